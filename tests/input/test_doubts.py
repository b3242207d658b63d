"""What a run would do without a word is said: strengths, units, loads that end, slopes that the window cuts, files that are not there."""
import re

import pytest
import scree
from test_check import CORNERS, check, deck

JOINT = "\n30.0 0 0\n"


def joint(folder, row, groups="", **options):
    """Warnings of three blocks on a floor whose joints have the numbers of a row."""
    deck(folder, groups=groups, **options)
    text = (folder / "a.ana").read_text()
    assert text.count(JOINT) == 1
    (folder / "a.ana").write_text(text.replace(JOINT, f"\n{row}\n"))
    return check(folder)[1]


@pytest.mark.parametrize("row, groups, words", [
    ("30 0 0", "&joints residual_phi=35, residual_slip=0.01 /", "residual friction angle up to the friction angle of the joint, 30, found 35"),
    ("30 0 0", "&joints residual_phi=30, residual_slip=0.01 /", None),
    ("30 0 0", "&joints residual_phi=20, residual_slip=0.01 /", None),
    ("30 5e4 1e4", "&joints residual_c=6e4 /", "residual cohesion up to the cohesion of the joint, 50000, found 60000"),
    ("30 0 1e4", "&joints residual_c=6e4 /", "residual cohesion up to the cohesion of the joint, 0, found 60000"),
    ("30 5e4 1e4", "&joints residual_c=5e4 /", None),
    ("30 0 0", "&joints residual_c=6e4 /", None)])  # no bond: the cohesion of what is not bonded
def test_a_residual_strength_above_the_peak_is_warned_of(row, groups, words, tmp_path):
    warnings = joint(tmp_path, row, groups)
    assert warnings == [] if words is None else [words in line for line in warnings] == [True], warnings


UNITS = {"Pa": (1.0, (2500.0, 24525.0, 1e10)), "kPa": (1e-3, (2.5, 24.525, 1e7)), "MPa": (1e-6, (0.0025, 0.024525, 1e4))}


@pytest.mark.parametrize("strength", [2e3, 2e4, 1e5, 2e6, 2e7])  # from a clay seam to rock
@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize("written", UNITS)
def test_a_strength_in_another_unit_is_warned_of(written, unit, strength, tmp_path):
    """Of a bank of 4 m; a factor of 1000 shows where the strength is not usual for that."""
    _, rock = UNITS[unit]
    c = strength * UNITS[written][0]
    warnings = joint(tmp_path, f"30 {c} {0.1 * c}", rock=rock)
    factor = UNITS[written][0] / UNITS[unit][0]
    if factor == 1:
        assert warnings == []
    elif factor == 1e6:
        assert any("cohesion up to 0.02 of Young's modulus" in line for line in warnings) == (c > 0.02 * rock[2]) and (
            strength < 1e4 or warnings)
    elif factor == 1e-6:
        assert any("cohesion of 0 or from" in line for line in warnings) == (strength < 1e7), warnings


def test_a_bond_that_is_to_hold_is_not_warned_of(tmp_path):
    assert joint(tmp_path, "30 1e10 1e10") == []
    assert len(joint(tmp_path, "30 1e10 0")) == 1


@pytest.mark.parametrize("jcs, warned", [(1e8, False), (100, True), (1e10, True)])
def test_strength_of_walls_in_another_unit_is_warned_of(jcs, warned, tmp_path):
    warnings = joint(tmp_path, "30 0 0", f"&joints jrc=8, jcs={jcs} /")
    assert ["strength of the walls (jcs)" in line for line in warnings] == [True] * warned


@pytest.mark.parametrize("weight, rock, warned", [(9810, "Pa", False), (9.81, "Pa", True), (9.81, "kPa", False), (9810, "kPa", True),
                                                  (0.00981, "MPa", False), (9.81, "MPa", True)])
def test_a_unit_weight_of_water_in_another_unit_is_warned_of(weight, rock, warned, tmp_path):
    deck(tmp_path, rock=UNITS[rock][1], groups=f"&water table=-3 2 4 2, unit_weight={weight} /")
    assert ["water: expected a unit weight from" in line for line in check(tmp_path)[1]] == [True] * warned


TABLE = "&acceleration table={}  {} {} 0 /"


@pytest.mark.parametrize("last, value, warned", [(0.002, 1.0, True), (0.005, 1.0, False), (0.01, 1.0, False), (0.002, 0, False)])
def test_a_record_that_is_cut_off_before_the_run_ends_is_warned_of(last, value, warned, tmp_path):
    """The run ends at 0.005."""
    deck(tmp_path, groups=TABLE.format("0 0 0  0.001 2 0", last, value))
    facts, warnings = check(tmp_path)
    assert [f"up to the end of the run at 0.005, found (1, 0) at the last time, {last}; it is 0 from there" in line for line in warnings] == [
        True] * warned
    done = scree.call("run", "a.ana", cwd=tmp_path)
    assert ("it is 0 from there" in done.stderr) == warned and "none from there" in done.stdout


