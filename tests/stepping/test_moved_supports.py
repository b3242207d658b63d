"""Supports at points, and supports that move by a velocity or a table."""
import numpy as np
import pytest
import scree

E, SIZE = 1e9, 2.0
COMPRESSION = "&support y=0 0 2 0, points_x=1 0, {} /\n"


def decks(folder, groups, steps=20, k01=0, size=0.05, weight=0.0, joint="30 0 0", lines=()):
    """A block of 2 m by 1 m, cut by more lines."""
    sides = [(0, 0, 2, 0), (2, 0, 2, 1), (2, 1, 0, 1), (0, 1, 0, 0), *lines]
    (folder / "box.geo").write_text(f"1e-3 {len(sides)} 4 0 0 0 0 1 0\n" + "".join("{} {} {} {} 1\n".format(*line) for line in sides) + "1 0.5\n")
    (folder / "box.ana").write_text(f"{k01} {steps} 1 1 0.05 {size}\n2500 {weight} {E} 0.25\n0 0 0\n0 0 0\n0 0 0\n{joint}\n"
                                    f"&deck geometry='box.geo' /\n{groups}")
    return folder / "box.ana"


def run(folder, groups, *settings, **more):
    return scree.run(decks(folder, groups, **more), settings=settings, output=folder / "box.h5")


@pytest.mark.parametrize("motion", ["velocity=0 -1e-6", "table=0 0 0  1 0 -1e-6",
                                    "moved=0 1 1 1  1 1 2 1, velocity=0 -1e-6  0 -1e-6"])
@pytest.mark.parametrize("groups", ["", "&method model='nmm' /\n&cover edge=0.3 /\n", "&fixed_points method='penalty', stiffness=1e14 /\n"])
def test_a_moved_side_compresses_a_block_as_hooke_has_it(motion, groups, tmp_path):
    """Without friction at the sides the stress is E times the shortening over the height, and the sides are free of stress."""
    result = run(tmp_path, COMPRESSION.format(("" if "moved" in motion else "moved=0 1 2 1, ") + motion) + groups, "method.strain=small")
    assert result.scene.status == "complete" and result.history.time[-1] == pytest.approx(1)
    bodies = result.bodies.stress[-1, 0]
    assert bodies == pytest.approx([0, -E * 1e-6, 0], abs=3e-5 * E * 1e-6)
    assert result.measured_points.displacement[-1, 0, 1] == pytest.approx(-5e-7, rel=1e-4)  # static steps have inertia


def test_a_velocity_is_the_table_of_its_displacements(tmp_path):
    """The same bits, also where the table has the displacement of a time after the end."""
    def moved(motion):
        result = run(tmp_path, COMPRESSION.format("moved=0 1 2 1, " + motion))
        return result.measured_points.displacement, result.bodies.stress[-1]

    a, b = moved("velocity=0 -1e-3"), moved("table=0 0 0  4 0 -4e-3")
    np.testing.assert_array_equal(a[0], b[0])
    np.testing.assert_array_equal(a[1], b[1])


def test_a_table_ends_where_it_ends_and_the_next_stage_holds_it_there(tmp_path):
    stages = "&stage name='held' /\n&stage name='back' /\n&support moved=none, y=0 0 2 0  0 1 2 1 /\n&stage name='up' /\n" \
             "&support y=0 0 2 0, moved=0 1 2 1, velocity=0 1e-3 /\n"
    result = run(tmp_path, COMPRESSION.format("moved=0 1 2 1, table=0 0 0  0.5 0 -1e-3") + stages, "method.strain=small")
    height, stage = result.measured_points.displacement[:, 0, 1], result.history.stage
    assert height[result.history.time <= 0.5][-1] == pytest.approx(-5e-4, rel=1e-5)
    assert height[stage == 1][-1] == pytest.approx(-5e-4, rel=1e-5)
    assert np.ptp(height[(stage == 2) | (stage == 3)]) < 1e-9
    assert height[-1] == pytest.approx(0, abs=1e-8)


def test_a_moved_line_leaves_edges_free_across_its_motion(tmp_path):
    """A traction along the moved side shears nothing, as the side slides; held across, it does."""
    groups = COMPRESSION.format("moved=0 1 2 1, velocity=0 -1e-3").replace("points_x=1 0", "x=0 0 2 0") + "&boundary lines=0 1 2 1, traction=1e6 0 1e6 0 /\n"
    free = run(tmp_path, groups).bodies.stress[-1, 0, 2]
    held = run(tmp_path, groups.replace("x=0 0 2 0", "x=0 0 2 0  0 1 2 1")).bodies.stress[-1, 0, 2]
    assert free == pytest.approx(1e6, rel=1e-2) and abs(held) < 1e-6 * free


