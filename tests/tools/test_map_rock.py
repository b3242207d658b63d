"""What tools/map clips, cuts out, and takes of bolts and water, through the program."""
import math

import numpy as np
import pytest
import scree
from scree.maps.rock import holds
from test_dxf2geo import convert, deck_of, drawing, on, one_line, read_deck

MATERIAL = "1 10 1e6 0.2  0 0 0  0 0 0  0 0 0\n"


def square(space, low, high, layer="BOUNDARY"):
    space.add_lwpolyline([(low, low), (high, low), (high, high), (low, high)], close=True, **on(layer))


def areas(folder):
    """Areas of the blocks that the deck makes."""
    done = scree.call("cut", "map.geo", cwd=folder)
    assert done.returncode == 0, done.stderr
    return sorted(float(line.split()[4]) for line in done.stdout.splitlines()[2:])


def test_a_window_takes_what_lies_in_it_and_its_sides_bound_the_rock(tmp_path):
    """Joints of a slope of -1 at one corner, cut at 0.1 and 0.3; the one inside keeps its coordinates to the bit."""
    document, space = drawing()
    square(space, -10, 10)
    inside = (1 / 3, 0.7, 0.9, 1.1)
    space.add_line(inside[:2], inside[2:], **on("JOINT_1"))
    space.add_line((-5, 0.1), (5, 0.1), **on("JOINT_1"))
    space.add_line((3, 3), (4, 5), **on("JOINT_1"))
    for x in (0.5, 7.0):
        space.add_point((x, 0.5), **on("MEASURED"))
    done = convert(document, tmp_path, "--clip", 0, 0, 2, 2)
    deck = read_deck(tmp_path / "map.geo")
    assert deck.boundary == 4 and {line[:4] for line in deck.lines[:4]} == {(0, 0, 2, 0), (2, 0, 2, 2), (2, 2, 0, 2), (0, 2, 0, 0)}
    assert {line[4] for line in deck.lines[:4]} == {3}  # BOUNDARY has the free number 2
    whole, cut = sorted(deck.lines[4:], key=lambda line: line != (*inside, 1))
    assert whole == (*inside, 1) and cut == pytest.approx((0, 0.1, 2, 0.1, 1), abs=1e-15) and deck.measured == [(0.5, 0.5)]
    assert "clip: boundary, joint material 3, 4 lines" in done.stdout
    assert "left out, where no rock is left: 6 lines and points" in done.stdout  # 4 sides, a joint, a point
    assert areas(tmp_path) == pytest.approx([0.2, 3.8], rel=1e-13)


def test_a_polygon_clips_either_way_round(tmp_path):
    document, space = drawing()
    square(space, -10, 10)
    space.add_line((-10, 1), (10, 1), **on("JOINT_1"))
    for corners in ([0, 0, 4, 0, 0, 4], [0, 4, 4, 0, 0, 0]):
        convert(document, tmp_path, "--clip", *corners)
        assert areas(tmp_path) == pytest.approx([3.5, 4.5], rel=1e-12)


def test_the_sides_of_a_clip_in_the_air_are_no_lines(tmp_path):
    """A slope from (-10, 0) over (0, 0) to (4, 4): the window from -2 to 4 has 12 of rock below 0 and a triangle of 8."""
    document, space = drawing()
    space.add_lwpolyline([(-10, -10), (10, -10), (10, 4), (4, 4), (0, 0), (-10, 0)], close=True, **on("BOUNDARY"))
    convert(document, tmp_path, "--clip", -2, -2, 4, 8)
    assert areas(tmp_path) == pytest.approx([12 + 8], rel=1e-12)


def test_what_a_hole_point_takes_out_of_the_drawing_is_no_rock(tmp_path):
    document, space = drawing()
    square(space, 0, 10)
    square(space, 4, 6)
    space.add_point((5, 5), **on("HOLE"))
    convert(document, tmp_path, "--clip", 0, 0, 5, 10)  # through the hole, its point on the side of the clip
    assert areas(tmp_path) == pytest.approx([50 - 2], rel=1e-12)


