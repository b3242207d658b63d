"""Draws results files, geometries and models: deformed shapes of frames, or histories; more files are laid over each other.

    tools/plot FILE [...] [--frames first last 10 | all] [--stage 1 NAME | all] [--field stress_xx] [-o PICTURE.png]
                          [--joints [material | state | forces]] [--vectors [displacement | velocity]] [--crosses]
                          [--conditions] [--points] [--numbers] [--covers] [--window X1 Y1 X2 Y2] [--range LOW HIGH | full] [--no-mesh]
                          [--magnify FACTOR] [--units m,MPa=1e6] [--colours MAP] [--dpi N] [--scree PROGRAM]
    tools/plot FILE --rose [-o PICTURE.png]
    tools/plot RESULTS.h5 [...] --history rotation area energy/kinetic measured_points/displacement [-o PICTURE.png]

FILE is a results file, a geometry (.geo, .blk, .blck, block.in), whose blocks are drawn, or an analysis deck (.ana), whose elements
are drawn as set up, under its mathematical mesh where it has one. Geometries and analysis decks go through `scree cut`.

Needs Debian's python3-numpy, python3-h5py and python3-matplotlib.
"""
import dataclasses
import os
import pathlib
import tempfile

os.environ.setdefault("MPLBACKEND", "Agg")  # unless something else draws here, as a notebook does
import matplotlib.pyplot as plt
import numpy as np
from matplotlib import patheffects
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.colors import ListedColormap
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation

from .arguments import above_zero, beside, check_picture, ends_in_a_line, parser_for
from .conditions import ARROW, draw_bolts, draw_conditions
from .errors import PlotError, ScreeError
from .histories import LINES, axis_of, histories_of, is_static
from .model.views import model_of
from .overlays import (VECTORS, Common, all_corners, draw_contact_forces, draw_crosses, draw_joint_states, first_of, lengths_of,
                       robust_limits, velocities)
from .polygons import loops_of
from .program import cut
from .results import LATER, read
from .rose import draw_rose
from .tips import draw_tips
from .units import Units, add_units, units_of_files

FIELDS = ("material", "block", "stress_xx", "stress_yy", "stress_xy", "major", "minor", "displacement", "velocity")
LARGEST_NUMBER_OF_PANELS = 12
MOST_NAMES = 15    # of curves of a panel, beyond which their names are left out
BOTH_SIGNS = 0.1   # of the smaller of two signs over the larger, from which on zero is white
DIGITS = 10        # of numbers along axes, which may be of a national grid
PALER = 0.4        # share of white in colours that something is drawn over
PANEL, WHOLE = 3.4, 5.6  # inches of one of many panels, and of one alone
LEGEND = 0.8       # inches below the panels
ALONG_BAR = 0.75   # of the height of a picture, which the label of the bar of colours may take
BAR = 1.2          # inches beside the panels, for the bar of colours
MOST_COLUMNS = 4   # of a legend
WIDER = 1.05       # times its width, which letters of another resolution may take
BELOW = 0.5        # inches from a panel to the legend, for the numbers and the name of x
TALLEST = 1.4      # of a panel, over its width
MESH = dict(edgecolors="0.35", linewidths=0.15)  # lines of the mesh
LEAST_SIDE = 0.25  # of a picture over the other
POINTS = {1: ("fixed point", "^", "tab:red"), 2: ("load point", "v", "tab:orange"), 3: ("measured point", "o", "tab:cyan")}
ROCKS = ("#d9d2c5", "#c3cfd9", "#dcc2ab", "#c5d4bb", "#d8c6d6", "#e6dfb4", "#aebfc0", "#c9b7a0")  # of block materials
ROCK = "rock"  # the map with these
JOINT_COLOURS = ("0.2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#8C564B", "#999999")  # of joint materials; blue is water


def outline(polygon, loops):
    """The loops as one path: holes turn the other way round and stay empty."""
    vertices = np.vstack([polygon[np.append(loop, loop[0])] for loop in loops])
    codes = np.concatenate([[Path.MOVETO] + [Path.LINETO] * (len(loop) - 1) + [Path.CLOSEPOLY] for loop in loops])
    return Path(vertices, codes)


def area_and_centroid(polygon):
    """Of a polygon, with or without seams."""
    own = polygon - polygon[0]
    after = np.roll(own, -1, axis=0)
    twice = own[:, 0] * after[:, 1] - own[:, 1] * after[:, 0]
    return twice.sum() / 2, polygon[0] + twice @ (own + after) / (3 * twice.sum())


