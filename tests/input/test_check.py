"""`scree check` says what is in a model, and warns of mistakes of units and signs and of what nothing holds; `run` warns too."""
import os
import pathlib
import re

import numpy as np
import pytest
import scree

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])

# Rock of 2500 kg/m3, 10 GPa on the earth: length, density, unit weight, Young's modulus in each system.
UNITS = {"m, kg, N": (1.0, 2500.0, 24525.0, 1e10), "m, t, kN": (1.0, 2.5, 24.525, 1e7), "m, 1000 t, MN": (1.0, 0.0025, 0.024525, 1e4),
         "mm, t, N": (1000.0, 2.5e-9, 2.4525e-5, 1e4), "cm, g, dyn": (100.0, 2.5, 2452.5, 1e11),
         "ft, slug, lbf": (3.2808, 4.8508, 156.12, 2.0885e8), "in, lbf": (39.37, 2.3393e-4, 0.090349, 1.4504e6),
         "m, kgf": (1.0, 255.0, 2500.0, 1.02e9), "m, tf": (1.0, 0.255, 2.5, 1.02e6)}


def box(x, y, width, height):
    return np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]], float)


FLOOR = box(-2, -1, 5, 1)
COLUMN = [FLOOR, *(box(0, i, 1, 1) for i in range(3))]
CORNERS = [(-1.9, -0.9, 1), (2.9, -0.9, 1), (2.9, -0.1, 1)]


def deck(folder, blocks=COLUMN, fixed=CORNERS, length=1.0, rock=(2500.0, 24525.0, 1e10), phi=30.0, stress="0 0 0 0 0 0", groups="",
         carried=1, steps=5, dt=0.001):
    """Writes a deck of blocks; fixed points are x, y and the number of their block."""
    head, rows, at = [], [], 1
    for corners in blocks:
        head.append(f"1 {at} {at + len(corners) - 1}")
        rows += [f"1 {float(x) * length} {float(y) * length}" for x, y in [*corners, corners[0]]] + ["0 0 0"] * 3
        at += len(corners) + 4
    points = [f"{x * length} {y * length} {b}" for x, y, b in fixed]
    (folder / "a.blk").write_text("\n".join([f"{len(blocks)} 0 {len(rows)}", f"{len(fixed)} 0 0", *head, *rows, *points, ""]))
    density, weight, young = rock
    (folder / "a.ana").write_text(f"{carried} {steps} 1 1 0.05 {dt}\n{density} {weight} {young} 0.25\n{stress} 0 0 0\n{phi} 0 0\n"
                                  f"&deck geometry='a.blk', dialect='short' /\n{groups}\n")


def check(folder, *options):
    """Facts by their label, and the warnings."""
    done = scree.call("check", "a.ana", *options, cwd=folder)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    pairs = (re.split("  +", line, maxsplit=1) for line in lines if "  " in line and not line.startswith(("effect: ", "warning: ")))
    return dict(pairs), [line.removeprefix("warning: ") for line in lines if line.startswith("warning: ")]


def first_number(text):
    return float(re.search(r"[-+0-9.e]+", text)[0])


@pytest.mark.parametrize("units", UNITS)
def test_rock_under_gravity_calls_for_no_warning_in_any_units(units, tmp_path):
    length, *rock = UNITS[units]
    deck(tmp_path, length=length, rock=rock)
    facts, warnings = check(tmp_path)
    assert warnings == []
    assert first_number(facts["gravity of material 1"]) == pytest.approx(9.81 * length, rel=2e-3)
    assert first_number(facts["wave speed of material 1"]) == pytest.approx(2000 * length, rel=2e-3)
    assert first_number(facts["strain under own weight"]) == pytest.approx(3 * 24525 / 1e10, rel=2e-3)


@pytest.mark.parametrize("units, names", [("m, kg, N", "m N s"), ("m, t, kN", "m kN s"), ("mm, t, N", "mm N s"), ("in, lbf", "in lbf s"),
                                          ("m, kg, N", "rod N s")])
