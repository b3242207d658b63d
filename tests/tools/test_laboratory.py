"""tools/test_rock: elastic stacks against closed forms, what tests measure, and the command."""
import json
import math
import os
import pathlib
import subprocess

import numpy as np
import pytest
import scree
from scree.errors import ScreeError
from scree.laboratories.command import Laboratory, words_of
from scree.laboratories.runs import LOOK, Outcome, level_stress, mohr_coulomb, run_specimen
from scree.laboratories.specimens import LIGHT, TESTS, Rock, Specimen

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
KN = 2e13


def outcome(kind, pressure, strength):
    """An outcome with a strength alone."""
    return Outcome(Specimen(kind, pressure=pressure), 1, pathlib.Path(), np.array([1.0]), np.array([strength]), np.zeros(1), np.zeros((1, 3)), True, 1, 0.0)


@pytest.mark.parametrize("grains", [1, 2])
def test_a_stack_gives_way_as_its_grains_and_its_joints(tmp_path, grains):
    """Grains on each other between smooth platens: E/(1 - nu^2) of the grains in a row with kn of each joint."""
    rock = Rock(young=40e9, poisson=0.2, kn=KN, cohesion=1e9, tension=1e9)
    specimen = Specimen("ucs", grains, rock=rock, platen_phi=0.0, relax=60, strain=1e-4, steps=10)
    found = run_specimen(specimen, 1, tmp_path)
    height, even = specimen.height, rock.young / (1 - rock.poisson ** 2)
    assert found.grains == grains and found.bonds[0, 0] == 2 * (grains - 1)
    stiffness = height / (height / even + (grains + 1) / KN)
    assert found.young == pytest.approx(stiffness, rel=1e-3)
    assert found.poisson == pytest.approx(rock.poisson / (1 - rock.poisson) * stiffness / even, rel=2e-3)


def test_the_fit_counts_specimens_whose_stress_did_not_fall():
    found = [outcome("shear", pressure, 1e6 + pressure) for pressure in (1e6, 2e6, 4e6)]
    assert list(words_of(Laboratory(found)))[-1] == "cohesion 1 MPa, friction angle 45.0 degrees"
    found[1].has_peak = False
    assert list(words_of(Laboratory(found)))[-1].endswith("45.0 degrees, with 1 of 3 specimens that did not fall")


def test_a_stress_is_level_where_it_changes_little_after_its_peak():
    strain = np.linspace(0, 4, 401)
    falls = np.where(strain < 1, 100 * strain, 40 + 60 * np.exp(-(strain - 1) / 0.3))
    assert level_stress(strain, falls) == pytest.approx(40, abs=0.1)
    assert level_stress(strain[:140], falls[:140]) is None   # before two parts are passed
    assert level_stress(strain[:170], falls[:170]) is None   # while it falls
    assert level_stress(strain, 100 * strain) is None        # without a peak
    assert level_stress(strain, np.minimum(100 * strain, 100)) == pytest.approx(100)


def test_a_confined_specimen_ends_where_its_stress_is_level(tmp_path, monkeypatch):
    """Its run stops there, and its seconds are those of all parts of the run. An unconfined specimen goes on."""
    monkeypatch.setattr("scree.laboratories.runs.level_stress", lambda strain, stress: 1.0 if len(stress) >= 2 * LOOK else None)
    for pressure in (2e7, 0.0):
        found = run_specimen(Specimen("biaxial", 2, pressure=pressure, steps=4 * LOOK, rock=Rock(cohesion=1e9, tension=1e9)), 1, tmp_path)
        assert (len(found.stress) == 2 * LOOK) == (pressure > 0) and found.has_peak and found.residual == 1.0
        parts = sum(scree.read(found.path).cost.processor_seconds)
        assert found.seconds > parts if pressure else found.seconds == pytest.approx(parts)


@pytest.fixture(scope="module")
def ucs(tmp_path_factory):
    """A specimen of few grains that fails, with a frame each step."""
    specimen = Specimen("ucs", 30, steps=40, rock=Rock(cohesion=5e6, tension=2e6))
    model = specimen.model(2)
    model["output.every"] = 1
    from scree.laboratories.runs import outcome_of
    results = model.run(tmp_path_factory.mktemp("ucs") / "ucs.h5")
    return outcome_of(specimen, 2, results), results


def test_the_stress_is_that_of_contacts_on_both_platens(ucs):
    found, results = ucs
    width = found.specimen.width
    inertia = 0.1 * found.young * np.diff(found.strain, prepend=0).max()  # of what a step adds to the stress
    for frame in range(1, results.n_frames):
        contacts = results.contacts_of(frame)
        along = np.column_stack([-contacts.normal[:, 1], contacts.normal[:, 0]])
        force = contacts.force[:, :1] * contacts.normal + contacts.force[:, 1:] * along
        upper, lower = (force[contacts.blocks[:, 0] == platen].sum(0) - force[contacts.blocks[:, 1] == platen].sum(0)
                        for platen in (results.n_blocks, results.n_blocks - 1))
        assert upper[1] / width == pytest.approx(found.stress[frame - 1], abs=LIGHT * inertia)
        assert -lower[1] / width == pytest.approx(found.stress[frame - 1], abs=inertia)


