"""Figures of chapter 5: what a contact presses and rubs with."""
import math

import numpy as np

from .sheet import BLACK, BLUE, GREEN, GREY, ORANGE, RED, arrow, figure, panels, to_pale


@figure("coulomb")
def draw_coulomb(sheet):
    """The states of a contact in the plane of its forces, and the shear force over the slip."""
    left, right = panels(sheet, 1, 2, 2.6)[0]
    N, mu, c, T = np.array([-1.0, 3.0]), 0.6, 0.5, 0.45
    left.fill_between([0, 3], [-c - 0, -c - 3 * mu], [c, c + 3 * mu], color=to_pale(BLUE))
    left.fill_between([-T, 0], [-(c - mu * T), -c], [c - mu * T, c], color=to_pale(GREEN))
    for sign in (1, -1):
        left.plot([0, 3], [sign * c, sign * (c + 3 * mu)], color=BLUE)
        left.plot([0, 3], [0, sign * 3 * mu], color=GREY, linestyle="--", linewidth=0.9)
    left.axhline(0, color=BLACK, linewidth=0.6)
    left.axvline(0, color=BLACK, linewidth=0.6)
    left.plot([-T, -T], [-(c - mu * T), c - mu * T], color=GREEN)
    left.text(1.7, 0.25, "locked", color=BLUE)
    left.text(0.75, 1.42, "sliding: $|T| = N\\tan\\varphi + c\\,l$", color=BLUE, fontsize=7.5, rotation=27, rotation_mode="anchor")
    left.text(-0.5, -1.65, "bond,\npulled", color=GREEN, fontsize=7.5, ha="center")
    left.text(-0.95, 0.1, "open", color=GREY)
    left.text(-T, 0.75, "$-\\sigma_t\\,l$", color=GREEN, ha="center", fontsize=7.5)
    left.set_xlabel("normal force $N$, pressing")
    left.set_ylabel("shear force $T$")
    left.set_xlim(N)
    left.set_xticks([])
    left.set_yticks([])
    slip, limit, k = np.linspace(0, 4, 200), 1.0, 1.0
    force = []
    anchor = 0.0
    way = np.concatenate([slip, 4 - slip[:150]])
    for s in way:
        f = k * (s - anchor)
        if abs(f) > limit:
            anchor = s - math.copysign(limit / k, f)
            f = math.copysign(limit, f)
        force.append(f)
    right.plot(way[:200], force[:200], color=BLUE)
    right.plot(way[200:], force[200:], color=RED)
    right.text(1.6, 1.08, "slides, the anchor follows", fontsize=7.5, color=BLUE)
    right.text(3.3, -0.45, "turns back:\nlocked", fontsize=7.5, color=RED)
    right.text(0.75, 0.3, "slope $k$", fontsize=7.5, color=BLUE)
    right.axhline(0, color=BLACK, linewidth=0.6)
    right.set_yticks([-1, 1], [r"$-N\tan\varphi$", r"$N\tan\varphi$"])
    right.set_xticks([])
    right.set_xlabel("slip")
    right.set_ylim(-1.35, 1.35)


@figure("closure")
def draw_closure(sheet):
    """The curve of a joint that stiffens, the lines of the iteration, and its energy."""
    left, right = panels(sheet, 1, 2, 2.4)[0]
    u = np.linspace(0, 0.9, 300)
    N = u / (1 - u)
    left.plot(u, N, color=BLACK, label=r"$N = p\,u/(1 - u/V)$")
    left.plot(u, u, color=GREY, linestyle="--", label="linear spring $p\\,u$")
    place, at = 0.8, 0.0
    colours = (RED, ORANGE, GREEN, BLUE)
    for k in range(4):
        slope = 1 / (1 - at) ** 2
        line = at / (1 - at) + slope * (np.linspace(0, 1.6, 50) - at)
        left.plot(np.linspace(0, 1.6, 50), line, color=colours[k], linewidth=0.9)
        force = at / (1 - at) + slope * (place - at)               # of the line at the closure that is given
        left.plot(place, force, "o", color=colours[k], markersize=3.5)
        at = force / (1 + force)                                   # touches where the curve has the force of the line
    left.axvline(place, color=GREY, linewidth=0.6)
    left.axvline(1, color=GREY, linewidth=0.6, linestyle=":")
    left.text(1.02, 5.5, "$V$", fontsize=8)
    left.set_xlim(0, 1.5)
    left.set_ylim(0, 6)
    left.set_xlabel("closure $u/V$")
    left.set_ylabel("$N/pV$")
    left.legend(loc="upper left")
    right.plot(u, -np.log(1 - u) - u, color=BLACK, label=r"$-\log(1 - u/V) - u/V$")
    right.plot(u, u**2 / 2, color=GREY, linestyle="--", label="linear spring")
    right.set_xlabel("closure $u/V$")
    right.set_ylabel(r"energy over $pV^2$")
    right.legend()


