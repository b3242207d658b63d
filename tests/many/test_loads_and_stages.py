"""Loads, the ground that shakes, damping, stages, removal and sleep in small steps."""
import numpy as np
import pytest
import scree
from scree.block_files import box, held
from small import DENSITY, G, decks, run, ways

FLOOR = box(-40, 40, -2, 0)


def test_point_and_edge_loads_push_a_block(tmp_path):
    """A force through the centroid without weight, and a traction of the same sum on a side."""
    blocks = [(1, FLOOR), (2, box(0, 1, 5, 6))]
    pushed = run(tmp_path, blocks, time=1.0, gravity=0.0, load=[(0.5, 5.5, 2)], groups="&loads force=5000 2500 /", name="a")
    drawn = run(tmp_path, blocks, time=1.0, gravity=0.0, name="b", groups="&boundary lines=0 5 0 6, traction=5000 2500 5000 2500 /")
    for result in (pushed, drawn):
        moved = result.bodies.centroid[-1, 1] - result.bodies.centroid[0, 1]
        assert moved[0] == pytest.approx(1.0, rel=1e-6)
        assert result.history.energy.work[-1] == pytest.approx(result.history.energy.kinetic[-1], rel=1e-9)
    assert pushed.bodies.rotation[-1, 1] == pytest.approx(0.0, abs=1e-9)


def test_the_ground_that_accelerates_takes_a_block_along(tmp_path):
    """Without friction a block stays behind the ground; that which friction holds goes with it."""
    groups = "&acceleration table=0 2 0 1 2 0 2 2 0 /"
    free = run(tmp_path, [(1, FLOOR), (2, box(0, 1, 0, 1))], time=1.0, phi=0.0, groups=groups)
    assert ways(free)[0] == pytest.approx(1.0, rel=1e-3)
    stuck = run(tmp_path, [(1, FLOOR), (2, box(0, 1, 0, 1))], time=1.0, phi=30.0, groups=groups)
    assert ways(stuck)[0] < 1e-3


def test_mass_damping_slows_a_block_as_its_law_has_it(tmp_path):
    result = run(tmp_path, [(1, FLOOR), (2, box(0, 1, 5, 6))], time=1.0, gravity=0.0, velocity=(2.0, 0.0, 0.0), groups="&damping mass=3 /")
    assert ways(result)[0] == pytest.approx(2 / 3 * (1 - np.exp(-3)), rel=1e-3)
    assert result.history.energy.damping[-1] == pytest.approx(DENSITY / 2 * 4 * (1 - np.exp(-6)), rel=1e-3)


def test_water_lifts_a_block(tmp_path):
    """Water pressure on all sides of a block above the floor is its weight in water."""
    groups = "&water table=-50 20 50 20, unit_weight=9810 /"
    result = run(tmp_path, [(1, FLOOR), (2, box(0, 1, 5, 6))], time=0.5, groups=groups)
    fall = result.bodies.centroid[0, 1, 1] - result.bodies.centroid[-1, 1, 1]
    assert fall == pytest.approx(G / 2 * 0.25 * (1 - 9810 / (DENSITY * G)), rel=1e-3)


def stages(folder):
    """A wall settles in a static stage; then a block of its lowest course is taken out and what lay on it falls."""
    boxes = [box(0, 1, 0, 1), box(1, 2, 0, 1), box(2, 3, 0, 1), box(0.5, 1.5, 1, 2), box(1.5, 2.5, 1, 2), box(1, 2, 2, 3)]
    files = decks(folder, [(1, FLOOR)] + [(2, b) for b in boxes], time=2.0, step=0.01, phi=35.0, scheme="", carried=0,
                  groups="&step balance=1e-6 /\n&stage name='fall', kind='dynamic', remove_blocks=2 3 /\n"
                         "&integrator scheme='small_steps' /\n&step size=0.005, end_time=0.5 /\n"
                         "&stage name='rest', kind='static' /\n&integrator scheme='newmark' /\n&step balance=1e-4, size=0.01 /")
    return files


def test_stages_hand_over_to_small_steps(tmp_path):
    """What rests does not move as small steps take it over: the forces of the static stage press on from the first step."""
    boxes = [box(-0.5, 0.5, k, k + 1) for k in range(8)]
    files = decks(tmp_path, [(1, FLOOR)] + [(2, b) for b in boxes], time=2.0, step=0.01, phi=35.0, scheme="", carried=0,
                  groups="&step balance=1e-6 /\n&stage name='move', kind='dynamic' /\n&integrator scheme='small_steps' /\n"
                         "&step size=0.005, end_time=0.2, sleep=0 /\n&output every=1 /")
    result = scree.run(*files, output=tmp_path / "x.h5")
    dynamic = np.flatnonzero(result.history.stage == 2)
    speed = np.linalg.norm(result.bodies.velocity, axis=-1)[1:]
    assert len(dynamic) == 40
    assert result.history.energy.kinetic[dynamic].max() < 1e-5 * 8 * DENSITY * G * 4
    forces = result.contacts_of(result.n_frames - 1)
    assert speed.shape[1] == 9 and forces is not None


def test_a_removed_block_lets_the_others_fall(tmp_path):
    result = scree.run(*stages(tmp_path), output=tmp_path / "x.h5")
    fall = result.bodies.centroid[0, :, 1] - result.bodies.centroid[-1, :, 1]
    assert fall[4] > 0.1
    assert result.history.energy.dissipated[-1] > 0


def test_what_rests_falls_asleep_and_wakes(tmp_path):
    """A stack sleeps until a block strikes it; then it moves as one that never slept."""
    boxes = [box(0, 1, k / 2, (k + 1) / 2) for k in range(4)] + [box(-4, -3.5, 1.0, 1.5)]
    blocks = [(1, FLOOR)] + [(1, b) for b in boxes[:-1]] + [(2, boxes[-1])]
    given = {"time": 1.5, "phi": 20.0, "velocity": (6.0, 4.0, 0.0)}
    asleep = run(tmp_path, blocks, "step.sleep=1e-3", name="a", **given)
    awake = run(tmp_path, blocks, "step.sleep=0", name="b", **given)
    counts = asleep.history.asleep
    assert counts.max() == 4 and counts[-1] < 4
    assert ways(awake)[:4].max() > 0.02
    assert np.abs(ways(asleep) - ways(awake)).max() < 0.1
