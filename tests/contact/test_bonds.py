"""Cohesion and tensile strength of joints, through the program, against limit equilibrium."""
import numpy as np
import pytest
import scree
from scree import block_files
from test_blocks_touch import G, MODES, box, incline, run, turn

WEIGHT = 2.5 * 0.5 * G  # of the block on the incline, which touches over a length of 1
SOFT = (2.5, 2.5 * G, 1e7, 0.25)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("angle,phi", [(30, 0.0), (60, 0.0), (30, 20.0), (35, 34.0)])
def test_a_block_slides_where_cohesion_and_friction_do_not_carry_its_weight(mode, angle, phi, tmp_path):
    """Static: c l = W (sin a - cos a tan phi) is the limit, to 1 % of c; the joint does not give way one contact at a time."""
    a = np.radians(angle)
    limit = WEIGHT * (np.sin(a) - np.cos(a) * np.tan(np.radians(phi)))
    for share, slides in [(0.99, True), (1.01, False)]:
        u, f = incline(tmp_path, angle, phi, MODES[mode], rock=SOFT, cohesion=share * limit, carried=0, steps=100, dt=0.01,
                       name=f"{share}")
        assert (-u[-1, 0] > 1e-3) == slides
        if not slides:
            assert abs(u[-1, 0] - u[50, 0]) < 1e-9


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("phi", [0.0, 30.0])
def test_a_block_hangs_by_the_strength_of_its_joint(mode, phi, tmp_path):
    """T l = W is the limit, to 1 %; beyond it the block falls freely from the start, by g t^2/2 and, as its acceleration
    begins at once, g dt^2/16."""
    blocks = [box(-2, 0, 5, 1), box(0, -1, 1, 1)]
    for share, falls in [(0.99, True), (1.01, False)]:
        f = run(tmp_path, blocks, MODES[mode], rock=SOFT, phi=phi, strength=share * 2.5 * G, steps=60, dt=0.01,
                fixed=[(x, y, 1) for x, y in blocks[0]], measured=[(0.5, -0.5, 2)], name=f"{share}")
        t, u = f.history.time, f.measured_points.displacement[:, 0, 1]
        if falls:
            np.testing.assert_allclose(u, -G * (t**2 / 2 + 0.01**2 / 16), rtol=1e-9)
        else:
            assert np.abs(u).max() < 1e-5
            assert (f.history.contacts[:, 1:].sum(1) == 2).all()


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("stretch", [1e-3, 3e-3, 0.03])
def test_a_soft_joint_is_stretched_and_holds(stretch, mode, tmp_path):
    """The weight that comes at once stretches joints.kn to twice what it gives at rest, and pulls with twice its force: to 5 % for T. Of
    2e-3 of the edge on the bond was not found again, and let go whatever its strength."""
    weight = 2.5 * G
    for share, falls in [(0.95, True), (1.05, False)]:
        f = run(tmp_path, [box(-2, 0, 5, 1), box(0, -1, 1, 1)], f"{MODES[mode]}\n&joints kn={weight / stretch}, ks={weight / stretch} /",
                rock=(2.5, weight, 1e7, 0.0), strength=2 * share * weight, cohesion=2 * weight, steps=200, dt=0.02 * np.sqrt(stretch),
                fixed=[(x, y, 1) for x, y in box(-2, 0, 5, 1)], measured=[(0.5, -0.5, 2)], name=f"{share}")
        u = f.measured_points.displacement[:, 0, 1]
        assert (u[-1] < -3 * stretch) == falls
        if not falls:
            assert u.min() == pytest.approx(-2 * stretch, rel=0.03)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("contact", ["", "&contact method='augmented' /"])
def test_bonds_of_all_lengths_are_pulled_by_the_same_stress(mode, contact, tmp_path):
    """A block 3 wide hangs from one 0.5 wide and one 2.5: T l = W of both together is the limit, to 1 %."""
    blocks = [box(0, 0, 0.5, 1), box(0.5, 0, 2.5, 1), box(0, -1, 3, 1)]
    for share, falls in [(0.99, True), (1.01, False)]:
        f = run(tmp_path, blocks, f"{MODES[mode]}\n{contact}", rock=(2.5, 2.5 * G, 1e9, 0.0), phi=30.0, strength=share * 2.5 * G, carried=0,
                steps=40, dt=0.01, fixed=[(x, y, b) for b in (1, 2) for x, y in blocks[b - 1]], measured=[(1.5, -0.5, 3)], name=f"{share}")
        assert (np.abs(f.measured_points.displacement).max() > 1e-3) == falls


