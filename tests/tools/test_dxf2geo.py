"""The tool that turns a DXF joint map into a geometry deck."""
import contextlib
import io
import math
import os
import pathlib
import re
import subprocess
import sys
import types
from unittest import mock

import ezdxf
import numpy as np
import pytest
import scree
from scree.maps import command

TOOL = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tools" / "dxf2geo"
ROUND_OFF = 1e-13  # a few units in the last place of coordinates near 1 to 10


def run(*words):
    """The tool's main in this process, which spares its start: status, output, errors."""
    output, errors = io.StringIO(), io.StringIO()
    with (contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors),
          mock.patch.object(sys, "argv", ["dxf2geo", *map(str, words)])):
        status = command.main()
    return types.SimpleNamespace(returncode=status, stdout=output.getvalue(), stderr=errors.getvalue())


def drawing(version="R2010"):
    document = ezdxf.new(version)
    return document, document.modelspace()


def on(layer, **more):
    return {"dxfattribs": {"layer": layer, **more}}


def convert(document, folder, *words):
    document.saveas(folder / "map.dxf")
    return run(folder / "map.dxf", *words)


def convert_edited(document, folder, old, new):
    """With a text of the file replaced, for what ezdxf does not write."""
    document.saveas(folder / "map.dxf")
    text = (folder / "map.dxf").read_text()
    assert text.count(old) == 1
    (folder / "map.dxf").write_text(text.replace(old, new))
    return run(folder / "map.dxf")


def read_deck(path):
    """Lines and points of a geometry deck, as doc/decks.md says."""
    numbers = iter(re.sub("[!#].*", "", path.read_text()).replace(",", " ").split())
    deck = types.SimpleNamespace(e0=float(next(numbers)))
    n, deck.boundary, materials, bolts, *counts = (int(next(numbers)) for _ in range(8))
    assert bolts == 0

    def rows(count, *types):
        return [tuple(kind(next(numbers)) for kind in types) for _ in range(count)]

    ends = (float,) * 4
    deck.lines, deck.materials, deck.fixed = rows(n, *ends, int), rows(materials, *ends, int), rows(counts[0], *ends)
    deck.loads, deck.measured, deck.holes = (rows(count, float, float) for count in counts[1:])
    assert next(numbers, None) is None
    return deck


def deck_of(document, folder, *words, warned=False):
    done = convert(document, folder, *words)
    assert done.returncode == 0 and bool(done.stderr) == warned, done.stderr
    assert done.stdout.splitlines()[-1] == str(folder / "map.geo")
    return read_deck(folder / "map.geo")


def chain(lines):
    """The places of lines that follow each other to the bit, the last one too."""
    assert all(a[2:4] == b[:2] for a, b in zip(lines, lines[1:]))
    return np.array([line[:2] for line in lines] + [lines[-1][2:4]])


def distance_to_chain(points, places):
    """The largest distance of points from a chain of chords."""
    least = np.full(len(points), np.inf)
    for a, b in zip(places, places[1:]):
        share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        least = np.minimum(least, np.hypot(*(points - a - share[:, None] * (b - a)).T))
    return least.max()


def area(places):
    x, y = places[:-1].T
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2


def middles(places):
    return (places[1:] + places[:-1]) / 2


def test_coordinates_and_order_are_those_of_the_drawing_to_the_bit(tmp_path):
    document, space = drawing()
    random = np.random.default_rng(1).uniform(-1e6, 1e6, (20, 4)).tolist() + [[0.1, 1 / 3, 1e-9, math.pi * 1e20]]
    for x1, y1, x2, y2 in random:
        space.add_line((x1, y1), (x2, y2), **on("JOINT_7"))
    assert deck_of(document, tmp_path, "--e0", "0", "--layer", "joint_7=joint:3").lines == [(*row, 3) for row in random]


@pytest.mark.parametrize("version", ["R12", "R2000", "R2018"])
def test_a_closed_polyline_is_its_polygon(version, tmp_path):
    document, space = drawing(version)
    corners = [(0.1, 0.2), (3.3, 0.7), (2.9, 4.1), (0.3, 2.2)]
    if version == "R12":
        space.add_polyline2d(corners, close=True)
    else:
        space.add_lwpolyline(corners, close=True)
    lines = deck_of(document, tmp_path).lines
    assert [line[:2] for line in lines] == corners and lines[-1][2:4] == corners[0]
    assert area(chain(lines)) == pytest.approx(area(np.array(corners + corners[:1])), rel=1e-15)


def test_an_open_polyline_is_not_closed(tmp_path):
    document, space = drawing()
    space.add_lwpolyline([(0, 0), (1, 0), (1, 1)])
    space.add_polyline3d([(0, 2, 0), (1, 2, 0), (1, 3, 0)])
    assert len(deck_of(document, tmp_path).lines) == 4


