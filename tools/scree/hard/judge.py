"""What must be true of any run, from its results file alone: overlap by separating axes on its frames, areas, energy, momentum, time."""
import dataclasses
import re

import numpy as np

from ..polygons import deepest_overlap, worst_overlap

SPIN = 1.05           # energy of what turns over its growth, at most, up to 20 degrees a step
FRAMES = 12           # that overlap is looked for in, even in time, the last among them
# Momentum that may change where nothing outside acts, over all that there is; x, y, and the angular one, whose error is of first order
MOMENTUM = np.array([1e-9, 1e-9, 5e-4])
PASSES, REFUSED, FAILS, SLOW = "passes", "refused", "FAILS", "SLOW"


@dataclasses.dataclass
class Judgement:
    """How a run went, why, and its worst figures: overlap and travel over the edge of a block, gain of energy over what there is,
    change of area over area."""

    verdict: str
    why: str = ""
    overlap: float = None
    gain: float = None
    area: float = None
    travel: float = None
    steps: int = None
    cuts: int = None
    solves: int = None
    reached: float = None


def names_a_block(words):
    """Whether a refusal says which block, and why."""
    return bool(re.search(r"\bblocks? \d+", words)) and len(words.split(":")) > 1


def refusal(scene, words):
    """The judgement of a run that was refused or stopped with these words. Small steps may refuse what they cannot do."""
    if "integrator.scheme='small_steps' only" in words:
        return Judgement(REFUSED, words)
    if not names_a_block(words):
        return Judgement(FAILS, f"stops without block or reason: {words}")
    return Judgement(REFUSED if scene.may_refuse else FAILS, words)


def energy_gain(r, scene, size):
    """The most energy that came from nothing since any earlier time, over weights times the height, motion at the start, and work."""
    e = r.history.energy
    mass = np.array([b.density * area for b, area in zip(scene.blocks, r.bodies.area[0])])[scene.moving()]
    high = np.ptp(np.concatenate(r.polygons(0))[:, 1])
    speed = r.bodies.velocity[0, scene.moving()]
    # energy of turning of a square block, at least
    turning = sum(b.density * area**2 / 12 * (b.velocity[2] / size.time)**2 for b, area in zip(scene.blocks, r.bodies.area[0]))
    there = mass.sum() * scene.gravity * high + (mass * (speed**2).sum(1)).sum() / 2 + turning + np.abs(e.work).max()
    lost = np.append(0.0, e.dissipated)
    return float((np.maximum.accumulate(lost) - lost).max() / there)


def momentum_change(r, scene, size):
    """The largest change of momentum (3), over the sum of masses times speeds; of angular momentum over that and the size of the scene."""
    area = r.bodies.area[0]
    extent = np.ptp(np.concatenate(r.polygons(0)), axis=0).max()
    speeds = [np.linalg.norm(v) + abs(b.velocity[2]) / size.time * np.sqrt(a) for b, a, v in zip(scene.blocks, area, r.bodies.velocity[0])]
    there = sum(b.density * a * v for b, a, v in zip(scene.blocks, area, speeds))
    return np.abs(r.history.momentum - r.history.momentum[0]).max(0) / there / [1, 1, extent]


def growth_by_turning(r):
    """By how much small strain lets the area of a block grow, and what its spin is worth: 1 + r^2 in each step that turns it by r, a
    property that is known and said."""
    if not any(setting.startswith("method.strain = small") for setting in r.scene.settings):
        return 0.0
    turned = np.diff(r.history.rotation, axis=0, prepend=0.0)
    return float((np.prod(1 + turned**2, axis=0) - 1).max())


def judge(r, scene, size):
    """The judgement of the results of a run, whatever it ended by."""
    scene.meet(r)
    history, problems = r.history, []
    found = Judgement(PASSES, steps=len(history.time), cuts=int(history.rejected.sum()), solves=int(history.solves.sum()),
                      reached=float(history.time[-1]) if len(history.time) else 0.0)
    if not found.steps:
        found.verdict, found.why = SLOW, "not one step"
        return found
    measure = deepest_overlap if scene.convex else worst_overlap
    frames = np.unique(np.linspace(0, r.n_frames - 1, min(FRAMES, r.n_frames)).round().astype(int))
    found.overlap = max(measure(r.polygons(k)) for k in frames) / size.edge  # elements of one body share edges: no overlap
    found.area = float(np.abs(r.bodies.area / r.bodies.area[0] - 1).max())
    found.gain = energy_gain(r, scene, size)
    found.travel = float(np.linalg.norm(r.bodies.centroid[-1] - r.bodies.centroid[0], axis=1).max() / size.edge)
    grown = growth_by_turning(r)
    for name, value, most in (("overlap", found.overlap, scene.overlap), ("energy from nothing", found.gain, scene.gain + SPIN * grown),
                              ("area", found.area, (1 + scene.area) * (1 + grown) - 1)):
        if not value <= most:  # what is no number is not either
            problems.append(f"{name} {value:.1e}, at most {most:g}")
    if not any(block.fixed for block in scene.blocks) and scene.gravity == 0:
        changed = momentum_change(r, scene, size)
        if not (changed <= MOMENTUM + [0, 0, grown]).all():
            problems.append("momentum changes by " + ", ".join(f"{x:.0e}" for x in changed))
    status = r.scene.status
    if status == "complete" and scene.answer:
        wrong = scene.answer(r, size, scene)
        problems += [wrong] if wrong else []
        if abs(found.reached - scene.end * size.time) > 1e-9 * found.reached:
            problems.append("ended before its end")
    if status.startswith("stopped"):
        told = refusal(scene, status.removeprefix("stopped: "))
        found.verdict, found.why = told.verdict, told.why
    elif problems:
        found.verdict, found.why = FAILS, "; ".join(problems)
    elif status != "complete":
        found.verdict, found.why = SLOW, f"{found.reached / (scene.end * size.time):.0%} in the time it had"
    return found