@pytest.mark.parametrize("far", [10, 60, 200])
def test_bonds_elsewhere_do_not_matter(far, tmp_path):
    """The same beside a pair of bonded plates that is far away and as long as that."""
    blocks = [box(0, 0, 0.5, 1), box(0.5, 0, 2.5, 1), box(0, -1, 3, 1), box(100, 0, far, 1), box(100, -1, far, 1)]
    f = run(tmp_path, blocks, rock=(2.5, 2.5 * G, 1e9, 0.0), phi=30.0, strength=1.01 * 2.5 * G, carried=0, steps=40, dt=0.01,
            fixed=[(x, y, b) for b in (1, 2, 4) for x, y in blocks[b - 1]], measured=[(1.5, -0.5, 3)])
    assert np.abs(f.measured_points.displacement).max() < 1e-6


@pytest.mark.parametrize("edge", [0.25, 0.37, 0.4, 0.55, 0.7])
@pytest.mark.parametrize("contact", ["", "&contact method='augmented' /"])
def test_a_bonded_mesh_bears_its_strength(edge, contact, tmp_path):
    """Two plates of manifold elements, 3 x 1, pulled apart by p: T = p is the limit, to 1 %, however the mesh cuts them."""
    pull = 100.0
    groups = (f"&method model='nmm' /\n&cover edge={edge} /\n&support both=0 -1 3 -1 /\n{contact}\n"
              f"&boundary lines=0 1 3 1, traction=0 {pull} 0 {pull} /")
    for share, falls in [(0.99, True), (1.01, False)]:
        f = run(tmp_path, [box(0, -1, 3, 1), box(0, 0, 3, 1)], groups, rock=(2.5, 0.0, 1e7, 0.0), phi=30.0, cohesion=2 * pull,
                strength=share * pull, carried=0, steps=12, measured=[(1.5, 0.5, 2)], name=f"{share}")
        assert (np.abs(f.measured_points.displacement).max() > 2e-4) == falls


@pytest.mark.parametrize("mode", MODES)
def test_a_broken_bond_stays_broken(mode, tmp_path):
    """Weight 25, strength 25: a jerk of 60 tears a block off its floor. Back at rest it does not resist a pull of 30, as it else does."""
    blocks = [box(-2, -1, 5, 1), box(0, 0, 1, 1)]
    pull = "0.5 0 0  0.500001 0 -12 2 0 -12"
    for jerk, holds in [("0 0 -24  0.02 0 -24  0.020001 0 0", False), ("0 0 0", True)]:
        f = run(tmp_path, blocks, f"{MODES[mode]}\n&contact restitution=0 /\n&acceleration table = {jerk} {pull} /", rock=SOFT,
                strength=2.5 * G, steps=120, dt=0.005, fixed=[(x, y, 1) for x, y in blocks[0]], measured=[(0.5, 0.5, 2)],
                name=f"{holds}")
        t, u = f.history.time, f.measured_points.displacement[:, 0, 1]
        assert np.abs(u[(t > 0.3) & (t < 0.49)]).max() < 1e-5  # it lies there
        if holds:
            assert np.abs(u).max() < 1e-5
        else:
            assert u[t < 0.3].max() > 1e-3
            assert u[-1] == pytest.approx((12 - G) * (t[-1] - 0.5) ** 2 / 2, rel=1e-2)


@pytest.mark.parametrize("mode", MODES)
def test_the_most_loaded_bond_breaks_and_spares_those_that_it_unloads(mode, tmp_path):
    """Three blocks of weight w hang under each other, the lowest pulled by 1.2 w: bonds bear 4.2, 3.2 and 2.2 w. Two of 2.5 w are not
    strong enough; the first breaks, and the others, which bear 0.4 and 0.8 w then, keep the blocks together."""
    w = 2.5 * G
    blocks = [box(-2, 0, 5, 1), box(0, -1, 1, 1), box(0, -2, 1, 1), box(0, -3, 1, 1)]
    f = run(tmp_path, blocks, f"{MODES[mode]}\n&loads force=0, {-1.2 * w} /", rock=(2.5, 2.5 * G, 1e9, 0.25), phi=30.0, strength=2.5 * w,
            steps=40, dt=0.005, fixed=[(x, y, 1) for x, y in blocks[0]], loads=[(0.5, -2.5, 4)],
            measured=[(0.5, y - 0.5, b) for b, y in [(2, 0), (3, -1), (4, -2)]])
    u = f.measured_points.displacement[:, :, 1]
    assert np.ptp(u, axis=1).max() < 1e-5
    np.testing.assert_allclose(u.mean(1), -1.4 * G * (f.history.time**2 / 2 + 0.005**2 / 16), rtol=1e-6)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("contact", ["", "&contact method='augmented' /"])
