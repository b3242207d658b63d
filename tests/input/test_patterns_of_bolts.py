"""Rows and rings of bolts, and bolts of a stage beside those before: the same bits as the lists that they stand for."""
import math

import numpy as np
import pytest
import scree

NUMBERS = "stiffness=1e7, pretension=1e3, strength=2e5"
STEP = "&deck geometry='g.geo' /\n&step balance=1e-4 /\n&support both=0 0 10 0 /\n"


def decks(folder, groups, in_geometry=""):
    """Rock of 10 m by 10 m with a level joint."""
    (folder / "g.geo").write_text("1e-3 5 4 0 0 0 0 1 0\n0 0 10 0 1\n10 0 10 10 1\n10 10 0 10 1\n0 10 0 0 1\n0 6 10 6 1\n5 9\n" + in_geometry)
    (folder / "g.ana").write_text("0 60 1 1 0.05 0.01\n2600 26000 1e10 0.25\n0 0 0\n0 0 0\n0 0 0\n35 0 0\n" + STEP + groups)
    return folder / "g.ana"


def bolts(folder, groups, **more):
    """Ends, forces and states of the bolts in all frames."""
    result = scree.run(decks(folder, groups, **more), output=folder / "g.h5")
    return [result.bolts.ends[:], result.bolts.force[:], result.bolts.state[:]]


def same(a, b):
    for one, other in zip(a, b):
        np.testing.assert_array_equal(one, other)


def ends_text(ends):
    return " ".join(str(float(value)) for end in ends for value in end)


@pytest.mark.parametrize("where", ["in_geometry", "groups"])
def test_a_row_is_the_list_of_its_bolts(where, tmp_path):
    row = f"&bolt_row line=1 8 9 8, spacing=2, length=4, direction=-90, {NUMBERS} /\n"
    ends = [(x, 8.0, x + 4 * math.cos(math.radians(-90)), 8.0 + 4 * math.sin(math.radians(-90))) for x in (1.0, 3.0, 5.0, 7.0, 9.0)]
    same(bolts(tmp_path, **{"groups": "", where: row}), bolts(tmp_path, f"&bolts ends={ends_text(ends)}, {NUMBERS} /\n"))


def test_rows_point_left_and_have_numbers_of_their_own(tmp_path):
    rows = "&bolt_row line=9 8 1 8  1 4 9 4, number=3 2, length=4 3, stiffness=1e7 2e7 /\n"
    ends = [(9, 8, 9, 4), (5, 8, 5, 4), (1, 8, 1, 4), (1, 4, 1, 7), (9, 4, 9, 7)]
    same(bolts(tmp_path, rows), bolts(tmp_path, f"&bolts ends={ends_text(ends)}, stiffness=1e7 1e7 1e7 2e7 2e7 /\n"))


def test_a_spacing_that_does_not_fit_begins_at_the_first_end(tmp_path):
    found = bolts(tmp_path, f"&bolt_row line=1 8 9 8, spacing=3, length=4, direction=270, {NUMBERS} /\n")[0][0]
    assert found[:, :2] == pytest.approx(np.array([(1, 8), (4, 8), (7, 8)]))


@pytest.mark.parametrize("words, angles", [("from=20, to=160, number=5", [20, 55, 90, 125, 160]), ("number=4", [0, 90, 180, 270]),
                                           ("from=30, number=3", [30, 150, 270]), ("from=-90, to=90, spacing=1.5707963267948966", [-90, 0, 90]),
                                           ("spacing=1.5707963267948966", [0, 90, 180, 270])])
def test_a_ring_points_away_from_its_centre(words, angles, tmp_path):
    found = bolts(tmp_path, f"&bolt_ring centre=5 6, radius=1, length=2, {words}, {NUMBERS} /\n")[0][0]
    ways = np.array([(math.cos(math.radians(angle)), math.sin(math.radians(angle))) for angle in angles])
    assert found == pytest.approx(np.hstack([(5, 6) + ways, (5, 6) + 3 * ways]))


def test_bolts_of_a_stage_stay_beside_those_before_where_they_are_kept(tmp_path):
    """Each stage adds a bolt; the same list by hand says them all again."""
    one, two, three = "2 8 2 4", "5 8 5 4", "8 8 8 4"
    kept = f"&stage /\n&bolts ends={one}, {NUMBERS} /\n&stage /\n&bolts ends={two}, earlier='kept' /\n&stage /\n&bolts ends={three} /\n&stage /\n"
    by_hand = f"&stage /\n&bolts ends={one}, {NUMBERS} /\n&stage /\n&bolts ends={one} {two} /\n&stage /\n&bolts ends={one} {two} {three} /\n&stage /\n"
    same(bolts(tmp_path, kept), bolts(tmp_path, by_hand))
    states = bolts(tmp_path, kept + "&bolts earlier='replaced' /\n")[2]
    assert states[-1].tolist() == [3, 3, 0]


