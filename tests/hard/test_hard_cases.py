"""Hard cases pass, in any size and way, and what judges them sees what is wrong (doc/stability.md)."""
import os
import pathlib
import shutil
import subprocess

import h5py
import numpy as np
import pytest
from scree import program, read
from scree.hard import judge, random_scenes
from scree.hard.cases import CASES
from scree.hard.command import Way, run, run_scene, runs_of, ways
from scree.hard.scene import Size

TOOLS = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tools"
LONG = "SCREE_HARD" in os.environ
LIMIT = 300.0  # s, of a run that then counts as slow

# What fails today and is known: (case, strain or '' for both, restitution or '') and why. Whoever mends one is told, as it passes then.
# Nothing today.
KNOWN = {}
# What may take longer than the limit, on a machine that is slow.
SLOW = {("column100", ""), ("column400", ""), ("slope700", "")}

# The ordinary suite: cases of a second or less, the way of all defaults, and some in other sizes and ways.
SHORT = ["H1", "H2", "H2-1e4", "H2-1e6", "H2-1e6-hard", "H3", "H4", "H5", "H5-10", "H5-falls", "H6", "H7", "H7-allowed", "H10-arch",
         "H11-gaps", "H11-corner", "H11-sliver", "H11-notch", "H12-step", "H12-hard", "H12-soft", "H12-phi0", "H12-phi89", "H12-turn30",
         "painleve", "chatter", "critical-rests", "critical-slides", "flush", "flight", "mesh", "top300", "overlap25"]
OTHERS = [("H5", Way(edge=1e-3)), ("H3", Way(edge=1e3)), ("H10-arch", Way(strain="green")), ("H12-turn30", Way(strain="green")),
          ("H12-turn90", Way(strain="green")), ("H2-1e6", Way(restitution="1")), ("H2-1e6", Way(step=1.0)),
          ("H11-notch", Way(edge=1e-3, strain="green"))]


def known(name, way):
    """Why a case is known to fail in a way, or None."""
    for (case, strain, restitution), why in KNOWN.items():
        if case == name and strain in ("", way.strain) and restitution in ("", way.restitution):
            return why
    return None


def marked(name, way):
    why = known(name, way)
    marks = [pytest.mark.xfail(reason=why, strict=True)] if why else []
    if {(name, ""), (name, way.restitution)} & SLOW:
        marks.append(pytest.mark.xfail(reason="takes long", strict=False))
    return pytest.param(name, way, marks=marks,
                        id=f"{name}-{way.edge:g}-{way.step:g}-{way.strain}-{way.restitution}")


class Vary:
    """What tools/hard --vary asks for."""

    edges = steps = strains = restitutions = ()
    vary, all = True, False


RUNS = [marked(*run) for run in (runs_of(CASES, ways(Vary)) if LONG else [*((name, Way()) for name in SHORT), *OTHERS])]


@pytest.mark.parametrize("name, way", RUNS)
def test_a_hard_case_passes_or_is_rightly_refused(name, way, tmp_path):
    found, _, _ = run(name, way, tmp_path, program(), limit=LIMIT)
    assert found.verdict in (judge.PASSES, judge.REFUSED), found
    assert (found.verdict == judge.REFUSED) <= CASES[name].make().may_refuse


