"""The tool plot on geometries and models: what is drawn, counted through its functions, and the pictures."""
import os
import pathlib
import subprocess

import numpy as np
import pytest
import scree
from matplotlib import image
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.path import Path
from scree import drawing as tool
from scree.polygons import loops_of

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOL = SOURCE / "tools" / "plot"

# A square of 10: a horizontal joint of material 2, a square hole in the lower block, a square block in the upper one.
GEOMETRY = """0.001
13 4
1  0  2 1 1 1
0 0 10 0 1
10 0 10 10 1
10 10 0 10 1
0 10 0 0 1
0 4 10 4 2
2 1 4 1 3
4 1 4 3 3
4 3 2 3 3
2 3 2 1 3
6 6 8 6 3
8 6 8 8 3
8 8 6 8 3
6 8 6 6 3
7 7 7 7 2
1 1 1 1
9 1 9 1
5 9
5 5
3 2
"""
ANALYSIS = """1 2 2 3 0.01 0.001
2500 25000 1e9 0.2
0 0 0
0 0 0
0 0 0
2500 25000 1e9 0.2
0 0 0
0 0 0
0 0 0
30 0 0
30 0 0
30 0 0
&deck geometry='map.geo' /
"""
COVERED = ANALYSIS + "&method model='nmm' /\n&cover edge=1.1 /\n"
AREAS = [36, 56, 4]  # below the joint less the hole; above it less the block; the block


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scene")
    (folder / "map.geo").write_text(GEOMETRY)
    (folder / "map.ana").write_text(ANALYSIS)
    (folder / "covered.ana").write_text(COVERED)
    scree.cut(folder / "map.geo", output=folder / "map.blk")
    scree.run(folder / "covered.ana", output=folder / "run.h5")
    return folder


def test_groups_of_places_after_the_numbers_are_passed_over(scene):
    """`scree cut` carries them on from the geometry."""
    (scene / "places.geo").write_text(GEOMETRY + "&support both=0 0 10 0 /\n&blocks least_area=5 /\n")
    made = scree.cut(scene / "places.geo", output=scene / "places.blk")
    assert "&support" in made.read_text()
    shapes = tool.Blocks(made, "places")
    assert len(shapes.polygons(0)) == 2 and len(shapes.points(0)[0]) == len(tool.Blocks(scene / "map.blk", "map").points(0)[0])


def shapes(path, folder):
    return tool.open_shapes(path, SCREE, folder)


def plot(*words):
    return subprocess.run([TOOL, *words, "--scree", SCREE], capture_output=True, text=True)


def area(path):
    """Of a path of loops: the holes count negative."""
    return sum(tool.area_and_centroid(loop[:-1])[0] for loop in path.to_polygons(closed_only=True))


def holds(path, place):
    """Whether a place is in an odd number of the loops."""
    return sum(Path(loop).contains_point(place) for loop in path.to_polygons(closed_only=True)) % 2 == 1


@pytest.mark.parametrize("name", ["map.geo", "map.blk", "map.ana", "covered.ana", "run.h5"])
@pytest.mark.parametrize("words", [[], ["--field", "material", "--joints", "--points", "--numbers"]])
def test_a_picture_is_made_and_not_blank(name, words, scene, tmp_path):
    done = plot(scene / name, *words, "-o", tmp_path / "p.png")
    assert done.returncode == 0 and done.stdout == f"{tmp_path / 'p.png'}\n", done.stderr
    pixels = image.imread(tmp_path / "p.png")
    assert len(np.unique(pixels.reshape(-1, pixels.shape[2]), axis=0)) > 10


def test_the_default_picture_lies_beside_the_first_file(scene):
    done = plot(scene / "map.geo")
    assert done.returncode == 0 and (scene / "map.png").exists()


@pytest.mark.parametrize("name", ["map.geo", "map.blk", "map.ana"])
def test_each_block_is_a_path_without_its_holes_and_seams(name, scene, tmp_path):
    paths = shapes(scene / name, tmp_path).outlines(0)
    assert sorted(area(path) for path in paths) == pytest.approx(sorted(AREAS), rel=1e-12)
    assert sorted(len(path.to_polygons()) for path in paths) == [1, 2, 2]
    assert not any(holds(path, (3, 2)) for path in paths)  # in the hole
    assert sum(holds(path, (7, 7)) for path in paths) == 1  # in the block, not in the one around it too


def test_the_picture_leaves_the_hole_white(scene):
    figure = tool.draw_frames([shapes(scene / "map.blk", scene)], None, "block")
    axis = figure.axes[0]
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())
    for place, white in (((3, 2), True), ((7, 7), False), ((1, 1), False), ((-0.3, 5), True)):
        x, y = axis.transData.transform(place)
        assert (pixels[int(pixels.shape[0] - y), int(x), :3] == 255).all() == white, place


def test_loops_of_a_polygon_with_seams_are_its_holes():
    """Two triangles in a square, one joined to the other."""
    square, first, second = [(0, 0), (9, 0), (9, 9), (0, 9)], [(1, 1), (1, 2), (2, 1)], [(3, 3), (3, 4), (4, 3)]
    polygon = np.array([*square[:1], first[0], first[1], first[2], second[0], *second[1:], second[0], first[2], first[0], *square],
                       float)
    loops = [set(map(tuple, polygon[loop])) for loop in loops_of(polygon)]
    assert sorted(map(len, loops)) == [3, 3, 4] and set(square) in loops and set(first) in loops and set(second) in loops
    assert len(loops_of(np.array(square, float))) == 1


