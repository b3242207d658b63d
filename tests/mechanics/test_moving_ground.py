"""Free and fixed bodies on a ground that accelerates, against closed forms, through the program."""
import numpy as np
import pytest
import scree

GEOMETRY = "1e-3 4 4 0 0 0 0 1 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n1.5 0.25\n"
CLAMPED = "1e-3 4 4 0 0 2 0 1 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n0.1 0.1 0.1 0.1\n0.1 0.9 0.1 0.9\n1.5 0.25\n"
DENSITY = 2.5
BODIES = {"dda": "&integrator gamma=0.5 /", "nmm": "&method model='nmm' /\n&cover edge=0.7 /\n&integrator gamma=0.5 /",
          "green": "&method model='nmm', strain='green' /\n&cover edge=0.7 /\n&integrator scheme='energy_momentum' /"}
STEPS = {"shi": "&integrator gamma=0.5 /", "quiet": "", "trapezoidal": "&integrator beta=0.5, gamma=0.25, scheme='newmark' /",
         "damped": "&integrator beta=0.8, scheme='newmark' /"}


def run(folder, steps, dt, groups, weight=0.0, geometry=GEOMETRY):
    """Runs a rectangle of 2 x 1; returns the results."""
    (folder / "box.geo").write_text(geometry)
    (folder / "box.ana").write_text(f"1 {steps} 1 0 0.05 {dt}\n{DENSITY} {weight} 1e8 0.25\n0 0 0\n0 0 0\n0 0 0\n"
                                    f"&deck geometry='box.geo' /\n{groups}\n")
    return scree.run(folder / "box.ana")


def sine(folder, samples=4001):
    """A record of three seconds at 1 Hz as a file; its times, accelerations, and exact velocities and displacements of the
    ground at these times (those of the lines between the samples)."""
    t = np.linspace(0, 3, samples)
    a = np.column_stack([3 * np.sin(2 * np.pi * t), 2 * np.cos(2 * np.pi * t)])
    (folder / "quake.txt").write_text("# t ax ay\n" + "".join(f"{x} {y} {z} ! g\n" for x, y, z in
                                                              zip(t.tolist(), *a.T.tolist())))
    h = np.diff(t)[:, None]
    v = np.vstack([[0, 0], np.cumsum(h * (a[1:] + a[:-1]) / 2, 0)])
    d = np.vstack([[0, 0], np.cumsum(h * v[:-1] + h**2 * (2 * a[:-1] + a[1:]) / 6, 0)])
    return t, a, v, d


@pytest.mark.parametrize("body", BODIES)
def test_a_constant_acceleration_moves_a_free_body_along_a_parabola(body, tmp_path):
    """To round-off: of the largest force of a step, that of the stiffness, which is E dt^2/rho l^2 = 16000 times that of inertia."""
    f = run(tmp_path, 50, 0.02, BODIES[body] + "\n&acceleration table=0 3 -2  5 3 -2, scale=0.5 /")
    t = f.history.time
    np.testing.assert_allclose(f.measured_points.displacement[:, 0], np.outer(t**2, [-0.75, 0.5]), rtol=1e-10)
    np.testing.assert_allclose(f.measured_points.velocity[:, 0], np.outer(t, [-1.5, 1.0]), rtol=1e-10)
    np.testing.assert_allclose(f.history.rotation, 0, atol=16000 * np.finfo(float).eps)  # no moment about the centroid
    np.testing.assert_allclose(f.history.energy.work, DENSITY * 2 * (1.5**2 + 1) / 2 * t**2, rtol=1e-10)
    kinetic = f.history.energy.kinetic
    np.testing.assert_allclose(f.history.energy.work, kinetic, rtol=1e-10)


