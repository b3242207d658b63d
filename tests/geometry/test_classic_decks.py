"""`scree cut` against the blocks that a derivative of Shi's cutter makes of the same decks (tests/data/classic)."""
import collections
import csv
import os
import pathlib

import pytest
import scree

DATA = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tests" / "data" / "classic"
DECKS = sorted(path.stem for path in DATA.glob("*.geo"))
SAME = [name for name in DECKS if name != "hole"]
DIGITS = 1e-13  # half a unit of the last of the 15 digits written, for coordinates up to 20, and a rounding of the crossing

Block = collections.namedtuple("Block", "material joints vertices area")


def cut(deck, out):
    """Blocks and points (x, y, block) of the block file, and what the program prints."""
    done = scree.call("cut", deck, "-o", out)
    assert done.returncode == 0, done.stderr
    lines = [line.split() for line in out.read_text().splitlines()]
    n, bolts, n_rows = map(int, lines[0])
    assert bolts == 0
    heads = [tuple(map(int, line)) for line in lines[2:2 + n]]
    rows = [tuple(map(float, line)) for line in lines[2 + n:2 + n + n_rows]]
    points = [tuple(map(float, line)) for line in lines[2 + n + n_rows:]]
    assert len(points) == sum(map(int, lines[1]))
    blocks = []
    for material, first, last in heads:
        assert rows[last] == rows[first - 1]  # the first vertex again
        blocks.append(Block(material, [row[0] for row in rows[first - 1:last]], [row[1:] for row in rows[first - 1:last]],
                            rows[last + 1][2]))
    return blocks, points, list(map(int, lines[1])), done.stdout


def known_blocks(name):
    rows = collections.defaultdict(list)
    for row in csv.DictReader((DATA / f"{name}.cut.csv").open()):
        rows[int(row["block"])].append(row)
    assert sorted(rows) == list(range(1, len(rows) + 1))
    blocks = []
    for b in sorted(rows):
        vertices = [(float(row["x"]), float(row["y"])) for row in rows[b]]
        blocks.append(Block(int(rows[b][0]["mat"]), [float(row["jointmat"]) for row in rows[b]], vertices, area_of(vertices)))
    return blocks


def known_points(name):
    return list(csv.DictReader((DATA / f"{name}.points.csv").open()))


def area_of(vertices):
    x0, y0 = vertices[0]
    return sum((a[0] - x0) * (b[1] - y0) - (a[1] - y0) * (b[0] - x0) for a, b in zip(vertices[1:], vertices[2:])) / 2


def numbers(places):
    return [number for place in places for number in place]


def test_there_are_decks():
    assert len(SAME) == 9 and sum(len(known_blocks(name)) for name in SAME) == 129


@pytest.mark.parametrize("name", SAME)
def test_blocks_are_those_of_the_derivative_in_its_order(name, tmp_path):
    blocks, _, _, printed = cut(DATA / f"{name}.geo", tmp_path / "x.blk")
    known = known_blocks(name)
    assert len(blocks) == len(known) and printed.startswith(f"{len(known)} blocks, ")
    for block, expected in zip(blocks, known):
        assert len(block.vertices) == len(expected.vertices)
        assert numbers(block.vertices) == pytest.approx(numbers(expected.vertices), rel=0, abs=DIGITS)
        assert block.joints == expected.joints
        assert block.material == expected.material
        width = max(x for x, _ in expected.vertices) - min(x for x, _ in expected.vertices)
        height = max(y for _, y in expected.vertices) - min(y for _, y in expected.vertices)
        assert block.area == pytest.approx(expected.area, rel=0, abs=4 * DIGITS * (width + height))
        assert block.area > 0


@pytest.mark.parametrize("name", SAME)
def test_points_are_those_of_the_derivative_with_their_blocks(name, tmp_path):
    _, points, counts, _ = cut(DATA / f"{name}.geo", tmp_path / "x.blk")
    known = known_points(name)
    assert counts == [sum(row["type"] == "0" for row in known), 0, sum(row["type"] == "1" for row in known)]
    assert [point[2] for point in points] == [float(row["block"]) for row in known]
    assert numbers(point[:2] for point in points) == pytest.approx(
        numbers((float(row["x"]), float(row["y"])) for row in known), rel=0, abs=DIGITS)


@pytest.mark.parametrize("name", DECKS)
def test_a_block_file_that_is_read_back_and_written_is_the_same(name, tmp_path):
    cut(DATA / f"{name}.geo", tmp_path / "x.blk")
    cut(tmp_path / "x.blk", tmp_path / "y.blk")
    assert (tmp_path / "x.blk").read_text() == (tmp_path / "y.blk").read_text()


def table(printed):
    """Holes and area of each block as printed."""
    return [(int(line.split()[3]), float(line.split()[4])) for line in printed.splitlines()[2:]]


def test_a_block_around_a_hole_point_keeps_its_hole(tmp_path):
    assert len(known_blocks("hole")) == 1 and known_blocks("hole")[0].area == 1  # theirs: what is in the hole
    blocks, points, _, printed = cut(DATA / "hole.geo", tmp_path / "x.blk")
    assert table(printed) == [(1, 8.0)]
    assert blocks[0].area == 8 and area_of(blocks[0].vertices) == 8
    assert len(blocks[0].vertices) == 10  # 4 + 4 and both ends of the seam again
    assert sorted(blocks[0].joints) == [0, 0] + 8 * [1]
    assert points == [(0.2, 0.2, 1.0)]  # the block that theirs has lost


def test_a_hole_point_removes_its_block_alone(tmp_path):
    lines = (DATA / "hole.geo").read_text().splitlines()
    assert lines[7] == "1" and lines[4] == "1" and lines[-1].split() == ["1.5000000000"] * 2
    without = tmp_path / "without.geo"
    without.write_text("\n".join(lines[:7] + ["0"] + lines[8:-1]) + "\n")
    _, points, _, printed = cut(without, tmp_path / "x.blk")
    assert table(printed) == [(1, 8.0), (0, 1.0)] and points == [(0.2, 0.2, 1.0)]
    around = tmp_path / "around.geo"
    around.write_text("\n".join(lines[:4] + ["0"] + lines[5:-2] + ["0.5 1.5"]) + "\n")
    _, _, _, printed = cut(around, tmp_path / "x.blk")
    assert table(printed) == [(0, 1.0)]
