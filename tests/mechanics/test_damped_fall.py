"""Bodies with mass damping, against closed forms, through the program."""
import numpy as np
import pytest
import scree

ALPHA, G, DENSITY = 0.8, 9.81, 2.5
BODIES = {"dda": "&integrator gamma=0.5 /", "nmm": "&method model='nmm' /\n&cover edge=0.7 /\n&integrator gamma=0.5 /",
          "green": "&method model='nmm', strain='green' /\n&cover edge=0.7 /\n&integrator scheme='energy_momentum' /"}
STEPS = {"beta 1": "&integrator gamma=0.5 /", **{name: f"&integrator scheme='newmark'{given} /" for name, given in
                                                 (("quiet", ""), ("beta 0.8", ", beta=0.8"), ("beta 1/2", ", beta=0.5"),
                                                  ("acceleration at the start", ", beta=0.5, start='acceleration'"))}}


def run(folder, steps, dt, groups, velocity="0 0 0", carried=1, fixed=""):
    """Runs a heavy rectangle of 2 x 1; returns the results."""
    (folder / "box.geo").write_text(f"1e-3 4 4 0 0 {len(fixed.split()) // 4} 0 1 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n"
                                    f"{fixed}1.5 0.25\n")
    (folder / "box.ana").write_text(f"{carried} {steps} 1 0 0.05 {dt}\n{DENSITY} {DENSITY * G} 1e6 0.25\n0 0 0\n0 0 0\n"
                                    f"{velocity}\n&deck geometry='box.geo' /\n{groups}\n")
    return scree.run(folder / "box.ana")


@pytest.mark.parametrize("body", BODIES)
def test_a_fall_loses_in_each_step_what_the_step_says(body, tmp_path):
    """v goes to g/alpha by (1 - alpha dt/2)/(1 + alpha dt/2) a step, and all that is lost the damping took."""
    n = np.arange(1, 101)
    f = run(tmp_path, 100, 0.05, BODIES[body] + f"\n&damping mass={ALPHA} /")
    left = ((1 - ALPHA * 0.025) / (1 + ALPHA * 0.025)) ** n
    velocity = f.measured_points.velocity[:, 0]
    np.testing.assert_allclose(velocity[:, 1], -G / ALPHA * (1 - left), rtol=1e-9)
    np.testing.assert_allclose(velocity[:, 0], 0, atol=1e-9)
    damping, dissipated = f.history.energy.damping, f.history.energy.dissipated
    assert (np.diff(damping) > 0).all()
    np.testing.assert_allclose(damping, dissipated, rtol=1e-9, atol=1e-9 * dissipated[-1])
    assert "mass damping" in f.scene.effects


@pytest.mark.parametrize("dt", [0.01, 1.0, 2.5, 100.0])
def test_the_terminal_velocity_is_g_over_alpha(dt, tmp_path):
    """alpha dt of 0.008 to 80: beyond 2 the way there alternates, and still ends."""
    f = run(tmp_path, 4000, dt, f"&damping mass={ALPHA} /\n&output every=4000 /")
    assert f.measured_points.velocity[-1, 0, 1] == pytest.approx(-G / ALPHA, rel=1e-9)


@pytest.mark.parametrize("steps", STEPS)
def test_thrown_bodies_converge_with_the_square_of_the_step(steps, tmp_path):
    """Velocity and height of a block thrown upwards against the exact solution of v' = -g - alpha v."""
    error, books = [], []
    for n in (40, 80, 160):
        f = run(tmp_path, n, 2 / n, f"{STEPS[steps]}\n&damping mass={ALPHA} /", velocity="3 7 0")
        t = f.history.time
        gone = (1 - np.exp(-ALPHA * t)) / ALPHA
        u, v = f.measured_points.displacement[:, 0], f.measured_points.velocity[:, 0]
        error.append([np.abs(u[:, 0] - 3 * gone).max(), np.abs(u[:, 1] - (7 + G / ALPHA) * gone + G / ALPHA * t).max(),
                      np.abs(v[:, 0] - 3 * np.exp(-ALPHA * t)).max(),
                      np.abs(v[:, 1] - (7 + G / ALPHA) * np.exp(-ALPHA * t) + G / ALPHA).max()])
        books.append(np.abs(f.history.energy.damping - f.history.energy.dissipated).max())
    orders = np.log2(np.array(error[:-1]) / error[1:])
    assert (1.8 < orders).all() and (orders < 2.2).all()
    if steps in ("beta 1", "acceleration at the start"):  # v0 + v1 = 2 d/dt in every step
        assert books[-1] < 1e-9 * DENSITY * (3**2 + 7**2)
    else:
        assert books[-1] < 0.3 * books[-2]


def test_a_hanging_body_comes_to_rest_as_the_static_run_does(tmp_path):
    """Small strain adds up along the way, and the ways differ by strains of 1e-4."""
    groups = BODIES["nmm"]
    fixed = "0.1 0.1 0.1 0.1\n0.1 0.9 0.1 0.9\n"
    f = run(tmp_path, 30, 10.0, groups, carried=0, fixed=fixed)
    rest = f.measured_points.displacement[-1]
    f = run(tmp_path, 2000, 0.01, groups + "\n&damping mass=100 /", fixed=fixed)
    np.testing.assert_allclose(f.measured_points.displacement[-1], rest, rtol=3e-4)


def test_a_deck_without_damping_has_no_damping(tmp_path):
    f = run(tmp_path, 2, 0.01, "&damping mass=0 /")
    assert "damping" not in f.history.energy
    assert "mass damping" not in f.scene.effects
