"""Random pairs of blocks that are pushed together do not pass into each other without a contact.

A deck holds a hundred pairs. GEOS gives the common area of each pair after every step."""
import os

import numpy as np
import pytest
import random_pairs

DECKS = int(os.environ.get("SCREE_DECKS", "10"))
OF_A_DECK = 100


def test_the_judge_knows_how_deep_blocks_overlap():
    """Two squares by their faces, a corner in a face, two corners, and bars that cross, of which no vertex lies in the other."""
    a = random_pairs.box(0, 1, 0, 1)
    corner = (a @ random_pairs.turn(np.pi / 4).T) * 2**0.5
    for b, expected in ((a + [0.2, 0.9], 0.1), (a + [0.7, 0.9], 0.1), (corner + [0.5, 0.75], 0.25), (a + [2, 0], 0.0),
                        (random_pairs.box(0.4, 0.7, -1, 2), 0.3)):
        assert random_pairs.depth(a, b) == pytest.approx(expected, rel=1e-12)
        assert random_pairs.depth(b, a) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("deck", range(DECKS))
def test_pairs_that_overlap_have_a_contact(deck, tmp_path):
    """The pairs meet edge to edge, corner to edge, corner to corner and in hollow corners. No pair overlaps by more than 1e-6 of its smaller
    block without a closed contact. (Of 10 000 pairs, SCREE_DECKS=100, one does so for one step, by 1.2e-6.)"""
    random = np.random.default_rng(deck)
    pairs = [random_pairs.drawn(random) for _ in range(OF_A_DECK)]
    r = random_pairs.run(tmp_path, pairs)
    assert len(set((r["contacts/blocks"][:, 0] - 1) // 2)) > 0.85 * OF_A_DECK
    worst = random_pairs.without_contact(r, pairs)
    assert worst.max() < 1e-6, f"pairs {np.flatnonzero(worst >= 1e-6)} overlap without a contact"


@pytest.mark.parametrize("deck", range(DECKS))
def test_a_common_area_is_no_deeper_than_its_springs_are_pressed(deck, tmp_path):
    """To 2e-6 of the smaller block: faces that slide onto each other as two corners pass bear at both ends of what they have in common.
    (Of 10 000 pairs, SCREE_DECKS=100, 36 are deeper by more than 1e-6, and 6 by more than 1e-4.)"""
    random = np.random.default_rng(deck)
    pairs = [random_pairs.drawn(random) for _ in range(OF_A_DECK)]
    r = random_pairs.run(tmp_path, pairs)
    worst = random_pairs.unborne(r, pairs).max(1)
    assert worst.max() < 2e-6, f"pairs {np.flatnonzero(worst >= 2e-6)}, by {worst[worst >= 2e-6]}"


@pytest.mark.parametrize("deck", range(DECKS // 5))
def test_thin_bodies_do_not_cross_like_swords(deck, tmp_path):
    """If nothing held them, three of five such pairs would cross with no vertex of one body in the other. The common area of a pair is no
    deeper than its springs are pressed, to 1e-6 of the smaller body."""
    random = np.random.default_rng(deck)
    pairs = [random_pairs.swords(random) for _ in range(OF_A_DECK)]
    r = random_pairs.run(tmp_path, pairs)
    worst = random_pairs.unborne(r, pairs).max(1)
    assert worst.max() < 1e-6, f"pairs {np.flatnonzero(worst >= 1e-6)} overlap by more than their springs bear"


def test_a_pair_moves_beside_others_as_it_does_alone(tmp_path):
    """To 1e-9 of the displacement: no other pair touches it, and how far the search looks around a block is told by that block alone."""
    random = np.random.default_rng(77)
    pairs = [random_pairs.drawn(random) for _ in range(40)]
    places = random_pairs.lattice(pairs)
    small = "&method strain='small' /"
    together = random_pairs.run(tmp_path, pairs, groups=[small]).bodies.centroid
    off = []
    for k, pair in enumerate(pairs):
        alone = random_pairs.run(tmp_path, [pair], places[k:k + 1], groups=[small], name="alone").bodies.centroid
        way = alone - alone[0]
        beside = together[:, 2 * k:2 * k + 2] - together[0, 2 * k:2 * k + 2]
        off.append(np.abs(way - beside).max() / np.abs(way).max())
    assert max(off) < 1e-9, f"pairs {np.flatnonzero(np.array(off) >= 1e-9)} of 40, by up to {max(off)} of the displacement"
