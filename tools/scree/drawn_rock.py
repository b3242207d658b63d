"""The rock of a drawing: what a window or polygon clips from it, without its tunnels, as lines of a geometry deck.

One rule, as of `scree joints` (doc/joint-sets.md): a line is split wherever it meets an outline, and the places beside the middle of a
piece tell whether there is rock. A piece of an outline with rock on one side bounds the rock, a piece of a joint with rock on both
lies in it. Lines that no outline meets keep their coordinates to the bit.

Needs Debian's python3-numpy and python3-shapely.
"""
import collections
import itertools
import math

import numpy as np
from shapely.geometry import LineString, Point, Polygon
from shapely.ops import polygonize, polygonize_full, unary_union

NEAR = 2e-9   # of the extent: what is closer touches
ASIDE = 2e-8  # of the extent: distance of the places that tell whether there is rock beside a line


class OpenOutline(Exception):
    """An end of an outline that does not close."""


def enclosed(lines):
    """What lines x1 y1 x2 y2 enclose, as one shape; raises OpenOutline with a place where one does not close."""
    faces, cuts, dangles, invalid = polygonize_full(unary_union([LineString([line[:2], line[2:4]]) for line in lines]))
    for loose in (dangles, cuts, invalid):
        if not loose.is_empty:
            raise OpenOutline("%g %g" % loose.geoms[0].coords[0])
    return unary_union(list(faces.geoms))


def networks(lines):
    """The parts of lines x1 y1 x2 y2 that hang together: for each whether it encloses something, and its places that one piece
    alone ends at."""
    pieces = unary_union([LineString([line[:2], line[2:4]]) for line in lines])
    ends = [(piece.coords[0], piece.coords[-1]) for piece in getattr(pieces, "geoms", [pieces])]
    at = collections.defaultdict(list)
    for piece, pair in enumerate(ends):
        for place in pair:
            at[place].append(piece)
    part, parts = {}, []
    for first in at:
        if first in part:
            continue
        members, to_see, n_ends = [], [first], 0
        part[first] = len(parts)
        while to_see:
            place = to_see.pop()
            members.append(place)
            n_ends += len(at[place])
            for other in itertools.chain(*(ends[piece] for piece in at[place])):
                if other not in part:
                    part[other] = len(parts)
                    to_see.append(other)
        encloses = n_ends // 2 >= len(members)  # a tree has one piece less than places
        parts.append((encloses, [place for place in members if len(at[place]) == 1]))
    return parts


def near_pairs(places, within):
    """Numbers of places, in order of x, that are at most so far apart, each pair once."""
    for a, (x, y) in enumerate(places):
        for b in range(a + 1, len(places)):
            if places[b][0] - x > within:
                break
            if math.dist(places[b], (x, y)) <= within:
                yield a, b


def least_distance(places):
    """The distance of the two places that are nearest to each other; of one alone 0."""
    return min((math.dist(a, b) for a, b in itertools.combinations(places, 2)), default=0.0)


def lies_inside(corners, place):
    """Whether a place lies in a polygon, not on its sides to rounding."""
    window = Polygon(corners)
    near = NEAR * np.ptp(np.array(corners), axis=0).max()
    return window.contains(Point(place)) and window.exterior.distance(Point(place)) > near


def loose_ends(lines):
    """Ends of outlines that enclose nothing, in order of place."""
    return sorted(end for encloses, ends in networks(lines) if not encloses for end in ends)


def joining_lines(lines, within):
    """Lines from end to end of outlines that enclose nothing, the shortest first, each end once: rows like the lines."""
    ends = loose_ends(lines)
    number = {tuple(line[k:k + 2]): line[4:] for line in lines for k in (0, 2)}
    joining, joined = [], set()
    for _, a, b in sorted((math.dist(ends[a], ends[b]), a, b) for a, b in near_pairs(ends, within)):
        if a in joined or b in joined:
            continue
        joined |= {a, b}
        joining.append([*ends[a], *ends[b], *number.get(ends[a], number.get(ends[b], []))])
    return joining


def polygons_of(shape):
    """The polygons of a shape that may have none, one or several."""
    return [part for part in getattr(shape, "geoms", [shape]) if isinstance(part, Polygon) and part.area > 0]


def rings_of(shape):
    """The closed outlines of the polygons of a shape and of their holes, (n, 2) each."""
    return [np.array(ring.coords) for part in polygons_of(shape) for ring in (part.exterior, *part.interiors)]


def sides_of(shape):
    """The sides of the polygons of a shape, rows x1 y1 x2 y2."""
    rings = rings_of(shape)
    return np.vstack([np.hstack([ring[:-1], ring[1:]]) for ring in rings]) if rings else np.empty((0, 4))


def holds(sides, places):
    """Whether closed outlines hold places (n, 2): by how often a ray to the left meets them."""
    x, y = places[:, :1], places[:, 1:]
    x1, y1, x2, y2 = sides.T
    with np.errstate(divide="ignore", invalid="ignore"):
        left = x1 + (y - y1) / (y2 - y1) * (x2 - x1) < x
    return ((((y1 > y) != (y2 > y)) & left).sum(1) % 2).astype(bool)


