"""Blocks with many holes: the block file holds each block as one polygon, and gives its outline and holes back."""
import collections
import random

import pytest
import scree
from joint_maps import closed, geometry_deck, make_map

SHARE = 1e-12  # of the area of all blocks: some thousand roundings of coordinates


def cut(name, folder):
    """What `scree cut` makes of a file: a row (corners, holes, area) of each block, and the block file."""
    done = scree.call("cut", name, "-o", name + ".blk", cwd=folder, timeout=60)
    assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines() if line.split()[0].isdigit() and "blocks" not in line]
    numbers = (folder / (name + ".blk")).read_text().split()
    n, n_rows = int(numbers[0]), int(numbers[2])
    edges = [(int(numbers[k]), *map(float, numbers[k + 1:k + 3])) for k in range(6 + 3 * n, 6 + 3 * (n + n_rows), 3)]
    spans = [(int(numbers[7 + 3 * b]), int(numbers[8 + 3 * b])) for b in range(n)]
    return [(int(r[2]), int(r[3]), float(r[4])) for r in rows], [edges[first - 1:last] for first, last in spans]


def squares(n):
    """Squares of side 1 in rows and columns, 2 apart, and the square around all of them."""
    loops = [closed([(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]) for x in range(1, 2 * n, 2) for y in range(1, 2 * n, 2)]
    return [line for loop in [closed([(0, 0), (2 * n + 1, 0), (2 * n + 1, 2 * n + 1), (0, 2 * n + 1)]), *loops] for line in loop]


def traces(n, seed):
    """n wavy traces, one in an area of 150: most blocks are islands in one. The lengths are of a survey in metres."""
    rnd = random.Random(seed)
    side = (150 * n) ** 0.5
    lines = closed([(0, 0), (side, 0), (side, side), (0, side)])
    for _ in range(n):
        x, y, slope = rnd.uniform(0, side), rnd.uniform(0, side), rnd.gauss(0, 0.3)
        upright = rnd.random() < 0.5
        places = [(3 * k, 3 * k * slope + rnd.gauss(0, 0.1)) for k in range(8)]
        places = [(x + b, y + a) if upright else (x + a, y + b) for a, b in places]
        lines += [p + q for p, q in zip(places, places[1:])]
    return lines


def cells_that_touch(n, seed):
    """Cells of a board whose sides are lines: many are holes that touch at corners, some close others in."""
    rnd = random.Random(seed)
    turned = seed % 2
    lines = []
    for x in range(n):
        for y in range(n):
            if (x + y) % 2 and rnd.random() < 0.6:
                corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)]
                lines += closed([(a - b, a + b) if turned else (a, b) for a, b in corners])
    corners = [(-1, -1), (n + 1, -1), (n + 1, n + 1), (-1, n + 1)]
    if seed % 3:  # the holes touch the outline, too
        corners = [(0, 0), (n, 0), (n, n), (0, n)]
    return lines + closed([(a - b, a + b) if turned else (a, b) for a, b in corners])


MAPS = {f"{make.__name__}-{seed}": (make, (n, seed), 0) for make, n in ((traces, 150), (cells_that_touch, 9)) for seed in range(8)}
# maps near the origin, upright, without edges so short that a block file may not have them
MAPS |= {f"joints-{seed}": (lambda seed: make_map(seed)[0], (seed,), 0.003) for seed in range(0, 80, 4)}
MAPS["squares"] = (squares, (6,), 0)


@pytest.mark.parametrize("name", MAPS)
def test_outlines_and_holes_come_back_from_the_polygons_of_a_block_file(name, tmp_path):
    make, numbers, e0 = MAPS[name]
    (tmp_path / "map.geo").write_text(geometry_deck(make(*numbers), e0))
    blocks, polygons = cut("map.geo", tmp_path)
    again, _ = cut("map.geo.blk", tmp_path)
    assert [row[:2] for row in again] == [row[:2] for row in blocks]
    whole = sum(area for *_, area in blocks)
    for (corners, holes, area), (_, _, read), polygon in zip(blocks, again, polygons):
        assert abs(read - area) <= SHARE * whole
        assert len(polygon) == corners + 2 * holes
        x, y = [c[1] - polygon[0][1] for c in polygon], [c[2] - polygon[0][2] for c in polygon]
        assert abs(sum(x[k - 1] * y[k] - x[k] * y[k - 1] for k in range(len(polygon))) / 2 - area) <= SHARE * whole
        # the joint material of a row is that of the edge that ends there; a seam has none, and is run through both ways
        seams = collections.Counter((polygon[k - 1][1:], polygon[k][1:]) for k in range(len(polygon)) if polygon[k][0] == 0)
        assert sum(seams.values()) == 2 * holes and all(seams[b, a] == n for (a, b), n in seams.items())


def test_a_block_of_ten_thousand_holes_is_written_and_read(tmp_path):
    """The program that held each hole against all others would take an hour."""
    n = 100
    (tmp_path / "map.geo").write_text(geometry_deck(squares(n), 0))
    for name in ("map.geo", "map.geo.blk"):
        blocks, _ = cut(name, tmp_path)
        assert len(blocks) == 1 + n * n
        assert (4 + 4 * n * n, n * n, (2 * n + 1) ** 2 - n * n) in blocks
