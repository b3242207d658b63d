"""The work of supports that move exactly: of what they move, and of what that touches."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

E, DENSITY = 1e9, 2500.0


def move(folder, blocks, fixed, still, table, steps, dt, phi, weight, method, more=""):
    """Blocks of which `fixed` points are held, the first so many still, the others by the table of time and displacement."""
    (folder / "m.blk").write_text(block_file("moving supports", [(1, b) for b in blocks], fixed))
    tables = "\n".join(" ".join(map(repr, map(float, row))) for _ in fixed[still:] for row in table)
    (folder / "m.ana").write_text(f"1 {steps} 1 1 0.05 {dt}\n0\n{' '.join(['0'] * still + [str(len(table))] * (len(fixed) - still))}\n"
                                  f"{tables}\n{DENSITY} {weight} {E} 0.25{' 0' * 9}\n{phi} 0 0\n&deck dialect='shi' /\n"
                                  f"&method strain='small' /\n&fixed_points method='{method}' /\n{more}")
    return scree.run(folder / "m.blk", folder / "m.ana", output=folder / "m.h5").history.energy


def corners(a, b, c, d, block):
    return [(x, y, block) for x in (a, b) for y in (c, d)]


@pytest.mark.parametrize("method", ["exact", "penalty"])
def test_a_wall_that_pushes_a_block_over_a_floor_does_the_work_of_friction(method, tmp_path):
    """By 0.5 m in half a second, a weight of 25 kN and 30 degrees. The block gets its speed in a blow, and leaves the wall now and then."""
    energy = move(tmp_path, [box(-2, 4, -1, 0), box(-0.5, -0.001, 0.1, 0.9), box(0, 1, 0, 1)],
                  corners(-1.94, 3.94, -0.99, -0.01, 1) + corners(-0.495, -0.006, 0.108, 0.892, 2), 4,
                  [(0, 0, 0), (0.05, 0.001, 0), (1.05, 0.501, 0)], 200, 0.005, 30, 25000, method)
    assert energy.friction[-1] == pytest.approx(np.tan(np.pi / 6) * 25000 * 0.5, rel=0.12)
    assert 0 < energy.dissipated[-1] - energy.friction[-1] < 0.1 * energy.work[-1]
    assert np.diff(energy.dissipated, prepend=0).min() > -1e-9 * energy.work[-1]


@pytest.mark.parametrize("method", ["exact", "penalty"])
def test_a_platen_that_squeezes_a_block_does_the_work_that_is_stored(method, tmp_path):
    """No weight, no friction: strain of the block and overlap of its contacts, but for what rings at first."""
    energy = move(tmp_path, [box(-1, 2, -1, 0), box(0, 1, 0, 1), box(-0.5, 1.5, 1, 2)],
                  corners(-0.9, 1.9, -0.9, -0.1, 1) + corners(-0.4, 1.4, 1.1, 1.9, 3), 4,
                  [(0, 0, 0), (0.1, 0, -0.002)], 100, 0.001, 0, 0, method)
    stored = energy.strain[-1] + energy.contact[-1] + energy.kinetic[-1] + energy.held[-1]
    stored += getattr(energy, "fixed_springs", [0])[-1]
    assert energy.work[-1] == pytest.approx(stored, rel=0.03)
    assert np.diff(energy.dissipated, prepend=0).min() > -1e-9 * energy.work[-1]


def test_a_wall_that_moves_into_a_floor_is_a_run(tmp_path):
    """It was stopped, as energy from nothing."""
    energy = move(tmp_path, [box(-2, 4, -1, 0), box(0, 1, 0.001, 1)], corners(-1.94, 3.94, -0.99, -0.01, 1) + corners(0.1, 0.9, 0.1, 0.9, 2), 4,
                  [(0, 0, 0), (0.1, 0, -0.004)], 100, 0.001, 0, 25000, "exact")
    assert energy.dissipated[-1] > -1e-9 * energy.work[-1]


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("method", ["exact", "penalty"])
def test_a_ram_that_strikes_a_block_does_the_work_of_its_impulse(method, e, tmp_path):
    """It goes at V = 1 from the start, which springs give it by M V^2, half of it lost; to the block of mass m it gives m (1 + e) V, and keeps its
    speed by m (1 + e) V^2, of which m (1 - e^2) V^2/2 is lost. None of that was in the books, and the run warned of energy from nothing."""
    energy = move(tmp_path, [box(0, 1, 0, 1), box(0.1, 0.9, 1.0123, 1.8)], corners(0.1, 0.9, 0.1, 0.9, 1), 0, [(0, 0, 0), (1, 0, 1)], 50, 0.001,
                  0, 0, method, f"&contact restitution={e} /\n")
    ram, block = DENSITY * (method == "penalty"), DENSITY * 0.8 * 0.7877
    assert energy.work[-1] == pytest.approx(ram + block * (1 + e), rel=1e-4)
    assert energy.dissipated[-1] == pytest.approx(ram / 2 + block * (1 - e**2) / 2, rel=1e-4, abs=1e-9 * block)
    assert np.diff(energy.dissipated, prepend=0).min() > -1e-9 * energy.work[-1]


@pytest.mark.parametrize("e", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("stages", [1, 2, 3])
def test_a_ram_keeps_its_speed_through_stages(stages, e, tmp_path):
    """Each began with the ram at rest, which its table brought to 1.78, 0.59, 1.19 and so on of its speed: a block left it at 1.08 for 1.5."""
    given = [box(0, 1, 0, 1), box(0.1, 0.9, 1.0413, 1.8)], corners(0.1, 0.9, 0.1, 0.9, 1), 0, [(0, 0, 0), (10, 0, 10)]
    more = f"&contact restitution={e} /\n&output every=1 /\n"
    move(tmp_path, *given, 60 // stages, 0.001, 0, 0, "exact", more + "".join(f"&stage name='next {k}' /\n" for k in range(1, stages)))
    velocity = scree.read(tmp_path / "m.h5").bodies.velocity
    np.testing.assert_allclose(velocity[:, 0, 1], 1, rtol=1e-9)
    assert velocity[-1, 1, 1] == pytest.approx(1 + e, rel=1e-4)
