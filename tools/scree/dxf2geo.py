"""Turns a DXF joint map into a geometry deck (doc/decks.md).

    tools/dxf2geo MAP.dxf [-o OUT.geo] [--e0 0.001] [--sagitta S] [--layer NAME=ROLE ...] [--clip X1 Y1 X2 Y2 [X3 Y3 ...]]
                  [--least-area A]

What a layer holds is told by how its name begins, in capitals or not:

    BOUNDARY    boundary lines                  MEASURED    measured points
    MATERIAL    material lines, of the block    HOLE        hole points
                material at the end of the      any other   joint lines
                name (MATERIAL_2)
    FIXED       fixed lines and points          TUNNEL      outlines of what is cut out of the rock;
    LOAD        load points                     EXCAVATION  so too
    BOLT        bolts, a line each              WATER       the water table
    STAGE_2...  outlines of what stage 2 of a run removes; they are joint lines, too

The joint material of joint and boundary lines and of tunnels is the number at the end of the layer's name (JOINT_3, 3); layers
without one get the numbers that are free, from 1, in order of name. --layer NAME=ROLE decides instead; ROLE is joint:N, boundary:N,
material:N, tunnel:N, stage:K, bolt:STIFFNESS[:STRENGTH[:PRETENSION]] (which bolts need), water, fixed, load, measured, hole or skip.

--clip takes what lies in a window, by two corners, or in a polygon, by three or more; its sides bound the rock where there is some.
What lies in tunnels is left out, and they get hole points where rock closes them in. The water table becomes the group &water at
the end of the deck, and --least-area, below which blocks join a neighbour, the group &blocks. What stages remove goes into OUT.stages, as
groups &stage for the end of the analysis deck.

Lines are LINE, LWPOLYLINE, POLYLINE, ARC, CIRCLE, ELLIPSE and SPLINE; points are POINT and, on the layers of points and of what is
fixed, the centres of CIRCLE. INSERT is exploded. Curves become chords that are nowhere farther than the sagitta from them.
The deck goes by layers in order of name, within a layer as the drawing does.

Needs Debian's python3-ezdxf and python3-numpy, and python3-shapely where something is clipped or cut out.
"""
import collections
import dataclasses
import itertools
import logging
import math
import pathlib
import re

import ezdxf
import numpy as np
from ezdxf.math import Vec3

from .arguments import beside, check_ending, ends_in_a_line, parser_for, say
from .errors import ScreeError

LINE_KINDS = ("boundary", "joint", "material", "tunnel", "stage")  # with a number each
POINT_KINDS = ("load", "measured", "hole")
NAMED_KINDS = {"boundary": "boundary", "material": "material", "fixed": "fixed", "tunnel": "tunnel", "excavation": "tunnel",
               "bolt": "bolt", "water": "water", "stage": "stage"} | {kind: kind for kind in POINT_KINDS}  # by the beginnings of names
ROLES = ("joint:N, boundary:N, material:N, tunnel:N, stage:K, bolt:STIFFNESS[:STRENGTH[:PRETENSION]], water, fixed, load, measured, "
         "hole or skip")
LARGEST_NUMBER = 2**31 - 1
FIRST_STAGE = 2         # that may remove something
DEFAULT_SAGITTA = 1e-3  # over the extent
LEAST_SAGITTA = 1e-9    # over the extent
FLAT = 1e-9             # largest z over the largest coordinate
STRAIGHT = 1e-12        # largest bulge of a line
MOST_HALVINGS = 64      # of a spline
SPLINE_FRAME_VERTEX = 16

Role = collections.namedtuple("Role", "kind number bolt", defaults=[None])  # number: of a material; bolt: e0 t0 f0 of a deck


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


def attribute(entity, name, code, default):
    """An attribute that every entity has, of those too that ezdxf does not know and only keeps."""
    if hasattr(entity, "xtags"):
        return next((tag.value for tags in entity.xtags.subclasses[:2] for tag in tags if tag.code == code), default)
    return entity.dxf.get(name, default) if entity.dxf.is_supported(name) else default


