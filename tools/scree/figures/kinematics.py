"""Figures of chapter 2: what blocks and covers move by, and what small strain makes of a rotation."""
import math

import numpy as np

from .sheet import BLACK, BLUE, GREEN, GREY, ORANGE, RED, SKY, arrow, body, box, figure, panels, rectangle, scene, to_pale

SQUARE = rectangle(-0.5, 0.5, -0.5, 0.5)


def moved_by(unknowns, points):
    """Positions to which a step of a DDA block with (u0, v0, r0, ex, ey, gxy) moves points, about the centroid."""
    u, v, r, ex, ey, g = unknowns
    return points + np.array([u, v]) + points @ np.array([[ex, r + g / 2], [g / 2 - r, ey]])


@figure("block-freedoms")
def draw_block_freedoms(sheet):
    """The six unknowns of a block of the DDA, each alone."""
    axes = panels(sheet, 1, 6, 1.55)[0]
    names = ["$u_0$", "$v_0$", "$r_0$", r"$\varepsilon_x$", r"$\varepsilon_y$", r"$\gamma_{xy}$"]
    for k, axis in enumerate(axes):
        unknowns = np.zeros(6)
        unknowns[k] = 0.3
        scene(axis, names[k])
        body(axis, SQUARE, GREY, linestyle="--")
        body(axis, moved_by(unknowns, SQUARE), BLUE, facecolor="none")
        axis.plot(0, 0, ".", color=BLACK, markersize=3)
        axis.set_xlim(-0.9, 0.9)
        axis.set_ylim(-0.85, 0.95)


@figure("covers")
def draw_covers(sheet):
    """A mathematical mesh over a physical region with a crack: the elements, and the physical covers of one node."""
    from shapely import geometry, ops
    axes = panels(sheet, 1, 3, 2.45, sharex=True, sharey=True)[0]
    side, rows = 1.0, math.sqrt(0.75)
    nodes = {(i, j): np.array([side * (i + 0.5 * (j % 2)), rows * j]) for i in range(-1, 6) for j in range(-1, 5)}
    triangles = []
    for i, j in nodes:
        up = (i, i + 1) if j % 2 else (i - 1, i)
        triangles += [corners for corners in ([(i, j), (i + 1, j), (up[1], j + 1)], [(i, j), (up[1], j + 1), (up[0], j + 1)])
                      if all(corner in nodes for corner in corners)]
    rock = geometry.Polygon([(0.55, 0.25), (4.1, 0.15), (4.4, 2.1), (2.6, 3.05), (0.75, 2.75)])
    slit = geometry.LineString([(-1, 1.62), (2.62, 1.42)])
    solid = rock.difference(slit.buffer(1e-6))
    centre = (1, 2)
    about = [t for t in triangles if centre in t]
    patch = ops.unary_union([geometry.Polygon([nodes[n] for n in t]) for t in about])
    for axis, title in zip(axes, ["mesh and physical region", "manifold elements", "two physical covers of a node"]):
        scene(axis, title)
        axis.set_xlim(-0.2, 4.8)
        axis.set_ylim(-0.2, 3.4)
    for t in triangles:
        corners = np.array([nodes[n] for n in t])
        for axis in axes[[0, 2]]:
            body(axis, corners, GREY, facecolor="none", linewidth=0.5)
        common = solid.intersection(geometry.Polygon(corners))
        for piece in getattr(common, "geoms", [common]):
            if piece.area > 1e-6:
                body(axes[1], np.array(piece.exterior.coords), BLUE, linewidth=0.6)
    for axis in axes[[0, 2]]:
        body(axis, np.array(rock.exterior.coords), BLACK, facecolor="none" if axis is axes[2] else to_pale(ORANGE))
    common = solid.intersection(patch)
    for piece, colour in zip(getattr(common, "geoms", [common]), (BLUE, RED)):
        body(axes[2], np.array(piece.exterior.coords), colour, linewidth=1.0)
    for axis in axes:
        axis.plot(*np.array(slit.intersection(rock).coords).T, color=BLACK)
    axes[2].plot(*nodes[centre], "o", color=BLACK, markersize=4)


def map_of(name, r):
    """F of a step that is a rotation by r alone (Shi: the unknown r of the step), by a map of `method.rotation`."""
    J, identity = np.array([[0.0, -1.0], [1.0, 0.0]]), np.eye(2)
    if name == "linear":
        return identity + r * J
    if name == "second_order":
        return (1 - r * r / 2) * identity + r * J
    if name == "trigonometric":
        return math.sqrt(1 - r * r) * identity + r * J
    return math.cos(r) * identity + math.sin(r) * J  # exact, adjusted, exponential