@pytest.mark.parametrize("sagitta", [None, 0.3, 1e-2, 1e-4, 1e-6])
def test_a_circle_is_a_regular_polygon_within_the_sagitta(sagitta, tmp_path):
    document, space = drawing()
    space.add_circle((3, -2), 1.5)
    words = [] if sagitta is None else ["--sagitta", sagitta, "--e0", "0"]
    places = chain(deck_of(document, tmp_path, *map(str, words)).lines)
    largest = sagitta or 1e-3 * 3  # the extent is the diameter
    n = len(places) - 1
    assert (places[0] == places[-1]).all()
    assert np.abs(np.hypot(*(places - [3, -2]).T) - 1.5).max() < ROUND_OFF
    assert np.ptp(np.hypot(*(middles(places) - [3, -2]).T)) < ROUND_OFF and 1.5 * (1 - math.cos(math.pi / n)) <= largest
    assert n == 4 or 1.5 * (1 - math.cos(math.pi / (n - 1))) > 0.999 * largest  # the fewest; the default's extent is within 1e-3
    assert area(places) == pytest.approx(n / 2 * 1.5**2 * math.sin(2 * math.pi / n), rel=1e-12)


@pytest.mark.parametrize("start, end", [(0, 90), (10, 350), (300, 30), (-45, 45), (12.5, 13)])
@pytest.mark.parametrize("extrusion", [(0, 0, 1), (0, 0, -1)])
def test_an_arc_keeps_within_the_sagitta_between_its_ends(start, end, extrusion, tmp_path):
    document, space = drawing()
    mirror = np.array([extrusion[2], 1])  # a downward extrusion turns x round
    space.add_arc((1, 2), 10, start, end, **on("0", extrusion=extrusion))
    places = chain(deck_of(document, tmp_path, "--sagitta", "0.01").lines)
    sweep = math.radians((end - start) % 360)
    for place, angle in ((places[0], start), (places[-1], end)):
        expected = mirror * [1 + 10 * math.cos(math.radians(angle)), 2 + 10 * math.sin(math.radians(angle))]
        assert np.abs(place - expected).max() < ROUND_OFF
    radii = np.hypot(*(middles(places) * mirror - [1, 2]).T)
    assert radii.min() >= 9.99 and radii.max() < 10
    assert len(places) - 1 == max(math.ceil(sweep / (2 * math.acos(1 - 0.001))), math.ceil(sweep / (math.pi / 2)))
    t = np.radians(start) + sweep * np.linspace(0, 1, 1001)
    assert distance_to_chain((np.array([1, 2]) + 10 * np.array([np.cos(t), np.sin(t)]).T) * mirror, places) <= 0.01


def test_quarter_arcs_end_where_lines_begin(tmp_path):
    document, space = drawing()
    for k, (x, y) in enumerate([(1, 1), (0, 1), (0, 0), (1, 0)]):
        space.add_arc((x, y), 0.25, 90 * k, 90 * k + 90)
    lines = deck_of(document, tmp_path, "--e0", "0", "--sagitta", "1").lines
    assert [line[:4] for line in lines] == [(1.25, 1, 1, 1.25), (0, 1.25, -0.25, 1), (-0.25, 0, 0, -0.25), (1, -0.25, 1.25, 0)]


@pytest.mark.parametrize("version", ["R12", "R2010"])
@pytest.mark.parametrize("bulge", [1, -1, 0.3, -2.5, 1e-4])
def test_bulges_are_arcs_between_the_vertices_to_the_bit(version, bulge, tmp_path):
    document, space = drawing(version)
    vertices = [(0.1, 0.7, bulge), (2.3, 1.9, 0), (1.1, 5.3, 0)]
    if version == "R12":
        space.add_polyline2d(vertices, format="xyb", close=True)
    else:
        space.add_lwpolyline(vertices, format="xyb", close=True)
    places = chain(deck_of(document, tmp_path, "--sagitta", "1e-6", "--e0", "0").lines)
    ends = np.array([vertex[:2] for vertex in vertices + vertices[:1]])
    chord = math.dist(*ends[:2])
    sweep, radius = 4 * math.atan(abs(bulge)), chord * (1 + bulge**2) / (4 * abs(bulge))
    segment = radius**2 / 2 * (sweep - math.sin(sweep))  # to the right of the chord where the bulge is above 0
    assert places[[0, -3, -2, -1]].tolist() == ends[[0, 1, 2, 0]].tolist()
    assert area(places) == pytest.approx(area(ends) + math.copysign(segment, bulge), abs=1e-6 * radius * sweep)
    arc = places[:-2]
    along = (ends[1] - ends[0]) / chord
    centre = ends[:2].mean(0) + (1 - bulge**2) / (4 * bulge) * chord * np.array([-along[1], along[0]])
    assert np.abs(np.hypot(*(arc - centre).T) / radius - 1).max() < 1e-12  # the truth's centre loses digits, not the arc
    assert (radius - np.hypot(*(middles(arc) - centre).T)).max() <= 1e-6 + 1e-12 * radius


def test_polylines_of_a_downward_extrusion_are_mirrored(tmp_path):
    """x turns round, so a bulge to the right of its chord lies to the left."""
    document, space = drawing()
    for add, layer in ((space.add_lwpolyline, "1"), (space.add_polyline2d, "2")):
        add([(1, 0, 1), (3, 0, 0)], format="xyb", **on(layer, extrusion=(0, 0, -1)))
    lines = deck_of(document, tmp_path).lines
    for material in (1, 2):
        places = chain([line for line in lines if line[4] == material])
        assert places[[0, -1]].tolist() == [[-1, 0], [-3, 0]] and places[:, 1].min() == pytest.approx(-1, abs=1e-2)
        assert np.abs(np.hypot(*(places - [-2, 0]).T) - 1).max() < ROUND_OFF


