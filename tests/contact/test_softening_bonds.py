"""Bonds that soften, through the program, against the linear softening law (Hillerborg, Modeer & Petersson 1976) and closed forms."""
import math
import numpy as np
import pytest
import scree
from scree.block_files import block_file
from scree.program import done_or_failed
from test_blocks_touch import MODES, box

T, G = 1e5, 100.0  # tensile strength and fracture energy
OPENING = 2 * G / T  # at which nothing of the strength is left


def joined(folder, way, groups, *, along=(0, 1), steps=12, static=True, cohesion=4e5, phi=30.0, young=1e9, name="pair", run=True):
    """A block of 1 x 1 bonded on a fixed one, led by its four corners to the places of `way` in turn, in so many steps each.
    Places are ways along a direction, or points."""
    upper, lower = box(0, 0, 1, 1), box(0, -1, 1, 1)
    fixed = [(*p, 1) for p in upper] + [(*p, 2) for p in lower]
    (folder / f"{name}.blk").write_text(block_file("pair", [(1, upper, [2, 1, 1, 1]), (1, lower, [1, 1, 2, 1])], fixed))
    dt = 1.0 if static else 0.01
    places = way if along is None else [(u * along[0], u * along[1]) for u in way]
    table = " ".join(f"{i * steps * dt} {x} {y}" for i, (x, y) in enumerate(places))
    (folder / f"{name}.ana").write_text("\n".join([
        f"{0 if static else 1} {steps * (len(way) - 1)} 1 2 0.05 {dt} 0", " ".join([str(len(way))] * 4 + ["0"] * 4), *[table] * 4,
        f"2500 0 {young} 0 0 0 0 0 0 0 0 0 0", "0 0 0", f"{phi} {cohesion} {T}",
        f"&deck geometry='{name}.blk', dialect='shi' /", groups, "&output every=1 /", ""]))
    return scree.run(folder / f"{name}.ana", timeout=300) if run else folder / f"{name}.ana"


def pull_of(results, frame):
    return -np.asarray(results.contacts_of(frame).force).reshape(-1, 2)[:, 0].sum()


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("static", [True, False])
def test_a_bond_is_pulled_let_back_and_pulled_again(mode, static, tmp_path):
    """The pull is on the envelope, or on the line to the origin. At the end the bond has lost G to 1e-9."""
    r = joined(tmp_path, [0, 0.5 * OPENING, 0, 0.8 * OPENING, 0.2 * OPENING, 1.2 * OPENING], f"{MODES[mode]}\n&joints energy=0 {G} /",
               static=static, young=1e12)  # the blocks hardly give: the gap is what the corners are led to
    first = T / (5 * 1e12)  # gap of the spring of contact at the strength
    farthest = 0.0
    for k in range(1, 61):
        way = [0, 0.5, 0, 0.8, 0.2, 1.2]
        gap = np.interp(k, 12 * np.arange(6), way) * OPENING
        farthest = max(farthest, gap)
        envelope = T * max(0.0, (OPENING - farthest) / (OPENING - first))
        assert pull_of(r, k) == pytest.approx(envelope * gap / max(farthest, 1e-30), abs=2e-3 * T)
    lost = r.history.energy.fracture
    assert (np.diff(lost) >= 0).all()
    assert lost[-1] == pytest.approx(G, rel=1e-9)


@pytest.mark.parametrize("mode", ["dda", "nmm green"])
def test_shear_takes_its_energy_and_friction_its_own(mode, tmp_path):
    """Slip forth and back to beyond sc: G_II is lost in the bond, and no friction without a pressing force."""
    c = 1e5
    r = joined(tmp_path, [0, 1e-3, 0, 3e-3], f"{MODES[mode]}\n&joints energy=0 {G}, shear_energy=0 {G} /", along=(1, 0), cohesion=c,
               young=1e12)
    assert r.history.energy.fracture[-1] == pytest.approx(G, rel=1e-3)  # the slip of each turn begins with the springs
    assert abs(r.history.energy.friction[-1]) < 1e-6 * G
    shear = np.abs(np.asarray(r.contacts_of(6).force)[:, 1]).sum()
    assert shear == pytest.approx(c * (1 - 0.5e-3 / (2 * G / c)), rel=1e-2)


