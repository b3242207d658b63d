"""step.sleep through the program: what rests falls asleep and costs next to nothing; what wakes it moves it as without sleep."""
import os
import shutil

import numpy as np
import pytest
import scree
from scree.bench.effects import Counter
from scree.block_files import block_file, box, held

SCREE = os.environ["SCREE"]
GROUND = (1, box(-2, 8, -1, 0))
STACK = [GROUND, *((1, box(0, 1, i / 2, i / 2 + 0.5)) for i in range(3)), (1, box(3, 4, 0, 1))]
WALL = [GROUND, *((1, box(i / 2, i / 2 + 0.5, j / 4, j / 4 + 0.25)) for j in range(4) for i in range(3))]


def decks(folder, blocks, *, steps=600, dt=0.005, groups="", velocity=0.0, gravity=9.81, young=1e10, tables=(), load=(), carried=1):
    """Blocks on the first, which is held at its corners; material 2 has the velocity. Tables: of its points, then of loads."""
    (folder / "x.blk").write_text(block_file("x", blocks, held(GROUND[1] if blocks[0] is GROUND else blocks[0][1], 1), load))
    rows = [f"{carried} {steps} 2 1 0.05 {dt} 0"]
    tables = list(tables) or [[]] * 4
    rows.append(" ".join(str(len(table)) for table in tables))
    rows += [" ".join(str(float(x)) for x in row) for table in tables for row in table]
    rows += [f"2500 {2500 * gravity} {young} 0.25\n0 0 0\n0 0 0\n{speed} 0 0" for speed in (0.0, velocity)]
    (folder / "x.ana").write_text("\n".join([*rows, "30 0 0", "&deck dialect='shi' /", groups, ""]))
    return [folder / "x.blk", folder / "x.ana"]


def awake_and_asleep(folder, *given, share=1e-3):
    """The run without sleep and with it."""
    return [scree.run(*given, output=folder / f"{share}.h5", settings=[f"step.sleep={share}"])
            for share in (0.0, share)]


def dominoes(folder, size=1.0, **given):
    """Five in a row; the first is pushed by 0.3 of its weight from time 1, in units of the time in which the size falls."""
    unit = np.sqrt(size / 9.81) * 3.13
    blocks = [(1, size * box(-1, 4.5, -0.5, 0)), *((1, size * box(x, x + 0.2, 0, 1)) for x in np.arange(5) / 2)]
    weight = 2500 * 9.81 * 0.2 * size**2
    push = [(0, 0, 0), (unit, 0, 0), (1.0001 * unit, 0.3 * weight, 0), (1.3 * unit, 0.3 * weight, 0), (1.3001 * unit, 0, 0),
            (9 * unit, 0, 0)]
    return decks(folder, blocks, dt=0.005 * unit, steps=540, tables=[*[[]] * 4, push], load=[(0.01 * size, 0.95 * size, 2)],
                 **given)


def farthest(a, b):
    """Largest difference of a place of a body in any frame."""
    return np.abs(a.bodies.centroid - b.bodies.centroid).max()


@pytest.mark.parametrize("size, given", [(1e-3, {"young": 1e7}), (1.0, {}), (1e3, {"young": 1e12}),
                                         (1.0, {"groups": "&method strain='green' /"}),
                                         (1.0, {"groups": "&method strain='auto' /"}),
                                         (1.0, {"groups": "&method model='nmm' /\n&cover edge=0.25 /"})])
def test_dominoes_that_sleep_fall_as_those_that_are_awake(size, given, tmp_path):
    """What they moved when they fell asleep is below the share asked for, and so is what that comes to until the last but one is
    struck, though each blow on springs makes it grow, by up to a hundred; a share of a thousandth of it leaves as much less."""
    for share in (1e-3, 1e-6):
        a, b = awake_and_asleep(tmp_path, *dominoes(tmp_path, size, **given), share=share)
        assert np.all(a.bodies.rotation[-1, 1:5] < -0.3)  # they do fall
        asleep = b.history.asleep
        assert asleep[190] >= 5 and asleep[-1] == 0  # before the push; the last is struck
        assert np.sum(b.history.solves) < np.sum(a.history.solves) - 100
        struck = np.argmax(a.bodies.rotation[:, 4] < -1e-3)  # the last but one, while the last sleeps
        assert np.abs(a.bodies.centroid - b.bodies.centroid)[:struck].max() < share * size
        assert np.abs(a.bodies.rotation - b.bodies.rotation)[:struck].max() < share / 0.2  # of which they are thick


@pytest.mark.parametrize("groups, tolerance", [("", 1e-9), ("&method strain='green' /", 1e-9),
                                               ("&method strain='small' /\n&contact method='augmented' /", 1e-6)])  # it leaves an overlap of 1e-7 of the size
