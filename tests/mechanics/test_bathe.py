"""Bathe's composite (Bathe and Baig 2005, Bathe 2007) through the program: its amplification, its order, its author's test, contact."""
import csv
import math
import os
import pathlib

import numpy as np
import pytest
import scree
from scree import block_files

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TRIANGLE = SOURCE / "input" / "paper" / "rotation" / "t4.ana"
PROTOTYPE = [row for row in csv.DictReader(line for line in (SOURCE / "tests/data/rotation/integrators.csv").read_text().splitlines()
                                           if not line.startswith("#")) if row["integrator"] == "Bathe composite"]
BATHE = "integrator.scheme=bathe"
E, RHO = 1e10, 2500.0
W = math.sqrt(12 * E / RHO)  # 1/s, of a free square of 1 m, nu 0, that breathes


def square(folder, steps, dt, *settings, unit_weight=0.0, speed=0.0, stress=0.0, edge=1.0, groups=""):
    folder.mkdir(exist_ok=True)
    corners = [(0, 0), (edge, 0), (edge, edge), (0, edge), (0, 0)]
    (folder / "b.blk").write_text("\n".join(["1 0 8", "0 0 1", "1 1 4", *(f"1 {x} {y}" for x, y in corners), *3 * ["0 0 0"],
                                             f"{edge / 2} {edge / 2} 1", ""]))
    (folder / "b.ana").write_text(f"1 {steps} 1 1 0.05 {dt} {RHO} {unit_weight} {E} 0 {stress} 0 0 0 0 0 {speed} 0 0 0 0 0\n"
                                  f"&deck geometry='b.blk' /\n{groups}\n")
    return scree.run(folder / "b.ana", settings=[BATHE, *settings])


def amplification(z):
    """Of x' = z x by a pair of steps of 1/2, a root at either end: 4/3 of the trapezoidal rule less 1/3, by the backward formula."""
    return (4 * (1 + z / 4) / (1 - z / 4) - 1) / (3 - z)


@pytest.mark.parametrize("row", PROTOTYPE, ids=lambda row: " ".join([row["start"], row["turns"]]))
def test_the_turning_triangle_is_that_of_the_prototype(row, tmp_path):
    """With Green strain, two steps of 5 ms as one of 10 ms: angle, angular momentum, stress. The trapezoidal rule has run away by then."""
    f = scree.run(TRIANGLE, output=tmp_path / "r.h5",
                  settings=[BATHE, f"integrator.start={row['start']}", "step.size=0.005", f"step.end_time={row['turns']}"])
    turned = np.unwrap(np.arctan2(*f.measured_points.position[:, 0].T[::-1]))
    turned += 2 * math.pi * round((2 * math.pi * 0.005 - turned[0] + math.pi / 6) / (2 * math.pi))
    angle = (turned[-1] - math.pi / 6) / (2 * math.pi * f.history.time[-1]) - 1
    start = RHO * math.sqrt(3) / 4 * 0.01 * 2 * math.pi * 0.01 * 5 / 12  # about the corner: rho A w (a^2/12 + a^2/3)
    stress = f.measured_points.stress[-63::2, 0]  # of pairs, the last 32
    major = stress[:, :2].mean(1) + np.hypot((stress[:, 0] - stress[:, 1]) / 2, stress[:, 2])
    assert 100 * angle == pytest.approx(float(row["angle_error_pct"]), rel=1e-7)
    assert 100 * (f.history.momentum[-1, 2] / start - 1) == pytest.approx(float(row["angular_momentum_drift_pct"]), rel=1e-6)
    assert 100 * (major / (RHO * (2 * math.pi * 0.1) ** 2 * 0.375) - 1).mean() == pytest.approx(float(row["stress_mean_error_pct"]), rel=1e-4)


@pytest.mark.parametrize("body, edge", [("dda", 1e-3), ("dda", 1.0), ("nmm", 1.0), ("nmm", 1e3)])
@pytest.mark.parametrize("periods", [0.02, 0.1, 0.6, 10.0])
def test_decay_and_period_are_those_of_the_amplification(periods, body, edge, tmp_path):
    """A square that breathes: its stress at the ends of pairs obeys s'' = 2 Re(R) s' - |R|^2 s, R of a pair of so many periods."""
    dt = math.pi * periods / W * edge
    f = square(tmp_path, 14, dt, stress=E * 1e-9, edge=edge, groups=f"&method strain='small', model='{body}' /")
    s = f.measured_points.stress[1::2, 0, 0] / (E * 1e-9)
    R = amplification(2j * W * dt / edge)
    np.testing.assert_allclose(s[2:], 2 * R.real * s[1:-1] - abs(R) ** 2 * s[:-2], atol=1e-9)
    assert np.abs(s).max() > 1e-4


@pytest.mark.parametrize("strain", ["small", "green"])
def test_a_free_fall_is_exact(strain, tmp_path):
    """Its velocity and its way, in steps of two sizes, as frames come between: the acceleration is constant."""
    f = square(tmp_path, 100, 0.01, "output.interval=0.025", unit_weight=25000, speed=3, groups=f"&method strain='{strain}' /")
    assert len(np.unique(np.diff(f.history.time).round(9))) == 2
    np.testing.assert_allclose(f.measured_points.position[:, 0, 1] - 0.5, -5 * f.history.time**2, atol=1e-10)
    np.testing.assert_allclose(f.measured_points.position[:, 0, 0] - 0.5, 3 * f.history.time, atol=1e-10)


