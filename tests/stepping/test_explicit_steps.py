"""Explicit steps are as long as no element is too stiff for; one that was short stays so, whatever the stress does that rings."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box


def run(folder, blocks, fixed, stress, velocity, dt, end, groups=()):
    (folder / "a.blk").write_text(block_file("explicit", [(k + 1, x) for k, x in enumerate(blocks)], fixed))
    moving = f"2500 0 1e10 0.25 {stress} {stress} 0 {'0 ' * 3} 0 {velocity} 0"
    material = [moving] if len(blocks) == 1 else [f"2500 0 1e10 0.25 {'0 ' * 9}", moving]
    (folder / "a.ana").write_text("\n".join([
        f"1 {round(end / dt)} {len(blocks)} 1 0.05 {dt}", *material, "0 0 0", "&deck geometry='a.blk', dialect='short' /",
        "&integrator scheme='central_difference' /", *groups, ""]))
    return scree.run(folder / "a.ana", output=folder / "a.h5")


@pytest.mark.parametrize("dt", [2.1e-4, 2e-4, 1.9e-4, 1e-3])
def test_a_block_that_rings_makes_no_energy(dt, tmp_path):
    """Its stress, let go, takes the longest step across the one that is asked for, there and back."""
    energy = run(tmp_path, [box(0, 1, 0, 1)], [], -1e6, 0, dt, 0.1).history.energy
    assert (energy.kinetic + energy.strain + energy.held).max() < 75 * (1 + 1e-9)  # that of its stress, in plane stress


@pytest.mark.parametrize("dt", [2e-3, 1e-3, 6e-4, 2e-4])
def test_a_block_that_lands_makes_no_energy(dt, tmp_path):
    """A square of 1 m at 1 m/s, with Green strain, which is stiffer while it is pressed."""
    r = run(tmp_path, [box(-2, 2, -1, 0), box(-0.5, 0.5, 0.01, 1.01)], [(-1.9, -0.9, 1), (1.9, -0.9, 1)], 0, -1, dt, 0.3,
            ["&method strain='green' /"])
    assert r.history.energy.kinetic.max() < 1250 * (1 + 1e-9)
    sizes = r.history.step_size
    assert np.count_nonzero(np.abs(np.diff(sizes)) > 1e-3 * sizes.max()) <= 5
