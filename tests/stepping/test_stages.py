"""Stages through the program: what each takes over, removes, holds, loads and says."""
import json

import numpy as np
import pytest
import scree
from scree import call
from scree.block_files import block_file, box, held
from scree.program import TREE

DECKS = TREE / "input" / "validation"
G = 9.81


def scene(folder, blocks, fixed, groups, k01=0, dt=0.01, steps=400, phi=30.0, size=1.0, measured=()):
    """Decks of blocks; the first is ground of material 1, without weight."""
    blocks = [(1 if i == 0 else 2, size * corners) for i, corners in enumerate(blocks)]
    (folder / "x.blk").write_text(block_file("x", blocks, [(size * x, size * y, b) for x, y, b in fixed],
                                             measured=[(size * x, size * y, b) for x, y, b in measured]))
    rock = f"2500 {{}} {1e10 * size} 0.25\n0 0 0  0 0 0  0 0 0\n"
    (folder / "x.ana").write_text(f"{k01} {steps} 2 1 0.05 {dt}\n{rock.format(0)}{rock.format(24525)}{phi} 0 0\n{groups}\n")
    return [folder / "x.blk", folder / "x.ana"]


def run(folder, decks, *settings, name="r.h5", status=0):
    words = [word for setting in settings for word in ("--set", setting)]
    done = call("run", *decks, "-o", folder / name, "--quiet", "--summary", "json", *words)
    assert done.returncode == status, done.stderr
    return json.loads(done.stdout), scree.read(folder / name)


GROUND = box(-2, 3, -1, 0)
TOWER = [GROUND, box(0, 1, 0, 1), box(0, 1, 1, 2)]


@pytest.mark.parametrize("later", ["0 0", "3e3 2e4"])
def test_a_load_point_that_gets_its_force_in_a_stage_is_where_its_block_took_it(later, tmp_path):
    """As one that has had a force of next to nothing all along."""
    ends = []
    for first in ("0 0", "1e-9 0"):
        stage = "&stage kind='dynamic' /\n&loads force={} /\n&step end_time=0.3 /\n"
        blocks = [GROUND, box(0, 1, 5, 6)]
        groups = f"&method strain='green' /\n&loads force={first} /\n" + stage.format(later) + stage.format("1e4 0")
        decks = scene(tmp_path, blocks, held(GROUND, 1), groups, k01=1, steps=30)
        (tmp_path / "x.blk").write_text(block_file("x", [*zip((1, 2), blocks)], held(GROUND, 1), [(0.9, 5.8, 2)]))
        (tmp_path / "x.ana").write_text((tmp_path / "x.ana").read_text().replace("0 0 0\n30.0", "1 2 3\n30.0"))
        _, r = run(tmp_path, decks)
        ends.append([*r.bodies.centroid[-1, 1], r.bodies.rotation[-1, 1]])
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-11)
    assert abs(ends[0][2]) > 0.5


METHODS = ["", "&method strain='green' /", "&method strain='small' /", "&contact method='augmented' /",
           "&method model='nmm' /\n&cover edge={0} /"]


@pytest.mark.parametrize("size, groups", [*((size, groups) for size in (1e-3, 1.0, 1e3) for groups in METHODS),
                                          (1.0, "&method preset='shi' /")])
