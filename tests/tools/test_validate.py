"""The answers of tools/validate, the geometries that it writes, and what it says."""
import math
import os
import pathlib
import re
import subprocess

import numpy as np
import pytest
import scree
from scree import block_files
from scree.polygons import worst_overlap
from scree.validation import cases, elastic, pages, published, references
from scree.validation.size_effect import NotchedBeam

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
RADIAN = math.pi / 180
G = 9.81


def test_friction_on_planes():
    """Without friction a block falls by the share of the sine; on the flat it stops by energy, m v^2/2 = mu m g s."""
    assert references.slide(30 * RADIAN, 0.0, 1.0) == pytest.approx(G / 4)
    assert references.slide(30 * RADIAN, math.tan(31 * RADIAN), 1.0) == 0
    found = [references.slide(a * RADIAN, mu, 1.0) for a, mu in ((30, 0.3), (45, 0.5), (30, math.tan(28 * RADIAN)))]
    assert found == pytest.approx([1.178144, 1.734179, 0.193876], abs=5e-7)
    time, way = references.stop(10.0, 0.5)
    assert way == pytest.approx(50 / (0.5 * G)) and time == pytest.approx(2 * way / 10)
    assert references.stop(2.0, 0.6, 20 * RADIAN) == pytest.approx((0.919197, 0.919197), abs=5e-7)


def test_kinks_of_cracks():
    """Pure shear turns a crack by acos(1/3) and counts 2/3^(1/2)-fold; an opened one goes straight on."""
    assert references.kink_angle(0.0, 1.0) == pytest.approx((-70.528779, 2 / math.sqrt(3)))
    assert references.kink_angle(2.0, 1.0)[0] == pytest.approx(-40.2078187)
    assert references.kink_angle(2.0, 0.0) == (0.0, 2.0)


def test_double_cantilever():
    """The load is that which has the energy of the crack, and its work over the opening is that of the compliance."""
    arms = references.DoubleCantilever(0.05, 1e10, 240.0)
    assert arms.length(arms.opening(0.2)) == pytest.approx(0.2)
    d = arms.opening(0.2)
    assert 12 * (arms.load(d) * (0.2 + 0.673 * 0.05))**2 / (1e10 * 0.05**3) == pytest.approx(240.0)
    slender = references.DoubleCantilever(1e-3, 1e10, 240.0)  # of beams alone: P = d E h^3/(8 a^3)
    assert slender.load(slender.opening(0.2)) == pytest.approx(slender.opening(0.2) * 1e10 * 1e-9 / (8 * 0.2**3), rel=0.02)


def test_dilating_joints():
    """Without dilation nothing lifts; the work of the push is that of friction, the rise and the speed."""
    assert references.dilating_ride(8.0, 10.0, 30, 0, 0.2) == pytest.approx((0.5 * (8 - 10 * math.tan(30 * RADIAN)) * 0.04, 0))
    along, up = references.dilating_ride(8.0, 10.0, 30, 10, 0.2)
    speed = 2 * np.array([along, up]) / 0.2
    pressing = 10 + 2 * up / 0.2**2
    lost = pressing * along * (math.tan(30 * RADIAN) - math.tan(10 * RADIAN))
    assert 8 * along == pytest.approx(lost + 10 * up + speed[0]**2 / 2 + speed[1]**2 / 2)
    along, up = references.dilating_hold(2.6, 4.0, 50.0, 1e4, 30, 10, 0.2)
    assert (4 + 50 * up) * math.tan(30 * RADIAN) == pytest.approx(2.6) and (along, up) == pytest.approx((0.0599162, 0.01006664), rel=1e-5)


def test_joints_that_stiffen():
    """The force is that of the closure; where a block turns its fall is the energy, the integral of that force."""
    u = references.joint_closure(80.0, 1e3, 2e-3)
    assert u < 2e-3 and 1e3 * u / (1 - u / 2e-3) == pytest.approx(80) and references.joint_closure(1.0, 1e3, 1e9) == pytest.approx(1e-3)
    deepest = references.deepest_closure(4.0, 1e3, 2e-3)
    way = np.linspace(0, deepest, 20001)
    assert np.trapz(1e3 * way / (1 - way / 2e-3), way) == pytest.approx(4 * deepest, rel=1e-6) and deepest == pytest.approx(1.88096e-3, rel=1e-5)


