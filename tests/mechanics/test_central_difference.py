"""Explicit central differences through the program: order, energy, the step that they take, contact."""
import math
import os
import pathlib

import numpy as np
import pytest
import scree

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
E, RHO = 1e10, 2500.0
CENTRAL = "integrator.scheme=central_difference"
W = math.sqrt(12 * E / RHO)  # 1/s: of a square of 1 m that breathes, as nu is 0
SAFE = 0.8 * 2 / W


def blocks(*outlines, fixed=(), measured=()):
    """Text of a block file."""
    spans = [f"1 {8 * i + 1} {8 * i + 4}" for i in range(len(outlines))]
    rows = [line for outline in outlines for line in [*(f"1 {x} {y}" for x, y in [*outline, outline[0]]), *3 * ["0 0 0"]]]
    points = [f"{x} {y} {block}" for x, y, block in [*fixed, *measured]]
    return "\n".join([f"{len(outlines)} 0 {len(rows)}", f"{len(fixed)} 0 {len(measured)}", *spans, *rows, *points, ""])


def square(x, y, edge=1.0):
    return (x, y), (x + edge, y), (x + edge, y + edge), (x, y + edge)


def breathing(folder, steps, dt, *settings, edge=1.0, strain=1e-9, groups="&method strain='small' /"):
    """A free square that a stress sets ringing: s11 = E strain cos(w t)."""
    folder.mkdir(exist_ok=True)
    (folder / "b.blk").write_text(blocks(square(0, 0, edge), measured=[(edge / 2, edge / 2, 1)]))
    (folder / "b.ana").write_text(f"1 {steps} 1 1 0.05 {dt} {RHO} 0 {E} 0 {E * strain} 0 0 0 0 0 0 0 0 0 0 0\n"
                                  f"&deck geometry='b.blk' /\n{groups}\n")
    f = scree.run(folder / "b.ana", settings=[CENTRAL, *settings])
    return f.history.time, f.measured_points.stress[:, 0, 0] / (E * strain), f


def total(f):
    """Kinetic and elastic energy, with what the integrator holds, after each step."""
    return f.history.energy.kinetic + f.history.energy.strain + f.history.energy.held