def test_a_record_of_a_static_run_stays_and_says_so(tmp_path):
    deck(tmp_path, carried=0, groups=TABLE.format("0 0 0", 0.002, 0.5))
    assert ["it stays so from there" in line for line in check(tmp_path)[1]] == [True]
    assert "the last one from there" in scree.call("check", "a.ana", cwd=tmp_path).stdout


def test_a_record_of_a_later_stage_is_warned_of(tmp_path):
    deck(tmp_path, groups="&stage /\n" + TABLE.format("0 0 0", 0.002, 0.5))
    assert ["acceleration of the ground of stage 2: " in line for line in check(tmp_path)[1]] == [True]


@pytest.mark.parametrize("table, warned", [("0 0 0  0.002 0.001 0", True), ("0 0 0  0.002 0.001 0  0.003 0.001 0", False),
                                           ("0 0 0  0.005 0.001 0", False)])
def test_a_table_of_a_point_that_ends_while_it_changes_is_warned_of(table, warned, tmp_path):
    deck(tmp_path, fixed=[CORNERS[0]])
    text = (tmp_path / "a.ana").read_text().replace("dialect='short'", "dialect='shi'")
    head, rest = text.split("\n", 1)
    (tmp_path / "a.ana").write_text(f"{head} 0\n{len(table.split()) // 3}\n{table}\n{rest}")
    assert any("fixed point 1: expected a displacement up to the end of the run" in line for line in check(tmp_path)[1]) == warned


def test_a_load_that_ends_in_a_later_stage_is_not_warned_of_where_the_run_ends_with_it(tmp_path):
    deck(tmp_path, fixed=[CORNERS[0]], groups="&stage /\n")
    text = (tmp_path / "a.ana").read_text().replace("dialect='short'", "dialect='shi'")
    head, rest = text.split("\n", 1)
    for last, warned in ((0.01, False), (0.009, True)):
        (tmp_path / "a.ana").write_text(f"{head} 0\n2\n0 0 0  {last} 0.001 0\n{rest}")
        assert any("end of the run at 0.01" in line for line in check(tmp_path)[1]) == warned


@pytest.mark.parametrize("pressure, warned", [(2e7, False), (4e7, True)])
def test_a_load_that_crushes_rock_is_warned_of(pressure, warned, tmp_path):
    """0.3 % of 1e10 is 3e7."""
    deck(tmp_path, groups=f"&boundary lines=0 3 1 3, pressure={pressure} {pressure} /")
    assert ["expected loads to compress" in line for line in check(tmp_path)[1]] == [True] * warned


def test_soft_rock_whose_stress_bears_its_weight_is_not_warned_of(tmp_path):
    """Three metres at 5e6 would settle by 1.5 %; a stress of -24525 (3 - y) is there already."""
    deck(tmp_path, rock=(2500.0, 24525.0, 5e6))
    assert any("a strain gamma H/E of 1.47" in line for line in check(tmp_path)[1])
    deck(tmp_path, rock=(2500.0, 24525.0, 5e6), stress="0 -73575 0 0 24525 0")
    assert not any("gamma H/E" in line for line in check(tmp_path)[1])


WINDOW = "&window x=0 20, y=0 10 /\n"


@pytest.mark.parametrize("slope, words", [
    ("x=0 5 12 20, y=4 4 9 9", None), ("x=0 5 12 20, y=4 4 10 10", None), ("x=0 5 12 20, y=4 4 12 12", "(12, 12) above its top, y = 10"),
    ("x=0 5 12 20, y=4 -1 9 9", "(5, -1) below its bottom, y = 0"), ("x=-3 5 12 20, y=4 4 9 9", "(-3, 4) beyond its left side, x = 0"),
    ("x=0 5 12 26, y=4 4 9 9", "(26, 9) beyond its right side, x = 20")])
def test_points_of_a_slope_outside_the_window_are_warned_of(slope, words, tmp_path):
    (tmp_path / "a.joints").write_text(WINDOW + f"&slope {slope} /\n")
    done = scree.call("joints", "a.joints", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    if words is None:
        assert done.stderr == ""
    else:
        assert f"warning: a.joints:2: expected points of &slope in the window, found {words}" in done.stderr, done.stderr


def test_joints_are_not_written_to_a_directory_or_a_device(tmp_path):
    (tmp_path / "a.joints").write_text(WINDOW)
    (tmp_path / "folder").mkdir()
    for target, found in (("folder", "a directory"), ("/dev/null", "a device")):
        done = scree.call("joints", "a.joints", "-o", target, cwd=tmp_path)
        assert done.returncode == 2 and re.search(f"expected a file for the geometry, found {found}", done.stderr), done.stderr
