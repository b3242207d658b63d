"""Shapes of a map: lines, points, arcs and splines, which affine maps leave of their kind, and the chords of curves."""
import dataclasses
import math

import numpy as np

from ..errors import ScreeError

MOST_HALVINGS = 64      # of a spline


class MapError(ScreeError):
    """One line for the user."""


@dataclasses.dataclass
class Shape:
    """A line, curve or point by rows of x y z w (directions have w = 0), which affine maps leave of its kind."""
    rows: np.ndarray

    def moved(self, matrix):
        """The shape under a map of rows. A sum in this order, not a product of matrices: equal rows stay equal to the bit."""
        return dataclasses.replace(self, rows=sum(self.rows[:, [k]] * matrix[k] for k in range(4)))

    def vertices(self, sagitta):
        """Places x y of a chain of chords nowhere farther than the sagitta from the curve."""
        return self.rows[:, :2]

    def outline(self):
        """Places that reach about as far as the curve."""
        return self.vertices(math.inf)

    def in_plane(self, plane):
        """The shape with the coordinates of a plane, as "xz", in front, and the third after them."""
        order = ["xyz".index(axis) for axis in sorted("xyz", key=(plane + "xyz").index)]
        return dataclasses.replace(self, rows=self.rows[:, [*order, 3]])


class Line(Shape):
    """Rows: the ends."""


class Point(Shape):
    """Row: the place."""


@dataclasses.dataclass
class Arc(Shape):
    """Of an ellipse: centre + u cos t + v sin t, t from 0 to the sweep. Rows: first and last place, u, v."""
    sweep: float

    def vertices(self, sagitta):
        """Equal steps h of t: a chord is off by (1 - cos h/2) times a half diameter, its largest being that of u and v.
        Places are first + u (cos t - 1) + v sin t, which keeps its digits where the radius is large."""
        first, last, u, v = self.rows[:, :2]
        radius = np.linalg.norm([u, v], 2)
        step = 4 * math.asin(math.sqrt(min(1.0, sagitta / (2 * radius)))) if radius > 0 else math.tau
        count = max(math.ceil(abs(self.sweep) / step), math.ceil(abs(self.sweep) / (math.pi / 2) - 1e-9))
        t = self.sweep * np.arange(1, count)[:, None] / count
        return np.vstack([first, first - 2 * np.sin(t / 2)**2 * u + np.sin(t) * v, last])


@dataclasses.dataclass
class Spline(Shape):
    """Rational Bezier curves end to end. Rows: w x, w y, w z, w of the control points, `order` for each curve."""
    order: int

    def vertices(self, sagitta):
        """By halving: a curve lies within its control points, so they bound its distance from the chord."""
        curves = self.rows.reshape(-1, self.order, 4)
        return np.vstack([curves[0, :1, :2] / curves[0, :1, 3:]] + [chords(curve, sagitta) for curve in curves])

    def outline(self):
        """The control points."""
        return self.rows[:, :2] / self.rows[:, 3:]


def chords(curve, sagitta, halvings=0):
    """Ends of the chords of a Bezier curve. A halving leaves a quarter of the distance, but where weights differ by many powers."""
    if halvings > MOST_HALVINGS:
        raise MapError("expected splines that chords can follow, found one whose weights or coordinates differ by too many powers of ten")
    places = curve[:, :2] / curve[:, 3:]
    away, chord = places - places[0], places[-1] - places[0]
    share = np.clip(away @ chord / (chord @ chord), 0, 1) if chord @ chord > 0 else np.zeros(len(curve))
    if np.hypot(*(away - share[:, None] * chord).T).max() <= sagitta:
        return places[-1:]
    left, right = [curve[0]], [curve[-1]]
    while len(curve) > 1:
        curve = (curve[1:] + curve[:-1]) / 2
        left.append(curve[0])
        right.append(curve[-1])
    return np.vstack([chords(np.array(half), sagitta, halvings + 1) for half in (left, right[::-1])])


def rows_of(places, directions=()):
    """Rows of places and directions."""
    return np.array([[*place, 1.0] for place in places] + [[*way, 0.0] for way in directions])
