"""tools/fs: factors of safety with a known answer."""
import csv
import math
import os
import pathlib
import subprocess

import pytest
import scree

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


def test_a_joint_that_dilates_has_the_factor_of_its_friction(tmp_path):
    """Its friction angle is the whole angle, so dilation adds no strength. It must not exceed that angle, and is divided with it."""
    _, lines = found(tmp_path, PLANE, "--set", "joint(1).phi=40", "--set", "joints.dilation=30", "--set", "joints.dilation_slip=0.1")
    exact = math.tan(math.radians(40)) / math.tan(math.radians(30))
    stands, falls = factors(lines)
    assert stands * (1 - 2e-4) < exact < falls and falls / stands - 1 < 6e-3


@pytest.mark.parametrize("values", [{"strength": (26e3, 39e3)}, {"strength": (0, 0), "toughness": (20e3, 30e3)}], ids=list)
def test_the_factor_of_a_block_that_may_crack_grows_with_its_strength(values, tmp_path):
    """A block hangs from a ligament between two cracks. The tension before them does not depend on the strength, so the factor is
    proportional to it."""
    static = {"deck.k01": 0, "step.count": 200, "step.size": 0.1, "cover.edge": 0.05}
    factors = [scree.fs(SOURCE / "input" / "examples" / "breaking" / "breaking.ana", within=0.2, folder=tmp_path / str(k),
                        set=static | {f"cracks.{name}": pair[k] for name, pair in values.items()}) for k in (0, 1)]
    assert factors[0].stands < factors[1].falls / 1.5 and factors[1].stands / 1.5 < factors[0].falls


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
    ([PLANE, "--set", "joint(1).phi=80", "--most", "4"], 1, "it stands with a factor of 4: try a larger --most, where strength decides at all"),
    ([PLANE, "--set", "joint(1).phi=1", "--most", "4"], 1, "it falls with a factor of 0.25: strength does not hold it"),
    ([PLANE, "--set", "joints.jrc=8", "--set", "joints.jcs=1e6"], 2, "found joints.jrc = 8: a rough joint with less strength is not one of another roughness"),
    ([CASES / "s4-bolted-later" / "bolted.ana", "--stage", "bench"], 2, "--stage: expected all, or a stage by name or number, 1 to 3"),
    ([CASES / "s4-bolted-later" / "unbolted.ana", "--stage", "3"], 1, "expected stages that stand before the factor changes anything"),
    ([PLANE, "--load", "seismic"], 2, "--load seismic: expected acceleration of the ground in the stage, found none"),
    ([PLANE, "--joints", "bedding"], 2, "or by name (1), found 'bedding'"),
    ([PLANE, "--inside", "0", "0", "1", "1"], 2, "--inside: expected x y of three corners or more, found 4 numbers"),
    ([PLANE, "--within", "0"], 2, "--within: expected a number above 0, found '0'"),
    ([PLANE, "--most", "1"], 2, "--most: expected a number above 1, found '1'"),
    (["nothing.ana"], 2, "nothing.ana")])
def test_what_has_no_factor_is_said(tmp_path, words, status, said):
    assert said in found(tmp_path, *words, status=status)[0]


ENGINEER = SOURCE / "tests" / "tools" / "engineer"
WATER = {"low": "0 10 25 10 45 22 80 30", "high": "0 10 25 10 34 30 80 35"}


def factor_of(deck, folder, **given):
    return scree.fs(deck, folder=folder, **given)


def test_water_lowers_the_factor_of_a_slope_where_it_stands_high(tmp_path):
    """Water below the mechanism changes nothing; water in its joints takes more than half of the factor."""
    factors = {"dry": factor_of(ENGINEER / "slope.ana", tmp_path / "dry", within=0.02)}
    for name, table in WATER.items():
        factors[name] = factor_of(ENGINEER / "slope.ana", tmp_path / name, within=0.02, set={"water.table": table, "water.unit_weight": 9810})
    assert factors["low"].factor == pytest.approx(factors["dry"].factor, rel=0.03)
    assert factors["high"].falls < 0.5 * factors["dry"].stands


@pytest.mark.parametrize("words", [[], ["--stage", "impounding"], ["--stage", "all"]])
def test_a_dam_that_is_impounded_in_a_stage(words, tmp_path):
    """N tan 45 / T = 6.7103/4.4133 of the base, whichever stages are reduced."""
    said, lines = found(tmp_path, ENGINEER / "dam.ana", "--set", "cover.edge=10", "--within", "0.02", *words)
    stands, falls = factors(lines)
    assert stands < 1.5205 < falls
    assert all(float(line["area"]) == pytest.approx(435, rel=1e-3) for line in lines if line["stands"] == "False")