@pytest.mark.parametrize("mode", ["dda", "green"])
def test_a_pressed_bond_bears_cohesion_and_friction_beside_each_other(mode, tmp_path):
    """Pressed first, then sheared beyond sc: the shear is c (1 - s/sc) + N tan phi. The bond loses G_II, and friction takes the rest."""
    c, phi, young, slip, steps = 1e5, 30.0, 1e10, 3e-3, 60
    r = joined(tmp_path, [(0, 0), (0, -4e-6), (slip, -4e-6)], f"{MODES[mode]}\n&joints energy=0 {G}, shear_energy=0 {G} /", along=None,
               cohesion=c, phi=phi, young=young, steps=steps)
    rubbed = 0.0
    for k in range(steps + 2, 2 * steps + 1):
        n, shear = np.abs(np.asarray(r.contacts_of(k).force)).sum(0)
        rubbed += n * math.tan(math.radians(phi)) * slip / steps
        assert n == pytest.approx(4e5, rel=1e-6)
        bonded = c * max(0.0, 1 - slip * (k - steps) / steps / (2 * G / c))
        assert shear == pytest.approx(bonded + n * math.tan(math.radians(phi)), abs=2e-2 * c)
    assert r.history.energy.fracture[-1] == pytest.approx(G, rel=1e-3)
    assert r.history.energy.friction[-1] == pytest.approx(rubbed, rel=2e-2)


@pytest.mark.parametrize("mode", MODES)
def test_a_bond_that_shears_off_under_a_pull_leaves_no_energy_behind(mode, tmp_path):
    """The bond softens in tension and breaks at once in shear: then its spring stores nothing, and the blocks are in balance."""
    r = joined(tmp_path, [0, 0.8 * OPENING], f"{MODES[mode]}\n&joints energy=0 {G} /", along=(0.3, 1), cohesion=1.2 * T, young=1e12)
    assert r.history.contacts[-1, 1:].sum() == 0  # it sheared off
    assert np.max(r.history.energy.contact) < G
    assert r.history.energy.contact[-1] == 0
    assert np.max(r.history.unbalanced) < 1e-6


def strip(folder, length, shares, steps, *, rows=8, whole=0.6, sheared=False):
    """Runs a strip 0.2 high with a crack of a length along its bonded middle, whose grips move it apart, or along the crack, by shares of the
    way of Griffith at 0, 1 and `steps` seconds. Returns the results and the place of the tip."""
    height, young, strength = 0.1, 1e10, 1e6
    edge = height / rows / math.cos(math.pi / 6)
    energy = 4 * edge * strength**2 / young
    reach = math.sqrt(energy * height / (young / 2 if sheared else young))
    a = round(length / edge) * edge
    upper = np.array([(0, 0), (a, 0), (whole, 0), (whole, height), (0, height)])
    lower = np.array([(0, -height), (whole, -height), (whole, 0), (a, 0), (0, 0)])
    xs = sorted(set(np.round(np.concatenate([np.arange(0, whole + 1e-9, edge / 2), [whole]]), 12)))
    fixed = [(x, height, 1) for x in xs] + [(x, -height, 2) for x in xs]
    (folder / "strip.blk").write_text(block_file("strip", [(1, upper, [1, 2, 1, 1, 1]), (1, lower, [1, 1, 2, 1, 1])], fixed))
    rows_of = [[(t, s * w, 0) if sheared else (t, 0, s * w) for t, w in zip((0, 1, steps), reach * np.array(shares))] for s in (1, -1)]
    tables = [" ".join(f"{t} {x} {y}" for t, x, y in rows_of[k]) for k in (0, 1) for _ in xs]
    bond = f"0 {strength} {100 * strength}" if sheared else f"45 {10 * strength} {strength}"
    (folder / "strip.ana").write_text("\n".join([
        f"0 {steps} 1 2 0.05 1 0", " ".join(["3"] * len(fixed)), *tables, f"2500 0 {young} 0 0 0 0 0 0 0 0 0 0", "0 0 0",
        bond, "&deck geometry='strip.blk', dialect='shi' /", "&method model='nmm', strain='small' /",
        f"&cover edge={edge}, origin=0 0 /", f"&joints {'shear_energy' if sheared else 'energy'}=0 {energy} /", "&output every=1 /", ""]))
    return scree.run(folder / "strip.ana", timeout=600), a


