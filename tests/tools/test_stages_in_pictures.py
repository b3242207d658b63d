"""Stages in pictures and films: their frames, and displacements counted as they count them."""
import os
import pathlib
import subprocess

import numpy as np
import pytest
import scree
from PIL import Image
from scree import drawing
from scree.errors import PlotError
from scree.pages import facts
from scree.pages.frames import pack_frames
from scree.pages.packing import Pack
from scree.units import Units

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOLS = SOURCE / "tools"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Four stages, two static and two dynamic; the last counts displacements anew, and the third has removed a block."""
    return scree.run(SOURCE / "tests/data/stages/stages.ana", output=tmp_path_factory.mktemp("stages") / "s.h5",
                     settings=["output.every=10"])


@pytest.fixture(scope="module")
def slide(tmp_path_factory):
    """A run without stages."""
    return scree.run(SOURCE / "input/validation/b1-slide/slope30.ana", output=tmp_path_factory.mktemp("slide") / "d.h5",
                     settings=["step.count=20", "output.every=10"])


def test_each_frame_has_its_stage(run, slide):
    assert run.stage_names == ["stage 1", "loaded", "dug", "free"] and slide.stage_names == []
    last = [int(np.flatnonzero(run.frame_stages == k)[-1]) for k in (1, 2, 3, 4)]
    assert run.frame_stages[0] == 1 and (np.diff(run.frame_stages) >= 0).all() and last[-1] == run.n_frames - 1
    steps = run.frame_steps[last]
    assert list(run.history.stage[steps - 1]) == [1, 2, 3, 4] and list(run.history.stage[steps[:-1]]) == [2, 3, 4]  # their ends
    assert list(slide.frame_stages) == [1, 1, 1] and not slide.is_static()
    assert [run.is_static(frame) for frame in last] == [True, True, False, False]


def test_displacements_count_from_a_frame(run, slide):
    """From each place less its displacement, of what is still there, to the digits of places."""
    for results in (run, slide):
        for frame in range(results.n_frames):
            there = np.concatenate([corners for corners, kept in zip(results.corners(), results.present(frame)) if kept])
            began = (results.vertices(frame) - results.displacement(frame))[there]
            np.testing.assert_allclose(began, results.vertices(results.counted_from(frame))[there], atol=1e-13)
    assert {results.counted_from(k) for k in range(results.n_frames)} == {0} and run.counted_from(-1) > 0
    file = drawing.Frames(run.path, "s")
    file.magnified = 5
    began, there = run.vertices(run.counted_from(-1)), run.corners()[1]
    np.testing.assert_allclose((file.vertices(run.n_frames - 1) - began)[there], 5 * run.displacement(-1)[there], atol=1e-12)


def test_panels_are_the_ends_of_stages(run):
    file = drawing.Frames(run.path, "s")
    figure = drawing.draw_frames([file], None, "block", stages=["all"])
    steps = run.frame_steps
    ends = [int(steps[run.frame_stages == k][-1]) for k in (1, 2)]
    assert [axis.get_title() for axis in figure.axes[:4]] == [f"stage 1, step {ends[0]}", f"loaded, step {ends[1]}", "dug, t = 0.3",
                                                              "free, t = 0.6"]
    grey = [axis.collections[0] for axis in figure.axes[:4]]  # outlines where displacements count from
    began = [[path.vertices[:-1] for path in collection.get_paths() if len(path.vertices)] for collection in grey]
    for places, since in zip(began, (0, 0, 0, run.counted_from(-1))):
        true = [polygon for polygon, there in zip(run.polygons(since), run.present(since)) if there]
        assert len(places) == len(true) and all(np.array_equal(a, b) for a, b in zip(places, true))
    assert len(began[2]) == 3 and len(began[3]) == 2  # what a stage removes shows where it was


@pytest.mark.parametrize("words, ends", [(["2", "free"], [2, 4]), (["dug"], [3])])
def test_a_stage_has_a_number_and_a_name(run, words, ends):
    file = drawing.Frames(run.path, "s")
    assert drawing.ends_of_stages(file, words) == [int(np.flatnonzero(run.frame_stages == k)[-1]) for k in ends]


def test_a_stage_that_is_none_is_one_line(run, slide):
    for path, words, expected in ((run.path, ["5"], "3 (dug), 4 (free); found '5'"), (run.path, ["quarry"], "found 'quarry'"),
                                  (slide.path, ["1"], "a run with stages"), (slide.path, ["all"], "a run with stages"),
                                  (SOURCE / "input/validation/b1-slide/slope30.blk", ["1"], "a run with stages"),
                                  (run.path, ["1", "--frames", "2"], "not allowed with")):
        done = subprocess.run([TOOLS / "plot", path, "--stage", *words], capture_output=True, text=True)
        assert done.returncode == 2 and expected in done.stderr.splitlines()[-1] and "Traceback" not in done.stderr
    with pytest.raises(PlotError, match="found 'x'"):
        drawing.frames_of_stage(drawing.Frames(run.path, "s"), "x")


def test_no_time_passes_in_static_stages_before_dynamic_ones(run, slide):
    """The clock of the run stands in them, and runs as its steps do in the others. A table of a stage is read at its time since the stage
    began, so the clock of the first dynamic stage is the time of its tables."""
    static, sizes = run.history.stage < 3, np.diff(run.history.time, prepend=0)
    assert sizes[static].sum() > 0.1 and not run.clock[static].any()
    np.testing.assert_allclose(np.diff(run.clock)[~static[1:]], sizes[~static], atol=1e-13)
    begun = run.history.time[static][-1]
    np.testing.assert_allclose(run.clock[~static], run.history.time[~static] - begun, atol=1e-13)
    assert [words[-1] for words in facts.stage_rows(run, Units("mm=1e-3,kPa=1e3,ms=1e-3"))][:2] == ["", ""]
    assert np.array_equal(slide.clock, slide.history.time)


def test_a_film_of_a_stage_has_its_frames(run, tmp_path):
    done = subprocess.run([TOOLS / "film", run.path, "--stage", "dug", "-o", tmp_path / "f.gif", "--dpi", "40"], capture_output=True,
                          text=True)
    assert done.returncode == 0, done.stderr
    with Image.open(tmp_path / "f.gif") as gif:
        assert gif.n_frames == np.sum(run.frame_stages == 3)


def test_a_model_as_set_up_and_a_static_run_have_no_time(tmp_path):
    """No time passes in a static run: its steps count."""
    model = scree.cut(SOURCE / "tests/data/stages/stages.ana", output=tmp_path / "m.h5")
    assert drawing.Look().title(drawing.Frames(model, "m"), 0) == "as set up"
    still = scree.run(SOURCE / "input/validation/b1-slide/slope30.ana", output=tmp_path / "still.h5",
                      settings=["deck.k01=0", "joint(1).phi=35", "step.balance=1e-6"])
    assert drawing.Look().title(drawing.Frames(still.path, "s"), still.n_frames - 1) == f"step {len(still.history.time)}"


def test_histories_of_a_static_run_are_drawn_along_its_steps(run, slide, tmp_path):
    """Those of a run that has dynamic stages, too, along its time, and files together along time where it passes in one of them."""
    still = scree.run(SOURCE / "input/validation/b1-slide/slope30.ana", output=tmp_path / "still.h5",
                      settings=["deck.k01=0", "joint(1).phi=35", "step.count=20", "output.every=5"])
    units, steps = Units("mm=1e-3,kPa=1e3,ms=1e-3"), np.arange(1, 21)
    for files, label, along in (([still], "step", steps), ([run], "time [ms]", 1e3 * run.clock),
                                ([still, slide], "time [ms]", 1e3 * still.history.time)):
        axis, = drawing.draw_histories([file.path for file in files], ["energy/kinetic"], units).axes
        assert axis.get_xlabel() == label
        np.testing.assert_allclose(axis.lines[0].get_xdata(), along, rtol=1e-12)
    assert all(chart["steps"] == list(steps) for chart in facts.charts(still, units))
    assert pack_frames(drawing.Frames(still.path, "still"), Pack(), units)["steps"] == [0, 5, 10, 15, 20]
    for file, label in ((still, "step"), (run, "time [ms]")):
        words = [file.path, "-o", tmp_path / "page.html", "--units", "mm=1e-3,kPa=1e3,ms=1e-3"]
        subprocess.run([TOOLS / "report", *words], check=True)
        assert f"Along the axis: {label}. Click" in (tmp_path / "page.html").read_text()
