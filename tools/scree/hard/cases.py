"""The hard cases by name: a function each that makes its scene, with what other programs made of it.

H1 to H12 are those that peers were run on: their figures are the largest overlap in blocks, by default and at their finest setting,
of blocks of 1 m (E 1e10 Pa, 2500 kg/m3, mu 0.6, 2 s), of Box2D, Chipmunk, MuJoCo, and LMGC90 at 5 and 1 ms.
"""
import dataclasses
import math
from functools import partial

import numpy as np

from ..bench import scenes as bench
from ..block_files import box, running_bond, turned
from ..polygons import deepest_overlap
from .scene import Block, Scene, Written, falls, goes, stands, stays_above

G = bench.GRAVITY


@dataclasses.dataclass
class Case:
    """What it is in words, what makes its scene, and the figures of peers."""

    text: str
    make: object
    peers: str = ""
    any_size: bool = True


def floor(wide=20.0, deep=4.0):
    return Block(box(-wide, wide, -deep, 0), fixed=True)


def on_floor(*corners, wide=20.0, deep=4.0, **scene):
    """Blocks at rest on a floor."""
    return Scene([floor(wide, deep), *(Block(c) for c in corners)], **scene)


def lying(corners):
    """Moved so that the lowest corner is at y = 0."""
    return corners - [0, np.asarray(corners)[:, 1].min()]


def stack(n=100):
    return on_floor(*(box(-0.5, 0.5, i, i + 1) for i in range(n)), answer=stands(0.05))  # it shortens by 0.013 at rest


def heavy_on_light(n, ratio, young=1.0, soft=False):
    blocks = [floor(), *(Block(box(-0.5, 0.5, i, i + 1)) for i in range(n)), Block(box(-0.5, 0.5, n, n + 1), ratio * bench.DENSITY)]
    short = 2 * ratio * bench.DENSITY * G / (young * bench.YOUNG) * (n + 1)  # twice that at rest, as the weight comes at once
    return Scene(blocks, None if soft else stands(0.01 + short), young=young, may_refuse=soft, area=0.02 + 2 * short / n,
                 overlap=1e-3 + short / 5)


def doubling(n=6):
    return on_floor(*(2.0**i * box(-0.5, 0.5, 0, 1) + [0, 2.0**i - 1] for i in range(n)), wide=100, deep=20, answer=stands(0.05))


def pyramid(rows, gap=0.0, top=1.0, may_refuse=False):
    blocks, apart = [floor(wide=2 * rows, deep=rows / 2)], 1 + gap
    for row in range(rows):
        left = (row - rows) / 2 * apart
        density = bench.DENSITY * (top if row == rows - 1 else 1)
        blocks += [Block(box(left + k * apart, left + k * apart + 1, row, row + 1), density) for k in range(rows - row)]
    return Scene(blocks, stands(0.05) if gap >= 0 else None, may_refuse=may_refuse, overlap=1e-3 + max(0.0, -gap))


def overhang(n, factor):
    blocks, right = [Block(box(-2, 0, -0.5, 0), fixed=True)], 0.0
    for level in range(n):
        right += factor / (2 * (n - level))
        blocks.append(Block(box(right - 1, right, level / 4, (level + 1) / 4)))
    return Scene(blocks, stands() if factor < 1 else falls(), end=2.0)


def bullet():
    return Scene([Block(box(-2, 2, -0.1, 0), fixed=True), Block(box(-0.5, 0.5, 1, 2), velocity=(0.0, -200.0, 0.0))], stays_above(0.4),
                 end=0.2, overlap=0.05, area=0.1)


def overlapping(initial=None, may_refuse=False):
    return on_floor(*(box(-0.5, 0.5, 0.9 * i, 0.9 * i + 1) for i in range(10)), answer=stands(0.02), overlap=0.101, may_refuse=may_refuse,
                    settings=lambda size: [f"contact.initial={initial}"] if initial else [])


def on_slope(angle, phi, answer, end, size=1.0, **scene):
    """A block on a slope, angles in degrees."""
    turn = math.radians(angle)
    return Scene([Block(turned(box(-40, 10, -4, 0), turn), fixed=True), Block(turned(box(0, size, 0, size), turn))], answer,
                 mu=math.tan(math.radians(phi)), end=end, **scene)


