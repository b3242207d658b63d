"""strain='auto' through the program: it agrees with Green strain to the accuracy asked for, and costs what small strain does at rest."""
import os
import pathlib

import numpy as np
import pytest
import scree

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
PAPER = SOURCE / "input" / "paper"
CLASSIC = SOURCE / "tests" / "data" / "classic"


def run(deck, folder, strain, *settings, geometry=()):
    return scree.run(*geometry, deck, output=folder / f"{strain}.h5", settings=[f"method.strain={strain}", *settings])


@pytest.mark.parametrize("twin", ["", "-dda"])
def test_a_triangle_that_turns_fast_is_green_to_the_bit(twin, tmp_path):
    green = run(PAPER / "rotation" / f"t4{twin}.ana", tmp_path, "green")
    auto = run(PAPER / "rotation" / f"t4{twin}.ana", tmp_path, "auto")
    assert np.all(auto.history.green_elements == 1)
    assert np.all(auto.bodies.green_share[1:] == 1)
    assert np.array_equal(auto.history.rotation, green.history.rotation)
    assert np.array_equal(auto.bodies.stress, green.bodies.stress)


@pytest.mark.parametrize("accuracy", [1e-6, 1e-8])
@pytest.mark.parametrize("model", ["dda", "nmm"])
def test_rock_fall_turns_as_with_green_strain(model, accuracy, tmp_path):
    """2200 steps on the slope, each off by at most the accuracy; most does not add up, as the stress takes it back: 11 and 30 times.
    Where it tips over a corner at the foot that grows, and at rest on a side nothing is left."""
    common = ["step.end_time=1", f"method.model={model}"]
    green = run(PAPER / "rockfall" / "rockfall.ana", tmp_path, "green", *common)
    auto = run(PAPER / "rockfall" / "rockfall.ana", tmp_path, "auto", f"method.accuracy={accuracy}", *common)
    off = np.abs(auto.history.rotation - green.history.rotation)[:, 1]
    assert off[green.history.time < 0.52].max() < 200 * accuracy
    assert off[-1] < 200 * accuracy
    count = auto.history.green_elements
    first_touch = np.flatnonzero(auto.history.contacts[:, 1:].sum(1))[0]
    assert count[:first_touch].max() == 0  # it falls without turning
    assert 100 < np.count_nonzero(count) < len(count) - 100
    # the slope is fixed and never turns
    assert auto.bodies.green_share[:, 0].max() == 0 and auto.bodies.green_share[:, 1].max() == 1


def test_the_arc_rises_as_with_green_strain(tmp_path):
    deck = PAPER / "arc" / "arc.ana"
    green = run(deck, tmp_path, "green", "contact.restitution=0")
    auto = run(deck, tmp_path, "auto", "contact.restitution=0")
    travel = np.ptp(green.bodies.centroid, axis=0).max()
    assert np.abs(auto.bodies.centroid - green.bodies.centroid).max() < 1e-7 * travel
    np.testing.assert_allclose(auto.history.energy.dissipated[-1], green.history.energy.dissipated[-1], rtol=1e-6)


def test_a_wall_at_rest_takes_the_solves_of_small_strain(tmp_path):
    """After the first steps, in which the weight comes on."""
    given = {"geometry": [CLASSIC / "wall100.geo"]}
    settings = ["step.size=0.005", "step.end_time=0.5"]
    small = run(CLASSIC / "wall100.ana", tmp_path, "small", *settings, **given)
    auto = run(CLASSIC / "wall100.ana", tmp_path, "auto", *settings, **given)
    assert auto.history.green_elements[20:].max() == 0
    assert np.sum(auto.history.solves) <= 1.05 * np.sum(small.history.solves)
    np.testing.assert_allclose(auto.history.energy.strain[-1], small.history.energy.strain[-1], rtol=1e-3)


@pytest.mark.parametrize("strain", ["small", "green"])
def test_what_is_not_chosen_is_not_written(strain, tmp_path):
    found = run(PAPER / "rotation" / "t4.ana", tmp_path, strain, "integrator.scheme=newmark")
    assert "green_elements" not in dir(found.history) and "green_share" not in dir(found.bodies)
