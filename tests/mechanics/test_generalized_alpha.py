"""The generalized-alpha method of Chung and Hulbert (1993) through the program: its order, its dissipation, its limits, contact."""
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
                                           if not line.startswith("#"))
             if not row["integrator"].startswith("Bathe")
             and not (row["integrator"].startswith("Average") and row["turns"] == "5")]  # by then its energy has run away from round-off
E, RHO = 1e10, 2500.0


def ga(rho):
    return ["integrator.scheme=generalized_alpha", f"integrator.rho={rho}"]


def breathing(folder, steps, dt, *settings, edge=1.0, strain=1e-9, groups="&method strain='small' /"):
    """A free square that a stress sets ringing: s11 = E strain cos(w t), w^2 = 12 E/(rho edge^2), as nu is 0."""
    folder.mkdir(exist_ok=True)
    corners = [(0, 0), (edge, 0), (edge, edge), (0, edge)]
    (folder / "b.blk").write_text("\n".join(["1 0 8", "0 0 1", "1 1 4", *(f"1 {x} {y}" for x, y in [*corners, (0, 0)]),
                                             *3 * ["0 0 0"], f"{edge / 2} {edge / 2} 1", ""]))
    (folder / "b.ana").write_text(f"1 {steps} 1 1 0.05 {dt} {RHO} 0 {E} 0 {E * strain} 0 0 0 0 0 0 0 0 0 0 0\n"
                                  f"&deck geometry='b.blk' /\n{groups}\n")
    f = scree.run(folder / "b.ana", settings=settings)
    return f.history.time, f.measured_points.stress[:, 0, 0] / (E * strain), f


W = math.sqrt(12 * E / RHO)  # 1/s, of the square of 1 m


