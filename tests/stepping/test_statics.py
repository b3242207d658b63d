"""Static runs through the program: what they say of equilibrium, and that they end by it."""
import json

import numpy as np
import pytest
import scree
from scree import call
from scree import block_files
from scree.block_files import block_file, box, held
from scree.program import TREE
from scree.validation import references

DECKS = TREE / "input" / "validation"

GROUND = (1, box(-2, 8, -1, 0))


def decks(folder, phi=30.0, tilt=0.0, steps=40, dt=0.02, groups="", size=1.0):
    """A block of 1 x 1 on a plane that falls to the right by `tilt`, held at its corners."""
    turn = np.array([[np.cos(tilt), np.sin(tilt)], [-np.sin(tilt), np.cos(tilt)]])
    ground, block = size * box(-2, 8, -1, 0) @ turn.T, size * box(0, 1, 0, 1) @ turn.T
    (folder / "x.blk").write_text(block_file("x", [(1, ground), (1, block)], held(ground, 1)))
    (folder / "x.ana").write_text(f"0 {steps} 1 1 0.05 {dt}\n2500 24525 {1e9 * size} 0.25\n0 0 0  0 0 0  0 0 0\n{phi} 0 0\n{groups}\n")
    return [folder / "x.blk", folder / "x.ana"]


def summary(folder, *given, status=0):
    done = call("run", *given, "-o", folder / "r.h5", "--quiet", "--summary", "json")
    assert done.returncode == status, done.stderr
    return json.loads(done.stdout), done.stderr, scree.read(folder / "r.h5")


def test_a_block_that_slides_is_said_to(tmp_path):
    """sin a - cos a tan phi of its weight is out of balance; the run says so, where, and how it goes on."""
    said, warned, r = summary(tmp_path, *decks(tmp_path, phi=20.0, tilt=0.5))
    balance, expected = said["balance"], np.sin(0.5) - np.cos(0.5) * np.tan(np.radians(20))
    assert balance["share"] == pytest.approx(expected, rel=1e-3)
    assert balance["block"] == 2 and balance["tolerance"] == 1e-3 and balance["others"] == 0
    length = np.linalg.norm(balance["way"])
    np.testing.assert_allclose(balance["way"] / length, [np.cos(0.5), -np.sin(0.5)], atol=1e-4)
    assert length == pytest.approx(balance["speed"] * 0.02)
    assert said["status"] == r.scene.status and said["status"].startswith("not in equilibrium: block 2 at (")
    assert warned.count("warning: not in equilibrium: block 2") == 1 and said["warnings"] == 1
    assert (r.history.unbalanced[-1], r.history.unbalanced_block[-1]) == (balance["share"], 2)
    lines = call("run", *decks(tmp_path, phi=20.0, tilt=0.5), "-o", tmp_path / "r.h5").stdout
    assert "balance: not in equilibrium: block 2 at (" in lines and "ended: not in equilibrium at time 0.8 of 0.8" in lines


@pytest.mark.parametrize("groups", ["", "&method model='nmm' /", "&method strain='green' /", "&method preset='shi' /"])
def test_a_static_run_begins_at_rest(groups, tmp_path):
    """Blocks went their velocity times its first step, 0.6 m here, before they stood still."""
    given = decks(tmp_path, groups=groups)
    _, warned, r = summary(tmp_path, *given)
    still = r.bodies.centroid
    assert "velocity" not in warned
    given[1].write_text(given[1].read_text().replace("0 0 0  0 0 0  0 0 0", "0 0 0  0 0 0  0 30 1"))
    _, warned, r = summary(tmp_path, *given)
    assert "warning: block material 1: expected no velocity in a static run, which begins at rest, found 0 30 1" in warned
    np.testing.assert_array_equal(r.bodies.centroid, still)


@pytest.mark.parametrize("stage", ["", "&stage name='later' /\n"])
def test_a_run_whose_steps_end_before_its_loads_have_grown_is_not_complete(stage, tmp_path):
    """It was, with half the weight on, and a stage after it was left out."""
    said, warned, r = summary(tmp_path, *decks(tmp_path, steps=50, groups=f"&step balance=1e-3 /\n&gravity ramp=2 /\n{stage}"))
    assert said["status"].startswith("not in equilibrium") and "change until time 2, after the last step" in said["status"]
    assert r.history.time[-1] == pytest.approx(1) and "step.end_time" in warned
    said, _, _ = summary(tmp_path, *decks(tmp_path, steps=200, groups=f"&step balance=1e-3 /\n&gravity ramp=2 /\n{stage}"))
    assert said["status"] == "complete"


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("groups", ["", "&method strain='green' /", "&method model='nmm' /\n&cover edge={0} /",
                                    "&method preset='shi' /", "&contact method='augmented' /"])
