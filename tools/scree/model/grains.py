"""Grains of rock: cells of a Laguerre tessellation in any polygon, whole or cut to triangles, with minerals by share.

A Laguerre tessellation (a power diagram) of points with equal weights is that of Voronoi. Weights make grains of different size
(Fan, Wu, Zhang, Li 2004, J. Phys. D 37, 1797). Points move to the middles of their cells, which makes grains compact (Lloyd 1982).
"""
from __future__ import annotations

import collections
import dataclasses
import math
import random
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.spatial import ConvexHull, cKDTree
from shapely.geometry import MultiPolygon, Polygon
from shapely.geometry import Point as PointInPlane

from ..errors import ModelError
from .geometry import Place, area_of
from .words import Points, number, one_of, places, whole

KINDS = ("voronoi", "trigon")
GRADED_ROUNDS = 30  # in which graded grains come to their sizes
SAME = 1e-9  # of the size: corners nearer to each other are one
OF_A_CELL = 5.5  # triangles of a cell on the mean: 6 corners by Euler's formula, less what the outline and short sides take
LIMIT = 200_000  # grains


@dataclasses.dataclass
class Grains:
    """Grains that fill a polygon without gaps: `corners` (n, 2), those of each grain by number, counter-clockwise, and its mineral."""

    corners: np.ndarray
    grain: list[list[int]]
    minerals: list[str]

    def polygon(self, i: int) -> np.ndarray:
        """Corners of a grain (n, 2)."""
        return self.corners[self.grain[i]]

    def areas(self) -> np.ndarray:
        """Area of each grain (n)."""
        return np.array([area_of([(float(x), float(y)) for x, y in self.polygon(i)]) for i in range(len(self.grain))])

    def neighbours(self) -> dict[tuple[int, int], int]:
        """The grain to the left of each side, by the numbers of its two corners."""
        return {(a, b): i for i, own in enumerate(self.grain) for a, b in zip(own, own[1:] + own[:1])}


def grains_in(outline: Points, size: float, kind: str = "voronoi", grading: float = 0, relax: int = 10, least: float = 0.2,
              minerals: Mapping[str, float] | None = None, seed: int = 1) -> Grains:
    """Grains in a polygon.

    `size` is the side of a square with the mean area of a grain. `grading` is the standard deviation of such sizes over their mean: 0 of
    even grains. `kind` is voronoi, or trigon: each cell is cut to triangles that meet in its middle. No side of a cell is shorter than
    `least` times the size of the cells, but sides of the outline that are. `minerals` has shares of the area by name, which are met within
    half a grain. ModelError where an argument is wrong.
    """
    corners = places(outline, "grains(outline=)", 3)
    if area_of(corners) < 0:
        corners.reverse()
    shape = Polygon(corners)
    number(size, "grains(size=)", above=0)
    one_of(kind, KINDS, "grains(kind=)")
    number(grading, "grains(grading=)", least=0, most=1)
    number(least, "grains(least=)", least=0, most=0.5)
    whole(relax, "grains(relax=)", 0)
    shares = {name: number(share, f"grains(minerals={name!r})", above=0) for name, share in (minerals or {"": 1.0}).items()}
    if not shape.is_valid:
        raise ModelError("grains(outline=): expected a polygon that does not cross itself")
    own_size = size * math.sqrt(OF_A_CELL) if kind == "trigon" else size
    n = round(shape.area / own_size ** 2)
    if not 1 <= n <= LIMIT:
        raise ModelError(f"grains(size=): expected 1 to {LIMIT} grains, found {n}")
    chance = random.Random(whole(seed, "grains(seed=)", 0))
    found = joined(*numbered(cells(shape, n, grading, relax, chance), own_size), corners, least * math.sqrt(shape.area / n))
    grains = Grains(*(found if kind == "voronoi" else cut_to_triangles(*found)), [])
    grains.minerals = shared_out(grains.areas(), shares, chance)
    return grains


def cells(shape: Polygon, n: int, grading: float, relax: int, chance: random.Random) -> list[Polygon]:
    """Relaxed cells of so many points in a shape."""
    x1, y1, x2, y2 = shape.bounds
    points: list[Place] = []
    while len(points) < n:
        tried = chance.uniform(x1, x2), chance.uniform(y1, y2)
        if holds(shape, tried):
            points.append(tried)
    wanted = np.exp(np.array([chance.gauss(0, 1) for _ in points]) * math.sqrt(math.log1p(grading ** 2)))
    wanted = wanted ** 2 * shape.area / np.sum(wanted ** 2)  # area of each cell
    place, weight = np.array(points), wanted / math.pi * (grading > 0)
    found = clipped_cells(shape, place, weight)
    for _ in range(max(relax, GRADED_ROUNDS) if grading > 0 else relax):
        middles = [own if cell is None else cell.centroid.coords[0] for own, cell in zip(place, found)]
        place = np.array([middle if holds(shape, middle) else own for own, middle in zip(place, middles)])
        if grading > 0:  # half of what the area of each lacks, as that of a circle
            weight = weight + 0.5 / math.pi * (wanted - [0.0 if cell is None else cell.area for cell in found])
            weight -= weight.min()
        found = clipped_cells(shape, place, weight)
    return whole_cells(found)


