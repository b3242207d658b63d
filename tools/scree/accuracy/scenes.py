"""Scenes whose accuracy is priced: a deck of one's own, or one of a set, most of which have an answer in closed form."""
import dataclasses
import math
import pathlib
import typing

import numpy as np

from .. import touching
from ..block_files import block_file, box, running_bond, on_base, turned
from ..errors import ScreeError
from ..program import shipped as place_of
from ..validation import arc, references
from .choices import AXES, DECK, INTEGRATORS, MULTIPLIERS, number

G = 9.81
SHIPPED = {}
FACTORS = (4.0, 2.0, 1.0, 0.5, 0.25)
STRAINS = [DECK, "small", "green", "auto"]
STEPPERS = [DECK, *INTEGRATORS]


@dataclasses.dataclass
class Quantity:
    """Numbers that a run is judged by.

    An error is the largest difference from `exact`, a closed form that leaves out as much as `doubt`, or without one from an
    extrapolated reference; over `scale`, or without one over the largest number of the reference. `way` is in its unit the displacement
    that an accuracy of the steps is a share of, where it is not that.
    """

    measure: typing.Callable  # results -> numbers
    exact: object = None
    scale: float = None
    doubt: float = 0.0
    way: float = None


@dataclasses.dataclass
class Scene:
    """A scene that writes its decks into a folder, for a mesh finer or coarser by a factor: (decks, settings of that mesh).

    It runs to `end` in steps of `size` times a factor; `axes` are the choices by default.
    """

    name: str
    text: str
    write: typing.Callable
    quantities: dict
    end: float
    size: float
    axes: dict
    source: pathlib.Path = None  # of a deck of one's own


def axes(strains=STRAINS, integrators=STEPPERS, contacts=(DECK, "0.1", "10", MULTIPLIERS), tolerances=(DECK, "1e-6", "1e-3"),
         meshes=(DECK,), accuracies=(DECK,), steps=FACTORS):
    return dict(zip(AXES, map(list, (strains, integrators, contacts, tolerances, meshes, accuracies, steps))))


def shipped(text):
    """A scene of the set, made when it is asked for."""
    def add(make):
        name = make.__name__.replace("_", "-")
        SHIPPED[name] = (text, lambda: make(name, text))
        return make
    return add


# Decks of the repository, with groups of our own

def with_groups(deck, *groups, geometry=None):
    """Writes the numbers of a deck of the repository with other groups, so that what is not said is the default of a new deck."""
    def write(folder, mesh):
        text = deck.read_text()
        blocks = geometry or deck.parent / text.split("geometry='")[1].split("'")[0]
        dialect = "shi" if "dialect='shi'" in text else "short"
        path = folder / deck.name
        path.write_text("\n".join([text.split("\n&")[0], f"&deck geometry='{blocks}', dialect='{dialect}' /", *groups, ""]))
        return [path], []
    return write


def at_end(values):
    """The last row of a series of the results."""
    return lambda r: np.atleast_1d(np.asarray(values(r), float)[-1])


def area_over_start(r):
    return np.atleast_1d(r.bodies.area[-1] / r.bodies.area[0])


def rotation(block):
    return at_end(lambda r: r.history.rotation[:, block])


def way(r):
    """Displacements of the measured points, and the largest on the way; else of the middles of the blocks."""
    if "measured_points" in r:
        moved = r.measured_points.displacement
        return np.append(moved[-1], np.linalg.norm(moved, axis=2).max())
    return (r.bodies.centroid[-1] - r.bodies.centroid[0]).ravel()


def summit(time, height, first, last):
    """Time and height of the highest point between two rows, on a parabola through three."""
    top = first + int(np.argmax(height[first:last]))
    if not 0 < top < len(time) - 1:
        return time[top], height[top]
    parabola = np.polynomial.Polynomial.fit(time[top - 1:top + 2], height[top - 1:top + 2], 2)
    at = parabola.deriv().roots()
    return (at[0].real, parabola(at[0].real)) if len(at) else (time[top], height[top])


@shipped("the turning triangle of Zhang et al. 2019: one turn in a second, nothing but inertia")
def triangle(name, text):
    deck = place_of("paper/rotation/t1.ana")
    stretch = 1e-6  # by what turns with it, and what that makes of an angle
    return Scene(name, text, with_groups(deck, "&method model='nmm', plane='strain' /"), {
        "area": Quantity(area_over_start, 1.0, 1.0, stretch),
        "angle": Quantity(rotation(0), 2 * math.pi, 2 * math.pi, 1e-7, way=2.0)},
        1.0, 0.01, axes(contacts=[DECK], steps=[4.0, 2.0, 1.0, 0.5, 0.25, 0.1]))


