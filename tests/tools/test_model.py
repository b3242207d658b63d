"""Models by words: decks are read and written without loss, results know names, numbers are those of closed forms, errors name the argument."""
import concurrent.futures
import math
import os
import pathlib
import re

import h5py
import numpy as np
import pytest
import scree
from scree.errors import ModelError, ResultsError
from scree.model.geometry import clipped
from scree.model.rock import JOINT_LAWS
from scree.model.shapes import voronoi_lines
from scree.model.text import NUMBER, as_number, number_text

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
INPUT = SOURCE / "input"
DECKS = sorted(INPUT.rglob("*.ana"))
STEPS = 2  # of each stage


def explained(deck, folder):
    """What the program says of a deck, without files and lines."""
    said = scree.call("explain", deck, cwd=folder)
    assert said.returncode == 0, said.stderr
    lines = [line.split("  (")[0] for line in said.stdout.splitlines()
             if not line.startswith(("geometry:", "analysis:", "  deck.", "  cover.mesh", "  acceleration.file"))]
    return [" ".join(str(float(as_number(word))) if NUMBER.match(word) else word for word in line.replace(";", " ").split()) for line in lines]


def bits_of_run(deck, steps, output):
    """The bytes of all datasets of a run that do not name its files or its cost."""
    found, run = {}, scree.run(deck, output=output, set=steps)
    with h5py.File(run.path) as f:
        f.visititems(lambda name, item: found.update({name: item[()].tobytes()}) if isinstance(item, h5py.Dataset) and
                     name.split("/")[0] not in ("cost", "scene", "ending", "checkpoint") and "settings" not in name else None)
    return found


@pytest.mark.parametrize("deck", DECKS, ids=[str(deck.relative_to(INPUT)) for deck in DECKS])
def test_every_deck_is_read_and_written_without_loss_and_runs_to_the_same_bits(deck, tmp_path):
    model = scree.Model.read(deck)
    first = model.save(tmp_path / deck.name)
    (tmp_path / "again").mkdir()
    second = scree.Model.read(first).save(tmp_path / "again" / deck.name)
    ending = model.geometry.ending
    assert first.read_text() == second.read_text()
    assert first.with_suffix(ending).read_text() == second.with_suffix(ending).read_text()
    steps = {f"stage({k}).step.count" if k > 1 else "step.count": STEPS for k in range(1, len(model.parts) + 1)}
    with concurrent.futures.ThreadPoolExecutor() as pool:
        before, after = pool.map(explained, (deck, first), (tmp_path, tmp_path))
        of_deck, of_model = pool.map(bits_of_run, (deck, first), (steps, steps), (tmp_path / "deck.h5", tmp_path / "model.h5"))
    assert sorted(before) == sorted(after)  # groups of a geometry stand in the analysis now
    assert len(of_deck) > 20 and of_deck == of_model


CLASSIC = [(deck, geometry) for deck in sorted((SOURCE / "tests" / "data" / "classic").glob("*.ana"))
           for geometry in deck.parent.glob("*.geo") if deck.stem.split("_")[0] == geometry.stem]


@pytest.mark.parametrize(("deck", "geometry"), CLASSIC, ids=[deck.name for deck, _ in CLASSIC])
def test_decks_of_numbers_alone_are_read_with_their_geometry(deck, geometry, tmp_path):
    saved = scree.Model.read(deck, geometry).save(tmp_path / deck.name)
    (first, second) = (scree.call("explain", *one) for one in ((geometry, deck), (saved,)))
    assert first.returncode == second.returncode == 0
    numbers = [[line for line in done.stdout.partition("\nsettings\n")[0].splitlines() if not line.startswith(("geometry:", "analysis:"))]
               for done in (first, second)]
    assert numbers[0] == numbers[1]


@pytest.mark.parametrize("value", [0, 1, -3, 0.1, 1e-4, 2e7, 1e10, 123456.789, -1e-20, 1 / 3, 2.5e5, 100000, 1e20])
def test_numbers_keep_all_their_bits(value):
    assert float(number_text(value)) == value and type(value)(number_text(value) if isinstance(value, float) else value) == value