@pytest.mark.parametrize("start, end", [(0, math.tau), (0, 6.2831853072), (0.3, 2.0), (5.0, 1.0)])
def test_an_ellipse_keeps_within_the_sagitta(start, end, tmp_path):
    document, space = drawing()
    major, ratio = np.array([3.0, 1.0]), 0.2
    space.add_ellipse((5, 6), (*major, 0), ratio, start, end)
    places = chain(deck_of(document, tmp_path, "--sagitta", "1e-3").lines)
    sweep = min((end - start) if end > start else end - start + math.tau, math.tau)
    t = start + sweep * np.linspace(0, 1, 20001)
    minor = ratio * np.array([-major[1], major[0]])
    curve = np.array([5, 6]) + np.cos(t)[:, None] * major + np.sin(t)[:, None] * minor
    assert distance_to_chain(curve, places) <= 1e-3
    assert np.abs(places[[0, -1]] - curve[[0, -1]]).max() < ROUND_OFF
    on_circle = (places - [5, 6]) @ np.linalg.inv(np.array([major, minor]))
    assert np.abs(np.hypot(*on_circle.T) - 1).max() < ROUND_OFF


def cubic(control, t):
    t = t[:, None]
    return (1 - t)**3 * control[0] + 3 * t * (1 - t)**2 * control[1] + 3 * t**2 * (1 - t) * control[2] + t**3 * control[3]


@pytest.mark.parametrize("control", [
    [(0, 0), (1, 0), (2, 1), (3, 1)], [(0, 0), (4, 3), (-1, 3), (3, 0)], [(0, 0), (3, 3), (3, -3), (0, 0)],
    [(0, 0), (2, 0), (-1, 0), (1, 0)],
], ids=["its middle lies on its chord", "a loop", "closed", "forth and back"])
@pytest.mark.parametrize("sagitta", [0.1, 1e-3, 1e-5])
def test_a_cubic_spline_keeps_within_the_sagitta(control, sagitta, tmp_path):
    document, space = drawing()
    space.add_open_spline([(x, y, 0) for x, y in control], degree=3)
    space.add_line((0, -5), (3, -5))
    lines = deck_of(document, tmp_path, "--sagitta", str(sagitta), "--e0", "0").lines
    places = chain(lines[:-1])
    assert distance_to_chain(cubic(np.array(control, float), np.linspace(0, 1, 5001)), places) <= sagitta
    assert places[[0, -1]].tolist() == [list(control[0]), list(control[3])]
    if sagitta == 1e-5:  # halving of what the control points bound takes at most twice the fewest chords
        assert len(places) < 2 * 3 / math.sqrt(8 * sagitta) * 2


def test_a_rational_spline_is_its_circle(tmp_path):
    document, space = drawing()
    w = math.sqrt(0.5)
    corners = [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1), (1, 0)]
    spline = space.add_spline()
    spline.dxf.degree = 2
    spline.control_points, spline.weights = [(x, y, 0) for x, y in corners], [1, w] * 4 + [1]
    spline.knots = [5, 5, 5, 6, 6, 8, 8, 9, 9, 11, 11, 11]
    places = chain(deck_of(document, tmp_path, "--sagitta", "1e-4").lines)
    assert np.abs(np.hypot(*places.T) - 1).max() < ROUND_OFF and np.hypot(*middles(places).T).min() >= 1 - 1e-4
    assert (places[0] == places[-1]).all() and area(places) == pytest.approx(math.pi, abs=2e-4 * math.pi)


def test_a_spline_of_free_ends_is_that_of_its_knots(tmp_path):
    """A uniform cubic B-spline begins and ends at (a + 4 b + c)/6 of its outer control points."""
    document, space = drawing()
    control = np.array([(0, 0), (1, 2), (3, 3), (5, 1), (4, -2), (1, -3)], float)
    spline = space.add_spline()
    spline.dxf.degree = 3
    spline.control_points, spline.knots = [(x, y, 0) for x, y in control], list(range(10))
    places = chain(deck_of(document, tmp_path, "--sagitta", "1e-4").lines)
    basis = np.array([[1, 4, 1, 0], [-3, 0, 3, 0], [3, -6, 3, 0], [-1, 3, -3, 1]]) / 6
    t = np.linspace(0, 1, 2001)
    curve = np.vstack([np.array([t**0, t, t**2, t**3]).T @ basis @ control[k: k + 4] for k in range(3)])
    assert distance_to_chain(curve, places) <= 1e-4
    for place, (a, b, c) in ((places[0], control[:3]), (places[-1], control[3:])):
        assert np.abs(place - (a + 4 * b + c) / 6).max() < ROUND_OFF


def test_a_spline_goes_through_its_fit_points(tmp_path):
    document, space = drawing()
    points = np.array([(0, 0), (1, 2), (3, 3), (5, 1)], float)
    space.add_spline([(x, y, 0) for x, y in points])
    places = chain(deck_of(document, tmp_path, "--sagitta", "1e-4").lines)
    assert distance_to_chain(points, places) <= 1e-4


