"""Pictures of a rock fall: paths over the slope, envelopes along it, histograms."""
from __future__ import annotations

import os
import typing

os.environ.setdefault("MPLBACKEND", "Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.lines import Line2D

from ..drawing import JOINT_COLOURS, ROCKS
from .runs import Path
from .scene import BARRIER, KILO, RockFall

WIDE = 8.0          # inches
PLACES = 200        # of an envelope
USUAL = 95          # percentile that an envelope shows beside the largest
COLOURS = {"rest": "#0072B2", "out": "#D55E00", "moving": "0.4"}
MEASURES = {"height": "height of the centre above the slope [m]", "speed": "speed [m/s]", "energy": "kinetic energy [kJ]"}


def envelopes(scene: RockFall, paths: list[Path]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Places along x (n), and of each measure the values of all rocks there (n, rocks): the largest between two places; nan where a rock did
    not come."""
    ends = np.linspace(scene.slope[0, 0], scene.slope[-1, 0], PLACES + 1)
    found = {name: np.full((PLACES, len(paths)), np.nan) for name in MEASURES}
    for k, path in enumerate(paths):
        fine = np.linspace(0, len(path.time) - 1, 4 * len(path.time))
        x, y, speed, energy = (np.interp(fine, np.arange(len(path.time)), values)
                               for values in (*path.place.T, path.speed, path.energy))
        cell = np.clip(np.searchsorted(ends, x, side="right") - 1, 0, PLACES - 1)
        height = scene.height_above(np.stack([x, y], axis=1))
        for name, values in (("height", height), ("speed", speed), ("energy", energy / KILO)):
            largest = np.full(PLACES, -np.inf)
            np.maximum.at(largest, cell, values)
            found[name][:, k] = np.where(np.isfinite(largest), largest, np.nan)
    return (ends[1:] + ends[:-1]) / 2, found


def draw_slope(axis: typing.Any, scene: RockFall) -> None:
    """The ground, its materials, the barrier and the collectors."""
    x, y = scene.slope.T
    axis.fill_between(x, y, y.min() - 0.05 * np.ptp(x), color=ROCKS[0], linewidth=0)
    names = list(scene.materials)
    for k, name in enumerate(scene.ground):
        axis.plot(x[k:k + 2], y[k:k + 2], color=JOINT_COLOURS[names.index(name) % len(JOINT_COLOURS)], linewidth=2.2, solid_capstyle="round")
    surface, parts = scene.surface()
    wall = [surface[k:k + 2] for k, part in enumerate(parts) if part == BARRIER]
    if wall:
        axis.fill(*np.vstack([wall[0][:1], *(piece[1:] for piece in wall)]).T, color="black", zorder=4)
    for name, place in scene.collectors.items():
        foot = np.interp(place, x, y)
        axis.plot([place, place], [foot, foot + 0.12 * np.ptp(x)], color="black", linewidth=1, linestyle=(0, (4, 2)))
        axis.text(place, foot + 0.125 * np.ptp(x), name, ha="center", fontsize=8)


def draw_paths(scene: RockFall, paths: list[Path]) -> typing.Any:
    """A figure: the paths of all rocks over the slope, and envelopes of bounce height, speed and energy below."""
    tall = min(1.0, max(0.3, (np.ptp(np.vstack([path.place for path in paths])[:, 1]) + 1) / np.ptp(scene.slope[:, 0])))
    figure, axes = plt.subplots(4, 1, figsize=(WIDE, WIDE * tall + 5.2), sharex=True, layout="constrained",
                                height_ratios=[WIDE * tall, 1.5, 1.5, 1.5])
    top = axes[0]
    draw_slope(top, scene)
    for path in paths:
        top.plot(*path.place.T, color=COLOURS[path.end], linewidth=0.5, alpha=0.5)
    for end, colour in COLOURS.items():
        places = np.array([path.place[-1] for path in paths if path.end == end]).reshape(-1, 2)
        top.plot(*places.T, linestyle="none", marker="o", markersize=2.5, color=colour)
    names = list(scene.materials)
    entries = [Line2D([], [], color=JOINT_COLOURS[names.index(name) % len(JOINT_COLOURS)], linewidth=2.2, label=name)
               for name in dict.fromkeys(scene.ground)]
    count = {end: sum(path.end == end for path in paths) for end in COLOURS}
    words = {"rest": "come to rest", "out": "leave the slope", "moving": "still move"}
    entries += [Line2D([], [], color=COLOURS[end], label=f"{number} {words[end]}") for end, number in count.items() if number]
    top.legend(handles=entries, fontsize=8, frameon=False, loc="upper right")
    top.set_aspect("equal", adjustable="datalim")
    top.set(xlim=scene.slope[[0, -1], 0], title=f"{scene.title}: {len(paths)} rocks", ylabel="y [m]")
    x, found = envelopes(scene, paths)
    for axis, (name, label) in zip(axes[1:], MEASURES.items()):
        there = np.isfinite(found[name]).any(axis=1)
        axis.plot(x[there], np.nanmax(found[name][there], axis=1), color="#D55E00", linewidth=1.2, label="largest")
        axis.plot(x[there], np.nanpercentile(found[name][there], USUAL, axis=1), color="#0072B2", linewidth=1.2, label=f"{USUAL} % of the rocks there")
        axis.set_ylabel(label.replace(" of the centre above the slope", ""), fontsize=9)
        axis.grid(True, linewidth=0.4, color="0.88")
        axis.set_ylim(bottom=0)
    axes[1].legend(fontsize=8, frameon=False, ncols=2)
    axes[-1].set_xlabel("x [m]")
    return figure


def draw_histograms(scene: RockFall, paths: list[Path], collected: dict[str, list[dict[str, float]]]) -> typing.Any:
    """A figure of histograms: where rocks end, and for each collector height, speed and energy."""
    figure, axes = plt.subplots(1 + len(collected), 3, figsize=(WIDE, 2.3 * (1 + len(collected))), layout="constrained", squeeze=False)
    ends = [path.place[-1, 0] for path in paths if path.end != "out"]
    whole = axes[0, 0].get_gridspec()
    for axis in axes[0]:
        axis.remove()
    top = figure.add_subplot(whole[0, :])
    histogram(top, ends, "x where rocks end [m]", 30)
    top.set_title(f"{len(ends)} of {len(paths)} rocks end on the slope", fontsize=10)
    for row, (name, rows) in zip(axes[1:], collected.items()):
        for axis, (measure, label) in zip(row, MEASURES.items()):
            histogram(axis, [one[measure] / (KILO if measure == "energy" else 1) for one in rows], label.replace(" of the centre above the slope", ""), 15)
        row[0].set_title(f"{name}: {len(rows)} rocks", fontsize=10, loc="left")
    return figure


def histogram(axis: typing.Any, values: list[float], label: str, bins: int) -> None:
    """Counts of values; nothing where there are none."""
    if values:
        axis.hist(values, bins=bins, color="#0072B2", edgecolor="white", linewidth=0.5)
    axis.set_xlabel(label, fontsize=9)
    axis.tick_params(labelsize=8)
