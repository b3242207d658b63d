"""Blocks that overlap when a run begins: seen, said, held without energy, or refused."""
import re

import numpy as np
import pytest
import shapely.geometry
import shapely.ops
import scree
from test_blocks_touch import G, MODES, box, run, touching, turn

E = 1e7
ROCK = (2.5, 2.5 * G, E, 0.25)


def stack(depth, shift=0.0, tilt=0.0):
    """Two unit boxes on a fixed floor, the upper one sunk into the lower by a depth."""
    upper = box(-0.5, 0, 1, 1) @ turn(tilt).T
    return [box(-20, -2, 40, 2), box(-0.5, 0, 1, 1), upper + [shift, 1 - depth - upper[:, 1].min()]]


def tip(depth):
    """A triangle that stands on its tip in the lower box, held upright by a groove: two fixed blocks beside it."""
    return [box(-20, -2, 40, 2), box(-0.5, 0, 1, 1), np.array([[0.1, 1 - depth], [0.4, 2 - depth], [-0.2, 2 - depth]]),
            box(-3.2, 1.5 - depth, 3.0, 1), box(0.4, 1.5 - depth, 3, 1)]


def corner(depth):
    """A box that hangs over the lower one's corner, both corners inside each other, beside a fixed wall that it leans on."""
    return [box(-20, -2, 40, 2), box(-0.5, 0, 1, 1), box(0.5 - depth, 1 - depth, 1, 1), box(1.5 - depth, 0, 1, 3)]


def notch(depth):
    """A box sunk in the hollow corner of an L that is fixed: into its floor and into its side."""
    return [np.array([[-2.0, -1], [1.5, -1], [1.5, 2], [1, 2], [1, 0], [-2, 0]]), box(depth, -depth, 1, 1)]


def settle(folder, blocks, held, size, mode, steps=400, phi=30.0, more="", **options):
    """Runs blocks of a size, times by its root and E by the size: the same run in other units."""
    blocks = [corners * size for corners in blocks]
    fixed = [(*x, i + 1) for i, corners in enumerate(blocks) if i in held for x in corners]
    return run(folder, blocks, MODES[mode] + more, steps=steps, dt=0.005 * size**0.5, phi=phi, fixed=fixed,
               rock=(2.5, 2.5 * G, E * size, 0.25), **options)


def weight_by_height(size):
    return 2.5 * G * size**3


def gained(f, size):
    """Largest kinetic energy above the work of gravity since the start, over m g h of a block."""
    fallen = f.bodies.centroid[0, :, 1] - f.bodies.centroid[1:, :, 1]
    work = 2.5 * G * fallen @ f.bodies.area[0]
    return (f.history.energy.kinetic - work).max() / weight_by_height(size)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("shift", [0.0, 0.25])
@pytest.mark.parametrize("depth", [1e-12, 1e-9, 1e-6, 1e-3, 1e-2])
def test_blocks_that_overlap_rest_where_they_are_without_energy(depth, shift, size, tmp_path):
    f = settle(tmp_path, stack(depth, shift), {0}, size, "dda")
    assert f.history.time[-1] == pytest.approx(2 * size**0.5)
    assert gained(f, size) < 1e-6
    moved = (f.bodies.centroid[-1] - f.bodies.centroid[0]) / size
    assert np.abs(moved).max() < 1e-5  # what the springs give is 7e-7, the columns 6e-6
    assert f.history.energy.kinetic[-1] < 1e-9 * weight_by_height(size)
    borne = 2 * 2.5 * G / (2 * 5 * E)  # by one of two springs of 5 E: below both boxes; beside each other they bear up to 3/4 more
    assert depth <= f.history.overlap[-1] / size * (1 + 1e-9) < depth + 1.75 * borne


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("scene,held", [(stack(1e-2, 0.1, 0.3), {0}), (stack(3e-4, 0.0, -0.1), {0}), (tip(1e-2), {0, 3, 4}),
                                        (corner(1e-2), {0, 3}), (notch(1e-2), {0})],
                         ids=["tilted", "nearly flush", "tip", "corner", "notch"])
def test_however_they_overlap_nothing_is_thrown(scene, held, mode, tmp_path):
    f = settle(tmp_path, scene, held, 1.0, mode)
    assert gained(f, 1.0) < 1e-6
    assert f.history.overlap[0] > 2e-4
    assert f.history.overlap.max() < 1.02e-2


@pytest.mark.parametrize("way", ["\n&contact rules='conserving' /\n&integrator beta=0.5 /",
                                  "\n&contact restitution=0 /", "\n&contact method='augmented', overlap=1e-6 /"])
def test_an_overlap_brings_no_energy_to_other_ways_of_contact(way, tmp_path):
    f = settle(tmp_path, stack(1e-2, 0.25), {0}, 1.0, "nmm green", steps=100, more=way)
    assert gained(f, 1.0) < 1e-6
    assert np.abs(f.bodies.centroid[-1] - f.bodies.centroid[0]).max() < 3e-5