@pytest.mark.parametrize("name", ["map.geo", "map.ana", "covered.ana"])
def test_joint_edges_have_the_length_of_the_joints(name, scene, tmp_path):
    """Boundary once, joints from both sides, the hole from one; no seam, no line of the mesh."""
    edges = shapes(scene / name, tmp_path).joint_edges(0)
    length = {material: np.linalg.norm(edge[:, 1] - edge[:, 0], axis=1).sum() for material, edge in edges.items()}
    assert length == {1: pytest.approx(40, rel=1e-12), 2: pytest.approx(20, rel=1e-12), 3: pytest.approx(8 + 16, rel=1e-12)}


@pytest.mark.parametrize("name", ["map.geo", "map.ana", "covered.ana", "run.h5"])
def test_points_are_those_of_the_deck(name, scene, tmp_path):
    kinds, places = shapes(scene / name, tmp_path).points(0)
    assert list(kinds) == [1, 1, 2, 3]
    np.testing.assert_allclose(places, [[1, 1], [9, 1], [5, 9], [5, 5]], atol=1e-12)


def test_points_and_covers_move_with_their_elements(scene):
    run = shapes(scene / "run.h5", scene)
    measured, frame = scree.read(scene / "run.h5").measured_points.position[-1, 0], len(run.times) - 1
    assert np.abs(measured - [5, 5]).max() > 1e-6
    np.testing.assert_allclose(run.points(frame)[1][-1], measured, rtol=0, atol=1e-12)
    places, _ = run.covers(frame)
    start, _ = run.covers(0)
    assert np.abs(places - start).max() > 1e-6


def test_covers_are_nodes_of_the_mesh(scene, tmp_path):
    places, follows = shapes(scene / "covered.ana", tmp_path).covers(0)
    lattice = places @ np.linalg.inv(1.1 * np.array([[1, 0], [0.5, np.sqrt(0.75)]]))
    np.testing.assert_allclose(lattice, np.round(lattice), atol=1e-9)
    assert len(follows) == len(places) and 0 < follows.sum() < len(places)


def test_what_is_drawn_is_what_was_asked_for(scene, tmp_path):
    files = [shapes(scene / name, tmp_path) for name in ("map.blk", "covered.ana", "run.h5")]
    figure = tool.draw_frames(files[:1], None, "material", [tool.draw_joints, tool.draw_points, tool.draw_numbers])
    axis = figure.axes[0]
    fills = [c for c in axis.collections if isinstance(c, PathCollection)]
    assert [len(c.get_paths()) for c in fills] == [3]
    assert list(fills[0].get_array()) == [2 if abs(area(path) - 4) < 1e-9 else 1 for path in fills[0].get_paths()]
    assert len([c for c in axis.collections if isinstance(c, LineCollection)]) == 3
    assert [len(line.get_xdata()) for line in axis.lines] == [2, 1, 1]
    assert [text.get_text() for text in axis.get_legend().get_texts()] == [
        "rock 1", "rock 2", "joint 1", "joint 2", "joint 3", "fixed point", "load point", "measured point"]
    for number, text in enumerate(axis.texts, 1):
        assert text.get_text() == str(number) and holds(fills[0].get_paths()[number - 1], text.xy)

    figure = tool.draw_frames(files, None, "block", [tool.draw_numbers])
    assert len(figure.axes) == 7 and sum(axis.get_visible() for axis in figure.axes) == 5  # 3 x 2 panels, colour bar
    assert {text.get_text() for text in figure.axes[2].texts} == {"1", "2", "3"}

    figure = tool.draw_frames(files[1:2], None, "block", [tool.draw_covers])
    places, follows = files[1].covers(0)
    assert [len(line.get_xdata()) for line in figure.axes[0].lines] == [(~follows).sum(), follows.sum()]
    for limits, coordinate in ((figure.axes[0].get_xlim(), places[:, 0]), (figure.axes[0].get_ylim(), places[:, 1])):
        assert limits[0] < coordinate.min() and coordinate.max() < limits[1]


def test_errors_are_one_line_and_status_2(scene, tmp_path):
    (tmp_path / "wrong.geo").write_text("0.001\n3 x\n")
    for words, expected in (([tmp_path / "none.geo"], "none.geo"), ([tmp_path / "none.ana"], "none.ana"),
                            ([tmp_path / "wrong.geo"], "wrong.geo:2"),
                            ([scene / "map.geo", "--field", "major"], "--field block or material"),
                            ([scene / "map.geo", "--covers"], "--covers"), ([scene / "map.ana", "--covers"], "manifold elements"),
                            ([scene / "map.geo", "--frames", "1"], "0 to 0"),
                            ([scene / "map.geo", "--history", "area"], "--history"),
                            ([scene / "map.geo", "--scree", tmp_path / "no"], "expected the program")):
        done = subprocess.run([TOOL, "--scree", SCREE, *words, "-o", tmp_path / "p.png"], capture_output=True, text=True)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, (words, done.stderr)
        assert done.stderr.startswith("tools/plot: ") and not (tmp_path / "p.png").exists()


def test_the_name_of_a_geometry_may_be_in_capitals(tmp_path):
    """As the program takes it."""
    (tmp_path / "MAP.GEO").write_text(GEOMETRY)
    done = plot(tmp_path / "MAP.GEO")
    assert done.returncode == 0 and done.stdout == f"{tmp_path / 'MAP.png'}\n", done.stderr
    assert tool.kind_of("MAP.ANA") == "analysis" and tool.kind_of("RUN.H5") == "results"
