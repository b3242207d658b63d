"""tools/rockfall: single rocks against closed forms, and what a scene of many comes to."""
import csv
import math
import os
import pathlib
import subprocess

import numpy as np
import pytest
import scree
from scree.rockfalls.runs import inertia_of
from scree.rockfalls.scene import RockFall, rock_shape

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
HILLSIDE = SOURCE / "input" / "rockfall" / "hillside.toml"
G = 9.81


def one(**given):
    """The path of one rock."""
    scene = {"materials": {"rock": {"phi": 30, "restitution": 0.0}}, "number": 1, "time": 5, "rock": {"size": 1.0}} | given
    return scree.rockfall(scene, jobs=1).paths[0]


def test_a_rock_falls_freely():
    """A parabola from a cliff: place, speed and energy at a vertical line."""
    fall = scree.rockfall({"slope": [[0, 0], [100, 0]], "materials": {"rock": {"phi": 30, "restitution": 0}}, "number": 1, "time": 3,
                           "start": {"line": [[10, 50]], "velocity": [20, 5], "spin": 2}, "rock": {"size": 1.5}, "collectors": {"line": 50}}, jobs=1)
    row, = fall.collected["line"]
    path, shape = fall.paths[0], fall.paths[0].rock.corners
    assert row["time"] == pytest.approx(2, rel=1e-6) and row["height"] == pytest.approx(50 + 10 - G / 2 * 4, rel=1e-3)
    late = math.hypot(20, 5 - 2 * G) - row["speed"]  # a velocity is that of half a small step before, of at most a millisecond
    assert 0 < late < G * 0.5e-3
    mass = 2650 * math.pi / 4 * 1.5 ** 2 * 1.5
    assert path.mass == pytest.approx(mass, rel=1e-9)
    turning = 0.5 * 2650 * 1.5 * inertia_of(shape) * 2 ** 2
    assert row["energy"] == pytest.approx(mass / 2 * row["speed"] ** 2 + turning, rel=1e-4)


@pytest.mark.parametrize("restitution, material", [(0.3, "soft"), (0.7, "hard")])
def test_a_rock_bounces_by_the_restitution_of_the_ground(restitution, material):
    """A flat square falls 2 m on one of two materials; it rises by e^2 of that."""
    x = {"soft": 10, "hard": 30}[material]
    path = one(slope=[[0, 0], [20, 0], [40, 0]], ground=["soft", "hard"], time=2.5, start={"line": [[x, 2.5]]},
               materials={"soft": {"phi": 30, "restitution": 0.3}, "hard": {"phi": 30, "restitution": 0.7}},
               rock={"size": 2 / math.sqrt(math.pi), "corners": 4, "elongation": 1, "angle": 0})
    height = path.place[:, 1] - 0.5
    struck = int(np.argmax(height < 0.05))
    assert height[0] == pytest.approx(2) and height[struck:].max() == pytest.approx(2 * restitution ** 2, abs=0.02)


@pytest.mark.parametrize("phi, restitution, sticks", [(5, 0.0, False), (15, 0.0, False), (5, 0.5, False), (15, 0.5, False), (40, 0.5, True)])
def test_a_round_rock_loses_speed_along_the_ground_by_friction(phi, restitution, sticks):
    """A corner below the centre strikes at 4 m/s across and 5 m/s along. Of rigid bodies with friction the rock slips, and loses
    mu (1 + e) v_n, or sticks, and loses v_t/(1 + R^2/k^2): a third for a disc."""
    across, along, corners = 4.0, 5.0, 16
    path = one(slope=[[0, 0], [40, 0]], materials={"rock": {"phi": phi, "restitution": restitution}}, time=0.05, step=0.001, gravity=1e-6,
               start={"line": [[10, 0.1]], "velocity": [along, -across]},
               rock={"size": 1.0, "corners": corners, "elongation": 1, "angle": 180 / corners})
    shape = path.rock.corners
    slip = math.tan(math.radians(phi)) * (1 + restitution) * across
    stick = along / (1 + shape[:, 1].min() ** 2 / (inertia_of(shape) / (math.pi / 4)))
    assert (stick < slip) == sticks and stick == pytest.approx(along / 3, rel=0.02)
    after = path.velocity[np.argmax(path.velocity[:, 1] > -0.1)]
    turns = 7 * 3.5 * 1e-3  # rad/s at most, times m/s of the corner along the ground and the millisecond of a step: its lever arm grows
    assert after[1] == pytest.approx(restitution * across, abs=turns)
    assert along - after[0] == pytest.approx(min(slip, stick), rel=0.005)


@pytest.mark.parametrize("phi", [10, 20])
def test_a_flat_rock_slides_down_a_slope(phi):
    """g (sin a - cos a tan phi) along a slope of 30 degrees, from rest."""
    down = math.radians(30)
    x, y = 40 * math.cos(down), 40 * math.sin(down)
    start = np.array([5 * math.cos(down), y - 5 * math.sin(down)]) + 0.5 * np.array([math.sin(down), math.cos(down)])
    path = one(slope=[[0, y], [x, 0]], materials={"rock": {"phi": phi, "restitution": 0}}, start={"line": [start.tolist()]}, time=1.5,
               rock={"size": 2 / math.sqrt(math.pi), "corners": 4, "elongation": 1, "angle": -30})
    way = np.linalg.norm(path.place - path.place[0], axis=1)
    assert way[-1] == pytest.approx(G / 2 * (math.sin(down) - math.cos(down) * math.tan(math.radians(phi))) * path.time[-1] ** 2, rel=5e-3)


