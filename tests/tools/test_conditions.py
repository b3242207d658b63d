"""Pictures and reports for a client: what acts on the rock, rock and joints by name, bolts by force, results before the solver."""
import os
import pathlib
import re
import subprocess

import numpy as np
import pytest
import scree
from matplotlib.collections import LineCollection
from matplotlib.colors import to_hex
from matplotlib.quiver import Quiver
from scree.conditions import draw_bolts, draw_conditions
from scree.drawing import JOINT_COLOURS, ROCKS, Frames, draw_frames
from scree.in_force import Explained, numbers, settings_of_frame

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])


def bench():
    """A bench of two rocks in a box, under water, with a load in its second stage and a bolt."""
    m = scree.Model("bench", title="A bench of two rocks. More words.")
    m.material("granite", density=2600, young=1e10)
    m.material("clay", density=2000, young=1e9)
    m.joint_material("bedding", phi=40)
    m.joint_material("contact", phi=35)
    m.rock([(0, 0), (20, 0), (20, 10), (0, 10)], material="granite")
    m.joint("bedding", [(0, 4), (20, 4)])
    m.joint("contact", [(0, 7), (20, 7)])
    m.region([(-1, 7), (21, 7), (21, 11), (-1, 11)], material="clay")
    m.support("floor", [(0, 0), (20, 0)])
    m.support("left", [(0, 0), (0, 10)], hold="normal")
    m.support("right", [(20, 0), (20, 10)], hold="normal")
    m.water([(0, 6), (20, 5)])
    m.measure("top", (10, 9.9))
    m.measure("foot", (10, 0.1))
    m.bolt("anchor", (5, 9.5), (5, 1), stiffness=1e7, pretension=2e4)
    m.bolt("second", (15, 9.5), (15, 1), stiffness=1e7, pretension=8e4)
    m.static()
    m.stage("fill")
    m.load("fill", [(0, 10), (20, 10)], pressure=[1e4, 5e4])
    return m


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    return bench().run(tmp_path_factory.mktemp("bench") / "bench.h5")


def drawn(results, frame, *extras):
    figure = draw_frames([Frames(results.path, "bench")], [str(frame)], "material", extras)
    axis = figure.axes[0]
    return axis, {text.get_text() for text in axis.get_legend().get_texts()}


def test_what_acts_is_drawn_in_its_stage(results):
    """Water is a line between its points; the load of a stage is not there before it."""
    axis, words = drawn(results, 0, draw_conditions)
    water = next(line for line in axis.lines if line.get_label() == "_water" and len(line.get_xdata()) > 1)
    assert np.interp([0, 10, 20], *water.get_data()) == pytest.approx([6, 5.5, 5])
    assert {"water table", "fixed support", "roller support", "granite", "clay"} <= words and not any("load" in one for one in words)
    axis, words = drawn(results, -1, draw_conditions)
    assert any(one.startswith("load, at most 50 000") or one.startswith("load, at most 5e+04") for one in words)
    arrows = next(one for one in axis.collections if isinstance(one, Quiver))
    assert (arrows.V < 0).all() and np.abs(arrows.U).max() < 1e-2 * np.abs(arrows.V).max()
    order = np.argsort(arrows.X)
    assert (np.diff(arrows.V[order]) < 0).all()  # the larger to the right


def test_supports_stand_outside_of_the_rock(results):
    axis, _ = drawn(results, 0, draw_conditions)
    circles = np.concatenate([line.get_xydata() for line in axis.lines if line.get_label() == "_roller support"])
    assert ((circles[:, 0] < 0) | (circles[:, 0] > 20)).all() and {-1, 1} == set(np.sign(circles[:, 0] - 10))
    strokes = next(one for one in axis.collections if one.get_label() == "fixed support")
    assert all(path.vertices[1, 1] < path.vertices[0, 1] <= 1e-9 for path in strokes.get_paths())


def test_bolts_are_the_wider_the_larger_their_force(results):
    axis, words = drawn(results, -1, draw_bolts)
    bolts = next(one for one in axis.collections if isinstance(one, LineCollection) and to_hex(one.get_edgecolor()[0]) == to_hex("crimson"))
    force = results.bolts.force[-1]
    widths = bolts.get_linewidths()
    assert force[1] > 2 * force[0] > 0 and widths[1] == pytest.approx(3.4) and widths[0] == pytest.approx(0.8 + 2.6 * force[0] / force[1])
    assert any(one.startswith("bolt, at most") for one in words)


