"""Manifold elements of second order: what they hold is exact, on any mesh; they turn, swing and stand as they should."""
import math

import numpy as np
import pytest
import scree
from scree import block_files

MESH = "edge={0}, origin={1} {2}, angle=23, order=1"
SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]


def solid(folder, corners, numbers, groups, fixed=(), loads=(), measured=()):
    """Run of a block with these corners, of manifold elements."""
    lines = list(zip(corners, [*corners[1:], corners[0]]))
    points = [(*p, *p) for p in fixed] + [*loads, *measured]
    rows = "".join(" ".join(map(repr, map(float, p))) + "\n" for p in points)
    (folder / "d.geo").write_text(f"{1e-6 * np.ptp(corners)}\n{len(lines)} {len(lines)}\n0\n0\n{len(fixed)}\n{len(loads)}\n"
                                  f"{len(measured)}\n0\n" + "".join(f"{a[0]} {a[1]} {b[0]} {b[1]} 1\n" for a, b in lines) + rows)
    (folder / "d.ana").write_text(f"{numbers}\n30 0 0\n" + "".join(f"&{g} /\n" for g in groups))
    return scree.run(folder / "d.ana")


def box(length, height):
    return [(0, 0), (length, 0), (length, height), (0, height)]


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("strain", ["small", "green", "auto"])
def test_bending_is_exact(size, strain, tmp_path):
    """A moment on a beam: u = -k x y, v = k (x^2 + nu y^2)/2 about the middle of its depth, linear in strain, under a mesh that lies
    anyhow, small cuts and all. Inertia takes rho L^2/(E dt^2) of it, nothing; the turns of Green strain are k L = 8e-7."""
    length, height, young, poisson, stress = 4 * size, size, 1e7, 0.25, 1.0
    exactly = 1e-8 if strain == "small" else 1e-5
    places = np.array([(1, 0.5), (0.5, 0), (0.5, 1), (0.3, 0.7)]) * [length, height]
    r = solid(tmp_path, box(length, height), f"0 1 1 1 0.05 {1e6 * size} 1000 0 {young} {poisson} 0 0 0 0 0 0 0 0 0", [
        f"method model='nmm', strain='{strain}', plane='stress'", "cover " + MESH.format(0.8 * size, 0.13 * size, 0.21 * size),
        f"support x=0 0 0 {height}", f"boundary lines={length} 0 {length} {height}, traction={stress} 0 {-stress} 0"],
        fixed=[(0, height / 2)], measured=places)
    k, x, y = 2 * stress / height / young, places[:, 0], places[:, 1] - height / 2
    exact = np.column_stack([-k * x * y, k / 2 * (x**2 + poisson * y**2)])
    assert "follows" in r.covers  # of some elements that are too small to stand on their own
    np.testing.assert_allclose(r.measured_points.displacement[-1], exact, atol=exactly * abs(exact).max())
    found = r.measured_points.stress[-1]
    np.testing.assert_allclose(found[:, 0], -young * k * y, atol=exactly * stress)
    np.testing.assert_allclose(found[:, 1:], 0, atol=exactly * stress)
    for polygon, xx in zip(r.polygons(0), r.stress()[:, 0]):  # a cell has the stress of a place in it
        around = -young * k * (polygon[:, 1] - height / 2)
        assert around.min() - exactly * stress <= xx <= around.max() + exactly * stress


@pytest.mark.parametrize("strain", ["small", "green"])
def test_the_stress_of_own_weight_is_exact(strain, tmp_path):
    """A column between smooth walls: sigma_yy = -rho g (H - y), v = -rho g (H y - y^2/2)/M, both held by elements of any shape."""
    height, weight, young, poisson = 2.0, 20.0, 1e9, 0.3
    places = np.array([(0.5, 2.0), (0.3, 1.0), (0.7, 0.5)])
    r = solid(tmp_path, box(1, height), f"0 1 1 1 0.05 1e7 2 {weight} {young} {poisson} 0 0 0 0 0 0 0 0 0", [
        f"method model='nmm', strain='{strain}', plane='strain'", "cover " + MESH.format(0.7, 0.13, 0.21),
        f"support y=0 0 1 0, x=0 0 0 {height} 1 0 1 {height}"], measured=places)
    stiffness = young * (1 - poisson) / ((1 + poisson) * (1 - 2 * poisson))
    y = places[:, 1]
    sag = weight / stiffness * height**2 / 2
    exact = -weight / stiffness * (height * y - y**2 / 2)
    of_green = 3 * weight * height / stiffness  # of the strain, what is not linear in it
    np.testing.assert_allclose(r.measured_points.displacement[-1][:, 1], exact, rtol=1e-8 if strain == "small" else of_green)
    np.testing.assert_allclose(r.measured_points.displacement[-1][:, 0], 0, atol=1e-6 * sag)
    np.testing.assert_allclose(r.measured_points.stress[-1][:, 1], -weight * (height - y),
                               atol=(1e-9 if strain == "small" else of_green) * weight * height)


