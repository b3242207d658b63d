"""Friction problems of real steps (output.problems): what a run writes of them, and that its solver gets through a kept set."""
import os
import pathlib

import h5py
import numpy as np
import pytest
import scree
from scree.bench import problems, scenes

SCREE = pathlib.Path(os.environ["SCREE"])
TOLERANCE = 1e-8  # of the largest force, as a step asks for


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Runs a small column that collapses, whose contacts run in circles, with settings; returns its results file."""
    folder = tmp_path_factory.mktemp("column")
    decks = scenes.column(16, end=0.3).write(folder, 0.005)

    def run(name, *settings):
        scree.run(*decks, output=folder / f"{name}.h5", settings=settings)
        return folder / f"{name}.h5"
    return run


def test_every_kept_problem_is_solved():
    """They are of the steps that Newton's iteration does not settle: columns, jointed rock, manifold elements, slopes with Green strain,
    among them one that only a long path solves, and one (slope of 130, phi 45) that only the path from apart does."""
    rows = problems.solve(SCREE)
    assert [row["problem"] for row in rows if row["solved"] != "yes" or row["left"] > TOLERANCE] == []
    assert len(rows) == 9
    assert max(row["matrices"] for row in rows if "slope of 130" not in row["problem"]) <= 40  # whatever the size


def test_problems_of_a_run_are_solved_alone_as_in_the_run(run):
    path = run("all", "output.problems=all")
    rows = problems.solve(SCREE, [path])
    with h5py.File(path) as file:
        found = [problem["is"][1] for problem in (file["problems"][name] for name in problems.in_order(file["problems"]))]
    assert len(found) > 5
    assert [row["solved"] == "yes" for row in rows] == [bool(solved) for solved in found]


def test_a_written_problem_is_that_of_blocks_and_contacts(run):
    """A is the inertia and stiffness of the blocks, each coupled with itself alone and definite; the forces of a contact act on two
    blocks, or on one and the fixed base, against each other: across and along they are unit forces on the displacements of each."""
    with h5py.File(run("all", "output.problems=all")) as file:
        problem = file["problems/1"]
        n = len(problem["force"])
        matrix = np.zeros((n, n))
        matrix[tuple(problem["matrix/at"][...].T - 1)] = problem["matrix/value"][...]
        row, force, law = (problem["springs"][name][...] for name in ("row", "force", "law"))
    blocks = np.arange(n) // 6
    assert n == 6 * 16
    assert not matrix[blocks[:, None] != blocks].any()
    assert np.linalg.eigvalsh(matrix / np.sqrt(np.outer(matrix.diagonal(), matrix.diagonal()))).min() > 0
    for unknown, (across, along) in zip(row, force):
        of = unknown[unknown > 0] - 1
        moves = [np.array([across[k:k + 2], along[k:k + 2]]) for k in range(0, len(of), 6)]  # of the displacement of a block
        assert len(moves) == len(set(blocks[of]))
        for move in moves:
            assert move @ move.T == pytest.approx(np.eye(2), abs=1e-12)
        if len(moves) == 2:
            assert moves[0] == pytest.approx(-moves[1], abs=1e-12)
    assert (law[:, 1] > 0).all() and (law[:, 4] == pytest.approx(0.3)) and not law[:, 5:].any()


def test_problems_are_written_where_they_are_asked_for_and_change_nothing(run):
    with h5py.File(run("none")) as none, h5py.File(run("failed", "output.problems=failed")) as failed, \
            h5py.File(run("all", "output.problems=all")) as every:
        assert "problems" in every and "problems" not in none and "problems" not in failed  # as each is solved
        for file in (failed, every):
            assert np.array_equal(none["bodies/centroid"][...], file["bodies/centroid"][...])
            assert np.array_equal(none["history/solves"][...], file["history/solves"][...])
