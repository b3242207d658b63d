"""Runs hard scenes and prints case | size | step | strain | restitution | verdict | worst figures | steps, cuts, solves | s | peers.

    tools/hard [CASE ...] [--edges 1e-3 1 1e3] [--steps 5 1] [--strains auto small green] [--restitutions none 0 0.5 1]
               [--schemes auto small_steps] [--vary | --all] [--random N [--first NUMBER]] [--limit SECONDS] [--sheet PICTURE.png]
               [--set GROUP.NAME=VALUE] [--scree PROGRAM] [--keep FOLDER] [--list]

Without a case, all of them run. Settings are the defaults, except for five that are varied: the edge of a block in m, the step in ms
for an edge of 1 m (times grow with the root of the edge, stiffness with the edge), strain, restitution, integrator (small
steps with an accuracy of 1e-3). --vary varies one of the first four at a time, --all these together. doc/stability.md says what
is judged. A run is stopped after the limit.

Exit status 0 when every run passes or is rightly refused, 1 when one does not, 2 when the program is missing.
Needs Debian's python3-numpy, python3-h5py and, for the sheet, python3-matplotlib.
"""
import dataclasses
import itertools
import pathlib

from ..arguments import above_zero, check_picture, ends_in_a_line, parser_for, whole_from
from ..bench.processes import start
from ..bench.tables import Table
from ..errors import ResultsError
from ..program import program, with_settings, work_folder
from ..results import read
from . import judge, random_scenes
from .cases import CASES
from .scene import EDGE, STEPS, Size

COLUMNS = [
    ("case", "case", "", -16), ("edge", "edge", "g", 6), ("ms", "step", "g", 3), ("strain", "strain", "", -6),
    ("e", "restitution", "", -4), ("scheme", "scheme", "", -11), ("verdict", "verdict", "", -7),
    ("overlap", "overlap", ".1e", 8), ("gain", "gain", ".0e", 6), ("area", "area", ".0e", 6), ("travel", "travel", ".1e", 8),
    ("steps", "steps", "d", 6), ("cut", "cuts", "d", 5),
    ("solves", "solves", "d", 7), ("s", "seconds", ".1f", 7), ("peers", "peers", "", -56), ("", "why", "", -8)]


SMALL_STEPS = 1e-3   # their accuracy, at which loads near a limit stay up


@dataclasses.dataclass(frozen=True)
class Way:
    """How a case is run."""

    edge: float = EDGE
    step: float = 1e3 * STEPS[0]   # ms, for an edge of 1 m
    strain: str = "auto"
    restitution: str = "none"
    scheme: str = "auto"

    def settings(self):
        settings = [f"method.strain={self.strain}"] if self.strain != "auto" else []
        settings += ["integrator.scheme=small_steps", f"step.accuracy={SMALL_STEPS}"] if self.scheme == "small_steps" else []
        return settings + ([f"contact.restitution={self.restitution}"] if self.restitution != "none" else [])


def ways(given):
    """The ways that are asked for."""
    axes = {"edge": given.edges, "step": given.steps, "strain": given.strains, "restitution": given.restitutions, "scheme": given.schemes}
    if given.vary:
        base = Way()
        others = {"edge": [1e-3, 1e3], "step": [1e3 * STEPS[1]], "strain": ["small", "green"], "restitution": ["0", "0.5", "1"]}
        return [base, *(dataclasses.replace(base, **{name: value}) for name, values in others.items() for value in values)]
    if given.all:
        axes = {"edge": [1.0, 1e-3, 1e3], "step": [1e3 * s for s in STEPS], "strain": ["auto", "small", "green"],
                "restitution": ["none", "0", "0.5", "1"]}
    return [Way(*values) for values in itertools.product(*axes.values())]


def runs_of(names, ways):
    """Cases and ways, but for those of a case that has one size."""
    return [(name, way) for name, way in itertools.product(names, ways) if CASES[name].any_size or way.edge == EDGE]


def run(name, way, folder, path, settings=(), limit=0.0):
    """Runs a case one way; its judgement, its seconds, and its results file where there is one."""
    words = "-".join([name, f"{way.edge:g}", f"{way.step:g}", way.strain, way.restitution, way.scheme])
    return run_scene(CASES[name].make(), words, way, folder, path, settings, limit)


