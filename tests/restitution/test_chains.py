"""Impacts that drive bodies against others within the step, piles of many, and bonds that are struck."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

FLOOR, DENSITY = box(-4, 4, -1, 0), 2500


def run(folder, blocks, velocities, groups, dt=0.001, steps=60, joint="0 0 0", on_floor=False, young=1e9, weight=0, model="dda",
        strain="green"):
    """Blocks, each with a velocity of its own; where they are on a floor that is the first, and held."""
    velocities = [(0, 0)] * on_floor + velocities
    fixed = [(x, y, 1) for x in (-3.96, 3.96) for y in (-0.995, -0.005)] if on_floor else []
    (folder / "a.blk").write_text(block_file("chain", [(k + 1, block) for k, block in enumerate([FLOOR] * on_floor + blocks)], fixed))
    (folder / "a.ana").write_text("\n".join([
        f"1 {steps} {len(velocities)} 1 .05 {dt}", *(f"{DENSITY} {weight} {young} .25{' 0' * 6} {vx} {vy} 0" for vx, vy in velocities), joint,
        "&deck geometry='a.blk', dialect='short' /", f"&method strain='{strain}', model='{model}' /", "&output every=1 /", *groups, ""]))
    return scree.run(folder / "a.ana", output=folder / "a.h5")


def check_books(r):
    """No step makes energy, and friction takes no more than is lost."""
    energy = r.history.energy
    scale = max(energy.kinetic.max(), np.ptp(energy.gravity) if hasattr(energy, "gravity") else 0)
    assert np.diff(energy.dissipated, prepend=0).min() > -1e-9 * scale
    assert (energy.friction - energy.dissipated).max() < 1e-9 * scale


@pytest.mark.parametrize("gap", [1e-5, 1e-4, 3e-4, 2e-3])
@pytest.mark.parametrize("restitution, kept", [(0, 1 / 3), (1, 1)])
def test_a_square_that_strikes_a_row_drives_it_on(restitution, kept, gap, tmp_path):
    """Three squares, the first at 1: momentum stays, and all of the energy, or a third of it, whether the second meets the third in the
    step of its impact or later. With gaps of 1e-4, a tenth of the way of a step, 0.64 and 0.37 were left."""
    row = [box(-0.05, 0.95, 0, 1), box(1 + gap, 2 + gap, 0, 1), box(2 + 2 * gap, 3 + 2 * gap, 0, 1)]
    r = run(tmp_path, row, [(1, 0), (0, 0), (0, 0)], [f"&contact restitution={restitution} /"], steps=80)
    velocity = r.bodies.velocity[-1, :, 0]
    assert velocity.sum() == pytest.approx(1, abs=1e-6)
    assert (velocity**2).sum() == pytest.approx(kept, abs=1e-6)
    assert np.diff(velocity).min() > -1e-6
    check_books(r)


def test_two_blocks_that_fly_at_a_wall_leave_it(tmp_path):
    """The second meets the first just as that comes back, in the step after, when the first may still be counted as closed: a fifth was lost with
    e = 1; without the way that bodies go in the step 0.22 was left in all."""
    gap = 1.6e-4
    r = run(tmp_path, [box(-0.5, 0.5, 0.0103, 1.0103), box(-0.4, 0.4, 1.0103 + gap, 1.8103 + gap)], [(0, -1), (0, -1)],
            ["&contact restitution=1 /"], on_floor=True)
    assert r.history.energy.kinetic[-1] > (1 - 1e-6) * r.history.energy.kinetic.max()
    assert (r.bodies.velocity[-1, 1:, 1] > 0).all()
    check_books(r)


@pytest.mark.parametrize("restitution", [0, 0.5, 1])
@pytest.mark.parametrize("gap", [0, 1e-10])
def test_a_square_that_is_thrown_where_it_is_bonded_stays(gap, restitution, tmp_path):
    """Its bond takes it all in the first steps. It was given any speed, up to 1e139, and friction took 7 times what there was."""
    r = run(tmp_path, [box(0, 1, gap, 1 + gap)], [(1, -1)], [f"&contact restitution={restitution} /"], steps=30, joint="0 5e6 5e6", on_floor=True)
    assert np.abs(r.bodies.velocity).max() < 1.5
    check_books(r)


@pytest.mark.parametrize("gap", [0, 1e-4])
@pytest.mark.parametrize("restitution", [0, 0.7, 1])
def test_a_column_of_two_that_falls_is_given_no_more_than_it_had(restitution, gap, tmp_path):
    """The upper square is pushed out with the lower one: it belongs to the impact, though nothing strikes it."""
    column = [box(0, 0.5, gap, 0.5 + gap), box(0, 0.5, 0.5 + 2 * gap, 1 + 2 * gap)]
    check_books(run(tmp_path, column, [(0, -1), (0, -1)], [f"&contact restitution={restitution} /"], steps=20, on_floor=True, young=1e8, weight=25000))


@pytest.mark.parametrize("restitution, gap, joint, dt", [(0, 1e-6, "0 5e6 5e6", 2e-4), (0.3, 1e-6, "0 5e6 5e6", 2e-4), (1, 1e-6, "0 5e6 5e6", 2e-4),
                                                         (0, 3e-4, "0 1e5 1e5", 6e-4), (0.3, 3e-4, "0 1e5 1e5", 6e-4)])
def test_a_column_of_two_takes_no_friction_where_there_is_none(gap, joint, dt, restitution, tmp_path):
    """It is stopped or bounces; with a gap of 1e-6 m its joints are bonded. The bonds bore friction though nothing slid."""
    column = [box(0, 0.5, gap, 0.5 + gap), box(0, 0.5, 0.5 + 2 * gap, 1 + 2 * gap)]
    r = run(tmp_path, column, [(0, -1), (0, -1)], [f"&contact restitution={restitution} /"], dt=dt, steps=12, joint=joint, on_floor=True, young=1e8)
    check_books(r)
    assert r.history.energy.kinetic[-1] < (1 + 1e-9) * 2 * DENSITY * 0.5**2 / 2


@pytest.mark.parametrize("restitution", [0, 0.3, 1])
def test_a_bond_that_fails_as_it_is_struck_stops_nothing_along(restitution, tmp_path):
    """It bears 50 N, of a square that comes with 312 N s in each direction: only the floor acts, across."""
    r = run(tmp_path, [box(0, 0.5, 0, 0.5)], [(1, -1)], [f"&contact restitution={restitution} /"], joint="0 100 200", on_floor=True, young=1e8, steps=20)
    assert r.bodies.velocity[-1, 1, :2] == pytest.approx([1, restitution], abs=0.02)
    check_books(r)


BOND = "0 1e7 1e7"


@pytest.mark.parametrize("gap", [0.0101, 0.0105, 0.0109])
@pytest.mark.parametrize("restitution", [0, 0.5, 1])
def test_bonded_squares_bounce_as_one(restitution, gap, tmp_path):
    """One on the other, at 1 onto a floor that they meet at any share of a step. With e = 1 they left at 0.013, 0.72 and 0.98, as the
    bond passed nothing of the impact on."""
    r = run(tmp_path, [box(0, 1, gap, 1 + gap), box(0, 1, 1 + gap, 2 + gap)], [(0, -1), (0, -1)], [f"&contact restitution={restitution} /"],
            steps=18, joint=BOND, on_floor=True)
    assert r.bodies.velocity[-1, 1:, 1] == pytest.approx(restitution, abs=1e-3)
    check_books(r)


@pytest.mark.parametrize("gap", [0.0101, 0.0105])
def test_a_square_that_strikes_two_that_are_bonded_gives_them_two_thirds(gap, tmp_path):
    """Bodies of mass 1 and 2, e = 1. The square kept 0.13 of its speed, and 0.66 of the energy was left."""
    row = [box(0, 1, 0, 1), box(1 + gap, 2 + gap, 0, 1), box(2 + gap, 3 + gap, 0, 1)]
    r = run(tmp_path, row, [(1, 0), (0, 0), (0, 0)], ["&contact restitution=1 /"], steps=18, joint=BOND)
    assert r.bodies.velocity[-1, :, 0] == pytest.approx([-1 / 3, 2 / 3, 2 / 3], abs=1e-3)
    check_books(r)


def tilted(angle, corners):
    return np.array(corners) @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) + (0, 1.3e-3)


@pytest.mark.parametrize("restitution", [0, 1])
@pytest.mark.parametrize("angle", [2e-5, 2e-4])
@pytest.mark.parametrize("parts", ["one", "corners", "bonded"])
def test_a_block_that_lands_nearly_flat_meets_the_floor_at_once(parts, angle, restitution, tmp_path):
    """With its two corners, with three more between them, and of four blocks in a bonded row. What is between was struck alone, between the
    ends, and with a restitution of 0 a tenth to a third of the energy was left, as a turn."""
    at = [0, 0.25, 0.5, 0.75, 1]
    blocks = {"one": [box(0, 1, 0, 0.25)], "corners": [[*[(x, 0) for x in at], (1, 0.25), (0, 0.25)]],
              "bonded": [box(a, b, 0, 0.25) for a, b in zip(at, at[1:])]}[parts]
    r = run(tmp_path, [tilted(angle, block) for block in blocks], [(0, -1)] * len(blocks), [f"&contact restitution={restitution} /"], steps=8,
            joint="0 1e9 1e9", on_floor=True, young=1e11)
    assert r.bodies.velocity[-1, 1:, 1] == pytest.approx(restitution, abs=0.01)
    check_books(r)


def test_what_a_bond_holds_in_one_place_turns_about_it(tmp_path):
    """A tower of which one corner has come loose from the floor, and turns about the other at 0.3 rad/s, is struck by a square at 2 m/s:
    about that corner they keep their angular momentum. Held as a rock it stopped the square dead, and turned on as it did."""
    tower, square = box(0, 0.5, 0, 2), box(-0.53, -0.03, 1.2, 1.7)
    (tmp_path / "a.blk").write_text(block_file("hinge", [(1, FLOOR), (2, tower), (3, square)], [
        (x, y, 1) for x in (-3.96, 3.96) for y in (-0.995, -0.005)]))
    rock = f"{DENSITY} 0 1e9 .25{' 0' * 6}"
    (tmp_path / "a.ana").write_text("\n".join([
        "1 60 3 1 .05 .001", f"{rock} 0 0 0", f"{rock} 0.3 0.075 -0.3", f"{rock} 2 0 0", "0 1e6 1e5", "&deck geometry='a.blk', dialect='short' /",
        "&method strain='green' /", "&contact restitution=0 /", "&output every=1 /", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    tower, square = r.bodies.velocity[-1, 1:, 0]  # of their centres, 1 and 1.45 m above it
    inertia, mass = DENSITY * (0.5**2 + 2**2) / 3, DENSITY * 0.5**2
    assert inertia * tower + mass * 1.45 * square == pytest.approx(inertia * 0.3 + mass * 1.45 * 2, rel=0.01)
    assert tower == pytest.approx(0.59, abs=0.02)
    check_books(r)


@pytest.mark.parametrize("restitution", [0, 0.5, 1])
@pytest.mark.parametrize("wide, high", [(1, 60), (4, 15)])
def test_a_pile_that_falls_leaves_as_one(wide, high, restitution, tmp_path):
    """Of squares that touch, too stiff for a wave within a step, at 1 onto a floor. With e = 1 a column of 40 kept a tenth of its energy, as
    sweeps for its impulses were given up too soon."""
    pile = [box(0.02 * i, 0.02 * i + 0.02, 0.02 * k + 5e-4, 0.02 * k + 0.02 + 5e-4) for i in range(wide) for k in range(high)]
    r = run(tmp_path, pile, [(0, -1)] * wide * high, [f"&contact restitution={restitution} /"], steps=3, on_floor=True, young=1e12)
    assert r.bodies.velocity[-1, 1:, 1] == pytest.approx(restitution, abs=1e-4)
    check_books(r)


@pytest.mark.parametrize("restitution", [0, 0.5, 1])
@pytest.mark.parametrize("angle", [0, 10, 36])
def test_meshes_that_fall_as_one_pile_stop_or_leave_as_one(angle, restitution, tmp_path):
    """Three squares, flush, whose joints have many nodes: how these share in an impact is not known, and forces of those that had none of it were taken for
    loads. 18 of 20 such piles were thrown aside, by up to 39 % of their speed."""
    pile = [box(1 + x, 2 + x, y, y + 1) for x, y in ((0, 0.01), (0.13, 1.01), (0.05, 2.01))]
    r = run(tmp_path, pile, [(0, 0)] * 3, [f"&contact restitution={restitution} /", "&support both=-4 -1 4 -1 /",
                                           f"&cover edge=0.537, origin=0.1 0.2, angle={angle} /"],
            on_floor=True, joint="30 0 0", young=4e10, weight=25000, model="nmm", steps=50)
    np.testing.assert_allclose(r.bodies.velocity[45, 1:, 1], np.sqrt(2 * 10 * 0.01) * restitution, atol=1e-4)
    assert np.abs(r.bodies.velocity[..., 0]).max() < 0.01
    check_books(r)


@pytest.mark.parametrize("light", [1, 0.03, 1e-3])
def test_a_heavy_block_on_a_light_one_stops_with_it(light, tmp_path):
    """Both fall as one, e = 0. What the heavy one presses the floor with was held against the mass of the light one: they were thrown up by 0.14 of
    their speed in the step after (here by 0.1)."""
    (tmp_path / "a.blk").write_text(block_file("heavy", [(1, FLOOR), (2, box(-0.5, 0.5, 0.0001, 0.5001)), (3, box(-0.5, 0.5, 0.5001, 1.0001))],
                                               [(x, y, 1) for x in (-3.96, 3.96) for y in (-0.995, -0.005)]))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 20 3 1 .05 2e-4", *(f"{rho} 0 1e12 .25{' 0' * 7} {vy} 0" for rho, vy in ((2500, 0), (2500 * light, -1), (2500, -1))), "0 0 0",
        "&deck geometry='a.blk', dialect='short' /", "&contact restitution=0 /", "&output every=1 /", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert np.abs(r.bodies.velocity[-1]).max() < 1e-3


SHORT = [2e-4, 5e-5]  # s; a wave passes a square of 1 m in 5e-4


@pytest.mark.parametrize("dt", SHORT)
@pytest.mark.parametrize("strain", ["green", "small"])
@pytest.mark.parametrize("restitution", [0, 0.5, 1])
@pytest.mark.parametrize("count", [2, 5, 120])
def test_a_pile_that_falls_as_one_in_short_steps_leaves_as_one(count, restitution, strain, dt, tmp_path):
    """Of five squares that fell as one 1 to 8 % of the energy was left with e = 0, 61 to 94 % with e = 1: the far side of each goes towards the
    impact at first, so what lies there had no part in it. The uppermost of 120 takes less than 1 % of the impulse, and belongs to it as well."""
    pile = [box(-0.5, 0.5, 2.35 * dt + k, 2.35 * dt + k + 1) for k in range(count)]
    r = run(tmp_path, pile, [(0, -1)] * count, [f"&contact restitution={restitution} /"], dt=dt, steps=10, on_floor=True, young=1e10, strain=strain)
    np.testing.assert_allclose(r.bodies.velocity[-1, 1:, 1], restitution, atol=1e-6)
    check_books(r)


@pytest.mark.parametrize("dt", SHORT)
@pytest.mark.parametrize("restitution", [0, 0.5, 1])
@pytest.mark.parametrize("upright", [False, True])
def test_a_row_that_is_struck_in_short_steps_goes_on_as_one(upright, restitution, dt, tmp_path):
    """Five squares that touch, by a sixth at 1: they had 0.007 to 0.33 of its speed with e = 0.5."""
    row = [box(-1 - 2.35 * dt, -2.35 * dt, 0, 1)] + [box(k, k + 1, 0, 1) for k in range(5)]
    if upright:
        row = [[(-y, x) for x, y in block] for block in row]
    speeds = [(0, 1) if upright else (1, 0)] + [(0, 0)] * 5
    r = run(tmp_path, row, speeds, [f"&contact restitution={restitution} /"], dt=dt, steps=10, young=1e10)
    expected = [1 / 6 - restitution * 5 / 6] + [(1 + restitution) / 6] * 5
    np.testing.assert_allclose(r.bodies.velocity[-1, :, 1 if upright else 0], expected, atol=1e-6)
    check_books(r)


@pytest.mark.parametrize("dt", SHORT)
@pytest.mark.parametrize("restitution", [0, 0.5, 1])
def test_a_column_that_is_struck_from_above_in_short_steps_stays(restitution, dt, tmp_path):
    """The square that comes leaves at e, and the floor takes it all: with e = 1 it left at 0.65 and 0.75, and the column sprang up."""
    column = [box(-0.5, 0.5, k, k + 1) for k in range(5)] + [box(-0.5, 0.5, 5 + 2.35 * dt, 6 + 2.35 * dt)]
    r = run(tmp_path, column, [(0, 0)] * 5 + [(0, -1)], [f"&contact restitution={restitution} /"], dt=dt, steps=10, on_floor=True, young=1e10)
    np.testing.assert_allclose(r.bodies.velocity[-1, 1:, 1], [0] * 5 + [restitution], atol=1e-6)
    check_books(r)


def test_what_is_apart_is_struck_when_it_is_met(tmp_path):
    """Two squares that fall, half the way of a step apart: with e = 0 the first stops where it meets the floor, late in a step, and the second
    goes on until the next."""
    dt = 2e-4
    pile = [box(-0.5, 0.5, 1.8 * dt, 1.8 * dt + 1), box(-0.5, 0.5, 2.3 * dt + 1, 2.3 * dt + 2)]
    r = run(tmp_path, pile, [(0, -1)] * 2, ["&contact restitution=0 /"], dt=dt, steps=6, on_floor=True, young=1e10)
    assert r.bodies.velocity[2, 1:, 1] == pytest.approx([0, -1], abs=1e-6)
    assert r.bodies.velocity[4, 1:, 1] == pytest.approx([0, 0], abs=1e-6)
    check_books(r)
