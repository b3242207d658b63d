"""What scree costs.

    tools/bench accuracy [--scree PROGRAM] [--turns 20]
    tools/bench cutting  [--scree PROGRAM] [--lines 1000 10000 100000] [--covers 10000 100000 1000000] [--crossings 6]
                         [--seed 1]
    tools/bench reading  [--scree PROGRAM] [--blocks 1000 10000 100000]
    tools/bench contact  [--scree PROGRAM]
    tools/bench wall     [--scree PROGRAM] [--steps 200]
    tools/bench rock     [--scree PROGRAM] [--seeds 0 1 2] [--steps 20]
    tools/bench fixed    [--scree PROGRAM] [--blocks 100 400 1600]

accuracy: the turning triangle by several methods and step sizes, error beside time. The error is the larger of those in volume
and angle after one turn; the ratio is that of the time of a step to the first row's. Times are those of the phase `steps` of the
results file, the least of five rounds through all rows.

cutting: how time and memory grow, from lines to blocks and from a block to manifold elements. The lines are random joints in a
square, of the length that gives each the same number of crossings whatever their number, so that the work is n log n at best. The
elements are those of a regular mesh of triangles over a square block. Growth is the exponent of n between a row and the one before
it; beside it that of n log n. Times are the least of five rounds, of fewer once they have taken thirty seconds; memory is the peak
of the process.

reading: how time and memory grow with the blocks of a block file, squares that do not touch, each with a measured point: reading and
checking them, and the set-up, in seconds of the processor. Rounds, growth and memory as of cutting.

contact: systems solved a step in small scenes of blocks that touch: contacts and deformation in one iteration or nested, and with
multipliers, at stiffness from 5 to 5000 E.

wall: a wall of 106 blocks in running bond, put up at once and left to stand: what Shi's contact and that of scree make of it, and
what each costs. At rest nothing moves: kinetic energy and the farthest that a block went sideways are errors.

rock: blocks cut at random under sudden gravity, the hard case of contact: steps taken and cut, systems solved a step, the largest
overlap over the size, the most energy that a step gained over the work of gravity so far, and time.

fixed: a step of blocks that stand apart, each with exact fixed points at its corners, beside the same blocks free, with measured
points there. Times are the least of five rounds; growth is the exponent of the number of blocks.
"""
import argparse
import math
import re
import subprocess
import sys

import numpy as np

from . import block_files, touching
from .block_files import block_file
from .errors import ScreeError
from .program import TREE, Runner, program, with_settings, work_folder
from .results import read

ROUNDS = 5
ENOUGH = 30  # seconds of rounds, after which no other begins

# Starts a program and tells on stderr its seconds and peak memory in KiB. A process of its own, because a child's peak counts from
# that of the process it was forked from.
STARTER = """
import os, sys, time
begun = time.monotonic()
_, status, used = os.wait4(os.posix_spawn(sys.argv[1], sys.argv[1:], os.environ), 0)
if status:
    sys.exit(1)
print(time.monotonic() - begun, used.ru_maxrss, file=sys.stderr)
"""


def run(path, *words):
    """What scree prints, seconds, peak memory in MB."""
    done = subprocess.run([sys.executable, "-ISc", STARTER, path, *words], capture_output=True, text=True)
    if done.returncode:
        raise ScreeError(done.stderr.strip() or f"{path} failed")
    seconds, kilobytes = map(float, done.stderr.splitlines()[-1].split())
    return done.stdout, seconds, kilobytes / 1024


# accuracy

DECK = TREE / "input" / "paper" / "rotation" / "t1.ana"
METHODS = {
    "small strain, Shi's step": ["method.strain=small", "integrator.beta=1", "integrator.gamma=0.5", "integrator.start=zero"],
    "Green strain, beta 1": ["method.strain=green", "integrator.scheme=newmark", "integrator.beta=1", "integrator.gamma=0.5",
                             "integrator.start=zero"],
    "Green strain, beta 1/2": ["method.strain=green", "integrator.scheme=newmark", "integrator.beta=0.5", "integrator.gamma=0.5",
                               "integrator.start=consistent"],
}
ENERGY_MOMENTUM = ["method.strain=green", "integrator.scheme=energy_momentum", "integrator.beta=1.0", "integrator.start=zero"]


