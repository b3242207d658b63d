"""Impacts whatever the size of the step: what bodies keep of their energy, and what an impact leaves alone."""
import math

import numpy as np
import pytest
import scree
from scree.bench.scenes import column
from scree.block_files import block_file, box, running_bond

G = 9.81
MODES = {"dda": "", "green": "&method strain='green' /", "nmm": "&method model='nmm' /\n&cover edge=0.2 /",
         "mesh": "&method model='nmm' /\n&cover edge=0.5 /", "green mesh": "&method model='nmm', strain='green' /\n&cover edge=0.5 /",
         "dissipating": "&integrator beta=1, gamma=0.5625 /", "trapezoidal": "&integrator beta=0.5 /"}
STEPS = np.geomspace(4e-4, 1e-2, 5)


def run(folder, blocks, groups, dt, time, fixed, weight=2500 * G, velocity=(0, 0, 0), young=1e10, phi=0.0):
    """Runs block 1, which has fixed points, and others of material 2."""
    return run_saying(folder, blocks, groups, dt, time, fixed, weight, velocity, young, phi)[0]


def run_saying(folder, blocks, groups, dt, time, fixed, weight=2500 * G, velocity=(0, 0, 0), young=1e10, phi=0.0):
    """The same, with what it warns of."""
    (folder / "a.blk").write_text(block_file("impacts", [(min(k, 1) + 1, x) for k, x in enumerate(blocks)], fixed))
    (folder / "a.ana").write_text("\n".join([
        f"1 {math.ceil(time / dt)} 2 1 0.05 {dt}", f"2500 0 {young} 0.25 {'0 ' * 9}",
        f"2500 {weight} {young} 0.25 {'0 ' * 6} {' '.join(map(str, velocity))}", f"{phi} 0 0",
        "&deck geometry='a.blk', dialect='short' /", "&output every=1 /", groups, ""]))
    done = scree.call("run", folder / "a.ana", "-o", folder / "a.h5", "--quiet")
    assert done.returncode == 0, done.stderr
    return scree.read(folder / "a.h5"), done.stderr


def turned(corners, angle, height):
    c, s = math.cos(angle), math.sin(angle)
    corners = (corners - corners.mean(0)) @ np.array([[c, s], [-s, c]])
    return corners + [0, height - corners[:, 1].min()]


def total(f):
    energy = f.history.energy
    return sum(getattr(energy, name) for name in ("kinetic", "strain", "contact", "gravity", "held") if hasattr(energy, name))


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("mode", [m for m in MODES if "mesh" not in m])
def test_a_square_that_falls_flat_keeps_the_square_of_restitution_at_any_step(mode, e, tmp_path):
    """By 1 m: e^2 of m g h is left, and springs, strain and the phase of the step take no part. What is measured is the height that its
    velocity after the first bounce will take it to; a step may miss the time of the impact by dt, dt g/v = 2 % of h at 10 ms."""
    for dt in STEPS:
        f = run(tmp_path, [box(-2, 2, -1, 0), turned(box(0, 0.5, 0, 0.5), 0, 1)], f"&contact restitution={e} /\n{MODES[mode]}", dt, 0.55,
                [(-1.9, -0.9, 1), (1.9, -0.9, 1)])
        height = f.bodies.centroid[-1, 1, 1] - 0.25 + f.bodies.velocity[-1, 1, 1]**2 / (2 * G)
        assert height == pytest.approx(e**2, abs=2e-3 + 0.1 * dt), (mode, dt)
        assert f.history.rejected.sum() == 0


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_the_energy_of_a_corner_impact_does_not_depend_on_the_step(e, tmp_path):
    """Square of side a turned by 30 degrees, no friction: with r the arm of the corner across, I = m a^2/6, an impulse gives back e^2 of what
    it takes, m v^2/2 (1 - e^2)/(1 + m r^2/I) lost. No step makes energy. The impact acts where the step ends, and has turned the square by
    up to its rate dt by then: the arm is that much another."""
    a, angle = 0.5, math.pi / 6
    r, speed = a / 2**0.5 * math.cos(math.pi / 4 + angle), math.sqrt(2 * G)
    lost = (1 - e**2) / (1 + 6 * r**2 / a**2)
    rate = (1 + e) * speed * r / (r**2 + a**2 / 6)
    by_turn = lost * 12 * r / a**2 / (1 + 6 * r**2 / a**2) * a / 2**0.5 * math.sin(math.pi / 4 + angle)
    for dt in STEPS:
        f = run(tmp_path, [box(-2, 2, -1, 0), turned(box(0, a, 0, a), angle, 1)],
                f"&contact restitution={e} /\n&method strain='green' /", dt, 0.47, [(-1.9, -0.9, 1), (1.9, -0.9, 1)])
        energy = total(f)
        scale = 2500 * a**2 * G
        assert np.diff(energy).max() < 1e-9 * scale
        assert (energy[0] - energy[-1]) / scale == pytest.approx(lost, abs=0.01 + 1.3 * by_turn * rate * dt), dt


