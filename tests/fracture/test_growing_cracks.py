"""Cracks that grow through a mesh, in the program: parts that break off fly free, paths turn with the scene, and runs go on to the bit."""
import math
import os
import pathlib
import subprocess

import h5py
import numpy as np
import pytest
import scree

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
SCREE = os.environ["SCREE"]


def lines_of(points, joint=1):
    return [" ".join(f"{x:.17g}" for x in (*a, *b)) + f" {joint}" for a, b in zip(points, points[1:])]


def write(folder, outline, cracks, groups, *, name="scene", dynamic=False, steps=60, dt=1.0, weight=0.0, velocity="0 0 0"):
    """A block with cracks, E 20 GPa, nu 0.25, density 2600."""
    closed = [*outline, outline[0]]
    rows = [*lines_of(closed), *(line for crack in cracks for line in lines_of(crack))]
    (folder / f"{name}.geo").write_text("\n".join(["1e-6", f"{len(rows)} {len(outline)}", "0", "0", "0", "0", "0", "0", *rows, ""]))
    (folder / f"{name}.ana").write_text("\n".join([
        f"{int(dynamic)} {steps} 1 1 0.05 {dt}", f"2600 {weight} 2e10 0.25", "0 0 0", "0 0 0", velocity, "30 0 0",
        f"&deck geometry='{name}.geo' /", "&method model='nmm', plane='strain' /", groups, ""]))
    return folder / f"{name}.ana"


def turned(points, angle):
    c, s = math.cos(angle), math.sin(angle)
    return [(c * x - s * y, s * x + c * y) for x, y in points]


def numbers(points):
    return " ".join(f"{x:.17g}" for point in points for x in point)


STRENGTH, TOUGHNESS = "strength=2e6, length=0.2", "toughness=2e6"


def plate(folder, angle=0.0, steps=12, groups="", law=STRENGTH, **more):
    """A plate of 2 x 2 with a crack from its left side, that its upper side pulls at."""
    def turn(*points):
        return turned(points, angle)
    (up,) = turn((0, 1.5e6))
    return write(folder, turn((0, 0), (2, 0), (2, 2), (0, 2)), [turn((0, 0.9), (0.6, 1.013))], f"""
&cover edge=0.1, angle={math.degrees(angle)} /
&support both={numbers(turn((0, 0), (2, 0)))} /
&boundary lines={numbers(turn((0, 2), (2, 2)))}, traction={numbers([up, up])} /
&cracks {law} /
&output every=1, cracks='tips' /
{groups}""", steps=steps, **more)


def crack_edges(r, frame=-1):
    """Middles of the edges that have a joint, at the start, in the order of the places."""
    ends = [(a, b) for polygon, joint in zip(r.polygons(0), np.split(r.joints(frame), r["VTKHDF/Offsets"][1:-1]))
            for a, b, j in zip(polygon, np.roll(polygon, -1, axis=0), joint) if j]
    return np.array([(a + b) / 2 for a, b in ends])


def test_a_part_that_breaks_off_falls_freely(tmp_path):
    """A block hangs on its upper side; a notch cuts it by half, and the rest tears. The lower part falls by g t^2/2 from then on."""
    g, density, height = 10.0, 2600.0, 2.0
    write(tmp_path, [(0, 0), (1, 0), (1, height), (0, height)], [[(0, 1.01), (0.3, 1.01)], [(1, 1.01), (0.7, 1.01)]], f"""
&cover edge=0.09 /
&support both=0 {height} 1 {height} /
&cracks strength={density * g * 1.0}, length=0.2 /
&output every=1 /""", name="hanging", dynamic=True, steps=120, dt=2e-3, weight=density * g)
    r = scree.run(tmp_path / "hanging.ana", timeout=600)
    there = r.bodies.present.sum(axis=1)
    assert there[0] == 1 and there[-1] == 2
    part = r.block[np.argmin([polygon[:, 1].mean() for polygon in r.polygons(-1)])] - 1
    free = int(np.argmax(there == 2)) + 20
    assert r.contacts_of(-1).__len__() == 0
    t, y, v = r.times[free:], r.bodies.centroid[free:, part, 1], r.bodies.velocity[free:, part, 1]
    t = t - t[0]
    assert y == pytest.approx(y[0] + v[0] * t - g * t**2 / 2, abs=2e-3 * g * t[-1]**2 / 2)
    area = r.bodies.area.sum(axis=1)
    assert area == pytest.approx(np.full(len(area), 2.0), rel=1e-4)