@pytest.mark.parametrize("name", ["H5", "H10-arch", "H11-gaps"])
def test_a_scene_is_the_same_in_any_size(name, tmp_path):
    """Blocks of 1 mm and 1 km go where those of 1 m go, in lengths of a block: to 1e-6 of the farthest, and 1e-12 of rounding."""
    ends = []
    for edge in (1.0, 1e-3, 1e3):
        _, _, output = run(name, Way(edge=edge), tmp_path, program())
        r = read(output)
        ends.append((r.bodies.centroid[-1] - r.bodies.centroid[0]) / edge)
    for other in ends[1:]:
        assert np.abs(other - ends[0]).max() < 1e-6 * np.abs(ends[0]).max() + 1e-12


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Results of a stack and of a flight."""
    folder = tmp_path_factory.mktemp("runs")
    return {name: run(name, Way(), folder, program())[2] for name in ("H5", "flight")}


def spoilt(runs, tmp_path, change, name="H5"):
    """The judgement of results after a change."""
    path = tmp_path / "spoilt.h5"
    shutil.copy(runs[name], path)
    with h5py.File(path, "a") as f:
        change(f)
    return judge.judge(read(path), CASES[name].make(), Size())


def sink(f):
    n = int(f["VTKHDF/NumberOfPoints"][0])
    f["VTKHDF/Points"][-n + 4:-n + 8, 1] -= 0.01  # the lowest block, in the last frame


def gain_energy(f):
    f["history/energy/dissipated"][200:] -= 0.01 * 4 * 0.25 * 2500 * 9.81 * 1.5


def grow(f):
    f["bodies/area"][-1, 2] *= 1.03


def go_away(f):
    f["bodies/centroid"][-1, 2] += 0.02


def stop_without_reason(f):
    f["scene"].attrs.modify("status", np.bytes_("stopped: the step size fell below step.least"))


def stop_with_reason(f):
    f["scene"].attrs.modify("status", np.bytes_("stopped: step 3 from time 1: block 2 at block 3: contacts did not settle"))


def drift(f):
    f["history/momentum"][100:, 0] += 1e-3


@pytest.mark.parametrize("change, name, words", [
    (sink, "H5", "overlap 1.0e-02"), (gain_energy, "H5", "energy from nothing"), (grow, "H5", "area"), (go_away, "H5", "should stand"),
    (stop_without_reason, "H5", "without block or reason"), (stop_with_reason, "H5", "contacts did not settle"),
    (drift, "flight", "momentum changes")])
def test_what_is_wrong_is_seen(change, name, words, runs, tmp_path):
    found = spoilt(runs, tmp_path, change, name)
    assert found.verdict == judge.FAILS and words in found.why, found


@pytest.mark.parametrize("name", ["H5", "flight"])
def test_what_is_right_passes(name, runs, tmp_path):
    assert spoilt(runs, tmp_path, lambda f: None, name).verdict == judge.PASSES


def test_the_tool_prints_a_row_a_run_and_draws_them(tmp_path):
    done = subprocess.run([TOOLS / "hard", "H5", "H6", "--edges", "1", "1e-3", "--sheet", tmp_path / "s.png", "--json", tmp_path / "t.json"],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    head, *rows, last = done.stdout.splitlines()
    assert head.split()[:7] == ["case", "edge", "ms", "strain", "e", "scheme", "verdict"] and len(rows) == 4 and last == "4 passes"
    assert (tmp_path / "s.png").stat().st_size > 10000


def test_the_tool_says_what_is_wrong(tmp_path):
    done = subprocess.run([TOOLS / "hard", "H99"], capture_output=True, text=True)
    assert done.returncode == 2 and "H99" in done.stderr
    done = subprocess.run([TOOLS / "hard", "H5", "--set", "contact.method=none"], capture_output=True, text=True)
    assert done.returncode == 1 and "FAILS" in done.stdout


# The suite's seconds are few; tools/hard --random runs as many as are wanted, and shrinks those that fail.
@pytest.mark.parametrize("number", range(300 if LONG else 40))
def test_a_scene_drawn_at_random_tells_the_truth(number, tmp_path):
    scene = random_scenes.drawn(number)
    found, _, _ = run_scene(scene.scene, "drawn", Way(), tmp_path, program(), scene.settings, LIMIT)
    assert found.verdict != judge.FAILS, f"{scene}: {found}"


def test_what_fails_is_shrunk_to_its_smallest():
    """Of a scene that fails by its third block and one setting nothing else is left."""
    scene = next(scene for scene in map(random_scenes.drawn, range(100)) if len(scene.settings) > 2 and len(scene.scene.moving()) > 4)
    block, setting = scene.scene.blocks[scene.scene.moving()[2]], scene.settings[1]
    least = random_scenes.shrunk(scene, lambda less: any(b is block for b in less.scene.blocks) and setting in less.settings)
    assert least.settings == [setting] and len(least.scene.blocks) == 1 and least.scene.blocks[0] is block
