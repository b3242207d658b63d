"""A run that is stopped or killed at any moment and gone on with has the same bits as one that never stopped."""
import contextlib
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import time

os.environ["HDF5_USE_FILE_LOCKING"] = "FALSE"  # a file is read here while it is written

import h5py
import numpy as np
import pytest
from scree import block_files, call, read, touching
from scree.bench import effects, scenes

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
CLASSIC = SOURCE / "tests" / "data" / "classic"
MOMENTS = int(os.environ.get("SCREE_MOMENTS", 2))  # of each scene, at which it is killed
ADAPTING = ["method.preset=shi", "step.control=shi", "contact.adapt=shi"]


def random_rock(folder, kind, steps):
    return [touching.jointed_rock(folder, kind, 3, steps)], []


def slope_made_quiet(folder):
    """A block that comes to rest on supports, then stands on absorbing edges and is pushed."""
    (folder / "q.blk").write_text(block_files.block_file("quiet", [(1, block_files.box(0, 4, 0, 2)), (1, block_files.box(1, 2, 2, 3))]))
    (folder / "q.ana").write_text("0\n40\n1 1\n0.05\n0.5\n2500 25000 1e8 0.25 0 0 0 0 0 0 0 0 0\n30 0 0\n&deck geometry='q.blk' /\n"
                                  "&output every=5 /\n&support both=0 0 4 0 /\n&stage kind='dynamic' /\n&support both=none /\n"
                                  "&absorbing lines=0 0 4 0, sides=0 0 0 2 4 0 4 2 /\n&acceleration table=0 0 0 0.1 3 0 0.2 0 0 /\n&step size=0.01, count=30 /\n")
    return [folder / "q.ana"], []


# Decks and settings of runs that take up to a second.
SCENES = {
    "arc": lambda folder: ([SOURCE / "input/paper/arc/arc.ana"], ["step.size=5e-4"]),
    "wall of 106": lambda folder: ([CLASSIC / "wall100.geo", CLASSIC / "wall100.ana"], ["step.count=60"]),
    "random rock": lambda folder: random_rock(folder, "dda, Green strain", 8),
    "supports that become quiet": slope_made_quiet,
    "shaken column": lambda folder: (scenes.column(36).write(folder, 0.005),
                                     ["acceleration.table=0 0 0 0.05 5 1 0.1 -5 0 1 0 0", "step.end_time=0.1", "damping.mass=0.1"]),
    "mesh": lambda folder: random_rock(folder, "nmm", 20),
    "covers of second order": lambda folder: ([SOURCE / "input/paper/rotation/chi-half.ana"], [
        "cover.edge=0.02", "cover.order=1", "integrator.scheme=energy_decaying", "step.count=60", "output.every=5"]),
    "stiffness that adapts": lambda folder: ([CLASSIC / "circleslope.geo", CLASSIC / "circleslope.ana"],
                                             [*ADAPTING, "step.count=60"]),
    "blocks that fall asleep": lambda folder: (effects.on_ground(3, 2, 60.0).with_more(velocity=(20.0, 0.0, 0.0)).write(folder, "x"),
                                               ["step.sleep=1e-3", "step.end_time=5", "output.every=20"]),
    "steps by accuracy": lambda folder: ([SOURCE / "input/validation/b10-rocking/push0.24.ana"], ["step.accuracy=1e-3"]),
    "bolts that yield": lambda folder: ([SOURCE / "input/validation/m10-bolted-block/bolt15.ana"],
                                        ["bolts.pretension=17.3", "bolts.strength=17.3", "output.every=2"]),
    "grouted bolts that yield": lambda folder: ([SOURCE / "input/validation/m10-bolted-block/bolt15.ana"],
                                                ["bolts.ends=0.5 0.866025 -2.098 -0.634", "bolts.strength=12",
                                                 "bolts.shear_stiffness=5e3", "bolts.shear_strength=11", "output.every=2"]),
    "supports, loads and water that grow": lambda folder: (
        [SOURCE / "input/validation/m10-bolted-block/bolt0.ana"],
        ["support.normal=-17.320508 10 -21.320508 3.07179677", "boundary.lines=1.73205081 -1 2.73205081 0.73205081",
         "boundary.pressure=3 1", "boundary.ramp=5", "gravity.ramp=4", "water.table=0 1 3 0", "water.unit_weight=2", "output.every=2"]),
    "rough joints that wear": lambda folder: ([SOURCE / "input/validation/b1-slide/slope30-phi28.ana"],
                                              ["joints.jrc=8", "joints.jcs=1e8", "joints.residual_phi=20", "joints.residual_slip=0.05",
                                               "joint(1).phi=20", "joints.residual_c=100", "output.every=5"]),
    "joints that dilate": lambda folder: ([SOURCE / "input/validation/j2-dilation/ride.ana"], ["method.strain=green", "output.every=2"]),
    "bonds that soften": lambda folder: ([SOURCE / "input/validation/j4-softening/pulled.ana"], ["output.every=5"]),
    "joints that stiffen": lambda folder: ([SOURCE / "input/validation/j3-closure/bounces.ana"], ["output.every=5"]),
    "waves that come in and go out": lambda folder: ([SOURCE / "input/validation/w1-wave/s-free.ana"],
                                                     ["method.strain=auto", "cover.edge=1", "step.count=60", "output.every=5"]),
    "stages": lambda folder: ([SOURCE / "tests/data/stages/stages.ana"], []),
    "impacts": lambda folder: ([SOURCE / "input/paper/arc/arc.ana"], ["contact.restitution=0.5", "step.size=2e-3"]),
}


