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
        f"1 {steps} 2 1 0.05 {dt}", f"2000 {weight} 1e8 0.25 {'0 ' * 6} 0 {velocity} 0", f"2000 {weight} 1e8 0.25 {'0 ' * 9}",
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


@pytest.mark.parametrize("pins", [[(0, 0, 1)], [(0, 0, 1), (0, 0, 2)], [(0, 0, 1), (1e-7, 0, 2)]])
@pytest.mark.parametrize("method", ["exact", "penalty"])
def test_pins_in_one_place_are_one_hinge(pins, method, tmp_path):
    """Two squares that are bonded, on a pin in each, swing about it; a third one strikes them, and gives what it has about the pin. Of two
    that are apart by rounding they were taken for clamped."""
    squares = [np.array([(x, -1), (x + 1, -1), (x + 1, 0), (x, 0)]) for x in (-1, 0)]
    ball = np.array([(-1.51, -0.95), (-1.01, -0.95), (-1.01, -0.45), (-1.51, -0.45)])
    (tmp_path / "a.blk").write_text(block_file("hinge", [(1, squares[0]), (1, squares[1]), (2, ball)], pins))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 20 2 1 0.05 1e-3", f"2500 0 5e9 0.2 {'0 ' * 9}", f"2500 0 5e9 0.2 {'0 ' * 6} 2 0 0", "0 1e7 1e7",
        "&deck geometry='a.blk', dialect='short' /", "&contact restitution=1 /", f"&fixed_points method='{method}' /", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    ball_mass, inertia = 2500 * 0.25, 2500 * 2 * (2**2 + 1) / 12 + 5000 * 0.5**2
    turn = r.bodies.velocity[-1, 1, 1] / 0.5      # of the squares, whose centres are that far from the pin, to the side and down
    about = ball_mass * 0.7 * r.bodies.velocity[-1, 2, 0]
    assert turn > 0.4
    assert about + inertia * turn == pytest.approx(ball_mass * 0.7 * 2, rel=5e-3)
