"""Joints with a stiffness of their own, through the program, against springs in series."""
import os
import pathlib

import numpy as np
import pytest
import scree
from scree.block_files import block_file
from test_blocks_touch import MODES, box, run

E, KN, KS = 1e8, 4e8, 1e8
ROCK = (2500.0, 25000.0, E, 0.0)  # a joint between blocks of 1 m gives a quarter of what they do
STATIC = {"carried": 0, "steps": 60, "dt": 1.0}


def joints(kn=KN, ks=KS):
    return f"\n&joints kn={kn}, ks={ks} /"


def split(corners, n, side):
    """A box whose bottom (0) or top (2) side has n edges."""
    a, b = corners[side], corners[(side + 1) % 4]
    between = [a + (b - a) * i / n for i in range(1, n)]
    return np.array([*corners[:side + 1], *between, *corners[side + 1:]])


def column(folder, blocks, groups, size=1.0, young=E, **options):
    """Boxes on each other, the first held; how far the middle of each has sunk."""
    fixed = [(*x, 1) for x in blocks[0]]
    f = run(folder, [b * size for b in blocks], groups, rock=(2500.0, 25000.0, young * size, 0.0), phi=30.0,
            fixed=[(x * size, y * size, b) for x, y, b in fixed], **{**STATIC, **options})
    return f.bodies.centroid[0, :, 1] - f.bodies.centroid[-1, :, 1], f


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("method", ["penalty", "augmented"])
@pytest.mark.parametrize("mode", MODES)
def test_a_column_sinks_as_blocks_and_joints_in_series(mode, method, size, tmp_path):
    """Under weights w of boxes of edge l: joint i bears W_i and gives W_i/(kn l), a box gives (W_i + w/2)/E where W_i stands on it.
    So 1/E_eff = 1/E + 1/(kn l). What is left is the square of the strain, 1e-3, and what a box of constant strain has for its
    own weight. Multipliers leave such joints what they give; they held them, too, without a word."""
    n, w = 4, 25000.0 * size**2
    sunk, _ = column(tmp_path, [box(-1, -1, 3, 1), *(box(0, i, 1, 1) for i in range(n))], f"{MODES[mode]}{joints(KN, KS)}\n&contact method='{method}' /", size)
    above = w * np.arange(n - 1, -1, -1)
    squeezed = (above + w / 2) / (E * size)                  # of each box
    opened = (above + w) / (KN * size)                       # of the joint below each box
    expected = np.cumsum(opened) + np.cumsum(squeezed) - squeezed / 2
    np.testing.assert_allclose(sunk[1:], expected, rtol=3e-3)
    assert opened.sum() > 0.2 * squeezed.sum()               # else nothing was proved


@pytest.mark.parametrize("mode", MODES)
def test_a_joint_shears_by_its_own_stiffness(mode, tmp_path):
    """A load T along a joint of length l moves what lies on it by T/(ks l). Its middle, at h/2, moves by its own shear T/(2 G l)
    and the tilt T (h/2)/(kn l^3/4) on its two contacts, too."""
    blocks, T, height, length = [box(-1, -1, 4, 1), box(0, 0, 2, 0.2)], 2500.0 * 0.4 * 2, 0.2, 2.0
    for kn in (KN, 9 * KN):
        _, f = column(tmp_path, blocks, MODES[mode] + joints(kn) + "\n&acceleration table=0 -2 0  1e9 -2 0 /")
        moved = f.bodies.centroid[-1, 1, 0] - f.bodies.centroid[0, 1, 0]
        expected = T / (KS * length) + T / (E * length) * height / 2 + T * height**2 / (kn * length**3)
        assert moved == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("bonded", [{}, {"cohesion": 1e9, "strength": 1e9}], ids=["rubs", "bonded"])
def test_vertices_that_shear_apart_keep_their_contact(bonded, mode, tmp_path):
    """A load along a joint that grows, until vertices that were at one place are apart by some 1e-3 of their edges: it slips by what one
    between undivided faces does. Their contact became two, of which one began without a force, and what bonded meshes bore depended
    on the last digits of their places."""
    moved = []
    for i, n in enumerate((1, 8)):
        (tmp_path / str(i)).mkdir()
        blocks = [split(box(-1, -1, 4, 1), 2 * n, 2), split(box(0, 0, 2, 0.2), n, 0)]
        load = "\n&acceleration table=0 0 0  40 -4 0  1e9 -4 0 /"
        _, f = column(tmp_path / str(i), blocks, f"{MODES[mode]}{joints(KN, 4e6)}{load}", young=1e10, **bonded)
        moved.append(f.bodies.centroid[-1, 1, 0] - f.bodies.centroid[0, 1, 0])
    assert moved[0] == pytest.approx(2500.0 * 0.4 * 4 / (4e6 * 2), rel=1e-2)
    assert moved[1] == pytest.approx(moved[0], rel=1e-3)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("below,above", [(1, 1), (1, 2), (2, 1), (1, 3), (3, 1), (2, 2), (3, 3), (2, 3), (4, 3)])
