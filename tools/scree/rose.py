"""Rose diagram of the joints between blocks, and of cracks that grew: how much of them runs in which direction."""
import matplotlib.pyplot as plt
import numpy as np

from .errors import PlotError
from .histories import LINES
from .overlays import parts_against_others

SECTOR = 10  # degrees
GROWN = "#000000"  # cracks that grew


def joint_directions(file):
    """Angle with x (n), in degrees from 0 to below 180, length and material of the joints between blocks at the start. What two
    blocks have in common is a part of an edge of both, and counts half for each."""
    material = file.edge_list(0)[1]
    edge, shares = parts_against_others(file)
    edge, shares = edge[material[edge] > 0], shares[material[edge] > 0]
    edges = file.places(edge, 0)
    side = (edges[:, 1] - edges[:, 0]) * (shares[:, 1:] - shares[:, :1])
    return direction_of(side), np.linalg.norm(side, axis=1) / 2, material[edge]


def growth_directions(file):
    """Likewise angle and length of the pieces by which cracks grew until the end of a run, in the places of the start."""
    if not (hasattr(file, "file") and "growth" in file.file):
        return np.empty(0), np.empty(0)
    side = file.file.growth.end[()] - file.file.growth.start[()]
    return direction_of(side), np.linalg.norm(side, axis=1)


def direction_of(side):
    """Angle of lines (n, 2) with x, in degrees from 0 to below 180."""
    angle = np.degrees(np.arctan2(side[:, 1], side[:, 0])) % 180
    return np.where(angle > 180 - 1e-9, 0.0, angle)


def sectors(angle, length):
    """Length in each sector of 10 degrees, the middle of the first at 0."""
    number = np.floor((angle + SECTOR / 2) % 180 / SECTOR).astype(int)
    return np.bincount(number, length, 180 // SECTOR)


def draw_rose(file, units):
    """The diagram: each sector as far out as the length in it, over all; joint materials and cracks that grew on each other."""
    angle, length, material = joint_directions(file)
    parts = {f"joint {k}": (angle[material == k], length[material == k], LINES[(k - 1) % len(LINES)]) for k in np.unique(material)}
    angle, length = growth_directions(file)
    if len(angle):
        parts["cracks that grew"] = angle, length, GROWN
    if not parts:
        raise PlotError(f"{file.name}: expected joints between blocks for --rose, or cracks that grew, found none")
    figure, axis = plt.subplots(figsize=(4.6, 4.6), layout="constrained", subplot_kw={"projection": "polar"})
    middle, inner = np.radians(np.arange(0, 360, SECTOR)), np.zeros(360 // SECTOR)
    total = sum(length.sum() for _, length, _ in parts.values())
    for name, (angle, length, colour) in parts.items():
        share = np.tile(sectors(angle, length) / total, 2)  # both ways of a line
        axis.bar(middle, 100 * share, np.radians(SECTOR), 100 * inner, color=colour, edgecolor="white", linewidth=0.6, label=name)
        inner += share
    label, factor = units.of("[length]")
    axis.set_title(f"{file.name}: {total / factor:.4g} {label} of joints, % in each {SECTOR} degrees", fontsize=10)
    axis.tick_params(labelsize=8)
    if len(parts) > 1:
        axis.legend(fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(-0.1, -0.1))
    return figure