def slope():
    """A model with all that has a name."""
    m = scree.Model("slope", title="A slope.\nIn two lines.")
    m.material("rock", density=2600, young=1e10)
    m.material("fill", density=2000, young=1e9, poisson=0.3)
    m.joint_material("bedding", phi=38)
    m.joint_material("steep", phi=38, cohesion=1e4, kn=1e10)
    m.rock([(0, 0), (40, 0), (40, 18), (21, 18), (14, 4), (0, 4)], "rock", name="outline")
    m.joint_set("bedding", dip=33, spacing=2.5, length=100, randomness=0.4, seed=12)
    m.joint_set("steep", dip=-60, spacing=3, length=8, bridge=1, randomness=0.4, seed=12)
    m.excavation("niche", [(34, 14), (38, 14), (38, 16), (34, 16)], material="steep")
    m.region([(30, 10), (40, 10), (40, 18), (30, 18)], "fill")
    m.support("floor", [(0, 0), (40, 0)])
    m.support("sides", [(0, 0), (0, 4)], hold="normal")
    m.support("sides", [(40, 0), (40, 18)], hold="normal")
    m.load("crest", [(22, 18), (26, 18)], pressure=[1e4, 2e4])
    m.bolt("anchor", (16, 8), (24, 6), stiffness=2e7)
    m.measure("toe", (15, 5))
    m.static()
    m.stage("dug")
    m.excavate("niche")
    m.bolt_row("row", [(17, 10), (20, 16)], count=3, length=8, angle=-20, stiffness=1e7, strength=2e5)
    m.remove("crest")
    m.stage("wet", kind="dynamic")
    m.dynamic(time=0.1)
    m.joint_material("steep", phi=30)
    m.material("fill", young=2e9)
    m.water([(0, 5), (40, 12)])
    return m


def test_a_model_of_words_is_read_back_with_its_names(tmp_path):
    first = slope().save(tmp_path / "slope.ana")
    model = scree.Model.read(first)
    (tmp_path / "again").mkdir()
    second = model.save(tmp_path / "again" / "slope.ana")
    assert first.read_text() == second.read_text()
    assert first.with_suffix(".geo").read_text() == second.with_suffix(".geo").read_text()
    assert list(model.materials) == ["rock", "fill"] and list(model.joint_materials) == ["bedding", "steep"]
    assert {row.name for row in model.geometry.joints} == {"bedding", "steep", "niche"}
    assert model.title == "A slope.\nIn two lines." and model.units.words == "m kg s" and model.gravity == 9.81
    assert model["joints.phi"] == [38, 30] and model["materials.young"] == [1e10, 2e9] and model["joints.kn"] == [0, 1e10]
    assert [row["name"] for row in model._rows("bolts.ends")] == ["anchor", "row", "row", "row"]
    assert model.until(0)._rows("boundary.lines")[0]["pressure"] == (1e4, 2e4) and model._rows("boundary.lines") == []
    assert "40 blocks" not in model.check()


def test_regions_give_their_blocks_their_material(tmp_path):
    m = slope()
    r = scree.run(m.save(tmp_path / "m.ana"), output=tmp_path / "m.h5", set={"stage(2).step.count": 1})
    for polygon, material in zip(r.polygons(0), r.material):
        (x, y), whole = polygon.mean(0), polygon
        if (whole[:, 0] > 30).all() and (whole[:, 1] > 10).all():
            assert material == 2
        if x < 30 and y < 10:
            assert material == 1


def incline(angle, phi, cohesion=0.0):
    """A block of 1 m on a wedge with a slope of an angle in degrees."""
    m = scree.Model("incline")
    m.material("rock", density=2500, young=1e9)
    m.joint_material("plane", phi=phi, cohesion=cohesion)
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    m.block("wedge", [(0, 0), (10, 0), (10, 10 * s / c)])
    corners = [(5, 0), (6, 0), (6, 1), (5, 1)]
    m.block("block", [(x * c - y * s, x * s + y * c) for x, y in corners])
    m.fix("wedge", block="wedge")
    return m


def test_a_block_on_an_incline_slides_as_by_hand(tmp_path):
    m = incline(30, 20)
    m.measure("middle", tuple(np.array([5.5 * math.cos(math.pi / 6) - 0.5 * 0.5, 5.5 * 0.5 + 0.5 * math.cos(math.pi / 6)])))
    m.dynamic(time=0.5, size=0.005)
    m["gravity.ramp"] = 0.05
    r = m.run(tmp_path / "slide.h5")
    a = 9.81 * (0.5 - math.cos(math.pi / 6) * math.tan(math.radians(20)))
    begins = 0.05 * math.cos(math.pi / 6) * math.tan(math.radians(20)) / 0.5  # friction grows with the weight, so it slides at once
    assert begins < 0.05
    way = a * (0.5 - 0.05) ** 2 / 2 + a * 0.05 / 2 * (0.5 - 0.05) + a * 0.05 ** 2 / 6
    joint = r.joint("plane")
    assert np.linalg.norm(r.measured_points.displacement[-1, 0]) == pytest.approx(way, rel=0.01)
    assert joint.slip == pytest.approx([way], rel=0.01)
    assert joint.shear_force == pytest.approx(math.tan(math.radians(20)) * joint.normal_force, rel=1e-6)
    assert joint.normal_force == pytest.approx(2500 * 9.81 * math.cos(math.pi / 6), rel=0.01)