def measure_turning(path, folder, deck, words, degrees, turns):
    """Larger error in percent after one turn, solves a step, microseconds a step, of one run."""
    settings = [*words, f"step.size={degrees / 360!r}", f"step.end_time={turns}", "output.interval=1"]
    run(path, "run", deck, "-o", folder / "r.h5", "--quiet", *with_settings(settings))
    r = read(folder / "r.h5")
    history, steps = r.history, len(r.history.time)
    one = np.searchsorted(history.time, 1 - 1e-9)
    area = history.area[one] / (np.sqrt(0.1875) * 0.01) - 1
    angle = history.rotation[one, 0] / (2 * np.pi * history.time[one]) - 1
    return 100 * max(abs(area), abs(angle)), history.solves.sum() / steps, 1e6 * r.seconds("steps") / steps


def accuracy(given, folder):
    cases = [(method, words, degrees) for method, words in METHODS.items() for degrees in (3.6, 0.36)]
    cases += [("energy-momentum, chi 1/2", ENERGY_MOMENTUM, degrees) for degrees in (20, 3.6, 0.36)]
    plain = folder / "triangle.ana"
    text = DECK.read_text().split("&integrator")[0].replace("triangle.geo", str(DECK.parent / "triangle.geo"))
    plain.write_text(text.replace(", strain='small'", ""))
    rounds = [[measure_turning(given.scree, folder, plain, words, degrees, given.turns) for _, words, degrees in cases]
              for _ in range(ROUNDS)]
    costs = [min(cost for _, _, cost in runs) for runs in zip(*rounds)]
    print(f"{'method':<28}{'degrees/step':>13}{'error %':>11}{'solves/step':>13}{'us/step':>9}{'ratio':>7}{'us/turn':>10}")
    for (method, _, degrees), (error, solves, _), cost in zip(cases, rounds[0], costs):
        print(f"{method:<28}{degrees:>13g}{error:>11.2g}{solves:>13.2f}{cost:>9.2f}{cost / costs[0]:>7.2f}"
              f"{cost * 360 / degrees:>10.0f}")


# cutting

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


def write_geometry(path, lines):
    """A geometry deck of lines of joint material 1, the first four boundary, with e0 = 0."""
    rows = "".join(f"{x1!r} {y1!r} {x2!r} {y2!r} 1\n" for x1, y1, x2, y2 in np.asarray(lines, float).tolist())
    path.write_text(f"0\n{len(lines)} 4\n0\n0 0 0 0 0\n{rows}")


def edge_for(n):
    """Edge of triangles of which so many have the area 1."""
    return math.sqrt(4 / (math.sqrt(3) * n))


def least_of_rounds(measure):
    """The least of each number that is measured, and the seconds of a round in front."""
    rounds, spent = [], 0
    while not rounds or (len(rounds) < ROUNDS and spent < ENOUGH):
        rounds.append(measure())
        spent += rounds[-1][0]
    return [min(column) for column in zip(*rounds)]


def growth(rows, of):
    """The exponent of the first column in `of` a row, between each row and the one before it."""
    exponents = [math.nan]
    for a, b in zip(rows, rows[1:]):
        both_measured = of(a) > 0 and of(b) > 0 and b[0] != a[0]
        exponents.append(math.log(of(b) / of(a)) / math.log(b[0] / a[0]) if both_measured else math.nan)
    return exponents


def print_table(columns, rows):
    """Columns are name and format; what is not a number is a dash."""
    print("".join(f"{name:>{max(10, len(name) + 2)}}" for name, _ in columns))
    for row in rows:
        print("".join(f"{format(value, form) if value == value else '-':>{max(10, len(name) + 2)}}"
                      for (name, form), value in zip(columns, row)))


def n_log_n(row):
    return row[0] * math.log(row[0])


def cut_lines(given, folder, n):
    """Lines, blocks, seconds of the phases, peak memory."""
    write_geometry(folder / "map.geo", joint_map(n, given.crossings, given.seed))

    def measure():
        printed, seconds, megabytes = run(given.scree, "cut", folder / "map.geo", "-o", folder / "map.blk")
        found = re.match(r" *(\d+) blocks.* read +([\d.]+) s, cut +([\d.]+) s, write +([\d.]+) s\n", printed).groups()
        return seconds, int(found[0]), *map(float, found[1:]), megabytes

    return n, *least_of_rounds(measure)[1:]


