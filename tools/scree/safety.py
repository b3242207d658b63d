"""Finds the factor of safety of a scene by strength reduction; writes a table of its runs and a picture of the mechanism.

    tools/fs [GEOMETRY] ANALYSIS [--joints NAME ...] [--stage NAME | all] [--load seismic | boundary] [--least AREA] [--inside X Y ...]
                          [--mechanisms N] [--balance 1e-4] [--within 0.005] [--most 16] [--set GROUP.NAME=VALUE] [--units m,MPa=1e6]
                          [-o FOLDER]

tan phi, cohesion and tensile strength of the joint materials, all of them or those of --joints, are divided by a factor F. So is the
tangent of their dilation angle, and without --joints the strength and the toughness at which cracks grow (cracks.strength, cracks.toughness). The
scene then runs as a static one, from its start. It stands if the force out of balance on each body falls below a fraction of its weight and
loads (--balance). It falls if a block moves on and on, or if the run fails. If its steps run out first, the run is undecided, and the
search ends without a factor: give the deck more steps (n5).

F begins with 1 and is doubled or halved until the scene stands with one factor and falls with another. Then the interval is halved
until its ends differ by less than a fraction (--within). The factor of safety is between them. FOLDER, by default the name of the
deck with -fs, holds fs.csv with all runs, the results of the last run that stands and of the last that falls, and mechanism.png,
which shows where the blocks of the latter went.

In a deck with stages the strength of the last stage is divided, that of --stage in its place, or that of all stages. Stages after
that one do not run. With --load the strength stays: F multiplies the acceleration of the ground (seismic) or pressure and traction on
edges (boundary), in the same stage.

Blocks that move together are a mechanism. With --least and --inside only mechanisms count that have this area and lie in this
polygon. Blocks of another one are taken away, as if they had fallen, and the run is made again. With --mechanisms N the search goes on
without the blocks of the mechanism that was found, for the factor of the next one. A deck with joints.jrc is refused: a rough joint
with less strength is not one of another roughness, as its friction angle falls with the stress.

Exit status 0; 1 where nothing falls up to --most or stands down to its inverse, or a run is undecided; 2 for bad input.
"""
from __future__ import annotations

import csv
import dataclasses
import functools
import json
import math
import pathlib
import tempfile
import typing
from collections.abc import Callable, Iterable, Iterator, Sequence

from .arguments import above, above_zero, ends_in_a_line, parser_for, say, whole_from
from .errors import NoFactor, ScreeError
from .in_force import Explained, numbers
from .mechanisms import Mechanism, Sought, mechanisms_of
from .model import Model
from .model.text import Setting
from .program import StrPath, call, done_or_failed, made_folder, with_settings
from .results import read
from .units import Units, add_units, units_of_files

STANDS, MOVES, UNDECIDED = "complete", "moves: ", "not in equilibrium: "  # how the status of a static run begins that ends
VERDICTS = {True: "stands", False: "falls", None: "undecided"}  # by whether a scene stands; its results are called so
TRIAL, TABLE, PICTURE = "trial.h5", "fs.csv", "mechanism.png"
LOADS = {"seismic": ("acceleration.scale",), "boundary": ("boundary.pressure", "boundary.traction")}  # that a factor multiplies
LOADED = {"seismic": ("acceleration of the ground", "acceleration.table", "acceleration.file"),
          "boundary": ("pressure or traction on edges", *LOADS["boundary"])}
STRENGTH = ("phi", "cohesion", "tensile_strength")  # of the row of a joint material
LATER_STRENGTH = ("residual_phi", "residual_c", "dilation")  # that only &joints gives
ANGLES = ("phi", "residual_phi", "dilation")
OF_BLOCKS, ROUGH = ("cracks.strength", "cracks.toughness"), "joints.jrc"
ALL = "all"
TINY = 1e-6  # of the step size: a step in which nothing moves
OF_ITS_STAGE = ("acceleration.", "step.")  # settings that a later stage does not take over


@dataclasses.dataclass
class Trial:
    """A run with a factor, and what it came to: whether the scene stands, None where it is undecided; share that is out of balance,
    body that is so most, largest displacement; number of the mechanism that is looked for, how many blocks had been taken away, area that
    moves."""

    factor: float
    stands: bool | None
    steps: int = 0
    solves: int = 0
    share: float = math.nan
    block: int = 0
    displacement: float = math.nan
    mechanism: int = 1
    taken_away: int = 0
    area: float = 0.0
    said: str = ""