def test_corner_impact_keeps_the_point_of_contact():
    """The corner that sticks is at rest after the impact; with little friction the impulses are Coulomb's."""
    stuck = references.SlopeImpact(0.05, 0.05, 0.3)
    assert stuck.along + stuck.spin * 0.05 / math.sqrt(2) == pytest.approx(0.0, abs=1e-12)
    assert (stuck.time, stuck.speed, stuck.along, stuck.spin) == pytest.approx((0.100964, 0.990454, 0.525268, -14.856817), abs=5e-7)
    assert stuck.place((0.125, 0.475), 0.15) == pytest.approx((0.143213, 0.394993, -0.728522), abs=6e-7)
    smooth = references.SlopeImpact(0.05, 0.05, 0.0)
    assert smooth.along == pytest.approx(stuck.speed / math.sqrt(2)) and smooth.spin == 0
    assert smooth.place((0.125, 0.475), 0.15)[:2] == pytest.approx((0.155181, 0.394819), abs=6e-7)
    # A table of this impact at g = 10 with V = 1 m/s, phi 5, 10 and 20 degrees.
    for phi, along, spin in ((5, 0.6452429539, 5.249319812), (10, 0.5824247774, 10.57961884), (20, 0.5303300859, 15.0)):
        row = references.SlopeImpact(0.05, 0.05, math.tan(phi * RADIAN), g=10.0)
        assert (row.along, -row.spin) == pytest.approx((along, spin), rel=1e-9)


def test_shaken_block_without_friction_stays_where_it_was():
    """Without friction the slip is minus the way of the base, amplitude (sin wt - wt)/w^2."""
    omega, end = 2 * math.pi, 0.4
    slip, least = references.shaken_block(1e-9, 3.0, 1.0, end)
    assert slip == pytest.approx(3.0 / omega**2 * (math.sin(omega * end) - omega * end), rel=1e-6)
    assert references.shaken_block(0.6, 0.5 * G, 1.0, 2.0) == (0.0, 0.0)


def test_shaken_block_agrees_with_small_steps():
    steps, mu, speed, slip, least = 200000, 0.2, 0.0, 0.0, 0.0
    dt = 2.0 / steps
    for i in range(steps):
        ground = 0.5 * G * math.sin(2 * math.pi * (i + 0.5) * dt)
        free = speed - ground * dt
        speed = math.copysign(max(abs(free) - mu * G * dt, 0.0), free)
        slip += speed * dt
        least = min(least, slip)
    assert references.shaken_block(mu, 0.5 * G, 1.0, 2.0) == pytest.approx((slip, least), abs=2e-5)  # of order dt


def test_modes_of_a_block_on_a_plane():
    def mode(height, phi, slope=40):
        return references.block_mode(10, height, phi * RADIAN, slope * RADIAN)

    assert mode(10, 40.1) == (False, False) and mode(5, 20) == (True, False) and mode(25, 40) == (False, True)
    # The weight passes outside the base, but friction cannot turn the block: mu h/2 = 4.55 lies within b/2 = 5.
    assert mode(25, 20) == (True, False)
    assert mode(30, 20) == (True, True)


def test_confined_rock():
    """Hooke's law in plane strain has no strain aside; the settlement is the integral of the strain."""
    young, nu = 1e7, 0.25
    depth = (np.arange(1000) + 0.5) / 100
    xx, yy, _ = references.confined_stress(depth, 50.0, 20.0, nu).T
    zz = nu * (xx + yy)
    assert np.abs(xx - nu * (yy + zz)).max() < 1e-12
    assert references.confined_settlement(10.0, 50.0, 20.0, young, nu) == pytest.approx(-((yy - nu * (xx + zz)) / young).sum() / 100, rel=1e-9)


