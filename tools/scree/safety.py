"""Finds the factor of safety of a scene by strength reduction; writes a table of its runs and a picture of the mechanism.

    tools/fs [GEOMETRY] ANALYSIS [--joints N ...] [--balance 1e-4] [--within 0.005] [--most 16] [--set GROUP.NAME=VALUE] [-o FOLDER]

tan phi, cohesion and tensile strength of the joint materials, all of them or those of --joints, are divided by a factor F. The scene
then runs as a static one, from its start. It stands if the force out of balance on each body falls below a fraction of its weight and
loads (--balance). It falls if a block moves on and on, or if the run fails. If its steps run out first, the run is undecided, and the
search ends without a factor: give the deck more steps (n5).

F begins with 1 and is doubled or halved until the scene stands with one factor and falls with another. Then the interval is halved
until its ends differ by less than a fraction (--within). The factor of safety is between them. FOLDER, by default the name of the
deck with -fs, holds fs.csv with all runs, the results of the last run that stands and of the last that falls, and mechanism.png,
which shows where the blocks of the latter went. A deck with stages, or with strength from &joints (phi, residual_phi, jrc ...), is
refused.

Exit status 0; 1 where nothing falls up to --most or stands down to its inverse, or a run is undecided; 2 for bad input.
"""
import csv
import dataclasses
import functools
import json
import math
import pathlib
import re

from .arguments import above, above_zero, ends_in_a_line, parser_for, say
from .errors import NoFactor, ScreeError
from .drawing import draw_frames, open_shapes
from .program import call, done_or_failed, made_folder, with_settings

STANDS, MOVES, UNDECIDED = "complete", "moves: ", "not in equilibrium: "  # how the status of a static run begins that ends
VERDICTS = {True: "stands", False: "falls", None: "undecided"}  # by whether a scene stands; its results are called so
TRIAL, TABLE, PICTURE = "trial.h5", "fs.csv", "mechanism.png"
FILES = (TRIAL, TABLE, PICTURE, *(f"{verdict}.h5" for verdict in VERDICTS.values()))  # that a search writes
STRENGTH = re.compile(r"^joint material (\d+).*\n  friction angle \(phi\): (\S+).*\n  cohesion \(c\): (\S+).*\n  tensile strength \(T\): (\S+)",
                      re.M)
BESIDE = re.compile(r"^  (joints\.(?:phi|cohesion|tensile_strength|residual_phi|residual_c|jrc|dilation) = \S+)|^(stage \d+)", re.M)  # other strength


@dataclasses.dataclass
class Trial:
    """A run with a factor, and what it came to: whether the scene stands, None where it is undecided; share that is out of balance,
    body that is so most, largest displacement."""

    factor: float
    stands: bool | None
    steps: int = 0
    solves: int = 0
    share: float = math.nan
    block: int = 0
    displacement: float = math.nan
    said: str = ""


class Reduction:
    """A scene whose strength is reduced."""

    def __init__(self, decks, settings, joints, balance, folder, path=None):
        self.decks, self.folder, self.path = decks, folder, path
        self.settings = [*settings, "deck.k01=0", f"step.balance={balance!r}"]
        said = done_or_failed(call("explain", *decks, *with_settings(self.settings), path=path)).stdout
        if beside := BESIDE.search(said):
            raise ScreeError("expected one stage, and no strength of joints but friction angle, cohesion and tensile strength in their rows "
                             f"of the deck, found {beside[1] or beside[2]}: a factor would not divide it")
        there = {int(number): tuple(map(float, strength)) for number, *strength in STRENGTH.findall(said)}
        unknown = [joint for joint in joints if joint not in there]
        if not there:
            raise ScreeError("expected a scene with joint materials, found none")
        if unknown:
            raise ScreeError(f"expected joint materials of the scene, 1 to {len(there)}, found {unknown}")
        self.strength = {joint: there[joint] for joint in (joints or there)}
        if not any(max(strength) > 0 for strength in self.strength.values()):
            raise ScreeError("expected a joint with friction, cohesion or tensile strength, found none: there is nothing to reduce")
        for name in FILES:  # of an earlier search
            (made_folder(folder) / name).unlink(missing_ok=True)

    def reduced(self, factor):
        """Settings of a run with strength over a factor."""
        for joint, (phi, cohesion, tension) in self.strength.items():
            weaker = math.degrees(math.atan(math.tan(math.radians(phi)) / factor))
            yield f"joint({joint}).phi={weaker!r}"
            yield f"joint({joint}).c={cohesion / factor!r}"
            yield f"joint({joint}).T={tension / factor!r}"

    def try_factor(self, factor):
        """Runs the scene; its results are kept as those of the last one that stood, fell, or was undecided."""
        partial = self.folder / TRIAL
        try:
            done = call("run", *self.decks, "-o", partial, "--quiet", "--summary", "json",
                        *with_settings([*self.settings, *self.reduced(factor)]), path=self.path)
            if done.returncode not in (0, 1):
                done_or_failed(done)
            came_to = json.loads(done.stdout)
            status, balance = came_to["status"], came_to["balance"] or {}
            stands = True if status == STANDS else None if status.startswith(UNDECIDED) else False
            if partial.exists():
                partial.replace(self.folder / f"{VERDICTS[stands]}.h5")
        finally:
            partial.unlink(missing_ok=True)  # of a run that was stopped
        return Trial(factor, stands, came_to["steps"]["taken"], came_to["steps"]["solves"], balance.get("share", math.nan),
                     balance.get("block", 0), came_to["displacement"]["largest"], "" if stands else status)