def test_what_stands_on_a_block_that_is_removed_falls(groups, size, tmp_path):
    """Half g t^2, in scenes of all sizes; its weight, and no more, has gone from the books."""
    second = "&stage remove_blocks=2, kind='dynamic', reset='displacements' /\n&step size={0}, end_time={1} /"
    root = size**0.5
    decks = scene(tmp_path, TOWER, held(GROUND, 1), groups.format(0.6 * size) + "\n&step balance=1e-5 /\n" + second.format(
        0.002 * root, 0.4 * root), size=size, dt=0.01 * root)
    said, r = run(tmp_path, decks)
    fall = r.bodies.centroid[-1, 2, 1] - r.bodies.centroid[np.searchsorted(r.times, r.history.time[r.history.stage == 1][-1]), 2, 1]
    assert -fall == pytest.approx(size * G * 0.4**2 / 2, rel=6e-3)  # Newmark with beta 1 is g t dt/2 ahead or behind
    assert [stage["status"] for stage in said["stages"]] == ["complete", "complete"]
    assert said["stages"][1]["energy_given"] == pytest.approx(-24525 * size**3 / 2, rel=1e-2)
    assert (r.bodies.present[-1] == [1, 0, 1]).all() and (r.bodies.present[0] == 1).all()
    assert r.present().sum() == r.n_elements - (r.block == 2).sum()
    assert (r["VTKHDF/CellData/vtkGhostType"][-r.n_elements:] == np.where(r.block == 2, 32, 0)).all()
    assert np.isin(r.contacts_of(-1).blocks, 2).sum() == 0
    falls = r.history.stage == 2
    falls[r.history.time > r.history.time[falls][0] + 0.35 * root] = False  # it may be near the ground then
    assert falls.sum() > 5 and (r.history.contacts[falls] == 0).all() and (r.history.overlap[falls] == 0).all()


def test_a_stage_that_changes_nothing_leaves_a_static_run_where_it_was(tmp_path):
    """It is in balance from its first step on."""
    said, r = run(tmp_path, scene(tmp_path, TOWER, held(GROUND, 1), "&step balance=1e-6 /\n&stage /"))
    first = r.bodies.centroid[np.searchsorted(r.times, r.history.time[r.history.stage == 1][-1])]
    assert said["status"] == "complete" and said["stages"][1]["steps"] <= 2
    np.testing.assert_allclose(r.bodies.centroid[-1], first, atol=2e-11)
    assert abs(said["stages"][1]["energy_given"]) < 1e-9 * 24525


def test_a_flight_goes_on_over_stages(tmp_path):
    """Velocities go on, with energy; where they are reset they begin at 0."""
    block = box(0, 1, 5, 6)
    groups = "&step end_time=0.2 /\n&stage /\n&stage reset='{}' /"
    for reset, way in (("none", G * 0.6**2 / 2), ("velocities", G * (0.4**2 + 0.2**2) / 2)):
        said, r = run(tmp_path, scene(tmp_path, [GROUND, block], held(GROUND, 1), groups.format(reset), k01=1, dt=1e-3))
        assert r.bodies.centroid[0, 1, 1] - r.bodies.centroid[-1, 1, 1] == pytest.approx(way, rel=3e-3)
        lost = -said["stages"][2]["energy_given"]
        assert lost == pytest.approx(0.0 if reset == "none" else 2500 * (G * 0.4)**2 / 2, rel=3e-3, abs=1e-6 * 24525)
        assert abs(r.history.energy.dissipated[-1]) < 1e-3 * 24525
        np.testing.assert_allclose(r.history.time[-1], 0.6)


def test_a_support_that_is_taken_away_lets_go(tmp_path):
    """Rollers hold a block in the air; it falls when they go, from where it was."""
    block = box(0, 1, 5, 6)
    groups = "&support both=0 5 0 6 /\n&step balance=1e-6 /\n&stage kind='dynamic', reset='displacements' /\n&support both=none /\n&step end_time=0.3, size=1e-3 /"
    _, r = run(tmp_path, scene(tmp_path, [GROUND, block], held(GROUND, 1), groups, measured=[(0.5, 5.5, 2)]))
    assert -r.measured_points.displacement[-1, 0, 1] == pytest.approx(G * 0.3**2 / 2, rel=5e-3)


def test_a_support_that_comes_holds_where_the_block_is(tmp_path):
    """A block that has fallen for a while is stopped there, held by springs or exactly."""
    block = box(0, 1, 5, 6)
    groups = "&step end_time=0.2 /\n&stage kind='static' /\n&support both=0 5 0 6 /\n&step balance=1e-6 /"
    for method in ("exact", "penalty"):
        said, r = run(tmp_path, scene(tmp_path, [GROUND, block], held(GROUND, 1), groups, k01=1, dt=1e-3),
                      f"fixed_points.method={method}")
        end = r.history.time[r.history.stage == 1][-1]
        where = r.bodies.centroid[np.searchsorted(r.times, end), 1, 1]
        assert said["status"] == "complete" and r.bodies.centroid[-1, 1, 1] == pytest.approx(where, abs=1e-4) and where < 5.4


