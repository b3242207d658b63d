"""The tool that turns maps of features into a geometry deck: GeoJSON, tables, files of GDAL; ends of traces; sections; grids."""
import json
import math
import subprocess
import sys
from unittest import mock

import ezdxf
import numpy as np
import pytest
import scree
from made_traces import made_traces
from shapely.geometry import LineString
from test_dxf2geo import TOOL, one_line, read_deck, run
from test_map_rock import areas

SQUARE = [[0, 0], [10, 0], [10, 10], [0, 10], [0, 0]]


def feature(kind, coordinates, **columns):
    return {"type": "Feature", "properties": columns, "geometry": {"type": kind, "coordinates": coordinates}}


def write(path, *features, **more):
    path.write_text(json.dumps({"type": "FeatureCollection", "features": features, **more}))
    return path


def line(*places, **columns):
    return feature("LineString", places, **columns)


def deck_of(folder, *words):
    done = run(*words, "-o", folder / "map.geo")
    assert done.returncode == 0, done.stderr
    return read_deck(folder / "map.geo"), done


def test_traces_in_an_area_become_blocks(tmp_path):
    """A square of 10 that two traces cross: 4 blocks whose areas are those of the parts."""
    traces = write(tmp_path / "traces.geojson", line((-1, 4), (5, 4), (11, 4)), line((3, -1), (3, 11)))
    area = write(tmp_path / "area.geojson", feature("Polygon", [SQUARE]))
    deck, done = deck_of(tmp_path, traces, area)
    assert deck.boundary == 4 and {row[4] for row in deck.lines[:4]} == {1} and {row[4] for row in deck.lines[4:]} == {2}
    assert "layer 'area': boundary, joint material 1, 4 lines" in done.stdout
    assert areas(tmp_path) == pytest.approx([12, 18, 28, 42], rel=1e-12)


def test_columns_of_fractopo_are_known(tmp_path):
    """Sets of azimuths are layers, invalid traces are told; another column goes by --by."""
    traces = write(tmp_path / "t.geojson", line((0, 0), (1, 0), azimuth_set="N-S", generation=2, VALIDATION_ERRORS=[]),
                   line((0, 1), (1, 1), azimuth_set="E-W", generation=1, VALIDATION_ERRORS=["V NODE"]),
                   line((0, 2), (1, 2), azimuth_set=None, generation=1.0), crs={"properties": {"name": "urn:ogc:def:crs:EPSG::3067"}})
    deck, done = deck_of(tmp_path, traces)
    assert [row[4] for row in deck.lines] == [1, 2, 3] and [row[1] for row in deck.lines] == [1, 0, 2]
    assert "layers of t.geojson by the column 'azimuth_set'" in done.stdout and "1 traces that fractopo found invalid" in done.stderr
    deck, _ = deck_of(tmp_path, traces, "--by", "GENERATION", "--layer", "2=joint:7")
    assert [row[1::3] for row in deck.lines] == [(1, 1), (2, 1), (0, 7)]
    one_line(run(traces, "--by", "age"), "a column 'age'", "'generation'")


def test_every_format_gives_the_same_deck(tmp_path):
    """Three traces, one of three places, with coordinates that no decimal fraction holds."""
    traces = np.array([[0.1, 1 / 3], [2.0, math.pi]]).tolist(), [[1, 1], [2, 1 / 7], [3, 5]], [[-1e-3, 0], [7e6 + 1 / 3, 1]]
    write(tmp_path / "a.geojson", *(line(*trace) for trace in traces))
    write(tmp_path / "b.geojson", feature("MultiLineString", traces))
    (tmp_path / "c.csv").write_text("\n".join(",".join(str(number) for place in trace for number in place) for trace in traces))
    (tmp_path / "d.csv").write_text("Trace;X;Y\n" + "\n".join(f"{k};{x};{y}" for k, trace in enumerate(traces) for x, y in trace))
    (tmp_path / "e.txt").write_text("x1\ty1\tx2\ty2\n" + "\n".join(
        "\t".join(str(number) for number in (*a, *b)) for trace in traces for a, b in zip(trace, trace[1:])))
    (tmp_path / "f.csv").write_text("id,WKT\n" + "\n".join(
        f'{k},"LINESTRING ({", ".join(f"{x} {y}" for x, y in trace)})"' for k, trace in enumerate(traces)))
    document = ezdxf.new("R2010")
    for trace in traces:
        document.modelspace().add_lwpolyline(trace)
    document.saveas(tmp_path / "g.dxf")
    decks = [deck_of(tmp_path, tmp_path / name)[0].lines
             for name in ("a.geojson", "b.geojson", "c.csv", "d.csv", "e.txt", "f.csv", "g.dxf")]
    assert len(decks[0]) == 4 and all(deck == decks[0] for deck in decks)


