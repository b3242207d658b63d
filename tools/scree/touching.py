"""Small scenes of blocks that touch, for what contact costs and conserves: units t, m, s, kN; g 10."""
import math

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
        """Its results with more settings; `run` is a Runner."""
        deck = run.folder / f"{name}.ana"
        deck.write_text(self.deck)
        return run(deck, (f"{name}.blk", self.blocks), [f"step.size={self.dt}", *settings], name=name)


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


# Rock cut at random, 10 by 10, on a fixed line near its foot: slivers, tips beside tips, contacts that bear next to nothing. kg, m, s, N.
ROCK_SIZE, ROCK_DENSITY, ROCK_E = 10.0, 2500.0, 1e9
ROCKS = {"dda": (40, ""), "dda, Green strain": (40, "&method strain='green' /"), "nmm": (20, "&method model='nmm' /\n&cover edge=1.5 /")}


def jointed_rock(folder, kind, seed, steps, dt=0.005):
    """Writes the decks of a rock of ROCKS under sudden gravity, and returns the analysis deck."""
    joints, groups = ROCKS[kind]
    random, size = np.random.default_rng(seed), ROCK_SIZE
    lines = [(0, 0, size, 0), (size, 0, size, size), (size, size, 0, size), (0, size, 0, 0)]
    for _ in range(joints):
        centre, angle = random.uniform(0, size, 2), random.choice([random.normal(0.3, 0.15), random.normal(1.8, 0.15)])
        half = np.array([np.cos(angle), np.sin(angle)]) * random.uniform(3, 9) / 2
        lines.append((*(centre - half), *(centre + half)))
    rows = "".join(" ".join(repr(float(x)) for x in line) + " 1\n" for line in lines)
    (folder / "rock.geo").write_text(f"0.002\n{len(lines)} 4\n0 0 1 0 0 0\n{rows}-0.01 0.03 {size + 0.01} 0.03\n")
    deck = folder / "rock.ana"
    deck.write_text(f"1 {steps} 1 1 0.05 {dt}\n{ROCK_DENSITY} {ROCK_DENSITY * G} {ROCK_E} 0.25 0 0 0 0 0 0 0 0 0\n30 0 0\n"
                    f"&deck geometry='rock.geo', dialect='short' /\n{groups}\n")
    return deck
