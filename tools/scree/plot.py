"""Draws results files, geometries and models: deformed shapes of frames, or histories; more files are laid over each other.

    tools/plot FILE [...] [--frames first last 10 | all] [--field stress_xx] [-o PICTURE.png]
                          [--joints] [--points] [--numbers] [--covers] [--scree PROGRAM]
    tools/plot RESULTS.h5 [...] --history rotation area energy/kinetic [-o PICTURE.png]

FILE is a results file, a geometry (.geo, .blk, .blck, block.in), whose blocks are drawn, or an analysis deck (.ana), whose elements
are drawn as set up, under its mathematical mesh where it has one. Geometries and analysis decks go through `scree cut`.

Needs Debian's python3-numpy, python3-h5py and python3-matplotlib.
"""
import argparse
import pathlib
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib import patheffects
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator

from .errors import ScreeError
from .program import cut
from .results import read

FIELDS = ("block", "material", "stress_xx", "stress_yy", "stress_xy", "major", "minor", "displacement")
LARGEST_NUMBER_OF_PANELS = 12
POINTS = {1: ("fixed point", "^", "tab:red"), 2: ("load point", "v", "tab:orange"), 3: ("measured point", "o", "tab:cyan")}
BOLTS = (("bolt", "-", "crimson"), ("bolt that has yielded", "-", "darkorange"), ("broken bolt", ":", "crimson"))  # by state
LEAST_POLYGON_WITH_A_HOLE = 8  # two triangles, and two vertices there twice


class PlotError(ScreeError):
    """What cannot be drawn."""


def loops_of(polygon):
    """Vertices of each loop of a polygon whose holes are joined by seams, edges that it runs through both ways."""
    corners = list(map(tuple, polygon))

    def part(numbers):
        n = len(numbers)
        if n >= LEAST_POLYGON_WITH_A_HOLE:
            edges = {(corners[numbers[i]], corners[numbers[(i + 1) % n]]): i for i in range(n)}
            for i in range(n - 4):
                j = edges.get((corners[numbers[i + 1]], corners[numbers[i]]), 0)
                if j >= i + 4:  # each vertex that is there twice stays where no seam starts
                    return part(numbers[:i] + numbers[j + 1:]) + part(numbers[i + 1:j])
        return [np.array(numbers)]

    return part(list(range(len(corners))))


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

    def outlines(self, frame):
        """A path an element."""
        return [outline(polygon, loops) for polygon, loops in zip(self.polygons(frame), self.shape())]

    def joint_edges(self, frame):
        """Edges by joint material; lines of the mesh and seams are none."""
        joints = np.split(self.joint, np.cumsum([len(polygon) for polygon in self.start])[:-1])
        edges, of_edge = [np.empty((0, 2, 2))], [np.empty(0, int)]
        for polygon, joint, loops in zip(self.polygons(frame), joints, self.shape()):
            for loop in loops:
                edges.append(np.stack([polygon[loop], polygon[np.roll(loop, -1)]], axis=1))
                of_edge.append(joint[loop])
        edges, of_edge = np.concatenate(edges), np.concatenate(of_edge)
        return {int(k): edges[of_edge == k] for k in np.unique(of_edge) if k > 0}

    def block_numbers(self, frame):
        """A place in each block: in the element nearest to its centroid."""
        polygons, block = self.polygons(frame), self.values(frame, "block")[0]
        found = [area_and_centroid(polygon) for polygon in polygons]
        area, centroid = np.array([a for a, _ in found]), np.array([c for _, c in found])
        places = {}
        for b in np.unique(block):
            of_block = np.flatnonzero(block == b)
            middle = area[of_block] @ centroid[of_block] / area[of_block].sum()
            e = of_block[((centroid[of_block] - middle) ** 2).sum(1).argmin()]
            places[int(b)] = place_inside(polygons[e], self.shape()[e])
        return places


