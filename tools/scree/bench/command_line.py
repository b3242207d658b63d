"""What scree costs.

    tools/bench wall     [--sizes 10 20 40 80] [--edge 1]        many blocks, a row a size:
    tools/bench column   [--sizes 100 400] [--edge 0.05]
    tools/bench pyramid  [--sizes 10 20 30] [--edge 0.005]
    tools/bench rock     [--kinds dda ...] [--seeds 0 1 2]
    tools/bench slope    [--decks g4 reg big] [--motions dynamic static]
    tools/bench tunnel   [--spacings 2 1.5 1]
                         [--set GROUP.NAME=VALUE] [--step 0.005] [--end SECONDS] [--limit 600] [--json FILE] [--keep FOLDER]
    tools/bench peers    [--scenes wall10 column100 pyramid10] [--programs scree box2d ...] [--accuracies default fine]
    tools/bench problems [FILE.h5 ...] [--json FILE]
    tools/bench cutting  [--lines 1000 10000 100000] [--traces 1000 10000 60000] [--covers 10000 100000 1000000]
                         [--crossings 6] [--seed 1]
    tools/bench reading  [--blocks 1000 10000 100000]
    tools/bench contact
    tools/bench rules    [--steps 200]
    tools/bench fixed    [--blocks 100 400 1600]
    tools/bench effects  [--size 1000] [--allocations] [--json FILE]

Each takes --scree PROGRAM.

wall, column, pyramid, rock, slope, tunnel: what steps of many blocks cost. A wall in running bond of so many courses, and a pyramid of 5 mm
blocks with so many in its lowest course, stand from the start; a column of so many blocks of 5 cm, four times as high as wide, is
put up on a base steeper than its friction and collapses; rock cut at random and slopes drawn by `scree joints` get their weight at
once, and so does rock with three sets of joints about a tunnel, of so many metres between them, static until it is in equilibrium or
moves. Units kg, m, s, N. A row has the steps asked for and made, tries that were cut, systems solved, matrices factorised and
iterations with their factors where the results tell, judgements of all contacts, the time that was reached, seconds of the
processor in the steps, the deepest overlap, the most energy that a step made over the work that the weight of all could do across
their height, the farthest that a block went, and the peak of memory. The ratio is that of the seconds to one factorisation by
CHOLMOD of a matrix in which all blocks that touch at the start are coupled, timed beside the run; growth is the exponent of the
number of blocks. A run that takes longer than the limit is asked to stop.

peers: the same walls, column and pyramid by other programs too, from PyPI, where they are installed (doc/performance.md), each at
its default accuracy and at a fine one. Overlap is measured by one routine for all, from the places of the blocks.

problems: friction problems that steps posed, where their iteration ran in circles, each solved by the solver of such problems alone:
those of results files of runs with output.problems='all', or 'failed', else a kept set (doc/testing.md). A row has the unknowns,
the springs, what is left out of balance over the largest force, matrices factorised, pieces of paths, and seconds of the processor.

cutting: how time and memory grow, from lines to blocks and from a block to manifold elements. The lines are random joints in a
square, of the length that gives each the same number of crossings whatever their number, so that the work is n log n at best. The
traces are so few in their area that most blocks are islands in one block; the block file is read back. The elements are those of a
regular mesh of triangles over a square block. Growth is the exponent of n between a row and the one before it; beside it that of
n log n. Times are the least of five rounds, of fewer once they have taken thirty seconds; memory is the peak of the process.

reading: how time and memory grow with the blocks of a block file, squares that do not touch, each with a measured point: reading and
checking them, and the set-up, in seconds of the processor. Rounds, growth and memory as of cutting.

contact: systems solved a step in small scenes of blocks that touch: contacts and deformation in one iteration or nested, and with
multipliers, at stiffness from 5 to 5000 E.

rules: a wall of 106 blocks in running bond, put up at once and left to stand: what Shi's contact and that of scree make of it, and
what each costs. At rest nothing moves: kinetic energy and the farthest that a block went sideways are errors.

fixed: a step of blocks that stand apart, each with exact fixed points at its corners, beside the same blocks free, with measured
points there. Times are the least of five rounds; growth is the exponent of the number of blocks.

effects: what effects cost where they are absent, of zero strength, far away or at rest. Under each scene stand the same with one
more thing in it: unknowns and entries of the matrices that are solved, systems solved a step, instructions a step by valgrind
(callgrind; without it none are given), without output, and allocations where asked for; the ratio of the instructions to those
of the scene without, and what it is to be at most. In the last scene so many squares are on the ground, a hundredth of which slides.
"""
import argparse

from .. import touching
from ..arguments import above_zero, ends_in_a_line, parser_for, whole_from
from ..program import program, work_folder
from . import peers, problems, settling
from .contact import contact, rules
from .cutting import cutting, reading
from .effects import effects
from .fixed import fixed


def any_scree():
    """Options of every case."""
    options = argparse.ArgumentParser(add_help=False)
    options.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    return options


def many_blocks():
    """Options of the cases of many blocks."""
    options = argparse.ArgumentParser(add_help=False, parents=[any_scree()])
    options.add_argument("--set", action="append", default=[], metavar="GROUP.NAME=VALUE",
                         help="a setting of every run; may be repeated")
    options.add_argument("--step", type=above_zero, default=0.005, metavar="SECONDS", help="size of a step, as asked for")
    options.add_argument("--limit", type=above_zero, default=600.0, metavar="SECONDS", help="after which a run is asked to stop")
    options.add_argument("--json", metavar="FILE", help="writes the rows there too")
    options.add_argument("--keep", metavar="FOLDER", help="keeps decks and results there")
    return options


