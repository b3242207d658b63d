"""tools/bench: its scenes, the factorisation that times are held against, its tables. Figures are printed, not judged."""
import json
import math
import os
import pathlib
import re
import subprocess
import types

import numpy as np
import pytest
import scree
from scree import block_files
from scree.bench import cutting, factorisation, scenes, settling, tables
from scree.errors import ScreeError
from scree.polygons import deepest_overlap
from shapely.geometry import LineString, Polygon, box
from shapely.ops import polygonize, unary_union

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOLS = SOURCE / "tools"
FACTOR = pathlib.Path(SCREE).parent / "bench_factor"


def bench(*words, **options):
    return subprocess.run([TOOLS / "bench", *map(str, words)], capture_output=True, text=True, **options)


def area(corners):
    x, y = np.asarray(corners).T
    return 0.5 * np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)


# Scenes

@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("make, size, count", [
    (scenes.wall, 10, 106), (scenes.wall, 20, 411), (scenes.column, 100, 101), (scenes.column, 16, 17), (scenes.pyramid, 10, 56)])
def test_boxes_of_a_scene_lie_flush(make, size, count, edge):
    """Their number is that of the formula; whole or half squares, which touch and do not overlap but for rounding."""
    scene = make(size, edge)
    assert len(scene.corners) == count
    assert deepest_overlap(scene.corners) < 1e-12 * edge
    areas = {round(area(corners) / edge**2, 9) for corners in scene.corners[1:]}
    assert areas == ({1.0, 0.5} if make is scenes.wall else {1.0})


def test_walls_have_as_many_blocks_as_their_name_says():
    assert [len(scenes.wall(n).corners) for n in (40, 80)] == [1621, 6441]


def test_a_column_slides_on_its_base_and_is_four_times_as_high_as_wide():
    scene = scenes.column(64)
    base, blocks = (block_files.turned(np.concatenate(part), math.radians(25)) for part in (scene.corners[:1], scene.corners[1:]))
    assert np.ptp(blocks, axis=0) == pytest.approx([0.2, 0.8], rel=1e-12)
    assert base[:, 1].max() == pytest.approx(blocks[:, 1].min(), abs=1e-12)
    assert scene.mu < math.tan(math.radians(25))
    with pytest.raises(ScreeError, match="four times a square"):
        scenes.column(50)


@pytest.mark.parametrize("scene", [
    scenes.wall(3), scenes.column(16), scenes.pyramid(4), scenes.rock("dda", 1), scenes.rock("nmm", 1), scenes.slope("g4", False),
    scenes.slope("reg", True), scenes.slope("big", False), scenes.tunnel(6.0)], ids=lambda scene: scene.name)
def test_a_scene_is_one_that_scree_takes(scene, tmp_path):
    """Without blocks that cross or float; those of boxes are as many as were made."""
    done = scree.call("check", *scene.write(tmp_path, 0.005))
    assert done.returncode == 0, done.stderr
    assert "touch nothing that is held    none" in done.stdout
    blocks = int(done.stdout.split()[0])
    if isinstance(scene, scenes.Boxes):
        assert blocks == len(scene.corners)
    elif isinstance(scene, scenes.Slope):
        assert blocks == {"g4": 7, "reg": 37, "big": 697}[scene.deck]


def test_the_wall_is_that_of_the_validation_case(tmp_path):
    """The same blocks and numbers, but for the size of the step."""
    text, (blocks, deck) = (SOURCE / "input/validation/m9-wall/wall.ana").read_text(), scenes.wall(10).write(tmp_path, 0.01)
    assert blocks.read_text().splitlines()[1:] == block_files.wall(10).splitlines()[1:]
    asked = [float(word) for line in text.splitlines() if not line.startswith("&")
             for word in line.split("!")[0].split()]
    written = [float(word) for line in deck.read_text().splitlines() if not line.startswith("&") for word in line.split()]
    assert written == pytest.approx(asked, rel=1e-15)


def test_the_slope_of_many_blocks_is_drawn_by_its_joint_deck(tmp_path):
    """Window, slope and joints; what was added by hand is e0 and three lines that are fixed."""
    done = scree.call("joints", SOURCE / "input/bench/slope/big.joints", "-o", tmp_path / "big.geo")
    assert done.returncode == 0, done.stderr

    def lines(path):
        rows = (line.split() for line in path.read_text().splitlines() if not line.startswith("!"))
        return [list(map(float, row)) for row in rows if len(row) == 5]

    drawn = lines(tmp_path / "big.geo")
    assert len(drawn) == 335 and lines(SOURCE / "input/bench/slope/big.geo") == drawn


# The factorisation

