"""Blocks that leave the scene: they are removed when they do, with their momentum and energy, and the others go on as if alone."""
import re

import h5py
import numpy as np
import pytest
import scree
from scree import block_files, call
from scree.errors import RunFailed

TABLE, SLIDER, FLYER = block_files.box(-2, 8, -1, 0), block_files.box(0, 1, 0, 1), block_files.box(0, 0.5, 2, 2.5)
METHODS = {"blocks": "", "Green strain": "&method strain='green' /", "multipliers": "&contact method='augmented' /",
           "a mesh": "&method model='nmm', strain='small' / &cover edge=0.7, angle=10 /", "small steps": "&integrator scheme='small_steps' /",
           "steps by accuracy": "&step accuracy=1e-3 /", "central differences": "&integrator scheme='central_difference' /",
           "what sleeps": "&step sleep=1e-3 /"}


def rows(weight, rotation=0.0):
    """Materials of the table, the slider and the flyer: the slider has 3 m/s to the right, the flyer 2 m/s to the left and some spin."""
    one = f"2500 {weight} 1e8 0.25 0 0 0 0 0 0"
    return f"{one} 0 0 0\n{one} 3 0 0\n{one} -2 0 {rotation}\n"


def scene(folder, more="", weight=0.0, steps=200, size=0.01, blocks=((1, TABLE), (2, SLIDER), (3, FLYER)), rotation=0.0, moves=1):
    """A table that is held, a block that slides on it, and one that flies."""
    fixed = block_files.held(blocks[0][1], 1)
    (folder / "d.blk").write_text(block_files.block_file("departures", blocks, fixed, measured=[(*np.mean(blocks[-1][1], axis=0), len(blocks))]))
    (folder / "d.ana").write_text(f"{moves}\n{steps}\n3 1\n0.05\n{size}\n{rows(weight, rotation)}2 0 0\n&deck geometry='d.blk', dialect='short' /\n"
                                  f"&output every=10 /\n{more}\n")
    return folder / "d.ana"


def run(folder, *words, name="r.h5", **more):
    return scree.run(scene(folder, *words, **more), output=folder / name)


@pytest.mark.parametrize("method", [method for method in METHODS if "sleep" not in method])  # without weight nothing sleeps
def test_momentum_and_energy_that_leave_close_the_books(method, tmp_path):
    """Nothing acts on free flight without weight. What is left and what has left have the momentum and the energy of the start, to 1e-9;
    each leaves at the end of the step in which its rear passes the side."""
    free = ((1, TABLE), (2, SLIDER + [0, 1.5]), (3, FLYER + [0, 4]))
    r = run(tmp_path, METHODS[method] + "\n&scene rectangle=-1 -5 4 9 /", blocks=free)
    gone, history = r.departures, r.history
    assert list(gone.block) == [3, 2] and r.scene.status == "complete"
    sizes = np.diff(history.time, prepend=0)
    for time, speed, way in zip(gone.time, (2, 3), (1.5, 4)):
        assert way / speed - 1e-9 <= time <= way / speed + sizes.max() + 1e-9
    momentum, mass = np.array(gone.momentum), 2500 * np.array([0.25, 1])
    assert momentum[:, 0] == pytest.approx(mass * [-2, 3], rel=1e-9)
    assert momentum[:, 2] == pytest.approx(-mass * [-2, 3] * [6.25, 2], rel=1e-9)  # about the origin of the deck
    assert np.array(gone.energy) == pytest.approx(0.5 * mass * [4, 9], rel=1e-9)
    left = np.array([momentum[np.array(gone.time) < time].sum(axis=0) for time in history.time])
    assert np.array(history.momentum) + left == pytest.approx(np.tile(momentum.sum(axis=0), (len(left), 1)), abs=1e-9 * np.abs(momentum).max())
    energy = history.energy
    assert np.array(energy.kinetic) - np.array(energy.stages) == pytest.approx(np.sum(gone.energy), rel=1e-9)
    assert np.abs(energy.dissipated).max() < 1e-9 * np.sum(gone.energy)
    assert not np.any(history.momentum[-1]) and list(r.bodies.present[-1]) == [1, 0, 0]