def test_the_factor_of_an_incline_and_its_reaction(tmp_path):
    m = incline(30, 40)
    m.static()
    factor = scree.fs(m, joints=["plane"], folder=tmp_path / "fs")
    true = math.tan(math.radians(40)) / math.tan(math.radians(30))
    assert factor.stands <= true * 1.001 and factor.falls >= true * 0.999 and float(factor) == pytest.approx(true, rel=0.004)
    assert factor.mechanism.scene.status.startswith("moves")
    falls = m.run(tmp_path / "falls.h5", set={"joint(plane).phi": 25, "material(rock).density": 2400})
    assert falls.scene.status.startswith("moves")
    r = m.run(tmp_path / "stands.h5")
    weight = 2500 * 9.81 * (1 + 50 * math.tan(math.pi / 6))
    assert r.support("wedge").reaction == pytest.approx([0, weight], rel=1e-4, abs=1e-3 * weight)


def test_lithostatic_stress_with_k0(tmp_path):
    m = scree.Model("ground", units="m t s")
    m.material("soil", density=2, young=1e5)
    m.joint_material("bedding", phi=30)
    m.rock([(0, -10), (8, -10), (8, 0), (0, 0)])
    for y in range(-9, 0):
        m.joint("bedding", [(0, y), (8, y)])
    m.in_situ(surface=0, k0=0.6)
    m.support("bottom", [(0, -10), (8, -10)], hold="normal")
    m.support("left", [(0, -10), (0, 0)], hold="normal")
    m.support("right", [(8, -10), (8, 0)], hold="normal")
    m.static()
    r = m.run(tmp_path / "k0.h5")
    line = r.line((4, 0), (4, -10), count=10)  # middles of the beds
    assert line.distance == pytest.approx(np.arange(10) + 0.5)
    assert line.stress[:, 1] == pytest.approx(-2 * 9.81 * line.distance, rel=1e-9)  # joints begin with the stress
    assert line.stress[:, 0] == pytest.approx(0.6 * line.stress[:, 1], rel=1e-9)
    assert r.support("bottom").reaction == pytest.approx([0, 2 * 9.81 * 80], rel=1e-3, abs=1)
    assert r.support("left").reaction[0] == pytest.approx(0.6 * 2 * 9.81 * 50, rel=1e-2)
    assert np.abs(r.closure((0, -5), (8, -5))).max() < 1e-9


def test_bolts_of_stages_are_found_by_name(tmp_path):
    m = scree.Model("hung")
    m.material("rock", density=2000, young=1e9)
    m.joint_material("gap", phi=0)
    m.block("roof", [(0, 2), (4, 2), (4, 3), (0, 3)])
    m.block("slab", [(0.5, 1), (3.5, 1), (3.5, 2), (0.5, 2)])
    m.fix("roof", block="roof")
    m.bolt("first", (1, 1.5), (1, 2.5), stiffness=1e7)
    m.bolt("first", (3, 1.5), (3, 2.5), stiffness=1e7)
    m.static()
    m.stage("more")
    m.bolt("second", (2, 1.5), (2, 2.5), stiffness=1e7)
    m.stage("less")
    m.remove("first")
    m.bolt("third", (1, 1.4), (1, 2.5), stiffness=1e7)
    m.bolt("third", (3, 1.4), (3, 2.5), stiffness=1e7)
    r = m.run(tmp_path / "hung.h5")
    weight = 2000 * 9.81 * 3
    of_stage = [int(np.flatnonzero(r.frame_stages == k)[-1]) for k in (1, 2, 3)]
    assert r.bolt("first", of_stage[0]).force == pytest.approx([weight / 2] * 2, rel=1e-3)
    assert list(r.bolt("second", of_stage[0]).state) == [3] and list(r.bolt("first").state) == [3, 3]
    assert r.bolt("second").force.sum() + r.bolt("third").force.sum() == pytest.approx(weight, rel=1e-3)
    assert r.support("roof", of_stage[0]).reaction == pytest.approx([0, weight + 2000 * 9.81 * 4], rel=1e-3, abs=1)


