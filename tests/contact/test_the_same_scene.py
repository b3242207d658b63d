"""One scene told in two ways: blocks in another order, turned by 37 degrees, in a mirror, with coordinates that rounding has moved.

The decks are those of random scenes, taken apart until little was left of each. What hung on an order, an axis or the last bit
showed in one early step, by 1e-7 to 0.4 of the way that blocks had gone."""
import numpy as np
import pytest
import scree
from scree.program import TREE

DECKS = TREE / "tests" / "data" / "same"


def ways(deck, folder):
    """How far each block went, at all times, the nearest first."""
    places = scree.run(deck, output=folder / f"{deck.stem}.h5").bodies.centroid
    return np.sort(np.linalg.norm(places - places[0], axis=2), axis=1)


@pytest.mark.parametrize("name", [
    "blow",      # in a mirror: what closes as fast as its load makes it in a step is no blow, in neither
    "crossing",  # of two joints: tips of two triangles, bonded over 1e-15 of a common edge, pressed where they were apart
    "order",     # of blocks: how far contacts were looked for went on from vertex to vertex along a list
    "rounding",  # of a gap at the start: what parted had its anchor at the end of its way with 1e-15, at the beginning with 0
    "rub",       # at the start, in a mirror: what rounding leaves across of a motion along an edge is no approach
    "strength",  # of a joint, none in the other: rules that only press have no bonds of it
    "turned"])   # whether an element was off by its small strain was told by components
def test_a_scene_is_the_same_however_it_is_told(name, tmp_path):
    one, other = (ways(DECKS / f"{name}_{which}.ana", tmp_path) for which in "ab")
    assert np.abs(one - other).max() < 1e-9 * one.max()
