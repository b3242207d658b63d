"""Joints whose strength depends on the stress across them, in direct shear: a flat plate under pressure, pushed along a base."""
import math

import numpy as np
import pytest

import scree
from scree import block_files

LENGTH, HEIGHT = 1.0, 0.04


def shear(folder, push, joints, phi=30, cohesion=0, stress=100.0, size=1.0, groups="&step balance=1e-5 /", carried=0, steps=200, dt=0.01,
          method=""):
    """The plate under a stress across, and a stress along that pushes at one end. Units of E follow the stress, mass 2 a unit of area."""
    base, block = block_files.box(-1, 4, -1, 0) * size, block_files.box(0, LENGTH, 0, HEIGHT) * size
    (folder / "shear.blk").write_text(block_files.block_file("shear", [(1, base), (2, block)], block_files.held(base, 1)))
    top, left = f"0 {HEIGHT * size} {LENGTH * size} {HEIGHT * size}", f"0 0 0 {HEIGHT * size}"
    rock = f"2 0 {1e5 * stress} 0 0 0 0 0 0 0 0 0 0"
    along = push * LENGTH / HEIGHT
    (folder / "shear.ana").write_text(
        f"{carried}\n{steps}\n2 1\n0.05\n{dt}\n{rock}\n{rock}\n{phi} {cohesion} 0\n&deck geometry='shear.blk', dialect='short' /\n"
        f"&joints {joints} /\n&boundary lines={top} {left}, pressure={stress} {stress} 0 0, traction=0 0 0 0 {along} 0 {along} 0 /\n"
        f"{groups}\n{method}\n")
    return scree.run(folder / "shear.ana")


def verdict(r):
    return {"complete": "holds", "moves": "slides"}[r.scene.status.split(":")[0]]


def barton(stress, jrc, jcs, phi):
    """Barton & Choubey 1977, no steeper than 70 degrees."""
    return stress * math.tan(math.radians(min(70.0, phi + jrc * math.log10(jcs / stress))))


@pytest.mark.parametrize("method", ("&method strain='small' /", "&method strain='green' /", "&method model='nmm' /"))
@pytest.mark.parametrize("stress", (10.0, 100.0, 1000.0))
def test_a_rough_joint_bears_what_barton_says(stress, method, tmp_path):
    """JRC 10, JCS 10 MPa, phi 30: 60, 50, 40 degrees; one percent on both sides."""
    limit = barton(stress, 10, 1e4, 30)
    assert limit / stress == pytest.approx(math.tan(math.radians({10.0: 60, 100.0: 50, 1000.0: 40}[stress])))
    for share, expected in ((0.99, "holds"), (1.01, "slides")):
        r = shear(tmp_path, share * limit, "jrc=10, jcs=1e4", stress=stress, method=method)
        assert verdict(r) == expected, (share, r.scene.status)


@pytest.mark.parametrize("size", (1e-3, 1e3))
def test_size_does_not_matter_to_a_rough_joint(size, tmp_path):
    limit = barton(100.0, 10, 1e4, 30)
    found = [verdict(shear(tmp_path, share * limit, "jrc=10, jcs=1e4", size=size, dt=0.01 * size)) for share in (0.99, 1.01)]
    assert found == ["holds", "slides"]


def test_little_stress_makes_no_joint_steeper_than_70_degrees(tmp_path):
    limit = math.tan(math.radians(70))
    found = [verdict(shear(tmp_path, share * limit, "jrc=20, jcs=1e4", stress=1.0)) for share in (0.99, 1.01)]
    assert found == ["holds", "slides"] and barton(1.0, 20, 1e4, 30) == pytest.approx(limit)


def test_walls_weaker_than_the_stress_are_smooth(tmp_path):
    limit = 100 * math.tan(math.radians(30))
    found = [verdict(shear(tmp_path, share * limit, "jrc=20, jcs=50")) for share in (0.99, 1.01)]
    assert found == ["holds", "slides"]


