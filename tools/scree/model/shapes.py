"""Shapes of a model: arcs, bricks, arches and Voronoi grains, as lists of places."""
from __future__ import annotations

import math
import random
from collections.abc import Iterator

from .geometry import Place, tidied
from .words import Point, number, vector, whole

FULL = 360.0
# Rings of neighbours on the lattice that may bound a grain. A place is at most (3^-1/2 + 1/2) size from a point, so points of neighbours are
# at most 2.16 size apart, and their places on the lattice 3.16; four rows are 3.46.
REACH = 4


def arc(centre: Point, radius: float, start: float = 0, end: float = FULL, sides: int = 24) -> list[Place]:
    """Places along an arc, from one angle to another in degrees counter-clockwise from x; of a full circle the last is left out.

    They serve as corners of rock, openings and excavations, or as points of joints, supports and loads.
    """
    x, y = vector(centre, "arc(centre=)")
    number(radius, "arc(radius=)", above=0)
    number(start, "arc(start=)")
    number(end, "arc(end=)")
    n = whole(sides, "arc(sides=)", 1)
    angles = [math.radians(start + (end - start) * i / n) for i in range(n if end - start == FULL else n + 1)]
    return tidied([(x + radius * math.cos(angle), y + radius * math.sin(angle)) for angle in angles])


def brick_courses(corner: Place, columns: int, courses: int, width: float, height: float) -> Iterator[list[Place]]:
    """Corners of the bricks of a wall in running bond, course by course from below."""
    x, y = corner
    for course in range(courses):
        ends = [0.0, *(i + 0.5 for i in range(columns)), float(columns)] if course % 2 else [float(i) for i in range(columns + 1)]
        low, high = y + course * height, y + (course + 1) * height
        for a, b in zip(ends, ends[1:]):
            yield tidied([(x + a * width, low), (x + b * width, low), (x + b * width, high), (x + a * width, high)])


def stones_of_arch(centre: Place, radius: float, thickness: float, stones: int, start: float, end: float) -> Iterator[list[Place]]:
    """Corners of the stones of an arch, counter-clockwise along it."""
    inner = arc(centre, radius, start, end, stones)
    outer = arc(centre, radius + thickness, start, end, stones)
    inner, outer = (inner + inner[:1], outer + outer[:1]) if end - start == FULL else (inner, outer)
    for i in range(stones):
        yield [inner[i], outer[i], outer[i + 1], inner[i + 1]]


def voronoi_lines(polygons: list[list[Place]], size: float, randomness: float, seed: int) -> list[tuple[Place, Place]]:
    """Sides between the cells of Voronoi of points on a triangular lattice, moved at random by up to half their distance.

    A cell is cut from a box by the bisectors with the points near it.
    """
    chance = random.Random(seed)
    xs, ys = zip(*(place for corners in polygons for place in corners))
    rise = size * math.sqrt(3) / 2
    columns, rows = (math.ceil((max(v) - min(v)) / step) + 2 * REACH + 1 for v, step in ((xs, size), (ys, rise)))
    points = {}
    for i in range(rows):
        for k in range(columns):
            away, angle = randomness * size / 2 * math.sqrt(chance.random()), 2 * math.pi * chance.random()
            points[i, k] = (min(xs) + (k - REACH + 0.5 * (i % 2)) * size + away * math.cos(angle),
                            min(ys) + (i - REACH) * rise + away * math.sin(angle))
    lines: list = []
    for (i, k), own in points.items():
        near = [(i + a, k + b) for a in range(-REACH, REACH + 1) for b in range(-REACH, REACH + 1) if (a, b) != (0, 0)]
        reach = REACH * size
        cell = [((own[0] + a * reach, own[1] + b * reach), None) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        for other in sorted((one for one in near if one in points), key=lambda one: math.dist(points[one], own)):
            cell = cut_by_bisector(cell, own, points[other], other)
        for (p, beyond), (q, _) in zip(cell, cell[1:] + cell[:1]):
            if beyond is not None and (i, k) < beyond and p != q:
                lines.append(tuple(tidied([p, q])))
    return lines


def cut_by_bisector(cell, own, other, name):
    """The part of a convex cell that is nearer to its point than to another; each corner has the name of what bounds the side after it."""
    nx, ny = other[0] - own[0], other[1] - own[1]
    limit = ((other[0] ** 2 - own[0] ** 2) + (other[1] ** 2 - own[1] ** 2)) / 2
    beyond = [nx * x + ny * y - limit for (x, y), _ in cell]
    if max(beyond) <= 0:
        return cell
    found = []
    for i, ((x1, y1), side) in enumerate(cell):
        (x2, y2), _ = cell[(i + 1) % len(cell)]
        a, b = beyond[i], beyond[(i + 1) % len(cell)]
        share = a / (a - b) if (a > 0) != (b > 0) else 0.0
        crossing = (x1 + share * (x2 - x1), y1 + share * (y2 - y1))
        if a <= 0:
            found.append(((x1, y1), side))
            if b > 0:
                found.append((crossing, name))
        elif b <= 0:
            found.append((crossing, side))
    return found
