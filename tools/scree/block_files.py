"""Block files, and the geometries of the validation cases whose numbers vary."""
import math

import numpy as np


def block_file(title, blocks, fixed=(), load=(), measured=()):
    """Text of a block file. Blocks: (material, corners[, joint materials]); points: (x, y, block number from 1).

    Joint material i is that of the edge from corner i to the next.
    """
    rows, ranges, body = 0, [], []
    for material, corners, *joints in blocks:
        n = len(corners)
        joint = list(joints[0]) if joints else [1] * n
        ranges.append(f"{material} {rows + 1} {rows + n}")
        body += [f"{joint[i - 1]} {float(corners[i % n][0])} {float(corners[i % n][1])}" for i in range(n + 1)]
        body += ["0 0 0"] * 3
        rows += n + 4
    points = [f"{float(x)} {float(y)} {number}" for x, y, number in (*fixed, *load, *measured)]
    head = [f"! {title}", f"{len(blocks)} 0 {rows}", f"{len(fixed)} {len(load)} {len(measured)}"]
    return "\n".join(head + ranges + body + points) + "\n"


def box(x0, x1, y0, y1):
    return np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)], float)


def turned(corners, angle):
    """Turned about the origin, counter-clockwise."""
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(corners) @ np.array([[c, s], [-s, c]])


def held(corners, number, share=0.01):
    """Fixed points near the corners of a block."""
    middle = np.mean(corners, axis=0)
    return [(*(x + share * (middle - x)), number) for x in np.asarray(corners)]


def arch(voussoirs, t):
    """A semicircular arch of middle radius 1 and thickness t on a fixed base; blocks 2 to N + 1 from right to left."""
    base = box(-1.6, 1.6, -0.4, 0)
    blocks = [(1, base)]
    angles = np.pi * np.arange(voussoirs + 1) / voussoirs
    ends = np.column_stack([np.cos(angles), np.sin(angles)])
    ends[0], ends[-1] = (1, 0), (-1, 0)
    for a, b in zip(ends[:-1], ends[1:]):
        blocks.append((2, [(1 - t / 2) * a, (1 + t / 2) * a, (1 + t / 2) * b, (1 - t / 2) * b]))
    return block_file(f"Semicircular arch, {voussoirs} voussoirs, t/R = {t:.9g}", blocks, held(base, 1))


def overhang(factor, count=4, height=0.25):
    """Blocks of length 1 that hang over the edge x = 0 of a table by factor/2k each, k from the top."""
    table = box(-2, 0, -0.5, 0)
    blocks, right = [(1, table)], 0.0
    for level in range(count):
        right += factor / (2 * (count - level))
        blocks.append((2, box(right - 1, right, level * height, (level + 1) * height)))
    return block_file(f"Harmonic overhang of {count} blocks, factor {factor:g}", blocks, held(table, 1))


def running_bond(n):
    """Corners of n courses of blocks 1 x 1, each second one with half blocks at its ends, n wide, the base first."""
    blocks = [box(-1, n + 1, -1, 0)]
    for course in range(n):
        ends = np.arange(n + 1.0) if course % 2 == 0 else np.concatenate([[0], np.arange(n) + 0.5, [n]])
        blocks += [box(a, b, course, course + 1) for a, b in zip(ends[:-1], ends[1:])]
    return blocks


def on_base(title, blocks):
    """Block file of blocks of material 2 on a fixed base of material 1, the first of them."""
    base, *others = blocks
    return block_file(title, [(1, base), *((2, corners) for corners in others)], held(base, 1))


def wall(n):
    """Running bond of n courses on a fixed base."""
    return on_base(f"Wall in running bond, {n} courses", running_bond(n))


def columns(example, run=30.0, depth=20.0):
    """The toppling slope of Goodman and Bray: block 1 the stepped base, 2 to 17 the columns from the toe up."""
    w, b, count = example.width, example.step, len(example.height)
    top = [(-run, 0.0)]
    for n in range(count):
        top += [(n * w, n * b), ((n + 1) * w, n * b)]
    top.append((count * w + run, (count - 1) * b))
    del top[1]  # the floor before the toe goes on below the first column
    base = np.array([(-run, -depth), (count * w + run, -depth), *top[::-1]])
    blocks = [(1, turned(base, example.base))]
    for n, y in enumerate(example.height):
        blocks.append((2, turned(box(n * w, (n + 1) * w, n * b, n * b + y), example.base)))
    corners = turned(box(-run, count * w + run, -depth, 0), example.base)
    return block_file(f"Toppling columns of Goodman and Bray, {count} columns", blocks, held(corners, 1, 0.02))
