"""Joints never bend the sides of the rock: its outline and area stay, whatever joints come near."""
import math
import os
import pathlib
import sys

import pytest
import scree
from shapely.geometry import LineString, Point
from shapely.ops import polygonize

sys.path.insert(0, str(pathlib.Path(__file__).parent))
from random_rock import make_rock  # noqa: E402

N_ROCKS = int(os.environ.get("SCREE_MAPS", "96"))
SHARE = 1e-9  # of an area or a length; coordinates of `scree joints` are rounded to less


def boundary_of(path):
    """Boundary lines of a geometry deck, x1 y1 x2 y2 each, and the area that they enclose without that of hole points."""
    words = [w for line in path.read_text().split("\n&")[0].splitlines() for w in line.split("!")[0].split()]
    n_holes = int(words[8])
    lines = [tuple(map(float, words[9 + 5 * i:13 + 5 * i])) for i in range(int(words[2]))]
    holes = [Point(float(words[-2 * k]), float(words[1 - 2 * k] if k > 1 else words[-1])) for k in range(1, n_holes + 1)]
    rock = [face for face in polygonize([LineString([a[:2], a[2:]]) for a in lines])
            if not any(face.contains(hole) for hole in holes)]
    return lines, math.fsum(face.area for face in rock)


def edges_of_blocks(path):
    """Edges of the polygons of a block file, without the seams to holes, which run both ways."""
    words = path.read_text().split()
    n, n_rows = int(words[0]), int(words[2])
    rows = [tuple(map(float, words[k + 1:k + 3])) for k in range(6 + 3 * n, 6 + 3 * (n + n_rows), 3)]
    edges = []
    for b in range(n):
        corners = rows[int(words[7 + 3 * b]) - 1:int(words[8 + 3 * b])]
        own = list(zip(corners, corners[1:] + corners[:1]))
        both = set(own)
        edges += [(p, q) for p, q in own if (q, p) not in both]
    return edges


def area_within(edges):
    """Area to the left of edges that close."""
    return math.fsum(p[0] * q[1] - q[0] * p[1] for p, q in edges) / 2


def covered(line, edges, near):
    """Length of a line that edges lie on."""
    length = math.dist(line[:2], line[2:])
    u = ((line[2] - line[0]) / length, (line[3] - line[1]) / length)
    total = 0.0
    for p, q in edges:
        off = [abs(u[0] * (r[1] - line[1]) - u[1] * (r[0] - line[0])) for r in (p, q)]
        if max(off) > near:
            continue
        along = sorted(u[0] * (r[0] - line[0]) + u[1] * (r[1] - line[1]) for r in (p, q))
        total += max(0.0, min(along[1], length) - max(along[0], 0.0))
    return total / length


def bent(folder, seed):
    """What a cut changed of the outline of a rock: '' where nothing did."""
    text, kind, e0, unit = make_rock(seed)
    deck = folder / f"rock{seed}.joints"
    deck.write_text(text)
    done = scree.call("joints", deck.name, cwd=folder, timeout=60)
    assert done.returncode == 0, done.stderr
    done = scree.call("cut", f"rock{seed}.geo", cwd=folder, timeout=60)
    assert done.returncode == 0, done.stderr
    lines, area = boundary_of(folder / f"rock{seed}.geo")
    edges = edges_of_blocks(folder / f"rock{seed}.blk")
    size = max(math.dist(line[:2], line[2:]) for line in lines)
    error = area_within(edges) / area - 1
    if abs(error) > SHARE:
        return f"rock {seed} ({kind}, e0 {e0}, unit {unit}): the area is off by {error:.1e}"
    for line in lines:
        share = covered(line, edges, SHARE * size)
        if abs(share - 1) > SHARE:
            return f"rock {seed} ({kind}, e0 {e0}, unit {unit}): blocks have {share} of the side {line}"
    return ""


@pytest.mark.parametrize("part", range(8))
def test_random_rock_keeps_its_area_and_each_side_of_its_outline(tmp_path, part):
    found = [bent(tmp_path, seed) for seed in range(part, N_ROCKS, 8)]
    assert not list(filter(None, found))