def test_files_of_gdal_give_the_same_deck(tmp_path):
    pyogrio = pytest.importorskip("pyogrio")
    lines = [LineString([(0.1, 1 / 3), (2, math.pi)]), LineString([(1, 1), (2, 1 / 7), (3, 5)])]
    write(tmp_path / "a.geojson", *(line(*shape.coords, set=name) for shape, name in zip(lines, "AB")))
    expected = deck_of(tmp_path, tmp_path / "a.geojson", "--by", "set")[0].lines
    for name, driver in (("b.gpkg", "GPKG"), ("c.shp", "ESRI Shapefile")):
        pyogrio.raw.write(tmp_path / name, np.array([shape.wkb for shape in lines], object), [np.array(["A", "B"], object)], ["set"],
                          geometry_type="LineString", driver=driver, crs="EPSG:3067")
        assert deck_of(tmp_path, tmp_path / name, "--by", "set")[0].lines == expected
        with mock.patch.dict(sys.modules, {"pyogrio": None}):
            if pytest.importorskip("fiona"):
                assert deck_of(tmp_path, tmp_path / name, "--by", "set")[0].lines == expected


def test_coordinates_of_a_national_grid_keep_their_digits_and_an_origin_is_taken_off_and_said(tmp_path):
    east, north = 466000.282228614203632, 6691582.099214151501656
    traces = write(tmp_path / "t.geojson", line((east, north), (east + 10, north + 1 / 3)))
    assert deck_of(tmp_path, traces)[0].lines == [(east, north, east + 10, north + 1 / 3, 1)]
    deck, done = deck_of(tmp_path, traces, "--origin", 466000, 6691500, "--clip", 465990, 6691570, 466090, 6691590, "--fixed", 465990,
                         6691571, 466090, 6691571)
    assert deck.lines[-1] == (east - 466000, north - 6691500, east + 10 - 466000, north + 1 / 3 - 6691500, 1)
    assert {row[:4] for row in deck.lines[:4]} == {(-10, 70, 90, 70), (90, 70, 90, 90), (90, 90, -10, 90), (-10, 90, -10, 70)}
    assert deck.fixed == [(-10, 71, 90, 71)] and "origin: 466000.0 6691500.0 is taken off all coordinates" in done.stdout


def test_an_end_in_the_rock_is_moved_extended_or_kept(tmp_path):
    """A trace through the square; one that ends 0.2 before it, one 1.5 before it at 45 degrees, one that points away from all."""
    traces = write(tmp_path / "t.geojson", line((0, 5), (10, 5)), line((2, 0), (2, 4.8)), line((4, 0), (4, 2), (5.5, 3.5)),
                   line((8, 7), (8, 6)))
    area = write(tmp_path / "area.geojson", feature("Polygon", [SQUARE]))
    deck, done = deck_of(tmp_path, traces, area)
    assert "4 meet a line, 4 lie in the rock" in done.stdout and (2, 0, 2, 4.8, 2) in deck.lines
    assert areas(tmp_path) == pytest.approx([50, 50], rel=1e-12)
    deck, done = deck_of(tmp_path, traces, area, "--snap", 0.3)
    assert "1 were moved onto one by 0.2 or less" in done.stdout and areas(tmp_path) == pytest.approx([10, 40, 50], rel=1e-12)
    deck, done = deck_of(tmp_path, traces, area, "--snap", 0.3, "--extend", 2.2)
    # the third ends at (7, 5), the fourth at (8, 5) as it points down, and its other end stays, 3 from the side above
    assert f"2 were extended to one by {1.5 * math.sqrt(2):.6g} or less, {1.5 * math.sqrt(2) + 1:.6g} in all" in done.stdout
    assert "1 lie in the rock" in done.stdout
    assert areas(tmp_path) == pytest.approx([10, 2 * 5 + 3 * 3 / 2, 40 - 14.5, 50], rel=1e-12)
    deck, done = deck_of(tmp_path, traces, area, "--extend", "inf")
    assert "0 lie in the rock" in done.stdout and len(areas(tmp_path)) == 5
    assert sum(areas(tmp_path)) == pytest.approx(100, rel=1e-12)