def test_waves_are_as_fast_as_hooke_and_newton_have_it():
    """Stress over strain of a bar that cannot get thicker, and of shear, over density; (cp/cs)^2 = 2 (1 - nu)/(1 - 2 nu)."""
    speed = references.wave_speeds(2500.0, 1e10, 0.25)
    assert references.wave_speeds(2500.0, 5e9, 0.25)["p"] == pytest.approx(1549.193, abs=1e-3)
    assert speed["s"] ** 2 * 2500 == pytest.approx(4e9) and (speed["p"] / speed["s"]) ** 2 == pytest.approx(3.0)


def test_strength_of_joints():
    """Barton's at a stress of JCS/100: phi + 2 JRC degrees."""
    assert references.barton_strength(100.0, 10.0, 1e4, 30) == pytest.approx(100 * math.tan(50 * RADIAN))
    assert references.bonded_strength(100.0, 60.0, 45) == pytest.approx(160)


def test_dams():
    """With the width that it needs the resultant passes through the toe: thrust h/3 = weight b/2."""
    b = references.dam_width(12.0, 24.0, 10.0)
    assert 720 * 12 / 3 == pytest.approx(24 * b * 12 * b / 2)
    assert references.dam_friction(6.0, 12.0, 24.0, 10.0) == pytest.approx(720 / 1728)


def test_stretch_of_a_bar_in_green_strain():
    """Printed stretches; the energy E (l^2 - 1)^2/8 has the load as its slope, and no slope is below that at 1/sqrt 3."""
    found = [references.green_stretch(p) for p in (0.01, 0.1, 0.5, -0.1)]
    assert found == pytest.approx([1.00985387, 1.08803391, 1.32471796, 0.87888507], abs=6e-9)
    assert ((found[1] + 1e-5)**2 - 1)**2 / 8 - ((found[1] - 1e-5)**2 - 1)**2 / 8 == pytest.approx(0.1 * 2e-5, rel=1e-8)
    assert references.green_stretch(-0.192450) == pytest.approx(math.sqrt(1 / 3), abs=1e-3)
    assert references.green_stretch(-0.2) < 0  # the only solution is beyond 0


def test_elastica():
    """Printed values of E5, and P L^3/3EI for a small load."""
    for load, way, down in ((1, 0.056433, 0.301721), (2, 0.160642, 0.493457), (5, 0.387628, 0.713792), (10, 0.554996, 0.810609)):
        assert references.elastica(load) == pytest.approx((way, down), abs=6e-7)
    assert references.elastica(3)[::-1] == pytest.approx((0.603253441130, 0.254420184564), abs=1e-10)
    assert references.elastica(1e-3)[1] == pytest.approx(1e-3 / 3, rel=1e-5)


def test_beam_of_timoshenko():
    """A slender one has the frequency and deflection of Euler and Bernoulli's; printed values of E6."""
    beam, slender = (references.TimoshenkoBeam(length, 1.0, 1e9, 0.25, 2500.0) for length in (10.0, 500.0))
    assert beam.deflection(1e4) == pytest.approx(0.0403) and slender.deflection(1.0) == pytest.approx(500**3 / 2.5e8, rel=1e-5)
    assert slender.frequency() == pytest.approx(1.021669 / 50**2, rel=1e-4)
    assert beam.frequency() == pytest.approx(1.013863, abs=1e-6)


def test_corner_of_a_clamp():
    """Williams' power in plane strain with nu 0.3, which is plane stress with 3/7; without nu nothing is singular."""
    assert references.clamped_corner(3 / 7) == pytest.approx(0.7112, abs=1e-4) and references.clamped_corner(0.0) == pytest.approx(1.0)