def test_a_pattern_is_the_lower_triangle_of_its_cliques():
    cliques = [np.array([0, 1, 2]), np.array([5, 2]), np.array([], int), np.array([4])]
    dense = np.eye(6, dtype=bool)
    for clique in cliques:
        dense[np.ix_(clique, clique)] = True
    first, row = factorisation.pattern(cliques, 6)
    for column in range(6):
        assert row[first[column]:first[column + 1]].tolist() == (column + np.flatnonzero(dense[column:, column])).tolist()


@pytest.mark.parametrize("cliques, n, entries, factor_entries", [
    ([], 5, 5, 5),                                                  # diagonal
    ([np.arange(40)], 40, 820, 820),                                # full: n (n + 1)/2
    ([[i, i + 1] for i in range(49)], 50, 99, 99),                  # a chain fills nothing
    ([[0, i] for i in range(1, 50)], 50, 99, 99)], ids=["diagonal", "full", "chain", "star"])
def test_a_factor_has_as_many_entries_as_theory_says(cliques, n, entries, factor_entries):
    """Whatever the numbering: a tree has a factor without fill."""
    found = factorisation.factorise(FACTOR, *factorisation.pattern(cliques, n))
    assert (found.unknowns, found.entries, found.factor_entries) == (n, entries, factor_entries)
    assert found.seconds > 0 and found.analysis > 0 and found.solution > 0


def test_what_is_no_matrix_is_refused():
    for data in (b"", b"\0" * 16, np.array([3, 9], np.int64).tobytes() + b"\1" * 8):
        done = subprocess.run([FACTOR], input=data, capture_output=True)
        assert done.returncode == 2 and done.stderr.startswith(b"bench_factor: ") and not done.stdout


def matrix_of(scene, folder, *settings):
    """First entries of the columns and rows of the matrix of a scene, as set up."""
    decks = scene.write(folder, 0.005)
    return factorisation.pattern_of_run(scree.run(*decks, output=folder / "r.h5", settings=["step.count=1", *settings]))


def test_the_matrix_of_a_wall_couples_the_blocks_that_touch(tmp_path):
    """Six unknowns a block, none of the base; each pair of blocks that share a piece of side, by GEOS, adds 36 entries."""
    scene = scenes.wall(4)
    blocks = [Polygon(corners) for corners in scene.corners[1:]]
    touching_pairs = sum(p.intersection(q).length > 1e-9 for i, p in enumerate(blocks) for q in blocks[:i])
    first, row = matrix_of(scene, tmp_path)
    assert len(first) - 1 == 6 * len(blocks)
    assert len(row) == 21 * len(blocks) + 36 * touching_pairs


def test_the_matrix_of_a_column_couples_blocks_that_share_a_corner_too(tmp_path):
    """2 x 8 blocks: 8 pairs across, 14 up, 14 of a corner. Those of the base are no unknowns."""
    first, row = matrix_of(scenes.column(16), tmp_path)
    assert len(first) - 1 == 96 and len(row) == 21 * 16 + 36 * (8 + 14 + 14)


def test_the_matrix_of_a_manifold_has_the_unknowns_of_its_covers(tmp_path):
    """A square under a mesh, two unknowns a cover; three fixed points in one element take those of its covers."""
    free = {}
    for name, fixed in (("free", []), ("held", [(5.0, 4.0), (5.1, 4.0), (5.0, 4.1)])):
        geometry, deck = tmp_path / f"{name}.blk", tmp_path / f"{name}.ana"
        geometry.write_text(block_files.block_file(name, [(1, block_files.box(0, 10, 0, 10))], [(*x, 1) for x in fixed]))
        deck.write_text("1 1 1 1 0.05 0.001\n2500 0 1e9 0.25\n0 0 0 0 0 0 0 0 0\n30 0 0\n&deck dialect='short' /\n"
                        "&method model='nmm' /\n&cover edge=4.0 /\n")
        r = scree.run(geometry, deck, output=tmp_path / f"{name}.h5")
        elements, free[name] = factorisation.unknowns_of_elements(r)
        covers = 2 * len(np.unique(r.covers.of_element))
        if fixed:
            assert len(set(r.points.element)) == 1  # else the points of this test are badly put
            assert len(elements[r.points.element[0] - 1]) == 0
        else:
            assert free["free"] == covers and all(len(unknowns) == 6 for unknowns in elements)
        assert set(np.concatenate(elements).astype(int)) == set(range(free[name]))
    assert free["held"] == free["free"] - 6


# Rows and tables

