"""tools/fs: factors of safety with a known answer."""
import csv
import math
import os
import pathlib
import subprocess

import pytest

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
CASES = SOURCE / "input" / "validation"
PLANE = CASES / "b1-slide" / "slope30-phi28.ana"


def found(folder, *words, status=0):
    """What tools/fs prints last, and the lines of its table."""
    done = subprocess.run([SOURCE / "tools" / "fs", *map(str, words), "-o", "out"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == status, done.stderr
    if status:
        return done.stderr, []
    with (folder / "out" / "fs.csv").open() as file:
        lines = list(csv.DictReader(file))
    assert {path.name for path in (folder / "out").iterdir()} == {"fs.csv", "mechanism.png", "stands.h5", "falls.h5"}
    return done.stdout.splitlines()[-1], lines


def factors(lines):
    """The factors that the answer is between."""
    falls = min(float(line["factor"]) for line in lines if line["stands"] == "False")
    return max(float(line["factor"]) for line in lines if line["stands"] == "True" and float(line["factor"]) < falls), falls


@pytest.mark.parametrize("phi, slope", [(28, 30), (40, 30), (20, 30)])
def test_a_block_on_a_plane(tmp_path, phi, slope):
    """tan phi over the tangent of the slope. It stands where no more than 1e-4 of its weight is out of balance, 2e-4 of what drives it."""
    said, lines = found(tmp_path, PLANE, "--set", f"joint(1).phi={phi}")
    exact = math.tan(math.radians(phi)) / math.tan(math.radians(slope))
    stands, falls = factors(lines)
    assert stands * (1 - 2e-4) < exact < falls and falls / stands - 1 < 6e-3
    assert said.startswith("factor of safety: ") and float(said.split()[3]) == pytest.approx(exact, rel=6e-3)
    assert all(int(line["solves"]) < 50 for line in lines if line["stands"] == "True")


def test_a_plane_failure(tmp_path):
    """Friction and cohesion: the deck has the strength of a factor of 1.14608, over 0.99 of that (doc/validation.md, M5)."""
    _, lines = found(tmp_path, CASES / "m5-plane-failure" / "stands.ana", "--within", "2e-3")
    stands, falls = factors(lines)
    assert stands < 1 / 0.99 < falls
    assert {line["block"] for line in lines if line["stands"] == "False"} == {"2"}


def test_a_ground_that_pushes_evenly(tmp_path):
    """A plane of 30 degrees with 0.2 of the weight along: it stood whatever its strength, once the record had ended."""
    _, lines = found(tmp_path, PLANE, "--set", "joint(1).phi=40", "--set", "acceleration.table=0 -1.962 0 1 -1.962 0")
    down = math.radians(30)
    exact = math.tan(math.radians(40)) * (math.cos(down) - 0.2 * math.sin(down)) / (math.sin(down) + 0.2 * math.cos(down))
    stands, falls = factors(lines)
    assert stands * (1 - 2e-3) < exact < falls and falls / stands - 1 < 6e-3


def test_joints_may_be_named(tmp_path):
    """The crack behind the block has no strength: to reduce that of the plane alone changes nothing."""
    _, lines = found(tmp_path, CASES / "m5-plane-failure" / "stands.ana", "--joints", "1", "--within", "0.05")
    stands, falls = factors(lines)
    assert stands < 1 / 0.99 < falls


@pytest.mark.parametrize("steps", [1, 2, 3, 4, 6, 12, 200])
def test_a_run_whose_steps_run_out_neither_stands_nor_falls(tmp_path, steps):
    """With few steps there is no factor, with more the true one; never another."""
    done = subprocess.run([SOURCE / "tools" / "fs", PLANE, "--set", f"step.count={steps}", "-o", "out"], cwd=tmp_path, capture_output=True, text=True)
    undecided = [line for line in done.stdout.splitlines() if " undecided " in line]
    if done.returncode == 0:
        assert not undecided and float(done.stdout.splitlines()[-1].split()[3]) == pytest.approx(0.92096, rel=6e-3)
    else:
        assert done.returncode == 1 and len(undecided) == 1 and "factor of safety" not in done.stdout
        factor = float(undecided[0].split()[0])
        assert f"found one whose steps ran out before, with a factor of {factor:g}: try more steps (n5 of the deck); not in equilibrium" in done.stderr
    assert (done.returncode == 0) == (steps > 6)


def test_a_search_leaves_nothing_of_an_earlier_one(tmp_path):
    """And the table of its runs, where it comes to no factor too."""
    found(tmp_path, PLANE, "--within", "0.1")
    (tmp_path / "out" / "mine.txt").write_text("no file of a search")
    found(tmp_path, PLANE, "--set", "joint(1).phi=1", "--most", "4", status=1)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"fs.csv", "falls.h5", "mine.txt"}
    with (tmp_path / "out" / "fs.csv").open() as file:
        assert [(float(line["factor"]), line["stands"]) for line in csv.DictReader(file)] == [(1, "False"), (0.5, "False"), (0.25, "False")]
    found(tmp_path, PLANE, "--set", "step.count=1", status=1)
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"fs.csv", "undecided.h5", "mine.txt"}
    with (tmp_path / "out" / "fs.csv").open() as file:
        line, = csv.DictReader(file)
    assert line["stands"] == "" and line["said"].startswith("not in equilibrium: ")


def test_a_scene_without_joint_materials_has_none_to_reduce(tmp_path):
    deck = (CASES / "e2-spin" / "spin.ana").read_text().replace("\n1 1  ", "\n1 0  ").replace("30 0 0 ", "! 30 0 0 ")
    (tmp_path / "spin.ana").write_text(deck.replace("square.geo", str(CASES / "e2-spin" / "square.geo")))
    for words in ([], ["--joints", "1"]):
        assert found(tmp_path, "spin.ana", *words, status=2)[0] == "tools/fs: expected a scene with joint materials, found none\n"


@pytest.mark.parametrize("words, status, said", [
    ([PLANE, "--joints", "2"], 2, "expected joint materials of the scene, 1 to 1, found [2]"),
    ([PLANE, "--set", "joint(1).phi=0"], 2, "nothing to reduce"),
    ([PLANE, "--set", "joint(1).phi=1", "--most", "4"], 1, "it falls with a factor of 0.25: strength does not hold it"),
    ([PLANE, "--set", "joints.phi=30"], 2, "found joints.phi = 30: a factor would not divide it"),
    ([CASES / "s4-bolted-later" / "bolted.ana"], 2, "found stage 2: a factor would not divide it"),
    ([PLANE, "--within", "0"], 2, "--within: expected a number above 0, found '0'"),
    ([PLANE, "--most", "1"], 2, "--most: expected a number above 1, found '1'"),
    (["nothing.ana"], 2, "nothing.ana")])
def test_what_has_no_factor_is_said(tmp_path, words, status, said):
    assert said in found(tmp_path, *words, status=status)[0]