def test_period_of_a_pendulum():
    """Printed ratios of E3; after a period the angle of its motion in closed form is the amplitude."""
    small = references.pendulum_period(0.0, elastic.PENDULUM)
    assert small == pytest.approx(1.947858, abs=1e-6)
    for degrees, ratio in ((30, 1.017409), (90, 1.180341), (150, 1.762204)):
        period = references.pendulum_period(degrees * RADIAN, elastic.PENDULUM)
        assert period / small == pytest.approx(ratio, abs=6e-7)
        assert references.pendulum(degrees * RADIAN, elastic.PENDULUM, period) == pytest.approx(degrees * RADIAN, abs=1e-7)
        assert references.pendulum(degrees * RADIAN, elastic.PENDULUM, period / 4) == pytest.approx(0.0, abs=1e-9)


def test_brazilian_disc():
    """Printed values of E11; across the diameter that is not loaded, s_yy = -(2 P/pi D)((4 D^2/(D^2 + 4 x^2))^2/4 - 1) balances the force."""
    assert references.brazilian_centre(1e6, 1.0) == pytest.approx((636619.77, -1909859.32), abs=0.01)
    x = np.linspace(-0.5, 0.5, 20001)
    along = references.brazilian_centre(1.0, 1.0)[0] * (1 - (4 / (1 + 4 * x**2))**2 / 4)
    assert along[10000] == pytest.approx(references.brazilian_centre(1.0, 1.0)[1]) and np.trapz(along, x) == pytest.approx(-1.0)


def test_hole_in_a_round_plate():
    """A large plate is Kirsch's; under the same pull from all sides it is Lame's ring, whose hoop stress balances the pull on its radius."""
    hole = references.Kirsch(1.0, -0.5, 1.0, 0.25)
    assert references.round_plate_hoop(1e4, 1.0, -0.5) == pytest.approx((hole.hoop(0.0), hole.hoop(math.pi / 2)), rel=1e-6)
    assert references.round_plate_hoop(2.0, 3.0, 3.0) == pytest.approx((8.0, 8.0))
    assert references.round_plate_hoop(30.0, 1.0, 0.0) == pytest.approx((-1.007794, 3.010019), abs=1e-6)


def test_rocking_block():
    block = references.Rocking(0.25, 1.0)
    for share, time, spin in ((0.2, 0.260350, 0.391092), (0.5, 0.493803, 0.565045), (0.8, 0.858640, 0.639612)):
        assert block.impact(share * block.alpha) == pytest.approx((time, spin), abs=6e-7)
    # Housner: a slender block, cosh(p T) = 1/(1 - share) with p^2 = 3 g/4 R.
    slender = references.Rocking(0.001, 1.0)
    p = math.sqrt(0.75 * G / slender.R)
    assert slender.impact(0.5 * slender.alpha)[0] == pytest.approx(math.acosh(2.0) / p, rel=1e-5)
    assert block.least_acceleration() == pytest.approx(0.25)


def test_load_of_cantilevers():
    """The energy of fracture is what the ends are given less what the arms store, and a crack of twice the length has half the load."""
    arms = references.Cantilevers(1e10, 0.05, 240.0)
    crack = np.linspace(0.2, 0.4, 2001)
    opening = arms.opening(crack)
    load = arms.load(opening)
    assert load * crack == pytest.approx(np.full(2001, math.sqrt(240.0 * 1e10 * 0.05**3 / 12)))
    assert opening == pytest.approx(2 * load * crack**3 / (3 * arms.bending))
    stored = load * opening / 2
    assert np.trapz(load, opening) - (stored[-1] - stored[0]) == pytest.approx(240.0 * 0.2, rel=1e-6)


def test_notched_flexure():
    """The energy released is P^2/2 dC/da; the length of the crack is found from the compliance, and the shear from Timoshenko's coefficient."""
    beam = references.NotchedFlexure(1e10, 0.5, 0.05)
    change = (beam.compliance(0.4 + 1e-5) - beam.compliance(0.4 - 1e-5)) / 2e-5
    crack = beam.crack(beam.compliance(0.4))
    assert crack == pytest.approx(0.4 + beam.longer) and beam.longer == pytest.approx(0.01271, abs=1e-5)
    assert beam.energy(5e4, crack) == pytest.approx(5e4**2 / 2 * change, rel=1e-8)
    whole = references.TimoshenkoBeam(0.5, 0.1, 1e10, 0.0, 1.0)  # half of a beam that is not cracked, under half of the load
    assert beam.compliance(-beam.longer) == pytest.approx(whole.deflection(0.5))