def row_of_figures(dissipated, area=2.0, height=3.0):
    """The energy gain of a run of two blocks, the second of material 2 and as high as said."""
    polygons = [np.array([(0, -9), (1, -9), (1, 0), (0, 0)]), np.array([(0, 0), (1, 0), (1, height), (0, height)])]
    r = types.SimpleNamespace(
        material=np.array([1, 2]), block=np.array([1, 2]), polygons=lambda frame: polygons,
        bodies=types.SimpleNamespace(area=np.array([[9.0, area]])),
        history=types.SimpleNamespace(time=np.arange(1.0, 1 + len(dissipated)),
                                      energy=types.SimpleNamespace(dissipated=np.array(dissipated))))
    return settling.largest_gain(r, scenes.Boxes("two", "two", 1, 1.0, 1.0, weight=10.0))


def test_energy_that_a_step_makes_is_held_against_weight_times_height():
    assert row_of_figures([0.0, 1.0, 0.4, 0.7]) == pytest.approx(0.6 / (10.0 * 2.0 * 3.0))
    assert row_of_figures([-0.3, 0.1]) == pytest.approx(0.3 / 60.0)  # in the first step
    assert row_of_figures([0.0, 0.1]) == 0.0 and row_of_figures([]) is None


def test_a_row_says_what_the_results_say(tmp_path):
    """In the table and in JSON, whose ratio is that of its own figures."""
    done = bench("wall", "--sizes", 2, 3, "--end", 0.02, "--scree", SCREE, "--json", tmp_path / "it.json", "--keep", tmp_path,
                 "--set", "contact.restitution=0")
    assert done.returncode == 0, done.stderr
    written = json.loads((tmp_path / "it.json").read_text())
    assert written["command"][0] == "wall" and written["settings"] == ["contact.restitution=0"] and written["machine"]["processor"]
    assert written["scree"]["program"] == SCREE and written["scree"]["blas"] and written["scree"]["version"].startswith("scree")
    head, *lines = done.stdout.splitlines()
    for row, line, (name, blocks) in zip(written["rows"], lines, (("wall2", 6), ("wall3", 11)), strict=True):
        r = scree.read(tmp_path / f"{name}.h5")
        assert any(re.match(r"contact\.restitution *= *0", text) for text in r.scene.settings), r.scene.settings
        assert (row["scene"], row["blocks"], row["steps_asked"], row["status"]) == (name, blocks, 4, "complete")
        assert row["steps"] == len(r.history.time) >= 4 and row["cuts"] == r.history.rejected.sum()
        assert row["solves"] == r.history.solves.sum() and row["overlap"] == r.history.overlap.max()
        assert row["time"] == pytest.approx(0.02) and row["seconds"] == r.seconds("steps", "processor")
        assert row["ratio"] == pytest.approx(1000 * row["seconds"] / row["factor_ms"])
        assert row["unknowns"] == 6 * (blocks - 1) and row["megabytes"] > 1
        assert line.split()[:4] == [name, str(blocks), "4", str(row["steps"])]
    assert "growth" not in written["rows"][0] or written["rows"][0]["growth"] is None
    first, second = written["rows"]
    assert second["growth"] == pytest.approx(math.log(second["seconds"] / first["seconds"]) / math.log(11 / 6))
    assert head.split()[:4] == ["scene", "blocks", "asked", "made"]


def test_a_run_beyond_the_limit_is_stopped_and_its_row_says_so(tmp_path):
    """20 million steps do not fit into a second, of blocks that sleep neither."""
    done = bench("wall", "--sizes", 6, "--end", 100000, "--limit", 1, "--scree", SCREE, "--json", tmp_path / "it.json")
    assert done.returncode == 0, done.stderr
    row, = json.loads((tmp_path / "it.json").read_text())["rows"]
    assert row["ended"] == "interrupted" and 0 < row["time"] < 100000 and done.stdout.splitlines()[1].endswith("interrupted")


def test_what_is_wrong_is_said_in_one_line(tmp_path):
    for words, expected in ((["wall", "--sizes", 2, "--set", "contact.nonsense=1"], "nonsense"),
                            (["column", "--sizes", 50], "four times a square"),
                            (["wall", "--sizes", 2, "--end", 0.01, "--json", tmp_path / "none" / "it.json"], "cannot write")):
        done = bench(*words, "--scree", SCREE)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr


@pytest.mark.parametrize("words, names", [
    (["rock", "--kinds", "dda", "nmm", "--seeds", 1, "--end", 0.005], ["dda, seed 1", "nmm, seed 1"]),
    (["slope", "--decks", "g4", "--end", 0.01], ["g4, dynamic", "g4, static"]),
    (["tunnel", "--spacings", 8], ["tunnel8"]), (["pyramid", "--sizes", 3, "--end", 0.01], ["pyramid3"]), (["column", "--sizes", 4, "--end", 0.01], ["column4"])],
    ids=lambda words: words[0] if isinstance(words[0], str) else "")
