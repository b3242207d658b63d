"""What `scree estimate` tells of runs that nobody has made yet."""
import os
import pathlib
import re

import pytest
import scree
from scree import call
from scree.bench import scenes

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
ARC = SOURCE / "input/paper/arc/arc.ana"


def told(tmp_path, *words):
    """The rows of an estimate, by their names: steps, seconds, least, most, MB; and by what."""
    done = call("estimate", *words, cwd=tmp_path, env={**os.environ, "TMPDIR": str(tmp_path)})
    assert done.returncode == 0, done.stderr
    rows = {}
    for line in done.stdout.splitlines()[1:]:
        if "leave out" in line:
            continue
        name, *numbers, by = re.fullmatch(r"(.{16}) *(\d+) +(\S+) +(\S+) +(\S+) +(\d+)  (.*)", line).groups()
        rows[name.strip()] = [float(number) for number in numbers], by
    return rows


def test_runs_that_end_are_known(tmp_path):
    rows = told(tmp_path, ARC, "--accuracy", "1e-2", "1e-3", "--set", "step.size=2e-3")
    assert list(rows) == ["small steps", "as it is", "accuracy 1e-2", "accuracy 1e-3"]
    for name, settings in (("as it is", []), ("accuracy 1e-3", ["step.accuracy=1e-3"])):
        run = scree.run(ARC, output=tmp_path / "x.h5", settings=["step.size=2e-3", *settings])
        (steps, seconds, least, most, memory), by = rows[name]
        assert (steps, by) == (len(run.history.time), "the whole run")
        assert 0 < seconds == least == most and 5 < memory < 1000
    assert {path.name for path in tmp_path.iterdir()} == {"x.h5"}  # a probe leaves nothing


def test_a_long_run_is_told_by_its_beginning(tmp_path):
    """A wall at rest for 200 s, kept awake, by both schemes. All its steps are foreseen; the range of what they take is how the pace changes."""
    decks = scenes.wall(6, end=200.0).write(tmp_path, 1e-3)
    rows = told(tmp_path, *decks, "--set", "step.sleep=0")
    for (steps, seconds, least, most, _), by in rows.values():
        assert steps == pytest.approx(200_000, rel=1e-3)
        assert re.fullmatch(r"\d+ steps, \S+ % of the run( and a whole one in longer steps)?", by)
        assert 0 < least <= seconds <= most


@pytest.mark.parametrize("words, said", [
    ([ARC, "--accuracy", "x"], "step.accuracy"),
    ([ARC, "--accuracy"], "expected a word after --accuracy"),
    ([ARC, "--summary", "json"], "expected --summary with run, found it with estimate"),
    ([ARC, "--set", "step.size=-1"], "step.size"),
    (["nothing.ana"], "nothing.ana")])
def test_what_cannot_be_is_refused_in_a_line(tmp_path, words, said):
    done = call("estimate", *words, cwd=tmp_path)
    assert done.returncode == 2 and said in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_a_run_that_fails_says_so(tmp_path):
    done = call("estimate", SOURCE / "input/paper/rotation/t4-printed-gamma.ana", "--set", "step.end_time=10", cwd=tmp_path)
    assert done.returncode == 1 and "energy has come from nothing" in done.stderr


def test_both_schemes_stand_side_by_side(tmp_path):
    """Each has the steps of its own run. A deck of small steps is held against the implicit scheme."""
    decks = scenes.wall(3, end=0.05).write(tmp_path, 1e-3)
    rows = told(tmp_path, *decks)
    assert list(rows) == ["small steps", "as it is"]
    again = told(tmp_path, *decks, "--set", "integrator.scheme=small_steps")
    assert list(again) == ["as it is", "implicit"]
    assert {(row[0][0], row[1]) for row in (*rows.values(), *again.values())} == {(50, "the whole run")}


@pytest.mark.parametrize("words, said", [
    (["--set", "contact.viscosity=0.1"], "small steps: --set integrator.scheme: expected integrator.scheme='small_steps' only without "
                                         "contact.viscosity"),
    (["--set", "integrator.scheme=small_steps", "--set", "step.accuracy=0.3"], "implicit ")])
def test_a_deck_that_the_other_scheme_cannot_run_is_told_in_a_line(words, said, tmp_path):
    decks = scenes.wall(2, end=0.01).write(tmp_path, 1e-3)
    done = call("estimate", *decks, *words, cwd=tmp_path)
    assert done.returncode == 0 and sum(line.startswith(said) for line in done.stdout.splitlines()) == 1
    assert "as it is" in done.stdout