@pytest.mark.parametrize("e", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("dt, steps", [(1e-2, 300), (1e-3, 1500)])
@pytest.mark.parametrize("mode", ["dda", "green", "mesh", "green mesh"])
def test_a_resting_column_carries_its_load(mode, dt, steps, e, tmp_path):
    """Three soft blocks, loaded at once: the stress of each is the weight above its middle, when damping has taken the swing."""
    blocks = [box(-1, 2, -1, 0), *[box(0, 1, k, k + 1) for k in range(3)]]
    f = run(tmp_path, blocks, f"&contact restitution={e} /\n{MODES[mode]}\n&damping mass=20 /", dt, steps * dt,
            [(-0.9, -0.9, 1), (1.9, -0.9, 1)], young=1e7, phi=30)
    load = 2500 * G * np.array([2.5, 1.5, 0.5])
    np.testing.assert_allclose(f.bodies.stress[-1, 1:, 1], -load, rtol=0.01)


@pytest.mark.parametrize("dt", [5e-3, 1e-3])
@pytest.mark.parametrize("mode", ["dda", "green"])
def test_a_wall_that_rings_under_its_load_has_no_impacts(mode, dt, tmp_path):
    """Loaded at once, its joints open and close slower than their springs ring under what they bear: with any restitution it is the wall that
    springs alone hold, to the bit, in as many solutions. Without this, 1 takes 4 times as many at 5 ms."""
    blocks = running_bond(8)
    low, high = np.min([b.min(0) for b in blocks], 0), np.max(blocks[0], 0)
    fixed = [(low[0] + 0.1, low[1] + 0.1, 1), (high[0] - 0.1, low[1] + 0.1, 1)]
    seen = []
    for group in ("", "&contact restitution=0 /", "&contact restitution=1 /"):
        f = run(tmp_path, blocks, f"{group}\n{MODES[mode]}", dt, 40 * dt, fixed, phi=31)
        seen.append((f.bodies.velocity[-1], f.history.solves.sum(), f.history.contacts[:, 0]))
    springs, *others = seen
    assert np.any(np.diff(springs[2]) < 0)  # joints close in it
    for other in others:
        np.testing.assert_array_equal(other[0], springs[0])
        assert other[1] == springs[1]


@pytest.mark.parametrize("gap", [2e-4, 5e-3])
def test_a_pebble_does_not_still_the_swing_of_what_it_falls_on(gap, tmp_path):
    """A column of three soft blocks swings under its load; a pebble of 1/7500 of its mass lands on it, plastic, with less than a joule.
    What a step takes of the swing stays below a twentieth of it; that of the whole column would be a third."""
    blocks = [box(-1, 2, -1, 0), *[box(0, 1, k, k + 1) for k in range(3)], box(0.5, 0.52, 3 + gap, 3.02 + gap)]
    f = run(tmp_path, blocks, f"&contact restitution=0 /\n{MODES['trapezoidal']}", 2e-3, 0.1, [(-0.9, -0.9, 1), (1.9, -0.9, 1)], young=1e7, phi=30)
    assert f.history.contacts[:, 1:].sum(1).max() > 6  # it has landed
    assert -np.diff(total(f)).min() < 0.05 * f.history.energy.strain.max()


def test_impacts_elsewhere_leave_a_vibrating_block_as_it_is(tmp_path):
    """A block 20 m off that swings by its initial stress: to the bit, whether two others meet or not."""
    (tmp_path / "a.ana").write_text("\n".join([
        "1 150 3 1 0.05 0.0005", f"2.5 0 1e5 0.25 {'0 ' * 9}", f"2.5 25 1e5 0.25 {'0 ' * 9}", f"2.5 0 1e5 0.25 100 {'0 ' * 8}", "30 0 0",
        "&deck dialect='short' /", "&integrator beta=0.5 /", "&method strain='green' /", "&output every=1 /", "&contact restitution=0.5 /", ""]))
    stress = []
    for height in (0.01, 50):
        (tmp_path / "a.blk").write_text(block_file("far", [(1, box(-1, 2, -1, 0)), (2, box(0, 1, height, 1 + height)),
                                                           (3, box(20, 21, 0, 1))], [(-0.9, -0.9, 1), (1.9, -0.9, 1)]))
        done = scree.call("run", tmp_path / "a.blk", tmp_path / "a.ana", "-o", tmp_path / "a.h5", "--quiet")
        assert done.returncode == 0, done.stderr
        f = scree.read(tmp_path / "a.h5")
        stress.append(f.bodies.stress[:, 2])
    assert f.history.contacts[:, 1:].sum() == 0
    np.testing.assert_allclose(stress[0], stress[1], rtol=0, atol=1e-10)
    assert np.abs(stress[0][-50:]).max() > 50


def test_impacts_are_left_to_springs_unless_restitution_is_asked_for(tmp_path):
    """A square that falls by 0.1 m: without the setting it bounces by what its phase in the step has it; with 0 it stays."""
    drop = [box(-2, 2, -1, 0), turned(box(0, 0.5, 0, 0.5), 0, 0.1)]
    fixed = [(-1.9, -0.9, 1), (1.9, -0.9, 1)]
    plastic = run(tmp_path, drop, "&contact restitution=0 /", 1e-3, 0.3, fixed).bodies.velocity[:, 1, :2]
    springs = run(tmp_path, drop, "", 1e-3, 0.3, fixed).bodies.velocity[:, 1, :2]
    assert np.abs(plastic[-1]).max() < 1e-3 < springs[:, 1].max()


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("mode", ["dda", "green"])
def test_a_wall_that_a_block_falls_on_takes_the_impact_whatever_its_joints(mode, size, tmp_path):
    """What is asked of a wall struck from above is hard friction, solved where the iteration runs in circles. With joints flush and not,
    and in every size, no impact is left to springs (a warning says so). After a plastic one the wall swings by what it meets in again:
    1e-9 to 6e-3 of the energy for falls of 0.47 to 0.53 m."""
    for scale in (1.0, 1.004):
        wall = [scale * np.array(block) for block in running_bond(3)[1:]]
        top, middle = max(block[:, 1].max() for block in wall), np.mean([block[:, 0].mean() for block in wall])
        blocks = [box(-6, 10, -1, 0), *wall, box(middle - 0.4, middle + 0.5, top + 0.5, top + 1.4)]
        f, said = run_saying(tmp_path, [size * np.array(block) for block in blocks], f"&contact restitution=0 /\n{MODES[mode]}",
                             2.5e-3 * size**0.5, 0.4 * size**0.5, [(-5.9 * size, -0.9 * size, 1), (9.9 * size, -0.9 * size, 1)],
                             young=1e10 * size, phi=30)
        kinetic = f.history.energy.kinetic
        assert "was not applied to an impact" not in said
        assert kinetic[-20:].max() < 1e-2 * kinetic.max()


@pytest.mark.parametrize("courses, phi", [(5, 40), (5, 45), (6, 40)])
def test_a_rough_wall_that_is_struck_does_not_jam(courses, phi, tmp_path):
    """Its impulses are there to be found, if by the path from apart alone: the first was left to springs, as if its blocks jammed."""
    wall = running_bond(courses)[1:]
    top, middle = max(block[:, 1].max() for block in wall), np.mean([block[:, 0].mean() for block in wall])
    blocks = [box(-6, 20, -1, 0), *wall, box(middle - 0.4, middle + 0.5, top + 0.02, top + 0.92)]
    _, said = run_saying(tmp_path, blocks, "&contact restitution=0 /", 2.5e-3, 0.1, [(-5.9, -0.9, 1), (19.9, -0.9, 1)], phi=phi)
    assert "was not applied to an impact" not in said


def square(low, width=0.5, skew=0.0):
    """Box at x = 0, its bottom from `low` at the left to `low + skew` at the right."""
    return np.array([(0, low), (width, low + skew), (width, low + 1), (0, low + 1)])


@pytest.mark.parametrize("mode, e, size", [*((mode, e, 1.0) for mode in ("dda", "green", "nmm") for e in (0.0, 0.5, 1.0)),
                                           ("dda", 0.5, 1e-3), ("nmm", 0.5, 1e3)])
def test_a_piston_between_rollers_bounces_without_turning(mode, e, size, tmp_path):
    """It falls on one corner, 0.1 below its other, and leaves with e times its speed, where a free one would turn."""
    body = square(0.2, skew=0.1) * size
    sides = " ".join(f"{x}" for x in (*body[0], *body[3], *body[1], *body[2]))
    dt = 1e-3 * math.sqrt(size)
    f = run(tmp_path, [box(-2, 2, -1, 0) * size, body], f"&contact restitution={e} /\n&support x={sides} /\n{MODES[mode].replace('0.2', str(0.2 * size))}",
            dt, 250 * dt, [(-1.9 * size, -0.9 * size, 1), (1.9 * size, -0.9 * size, 1)], young=1e10 * max(size, 1))
    t = math.sqrt(0.4 * size / G)
    after = np.searchsorted(f.times, t + 2.5 * dt)
    left = e * G * t - (G * (f.times[after] - t) if e else 0)
    assert f.bodies.velocity[after, 1, 1] == pytest.approx(left, abs=0.015 * G * t)
    assert np.abs(f.bodies.rotation[:, 1]).max() < 1e-5  # by strain
    assert np.diff(total(f)).max() < 1e-7 * 1250 * G * 0.2 * size**3


@pytest.mark.parametrize("mode", ["dda", "mesh"])
def test_a_floor_on_supports_is_one_on_fixed_points(mode, tmp_path):
    """Rollers at foot and sides leave it no motion, neither do fixed points; a block that falls askew goes the same way after it struck."""
    floor, body = box(-2, 2, -1, 0), turned(box(0, 0.5, 0, 0.5), 0.4, 0.3)
    groups = f"&contact restitution=0.6 /\n{MODES[mode]}"
    ends = []
    for supports, fixed in (("&support normal=-2 -1 2 -1  -2 -1 -2 0 /", []), ("", [(-1.99, -0.99, 1), (1.99, -0.99, 1), (1.99, -0.01, 1)])):
        f = run(tmp_path, [floor, body], f"{groups}\n{supports}", 1e-3, 0.4, fixed, phi=30)
        ends.append([*f.bodies.velocity[-1, 1], f.bodies.rotation[-1, 1]])
    assert ends[0] == pytest.approx(ends[1], abs=0.01) and abs(ends[0][2]) > 0.1


def test_what_strikes_a_floor_on_rollers_takes_it_along(tmp_path):
    """Without rebound and with much friction both go on with the momentum along the rollers, m v/(m + M), M = 16 m."""
    f = run(tmp_path, [box(-2, 2, -1, 0), box(0, 0.5, 0.05, 0.55)], "&contact restitution=0 /\n&support normal=-2 -1 2 -1 /", 1e-3, 0.25, [],
            velocity=(0.1, -1, 0), phi=80)
    assert f.bodies.velocity[-1, :, 0] == pytest.approx(0.1 / 17, rel=1e-2)
    assert np.abs(f.bodies.rotation[-1]).max() < 1e-4


@pytest.mark.parametrize("dt", [0.02, 0.01, 0.005, 0.002])
@pytest.mark.parametrize("restitution", [0.5, 1])
def test_friction_takes_no_more_of_an_impact_than_is_lost(restitution, dt, tmp_path):
    """A tilted square that comes down on a rough floor, without more loss than friction: what weight does over the way that the floor
    bars is not friction's. It was said to take 1412 J of an impact that took 218."""
    square = np.array([[-0.3906986235230902, 0.013], [0.5893679543181514, 0.21166933079506117], [0.3906986235230902, 1.1917359086363026],
                       [-0.5893679543181514, 0.9930665778412416]])
    (tmp_path / "a.blk").write_text(block_file("impact", [(1, box(-6, 6, -1, 0)), (2, square)], [(x, y, 1) for x in (-6, 6) for y in (-1, 0)]))
    (tmp_path / "a.ana").write_text("\n".join([
        f"1 {round(0.06 / dt)} 2 1 .05 {dt}", "2500 25000 1e10 .25" + " 0" * 9, "2500 25000 1e10 .25 0 0 0 0 0 0 -0.75 -3.4 0", "30 0 0",
        "&deck dialect='short' /", "&method strain='green' /", f"&contact restitution={restitution} /", ""]))
    energy = scree.run(tmp_path / "a.blk", tmp_path / "a.ana", output=tmp_path / "a.h5").history.energy
    assert energy.friction[-1] > 0
    assert (energy.friction - energy.dissipated).max() < 1e-9 * energy.kinetic.max()


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_blocks_that_turn_as_they_strike_do_not_go_in(e, tmp_path):
    """A column of 16 blocks that breaks up on a slope. The step that is made with the impact does not bring what turns to the same places
    by itself: corners went in by 2 % of a block, and rested there."""
    scene = column(16)
    *_, deck = scene.write(tmp_path, 0.005)
    done = scree.call("run", *[p for p in tmp_path.iterdir() if p != deck], deck, "-o", tmp_path / "a.h5", "--quiet",
                      "--set", f"contact.restitution={e}")
    assert done.returncode == 0, done.stderr
    f = scree.read(tmp_path / "a.h5")
    assert f.history.overlap.max() < 1e-5 * scene.edge
    assert np.diff(f.history.energy.dissipated, prepend=0).min() > -1e-9 * f.history.energy.kinetic.max()


@pytest.mark.parametrize("dt", [5e-4, 2e-3, 1e-2])
def test_what_is_struck_does_not_stay_as_deep_as_it_was_pressed(dt, tmp_path):
    """A square that falls flat by 0.2 m and stays: in the end its weight of 6 kN presses the four springs that it and its floor meet
    by, of 5 E each, in by 6e-8 m at most. It stayed up to 1.3e-4 m deep."""
    f = run(tmp_path, [box(-2, 2, -1, 0), turned(box(0, 0.5, 0, 0.5), 0, 0.2)], "&contact restitution=0 /", dt, 0.6,
            [(-1.9, -0.9, 1), (1.9, -0.9, 1)])
    assert f.history.overlap.max() < 2 * 2500 * G * 0.25 / 5e10
    assert f.bodies.centroid[-1, 1, 1] == pytest.approx(0.25, abs=1e-6)


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
def test_ground_without_mass_is_ground(e, tmp_path):
    """A ground of no density had no middle: what fell on it had the springs' bounce, whatever was asked for."""
    heights = []
    for density in (2500, 0):
        (tmp_path / "a.blk").write_text(block_file("ground", [(1, box(-1, 1, -1, 0)), (2, box(-0.25, 0.25, 0.1, 0.6))],
                                                   [(-1, -1, 1), (1, -1, 1), (0, -0.1, 1)]))
        (tmp_path / "a.ana").write_text("\n".join([
            "1 80 2 1 0.05 0.005", f"{density} 0 1e10 0.25 {'0 ' * 9}", f"2500 25000 1e10 0.25 {'0 ' * 9}", "0 0 0",
            "&deck geometry='a.blk', dialect='short' /", f"&contact restitution={e} /", "&output every=1 /", ""]))
        done = scree.call("run", tmp_path / "a.ana", "-o", tmp_path / "a.h5", "--quiet")
        assert done.returncode == 0 and not done.stderr
        heights.append(scree.read(tmp_path / "a.h5").bodies.centroid[:, 1, 1] - 0.25)
    assert heights[1] == pytest.approx(heights[0], abs=1e-9)
    assert max(heights[0][40:]) == pytest.approx(0.1 * e**2, abs=0.01)
