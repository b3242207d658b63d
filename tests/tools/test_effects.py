"""What effects cost where they are absent, far away or at rest: unknowns, entries, solutions and bits; instructions where valgrind
is there. No times."""
import os
import shutil

import numpy as np
import pytest
import scree
from scree.bench import effects
from scree.block_files import block_file, box
from scree.errors import RunFailed

SCREE = os.environ["SCREE"]
CASES = effects.cases(20)
FALL, ALONE = (CASES[name] for name in ("a block falls", "a block falls, no contact in the deck"))
SERIES = ["time", "momentum", "solves", "energy/kinetic", "energy/gravity", "rotation"]


def run(scene, folder, steps=40):
    folder.mkdir(exist_ok=True)
    return scree.run(*scene.with_more(last=steps).write(folder, "scene"), settings=scene.settings)


def size_of(r):
    """Unknowns and entries of the matrices that were solved last."""
    count = dict(zip(r.cost.work, r.cost["count"].tolist()))
    return count["unknowns"], count["entries"]


@pytest.mark.parametrize("scene, what", [(scene, what) for scene, what, bound in FALL
                                         if bound == effects.ABSENT and "stress" not in what])
def test_an_absent_effect_changes_no_bit(scene, what, tmp_path):
    r, without = run(scene, tmp_path / "with"), run(FALL[0][0], tmp_path / "without")
    assert size_of(r) == size_of(without) == (6, 36)
    for name in SERIES:
        assert np.array_equal(r.history[name], without.history[name]), name


@pytest.mark.parametrize("scene", [scene for scene, _, _ in ALONE[1:4]], ids=[what for _, what, _ in ALONE[1:4]])
def test_what_is_fixed_or_far_has_no_unknowns_and_does_not_touch_what_moves(scene, tmp_path):
    """But for the rounding of coordinates, which count from the middle of the scene."""
    r, without = run(scene, tmp_path / "with"), run(ALONE[0][0], tmp_path / "without")
    assert size_of(r) == size_of(without) == (6, 36)
    assert np.array_equal(r.history.solves, without.history.solves)
    np.testing.assert_allclose(r.history.momentum[:, :2], without.history.momentum[:, :2], rtol=1e-9, atol=1e-6)
    np.testing.assert_allclose(r.history.energy.kinetic, without.history.energy.kinetic, rtol=1e-9)


def test_a_rock_on_a_fixed_slope_has_six_unknowns_and_check_says_so(tmp_path):
    scene = effects.on_slope(0.0)
    assert "2 blocks, 2 elements, 6 unknowns" in scree.call("check", *scene.write(tmp_path, "slope")).stdout
    assert size_of(run(scene, tmp_path)) == (6, 36)


@pytest.mark.parametrize("points, unknowns", [([(0.1, 0.1), (0.9, 0.1), (0.1, 0.9)], 0), ([(0.1, 0.1), (0.5, 0.1), (0.9, 0.1)], 2),
                                              ([(0.1, 0.1), (0.9, 0.1)], 2), ([(0.1, 0.1)], 4), ([], 6)])
@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
def test_check_prints_the_unknowns_that_fixed_points_leave(points, unknowns, edge, tmp_path):
    """A point takes two; on a line the third says nothing new."""
    (tmp_path / "block.blk").write_text(block_file(
        "block", [(1, box(0, edge, 0, edge))], [(edge * x, edge * y, 1) for x, y in points]))
    (tmp_path / "block.ana").write_text("1 1 1 1 0.05 0.005\n2500 24525 1e10 0.25 0 0 0 0 0 0 0 0 0\n30 0 0\n&deck dialect='short' /\n")
    said = scree.call("check", tmp_path / "block.blk", tmp_path / "block.ana").stdout
    assert f"1 blocks, 1 elements, {unknowns} unknowns" in said


@pytest.mark.parametrize("model", ["dda", "nmm"])
@pytest.mark.parametrize("strain", ["small", "green"])
def test_a_block_that_rests_on_a_fixed_one_bears_its_weight(model, strain, tmp_path):
    """The forces of its contacts add up to its weight, though the ground is no part of the system."""
    scene = effects.on_ground(1).with_more(groups=f"&method model='{model}', strain='{strain}' /", settings=["output.every=1", *effects.AWAKE])
    r = run(scene, tmp_path, 400)
    contacts = r.contacts_of(-1)
    assert len(contacts) == 2
    assert abs((contacts.force[:, :1] * contacts.normal)[:, 1].sum()) == pytest.approx(effects.DENSITY * effects.GRAVITY, rel=1e-3)
    assert size_of(r) == (6, 36)


def test_instructions_are_those_outside_of_the_c_library_and_the_timers():
    profile = """events: Ir

ob=(1) /bin/scree
fn=(1) advance
10 7
+1 5
cob=(2) /usr/lib/libc.so.6
cfn=(2) malloc
calls=2 30
+3 1000
* 2

ob=(2)
fn=(2)
30 900
+5 100

ob=(3) /usr/lib/libopenblas.so
fn=(3) dgemm
-4 40

ob=(1)
fn=(4) __scree_timers_MOD_begin_phase
5 600
"""
    assert effects.own_instructions(profile) == 7 + 5 + 2 + 40


INSTRUCTIONS = {}  # of a step of each base, where it was counted


def instructions(scene, folder):
    """Instructions of a step of a scene."""
    return effects.measure(scene, effects.Counter(SCREE), folder, allocations=False)["instructions"]


@pytest.mark.skipif(not shutil.which("valgrind"), reason="instructions are counted by valgrind")
@pytest.mark.parametrize("base, what, most", [
    ("a block falls", "with damping 0", 1.001),
    ("a block rests, awake (`step.sleep=0`), on a ground of 4 vertices", "with restitution", 1.003),
    ("a block rests, awake (`step.sleep=0`), on a ground of 4 vertices", "on one of 1003", 1.1),
    ("a block rests, awake (`step.sleep=0`), on a ground of 4 vertices", "beside 100 fixed blocks far away", 1.25),
    ("a block falls, no contact in the deck", "above a fixed slope, with contact", 2.0),
    ("two blocks fall 10 sizes apart, no contact in the deck", "with contact", 1.07)])
def test_the_instructions_of_a_step_hardly_grow(base, what, most, tmp_path):
    """Bounds lie a little above the table of doc/notes/effects-2026-11.md."""
    rows = {name: scene for scene, name, _ in CASES[base]}
    try:
        if base not in INSTRUCTIONS:
            INSTRUCTIONS[base] = instructions(rows[""], tmp_path)
        with_it = instructions(rows[what], tmp_path)
    except RunFailed as problem:
        pytest.skip(f"valgrind does not run this build: {problem}")
    assert with_it <= most * INSTRUCTIONS[base]
