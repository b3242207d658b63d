"""Rose diagrams: lengths of the joints between blocks by direction, without the boundary."""
import os
import pathlib
import subprocess

import numpy as np
import pytest
from scree import plot, rose
from scree.errors import PlotError
from scree.units import Units

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
# A rectangle of 4 by 3, cut by a level line, by a plumb one and by one that climbs 3 in 4.
LINES = [(0, 0, 4, 0, 1), (4, 0, 4, 3, 1), (4, 3, 0, 3, 1), (0, 3, 0, 0, 1), (0, 2, 4, 2, 1), (1, 0, 1, 3, 2), (0, 0, 4, 3, 3)]


@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
def test_lengths_are_those_of_the_joints_in_their_directions(edge, tmp_path):
    text = "".join(f"{a * edge!r} {b * edge!r} {c * edge!r} {d * edge!r} {k}\n" for a, b, c, d, k in LINES)
    (tmp_path / "x.geo").write_text(f"0.001 {len(LINES)} 4 0 0 0 0 0 0\n{text}")
    file = plot.open_shapes(tmp_path / "x.geo", SCREE, tmp_path)
    angle, length, material = rose.joint_directions(file)
    for k, direction, true in ((1, 0, 4), (2, 90, 3), (3, np.degrees(np.arctan2(3, 4)), 5)):
        assert length[material == k].sum() == pytest.approx(true * edge) and angle[material == k] == pytest.approx(direction, abs=1e-6)
    found = rose.sectors(angle, length)
    assert len(found) == 18 and found.sum() == pytest.approx(12 * edge)
    assert found[[0, 4, 9]] == pytest.approx([4 * edge, 5 * edge, 3 * edge])
    axis = rose.draw_rose(file, Units()).axes[0]
    heights = sum(np.array([bar.get_height() for bar in bars]) for bars in axis.containers)
    assert heights[:18] == pytest.approx(heights[18:]) and heights[:18].sum() == pytest.approx(100)


def test_directions_about_level_are_one_sector():
    assert rose.sectors(np.array([179.0, 1.0, 4.9, 175.1]), np.ones(4))[0] == 4
    assert list(np.flatnonzero(rose.sectors(np.array([174.9, 5.1]), np.ones(2)))) == [1, 17]


def test_the_command_draws_maps_and_results_and_says_where_there_are_no_joints(tmp_path):
    slope = SOURCE / "input" / "bench" / "slope" / "reg.geo"
    done = subprocess.run([SOURCE / "tools" / "plot", slope, "--rose", "--scree", SCREE, "-o", tmp_path / "r.png"], capture_output=True)
    assert done.returncode == 0 and (tmp_path / "r.png").stat().st_size > 5000
    (tmp_path / "one.geo").write_text("0.001 4 4 0 0 0 0 0 0\n0 0 1 0 1\n1 0 1 1 1\n1 1 0 1 1\n0 1 0 0 1\n")
    with pytest.raises(PlotError, match="joints between blocks for --rose, found none"):
        rose.draw_rose(plot.open_shapes(tmp_path / "one.geo", SCREE, tmp_path), Units())