def random_polygon(random):
    """Convex or a star, about the origin, or nothing where it does not go round."""
    angles = np.sort(random.uniform(0, 2 * np.pi, random.integers(3, 8)))
    if np.diff(angles, append=angles[0] + 2 * np.pi).max() > 3:
        return None
    radius = 1 if random.random() < 0.5 else random.uniform(0.4, 1, len(angles))[:, None]
    return np.column_stack([np.cos(angles), np.sin(angles)]) * radius


def test_any_pair_that_overlaps_in_area_has_a_contact_and_stays(tmp_path):
    """Polygons of all sizes thrown on each other, without weight: what GEOS says that they have in common they hold, at rest."""
    random, overlapping = np.random.default_rng(1), 0
    while overlapping < 80:
        a, b = random_polygon(random), random_polygon(random)
        if a is None or b is None:
            continue
        b = b * random.choice([1, 0.3, 0.05]) + random.normal(size=2) * 0.5
        common = shapely.geometry.Polygon(a).intersection(shapely.geometry.Polygon(b)).area
        try:
            f = run(tmp_path, [a, b], "&contact initial=1 /", steps=5, rock=(2.5, 0, E, 0.25), phi=20.0)
        except scree.RunFailed as error:
            assert "that cross" in str(error), error
        else:
            assert f.history.energy.kinetic.max() < 1e-20
            assert (f.history.contacts[0].sum() > 0 and f.history.overlap[0] > 0) or common < 1e-6
        overlapping += common > 1e-6


def crossing_stack(random, grown):
    """Four to nine blocks that joints cut, on a fixed floor, each grown about its middle: corners overlap across both of their lines."""
    rock = shapely.geometry.MultiPolygon([shapely.geometry.box(0, 0, *random.uniform(0.5, 2, 2))])
    for dip in random.uniform(-0.5, 0.5, 2) + [0, np.pi / 2]:
        for share in np.arange(1, random.integers(2, 4)) / 3:
            along, point = np.array([np.cos(dip), np.sin(dip)]), np.array(rock.bounds[2:]) * share
            cut = shapely.geometry.LineString([point - 9 * along, point + 9 * along])
            rock = shapely.geometry.MultiPolygon([part for block in rock.geoms for part in shapely.ops.split(block, cut).geoms])
    corners = [np.array(shapely.geometry.polygon.orient(block).exterior.coords[:-1]) for block in rock.geoms]
    return [box(-5, -1, 12, 1)] + [x.mean(0) + (x - x.mean(0)) * (1 + grown) for x in corners]


@pytest.mark.parametrize("grown", [1e-6, 3e-5, 1e-4])
def test_stacks_whose_corners_overlap_stay_where_they_are(grown, tmp_path):
    """Where a third block covers the line that a corner is least across it acts across the other one: by all that it was behind it."""
    random = np.random.default_rng(3)
    for _ in range(25):
        blocks = crossing_stack(random, grown)
        f = run(tmp_path, blocks, "", steps=3, rock=(2.5, 0, E, 0.25), phi=random.choice([0.0, 40.0]), fixed=[(*x, 1) for x in blocks[0]])
        assert f.history.overlap[0] > 0.1 * grown and f.history.energy.kinetic.max() < 1e-20


@pytest.mark.parametrize("seed", [0, 1, 5])
def test_rock_with_rounded_corners_overlaps_by_their_rounding_and_gains_no_energy(seed, tmp_path):
    """Blocks of random joints, turned, written with six decimals: the common area of two may be thin and long, and end in a face on
    which they only touch."""
    deck = touching.jointed_rock(tmp_path, "dda", seed, steps=2)
    lines = scree.cut(next(tmp_path.glob("*.geo")), output=tmp_path / "cut.blk").read_text().splitlines()
    blocks, rows = int(lines[0].split()[0]), int(lines[0].split()[2])
    points = range(2 + blocks + rows, len(lines))
    for i in range(2 + blocks, len(lines)):
        words = lines[i].split()
        x = slice(0, 2) if i in points else slice(1, 3)
        if any(float(word) for word in words):
            words[x] = [f"{u:.6f}" for u in turn(23 * seed) @ np.array(words[x], float)]
        lines[i] = " ".join(words)
    (tmp_path / "rounded.blk").write_text("\n".join(lines) + "\n")
    (tmp_path / "rounded.ana").write_text(re.sub(r"&deck[^/]*/", "&deck dialect='short' /", deck.read_text()))
    files = [tmp_path / "rounded.blk", tmp_path / "rounded.ana"]
    told = scree.call("check", *files)
    assert told.returncode == 0, told.stderr
    depths = [float(depth) for depth in re.findall(r"^overlap: blocks \d+ and \d+ by (\S+),", told.stdout, re.M)]
    assert len(depths) > 20 and max(depths) < 2e-6
    f = scree.run(*files)
    assert np.diff(f.history.energy.dissipated, prepend=0.0).min() > -1e-9 * np.ptp(f.history.energy.gravity)


