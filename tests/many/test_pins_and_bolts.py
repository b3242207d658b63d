"""Pins, rollers, points that move and bolts in small steps, against closed forms."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box, turned
from small import DENSITY, G, decks, run, ways

CEILING = box(-3, 3, 3, 4)


def test_a_block_swings_about_its_pin(tmp_path):
    """A square of 1 m hangs at a corner, 5 degrees out of balance: half a period later it is as far on the other side."""
    corners = turned(box(0, 1, 0, 1), np.radians(5 - 135))
    files = decks(tmp_path, [(1, corners)], time=1.0, step=5e-4)
    files[0].write_text(block_file("Square", [(1, corners)], [(*corners[0], 1)]))
    omega = np.sqrt(G * np.sqrt(0.5) / (2 / 3)) * (1 - np.radians(5)**2 / 16)
    result = scree.run(*files, output=tmp_path / "x.h5", settings=["step.sleep=0", f"step.end_time={np.pi / omega}"])
    assert result.bodies.rotation[-1, 0] == pytest.approx(-2 * np.radians(5), rel=2e-3)
    energy = result.history.energy
    assert abs(energy.dissipated).max() < 1e-3 * DENSITY * G * np.sqrt(0.5) * (1 - np.cos(np.radians(5)))
    distance = np.linalg.norm(result.bodies.centroid[:, 0], axis=-1)
    assert distance == pytest.approx(np.sqrt(0.5), abs=1e-4)


def test_a_block_on_rollers_falls_along_them(tmp_path):
    """Rollers along a side that is turned by 30 degrees hold it across, and it slides as Newton has it."""
    corners = turned(box(0, 1, 0, 1), -np.radians(30))
    (a, b) = corners[0], corners[1]
    groups = f"&support normal={a[0]} {a[1]} {b[0]} {b[1]} /"
    files = decks(tmp_path, [(2, box(0, 1, 0, 1))], time=1.0, groups=groups, fixed=[])
    files[0].write_text(block_file("x", [(2, corners)], []))
    result = scree.run(*files, output=tmp_path / "x.h5")
    moved = result.bodies.centroid[-1, 0] - result.bodies.centroid[0, 0]
    assert moved == pytest.approx(G / 4 * np.array([np.cos(np.radians(30)), -0.5]), rel=1e-4)
    assert abs(result.bodies.rotation[-1, 0]) < 1e-6


def test_points_that_move_take_their_block_along(tmp_path):
    """Two points of a block without weight go 1 m to the right in a second, and the work is its kinetic energy."""
    (tmp_path / "x.blk").write_text(block_file("x", [(2, box(0, 1, 0, 1))], [(0.1, 0.5, 1), (0.9, 0.5, 1)]))
    table = [(0, 0, 0), (0.5, 0.25, 0), (1, 1, 0)]
    rows = ["1 200 2 1 0.05 5e-3 0", "3 3", *(" ".join(map(str, row)) for row in table * 2)]
    rows += [f"{DENSITY} 0 1e10 0.25\n0 0 0\n0 0 0\n0 0 0"] * 2 + ["30 0 0", "&deck dialect='shi' /", "&integrator scheme='small_steps' /"]
    (tmp_path / "x.ana").write_text("\n".join([*rows, ""]))
    result = scree.run(tmp_path / "x.blk", tmp_path / "x.ana", output=tmp_path / "x.h5")
    assert ways(result, slice(0, None))[0] == pytest.approx(1.0, abs=1e-3)
    assert result.bodies.velocity[-1, 0] == pytest.approx((1.5, 0.0), abs=1e-3)


def test_a_bolt_bears_a_block(tmp_path):
    """A block of 1 m hangs from a bolt: it comes to rest where the tension is its weight, and a bolt that is too weak yields."""
    stiffness = 1e7
    groups = f"&bolts ends=0 3.5 0 2.4, stiffness={stiffness} /\n&damping mass=5 /"
    blocks = [(1, CEILING), (2, box(-0.5, 0.5, 1.5, 2.5))]
    result = run(tmp_path, blocks, "step.sleep=0", time=4.0, groups=groups)
    assert ways(result)[0] == pytest.approx(DENSITY * G / stiffness, rel=1e-2)
    weak = run(tmp_path, blocks, "step.sleep=0", f"bolts.strength={0.98 * DENSITY * G}", time=2.0, groups=groups, name="weak")
    strong = run(tmp_path, blocks, "step.sleep=0", f"bolts.strength={2.1 * DENSITY * G}", time=2.0, groups=groups, name="strong")
    assert ways(weak)[0] > 10 * ways(strong)[0]


def test_a_run_with_ties_goes_on_with_the_same_bits(tmp_path):
    groups = "&bolts ends=0 3.5 0.3 2.4, stiffness=1e6, strength=3e4 /\n&output every=10 /"
    blocks = [(1, CEILING), (2, box(-0.5, 0.5, 1.5, 2.5)), (2, box(0.6, 1.6, 0, 1))]
    fixed = [(-2.9, 3.1, 1), (2.9, 3.9, 1), (0.7, 0.9, 3)]
    files = decks(tmp_path, blocks, time=0.5, groups=groups, fixed=fixed)
    whole = scree.run(*files, output=tmp_path / "whole.h5")
    for moment in (1, 37):
        scree.run(*files, output=tmp_path / "part.h5", settings=[f"step.count={moment}"])
        done = scree.call("run", "--restart", tmp_path / "part.h5", "--quiet", "--set", f"step.count={len(whole.history.time)}")
        assert done.returncode == 0, done.stderr
        assert scree.read(tmp_path / "part.h5").bodies.centroid[-1].tobytes() == whole.bodies.centroid[-1].tobytes()


def test_grouted_bolts_are_refused(tmp_path):
    groups = "&bolts ends=0 3.5 0 2.4, stiffness=1e7, shear_stiffness=1e6 /"
    files = decks(tmp_path, [(1, CEILING), (2, box(-0.5, 0.5, 2, 3))], time=0.1, groups=groups)
    done = scree.call("run", *files, "-o", tmp_path / "x.h5")
    assert done.returncode == 2 and "shear_stiffness" in done.stderr, done.stderr
