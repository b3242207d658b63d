"""A pebble on a mountain: what a contact weighs and measures by is its own bodies', not the largest of the scene."""
import numpy as np
import pytest
from test_blocks_touch import G, MODES, box, run, turn


def slide(folder, size, slope, mode, boulder=0.0, groups=""):
    """A box on a fixed slope of 30 degrees, tan phi 0.3, for about 20 of its lengths; shares of the way by which box and boulder
    miss Galileo's and Coulomb's s = g (sin a - cos a tan phi) t^2/2."""
    a, share = np.radians(30), 0.3
    acceleration = G * (np.sin(a) - share * np.cos(a))
    t = min(1.0, np.sqrt(2 * 20 * size / acceleration))
    blocks = [box(-slope / 2, -slope / 60, slope, slope / 60), box(0, 0, size, size)]
    if boulder:
        blocks.append(box(-0.4 * slope, 0, boulder, boulder))
    fixed = [(*(turn(-30) @ (0.99 * (x - blocks[0].mean(0)) + blocks[0].mean(0))), 1) for x in blocks[0]]
    blocks = [corners @ turn(-30).T for corners in blocks]
    f = run(folder, blocks, MODES[mode] + groups, rock=(2500, 2500 * G, 1e10, 0.25), phi=np.degrees(np.arctan(share)), dt=t / 100,
            steps=100, fixed=fixed)
    way = np.linalg.norm(f.bodies.centroid[-1] - f.bodies.centroid[0], axis=1)[1:]
    assert len(f.history.time) <= 101
    return way / (acceleration * f.history.time[-1] ** 2 / 2) - 1


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("slope", [120.0, 1000.0])
@pytest.mark.parametrize("size", [0.001, 0.005, 0.05, 0.5])
def test_a_pebble_slides_on_a_mountain(size, slope, mode, tmp_path):
    """To 1e-4 of the way, as blocks of a metre do (b1)."""
    assert np.abs(slide(tmp_path, size, slope, mode)).max() < 1e-4


@pytest.mark.parametrize("mode", ["dda", "green"])
def test_a_boulder_does_not_hold_a_pebble(mode, tmp_path):
    """A boulder of 100 m, 4e8 times as heavy, slides on the same slope, and shortens by a centimetre under its weight."""
    assert abs(slide(tmp_path, 0.005, 1000.0, mode, boulder=100.0)[0]) < 1e-4


@pytest.mark.parametrize("mode", ["dda", "green"])
def test_stiff_springs_do_not_hold_a_block(mode, tmp_path):
    """A million times E."""
    assert np.abs(slide(tmp_path, 0.5, 120.0, mode, groups="\n&contact stiffness=1e16 /")).max() < 1e-4