def test_a_run_ends_where_it_has_come_to_equilibrium(groups, size, tmp_path):
    given = decks(tmp_path, tilt=0.3, steps=1000, dt=0.02 * size**0.5, size=size,
                  groups=groups.format(0.5 * size) + "\n&step balance=1e-4 /")
    said, warned, r = summary(tmp_path, *given)
    assert said["status"] == "complete" and "not in equilibrium" not in warned
    assert said["balance"]["others"] == 0 and not said["balance"]["moves"]
    assert said["balance"]["share"] <= 1e-4 < r.history.unbalanced[:-1].min()
    assert r.times[-1] == r.history.time[-1] and len(r.history.time) < 200


def test_a_dynamic_run_has_no_such_number(tmp_path):
    deck = decks(tmp_path)
    deck[1].write_text("1" + deck[1].read_text()[1:])
    said, _, r = summary(tmp_path, *deck)
    assert said["balance"] is None and "unbalanced" not in dir(r.history)
    done = call("run", *deck, "--set", "step.balance=1e-3", "-o", tmp_path / "r.h5")
    assert done.returncode == 2 and "expected step.balance only with k01 0" in done.stderr and "found k01=1" in done.stderr


def test_a_run_goes_on_from_where_it_was_in_balance(tmp_path):
    """To a smaller share, with the same bits as in one run; to the same there is nothing left to do."""
    given = decks(tmp_path, tilt=0.3, steps=1000, groups="&step balance=1e-2 /")
    first, _, _ = summary(tmp_path, *given)
    done = call("run", "--restart", tmp_path / "r.h5", "-o", tmp_path / "again.h5")
    assert done.returncode == 2
    gone_on = scree.read(tmp_path / "r.h5").path
    done = call("run", "--restart", gone_on, "--set", "step.balance=1e-6", "-o", tmp_path / "on.h5", "--quiet")
    assert done.returncode == 0, done.stderr
    whole = scree.run(*given, settings=["step.balance=1e-6"], output=tmp_path / "whole.h5")
    on = scree.read(tmp_path / "on.h5")
    assert len(on.history.time) > first["steps"]["taken"]
    np.testing.assert_array_equal(on.history.unbalanced, whole.history.unbalanced)


def problem(folder, name):
    """Decks of a static problem of tools/validate."""
    case, rest = name.split("/")
    if case == "m2-toppling":
        (folder / "m2.blk").write_text(block_files.columns(references.Toppling()))
        return [folder / "m2.blk", DECKS / f"{name}.ana"]
    if case == "m3-arch":
        voussoirs, words = rest.split("-")
        thickness = references.arch_thickness(int(voussoirs), polygon=True) * (1.02 if words == "stands" else 0.98)
        (folder / "m3.blk").write_text(block_files.arch(int(voussoirs), thickness))
        return [folder / "m3.blk", DECKS / "m3-arch" / "static.ana"]
    return [DECKS / f"{name}.ana"]


@pytest.mark.parametrize("case", ["m2-toppling/", "m3-arch/8-", "m3-arch/64-", "m5-plane-failure/", "m6-roof-wedge/"])
def test_a_static_problem_has_its_verdict_in_few_solves(case, tmp_path):
    """Half a degree, two percent and one percent on both sides of the limit."""
    said, warned, r = summary(tmp_path, *problem(tmp_path, case + "stands"))
    assert said["status"] == "complete" and said["balance"]["share"] <= 1e-4 and not said["balance"]["moves"]
    assert said["steps"]["solves"] <= 50 and warned == ""
    said, warned, r = summary(tmp_path, *problem(tmp_path, case + "falls"))
    assert said["status"].startswith("moves: block ") and "nothing stops it" in warned and said["balance"]["moves"]
    assert said["balance"]["share"] > 5e-3 and r.bodies.centroid[-1, :, 1].sum() < r.bodies.centroid[0, :, 1].sum()
    assert said["steps"]["solves"] <= 60


