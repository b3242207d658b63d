"""Grains: what tessellations must hold, and a model of them."""
import math

import numpy as np
import pytest
import scree
from scree.errors import ModelError
from scree.model.grains import KINDS, grains_in

RECTANGLE = [(0, 0), (1, 0), (1, 2), (0, 2)]
BEAM = [(0, 0), (0.45, 0), (0.45, 0.3), (0.55, 0.3), (0.55, 0), (1, 0), (1, 1), (0, 1)]
SHAPES = {"rectangle": RECTANGLE, "disc": scree.arc((3, -2), 0.7, sides=36), "notched beam": BEAM}
LEAST = 0.2


def area(corners):
    x, y = np.asarray(corners, float).T
    return 0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def sides(grains):
    return np.array([math.dist(grains.corners[a], grains.corners[b]) for a, b in grains.neighbours()])


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("kind", KINDS)
def test_grains_fill_the_outline_without_gaps(shape, kind):
    outline = SHAPES[shape]
    size = math.sqrt(area(outline) / 120)
    grains = grains_in(outline, size, kind, least=LEAST, seed=5)
    assert grains.areas().min() > 0 and grains.areas().sum() == pytest.approx(area(outline), rel=1e-12)
    assert grains.areas().mean() == pytest.approx(size ** 2, rel=0.15)
    left = grains.neighbours()
    assert sum(map(len, grains.grain)) == len(left), "a side has one grain to its left"
    free = [pair for pair in left if pair[::-1] not in left]
    around = sum(math.dist(p, q) for p, q in zip(outline, outline[1:] + outline[:1]))
    assert sum(math.dist(grains.corners[a], grains.corners[b]) for a, b in free) == pytest.approx(around, rel=1e-12)
    assert {tuple(p) for p in outline} <= {tuple(p) for p in grains.corners}


@pytest.mark.parametrize("grading", [0, 0.4])
def test_no_side_is_shorter_than_stated(grading):
    for seed in range(1, 6):
        grains = grains_in(RECTANGLE, 0.2, grading=grading, least=LEAST, seed=seed)
        assert sides(grains).min() >= LEAST * 0.2 * (1 - 1e-9)
    assert sides(grains_in(RECTANGLE, 0.2, least=0, seed=1)).min() < LEAST * 0.2, "without joining there are shorter ones"


@pytest.mark.parametrize("grading", [0.2, 0.4])
def test_grading_is_the_spread_of_sizes(grading):
    sizes = np.sqrt(grains_in(RECTANGLE, math.sqrt(2 / 300), grading=grading, least=0, seed=2).areas())
    assert sizes.std() / sizes.mean() == pytest.approx(grading, rel=0.25)


def test_minerals_have_their_shares_of_the_area():
    wanted = {"quartz": 3.0, "feldspar": 6.0, "mica": 1.0}
    grains = grains_in(RECTANGLE, 0.08, minerals=wanted, seed=4)
    areas = grains.areas()
    for name, share in wanted.items():
        found = areas[[one == name for one in grains.minerals]].sum()
        assert abs(found - share / 10 * areas.sum()) <= areas.max()


def test_a_seed_gives_the_same_grains_and_another_does_not():
    first, again, other = (grains_in(RECTANGLE, 0.2, minerals={"a": 1, "b": 1}, seed=seed) for seed in (7, 7, 8))
    assert (first.corners == again.corners).all() and first.grain == again.grain and first.minerals == again.minerals
    assert len(first.corners) != len(other.corners) or not np.allclose(first.corners, other.corners)


def grained(tmp_path):
    """A model of grains of two minerals with a joint material for each pair, and its grains."""
    model = scree.Model("grained")
    for name in "ab":
        model.material(name, density=2600, young=1e10)
    for name in "aa", "ab", "bb", "free":
        model.joint_material(name, phi=30, cohesion=1e6)
    pairs = {("a", "a"): "aa", ("b", "a"): "ab", ("b", "b"): "bb"}
    return model, model.grains("rock", RECTANGLE, 0.25, {"a": 0.5, "b": 0.5}, pairs, side="free")


def test_sides_of_grains_have_the_joint_material_of_their_pair(tmp_path):
    model, grains = grained(tmp_path)
    left, names = grains.neighbours(), list(model.joint_materials)
    assert len(model.geometry.blocks) == len(grains.grain)
    for own, block, mineral in zip(grains.grain, model.geometry.blocks, grains.minerals):
        assert list(model.materials)[block.material - 1] == mineral
        for a, b, joint in zip(own, own[1:] + own[:1], block.joints):
            other = left.get((b, a))
            assert names[joint - 1] == ("free" if other is None else "".join(sorted((mineral, grains.minerals[other]))))


def test_the_program_reads_the_grains_as_they_are(tmp_path):
    model, grains = grained(tmp_path)
    said = scree.call("cut", model.save(tmp_path / "grained.ana"), "-o", "grained.h5", cwd=tmp_path)
    assert said.returncode == 0, said.stderr
    results = scree.read(tmp_path / "grained.h5")
    assert results.n_blocks == len(grains.grain)
    np.testing.assert_allclose(results.bodies.area[0], grains.areas(), rtol=1e-7)  # corners in a file are rounded


@pytest.mark.parametrize("given, words", [
    ({"size": 0}, "size="), ({"size": 5}, "found 0"), ({"kind": "round"}, "kind="), ({"grading": -1}, "grading="), ({"least": 1}, "least="),
    ({"minerals": {"": -1}}, "minerals="), ({"outline": [(0, 0), (1, 1), (1, 0), (0, 1)]}, "cross")])
def test_wrong_arguments_are_named(given, words):
    with pytest.raises(ModelError, match=words):
        grains_in(**({"outline": RECTANGLE, "size": 0.2} | given))


def test_a_pair_without_a_joint_material_is_named():
    model = scree.Model("grained")
    for name in "ab":
        model.material(name, density=2600, young=1e10)
    model.joint_material("aa", phi=30)
    with pytest.raises(ModelError, match=r"grains\(joint=\): expected the joint material of"):
        model.grains("rock", RECTANGLE, 0.25, {"a": 0.5, "b": 0.5}, {("a", "a"): "aa"})
