"""The last frames of hard runs as one picture."""
import math

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import PolyCollection

from ..results import read
from .cases import CASES
from .judge import FAILS, PASSES, REFUSED

ACROSS = 6
COLOURS = {PASSES: "black", REFUSED: "tab:blue", FAILS: "tab:red"}


def draw_sheet(runs, path):
    """Draws runs (case, way, judgement, results file) into a picture, a panel each: what is fixed grey, the start dotted."""
    down = math.ceil(len(runs) / ACROSS)
    figure, panels = plt.subplots(down, ACROSS, figsize=(3 * ACROSS, 2.6 * down), squeeze=False, layout="constrained")
    for panel in panels.flat:
        panel.set_axis_off()
    for panel, (name, way, found, file) in zip(panels.flat, runs):
        r, scene = read(file), CASES[name].make()
        scene.meet(r)
        moves = np.isin(r.block - 1, scene.moving())
        start, now = r.polygons(0), r.polygons(-1)
        panel.add_collection(PolyCollection([p for p, m in zip(now, moves) if not m], facecolor="0.8", edgecolor="0.6", lw=0.5))
        panel.add_collection(PolyCollection([p for p, m in zip(start, moves) if m], facecolor="none", edgecolor="0.6", ls=":", lw=0.4))
        panel.add_collection(PolyCollection([p for p, m in zip(now, moves) if m], facecolor="wheat", edgecolor="black", lw=0.4))
        seen = np.concatenate([p for frame in (start, now) for p, m in zip(frame, moves) if m])
        middle, half = (seen.min(0) + seen.max(0)) / 2, 0.55 * max(np.ptp(seen, axis=0).max(), way.edge)
        panel.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half), aspect="equal")
        more = "" if way.restitution == "none" else f", e {way.restitution}"
        panel.set_title(f"{name}, {way.edge:g} m, {way.step:g} ms, {way.strain}{more}\n{found.verdict}", fontsize=7,
                        color=COLOURS.get(found.verdict, "tab:orange"))
    figure.savefig(path, dpi=110)
    plt.close(figure)
