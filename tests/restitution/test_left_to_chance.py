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
        f"1 {steps} 2 1 0.05 {dt * math.sqrt(size)!r}", f"2500 0 {1e10 * size!r} 0.25 {'0 ' * 9}", f"2500 {2500 * G} {1e10 * size!r} 0.25 {'0 ' * 9}", "30 0 0",
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
