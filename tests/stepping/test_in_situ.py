"""Initial stress from the weight below a ground surface and K0 (&in_situ)."""
import numpy as np
import pytest
import scree

WEIGHT, K0, DEEP = 26e3, 0.6, 40.0
SIDES = "&support normal=0 0 0 8  10 0 10 8, y=0 0 10 0 /\n"


def decks(folder, groups, weights=(WEIGHT,), lines=(), materials="", steps=20, k01=0, stress="0 0 0\n0 0 0"):
    """Ground of 10 m by 8 m, cut by lines; material lines give it layers."""
    sides = [(0, 0, 10, 0), (10, 0, 10, 8), (10, 8, 0, 8), (0, 8, 0, 0), *lines]
    n = materials.count("\n")
    (folder / "g.geo").write_text(f"1e-3 {len(sides)} 4 {n} 0 0 0 1 0\n" + "".join("{} {} {} {} 1\n".format(*line) for line in sides)
                                  + materials + "5 7\n")
    (folder / "g.ana").write_text(f"{k01} {steps} {len(weights)} 1 0.05 0.01\n"
                                  + "".join(f"2600 {weight} 1e10 0.25\n{stress}\n0 0 0\n" for weight in weights)
                                  + f"35 0 0\n&deck geometry='g.geo' /\n&method plane='strain' /\n{groups}")
    return folder / "g.ana"


def run(folder, groups, **more):
    return scree.run(decks(folder, groups, **more), output=folder / "g.h5")


def height_of(polygon):
    """Height of the centroid of a polygon."""
    (x, y), (a, b) = (polygon - polygon[0]).T, (np.roll(polygon, -1, axis=0) - polygon[0]).T
    twice = x * b - a * y
    return polygon[0, 1] + ((y + b) * twice).sum() / (3 * twice.sum())


def middles(result):
    return np.array([height_of(polygon) for polygon in result.polygons(0)])


@pytest.mark.parametrize("k01", [0, 1])
@pytest.mark.parametrize("mesh", ["", "edge=1.7", "edge=2.3, origin=0.3 0.4"])
def test_level_ground_stays_at_rest(mesh, k01, tmp_path):
    """The stress is the weight above and K0 times that to 1e-9, and after 20 steps nothing has moved."""
    deck = decks(tmp_path, SIDES + f"&in_situ surface=0 8, k0={K0} /\n" + (f"&cover {mesh} /\n" if mesh else ""), k01=k01)
    deck.write_text(deck.read_text().replace("plane=", "model='nmm', plane=" if mesh else "plane="))
    result = scree.run(deck, output=tmp_path / "g.h5")
    for frame in 0, -1:
        stress, depth = result.stress(frame), 8 - middles(result)
        scale = WEIGHT * 8
        np.testing.assert_allclose(stress[:, 1], -WEIGHT * depth, atol=1e-9 * scale)
        np.testing.assert_allclose(stress[:, 0], -K0 * WEIGHT * depth, atol=1e-9 * scale)
        np.testing.assert_allclose(stress[:, 2], 0, atol=1e-9 * scale)
    assert np.abs(result.measured_points.displacement).max() < 1e-12


def test_the_stress_is_that_of_the_numbers_of_a_material(tmp_path):
    """The same bits as s11 s22 t11 t22 by hand, for a level surface above the model."""
    groups = SIDES + "&step balance=1e-6 /\n&boundary lines=0 8 10 8, pressure={p} {p} /\n".format(p=WEIGHT * (DEEP - 8))
    a = run(tmp_path, groups + f"&in_situ surface=-5 {DEEP}  20 {DEEP}, k0=0.5 /\n").bodies.stress[-1].copy()
    by_hand = f"{-0.5 * WEIGHT * DEEP} {-WEIGHT * DEEP} 0\n{0.5 * WEIGHT} {WEIGHT} 0"
    b = run(tmp_path, groups, stress=by_hand).bodies.stress[-1].copy()
    np.testing.assert_allclose(a, b, rtol=1e-13, atol=1e-6)


