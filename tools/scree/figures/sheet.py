"""What all figures of the theory have in common: a register, a size, colours, arrows and polygons."""
import math

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, Polygon

from ..histories import LINES

BLUE, RED, GREEN, PINK, ORANGE, SKY, BLACK, GREY = LINES
WIDTH = 6.6        # inches, of the text of a page
RESOLUTION = 130   # dots an inch
FONT = {"font.size": 8.5, "axes.titlesize": 8.5, "legend.fontsize": 7.5, "axes.spines.top": False, "axes.spines.right": False,
        "legend.frameon": False, "mathtext.fontset": "cm", "lines.linewidth": 1.4}
FIGURES = {}       # drawing functions by the name of their picture, in the order of the chapters


def figure(name):
    """Registers a function that draws on a Figure of matplotlib as that of the picture `name`.png."""
    def register(draw):
        FIGURES[name] = draw
        return draw
    return register


def drawn(draw):
    """The figure that a function draws."""
    sheet = Figure(dpi=RESOLUTION, layout="constrained")
    FigureCanvasAgg(sheet)
    draw(sheet)
    return sheet


def panels(sheet, rows, columns, height, **options):
    """Axes (rows, columns) of a sheet as wide as the text."""
    sheet.set_size_inches(WIDTH, height)
    return sheet.subplots(rows, columns, squeeze=False, **options)


def scene(axis, title=""):
    """Makes an axis a picture of bodies: equal scales and no frame."""
    axis.set_aspect("equal")
    axis.axis("off")
    axis.set_title(title)


def body(axis, corners, colour=BLUE, **options):
    """Draws a polygon (n, 2)."""
    style = {"facecolor": to_pale(colour), "edgecolor": colour, "linewidth": 1.2, **options}
    axis.add_patch(Polygon(np.asarray(corners, float), closed=True, **style))
    axis.update_datalim(corners)
    axis.autoscale_view()


def arrow(axis, start, end, colour=BLACK, style="-|>", **options):
    """Draws an arrow from a point to another one."""
    axis.annotate("", xy=end, xytext=start, arrowprops={"arrowstyle": style, "color": colour, "linewidth": 1.1, "shrinkA": 0,
                                                        "shrinkB": 0, "mutation_scale": 9, **options})


def box(axis, middle, text, width=1.0, height=0.34, colour=BLUE):
    """Draws a box of a flow chart with a text in it."""
    x, y = middle
    axis.add_patch(FancyBboxPatch((x - width / 2, y - height / 2), width, height, boxstyle="round,pad=0.02,rounding_size=0.05",
                                  facecolor=to_pale(colour), edgecolor=colour, linewidth=1.1))
    axis.text(x, y, text, ha="center", va="center", fontsize=7.5)


def to_pale(colour, share=0.16):
    """A colour mixed with white."""
    parts = [int(colour[i:i + 2], 16) / 255 for i in (1, 3, 5)]
    return tuple(1 - share * (1 - part) for part in parts)


def turned(points, angle, about=(0.0, 0.0)):
    """Points (n, 2) turned by an angle in rad."""
    c, s = math.cos(angle), math.sin(angle)
    return (np.asarray(points, float) - about) @ np.array([[c, s], [-s, c]]) + about


def rectangle(x0, x1, y0, y1):
    """Corners of a rectangle, counter-clockwise."""
    return np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]], float)
