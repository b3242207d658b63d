"""tools/cost_of_accuracy --run-out: both schemes on one deck, in ensembles."""
import csv
import math
import os
import pathlib
import subprocess
import types

import numpy as np
import pytest
from scree import block_files
from scree.accuracy import ensembles
from scree.errors import ScreeError

SCREE = os.environ["SCREE"]
TOOL = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tools" / "cost_of_accuracy"
G = 9.81


def rows_of(folder, *given):
    """The rows of a study by scheme and setting, and what was printed."""
    done = subprocess.run([TOOL, *map(str, given), "--run-out", "--scree", SCREE, "--folder", folder, "--jobs", "1"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    with open(folder / "run-out.csv") as f:
        return {(row["scheme"], row["knob"]): row for row in csv.DictReader(f)}, done.stdout


def slide(folder, words=""):
    """Two blocks of 1 m, far apart, slide for half a second down a slope of 30 degrees whose friction angle is 17 degrees."""
    base, *blocks = (block_files.turned(corners, -math.pi / 6) for corners in (
        block_files.box(-10, 10, -1, 0), block_files.box(-8, -7, 0, 1), block_files.box(0, 1, 0, 1)))
    (folder / "slide.blk").write_text(block_files.block_file("slide", [(1, base), *((2, one) for one in blocks)], block_files.held(base, 1)))
    rest = "0 0 0 0 0 0 0 0 0"
    (folder / "slide.ana").write_text(f"1 50 2 1 0.05 0.01\n2500 0 1e10 0.25 {rest}\n2500 24525 1e10 0.25 {rest}\n17 0 0\n"
                                      f"&deck geometry='slide.blk', dialect='short' /\n{words}")
    return folder / "slide.ana"


@pytest.mark.parametrize("words", ["", "&integrator scheme='small_steps' /\n"])
def test_both_schemes_slide_as_far_as_newton_says(tmp_path, words):
    rows, printed = rows_of(tmp_path / "out", slide(tmp_path, words), "--runs", 2, "--steps", 1, 2, "--contacts", "deck", "0.1",
                            "--tolerances", "deck", "--accuracies", "0.03", "0.01")
    way = 0.5 * G * (math.sin(math.pi / 6) - math.tan(math.radians(17)) * math.cos(math.pi / 6)) * 0.5**2
    assert list(rows) == [("implicit", "as it is"), ("implicit", "step 2 x"), ("implicit", "contact 0.1 x"),
                          ("small steps", "accuracy 0.03"), ("small steps", "accuracy 0.01")]
    for row in rows.values():
        assert row["runs"] == "2" and float(row["seconds"]) > 0
        assert float(row["mean"]) == pytest.approx(way, rel=3e-3) and float(row["farthest"]) == pytest.approx(way, rel=3e-3)
    assert "2 of 3 blocks move" in printed  # the base stays
    assert (tmp_path / "out" / "slide-run-out.png").stat().st_size > 10_000


def test_a_study_that_is_repeated_keeps_its_runs(tmp_path):
    given = [slide(tmp_path), "--runs", 1, "--steps", 1, "--contacts", "deck", "--tolerances", "deck", "--accuracies", "0.03"]
    first, _ = rows_of(tmp_path / "out", *given)
    again, _ = rows_of(tmp_path / "out", *given)
    assert first == again and len(list((tmp_path / "out" / "slide" / "runs").glob("*.json"))) == 2


@pytest.mark.parametrize("words, said", [
    ("&contact method='augmented' /\n", "contact.method"), ("&method model='nmm' /\n&cover edge=1 /\n", "method.model")])
def test_a_deck_that_small_steps_refuse_is_refused(tmp_path, words, said):
    done = subprocess.run([TOOL, slide(tmp_path, words), "--run-out", "--scree", SCREE, "--folder", tmp_path / "out"],
                          capture_output=True, text=True)
    assert done.returncode != 0 and said in done.stderr and len(done.stderr.strip().splitlines()) == 1


# What runs came to

def run_out(**runs):
    """Ensembles of runs by their displacements; a run without them did not end."""
    records = [(ensembles.Member(*name.split("/"), None), ways) for name, many in runs.items() for ways in many]
    found = []
    for number, (choice, ways) in enumerate(records):
        record = {"ended": "stopped after 1 s"}
        if ways is not None:
            record = {"ended": "complete", "seconds": [2.0 + number], "values": {"displacement": ways, "overlap": [0.1]}}
        found.append(types.SimpleNamespace(choice=choice, record=record))
    return types.SimpleNamespace(scene=types.SimpleNamespace(name="a deck", text="of a test"), runs=found)


@pytest.fixture(autouse=True)
def kept(monkeypatch):
    monkeypatch.setattr(ensembles, "recorded", lambda run: run.record)


IMPLICIT, COARSE, FINE = "implicit/as it is", "small steps/accuracy 0.03", "small steps/accuracy 0.003"


def test_the_reference_is_the_mean_of_the_best_of_both_schemes():
    found = ensembles.RunOut(run_out(**{IMPLICIT: [[0, 9.0], [0, 11.0]], COARSE: [[0, 20.0]], FINE: [[0, 12.0], [0, 12.0]]}))
    assert found.reference["mean"] == (pytest.approx(11.0), pytest.approx(1.0))  # half of what they differ by
    rows = {row["knob"]: row for row in found.rows}
    assert rows["as it is"]["error: mean"] == pytest.approx(-1 / 11)
    assert rows["as it is"]["spread: mean"] == pytest.approx(math.sqrt(2)) and rows["as it is"]["doubt: mean"] == pytest.approx(1 / 11)
    assert rows["accuracy 0.03"]["error: mean"] == pytest.approx(9 / 11)


def test_scatter_of_runs_is_doubt_of_the_reference():
    ways = np.random.default_rng(1).normal(10.0, 1.0, (2, 400))
    found = ensembles.RunOut(run_out(**{IMPLICIT: [[0, way] for way in ways[0]], FINE: [[0, way] for way in ways[1]]}))
    value, doubt = found.reference["mean"]
    assert doubt == pytest.approx(1 / math.sqrt(800), rel=0.6) and abs(value - 10) < 4 * doubt


def test_a_scheme_that_does_not_end_leaves_the_other_one():
    found = ensembles.RunOut(run_out(**{IMPLICIT: [None], COARSE: [[0, 20.0]], FINE: [[0, 12.0]]}))
    assert found.reference["farthest"] == (12.0, 0.0)
    assert [row["runs"] for row in found.rows] == [0, 1, 1] and found.rows[0]["ended"] == "stopped after 1 s"


def test_blocks_that_stay_are_not_counted():
    found = ensembles.RunOut(run_out(**{IMPLICIT: [[1e-5, 10.0, 0.02, 30.0]], FINE: [[1e-5, 10.0, 0.02, 30.0]]}))
    assert found.moves.tolist() == [False, True, False, True]
    assert found.reference["mean"][0] == pytest.approx(20.0)


def test_there_is_no_answer_without_runs_or_motion():
    with pytest.raises(ScreeError, match="runs that end"):
        ensembles.RunOut(run_out(**{IMPLICIT: [None]}))
    with pytest.raises(ScreeError, match="blocks move"):
        ensembles.RunOut(run_out(**{IMPLICIT: [[0.0, 0.0]]}))
