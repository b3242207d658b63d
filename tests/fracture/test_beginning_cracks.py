"""Cracks that begin without a notch, in the program: where, at which load, one at a time, and the same with the scene turned and after a restart."""
import math
import os
import subprocess

import h5py
import numpy as np
import pytest
import scree

SCREE = os.environ["SCREE"]
TENSION = 1e6


def turned(points, angle):
    c, s = math.cos(angle), math.sin(angle)
    return [(c * x - s * y, s * x + c * y) for x, y in points]


def numbers(points):
    return " ".join(f"{x:.17g}" for point in points for x in point)


def lines_of(corners):
    return [" ".join(f"{x:.17g}" for x in (*a, *b)) + " 1" for a, b in zip(corners, [*corners[1:], corners[0]])]


def write(folder, loops, groups, *, hole=(), weight=0.0, dynamic=False, steps=2, dt=1.0):
    """A block of rock, E 20 GPa, nu 0.25, density 2600, with the outline and the hole of some loops."""
    rows = [row for loop in loops for row in lines_of(loop)]
    (folder / "scene.geo").write_text("\n".join(["0", f"{len(rows)} {len(loops[0])}", *"00000", str(len(hole)), *rows,
                                                 *(numbers([place]) for place in hole), ""]))
    (folder / "scene.ana").write_text("\n".join([
        f"{int(dynamic)} {steps} 1 1 0.05 {dt}", f"2600 {weight} 2e10 0.25", "0 0 0", "0 0 0", "0 0 0", "30 0 0",
        "&deck geometry='scene.geo' /", "&method model='nmm', plane='strain' /", groups, ""]))
    return folder / "scene.ana"


def kirsch(x, y):
    """Stress xx, yy, xy around a hole of radius 1 in a plate under the tension along y (Kirsch 1898)."""
    b, angle = 1 / (x * x + y * y), np.arctan2(y, x)
    cos, sin = np.cos(2 * angle), np.sin(2 * angle)
    radial = (1 - b) / 2 - (1 - 4 * b + 3 * b * b) / 2 * cos
    hoop = (1 + b) / 2 + (1 + 3 * b * b) / 2 * cos
    shear = (1 + 2 * b - 3 * b * b) / 2 * sin
    mean, half = (radial + hoop) / 2, (radial - hoop) / 2
    return TENSION * (mean + half * cos - shear * sin), TENSION * (mean - half * cos + shear * sin), TENSION * (half * sin + shear * cos)


def mean_beside_the_hole(radius, n=300):
    """Mean tension over the half disc of a radius beside the hole, where its edge is along the load."""
    r = radius * np.sqrt((np.arange(n) + 0.5) / n)[:, None]
    t = math.pi * ((np.arange(n) + 0.5) / n - 0.5)
    return kirsch(1 + r * np.cos(t), r * np.sin(t))[1].mean()


def plate(folder, share, angle=0.0, length=0.4, edge=0.2, half=3.0, pieces=12, sides=48, **more):
    """A plate with a hole of radius 1 under Kirsch's tractions, whose strength is a share of the mean tension beside the hole."""
    x = np.linspace(-half, half, pieces + 1)[:-1]
    corners = [*((a, -half) for a in x), *((half, a) for a in x), *((-a, half) for a in x), *((-half, -a) for a in x)]
    hole = [(math.cos(a), math.sin(a)) for a in 2 * math.pi * np.arange(sides) / sides]
    lines, traction = [], []
    for a, b in zip(corners, [*corners[1:], corners[0]]):
        normal = np.array([b[1] - a[1], a[0] - b[0]]) / np.hypot(b[1] - a[1], a[0] - b[0])
        for place in (a, b):
            xx, yy, xy = kirsch(*place)
            traction += turned([(xx * normal[0] + xy * normal[1], xy * normal[0] + yy * normal[1])], angle)
        lines += turned([a, b], angle)
    held = turned([(-half, -half), (-half + 2 * half / pieces, -half)], angle)
    return write(folder, [turned(corners, angle), turned(hole, angle)], f"""
&cover edge={edge}, origin={numbers(turned([(0.031, 0.017)], angle))}, angle={math.degrees(angle)} /
&support both={numbers(held)} /
&boundary lines={numbers(lines)}, traction={numbers(traction)} /
&cracks strength={share * mean_beside_the_hole(length)}, length={length}, begin_joint=1 /
&output every=1 /""", hole=turned([(0, 0)], angle), **more)


def bar(folder, share, more="", width=0.6, height=2.0, **how):
    """A bar without a notch that its ends are pulled at, whose strength is a share of the tension."""
    return write(folder, [[(0, 0), (width, 0), (width, height), (0, height)]], f"""
&cover edge=0.1, origin=0.031 0.017 /
&support normal=0 0 {width} 0 /
&boundary lines=0 {height} {width} {height}, traction=0 {TENSION} 0 {TENSION} /
&cracks strength={share * TENSION}, length=0.2, begin_joint=1 /
&output every=1 /
{more}""", **how)