@pytest.mark.parametrize("body", BODIES)
def test_the_velocity_is_exact_however_fine_the_record(body, tmp_path):
    """Steps of 0.06 s, 80 samples each: velocities are those of the ground at the ends of the steps, displacements their
    trapezoidal sum, the work is the kinetic energy. Round-off alone, where E/rho is 4e7 that of the motion."""
    t, _, v, _ = sine(tmp_path)
    f = run(tmp_path, 50, 0.06, BODIES[body] + "\n&acceleration file='quake.txt' /")
    ground = v[80::80]
    np.testing.assert_allclose(f.history.time, t[80::80], rtol=1e-13)
    np.testing.assert_allclose(f.measured_points.velocity[:, 0], -ground, atol=1e-9)
    before = np.vstack([[0, 0], ground[:-1]])
    np.testing.assert_allclose(f.measured_points.displacement[:, 0], -0.03 * np.cumsum(ground + before, 0), atol=1e-9)
    np.testing.assert_allclose(f.history.energy.work, f.history.energy.kinetic, atol=1e-8)
    np.testing.assert_allclose(f.history.energy.dissipated, 0, atol=1e-8)


NGA = "ACCELERATION TIME SERIES IN UNITS OF G"


def peer_file(path, values, head, unit=NGA):
    """A component of a record of PEER, five values a line, CRLF and capitals as they come."""
    lines = [" ".join(f"{value:15.7E}" for value in values[i:i + 5]) for i in range(0, len(values), 5)]
    path.write_text("\r\n".join(["PEER NGA STRONG MOTION DATABASE RECORD", "Somewhere #2 & more, 1/17/1994, 'Station', 180",
                                 unit, head, *lines]) + "\r\n")


@pytest.mark.parametrize("unit, head", [
    (NGA, "NPTS=    301, DT=   .0100 SEC,"), (NGA, "   301    0.0100    NPTS, DT"),
    ("ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.1 Hz LP=30.0 Hz", "NPTS=   301, DT= .01000 SEC"),
    ("ACCELERATION TIME HISTORY IN UNITS OF G, BASELINE CORRECTED", "301 .01000SEC NPTS, DT"),
], ids=["NGA", "NGA with the numbers first", "before NGA", "before NGA with a comma"])
def test_components_of_peer_move_the_ground_as_their_lines_would(unit, head, tmp_path):
    """The first acceleration is that of time 0; the vertical component is shorter, and zero from its end on."""
    t = np.arange(301) * 0.01
    ax, ay = np.round(0.3 * np.sin(5 * t), 8), np.round(0.2 * np.cos(7 * t), 8)
    ay[200:] = 0
    peer_file(tmp_path / "Q_180.AT2", ax, head, unit)
    peer_file(tmp_path / "q_up.at2", ay[:200], head.replace("301", "200"), unit)
    (tmp_path / "quake.txt").write_text("".join(f"{i * 0.01} {x} {y}\n" for i, (x, y) in enumerate(zip(ax.tolist(), ay.tolist()))))
    runs = [run(tmp_path, 60, 0.05, f"&acceleration {file}, scale=9.81 /").measured_points.velocity
            for file in ("file='Q_180.AT2', vertical='q_up.at2'", "file='quake.txt'", "file='Q_180.AT2'")]
    np.testing.assert_array_equal(runs[0], runs[1])
    np.testing.assert_array_equal(runs[2][..., 0], runs[1][..., 0])
    assert np.abs(runs[1]).max() > 0.1 and np.abs(runs[2][..., 1]).max() < 1e-9


@pytest.mark.parametrize("steps", STEPS)
def test_the_displacement_converges_with_the_square_of_the_step(steps, tmp_path):
    _, _, _, d = sine(tmp_path)
    error, work = [], []
    for n in (75, 150, 300):
        f = run(tmp_path, n, 3 / n, STEPS[steps] + "\n&acceleration file='quake.txt' /")
        ends = np.rint(f.history.time * 4000 / 3).astype(int)
        whole = np.abs(f.history.time * 4000 / 3 - ends) < 1e-6  # a sample: steps of 0.02 s have one in three
        error.append(np.abs(f.measured_points.displacement[:, 0] + d[ends])[whole].max())
        work.append(np.abs(f.history.energy.work - f.history.energy.kinetic).max())
    orders = np.log2(np.array(error[:-1]) / error[1:])
    assert error[-1] < 3e-3 and (1.8 < orders).all() and (orders < 2.2).all()
    if steps == "shi":
        # (dt^2/12)(a(t) - a(0)): the error of the trapezoidal sum of exact velocities
        assert error[-1] == pytest.approx(0.01**2 / 12 * 4, rel=1e-2)
    else:
        assert work[-1] < 0.27 * work[-2]


