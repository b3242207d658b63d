"""Overlap of convex polygons, by which scree and other programs are compared."""
import math

import numpy as np
import pytest
from scree.block_files import box, turned
from scree.polygons import boxes_that_meet, deepest_overlap
from shapely.geometry import Polygon

SQUARE = box(0, 1, 0, 1)
ANGLES = np.linspace(0, 6, 13)


@pytest.mark.parametrize("edge", [1e-3, 1, 1e3])
@pytest.mark.parametrize("depth", [1e-6, 0.01, 0.3, 0.5])
def test_squares_overlap_by_the_depth_one_sank_into_the_other(edge, depth):
    """However they are turned; aligned, so that corners lie on the lines of sides. 1e-14 is their rounding."""
    for angle in ANGLES:
        pair = [edge * turned(corners, angle) for corners in (SQUARE, SQUARE + [0, 1 - depth])]
        for polygons in (pair, pair[::-1]):
            assert deepest_overlap(polygons) == pytest.approx(edge * depth, abs=1e-14 * edge)


def test_a_corner_in_a_side_overlaps_by_its_depth():
    """A square on its corner, by d in another; the least way across its own edges is half its side."""
    diamond = turned(SQUARE - 0.5, math.pi / 4) + [0.5, 1 + math.sqrt(0.5)]
    for depth in (0.001, 0.1, 0.4):
        for angle in ANGLES:
            assert deepest_overlap([turned(SQUARE, angle), turned(diamond - [0, depth], angle)]) == pytest.approx(depth, abs=1e-14)


def test_a_square_within_another_leaves_by_the_nearest_side():
    assert deepest_overlap([SQUARE, 0.2 * SQUARE + [0.1, 0.5]]) == pytest.approx(0.3, abs=1e-15)


def test_what_touches_or_is_apart_does_not_overlap():
    assert deepest_overlap([SQUARE, SQUARE + [1, 0], SQUARE + [0, 1], SQUARE + [1, 1], SQUARE + [3, 3]]) == 0
    assert deepest_overlap([SQUARE, SQUARE + [5, 5]]) == 0


def test_the_deepest_of_many_counts_whatever_their_number_of_corners():
    triangle = np.array([(0, 0), (1, 0), (0, 1)]) + [0.9, 5]
    assert deepest_overlap([SQUARE, SQUARE + [0.95, 0], triangle, SQUARE + [0, 5]]) == pytest.approx(0.1, abs=1e-15)


def convex(random, n):
    """A polygon with corners on a circle, counter-clockwise, somewhere."""
    angle = np.sort(random.uniform(0, 2 * np.pi, n))
    return np.column_stack([np.cos(angle), np.sin(angle)]) * random.uniform(0.2, 1) + random.uniform(-1, 1, 2)


def test_it_is_the_least_way_that_parts_two_polygons():
    """By GEOS: a way of that length across some edge parts them, and no shorter one in any of many directions."""
    random, seen = np.random.default_rng(3), 0
    while seen < 60:
        p, q = convex(random, random.integers(3, 7)), convex(random, random.integers(3, 7))
        depth, common = deepest_overlap([p, q]), Polygon(p).intersection(Polygon(q)).area
        assert (depth > 0) == (common > 0)
        if common < 1e-6:
            continue
        seen += 1
        angles = np.linspace(0, 2 * np.pi, 73)
        for direction in np.column_stack([np.cos(angles), np.sin(angles)]):
            assert Polygon(p).intersection(Polygon(q + 0.999 * depth * direction)).area > 0
        edges = np.concatenate([np.roll(p, -1, axis=0) - p, np.roll(q, -1, axis=0) - q])
        outward = np.column_stack([edges[:, 1], -edges[:, 0]]) / np.linalg.norm(edges, axis=1)[:, None]
        ways = 1.000001 * depth * np.concatenate([outward, -outward])
        assert min(Polygon(p).intersection(Polygon(q + way)).area for way in ways) == 0


def test_boxes_that_meet_are_those_of_all_pairs():
    random = np.random.default_rng(1)
    low = random.integers(0, 12, (60, 2)).astype(float)  # whole numbers, so that many just touch
    high = low + random.integers(1, 4, (60, 2))
    found = {tuple(sorted(pair)) for pair in boxes_that_meet(low, high).tolist()}
    assert len(found) == len(boxes_that_meet(low, high))
    assert found == {(a, b) for a in range(60) for b in range(a + 1, 60) if (low[a] <= high[b]).all() and (low[b] <= high[a]).all()}