def faces(r, frame=-1):
    """Edges with a joint inside the rock, as pairs of places at the start, each once, by their middles."""
    found = {}
    for polygon, joint in zip(r.polygons(0), np.split(r.joints(frame), r["VTKHDF/Offsets"][1:-1])):
        for a, b, j in zip(polygon, np.roll(polygon, -1, axis=0), joint):
            if j:
                found.setdefault(tuple(np.round((a + b) / 2, 9)), []).append((a, b))
    return np.array([pairs[0] for pairs in found.values() if len(pairs) == 2])


def begins(deck):
    """Whether a crack begins in a run, and what the run says of it."""
    run = subprocess.run([SCREE, "run", deck, "-o", deck.with_suffix(".h5")], capture_output=True, text=True, check=True)
    told = [line for line in run.stdout.splitlines() if line.startswith("crack tip") and " begins at " in line]
    assert (scree.read(deck.with_suffix(".h5"))._layouts.count > 1) == bool(told)
    return bool(told)


@pytest.mark.parametrize("share, expected", [(0.97, True), (1.03, False)])
def test_a_hole_breaks_at_the_mean_tension_beside_it(share, expected, tmp_path):
    assert begins(plate(tmp_path, share)) == expected
    if not expected:
        return
    crack = faces(scree.read(tmp_path / "scene.h5"))
    place = crack.reshape(-1, 2)[np.argmin(np.hypot(*crack.reshape(-1, 2).T))]
    far = crack.reshape(-1, 2)[np.argmax(np.hypot(*crack.reshape(-1, 2).T))]
    assert np.hypot(*place) == pytest.approx(1, abs=3e-3) and abs(place[1]) < 0.2  # the side of a triangle
    assert np.hypot(*(far - place)) >= 0.4 - 1e-9
    along = abs(np.degrees(math.atan2(far[1] - place[1], abs(far[0] - place[0]))))
    assert along < 10 and np.sign(far[0] - place[0]) == np.sign(place[0])


def test_the_mean_over_a_half_disc_is_that_of_the_average_stress_criterion():
    for length in (0.05, 0.1, 0.2, 0.3):
        xi = 1 / (1 + length)
        assert mean_beside_the_hole(length) == pytest.approx(TENSION * (2 - xi**2 - xi**4) / (2 * (1 - xi)), rel=0.016)


@pytest.mark.parametrize("share, expected", [(0.999, True), (1.001, False)])
def test_a_bar_without_a_notch_breaks_at_its_strength(share, expected, tmp_path):
    assert begins(bar(tmp_path, share)) == expected


def test_one_crack_at_a_time_begins_in_a_static_run(tmp_path):
    """All of the bar has reached its strength, so another crack could begin in each step."""
    r = scree.run(bar(tmp_path, 0.95, steps=4), timeout=60)
    assert r._layouts.count > 2 and r.bodies.present[-1].sum() == 1
    crack = faces(r).reshape(-1, 2)
    assert np.ptp(crack[:, 1]) < 0.2 and abs(crack[:, 1].mean() - 1) < 0.1


def test_a_path_turns_with_the_scene(tmp_path):
    paths = []
    for angle in (0.0, math.radians(37)):
        folder = tmp_path / f"{angle:.2f}"
        folder.mkdir()
        r = scree.run(plate(folder, 0.9, angle, steps=4), timeout=100)
        path = np.array(turned(faces(r).mean(axis=1), -angle))
        paths.append(path[np.lexsort(np.round(path, 5).T)])
    assert len(paths[0]) > 2
    assert paths[1] == pytest.approx(paths[0], abs=1e-6)


def with_tips(deck):
    """The deck, which writes the tips of cracks."""
    deck.write_text(deck.read_text().replace("&output every=1", "&output every=1, cracks='tips'"))
    return deck


def test_a_tip_has_rows_from_when_its_crack_begins(tmp_path):
    r = scree.run(with_tips(bar(tmp_path, 0.95, steps=4)), timeout=60)
    assert np.array_equal(r.tips.tip, [1] * 3) and np.array_equal(r.tips.time, r.history.time[1:])
    for time, place, length in zip(r.tips.time, r.tips.place, r.tips.length):
        pieces = r.growth.time[()] < time
        ways = r.growth.end[pieces] - r.growth.start[pieces]
        assert length == pytest.approx(np.hypot(*ways.T).sum(), rel=1e-9)
        assert place == pytest.approx(r.growth.end[pieces][-1], abs=1e-3)  # by the small displacement of the bar
    assert (r.tips.K_I > 0).all() and np.array_equal(r.history.cracks.K_I[:, 0], [0, *r.tips.K_I])
    assert r.history.cracks.place.shape == (4, 1, 2) and r.history.units("cracks/K_I") == r.tips.units("K_I")
    assert "cracks/K_II" in r.history and "history/cracks" in r and "cracks/length" in r.history.series()