def test_a_table_of_the_deck_goes_on_through_stages(tmp_path):
    """Shi's tables count from the beginning of the run: a support that moves goes on from where it was."""
    blocks = [(1, GROUND), (2, box(0, 1, 5, 6))]
    (tmp_path / "x.blk").write_text(block_file("x", blocks, [*held(GROUND, 1), (0.1, 5.1, 2), (0.9, 5.1, 2)]))
    rock = "2500 {} 1e10 0.25\n0 0 0  0 0 0  0 0 0\n"
    tables = "0 0 0 0 2 2  0 0 0 1 0.5 -0.2  0 0 0 1 0.5 -0.2"
    (tmp_path / "x.ana").write_text(f"1 30 2 1 0.05 0.01 0\n{tables}\n{rock.format(0)}{rock.format(24525)}30 0 0\n"
                                    "&deck dialect='shi' /\n&stage /\n&stage reset='displacements' /\n")
    _, r = run(tmp_path, [tmp_path / "x.blk", tmp_path / "x.ana"])
    np.testing.assert_allclose(r.bodies.centroid[-1, 1] - r.bodies.centroid[0, 1], 0.9 * np.array([0.5, -0.2]), atol=1e-6)
    np.testing.assert_allclose(r.displacement()[4:].mean(axis=0), 0.3 * np.array([0.5, -0.2]), atol=1e-6)


def test_ramps_are_of_their_stage(tmp_path):
    """The weight that has grown stays; a pressure that comes later grows then."""
    groups = "&gravity ramp=0.1 /\n&step balance=1e-6 /\n&stage /\n&boundary lines=0 2 1 2, pressure=1e5 1e5, ramp=0.05 /"
    said, r = run(tmp_path, scene(tmp_path, TOWER, held(GROUND, 1), groups))
    assert said["status"] == "complete"
    second = np.flatnonzero(r.history.stage == 2)
    assert r.history.time[second[-1]] - r.history.time[second[0] - 1] >= 0.05
    contacts = r.contacts_of(-1)
    foot = (contacts.blocks == 1).any(axis=1)
    assert np.abs(contacts.force[foot, 0]).sum() == pytest.approx(2 * 24525 + 1e5, rel=1e-4)


def test_stages_are_in_the_results_and_told(tmp_path):
    decks = [DECKS / "s4-bolted-later" / "bolted.ana"]
    done = call("run", *decks, "-o", tmp_path / "r.h5")
    assert done.returncode == 0 and "warning: moves: stage 3 (weaker still): block 2 at (" in done.stderr
    for words in ("stage 1 of 3, static, from time 0", "stage 2 (weaker, bolted) of 3, static, from time",
                  "stage 3 (weaker still): static, moves, ", "ended: moves at time"):
        assert words in done.stdout
    r = scree.read(tmp_path / "r.h5")
    assert list(r.stages.name) == ["stage 1", "weaker, bolted", "weaker still"] and list(r.stages.kind) == ["static"] * 3
    assert (np.diff(r.history.stage) >= 0).all() and (np.diff(r.history.time) > 0).all() and (np.diff(r.times) > 0).all()
    assert any(line.startswith("joints.phi = 15") for line in r.stages.settings_3)
    assert r.bolts.state[0, 0] == 3 and r.bolts.force[0, 0] == 0 and r.bolts.state[-1, 0] == 1
    lines = call("check", *decks).stdout
    assert "stage 2 (weaker, bolted): static; joints.phi = 20; bolts.ends = 0.5" in lines


def test_the_command_line_gives_settings_of_a_stage(tmp_path):
    deck = [DECKS / "s4-bolted-later" / "unbolted.ana"]
    said, _ = run(tmp_path, deck, "stage(2).joints.phi=31", "stage(3).joints.phi=29")
    assert said["status"].startswith("moves: stage 3") and [s["status"] for s in said["stages"]] == ["complete", "complete", "moves"]
    said, _ = run(tmp_path, deck, "joints.phi=31")
    assert said["status"] == "complete"


