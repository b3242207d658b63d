"""What holds the ends of bolts: the block that an end lies in, or stands out of a little; the ground only where the deck says so."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

LENGTH = 2.0
REACH = 0.01 * LENGTH  # that a head may stand out of the rock


def deck(folder, head, words="", model="dda"):
    """A floor that is held and a block on it without friction, pulled aside by its weight; a bolt of 2 m from the floor to a head."""
    floor, block = box(-2, 3, -1, 0), box(0, 1, 0, 1)
    (folder / "a.blk").write_text(block_file("bolted", [(1, floor), (1, block)], [(-1.9, -0.9, 1), (2.9, -0.9, 1), (2.9, -0.1, 1)]))
    (folder / "a.ana").write_text("\n".join([
        "1 50 1 1 0.05 0.01", "2500 25000 1e10 0.2" + " 0" * 9, "0 0 0", "&deck geometry='a.blk', dialect='short' /",
        f"&method model='{model}' /", "&cover edge=0.7 /" if model == "nmm" else "", "&acceleration table=0 -1 0  1e9 -1 0 /",
        f"&bolts ends=0.5 {head - LENGTH} 0.5 {head}, stiffness=1e6, pretension=1000{words} /", ""]))
    return folder / "a.ana"


@pytest.mark.parametrize("model", ["dda", "nmm"])
@pytest.mark.parametrize("out", [0.5 * REACH, 0.99 * REACH])
def test_a_head_that_stands_out_of_the_rock_holds_the_rock(out, model, tmp_path):
    """The block goes with the head: the bolt pulls at both, as with its head on the surface of the block."""
    r = scree.run(deck(tmp_path, 1 + out, model=model))
    first, head = (np.reshape(r.bolts.ends[frame, 0], (2, 2))[1] for frame in (0, -1))
    assert first == pytest.approx([0.5, 1.0], abs=1e-12)
    moved = r.bodies.centroid[-1, 1] - r.bodies.centroid[0, 1]
    assert moved[0] > 0.01 and head - [0.5, 1.0] == pytest.approx(moved, abs=0.2 * moved[0])
    said = scree.call("check", tmp_path / "a.ana").stdout
    assert f"1 ends up to {out:.4g} outside the blocks, moved to the nearest one" in said and "ground holds" not in said


@pytest.mark.parametrize("out", [1.01 * REACH, 0.3])
def test_a_head_in_the_air_is_refused(out, tmp_path):
    """One line with the place, the nearest block and how far it is; the ground held such a head."""
    done = scree.call("run", deck(tmp_path, 1 + out), "-o", tmp_path / "a.h5")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1
    assert f"{tmp_path}/a.ana:8: expected both ends of a bolt in blocks" in done.stderr
    assert f"found the end (0.5, {1 + out:.6g}), {out:.4g} from block 2" in done.stderr and "outside='ground'" in done.stderr
    assert not (tmp_path / "a.h5").exists()


def test_the_ground_holds_an_end_where_the_deck_says_so(tmp_path):
    """The head stays where it is, the other end moves with the floor, which is held."""
    r = scree.run(deck(tmp_path, 1.3, ", outside='ground'"))
    np.testing.assert_array_equal(r.bolts.ends[0], r.bolts.ends[-1])
    assert "1 ends in no block, which the ground holds" in scree.call("check", tmp_path / "a.ana").stdout


def test_the_ground_holds_no_end_that_stands_out_of_the_rock(tmp_path):
    """Not even where the deck lets the ground hold ends: the head of a bolt is not an anchor."""
    out = scree.run(deck(tmp_path, 1 + 0.5 * REACH, ", outside='ground'"), output=tmp_path / "g.h5")
    refused = scree.run(deck(tmp_path, 1 + 0.5 * REACH), output=tmp_path / "r.h5")
    np.testing.assert_array_equal(out.bodies.centroid, refused.bodies.centroid)


def test_a_geometry_says_so_in_its_own_groups(tmp_path):
    """Rows of bolts in a geometry deck, and in the block file that is cut from it."""
    rows = "1e-3\n4 4 0 1 1 0 0 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n0.5 0.5 0.5 5 1e6 0 0\n-1 0.5 3 0.5\n"
    (tmp_path / "a.ana").write_text("1 2 1 1 0.05 0.01\n2500 25000 1e10 0.2" + " 0" * 9 + "\n0 0 0\n&deck geometry='a.geo', dialect='short' /\n")
    (tmp_path / "a.geo").write_text(rows)
    done = scree.call("cut", tmp_path / "a.geo", "-o", tmp_path / "a.blk")
    assert done.returncode == 2 and "a.geo:7: expected both ends of a bolt in blocks" in done.stderr
    (tmp_path / "a.geo").write_text(rows + "&bolts outside='ground' /\n")
    assert scree.call("cut", tmp_path / "a.geo", "-o", tmp_path / "a.blk").returncode == 0
    for geometry in ("a.geo", "a.blk"):
        assert "which the ground holds" in scree.call("check", tmp_path / geometry, tmp_path / "a.ana").stdout


def test_a_grouted_bolt_needs_no_word_for_a_head_in_the_air(tmp_path):
    """Grout holds it where it crosses joints, and nothing holds its ends."""
    done = scree.call("check", deck(tmp_path, 1.5, ", shear_stiffness=1e5"))
    assert done.returncode == 0 and "grouted ones cross 1 joints" in done.stdout
