"""Boundary lines enclose the rock: what joints enclose outside of it makes no block, through the program."""
import random
import re

import pytest
import scree
from shapely.geometry import LineString, Point, Polygon
from shapely.ops import polygonize, unary_union

SQUARE = ["0 0 10 0 1", "10 0 10 10 1", "10 10 0 10 1", "0 10 0 0 1"]
TWO_BLOCKS_IN_THE_AIR = ["10 2 12 2 1", "12 2 12 4 1", "12 4 10 4 1",  # 2 x 2
                         "5 10 5 13 1", "5 13 8 13 1", "8 13 8 10 1"]  # 3 x 3
ROUNDING = 1e-12
ANALYSIS = "0\n1\n1 1\n0.05\n0.01\n1 0 1e6 0.2  0 0 0  0 0 0  0 0 0\n30 0 0\n"


def write_deck(folder, boundary, joints, holes=(), fixed=(), e0=0):
    lines = [*boundary, *joints]
    (folder / "m.geo").write_text("\n".join([f"{e0} {len(lines)} {len(boundary)} 0 0 {len(fixed)} 0 0 {len(holes)}", *lines, *fixed,
                                             *holes, ""]))


def cut(folder, *deck, **more):
    """The blocks of a map as polygons, and what the program warned of."""
    write_deck(folder, *deck, **more)
    done = scree.call("cut", "m.geo", cwd=folder)
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in (folder / "m.blk").read_text().splitlines()]
    n, _, vertices = map(int, rows[0])
    corners = [(float(x), float(y)) for _, x, y in (row if len(row) == 3 else [0, *row] for row in rows[2 + n:2 + n + vertices])]
    return [Polygon(corners[int(first) - 1:int(last)]) for _, first, last in rows[2:2 + n]], done.stderr


def test_blocks_outside_are_left_out_and_told_by_number_area_and_place(tmp_path):
    blocks, said = cut(tmp_path, SQUARE, [*TWO_BLOCKS_IN_THE_AIR, "0 5 10 5 1"])
    assert [block.area for block in blocks] == [50, 50]
    assert "left out 2 blocks outside of it, of area 13, the largest about (6.5, 11.5)" in said and said.count("\n") == 1


def test_without_boundary_lines_every_enclosed_region_is_a_block(tmp_path):
    blocks, said = cut(tmp_path, [], [*SQUARE, *TWO_BLOCKS_IN_THE_AIR])
    assert sorted(block.area for block in blocks) == [4, 9, 100] and said == ""


def test_boundary_lines_may_enclose_several_parts_and_hollows(tmp_path):
    """A square of 100 with a square of 4 inside, which stays a block, and one of 1 apart; joints lead from one to the other."""
    inner = ["4 4 6 4 1", "6 4 6 6 1", "6 6 4 6 1", "4 6 4 4 1"]
    apart = ["20 0 21 0 1", "21 0 21 1 1", "21 1 20 1 1", "20 1 20 0 1"]
    blocks, said = cut(tmp_path, [*SQUARE, *inner, *apart], ["10 0 20 0 1", "10 1 20 1 1"])
    assert sorted(round(block.area, 9) for block in blocks) == [1, 4, 96]
    assert "left out 1 block outside of it, of area 10, the largest about (15, 0.5)" in said


def test_a_boundary_that_does_not_close_is_told_with_its_ends_and_loses_no_block(tmp_path):
    gap = [*SQUARE[:3], "0 10 0 0.02 1"]
    joints = ["0 5 10 5 1", "4 5 4 10 1"]
    blocks, said = cut(tmp_path, gap, joints)
    assert sorted(block.area for block in blocks) == [20, 30]  # what the lines enclose
    assert "enclose none and meet no other line at (0, 0) (0, 0.02)" in said and said.count("\n") == 1


def test_a_boundary_around_a_tunnel_alone_encloses_no_rock(tmp_path):
    """The rock is what joints enclose around it, as in a deck without boundary lines."""
    tunnel = ["4 4 6 4 1", "6 4 6 6 1", "6 6 4 6 1", "4 6 4 4 1"]
    blocks, _ = cut(tmp_path, tunnel, SQUARE, holes=["5 5"])
    assert [block.area for block in blocks] == [96]