def search(try_factor, within, most):
    """Tries factors until one at which a scene stands and one at which it falls are near each other; all trials, in their order.

    Raises NoFactor where it stands with all of them, or with none. Who takes the trials ends the search at one that is undecided."""
    trials = [try_factor(1.0)]
    yield trials[0]
    step = 2.0 if trials[0].stands else 0.5
    while trials[-1].stands == trials[0].stands:
        factor = trials[-1].factor * step
        if not 1 / most <= factor <= most:
            raise NoFactor(f"it stands with a factor of {trials[-1].factor:g}: strength does not decide" if trials[0].stands else
                           f"it falls with a factor of {trials[-1].factor:g}: strength does not hold it")
        trials.append(try_factor(factor))
        yield trials[-1]
    stands, falls = bracket(trials)
    while falls - stands > within * stands:
        trials.append(try_factor(0.5 * (stands + falls)))
        yield trials[-1]
        stands, falls = bracket(trials)


def bracket(trials):
    """The largest factor at which a scene stood below the smallest at which it fell, and that."""
    falls = min(trial.factor for trial in trials if not trial.stands)
    return max((trial.factor for trial in trials if trial.stands and trial.factor < falls), default=0.0), falls


def find(reduction, within, most, show=functools.partial(print, flush=True)):
    """The factors between which a scene begins to fall; shows each trial, and writes the table of all, whatever the search comes to."""
    trials = []
    try:
        show_all(search(reduction.try_factor, within, most), trials, show)
    finally:
        write_table(reduction.folder / TABLE, trials)
    return bracket(trials)


def show_all(search, trials, show):
    """Shows the trials of a search as they are made, and adds them to a list. NoFactor at one that is undecided."""
    show(f"{'factor':>10}  {'':<9}{'steps':>7}{'solves':>8}{'out of balance':>16}{'block':>7}{'displacement':>14}")
    for trial in search:
        trials.append(trial)
        show(f"{trial.factor:10.5f}  {VERDICTS[trial.stands]:<9}{trial.steps:7}{trial.solves:8}{trial.share:16.2e}"
             f"{trial.block:7}{trial.displacement:14.3e}")
        if trial.stands is None:
            raise NoFactor("expected runs that come to equilibrium or move on and on, found one whose steps ran out before, with a factor "
                           f"of {trial.factor:g}: try more steps (n5 of the deck); {trial.said}")
        if not trial.stands and not trial.said.startswith(MOVES):
            show(f"            the run ended: {trial.said}")


def write_table(path, trials):
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(field.name for field in dataclasses.fields(Trial))
        writer.writerows(dataclasses.astuple(trial) for trial in trials)


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("decks", nargs="+", metavar="DECK")
    parser.add_argument("--joints", nargs="+", type=int, default=[], metavar="N", help="joint materials to weaken; default: all")
    parser.add_argument("--balance", type=above_zero, default=1e-4, help="share out of balance with which it stands")
    parser.add_argument("--within", type=above_zero, default=5e-3, help="share between the factors in the end")
    parser.add_argument("--most", type=above(1), default=16.0, help="largest factor, and inverse of the smallest")
    parser.add_argument("--set", action="append", default=[], metavar="GROUP.NAME=VALUE", help="a setting of every run")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FOLDER")
    given = parser.parse_intermixed_args()
    if len(given.decks) > 2:
        parser.error(f"expected at most a geometry and an analysis deck, found {' '.join(given.decks)}")
    folder = given.output or pathlib.Path(pathlib.Path(given.decks[-1]).stem + "-fs")
    reduction = Reduction(given.decks, given.set, given.joints, given.balance, folder, given.scree)
    try:
        stands, falls = find(reduction, given.within, given.most)
    except NoFactor as problem:
        say(problem)
        return 1
    draw_frames([open_shapes(str(folder / f"{VERDICTS[False]}.h5"), given.scree, folder)], ["last"], "displacement").savefig(
        folder / PICTURE, dpi=130)
    print(f"factor of safety: {0.5 * (stands + falls):.4g} ({stands:.5g} stands, {falls:.5g} falls); {folder}/{TABLE}, {PICTURE}")
    return 0
