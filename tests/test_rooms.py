"""The rooms of src/: the build lets each use those before it, and none after it."""
import os
import pathlib
import subprocess

import pytest

BUILD = pathlib.Path(os.environ["SCREE"]).parents[1]
ROOMS = os.environ["SCREE_ROOMS"].split()
NEIGHBOURS = list(zip(ROOMS, ROOMS[1:]))


def compile_use(sees, uses):
    """Compiles a source of the room `sees` that uses a module of another room."""
    return subprocess.run(["cmake", "--build", BUILD, "--target", f"room_{sees}_uses_{uses}"], capture_output=True, text=True)


def test_every_folder_of_sources_is_a_room():
    folders = {path.name for path in (pathlib.Path(os.environ["SCREE_SOURCE"]) / "src").iterdir() if path.is_dir()}
    assert folders == set(ROOMS)


@pytest.mark.parametrize("lower, upper", NEIGHBOURS)
def test_a_room_uses_one_before_it(lower, upper):
    done = compile_use(upper, lower)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("lower, upper", NEIGHBOURS)
def test_a_backward_use_does_not_compile(lower, upper):
    done = compile_use(lower, upper)
    assert done.returncode != 0
    assert "Cannot open module file" in done.stdout + done.stderr