def way_down(angle, phi, t):
    a = math.radians(angle)
    return 0.5 * G * (math.sin(a) - math.cos(a) * math.tan(math.radians(phi))) * t**2


def creep():
    return on_slope(29.9, 30, stands(1e-4), 10.0)


def critical(phi):
    # its weight comes at once, and what it slips while it settles is of the size of the way
    return on_slope(30, phi, stands(1e-3) if phi > 30 else goes(way_down(30, phi, 2.0), 0.5), 2.0)


def packed(n=10):
    weight = bench.DENSITY * G
    blocks = [floor(wide=30), Block(box(n, n + 2, 0, n), fixed=True)]
    blocks += [Block(box(i, i + 1, k, k + 1)) for k in range(n) for i in range(n)]
    return Scene(blocks, stands(), pushes=[(0.01, k + 0.5, 2 + n * k, weight * n / 2, 0.0) for k in range(n)])


def arch(n=16, t=0.15):
    ends = np.column_stack([np.cos(np.pi * np.arange(n + 1) / n), np.sin(np.pi * np.arange(n + 1) / n)])
    ends[0], ends[-1] = (1, 0), (-1, 0)
    stones = [5 * np.array([(1 - t / 2) * a, (1 + t / 2) * a, (1 + t / 2) * b, (1 - t / 2) * b]) for a, b in zip(ends[:-1], ends[1:])]
    return on_floor(*stones, answer=stands())


def cards(storeys=5, length=0.4, thick=0.002, angle=25.0):
    """Cards lean by pairs; a card lies on the tops of two pairs beside each other. In lengths of a card of 0.4."""
    lean, blocks, y = math.radians(angle), [floor(wide=5, deep=1)], 0.0
    half = length * math.sin(lean) + thick * math.cos(lean)  # of the foot of a pair
    card = lying(turned(box(-thick, 0, 0, length), -lean))  # leans to the right, its upper right corner is its top
    card = card - [card[:, 0].max(), 0]
    apart, high = 2 * half, float(card[:, 1].max())
    for storey in range(storeys):
        for k in range(storeys - storey):
            middle = (k - (storeys - storey - 1) / 2) * apart
            blocks += [Block(card + [middle, y]), Block((card * [-1, 1])[::-1] + [middle, y])]
        y += high
        for k in range(storeys - storey - 1):
            left = (k - (storeys - storey - 1) / 2) * apart
            blocks.append(Block(box(left + 0.0, left + apart, y, y + thick)))
        y += thick
    return Scene(blocks, stands(0.01), mu=0.7, overlap=2e-4)


def gaps():
    bottoms = np.cumsum([1 + 10.0**-k for k in range(12, 2, -1)])
    return on_floor(box(-0.5, 0.5, 0, 1), *(box(-0.5, 0.5, y, y + 1) for y in bottoms), answer=stands())


def corner_on_corner():
    square = turned(box(-0.5, 0.5, -0.5, 0.5), math.pi / 4)
    return Scene([Block(square, fixed=True), Block(square + [1e-4, math.sqrt(2)])], falls(), overlap=0.01)


def sliver():
    return on_floor(box(-0.5, 0.5, 0, 1e-4), box(-0.5, 0.5, 1e-4, 1 + 1e-4), answer=stands())


def notch():
    a = math.radians(0.5)
    deep, wide = 2.0, 2.0 * math.tan(a)
    base = np.array([(-5, -4), (5, -4), (5, 0), (wide, 0), (0, -deep), (-wide, 0), (-5, 0)], float)
    wedge = np.array([(-0.75 * wide, 0.5 - 1), (0, -deep + 0.5 * deep - 0.5), (0.75 * wide, 0.5 - 1)], float)
    return Scene([Block(base, fixed=True), Block(wedge)], stands(2.0), convex=False, overlap=2e-3)


def speck(small=1e-3):
    """Bounds are those of the block of 1000; the speck has one of its own."""
    def sits(r, size, scene):
        block, middle = r.polygons(-1)[-1], r.bodies.centroid[-1, -1] - r.bodies.centroid[0, -1]
        depth = deepest_overlap([r.polygons(-1)[0], block]) / size.edge
        if depth > 0.01 * small or np.linalg.norm(middle) > small * size.edge:
            return f"the speck is {depth / small:.1e} of its size in the floor, and went {np.linalg.norm(middle) / small / size.edge:.1e} of it"
        return ""
    return on_floor(box(-500, 500, 0, 1000), box(1900, 1900 + small, 0, small), wide=2000, deep=200, answer=sits, overlap=0.6)


