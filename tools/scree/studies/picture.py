"""Draws what a study found: a column of its table against each number that varies."""
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from ..errors import ScreeError
from .output import numbers_of

MOST_COLUMNS = 3  # of panels
DPI = 150


def ranks(values):
    """Places of values in order, those that are equal sharing theirs."""
    _, place, count = np.unique(values, return_inverse=True, return_counts=True)
    return (np.cumsum(count) - (count - 1) / 2)[place]


def rank_correlation(x, y):
    """Spearman's: 1 where y grows with x, -1 where it falls, whatever the law; 0 without either."""
    x, y = ranks(x), ranks(y)
    return float(np.corrcoef(x, y)[0, 1]) if np.ptp(x) > 0 and np.ptp(y) > 0 else 0.0


def drawn(names, header, lines, quantity, dimensions, units):
    """A figure with a panel for each name that varies, coloured by the name after it, in units by the dimensions of columns."""
    columns = {name: numbers_of(column) for name, column in zip(header, zip(*lines))}
    if columns.get(quantity) is None:
        known = [name for name, column in columns.items() if column is not None and name not in (*names, "run")]
        raise ScreeError(f"--draw: expected a column of numbers: {', '.join(known)}; found '{quantity}'")
    there = np.isfinite(columns[quantity])
    varied = [name for name in names if columns[name] is not None and np.ptp(columns[name]) > 0]
    if not there.any() or not varied:
        raise ScreeError(f"--draw: expected runs with {quantity} and a number that varies, found none")
    labels = {}
    for name in dict.fromkeys((quantity, *varied)):
        labels[name], factor = units.of(f"{name} [{dimensions[name]}]" if name in dimensions else name)
        columns[name] = columns[name][there] / factor
    y, wide = columns[quantity], min(len(varied), MOST_COLUMNS)
    figure, axes = plt.subplots(-(-len(varied) // wide), wide, figsize=(4.2 * wide, 3.4 * -(-len(varied) // wide)), squeeze=False,
                                sharey=True, layout="constrained")
    for axis, name, other in zip(axes.flat, varied, [*varied[1:], varied[0]]):
        x = columns[name]
        colours = dict(c=columns[other], cmap="cividis") if other != name else dict(color="0.2")
        points = axis.scatter(x, y, s=16, linewidths=0.3, edgecolors="white", **colours)
        if other != name:
            figure.colorbar(points, ax=axis, label=labels[other])
        axis.set(xlabel=labels[name], title=f"rank correlation {rank_correlation(x, y):+.2f}")
        axis.title.set_fontsize(10)
        axis.ticklabel_format(useOffset=False)
        axis.grid(True, linewidth=0.4, color="0.88")
        axis.set_axisbelow(True)
    for axis in axes.flat[len(varied):]:
        axis.set_visible(False)
    for row in axes:
        row[0].set_ylabel(labels[quantity])
    return figure


def draw(figure, path):
    """Writes a figure. Returns the path."""
    try:
        figure.savefig(path, dpi=DPI)
    except (OSError, ValueError) as problem:
        raise ScreeError(f"{path}: cannot write the picture: {problem}") from None
    return path