def test_bonds_hold_from_the_first_step_whatever_moves(mode, contact, tmp_path):
    """A block that begins to leave its base at 1, as far as its bonds give way; and a pair that flies together, pulled apart by less
    than its bonds hold."""
    strong = {"rock": (2.5, 2.5 * G, 1e9, 0.25), "phi": 30.0, "cohesion": 1e6, "strength": 1e6, "steps": 20}
    blocks = [box(-2, -1, 5, 1), box(0, 0, 1, 1)]
    f = run(tmp_path, blocks, f"{MODES[mode]}\n{contact}", material=[1, 2], velocity=((0, 0, 0), (0, 1, 0)),
            fixed=[(x, y, 1) for x, y in blocks[0]], measured=[(0.5, 0.5, 2)], **strong)
    assert np.abs(f.measured_points.displacement).max() < 1e-6
    f = run(tmp_path, [box(0, 0, 1, 1), box(1, 0.2, 1, 1)], f"{MODES[mode]}\n{contact}\n&loads force=-15, 0, 15, 0 /", velocity=((-1.4, -0.3, 0),),
            loads=[(0.5, 0.6, 1), (1.5, 0.6, 2)], measured=[(0.5, 0.6, 1), (1.5, 0.6, 2)], **strong)
    assert np.ptp(f.measured_points.displacement, axis=1).max() < 1e-6


def test_a_row_that_peels_off_takes_the_steps_asked_for(tmp_path):
    """110 blocks of weight 25, glued to each other, hang from a roof by bonds of 26, and the last is pulled by 60: the first step takes
    a round for each bond that breaks, more of them than multipliers may take."""
    n = 110
    roof = block_files.box(-1, n + 1, 0, 1)
    row = [(1, block_files.box(i, i + 1, -1, 0), (2, 2, 1, 2)) for i in range(n)]
    (tmp_path / "row.blk").write_text(block_files.block_file("Row", [(1, roof), *row], block_files.held(roof, 1), [(n - 0.5, -0.5, n + 1)],
                                                             [(n - 0.5, -0.5, n + 1)]))
    (tmp_path / "row.ana").write_text(f"1 5 1 2 0.05 0.005\n2.5 25 1e7 0.25 {'0 ' * 9}\n30 0 26\n30 1e9 1e9\n"
                                      "&deck geometry='row.blk', dialect='short' /\n&output every=1 /\n&loads force=0 -60 /\n")
    f = scree.run(tmp_path / "row.ana")
    assert len(f.history.time) == 5 and f.history.rejected.sum() == 0
    assert f.measured_points.displacement[-1, 0, 1] < -1e-3


def test_faint_forces_of_bonded_blocks_that_slide_do_not_keep_multipliers_from_settling(tmp_path):
    """Two blocks bonded to each other slide in flight along a wall, with forces of rounding: a step takes a few solutions, and is not cut."""
    blocks = [box(-1, -1, 1, 4), box(0, 0, 1, 1), box(0, 1, 1, 1)]
    f = run(tmp_path, blocks, "&method strain='green' /\n&contact method='augmented' /", rock=(2.5, 2.5 * G, 9e9, 0.25), phi=40.0,
            cohesion=1.0, strength=1.4, steps=20, fixed=[(x, y, 1) for x, y in blocks[0]], measured=[(0.5, 0.5, 2)])
    assert f.history.rejected.sum() == 0 and f.history.solves.mean() < 5
    assert f.measured_points.displacement[-1, 0, 1] == pytest.approx(-G * 0.1**2 / 2, rel=2e-2)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("contact", ["", "&contact method='augmented' /", "&contact restitution=0.5 /"])