def test_notched_beam_with_bonds_lies_between_plasticity_and_a_crack():
    """A closed ligament bears the moment P W of the reactions without a force along the beam. A small beam has P = T W/8, as its ligament
    turns about the press; a large one has that of K = (E G)^(1/2), 10.65 P/W^(1/2) by Srawley (1976)."""
    beam = NotchedBeam(24)
    y = np.linspace(0.5, 1, len(beam.pull))
    assert abs(beam.pull.sum()) < 1e-9 and beam.pull @ (1 - y) == pytest.approx(1, abs=1e-9)
    assert 0.97 / 8 * 0.99 < beam.peak(1e-3) < 1 / 8
    assert 0.8 < beam.peak(5.2) * 10.65 * math.sqrt(5.2) < 0.9 < NotchedBeam(48).peak(20) * 10.65 * math.sqrt(20) < 1


@pytest.mark.parametrize("ratio, amplitude", [(2, 1.2233), (4, 1.7811)])
def test_block_under_one_cycle_of_a_sine(ratio, amplitude):
    """Amplitudes of an integration by fixed steps; a block that does not lift does not tilt."""
    block = references.Rocking(0.25, 1.0)
    lifts, omega = math.tan(block.alpha), ratio * math.sqrt(0.75 * block.g / block.R)
    assert math.isinf(published.pulse_tilt(block, (amplitude + 2e-4) * lifts, omega))
    assert 0.5 < published.pulse_tilt(block, (amplitude - 2e-4) * lifts, omega) < 1.5
    assert published.pulse_tilt(block, 0.999 * lifts, omega) == 0
    if ratio == 2:  # a second integration, by steps of 1 ms at most; errors grow where the block hovers
        assert published.pulse_tilt(block, 1.1 * lifts, omega) == pytest.approx(0.014061862, abs=2e-6)


def test_arch_that_is_pushed_aside():
    """Of least thickness it bears nothing more than its weight."""
    assert [round(published.pushed_arch(*arch), 5) for arch in published.ARCHES.values()] == [0.37361, 0.35675, 1.29212]
    least = references.arch_thickness(8, polygon=True)
    pushes = [published.pushed_arch(8, factor * least, 180.0) for factor in (1 + 1e-6, 1.01, 1.1)]
    assert 0 <= pushes[0] < 1e-4 < pushes[1] < pushes[2]


def test_toppling_columns_of_goodman_and_bray():
    """Forces of the worked example; its toe column needs almost none."""
    rows = references.Toppling().forces(0.7855)
    forces = {n: force for n, force, _ in rows}
    table = [292.5, 825.7, 1556.0, 2826.7, 3922.2, 4594.8, 4837.0, 4637.5, 3978.1, 2825.6, 1413.6, 472.2, 1.5]
    assert [forces[n] for n in range(13, 0, -1)] == pytest.approx(table, abs=0.06)
    modes = {n: mode for n, _, mode in rows}
    assert all(modes[n] == "topples" for n in range(4, 14)) and all(modes[n] == "slides" for n in (1, 2, 3))
    assert all(modes[n] == "stable" for n in (14, 15, 16))
    example = references.Toppling()
    assert example.forces(example.critical())[-1][1] == pytest.approx(0.0, abs=1e-6)
    assert math.degrees(math.atan(example.critical())) == pytest.approx(38.1512, abs=5e-5)


def test_least_thickness_of_arches():
    for voussoirs, least in ((8, 0.10086), (16, 0.10724), (25, 0.10703), (64, 0.10739)):
        assert references.arch_thickness(voussoirs) == pytest.approx(least, abs=6e-6)
    # Many voussoirs: Milankovitch's 0.10748 with radial joints, whichever weights; 1/N^2 is left.
    assert references.arch_thickness(120) == pytest.approx(0.10748, abs=6e-5)
    assert references.arch_thickness(120, polygon=True) == pytest.approx(references.arch_thickness(120), abs=1e-5)
    assert references.arch_thickness(8, polygon=True) == pytest.approx(0.09997, abs=6e-6)


