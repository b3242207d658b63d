"""Groups of places at the end of a geometry: as if they stood in the analysis deck, which wins over them, name by name."""
import numpy as np
import pytest
import scree

GEOMETRY = "1e-3 5 4 0 0 0 0 1 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n1 0 1 1 1\n1.5 0.25\n"
ANALYSIS = "0 20 1 1 0.05 0.01\n2.5 25 1e6 0.25\n0 0 0\n0 0 0\n0 0 0\n30 0 0\n&deck geometry='box.{}' /\n"
GROUPS = ("&support both=0 0 2 0 /\n&boundary lines=0 1 2 1, pressure=5 8 /\n&bolts ends=0.5 0.5 1.5 0.6, stiffness=1e3, limit='breaks' /\n"
          "&water table=0 0.4 2 0.6, unit_weight=10 /\n")


def run(folder, in_geometry="", in_analysis="", *settings, ending="geo"):
    folder.mkdir(exist_ok=True)
    (folder / "box.geo").write_text(GEOMETRY + in_geometry)
    (folder / "box.ana").write_text(ANALYSIS.format(ending) + in_analysis)
    if ending == "blk":
        scree.cut("box.geo", output="box.blk", cwd=folder)
    return scree.run(folder / "box.ana", settings=settings).measured_points.displacement


def test_they_do_what_they_would_do_in_the_analysis(tmp_path):
    expected = run(tmp_path / "a", in_analysis=GROUPS)
    assert np.abs(expected).max() > 0
    np.testing.assert_array_equal(run(tmp_path / "g", GROUPS), expected)
    np.testing.assert_array_equal(run(tmp_path / "m", GROUPS.replace(", unit_weight=10", ""), "&water unit_weight=10 /\n"), expected)
    assert (run(tmp_path / "n") != expected).any()


def test_a_cut_carries_them_on_to_the_block_file(tmp_path):
    np.testing.assert_array_equal(run(tmp_path / "b", GROUPS + "&blocks least_area=0.1 /\n", ending="blk"),
                                  run(tmp_path / "a", in_analysis=GROUPS, ending="blk"))
    groups = (tmp_path / "b" / "box.blk").read_text().split("&")[1:]
    assert [group.split()[0] for group in groups] == ["bolts", "support", "boundary", "water"]  # the blocks are cut


def test_the_analysis_wins_over_them_and_the_command_line_over_both(tmp_path):
    expected = run(tmp_path / "a", in_analysis=GROUPS.replace("pressure=5 8", "pressure=1 2"))
    np.testing.assert_array_equal(run(tmp_path / "g", GROUPS, "&boundary pressure=1 2 /\n"), expected)
    np.testing.assert_array_equal(run(tmp_path / "s", GROUPS, "&boundary pressure=7 7 /\n", "boundary.pressure=1 2"), expected)
    text = scree.call("explain", tmp_path / "g" / "box.ana").stdout
    assert "boundary.pressure = 1 2 [force/length^2]  (" in text and f"water.table = 0 0.4 2 0.6 [length]  ({tmp_path}/g/box.geo:11)" in text


def test_a_restart_knows_them(tmp_path):
    whole = run(tmp_path / "w", GROUPS)
    run(tmp_path / "r", GROUPS, "", "step.count=7")
    done = scree.call("run", "--restart", "box.h5", "--set", "step.count=20", cwd=tmp_path / "r")
    assert done.returncode == 0, done.stderr
    np.testing.assert_array_equal(scree.read(tmp_path / "r" / "box.h5").measured_points.displacement, whole)


@pytest.mark.parametrize("groups, line, expected", [
    ("&method model='nmm' /\n", 8, "one of the groups &blocks, &bolts, &bolt_row, &bolt_ring, &support, &boundary, &water"),
    ("&water table=0 0 1, unit_weight=1 /\n", 8, "two numbers x y"), ("! one\n&water table=deep /\n", 9, "a number"), ("&water table=0 0\n", 9, "'/'"),
    ("&water depth=3 /\n", 8, "table, unit_weight"), ("&water table=0 0 1 0 /\n", 8, "water.unit_weight"), ("7 8\n", 8, "the end of the numbers"),
    ("&support x=0 0 0 1 /\n&support y=0 0 1 0 /\n", 9, "once")])
def test_bad_groups_are_refused_with_their_line(groups, line, expected, tmp_path):
    (tmp_path / "box.geo").write_text(GEOMETRY + groups)
    (tmp_path / "box.ana").write_text(ANALYSIS.format("geo"))
    done = scree.call("check", "box.ana", cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert done.stderr.startswith(f"scree: box.geo:{line}: expected") and expected in done.stderr, done.stderr
