"""What acts on the rock of a picture: water, supports, loads, absorbing edges, and bolts by their force.

`draw_conditions(axis, file, frame, common)` draws on a panel and returns the entries of the legend, as all of overlays.py do.
"""
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from .in_force import numbers, settings_of_frame
from .model.views import tolerance_of
from .polygons import on_lines
from .units import number

LINE, PLACE, TRACTION = 4, 2, 4  # numbers of a line x1 y1 x2 y2, of a place, of the traction at both ends of a line
FIXED, LOADED = 1, 2  # kinds of points
HATCH = r"$////$"
WATER, SUPPORT, LOAD, QUIET = "#0072B2", "0.25", "#CC79A7", "#009E73"
HOLDS = ("both", "normal", "x", "y", "moved")
STROKE = 0.012      # of the strokes of a support and of the signs of a support and a water table, over the size of a picture
ARROW = 0.08        # of the longest arrow of a load
ALONG = 0.03        # between the arrows of a line
BOLTS = (("bolt", "-", "crimson"), ("bolt that has yielded", "-", "darkorange"), ("broken bolt", ":", "crimson"))  # by state
THIN, THICK = 0.8, 3.4  # widths of a bolt without force and of the one with the largest


def draw_conditions(axis, file, frame, common):
    """Water, supports, loads and absorbing edges of a frame; nothing of a geometry."""
    if not hasattr(file, "file"):
        return {}
    settings, size, entries = settings_of_frame(file.file, frame), common.size, {}
    draw_water(axis, numbers(settings, "water.table"), size, entries)
    for hold in HOLDS:
        edges = edges_on(file, frame, numbers(settings, f"support.{hold}"))
        if len(edges):
            draw_support(axis, edges, hold, size)
            name = {"both": "fixed support", "moved": "moved support"}.get(hold, "roller support")
            entries[name] = Line2D([], [], color=SUPPORT, linestyle="none", marker=HATCH if hold == "both" else "o", markersize=5,
                                   markeredgewidth=0.8, markerfacecolor=SUPPORT if hold == "both" else "none")
    kinds, points = file.points(frame)
    if FIXED in kinds:
        entries["fixed point"], = axis.plot(*points[kinds == FIXED].T, linestyle="none", marker="^", color=SUPPORT, markersize=6)
    draw_loads(axis, file, frame, settings, common, entries)
    edges = np.concatenate([edges_on(file, frame, numbers(settings, f"absorbing.{which}")) for which in ("lines", "sides", "base")])
    if len(edges):
        axis.add_collection(LineCollection(edges, colors=QUIET, linewidths=3, linestyles=(0, (2, 1)), zorder=3, label="absorbing edge"))
        entries["absorbing edge"] = Line2D([], [], color=QUIET, linewidth=3, linestyle=(0, (2, 1)))
    return entries


def edges_on(file, frame, lines):
    """Edges (n, 2, 2) in a frame that lay on lines x1 y1 x2 y2 at the start, those that are there."""
    if not lines:
        return np.empty((0, 2, 2))
    rows = file.faces(frame)
    start = file.places(rows, 0)
    return file.places(rows[on_lines(start.mean(axis=1), start[:, 1] - start[:, 0], np.reshape(lines, (-1, LINE)), tolerance_of(file.file))], frame)


def outwards(edges):
    """Unit vectors along edges, and across them out of the rock, whose corners run counter-clockwise (n, 2)."""
    way = edges[:, 1] - edges[:, 0]
    way = way / np.linalg.norm(way, axis=1)[:, None]
    return way, np.stack([way[:, 1], -way[:, 0]], axis=1)


def places_along(edges, spacing):
    """Places on edges in about equal distances (n, 2), one at least on each, and the edge of each (n)."""
    counts = np.maximum(1, np.rint(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1) / spacing)).astype(int)
    edge = np.repeat(np.arange(len(edges)), counts)
    share = np.concatenate([(np.arange(n) + 0.5) / n for n in counts])
    return edges[edge, 0] + share[:, None] * (edges[edge, 1] - edges[edge, 0]), edge


def draw_water(axis, table, size, entries):
    """A water table, level beyond its ends, with the sign of water at its highest place."""
    if not table:
        return
    x, y = np.reshape(table, (-1, PLACE)).T
    left, right = axis.get_xlim()
    x, y = np.concatenate([[min(left, x[0])], x, [max(right, x[-1])]]), np.concatenate([y[:1], y, y[-1:]])
    axis.plot(x, y, color=WATER, linewidth=1.6, linestyle=(0, (6, 2)), zorder=4, label="_water")
    inside = np.clip(np.array([left, right]) + [2 * STROKE * size, -2 * STROKE * size], left, right)
    at = inside[np.interp(inside, x, y).argmax()]
    axis.plot(at, np.interp(at, x, y) + STROKE * size, marker="v", color=WATER, markersize=7, markerfacecolor="white", zorder=4, label="_water")
    entries["water table"] = Line2D([], [], color=WATER, linewidth=1.6, linestyle=(0, (6, 2)))


