"""Lines that hold the edges of blocks, in one direction or in both."""
import math

import numpy as np
import pytest

import scree
from scree import block_files, call


def run(folder, blocks, material, groups, carried=0, steps=40, dt=0.1, fixed=()):
    (folder / "g.blk").write_text(block_files.block_file("held", [(1, corners) for corners in blocks], fixed))
    (folder / "g.ana").write_text(f"{carried}\n{steps}\n1 1\n0.05\n{dt}\n{material}\n20 0 0\n&deck geometry='g.blk', dialect='short' /\n{groups}\n")
    return scree.run(folder / "g.ana")


METHODS = ("model='dda', strain='small'", "model='nmm', strain='small' / &cover edge=0.6", "model='nmm', strain='green' / &cover edge=0.6",
           "model='nmm' / &cover edge=0.6 / &fixed_points method='penalty'")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("angle", (0.0, 0.5))
@pytest.mark.parametrize("size", (1e-3, 1.0, 1e3))
def test_a_block_between_walls_has_the_stress_of_confinement(size, angle, method, tmp_path):
    """Pressed by 3 from above between rollers, in plane strain: s = -3 nu/(1 - nu) aside; however it lies."""
    corners = block_files.turned(size * block_files.box(0, 2, 0, 1), angle)
    foot, right, top, left = (" ".join(f"{x:.17g}" for x in (*a, *b)) for a, b in zip(corners, np.roll(corners, -1, 0)))
    r = run(tmp_path, [corners], "1 0 1e6 0.25 0 0 0 0 0 0 0 0 0", f"&method plane='strain', {method.replace('0.6', str(0.6 * size))} / "
            f"&support normal={left} {foot} {right} / &boundary lines={top}, pressure=3 3 /", dt=size, steps=20)
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    full = turn @ np.diag([-1.0, -3.0]) @ turn.T
    expected = np.tile([full[0, 0], full[1, 1], full[0, 1]], (r.n_elements, 1))
    assert r.stress() == pytest.approx(expected, abs=2e-2 if "penalty" in method else 1e-4)  # strains are 3e-6
    start = r.vertices(0) @ np.array([c, s])
    aside = r.displacement() @ np.array([c, s])
    ends = (start < start.min() + 1e-9 * size) | (start > start.max() - 1e-9 * size)
    assert np.abs(aside[ends]).max() < (1e-8 if "penalty" in method else 1e-13) * size  # round-off


def test_a_clamped_edge_is_held_all_along(tmp_path):
    """The left edge of a meshed beam under its weight: no vertex on it moves, though fixed points would let it between them."""
    r = run(tmp_path, [block_files.box(0, 3, 0, 1)], "1 10 1e5 0.25 0 0 0 0 0 0 0 0 0",
            "&method model='nmm' / &cover edge=0.37, angle=10 / &support both=0 0 0 1 /", steps=20)
    start, moved = r.vertices(0), r.displacement()
    assert np.abs(moved[start[:, 0] < 1e-9]).max() < 1e-15
    assert moved[start[:, 0] > 2.99][:, 1].max() < -1e-3


@pytest.mark.parametrize("axis", ("x", "y"))
def test_a_roller_lets_a_block_go_along_it(axis, tmp_path):
    """A skew edge on rollers along one axis: the block falls freely or not at all, and goes aside under a push or not at all."""
    corners = np.array([(0, 0), (1, 0.2), (1.1, 1), (0.1, 0.9)])
    r = run(tmp_path, [corners], "2 20 1e9 0.25 0 0 0 0 0 0 3 0 0", f"&support {axis}=0 0 1 0.2 /", carried=1, steps=50, dt=0.01)
    moved = r.bodies.centroid[-1, 0] - r.bodies.centroid[0, 0]
    expected = (0.0, -0.5 * 10 * 0.25) if axis == "x" else (1.5, 0.0)
    assert moved == pytest.approx(expected, abs=1e-4)  # what it swings as its weight comes at once


def test_k0_stays_in_balance_with_its_sides_on_rollers(tmp_path):
    """Weight 20, K0 = 0.5 in a meshed rock of which neither side nor foot moves across: nothing happens, but for the mean of an element."""
    r = run(tmp_path, [block_files.box(0, 4, 0, 3)], "2 20 1e6 0.25 -30 -60 0 10 20 0 0 0 0",
            "&method model='nmm' / &cover edge=0.5 / &support normal=0 0 0 3  4 0 4 3  0 0 4 0 /", steps=20)
    height = np.array([polygon[:, 1].mean() for polygon in r.polygons(0)])
    assert r.stress()[:, 1] == pytest.approx(-20 * (3 - height), abs=0.05 * 60)
    assert np.abs(r.displacement()).max() < 0.02 * 20 * 3**2 / 2 / 1e6  # of the settlement without stress


@pytest.mark.parametrize("order, off", [(0, 1.6e-8), (0, 1e-7), (1, 1.6e-9), (1, 1.6e-8), (1, 1.2e-4), (1, 2.6e-4)])
def test_a_support_beside_a_node_of_the_mesh_holds_without_stress(order, off, tmp_path):
    """A bar under traction 100 between two rollers, from whose corner a node of the mesh, and sides along the edges, lie off by a little."""
    width = 1.5 * math.sqrt(3)
    r = run(tmp_path, [block_files.box(0, width, 0, 2)], "1 0 1e6 0.3 0 0 0 0 0 0 0 0 0",
            f"&method model='nmm', strain='small' / &cover edge=0.5, origin={off} {off}, angle=30, order={order} / "
            f"&support x=0 0 0 2, y=0 0 {width} 0 / &boundary lines={width} 0 {width} 2, traction=100 0 100 0 /", dt=1e5, steps=3)
    assert np.abs(r.stress() - [100, 0, 0]).max() < 0.02  # by the change of length, 1e-4, and the step 0.003
    start, moved = r.vertices(0), r.displacement()
    held = np.abs(start) < 1e-12
    assert np.abs(moved[held]).max() < 1e-9 * np.abs(moved).max()


BAD = {"&support normal=0 0 1 /": "four numbers", "&support x=0 0 0 0 /": "two ends of line 1",
       "&support both=0 0 1 0 0 0.5 1 0.5 /": "support.both, found none on line 2"}


@pytest.mark.parametrize("groups", BAD)
def test_lines_that_hold_nothing_are_refused(groups, tmp_path):
    (tmp_path / "g.blk").write_text(block_files.block_file("held", [(1, block_files.box(0, 1, 0, 1))]))
    (tmp_path / "g.ana").write_text(f"1\n5\n1 1\n0.05\n0.1\n1 0 1 0 0 0 0 0 0 0 0 0 0\n30 0 0\n&deck geometry='g.blk' /\n{groups}\n")
    done = call("check", tmp_path / "g.ana")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "g.ana:9: expected" in done.stderr
    assert BAD[groups] in done.stderr, done.stderr
