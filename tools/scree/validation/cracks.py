"""Cases of cracks: stress intensity, growth by it, and where cracks begin."""
import math

import numpy as np

from .cases import DECKS, Row, case
from .references import CRACKS, THREE_HOLES, DoubleCantilever, kink_angle

INTENSITY, GROWTH, STRUCK = DECKS / "k1-intensity", DECKS / "k2-growth", DECKS / "k7-kalthoff"
BEGINNING, HOLES = DECKS / "k10-beginning", DECKS / "k6-three-holes"
ARMS, STRIP, OVERHANG = DECKS / "k3-cantilevers", DECKS / "k4-strip", DECKS / "k8-overhang"
ENERGY, MODULUS = {"arms": 240.0, "strip": 100.0}, 1e10 / (1 - 0.2**2)


def intensity(r):
    """K_I and the size of K_II of the tips at the end (tips, 2)."""
    return np.stack([r.history.cracks.K_I[-1], np.abs(r.history.cracks.K_II[-1])], axis=1)


def farthest(found, expected):
    """Of the tips, the value that is farthest from what is expected."""
    return found[np.argmax(np.abs(found - expected))]


@case
def k1(run):
    """Stress intensity of cracks in plates and a disc."""
    pulled, pressed = 1e3 * math.sqrt(math.pi * 0.5), 1e3 * math.sqrt(0.5 / math.pi)
    for name, words, deck, settings, scale in (
            ("centre", "crack across", "plate", [], pulled),
            ("inclined", "crack at 45 degrees", "plate", ["deck.geometry=inclined.geo"], pulled),
            ("edge", "edge crack", "edge", [], pulled),
            ("disc", "crack in a disc", "disc", [], pressed)):
        found = intensity(run(INTENSITY / f"{deck}.ana", name=f"k1-{name}", settings=settings)) / scale
        for mode, expected in enumerate(CRACKS[name]):
            if expected:
                yield Row(f"K_{'I' * (mode + 1)}, {words}", expected, farthest(found[:, mode], expected), 0.01)
    slip = 1e3 * 0.5 * (1 - math.tan(math.radians(20))) * math.sqrt(math.pi * 0.4)
    found = intensity(run(INTENSITY / "closed.ana", name="k1-closed")) / slip
    yield Row("K_II, closed crack", CRACKS["closed"][1], farthest(found[:, 1], CRACKS["closed"][1]), 0.01)
    yield Row("K_I over K_II, closed crack", 0.0, farthest(found[:, 0], 0.0) / CRACKS["closed"][1], 0.02, 1.0)


def first_kinks(r, *directions):
    """Angles of the first pieces that grow from tips, from the directions of their cracks there, degrees."""
    place = r.history.cracks.place
    moved = np.linalg.norm(place - place[0], axis=2).min(axis=1) > 1e-3
    piece = place[np.argmax(moved)] - place[0]
    along = np.array([(math.cos(t), math.sin(t)) for t in np.radians(directions)])
    cross = along[:, 0] * piece[:, 1] - along[:, 1] * piece[:, 0]
    return np.degrees(np.arctan2(cross, (along * piece).sum(axis=1)))


@case
def k2(run):
    """Cracks that grow by stress intensity: direction and load."""
    opened = 1e3 * math.sqrt(math.pi * 0.5) * np.array(CRACKS["tilted"])
    expected, hoop = kink_angle(*opened)
    found = first_kinks(run(GROWTH / "inclined.ana", name="k2-inclined"), 210, 30)
    yield Row("first kink of an inclined crack", expected, farthest(found, expected), 0.5, 1.0)
    low, high = 0.9, 1.1  # shares of the reference: a toughness at which the crack grows, and one at which it does not
    while high - low > 5e-3:
        middle = (low + high) / 2
        r = run(GROWTH / "inclined.ana", name="k2-threshold", settings=[f"cracks.toughness={middle * hoop}", "step.count=2"])
        grows = r.history.cracks.length[-1, 0] > r.history.cracks.length[0, 0]
        low, high = (middle, high) if grows else (low, middle)
    yield Row("load at which it grows", 1.0, 2 / (low + high), 0.015)
    found = first_kinks(run(GROWTH / "closed.ana", name="k2-closed"), 225, 45)
    expected = math.degrees(math.acos(1 / 3))
    yield Row("first kink of a closed crack", expected, farthest(np.abs(found), expected), 0.5, 1.0)


