"""Nodes of a mesh that lie on a side of the rock but for rounding: far from the origin of a regular mesh, or in a file."""
import numpy as np
import pytest
import scree


def sinks(folder, at, cover, size=1.0):
    """How far the middle of the top of two blocks, one on the other, sinks under their weight, over their height."""
    x, y = at
    corners = [(x, y), (x + 10, y), (x + 10, y + 10), (x, y + 10)]
    lines = [(*corners[i], *corners[(i + 1) % 4], 1) for i in range(4)] + [(x, y + 4, x + 10, y + 4, 1)]
    text = lambda numbers: " ".join(str(float(n) * size) for n in numbers)
    (folder / "a.geo").write_text("\n".join(["0.001", "5 0", *"0000", "1", "0", *(f"{text(r[:4])} 1" for r in lines), text((x + 5, y + 9)), ""]))
    (folder / "a.ana").write_text("\n".join([
        "0 40 1 1 0.05 0.05", f"2500 25000 {1e9 * size} 0.25", "0 0 0", "0 0 0", "0 0 0", "45 0 0", "&deck geometry='a.geo' /",
        "&method model='nmm' /", f"&cover {cover} /",
        f"&support x={text((x, y, x, y + 10, x + 10, y, x + 10, y + 10))}, y={text((x, y, x + 10, y))} /", "&step balance=1e-6 /", ""]))
    r = scree.run(folder / "a.ana", output=folder / "a.h5")
    return -r.measured_points.displacement[-1, 0, 1] / (10 * size)


@pytest.mark.parametrize("at", [(0, 0), (1000, 1000), (0, -600), (-5000, 2000), (100000, 50000)])
def test_a_regular_mesh_far_from_its_origin(at, tmp_path):
    """After hundreds of rows its nodes were a rounding beside the side of the rock: faces had edges of 2e-13 m, which nothing may leap
    over, and the run ended not in equilibrium where it began."""
    assert sinks(tmp_path, at, "edge=1") == pytest.approx(1.174e-4, rel=2e-2)


@pytest.mark.parametrize("size", [1e-3, 1e3])
def test_of_any_size(size, tmp_path):
    assert sinks(tmp_path, (1000, 1000), f"edge={size}", size) == pytest.approx(1.174e-4, rel=2e-2)


@pytest.mark.parametrize("off", [1e-14, 3e-13, 1e-11, 1e-9, 1e-7])
def test_a_file_whose_nodes_are_off(off, tmp_path):
    """By up to so much, from side to side of the rock and outside of it."""
    n, rng = 10, np.random.default_rng(1)
    node = np.array([(i - 1, j - 1) for j in range(n + 3) for i in range(n + 3)], float)
    node += off * rng.uniform(-1, 1, node.shape)
    three = [(a, a + 1, a + n + 4) for j in range(n + 2) for a in range(j * (n + 3), j * (n + 3) + n + 2)]
    three += [(a, a + n + 4, a + n + 3) for a, _, _ in three]
    (tmp_path / "a.msh").write_text("\n".join([
        "$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$Nodes", f"1 {len(node)} 1 {len(node)}", f"2 1 0 {len(node)}",
        *(str(k + 1) for k in range(len(node))), *(f"{x} {y} 0" for x, y in node.tolist()), "$EndNodes",
        "$Elements", f"1 {len(three)} 1 {len(three)}", f"2 1 2 {len(three)}",
        *(f"{k + 1} {a + 1} {b + 1} {c + 1}" for k, (a, b, c) in enumerate(three)), "$EndElements", ""]))
    assert sinks(tmp_path, (0, 0), "mesh='a.msh'") == pytest.approx(1.174e-4, rel=3e-2)