def slide(settings, overlap=1e-3):
    phi = math.degrees(math.atan(0.3))

    def scaled(size):
        name, value = settings[0].split("=")
        return [f"{name}={float(value) * (size.time if name == 'step.size' else size.edge)}"]
    return on_slope(30, phi, goes(way_down(30, phi, 2.0), 2e-3), 2.0, settings=scaled, overlap=overlap)


def friction(mu):
    return on_floor(*(box(-0.5, 0.5, i, i + 1) for i in range(5)), answer=stands(), mu=mu)


def turn(degrees):
    rate = math.radians(degrees) / 5e-3
    return Scene([Block(box(-0.5, 0.5, -0.5, 0.5), velocity=(1.0, 0.0, rate))], goes(0.2, 1e-6), gravity=0.0, end=0.2, may_refuse=True,
                 area=0.2)


def rest():
    return on_floor(box(-0.5, 0.5, 0, 1), answer=stands(1e-5), end=100.0)


def dominoes():
    rows = [box(x, x + 0.1, y, y + 1) for y in (0.0, 1.1) for x in np.arange(5) * 0.5]
    plank = box(-0.1, 2.3, 1.0, 1.1)
    tilted = lying(turned(box(0, 0.1, 0, 1), -math.radians(10))) + [-0.35, 0.0]
    blocks = [floor(), *(Block(c) for c in (*rows, plank)), Block(tilted, velocity=(4.0, 0.0, -4.0))]
    return Scene(blocks, falls(0.2), overlap=0.01)


def wall(n=20):
    base, *others = running_bond(n)
    return Scene([Block(base, fixed=True), *(Block(c) for c in others)], stands(), end=1.0)


def column(n):
    base, *others = (np.asarray(c) / 0.05 for c in bench.column(n).corners)
    return Scene([Block(base, fixed=True), *(Block(c) for c in others)], falls(), mu=0.3, end=4.0, overlap=0.02)


def painleve():
    rod = lying(turned(box(-0.01, 0.01, 0, 2), math.radians(30)))
    return Scene([floor(), Block(rod, velocity=(-4.0, 0.0, 0.0))], falls(), mu=2.0, overlap=0.01)


def chatter():
    return on_floor(box(-0.5, 0.5, 0, 1), answer=stands(1e-3), shake=(0.6, 10.0))


def bend(n=50):
    """A channel as wide as a block and a tenth; its blocks, 0.6 high, are pushed through it from behind."""
    a, wide, run = math.radians(30), 1.1, n + 2
    up = np.array([math.cos(a), math.sin(a)])
    across = np.array([-math.sin(a), math.cos(a)])
    inner = np.array([-wide * math.tan(a / 2), wide])
    lower = Block(np.array([(-run, 0), (-run, -1), (0, -1), run * up - across, run * up, (0, 0)]), fixed=True)
    upper = Block(np.array([(-run, wide), inner, inner + run * up, inner + run * up + across, (-run, wide + 1)]), fixed=True)
    row = [Block(box(-k - 1, -k, 0, 0.6)) for k in range(n)]
    push = 0.6 * n * bench.DENSITY * G  # their whole weight
    return Scene([lower, upper, *row], falls(0.2), mu=0.3, end=1.0, pushes=[(-n + 0.01, 0.3, 1 + n, push, 0.0)], overlap=0.01,
                 convex=False)


def flush(mu=0.1, speed=2.0):
    """A block slides over the joint between two blocks of its floor."""
    blocks = [Block(box(-5, 0.6, -1, 0), fixed=True), Block(box(0.6, 5, -1, 0), fixed=True),
              Block(box(-0.5, 0.5, 0, 1), velocity=(speed, 0.0, 0.0))]
    return Scene(blocks, goes(speed**2 / (2 * mu * G), 1e-2), mu=mu, end=3.0)