def run_scene(scene, name, way, folder, path, settings=(), limit=0.0):
    """Likewise a scene by a name."""
    size, output = Size(way.edge), folder / f"{name}.h5"
    output.unlink(missing_ok=True)
    decks = scene.write(folder, name, size, 1e-3 * way.step)
    given = [*way.settings(), *scene.settings(size), *settings]
    done = start(path, "run", *decks, "-o", output, "--quiet", *with_settings(given), limit=limit)
    words = (done.said.splitlines() or [""])[-1].removeprefix("scree: ")
    if not output.exists():
        return judge.refusal(scene, words), done.seconds, None
    try:
        found = judge.judge(read(output), scene, size)
    except ResultsError as problem:
        found = judge.Judgement(judge.FAILS, str(problem))
    if done.status not in (0, 1, 143):  # it died
        found.verdict, found.why = judge.FAILS, f"exit status {done.status}: {words}"
    return found, done.seconds, output


def run_random(numbers, folder, path, settings=(), limit=0.0):
    """Runs scenes drawn at random and prints those that fail, each as small as it gets; how many do."""
    failures = 0
    for number in numbers:
        def judged(scene):
            found, _, _ = run_scene(scene.scene, f"random-{number}", Way(), folder, path, [*scene.settings, *settings], limit)
            return found
        scene = random_scenes.drawn(number)
        if not random_scenes.has_failed(judged(scene)):
            continue
        failures += 1
        least = random_scenes.shrunk(scene, lambda less: random_scenes.has_failed(judged(less)))
        print(f"{scene}\n  at least {least}: {judged(least).why}", flush=True)  # whose decks stay in the folder
    print(f"{len(numbers)} scenes, {failures} fail")
    return failures


def row_of(name, way, found, seconds):
    return {"case": name, **dataclasses.asdict(way), **dataclasses.asdict(found), "seconds": seconds, "peers": CASES[name].peers,
            "text": CASES[name].text}


def hold_good(rows):
    return all(row["verdict"] in (judge.PASSES, judge.REFUSED) for row in rows)


def arguments():
    parser = parser_for(__doc__)
    base = Way()
    parser.add_argument("case", nargs="*", help=f"of {' '.join(CASES)}")
    parser.add_argument("--edges", type=above_zero, nargs="+", default=[base.edge], help="of a block, m")
    parser.add_argument("--steps", type=above_zero, nargs="+", default=[base.step], help="ms, for an edge of 1 m")
    parser.add_argument("--strains", nargs="+", default=[base.strain], choices=("auto", "small", "green"))
    parser.add_argument("--restitutions", nargs="+", default=[base.restitution], help="none, or numbers from 0 to 1")
    parser.add_argument("--schemes", nargs="+", default=[base.scheme], choices=("auto", "small_steps"), help="integrators")
    parser.add_argument("--vary", action="store_true", help="the way of all defaults, and from it one thing at a time")
    parser.add_argument("--all", action="store_true", help="72 ways a case")
    parser.add_argument("--random", type=whole_from(1), default=0, metavar="N", help="N scenes drawn at random, with options at random, instead")
    parser.add_argument("--first", type=whole_from(0), default=0, help="number of the first of these (0)")
    parser.add_argument("--limit", type=above_zero, default=60.0, help="seconds of a run (60)")
    parser.add_argument("--sheet", type=pathlib.Path, help="picture of the last frame of each run")
    parser.add_argument("--json", type=pathlib.Path, help="file for the rows")
    parser.add_argument("--set", action="append", default=[], metavar="GROUP.NAME=VALUE", help="a setting of every run")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for decks and results; else they are not kept")
    parser.add_argument("--list", action="store_true", help="the cases")
    given = parser.parse_args()
    unknown = [name for name in given.case if name not in CASES]
    if unknown:
        parser.error(f"expected cases of {' '.join(CASES)}, found {' '.join(unknown)}")
    return given


@ends_in_a_line
def main():
    given = arguments()
    if given.list:
        print("\n".join(f"{name:<16}{case.text}" for name, case in CASES.items()))
        return 0
    if given.sheet:
        check_picture(given.sheet)
    table, pictures = Table(COLUMNS), []
    path = program(given.scree)
    with work_folder(given.keep) as folder:
        if given.random:
            numbers = range(given.first, given.first + given.random)
            return 1 if run_random(numbers, folder, path, given.set, given.limit) else 0
        for name, way in runs_of(given.case or CASES, ways(given)):
            found, seconds, output = run(name, way, folder, path, given.set, given.limit)
            table.add(row_of(name, way, found, seconds))
            if output:
                pictures.append((name, way, found, output))
        if given.sheet:
            from .sheet import draw_sheet  # here, as matplotlib takes a second to begin
            draw_sheet(pictures, given.sheet)
    if given.json:
        table.write(given.json)
    verdicts = [row["verdict"] for row in table.rows]
    print(", ".join(f"{verdicts.count(v)} {v}" for v in dict.fromkeys(verdicts)))
    return 0 if hold_good(table.rows) else 1