def test_boundary_lines_that_enclose_nothing_are_said(tmp_path):
    document, space = drawing()
    space.add_line((-10, 1), (10, 1), **on("BOUNDARY"))
    done = convert(document, tmp_path, "--clip", 0, 0, 2, 2)
    assert "boundary lines enclose nothing: all that is clipped is rock" in done.stdout
    assert areas(tmp_path) == pytest.approx([2, 2], rel=1e-12)


def test_a_round_tunnel_is_a_hole_and_the_joints_end_at_it(tmp_path):
    document, space = drawing()
    square(space, 0, 10)
    space.add_circle((5, 5), 2, **on("TUNNEL_4"))
    space.add_line((0, 5), (10, 5), **on("JOINT_1"))
    space.add_line((4, 4.5), (6, 4.5), **on("JOINT_1"))  # inside the tunnel
    done = convert(document, tmp_path)
    deck = read_deck(tmp_path / "map.geo")
    n = sum(line[4] == 4 for line in deck.lines)
    left = 100 - n / 2 * 4 * math.sin(math.tau / n)
    assert "tunnels that rock closes in: 1 hole point" in done.stdout and len(deck.holes) == 1
    assert [line[:4] for line in deck.lines if line[4] == 1] == [(0, 5, 3, 5), (7, 5, 10, 5)]
    assert areas(tmp_path) == pytest.approx([left / 2] * 2, rel=1e-12)


def test_excavations_that_reach_the_surface_overlap_or_leave_the_clip_need_no_hole_point(tmp_path):
    document, space = drawing()
    square(space, 0, 10)
    space.add_lwpolyline([(2, 7), (4, 7), (4, 12), (2, 12)], close=True, **on("EXCAVATION"))   # 2 x 3 of it in rock
    space.add_lwpolyline([(3, 6), (5, 6), (5, 8), (3, 8)], close=True, **on("TUNNEL"))         # 4 less the 1 of both
    space.add_lwpolyline([(8, 1), (9, 1), (9, 2), (8, 2)], close=True, **on("TUNNEL"))         # a hole of 1
    done = convert(document, tmp_path)
    assert "tunnels that rock closes in: 1 hole point" in done.stdout
    assert areas(tmp_path) == pytest.approx([100 - 6 - 3 - 1], rel=1e-12)
    convert(document, tmp_path, "--clip", 0, 0, 8.5, 10)  # through the hole
    assert len(read_deck(tmp_path / "map.geo").holes) == 0 and areas(tmp_path) == pytest.approx([85 - 6 - 3 - 0.5], rel=1e-12)


def test_an_outline_may_be_of_several_entities(tmp_path):
    document, space = drawing()
    square(space, 0, 10)
    for a, b in (((2, 2), (4, 2)), ((4, 4), (4, 2)), ((2, 4), (4, 4)), ((2, 2), (2, 4))):
        space.add_line(a, b, **on("TUNNEL"))
    deck_of(document, tmp_path)
    assert areas(tmp_path) == pytest.approx([96], rel=1e-13)


