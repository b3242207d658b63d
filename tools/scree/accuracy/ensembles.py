"""The run-out of a deck by both schemes: what each setting costs, and how far it is off.

Blocks that meet again and again are a chaotic system: two runs whose steps differ by one per cent end in different places. So each
setting is run several times, and the means of these runs are compared.
"""
import dataclasses
import math

import numpy as np

from ..bench.tables import Table
from ..errors import ScreeError
from .choices import Choice, DECK
from .runs import Study, recorded
from .scenes import Quantity

IMPLICIT, SMALL = "implicit", "small steps"
DEFAULTS = {"step": [1.0, 2.0], "contact": [DECK, "0.1"], "tolerance": [DECK, "1e-3"], "accuracy": ["0.1", "0.03", "0.01", "0.003", "0.001"]}
APART = 0.01  # difference of the steps of one run and the next, over the step
STAYS = 1e-3  # displacement over that of the farthest block, below which a block counts as one that stays
MEASURES = {"mean": np.mean, "95 %": lambda ways: np.quantile(ways, 0.95), "farthest": np.max}  # of the blocks that move
QUANTITIES = {"displacement": Quantity(lambda r: np.linalg.norm(r.bodies.centroid[-1] - r.bodies.centroid[0], axis=1)),
              "overlap": Quantity(lambda r: r.history.overlap.max())}


@dataclasses.dataclass(frozen=True)
class Member:
    """One run of an ensemble: its scheme, what is set otherwise than in the deck, in words too."""

    scheme: str
    knob: str
    choice: Choice
    mesh: str = DECK

    @property
    def step(self):
        return self.choice.step

    def settings(self, asked, size):
        """As those of a `Choice`, with the scheme where the deck has another one."""
        scheme = "small_steps" if self.scheme == SMALL else "energy_decaying"
        given = (self.scheme == SMALL) == (asked["integrator.scheme"] == "small_steps")
        return self.choice.settings(asked, size) + ([] if given else [f"integrator.scheme={scheme}"])


def members(axes, count):
    """The runs of all ensembles of `count` runs: the implicit scheme as it is and with one other step, contact stiffness or
    tolerance at a time; small steps by their accuracies.
    """
    knobs = {(IMPLICIT, "as it is"): {}}
    for axis in ("step", "contact", "tolerance"):
        for word in axes[axis]:
            if word not in (DECK, 1.0):
                knobs[IMPLICIT, f"{axis} {word:g} x" if axis == "step" else f"{axis} {word}" + " x" * (axis == "contact")] = {axis: word}
    knobs |= {(SMALL, f"accuracy {word}"): {"accuracy": word} for word in axes["accuracy"]}
    shifts = [1 + APART * (k - (count - 1) / 2) for k in range(count)]
    return [Member(*names, Choice(**{**knob, "step": knob.get("step", 1.0) * shift})) for names, knob in knobs.items() for shift in shifts]


class Ensembles(Study):
    """All runs of a deck by both schemes. RunFailed where the program refuses one of them."""

    def __init__(self, scene, axes, count, settings, decks, kept, path):
        every = members(axes, count)
        super().__init__(scene, every, settings, decks, kept, path)
        for scheme in (IMPLICIT, SMALL):
            if not any(run.choice.scheme == scheme for run in self.runs):
                self.made(next(one for one in every if one.scheme == scheme))

    def reference_choices(self):
        return []


