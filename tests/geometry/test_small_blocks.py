"""Blocks below &blocks least_area join the neighbour of their longest edge, through the program."""
import random
import re

import numpy as np
import pytest
import scree
from shapely.geometry import Polygon

SQUARE = ["0 0 10 0 1", "10 0 10 10 1", "10 10 0 10 1", "0 10 0 0 1"]


def cut(folder, joints, least=None, boundary=SQUARE, holes=()):
    """The blocks of a map: their number, polygons, and what the program said."""
    groups = "" if least is None else f"&blocks least_area={least} /\n"
    lines = [*boundary, *joints]
    (folder / "m.geo").write_text("\n".join([f"1e-6 {len(lines)} {len(boundary)} 0 0 0 0 0 {len(holes)}", *lines, *holes, groups]))
    done = scree.call("cut", "m.geo", cwd=folder)
    assert done.returncode == 0, done.stderr
    said = re.search(r"(\d+) blocks smaller than (\S+) joined", done.stdout)
    rows = [line.split() for line in (folder / "m.blk").read_text().splitlines() if "&" not in line]
    n, _, vertices = map(int, rows[0])
    ranges = [[int(word) for word in row] for row in rows[2:2 + n]]
    corners = [(float(x), float(y)) for _, x, y in (row if len(row) == 3 else [0, *row] for row in rows[2 + n:2 + n + vertices])]
    return [Polygon(corners[first - 1:last]) for _, first, last in ranges], int(said[1]) if said else 0


def test_a_sliver_joins_the_neighbour_of_its_longest_edge(tmp_path):
    """A triangle of area 0.005 at the corner of four blocks: its hypotenuse is the longest of its three edges."""
    joints = ["0 5 10 5 2", "5 0 5 10 2", "5 4.9 5.1 5 3"]
    before, _ = cut(tmp_path, joints)
    after, joined = cut(tmp_path, joints, 0.01)
    assert len(before) == 5 and len(after) == 4 and joined == 1
    assert sorted(round(block.area, 12) for block in after) == [25] * 4
    assert all(len(block.exterior.coords) == 5 for block in after)  # the corners of the sliver are gone


def test_blocks_of_that_area_and_above_stay_to_the_bit(tmp_path):
    joints = ["0 5 10 5 2", "5 0 5 10 2", "5 4.9 5.1 5 3"]
    cut(tmp_path, joints)
    plain = (tmp_path / "m.blk").read_text()
    _, joined = cut(tmp_path, joints, 0.004)
    assert joined == 0 and (tmp_path / "m.blk").read_text() == plain


def test_slivers_that_lie_on_each_other_join_until_they_are_large_enough(tmp_path):
    """Ten strips of 0.1 x 10 above a block of 90: the smallest first, each with the strip beside it or what that has become."""
    joints = [f"0 {9 + k / 10} 10 {9 + k / 10} 2" for k in range(10)]
    after, joined = cut(tmp_path, joints, 2.5)
    assert len(after) == 11 - joined and joined > 5
    assert min(block.area for block in after) >= 2.5 and sum(block.area for block in after) == pytest.approx(100, rel=1e-14)


def test_boundary_lines_part_for_ever(tmp_path):
    """A strip behind a boundary line has no neighbour, however small."""
    boundary = [*SQUARE, "0 9.9 10 9.9 1"]
    after, joined = cut(tmp_path, ["5 0 5 10 2"], 2.0, boundary)
    assert sorted(round(block.area, 9) for block in after) == [1, 49.5, 49.5] and joined == 1  # the halves of the strip are one


def test_a_hole_of_joint_lines_stays_a_hole(tmp_path):
    """Joined to the rock around it, its point would take all rock away."""
    hole = ["4 4 5 4 2", "5 4 5 5 2", "5 5 4 5 2", "4 5 4 4 2"]
    after, joined = cut(tmp_path, hole, 2.0, holes=["4.5 4.5"])
    assert joined == 0 and len(after) == 1 and after[0].area == pytest.approx(99, rel=1e-14)
    after, joined = cut(tmp_path, hole, 2.0)
    assert joined == 1 and len(after) == 1 and after[0].area == pytest.approx(100, rel=1e-14)


@pytest.mark.parametrize("seed", range(6))
def test_in_random_maps_no_small_block_is_left_and_no_area_is_lost(seed, tmp_path):
    draw = random.Random(seed)
    joints = [" ".join(f"{draw.uniform(0, 10):.6f}" for _ in range(4)) + " 2" for _ in range(40)]
    before, _ = cut(tmp_path, joints)
    least = sorted(block.area for block in before)[len(before) // 2]
    after, joined = cut(tmp_path, joints, least)
    assert joined == len(before) - len(after) >= len(before) // 4
    assert min(block.area for block in after) >= least
    assert sum(block.area for block in after) == pytest.approx(sum(block.area for block in before), rel=1e-12)
    for block in after:  # each is made of whole blocks of before
        parts = [old for old in before if block.buffer(1e-9).contains(old)]
        assert sum(old.area for old in parts) == pytest.approx(block.area, rel=1e-9)


def test_an_area_that_is_none_is_refused(tmp_path):
    (tmp_path / "m.geo").write_text("\n".join(["1e-6 4 4 0 0 0 0 0 0", *SQUARE, "&blocks least_area=-1 /\n"]))
    done = scree.call("cut", "m.geo", cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.startswith("scree: m.geo:6: expected") and "at least 0" in done.stderr


def test_a_boundary_line_between_blocks_that_join_a_third_stays(tmp_path):
    """Two blocks of 25 join the one above; what parted them is a line inside that, which a mesh opens. The block file is without it,
    and the program says so."""
    groups = "&blocks least_area=30 /"
    (tmp_path / "m.geo").write_text("\n".join(["1e-6 6 5 0 0 0 0 0 0", *SQUARE, "5 0 5 5 1", "0 5 10 5 2", groups, ""]))
    done = scree.call("cut", "m.geo", cwd=tmp_path)
    assert done.returncode == 0 and "1 blocks, 1 cracks" in done.stdout
    assert done.stderr == "scree: warning: m.blk is without the 1 pieces of joints that end inside blocks, which a mesh would open\n"


def test_a_fixed_line_along_the_bottom_of_columns_holds_both_ends_of_each(tmp_path):
    """Three columns that are pushed aside stand. One corner of each was held, and they turned about it."""
    fixed = "-1 0 10 0"
    (tmp_path / "m.geo").write_text("\n".join(["1e-6 6 4 0 0 1 0 0 0", "0 0 9 0 1", "9 0 9 4 1", "9 4 0 4 1", "0 4 0 0 1", "3 0 3 4 1", "6 0 6 4 1",
                                               fixed, ""]))
    (tmp_path / "m.ana").write_text("1 100 1 1 .05 .01 1000 0 1e8 .25 0 0 0 0 0 0 0 0 0 30 0 0\n&deck geometry='m.geo', dialect='short' /\n"
                                    "&boundary lines=0 4 9 4, traction=2e4 0 2e4 0 /\n")
    r = scree.run(tmp_path / "m.ana", output=tmp_path / "m.h5")
    assert np.abs(r.bodies.centroid[-1] - r.bodies.centroid[0]).max() < 0.01
