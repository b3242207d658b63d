"""Random joint maps: what `scree cut` makes of them against GEOS, and against rational numbers where GEOS is wrong."""
import math
import multiprocessing
import os
import pathlib
import random

import pytest
import scree
from exact_arrangement import enclosed_area, lengthened
from joint_maps import FAR, closed, geometry_deck, make_map
from shapely.geometry import LineString, Polygon
from shapely.ops import polygonize, unary_union

N_MAPS = int(os.environ.get("SCREE_MAPS", "100"))
SHARE = 1e-12     # of the whole area: some hundred roundings of coordinates, times the length of all lines over the width
E0 = 0.003
CLOSED = 1.25 * 64 * 2.0**-52  # of the extent: gaps that cutting closes, as rounding of a crossing may leave them


def cut(name, lines, e0):
    """Areas of the blocks and the polygons of the block file; the program's message where it fails."""
    pathlib.Path(f"{name}.geo").write_text(geometry_deck(lines, e0))
    done = scree.call("cut", f"{name}.geo", "-o", f"{name}.blk", timeout=60)
    if done.returncode:
        return None, done.stderr
    areas = [float(line.split()[4]) for line in done.stdout.splitlines()[2:]]
    numbers = pathlib.Path(f"{name}.blk").read_text().split()
    n, n_rows = int(numbers[0]), int(numbers[2])
    rows = [tuple(map(float, numbers[k + 1:k + 3])) for k in range(6 + 3 * n, 6 + 3 * (n + n_rows), 3)]  # jm x y
    spans = [(int(numbers[7 + 3 * b]), int(numbers[8 + 3 * b])) for b in range(n)]
    return areas, [rows[first - 1:last] for first, last in spans]


def loops_of(corners):
    """Loops of a polygon whose seams are edges run through both ways."""
    n = len(corners)
    if len(set(corners)) == n:
        return [corners]
    for i in range(n - 4):
        for j in range(i + 4, n):
            if corners[i] == corners[(j + 1) % n] and corners[i + 1] == corners[j]:
                return loops_of(corners[i + 1:j]) + loops_of(corners[:i] + corners[j + 1:])
    return [corners]


def polygon_of(corners, origin):
    """A block as GEOS knows it; differences from the origin are exact. Empty where the file's digits left it no width."""
    loops = [[(x - origin[0], y - origin[1]) for x, y in loop] for loop in loops_of(corners) if len(set(loop)) > 2]
    if not loops:
        return Polygon()
    loops.sort(key=lambda loop: -abs(Polygon(loop).area))
    return Polygon(loops[0], loops[1:])