@shipped("a square of 1 m that swings about a corner, 90 degrees to either side: 2 s, nearly a period")
def pendulum(name, text):
    corners = turned(box(0, 1, 0, 1), -math.pi / 4)  # its middle beside the pin

    def write(folder, mesh):
        geometry, deck = folder / "pendulum.blk", folder / "pendulum.ana"
        geometry.write_text(block_file(text, [(1, corners)], [(*corners[0], 1)]))
        deck.write_text(f"1 200 1 1 0.05 0.01\n2500 {2500 * G} 1e10 0.25\n0 0 0 0 0 0 0 0 0\n30 0 0\n&deck dialect='short' /\n")
        return [geometry, deck], []

    arm = math.sqrt(0.5)
    angle = -math.pi / 2 + references.pendulum(math.pi / 2, (arm**2 + 1 / 6) / arm, 2.0, G)
    # rho g L/E = 2.5e-6 of stretch at rest, three times that at the bottom
    return Scene(name, text, write, {
        "angle": Quantity(rotation(0), angle, 1.0, 1e-5, way=2.0),
        "area": Quantity(area_over_start, 1.0, 1.0, 1e-5)},
        2.0, 0.01, axes(contacts=[DECK]))


@shipped("a cantilever of manifold elements, bent by 0.6 of its length: load steps and mesh")
def cantilever(name, text):
    length, depth, force, rows = 1.0, 0.1, 2500.0, 8  # P L^2/EI = 3

    def write(folder, mesh):
        """The load grows with time; fixed points stand where the mesh meets the clamped edge."""
        height = depth / round(rows / mesh)
        clamped = sorted({0.0, depth} | {j / 2 * height for j in range(1, 2 * round(rows / mesh))})
        points = [f"0 {y} 0 {y}" for y in clamped] + [f"{length} 0", f"{length} {depth}"] * 2  # loads, measured points
        geometry, deck = folder / f"cantilever-{mesh:g}.geo", folder / f"cantilever-{mesh:g}.ana"
        geometry.write_text(
            f"1e-6\n4 4\n0\n0\n{len(clamped)}\n2\n2\n0\n0 0 {length} 0 1\n{length} 0 {length} {depth} 1\n"
            f"{length} {depth} 0 {depth} 1\n0 {depth} 0 0 1\n" + "\n".join(points) + "\n")
        tables = " ".join(["0"] * len(clamped) + ["2", "2"])
        load = f"0 0 0 1 0 {-force / 2}\n"
        deck.write_text(f"0 8 1 1 0.05 0.125\n0\n{tables}\n{load}{load}1e-3 0 1e7 0.3\n0 0 0\n0 0 0\n0 0 0\n30 0 0\n"
                        f"&deck dialect='shi' /\n&method model='nmm' /\n&cover edge={height / math.sqrt(0.75)}, origin=0 0 /\n"
                        "&iteration most=200 /\n")
        return [geometry, deck], []

    return Scene(name, text, write, {"deflection": Quantity(at_end(lambda r: r.measured_points.displacement.mean(1)))}, 1.0, 0.125,
                 axes(integrators=[DECK, "newmark"], contacts=[DECK], meshes=[DECK, "4", "2", "0.5"], steps=[8.0, 4.0, 2.0, 1.0]))


@shipped("a block slides from rest down a plane of 30 degrees, mu 0.3: 1 s")
def slide(name, text):
    deck = place_of("validation/b1-slide/slope30.ana")
    down = np.array([math.cos(math.pi / 6), -math.sin(math.pi / 6)])
    exact = references.slide(math.pi / 6, 0.3, 1.0)
    return Scene(name, text, with_groups(deck), {
        "way": Quantity(at_end(lambda r: r.measured_points.displacement[:, 0] @ down), exact, exact, 1e-7),
        "area": Quantity(lambda r: r.bodies.area[-1, 1:] / r.bodies.area[0, 1:], 1.0, 1.0, 1e-5)},
        1.0, 0.01, axes())


@shipped("a square falls with a corner on a plane of 45 degrees, sticks and spins off: 0.15 s; plastic")
def corner_drop(name, text):
    deck = place_of("validation/b5-corner-impact/impact.ana")
    x, y, angle = references.SlopeImpact(0.05, 0.05, 0.3).place((0.125, 0.475), 0.15)
    return Scene(name, text, with_groups(deck, "&contact restitution=0 /"), {
        "way": Quantity(at_end(lambda r: r.measured_points.displacement[:, 0]), (x - 0.125, y - 0.475), None, 1e-6),
        "angle": Quantity(rotation(1), angle, None, 1e-6),
        "area": Quantity(area_over_start, 1.0, 1.0, 1e-5)},
        0.15, 0.002, axes())


@shipped("a block of 0.5 by 2 m falls back from half the tilt that overturns it: 0.45 s, before it meets the ground")
def rocking_block(name, text):
    deck = place_of("validation/b10-rocking/tilt0.5.ana")
    block = references.Rocking(0.25, 1.0)
    start = 0.5 * block.alpha
    return Scene(name, text, with_groups(deck), {
        "angle": Quantity(rotation(1), start - block.tilt(start, 0.45), None, 2e-6),
        "area": Quantity(lambda r: r.bodies.area[-1, 1:] / r.bodies.area[0, 1:], 1.0, 1.0, 1e-5)},
        0.45, 0.01, axes())