def test_a_section_has_apparent_dips_and_lengths_of_traces(tmp_path):
    """The section runs to the north east. A plane that dips 60 degrees to the east has there tan 60 cos 45; one that strikes along the
    section shows no dip; an upright one is upright."""
    root = math.sqrt(0.5)
    traces = write(tmp_path / "t.geojson", line((0, 5), (0, -5), dip=60, dip_direction=90), line((root, 5), (root, -5), dip=90, strike=0),
                   line((3, 0), (0, 3), dip=20, dip_dir=45), line((50, 0), (50, 1), dip=20, dip_dir=45))
    deck, done = deck_of(tmp_path, traces, "--section", -10, -10, 10, 10)
    apparent = math.atan(math.tan(math.radians(60)) * math.cos(math.radians(45)))
    middle = 10 * math.sqrt(2)
    first, upright, gentle = sorted(deck.lines)
    assert first[:4] == pytest.approx((middle, 0, middle + 10 * math.cos(apparent), -10 * math.sin(apparent)), abs=1e-12)
    assert upright[:4] == pytest.approx((middle + 1, 0, middle + 1, -10), abs=1e-12)
    length, dip = 3 * math.sqrt(2), math.radians(20)
    assert gentle[:4] == pytest.approx((middle + 1.5 * math.sqrt(2), 0, middle + 1.5 * math.sqrt(2) + length * math.cos(dip),
                                        -length * math.sin(dip)), abs=1e-12)
    assert "left out: 1 features with dip and dip_direction that do not cross the section" in done.stdout
    one_line(run(write(tmp_path / "u.geojson", line((0, 0), (1, 1), dip=99, strike=0)), "--section", 0, 0, 1, 0), "feature 1", "0 to 90")


def test_lines_with_heights_are_projected_on_a_section(tmp_path):
    """A line on a face that runs north at x = 4: along the section y is the distance, z the height; one farther than the reach goes."""
    traces = write(tmp_path / "t.geojson", line((4, 1, 100), (4.5, 3, 104)), line((9, 1, 100), (9, 3, 104)))
    deck, done = deck_of(tmp_path, traces, "--section", 4, 0, 4, 10, "--reach", 2)
    assert [row[:4] for row in deck.lines] == [(1, 100, 3, 104)]
    assert "section: lines lie from 0 to 0.5 to the right of it" in done.stdout and "1 features farther from the section" in done.stdout
    flat = write(tmp_path / "u.geojson", line((0, 0), (3, 1)))
    one_line(run(flat, "--section", 0, 0, 5, 0), "expected heights of lines, or columns dip and dip_direction")


def test_geojson_and_tables_need_numpy_alone(tmp_path):
    """An area, and a window, without ezdxf, shapely, pyogrio and fiona."""
    traces = write(tmp_path / "t.geojson", line((-1, 4), (11, 4)))
    area = write(tmp_path / "area.geojson", feature("Polygon", [SQUARE]))
    code = ("import sys; sys.modules.update(dict.fromkeys(('ezdxf', 'shapely', 'pyogrio', 'fiona', 'matplotlib')))\n"
            "from scree.maps.command import main; sys.argv[0] = 'map'; sys.exit(main())")
    for words in ([area], ["--clip", "0", "0", "10", "10"]):
        done = subprocess.run([sys.executable, "-B", "-c", code, traces, *words, "-o", tmp_path / "map.geo"], capture_output=True, text=True,
                              env={"PYTHONPATH": str(TOOL.parent), "PATH": "/usr/bin:/bin"})
        assert done.returncode == 0, done.stderr
        assert areas(tmp_path) == pytest.approx([40, 60], rel=1e-12)


