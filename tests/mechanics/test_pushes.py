"""A free body that is pushed, against the integral of its push, through the program."""
import numpy as np
import pytest
import scree

MASS = 2500.0
QUIET = {"dda": "&method model='dda' /", "green": "&method strain='green' /", "nmm": "&method model='nmm' /",
         "nmm green": "&method model='nmm', strain='green' /"}
BODIES = {name: groups + ("\n&integrator scheme='energy_momentum' /" if "green" in name else "\n&integrator gamma=0.5 /")
          for name, groups in QUIET.items()}
PUSH = np.array([[0, 2500, 500], [0.25, 2500, 500], [0.25 + 2**-20, 0, 0]])  # it ends within a step, but at steps of 10 ms
HAT = np.array([[0.05, 0, 0], [0.15, 2e4, -3e3], [0.2, 5e3, 1e4], [0.45, 0, 0]])


def run(folder, table, steps, dt, groups, carried=1, fixed=(), E=1e10):
    """Pushes a square of 1 m at its centroid; returns the results."""
    (folder / "push.blk").write_text("\n".join(["1 0 8", f"{len(fixed)} 1 1", "1 1 4", *(f"1 {x} {y}" for x, y in (
        (0, 0), (1, 0), (1, 1), (0, 1), (0, 0))), *3 * ["0 0 0"], *(f"{x} {y} 1" for x, y in fixed), *2 * ["0.5 0.5 1"], ""]))
    rows = "\n".join(" ".join(str(float(x)) for x in row) for row in table)
    (folder / "push.ana").write_text(f"{carried}\n{steps}\n1\n0\n0.05\n{dt}\n0\n{'0 ' * len(fixed)}{len(table)}\n{rows}\n"
                                     f"{MASS} 0 {E} 0.25\n0 0 0\n0 0 0\n0 0 0\n&deck geometry='push.blk', dialect='shi' /\n"
                                     f"&output every=1 /\n{groups}\n")
    return scree.run(folder / "push.ana")


def impulse(table, times):
    """Integral of the lines of a table up to each of the times; its ends last."""
    t = np.unique([0.0, *table[:, 0], *times])
    f = np.array([np.interp(t, table[:, 0], column) for column in table[:, 1:].T]).T
    total = np.vstack([[0, 0], np.cumsum(np.diff(t)[:, None] * (f[1:] + f[:-1]) / 2, 0)])
    return total[np.searchsorted(t, times)]


@pytest.mark.parametrize("body", BODIES)
@pytest.mark.parametrize("dt", [0.004, 0.007, 0.01, 0.02, 0.19])
@pytest.mark.parametrize("table", [PUSH, HAT], ids=["push", "hat"])
def test_a_push_gives_its_impulse_at_any_step(table, dt, body, tmp_path):
    """At the end of each step, whatever the push does within; its work is the kinetic energy that it gives. Round-off alone: of
    the largest force of a step, which for a long one is that of the stiffness, E dt^2/rho times that of inertia."""
    exact = max(1e-12, np.finfo(float).eps * 1e10 * dt**2 / MASS)
    f = run(tmp_path, table, round(0.6 / dt), dt, BODIES[body])
    velocity = impulse(table, f.history.time) / MASS
    kinetic = MASS * (velocity**2).sum(1) / 2
    np.testing.assert_allclose(f.measured_points.velocity[:, 0], velocity, rtol=0, atol=exact * np.abs(velocity).max())
    for name, energy in (("kinetic", kinetic), ("work", kinetic), ("dissipated", 0)):
        np.testing.assert_allclose(f.history.energy[name], energy, rtol=0, atol=exact * kinetic.max())


