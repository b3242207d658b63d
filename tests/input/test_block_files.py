"""Block files: what bounds a block is read, what does not is refused with the line at which it stands."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file

SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
BESIDE = [(1, 0), (2, 0), (2, 1), (1, 1)]
OUTER = [(0, 0), (3, 0), (3, 3), (0, 3)]
OUTLINE_AT = 5  # the line at which the outline of the only block begins, after the title, two lines of counts and its rows


def analysis(joints=1, groups=""):
    """One block material; blocks under gravity."""
    return f"1 1 1 {joints} 0.05 0.001\n2500 25000 1e9 0.3\n" + "0 0 0\n" * 3 + "30 0 0\n" * joints + groups


def check(folder, text, ana=analysis(), verb="check", *words):
    (folder / "b.blk").write_text(text)
    (folder / "b.ana").write_text(ana)
    return scree.call(verb, "b.blk", "b.ana", *words, cwd=folder)


def refused(done, line, *said):
    """One line, status 2, the place and what was expected."""
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr + done.stdout
    assert done.stderr.startswith(f"scree: b.blk:{line}: expected ") and all(word in done.stderr for word in said), done.stderr


def with_hole(hole, outer=OUTER):
    """The polygon of an outline and a hole: out along the seam between their first corners, around, and back."""
    return [*outer, outer[0], *hole, hole[0]]


# Outlines that bound no block, or not one: corners, the corner (from 0) at whose line the error stands, what is said of it.
NO_BLOCK = {
    "a bow tie": ([(0, 0), (3, 0), (3, 3), (1, -1)], 0, "crosses itself"),
    "a small tangle": ([(0, 0), (1, 0), (1, .5), (1.001, .501), (1.001, .5), (1, .501), (1, 1), (0, 1)], 0, "crosses itself"),
    "a bow tie with a corner in its knot": ([(0, 0), (1, 0), (2, 1), (3, 0), (3, 2), (2, 1), (1, 2), (0, 2)], 0, "falls apart"),
    "twice around": (SQUARE + SQUARE, 0, "runs once around one area"),
    "clockwise": (SQUARE[::-1], 0, "whose vertices go clockwise"),
    "without area": ([(0, 0), (1, 0), (2, 0)], 0, "without area, or whose edges cross"),
    "a bow tie of two alike": ([(0, 0), (1, 1), (1, 0), (0, 1)], 0, "without area, or whose edges cross"),
    "a bow tie, more of it clockwise": ([(0, 0), (3, 3), (3, -1), (1, 2)], 0, "whose edges cross"),
    "a spike": ([(0, 0), (1, 0), (1, .5), (2, .5), (1, .5), (1, 1), (0, 1)], 3, "fold back"),
    "a spike at its begin": ([(2, .5), (1, .5), (1, 1), (0, 1), (0, 0), (1, 0), (1, .5)], 0, "fold back"),
    "a spike inwards": ([(0, 0), (1, 0), (1, .5), (.5, .5), (1, .5), (1, 1), (0, 1)], 3, "fold back"),
    "a needle": ([(0, 0), (1, 0), (.5, 1e-9)], 0, "fold back"),
    "a corner twice": ([(0, 0), (1, 0), (1, 0), (1, 1), (0, 1)], 2, "farther than 1e-8 of its size"),
    "its first corner again": ([*SQUARE, (0, 0)], 0, "farther than 1e-8 of its size"),
    "corners 1e-13 apart": ([(0, 0), (1 - 1e-13, 0), (1, 0), (1, 1), (0, 1)], 2, "farther than 1e-8 of its size"),
    "one place": ([(1, 1)] * 4, 0, "farther than 1e-8 of its size"),
    "a hole that turns as the outline": (with_hole([(1, 1), (2, 1), (2, 2), (1, 2)]), 0, "runs once around one area"),
    "a hole outside": (with_hole([(-2, -2), (-2, -1), (-1, -1), (-1, -2)]), 0, "runs once around one area"),
    "a hole that reaches out": (with_hole([(1, 1), (1, 4), (2, 4), (2, 1)]), 0, "crosses itself"),
}
# Outlines that bound one: corners and area. Some touch themselves, by the last digits across.
BLOCK = {
    "a square": (SQUARE, 1),
    "corners on its sides": ([(0, 0), (.5, 0), (1, 0), (1, .3), (1, 1), (0, 1)], 1),
    "corners 1e-6 apart": ([(0, 0), (1 - 1e-6, 0), (1, 0), (1, 1), (0, 1)], 1),
    "a sliver": ([(0, 0), (1, 0), (.5, 1e-6)], .5e-6),
    "a ring": (with_hole([(1, 1), (1, 2), (2, 2), (2, 1)]), 8),
    "a hole that touches the side": (with_hole([(1, 1), (1.5, 3), (2, 1)]), 8),
    "a seam without length": ([(0, 0), (3, 0), (3, 3), (1.5, 3), (1.5, 3), (2, 1), (1, 1), (1.5, 3), (1.5, 3), (0, 3)], 8),
    "a ring that is closed but not joined": ([(0, 0), (3, 0), (3, 1.5), (2.2, 1.5), (2.2, 1), (1, 1), (1, 2), (2, 2), (2, 1.5),
                                              (3, 1.5), (3, 3), (0, 3)], 8 - .1),
    "the same, rounded": ([(0, 0), (3, 0), (3, 1.5000001), (2.2, 1.5000001), (2.2, 1), (1, 1), (1, 2), (2, 2), (2, 1.5),
                           (3, 1.5), (3, 3), (0, 3)], 8 - .1),
}
# Edge of the scene and how far it lies from the origin.
PLACES = [(1, 0), (1e-3, 0), (1e3, 0), (1, 1e4)]


@pytest.mark.parametrize("size, away", PLACES)
@pytest.mark.parametrize("name", NO_BLOCK)
def test_an_outline_that_bounds_no_block_is_refused(name, size, away, tmp_path):
    corners, at, said = NO_BLOCK[name]
    done = check(tmp_path, block_file(name, [(1, size * (np.array(corners, float) + away))]))
    refused(done, OUTLINE_AT + at, "block 1", said)


@pytest.mark.parametrize("size, away", PLACES)
@pytest.mark.parametrize("name", BLOCK)
def test_an_outline_that_bounds_a_block_is_read_with_its_area(name, size, away, tmp_path):
    corners, area = BLOCK[name]
    done = check(tmp_path, block_file(name, [(1, size * (np.array(corners, float) + away))]), analysis(), "cut", "-o", "m.h5")
    assert done.returncode == 0, done.stderr
    f = scree.read(tmp_path / "m.h5")
    # what is rounded is a place, by half a unit of its last digit, at a side of the size 3 each
    assert abs(f.bodies.area[0, 0] / size**2 - area) < 1e-6 * 0.3 + 20 * np.spacing(1.0 * away + 3)


def test_the_line_is_that_of_the_second_block(tmp_path):
    text = block_file("two", [(1, SQUARE), (1, [(1, 0), (4, 0), (4, 3), (2, -1)])])
    refused(check(tmp_path, text), 6 + 8, "block 2", "crosses itself")


@pytest.mark.parametrize("joint, said", [(0, "at least 1"), (-3, "at least 1"), (2, "up to 1"), (1000000, "up to 1"),
                                         (1.5, "whole number"), (1e12, "whole number")])
@pytest.mark.parametrize("edge", range(4))
def test_a_joint_material_that_is_not_there_is_refused(joint, said, edge, tmp_path):
    joints = [1] * 4
    joints[edge] = joint
    text = block_file("two squares", [(1, SQUARE), (1, BESIDE, joints)])
    # The joint of an edge stands where the edge ends; of the last one, where the block begins.
    refused(check(tmp_path, text), 14 + (edge + 1) % 4, said)


def test_joint_materials_up_to_the_last_are_read(tmp_path):
    text = block_file("two squares", [(1, SQUARE, [1, 2, 3, 2]), (1, BESIDE, [3, 3, 1, 2])])
    assert check(tmp_path, text, analysis(3)).returncode == 0
    refused(check(tmp_path, text, analysis(2)), 6 + 3, "up to 2")


def test_blocks_that_may_touch_need_joint_materials(tmp_path):
    two = block_file("two squares", [(1, SQUARE), (1, BESIDE)])
    refused(check(tmp_path, two, analysis(0)), 7, "up to 0")
    assert check(tmp_path, two, analysis(0, "&contact method='none' /\n")).returncode == 0
    assert check(tmp_path, block_file("a square", [(1, SQUARE)]), analysis(0)).returncode == 0


def test_a_block_material_that_is_not_there_is_refused(tmp_path):
    text = block_file("two squares", [(1, SQUARE), (2, BESIDE)])
    refused(check(tmp_path, text), 5, "block material up to 1")


@pytest.mark.parametrize("kind", ["fixed", "load", "measured"])
@pytest.mark.parametrize("size", [1, 1e-3, 1e3])
def test_a_point_belongs_to_the_block_that_it_names(kind, size, tmp_path):
    blocks = [(1, size * np.array(SQUARE)), (1, size * np.array(BESIDE))]
    for x, y, number, outside in [(.5, .5, 1, 0), (1, 1, 1, 0), (1, .5, 2, 0), (1 + 1e-6, .5, 1, 0), (1 + 2e-5, .5, 1, 2e-5),
                                  (.5, .5, 2, .5), (50, .5, 1, 49), (1.5, -3, 1, np.hypot(3, .5))]:
        text = block_file("two squares", blocks, **{kind: [(size * x, size * y, number)]})
        done = check(tmp_path, text)
        if not outside:
            assert done.returncode == 0, done.stderr
            continue
        refused(done, 6 + 16, f"a {kind} point in its block {number}")
        said = float(done.stderr.split("found one ")[1].split()[0])
        assert abs(said - size * outside) < 1e-12 * size * (1 + outside)


def test_a_point_in_a_hole_is_outside(tmp_path):
    text = block_file("ring", [(1, with_hole([(1, 1), (1, 2), (2, 2), (2, 1)]))], load=[(1.5, 1.5, 1)])
    refused(check(tmp_path, text), OUTLINE_AT + 14, "load point", "0.5 outside")


def test_a_block_far_smaller_than_the_model_is_refused(tmp_path):
    text = block_file("a grain and the moon", [(1, SQUARE), (1, 1e10 * np.array(BESIDE))])
    refused(check(tmp_path, text), 6, "larger than 1e-9 of the model", "block 1")


@pytest.mark.parametrize("groups", ["&method strain='small' /", "&method strain='green' /", "&method model='nmm', strain='green' /",
                                    "&method preset='shi' /"])
def test_a_block_that_flies_beyond_its_digits_ends_the_run_by_name(groups, tmp_path):
    """At 1e19 m its corners would be one place."""
    ana = analysis(1, groups + "\n&contact method='none' /\n&step size=0.1, count=3 /\n").replace("0 0 0\n30", "0 1e20 0\n30")
    done = check(tmp_path, block_file("two squares", [(1, SQUARE), (1, BESIDE)]), ana, "run", "-o", "r.h5", "--quiet")
    errors = [line for line in done.stderr.splitlines() if "warning" not in line]
    assert done.returncode == 1 and len(errors) == 1, done.stderr
    assert all(word in errors[0] for word in ("step 1 to time 0", "block 1, (", "it is lost", "; try ")), done.stderr


def test_what_the_cutter_writes_is_read_again(tmp_path):
    """Blocks of lines at random, with holes and short edges, come back as they were."""
    random = np.random.default_rng(5)
    lines = [(0, 0, 1, 0), (1, 0, 1, 1), (1, 1, 0, 1), (0, 1, 0, 0), *random.random((40, 4)),
             (.30, .30, .31, .30), (.31, .30, .30, .31), (.30, .31, .30, .30)]
    (tmp_path / "r.geo").write_text(f"0 {len(lines)} 4 0 0 0 0 0 0\n" + "".join(f"{a} {b} {c} {d} 1\n"
                                                                            for a, b, c, d in np.array(lines).tolist()))
    areas = []
    for words in (["r.geo", "-o", "r.blk"], ["r.blk", "-o", "s.blk"]):
        done = scree.call("cut", *words, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        areas.append([float(line.split()[4]) for line in done.stdout.splitlines()[2:]])
    np.testing.assert_allclose(areas[0], areas[1], rtol=1e-9, atol=1e-15)


def test_many_blocks_and_a_block_of_many_corners_are_read(tmp_path):
    """40 000 blocks, each with a load, and 40 000 corners: the square of that would take minutes."""
    n = 200
    corners = 0.9 * np.array(SQUARE) + np.array([(i, j) for i in range(n) for j in range(n)])[:, None]
    loads = [(*c.mean(0), b) for b, c in enumerate(corners, 1)]
    (tmp_path / "b.ana").write_text(analysis(1, f"&loads force={' '.join(['1 0'] * n * n)} /\n"))
    (tmp_path / "b.blk").write_text(block_file("many", [(1, c) for c in corners], load=loads))
    done = scree.call("check", "b.blk", "b.ana", cwd=tmp_path, timeout=60)
    assert done.returncode == 0 and f"{n * n} blocks" in done.stdout and f"{n * n} load points" in done.stdout, done.stderr
    angle = 2 * np.pi * np.arange(n * n) / (n * n)
    wheel = (1 + 0.01 * (np.arange(n * n) % 2))[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    (tmp_path / "b.ana").write_text(analysis())
    (tmp_path / "b.blk").write_text(block_file("a wheel", [(1, wheel)]))
    done = scree.call("check", "b.blk", "b.ana", cwd=tmp_path, timeout=60)
    assert done.returncode == 0, done.stderr


def test_the_costs_of_a_run_show_what_reading_took(tmp_path):
    done = check(tmp_path, block_file("a square", [(1, SQUARE)]), analysis(), "run", "-o", "r.h5")
    assert done.returncode == 0, done.stderr
    f = scree.read(tmp_path / "r.h5")
    assert list(f.cost.phase) == ["read", "set-up", "search", "alone", "check", "update", "history", "frames", "other"]
    assert f.cost.calls[0] == 1 and f.cost.wall_seconds[0] > 0


def test_names_may_be_in_capitals(tmp_path):
    """As those of files that came by other systems."""
    (tmp_path / "B.BLK").write_text(block_file("One", [(1, SQUARE)]))
    (tmp_path / "B.ANA").write_text(analysis())
    assert scree.call("check", "B.BLK", "B.ANA", cwd=tmp_path).returncode == 0
    (tmp_path / "D.ANA").write_text(analysis(groups="&deck geometry='B.BLK' /\n"))
    done = scree.call("cut", "D.ANA", "-o", "m.h5", cwd=tmp_path)
    assert done.returncode == 0 and (tmp_path / "m.h5").exists(), done.stderr