def test_plane_failure_and_roof_wedge():
    safety = references.plane_failure(60, 50 * RADIAN, 35 * RADIAN, 14, 25, 35 * RADIAN, 26)
    assert safety == pytest.approx(1.1461, abs=5e-5)
    dry = references.plane_failure(60, 50 * RADIAN, 35 * RADIAN, 14, 0, 35 * RADIAN, 26)
    assert dry == pytest.approx(1.0)  # friction angle of the plane
    weight, normal, thrust = references.roof_wedge(20 * RADIAN, 35 * RADIAN, 1, 2500)
    assert (weight, normal) == pytest.approx((8926.37, 14125.8), abs=0.05)
    shear = normal * math.tan(35 * RADIAN)
    c, s = math.cos(20 * RADIAN), math.sin(20 * RADIAN)
    assert 2 * (shear * c - normal * s) == pytest.approx(weight) and normal * c + shear * s == pytest.approx(thrust)


def test_loss_on_an_arc_falls_with_the_length_of_its_chords():
    """A plastic kink costs energy to the second order of its angle, so all of them together to the first."""
    losses = [1 - references.ArcSlide(references.track(n, 90, 1.5), 0.2, 0.1, math.sqrt(20)).rise for n in (40, 80, 160)]
    assert losses == pytest.approx([1 - 0.975468278, 1 - 0.9876986872, 1 - 0.9937847167], abs=1e-4)
    assert losses[1] / losses[2] == pytest.approx(2.0, abs=0.05)


@pytest.mark.parametrize("opening, top, rise, back", [
    (90, 0.9262935333, 0.951536861, 4.256195821), (80, 0.9269621533, 0.956832458, 4.279714494),
    (75, 0.9277696117, 0.9595199838, 4.29165666)])
def test_arc_slide_agrees_with_an_independent_integration(opening, top, rise, back):
    """Another program, by steps of the front corner; its last digits are not converged."""
    slide = references.ArcSlide(references.track(20, opening, 1.5), 0.2, 0.1, math.sqrt(20))
    assert (0.25 + slide.top_time, slide.rise, slide.speed_back) == pytest.approx((top, rise, back), abs=8e-6)


def outlines(text):
    """Corners of the blocks of a block file."""
    rows = [line.split() for line in text.splitlines() if not line.startswith("!")]
    count = int(rows[0][0])
    vertices = np.array([[float(x) for x in row[1:3]] for row in rows[2 + count:2 + count + int(rows[0][2])]])
    return [vertices[int(first) - 1:int(last)] for _, first, last in rows[2:2 + count]]


@pytest.mark.parametrize("text, count", [
    (block_files.arch(25, 0.11), 26), (block_files.arch(8, 0.1), 9), (block_files.overhang(0.99), 5),
    (block_files.wall(10), 106), (block_files.columns(references.Toppling()), 17)])
def test_blocks_touch_and_do_not_overlap(text, count, tmp_path):
    polygons = outlines(text)
    assert len(polygons) == count and worst_overlap(polygons) < 1e-12
    areas = [np.sum(p[:, 0] * np.roll(p[:, 1], -1) - np.roll(p[:, 0], -1) * p[:, 1]) / 2 for p in polygons]
    assert min(areas) > 0
    (tmp_path / "it.blk").write_text(text)
    scree.cut(tmp_path / "it.blk", output=tmp_path / "again.blk")


def test_overlap_is_the_depth_of_a_corner():
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    assert worst_overlap([square, square + [0.3, 0.9]]) == pytest.approx(0.1)
    assert worst_overlap([square, square + [0.0, 1.0]]) == 0 and worst_overlap([square, square + [2.0, 0.0]]) == 0


