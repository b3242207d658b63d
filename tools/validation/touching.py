"""Small scenes of blocks that touch, for what contact costs and conserves: units t, m, s, kN; g 10."""
import math

import h5py
import numpy as np

from . import block_files
from .block_files import box, turned

G = 10.0


def lying(corners):
    """Moved so that the lowest corner is at y = 0."""
    return corners - [0, corners[:, 1].min()]


class Scene:
    """Blocks, the first fixed where they have a floor; E, friction angle, velocity of material 2, what its energy is measured by."""

    def __init__(self, blocks, E, phi, steps, dt, scale, floor=True, weight=True, velocity=(0, 0, 0)):
        self.steps, self.dt, self.scale = steps, dt, scale
        moving = range(1 if floor else 0, len(blocks))
        fixed = [(*corner, 1) for corner in blocks[0]] if floor else []
        self.blocks = block_files.block_file("Blocks that touch", [(1 if i == 0 else 2, b) for i, b in enumerate(blocks)], fixed,
                                             measured=[(*blocks[i].mean(0), i + 1) for i in moving])
        rock = f"2.5 {2.5 * G if weight else 0} {E} 0.25 0 0 0 0 0 0"
        self.deck = (f"1 {steps} 2 1 0.05 {dt}\n{rock} 0 0 0\n{rock} {' '.join(map(str, velocity))}\n{phi} 0 0\n"
                     "&deck dialect='short' /\n&method strain='green' /\n&output every=1 /\n")
        self.E = E

    def run(self, run, name, settings=()):
        """Runs it with more settings; `run` is a Runner."""
        deck = run.folder / f"{name}.ana"
        deck.write_text(self.deck)
        run(deck, (f"{name}.blk", self.blocks), [f"step.size={self.dt}", *settings], name=name)
        return Touching(run.folder / f"{name}.h5")


class Touching:
    """What a run of a scene took, and where its blocks went."""

    def __init__(self, path):
        with h5py.File(path) as f:
            self.time = f["history/time"][:]
            self.moved = f["measured_points/displacement"][:]
            self.rotation = f["history/rotation"][:]
            self.overlap = f["history/overlap"][:]
            self.contacts = f["history/contacts"][:]
            self.solves = f["history/solves"][:].sum() / len(self.time)
            self.dissipated = f["history/energy/dissipated"][:]
            self.friction = f["history/energy/friction"][:]


def scenes():
    slope = math.radians(30)
    floor = box(-4, 4, -1, 0)
    tilted = lying(turned(box(0, 0.5, 0, 1.5), math.radians(8)))
    square = lying(turned(box(-0.5, 0.5, 0, 1), math.radians(20))) + [0, 0.5]
    return {
        "slide on a slope": Scene([turned(box(0, 10, 0, 1), slope), turned(box(6, 7, 1, 1.5), slope)], 1e7, 20, 100, 0.005, 6.25),
        "slide over an edge": Scene([box(-4, 0, -1, 0), box(-0.6, 0.4, 0, 0.4)], 1e7, 15, 120, 0.005, 10.0, velocity=(3, 0, 0)),
        "meet in flight": Scene([box(0, 1, 0, 1), turned(box(1.08, 2.08, 0.4, 1.4), math.radians(3))], 1e5, 20, 100, 0.002, 6.6,
                                floor=False, weight=False, velocity=(-3, 0.5, 0.3)),
        "fall and bounce": Scene([floor, square], 1e7, 20, 200, 0.005, 12.5),
        "rock": Scene([floor, tilted], 1e7, 40, 200, 0.005, 14.0),
        "stand as a stack": Scene([floor, *(box(0.1 * i, 1 + 0.1 * i, i, i + 1) for i in range(4))], 1e6, 30, 200, 0.005, 25.0),
    }
