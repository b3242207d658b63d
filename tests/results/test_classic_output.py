"""The classic output (doc/results.md): its layout, row by row, and what it holds of a run that dies."""
import os
import pathlib
import subprocess
import time

import h5py
import numpy as np
import pytest
from scree.block_files import block_file, box

SCREE = os.environ["SCREE"]
DATA = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tests" / "data" / "classic"


def run(geometry, analysis, out, *settings):
    words = [word for setting in settings for word in ("--set", setting)]
    done = subprocess.run([SCREE, "run", geometry, analysis, "-o", out, "--quiet", "--classic-output", *words],
                          capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out.with_suffix(".replay")


def parts(path):
    """Head, blocks, and vertex rows and point rows of each frame, as the layout says; what follows is left over."""
    lines = path.read_text().splitlines()
    n, n_blocks, n_bolts, oo = map(int, lines[0].split())
    kinds = list(map(int, lines[1].split()))
    blocks = [tuple(map(int, line.split())) for line in lines[2:3 + n_blocks]]
    at, frames = 3 + n_blocks, []
    for _ in range(n):
        rows = np.array([list(map(float, line.split())) for line in lines[at:at + oo + 1]])
        at += oo + 1
        points = np.array([list(map(float, line.split())) for line in lines[at:at + sum(kinds) + 1]])
        at += sum(kinds) + 1
        frames.append((rows, points))
    return (n, n_blocks, n_bolts, oo), kinds, blocks, frames, lines[at:]


@pytest.fixture(scope="module")
def stack(tmp_path_factory):
    out = tmp_path_factory.mktemp("stack") / "s.h5"
    return run(DATA / "stack5.geo", DATA / "stack5_dyn.ana", out, "step.end_time=0.05", "output.every=1")


def test_the_layout_is_that_of_the_classic_replay(stack):
    head, kinds, blocks, frames, left = parts(stack)
    assert head == (11, 6, 0, 48) and kinds == [3, 0, 5] and not left
    assert blocks == [(0, 0, 0)] + [(1, 8 * b + 1, 8 * b + 4) for b in range(6)]
    with h5py.File(stack.with_suffix(".h5")) as f:
        places = f["VTKHDF/Points"][:, :2].reshape(11, 6, 4, 2)
        measured = f["measured_points/position"][:]
        for k, (rows, points) in enumerate(frames):
            for b, (_, start, end) in enumerate(blocks[1:]):
                np.testing.assert_array_equal(rows[start:end + 1, 1:], places[k, b])  # every digit
                np.testing.assert_array_equal(rows[end + 1], rows[start])
                np.testing.assert_array_equal(rows[start - 1], rows[end])  # so that they run round it
                middle = places[k, b].mean(0)
                radius = np.hypot(*(places[k, b] - middle).T).max()
                x, y = places[k, b].T
                area = (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2
                # of parallelograms; the roundings of coordinates up to 5
                np.testing.assert_allclose(rows[end + 2], [0, radius, area], rtol=0, atol=1e-13)
                np.testing.assert_allclose(rows[end + 3, 1:], middle * rows[end + 2, 2], rtol=0, atol=1e-13)
            np.testing.assert_allclose(rows[-1], [0, *middle], rtol=0, atol=1e-14)
            np.testing.assert_array_equal(points[0], 0)
            np.testing.assert_array_equal(points[1:, 0], [0, 0, 0, 1, 1, 1, 1, 1])
            np.testing.assert_array_equal(points[1:, 3], [1, 1, 1, 2, 3, 4, 5, 6])
            if k > 0:
                np.testing.assert_array_equal(points[4:, 1:3], measured[k - 1])


@pytest.mark.parametrize("method", ["strain='green'", "strain='small'", "preset='shi'", "model='nmm' /\n&cover edge=0.7"])
def test_a_load_point_without_force_is_where_its_block_took_it(method, tmp_path):
    """No step moves it; one that is measured is moved in each."""
    points = [(0.9, 0.8, 1), (0.1, 0.2, 1)]
    (tmp_path / "x.blk").write_text(block_file("x", [(1, box(0, 1, 0, 1))], load=points, measured=points))
    (tmp_path / "x.ana").write_text("1 100 1 1 0.05 0.01\n2500 24525 1e7 0.25  2e4 1e4 5e3  0 0 0  1 2 3\n30 0 0\n"
                                    f"&loads force=0 0 0 0 /\n&method {method} /\n&output every=25 /\n")
    *_, frames, _ = parts(run(tmp_path / "x.blk", tmp_path / "x.ana", tmp_path / "x.h5"))
    for _, points in frames:
        np.testing.assert_array_equal(points[1:, 0], [2, 2, 1, 1])
        np.testing.assert_allclose(points[1:3, 1:3], points[3:, 1:3], rtol=0, atol=1e-12)
    assert np.ptp(frames[-1][1][1:, 2]) > 0.1 and np.hypot(*(frames[-1][1][1] - frames[0][1][1])[1:3]) > 1


def test_joint_materials_stand_where_block_files_have_them(tmp_path):
    """At the end of their edge, with 0 for both ways of a seam."""
    subprocess.run([SCREE, "cut", DATA / "hole.geo", "-o", tmp_path / "x.blk"], check=True, capture_output=True)
    cut = [list(map(float, line.split())) for line in (tmp_path / "x.blk").read_text().splitlines()[3:13]]
    out = run(DATA / "hole.geo", DATA / "freefall.ana", tmp_path / "h.h5", "step.end_time=0.01")
    head, _, blocks, frames, _ = parts(out)
    assert head[1] == 1 and blocks[1][1:] == (1, 10)
    np.testing.assert_array_equal(frames[0][0][1:11], cut)
    assert frames[0][0][12, 2] == 8  # the area without the hole


def test_each_element_of_a_manifold_is_a_polygon(tmp_path):
    out = run(DATA / "freefall.geo", DATA / "freefall.ana", tmp_path / "m.h5", "method.model=nmm", "cover.edge=0.4",
              "step.end_time=0.05")
    head, _, blocks, frames, _ = parts(out)
    with h5py.File(tmp_path / "m.h5") as f:
        first = f["VTKHDF/Offsets"][:]
        assert head[1] == len(first) - 1 > 10 and head[0] == f["VTKHDF/Steps"].attrs["NSteps"]
        places = f["VTKHDF/Points"][-len(f["elements/joint"]):, :2]
        rows = np.concatenate([frames[-1][0][start:end + 1] for _, start, end in blocks[1:]])
        np.testing.assert_array_equal(rows[:, 1:], places)
        assert frames[-1][1][1, 3] == f["points/element"][0]
    assert set(rows[:, 0]) == {0, 1}  # lines of the mesh, edges of the block


def test_a_killed_run_says_how_many_frames_are_whole(tmp_path):
    for i in range(6):
        out = tmp_path / f"{i}.h5"
        replay = out.with_suffix(".replay")
        running = subprocess.Popen([SCREE, "run", DATA / "wall100.geo", DATA / "wall100.ana", "-o", out, "--quiet",
                                    "--classic-output", "--set", "output.every=1", "--set", "step.end_time=1e5"])
        while not (replay.exists() and replay.stat().st_size > 300_000):
            assert running.poll() is None
            time.sleep(0.002)
        time.sleep(0.013 * i)
        running.kill()
        running.wait()
        head, kinds, _, frames, left = parts(replay)
        with h5py.File(out) as f:
            counted = f["VTKHDF/Steps"].attrs["NSteps"]  # the results file writes frames that have waited
            n = 4 * head[1]  # all are quadrilaterals
            places = f["VTKHDF/Points"][:counted * n, :2].reshape(counted, n, 2)
        assert 0 < counted <= head[0] + 1
        for rows, points in frames:
            assert rows.shape == (head[3] + 1, 3) and points.shape == (sum(kinds) + 1, 4)
        for (rows, _), place in zip(frames, places, strict=False):
            np.testing.assert_array_equal(rows[1:5, 1:], place[:4])
        assert len(left) < head[3] + sum(kinds) + 3  # less than a frame, at most its last line whole


def test_errors_are_one_line(tmp_path):
    def fails(status, expected, *words):
        done = subprocess.run([SCREE, *words], capture_output=True, text=True, cwd=tmp_path)
        assert done.returncode == status and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr

    decks = [DATA / "stack5.geo", DATA / "stack5_dyn.ana", "--quiet", "--classic-output"]
    fails(2, "expected --classic-output with run, found it with cut", "cut", *decks)
    fails(2, "expected another name for the results", "run", *decks, "-o", "x.replay")
    assert not (tmp_path / "x.replay").exists()
    (tmp_path / "x.replay").mkdir()
    fails(2, "x.replay: expected a file for the replay, found a directory", "run", *decks, "-o", "x.h5")


def test_a_full_disk_is_an_error(tmp_path):
    """As /dev/full is: at the start it is bad input, later the run fails and the results file says so."""
    deck = [SCREE, "run", DATA / "wall100.geo", DATA / "wall100.ana", "-o", tmp_path / "x.h5", "--quiet", "--classic-output",
            "--set", "output.every=1", "--set", "step.end_time=1e5"]
    replay, full = tmp_path / "x.replay", tmp_path / "full"
    replay.symlink_to("/dev/full")
    done = subprocess.run(deck, capture_output=True, text=True)
    assert done.returncode == 2 and "x.replay: expected a file for the replay, found a device" in done.stderr, done.stderr
    replay.unlink()
    running = subprocess.Popen(deck, stderr=subprocess.PIPE, text=True)
    while not (replay.exists() and replay.stat().st_size > 100_000):
        assert running.poll() is None
        time.sleep(0.002)
    full.symlink_to("/dev/full")
    full.rename(replay)
    _, said = running.communicate(timeout=60)
    assert running.returncode == 1 and "x.replay: cannot write" in said and len(said.splitlines()) == 1, said
    with h5py.File(tmp_path / "x.h5") as f:
        assert f["scene"].attrs["status"].startswith(b"stopped: ") and f["VTKHDF/Steps"].attrs["NSteps"] > 1