@pytest.mark.parametrize("factor", [1, 7, 50])
def test_what_is_faster_than_the_step_does_not_alias(factor, tmp_path):
    """One, seven and fifty periods a step: the ground is at rest at the end of each. Its acceleration at that time, or in the
    middle of the step, is 1 in every step."""
    n = 100 * factor
    t = np.linspace(0, 1, 40 * n + 1)
    a = np.cos(2 * np.pi * n * t)
    (tmp_path / "fast.txt").write_text("".join(f"{x} {y} 0\n" for x, y in zip(t.tolist(), a.tolist())))
    f = run(tmp_path, 100, 0.01, "&acceleration file='fast.txt' /")
    assert np.abs(f.measured_points.velocity).max() < 1e-12  # with that acceleration: 1


@pytest.mark.parametrize("body", ["dda", "nmm"])
def test_an_accelerating_ground_is_weight_on_a_fixed_body(body, tmp_path):
    """Upwards by g: the same stress and deflection as a unit weight of rho g, and the work of the one is the gravity of the
    other. The sums are done in another order: round-off."""
    f = run(tmp_path, 40, 0.001, BODIES[body], DENSITY * 9.81, CLAMPED)
    stress, moved = f.bodies.stress, f.measured_points.displacement
    gravity = f.history.energy.gravity
    f = run(tmp_path, 40, 0.001, BODIES[body] + "\n&acceleration table=0 0 9.81  1 0 9.81 /", 0, CLAMPED)
    np.testing.assert_allclose(f.bodies.stress, stress, atol=1e-9 * np.abs(stress).max())
    np.testing.assert_allclose(f.measured_points.displacement, moved, atol=1e-9 * np.abs(moved).max())
    at_start = DENSITY * 9.81 * 2 * 0.5
    np.testing.assert_allclose(f.history.energy.work, at_start - gravity, atol=1e-12 * at_start)


def test_the_ground_is_at_rest_before_and_after_its_record(tmp_path):
    f = run(tmp_path, 40, 0.1, "&acceleration table=1 2 0  2 2 0 /")
    t, v = f.history.time, f.measured_points.velocity[:, 0]
    np.testing.assert_allclose(v[:, 0], -2 * np.clip(t - 1, 0, 1), atol=1e-12)


def test_the_consistent_start_begins_with_the_acceleration_of_time_zero(tmp_path):
    """Without a dissipative step the trapezoidal rule needs it: else half a step of the first acceleration is lost."""
    f = run(tmp_path, 20, 0.05, STEPS["trapezoidal"].replace(" /", ", start='acceleration' /")
            + "\n&acceleration table=0 3 0  2 3 0 /")
    t = f.history.time
    np.testing.assert_allclose(f.measured_points.displacement[:, 0, 0], -1.5 * t**2, rtol=1e-10)


def test_what_the_deck_does_not_ask_for_is_not_there(tmp_path):
    run(tmp_path, 1, 0.1, "&acceleration table=0 1 2  1 2 1, scale=0 /")
    done = scree.call("check", tmp_path / "box.ana")
    assert done.returncode == 0 and "base acceleration" not in done.stdout
    done = scree.call("check", tmp_path / "box.ana", "--set", "acceleration.scale=2")
    assert "effect: base acceleration - &acceleration: 2 times from 0 to 1, none from there" in done.stdout
    done = scree.call("explain", tmp_path / "box.ana", "--set", "acceleration.scale=2")
    assert "acceleration of the ground at time 1 x y: 4 2 [length/time^2]" in done.stdout
