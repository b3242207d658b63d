"""What bodies keep of their energy in an impact, over the phases of the step that it may come in: how much higher they fall from, or farther
apart they begin, in shares of what they go in a step."""
import math

import numpy as np
import pytest
import scree
from scree.block_files import block_file, box, turned

G, HEIGHT, EDGE, PHASES = 9.81, 0.2, 0.5, 8


def run(folder, blocks, groups, dt, time, fixed, weight, velocity):
    """Block 1 rests, and is held where it has fixed points; the other has a velocity."""
    (folder / "a.blk").write_text(block_file("phases", [(k + 1, x) for k, x in enumerate(blocks)], fixed))
    (folder / "a.ana").write_text("\n".join([
        f"1 {math.ceil(time / dt)} 2 1 0.05 {dt}", f"2500 0 1e10 0.25 {'0 ' * 9}", f"2500 {weight} 1e10 0.25 {'0 ' * 6} {velocity} 0 0",
        "30 0 0", "&deck geometry='a.blk', dialect='short' /", "&output every=1 /", groups, ""]))
    return scree.run(folder / "a.ana", output=folder / "a.h5")


def kept_in_fall(folder, groups, dt, tilt):
    """Shares of m g h that a square has four steps after it struck a floor with its face, or a corner, of each phase."""
    shares = []
    for phase in range(PHASES):
        fall = HEIGHT + math.sqrt(2 * G * HEIGHT) * dt * phase / PHASES
        square = turned(box(-EDGE / 2, EDGE / 2, -EDGE / 2, EDGE / 2), math.radians(tilt))
        square = square + [0, fall - square[:, 1].min()]
        r = run(folder, [box(-2, 2, -1, 0), square], groups, dt, math.sqrt(2 * fall / G) + 4 * dt, [(-1.9, -0.9, 1), (1.9, -0.9, 1)],
                2500 * G, 0)
        mass = 2500 * EDGE**2
        shares.append(r.history.energy.kinetic[-1] / (mass * G * fall) + (r.bodies.centroid[-1, 1, 1] - square[:, 1].mean()) / fall + 1)
    return np.array(shares)


def kept_in_flight(folder, groups, dt):
    """Shares of the energy of a square that met one of its kind face to face, of each phase."""
    shares = []
    for phase in range(PHASES):
        apart = 0.25 + 2 * dt * phase / PHASES
        r = run(folder, [box(0, EDGE, 0, EDGE), box(EDGE + apart, 2 * EDGE + apart, 0, EDGE)], groups, dt, apart / 2 + 4 * dt, [], 0, -2)
        shares.append(r.history.energy.kinetic[-1] / r.history.energy.kinetic[0])
    return np.array(shares)


@pytest.mark.parametrize("dt", [5e-3, 1e-3])
def test_plastic_impacts_keep_what_rigid_ones_do_in_any_phase(dt, tmp_path):
    """Flat: nothing; of two of a kind: half; on a corner, which sticks: r^2/(2 a^2/3), r its arm across. The turn of the corner in the
    rest of a step is of the first order in dt."""
    plastic = "&contact restitution=0 /"
    np.testing.assert_allclose(kept_in_fall(tmp_path, plastic, dt, 0), 0, atol=1e-5)
    np.testing.assert_allclose(kept_in_flight(tmp_path, plastic, dt), 0.5, atol=1e-6)
    arm = EDGE / math.sqrt(2) * math.sin(math.radians(15))
    np.testing.assert_allclose(kept_in_fall(tmp_path, plastic, dt, 30), arm**2 / (2 / 3 * EDGE**2), atol=0.6 * dt)