@pytest.mark.parametrize("seed", range(8))
def test_random_joints_keep_the_area_of_the_rock(seed, tmp_path):
    """A window and tunnels at random, in mm, m and km and far from the origin, against the area that their rock has by shapely."""
    from shapely.geometry import Polygon, box
    draw = np.random.default_rng(seed)
    document, space = drawing()
    unit, far = 10.0**(3 * (seed % 3) - 3), 1e4 * (seed % 2)

    def placed(x):
        return (np.asarray(x) * unit + far * unit).tolist()

    square(space, *placed([-10, 10]))
    rock = box(-10, -10, 10, 10)
    for k in range(3):
        angles = np.sort(draw.uniform(0, math.tau, 5))
        corners = draw.uniform(-6, 6, 2) + draw.uniform(0.5, 3) * np.column_stack([np.cos(angles), np.sin(angles)])
        space.add_lwpolyline(placed(corners), close=True, **on(f"TUNNEL_{k + 2}"))
        rock = rock.difference(Polygon(corners))
    for _ in range(30):
        a, b = placed(draw.uniform(-11, 11, (2, 2)))
        space.add_line(a, b, **on("JOINT_1"))
    clip = draw.uniform(-9, -4, 2).tolist() + draw.uniform(4, 9, 2).tolist()
    convert(document, tmp_path, "--e0", 0, "--clip", *placed(clip))
    expected = rock.intersection(box(*clip))
    assert sum(areas(tmp_path)) == pytest.approx(expected.area * unit**2, rel=1e-9)


def test_bolts_and_water_come_by_layer(tmp_path):
    """A bolt along the height under its pretension; the table is in the order of x, whatever way its lines are drawn."""
    document, space = drawing()
    square(space, 0, 4)
    space.add_line((0, 2), (4, 2), **on("JOINT_1"))
    space.add_line((1, 1), (1, 3), **on("BOLTS"))
    space.add_line((3, 1), (3, 3), **on("Anchors"))
    space.add_lwpolyline([(5, 3), (2, 2.5)], **on("WATER"))
    space.add_line((-1, 2), (2, 2.5), **on("WATER"))
    done = convert(document, tmp_path, "--layer", "BOLTS=bolt:1e5", "--layer", "anchors=bolt:2e5:900:50", "--least-area", 0.01)
    assert done.returncode == 0 and "layer 'Anchors': bolts of stiffness, strength, pretension 200000.0 900.0 50.0, 1 line" in done.stdout
    text = (tmp_path / "map.geo").read_text()
    assert "\n3.0 1.0 3.0 3.0 200000.0 900.0 50.0\n1.0 1.0 1.0 3.0 100000.0 0.0 0.0\n" in text
    assert text.endswith("&blocks least_area=0.01 /\n&water table=-1.0 2.0  2.0 2.5  5.0 3.0 /\n")
    (tmp_path / "map.ana").write_text("1\n1\n1 2\n0.05\n0.001\n" + MATERIAL + "30 0 0 30 0 0\n&water unit_weight=10 /\n")
    said = scree.call("check", "map.geo", "map.ana", cwd=tmp_path).stdout
    assert "effect: bolts" in said and "water" in said
    results = scree.run(tmp_path / "map.geo", tmp_path / "map.ana")
    np.testing.assert_allclose(results.bolts.force[0], [50, 0], rtol=1e-10)


def test_a_clip_takes_whole_bolts_alone(tmp_path):
    document, space = drawing()
    square(space, 0, 4)
    space.add_line((1, 1), (1, 1.5), **on("BOLT"))
    space.add_line((1, 1), (1, 3), **on("BOLT"))
    convert(document, tmp_path, "--clip", 0, 0, 4, 2, "--layer", "BOLT=bolt:1")
    rows = [line.split("!") for line in (tmp_path / "map.geo").read_text().splitlines() if line.endswith("! bolts")]
    assert [int(number) for number, _ in rows] == [1]


