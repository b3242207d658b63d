"""The results file: its layout, what it holds of a run that dies, and what a failed write says."""
import os
import pathlib
import random
import re
import resource
import signal
import subprocess
import time
import xml.etree.ElementTree as xml

os.environ["HDF5_USE_FILE_LOCKING"] = "FALSE"  # a file is read here while it is written

import h5py
import numpy as np
import pytest
import scree

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
DECKS = SOURCE / "input" / "paper" / "rotation"
HOLE = """0.001
8 4
0  0  1  0  0  0
0 0 4 0 1
4 0 4 4 1
4 4 0 4 1
0 4 0 0 1
1 1 2 1 2
2 1 2 2 2
2 2 1 2 2
1 2 1 1 2
0.5 0.5 0.5 0.5
"""
SHORT_DECK = """1 2 1 2 0.01 0.001
2500 25000 1e9 0.2
0 0 0
0 0 0
0 0 0
30 0 0
30 0 0
&deck geometry='{geometry}' /
"""


@pytest.fixture(scope="module")
def t4(tmp_path_factory):
    path = tmp_path_factory.mktemp("t4") / "t4.h5"
    subprocess.run([SCREE, "run", DECKS / "t4.ana", "-o", path, "--quiet", "--xdmf"], check=True)
    return path


def test_frames_are_a_vtkhdf_time_series(t4):
    with h5py.File(t4) as f:
        root = f["VTKHDF"]
        assert list(root.attrs["Version"]) == [2, 0] and root.attrs["Type"] == b"UnstructuredGrid"
        n = root["Steps"].attrs["NSteps"]
        assert n == 101 and len(root["Steps/Values"]) == n and root["Types"][0] == 7 and root["Types"].dtype == np.uint8
        for name in ("PartOffsets", "NumberOfParts", "PointOffsets", "CellOffsets", "ConnectivityIdOffsets"):
            assert len(root["Steps"][name]) == n
        np.testing.assert_array_equal(root["Steps/PointOffsets"][:], 3 * np.arange(n))
        np.testing.assert_array_equal(root["Steps/CellDataOffsets/stress_xx"][:], np.arange(n))
        moved = root["Points"][:].reshape(n, 3, 3)
        np.testing.assert_allclose(moved - moved[0], root["PointData/displacement"][:].reshape(n, 3, 3), atol=1e-15)