class RunOut:
    """What the ensembles came to: `rows`, one an ensemble, and the `reference` by measure: (value, how far that may be off).

    The reference is the mean of two ensembles: the implicit scheme as it is, and small steps at their least accuracy. It may be off by
    its standard error, or by half the difference of the two. Where one scheme has not ended, it is the other one alone.
    """

    def __init__(self, study):
        self.scene, ensembles, ended = study.scene, {}, {}
        for run in study.runs:
            record = recorded(run)
            name = run.choice.scheme, run.choice.knob
            ensembles.setdefault(name, [])
            if record.get("ended") == "complete":
                ensembles[name].append(record)
            else:
                ended[name] = record.get("ended", "not run")
        ways = [record["values"]["displacement"] for runs in ensembles.values() for record in runs]
        if not ways:
            raise ScreeError(f"{self.scene.name}: expected runs that end, found none: {'; '.join(dict.fromkeys(ended.values()))}")
        farthest = np.max(ways, axis=0)
        self.moves = farthest > STAYS * farthest.max()
        if not self.moves.any():
            raise ScreeError(f"{self.scene.name}: expected a deck whose blocks move, found none that does")
        self.values = {name: self.measured(runs) for name, runs in ensembles.items()}
        self.reference = {measure: self.refer(measure) for measure in MEASURES}
        self.rows = [self.row(name, runs, ended.get(name, "")) for name, runs in ensembles.items()]

    def measured(self, runs):
        """Measures of each run, by name."""
        ways = [np.array(record["values"]["displacement"])[self.moves] for record in runs]
        return {measure: np.array([of(way) for way in ways]) for measure, of in MEASURES.items()}

    def refer(self, measure):
        """The reference of a measure, and how far it may be off."""
        ran = [(name, values[measure]) for name, values in self.values.items() if len(values[measure])]
        finest = [values for (scheme, knob), values in ran if scheme == IMPLICIT and knob == "as it is"]
        by_accuracy = [(float(knob.split()[-1]), values) for (scheme, knob), values in ran if scheme == SMALL]
        finest += [values for _, values in sorted(by_accuracy, key=lambda one: one[0])[:1]]
        finest = finest or [values for _, values in ran]
        means = [values.mean() for values in finest]
        error = math.hypot(*(standard_error(values) for values in finest)) / len(finest)
        return np.mean(means), max(error, np.ptp(means) / 2)

    def row(self, name, runs, ended):
        """An ensemble: means, standard deviations of one run, errors over the reference with their uncertainty."""
        row = {"scheme": name[0], "knob": name[1], "runs": len(runs), "ended": ended}
        if not runs:
            return row
        row["seconds"] = float(np.mean([seconds for record in runs for seconds in record["seconds"]]))
        row["overlap"] = float(np.mean([record["values"]["overlap"][0] for record in runs]))
        for measure, values in self.values[name].items():
            reference, _ = self.reference[measure]
            row |= {measure: float(values.mean()), f"spread: {measure}": spread(values),
                    f"error: {measure}": float(values.mean() / reference - 1), f"doubt: {measure}": standard_error(values) / reference}
        return row


def spread(values):
    """Standard deviation of one run; 0 where there is but one."""
    return float(np.std(values, ddof=1)) if len(values) > 1 else 0.0


def standard_error(values):
    """Standard deviation of the mean."""
    return spread(values) / math.sqrt(len(values))


def print_run_out(found):
    """The table of a deck and what it is held against."""
    print(f"\n{found.scene.name}: {found.scene.text}; {found.moves.sum()} of {found.moves.size} blocks move")
    columns = [("scheme", "scheme", "", -11), ("set", "knob", "", -15), ("runs", "runs", "d", 4), ("s", "seconds", ".3f", 8)]
    for measure in MEASURES:
        columns += [(measure, measure, ".4g", 8), ("+-", f"spread: {measure}", ".1g", 6), ("error", f"error: {measure}", "+.1%", 7),
                    ("+-", f"doubt: {measure}", ".1%", 5)]
    table = Table([*columns, ("overlap", "overlap", ".1e", 8), ("", "ended", "", -1)])
    for row in found.rows:
        table.add(row)
    for measure, (value, doubt) in found.reference.items():
        print(f"{measure}: errors are of {value:.4g}, which may be off by {doubt / value:.1%}")
    print("seconds are those of the processor of one run; +- after a displacement is the standard deviation of one run, after an error "
          "that of the mean")
