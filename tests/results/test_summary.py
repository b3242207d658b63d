"""What a run says at its end, on a screen and as JSON: the numbers of its results, whatever way it went."""
import json
import os
import pathlib
import pty
import re
import subprocess
import time

import numpy as np
import pytest
from scree import call, read, touching
from scree import run as run_of
from scree.bench import effects, scenes
from scree.block_files import block_file

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
CLASSIC = SOURCE / "tests" / "data" / "classic"
ARC = SOURCE / "input/paper/arc/arc.ana"

# Decks, settings and the exit status of runs that take up to a second.
SCENES = {
    "a block that falls": lambda folder: ([CLASSIC / "freefall.geo", CLASSIC / "freefall.ana"], [], 0),
    "a mesh": lambda folder: ([touching.jointed_rock(folder, "nmm", 3, 20)], [], 0),
    "random rock": lambda folder: ([touching.jointed_rock(folder, "dda, Green strain", 3, 8)], [], 0),
    "a static stack": lambda folder: ([CLASSIC / "stack5.geo", CLASSIC / "stack5_sta.ana"], [], 0),
    "steps of Shi's": lambda folder: ([CLASSIC / "circleslope.geo", CLASSIC / "circleslope.ana"],
                                      ["method.preset=shi", "step.control=shi", "contact.adapt=shi", "step.count=60"], 0),
    "a shaken column": lambda folder: (scenes.column(36).write(folder, 0.005),
                                       ["acceleration.table=0 0 0 0.05 5 1 0.1 -5 0 1 0 0", "step.end_time=0.1", "damping.mass=0.1"], 0),
    "impacts": lambda folder: ([ARC], ["contact.restitution=0.5", "step.size=2e-3"], 0),
    "blocks that fall asleep": lambda folder: (effects.on_ground(3, 2, 60.0).with_more(velocity=(20.0, 0.0, 0.0)).write(folder, "x"),
                                               ["step.sleep=1e-3", "step.end_time=5", "output.every=20"], 0),
    "a column that fails": lambda folder: (scenes.column(36).write(folder, 0.005),
                                           ["acceleration.table=0 0 0 0.05 0 0 0.06 1e9 0 1 1e9 0", "step.end_time=0.2"], 1),
}


def words(settings):
    return [word for setting in settings for word in ("--set", setting)]


def summary_of(done):
    """The JSON of a run; it has no NaN and is one line."""
    assert len(done.stdout.splitlines()) == 1, done.stdout
    return json.loads(done.stdout, parse_constant=lambda word: pytest.fail(f"{word} in {done.stdout}"))