def test_a_picture_without_a_field_has_rock_joints_and_what_acts(results, tmp_path):
    """The same of a deck as of results; never a colour for each block."""
    deck = bench().save(tmp_path / "bench.ana")
    for path in (deck, results.path):
        done = subprocess.run([SOURCE / "tools" / "plot", path, "--frames", "first", "-o", tmp_path / "p.svg"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        text = (tmp_path / "p.svg").read_text()
        assert all(colour in text for colour in (*ROCKS[:2], to_hex(JOINT_COLOURS[0]), to_hex(JOINT_COLOURS[1])))
        assert all(f"<!-- {word} -->" in text for word in ("granite", "clay", "bedding", "contact", "water table", "fixed support"))


def test_settings_in_force(results, tmp_path):
    first, last = settings_of_frame(results, 0), settings_of_frame(results, -1)
    assert numbers(first, "boundary.lines") == [] and numbers(last, "boundary.pressure") == [1e4, 5e4]
    assert numbers(first, "water.table") == numbers(last, "water.table") == [0, 6, 20, 5]
    said = Explained(scree.call("explain", bench().save(tmp_path / "bench.ana")).stdout)
    assert said.names == ["stage 1", "fill"] and said.kinds == ["static", "static"] and said.joints == [(40, 0, 0), (35, 0, 0)]
    assert numbers(said.stages[1], "boundary.pressure") == [1e4, 5e4] and numbers(said.stages[1], "water.unit_weight") == [9810]


def test_a_report_begins_with_results(results, tmp_path):
    """Measured points, closure, bolts, reactions; then what is modelled, with units; the solver is folded."""
    page = scree.report(results, tmp_path / "p.html", project="A client", note="A note.").read_text()
    shown, folded = page[page.index("<header>"):].split('<details id="solver">')
    text = re.sub(r"<[^>]+>", " ", shown)
    words = re.sub(r"\s+", " ", text)
    assert "<h1>A bench of two rocks</h1>" in shown and "A client" in words and "A note." in words
    places = [words.index(one) for one in ("displacement of top", "closure between top and foot", "bolts at most", "reaction of floor",
                                           "What is modelled", "3 blocks, 20 m × 10 m, plane strain", "joint bedding friction 40°")]
    assert places == sorted(places)
    bears = 9.81 * (2600 * 140 + 2000 * 60) + 3e4 * 20 - 9810 * 5.5 * 20  # rock, load, uplift
    assert float(re.search(r"reaction of floor \(.*?, (\S+) N/m\)", words)[1]) == pytest.approx(bears, rel=1e-3)
    assert "E = " in words and "Pa" in words and "solves" not in words and "solves" in folded


@pytest.mark.parametrize("dpi", [50, 70, 150])
def test_a_legend_is_as_wide_as_its_panel_allows(results, dpi, tmp_path):
    """All that acts, states of joints and vectors make a long legend: no part of it is beside the picture."""
    axis = scree.plot(results, "displacement", joints="state", vectors="displacement", conditions=True)
    axis.figure.savefig(tmp_path / "bench.png", dpi=dpi)
    axis.figure.set_dpi(dpi)
    axis.figure.draw_without_rendering()
    legend = axis.get_legend().get_window_extent()
    assert len(axis.get_legend().get_texts()) > 6 and legend.x0 > 0 and legend.x1 < axis.figure.bbox.width


def test_rock_below_joints_has_the_names_of_its_materials(results):
    axis = scree.plot(results, "material", joints="state")
    assert {"granite", "clay"} <= {text.get_text() for text in axis.get_legend().get_texts()} and len(axis.figure.axes) == 1


def test_a_report_names_what_acts_and_counts_blocks_that_are_there(tmp_path):
    """A block without weight that a support pushes, and one that a stage removes."""
    from scree.pages.modelled import modelled_rows
    from scree.units import Units

    m = scree.Model("pushed", title="A block that is pushed.")
    m.material("rock", density=2600, young=1e9, unit_weight=0)
    m.joint_material("joint", phi=30)
    m.rock([(0, 0), (1, 0), (1, 1), (0, 1)], material="rock")
    m.rock([(3, 0), (4, 0), (4, 1), (3, 1)], material="rock")
    m.support("left", [(0, 0), (0, 1)], velocity=(0.1, 0))
    m.dynamic(0.01, 0.001)
    m.stage("later", kind="dynamic")
    m.dynamic(0.01, 0.001)
    m.excavate([(2.9, -0.1), (4.1, -0.1), (4.1, 1.1), (2.9, 1.1)])
    rows = dict(modelled_rows(m.run(tmp_path / "pushed.h5"), Units()))
    assert rows["what acts"] == "moved supports" and rows["model"].startswith("2 blocks, 1 at the end, 4")