def words(settings):
    return [word for setting in settings for word in ("--set", setting)]


def datasets(path, but=()):
    """All datasets of a run by name, but for what its last part came to and cost, and where it may be gone on from."""
    found = {}
    with h5py.File(path) as f:
        f.visititems(lambda name, item: found.update({name: item[()]}) if isinstance(item, h5py.Dataset) else None)
    return {name: value for name, value in found.items() if not name.startswith(("cost", "ending", "checkpoint", "scene/options", *but))}


def differing(a, b, but=()):
    """Names of datasets that are not the same bytes."""
    a, b = datasets(a, but), datasets(b, but)
    assert len(a) > 20
    return sorted(a.keys() ^ b.keys()) + [name for name in a.keys() & b.keys() if a[name].tobytes() != b[name].tobytes()]


@contextlib.contextmanager
def writing(decks, settings, path):
    """A run that has just begun to write its file."""
    path.unlink(missing_ok=True)
    with subprocess.Popen([SCREE, "run", *decks, "-o", path, "--quiet", *words(settings)], stderr=subprocess.PIPE, text=True) as run:
        while run.poll() is None and not path.exists():
            time.sleep(1e-4)
        yield run


def stop(number, decks, settings, path, pause, end):
    """Starts a run and sends a signal; False where that ended before, had no checkpoint yet, or has one of its end."""
    with writing(decks, settings, path) as run:
        time.sleep(pause)
        run.send_signal(number)
        run.communicate()
    if run.returncode == 0 or not path.exists():
        return False
    try:
        with h5py.File(path) as f:
            rest = f["checkpoint"]
            frames = rest["frame"][:]
            if f["VTKHDF/Steps/Values"][frames[frames < f["VTKHDF/Steps"].attrs["NSteps"]].max()] >= end:
                return False  # nothing is left to go on with
            return number != signal.SIGKILL or (rest["frame"][0] < f["VTKHDF/Steps"].attrs["NSteps"] and len(rest["rows"]) > 0
                                                and rest["end"][0] <= len(rest["numbers"]))
    except (OSError, KeyError, IndexError, ValueError):  # killed before the first checkpoint with its frame
        return False


def stopped(number, decks, settings, path, seconds, moments, end):
    """Stops a run at a random moment of the seconds that it writes, until that is one with something to go on from. Or of fewer, in
    turn, as they are many where the machine stood still while they were measured."""
    for i in range(100):
        if stop(number, decks, settings, path, moments.uniform(0.0, seconds / 2**(i % 6)), end):
            return
    raise AssertionError("no moment to stop this run at")


