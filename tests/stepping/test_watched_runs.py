"""Runs that make nonsense stop by name, runs that are right do not, and a run that stops says where, why and what to try."""
import os
import pathlib
import re

import numpy as np
import pytest
import scree

FREE_FALL = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tests" / "data" / "classic" / "freefall"
MODES = {"small": "&method strain='small' /", "green": "&method strain='green' /", "nmm": "&method model='nmm', strain='small' /",
         "nmm green": "&method model='nmm', strain='green' /"}


def run(folder, blocks, analysis, *, fixed=(), status=0):
    """Runs boxes x, y, width, height, material; returns what the run said, and its results."""
    head, rows, at = [], [], 1
    for x, y, w, h, material in blocks:
        head.append(f"{material} {at} {at + 3}")
        rows += [f"1 {a} {b}" for a, b in ((x, y), (x + w, y), (x + w, y + h), (x, y + h), (x, y))] + ["0 0 0"] * 3
        at += 8
    points = [f"{x} {y} {block}" for x, y, block in fixed]
    (folder / "x.blk").write_text("\n".join([f"{len(blocks)} 0 {len(rows)}", f"{len(fixed)} 0 0", *head, *rows, *points, ""]))
    (folder / "x.ana").write_text(analysis)
    done = scree.call("run", folder / "x.blk", folder / "x.ana", "-o", folder / "x.h5", "--quiet", timeout=300)
    assert done.returncode == status, done.stderr
    return done.stderr, scree.read(folder / "x.h5")


def column(folder, a, density, mode, status, young=1e10, g=10.0, steps=400, more=""):
    """A block of edge a between a fixed floor and another whose density is given, for 400 steps of a fifth of a free fall."""
    dt = 0.02 * np.sqrt(2 * a / g)
    rock = [f"{rho} {rho * g} {young} 0.25\n0 0 0\n0 0 0\n0 0 0\n" for rho in (2500.0, density)]
    fixed = [(-4.9 * a, -1.9 * a, 1), (4.9 * a, -1.9 * a, 1), (4.9 * a, -0.1 * a, 1), (-4.9 * a, -0.1 * a, 1)]
    return run(folder, [(-5 * a, -2 * a, 10 * a, 2 * a, 1), (-a / 2, 0.0, a, a, 1), (-a / 2, a, a, a, 2)],
               f"1 {steps} 2 1 0.05 {float(dt)}\n{''.join(rock)}30 0 0\n&deck dialect='short' /\n{MODES[mode]}\n{more}\n", fixed=fixed,
               status=status)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("a", [1e-3, 1.0, 1e3])
def test_a_block_under_more_than_it_can_bear_is_named_and_ends_the_run(a, mode, tmp_path):
    """Under three times its E: no small block of rock holds a mountain of lead. Springs of 50 E: softer ones let it through. Small
    strain ends where the stress passes E, Green strain where a tenth of the area is left."""
    said, f = column(tmp_path, a, 3 * 1e10 / (10.0 * a), mode, 1, more="&contact stiffness=5e11 /")
    last = said.splitlines()[-1]
    assert f.scene.status == "stopped: " + last.removeprefix("scree: ")[:len(f.scene.status) - len("stopped: ")]
    when, step = f.history.time, len(f.history.time)
    assert f.times[-1] == when[-1]  # what is named can be looked at
    area = f.bodies.area[-1] / f.bodies.area[0]
    worst = 2 if "block 2, (" in last else 3  # its own weight may crush the other, too
    assert last.startswith(f"scree: step {step} to time ") and f"block {worst}, (" in last and "; try " in last, last
    if "green" in mode:
        assert not 0.1 < area[worst - 1] < 10
    else:
        over = float(re.search(r"under a stress of \S+, which is (\S+) of its stiffness", last).group(1))
        assert 1 < over < 1.2 and area[worst - 1] < 0.5, last
    assert "warning: time " in said and said.count("warning: ") <= 4, said


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("a", [1e-3, 1.0, 1e3])
def test_a_block_under_a_thousandth_of_what_it_bears_is_not_spoken_of(a, mode, tmp_path):
    """But for 2 km of rock without an initial stress, which `check` warns of."""
    said, _ = column(tmp_path, a, 1e-3 * 1e10 / (10.0 * a), mode, 0, steps=100)
    assert [line for line in said.splitlines() if "gamma H/E" not in line] == []


SPIN = "1 {steps} 1 1 0.05 {dt}\n2.5 0 1e7 0.25\n0 0 0\n0 0 0\n1 0 {spin}\n0 0 0\n&deck dialect='short' /\n{groups}\n"


@pytest.mark.parametrize("strain", ["small", "green"])
def test_energy_that_an_unstable_integrator_makes_is_named_and_ends_the_run(strain, tmp_path):
    """A displacement weight below half that of the velocity is stable in small steps alone: here 2 pi/frequency is 0.002 and less.
    The block moves at 1, and its energy is that to 1e-3, until what vibrates has grown."""
    said, f = run(tmp_path, [(0.0, 0.0, 1.0, 1.0, 1)], SPIN.format(
        steps=40, dt=0.001, spin=1.0, groups=f"&method strain='{strain}' /\n&integrator scheme='newmark', beta=0.5, gamma=0.05 /"),
        status=1)
    kinetic = f.history.energy.kinetic
    assert "energy has come from nothing" in said and "block 1, (" in said and "step.size" in said, said
    assert kinetic[0] == pytest.approx(1.25 + 2.5 / 12, rel=0.05) and kinetic[-1] > 5 * kinetic[0]


