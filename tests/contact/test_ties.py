"""Pairs of a vertex and an edge that are as good for a contact: which of them it has is told by the scene, not by the numbers of its
blocks and vertices, nor by its axes."""
import itertools

import numpy as np
import pytest
import scree
from scree.block_files import block_file

#: Wedges of rock that meet in one place, cut from a square of 4 m.
ROCK = [[(4.0, 0.0), (3.9999999999999996, 1.3886280133531137), (2.68874673086652, 1.0349187960054786)],
        [(4.0, 4.0), (2.0940853204625585, 2.826601651590837), (3.9999999999999996, 1.3886280133531137)],
        [(0.0, 0.309632137655117), (2.274569769187592, 0.923194987640306), (2.0940853204625585, 2.826601651590837),
         (2.220446049250313e-16, 2.826601651590837)],
        [(3.286155368361938, 0.0), (2.68874673086652, 1.0349187960054786), (2.274569769187592, 0.923194987640306),
         (2.362108780984551, 0.0)]]
#: A wedge on another like it.
WEDGES = [[(0, 0), (2, 1), (0, 1)], [(0, 1), (2, 1), (0, 2)]]


def moved(folder, blocks, order, starts, mirrored, steps, E, dt, state):
    """How far the corners of blocks get, whose order in the file, and that of the corners of each, is another, or in a mirror."""
    side = np.array([-1 if mirrored else 1, 1])
    corners = [np.roll(np.array(blocks[b], float) * side, -start, axis=0)[::side[0]] for b, start in zip(order, starts)]
    (folder / "a.blk").write_text(block_file("ties", [(1, x) for x in corners]))
    (folder / "a.ana").write_text("\n".join([
        f"1 {steps} 1 1 0.05 {dt}", f"2500 0 {E} 0.25", *state, "0 0 0", "&deck geometry='a.blk', dialect='short', gaps='allow' /",
        "&method strain='small' /", "&acceleration table=0 0 10 100 0 10 /", "&support both=0 0 4 0 /" if len(blocks) > 2 else "", ""]))
    r = scree.run(folder / "a.ana", output=folder / "a.h5")
    assert r.history.contacts[-1, 1:].sum() > 0
    way = [None] * len(blocks)
    for b, start, now, at_first in zip(order, starts, r.polygons(-1), r.polygons(0)):
        way[b] = np.roll(((now - at_first) * side)[::side[0]], start, axis=0)
    return np.concatenate(way)


@pytest.mark.parametrize("order", itertools.permutations(range(4)), ids=str)
def test_order_of_blocks_and_corners(order, tmp_path):
    """Where four wedges came together it was told by the numbers of their vertices which of two was over an edge of the other."""
    case = (1, 1e9, 5e-3, ["0 0 0", "0 0 0", "0.6 -0.35 0.14"])
    way = moved(tmp_path, ROCK, range(4), [0] * 4, False, *case)
    other = moved(tmp_path, ROCK, order, [b % 3 for b in order], False, *case)
    assert np.abs(other - way).max() < 1e-10 * np.abs(way).max()


def test_mirror(tmp_path):
    """At both ends of the joint between two wedges that are stressed either has a corner: which of them acts took turns in a mirror."""
    case = (2, 1e8, 1e-3, ["-25404 -60414 0", "0 0 0", "0 0 0"])
    way, other = (moved(tmp_path, WEDGES, range(2), [0, 0], mirrored, *case) for mirrored in (False, True))
    assert np.abs(other - way).max() < 1e-10 * np.abs(way).max()