def test_closure_of_blocks_that_come_together(tmp_path):
    m = scree.Model("press")
    m.material("plate", density=1000, young=1e10, unit_weight=0)
    m.joint_material("contact", phi=30)
    m.block("low", [(0, 0), (2, 0), (2, 1), (0, 1)])
    m.block("high", [(0, 3), (2, 3), (2, 4), (0, 4)])
    m.fix("low", block="low")
    m.fix("high", block="high", move=[(0, 0, 0), (1, 0, -0.25)])
    m.measure("head", (1, 3.5))
    m.static(balance=None, steps=100)
    r = m.run(tmp_path / "press.h5")
    assert r.closure((1, 0.5), "head") == pytest.approx(0.25 * r.times, abs=1e-9)


def test_a_mixed_model_digs_blocks_by_name(tmp_path):
    m = incline(30, 40)
    m.static()
    m.stage("dug")
    m.excavate("block")
    r = m.run(tmp_path / "dug.h5")
    assert list(r.present(-1)) == [True, False] and r.stage_names[-1] == "dug"
    assert len(r.joint("plane").slip) == 0 and len(r.joint("plane", 0).slip) == 1


def test_lines_are_clipped_to_rock():
    square, hole = [(0, 0), (4, 0), (4, 4), (0, 4)], [(1, 1), (3, 1), (3, 3), (1, 3)]
    assert clipped((-1, 2), (5, 2), [square]) == [((0, 2), (4, 2))]
    assert clipped((0.5, 2), (3.5, 2), [square]) == [((0.5, 2), (3.5, 2))]
    assert clipped((0, 2), (4, 2), [hole], inside=False) == [((0, 2), (1, 2)), ((3, 2), (4, 2))]
    assert clipped((5, 5), (6, 6), [square]) == []


def test_grains_fill_their_polygon(tmp_path):
    size = 0.2
    m = scree.Model("grains")
    m.material("rock", density=2600, young=1e10)
    m.joint_material("grain", phi=30)
    m.rock([(0, 0), (2, 0), (2, 1), (0, 1)])
    m.voronoi("grain", size, randomness=0)
    scree.cut(m.save(tmp_path / "g.ana"), output=tmp_path / "g.h5")
    r = scree.read(tmp_path / "g.h5")
    areas = r.bodies.area[0]
    assert areas.sum() == pytest.approx(2) and np.median(areas) == pytest.approx(size ** 2 * math.sqrt(3) / 2, rel=1e-6)
    rough = scree.Model("rough")
    rough.material("rock", density=2600, young=1e10)
    rough.joint_material("grain", phi=30)
    rough.rock([(0, 0), (2, 0), (2, 1), (0, 1)])
    rough.voronoi("grain", size / 2, randomness=1, seed=5)
    scree.cut(rough.save(tmp_path / "r.ana"), output=tmp_path / "r.h5")
    grains = scree.read(tmp_path / "r.h5").polygons(0)
    inner = [one for one in grains if (one > 0.01).all() and (one < [1.99, 0.99]).all()]
    for one in inner:  # each is convex, as a grain with a side that is missing is not
        side = np.roll(one, -1, axis=0) - one
        after = np.roll(side, -1, axis=0)
        assert (side[:, 0] * after[:, 1] - side[:, 1] * after[:, 0] > -1e-6 * size ** 2).all()
    assert len(inner) > 150 and len(grains) == pytest.approx(2 / ((size / 2) ** 2 * math.sqrt(3) / 2), rel=0.25)
    first, again, other = (voronoi_lines([[(0, 0), (1, 0), (1, 1)]], size, 1, seed) for seed in (1, 1, 2))
    assert first == again != other


def test_functions_of_the_tools(tmp_path):
    m = incline(30, 40)
    m.dynamic(time=0.05, size=0.005)
    m["output.every"] = 2
    r = m.run(tmp_path / "i.h5")
    axes = scree.plot(r, joints="state", vectors="velocity")
    assert axes.get_xlabel() == "x [m]" and axes.collections
    assert scree.plot(m).get_title() == "as set up"
    film = scree.film(r, tmp_path / "i.gif", every=3, dpi=40)
    assert film.read_bytes()[:4] == b"GIF8"
    assert scree.report(r).read_text().startswith("<!DOCTYPE html>") and scree.report(r) == tmp_path / "i.html"
    rows = scree.study(m, grid={"joint(plane).phi": [10, 40]}, set={"output.every": 10}, folder=tmp_path / "study", jobs=1)
    assert [row["joint(plane).phi"] for row in rows] == ["10", "40"] and rows[0]["displacement.largest"] > 10 * rows[1]["displacement.largest"]