class Reduction:
    """A scene whose strength is divided, or whose load is multiplied, by a factor."""

    def __init__(self, decks: Sequence[StrPath], settings: Iterable[str], joints: Iterable[str | int], balance: float,
                 folder: pathlib.Path, path: StrPath | None = None, stage: str | None = None, load: str | None = None,
                 sought: Sought | None = None) -> None:
        self.decks, self.folder, self.path, self.sought, self.load = list(decks), folder, path, sought or Sought(), load
        self.settings, self.balance = [*settings, "deck.k01=0"], f"step.balance={balance}"
        said = Explained(self._explain())
        self.stages, self.n_stages = self._stages(said, stage), len(said.stages)
        self.stage = self.stages[-1]
        if "dynamic" in said.kinds[:self.stage]:
            k = said.kinds.index("dynamic")
            raise ScreeError(f"expected static stages, found stage {k + 1} ({said.names[k]}): a factor of safety is of an equilibrium")
        self.in_force = {k: said.stages[k - 1] for k in self.stages}
        self.rows = said.joints
        chosen = list(joints)
        self.joints, self.reduces_blocks = self._joints(said, chosen), not chosen
        self._check(said)
        self.mechanism = 1
        self.gone: set[int] = set()                           # blocks of earlier mechanisms
        self.found: list[tuple[float, set[int]]] = []         # factors, and blocks that fell
        self.last: dict[float, Mechanism | None] = {}         # what moves, by the factor of the run that falls
        made_folder(folder)
        for name in (TRIAL, TABLE, *(f"{verdict}*.h5" for verdict in VERDICTS.values()), PICTURE.replace(".", "*.")):  # of an earlier search
            for there in folder.glob(name):
                there.unlink()

    def _explain(self) -> str:
        return done_or_failed(call("explain", *self.decks, *with_settings([*self.settings, self.balance]), path=self.path)).stdout

    def _stages(self, said: Explained, stage: str | None) -> list[int]:
        """Numbers of the stages whose strength or load the factor changes; the last is the one that the run ends with."""
        last = len(said.stages)
        if stage is None or stage == ALL:
            return [last] if stage is None else list(range(1, last + 1))
        if stage.isdecimal() and 1 <= int(stage) <= last:
            return [int(stage)]
        if stage not in said.names:
            raise ScreeError(f"--stage: expected all, or a stage by name or number, 1 to {last} ({', '.join(said.names)}), found '{stage}'")
        return [said.names.index(stage) + 1]

    def _joints(self, said: Explained, joints: Iterable[str | int]) -> list[int]:
        """Numbers of the joint materials whose strength is divided."""
        there, found = len(said.joints), []
        if not there:
            raise ScreeError("expected a scene with joint materials, found none")
        for joint in joints:
            if not isinstance(joint, int) and not joint.isdecimal():
                names = list(self.model().joint_materials)
                if joint not in names:
                    raise ScreeError(f"--joints: expected joint materials by number, 1 to {there}, or by name ({', '.join(names)}), "
                                     f"found '{joint}'")
                joint = names.index(joint) + 1
            found.append(int(joint))
        if unknown := [joint for joint in found if not 1 <= joint <= there]:
            raise ScreeError(f"expected joint materials of the scene, 1 to {there}, found {unknown}")
        return found or list(range(1, there + 1))

    def _check(self, said: Explained) -> None:
        """ScreeError where the factor has nothing to change, or cannot."""
        for stage in self.in_force.values():
            if self.load:
                what, *given = LOADED[self.load]
                if not any(name in stage for name in given):
                    raise ScreeError(f"--load {self.load}: expected {what} in the stage, found none")
                continue
            if any(value > 0 for joint, value in enumerate(numbers(stage, ROUGH), 1) if joint in self.joints):
                raise ScreeError(f"expected joints without {ROUGH}, found {ROUGH} = {stage[ROUGH]}: a rough joint with less strength is not "
                                 "one of another roughness; weaken other joints with --joints, or give its friction angle at the stress it bears")
            if not any(self.strength(stage, name)[joint - 1] > 0 for name in STRENGTH for joint in self.joints):
                raise ScreeError("expected a joint with friction, cohesion or tensile strength, found none: there is nothing to reduce")

    def model(self) -> Model:
        """The scene as a model, for its names and for decks that differ from it."""
        return Model.read(self.decks[-1], self.decks[0] if len(self.decks) > 1 else None)

    def strength(self, stage: dict[str, str], name: str) -> list[float]:
        """A strength of all joint materials in a stage: that of &joints where it is given, else that of their rows."""
        return numbers(stage, f"joints.{name}") or ([row[STRENGTH.index(name)] for row in self.rows] if name in STRENGTH else [])

    def reduced(self, factor: float) -> Iterator[str]:
        """Settings of a run with a factor."""
        for k, stage in self.in_force.items():
            prefix = f"stage({k})." if k > 1 else ""
            for name in LOADS[self.load] if self.load else ():
                if values := numbers(stage, name):
                    yield f"{prefix}{name}={' '.join(str(factor * value) for value in values)}"
            for name in (*STRENGTH, *LATER_STRENGTH) if not self.load else ():
                weaker = [weakened(value, name, factor) if joint in self.joints else value
                          for joint, value in enumerate(self.strength(stage, name), 1)]
                if weaker and (k > 1 or f"joints.{name}" in stage):
                    yield f"{prefix}joints.{name}={' '.join(map(str, weaker))}"
                elif weaker:
                    yield from (f"joint({joint}).{name}={weaker[joint - 1]}" for joint in self.joints)
            for name in OF_BLOCKS if self.reduces_blocks and not self.load else ():
                if of_blocks := numbers(stage, name):
                    yield f"{prefix}{name}={' '.join(str(value / factor) for value in of_blocks)}"

    def taken_away(self, factor: float) -> set[int]:
        """Blocks that fell with this factor or a smaller one, and do not count; and those of mechanisms found before."""
        return self.gone.union(*(blocks for less, blocks in self.found if less <= factor))

    def try_factor(self, factor: float) -> Trial:
        """Runs the scene, again and again without the blocks that move and do not count. The results are kept as those of the last run
        that stood, fell, or was undecided."""
        partial = self.folder / TRIAL
        try:
            while True:
                trial, moving = self.run_once(factor, partial)
                if trial.stands is not False or not moving:
                    break
                results = read(partial)
                groups = mechanisms_of(results, moving)
                counting = [one for one in groups if self.sought.counts(results, one)]
                if counting:
                    self.last[factor], trial.area = counting[0], counting[0].area
                    break
                self.found.append((factor, {int(block) for one in groups for block in one.blocks}))
            if partial.exists():
                partial.replace(self.folder / f"{self.name_of(VERDICTS[trial.stands])}.h5")
        finally:
            partial.unlink(missing_ok=True)  # of a run that was stopped
        return trial

    def name_of(self, what: str) -> str:
        """The name of a file of the mechanism that is looked for."""
        return what if self.mechanism == 1 else f"{what}-{self.mechanism}"

    def run_once(self, factor: float, partial: pathlib.Path) -> tuple[Trial, int]:
        """Runs the scene with a factor; what it came to, and the block that moves on and on, 0 where none does."""
        away = self.taken_away(factor)
        with tempfile.TemporaryDirectory() as folder:
            decks, settings = self.without(away, [*self.settings, *self.reduced(factor)], pathlib.Path(folder))
            done = call("run", *decks, "-o", partial, "--quiet", "--summary", "json", *with_settings([*settings, "output.every=1"]),
                        path=self.path)
        if done.returncode not in (0, 1):
            done_or_failed(done)
        came_to = json.loads(done.stdout)
        status, balance = came_to["status"], came_to["balance"] or {}
        reached = len(came_to.get("stages") or [0])
        if status != STANDS and reached < self.stages[0]:
            raise NoFactor(f"expected stages that stand before the factor changes anything, found another; {status}")
        stands = True if status == STANDS else None if status.startswith(UNDECIDED) else False
        trial = Trial(factor, stands, came_to["steps"]["taken"], came_to["steps"]["solves"], balance.get("share", math.nan),
                      balance.get("block", 0), came_to["displacement"]["largest"], self.mechanism, len(away),
                      said="" if stands else status)
        return trial, balance["block"] if balance.get("moves") else 0

    def without(self, away: set[int], settings: list[str], folder: pathlib.Path) -> tuple[list[StrPath], list[str]]:
        """Decks and settings of a run up to the last stage that the factor changes, without the blocks that are taken away.

        Stages alone take blocks away. In a deck without stages, one with a step so small that nothing moves comes before.
        """
        if not away and self.stage == self.n_stages:
            return self.decks, [*settings, self.balance]
        model = self.model().until(self.stage - 1)
        model.parts = [dict(part) for part in model.parts]
        balance = self.balance
        if away:
            if self.stage == 1:
                settings, balance = with_a_stage_before(model, settings), f"stage(2).{self.balance}"
            own = model.parts[-1].get("stage.remove_blocks", Setting([]))
            model.parts[-1]["stage.remove_blocks"] = Setting([*own.value, *sorted(away)])
        return [model.save(folder / f"{model.name}.ana")], [*settings, balance]

    def search_on(self, factor: float) -> None:
        """Goes on to the next mechanism, without the blocks of the one that falls with a factor. ScreeError where it is not known which."""
        mechanism = self.last.get(factor)
        if mechanism is None:
            raise NoFactor("expected blocks that move, found a run that failed: no further mechanism is known")
        self.gone |= set(map(int, mechanism.blocks))
        self.mechanism += 1


