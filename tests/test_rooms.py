"""The rooms of src/: the build lets each use the rooms that its SEES lists, and no others."""
import os
import pathlib
import re
import subprocess

import pytest
from scree.house import rooms

BUILD = pathlib.Path(os.environ["SCREE"]).parents[1]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"]) / "src"
SEES = rooms.seen_by(SOURCE)
SEES.pop(rooms.TOP)
ROOMS = list(SEES)
UNSEEN = [*zip(ROOMS, ROOMS[1:]), *((room, lower) for k, room in enumerate(ROOMS) for lower in ROOMS[:k] if lower not in SEES[room])]


def compile_probes(what, rooms):
    """Compiles sources that use modules of rooms, all of them, in one call of the build: its exit status and what it says."""
    go_on = ["-k", "0"] if (BUILD / "build.ninja").exists() else ["-k"]
    targets = [f"{room}_uses_{what}" for room in rooms]
    done = subprocess.run(["cmake", "--build", BUILD, "--target", *targets, "--", *go_on], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def said():
    """What the compiler says of each use of a room that is not seen."""
    return compile_probes("others", dict(UNSEEN))[1]


def test_every_folder_of_sources_is_a_room():
    assert {path.name for path in SOURCE.iterdir() if path.is_dir()} == set(ROOMS)


def test_a_room_uses_those_of_its_list():
    status, said = compile_probes("its_list", [room for room in ROOMS if SEES[room]])
    assert status == 0, said


@pytest.mark.parametrize("room, unseen", UNSEEN)
def test_a_use_of_another_room_does_not_compile(room, unseen, said):
    assert re.search(rf"/{room}_uses_{unseen}\.f90:\d+:\d+:\n(?:(?!.*\.f90:).*\n)*Fatal Error: Cannot open module file", said), said
