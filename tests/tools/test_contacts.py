"""tools/contacts: what VTK reads of it is what /contacts has, frame by frame."""
import os
import pathlib
import shutil
import subprocess

import h5py
import numpy as np
import pytest
import scree
from scree import drawing, overlays, touching

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOL = SOURCE / "tools" / "contacts"
SLIDE = SOURCE / "input" / "validation" / "b1-slide" / "slope30.ana"


def dda(folder):
    return scree.run(SLIDE, output=folder / "run.h5", settings=["step.count=40", "output.every=4"])


def nmm(folder):
    return scree.run(touching.jointed_rock(folder, "nmm", 3, 30), output=folder / "run.h5", settings=["output.every=6"])


@pytest.fixture(scope="module", params=[dda, nmm], ids=["dda", "nmm"])
def written(request, tmp_path_factory):
    """Results and the file of their contacts."""
    results = request.param(tmp_path_factory.mktemp("contacts"))
    done = subprocess.run([TOOL, results.path], capture_output=True, text=True)
    path = results.path.with_name("run-contacts.vtkhdf")
    assert done.returncode == 0 and done.stdout == f"{path}\n", done.stderr
    return results, path


def expected(results, frame):
    """Points and data of a frame."""
    contacts, space = results.contacts_of(frame), lambda pairs: np.column_stack([pairs, np.zeros(len(pairs))])
    force = overlays.contact_forces(drawing.Frames(results.path, "run"), frame)
    return space(contacts.place), {
        "state": contacts.state, "force": space(force), "across": contacts.force[:, 0], "along": contacts.force[:, 1],
        "normal": space(contacts.normal), "block": contacts.blocks[:, 0], "against": contacts.blocks[:, 1]}


def check_frame(results, frame, points, data):
    true_points, true = expected(results, frame)
    np.testing.assert_array_equal(points, true_points)
    assert set(data) == set(true)
    for name, values in true.items():
        np.testing.assert_allclose(data[name], values, rtol=1e-14, err_msg=name)


def test_frames_are_where_their_offsets_say(written):
    """The layout of VTKHDF for grids in time: a frame begins at its offsets and has as many rows as its numbers say."""
    results, path = written
    with h5py.File(path) as f:
        top, steps = f["VTKHDF"], f["VTKHDF/Steps"]
        assert top.attrs["Type"] == b"UnstructuredGrid" and list(top.attrs["Version"]) == [2, 0]
        assert steps.attrs["NSteps"] == results.n_frames and list(steps["Values"]) == list(results.times)
        for frame in range(results.n_frames):
            part = steps["PartOffsets"][frame]
            n, at = top["NumberOfPoints"][part], steps["PointOffsets"][frame]
            assert steps["NumberOfParts"][frame] == 1 and top["NumberOfCells"][part] == top["NumberOfConnectivityIds"][part] == n
            data = {name: values[steps[f"PointDataOffsets/{name}"][frame]:][:n] for name, values in top["PointData"].items()}
            check_frame(results, frame, top["Points"][at:at + n], data)
            cells = steps["CellOffsets"][frame, 0]
            assert list(top["Offsets"][cells + part:][:n + 1]) == list(range(n + 1)) and set(top["Types"][cells:cells + n]) <= {1}
            assert list(top["Connectivity"][steps["ConnectivityIdOffsets"][frame, 0]:][:n]) == list(range(n))
        assert top["NumberOfPoints"][0] == 0 < top["NumberOfPoints"][-1] and at + n == len(top["Points"])


def test_vtk_reads_the_contacts_of_each_frame(written):
    vtk = pytest.importorskip("vtk", reason="VTK is not installed (pip install vtk)")
    if tuple(map(int, vtk.vtkVersion().GetVTKVersion().split(".")[:2])) < (9, 3):
        pytest.skip("VTK is older than 9.3")
    from vtk.util.numpy_support import vtk_to_numpy
    results, path = written
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    assert reader.GetNumberOfSteps() == results.n_frames
    for frame in range(results.n_frames):
        reader.SetStep(frame)
        reader.Update()
        grid = reader.GetOutputDataObject(0)
        n, data = grid.GetNumberOfPoints(), grid.GetPointData()
        assert n == grid.GetNumberOfCells() == results["contacts/count"][frame]
        assert [grid.GetCell(i).GetPointId(0) for i in range(n)] == list(range(n))
        if n:
            arrays = {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}
            check_frame(results, frame, vtk_to_numpy(grid.GetPoints().GetData()), arrays)


def test_what_has_no_contacts_is_one_line(written, tmp_path):
    fall = scree.run(SOURCE / "input/paper/rotation/t4.ana", output=tmp_path / "t4.h5", settings=["step.count=3"])
    results = written[0]
    without = tmp_path / "without.h5"
    shutil.copy(results.path, without)
    with h5py.File(without, "r+") as file:
        file["VTKHDF/Steps"].attrs["NSteps"] = 0  # as where the disk was full before the first frame
    for words, said in (([fall.path], "without"), ([without], "expected a frame, found none"), ([tmp_path / "none.h5"], "found"),
                        ([results.path, "-o", tmp_path / "no" / "c.vtkhdf"], "cannot write"),
                        ([results.path, "-o", results.path], "that of the results")):
        done = subprocess.run([TOOL, *words], capture_output=True, text=True)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and said in done.stderr, done.stderr
    assert scree.read(results.path).n_frames == results.n_frames
