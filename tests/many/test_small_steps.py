"""Small steps against closed forms, balances and themselves: slides, rest, corners, falls, bonds, bounces, restarts."""
import os
import pathlib
import re

import numpy as np
import pytest
import scree
from scree.block_files import arch, box, held, overhang, running_bond, turned
from small import DENSITY, G, column, decks, run, ways

FLOOR = box(-40, 40, -2, 0)
BLOCK = box(-20.5, -19.5, 0, 1)


def angle(mu):
    return float(np.degrees(np.arctan(mu)))


def slope(folder, tilt, phi, *settings, **given):
    """A block of 1 m on a slope."""
    return run(folder, [(1, FLOOR), (2, BLOCK)], *settings, tilt=tilt, phi=phi, **{"time": 1.0, **given})


@pytest.mark.parametrize("step", [0.005, 0.0005])
@pytest.mark.parametrize("tilt, mu", [(30, 0.0), (30, 0.3), (45, 0.5)])
def test_a_block_slides_down_a_slope_as_Newton_has_it(tilt, mu, step, tmp_path):
    a = np.radians(tilt)
    way = ways(slope(tmp_path, tilt, angle(mu), step=step))[0]
    assert way == pytest.approx(G / 2 * (np.sin(a) - mu * np.cos(a)), rel=1e-5)


def test_a_block_that_hardly_slides_begins_at_once(tmp_path):
    """28 degrees of friction on 30: the forces of the first steps are settled by many sweeps."""
    a = np.radians(30)
    way = ways(slope(tmp_path, 30, 28.0, step=0.0005))[0]
    assert way == pytest.approx(G / 2 * (np.sin(a) - np.tan(np.radians(28)) * np.cos(a)), rel=1e-3)


