"""Corners that lie opposite each other across a gap, each a little past the end of the other's edge, meet as they come together."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

SIDE, GAP = 0.05, 2e-3


def deepest(folder, tilt, aside, mirrored, groups, size=1.0):
    """How deep a block that is pushed up within a step overlaps the one above it, which is held, over its side. Its corner is beside
    the other's by `aside` of the gap, and it is turned by `tilt`."""
    a = np.radians(tilt)
    turned = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    held = box(0, SIDE, GAP, SIDE + GAP)
    pushed = box(0, SIDE, -SIDE, 0) @ turned.T + [-aside * GAP, 0]
    load = pushed.mean(0)
    side = np.array([-1 if mirrored else 1, 1]) * size
    blocks = [(x * side)[::(-1 if mirrored else 1)] for x in (held, pushed)]
    fixed = [(*(p * side), 1) for p in ([0.01, GAP + 0.01], [SIDE - 0.01, GAP + 0.01])]
    (folder / "a.blk").write_text(block_file("opposite", [(1, b) for b in blocks], fixed, load=[(*(load * side), 2)]))
    force = 400 * 2500 * (SIDE * size)**2
    (folder / "a.ana").write_text("\n".join([
        f"1 8 1 1 0.3 {5e-3 * np.sqrt(size)}", f"2500 0 {1e9 * size} 0.2 {'0 ' * 9}", "20 0 0", f"&loads force=0 {force} /",
        "&deck geometry='a.blk', dialect='short' /", *groups, ""]))
    r = scree.run(folder / "a.ana", output=folder / "a.h5")
    assert r.history.contacts[-1, 1:].sum() > 0
    return r.history.overlap.max() / (SIDE * size)


@pytest.mark.parametrize("groups", [[], ["&method strain='green' /"], ["&contact method='augmented' /"], ["&contact restitution=0 /"]], ids=str)
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("tilt, aside", [(-1.5, 0.0125), (-1.5, 0.002), (-2.5, 0.03), (-0.5, 0.004), (1.5, 0.0125), (0.5, -0.004)])
def test_they_do_not_pass_through_each_other(tilt, aside, mirrored, groups, tmp_path):
    """Neither corner was over the other's edge as the step began, and none of the two had a contact: columns that collapse overlapped by
    up to an eighth of their blocks."""
    assert deepest(tmp_path, tilt, aside, mirrored, groups) < 1e-4


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_of_any_size(size, tmp_path):
    assert deepest(tmp_path, -1.5, 0.0125, False, [], size) < 1e-4