def flight():
    blocks = [Block(turned(box(-0.5, 0.5, -0.5, 0.5), 0.3 * k) + 1.6 * np.array([math.cos(k * math.pi / 3), math.sin(k * math.pi / 3)]),
                    velocity=(-2 * math.cos(k * math.pi / 3), -2 * math.sin(k * math.pi / 3), 0.5 * (k - 2.5))) for k in range(6)]
    return Scene(blocks, None, gravity=0.0, end=1.0, overlap=0.01)


def mesh():
    return on_floor(*(box(-0.5, 0.5, i, i + 1) for i in range(5)), wide=3, deep=1, answer=stands(), convex=True,
                    settings=lambda size: ["method.model=nmm", f"cover.edge={0.7 * size.edge}"])


def of_bench(made, overlap=0.01):
    """A scene of tools/bench, by what is true of any."""
    return Written([], None, end=made.end, overlap=overlap, made=made)


def pile(seed, n=12):
    """Polygons of three to seven corners at random that fall into a box without a lid."""
    random = np.random.default_rng(seed)
    blocks = [floor(wide=6, deep=1), Block(box(-6, -5, 0, 20), fixed=True), Block(box(5, 6, 0, 20), fixed=True)]
    for k in range(n):
        angles = np.sort(random.uniform(0, 1, corners := int(random.integers(3, 8))) + np.arange(corners)) * 2 * math.pi / corners
        radius = random.uniform(0.4, 1.2)
        middle = [(k % 3 - 1) * 3.2, 1.5 + 2.6 * (k // 3)] + random.uniform(-0.2, 0.2, 2)
        blocks.append(Block(middle + radius * np.column_stack([np.cos(angles), np.sin(angles)]),
                            velocity=(*random.uniform(-2, 2, 2).tolist(), float(random.uniform(-2, 2)))))
    return Scene(blocks, stays_above(0.0), mu=random.choice([0.0, 0.3, 0.8]), overlap=0.01)


CASES = {
    "H1": Case("stack of 100", stack,
               "falls/1e-3, 17 m/9e-5, 1.6e-3/3e-6, 1.4e-3/4e-5"),
    "H2": Case("a block 1000 times as heavy on ten", partial(heavy_on_light, n=10, ratio=1e3),
               "collapses/.011, collapses/1e-3, .017/3e-5, .043/1e-3"),
    "H2-1e4": Case("a block 1e4 times as heavy on one", partial(heavy_on_light, n=1, ratio=1e4),
                   "sinks/.28, falls/.11, .086/6e-5, .029/5e-5"),
    "H2-1e6": Case("a block 1e6 times as heavy on one crushes it", partial(heavy_on_light, n=1, ratio=1e6, soft=True),
                   "fails, fails, 1.0/1.6e-3, .90/.08"),
    "H2-1e6-hard": Case("the same on rock of 1e13 Pa", partial(heavy_on_light, n=1, ratio=1e6, young=1e3)),
    "H3": Case("sizes that double, six high", doubling,
               "through/8e-3, 3 m/6e-3, .014/3e-5, 2.5e-3/1e-5"),
    "H4": Case("pyramid, base 10", partial(pyramid, rows=10),
               ".7/.016, 1/4e-3, .04/4e-5, .01/4e-5 (of 5 mm)"),
    "H4-20": Case("pyramid, base 20", partial(pyramid, rows=20)),
    "pyramid-gaps": Case("pyramid of 20 rows with gaps of 1 %", partial(pyramid, rows=20, gap=0.01)),
    "top100": Case("pyramid of 10 rows, its top 100 times as heavy", partial(pyramid, rows=10, top=100)),
    "top200": Case("the same, 200 times", partial(pyramid, rows=10, top=200)),
    "top300": Case("the same, 300 times", partial(pyramid, rows=10, top=300)),
    "overlap25": Case("pyramid of 5 rows that overlap by 25 %", partial(pyramid, rows=5, gap=-0.25, may_refuse=True)),
    "H5": Case("overhang of 4 blocks, .99 of the limit", partial(overhang, n=4, factor=0.99),
               "falls/stands, falls, stands, stands"),
    "H5-10": Case("overhang of 10 blocks, .99 of the limit", partial(overhang, n=10, factor=0.99)),
    "H5-falls": Case("overhang of 4 blocks, 1.01 of the limit", partial(overhang, n=4, factor=1.01)),
    "H6": Case("200 m/s on a plate of 0.1 m", bullet,
               ".09/3e-3, tunnels, tunnels/3e-5, .5/.1"),
    "H7": Case("ten blocks that overlap by 10 %", partial(overlapping, may_refuse=True),
               "recovers/thrown 9 m, stays, thrown, stays"),
    "H7-allowed": Case("the same with contact.initial=0.2", partial(overlapping, initial=0.2)),
    "H8": Case("29.9 degrees, phi 30, 10 s: no creep", creep,
               "1.4 mm/4 um, 4 um/0, 48/5 mm, 0"),
    "critical-rests": Case("30 degrees, phi 30.01", partial(critical, phi=30.01)),
    "critical-slides": Case("30 degrees, phi 29.99", partial(critical, phi=29.99)),
    "H9": Case("10 x 10 packed before a wall, pushed", packed,
               "6e-3/1e-4, 4e-3/3e-6, 3.5e-4/4e-7, 1e-4/7e-7"),
    "H10-arch": Case("arch of 16 voussoirs, t/R 0.15", arch),
    "H10-cards": Case("card house, cards 0.4 x 0.002 m at 25 degrees, 5 storeys, mu 0.7", cards),
    "H11-gaps": Case("stack with gaps from 1e-12 to 1e-3", gaps),
    "H11-corner": Case("a square on its corner, on the corner of another", corner_on_corner),
    "H11-sliver": Case("a block on a sliver of 1 to 1e4", sliver),
    "H11-notch": Case("a wedge in a notch of 1 degree", notch),
    "H11-speck": Case("blocks of sizes 1e6 to 1 on a floor", speck),
    "H12-step": Case("slide at 30 degrees, mu 0.3, with steps 100 times too large", partial(slide, settings=["step.size=0.5"])),
    "H12-hard": Case("the same with contacts of 1e6 E", partial(slide, settings=["contact.stiffness=1e16"])),
    "H12-soft": Case("the same with contacts of 1e-2 E", partial(slide, settings=["contact.stiffness=1e8"], overlap=0.01)),
    "H12-phi0": Case("stack of five, phi 0", partial(friction, mu=0.0)),
    "H12-phi89": Case("stack of five, phi 89", partial(friction, mu=math.tan(math.radians(89)))),
    "H12-turn30": Case("free block that turns 30 degrees a step of 5 ms", partial(turn, degrees=30)),
    "H12-turn90": Case("free block that turns 90 degrees a step of 5 ms", partial(turn, degrees=90)),
    "H12-rest": Case("a block at rest, 20000 steps", rest),
    "domino": Case("double domino: two rows of five fall", dominoes),
    "wall": Case("wall of 20 courses in running bond", wall),
    "column100": Case("column of 100 on 25 degrees, mu 0.3: collapses", partial(column, n=100),
                      "Box2D 0.1 s, LMGC90 1.3 s"),
    "column400": Case("column of 400 on 25 degrees, mu 0.3: collapses", partial(column, n=400)),
    "painleve": Case("a rod that slides on its tip, mu 2: Painleve", painleve),
    "chatter": Case("a block on a table that shakes at its sliding limit", chatter),
    "bend": Case("fifty blocks pushed through a bend of 30 degrees", bend),
    "flush": Case("a block slides over the joint of two blocks that lie flush", flush),
    "flight": Case("six blocks meet in flight, nothing outside acts", flight),
    "mesh": Case("stack of five under a mesh, two elements a block and more", mesh),
    "pile": Case("twelve polygons at random fall into a box", partial(pile, seed=1)),
    "pile-2": Case("the same, others", partial(pile, seed=2)),
    "pile-3": Case("the same, others", partial(pile, seed=3)),
    "rock": Case("rock that forty joints cut at random", lambda: of_bench(bench.rock("dda", 3)), any_size=False),
    "rock-cracks": Case("rock with cracks, under a mesh", lambda: of_bench(bench.rock("nmm", 3)), any_size=False),
    "slope": Case("slope of 24 blocks of scree joints", lambda: of_bench(bench.slope("g4", False)), any_size=False),
    "slope700": Case("slope of 697 blocks", lambda: of_bench(bench.slope("big", False)), any_size=False),
}