def test_the_number_of_contacts_does_not_matter(below, above, mode, tmp_path):
    """A joint whose sides have 1 to 4 edges, whose ends may or may not meet: 2 to 6 contacts, and W/(kn l) all the same."""
    floor, block = box(0, -1, 1, 1), box(0, 0, 1, 1)
    sunk, f = column(tmp_path, [split(floor, below, 2), split(block, above, 0)], MODES[mode] + joints())
    closed = f.history.contacts[-1, 1:].sum()
    assert closed == below + above - (np.gcd(below, above) - 1)
    assert sunk[1] == pytest.approx(25000.0 / KN + 25000.0 / (4 * E), rel=1e-3)


@pytest.mark.parametrize("parts", [1, 2, 4, 8, 16])
def test_against_tilting_springs_at_the_ends_of_parts(parts, tmp_path):
    """A load off the middle, in the middle third, tilts a block by M/(kn L^3/12 (1 + 2/n^2)), of a floor with n edges: half the length of each is
    a spring at either end. A joint all of whose length gives would tilt by M/(kn L^3/12), three times as far as without parts."""
    floor, block, kn, force, aside = split(box(0, -1, 1, 1), parts, 2), box(0, 0, 1, 1), 1e7, 1e4, 0.2
    (tmp_path / "a.blk").write_text(block_file("tilts", [(1, floor), (1, block)], [(*(0.9 * x + [0.05, -0.05]), 1) for x in floor],
                                               load=[(0.5 + aside, 0.5, 2)]))
    (tmp_path / "a.ana").write_text("\n".join([
        "0 200 1 1 0.05 0.02", f"2500 25000 1e12 0 {'0 ' * 9}", "30 0 0", f"&loads force=0 {-force} /",
        "&deck geometry='a.blk', dialect='short' /", f"&joints kn={kn}, ks={kn} /", "&step balance=1e-8 /", ""]))
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    stiffness = kn / 12 * (1 + 2 / parts**2) - (25000 + force) / 2  # what is up there leans out, too
    assert -r.history.rotation[-1, 1] == pytest.approx(force * aside / stiffness, rel=2e-3)
    assert r.bodies.centroid[0, 1, 1] - r.bodies.centroid[-1, 1, 1] == pytest.approx((25000 + force) / kn, rel=5e-3)


@pytest.mark.parametrize("contact", [joints(), joints(1e7, 1e7)])
@pytest.mark.parametrize("apart", [0.0, 1e-5, 1.1e-3, 2e-3, 0.01, 0.03, 0.1])
@pytest.mark.parametrize("n", [1, 2, 5, 11])
def test_vertices_that_change_nothing_do_not_matter(n, apart, contact, tmp_path):
    """On both faces of a joint, a little apart: from 1e-3 of their edges on each has a contact. Up to some hundredths two had one, which
    stood for what one of them stands for: the joint gave up to twice as much."""
    at = np.linspace(0, 3, n + 2)[1:-1]
    floor = np.array([[0, -1], [3, -1], [3, 0], *((x, 0) for x in at[::-1]), [0, 0]])
    block = np.array([[0, 0], *((x + apart, 0) for x in at), [3, 0], [3, 1], [0, 1]])
    sunk, f = column(tmp_path, [floor, block], contact, steps=200)
    kn = KN if contact == joints() else 1e7
    assert sunk[1] == pytest.approx(25000.0 / kn + 25000.0 / (4 * E), rel=3e-3)
    assert f.history.contacts[-1, 1:].sum() == 2 + n * (1 + (apart > 0.99e-3 * 3 / (n + 1)))


