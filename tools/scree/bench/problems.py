"""Friction problems of steps (`output.problems`), solved again by the solver of scree alone."""
import os
import pathlib
import subprocess
import tempfile

import h5py
import numpy as np

from ..errors import ScreeError, reason_of
from ..program import BUILT, TREE
from ..results import opened
from .factorisation import ONE_THREAD
from .tables import Table

KEPT = TREE / "tests" / "data" / "friction_problems.h5"

COLUMNS = [("problem", "problem", "s", -28), ("unknowns", "unknowns", "d", 8), ("springs", "springs", "d", 7),
           ("solved", "solved", "s", 6), ("left", "left", ".0e", 6), ("matrices", "matrices", "d", 8), ("pieces", "pieces", "d", 6),
           ("s", "s", ".4f", 8)]


def bytes_of(problem):
    """A group of /problems as bench_problems reads it."""
    near, _, symmetric_matrix, symmetric_springs = problem["is"][...]
    at, springs = problem["matrix/at"][...], problem["springs"]
    row, force = springs["row"][...], springs["force"][...]
    change = springs["change"][...] if "change" in springs else force
    head = [len(problem["force"]), len(at), *row.shape, near, symmetric_matrix, symmetric_springs]
    parts = [(head, np.int32), (at, np.int32), (problem["matrix/value"], float), (problem["force"], float),
             (problem["span"], float), (springs["law"], float), (row, np.int32),
             *((rows[:, k], float) for rows in (force, change) for k in (0, 1))]
    return b"".join(np.asarray(numbers, kind).tobytes() for numbers, kind in parts)


def in_order(group):
    """Names of the problems of a file."""
    return sorted(group, key=lambda name: (len(name), name))


def bench_problems(scree):
    """The program that solves them: the one beside scree, else that of the build folder."""
    found = next((path for folder in (scree.parent, BUILT.parent) if (path := folder / "bench_problems").exists()), None)
    if not found:
        raise ScreeError("expected the program bench_problems beside scree, found none: build scree from its sources")
    return found


def solve(scree, files=(KEPT,)):
    """What it took to solve each problem of results files: a dictionary with the keys of COLUMNS."""
    rows, sent = [], []
    for path in map(pathlib.Path, files):
        try:
            file = opened(path)
        except OSError as problem:
            raise ScreeError(f"{path}: expected a results file, found: {reason_of(problem)}") from None
        with file:
            if "problems" not in file:
                raise ScreeError(f"{path}: expected friction problems (output.problems='all'), found none")
            for name in in_order(file["problems"]):
                problem = file["problems"][name]
                rows.append((f"{path.stem} {name}", len(problem["force"]), len(problem["springs/law"])))
                sent.append(bytes_of(problem))
    with tempfile.TemporaryFile() as file:  # a pipe may give a Fortran read less than it asks for
        file.write(b"".join(sent))
        file.seek(0)
        done = subprocess.run([bench_problems(scree)], stdin=file, capture_output=True, env={**os.environ, **ONE_THREAD})
    if done.returncode:
        raise ScreeError(done.stderr.decode().strip() or "bench_problems failed")
    answers = (line.split() for line in done.stdout.decode().splitlines())
    return [dict(zip((key for _, key, _, _ in COLUMNS),
                     (*row, "yes" if solved == "1" else "no", float(left), int(matrices), int(pieces), float(s)), strict=True))
            for row, (solved, left, matrices, pieces, s) in zip(rows, answers, strict=True)]


def problems(given, folder):
    table = Table(COLUMNS)
    rows = solve(given.scree, given.files)
    for row in rows:
        table.add(row)
    print(f"{sum(row['solved'] == 'yes' for row in rows)} of {len(rows)} solved, {sum(row['matrices'] for row in rows)} matrices, "
          f"{sum(row['pieces'] for row in rows)} pieces, {sum(row['s'] for row in rows):.3f} s")
    if given.json:
        table.write(given.json, case="problems")