def test_named_units_stand_in_place_of_dimensions(units, names, tmp_path):
    """Names are printed, numbers stay; the gravity of the earth in these units calls for no warning, nor does an unknown name."""
    length, *rock = UNITS[units]
    deck(tmp_path, length=length, rock=rock)
    before, _ = check(tmp_path)
    of_length, of_force, of_time = names.split()
    facts, warnings = check(tmp_path, *named(names))
    assert warnings == [] and facts["gravity of material 1"].split()[1] == f"{of_length}/{of_time}^2"
    assert facts["shortest edge"] == before["shortest edge"].replace("length", of_length)
    assert facts["stiffness of contact"].startswith(before["stiffness of contact"].split()[0] + f" {of_force}/{of_length}")
    assert facts["strain under own weight"].endswith(f" {of_length}, {before['strain under own weight'].split()[-2]} {of_force}/{of_length}^2")
    assert not any(re.search(r"\b(length|force|time)\b", fact) for fact in facts.values())


def named(names):
    """The words of the command line that name units of length, force and time."""
    return [word for name, unit in zip(("length", "force", "time"), names.split()) for word in ("--set", f"units.{name}={unit}")]


@pytest.mark.parametrize("names, expected", [("mm N s", "9810 mm/s^2"), ("m N ms", "9.81e-6 m/ms^2"), ("ft lbf s", "32.19 ft/s^2")])
def test_gravity_in_other_units_than_named_is_warned_of(names, expected, tmp_path):
    deck(tmp_path)
    _, warnings = check(tmp_path, *named(names))
    assert warnings == [f"block material 1: expected unit weight over density to be the gravity of the earth in &units, {expected}, found 9.81"]


@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize("mistake, words", [
    (lambda d, w, E: (d, w / 1000, E), ["unit weight over density", "factor of 1000"]),
    (lambda d, w, E: (d, w * 1000, E), ["unit weight over density"]),
    (lambda d, w, E: (d, d, E), ["unit weight over density"]),
    (lambda d, w, E: (d, -w, E), ["unit weight of at least 0"]),
    (lambda d, w, E: (d, w, E / 1e9), ["own weight to compress"]),
    (lambda d, w, E: (d, w, E / 1e6), ["own weight to compress"])],
    ids=["kN beside kg", "N beside t", "weight is density", "negative", "E in GPa", "E in MPa"])
def test_a_mistake_of_units_or_sign_is_warned_of(units, mistake, words, tmp_path):
    length, *rock = UNITS[units]
    deck(tmp_path, length=length, rock=mistake(*rock))
    warnings = check(tmp_path)[1]
    for word in words:
        assert any(word in line for line in warnings), warnings
    assert all("expected" in line and "found" in line for line in warnings)


@pytest.mark.parametrize("g", [0.0, 9.81, 10.0, 9.4, 10.3])
def test_gravity_may_be_earthly_or_none(g, tmp_path):
    deck(tmp_path, rock=(2500.0, 2500 * g, 1e10))
    assert check(tmp_path)[1] == []


@pytest.mark.parametrize("E, warned", [(2.44e7, True), (2.47e7, False)])
def test_own_weight_may_compress_by_three_thousandths(E, warned, tmp_path):
    """Three blocks of 1 m: the strain at the foot is 3 x 24525 / E, 0.3 % at 2.4525e7."""
    deck(tmp_path, rock=(2500.0, 24525.0, E))
    assert any("own weight to compress" in line for line in check(tmp_path)[1]) == warned


@pytest.mark.parametrize("phi, warned", [(0.0, False), (0.5236, True), (0.99, True), (1.0, False), (30.0, False)])
def test_a_friction_angle_in_radians_is_warned_of(phi, warned, tmp_path):
    deck(tmp_path, phi=phi)
    warnings = check(tmp_path)[1]
    assert ["radians" in line for line in warnings] == [True] * warned


