"""Entities of a DXF drawing as shapes of a map."""
import math

import ezdxf
import numpy as np
from ezdxf.math import Vec3

from .shapes import Arc, Line, Point, Spline, rows_of

STRAIGHT = 1e-12        # largest bulge of a line
SPLINE_FRAME_VERTEX = 16


def direction(degrees):
    """Cosine and sine, exact at quarter turns."""
    quarter, rest = divmod(degrees, 90)
    c, s = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    return ((c, s), (-s, c), (-c, -s), (s, -c))[int(quarter) % 4]


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