def test_a_run_is_looked_at_and_changed_on_its_way(tmp_path):
    """A block stands on a plane of 30 degrees until its friction goes to 20 degrees after half a second, and then slides by a t^2/2."""
    m, looks = incline(30, 40), []
    m.dynamic(time=1, size=0.01)

    def look(r):
        looks.append((r.history.time[-1], r.joint("plane").slip.max()))
        return {"joint(plane).phi": 20} if len(looks) == 2 else None

    r = m.run(tmp_path / "i.h5", each=look, every=25)
    assert [time for time, _ in looks] == pytest.approx([0.25, 0.5, 0.75]) and looks[1][1] < 1e-5 and r.scene.status == "complete"
    pull = 9.81 * (math.sin(math.radians(30)) - math.cos(math.radians(30)) * math.tan(math.radians(20)))
    for slip, time in ((looks[2][1], 0.25), (r.joint("plane").slip.max(), 0.5)):
        assert slip == pytest.approx(pull * time ** 2 / 2, rel=5e-3)


def test_a_look_may_end_a_run(tmp_path):
    m = incline(30, 20)
    m.dynamic(time=1, size=0.01)
    r = m.run(tmp_path / "i.h5", each=lambda r: r.joint("plane").slip.max() < 0.1, every=10)
    pull = 9.81 * (math.sin(math.radians(30)) - math.cos(math.radians(30)) * math.tan(math.radians(20)))
    ends = math.ceil(math.sqrt(2 * 0.1 / pull) / 0.1) / 10
    assert r.scene.status == "paused" and r.times[-1] == pytest.approx(ends)
    with pytest.raises(scree.ScreeError, match=r"run\(each=\): expected a function that returns None, False or values"):
        m.run(tmp_path / "j.h5", each=lambda r: "go on", every=10)
    with pytest.raises(scree.ScreeError, match=r"run\(every=\): expected a whole number from 1, found 0"):
        m.run(tmp_path / "j.h5", each=lambda r: None, every=0)


def test_progress_is_one_line_that_goes_again(tmp_path, capsys):
    m = incline(30, 20)
    m.dynamic(time=2, size=0.001)
    m.run(tmp_path / "i.h5", progress=True)
    said = capsys.readouterr().out
    lines = [line.rstrip() for line in said.split("\r") if line.strip()]
    assert "\n" not in said and all(re.match(r"left (\d+:\d\d:\d\d|\?)  \d+ %", line) for line in lines)
    assert lines[-1].startswith("left 0:00:00  100 %") and said.endswith(" \r")
    m.run(tmp_path / "i.h5")
    assert capsys.readouterr().out == ""
    with pytest.raises(scree.RunFailed, match="step.sense"):
        m.run(tmp_path / "i.h5", set={"step.sense": 1}, progress=True)


def mixed():
    m = slope()
    m.parts = m.parts[:1]
    m.block("b", [(0, 0), (1, 0), (1, 1)])


