"""Blocks without a free unknown: others touch them, they have no equations, and stay where they are."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

G = 10.0
MODES = {"dda": "", "green": "&method strain='green' /", "nmm": "&method model='nmm' /",
         "nmm green": "&method model='nmm', strain='green' /"}
LAWS = {"springs": "", "plastic": "&contact restitution=0 /", "bouncing": "&contact restitution=0.5 /",
        "multipliers": "&contact method='augmented', stiffness=1e9, overlap=1e-5 /", "viscous": "&contact viscosity=1e4 /"}


def run(folder, blocks, held, groups="", steps=100, dt=0.002, density=2500.0, way=None, size=1.0):
    """Runs blocks of which some are held at all corners; they follow `way`, rows of t x y. Returns the finished process."""
    fixed = [(*x, b) for b in held for x in blocks[b - 1]]
    (folder / "held.blk").write_text(block_file("held", [(2 if b + 1 in held else 1, x) for b, x in enumerate(blocks)], fixed,
                                                measured=[(*blocks[-1].mean(0), len(blocks))]))
    table = [] if way is None else [f"{len(way)} " * len(fixed)] + ["  ".join(" ".join(map(str, row)) for row in way)] * len(fixed)
    numbers = [f"{rho} {rho * G} {1e9 * size} 0.25 {'0 ' * 9}" for rho in (density, 2500.0)]
    (folder / "held.ana").write_text("\n".join([
        "1", str(steps), "2 1", f"0.05 {dt}", *(["0"] if table else []), *table, *numbers, "30 0 0",
        f"&deck geometry='held.blk', dialect='{'shi' if table else 'short'}' /", "&output every=1 /", groups, ""]))
    return scree.call("run", folder / "held.ana", "-o", folder / "held.h5", "--quiet")


def floor_and_wall(size=1.0):
    return [box(-2, 2, -1, 0) * size, box(2, 3, -1, 3) * size, box(-3, -2, -1, 3) * size]


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("mode", MODES)
def test_held_blocks_that_touch_each_other_alone_stay_to_the_bit(mode, law, tmp_path):
    blocks = floor_and_wall()
    done = run(tmp_path, blocks, [1, 2, 3], f"{MODES[mode]}\n{LAWS[law]}", steps=20)
    assert done.returncode == 0, done.stderr
    f = scree.read(tmp_path / "held.h5")
    assert not f.history.contacts.any() # nothing of what they would have between them could move
    assert (f.bodies.centroid == f.bodies.centroid[0]).all() and not f.bodies.stress.any()
    assert not f.history.momentum.any() and not f.history.energy.kinetic.any()


@pytest.mark.parametrize("depth", [0.0, 1e-3])
def test_held_blocks_that_overlap_carry_one_that_overlaps_one_of_them(depth, tmp_path):
    blocks = [box(-2, 2, -1, 0), box(1, 5, -0.01, 1), box(-0.5, 0.5, -depth, 1 - depth)]
    done = run(tmp_path, blocks, [1, 2])
    assert done.returncode == 0, done.stderr
    f = scree.read(tmp_path / "held.h5")
    assert (f.bodies.centroid[:, :2] == f.bodies.centroid[0, :2]).all()
    assert np.abs(f.bodies.centroid[:, 2] - f.bodies.centroid[0, 2]).max() < 2e-5  # its springs give by 2.5e-6, itself by 6e-6
    assert f.history.overlap[-1] == pytest.approx(depth, abs=1e-5)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("law", ["bouncing", "plastic"])
@pytest.mark.parametrize("mode", MODES)
def test_a_block_falls_and_bounces_between_held_blocks_that_touch(mode, law, size, tmp_path):
    """From 0.05 of its size: as Galileo says until it touches; then to a quarter of the height, or not at all, but for what a
    step of the fall leaves of the velocity of the impact, 1 %."""
    dt, steps, drop = 4e-4 * size**0.5, 450, 0.05 * size
    blocks = [*floor_and_wall(size), box(-0.5, 0.5, 0.05, 1.05) * size]
    done = run(tmp_path, blocks, [1, 2, 3], f"{MODES[mode]}\n{LAWS[law]}\n&integrator start='consistent' /", steps, dt, size=size)
    assert done.returncode == 0, done.stderr
    f = scree.read(tmp_path / "held.h5")
    t, height = f.history.time, drop + f.measured_points.displacement[:, 0, 1]
    falls = t < (2 * drop / G)**0.5 - 2 * dt
    np.testing.assert_allclose(height[falls], drop - G * t[falls]**2 / 2, rtol=0, atol=1e-9 * size)
    apex = height[np.argmin(height[t < 0.12 * size**0.5]):].max()
    assert apex == pytest.approx(drop * {"bouncing": 0.25, "plastic": 0}[law], abs=0.02 * drop)
    still = f.bodies.centroid[:, :3]
    assert (still == still[0]).all()


@pytest.mark.parametrize("mode", MODES)
def test_held_blocks_go_where_their_tables_say(mode, tmp_path):
    """Two that touch move together: rigidly, and what they lean on each other stays nothing."""
    way = [(0, 0, 0), (0.1, 0.3, 0.1), (1, 0.3, 0.1)]
    done = run(tmp_path, floor_and_wall(), [1, 2, 3], MODES[mode], 100, way=way)
    assert done.returncode == 0, done.stderr
    f = scree.read(tmp_path / "held.h5")
    moved = f.bodies.centroid[1:] - f.bodies.centroid[0]
    t = np.minimum(f.history.time, 0.1)[:, None]
    for b in range(3):
        np.testing.assert_allclose(moved[:, b], t * [3.0, 1.0], rtol=0, atol=1e-13)
    # places to 3 have roundings of 4e-16, which a hundred steps add up, times E
    np.testing.assert_allclose(f.bodies.stress, 0, atol=1e-4)


@pytest.mark.parametrize("mode", MODES)
def test_a_block_without_mass_that_nothing_holds_is_still_an_error(mode, tmp_path):
    done = run(tmp_path, [*floor_and_wall(), box(-0.5, 0.5, 0.5, 1.5)], [1, 2, 3], MODES[mode], density=0.0)
    assert done.returncode == 1 and "singular" in done.stderr
