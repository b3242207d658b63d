"""Figures of chapter 3: roots, spins and the time at which a step feels its loads."""
import math

import numpy as np

from .sheet import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, RED, SKY, figure, panels


def newmark_matrix(beta, gamma, w):
    """What a step of Newmark does to (d, v dt, a dt^2) of an oscillator with w = omega dt; balance at the end of the step."""
    after = np.array([[1.0, 1.0, 0.5 - gamma], [0.0, 1.0, 1 - beta]])   # of the state before, without the new acceleration
    row = -w * w * after[0] / (1 + gamma * w * w)                       # the new acceleration
    return np.vstack([after[0] + gamma * row, after[1] + beta * row, row])


def generalised_alpha_matrix(rho, w):
    """The same of generalized-alpha, whose balance is between the beginning and the end of the step."""
    alpha_m, alpha_f = (2 * rho - 1) / (rho + 1), rho / (rho + 1)
    beta = 0.5 - alpha_m + alpha_f
    gamma = (beta + 0.5) ** 2 / 4
    after = np.array([[1.0, 1.0, 0.5 - gamma], [0.0, 1.0, 1 - beta]])
    old = np.array([-w * w * alpha_f, 0.0, -alpha_m])
    row = (old - (1 - alpha_f) * w * w * after[0]) / (1 - alpha_m + (1 - alpha_f) * gamma * w * w)
    return np.vstack([after[0] + gamma * row, after[1] + beta * row, row])


def bathe_matrix(w):
    """A pair of steps of Bathe's composite in one, each of the size dt: the trapezoidal rule, then the step that looks back."""
    first = newmark_matrix(0.5, 0.25, w)
    first = np.vstack([first[:2], first[1] - np.array([0.0, 1.0, 0.0])])   # hands on (v1 - v0)/h
    return newmark_matrix(2 / 3, 4 / 9, w) @ first


def radius(matrix):
    """Largest magnitude of a root."""
    return np.abs(np.linalg.eigvals(matrix)).max()


@figure("spectral-radius")
def draw_spectral_radius(sheet):
    """Spectral radius of the integrators over omega dt."""
    axis = panels(sheet, 1, 1, 2.9)[0, 0]
    w = np.logspace(-2, 3, 400)
    curves = [(r"Newmark $\beta=1,\ \gamma=\frac{1}{2}$ (Shi)", RED, "-", lambda x: radius(newmark_matrix(1, 0.5, x))),
              (r"Newmark $\beta=1,\ \gamma=\frac{9}{16}$ (default)", BLUE, "-", lambda x: radius(newmark_matrix(1, 9 / 16, x))),
              (r"Newmark $\beta=\frac{1}{2},\ \gamma=\frac{1}{2}$", ORANGE, "--", lambda x: radius(newmark_matrix(0.5, 0.5, x))),
              (r"energy-decaying $\chi=\frac{1}{2}$", SKY, ":", lambda x: radius(newmark_matrix(1, 9 / 16, x))),
              (r"energy-momentum $\chi=0$ (trapezoidal)", GREY, "-", lambda x: radius(newmark_matrix(0.5, 0.25, x))),
              (r"generalized-$\alpha$, $\rho=\frac{1}{2}$", GREEN, "-", lambda x: radius(generalised_alpha_matrix(0.5, x))),
              ("Bathe, root of a pair per step", PINK, "-", lambda x: radius(bathe_matrix(x)) ** 0.5)]
    for label, colour, style, of in curves:
        axis.semilogx(w, [of(x) for x in w], style, color=colour, label=label)
    axis.axhline(1 / 3, color=BLACK, linewidth=0.5, linestyle=":")
    axis.text(750, 0.35, "1/3", fontsize=7.5)
    axis.set_xlabel(r"$\omega\,\Delta t$")
    axis.set_ylabel("largest magnitude of a root")
    axis.set_ylim(0, 1.12)
    axis.legend(loc="lower left", bbox_to_anchor=(0.0, 0.02))


@figure("spin")
def draw_spin(sheet):
    """Angle lost by a body that spins, by integrator; closed forms of the turning triangle."""
    left, right = panels(sheet, 1, 2, 2.5)[0]
    turns = np.linspace(0, 20, 300)
    step = math.radians(3.6)
    for label, excess, colour in ((r"$\beta=1$", 1.0, RED), (r"$\beta=0.8$", 0.6, ORANGE)):
        x = excess * step * 2 * math.pi * turns                       # (2 beta - 1) omega0^2 dt t
        angle = np.where(x > 0, 2 * (np.sqrt(1 + x) - 1) / np.maximum(x, 1e-30), 1.0)
        left.plot(turns, 100 * (angle - 1), color=colour, label="Newmark " + label)
    left.plot(turns, 100 * (2 * math.atan(step / 2) / step - 1) + 0 * turns, color=BLUE, label="energy-momentum, energy-decaying")
    left.set_xlabel(r"$\omega_0 t/2\pi$, turns")
    left.set_ylabel("error of the angle, %")
    left.set_ylim(-62, 3)
    left.legend(loc="lower left", fontsize=6.5)
    angle = np.radians(np.linspace(0.1, 90, 200))
    right.semilogy(np.degrees(angle), 100 * (1 - 2 * np.arctan(angle / 2) / angle), color=BLUE, label="lag of the angle")
    right.semilogy(np.degrees(angle), 100 * angle**4 / 32, color=RED, label=r"angular momentum lost a step if $Q = I$")
    right.set_xlabel(r"$\omega\,\Delta t$, degrees")
    right.set_ylabel("%")
    right.set_ylim(1e-5, 100)
    right.legend(loc="lower right")


@figure("load-times")
def draw_load_times(sheet):
    """The window over which a step takes the mean of its loads."""
    axis = panels(sheet, 1, 1, 1.75)[0, 0]
    rows = [(r"$\beta = 1$; energy-momentum", 0.0, 1.0), (r"Newmark, $\beta = 0.8$", 0.2, 1.2), (r"Newmark, $\beta = \frac{1}{2}$", 0.5, 1.5),
            ("central differences", -0.5, 0.5), ("static steps and Shi's", 1.0, 1.0)]
    for k, (label, start, end) in enumerate(rows):
        y = -0.5 * k
        axis.plot([start, end], [y, y], color=BLUE, linewidth=7, solid_capstyle="butt", alpha=0.45)
        axis.plot((start + end) / 2, y, "o", color=BLUE, markersize=5)
        axis.text(-0.62, y, label, ha="right", va="center")
    for t, label in ((0, "$t_0$"), (1, "$t_1$")):
        axis.axvline(t, color=BLACK, linewidth=0.8)
        axis.text(t - 0.03, 0.3, label, ha="right")
    axis.set_xlim(-1.7, 1.7)
    axis.set_ylim(-2.3, 0.6)
    axis.axis("off")