def place_inside(polygon, loops):
    """The centroid where no corner turns inwards; else the middle of the widest run of a horizontal between two corners."""
    side = np.roll(polygon, -1, axis=0) - polygon
    after = np.roll(side, -1, axis=0)
    if len(loops) == 1 and (side[:, 0] * after[:, 1] >= side[:, 1] * after[:, 0]).all():
        return area_and_centroid(polygon)[1]
    heights = np.unique(polygon[:, 1])
    best, room = polygon[0], -1
    for low, high in zip(heights, heights[1:]):
        y, at = (low + high) / 2, []
        for loop in loops:
            p, q = polygon[loop], polygon[np.roll(loop, -1)]
            crossing = (p[:, 1] > y) != (q[:, 1] > y)
            p, q = p[crossing], q[crossing]
            at.extend(p[:, 0] + (q[:, 0] - p[:, 0]) * (y - p[:, 1]) / (q[:, 1] - p[:, 1]))
        at = np.sort(at).reshape(-1, 2)
        run = at[np.ptp(at, axis=1).argmax()]
        if min(np.ptp(run), high - low) > room:
            best, room = np.array([run.mean(), y]), min(np.ptp(run), high - low)
    return best


class Shapes:
    """What blocks and frames have in common; `start` has the vertices of each element at the start."""

    def shape(self):
        """Loops of each element."""
        if not hasattr(self, "loops"):
            self.loops = [loops_of(polygon) for polygon in self.start]
        return self.loops

    def present(self, frame):
        """Which elements are there."""
        return np.ones(len(self.start), bool)

    def since(self, frame):
        """The frame that displacements of a frame count from."""
        return 0

    def outlines(self, frame, magnified=True):
        """A path an element; that of one that is gone is empty."""
        return [outline(polygon, loops) if there else Path(np.empty((0, 2)))
                for polygon, loops, there in zip(self.polygons(frame, magnified), self.shape(), self.present(frame))]

    def joints(self, frame):
        """Joint material of the edge from each corner of the elements to the next, 0 for a line of the mesh."""
        return self.joint

    def edge_list(self, frame=-1):
        """Of each edge, but seams: its two corners (n, 2), rows of those of all elements one after the other, its joint material in a
        frame, 0 for a line of the mesh and -1 for one of a crack that grows later, and its element (n)."""
        if not hasattr(self, "listed"):
            first = first_of(self.start)
            loops = [at + loop for at, of_element in zip(first, self.shape()) for loop in of_element]
            ends = np.stack([np.concatenate(loops), np.concatenate([np.roll(loop, -1) for loop in loops])], axis=1)
            self.listed = ends, np.searchsorted(first, ends[:, 0], side="right") - 1
        ends, element = self.listed
        return ends, np.asarray(self.joints(frame))[ends[:, 0]], element

    def faces(self, frame):
        """Rows of `edge_list` that are edges of joints and boundary in a frame; lines of the mesh and of cracks that grow later are none."""
        _, of_edge, element = self.edge_list(frame)
        return np.flatnonzero((of_edge > 0) & self.present(frame)[element])

    def mesh_lines(self, frame):
        """Rows of `edge_list` that are lines of the mesh in a frame."""
        _, of_edge, element = self.edge_list(frame)
        return np.flatnonzero((of_edge == 0) & self.present(frame)[element])

    def places(self, rows, frame, magnified=True):
        """Places of rows of `edge_list` in a frame (n, 2, 2)."""
        return np.vstack(self.polygons(frame, magnified))[self.edge_list(frame)[0][rows]]

    def edges(self, frame, magnified=True):
        """Edges of joints and boundary (n, 2, 2), their joint material and element (n)."""
        rows, (_, of_edge, element) = self.faces(frame), self.edge_list(frame)
        return self.places(rows, frame, magnified), of_edge[rows], element[rows]

    def joint_edges(self, frame):
        """Edges by joint material."""
        edges, of_edge, _ = self.edges(frame)
        return {int(k): edges[of_edge == k] for k in np.unique(of_edge)}

    def has_mesh(self):
        """Whether blocks are of several elements."""
        return len(np.unique(self.values(0, "block")[0])) < len(self.start)

    def block_numbers(self, frame):
        """A place in each block: in the element nearest to its centroid."""
        polygons, block = self.polygons(frame), self.values(frame, "block")[0]
        found = [area_and_centroid(polygon) for polygon in polygons]
        area, centroid = np.array([a for a, _ in found]), np.array([c for _, c in found])
        places = {}
        for b in np.unique(block[self.present(frame)]):
            of_block = np.flatnonzero(block == b)
            middle = area[of_block] @ centroid[of_block] / area[of_block].sum()
            e = of_block[((centroid[of_block] - middle) ** 2).sum(1).argmin()]
            places[int(b)] = place_inside(polygons[e], self.shape()[e])
        return places


