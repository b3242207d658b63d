"""Fully grouted bolts through the program: springs along and across them at each joint that they cross."""
import os
import pathlib

import numpy as np
import pytest

import scree
from scree import block_files, call
from scree.block_files import block_file, box, held, turned
from scree.validation import references

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
M12 = SOURCE / "input/validation/m12-grouted-block"
TILT = -np.pi / 6


def test_the_forces_that_hold_a_block():
    """At 0 degrees all is along the bolt, at 90 across it: W (sin p - cos p tan phi). Springs of one stiffness press with nothing."""
    assert references.grouted_bolt(100.0, 30, 20, 0, 1e4, 5e3) == pytest.approx((18.479253, 0), abs=1e-6)
    assert references.grouted_bolt(100.0, 30, 20, 90, 1e4, 5e3) == pytest.approx((0, -18.479253), abs=1e-6)
    along, across = references.grouted_bolt(100.0, 30, 20, 37, 7e3, 7e3)
    assert np.hypot(along, across) == pytest.approx(18.479253, abs=1e-6)
    along, across = references.grouted_bolt(100.0, 30, 20, 60, 1e4, 5e3)  # balance, with the sum of forces
    c, s, mu = np.cos(np.pi / 3), np.sin(np.pi / 3), np.tan(np.radians(20))
    up, into = along * c - across * s, along * s + across * c
    assert 100 * np.sin(np.pi / 6) == pytest.approx(up + mu * (100 * np.cos(np.pi / 6) + into))


def sloping(folder, size, share, groups=""):
    """A block of 2 x 1 on a plane of 30 degrees, held by a bolt at 60 degrees to it with a share of what it needs; stress as of 1 m."""
    ground, block = (size * turned(box(*corners), TILT) for corners in ((-8, 10, -4, 0), (0, 2, 0, 1)))
    (folder / "x.blk").write_text(block_file("x", [(1, ground), (2, block)], held(ground, 1)))
    along, across = references.grouted_bolt(2 * size, 30, 20, 60, 100.0, 50.0)
    ends = size * turned([(1, 0.5), (1 - 1.5, 0.5 - 1.5 * np.tan(np.pi / 3))], TILT)
    rock = f"{0.1 / size} {{}} 1e5 0.25\n0 0 0\n0 0 0\n0 0 0\n"
    (folder / "x.ana").write_text(
        f"0\n100\n2 1\n0.05\n{0.1 * size}\n" + rock.format(0) + rock.format(1 / size) + "20 0 0\n"
        f"&step balance=1e-5 /\n&bolts ends={' '.join(map(repr, map(float, ends.ravel())))}, stiffness=100, shear_stiffness=50, "
        f"strength={share * along}, shear_strength={-share * across} /\n" + groups)
    return [folder / "x.blk", folder / "x.ana"], along, across


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("groups", ["&method strain='small' /", "&method strain='green' /", "&method model='nmm' /"])
def test_a_bolt_holds_what_its_strengths_hold(size, groups, tmp_path):
    decks, along, across = sloping(tmp_path, size, 1.01, groups)
    r = scree.run(*decks, output=tmp_path / "r.h5")
    assert r.scene.status == "complete"
    assert (r.bolts.force[-1, 0], r.bolts.shear[-1, 0]) == pytest.approx((along, across), rel=5e-3)
    assert r.bolts.slip[-1, 0] == pytest.approx(r.bolts.shear[-1, 0] / 50, rel=1e-9) and r.bolts.state[-1, 0] == 0
    decks, along, across = sloping(tmp_path, size, 0.99, groups)
    r = scree.run(*decks, output=tmp_path / "r.h5")
    assert r.scene.status.startswith("moves: block 2") and r.bolts.state[-1, 0] == 1
    assert (r.bolts.force[-1, 0], r.bolts.shear[-1, 0]) == pytest.approx((0.99 * along, 0.99 * across), rel=1e-9)


def test_one_that_breaks_lets_go(tmp_path):
    decks, _, _ = sloping(tmp_path, 1.0, 0.9)
    r = scree.run(*decks, output=tmp_path / "r.h5", settings=["bolts.limit=breaks"])
    assert r.scene.status.startswith("moves: block 2")
    assert (r.bolts.state[-1, 0], r.bolts.force[-1, 0], r.bolts.shear[-1, 0]) == (2, 0, 0)


def stacked(folder, gap, groups, step="0\n100"):
    """A table and two blocks of 4 x 1 above each other, a gap between these."""
    table = box(-2, 6, -2, 0)
    blocks = [(1, table), (1, box(0, 4, 0, 1)), (1, box(0, 4, 1 + gap, 2 + gap))]
    (folder / "x.blk").write_text(block_file("x", blocks, held(table, 1)))
    (folder / "x.ana").write_text(f"{step}\n1 1\n0.05\n0.01\n2 20 1e6 0.25\n0 0 0\n0 0 0\n0 0 0\n20 0 0\n" + groups)
    return [folder / "x.blk", folder / "x.ana"]


