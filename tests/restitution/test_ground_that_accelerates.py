"""Restitution where the ground accelerates: in its frame that is a weight, and bodies meet as under one."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box, held

G = 9.81


def run(path, by_ground, restitution, height, velocity):
    """A square that slides on a base, or falls on it; its weight is that of the deck or of the ground."""
    base = box(-1, 4, -1, 0)
    path.with_suffix(".blk").write_text(block_file("ground", [(1, base), (2, box(0, 1, height, height + 1))], held(base, 1)))
    path.with_suffix(".ana").write_text("\n".join([
        "1 60 2 1 0.05 4e-3", f"2500 0 1e9 0.2 {'0 ' * 9}", f"2500 {0 if by_ground else 2500 * G} 1e9 0.2 {'0 ' * 6} {velocity} 0 0",
        "20 0 0", f"&deck geometry='{path.name}.blk', dialect='short' /", f"&contact restitution={restitution} /", "&step sleep=0 /",
        f"&acceleration table=0 0 {G} 1e6 0 {G} /" if by_ground else "", ""]))
    return scree.run(path.with_suffix(".ana"), output=path.with_suffix(".h5"))


@pytest.mark.parametrize("restitution", [0, 0.5, 1])
@pytest.mark.parametrize("height, velocity", [(0, 0), (0, 1), (0.05, 0), (0.05, 1)])
def test_it_is_a_weight(restitution, height, velocity, tmp_path):
    """What rests, or slides, on a ground that rises took part in impacts that its weight would not have made: by 0.2 % of its friction."""
    by_weight, by_ground = (run(tmp_path / f"{k}", k, restitution, height, velocity) for k in (0, 1))
    np.testing.assert_allclose(by_ground.bodies.centroid, by_weight.bodies.centroid, atol=1e-10)
    np.testing.assert_allclose(by_ground.history.energy.friction, by_weight.history.energy.friction, atol=1e-6)
