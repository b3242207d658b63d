"""The validation cases of elastic bodies without contact."""
import math

import numpy as np

from . import references, scenes
from .cases import DECKS, G, Row, case

SIDE = 2 / math.sqrt(3)  # edge of triangles that are 1 high
PENDULUM = (1 / 2 + 1 / 6) / math.sqrt(1 / 2)  # of a square of 1 m about its corner: radius of inertia squared over the arm


def orders(values):
    """Observed orders of convergence of a value on meshes, or steps, each half the one before: log2 of the ratio of its changes."""
    changes = np.diff(values)
    return np.log2(changes[:-1] / changes[1:])


def frequency(time, values, guess):
    """Of the sine that fits best, within 3 % of a guess."""
    tried = guess * np.linspace(0.97, 1.03, 601)
    left = []
    for f in tried:
        of_time = np.column_stack([np.ones_like(time), np.cos(2 * math.pi * f * time), np.sin(2 * math.pi * f * time)])
        left.append(np.sum((values - of_time @ np.linalg.lstsq(of_time, values, rcond=None)[0])**2))
    return tried[np.argmin(left)]


@case
def e6(run):
    """Cantilever under a small load: deflection, convergence, first frequency."""
    beam, deck = references.TimoshenkoBeam(10.0, 1.0, 1e9, 0.25, 2500.0), DECKS / "e6-cantilever" / "bent.ana"
    found = {}
    for order, rows in ((0, (8, 16, 32)), (1, (1, 2, 4, 8))):
        for n in rows:
            r = run(deck, settings=[f"cover.order={order}", f"cover.edge={SIDE / n}"], name=f"e6-order{order}-{n}")
            found[order, n] = -r.measured_points.displacement[-1, :, 1].mean()
    for words, of in (("order=0, 16 rows", (0, 16)), ("order=1, one row", (1, 1))):
        yield Row(f"deflection, {words}", beam.deflection(1e4), found[of], 0.01)
    yield Row("order of the error, order=0, mesh halved", 2.0, orders([found[0, n] for n in (8, 16, 32)])[0], 0.05)
    yield Row("order of the error, order=1, mesh halved", 2 * references.clamped_corner(0.25), orders([found[1, n] for n in (2, 4, 8)])[0], 0.05)
    r = run(DECKS / "e6-cantilever" / "swings.ana")
    exact = beam.frequency()
    yield Row("first frequency", exact, frequency(r.history.time, r.measured_points.displacement[:, :, 1].mean(axis=1), exact), 0.01)


def bar_ends(run, ratio, name):
    """How the bar of e7 ends under a load over E: complete, or with the words that it does not settle."""
    r = run(DECKS / "e7-bar" / "bar.ana", settings=[f"boundary.traction={ratio * 1e9} 0 {ratio * 1e9} 0"], name=name)
    return "does not settle" if r.scene.status.startswith("not in equilibrium") else r.scene.status


@case
def e7(run):
    """Bar in Green strain: stretch, and loss of stiffness."""
    for name, settings in (("block", []), ("mesh", ["method.model=nmm", "cover.edge=0.4"])):
        for ratio in (0.01, 0.1, 0.5, -0.1, -0.192):
            r = run(DECKS / "e7-bar" / "bar.ana", settings=[f"boundary.traction={ratio * 1e9} 0 {ratio * 1e9} 0", *settings],
                    name=f"e7-{name}{ratio:g}")
            yield Row(f"stretch at P/E = {ratio:g}, {name}", references.green_stretch(ratio),
                      1 + r.measured_points.displacement[-1, 0, 0] / 2, 1e-8)
    limit = -1 / math.sqrt(27)
    for factor, expected in ((0.999999, "complete"), (1.000005, "does not settle")):
        yield Row(f"{factor} of the limit -0.19245 E, block", expected, bar_ends(run, factor * limit, f"e7-limit{factor}"))