@pytest.mark.parametrize("tilt, at", [(29.9, -20.5), (-29.9, 19.5), (29.9, 0.0), (-29.9, 0.0)])
def test_what_friction_holds_does_not_creep(tilt, at, tmp_path):
    """30 degrees of friction on 29.9, to the right and to the left, wherever the search begins: the block moves by 5e-5 m as it is
    loaded, and by nothing in the 10 s after. One of its two points is at its limit."""
    result = run(tmp_path, [(1, FLOOR), (2, box(at, at + 1, 0, 1))], tilt=tilt, phi=30.0, time=10.0)
    assert ways(result)[0] < 5e-5
    assert abs(ways(result)[0] - ways(result, frame=result.n_frames // 10)[0]) < 1e-9


def test_a_mirrored_slope_is_the_same(tmp_path):
    for name in "ab":
        (tmp_path / name).mkdir()
    sides = [slope(tmp_path / "a", 30, 10.0), run(tmp_path / "b", [(1, FLOOR), (2, box(19.5, 20.5, 0, 1))], tilt=-30, phi=10.0, time=1.0)]
    assert ways(sides[0])[0] == pytest.approx(ways(sides[1])[0], rel=1e-9)


def test_a_corner_that_strikes_a_slope_turns_its_block_as_rigid_dynamics_has_it(tmp_path):
    """A square of 50 mm falls 50 mm on a slope of 45 degrees: place, fall and turn 0.15 s after it was let go."""
    h, x0 = 0.025, 0.125
    y0 = 0.5 - (x0 - h) + 0.05 + h
    ground = turned(box(-0.4, 1.2, -0.5, 0), -np.pi / 4) + [0, 0.5]
    result = run(tmp_path, [(1, ground), (2, box(x0 - h, x0 + h, y0 - h, y0 + h))], phi=angle(0.3), time=0.15, step=2e-4)
    assert result.bodies.centroid[-1, 1] == pytest.approx((0.143213, 0.394993), abs=1e-3 * 2 * h)
    assert result.bodies.rotation[-1, 1] == pytest.approx(-0.7285, abs=5e-3)


def test_momentum_and_angular_momentum_stay(tmp_path):
    """Three blocks fly into each other without weight, and two of them overlap as they begin."""
    square = box(0, 1, 0, 1)
    blocks = [(1, box(-1000, -999, 0, 1)), (2, square), (1, turned(square, 0.3) + [1.5, 0.2]), (1, turned(square, 0.7) + [3.5, 0.1]),
              (1, box(-0.995, 0.005, 0.2, 1.2))]
    result = run(tmp_path, blocks, "step.sleep=0", phi=angle(0.5), time=1.0, gravity=0.0, velocity=(5.0, 0.3, 0.5))
    start = result.history.momentum[0]
    assert result.history.contacts[:, 1:].sum() > 0
    size = DENSITY * np.array([5.0, 5.0, 5.0 * 1000])
    size[2] = abs(start).max() + DENSITY * 5.0
    assert np.all(abs(result.history.momentum - start) < 1e-12 * size)


@pytest.mark.parametrize("factor, stands", [(0.99, True), (1.01, False)])
def test_a_harmonic_overhang_stands_below_its_limit_alone(factor, stands, tmp_path):
    (tmp_path / "x").mkdir()
    files = decks(tmp_path, [(1, box(0, 1, 0, 1)), (2, box(0, 1, 1, 2))], time=4.0, phi=31.0)
    files[0].write_text(overhang(factor))
    result = scree.run(*files, output=tmp_path / "x.h5", settings=["step.accuracy=3e-3"])
    assert (ways(result).max() < 1e-2) == stands


@pytest.mark.parametrize("factor, stands", [(1.02, True), (0.98, False)])
def test_an_arch_stands_at_its_least_thickness_and_no_less(factor, stands, tmp_path):
    """Eight voussoirs; the least thickness is 0.10086 of the radius (Couplet, Heyman; for voussoirs Ochsendorf 2006)."""
    files = decks(tmp_path, [(1, box(0, 1, 0, 1)), (2, box(0, 1, 1, 2))], time=4.0, step=5e-4, phi=45.0)
    files[0].write_text(arch(8, 0.10086 * factor))
    result = scree.run(*files, output=tmp_path / "x.h5", settings=["output.every=100"])
    assert (ways(result).max() < 2e-2) == stands


def test_a_stack_stands_and_makes_no_energy(tmp_path):
    """Twenty blocks of 1 m for 4 s: overlaps are below 1e-3 of a block, and energy is made nowhere."""
    blocks = [(1, box(-5, 5, -1, 0))] + [(2, box(-0.5, 0.5, k, k + 1)) for k in range(20)]
    result = run(tmp_path, blocks, "step.sleep=0", phi=31.0, time=4.0)
    assert result.history.overlap.max() < 1e-3
    assert ways(result).max() < 20 * result.history.overlap.max()
    assert result.history.energy.dissipated.min() > -1e-5 * 20 * DENSITY * G * 20


def test_a_heavy_block_stands_on_light_ones(tmp_path):
    """A block of a thousand times the weight of those below it, on ten of them."""
    blocks = [(1, box(-5, 5, -1, 0))] + [(1, box(-0.5, 0.5, k, k + 1)) for k in range(10)] + [(2, box(-0.5, 0.5, 10, 11))]
    files = decks(tmp_path, blocks, time=4.0, phi=31.0)
    text = files[1].read_text().splitlines()
    text[2] = f"{1000 * DENSITY} {1000 * DENSITY * G} 1e10 0.25 0 0 0 0 0 0 0 0 0"
    files[1].write_text("\n".join(text))
    result = scree.run(*files, output=tmp_path / "x.h5", settings=["step.accuracy=1e-3"])
    assert ways(result).max() < 1e-2


def test_a_block_slides_over_a_row_of_flush_blocks(tmp_path):
    """Eighty blocks that are flush take the way that one floor has: nothing catches at their corners."""
    a = np.radians(30)
    row = [box(0.7 * i - 10, 0.7 * i - 9.3, -1, 0) for i in range(80)]
    blocks = [(1, b) for b in row] + [(2, box(-9, -8, 0, 1))]
    fixed = [p for k, b in enumerate(row) for p in held(b, k + 1)]
    result = run(tmp_path, blocks, tilt=30, phi=angle(0.3), time=1.0, step=1e-3, fixed=fixed)
    assert ways(result)[-1] == pytest.approx(G / 2 * (np.sin(a) - 0.3 * np.cos(a)), rel=1e-3)


@pytest.mark.parametrize("restitution", [0.0, 0.5, 0.8])
def test_a_block_bounces_by_its_restitution(restitution, tmp_path):
    """A flat block falls 1 m; it rises again by e^2 of that."""
    result = run(tmp_path, [(1, box(-5, 5, -1, 0)), (2, box(-0.5, 0.5, 1, 2))], f"contact.restitution={restitution}",
                 "output.every=10", phi=26.0, time=1.2, step=2e-4)
    height = result.bodies.centroid[:, 1, 1] - 0.5
    struck = int(np.argmax(height < 0.01))
    assert struck > 0 and height[struck:].max() == pytest.approx(restitution**2, abs=1e-2)


@pytest.mark.parametrize("phi, tilt", [(0.0, 0.0), (30.0, 0.0), (0.0, 20.0)])
def test_a_block_that_bounces_flat_does_not_turn(phi, tilt, tmp_path):
    """Three bounces, each to e^2 of the height before. A block that turned by 2e-4 would strike with one corner the third time."""
    e = 0.8
    result = run(tmp_path, [(1, box(-30, 30, -1, 0)), (2, box(-0.5, 0.5, 1, 2))], f"contact.restitution={e}", "output.every=10",
                 phi=phi, tilt=tilt, time=2.9, step=2e-4)
    down = np.array([np.sin(np.radians(tilt)), np.cos(np.radians(tilt))])
    height = result.bodies.centroid[:, 1] @ down - 0.5
    tops = [h for before, h, after in zip(height, height[1:], height[2:]) if before < h >= after]
    assert tops[:3] == pytest.approx([e**2, e**4, e**6], rel=2e-2)
    assert np.abs(result.history.rotation[:, 1]).max() < 1e-6


@pytest.mark.parametrize("share, holds", [(0.98, True), (1.02, False)])
def test_a_bond_holds_up_to_its_strength_in_tension(share, holds, tmp_path):
    """A block of 1 m hangs from a ceiling, by a joint that bears 1/share of its weight."""
    strength = DENSITY * G / share
    result = run(tmp_path, [(1, box(-2, 3, 1, 2)), (2, box(0, 1, 0, 1))], phi=20.0, joint=f"0 {strength}", time=1.0)
    assert (ways(result).max() < 1e-2) == holds


@pytest.mark.parametrize("share, holds", [(0.98, True), (1.02, False)])
def test_cohesion_holds_a_block_on_a_slope(share, holds, tmp_path):
    """45 degrees, friction 0.5: cohesion bears the rest of the weight, over 1 m."""
    a = np.radians(45)
    cohesion = DENSITY * G * (np.sin(a) - 0.5 * np.cos(a)) / share
    result = slope(tmp_path, 45, angle(0.5), joint=f"{cohesion} 0")
    assert (ways(result)[0] < 1e-2) == holds


def test_joints_that_wear_let_go(tmp_path):
    """35 degrees of friction that fall to 20 over a slip of 1 cm hold a block on 30 degrees; one that is pushed slides on."""
    given = ["joints.residual_phi=20", "joints.residual_slip=0.01"]
    for name in "ab":
        (tmp_path / name).mkdir()
    assert ways(slope(tmp_path / "a", 30, 35.0, *given))[0] < 1e-3
    a = np.radians(30)
    speed = 2.0
    result = slope(tmp_path / "b", 30, 35.0, *given, velocity=(speed * np.cos(a), -speed * np.sin(a), 0.0))
    expected = speed + G / 2 * (np.sin(a) - np.tan(np.radians(20)) * np.cos(a))
    assert ways(result)[0] == pytest.approx(expected, rel=5e-3)


def scenes(folder):
    """Scenes that are stopped and gone on with: a collapse, bonds that break, what falls asleep and wakes."""
    wall = [(1 if i == 0 else 2, b) for i, b in enumerate(running_bond(4))]
    return {
        "column": decks(folder, column(36), phi=angle(0.3), time=0.4, name="column", groups="&output every=4 /"),
        "bonds": decks(folder, wall, phi=20.0, joint="2e4 1e4", time=0.4, name="bonds", velocity=(3.0, 0.0, 0.0),
                       groups="&output every=4 /\n&joints residual_phi=10, residual_slip=0.1 /"),
        "sleep": decks(folder, [*wall, (2, box(1.5, 2.5, 6.0, 7.0))], phi=31.0, time=1.0, name="sleep",
                       groups="&step sleep=1e-3 /\n&output every=10 /"),
    }


@pytest.mark.parametrize("name", ["column", "bonds", "sleep"])
def test_a_run_that_is_stopped_goes_on_with_the_same_bits(name, tmp_path):
    """All that small steps keep from one step of the run to the next is in a checkpoint: what is kept beside it decides no bit."""
    files = scenes(tmp_path)[name]
    whole = scree.run(*files, output=tmp_path / "whole.h5")
    n = len(whole.history.time)
    moments = np.random.default_rng(7).choice(np.arange(1, n), 3, replace=False)
    for moment in moments:
        scree.run(*files, output=tmp_path / "part.h5", settings=[f"step.count={moment}"])
        done = scree.call("run", "--restart", tmp_path / "part.h5", "--quiet", "--set", f"step.count={n}")
        assert done.returncode == 0, done.stderr
        part = scree.read(tmp_path / "part.h5")
        for quantity in ("centroid", "rotation", "velocity", "stress"):
            a, b = getattr(whole.bodies, quantity)[-1], getattr(part.bodies, quantity)[-1]
            assert a.tobytes() == b.tobytes(), (name, moment, quantity)
        assert whole.history.energy.kinetic.tobytes() == part.history.energy.kinetic.tobytes()


def test_an_L_lies_and_falls_as_one_body(tmp_path):
    """A concave block is cut into convex pieces, between whose faces nothing catches."""
    a = np.radians(30)
    shape = np.array([[0, 0], [3, 0], [3, 1], [1, 1], [1, 2], [0, 2]]) + [-20.0, 0]
    result = run(tmp_path, [(1, FLOOR), (2, shape)], tilt=30, phi=angle(0.3), time=1.0)
    assert ways(result)[0] == pytest.approx(G / 2 * (np.sin(a) - 0.3 * np.cos(a)), rel=1e-4)
    assert abs(result.bodies.rotation[-1, 1]) < 1e-4


def test_the_mean_stress_of_a_block_is_that_of_its_contacts(tmp_path):
    """Blocks of a column at rest: s_yy at the middle of each is the weight above it."""
    blocks = [(1, box(-5, 5, -1, 0))] + [(2, box(-0.5, 0.5, k, k + 1)) for k in range(4)]
    result = run(tmp_path, blocks, "step.sleep=0", phi=31.0, time=2.0)
    expected = -DENSITY * G * (np.arange(4)[::-1] + 0.5)
    assert result.bodies.stress[-1, 1:, 1] == pytest.approx(expected, rel=1e-3)
    assert abs(result.bodies.stress[-1, 1:, [0, 2]]).max() < 1e-3 * DENSITY * G


@pytest.mark.parametrize("groups, expected", [
    ("&method model='nmm' /\n&cover edge=0.5 /", "method.model"),
    ("&contact viscosity=1e3 /", "contact.viscosity"),
    ("&contact method='augmented' /", "contact.method"),
    ("&joints dilation=5, dilation_slip=0.1 /", "joints.dilation"),
    ("&output error='estimate' /", "output.error")])
def test_what_small_steps_do_not_have_is_refused(groups, expected, tmp_path):
    files = decks(tmp_path, [(1, FLOOR), (2, BLOCK)], time=0.1, groups=groups)
    done = scree.call("run", *files, "-o", tmp_path / "x.h5")
    assert done.returncode == 2 and expected in done.stderr and "small_steps" in done.stderr, done.stderr


def test_a_static_run_is_refused(tmp_path):
    files = decks(tmp_path, [(1, FLOOR), (2, BLOCK)], time=0.1, carried=0)
    done = scree.call("run", *files, "-o", tmp_path / "x.h5")
    assert done.returncode == 2 and re.search("small_steps.*k01 above 0", done.stderr), done.stderr


def test_sizes_follow_the_accuracy(tmp_path):
    """A third of the run-out error takes about twice the small steps."""
    counts = {}
    for accuracy in (0.03, 0.01, 0.003):
        result = run(tmp_path, column(36), f"step.accuracy={accuracy}", phi=angle(0.3), time=0.1)
        counts[accuracy] = result.history.deformation_iterations[0]
    assert 1.7 < counts[0.01] / counts[0.03] < 2.3 and 1.7 < counts[0.003] / counts[0.01] < 2.3


def test_threads_change_no_bit(tmp_path):
    """3660 blocks of a wall and a block that flies into it, with one thread and with two."""
    wall = [(1, b) for b in running_bond(60)] + [(2, box(-4.0, -1.2, 30.0, 32.0))]
    files = decks(tmp_path, wall, phi=31.0, time=0.02, velocity=(30.0, 0.0, 0.0), groups="&output every=2 /")
    runs = [scree.run(*files, output=tmp_path / f"{n}.h5", words=["--threads", str(n)]) for n in (1, 2)]
    assert len(wall) > 3000 and runs[0].history.contacts[-1].sum() > 3000
    for quantity in ("centroid", "rotation", "velocity", "stress"):
        a, b = (getattr(r.bodies, quantity)[-1] for r in runs)
        assert a.tobytes() == b.tobytes(), quantity


def test_a_beam_lies_on_more_blocks_than_there_are_colours(tmp_path):
    """Eighty blocks bear a beam: contacts of one body beyond 63 have no colour of their own."""
    blocks = [(1, box(-1, 81, -1, 0))] + [(2, box(k, k + 0.7, 0, 0.7)) for k in range(80)] + [(2, box(0, 80, 0.7, 2.7))]
    result = run(tmp_path, blocks, "step.sleep=0", phi=31.0, time=1.0)
    assert ways(result).max() < 2e-3
    assert result.history.contacts[-1].sum() >= 4 * 80
    assert result.history.energy.kinetic[-1] < 1e-6 * 160 * DENSITY * G


def test_blocks_of_a_rock_slope_fall_freely_and_do_not_catch(tmp_path):
    """697 blocks of two joint sets, many of them concave: those that nothing holds fall as Newton has it."""
    geometry = pathlib.Path(os.environ["SCREE_SOURCE"]) / "input" / "bench" / "slope" / "big.geo"
    rock = f"{DENSITY} {DENSITY * G} 1e10 0.25\n0 0 0 0 0 0 0 0 0"
    (tmp_path / "x.ana").write_text("\n".join(["1 100", "2 2", "0.05", "0.005", rock, rock, "40 0 0", "40 0 0",
                                               f"&deck geometry='{geometry}' /", "&integrator scheme='small_steps' /", ""]))
    result = scree.run(tmp_path / "x.ana", output=tmp_path / "x.h5")
    assert ways(result, slice(0, None)).max() == pytest.approx(G / 2 * 0.5**2, rel=1e-4)
    assert result.history.overlap.max() < 1e-3
    assert result.history.energy.dissipated.min() > 0


@pytest.mark.parametrize("restitution", [0, 0.3])
@pytest.mark.parametrize("corners", [5, 6, 7, 8])
def test_a_rock_comes_to_rest_in_a_corner_of_concave_ground(corners, restitution, tmp_path):
    """A slope and a wall on it are one outline. Rocks that roll against the wall have no energy left two seconds later."""
    top = [(0, 60), (8, 58), (14, 40), (40, 20), (58, 12), (66, 11.33), (66, 13.83), (66.5, 13.83), (66.5, 11.29), (70, 11), (95, 10)]
    ground = np.array([(0, 0), (95, 0), *top[::-1]], float)
    for k, x in enumerate((58.0, 61.0, 63.5)):
        turns = 0.3 * k + np.arange(corners) * 2 * np.pi / corners
        y = np.interp(x, *np.transpose(top[:6])) + 0.9
        rock = 0.4 * np.column_stack([np.cos(turns), np.sin(turns)]) + [x, y]
        result = run(tmp_path, [(1, ground), (2, rock)], f"contact.restitution={restitution}", time=8.0, phi=30.0, velocity=(6.0, 0, 0),
                     fixed=[(1, 1, 1), (90, 1, 1)], name=f"rock{k}")
        kinetic = np.asarray(result.history.energy.kinetic)
        assert kinetic[0] > 0
        assert kinetic[-400:].max() < 1e-2 * kinetic[0]
        assert kinetic[-1] < 1e-6 * kinetic[0]