@pytest.mark.parametrize("length", [0.25, 0.35])
def test_a_strip_runs_at_the_opening_of_griffith_whatever_its_crack(length, tmp_path):
    """Grips at -+H move apart by 2u: the crack runs at u = (G H/E)^(1/2), to 2 % with 8 rows, and stays 3 % below it."""
    shares = (0, 0.9, 1.03)
    r, a = strip(tmp_path, length, shares, 12)
    runs = None
    for k in range(1, r.n_frames):
        c = r.contacts_of(k)
        x, pulled = np.asarray(c.place)[:, 0], np.asarray(c.force)[:, 0] < -1.0
        tip = x[pulled].min() if pulled.any() else 0.6
        u = np.interp(r.times[k], [0, 1, 12], shares)
        if runs is None and tip > a + 0.15:
            runs = u
        if u < 0.97:
            assert tip < a + 0.1
    assert runs is not None and runs == pytest.approx(1, abs=0.02)


def test_a_sheared_strip_comes_near_the_slip_of_griffith_in_whole_steps(tmp_path):
    """The rounds in which the damage settles do not cut a step while the crack stands, 0.5 % below Griffith's slip."""
    r, _ = strip(tmp_path, 0.2, (0, 0.9, 0.995), 6, rows=6, whole=0.5, sheared=True)
    assert len(r.history.time) == 6 and np.sum(r.history.rejected) == 0
    edge = 0.1 / 6 / math.cos(math.pi / 6)
    lost = np.asarray(r.history.energy.fracture) / (4 * edge * 100.0 * edge)  # of the bonds of an edge
    assert 0 < lost[0] < lost[-1] < 2


def test_a_run_goes_on_to_the_bit_while_bonds_soften(tmp_path):
    groups = f"&joints energy=0 {G}, shear_energy=0 {G} /"
    way = [0, 0.5 * OPENING, 0, 0.9 * OPENING]
    whole = joined(tmp_path, way, groups, along=(0.1, 1), name="whole")
    deck = joined(tmp_path, way, groups, along=(0.1, 1), name="part", run=False)
    scree.run(deck, set={"step.count": 17}, timeout=300)
    done_or_failed(scree.call("run", "--restart", tmp_path / "part.h5", "--set", "step.count=36", "--quiet"))
    part = scree.read(tmp_path / "part.h5")
    for name in ("fracture", "contact", "dissipated"):
        np.testing.assert_array_equal(getattr(whole.history.energy, name), getattr(part.history.energy, name))
    assert whole.history.energy.fracture[-1] > whole.history.energy.fracture[16] > 0


@pytest.mark.parametrize("groups,words", [
    (f"&joints energy={G} 0 /", "a tensile strength"),
    (f"&joints shear_energy={G} 0 /", "a cohesion"),
    (f"&joints energy={G} /", "2 numbers"),
    (f"&joints energy=0 {G} /\n&contact method='augmented' /", "multipliers"),
    (f"&joints energy=0 {G}, dilation=0 5, dilation_slip=0 0.01 /", "dilates"),
])
def test_what_cannot_be_is_refused_by_name(groups, words, tmp_path):
    deck = joined(tmp_path, [0, OPENING], groups, run=False)
    with pytest.raises(scree.RunFailed, match=words):
        scree.run(deck, timeout=60)


@pytest.mark.parametrize("groups,words", [
    (f"&joints energy=0 {G} /\n&method model='nmm' /\n&cover edge=0.01, origin=0 0 /", None),
    (f"&joints energy=0 {G / 1000} /\n&method model='nmm' /\n&cover edge=0.01, origin=0 0 /", "a quarter of E G/T^2"),
    (f"&joints energy=0 {G}, kn=0 1e7, ks=0 1e7 /", "above T^2/(2 kn)"),
])
def test_a_zone_that_the_mesh_does_not_resolve_is_told(groups, words, tmp_path):
    """E G/T^2 is 10 m: edges of 10 mm are fine; 1000 times less energy leaves edges of 2.5 mm."""
    done = scree.call("check", joined(tmp_path, [0, OPENING], groups, run=False))
    assert done.returncode == 0
    told = [line for line in done.stdout.splitlines() if "warning" in line and ("E G/T^2" in line or "T^2/(2 kn)" in line)]
    assert len(told) == (words is not None)
    if words:
        assert words in told[0]