@pytest.mark.parametrize("method", [method for method in METHODS if method != "a mesh"])  # on one the table bends under what moves
def test_what_leaves_in_contact_takes_nothing_from_the_others(method, tmp_path):
    """A block that slides off with weight leaves another at rest on the table. No jump of the energy that was lost, no jerk: the other is
    where it is in a run without a rectangle."""
    blocks = ((1, TABLE), (1, block_files.box(-1.9, -1, 0, 1)), (2, SLIDER))
    step = "&step size=0.002, end_time=1.4 /\n" if "accuracy" not in method else ""
    more, end = METHODS[method], dict(weight=25000, size=0.002, steps=700, blocks=blocks)
    if "sleep" in method:
        more = more.replace("/", ", size=0.002, end_time=1.4 /")
    elif "accuracy" in method:
        more = more.replace("/", ", end_time=1.4 /")
    else:
        more += "\n" + step
    alone = run(tmp_path, more, name="alone.h5", **end)
    r = run(tmp_path, more + "&scene rectangle=-2 -1 3 5 /", **end)
    assert list(r.departures.block) == [3] and 0.5 < r.departures.time[0] < 1.4
    k = int(np.searchsorted(r.history.time, r.departures.time[0]))
    lost, scale = np.array(r.history.energy.dissipated), r.departures.energy[0] + 2500 * 4.5
    assert abs(lost[k + 1] - lost[k]) < 2 * max(abs(lost[k] - lost[k - 1]), 1e-9 * scale) + 1e-9 * scale
    of_second = r.block == 2
    places = [np.concatenate([corners for corners, own in zip(results.polygons(-1), of_second) if own]) for results in (alone, r)]
    assert places[1] == pytest.approx(places[0], abs=1e-7)


def test_a_rectangle_that_holds_all_changes_no_bit(tmp_path):
    with h5py.File(run(tmp_path, weight=25000.0, name="a.h5").path) as a, \
            h5py.File(run(tmp_path, "&scene rectangle=-100 -100 100 100 /", weight=25000.0, name="b.h5").path) as b:
        assert len(b["departures/block"]) == 0 and "departures" not in a
        for name in ("history/energy/kinetic", "history/momentum", "VTKHDF/Points", "VTKHDF/PointData/velocity", "contacts/force"):
            assert np.array_equal(a[name], b[name])


@pytest.mark.parametrize("method", METHODS)
def test_a_restart_before_or_after_a_departure_has_the_same_bits(method, tmp_path):
    deck = scene(tmp_path, METHODS[method] + "\n&scene rectangle=-1 -5 4 9 /", weight=25000.0, steps=180)
    whole = scree.run(deck, output=tmp_path / "whole.h5")
    steps = [int(np.searchsorted(whole.history.time, time)) + 1 for time in whole.departures.time]
    assert len(steps) == 2
    path = tmp_path / "part.h5"
    assert call("run", deck, "-o", path, "--steps", str(steps[0])).returncode == 0  # it has left, and is still there
    for n in (1, max(1, steps[1] - steps[0] - 1), 10000):
        done = call("run", "--restart", path, "--steps", str(n))
        assert done.returncode == 0, done.stderr
    with h5py.File(whole.path) as a, h5py.File(path) as b:
        for name in ("history/energy/kinetic", "history/energy/stages", "history/momentum", "departures/time", "departures/momentum", "history/time"):
            assert np.array_equal(a[name], b[name]), name


def test_a_later_stage_is_without_what_left(tmp_path):
    """What a stage removes and what has left are both gone; a stage may take the rectangle away."""
    later = "&stage name='then' /\n&scene rectangle=none /\n&step end_time=1.5 /"
    r = run(tmp_path, f"&scene rectangle=-1 -5 4 9 /\n&step end_time=1.2 /\n{later}", weight=0.0)
    assert list(r.departures.block) == [3] and list(r.bodies.present[-1]) == [1, 1, 0]
    assert r.history.energy.kinetic[-1] == pytest.approx(0.5 * 2500 * 9, rel=1e-6)  # the slider is beyond the rectangle by now


