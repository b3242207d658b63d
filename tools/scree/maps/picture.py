"""The picture of a map as a deck has it: lines by joint material, what was extended, ends in the rock, points."""
import os

os.environ.setdefault("MPLBACKEND", "Agg")  # unless something else draws here, as a notebook does
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection

SIDE = 8.0      # inches of the longer side
MOST_NAMES = 12  # of joint materials in the legend
POINTS = {"load": "v", "measured": "o", "hole": "x"}


def draw(deck, path):
    """Writes the picture of a Deck."""
    lines = {kind: np.array([line[:4] for line in deck.lines[kind]]).reshape(-1, 2, 2) for kind in list(deck.lines)}
    places = np.vstack([rows.reshape(-1, 2) for rows in lines.values()])
    low, size = places.min(0), np.maximum(np.ptp(places, axis=0), 1e-3 * np.ptp(places, axis=0).max())
    figure, axis = plt.subplots(figsize=np.clip(SIDE * size / size.max(), SIDE / 3, SIDE) + [1.0, 1.2], layout="constrained")

    def put(rows, name, **how):
        if len(rows):
            axis.add_collection(LineCollection(np.asarray(rows, float).reshape(-1, 2, 2), label=name, **how))

    numbers = np.array([line[4] for line in deck.lines["joint"]], int)
    shades = plt.get_cmap("tab10").colors[:3] + plt.get_cmap("tab10").colors[4:]
    for k, number in enumerate(np.unique(numbers)):
        put(lines["joint"][numbers == number], f"joint material {number}" if k < MOST_NAMES else None, color=shades[k % len(shades)], lw=0.8)
    put(deck.ends.added, "extended", color="tab:red", lw=1.6)
    put(lines["boundary"], "boundary", color="black", lw=1.6)
    for kind, name, style in (("material", "material line", ":"), ("fixed", "fixed line", "--"), ("bolt", "bolt", "-."), ("water", "water", "-")):
        put(lines.get(kind, ()), name, color="tab:blue" if kind == "water" else "dimgrey", lw=1.2, ls=style)
    for kind, marker in POINTS.items():
        if deck.points[kind]:
            axis.plot(*np.array(deck.points[kind]).T, marker, color="black", ms=4, label=f"{kind} point")
    if deck.ends.loose:
        axis.plot(*np.array(deck.ends.loose).T, ".", color="tab:red", ms=3, label="end in the rock")
    margin = 0.02 * size.max()
    axis.set(xlim=(low[0] - margin, low[0] + size[0] + margin), ylim=(low[1] - margin, low[1] + size[1] + margin), aspect="equal")
    axis.ticklabel_format(style="plain", useOffset=False)
    if axis.get_legend_handles_labels()[0]:
        axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=3, fontsize="small", frameon=False)
    figure.savefig(path, dpi=150, bbox_inches="tight")
    plt.close(figure)