def add_settling(cases, options):
    """The cases of many blocks."""
    for name, sizes, edge, end, what in (
            ("wall", [10, 20, 40, 80], 1, 1, "courses of a wall that stands"),
            ("column", [100, 400], 0.05, 1, "blocks of a column that collapses"),
            ("pyramid", [10, 20, 30], 0.005, 1, "blocks in the lowest course of a pyramid that stands")):
        case = cases.add_parser(name, parents=[options], help=what)
        case.add_argument("--sizes", type=whole_from(2), nargs="+", default=sizes, metavar="N", help=what)
        case.add_argument("--edge", type=above_zero, default=edge, metavar="METRES", help="of a block")
        case.add_argument("--end", type=above_zero, default=end, metavar="SECONDS", help="of the motion")
        case.set_defaults(case=settling.settling, name=name)
    case = cases.add_parser("rock", parents=[options], help="random jointed rock under sudden gravity")
    case.add_argument("--kinds", nargs="+", choices=touching.ROCKS, default=list(touching.ROCKS))
    case.add_argument("--seeds", type=int, nargs="+", default=[0, 1, 2], help="of the joints")
    case.add_argument("--end", type=above_zero, default=0.1, metavar="SECONDS", help="of the motion")
    case.set_defaults(case=settling.settling, name="rock")
    case = cases.add_parser("slope", parents=[options], help="slopes of 7, 37 and 697 blocks under sudden gravity")
    case.add_argument("--decks", nargs="+", choices=["g4", "reg", "big"], default=["g4", "reg", "big"])
    case.add_argument("--motions", nargs="+", choices=["dynamic", "static"], default=["dynamic", "static"])
    case.add_argument("--end", type=above_zero, default=0.5, metavar="SECONDS", help="of the motion")
    case.set_defaults(case=settling.settling, name="slope")
    case = cases.add_parser("tunnel", parents=[options], help="a tunnel in jointed rock that gets its weight at once, static")
    case.add_argument("--spacings", type=above_zero, nargs="+", default=[2.0, 1.5, 1.0], metavar="METRES", help="of its joints")
    case.set_defaults(case=settling.settling, name="tunnel")
    case = cases.add_parser("peers", parents=[options], help="the same scenes by other programs")
    case.add_argument("--scenes", nargs="+", type=peers.scene_named, default=list(map(peers.scene_named, peers.SCENES)),
                      metavar="SCENE", help="wall, column or pyramid and its size, as wall20")
    case.add_argument("--programs", nargs="+", choices=peers.PROGRAMS, default=list(peers.PROGRAMS))
    case.add_argument("--accuracies", nargs="+", choices=peers.ACCURACIES, default=list(peers.ACCURACIES),
                      help="of the other programs")
    case.add_argument("--end", type=above_zero, default=1.0, metavar="SECONDS", help="of the motion")
    case.set_defaults(case=peers.peers, name="peers")


def add_others(cases, options):
    """The cases of single features."""
    case = cases.add_parser("problems", parents=[options], help="friction problems of steps, by their solver alone")
    case.add_argument("files", nargs="*", default=[problems.KEPT], metavar="FILE.h5", help="results of runs that kept problems")
    case.add_argument("--json", metavar="FILE", help="writes the rows there too")
    case.set_defaults(case=problems.problems)
    case = cases.add_parser("cutting", parents=[options], help="time and memory beside n, joint maps and covers")
    case.add_argument("--lines", type=whole_from(2), nargs="*", default=[1000, 10000, 100000], metavar="N")
    case.add_argument("--traces", type=whole_from(2), nargs="*", default=[1000, 10000, 60000], metavar="N",
                      help="wavy ones, of which most blocks are islands in one block")
    case.add_argument("--covers", type=whole_from(2), nargs="*", default=[10000, 100000, 1000000], metavar="N",
                      help="triangles in the area of the block; those on its sides are cut, so there are more elements")
    case.add_argument("--crossings", type=float, default=6, help="of a line on average")
    case.add_argument("--seed", type=int, default=1, help="of the lines")
    case.set_defaults(case=cutting)
    case = cases.add_parser("reading", parents=[options], help="time and memory beside n, block files")
    case.add_argument("--blocks", type=whole_from(2), nargs="*", default=[1000, 10000, 100000], metavar="N")
    case.set_defaults(case=reading)
    case = cases.add_parser("contact", parents=[options], help="systems solved by the ways to treat contact")
    case.set_defaults(case=contact)
    case = cases.add_parser("rules", parents=[options], help="a wall that stands, by Shi's contact and by scree's")
    case.add_argument("--steps", type=whole_from(2), default=200, help="of 5 ms, as asked for")
    case.set_defaults(case=rules)
    case = cases.add_parser("fixed", parents=[options], help="what exact fixed points cost beside n")
    case.add_argument("--blocks", type=whole_from(2), nargs="*", default=[100, 400, 1600], metavar="N")
    case.set_defaults(case=fixed)
    case = cases.add_parser("effects", parents=[options], help="instructions of what is absent, far away or at rest")
    case.add_argument("--size", type=whole_from(2), default=1000, metavar="N", help="squares of the largest scene")
    case.add_argument("--allocations", action="store_true", help="counts allocations too, which takes as long again")
    case.add_argument("--json", metavar="FILE", help="writes the rows there too")
    case.set_defaults(case=effects)


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    cases = parser.add_subparsers(required=True, metavar="CASE")
    add_settling(cases, many_blocks())
    add_others(cases, any_scree())
    given = parser.parse_args()
    given.scree = program(given.scree)
    with work_folder(getattr(given, "keep", None)) as folder:
        given.case(given, folder)
    return 0