def test_a_static_run_goes_on_without_a_block_that_falls_out(tmp_path):
    """A block that nothing holds falls out of the rectangle, and the others stay in equilibrium."""
    blocks = ((1, TABLE), (2, SLIDER), (3, FLYER + [9, 0]))
    r = run(tmp_path, "&scene rectangle=-5 -3 20 20 /", weight=25000.0, blocks=blocks, moves=0, steps=400,
            size=0.1)
    assert r.scene.status == "complete" and list(r.departures.block) == [3]


@pytest.mark.parametrize("given, expected", [
    ("5 0 1 3", "expected the lower left and then the upper right corner in scene.rectangle, found (5, 0) and (1, 3)"),
    ("0 3 1 3", "expected the lower left and then the upper right corner"), ("0 0 1", "expected four numbers x1 y1 x2 y2 in scene.rectangle, found 3"),
    ("0 0 nan 3", "d.ana:12: expected '=' after nan"), ("0 0 1e999 3", "1e999"), ("20 20 30 30", "found block 1 outside"), ("-3 -3 9 1.5", "found block 3 outside")])
def test_a_rectangle_that_is_none_is_refused_in_one_line(given, expected, tmp_path):
    said = call("check", scene(tmp_path, f"&scene rectangle={given} /"))
    assert said.returncode == 2 and expected in said.stderr and len(said.stderr.splitlines()) == 1, said.stderr


def test_cracks_that_grow_are_refused(tmp_path):
    said = call("check", scene(tmp_path, "&method model='nmm' /\n&cover edge=0.5 /\n&cracks strength=1e6 1e6 1e6 /\n&scene rectangle=-9 -9 9 9 /"))
    assert said.returncode == 2 and "scene.rectangle" in said.stderr, said.stderr


def test_the_log_and_explain_say_it(tmp_path):
    deck = scene(tmp_path, "&scene rectangle=-1 -5 4 9 /")
    log = call("run", deck, "-o", tmp_path / "r.h5").stdout
    assert "block 3 left the scene at time 0.76" in log or "block 3 left the scene at time 0.75" in log, log
    assert "scene.rectangle = -1 -5 4 9" in " ".join(call("explain", deck).stdout.split()) and "leaves it is removed" in call("explain", "scene.rectangle").stdout


def test_a_model_has_it(tmp_path):
    model = scree.Model.read(scene(tmp_path, "&scene rectangle=-1 -5 4 9 /"))
    assert list(model["scene.rectangle"]) == [-1, -5, 4, 9]
    first = model.save(tmp_path / "first.ana")
    assert scree.Model.read(first).save(tmp_path / "second.ana").read_text() == first.read_text().replace("first.blk", "second.blk")
    assert list(model.run(output=tmp_path / "m.h5").departures.block) == [3, 2]
    with pytest.raises(RunFailed):
        model["scene.rectangle"] = [4, 0, 1, 3]
        model.run(output=tmp_path / "n.h5")


def test_the_summary_says_what_left_with_blocks(tmp_path):
    """What is supplied is what friction, damping and blocks that leave take, and the rest."""
    deck = scene(tmp_path, "&scene rectangle=-1 -5 4 9 /", weight=25000.0, steps=180)
    done = call("run", deck, "-o", tmp_path / "x.h5")
    line = re.search(r"energy: (.*)", done.stdout)[1]
    given, friction, damping, removed, lost = (float(number) for number in re.search(
        r"(\S+) supplied; friction took (\S+), damping (\S+), blocks that left (\S+); (\S+) \(.* lost", line).groups())
    assert removed > 0.1 * given and given == pytest.approx(friction + damping + removed + lost, rel=2e-3)
