"""One factorisation by CHOLMOD of a matrix with the pattern of a run: what the time of a run is held against.

The matrix is that of all blocks, or manifold elements, each coupled with those of other blocks that it touches at the start,
without the unknowns that fixed points take. `bench_factor`, which is built beside scree with the same libraries, times it; what a
Cholesky factor costs depends on the pattern alone.
"""
import dataclasses
import os
import subprocess

import numpy as np

from ..errors import ScreeError
from ..polygons import boxes_that_meet
from ..program import BUILT

HELD_WHOLLY = 3  # fixed points not on a line leave an element no unknown, each of fewer takes two
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_THREAD_LIMIT": "1"}  # four of CHOLMOD wait for each other longer than they work
TOUCHING = 1e-6  # of the size of the scene: as far apart are outlines that touch


@dataclasses.dataclass
class Factorisation:
    """Unknowns, entries of the lower triangle and of the factor; processor seconds of analysis, factorisation and a solution."""

    unknowns: int
    entries: int
    factor_entries: int
    analysis: float
    seconds: float
    solution: float


def unknowns_of_elements(r):
    """The unknowns of each element, lists of numbers from 0 that elements may share, and how many there are."""
    fixed = np.zeros(r.n_elements, int)
    if "points" in r:
        np.add.at(fixed, r.points.element[r.points.kind == 1] - 1, 1)
    if "covers" not in r:
        free = np.where(fixed >= HELD_WHOLLY, 0, 6 - 2 * np.minimum(fixed, HELD_WHOLLY))
        last = np.cumsum(free)
        return [np.arange(end - n, end) for end, n in zip(last, free)], int(last[-1])
    masters = {cover: others for cover, *others in r.covers.follows.tolist()} if "follows" in r.covers else {}
    of_element = [sorted({m for cover in covers for m in masters.get(cover, [cover])}) for covers in r.covers.of_element.tolist()]
    held = {cover for covers, n in zip(of_element, fixed) if n >= HELD_WHOLLY for cover in covers}
    number = {cover: i for i, cover in enumerate(sorted({c for covers in of_element for c in covers} - held))}
    unknowns = [np.array([2 * number[c] + k for c in covers if c in number for k in (0, 1)], int) for covers in of_element]
    return unknowns, 2 * len(number)


def gap_of_outlines(p, q):
    """Least distance of a corner of one polygon from the outline of the other: how far two that do not overlap are apart."""
    def from_corners(corners, polygon):
        side = np.roll(polygon, -1, axis=0) - polygon
        to = corners[:, None] - polygon
        share = np.clip((to * side).sum(2) / np.maximum((side**2).sum(1), np.finfo(float).tiny), 0, 1)
        return np.linalg.norm(to - share[..., None] * side, axis=2).min()
    return min(from_corners(p, q), from_corners(q, p))


def touching_elements(r):
    """Pairs of elements (n, 2) of different blocks, from 0, that touch at the start."""
    polygons = r.polygons(0)
    low, high = (np.array([bound(polygon, axis=0) for polygon in polygons]) for bound in (np.min, np.max))
    near = TOUCHING * np.ptp(np.concatenate([low, high]), axis=0).max()
    pairs = boxes_that_meet(low - near, high + near)
    pairs = pairs[r.block[pairs[:, 0]] != r.block[pairs[:, 1]]]
    return pairs[[gap_of_outlines(polygons[a], polygons[b]) <= near for a, b in pairs]]


def pattern(cliques, n):
    """The lower triangle in compressed columns, of a matrix of `n` unknowns each of whose cliques is coupled with itself.

    First entry of each column (n + 1) and rows (entries), ascending, the diagonal always among them.
    """
    codes = [np.arange(n, dtype=np.int64) * (n + 1)]
    for clique in cliques:
        row, column = np.meshgrid(clique, clique, indexing="ij")
        low = row >= column
        codes.append(column[low].astype(np.int64) * n + row[low])
    column, row = np.divmod(np.unique(np.concatenate(codes)), n)
    return np.searchsorted(column, np.arange(n + 1)).astype(np.int32), row.astype(np.int32)


def pattern_of_run(r):
    """The lower triangle of the matrix of a run, as `pattern` gives it."""
    unknowns, n = unknowns_of_elements(r)
    return pattern([*unknowns, *(np.concatenate([unknowns[a], unknowns[b]]) for a, b in touching_elements(r))], n)


def bench_factor(scree):
    """The program that is timed: the one beside scree, else that of the build folder; None where neither is built."""
    return next((path for folder in (scree.parent, BUILT.parent) if (path := folder / "bench_factor").exists()), None)


def factorise(program, first, row):
    """What CHOLMOD takes for a matrix of a pattern, on one thread."""
    n = len(first) - 1
    data = np.array([n, len(row)], np.int64).tobytes() + first.tobytes() + row.tobytes()
    done = subprocess.run([program], input=data, capture_output=True, env={**os.environ, **ONE_THREAD})
    if done.returncode:
        raise ScreeError(done.stderr.decode().strip() or f"{program} failed")
    counts, seconds = done.stdout.split()[:3], done.stdout.split()[3:]
    return Factorisation(*map(int, counts), *map(float, seconds))