@pytest.mark.parametrize("law, off", [(STRENGTH, 1e-6), (TOUGHNESS, 1e-5)])
def test_a_path_turns_with_the_scene(law, off, tmp_path):
    """The weights of a disc are sums over triangles, into which a polygon may be divided otherwise where it is turned: K differs by 2e-6."""
    paths = []
    for angle in (0.0, math.radians(90), math.radians(37)):
        folder = tmp_path / f"{angle:.2f}"
        folder.mkdir()
        r = scree.run(plate(folder, angle, law=law), timeout=600)
        assert r._layouts.count > 5
        path = np.array(turned(crack_edges(r), -angle))
        paths.append(path[np.lexsort(np.round(path, 6).T)])
    for path in paths[1:]:
        assert path == pytest.approx(paths[0], abs=off)


def held(folder, quarter_turns, steps=14):
    """A plate of 1 x 2 with a crack at 30 degrees, pulled by two rows of points that turn with it in a static run: to the load at which it
    grows in eight steps, then on."""
    points = [(x, y) for y in (-0.95, 0.95) for x in np.linspace(-0.45, 0.45, 5)]
    crack = np.array([math.cos(math.radians(30)), math.sin(math.radians(30))]) / 4
    rows = [(-0.5, -1, 0.5, -1), (0.5, -1, 0.5, 1), (0.5, 1, -0.5, 1), (-0.5, 1, -0.5, -1), (*-crack, *crack)]
    tables = []
    for x, y in points:
        moved = [complex(x, y + math.copysign(5e-5 * min(k, 8) / 8 + 5e-6 * max(k - 8, 0), y)) * np.exp(0.5j * math.pi * quarter_turns * k / steps)
                 - complex(x, y) for k in range(steps + 1)]
        tables.append(" ".join(f"{k} {z.real:.17g} {z.imag:.17g}" for k, z in enumerate(moved)))
    (folder / "held.geo").write_text("\n".join([
        "1e-6", "5 4", "0", "0", f"{len(points)}", "0", "0", "0", *(" ".join(f"{x:.17g}" for x in row) + " 1" for row in rows),
        *(f"{x} {y} {x} {y}" for x, y in points), ""]))
    (folder / "held.ana").write_text("\n".join([
        f"0 {steps} 1 1 0.05 1 0", " ".join([str(steps + 1)] * len(points)), *tables, "2.6 0 2e10 0.25", "0 0 0", "0 0 0", "0 0 0", "30 0 0",
        "&deck geometry='held.geo', dialect='shi' /", "&method model='nmm', plane='strain', strain='green' /",
        "&cover edge=0.06, origin=0.0137 0.0071 /", "&cracks toughness=9e5 /", "&output every=1, cracks='tips' /", ""]))
    return scree.run(folder / "held.ana", output=folder / f"held{quarter_turns}.h5", timeout=600)


def test_a_plate_that_turns_by_90_degrees_before_and_while_it_cracks_has_the_same_path(tmp_path):
    """Static, held by points that move: the first half of the turn comes before the crack grows, the second as it grows."""
    still, turning = held(tmp_path, 0), held(tmp_path, 1)
    assert still._layouts.count > 4 and still.history.cracks.length[7, 0] == still.history.cracks.length[0, 0]
    assert turning.displacement(-1).max() > 0.5
    assert crack_edges(turning) == pytest.approx(crack_edges(still), abs=1e-6)


def test_a_crack_grows_at_its_strength_and_not_below(tmp_path):
    """The load at which the first piece grows is that at which the mean tension before the tip, linear in the load, is the strength."""
    grown = []
    for share in (0.9, 1.0, 1.1):
        deck = plate(tmp_path, groups="&step balance=1e-6 /", steps=40).read_text()
        (tmp_path / "scene.ana").write_text(deck.replace("strength=2e6", f"strength={share * 4.5e6}"))
        grown.append(scree.run(tmp_path / "scene.ana", timeout=600)._layouts.count > 1)
    assert grown == sorted(grown, reverse=True)


@pytest.mark.parametrize("share, grows", [(0.999, True), (1.001, False)])
def test_a_crack_grows_at_its_toughness_and_not_below(share, grows, tmp_path):
    """The toughness is compared with the intensity of the circumferential stress, of the K that a run without growth writes."""
    r = scree.run(plate(tmp_path, law="toughness=0", steps=4), timeout=600)
    K = r.history.cracks.K_I[-1, 0], r.history.cracks.K_II[-1, 0]
    t = -2 * math.atan2(2 * K[1], K[0] + math.sqrt(K[0]**2 + 8 * K[1]**2))
    hoop = math.cos(t / 2)**2 * (K[0] * math.cos(t / 2) - 3 * K[1] * math.sin(t / 2))
    r = scree.run(plate(tmp_path, law=f"toughness={share * hoop}", steps=4), timeout=600)
    assert (r._layouts.count > 1) == grows


