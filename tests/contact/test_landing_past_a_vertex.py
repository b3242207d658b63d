"""A corner that lands on a face past a vertex within it is met by the edge there, whichever of the two held it."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

SIDE = 0.05


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("at, tilt, aside, phi", [(0.55, 3.4, 275, 39), (0.55, 5.0, 275, 39), (0.6, 5.0, 275, 39), (0.8, 3.4, 275, 10),
                                                  (0.8, 5.0, 275, 10)])
def test_with_multipliers(at, tilt, aside, phi, mirrored, tmp_path):
    """Multipliers leave it behind the face by 1e-9 of an edge, with no area: it was taken for one that had not entered by the second edge,
    and went in by 2e-3 to 3e-2 of a side."""
    a = np.radians(tilt)
    turned = np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]])
    held = np.insert(box(0, 1.2 * SIDE, 2e-3, SIDE + 2e-3), 1, [at * 1.2 * SIDE, 2e-3], 0)
    pushed = box(0, 0.84 * SIDE, -SIDE, 0) @ turned.T
    pushed[:, 1] -= max(0, pushed[:, 1].max() - 1.2e-3)
    fixed = 0.9 * held + 0.1 * held.mean(0)
    load = pushed.mean(0)
    force = 2500 * 0.84 * SIDE**2 * np.array([aside, 500])
    if mirrored:
        side = np.array([-1, 1])
        held, pushed, fixed, load, force = (held * side)[::-1], (pushed * side)[::-1], fixed * side, load * side, force * side
    (tmp_path / "a.blk").write_text(block_file("past", [(1, held), (1, pushed)], [(*p, 1) for p in fixed], load=[(*load, 2)]))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 10 1 1 0.3 5e-3", f"2500 0 1e9 0.2 {'0 ' * 9}", f"{phi} 0 0", f"&loads force={float(force[0])} {float(force[1])} /",
        "&deck geometry='a.blk', dialect='short' /", "&contact method='augmented' /", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert r.history.contacts[:, 1:].max() > 0
    assert r.history.overlap.max() < 1e-4 * SIDE