def examine(seed, folder):
    """What is wrong with a map, by the tests below, and how many blocks it has."""
    os.chdir(folder)
    name = f"map{seed}"
    wrong = {"sum": None, "overlap": None, "shuffled": None, "snapped": None}
    lines, far = make_map(seed)
    origin = (min(min(a[0], a[2]) for a in lines), min(min(a[1], a[3]) for a in lines)) if far else (0, 0)
    here = [(a[0] - origin[0], a[1] - origin[1], a[2] - origin[0], a[3] - origin[1]) for a in lines]
    report = {"seed": seed, "wrong": wrong, "by_geos": True}

    # what is enclosed
    areas, polygons = cut(name, lines, 0)
    if areas is None:
        wrong["sum"] = polygons
        return report
    report["blocks"] = len(areas)
    whole = sum(face.area for face in polygonize(unary_union([LineString([a[:2], a[2:]]) for a in here if a[:2] != a[2:]])))
    if abs(sum(areas) - whole) > SHARE * whole:
        report["by_geos"] = False
        extent = max(map(max, here)) - min(map(min, here))
        least = float(enclosed_area(here))
        most = float(enclosed_area(lengthened(here, CLOSED * extent)))
        whole = min(max(sum(areas), least), most)
        if abs(sum(areas) - whole) > SHARE * whole or most > (1 + 100 * SHARE) * least:
            wrong["sum"] = f"{sum(areas)} is not between {least} and {most}"
    if min(areas) <= 0:
        wrong["sum"] = f"an area of {min(areas)}"

    # The block file carries coordinates as they are: far away with 1e-10 of rounding, which a block may lose its width in.
    rounding = SHARE * whole if not far else 4e-16 * FAR * sum(math.dist(a[:2], a[2:]) for a in here) * 4
    blocks = [polygon_of(p, origin) for p in polygons]
    union = unary_union([b if b.is_valid else b.buffer(0) for b in blocks]).area
    if abs(union - whole) > rounding:
        wrong["overlap"] = f"union {union} instead of {whole}"

    # another order of the lines, and of the ends of each
    rnd = random.Random(-seed)
    shuffled = [a if rnd.random() < 0.5 else a[2:] + a[:2] for a in rnd.sample(lines, len(lines))]
    others = cut(name, shuffled, 0)[0] or []
    large = [sorted(a for a in some if a > SHARE * whole) for some in (areas, others)]
    report["slivers"] = len(areas) - len(large[0])
    if len(large[0]) != len(large[1]):
        wrong["shuffled"] = f"{len(large[1])} blocks instead of {len(large[0])}"
    elif max(abs(a - b) for a, b in zip(*large)) > SHARE * whole:
        wrong["shuffled"] = f"areas differ by {max(abs(a - b) for a, b in zip(*large))}"

    # what is near joined
    areas, polygons = cut(name, lines, E0)
    if areas is None:
        wrong["snapped"] = polygons
        return report
    blocks = [polygon_of(p, origin) for p in polygons]
    if not all(b.is_valid for b in blocks):
        wrong["snapped"] = "a block that is no polygon"
        return report
    union = unary_union(blocks)
    outline = unary_union([Polygon(part.exterior) for part in getattr(union, "geoms", [union])]).area
    if min(areas) <= 0 or abs(sum(areas) - outline) > rounding:
        wrong["snapped"] = f"sum {sum(areas)}, outline {outline}"
    if abs(sum(b.area for b in blocks) - union.area) > rounding:
        wrong["snapped"] = f"blocks overlap by {sum(b.area for b in blocks) - union.area}"
    return report


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    folder = tmp_path_factory.mktemp("maps")
    with multiprocessing.Pool(2) as pool:
        return pool.starmap(examine, [(seed, folder) for seed in range(N_MAPS)], chunksize=20)


def test_the_rational_arrangement_is_right():
    """Squares of 4 and 2 that touch at a corner, one of 1 in the first, a dangling end, a gap that lengthening closes."""
    def square(x, y, width):
        return closed([(x, y), (x + width, y), (x + width, y + width), (x, y + width)])

    lines = square(0, 0, 4) + square(4, 4, 2) + square(1, 1, 1) + [(3, 3, 3.5, 3.7), (4, 1, 5, 1), (5, 1, 5, 2)]
    lines.append((5, 2, 4 + 1e-13, 2))
    assert enclosed_area(lines) == 20
    assert enclosed_area(lines + lines) == 20
    assert enclosed_area(lengthened(lines, 2e-13)) == pytest.approx(21, rel=1e-12)
    for seed in (0, 1, 4, 5):
        lines = [line for line in make_map(seed)[0] if line[:2] != line[2:]][:12]
        by_geos = sum(face.area for face in polygonize(unary_union([LineString([a[:2], a[2:]]) for a in lines])))
        assert float(enclosed_area(lines)) == pytest.approx(by_geos, rel=SHARE)


def test_maps_are_many_and_of_all_sorts(maps):
    assert len(maps) == N_MAPS and sum(m["blocks"] for m in maps) > 20 * N_MAPS
    assert sum(m["slivers"] > 0 for m in maps) > N_MAPS / 4
    assert sum(not m["by_geos"] for m in maps) < N_MAPS / 100


def wrong_in(maps, what):
    return [(m["seed"], m["wrong"][what]) for m in maps if m["wrong"][what]]


def test_the_areas_are_positive_and_sum_to_what_is_enclosed(maps):
    assert not wrong_in(maps, "sum")


def test_blocks_do_not_overlap(maps):
    assert not wrong_in(maps, "overlap")


def test_a_shuffled_deck_gives_the_same_areas(maps):
    assert not wrong_in(maps, "shuffled")


def test_with_a_distance_blocks_are_polygons_without_gaps_and_overlaps(maps):
    assert not wrong_in(maps, "snapped")
