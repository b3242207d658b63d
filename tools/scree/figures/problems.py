"""Figures of chapter 6: the friction problem of one spring and two unknowns, and the methods in their order."""
import math

import numpy as np

from .sheet import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, RED, SKY, arrow, box, figure, panels, scene, to_pale

# One spring with n = (1, 0), t = (0, 1): the coupling of A and the friction make the determinant negative where it slides forth.
A, LOAD = np.array([[1.0, -0.8], [-0.8, 1.0]]), np.array([-4.0, 3.0])
N0, STIFFNESS, T0, SHEAR_STIFFNESS, FRICTION = 1.0, 5.0, 0.0, 4.0, 2.5
OPEN, FORTH, BACK, LOCKED = "open", "sliding forth", "sliding back", "locked"
COLOUR = {OPEN: GREY, FORTH: RED, BACK: GREEN, LOCKED: BLUE}


def state_at(x):
    """State of the spring."""
    pressing, shear = N0 - STIFFNESS * x[0], T0 - SHEAR_STIFFNESS * x[1]
    if pressing < 0:
        return OPEN
    if abs(shear) < FRICTION * pressing:
        return LOCKED
    return BACK if shear > 0 else FORTH


def piece(state):
    """F = constant - K x in a piece: (K, constant)."""
    K, constant = A.copy(), LOAD.copy()
    if state == OPEN:
        return K, constant
    K[0, 0] += STIFFNESS
    constant[0] += N0
    if state == LOCKED:
        K[1, 1] += SHEAR_STIFFNESS
        constant[1] += T0
        return K, constant
    sign = 1 if state == BACK else -1
    K[1, 0] += sign * FRICTION * STIFFNESS
    constant[1] += sign * FRICTION * N0
    return K, constant


def left_over(x):
    """Forces out of balance."""
    K, constant = piece(state_at(x))
    return constant - K @ x


def path_from(start, most=40):
    """Corners of the path F(x) = (1 - t) F(start) and their t, until t is 1 or the pieces end."""
    x, t, sense, F0 = np.array(start, float), 0.0, 1.0, left_over(np.array(start, float))
    points, times, states = [x], [t], [state_at(x)]
    for _ in range(most):
        state = states[-1]
        K, _ = piece(state)
        direction = sense * np.linalg.solve(K, F0)
        rates = np.array([-STIFFNESS * direction[0], -SHEAR_STIFFNESS * direction[1]])
        forces = np.array([N0 - STIFFNESS * x[0], T0 - SHEAR_STIFFNESS * x[1]])
        faces = [np.array([1, 0]), np.array([FRICTION, -1]), np.array([FRICTION, 1])]
        ways = [-(face @ forces) / (face @ rates) for face in faces if abs(face @ rates) > 1e-12]
        way = min([w for w in ways if w > 1e-9], default=math.inf)
        if sense > 0 and t + way >= 1:
            points.append(x + (1 - t) * direction)
            times.append(1.0)
            states.append(state)
            break
        if math.isinf(way):
            break
        x, t = x + way * direction, t + sense * way
        after = state_at(x + 1e-7 * direction / np.linalg.norm(direction))
        if after == state:                                   # a face that this piece does not have
            after = state_at(x + 1e-7 * direction)
        if np.sign(np.linalg.det(piece(after)[0])) != np.sign(np.linalg.det(K)):
            sense = -sense
        points.append(x)
        times.append(t)
        states.append(after)
    return np.array(points), np.array(times), states