@pytest.mark.parametrize("dt", [1e-3, 1e-2, 1.0, 100.0])
@pytest.mark.parametrize("joints, cohesion, limit", [("jrc=10, jcs=5e7", 0, barton(24525, 10, 5e7, 25)),
                                                     ("residual_c=2e4", 0, 24525 * math.tan(math.radians(25)) + 2e4)])
@pytest.mark.parametrize("method", ["", "&contact method='augmented' /"])
def test_weight_and_shear_that_come_together(joints, cohesion, limit, dt, method, tmp_path):
    """A square that a bolt pulls on beside its joint, pushed by 0.95 and 1.05 of what that bears. Where all comes in the first step, a
    joint went by the stress before it, none: the bolt bore up to 51 966 and 59 755 of 74 843 and 82 721."""
    base, block = block_files.box(-5, 5, -1, 0), block_files.box(-1, 1, 0, 1)
    (tmp_path / "b.blk").write_text(block_files.block_file("b", [(1, base), (2, block)], block_files.held(base, 1), [(0, 0.02, 2)]))
    at_rest = "0 0 0 0 0 0 0 0 0"
    bolt = {}
    for share in (0.95, 1.05):
        (tmp_path / "b.ana").write_text(
            f"0 300 2 1 0.05 {dt}\n2500 0 1e10 0.2 {at_rest}\n2500 24525 1e10 0.2 {at_rest}\n25 {cohesion} 0\n"
            f"&deck geometry='b.blk', dialect='short' /\n&step balance=1e-4 /\n&joints {joints} /\n{method}\n"
            f"&loads force={share * 2 * limit} 0 /\n&bolts ends=-6 .02 0 .02, stiffness=1e8, outside='ground' /\n")
        r = scree.run(tmp_path / "b.ana")
        assert r.scene.status == "complete"
        bolt[share] = abs(r.bolts.force[-1, 0])
    assert bolt[0.95] < 1e-2 * limit and bolt[1.05] == pytest.approx(0.1 * limit, rel=0.05)


def way(r):
    return r.bodies.centroid[-1, 1, 0] - r.bodies.centroid[0, 1, 0]


def test_what_a_broken_bond_leaves(tmp_path):
    """phi 30, cohesion 50 and 20 then, stress 100: at 105 it holds; at 110 it breaks, and slides with 110 - 77.7 over its mass."""
    residual = 100 * math.tan(math.radians(30)) + 20
    assert verdict(shear(tmp_path, 105, "residual_c=20", cohesion=50)) == "holds"
    r = shear(tmp_path, 115, "residual_c=20", cohesion=50, carried=1, dt=0.0002, groups="")
    end = r.times[-1]
    assert way(r) == pytest.approx(0.5 * (115 - residual) / (2 * HEIGHT) * end**2, rel=0.01)


def test_roughness_wears_off(tmp_path):
    """From 50 to 30 degrees over 5 cm, shaken ever more when the pressure has come to rest: s'' = a(t) - tau(s)/m, integrated."""
    mass, slip, push, rise, end, rest = 2 * HEIGHT, 0.05, 140.0, 0.02, 0.045, 0.01
    s = v = tau = 0.0
    for t in np.linspace(0, end, 20000, endpoint=False):
        turn = tau * HEIGHT / 2 / LENGTH  # more on the front, less on the rear: friction acts below the middle
        tau = sum(barton(2 * half, 10 * max(0.0, 1 - s / slip), 1e4, 30) / 2 for half in (50 - turn, 50 + turn))
        v = max(0.0, v + (push * min(1.0, t / rise) - tau) / mass * end / 20000)
        s += v * end / 20000
    shaken = f"&acceleration table={rest} 0 0 {rest + rise} {-push / mass} 0 1 {-push / mass} 0 /"
    r = shear(tmp_path, 0, "jrc=10, jcs=1e4, residual_phi=30, residual_slip=0.05", carried=1, steps=1100, dt=(end + rest) / 1100, groups=shaken)
    assert s > 3 * slip and way(r) == pytest.approx(s, rel=0.01)
    assert (np.diff(r.history.energy.friction) > -1e-9).all()