def test_a_ring_of_a_stage_adds_to_a_row_before(tmp_path):
    states = bolts(tmp_path, f"&bolt_row line=2 8 8 8, number=2, length=4, direction=-90, {NUMBERS} /\n&stage name='ring' /\n"
                             f"&bolt_ring centre=5 6, radius=1, length=2, number=3, from=45, to=135, {NUMBERS} /\n")[2]
    assert states[0].tolist() == [0, 0, 3, 3, 3] and states[-1].tolist() == [0] * 5


def test_names_in_comments_sum_the_bolts_of_a_pattern(tmp_path):
    groups = f"&bolt_row line=9 8 1 8  ! 'lower'\n 1 4 9 4 ! 'upper'\n, number=3 2, length=4 3, {NUMBERS} /\n&stage /\n" \
             f"&bolt_ring centre=5 6, ! 'ring'\n radius=1, length=2, spacing=1, {NUMBERS} /\n"
    deck = decks(tmp_path, groups)
    result = scree.run(deck, output=tmp_path / "g.h5")
    assert len(result.bolt("lower").force) == 3 and len(result.bolt("upper").force) == 2 and len(result.bolt("ring").force) == 6
    assert result.bolt("upper").ends[:, :2] == pytest.approx(np.array([(1, 4), (9, 4)]), abs=1e-3)
    first = scree.Model.read(deck).save(tmp_path / "first.ana")
    assert "&bolt_ring centre=5 6  ! 'ring'" in first.read_text() and "&bolts" not in first.read_text()
    second = scree.Model.read(first).save(tmp_path / "second.ana")
    assert second.read_text() == first.read_text().replace("first.", "second.")


@pytest.mark.parametrize("groups, expected", [
    ("&bolt_row line=0 0 1, number=2, length=1, stiffness=1 /\n", "four numbers x1 y1 x2 y2 for each row in bolt_row.line, found 3"),
    ("&bolt_row line=1 1 1 1, number=2, length=1, stiffness=1 /\n", "two ends of row 1 in bolt_row.line, found one place"),
    ("&bolt_row line=1 1 2 1, number=2.5, length=1, stiffness=1 /\n", "bolt_row.number that makes a whole number of bolts"),
    ("&bolt_row line=1 1 2 1, spacing=1e-9, length=1, stiffness=1 /\n", "at most 100000, found 1e-9"),
    ("&bolt_row line=1 1 2 1, number=2, length=1 2, stiffness=1 /\n", "bolt_row.length with one number or 1, one for each row of bolt_row.line, found 2"),
    ("&bolt_row line=1 1 2 1, number=2, length=1 /\n", "bolt_row.stiffness with bolt_row.line, found none"),
    ("&bolt_row line=1 1 2 1, number=2, stiffness=1 /\n", "expected bolt_row.length with bolt_row.line, found none"),
    ("&bolt_row line=1 1 2 1, length=1, stiffness=1 /\n", "only with bolt_row.spacing or bolt_row.number"),
    ("&bolt_row line=1 1 2 1, length=1, stiffness=1, number=1, spacing=1 /\n", "only without bolt_row.spacing"),
    ("&bolt_ring centre=1, radius=1, number=2, length=1, stiffness=1 /\n", "two numbers x y for each ring in bolt_ring.centre, found 1"),
    ("&bolt_ring centre=5 5, radius=1, number=2, length=1, stiffness=1, from=90, to=90 /\n", "bolt_ring.to above bolt_ring.from by at most 360"),
    ("&bolt_ring centre=5 5, radius=1, number=2, length=1, stiffness=1 2 /\n", "one for each ring of bolt_ring.centre, found 2"),
    ("&bolt_ring centre=5 5, radius=9, number=2, length=1, stiffness=1 /\n", "bolt")])
def test_patterns_that_make_no_bolts_are_refused_with_their_line(groups, expected, tmp_path):
    done = scree.call("check", decks(tmp_path, groups), cwd=tmp_path)
    assert done.returncode == 2 and expected in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"scree: {tmp_path}/g.ana:10: "), done.stderr