@pytest.mark.parametrize("size, far", [(1e-3, 0.0), (1.0, 0.0), (1e3, 0.0), (1.0, 1e6)])
def test_blocks_in_polygons_are_removed_as_by_their_numbers(size, far, tmp_path):
    """The same bits. The sides of the polygons are those of the blocks; a trough around a block has its centroid in that, and stays. A
    polygon in another, either way round, is a hole of it."""
    trough = np.array([(-1.0, 0), (2, 0), (2, 3), (1.5, 3), (1.5, 0.25), (-0.5, 0.25), (-0.5, 3), (-1, 3)])
    blocks = [GROUND, trough, box(0, 1, 0.25, 1.25), box(0, 1, 1.25, 2.25)]
    square, upper = ("0 0.25  1 0.25  1 2.25  0 2.25  0 0.25", "0 1.25  0 2.25  1 2.25  1 1.25  0 1.25")

    def placed(words):
        return " ".join(str(float(word) * size + far) for word in words.split())

    found = {}
    for name, removal in (("number", "remove_blocks=3"), ("polygon", f"remove_inside={placed(square + ' ' + upper)}"),
                          ("numbers", "remove_blocks=3 4"), ("polygons", f"remove_inside={placed(square)}")):
        moved = [np.asarray(corners) + far / size for corners in blocks]
        decks = scene(tmp_path, moved, [(x + far / size, y + far / size, b) for x, y, b in held(GROUND, 1)], "&step balance=1e-5 /\n"
                      f"&stage {removal}, kind='dynamic' /\n&step size={0.002 * size**0.5}, count=10 /", size=size, dt=0.01 * size**0.5)
        found[name] = run(tmp_path, decks, name=f"{name}.h5")[1]
    for one, other, gone in (("number", "polygon", [2]), ("numbers", "polygons", [2, 3])):
        a, b = found[one], found[other]
        assert np.flatnonzero(b.bodies.present[-1] == 0).tolist() == gone and (a.bodies.present == b.bodies.present).all()
        assert a.vertices(-1).tobytes() == b.vertices(-1).tobytes()