@shipped("a block slides up an arc of 20 chords and back, without friction (Zhang et al. 2019): 1.9 s; kinks are plastic")
def arc_slide(name, text):
    exact = arc.reference(20, 80)

    def measured(r):
        time, place = r.history.time, r.measured_points.position[:, 0]
        return time, place[:, 0], r.measured_points.displacement[:, 0, 1], r.measured_points.velocity[:, 0, 0]

    def top(r):
        time, _, rise, _ = measured(r)
        return summit(time, rise, 0, int(np.searchsorted(time, 1.4)))

    def speed_back(r):
        time, x, _, speed = measured(r)
        back = np.flatnonzero((time > top(r)[0]) & (x < -arc.LENGTH / 2 - 0.05))
        return -speed[back[0]] if back.size else math.nan

    return Scene(name, text, with_groups(place_of("paper/arc/arc.ana"), "&contact restitution=0 /"), {
        "rise": Quantity(lambda r: top(r)[1], exact.rise, arc.RISE, 1e-6),
        "time of the top": Quantity(lambda r: top(r)[0], arc.PUSH_TIME + exact.top_time, None, 1e-6),
        "speed back": Quantity(speed_back, exact.speed_back, arc.SPEED, 1e-6),
        "area": Quantity(area_over_start, 1.0, 1.0, 1e-5)},
        1.9, 0.004, axes(steps=[2.0, 1.0, 0.5, 0.25]))


@shipped("a square falls by 1 m and bounces with restitution 0.5: the heights of three bounces, 1.4 s")
def bounce(name, text):
    def heights(r):
        height, speed = 1 + r.measured_points.displacement[:, 0, 1], r.measured_points.velocity[:, 0, 1]
        tops = np.flatnonzero((speed[:-1] > 0) & (speed[1:] <= 0))
        found = [summit(r.history.time, height, max(0, i - 1), i + 3)[1] for i in tops if height[i] > 0.005]
        return np.array([*found[:3], 0, 0, 0][:3])

    return Scene(name, text, with_groups(place_of("validation/b7-bounce/restitution0.5.ana"), "&contact restitution=0.5 /"), {
        "heights": Quantity(heights, (0.25, 0.0625, 0.015625), 1.0, 1e-6)},
        1.4, 0.002, axes(steps=[4.0, 2.0, 1.0, 0.5, 0.25]))


@shipped("a wall of six courses is put up at once and stands: after 0.5 s the stress of the lowest course, and what still moves")
def wall(name, text):
    courses = 6
    corners = running_bond(courses)
    weight = 2500 * G

    def write(folder, mesh):
        geometry, deck = folder / "wall.blk", folder / "wall.ana"
        geometry.write_text(on_base(text, corners))
        rest = "0 0 0 0 0 0 0 0 0"
        deck.write_text(f"1 100 2 1 0.05 0.005\n2500 0 1e10 0.25 {rest}\n2500 {weight} 1e10 0.25 {rest}\n30 0 0\n"
                        "&deck dialect='short' /\n")
        return [geometry, deck], []

    def pressure(r):
        """Mean over the lowest course, the blocks after the base: that bears all above its middle."""
        lowest = slice(1, 1 + courses)
        return np.average(r.bodies.stress[-1, lowest, 1], weights=r.bodies.area[-1, lowest])

    mass = 2500 * courses**2
    return Scene(name, text, write, {
        "pressure": Quantity(pressure, -weight * (courses - 0.5), None, 1e-5),
        "speed": Quantity(at_end(lambda r: np.sqrt(2 * r.history.energy.kinetic / mass)), 0.0, math.sqrt(G), 1e-9)},
        0.5, 0.005, axes(steps=[2.0, 1.0, 0.5, 0.25]))


@shipped("rock that forty joints cut at random gets its weight at once: 0.1 s; no answer in closed form")
def random_rock(name, text):
    end, size = 0.1, 0.005
    return Scene(name, text, lambda folder, mesh: ([touching.jointed_rock(folder, "dda", 0, round(end / size), size)], []),
                 {what: QUANTITIES[what] for what in ("displacement", "kinetic")}, end, size,
                 axes(["small", "green"], [DECK, "shi", "momentum"], [DECK, "0.1"], [DECK], steps=[1.0, 0.5, 0.2, 0.1]))


# Decks of one's own

QUANTITIES = {
    "displacement": Quantity(way),
    "rotation": Quantity(at_end(lambda r: r.history.rotation), scale=1.0),
    "area": Quantity(area_over_start, scale=1.0),
    "kinetic": Quantity(lambda r: (r.history.energy.kinetic[-1], r.history.energy.kinetic.max())),
    "stress": Quantity(lambda r: r.bodies.stress[-1].ravel()),
}


def own(deck, asked, quantities):
    """The scene of a deck that someone has: its steps and end are those that it asks for."""
    for name in ("step.size", "step.end_time"):
        if name not in asked:
            raise ScreeError(f"{deck}: expected a deck with {name}, as errors are compared at one time, found none")

    def write(folder, mesh):
        return [deck], [f"cover.edge={mesh * number(asked, 'cover.edge')}"] if mesh != 1 else []

    return Scene(deck.stem, f"the deck {deck.name}", write, quantities,
                 float(asked["step.end_time"]), float(asked["step.size"]), axes(), deck)
