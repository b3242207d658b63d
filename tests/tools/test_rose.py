"""Rose diagrams: lengths of the joints between blocks by direction, without the boundary."""
import os
import pathlib
import subprocess

import numpy as np
import pytest
from scree import block_files, drawing, rose, tables, touching
from scree.errors import PlotError
from scree.units import Units
from shapely.ops import unary_union

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
# A rectangle of 4 by 3, cut by a level line, by a plumb one and by one that climbs 3 in 4.
LINES = [(0, 0, 4, 0, 1), (4, 0, 4, 3, 1), (4, 3, 0, 3, 1), (0, 3, 0, 0, 1), (0, 2, 4, 2, 1), (1, 0, 1, 3, 2), (0, 0, 4, 3, 3)]


@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
def test_lengths_are_those_of_the_joints_in_their_directions(edge, tmp_path):
    text = "".join(f"{a * edge} {b * edge} {c * edge} {d * edge} {k}\n" for a, b, c, d, k in LINES)
    (tmp_path / "x.geo").write_text(f"0.001 {len(LINES)} 4 0 0 0 0 0 0\n{text}")
    file = drawing.open_shapes(tmp_path / "x.geo", SCREE, tmp_path)
    angle, length, material = rose.joint_directions(file)
    for k, direction, true in ((1, 0, 4), (2, 90, 3), (3, np.degrees(np.arctan2(3, 4)), 5)):
        assert length[material == k].sum() == pytest.approx(true * edge) and angle[material == k] == pytest.approx(direction, abs=1e-6)
    found = rose.sectors(angle, length)
    assert len(found) == 18 and found.sum() == pytest.approx(12 * edge)
    assert found[[0, 4, 9]] == pytest.approx([4 * edge, 5 * edge, 3 * edge])
    axis = rose.draw_rose(file, Units()).axes[0]
    heights = sum(np.array([bar.get_height() for bar in bars]) for bars in axis.containers)
    assert heights[:18] == pytest.approx(heights[18:]) and heights[:18].sum() == pytest.approx(100)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_of_edges_that_lie_in_part_against_others_these_parts_count(size, tmp_path):
    """A wall of 5 courses of running bond on a longer base: below each course 5 of joint, between the blocks of one 4 or 5; and a block
    beside it on the base, 1e-2 away, which has a joint with that alone."""
    base, *blocks = block_files.running_bond(5)
    blocks = [base, *blocks, block_files.box(5.01, 7, 0, 1)]
    base[1:3, 0] = 6
    (tmp_path / "wall.blk").write_text(block_files.on_base("Wall", [size * block for block in blocks]))
    angle, length, _ = rose.joint_directions(drawing.open_shapes(tmp_path / "wall.blk", SCREE, tmp_path))
    assert length[angle == 0].sum() == pytest.approx((25 + 0.99) * size) and length[angle == 90].sum() == pytest.approx(22 * size)
    assert length.sum() == pytest.approx(47.99 * size)


@pytest.mark.parametrize("kind", ["dda", "nmm"])
def test_joints_of_rock_cut_at_random_are_half_of_all_edges_but_those_of_its_outline(kind, tmp_path):
    file = drawing.open_shapes(touching.jointed_rock(tmp_path, kind, 3, 1), SCREE, tmp_path)
    edges = file.edges(0)[0]
    every = np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1).sum()
    outline = unary_union([tables.shape_of(polygon).buffer(1e-6, join_style=2) for polygon in file.start]).length
    assert rose.joint_directions(file)[1].sum() == pytest.approx((every - outline) / 2, rel=1e-4)


def test_directions_about_level_are_one_sector():
    assert rose.sectors(np.array([179.0, 1.0, 4.9, 175.1]), np.ones(4))[0] == 4
    assert list(np.flatnonzero(rose.sectors(np.array([174.9, 5.1]), np.ones(2)))) == [1, 17]


def test_the_command_draws_maps_and_results_and_says_where_there_are_no_joints(tmp_path):
    slope = SOURCE / "input" / "bench" / "slope" / "reg.geo"
    done = subprocess.run([SOURCE / "tools" / "plot", slope, "--rose", "--scree", SCREE, "-o", tmp_path / "r.png"], capture_output=True)
    assert done.returncode == 0 and (tmp_path / "r.png").stat().st_size > 5000
    (tmp_path / "one.geo").write_text("0.001 4 4 0 0 0 0 0 0\n0 0 1 0 1\n1 0 1 1 1\n1 1 0 1 1\n0 1 0 0 1\n")
    with pytest.raises(PlotError, match="joints between blocks for --rose, or cracks that grew, found none"):
        rose.draw_rose(drawing.open_shapes(tmp_path / "one.geo", SCREE, tmp_path), Units())