BAD = {
    "corners that are not closed": ("&stage remove_inside=0 0 1 0 1 1 0 1 /", "its first again"),
    "two corners": ("&stage remove_inside=0 0 1 0 0 0 /", "three or more of each"),
    "an odd number": ("&stage remove_inside=0 0 1 0 1 1 0 0 5 /", "expected x y of corners"),
    "sides that cross": ("&stage remove_inside=0 0 1 1 1 0 0 1 0 0 /", "whose sides do not cross"),
    "a polygon in the air": ("&stage remove_inside=5 5 6 5 6 6 5 5 /", "expected blocks in the polygons of stage.remove_inside, found none"),
    "a setting that makes blocks": ("&method strain='green' /", "before the first &stage"),
    "a block that there is not": ("&stage remove_blocks=4 /", "expected numbers of blocks from 1 to 3 in stage.remove_blocks, found 4"),
    "a half block": ("&stage remove_blocks=1.5 /", "found 1.5"),
    "a material that there is not": ("&stage remove_materials=3 /", "block materials from 1 to 2"),
    "everything": ("&stage remove_blocks=1 2 3 /", "expected a stage that leaves a block"),
    "no joint materials": ("&joints phi=1 2 /", "expected joints.phi with 1 numbers, one for each joint material, found 2"),
    "a support beside all edges": ("&support x=7 7 8 8 /", "expected lines that edges of blocks lie on in support.x"),
    "what goes with nothing": ("&bolts stiffness=1 /", "only with bolts.ends"),
    "balance of what moves": ("&stage kind='dynamic' /\n&step balance=1e-3 /", "only with k01 0"),
    "a name twice": ("&stage name='dug' /\n&stage name='dug' /", "expected another name of a stage than that of stage 3, found 'dug'"),
    "the name of a number": ("&stage name='stage 2' /", "expected another name of a stage than that of stage 2"),
    "a group twice": ("&joints phi=1 /\n&joints phi=2 /", "each group once, or once in each stage"),
    "a kind that is none": ("&stage kind='slow' /", "one of dynamic, static"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_stage_is_refused_in_a_line_before_the_run(name, tmp_path):
    groups, expected = BAD[name]
    decks = scene(tmp_path, TOWER, held(GROUND, 1), "&step balance=1e-6 /\n&stage /\n" + groups)
    for verb in (("run", "-o", tmp_path / "r.h5"), ("check",)):
        done = call(verb[0], *decks, *verb[1:], "--quiet")
        assert done.returncode == 2 and expected in done.stderr, done.stderr
        assert len(done.stderr.splitlines()) == 1 and "x.ana:" in done.stderr
    assert not (tmp_path / "r.h5").exists()


@pytest.mark.parametrize("option", ["stage(4).joints.phi=3", "stage(x).joints.phi=3", "stage.name=x", "stage(2).stage.kind=static"])
def test_a_stage_that_there_is_not_is_refused_on_the_command_line(option):
    done = call("check", DECKS / "s4-bolted-later" / "unbolted.ana", "--set", option)
    assert done.returncode == 2 and f"--set {option}: expected a s" in done.stderr


@pytest.mark.parametrize("first, second, stiffness", [("&contact stiffness=1e9 /", "&contact stiffness=1e10 /", 2e10),
                                                      ("&joints kn=1e8 1e8 /", "&joints kn=1e9 1e9 /", 1e9)])
@pytest.mark.parametrize("cohesion", [0, 1e3])
def test_closed_contacts_have_the_stiffness_of_the_stage(first, second, stiffness, cohesion, tmp_path):
    """A block of weight W sinks by W/k of each stage; what its springs hold then is in the books. A second joint material has cohesion, that
    touches nothing."""
    decks = scene(tmp_path, TOWER[:2], held(GROUND, 1), f"{first}\n&stage name='b' /\n{second}", steps=60)
    (tmp_path / "x.ana").write_text((tmp_path / "x.ana").read_text().replace("60 2 1 0.05", "60 2 2 0.05").replace("30.0 0 0\n", f"30.0 0 0\n30.0 {cohesion} 0\n"))
    _, r = run(tmp_path, decks)
    overlap = r.history.overlap
    assert overlap[-1] == pytest.approx(24525 / stiffness, rel=1e-3) and overlap[59] == pytest.approx(10 * overlap[-1], rel=1e-3)
    assert r.history.energy.stages[-1] == pytest.approx(9 * 24525 * overlap[59] / 2, rel=1e-2)
    assert np.diff(r.history.energy.dissipated).min() > -1e-9 * 24525


@pytest.mark.parametrize("second", ["kn=none", "kn=7.1e9, ks=7.1e9"])
def test_bonds_of_all_lengths_share_a_load_where_a_stage_changes_their_stiffness(second, tmp_path):
    """A block 3 wide hangs from one 0.5 wide and one 2.5: their bonds bear 250 and 1250 of 3000 each, before and after."""
    blocks = [box(0, 0.5, 0, 1), box(0.5, 3, 0, 1), box(0, 3, -1, 0)]
    decks = scene(tmp_path, blocks, [*held(blocks[0], 1), *held(blocks[1], 2)],
                  f"&joints kn=7e9, ks=7e9 /\n&step balance=1e-7 /\n&stage name='b' /\n&joints {second}{', ks=none' * (second == 'kn=none')} /", steps=300)
    (tmp_path / "x.ana").write_text((tmp_path / "x.ana").read_text().replace("30.0 0 0\n", f"30.0 1e6 {24525 / 0.9}\n"))
    said, r = run(tmp_path, decks)
    assert said["status"] == "complete"
    contacts = r.contacts_of(-1)
    for hanger, width in ((1, 0.5), (2, 2.5)):
        of_it = (contacts.blocks == hanger).any(axis=1) & (contacts.blocks == 3).any(axis=1)
        assert contacts.force[of_it, 0].sum() == pytest.approx(-24525 * width, rel=1e-2)


@pytest.mark.parametrize("first, second", [("closure=2e-4", "closure=1.2e-4"), ("kn=1e8, ks=1e8", "kn=1e8, ks=1e9")])
def test_what_springs_hold_as_a_stage_changes_them_is_in_the_books(first, second, tmp_path):
    """A block at rest under a push along: nothing dissipates less than nothing, and what its springs hold more is the stage's."""
    decks = scene(tmp_path, TOWER[:2], held(GROUND, 1), f"&joints {first}{', kn=1e8, ks=1e8' * ('kn' not in first)} /\n"
                  "&acceleration table=0 -2 0  0.1 -2 0 /\n&step balance=1e-6 /\n"
                  f"&stage name='b', kind='dynamic' /\n&joints {second} /\n&step size=1e-4, count=50 /", steps=200)
    said, r = run(tmp_path, decks)
    energy, held_more = r.history.energy, r.history.energy.stages[-1]
    assert said["status"] == "complete" and len(said["stages"]) == 2
    assert np.diff(energy.dissipated).min() > -1e-9 * 24525 and held_more > 1e-6 * energy.contact[-1]


def test_bonds_stay_as_stiff_where_a_stage_takes_their_strength(tmp_path):
    """A block on feet of 0.2 and 2.8, bonded, stays where it is when they are no longer."""
    blocks = [GROUND, box(0, 0.2, 0, 1), box(0.2, 3, 0, 1), box(0, 3, 1, 2)]
    decks = scene(tmp_path, blocks, [*held(GROUND, 1), *held(blocks[1], 2), *held(blocks[2], 3)],
                  "&stage name='b', kind='dynamic' /\n&joints cohesion=0, tensile_strength=0 /\n&step end_time=0.1 /", steps=60, measured=[(1.5, 1.5, 4)])
    (tmp_path / "x.ana").write_text((tmp_path / "x.ana").read_text().replace("30.0 0 0\n", "30.0 1e6 1e6\n"))
    _, r = run(tmp_path, decks)
    u = r.measured_points.displacement[:, 0]
    assert np.ptp(u[-1] - u[60]) < 1e-12 and np.diff(r.history.energy.dissipated).min() > -1e-9 * 24525


@pytest.mark.parametrize("start", ["zero", "dissipative", "acceleration", "consistent"])
def test_a_stack_rests_on_whatever_a_stage_starts_with(start, tmp_path):
    """Its contacts count: without them what was in balance sprang up, and of -62.5 kPa -8.4 were left after a step."""
    groups = f"&integrator scheme='newmark', start='{start}' /\n&damping mass=20 /\n&output every=1 /\n&step sleep=0 /\n&stage name='b' /\n&step end_time=0.1 /"
    decks = scene(tmp_path, TOWER, held(GROUND, 1), groups, k01=1, dt=0.002, steps=400)
    _, r = run(tmp_path, decks)
    stress = r.bodies.stress[:, 1, 1]
    assert stress[400] == pytest.approx(-1.5 * 24525, rel=1e-3)
    np.testing.assert_allclose(stress[401:], stress[400], rtol=1e-3)
    assert r.history.energy.kinetic[400:].max() < 1e-6


def test_the_error_of_a_run_and_its_fall_go_on_through_stages(tmp_path):
    """A square on a pin. Each stage began with nothing off: five said 4.9e-5 of 2.1e-4 m, and 15.9 kJ given for 8.8."""
    corners = np.array([(0, 0), (0.2588190451, -0.9659258263), (1.2247448714, -0.7071067812), (0.9659258263, 0.2588190451)])
    (tmp_path / "p.blk").write_text(block_file("pendulum", [(1, corners)], [(0, 0, 1)]))

    def swing(name, steps, dt, groups=""):
        (tmp_path / "p.ana").write_text(f"1 {steps} 1 1 0.05 {dt}\n2500 25000 5e9 0.2 {'0 ' * 9}\n30 0 0\n&deck dialect='short' /\n"
                                        f"&output error='estimate' /\n{groups}")
        return run(tmp_path, [tmp_path / "p.blk", tmp_path / "p.ana"], name=name)

    said, one = swing("1.h5", 200, 0.01)
    said_five, five = swing("5.h5", 40, 0.01, "".join(f"&stage name='{n}' /\n" for n in "bcde"))
    _, truth = swing("t.h5", 8000, 2.5e-4)
    for r in (one, five):
        off = np.linalg.norm(r.bodies.centroid[-1, 0] - truth.bodies.centroid[-1, 0])
        assert 0.6 * off < r.history.error.displacement[-1] < 1.6 * off
    assert said_five["energy"]["given"] == pytest.approx(said["energy"]["given"], rel=1e-3)
    assert said_five["energy"]["fallen"] == pytest.approx(said["energy"]["fallen"], rel=1e-3)


def test_a_stage_with_a_count_of_steps_makes_them(tmp_path):
    """Beyond n5, whose steps were the end of it without a word."""
    groups = "&stage kind='dynamic', remove_blocks=3 /\n&step size=0.001, count=30 /"
    summary, r = run(tmp_path, scene(tmp_path, TOWER, held(GROUND, 1), groups, k01=1, dt=0.002, steps=10))
    assert r.history.time.size == 40 and r.history.time[-1] == pytest.approx(0.05)
    np.testing.assert_allclose(r.history.area[[0, 9, 10, -1]], [7, 7, 6, 6], rtol=1e-6)


@pytest.mark.parametrize("deep", [0, 1e-6, 0.01, 0.15])
def test_what_overlaps_a_block_that_is_removed_falls(deep, tmp_path):
    """Behind its edges from the start: contacts with what was gone held it after 3 cm, or at once, in runs that ended complete."""
    blocks = [box(-1, 3, -0.5, 0), box(0, 1, -deep, 1 - deep), box(1.5, 2.5, 0, 1)]
    groups = "&contact initial=0.5 /\n&stage kind='dynamic', remove_blocks=1 /\n&step end_time=0.3 /"
    _, r = run(tmp_path, scene(tmp_path, blocks, held(blocks[0], 1), groups, k01=1, dt=0.005, steps=20))
    assert r.bodies.centroid[-1, 1, 1] - r.bodies.centroid[0, 1, 1] == pytest.approx(-0.5 * G * 0.3**2, rel=0.03)


def test_a_support_holds_where_the_block_is_whatever_held_it_there_the_other_way(tmp_path):
    """It goes 0.01 along a line that holds it across; a stage holds it both ways: that brought it back to where it began."""
    (tmp_path / "x.blk").write_text(block_file("x", [(1, box(0, 1, 0, 1))], []))
    (tmp_path / "x.ana").write_text(f"1 10 1 1 0.05 0.01\n2500 25000 1e9 0.2 {'0 ' * 6} 0.1 0 0\n30 0 0\n&deck dialect='short' /\n"
                                    "&support normal=0 0 1 0 /\n&stage kind='static' /\n&support normal=none, both=0 0 1 0 /\n"
                                    "&step balance=1e-6, size=0.01, count=100 /\n")
    _, r = run(tmp_path, [tmp_path / "x.blk", tmp_path / "x.ana"])
    assert r.bodies.centroid[-1, 0, 0] == pytest.approx(0.51, abs=1e-4)


@pytest.mark.parametrize("kind, fixed", [("static", "exact"), ("dynamic", "exact"), ("dynamic", "penalty")])
def test_supports_of_what_is_removed_are_gone_with_it(kind, fixed, tmp_path):
    """Their table goes on to time 10: no stage came to rest before, and springs stretched on, until a run was stopped as energy came from nothing."""
    blocks = [(1, box(0, 1, 5, 6)), (1, GROUND), (1, box(0, 1, 0, 1))]
    points = held(blocks[0][1], 1) + held(GROUND, 2)
    (tmp_path / "x.blk").write_text(block_file("x", blocks, points))
    tables = "\n".join("0 0 0\n10 0 5" for _ in range(4))
    step = "&step balance=1e-6, size=0.01, count=100 /" if kind == "static" else "&step size=0.005, end_time=0.2 /"
    (tmp_path / "x.ana").write_text(f"1 20 1 1 0.05 0.005\n0\n2 2 2 2 0 0 0 0\n{tables}\n2500 25000 1e9 0.2\n0 0 0\n0 0 0\n0 0 0\n30 0 0\n"
                                    f"&deck dialect='shi' /\n&fixed_points method='{fixed}' /\n&stage kind='{kind}', remove_blocks=1 /\n{step}\n")
    summary, r = run(tmp_path, [tmp_path / "x.blk", tmp_path / "x.ana"])
    assert summary["status"] == "complete"
    if fixed == "penalty":
        assert r.history.energy.fixed_springs[-1] < 1