@pytest.mark.parametrize("name", SCENES)
def test_a_run_goes_on_with_the_same_bits(name, tmp_path):
    """Stopped by SIGTERM: every step is the same, and every frame; the one of the stop is one more. Killed: the file is the same.
    The threads of the linear algebra are others than those of the run before."""
    (tmp_path / "decks").mkdir()
    decks, settings = SCENES[name](tmp_path / "decks")
    settings = [*settings, "output.checkpoint=2"]
    whole, path, moments = tmp_path / "whole.h5", tmp_path / "part.h5", random.Random(14)
    with writing(decks, settings, whole) as run:
        begun = time.monotonic()
        said = run.communicate()[1]
    seconds = time.monotonic() - begun
    assert run.returncode == 0, said
    end = read(whole).times[-1]
    for moment in range(MOMENTS):
        number = (signal.SIGKILL, signal.SIGTERM)[moment % 2]
        stopped(number, decks, settings, path, seconds, moments, end)
        done = call("run", "--restart", path, "--quiet", env={**os.environ, "OPENBLAS_NUM_THREADS": "12"[moment // 2 % 2]})
        assert done.returncode == 0, done.stderr
        assert differing(whole, path, () if number == signal.SIGKILL else ("VTKHDF", "bodies", "contacts", "bolts")) == []
        a, b = read(whole), read(path)
        at = np.searchsorted(b.times, a.times)
        assert b.scene.status == a.scene.status and b.n_frames <= a.n_frames + 1 and (b.times[at] == a.times).all()
        for i, k in enumerate(at):
            assert a.vertices(i).tobytes() == b.vertices(k).tobytes() and a.stress(i).tobytes() == b.stress(k).tobytes()
            assert a.bodies.velocity[i].tobytes() == b.bodies.velocity[k].tobytes()
            assert "bolts" not in a or a.bolts.force[i].tobytes() == b.bolts.force[k].tobytes()


@pytest.fixture
def stopped_run(tmp_path):
    """Decks, and a run of them that is over after 30 steps of 100, in the folder."""
    analysis = (SOURCE / "input/paper/arc/arc.ana").read_text()
    (tmp_path / "arc.ana").write_text(analysis)
    (tmp_path / "arc.geo").write_text((SOURCE / "input/paper/arc/arc.geo").read_text())
    assert call("run", "arc", "--quiet", "--set", "step.count=30", cwd=tmp_path).returncode == 0
    return tmp_path


def goes_on(folder, *words):
    done = call("run", "--restart", "arc.h5", "--quiet", "--set", "step.count=50", *words, cwd=folder)
    assert done.returncode == 0, done.stderr


def test_a_run_is_gone_on_with_again_and_again(stopped_run):
    """Restarts of restarts; the settings of the first run stay."""
    for count in (31, 40, 50):
        goes_on(stopped_run, "--set", f"step.count={count}")
    assert call("run", "arc", "--quiet", "--set", "step.count=50", "-o", "whole.h5", cwd=stopped_run).returncode == 0
    assert differing(stopped_run / "whole.h5", stopped_run / "arc.h5", ("VTKHDF", "bodies", "contacts", "scene/settings")) == []


def test_a_restart_may_say_how_a_stage_goes_on(tmp_path):
    """The last of four stages to its 120 steps, or to 50 first; without its number the count would be that of all stages."""
    deck, last = SOURCE / "tests/data/stages/stages.ana", "stage(4).step.count=120"
    assert call("run", deck, "-o", "whole.h5", "--quiet", "--set", last, cwd=tmp_path).returncode == 0
    assert call("run", deck, "-o", "part.h5", "--quiet", "--set", "stage(4).step.count=50", cwd=tmp_path).returncode == 0
    assert call("run", "--restart", "part.h5", "--quiet", "--set", last, cwd=tmp_path).returncode == 0
    a, b = read(tmp_path / "whole.h5"), read(tmp_path / "part.h5")
    assert a.scene.status == b.scene.status == "complete" and list(b.scene.options)[-1] == last
    assert differing(a.path, b.path, ("VTKHDF", "bodies", "contacts", "bolts", "stages", "scene/options", "scene/settings")) == []
    assert (a.history.time == b.history.time).all() and a.vertices(-1).tobytes() == b.vertices(-1).tobytes()


def test_another_file_leaves_the_first_as_it_was(stopped_run):
    before = (stopped_run / "arc.h5").read_bytes()
    goes_on(stopped_run, "-o", "more.h5")
    assert (stopped_run / "arc.h5").read_bytes() == before and len(read(stopped_run / "more.h5").history.time) == 50
    assert not list(stopped_run.glob("*.part"))


def test_the_side_car_has_all_frames(stopped_run):
    goes_on(stopped_run, "--xdmf")
    assert (stopped_run / "arc.xdmf").read_text().count("<Time ") == read(stopped_run / "arc.h5").n_frames


def test_frames_go_on_at_their_times_when_the_end_moves(stopped_run):
    """Frames at set times that are set anew: no step goes back, and frames come at multiples."""
    done = call("run", "--restart", "arc.h5", "--quiet", "--set", "step.count=1000", "--set", "output.interval=0.1", cwd=stopped_run)
    assert done.returncode == 0, done.stderr
    r = read(stopped_run / "arc.h5")
    stop = r.history.time[29]
    later = r.times[r.times > stop]
    assert (np.diff(r.history.time) > 0).all() and len(later) > 5
    assert np.abs(later / 0.1 - np.round(later / 0.1))[:-1].max() < 1e-9 and later[0] - stop <= 0.1 + 1e-12


def test_a_restart_at_a_frame_of_its_own_makes_no_step_of_round_off(tmp_path):
    """Time 0.7 is a frame every 0.35 and every 0.1: 7 times 0.1 is beyond it by round-off."""
    deck = SOURCE / "input/validation/b7-bounce/restitution0.5.ana"
    first = ["--set", "output.interval=0.35", "--set", "step.end_time=0.7"]
    assert call("run", deck, "-o", "part.h5", "--quiet", *first, cwd=tmp_path).returncode == 0
    done = call("run", "--restart", "part.h5", "--quiet", "--set", "output.interval=0.1", "--set", "step.end_time=0.9", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    r = read(tmp_path / "part.h5")
    assert np.diff(r.history.time).min() > 1e-6 and np.abs(r.times[-2:] - [0.8, 0.9]).max() < 1e-12


def test_a_checkpoint_that_was_not_finished_is_passed_over(stopped_run):
    """As where a run was killed while it wrote one: the one before is gone on from, to the same bits."""
    assert call("run", "arc", "--quiet", "--set", "step.count=60", "--set", "output.checkpoint=2", "--set", "output.every=10",
                cwd=stopped_run).returncode == 0
    shutil.copy(stopped_run / "arc.h5", stopped_run / "whole.h5")
    edit(stopped_run / "arc.h5", lambda f: f["checkpoint/numbers"].resize(f["checkpoint/end"][-1] - 1, 0))
    with h5py.File(stopped_run / "arc.h5") as f:
        assert list(f["checkpoint/frame"]) == [2, 4, 6]
    done = call("run", "--restart", "arc.h5", "--quiet", cwd=stopped_run)
    assert done.returncode == 0, done.stderr
    assert differing(stopped_run / "whole.h5", stopped_run / "arc.h5") == []


def edit(path, change):
    with h5py.File(path, "a") as f:
        change(f)


BAD = {
    "another deck": (lambda d: (d / "arc.ana").write_text((d / "arc.ana").read_text() + "\n"), "arc.ana: expected the deck that"),
    "another geometry": (lambda d: (d / "arc.geo").write_text((d / "arc.geo").read_text() + "! more\n"), "arc.geo: expected the deck that"),
    "no deck": (lambda d: (d / "arc.ana").unlink(), "arc.ana: expected a deck, found no such file"),
    "no file": (lambda d: (d / "arc.h5").unlink(), "arc.h5: expected the results file of a run to go on with, found no such file"),
    "no results file": (lambda d: (d / "arc.h5").write_text("no"), "found another file"),
    "the results of something else": (lambda d: edit(d / "arc.h5", lambda f: f.__delitem__("scene")), "found another file"),
    "no checkpoint": (lambda d: edit(d / "arc.h5", lambda f: f.__delitem__("checkpoint")), "expected a run with a checkpoint"),
    "another version": (lambda d: edit(d / "arc.h5", lambda f: f["scene"].attrs.modify("version", np.bytes_("scree 0.0.9"))),
                        "found one of scree 0.0.9"),
    "other components": (lambda d: edit(d / "arc.h5", lambda f: f["checkpoint/components"].write_direct(
        np.array([b"time"], f["checkpoint/components"].dtype))), "found one of another version"),
    "a damaged checkpoint": (lambda d: edit(d / "arc.h5", lambda f: f["checkpoint/end"].__setitem__(0, f["checkpoint/end"][0] - 1)),
                             "found one that is damaged"),
    "numbers that are not there": (lambda d: edit(d / "arc.h5", lambda f: f["checkpoint/numbers"].resize(9, 0)),
                                   "expected a run with a checkpoint"),
    "rows that are not there": (lambda d: edit(d / "arc.h5", lambda f: f["history/area"].resize(9, 0)), "up to its checkpoint, found less"),
    "other vertices": (lambda d: edit(d / "arc.h5", lambda f: f["VTKHDF/Points"].__setitem__((0, 0), 7.0)), "begins with other vertices"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_restart_is_refused_in_a_line_and_writes_nothing(name, stopped_run):
    """Whether another program has the file open is told by opening it, which leaves the time of that in it, to a second."""
    BAD[name][0](stopped_run)
    before = shutil.copytree(stopped_run, stopped_run / "before")
    done = call("run", "--restart", "arc.h5", "--quiet", "--set", "step.count=50", cwd=stopped_run)
    assert done.returncode == 2 and BAD[name][1] in done.stderr, done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert {path.name for path in stopped_run.iterdir()} - {"before"} == {path.name for path in before.iterdir()}
    for path in before.iterdir():
        now = stopped_run / path.name
        assert now.read_bytes() == path.read_bytes() or path.suffix == ".h5" and differing(now, path) == []


@pytest.mark.parametrize("words, expected", [
    ([], "beyond the checkpoint"), (["--set", "stage(1).contact.stiffness=1e9", "--set", "step.count=50"], "expected one of step.size, "),
    (["--set", "stage(2).step.count=50"], "expected a stage from 1 to 1"), (["--set", "contact.stiffness=1e9", "--set", "step.count=50"], "expected one of step.size, "),
    (["--set", "step.count=50", "--set", "step.sleep=0"], "expected one of step.size, "),
    (["--set", "step.count=50", "--set", "stage(1).output.error=estimate"], "expected one of step.size, "),
    (["--classic-output", "--set", "step.count=50"], "without --restart")])
def test_words_that_do_not_go_with_a_restart_are_refused(words, expected, stopped_run):
    done = call("run", "--restart", "arc.h5", *words, cwd=stopped_run)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr


def test_restart_goes_with_run_alone(stopped_run):
    done = call("check", "--restart", "arc.h5", cwd=stopped_run)
    assert done.returncode == 2 and "expected --restart with run" in done.stderr


def components(source, name):
    """Names of the components of a type in a source."""
    body = re.search(rf"^  type :: {name}\n(.*?)^  end type", (SOURCE / "src" / source).read_text(), re.S | re.M)[1]
    names = []
    for line in body.splitlines():
        declared = line.split("!!")[0].partition("::")[2]
        names += re.findall(r"(\w+)\s*(?:\([^)]*\))?\s*(?:=[^,]*)?(?:,|$)", re.sub(r"\([^)]*\)", "", declared))
    return names


@pytest.mark.parametrize("source, name", [
    ("types/state.f90", "state_t"), ("types/state.f90", "pace_t"), ("types/state.f90", "books_t"), ("types/state.f90", "sleep_t"),
    ("types/state.f90", "deviation_t"),
    ("types/factored.f90", "factored_t"),
    ("types/contacts.f90", "contact_memory_t"), ("types/contacts.f90", "contact_t"), ("types/contacts.f90", "entrance_t"),
    ("stepping/watch.f90", "watch_t")])
def test_no_component_of_what_a_run_goes_on_from_is_forgotten(source, name):
    """Who adds a component to the state, or to the watch, is told here to name it in `visit_run`; of the state, in
    `first_difference` too, by which the law of the house is tried."""
    names = components(source, name)
    assert len(names) >= 4
    for text in (["src/results/checkpoint.f90"] if name == "watch_t" else ["src/results/checkpoint.f90", "tests/worlds/states.f90"]):
        missing = [n for n in names if f"%{n}" not in (SOURCE / text).read_text()]
        assert missing == [], text


@pytest.mark.parametrize("name", ["stages", "steps by accuracy", "bolts that yield"])
def test_a_run_in_parts_has_the_same_bits(name, tmp_path):
    """Parts of a number of steps, whatever stages and step sizes there are."""
    (tmp_path / "decks").mkdir()
    decks, settings = SCENES[name](tmp_path / "decks")
    whole, path = tmp_path / "whole.h5", tmp_path / "part.h5"
    assert call("run", *decks, "-o", whole, "--quiet", *words(settings)).returncode == 0
    total = len(read(whole).history.time)
    done = call("run", *decks, "-o", path, "--quiet", "--steps", str(total // 3), *words(settings))
    for parts in range(1, 3):
        assert done.returncode == 0 and done.stderr == "" and read(path).scene.status == "paused"
        assert len(read(path).history.time) == parts * (total // 3)
        done = call("run", "--restart", path, "--quiet", "--steps", str(total // 3 + (total if parts == 2 else 0)))
    assert done.returncode == 0 and read(path).scene.status == read(whole).scene.status
    frames = ("VTKHDF", "bodies", "contacts", "frame", "elements", "bolts")  # of pauses there are more
    assert differing(whole, path, frames) == []


def test_only_strengths_and_steps_change_on_the_way(tmp_path):
    path = tmp_path / "r.h5"
    decks, settings = SCENES["arc"](tmp_path)
    assert call("run", *decks, "-o", path, "--quiet", "--steps", "3", *words(settings)).returncode == 0
    for setting, said in (("joint(1).phi=20", ""), ("joints.cohesion=1", "a restart cannot add bonds"), ("joint(9).phi=1", "joint(9)"), ("material(1).E=1", "expected one of"),
                          ("contact.restitution=0", "expected one of")):
        done = call("run", "--restart", path, "-o", tmp_path / "on.h5", "--quiet", "--steps", "1", "--set", setting)
        assert (done.returncode, said in done.stderr) == (2 if said else 0, True), (setting, done.stderr)