class Blocks(Shapes):
    """The blocks of a block file as `scree cut` writes it (doc/decks.md); one frame."""

    def __init__(self, path, name):
        self.name, self.times = name, [None]
        numbers = np.array(path.read_text().split(), float)
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

    def title(self, frame):
        return f"{self.name}, {len(self.start)} blocks"

    def polygons(self, frame):
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
    """The frames of a results file."""

    def __init__(self, path, name):
        self.name, self.file = name, read(path)
        self.times, self.corners = self.file.times, self.file.corners()
        if len(self.times) == 0:
            raise PlotError(f"{path}: expected a frame, found none")
        self.start = self.polygons(0)
        self.joint = self.file["elements/joint"] if "elements" in self.file else np.zeros(sum(map(len, self.corners)), int)

    def title(self, frame):
        return f"{self.name}, t = {self.times[frame]:.6g}"

    def polygons(self, frame):
        """Vertices of each element."""
        vertices = self.file.vertices(frame)
        return [vertices[corners] for corners in self.corners]

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
        return given.ends[frame].reshape(-1, 2, 2), given.state[frame]

    def covers(self, frame):
        """Places of the nodes of the covers, and whether each follows others."""
        if "covers" not in self.file:
            raise PlotError(f"{self.name}: expected manifold elements for --covers, found none")
        given = self.file["covers"]
        follows = np.zeros(len(given.node), bool)
        if "follows" in given:
            follows[given.follows[:, 0] - 1] = True
        element = np.unique(given.of_element, return_index=True)[1] // 3
        return self.moved(frame, given.node, element), follows

    def values(self, frame, field):
        """One number an element, and its label."""
        if field in ("block", "material"):
            return getattr(self.file, field), field
        if field == "displacement":
            size = np.linalg.norm(self.file.displacement(frame), axis=1)
            return np.array([size[corners].mean() for corners in self.corners]), "displacement [length]"
        xx, yy, xy = self.file.stress(frame).T
        mean, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
        values = {"stress_xx": xx, "stress_yy": yy, "stress_xy": xy, "major": mean + half, "minor": mean - half}[field]
        name = {"major": "major principal stress", "minor": "minor principal stress"}.get(field, field.replace("_", " "))
        return values, f"{name} [force/length$^2$]"


def kind_of(path):
    """geometry, analysis or results, by the name."""
    path = pathlib.Path(path)
    if path.suffix in (".geo", ".blk", ".blck") or path.name == "block.in":
        return "geometry"
    return "analysis" if path.suffix == ".ana" else "results"


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


def draw_joints(axis, file, frame):
    """Edges in the colour of their joint material; returns the entries of the legend by what they say."""
    entries = {}
    for material, edges in file.joint_edges(frame).items():
        colour = f"C{(material - 1) % 10}"
        axis.add_collection(LineCollection(edges, colors=colour, linewidths=1.3))
        entries[f"joint {material}"] = Line2D([], [], color=colour, linewidth=1.3)
    return entries


def draw_points(axis, file, frame):
    """Fixed, load and measured points with a marker each."""
    entries = {}
    kinds, places = file.points(frame)
    for kind, (name, marker, colour) in POINTS.items():
        if kind in kinds:
            entries[name], = axis.plot(*places[kinds == kind].T, linestyle="none", marker=marker, color=colour, markersize=6,
                                       markeredgecolor="black", markeredgewidth=0.6)
    return entries


def draw_bolts(axis, file, frame):
    """Bolts as lines between their ends."""
    entries = {}
    ends, states = file.bolts(frame)
    for state, (name, style, colour) in enumerate(BOLTS):
        if state in states:
            axis.add_collection(LineCollection(ends[states == state], colors=colour, linestyles=style, linewidths=1.8))
            entries[name] = Line2D([], [], color=colour, linestyle=style, linewidth=1.8)
    return entries


def draw_covers(axis, file, frame):
    """Nodes of the covers, hollow where they follow others."""
    entries = {}
    places, follows = file.covers(frame)
    for name, which, face in (("cover", ~follows, "black"), ("cover that follows", follows, "none")):
        if which.any():
            entries[name], = axis.plot(*places[which].T, linestyle="none", marker="o", markersize=3, markerfacecolor=face,
                                       markeredgecolor="black", markeredgewidth=0.6)
    return entries


def draw_numbers(axis, file, frame):
    """The number of each block in it."""
    for number, place in file.block_numbers(frame).items():
        axis.annotate(str(number), place, ha="center", va="center", fontsize=7,
                      path_effects=[patheffects.withStroke(linewidth=1.5, foreground="white")])
    return {}