def test_what_lies_apart_is_not_bonded(mode, contact, tmp_path):
    """A block 5 mm above its base comes with 1 m/s and is drawn up by 400 m/s2: it turns after 1.25 mm. Its first step of 10 ms would
    take it to the base, which bonded held it."""
    blocks = [box(-2, -1, 5, 1), box(0, 0.005, 1, 1)]
    rises = [run(tmp_path, blocks, f"{MODES[mode]}\n{contact}\n&loads force = 0 1000 /", rock=SOFT, material=[1, 2], velocity=[(0, 0, 0), (0, -1, 0)],
                 cohesion=bond, strength=bond, steps=10, dt=0.01, fixed=[(x, y, 1) for x, y in blocks[0]], loads=[(0.5, 0.5, 2)],
                 measured=[(0.5, 0.5, 2)], name=f"{bond}").measured_points.displacement[:, 0, 1] for bond in (0.0, 1e7)]
    assert rises[0][-1] > 1
    np.testing.assert_allclose(rises[1], rises[0], rtol=1e-9)


@pytest.mark.parametrize("decimals", [15, 12, 9, 6])
def test_bonds_hold_where_a_file_has_rounded_their_corners(decimals, tmp_path):
    """Three blocks under each other hang from a roof, all turned by some angle. Of 15 angles 1 to 7 fell where corners had 6 to 12 decimals."""
    for angle in np.arange(3, 90, 11):
        blocks = [np.round(corners @ turn(angle).T, decimals) for corners in [box(-2, 0, 5, 1), box(0, -1, 1, 1), box(0, -2, 1, 1), box(0, -3, 1, 1)]]
        f = run(tmp_path, blocks, rock=SOFT, cohesion=1e4, strength=1e4, steps=10, dt=0.01, fixed=[(x, y, 1) for x, y in blocks[0]])
        assert np.linalg.norm(f.bodies.centroid[-1] - f.bodies.centroid[0], axis=1).max() < 1e-4
        assert (f.history.contacts[:, 2] == 6).all()