@pytest.mark.parametrize("strain", ["small", "green"])
@pytest.mark.parametrize("body", ["dda", "nmm"])
def test_they_are_of_second_order(body, strain, tmp_path):
    errors = []
    for n in (20, 40, 80):
        t, s, _ = breathing(tmp_path, 2 * n, 2 * math.pi / W / n, groups=f"&method strain='{strain}', model='{body}' /")
        errors.append(np.abs(s - np.cos(W * t)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2, abs=0.1)


def test_a_step_is_that_of_the_difference_equation(tmp_path):
    """x(n+1) - 2 x(n) + x(n-1) = -(w dt)^2 x(n), and half of that in the first step."""
    dt = 0.7 * 2 / W
    _, s, _ = breathing(tmp_path, 50, dt)
    x = [1.0, 1 - (W * dt) ** 2 / 2]
    for _ in range(49):
        x.append((2 - (W * dt) ** 2) * x[-1] - x[-2])
    np.testing.assert_allclose(s, x[1:], atol=1e-6)


@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
def test_energy_is_kept_with_what_the_integrator_holds(edge, tmp_path):
    """To the strain, of which the equations know nothing; without it, it goes up and down by (w dt)^2."""
    _, _, f = breathing(tmp_path, 1000, 0.7 * 2 / W * edge, edge=edge)
    e = total(f)
    assert np.ptp(e) < 1e-7 * e[0]
    assert np.ptp(e - f.history.energy.held) > 0.1 * e[0]


def test_steps_that_change_keep_the_order(tmp_path):
    """Frames that steps must meet cut some of them short, each to another size."""
    errors = []
    for n in (40, 80):
        t, s, _ = breathing(tmp_path, 4 * n, 2 * math.pi / W / n, f"output.interval={0.37123 * 2 * math.pi / W}")
        assert np.ptp(np.diff(t)) > 0.1 * t[0]
        errors.append(np.abs(s - np.cos(W * t)).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.3)


@pytest.mark.parametrize("strain", ["small", "green"])
@pytest.mark.parametrize("body", ["dda", "nmm"])
def test_a_step_above_the_critical_one_is_split(body, strain, tmp_path):
    """The program finds it, says so, and takes the largest part of the step below 0.8 of it; energy is kept to the strain."""
    _, _, f = breathing(tmp_path, 3, 0.1, groups=f"&method strain='{strain}', model='{body}' /", strain=1e-5)
    sizes = f.history.step_size
    np.testing.assert_allclose(sizes[:-400], 0.1 / math.ceil(0.1 / SAFE), rtol=1e-9)
    assert sizes.max() < 1.001 * SAFE and sizes.min() > 0.99 * SAFE
    assert f.history.time[-1] == pytest.approx(0.3, rel=1e-12) and (f.history.solves == 1).all()
    e = total(f)
    assert np.abs(e / e[0] - 1).max() < 1e-3
    done = scree.call("run", tmp_path / "b.ana", "--set", CENTRAL, "-o", tmp_path / "x.h5")
    assert f"explicit steps: at most {SAFE:.4g}"[:28] in done.stdout + done.stderr


def test_a_mesh_is_stable_for_long(tmp_path):
    """A cantilever of 80 triangles that a sudden load swings, in steps of what its elements bear."""
    (tmp_path / "c.blk").write_text(blocks(((0, 0), (4, 0), (4, 1), (0, 1)), fixed=[(0, y, 1) for y in (0.0, 0.5, 1.0)],
                                           measured=[(4, 0.5, 1)]))
    (tmp_path / "c.ana").write_text("1 1 1 1 0.05 0.2 2500 25000 1e8 0.2 0 0 0 0 0 0 0 0 0 0 0 0\n&deck geometry='c.blk' /\n"
                                    "&method model='nmm', strain='green' /\n&cover edge=0.5, origin=0 0.25 /\n")
    f = scree.run(tmp_path / "c.ana", settings=[CENTRAL])
    still = scree.run(tmp_path / "c.ana", output=tmp_path / "i.h5", settings=["step.size=0.001", "step.end_time=0.2", "integrator.beta=0.5",
                                                                                "integrator.scheme=energy_momentum"])
    e = f.history.energy
    assert len(f.history.time) > 500
    assert np.abs(e.dissipated[1:] - e.dissipated[1]).max() < 1e-3 * e.kinetic.max()
    tip, expected = (r.measured_points.position[:, 0, 1] for r in (f, still))
    np.testing.assert_allclose(np.interp(still.history.time, f.history.time, tip), expected, atol=0.02 * np.ptp(expected))


def test_the_turning_triangle_keeps_its_area_and_its_spin(tmp_path):
    """With Green strain, held at its corner, in steps so small that what is left is the strain of its spin."""
    deck = SOURCE / "input" / "paper" / "rotation" / "t4-dda.ana"
    f = scree.run(deck, output=tmp_path / "r.h5", settings=[CENTRAL, "integrator.start=zero", "step.end_time=0.25"])
    assert f.history.step_size.max() < 2e-5
    assert abs(f.history.rotation[-1, 0] / (math.pi / 2) - 1) < 1e-6
    assert np.ptp(f.history.area) < 1e-6 * f.history.area[0]
    assert np.ptp(f.history.momentum[:, 2]) < 1e-6 * f.history.momentum[0, 2]


@pytest.mark.parametrize("strain", ["small", "green"])
def test_contacts_set_no_step_and_take_energy(strain, tmp_path):
    """A square falls on its corner and comes to rest on its face where Green strain in steps of its own brings it, with springs that
    would allow explicit steps many times smaller. What is left is the ringing of the block itself, which nothing damps."""
    floor, tilted = ((-3, -1), (3, -1), (3, 0), (-3, 0)), ((0, 0.01), (0.8, 0.61), (0.2, 1.41), (-0.6, 0.81))
    (tmp_path / "s.blk").write_text(blocks(floor, tilted, fixed=[(-2.9, -0.9, 1), (2.9, -0.9, 1), (0, -0.1, 1)]))
    (tmp_path / "s.ana").write_text("1 2000 1 1 0.05 0.001 2500 24525 1e9 0.25 0 0 0 0 0 0 0 0 0 20 0 0\n&deck geometry='s.blk' /\n")
    f = scree.run(tmp_path / "s.ana", settings=[CENTRAL, f"method.strain={strain}", "contact.stiffness=1e13"])
    implicit = scree.run(tmp_path / "s.ana", output=tmp_path / "i.h5", settings=["method.strain=green", "contact.stiffness=1e13"])
    assert f.history.step_size.max() > 5e-4  # 2/sqrt(p/m) is 3e-5
    assert f.bodies.centroid[-1, 1, 1] == pytest.approx(implicit.bodies.centroid[-1, 1, 1], abs=1e-3)
    assert f.history.rotation[-1, 1] == pytest.approx(implicit.history.rotation[-1, 1], abs=1e-3)
    e = f.history.energy
    assert e.kinetic[-1] < 1e-4 * e.dissipated[-1]
    assert np.diff(e.dissipated, prepend=0).min() > -1e-2 * e.dissipated[-1]


def test_loads_of_a_step_act_with_their_mean_over_its_kick(tmp_path):
    """A ground that accelerates leaves a free block exactly its velocity half a step ago, however fine the record is."""
    (tmp_path / "g.blk").write_text(blocks(square(0, 0)))
    rng = np.random.default_rng(1)
    times, values = np.linspace(0, 0.02, 401), rng.normal(size=401)
    (tmp_path / "q.txt").write_text("".join(f"{t} {a} 0\n" for t, a in zip(times.tolist(), values.tolist())))
    (tmp_path / "g.ana").write_text(f"1 40 1 1 0.05 0.0001 {RHO} 0 {E} 0 0 0 0 0 0 0 0 0 0 0 0 0\n&deck geometry='g.blk' /\n"
                                    "&acceleration file='q.txt' /\n")
    f = scree.run(tmp_path / "g.ana", settings=[CENTRAL])
    dt, way = f.history.step_size, np.diff(f.bodies.centroid[:, 0, 0]) if len(f.bodies.centroid) == 41 else None
    integral = np.concatenate([[0], np.cumsum((values[1:] + values[:-1]) / 2 * np.diff(times))])
    if way is None:
        pytest.fail("expected a frame for each step")
    middle = f.history.time - dt / 2
    np.testing.assert_allclose(way / dt, -np.interp(middle, times, integral), atol=2e-7 * np.abs(integral).max() + 1e-9)


def test_a_step_below_the_least_is_refused(tmp_path):
    breathing(tmp_path, 1, 1e-4)
    done = scree.call("run", tmp_path / "b.ana", "--set", CENTRAL, "--set", "step.size=1000", "--set", "step.end_time=1000",
                      "-o", tmp_path / "x.h5")
    assert done.returncode == 1
    line = done.stderr.strip().splitlines()[-1]
    assert "an explicit step may have" in line and "below step.least" in line and "block 1" in line


def test_many_blocks_that_may_meet_are_told_of_the_other_schemes(tmp_path):
    """A row of blocks: with eleven of them the check names small steps, with ten, without contact or in a mesh it does not."""
    said = "expected integrator.scheme='small_steps' or no integrator.scheme for 11 blocks that may meet, found 'central_difference'"
    (tmp_path / "b.ana").write_text(f"1 10 1 1 0.05 1e-4\n{RHO} 0 {E} 0\n0 0 0 0 0 0 0 0 0\n30 0 0\n&deck geometry='b.blk' /\n")
    for count, settings, told in ((11, [], True), (10, [], False), (11, ["contact.method=none"], False),
                                  (11, ["method.model=nmm", "cover.edge=1"], False)):
        (tmp_path / "b.blk").write_text(blocks(*(square(1.5 * i, 0) for i in range(count))))
        done = scree.call("check", tmp_path / "b.ana", *(word for one in [CENTRAL, *settings] for word in ("--set", one)))
        assert done.returncode == 0 and (said in done.stdout) is told, (count, settings, done.stderr)
