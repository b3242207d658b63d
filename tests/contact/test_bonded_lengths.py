"""The lengths of joint for which bonds stand: they add up to the bonded part of a joint, wherever it ends and however its faces are divided."""
import math
import numpy as np
import pytest
from scree.model import Model

T, G = 1e5, 100.0  # tensile strength and fracture energy
OPENING = 2 * G / T  # at which nothing of the strength is left
MESH = {"method.model": "nmm", "method.strain": "small"}


def lies(random, model):
    """Settings of a mesh that lies anywhere under the model, or none for whole blocks."""
    if model == "dda":
        return {}
    return MESH | {"cover.edge": float(random.uniform(0.15, 0.4)), "cover.origin": random.uniform(0, 1, 2).tolist(),
                   "cover.angle": float(random.uniform(0, 60))}


def on_each_other(random, low, high, turned):
    """Two blocks on each other, whose common face has nodes at random places of its own on each side. It is bonded from `low` to `high`, and
    cracked elsewhere; cracks rub more than bonds or less."""
    def nodes():
        return sorted({0.0, 1.0, low, high, *random.uniform(0, 1, random.integers(0, 6))})

    def kinds(x):
        return ["bond" if low < (p + q) / 2 < high else "crack" for p, q in zip(x, x[1:])]

    model = Model("pair")
    model.material("rock", density=2500, young=1e12, poisson=0, unit_weight=0)
    model.joint_material("crack", phi=float(random.choice([0, 50])))
    model.joint_material("bond", phi=30, cohesion=10 * T, tensile_strength=T, energy=G)
    upper, lower = nodes(), nodes()
    model.block("upper", turned([(x, 0) for x in upper] + [(1, 1), (0, 1)]), joint=[*kinds(upper), *["crack"] * 3])
    model.block("lower", turned([(0, -1), (1, -1)] + [(x, 0) for x in lower[::-1]]), joint=["crack", "crack", *kinds(lower)[::-1], "crack"])
    return model


@pytest.mark.parametrize("model", ["dda", "nmm"])
@pytest.mark.parametrize("seed", range(4))
def test_bonds_cover_the_bonded_part_of_a_face_and_nothing_else(seed, model, tmp_path):
    """All bonds open alike. Half way their forces are in the middle of the bonded part, and in the end they have lost its length times G."""
    random = np.random.default_rng(seed)
    low, high = sorted(random.uniform(0, 0.5, 1).tolist() + random.choice([1.0, random.uniform(0.6, 0.9)], 1).tolist())
    angle = random.uniform(0, 2 * math.pi)
    along, across = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
    pair = on_each_other(random, low, high, lambda places: [tuple(x * along + y * across) for x, y in places])
    ways = [(t, *(share * OPENING * across)) for t, share in ((0, 0), (1, 0.5), (2, 1.1))]
    pair.fix("up", *(tuple(x * along + across) for x in (0, 1)), move=ways)
    pair.fix("down", *(tuple(x * along - across) for x in (0, 1)))
    pair.static(balance=None, steps=2, size=1)
    r = pair.run(tmp_path / "pair.h5", set=lies(random, model) | {"output.every": 1})
    contacts = r.contacts_of(1)
    pull, place = -np.asarray(contacts.force)[:, 0], np.asarray(contacts.place) @ along
    assert pull.sum() == pytest.approx(0.5 * T * (high - low), rel=2e-4)  # blocks and springs give, too
    assert pull @ place / pull.sum() == pytest.approx((low + high) / 2, abs=2e-5)
    assert r.history.energy.fracture[-1] == pytest.approx(G * (high - low), rel=1e-9)


def bar(random, low, pull):
    """A meshed bar of 2 x 1 with a joint across its middle, bonded from `low` up; a traction pulls its right end, and the left one is held."""
    model = Model("bar")
    model.material("rock", density=2500, young=1e11, poisson=0.2, unit_weight=0)
    model.joint_material("crack", phi=0)
    model.joint_material("bond", phi=30, cohesion=10 * T, tensile_strength=T)
    y = [0.0, 1.0] if low == 0 else [0.0, low, 1.0]
    kinds = ["bond"] if low == 0 else ["crack", "bond"]
    model.block("left", [(-1, 0), *((0, v) for v in y), (-1, 1)], joint=["crack", *kinds, "crack", "crack"])
    model.block("right", [(1, 1), *((0, v) for v in y[::-1]), (1, 0)], joint=["crack", *kinds[::-1], "crack", "crack"])
    model.support("end", line=[(-1, 0), (-1, 1)], hold="x")
    model.support("foot", points=[(-1, 0)], hold="y")
    model.load("pull", [(1, 0), (1, 1)], traction=(pull, 0))
    model.static(steps=30)
    return lies(random, "nmm"), model


@pytest.mark.parametrize("seed", range(2))
def test_a_bonded_section_bears_its_strength_times_its_area(seed, tmp_path):
    for share, holds in ((0.9999, True), (1.0001, False)):
        mesh, model = bar(np.random.default_rng(seed), 0, share * T)
        r = model.run(tmp_path / f"{share}.h5", set=mesh)
        assert (r.history.contacts[-1, 1:].sum() > 0) == holds


@pytest.mark.parametrize("seed", range(2))
def test_bonds_over_a_part_of_a_section_bear_the_force_and_the_moment_of_statics(seed, tmp_path):
    random = np.random.default_rng(seed)
    mesh, model = bar(random, random.uniform(0.1, 0.3), 0.1 * T)
    r = model.run(tmp_path / "bar.h5", set=mesh)
    contacts = r.contacts_of(-1)
    pull, place = -np.asarray(contacts.force)[:, 0], np.asarray(contacts.place)[:, 1]
    assert pull.sum() == pytest.approx(0.1 * T, rel=1e-6)
    assert pull @ place == pytest.approx(0.05 * T, rel=1e-4)
