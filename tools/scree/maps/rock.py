"""The rock of a drawing: what a window or polygon clips from it, without its tunnels, as lines of a geometry deck.

One rule, as of `scree joints` (doc/joint-sets.md): a line is split wherever it meets an outline, and the places beside the middle of a
piece tell whether there is rock. A piece of an outline with rock on one side bounds the rock, a piece of a joint with rock on both
lies in it. Lines that no outline meets keep their coordinates to the bit.

Needs Debian's python3-numpy, and python3-shapely where there are boundary lines or tunnels.
"""
import numpy as np

NEAR = 2e-9   # of the extent: what is closer touches
ASIDE = 2e-8  # of the extent: distance of the places that tell whether there is rock beside a line


def sides_between(corners):
    """The sides of a closed polygon, rows x1 y1 x2 y2."""
    corners = np.array(corners, float)
    return np.hstack([corners, np.roll(corners, -1, axis=0)])


def is_simple(corners):
    """Whether the sides of a polygon meet at its corners alone, and enclose something."""
    sides = sides_between(corners)
    size = np.ptp(sides[:, :2], axis=0).max()
    x, y = (sides[:, :2] - sides[0, :2]).T
    if not abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) > NEAR * size**2:
        return False

    def left(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    for i, (a, b) in enumerate(sides.reshape(-1, 2, 2)):
        if not (a != b).any() or not left(sides[i - 1, :2], a, b) and (a - sides[i - 1, :2]) @ (b - a) < 0:
            return False
        for j in range(i + 2, len(sides) - (i == 0)):
            c, d = sides[j].reshape(2, 2)
            if left(a, b, c) * left(a, b, d) <= 0 and left(c, d, a) * left(c, d, b) <= 0:
                return False
    return True


def holds(sides, places):
    """Whether closed outlines hold places (n, 2): by how often a ray to the left meets them."""
    x, y = places[:, :1], places[:, 1:]
    x1, y1, x2, y2 = sides.T
    with np.errstate(divide="ignore", invalid="ignore"):
        left = x1 + (y - y1) / (y2 - y1) * (x2 - x1) < x
    return ((((y1 > y) != (y2 > y)) & left).sum(1) % 2).astype(bool)


class Rock:
    """What is left: within the clip (corners of a polygon, None: everything), within the closed parts of the boundary lines (where
    there are any) that no hole point takes out, and outside of the tunnels."""

    def __init__(self, clip, tunnels, boundary, holes):
        if tunnels or boundary:
            from . import outlines  # here, as it needs shapely
        self.clip = None if clip is None else sides_between(clip)
        self.tunnels = [outlines.sides_of(tunnel) for tunnel in tunnels]
        self.sides = np.vstack([*([] if clip is None else [self.clip]), *self.tunnels])
        everything = np.vstack([self.sides.reshape(-1, 2), *(np.array(line[:4]).reshape(2, 2) for line in boundary)])
        self.extent = np.ptp(everything, axis=0).max()
        self.inside, self.opened, self.encloses, self.domain = self.clip, [], False, None
        if tunnels or boundary:
            self.bound(outlines, clip, tunnels, boundary, np.array(holes).reshape(-1, 2))

    def bound(self, outlines, clip, tunnels, boundary, holes):
        """Takes what boundary lines enclose, and what tunnels cut out."""
        faces = outlines.faces_of(boundary)
        taken = [holds(outlines.sides_of(face), holes).any() for face in faces]
        self.encloses = bool(faces)
        window = None if clip is None else outlines.Polygon(clip)
        self.domain = outlines.unary_union([face for face, out in zip(faces, taken) if not out]) if faces else None
        if window:
            self.domain = window if self.domain is None else self.domain.intersection(window)
        self.cut_out = outlines.unary_union(tunnels)
        self.inside = None if self.domain is None else outlines.sides_of(self.domain)
        self.opened = [outlines.sides_of(face) for face, out in zip(faces, taken) if out and window and
                       (not face.within(window) or face.intersection(window.boundary).length > NEAR * self.extent)]

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
        if not self.tunnels:
            return []
        from .outlines import polygons_of  # here, as it needs shapely
        left = self.cut_out if self.domain is None else self.cut_out.intersection(self.domain)
        touching = NEAR * self.extent
        return [list(part.representative_point().coords[0]) for part in polygons_of(left)
                if self.domain is None or part.boundary.intersection(self.domain.boundary).length <= touching]