def test_a_crack_that_runs_is_told_and_a_tip_that_ends_has_zeros(tmp_path):
    deck = plate(tmp_path, law=TOUGHNESS, steps=30)
    run = subprocess.run([SCREE, "run", deck, "-o", tmp_path / "x.h5"], capture_output=True, text=True)
    assert "crack tip 1 at (" in run.stdout + run.stderr and "runs: it has grown in each of 10 steps" in run.stdout + run.stderr
    r = scree.read(tmp_path / "x.h5")
    length = r.history.cracks.length[:, 0]
    there = length > 0
    assert there[0] and not there[-1] and (np.diff(length[there]) > 0).sum() > 10
    assert r.history.cracks.place[there][:, 0, 0].max() > 1.8
    assert not r.history.cracks.K_I[~there].any() and not r.history.cracks.place[~there].any()
    pieces = r.growth
    assert (pieces.tip[()] == 1).all() and (np.diff(pieces.time[()]) > 0).all() and np.array_equal(pieces.start[1:], pieces.end[:-1])
    drawn, grown = length[0], np.linalg.norm(pieces.end[()] - pieces.start[()], axis=1)
    assert length[there][-1] == pytest.approx(drawn + grown[:-1].sum(), rel=1e-9) and pieces.end[-1, 0] == pytest.approx(2)


def test_parts_of_cracks_that_have_met_hold_each_other_no_more(tmp_path):
    """One tip meets the other crack, whose own tip is left inside a part. Its last faces held the parts together for good."""
    r = scree.run(SOURCE / "input" / "examples" / "breaking" / "breaking.ana", output=tmp_path / "x.h5", settings=["step.count=80"])
    apart = r.history.time > r.growth.time[-1] + 2e-3
    assert r.bodies.present[-1, :2].all() and apart.sum() > 50
    assert r.history.energy.fracture[-1] > 0 and np.ptp(r.history.energy.fracture[apart]) == 0


@pytest.mark.parametrize("law, half_way, steps, motion", [(STRENGTH, 6, 12, {}), (TOUGHNESS, 6, 12, {}),
                                                          (TOUGHNESS, 70, 76, {"dynamic": True, "dt": 2**-16}),
                                                          (TOUGHNESS, 2, 76, {"dynamic": True, "dt": 2**-16})])
def test_a_run_goes_on_to_the_bit_before_growth_and_in_the_middle_of_it(law, half_way, steps, motion, tmp_path):
    deck = plate(tmp_path, law=law, steps=steps, **motion)
    whole, half = tmp_path / "whole.h5", tmp_path / "half.h5"
    subprocess.run([SCREE, "run", deck, "-o", whole, "--quiet"], check=True)
    subprocess.run([SCREE, "run", deck, "-o", half, "--quiet", "--set", f"step.count={half_way}"], check=True)
    subprocess.run([SCREE, "run", "--restart", half, "-o", half, "--quiet", "--set", f"step.count={steps}"], check=True)
    with h5py.File(whole) as a, h5py.File(half) as b:
        names = []
        a.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        assert "elements/parent" in names
        for name in names:
            if name.split("/")[0] in ("VTKHDF", "elements", "growth", "tips", "history", "bodies", "contacts"):
                assert a[name][()].tobytes() == b[name][()].tobytes(), name


def test_all_frames_are_of_the_elements_of_the_last(tmp_path):
    r = scree.run(plate(tmp_path), timeout=600)
    for frame in (0, 5, -1):
        assert len(r.polygons(frame)) == len(r.stress(frame)) == len(r.block) == r.n_elements
        x, y = (np.concatenate(c) for c in zip(*((p[:, 0] * np.roll(p[:, 1], -1), np.roll(p[:, 0], -1) * p[:, 1])
                                                 for p in r.polygons(frame))))
        assert (x - y).sum() / 2 == pytest.approx(r.bodies.area[frame].sum(), rel=1e-12)
        assert r.present(frame).all()
    assert (r.joints(0) > 0).sum() < (r.joints(-1) > 0).sum()


@pytest.mark.parametrize("change, words", [
    (("model='nmm'", "model='dda'"), "DDA block"),
    ((", length=0.2", ""), "cracks.length"),
    ((STRENGTH, "parts=4"), "cracks.strength or cracks.toughness"),
    ((STRENGTH, TOUGHNESS + " 2e6"), "cracks.toughness"),
    (("&cracks", "&step accuracy=1e-3 /\n&cracks"), "step.accuracy"),
])
def test_what_cracks_cannot_do_is_refused(change, words, tmp_path):
    deck = plate(tmp_path)
    deck.write_text(deck.read_text().replace(*change))
    refused = subprocess.run([SCREE, "run", deck, "-o", tmp_path / "x.h5"], capture_output=True, text=True)
    assert refused.returncode == 2 and words in refused.stderr, refused.stderr