def holds(shape: Polygon, place: Place | np.ndarray) -> bool:
    """Whether a place is inside a shape."""
    return shape.contains(PointInPlane(place))


def clipped_cells(shape: Polygon, place: np.ndarray, weight: np.ndarray) -> list:
    """The part of each cell in a shape, or None where a cell is empty. The cells of four points far away close the others."""
    x1, y1, x2, y2 = shape.bounds
    centre, far = np.array([(x1 + x2) / 2, (y1 + y2) / 2]), 10 * max(x2 - x1, y2 - y1)
    p = np.vstack([place - centre, far * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])])
    w = np.concatenate([weight, np.zeros(4)])
    hull = ConvexHull(np.column_stack([p, (p ** 2).sum(1) - w]), qhull_options="Qt")
    lower = hull.equations[:, 2] < 0
    middle = hull.equations[lower][:, :2] / (-2 * hull.equations[lower][:, 2:3])  # where powers of three points are equal
    around = collections.defaultdict(list)
    for corner, triangle in zip(middle, hull.simplices[lower]):
        for i in triangle:
            around[i].append(corner)
    found: list = []
    for i in range(len(place)):
        corners = np.array(around.get(i, []))
        if len(corners) < 3:  # noqa: PLR2004  a polygon
            found.append(None)
            continue
        inside = corners.mean(axis=0)
        corners = corners[np.argsort(np.arctan2(corners[:, 1] - inside[1], corners[:, 0] - inside[0]))]
        cell = Polygon(corners + centre).buffer(0).intersection(shape)
        found.append(cell if cell.area > 0 else None)
    return found


def whole_cells(cells: list) -> list[Polygon]:
    """Cells in one piece each: a piece that the outline cuts off, such as across a notch, joins the neighbour with the longest common side."""
    pieces = [[one for one in (cell.geoms if isinstance(cell, MultiPolygon) else [cell]) if one.geom_type == "Polygon" and one.area > 0]
              for cell in cells if cell is not None]
    kept = [max(own, key=lambda one: one.area) for own in pieces]
    for piece in [one for own, main in zip(pieces, kept) for one in own if one is not main]:
        common = [piece.buffer(0).intersection(other).length for other in kept]
        k = int(np.argmax(common))
        joint = kept[k].union(piece)
        if joint.geom_type == "Polygon":
            kept[k] = joint
        else:
            kept.append(piece)
    return kept


def numbered(cells: Sequence[Polygon], size: float) -> tuple[np.ndarray, list[list[int]]]:
    """Corners of cells, each once, and the cells by their numbers. A corner of one cell on the side of another is a corner of both."""
    rings = [np.array(cell.exterior.coords)[:-1][::1 if cell.exterior.is_ccw else -1] for cell in cells]
    all_of_them = np.vstack(rings)
    tree = cKDTree(all_of_them)
    number = np.arange(len(all_of_them))
    for a, b in sorted(tree.query_pairs(SAME * size)):
        number[b] = min(number[b], number[a])
    for i in range(len(number)):
        number[i] = number[number[i]]
    used, number = np.unique(number, return_inverse=True)
    corners = all_of_them[used]
    ends = np.cumsum([0, *map(len, rings)])
    found = []
    near = cKDTree(corners)
    for begin, end in zip(ends, ends[1:]):
        own = [int(i) for k, i in enumerate(number[begin:end]) if i != number[begin:end][k - 1]]
        found.append([i for a, b in zip(own, own[1:] + own[:1]) for i in [a, *between(corners, near, a, b, SAME * size)]])
    return corners, found


def between(corners: np.ndarray, near: cKDTree, a: int, b: int, close: float) -> list[int]:
    """Corners that lie on a side between its ends, in their order."""
    p, q = corners[a], corners[b]
    length = np.linalg.norm(q - p)
    on = []
    for i in near.query_ball_point((p + q) / 2, length / 2):
        if i in (a, b):
            continue
        along, across = np.dot(corners[i] - p, q - p) / length, np.cross(q - p, corners[i] - p) / length
        if abs(across) < close and close < along < length - close:
            on.append((along, int(i)))
    return [i for _, i in sorted(on)]


