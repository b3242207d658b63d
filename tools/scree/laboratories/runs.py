"""The runs of a laboratory, a specimen each in a process of its own, and what each measures."""
from __future__ import annotations

import concurrent.futures
import dataclasses
import os
import pathlib
from collections.abc import Callable, Sequence

import numpy as np

from ..program import StrPath
from ..records import Bar, stopped_at_once
from ..results import Results
from .specimens import Specimen

ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
STRAIGHT = (0.1, 0.4)  # of the peak: between them stress over strain is E
ONSET = 0.02           # of all bonds that break in tension: the stress then counts as the begin of cracks
WINDOW, LEVEL = 0.25, 0.02  # a stress is level whose means over two parts of the end, of so much of the strain at the peak, differ by so much of it
LOOK = 20              # steps after which a confined test looks whether its stress is level
GAUGES = 5             # pairs of points across the specimen and along it


@dataclasses.dataclass
class Outcome:
    """What a test of one specimen came to. `strain` and `stress` (n) are along the load, compression positive, from the first step on, `lateral`
    is the strain across it, `bonds` (n, 3) that hold, that broke in tension and in shear. `strength` is the largest stress, `young` and `poisson`
    are slopes of the straight part, of a confined or unconfined specimen alone. `has_peak` says whether the stress fell to the share of the
    peak at which a test ends, or is level after it."""

    specimen: Specimen
    seed: int
    path: pathlib.Path
    strain: np.ndarray
    stress: np.ndarray
    lateral: np.ndarray
    bonds: np.ndarray
    has_peak: bool
    grains: int
    seconds: float

    @property
    def peak(self) -> int:
        """The step of the largest stress."""
        return int(np.argmax(self.stress))

    @property
    def strength(self) -> float:
        return float(self.stress[self.peak])

    @property
    def residual(self) -> float | None:
        """The level stress at the end; None where it is not level."""
        return level_stress(self.strain, self.stress)

    @property
    def straight(self) -> slice:
        """Steps of the straight part of the curve."""
        low, high = (int(np.argmax(self.stress >= share * self.strength)) for share in STRAIGHT)
        return slice(low, max(high, low + 1) + 1)

    @property
    def young(self) -> float:
        """Slope of stress over strain; in plane strain it is E/(1 - nu^2) of an even rock."""
        return float(np.polyfit(self.strain[self.straight], self.stress[self.straight], 1)[0])

    @property
    def poisson(self) -> float:
        """Strain across over strain along; in plane strain it is nu/(1 - nu) of an even rock."""
        return float(np.polyfit(self.strain[self.straight], self.lateral[self.straight], 1)[0])

    @property
    def onset(self) -> float:
        """Stress at which bonds begin to break."""
        return float(self.stress[int(np.argmax(self.bonds[:, 1:].sum(axis=1) > ONSET * self.bonds[0, 0]))])

    @property
    def broken(self) -> tuple[int, int]:
        """Bonds that broke in tension and in shear until the end."""
        return int(self.bonds[-1, 1]), int(self.bonds[-1, 2])


def run_specimen(specimen: Specimen, seed: int, folder: pathlib.Path, path: StrPath | None = None) -> Outcome:
    """Tests one specimen, whose decks and results stay in a folder. A confined test ends where its stress is level after the peak."""
    spent: dict[int, float] = {}  # seconds of the processor of each part of the run, by the steps at its end

    def look(results: Results) -> bool:
        spent[len(results.history.time)] = processor_seconds(results)
        return level_stress(*curve_of(specimen, results)) is None

    results = specimen.model(seed).run(folder / f"{specimen.kind}-{specimen.pressure / 1e6:g}-{seed}.h5", path=path, env=os.environ | ONE_THREAD,
                                       each=look if specimen.pressure > 0 else None, every=LOOK)
    look(results)
    return dataclasses.replace(outcome_of(specimen, seed, results), seconds=sum(spent.values()))


def processor_seconds(results: Results) -> float:
    """Of the run, or of its part since a restart."""
    return sum(float(value) for value in results.cost.processor_seconds)


def curve_of(specimen: Specimen, results: Results) -> tuple[np.ndarray, np.ndarray]:
    """Strain and stress along the load at the end of each step."""
    way = np.interp(results.history.time, *np.transpose(specimen.way()))
    return way / specimen.height, np.asarray(results.history.support_force) / specimen.area


def level_stress(strain: np.ndarray, stress: np.ndarray) -> float | None:
    """Mean of the stress over the last part of a curve; None where it still changes, or the peak is not yet passed by two parts."""
    peak = int(np.argmax(stress))
    part = WINDOW * strain[peak]
    if not strain[-1] - 2 * part >= strain[peak]:
        return None
    before, last = (stress[(strain > strain[-1] - (k + 1) * part) & (strain <= strain[-1] - k * part)] for k in (1, 0))
    if not (len(before) and abs(last.mean() - before.mean()) <= LEVEL * stress[peak]):
        return None
    return float(last.mean())


def outcome_of(specimen: Specimen, seed: int, results: Results) -> Outcome:
    """What the results of a test say."""
    history = results.history
    moved = results.measured_points.displacement.reshape(len(history.time), GAUGES, 4, 2)  # left, right, low, high
    across = (moved[:, :, 1, 0] - moved[:, :, 0, 0]).mean(axis=1) / (0.8 * specimen.width)
    strain, stress = curve_of(specimen, results)
    fell = bool(stress[-1] <= specimen.fallen * stress.max()) or level_stress(strain, stress) is not None
    return Outcome(specimen, seed, pathlib.Path(results.path), strain, stress, across, np.asarray(history.bonds), fell,
                   results.n_blocks - specimen.platens, processor_seconds(results))


def all_tests(specimens: Sequence[Specimen], seeds: Sequence[int], folder: pathlib.Path, jobs: int | None = None, path: StrPath | None = None,
              show: Callable = Bar) -> list[Outcome]:
    """Tests each specimen with each seed, so many at once."""
    pairs = [(specimen, seed) for specimen in specimens for seed in seeds]
    bar, found = show("laboratory", len(pairs), "specimens"), {}
    with concurrent.futures.ThreadPoolExecutor(jobs or len(os.sched_getaffinity(0))) as pool:
        waiting = {pool.submit(run_specimen, *pair, folder, path): i for i, pair in enumerate(pairs)}
        with stopped_at_once(pool):
            for done in concurrent.futures.as_completed(waiting):
                found[waiting[done]] = done.result()
                bar.advance(f"specimen {waiting[done] + 1}")
    bar.end()
    return [found[i] for i in range(len(pairs))]


def mohr_coulomb(outcomes: Sequence[Outcome]) -> tuple[float, float] | None:
    """Cohesion and friction angle (degrees) of a line through all strengths: over the confinement, or over the normal stress of a direct
    shear test. None where all have the same."""
    x = np.array([outcome.specimen.pressure for outcome in outcomes])
    if np.ptp(x) == 0:
        return None
    slope, start = np.polyfit(x, [outcome.strength for outcome in outcomes], 1)
    if outcomes[0].specimen.kind == "shear":
        return float(start), float(np.degrees(np.arctan(slope)))
    return float(start / (2 * np.sqrt(slope))), float(np.degrees(np.arcsin((slope - 1) / (slope + 1))))