def test_a_hole_point_of_a_block_that_is_left_out_has_nothing_to_do(tmp_path):
    blocks, _ = cut(tmp_path, SQUARE, TWO_BLOCKS_IN_THE_AIR, holes=["11 3"])
    assert [block.area for block in blocks] == [100]
    write_deck(tmp_path, SQUARE, TWO_BLOCKS_IN_THE_AIR, holes=["-1 -1"])
    done = scree.call("cut", "m.geo", cwd=tmp_path)
    assert done.returncode == 2 and "expected a hole point inside a block, found one outside" in done.stderr


def test_joints_that_end_outside_open_nothing_and_small_blocks_join_those_inside(tmp_path):
    """A joint that ends in a block outside is no crack, one that ends inside is. A strip of 1 joins what lies below it."""
    joints = [*TWO_BLOCKS_IN_THE_AIR, "0 9.9 10 9.9 1", "10 3 11 3 1", "0 2 3 2 1"]
    write_deck(tmp_path, SQUARE, joints)
    assert scree.call("cut", "m.geo", cwd=tmp_path).stdout.startswith("2 blocks, 1 cracks, area  1.0000000000000000E+02")
    with (tmp_path / "m.geo").open("a") as deck:
        deck.write("&blocks least_area=5 /\n")  # above the 4 of a block outside
    done = scree.call("cut", "m.geo", cwd=tmp_path)
    assert done.stdout.startswith("1 blocks, 1 cracks, area  1.0000000000000000E+02") and "1 blocks smaller" in done.stdout
    assert "left out 2 blocks outside of it, of area 13" in done.stderr


def test_an_error_about_a_place_outside_says_what_was_left_out(tmp_path):
    write_deck(tmp_path, SQUARE, TWO_BLOCKS_IN_THE_AIR, fixed=["11 3 11 3"])
    done = scree.call("cut", "m.geo", cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert "left out 2 blocks outside of it, of area 13" in done.stderr


def test_check_and_run_warn_of_blocks_left_out(tmp_path):
    write_deck(tmp_path, SQUARE, TWO_BLOCKS_IN_THE_AIR, fixed=["5 5 5 5"])
    (tmp_path / "m.ana").write_text(ANALYSIS)
    for verb, stream in (("check", "stdout"), ("run", "stderr")):
        done = scree.call(verb, "m.geo", "m.ana", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        said = [line for line in getattr(done, stream).splitlines() if "left out 2 blocks outside of it, of area 13" in line]
        assert len(said) == 1 and "warning: " in said[0]
    assert scree.call("check", "--strict", "m.geo", "m.ana", cwd=tmp_path).returncode == 2


@pytest.mark.parametrize("seed", range(12))
def test_blocks_of_random_joints_are_the_parts_of_the_boundary(seed, tmp_path):
    """Joints reach far beyond a boundary with a notch: areas and number against shapely, and no block is outside."""
    rnd = random.Random(seed)
    corners = [(0, 0), (10, 0), (10, 7), (6, 7), (6, rnd.uniform(2, 6)), (4, rnd.uniform(2, 6)), (4, 9), (0, 9)]
    rock = Polygon(corners)
    joints = [[rnd.uniform(-4, 14) for _ in range(4)] for _ in range(40)]
    boundary = [[*a, *b] for a, b in zip(corners, corners[1:] + corners[:1])]
    blocks, said = cut(tmp_path, *([" ".join(map(repr, line)) + " 1" for line in lines] for lines in (boundary, joints)))
    traces = unary_union([LineString([line[:2], line[2:]]) for line in joints] + [rock.exterior])
    faces = list(polygonize(traces))
    expected = [face.area for face in faces if rock.contains(face.representative_point())]
    assert sorted(block.area for block in blocks) == pytest.approx(sorted(expected), abs=1e-10)  # crossings are rounded to 1e-14
    assert sum(block.area for block in blocks) == pytest.approx(rock.area, rel=ROUNDING)
    assert all(rock.distance(Point(block.representative_point())) == 0 for block in blocks)
    outside = len(faces) - len(expected)
    assert outside > 3 and int(re.search(r"left out (\d+) block", said)[1]) == outside
