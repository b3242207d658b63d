"""The same walls, columns and pyramids by scree and by programs for games and robots, side by side in one run.

pymunk (Chipmunk), Box2D and MuJoCo are modules from PyPI; one that is not installed is said to be absent. They know rigid bodies:
what overlaps in them is left over by their iteration, in scree it is what the springs of contacts need. So overlap is measured by
one routine, from the polygons of the blocks.

A scene is given to them in lengths of its own, `unit` to the edge of a block, as their tolerances are absolute; the time is that of
the scene, so gravity is scaled with the lengths and the motion is the same. Nothing sleeps.
"""
import argparse
import dataclasses
import importlib
import re
import time

import numpy as np

from ..arguments import say
from ..errors import ScreeError
from ..polygons import deepest_overlap
from . import scenes, settling
from .tables import Table

SCENES = ("wall10", "wall20", "column100", "pyramid10")
ACCURACIES = ("default", "fine")
INSTANTS = 20  # at which overlap is looked for, even in time
COLUMNS = [
    ("scene", "scene", "", -10), ("blocks", "blocks", "d", 6), ("program", "program", "", -8), ("version", "version", "", -8),
    ("accuracy", "accuracy", "", -8), ("step ms", "step_ms", ".3g", 8), ("iterations", "iterations", "", 10),
    ("reached", "time", ".4g", 7), ("s", "seconds", ".3f", 9), ("overlap", "overlap", ".1e", 8),
    ("of a block", "overlap_of_edge", ".1e", 10), ("travel", "travel", ".2e", 9), ("", "note", "", -8)]


@dataclasses.dataclass
class Accuracy:
    """How exact a program is asked to be: seconds of a step, iterations in words, and what its world takes besides."""

    step: float
    iterations: str
    unit: float = 1.0  # length of a block in the lengths of the program
    more: dict = dataclasses.field(default_factory=dict)


class Bodies:
    """The blocks of a scene in lengths of a program: corners about their middles, and where these are at the start."""

    def __init__(self, scene, unit):
        self.scale = unit / scene.edge
        self.base, *blocks = [self.scale * np.asarray(corners) for corners in scene.corners]
        self.middle = np.array([corners.mean(0) for corners in blocks])  # the centroid, as all are boxes
        self.corners = [corners - middle for corners, middle in zip(blocks, self.middle)]
        self.gravity, self.mu = scenes.GRAVITY * self.scale, scene.mu

    def polygons(self, places):
        """The base and the blocks in the lengths of the scene, from places x, y and angles (b, 3)."""
        c, s = np.cos(places[:, 2]), np.sin(places[:, 2])
        turn = np.stack([np.stack([c, s], 1), np.stack([-s, c], 1)], 1)
        return [self.base / self.scale, *((corners @ r + place) / self.scale
                                          for corners, r, place in zip(self.corners, turn, places[:, :2]))]


def sides(corners):
    """Width, height and angle of a box whose first side is its bottom."""
    along, up = corners[1] - corners[0], corners[2] - corners[1]
    return float(np.linalg.norm(along)), float(np.linalg.norm(up)), float(np.arctan2(along[1], along[0]))


class Pymunk:
    """Chipmunk by pymunk: impulses by sequential iterations, friction as the product of two."""

    accuracies = {"default": Accuracy(1 / 60, "10", 10.0),
                  "fine": Accuracy(1e-3, "50", 10.0, {"slop": 1e-4, "bias": 1e-12})}

    def __init__(self, pymunk, bodies, accuracy):
        self.step_size, self.space = accuracy.step, pymunk.Space()
        self.space.gravity = (0, -bodies.gravity)
        self.space.iterations = int(accuracy.iterations)
        if accuracy.more:
            self.space.collision_slop = accuracy.more["slop"]
            self.space.collision_bias = accuracy.more["bias"]
        shapes = [pymunk.Poly(self.space.static_body, bodies.base.tolist())]
        self.bodies = []
        for corners, middle in zip(bodies.corners, bodies.middle):
            points = corners.tolist()
            body = pymunk.Body(1.0, pymunk.moment_for_poly(1.0, points))
            body.position = tuple(middle)
            self.bodies.append(body)
            shapes.append(pymunk.Poly(body, points))
        for shape in shapes:
            shape.friction = bodies.mu**0.5
        self.space.add(*self.bodies, *shapes)

    def step(self):
        self.space.step(self.step_size)

    def places(self):
        return np.array([(*body.position, body.angle) for body in self.bodies])