def test_the_control_frame_of_a_fitted_polyline_is_not_drawn(tmp_path):
    document, space = drawing("R12")
    polyline = space.add_polyline2d([(0, 0), (5, 9), (1, 1), (2, 0)])
    polyline.dxf.flags |= 4
    polyline.vertices[1].dxf.flags |= 16
    assert [line[:4] for line in deck_of(document, tmp_path).lines] == [(0, 0, 1, 1), (1, 1, 2, 0)]


def triangle(space, x, layer):
    space.add_lwpolyline([(-1 - x, -1), (30, -1), (30, 30)], close=True, **on(layer))


def test_layers_become_materials_and_the_mapping_is_said(tmp_path):
    document, space = drawing()
    names = ["Fault", "JOINT_3", "1", "bedding", "joint 0", "BOUNDARY", "boundary-2", "MATERIAL_2", "Material5", "FIXED_4"]
    for k, name in enumerate(names):
        if name.lower().startswith("boundary"):
            triangle(space, k, name)
        else:
            space.add_line((k, 0), (k, 1), **on(name))
    deck = deck_of(document, tmp_path)
    # 1, 2 and 3 are taken: bedding, BOUNDARY, Fault and 'joint 0' get 4 to 7
    assert deck.boundary == 6 and [line[4] for line in deck.lines[:6]] == [5] * 3 + [2] * 3
    assert [line[0::4] for line in deck.lines[6:]] == [(2, 1), (3, 4), (0, 6), (4, 7), (1, 3)]
    assert deck.materials == [(8, 0, 8, 1, 5), (7, 0, 7, 1, 2)] and deck.fixed == [(9, 0, 9, 1)]
    said = ["layer '1': joint material 1, 1 line", "layer 'bedding': joint material 4, 1 line",
            "layer 'BOUNDARY': boundary, joint material 5, 3 lines", "layer 'boundary-2': boundary, joint material 2, 3 lines",
            "layer 'Fault': joint material 6, 1 line", "layer 'FIXED_4': fixed, 1 line",
            "layer 'joint 0': joint material 7, 1 line",
            "layer 'JOINT_3': joint material 3, 1 line", "layer 'Material5': block material 5, 1 line",
            "layer 'MATERIAL_2': block material 2, 1 line", "length of joint lines: 5 drawn, 5 in the deck",
            "ends of joint traces: 0 meet a line, 0 lie in the rock, 10 outside of it",
            "joint materials of the analysis deck (nj): 7, that of layer 'joint 0'"]
    assert convert(document, tmp_path).stdout.splitlines()[:-1] == said
    comments = [line[2:] for line in (tmp_path / "map.geo").read_text().splitlines() if re.match("! (layer|length|ends|joint materials)", line)]
    assert comments == said


@pytest.mark.parametrize("name, number", [
    ("JOINT_3", 3), ("joints 3", 3), ("Joint-12", 12), ("JOINTS.4", 4), ("7", 7), ("BOUNDARY_5", 5), ("boundaries 6", 6),
    ("Survey_2019", 0), ("joints dip 65", 0), ("JOINT_SET_2", 0), ("line 3", 0), ("J2", 0), ("J_3.5", 0), ("3b", 0), ("65 joints", 0),
    ("BOUNDARY survey 2019", 0), ("joint_0", 0)])
def test_the_number_of_a_layer_is_that_after_one_word_that_says_what_the_layer_holds(name, number, tmp_path):
    """All other layers get the numbers from 1 that are free, so that no year and no dip becomes a material."""
    document, space = drawing()
    triangle(space, 0, name)
    deck = deck_of(document, tmp_path)
    assert {line[4] for line in deck.lines} == {number or 1}
    assert f"joint materials of the analysis deck (nj): {number or 1}, that of layer '{name}'" in (tmp_path / "map.geo").read_text()


def test_options_win_over_names(tmp_path):
    document, space = drawing()
    triangle(space, 0, "A B")
    for k, name in enumerate(["FIXED", "HOLE", "JOINT_1", "notes", "x"], 1):
        space.add_line((k, 0), (k, 1), **on(name))
    space.add_text("not read", **on("notes"))
    space.add_point((9, 9), **on("x"))
    words = ["a b=boundary:4", "FIXED=joint:2", "hole=material:6", "joint_1=fixed", "NOTES=skip", "x=measured"]
    done = convert(document, tmp_path, *[word for option in words for word in ("--layer", option)])
    deck = read_deck(tmp_path / "map.geo")
    assert done.returncode == 0 and "layer 'notes': skipped, 2 entities" in done.stdout
    assert done.stderr.count("\n") == 1 and "1 LINE (this layer is for points) on layer 'x'" in done.stderr
    assert deck.boundary == 3 and {line[4] for line in deck.lines[:3]} == {4} and deck.lines[3:] == [(1, 0, 1, 1, 2)]
    assert deck.materials == [(2, 0, 2, 1, 6)]
    assert deck.fixed == [(3, 0, 3, 1)] and deck.measured == [(9, 9)]


def test_layers_and_points_come_in_order_of_name_with_2_before_10(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1))
    for name in ("LOAD_10", "load_2", "LOAD_1"):
        space.add_point((float(name[5:]), 0.1), **on(name))
    assert deck_of(document, tmp_path).loads == [(1, 0.1), (2, 0.1), (10, 0.1)]