@pytest.mark.parametrize("rules, warned", [("coulomb", False), ("conserving", True)])
def test_a_strength_that_is_not_used_is_warned_of(rules, warned, tmp_path):
    deck(tmp_path, groups=f"&contact rules='{rules}' /")
    text = (tmp_path / "a.ana").read_text()
    assert text.count("\n30.0 0 0\n") == 1
    (tmp_path / "a.ana").write_text(text.replace("\n30.0 0 0\n", "\n30.0 1e5 2e4\n"))
    warnings = check(tmp_path)[1]
    assert ["joint material 1: expected no tensile strength" in line and line.endswith("found 20000") for line in warnings] == [True] * warned


def test_what_nothing_holds_is_warned_of(tmp_path):
    deck(tmp_path, fixed=[])
    facts, warnings = check(tmp_path)
    assert len(warnings) == 1 and "fixed point or a support, found none: all 4 blocks fall" in warnings[0]
    assert facts["touch nothing that is held"] == "blocks 1 2 3 4"
    deck(tmp_path, fixed=[], rock=(2500.0, 0.0, 1e10))
    assert check(tmp_path)[1] == []  # nothing pulls it


def test_blocks_that_touch_nothing_held_are_listed(tmp_path):
    """The third block hangs 0.1 above the second, and the fourth lies on it."""
    deck(tmp_path, blocks=[FLOOR, box(0, 0, 1, 1), box(0, 1.1, 1, 1), box(0, 2.1, 1, 1)])
    facts, warnings = check(tmp_path)
    assert facts["touch nothing that is held"] == "blocks 3 4" and warnings == []
    assert "under 2 length" in facts["strain under own weight"] and "block 3" in facts["strain under own weight"]


def stressed(folder, held, stress, **options):
    """Rock of 4 by 3 blocks of 2 x 1 with an initial stress, its lowest row held; the sides above held too or free."""
    blocks = [box(2 * i, j, 2, 1) for j in range(3) for i in range(4)]
    fixed = [(2 * i + x, 0.02, i + 1) for i in range(4) for x in (0.1, 1.9)]
    if held:
        fixed += [(x, j + y, 4 * j + i) for j in range(3) for i, x in ((1, 0.02), (4, 7.98)) for y in (0.1, 0.9)]
    deck(folder, blocks, fixed, stress=stress, **options)


K0 = f"{-1.5 * 24525} {-3 * 24525.0} 0 {24525 / 2} 24525 0"  # of its weight below y = 3, and half of that across


@pytest.mark.parametrize("groups", ["", "&method model='nmm' /"])
def test_an_initial_stress_on_free_sides_is_warned_of(groups, tmp_path):
    """On each side K0 w y dy over the two rows that no fixed point holds, 2 m: 1/2 x 24525 x 2^2/2. The top is free of stress."""
    stressed(tmp_path, False, K0, groups=groups)
    facts, warnings = check(tmp_path)
    assert len(warnings) == 1 and "initial stress" in warnings[0] and "left" in warnings[0] and "right" in warnings[0]
    assert "top" not in warnings[0] and "bottom" not in warnings[0]
    for side, block in (("left", 5), ("right", 8)):
        assert first_number(facts[f"initial stress, {side}"]) == pytest.approx(24525, rel=1e-3)
        assert facts[f"initial stress, {side}"].endswith(f"block {block}")
    stressed(tmp_path, True, K0, groups=groups)
    assert check(tmp_path)[1] == []


SIDES = {"left": "0 1 0 3", "right": "8 1 8 3"}  # of the rows that no fixed point holds


@pytest.mark.parametrize("method", ["", "&method model='nmm' /"])
def test_supports_and_pressure_bear_an_initial_stress(method, tmp_path):
    """Rollers on a side bear it all, the pressure of K0 too; half of that leaves half, and one that grows from 0 leaves it all."""
    full = 24525.0
    for side, line in SIDES.items():
        other = {"left": "right", "right": "left"}[side]
        for groups, left in ((f"&support normal={line} /", 0.0), (f"&boundary lines={line}, pressure={full} 0 /", 0.0),
                             (f"&boundary lines={line}, pressure={full / 2} 0 /", full / 2),
                             (f"&boundary lines={line}, pressure={full} 0, ramp=1 /", full), (f"&support y={line} /", full)):
            stressed(tmp_path, False, K0, groups=method + groups)
            facts = check(tmp_path)[0]
            assert first_number(facts[f"initial stress, {other}"]) == pytest.approx(full, rel=1e-3)
            assert first_number(facts.get(f"initial stress, {side}", "0")) == pytest.approx(left, rel=1e-3), groups
    stressed(tmp_path, False, K0, groups=method + f"&support normal={SIDES['left']} / &boundary lines={SIDES['right']}, pressure={full} 0 /")
    assert check(tmp_path)[1] == []


