"""What is found inside brings no spring of elsewhere: nodes of meshes that meet face to face, corners that come to other joints."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box, turned


def gain(folder, blocks, materials, groups, dt, steps, phi=0):
    """Most that a step brings to the energy, over what the scene is given; the first block is held."""
    low, high = blocks[0].min(axis=0), blocks[0].max(axis=0)
    fixed = [(x, y, 1) for x in (low[0] + 0.06, high[0] - 0.06) for y in (low[1] + 0.005, high[1] - 0.005)]
    (folder / "a.blk").write_text(block_file("meet", [(k + 1, x) for k, x in enumerate(blocks)], fixed))
    (folder / "a.ana").write_text("\n".join([
        f"1 {steps} {len(blocks)} 1 0.05 {dt}", *materials, f"{phi} 0 0", "&deck geometry='a.blk', dialect='short' /", *groups, ""]))
    r = scree.run(folder / "a.ana", output=folder / "a.h5")
    return -np.diff(r.history.energy.dissipated - r.history.energy.friction, prepend=0).min() / r.history.energy.kinetic.max()


@pytest.mark.parametrize("gap, edge", [
    (1e-4, 0.6), (1e-4, 1.149), (1e-5, 0.3), (1e-5, 1.149), (1e-6, 1.149), (1e-7, 1.149), (1e-9, 0.3), (1e-9, 1.149), (0, 0.37)])
def test_a_block_that_falls_flat_on_another_gains_nothing(gap, edge, tmp_path):
    """The rows of nodes at y = 0 are cut just below the lower side of what falls, so it has edges there as short as the gap. A node
    found inside brought the spring of another, that went on, once more, or both ends of such an edge did: up to 0.09 of all energy in a
    step."""
    E, v = 51641019.46, -0.4282474344293716
    blocks = [box(-6, 6, -1, 0), box(0.6208441521437718, 1.467287608477784, gap, 0.5379755270859258)]
    materials = [f"2500 0 {E} 0.25 {'0 ' * 9}", f"2500 0 {E} 0.25 {'0 ' * 6} 0 {v} 0"]
    groups = ["&method strain='auto', model='nmm' /", f"&cover edge={edge} /"]
    assert gain(tmp_path, blocks, materials, groups, 2.772e-4, 12) < 1e-9


def squares_on_a_tip(folder, angle, groups, dt=2.9e-3, time=0.0986):
    """Four squares on a tip that fall apart: most that a step brings to the energy."""
    squares = [turned(box(x, x + 0.5, y, y + 0.5), angle) for y in (0, 0.5) for x in (0, 0.5)]
    lowest = min(x[:, 1].min() for x in squares)
    blocks = [box(-4, 6, -1, 0)] + [x - (0, lowest) for x in squares]
    materials = [f"2500 25000 1.8e9 0.25 {'0 ' * 9}"] * len(blocks)
    return gain(folder, blocks, materials, groups, dt, round(time / dt))


@pytest.mark.parametrize("stiffness", [1e8, 1e9, 1e10])
@pytest.mark.parametrize("angle", [-0.7713, -0.6, -0.5])
def test_corners_that_come_to_a_joint_gain_nothing(angle, stiffness, tmp_path):
    """One that comes to the joint of two others was pressed there as the tip is on the floor."""
    assert squares_on_a_tip(tmp_path, angle, [f"&contact stiffness={stiffness} /"]) < 1e-9


@pytest.mark.parametrize("kn", [1e9, 1e10])
@pytest.mark.parametrize("angle", [-0.7713, -0.6, -0.5])
def test_nor_more_by_joints_that_slide_than_a_force_along_them(angle, kn, tmp_path):
    """With a stiffness of joints that made up to 2e-4 of all energy in a step. Springs that slide onto more length win what a force along
    the joint, which is left out, would lose: kn u^2/2 times the way."""
    assert squares_on_a_tip(tmp_path, angle, [f"&joints kn={kn} /"]) < 1e-5
    assert squares_on_a_tip(tmp_path, angle, [f"&joints kn={kn} /"], dt=2.9e-4) < 3e-5


def test_what_is_far_away_and_heavy_changes_nothing(tmp_path):
    """How far corners of flush blocks may be apart went by the spring that was pressed most in the scene: four squares on a tip went
    otherwise, by 2e-2 of their way, with a block of 40 m on their floor."""
    ways = []
    for far in ([], [box(70, 110, 0, 40)]):
        squares = [turned(box(x, x + 0.5, y, y + 0.5), -0.6) for y in (0, 0.5) for x in (0, 0.5)]
        lowest = min(x[:, 1].min() for x in squares)
        blocks = [box(-4, 120, -1, 0)] + [x - (0, lowest) for x in squares] + far
        fixed = [(x, y, 1) for x in (-3.94, 119.94) for y in (-0.995, -0.005)]
        (tmp_path / "a.blk").write_text(block_file("far", [(1, x) for x in blocks], fixed))
        (tmp_path / "a.ana").write_text("1 20 1 1 0.05 0.0029\n2500 25000 1.8e9 0.25 0 0 0 0 0 0 0 0 0\n0 0 0\n"
                                        "&deck geometry='a.blk', dialect='short' /\n")
        places = scree.run(tmp_path / "a.ana", output=tmp_path / f"{len(far)}.h5").bodies.centroid[:, 1:5]
        ways.append(places[-1] - places[0])
    assert np.abs(ways[1] - ways[0]).max() < 1e-9 * np.abs(ways[0]).max()