@figure("dilation-and-wear")
def draw_dilation_and_wear(sheet):
    """Dilation over a slip that turns back, friction that wears, and the curve of a rough joint."""
    axes = panels(sheet, 1, 3, 2.3)[0]
    legs = [(0, 1.5), (1.5, -0.6), (-0.6, 2.9)]
    farthest, end, psi = 0.0, 2.2, math.tan(math.radians(10))
    for (start, stop), colour in zip(legs, (BLUE, ORANGE, RED)):
        way = np.linspace(start, stop, 200)
        opening = []
        for s in way:
            farthest = max(farthest, abs(s))
            opening.append(psi * min(farthest, end))
        axes[0].plot(way, opening, color=colour)
        middle = len(way) // 2
        arrow(axes[0], (way[middle - 8], opening[middle - 8]), (way[middle + 8], opening[middle + 8]), colour)
    axes[0].axvline(end, color=GREY, linewidth=0.6, linestyle=":")
    axes[0].set_title(r"opening $\delta$ over the slip $S$")
    axes[0].set_xlabel("$S$")
    axes[0].set_xticks([0, end], ["0", "dilation_slip"])
    axes[0].set_yticks([0])
    slid = np.linspace(0, 3, 100)
    axes[1].plot(slid, np.maximum(math.tan(math.radians(20)), math.tan(math.radians(35))
                                  - (math.tan(math.radians(35)) - math.tan(math.radians(20))) * slid / 2), color=BLUE)
    axes[1].set_title(r"$\tan\varphi$ over the path slid")
    axes[1].set_xticks([0, 2], ["0", "residual_slip"])
    axes[1].set_yticks([math.tan(math.radians(20)), math.tan(math.radians(35))], ["residual", "peak"])
    axes[1].set_ylim(0, 0.8)
    stress = np.logspace(-3, 0, 200)
    angle = np.minimum(np.radians(70), np.radians(30) + np.radians(10) * np.maximum(0, -np.log10(stress)))
    axes[2].plot(stress, stress * np.tan(angle), color=BLUE, label=r"$\tau(\sigma_n)$, JRC 10")
    at = 0.15
    slope = math.tan(math.radians(30) - math.radians(10) * math.log10(at))
    axes[2].plot([0, 0.5], [0, 0.5 * slope], color=RED, linewidth=0.9, label="slope taken in a step")
    axes[2].plot(at, at * slope, "o", color=RED, markersize=4)
    axes[2].plot(stress, stress * math.tan(math.radians(30)), color=GREY, linestyle="--", label=r"$\sigma_n\tan\varphi$")
    axes[2].set_xlim(0, 0.6)
    axes[2].set_ylim(0, 0.5)
    axes[2].set_xticks([])
    axes[2].set_yticks([])
    axes[2].set_xlabel(r"$\sigma_n/\mathrm{JCS}$")
    axes[2].set_title("strength of a rough joint")
    axes[2].legend(loc="upper left", fontsize=6.5)


@figure("conserving")
def draw_conserving(sheet):
    """The force of a contact by the end of the step and by the mean over the step, and the energy that each gains or loses."""
    left, right = panels(sheet, 1, 2, 2.3)[0]
    g = np.linspace(-1, 1, 200)
    force = np.maximum(0, -g)
    left.plot(g, force, color=BLACK)
    g0, g1 = 0.35, -0.75
    left.fill_between(np.linspace(g1, g0, 60), np.maximum(0, -np.linspace(g1, g0, 60)), color=to_pale(BLUE, 0.4))
    mean = 0.5 * g1**2 / (g0 - g1)
    left.plot([g1, g0], [mean, mean], color=BLUE, label="conserving: mean over the step")
    left.plot([g1, g0], [-g1, -g1], color=RED, label="Coulomb: force of the end")
    left.plot([g0, g1], [0, -g1], "o", color=BLACK, markersize=4)
    left.set_xticks([g1, 0, g0], ["$g_1$", "0", "$g_0$"])
    left.set_yticks([])
    left.set_xlabel("gap")
    left.set_ylabel("normal force")
    left.legend(loc="upper right")
    left.set_ylim(0, 1.25)
    start = np.linspace(-1, 1, 200)
    for end, style in ((-0.75, "-"), (0.3, "--")):
        work = -max(0, -end) * (end - start)               # that the force of the end takes from the motion
        change = 0.5 * min(end, 0) ** 2 - 0.5 * np.minimum(start, 0) ** 2
        right.plot(start, work - change, style, color=RED, label=f"end at $g_1 = {end}$")
    right.axhline(0, color=BLUE)
    right.text(0.35, 0.05, "conserving: none", color=BLUE, fontsize=7.5)
    right.set_xlabel("$g_0$")
    right.set_ylabel("energy lost in the step")
    right.set_ylim(-0.2, 1.6)
    right.legend()