def test_supports_hold_what_stands_on_them(tmp_path):
    """Without a fixed point: a floor on a level support holds its column; upright rollers let it fall."""
    deck(tmp_path, fixed=[], groups="&support normal=-2 -1 3 -1 /")
    facts, warnings = check(tmp_path)
    assert warnings == [] and facts["touch nothing that is held"] == "none"
    deck(tmp_path, fixed=[], groups="&support normal=-2 -1 -2 0 /")
    facts, warnings = check(tmp_path)
    assert "all 4 blocks fall" in warnings[0] and facts["touch nothing that is held"] == "blocks 1 2 3 4"


def test_blocks_that_may_not_touch_bear_no_stress_of_each_other(tmp_path):
    """Each of the four columns above the row that is held pushes to both sides."""
    stressed(tmp_path, False, K0, groups="&contact method='none' /")
    assert first_number(check(tmp_path)[0]["initial stress, left"]) == pytest.approx(4 * 24525, rel=1e-3)


def test_rock_with_free_sides_bursts_under_its_stress_and_with_held_ones_does_not(tmp_path):
    """What the warning says comes true: 10 MPa across, without weight, for 0.1 s."""
    moved, warned = {}, {}
    for held in (False, True):
        stressed(tmp_path, held, "-1e7 0 0 0 0 0", rock=(2500.0, 0.0, 1e10), steps=100, dt=0.001, groups="&output every=1 /")
        done = scree.call("run", "a.ana", "--quiet", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        warned[held] = "initial stress" in done.stderr
        f = scree.read(tmp_path / "a.h5")
        moved[held] = np.abs(f.bodies.centroid[-1] - f.bodies.centroid[0]).max()
    assert warned == {False: True, True: False}
    assert moved[False] > 20 * moved[True]


def test_slivers_are_warned_of(tmp_path):
    """A slab of 1 : 120, a wedge of 2 degrees; a slab of 1 : 80 and a wedge of 4 degrees are none."""
    def wedge(degrees):
        return np.array([[2, 0], [3, 0], [3, np.tan(np.radians(degrees))]])

    for blocks, slivers in (([FLOOR, box(0, 0, 1.2, 0.01)], "block 2"), ([FLOOR, wedge(2)], "block 2"),
                            ([FLOOR, box(0, 0, 0.8, 0.01)], "none"), ([FLOOR, wedge(4)], "none")):
        deck(tmp_path, blocks)
        facts, warnings = check(tmp_path)
        assert facts["slivers"] == slivers
        assert [slivers in line for line in warnings] == [True] * (slivers != "none")


@pytest.mark.parametrize("groups", ["&contact stiffness=1e9 /", "&joints kn=1e9 /", "&joints kn=1e7, closure=1e-4 /"])
def test_the_overlap_of_contacts_is_what_a_static_run_finds(groups, tmp_path):
    """Within what a static run of 60 steps leaves of its way there; of a joint that stiffens by s/(kn + s/closure)."""
    deck(tmp_path, carried=0, steps=60, dt=0.01, groups=groups)
    facts, warnings = check(tmp_path)
    f = scree.run(tmp_path / "a.ana")
    assert first_number(facts["overlap of contacts there"]) == pytest.approx(f.history.overlap[-1], rel=1e-3)
    assert not any("bear own weight" in line for line in warnings)


def test_contacts_that_multipliers_hold_give_way_by_what_these_leave(tmp_path):
    """However soft their springs are."""
    deck(tmp_path, carried=0, steps=60, dt=0.01, groups="&contact method='augmented', stiffness=1e6, overlap=1e-6 /")
    facts, warnings = check(tmp_path)
    f = scree.run(tmp_path / "a.ana")
    assert f.history.overlap.max() <= first_number(facts["overlap of contacts there"]) == 1e-6
    assert "has 1 of the modulus" in facts["stiffness of contact"] and not any("bear own weight" in line for line in warnings)


def test_soft_contact_is_warned_of(tmp_path):
    """Three blocks of 24525 on two contacts of 1e6 sink by 0.0368, 4 % of the block."""
    deck(tmp_path, groups="&contact stiffness=1e6 /")
    warnings = check(tmp_path)[1]
    assert len(warnings) == 1 and "3.679 % of block 2" in warnings[0]


@pytest.mark.parametrize("ends, warned", [("0.2 0.2 0.8 0.8", True), ("0.5 0.5 0.5 1.5", False), ("0.5 2.5 0.5 9", False)])
def test_a_bolt_within_one_block_is_warned_of(ends, warned, tmp_path):
    deck(tmp_path, groups=f"&bolts ends={ends}, stiffness=1e6, outside='ground' /")
    assert [line.endswith("found bolt 1 with both ends in one block, whose joints it does not hold") for line in check(tmp_path)[1]] == warned * [True]


def test_sizes_points_and_step_are_told(tmp_path):
    deck(tmp_path, dt=0.01)
    facts = check(tmp_path)[0]
    assert facts["largest block"] == "1, 5 length^2, about (0.5, -0.5)"
    assert facts["smallest block"] == "2, 1 length^2, about (0.5, 0.5)"
    assert facts["shortest edge"] == "1 length"
    assert facts["fixed points"] == "3 in block 1"
    assert first_number(facts["fall in a step"]) == pytest.approx(0.5 * 9.81 * 0.01**2, rel=1e-3)


@pytest.mark.parametrize("mesh", ["", "&cover edge=0.5 /"])
def test_manifold_elements_are_told_alike(mesh, tmp_path):
    deck(tmp_path, groups=f"&method model='nmm', strain='green' /\n{mesh}")
    facts, warnings = check(tmp_path)
    assert warnings == [] and facts["touch nothing that is held"] == "none"
    assert first_number(facts["strain under own weight"]) >= 3 * 24525 / 1e10


def test_friction_that_lags_is_warned_of_where_it_makes_energy(tmp_path):
    """A dynamic run of small strain; not a static one, and not Green strain."""
    for groups, carried, warned in (("preset='shi'", 1, True), ("preset='shi'", 0, False), ("preset='shi', strain='green'", 1, False)):
        deck(tmp_path, groups=f"&method {groups} /", carried=carried)
        assert any("Shi's contact" in line for line in check(tmp_path)[1]) == warned


@pytest.mark.parametrize("phi, groups, warned", [
    (30.0, "&integrator beta=0.5 /\n&method strain='small' /", True), (0.0, "&integrator beta=0.5 /\n&method strain='small' /", False),
    (30.0, "&integrator beta=0.5 /", False), (30.0, "&integrator beta=0.52 /\n&method strain='small' /", False),
    (30.0, "&integrator beta=0.5, gamma=0.5 /\n&method strain='small' /", False)])
def test_contact_that_rings_while_it_rubs_is_warned_of(phi, groups, warned, tmp_path):
    deck(tmp_path, phi=phi, groups=groups, carried=1)
    assert any("rings while it rubs" in line for line in check(tmp_path)[1]) == warned


def test_strict_makes_warnings_errors(tmp_path):
    deck(tmp_path, phi=0.5)
    done = scree.call("check", "a.ana", "--strict", cwd=tmp_path)
    assert done.returncode == 2 and "warning: joint material 1" in done.stdout and "found 1" in done.stderr
    done = scree.call("run", "a.ana", "--strict", cwd=tmp_path)
    assert done.returncode == 2 and "radians" in done.stderr and not (tmp_path / "a.h5").exists()
    deck(tmp_path)
    for verb in ("check", "run"):
        assert scree.call(verb, "a.ana", "--strict", cwd=tmp_path).returncode == 0
    done = scree.call("explain", "a.ana", "--strict", cwd=tmp_path)
    assert done.returncode == 2 and "expected --strict with run or check" in done.stderr


def test_a_run_warns_once_and_runs(tmp_path):
    deck(tmp_path, phi=0.5)
    done = scree.call("run", "a.ana", "--quiet", cwd=tmp_path)
    assert done.returncode == 0 and (tmp_path / "a.h5").exists()
    assert len(done.stderr.splitlines()) == 1 and done.stderr.startswith("scree: warning: joint material 1: "), done.stderr


@pytest.mark.parametrize("preset", ["none", "shi"])
def test_what_touches_does_not_depend_on_whose_rules_the_run_has(preset, tmp_path):
    """Shi's rules look for contacts up to 6 % of the model away, which is not touching."""
    deck(tmp_path, blocks=[FLOOR, box(0, 0, 1, 1), box(0, 1.1, 1, 1)], groups=f"&method preset='{preset}', strain='green' /")
    assert check(tmp_path)[0]["touch nothing that is held"] == "block 3"


@pytest.mark.parametrize("away", [0.0, 1e6])
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_facts_follow_the_model_wherever_and_however_large_it_is(size, away, tmp_path):
    """A column of three on a floor, edges of a millimetre to a kilometre: areas with the square, strain with the size."""
    where = np.array([away, -away]) * size
    blocks = [size * block + where for block in COLUMN]
    fixed = [(float(size * x + where[0]), float(size * y + where[1]), b) for x, y, b in CORNERS]
    deck(tmp_path, blocks, fixed, rock=(2500.0, 24525.0, 1e10 * max(size, 1.0)))
    facts, warnings = check(tmp_path)
    assert warnings == [] and facts["touch nothing that is held"] == "none" and facts["slivers"] == "none"
    assert first_number(facts["smallest block"].split(", ")[1]) == pytest.approx(size**2, rel=1e-3)
    assert first_number(facts["strain under own weight"]) == pytest.approx(3 * size * 24525 / (1e10 * max(size, 1.0)), rel=1e-3)


@pytest.mark.parametrize("sides", [0, 1, 2])
def test_a_side_under_a_mesh_is_borne_by_two_fixed_points_on_it(sides, tmp_path):
    """One block of 8 x 3 with the stress of its weight, on a line of fixed points; those of its sides stand in the corners or higher.

    K0 w h^2/2 a side, less what elements near the corners bear, 0.5 of 3 at most; the bottom and the top call for nothing."""
    fixed = [(x, 0.0, 1) for x in (0.0, 2.0, 4.0, 6.0, 8.0)] + [(0.0, 3.0, 1)] * (sides > 0) + [(8.0, 3.0, 1)] * (sides > 1)
    deck(tmp_path, [box(0, 0, 8, 3)], fixed, stress=K0, groups="&method model='nmm' /\n&cover edge=0.25 /")
    facts, warnings = check(tmp_path)
    free = ["left", "right"][sides:]
    assert [label for label in facts if label.startswith("initial stress")] == [f"initial stress, {side}" for side in free]
    assert len(warnings) == (sides < 2)
    for side in free:
        assert (1 - 2 * 0.5 / 3) * 24525 * 9 / 4 < first_number(facts[f"initial stress, {side}"]) <= 24525 * 9 / 4


@pytest.mark.parametrize("groups", ["&method preset='shi' /", "&fixed_points method='penalty' /", ""])
def test_a_line_of_an_effect_ends_with_its_last_letter(groups, tmp_path):
    """The shorter of two reasons had blanks behind it, or whatever lay there in memory."""
    deck(tmp_path, groups=groups)
    done = scree.call("check", "a.ana", cwd=tmp_path)
    effects = [line for line in done.stdout.split("\n") if line.startswith("effect: ")]
    assert any("fixed points" in line for line in effects)
    for line in effects:
        assert re.fullmatch("[ -~]*[!-~]", line), line