@case
def k3(run):
    """Crack that grows between the arms of a double cantilever."""
    for name, height, first, last in ("thick", 0.05, 0.15, 0.3), ("thin", 0.03, 0.12, 0.22):
        arms = DoubleCantilever(height, MODULUS, ENERGY["arms"])
        r = run(ARMS / f"{name}.ana", name=f"k3-{name}")
        opening = np.interp(r.history.time, [1, 60], [0.9 * arms.opening(first), arms.opening(last)])
        length = r.history.cracks.length[:, 0]
        grows = np.cumsum(np.diff(length, prepend=length[0]) > 1e-3) > 0
        for words, found, expected in ("length", length, arms.length(opening)), ("load", np.asarray(r.history.support_force), arms.load(opening)):
            yield Row(f"mean {words} as the crack grows, over that of beams, arms {1e3 * height:g} mm high", 1.0,
                      float((found / expected)[grows].mean()), 0.03)


@case
def k4(run):
    """Crack that runs through a strip between grips."""
    reference, starts = math.sqrt(ENERGY["strip"] * 0.1 / MODULUS), []
    for length in 0.2, 0.3:
        r = run(STRIP / "strip.ana", name=f"k4-{length}", settings=[f"line(6).x2={length}"])
        grown = np.diff(r.history.cracks.length[:, 0]) > 1e-3
        first = np.argmax(grown)
        starts.append(0.97 * reference + 0.06 * reference * (r.history.time[first] - 1) / 24)
        yield Row(f"opening at which it starts, over that of Griffith, {length:g} m long", 1.0, starts[-1] / reference, 0.03)
        yield Row(f"part of the later steps in which it grows, {length:g} m long", 1.0, float(grown[first:].mean()), 0.0)
    yield Row("openings of the two lengths, ratio", 1.0, starts[1] / starts[0], 0.005)


def distance_from(path, point):
    """Distance of a point from a polyline (n, xy)."""
    start, way = path[:-1], np.diff(path, axis=0)
    share = np.clip(((point - start) * way).sum(axis=1) / (way**2).sum(axis=1), 0, 1)
    return float(np.linalg.norm(start + share[:, None] * way - point, axis=1).min())


@case
def k6(run):
    """Notch of a beam with three holes that grows into one of them (Bittencourt)."""
    for notch, expected in THREE_HOLES.items():
        pieces = run(HOLES / "beam.ana", name=f"k6-{notch}", settings=[f"deck.geometry=at{notch}.geo"]).growth
        path = np.vstack([pieces.start[:1], pieces.end[()]])
        yield Row(f"farthest that its path is from the reference, notch at {notch}", 0.0,
                  max(distance_from(path, point) for point in np.array(expected)), 0.1, 1.0)
        yield Row(f"end of its path, from the centre of the middle hole, notch at {notch}", 0.25,
                  float(np.linalg.norm(path[-1] - [6, 4.75])), 0.01)


@case
def k7(run):
    """Notch in a plate that is struck, which runs (Kalthoff and Winkler)."""
    for words, angle in (("", 0), (", mesh turned by 17 degrees", 17)):
        r = run(STRUCK / "kalthoff.ana", name=f"k7-{angle}", settings=[f"cover.angle={angle}"])
        kinks = first_kinks(r, 0)
        yield Row(f"first kink{words}", 70.0, kinks[0], 5.0, 1.0)
        yield Row(f"blocks at the end{words}", 2.0, r.bodies.present[-1].sum(), 0.0)


@case
def k8(run):
    """Slab that overhangs, breaks at a notch and falls."""
    for name, thick in ("thick", 1.0), ("thin", 0.5):
        r = run(OVERHANG / f"{name}.ana", name=f"k8-{name}")
        load = r.history.time[np.argmax(np.diff(r.history.cracks.length[:, 0]) > 1e-6)]  # share of the weight, which grows in 1 s
        yield Row(f"load at which it breaks, over that of a beam, {thick:g} m thick", 1.0, load / 0.9, 0.05)
        last = r.history.time[np.flatnonzero(np.asarray(r.history.contacts).any(axis=1))[-1]]  # step with contact
        free = np.argmax(r.times > max(last, 1.0))
        part = np.argmin(r.bodies.velocity[-1, :, 1])
        time = r.times[-1] - r.times[free]
        fall = r.bodies.centroid[free, part, 1] - r.bodies.centroid[-1, part, 1] + r.bodies.velocity[free, part, 1] * time
        yield Row(f"fall of its centre beyond uniform motion, over g t^2/2, {thick:g} m thick", 1.0, fall / (5 * time**2), 1e-6)


