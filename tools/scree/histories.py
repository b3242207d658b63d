"""Histories of a run as columns that have names: series of /history, and those of measured points."""
import dataclasses
import re

import numpy as np

from .errors import PlotError

COLUMNS = {"contacts": ("open", "sliding", "locked"), "momentum": ("x", "y", "angular")}  # of series that are no blocks
PANELS = {"momentum": {"x, y": slice(0, 2), "angular": slice(2, 3)}}  # columns of one dimension, where a series has several, in their order
LINES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000", "#999999")  # of curves: Okabe and Ito (2008)
PARTS = {2: ("x", "y"), 3: ("xx", "yy", "xy")}  # of vectors and stresses
MEASURED, TIPS = "measured_points/", "cracks/"


@dataclasses.dataclass
class History:
    """Values (s, n) with the names of the columns, none where there is one; the dimension, and what it is in words."""

    values: np.ndarray
    names: list
    dimension: str
    description: str


def names_of_histories(results):
    """All that there are."""
    measured = results.measured_points.series() if "measured_points" in results else []
    return [*results.history.series(), *(f"{MEASURED}{name}" for name in measured)]


def is_static(results):
    """Whether all stages of a run are static: no time passes, its steps count."""
    return all(results.is_static(int(frame)) for frame in np.unique(results.frame_stages, return_index=True)[1])


def axis_of(results, units, static):
    """What histories are drawn along, in words, and where each step is there: at its number in a static run, else at its time."""
    label, factor = ("step", 1.0) if static else units.of("time [time]")
    steps = np.arange(1, len(results.history.time) + 1) if static else results.clock
    return label, steps / factor


def histories_of(results, name):
    """What a name below /history, or measured_points/NAME, stands for: one history, or one for each dimension that its columns have.
    PlotError where there is none."""
    if name not in names_of_histories(results):
        raise PlotError(f"{results.path}: expected one of the histories {', '.join(names_of_histories(results))}, found '{name}'")
    group, own = (results.measured_points, name.removeprefix(MEASURED)) if name.startswith(MEASURED) else (results.history, name)
    values, what = group[own], group.description(own)
    if len(values) == 0:
        raise PlotError(f"{results.path}: expected steps, found none: there is no history of {name}")
    if values.ndim == 3 and name.startswith(TIPS):  # noqa: PLR2004  tips and parts of vectors
        names = [f"tip {i + 1}, {part}" for i in range(values.shape[1]) for part in PARTS[values.shape[2]]]
    elif values.ndim == 3:  # noqa: PLR2004  points and parts of vectors
        places = [", ".join(f"{x:.4g}" for x in place) for place in results.given_points("measured")]
        names = [f"point {i + 1} at ({place}), {part}" for i, place in enumerate(places) for part in PARTS[values.shape[2]]]
        what = f"{what}, of measured points"
    elif values.ndim == 1:
        names = [""]
    else:
        names = list(COLUMNS.get(name, ())) or [f"{'tip' if name.startswith(TIPS) else 'block'} {i + 1}" for i in range(values.shape[1])]
    values, units = values.reshape(len(values), -1), group.units(own)
    if name not in PANELS:
        return [History(values, names, units, what)]
    dimensions = re.findall(r"(\S+) \(", units)  # as in mass*length/time (x, y), mass*length^2/time (about the origin)
    return [History(values[:, columns], names[columns], dimension, f"{what}: {part}")
            for (part, columns), dimension in zip(PANELS[name].items(), dimensions, strict=True)]
