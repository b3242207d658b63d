"""Who may read and write a results file while a run goes on: with locks of the system, without them, and without the file."""
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import time
import xml.etree.ElementTree as xml

import h5py
import numpy as np
import pytest
import scree

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
DECK = SOURCE / "input" / "examples" / "toppling" / "toppling.ana"
LONG = ["--quiet", "--set", "step.end_time=1e4", "--set", "step.sleep=0", "--set", "output.every=50"]  # hours
PLAIN = {name: value for name, value in os.environ.items() if name != "HDF5_USE_FILE_LOCKING"}


@pytest.fixture(scope="module")
def no_locks(tmp_path_factory):
    """A library that makes the locks of all file systems fail."""
    path = tmp_path_factory.mktemp("no_locks") / "no_locks.so"
    done = subprocess.run(["cc", "-shared", "-fPIC", "-o", path, SOURCE / "tests" / "results" / "no_locks.c", "-ldl"], capture_output=True)
    if done.returncode:
        pytest.skip("no C compiler that makes a library")
    return path


@pytest.fixture
def system(request, no_locks):
    """The environment of a system with locks, with those of HDF5 turned off or on, without `flock`, and without any."""
    return {"locks": PLAIN, "off": PLAIN | {"HDF5_USE_FILE_LOCKING": "FALSE"}, "on": PLAIN | {"HDF5_USE_FILE_LOCKING": "TRUE"},
            "no flock": PLAIN | {"LD_PRELOAD": str(no_locks), "WITHOUT": "flock"},
            "none": PLAIN | {"LD_PRELOAD": str(no_locks), "WITHOUT": "all"}}[request.param]


def on(*systems):
    return pytest.mark.parametrize("system", systems, indirect=True)


def frames_of(path):
    """Frames that a file counts, read without a lock; 0 where it is none yet."""
    try:
        with h5py.File(path, "r", locking=False) as f:
            return int(f["VTKHDF/Steps"].attrs["NSteps"])
    except (OSError, KeyError, RuntimeError, ValueError):  # caught half-way in a write
        return 0


