"""With `iteration.test='residual'` a flight that balances is no reason to pass by what lies ahead: contacts are judged first."""
import math

import pytest
import scree
from scree.block_files import block_file, box

FIXED = [(-3.9, -0.9, 1), (3.9, -0.9, 1)]


def run(folder, blocks, material, groups, steps, dt=2e-3, phi=20, fixed=FIXED):
    (folder / "a.blk").write_text(block_file("balance", [(k + 1, x) for k, x in enumerate(blocks)], fixed))
    (folder / "a.ana").write_text("\n".join([
        f"1 {steps} {len(blocks)} 1 0.05 {dt}", *material, f"{phi} 0 0", "&deck geometry='a.blk', dialect='short' /",
        "&output every=1 /", "&iteration test='residual' /", *groups, ""]))
    return scree.run(folder / "a.ana", output=folder / "a.h5")


GROUND = f"2500 0 1e10 0.25 {'0 ' * 9}"


@pytest.mark.parametrize("groups", [["&method strain='green' /"], ["&method strain='auto' /"],
                                    ["&method strain='green' /", "&contact restitution=0 /"],
                                    ["&method strain='green' /", "&contact method='augmented' /"],
                                    ["&method strain='green' /", "&integrator scheme='energy_momentum' /"],
                                    ["&contact rules='conserving' /"]], ids=str)
def test_a_block_that_falls_lands(groups, tmp_path):
    """By 0.1 m, in 0.143 s; then it rests, or hops on its springs, not deeper than these give."""
    r = run(tmp_path, [box(-4, 4, -1, 0), box(-0.5, 0.5, 0.1, 1.1)], [GROUND, f"2500 24525 1e10 0.25 {'0 ' * 9}"], groups, 200)
    assert r.bodies.centroid[-1, 1, 1] > 0.5 - 2e-4
    assert r.history.overlap.max() > 0


@pytest.mark.parametrize("spin", [0, 3])
def test_a_block_that_slides_stops_at_a_wall(spin, tmp_path):
    """At 2 m/s on a floor without friction, or turning beside it in flight, 0.5 m from a wall that is held."""
    height = 0.0 if spin == 0 else 0.5
    wall = box(1, 2, 0, 4)
    r = run(tmp_path, [box(-4, 4, -1, 0), box(-0.5, 0.5, height, 1 + height), wall],
            [GROUND, f"2500 {24525 if spin == 0 else 0} 1e10 0.25 {'0 ' * 6} 2 0 {spin}", GROUND],
            ["&method strain='green' /", "&contact restitution=0 /"], 250, phi=0, fixed=[*FIXED, (1.5, 0.5, 3), (1.5, 3.5, 3)])
    farthest = r.bodies.centroid[:, 1, 0].max() + (0.5 if spin == 0 else 0.5)
    assert farthest < 1 + 1e-3 and math.isclose(r.bodies.centroid[0, 1, 0], 0, abs_tol=1e-12)