def test_layers_weigh_on_those_below(tmp_path):
    """Two layers: the stress of the lower one has the weight of the upper one, whose weight the ground above the model has too."""
    groups = f"&in_situ surface=0 {DEEP}, k0=1 0.5 /\n" + SIDES
    result = run(tmp_path, groups, weights=(20e3, 27e3), lines=[(0, 3, 10, 3)], materials="5 1 5 1 2\n", steps=1)
    above = 20e3 * (DEEP - 3)
    lower, upper = np.argsort(middles(result))
    assert result.bodies.stress[0, upper] == pytest.approx([-20e3 * (DEEP - 5.5)] * 2 + [0])
    assert result.bodies.stress[0, lower] == pytest.approx([-0.5 * (above + 27e3 * 1.5), -(above + 27e3 * 1.5), 0])


def test_a_gradient_and_a_pressure_are_taken_as_they_are(tmp_path):
    result = run(tmp_path, SIDES + "&in_situ surface=0 10, k0=2, gradient=1e3, pressure=5e4 /\n", steps=1)
    assert result.bodies.stress[0, 0] == pytest.approx([-2 * 5.6e4, -5.6e4, 0])


def test_a_slope_has_the_depth_below_its_surface(tmp_path):
    result = run(tmp_path, SIDES + "&in_situ surface=2 8  8 20, k0=0.5 /\n", steps=1, lines=[(5, 0, 5, 8)])
    left, right = np.argsort([polygon.mean(axis=0)[0] for polygon in result.polygons(0)])
    assert result.bodies.stress[0, left, 1] == pytest.approx(-WEIGHT * (8 + 0.5 / 6 * 12 - 4))
    assert result.bodies.stress[0, right, 1] == pytest.approx(-WEIGHT * (8 + 5.5 / 6 * 12 - 4))


def test_check_says_the_stress(tmp_path):
    done = scree.call("check", decks(tmp_path, SIDES + "&in_situ surface=0 8, k0=0.5 /\n"), cwd=tmp_path)
    assert "effect: initial stress - &in_situ; vertical from -104000 to -104000, horizontal from -52000 to -52000" in done.stdout, done.stdout


@pytest.mark.parametrize("groups, more, expected", [
    ("&in_situ k0=1 /\n", {}, "only with in_situ.surface"), ("&in_situ surface=0 8 /\n", {}, "only with in_situ.k0"),
    ("&in_situ surface=0 8 1, k0=1 /\n", {}, "two numbers x y for each point of in_situ.surface, found 3"),
    ("&in_situ surface=0 8 0 9, k0=1 /\n", {}, "points of in_situ.surface with x ascending"),
    ("&in_situ surface=0 8, k0=1 1 /\n", {}, "in_situ.k0 with 1 numbers, one for each block material, found 2"),
    ("&in_situ surface=0 8, k0=-1 /\n", {}, "in_situ.k0 at least 0"),
    ("&in_situ surface=0 8, k0=1 /\n", {"stress": "0 -1 0\n0 0 0"}, "no initial stress of block materials with in_situ.k0, found one of block material 1"),
    ("&stage /\n&in_situ surface=0 8, k0=1 /\n", {}, "expected in_situ.surface before the first &stage")])
def test_bad_words_are_refused_with_their_line(groups, more, expected, tmp_path):
    done = scree.call("check", decks(tmp_path, groups, **more), cwd=tmp_path)
    assert done.returncode == 2 and expected in done.stderr and done.stderr.count("\n") == 1, done.stderr
    assert done.stderr.startswith(f"scree: {tmp_path}/g.ana:"), done.stderr


def joint_lines(dip, spacing, middle=(5.0, 4.0), long=30.0):
    """Straight joints of a dip (degrees) at a spacing across the ground."""
    along = np.array([np.cos(np.radians(dip)), np.sin(np.radians(dip))])
    across = np.array([-along[1], along[0]])
    for k in range(-12, 13):
        at = np.array(middle) + (k + 0.37) * spacing * across
        yield (*(at - long * along), *(at + long * along))