def draw_frames(files, words, field, extras=()):
    """A panel a frame, files below each other, one colour scale; extras draw on each panel."""
    chosen = [chosen_frames(words, len(file.times)) for file in files]
    columns = min(max(map(len, chosen)), 4)
    slots = [(file, frame) for file, frames in zip(files, chosen)
             for frame in frames + [None] * (-len(frames) % columns)]
    values = [file.values(frame, field) for file, frame in slots if frame is not None]
    low, high = min(v.min() for v, _ in values), max(v.max() for v, _ in values)
    corners = [np.vstack(file.polygons(frame)) for file, frame in slots if frame is not None]
    if draw_covers in extras:
        corners += [file.covers(frame)[0] for file, frame in slots if frame is not None]
    corners += [file.bolts(frame)[0].reshape(-1, 2) for file, frame in slots if frame is not None]
    every = np.vstack(corners + [np.vstack(file.start) for file in files])
    centre, reach = (every.min(0) + every.max(0)) / 2, 0.55 * max(np.ptp(every, axis=0).max(), 1e-300)
    rows = len(slots) // columns
    figure, axes = plt.subplots(rows, columns, figsize=(3.4 * columns + 1.2, 3.4 * rows), squeeze=False,
                                layout="constrained", sharex=True, sharey=True)
    edges = dict(edgecolors="0.6", linewidths=0.3) if draw_joints in extras else dict(edgecolors="0.15", linewidths=0.6)
    picture, entries, given = None, {}, iter(values)
    for axis, (file, frame) in zip(axes.flat, slots):
        if frame is None:
            axis.set_visible(False)
            continue
        if frame > 0:
            axis.add_collection(PathCollection(file.outlines(0), facecolors="none", edgecolors="0.7", linewidths=0.8))
        picture = PathCollection(file.outlines(frame), array=next(given)[0], cmap="viridis", **edges)
        picture.set_clim(low, high if high > low else low + 1)
        axis.add_collection(picture)
        for extra in (draw_bolts, *extras):
            entries.update(extra(axis, file, frame))
        axis.set(xlim=(centre[0] - reach, centre[0] + reach), ylim=(centre[1] - reach, centre[1] + reach), aspect="equal")
        axis.set_title(file.title(frame) if len(files) > 1 or isinstance(file, Blocks) else f"t = {file.times[frame]:.6g}",
                       fontsize=10)
    figure.supxlabel("x [length]", fontsize=10)
    figure.supylabel("y [length]", fontsize=10)
    figure.colorbar(picture, ax=axes, label=values[0][1], shrink=0.8,
                    ticks=MaxNLocator(integer=True) if field in ("block", "material") else None)
    if entries:
        axes[-1, 0].legend(entries.values(), entries.keys(), fontsize=8, frameon=False, ncols=2, loc="upper center",
                           bbox_to_anchor=(0.5, -0.12), borderaxespad=0)
    return figure


def draw_histories(paths, names):
    """A panel a history, files as lines."""
    for path in paths:
        if kind_of(path) != "results":
            raise PlotError(f"{path}: expected results files with --history, found another")
    histories = [read(path).history for path in paths]
    figure, axes = plt.subplots(len(names), 1, figsize=(7.5, 2.3 * len(names) + 0.6), squeeze=False, sharex=True,
                                layout="constrained")
    for axis, name in zip(axes.flat, names):
        for path, history in zip(paths, histories):
            known = history.series()
            if name not in known:
                raise PlotError(f"{path}: expected one of the histories {', '.join(known)}, found '{name}'")
            values = history[name].reshape(len(history.time), -1)
            for k in range(values.shape[1]):
                label = pathlib.Path(path).stem + (f" {k + 1}" if values.shape[1] > 1 else "")
                axis.plot(history.time, values[:, k], linewidth=1.2, label=label)
        axis.set_title(history.description(name), fontsize=10, loc="left")
        axis.set_ylabel(f"[{history.units(name).split(' ')[0]}]", fontsize=9)
        axis.grid(True, linewidth=0.4, color="0.85")
        axis.margins(x=0)
    if len(axes.flat[0].lines) > 1:
        axes.flat[0].legend(fontsize=8, frameon=False, ncols=3)
    axes.flat[-1].set_xlabel("time [time]")
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", metavar="FILE")
    parser.add_argument("--history", nargs="+", metavar="NAME", help="histories to draw, as below /history")
    parser.add_argument("--frames", nargs="+", metavar="FRAME", help="default: first last")
    parser.add_argument("--field", choices=FIELDS, default="block")
    parser.add_argument("--joints", action="append_const", dest="extras", const=draw_joints, help="edges by joint material")
    parser.add_argument("--covers", action="append_const", dest="extras", const=draw_covers, help="nodes of the covers")
    parser.add_argument("--points", action="append_const", dest="extras", const=draw_points, help="fixed, load, measured points")
    parser.add_argument("--numbers", action="append_const", dest="extras", const=draw_numbers, help="numbers of blocks")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    parser.add_argument("-o", "--output", help="picture; default: the first file with .png")
    given = parser.parse_args()
    try:
        with tempfile.TemporaryDirectory() as folder:
            figure = (draw_histories(given.files, given.history) if given.history else
                      draw_frames([open_shapes(path, given.scree, folder) for path in given.files], given.frames, given.field,
                                  given.extras or ()))
        output = given.output or str(pathlib.Path(given.files[0]).with_suffix(".png"))
        try:
            figure.savefig(output, dpi=130)
        except (OSError, ValueError) as error:
            raise PlotError(f"{output}: cannot write the picture: {error}") from None
    except ScreeError as error:
        print(f"tools/plot: {error}", file=sys.stderr)
        return 2
    print(output)
    return 0
