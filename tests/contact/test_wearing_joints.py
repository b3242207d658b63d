"""Joints whose friction falls as they slide: a block on a plane of 30 degrees, with a peak of 35 and a residual angle of 20 degrees."""
import math
import os
import pathlib

import numpy as np
import pytest
import scree
from scree.block_files import block_file

SLOPE = pathlib.Path(os.environ["SCREE_SOURCE"]) / "input/validation/b1-slide/slope30.blk"
G, THETA = 9.81, math.radians(30)
PEAK, RESIDUAL, SLIP = math.tan(math.radians(35)), math.tan(math.radians(20)), 0.05


def slid(folder, speed, end, *settings, step=1e-3, scale=1.0):
    """The run of the block that begins with a speed down the plane, and how far it has slid, as if the scene was not scaled."""
    time = math.sqrt(scale)
    velocity = (speed * time * math.cos(THETA), -speed * time * math.sin(THETA))
    rows = SLOPE.read_text().splitlines()
    for i in [*range(5, 10), *range(13, 18), *range(21, 25), 25]:  # vertices, then fixed and measured points
        words = rows[i].split()
        at = 0 if i >= 21 else 1
        rows[i] = " ".join([*words[:at], *(str(float(word) * scale) for word in words[at:at + 2]), *words[at + 2:]])
    (folder / "slope.blk").write_text("\n".join(rows) + "\n")
    deck = folder / "wear.ana"
    deck.write_text(f"1 {round(end / step)} 2 1 0.05 {step * time}\n"
                    f"2500 0 {1e10 * scale} 0.25  0 0 0  0 0 0  0 0 0\n"
                    f"2500 24525 {1e10 * scale} 0.25  0 0 0  0 0 0  {velocity[0]} {velocity[1]} 0\n"
                    "35 0 0\n&deck geometry='slope.blk', dialect='short' /\n"
                    f"&joints residual_phi=20, residual_slip={SLIP * scale} /\n")
    run = scree.run(deck, output=folder / "wear.h5", settings=settings)
    return run, np.linalg.norm(run.measured_points.displacement[-1, 0]) / scale


def exact(speed, end, g=G, slip=SLIP):
    """How far it slides in closed form: by an exponential until the joint is worn, evenly faster from there."""
    peak, residual = (g * (math.sin(THETA) - math.cos(THETA) * friction) for friction in (PEAK, RESIDUAL))  # accelerations
    rate = math.sqrt((residual - peak) / slip)  # s'' = peak + rate^2 s until s is the slip
    if speed < -peak / rate:
        return (-peak - math.sqrt(peak**2 - (rate * speed) ** 2)) / rate**2  # it stops
    def way(t):
        return peak / rate**2 * (math.cosh(rate * t) - 1) + speed / rate * math.sinh(rate * t)
    worn = root_of(lambda t: way(t) - slip, 0.0, 10.0)
    faster = peak / rate * math.sinh(rate * worn) + speed * math.cosh(rate * worn)
    return slip + faster * (end - worn) + 0.5 * residual * (end - worn) ** 2


def root_of(f, low, high):
    """Where a function that rises is 0."""
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if f(middle) < 0 else (low, middle)
    return low


@pytest.mark.parametrize("settings", [["method.strain=small"], ["method.strain=green"], ["contact.rules=conserving"],
                                      ["contact.method=augmented"], ["contact.restitution=0.3"]])
@pytest.mark.parametrize("speed", [0.1, 0.3])
def test_a_block_wears_its_joint(tmp_path, settings, speed):
    """The slower one stops, the faster one wears the joint down and slides away. Friction is that of the start of a step: order 1."""
    off = [slid(tmp_path, speed, 0.6, *settings, step=step)[1] / exact(speed, 0.6) - 1 for step in (2e-3, 1e-3)]
    assert abs(off[1]) < 3e-3
    assert off[0] / off[1] == pytest.approx(2, rel=0.05)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_size_does_not_matter(tmp_path, scale):
    assert slid(tmp_path, 0.3, 0.6, scale=scale)[1] == pytest.approx(slid(tmp_path, 0.3, 0.6)[1], rel=1e-9)