class Drawing:
    """The model space of a DXF file: what each visible layer holds, by a key that is the same in capitals or not."""

    def __init__(self, path):
        try:
            self.document = ezdxf.readfile(path)
            space = self.document.modelspace()
        except Exception as error:  # a damaged file fails anywhere in ezdxf
            reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error) or type(error).__name__
            raise MapError(f"{path}: expected a DXF file, found: {shown(reason)}") from None
        self.path = path
        self.names = {layer.dxf.name.lower(): layer.dxf.name for layer in self.document.layers}
        self.hidden = collections.Counter()          # entities by layer and why
        self.held = collections.defaultdict(list)    # kind and shapes by layer
        for layer, kind, shapes in self.walk(space):
            self.held[layer].append((kind, shapes))
        self.on_paper = sum(entity.dxftype() != "VIEWPORT" for layout in self.document.layouts
                            if layout.is_any_paperspace for entity in layout)

    def why_hidden(self, layer):
        """Whether a layer is frozen or off."""
        entry = self.document.layers.get(layer) if layer in self.document.layers else None
        return "" if entry is None else "frozen" if entry.is_frozen() else "off" if entry.is_off() else ""

    def walk(self, entities, outer=None, blocks=()):
        """Layer, kind and shapes (or why there are none) of each visible entity. Layer 0 in a block is that of its INSERT."""
        for entity in entities:
            name, kind = attribute(entity, "layer", 8, "0"), entity.dxftype()
            layer = name.lower() if name != "0" or outer is None else outer
            self.names.setdefault(layer, name)
            why = self.why_hidden(layer)
            if attribute(entity, "invisible", 60, 0):
                self.hidden[layer, "invisible"] += 1
            elif why == "frozen" or why and kind != "INSERT":  # a block whose INSERT is off shows what lies on other layers
                self.hidden[layer, why] += 1
            elif kind == "INSERT":
                yield from self.explode(entity, layer, blocks)
            else:
                yield layer, kind, shapes_of(entity)

    def explode(self, insert, layer, blocks):
        """What walk says, of an INSERT."""
        name = insert.dxf.get("name", "")
        block = insert.block() if name else None
        yield from self.walk(insert.attribs, layer, blocks)
        if block is None or block.block.is_xref:
            yield layer, "INSERT", f"INSERT of the {'missing' if block is None else 'external'} block '{shown(name)}'"
            return
        if name.lower() in blocks:
            raise MapError(f"{self.path}: expected blocks that end, found '{shown(name)}' within itself")
        for one in insert.multi_insert() if insert.mcount > 1 else [insert]:
            matrix = matrix_rows(one.matrix44())
            for inner, kind, shapes in self.walk(block, layer, (*blocks, name.lower())):
                yield inner, kind, shapes if isinstance(shapes, str) else [shape.moved(matrix) for shape in shapes]


def shown(text):
    """A text of the drawing, fit for one line."""
    return "".join(letter if letter.isprintable() else "?" for letter in str(text))


def in_order(layer):
    """Key of the order of names: 2 comes before 10."""
    return [int(part) if part.isdecimal() else part for part in re.split("([0-9]+)", layer)]


def role_by_name(name):
    """The role that a layer's name says; number 0 where it says none."""
    kind = next((kind for word, kind in NAMED_KINDS.items() if name.lower().startswith(word)), "joint")
    number = int("0" + re.search("[0-9]*$", name).group())
    return Role(kind, number if kind in LINE_KINDS and number <= LARGEST_NUMBER else 0)


