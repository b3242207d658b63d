"""A run that is killed between any two of its writes, or in one where that goes on in another page of the system's memory, leaves a file
that has all that it had counted, and goes on from there."""
import io
import os
import pathlib
import shutil
import struct
import subprocess

import h5py
import numpy as np
import pytest
from scree import call

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
DECK = [SOURCE / "input/paper/arc/arc.ana", "--set", "step.count=100", "--set", "output.every=1", "--set", "output.checkpoint=1"]
FIELDS = ("Points", "PointData/velocity", "CellData/stress_xx", "Steps/Values")
OFTEN = int(os.environ.get("SCREE_OFTEN", 12))  # one of so many moments is looked at
PAGE = 4096  # bytes that a system writes at once


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A run of 101 frames, more than a node of HDF5's older indices holds, and all its writes in their order."""
    if not shutil.which("gcc"):
        pytest.skip("needs gcc")
    folder = tmp_path_factory.mktemp("torn")
    library = folder / "recorded_writes.so"
    subprocess.run(["gcc", "-shared", "-fPIC", "-O1", pathlib.Path(__file__).with_name("recorded_writes.c"), "-o", library, "-ldl"],
                   check=True)
    path, record = folder / "whole.h5", folder / "record"
    done = subprocess.run([SCREE, "run", *DECK, "-o", path, "--quiet"], stderr=subprocess.PIPE, text=True,
                          env={**os.environ, "LD_PRELOAD": str(library), "RECORDED": str(path), "RECORD": str(record)})
    assert done.returncode == 0, done.stderr
    writes, data, at = [], record.read_bytes(), 0
    while at < len(data):
        first, second = struct.unpack_from("qq", data, at)
        at += 16
        writes.append((first, data[at:at + max(0, second)] if second >= 0 else None))
        at += max(0, second)
    return path, list(parts(writes[:-3]))  # the last three cut it to its length


def parts(writes):
    """Writes up to the end of a page each: a run that is killed may have done the first of them alone."""
    for offset, data in writes:
        while data and offset // PAGE < (offset + len(data) - 1) // PAGE:
            first = PAGE - offset % PAGE
            yield offset, data[:first]
            offset, data = offset + first, data[first:]
        yield offset, data


def images(writes):
    """The file after each of its writes."""
    image = bytearray()
    for offset, data in writes:
        end = offset if data is None else offset + len(data)
        image.extend(bytes(max(0, end - len(image))))
        if data is None:
            del image[end:]
        else:
            image[offset:end] = data
        yield image


def lost(image, whole):
    """Names of what the file has lost of the frames and the checkpoint that it counts; None where it counts none as yet."""
    with h5py.File(io.BytesIO(image)) as file:
        try:
            n = file["VTKHDF/Steps"].attrs["NSteps"]
            frame, end = whole["checkpoint/frame"][:], whole["checkpoint/end"][:]
            k = int((frame < n).sum())
        except (KeyError, OSError):  # not all is there that the file is made of
            return None
        if n == 0:
            return None
        bad = [name for name in ("frame", "end", "rows") if file[f"checkpoint/{name}"][:k].tobytes()
               != whole[f"checkpoint/{name}"][:k].tobytes()]
        bad += [name for name in ["numbers"] if file["checkpoint/numbers"][:end[k - 1]].tobytes()
                != whole["checkpoint/numbers"][:end[k - 1]].tobytes()] if k else []
        bad += [name for name in whole["history"] if name in file["history"] and unreadable(file[f"history/{name}"])]
        for name in FIELDS:
            rows = n * (len(whole[f"VTKHDF/{name}"]) // len(frame_times(whole)))
            bad += [name] if file[f"VTKHDF/{name}"][:rows].tobytes() != whole[f"VTKHDF/{name}"][:rows].tobytes() else []
        return bad


def unreadable(item):
    """Whether an index or a head of the data is not whole."""
    try:
        return isinstance(item, h5py.Dataset) and item[:1] is None
    except OSError:
        return True


def frame_times(file):
    return file["VTKHDF/Steps/Values"]


def test_no_moment_loses_what_was_counted(recorded):
    path, writes = recorded
    counted = 0
    with h5py.File(path) as whole:
        assert len(frame_times(whole)) == 101
        for i, image in enumerate(images(writes)):
            if i < 300 or i % OFTEN:
                continue
            try:
                bad = lost(image, whole)
            except OSError as problem:
                bad = [str(problem)]
            assert not bad, f"after {i} of {len(writes)} writes: {bad}"
            counted += bad is not None
    assert counted > 3000 / OFTEN


def test_a_run_goes_on_from_any_moment(recorded, tmp_path):
    """Of some: the program itself finds the last checkpoint, where the one that was being written is not whole."""
    path, writes = recorded
    went_on = 0
    with h5py.File(path) as whole:
        for i, image in enumerate(images(writes)):
            if i < 300 or i % 997 or lost(image, whole) is None:
                continue
            (tmp_path / "part.h5").write_bytes(image)
            done = call("run", "--restart", tmp_path / "part.h5", "--quiet")
            if done.returncode == 2 and ("found none" in done.stderr or "beyond the checkpoint" in done.stderr):
                continue  # the first is not there as yet, or it is the last
            assert done.returncode == 0, done.stderr
            went_on += 1
            with h5py.File(tmp_path / "part.h5") as part:
                for name in ("VTKHDF/Points", "history/time", "history/rotation"):
                    assert part[name][:].tobytes() == whole[name][:].tobytes()
    assert went_on > 5
