"""Joints that open as they slide: blocks that ride up, under their weight, under a spring, and between two walls."""
import math

import numpy as np
import pytest

import scree
from scree import block_files

PHI, PSI = math.tan(math.radians(30)), math.tan(math.radians(10))
G, WEIGHT = 10.0, 4.0  # of the block of 1 by 0.2: density 2, unit weight 20
METHODS = ("&method strain='small' /", "&method strain='green' /", "&method model='nmm' /")


def scene(folder, joints, groups="", size=1.0, carried=1, steps=100, dt=2e-3, young=1e7, height=0.2, roof=False, weight=20, stress=0):
    """The block on a long base, or between that and a roof, all in units in which the weight is that above."""
    base, block = block_files.box(-1, 4, -1, 0) * size, block_files.box(0, 1, 0, height) * size
    above = [(1, block_files.box(-1, 4, height, 1.2) * size)] if roof else []
    held = block_files.held(base, 1) + (block_files.held(above[0][1], 3) if roof else [])
    (folder / "b.blk").write_text(block_files.block_file("b", [(1, base), (2, block), *above], held))
    rest = f"{young * size} 0 0 {stress} 0 0 0 0 0 0 0"
    (folder / "b.ana").write_text(f"{carried}\n{steps}\n2 1\n0.05\n{dt * size**0.5}\n2 0 {rest}\n2 {weight} {rest}\n30 0 0\n"
                                  f"&deck geometry='b.blk', dialect='short' /\n&joints {joints} /\n{groups}\n")
    return scree.run(folder / "b.ana")


def shaken(size, *times_and_accelerations):
    """What pushes the block, as ground that gets away under it."""
    rows = " ".join(f"{t * size**0.5} {-a} 0" for t, a in times_and_accelerations)
    return f"&acceleration table={rows} /"


def ways(r, size=1.0):
    """How far the block has gone along and up, in each frame."""
    return ((r.bodies.centroid[:, 1] - r.bodies.centroid[0, 1]) / size).T


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("size", (1e-3, 1.0, 1e3))
def test_a_pushed_block_rides_up(method, size, tmp_path):
    """m x'' = H - N tan phi and m x'' tan psi = N - W. What friction takes is N (tan phi - tan psi) over the way: the rest lifts."""
    push, end = 8.0, 0.2
    exact = (push - G * PHI) / (1 + PHI * PSI)
    r = scene(tmp_path, f"dilation=10, dilation_slip={size}", method + "\n" + shaken(size, (0, push), (1, push)), size=size)
    along, up = ways(r, size)
    assert along[-1] == pytest.approx(0.5 * exact * end**2, rel=1e-4)
    assert up[-1] == pytest.approx(along[-1] * PSI, rel=1e-4)
    pressing = WEIGHT * (1 + PSI * exact / G)
    assert r.history.energy.friction[-1] / size**3 == pytest.approx(pressing * along[-1] * (PHI - PSI), rel=1e-4)


def test_half_the_step_halves_the_error(tmp_path):
    """Stiff springs leave the error of the first step, in which the weight comes on."""
    exact = 0.5 * (8 - G * PHI) / (1 + PHI * PSI) * 0.2**2
    off = [ways(scene(tmp_path, "dilation=10, dilation_slip=1", shaken(1, (0, 8), (1, 8)), dt=dt, steps=round(0.2 / dt), young=1e9))[0][-1]
           / exact - 1 for dt in (4e-3, 2e-3)]
    assert abs(off[1]) < 1e-4 and abs(off[1]) < 0.6 * abs(off[0])