def test_a_dam_under_a_load_that_grows(tmp_path):
    """F times the water slides the base where F H = (W - F U) tan 45: W = 435 x 23544, H = 9810 30^2/2, U = 294300 x 24/2."""
    said, lines = found(tmp_path, ENGINEER / "dam.ana", "--set", "cover.edge=10", "--within", "0.02", "--load", "boundary")
    stands, falls = factors(lines)
    assert stands < 435 * 23544 / (9810 * 450 + 294300 * 12) < falls and said.startswith("boundary load factor: ")


def test_a_seismic_load_factor(tmp_path):
    """A plane of 30 degrees: k (cos a + sin a tan phi) = cos a tan phi - sin a; here k is 0.1 times the factor."""
    _, lines = found(tmp_path, PLANE, "--set", "joint(1).phi=40", "--set", "acceleration.table=0 -0.981 0 1 -0.981 0", "--load", "seismic")
    a, mu = math.radians(30), math.tan(math.radians(40))
    exact = 10 * (math.cos(a) * mu - math.sin(a)) / (math.cos(a) + math.sin(a) * mu)
    stands, falls = factors(lines)
    assert stands * (1 - 2e-3) < exact < falls and falls / stands - 1 < 6e-3


def test_the_last_stage_is_reduced_with_its_own_strength(tmp_path):
    """A bolt that yields at 20 kN holds a block of 100 kN on 30 degrees; phi is 15 degrees by then: 100 cos a tan phi/F + 20 = 100 sin a."""
    _, lines = found(tmp_path, CASES / "s4-bolted-later" / "bolted.ana")
    a = math.radians(30)
    stands, falls = factors(lines)
    assert stands * (1 - 1e-3) < 100 * math.cos(a) * math.tan(math.radians(15)) / (100 * math.sin(a) - 20) < falls


def test_a_stage_that_is_named_is_the_last_that_runs(tmp_path):
    """In the stage before phi is 20 degrees."""
    _, lines = found(tmp_path, CASES / "s4-bolted-later" / "bolted.ana", "--stage", "weaker, bolted")
    a = math.radians(30)
    stands, falls = factors(lines)
    assert stands * (1 - 1e-3) < 100 * math.cos(a) * math.tan(math.radians(20)) / (100 * math.sin(a) - 20) < falls


def three_blocks():
    """Blocks of 1, 4 and 9 m2 on planes of 40, 30 and 20 degrees, phi 25: they slide at 0.556, 0.808 and 1.281."""
    m = scree.Model("blocks")
    m.material("rock", density=2500, young=1e10)
    m.joint_material("plane", phi=25)
    for k, (side, slope) in enumerate(((1, 40), (2, 30), (3, 20))):
        a, x = math.radians(slope), 40 * k
        def place(s, t):
            return x + s * math.cos(a) + t * math.sin(a), -s * math.sin(a) + t * math.cos(a)
        m.block(f"plane {k}", [place(0, -2), place(20, -2), place(20, 0), place(0, 0)])
        m.block(f"block {k}", [place(5, 0), place(5 + side, 0), place(5 + side, side), place(5, side)])
        m.fix("ground", block=f"plane {k}")
    m.static()
    return m


def exact(slope):
    return math.tan(math.radians(25)) / math.tan(math.radians(slope))


@pytest.mark.parametrize("given, slope", [({}, 40), ({"least": 2}, 30), ({"least": 5}, 20),
                                          ({"inside": [(70, -30), (120, -30), (120, 10), (70, 10)]}, 20)])
def test_a_mechanism_counts_by_its_area_and_its_place(given, slope, tmp_path):
    """What falls before and does not count is taken away."""
    found = scree.fs(three_blocks(), folder=tmp_path / "fs", **given)
    assert found.stands * (1 - 1e-3) < exact(slope) < found.falls and found.area == pytest.approx({40: 1, 30: 4, 20: 9}[slope], rel=1e-3)


def test_mechanisms_one_after_the_other(tmp_path):
    found = scree.fs(three_blocks(), folder=tmp_path / "fs", mechanisms=3)
    for one, slope in zip([found, *found.others], (40, 30, 20), strict=True):
        assert one.stands * (1 - 1e-3) < exact(slope) < one.falls
    assert {path.name for path in (tmp_path / "fs").glob("*.h5")} == {f"{verdict}{k}.h5" for verdict in ("stands", "falls") for k in ("", "-2", "-3")}
    assert found.others[1].mechanism.n_blocks == 6