def cut_covers(given, folder, n):
    """Elements, seconds of the set-up and of all, peak memory."""
    write_geometry(folder / "square.geo", WINDOW)
    (folder / "square.ana").write_text(SQUARE)

    def measure():
        _, seconds, megabytes = run(given.scree, "cut", folder / "square.ana", "-o", folder / "square.h5", "--quiet",
                                    "--set", f"cover.edge={edge_for(n)!r}")
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
    rows = [cut_covers(given, folder, n) for n in given.covers]
    added = zip(growth(rows, lambda row: row[1]), growth(rows, lambda row: row[2]), growth(rows, n_log_n))
    print_table([("elements", "d"), ("set-up s", ".3f"), ("all s", ".3f"), ("MB", ".0f"),
                 ("growth of set-up", ".2f"), ("of all", ".2f"), ("n log n", ".2f")],
                [row + more for row, more in zip(rows, added)])


# reading

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


def solves_a_step(r):
    return r.history.solves.sum() / len(r.history.time)


# contact

def contact(given, folder):
    run = Runner(folder, given.scree)
    stiffness = (5, 50, 500, 5000)
    print(f"{'scene':<20}{'steps':>6}{'merged':>8}{'nested':>8}{'difference':>12}{'overlap':>9}" +
          "".join(f"{f'at {p} E':>11}" for p in stiffness) + f"{'largest overlap':>17}")
    for name, scene in touching.scenes().items():
        merged, nested = (scene.run(run, way, [f"contact.coupling={way}"]) for way in ("merged", "nested"))
        moved = [r.measured_points.displacement for r in (merged, nested)]
        difference = np.abs(moved[0] - moved[1]).max() / np.abs(moved[0]).max()
        held = [scene.run(run, f"at {p} E", ["contact.method=augmented", f"contact.stiffness={p * scene.E}"]) for p in stiffness]
        print(f"{name:<20}{scene.steps:>6}{solves_a_step(merged):>8.2f}{solves_a_step(nested):>8.2f}{difference:>12.0e}"
              f"{merged.history.overlap.max():>9.0e}" + "".join(f"{solves_a_step(r):>11.2f}" for r in held) +
              f"{max(r.history.overlap.max() for r in held):>17.0e}")


# wall

WALLS = {
    "Shi's contact": ["method.preset=shi"],
    "small strain": [],
    "Green strain": ["method.strain=green"],
    "with multipliers": ["method.strain=green", "contact.method=augmented"],
}


def wall(given, folder):
    classic, run = TREE / "tests" / "data" / "classic", Runner(folder, given.scree)
    print(f"{'wall':<20}{'steps':>7}{'solves a step':>15}{'ms a step':>11}{'ratio':>7}{'kinetic, kJ':>13}{'sideways, m':>13}{'open':>6}")
    times = []
    for name, settings in WALLS.items():
        r = run(classic / "wall100.ana", ("wall.geo", (classic / "wall100.geo").read_text()),
                [f"step.end_time={0.005 * given.steps}", *settings], name="wall")
        steps, place = len(r.history.time), r.bodies.centroid
        times.append(r.seconds("steps") / steps)
        print(f"{name:<20}{steps:>7}{solves_a_step(r):>15.2f}{1000 * times[-1]:>11.1f}{times[-1] / times[0]:>7.2f}"
              f"{r.history.energy.kinetic[-1]:>13.1e}{np.abs(place[-1] - place[0])[:, 0].max():>13.1e}{r.history.contacts[-1, 0]:>6}")


# rock

def rock(given, folder):
    run = Runner(folder, given.scree)
    print(f"{'rock':<20}{'seed':>5}{'blocks':>8}{'steps':>7}{'cut':>5}{'ms':>7}{'solves':>8}{'overlap':>9}{'gain':>9}{'seconds':>9}")
    for kind in touching.ROCKS:
        for seed in given.seeds:
            r = run(touching.jointed_rock(folder, kind, seed, given.steps), name="rock")
            h, time = r.history, r.history.time
            print(f"{kind:<20}{seed:>5}{r.n_blocks:>8}{len(time):>7}{h.rejected.sum():>5}{1000 * time[-1] / len(time):>7.2f}"
                  f"{solves_a_step(r):>8.2f}{h.overlap.max() / touching.ROCK_SIZE:>9.0e}"
                  f"{max(0.0, -np.diff(h.energy.dissipated).min()) / h.energy.gravity[-1]:>9.0e}{r.seconds('steps'):>9.1f}", flush=True)


