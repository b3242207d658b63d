"""Outlines of a map: what lines enclose, where they do not close, and the polygons that they make.

Needs Debian's python3-numpy and python3-shapely.
"""
import collections
import itertools
import math

import numpy as np
from shapely.geometry import LineString, Point, Polygon
from shapely.ops import polygonize, polygonize_full, unary_union

from .rock import NEAR, sides_between


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
    return np.vstack([sides_between(ring[:-1]) for ring in rings]) if rings else np.empty((0, 4))


def faces_of(lines):
    """The polygons between lines x1 y1 x2 y2."""
    return list(polygonize(unary_union([LineString([line[:2], line[2:4]]) for line in lines]))) if lines else []