@pytest.mark.parametrize("restitution", [0, 0.5, 1])
@pytest.mark.parametrize("velocity", [(0, -1, 0), (0, -0.3, 1.5), (0.5, 1, -1)])
def test_bonds_hold_though_their_blocks_are_pushed_together(velocity, restitution, tmp_path):
    """As without restitution: they bear it from the first step. They were struck and lost, and the block drawn away by 1000."""
    blocks = [box(-2, -1, 5, 1), box(0, 0, 1, 1)]
    ways = [run(tmp_path, blocks, f"{contact}\n&loads force = 0 1000 /", rock=SOFT, material=[1, 2], velocity=[(0, 0, 0), velocity], cohesion=1e7,
                strength=1e7, steps=40, dt=0.0005, fixed=[(x, y, 1) for x, y in blocks[0]], loads=[(0.5, 0.5, 2)], name=name).bodies.centroid[:, 1]
            for name, contact in [("with", f"&contact restitution={restitution} /"), ("without", "")]]
    assert np.abs(ways[0] - ways[0][0]).max() < 2e-3
    np.testing.assert_allclose(ways[0], ways[1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("mode", ["dda", "green"])
def test_bonds_that_begin_strained_make_no_energy_with_restitution(mode, tmp_path):
    """Two blocks side by side and one astride, each turning about itself, in flight above a floor: 232 J came of 2e-3 at 1e5 Pa."""
    blocks = [box(-4, -1, 10, 1), box(0, 0.3, 1, 1), box(1, 0.3, 1, 1), box(0.5, 1.3, 1, 1)]
    f = [run(tmp_path, blocks, f"{MODES[mode]}\n{contact}", rock=SOFT, material=[1, 2, 2, 2], velocity=[(0, 0, 0), (0, 0, 0.05)], phi=30.0, cohesion=1e5,
             strength=1e5, steps=8, dt=0.002, fixed=[(x, y, 1) for x, y in blocks[0]], name=name).bodies.velocity
         for name, contact in [("with", "&contact restitution=0.5 /"), ("without", "")]]
    np.testing.assert_allclose(f[0], f[1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("strain", ["small", "auto", "green"])
@pytest.mark.parametrize("size, velocity, phi", [((1.2, 0.8), -1.0, 45.0), ((1.9, 0.9), -1.9, 20.0), ((1.1, 1.0), 0.6, 40.0)])
def test_a_bond_that_slides_from_the_first_step_rubs_by_its_forces(size, velocity, phi, strain, tmp_path):
    """A bonded block that is thrown along its ground turns over its front corner in the first iterate, which pulls at the other
    one. Contact is all that brakes it: m dv/dt in each step. The corner was pulled in no later iterate, but had no friction, and
    half of the force was missing, as no state of a contact had changed."""
    E, dt = 3e8, 0.005
    f = run(tmp_path, [box(-3, -1, 9, 1), box(0.1, 0, *size)], f"&method strain='{strain}' /", rock=(2500.0, 24525.0, E, 0.25),
            material=[1, 2], velocity=((0, 0, 0), (velocity, 0, 0)), phi=phi, cohesion=1e4, steps=4, dt=dt,
            fixed=[(x, y, 1) for x, y in box(-3, -1, 9, 1)])
    ends = np.cumsum(f.contacts.count)
    for frame in range(1, len(ends)):
        own = slice(ends[frame - 1], ends[frame])
        normal, force = f.contacts.normal[own], f.contacts.force[own]
        side = np.where(f.contacts.blocks[own, 0] == 2, 1.0, -1.0)
        braking = np.sum(side * (force[:, 0] * normal[:, 0] - force[:, 1] * normal[:, 1]))
        change = 2500.0 * size[0] * size[1] * (f.bodies.velocity[frame, 1, 0] - f.bodies.velocity[frame - 1, 1, 0]) / dt
        assert change == pytest.approx(braking, rel=1e-4)
        assert abs(change) > 1e3


@pytest.mark.parametrize("beyond", [1e-5, 1e-4, 3e-4])
@pytest.mark.parametrize("share, slides", [(0.95, True), (1.05, False)])
def test_a_short_edge_elsewhere_adds_no_strength(beyond, share, slides, tmp_path):
    """A block of 1 m whose corner is a little beyond a vertex of its floor, and which has an edge of 20 mm at its other end. That
    made both corners look no farther, so that they had a contact each, of which each stood for both: it held 1.15 c l."""
    block = np.array([(0, 0), (0.5, 0), (1, 0), (1, 0.5), (0, 0.5), (0, 0.02)])
    floor = np.array([(-2, -1), (3, -1), (3, 0), (1 - beyond, 0), (-2, 0)])
    load = 1e4 / 1250 / share
    f = run(tmp_path, [floor, block], f"&acceleration table=0 {-load} 0  1e9 {-load} 0 /", rock=(2500.0, 25000.0, 1e9, 0.0), cohesion=1e4,
            strength=1e5, carried=0, steps=60, dt=0.01, fixed=[(*x, 1) for x in floor])
    assert (f.bodies.centroid[-1, 1, 0] - f.bodies.centroid[0, 1, 0] > 1e-3) == slides


@pytest.mark.parametrize("edge, angle", [(0.77, 11), (0.4, 0)])
def test_a_meshed_joint_gives_way_as_a_whole(edge, angle, tmp_path):
    """A flat block of 3 by 0.3, bonded to its base and pushed by its own mass. Between two elements each bond broke as soon as those of
    the two yielded: the joint fell at 0.61 to 0.67 of its cohesion, and its mirror image at 0.80."""
    cohesion, mass = 2e4, 2500 * 3 * 0.3
    for side in (1, -1):
        blocks = [(1, box(0, 0, 5, 1) * (side, 1)), (1, box(1, 1, 3, 0.3) * (side, 1))]
        blocks = [(material, corners[::side]) for material, corners in blocks]
        (tmp_path / "a.blk").write_text(block_files.block_file("bonded", blocks, []))
        for share, verdict in ((0.97, "complete"), (1.03, "moves")):
            push = side * share * cohesion * 3 / mass
            (tmp_path / "a.ana").write_text("\n".join([
                "0 200 1 1 0.05 0.01", f"2500 25000 1e9 0 {'0 ' * 9}", f"0 {cohesion} 1e7", "&deck geometry='a.blk', dialect='short' /",
                f"&support both=0 0 {5 * side} 0 /", f"&acceleration table=0 {push} 0  1 {push} 0 /",
                f"&cover edge={edge}, origin={0.13 * side} 0.21, angle={angle * side} /", "&method model='nmm' /", "&step balance=1e-6 /", ""]))
            done = scree.call("run", tmp_path / "a.ana", "-o", tmp_path / "a.h5", "--quiet")
            assert scree.read(tmp_path / "a.h5").summary["status"].split(":")[0] == verdict, (side, share, done.stderr)
