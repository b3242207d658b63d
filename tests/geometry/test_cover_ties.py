"""Covers without an element large enough follow one that is as near as others: the same in the mirror."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file

CORNERS = np.array([(0, 0), (2, 0), (2, 0.7), (0, 0.7)], float)


def displaced(folder, name, mirror, edge, angle, origin, strain):
    """Displacement of a measured point of a loaded block that is held at two points."""
    side = np.array([-1 if mirror else 1, 1])
    outline = (CORNERS * side)[::side[0]]
    points = np.array([(0.2, 0.15), (1.7, 0.2), (1.1, 0.5), (0.7, 0.6)]) * side
    (folder / f"{name}.blk").write_text(block_file("covers", [(1, outline)], [(*p, 1) for p in points[:2]], measured=[(*p, 1) for p in points[2:]]))
    o = np.array(origin) * side
    (folder / f"{name}.ana").write_text("\n".join([
        "1 20 1 1 0.05 0.001", "2500 25000 1e8 0.25" + " 0" * 9, "0 0 0", f"&deck geometry='{name}.blk', dialect='short' /",
        f"&method model='nmm', strain='{strain}' /", f"&cover edge={edge}, origin={o[0]} {o[1]}, angle={side[0] * angle}, least=0.3 /", ""]))
    return scree.run(folder / f"{name}.ana", output=folder / f"{name}.h5").measured_points.displacement[-1] * side


@pytest.mark.parametrize("strain", ["small", "green"])
@pytest.mark.parametrize("edge, angle, origin", [(0.8, 33.4, (0.28, -0.63)), (0.76, 32.4, (0.72, -0.54)), (0.33, 42.2, (0.97, 0.19))])
def test_the_mirror_image_moves_as_the_block(edge, angle, origin, strain, tmp_path):
    """Of faces as near, by steps from element to element, the first in the order of the lines led: 2 to 29 % of the displacement."""
    one = displaced(tmp_path, "one", False, edge, angle, origin, strain)
    other = displaced(tmp_path, "other", True, edge, angle, origin, strain)
    assert other == pytest.approx(one, abs=1e-9 * np.abs(one).max())
