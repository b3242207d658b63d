"""Blocks that one fixed point holds, and fixed lines that make one fixed point: said by `check` and by a run."""
import pytest
import scree
from scree.block_files import block_file, box

ROCK = "2500 25000 1e10 0.2" + " 0" * 9


def analysis(folder, geometry, groups="", carried=1):
    (folder / "a.ana").write_text(f"{carried} 2 1 1 0.05 0.001\n{ROCK}\n30 0 0\n&deck geometry='{geometry}', dialect='short' /\n{groups}")
    return folder / "a.ana"


def warnings(deck, words):
    """Warnings with some words, which `check` and a run give alike; the latter keeps them in its results."""
    said = [line.removeprefix("warning: ") for line in scree.call("check", deck).stdout.splitlines() if line.startswith("warning: ")]
    done = scree.call("run", deck, "-o", deck.with_suffix(".h5"))
    assert all(line in done.stderr for line in said)
    return [line for line in said if words in line]


def blocks(folder, fixed, alone=False):
    """A floor, and unless it is alone a block on it; fixed points with their block."""
    outlines = [(1, box(-1, 2, -1, 0))] + [(1, box(0, 1, 0, 1))] * (not alone)
    (folder / "a.blk").write_text(block_file("held", outlines, fixed))


@pytest.mark.parametrize("fixed, block", [
    ([(0.5, -0.5, 1)], 1), ([(0.5, -0.5, 1), (0.5, -0.5, 1)], 1), ([(-0.9, -0.9, 1), (1.9, -0.9, 1), (0.5, 0.9, 2)], 2),
    ([(-0.9, -0.9, 1), (1.9, -0.9, 1)], 0), ([(-0.9, -0.9, 1), (1.9, -0.9, 1), (0.1, 0.9, 2), (0.9, 0.9, 2)], 0)])
def test_a_block_on_one_fixed_point_is_warned_of(fixed, block, tmp_path):
    """It can turn about the point; two points at one place hold no more."""
    blocks(tmp_path, fixed)
    found = warnings(analysis(tmp_path, "a.blk"), "about which the block can turn")
    assert len(found) == (block > 0)
    if block:
        x, y, _ = fixed[-1]
        assert f"found one fixed point, at ({x:g}, {y:g}) in block {block}" in found[0] and "add a second fixed point" in found[0]


@pytest.mark.parametrize("groups", ["&support both=-1 -1 2 -1 /\n", "&support normal=-1 -1 2 -1 /\n",
                                    "&bolts ends=1.5 -0.5 5 -0.5, stiffness=1e6, outside='ground' /\n"])
def test_what_else_is_held_is_not_warned_of(groups, tmp_path):
    blocks(tmp_path, [(-0.5, -0.5, 1)])
    assert warnings(analysis(tmp_path, "a.blk", groups), "about which the block can turn") == []


@pytest.mark.parametrize("carried, warned", [(0, 1), (1, 0)])
def test_a_pendulum_is_not_warned_of(carried, warned, tmp_path):
    """A block that touches nothing and hangs from a point swings in a dynamic run, and has no way to rest in a static one."""
    blocks(tmp_path, [(0.5, -0.1, 1)], alone=True)
    assert len(warnings(analysis(tmp_path, "a.blk", carried=carried), "about which the block can turn")) == warned


SQUARE = "1e-3\n4 4 0 0 1 0 0 0\n0 0 1 0 1\n1 0 1 1 1\n1 1 0 1 1\n0 1 0 0 1\n{}\n"


@pytest.mark.parametrize("line, words", [
    ("0.5 0.5 1.5 0.5", "crosses one edge and makes one fixed point, at (0.9974, 0.5) in block 1"),
    ("0.2 0.5 0.8 0.5", "crosses no edge and makes one fixed point, at (0.2, 0.5) in block 1"),
    ("-0.5 0.5 1.5 0.5", ""), ("0.5 0.5 0.5 0.5", ""), ("0.5 -0.1 1.1 0.5", "")])
def test_a_fixed_line_that_makes_one_point_is_warned_of(line, words, tmp_path):
    """A fixed point each crossing with an edge of a block: a line that ends inside makes one. A line of no length is a point."""
    (tmp_path / "a.geo").write_text(SQUARE.format(line))
    found = warnings(analysis(tmp_path, "a.geo"), "makes one fixed point")
    assert len(found) == bool(words)
    if words:
        assert "a.geo:7: expected a fixed line that crosses edges of a block twice, found one that " + words in found[0]
        assert "draw the line across the whole block" in found[0]
