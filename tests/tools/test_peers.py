"""tools/bench peers: what the programs are given, what is measured of them; each that is installed on motions with an answer."""
import json
import math
import os
import pathlib
import subprocess

import numpy as np
import pytest
from scree.bench import peers, scenes
from scree.block_files import box, turned

SCREE = os.environ["SCREE"]
TOOLS = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tools"


class Sinking:
    """A program in which a block goes down by 1/20 of its edge in each of ten steps and turns by a quarter in all."""

    accuracies = {"default": peers.Accuracy(0.1, "none", 8.0)}

    def __init__(self, module, bodies, accuracy):
        self.middle, self.unit, self.steps = bodies.middle, accuracy.unit, 0

    def step(self):
        self.steps += 1

    def places(self):
        down = self.steps * self.unit / 20
        return np.column_stack([self.middle[:, 0], self.middle[:, 1] - down, np.full(len(self.middle), self.steps * math.pi / 20)])


def one_block(tilt=0.0, height=0.0, edge=1.0, mu=0.3, end=1.0):
    """A square block at a height over the middle of a base, both turned clockwise."""
    corners = [box(-200, 200, -50, 0), box(-0.5, 0.5, height, height + 1)]
    return scenes.Boxes("one", "one", 1, edge, end, corners=[edge * turned(c, -tilt) for c in corners], mu=mu)


@pytest.mark.parametrize("edge", [0.005, 1.0])
def test_bodies_are_where_the_scene_has_them(edge):
    scene = scenes.column(16, edge)
    bodies = peers.Bodies(scene, 10.0)
    polygons = bodies.polygons(np.column_stack([bodies.middle, np.zeros(16)]))
    assert np.allclose(np.concatenate(polygons), np.concatenate(scene.corners), rtol=0, atol=1e-13 * 200 * edge)
    assert np.linalg.norm(bodies.corners[0][1] - bodies.corners[0][0]) == pytest.approx(10.0)
    assert bodies.gravity / scenes.GRAVITY == pytest.approx(10.0 / edge)


def test_overlap_and_travel_are_those_of_the_places(monkeypatch):
    """Of a square that turned by an angle and sank by d, (|cos| + |sin| - 1)/2 + d of its edge; lengths are those of the scene."""
    monkeypatch.setitem(peers.WORLDS, "sinking", ("math", Sinking))
    monkeypatch.setattr(math, "version", "0", raising=False)
    row = peers.run_peer(one_block(edge=0.01), "sinking", "default", 60.0)
    angles = [k * math.pi / 20 for k in range(1, 11)]
    deepest = max((math.cos(angle) + math.sin(angle) - 1) / 2 + k / 20 for k, angle in enumerate(angles, 1))
    assert (row["overlap"], row["overlap_of_edge"]) == pytest.approx((0.01 * deepest, deepest), rel=1e-12)
    assert row["travel"] == pytest.approx(0.005, rel=1e-12) and row["time"] == pytest.approx(1.0) and row["note"] == ""


def test_a_program_that_is_not_there_is_said(tmp_path):
    """Modules that do not import, as where they are not installed; the others run."""
    for module, _ in peers.WORLDS.values():
        (tmp_path / f"{module}.py").write_text("raise ImportError('not on this machine')\n")
    words = ["--scenes", "wall2", "--end", "0.02", "--scree", SCREE, "--json", tmp_path / "it.json"]
    done = subprocess.run([TOOLS / "bench", "peers", *words], capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(tmp_path)})
    assert done.returncode == 0, done.stderr
    assert [line.split(": ")[1:3] for line in done.stderr.splitlines()] == [
        [f"{program} is left out", "not on this machine (doc/performance.md says how to install it)"] for program in peers.WORLDS]
    written = json.loads((tmp_path / "it.json").read_text())
    assert written["absent"] == sorted(peers.WORLDS)
    row, = written["rows"]
    assert row["program"] == "scree" and row["blocks"] == 6 and row["time"] == pytest.approx(0.02)
    assert 0 < row["overlap"] < 1e-5 and row["overlap_of_edge"] == row["overlap"]


def test_scree_overlaps_by_what_its_springs_need(tmp_path):
    """A block put on a base at once sinks by up to twice W/2p at each of its two corners, and by W/2p at rest."""
    rest = scenes.DENSITY * scenes.GRAVITY / (2 * 1e9)
    given = type("given", (), {"scree": SCREE, "step": 0.001, "set": ["contact.stiffness=1e9", "integrator.beta=1"], "limit": 60.0})
    row = peers.run_scree(one_block(end=1.0, mu=0.6), given, tmp_path)
    assert rest < row["overlap"] * 1.01 and row["overlap"] < 2.02 * rest


def test_a_scene_is_named_by_its_kind_and_size():
    assert len(peers.scene_named("wall10").corners) == 106
    for word in ("wall", "arch10", "column50", "pyramid0", "10"):
        with pytest.raises(peers.argparse.ArgumentTypeError, match="expected"):
            peers.scene_named(word)


@pytest.mark.parametrize("program", peers.WORLDS)
class TestInstalled:
    """At the fine accuracy."""

    @pytest.fixture(autouse=True)
    def installed(self, program):
        pytest.importorskip(peers.WORLDS[program][0])

    @pytest.mark.parametrize("edge", [0.005, 1.0])
    def test_a_block_in_the_air_falls(self, program, edge):
        """To g t dt/2, half a step at the end speed: an integrator of first order is off by it; 1 % of it for single precision."""
        row = peers.run_peer(one_block(height=60.0, edge=edge, end=0.3 * edge**0.5), program, "fine", 60.0)
        speed = scenes.GRAVITY * row["time"]
        assert row["travel"] == pytest.approx(speed * row["time"] / 2, abs=1.01 * speed * row["step_ms"] / 2000)
        assert row["overlap"] == 0

    def test_a_block_slides_as_coulomb_says(self, program):
        """To 1 %: a first step, with no contact yet, and skins and softness of contacts."""
        tilt, time = math.radians(25), 1.0
        row = peers.run_peer(one_block(tilt, end=time), program, "fine", 60.0)
        assert row["travel"] == pytest.approx(scenes.GRAVITY * (math.sin(tilt) - 0.3 * math.cos(tilt)) * time**2 / 2, rel=0.01)
        assert row["overlap"] < 1e-3

    def test_a_block_on_less_than_its_friction_rests(self, program):
        """But for the first steps, in which contact builds up, and for the creep of soft friction."""
        row = peers.run_peer(one_block(math.radians(25), mu=0.6), program, "fine", 60.0)
        assert row["travel"] < 2e-3 and row["overlap"] < 1e-3