def test_a_wall_that_sleeps_wakes_as_a_whole_when_a_block_falls_on_it(groups, tolerance, tmp_path):
    given = decks(tmp_path, [*WALL, (1, box(0.3, 0.7, 6, 6.4))], steps=300, groups=groups)
    a, b = awake_and_asleep(tmp_path, *given)
    assert farthest(a, b) < tolerance
    struck = np.flatnonzero(np.diff(b.history.asleep) < 0)[0]
    # the step before in which it falls 5 m to the wall: free fall by Newmark's step is as long, to a step
    assert b.history.time[struck] == pytest.approx(np.sqrt(2 * 5 / 9.81), abs=0.006)
    assert set(b.history.asleep[:struck + 3]) == {0, 12}
    # what sleeps touches as before, in the history and in the frames
    quiet = slice(100, struck)
    if "augmented" not in groups:  # whose multipliers let springs and contacts change for ever
        np.testing.assert_array_equal(a.history.contacts[quiet], b.history.contacts[quiet])
        np.testing.assert_allclose(a.history.energy.contact[quiet], b.history.energy.contact[quiet], rtol=1e-9)
        np.testing.assert_array_equal(a.contacts.count, b.contacts.count)
    frame = np.flatnonzero(b.bodies.asleep[:, 1] > 0)[0]
    np.testing.assert_array_equal(b.bodies.asleep[frame], [0, *[2] * 12, 0])  # the first of the island is block 2


@pytest.mark.parametrize("groups, tables", [
    ("&acceleration table=0 0 0  1.5 0 0  1.6 7 0  1.9 -7 0  2.2 0 0 /", ()),
    ("", [[(0, 0, 0), (1.5, 0, 0), (1.7, 0.2, 0), (3, 0.2, 0)]] * 4),
    ("&fixed_points method='penalty' /", [[(0, 0, 0), (1.5, 0, 0), (1.7, 0.2, 0), (3, 0.2, 0)]] * 4)])
def test_the_ground_and_its_supports_wake_what_stands_on_it(groups, tables, tmp_path):
    a, b = awake_and_asleep(tmp_path, *decks(tmp_path, STACK, groups=groups, tables=tables))
    assert farthest(a, b) < 1e-6
    assert np.abs(a.bodies.centroid[-1] - a.bodies.centroid[0]).max() > 1e-3  # it moved
    asleep = b.history.asleep
    assert asleep[290] >= 4 and asleep[320] == 0 and asleep[-1] >= 4


def test_a_load_wakes_from_the_share_of_the_weight_on(tmp_path):
    for force, wakes in ((0.9, False), (1.1, True)):  # of the share, 0.05; each change is as small as one likes
        push = 0.05 * force * 2500 * 9.81
        given = decks(tmp_path, STACK, load=[(3.1, 0.5, 5)], tables=[*[[]] * 4, [(0, 0, 0), (1, 0, 0), (2, push, 0), (9, push, 0)]])
        asleep = scree.run(*given, output=tmp_path / "x.h5", settings=["step.sleep=0.05"]).history.asleep
        assert np.any(asleep[200:] < 4) == wakes


def test_the_motion_that_falls_asleep_is_booked(tmp_path):
    """A block slides and falls asleep on its way: half m v^2, v0 - mu g t, and no energy changes afterwards."""
    given = decks(tmp_path, [GROUND, (2, box(0, 1, 0, 1))], steps=60, velocity=2.0)
    a, b = awake_and_asleep(tmp_path, *given, share=0.9)
    k = np.flatnonzero(b.history.asleep)[0]
    a, b = a.history.energy, b.history.energy
    assert b.asleep[k] == pytest.approx(0.5 * 2500 * (2 - np.tan(np.radians(30)) * 9.81 * 0.005 * (k + 1))**2, rel=0.02)
    assert b.kinetic[k] == b.held[k] == 0 and a.kinetic[k] + a.held[k] == pytest.approx(b.asleep[k], rel=1e-12)
    assert b.dissipated[k] - a.dissipated[k] == pytest.approx(b.asleep[k], rel=1e-9)
    for book in (b.asleep, b.dissipated, b.strain, b.gravity, b.contact, b.friction):
        assert np.all(book[k:] == book[k])


def test_two_threads_give_the_bits_of_one(tmp_path):
    given = dominoes(tmp_path)
    runs = [scree.run(*given, output=tmp_path / f"{n}.h5", settings=["step.sleep=1e-3"],
                      env={**os.environ, "OMP_NUM_THREADS": n, "OPENBLAS_NUM_THREADS": n}) for n in "12"]
    for name in ("centroid", "rotation", "velocity", "stress", "asleep"):
        one, two = (getattr(run.bodies, name) for run in runs)
        assert one.tobytes() == two.tobytes()


