"""What slides over faces that are divided, or over a row of blocks, is held as on one face, by joints with a stiffness and by springs."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, box

WEIGHT, LENGTH, E = 50000.0, 2.0, 1e9  # of the slider, its lower side, both materials
SQUEEZED = 0.25 * WEIGHT / LENGTH / E   # its middle comes down by half its height times its mean strain, too


def divided(corners, side, edge):
    """A box whose bottom (0) or top (2) side has edges of a length, the last shorter."""
    a, b = corners[side], corners[(side + 1) % 4]
    n = int(np.ceil(np.linalg.norm(b - a) / edge - 1e-9))
    between = [a + (b - a) * i * edge / np.linalg.norm(b - a) for i in range(1, n)]
    return np.array([*corners[:side + 1], *between, *corners[side + 1:]])


def slide(folder, floor, groups, velocity=3.0, dt=4e-3, phi=0.0, slider=None, time=0.8, size=1.0, ramp=0.1, slider_first=False):
    """How far the slider is below where it began, over time since weight is there, shares of its lengths, and the results."""
    blocks = [*floor, box(0.55, 0.55 + LENGTH, 0, 1) if slider is None else slider]
    order = -1 if slider_first else 1
    held = [(*x, (k + 1) if order > 0 else len(blocks) - k) for k, b in enumerate(floor) for x in b]
    (folder / "a.blk").write_text(block_file("slide", [(1 + (k == len(floor)), b * size) for k, b in enumerate(blocks)][::order],
                                             [(x * size, y * size, k) for x, y, k in held]))
    scale = np.sqrt(size)
    (folder / "a.ana").write_text("\n".join([
        f"1 {round(time / dt)} 2 1 0.05 {dt * scale}", f"2500 0 {E * size} 0 {'0 ' * 9}",
        f"2500 25000 {E * size} 0 {'0 ' * 6} {velocity * scale} 0 0", f"{phi} 0 0", "&deck geometry='a.blk', dialect='short' /",
        f"&gravity ramp={ramp * scale} /" if ramp else "", *groups, ""]))
    r = scree.run(folder / "a.ana", output=folder / "a.h5")
    y = r.bodies.centroid[:, 0 if slider_first else -1, 1] / size
    return (y[0] - y)[y.size // 3:], r


def test_however_fast_and_tilted(tmp_path):
    """Vertices of one floor, which steps pass by a third of their distance: it came down to 1.4 and 1.8 times, as each took over the overlap
    of the one before, and rested where it was deeper."""
    for k, (velocity, dt, phi, height) in enumerate([(20.0, 4e-3, 0.0, 0.6), (10.0, 1e-3, 20.0, 0.5)]):
        (tmp_path / f"{k}").mkdir()
        slider = box(0.55, 0.55 + LENGTH, 0, height)
        sunk, _ = slide(tmp_path / f"{k}", [divided(box(0, 24, -0.5, 0), 2, 0.25)], ["&joints kn=1e8, ks=1e8 /"], velocity=velocity, dt=dt, phi=phi,
                        slider=slider, time=1.0)
        np.testing.assert_allclose(sunk[sunk.size // 3:], (WEIGHT / (1e8 * LENGTH) + height * SQUEEZED) * height, rtol=0.05)


@pytest.mark.parametrize("bends", [10, 20])
def test_over_a_floor_that_bends_up(bends, tmp_path):
    """By a degree every 0.1 m: it lies on its corners, at more than 3 degrees too. Their contacts stood for what a flat one stands for
    there, less and less, and it sank by up to 96 mm; with what they closed with by 14."""
    at, x = np.zeros(2), [np.array([-1.0, 0.0]), np.array([1.6, 0.0])]
    for k in range(1, bends + 1):
        at = x[-1]
        x.append(at + 0.1 * np.array([np.cos(np.radians(k)), np.sin(np.radians(k))]))
    x.append(x[-1] + 3 * np.array([np.cos(np.radians(bends)), np.sin(np.radians(bends))]))
    floor = np.array([[-1.0, -1.0], [x[-1][0], -1.0], *x[::-1]])
    _, r = slide(tmp_path, [floor], ["&joints kn=1e8, ks=1e8 /"], dt=2e-3, slider=box(0, 1, 0, 0.4), time=0.9)
    assert r.history.overlap.max() < 4e-3
    assert abs(r.history.energy.dissipated[-1]) < 0.01 * 0.5 * 1000 * 3**2


def row(edge):
    return [box(edge * i, edge * (i + 1), -0.5, 0) for i in range(round(6 / edge))]


@pytest.mark.parametrize("rules", ["&method strain='small' /", "&method strain='green' /", "&method model='nmm' /",
                                   "&contact method='augmented' /", "&contact restitution=0 /", "&contact restitution=1 /",
                                   "&integrator scheme='newmark', beta=1 /"])
@pytest.mark.parametrize("edge", [0.25, 0.5, 1.0, 2.0])
def test_over_a_row_of_blocks(edge, rules, tmp_path):
    """Each block that it comes onto had a spring without force, and those that it left took theirs with them: it sank by up to 11 times
    W/(kn L), the more the farther it went. What a slider
    comes onto stands for 1/20 of an edge at first."""
    sunk, r = slide(tmp_path, row(edge), ["&joints kn=1e8, ks=1e8 /", rules])
    np.testing.assert_allclose(sunk, WEIGHT / (1e8 * LENGTH) + SQUEEZED, rtol=0.025 + 0.05 * edge)
    assert r.bodies.velocity[-1, -1, 0] == pytest.approx(3, abs=2e-4)


@pytest.mark.parametrize("kn", [1e7, 1e9, 1e10])
@pytest.mark.parametrize("velocity, dt", [(3.0, 1e-3), (1.0, 4e-3), (0.1, 4e-3), (5.0, 2e-3)])
def test_whatever_the_stiffness_and_speed(velocity, dt, kn, tmp_path):
    sunk, _ = slide(tmp_path, row(0.5), [f"&joints kn={kn}, ks={kn} /"], velocity=velocity, dt=dt, time=0.68)
    np.testing.assert_allclose(sunk, WEIGHT / (kn * LENGTH) + SQUEEZED, rtol=0.06)


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_of_any_size(size, tmp_path):
    sunk, _ = slide(tmp_path, row(0.5), ["&joints kn=1e8, ks=1e8 /"], size=size)
    np.testing.assert_allclose(sunk, WEIGHT / (1e8 * LENGTH) + SQUEEZED, rtol=0.025 + 0.05 * 0.5)


@pytest.mark.parametrize("edge", [0.25, 0.5, 1.0])
def test_friction_stops_it_where_it_should(edge, tmp_path):
    """After v^2/(2 g tan phi), upright: it tilts forward, as much as on one block."""
    floor = [box(0, 6, -0.5, 0)]
    ends = []
    for k, blocks in enumerate((floor, row(edge))):
        (tmp_path / f"{k}").mkdir()
        sunk, r = slide(tmp_path / f"{k}", blocks, ["&joints kn=1e8, ks=1e8 /"], velocity=3.5, phi=20.0, time=1.1)
        ends.append(r.bodies.centroid[-1, -1, 0])
        np.testing.assert_allclose(sunk, WEIGHT / (1e8 * LENGTH) + SQUEEZED, rtol=0.025 + 0.05 * edge)
        assert abs(r.bodies.velocity[-1, -1, 0]) < 5e-3 # it swings on its springs
    assert ends[1] == pytest.approx(ends[0], abs=3e-3)
    braking, ramp = 10 * np.tan(np.radians(20)), 0.1  # which comes with its weight
    assert ends[0] - 1.55 == pytest.approx(3.5**2 / (2 * braking) + 3.5 * ramp / 2 - braking * ramp**2 / 24, rel=1e-3)


@pytest.mark.parametrize("groups, sinks", [(["&joints kn=1e7, ks=1e7 /"], WEIGHT / (1e7 * LENGTH)), (["&contact stiffness=1e7 /"], 0)])
@pytest.mark.parametrize("edge, own", [(0.25, 9), (0.37, 9), (0.25, 0.25)])
def test_over_faces_of_many_edges(edge, own, groups, sinks, tmp_path):
    """Vertices that change nothing, at 5 m/s: contacts stayed with edges that they had left, from 10 to 27, and from 25 to 124, and where
    joints have a stiffness it sank by 17 mm for 2.5. Springs without count, so they give less where more vertices are, but no more
    with time."""
    slider = divided(box(0.55, 0.55 + LENGTH, 0, 1), 0, own)
    sunk, r = slide(tmp_path, [divided(box(0, 8, -0.5, 0), 2, edge)], groups, velocity=5.0, slider=slider)
    vertices = 2 + len(slider) - 4 + int(np.ceil(LENGTH / edge))
    assert r.history.contacts[-50:, 1:].sum(axis=1).max() <= vertices
    if sinks:
        np.testing.assert_allclose(sunk, sinks + SQUEEZED, rtol=0.06)
    else:
        half = sunk.size // 2
        assert sunk[half:].max() <= 1.2 * sunk[:half].max()


@pytest.mark.parametrize("velocity", [2.0, 5.0])
@pytest.mark.parametrize("strain", ["small", "green"])
def test_meshes_over_meshes(strain, velocity, tmp_path):
    """Nodes rested behind edges long left behind: of 35 contacts 364 were closed after 11 m, and it sank 1.8 times as far as it should."""
    groups = ["&joints kn=1e7, ks=1e7 /", f"&method model='nmm', strain='{strain}' /", "&cover edge=0.25 /", "&support both=0 -0.5 8 -0.5 /"]
    sunk, r = slide(tmp_path, [box(0, 8, -0.5, 0)], groups, velocity=velocity, time=1.0)
    assert r.history.contacts[-1, 1:].sum() <= 17
    assert sunk.mean() == pytest.approx(WEIGHT / (1e7 * LENGTH) + SQUEEZED, rel=0.06)
    assert sunk.max() < 1.4 * WEIGHT / (1e7 * LENGTH)


@pytest.mark.parametrize("kn, velocity, slider_first", [(1e7, 3.0, False), (1e8, 3.0, False), (1e7, 3.0, True), (1e7, 3.7, True)])
def test_what_conserves_energy_swings_on(kn, velocity, slider_first, tmp_path):
    """Weight put on at once: between 0 and twice what it settles by, over a row as over one block. A slider that was the first block of its
    file jumped off the row, by 1.4 times what it settles by, as its corners went on over edges of the row instead of the row's under its own."""
    groups = [f"&joints kn={kn}, ks={kn} /", "&contact rules='conserving' /"]
    sunk, _ = slide(tmp_path, row(0.5), groups, velocity=velocity, time=1.0, ramp=0, slider_first=slider_first)
    mean = WEIGHT / (kn * LENGTH)
    assert sunk.max() < 2.1 * mean and sunk.min() > -0.05 * mean
    assert sunk.mean() == pytest.approx(mean, rel=0.1)