def chosen_roles(words, drawing):
    """The roles that the options --layer give, by layer."""
    roles = {}
    for word in words:
        name, _, role = word.rpartition("=")
        found = re.fullmatch("(joint|boundary|material|tunnel|stage):([0-9]{1,10})|(fixed|load|measured|hole|water|skip)", role.lower())
        bolt = bolt_of(role.lower())
        if not name or not (found or bolt) or found and found[2] and not 1 <= int(found[2]) <= LARGEST_NUMBER:
            raise MapError(f"--layer: expected NAME=ROLE with ROLE one of {ROLES} (N from 1), found '{shown(word)}'")
        if name.lower() not in drawing.names:
            raise MapError(f"{drawing.path}: expected a layer of the name '{shown(name)}' (--layer), found "
                           + ", ".join(f"'{shown(drawing.names[layer])}'" for layer in sorted(drawing.names, key=in_order)))
        if name.lower() in roles:
            raise MapError(f"--layer: expected one role for the layer '{shown(name)}', found two")
        roles[name.lower()] = Role("bolt", 0, bolt) if bolt else Role(found[1] or found[3], int(found[2] or 0))
    return roles


def bolt_of(role):
    """Stiffness, strength and pretension of a role bolt:...; None where it is another, or they are no such numbers."""
    kind, *words = role.split(":")
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        return None
    whole = kind == "bolt" and 1 <= len(numbers) <= 3 and numbers[0] > 0 and all(0 <= number < math.inf for number in numbers)
    return tuple((numbers + [0.0, 0.0])[:3]) if whole else None


def wanted(role, shapes):
    """The shapes of an entity that a layer of a role takes."""
    points = [shape for shape in shapes if isinstance(shape, Point)]
    curves = [shape for shape in shapes if not isinstance(shape, Point)]
    if role.kind == "bolt":
        return curves if len(curves) == 1 and isinstance(curves[0], Line) else []
    return points if role.kind in POINT_KINDS else points or curves if role.kind == "fixed" else curves


def role_words(role):
    """What the layer of a role is for."""
    return "points" if role.kind in POINT_KINDS else "straight lines" if role.kind == "bolt" else "lines"