@figure("growth")
def draw_growth(sheet):
    """A square turned by 0.2 a step, and its area by step and map."""
    left, right = panels(sheet, 1, 2, 2.6, gridspec_kw={"width_ratios": [1, 1.3]})[0]
    scene(left, "11 steps of $r = 0.2$, linear map")
    F = np.eye(2)
    for k in range(12):
        shade = 0.15 + 0.85 * k / 11
        body(left, SQUARE @ F.T, BLUE, facecolor="none", alpha=shade, linewidth=0.9)
        F = map_of("linear", 0.2) @ F
    steps, r = np.arange(0, 101), 2 * math.pi / 100
    for name, label, colour in (("linear", "linear: $(1 + r^2)^n$", RED), ("second_order", "second order: $(1 + r^4/4)^n$", ORANGE),
                                ("exact", "all others, and Green strain", BLUE)):
        right.plot(steps, 100 * (np.linalg.det(map_of(name, r)) ** steps - 1), color=colour, label=label)
    right.set_xlabel("step, of 100 in a turn ($r = 3.6$ degrees)")
    right.set_ylabel("growth of the area, %")
    right.set_ylim(-2, 50)
    right.legend()


@figure("small-strain-error")
def draw_small_strain_error(sheet):
    """Strain that a step of small strain neglects over its rotation, and which strain an element takes."""
    axis = panels(sheet, 1, 1, 2.4)[0, 0]
    angle = np.logspace(-6, -0.3, 300)
    for stress, colour in ((0, BLUE), (1e-5, GREEN), (1e-3, ORANGE)):
        label = "no stress" if stress == 0 else rf"$|\sigma|/D_{{11}} = 10^{{{round(math.log10(stress))}}}$"
        axis.loglog(angle, angle * (angle / 2 + stress), color=colour, label=label)
    accuracy = 1e-8
    axis.axhspan(accuracy, 1, color=to_pale(RED), zorder=0)
    axis.axhspan(accuracy / 4, accuracy, color=to_pale(SKY), zorder=0)
    axis.text(0.45, 2e-7, "Green strain", color=RED, ha="right")
    axis.text(0.45, 4.1e-9, "the strain of the step before", fontsize=7.5, ha="right")
    axis.text(0.45, 1e-11, "small strain", ha="right")
    axis.set_xlabel(r"rotation $\alpha$ of the element in the step, rad")
    axis.set_ylabel("neglected strain")
    axis.set_ylim(1e-12, 1e-3)
    axis.legend(loc="upper left")


@figure("push-forward")
def draw_push_forward(sheet):
    """The configurations of an updated Lagrangian step, and what carries stress from one to the other."""
    axis = panels(sheet, 1, 1, 1.9)[0, 0]
    scene(axis)
    shape = rectangle(-0.7, 0.7, -0.35, 0.35)
    angle = 0.55
    F = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]) @ np.array([[1.2, 0.25], [0.0, 0.85]])
    for at, corners, colour, words in ((-2.6, shape, GREY, "beginning of the step\n" r"$\sigma_0,\ \rho_0,\ D_0$"),
                                       (2.6, shape @ F.T, BLUE, "end of the step\n" r"$\sigma_1,\ \rho_1,\ D_1$")):
        body(axis, corners + [at, 0], colour)
        axis.text(at, -1.02, words, ha="center", va="top")
    arrow(axis, (-1.6, 0.15), (1.4, 0.15))
    axis.text(-0.1, 0.27, r"$F = I + \theta$", ha="center")
    axis.text(-0.1, -0.02, r"$S = \sigma_0 + D_0\,E(\theta)$" "\n" r"$\sigma_1 = F S F^T/\det F$", ha="center", va="top")
    axis.set_xlim(-3.9, 3.9)
    axis.set_ylim(-1.75, 0.95)


@figure("nested-iterations")
def draw_nested_iterations(sheet):
    """The two iterations of a step, merged and nested."""
    left, right = panels(sheet, 1, 2, 3.3)[0]
    boxes = ["predict $d$", "linearise strain,\ngeometry and contact", r"solve $K\,\delta d = $ forces", "update contact states",
             "deformation settled?"]
    for axis, title, back, words in ((left, "merged (default)", (4, 1), "no, or states changed"),
                                     (right, "nested (Fig. 9 of Zhang et al. 2019)", (3, 2), "states changed")):
        scene(axis, title)
        axis.set_aspect("auto")
        height = {k: 2.2 - 0.55 * k for k in range(6)}
        for k, text in enumerate(boxes):
            box(axis, (0, height[k]), text, 1.25, 0.36, GREEN if k == 3 else BLUE)
            arrow(axis, (0, height[k] - 0.2), (0, height[k + 1] + 0.2))
        box(axis, (0, height[5]), "accept the step", 1.25, 0.3, GREY)
        loops = [(back, words, 0.95, RED)] + ([((4, 1), "no", 1.25, ORANGE)] if back == (3, 2) else [])
        for (start, end), said, out, colour in loops:
            axis.plot([0.65, out, out], [height[start], height[start], height[end]], color=colour, linewidth=1.1)
            arrow(axis, (out, height[end]), (0.66, height[end]), colour)
            axis.text(out + 0.04, (height[start] + height[end]) / 2, said, rotation=90, va="center", fontsize=7.5, color=colour)
        axis.text(0.05, height[4] - 0.275, "yes", fontsize=7.5, va="center")
        axis.set_xlim(-0.8, 1.6)
        axis.set_ylim(-0.8, 2.5)


