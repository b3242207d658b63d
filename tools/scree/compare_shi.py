"""Compares a run with one of Shi's programs, block by block: places, areas, stresses, contacts, and where they part.

    tools/compare_shi RUN.h5 REFERENCE [--tolerance 1e-6] [--match step | time] [--every N]
                      [--length-scale L] [--stress-scale S] [--contacts N]

REFERENCE is a classic replay (of ntdda, or of `scree run --classic-output`), or a folder of CSV files as tests/data/classic/runs
has them: steps.csv, blocks.csv, vertices.csv and, where it has measured points, points.csv. Blocks and vertices are numbered alike.

A difference exceeds the tolerance where, in a frame that both have,
  a vertex, a centroid or a measured point is off by more than TOLERANCE times the largest travel of a vertex in the reference,
  an area by more than TOLERANCE times its own,
  a component of stress by more than TOLERANCE times the largest in the reference.
--length-scale and --stress-scale replace the two largest, for references that hardly move or are free of stress.

Exit status 0 where nothing does, 1 where something does or the run ends before the reference, 2 where they cannot be compared.
Needs Debian's python3-numpy and python3-h5py.
"""
import argparse
import csv
import pathlib

import numpy as np

from .arguments import above_zero, command, ends_in_a_line, parser_for, whole_from
from .errors import ScreeError
from .results import read

SAME_TIME = 1e-9  # over the largest time: sums of steps differ by roundings
STRESS = ("sxx", "syy", "sxy")  # columns that may be empty at the start
MEASURED = 1      # type of a measured point in replays and CSV files


class CompareError(ScreeError):
    """Why they cannot be compared."""


class Frames:
    """Frames of blocks: `steps` and `times` (f), either of them None where it is not known; `vertices` (f, v, 2) or None, `first`
    (b + 1) where those of each block begin; `centroid` (f, b, 2), `area` (f, b); `stress` (f, b, 3) or None, NaN where it is not
    known; `points` (f, p, 2), the measured points, or None; `contacts`, from step to (open, closed), or None."""

    steps = times = vertices = first = stress = points = contacts = None

    def take_moments(self):
        """Centroid and area from the vertices."""
        areas, centroids = [], []
        for a, b in zip(self.first, self.first[1:]):
            origin = self.vertices[:, a:a + 1]
            own = self.vertices[:, a:b] - origin
            after = np.roll(own, -1, axis=1)
            twice = own[..., 0] * after[..., 1] - own[..., 1] * after[..., 0]
            areas.append(twice.sum(1) / 2)
            centroids.append(origin[:, 0] + np.einsum("fv,fvc->fc", twice, own + after) / (3 * twice.sum(1)[:, None]))
        self.area, self.centroid = np.stack(areas, 1), np.stack(centroids, 1)

    def travel(self):
        """Largest displacement of a vertex of each block since the start; of its centroid where there are no vertices."""
        if self.vertices is None:
            return lengths(self.centroid - self.centroid[0]).max(0)
        return np.maximum.reduceat(lengths(self.vertices - self.vertices[0]).max(0), self.first[:-1])


class Run(Frames):
    """A results file of scree. Its bodies are the blocks, or the elements where the reference has as many polygons."""

    def __init__(self, path, reference):
        r = read(path)
        if r.n_frames == 0:
            raise CompareError(f"{path}: expected frames, found none")
        self.times, self.steps = r.times, r.frame_steps
        self.area, self.centroid, self.stress = r.bodies.area, r.bodies.centroid, r.bodies.stress
        frames, elements_are_blocks = range(r.n_frames), r.n_elements == r.n_blocks
        if elements_are_blocks or (r.n_elements == len(reference.first) - 1 and reference.stress is None):
            corners = r.corners()
            self.vertices = np.stack([r.vertices(k)[np.concatenate(corners)] for k in frames])
            self.first = np.append(0, np.cumsum([len(c) for c in corners]))
        if self.vertices is not None and not elements_are_blocks:
            self.take_moments()
            self.stress = np.stack([r.stress(k) for k in frames])
        if "measured_points" in r:
            self.points = np.concatenate([r.given_points("measured")[None], r.measured_points.position])[self.steps]
        if "contacts" in r.history:
            self.contacts = {step: (a, b + c) for step, (a, b, c) in enumerate(r.history.contacts.astype(int), 1)}