def joined(corners: np.ndarray, cells: list[list[int]], outline: Sequence[Place], least: float) -> tuple[np.ndarray, list[list[int]]]:
    """Cells whose sides are at least so long: the two ends of a shorter side become one corner, from the shortest on.

    Corners of the outline stay, and those on its sides stay there. A cell of which two corners are left goes. A side stays short where one
    end cannot leave its side of the outline, or where a cell would fold.
    """
    corners, root = corners.copy(), list(range(len(corners)))
    sides = sides_of(corners, outline, SAME * least)
    at = collections.defaultdict(set)  # cells at each corner
    for k, cell in enumerate(cells):
        for i in cell:
            at[i].add(k)

    def top(i):
        while root[i] != i:
            root[i] = root[root[i]]
            i = root[i]
        return i

    def ring(cell):
        own = [top(i) for i in cell]
        return [i for i, before in zip(own, own[-1:] + own[:-1]) if i != before]

    def is_sound(own):
        return len(set(own)) < 3 or (len(set(own)) == len(own) and area_of(corners[own].tolist()) > 0)  # noqa: PLR2004  corners of a triangle

    again = True
    while again:
        again = False
        pairs = {tuple(sorted(pair)) for own in map(ring, cells) for pair in zip(own, own[1:] + own[:1])}
        for _, i, j in sorted((math.dist(corners[i], corners[j]), i, j) for i, j in pairs if i != j):
            a, b = sorted((top(i), top(j)), key=lambda one: -len(sides[one]))
            if a == b or math.dist(corners[a], corners[b]) >= least or not sides[b] <= sides[a]:
                continue
            before = corners[a].copy()
            if sides[a] == sides[b]:
                corners[a] = (corners[a] + corners[b]) / 2
            root[b] = a
            if all(is_sound(ring(cells[k])) for k in at[a] | at[b]):
                at[a] |= at[b]
                again = True
            else:
                root[b], corners[a] = b, before
    kept = [own for own in map(ring, cells) if len(set(own)) > 2]  # noqa: PLR2004
    used = sorted({i for own in kept for i in own})
    new = {i: k for k, i in enumerate(used)}
    return corners[used], [[new[i] for i in own] for own in kept]


def sides_of(corners: np.ndarray, outline: Sequence[Place], close: float) -> list[frozenset[int]]:
    """The sides of the outline that each corner lies on. It is put exactly onto a corner of the outline, or onto a level or upright side."""
    found: list[set[int]] = [set() for _ in corners]
    for k, (p, q) in enumerate(zip(np.array(outline), np.roll(outline, -1, axis=0))):
        length = np.linalg.norm(q - p)
        along = (corners - p) @ (q - p) / length
        across = (corners - p) @ np.array([p[1] - q[1], q[0] - p[0]]) / length
        for i in np.flatnonzero((np.abs(across) < close) & (along > -close) & (along < length + close)):
            found[i].add(k)
            end = next((end for end in (p, q) if np.linalg.norm(corners[i] - end) < close), None)
            if end is not None:
                corners[i] = end
            else:
                corners[i, p == q] = p[p == q]
    return [frozenset(one) for one in found]


def cut_to_triangles(corners: np.ndarray, cells: list[list[int]]) -> tuple[np.ndarray, list[list[int]]]:
    """Each cell as triangles that meet in its middle; those of a hollow cell meet in one of its corners."""
    places, found = list(corners), []
    for own in cells:
        around = np.array([places[i] for i in own])
        if len(own) == 3:  # noqa: PLR2004  a triangle
            found.append(own)
            continue
        middle = np.array(Polygon(around).centroid.coords[0])
        fans = [[[a, b, len(places)] for a, b in zip(own, own[1:] + own[:1])],
                *([[a, b, one] for a, b in zip(own, own[1:] + own[:1]) if one not in (a, b)] for one in own)]
        places.append(middle)
        fan = next((fan for fan in fans if all(area_of([places[i] for i in one]) > 0 for one in fan)), [own])
        if fan is not fans[0]:
            places.pop()
        found += fan
    return np.array(places), found


def shared_out(areas: np.ndarray, shares: Mapping[str, float], chance: random.Random) -> list[str]:
    """A mineral for each grain, drawn in a random order: the one that lacks most of its share of the area."""
    lacking = {name: share / sum(shares.values()) * areas.sum() for name, share in shares.items()}
    found = [""] * len(areas)
    for i in chance.sample(range(len(areas)), len(areas)):
        found[i] = max(lacking, key=lambda name: lacking[name])
        lacking[found[i]] -= areas[i]
    return found
