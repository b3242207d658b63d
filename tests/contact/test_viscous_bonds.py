"""A dashpot across bonds resists how fast they stretch, not how far."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

WEIGHT, STIFFNESS = 25e3, 1e7


def hang(folder, *groups, steps=1500, dt=2e-3, strength=1e6):
    """Displacement of a block that is bonded to a roof, along the pull of its weight; mass damping lets it come to rest."""
    roof, block = box(0, 1, 1, 2), box(0, 1, 0, 1)
    (folder / "a.blk").write_text(block_file("hanging", [(1, roof), (2, block)], [(0.1, 1.9, 1), (0.9, 1.9, 1), (0.1, 1.1, 1), (0.9, 1.1, 1)],
                                             load=[(0.5, 0.5, 2)]))
    (folder / "a.ana").write_text("\n".join([
        f"1 {steps} 2 1 0.05 {dt}", f"2500 0 1e9 0 {'0 ' * 9}", f"2500 0 1e9 0 {'0 ' * 9}", f"40 {strength} {strength}",
        f"&loads force=0 {-WEIGHT} /", "&deck geometry='a.blk', dialect='short' /", "&damping mass=40 /", *groups, ""]))
    r = scree.run(folder / "a.ana", output=folder / "a.h5")
    assert r.history.contacts[-1].tolist() == [0, 0, 2]
    return r.bodies.centroid[-1, 1, 1] - r.bodies.centroid[0, 1, 1]


@pytest.mark.parametrize("method", ["", "&contact method='augmented', viscosity={} /"])
@pytest.mark.parametrize("viscosity", [1e3, 1e4, 1e5])
@pytest.mark.parametrize("dt", [4e-3, 1e-3])
def test_where_it_hangs(dt, viscosity, method, tmp_path):
    """As far as without: it hung at W/(kn + 2 c/dt), a thirtieth of that with the largest viscosity."""
    groups = [(method or "&contact viscosity={} /").format(viscosity), f"&joints kn={STIFFNESS} /"]
    assert hang(tmp_path, *groups, steps=round(1.5 / dt), dt=dt) == pytest.approx(-WEIGHT / STIFFNESS, rel=0.03)


def test_a_stage_of_shorter_steps_breaks_nothing(tmp_path):
    """Three times as strong as what they bear; both broke in its first steps, and the block fell."""
    hang(tmp_path, "&contact viscosity=1e4 /", f"&joints kn={STIFFNESS} /", "&stage /", "&step size=4e-5, count=100 /", steps=375,
         dt=4e-3, strength=3 * WEIGHT)