def test_a_curved_table_moves_a_side_both_ways(tmp_path):
    result = run(tmp_path, "&support both=0 0 2 0, moved=0 1 2 1, table=0 0 0  0.5 1e-3 0  1 1e-3 -1e-3 /\n", "method.strain=small")
    assert result.measured_points.displacement[9, 0] == pytest.approx([5e-4, 0], abs=1e-9)
    assert result.measured_points.displacement[-1, 0] == pytest.approx([5e-4, -5e-4], abs=1e-9)


def test_points_bear_a_beam_and_let_it_slide(tmp_path):
    """A block on two points that hold it along y: half its weight on each; a force along x moves it away."""
    ends = "&support points_y=0.2 0  1.8 0{} /\n"
    result = run(tmp_path, ends.format(", points_x=1 0.5"), "step.balance=1e-9", weight=25e3, steps=100)
    assert result.scene.status == "complete" and abs(result.measured_points.displacement[-1, 0, 0]) < 1e-12
    slides = run(tmp_path, ends.format("") + "&boundary lines=0 0 0 1, traction=1e3 0 1e3 0 /\n", weight=25e3, k01=1, size=0.01)
    way = slides.measured_points.displacement[-1, 0]
    assert way[0] == pytest.approx(1e3 / 5e3 * 0.2 ** 2 / 2, rel=0.06) and abs(way[1]) < 1e-4


def test_small_steps_take_rigid_blocks_along(tmp_path):
    result = run(tmp_path, "&support points=0.2 0.5  1.8 0.5 /\n&stage name='go' /\n&support points=none, y=0 0 2 0, moved=0 0 0 1, velocity=0.5 0 /\n",
                 "integrator.scheme=small_steps", k01=1, steps=50, size=0.02)
    way, stage = result.measured_points.displacement[:, 0, 0], result.history.stage
    assert abs(way[stage == 1]).max() < 1e-9
    assert way[-1] == pytest.approx(0.5, rel=2e-3)


def test_a_restart_goes_on_with_the_same_bits(tmp_path):
    whole = run(tmp_path, COMPRESSION.format("moved=0 1 2 1, velocity=0 -1e-3")).bodies.stress[-1].tobytes()
    run(tmp_path, COMPRESSION.format("moved=0 1 2 1, velocity=0 -1e-3"), "step.count=7")
    done = scree.call("run", "--restart", "box.h5", "--set", "step.count=20", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert scree.read(tmp_path / "box.h5").bodies.stress[-1].tobytes() == whole


@pytest.mark.parametrize("groups, expected", [
    ("&support moved=0 1 2 1 /\n", "only with support.velocity or support.table"),
    ("&support velocity=0 1 /\n", "only with support.moved"),
    ("&support moved=0 1 2 1, velocity=0 1 2 /\n", "vx vy of all lines of support.moved, or of each of the 1, found 3 numbers"),
    ("&support moved=0 1 2 1, velocity=0 0 /\n", "lines of support.moved that move in support.velocity, found one that does not"),
    ("&support moved=0 1 2 1, table=0 0 0  0 1 0 /\n", "times of support.table that increase, found 0 after 0"),
    ("&support moved=0 1 2 1, table=0 0 0  1 0 0 /\n", "found one that does not"),
    ("&support moved=0 1 2 1, table=0 0 0 1 /\n", "t ux uy of support.table at two times or more, found 4 numbers"),
    ("&support moved=0 1 2 1, table=0 0 0  1 0 1, velocity=0 1 /\n", "without support.velocity"),
    ("&support moved=0 1 2 1, velocity=0 1 /\n&step balance=1e-4 /\n", "without step.balance"),
    ("&support moved=0 5 2 5, velocity=0 1 /\n", "lines that edges of blocks lie on in support.moved, found none on line 1"),
    ("&support points=0 5 /\n", "points of blocks in support.points, found no block at point 1, (0, 5)"),
    ("&support points_x=0 5 1 /\n", "two numbers x y for each point in support.points_x, found 3")])
def test_bad_motions_are_refused_with_their_line(groups, expected, tmp_path):
    done = scree.call("run", decks(tmp_path, groups), cwd=tmp_path)
    assert done.returncode == 2 and expected in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"scree: {tmp_path}/box.ana:"), done.stderr