def draw_support(axis, edges, hold, size):
    """A support as strokes, and as circles where it lets the rock slide."""
    way, out = outwards(edges)
    axis.add_collection(LineCollection(edges, colors=SUPPORT, linewidths=1.8, zorder=3))
    places, edge = places_along(edges, 2 * STROKE * size)
    if hold == "both":
        axis.add_collection(LineCollection(np.stack([places, places + STROKE * size * (out - way)[edge]], axis=1), colors=SUPPORT,
                                           linewidths=0.9, zorder=3, label="fixed support"))
    else:
        axis.plot(*(places + 0.5 * STROKE * size * out[edge]).T, linestyle="none", marker="o", markersize=3, color=SUPPORT,
                  markerfacecolor="white", markeredgewidth=0.8, zorder=3, label="_roller support")


def draw_loads(axis, file, frame, settings, common, entries):
    """Pressure and traction on edges as arrows, the largest as long as ARROW; forces on points as arrows of that length."""
    lines = np.reshape(numbers(settings, "boundary.lines"), (-1, LINE))
    pressure = numbers(settings, "boundary.pressure") or [0.0] * (2 * len(lines))
    traction = numbers(settings, "boundary.traction") or [0.0] * (TRACTION * len(lines))
    tails, heads = [np.empty((0, 2))], [np.empty((0, 2))]
    rows = file.faces(frame)
    start, now = file.places(rows, 0), file.places(rows, frame)
    for line, ends, pull in zip(lines, np.reshape(pressure, (-1, 2)), np.reshape(traction, (-1, 2, 2))):
        own = on_lines(start.mean(axis=1), start[:, 1] - start[:, 0], [line], tolerance_of(file.file))
        edges, before = now[own], start[own]
        if len(edges) == 0:
            continue
        places, edge = places_along(edges, ALONG * common.size)
        at, _ = places_along(before, ALONG * common.size)
        side = line[2:] - line[:2]
        if len(at) != len(places):  # edges have stretched by a place
            at = before[edge].mean(axis=1)
        share = np.clip((at - line[:2]) @ side / (side @ side), 0, 1)[:, None]
        load = -(ends[0] + share * (ends[1] - ends[0])) * outwards(edges)[1][edge] + pull[0] + share * (pull[1] - pull[0])
        tails.append(places)
        heads.append(load)
    places, load = np.concatenate(tails), np.concatenate(heads)
    largest = max(np.abs(pressure).max(initial=0.0), np.linalg.norm(np.reshape(traction, (-1, 2)), axis=1).max(initial=0.0))
    if load.any():
        arrows(axis, places, ARROW * common.size / largest * load)
        unit, factor = common.units.of("[force/length$^2$]")
        entries[f"load, at most {number(float(largest / factor))} {unit}"] = arrow_of_legend()
    kinds, points = file.points(frame)
    force = np.reshape(numbers(settings, "loads.force"), (-1, 2))
    points = points[kinds == LOADED]
    if len(force) == len(points) and force.any():
        largest = np.linalg.norm(force, axis=1).max()
        arrows(axis, points, ARROW * common.size / largest * force)
        unit, factor = common.units.of("[force/length]")
        entries[f"force, at most {number(float(largest / factor))} {unit}"] = arrow_of_legend()


def arrows(axis, heads, ways):
    """Arrows that end at places."""
    axis.quiver(*(heads - ways).T, *ways.T, angles="xy", scale_units="xy", scale=1, width=0.0025, color=LOAD, zorder=4)


def arrow_of_legend():
    return Line2D([], [], color=LOAD, linestyle="none", marker=r"$\rightarrow$", markersize=11)


def draw_bolts(axis, file, frame, common):
    """Bolts as lines between their ends, by state, the thicker the larger their force; the legend has the largest."""
    entries = {}
    ends, states = file.bolts(frame)
    force = forces_of_bolts(file, frame, len(ends))
    largest = np.abs(force).max(initial=0.0)
    width = np.full(len(ends), 1.8) if largest == 0 else THIN + (THICK - THIN) * np.abs(force) / largest
    for state, (name, style, colour) in enumerate(BOLTS):
        own = states == state
        if own.any():
            axis.add_collection(LineCollection(ends[own], colors=colour, linestyles=style, linewidths=width[own], zorder=3))
            top = np.abs(force[own]).max()
            unit, factor = common.units.of("[force/length]")
            words = f", at most {number(float(top / factor))} {unit}" if top > 0 else ""
            entries[name + words] = Line2D([], [], color=colour, linestyle=style, linewidth=width[own].max())
    return entries


def forces_of_bolts(file, frame, n):
    """The force of each bolt; 0 of a geometry."""
    return file.file.bolts.force[frame] if hasattr(file, "file") and "bolts" in file.file else np.zeros(n)