JOINTED = {"dip 0": [*joint_lines(0, 1.7)], "dip 90": [*joint_lines(90, 1.9)], "dip 37": [*joint_lines(37, 2.3)],
           "two sets": [*joint_lines(62, 3.1), *joint_lines(-24, 2.7)]}


def jointed(folder, groups, name, joint="35 0 0"):
    """The ground with joints (friction angle, cohesion, tensile strength), whose ends the sides of the model cut off."""
    deck = decks(folder, groups, lines=JOINTED[name])
    text = (folder / "g.geo").read_text().splitlines()
    count = int(text[0].split()[1])
    inside = [line for line in (cut(*map(float, line.split()[:4])) for line in text[5:1 + count]) if line]
    (folder / "g.geo").write_text(f"1e-3 {4 + len(inside)} 4 0 0 0 0 1 0\n" + "\n".join(text[1:5]) + "\n"
                                  + "".join("{:.15g} {:.15g} {:.15g} {:.15g} 1\n".format(*line) for line in inside) + "5 7\n")
    deck.write_text(deck.read_text().replace("\n35 0 0\n", f"\n{joint}\n"))
    return deck


def cut(x1, y1, x2, y2):
    """The part of a line in the ground of 10 m by 8 m, a little longer; None where it passes by."""
    a, way, from_, to = np.array([x1, y1]), np.array([x2 - x1, y2 - y1]), 0.0, 1.0
    for k, high in enumerate((10.0, 8.0)):
        if abs(way[k]) < 1e-12:
            if not 0 < a[k] < high:
                return None
            continue
        ends = sorted(((0 - a[k]) / way[k], (high - a[k]) / way[k]))
        from_, to = max(from_, ends[0]), min(to, ends[1])
    beyond = 0.01 / np.hypot(*way)
    return (*(a + (from_ - beyond) * way), *(a + (to + beyond) * way)) if from_ < to else None


@pytest.mark.parametrize("name", JOINTED)
@pytest.mark.parametrize("mesh, method, k01", [("", "", 0), ("", "", 1), ("edge=1.9", "", 0),
                                               ("", "&contact method='augmented', overlap=1e-9 /\n", 0), ("", "&contact rules='conserving' /\n", 1),
                                               ("", "&joints kn=1e9, ks=4e8 /\n", 0), ("edge=2.6", "&joints kn=1e9, ks=4e8, closure=1e-3 /\n", 0)])
def test_jointed_level_ground_stays_at_rest(name, mesh, method, k01, tmp_path):
    """Joints begin with the tractions of the stress: it stays to 1e-9, nothing moves, and no energy comes or goes."""
    groups = SIDES + f"&in_situ surface=0 8, k0={K0} /\n" + method + (f"&cover {mesh} /\n" if mesh else "")
    deck = jointed(tmp_path, groups, name)
    text = deck.read_text().replace("0 20 1 1", f"{k01} 5 1 1", 1)
    deck.write_text(text.replace("plane=", "model='nmm', plane=" if mesh else "plane="))
    result = scree.run(deck, output=tmp_path / "g.h5")
    scale = WEIGHT * 8
    for frame in 0, -1:
        stress, depth = result.stress(frame), 8 - middles(result)
        np.testing.assert_allclose(stress, np.outer(depth, [-K0 * WEIGHT, -WEIGHT, 0]), atol=1e-9 * scale)
    assert np.abs(result.measured_points.displacement).max() < 1e-11
    springs = result.history.energy.contact
    np.testing.assert_allclose(springs, springs[0], rtol=1e-9, atol=1e-9)
    assert np.abs(result.history.energy.friction).max() <= 1e-12 * scale


