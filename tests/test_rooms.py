"""The rooms of src/: the build lets each use the rooms that its SEES lists, and no others."""
import os
import pathlib
import subprocess

import pytest
from scree.house import rooms

BUILD = pathlib.Path(os.environ["SCREE"]).parents[1]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"]) / "src"
SEES = rooms.seen_by(SOURCE)
SEES.pop(rooms.TOP)
ROOMS = list(SEES)
UNSEEN = [*zip(ROOMS, ROOMS[1:]), *((room, lower) for k, room in enumerate(ROOMS) for lower in ROOMS[:k] if lower not in SEES[room])]


def compile_probe(name):
    """Compiles a source that uses modules of rooms."""
    return subprocess.run(["cmake", "--build", BUILD, "--target", f"room_{name}"], capture_output=True, text=True)


def test_every_folder_of_sources_is_a_room():
    assert {path.name for path in SOURCE.iterdir() if path.is_dir()} == set(ROOMS)


@pytest.mark.parametrize("room", [room for room in ROOMS if SEES[room]])
def test_a_room_uses_those_of_its_list(room):
    done = compile_probe(f"{room}_uses_its_list")
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.parametrize("room, unseen", UNSEEN)
def test_a_use_of_another_room_does_not_compile(room, unseen):
    done = compile_probe(f"{room}_uses_{unseen}")
    assert done.returncode != 0
    assert "Cannot open module file" in done.stdout + done.stderr