def weakened(value: float, name: str, factor: float) -> float:
    """A strength over a factor: of an angle its tangent."""
    return math.degrees(math.atan(math.tan(math.radians(value)) / factor)) if name in ANGLES else value / factor


def with_a_stage_before(model: Model, settings: list[str]) -> list[str]:
    """Puts a static stage of one tiny step before the only stage of a model; returns settings of the command line as they are then."""
    first = model.parts[0]
    own = {name: value for name, value in first.items() if name.startswith(OF_ITS_STAGE) or name.endswith(".ramp")}
    model.parts = [{name: value for name, value in first.items() if name not in own},
                   {"stage.name": Setting("reduced"), "stage.kind": Setting("static"), "step.size": Setting([model.step_size]),
                    "step.count": Setting([int(model.steps)])} | own]
    model.steps, model.step_size = 1, TINY * model.step_size
    renamed = {"deck.n5": "step.count", "deck.g1": "step.size"}
    found = []
    for setting in settings:
        name, _, value = setting.partition("=")
        name = renamed.get(name, name)
        found.append(f"{'stage(2).' if name.startswith((*OF_ITS_STAGE, 'joints.')) or name.endswith('.ramp') else ''}{name}={value}")
    return found


def search(try_factor: Callable[[float], Trial], within: float, most: float, first: float = 1.0) -> Iterator[Trial]:
    """Tries factors until one at which a scene stands and one at which it falls are near each other; all trials, in their order.

    Raises NoFactor where it stands with all of them, or with none. Who takes the trials ends the search at one that is undecided."""
    trials = [try_factor(first)]
    yield trials[0]
    step = 2.0 if trials[0].stands else 0.5
    while trials[-1].stands == trials[0].stands:
        factor = trials[-1].factor * step
        if not 1 / most <= factor <= most:
            raise NoFactor(f"it stands with a factor of {trials[-1].factor:g}: try a larger --most, where strength decides at all" if trials[0].stands else
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


@dataclasses.dataclass
class Found:
    """The factors between which a mechanism begins to move, its name in files, and the mechanism; None where the run that falls failed."""

    stands: float
    falls: float
    results: pathlib.Path
    mechanism: Mechanism | None

    @property
    def factor(self) -> float:
        """The middle between the two factors."""
        return 0.5 * (self.stands + self.falls)


def find(reduction: Reduction, within: float, most: float, show: Callable = functools.partial(print, flush=True),
         mechanisms: int = 1) -> list[Found]:
    """The factors between which a scene begins to fall, for so many mechanisms one after the other; shows each trial, and writes the table
    of all, whatever the search comes to. NoFactor where there is none for the first."""
    trials: list[Trial] = []
    found: list[Found] = []
    try:
        while len(found) < mechanisms:
            own: list[Trial] = []
            try:
                if found:
                    reduction.search_on(found[-1].falls)
                show_all(search(reduction.try_factor, within, most, found[-1].stands if found else 1.0), own, show)
            except (NoFactor, ScreeError) as problem:
                if not found:
                    raise
                show(f"no further mechanism: {problem}")
                break
            finally:
                trials += own
            stands, falls = bracket(own)
            found.append(Found(stands, falls, reduction.folder / f"{reduction.name_of(VERDICTS[False])}.h5", reduction.last.get(falls)))
    finally:
        write_table(reduction.folder / TABLE, trials)
    return found


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


def draw_mechanism(found: Found, what: str, units: Units) -> typing.Any:
    """A picture of the run that falls: displacements, states of joints, water, supports and bolts, and the factor above."""
    from .conditions import draw_conditions  # here, as matplotlib takes a second to begin
    from .drawing import JOINTS, Frames, Look, draw_frames
    shapes = Frames(found.results, found.results.stem)
    states = [JOINTS["state"]] if shapes.file.contacts_of(-1) is not None else []
    figure = draw_frames([shapes], ["last"], "displacement", [*states, draw_conditions], Look(units=units))
    where = ""
    if found.mechanism is not None:
        area, factor = units.of("[length$^2$]")
        blocks = f"{len(found.mechanism.blocks)} blocks move, " if len(found.mechanism.blocks) > 1 else "1 block moves, "
        where = f"; {blocks}{found.mechanism.area / factor:.4g} {area[1:-1]}"
    figure.axes[0].set_title(f"{what} {found.factor:.3f}{where}", fontsize=10)
    return figure


@ends_in_a_line
def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("decks", nargs="+", metavar="DECK")
    parser.add_argument("--joints", nargs="+", default=[], metavar="NAME", help="joint materials to weaken, by name or number; default: all")
    parser.add_argument("--stage", metavar="STAGE", help="whose strength or load the factor changes, by name or number, or all; default: the last")
    parser.add_argument("--load", choices=LOADS, help="multiply this load in place of dividing the strength")
    parser.add_argument("--least", type=above_zero, default=0.0, metavar="AREA", help="least area of a mechanism that counts")
    parser.add_argument("--inside", nargs="+", type=float, metavar="X", help="x y of the corners of the polygon in which a mechanism counts")
    parser.add_argument("--mechanisms", type=whole_from(1), default=1, metavar="N", help="so many, one after the other; default: 1")
    parser.add_argument("--balance", type=above_zero, default=1e-4, help="share out of balance with which it stands")
    parser.add_argument("--within", type=above_zero, default=5e-3, help="share between the factors in the end")
    parser.add_argument("--most", type=above(1), default=16.0, help="largest factor, and inverse of the smallest")
    parser.add_argument("--set", action="append", default=[], metavar="GROUP.NAME=VALUE", help="a setting of every run")
    add_units(parser)
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FOLDER")
    given = parser.parse_intermixed_args()
    if len(given.decks) > 2:
        parser.error(f"expected at most a geometry and an analysis deck, found {' '.join(given.decks)}")
    folder = given.output or pathlib.Path(pathlib.Path(given.decks[-1]).stem + "-fs")
    units = Units(given.units or units_of_files(*given.decks, path=given.scree))
    reduction = Reduction(given.decks, given.set, given.joints, given.balance, folder, given.scree, given.stage, given.load,
                          Sought(given.least, corners_of(given.inside)))
    try:
        found = find(reduction, given.within, given.most, mechanisms=given.mechanisms)
    except NoFactor as problem:
        say(problem)
        return 1
    what = f"{given.load} load factor" if given.load else "factor of safety"
    for k, one in enumerate(found, 1):
        picture = PICTURE if k == 1 else PICTURE.replace(".", f"-{k}.")
        draw_mechanism(one, what, units).savefig(folder / picture, dpi=130, bbox_inches="tight")
        number = f", mechanism {k}" if len(found) > 1 else ""
        print(f"{what}{number}: {one.factor:.4g} ({one.stands:.5g} stands, {one.falls:.5g} falls); {folder}/{TABLE}, {picture}")
    return 0


def corners_of(values: Sequence[float] | None) -> list[tuple[float, float]] | None:
    """Corners of a polygon of numbers x y; ScreeError where they are none."""
    if values is None:
        return None
    if len(values) < 6 or len(values) % 2:  # noqa: PLR2004  three corners
        raise ScreeError(f"--inside: expected x y of three corners or more, found {len(values)} numbers")
    return list(zip(values[::2], values[1::2]))