def test_ten_blocks_stand_in_each_other(tmp_path):
    """A tenth of each in the next, as the deck says that it wants them."""
    blocks = [box(-20, -2, 40, 2)] + [box(-0.5, 0.9 * i, 1, 1) for i in range(10)]
    f = settle(tmp_path, blocks, {0}, 1.0, "dda", steps=200, more="\n&contact initial=0.2 /")
    assert gained(f, 1.0) < 1e-6
    assert np.abs(f.bodies.centroid[-1] - f.bodies.centroid[0]).max() < 1e-3
    assert f.history.overlap[-1] == pytest.approx(0.1, rel=1e-3)


def test_what_has_come_out_stays_out(tmp_path):
    """A load of a little more than its weight draws the upper block out of the lower one, which is fixed."""
    blocks = stack(1e-2, 0.25)
    fixed = [(*x, i + 1) for i in range(2) for x in blocks[i]]
    f = run(tmp_path, blocks, "&loads force=0 25.2 /", steps=100, dt=0.001, rock=ROCK, phi=30.0, fixed=fixed,
            loads=[(*blocks[2].mean(0), 3)])
    up = f.bodies.centroid[:, 2, 1] - f.bodies.centroid[0, 2, 1]
    t = f.history.time[-1]
    assert up[-1] == pytest.approx(0.08 * t**2 / 2, rel=1e-3)  # 0.2 kN over 2.5 t, and no push of the spring
    assert f.history.overlap[-1] == pytest.approx(1e-2 - up[-1], rel=1e-3)


def check(folder, blocks, *options):
    """Writes the deck and checks it."""
    run_it = []
    try:
        run(folder, blocks, steps=1, fixed=[(*x, 1) for x in blocks[0]], rock=ROCK)
    except scree.RunFailed as error:
        run_it.append(str(error))
    done = scree.call("check", folder / "scene.ana", *options)
    return done, run_it


def test_check_lists_overlaps_with_depth_and_place(tmp_path):
    done, failed = check(tmp_path, stack(1e-3, 0.25))
    assert done.returncode == 0 and not failed
    lines = [line for line in done.stdout.splitlines() if line.startswith("overlap: ")]
    assert lines == ["overlap: blocks 2 and 3 by 0.001, 0.001 of the smaller, at (0.125, 0.9995)"]


@pytest.mark.parametrize("blocks,words", [
    (stack(0.1, 0.25), "blocks 2 and 3 by 0.1, 0.1 of the smaller, at (0.125, 0.95)"),
    ([*stack(0.0), box(-0.5, 1, 1, 1)], "blocks 3 and 4 by 1, 1 of the smaller"),
    ([*stack(0.0), box(-0.2, 1.3, 0.4, 0.3)], "blocks 3 and 4 by"),
    ([box(-20, -2, 40, 2), box(-0.5, 0, 1, 1), box(-3, 0.5, 6, 0.01)], "blocks 2 and 3 that cross"),
], ids=["by a tenth", "twins", "nested", "crossing"])
def test_blocks_that_overlap_by_more_are_refused_by_number_and_place(blocks, words, tmp_path):
    done, failed = check(tmp_path, blocks)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert words in done.stderr
    assert re.search(r"scene\.blk:\d+: expected blocks that overlap by at most 0\.02 of the smaller \(contact\.initial\)", done.stderr)
    assert failed and words in failed[0]
    assert not (tmp_path / "scene.h5").exists()
    crossing = "cross" in words
    again = scree.call("check", tmp_path / "scene.ana", "--set", "contact.initial=1")
    assert again.returncode == (2 if crossing else 0)


def test_blocks_that_overlap_are_refused_under_a_mesh(tmp_path):
    """Which would cut each of them by the outlines of both, and leave the common area to one."""
    check(tmp_path, stack(1e-3))
    words = ["--set", "method.model=nmm", "--set", "cover.edge=0.4"]
    done = scree.call("check", tmp_path / "scene.ana", *words)
    assert done.returncode == 2
    assert "expected blocks that do not overlap under a mathematical mesh, found blocks 2 and 3 by 0.001" in done.stderr


def test_neighbours_that_share_edges_and_corners_do_not_overlap(tmp_path):
    """A fan of wedges about a point, flush boxes of other sizes, a block in a hole of another's outline."""
    angles = np.linspace(0, 2 * np.pi, 8)[:-1]
    rim = np.column_stack([np.cos(angles), np.sin(angles)]) @ turn(11).T + [0, 3]
    fan = [np.array([[0, 3], rim[i], rim[(i + 1) % 7]]) for i in range(7)]
    boxes = [box(-20, -2, 40, 2), box(5, 0, 1, 1), box(6, 0, 0.3, 0.7), box(5.2, 1, 1.1, 0.3)]
    done, failed = check(tmp_path, boxes + fan)
    assert done.returncode == 0 and not failed and "overlap:" not in done.stdout