@pytest.mark.skipif(not shutil.which("valgrind"), reason="instructions are counted by valgrind")
def test_five_that_move_among_500_cost_at_most_three_times_themselves(tmp_path):
    """500 squares apart on the ground, of which five slide; counts of instructions have no noise."""
    each = []
    for n, words in ((0, ()), (495, ("--set", "step.sleep=1e-3"))):
        ground = (1, box(-2, 2500, -1, 0))
        squares = [(2 if i < 5 else 1, box(4 * i, 4 * i + 1, 0, 1)) for i in range(5 + n)]
        given = decks(tmp_path, [ground, *squares], steps=80, velocity=3.0, groups="&output every=60 /")
        each.append(Counter(SCREE).instructions(["run", *given, "-o", tmp_path / f"{n}.h5", "--quiet", *words], frame=1))
    assert each[1] < 3 * each[0]


@pytest.mark.parametrize("given, words", [({"carried": 0}, "k01 above 0"), ({"groups": "&method preset='shi' /"}, "contact.rules="),
                                          ({"gravity": 0.0}, "blocks with weight"),
                                          ({"groups": "&contact method='none' /"}, "contact.method=")])
def test_sleep_is_refused_where_nothing_tells_rest_or_wakes(given, words, tmp_path):
    with pytest.raises(scree.RunFailed, match=words) as refusal:
        scree.run(*decks(tmp_path, STACK, **given), output=tmp_path / "x.h5", settings=["step.sleep=1e-3"])
    assert refusal.value.status == 2


def test_a_run_without_sleep_has_no_word_of_it(tmp_path):
    run = scree.run(*decks(tmp_path, STACK, steps=40, groups="&step sleep=0 /"), output=tmp_path / "x.h5")
    assert not hasattr(run.bodies, "asleep") and not hasattr(run.history, "asleep")


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_unless_it_is_told_otherwise_what_has_stopped_sleeps_and_is_where_it_would_be_awake(size, tmp_path):
    """A square that slides to a stop: nothing else is there, and 1e-8 is far below what a stop takes to come to rest."""
    blocks = [(1, size * box(-2, 8, -1, 0)), (2, size * box(0, 1, 0, 1))]
    given = decks(tmp_path, blocks, dt=0.005 * np.sqrt(size), velocity=2 * np.sqrt(size), young=1e10 * size)
    awake = scree.run(*given, output=tmp_path / "awake.h5", settings=["step.sleep=0"])
    usual = scree.run(*given, output=tmp_path / "usual.h5")
    assert usual.history.asleep[-1] == 1 and not hasattr(awake.history, "asleep")
    assert awake.bodies.centroid[-1, 1, 0] > 0.8 * size
    assert farthest(awake, usual) < 1e-12 * size


def test_one_body_alone_has_nothing_that_could_wake_it(tmp_path):
    given = decks(tmp_path, [GROUND], groups="&step sleep=1e-3 /", steps=3)
    assert not hasattr(scree.run(*given, output=tmp_path / "x.h5").history, "asleep")


def test_what_hands_on_little_of_its_velocity_rests_by_what_it_had(tmp_path):
    """A block on a slope of 30 degrees with friction of 20, k01 1/1000: it fell asleep with 18 % of its weight out of balance."""
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    turned = np.array([[c, s], [-s, c]])
    slope = (1, box(-3, 6, -1, 0) @ turned.T)
    given = decks(tmp_path, [slope, (1, box(-0.5, 0.5, 0, 0.5) @ turned.T)], steps=400, dt=0.001, carried=1e-3)
    given[1].write_text(given[1].read_text().replace("30 0 0", "20 0 0"))
    awake, asleep = awake_and_asleep(tmp_path, *given)
    assert np.linalg.norm(awake.bodies.centroid[-1, 1] - awake.bodies.centroid[0, 1]) > 4e-4
    assert farthest(awake, asleep) == 0


def test_what_sleeps_is_off_by_no_more_as_time_goes(tmp_path):
    """A block that slides to a stop, and sleeps: its error went on as if it moved."""
    given = decks(tmp_path, [GROUND, (2, box(0, 1, 0, 0.6))], steps=500, dt=0.002, velocity=1.5, groups="&output error='estimate' /")
    asleep = scree.run(*given, output=tmp_path / "a.h5", settings=["step.sleep=1e-8"])
    error, slept = asleep.history.error.displacement, asleep.history.asleep > 0
    assert 100 < slept.sum() < 450
    np.testing.assert_array_equal(error[slept], error[slept][0])