class Replay(Frames):
    """A classic replay, whose layout is in doc/classic-output.md. What follows the frames that it counts is not read."""

    def __init__(self, path):
        try:
            numbers = np.array(path.read_text().split(), float)
        except (OSError, ValueError) as problem:
            raise CompareError(f"{path}: expected a replay, found: {problem}")
        if not np.isfinite(numbers).all():
            raise CompareError(f"{path}: expected numbers, found one that is not finite")
        if len(numbers) < 7 or (numbers[:7] != np.floor(numbers[:7])).any() or (numbers[:7] < 0).any():
            raise CompareError(f"{path}: expected a replay, found another text")
        n, n_blocks, n_bolts, oo = numbers[:4].astype(int)
        n_points = int(numbers[4:7].sum())
        if n_bolts:
            raise CompareError(f"{path}: expected no bolts, found {n_bolts}")
        head = 7 + 3 * (n_blocks + 1)
        size = 3 * (oo + 1) + 4 * (n_points + 1)
        if n < 1 or len(numbers) < head + n * size:
            raise CompareError(f"{path}: expected {head + n * size} numbers of {n} frames, 1 or more, found {len(numbers)}")
        _, start, end = numbers[10:head].astype(int).reshape(-1, 3).T
        if (start < 1).any() or (end < start + 2).any() or (end > oo).any():
            raise CompareError(f"{path}: expected blocks of vertex rows 1 to {oo}, found others")
        frames = numbers[head:head + n * size].reshape(n, size)
        rows = frames[:, :3 * (oo + 1)].reshape(n, -1, 3)
        self.vertices = rows[:, np.concatenate([np.arange(a, b + 1) for a, b in zip(start, end)]), 1:]
        self.first = np.concatenate([[0], np.cumsum(end - start + 1)])
        self.take_moments()
        points = frames[:, 3 * (oo + 1) + 4:].reshape(n, -1, 4)
        if n_points and (points[0, :, 0] == MEASURED).any():
            self.points = points[:, points[0, :, 0] == MEASURED, 1:3]


class Folder(Frames):
    """A folder of CSV files."""

    def __init__(self, path):
        self.path = path
        blocks = self.table("blocks", "step time block area cx cy sxx syy sxy")
        self.steps, n = self.frames(blocks)
        self.times = blocks[:, 1].reshape(-1, n)[:, 0]
        blocks = blocks[:, 3:].reshape(len(self.steps), n, -1)
        self.area, self.centroid, self.stress = blocks[..., 0], blocks[..., 1:3], blocks[..., 3:]
        vertices = self.table("vertices", "step block x y")
        steps, n_vertices = self.frames(vertices)
        if (steps.shape != self.steps.shape) or (steps != self.steps).any():
            raise CompareError(f"{path}: expected the steps of blocks.csv in vertices.csv, found others")
        self.vertices = vertices[:, 2:].reshape(len(steps), n_vertices, 2)
        block = vertices[:n_vertices, 1].astype(int)
        self.first = np.searchsorted(block, np.arange(1, n + 2))
        if (np.diff(self.first) < 3).any():
            raise CompareError(f"{path}/vertices.csv: expected three vertices or more of each of {n} blocks, found less")
        if (path / "points.csv").exists():
            points = self.table("points", "step type x y")
            points = points[points[:, 1] == MEASURED]
            if len(points):
                steps, n_points = self.frames(points)
                if (steps.shape != self.steps.shape) or (steps != self.steps).any():
                    raise CompareError(f"{path}: expected the steps of blocks.csv in points.csv, found others")
                self.points = points[:, 2:].reshape(len(steps), n_points, 2)
        self.contacts = {int(step): (int(n - closed), int(closed))
                         for step, n, closed in self.table("steps", "step ncontacts nclosed") if step > 0}

    def table(self, name, columns):
        """Columns of a CSV file; NaN where stress is not known at the start."""
        path, columns = self.path / f"{name}.csv", columns.split()
        try:
            with path.open(newline="") as f:
                lines = csv.DictReader(f)
                found = lines.fieldnames or []
                if not set(columns) <= set(found):
                    raise CompareError(f"{path}: expected the columns {' '.join(columns)}, found {' '.join(found)}")
                rows = [[float(line[c] or "nan") for c in columns] for line in lines]
        except (OSError, ValueError, TypeError) as problem:
            raise CompareError(f"{path}: expected a table of numbers, found: {problem}")
        if not rows:
            raise CompareError(f"{path}: expected rows, found none")
        rows = np.array(rows)
        known = np.isfinite(rows) | (rows[:, :1] == 0) & np.isin(columns, STRESS)
        if not known.all():
            raise CompareError(f"{path}: expected finite numbers, found none in row {np.argmin(known.all(1)) + 1} after the head")
        return rows

    def frames(self, rows):
        """Steps of a table, and its rows a step."""
        steps, counts = np.unique(rows[:, 0], return_counts=True)
        if (counts != counts[0]).any() or (np.diff(rows[:, 0]) < 0).any():
            raise CompareError(f"{self.path}: expected as many rows of each step, in order of steps, found others")
        return steps.astype(int), int(counts[0])