@pytest.mark.parametrize("row", PROTOTYPE, ids=lambda row: " ".join([row["integrator"], row["start"], row["turns"]]))
def test_the_turning_triangle_is_that_of_the_prototype(row, tmp_path):
    """With Green strain: angle and angular momentum to the digits that both iterate to."""
    rho = float(row["integrator"].split("rho=")[1]) if "rho" in row["integrator"] else 1.0
    f = scree.run(TRIANGLE, output=tmp_path / "r.h5",
                  settings=[*ga(rho), f"integrator.start={row['start']}", f"step.end_time={row['turns']}"])
    turned = np.unwrap(np.arctan2(*f.measured_points.position[:, 0].T[::-1]))
    turned += 2 * math.pi * round((2 * math.pi * 0.01 - turned[0] + math.pi / 6) / (2 * math.pi))
    angle = (turned[-1] - math.pi / 6) / (2 * math.pi * f.history.time[-1]) - 1
    start = RHO * math.sqrt(3) / 4 * 0.01 * 2 * math.pi * 0.01 * 5 / 12  # about the corner: rho A w (a^2/12 + a^2/3)
    momentum = f.history.momentum[-1, 2] / start - 1
    assert 100 * angle == pytest.approx(float(row["angle_error_pct"]), rel=1e-5, abs=1e-6)
    assert 100 * momentum == pytest.approx(float(row["angular_momentum_drift_pct"]), rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("body", ["dda", "nmm"])
@pytest.mark.parametrize("rho", [0, 0.5, 1])
def test_it_is_of_second_order(rho, body, tmp_path):
    """Over two periods, at most 1/20 of one a step."""
    errors = []
    for n in (40, 80, 160):
        t, s, _ = breathing(tmp_path, 2 * n, 2 * math.pi / W / n, *ga(rho), groups=f"&method strain='small', model='{body}' /")
        errors.append(np.abs(s - np.cos(W * t)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.15)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("rho", [0.2, 0.5, 0.8])
def test_what_no_step_can_follow_dies_out_by_rho_in_each(rho, edge, tmp_path):
    """A hundred thousand periods of the square a step: its stress leaves nothing of (z + rho)^3."""
    _, s, _ = breathing(tmp_path, 12, 1e5 * 2 * math.pi / W * edge, *ga(rho), "integrator.start=zero", edge=edge)
    left = s[3:] + 3 * rho * s[2:-1] + 3 * rho**2 * s[1:-2] + rho**3 * s[:-3]
    assert np.abs(left[1:]).max() < 1e-7 * np.abs(s).max()
    assert np.abs(s[-1]) < 100 * rho**12


def test_rho_of_1_is_the_trapezoidal_rule(tmp_path):
    """It keeps the energy of a linear problem, and is Newmark with beta 1/2 and gamma 1/4, to round-off."""
    t, s, f = breathing(tmp_path / "a", 400, 1e-4, *ga(1))
    _, trapezoidal, _ = breathing(tmp_path / "b", 400, 1e-4, "integrator.beta=0.5", "integrator.gamma=0.25")
    np.testing.assert_allclose(s, trapezoidal, atol=1e-9)
    energy = f.history.energy.kinetic + f.history.energy.strain
    np.testing.assert_allclose(energy[1:], energy[1], rtol=1e-7)


@pytest.mark.parametrize("strain", ["small", "green"])
def test_a_free_fall_is_exact_with_any_rho(strain, tmp_path):
    """Its velocity and its way, of which a first step with beta 1 and gamma 1/2 leaves nothing: the acceleration is constant."""
    for rho in (0, 0.3, 1):
        (tmp_path / "b.blk").write_text("1 0 8\n0 0 1\n1 1 4\n1 0 0\n1 1 0\n1 1 1\n1 0 1\n1 0 0\n0 0 0\n0 0 0\n0 0 0\n0.5 0.5 1\n")
        (tmp_path / "b.ana").write_text("1 100 1 1 0.05 0.01 2500 25000 1e10 0.2 0 0 0 0 0 0 3 0 0 0 0 0\n"
                                        f"&deck geometry='b.blk' /\n&method strain='{strain}' /\n")
        f = scree.run(tmp_path / "b.ana", settings=ga(rho))
        t = f.history.time
        np.testing.assert_allclose(f.measured_points.position[:, 0, 1] - 0.5, -5 * t**2, atol=1e-10)
        np.testing.assert_allclose(f.measured_points.position[:, 0, 0] - 0.5, 3 * t, atol=1e-10)


@pytest.mark.parametrize("settings", [ga(0), ga(0.5), ga(1), ["integrator.scheme=central_difference"]], ids=lambda s: s[-1])
def test_mass_damping_is_of_second_order(settings, tmp_path):
    """A free block comes to (1 - exp(-alpha t)) v0/alpha; the books know what damping took."""
    (tmp_path / "b.blk").write_text("1 0 8\n0 0 1\n1 1 4\n1 0 0\n1 1 0\n1 1 1\n1 0 1\n1 0 0\n0 0 0\n0 0 0\n0 0 0\n0.5 0.5 1\n")
    (tmp_path / "b.ana").write_text("1 1 1 1 0.05 1 2500 0 1e5 0.2 0 0 0 0 0 0 1 0 0 0 0 0\n&deck geometry='b.blk' /\n&damping mass=2 /\n")
    errors = []
    for dt in (0.02, 0.01, 0.005):
        f = scree.run(tmp_path / "b.ana", settings=[*settings, f"step.size={dt}", "step.end_time=1"])
        errors.append(abs(f.measured_points.position[-1, 0, 0] - 0.5 - (1 - math.exp(-2)) / 2))
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.1)
    assert f.history.energy.damping[-1] == pytest.approx(1250 * (1 - math.exp(-4)), rel=1e-3)


def test_blocks_that_rest_come_to_rest(tmp_path):
    """Contacts press with the force of the end of the step, and die out by rho in each as well."""
    blocks = [block_files.box(*sides) for sides in ((-1, 2, -1, 0), (0, 1, 0, 1), (0, 1, 1, 2))]
    (tmp_path / "b.blk").write_text(block_files.on_base("Two blocks on a base", blocks))
    rock = "2500 25000 1e9 0.2 0 0 0 0 0 0 0 0 0"
    (tmp_path / "b.ana").write_text(f"1 400 2 1 0.05 0.005 {rock} {rock} 30 0 0\n&deck geometry='b.blk' /\n")
    for strain in ("small", "green"):
        f = scree.run(tmp_path / "b.ana", settings=[*ga(0.5), f"method.strain={strain}"])
        kinetic = f.history.energy.kinetic
        assert kinetic[-100:].max() < 1e-12 * kinetic.max()
