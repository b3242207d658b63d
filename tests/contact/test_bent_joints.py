"""Joints between meshes that bend: nodes that lie on each other keep their one contact, and its bond, however far they do."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

STRONG = "30 1e12 1e12"


def settled(path, blocks, modulus, joint, measured, *groups):
    """A static run of meshed blocks to equilibrium."""
    path.with_suffix(".blk").write_text(block_file("bent", [(1, b) for b in blocks], measured=[(*measured, len(blocks))]))
    path.with_suffix(".ana").write_text("\n".join([
        "0 4000 1 1 0.1 0.02", f"1000 0 {modulus} 0.25", "0 0 0 0 0 0 0 0 0", joint, f"&deck geometry='{path.name}.blk', dialect='short' /",
        *groups, "&step balance=1e-7 /", ""]))
    r = scree.run(path.with_suffix(".ana"), output=path.with_suffix(".h5"))
    assert r.scene.status == "complete"
    return r


def sinks(r):
    return -r.measured_points.displacement[-1, 0, 1]


@pytest.mark.parametrize("strain", ["small", "green", "auto"])
@pytest.mark.parametrize("contact", ["", "&contact method='augmented', overlap=1e-8 /", "&joints kn=2e7 /"])
def test_what_is_bonded_goes_with_the_load(strain, contact, tmp_path):
    """Two meshes in a line, bonded. Past a bend of 1e-3 rad at a node each of the two had contacts of its own there, and two of four
    bonds were gone without a word: it sank by 6 % more."""
    def per_load(load):
        r = settled(tmp_path / f"line{load:g}", [[(0, 0), (1.43, 0), (1.57, 1), (0, 1)], [(1.43, 0), (3, 0), (3, 1), (1.57, 1)]], 1e6, STRONG, (2.9, 0.45),
                    f"&method model='nmm', strain='{strain}' /", "&cover edge=0.83, origin=0.53 0.25, angle=44.1 /",
                    "&support both=0 0 0 1 /", f"&boundary lines=3 0 3 1, traction=0 {-load} 0 {-load} /", contact)
        assert r.history.contacts[-1].tolist() == [0, 0, 4]
        return sinks(r) / load
    np.testing.assert_allclose(per_load(600), per_load(10), rtol=4e-3)


def layers(folder, n, load, length=4.0, depth=0.3):
    """A cantilever on a support at its left side, of n layers that are bonded, under a load at the right side of the lowest."""
    thick = depth / n
    blocks = [box(0, length, k * thick, (k + 1) * thick) for k in range(n)]
    return settled(folder / f"layers{n}", blocks, 1e7, STRONG, (length - 0.01, depth - 0.05), "&method model='nmm', strain='green' /", "&cover edge=0.25 /",
                   f"&support both=0 0 0 {depth} /",
                   f"&boundary lines={length} 0 {length} {depth / 2}, traction=0 {-load} 0 {-load} /")


@pytest.mark.parametrize("load", [1e3, 1e4, 1.5e5])
def test_bonded_layers_bend_as_one(load, tmp_path):
    """By up to 80 degrees, 3 to 6 at a node. Lines of &support hold it as fixed points would: it settles, and does not 'move'."""
    whole, two = layers(tmp_path, 1, load), layers(tmp_path, 2, load)
    assert two.history.contacts[-1].tolist() == [0, 0, 34]
    np.testing.assert_allclose(two.measured_points.displacement[-1], whole.measured_points.displacement[-1], rtol=0.025)


def hung(folder, load, layered=True):
    """A layer that hangs from another one, between supports at both ends of that."""
    blocks = [box(0, 4, 0, 0.5), box(0, 4, 0.5, 1)] if layered else [box(0, 4, 0, 1)]
    return settled(folder / f"hung{len(blocks)}", blocks, 1e7, "30 1e9 1e9", (2.03, 0.77), "&method model='nmm', strain='green' /",
                   "&cover edge=0.5, origin=0.13 0.07, angle=10 /", "&joints kn=1e9 /" if layered else "",
                   "&support both=0 .5 0 1 4 .5 4 1 /", f"&boundary lines=0 0 4 0, traction=0 {-load} 0 {-load} /")


def test_bonds_far_below_their_strength_stay(tmp_path):
    """15 of 20 were left, 18 were open, and it sank by 4 % more, with friction."""
    r = hung(tmp_path, 3e4)
    assert r.history.contacts[-1, 1:].tolist() == [0, 20] # others are looked for, and bear nothing
    assert r.history.energy.friction[-1] == 0
    whole = sinks(hung(tmp_path, 3e4, layered=False))
    assert whole < sinks(r) < 1.06 * whole


@pytest.mark.parametrize("strain", ["small", "green"])
def test_so_in_a_dynamic_run(strain, tmp_path):
    """13 of 20 were left. Nodes that lie apart by some hundredths of an edge have a contact each, and meet as corners where the joint
    opens."""
    (tmp_path / "hung.blk").write_text(block_file("hung", [(1, box(0, 4, 0, 0.5)), (1, box(0, 4, 0.5, 1))]))
    (tmp_path / "hung.ana").write_text("\n".join([
        "1 400 1 1 0.05 0.005", "1000 0 1e7 0.25", "0 0 0 0 0 0 0 0 0", "30 1e9 1e9", "&deck geometry='hung.blk', dialect='short' /",
        f"&method model='nmm', strain='{strain}' /", "&cover edge=0.5, origin=0.13 0.07, angle=10 /", "&joints kn=1e9 /",
        "&support both=0 .5 0 1 4 .5 4 1 /", "&boundary lines=0 0 4 0, traction=0 -6e4 0 -6e4 /", "&damping mass=8 /", ""]))
    r = scree.run(tmp_path / "hung.ana", output=tmp_path / "hung.h5")
    assert r.history.contacts[-1, 1:].tolist() == [0, 20]
    assert r.history.energy.friction[-1] < 1e-6 * 6e4 * 4 * 0.06  # of what the load does
