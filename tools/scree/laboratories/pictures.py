"""The picture of a laboratory: stress over strain of all specimens, and one of them as it broke."""
from __future__ import annotations

import os
import typing
from collections.abc import Sequence

os.environ.setdefault("MPLBACKEND", "Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

from ..drawing import JOINT_COLOURS, ROCKS
from ..results import Results, read
from .runs import Outcome

MEGA = 1e6
SHOWN, USUAL = 0.05, 90  # displacement in the picture, over the size of the scene, of the vertices at this percentile
WORDS = {"ucs": "axial stress", "biaxial": "axial stress", "brazilian": "2P/(πD)", "shear": "shear stress", "bending": "6M/h²"}
PLATENS = "0.75"


def draw_outcomes(outcomes: Sequence[Outcome]) -> typing.Any:
    """A figure: curves on the left, one for each specimen, and on the right the first specimen at its end."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.5, 4.4), layout="constrained", width_ratios=[1.25, 1])
    pressures = list(dict.fromkeys(outcome.specimen.pressure for outcome in outcomes))
    for outcome in outcomes:
        colour = JOINT_COLOURS[pressures.index(outcome.specimen.pressure) % len(JOINT_COLOURS)]
        left.plot(1e3 * np.concatenate([[0], outcome.strain]), np.concatenate([[0], outcome.stress]) / MEGA, color=colour, linewidth=1.1)
        left.plot(1e3 * outcome.strain[outcome.peak], outcome.strength / MEGA, marker="o", markersize=4, color=colour)
    for pressure in pressures if len(pressures) > 1 else ():
        left.plot([], [], color=JOINT_COLOURS[pressures.index(pressure) % len(JOINT_COLOURS)], label=f"{pressure / MEGA:g} MPa")
    if len(pressures) > 1:
        left.legend(frameon=False, fontsize=9)
    left.set(xlabel="strain [mm/m]", ylabel=f"{WORDS[outcomes[0].specimen.kind]} [MPa]", xlim=(0, None), ylim=(0, None))
    left.grid(True, linewidth=0.4, color="0.88")
    first = read(outcomes[0].path)
    draw_broken(right, first, range(outcomes[0].grains + 1, first.n_blocks + 1))
    right.set_title(f"seed {outcomes[0].seed}, {outcomes[0].broken[0]} bonds broken in tension, {outcomes[0].broken[1]} in shear", fontsize=9)
    return figure


def draw_broken(axis: typing.Any, results: Results, platens: Sequence[int]) -> None:
    """The last frame with magnified displacements, so that cracks gape; `platens` are the numbers of blocks that are none of the grains."""
    start, moved = results.polygons(0), results.polygons(-1)
    size = np.ptp(results.vertices(0), axis=0).min()
    way = np.linalg.norm(results.displacement(-1), axis=1)
    magnified = SHOWN * size / max(np.percentile(way, USUAL), np.finfo(float).tiny)
    shapes = [before + magnified * (after - before) for before, after in zip(start, moved)]
    held = set(platens)
    for chosen, colour, line in ((True, PLATENS, "0.4"), (False, ROCKS[0], "0.35")):
        axis.add_collection(PolyCollection([shape for block, shape in zip(results.block, shapes) if (block in held) == chosen],
                                           facecolor=colour, edgecolor=line, linewidth=0.3))
    axis.set_aspect("equal")
    axis.autoscale_view()
    axis.axis("off")
    axis.text(0.5, -0.02, f"displacements {magnified:.0f} times", transform=axis.transAxes, ha="center", va="top", fontsize=8)
