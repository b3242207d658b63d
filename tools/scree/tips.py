"""Tips of cracks in pictures and reports: where they are in a frame, and their stress intensity."""
from __future__ import annotations

import dataclasses

import numpy as np
from matplotlib import patheffects

from .model.views import distance_to

TIP = "#F0E442"   # yellow of Okabe and Ito, which nothing else has
MOST_WORDS = 12   # tips of a panel, beyond which their numbers are left out
INTENSITY = "[force/length$^2$*length$^(1/2)$]"


@dataclasses.dataclass
class Tip:
    """A tip in a frame: its number from 1, the element that holds it, from 0, with weights of the vertices
    of this element, and K_I and K_II, which are 0 where they are not measured."""

    number: int
    element: int
    weights: np.ndarray
    intensity: tuple[float, float]


def tips_of(file, frame):
    """The tips that are there in a frame, by the step that it is the end of; none at the start, and of a run without `output.cracks`."""
    step = file.file.frame_steps[frame] - 1 if hasattr(file, "file") and "cracks" in file.file.history else -1
    if step < 0:
        return []
    cracks, polygons, there, found = file.file.history.cracks, file.polygons(frame, magnified=False), file.present(frame), []
    low, high = (np.array([side(polygon, axis=0) for polygon in polygons]) for side in (np.min, np.max))
    for k in np.flatnonzero(cracks.length[step] > 0):
        place = cracks.place[step, k]
        apart = np.where(there, np.linalg.norm(np.clip(place, low, high) - place, axis=1), np.inf)
        near = np.flatnonzero(apart <= apart.min())
        element = int(near[np.argmin([distance_to(polygons[e], place) for e in near])])
        found.append(Tip(int(k) + 1, element, weights_of(polygons[element], place), (float(cracks.K_I[step, k]), float(cracks.K_II[step, k]))))
    return found


def weights_of(polygon, place):
    """Weights of the vertices of an element whose field is linear (n), with which its places are those of a place in it."""
    return np.linalg.pinv(np.column_stack([polygon - place, np.ones(len(polygon))]).T)[:, 2]


def draw_tips(axis, file, frame, common):
    """A mark at each tip, with its stress intensity factors where the tips are few."""
    tips = tips_of(file, frame)
    if not tips:
        return {}
    label, factor = common.units.of(INTENSITY)
    polygons = file.polygons(frame)
    places = np.array([tip.weights @ polygons[tip.element] for tip in tips])
    mark, = axis.plot(*places.T, linestyle="none", marker="o", markersize=4, color=TIP, markeredgecolor="black", markeredgewidth=0.6, zorder=6)
    for place, tip in zip(places, tips if len(tips) <= MOST_WORDS else []):
        words = "$K_I$ {:.3g}, $K_{{II}}$ {:.3g}".format(*(value / factor for value in tip.intensity)) if any(tip.intensity) else "not measured"
        right = place[0] > np.mean(axis.get_xlim())
        axis.annotate(words, place, (-4 if right else 4, 5), textcoords="offset points", ha="right" if right else "left", fontsize=6, zorder=6,
                      path_effects=[patheffects.withStroke(linewidth=1.5, foreground="white")], annotation_clip=True).set_in_layout(False)
    return {f"crack tip, K {label}": mark}