def test_growth_by_rotation_is_warned_of_once_and_goes_on(tmp_path):
    """A step turned by r grows small strain's area by 1 + r^2: by (1 + 0.1^2)^k for steps of 0.1 rad, the run of Shi's programs."""
    said, f = run(tmp_path, [(0.0, 0.0, 1.0, 1.0, 1)], SPIN.format(
        steps=60, dt=0.01, spin=10.0, groups="&method strain='small', mass='constant' /\n&integrator beta=0.5, transport='rates' /"))
    area = f.bodies.area[-1, 0]
    assert area > 1.5 and said.count("times its initial area") == 1 and "block 1, (" in said, said
    said, _ = run(tmp_path, [(0.0, 0.0, 1.0, 1.0, 1)], SPIN.format(steps=60, dt=0.01, spin=10.0, groups="&method strain='green' /"))
    assert said == ""


def test_frames_are_about_a_hundred_whatever_is_cut_and_bend_no_step(tmp_path):
    """A fall whose steps are cut by the way that they may go, against a frame for each of them."""
    for travel in (0.05, 0.01, 0.002):  # of half a block: 250 and more steps
        sizes = []
        for more in (["output.every=1"], []):
            f = scree.run(f"{FREE_FALL}.geo", f"{FREE_FALL}.ana", output=tmp_path / "x.h5", settings=[
                f"step.travel={travel}", "step.size=0.002", "step.end_time=0.5", *more])
            sizes.append(f.history.step_size)
            frames, when = f.times, f.history.time
        np.testing.assert_array_equal(*sizes)
        assert len(frames) == 101 and len(when) >= 250
        np.testing.assert_array_equal(frames[1:], when[np.searchsorted(when, np.arange(1, 101) * 0.005 * (1 - 1e-9))])


@pytest.mark.parametrize("groups, words", [
    ("&iteration most=1, tolerance=1e-20 /\n&step least=0.01 /\n", ("did not settle", "step.least", "iteration.method=newton")),
    ("&step travel=1e-9, least=0.01 /\n", ("step.travel", "fell below step.least, 0.01"))])
def test_a_step_that_fails_says_which_block_where_when_and_what_to_try(groups, words, tmp_path):
    said, _ = run(tmp_path, [(5.0, 0.0, 1.0, 1.0, 1), (10.0, 0.0, 1.0, 1.0, 2)],
                  "1 20 2 1 0.1 0.05\n1 0 1e3 0\n0 0 0\n0 0 0\n0 0 0\n1 0 1e3 0\n0 0 0\n0 0 0\n1 0 1\n0 0 0\n"
                  f"&deck dialect='short' /\n&method strain='green' /\n{groups}", status=1)
    assert said.startswith("scree: step 1 from time 0: block 2, (10.5, 0.5): ") and len(said.splitlines()) == 1
    assert all(word in said for word in ("; try ", *words)), said


def test_fixed_points_that_contradict_are_named_by_their_block(tmp_path):
    (tmp_path / "x.geo").write_text("1e-3 4 0 0 0 2 0 0 0\n0 0 1 0 1\n1 0 1 1 1\n1 1 0 1 1\n0 1 0 0 1\n0 0 0 0\n0 0 0 0\n")
    (tmp_path / "x.ana").write_text("0 20 1 0 0.1 0.05 0  2 2  0 0 0 1 1 0  0 0 0 1 -1 0  1 0 1e3 0  0 0 0  0 0 0  0 0 0\n")
    done = scree.call("run", tmp_path / "x.geo", tmp_path / "x.ana", "-o", tmp_path / "x.h5", "--quiet")
    assert done.returncode == 1 and "block 1, (0.5, 0.5): its fixed points" in done.stderr, done.stderr


def test_contacts_that_do_not_settle_are_named_by_their_blocks_and_place(tmp_path):
    """Shi's rules at steps too large, which may not be cut: the place is a vertex of the one block, at the outline of the other."""
    classic = FREE_FALL.parent / "circleslope"
    done = scree.call("run", f"{classic}.geo", f"{classic}.ana", "-o", tmp_path / "x.h5", "--quiet", "--set", "method.preset=shi",
                      "--set", "step.size=0.05", "--set", "step.least=0.05")
    found = re.fullmatch(r"scree: step 1 from time 0: block (\d+) at block (\d+), \(([^,]*), ([^)]*)\): contacts did not settle in "
                         r"\d+ open-close iterations, \d+ still change; the step size fell below step.least, 0.05; try .*\n",
                         done.stderr)
    assert done.returncode == 1 and found, done.stderr
    place = np.array([float(x) for x in found.groups()[2:]])
    f = scree.read(tmp_path / "x.h5")
    one, other = (f.polygons(0)[int(b) - 1] for b in found.groups()[:2])
    size = np.ptp(f.vertices(0), 0).max()
    assert np.linalg.norm(one - place, axis=1).min() < 1e-5 * size  # six digits are said
    along = np.roll(other, -1, 0) - other
    share = np.clip(((place - other) * along).sum(1) / (along**2).sum(1), 0, 1)
    assert np.linalg.norm(other + share[:, None] * along - place, axis=1).min() < 0.05 * size