def test_what_cannot_be_is_one_line(tmp_path):
    def done(add, *words):
        document, space = drawing()
        square(space, 0, 4)
        add(space)
        return convert(document, tmp_path, *words)

    def bolt(space):
        space.add_line((1, 1), (2, 2), **on("BOLT"))

    one_line(done(lambda s: s.add_line((1, 1), (2, 2), **on("TUNNEL"))), "closed outlines of tunnels", "(1, 1) (2, 2)")
    one_line(done(bolt), "the stiffness of bolts", "'BOLT=bolt:STIFFNESS[:STRENGTH[:PRETENSION]]'")
    for role in ("bolt:", "bolt:0", "bolt:1:-1", "bolt:nan", "bolt:1:2:3:4", "bolt:1:inf", "water:2", "tunnel"):
        one_line(done(bolt, "--layer", f"BOLT={role}"), "NAME=ROLE")
    one_line(done(lambda s: s.add_lwpolyline([(0, 1), (2, 2), (1, 3)], **on("WATER"))), "one level at each x")
    one_line(done(lambda s: s.add_line((1, 1), (1, 2), **on("WATER"))), "one level at each x")
    for clip in ([1], [1, 2, 3], [1, 2], [0, 0, 0, 1], [0, 0, 1, 1, 1, 0, 0, 1], ["nan", 0, 1, 1], [0, 0, "inf", 1]):
        one_line(done(lambda s: None, "--clip", *clip), "--clip: expected")
    one_line(done(lambda s: None, "--clip", 10, 10, 12, 12), "joint or boundary lines in the clip")
    one_line(done(lambda s: None, "--least-area", "-1"), "--least-area")
    said = done(lambda s: s.add_lwpolyline([(1, 1), (2, 2), (3, 1)], **on("BOLT")), "--layer", "BOLT=bolt:1")
    assert said.returncode == 0 and "1 LWPOLYLINE (this layer is for straight lines)" in said.stderr


def test_a_ray_tells_what_an_outline_holds():
    corners = np.array([(0, 0), (4, 0), (4, 4), (2, 1), (0, 4)], float)
    sides = np.hstack([corners, np.roll(corners, -1, axis=0)])
    assert holds(sides, np.array([[2, 0.5], [2, 2], [0.5, 2], [3.5, 2], [-1, 0], [5, 4]])).tolist() == [True, False, True, True, False, False]


def test_what_a_stage_removes_is_drawn(tmp_path):
    """Rock of 10 x 10 with a joint across; stage 2 takes a square of 2, stage 4 a corner: areas that are left."""
    document, space = drawing()
    square(space, 0, 10)
    space.add_line((0, 5), (10, 5), **on("JOINT_1"))
    square(space, 4, 6, "STAGE_2")
    space.add_lwpolyline([(0, 0), (1, 0), (0, 1)], close=True, **on("corner"))
    done = convert(document, tmp_path, "--layer", "corner=stage:4")
    assert "layer 'STAGE_2': removed by stage 2, 4 lines" in done.stdout and "map.stages\n" in done.stdout
    deck = read_deck(tmp_path / "map.geo")
    joint, = {line[4] for line in deck.lines[deck.boundary:]} - {1}
    assert f"sides of what stages remove: joint material {joint}, whose cohesion" in done.stdout
    groups = (tmp_path / "map.stages").read_text()
    assert groups.splitlines()[1] == "&stage /"  # what is not drawn changes nothing
    (tmp_path / "map.ana").write_text("1 1 1 3 0.05 0.01\n" + MATERIAL + "30 1e9 1e9\n" * 3 + "&deck geometry='map.geo' /\n" + groups)
    results = scree.run(tmp_path / "map.ana", output=tmp_path / "map.h5")
    ends = [int(np.flatnonzero(results.frame_stages == k)[-1]) for k in (1, 2, 3, 4)]
    left = [results.bodies.area[k][results.bodies.present[k] > 0].sum() for k in ends]
    assert left == pytest.approx([100, 96, 96, 95.5], rel=1e-9)


@pytest.mark.parametrize("layer, corners, expected", [
    ("STAGE_2", [(4, 4), (6, 4)], "closed outlines of what stages remove"), ("STAGE", [(4, 4), (6, 4), (5, 6), (4, 4)], "a stage from 2"),
    ("STAGE_1", [(4, 4), (6, 4), (5, 6), (4, 4)], "a stage from 2")])
def test_an_outline_of_a_stage_that_is_open_or_has_no_number_is_refused(layer, corners, expected, tmp_path):
    document, space = drawing()
    square(space, 0, 10)
    space.add_lwpolyline(corners, **on(layer))
    one_line(convert(document, tmp_path), expected)


