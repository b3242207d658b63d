"""Polygons that the geometry is cut along, and that stages excavate (&excavation)."""
import numpy as np
import pytest
import scree

OUTLINE = "3 3 7 3 7 6 3 6 3 3"
BENCH = "3 1 7 1 7 3 3 3 3 1"


def decks(folder, groups, lines=(), in_geometry="", removed=("", "")):
    """Rock of 10 m by 10 m with an inclined joint, in three stages."""
    sides = [(0, 0, 10, 0, 1), (10, 0, 10, 10, 1), (10, 10, 0, 10, 1), (0, 10, 0, 0, 1), (0, 2, 10, 7.3, 1), *lines]
    (folder / "g.geo").write_text(f"1e-3 {len(sides)} 4 0 0 0 0 1 0\n" + "".join("{} {} {} {} {}\n".format(*line) for line in sides)
                                  + "5 9\n" + in_geometry)
    (folder / "g.ana").write_text("0 60 1 2 0.05 0.01\n2600 26000 1e10 0.25\n0 0 0\n0 0 0\n0 0 0\n35 1e9 1e9\n45 1e9 1e9\n&deck geometry='g.geo' /\n"
                                  "&step balance=1e-4 /\n&support both=0 0 10 0 /\n" + groups
                                  + f"&stage name='heading'{removed[0]} /\n&stage name='bench'{removed[1]} /\n")
    return folder / "g.ana"


def sides(outline):
    numbers = [float(word) for word in outline.split()]
    return [(*numbers[k:k + 4], 2) for k in range(0, len(numbers) - 2, 2)]


def run(folder, *given, **more):
    result = scree.run(decks(folder, *given, **more), output=folder / "g.h5")
    return result.history.area[:], result.bodies.stress[:], result.measured_points.displacement[:]


def same(a, b):
    for one, other in zip(a, b):
        np.testing.assert_array_equal(one, other)


def test_outlines_are_the_joints_and_the_removal_by_hand(tmp_path):
    found = run(tmp_path, f"&excavation outline={OUTLINE} {BENCH}, stage='heading, bench', joint=2 /\n")
    by_hand = run(tmp_path, "", lines=sides(OUTLINE) + sides(BENCH), removed=(f", remove_inside={OUTLINE}", f", remove_inside={BENCH}"))
    same(found, by_hand)
    assert found[0][[0, -1]] == pytest.approx([100, 100 - 12 - 8], rel=1e-4)


def test_an_outline_adds_to_what_its_stage_removes(tmp_path):
    found = run(tmp_path, f"&excavation outline={OUTLINE}, stage='heading', joint=2 /\n", removed=(f", remove_inside={BENCH}", ""), lines=sides(BENCH))
    assert found[0][-1] == pytest.approx(80, rel=1e-4)


def test_explain_shows_what_the_stages_remove(tmp_path):
    text = scree.call("check", decks(tmp_path, f"&excavation outline={OUTLINE}, stage='bench', joint=2 /\n"), cwd=tmp_path).stdout
    assert "stage 3 (bench): static; removes 2 of 4 blocks" in text, text


def test_a_model_keeps_the_group(tmp_path):
    first = scree.Model.read(decks(tmp_path, f"&excavation outline={OUTLINE} {BENCH}, stage='heading, bench', joint=2 /\n")).save(tmp_path / "first.ana")
    assert "&excavation" in first.read_text() and "remove_inside" not in first.read_text()
    second = scree.Model.read(first).save(tmp_path / "second.ana")
    assert second.read_text() == first.read_text().replace("first.", "second.")


@pytest.mark.parametrize("groups, expected", [
    ("&excavation outline=0 0 1 0 1 1, stage='heading' /\n", "three or more of each and its first again, in excavation.outline"),
    (f"&excavation outline={OUTLINE}, stage='benh' /\n", "the name of a later stage for polygon 1 in excavation.stage, found 'benh'"),
    (f"&excavation outline={OUTLINE} {BENCH}, stage='bench' /\n", "a stage for each of the 2 polygons of excavation.outline, found 'bench'"),
    (f"&excavation outline={OUTLINE}, stage='bench, heading' /\n", "1 stages, one for each polygon, found 'bench, heading'"),
    (f"&excavation outline={OUTLINE}, stage='bench', joint=1 2 /\n", "excavation.joint with one number or 1, one for each polygon"),
    (f"&excavation outline={OUTLINE} /\n", "only with excavation.stage"), ("&excavation stage='bench' /\n", "only with excavation.outline"),
    ("&excavation outline=20 20 21 20 21 21 20 20, stage='bench' /\n", "blocks in the polygons of stage.remove_inside, found none")])
def test_bad_outlines_are_refused_with_their_line(groups, expected, tmp_path):
    done = scree.call("check", decks(tmp_path, groups), cwd=tmp_path)
    assert done.returncode == 2 and expected in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"scree: {tmp_path}/g.ana:11: "), done.stderr


def test_finished_blocks_are_not_cut(tmp_path):
    deck = decks(tmp_path, f"&excavation outline={OUTLINE}, stage='bench' /\n")
    assert scree.call("cut", "g.geo", "-o", "g.blk", cwd=tmp_path).returncode == 0
    deck.write_text(deck.read_text().replace("g.geo", "g.blk"))
    done = scree.call("check", deck, cwd=tmp_path)
    assert done.returncode == 2 and "found finished blocks, which stage.remove_inside removes" in done.stderr, done.stderr