@pytest.mark.parametrize("body", ["dda", "nmm"])
def test_it_is_of_second_order(body, tmp_path):
    """The square that breathes, over two periods; the damped way of a free one, (1 - exp(-alpha t)) v/alpha."""
    ring, slow = [], []
    for n in (40, 80, 160):
        f = square(tmp_path, 2 * n, 2 * math.pi / W / n, stress=E * 1e-9, groups=f"&method strain='small', model='{body}' /")
        ring.append(np.abs(f.measured_points.stress[:, 0, 0] / (E * 1e-9) - np.cos(W * f.history.time)).max())
        f = square(tmp_path, n, 1 / n, speed=1, groups=f"&method strain='small', model='{body}' /\n&damping mass=2 /")
        slow.append(abs(f.measured_points.position[-1, 0, 0] - 0.5 - (1 - math.exp(-2)) / 2))
    for errors in (ring, slow):
        assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.1)


def pendulum(folder, dt, turns, *settings):
    """A mass of 10 kg on a bar of 3.0443 m and 1e10 N, at 7.72 m/s and without weight; and the time of a turn."""
    l, k, v = 3.0443, 1e10 / 3.0443, 7.72
    period = 2 * math.pi * l / v
    blocks = [(1, block_files.box(-1, 1, -0.5, 0.5)), (1, block_files.box(-0.05, 0.05, -l - 0.05, -l + 0.05))]
    (folder / "p.blk").write_text(block_files.block_file("pendulum", blocks, block_files.held(blocks[0][1], 1), measured=[(0, -l, 2)]))
    (folder / "p.ana").write_text(f"1 {round(turns * period / dt)} 1 1 0.05 {dt} 1000 0 1e10 0 0 0 0 0 0 0 {v} 0 0 0 0 0\n"
                                  "&deck geometry='p.blk' /\n&method strain='green' /\n&contact method='none' /\n"
                                  f"&bolts ends=0 0 0 {-l}, stiffness={k} /\n")
    return scree.run(folder / "p.ana", settings=settings), period


@pytest.mark.parametrize("scheme", ["bathe", "generalized_alpha"])
def test_a_swing_on_a_bolt_is_of_second_order(scheme, tmp_path):
    """The angle of the pendulum, from a start that knows the pull of its bar; of generalized-alpha too, as it shares the force of a bolt as
    that of an element."""
    errors = []
    for dt in (0.02, 0.01, 0.005):
        f, period = pendulum(tmp_path, dt, 6, f"integrator.scheme={scheme}", "integrator.start=consistent")
        place = f.measured_points.position[:, 0]
        errors.append(abs(np.unwrap(np.arctan2(place[:, 0], -place[:, 1]))[-1] / (2 * math.pi) - f.history.time[-1] / period))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1) and np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.1)


def test_the_stiff_pendulum_swings_on_where_the_trapezoidal_rule_runs_away(tmp_path):
    """Their test (Kuhl and Crisfield 1999, Bathe 2007): the bar keeps its length, and what it loses goes with the cube of the step."""
    lost = []
    for dt in (0.04, 0.02, 0.01):
        f, period = pendulum(tmp_path, dt, 6, BATHE)
        place, energy = f.measured_points.position[:, 0], f.history.energy
        left = (energy.kinetic + energy.bolts)[1::2] / (0.5 * 10 * 7.72**2)
        assert np.hypot(*place.T) == pytest.approx(3.0443, rel=1e-7)
        assert left.max() < 1 and (np.diff(left[2:]) < 0).all()
        lost.append(1 - left[-1])
        turned = np.unwrap(np.arctan2(place[:, 0], -place[:, 1]))[-1] / (2 * math.pi)
        assert turned == pytest.approx(f.history.time[-1] / period, rel=30 * dt**2 / 3.0443)
    assert np.log2(lost[0] / lost[1]) == pytest.approx(3, abs=0.1) and np.log2(lost[1] / lost[2]) == pytest.approx(3, abs=0.1)
    with pytest.raises(scree.RunFailed, match="energy has come from nothing"):
        pendulum(tmp_path, 0.04, 6, "integrator.scheme=newmark", "integrator.beta=0.5", "integrator.gamma=0.25")


def test_blocks_that_rest_come_to_rest(tmp_path):
    """Contacts press with the force of the end of a step, and the second of two forgets what shakes in them. Impacts are warned of."""
    blocks = [block_files.box(*sides) for sides in ((-1, 2, -1, 0), (0, 1, 0, 1), (0, 1, 1, 2))]
    (tmp_path / "b.blk").write_text(block_files.on_base("Two blocks on a base", blocks))
    rock = "2500 25000 1e9 0.2 0 0 0 0 0 0 0 0 0"
    (tmp_path / "b.ana").write_text(f"1 400 2 1 0.05 0.005 {rock} {rock} 30 0 0\n&deck geometry='b.blk' /\n")
    said = "where blocks may meet, found 'bathe': its impacts make energy"
    assert said in scree.call("check", tmp_path / "b.ana", "--set", BATHE).stdout
    assert said not in scree.call("check", tmp_path / "b.ana", "--set", BATHE, "--set", "contact.method=none").stdout
    for strain in ("small", "green"):
        kinetic = scree.run(tmp_path / "b.ana", settings=[BATHE, f"method.strain={strain}"]).history.energy.kinetic
        assert kinetic[-100:].max() < 1e-12 * kinetic.max()
