"""The tools around the program: plot, and the comparison with the paper."""
import os
import pathlib
import re
import subprocess

import h5py
import pytest
import scree

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
