"""How a run ends before its end: by a signal, on a full disk, and what it never writes over."""
import fcntl
import os
import pathlib
import signal
import subprocess
import time

os.environ["HDF5_USE_FILE_LOCKING"] = "FALSE"  # a file is read here while it is written

import h5py
import numpy as np
import pytest

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
ROTATION = SOURCE / "input" / "paper" / "rotation"
GEOMETRY = "0.001\n4 4\n0 0 1 0 0 0\n0 0 1 0 1\n1 0 1 1 1\n1 1 0 1 1\n0 1 0 0 1\n0 0 0 0\n"
BLOCKS = "1 0 8\n0 0 0\n1 1 4\n1 0 0\n1 1 0\n1 1 1\n1 0 1\n1 0 0\n0 0 0\n0 0 0\n0 0 0\n"
ANALYSIS = "1 3 1 1 0.01 0.001\n2500 25000 1e9 0.2\n0 0 0\n0 0 0\n0 0 0\n30 0 0\n"
JOINTS = "&window x=0 10, y=0 10 /\n&joint_set dip=30, spacing=1, length=4, bridge=1 /\n"


def start(folder, *words, **options):
    """A run of a triangle of 1e6 steps, once its first frame is there; frames are 1e4 steps apart."""
    path = folder / "long.h5"
    run = subprocess.Popen([SCREE, "run", ROTATION / "t4.ana", "-o", path, "--quiet", "--set", "step.end_time=1e4", *words],
                           stderr=subprocess.PIPE, text=True, **options)
    while True:
        try:
            with h5py.File(path) as f:
                if f["VTKHDF/Steps"].attrs["NSteps"] > 0:
                    return run, path
        except (OSError, KeyError, RuntimeError, ValueError):  # caught half-way in a write
            assert run.poll() is None, run.stderr.read()


def check_interrupted(path, said, name):
    """Every step that was done has its rows, and the last frame is of the last step."""
    with h5py.File(path) as f:
        assert f["scene"].attrs["status"] == b"interrupted"
        when, n = f["history/time"][:], f["VTKHDF/Steps"].attrs["NSteps"]
        frames = f["VTKHDF/Steps/Values"][:]
        assert len(frames) == n and frames[-1] == np.append(0, when)[-1] and (np.diff(when) > 0).all()
        assert len(when) == len(f["history/rotation"]) and len(f["bodies/area"]) == n
        phases = [phase.decode().strip() for phase in f["cost/phase"]]
        assert phases[:2] == ["read", "set-up"] and ("history" in phases) == (len(when) > 0)  # a signal may come before the first step
        assert len(said.splitlines()) == 1 and f"interrupted by {name} after step {len(when)}, " in said and str(path) in said
        return len(when), n


@pytest.mark.parametrize("name, status", [("SIGINT", 130), ("SIGTERM", 143)])
def test_a_signal_ends_the_step_and_keeps_all_that_was_done(name, status, tmp_path):
    for pause in (0, 0.02, 0.3):
        run, path = start(tmp_path)
        time.sleep(pause)
        run.send_signal(getattr(signal, name))
        _, said = run.communicate(timeout=60)
        assert run.returncode == status
        steps, _ = check_interrupted(path, said, name)
        path.unlink()
    assert steps > 10


def test_a_signal_sent_twice_at_once_is_one(tmp_path):
    """As timeout and batch systems send it: to the process, and to its group."""
    for pause in (0, 1e-4, 1e-3):
        run, path = start(tmp_path)
        for _ in range(3):
            run.send_signal(signal.SIGTERM)
            time.sleep(pause)
        _, said = run.communicate(timeout=60)
        assert run.returncode == 143
        check_interrupted(path, said, "SIGTERM")
        path.unlink()


def test_side_cars_have_the_frame_of_a_run_that_a_signal_stops(tmp_path):
    run, path = start(tmp_path, "--xdmf", "--classic-output")
    time.sleep(0.1)
    run.send_signal(signal.SIGTERM)
    _, said = run.communicate(timeout=60)
    _, n = check_interrupted(path, said, "SIGTERM")
    assert path.with_suffix(".xdmf").read_text().count("<Time ") == n and n > 1
    assert int(path.with_suffix(".replay").read_text().split()[0]) == n


def test_a_job_that_ignores_a_signal_goes_on(tmp_path):
    """As a shell starts a job in the background."""
    run, path = start(tmp_path, "--set", "step.end_time=20", preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_IGN))
    run.send_signal(signal.SIGINT)
    _, said = run.communicate(timeout=60)
    assert run.returncode == 0 and said == ""
    with h5py.File(path) as f:
        assert f["scene"].attrs["status"] == b"complete"


def test_a_signal_before_there_are_results_leaves_none(tmp_path):
    os.mkfifo(tmp_path / "x.geo")  # whose other end nobody opens
    (tmp_path / "x.ana").write_text(ANALYSIS)
    run = subprocess.Popen([SCREE, "run", tmp_path / "x.geo", tmp_path / "x.ana", "-o", tmp_path / "x.h5"])
    time.sleep(0.5)
    run.send_signal(signal.SIGTERM)
    assert run.wait(timeout=60) == -signal.SIGTERM and not (tmp_path / "x.h5").exists()


