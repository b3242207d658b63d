"""The package of tools/: results are read as the program wrote them, and runs say what the program says."""
import base64
import inspect
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib

import h5py
import numpy as np
import pytest
import scree

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
T4 = SOURCE / "input" / "paper" / "rotation" / "t4.ana"
CLASSIC = SOURCE / "tests" / "data" / "classic"


@pytest.fixture(scope="module")
def incline(tmp_path_factory):
    """A block that slides on a fixed one, a frame a step."""
    return scree.run(CLASSIC / "incline30.geo", CLASSIC / "incline30_p10.ana", settings=["output.every=1", "step.count=20"],
                     output=tmp_path_factory.mktemp("incline") / "x.h5")


def test_every_dataset_is_read_as_it_stands(incline):
    with h5py.File(incline.path) as f:
        names = []
        f.visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        assert len(names) > 40
        for name in names:
            if f[name].dtype.kind in "SO":
                continue
            np.testing.assert_array_equal(incline[name], f[name][()], err_msg=name)
            found = incline
            for part in name.split("/"):
                found = getattr(found, part)
            np.testing.assert_array_equal(found, f[name][()])


def test_frames_are_those_of_the_file(incline):
    with h5py.File(incline.path) as f:
        n = f["VTKHDF/Steps"].attrs["NSteps"]
        points = f["VTKHDF/Points"][:, :2].reshape(n, -1, 2)
        velocity = f["VTKHDF/PointData/velocity"][:, :2].reshape(n, -1, 2)
        yy = f["VTKHDF/CellData/stress_yy"][:].reshape(n, -1)
        measured = f["points/place"][:][f["points/kind"][:] == 3]
    assert incline.n_frames == n == 21 and incline.n_blocks == incline.n_elements == 2
    np.testing.assert_array_equal(incline.frame_steps, np.arange(21))
    for k in (0, 7, 20):
        np.testing.assert_array_equal(incline.vertices(k), points[k])
        np.testing.assert_array_equal(incline.velocity(k), velocity[k])
        np.testing.assert_array_equal(incline.stress(k)[:, 1], yy[k])
    np.testing.assert_array_equal(incline.vertices(-1), points[-1])
    np.testing.assert_array_equal(incline.given_points("measured"), measured)
    assert list(incline.block) == [1, 2] and set(incline.material) <= {1, 2}
    np.testing.assert_allclose(incline.displacement(5), points[5] - points[0], atol=1e-12)
    for polygon, area in zip(incline.polygons(), incline.bodies.area[-1]):
        x, y = polygon.T
        assert (x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2 == pytest.approx(area, rel=1e-12)
    with pytest.raises(IndexError, match="from 0 to 20, found 21"):
        incline.vertices(21)


def test_contacts_of_a_frame_carry_the_block(incline):
    """Frames have the rows that their counts say. The slope falls to the right, and friction up it is tan 10 of what presses."""
    count = incline.contacts.count
    assert [len(incline.contacts_of(k)) for k in range(21)] == list(count) and count[-1] > 0
    contacts = incline.contacts_of(20)
    assert contacts.blocks.tolist() == [[2, 1]] * 2 and set(contacts.state) == {1}
    left = np.column_stack([-contacts.normal[:, 1], contacts.normal[:, 0]])
    push = (contacts.force[:, :1] * contacts.normal + contacts.force[:, 1:] * left).sum(0)
    uphill, out = [-np.cos(np.radians(30)), np.sin(np.radians(30))], [np.sin(np.radians(30)), np.cos(np.radians(30))]
    # rounding of the corners of the deck, 1e-9, and its turning
    assert push @ uphill / (push @ out) == pytest.approx(np.tan(np.radians(10)), rel=1e-6)


def test_texts_units_and_costs_are_read(incline):
    assert incline.scene.status == "complete" and "contact" in " ".join(incline.scene.effects)
    assert incline.history.units("area") == "length^2" and "area" in incline.history.description("area")
    assert list(incline.cost.phase) == ["read", "set-up", "search", "assemble", "solve", "judge", "check", "update", "sleep",
                                        "history", "frames", "other"]
    assert list(incline.cost.work) == ["factors by CHOLMOD", "factors by LU", "iterations of GMRES", "unknowns", "entries"]
    # one block is no sparse matrix
    assert list(incline.cost["count"]) == [0, 0, 0, 6, 36]
    assert incline.seconds("steps") == incline.cost.wall_seconds[2:9].sum() > 0 == incline.seconds("factor")
    assert {"energy/kinetic", "time"} <= set(incline.history.series()) and {"energy", "time"} <= set(dir(incline.history))


def test_what_a_run_has_not_is_said_with_what_it_has(incline):
    with pytest.raises(AttributeError, match="expected history/energy/damping, found .*kinetic"):
        incline.history.energy.damping
    with pytest.raises(KeyError, match="expected history/weather"):
        incline["history/weather"]
    assert "damping" not in incline.history.energy and "kinetic" in incline.history.energy
    assert scree.run(T4, output=incline.path.parent / "t4.h5").contacts_of() is None


def test_a_file_that_was_run_again_is_not_mixed_with_the_one_that_was_read(tmp_path):
    first = scree.run(T4, output=tmp_path / "x.h5", settings=["step.count=5"])
    assert len(first.history.time) == 5
    scree.run(T4, output=tmp_path / "x.h5", settings=["step.count=7"])
    assert len(first.history.time) == 5  # it was asked for before
    with pytest.raises(scree.ResultsError, match="has changed since it was read"):
        first.history.area


def test_rows_beyond_the_frames_that_count_and_those_that_not_all_series_have_are_left_out(tmp_path):
    """As a run leaves them that was killed while it wrote."""
    r = scree.run(T4, output=tmp_path / "x.h5", settings=["output.every=1", "step.count=6"])
    area, time = r.bodies.area, r.history.time
    with h5py.File(r.path, "a") as f:
        f["VTKHDF/Steps"].attrs["NSteps"] = np.int64(5)
        f["history/solves"].resize(4, axis=0)
    r = scree.read(r.path)
    np.testing.assert_array_equal(r.bodies.area, area[:5])
    np.testing.assert_array_equal(r.history.time, time[:4])
    assert len(r.times) == 5 and len(r.measured_points.position) == 4


def test_files_that_are_no_results_are_refused_in_one_line(tmp_path):
    (tmp_path / "text.h5").write_text("no HDF5")
    with h5py.File(tmp_path / "other.h5", "w") as f:
        f["x"] = 1
    for name, words in (("none.h5", "expected a results file"), ("text.h5", "expected a results file"),
                        ("other.h5", "another HDF5 file")):
        with pytest.raises(scree.ResultsError, match=words) as refused:
            scree.read(tmp_path / name)
        assert len(str(refused.value).splitlines()) == 1 and name in str(refused.value)


def test_a_run_that_fails_says_what_the_program_says(tmp_path):
    (tmp_path / "bad.ana").write_text("1 2 x\n")
    with pytest.raises(scree.RunFailed, match=r"bad\.ana:1: expected") as failed:
        scree.run(tmp_path / "bad.ana")
    assert failed.value.status == 2 and failed.value.said == f"scree: {failed.value}\n"
    done = scree.call("run", tmp_path / "bad.ana")
    assert done.returncode == 2 and done.stderr == failed.value.said


def test_the_program_is_the_one_named_else_that_of_the_variable(tmp_path, monkeypatch):
    other = tmp_path / "other"
    other.write_text("#!/bin/sh\necho other\n")
    other.chmod(0o755)
    assert scree.call("--version", path=other).stdout == "other\n"
    monkeypatch.setenv("SCREE", str(other))
    assert scree.program() == other and scree.call("--version").stdout == "other\n"
    monkeypatch.setenv("SCREE", str(tmp_path / "none"))
    with pytest.raises(scree.ProgramMissing, match="none"):
        scree.call("--version")


def test_the_package_needs_no_installation_and_no_folder(tmp_path):
    """From anywhere, with tools/ in the path alone; and it leaves no compiled files beside its sources."""
    code = f"import scree; print(scree.run({str(T4)!r}, output='x.h5', settings=['step.count=2']).n_frames)"
    done = subprocess.run([sys.executable, "-B", "-c", code], cwd=tmp_path, capture_output=True, text=True,
                          env={**os.environ, "PYTHONPATH": str(SOURCE / "tools")})
    assert done.returncode == 0 and int(done.stdout) >= 2, done.stderr


def test_settings_are_given_by_name_with_all_their_digits(tmp_path):
    """A number, a list, numpy's numbers, a word, a number of a material; as the texts do."""
    given = {"step.size": 0.1 / 3, "step.count": np.int64(3), "damping.mass": np.float64(0.7), "method.plane": "strain",
             "acceleration.table": [0, 1, (2.5, 1), np.array([1, 0])], "material(1).ma": 2000}
    texts = [f"step.size={0.1 / 3}", "step.count=3", "damping.mass=0.7", "method.plane=strain", "acceleration.table=0 1 2.5 1 1 0",
             "material(1).ma=2000"]
    by_name = scree.run(T4, output=tmp_path / "a.h5", set=given)
    by_text = scree.run(T4, output=tmp_path / "b.h5", settings=texts)
    assert len(by_name.history.time) == 3 and by_name.history.step_size[0] == 0.1 / 3
    np.testing.assert_array_equal(by_name.vertices(), by_text.vertices())
    for wrong in (True, None, object()):
        with pytest.raises(TypeError, match="a text, a number or a list"):
            scree.run(T4, output=tmp_path / "c.h5", set={"step.size": wrong})
    with pytest.raises(scree.RunFailed, match="step.size above 0"):
        scree.run(T4, output=tmp_path / "c.h5", set={"step.size": -1})


def test_tables_hold_the_arrays_of_the_file(incline):
    steps = incline.table_of_steps()
    np.testing.assert_array_equal(steps.index, incline.history.time)
    np.testing.assert_array_equal(steps["energy/kinetic"], incline.history.energy.kinetic)
    assert steps.shape[0] == 20 and "rotation" not in steps and "time" not in steps
    blocks = incline.table_of_blocks(7)
    assert list(blocks.index) == [1, 2] and blocks.index.name == "block"
    np.testing.assert_array_equal(blocks[["centroid_x", "centroid_y"]], incline.bodies.centroid[7])
    np.testing.assert_array_equal(blocks[["stress_xx", "stress_yy", "stress_xy"]], incline.bodies.stress[7])
    np.testing.assert_array_equal(blocks["area"], incline.bodies.area[7])
    contacts, expected = incline.table_of_contacts(), incline.contacts_of()
    assert len(contacts) == len(expected) > 0 and set(contacts["state"]) <= {"sliding", "locked"}
    np.testing.assert_array_equal(contacts[["normal_force", "shear_force"]], expected.force)
    np.testing.assert_array_equal(contacts[["vertex_block", "edge_block"]], expected.blocks)
    spin = scree.run(T4, output=incline.path.with_name("t4.h5"), set={"step.count": 1})
    assert len(spin.table_of_contacts()) == 0 and list(spin.table_of_contacts()) == list(contacts)


def test_shapes_have_the_holes_of_the_elements(tmp_path):
    """A square of 10 with a hole of 2 x 2 and one of 1 x 1."""
    (tmp_path / "g.geo").write_text(
        "0.001 12 12 0 0 1 0 0 2\n0 0 10 0 1\n10 0 10 10 1\n10 10 0 10 1\n0 10 0 0 1\n2 2 4 2 1\n4 2 4 4 1\n4 4 2 4 1\n2 4 2 2 1\n"
        "6 6 7 6 1\n7 6 7 7 1\n7 7 6 7 1\n6 7 6 6 1\n1 1 1 1\n3 3\n6.5 6.5\n")
    (tmp_path / "a.ana").write_text("1 1 1 1 0.05 0.01\n1 0 1e6 0.2\n0 0 0\n0 0 0\n0 0 0\n30 0 0\n&deck geometry='g.geo' /\n")
    shape, = scree.run(tmp_path / "a.ana").shapes(0)
    assert shape.is_valid and sorted(hole.length for hole in shape.interiors) == pytest.approx([4, 8])
    assert shape.area == pytest.approx(95, rel=1e-12) and shape.exterior.length == pytest.approx(40)


def test_a_notebook_shows_facts_and_a_picture(incline):
    png, text = incline._repr_png_(), incline._repr_html_()
    assert png.startswith(b"\x89PNG") and len(png) > 3000
    assert base64.b64decode(re.search(r"base64,([^\"]*)", text)[1]).startswith(b"\x89PNG")
    assert "<td>2</td>" in text and "frames</th><td>21, to t = 0.2" in text and str(incline.path) in text


def test_what_is_public_has_a_docstring_and_types():
    things = [getattr(scree, name) for name in scree.__all__ if not name.endswith(("Error", "Missing", "Failed"))]
    things += [method for name, method in inspect.getmembers(scree.Results, inspect.isfunction) if not name.startswith("_")]
    for thing in things:
        assert thing.__doc__, thing
        if inspect.isfunction(thing) and thing is not scree.Runner:
            assert {*inspect.signature(thing).parameters} - {"self"} <= {*thing.__annotations__}, thing
            assert "return" in thing.__annotations__, thing
    assert (SOURCE / "tools" / "scree" / "py.typed").exists()


@pytest.fixture(scope="module")
def pip_folder(tmp_path_factory):
    """A copy of what pip needs of the sources, the package that pip installed from there, and a program that is in no tree."""
    folder = tmp_path_factory.mktemp("pip")
    shutil.copytree(SOURCE / "tools", folder / "tree" / "tools", ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "CMakeLists.txt", "README.md", "LICENSE"):
        shutil.copy(SOURCE / name, folder / "tree" / name)
    done = subprocess.run([sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--no-warn-script-location", "--disable-pip-version-check",
                           "--root-user-action", "ignore", "--config-settings", "wheel.cmake=false", "--target", folder / "site", folder / "tree"],
                          cwd=folder, capture_output=True, text=True)
    if "scikit-build-core" in done.stderr and "No matching distribution" in done.stderr:
        pytest.skip("pip does not reach PyPI, where scikit-build-core is")
    assert done.returncode == 0, done.stderr
    (folder / "bin").mkdir()
    shutil.copy(os.environ["SCREE"], folder / "bin" / "scree")
    return folder


def test_the_package_installs_with_the_commands(pip_folder, tmp_path):
    """By pip into a folder of its own; its commands run elsewhere, by the program of the shell's path."""
    site = pip_folder / "site"
    commands = {path.name for path in (site / "bin").iterdir()}
    python = {path.name for path in (SOURCE / "tools").iterdir() if path.is_file() and path.read_text().startswith("#!/usr/bin/python3")}
    assert commands == {"scree-" + name.replace("_", "-") for name in python - {"figures", "gallery"}}  # which are of the manual
    environment = {"PATH": f"{pip_folder / 'bin'}:/usr/bin:/bin", "PYTHONPATH": str(site), "HOME": str(tmp_path)}
    code = f"import scree; print(scree.__file__, scree.run({str(T4)!r}, output='x.h5', set={{'step.count': 2}}).n_frames)"
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert done.returncode == 0 and str(site) in done.stdout, done.stderr
    done = subprocess.run([site / "bin" / "scree-plot", "x.h5"], cwd=tmp_path, capture_output=True, text=True, env=environment)
    assert done.returncode == 0 and (tmp_path / "x.png").exists(), done.stderr
    for command, words in (("plot", ["y.h5"]), ("fs", ["y.ana"]), ("compare-shi", ["y.h5", "y.replay"]), ("study", ["y.csv"])):
        name = f"scree-{command}"  # what they say begins with their own names, and their help has these
        words, page = (subprocess.run([site / "bin" / name, *given], cwd=tmp_path, capture_output=True, text=True,
                                      env=environment) for given in (words, ["--help"]))
        assert words.returncode == 2 and words.stderr.startswith(f"{name}: ") and "tools/" not in words.stderr
        assert f"{name} " in page.stdout.partition("\n\n")[2] and "tools/" not in page.stdout, page.stdout


def test_every_command_starts_without_the_optional_packages():
    project = tomllib.loads((SOURCE / "pyproject.toml").read_text())["project"]
    named = [re.match("[A-Za-z0-9]+", word)[0].lower() for words in project["optional-dependencies"].values() for word in words]
    modules = sorted({place.partition(":")[0] for place in project["scripts"].values()})
    code = f"import importlib, sys\nsys.modules.update(dict.fromkeys({named}))\nfor name in {modules}: importlib.import_module(name)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env={**os.environ, "PYTHONPATH": str(SOURCE / "tools")})
    assert "ezdxf" in named and "matplotlib" not in named and done.returncode == 0, done.stderr


@pytest.mark.parametrize("decks", ["none", "variable", "tree of the package", "tree of the program", "beside the program"])
def test_installed_commands_find_their_decks_or_say_how_to_name_them(decks, pip_folder, tmp_path):
    environment = {"PATH": f"{pip_folder / 'bin'}:/usr/bin:/bin", "PYTHONPATH": str(pip_folder / "site"), "HOME": str(tmp_path)}
    link = None
    if decks == "variable":
        environment["SCREE_INPUT"] = str(SOURCE / "input")
    elif decks == "tree of the package":
        link = pip_folder / "tree" / "input"
    elif decks == "beside the program":
        link = pip_folder / "share" / "scree" / "input"
    elif decks == "tree of the program":
        link = tmp_path / "input"
        built = tmp_path / "build" / "release" / "bin"
        built.mkdir(parents=True)
        environment["SCREE"] = shutil.copy(os.environ["SCREE"], built / "scree")
    if link:
        link.parent.mkdir(parents=True, exist_ok=True)
        link.symlink_to(SOURCE / "input")
    try:
        for command, words in (("validate", ["b7"]), ("paper", ["rotation"]))[:2 if decks == "none" else 1]:
            done = subprocess.run([pip_folder / "site" / "bin" / f"scree-{command}", *words], cwd=tmp_path, capture_output=True, text=True,
                                  env=environment)
            if decks == "none":
                assert done.returncode == 2 and not done.stdout and len(done.stderr.splitlines()) == 1
                assert "expected decks of scree" in done.stderr and "SCREE_INPUT" in done.stderr
            else:
                assert done.returncode == 0 and not done.stderr, done.stdout + done.stderr
        if decks == "variable":  # all runs of the paper take ten seconds; a stand-in of the program says what the first is asked for
            asked = tmp_path / "asked"
            asked.write_text('#!/bin/sh\necho "asked for $2" >&2\nexit 2\n')
            asked.chmod(0o755)
            done = subprocess.run([pip_folder / "site" / "bin" / "scree-paper", "rotation"], cwd=tmp_path, capture_output=True, text=True,
                                  env=environment | {"SCREE": str(asked)})
            assert done.stderr == f"scree-paper: asked for {SOURCE}/input/paper/rotation/table3-1.ana\n"
    finally:
        if link:
            link.unlink()


@pytest.mark.parametrize("name", ["validate", "bench", "plot", "compare_shi", "paper", "map", "dxf2geo"])
def test_the_commands_tell_how_they_are_used_from_any_folder(name, tmp_path):
    done = subprocess.run([SOURCE / "tools" / name, "--help"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and f"tools/{name}" in done.stdout, done.stderr
