"""Time and memory beside n: joint maps, blocks with many holes, covers, block files."""
import math
import re

import numpy as np

from ..block_files import block_file
from ..results import read
from .processes import least_of_rounds, run
from .tables import growth, n_log_n, print_table

WINDOW = [(0, 0, 1, 0), (1, 0, 1, 1), (1, 1, 0, 1), (0, 1, 0, 0)]
SQUARE = """1 1 1 1 0.01 0.001
2500 25000 1e9 0.2
0 0 0
0 0 0
0 0 0
30 0 0
&deck geometry='square.geo' /
&method model='nmm' /
"""


def joint_map(n, crossings, seed):
    """The sides of the square and n lines in it (n + 4, 4), each with so many crossings on average.

    Middles and directions are uniform; an end beyond the square is brought onto its side. Two lines of length L in a unit area
    cross with probability 2 L^2 / pi.
    """
    random = np.random.default_rng(seed)
    middle, angle = random.random((n, 2)), np.pi * random.random(n)
    half = np.sqrt(np.pi * crossings / (2 * n)) / 2 * np.column_stack([np.cos(angle), np.sin(angle)])
    return np.vstack([WINDOW, np.clip(np.hstack([middle - half, middle + half]), 0, 1)])


def trace_map(n, seed):
    """The sides of the square and n wavy traces of eight vertices (7 n + 4, 4), so few that most blocks are islands in one.

    A trace is as long as 1.7 times the side of the square that it has for itself (21 m, one in 150 m2); its vertices lie 1/200 of
    its length off, in both directions. A trace may end beyond the square.
    """
    random = np.random.default_rng(seed)
    length = 1.7 / np.sqrt(n)
    angle = np.where(random.random(n) < 0.5, 0.3, 2.0) + 0.1 * random.standard_normal(n)
    along = length * np.arange(8) / 7
    x = random.random((n, 1)) + along * np.cos(angle)[:, None] + length / 200 * random.standard_normal((n, 8))
    y = random.random((n, 1)) + along * np.sin(angle)[:, None] + length / 200 * random.standard_normal((n, 8))
    return np.vstack([WINDOW, np.stack([x[:, :-1], y[:, :-1], x[:, 1:], y[:, 1:]], -1).reshape(-1, 4)])


def write_geometry(path, lines, e0=0):
    """A geometry deck of lines of joint material 1, the first four boundary."""
    rows = "".join(f"{x1} {y1} {x2} {y2} 1\n" for x1, y1, x2, y2 in np.asarray(lines, float).tolist())
    path.write_text(f"{e0}\n{len(lines)} 4\n0\n0 0 0 0 0\n{rows}")


def edge_for(n):
    """Edge of triangles of which so many have the area 1."""
    return math.sqrt(4 / (math.sqrt(3) * n))


def cut_file(given, folder, source, to):
    """Seconds of all; blocks, most holes of a block, seconds of the phases, peak memory."""
    printed, seconds, megabytes = run(given.scree, "cut", folder / source, "-o", folder / to)
    found = re.match(r" *(\d+) blocks.* read +([\d.]+) s, cut +([\d.]+) s, write +([\d.]+) s\n", printed).groups()
    holes = max(int(line.split()[3]) for line in printed.splitlines()[2:])
    return seconds, int(found[0]), holes, *map(float, found[1:]), megabytes


def cut_lines(given, folder, n):
    """Lines, blocks, seconds of the phases, peak memory."""
    write_geometry(folder / "map.geo", joint_map(n, given.crossings, given.seed))
    _, blocks, _, *costs = least_of_rounds(lambda: cut_file(given, folder, "map.geo", "map.blk"))
    return n, blocks, *costs


def cut_islands(given, folder, n):
    """Traces, blocks, holes of one, seconds of the phases, and of reading and checking what was written, peak memory."""
    write_geometry(folder / "map.geo", trace_map(n, given.seed), 1e-6)  # a block file has no edges of 1e-8 of a block
    _, blocks, holes, read_, cut, write, megabytes = least_of_rounds(lambda: cut_file(given, folder, "map.geo", "map.blk"))
    back = least_of_rounds(lambda: cut_file(given, folder, "map.blk", "again.blk"))
    return n, blocks, holes, read_, cut, write, sum(back[3:5]), megabytes