def moments(polygon):
    """Area and centroid of a polygon."""
    (x, y), (x1, y1) = polygon.T, np.roll(polygon, -1, axis=0).T
    twice = x * y1 - x1 * y
    return twice.sum() / 2, ((x + x1) * twice).sum() / (3 * twice.sum()), ((y + y1) * twice).sum() / (3 * twice.sum())


@case
def e9(run):
    """Column under its own weight."""
    deck, height, weight = DECKS / "e9-column" / "column.ana", 8.0, 24525.0
    r = run(deck)
    yield Row("settlement, order=1", weight * height**2 / 2e9, -r.measured_points.displacement[-1, 0, 1], 1e-6)
    depth, stress = -r.stress()[:, 1] / weight, r.stress()
    ends = np.array([(polygon[:, 1].min(), polygon[:, 1].max()) for polygon in r.polygons(0)])
    outside = np.maximum(ends[:, 0] - (height - depth), height - depth - ends[:, 1])
    yield Row("stress yy outside that of its cell, order=1", 0.0, max(outside.max(), 0.0) / height, 1e-6, 1.0)
    yield Row("largest stress xx, xy, order=1", 0.0, np.abs(stress[:, [0, 2]]).max(), 1e-6, weight * height)
    left = []
    for edge in (0.2, 0.1):
        r = run(deck, settings=["cover.order=0", f"cover.edge={edge}"], name=f"e9-order0-{edge}")
        area, _, y = np.array([moments(polygon) for polygon in r.polygons(0)]).T
        left.append(math.sqrt((area * (r.stress()[:, 1] + weight * (height - y))**2).sum() / height) / (weight * height))
    yield Row("settlement, order=0, edge 0.1", weight * height**2 / 2e9, -r.measured_points.displacement[-1, 0, 1], 1e-4)
    yield Row("order of the stress, order=0, mesh halved", 1.0, math.log2(left[0] / left[1]), 0.05)


def swing(run, amplitude, time, settings=(), name=""):
    """The pendulum of e3 let go at an amplitude (degrees): its run and its period, from passing the bottom in its first three."""
    r = run(scenes.pendulum(amplitude, time), settings=settings, name=f"e3-{amplitude}{name}")
    time, angle = r.history.time, math.radians(amplitude) + r.history.rotation[:, 0]
    passed = np.flatnonzero((angle[:-1] > 0) & (angle[1:] <= 0))[[0, 3]]
    there = time[passed] - angle[passed] * (time[passed + 1] - time[passed]) / (angle[passed + 1] - angle[passed])
    return r, (there[1] - there[0]) / 3


@case
def e3(run):
    """Pendulum."""
    small = references.pendulum_period(0.0, PENDULUM)
    for amplitude in (30, 90, 150):
        exact = references.pendulum_period(math.radians(amplitude), PENDULUM)
        r, period = swing(run, amplitude, 100 * exact)
        yield Row(f"T/T0, {amplitude} degrees", exact / small, period / small, 1e-3)
        energy = r.history.energy.kinetic + r.history.energy.strain + r.history.energy.gravity
        fall = 2500 * G * math.sqrt(0.5) * (1 - math.cos(math.radians(amplitude)))
        yield Row(f"energy lost in 100 periods, {amplitude} degrees", 0.0, (energy[0] - energy[-1]) / fall, 1e-3, 1.0)
    exact = references.pendulum_period(math.pi / 2, PENDULUM)
    off = [swing(run, 90, 4 * exact, [f"step.size={size}", "integrator.beta=0.5"], f"-{size}")[1] - exact
           for size in (0.02, 0.01)]
    yield Row("order of the period, step halved", 2.0, math.log2(off[0] / off[1]), 0.05)


def chords(count, radius):
    """Corners of a quarter of a circle, from the x axis on."""
    t = np.linspace(0, math.pi / 2, count + 1)
    return radius * np.column_stack([np.cos(t), np.sin(t)])


def pulled(count, xx, yy, radius=30.0):
    """Settings for the stress of a plate on the chords around it."""
    corners = chords(count, radius)
    lines = np.hstack([corners[:-1], corners[1:]])
    t = (np.arange(count) + 0.5) * math.pi / 2 / count
    traction = np.column_stack([xx * np.cos(t), yy * np.sin(t)] * 2)
    return [f"boundary.{name}={' '.join(map(str, rows.ravel().tolist()))}" for name, rows in (("lines", lines), ("traction", traction))]