class Blocks(Shapes):
    """The blocks of a block file as `scree cut` writes it (doc/decks.md); one frame."""

    def __init__(self, path, name):
        self.name, self.times = name, [None]
        numbers = np.array(path.read_text().partition("&")[0].split(), float)  # groups of places follow them
        n_blocks, n_bolts, n_rows = numbers[:3].astype(int)
        self.table = numbers[6:6 + 3 * n_blocks].reshape(-1, 3).astype(int)
        at = 6 + 3 * n_blocks
        rows = numbers[at:at + 3 * n_rows].reshape(-1, 3)
        self.start = [rows[a - 1:b, 1:] for _, a, b in self.table]
        self.joint = np.concatenate([np.roll(rows[a - 1:b, 0], -1) for _, a, b in self.table]).astype(int)
        self.kind = np.repeat([1, 2, 3], numbers[3:6].astype(int))
        at += 3 * n_rows
        self.bolt_ends = numbers[at:at + 9 * n_bolts].reshape(-1, 9)[:, :4].reshape(-1, 2, 2)
        self.place = numbers[at + 9 * n_bolts:].reshape(-1, 3)[:, :2]

    def title(self):
        return f"{self.name}, {len(self.start)} blocks"

    def polygons(self, frame, magnified=True):
        return self.start

    def values(self, frame, field):
        if field not in ("block", "material"):
            raise PlotError(f"{self.name}: expected --field block or material for a geometry, found {field}")
        return (np.arange(1, len(self.table) + 1) if field == "block" else self.table[:, 0]), field

    def points(self, frame):
        return self.kind, self.place

    def bolts(self, frame):
        return self.bolt_ends, np.zeros(len(self.bolt_ends), int)

    def covers(self, frame):
        raise PlotError(f"{self.name}: expected an analysis deck or results file for --covers, found a geometry")


class Frames(Shapes):
    """The frames of a results file, as they are drawn: with displacements magnified."""

    def __init__(self, path, name):
        self.name, self.file, self.magnified = name, read(path), 1.0
        self.times, self.corners = np.append(0.0, self.file.clock)[self.file.frame_steps], self.file.corners()
        if len(self.times) == 0:
            raise PlotError(f"{path}: expected a frame, found none")
        self.start = self.polygons(0)
        self.joint = self.file["elements/joint"] if "elements" in self.file else np.zeros(sum(map(len, self.corners)), int)

    def moment(self, frame, units, digits=""):
        """Which frame it is, with so many letters at least: its stage, and the time, or the step where no time passes."""
        if len(self.file.history.time) == 0:
            return "as set up"
        time, factor = units.of("[time]")
        if self.file.is_static(frame):
            words = f"step {self.file.frame_steps[frame]:<{digits}}"
        else:
            words = f"t = {self.times[frame] / factor:<{digits}.6g}" + (f" {time[1:-1]}" if time != "[time]" else "")
        names = self.file.stage_names
        return f"{names[self.file.frame_stages[frame] - 1]}, {words}" if names else words

    def since(self, frame):
        return self.file.counted_from(frame)

    def polygons(self, frame, magnified=True):
        """Vertices of each element."""
        vertices = self.vertices(frame) if magnified else self.file.vertices(frame)
        return [vertices[corners] for corners in self.corners]

    def magnify(self, places, frame):
        """Places as drawn, in a frame; `places(frame)` are the true ones."""
        if self.magnified == 1:
            return places(frame)
        since = places(self.since(frame))
        return since + self.magnified * (places(frame) - since)

    def vertices(self, frame):
        """Places of all vertices as drawn."""
        return self.magnify(self.file.vertices, frame)

    def joints(self, frame):
        return self.file.joints(frame) if "elements" in self.file else self.joint

    def present(self, frame):
        """Which elements no stage has removed."""
        return self.file.present(frame)

    def moved(self, frame, places, elements):
        """Where places of elements, from 0, have come to: the field of an element is linear."""
        if frame == 0 or len(places) == 0:
            return places
        polygons, now = self.polygons(frame), np.empty((len(places), 2))
        for i, (place, e) in enumerate(zip(places, elements)):
            own = np.column_stack([self.start[e] - place, np.ones(len(self.start[e]))])
            now[i] = np.linalg.lstsq(own, polygons[e], rcond=None)[0][2]
        return now

    def points(self, frame):
        """Kinds and places of the points."""
        if "points" not in self.file:
            return np.empty(0, int), np.empty((0, 2))
        given = self.file["points"]
        return given.kind, self.moved(frame, given.place, given.element - 1)

    def bolts(self, frame):
        """Ends (n, 2, 2) and states of the bolts."""
        if "bolts" not in self.file:
            return np.empty((0, 2, 2)), np.empty(0, int)
        given = self.file["bolts"]
        return self.magnify(lambda k: given.ends[k], frame).reshape(-1, 2, 2), given.state[frame]

    def covers(self, frame):
        """Places of the nodes of the covers, and whether each follows others."""
        if "covers" not in self.file:
            raise PlotError(f"{self.name}: expected manifold elements for --covers, found none")
        if "parent" in self.file.elements:
            raise PlotError(f"{self.name}: expected a scene whose cracks do not grow for --covers, as a file has the covers of the start")
        given = self.file["covers"]
        follows = np.zeros(len(given.node), bool)
        if "follows" in given:
            follows[given.follows[:, 0] - 1] = True
        element = np.unique(given.of_element, return_index=True)[1] // given.of_element.shape[1]
        return self.moved(frame, given.node, element), follows

    def values(self, frame, field):
        """One number an element, and its label."""
        if field in ("block", "material"):
            return (self.file.blocks(frame) if field == "block" else self.file.material), field
        if field == "velocity":
            return lengths_of[velocities](self, frame), "velocity [length/time]"
        if field == "displacement":
            size = np.linalg.norm(self.file.displacement(frame), axis=1)
            first, every = all_corners(self)[:2]
            return np.add.reduceat(size[every], first) / np.diff(first, append=len(every)), "displacement [length]"
        xx, yy, xy = self.file.stress(frame).T
        mean, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
        values = {"stress_xx": xx, "stress_yy": yy, "stress_xy": xy, "major": mean + half, "minor": mean - half}[field]
        name = {"major": "major principal stress", "minor": "minor principal stress"}.get(field, field.replace("_", " "))
        return values, f"{name} [force/length$^2$]"