@pytest.mark.parametrize("body", QUIET)
@pytest.mark.parametrize("table", [PUSH, HAT], ids=["push", "hat"])
def test_a_quiet_step_keeps_the_impulse_and_loses_what_its_change_takes(table, body, tmp_path):
    """By default gamma exceeds beta/2 by 1/16. The velocity is exact none the less; the way is its trapezoidal sum and 1/16 of the
    last step's change of velocity times dt; each step loses (1/16) M/2 of the square of the change of that change, and holds
    (1/16) M/2 of its own square. Round-off of the stiffness, as above."""
    dt = 0.01
    f = run(tmp_path, table, 60, dt, QUIET[body])
    velocity = impulse(table, f.history.time) / MASS
    change = np.diff(velocity, axis=0, prepend=0)
    way = np.cumsum(velocity - change / 2, axis=0) * dt + change * dt / 16
    held = MASS / 32 * (change**2).sum(1)
    lost = MASS / 32 * np.cumsum((np.diff(change, axis=0, prepend=0)**2).sum(1))
    exact = np.finfo(float).eps * 1e10 * dt**2 / MASS
    np.testing.assert_allclose(f.measured_points.velocity[:, 0], velocity, rtol=0, atol=exact * np.abs(velocity).max())
    np.testing.assert_allclose(f.measured_points.displacement[:, 0], way, rtol=0, atol=exact * np.abs(way).max())
    most = f.history.energy.kinetic.max()
    assert lost[-1] > 1e-5 * most  # else nothing was proved
    np.testing.assert_allclose(f.history.energy.held, held, rtol=0, atol=exact * most)
    np.testing.assert_allclose(f.history.energy.dissipated, lost, rtol=0, atol=10 * exact * most)


@pytest.mark.parametrize("integrator", ["beta=1, gamma=0.5", "beta=1, gamma=0.5625", "beta=0.5, gamma=0.25", "beta=0.8",
                                        "beta=0.7, gamma=0.5"])
def test_what_a_push_moves_converges_with_the_square_of_the_step(integrator, tmp_path):
    """Displacement, and with it the work. The corners of the push fall anywhere in a step, so the order is that of three
    halvings."""
    wrong, work = [], []
    for n in (35, 70, 140, 280):
        f = run(tmp_path, HAT, n, 0.7 / n, f"&integrator scheme='newmark', {integrator} /")
        every = 70000 // n
        velocity = impulse(HAT, np.linspace(0, 0.7, 70001)) / MASS
        way = np.cumsum((velocity[1:] + velocity[:-1]) / 2, 0)[every - 1::every] * 1e-5
        wrong.append(np.abs(f.measured_points.displacement[:, 0] - way).max() / np.abs(way).max())
        energy = MASS * (velocity[every::every]**2).sum(1) / 2
        work.append(np.abs(f.history.energy.work - energy).max() / energy.max())
    assert wrong[-1] < 1e-4 and np.log2(wrong[0] / wrong[-1]) / 3 > 1.8, wrong
    if integrator == "beta=1, gamma=0.5":
        assert max(work) < 1e-12, work
    else:
        assert work[-1] < 1e-3 and np.log2(work[0] / work[-1]) / 3 > 1.8, work


@pytest.mark.parametrize("groups", ["", "&method strain='green' /"])
def test_a_static_step_balances_the_load_of_its_end(groups, tmp_path):
    """A held square that is pulled ever harder, at rest in each step: the stress follows the load without delay. Inertia, a
    millionth of the stiffness at this step, is what it is off by."""
    ramp = np.array([[0, 0, 0], [10, 1e4, 0]])
    f = run(tmp_path, ramp, 10, 1.0, groups, carried=0, fixed=[(0, 0), (0, 1)], E=1e9)
    moved = f.measured_points.displacement[:, 0, 0]
    np.testing.assert_allclose(moved / moved[-1], np.arange(1, 11) / 10, atol=1e-4)


def test_shis_programs_take_the_load_of_the_end_of_the_step(tmp_path):
    """His value at that time, held for the step; without the preset its mean."""
    ramp = np.array([[0, 0, 0], [1, 1e4, 0]])
    t = 0.05 * np.arange(1, 13)
    for groups, load in (("&method preset='shi' /", 1e4 * t), ("", 1e4 * (t - 0.025))):
        f = run(tmp_path, ramp, 12, 0.05, groups)
        velocity = np.cumsum(load) * 0.05 / MASS
        np.testing.assert_allclose(f.measured_points.velocity[:, 0, 0], velocity, rtol=1e-9)