def stress_at(r, place):
    """Stress at a place, an end or the middle of a held edge of elements of second order: a cell without area has the stress of its one point."""
    cells = [e for e, polygon in enumerate(r.polygons(0)) if np.abs(polygon - place).max() < 1e-6]
    return r.stress()[cells[0]]


@case
def e12(run):
    """Hole in a pulled plate (Kirsch): hoop stress."""
    found = {}
    for load, xx, yy in (("uniaxial", 1e6, 0.0), ("hydrostatic", 1e6, 1e6)):
        hole = references.Kirsch(xx, yy, 1e9, 0.25)
        for n in (8, 16):
            r = run(DECKS / "e12-kirsch" / "plate.ana", name=f"e12-{load}{n}", settings=[
                f"deck.geometry=plate{n}.geo", f"cover.mesh=../s1-kirsch/quarter{n}.msh", *pulled(n, xx, yy)])
            found[load, n] = stress_at(r, (1, 0))[1], stress_at(r, (0, 1))[0]
        for where, angle, hoop in zip(("side", "top"), (0.0, math.pi / 2), found[load, 16]):
            yield Row(f"hoop stress at the {where}, {load}", hole.hoop(angle), hoop, 0.03, max(abs(hole.hoop(0.0)), abs(hole.hoop(math.pi / 2))))
        exact = references.round_plate_hoop(30.0, xx, yy)
        off = [np.subtract(found[load, n], exact) for n in (8, 16)]
        for where, order in zip(("side", "top"), np.log2(off[0] / off[1])):
            yield Row(f"order at the {where}, {load}, mesh halved", 2.0, order, 0.1)


@case
def e11(run):
    """Brazilian disc: stress at the centre."""
    exact = np.array(references.brazilian_centre(1e6, 1.0))
    for order, words in ((1, "order=1"), (0, "order=0")):
        found = {}
        for n in (16, 32):
            r = run(DECKS / "e11-brazilian" / "disc.ana", name=f"e11-order{order}-{n}", settings=[
                f"deck.geometry=quarter{n}.geo", f"cover.order={order}", f"cover.edge={0.8 / n}"])
            nearest = np.argmin([np.linalg.norm(polygon.mean(axis=0)) for polygon in r.polygons(0)])
            found[n] = (stress_at(r, (0, 0)) if order == 1 else r.stress()[nearest])[:2]
        for i, component in enumerate(("xx", "yy")):
            yield Row(f"stress {component} at the centre, {words}", exact[i], found[16 if order == 1 else 32][i], 0.02)
            yield Row(f"order of the stress {component}, {words}, mesh halved", 2.0,
                      math.log2((found[16][i] - exact[i]) / (found[32][i] - exact[i])), 0.1)


@case
def e10(run):
    """Speed of a pulse in a rod."""
    for name, words, exact in (("stress", "plane stress, nu 0", math.sqrt(5e9 / 2500)),
                               ("strain", "plane strain, nu 0.25", references.wave_speeds(2500.0, 5e9, 0.25)["p"])):
        found = []
        for halved in (1, 2):
            r = run(DECKS / "e10-rod" / f"{name}.ana", name=f"e10-{name}{halved}",
                    settings=[f"cover.edge={0.5 / halved}", f"step.size={1e-4 / halved}", "step.end_time=0.018"])
            energy = r.measured_points.velocity[:, :, 0]**2
            passing = r.history.time @ energy / energy.sum(axis=0)
            found.append(10 / (passing[1] - passing[0]))
        yield Row(f"speed, {words}", exact, found[0], 0.01)
        yield Row(f"order of the speed, {words}, both halved", 2.0, math.log2((found[0] - exact) / (found[1] - exact)), 0.05)