def test_a_run_goes_on_to_the_bit_after_a_crack_began(tmp_path):
    deck = with_tips(bar(tmp_path, 0.95, steps=6))
    whole, half = tmp_path / "whole.h5", tmp_path / "half.h5"
    subprocess.run([SCREE, "run", deck, "-o", whole, "--quiet"], check=True)
    subprocess.run([SCREE, "run", deck, "-o", half, "--quiet", "--set", "step.count=3"], check=True)
    subprocess.run([SCREE, "run", "--restart", half, "-o", half, "--quiet", "--set", "step.count=6"], check=True)
    with h5py.File(whole) as a, h5py.File(half) as b:
        names = []
        a.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        assert "elements/parent" in names and len(a["tips/tip"])
        for name in names:
            if name.split("/")[0] in ("VTKHDF", "elements", "growth", "tips", "history", "bodies", "contacts"):
                assert a[name][()].tobytes() == b[name][()].tobytes(), name


def test_a_block_tears_under_its_weight_and_falls_freely(tmp_path):
    """A block with a waist hangs on its upper side. One crack tears it there, and the lower part falls by g t^2/2 from then on; area stays."""
    g, density, height, length = 10.0, 2600.0, 2.0, 0.2
    strength = 1.6 * density * g  # the weight at rest makes 1.8 in the waist
    write(tmp_path, [[(0.3, 0), (0.9, 0), (0.75, 1.2), (1.2, height), (0, height), (0.45, 1.2)]], f"""
&cover edge=0.1, origin=0.031 0.017 /
&support both=0 {height} 1.2 {height} /
&cracks strength={strength}, length={length}, toughness={strength * math.sqrt(length / 0.39)}, begin_joint=1 /
&output every=1 /""", dynamic=True, steps=40, dt=3e-3, weight=density * g)
    r = scree.run(tmp_path / "scene.ana", timeout=100)
    there = r.bodies.present.sum(axis=1)
    assert there[0] == 1 and there[-1] == 2
    part = r.block[np.argmin([polygon[:, 1].mean() for polygon in r.polygons(0)])] - 1
    alone = int(np.argmax(there == 2)) + 15
    assert alone < len(there) - 10
    t, y, v = r.times[alone:] - r.times[alone], r.bodies.centroid[alone:, part, 1], r.bodies.velocity[alone:, part, 1]
    assert v == pytest.approx(v[0] - g * t, abs=1e-3 * g * t[-1])
    assert y == pytest.approx(y[0] + v[0] * t - g * t**2 / 2, abs=2e-3 * g * t[-1]**2 / 2)
    area = r.bodies.area.sum(axis=1)
    assert area == pytest.approx(np.full(len(area), area[0]), rel=1e-4)


def test_a_crack_at_a_held_edge_counts_what_its_steps_lose(tmp_path):
    """The edge takes up what the sides of a crack that begins there do not: its reaction belongs to the side that it goes on to hold."""
    weight, length = 26e3, 4.0
    r = scree.run(write(tmp_path, [[(0, 0), (length, 0), (length, 1), (0, 1)]], f"""
&cover edge=0.1, origin=0 0 /
&support both=0 0 0 1 /
&cracks strength={1.8 * weight * length**2}, length=0.25, begin_joint=1 /
&output every=1 /""", weight=weight, steps=4), timeout=600)
    taken, lost = np.diff(r.history.energy.fracture[()]), np.diff(r.history.energy.dissipated[()])
    assert len(r.growth.time) > 10 and (taken[:2] > 0.1).all()
    assert taken[:2] == pytest.approx(lost[:2], rel=1e-3)


def test_no_crack_begins_below_the_strength(tmp_path):
    deck = bar(tmp_path, 0.95, steps=3)
    deck.write_text(deck.read_text().replace(f"strength={0.95 * TENSION}", "strength=1e9"))
    assert scree.run(deck, timeout=60)._layouts.count == 1


@pytest.mark.parametrize("change, words", [
    (("begin_joint=1", "begin_joint=2"), "expected a joint material up to 1 for cracks.begin_joint, found 2"),
    (("begin_joint=1", "begin_joint=-1"), "cracks.begin_joint"),
    ((", length=0.2", ""), "cracks.length"),
    (("length=0.2", "length=0.1"), "at least two edges of the mesh, 0.2,"),
    (("length=0.2", "length=2.5"), "expected cracks.length of at most the size of the largest block that may break, 2"),
    ((", begin_joint=1", ""), "expected a joint that ends inside a block or cracks.begin_joint with cracks.strength, found none"),
])
def test_what_cannot_begin_is_refused(change, words, tmp_path):
    deck = bar(tmp_path, 0.95)
    deck.write_text(deck.read_text().replace(*change))
    refused = subprocess.run([SCREE, "run", deck, "-o", tmp_path / "x.h5"], capture_output=True, text=True)
    assert refused.returncode == 2 and words in refused.stderr, refused.stderr
