"""Where four corners meet the pairs across bear nothing: what lies flush with both lines of their entrance is in the way."""
import numpy as np
import pytest
from test_blocks_touch import G, MODES, box, run

P = 1e5
GREY = (2500, 0, 1e9, 0.0)


def grid(columns, rows, mirrored):
    """Unit squares in columns and rows, and the same from the other side."""
    blocks = [box(i, j, 1, 1) for j in range(rows) for i in range(columns)]
    return [[(columns - x, y) for x, y in b[::-1]] for b in blocks] if mirrored else blocks


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("columns, rows", [(2, 2), (3, 2), (2, 3), (3, 3)])
@pytest.mark.parametrize("contact", ["&contact stiffness=1e8 /", "", "&joints kn=1e9, ks=1e9 /"])
@pytest.mark.parametrize("mirrored", [False, True])
def test_pressure_goes_down_evenly(mode, columns, rows, contact, mirrored, tmp_path):
    """Blocks without Poisson's ratio under uniform pressure have its stress throughout, which solves the problem exactly."""
    f = run(tmp_path, grid(columns, rows, mirrored), f"{MODES[mode]}\n{contact}\n&support both=0 0 {columns} 0 /\n"
            f"&boundary lines=0 {rows} {columns} {rows}, traction=0 {-P} 0 {-P} /\n&step balance=1e-7 /",
            rock=GREY, phi=30.0, carried=0, steps=300, dt=0.01)
    assert f.scene.status == "complete"
    np.testing.assert_allclose(f.stress(-1)[:, 1], -P, rtol=2e-3)


@pytest.mark.parametrize("carried", [0, 1])
def test_columns_of_blocks_bear_their_own_weight(carried, tmp_path):
    """Six columns of six squares, at rest: the mean stress of a block is the weight of what is above its middle."""
    blocks = [box(-1, -1, 8, 1), *grid(6, 6, False)]
    f = run(tmp_path, blocks, "&step balance=1e-7 /" if carried == 0 else "&damping mass=20 /", rock=(2500, 2500 * G, 1e9, 0.0), phi=30.0,
            carried=carried, steps=300, dt=0.01, fixed=[(x, y, 1) for x, y in blocks[0]])
    above = 5.5 - np.repeat(np.arange(6), 6)
    np.testing.assert_allclose(f.stress(-1)[1:, 1], -2500 * G * above, rtol=5e-3)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("way", [-1, 1])
@pytest.mark.parametrize("off", [0.0, 1e-9, 1e-6, 1e-5, -1e-6])
@pytest.mark.parametrize("dt", [0.005, 0.001])
def test_a_block_whose_corner_stands_on_a_joint_slides(mode, way, off, dt, tmp_path):
    """On two blocks that lie flush, by g (sin a - cos a tan phi) t^2/2 either way, however near the joint its lower corner is. It hung on
    the side of the block beside it, which nothing can get at."""
    angle, phi = np.radians(12), 10.0
    blocks = [box(-4, -0.5, 4, 0.5), box(0, -0.5, 6, 0.5), box(off, 0, 0.6, 0.4)]
    if way > 0:
        blocks = [np.array([(-x, y) for x, y in b[::-1]]) for b in blocks]
    push = f"0 {-way * G * np.sin(angle)} {G * np.cos(angle)}"
    f = run(tmp_path, blocks, f"{MODES[mode]}\n&support both=-6 -0.5 6 -0.5 /\n&acceleration table={push} 1e6 {push[2:]} /",
            rock=(2500, 0, 1e9, 0.2), phi=phi, steps=round(0.5 / dt), dt=dt, measured=[(*blocks[2].mean(0), 3)])
    expected = G * (np.sin(angle) - np.cos(angle) * np.tan(np.radians(phi))) * 0.5**2 / 2
    assert way * f.measured_points.displacement[-1, 0, 0] == pytest.approx(expected, rel=2e-2)
