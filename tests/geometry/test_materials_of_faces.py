"""Blocks that lie on each other keep the joint materials of their own edges under a mesh, whichever is first in the file."""
import random

import numpy as np
import pytest
import scree
from scree.block_files import block_file, box


def wall(rnd):
    """Courses of blocks that lie flush, their edges divided at random, each piece with a material from 1 to 4, in any order."""
    blocks = []
    for course in range(3):
        ends = [0.0, *sorted(rnd.sample([0.5, 0.8, 1.0, 1.4, 1.5, 1.7], rnd.randint(1, 3))), 2.0]
        for left, right in zip(ends, ends[1:]):
            corners = []
            for start, end in zip(box(left, right, course, course + 1), np.roll(box(left, right, course, course + 1), -1, axis=0)):
                shares = [0.0, *sorted(rnd.sample([0.25, 0.4, 0.5, 0.75], rnd.randint(0, 2)))]
                corners += [start + s * (end - start) for s in shares]
            blocks.append((1, np.array(corners), [rnd.randint(1, 4) for _ in corners]))
    rnd.shuffle(blocks)
    return blocks


def material_at(block, place):
    """Material of the edge of a block that a place lies on; 0 inside."""
    _, corners, materials = block
    for start, end, material in zip(corners, np.roll(corners, -1, axis=0), materials):
        along = end - start
        share = np.dot(place - start, along) / np.dot(along, along)
        if 0 < share < 1 and np.linalg.norm(start + share * along - place) < 1e-9:
            return material
    return 0


@pytest.mark.parametrize("seed", range(20))
def test_each_block_has_its_own_materials(seed, tmp_path):
    """A face had the material of the first block's in the file, on both sides: a block lost all of its friction so."""
    rnd = random.Random(seed)
    blocks = wall(rnd)
    cover = rnd.choice(["edge=0.5", "edge=0.5, origin=0.1 0.2, angle=20", f"edge={rnd.uniform(0.3, 3)}, origin=0.123 0.0771"])
    (tmp_path / "a.blk").write_text(block_file("wall", blocks))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 1 1 4 0.05 0.001", "2500 25000 1e9 0.25" + " 0" * 9, *["30 0 0"] * 4,
        f"&deck geometry='a.blk', dialect='short' /\n&method model='nmm' /\n&cover {cover} /", ""]))
    done = scree.call("cut", tmp_path / "a.ana", "-o", tmp_path / "a.h5")
    assert done.returncode == 0, done.stderr
    f = scree.read(tmp_path / "a.h5")
    joints = np.split(f["elements/joint"], f["VTKHDF/Offsets"][1:-1])
    seen = 0
    for block, corners, joint in zip(f["VTKHDF/CellData/block"], f.polygons(0), joints):
        for start, end, own in zip(corners, np.roll(corners, -1, axis=0), joint):
            assert own == material_at(blocks[block - 1], start + 0.3719 * (end - start))
            seen += own > 0
    assert seen >= sum(len(b[2]) for b in blocks)


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("weak", [1, 2])
@pytest.mark.parametrize("edge", [0.2, 0.673, 2.9])
def test_a_meshed_block_slides_by_the_weaker_of_two_faces(edge, weak, order, tmp_path):
    """A block of material 2 on ground of material 1, either first in the file, one of them with phi 35 and the other with 50:
    v = 1 - g t tan 35."""
    ground, block = (1, box(-3, 6, -1, 0), [1] * 4), (2, box(0.1327, 1.3327, 0, 0.5), [2] * 4)
    number = 1 if order == 1 else 2
    fixed = [(-2.9, -0.9, number), (5.9, -0.9, number), (1.0, -0.1, number)]
    (tmp_path / "a.blk").write_text(block_file("slide", [ground, block][::order], fixed))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 20 2 2 0.05 0.001", "2500 0 1e9 0" + " 0" * 9, "2500 24525 1e9 0 0 0 0 0 0 0 1 0 0",
        *["35 0 0", "50 0 0"][::1 if weak == 1 else -1],
        f"&deck geometry='a.blk', dialect='short' /\n&method model='nmm' /\n&cover edge={edge}, origin=0.123 0.0771 /", ""]))
    f = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert f.bodies.velocity[-1, 2 - number, 0] == pytest.approx(1 - 9.81 * 0.02 * np.tan(np.radians(35)), abs=2e-3)