@pytest.fixture
def start():
    """Begins runs, waits for their first frames, and ends them with the test."""
    runs = []

    def begin(*words, frames=1, **options):
        runs.append(subprocess.Popen([SCREE, "run", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options))
        path = words[words.index("-o") + 1]
        while frames_of(path) < frames:
            assert runs[-1].poll() is None, runs[-1].stderr.read()
        return runs[-1]

    yield begin
    for run in runs:
        run.kill()
        run.communicate()


def run(*words, **options):
    return subprocess.run([SCREE, "run", *words], capture_output=True, text=True, timeout=100, **options)


@on("locks", "on", "no flock", "none")
def test_a_run_needs_no_locks_of_the_file_system(system, tmp_path):
    done = run(DECK, "-o", tmp_path / "r.h5", "--quiet", "--set", "step.end_time=0.1", env=system)
    assert done.returncode == 0 and scree.read(tmp_path / "r.h5").scene.status == "complete", done.stderr


@on("locks", "none")
def test_a_run_that_goes_on_is_read_as_far_as_it_is(system, start, tmp_path):
    """Of many looks at a run that writes as often as it can, each finds whole frames, whose times are multiples of the step."""
    path = tmp_path / "r.h5"
    going = start(DECK, "-o", path, *LONG, "--set", "output.every=1", env=system, frames=2)
    counted = []
    while len(counted) < 20 or counted[-1] < counted[0] + 200:
        results = scree.read(path)
        assert results.scene.status == "running" and results.summary is None
        counted.append(results.n_frames)
        np.testing.assert_allclose(results.times, 0.005 * np.arange(results.n_frames), rtol=1e-9, atol=1e-12)
        assert len(results.bodies.centroid) == results.n_frames <= len(results.history.time) + 1
        assert np.isfinite(results.vertices()).all() and np.isfinite(results.stress(-1)).all() and results.contacts_of() is not None
        assert going.poll() is None


@pytest.mark.parametrize("tool", ["plot", "report"])
@on("locks")
def test_a_picture_and_a_page_of_a_run_that_goes_on_are_made(system, tool, start, tmp_path):
    start(DECK, "-o", tmp_path / "r.h5", *LONG, "--set", "output.every=2000", env=system, frames=2)
    words = {"plot": ["--frames", "last", "-o", "r.png"], "report": ["-o", "r.html"]}[tool]
    done = subprocess.run([SOURCE / "tools" / tool, "r.h5", *words], capture_output=True, text=True, cwd=tmp_path, env=system)
    assert done.returncode == 0 and (tmp_path / words[-1]).stat().st_size > 1000, done.stderr


def test_other_programs_with_hdf5_may_read_what_a_run_writes_but_not_write_it(start, tmp_path):
    """With the locks that HDF5 takes where nothing is said."""
    path = tmp_path / "r.h5"
    start(DECK, "-o", path, *LONG, env=PLAIN)
    with h5py.File(path, "r", locking=True) as f:
        assert f["scene"].attrs["status"] == b"running"
    with pytest.raises(OSError, match="Resource temporarily unavailable"):
        h5py.File(path, "a", locking=True)


def test_a_run_without_a_frame_is_said_to_have_none(tmp_path):
    with h5py.File(tmp_path / "r.h5", "w") as f:
        f.create_group("scene").attrs["status"] = np.bytes_("running")
    with pytest.raises(scree.ResultsError, match="expected a frame, found a run that has written none"):
        scree.read(tmp_path / "r.h5")


@on("locks", "off", "no flock")
def test_of_two_runs_to_one_file_the_second_is_refused(system, start, tmp_path):
    path = tmp_path / "r.h5"
    first = start(DECK, "-o", path, *LONG, env=system)
    for words in ([DECK, "-o", path], [DECK, "-o", path, "--xdmf"], ["--restart", path]):
        done = run(*words, "--quiet", "--set", "step.end_time=1", env=system)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and f"scree: {path}: expected " in done.stderr
        assert "run" in done.stderr and "wait until that ends" in done.stderr
    first.send_signal(signal.SIGTERM)
    first.communicate(timeout=60)
    assert first.returncode == 143 and scree.read(path).scene.status == "interrupted"


def test_of_two_runs_to_one_file_without_any_lock_the_first_fails(start, no_locks, tmp_path):
    """Whoever comes later takes the place of the file; the other finds that at its next frame."""
    path, system = tmp_path / "r.h5", PLAIN | {"LD_PRELOAD": str(no_locks), "WITHOUT": "all"}
    first = start(DECK, "-o", path, *LONG, env=system)
    assert run(DECK, "-o", path, "--quiet", env=system).returncode == 0
    said = first.communicate(timeout=60)[1]
    assert first.returncode == 1 and "another program has put another file there" in said and "frames of this run are lost" in said
    assert scree.read(path).scene.status == "complete"


@on("locks", "none")
def test_a_run_that_was_killed_leaves_no_lock(system, start, tmp_path):
    path = tmp_path / "r.h5"
    start(DECK, "-o", path, *LONG, "--set", "output.checkpoint=1", env=system, frames=3).kill()
    for words in (["--restart", path], [DECK, "-o", path]):
        n = frames_of(path)
        done = run(*words, "--quiet", "--set", f"step.end_time={0.25 * n + 0.5}", env=system)
        assert done.returncode == 0 and scree.read(path).scene.status == "complete", done.stderr
    assert [file.name for file in tmp_path.iterdir()] == ["r.h5"]


def test_a_reader_does_not_keep_a_run_from_its_file(tmp_path):
    """Results that somebody looks at are written anew; he keeps what he has opened."""
    path = tmp_path / "r.h5"
    assert run(DECK, "-o", path, "--quiet", "--set", "step.end_time=0.1").returncode == 0
    with h5py.File(path) as f:
        assert run(DECK, "-o", path, "--quiet", "--set", "step.end_time=0.2", env=PLAIN).returncode == 0
        assert len(f["history/time"]) == 20
    assert len(scree.read(path).history.time) == 40


def test_a_link_to_results_stays_a_link(tmp_path):
    (tmp_path / "below").mkdir()
    (tmp_path / "r.h5").symlink_to("below/r.h5")
    for _ in range(2):
        assert run(DECK, "-o", tmp_path / "r.h5", "--quiet", "--set", "step.end_time=0.1").returncode == 0
        assert (tmp_path / "r.h5").is_symlink() and len(scree.read(tmp_path / "below" / "r.h5").history.time) == 20


@pytest.mark.parametrize("what, words", [("remove", "removed or renamed"), ("rename", "removed or renamed"),
                                         ("folder", "removed or renamed"), ("replace", "another program has put another file there")])
def test_a_run_whose_results_are_taken_away_fails_and_says_what_is_kept(what, words, start, tmp_path):
    folder = tmp_path / "results"
    folder.mkdir()
    path = folder / "r.h5"
    going = start(DECK, "-o", path, *LONG[1:], "--summary", "json", frames=3)
    if what == "remove":
        path.unlink()
    elif what == "rename":
        path.rename(folder / "other.h5")
    elif what == "folder":
        shutil.rmtree(folder)
    else:
        (folder / "notes.txt").write_text("to be kept\n")
        (folder / "notes.txt").rename(path)
    out, said = going.communicate(timeout=60)
    mine = [line for line in said.splitlines() if not line.startswith("scree: warning: ")]
    assert going.returncode == 1 and len(mine) == 1 and words in mine[0] and " frames of this run are " in mine[0], said
    assert '"results":null' in out.replace(": ", ":") and "HDF5-DIAG" not in said + out
    if what == "replace":
        assert path.read_text() == "to be kept\n"
    else:
        assert not path.exists()
    if what == "rename":
        assert frames_of(folder / "other.h5") >= 3


def made_in(folder):
    """The files of a folder, and which they are."""
    found = {}
    for path in folder.iterdir():
        try:
            found[path.name] = path.stat().st_ino, path.stat().st_ctime_ns
        except FileNotFoundError:  # it has just taken its place
            pass
    return found


@pytest.mark.parametrize("when", [0, 0.01, 0.03])
def test_a_run_that_is_killed_as_it_begins_leaves_nothing_that_the_next_refuses(when, tmp_path):
    """Nor a file without a frame in its place."""
    for _ in range(3):
        before = made_in(tmp_path)
        going = subprocess.Popen([SCREE, "run", DECK, "-o", tmp_path / "r.h5", *LONG], stderr=subprocess.DEVNULL)
        while made_in(tmp_path) == before:
            assert going.poll() is None
        time.sleep(when)
        going.kill()
        going.wait()
        assert not (tmp_path / "r.h5").exists() or frames_of(tmp_path / "r.h5")
    done = run(DECK, "-o", tmp_path / "r.h5", "--quiet", "--set", "step.end_time=0.1")
    assert done.returncode == 0 and [file.name for file in tmp_path.iterdir()] == ["r.h5"], done.stderr


def test_what_was_there_stays_until_there_is_a_first_frame(tmp_path):
    """A disk without room for that keeps the results of before."""
    path = tmp_path / "r.h5"
    assert run(DECK, "-o", path, "--quiet", "--set", "step.end_time=0.1").returncode == 0
    before = path.read_bytes()
    done = run(DECK, "-o", path, "--quiet", preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (50_000, 50_000)))
    assert done.returncode == 1 and done.stderr == f"scree: {path}: cannot write: File too large\n"
    assert path.read_bytes() == before and [file.name for file in tmp_path.iterdir()] == ["r.h5"]


