"""A body that nothing acts on but, at most, a support about which it turns, by the default integrator of Green strain, through the program."""
import math

import numpy as np
import pytest
import scree

RHO, SQUARE = 2500.0, ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5))
GREEN = "&method strain='green' /"
BODIES = {"dda": GREEN, "auto": "&method strain='auto' /", "nmm": "&method model='nmm', strain='green' /",
          "mesh": "&method model='nmm', strain='green' /\n&cover edge={mesh} /"}


def spin(folder, degrees, body="dda", edge=1.0, steps=80, fixed=(), speed=0.0, E=1e10, groups=""):
    """Results of a square that turns by an angle in each step of 5 ms (sqrt(edge) times as long), about its centroid or its fixed point;
    and the strain that its spin makes, rho w^2 r^2/E."""
    dt = 0.005 * math.sqrt(edge)
    w = 2 * math.tan(math.radians(degrees) / 2) / dt
    folder.mkdir(exist_ok=True)
    corners = [(edge * x, edge * y) for x, y in SQUARE]
    (folder / "spin.blk").write_text("\n".join(["1 0 8", f"{len(fixed)} 0 0", "1 1 4", *(f"1 {x} {y}" for x, y in [*corners, corners[0]]),
                                                *3 * ["0 0 0"], *(f"{edge * x} {edge * y} 1" for x, y in fixed), ""]))
    vx, vy = (w * fixed[0][1] * edge, -w * fixed[0][0] * edge) if fixed else (speed, 0.0)
    (folder / "spin.ana").write_text(f"1\n{steps}\n1\n1\n0.05\n{dt}\n0\n{'0 ' * len(fixed)}\n{RHO} 0 {E * edge} 0.25\n0 0 0\n0 0 0\n"
                                     f"{vx} {vy} {w}\n0 0 0\n&deck geometry='spin.blk', dialect='shi' /\n"
                                     f"{BODIES[body].format(mesh=0.3 * edge)}\n{groups}\n")
    return scree.run(folder / "spin.ana"), RHO * w**2 * edge / E * (2.0 if fixed else 0.5)


def no_step_gains(energy):
    return np.diff(energy.dissipated, prepend=0.0).min() > -1e-13 * energy.kinetic[0]


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("degrees", [3.6, 30, 90])
def test_a_free_body_keeps_its_spin(degrees, body, tmp_path):
    """However far it turns in a step. What the stress of its spin takes to come about, of which the integrator holds 1/16, is the
    error; then it is round-off, of E dt^2/rho times that of inertia."""
    f, strain = spin(tmp_path, degrees, body)
    L, turned = f.history.momentum[:, 2], np.diff(f.history.rotation[:, 0])
    assert np.abs(L / L[0] - 1).max() < strain / 16
    assert np.abs(turned / math.radians(degrees) - 1).max() < 2 * strain
    if degrees < 60:  # at 90 the stress turns so far in a step that it takes longer to come to rest
        exact = 2 * np.finfo(float).eps * 1e10 * 0.005**2 / RHO
        assert np.ptp(L[-20:]) < exact * L[0] and np.ptp(turned[-20:]) < exact
    assert no_step_gains(f.history.energy)


@pytest.mark.parametrize("edge", [1e-3, 1e3])
def test_spin_is_kept_in_any_size(edge, tmp_path):
    f, strain = spin(tmp_path, 30, edge=edge)
    L = f.history.momentum[:, 2]
    assert np.abs(L / L[0] - 1).max() < strain / 16 and np.ptp(L[-20:]) < 1e-10 * L[0]


@pytest.mark.parametrize("body", ["dda", "mesh"])
def test_drift_changes_nothing_in_spin(body, tmp_path):
    """Its centroid goes where its velocity says, and it turns as without: the scheme knows no frame."""
    still, drifting = (spin(tmp_path / f"{v}", 30, body, speed=v)[0] for v in (0.0, 50.0))
    np.testing.assert_allclose(drifting.history.rotation, still.history.rotation, rtol=1e-10)
    way = drifting.bodies.centroid[-1, 0] - drifting.bodies.centroid[0, 0]
    np.testing.assert_allclose(way, [50 * drifting.history.time[-1], 0], rtol=0, atol=1e-10)


@pytest.mark.parametrize("body", ["dda", "mesh"])
@pytest.mark.parametrize("groups", ["", "&fixed_points method='penalty' /"], ids=["exact", "springs"])
def test_a_body_turns_about_its_fixed_point_for_ever(groups, body, tmp_path):
    """Its energy is kept but for what its strain takes to come about. A spring that holds it acts as at the end of the step, and takes
    some 1e-7 of it in each, as the body stretches it in turning."""
    f, strain = spin(tmp_path, 30, body, fixed=((-0.5, -0.5),), groups=groups)
    e = f.history.energy
    kept = e.kinetic + e.strain + (e.fixed_springs if groups else 0.0)
    assert abs(kept[-1] / kept[0] - 1) < strain / 2 and np.ptp(kept[-20:]) < (5e-6 if groups else 1e-9) * kept[0]
    assert no_step_gains(e)


def test_stress_that_the_spin_does_not_make_dies_out(tmp_path):
    """A block begins without the stress of its spin, and its breathing, ten times too fast for the steps, comes to rest while it spins:
    by far more than the 1e-5 that is asked, and that the energy-momentum form does not do in a hundred steps."""
    left = []
    for scheme in ("energy_decaying", "energy_momentum"):
        f, _ = spin(tmp_path / scheme, 30, steps=120, groups=f"&integrator scheme='{scheme}' /")
        off = np.abs(f.history.energy.strain / f.history.energy.strain[-1] - 1)
        left.append(off[24:100].max() / off[2])
    assert left[0] < 1e-5 < left[1]
