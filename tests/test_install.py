"""What `cmake --install` leaves: a folder that may be moved, with program, commands, decks, man page and completion."""
import os
import pathlib
import re
import shutil
import subprocess
import tomllib

import pytest
import scree

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
BUILD = pathlib.Path(os.environ["SCREE"]).parents[1]
COMMANDS = re.findall(r"^(scree-[a-z0-9-]+) = ", (SOURCE / "pyproject.toml").read_text(), re.M)


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The folder, moved after it was installed."""
    folder = tmp_path_factory.mktemp("installed")
    subprocess.run(["cmake", "--install", BUILD, "--prefix", folder / "first"], check=True, stdout=subprocess.DEVNULL)
    return (folder / "first").rename(folder / "moved")


def call(folder, name, *words, cwd, **more):
    """Runs something of the folder, with nothing else of scree in sight."""
    return subprocess.run([folder / "bin" / name, *words], cwd=cwd, capture_output=True, text=True,
                          env={"PATH": "/usr/bin:/bin", "HOME": str(cwd), **more})


def test_a_moved_folder_runs_and_draws_its_decks(installed, tmp_path):
    deck = installed / "share" / "scree" / "input" / "paper" / "rotation" / "t4.ana"
    done = call(installed, "scree", "run", deck, "--set", "step.count=3", "--quiet", cwd=tmp_path)
    assert done.returncode == 0 and len(scree.read(tmp_path / "t4.h5").history.time) == 3, done.stderr
    done = call(installed, "scree-plot", "t4.h5", cwd=tmp_path)
    assert done.returncode == 0 and (tmp_path / "t4.png").exists(), done.stderr
    done = call(installed, "scree-plot", deck, "-o", "deck.png", cwd=tmp_path)  # by the program beside it
    assert done.returncode == 0 and (tmp_path / "deck.png").exists(), done.stderr


def test_each_command_is_there_and_says_how_it_is_used(installed, tmp_path):
    assert {path.name for path in (installed / "bin").iterdir()} == {"scree", *COMMANDS} and len(COMMANDS) > 10
    page = (installed / "share" / "man" / "man1" / "scree.1").read_text().replace("\\-", "-")
    for name in COMMANDS:
        assert f" {name}" in page and (installed / "share" / "man" / "man1" / f"{name}.1").read_text() == ".so man1/scree.1\n"
        done = call(installed, name, "--help", cwd=tmp_path)
        assert done.returncode == 0 and "usage: " + name in done.stdout, done.stderr
    assert not list(installed.rglob("__pycache__"))


def test_an_installed_command_finds_its_decks(installed, tmp_path):
    done = call(installed, "scree-validate", "b7", cwd=tmp_path)
    assert done.returncode == 0 and "every tolerance is met" in done.stdout, done.stdout + done.stderr


def test_a_blas_that_is_asked_for_is_linked(tmp_path):
    """Where OpenBLAS is there as well. Without man page and Python, which are switches."""
    done = subprocess.run(["cmake", "-S", SOURCE, "-B", tmp_path, "-DBUILD_TESTING=OFF", "-DCMAKE_BUILD_TYPE=Release", "-DBLA_VENDOR=Generic",
                           "-DSCREE_MAN_PAGE=OFF", "-DSCREE_PYTHON=OFF"], capture_output=True, text=True)
    if "LAPACK (OpenBLAS, or another) not found" in done.stderr:
        pytest.skip("no libblas.so and liblapack.so")
    assert done.returncode == 0, done.stderr
    words = (tmp_path / "src" / "CMakeFiles" / "scree.dir" / "link.txt").read_text().split()
    linked = {pathlib.Path(word).name.split(".")[0] for word in words if ".so" in word or ".a" in word}
    assert {"libblas", "liblapack"} <= linked and "libopenblas" not in linked
    script = (tmp_path / "packaging" / "cmake_install.cmake").read_text()
    assert "scree.bash" in script and "man1" not in script and "dist-packages" not in script


def test_a_package_that_is_missing_is_one_line(installed, tmp_path):
    (tmp_path / "matplotlib.py").write_text("raise ModuleNotFoundError('none', name='matplotlib')\n")
    done = call(installed, "scree-plot", "x.h5", cwd=tmp_path, PYTHONPATH=str(tmp_path))
    assert done.returncode == 2 and done.stderr == ("scree-plot: expected the Python package matplotlib, found none: on Debian, "
                                                    "apt-get install python3-matplotlib\n")


def test_the_man_page_says_what_the_program_says(installed):
    page = (installed / "share" / "man" / "man1" / "scree.1").read_text()
    plain = page.replace("\\-", "-").replace("\\&", "").replace("\\e", "\\")
    for line in scree.call("--help").stdout.splitlines()[3:]:
        assert line.removeprefix("Exit status: ") in plain, line
    settings, rules = scree.call("explain", "--settings").stdout.split("\n\n")
    for line in settings.splitlines()[2:]:
        name, values, unit, default, meaning = (cell.strip() for cell in line.strip("|").split("|"))
        text = "; ".join(filter(None, [meaning, values])) + (f" [{unit}]" if unit else "")
        assert f".B {name.strip('`')}\n{text}; default: {default}\n" in plain, name
    for line in rules.splitlines()[2:]:
        name, other, why = (cell.strip() for cell in line.strip("|").split("|"))
        assert f".B {name.strip('`')}\n{other}: {why}\n" in plain, name


@pytest.mark.parametrize("words, offered", [
    (["ru"], ["run"]), (["e"], ["estimate", "explain"]), (["--v"], ["--version"]), (["run", "--sum"], ["--summary"]),
    (["run", "a.ana", "--summary", ""], ["json"]), (["run", "--set", "integrator.b"], ["integrator.beta="]), (["run", "a"], [])])
def test_bash_completes_verbs_options_and_settings(words, offered, installed):
    script = ('compopt() { :; }; source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _scree; printf "%s\\n" "${COMPREPLY[@]}"')
    completion = installed / "share" / "bash-completion" / "completions" / "scree"
    done = subprocess.run(["bash", "-c", script, "bash", completion, installed / "bin" / "scree", *words], capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout.split() == offered and not done.stderr


@pytest.mark.parametrize("manager", ["none", "dnf"])
def test_packages_are_installed_with_what_the_system_has_or_listed(manager, tmp_path):
    """A stand-in of dnf prints what it is asked for; that of rpm has make alone."""
    for name in ("sh", "id", "grep"):
        (tmp_path / name).symlink_to(shutil.which(name))
    if manager == "dnf":
        for name, text in (("dnf", 'echo "$@" >&2'), ("rpm", '[ "$4" = make ]'), ("sudo", '"$@"')):
            (tmp_path / name).write_text(f"#!/bin/sh\n{text}\n")
            (tmp_path / name).chmod(0o755)
    done = subprocess.run([tmp_path / "sh", "-euc", "name=quickstart; . tools/install_packages; echo done"], cwd=SOURCE, capture_output=True,
                          text=True, env={"PATH": str(tmp_path)})
    if manager == "none":
        assert done.returncode == 2 and not done.stdout and len(done.stderr.splitlines()) == 1
        assert done.stderr.startswith("quickstart: expected apt or dnf") and "HDF5 1.10 with Fortran" in done.stderr
    else:
        words = done.stderr.split()
        assert done.returncode == 0 and words[:3] == ["install", "-q", "-y"] and "hdf5-devel" in words and "make" not in words


def test_without_python_packages_the_python_tests_are_left_out_and_said(tmp_path):
    (tmp_path / "python").write_text('#!/bin/sh\n[ "$1" = -c ] && case "$2" in *h5py*) exit 1;; esac\nexec /usr/bin/python3 "$@"\n')
    (tmp_path / "python").chmod(0o755)
    done = subprocess.run(["cmake", "-S", SOURCE, "-B", tmp_path / "build", f"-DPython3_EXECUTABLE={tmp_path / 'python'}"],
                          capture_output=True, text=True)
    assert done.returncode == 0 and "Python tests are left out" in done.stderr and "apt-get install python3-pytest" in done.stderr, done.stderr
    listed = subprocess.run(["ctest", "--test-dir", tmp_path / "build", "-N"], capture_output=True, text=True).stdout
    assert "test_install" not in listed and "Total Tests: 0" not in listed


def test_there_is_one_version():
    """It stands in CMakeLists.txt, where the program and pyproject.toml take it from; tools/release compares the texts that name it."""
    version = re.search(r"project\(scree VERSION (\S+)", (SOURCE / "CMakeLists.txt").read_text())[1]
    assert scree.version()["version"] == f"scree {version}" == scree.call("--version").stdout.splitlines()[0]
    wanted = tomllib.loads((SOURCE / "pyproject.toml").read_text())["tool"]["scikit-build"]["metadata"]["version"]
    assert re.search(wanted["regex"], (SOURCE / wanted["input"]).read_text())["value"] == version
    done = subprocess.run([SOURCE / "tools" / "release"], capture_output=True, text=True)
    assert done.returncode == 0 and f"version {version} in all files" in done.stdout and not done.stderr, done.stderr


RELEASED = {"CMakeLists.txt": "project(scree VERSION 3.1.0 LANGUAGES C)\n", "CITATION.cff": "version: 3.1.0\ndate-released: 2031-05-06\n",
            "doc/cite.md": "      version = {3.1.0},\n", "doc/changes.md": "# Changes\n\n## 3.1.0 (2031-05-06)\n\n## 3.0.0 (2030-05-06)\n",
            "debian/changelog": "scree (3.1.0) unstable; urgency=medium\n"}


@pytest.mark.parametrize("file, text, status, said", [
    (None, "", 0, ""),
    *((file, text.replace("3.1.0", "3.1.1"), 1, f"{file}: expected version 3.1.0 of CMakeLists.txt, found '3.1.1'")
      for file, text in RELEASED.items() if file != "CMakeLists.txt"),
    ("doc/changes.md", "## 3.1.0 (not yet tagged)\n", 0, "before the tag: give the date in doc/changes.md"),
    ("CITATION.cff", "version: 3.1.0\n", 0, "before the tag: give date-released"),
    ("debian/changelog", "scree (3.1.0) UNRELEASED; urgency=medium\n", 0, "before the tag: name the distribution"),
    ("other", "", 0, "before the tag: commit all changes"), ("tag", "", 0, "before the tag: raise the version")])
def test_a_release_says_what_disagrees_and_what_is_left(file, text, status, said, tmp_path):
    """By a tree of its own, with nothing left to do but for one file; without words it tags nothing."""
    for name, words in RELEASED.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text if name == file else words)
    (tmp_path / "tools").mkdir()
    for name in ("release", "say_help"):
        shutil.copy(SOURCE / "tools" / name, tmp_path / "tools")
    git = ["git", "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=a@b"]
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "all"], *([["tag", "3.1.0"]] if file == "tag" else [])):
        subprocess.run([*git, *words], check=True)
    if file == "other":
        (tmp_path / file).write_text(text)
    done = subprocess.run([tmp_path / "tools" / "release"], capture_output=True, text=True)
    assert done.returncode == status and said in done.stdout + done.stderr
    assert done.stdout.count("before the tag") == ("before the tag" in said)
    assert subprocess.run([*git, "tag"], capture_output=True, text=True).stdout == ("3.1.0\n" if file == "tag" else "")


def test_the_program_has_no_path_to_a_folder_of_the_system():
    """A path in the program would win over the libraries that the system's loader finds."""
    said = subprocess.run(["readelf", "-d", os.environ["SCREE"]], capture_output=True, text=True, check=True).stdout
    paths = [path for path in ":".join(re.findall(r"R(?:UN)?PATH.*\[(.*)\]", said)).split(":") if path]
    assert "NEEDED" in said and not [path for path in paths if path.startswith(("/usr/", "/lib"))], paths