def test_another_file_that_comes_to_its_place_while_a_run_is_set_up_is_not_written_over(tmp_path):
    """The run is held as soon as it has begun its file, before that has a frame and takes its place."""
    path, begun = tmp_path / "r.h5", tmp_path / "r.h5.part"
    for _ in range(50):
        going = subprocess.Popen([SCREE, "run", DECK, "-o", path, "--quiet", "--set", "step.end_time=0.1"], stderr=subprocess.PIPE, text=True)
        while not begun.exists() and going.poll() is None:
            pass
        going.send_signal(signal.SIGSTOP)
        held = begun.exists() and not path.exists()
        if held:
            path.write_text("to be kept\n")
        going.send_signal(signal.SIGCONT)
        said = going.communicate(timeout=60)[1]
        if held:
            break
        path.unlink(missing_ok=True)
    assert held and going.returncode == 2 and "expected a new file or a results file of scree" in said
    assert path.read_text() == "to be kept\n" and not begun.exists()


@pytest.mark.parametrize("name", ["A & B", "less < more", "a > b", "'it' \"is\"", "&amp;", "höhle"])
def test_a_side_car_is_xml_whatever_its_file_is_called(name, tmp_path):
    done = run(DECK, "-o", tmp_path / f"{name}.h5", "--xdmf", "--quiet", "--set", "step.end_time=0.1")
    assert done.returncode == 0, done.stderr
    sources = [item.text for item in xml.parse(tmp_path / f"{name}.xdmf").iter("DataItem") if item.get("Format") == "HDF"]
    assert sources and all(source.startswith(f"{name}.h5:/VTKHDF/") for source in sources)