@pytest.mark.parametrize("edge", [0.25, 0.1])
@pytest.mark.parametrize("speed", [0.0, 7.0, 20.0])
def test_what_moves_as_one_closes_as_at_rest(speed, edge, tmp_path):
    """Meshes that are pressed together in flight: with a step of half of their edges and more vertices counted as corners that may meet
    as far as they went, and the joint had four times its contacts, and gave less than half."""
    groups = (f"&method model='nmm', strain='green' /\n&cover edge={edge} /{joints(1e7, 1e7)}\n"
              "&boundary lines=0 1 3 1 3 -1 0 -1, traction=0 -1e4 0 -1e4 0 1e4 0 1e4, ramp=0.2 /")
    f = run(tmp_path, [box(0, -1, 3, 1), box(0, 0, 3, 1)], groups, rock=(2500.0, 0.0, E, 0.0), phi=30.0, steps=50, velocity=((0, speed, 0),))
    y = f.bodies.centroid[:, :, 1]
    assert (y[0, 1] - y[0, 0]) - (y[-1, 1] - y[-1, 0]) == pytest.approx(1.0634e-3, rel=1e-3)
    assert f.history.contacts[-1, 1:].sum() == 3 / edge + 1


@pytest.mark.parametrize("below, above", [([0.66], [0.84]), ([0.66], []), ([0.9], [1.1])])
@pytest.mark.parametrize("kn", [1e9, 1e10])
@pytest.mark.parametrize("pressure", [1e5, 1e6])
def test_long_static_steps_have_the_contacts_of_short_ones(pressure, kn, below, above, tmp_path):
    """A block of 1 m under pressure, whose corner is 0.16 m from a vertex of the floor: however long the steps on the way to the
    balance are, and however far contacts are looked for, both stay apart. They had one contact; the joint gave 1.1 times p/kn."""
    floor = np.array([(0, -0.5), (2, -0.5), (2, 0), *((x, 0) for x in below), (0, 0)])
    block = np.array([(0.5, 0), *((x, 0) for x in above), (1.5, 0), (1.5, 0.5), (0.5, 0.5)])
    group = f"&step balance=1e-8 /\n&boundary lines=0.5 0.5 1.5 0.5, pressure={pressure}, {pressure} /"
    sunk, _ = column(tmp_path, [floor, block], f"\n{group}{joints(kn, kn)}", young=1e10, steps=300, dt=0.01)
    weight = 25000.0 * 0.5
    assert sunk[1] == pytest.approx((pressure + weight) / kn + (pressure + weight / 2) / 4e10, rel=1e-3)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("floor, block", [(1, 2), (2, 1)])
@pytest.mark.parametrize("soft", [1, 2])
@pytest.mark.parametrize("width", [0.5, 1.0, 2.0])
def test_of_two_faces_the_softer_one_is_the_material(width, soft, floor, block, mode, tmp_path):
    """A block on a post as wide, wider or narrower: vertices of the joint are the block's, the post's, or either where rounding tells.
    It gives W/(kn l) with kn of the softer material, whichever number and side that has."""
    def both(stiffness):
        return f"{stiffness} 1e10" if soft == 1 else f"1e10 {stiffness}"

    post, on_it = box(0, -1, 1, 1), box(0.5 - width / 2, 0, width, 1)
    (tmp_path / "a.blk").write_text(block_file("two materials", [(1, post, [floor] * 4), (1, on_it, [block] * 4)], [(*x, 1) for x in post]))
    (tmp_path / "a.ana").write_text("\n".join([
        "0 60 1 2 0.05 1", f"2500 25000 1e10 0 {'0 ' * 9}", "30 0 0", "30 0 0", "&deck geometry='a.blk', dialect='short' /",
        f"&joints kn={both(KN)}, ks={both(KS)} /", MODES[mode], ""]))
    centroid = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5").bodies.centroid
    weight, length = 25000.0 * width, min(1.0, width)
    assert centroid[0, 1, 1] - centroid[-1, 1, 1] == pytest.approx(weight / (KN * length), rel=0.02)


FLOORS = {
    "changes at its right end": ([(0, -1), (2, -1), (2, 0), (1, 0), (0, 0)], [1, 1, 2, 1, 1], 0),
    "changes at its left end": ([(0, -1), (2, -1), (2, 0), (1, 0), (0, 0)], [1, 1, 1, 2, 1], 1),
    "a riser at its right end": ([(0, -1), (2, -1), (2, 2), (1, 2), (1, 0), (0, 0)], [1, 1, 2, 2, 1, 1], 0),
    "a riser at its left end": ([(0, -1), (2, -1), (2, 0), (1, 0), (1, 2), (0, 2)], [1, 1, 1, 2, 2, 2], 1),
}