class Deck:
    """The geometry deck of a drawing."""

    def __init__(self, drawing, choice, e0, sagitta, clip=(), least_area=0.0):
        self.drawing, self.e0, self.least_area = drawing, e0, least_area
        self.taken = {}                        # shapes by layer, in order of name
        self.left_out = collections.Counter()  # entities by layer and what they are
        self.roles = {layer: choice.get(layer) or role_by_name(drawing.names[layer])
                      for layer in sorted(drawing.held, key=in_order)}
        for layer, role in self.roles.items():
            self.take(layer, role)
        self.number_layers()
        self.sagitta = self.choose_sagitta(sagitta)
        self.flatten()
        self.said = []                         # what clip and tunnels became
        self.outside = 0                       # lines and points that they take away
        self.removed = self.take_stages()
        if clip or self.lines["tunnel"]:
            self.take_rock(clip)
        if not self.lines["boundary"] and not self.lines["joint"]:
            raise MapError(f"{self.drawing.path}: expected joint or boundary lines"
                           + (" in the clip" if self.outside else "") + ", found none"
                           + (f" but {self.dropped} of no length" if self.dropped else "") + self.why_empty())
        self.table = self.water_table()

    def take(self, layer, role):
        """Takes the shapes of a layer."""
        taken = []
        for kind, shapes in self.drawing.held[layer] if role.kind != "skip" else ():
            some = [] if isinstance(shapes, str) else wanted(role, shapes)
            if not some:
                self.left_out[layer, shapes if isinstance(shapes, str) else f"{kind} (this layer is for {role_words(role)})"] += 1
            for shape in some:
                self.expect_flat(layer, kind, shape)
                taken.append(shape)
        if taken:
            self.taken[layer] = taken

    def expect_flat(self, layer, kind, shape):
        """Error for coordinates that are not finite, or a z."""
        where = f"{kind} on layer '{shown(self.drawing.names[layer])}'"
        if not np.isfinite(shape.rows).all():
            raise MapError(f"{self.drawing.path}: expected finite coordinates, found {where} with others")
        z = shape.rows[:, 2]
        if abs(z).max() > FLAT * abs(shape.rows[:, :2]).max():
            raise MapError(f"{self.drawing.path}: expected z = 0, found {where} with z = {z[abs(z).argmax()]:.6g}")

    def number_layers(self):
        """Gives the free numbers to the layers of joint and boundary lines and of tunnels without one."""
        for layer in self.taken:
            if self.roles[layer].kind == "bolt" and not self.roles[layer].bolt:
                name = shown(self.drawing.names[layer])
                raise MapError(f"{self.drawing.path}: expected the stiffness of bolts, "
                               f"--layer '{name}=bolt:STIFFNESS[:STRENGTH[:PRETENSION]]', found '{name}'")
        numbered = [layer for layer in self.taken if self.roles[layer].kind in LINE_KINDS]
        used = {self.roles[layer].number for layer in numbered if self.roles[layer].kind not in ("material", "stage")}
        self.free = (number for number in itertools.count(1) if number not in used)
        for layer in numbered:
            kind, number, _ = self.roles[layer]
            least = {"material": 1, "stage": FIRST_STAGE}.get(kind, 0)
            if number < least:
                name, what = shown(self.drawing.names[layer]), "block material" if kind == "material" else kind
                raise MapError(f"{self.drawing.path}: expected a {what} from {least} at the end of the layer's name or "
                               f"--layer '{name}={kind}:N', found '{name}'")
            self.roles[layer] = Role(kind, number or next(self.free))

    def choose_sagitta(self, given):
        """The sagitta that was given, or else the default of the drawing's extent: its width or height, the larger."""
        shapes = list(itertools.chain(*self.taken.values()))
        if not shapes:
            raise MapError(f"{self.drawing.path}: expected lines, found {'none' if self.drawing.held else 'an empty drawing'}"
                           + self.why_empty())
        places = np.vstack([shape.outline() for shape in shapes])
        round_off = 64 * np.finfo(float).eps * abs(places).max()
        rough = max(1e-4 * np.ptp(places, axis=0).max(), round_off)
        extent = np.ptp(np.vstack([shape.vertices(rough) for shape in shapes]), axis=0).max()
        least = max(LEAST_SAGITTA * extent, round_off)
        if given is not None and given < least:
            raise MapError(f"--sagitta: expected at least {least:.6g} for this drawing of extent {extent:.6g}, found {given:.6g}")
        return float(given or max(DEFAULT_SAGITTA * extent, least))

    def why_empty(self):
        """What was there instead of lines."""
        there = [f"{count} on the layer '{shown(self.drawing.names[layer])}', which is {why}" if why != "invisible"
                 else f"{count} invisible" for (layer, why), count in self.drawing.hidden.items()]
        there += [f"{count} {what}" for (layer, what), count in self.left_out.items()]
        return f" ({', '.join(there)})" if there else ""

    def flatten(self):
        """Lines and points of each kind, and how many of each layer."""
        self.dropped = 0
        self.lines, self.points = collections.defaultdict(list), collections.defaultdict(list)
        self.counts = {}
        for layer, shapes in self.taken.items():
            kind, number, bolt = self.roles[layer]
            before = len(self.lines[kind]), len(self.points[kind])
            for shape in shapes:
                places = shape.vertices(self.sagitta).tolist()
                if isinstance(shape, Point):
                    self.points[kind].append(places[0])
                    if kind == "fixed":  # equal ends
                        self.lines[kind].append(places[0] * 2)
                    continue
                for start, end in zip(places, places[1:]):
                    if start == end:
                        self.dropped += 1
                    else:
                        self.lines[kind].append(start + end + ([number] if number else list(bolt or ())))
            points = len(self.points[kind]) - before[1]
            self.counts[layer] = len(self.lines[kind]) - before[0] - (points if kind == "fixed" else 0), points

    def take_stages(self):
        """What each stage removes, by its number; the sides are joint lines of a material of their own."""
        if not self.lines["stage"]:
            return {}
        outlines, joint = collections.defaultdict(list), next(self.free)
        for line in self.lines["stage"]:
            outlines[line[4]].append(line)
            self.lines["joint"].append(line[:4] + [joint])
        self.said.append(f"sides of what stages remove: joint material {joint}, whose cohesion and tensile strength hold until then")
        return {number: closed(self.drawing, "what stages remove", lines) for number, lines in sorted(outlines.items())}

    def take_rock(self, clip):
        """Clips lines and points, cuts the tunnels out and adds what bounds the rock then."""
        drawn_rock = with_shapely()
        window = drawn_rock.Polygon(corners_of(clip)) if clip else None
        if clip and not (window.is_valid and window.area > 0):
            raise MapError("--clip: expected corners of a polygon whose sides meet there alone, found " + " ".join(map(repr, clip)))
        outlines = collections.defaultdict(list)
        for line in self.lines["tunnel"]:
            outlines[line[4]].append(line)
        tunnels = {number: closed(self.drawing, "tunnels", lines) for number, lines in outlines.items()}
        rock = drawn_rock.Rock(window, list(tunnels.values()), self.lines["boundary"], self.points["hole"])
        if self.lines["boundary"] and not rock.encloses:
            self.said.append("boundary lines enclose nothing: all that is clipped is rock")
        for kind in ("boundary", "joint", "material", "fixed", "bolt"):
            kept = [rock.part_of(line, kind != "joint") if kind != "bolt" and line[:2] != line[2:4]
                    else [line] if rock.holds_points([line[:2], line[2:4]]).all() else [] for line in self.lines[kind]]
            self.outside += sum(not parts for parts in kept)
            self.lines[kind] = list(itertools.chain(*kept))
        for kind in POINT_KINDS:
            left = rock.holds_holes(self.points[kind]) if kind == "hole" else rock.holds_points(self.points[kind])
            self.outside += int((~left).sum())
            self.points[kind] = [point for point, stays in zip(self.points[kind], left) if stays]
        if clip:
            sides, number = rock.outline(rock.clip), next(self.free)
            self.lines["boundary"] += [side + [number] for side in sides]
            self.said.append(f"clip: boundary, joint material {number}, {counted(len(sides), 'line')}")
        for number, tunnel in tunnels.items():
            sides = rock.outline(drawn_rock.sides_of(tunnel))
            self.lines["boundary"] += [side + [number] for side in sides]
            self.said.append(f"tunnels of joint material {number}: boundary, {counted(len(sides), 'line')}")
        holes = rock.hole_points()
        self.points["hole"] += holes
        if tunnels:
            self.said.append(f"tunnels that rock closes in: {counted(len(holes), 'hole point')}")
        if self.outside:
            self.said.append(f"left out, where no rock is left: {counted(self.outside, 'line or point', 'lines and points')}")

    def water_table(self):
        """The points of the water table, x ascending, from the lines of its layers."""
        chains = []
        for start_end in self.lines["water"]:
            start, end = start_end[:2], start_end[2:]
            if chains and chains[-1][-1] == start:
                chains[-1].append(end)
            else:
                chains.append([start, end])
        chains = sorted(chain if chain[0][0] < chain[-1][0] else chain[::-1] for chain in chains)
        places = [place for place, _ in itertools.groupby(itertools.chain(*chains))]
        for before, after in zip(places, places[1:]):
            if not after[0] > before[0]:
                raise MapError(f"{self.drawing.path}: expected a water table with one level at each x, found points at x = "
                               f"{before[0]:.6g} and, after it, {after[0]:.6g}")
        return places

    def mapping(self):
        """Lines that say what each layer became."""
        text = []
        for layer, role in self.roles.items():
            name = f"layer '{shown(self.drawing.names[layer])}': "
            if role.kind == "skip":
                text.append(f"{name}skipped, {counted(len(self.drawing.held[layer]), 'entity', 'entities')}")
            elif layer in self.counts:
                what = {"joint": f"joint material {role.number}", "boundary": f"boundary, joint material {role.number}",
                        "material": f"block material {role.number}", "tunnel": f"tunnels, joint material {role.number}",
                        "stage": f"removed by stage {role.number}",
                        "bolt": "bolts of stiffness, strength, pretension " + " ".join(map(repr, role.bolt or ())),
                        "water": "water table"}.get(role.kind, role.kind)
                lines, points = self.counts[layer]
                text.append(name + ", ".join([what] + [counted(n, one) for n, one in ((lines, "line"), (points, "point")) if n]))
        for (layer, why), count in sorted(self.drawing.hidden.items()):
            name, entities = shown(self.drawing.names[layer]), counted(count, "entity", "entities")
            text.append(f"layer '{name}'" + (f": {entities} invisible, skipped" if why == "invisible" else
                                             f" is {why}: {entities} skipped"))
        text += self.said
        if self.dropped:
            text.append(f"dropped {counted(self.dropped, 'line')} of no length")
        return text

    def warnings(self):
        """Lines that say what is lost, or will be."""
        text = [f"left out, not understood: {count} {shown(what)} on layer '{shown(self.drawing.names[layer])}'"
                for (layer, what), count in self.left_out.items()]
        if self.drawing.on_paper:
            text.append(f"left out, in paper space: {counted(self.drawing.on_paper, 'entity', 'entities')}")
        lines = np.array([line[:4] for line in self.lines["boundary"] + self.lines["joint"]])
        places = lines.reshape(-1, 2)
        width, height = np.ptp(places, axis=0)
        snap = self.e0 * 1.02 * max(height / 2, width / 2 / 1.3)  # as doc/decks.md says
        short = int((np.hypot(*(lines[:, 2:] - lines[:, :2]).T) <= snap).sum())
        if short:
            text.append(f"{counted(short, 'line')} not longer than e0 w0 = {snap:.6g}, within which ends are one point: "
                        "a smaller --e0 or a larger --sagitta keeps them apart")
        return text

    def text(self):
        """The deck."""
        lines = self.lines["boundary"] + self.lines["joint"]
        name = shown(pathlib.Path(self.drawing.path).name)
        head = [f"From {name}, chords within {self.sagitta:.6g} of the curves", *self.mapping(), *self.warnings()]
        numbers = [(repr(self.e0), "least distance of edge and node, over the size (e0)"),
                   (f"{len(lines)} {len(self.lines['boundary'])}", "lines, boundary lines"),
                   (len(self.lines["material"]), "material lines"), (len(self.lines["bolt"]), "bolts"),
                   (len(self.lines["fixed"]), "fixed lines"),
                   *((len(self.points[kind]), f"{kind} points") for kind in POINT_KINDS)]
        rows = itertools.chain(lines, *(self.lines[kind] for kind in ("material", "bolt", "fixed")),
                               *(self.points[kind] for kind in POINT_KINDS))
        return "".join([f"! {line}\n" for line in head] + [f"{number!s:<12} ! {what}\n" for number, what in numbers]
                       + [" ".join(map(repr, row)) + "\n" for row in rows] + self.groups())

    def stages(self):
        """The groups &stage that remove what is drawn to be removed, from the second to the last of them."""
        corners = {number: "  ".join(f"{x!r} {y!r}" for ring in with_shapely().rings_of(shape) for x, y in ring.tolist())
                   for number, shape in self.removed.items()}
        return "".join(f"&stage remove_inside={corners[k]} /\n" if k in corners else "&stage /\n"
                       for k in range(FIRST_STAGE, max(corners) + 1))

    def groups(self):
        """The groups of places that the deck ends in."""
        text = [f"&blocks least_area={self.least_area!r} /\n"] if self.least_area > 0 else []
        if self.table:
            text.append("&water table=" + "  ".join(f"{x!r} {y!r}" for x, y in self.table) + " /\n")
        return text