class Rock:
    """What is left: within the clip (a shape of shapely, None: everything), within the closed parts of the boundary lines (where
    there are any) that no hole point takes out, and outside of the tunnels."""

    def __init__(self, clip, tunnels, boundary, holes):
        self.clip, self.tunnels = sides_of(clip) if clip else None, [sides_of(tunnel) for tunnel in tunnels]
        faces = list(polygonize(unary_union([LineString([line[:2], line[2:4]]) for line in boundary]))) if boundary else []
        holes = np.array(holes).reshape(-1, 2)
        taken = [holds(sides_of(face), holes).any() for face in faces]
        kept = [face for face, out in zip(faces, taken) if not out]
        self.encloses = bool(faces)
        self.domain = unary_union(kept) if faces else None
        if clip:
            self.domain = clip if self.domain is None else self.domain.intersection(clip)
        self.cut_out = unary_union(tunnels)
        self.inside = None if self.domain is None else sides_of(self.domain)
        self.sides = np.vstack([*([self.clip] if clip else []), *self.tunnels])
        everything = np.vstack([self.sides.reshape(-1, 2), *(np.array(line[:4]).reshape(2, 2) for line in boundary)])
        self.extent = np.ptp(everything, axis=0).max()
        self.opened = [sides_of(face) for face, out in zip(faces, taken) if out and clip and
                       (not face.within(clip) or face.intersection(clip.boundary).length > NEAR * self.extent)]

    def is_left(self, places):
        """Whether places are within the clip and outside of the tunnels."""
        left = np.ones(len(places), bool) if self.clip is None else holds(self.clip, places)
        for tunnel in self.tunnels:
            left &= ~holds(tunnel, places)
        return left

    def is_rock(self, places):
        """Whether there is rock at places."""
        return self.is_left(places) & (True if self.inside is None else holds(self.inside, places))

    def split(self, line, sides):
        """The places (n, 2) at which sides split a line, its ends among them; corners of the sides are taken as they are."""
        ends = np.array(line[:4], float).reshape(2, 2)
        length = np.hypot(*(ends[1] - ends[0]))
        way = (ends[1] - ends[0]) / length
        touching = NEAR * self.extent
        a, b = sides[:, :2], sides[:, 2:]
        off_a, off_b = ((p - ends[0]) @ [-way[1], way[0]] for p in (a, b))
        on_a, on_b = ((p - ends[0]) @ way for p in (a, b))
        at = [(0.0, ends[0]), (length, ends[1])]
        for on, off, corner in ((on_a, off_a, a), (on_b, off_b, b)):
            at += list(zip(on[abs(off) <= touching], corner[abs(off) <= touching]))
        crossing = (abs(off_a) > touching) & (abs(off_b) > touching) & ((off_a > 0) != (off_b > 0))
        share = off_a[crossing] / (off_a[crossing] - off_b[crossing])
        at += list(zip(on_a[crossing] + share * (on_b - on_a)[crossing], a[crossing] + share[:, None] * (b - a)[crossing]))
        inner = sorted((item for item in at[2:] if touching < item[0] < length - touching), key=lambda item: item[0])
        places, last = [ends[0]], 0.0
        for on, place in inner:
            if on - last > touching:
                places.append(place)
                last = on
        return np.array([*places, ends[1]])

    def beside(self, places, where):
        """Whether there is rock, as `where` tells, to the left and to the right of the pieces between places: (n - 1, 2)."""
        way = np.diff(places, axis=0)
        step = ASIDE * self.extent * np.column_stack([-way[:, 1], way[:, 0]]) / np.hypot(*way.T)[:, None]
        middle = (places[1:] + places[:-1]) / 2
        return np.column_stack([where(middle + step), where(middle - step)])

    def part_of(self, line, bounds):
        """The parts of a line of the drawing that are left, as rows like it: of one that bounds the rock what has some beside it,
        of another what lies in it."""
        places = self.split(line, self.sides)
        left = self.beside(places, self.is_left)
        left = left.any(1) if bounds else left.all(1)
        if left.all():
            return [line]
        edges = np.flatnonzero(np.diff(np.concatenate([[False], left, [False]]).astype(int)))
        return [[*map(float, places[first]), *map(float, places[last]), *line[4:]] for first, last in edges.reshape(-1, 2)]

    def holds_points(self, points):
        """Whether points are within the clip, its edge included."""
        if self.clip is None or not len(points):
            return np.ones(len(points), bool)
        places, touching = np.array(points, float), NEAR * self.extent
        return np.any([holds(self.clip, places + step) for step in touching * np.array(
            [[0, 0], [1, 1], [1, -1], [-1, 1], [-1, -1]])], axis=0)

    def holds_holes(self, points):
        """Whether hole points are within the clip, and what they take out is still closed there."""
        left = self.holds_points(points)
        for face in self.opened if len(points) else ():
            left &= ~holds(face, np.array(points, float))
        return left

    def outline(self, sides):
        """The parts of the sides of the clip or of a tunnel that bound rock, as x1 y1 x2 y2."""
        all_sides = self.sides if self.inside is None else np.vstack([self.sides, self.inside])
        parts = []
        for side in sides:
            places = self.split(side, all_sides)
            bounds = self.beside(places, self.is_rock)
            parts += [[*map(float, places[k]), *map(float, places[k + 1])] for k in np.flatnonzero(bounds[:, 0] != bounds[:, 1])]
        return parts

    def hole_points(self):
        """A point in each part of the tunnels that rock closes in, where a block would be."""
        left = self.cut_out if self.domain is None else self.cut_out.intersection(self.domain)
        touching = NEAR * self.extent
        return [list(part.representative_point().coords[0]) for part in polygons_of(left)
                if self.domain is None or part.boundary.intersection(self.domain.boundary).length <= touching]