def lengths(vectors):
    return np.hypot(vectors[..., 0], vectors[..., 1])


def nearest(ascending, values):
    """Where what is nearest to each value lies in numbers that ascend."""
    after = np.searchsorted(ascending, values)
    before, after = np.maximum(after - 1, 0), np.minimum(after, len(ascending) - 1)
    return np.where(values - ascending[before] <= ascending[after] - values, before, after)


def match(run, reference, given):
    """Frames that both have: those of the run, those of the reference; and whether the run ends before the reference."""
    if given.match == "time":
        if reference.times is None:
            raise CompareError(f"{given.reference}: expected times for --match time, found a replay, which has none")
        near = nearest(run.times, reference.times)
        allowed = SAME_TIME * max(run.times[-1], reference.times[-1])
        of_reference = np.flatnonzero(np.abs(run.times[near] - reference.times) <= allowed)
        return near[of_reference], of_reference, run.times[-1] < reference.times[-1] - allowed
    if reference.steps is None and given.every is None:
        n = min(len(run.steps), len(reference.vertices))
        return np.arange(n), np.arange(n), len(run.steps) < len(reference.vertices)
    if reference.steps is None:
        reference.steps = given.every * np.arange(len(reference.vertices))
    _, of_run, of_reference = np.intersect1d(run.steps, reference.steps, return_indices=True)
    return of_run, of_reference, run.steps[-1] < reference.steps[-1]


def check_shapes(run, reference, given):
    """The same blocks, with as many vertices."""
    a, b = run.area.shape[1], reference.area.shape[1]
    if a != b:
        raise CompareError(f"{given.reference}: expected {a} blocks as {given.run} has, found {b}")
    if run.vertices is None:
        return
    for k, (n, m) in enumerate(zip(np.diff(run.first), np.diff(reference.first)), 1):
        if n != m:
            raise CompareError(f"{given.reference}: expected {n} vertices of block {k} as {given.run} has, found {m}")


def over(difference, scale):
    return f"{difference / scale:9.2e}" if scale > 0 else f"{'-':>9}"


def first_excess(excesses, run, of_run):
    """Where and in what the first difference lies that is more than allowed: excesses is name -> (f) true or false."""
    begins = min((int(np.argmax(excess)) for excess in excesses.values() if excess.any()), default=None)
    if begins is None:
        return "-"
    frame = of_run[begins]
    return f"step {run.steps[frame]}, time {run.times[frame]:.6g}: {', '.join(k for k, e in excesses.items() if e[begins])}"


def compare_contacts(run, reference, most):
    """Prints how the numbers of contacts differ; returns whether those of closed ones do by more than `most`."""
    for frames, name in ((run, "the run"), (reference, "the reference")):
        if frames.contacts is None:
            print(f"contacts: {name} has none to compare")
            return False
    steps = sorted(set(run.contacts) & set(reference.contacts))
    if not steps:
        print("contacts: no step that both have")
        return False
    for i, kind in enumerate(("open", "closed")):
        off = np.array([run.contacts[step][i] - reference.contacts[step][i] for step in steps])
        text = f"contacts: {kind} differ at {np.count_nonzero(off)} of {len(steps)} steps"
        if off.any():
            begin, worst = steps[np.argmax(off != 0)], steps[np.argmax(np.abs(off))]
            text += (f", first at step {begin}; most at step {worst}: {run.contacts[worst][i]} in the run, "
                     f"{reference.contacts[worst][i]} in the reference")
        print(text)
    return most is not None and np.abs(off).max() > most


