"""Blocks whose sides lie next to a line of the mathematical mesh, through the program, against those whose sides lie on it."""
import numpy as np
import pytest
import scree
from scree.block_files import block_file, held
from test_blocks_touch import G, box, run

OFFSETS = [(0, -1e-3), (0, -1e-5), (0, -1e-7), (0, -1e-12), (0, 1e-7), (-1e-7, -1e-7), (1e-8, 1e-6)]


def stand(folder, offset, groups, **options):
    """A block of 2 x 1 on a floor, a multiple of the mesh but for an offset; how far its middle went, and the results."""
    x, y = offset
    blocks = [np.array([[-1, -1], [3, -1], [3, y], [-1, y]]), box(x, y, 2, 1)]
    groups += "\n&method model='nmm' /\n&cover edge=0.8, origin=0 0, angle=0, order=0 /\n&support both=-1 -1 3 -1 /"
    f = run(folder, blocks, groups, rock=(2.5, 2.5 * G, 1e5, 0.2), phi=30.0, measured=[(1, 0.5, 2)], name=f"{x}_{y}", **options)
    return f.measured_points.displacement[-1, 0], f


@pytest.mark.parametrize("contact", ["", "&contact method='augmented' /"])
@pytest.mark.parametrize("static", [False, True])
def test_a_block_rests_as_one_on_the_mesh_does(contact, static, tmp_path):
    """Within what the rock does differently over the offset, and vertices at the other end of a sliver, and in as many steps."""
    options = {"carried": 0, "steps": 60} if static else {"steps": 200, "dt": 1e-3}
    groups = contact + ("\n&step balance=1e-6 /" if static else "\n&damping mass=10 /")
    on_it, flush = stand(tmp_path, (0, 0), groups, **options)
    assert on_it[1] < -1e-4
    for offset in OFFSETS:
        beside, f = stand(tmp_path, offset, groups, **options)
        np.testing.assert_allclose(beside, on_it, atol=(1e-3 + 2 * max(map(abs, offset))) * abs(on_it[1]))
        assert f.history.rejected.sum() == 0 and len(f.history.time) <= len(flush.history.time) + 1


def test_rounded_heights_let_blocks_slide(tmp_path):
    """Two blocks that slide on each other and on a floor, two rows of nodes high to 9 digits: in the steps asked for."""
    height = round(np.sqrt(3) / 2, 9)
    blocks = [np.array([[-6, -1], [8, -1], [8, 0], [-6, 0]]), box(0, 0, 1.09375, height), box(0.046875, height, 0.8203125, height)]
    f = run(tmp_path, blocks, "&method model='nmm' /\n&cover edge=0.5, origin=0 0, angle=0, order=0 /\n&support both=-6 -1 8 -1 /\n"
            "&contact restitution=0 /", rock=(2500, 2500 * G, 4e9, 0.2), phi=20.0, material=[1, 2, 2],
            velocity=((0, 0, 0), (2, 0, 0)), steps=60, measured=[(0.5, 0.5, 2)])
    assert f.history.rejected.sum() == 0 and len(f.history.time) == 60
    t = f.history.time[-1]
    assert f.measured_points.displacement[-1, 0, 0] == pytest.approx(2 * t - G * np.tan(np.radians(20)) * t**2 / 2, rel=1e-2)


@pytest.mark.parametrize("origin", [(0.1, 0.05), (-0.002, -0.0006), (0.002, 0.0014), (0, 0.0005), (0.001, 0.0007), (0.003, 0.0021), (-0.005, -0.0015)])
@pytest.mark.parametrize("angle", [0, 30])
def test_a_joint_closes_evenly_whatever_slivers_lie_on_it(origin, angle, tmp_path):
    """Two hard plates under a pressure p: by p/kn at both ends. Both sides of the joint keep the same vertices."""
    groups = (f"&method model='nmm' /\n&cover edge=0.4, origin={origin[0]} {origin[1]}, angle={angle} /\n&support both=0 -1 3 -1 /\n"
              "&boundary lines=0 1 3 1, traction=0 -1e3 0 -1e3 /\n&joints kn=1e6 /")
    f = run(tmp_path, [box(0, -1, 3, 1), box(0, 0, 3, 1)], groups, rock=(2.5, 0.0, 1e10, 0.2), phi=30.0, carried=0, steps=40,
            measured=[(0.1, 0.1, 2), (2.9, 0.1, 2)])
    np.testing.assert_allclose(f.measured_points.displacement[-1, :, 1], -1e-3, rtol=1e-3)


def test_a_corner_that_begins_a_sliver_goes_with_its_own_element(tmp_path):
    """A wedge that falls on its tip, where the mesh leaves a sliver of a side, and its mirror image: in one of them the side begins there.
    The tip went by what the element next to its own is bent, and pressed on that."""
    floor = np.array([(-4, -1), (4, -1), (4, 0), (-4, 0)], float)
    wedge = np.array([(0.04662576853596152, 0.040237671483251664), (0.5053317595289796, 0.492052002088164),
                      (-0.4386393614604619, 0.6760881983618777)])
    middle, way = wedge.mean(0), []
    for side in (1, -1):
        floor_here, wedge_here = ((x * [side, 1])[::side] for x in (floor, wedge))
        (tmp_path / "a.blk").write_text(block_file("wedge", [(1, floor_here), (1, wedge_here)], held(floor_here, 1), measured=[
            (*((0.9 * x + 0.1 * middle) * [side, 1]), 2) for x in wedge]))
        (tmp_path / "a.ana").write_text("\n".join([
            "1 40 1 1 0.05 0.005", f"2500 0 1e8 0.25 {'0 ' * 9}", "0 0 0", "&deck geometry='a.blk', dialect='short' /",
            "&acceleration table=0 0 10 100 0 10 /", "&method strain='small', model='nmm' /",
            f"&cover edge=0.9, origin={0.1 * side} 0.2, angle={11 if side == 1 else 169} /", ""]))
        r = scree.run(tmp_path / "a.ana", output=tmp_path / "a.h5")
        assert r.history.overlap.max() > 0
        way.append(r.measured_points.displacement[-1] * [side, 1])
    np.testing.assert_allclose(way[1], way[0], atol=1e-11)
