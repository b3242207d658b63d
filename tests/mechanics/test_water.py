"""Water below a table: what it presses on edges, by numbers summed up along them, and what swims."""
import math
import os
import pathlib
import re

import numpy as np
import pytest

import scree
from scree import block_files, call
from scree.validation import references

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])


def run(folder, blocks, material, groups, steps=50, dt=0.01, fixed=()):
    (folder / "g.blk").write_text(block_files.block_file("wet", [(1, corners) for corners in blocks], fixed))
    (folder / "g.ana").write_text(f"1\n{steps}\n1 1\n0.05\n{dt}\n{material}\n30 0 0\n&deck geometry='g.blk', dialect='short' /\n{groups}\n")
    return scree.run(folder / "g.ana")


def pressed(corners, table, weight, parts=5000):
    """Force and torque about the origin of water on a polygon, by the rule of the middle."""
    x, y = np.array(table).T
    force, torque = np.zeros(2), 0.0
    for a, b in zip(corners, np.roll(corners, -1, 0)):
        t = ((np.arange(parts) + 0.5) / parts)[:, None]
        at, along = a + t * (b - a), b - a
        p = weight * np.maximum(np.interp(at[:, 0], x, y) - at[:, 1], 0.0) / parts
        own = -p[:, None] * np.array([along[1], -along[0]])
        force += own.sum(0)
        torque += (at[:, 0] * own[:, 1] - at[:, 1] * own[:, 0]).sum()
    return np.append(force, torque)


TABLES = {"level": [(0, 0.3)], "slope": [(-2, 1.5), (2, -0.8)], "steps": [(-0.7, 0.9), (-0.2, 0.1), (0.15, 0.2), (0.6, -0.5)],
          "deep": [(-1, 40), (1, 30)]}
METHODS = ("model='dda'", "model='nmm' / &cover edge=0.4", "strain='small'")


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", (1e-3, 1.0, 1e3))
def test_water_presses_with_its_depth(size, method, name, tmp_path):
    """Momentum after one short step is the force, and the torque, of the water on a turned quadrangle."""
    corners = block_files.turned(np.array([(-1, -0.6), (1, -0.5), (0.9, 0.5), (-1.1, 0.6)]), 0.4) * size
    table, dt = [(size * x, size * y) for x, y in TABLES[name]], 1e-6 * size
    r = run(tmp_path, [corners], "2 0 1e6 0.25 0 0 0 0 0 0 0 0 0", f"&method {method.replace('0.4', str(0.4 * size))} / "
            f"&water table={' '.join(f'{x} {y}' for x, y in table)}, unit_weight=10 /", steps=1, dt=dt)
    expected = pressed(corners, table, 10.0)
    scale = np.array([1, 1, size]) * np.abs(expected[:2]).max()
    assert r.history.momentum[0] / dt / scale == pytest.approx(expected / scale, abs=1e-6)


def test_what_is_as_heavy_as_the_water_that_it_displaces_swims(tmp_path):
    """A box of half the density, half of it below a table."""
    r = run(tmp_path, [block_files.box(0, 2, -0.5, 0.5)], "1 10 1e8 0.25 0 0 0 0 0 0 0 0 0", "&water table=0 0, unit_weight=20 /")
    fall = 5 * r.times[-1] ** 2
    assert np.abs(r.displacement()).max() < 1e-5 * fall


def test_water_in_a_joint_lifts_what_lies_on_it(tmp_path):
    """A box on a held one, water to its top: it stays where it weighs more than the water it displaces, and rises where less."""
    for weight, rises in ((11, False), (9, True)):
        r = run(tmp_path, [block_files.box(-1, 2, -1, 0), block_files.box(0, 1, 0, 1)], f"1 {weight} 1e8 0.25 0 0 0 0 0 0 0 0 0",
                "&water table=0 1, unit_weight=10 / &output every=1 /", fixed=block_files.held(block_files.box(-1, 2, -1, 0), 1))
        moved = r.bodies.centroid[-1, 1, 1] - r.bodies.centroid[0, 1, 1]
        # pressure stays that of where an edge began
        assert moved == pytest.approx(0.5 * 1.0 * r.times[-1] ** 2 if rises else 0.0, abs=1e-3)


def test_the_wet_slopes_are_those_of_hoek_and_bray():
    """FS 1.1461, 0.9844, 0.7916 with 0, 7, 14 m of water, and the decks of m11 have the strength over 0.99 and 1.01 of that."""
    degree = math.pi / 180
    slope = (60, 50 * degree, 35 * degree, 14, 25, 35 * degree, 26)
    assert [references.plane_failure(*slope, water) for water in (0, 7, 14)] == pytest.approx([1.1461, 0.9844, 0.7916], abs=5e-5)
    for water in (7, 14):
        for name, share in (("stands", 0.99), ("falls", 1.01)):
            deck = (SOURCE / f"input/validation/m11-wet-slope/water{water}-{name}.ana").read_text()
            phi, c = map(float, re.search(r"^(\S+) (\S+) 0 ! plane", deck, re.M).groups())
            over = share * references.plane_failure(*slope, water)
            assert (math.tan(phi * degree), c) == pytest.approx((math.tan(35 * degree) / over, 25 / over), rel=1e-9)


BAD = {"&water table=0 0 1, unit_weight=10 /": "two numbers x y", "&water table=0 0 0 1, unit_weight=10 /": "x ascending",
       "&water table=0 -1, unit_weight=10 /": "edges of blocks below", "&water table=0 1 /": "water.unit_weight",
       "&water unit_weight=10 /": "water.table"}


@pytest.mark.parametrize("groups", BAD)
def test_water_that_is_none_is_refused(groups, tmp_path):
    (tmp_path / "g.blk").write_text(block_files.block_file("dry", [(1, block_files.box(0, 1, 0, 1))]))
    (tmp_path / "g.ana").write_text(f"1\n5\n1 1\n0.05\n0.1\n1 0 1 0 0 0 0 0 0 0 0 0 0\n30 0 0\n&deck geometry='g.blk' /\n{groups}\n")
    done = call("check", tmp_path / "g.ana")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "g.ana:9: expected" in done.stderr
    assert BAD[groups] in done.stderr, done.stderr
