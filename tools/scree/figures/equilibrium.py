"""Figures of chapters 8 and 9: static steps, islands that sleep, and the estimate of the error."""
import math

import numpy as np

from .sheet import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, RED, arrow, body, figure, panels, rectangle, scene, to_pale


@figure("static-steps")
def draw_static_steps(sheet):
    """The force that static steps leave on a spring, and the force over the displacement of a body that settles or slides."""
    left, right = panels(sheet, 1, 2, 2.4)[0]
    steps = np.arange(0, 41)
    for ratio, colour in ((10, RED), (1, ORANGE), (0.1, GREEN), (0.001, BLUE)):
        left.semilogy(steps, (ratio / (1 + ratio)) ** steps, color=colour, label=f"$c/k = {ratio:g}$")
    left.set_ylim(1e-12, 2)
    left.set_xlabel("static steps of one size")
    left.set_ylabel("ratio of the force out of balance")
    left.legend(loc="lower left", bbox_to_anchor=(0.28, 0.0))
    size, share, moved, grow = 1.0, 1.0, 0.0, 3.0
    ways, shares = [0.0], [1.0]
    for _ in range(8):
        c = 30 / size**2
        step = share / (1 + c)
        moved, share, size = moved + step, share * c / (c + 1), size * grow
        ways.append(moved)
        shares.append(share)
    right.plot(ways, shares, "o-", color=BLUE, markersize=3, label="a spring holds it")
    slide = np.cumsum([0] + [0.03 * 3 ** (2 * k) * 0.1 for k in range(4)])
    right.plot(slide, [0.55] * len(slide), "s-", color=RED, markersize=3, label="nothing holds it")
    right.plot([ways[3], 1.0], [shares[3], 0], color=GREY, linestyle="--", linewidth=0.9)
    right.text(0.60, 0.44, r"goes on by $w\,r_1/(r_0 - r_1)$", fontsize=7.5)
    right.set_xlim(-0.03, 1.35)
    right.set_ylim(-0.03, 1.05)
    right.set_xlabel("displacement of the body")
    right.set_ylabel("force out of balance $r$")
    right.legend(loc="upper right")


@figure("islands")
def draw_islands(sheet):
    """Islands of bodies: two that sleep, one that wakes, one that stays awake."""
    axis = panels(sheet, 1, 1, 2.0)[0, 0]
    scene(axis)
    body(axis, rectangle(-0.4, 11.4, -0.5, 0), GREY)
    axis.text(5.5, -0.27, "fixed body: it cuts islands", ha="center", va="center", fontsize=7.5)
    piles = [(0.2, BLUE, "sleeps"), (3.1, BLUE, "sleeps"), (6.0, ORANGE, "wakes: a body\nreaches it")]
    for x, colour, words in piles:
        bricks = [(x, x + 0.95, 0, 0.5), (x + 1.0, x + 1.95, 0, 0.5), (x + 0.5, x + 1.45, 0.5, 1.0)]
        for corners in bricks:
            body(axis, rectangle(*corners), colour, alpha=0.9)
        axis.text(x + 0.97, 1.12, words, ha="center", va="bottom", fontsize=7.5, color=colour)
    body(axis, rectangle(9.3, 10.1, 0.0, 0.8), RED)
    axis.text(9.7, 0.9, "slides: awake", ha="center", va="bottom", fontsize=7.5, color=RED)
    arrow(axis, (9.2, 0.4), (8.2, 0.4), RED)
    axis.set_xlim(-0.5, 11.5)
    axis.set_ylim(-0.55, 1.9)


@figure("rest-bounds")
def draw_rest_bounds(sheet):
    """The two bounds below which a body counts as near equilibrium."""
    axis = panels(sheet, 1, 1, 2.1)[0, 0]
    for s, colour in ((1e-3, ORANGE), (1e-8, BLUE)):
        axis.fill_between([1e-12, s], 1e-12, s, color=to_pale(colour, 0.3))
        axis.text(2e-12, s / 2, f"$s = 10^{{{round(math.log10(s))}}}$", va="top", color=colour)
    steps = np.arange(0, 17)
    axis.loglog(10.0 ** (-0.7 * steps), 0.6 * 10.0 ** (-0.65 * steps), "o-", color=BLACK, markersize=3, linewidth=0.8)
    axis.text(2e-3, 3e-7, "a body that comes to rest,\nlooked at every eighth step", fontsize=7.5, va="top")
    axis.set_xlim(1e-12, 3)
    axis.set_ylim(1e-12, 3)
    axis.set_xlabel(r"speed over $\sqrt{g\,l}$")
    axis.set_ylabel("force out of balance\nover the weight")


