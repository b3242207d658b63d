"""Steps are as long as they were asked for: contacts that run in circles are settled, not cut."""
import numpy as np
import pytest

import scree
from scree import block_files, touching
from scree.bench import scenes

# Random rock under sudden gravity, 5 ms. In the first case the way through the interior ends at a fold; in the third, of Green
# strain, at several; in the last the lines of corners never settle.
ROCK = [("dda", 0), ("dda", 2), ("dda, Green strain", 2), ("nmm", 0)]


def keeps_its_steps(results, count):
    history = results.history
    scale = np.abs(history.energy.gravity).max()
    assert len(history.time) == count and history.rejected.sum() == 0
    assert np.diff(history.energy.dissipated, prepend=0.0).min() > -1e-9 * scale


@pytest.mark.parametrize("kind,seed", ROCK)
def test_random_rock_takes_the_steps_asked_for(kind, seed, tmp_path):
    keeps_its_steps(scree.run(touching.jointed_rock(tmp_path, kind, seed, 20)), 20)


@pytest.mark.parametrize("strain", ["small", "green"])
@pytest.mark.parametrize("stiffness", [5, 50])
def test_a_column_of_small_blocks_takes_the_steps_asked_for(strain, stiffness, tmp_path):
    """5 x 8 blocks of 5 cm on a base turned by 25 degrees, mu 0.3: at 5 ms contacts are 1e5 times as stiff as the blocks are heavy."""
    angle, edge = np.radians(-25), 0.05
    blocks = [(1, block_files.turned(block_files.box(-2, 2, -1, 0), angle))]
    blocks += [(2, block_files.turned(block_files.box(x * edge, (x + 1) * edge, y * edge, (y + 1) * edge), angle))
               for x in range(5) for y in range(8)]
    (tmp_path / "column.blk").write_text(block_files.block_file("Column", blocks, block_files.held(blocks[0][1], 1)))
    deck = tmp_path / "column.ana"
    deck.write_text(f"1 20 2 1 0.05 0.005\n{'2500 0 1e10 0.25 '}{'0 0 0 ' * 3}\n{'2500 24525 1e10 0.25 '}{'0 0 0 ' * 3}\n16.7 0 0\n"
                    f"&deck geometry='column.blk', dialect='short' /\n&method strain='{strain}' /\n"
                    f"&contact stiffness={stiffness}e10 /\n")
    keeps_its_steps(scree.run(deck), 20)


@pytest.mark.parametrize("strain", ["auto", "green"])
def test_a_column_that_breaks_up_under_green_strain_takes_the_steps_asked_for(strain, tmp_path):
    """Blocks of 5 cm that turn under pressure: the tangent of some is not definite, and a friction problem without a solution."""
    decks = scenes.column(16, end=0.5).write(tmp_path, 0.005)
    keeps_its_steps(scree.run(*decks, output=tmp_path / "column.h5", settings=[f"method.strain={strain}"]), 100)