@pytest.fixture
def folder(tmp_path):
    """Decks, and files of others by names that results would have."""
    for name, text in {"x.geo": GEOMETRY, "x.ana": ANALYSIS, "x.blk": BLOCKS, "x.joints": JOINTS, "notes.txt": "to be kept\n",
                       "x.xdmf": "<Xdmf/>\n", "x.replay": "3 1 0 8\n1 0 0\n0 0 0\n", "hand.geo": GEOMETRY, "two.txt": "1 2\n",
                       "empty.h5": ""}.items():
        (tmp_path / name).write_text(text)
    with h5py.File(tmp_path / "other.h5", "w") as f:
        f["data"] = [1.0]
    (tmp_path / "cut.h5").write_bytes((tmp_path / "other.h5").read_bytes()[:100])
    (tmp_path / "symbolic.geo").symlink_to("x.geo")
    os.link(tmp_path / "x.blk", tmp_path / "hard.blk")
    (tmp_path / "symbolic.blk").symlink_to("x.blk")
    (tmp_path / "below").mkdir()
    return tmp_path


RUN = ["run", "x.geo", "x.ana"]


@pytest.mark.parametrize("words", [
    [*RUN, "-o", "x.geo"], [*RUN, "-o", "./x.ana"], [*RUN, "-o", "symbolic.geo"], [*RUN, "-o", "notes.txt"],
    [*RUN, "-o", "other.h5"], [*RUN, "-o", "cut.h5"], [*RUN, "-o", "x.h5", "--xdmf"], [*RUN, "-o", "x.h5", "--classic-output"],
    [*RUN, "-o", "x.xdmf", "--xdmf"], [*RUN, "-o", "new.xdmf", "--xdmf"], [*RUN, "-o", "new.replay", "--classic-output"],
    ["cut", "x.geo", "x.ana", "-o", "x.geo"], ["cut", "x.geo", "-o", "below/../x.geo"], ["cut", "x.geo", "-o", "symbolic.geo"],
    ["cut", "x.blk", "-o", "hard.blk"], ["cut", "x.blk", "-o", "symbolic.blk"], ["cut", "x.blk"], ["cut", "x.geo", "-o", "notes.txt"],
    ["cut", "x.geo", "-o", "two.txt"], ["cut", "x.geo", "-o", "other.h5"], ["joints", "x.joints", "-o", "x.joints"],
    ["joints", "x.joints", "-o", "hand.geo"], ["joints", "x.joints"], ["joints", "x.joints", "-o", "other.h5"]])
def test_no_file_of_another_kind_is_written_over(words, folder):
    before = {path: path.read_bytes() for path in folder.iterdir() if path.is_file()}
    done = subprocess.run([SCREE, *words, "--quiet"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "expected" in done.stderr, done.stderr
    assert {path: path.read_bytes() for path in folder.iterdir() if path.is_file()} == before


@pytest.mark.parametrize("words", [
    [*RUN, "-o", "new.h5", "--xdmf", "--classic-output"], [*RUN, "-o", "empty.h5"], ["cut", "x.geo", "x.ana", "-o", "m.h5", "--xdmf"],
    ["cut", "x.geo", "-o", "x2.blk"], ["joints", "x.joints", "-o", "j.geo"], ["cut", "x.geo", "-o", "/dev/null"]])
def test_what_scree_wrote_is_written_anew(words, folder):
    for _ in range(2):
        done = subprocess.run([SCREE, *words, "--quiet"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


def test_of_two_runs_that_begin_at_once_on_one_file_one_has_it(tmp_path):
    """The other is refused, and what it would have emptied is whole."""
    path = tmp_path / "r.h5"
    env = {name: value for name, value in os.environ.items() if name != "HDF5_USE_FILE_LOCKING"}
    for _ in range(8):  # the first time there is no file yet
        runs = [subprocess.Popen([SCREE, "run", ROTATION / "t4.ana", "-o", path, "--quiet"],
                                 stderr=subprocess.PIPE, text=True, env=env) for _ in range(2)]
        said = [run.communicate(timeout=60)[1] for run in runs]
        assert sorted(run.returncode for run in runs) in ([0, 2], [0, 0])  # one may end before the other begins
        assert all(len(words.splitlines()) <= 1 for words in said)
        with h5py.File(path) as f:
            assert f["scene"].attrs["status"] == b"complete" and len(f["history/time"]) == 100
    assert [file.name for file in tmp_path.iterdir()] == ["r.h5"]


def test_a_run_waits_while_another_makes_its_file(tmp_path):
    """Whose turn it is, the system knows: it has a lock on the directory, which one that is killed gives up."""
    path = tmp_path / "r.h5"
    turn = os.open(tmp_path, os.O_RDONLY)
    fcntl.flock(turn, fcntl.LOCK_EX)
    run = subprocess.Popen([SCREE, "run", ROTATION / "t4.ana", "-o", path, "--quiet"])
    time.sleep(0.5)
    assert run.poll() is None and not path.exists()
    os.close(turn)
    assert run.wait(timeout=60) == 0 and path.exists()


def test_results_of_a_run_that_died_are_written_anew(tmp_path):
    run, path = start(tmp_path)
    run.kill()
    run.communicate()
    done = subprocess.run([SCREE, "run", ROTATION / "t4.ana", "-o", path, "--quiet"])
    assert done.returncode == 0
