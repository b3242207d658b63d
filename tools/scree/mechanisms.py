"""Which blocks move at the end of a static run that does not stand, as groups, and which groups count as a mechanism."""
from __future__ import annotations

import dataclasses

import numpy as np

from .model.geometry import contains
from .results import Results

# Displacement in the last step over that of the block that the run names, from which on a block moves too. Blocks of one mechanism move
# alike; what is in equilibrium hardly moves in so late a step.
MOVES = 0.1


@dataclasses.dataclass
class Mechanism:
    """Blocks that move together: numbers from 1, area in all, centroid."""

    blocks: np.ndarray
    area: float
    centre: np.ndarray


@dataclasses.dataclass
class Sought:
    """Which mechanisms count: those with at least an area, of which more than half lies inside a polygon, where one is given."""

    least: float = 0.0
    inside: list[tuple[float, float]] | None = None

    def counts(self, results: Results, mechanism: Mechanism) -> bool:
        """Whether a mechanism is one of these. A block lies inside where its centroid lies there at the start."""
        if mechanism.area < self.least:
            return False
        if self.inside is None:
            return True
        rows = mechanism.blocks - 1
        within = [contains(self.inside, *centre) for centre in results.bodies.centroid[0][rows]]
        return 2 * results.bodies.area[0][rows][within].sum() > mechanism.area


def mechanisms_of(results: Results, block: int) -> list[Mechanism]:
    """The groups of blocks that move at the end of a run which names the block that moves most for its size, the largest group first.

    Blocks belong together where they have touched in a frame. Results need a frame for each step.
    """
    moved = results.bodies.centroid[-1] - results.bodies.centroid[-2]
    moved = np.linalg.norm(moved, axis=1)
    there = np.zeros(results.n_blocks, bool)
    there[results.block[results.present(-1)] - 1] = True
    moves = there & (moved >= MOVES * moved[block - 1])
    group = np.arange(results.n_blocks)
    pairs = np.unique(np.sort(results["contacts/blocks"], axis=1), axis=0) - 1 if "contacts" in results else np.empty((0, 2), int)
    pairs = pairs[moves[pairs].all(axis=1)]
    while len(pairs):  # each group takes the least number of its blocks
        before = group.copy()
        np.minimum.at(group, pairs[:, 0], group[pairs[:, 1]])
        np.minimum.at(group, pairs[:, 1], group[pairs[:, 0]])
        if (group == before).all():
            break
    area, centre = results.bodies.area[-1], results.bodies.centroid[-1]
    found = []
    for number in np.unique(group[moves]):
        rows = np.flatnonzero(moves & (group == number))
        found.append(Mechanism(rows + 1, float(area[rows].sum()), area[rows] @ centre[rows] / area[rows].sum()))
    return sorted(found, key=lambda one: -one.area)
