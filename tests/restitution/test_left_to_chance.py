"""What strikes in steps that do not resolve how springs swing is told, as its phase in the step decides what comes back of it."""
import json
import math

import numpy as np
import pytest
from scree import call
from scree.block_files import block_file, box, turned

G, EDGE, HEIGHT = 9.81, 0.5, 0.2
FIXED = [(-1.9, -0.9, 1), (1.9, -0.9, 1)]


def summary(folder, tilt, dt, *groups, size=1.0, fall=HEIGHT, steps_after=2):
    """What a run says of a square that falls on a floor with its face, or a corner, by `fall` and two steps more."""
    square = turned(box(-EDGE / 2, EDGE / 2, -EDGE / 2, EDGE / 2), math.radians(tilt))
    square = square + [0, fall - square[:, 1].min()]
    blocks = [(k + 1, x * size) for k, x in enumerate([box(-2, 2, -1, 0), square])]
    (folder / "a.blk").write_text(block_file("chance", blocks, [(x * size, y * size, b) for x, y, b in FIXED]))
    steps = math.ceil(math.sqrt(2 * fall / G) / dt) + steps_after
    (folder / "a.ana").write_text("\n".join([
        f"1 {steps} 2 1 0.05 {dt * math.sqrt(size)}", f"2500 0 {1e10 * size} 0.25 {'0 ' * 9}", f"2500 {2500 * G} {1e10 * size} 0.25 {'0 ' * 9}", "30 0 0",
        "&deck geometry='a.blk', dialect='short' /", *groups, ""]))
    done = call("run", folder / "a.ana", "-o", folder / "a.h5", "--quiet", "--summary", "json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


@pytest.mark.parametrize("size", [1e-3, 1, 1e3])
def test_a_corner_strikes_with_the_energy_that_a_smooth_plastic_impact_takes(size, tmp_path):
    """m v^2/2 over 1 + x^2/(a^2/6), x the arm of the corner: the impulse ends its approach, and turns the square."""
    told, warned = summary(tmp_path, 30, 1e-3, size=size)
    arm = EDGE / math.sqrt(2) * math.sin(math.radians(15))
    fallen = 2500 * EDGE**2 * G * HEIGHT * size**3
    assert told["impacts"]["energy"] == pytest.approx(fallen / (1 + arm**2 / (EDGE**2 / 6)), rel=0.01)  # it falls on in the step
    assert told["impacts"]["share"] == told["impacts"]["energy"] / told["energy"]["given"]
    felt = 2500 * (EDGE * size)**2 / (1 + arm**2 / (EDGE**2 / 6))
    assert told["impacts"]["swing"] == pytest.approx(2 * math.pi * math.sqrt(felt / (5e10 * size)), rel=0.01)
    assert told["warnings"] == 1 and "chance decides" in warned and "contact.restitution" in warned


def test_nothing_is_left_to_chance_by_what_decides_it(tmp_path):
    """Restitution, rules that conserve energy, and steps of a twentieth of the swing."""
    for groups, dt, fall in [(["&contact restitution=0.3 /"], 1e-3, HEIGHT), (["&contact rules='conserving' /"], 1e-3, HEIGHT),
                             ([], 2e-5, 1e-3)]:
        told, warned = summary(tmp_path, 30, dt, *groups, fall=fall)
        assert told["impacts"] is None and not warned, (groups, dt)


def test_what_rests_strikes_nothing(tmp_path):
    """A square that lies on the floor, and gets its weight at once, rings on its springs."""
    told, warned = summary(tmp_path, 0, 5e-3, fall=0.0, steps_after=100)
    assert told["impacts"] is None and not warned
    assert np.isfinite(told["energy"]["given"])


def standing_slope(folder, size, *groups, phi=38.0, steps=100):
    """Rock with two joint sets, a scene 16 m high times `size`, that stands where its friction is above 33 degrees; what a run of it says."""
    (folder / "s.joints").write_text(
        f"&window x=0 {28 * size}, y=0 {16 * size} /\n&slope x=0 {10 * size} {15 * size} {28 * size}, y={3 * size} {3 * size} {12 * size} {12 * size} /\n"
        f"&joint_set dip=33, spacing={2.5 * size}, length={100 * size}, randomness=0.4, material=1 /\n"
        f"&joint_set dip=-60, spacing={3 * size}, length={8 * size}, bridge={size}, randomness=0.4, material=2 /\n"
        f"&support x=0 {28 * size}, y=0 0, hold='both' /\n&support x=0 0, y=0 {3 * size} /\n&support x={28 * size} {28 * size}, y=0 {12 * size} /\n"
        "&seed value=12 /\n")
    assert call("joints", folder / "s.joints", "-o", folder / "s.geo").returncode == 0
    (folder / "s.ana").write_text(f"1 {steps} 1 2 0.05 {0.01 * math.sqrt(size)}\n2600 {2600 * G} {1e10 * size} 0.25\n0 0 0 0 0 0 0 0 0\n"
                                  f"{phi} 0 0\n{phi} 0 0\n" + "\n".join(["&deck geometry='s.geo' /", "&method plane='strain' /", *groups, ""]))
    done = call("run", folder / "s.ana", "-o", folder / "s.h5", "--quiet", "--summary", "json", timeout=120)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout), done.stderr


@pytest.mark.parametrize("size, groups", [(1e-3, []), (1, []), (1e3, []), (1, ["&joints kn=1e9 1e9 /"]), (1, ["&contact stiffness=1e12 /"]),
                                          (1, ["&step accuracy=1e-2 /"])])
def test_a_slope_that_stands_has_no_impact(size, groups, tmp_path):
    """Its weight acts at once, and joints open and close as it settles: what comes back moves blocks by no more than it settles by,
    weight times height squared over twice the modulus."""
    told, warned = standing_slope(tmp_path, size, *groups)
    softer = 1 + (1e10 / (1e9 * 2.5) if "kn=" in "".join(groups) else 0.2)
    assert told["displacement"]["largest"] < 10 * softer * 2600 * G * (12 * size) ** 2 / (2e10 * size)  # it stands
    assert told["impacts"] is None and not warned


@pytest.mark.parametrize("share, counts", [(0.5, False), (4.0, True)])
def test_a_block_strikes_where_it_falls_by_more_than_the_scene_settles(share, counts, tmp_path):
    """A soft square falls on a floor by a share of w H^2/2 (1/E + 1/(2 k)), H the height of the scene. Of a corner a quarter or more of the
    energy of its fall strikes."""
    soft, stiffness = 1e6, 5e10
    settling = 2500 * G * (1 + EDGE) ** 2 / 2 * (1 / soft + 1 / (2 * stiffness))  # before the fall adds to the height
    square = box(-EDGE / 2, EDGE / 2, 0, EDGE) + [0, share * settling]
    (tmp_path / "a.blk").write_text(block_file("chance", [(1, box(-2, 2, -1, 0)), (2, square)], FIXED))
    dt = 2e-3
    steps = math.ceil(math.sqrt(2 * share * settling / G) / dt) + 2
    (tmp_path / "a.ana").write_text(f"1 {steps} 2 1 0.05 {dt}\n2500 0 1e10 0.25 {'0 ' * 9}\n2500 {2500 * G} {soft} 0.25 {'0 ' * 9}\n30 0 0\n"
                                    f"&deck geometry='a.blk', dialect='short' /\n&contact stiffness={stiffness} /\n")
    done = call("run", tmp_path / "a.ana", "-o", tmp_path / "a.h5", "--quiet", "--summary", "json")
    assert done.returncode == 0, done.stderr
    assert (json.loads(done.stdout)["impacts"] is not None) == counts
