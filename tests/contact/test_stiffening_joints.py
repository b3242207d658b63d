"""Joints that stiffen as they close, by the hyperbola of Bandis et al. 1983: what rests on one, and what bounces on it."""
import math

import numpy as np
import pytest

import scree
from scree import block_files

WEIGHT, KN, MOST = 4.0, 1e3, 2e-3  # closes by 2/3 of the most under the weight
METHODS = ("&method strain='small' /", "&method strain='green' /", "&method model='nmm' /")


def closure(force, kn=KN):
    """Of a joint of length 1 under a force."""
    return force * MOST / (kn * MOST + force)


def scene(folder, groups, joints=f"kn={KN}, ks={KN}, closure={MOST}", size=1.0, carried=0, steps=100, dt=0.01, young=1e8):
    """A block of 1 by 0.2, density 2, unit weight 20, on a base, in units in which its weight is that above."""
    base, block = block_files.box(-1, 4, -1, 0) * size, block_files.box(0, 1, 0, 0.2) * size
    (folder / "b.blk").write_text(block_files.block_file("b", [(1, base), (2, block)], block_files.held(base, 1)))
    rest = f"{young * size} 0 0 0 0 0 0 0 0 0 0"
    (folder / "b.ana").write_text(f"{carried}\n{steps}\n2 1\n0.05\n{dt * size**0.5}\n2 0 {rest}\n2 20 {rest}\n30 0 0\n"
                                  f"&deck geometry='b.blk', dialect='short' /\n&joints {joints} /\n{groups}\n")
    return scree.run(folder / "b.ana")


def sunk(r, frame=-1):
    return r.bodies.centroid[0, 1, 1] - r.bodies.centroid[frame, 1, 1]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", (1e-3, 1.0, 1e3))
def test_a_block_settles_loaded_and_unloaded(method, size, tmp_path):
    """Under its weight, twenty times that, and its weight again: the curve has no memory."""
    top = f"&boundary lines=0 {0.2 * size} {size} {0.2 * size}, pressure={19 * WEIGHT * size} {19 * WEIGHT * size} /"
    joints = f"kn={KN}, ks={KN}, closure={MOST * size}"
    r = scene(tmp_path, f"{method}\n&step balance=1e-9 /\n&stage name='more' /\n{top}\n&stage name='less' /\n"
              f"&boundary lines=0 {0.2 * size} {size} {0.2 * size}, pressure=0 0 /", joints, size, young=1e11)
    ends = [np.searchsorted(r.times, r.history.time[r.history.stage == stage][-1]) for stage in (1, 2, 3)]
    for frame, force in zip(ends, (WEIGHT, 20 * WEIGHT, WEIGHT)):
        assert sunk(r, frame) / size == pytest.approx(closure(force), rel=2e-7)


def lowest(weight):
    """Where a block that a joint bears at once turns: its fall is the energy of the curve."""
    low, high = 0.0, MOST
    for _ in range(200):
        u = 0.5 * (low + high)
        low, high = (u, high) if weight * u > KN * MOST**2 * (-math.log(1 - u / MOST) - u / MOST) else (low, u)
    return low


@pytest.mark.parametrize("method", METHODS)
def test_a_bouncing_block_keeps_its_energy_to_second_order(method, tmp_path):
    """Its weight comes at once; by the midpoint rule nothing is lost but by the step, and it turns where its fall is the energy."""
    lost = []
    for dt in (4e-4, 2e-4):
        r = scene(tmp_path, f"{method}\n&integrator scheme='newmark', gamma=0.5, beta=0.5 /\n&output every=1 /", carried=1, dt=dt,
                  steps=round(0.08 / dt))
        lost.append(abs(r.history.energy.dissipated).max())
    assert max(sunk(r, frame) for frame in range(len(r.times))) == pytest.approx(lowest(WEIGHT), rel=1e-3)
    assert lost[1] < 0.01 * WEIGHT * MOST and lost[1] < 0.4 * lost[0]


def test_a_joint_that_stiffens_dilates(tmp_path):
    """A push under a bolt: it rises by s tan psi less what the joint closes."""
    stiffness, push, kn = 50.0, 2.6, 1e4
    friction, dilation = math.tan(math.radians(30)), math.tan(math.radians(10))
    up = (push / friction - WEIGHT) / stiffness
    r = scene(tmp_path, f"&step balance=1e-8 /\n&bolts ends=0.5 0.1 0.5 -1e5, stiffness={stiffness}, outside='ground' /\n&stage name='push' /\n"
              f"&boundary lines=0 0 0 0.2, pressure=0 0, traction={push / 0.2} 0 {push / 0.2} 0 /",
              f"kn={kn}, ks={kn}, closure={MOST}, dilation=10, dilation_slip=1", steps=200)
    along, rose = r.bodies.centroid[-1, 1] - r.bodies.centroid[0, 1]
    assert rose == pytest.approx(up, rel=1e-4)
    assert along == pytest.approx((up + closure(push / friction, kn)) / dilation + push / kn, rel=5e-4)


def test_a_joint_that_never_closes_far_is_linear(tmp_path):
    linear = sunk(scene(tmp_path, "&step balance=1e-9 /", f"kn={KN}, ks={KN}"))
    assert sunk(scene(tmp_path, "&step balance=1e-9 /", f"kn={KN}, ks={KN}, closure=1e6")) == pytest.approx(linear, rel=1e-8)
    same = sunk(scene(tmp_path, "&step balance=1e-9 /", f"kn={KN}, ks={KN}, closure=0"))
    assert same == linear


@pytest.mark.parametrize("joints, groups, said", [
    (f"closure={MOST}", "", "joints.kn"),
    (f"kn=0, closure={MOST}", "", "only where joints.kn is"),
    (f"kn=1e3, closure={MOST} {MOST}", "", "1 numbers, one for each joint material"),
    (f"kn=1e3, closure={MOST}", "&contact method='augmented' /", "contact.method='penalty'"),
    (f"kn=1e3, closure={MOST}", "&method strain='green' /\n&integrator scheme='energy_momentum' /\n&contact rules='conserving' /",
     "contact.rules='coulomb'")])
def test_what_cannot_be_is_refused_in_a_line(joints, groups, said, tmp_path):
    with pytest.raises(scree.RunFailed) as failed:
        scene(tmp_path, groups, joints)
    assert failed.value.status == 2 and said in failed.value.said and len(failed.value.said.strip().splitlines()) == 1
