"""Spectra of records of the ground, and records that begin and end at rest.

    tools/spectrum RECORD [--damping 0.02 0.05] [-o spectrum.png | spectrum.csv]
    tools/spectrum RECORD --corrected quake.txt [--velocity wave.txt]

RECORD has lines t ax (ay), as &acceleration takes them, or is a record of PEER (.AT2). The spectra are the largest displacement of
oscillators with the fraction --damping of critical damping, times the circular frequency and its square: pseudo velocity and pseudo
acceleration, in units of the record. --corrected writes the record with the smallest change that brings the ground to rest where it began.
--velocity writes the velocity of that for &absorbing.

Exit status 0; 2 for bad input.
"""
from __future__ import annotations

import csv
import dataclasses
import pathlib
import re
import typing

import numpy as np

from .arguments import above, ends_in_a_line, parser_for
from .errors import ScreeError
from .program import StrPath

Motion: typing.TypeAlias = "tuple[np.ndarray, np.ndarray]"  # times (s), values (s) or (s, k)
PERIODS = np.geomspace(0.02, 10, 200)
PARTS = 60  # places in a period, at least, where the largest displacement is looked for: 0.2 % off at most


@dataclasses.dataclass
class Spectrum:
    """Largest response of oscillators to a record, by their period: displacement, pseudo velocity and pseudo acceleration."""

    period: np.ndarray
    damping: float
    displacement: np.ndarray

    @property
    def velocity(self) -> np.ndarray:
        """The displacement times the circular frequency."""
        return self.displacement * 2 * np.pi / self.period

    @property
    def acceleration(self) -> np.ndarray:
        """The displacement times the square of the circular frequency."""
        return self.displacement * (2 * np.pi / self.period) ** 2

    def plot(self, axis: typing.Any = None) -> typing.Any:
        """Draws the pseudo acceleration against the period; returns the axes."""
        if axis is None:
            import matplotlib
            matplotlib.use("Agg", force=False)
            from matplotlib import pyplot
            axis = pyplot.figure(figsize=(6.4, 4.0), layout="constrained").add_subplot()
        axis.loglog(self.period, self.acceleration, label=f"damping {self.damping:g}")
        axis.set(xlabel="period", ylabel="pseudo acceleration")
        axis.grid(which="both", alpha=0.3)
        axis.legend(frameon=False)
        return axis


def read_record(path: StrPath) -> Motion:
    """Times and values of a record: lines t ax (ay), where ! begins a comment, or a file of PEER (.AT2).

    ScreeError where a line has other numbers, or times do not increase."""
    text = pathlib.Path(path).read_text(errors="replace")
    if str(path).lower().endswith(".at2"):
        head = text.split("\n", 4)
        found = re.search(r"DT\s*=\s*([\d.Ee+-]+)", head[3] if len(head) > 4 else "")
        try:
            values = np.array(head[4].split(), float)
            return np.arange(len(values)) * float(found[1] if found else "none"), values
        except (IndexError, TypeError, ValueError):
            raise ScreeError(f"{path}: expected a record of PEER with DT= in its fourth line and numbers after it, found another file") from None
    rows = [(number, line.split("!")[0].replace(",", " ").split()) for number, line in enumerate(text.splitlines(), 1)]
    rows = [(number, words) for number, words in rows if words]
    if len(rows) < 2:
        raise ScreeError(f"{path}: expected two lines t ax (ay) at least, found {len(rows)}")
    numbers = []
    for number, words in rows:
        try:
            numbers.append([float(word) for word in words])
        except ValueError:
            numbers.append([])
        if len(numbers[-1]) not in (2, 3) or len(numbers[-1]) != len(numbers[0]) or not np.isfinite(numbers[-1]).all():
            raise ScreeError(f"{path}:{number}: expected {'t ax (ay)' if number == rows[0][0] else 'as many numbers as in the first line'}, "
                             f"found {' '.join(words)}")
        if len(numbers) > 1 and numbers[-1][0] <= numbers[-2][0]:
            raise ScreeError(f"{path}:{number}: expected times that increase, found {words[0]}")
    table = np.array(numbers)
    return table[:, 0], table[:, 1:]


def motion_of(record: Motion | StrPath) -> tuple[np.ndarray, np.ndarray]:
    """Times (s) and values (s, k) of a record, or of its file."""
    time, values = record if isinstance(record, tuple) else read_record(record)
    time, values = np.asarray(time, float), np.asarray(values, float)
    values = values.reshape(len(values), -1)
    if len(time) < 2 or len(time) != len(values) or not (np.diff(time) > 0).all() or not np.isfinite(values).all():
        raise ScreeError("expected a record of two or more increasing times with a value each, found another")
    return time, values