@figure("friction-problem")
def draw_friction_problem(sheet):
    """The pieces of a friction problem, its forces far away, and the path to its solution with its turn."""
    left, right = panels(sheet, 1, 2, 2.9, gridspec_kw={"width_ratios": [1.1, 1]})[0]
    span = np.linspace(-6, 6, 500)
    X, Y = np.meshgrid(span, span)
    pressing, shear = N0 - STIFFNESS * X, T0 - SHEAR_STIFFNESS * Y
    kinds = np.where(pressing < 0, 0, np.where(np.abs(shear) < FRICTION * pressing, 3, np.where(shear > 0, 2, 1)))
    pale = np.array([to_pale(COLOUR[s]) for s in (OPEN, FORTH, BACK, LOCKED)])
    left.imshow(pale[kinds], extent=(-6, 6, -6, 6), origin="lower", interpolation="nearest")
    for angle in np.linspace(0, 2 * math.pi, 24, endpoint=False):
        at = 5.3 * np.array([math.cos(angle), math.sin(angle)])
        force = left_over(at)
        left.annotate("", at + 0.8 * force / np.linalg.norm(force), at, arrowprops={"arrowstyle": "->", "color": GREY})
    points, times, states = path_from((2.4, 3.0))
    left.plot(points[:, 0], points[:, 1], color=BLACK)
    left.plot(*points[0], "s", color=BLACK, markersize=4)
    left.plot(*points[-1], "o", color=BLACK, markersize=5)
    left.text(2.0, -3.4, "open", color=GREY, fontsize=7.5)
    left.text(-4.9, 0.3, "locked", color=BLUE, fontsize=7.5)
    left.text(-1.4, 3.0, "sliding forth\n(det < 0)", color=RED, fontsize=7.5, ha="center")
    left.text(-1.3, -4.3, "sliding back", color=GREEN, fontsize=7.5, ha="center")
    left.set_xlabel("$x_n$")
    left.set_ylabel("$x_t$")
    left.set_title("pieces, forces on a circle, path")
    way = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    right.axhline(1, color=GREY, linewidth=0.6, linestyle=":")
    for k in range(len(way) - 1):
        right.plot(way[k:k + 2], times[k:k + 2], color=COLOUR[states[k]], linewidth=2)
    right.plot(way, times, ".", color=BLACK)
    right.set_xlabel("length of the path in $x$")
    right.set_ylabel("$t$")
    right.set_title("$F(x) = (1 - t)\\,F(x_0)$ along the path")


@figure("methods")
def draw_methods(sheet):
    """The methods that settle contacts, in the order in which they are tried."""
    axis = panels(sheet, 1, 1, 3.1)[0, 0]
    scene(axis)
    axis.set_aspect("auto")
    rows = [("open-close iteration\n(semi-smooth Newton)", BLUE, "no state changes: accept"),
            ("the part that goes on changing, all else held", SKY, "goes on with the iteration"),
            ("path from the best iterate, at most 300 pieces", ORANGE, "choose lines and anchors anew"),
            ("interior, then path, up to four starts", GREEN, "choose lines and anchors anew"),
            ("take the springs at folds apart, bring them together", PINK, "choose lines and anchors anew"),
            ("all springs from apart", RED, "choose lines and anchors anew"),
            ("cut the step", GREY, "")]
    for k, (text, colour, then) in enumerate(rows):
        y = -0.52 * k
        box(axis, (0, y), text, 2.3, 0.36, colour)
        if k < len(rows) - 1:
            arrow(axis, (0, y - 0.2), (0, y - 0.34))
            axis.text(0.06, y - 0.265, "runs in circles" if k == 0 else "not found", fontsize=7, va="center")
            arrow(axis, (1.17, y), (1.75, y), colour)
            axis.text(1.8, y, then, fontsize=7.5, va="center")
    axis.set_xlim(-1.4, 3.6)
    axis.set_ylim(-3.4, 0.3)


@figure("interior")
def draw_interior(sheet):
    """The pairs of a spring as their products go to zero: the law that the interior smooths."""
    left, right = panels(sheet, 1, 2, 2.3)[0]
    excess = np.linspace(-2, 2, 300)                        # what would press if it were closed
    for product, colour in ((0.5, ORANGE), (0.05, GREEN), (0.0, BLACK)):
        y = (excess + np.sqrt(excess**2 + 4 * product)) / 2
        left.plot(excess, y, color=colour, label=f"$y\\,w = {product:g}$")
    left.set_xlabel("$N_0 - p\\,n'\\!\\cdot x$")
    left.set_ylabel("pressing force $y$")
    left.legend()
    limit = 1.0
    shear = np.linspace(-0.999, 0.999, 400) * limit
    for product, colour in ((0.5, ORANGE), (0.05, GREEN)):
        locked = shear + product / (limit - shear) - product / (limit + shear)   # s - r beyond T
        right.plot(locked, shear, color=colour)
    right.plot([-3, -1, 1, 3], [-1, -1, 1, 1], color=BLACK)
    right.set_xlim(-3, 3)
    right.set_xlabel("$T_0 - k\\,t'\\!\\cdot x$")
    right.set_yticks([-1, 0, 1], [r"$-\mu y$", "0", r"$\mu y$"])
    right.set_ylabel("shear force $T$")