@pytest.mark.parametrize("phi, groups", [(0, ""), (30, ""), (30, "&cover edge=0.4 /\n&method model='nmm' /\n")])
@pytest.mark.parametrize("parts", [(0.1, 1), (0.25, 4), (0.1, 10)])
def test_in_static_steps(parts, phi, groups, tmp_path):
    """A table moves the base under a block that a line holds. Static steps begin without velocities, by which the joint was taken not to slide: what
    left a face kept its spring and what came had none, and the block sank to 1.3 to 2 times its pressure over kn. What a vertex came to
    held it without shear, half of which was lost as the nodes of two meshes met."""
    pressure, kn, ks, steps, way = 1e5, 1e9, 1e7, 600, 0.3
    base, block = divided(box(-2, 3, -1, 0) + [-0.03, 0], 2, parts[0]), divided(box(0, 1, 0, 0.4), 0, 1 / parts[1])
    fixed = [(-1.9, -0.9, 1), (2.8, -0.9, 1), (2.8, -0.1, 1), (-1.9, -0.1, 1)]
    (tmp_path / "a.blk").write_text(block_file("static", [(1, base), (1, block)], fixed))
    moves = f"0 0 0\n10 0 0\n{10 * (steps + 1)} {way} 0\n"
    (tmp_path / "a.ana").write_text(
        f"0 {steps + 1} 1 1 0.05 10\n0\n{'3 ' * 4}\n{moves * 4}2500 0 1e13 0.2\n{'0 ' * 6}\n0 0 0\n{phi} 0 0\n"
        f"&deck geometry='a.blk', dialect='shi' /\n&joints kn={kn}, ks={ks} /\n&output every=1 /\n{groups}"
        f"&boundary lines=0 0.4 1 0.4, pressure={pressure} {pressure} /\n&support normal=0 0 0 0.4 /\n")
    r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
    assert r.bodies.centroid[-1, 0, 0] - r.bodies.centroid[0, 0, 0] == pytest.approx(way, rel=1e-3)
    np.testing.assert_allclose(r.history.overlap[5:], pressure / kn, rtol=0.03)
    slides = 5 + int(np.tan(np.radians(phi)) * pressure / ks / way * steps)
    first = np.append(0, np.cumsum(r.contacts.count))
    pressing, shear = np.array([r.contacts.force[a:b].sum(axis=0) for a, b in zip(first[slides:-1], first[slides + 1:])]).T
    np.testing.assert_allclose(np.abs(shear), pressing * np.tan(np.radians(phi)), rtol=1e-6)