WRONG = {
    r"Model\(units=\): expected a length .* found 'feet'": lambda: scree.Model(units="feet"),
    r"Model\(gravity=\): expected a number from 0, found -1": lambda: scree.Model(gravity=-1),
    r"material: expected at least one block material": lambda: scree.Model().check(),
    r"material\(density=, young=\): expected both": lambda: scree.Model().material("x", young=1e9),
    r"material\(young=\): expected a number above 0, found 0": lambda: scree.Model().material("x", 1, young=0),
    r"joint_material\(phi=\): expected a number from 0 to 89.9, found 90": lambda: scree.Model().joint_material("x", phi=90),
    r"joint_material\(\*\*laws\): expected one of kn, .*found 'knn'": lambda: scree.Model().joint_material("x", knn=1),
    r"rock\(corners=\): expected at least 3 places": lambda: scree.Model().rock([(0, 0), (1, 1)]),
    r"rock\(corners=\): .* enclose no area": lambda: scree.Model().rock([(0, 0), (1, 1), (2, 2)]),
    r"rock\(material=\): expected one of rock, fill, found none": lambda: slope_at_first().rock([(50, 0), (51, 0), (51, 1)]),
    r"joint\(material=\): expected one of bedding, steep, found none": lambda: slope_at_first().joint("beding", [(0, 0), (1, 1)]),
    r"joint_set: expected rock before it": lambda: scree.Model().joint_set("a", dip=1, spacing=1, length=1),
    r"joint_set\(spacing=\): expected a number above 0": lambda: slope_at_first().joint_set("a", dip=1, spacing=0, length=1),
    r"support\(hold=\): expected one of normal, x, y, both, found 'all'": lambda: slope().support("s", [(0, 0), (1, 0)], hold="all"),
    r"remove\(name=\): expected one of anchor, .*floor, found 'roof'": lambda: slope().remove("roof"),
    r"excavate: expected a stage before it": lambda: slope_at_first().excavate("niche"),
    r"excavate\(what\): expected one of niche, found 'nich'": lambda: slope().excavate("nich"),
    r"rock: expected it before the first stage": lambda: slope().rock([(0, 0), (1, 0), (1, 1)]),
    r"block: expected a model of finished blocks": mixed,
    r"bolt\(stiffness=\): expected a number above 0": lambda: slope().bolt("b", (0, 0), (1, 1), stiffness=0),
    r"bolt_row\(line=\): expected a line with a length": lambda: slope().bolt_row("b", [(1, 1), (1, 1)], 3, 1, stiffness=1),
    r"load\(pressure=\): expected a number, found None": lambda: slope().load("l", [(0, 0), (1, 0)], pressure=None),
    r"load\(pressure=\) along the line: expected two numbers": lambda: slope().load("l", [(0, 0), (1, 0)], pressure=[1, 2, 3]),
    r"force\(force=\): expected two numbers": lambda: slope_at_first().force("f", (1, 1), 5),
    r"in_situ\(k0=\): expected a number from 0, found -1": lambda: slope_at_first().in_situ(0, -1),
    r"model\[name\]: expected GROUP.NAME": lambda: slope().__setitem__("restitution", 1),
    r"joint\(plan\).phi: expected one of plane, found 'plan'": lambda: scree.study(incline(30, 40), grid={"joint(plan).phi": [1]}),
    r"save\(path=\): expected a name with .ana": lambda: slope().save("x.txt"),
    r"nowhere.ana: expected an analysis deck, found: No such file": lambda: scree.Model.read("nowhere.ana"),
}


def slope_at_first():
    m = slope()
    m.parts = m.parts[:1]
    return m


@pytest.mark.parametrize("words", WRONG)
def test_a_wrong_word_is_one_sentence_that_names_the_argument(words):
    with pytest.raises(ModelError, match=words) as caught:
        WRONG[words]()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("text", "words"), [("1 2 x", "expected numbers before the groups, found 'x'"),
                                             ("1 2 1 1 0 0", "expected more numbers"), ("1 &a b=1", "expected '/' at the end of &a"),
                                             ("1 &a 'b' /", "expected a name in &a"), ("1 &a / b", "expected & and the name")])
def test_a_text_that_is_no_deck_is_refused(text, words, tmp_path):
    (tmp_path / "x.ana").write_text(text)
    with pytest.raises(ModelError, match=words):
        scree.Model.read(tmp_path / "x.ana", geometry=INPUT / "examples" / "tunnel" / "tunnel.geo")


def test_names_that_are_not_there_are_one_sentence(tmp_path):
    m = incline(30, 40)
    m.static()
    r = m.run(tmp_path / "i.h5")
    for ask, words in ((r.joint, r"joint\(name=\): expected one of plane"), (r.bolt, r"bolt\(name=\): expected one of none"),
                       (r.support, r"support\(name=\): expected one of wedge")):
        with pytest.raises(ResultsError, match=words):
            ask("x")
    with pytest.raises(ResultsError, match=r"closure\(q\): expected a place in the rock"):
        r.closure((5, 1), (50, 50))
    with pytest.raises(scree.ScreeError, match="joints=: expected one of"):
        scree.plot(r, joints="all")