def test_every_case_prints_its_scenes(words, names):
    done = bench(*words, "--limit", 20, "--scree", SCREE)
    assert done.returncode == 0, done.stderr
    assert [line[:25].strip() for line in done.stdout.splitlines()[1:]] == names


def test_a_table_has_dashes_where_there_is_no_figure(capsys, tmp_path):
    table = tables.Table([("name", "name", "", -6), ("n", "n", "d", 4), ("x", "x", ".1f", 5)])
    table.add({"name": "one", "n": 3, "x": None})
    table.add({"name": "two", "x": 0.25})
    assert capsys.readouterr().out == "name       n      x\none        3      -\ntwo        -    0.2\n"
    table.write(tmp_path / "it.json", case="it")
    written = json.loads((tmp_path / "it.json").read_text())
    assert written["case"] == "it" and written["rows"] == [{"name": "one", "n": 3, "x": None}, {"name": "two", "x": 0.25}]


# Single features

def tables_of_cutting(*words):
    """The tables of the case cutting, of lines, traces and covers: lists of rows of words."""
    done = subprocess.run([TOOLS / "bench", "cutting", "--scree", SCREE, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [[line.split() for line in table.splitlines()[1:]] for table in done.stdout.split("\n\n")]


def test_the_bench_cuts_as_many_blocks_as_there_are_faces():
    rows, *_ = tables_of_cutting("--lines", 50, 400, "--traces", "--covers", "--seed", 7)
    assert [row[0] for row in rows] == ["50", "400"]
    for n, found in zip((50, 400), rows):
        lines = [LineString(line.reshape(2, 2)) for line in cutting.joint_map(n, 6, 7)]
        assert int(found[1]) == len(list(polygonize(unary_union(lines))))


def test_the_bench_finds_the_islands_of_traces():
    _, rows, _ = tables_of_cutting("--lines", "--traces", 300, "--covers", "--seed", 3)
    lines = cutting.trace_map(300, 3)
    rock = Polygon(lines[:4, :2])  # what traces enclose beyond it is no block
    faces = [face for face in polygonize(unary_union([LineString(line.reshape(2, 2)) for line in lines]))
             if rock.contains(face.representative_point())]
    assert [row[:3] for row in rows] == [["300", str(len(faces)), str(max(len(face.interiors) for face in faces))]]


def test_the_bench_cuts_as_many_elements_as_triangles_meet_the_square():
    *_, rows = tables_of_cutting("--lines", "--traces", "--covers", 30, 500)
    for n, found in zip((30, 500), rows):
        edge = cutting.edge_for(n)
        corner = edge * np.array([[0, 0], [1, 0], [0.5, np.sqrt(0.75)], [1.5, np.sqrt(0.75)]])
        reach = range(-int(2 / edge) - 2, int(2 / edge) + 2)
        triangles = [Polygon(corner[list(corners)] + i * corner[1] + j * corner[2])
                     for i in reach for j in reach for corners in ((0, 1, 2), (1, 3, 2))]
        # 1e-9 is above the rounding of a triangle that touches, 1e-15, and below any part here, 1e-5
        assert int(found[0]) == sum(triangle.intersection(box(0, 0, 1, 1)).area > 1e-9 for triangle in triangles)


def test_lines_of_the_bench_cross_as_often_as_asked():
    """Less the share whose middle would lie beyond a side, for both lines and four sides 8 E[max(0, u L |cos|)] = 2 L / pi."""
    n, crossings = 3000, 6
    length = np.sqrt(np.pi * crossings / (2 * n))
    lines = cutting.joint_map(n, crossings, 1)[4:]
    a, b = lines[:, None, :2], lines[:, None, 2:]
    c, d = lines[None, :, :2], lines[None, :, 2:]

    def turn(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    cross = (turn(a, b, c) * turn(a, b, d) < 0) & (turn(c, d, a) * turn(c, d, b) < 0)
    # drawn: some 9000 crossings, 1 % of scatter if they were independent
    assert cross.sum() / n == pytest.approx(crossings * (1 - 2 * length / np.pi), rel=0.03)


def test_growth_is_the_exponent_of_n():
    rows = [(10, 3.0), (100, 300.0), (1000, 0.0)]
    exponents = tables.growth(rows, lambda row: row[1])
    assert np.isnan(exponents[0]) and exponents[1] == pytest.approx(2, rel=1e-12) and np.isnan(exponents[2])
    assert tables.growth([(10,), (100,)], tables.n_log_n)[1] == pytest.approx(1 + np.log10(2), rel=1e-12)