@pytest.mark.parametrize("phi, edge", [(0.0, 0.4), (20.0, 0.4), (39.5, 0.4), (20.0, 0.1), (39.5, 0.1)])
def test_a_meshed_block_that_slides_freely_moves(phi, edge, tmp_path):
    """What its mesh bends goes up and down with the steps, by a thousandth of what is out of balance: it was nearer to equilibrium for ever.

    Where the mesh cuts its sides says nothing of how long the steps may be: they were cut by the shortest edge, 500 for a centimetre."""
    groups = f"&method model='nmm' /\n&cover edge={edge} /\n&step balance=1e-4 /"
    said, _, r = summary(tmp_path, *decks(tmp_path, phi, np.radians(40), 500, 0.01, groups))
    assert said["status"].startswith("moves: block 2") and said["balance"]["moves"]
    assert said["steps"]["taken"] <= 20 and said["steps"]["cut"] == 0
    went = np.linalg.norm(r.bodies.centroid[-1] - r.bodies.centroid[0], axis=1)
    assert 0.01 < went[1] < 0.1


@pytest.mark.parametrize("end", [0.01, 1.0, 1e9])
@pytest.mark.parametrize("share, stands", [(0.35, True), (0.37, False), (0.5, False)])
def test_a_ground_that_pushes_evenly_is_a_load(share, stands, end, tmp_path):
    """Pseudo-static: tan 20 = 0.364. It was judged once the record had ended, and stood with 0.5 of its weight along; a longer one never ended."""
    groups = f"&acceleration table=0 {share * 9.81} 0 {end} {share * 9.81} 0 /\n&step balance=1e-4 /"
    said, _, _ = summary(tmp_path, *decks(tmp_path, phi=20.0, steps=400, dt=0.01, groups=groups))
    assert said["status"].split(":")[0] == ("complete" if stands else "moves")


@pytest.mark.parametrize("size", [0.001, 0.01, 0.1, 1, 3])
def test_blocks_that_come_to_rest_late_have_one_verdict_whatever_the_first_step(size, tmp_path):
    """Five blocks on 3.7 degrees that go 5 cm until bolts that yield hold them; damped motion ends there, too."""
    deck = TREE / "tests" / "data" / "settles_late" / "a"
    said, _, r = summary(tmp_path, f"{deck}.blk", f"{deck}.ana", "--set", f"step.size={size}")
    assert said["status"] == "complete"
    assert np.linalg.norm(r.bodies.centroid[-1] - r.bodies.centroid[0], axis=1).max() == pytest.approx(0.0498, rel=0.01)


def test_columns_have_a_verdict_a_tenth_of_a_degree_from_their_limit(tmp_path):
    """Steps along the mechanism are long against inertia: what forces of contacts change by as their edges turn is all of the stiffness then."""
    deck, limit = problem(tmp_path, "m2-toppling/falls"), 38.1512
    for off, status in ((0.1, "complete"), (-0.1, "moves")):
        r = scree.run(*deck, output=tmp_path / "r.h5", settings=[f"joint(1).phi={limit + off}"])
        assert r.scene.status.split(":")[0] == status and r.history.solves.sum() <= 80


def test_a_load_that_changes_is_followed_to_its_end(tmp_path):
    """The run neither ends nor takes larger steps before the last time of a table: a push that grows to half of what friction
    holds, then to twice."""
    for push, status in ((0.5, "complete"), (2.0, "moves")):
        given = decks(tmp_path, phi=30.0)
        weight = 24525.0
        force = push * weight * np.tan(np.radians(30))
        (tmp_path / "x.blk").write_text(block_file("x", [(1, GROUND[1]), (1, box(0, 1, 0, 1))], held(GROUND[1], 1), [(0.5, 0.1, 2)]))
        tables = f"0 0 0 0 2\n0 0 0  1 {force} 0"
        given[1].write_text(f"0 60 1 1 0.05 0.1 0\n{tables}\n2500 {weight} 1e9 0.25\n0 0 0  0 0 0  0 0 0\n30 0 0\n"
                            "&deck dialect='shi' /\n&step balance=1e-4 /\n")
        said, _, r = summary(tmp_path, *given)
        assert said["status"].split(":")[0] == status
        steady = r.history.time >= 1 - 1e-9
        np.testing.assert_allclose(r.history.step_size[~steady], 0.1)
        assert steady.any() and r.history.step_size[steady][1:].max(initial=1) > 0.2