def test_reactions_under_pressure_traction_water_and_forces(tmp_path):
    m = scree.Model("dam")
    m.material("rock", density=2500, young=1e10)
    m.joint_material("base", phi=60)
    m.block("rock", [(-5, -3), (8, -3), (8, 0), (-5, 0)])
    m.block("dam", [(0, 0), (3, 0), (3, 5), (0, 5)])
    m.support("floor", [(-5, -3), (8, -3)])
    m.support("back", [(8, -3), (8, 0)], hold="normal")
    m.load("snow", [(4, 0), (8, 0)], pressure=[1000, 3000], traction=(500, 0))
    m.force("crane", (-3, -1), (200, -7000))
    m.water([(-5, 4), (0, 4), (3, -1), (8, -1)])
    m.static(balance=1e-6)
    r = m.run(tmp_path / "dam.h5")
    floor, back = r.support("floor").reaction, r.support("back").reaction
    w = 9810
    # The dam bears water at its wet side, w 4^2/2; the rock bears water on its outline alike on both sides but where levels differ:
    # the left side from 4 to 7 deep, the right one from 0 to 2, the top on the left, uplift below the dam on both of its blocks, below.
    sideways = w * (4 ** 2 / 2 + (4 + 7) / 2 * 3 - 2 ** 2 / 2) + 500 * 4 + 200
    level = [(-5, 4), (0, 4), (3, -1), (8, -1)]
    below = w * sum((x2 - x1) * ((y1 + 3) + (y2 + 3)) / 2 for (x1, y1), (x2, y2) in zip(level, level[1:]))
    down = 2500 * 9.81 * (13 * 3 + 3 * 5) + 2000 * 4 + 7000 + w * 4 * 5 - below
    assert floor[0] + back[0] == pytest.approx(-sideways, rel=2e-4)
    assert floor[1] == pytest.approx(down, rel=2e-4) and back[1] == 0


def test_a_joint_material_has_the_laws_of_the_program():
    named = re.findall(r"(?m)^\| `joints\.(\w+)` \|", scree.call("explain", "--settings").stdout)
    assert set(JOINT_LAWS) == set(named) - {"phi", "cohesion", "tensile_strength", "restitution"}  # of these, 0 is no default


@pytest.mark.parametrize("words", ["m kg s", "m t s", "mm t s"])
def test_units_change_no_answer(words, tmp_path):
    scale = {"m": 1.0, "mm": 1e3}[words.split()[0]]
    mass = {"kg": 1.0, "t": 1e-3}[words.split()[1]]
    m = scree.Model("u", units=words)
    assert m.units.water * scale ** 3 / mass == pytest.approx(1000)
    m.material("rock", density=2500 * mass / scale ** 3, young=1e9 * mass / scale)
    m.joint_material("plane", phi=30)
    m.block("low", [(0, 0), (2 * scale, 0), (2 * scale, scale), (0, scale)])
    m.block("high", [(0, scale), (scale, scale), (scale, 2 * scale), (0, 2 * scale)])
    m.support("floor", [(0, 0), (2 * scale, 0)])
    m.static()
    r = m.run(tmp_path / "u.h5")
    assert r.support("floor").reaction[1] == pytest.approx(3 * 2500 * 9.81 * mass, rel=1e-4)  # per unit thickness
    assert scree.plot(r).get_xlabel() == f"x [{words.split()[0]}]"


def test_refused_reactions_are_one_sentence(tmp_path):
    m = incline(30, 40)
    m.dynamic(time=0.01, size=0.005)
    with pytest.raises(ResultsError, match="support: expected the end of a static run of DDA blocks"):
        m.run(tmp_path / "i.h5").support("wedge")
    m.static()
    m["acceleration.table"] = [0, 0.1, 0, 1, 0.1, 0]
    with pytest.raises(ResultsError, match="support: expected a run without acceleration.table"):
        m.run(tmp_path / "j.h5").support("wedge")


def test_joints_end_at_openings_and_a_tunnel_is_air(tmp_path):
    m = scree.Model("tunnel")
    m.material("rock", density=2600, young=1e10)
    m.joint_material("joint", phi=30)
    m.rock([(-10, -10), (10, -10), (10, 10), (-10, 10)])
    m.joint("joint", [(-12, 0.5), (12, 0.5)])
    m.opening(scree.arc((0, 0), 3, sides=24))
    m.joint_set("set", dip=40, spacing=3, length=100, material="joint")
    scree.cut(m.save(tmp_path / "t.ana"), output=tmp_path / "t.h5")
    r = scree.read(tmp_path / "t.h5")
    assert r.bodies.area[0].sum() == pytest.approx(400 - 12 * 9 * math.sin(math.radians(15)), rel=1e-9)
    named = [row.numbers for row in m.geometry.joints if row.name == "joint"]
    assert len(named) == 2 and named[0][0] == -10 and named[1][2] == 10
    assert all(math.hypot((x1 + x2) / 2, (y1 + y2) / 2) > 2.9 for x1, y1, x2, y2 in (row.numbers for row in m.geometry.joints))