class Box2D:
    """Box2D 2.3 by pybox2d: impulses by sequential iterations, of velocities and of positions; polygons without their skin."""

    accuracies = {"default": Accuracy(1 / 60, "8 + 3"), "fine": Accuracy(1e-3, "50 + 20", 10.0)}

    def __init__(self, box2d, bodies, accuracy):
        self.step_size, self.iterations = accuracy.step, tuple(map(int, accuracy.iterations.split("+")))
        self.world = box2d.b2World(gravity=(0, -bodies.gravity), doSleep=False)
        self.bodies = []

        def add(body, corners):
            shape = box2d.b2PolygonShape(vertices=corners.tolist())
            shape.radius = 0.0
            body.CreateFixture(shape=shape, density=1.0, friction=bodies.mu)

        add(self.world.CreateStaticBody(), bodies.base)
        for corners, middle in zip(bodies.corners, bodies.middle):
            body = self.world.CreateDynamicBody(position=tuple(middle))
            add(body, corners)
            self.bodies.append(body)

    def step(self):
        self.world.Step(self.step_size, *self.iterations)

    def places(self):
        return np.array([(*body.worldCenter, body.angle) for body in self.bodies])


class MuJoCo:
    """MuJoCo: soft contact solved by Newton's method to its own tolerance; boxes that joints keep in a plane."""

    accuracies = {"default": Accuracy(2e-3, "Newton"),
                  "fine": Accuracy(5e-4, "Newton", more={"solref": "0.002 1", "solimp": "0.99 0.999 0.001"})}

    def __init__(self, mujoco, bodies, accuracy):
        def body(middle, corners, joints):
            width, height, angle = sides(corners)
            place, turn = f"{float(middle[0])!r} 0 {float(middle[1])!r}", f"0 {-angle!r} 0"  # from x to z is about -y
            return (f'<body pos="{place}">{joints}<geom type="box" size="{width / 2!r} 0.5 {height / 2!r}" euler="{turn}"/></body>')

        joints = '<joint type="slide" axis="1 0 0"/><joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 -1 0"/>'
        soft = " ".join(f'{name}="{value}"' for name, value in accuracy.more.items())
        self.model = mujoco.MjModel.from_xml_string(
            f'<mujoco><compiler angle="radian"/><size memory="4G"/>'
            f'<option timestep="{accuracy.step!r}" gravity="0 0 {-bodies.gravity!r}" integrator="implicitfast" jacobian="sparse"/>'
            f'<default><geom friction="{bodies.mu!r}" {soft}/></default><worldbody>'
            + body(bodies.base.mean(0), bodies.base, "")
            + "".join(body(*both, joints) for both in zip(bodies.middle, bodies.corners)) + "</worldbody></mujoco>")
        self.data, self.advance, self.start = mujoco.MjData(self.model), mujoco.mj_step, bodies.middle

    def step(self):
        self.advance(self.model, self.data)

    def places(self):
        return self.data.qpos.reshape(-1, 3) + np.column_stack([self.start, np.zeros(len(self.start))])


WORLDS = {"box2d": ("Box2D", Box2D), "pymunk": ("pymunk", Pymunk), "mujoco": ("mujoco", MuJoCo)}  # the module, and its world
PROGRAMS = ("scree", *WORLDS)


