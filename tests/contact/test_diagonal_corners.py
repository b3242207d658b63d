"""Corners that touch diagonally, where four blocks could meet: those beside them keep them apart, until these leave."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

SIDE = 0.05


def deepest(folder, push, tilt=0.0, mirrored=False, size=1.0, groups=()):
    """How deep a block overlaps the one that is held, of which it touches a corner with its own, over its side. Both have a third
    beside them, which it takes with it as it is pushed."""
    a = np.radians(tilt)
    turned = size * np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) @ np.diag([-1 if mirrored else 1, 1])
    blocks = [(np.array(box(*corners)) @ turned)[::(-1 if mirrored else 1)]
              for corners in ((-SIDE, 0, -SIDE, 0), (0, SIDE, 0, SIDE), (-SIDE, 0, 0, SIDE))]
    held, pushed, _ = blocks
    force = 2500 * SIDE**2 * size**2 * np.array(push) @ turned / size
    (folder / "a.blk").write_text(block_file("diagonal", [(1, b) for b in blocks], [(*(0.9 * p + 0.1 * held.mean(0)), 1) for p in held],
                                             load=[(*pushed.mean(0), 2)]))
    (folder / "a.ana").write_text("\n".join([
        f"1 10 1 1 0.3 {5e-3 * np.sqrt(size)}", f"2500 0 {1e10 * size} 0.2 {'0 ' * 9}", "16 0 0",
        f"&loads force={float(force[0])} {float(force[1])} /", "&deck geometry='a.blk', dialect='short' /", *groups, ""]))
    r = scree.run(folder / "a.ana", output=folder / "a.h5")
    moved = r.polygons(-1)[1] - r.polygons(0)[1]
    assert np.abs(moved).max() > 1e-3 * SIDE * size
    return r.history.overlap.max() / (SIDE * size)


@pytest.mark.parametrize("groups", [[], ["&method strain='green' /"], ["&contact method='augmented' /"], ["&contact restitution=0 /"]], ids=str)
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("push", [(-16, -16), (-16, -8), (-16, -20), (-100, -100), (-5, -5)])
def test_they_do_not_pass_through_each_other(push, mirrored, groups, tmp_path):
    """Their contact was left out while a third block lay flush with both, as that bears: from rest they went 7e-4 to 1.5e-2 of a side
    into each other in the step in which it left, and rested there."""
    assert deepest(tmp_path, push, mirrored=mirrored, groups=groups) < 1.1e-4


@pytest.mark.parametrize("tilt", [17.0, 90.0, 200.0])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_turned_and_of_any_size(size, tilt, tmp_path):
    assert deepest(tmp_path, (-16, -16), tilt, size=size) < 1.1e-4