def test_friction_takes_what_the_fall_does_not_leave(tmp_path):
    """The books: the work against the peak over the slip that wears, and that of the residual angle from there on."""
    run, way = slid(tmp_path, 0.3, 0.6)
    pressing = 24525 * 0.5 * math.cos(THETA)
    lost = pressing * (0.5 * (PEAK + RESIDUAL) * SLIP + RESIDUAL * (way - SLIP))
    assert run.history.energy.friction[-1] == pytest.approx(lost, rel=5e-3)


def test_a_joint_that_does_not_wear_is_as_one_without(tmp_path):
    plain = slid(tmp_path, 0.3, 0.3)[0].vertices(-1)
    same = slid(tmp_path, 0.3, 0.3, "joints.residual_phi=35")[0].vertices(-1)
    stays = slid(tmp_path, 0.3, 0.3, "joints.residual_slip=0")[0].vertices(-1)
    assert same.tobytes() == stays.tobytes() != plain.tobytes()


def test_wear_goes_on_after_a_restart(tmp_path):
    whole = slid(tmp_path, 0.3, 0.6)[0].vertices(-1).tobytes()
    run, _ = slid(tmp_path, 0.3, 0.6, "step.count=100")
    path = tmp_path / "wear.h5"
    assert scree.call("run", "--restart", path, "--quiet", "--set", "step.count=600").returncode == 0
    assert scree.read(path).vertices(-1).tobytes() == whole


@pytest.mark.parametrize("settings, said", [
    (["joints.residual_phi=20 20"], "1 numbers, one for each joint material"),
    (["joints.residual_phi=90"], "at most 89"),
    (["contact.rules=shi", "method.preset=shi"], "joints.residual_phi")])
def test_what_cannot_be_is_refused_in_a_line(tmp_path, settings, said):
    with pytest.raises(scree.RunFailed) as failed:
        slid(tmp_path, 0.1, 0.1, *settings)
    assert failed.value.status == 2 and said in failed.value.said and len(failed.value.said.strip().splitlines()) == 1


@pytest.mark.parametrize("meshed", [False, True])
@pytest.mark.parametrize("part", [0.1, 0.25])
def test_divided_faces_wear_as_whole_ones(part, meshed, tmp_path):
    """From vertex to vertex, and node to node of a mesh, others take over, which began as new: the finer the mesh, the more was forgotten, up to
    all but half of the way and a quarter of the speed."""
    c, s = math.cos(THETA), math.sin(THETA)
    turned = np.array([[c, -s], [s, c]])
    n, m = (1, 1) if meshed else (round(5 / part), round(1 / part))
    slope = np.array([[4, -1], *((4 - 5 * i / n, 0) for i in range(n)), [-1, 0], [-1, -1]]) @ turned
    block = np.array([*((i / m, 0) for i in range(m)), [1, 0], [1, 0.25], [0, 0.25]]) @ turned
    fixed = [(*(0.95 * x + 0.05 * slope.mean(0)), 1) for x in (slope[0], slope[1], slope[-2], slope[-1])]
    (tmp_path / "a.blk").write_text(block_file("wears", [(1, slope), (2, block)], fixed, measured=[(*block.mean(0), 2)]))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 600 2 1 0.05 0.002", f"2500 0 1e10 0.2 {'0 ' * 9}", f"2500 25000 1e10 0.2 {'0 ' * 6}{1.2 * c} {-1.2 * s} 0", "35 0 0",
        "&deck geometry='a.blk', dialect='short' /", "&joints residual_phi=20, residual_slip=0.3 /",
        f"&method model='nmm' /\n&cover edge={part} /" if meshed else "", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert np.linalg.norm(r.measured_points.displacement[-1, 0]) == pytest.approx(exact(1.2, 1.2, g=10, slip=0.3), rel=4e-3)