def scene_named(word):
    """A scene by its name, as wall20."""
    makers = {"wall": scenes.wall, "column": scenes.column, "pyramid": scenes.pyramid}
    found = re.fullmatch(f"({'|'.join(makers)})([1-9][0-9]*)", word)
    if not found:
        raise argparse.ArgumentTypeError(f"expected {', '.join(makers)} and its size, as wall20, found '{word}'")
    try:
        return makers[found[1]](int(found[2]))
    except ScreeError as problem:
        raise argparse.ArgumentTypeError(problem) from None


def row_of(scene, program, version, seconds, reached, overlap, travel, **more):
    """A row of the table; overlap and travel in the lengths of the scene."""
    return {"scene": scene.name, "blocks": len(scene.corners), "edge": scene.edge, "end": scene.end, "program": program,
            "version": version, "time": reached, "seconds": seconds, "overlap": overlap, "overlap_of_edge": overlap / scene.edge,
            "travel": travel, **more}


def run_peer(scene, program, accuracy, limit):
    """The row of a scene by another program: processor seconds of its steps, the deepest overlap at the instants, travel."""
    name, make = WORLDS[program]
    module, asked = importlib.import_module(name), make.accuracies[accuracy]
    bodies = Bodies(scene, asked.unit)
    world, steps = make(module, bodies, asked), scene.steps(asked.step)
    start, done, seconds, overlap, travel, note = world.places(), 0, 0.0, 0.0, 0.0, ""
    for instant in range(1, INSTANTS + 1):
        begun = time.process_time()
        while done < steps * instant // INSTANTS:
            world.step()
            done += 1
        seconds += time.process_time() - begun
        places = world.places()
        if not np.isfinite(places).all():
            note = "not a number"
            break
        overlap = max(overlap, deepest_overlap(bodies.polygons(places)))
        travel = float(np.linalg.norm((places - start)[:, :2], axis=1).max() / bodies.scale)
        if seconds > limit and done < steps:
            note = "interrupted"
            break
    version = getattr(module, "__version__", None) or module.version
    return row_of(scene, program, version, seconds, done * asked.step, overlap, travel,
                  accuracy=accuracy, step_ms=1000 * asked.step, iterations=asked.iterations, unit=asked.unit, **asked.more,
                  note=note)


def run_scree(scene, given, folder):
    """The row of a scene by scree, its overlap at the frames next to the same instants."""
    r, _ = settling.run_scene(scene, given, folder)
    figures = settling.figures(r, scene, given.step)
    instants = scene.end * np.arange(1, INSTANTS + 1) / INSTANTS
    frames = np.unique(np.searchsorted(r.times, (1 - 1e-9) * instants).clip(max=r.n_frames - 1))
    overlap = max(deepest_overlap(r.polygons(frame)) for frame in frames)
    return row_of(scene, "scree", r.scene.version, figures["seconds"], figures["time"], overlap, figures["travel"], accuracy="",
                  step_ms=1000 * given.step, iterations=f"{figures['solves'] / max(1, figures['steps']):.1f} solves",
                  settings=given.set, note=figures["ended"])


def absent_programs(programs):
    """Those that are not installed, each with what the import said."""
    absent = {}
    for program in programs:
        if program == "scree":
            continue
        try:
            importlib.import_module(WORLDS[program][0])
        except ImportError as problem:
            absent[program] = str(problem)
    return absent


def peers(given, folder):
    table, absent = Table(COLUMNS), absent_programs(given.programs)
    for program, said in absent.items():
        say(f"{program} is left out: {said} (doc/performance.md says how to install it)")
    for scene in given.scenes:
        scene = dataclasses.replace(scene, end=given.end)
        for program in given.programs:
            if program == "scree":
                table.add(run_scree(scene, given, folder))
            elif program not in absent:
                for accuracy in given.accuracies:
                    table.add(run_peer(scene, program, accuracy, given.limit))
    if given.json:
        table.write(given.json, case="peers", settings=given.set, absent=sorted(absent), scree={"program": str(given.scree)})