def test_an_element_with_a_hole_is_one_polygon_with_a_seam(tmp_path):
    """A square of 4 with a square of 1 in it: ten vertices, both ways along the seam, and the area of 15."""
    (tmp_path / "hole.geo").write_text(HOLE)
    (tmp_path / "hole.ana").write_text(SHORT_DECK.format(geometry="hole.geo"))
    subprocess.run([SCREE, "run", tmp_path / "hole.ana", "-o", tmp_path / "hole.h5", "--quiet", "--xdmf"], check=True)
    with h5py.File(tmp_path / "hole.h5") as f:
        root = f["VTKHDF"]
        offsets = root["Offsets"][:]
        assert list(offsets) == [0, 10, 14] and root["NumberOfPoints"][0] == 12 and root["NumberOfCells"][0] == 2
        n = root["Steps"].attrs["NSteps"]
        for name in ("Points", "PointData/displacement", "PointData/velocity"):
            assert root[name].shape == (12 * n, 3)
        corners = root["Connectivity"][:10]
        x, y = root["Points"][:12, :2][corners].T
        assert (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2 == 15  # whole numbers
    assert f"3 10 {' '.join(map(str, corners))}\n" in (tmp_path / "hole.xdmf").read_text()


@pytest.fixture(scope="module")
def covered(tmp_path_factory):
    """A square of 10 with a joint across it, below a mesh of edge 0.7: its model, and two steps of it."""
    folder = tmp_path_factory.mktemp("covered")
    (folder / "square.geo").write_text("0.001\n5 4\n0 0 2 1 1 0\n0 0 10 0 1\n10 0 10 10 1\n10 10 0 10 1\n0 10 0 0 1\n"
                                       "0 3 10 6 2\n1 1 1 1\n9 1 9 1\n5 9\n2 2\n")
    (folder / "square.ana").write_text(SHORT_DECK.format(geometry="square.geo") + "&method model='nmm' /\n&cover edge=0.7 /\n")
    subprocess.run([SCREE, "cut", folder / "square.ana", "-o", folder / "model.h5", "--quiet"], check=True)
    subprocess.run([SCREE, "run", folder / "square.ana", "-o", folder / "run.h5", "--quiet"], check=True)
    return folder


def test_a_model_is_the_first_frame_of_its_run(covered):
    with h5py.File(covered / "model.h5") as model, h5py.File(covered / "run.h5") as run:
        assert model["scene"].attrs["status"] == b"cut" and run["scene"].attrs["status"] == b"complete"
        assert model["VTKHDF/Steps"].attrs["NSteps"] == 1 and len(model["history/time"]) == 0 and len(model["bodies/area"]) == 1
        n = len(model["VTKHDF/Points"])
        for name in ("VTKHDF/Points", "VTKHDF/Offsets", "VTKHDF/CellData/block", "covers/node", "covers/of_element",
                     "covers/follows", "elements/joint", "points/kind", "points/place", "points/element"):
            rows = n if name == "VTKHDF/Points" else None
            np.testing.assert_array_equal(model[name][:], run[name][:rows])
        assert not model["VTKHDF/PointData/displacement"][:].any()


def test_covers_hold_their_elements_and_follow_those_that_stand(covered):
    with h5py.File(covered / "model.h5") as f:
        node, of_element, follows = (f[f"covers/{name}"][:] for name in ("node", "of_element", "follows"))
        assert sorted(set(of_element.flat)) == list(range(1, len(node) + 1))
        followers = follows[:, 0]
        assert len(set(followers)) == len(followers) > 0 and not set(followers) & set(follows[:, 1:].flat)
        points, offsets = f["VTKHDF/Points"][:, :2], f["VTKHDF/Offsets"][:]
        for covers, a, b in zip(of_element, offsets, offsets[1:]):
            corner = node[covers - 1]
            weights = np.linalg.solve(np.vstack([corner.T, np.ones(3)]), np.vstack([points[a:b].T, np.ones(b - a)]))
            assert weights.min() > -1e-9  # rounding of coordinates up to 10 in triangles of 0.7


def test_edges_keep_their_joints_and_points_their_elements(covered):
    with h5py.File(covered / "model.h5") as f:
        points, offsets, joint = f["VTKHDF/Points"][:, :2], f["VTKHDF/Offsets"][:], f["elements/joint"][:]
        length = dict.fromkeys((0, 1, 2), 0.0)
        for a, b in zip(offsets, offsets[1:]):
            for k, size in zip(joint[a:b], np.linalg.norm(np.roll(points[a:b], -1, 0) - points[a:b], axis=1)):
                length[k] += size
        assert length[1] == pytest.approx(40, rel=1e-12) and length[2] == pytest.approx(2 * np.hypot(10, 3), rel=1e-12)
        assert list(f["points/kind"]) == [1, 1, 2, 3]
        np.testing.assert_allclose(f["points/place"][:], [[1, 1], [9, 1], [5, 9], [2, 2]], atol=1e-14)
        for place, e in zip(f["points/place"], f["points/element"]):
            polygon = points[offsets[e - 1]:offsets[e]]
            side, way = np.roll(polygon, -1, 0) - polygon, place - polygon
            assert (side[:, 0] * way[:, 1] - side[:, 1] * way[:, 0] > -1e-9).all()  # convex: on the left of every edge


def test_every_series_has_units_and_description_and_is_finite(t4):
    rows = []

    def look(name, item):
        if isinstance(item, h5py.Dataset) and name.split("/")[0] in ("history", "bodies", "measured_points"):
            rows.append(name)
            assert item.attrs["units"] and item.attrs["description"], name
            assert np.isfinite(item[:]).all(), name
            assert len(item) == (101 if name.startswith("bodies") else 100), name

    with h5py.File(t4) as f:
        f.visititems(look)
    assert len(rows) > 15


def test_absent_effects_are_absent(t4):
    with h5py.File(t4) as f:
        assert set(f["history/energy"]) == {"kinetic", "strain", "held", "work", "dissipated"}  # gamma 1/2 is above beta/2
        assert [phase.decode().strip() for phase in f["cost/phase"]] == [
            "read", "set-up", "search", "alone", "check", "update", "history", "frames", "other"]  # nothing shares or touches
        assert "contacts" not in f


def test_the_scene_is_kept(t4):
    with h5py.File(t4) as f:
        assert f["scene"].attrs["status"] == b"complete"
        assert f["scene/analysis_deck"][0].decode().rstrip() == (DECKS / "t4.ana").read_text().rstrip()
        assert any(word.startswith(b"integrator.beta = 0.5  (") for word in f["scene/settings"])
        assert f["scene/effects"][1].decode().strip() == "large deformation"


def test_the_file_names_what_it_was_made_by(t4):
    """What `scree --version` says, but for the threads, of which a run knows the number. Whether the BLAS is OpenBLAS is seen by the
    libraries that the program loads."""
    told = scree.version()
    scene = scree.read(t4).scene
    assert len(told) == 8 and scene.threads == "linear algebra 1, small steps 1" and told.pop("threads").endswith("--threads")
    assert {name: getattr(scene, name) for name in told} == told
    loaded = subprocess.run(["ldd", os.environ["SCREE"]], capture_output=True, text=True, check=True).stdout
    assert told["blas_file"] in {os.path.realpath(path) for path in re.findall(r" => (/\S+) ", loaded)}
    if "libopenblas" in loaded:
        assert re.fullmatch(r"OpenBLAS [0-9.]+, kernel \w+", told["blas"])
    else:
        assert re.fullmatch(r"not OpenBLAS, LAPACK \d+\.\d+\.\d+", told["blas"])
    assert all(re.fullmatch(r"\d+\.\d+\.\d+", told[name]) for name in ("hdf5", "suitesparse")) and " -O" in told["compiler_options"]
    lines = scree.call("--version").stdout.splitlines()
    assert len(lines) == 8 and all(line.endswith(value) for line, value in zip(lines, told.values()))


def test_the_side_car_points_at_every_frame(t4):
    grids = xml.parse(t4.with_suffix(".xdmf")).getroot().findall("./Domain/Grid/Grid")
    assert len(grids) == 101
    with h5py.File(t4) as f:
        for frame in (0, 57, 100):
            assert float(grids[frame].find("Time").get("Value")) == f["VTKHDF/Steps/Values"][frame]
            slab, source = grids[frame].find("Geometry/DataItem")
            start, _, count = np.array(slab.text.split(), int).reshape(3, 2)
            name, path = source.text.strip().split(":")
            assert name == "t4.h5"
            np.testing.assert_array_equal(f[path][start[0]:start[0] + count[0]], f["VTKHDF/Points"][3 * frame:3 * frame + 3])


def test_the_side_car_has_a_row_for_every_polygon(covered):
    """Some tens to some thousands of elements; the dimension counts the 3 for polygon, the number of vertices, the vertices."""
    for edge in (10, 2, 0.2):
        subprocess.run([SCREE, "cut", covered / "square.ana", "-o", covered / "car.h5", "--quiet", "--xdmf",
                        "--set", f"cover.edge={edge}"], check=True)
        topology = xml.parse(covered / "car.xdmf").getroot().find("./Domain/Grid/Grid/Topology")
        with h5py.File(covered / "car.h5") as f:
            offsets, corners = f["VTKHDF/Offsets"][:], f["VTKHDF/Connectivity"][:]
        polygons = [corners[a:b] for a, b in zip(offsets, offsets[1:])]
        assert int(topology.get("NumberOfElements")) == len(polygons)
        assert int(topology.find("DataItem").get("Dimensions")) == len(corners) + 2 * len(polygons)
        assert topology.find("DataItem").text == "\n" + "".join(
            f"3 {len(polygon)} {' '.join(map(str, polygon))}\n" for polygon in polygons)


def read_frames(path):
    """Reads all counted frames and checks that they are whole; returns how many."""
    with h5py.File(path) as f:
        n = int(f["VTKHDF/Steps"].attrs["NSteps"])
        place = f["VTKHDF/Points"][:3 * n].reshape(n, 3, 3)
        np.testing.assert_allclose(np.linalg.norm(place[:, 1] - place[:, 0], axis=1), 0.1, rtol=1e-6)
        when = f["VTKHDF/Steps/Values"][:n]
        assert (np.diff(when) > 0).all()
        for item in f["bodies"].values():
            assert len(item) >= n and np.isfinite(item[:n]).all()
        history = f["history/time"][:]
        assert n < 2 or history.max() >= when[-1]
        return n


def test_a_killed_run_leaves_its_frames(tmp_path):
    random.seed(1)
    counted = []
    for every in [1, 3, 20, 200] * 4:
        path = tmp_path / "killed.h5"
        path.unlink(missing_ok=True)
        run = subprocess.Popen([SCREE, "run", DECKS / "chi0.ana", "-o", path, "--quiet", "--set", f"output.every={every}"])
        while True:  # until the first frame is there
            try:
                if read_frames(path) > 0:
                    break
            except (OSError, KeyError, RuntimeError, ValueError, AssertionError):  # caught half-way in a write
                assert run.poll() is None
        time.sleep(random.uniform(0.1, 0.6))  # frames wait for a quarter of a second at most
        run.send_signal(signal.SIGKILL)
        run.wait()
        counted.append(read_frames(path))
    assert max(counted) > 1000


def check_status_and_rows(path):
    """The file says that it stopped for want of room, and no frame is ahead of the rows of the steps; how many frames it has."""
    frames = read_frames(path)
    assert frames >= 1
    with h5py.File(path) as f:
        assert b"cannot write: " in f["scene"].attrs["status"] and f["scene"].attrs["status"].startswith(b"stopped: step ")
    return frames


def check_words(said, path, reason, frames):
    """At which step and time, what, how many frames there are, and what to try, in one line."""
    assert re.fullmatch(rf"scree: step \d+ to time [\d.]+: {path}: cannot write: {reason}; the first {frames} frames are kept; try .*\n", said)


def limit_file_size():
    """Writes beyond 3 MB fail."""
    resource.setrlimit(resource.RLIMIT_FSIZE, (3_000_000, 3_000_000))


def test_a_limit_of_file_size_is_said(tmp_path):
    path = tmp_path / "large.h5"
    done = subprocess.run([SCREE, "run", DECKS / "chi0.ana", "-o", path, "--quiet", "--set", "output.every=100"],
                          capture_output=True, text=True, preexec_fn=limit_file_size)
    assert done.returncode == 1
    check_words(done.stderr, path, "File too large", check_status_and_rows(path))


def test_a_disk_without_room_for_the_first_frame_keeps_no_file(tmp_path):
    path = tmp_path / "none.h5"
    for size in (20_000, 100_000, 200_000, 300_000):
        done = subprocess.run([SCREE, "run", DECKS / "chi0.ana", "-o", path, "--quiet"], capture_output=True, text=True,
                              preexec_fn=lambda size=size: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)))
        if path.exists():
            with h5py.File(path) as f:
                assert f["VTKHDF/Steps"].attrs["NSteps"] > 0
        assert done.returncode == (0 if size == 300_000 and done.returncode == 0 else 1)
        if done.returncode:
            assert done.stderr == f"scree: {path}: cannot write: File too large\n"