def kind_of(path):
    """geometry, analysis or results, by the name, in capitals or not."""
    name = pathlib.Path(str(path).lower())
    if name.suffix in (".geo", ".blk", ".blck") or name.name == "block.in":
        return "geometry"
    return "analysis" if name.suffix == ".ana" else "results"


def open_shapes(path, program, folder):
    """The shapes of a file; a geometry or an analysis deck is cut into the folder."""
    path = pathlib.Path(path)
    kind = kind_of(path)
    if kind == "results":
        return Frames(path, path.stem)
    made = pathlib.Path(folder) / f"{len(list(pathlib.Path(folder).iterdir()))}{'.blk' if kind == 'geometry' else '.h5'}"
    cut(path, output=made, path=program)
    return Blocks(made, path.stem) if kind == "geometry" else Frames(made, path.stem)


def chosen_frames(words, count):
    """Frame numbers, from 0; the first and the last where no words are given."""
    if words is None:
        words = ["first", "last"] if count > 1 else ["first"]
    if words == ["all"]:
        words = [str(i) for i in np.unique(np.linspace(0, count - 1, min(count, LARGEST_NUMBER_OF_PANELS)).round().astype(int))]
    numbers = []
    for word in words:
        number = {"first": 0, "last": count - 1}.get(word)
        if number is None:
            if not word.lstrip("-").isdigit() or not -count <= int(word) < count:
                raise PlotError(f"--frames: expected first, last, all or a number from 0 to {count - 1}, found '{word}'")
            number = int(word) % count
        numbers.append(number)
    return numbers


def frames_of_stage(file, word):
    """The frames of a stage, by its number from 1 or its name; PlotError where there are none."""
    names = file.file.stage_names if isinstance(file, Frames) else []
    if not names:
        raise PlotError(f"{file.name}: expected a run with stages for --stage, found one without")
    number = int(word) if word.isdecimal() else names.index(word) + 1 if word in names else 0
    frames = np.flatnonzero(file.file.frame_stages == number)
    if len(frames) == 0:
        reached = ", ".join(f"{k} ({names[k - 1]})" for k in np.unique(file.file.frame_stages))
        raise PlotError(f"--stage: expected one of the stages of {file.name}, by number or name: {reached}; found '{word}'")
    return [int(frame) for frame in frames]


def ends_of_stages(file, words):
    """The last frame of each stage; words are numbers, names, or `all`."""
    if words == ["all"] and isinstance(file, Frames):
        words = [str(number) for number in np.unique(file.file.frame_stages)]
    return [frames_of_stage(file, word)[-1] for word in words]