BLOCKS = {"m6-roof-wedge/wedge.blk": 5, "p1-confined-column/stack.geo": 10,
          "p1-confined-column/column.geo": 1, "p4-cantilever/beam.geo": 1, "n1-cantilever/cantilever.geo": 1, "p2-k0/k0.geo": 1,
          "w1-wave/column.geo": 1, "w3-free-field/layer.geo": 1, "e6-cantilever/beam.geo": 1, "e7-bar/bar.geo": 1,
          "e9-column/column.geo": 1, "e10-rod/rod.geo": 1, "e8-patch/patch.geo": 1, "e2-spin/square.geo": 1, "e5-elastica/beam.geo": 1,
          "e12-kirsch": 1, "e11-brazilian": 1, "k1-intensity": 1, "k2-growth": 1, "k3-cantilevers": 1,
          "k4-strip": 1, "k6-three-holes": 1, "k7-kalthoff": 1, "k8-overhang": 1, "k10-beginning": 1,
          "s3-excavations/pillar.blk": 3, "s3-excavations/toe.blk": 3, "m2-toppling/columns.blk": 17,
          "m3-arch/arch16.blk": 17, "m13-pushed-arch": 9, "m4-overhang/overhang95.blk": 5, "m9-wall/wall10.blk": 106}  # of files and folders that have other than two


@pytest.mark.parametrize("path", sorted(p.relative_to(SOURCE) for pattern in ("validation/*/*", "paper/arc/*", "paper/rockfall/*")
                                        for p in (SOURCE / "input").glob(pattern) if p.suffix in (".geo", ".blk")), ids=str)
def test_committed_geometries_do_not_overlap(path, tmp_path):
    polygons = outlines(scree.cut(SOURCE / path, output=tmp_path / "it.blk").read_text())
    assert len(polygons) == BLOCKS.get(f"{path.parent.name}/{path.name}", BLOCKS.get(path.parent.name, 2))
    assert worst_overlap(polygons) < 1e-9


def test_orders_and_frequencies_are_found():
    """Of values made with an order, and of a sine with a higher one on it."""
    assert elastic.orders([1 + 0.3 / 2**(1.5 * n) for n in range(4)]) == pytest.approx([1.5, 1.5])
    time = np.arange(0, 4, 0.01)
    assert elastic.frequency(time, 1 - np.cos(6.4 * time) + 0.02 * np.sin(40 * time), 1.0) == pytest.approx(6.4 / 2 / math.pi, rel=2e-4)


def test_distance_from_a_linear_field():
    """Nothing of a rigid motion counts, and all of what is neither that nor the strain."""
    class Run:
        def vertices(self, frame):
            return np.array([(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)])

        def displacement(self):
            return self.vertices(0) @ [[1e-3, 3e-3], [-1e-3, 2e-3]] + [0.5, 0.2] + np.outer([1e-5, -1e-5, 1e-5, -1e-5], [1, 0])

    strain = np.array([[1e-3, 1e-3], [1e-3, 2e-3]])
    assert elastic.off_linear_field(Run(), strain) == pytest.approx(1e-5 / 4e-3, rel=0.3)
    assert elastic.off_linear_field(Run(), 2 * strain) > 0.1


def test_a_row_is_met_within_its_tolerance():
    assert cases.Row("way", 2.0, 2.001, 1e-3).met() and not cases.Row("way", 2.0, 2.003, 1e-3).met()
    assert cases.Row("way", 0.0, 1e-7, 1e-6, 1.0).met() and not cases.Row("way", 1.0, math.nan, 1e9).met()
    assert cases.Row("mode", "rests", "rests").met() and not cases.Row("mode", "rests", "slides").met()


def test_the_tool_says_what_is_wrong(tmp_path):
    tool = SOURCE / "tools" / "validate"
    done = subprocess.run([tool, "b99"], capture_output=True, text=True)
    assert done.returncode == 2 and "found b99" in done.stderr
    done = subprocess.run([tool, "b1", "--scree", tmp_path / "none"], capture_output=True, text=True)
    assert done.returncode == 2 and "found none" in done.stderr
    wrong = tmp_path / "wrong"
    wrong.write_text("#!/bin/sh\necho 'out of order' >&2\nexit 1\n")
    wrong.chmod(0o755)
    done = subprocess.run([tool, "b1", "m4", "--scree", wrong], capture_output=True, text=True)
    assert done.returncode == 1 and done.stdout.count("out of order  MISS") == 2