@pytest.mark.parametrize("method", METHODS)
def test_it_opens_where_the_slip_is_larger_than_before_and_up_to_its_end(method, tmp_path):
    """Pushed forth, back past where it began, and on: it rises where it is farther from there than ever, up to the end."""
    pushes = (0, 8), (0.1, 8), (0.1001, -8), (0.6, -8)
    r = scene(tmp_path, "dilation=10, dilation_slip=0.015", method + "\n" + shaken(1, *pushes), steps=300)
    along, up = ways(r)
    there = along.argmax()
    past = there + np.argmax(along[there:] < -along[there])
    assert 0.008 < along[there] < 0.012 and along[-1] < -0.06
    assert up[:past] == pytest.approx(PSI * np.maximum.accumulate(along)[:past], abs=1e-5)
    assert up[-1] == pytest.approx(PSI * 0.015, rel=1e-3)
    assert (np.diff(r.history.energy.friction) > -1e-9).all()


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("dt", (0.01, 1.0))
def test_a_spring_across_holds_what_slides(method, dt, tmp_path):
    """A bolt of stiffness K holds the block down: it slides until (W + K v) tan phi bears the push, v = s tan psi - N/kn."""
    stiffness, push, kn = 50.0, 2.6, 1e4
    pressing = push / PHI
    up_then = (pressing - WEIGHT) / stiffness
    r = scene(tmp_path, f"dilation=10, dilation_slip=1, kn={kn}, ks={kn}", carried=0, dt=dt, steps=200, young=1e8,
              groups=f"{method}\n&step balance=1e-7 /\n&bolts ends=0.5 0.1 0.5 -1e5, stiffness={stiffness}, outside='ground' /\n"
                     f"&stage name='push' /\n&boundary lines=0 0 0 0.2, pressure=0 0, traction={push / 0.2} 0 {push / 0.2} 0 /")
    along, up = ways(r)
    assert up[-1] == pytest.approx(up_then, rel=2e-5)
    tilt = 2 * push * 0.2 / kn * (1 + PHI * PSI)
    assert along[-1] == pytest.approx((up_then + pressing / kn) / PSI + push / kn + tilt * 0.1, rel=2e-5)


@pytest.mark.parametrize("size", (1e-3, 1.0, 1e3))
def test_a_block_between_walls_jams(size, tmp_path):
    """Its stress presses it against base and roof, and both joints open: N = N0 + 2 a tan psi/(2/kn + h/E), a = s - N tan phi/ks."""
    push, kn, young, height, stress = 40.0, 1e4, 1e6, 0.2, 4e3
    pressing, at_first = push / PHI / 2, stress / (1 + 2 * young / (kn * height))
    exact = (pressing - at_first) * (2 / kn + height / young) / (2 * PSI) + pressing * PHI / kn
    push_it = f"traction={push / height * size} 0 {push / height * size} 0"
    r = scene(tmp_path, f"dilation=10, dilation_slip={size}, kn={kn}, ks={kn}", carried=0, size=size, dt=0.01, young=young, roof=True,
              weight=0, stress=-stress * size, steps=200,
              groups=f"&step balance=1e-7 /\n&stage name='push' /\n&boundary lines=0 0 0 {height * size}, pressure=0 0, {push_it} /")
    along, up = ways(r, size)
    assert along[-1] == pytest.approx(exact, rel=1e-3) and abs(up[-1]) < 1e-4 * along[-1]


def test_a_joint_that_has_opened_goes_on_after_a_restart(tmp_path):
    given = "dilation=10, dilation_slip=0.05", "&method strain='green' /\n" + shaken(1, (0, 9), (0.1, 9), (0.1001, -12), (1, -12))
    whole = scene(tmp_path, *given, steps=200)
    path = tmp_path / "half.h5"
    assert scree.call("run", tmp_path / "b.ana", "-o", path, "--quiet", "--set", "step.count=90").returncode == 0
    assert scree.call("run", "--restart", path, "--quiet", "--set", "step.count=200").returncode == 0
    assert scree.read(path).vertices(-1).tobytes() == whole.vertices(-1).tobytes()


@pytest.mark.parametrize("joints, groups, said", [
    ("dilation=31, dilation_slip=1", "", "b.ana:10: expected joints.dilation with no angle above that of friction"),
    ("dilation=21, dilation_slip=1, residual_phi=20, residual_slip=1", "", "20 of material 1"),
    ("dilation=10, dilation_slip=0", "", "a slip above 0"),
    ("dilation=10", "", "joints.dilation_slip"),
    ("dilation_slip=1", "", "joints.dilation"),
    ("dilation=10 10, dilation_slip=1", "", "1 numbers, one for each joint material"),
    ("dilation=10, dilation_slip=1", "&contact method='augmented' /", "contact.method='penalty'"),
    ("dilation=10, dilation_slip=1", "&contact restitution=0.5 /", "without contact.restitution"),
    ("dilation=10, dilation_slip=1", "&method preset='shi' /\n&contact rules='shi' /", "contact.rules='coulomb'"),
    ("dilation=10, dilation_slip=1", "&method strain='green' /\n&integrator scheme='energy_momentum' /\n&contact rules='conserving' /",
     "contact.rules='coulomb'")])
def test_what_cannot_be_is_refused_in_a_line(joints, groups, said, tmp_path):
    with pytest.raises(scree.RunFailed) as failed:
        scene(tmp_path, joints, groups)
    assert failed.value.status == 2 and said in failed.value.said and len(failed.value.said.strip().splitlines()) == 1