def off_linear_field(r, strain):
    """Largest distance of displacements from a field of that strain and the rigid motion that fits best, over the largest of the field."""
    places = r.vertices(0)
    field, ones, none = places @ strain, np.ones(len(places)), np.zeros(len(places))
    rigid = np.stack([np.column_stack([ones, none]), np.column_stack([none, ones]), places @ [[0, 1], [-1, 0]]], axis=-1).reshape(-1, 3)
    left = (r.displacement() - field).ravel()
    left -= rigid @ np.linalg.lstsq(rigid, left, rcond=None)[0]
    return np.abs(left).max() / np.abs(field).max()


@case
def e8(run):
    """Patch test on meshes that a polygon cuts."""
    xx, yy, xy = 2e4, -1e4, 7e3
    strain = np.array([[xx - 0.25 * yy, 1.25 * xy], [1.25 * xy, yy - 0.25 * xx]]) / 1e9
    cuts = [[f"cover.edge={edge}", f"cover.angle={angle}", f"cover.origin={x} {y}"]
            for edge, angle, x, y in ((0.31, 3, 0.12, 0.47), (0.5, 10, 0.1, 0.2), (0.76, 57, 0.14, 0.95), (1.17, 43, 0.54, 0.28))]
    cuts.append(["cover.mesh=../s1-kirsch/quarter8.msh"])
    for order in (0, 1):
        runs = [run(DECKS / "e8-patch" / "patch.ana", settings=[*cut, f"cover.order={order}"], name=f"e8-order{order}-{i}")
                for i, cut in enumerate(cuts)]
        yield Row(f"largest distance from the field, order={order}", 0.0, max(off_linear_field(r, strain) for r in runs), 1e-10, 1.0)
        off = max(np.abs(r.stress() - [xx, yy, xy]).max() for r in runs)
        yield Row(f"largest error of the stress, order={order}", 0.0, off, 1e-10, xx)


@case
def e2(run):
    """Free spin."""
    deck, spin = DECKS / "e2-spin" / "spin.ana", 2 * math.pi
    for name, turns, settings in (("block", 1000, []), ("NMM block", 1000, ["method.model=nmm"]),
                                  ("mesh", 100, ["method.model=nmm", "cover.edge=0.4"])):
        r = run(deck, settings=[f"step.end_time={turns}", *settings], name=f"e2-{name.replace(' ', '-')}")
        time, angle, area = (of_steps[99::100] for of_steps in (r.history.time, r.history.rotation[:, 0], r.history.area))
        rate = np.diff(angle) / np.diff(time)
        yield Row(f"area less that of turn 1, {name}, {turns} turns", 0.0, np.abs(area / area[0] - 1).max(), 1e-10, 1.0)
        yield Row(f"rate less that of turn 2, {name}, {turns} turns", 0.0, np.abs(rate / rate[0] - 1).max(), 1e-10, 1.0)
        yield Row(f"growth by the spin, {name}", 0.75 * 2500 * spin**2 / (6 * 1e10), area[0] - 1, 1e-4)
    off = [run(deck, settings=["step.end_time=10", f"step.size={size}"], name=f"e2-{size}").history.rotation[-1, 0] - 10 * spin
           for size in (0.02, 0.01)]
    yield Row("order of the angle, step halved", 2.0, math.log2(off[0] / off[1]), 0.05)
    r = run(deck, settings=["method.strain=small", "step.end_time=1"], name="e2-small")
    yield Row("area after a turn, small strain", (1 + (0.01 * spin)**2)**100, r.history.area[-1], 1e-10)


@case
def e5(run):
    """The elastica: a slender cantilever in one load step."""
    for load in (1, 2, 5, 10):
        traction = load * 1e9 * 0.02**2 / 12  # P over the height, P = load EI, EI = E h^3/12
        r = run(DECKS / "e5-elastica" / "beam.ana", settings=[f"boundary.traction=0 {-traction} 0 {-traction}"], name=f"e5-{load}")
        for words, exact, found in zip(("way back", "deflection"), references.elastica(load), -r.measured_points.displacement[-1].mean(axis=0)):
            yield Row(f"{words}, P L^2/EI = {load}", exact, found, 0.01)
