"""tools/film: as many frames as the run has, the scene in them, one set of colours; and what is missing is said."""
import os
import pathlib
import stat
import subprocess

import h5py
import numpy as np
import pytest
import scree
from PIL import Image
from scree import drawing, filming

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOL = SOURCE / "tools" / "film"
FALL = SOURCE / "input" / "paper" / "rockfall" / "rockfall.ana"


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """A rock that falls for 0.2 s, 11 frames."""
    path = tmp_path_factory.mktemp("film") / "fall.h5"
    scree.run(FALL, output=path, settings=["step.end_time=0.2", "output.interval=0.02"])
    return path


def call(*words, path=None):
    return subprocess.run([TOOL, *words], capture_output=True, text=True, env=os.environ | ({"PATH": path} if path else {}))


def pictures(path):
    """The frames of a GIF, as arrays."""
    with Image.open(path) as gif:
        found = []
        for frame in range(gif.n_frames):
            gif.seek(frame)
            found.append(np.asarray(gif.convert("RGB"), int))
        return found, gif.info["duration"]


def test_a_film_shows_the_rock_where_it_is(run, tmp_path):
    """Its yellow is the colour of block 2 of 2; the height of its middle falls as that of the block in the results."""
    done = call(run, "-o", tmp_path / "f.gif", "--fps", "10", "--dpi", "100", "--field", "block", "--window", "0", "0.2", "0.4", "0.6")
    assert done.returncode == 0 and done.stdout == f"{tmp_path / 'f.gif'}\n", done.stderr
    found, duration = pictures(tmp_path / "f.gif")
    centroid = scree.read(run).bodies.centroid[:, 1, 1]
    assert len(found) == len(centroid) == 11 and duration == 100
    height = []
    for picture in found:
        panel = picture[:, :int(0.8 * picture.shape[1])]  # without the bar of colours
        yellow = (panel[..., 0] > 220) & (panel[..., 1] > 200) & (panel[..., 2] < 110)
        assert yellow.sum() > 200
        height.append(-np.argwhere(yellow)[:, 0].mean())
    fit = np.polyfit(centroid, height, 1)
    assert np.ptp(height) > 50 and np.abs(np.polyval(fit, centroid) - height).max() < 2  # pixels
    assert len({picture.tobytes() for picture in found}) == 11


def test_each_nth_frame_with_all_that_is_drawn_over(run, tmp_path):
    for words in (["--joints", "state", "--vectors", "velocity", "--field", "minor"],
                  ["--joints", "forces", "--crosses", "--points"]):
        done = call(run, "-o", tmp_path / "f.gif", "--every", "5", "--dpi", "40", *words)
        assert done.returncode == 0, done.stderr
        assert len(pictures(tmp_path / "f.gif")[0]) == 3


def test_colours_and_scales_are_those_of_all_frames(run):
    file = drawing.Frames(run, "fall")
    panels = drawing.Panels([file], [(file, frame) for frame in range(11)], "displacement", (), drawing.Look(range=["full"]))
    figure, axes = panels.figure(1, 1, 4.0)
    for frame in (0, 10):
        assert panels.draw(axes[0, 0], file, frame)[0].get_clim() == (0, max(file.values(10, "displacement")[0]))
        assert len(axes[0, 0].collections) == (1 if frame == 0 else 2)  # with the outlines of the start
        filming.clear(axes[0, 0])
        assert not axes[0, 0].collections
    assert figure.get_axes() == [axes[0, 0]]


def test_an_mp4_is_what_ffmpeg_is_given(run, tmp_path):
    """By a program that keeps what it is given, in place of ffmpeg: raw frames of the size that it is told."""
    (tmp_path / "bin").mkdir()
    stand_in = tmp_path / "bin" / "ffmpeg"
    stand_in.write_text('#!/bin/sh\n[ "$1" = -version ] && exit\nfor last; do :; done\necho "$@" > "$(dirname "$last")/words"\ncat > "$last"\n')
    stand_in.chmod(stand_in.stat().st_mode | stat.S_IEXEC)
    done = call(run, "-o", tmp_path / "f.mp4", "--dpi", "40", "--fps", "25", path=f"{tmp_path / 'bin'}:{os.environ['PATH']}")
    assert done.returncode == 0, done.stderr
    words = (tmp_path / "words").read_text().split()
    wide, tall = map(int, words[words.index("-s") + 1].split("x"))
    rate = "-framerate" if "-framerate" in words else "-r"  # of matplotlib from 3.8 on, and before
    assert wide % 2 == tall % 2 == 0 and float(words[words.index(rate) + 1]) == 25  # H.264 wants even sizes
    assert (tmp_path / "f.mp4").stat().st_size == 11 * 4 * wide * tall


def test_what_cannot_be_filmed_is_one_line(run, tmp_path):
    (tmp_path / "bin").mkdir()
    (tmp_path / "x.geo").write_text("")
    with h5py.File(tmp_path / "other.h5", "w") as f:
        f["x"] = 1
    for words, expected in (([run, "-o", tmp_path / "f.avi"], "the ending .mp4 or .gif"), ([tmp_path / "none.h5"], "found"),
                            ([run, "-o", tmp_path / "f.mp4"], "apt-get install ffmpeg, or give a name with .gif"),
                            ([tmp_path / "other.h5"], "another HDF5 file"), ([tmp_path / "x.geo"], "expected a results file"),
                            ([run, "-o", tmp_path / "no" / "f.gif"], "cannot write"),
                            ([run, "--covers", "-o", "f.gif"], "manifold elements"),
                            ([run, "--fps", "0"], "above 0"), ([run, "--every", "0"], "from 1")):
        done = subprocess.run(["/usr/bin/python3", "-B", TOOL, *words], capture_output=True, text=True, cwd=tmp_path,
                              env={**os.environ, "PATH": str(tmp_path / "bin")})
        assert done.returncode == 2 and expected in done.stderr.splitlines()[-1] and "Traceback" not in done.stderr, done.stderr
    assert not list(tmp_path.glob("*.gif"))