def compare(run, reference, given):
    """Prints the table; returns whether something is out of tolerance."""
    check_shapes(run, reference, given)
    of_run, of_reference, ends_early = match(run, reference, given)
    if not (run.times[of_run] > 0).any():
        raise CompareError(f"{given.run}: expected frames of the reference beyond the start, found none: "
                           "run it with --set output.every=1, or choose --match or --every")
    travel = reference.travel()
    length = given.length_scale or travel.max()
    stress_known = reference.stress is not None
    largest = np.nan_to_num(np.abs(reference.stress)).max((0, 2)) if stress_known else np.zeros(len(travel))
    stress_scale = given.stress_scale or largest.max()
    centroid = lengths(run.centroid[of_run] - reference.centroid[of_reference])
    vertex = np.zeros_like(centroid)
    if run.vertices is not None:
        off = lengths(run.vertices[of_run] - reference.vertices[of_reference])
        vertex = np.maximum.reduceat(off, reference.first[:-1], axis=1)
    place = np.maximum(centroid, vertex)
    area = np.abs(run.area[of_run] / reference.area[of_reference] - 1)
    stress = np.zeros_like(area)
    if stress_known:
        stress = np.nan_to_num(np.abs(run.stress[of_run] - reference.stress[of_reference])).max(2)

    of_stress = f", of stress {stress_scale:.6g}" if stress_known else "; no stress to compare"
    print(f"{len(of_run)} of {len(reference.area)} frames of the reference, to step {run.steps[of_run[-1]]}; tolerance "
          f"{given.tolerance:g} of length {length:.6g}{of_stress}")
    if reference.times is not None:
        print(f"times differ by at most {np.abs(run.times[of_run] - reference.times[of_reference]).max():.2e}")
    if run.vertices is None:
        print("blocks of more than one element: centroids alone, no vertices")
    columns = ("centroid", "vertex", "/travel", "area", "stress", "/largest")
    print("block" + "".join(f"  {name:>9}" for name in columns) + "  exceeds the tolerance from")
    failed = False
    for b in range(len(travel)):
        begins = first_excess({"place": place[:, b] > given.tolerance * length, "area": area[:, b] > given.tolerance,
                               "stress": stress[:, b] > given.tolerance * stress_scale}, run, of_run)
        failed |= begins != "-"
        print(f"{b + 1:5}  {centroid[:, b].max():9.2e}  {vertex[:, b].max():9.2e}  {over(place[:, b].max(), travel[b])}  "
              f"{area[:, b].max():9.2e}  {stress[:, b].max():9.2e}  {over(stress[:, b].max(), largest[b])}  {begins}")
    n_points = [0 if frames.points is None else frames.points.shape[1] for frames in (run, reference)]
    if n_points[0] != n_points[1]:
        print(f"measured points: {n_points[0]} in the run, {n_points[1]} in the reference: not compared")
    elif n_points[0]:
        off = lengths(run.points[of_run] - reference.points[of_reference]).max(1)
        begins = first_excess({"place": off > given.tolerance * length}, run, of_run)
        failed |= begins != "-"
        print(f"measured points: {off.max():.2e}, exceeds the tolerance from {begins}")
    failed |= compare_contacts(run, reference, given.contacts)
    if ends_early:
        print("the run ends before the reference")
    return failed or ends_early


class Parser(argparse.ArgumentParser):
    def error(self, message):
        self.exit(2, f"{command()}: {message}\n")


@ends_in_a_line
def main():
    parser = parser_for(__doc__, Parser)
    parser.add_argument("run", type=pathlib.Path, metavar="RUN", help="a results file of scree")
    parser.add_argument("reference", type=pathlib.Path, metavar="REFERENCE", help="a replay, or a folder of CSV files")
    parser.add_argument("--tolerance", type=above_zero, default=1e-6, help="share of the scales; 1e-6 without it")
    parser.add_argument("--match", choices=["step", "time"], default="step", help="what frames have in common")
    parser.add_argument("--every", type=whole_from(1), metavar="N",
                        help="steps between the frames of a replay; without it they are those of the run")
    parser.add_argument("--length-scale", type=above_zero, help="in place of the largest travel")
    parser.add_argument("--stress-scale", type=above_zero, help="in place of the largest stress")
    parser.add_argument("--contacts", type=whole_from(0), metavar="N",
                        help="largest difference in the number of closed contacts; else not judged")
    given = parser.parse_args()
    reference = Folder(given.reference) if given.reference.is_dir() else Replay(given.reference)
    return int(compare(Run(given.run, reference), reference, given))