def test_points_and_centres_of_circles_are_points(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1))
    for k, layer in enumerate(["LOADS", "measured", "Hole", "FIXED"]):
        space.add_point((k + 0.1, 1 / 3), **on(layer))
        space.add_circle((k + 0.7, 0.2), 0.3, **on(layer))
    space.add_line((5, 5), (6, 5), **on("FIXED"))
    deck = deck_of(document, tmp_path)
    assert (deck.loads, deck.measured, deck.holes) == tuple([(k + 0.1, 1 / 3), (k + 0.7, 0.2)] for k in range(3))
    assert deck.fixed == [(3.1, 1 / 3, 3.1, 1 / 3), (3.7, 0.2, 3.7, 0.2), (5, 5, 6, 5)] and len(deck.lines) == 1


def with_block(name="B"):
    document, space = drawing()
    return space, document.blocks.new(name, base_point=(1, 0)), document


def test_inserts_are_exploded_with_base_point_turn_scale_and_grid(tmp_path):
    space, block, document = with_block()
    block.add_line((1, 0), (2, 0), **on("JOINT_2"))
    space.add_blockref("B", (10, 20), **on("0", rotation=90, xscale=3, yscale=2, row_count=2, column_count=3, row_spacing=5,
                                           column_spacing=7))
    lines = deck_of(document, tmp_path).lines
    expected = sorted((10 - 5 * row, 20 + 7 * column) for row in range(2) for column in range(3))  # the grid turns too
    found = sorted(lines, key=lambda line: (round(line[0]), round(line[1])))
    for line, (x, y) in zip(found, expected, strict=True):
        assert np.abs(np.array(line) - [x, y, x, y + 3, 2]).max() < ROUND_OFF


@pytest.mark.parametrize("seed", range(4))
def test_grids_of_unevenly_scaled_inserts_within_each_other_are_the_product_of_their_maps(seed, tmp_path):
    """A place p of a block goes to F (insert + R grid + R S (p - base)), with F turning x round where the extrusion is downward."""
    random = np.random.default_rng(seed)
    document, space = drawing()
    bases, ends = random.uniform(-5, 5, (2, 2)), random.uniform(-5, 5, (2, 2))
    inner, outer = (document.blocks.new(name, base_point=base) for name, base in zip("AB", bases))
    inner.add_line(*ends)
    places = [ends]
    for space_of_insert, name, base, side in ((outer, "A", bases[0], -1), (space, "B", bases[1], 1 if seed % 2 else -1)):
        x, y, sx, sy, dx, dy = random.uniform(-5, 5, 6)
        angle = random.uniform(-180, 180)
        space_of_insert.add_blockref(name, (x, y), **on(
            "0", xscale=sx, yscale=sy, rotation=angle, row_count=2, column_count=3, row_spacing=dy, column_spacing=dx,
            extrusion=(0, 0, side)))
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        turn = np.array([[c, -s], [s, c]])
        places = [(np.array([x, y]) + (turn @ [dx * column, dy * row]) + (p - base) @ (turn @ np.diag([sx, sy])).T) * [side, 1]
                  for row in range(2) for column in range(3) for p in places]
    lines = sorted(line[:4] for line in deck_of(document, tmp_path).lines)
    assert len(lines) == 36 and np.abs(np.array(lines) - sorted(p.ravel().tolist() for p in places)).max() < 1e-12  # near 100


def test_layer_0_of_a_block_is_the_layer_of_its_insert_through_all_levels(tmp_path):
    space, block, document = with_block()
    block.add_line((1, 0), (2, 0))
    block.add_line((1, 1), (2, 1), **on("JOINT_5"))
    document.blocks.new("OUTER").add_blockref("B", (0, 0))
    space.add_blockref("OUTER", (0, 0), **on("JOINT_4"))
    assert deck_of(document, tmp_path).lines == [(0, 0, 1, 0, 4), (0, 1, 1, 1, 5)]


def test_curves_in_unevenly_scaled_turned_mirrored_inserts_keep_within_the_sagitta(tmp_path):
    """The sheared circle, against the product of the two inserts' maps."""
    space, block, document = with_block()
    block.add_circle((1, 0), 1, **on("JOINT_1"))
    block.add_lwpolyline([(2, 0, 1), (0, 0, 1)], format="xyb", close=True, **on("JOINT_2"))
    spline = block.add_spline(**on("JOINT_3"))
    spline.dxf.degree = 2
    w = math.sqrt(0.5)
    spline.control_points, spline.weights, spline.knots = [(2, 0, 0), (2, 1, 0), (1, 1, 0)], [1, w, 1], [0, 0, 0, 1, 1, 1]
    block.add_point((1, 0), **on("LOAD"))
    document.blocks.new("OUTER").add_blockref("B", (0, 0), **on("0", rotation=30))
    space.add_blockref("OUTER", (5, -3), **on("0", xscale=-4, yscale=1, rotation=20))
    deck = deck_of(document, tmp_path, "--sagitta", "1e-3")

    def turn(degrees):
        c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
        return np.array([[c, -s], [s, c]])

    whole = turn(20) @ np.diag([-4, 1]) @ turn(30)
    t = np.linspace(0, math.tau, 40001)
    for material, share in ((1, 1), (2, 1), (3, 0.25)):
        places = chain([line for line in deck.lines if line[4] == material])
        angle = t * share
        curve = np.array([5, -3]) + np.array([np.cos(angle), np.sin(angle)]).T @ whole.T
        assert distance_to_chain(curve, places) <= 1e-3, material
        on_circle = (places - [5, -3]) @ np.linalg.inv(whole).T
        assert np.abs(np.hypot(*on_circle.T) - 1).max() < ROUND_OFF
    assert np.abs(np.array(deck.loads) - [5, -3]).max() < ROUND_OFF