@pytest.mark.parametrize("setting", ["x", "contact.nothing=1", "step.size=-1", "cover.edge=1", "joint(5).phi=3"])
def test_a_setting_that_a_case_cannot_have_is_one_line(setting):
    done = subprocess.run([SOURCE / "tools" / "validate", "b1", "m6", "--set", setting], capture_output=True, text=True)
    line, = done.stderr.splitlines()
    assert done.returncode == 2 and line.startswith("tools/validate: b1: --set") and ": expected " in line
    assert "MISS" not in done.stdout


def test_a_setting_reaches_every_run_and_solves_are_counted():
    done = subprocess.run([SOURCE / "tools" / "validate", "b3"], capture_output=True, text=True)
    assert done.returncode == 0 and int(re.search(r"(\d+) solves", done.stdout)[1]) > 0
    done = subprocess.run([SOURCE / "tools" / "validate", "b3", "--set", "contact.method=none"], capture_output=True, text=True)
    assert done.returncode == 1 and "2 misses, 750 solves" in done.stdout  # falls freely, a solve a step


def scene_of_page(name, text):
    """The lines of the deck that the page of a case shows: of a file, or of the first model that the case runs."""
    found = re.search(r"^Deck: `(\S+)`", text, re.M)
    if found:
        return (SOURCE / found[1]).read_text().splitlines()

    class Met(Exception):
        pass

    def run(scene, *_, **__):
        raise Met(scene)

    with pytest.raises(Met) as met:
        next(cases.CASES[name](run))
    said, lines = pages.deck_of(met.value.args[0])
    assert said in text
    return lines


@pytest.mark.parametrize("name", cases.CASES)
def test_each_case_has_a_page_with_its_scene_its_picture_and_its_deck(name):
    """`tools/validate --write` makes them; numbers are those of its run, scene and reference are written by hand."""
    text = (pages.PAGES / f"{name}.md").read_text()
    assert text.startswith(f"# {name}: {cases.CASES[name].__doc__.splitlines()[0].rstrip('.')}\n")
    assert re.search(r"(?m)^- \*\*Scene:\*\* .{10,}\n- \*\*Reference:\*\* .+", text) and pages.described(name) in text
    assert pages.shown(scene_of_page(name, text)) in text and (pages.PICTURES / f"{name}.png").stat().st_size > 1000
    assert len(re.findall(r"^\| [^|]+ \| [^|]+ \| [^|]+ \| [^|]* \| [^|]* \|$", text, re.M)) > 1


def test_the_overview_names_each_case():
    overview = (SOURCE / "doc" / "validation.md").read_text()
    for name, function in cases.CASES.items():
        assert f"| [{name}](verification/{name}.md) | {function.__doc__.splitlines()[0].rstrip('.')} |\n" in overview


def test_a_page_shows_the_first_of_long_lists_of_numbers():
    deck = ["&boundary lines=0 0 1 0", *6 * ["  1 0 2e-3 0"], "  traction=1 0 1 0", "  1 0 1 0 /"]
    assert pages.shown(deck).splitlines() == [*deck[:5], "...", *deck[7:]]


def test_a_page_has_the_numbers_of_its_rows(tmp_path):
    rows = [cases.Row("way", 2.0, 2.002, 0.01), cases.Row("verdict", "stands", "stands")]
    text = pages.page("b1", "Sliding", rows, SOURCE / "input" / "validation" / "b1-slide" / "slope30.ana", 2)
    assert "| way | 2 | 2.002 | 1.0e-03 | 1.0e-02 |\n| verdict | stands | stands |  |  |\n" in text and ", and 2 more in its folder" in text