def mean_beside_hole(radius, n=600):
    """Mean tension over the half disc of a radius at the side of a hole of radius 1, over the tension far away (Kirsch 1898)."""
    r, t = radius * np.sqrt((np.arange(n) + 0.5) / n)[:, None], math.pi * ((np.arange(n) + 0.5) / n - 0.5)
    x, y = 1 + r * np.cos(t), r * np.sin(t)
    b, angle = 1 / (x * x + y * y), np.arctan2(y, x)
    radial = (1 - b - (1 - 4 * b + 3 * b * b) * np.cos(2 * angle)) / 2
    hoop = (1 + b + (1 + 3 * b * b) * np.cos(2 * angle)) / 2
    shear = (1 + 2 * b - 3 * b * b) * np.sin(2 * angle) / 2
    return float(((radial + hoop) / 2 - (radial - hoop) / 2 * np.cos(2 * angle) + shear * np.sin(2 * angle)).mean())


def new_faces(r):
    """Ends of the edges that cracks have made in a run (edges, end, xy), at the start."""
    ends = [(a, b) for polygon, early, late in zip(r.polygons(0), *(np.split(r.joints(k), r["VTKHDF/Offsets"][1:-1]) for k in (0, -1)))
            for a, b, was, now in zip(polygon, np.roll(polygon, -1, axis=0), early, late) if was < 0 < now]
    return np.array(ends).reshape(-1, 2, 2)


def mean_at_root(length, radius, depth=1.0, weight=26e3):
    """Mean tension of a cantilever that bends under its weight, over the quarter of a disc at its root on top: that of 3 w L^2/d (1 - x/L)^2
    (1 - 2 y/d), with y from the top down."""
    first, across = 4 * radius / (3 * math.pi), radius**2 / (2 * math.pi)  # means of x and of y, and of x y
    along = 1 - 2 * first / length + radius**2 / (4 * length**2)
    deep = first - 2 * across / length + 4 * radius**3 / (15 * math.pi * length**2)
    return 3 * weight * length**2 / depth * (along - 2 / depth * deep)


def strength_of(run, deck, expected, *settings):
    """Largest strength at which a crack begins in a deck, over one that is expected, and the faces of that crack."""
    low, high, faces = 0.9, 1.1, None
    while high - low > 5e-3 or faces is None:
        middle = (low + high) / 2
        found = new_faces(run(BEGINNING / f"{deck}.ana", name=f"k10-{deck}",
                              settings=[f"cracks.strength={middle * expected}", "step.count=2", *settings]))
        low, high, faces = (middle, high, found) if len(found) else (low, middle, faces)
    return (low + high) / 2, faces


@case
def k10(run):
    """Cracks that begin without a notch: load, place and direction."""
    length, xi = 0.3, 1 / 1.3
    share, faces = strength_of(run, "hole", 1e6 * mean_beside_hole(length))
    yield Row("load of a hole, over that of the half disc", 1.0, 1 / share, 0.03)
    yield Row("load of a hole, over that of a line (Whitney)", 1.0, (2 - xi**2 - xi**4) / (2 * (1 - xi)) / mean_beside_hole(length) / share, 0.03)
    places = faces.reshape(-1, 2)
    from_hole = np.hypot(*places.T)
    start, tip = places[np.argmin(from_hole)], places[np.argmax(from_hole)]
    yield Row("its place, degrees from the side of the hole", 0.0, math.degrees(math.atan2(start[1], abs(start[0]))), 5.0, 1.0)
    yield Row("its direction, degrees from across the load", 0.0, math.degrees(math.atan2(tip[1] - start[1], abs(tip[0] - start[0]))), 5.0, 1.0)
    share, faces = strength_of(run, "slab", 3 * 26e3 * 36 * (5 / 6) * (1 - 8 * 0.25 / (3 * math.pi)))
    yield Row("load of a slab, over that of the beam", 1.0, 1 / share, 0.05)
    yield Row("its place, from the middle of the slab, m", 0.0, faces[..., 0].mean(), 0.1, 1.0)
    for size in 4, 6:
        for edge in 0.1, 0.0625:
            share, faces = strength_of(run, "overhang", mean_at_root(size, 0.25), f"deck.geometry=overhang{size}.geo", f"cover.edge={edge}")
            words = f"overhang of {size} m, edges {edge:g} m"
            yield Row(f"load of an {words}, over that of the beam", 1.0, 1 / share, 0.05)
            places = faces.reshape(-1, 2)
            yield Row(f"place from the root, {words}, m", 0.0, places[np.argmax(places[:, 1]), 0], edge, 1.0)
    r = run(BEGINNING / "bar.ana", name="k10-bar")
    yield Row("blocks of a bar that is pulled at its strength", 2.0, r.bodies.present[-1].sum(), 0.0)
    yield Row("place of its crack, m", 1.0, new_faces(r)[..., 1].mean(), 0.1, 1.0)
