"""The geometry deck of a joint map: roles of layers, chords of curves, closed outlines, what is clipped and cut out, ends of traces."""
import collections
import itertools
import math
import pathlib

import numpy as np

from .connecting import connect
from .layers import LINE_KINDS, POINT_KINDS, Role, in_order, role_by_name, role_words, shown, wanted
from .rock import Rock, is_simple
from .shapes import MapError, Point

FIRST_STAGE = 2         # that may remove something
DEFAULT_SAGITTA = 1e-3  # over the extent
LEAST_SAGITTA = 1e-9    # over the extent
ROUND_OFF = 64 * np.finfo(float).eps  # over the largest coordinate
FLAT = 1e-9             # largest height over the largest coordinate
NODE_SHARE = 1.25       # of e0 w0: distance at which the cutter takes ends of lines for one (doc/decks.md)
MOST_PLACES = 4         # that a line names
OUTLINES = {"boundary": "boundary lines", "tunnel": "outlines of tunnels", "stage": "outlines of what stages remove"}


class Deck:
    """The geometry deck of a map. Roles of `choice` are by layer; `origin` is taken off all coordinates, those of `clip` and `fixed`
    among them; `snap` and `extend` are the lengths by which ends of joint traces are moved and extended at most."""

    def __init__(self, drawing, choice, e0, sagitta, clip=(), least_area=0.0, close=None, origin=(0.0, 0.0), snap=0.0, extend=0.0,
                 fixed=()):
        self.drawing, self.e0, self.least_area, self.origin = drawing, e0, least_area, np.array(origin, float)
        self.said = list(drawing.noted)        # what heights, gaps, clip and tunnels became
        self.taken = {}                        # shapes by layer, in order of name
        self.left_out = collections.Counter()  # entities by layer and what they are
        self.roles = {layer: choice.get(layer) or role_by_name(drawing.names[layer], layer in drawing.areas)
                      for layer in sorted(drawing.held, key=in_order)}
        for layer, role in self.roles.items():
            self.take(layer, role)
        self.number_layers()
        self.sagitta = self.choose_sagitta(sagitta)
        self.leave_out_heights()
        self.flatten()
        self.joining = []                      # lines that join ends of outlines
        window = corners_of(clip) - self.origin if clip else None
        if window is not None and not is_simple(window):
            raise MapError("--clip: expected corners of a polygon whose sides meet there alone, found " + " ".join(map(str, clip)))
        self.lines["fixed"] += [[*map(float, np.array(line) - np.tile(self.origin, 2))] for line in fixed]
        for kind, what in OUTLINES.items():
            self.close_outlines(kind, what, self.node_distance() if close is None else close, window)
        self.outside = 0                       # lines and points that they take away
        self.removed = self.take_stages()
        self.drawn = length_of(self.lines["joint"])
        if clip or self.lines["tunnel"]:
            self.take_rock(window)
        elif self.lines["boundary"]:
            self.leave_out_beyond()
        if not self.lines["boundary"] and not self.lines["joint"]:
            raise MapError(f"{self.drawing.path}: expected joint or boundary lines"
                           + (" in the clip" if self.outside else "") + ", found none"
                           + (f" but {self.dropped} of no length" if self.dropped else "") + self.why_empty())
        self.connect_traces(snap, extend)
        self.table = self.water_table()

    def take(self, layer, role):
        """Takes the shapes of a layer."""
        taken = []
        for kind, shapes in self.drawing.held[layer] if role.kind != "skip" else ():
            some = [] if isinstance(shapes, str) else wanted(role, shapes)
            if not some:
                self.left_out[layer, shapes if isinstance(shapes, str) else f"{kind} (this layer is for {role_words(role)})"] += 1
            for shape in some:
                self.expect_finite(layer, kind, shape)
                taken.append(shape.moved(np.vstack([np.eye(4)[:3], [*-self.origin, 0, 1]])) if self.origin.any() else shape)
        if taken:
            self.taken[layer] = taken

    def expect_finite(self, layer, kind, shape):
        """Error for coordinates that are not finite."""
        if not np.isfinite(shape.rows).all():
            raise MapError(f"{self.drawing.path}: expected finite coordinates, found {kind} on layer "
                           f"'{shown(self.drawing.names[layer])}' with others")

    def leave_out_heights(self):
        """Says which heights above the plane the deck leaves out. Error where the drawing stands on the plane on edge."""
        shapes = list(itertools.chain(*self.taken.values()))
        places = np.vstack([np.column_stack([shape.outline(), shape.in_plane("zx").outline()[:, 0]]) for shape in shapes])
        places = places[np.isfinite(places).all(1)]
        size = abs(places[:, :2]).max(initial=0)
        low, high = places[:, 2].min(initial=math.inf), places[:, 2].max(initial=-math.inf)
        if not max(abs(low), abs(high)) > FLAT * size:
            return
        refusal = self.drawing.view.refusal(places, width_of)
        if refusal:
            raise MapError(f"{self.drawing.path}: {refusal}")
        self.said.append(self.drawing.view.left_out(low, high))

    def node_distance(self):
        """The distance at which the cutter takes ends of lines for one."""
        lines = [line[:4] for line in self.lines["boundary"] + self.lines["joint"] + self.lines["tunnel"] + self.lines["stage"]]
        return NODE_SHARE * self.snap_distance(lines)

    def snap_distance(self, lines):
        """e0 w0 of some lines, as doc/decks.md says."""
        width, height = np.ptp(np.array(lines).reshape(-1, 2), axis=0) if lines else (0.0, 0.0)
        return float(self.e0 * 1.02 * max(height / 2, width / 2 / 1.3))

    def close_outlines(self, kind, what, within, window):
        """Joins ends of outlines that do not close. Error for ends within the window (None: anywhere) that are farther apart.

        An outline is what lines make that hang together. One that encloses something closes, wherever its lines overshoot."""
        lines = self.lines[kind]
        count = collections.Counter(tuple(line[k:k + 2]) for line in lines for k in (0, 2))
        if all(ends > 1 for ends in count.values()):  # no end is loose
            return
        outlines = with_shapely()
        joining = outlines.joining_lines(lines, within)
        if joining:
            self.lines[kind] = lines + joining
            self.joining += joining
            gaps = [math.dist(line[:2], line[2:4]) for line in joining]
            self.said.append(f"{what}: joined ends {max(gaps):.6g} apart or less at " + places_text([line[:2] for line in joining]))
        ends = outlines.loose_ends(self.lines[kind])
        if window is not None:
            ends = [end for end in ends if outlines.lies_inside(window, end)]
        if ends:
            raise MapError(f"{self.drawing.path}: expected closed {what}, found ends that meet no other line of these at "
                           f"{places_text(ends)}, the nearest {outlines.least_distance(ends):.6g} apart: "
                           "--close G joins ends up to G apart")

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
        round_off = ROUND_OFF * abs(places).max()
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

    def take_rock(self, window):
        """Clips lines and points at a window (corners, or None), cuts the tunnels out and adds what bounds the rock then."""
        if self.lines["tunnel"] or self.lines["boundary"]:
            with_shapely()
        outlines = collections.defaultdict(list)
        for line in self.lines["tunnel"]:
            outlines[line[4]].append(line)
        tunnels = {number: closed(self.drawing, "tunnels", lines) for number, lines in outlines.items()}
        rock = Rock(window, list(tunnels.values()), self.lines["boundary"], self.points["hole"])
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
        if window is not None:
            sides, number = rock.outline(rock.clip), next(self.free)
            self.lines["boundary"] += [side + [number] for side in sides]
            self.said.append(f"clip: boundary, joint material {number}, {counted(len(sides), 'line')}")
        for number, tunnel in tunnels.items():
            sides = rock.outline(with_shapely().sides_of(tunnel))
            self.lines["boundary"] += [side + [number] for side in sides]
            self.said.append(f"tunnels of joint material {number}: boundary, {counted(len(sides), 'line')}")
        holes = rock.hole_points()
        self.points["hole"] += holes
        if tunnels:
            self.said.append(f"tunnels that rock closes in: {counted(len(holes), 'hole point')}")
        if self.outside:
            self.said.append(f"left out, where no rock is left: {counted(self.outside, 'line or point', 'lines and points')}")

    def connect_traces(self, snap, extend):
        """Moves loose ends of joint traces onto a trace nearby, or extends them to the next one, and says what became of the ends."""
        others = [line for kind in ("boundary", "tunnel", "stage") for line in self.lines[kind]]
        boundary = np.array([line[:4] for line in self.lines["boundary"]])
        lines, self.ends = connect(self.lines["joint"], others, boundary, self.node_distance(), snap, extend)
        kept = self.lines["joint"] = [line for line in lines if line[:2] != line[2:4]]
        self.dropped += len(lines) - len(kept)
        if kept:
            self.said += [f"length of joint lines: {self.drawn:.6g} drawn, {length_of(kept):.6g} in the deck", self.ends.text()]

    def leave_out_beyond(self):
        """Leaves out joint lines that lie wholly beyond the box around the boundary lines, where they would count for the size w0."""
        places = np.array([line[:4] for line in self.lines["boundary"]]).reshape(-1, 2)
        low, high = places.min(0), places.max(0)
        ends = np.array([line[:4] for line in self.lines["joint"]]).reshape(-1, 2, 2)
        beyond = ((ends.min(1) > high) | (ends.max(1) < low)).any(1)
        if beyond.any():
            self.lines["joint"] = [line for line, out in zip(self.lines["joint"], beyond) if not out]
            self.said.append(f"left out, beyond the boundary lines: {counted(int(beyond.sum()), 'joint line')}")

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
                        "bolt": "bolts of stiffness, strength, pretension " + " ".join(map(str, role.bolt or ())),
                        "water": "water table"}.get(role.kind, role.kind)
                lines, points = self.counts[layer]
                text.append(name + ", ".join([what] + [counted(n, one) for n, one in ((lines, "line"), (points, "point")) if n]))
        for (layer, why), count in sorted(self.drawing.hidden.items()):
            name, entities = shown(self.drawing.names[layer]), counted(count, "entity", "entities")
            text.append(f"layer '{name}'" + (f": {entities} invisible, skipped" if why == "invisible" else
                                             f" is {why}: {entities} skipped"))
        if self.origin.any():
            text.append(f"origin: {float(self.origin[0])} {float(self.origin[1])} is taken off all coordinates; "
                        "add it to come back to those of the map")
        text += self.said
        if self.dropped:
            text.append(f"dropped {counted(self.dropped, 'line')} of no length")
        numbered = [(role.number, layer) for layer, role in self.roles.items() if role.kind in ("joint", "boundary", "tunnel")]
        largest = max((line[4] for line in self.lines["boundary"] + self.lines["joint"]))
        layer = next((f", that of layer '{shown(self.drawing.names[layer])}'" for number, layer in numbered if number == largest), "")
        text.append(f"joint materials of the analysis deck (nj): {largest}{layer}")
        return text

    def warnings(self):
        """Lines that say what is lost, or will be."""
        text = [f"left out, not understood: {count} {shown(what)} on layer '{shown(self.drawing.names[layer])}'"
                for (layer, what), count in self.left_out.items()]
        text += self.drawing.warned
        if self.drawing.on_paper:
            text.append(f"left out, in paper space: {counted(self.drawing.on_paper, 'entity', 'entities')}")
        lines = [line[:4] for line in self.lines["boundary"] + self.lines["joint"] if line not in self.joining]
        snap = self.snap_distance(lines)
        short = sum(math.dist(line[:2], line[2:]) <= snap for line in lines)
        if short:
            text.append(f"{counted(short, 'line')} not longer than e0 w0 = {snap:.6g}, within which ends are one point: "
                        "a smaller --e0 or a larger --sagitta keeps them apart")
        return text

    def text(self):
        """The deck."""
        lines = self.lines["boundary"] + self.lines["joint"]
        name = shown(", ".join(pathlib.Path(path).name for path in self.drawing.files))
        head = [f"From {name}, chords within {self.sagitta:.6g} of the curves", *self.mapping(), *self.warnings()]
        numbers = [(str(self.e0), "least distance of edge and node, over the size (e0)"),
                   (f"{len(lines)} {len(self.lines['boundary'])}", "lines, boundary lines"),
                   (len(self.lines["material"]), "material lines"), (len(self.lines["bolt"]), "bolts"),
                   (len(self.lines["fixed"]), "fixed lines"),
                   *((len(self.points[kind]), f"{kind} points") for kind in POINT_KINDS)]
        rows = itertools.chain(lines, *(self.lines[kind] for kind in ("material", "bolt", "fixed")),
                               *(self.points[kind] for kind in POINT_KINDS))
        return "".join([f"! {line}\n" for line in head] + [f"{number!s:<12} ! {what}\n" for number, what in numbers]
                       + [" ".join(map(str, row)) + "\n" for row in rows] + self.groups())

    def stages(self):
        """The groups &stage that remove what is drawn to be removed, from the second to the last of them."""
        corners = {number: "  ".join(f"{x} {y}" for ring in with_shapely().rings_of(shape) for x, y in ring.tolist())
                   for number, shape in self.removed.items()}
        return "".join(f"&stage remove_inside={corners[k]} /\n" if k in corners else "&stage /\n"
                       for k in range(FIRST_STAGE, max(corners) + 1))

    def groups(self):
        """The groups of places that the deck ends in."""
        text = [f"&blocks least_area={self.least_area} /\n"] if self.least_area > 0 else []
        if self.table:
            text.append("&water table=" + "  ".join(f"{x} {y}" for x, y in self.table) + " /\n")
        return text