def test_heights_are_left_out_and_told(tmp_path):
    """Every kind of entity with heights has the lines of the same entity in the plane."""
    def done(add):
        document, space = drawing()
        space.add_lwpolyline([(0, 0), (1, 7), (3, 2)], **on("A"))
        add(space, 1.0)
        said = convert(document, tmp_path, "--layer", "P=fixed") if add is point else convert(document, tmp_path)
        lifted = (tmp_path / "map.geo").read_text()
        document, space = drawing()
        space.add_lwpolyline([(0, 0), (1, 7), (3, 2)], **on("A"))
        add(space, 0.0)
        (convert(document, tmp_path, "--layer", "P=fixed") if add is point else convert(document, tmp_path))
        flat = (tmp_path / "map.geo").read_text()
        told = [line for line in said.stdout.splitlines() if line.startswith("heights left out: z from ")]
        assert said.returncode == 0 and len(told) == 1 and f"! {told[0]}\n" in lifted and "heights" not in flat
        assert lifted.replace(f"! {told[0]}\n", "") == flat
        return told[0]

    def point(space, h):
        space.add_point((0, 0, 0.5 * h), **on("P"))

    for add, heights in (
            (lambda s, h: s.add_line((0, 0, 0), (1, 1, 2.5 * h), **on("B")), "0 to 2.5"),
            (lambda s, h: s.add_lwpolyline([(0, 0), (1, 1)], **on("B", elevation=3 * h)), "0 to 3"),
            (lambda s, h: s.add_polyline2d([(0, 0), (1, 1)], **on("B", elevation=(0, 0, -4 * h))), "-4 to 0"),
            (lambda s, h: s.add_circle((0, 0, 7 * h), 1, **on("B")), "0 to 7"),
            (lambda s, h: s.add_open_spline([(0, 0, 0), (1, 0, 5 * h), (2, 0, 5 * h), (3, 0, 0)], **on("B")), "0 to 5"),
            (point, "0 to 0.5")):
        assert f"z from {heights}, projected on the plane xy (--plane)" in done(add)


@pytest.mark.parametrize("plane", ["xz", "yz"])
def test_a_section_on_edge_is_refused_with_the_plane_that_takes_it(plane, tmp_path):
    """A square of 100 upright, with a joint at half its height; the coordinate across is not 0."""
    document, space = drawing()

    def placed(*points):
        return [(x, 3, y) if plane == "xz" else (3, x, y) for x, y in points]

    space.add_polyline3d(placed((0, 0), (10, 0), (10, 10), (0, 10)), close=True, **on("BOUNDARY"))
    space.add_line(*placed((0, 5), (10, 5)), **on("JOINT_1"))
    one_line(convert(document, tmp_path), "in the plane xy, found one that stands on it, 0 wide with z from 0 to 10",
             f"--plane {plane} takes {plane[0]} and {plane[1]}")
    done = convert(document, tmp_path, "--plane", plane)
    across = (set("xyz") - set(plane)).pop()
    assert f"heights left out: {across} from 3 to 3, projected on the plane {plane}" in done.stdout
    deck = read_deck(tmp_path / "map.geo")
    assert [line[:4] for line in deck.lines] == [(0, 0, 10, 0), (10, 0, 10, 10), (10, 10, 0, 10), (0, 10, 0, 0), (0, 5, 10, 5)]


def test_a_plane_takes_two_coordinates_of_every_entity_after_its_insert(tmp_path):
    """A circle of a block in the x y plane, inserted on edge by its extrusion along y: x and z of it are a circle again."""
    document, space = drawing()
    document.blocks.new("B").add_circle((0, 0), 2)
    space.add_blockref("B", (1, 5, 0), **on("0", extrusion=(0, -1, 0)))
    places = chain(deck_of(document, tmp_path, "--plane", "xz", "--e0", 0).lines)
    centre = (places.max(0) + places.min(0)) / 2
    assert np.abs(np.hypot(*(places - centre).T) - 2).max() < ROUND_OFF
    one_line(convert(document, tmp_path), "--plane xz")
    assert convert(document, tmp_path, "--plane", "yz").returncode == 2  # on edge there, too