@pytest.mark.parametrize("size", ["4m", "4700k", "6m", "7300k", "8m"])
def test_a_full_disk_is_said_and_leaves_the_frames(size, tmp_path):
    """On a small file system of its own, which needs root or the right to make a user namespace."""
    disk = tmp_path / "disk"
    disk.mkdir()
    inside = (f"mount -t tmpfs -o size={size} none {disk} && {{ {SCREE} run {DECKS / 'chi0.ana'} -o {disk}/full.h5 --quiet "
              f"--set output.every=100; status=$?; cp {disk}/full.h5 {tmp_path}; exit $status; }}")
    unshare = ["unshare", "--user", "--map-root-user", "--mount"] if os.geteuid() else ["unshare", "--mount"]
    if subprocess.run([*unshare, "mount", "-t", "tmpfs", "none", disk], capture_output=True).returncode != 0:
        pytest.skip("no right to mount a small file system")
    done = subprocess.run([*unshare, "sh", "-c", inside], capture_output=True, text=True)
    assert done.returncode == 1
    check_words(done.stderr, f"{disk}/full.h5", "No space left on device", check_status_and_rows(tmp_path / "full.h5"))


def test_a_place_that_cannot_be_written_is_said_before_the_run(tmp_path):
    for path, word in ((tmp_path / "none" / "r.h5", "No such file or directory"), (tmp_path, "directory")):
        done = subprocess.run([SCREE, "run", DECKS / "t4.ana", "-o", path, "--quiet"], capture_output=True, text=True)
        assert done.returncode == 2 and word in done.stderr and len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("ending, option", [("h5", "--quiet"), ("xdmf", "--xdmf"), ("replay", "--classic-output")])
def test_what_is_no_regular_file_is_left_alone(ending, option, tmp_path):
    """A run waited at a pipe for ever, and put a file in the place of a device where it had the right."""
    os.mkfifo(tmp_path / f"r.{ending}")
    done = subprocess.run([SCREE, "run", DECKS / "t4.ana", "-o", tmp_path / "r.h5", option], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2 and "found a device, a pipe or a protected file" in done.stderr
    assert (tmp_path / f"r.{ending}").is_fifo() and len(list(tmp_path.iterdir())) == 1