def cut_covers(given, folder, n):
    """Elements, seconds of the set-up and of all, peak memory."""
    write_geometry(folder / "square.geo", WINDOW)
    (folder / "square.ana").write_text(SQUARE)

    def measure():
        _, seconds, megabytes = run(given.scree, "cut", folder / "square.ana", "-o", folder / "square.h5", "--quiet",
                                    "--set", f"cover.edge={edge_for(n)}")
        model = read(folder / "square.h5")
        return seconds, len(model.covers.of_element), model.seconds("set-up"), megabytes

    seconds, elements, set_up, megabytes = least_of_rounds(measure)
    return elements, set_up, seconds, megabytes


def cutting(given, folder):
    rows = [cut_lines(given, folder, n) for n in given.lines]
    added = zip(growth(rows, lambda row: row[3]), growth(rows, lambda row: sum(row[2:5])), growth(rows, n_log_n))
    print_table([("lines", "d"), ("blocks", "d"), ("read s", ".3f"), ("cut s", ".3f"), ("write s", ".3f"), ("MB", ".0f"),
                 ("growth of cut", ".2f"), ("of all", ".2f"), ("n log n", ".2f")],
                [row + more for row, more in zip(rows, added)])
    print()
    rows = [cut_islands(given, folder, n) for n in given.traces]
    added = zip(growth(rows, lambda row: row[5]), growth(rows, lambda row: sum(row[3:7])), growth(rows, n_log_n))
    print_table([("traces", "d"), ("blocks", "d"), ("holes of one", "d"), ("read s", ".3f"), ("cut s", ".3f"), ("write s", ".3f"),
                 ("read back s", ".3f"), ("MB", ".0f"), ("growth of write", ".2f"), ("of all", ".2f"), ("n log n", ".2f")],
                [row + more for row, more in zip(rows, added)])
    print()
    rows = [cut_covers(given, folder, n) for n in given.covers]
    added = zip(growth(rows, lambda row: row[1]), growth(rows, lambda row: row[2]), growth(rows, n_log_n))
    print_table([("elements", "d"), ("set-up s", ".3f"), ("all s", ".3f"), ("MB", ".0f"),
                 ("growth of set-up", ".2f"), ("of all", ".2f"), ("n log n", ".2f")],
                [row + more for row, more in zip(rows, added)])


def read_blocks(given, folder, n):
    """Blocks, seconds of reading and set-up, peak memory."""
    side = math.isqrt(n - 1) + 1
    places = [divmod(i, side) for i in range(n)]
    corners = [[(x, y), (x + 0.9, y), (x + 0.9, y + 0.9), (x, y + 0.9)] for x, y in places]
    (folder / "many.blk").write_text(block_file("squares", [(1, c) for c in corners],
                                                measured=[(x + 0.5, y + 0.5, b) for b, (x, y) in enumerate(places, 1)]))
    (folder / "many.ana").write_text(SQUARE.replace("square.geo", "many.blk").replace("nmm", "dda"))

    def measure():
        _, seconds, megabytes = run(given.scree, "cut", folder / "many.ana", "-o", folder / "many.h5", "--quiet")
        model = read(folder / "many.h5")
        return seconds, *(model.seconds(phase, "processor") for phase in ("read", "set-up")), megabytes

    return n, *least_of_rounds(measure)[1:]


def reading(given, folder):
    rows = [read_blocks(given, folder, n) for n in given.blocks]
    added = zip(growth(rows, lambda row: row[1]), growth(rows, lambda row: row[2]), growth(rows, n_log_n))
    print_table([("blocks", "d"), ("read s", ".3f"), ("set-up s", ".3f"), ("MB", ".0f"), ("growth of read", ".2f"),
                 ("of set-up", ".2f"), ("n log n", ".2f")], [row + more for row, more in zip(rows, added)])
