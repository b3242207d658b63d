"""What tools/plot draws over blocks, held against the results: vectors, principal stresses, joints, forces; and how it is drawn."""
import os
import pathlib
import subprocess

import numpy as np
import pytest
import scree
from matplotlib import image
from matplotlib.collections import LineCollection, PathCollection
from matplotlib.quiver import Quiver
from scree import drawing, overlays
from scree.errors import PlotError

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOL = SOURCE / "tools" / "plot"
CASES = SOURCE / "input" / "validation"
SHEARED = """1 3 1 1 0.01 0.001
2500 0 1e9 0.2
3e5 -1e5 1e5
0 0 0
0.2 -0.1 0.3
30 0 0
&deck geometry='{geometry}' /
&contact method='none' /
"""
SQUARE = """0.001 4 4 0 0 0 0 0 0
0 0 {a} 0 1
{a} 0 {a} {a} 1
{a} {a} 0 {a} 1
0 {a} 0 0 1
"""


def lines_of(axis, name):
    """The segments of what a panel has of a name."""
    found = [c for c in axis.collections if isinstance(c, LineCollection) and c.get_label() == name]
    return np.array([segment for c in found for segment in c.get_segments()])


def frames(path):
    return drawing.Frames(path, path.stem)


@pytest.fixture(scope="module")
def slides(tmp_path_factory):
    """A block on a plane of 30 degrees that slides, one that stays."""
    folder = tmp_path_factory.mktemp("slides")
    for name, phi in (("slips", 16), ("sticks", 40)):
        scree.run(CASES / "b1-slide" / "slope30.ana", output=folder / f"{name}.h5",
                  settings=[f"joint(1).phi={phi}", "step.count=400", "output.every=200", "contact.rules=coulomb", "deck.k01=1"])
    return folder


