"""The arc slide of Zhang, Li, Jiang, Lin 2019, section 6.2, over the points of the polyline, its opening, the step and the scheme."""
import math

import numpy as np

from .. import block_files
from . import references

RADIUS, LENGTH, HEIGHT = 1.5, 0.2, 0.1  # m, inferred (doc/validation.md)
PUSH_TIME, SPEED, G = 0.25, math.sqrt(20), 10.0
RISE = SPEED**2 / (2 * G)  # without any loss: h, 1 m
SCHEMES = {
    "plastic": ["integrator.scheme=energy_momentum", "integrator.beta=1.0", "contact.restitution=0.0"],
    "springs": ["integrator.scheme=energy_momentum", "integrator.beta=1.0"],
    "conserving": ["integrator.scheme=energy_momentum", "integrator.beta=0.5", "contact.rules=conserving"],
    "beta 0.8": ["integrator.scheme=newmark", "integrator.beta=0.8", "integrator.gamma=0.5"],
    "small": ["method.strain=small", "integrator.scheme=newmark", "integrator.beta=1.0", "integrator.gamma=0.5"],
}


def geometry(points, opening):
    """Block file: the fixed track, and the block with its front corner 0.559 m before the foot."""
    corners = references.track(points, opening, RADIUS, run=2.0, beyond=1.0)
    x, y = corners[-1]
    base = np.vstack([[-2.0, -0.3], [x + 0.5, -0.3], [x + 0.5, y], corners[::-1]])
    block = block_files.box(-0.559 - LENGTH, -0.559, 0.0, HEIGHT)
    centre = [(*block.mean(0), 2)]
    fixed = [(-1.9, -0.25, 1), (x + 0.4, -0.25, 1), (x + 0.4, y - 0.1, 1)]
    return block_files.block_file(f"Arc of {points} points over {opening} degrees", [(1, base), (2, block)], fixed, centre, centre)


def reference(points, opening):
    """The rigid block with plastic kinks."""
    return references.ArcSlide(references.track(points, opening, RADIUS), LENGTH, HEIGHT, SPEED, G)


def elastic(points, opening):
    """The rigid block that loses nothing: time of the top from the foot, rise, rotation's energy there over m g h, error."""
    return references.elastic_slide(references.track(points, opening, RADIUS), LENGTH, HEIGHT, SPEED, 2e9, G, 4e-7)


class Slide:
    """One run: time of the top, rise, speed back on the flat (NaN: not back in time), energies over m g h, change of area."""

    def __init__(self, run, deck, scheme, points, opening, dt, more=()):
        name = f"arc-{scheme.replace(' ', '')}-{points}-{opening}-{dt:g}"
        path = run.folder / f"arc-{points}-{opening}.blk"
        path.write_text(geometry(points, opening))
        r = run(deck, settings=[f"deck.geometry={path}", f"step.size={dt}", "step.end_time=1.9", "output.interval=0.1",
                                *SCHEMES[scheme], *more], name=name)
        time, centre = r.history.time, r.measured_points
        top = np.argmax(np.where(time < 1.4, centre.displacement[:, 0, 1], -np.inf))
        back = np.flatnonzero((time > time[top]) & (centre.position[:, 0, 0] < -LENGTH / 2 - 0.05))
        self.top_time, self.rise = time[top], centre.displacement[top, 0, 1]
        self.speed_back = -centre.velocity[back[0], 0, 0] if back.size else math.nan
        weight = 2500 * LENGTH * HEIGHT * G
        lost = r.history.energy.dissipated[time > PUSH_TIME + 1e-9] / (weight * RISE)
        self.energy_gain = max(0.0, (lost[0] - lost).max())
        self.energy_loss = lost[-1] - lost[0]
        self.step_gain = max(0.0, -np.diff(lost).min())
        self.energy_error = np.abs(lost - lost[0]).max()
        self.area = r.history.area[-1] / r.history.area[0] - 1