def test_hidden_layers_and_entities_are_left_out_and_said(tmp_path):
    document, space = drawing()
    for name in ("JOINT_1", "frost", "dark"):
        document.layers.add(name)
        space.add_line((0, 0), (1, 1), **on(name))
    space.add_line((0, 0, 5), (1, 1, 6), **on("frost"))
    document.layers.get("frost").freeze()
    document.layers.get("dark").off()
    block = document.blocks.new("B")
    block.add_line((0, 0), (3, 1))
    block.add_line((0, 0), (4, 1), **on("JOINT_1"))
    space.add_blockref("B", (0, 0), **on("dark"))
    space.add_blockref("B", (0, 0), **on("frost"))
    done = convert(document, tmp_path)
    assert done.returncode == 0 and done.stderr == ""
    said = set(done.stdout.splitlines())
    assert said >= {"layer 'frost' is frozen: 3 entities skipped", "layer 'dark' is off: 2 entities skipped"}
    assert read_deck(tmp_path / "map.geo").lines == [(0, 0, 1, 1, 1), (0, 0, 4, 1, 1)]


def test_an_invisible_entity_is_left_out_and_said(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1))
    space.add_line((0, 0), (2, 1), **on("UNSEEN"))
    done = convert_edited(document, tmp_path, "\n  8\nUNSEEN\n", "\n  8\nJOINT_1\n 60\n1\n")
    assert done.returncode == 0 and "layer 'JOINT_1': 1 entity invisible, skipped" in done.stdout
    assert len(read_deck(tmp_path / "map.geo").lines) == 1


def test_lines_of_no_length_are_dropped_and_counted(tmp_path):
    document, space = drawing()
    space.add_line((1, 1), (1, 1))
    space.add_lwpolyline([(0, 0), (1, 0), (1, 0), (1, 1), (0, 0)], close=True)
    done = convert(document, tmp_path)
    assert "dropped 3 lines of no length" in done.stdout and "dropped 3 lines" in (tmp_path / "map.geo").read_text()
    assert [line[:4] for line in read_deck(tmp_path / "map.geo").lines] == [(0, 0, 1, 0), (1, 0, 1, 1), (1, 1, 0, 0)]


@pytest.mark.parametrize("bulge", [1e-300, 1e-320, -1e-14, 1e-9])
def test_a_bulge_too_small_to_see_is_a_line(bulge, tmp_path):
    document, space = drawing()
    space.add_lwpolyline([(0.1, 0.2, bulge), (3, 4, 0)], format="xyb")
    assert deck_of(document, tmp_path).lines == [(0.1, 0.2, 3, 4, 1)]


def test_what_is_not_understood_is_counted_and_named(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1), **on("J1"))
    for _ in range(2):
        space.add_text("note", **on("notes"))
    space.add_hatch(**on("J1"))
    space.add_point((0, 0), **on("J1"))
    with space.add_mesh(**on("J1")).edit_data() as mesh:  # ezdxf 1 leaves out what is empty
        mesh.vertices, mesh.faces = [(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]
    space.add_polymesh((2, 2), **on("J1"))
    space.add_spline(**on("J1"))
    space.add_lwpolyline([(0, 0)], **on("J1"))
    space.add_blockref("NONE", (0, 0), **on("J1"))
    document.blocks.new("B").add_solid([(0, 0), (1, 0), (0, 1)], **on("J1"))
    space.add_blockref("B", (0, 0)).add_attrib("TAG", "text", (0, 0), **on("J1"))
    document.layout("Layout1").add_line((0, 0), (1, 1))
    done = convert(document, tmp_path)
    said = re.findall(r"left out, (?:not understood|in paper space): (.*)", done.stderr)
    named = {line.removesuffix(" on layer 'J1'") for line in said}
    assert named >= {
        "2 TEXT on layer 'notes'", "1 HATCH", "1 POINT (this layer is for lines)", "1 MESH", "1 POLYLINE that is a mesh",
        "1 LWPOLYLINE of less than two vertices", "1 INSERT of the missing block 'NONE'", "1 SOLID", "1 ATTRIB", "1 entity"}
    assert sum(name.startswith("1 SPLINE that cannot be built") for name in named) == 1 and len(said) == 11
    assert done.returncode == 0 and len(done.stderr.splitlines()) == 11 and len(read_deck(tmp_path / "map.geo").lines) == 1
    assert (tmp_path / "map.geo").read_text().count("! left out") == 11


def test_an_entity_of_an_unknown_name_is_named(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1))
    space.add_text("x", **on("notes"))
    done = convert_edited(document, tmp_path, "\nTEXT\n", "\nFUTURE\n")
    assert done.returncode == 0 and "1 FUTURE on layer 'notes'" in done.stderr


def test_lines_within_the_snap_distance_are_warned_of(tmp_path):
    document, space = drawing()
    space.add_lwpolyline([(0, 0), (2.6, 0), (2.6, 1), (0, 1)], close=True)
    space.add_line((0, 0), (0.0101, 0))  # e0 w0 = 0.01 * 1.02 * 2.6/2/1.3
    assert "1 line not longer than e0 w0 = 0.0102" in convert(document, tmp_path, "--e0", "0.01").stderr
    assert convert(document, tmp_path, "--e0", "0.0099").stderr == ""


def test_names_of_all_letters_stay_in_one_comment(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1), **on("Klüfte 岩"))
    deck_of(document, tmp_path)
    assert "! layer 'Klüfte 岩': joint material 1" in (tmp_path / "map.geo").read_text()