def test_joints_beyond_the_boundary_make_no_block_with_a_clip_or_without(tmp_path):
    """Joints from the side of a square of 100 enclose 2 x 3 outside of it. The clip holds all of the drawing."""
    document, space = drawing()
    square(space, 0, 10)
    space.add_lwpolyline([(10, 5), (12, 5), (12, 8), (10, 8)], **on("JOINT_1"))
    space.add_line((5, 0), (5, 10), **on("JOINT_1"))
    for words in ((), ("--clip", -1, -1, 20, 20)):
        convert(document, tmp_path, *words)
        assert areas(tmp_path) == [50, 50], words


def open_square(space, gap, layer="BOUNDARY"):
    """A square of 100 whose last side ends a gap above its first corner."""
    space.add_lwpolyline([(0, 0), (10, 0), (10, 10), (0, 10), (0, gap)], **on(layer))
    space.add_line((-1, 5), (11, 5), **on("JOINT_1"))


@pytest.mark.parametrize("layer", ["BOUNDARY", "TUNNEL", "STAGE_2"])
def test_an_outline_with_a_gap_is_refused_with_both_ends(layer, tmp_path):
    document, space = drawing()
    if layer != "BOUNDARY":
        square(space, -20, 20)
    open_square(space, 0.02, layer)
    one_line(convert(document, tmp_path, "--e0", "1e-5"), "(0, 0) (0, 0.02), the nearest 0.02 apart", "--close G")


@pytest.mark.parametrize("gap, words", [(0.02, ("--close", 0.02)), (0.006, ()), (1e-9, ()), (3, ("--close", 5))])
def test_a_gap_of_an_outline_is_closed_up_to_a_length_that_is_given_or_that_of_nodes(gap, words, tmp_path):
    """1.25 e0 w0 = 0.00125 * 1.02 * 5 = 0.0064 without the option. The joint is cut off by the clip, so that the square makes w0."""
    document, space = drawing()
    space.add_lwpolyline([(0, 0), (10, 0), (10, 10), (0, 10), (0, gap)], **on("BOUNDARY"))
    space.add_line((0, 5), (10, 5), **on("JOINT_1"))
    done = convert(document, tmp_path, *words)
    assert f"boundary lines: joined ends {gap:.6g} apart or less at (0, 0)" in done.stdout and done.stderr == ""
    assert areas(tmp_path) == pytest.approx([50, 50], rel=1e-12)
    assert read_deck(tmp_path / "map.geo").boundary == 5


def test_only_ends_near_each_other_are_joined_and_overshoots_are_no_gaps(tmp_path):
    document, space = drawing()
    for a, b in (((-1, 0), (11, 0)), ((10, -1), (10, 11)), ((11, 10), (-1, 10)), ((0, 11), (0, -1))):
        space.add_line(a, b, **on("BOUNDARY"))
    done = convert(document, tmp_path, "--close", 2)  # the ends beside each corner are 1.4 apart
    assert "joined" not in done.stdout and areas(tmp_path) == pytest.approx([100], rel=1e-12)


def test_a_boundary_that_ends_outside_of_the_clip_is_no_open_one(tmp_path):
    document, space = drawing()
    space.add_lwpolyline([(-9, 4), (5, 5), (19, 6)], **on("BOUNDARY"))
    convert(document, tmp_path, "--clip", 0, 0, 10, 10)
    assert areas(tmp_path) == pytest.approx([50, 50], rel=1e-12)  # the line goes through the middle of the clip
    space.add_lwpolyline([(5, 5), (5, 8)], **on("BOUNDARY"))
    one_line(convert(document, tmp_path, "--clip", 0, 0, 10, 10), "(5, 8)")
    one_line(convert(document, tmp_path, "--close", "nan"), "--close: expected")