def draw_joints(axis, file, frame, common):
    """Edges in the colour of their joint material; returns the entries of the legend by what they say."""
    entries = {}
    for material, edges in file.joint_edges(frame).items():
        colour = JOINT_COLOURS[(material - 1) % len(JOINT_COLOURS)]
        axis.add_collection(LineCollection(edges, colors=colour, linewidths=1.3))
        entries[name_of(file, "joint", material)] = Line2D([], [], color=colour, linewidth=1.3)
    return entries


def name_of(file, what, number):
    """The name of a block material, or of a joint material, by the comments of the decks; its number where it has none."""
    if not hasattr(file, "material_names"):
        file.material_names = {"rock": [], "joint": []}
        try:
            model = model_of(file.file)
            file.material_names = {"rock": list(model.materials), "joint": list(model.joint_materials)}
        except (AttributeError, ScreeError):  # a geometry, or decks that no model reads
            pass
    names = file.material_names[what]
    name = names[number - 1] if number <= len(names) else str(number)
    return f"{what} {number}" if name == str(number) else name


def draw_points(axis, file, frame, common):
    """Fixed, load and measured points with a marker each."""
    entries = {}
    kinds, places = file.points(frame)
    for kind, (name, marker, colour) in POINTS.items():
        if kind in kinds:
            entries[name], = axis.plot(*places[kinds == kind].T, linestyle="none", marker=marker, color=colour, markersize=6,
                                       markeredgecolor="black", markeredgewidth=0.6)
    return entries


def draw_covers(axis, file, frame, common):
    """Nodes of the covers, hollow where they follow others."""
    entries = {}
    places, follows = file.covers(frame)
    for name, which, face in (("cover", ~follows, "black"), ("cover that follows", follows, "none")):
        if which.any():
            entries[name], = axis.plot(*places[which].T, linestyle="none", marker="o", markersize=3, markerfacecolor=face,
                                       markeredgecolor="black", markeredgewidth=0.6)
    return entries


def draw_numbers(axis, file, frame, common):
    """The number of each block in it."""
    for number, place in file.block_numbers(frame).items():
        axis.annotate(str(number), place, ha="center", va="center", fontsize=7,
                      path_effects=[patheffects.withStroke(linewidth=1.5, foreground="white")])
    return {}


@dataclasses.dataclass
class Look:
    """How frames are drawn, where it is not told by itself."""

    window: list | None = None  # x and y of two corners
    range: list | None = None   # of the colours: two numbers, or ["full"]; else all but the hundredth at each end
    mesh: bool = True           # lines within blocks
    colours: str | None = None  # a map of matplotlib
    magnify: float = 1.0        # displacements by so much
    units: Units = dataclasses.field(default_factory=Units)

    def title(self, file, frame, digits=""):
        """What stands above a panel of a results file; its time or step with so many letters at least."""
        return file.moment(frame, self.units, digits) + (f", displacements × {self.magnify:g}" if self.magnify != 1 else "")


def limits_of(values, field, look):
    """Limits and map of the colours. A field that has both signs, each of some size, is white at zero."""
    if field == "material" and values.max() <= len(ROCKS) and look.range is None and look.colours is None:
        return 0.5, len(ROCKS) + 0.5, ROCK
    low, high = robust_limits(values) if look.range is None and field not in ("block", "material") else (values.min(), values.max())
    colours = "cividis"
    if min(-low, high) > BOTH_SIGNS * max(-low, high):
        low, high, colours = -max(-low, high), max(-low, high), "RdBu_r"
    if look.range not in (None, ["full"]):
        low, high = look.range
    return low, high if high > low else low + 1, look.colours or colours


def window_of(files, slots, extras, look):
    """Corners of what is drawn, (2, 2)."""
    corners = [np.vstack(file.polygons(frame)) for file, frame in slots]
    if draw_covers in extras:
        corners += [file.covers(frame)[0] for file, frame in slots]
    corners += [file.bolts(frame)[0].reshape(-1, 2) for file, frame in slots]
    every = np.vstack(corners + [np.vstack(file.start) for file in files])
    low, high = every.min(0), every.max(0)
    if look.window:
        window = np.array(look.window).reshape(2, 2)
        if (window[1] < low).any() or (window[0] > high).any():
            extent = " to ".join(f"({x:.6g}, {y:.6g})" for x, y in (low, high))
            raise PlotError(f"--window: expected a part of what is drawn, which is from {extent}, found {look.window}")
        return window
    size = max((high - low).max(), 1e-300)
    spare = np.maximum((1.3 * ARROW if draw_conditions in extras else 0.05) * size, (LEAST_SIDE * size - (high - low)) / 2)
    return np.array([low - spare, high + spare])