def test_a_constant_stress_relaxes_to_none_in_a_block_of_any_shape(tmp_path):
    """With notches, under a mesh whose triangles it cuts to pieces of any shape."""
    corners = [(0, 0), (3, 0), (3, 2), (2.2, 0.6), (1.8, 2.5), (1.1, 2.4), (1.3, 0.5), (0.9, 0.4), (0.2, 2.2)]
    stress, young, poisson = np.array([1.0, -2.0, 0.5]), 1e7, 0.25
    r = solid(tmp_path, corners, f"0 1 1 1 0.05 1e7 1000 0 {young} {poisson} {stress[0]} {stress[1]} {stress[2]} 0 0 0 0 0 0", [
        "method model='nmm', strain='small', plane='stress'", "cover " + MESH.format(0.9, 0.13, 0.21), "support y=0 0 3 0"],
        fixed=[(0, 0)], measured=[(2.9, 1.5), (1.5, 2.4)])
    np.testing.assert_allclose(r.stress(), 0, atol=1e-8)
    xx, yy, xy = stress
    ex, ey, shear = -(xx - poisson * yy) / young, -(yy - poisson * xx) / young, -xy * 2 * (1 + poisson) / young
    x, y = np.array([(2.9, 1.5), (1.5, 2.4)]).T
    np.testing.assert_allclose(r.measured_points.displacement[-1], np.column_stack([ex * x + shear * y, ey * y]), rtol=1e-7)


def triangles_over_the_beam(path, edge, height):
    """A Gmsh file of a row of triangles over a beam from 0 to 1."""
    n = round(1 / edge)
    low, high = [(i * edge, 0.0) for i in range(-1, n + 2)], [((i + 0.5) * edge, height) for i in range(-1, n + 1)]
    k, m = len(low), len(high)
    three = [(i, i + 1, k + i) for i in range(m)] + [(i + 1, k + i + 1, k + i) for i in range(m - 1)]
    path.write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n" + f"1 {k + m} 1 {k + m}\n2 1 0 {k + m}\n"
                    + "".join(f"{i + 1}\n" for i in range(k + m)) + "".join(f"{x} {y} 0\n" for x, y in low + high)
                    + f"$EndNodes\n$Elements\n1 {len(three)} 1 {len(three)}\n2 1 2 {len(three)}\n"
                    + "".join(f"{i + 1} {a + 1} {b + 1} {c + 1}\n" for i, (a, b, c) in enumerate(three)) + "$EndElements\n")


def test_the_cantilever_is_that_of_the_independent_program_with_41_elements(tmp_path):
    """Of Zhang et al. 2019, section 5.3: a row of 41 triangles, bent to 0.6 of its length in one step. The prototype has six-node
    triangles there and clamps with springs, softer by up to 4e-5; the converged solution is 0.60977 and 0.25859."""
    triangles_over_the_beam(tmp_path / "row.msh", 0.05, 0.1)
    r = solid(tmp_path, box(1, 0.1), "0 1 1 1 0.05 1e3 1e-3 0 2e8 0.3 0 0 0 0 0 0 0 0 0", [
        "method model='nmm', strain='green', plane='stress'", "integrator scheme='newmark', beta=1, gamma=0.5",
        "iteration method='newton', most=100", "cover mesh='row.msh', order=1, least=0",
        "loads force=0 -25000 0 -25000", "support both=0 0 0 0.1"], loads=[(1, 0), (1, 0.1)], measured=[(1, 0), (1, 0.1)])
    tip = -r.measured_points.displacement[-1].mean(0)
    np.testing.assert_allclose(tip, [0.2576371245, 0.6080931904], rtol=6e-5)
    assert tip[1] < 0.6080931904 and abs(tip[1] / 0.60977 - 1) < 0.01
    assert len(np.unique(r.covers.of_element, axis=0)) == 41 and len(r.covers.node) == 126
    assert r.history.solves.tolist() == [10]