@pytest.mark.parametrize("name,text,said", [
    ("a.geojson", "{", "a.geojson: expected GeoJSON"), ("a.geojson", "[1]", "expected GeoJSON with features"),
    ("a.json", '{"type": "Topology"}', "found Topology"), ("a.geojson", '{"type": "FeatureCollection"}', "expected GeoJSON with features"),
    ("a.geojson", json.dumps({"type": "FeatureCollection", "features": [line((0, 0), (1, 1)), line((0, "x"), (1, 1))]}),
     "a.geojson: feature 2: expected numbers as coordinates of a LineString, found "),
    ("a.geojson", json.dumps(line((0, 0))), "feature 1: expected 2 places or more x y of a LineString"),
    ("a.geojson", json.dumps(line((0, 0), (1,))), "feature 1: expected 2 places or more x y"),
    ("a.geojson", json.dumps(line((0, 0), (1, float("nan")))), "expected finite coordinates, found LineString on layer 'a'"),
    ("a.geojson", json.dumps(feature("Polygon", [1, 2])), "feature 1: expected"),
    ("a.geojson", json.dumps({"type": "FeatureCollection", "features": []}), "an empty drawing"),
    ("a.geojson", json.dumps({"type": "FeatureCollection", "features": [line((24.9, 60.1), (25, 60.2))], "crs": {
        "type": "name", "properties": {"name": "urn:ogc:def:crs:OGC:1.3:CRS84"}}}), "expected coordinates that are lengths, found degrees"),
    ("a.csv", "", "an empty file"), ("a.csv", "1,2,3\n", "a.csv:1: expected x and y of two places or more, found 3 numbers"),
    ("a.csv", "a,b\n1,2\n", "a.csv:1: expected the columns x1 y1 x2 y2, or x y and trace, or wkt, found a, b"),
    ("a.csv", "x1,y1,x2,y2\n1,2,3,4\n\n1,2,3,four\n", "a.csv:4: expected a number, found 'four'"),
    ("a.csv", "wkt\nCIRCLE (1 2)\n", "a.csv:2: expected well-known text"), ("a.csv", 'wkt\n"LINESTRING (1 2, 3 x)"\n', "a.csv:2: expected numbers"),
    ("a.xyz", "", "expected a map with the ending .dxf"), ("none/a.geojson", None, "expected GeoJSON, found: No such file"),
    ("none/a.gpkg", None, "expected a map, found no such file")])
def test_what_is_no_map_is_one_line(name, text, said, tmp_path):
    if text is not None:
        (tmp_path / name).write_text(text)
    one_line(run(tmp_path / name, "-o", tmp_path / "map.geo"), said)
    assert not (tmp_path / "map.geo").exists()


def test_what_is_left_out_is_said(tmp_path):
    traces = write(tmp_path / "t.geojson", line((0, 0), (1, 1), (1, 1)), {"type": "Feature", "properties": None, "geometry": None},
                   feature("Tin", []), feature("Point", [3, 4]))
    _, done = deck_of(tmp_path, traces)
    assert "dropped 1 line of no length" in done.stdout
    for what in ("1 feature without a geometry", "1 feature of the kind 'Tin'", "1 Point (this layer is for lines)"):
        assert f"left out, not understood: {what} on layer 't'" in done.stderr


def test_the_map_is_drawn(tmp_path):
    (tmp_path / "t.geojson").write_text(made_traces(60, 10, 10, 3))
    _, done = deck_of(tmp_path, tmp_path / "t.geojson", "--clip", 0, 0, 10, 10, "--extend", 1, "--picture", tmp_path / "p.png")
    assert (tmp_path / "p.png").read_bytes().startswith(b"\x89PNG") and str(tmp_path / "p.png") in done.stdout


def test_two_thousand_traces_become_blocks(tmp_path):
    """The blocks fill the window, and their joints have the materials of the sets."""
    (tmp_path / "t.geojson").write_text(made_traces(2000, 40, 30, 1))
    deck, _ = deck_of(tmp_path, tmp_path / "t.geojson", "--clip", 0, 0, 40, 30, "--snap", 0.05, "--extend", 1)
    assert {row[4] for row in deck.lines} == {1, 2, 3, 4}
    found = areas(tmp_path)
    assert len(found) > 2000 and sum(found) == pytest.approx(1200, rel=1e-12)


def test_traces_stand_under_their_weight(tmp_path):
    """Rock from its traces, held below and at both sides: a static run ends in equilibrium, and no block falls."""
    (tmp_path / "t.geojson").write_text(made_traces(40, 10, 8, 2))
    done = run(tmp_path / "t.geojson", "--clip", 0, 0, 10, 8, "--snap", 0.05, "--extend", "inf", "--least-area", 0.01, "--fixed", 0, 0.01,
               10, 0.01, "--fixed", 0.01, 0, 0.01, 8, "--fixed", 9.99, 0, 9.99, 8, "-o", tmp_path / "map.geo")
    assert done.returncode == 0, done.stderr
    (tmp_path / "map.ana").write_text("0 200 1 4 0.05 0.01\n2600 25506 1e10 0.25\n0 0 0\n0 0 0\n0 0 0\n" + "40 0 0\n" * 4
                                      + "&deck geometry='map.geo' /\n&method plane='strain' /\n&step balance=1e-4 /\n")
    done = scree.call("run", "map.ana", cwd=tmp_path)
    assert done.returncode == 0 and "balance: in equilibrium" in done.stdout, done.stdout + done.stderr
    r = scree.read(tmp_path / "map.h5")
    assert r.n_blocks > 100
    assert r.bodies.area[-1].sum() == pytest.approx(80, rel=1e-3)
    assert abs(r.displacement(-1)).max() < 1e-3  # of the size; blocks that fall or slide move by their own size