class Panels:
    """What panels have in common, each a frame of a file: window, colours, scales of what is drawn over."""

    def __init__(self, files, slots, field, extras, look):
        self.field, self.extras, self.look = field, extras, look
        for file in files:
            file.magnified = look.magnify
        found = {slot: slot[0].values(slot[1], field) for slot in slots}
        self.label, factor = look.units.of(next(iter(found.values()))[1])
        self.values = {slot: values / factor if factor != 1 else values for slot, (values, _) in found.items()}
        every = np.concatenate(list(self.values.values()))
        *self.limits, self.colours = limits_of(every, field, look)
        if OVER.intersection(extras) and self.colours != ROCK:
            self.colours = paler(self.colours)
        self.beyond = {(True, True): "both", (True, False): "min", (False, True): "max", (False, False): "neither"}[
            every.min() < self.limits[0], every.max() > self.limits[1]]
        self.window = window_of(files, slots, extras, look)
        self.shape = np.ptp(self.window, axis=0)  # wide, tall
        self.common = Common(slots, self.shape.max(), look.units)

    def draw(self, axis, file, frame):
        """Draws a panel; returns the picture that the colours are of, and the entries of the legend."""
        axis.set(xlim=self.window[:, 0], ylim=self.window[:, 1], aspect="equal")
        picture = draw_shapes(axis, file, frame, self.values[file, frame], draw_joints in self.extras, self.look)
        picture.set(clim=self.limits, cmap=self.colours)
        entries = {}
        for extra in (draw_bolts, *self.extras, draw_tips):
            entries.update(extra(axis, file, frame, self.common))
        return picture, entries

    def frame_picture(self, figure, axes, picture, entries):
        """Names of the axes, the bar of colours and the legend around the panels."""
        (x, factor), (y, _) = (self.look.units.of(f"{name} [length]") for name in "xy")
        for column in axes.T:
            lowest = [axis for axis in column if axis.get_visible()][-1]
            lowest.tick_params(labelbottom=True)
            lowest.set_xlabel(x, fontsize=10)
        for axis in axes[:, 0]:
            axis.set_ylabel(y, fontsize=10)
        for axis in (axes[0, 0].xaxis, axes[0, 0].yaxis):  # those of all panels
            if factor == 1:
                axis.get_major_formatter().set_useOffset(False)  # numbers are whole, without one to add to them
            else:
                axis.set_major_formatter(lambda value, _: f"{value / factor:.{DIGITS}g}")
        if self.colours == ROCK:
            file = next(iter(self.values))[0]
            found = [int(number) for number in np.unique(np.concatenate(list(self.values.values())))]
            rocks = {name_of(file, "rock", number): Patch(facecolor=ROCKS[number - 1], edgecolor="0.6") for number in found}
            entries = {**rocks, **entries}
        else:
            self.bar_of_colours(figure, axes, picture)
        if entries:
            below = axes[-1, 0].transAxes + ScaledTranslation(0, -BELOW, figure.dpi_scale_trans)
            for columns in range(MOST_COLUMNS, 0, -1):  # as many as the panels are wide enough for
                legend = axes[-1, 0].legend(entries.values(), entries.keys(), fontsize=8, frameon=False, ncols=columns, loc="upper center",
                                            bbox_to_anchor=(0.5, 0), bbox_transform=below, borderaxespad=0)
                if WIDER * legend.get_window_extent().width <= figure.bbox.width - BAR * figure.dpi:
                    break

    def bar_of_colours(self, figure, axes, picture):
        """The bar of colours beside the panels."""
        bar = figure.colorbar(picture, ax=axes, label=self.label, shrink=0.8, extend=self.beyond,
                              ticks=MaxNLocator(integer=True) if self.field in ("block", "material") else None)
        bar.formatter.set_useOffset(False)
        label = bar.ax.yaxis.label
        for size in (10, 8, 6):  # the room of a saved picture does not count how long a label is along its axis
            if label.get_window_extent().height <= ALONG_BAR * figure.bbox.height:
                break
            label.set(text=self.label.replace(" [", "\n["), fontsize=size)

    def figure(self, rows, columns, side):
        """A figure with so many panels of a side in inches."""
        wide, tall = self.shape
        below = LEGEND if self.extras or self.colours == ROCK else 0.3
        size = (side * columns + BAR, (side * min(tall / wide, TALLEST) + 0.5) * rows + below)
        return plt.subplots(rows, columns, figsize=size, squeeze=False, layout="constrained", sharex=True, sharey=True)