@pytest.mark.parametrize("edge", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("model", ["dda", "nmm"])
def test_vectors_are_those_of_the_centroids_and_crosses_the_principal_stresses(model, edge, tmp_path):
    (tmp_path / "s.geo").write_text(SQUARE.format(a=edge))
    (tmp_path / "s.ana").write_text(SHEARED.format(geometry="s.geo"))
    mesh = ["method.model=nmm", f"cover.edge={0.4 * edge}"] if model == "nmm" else []
    speed = [f"material(1).vx={0.2 * edge}", f"material(1).vy={-0.1 * edge}"]
    r = scree.run("s.ana", settings=["output.every=1", *mesh, *speed], cwd=tmp_path)
    file = frames(tmp_path / "s.h5")
    if model == "dda":
        np.testing.assert_allclose(overlays.displacements(file, 2), r.bodies.centroid[2] - r.bodies.centroid[0], atol=1e-12 * edge)
        np.testing.assert_allclose(overlays.velocities(file, 2), r.bodies.velocity[2], rtol=1e-9)
    area, centre = np.array([drawing.area_and_centroid(polygon)[0] for polygon in file.polygons(2)]), overlays.centroids(file, 2)
    assert len(area) == (1 if model == "dda" else len(file.start)) and (model == "dda" or len(area) > 5)
    np.testing.assert_allclose(centre, [drawing.area_and_centroid(polygon)[1] for polygon in file.polygons(2)], atol=1e-12 * edge)

    values, angle = overlays.principal_stresses(file, 0)
    for (xx, yy, xy), (major, minor), a in zip(r.stress(0), values, angle):
        true, axes = np.linalg.eigh([[xx, xy], [xy, yy]])
        assert (minor, major) == pytest.approx(tuple(true), rel=1e-9) and major > 0 > minor
        assert abs(axes[:, 1] @ [np.cos(a), np.sin(a)]) == pytest.approx(1, rel=1e-9)

    panel = drawing.draw_frames([file], ["0"], "major", [overlays.draw_crosses]).axes[0]
    for name, value, turned in (("tension", values[:, 0], 0), ("compression", values[:, 1], np.pi / 2)):
        bars = lines_of(panel, name)
        along = bars[:, 1] - bars[:, 0]
        assert 0 < len(bars) <= len(area)
        length, direction = np.linalg.norm(along, axis=1), np.array([np.cos(angle[0] + turned), np.sin(angle[0] + turned)])
        np.testing.assert_allclose(length, overlays.CROSS * 1.1 * edge * abs(value[0]) / abs(values).max(), rtol=1e-6)
        np.testing.assert_allclose(abs(along @ direction), length, rtol=1e-9)

    panel = drawing.draw_frames([file], ["last"], "major", [overlays.VECTORS["displacement"]]).axes[0]
    arrows, = [c for c in panel.collections if isinstance(c, Quiver)]
    moved = overlays.displacements(file, 3)
    drawn = np.column_stack([arrows.U, arrows.V])
    size = max(np.ptp(panel.get_xlim()), np.ptp(panel.get_ylim()))
    assert len(drawn) <= len(moved) and np.linalg.norm(drawn, axis=1).max() == pytest.approx(overlays.LONGEST * size, rel=0.05)
    factor = overlays.LONGEST * size / overlays.robust_limits(np.linalg.norm(moved, axis=1), 0.02)[1]
    for place, arrow in zip(np.column_stack([arrows.X, arrows.Y]), drawn):
        e = np.linalg.norm(overlays.centroids(file, 3) - place, axis=1).argmin()
        np.testing.assert_allclose(arrow, factor * moved[e], rtol=1e-9)


def test_a_block_that_slides_slips_one_that_stays_sticks_and_a_free_one_is_open(slides, tmp_path):
    for name, state in (("slips", "slip"), ("sticks", "stick")):
        file = frames(slides / f"{name}.h5")
        found = overlays.joint_states(file, len(file.times) - 1)
        assert {key for key, edges in found.items() if len(edges)} == {state}, name
        lengths = np.linalg.norm(found[state][:, 1] - found[state][:, 0], axis=1)
        slope = (found[state][:, 1] - found[state][:, 0]) / lengths[:, None]
        np.testing.assert_allclose(np.abs(slope[:, 1]), 0.5, atol=1e-3)  # along the plane alone
        np.testing.assert_allclose(lengths, 1, rtol=1e-3)  # what the block covers of it
        assert all(len(edges) == 0 for edges in overlays.joint_states(file, 0).values())  # not looked for yet
    scree.run(CASES / "b1-slide" / "slope30.ana", output=tmp_path / "up.h5",
              settings=["material(2).vx=-1", "material(2).vy=2", "step.count=50"])  # away from the plane
    found = overlays.joint_states(frames(tmp_path / "up.h5"), -1 % 51)
    assert [len(found[key]) for key in ("stick", "slip")] == [0, 0]
    own, of_plane = np.linalg.norm(np.diff(found["open"], axis=1), axis=2)  # of the plane, which is longer, what the block lay on
    assert own == pytest.approx(1, rel=1e-3) and of_plane == pytest.approx(1, rel=1e-3)


def test_a_part_of_a_joint_is_what_two_edges_have_of_each_other():
    edge = np.array([[0.0, 0], [4, 0]])
    for other, part in (([[3, 1e-3], [1, 0]], [0.25, 0.75]), ([[9, 0], [-9, 0]], [0, 1]), ([[6, 0], [2, 0]], [0.5, 1])):
        np.testing.assert_allclose(overlays.common_part(edge, np.array(other, float)), part, atol=1e-12)
    assert overlays.common_part(edge, np.array([[5.0, 0], [7, 0]])) is None


def test_a_corner_on_an_edge_is_a_short_piece(tmp_path):
    """A column that rocks on its corner: a piece of the floor where the corner is."""
    scree.run(CASES / "b10-rocking" / "tilt0.5.ana", output=tmp_path / "x.h5", settings=["step.count=20", "output.every=5"])
    file = frames(tmp_path / "x.h5")
    counts = file.file["contacts/count"]
    frame = int(np.flatnonzero(counts == 1)[0])
    found = overlays.joint_states(file, frame)
    piece, = [*found["slip"], *found["stick"]]
    place = file.file.contacts_of(frame).place[0]
    edge = min(np.linalg.norm(np.roll(file.start[1], -1, axis=0) - file.start[1], axis=1))
    np.testing.assert_allclose(piece.mean(0), place, atol=1e-9)
    assert np.linalg.norm(piece[1] - piece[0]) == pytest.approx(overlays.CORNER * edge, rel=1e-3)


def test_forces_of_contacts_bear_the_weight(slides):
    file = frames(slides / "sticks.h5")
    last = len(file.times) - 1
    contacts = file.file.contacts_of(last)
    signs = np.where(contacts.blocks[:, 0] == 2, 1, -1)[:, None]
    weight = 24525 * file.file.bodies.area[0, 1]
    np.testing.assert_allclose((signs * overlays.contact_forces(file, last)).sum(0), [0, weight], atol=2e-3 * weight)
    panel = drawing.draw_frames([file], ["last"], "block", [overlays.draw_contact_forces]).axes[0]
    bars = lines_of(panel, "force")
    np.testing.assert_allclose(bars.mean(1), contacts.place, atol=1e-9)
    along, force = bars[:, 1] - bars[:, 0], overlays.contact_forces(file, last)
    np.testing.assert_allclose(along[:, 0] * force[:, 1], along[:, 1] * force[:, 0], atol=1e-9 * weight)


def test_colours_leave_out_what_is_far_off_unless_told():
    values = np.append(np.linspace(0, 1, 199), 1e6)
    assert overlays.robust_limits(values) == (values[2], values[197])
    assert overlays.robust_limits(values[-50:]) == (values[-50], 1e6)  # of few all count
    look = drawing.Look()
    assert drawing.limits_of(values, "displacement", look)[:2] == (values[2], values[197])
    assert drawing.limits_of(values, "block", look)[:2] == (0, 1e6)
    assert drawing.limits_of(values, "displacement", drawing.Look(range=["full"]))[:2] == (0, 1e6)
    assert drawing.limits_of(values, "displacement", drawing.Look(range=[0.2, 0.3])) == (0.2, 0.3, "cividis")
    assert drawing.limits_of(np.array([-3.0, 1.0]), "major", look) == (-3, 3, "RdBu_r")  # white at zero
    assert drawing.limits_of(np.array([-3.0, 0.1]), "major", look) == (-3, 0.1, "cividis")
    assert drawing.limits_of(np.zeros(3), "major", look)[:2] == (0, 1)


def test_one_arrow_in_each_cell():
    class Size:
        size = 36.0
    places = np.random.default_rng(2).random((5000, 2)) * 36
    every = np.ones(len(places), bool)
    chosen = overlays.spread_out(places, every, Size)
    cells = np.floor(places[chosen])
    assert len(chosen) == len(np.unique(cells, axis=0)) == len(np.unique(np.floor(places), axis=0))
    assert list(overlays.spread_out(places[:1], every[:1], Size)) == [0]
    every[chosen] = False
    assert not set(chosen) & set(overlays.spread_out(places, every, Size))


def test_what_a_stage_has_removed_is_not_drawn(tmp_path):
    """Of two blocks on each other the lower is dug away: the foot of the upper one, which lay on it, is open; nothing else is."""
    deck = CASES / "s3-excavations" / "pillar.ana"
    file = frames(scree.run(deck, output=tmp_path / "pillar.h5").path)
    last = len(file.times) - 1
    gone = ~file.present(last)
    assert gone.sum() == 1 and file.present(0).all()
    edges, _, element = file.edges(last)
    assert len(edges) == len(element) and not gone[element].any()
    open_ = overlays.joint_states(file, last)["open"]
    lowest = min(polygon[:, 1].min() for polygon, there in zip(file.polygons(last), file.present(last)) if there and polygon[0, 1] > 0)
    assert len(open_) > 0 and open_[:, :, 1].max() < lowest + 1e-6
    common = overlays.Common([(file, last)], 10.0, drawing.Look().units)
    assert not gone[overlays.spread_out(overlays.centroids(file, last), file.present(last), common)].any()
    assert subprocess.run([TOOL, file.file.path, "--frames", "last", "--joints", "state", "--vectors", "--crosses", "-o", tmp_path / "x.png"],
                          capture_output=True).returncode == 0


def test_a_scale_is_a_round_number():
    assert [overlays.round_below(x) for x in (1.0, 1.9, 2.0, 4.99, 5, 9.9, 0.03, 3.1e6)] == [1, 1, 2, 2, 5, 5, 0.02, 2e6]


def test_lines_of_the_mesh_are_thin_or_none_and_the_window_is_what_was_asked_for(tmp_path):
    (tmp_path / "s.geo").write_text(SQUARE.format(a=1))
    (tmp_path / "s.ana").write_text(SHEARED.format(geometry="s.geo"))
    scree.run("s.ana", settings=["method.model=nmm", "cover.edge=0.4"], cwd=tmp_path)
    for look, width in ((None, 0.15), (drawing.Look(mesh=False), 1.0)):
        panel = drawing.draw_frames([frames(tmp_path / "s.h5")], ["0"], "major", (), look).axes[0]
        fill = next(c for c in panel.collections if isinstance(c, PathCollection))
        outline = lines_of(panel, [c for c in panel.collections if isinstance(c, LineCollection)][-1].get_label())
        assert np.linalg.norm(outline[:, 1] - outline[:, 0], axis=1).sum() == pytest.approx(4)
        assert fill.get_linewidths()[0] == width and (len(fill.get_edgecolors()) == 0) == (look is not None)
    panel = drawing.draw_frames([frames(tmp_path / "s.h5")], ["0"], "major", (), drawing.Look(window=[0.1, 0.2, 0.5, 0.4])).axes[0]
    assert panel.get_xlim() == (0.1, 0.5) and panel.get_ylim() == (0.2, 0.4)


def test_the_commands_of_the_manual_make_pictures(slides, tmp_path):
    for words in (["--joints", "state", "--vectors"], ["--joints", "forces", "--crosses", "--frames", "last"],
                  ["--vectors", "velocity"],
                  ["--field", "minor", "--range", "full", "--no-mesh", "--colours", "viridis", "--window", "-1", "-1", "2", "2"]):
        done = subprocess.run([TOOL, slides / "slips.h5", *words, "--dpi", "40", "-o", tmp_path / "p.png"], capture_output=True,
                              text=True)
        assert done.returncode == 0, done.stderr
        assert 150 < image.imread(tmp_path / "p.png").shape[1] < 400  # 5 to 9 inches


def test_what_cannot_be_drawn_is_one_line(slides, tmp_path):
    (tmp_path / "s.geo").write_text(SQUARE.format(a=1))
    (tmp_path / "s.ana").write_text(SHEARED.format(geometry="s.geo"))
    for words, expected in (
            ([tmp_path / "s.geo", "--vectors"], "results file for --vectors"), ([tmp_path / "s.geo", "--crosses"], "for --crosses"),
            ([tmp_path / "s.ana", "--joints", "state"], "run with contacts"),
            ([slides / "slips.h5", "--range", "2", "1"], "LOW HIGH"), ([slides / "slips.h5", "--range", "a"], "LOW HIGH"),
            ([slides / "slips.h5", "--range", "0", "inf"], "LOW HIGH, finite, or full, found 0 inf"),
            ([slides / "slips.h5", "--window", "1", "0", "0", "1"], "X1 below X2"),
            ([slides / "slips.h5", "--window", "0", "0", "inf", "1"], "X1 below X2"),
            ([slides / "slips.h5", "--window", "100", "100", "101", "101"], "a part of what is drawn, which is from ("),
            ([slides / "slips.h5", "--dpi", "0"], "from 10 to 2000")):
        done = subprocess.run([TOOL, *words, "--scree", SCREE, "-o", tmp_path / "p.png"], capture_output=True, text=True)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr
    with pytest.raises(PlotError):
        overlays.results_of(object.__new__(type("Geometry", (), {"name": "x"})), "--vectors")


def test_magnified_displacements_move_all_that_is_drawn(slides):
    """Blocks, centroids and points are as many times as far from where they began; states of joints are the same, on edges as drawn."""
    file, large = frames(slides / "sticks.h5"), frames(slides / "sticks.h5")
    large.magnified, last = 1e4, len(file.times) - 1
    for what in (lambda f, k: f.vertices(k), lambda f, k: np.vstack(f.polygons(k)), overlays.centroids, lambda f, k: f.points(k)[1]):
        start, now, far = what(file, 0), what(file, last), what(large, last)
        np.testing.assert_allclose(far - start, 1e4 * (now - start), atol=1e-8)
    assert np.abs(large.vertices(last) - file.vertices(0)).max() > 1e-3
    for name, parts in overlays.joint_states(file, last).items():
        far = overlays.joint_states(large, last)[name]
        assert len(far) == len(parts)
        edges = large.edges(last)[0]
        for part in far:  # on an edge as drawn
            side = edges[:, 1] - edges[:, 0]
            off = [np.abs(side[:, 0] * (end - edges[:, 0])[:, 1] - side[:, 1] * (end - edges[:, 0])[:, 0]) / (side ** 2).sum(1) for end in part]
            assert np.max(off, axis=0).min() < 1e-9
    np.testing.assert_array_equal(overlays.displacements(large, last), overlays.displacements(file, last))  # numbers stay
    panel = drawing.draw_frames([large], ["last"], "block", (), drawing.Look(magnify=1e4)).axes[0]
    assert panel.get_title() == f"t = {file.times[last]:.6g}, displacements × 10000"
    bars = lines_of(drawing.draw_frames([large], ["last"], "block", [overlays.draw_contact_forces], drawing.Look(magnify=1e4)).axes[0], "force")
    np.testing.assert_allclose(bars.mean(1), large.vertices(last)[overlays.vertices_of_contacts(large, last)], atol=1e-9)
