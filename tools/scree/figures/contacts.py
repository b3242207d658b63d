"""Figures of chapter 4: the entrance block E(A, B) of two convex polygons, and what a contact is told by."""
import math

import numpy as np

from .sheet import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, RED, SKY, arrow, body, figure, panels, rectangle, scene, to_pale, turned

PARALLEL = math.radians(3)  # edges whose directions differ by less are parallel, as in scree


def entrance_lines(A, B):
    """Entrance lines of two convex polygons, corners counter-clockwise, in the order of their directions.

    Each is (normal, distance, pair): A and B are apart across it by the distance; the pair is (body of the edge, edge, vertex of the
    other body). The edges of B, and those of A turned round, are merged by direction (Shi 1988).
    """
    lines = []
    for owner, own, other in (("B", B, A), ("A", A, B)):
        for k, start in enumerate(own):
            edge = own[(k + 1) % len(own)] - start
            normal = np.array([edge[1], -edge[0]]) / math.hypot(*edge)  # out of its own body
            vertex = int(np.argmin(other @ normal))
            distance = float((other[vertex] - start) @ normal)
            lines.append((normal if owner == "B" else -normal, distance, (owner, k, vertex)))
    return sorted(lines, key=lambda line: math.atan2(line[0][1], line[0][0]))


def entrance_block(A, B, reference):
    """Corners of E(A, B): the places of a reference point of A for which A and B have a point in common."""
    sums = np.array([b - a + reference for a in A for b in B])
    from shapely import geometry
    return np.array(geometry.MultiPoint(sums).convex_hull.exterior.coords)[:-1][::-1]


HOUSE = np.array([[0.0, 0.0], [2.2, 0.0], [2.2, 1.1], [1.1, 1.7], [0.0, 1.1]])
WEDGE = turned(np.array([[0.0, 0.0], [1.0, 0.0], [0.45, 0.85]]), 0.25)


@figure("entrance-block")
def draw_entrance_block(sheet):
    """Two polygons, their entrance block with its lines in order, and the list of the lines by distance."""
    left, right = panels(sheet, 1, 2, 3.1, gridspec_kw={"width_ratios": [1.5, 1]})[0]
    A, B = WEDGE + [2.0, 1.8], HOUSE
    point = A[0]
    E = entrance_block(A, B, point)
    scene(left, r"$A$, $B$ and the entrance block $E(A, B)$ of the point $a_0$")
    body(left, E, ORANGE, linestyle="--")
    body(left, B, BLUE)
    body(left, A, RED)
    left.plot(*point, "o", color=RED, markersize=4)
    left.text(point[0] + 0.08, point[1] - 0.14, "$a_0$", color=RED)
    left.text(1.05, 0.6, "$B$", color=BLUE)
    left.text(*A.mean(0), "$A$", color=RED, ha="center", va="center")
    lines = entrance_lines(A, B)
    for number, (normal, distance, (owner, _, _)) in enumerate(lines, 1):
        values = E @ normal
        side = E[np.isclose(values, values.max(), atol=1e-9)]
        middle = side.mean(0)
        left.text(*(middle + 0.16 * normal), str(number), ha="center", va="center", fontsize=8, color=BLUE if owner == "B" else RED)
    leading = max(lines, key=lambda line: line[1])
    foot = point - leading[1] * leading[0]
    arrow(left, foot, point, BLACK, "<->")
    left.text(*((foot + point) / 2 + [0.08, -0.1]), "$g$", fontsize=9)
    order = sorted(enumerate(lines, 1), key=lambda row: -row[1][1])
    colours = [BLUE if line[2][0] == "B" else RED for _, line in order]
    right.barh(range(len(order)), [line[1] for _, line in order], color=colours, alpha=0.75)
    right.set_yticks(range(len(order)), [f"{number}: {'edge of B, vertex of A' if line[2][0] == 'B' else 'edge of A, vertex of B'}"
                                         for number, line in order], fontsize=7)
    right.invert_yaxis()
    right.axvline(0, color=BLACK, linewidth=0.8)
    right.set_xlabel("distance across the entrance line")
    right.set_title("the lines by distance: the first acts")