@pytest.mark.parametrize("mesh, joints", [("", ""), ("edge=2.6", ""), ("", "&joints kn=1e9, ks=4e8, closure=1e-3 /\n"), ("", "&contact method='augmented', overlap=1e-9 /\n")])
def test_a_joint_that_cannot_bear_the_shear_slips_and_is_told(mesh, joints, tmp_path):
    """K0 = 0.3 at dip 60: tau/sigma is 0.7 sin 60 cos 60/(0.3 sin^2 60 + cos^2 60). At the start each contact has tan(phi) times its force."""
    k0, dip, phi = 0.3, np.radians(60), 20
    groups = SIDES + f"&in_situ surface=0 8, k0={k0} /\n" + joints + (f"&cover {mesh} /\n" if mesh else "")
    JOINTED["steep"] = [*joint_lines(60, 2.9)]
    deck = jointed(tmp_path, groups, "steep", f"{phi} 0 0")
    deck.write_text(deck.read_text().replace("plane=", "model='nmm', plane=" if mesh else "plane="))
    borne = np.tan(np.radians(phi)) * (k0 * np.sin(dip)**2 + np.cos(dip)**2) / ((1 - k0) * np.sin(dip) * np.cos(dip))
    told = [line for line in scree.call("check", deck, cwd=tmp_path).stdout.splitlines() if "shear of the stress before the run" in line]
    assert len(told) == 1 and told[0].endswith(f" % of it"), told
    assert float(told[0].split()[-4]) == pytest.approx(100 * borne, rel=1e-3)
    result = scree.run(deck, output=tmp_path / "g.h5")
    across, along = result.contacts_of(0).force.T
    held = across > 1e-9 * across.max()
    np.testing.assert_allclose(np.abs(along[held]), np.tan(np.radians(phi)) * across[held], rtol=1e-9)
    assert result.history.energy.friction[-1] > 0 and np.abs(result.measured_points.displacement).max() > 1e-6


def test_cohesion_bears_the_shear(tmp_path):
    """The same with a cohesion above the largest shear stress, 0.7/2 of the vertical stress: nothing moves, and nothing is told."""
    deck = jointed(tmp_path, SIDES + "&in_situ surface=0 8, k0=0.3 /\n", "dip 37", f"0 {0.36 * WEIGHT * 8} 1e9")
    assert "shear of the stress" not in scree.call("check", deck, cwd=tmp_path).stdout
    result = scree.run(deck, output=tmp_path / "g.h5")
    assert np.abs(result.measured_points.displacement).max() < 1e-11 and not result.history.bonds[:, 1:].any()


def test_bonded_polygons_stay_at_rest(tmp_path):
    """An outline with corners, as of rock that a stage excavates: corners that bonds hold have a contact in common."""
    ring = [(5 + 2 * np.cos(a), 4 + 2 * np.sin(a)) for a in 0.3 + np.pi / 6 * (np.arange(13) % 12)] + [(10.01, 5)]
    deck = decks(tmp_path, SIDES + f"&in_situ surface=0 8, k0={K0} /\n", lines=[(*p, *q) for p, q in zip(ring, ring[1:])], k01=0, steps=3)
    deck.write_text(deck.read_text().replace("\n35 0 0\n", "\n45 1e9 1e9\n"))
    result = scree.run(deck, output=tmp_path / "g.h5")
    assert result.n_blocks == 2
    np.testing.assert_allclose(result.bodies.stress[-1], result.bodies.stress[0], atol=1e-9 * WEIGHT * 8)
    assert np.abs(result.measured_points.displacement).max() < 1e-11


def test_shi_rules_begin_without_force(tmp_path):
    """By the rules of Shi's programs the joints close under the weight."""
    deck = jointed(tmp_path, SIDES + f"&in_situ surface=0 8, k0={K0} /\n", "dip 0")
    deck.write_text(deck.read_text().replace("plane=", "preset='shi', plane="))
    result = scree.run(deck, output=tmp_path / "g.h5")
    assert result.contacts_of(0).force.size == 0 and np.abs(result.measured_points.displacement).max() > 1e-6