def with_shapely():
    """The module that needs shapely."""
    try:
        from . import outlines
    except ImportError:
        raise MapError("expected shapely for tunnels, stages, a clip of boundary lines and boundary lines that do not close, found none: "
                       "pip install shapely, or on Debian apt-get install python3-shapely") from None
    return outlines


def closed(drawing, what, lines):
    """What outlines enclose."""
    outlines = with_shapely()
    try:
        return outlines.enclosed(lines)
    except outlines.OpenOutline as end:
        raise MapError(f"{drawing.path}: expected closed outlines of {what}, found an open one at {end}") from None


def width_of(places):
    """How far places (n, 2) reach across the direction in which they reach farthest."""
    size = abs(places).max()
    if not size > 0:
        return 0.0
    away = places / size - (places / size).mean(0)
    width = np.ptp(away @ np.linalg.svd(away, full_matrices=False)[2][-1])
    return float(size * width) if width > ROUND_OFF else 0.0


def places_text(places):
    """A few places, in words."""
    text = " ".join(f"({x:.6g}, {y:.6g})" for x, y in places[:MOST_PLACES])
    return text + (f" and {len(places) - MOST_PLACES} more" if len(places) > MOST_PLACES else "")


def corners_of(numbers):
    """The corners of a clip: two are those of a window."""
    x, y = numbers[::2], numbers[1::2]
    if len(x) == 2:
        x, y = [x[0], x[1], x[1], x[0]], [y[0], y[0], y[1], y[1]]
    corners = np.column_stack([x, y])
    return corners[:-1] if (corners[0] == corners[-1]).all() else corners


def length_of(lines):
    """The length of lines x1 y1 x2 y2 together."""
    return sum(math.dist(line[:2], line[2:4]) for line in lines)


def counted(number, one, more=None):
    """A number of things."""
    return f"{number} {one if number == 1 else more or one + 's'}"
