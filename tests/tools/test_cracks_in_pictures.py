"""Cracks in pictures and reports: each frame has the faces that it had, and marks where tips are."""
import os
import pathlib
import subprocess

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
import scree
from browser import CHROMIUM, WITHOUT, Browser
from scree import drawing, overlays, rose, tips
from scree.pages import modelled
from scree.units import Units

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
GROWTH = SOURCE / "input/validation/k2-growth"
RUNS = {"pulled": (GROWTH / "inclined.ana", ["cover.edge=0.1", "step.count=5"]), "closed": (GROWTH / "closed.ana", ["cover.edge=0.1", "step.count=4"]),
        "breaking": (SOURCE / "input/examples/breaking/breaking.ana", ["step.count=32", "output.every=8"])}


@pytest.fixture(scope="module", params=RUNS)
def file(request, tmp_path_factory):
    """The frames of a run in which cracks grow."""
    deck, settings = RUNS[request.param]
    path = tmp_path_factory.mktemp(request.param) / f"{request.param}.h5"
    scree.run(deck, output=path, settings=settings)
    return drawing.Frames(path, request.param)


def own_sides(file, frame):
    """Sides of the elements that a frame has in the file (n, 2, 2), without those of the last layout, and their joint material."""
    layouts = file.file._layouts
    k = layouts.of_frame[frame]
    with h5py.File(file.file.path) as f:
        points = f["VTKHDF/Points"][layouts.rows("points", frame)][:, :2]
        corner = f["VTKHDF/Connectivity"][layouts.corners_of_layout(k)]
        first = layouts.cells[:k].sum() + k
        ends = f["VTKHDF/Offsets"][first:first + layouts.cells[k] + 1]
        joint = f["elements/joint"][layouts.corners_of_layout(k)]
    polygons = [points[corner[a:b]] for a, b in zip(ends, ends[1:])]
    return np.concatenate([np.stack([p, np.roll(p, -1, axis=0)], axis=1) for p in polygons]), joint


def length(sides):
    return np.linalg.norm(sides[:, 1] - sides[:, 0], axis=1).sum()


def test_each_frame_has_the_faces_and_the_mesh_that_it_had(file):
    grown = []
    for frame in range(len(file.times)):
        sides, joint = own_sides(file, frame)
        faces, lines = file.edges(frame)[0], file.places(file.mesh_lines(frame), frame)
        assert length(faces) == pytest.approx(length(sides[joint > 0]), rel=1e-9)
        assert length(lines) == pytest.approx(length(sides[joint == 0]), rel=1e-9)
        grown.append(len(faces))
    assert grown[-1] > grown[0]


def test_a_frame_before_growth_has_no_part_of_a_later_face(file):
    first, last = (set(file.faces(frame)) for frame in (0, len(file.times) - 1))
    later = np.array(sorted(last - first))
    assert first < last
    drawn = set(file.faces(0)) | set(file.mesh_lines(0))
    sides = own_sides(file, 0)[0]
    for row, place in zip(later, file.places(later, 0).mean(axis=1)):
        p, way = sides[:, 0], sides[:, 1] - sides[:, 0]
        share = np.clip(((place - p) * way).sum(1) / (way**2).sum(1), 0, 1)
        on_a_side = np.linalg.norm(p + share[:, None] * way - place, axis=1).min() < 1e-9
        assert (row in drawn) == on_a_side  # as a line of the mesh, which the crack follows later


def test_pictures_mark_tips_where_the_run_has_them(file):
    common = overlays.Common([(file, 0)], 1.0)
    has_tips = "cracks" in file.file.history
    for frame in range(len(file.times)):
        axis = plt.figure().gca()
        entries = tips.draw_tips(axis, file, frame, common)
        if not has_tips or frame == 0:
            assert not entries and not axis.lines
        else:
            cracks, step = file.file.history.cracks, file.file.frame_steps[frame] - 1
            there = cracks.length[step] > 0
            assert axis.lines[0].get_xydata() == pytest.approx(cracks.place[step][there], abs=1e-9)
            words = [text.get_text() for text in axis.texts]
            expected = [f"$K_I$ {k:.3g}" if k else "not measured" for k in cracks.K_I[step][there]]
            assert len(words) == there.sum() and all(one in word for one, word in zip(expected, words))
        plt.close("all")


