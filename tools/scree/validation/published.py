"""Cases of the literature: a rocking block under one sine pulse, and arches that are pushed aside."""
import math

import numpy as np

from .. import block_files
from .cases import DECKS, G, Row, case, verdict
from .references import Rocking

FINE = 0.05        # of g b/h, between the amplitudes that are tried until a block overturns
HELD = 0.8         # of the thickness of an arch, by which its abutments reach beyond the middle line on either side
CHORDS = np.sinc(1 / 400)**2  # amplitude of the sine of 400 chords that the decks of a pulse have
WITHOUT_SLIP = 50  # coefficient of friction of arches that may only turn
ARCHES = {"arch7": (7, 0.15, 157.5), "arch15": (15, 0.15, 157.5), "arch9": (9, 0.2, 120.0)}  # voussoirs, t/R, degrees


def pulse_tilt(block, amplitude, omega):
    """Largest tilt over atan(b/h) of a rigid block that rocks on ground with the acceleration amplitude sin(omega t) g for one cycle; infinite where
    it overturns. An impact leaves 1 - 1.5 sin^2 alpha of the speed (Housner 1963, Makris and Zhang 2001). After the cycle it rocks freely, by energy."""
    from scipy.integrate import solve_ivp  # here, as scipy takes half a second to begin
    p2, left, lifts, end = 0.75 * block.g / block.R, 1 - 1.5 * math.sin(block.alpha)**2, math.tan(block.alpha), 2 * math.pi / omega
    if amplitude <= lifts:
        return 0.0
    t, x, side, largest = math.asin(lifts / amplitude) / omega, (-1e-12, 0.0), -1.0, 0.0
    while t < end:
        def rates(t, x, side=side):
            lean = side * block.alpha - x[0]
            return x[1], -p2 * (math.sin(lean) + amplitude * math.sin(omega * t) * math.cos(lean))

        def upright(t, x):
            return x[0]

        upright.terminal, upright.direction = True, -side
        run = solve_ivp(rates, (t, end), x, events=upright, rtol=1e-10, atol=1e-13, max_step=end / 20)
        t, largest = run.t[-1], max(largest, np.abs(run.y[0]).max())
        if t < end:
            side = -side
            x = side * 1e-12, left * run.y[1, -1]
    tilt, speed = abs(run.y[0, -1]), side * run.y[1, -1]
    energy = speed**2 / 2 + p2 * (math.cos(block.alpha - tilt) - math.cos(block.alpha))
    if tilt > block.alpha and speed > 0 or (energy if speed > 0 else energy * left**2) > p2 * (1 - math.cos(block.alpha)):
        return math.inf
    free = energy if speed > 0 else energy * left**2
    return max(largest, block.alpha - math.acos(free / p2 + math.cos(block.alpha))) / block.alpha


def least_pulse(block, omega):
    """Amplitude over g, from which on a block overturns: the first one as it grows."""
    step = FINE * math.tan(block.alpha)
    high = next(a for a in np.arange(math.tan(block.alpha) + step, 10.0, step) if math.isinf(pulse_tilt(block, a, omega)))
    low = high - step
    while high - low > 1e-5 * high:
        middle = (low + high) / 2
        low, high = (low, middle) if math.isinf(pulse_tilt(block, middle, omega)) else (middle, high)
    return high


