"""Weight that grows on a ramp: closed forms of a fall, and a start without a shock."""
import math

import numpy as np
import pytest

import scree
from scree import block_files

G, RAMP = 10.0, 0.4


def run(folder, blocks, groups, fixed=(), steps=200, dt=0.005, young=1e8, settings=()):
    (folder / "g.blk").write_text(block_files.block_file("growing", [(1, corners) for corners in blocks], fixed))
    (folder / "g.ana").write_text(f"1\n{steps}\n1 1\n0.05\n{dt}\n2 20 {young} 0.25 0 0 0 0 0 0 0 0 0\n20 0 0\n"
                                  f"&deck geometry='g.blk', dialect='short' /\n{groups}\n")
    return scree.run(folder / "g.ana", settings=settings)


@pytest.mark.parametrize("scheme", ("newmark", "energy_decaying", "energy_momentum", "generalized_alpha", "bathe", "central_difference"))
@pytest.mark.parametrize("height", (0.0, 1e4))
def test_a_block_falls_as_its_weight_grows(height, scheme, tmp_path):
    """v = g t^2/2T, then g (t - T/2); y by its integral; the books of energy balance, wherever y = 0 is."""
    groups = f"&gravity ramp={RAMP} / &integrator scheme='{scheme}' / &output every=1 /"
    r = run(tmp_path, [block_files.box(0, 1, height, height + 1)], groups, steps=100, dt=0.01, young=1e5)
    t, late = r.times, np.maximum(r.times - RAMP, 0)
    early = np.minimum(t, RAMP)
    speed = G * (early**2 / (2 * RAMP) + late)
    fall = G * (early**3 / (6 * RAMP) + RAMP * late / 2 + late**2 / 2)
    assert -r.bodies.velocity[:, 0, 1] == pytest.approx(speed, abs=0.02 * G * RAMP)
    assert r.bodies.centroid[0, 0, 1] - r.bodies.centroid[:, 0, 1] == pytest.approx(fall, abs=2e-2)
    energy = r.history.energy
    assert np.abs(energy.dissipated).max() < 2e-2 * energy.kinetic.max()
    if height > 0:
        assert energy.work[-1] == pytest.approx(2 * G * height, rel=1e-3)  # what lifts the weight to its height


def test_a_ramp_keeps_the_shock_away(tmp_path):
    """A block on a floor, with soft springs: it overshoots to nearly twice the overlap of its weight without a ramp, not with one."""
    floor, block = block_files.box(-2, 3, -1, 0), block_files.box(0, 1, 0, 1)
    over = {}
    for ramp in (0.0, 2.0):
        groups = f"&gravity ramp={ramp} / &contact stiffness=1e4 / &integrator scheme='energy_momentum', beta=0.5, start='zero' /"
        r = run(tmp_path, [floor, block], groups, block_files.held(floor, 1), steps=1500, dt=0.002)
        over[ramp] = r.history.overlap.max() / (20 / 2e4)
    assert 1.8 < over[0.0] < 2.0  # springs that balance at the end of a step take some
    assert over[2.0] == pytest.approx(1.0, abs=0.05)


def test_what_sleeps_wakes_as_weight_grows(tmp_path):
    """On a slope of 30 degrees a block with phi 20 slides from the start of the ramp; whatever sleeps, it goes as if none did."""
    angle = math.radians(-30)
    slope = block_files.turned(block_files.box(-5, 20, -1, 0), angle)
    block = block_files.turned(block_files.box(-1, 0, 0, 0.5), angle)
    ways = []
    for sleep in ("0", "1e-3"):
        r = run(tmp_path, [slope, block], "&gravity ramp=1 /", block_files.held(slope, 1), settings=[f"step.sleep={sleep}"])
        ways.append(np.linalg.norm(r.bodies.centroid[-1, 1] - r.bodies.centroid[0, 1]))
    exact = G * (math.sin(-angle) - math.tan(math.radians(20)) * math.cos(angle)) / 6
    assert ways[0] == pytest.approx(exact, rel=2e-2) and ways[1] == pytest.approx(ways[0], rel=1e-6)


@pytest.mark.parametrize("e", (0.0, 0.5, 1.0))
@pytest.mark.parametrize("method", ("", "&method model='nmm' /", "&method strain='green' /"))
def test_a_block_bounces_while_its_weight_grows(method, e, tmp_path):
    """It falls by h = g t^3/6T; what e^2 of its speed there takes it up to is by the same equations, and no step makes energy."""
    height, ramp, dt = 0.3, 1.0, 0.002
    floor, block = block_files.box(-2, 3, -1, 0), block_files.box(0, 1, height, 1 + height)
    r = run(tmp_path, [floor, block], f"&gravity ramp={ramp} / &contact restitution={e} / &output every=1 /{method}",
            block_files.held(floor, 1), steps=400, dt=dt, young=1e9)
    at = (6 * height * ramp / G) ** (1 / 3)
    speed = G * at**2 / (2 * ramp)
    after = np.searchsorted(r.times, at + 2.5 * dt)
    left = e * speed - G / (2 * ramp) * (r.times[after] ** 2 - at**2)
    assert r.bodies.velocity[after, 1, 1] == pytest.approx(left, abs=0.03 * speed)
    energy = r.history.energy
    assert np.diff(energy.dissipated).min() > -1e-6 * energy.kinetic.max()
    if e == 0:
        assert r.bodies.centroid[-1, 1, 1] == pytest.approx(0.5, abs=1e-6)


def test_what_rests_bears_its_growing_weight_with_restitution(tmp_path):
    """Three blocks on each other: the floor bears what is there, and nothing hops."""
    blocks = [block_files.box(-2, 3, -1, 0), *(block_files.box(0, 1, i, i + 1) for i in range(3))]
    r = run(tmp_path, blocks, "&gravity ramp=0.5 / &contact restitution=0.5 / &output every=1 /", block_files.held(blocks[0], 1), young=1e7)
    share = np.minimum(r.history.time / 0.5, 1)
    overlap = share * 60 / (2 * 5e7)
    assert r.history.overlap == pytest.approx(overlap, abs=0.03 * overlap.max())


@pytest.mark.parametrize("height", [-1e3, -50.0, 0.0, 100.0])
def test_the_watch_does_not_ask_where_the_scene_lies(height, tmp_path):
    """A block that slides on its floor while its weight grows is given what it moves with, wherever y = 0 is, and no energy comes from
    nothing."""
    blocks = [block_files.box(-2, 2, height - 1, height), block_files.box(-0.5, 0.5, height, height + 1)]
    (tmp_path / "a.blk").write_text(block_files.block_file("ramp", [(k + 1, x) for k, x in enumerate(blocks)],
                                               [(-1.9, height - 0.9, 1), (1.9, height - 0.9, 1)]))
    (tmp_path / "a.ana").write_text("\n".join([
        "1 60 2 1 0.05 0.001", f"2500 0 1e10 0.25 {'0 ' * 9}", f"2500 24525 1e10 0.25 {'0 ' * 6} 1 0 0", "30 0 0",
        "&deck geometry='a.blk', dialect='short' /", "&gravity ramp=0.03 /", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert r.warnings == []
    assert r.summary["energy"]["given"] == pytest.approx(1250, rel=1e-3)