def with_shapely():
    """The module that needs shapely."""
    try:
        from . import drawn_rock
    except ImportError:
        raise MapError("expected shapely for --clip, tunnels and stages, found none: on Debian, apt-get install python3-shapely") from None
    return drawn_rock


def closed(drawing, what, lines):
    """What outlines enclose."""
    drawn_rock = with_shapely()
    try:
        return drawn_rock.enclosed(lines)
    except drawn_rock.OpenOutline as end:
        raise MapError(f"{drawing.path}: expected closed outlines of {what}, found an open one at {end}") from None


def corners_of(numbers):
    """The corners of a clip: two are those of a window."""
    x, y = numbers[::2], numbers[1::2]
    if len(x) == 2:
        x, y = [x[0], x[1], x[1], x[0]], [y[0], y[0], y[1], y[1]]
    return list(zip(x, y))


def counted(number, one, more=None):
    """A number of things."""
    return f"{number} {one if number == 1 else more or one + 's'}"


@ends_in_a_line
@np.errstate(all="ignore")  # what is not finite is refused by name
def main():
    parser = parser_for(__doc__)
    parser.add_argument("map", metavar="MAP.dxf")
    parser.add_argument("-o", "--output", metavar="OUT.geo", help="deck; default: the map with .geo, beside it")
    parser.add_argument("--e0", type=float, default=0.001, help="least distance of edge and node, over the size; default: 0.001")
    parser.add_argument("--sagitta", type=float, metavar="S",
                        help="largest distance of a chord from its curve; default: 1e-3 of the drawing's extent")
    parser.add_argument("--layer", action="append", default=[], metavar="NAME=ROLE", help="role of a layer; may be repeated")
    parser.add_argument("--clip", type=float, nargs="+", default=[], metavar="X",
                        help="x and y of two corners of a window, or of three or more of a polygon")
    parser.add_argument("--least-area", type=float, default=0.0, metavar="A", help="of a block: a smaller one joins its neighbour")
    given = parser.parse_args()
    logging.disable()  # ezdxf's; what matters of it is said here
    if not 0 <= given.e0 < 1:
        raise MapError(f"--e0: expected at least 0 and below 1, found {given.e0}")
    if given.sagitta is not None and not 0 < given.sagitta < math.inf:
        raise MapError(f"--sagitta: expected a length above 0, found {given.sagitta}")
    if given.clip and (len(given.clip) < 4 or len(given.clip) % 2 or not np.isfinite(given.clip).all()):
        raise MapError(f"--clip: expected x and y of two corners or more, found {' '.join(map(repr, given.clip))}")
    if not 0 <= given.least_area < math.inf:
        raise MapError(f"--least-area: expected an area from 0, found {given.least_area}")
    output = pathlib.Path(given.output or beside(given.map, ".geo"))
    if output.resolve() == pathlib.Path(given.map).resolve():
        raise MapError(f"{output}: expected another name than the map's for the deck (-o), found the same")
    check_ending(output, "a deck", (".geo",))
    drawing = Drawing(given.map)
    deck = Deck(drawing, chosen_roles(given.layer, drawing), given.e0, given.sagitta, given.clip, given.least_area)
    try:
        output.write_text(deck.text(), encoding="utf-8")
        if deck.removed:
            output.with_suffix(".stages").write_text(deck.stages(), encoding="utf-8")
    except OSError as error:
        raise MapError(f"{output}: cannot write the deck: {error.strerror}") from None
    for line in deck.mapping():
        print(line)
    for line in deck.warnings():
        say(f"warning: {given.map}: {line}")
    print(*([output.with_suffix(".stages")] if deck.removed else []), output, sep="\n")
    return 0