@pytest.mark.parametrize("restitution", [0.0, 0.5])
def test_friction_bears_the_whole_impulse_of_an_impact(restitution):
    """A corner strikes straight below the centre: the impact takes mu (1 + e) v of the speed along, and turns the rock by it (Poisson)."""
    mu, down, along = 0.2, 5.0, 6.0
    corners = 16
    size = 1.0
    path = one(slope=[[0, 0], [60, 0]], materials={"rock": {"phi": math.degrees(math.atan(mu)), "restitution": restitution}}, gravity=1e-3,
               start={"line": [[10, 1.0]], "velocity": [along, -down]}, time=0.3, step=1e-3,
               rock={"size": size, "corners": corners, "elongation": 1, "angle": 180 / corners})
    shape = path.rock.corners
    lowest = shape[shape[:, 1].argmin()]
    assert abs(lowest[0]) < 1e-12  # a corner below the centre
    after = path.velocity[np.flatnonzero(path.velocity[:, 1] > -0.5 * down)[0]]
    assert after[1] == pytest.approx(restitution * down, abs=0.02 * down)
    assert along - after[0] == pytest.approx(mu * (1 + restitution) * down, rel=0.02)


def test_a_rock_comes_to_rest_or_leaves():
    slope = {"slope": [[0, 10], [10, 10], [20, 0], [60, 0]], "ground": "rock"}
    rests = one(**slope, start={"line": [[11, 12]]}, time=20)
    assert rests.end == "rest" and rests.time[-1] < 20 and rests.speed[-1] < 0.1
    leaves = one(**slope, start={"line": [[30, 3]], "velocity": [25, 5]}, materials={"rock": {"phi": 5, "restitution": 0.3}}, time=20)
    assert leaves.end == "out" and leaves.place[-1, 0] > 60 and (leaves.place[:-1, 0] <= 60).all()


def test_a_barrier_stops_what_is_lower():
    scene = {"slope": [[0, 0], [60, 0]], "materials": {"rock": {"phi": 20, "restitution": 0.2}}, "number": 4, "time": 15,
             "start": {"line": [[10, 1], [14, 1]], "velocity": [15, 3]}, "rock": {"size": 0.8}}
    free = scree.rockfall(scene, jobs=2)
    held = scree.rockfall(scene | {"barrier": {"x": 25, "height": 6}}, jobs=2)
    assert (free.run_out > 25).all() and (held.run_out < 25).all() and held.stopped() == 4


def test_rocks_have_the_area_and_the_seed_that_they_are_given():
    for corners in (3, 5, 8):
        shape = rock_shape(corners, 2.0, 1.5, 0.7)
        x, y = shape.T
        after = np.roll(shape, -1, axis=0)
        twice = x * after[:, 1] - after[:, 0] * y
        assert twice.sum() / 2 == pytest.approx(math.pi) and (twice > 0).all()
        assert (twice @ (shape + after)) == pytest.approx([0, 0], abs=1e-12)
    first, again = (RockFall.read(HILLSIDE, number) for number in (7, 7))
    assert [one.laws for one in first.rocks] == [one.laws for one in again.rocks]
    assert len({one.size for one in first.rocks}) == 7 and all(0.5 <= one.size <= 1.2 for one in first.rocks)


def test_the_command_writes_tables_and_pictures(tmp_path):
    done = subprocess.run([SOURCE / "tools" / "rockfall", HILLSIDE, "--number", "6"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "hillside-fall"
    assert {path.name for path in folder.iterdir()} == {"rocks.csv", "collectors.csv", "paths.png", "histograms.png"}
    with (folder / "rocks.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 6 and {row["end"] for row in rows} <= {"rest", "out"}
    assert done.stdout.startswith("6 rocks: ") and "foot of the cliff: 6 rocks" in done.stdout


@pytest.mark.parametrize("words, said", [
    ({"slope": [[0, 0]]}, "two places [x, y] or more"), ({"slope": [[0, 0], [0, 5]]}, "ascending x"),
    ({"ground": "sand"}, "a material for each of the 1 parts of the slope: rock"), ({"number": 0}, "a whole number from 1 for number, found 0"),
    ({"time": -1}, "a number above 0 for time"), ({"speed": 3}, "expected barrier, collectors"), ({"rock": {"sise": 1}}, "in [rock], found sise"),
    ({"rock": {"size": "large"}}, "for rock.size, found 'large'"), ({"barrier": {"x": 200, "height": 2}}, "a place on the slope for barrier.x"),
    ({"materials": {}}, "tables of phi and restitution"), ({"start": {}}, "places [x, y] for line, found None")])
def test_bad_scenes_are_refused(words, said):
    scene = {"slope": [[0, 0], [60, 0]], "materials": {"rock": {"phi": 20}}, "number": 1, "start": {"line": [[5, 5]]}}
    with pytest.raises(scree.ScreeError) as problem:
        RockFall(scene | words)
    assert said in str(problem.value)
