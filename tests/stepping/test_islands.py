"""Islands: what touches nothing of another, but for what cannot move, is as if it was alone."""
import numpy as np
import pytest

import scree
from scree import block_files

GROUND, PILE = (1, block_files.box(-30, 30, -1, 0)), 3


def pile(left, tilt=0.0):
    """Two courses of three and two bricks, the upper ones turned about their middle."""
    bricks = [block_files.box(left + i, left + i + 1, 0, 0.5) for i in range(3)]
    for i in range(2):
        corners = block_files.box(left + 0.2 + 1.5 * i, left + 1.2 + 1.5 * i, 0.5, 1.0)
        middle = corners.mean(0)
        bricks.append(middle + [0, 0.6 * abs(tilt)] + block_files.turned(corners - middle, tilt))
    return bricks


def run(folder, piles, groups=""):
    """Runs the piles on one ground that is held; those after the first have a velocity along it."""
    blocks = [GROUND] + [(2 if i == 0 else 3, corners) for i, bricks in enumerate(piles) for corners in bricks]
    folder.mkdir()
    (folder / "piles.blk").write_text(block_files.block_file("Piles", blocks, block_files.held(GROUND[1], 1)))
    deck = folder / "piles.ana"
    used = 2 if len(piles) == 1 else 3
    materials = ["2500 0 1e9 0.25 0 0 0 0 0 0 0 0 0", "2500 24525 1e9 0.25 0 0 0 0 0 0 0 0 0", "2500 24525 1e9 0.25 0 0 0 0 0 0 1.5 0 0"]
    deck.write_text("1 40 {} 1 0.05 0.005\n{}\n30 0 0\n&deck geometry='piles.blk', dialect='short' /\n{}\n".format(
        used, "\n".join(materials[:used]), groups))
    return scree.run(deck)


OPTIONS = {"small": "", "Green": "&method strain='green' /", "multipliers": "&contact method='augmented', overlap=1e-6 /",
           "conserving": "&method strain='green' / &contact rules='conserving' /", "restitution": "&contact restitution=0.3 /"}


@pytest.mark.parametrize("groups", OPTIONS.values(), ids=OPTIONS)
def test_a_pile_moves_as_if_it_was_alone(groups, tmp_path):
    """A second pile that slides changes no more of the first than what is left of round-off."""
    alone = run(tmp_path / "alone", [pile(-12.0, 0.2)], groups)
    both = run(tmp_path / "both", [pile(-12.0, 0.2), pile(5.0, 0.1)], groups)
    moved = alone.displacement()
    assert both.displacement()[:len(moved)] == pytest.approx(moved, abs=1e-13)
    assert both.history.rotation[:, :6] == pytest.approx(alone.history.rotation, abs=1e-13)
    assert np.abs(both.displacement()[len(moved):]).max() > 0.1


def test_what_is_fixed_joins_no_islands(tmp_path):
    """The systems solved are those of both piles: neither iterates for the other."""
    count = {}
    for name, piles in {"first": [pile(-12.0, 0.1)], "none": [pile(-12.0), pile(5.0)], "both": [pile(-12.0, 0.1), pile(5.0)]}.items():
        count[name] = run(tmp_path / name, piles).history.solves.sum()
    plain = run(tmp_path / "plain", [pile(-12.0)]).history.solves.sum()
    assert count["both"] == count["first"] + count["none"] - plain
    assert count["first"] > plain