def pushed_arch(voussoirs, thickness, degrees):
    """Largest acceleration along x, over g, that an arch of rigid voussoirs bears, none of whose joints pulls or slides: the linear programme of
    forces at both ends of each joint (Livesley 1978). The radius of its middle line is 1."""
    from scipy.optimize import linprog  # here, as scipy takes half a second to begin
    corners, ways = voussoirs_of(voussoirs, thickness, degrees)
    n = 4 * (voussoirs + 1) + 1  # at each joint thrust and shear inside, then outside; the acceleration
    balance, weight = [], []
    for k, polygon in enumerate(corners):
        after = np.roll(polygon, -1, axis=0)
        twice = polygon[:, 0] * after[:, 1] - polygon[:, 1] * after[:, 0]
        area, middle = twice.sum() / 2, ((polygon + after) * twice[:, None]).sum(0) / (3 * twice.sum())
        rows = np.zeros((3, n))
        for j, sign in ((k, 1), (k + 1, -1)):
            along, across = ways[j], np.array([-ways[j][1], ways[j][0]])
            for end, radius in enumerate((1 - thickness / 2, 1 + thickness / 2)):
                arm = radius * along - middle
                for column, way in ((4 * j + 2 * end, sign * across), (4 * j + 2 * end + 1, sign * along)):
                    rows[:, column] = *way, arm[0] * way[1] - arm[1] * way[0]
        rows[0, -1] = area
        balance.append(rows)
        weight += [0.0, area, 0.0]
    thrust = np.arange(0, n - 1, 2)
    slip = np.zeros((2 * len(thrust), n))
    for i, column in enumerate(thrust):
        slip[2 * i:2 * i + 2, column], slip[2 * i:2 * i + 2, column + 1] = -WITHOUT_SLIP, (1, -1)
    bounds = [(0, None) if i in thrust else (None, None) for i in range(n)]
    goal = np.zeros(n)
    goal[-1] = -1
    return linprog(goal, A_ub=slip, b_ub=np.zeros(len(slip)), A_eq=np.vstack(balance), b_eq=weight, bounds=bounds).x[-1]


def voussoirs_of(count, thickness, degrees):
    """Corners of the voussoirs of an arch of middle radius 1, from right to left, and the directions of its joints."""
    angle = np.radians(np.linspace(90 - degrees / 2, 90 + degrees / 2, count + 1))
    ways, inner, outer = np.column_stack([np.cos(angle), np.sin(angle)]), 1 - thickness / 2, 1 + thickness / 2
    return [np.array([inner * a, outer * a, outer * b, inner * b]) for a, b in zip(ways, ways[1:])], ways


def arch_file(count, thickness, degrees):
    """The blocks of such an arch between two held abutments."""
    corners, ways = voussoirs_of(count, thickness, degrees)
    low, high = 1 - HELD * thickness, 1 + HELD * thickness
    ends = []
    for way, sign in ((ways[0], -1), (ways[-1], 1)):
        back = sign * thickness * np.array([-way[1], way[0]])
        ends.append(np.array([low * way, high * way, high * way + back, low * way + back])[::sign])
    title = f"Arch of {count} voussoirs over {degrees:g} degrees, t/R = {thickness:g}"
    return block_files.block_file(title, [(1, end) for end in ends] + [(2, polygon) for polygon in corners],
                                  block_files.held(ends[0], 1) + block_files.held(ends[1], 2))


@case
def b13(run):
    """Block that one cycle of a sine overturns."""
    block = Rocking(0.25, 1.0)
    p = math.sqrt(0.75 * G / block.R)
    for ratio in (2, 4):
        least = least_pulse(block, ratio * p)
        deck = DECKS / "b13-pulse" / f"pulse{ratio}.ana"
        for share in (0.9, 0.97):
            r = run(deck, name=f"b13-{ratio}-{share}", settings=[f"acceleration.scale={share * least * G / CHORDS!r}"])
            yield Row(f"tilt over atan(b/h), {share} of {least / math.tan(block.alpha):.4f} g b/h", pulse_tilt(block, share * least, ratio * p),
                      np.abs(r.history.rotation[:, 1]).max() / block.alpha, 1e-4, 1.0)
        for share, expected in ((0.99, "stands"), (1.01, "overturns")):
            r = run(deck, name=f"b13-{ratio}-{share}", settings=[f"acceleration.scale={share * least * G / CHORDS!r}"])
            found = "overturns" if np.abs(r.history.rotation[:, 1]).max() > 1.2 * block.alpha else "stands"
            yield Row(f"{share} of {least / math.tan(block.alpha):.4f} g b/h", expected, found)


@case
def m13(run):
    """Arch pushed aside."""
    for name, (count, thickness, degrees) in ARCHES.items():
        most = pushed_arch(count, thickness, degrees)
        for share, expected in ((0.99, "stands"), (1.01, "falls")):
            push = share * most * G
            r = run(DECKS / "m13-pushed-arch" / "arch.ana", (f"m13-{name}.blk", arch_file(count, thickness, degrees)), name=f"m13-{name}-{expected}",
                    settings=[f"acceleration.table=0 {push!r} 0  1000 {push!r} 0"])
            yield Row(f"{share} of {most:.5f} g, {count} voussoirs over {degrees:g} degrees", expected, verdict(r))