def pendulum(dt, end, arm=1.0, gravity=10.0, start=1.2):
    """Angles of a pendulum by steps of Newmark (1, 1/2), and the estimate of their error, all as displacement over the arm.

    It is the estimate of doc/theory/error-estimate.md for a body that is held: the error of each step in place and motion, carried
    on by e' = u, u' = k e with k = da/ds.
    """
    angle, speed, before = start, 0.0, None
    e = u = 0.0
    angles, estimates = [angle], [0.0]
    for _ in range(round(end / dt)):
        a = -gravity / arm * math.sin(angle)
        for _ in range(50):                                    # d = dt v0 + a1 dt^2/2, v1 = v0 + a1 dt, a1 of the end
            a = -gravity / arm * math.sin(angle + dt * speed + a * dt**2 / 2)
        moved, new = dt * speed + a * dt**2 / 2, speed + a * dt
        k = -gravity / arm * math.cos(angle + moved / 2)
        if before is not None:
            jerk = (a - before) / dt
            place = moved - (dt * (speed + new) / 2 - dt**3 * jerk / 12)
            u += k * dt * e + 0.5 * dt**2 * jerk
            e += dt * u + place
        angle, speed, before = angle + moved, new, a
        angles.append(angle)
        estimates.append(e)
    return np.array(angles), np.array(estimates)


@figure("error-along-a-run")
def draw_error_along_a_run(sheet):
    """Error of a pendulum along a run, and its estimate, for two sizes of steps."""
    left, right = panels(sheet, 1, 2, 2.5)[0]
    end = 3.0
    exact, _ = pendulum(1e-4, end)
    for dt, colour in ((0.02, BLUE), (0.005, GREEN)):
        angles, estimate = pendulum(dt, end)
        time = dt * np.arange(len(angles))
        reference = np.interp(time, 1e-4 * np.arange(len(exact)), exact)
        left.plot(time, angles - reference, color=colour, label=rf"$\Delta t = {dt:g}$ s: error")
        left.plot(time, estimate, "--", color=colour, label="estimate")
    left.set_xlabel("time, s")
    left.set_ylabel("error over the arm")
    left.legend(loc="upper left", ncol=2)
    left.set_ylim(-0.24, 0.3)
    time = np.linspace(0, 2.5, 200)
    for k, colour, words in ((-9.0, BLUE, "$k < 0$: held, bounded"), (0.0, GREY, "$k = 0$: free"), (1.5, RED, "$k > 0$: tips over")):
        if k < 0:
            became = np.minimum(time, 1 / math.sqrt(-k))
        else:
            became = time if k == 0 else np.sinh(np.minimum(3.0, math.sqrt(k) * time)) / math.sqrt(k)
        right.plot(time, became, color=colour, label=words)
    right.set_xlabel("time that is left")
    right.set_ylabel("what a unit of $u$ comes to at most")
    right.legend()


@figure("step-control")
def draw_step_control(sheet):
    """The factor of the next step over the excess of a step, for three excesses before."""
    axis = panels(sheet, 1, 1, 2.1)[0, 0]
    excess = np.logspace(-1, 1, 300)
    for before, colour in ((0.5, GREEN), (1.0, BLUE), (2.0, PINK)):
        earlier = np.maximum(before, excess / 1.25)
        axis.loglog(excess, np.clip(excess**-0.7 * earlier**0.4, 0.2, 1.25), color=colour, label=f"$h' = {before:g}$")
    axis.axvline(1, color=BLACK, linewidth=0.5, linestyle=":")
    axis.set_yticks([0.2, 0.5, 1, 1.25], ["0.2", "0.5", "1", "1.25"])
    axis.minorticks_off()
    axis.set_xlabel("$h$: size of the step over the size that adds what it may")
    axis.set_ylabel("factor of the next step")
    axis.legend()
