"""A corner that stands on a vertex, within a face that is nearly straight there, slides off it on the face."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("tilt", [1.5, 2.5, 2.9, 4.0])
@pytest.mark.parametrize("height", [0, 3.6e-5, 1e-3])
def test_it_does_not_sink(height, tilt, mirrored, tmp_path):
    """Its lower edge rises by less than 3 degrees behind it. The vertex below was taken to be under that edge, as often as the corner to be on
    the face: the corner sank by its way times the sine of the tilt, and its mirror image did not. (Where the block turns by as much in a step
    as it is tilted, either may be.)"""
    slab = np.insert(box(-1, 1, -1, 0), 3, [0.5, height], 0)
    a = np.radians(tilt)
    block = box(0, 0.6, 0, 0.4) @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) + [0.5, height]
    velocity, load, force = np.array([-1.2, 0]), block.mean(0), 2500 * 0.24 * np.array([0, -100.0])
    if mirrored:
        side = np.array([-1, 1])
        slab, block, velocity, load = (slab * side)[::-1], (block * side)[::-1], velocity * side, load * side
    fixed = 0.9 * slab + 0.1 * slab.mean(0)
    (tmp_path / "a.blk").write_text(block_file("off", [(1, slab), (2, block)], [(*p, 1) for p in fixed], load=[(*load, 2)]))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 10 2 1 0.3 5e-3", f"2500 0 1e9 0.2 {'0 ' * 9}", f"2500 0 1e9 0.2 {'0 ' * 6}{velocity[0]} 0 0", "30 0 0",
        f"&loads force={float(force[0])} {float(force[1])} /", "&deck geometry='a.blk', dialect='short' /",
        "&contact method='augmented' /", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert r.history.contacts[:, 1:].sum(axis=1).min() > 0
    assert r.history.overlap.max() < 1e-6