def test_a_test_without_pressure_ends_nearer_to_its_peak(tmp_path):
    """It ends in the first step whose stress is down to the share that its specimen names, and that is larger than under a pressure."""
    found = run_specimen(Specimen("bending", 60, width=0.025), 1, tmp_path)
    over_peak = found.stress / np.maximum.accumulate(found.stress)
    assert found.has_peak and over_peak[-1] <= found.specimen.fallen < over_peak[:-1].min()
    assert Specimen("biaxial", pressure=1e6).fallen < Specimen("biaxial").fallen == found.specimen.fallen < 1
    assert Specimen("biaxial", pressure=1e6, past_peak=0.8).fallen == Specimen("ucs", past_peak=0.8).fallen == 0.8


def test_bonds_are_counted(ucs):
    found, _ = ucs
    assert found.bonds[0].tolist()[1:] == [0, 0] and (np.diff(found.bonds[:, 0]) <= 0).all() and (np.diff(found.bonds[:, 1:], axis=0) >= 0).all()
    assert (found.bonds.sum(axis=1) <= found.bonds[0, 0] + 2).all() and sum(found.broken) > 0
    assert found.onset <= found.strength


@pytest.mark.parametrize("kind", TESTS)
def test_every_test_loads_its_specimen(tmp_path, kind):
    """Few grains, few steps: the model is valid, the stress grows from the start, and the platen goes as far as it is told."""
    specimen = Specimen(kind, 20, width=0.02, pressure=1e6 if kind in ("biaxial", "shear") else 0.0, steps=30, strain=0.02 * Specimen(kind).failing)
    found = run_specimen(specimen, 1, tmp_path)
    assert found.strain[-1] == pytest.approx(specimen.strain) and found.strength == found.stress[-1] > 0
    assert (np.diff(found.stress) > 0).all() and not found.has_peak


def test_mohr_coulomb_finds_the_line_of_strengths():
    cohesion, phi = 12e6, 35.0
    sine = math.sin(math.radians(phi))
    slope, start = (1 + sine) / (1 - sine), 2 * cohesion * math.cos(math.radians(phi)) / (1 - sine)
    assert mohr_coulomb([outcome("biaxial", p, start + slope * p) for p in (0, 5e6, 1e7)]) == pytest.approx((cohesion, phi))
    assert mohr_coulomb([outcome("shear", p, cohesion + math.tan(math.radians(phi)) * p) for p in (1e6, 2e6)]) == pytest.approx((cohesion, phi))
    assert mohr_coulomb([outcome("ucs", 0, 1e8)] * 3) is None


def test_the_command_writes_a_table_and_a_picture(tmp_path):
    done = subprocess.run([SOURCE / "tools" / "test_rock", "brazilian", "--grains", "20", "--seeds", "3", "1", "--steps", "40"], cwd=tmp_path,
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    rows = json.loads((tmp_path / "brazilian-tests" / "specimens.json").read_text())
    assert [row["seed"] for row in rows] == [3, 1] and (tmp_path / "brazilian-tests" / "specimens.png").stat().st_size > 0
    mean, spread = np.mean([row["strength"] for row in rows]), np.std([row["strength"] for row in rows], ddof=1)
    assert f"BTS: {mean / 1e6:.4g} +- {spread / 1e6:.2g} MPa" in done.stdout
    again = scree.laboratory("brazilian", seeds=[1], folder=tmp_path / "again", grains=20, steps=40)
    assert again.outcomes[0].strength == rows[1]["strength"] and again.strength == (rows[1]["strength"], 0.0)


def test_grains_are_written_by_a_command(tmp_path):
    done = subprocess.run([SOURCE / "tools" / "grains", "disc", "0.05", "--size", "0.01", "--mineral", "a=1", "--mineral", "b=1", "-o", "d.blk"],
                          cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "joint material 4: b and b" in done.stdout
    n = int(done.stdout.split()[1])
    (tmp_path / "d.ana").write_text("0 1 2 4 0.05 0.01\n" + "1 0 1e9 0.2\n0 0 0\n0 0 0\n0 0 0\n" * 2 + "30 0 0\n" * 4 + "&deck geometry='d.blk' /\n")
    said = scree.call("cut", "d.ana", "-o", "d.h5", cwd=tmp_path)
    assert said.returncode == 0, said.stderr
    assert scree.read(tmp_path / "d.h5").n_blocks == n
    wrong = subprocess.run([SOURCE / "tools" / "grains", "beam", "1", "1", "--size", "0.1", "-o", "b.blk"], cwd=tmp_path, capture_output=True, text=True)
    assert wrong.returncode == 2 and "expected 4 numbers, found 2" in wrong.stderr


@pytest.mark.parametrize("given", [{"kind": "triaxial"}, {"width": 0.0}, {"kind": "biaxial", "pressure": -1.0}])
def test_wrong_specimens_are_refused(given):
    with pytest.raises(ScreeError, match="expected"):
        Specimen(**given)
