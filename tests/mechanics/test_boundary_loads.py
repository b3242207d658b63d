"""Pressure and traction on lines: what they balance, what they move, and where they act."""
import math

import numpy as np
import pytest

import scree
from scree import block_files, call

G = 10.0


def lines_of(corners):
    """The edges of a polygon as numbers of boundary.lines."""
    return " ".join(str(float(x)) for a, b in zip(corners, np.roll(corners, -1, 0)) for x in (*a, *b))


def run(folder, blocks, material, groups, carried=1, steps=50, dt=0.01, fixed=(), measured=()):
    """Runs blocks of one material; material: density, unit weight, E, nu, stress, gradient, velocity."""
    (folder / "g.blk").write_text(block_files.block_file("loaded", [(1, corners) for corners in blocks], fixed, measured=measured))
    (folder / "g.ana").write_text(f"{carried}\n{steps}\n1 1\n0.05\n{dt}\n{material}\n30 0 0\n&deck geometry='g.blk', dialect='short' /\n{groups}\n")
    return scree.run(folder / "g.ana")


METHODS = ("model='dda'", "model='nmm'", "model='nmm' / &cover edge=0.3", "strain='green'", "strain='small'")
SIZES = (1e-3, 1.0, 1e3)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", SIZES)
def test_pressure_and_initial_stress_balance(size, method, tmp_path):
    """A skew block under a stress of -7 in all directions and 7 on all sides stays as it is, to round-off."""
    corners = size * np.array([(0, 0), (1, 0.1), (1.2, 0.9), (0.1, 0.7)])
    method = method.replace("0.3", str(0.3 * size))
    r = run(tmp_path, [corners], f"2 0 1e4 0.25 -7 -7 0 0 0 0 0 0 0",
            f"&method {method} / &boundary lines={lines_of(corners)}, pressure={'7 ' * 8} /", dt=0.01 * size)
    assert np.abs(r.displacement()).max() < 1e-12 * size
    assert r.stress() == pytest.approx(np.tile([-7.0, -7.0, 0.0], (r.n_elements, 1)), abs=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("carried", (0, 1))
def test_a_column_with_its_stress_stands_between_pressures(carried, method, tmp_path):
    """K0 = 0.5: weight 20, stress -20 depth and -10 depth; sides under 10 depth, the foot under its weight, nothing moves."""
    height = 3.0
    corners = block_files.box(0, 2, 0, height)
    lines = "0 0 2 0  2 0 2 3  0 3 0 0"
    r = run(tmp_path, [corners], f"2 20 1e5 0.25 {-10 * height} {-20 * height} 0 10 20 0 0 0 0",
            f"&method {method} / &boundary lines={lines}, pressure=60 60  30 0  0 30 /", carried=carried)
    # a block of the DDA has the mean of the stress, which asks for no other force; so has an element under a mesh
    assert np.abs(r.displacement()).max() < (1e-12 if "edge" not in method else 1e-4)


def test_a_turned_block_swims(tmp_path):
    """Of the density of the water around it: pressure 10 depth on all sides carries its weight, whatever its shape."""
    corners = block_files.turned(block_files.box(-1, 1, -0.5, 0.7), 0.6)
    depth = 5 - corners[:, 1]
    pressure = " ".join(f"{10 * a} {10 * b}" for a, b in zip(depth.tolist(), np.roll(depth, -1).tolist()))
    r = run(tmp_path, [corners], "1 10 1e9 0.25 0 0 0 0 0 0 0 0 0", f"&boundary lines={lines_of(corners)}, pressure={pressure} /")
    start, end = r.bodies.centroid[0, 0], r.bodies.centroid[-1, 0]
    fall = 0.5 * G * r.times[-1] ** 2
    assert end == pytest.approx(start, abs=1e-5 * fall) and abs(r.bodies.rotation[-1, 0]) < 1e-5


@pytest.mark.parametrize("parts", (1, 3))
def test_traction_makes_uniform_stress(parts, tmp_path):
    """A bar pulled at both ends by 50, statically, whatever its mesh; also where the lines are cut in parts."""
    corners = block_files.box(0, 4, 0, 1)
    at = np.linspace(0, 1, parts + 1)
    rows = [((0, 0, 4, 0), (-3, 0)), ((0, 1, 4, 1), (3, 0))]
    for a, b in zip(at[:-1], at[1:]):
        rows += [((0, a, 0, b), (-50, -3)), ((4, a, 4, b), (50, 3))]
    lines = " ".join(f"{x:.17g}" for line, _ in rows for x in line)
    traction = " ".join(f"{tx} {ty} {tx} {ty}" for _, (tx, ty) in rows)
    r = run(tmp_path, [corners], "1 0 1e9 0.25 0 0 0 0 0 0 0 0 0", "&method model='nmm', strain='small' / &cover edge=0.7 /"
            f"&boundary lines={lines}, traction={traction} /", carried=0, dt=0.1, steps=5)
    assert r.stress() == pytest.approx(np.tile([50.0, 0.0, 3.0], (r.n_elements, 1)), abs=1e-5)  # strains are 5e-8


def spinning(folder, dt, groups=""):
    """A square of mass 2 that spins at 3 rad/s, pushed by 5 on the edge that is its left at the start."""
    corners = block_files.box(-0.5, 0.5, -0.5, 0.5)
    return run(folder, [corners], "2 0 1e7 0.25 0 0 0 0 0 0 0 0 3", "&integrator scheme='energy_momentum', beta=0.5 /"
               f"&boundary lines=-0.5 0.5 -0.5 -0.5, pressure=5 5 /{groups}", steps=round(1 / dt), dt=dt)


def test_pressure_follows_what_turns(tmp_path):
    """Its thrust turns with it: v = 5/(2 * 3) (sin 3t, 1 - cos 3t), of second order in the step, and the work is its energy."""
    exact = 5 / 6 * np.array([math.sin(3.0), 1 - math.cos(3.0)])
    errors = []
    for dt in (0.02, 0.01, 0.005):
        r = spinning(tmp_path, dt)
        errors.append(np.linalg.norm(r.bodies.velocity[-1, 0] - exact))
        assert r.history.energy.work[-1] == pytest.approx(0.5 * 2 * (exact @ exact), rel=0.01)
    assert errors[0] < 2e-3 and errors[0] / errors[1] > 3.5 and errors[1] / errors[2] > 3.5


def test_a_ramp_hands_over_half_of_the_impulse(tmp_path):
    """Traction 5 on a side of 1, mass 2, ramp 0.4: v(1) = 5/2 (1 - 0.2), and the books balance."""
    corners = block_files.box(0, 1, 0, 1)
    r = run(tmp_path, [corners], "2 0 1e7 0.25 0 0 0 0 0 0 0 0 0", "&boundary lines=0 0 0 1, traction=5 0 5 0, ramp=0.4 /"
            "&integrator scheme='energy_momentum', beta=0.5 /", steps=100)
    assert r.bodies.velocity[-1, 0] == pytest.approx([2.0, 0.0], rel=1e-4, abs=1e-6)
    assert np.abs(r.history.energy.dissipated).max() < 1e-4 * r.history.energy.work[-1]


def test_both_sides_of_a_joint_are_pressed_apart(tmp_path):
    """Half of the joint under 8, linear to 0: two boxes part with 8/4 each along x, and turn."""
    a, b = block_files.box(0, 1, 0, 1), block_files.box(1, 2, 0, 1)
    r = run(tmp_path, [a, b], "2 0 1e7 0.25 0 0 0 0 0 0 0 0 0", "&boundary lines=1 0 1 0.5, pressure=8 0 / &contact method='none' /",
            steps=10, dt=1e-3)
    momentum = 2 * r.bodies.velocity[-1]
    assert momentum[:, 0] / r.times[-1] == pytest.approx([-2.0, 2.0], rel=1e-3)
    assert momentum[:, 1] == pytest.approx([0, 0], abs=1e-6)
    spin = r.bodies.rotation[-1] / (0.5 * r.times[-1] ** 2)  # torque 2 (1/2 - 1/6) over mass/6
    assert spin == pytest.approx([-2 * (1 / 3) * 3, 2 * (1 / 3) * 3], rel=1e-2)


BAD = {"&boundary lines=0 0 1 /": "four numbers", "&boundary lines=0 0 1 0, pressure=1 /": "2 numbers, p1 p2",
       "&boundary lines=0 0 1 0, traction=1 2 /": "4 numbers", "&boundary lines=0 0 0 0, pressure=1 1 /": "two ends of line 1",
       "&boundary lines=0 0 1 0 0 0.5 1 0.5, pressure=1 1 2 2 /": "found none on line 2", "&boundary pressure=1 1 /": "boundary.lines"}


@pytest.mark.parametrize("groups", BAD)
def test_lines_that_load_nothing_are_refused(groups, tmp_path):
    (tmp_path / "g.blk").write_text(block_files.block_file("loaded", [(1, block_files.box(0, 1, 0, 1))]))
    (tmp_path / "g.ana").write_text(f"1\n5\n1 1\n0.05\n0.1\n1 0 1 0 0 0 0 0 0 0 0 0 0\n30 0 0\n&deck geometry='g.blk' /\n{groups}\n")
    done = call("check", tmp_path / "g.ana")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "g.ana:9: expected" in done.stderr
    assert BAD[groups] in done.stderr, done.stderr