def test_a_rose_has_the_directions_in_which_cracks_grew(file):
    """And the report their lengths: both are those of the faces that the last frame has and the first one has not."""
    angle, grown = rose.growth_directions(file)
    later = sorted(set(file.faces(len(file.times) - 1)) - set(file.faces(0)))
    assert grown.sum() == pytest.approx(length(file.places(np.array(later), 0)) / 2, rel=1e-6)
    assert ((angle >= 0) & (angle < 180)).all()
    labels = rose.draw_rose(file, Units()).axes[0].get_legend_handles_labels()[1]
    assert labels[-1] == "cracks that grew"
    rows = dict(modelled.growth_rows(file.file, Units()))
    assert list(rows) == [f"growth of crack tip {tip}" for tip in np.unique(file.file.growth.tip)]
    assert sum(float(words.split()[0]) for words in rows.values()) == pytest.approx(grown.sum(), rel=1e-3)
    plt.close("all")


def test_marks_go_with_magnified_displacements(file):
    last, common = len(file.times) - 1, overlays.Common([(file, 0)], 1.0)
    if "cracks" not in file.file.history:
        return
    file.magnified = 1000.0
    try:
        axis = plt.figure().gca()
        tips.draw_tips(axis, file, last, common)
        corners = np.vstack(file.polygons(last))
        nearest = [np.linalg.norm(corners - place, axis=1).min() for place in axis.lines[0].get_xydata()]
        assert max(nearest) < 0.1  # within an edge of the mesh
    finally:
        file.magnified = 1.0
        plt.close("all")


def test_states_of_joints_are_known_in_all_frames(file):
    """Also in those of a block that a part breaks off later, whose contacts name the block of that frame."""
    for frame in range(len(file.times)):
        if file.file.contacts_of(frame) is not None:
            parts = overlays.joint_states(file, frame)
            contacts = file.file.contacts_of(frame)
            assert (len(parts["stick"]) + len(parts["slip"]) > 0) == (len(contacts) > 0)


def test_a_block_has_its_number_of_the_frame(file):
    there = [np.unique(file.file.blocks(frame)) for frame in range(len(file.times))]
    assert len(there[0]) == 1 and len(there[-1]) == len(np.unique(file.file.block)) == (2 if file.name == "breaking" else 1)
    assert all(np.array_equal(np.unique(file.values(frame, "block")[0]), blocks) for frame, blocks in enumerate(there))


@pytest.mark.skipif(CHROMIUM is None, reason=WITHOUT)
def test_a_report_has_faces_and_tips_by_frame(file):
    assert subprocess.run([SOURCE / "tools/report", file.file.path], capture_output=True).returncode == 0
    with Browser() as browser:
        browser.open(file.file.path.with_suffix(".html"))
        origin = np.array(browser.evaluate("player.scene.origin"))
        for frame in range(len(file.times)):
            every = "[...player.scene.edge_face.keys()].filter"
            assert browser.evaluate(f"{every}(i => player.scene.isFace({frame}, i))") == file.faces(frame).tolist()
            assert browser.evaluate(f"{every}(i => player.scene.isMeshLine({frame}, i))") == file.mesh_lines(frame).tolist()
            found = browser.evaluate(f"player.scene.tips[{frame}].map(tip => player.scene.placeOf(tip, player.scene.positions({frame}, 1)))")
            expected = [tip.weights @ file.polygons(frame)[tip.element] for tip in tips.tips_of(file, frame)]
            np.testing.assert_allclose(np.reshape(found, (-1, 2)) + origin, np.reshape(expected, (-1, 2)), atol=1e-6)
            browser.choose("frame", frame)
        assert not browser.problems
