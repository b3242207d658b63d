"""The force of moving supports, and runs that end when it has fallen past its peak."""
import numpy as np
import pytest
import scree

SIDE, YOUNG, KN, STRENGTH, STEPS, WAY = 1.0, 1e10, 1e11, 1e6, 40, 4e-4
HEIGHT = 0.9  # of the points that pull, above the bond


def pulled(past_peak=None, strength=STRENGTH):
    """Two blocks on each other, bonded; the lower is fixed and the upper is pulled up by WAY."""
    model = scree.Model("pulled")
    model.material("rock", density=2600, young=YOUNG, poisson=0, unit_weight=0)
    model.joint_material("bond", phi=30, cohesion=1e7, tensile_strength=strength, kn=KN)
    model.block("lower", [(0, 0), (SIDE, 0), (SIDE, 1), (0, 1)])
    model.block("upper", [(0, 1), (SIDE, 1), (SIDE, 2), (0, 2)])
    model.fix("lower", block="lower")
    model.fix("pull", (0.2, 1 + HEIGHT), (0.8, 1 + HEIGHT), move=[(0, 0, 0), (STEPS, 0, WAY)])
    model.static(balance=None, steps=STEPS, size=1)
    if past_peak is not None:
        model["step.past_peak"] = past_peak
    return model


def upwards(results, frame):
    """The force of contacts on the upper block in a frame."""
    contacts = results.contacts_of(frame)
    return sum(float(force[0] * normal[1] + force[1] * normal[0]) * (1 if blocks[0] == 2 else -1)
               for blocks, normal, force in zip(contacts.blocks, contacts.normal, contacts.force))


def test_the_force_of_moving_supports_is_that_of_contacts_and_of_the_closed_form(tmp_path):
    """The upper block and the bond are springs in a row. The strain of a block is constant: a force at the height h above its foot and
    one at its foot make a stress F h / A, and the points go by h times the strain, so the block has the stiffness E/h^2 of its unit area."""
    model = pulled(strength=1e9)
    results = model.run(tmp_path / "r.h5", set={"output.every": 1})
    stiffness = SIDE / (1 / KN + HEIGHT ** 2 / YOUNG)
    way = WAY * np.arange(1, STEPS + 1) / STEPS
    np.testing.assert_allclose(results.history.support_force, stiffness * way, rtol=2 * WAY)
    for frame in 1, 20, STEPS:
        assert -upwards(results, frame) == pytest.approx(results.history.support_force[frame - 1], rel=1e-6)  # but for inertia, 3e-7


def test_a_run_ends_past_its_peak(tmp_path):
    whole = pulled().run(tmp_path / "whole.h5")
    ended = pulled(0.5).run(tmp_path / "ended.h5")
    force = np.asarray(whole.history.support_force)
    peak = int(np.argmax(force))
    assert force[peak] == pytest.approx(STRENGTH * SIDE, rel=0.05) and abs(force[-1]) < 1e-3 * force[peak]
    last = peak + 1 + int(np.argmax(force[peak + 1:] <= 0.5 * force[peak]))
    assert len(whole.history.time) == STEPS and len(ended.history.time) == last + 1 < STEPS
    np.testing.assert_array_equal(ended.history.support_force, force[:last + 1])
    bonds = np.asarray(ended.history.bonds)
    assert bonds[0].tolist() == [2, 0, 0] and bonds[-1].tolist() == [0, 2, 0]


def test_the_summary_tells_of_the_peak(tmp_path):
    deck = pulled(0.5).save(tmp_path / "pulled.ana")
    said = scree.call("run", deck, "-o", tmp_path / "r.h5")
    assert ", past the peak: moving supports push with " in said.stderr + said.stdout
    results = scree.read(tmp_path / "r.h5")
    force = np.asarray(results.history.support_force)
    told = results.summary["support_force"]
    assert told["last"] == pytest.approx(force[-1], abs=1e-9 * force.max()) and told["largest"] == pytest.approx(force.max(), rel=1e-12)
    with_none = scree.call("run", pulled().save(tmp_path / "goes.ana"), "-o", tmp_path / "g.h5")
    assert "past the peak" not in with_none.stderr + with_none.stdout


def test_a_restart_knows_the_peak(tmp_path):
    whole = pulled(0.5).run(tmp_path / "whole.h5", set={"output.checkpoint": 1, "output.every": 1})
    half = int(np.argmax(whole.history.support_force)) + 1  # the last step before the fall
    pulled(0.5).run(tmp_path / "half.h5", set={"output.checkpoint": 1, "output.every": 1, "step.count": half})
    done = scree.call("run", "--restart", tmp_path / "half.h5", "--set", f"step.count={STEPS}", "-o", tmp_path / "on.h5", "--quiet")
    assert done.returncode == 0, done.stderr
    np.testing.assert_array_equal(scree.read(tmp_path / "on.h5").history.support_force, whole.history.support_force)


@pytest.mark.parametrize("settings, words", [(["deck.k01=1"], "with k01 0"), (["step.balance=1e-3"], "step.balance")])
def test_where_there_is_no_peak_it_is_refused(tmp_path, settings, words):
    deck = pulled(0.5).save(tmp_path / "pulled.ana")
    said = scree.call("run", deck, *[word for one in settings for word in ("--set", one)], "-o", tmp_path / "r.h5")
    assert said.returncode == 2 and "step.past_peak" in said.stderr and words.split()[-1] in said.stderr
