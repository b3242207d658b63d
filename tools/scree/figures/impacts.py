"""Figures of chapter 7: bounces by springs and by restitution, the two parts of a step, impacts in a row."""
import math

import numpy as np

from .sheet import BLACK, BLUE, GREEN, GREY, LINES, ORANGE, RED, arrow, figure, panels

GRAVITY, DROP = 10.0, 0.2
SWING = 0.5e-3  # period of the contact springs, s


def bounce(dt, phase, steps, restitution=None):
    """Height of a block that falls, at the ends of steps of Newmark (1, 9/16) with a spring, or with the rule of restitution."""
    stiffness = (2 * math.pi / SWING) ** 2                 # over the mass
    v, a = 0.0, -GRAVITY
    height = DROP + phase * dt * math.sqrt(2 * GRAVITY * DROP)
    heights = [height]
    for _ in range(steps):
        free = height + v * dt + (0.5 - 9 / 16) * a * dt**2  # without the new acceleration
        new = -GRAVITY
        if free + 9 / 16 * new * dt**2 < 0:
            if restitution is None:
                new = (-GRAVITY - stiffness * free) / (1 + 9 / 16 * stiffness * dt**2)
            else:                                            # an instant at the end of the step, where the block touches
                arrival = v - GRAVITY * dt
                heights.append(0.0)
                height, v, a = 0.0, -restitution * arrival if arrival < -2 * GRAVITY * dt else 0.0, -GRAVITY
                continue
        height, v, a = free + 9 / 16 * new * dt**2, v + new * dt, new
        heights.append(height)
    return np.array(heights)


def kept(dt, phase):
    """Fraction of the energy of the fall that a block keeps, by its largest height after the first contact."""
    height = bounce(dt, phase, int(0.6 / dt))
    first = int(np.argmax(height <= 0))
    return max(height[first:].max(), 0) / DROP


@figure("bounce")
def draw_bounce(sheet):
    """Bounces by springs in four phases of the step and by restitution, and the energy kept over the phase."""
    left, right = panels(sheet, 1, 2, 2.6)[0]
    dt, steps = 2e-3, 500
    time = dt * np.arange(steps + 1)
    for k, phase in enumerate((0.0, 0.25, 0.5, 0.75)):
        left.plot(time, bounce(dt, phase, steps), color=GREY, linewidth=0.8, label="springs, four phases" if k == 0 else None)
    left.plot(time, bounce(dt, 0.0, steps, 0.5), color=BLUE, label="restitution 0.5")
    left.set_xlabel("time, s")
    left.set_ylabel("height, m")
    left.legend()
    phases = np.linspace(0, 1, 161)
    for size, colour in ((2e-3, RED), (0.5e-3, ORANGE), (0.05e-3, GREEN)):
        right.plot(phases, [kept(size, phase) for phase in phases], color=colour, label=f"springs, {1e3 * size:g} ms")
    right.axhline(0.25, color=BLUE, label="restitution 0.5")
    right.set_xlabel("phase of the step in which the block arrives")
    right.set_ylabel("fraction of the energy that is kept")
    right.set_ylim(0, 1.05)
    right.legend(loc="upper center", ncol=2)


@figure("impact-in-a-step")
def draw_impact_in_a_step(sheet):
    """The gap in a step with an impact: by an exact rigid body, and by the two parts that the step is made of."""
    axis = panels(sheet, 1, 1, 2.3)[0, 0]
    at = 0.6
    axis.plot([-0.25, at], [1.25 / 0.85 * 0.6 + 0.0, 0], color=GREY, linewidth=2.5, label="rigid body, met at $u$, held to the end")
    axis.plot([at, 1], [0, 0], color=GREY, linewidth=2.5)
    axis.plot([at, 1.35], [0, 0.35], color=GREY, linestyle=":", linewidth=1.5, label="rigid body that leaves at once")
    start = 1.25 / 0.85 * 0.6 * 0.6 / 0.85
    axis.plot([0, 1], [start, 0], color=BLUE, label="step made with the push: ends where the body touches")
    axis.plot([1, 1.35], [0, 0.35], color=RED, label="velocity after compression and restitution")
    axis.axhline(0, color=BLACK, linewidth=0.7)
    for t, label in ((0, "$t_0$"), (at, r"$t_0 + u\,\Delta t$"), (1, "$t_1$")):
        axis.axvline(t, color=BLACK, linewidth=0.5, linestyle=":")
        axis.text(t, -0.16, label, ha="center", fontsize=8)
    axis.set_xlim(-0.3, 1.45)
    axis.set_ylim(-0.06, 1.2)
    axis.set_xticks([])
    axis.set_yticks([])
    axis.set_ylabel("gap")
    axis.spines["bottom"].set_visible(False)
    axis.legend(loc="upper right")


def row_of_masses(restitution, count=6, gap=1e-3, size=0.02, speed=1.0, end=0.02):
    """Histories of the left ends of equal bodies in a row, the first of which is thrown at the others; event by event."""
    position = np.array([(size + gap) * k for k in range(count)])
    velocity = np.zeros(count)
    velocity[0] = speed
    times, places, now = [0.0], [position.copy()], 0.0
    while now < end:
        apart, closing = np.diff(position) - size, -np.diff(velocity)
        waits = np.where(closing > 1e-12, apart / np.maximum(closing, 1e-12), np.inf)
        wait = min(waits.min(), end - now)
        position = position + wait * velocity
        now += wait
        times.append(now)
        places.append(position.copy())
        for k in np.flatnonzero(waits <= wait + 1e-12):
            mean, change = velocity[k:k + 2].mean(), velocity[k + 1] - velocity[k]
            velocity[k:k + 2] = mean - restitution * change / 2 * np.array([-1, 1])
    return np.array(times), np.array(places)


@figure("impacts-in-turn")
def draw_impacts_in_turn(sheet):
    """A row of six squares with gaps of 1 mm: where they are over time, with restitution 1 and 0."""
    axes = panels(sheet, 1, 2, 2.5, sharex=True, sharey=True)[0]
    for axis, restitution in zip(axes, (1.0, 0.0)):
        times, places = row_of_masses(restitution)
        for k in range(6):
            axis.plot(1e3 * times, 1e3 * (places[:, k] - places[0, k]) + 4 * k, color=LINES[k % len(LINES)])
        for end in (2.5, 5, 7.5, 10, 12.5, 15):
            axis.axvline(end, color=GREY, linewidth=0.5, linestyle=":")
        axis.set_title(f"restitution {restitution:g}")
        axis.set_xlabel("time, ms (dotted: ends of steps)")
        axis.set_xlim(0, 15)
        axis.set_ylim(-1, 34)
    axes[0].set_ylabel("displacement, mm, and 4 mm a body")
    arrow(axes[0], (7.9, 27.5), (6.0, 22), BLACK)
    axes[0].text(8.0, 27.5, "all of the energy", fontsize=7.5, va="center")