@pytest.fixture(scope="module", params=SCENES)
def run(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("summary")
    decks, settings, status = SCENES[request.param](folder)
    done = call("run", *decks, *words(settings), "-o", folder / "r.h5", "--quiet", "--summary", "json", timeout=120)
    assert done.returncode == status, done.stderr
    return summary_of(done), read(folder / "r.h5")


def check_numbers(said, r, of=slice(None)):
    """All numbers are those of the file, of the steps of the last part."""
    history, n = r.history, len(r.history.time[of])
    assert said["status"] == r.scene.status and said["results"] == str(r.path)
    assert said["time"]["reached"] == (history.time[-1] if n else said["time"]["from"])
    ends = [float(text.split()[2]) for text in r.scene.settings if text.startswith("step.end_time = ")]
    assert [said["time"]["asked"]] == (ends or [None])
    steps = said["steps"]
    assert (steps["taken"], steps["cut"], steps["solves"]) == (n, history.rejected[of].sum(), history.solves[of].sum())
    assert sum(steps["cut_by"].values()) == steps["cut"]
    cost = dict(zip(r.cost.phase, zip(r.cost.calls, r.cost.wall_seconds, r.cost.processor_seconds, r.cost.share)))
    assert {name: tuple(own.values()) for name, own in said["cost"].items()} == cost
    assert steps["factors"] == (cost["factor"][0] if "factor" in cost else 0)
    of_vertex = np.repeat(r.block, [len(set(corners)) for corners in r.corners()])  # those of an element are together
    for name, field in (("displacement", r.displacement()), ("speed", r.velocity())):
        size = np.linalg.norm(field, axis=1)
        assert said[name]["largest"] == pytest.approx(size.max(), rel=1e-14, abs=0)
        here = np.isclose(size, size.max(), rtol=1e-14, atol=0)
        assert said[name]["block"] in of_vertex[here]
        assert any(said[name]["position"] == place.tolist() for place in r.vertices()[here])


def test_the_summary_has_the_numbers_of_the_file(run):
    said, r = run
    assert r.summary == said
    check_numbers(said, r)
    history, energy = r.history, said["energy"]
    books = history.energy
    assert energy["work"] == books.work[-1] and energy["dissipated"] == books.dissipated[-1]
    for name in ("friction", "damping", "asleep"):
        assert energy[name] == (books[name][-1] if name in books else 0)
    lost = energy["dissipated"] - energy["friction"] - energy["damping"] - energy["asleep"]
    assert energy["lost_otherwise"] == pytest.approx(lost, rel=1e-12, abs=1e-12 * energy["given"])
    assert energy["share_lost"] == pytest.approx(lost / energy["given"] if energy["given"] else 0, rel=1e-12, abs=1e-12)
    start, end = r.bodies.area[0].sum(), history.area[-1]
    assert said["change_of_area"] == pytest.approx(end / start - 1, abs=1e-15 * r.n_elements)


def test_the_deepest_overlap_is_that_of_the_history(run):
    said, r = run
    if "overlap" not in r.history or not r.history.overlap.max():
        assert said["overlap"] is None
        return
    deepest = r.history.overlap.argmax()
    assert said["overlap"]["largest"] == r.history.overlap[deepest] and said["overlap"]["time"] == r.history.time[deepest]
    assert all(1 <= block <= r.n_blocks for block in said["overlap"]["blocks"])


def test_the_deepest_overlap_is_where_blocks_touch(tmp_path):
    """A block on a base: the block and the base, at a corner of the one that rests on the other."""
    decks = [CLASSIC / "stack5.geo", CLASSIC / "stack5_dyn.ana"]
    said = summary_of(call("run", *decks, "--set", "output.every=1", "-o", tmp_path / "r.h5", "--quiet", "--summary", "json"))
    r = read(tmp_path / "r.h5")
    frame = np.searchsorted(r.times, said["overlap"]["time"])
    touching_there = r.contacts_of(frame)
    assert r.times[frame] == said["overlap"]["time"]
    assert said["overlap"]["position"] in touching_there.place.tolist()
    assert said["overlap"]["blocks"] in touching_there.blocks.tolist()


def test_free_fall_moves_by_half_g_t_squared(tmp_path):
    """10 m/s^2 for 1 s, without a force that could err."""
    said = summary_of(call("run", CLASSIC / "freefall.geo", CLASSIC / "freefall.ana", "--set", "integrator.start=consistent", "--quiet", "--summary", "json", "-o", tmp_path / "r.h5"))
    assert said["displacement"]["largest"] == pytest.approx(5) and said["speed"]["largest"] == pytest.approx(10)
    assert said["steps"]["planned"] == said["steps"]["taken"] == 100 and said["at_rest"] is False and said["overlap"] is None


def test_the_energy_of_a_slide_is_that_of_its_height(tmp_path):
    """What a block on a slope is given is its weight times the height that it lost; friction took mu cos / sin of it."""
    decks = [CLASSIC / "incline30.geo", CLASSIC / "incline30_p10.ana"]
    said = summary_of(call("run", *decks, "--quiet", "--summary", "json", "-o", tmp_path / "r.h5"))
    books = read(tmp_path / "r.h5").history.energy
    energy = said["energy"]
    assert energy["given"] == pytest.approx(energy["fallen"]) and energy["fallen"] > books.gravity[0] - books.gravity[-1]
    assert energy["friction"] / energy["given"] == pytest.approx(np.tan(np.radians(10)) / np.tan(np.radians(30)), rel=1e-3)
    assert abs(energy["share_lost"]) < 1e-3


def test_rest_is_told_from_motion(tmp_path):
    decks = [CLASSIC / "stack5.geo", CLASSIC / "stack5_dyn.ana"]
    for settings, rests in ((["damping.mass=5", "step.end_time=10"], True), (["step.end_time=0.05"], False)):
        said = summary_of(call("run", *decks, *words(settings), "--quiet", "--summary", "json", "-o", tmp_path / "r.h5"))
        assert said["at_rest"] is rests
    said = summary_of(call("run", decks[0], CLASSIC / "stack5_sta.ana", "--quiet", "--summary", "json", "-o", tmp_path / "r.h5"))
    assert said["at_rest"] is None  # a static step has no speed that tells of rest


def test_a_run_that_goes_on_sums_up_its_last_part(tmp_path):
    decks, settings = [CLASSIC / "wall100.geo", CLASSIC / "wall100.ana"], ["step.count=20"]
    done = call("run", *decks, *words(settings), "-o", tmp_path / "r.h5", "--quiet", "--summary", "json")
    first = summary_of(done)
    done = call("run", "--restart", tmp_path / "r.h5", "--set", "step.count=50", "--set", "step.end_time=1", "--quiet", "--summary", "json")
    assert done.returncode == 0, done.stderr
    said, r = summary_of(done), read(tmp_path / "r.h5")
    assert said["steps"]["planned"] == said["steps"]["taken"] == 30 and said["time"]["from"] == first["time"]["reached"]
    assert r.summary == said
    check_numbers(said, r, slice(20, None))
    assert said["energy"]["dissipated"] == pytest.approx(np.diff(r.history.energy.dissipated[[19, -1]])[0],
                                                         abs=1e-12 * np.abs(r.history.energy.gravity[-1]))


def test_a_run_that_goes_on_asleep_has_the_overlap_of_what_sleeps(tmp_path):
    decks = effects.on_ground(3, 2, 60.0).write(tmp_path, "x")
    assert call("run", *decks, *words(["step.sleep=1e-3", "step.end_time=5"]), "-o", tmp_path / "r.h5", "--quiet").returncode == 0
    done = call("run", "--restart", tmp_path / "r.h5", "--set", "step.end_time=6", "--quiet", "--summary", "json")
    said, r = summary_of(done), read(tmp_path / "r.h5")
    assert said["steps"]["taken"] > 0
    deepest = r.history.overlap[-said["steps"]["taken"]:].max()
    assert deepest > 0 and said["overlap"]["largest"] == deepest


def test_a_screen_says_it_in_words_and_ends_with_the_file(tmp_path):
    done = call("run", ARC, "--set", "step.size=5e-4", "-o", tmp_path / "arc.h5")
    lines = done.stdout.splitlines()
    at = [line.startswith("ended: ") for line in lines].index(True)
    assert lines[at] == "ended: complete at time 1 of 1" and lines[-1] == f"results: {tmp_path / 'arc.h5'}" and len(lines) - at < 12
    names = [line.split(":")[0] for line in lines[at:]]
    assert names == ["ended", "steps", "displacement", "speed", "energy", "area", "overlap", "time", "results"]
    r = read(tmp_path / "arc.h5")
    assert lines[at + 1].startswith(f"steps: {len(r.history.time)} taken of 2000 planned, {r.history.rejected.sum()} tried again smaller")
    assert sum(map(int, re.findall(r"(\d+) %", lines[-2]))) <= 102
    assert call("run", ARC, "--set", "step.size=5e-3", "-o", tmp_path / "arc.h5", "--quiet").stdout == ""


@pytest.mark.parametrize("away", [(0, 0), (450_000, 5_200_000)])
def test_places_are_told_to_the_same_part_of_the_model_wherever_it_is(away, tmp_path):
    """A beam of 10 m with a square on it, at the origin or in coordinates of a national grid: places to 1 cm, in blocks of their size."""
    blocks = [[(x + away[0], y + away[1]) for x, y in corners] for corners in ([(0, 0), (10, 0), (10, 1), (0, 1)],
                                                                               [(3.25, 1), (4.5, 1), (4.5, 2.25), (3.25, 2.25)])]
    (tmp_path / "a.blk").write_text(block_file("a", [(1, corners) for corners in blocks], [(*blocks[0][k], 1) for k in (0, 1)]))
    (tmp_path / "a.ana").write_text("1 2 1 1 0.05 0.01\n2500 24525 1e10 0.25\n0 0 0 0 0 0 0 0 0\n30 0 0\n"
                                    "&deck geometry='a.blk', dialect='short' /\n")
    done = call("run", "a.ana", cwd=tmp_path)
    farthest = next(line for line in done.stdout.splitlines() if line.startswith("displacement: "))
    place = [float(word) for word in re.search(r"of block 2 at \((.*?), (.*?)\)", farthest).groups()]
    assert min(np.hypot(*(np.array(place) - corner)) for corner in blocks[1]) < 0.01
    told = re.search(r"smallest block .* about \((.*?), (.*?)\)", call("check", "a.ana", cwd=tmp_path).stdout).groups()
    assert [float(word) for word in told] == [away[0] + 3.875, away[1] + 1.625]


def test_warnings_are_counted(tmp_path):
    done = call("run", CLASSIC / "freefall.geo", CLASSIC / "freefall.ana", "--summary", "json", "-o", tmp_path / "r.h5", "--quiet")
    assert summary_of(done)["warnings"] == done.stderr.count("scree: warning: ") == 1
    assert [f"scree: warning: {line}" for line in read(tmp_path / "r.h5").warnings] == done.stderr.splitlines()
    r = run_of(CLASSIC / "stack5.geo", CLASSIC / "stack5_dyn.ana", output=tmp_path / "r.h5", settings=["step.count=2"])
    assert r.warnings == [] and r.summary["warnings"] == 0


def test_a_summary_is_of_a_run_and_in_json(tmp_path):
    for given, said in ((["run", ARC, "--summary", "xml"], "expected json after --summary, found 'xml'"),
                        (["check", ARC, "--summary", "json"], "expected --summary with run, found it with check"),
                        (["run", ARC, "--summary"], "expected a word after --summary, found the end")):
        done = call(*given, cwd=tmp_path)
        assert done.returncode == 2 and said in done.stderr and len(done.stderr.splitlines()) == 1


def said_on_a_terminal(given, until, limit=30):
    """What a run writes to a terminal, up to where it says something or ends."""
    master, slave = pty.openpty()
    with subprocess.Popen([SCREE, *map(str, given)], stdout=slave, stderr=slave) as process:
        os.close(slave)
        said, begun = "", time.monotonic()
        try:
            while until not in said and time.monotonic() - begun < limit:
                said += os.read(master, 4096).decode(errors="replace")
        except OSError:  # the run has ended
            pass
        process.terminate()
        while True:
            try:
                rest = os.read(master, 4096).decode(errors="replace")
            except OSError:
                break
            if not rest:
                break
            said += rest
    os.close(master)
    return said


@pytest.mark.parametrize("settings, reason", [(["method.strain=green", "iteration.most=2"], "deformation"), (["step.travel=0.5"], "travel")])
def test_cut_tries_are_counted_by_their_reasons(settings, reason, tmp_path):
    """A block that spins, in so few iterations that only short steps settle, or with a bound of what a vertex may go: on the screen too."""
    given = ["run", CLASSIC / "spin.geo", CLASSIC / "spin_w10.ana", *words(
        [*settings, "step.size=0.1", "step.end_time=0.5", "step.least=1e-9", "step.count=100000"])]
    given += ["-o", tmp_path / "r.h5"]
    steps = summary_of(call(*given, "--quiet", "--summary", "json", timeout=120))["steps"]
    assert steps["cut"] > 0 and steps["cut_by"] == {name: steps["cut"] * (name == reason) for name in steps["cut_by"]}
    assert f", {steps['cut']} tried again smaller ({reason} {steps['cut']}); " in call(*given, timeout=120).stdout


def test_a_terminal_is_told_once_why_steps_stay_short(tmp_path):
    """A block that spins, in so few iterations of each step, by the secant, that only short ones settle."""
    given = ["run", CLASSIC / "spin.geo", CLASSIC / "spin_w10.ana", *words(
        ["method.strain=green", "iteration.method=secant", "iteration.most=2", "step.size=0.1", "step.least=1e-9", "step.end_time=1e6",
         "step.count=100000000", "output.every=100000000"]), "-o", tmp_path / "r.h5"]
    said = re.sub(r"\r?\n  ", " ", said_on_a_terminal(given, "steps stay short"))  # a line that is longer than the terminal is wide is parted
    found = re.findall(r"steps stay short, (\S+) of 0\.1, as tries are cut: (.*)", said)
    assert len(found) == 1, said[-1000:]
    assert float(found[0][0]) < 0.05 and "block 1" in found[0][1] and "did not settle in 2 iterations" in found[0][1]


def test_a_run_says_how_far_it_is_off_and_warns_where_that_is_more_than_was_asked_for(tmp_path):
    """By its estimate, as the last row of the results has it. Steps that may not be short enough miss what is asked for."""
    for accuracy, least, warns in ((1e-3, 1e-9, False), (1e-7, 5e-3, True)):
        sets = [f"step.accuracy={accuracy}", "step.size=2e-2", f"step.least={least}"]
        done = call("run", ARC, *words(sets), "--summary", "json", "-o", tmp_path / "r.h5", "--quiet")
        said = summary_of(done)
        assert said["error"] == {"share": read(tmp_path / "r.h5").history.error.share[-1], "asked": accuracy}
        assert warns == (said["error"]["share"] > 2 * accuracy) == (": lower step.accuracy until" in done.stderr), done.stderr
    done = call("run", ARC, "--set", "step.size=1e-3", "--summary", "json", "-o", tmp_path / "r.h5", "--quiet")
    assert summary_of(done)["error"] is None