# fixed

def fixed(given, folder):
    deck, steps, rows = folder / "fixed.ana", 200, []
    deck.write_text(f"1 {steps} 1 1 0.05 0.002\n2500 0 1e9 0.25\n{'0 0 0 ' * 3}\n30 0 0\n"
                    f"&deck dialect='short' /\n&output every={steps} /\n")
    for n in given.blocks:
        blocks = [(1, block_files.box(2 * x, 2 * x + 1, 2 * y, 2 * y + 1)) for x, y in (divmod(i, math.isqrt(n)) for i in range(n))]
        corners = [(*x, i + 1) for i, (_, box) in enumerate(blocks) for x in box]
        times = {}
        for name, points in (("fixed", {"fixed": corners}), ("free", {"measured": corners})):
            run, geometry = Runner(folder, given.scree), (f"{name}.blk", block_files.block_file(name, blocks, **points))
            for _ in range(ROUNDS):
                times[name] = min(times.get(name, math.inf), 1000 * run(deck, geometry, name=name).seconds("steps") / steps)
        rows.append((n, times["fixed"], times["free"]))
    table = zip(rows, growth(rows, lambda row: row[1]), growth(rows, lambda row: row[2]))
    print_table((("blocks", "d"), ("fixed, ms a step", ".2f"), ("growth", ".2f"), ("free", ".2f"), ("growth", ".2f"), ("ratio", ".2f")),
                [(n, held, grows, free, as_free, held / free) for (n, held, free), grows, as_free in table])


def counts(word):
    """A number of lines, covers, blocks or steps."""
    if int(word) < 2:
        raise argparse.ArgumentTypeError(f"expected a whole number from 2, found '{word}'")
    return int(word)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    common = argparse.ArgumentParser(add_help=False)
    common.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    cases = parser.add_subparsers(required=True, metavar="CASE")
    case = cases.add_parser("accuracy", parents=[common], help="error beside time, the turning triangle")
    case.add_argument("--turns", type=int, default=20, help="length of a run")
    case.set_defaults(case=accuracy)
    case = cases.add_parser("cutting", parents=[common], help="time and memory beside n, joint maps and covers")
    case.add_argument("--lines", type=counts, nargs="*", default=[1000, 10000, 100000], metavar="N")
    case.add_argument("--covers", type=counts, nargs="*", default=[10000, 100000, 1000000], metavar="N",
                      help="triangles in the area of the block; those on its sides are cut, so there are more elements")
    case.add_argument("--crossings", type=float, default=6, help="of a line on average")
    case.add_argument("--seed", type=int, default=1, help="of the lines")
    case.set_defaults(case=cutting)
    case = cases.add_parser("reading", parents=[common], help="time and memory beside n, block files")
    case.add_argument("--blocks", type=counts, nargs="*", default=[1000, 10000, 100000], metavar="N")
    case.set_defaults(case=reading)
    case = cases.add_parser("contact", parents=[common], help="systems solved by the ways to treat contact")
    case.set_defaults(case=contact)
    case = cases.add_parser("wall", parents=[common], help="a wall that stands, by Shi's contact and by scree's")
    case.add_argument("--steps", type=counts, default=200, help="of 5 ms, as asked for")
    case.set_defaults(case=wall)
    case = cases.add_parser("rock", parents=[common], help="random jointed rock under sudden gravity")
    case.add_argument("--seeds", type=int, nargs="*", default=[0, 1, 2], help="of the joints")
    case.add_argument("--steps", type=counts, default=20, help="of 5 ms, as asked for")
    case.set_defaults(case=rock)
    case = cases.add_parser("fixed", parents=[common], help="what exact fixed points cost beside n")
    case.add_argument("--blocks", type=counts, nargs="*", default=[100, 400, 1600], metavar="N")
    case.set_defaults(case=fixed)
    given = parser.parse_args()
    try:
        given.scree = program(given.scree)
        with work_folder() as folder:
            given.case(given, folder)
    except ScreeError as problem:
        print(f"tools/bench: {problem}", file=sys.stderr)
        return 1
    return 0
