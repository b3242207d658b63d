"""The tools around the program: plot, and the comparison with the paper."""
import os
import pathlib
import re
import subprocess

import h5py
import numpy as np
import pytest
import scree
from scree import bench
from shapely.geometry import LineString, Polygon, box
from shapely.ops import polygonize, unary_union

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOLS = SOURCE / "tools"


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    for name in ("t1", "t4"):
        scree.run(SOURCE / f"input/paper/rotation/{name}.ana", output=folder / f"{name}.h5")
    return folder


def plot(*words):
    return subprocess.run([TOOLS / "plot", *words], capture_output=True, text=True)


@pytest.mark.parametrize("words", [
    [], ["--frames", "all", "--field", "stress_xx"], ["--frames", "0", "-1", "--field", "major"], ["--field", "displacement"],
    ["--history", "rotation", "momentum", "energy/strain", "solves"]])
def test_plot_makes_a_picture_of_one_or_more_files(words, results, tmp_path):
    for files in (["t4.h5"], ["t1.h5", "t4.h5"]):
        picture = tmp_path / "p.png"
        done = plot(*[results / file for file in files], *words, "-o", picture)
        assert done.returncode == 0, done.stderr
        assert picture.read_bytes().startswith(b"\x89PNG") and picture.stat().st_size > 5000


def test_plot_says_what_is_wrong_in_one_line(results, tmp_path):
    (tmp_path / "text.h5").write_text("no HDF5")
    with h5py.File(tmp_path / "other.h5", "w") as f:
        f["x"] = 1
    for words, expected in (([tmp_path / "none.h5"], "found"), ([tmp_path / "text.h5"], "expected a results file"),
                            ([tmp_path / "other.h5"], "another HDF5 file"), ([results / "t4.h5", "--frames", "101"], "0 to 100"),
                            ([results / "t4.h5", "--history", "weather"], "deformation_iterations"),
                            ([results / "t4.h5", "-o", tmp_path / "no" / "p.png"], "cannot write")):
        done = plot(*words)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr


def test_every_number_of_the_paper_is_met():
    done = subprocess.run([TOOLS / "paper", "rotation", "--scree", SCREE], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "every number is met" in done.stdout


def test_a_miss_is_seen(tmp_path):
    """A program that runs other decks than it is asked for must miss."""
    wrong = tmp_path / "wrong"
    wrong.write_text(f'#!/bin/sh\nshift; shift\nexec {SCREE} run {SOURCE}/input/paper/rotation/t4.ana "$@"\n')
    wrong.chmod(0o755)
    done = subprocess.run([TOOLS / "paper", "rotation", "--scree", wrong], capture_output=True, text=True)
    assert done.returncode == 1 and "MISS" in done.stdout


def test_the_python_of_the_manual_runs(results, tmp_path):
    """The example of doc/results.md."""
    code = re.search(r"```python\n(.*?)```", (SOURCE / "doc/results.md").read_text(), re.S).group(1)
    done = subprocess.run(["/usr/bin/python3", "-c", code], cwd=results, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(TOOLS)})
    assert done.returncode == 0, done.stderr


def test_the_bench_prints_every_method():
    """Its figures are printed, not judged; that it runs and that the errors are those of the theory is."""
    done = subprocess.run([TOOLS / "bench", "accuracy", "--scree", SCREE, "--turns", "1"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    errors = [float(line[41:52]) for line in done.stdout.splitlines()[1:]]
    # small strain w^2 dt t; the mid-step rotation 2 atan(a/2) - a, relative; the printed digits
    assert errors[:2] == [39, 3.9] and errors[-3:] == [1, 0.033, 0.00033]


def cutting(*words):
    """Both tables of the case cutting: lists of rows of words."""
    done = subprocess.run([TOOLS / "bench", "cutting", "--scree", SCREE, *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [[line.split() for line in table.splitlines()[1:]] for table in done.stdout.split("\n\n")]


def test_the_bench_cuts_as_many_blocks_as_there_are_faces():
    rows, _ = cutting("--lines", 50, 400, "--covers", "--seed", 7)
    assert [row[0] for row in rows] == ["50", "400"]
    for n, found in zip((50, 400), rows):
        lines = [LineString(line.reshape(2, 2)) for line in bench.joint_map(n, 6, 7)]
        assert int(found[1]) == len(list(polygonize(unary_union(lines))))


def test_the_bench_cuts_as_many_elements_as_triangles_meet_the_square():
    _, rows = cutting("--lines", "--covers", 30, 500)
    for n, found in zip((30, 500), rows):
        edge = bench.edge_for(n)
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
    lines = bench.joint_map(n, crossings, 1)[4:]
    a, b = lines[:, None, :2], lines[:, None, 2:]
    c, d = lines[None, :, :2], lines[None, :, 2:]

    def turn(p, q, r):
        return (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])

    cross = (turn(a, b, c) * turn(a, b, d) < 0) & (turn(c, d, a) * turn(c, d, b) < 0)
    # drawn: some 9000 crossings, 1 % of scatter if they were independent
    assert cross.sum() / n == pytest.approx(crossings * (1 - 2 * length / np.pi), rel=0.03)


def test_growth_is_the_exponent_of_n():
    rows = [(10, 3.0), (100, 300.0), (1000, 0.0)]
    exponents = bench.growth(rows, lambda row: row[1])
    assert np.isnan(exponents[0]) and exponents[1] == pytest.approx(2, rel=1e-12) and np.isnan(exponents[2])
    assert bench.growth([(10,), (100,)], bench.n_log_n)[1] == pytest.approx(1 + np.log10(2), rel=1e-12)
