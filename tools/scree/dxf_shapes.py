"""Entities of a DXF drawing as shapes: lines, points, arcs and splines, which affine maps leave of their kind, and the chords of curves."""
import dataclasses
import math

import ezdxf
import numpy as np
from ezdxf.math import Vec3

from .errors import ScreeError

STRAIGHT = 1e-12        # largest bulge of a line
MOST_HALVINGS = 64      # of a spline
SPLINE_FRAME_VERTEX = 16


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


def direction(degrees):
    """Cosine and sine, exact at quarter turns."""
    quarter, rest = divmod(degrees, 90)
    c, s = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    return ((c, s), (-s, c), (-c, -s), (s, -c))[int(quarter) % 4]


def rows_of(places, directions=()):
    """Rows of places and directions."""
    return np.array([[*place, 1.0] for place in places] + [[*way, 0.0] for way in directions])


def elliptic_arc(centre, major, minor, start, end):
    """From a start to an end in degrees; equal ones are a full turn, and so is a turn with an end that was rounded up."""
    sweep = end - start if 0 < end - start <= 360 * (1 + 1e-6) else (end - start) % 360
    if sweep == 0 or sweep > 360 * (1 - 1e-9):
        sweep = 360.0
    (c, s), (c_end, s_end) = direction(start), direction(end)
    u, v = major * c + minor * s, minor * c - major * s
    last = u if sweep == 360 else major * c_end + minor * s_end
    return Arc(rows_of([centre + u, centre + last], [u, v]), math.radians(sweep))


def bulged(start, end, bulge):
    """The arc between two vertices of a polyline; the bulge is the tangent of a quarter of its angle."""
    half = (end - start) / 2
    to_centre = half + Vec3(-half.y, half.x) * ((1 - bulge**2) / (2 * bulge))
    return Arc(rows_of([start, end], [-to_centre, Vec3(to_centre.y, -to_centre.x)]), 4 * math.atan(bulge))


def polyline(points, bulges, closed):
    """Lines and arcs through points."""
    following = points[1:] + points[:1] if closed else points[1:]
    return [bulged(a, b, bulge) if abs(bulge) > STRAIGHT and a != b else Line(rows_of([a, b]))
            for a, b, bulge in zip(points, following, bulges)]


def bezier_curves(spline):
    """A B-spline as Bezier curves, by its polar form. Takes any degree, weights above 0, clamped ends or not."""
    degree, knots = spline.degree, spline.knots()
    weights = np.array(spline.weights() or [1.0] * spline.count)[:, None]
    control = rows_of(spline.control_points) * weights

    def polar(span, arguments):
        level = control[span - degree: span + 1].copy()
        for r, t in enumerate(arguments, 1):
            for j in range(degree, r - 1, -1):
                low, high = knots[span - degree + j], knots[span + j - r + 1]
                level[j] = ((high - t) * level[j - 1] + (t - low) * level[j]) / (high - low)
        return level[degree]

    curves = [polar(span, [knots[span]] * (degree - k) + [knots[span + 1]] * k)
              for span in range(degree, spline.count) if knots[span] < knots[span + 1] for k in range(degree + 1)]
    return Spline(np.array(curves).reshape(-1, 4), degree + 1)


def in_world(entity, shapes):
    """Shapes in the coordinates of an entity, in those of the drawing."""
    ocs = entity.ocs()
    return [shape.moved(matrix_rows(ocs.matrix)) for shape in shapes] if ocs.transform else shapes


def matrix_rows(matrix):
    """The matrix of ezdxf, which is for rows."""
    return np.array(list(matrix.rows()))


def shapes_of(entity):
    """The shapes of an entity, or a text that says why there are none."""
    try:
        return built(entity)
    except (ezdxf.DXFError, ArithmeticError, ValueError) as error:
        return f"{entity.dxftype()} that cannot be built ({error})"


def built(entity):
    """What shapes_of says, of numbers that an entity can be built of."""
    kind, dxf = entity.dxftype(), entity.dxf
    if kind == "LINE":
        return [Line(rows_of([dxf.start, dxf.end]))]
    if kind == "POINT":
        return [Point(rows_of([dxf.location]))]
    if kind in ("ARC", "CIRCLE"):
        across, up = Vec3(abs(dxf.radius), 0), Vec3(0, abs(dxf.radius))
        if kind == "ARC":
            return in_world(entity, [elliptic_arc(dxf.center, across, up, dxf.start_angle, dxf.end_angle)])
        return in_world(entity, [elliptic_arc(dxf.center, across, up, 0, 360), Point(rows_of([dxf.center]))])
    if kind == "ELLIPSE":
        start, end = math.degrees(dxf.start_param), math.degrees(dxf.end_param)
        return [elliptic_arc(dxf.center, dxf.major_axis, entity.minor_axis, start, end)]
    if kind == "LWPOLYLINE":
        points = entity.get_points("xyb")
        made = polyline([Vec3(x, y, dxf.elevation) for x, y, _ in points], [bulge for *_, bulge in points], entity.closed)
        return in_world(entity, made) or "LWPOLYLINE of less than two vertices"
    if kind == "POLYLINE":
        if entity.is_polygon_mesh or entity.is_poly_face_mesh:
            return "POLYLINE that is a mesh"
        vertices = [vertex.dxf for vertex in entity.vertices if not vertex.dxf.flags & SPLINE_FRAME_VERTEX]
        points = [Vec3(vertex.get("location", (0, 0, 0))) for vertex in vertices]
        if entity.is_3d_polyline:
            return polyline(points, [0] * len(points), entity.is_closed) or "POLYLINE of less than two vertices"
        if dxf.hasattr("elevation"):
            points = [point.replace(z=Vec3(dxf.elevation).z) for point in points]
        made = polyline(points, [vertex.get("bulge", 0) for vertex in vertices], entity.is_closed)
        return in_world(entity, made) or "POLYLINE of less than two vertices"
    if kind == "SPLINE":
        spline = entity.construction_tool()
        if any(not weight > 0 for weight in spline.weights()):
            return "SPLINE with weights not above 0"
        curves = bezier_curves(spline)
        return [curves] if len(curves.rows) else "SPLINE whose knots do not ascend"
    return kind