@pytest.mark.parametrize("floor", FLOORS)
def test_an_edge_beside_a_joint_is_none_of_its_faces(floor, tmp_path):
    """A block of material 1, but for its side at a riser, on a face of material 1 between edges of material 2: its joint has material 1.
    The block hardly presses on the riser."""
    outline, materials, left = FLOORS[floor]
    faces = [1, 2 if "riser" in floor and left == 0 else 1, 1, 2 if "riser" in floor and left == 1 else 1]
    (tmp_path / "a.blk").write_text(block_file(floor, [(1, np.array(outline), materials), (1, box(left, 0, 1, 1), faces)],
                                               [(*x, 1) for x in outline]))
    (tmp_path / "a.ana").write_text("\n".join([
        "0 60 1 2 0.05 1", f"2500 25000 1e10 0 {'0 ' * 9}", "30 0 0", "0 0 0", "&deck geometry='a.blk', dialect='short' /",
        "&joints kn=1e9 1e8, ks=1e9 1e8 /", ""]))
    f = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert f.bodies.centroid[0, 1, 1] - f.bodies.centroid[-1, 1, 1] == pytest.approx(25000 / 1e9, rel=0.03)
    assert abs(f.history.rotation[-1, 1]) < 1e-7


@pytest.mark.parametrize("width", [0.01, 0.04, 0.2])
def test_narrow_joints_between_long_edges_are_no_stiffer(width, tmp_path):
    """A column of 1 that is narrow: its joint gives p/kn under the stress p, and its middle, of constant strain, p/4E more."""
    blocks = [box(-1, -1, 3, 1), box(0, 0, width, 1)]
    sunk, _ = column(tmp_path, blocks, joints())
    assert sunk[1] == pytest.approx(25000.0 / KN + 25000.0 / (4 * E), rel=3e-3)


@pytest.mark.parametrize("edge", [0.17, 0.25, 0.6])
@pytest.mark.parametrize("strain", ["small", "green"])
def test_the_mesh_does_not_matter(strain, edge, tmp_path):
    """The same between stiff boxes, under meshes that cut both sides of the joint alike."""
    groups = f"&method model='nmm', strain='{strain}' /\n&cover edge={edge} /" + joints()
    sunk, f = column(tmp_path, [box(0, -1, 1, 1), box(0, 0, 1, 1)], groups, young=1e13)
    assert sunk[1] == pytest.approx(25000.0 / KN, rel=1e-3)
    assert f.history.contacts[-1, 1:].sum() > 2


CORNERS = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tests/data/corners"


def meeting(name, folder, **options):
    """A corner that comes down on one, whose edges have joints of two materials, of which one has a stiffness of its own."""
    return scree.run(CORNERS / f"{name}.blk", CORNERS / f"{name}.ana", output=folder / f"{name}.h5", **options)


def test_corners_meet_as_their_mirror_image_does(tmp_path):
    """kn 0 is the stiffness of contact, whichever of the two edges the search comes to first."""
    one, other = (meeting(name, tmp_path).bodies.velocity[-1, 1] for name in ("kn_order", "kn_mirrored"))
    np.testing.assert_allclose(one, other * [-1, 1], rtol=1e-9)


@pytest.mark.parametrize("kn", ["1e9 0", "0 1e9", "1e9 1e8", "1e11 0"])
def test_springs_of_two_materials_make_no_energy(kn, tmp_path):
    """One that is found inside, as edges turn, is as stiff as what it stands for, and a closed one keeps its stiffness."""
    lost = meeting("kn_of_one", tmp_path, set={"joints.kn": kn}).history.energy.dissipated
    assert np.diff(np.append(0, lost)).min() > -1e-9 * 11250


@pytest.mark.parametrize("name", ["kn_turns_off", "kn_alone", "kn_beside"])
def test_what_lands_and_slides_on_makes_no_energy(name, tmp_path):
    """A polygon of 30 sides whose corner turns off the floor as it rolls, a square that comes down on its corner on a row of blocks, and one
    beside a vertex of the floor: where the contact that bears alone won its length at once, 1.8e-2, 1.1e-2 and 2.4e-3 of their energy
    were made in a step."""
    energy = meeting(name, tmp_path).history.energy
    assert np.diff(np.append(0, energy.dissipated)).min() > -2e-4 * energy.kinetic.max()
    assert (energy.friction - energy.dissipated).max() < 1e-5 * energy.kinetic.max()