def draw_frames(files, words, field, extras=(), look=None, stages=None):
    """A panel a frame, or the end of a stage, files below each other, one colour scale; extras draw on each panel."""
    chosen = [ends_of_stages(file, stages) if stages else chosen_frames(words, len(file.times)) for file in files]
    columns = min(max(map(len, chosen)), 4)
    slots = [(file, frame) for file, frames in zip(files, chosen)
             for frame in frames + [None] * (-len(frames) % columns)]
    drawn = [slot for slot in slots if slot[1] is not None]
    panels = Panels(files, drawn, field, extras, look or Look())
    figure, axes = panels.figure(len(slots) // columns, columns, PANEL if len(drawn) > 1 else WHOLE)
    picture, entries = None, {}
    for axis, (file, frame) in zip(axes.flat, slots):
        if frame is None:
            axis.set_visible(False)
            continue
        picture, more = panels.draw(axis, file, frame)
        entries.update(more)
        if isinstance(file, Blocks):
            title = file.title()
        else:
            title = (f"{file.name}, " if len(files) > 1 else "") + panels.look.title(file, frame)
        axis.set_title(title, fontsize=10)
    panels.frame_picture(figure, axes, picture, entries)
    return figure


plt.colormaps.register(ListedColormap(ROCKS, name=ROCK), force=True)


def paler(colours):
    """A map with more white, so that lines show on its dark end."""
    return ListedColormap(PALER + (1 - PALER) * plt.get_cmap(colours)(np.linspace(0, 1, 256)))


def draw_shapes(axis, file, frame, values, with_joints, look):
    """The elements of a frame in their colours over their outlines where displacements count from, lines of the mesh thinner than edges
    of blocks."""
    meshed = isinstance(file, Frames) and file.has_mesh()
    if frame > 0 and not meshed:
        axis.add_collection(PathCollection(file.outlines(file.since(frame), magnified=False), facecolors="none", edgecolors="0.7", linewidths=0.8))
    cut_later = meshed and look.mesh and (file.edge_list(frame)[1] == LATER).any()  # elements are parts of those of the frame
    if meshed:
        edges = MESH if look.mesh and not cut_later else dict(edgecolors="none", antialiaseds=False)
    else:
        edges = dict(edgecolors="0.6", linewidths=0.3) if with_joints else dict(edgecolors="0.15", linewidths=0.6)
    picture = axis.add_collection(PathCollection(file.outlines(frame), array=values, **edges))
    if cut_later:
        axis.add_collection(LineCollection(file.places(file.mesh_lines(frame), frame), colors=MESH["edgecolors"], linewidths=MESH["linewidths"]))
    if meshed and not with_joints:
        if frame > 0:
            axis.add_collection(LineCollection(file.edges(file.since(frame), magnified=False)[0], colors="0.7", linewidths=0.8, zorder=0.9))
        axis.add_collection(LineCollection(file.edges(frame)[0], colors="0.15", linewidths=0.8))
    return picture


def draw_histories(paths, names, units=None):
    """A panel a history, or each of its dimensions; files as lines."""
    units = units or Units()
    for path in paths:
        if kind_of(path) != "results":
            raise PlotError(f"{path}: expected results files with --history, found another")
    files = [read(path) for path in paths]
    panels = list(zip(*([found for name in names for found in histories_of(file, name)] for file in files)))
    figure, axes = plt.subplots(len(panels), 1, figsize=(7.5, 2.3 * len(panels) + 0.6), squeeze=False, sharex=True,
                                layout="constrained")
    static = all(map(is_static, files))
    for axis, panel in zip(axes.flat, panels):
        axis.set_prop_cycle(color=LINES)
        for path, file, found in zip(paths, files, panel):
            along, steps = axis_of(file, units, static)
            label, factor = units.of(f"[{found.dimension}]")
            for own, values in zip(found.names, found.values.T):
                words = [pathlib.Path(path).stem] if len(paths) > 1 or not own else []
                axis.plot(steps, values / factor, linewidth=1.2, label=", ".join([*words, *([own] if own else [])]))
        axis.set_title(found.description, fontsize=10, loc="left")
        axis.set_ylabel(label, fontsize=9)
        axis.ticklabel_format(useOffset=False)
        axis.grid(True, linewidth=0.4, color="0.85")
        axis.margins(x=0)
        if 1 < len(axis.lines) <= MOST_NAMES:
            axis.legend(fontsize=8, frameon=False, ncols=3)
    axes.flat[-1].set_xlabel(along)
    return figure


# What is not to be lost on dark colours; those of rock are pale.
OVER = {draw_joint_states, draw_contact_forces, draw_crosses, *VECTORS.values()}
JOINTS = {"material": draw_joints, "state": draw_joint_states, "forces": draw_contact_forces}


def extras_of(given):
    """What is drawn over the blocks, in its order. A picture without a field has the joints and what acts on the rock."""
    plain = given.field is None
    joints = given.joints or ("material" if plain else None)
    return [*([JOINTS[joints]] if joints else []), *([draw_conditions] if plain or given.conditions else []), *(given.extras or []),
            *([VECTORS[given.vectors]] if given.vectors else [])]


def look_of(given):
    """How it is drawn; PlotError where the words say nothing."""
    given_range = given.range
    if given_range not in (None, ["full"]):
        try:
            low, high = given_range = [float(word) for word in given_range]
        except ValueError:
            low, high = 0.0, 0.0
        if not -np.inf < low < high < np.inf:
            raise PlotError(f"--range: expected LOW HIGH, finite, or full, found {' '.join(given.range)}")
    if given.window and not (np.isfinite(given.window).all() and np.less(given.window[:2], given.window[2:]).all()):
        raise PlotError(f"--window: expected X1 Y1 X2 Y2 with X1 below X2 and Y1 below Y2, found {given.window}")
    if not 10 <= given.dpi <= 2000:
        raise PlotError(f"--dpi: expected a number from 10 to 2000, found {given.dpi:g}")
    return Look(given.window, given_range, not given.no_mesh, given.colours, given.magnify, Units(given.units))


def add_words_of_frames(parser):
    """What says how frames are drawn, in a picture and in a film."""
    parser.add_argument("--field", choices=FIELDS, help="default: material, with joints and conditions")
    parser.add_argument("--joints", nargs="?", const="material", choices=JOINTS,
                        help="edges by joint material; by state: stick, slip, open; forces: of contacts, too")
    parser.add_argument("--vectors", nargs="?", const="displacement", choices=VECTORS, help="arrows at the middle of elements")
    parser.add_argument("--crosses", action="append_const", dest="extras", const=draw_crosses,
                        help="principal stresses, compression and tension apart")
    parser.add_argument("--covers", action="append_const", dest="extras", const=draw_covers, help="nodes of the covers")
    parser.add_argument("--conditions", action="store_true", help="water, supports, loads, absorbing edges")
    parser.add_argument("--points", action="append_const", dest="extras", const=draw_points, help="fixed, load, measured points")
    parser.add_argument("--numbers", action="append_const", dest="extras", const=draw_numbers, help="numbers of blocks")
    parser.add_argument("--window", nargs=4, type=float, metavar=("X1", "Y1", "X2", "Y2"), help="what is drawn; default: all")
    parser.add_argument("--range", nargs="+", metavar="VALUE",
                        help="of the colours: LOW HIGH, or full; default: without the hundredth part at each end")
    parser.add_argument("--magnify", type=above_zero, default=1.0, metavar="FACTOR", help="displacements by so much")
    add_units(parser)
    parser.add_argument("--no-mesh", action="store_true", help="no lines within blocks")
    parser.add_argument("--colours", choices=plt.colormaps(), metavar="MAP", help="a colour map of matplotlib")
    parser.add_argument("--dpi", type=float, default=150)


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--history", nargs="+", metavar="NAME", help="histories to draw, as below /history, or measured_points/NAME")
    parser.add_argument("--rose", action="store_true", help="directions of the joints between blocks of the first file")
    moments = parser.add_mutually_exclusive_group()
    moments.add_argument("--frames", nargs="+", metavar="FRAME", help="default: first last")
    moments.add_argument("--stage", nargs="+", metavar="STAGE", help="the last frame of stages, by number or name; or all")
    add_words_of_frames(parser)
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="PICTURE", help="default: the first file with .png")
    given = parser.parse_args()
    output = given.output or beside(given.files[0], ".png")
    check_picture(output)
    if given.units is None and kind_of(given.files[0]) != "geometry":
        given.units = units_of_files(given.files[0], path=given.scree)
    extras, look = extras_of(given), look_of(given)
    with tempfile.TemporaryDirectory() as folder:
        if given.history:
            figure = draw_histories(given.files, given.history, look.units)
        elif given.rose:
            figure = draw_rose(open_shapes(given.files[0], given.scree, folder), look.units)
        else:
            shapes = [open_shapes(path, given.scree, folder) for path in given.files]
            figure = draw_frames(shapes, given.frames, given.field or FIELDS[0], extras, look, given.stage)
    try:
        figure.savefig(output, dpi=given.dpi, bbox_inches="tight", pad_inches=0.05)
    except (OSError, ValueError) as error:
        raise PlotError(f"{output}: cannot write the picture: {error}") from None
    print(output)
    return 0