def test_a_mesh_that_is_too_coarse_for_toughness_is_refused(tmp_path):
    deck = plate(tmp_path, law=TOUGHNESS)
    deck.write_text(deck.read_text().replace("edge=0.1", "edge=0.3").replace(", cracks='tips'", ""))
    refused = subprocess.run([SCREE, "run", deck, "-o", tmp_path / "x.h5"], capture_output=True, text=True)
    assert refused.returncode == 2 and "that resolve the crack with cracks.toughness, at least 4 along it" in refused.stderr, refused.stderr


def test_a_crack_of_four_triangles_is_enough_wherever_the_mesh_lies(tmp_path):
    """Nodes that move to the tips stretch the triangles there; the crack is measured in edges of the mesh all the same."""
    square, crack = [(0, 0), (2, 0), (2, 2), (0, 2)], [(0.8, 1.013), (0.8 + 4.2 * 0.12, 1.013)]
    for x in np.linspace(0, 0.12, 8):
        deck = write(tmp_path, square, [crack], f"&cover edge=0.12, origin={x} {x / 3}, angle={300 * x} /\n&cracks toughness=2e6 /")
        subprocess.run([SCREE, "check", deck], check=True, capture_output=True)


def test_files_whose_polygons_cannot_change_are_refused(tmp_path):
    for option in ("--xdmf", "--classic-output"):
        refused = subprocess.run([SCREE, "run", plate(tmp_path), "-o", tmp_path / "x.h5", option], capture_output=True, text=True)
        assert refused.returncode == 2 and option in refused.stderr

def energies(r):
    """Length of the crack after each step, what growth has taken by then, and the change of energy that no row of the books explains."""
    e = r.history.energy
    return r.history.cracks.length[:, 0], e.fracture, e.dissipated - e.fracture - e.friction


def test_a_static_step_under_a_load_that_stays_loses_what_growth_takes(tmp_path):
    """The load is small, so that all is linear: then nothing else is lost. Over triangles whose cuts take more or less than their share
    it is the energy release rate of the tip, times the length by which the crack grows."""
    deck = plate(tmp_path, law="toughness=200", steps=13)
    deck.write_text(deck.read_text().replace("1500000", "150"))
    r = scree.run(deck, timeout=600)
    length, taken, rest = energies(r)
    assert r._layouts.count > 10
    assert np.abs(np.diff(rest)).max() < 1e-6 * r.history.energy.work[-1]
    cracks = r.history.cracks
    rate = (cracks.K_I[:, 0]**2 + cracks.K_II[:, 0]**2) * (1 - 0.25**2) / 2e10
    assert taken[-1] == pytest.approx(((rate[1:] + rate[:-1]) / 2 * np.diff(length)).sum(), rel=0.1)


def test_growth_in_motion_takes_the_energy_of_the_toughness(tmp_path):
    """A plate that a load pulls at from a time on: the crack runs with K = K_Ic, and takes K_Ic^2/E' of each length whatever the step.
    Brittle faces that let go at once would take the less the smaller the step is, and the rest would go into motion. The energy counts
    where a piece has been passed, at the last step before the next."""
    taken = []
    for dt in (5e-6, 2.5e-6):
        deck = plate(tmp_path, law=TOUGHNESS, dynamic=True, dt=dt, steps=round(2e-3 / dt))
        deck.write_text(deck.read_text().replace("1500000", "1000000"))
        length, fracture, _ = energies(scree.run(deck, timeout=600))
        last = int(np.argmax(length >= 1.3)) - 1
        assert last > 0
        taken.append(fracture[last] / (2e6**2 * (1 - 0.25**2) / 2e10 * (length[last] - length[0])))
    assert taken == pytest.approx([1, 1], abs=0.05)
    assert taken[0] == pytest.approx(taken[1], rel=0.03)


def test_growth_loses_what_its_row_counts_in_each_step_that_conserves_energy(tmp_path):
    """Nothing else takes energy while the crack runs: a cut changes none, and its faces let go with the work that the row counts."""
    deck = plate(tmp_path, law=TOUGHNESS, dynamic=True, dt=5e-6, steps=260, groups="&integrator scheme='energy_momentum', beta=0.5 /")
    deck.write_text(deck.read_text().replace("model='nmm'", "model='nmm', strain='green'"))
    length, taken, rest = energies(scree.run(deck, timeout=600))
    runs = int(np.argmax(length > length[0])) - 1
    assert length[-1] > length[0] + 0.4 and taken[-1] > 50
    assert np.abs(np.diff(rest[runs:])).max() < 1e-9 * taken[-1]