@figure("gap-along-a-slide")
def draw_gap_along_a_slide(sheet):
    """Distances across the entrance lines as A slides along B and over its end; their maximum is the gap of the pair."""
    left, right = panels(sheet, 1, 2, 2.5)[0]
    A0, B = rectangle(0, 0.9, 0.0, 0.55), rectangle(0, 2, -1, 0)
    A0 = turned(A0, math.radians(-12), (0.45, 0.0))
    scene(left, "a block slides over an edge")
    body(left, B, BLUE)
    places = np.linspace(-0.2, 2.3, 251)
    gaps = {}
    for x in places:
        for _, distance, pair in entrance_lines(A0 + [x, 0.12], B):
            gaps.setdefault(pair[:2], {})[x] = distance
    for x in (0.2, 1.2, 2.2):
        body(left, A0 + [x, 0.12], RED, facecolor="none")
    arrow(left, (0.7, 1.0), (2.2, 1.0), GREY)
    styles = {("B", 2): (BLUE, "top face of $B$"), ("B", 1): (GREEN, "right face of $B$"), ("A", 3): (ORANGE, "left face of $A$"),
              ("A", 0): (RED, "lower face of $A$")}
    for key, (colour, label) in styles.items():
        right.plot(list(gaps[key]), list(gaps[key].values()), color=colour, label=label)
    top = [max(row[x] for row in gaps.values()) for x in places]
    right.plot(places, top, color=BLACK, linewidth=3, alpha=0.25, label="gap of the pair: the largest")
    right.set_ylim(-0.5, 0.6)
    right.set_xlabel("displacement of the block")
    right.set_ylabel("distance across the line")
    right.legend(loc="upper left")


@figure("interval")
def draw_interval(sheet):
    """The interval that two parallel edges have in common, and its two contacts."""
    axes = panels(sheet, 1, 3, 1.9)[0]
    tops = [(0.6, 1.9), (0.6, 3.4), (-0.4, 3.6)]
    titles = ["both ends at vertices of $A$", "one end at a vertex of either", "both ends at vertices of $B$"]
    for axis, (x0, x1), title in zip(axes, tops, titles):
        scene(axis, title)
        body(axis, rectangle(0, 3, -0.8, 0), BLUE)
        body(axis, rectangle(x0, x1, 0.06, 0.8), RED)
        low, high = max(0, x0), min(3, x1)
        axis.plot([low, high], [0.03, 0.03], color=ORANGE, linewidth=4, solid_capstyle="butt")
        for x, of_A in ((low, low == x0), (high, high == x1)):
            axis.plot(x, 0.06 if of_A else 0, "o", color=RED if of_A else BLUE, markersize=5)
        arrow(axis, (low, -1.0), (high, -1.0), BLACK, "<->")
        axis.text((low + high) / 2, -1.32, "$L$; each contact stands for $L/2$", ha="center", fontsize=7.5)
        axis.set_xlim(-0.6, 3.8)
        axis.set_ylim(-1.45, 1.0)


@figure("covered-faces")
def draw_covered_faces(sheet):
    """Which stretches of the faces of a row of flush blocks can be reached, and a corner that has sunk over a joint."""
    left, right = panels(sheet, 1, 2, 2.2, gridspec_kw={"width_ratios": [1.5, 1]})[0]
    scene(left, "covered (grey) and free (orange) stretches")
    for k in range(3):
        body(left, rectangle(1.6 * k, 1.6 * (k + 1), -1, 0), BLUE)
        if k:
            left.plot([1.6 * k] * 2, [-1, 0], color=GREY, linewidth=4, solid_capstyle="butt")
    left.plot([0, 0.75], [0.02, 0.02], color=ORANGE, linewidth=4, solid_capstyle="butt")
    left.plot([2.25, 4.8], [0.02, 0.02], color=ORANGE, linewidth=4, solid_capstyle="butt")
    left.plot([0.75, 2.25], [0.02, 0.02], color=GREY, linewidth=4, solid_capstyle="butt")
    body(left, rectangle(0.75, 2.25, 0.05, 0.8), RED)
    arrow(left, (2.4, 0.45), (3.3, 0.45), RED)
    scene(right, "the joint, overlap exaggerated")
    body(right, rectangle(0, 1, -1, 0), BLUE)
    body(right, rectangle(1, 2, -1, 0.0), BLUE)
    body(right, np.array([[-0.3, -0.13], [0.93, -0.13], [0.93, 0.6], [-0.3, 0.6]]), RED, facecolor="none")
    right.plot([1, 1], [-1, 0], color=GREY, linewidth=4, solid_capstyle="butt")
    right.plot(0.93, -0.13, "o", color=RED, markersize=4)
    arrow(right, (0.95, -0.13), (1.35, -0.13), RED)
    right.text(1.1, -0.75, "covered side:\nstops nothing", fontsize=7.5)
    right.set_ylim(-1.05, 0.65)


