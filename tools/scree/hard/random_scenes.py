"""Scenes drawn at random, with options at random, and the smallest one that still fails.

A number draws a scene: its blocks are numbered by it alone, so that what is left out of a scene changes nothing else.
"""
import dataclasses
import math

import numpy as np

from ..block_files import box, turned
from .judge import FAILS
from .scene import Block, Scene

RUN = 0.5  # s


def polygon(random, radius):
    """Of three to seven corners, convex about its middle; one in four has a notch."""
    n = int(random.integers(3, 8))
    angles = (np.sort(random.uniform(0, 1, n)) + np.arange(n)) * 2 * math.pi / n
    corners = radius * np.column_stack([np.cos(angles), np.sin(angles)])
    if n > 4 and random.uniform() < 0.25:
        corners[int(random.integers(n))] *= random.uniform(0.3, 0.6)
    return corners


def trough():
    return [Block(box(-7, 7, -1, 0), fixed=True), Block(box(-7, -6, 0, 20), fixed=True), Block(box(6, 7, 0, 20), fixed=True)]


def thrown(random):
    """Polygons that fall into a trough."""
    blocks = trough()
    for k in range(int(random.integers(1, 10))):
        middle = [(k % 3 - 1) * 3.6, 1.8 + 3.0 * (k // 3)]
        velocity = (*random.uniform(-3, 3, 2).tolist(), float(random.uniform(-3, 3)))
        blocks.append(Block(polygon(random, random.uniform(0.3, 1.3)) + middle, velocity=velocity))
    return blocks, 9.81


def stacked(random):
    """Boxes on each other, of any width, each with its middle over the one below; some heavier, some apart by a gap."""
    blocks, y, x = trough(), 0.0, 0.0
    for _ in range(int(random.integers(1, 9))):
        wide, high = random.uniform(0.3, 2.0), random.uniform(0.2, 1.0)
        x += random.uniform(-0.2, 0.2)
        y += random.choice([0.0, 0.0, 1e-9, 1e-3])
        blocks.append(Block(box(x - wide / 2, x + wide / 2, y, y + high), 2500.0 * float(10 ** random.uniform(-1, 1))))
        y += high
    return blocks, 9.81


def framed(random):
    """A frame full of bricks whose joints are turned and cut at random: none has room."""
    columns, rows = int(random.integers(2, 5)), int(random.integers(2, 5))
    x = np.linspace(0, columns, columns + 1)
    shift = random.uniform(-0.3, 0.3, (rows + 1, columns + 1))
    shift[[0, -1]] = 0
    shift[:, [0, -1]] = 0
    node = lambda k, i: (x[i], k + shift[k, i])
    blocks = [Block(box(-1, columns + 1, -1, 0), fixed=True), Block(box(-1, 0, 0, rows), fixed=True),
              Block(box(columns, columns + 1, 0, rows), fixed=True)]
    blocks += [Block(np.array([node(k, i), node(k, i + 1), node(k + 1, i + 1), node(k + 1, i)]))
               for k in range(rows) for i in range(columns)]
    return blocks, 9.81


def flying(random):
    """Squares and polygons that meet where nothing acts."""
    blocks = []
    for k in range(int(random.integers(2, 7))):
        way = np.array([math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)])
        shape = polygon(random, 0.9) if random.uniform() < 0.5 else turned(box(-0.6, 0.6, -0.6, 0.6), random.uniform(0, 1.5))
        blocks.append(Block(shape + 3 * way, velocity=(*(-random.uniform(2, 8) * way).tolist(), float(random.uniform(-2, 2)))))
    return blocks, 0.0


KINDS = (thrown, stacked, framed, flying)


@dataclasses.dataclass
class Drawn:
    """A scene that was drawn, and settings that it is run with."""

    number: int
    scene: Scene
    settings: list

    def __str__(self):
        moving = len(self.scene.moving())
        return f"scene {self.number}: {moving} blocks that move, {len(self.scene.blocks) - moving} fixed; {' '.join(self.settings) or 'defaults'}"


def drawn(number):
    """The scene of a number from 0."""
    random = np.random.default_rng(number)
    blocks, gravity = KINDS[number % len(KINDS)](random)
    settings = []
    if random.uniform() < 0.5:
        settings.append("method.strain=green")
    if random.uniform() < 0.3:
        settings.append("method.plane=strain")
    if random.uniform() < 0.2:
        settings.append("contact.method=augmented")
    if random.uniform() < 0.3:
        settings.append(f"contact.viscosity={10 ** random.uniform(4, 7):.3g}")
    if random.uniform() < 0.3:
        settings.append(f"contact.stiffness={10 ** random.uniform(9.5, 12):.3g}")
    if random.uniform() < 0.2 and gravity:
        settings.append(f"damping.mass={random.uniform(0.1, 10):.3g}")
    if random.uniform() < 0.3:
        settings.append(f"step.size={10 ** random.uniform(-3.5, -1.7):.3g}")
    scene = Scene(blocks, None, mu=float(random.choice([0.0, 0.2, 0.6, 2.0])), end=RUN, gravity=gravity, overlap=0.02, convex=False)
    return Drawn(number, scene, settings)


def shrunk(found, fails):
    """The smallest scene that still fails: settings, then blocks, are left out one by one while `fails` says so of what is left."""
    smaller = True
    while smaller:
        smaller = False
        for i in range(len(found.settings)):
            less = dataclasses.replace(found, settings=found.settings[:i] + found.settings[i + 1:])
            if fails(less):
                found, smaller = less, True
                break
        for i in reversed(range(len(found.scene.blocks))):
            blocks = found.scene.blocks[:i] + found.scene.blocks[i + 1:]
            less = dataclasses.replace(found, scene=dataclasses.replace(found.scene, blocks=blocks))
            if less.scene.moving() and fails(less):
                found, smaller = less, True
                break
    return found


def has_failed(judgement):
    return judgement.verdict == FAILS