def response_spectrum(record: Motion | StrPath, damping: float = 0.05, periods: typing.Any = PERIODS) -> Spectrum:
    """The response spectrum of the first component of a record (times, accelerations), or of its file.

    The record is linear between its times, for which the steps of an oscillator are exact (Nigam, N. C., Jennings, P. C. (1969).
    Calculation of response spectra from strong-motion earthquake records. *Bulletin of the Seismological Society of America* 59,
    909-922). With s = w (-z + i (1 - z^2)^1/2) the two rates of its displacement u are one of z = u' - s* u, z' = s z - a."""
    time, values = motion_of(record)
    periods = np.atleast_1d(np.asarray(periods, float))
    if not 0 <= damping < 1:
        raise ScreeError(f"expected a damping from 0 to below 1, found {damping:g}")
    if not len(periods) or not (periods > 0).all():
        raise ScreeError("expected periods above 0, found others")
    w = 2 * np.pi / periods
    s = w * (-damping + 1j * np.sqrt(1 - damping**2))
    z, most, before = np.zeros(len(w), complex), np.zeros(len(w)), 0.0
    for h, a, b in zip(np.diff(time), values[:-1, 0], values[1:, 0]):
        if abs(h - before) > 1e-12 * h:
            before = h
            t = h / np.ceil(PARTS * h / periods.min()) * np.arange(1, 1 + np.ceil(PARTS * h / periods.min()))[:, None]
            turned = np.exp(s * t)
            kept, grown = (turned - 1) / s, (turned - 1 - s * t) / s**2
        path = turned * z - a * kept - (b - a) / h * grown
        z = path[-1]
        np.maximum(most, np.abs(path.imag).max(axis=0), out=most)
    free = z * np.exp(s * periods * np.linspace(0, 1, PARTS)[:, None])  # a period after the end
    most = np.maximum(most, np.abs(free.imag).max(axis=0))
    return Spectrum(periods, damping, most / s.imag)


def integrated(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Integral from 0 of values that are linear between times, at these times."""
    rise = 0.5 * np.diff(time)[:, None] * (values[1:] + values[:-1])
    return np.vstack([np.zeros(values.shape[1]), np.cumsum(rise, axis=0)])


def displaced(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Displacement by an acceleration that is linear between times, at these times."""
    h = np.diff(time)[:, None]
    velocity = integrated(time, values)
    return np.vstack([np.zeros(values.shape[1]), np.cumsum(h * velocity[:-1] + h**2 * (2 * values[:-1] + values[1:]) / 6, axis=0)])


def corrected(record: Motion | StrPath, displacement: float | typing.Sequence[float] = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A record of acceleration with the smallest correction, in the mean square, that ends it at rest at a displacement.

    Velocity and displacement at the end T are the integrals of a and of (T - t) a. Of all corrections with given integrals the
    smallest is linear, c0 + c1 (T - t)/T, with c0 + c1/2 = -v/T and c0/2 + c1/3 = -(d - d_T)/T^2."""
    time, values = motion_of(record)
    span = time[-1] - time[0]
    off = np.vstack([integrated(time, values)[-1] / span, (displaced(time, values)[-1] - np.asarray(displacement)) / span**2])
    constant, slope = np.linalg.solve([[1, 1 / 2], [1 / 2, 1 / 3]], -off)
    return time, values + constant + np.outer((time[-1] - time) / span, slope)


def write_motion(path: StrPath, time: np.ndarray, values: np.ndarray) -> None:
    """Writes lines t x y for a deck; a record of one component is along x."""
    both = np.column_stack([values, np.zeros((len(values), 2 - values.shape[1]))])
    pathlib.Path(path).write_text("".join(f"{t:.9g} {x:.9g} {y:.9g}\n" for t, (x, y) in zip(time, both)))


@ends_in_a_line
def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("record", type=pathlib.Path, metavar="RECORD")
    parser.add_argument("--damping", type=above(-1e-300, 1), nargs="+", default=[0.05], metavar="Z")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FILE", help="picture of the spectra, or .csv; default: spectrum.png")
    parser.add_argument("--corrected", type=pathlib.Path, metavar="FILE", help="write the record that ends at rest, and no spectra")
    parser.add_argument("--velocity", type=pathlib.Path, metavar="FILE", help="write its velocity, and no spectra")
    given = parser.parse_args()
    time, values = motion_of(given.record)
    if given.corrected or given.velocity:
        still, better = corrected((time, values))
        if given.corrected:
            write_motion(given.corrected, still, better)
        if given.velocity:
            write_motion(given.velocity, still, integrated(still, better))
        shift = displaced(time, values)[-1]
        print(f"the record ended at the velocity {words(integrated(time, values)[-1])} and the displacement {words(shift)}; "
              f"its correction is at most {words(np.abs(better - values).max(axis=0))}, of {words(np.abs(values).max(axis=0))}")
        return 0
    spectra = [response_spectrum((time, values), damping) for damping in given.damping]
    output = given.output or pathlib.Path("spectrum.png")
    if output.suffix == ".csv":
        with output.open("w", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(["damping", "period", "displacement", "velocity", "acceleration"])
            for one in spectra:
                writer.writerows([one.damping, *row] for row in zip(one.period, one.displacement, one.velocity, one.acceleration))
    else:
        first, *others = spectra
        axis = first.plot()
        for one in others:
            one.plot(axis)
        axis.figure.savefig(output, dpi=100)
    for one in spectra:
        top = one.acceleration.argmax()
        print(f"damping {one.damping:g}: pseudo acceleration at most {one.acceleration[top]:.4g}, at the period {one.period[top]:.3g}")
    return 0


def words(numbers: np.ndarray) -> str:
    """Numbers of the components in words."""
    return " ".join(f"{number:.3g}" for number in numbers)