@figure("memory-by-arc-length")
def draw_memory_by_arc_length(sheet):
    """A contact that goes from one feature to the next of E keeps its place along the outlines."""
    left, right = panels(sheet, 1, 2, 2.4)[0]
    B = np.array([[0.0, -0.8], [3.4, -0.8], [3.4, 0.0], [2.3, 0.28], [1.1, 0.28], [0.0, 0.0]])
    scene(left, "vertex of $A$ on three faces of $B$ in turn")
    body(left, B, BLUE)
    shape = np.array([[0.0, 0.0], [0.45, 0.55], [0.0, 1.0], [-0.45, 0.55]])
    stops = [(0.6, 0.153, PINK), (1.7, 0.28, RED), (2.9, 0.127, GREEN)]
    for x, y, colour in stops:
        body(left, shape * 0.75 + [x, y], colour, facecolor="none")
    s = [0.0, math.hypot(1.1, 0.28), 1.2 + math.hypot(1.1, 0.28), 1.2 + 2 * math.hypot(1.1, 0.28)]
    for x, y, label in ((0, 0, "$s_0$"), (1.1, 0.28, "$s_1$"), (2.3, 0.28, "$s_2$"), (3.4, 0, "$s_3$")):
        left.plot(x, y, ".", color=BLACK)
        left.text(x, y - 0.25, label, ha="center", fontsize=8)
    left.set_xlim(-0.2, 3.6)
    for k, colour in enumerate((PINK, RED, GREEN)):
        right.axvspan(s[k], s[k + 1], color=to_pale(colour), zorder=0)
    path = np.linspace(0.25, 3.2, 50)
    shear = np.minimum(1.0, 1.6 * (path - 0.25))
    right.plot(path, shear, color=BLACK, label="shear force over its limit")
    right.plot(path, 0.35 * np.maximum(0, path - 0.875), color=ORANGE, label="path slid, wear")
    right.set_xticks(s, ["$s_0$", "$s_1$", "$s_2$", "$s_3$"])
    right.set_xlabel("arc length of the contact along $B$")
    right.set_yticks([0, 1])
    right.legend(loc="lower right")


@figure("reach")
def draw_reach(sheet):
    """How far a vertex is looked around it."""
    axis = panels(sheet, 1, 1, 1.9)[0, 0]
    scene(axis)
    body(axis, np.array([[0.0, 0.4], [0.9, 0.0], [1.9, 0.5], [1.7, 1.1], [0.2, 1.1]]), RED)
    body(axis, rectangle(-1.4, 4.2, -1.2, -0.62), BLUE)
    vertex = np.array([0.9, 0.0])
    arrow(axis, vertex, vertex + [0.55, -0.35], BLACK)
    axis.text(1.5, -0.36, r"$v\,\Delta t$")
    angle = np.linspace(0, 2 * math.pi, 200)
    for radius, colour, label in ((0.25, SKY, r"at rest: $10^{-3}$ of the edges, or 19 times the overlap"),
                                  (0.25 + 1.2 * 0.65, ORANGE, r"in the step: also $1.2\,|v|\,\Delta t$ and margin")):
        axis.plot(vertex[0] + radius * np.cos(angle), vertex[1] + radius * np.sin(angle), color=colour, label=label)
    axis.legend(loc="center left", bbox_to_anchor=(0.56, 0.8))
    axis.set_xlim(-1.5, 4.6)
    axis.set_ylim(-1.25, 1.25)