BOLTS = "&bolts ends=1 2 1 -1  3 -1 3 3, stiffness=1e3, shear_stiffness=5e2, pretension=2 1 /\n"


def test_a_bolt_has_springs_at_each_joint_that_it_crosses(tmp_path):
    """Two bolts, two joints: pieces of each follow each other and make all of it but what is in the air; each has its pretension."""
    r = scree.run(*stacked(tmp_path, 0.0, BOLTS), output=tmp_path / "r.h5")
    assert r.bolts.number[0].tolist() == [1, 1, 2, 2]
    assert r.bolts.ends[0] == pytest.approx(np.array([[1, 2, 1, 0.5], [1, 0.5, 1, -1], [3, -1, 3, 0.5], [3, 0.5, 3, 2]]))
    assert r.bolts.force[0] == pytest.approx([2, 2, 1, 1]) and r.bolts.shear[0] == pytest.approx(0, abs=1e-12)
    from scree import drawing

    ends, states = drawing.Frames(tmp_path / "r.h5", "r").bolts(0)
    assert ends.shape == (4, 2, 2) and not states.any()


def test_there_is_no_joint_where_bodies_are_apart(tmp_path):
    r = scree.run(*stacked(tmp_path, 0.5, BOLTS.replace("1 2 1 -1", "1 2.4 1 -1")), output=tmp_path / "r.h5")
    assert r.bolts.number[0].tolist() == [1, 2] and r.bolts.ends[0, 0] == pytest.approx([1, 1, 1, -1])
    for ends, expected in (("1 2.4 1 0.5  2 0.2 2 0.9", "grouted bolts that cross joints between two blocks, found none that does"),
                           ("1 2.4 1 -1  8 0 8 9", "a grouted bolt in blocks, found one outside")):
        done = call("run", *stacked(tmp_path, 0.5, BOLTS.replace("1 2 1 -1  3 -1 3 3", ends)), "-o", tmp_path / "no.h5")
        assert done.returncode == 2 and f"x.ana:11: expected {expected}\n" in done.stderr


@pytest.mark.parametrize("groups, said", [
    ("&bolts ends=1 2 1 -1, stiffness=1e3, shear_strength=5 /", "expected no shear strength without a shear stiffness of bolt 1, found 5"),
    ("&bolts ends=1 2 1 -1  2 2 2 -1, stiffness=1e3, shear_stiffness=1 0, shear_strength=5 /",
     "expected no shear strength without a shear stiffness of bolt 2, found 5"),
    ("&bolts ends=1 2 1 -1, stiffness=1e3, shear_stiffness=-1 /", "bolts.shear_stiffness"),
    ("&bolts shear_stiffness=1 /", "expected bolts.shear_stiffness only with bolts.ends")])
def test_numbers_that_are_no_grouted_bolt_are_refused(groups, said, tmp_path):
    done = call("run", *stacked(tmp_path, 0.0, groups), "-o", tmp_path / "no.h5")
    assert done.returncode == 2 and said in done.stderr


STAGES = """&joints phi=40 /
&stage name='bolted' /
&joints phi=20 /
{bolts}
&stage name='let go' /
&bolts ends=none /
"""


def test_bolts_come_and_go_with_stages(tmp_path):
    """What the block moved by before they came stretches them not; without them it slides."""
    decks, along, across = sloping(tmp_path, 1.0, 2.0)
    text = decks[1].read_text()
    bolts = text[text.index("&bolts"):]
    decks[1].write_text(text.replace(bolts, "") + STAGES.format(bolts=bolts.strip()))
    r = scree.run(*decks, output=tmp_path / "r.h5")
    assert r.scene.status.startswith("moves: stage 3 (let go): block 2")
    assert set(r.bolts.state[:, 0]) == {0, 3}
    bolted = np.flatnonzero(r.bolts.state[:, 0] == 0)[-1]
    assert (r.bolts.force[bolted, 0], r.bolts.shear[bolted, 0]) == pytest.approx((along, across), rel=5e-3)
    assert r.bolts.force[-1, 0] == r.bolts.shear[-1, 0] == 0


def test_energy_that_grouted_bolts_take_is_booked(tmp_path):
    """Blocks that drift apart, without contact, in the form of the step that keeps energy: work = energy + what yielded."""
    groups = ("&method strain='green' / &integrator scheme='energy_momentum', beta=0.5, start='zero' / &contact method='none' /\n"
              "&acceleration table=0 8 0 0.3 8 3 0.4 0 0 /\n" + BOLTS.replace("pretension=2 1", "pretension=0, strength=4, shear_strength=3"))
    r = scree.run(*stacked(tmp_path, 0.0, groups, "1\n60"), output=tmp_path / "r.h5")
    energy = r.history.energy
    assert energy["yield"][-1] > 0.1 and (r.bolts.state[-1] == 1).any()
    assert energy.dissipated == pytest.approx(energy["yield"], abs=1e-8 * energy.kinetic.max())