def test_an_arch_bears_itself_and_bricks_stand(tmp_path):
    m = scree.Model("stones")
    m.material("stone", density=2000, young=1e10)
    m.joint_material("bed", phi=40)
    m.block("ground", [(-3, -1), (12, -1), (12, 0), (-3, 0)])
    m.arch("arch", (0, 0), 2, 0.6, stones=12)
    m.bricks("wall", (4, 0), columns=6, courses=8, width=1, height=0.5)
    m.support("ground", [(-3, -1), (12, -1)])
    m.static()
    r = m.run(tmp_path / "stones.h5")
    assert r.scene.status == "complete" and r.warnings == []
    areas = r.bodies.area[0]
    assert areas[1:13].sum() == pytest.approx(12 * math.sin(math.radians(15)) / 2 * (2.6 ** 2 - 2 ** 2)) and areas[13:].sum() == pytest.approx(24)
    assert r.support("ground").reaction == pytest.approx([0, 2000 * 9.81 * areas.sum()], rel=1e-4, abs=100)


def platen(**motion):
    """A block between a floor that is smooth but for one point and a platen that moves."""
    m = scree.Model("platen")
    m.material("rock", density=2500, young=1e9, unit_weight=0)
    m.joint_material("side", phi=30)
    m.block("sample", [(0, 0), (2, 0), (2, 1), (0, 1)])
    m.support("floor", [(0, 0), (2, 0)], hold="y")
    m.support("pin", points=[(1, 0)], hold="x")
    m.support("platen", [(0, 1), (2, 1)], **motion)
    m.static(balance=None, steps=20, size=0.05)
    return m


@pytest.mark.parametrize("motion", [{"velocity": (0, -1e-3)}, {"table": [(0, 0, 0), (1, 0, -1e-3)]}])
def test_a_moved_support_has_a_reaction_and_survives_a_deck(motion, tmp_path):
    m = platen(**motion)
    first = m.save(tmp_path / "first.ana")
    assert scree.Model.read(first).save(tmp_path / "second.ana").read_text() == first.read_text().replace("first.", "second.")
    r = scree.Model.read(first).run(tmp_path / "platen.h5")
    for frame, share in (10, 0.5), (-1, 1):  # plane strain and sides that are free
        stress = share * 1e-3 * 1e9 / (1 - 0.25 ** 2)
        assert r.support("platen", frame).reaction == pytest.approx([0, -2 * stress], rel=2e-3, abs=1)
        assert r.support("floor", frame).reaction == pytest.approx([0, 2 * stress], rel=2e-3, abs=1)
    assert r.support("pin").reaction == pytest.approx([0, 0], abs=1)


def test_reactions_are_a_series_of_the_growing_weight(tmp_path):
    """Blocks on a floor: it bears their weight while that grows over ten of twenty steps, and half of it when the upper ones are gone."""
    m = scree.Model("pile")
    m.material("rock", density=2500, young=1e9)
    m.joint_material("joints", phi=35)
    m.rock([(0, 0), (4, 0), (4, 2), (0, 2)])
    m.joint("bed", [(0, 1), (4, 1)])
    m.joint("cut", [(2, 1), (2, 2)])
    m.support("floor", [(0, 0), (4, 0)])
    m["gravity.ramp"], m["output.every"] = 0.5, 1
    m.static(balance=None, steps=20, size=0.05)
    m.stage("lifted")
    m["gravity.ramp"] = 0
    m.excavate([(0, 1), (4, 1), (4, 2), (0, 2)])
    r = m.run(tmp_path / "pile.h5")
    weight = 2500 * 9.81 * 8
    found = r.reactions("floor")
    assert found.shape == (r.n_frames, 2) and np.isnan(found[0]).all()
    share = np.where(r.frame_stages == 1, np.minimum(r.times / 0.5, 1), 0.5)
    settled = (r.frame_stages == 1) | (np.arange(r.n_frames) > 30)
    settled[0] = False
    np.testing.assert_allclose(found[settled], np.outer(share[settled] * weight, [0, 1]), atol=1e-3 * weight)


def test_a_model_has_one_kind_of_motion():
    with pytest.raises(ModelError, match=r"support\(velocity=, table=\): expected one of both for all lines that move, found two"):
        platen(velocity=(0, 1), table=[(0, 0, 0), (1, 0, 1)])
    with pytest.raises(ModelError, match=r"support\(velocity=, table=\): expected one of both for all lines that move, found two"):
        platen(velocity=(0, 1)).support("side", [(0, 0), (0, 1)], table=[(0, 0, 0), (1, 0, 1)])
    with pytest.raises(ModelError, match=r"support\(line=, points=\): expected one of both"):
        platen(velocity=(0, 1)).support("side")
    with pytest.raises(ModelError, match=r"support\(hold=\) of points: expected one of both, x, y, found 'normal'"):
        platen(velocity=(0, 1)).support("pins", points=[(0, 0)], hold="normal")
