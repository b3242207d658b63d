"""Bodies that supports or one fixed point hold in part deform as they are struck; an impact gives back no more than it takes, and friction
takes no more than that."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file

LOWER = np.array([(0, 0), (8, 0), (8, 1.375), (0, 3.125)])
UPPER = np.array([(8, 1.385), (8, 4), (0, 4), (0, 3.135)])


def run(folder, fixed, groups, phi=0, weight=20000, velocity=0.0, dt=4e-3, steps=100):
    """A block with a slanting top on its foot, and one that falls on it, or is struck by it."""
    (folder / "a.blk").write_text(block_file("held", [(1, LOWER), (2, UPPER)], fixed))
    (folder / "a.ana").write_text("\n".join([
        f"1 {steps} 2 1 0.05 {dt!r}", f"2000 {weight} 1e8 0.25 {'0 ' * 6} 0 {velocity} 0", f"2000 {weight} 1e8 0.25 {'0 ' * 9}",
        f"{phi} 0 0", "&deck geometry='a.blk', dialect='short' /", "&output every=1 /", *groups, ""]))
    return scree.run(folder / "a.ana", output=folder / "a.h5")


def check_books(r):
    """No step makes energy, and friction neither gives back nor takes more than is lost."""
    energy = r.history.energy
    lost = np.append(0, energy.dissipated)
    assert np.diff(lost).min() > -1e-9 * r.summary["energy"]["given"]
    friction = np.append(0, energy.friction)
    assert np.diff(friction).min() >= 0
    assert friction[-1] <= lost[-1] * (1 + 1e-9)
    assert lost[-1] > 0.01 * r.summary["energy"]["given"]  # there were impacts


@pytest.mark.parametrize("strain", ["small", "green"])
@pytest.mark.parametrize("restitution", [0, 0.5, 0.9])
@pytest.mark.parametrize("dt", [4e-3, 1e-3])
def test_a_block_on_a_guide_is_given_no_more_than_it_had(strain, restitution, dt, tmp_path):
    """Its top slides up and down; below it turns and shears at once, which no impulse on it as a rigid one changes."""
    check_books(run(tmp_path, [], ["&support both=0 0 8 0, x=0 4 8 4 /", f"&contact restitution={restitution} /",
                                   f"&method strain='{strain}' /"], dt=dt, steps=round(0.4 / dt)))


@pytest.mark.parametrize("phi", [0, 30])
@pytest.mark.parametrize("restitution", [0, 0.5, 0.9])
def test_a_block_on_a_pin_is_given_no_more_than_it_had(phi, restitution, tmp_path):
    """In flight: the lower one strikes the upper one far from its pin."""
    check_books(run(tmp_path, [(0.5, 3.5, 2)], [f"&contact restitution={restitution} /"], phi=phi, weight=0, velocity=1.0, steps=60))