@pytest.mark.parametrize("scheme", ["energy_momentum', beta=0.5", "energy_decaying'"])
def test_a_square_turns_without_growing(scheme, tmp_path):
    """By 3.6 degrees a step: 2 atan(w dt/2) a step, the area and the momentum as they began (as with covers of first order)."""
    spin, steps, dt = 2 * math.pi, 100, 0.01
    r = solid(tmp_path, SQUARE, f"1 {steps} 1 1 0.9 {dt} 2500 0 1e10 0.25 0 0 0 0 0 0 1 0.5 {spin}", [
        "method model='nmm', strain='green', plane='stress'", "cover " + MESH.format(0.9, 0.13, 0.21),
        f"integrator scheme='{scheme}"])
    h = r.history
    stretch = 2500 * spin**2 / 1e10  # rho w^2 L^2/E, what turning makes
    assert abs(h.area[-1] / h.area[0] - 1) < stretch
    assert h.rotation[-1].item() == pytest.approx(2 * steps * math.atan(spin * dt / 2), rel=stretch)
    np.testing.assert_allclose(h.momentum[-1], h.momentum[0], rtol=1e-6 if "decaying" in scheme else 1e-12)


def test_a_beam_swings_without_losing_energy(tmp_path):
    """A beam that is clamped and struck bends by a third of its length, with strains of some percent."""
    r = solid(tmp_path, box(1, 0.1), "1 60 1 1 0.9 0.005 1000 0 1e7 0.3 0 0 0 0 0 0 0 3 0", [
        "method model='nmm', strain='green', plane='stress'", "cover edge=0.11547005383792516, origin=0 0, order=1",
        "integrator scheme='energy_momentum', beta=0.5", "support both=0 0 0 0.1"], measured=[(1, 0.05)])
    energy = r.history.energy
    assert energy.strain.max() > 0.5 * energy.kinetic[0] and r.measured_points.displacement[:, 0, 1].max() > 0.3
    total = energy.kinetic + energy.strain
    np.testing.assert_allclose(total, total[0], rtol=1e-9)


def timoshenko(length, depth, young, poisson, density):
    """Lowest circular frequency of a clamped beam: where end forces that move nothing at the clamp leave none at the free end."""
    inertia, shear = depth**3 / 12, 10 * (1 + poisson) / (12 + 11 * poisson) * young / (2 * (1 + poisson)) * depth  # Cowper 1966

    def left(w):
        change = np.array([[0, 1, 0, 1 / shear], [0, 0, 1 / (young * inertia), 0], [0, -density * inertia * w**2, 0, -1],
                           [-density * depth * w**2, 0, 0, 0]])  # of deflection, turn, moment, shear force
        value, vector = np.linalg.eig(change)
        return np.linalg.det((vector @ np.diag(np.exp(value * length)) @ np.linalg.inv(vector))[2:, 2:]).real

    low, high = (share * 3.5160153 / length**2 * math.sqrt(young * inertia / (density * depth)) for share in (0.8, 1.0))
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if left(low) * left(middle) <= 0 else (middle, high)
    return low


def test_a_beam_swings_with_the_frequency_of_timoshenko(tmp_path):
    """A row of 41 elements, L/h = 10, struck: 0.8 % below Euler and Bernoulli. The step (average acceleration) makes tan(w dt/2) of w dt/2."""
    length, depth, young, poisson, density = 1.0, 0.1, 1e7, 0.25, 1000.0
    exact = timoshenko(length, depth, young, poisson, density)
    dt = 2 * math.pi / exact / 40
    triangles_over_the_beam(tmp_path / "row.msh", 0.05, depth)
    r = solid(tmp_path, box(length, depth), f"1 240 1 1 0.9 {dt} {density} 0 {young} {poisson} 0 0 0 0 0 0 0 1e-6 0", [
        "method model='nmm', strain='small', plane='stress'", "cover mesh='row.msh', order=1",
        "integrator scheme='newmark', beta=0.5, gamma=0.25", "support both=0 0 0 0.1"], measured=[(length, depth / 2)])
    t, v = r.history.time, r.measured_points.displacement[:, 0, 1]
    w = exact * np.linspace(0.95, 1.05, 2001)
    height = abs(np.exp(-1j * np.outer(w, t)) @ (v * np.hanning(len(t))))
    assert 2 / dt * math.tan(w[height.argmax()] * dt / 2) == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize("extra, found", [("", "contact"), ("&contact method='none' /\n&stage /", "stages")])
def test_what_takes_fields_for_linear_is_refused(extra, found, tmp_path):
    (tmp_path / "d.blk").write_text(block_files.block_file("two", [(1, block_files.box(x, x + 1, 0, 1)) for x in (0, 2)]))
    (tmp_path / "d.ana").write_text("1 5 1 1 0.05 0.01 2500 25000 1e9 0.25 0 0 0 0 0 0 0 0 0 30 0 0\n&deck geometry='d.blk' /\n"
                                    f"&method model='nmm' /\n&cover edge=0.7, order=1 /\n{extra}\n")
    done = scree.call("check", tmp_path / "d.ana")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert f"d.ana:4: expected cover.order=1 without contact, bolts and stages, found {found}" in done.stderr, done.stderr