def one_line(done, *expected):
    assert done.returncode == 2 and done.stdout == "" and len(done.stderr.splitlines()) == 1, done.stderr
    assert "expected" in done.stderr and "found" in done.stderr
    for text in expected:
        assert text in done.stderr, done.stderr


def test_files_that_are_no_drawing_are_one_line(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1))
    document.saveas(tmp_path / "map.dxf")
    whole = (tmp_path / "map.dxf").read_bytes()
    for name, content in (("text", b"no DXF\nat all\n"), ("empty", b""), ("cut", whole[:len(whole) * 2 // 3]),
                          ("bytes", bytes(range(256))), ("number", whole.replace(b"\n1.0\n", b"\none\n"))):
        (tmp_path / f"{name}.dxf").write_bytes(content)
        one_line(run(tmp_path / f"{name}.dxf"), f"{name}.dxf: expected a DXF file")
        assert not (tmp_path / f"{name}.geo").exists()
    one_line(run(tmp_path / "none.dxf", "-o", tmp_path / "x.geo"), "a DXF file")
    one_line(run(tmp_path, "-o", tmp_path / "x.geo"), "a map with the ending .dxf")
    one_line(subprocess.run([TOOL, tmp_path / "none.dxf"], capture_output=True, text=True), "none.dxf: expected a DXF file")


def test_drawings_without_lines_are_one_line(tmp_path):
    def done(add, *words):
        document, space = drawing()
        add(document, space)
        return convert(document, tmp_path, *words)

    def frozen(document, space):
        document.layers.add("ice").freeze()
        space.add_line((0, 0), (1, 1), **on("ice"))

    one_line(done(lambda d, s: None), "an empty drawing")
    one_line(done(frozen), "1 on the layer 'ice', which is frozen")
    one_line(done(lambda d, s: s.add_text("x")), "1 TEXT")
    one_line(done(lambda d, s: s.add_line((0, 0), (1, 1)), "--layer", "0=skip"), "expected lines")
    one_line(done(lambda d, s: s.add_line((1, 1), (1, 1))), "1 of no length")
    one_line(done(lambda d, s: s.add_circle((1e6, 1e6), 1e-20)), "of no length")
    one_line(done(lambda d, s: s.add_point((1, 1), **on("HOLE"))), "joint or boundary lines")


def test_wrong_options_are_one_line(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1), **on("A"))
    for words, expected in (
            (["--layer", "B=joint:1"], "the name 'B'"), (["--layer", "A=joint"], "'A=joint'"),
            (["--layer", "A=joint:0"], "N from 1"), (["--layer", "A=material:9999999999"], "N from 1"),
            (["--layer", "A"], "NAME=ROLE"), (["--layer", "A=fixed:1"], "NAME=ROLE"),
            (["--layer", "A=joint:1", "--layer", "a=skip"], "found two"), (["--e0", "1"], "below 1"), (["--e0", "nan"], "below 1"),
            (["--sagitta", "0"], "above 0"), (["--sagitta", "inf"], "above 0"), (["--sagitta", "1e-12"], "at least 1e-09"),
            (["-o", tmp_path / "map.dxf"], "another name")):
        one_line(convert(document, tmp_path, *words), expected)
    done = convert(document, tmp_path, "-o", tmp_path / "no" / "x.geo")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "cannot write" in done.stderr


def test_material_layers_without_a_number_and_endless_blocks_are_one_line(tmp_path):
    document, space = drawing()
    space.add_line((0, 0), (1, 1), **on("MATERIAL"))
    one_line(convert(document, tmp_path), "a block material", "'MATERIAL=material:N'")
    space, block, document = with_block()
    block.add_blockref("B", (0, 0))
    space.add_blockref("B", (0, 0))
    one_line(convert(document, tmp_path), "'B' within itself")


def test_the_program_runs_the_deck_with_the_area_of_the_drawing(tmp_path):
    """A stadium beside a square: the chords of the stadium's half circles have the area of regular polygons."""
    document, space = drawing()
    space.add_lwpolyline([(0, 0), (2, 0), (2, 2), (0, 2)], close=True, **on("BOUNDARY"))
    space.add_lwpolyline([(4, 0, 0), (6, 0, 1), (6, 2, 0), (4, 2, 1)], format="xyb", close=True, **on("BOUNDARY_1"))
    space.add_line((5, -1), (5, 3), **on("MATERIAL_2"))
    space.add_point((1, 1), **on("MEASURED"))
    space.add_point((0, 0), **on("FIXED"))
    document.saveas(tmp_path / "map.dxf")
    subprocess.run([TOOL, "map.dxf"], cwd=tmp_path, check=True)
    deck = read_deck(tmp_path / "map.geo")
    n = (len(deck.lines) - 4 - 2) // 2  # chords of a half circle
    material = "1 0 1e6 0.2  0 0 0  0 0 0  0 0 0\n"
    joints = max(line[4] for line in deck.lines)
    (tmp_path / "map.ana").write_text(f"0\n1\n2 {joints}\n0.05\n0.01\n{2 * material}{joints * '30 0 0 '}\n")
    areas = scree.run(tmp_path / "map.geo", tmp_path / "map.ana").bodies.area
    assert sorted(areas[0]) == pytest.approx([4, 4 + n * math.sin(math.pi / n)], rel=1e-12)
