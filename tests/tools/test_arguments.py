"""Words of command lines that several tools take: what is a number, what is not, and what is said then."""
import argparse
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time

import ezdxf
import pytest
import scree
from scree.arguments import above, above_zero, whole_from

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
SLIDE = SOURCE / "input" / "validation" / "b1-slide" / "slope30.ana"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With results, a map and a table of a study."""
    folder = tmp_path_factory.mktemp("tools")
    scree.run(SLIDE, output=folder / "slide.h5", settings=["step.count=5", "output.every=1"], words=["--classic-output"])
    drawing = ezdxf.new()
    for start, end in (((0, 0), (4, 0)), ((4, 0), (0, 3)), ((0, 3), (0, 0))):
        drawing.modelspace().add_line(start, end)
    drawing.saveas(folder / "map.dxf")
    (folder / "phi.csv").write_text("joint(1).phi\n30\n")
    return folder


def one_line(folder, tool, *words, status=2):
    """What a tool says, which is one line."""
    done = subprocess.run([SOURCE / "tools" / tool, *words], cwd=folder, capture_output=True, text=True)
    line, = done.stderr.splitlines()
    assert done.returncode == status and line.startswith(f"tools/{tool}: "), done.stderr
    return line


def test_numbers_are_taken():
    assert [whole_from(1)(word) for word in ("1", "12", "007")] == [1, 12, 7]
    assert [above_zero(word) for word in ("1e-3", "2", " 5 ")] == [1e-3, 2, 5]


@pytest.mark.parametrize("kind,words,said", [
    (whole_from(1), ("0", "-1", "1.5", "x", "", "1e3", "²"), "a whole number from 1"), (whole_from(2), ("1",), "from 2"),
    (above_zero, ("0", "-1", "nan", "inf", "x", ""), "a number above 0, found"),
    (above(0, below=1000), ("1000", "0"), "above 0 and below 1000"),
    (above(1), ("1", "0.5", "inf"), "a number above 1, found")])
def test_what_is_no_such_number_is_refused(kind, words, said):
    for word in words:
        with pytest.raises(argparse.ArgumentTypeError, match=said) as refused:
            kind(word)
        assert f"found '{word}'" in str(refused.value)


@pytest.mark.parametrize("tool,words,name", [
    *(("contacts", ["slide.h5"], name) for name in ("deck.ana", "deck.blk", "deck")),
    *((tool, ["slide.h5"], "deck.ana") for tool in ("plot", "film", "report")),
    ("map", ["map.dxf"], "deck.ana"), ("study", ["phi.csv", SLIDE, "--to"], "deck.ana")])
def test_no_deck_is_written_over(folder, tool, words, name):
    """What is written has an ending of its own; that of a deck, or none, is refused."""
    deck = folder / name
    deck.write_text("a deck\n")
    said = one_line(folder, tool, *words, *([] if words[-1] == "--to" else ["-o"]), deck)
    assert " with the ending ." in said and said.endswith(f", found '{deck.suffix}'") and deck.read_text() == "a deck\n"


@pytest.mark.parametrize("tool,name,said", [
    *(("contacts", name, name or ".") for name in (".", "/", "", "..")), *((tool, "a.h5", "a.h5") for tool in ("plot", "film", "report", "contacts", "map"))])
def test_a_directory_is_no_file(folder, tool, name, said):
    (folder / "a.h5").mkdir(exist_ok=True)
    assert one_line(folder, tool, name) == f"tools/{tool}: {said}: expected a file, found a directory"


@pytest.mark.parametrize("tool,words", [("plot", []), ("bench", ["problems"])])
def test_what_is_no_results_file_is_one_line(folder, tool, words):
    """Without the words of HDF5, which has many."""
    (folder / "a.h5").mkdir(exist_ok=True)
    (folder / "text.h5").write_text("no HDF5")
    for name, why in (("none.h5", "No such file or directory"), ("a.h5", "Is a directory"),
                      ("text.h5", "file signature not found")):
        said = one_line(folder, tool, *words, name, *(["-o", "p.png"] if tool == "plot" else []))
        assert said == f"tools/{tool}: {name}: expected a results file, found: {why}"


@pytest.mark.parametrize("words,said", [
    (["--edges", "0"], "a number above 0"), (["--edges", "1", "-1"], "a number above 0"), (["--steps", "0"], "a number above 0"),
    (["--limit", "-1"], "a number above 0"), (["--random", "0"], "a whole number from 1"),
    (["--random", "1", "--first", "-1"], "a whole number from 0"), (["--sheet", "x.foo"], "x.foo: expected a picture with the ending .")])
def test_hard_scenes_refuse_what_is_no_size_number_or_picture(folder, words, said):
    done = subprocess.run([SOURCE / "tools" / "hard", "H1", *words], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 2 and not done.stdout and said in done.stderr.splitlines()[-1], done.stderr


@pytest.mark.parametrize("tool,words", [
    ("fs", [SLIDE, "-o"]), ("study", ["phi.csv", SLIDE, "-o"]), ("cost_of_accuracy", [SLIDE, "--folder"]), ("validate", ["b1", "--keep"]),
    ("paper", ["arc", "--keep"]), ("hard", ["H1", "--keep"])])
def test_a_folder_that_cannot_be_made_is_refused(folder, tool, words):
    for path in (folder / "map.dxf", folder / "map.dxf" / "below"):
        said = one_line(folder, tool, *words, path)
        assert "expected a folder to write into, found" in said and path.name in said


@pytest.mark.parametrize("tool,words", [("fs", [SLIDE]), ("study", ["phi.csv", SLIDE]), ("plot", ["slide.h5"]), ("report", ["slide.h5"]),
                                        ("map", ["map.dxf"]), ("validate", ["b1"])])
def test_a_full_disk_is_one_line(folder, tool, words):
    with open("/dev/full", "w") as full:
        done = subprocess.run([SOURCE / "tools" / tool, *words], cwd=folder, stdout=full, stderr=subprocess.PIPE, text=True)
    lines = [line for line in done.stderr.splitlines() if not line.startswith("study: ")]  # but for how far it is
    assert done.returncode == 2 and lines == [f"tools/{tool}: cannot go on: No space left on device"], done.stderr


@pytest.mark.parametrize("tool,words", [("fs", [SLIDE]), ("study", ["phi.csv", SLIDE]), ("plot", ["slide.h5"]),
                                        ("validate", ["b1"]), ("compare_shi", ["slide.h5", "slide.replay"])])
def test_who_reads_may_stop_without_a_word(folder, tool, words):
    """As `head` does; what is written is written, and the exit status is that of others that a pipe ends."""
    reads, writes = os.pipe()
    os.close(reads)
    with os.fdopen(writes, "w") as pipe:
        done = subprocess.run([SOURCE / "tools" / tool, *words], cwd=folder, stdout=pipe, stderr=subprocess.PIPE, text=True)
    lines = [line for line in done.stderr.splitlines() if not line.startswith("study: ")]  # but for how far it is
    assert done.returncode == 141 and not lines, done.stderr


@pytest.mark.parametrize("tool,words", [("fs", [SLIDE]), ("gallery", ["slope", "arch", "--jobs", "1"]), ("film", ["long.h5", "-o", "film.gif"])])
def test_ctrl_c_is_one_line(folder, tool, words):
    """While a run goes on that does not end, or frames are drawn. What is half done is not left."""
    endless, begun = folder / "endless", folder / "begun"
    endless.write_text(f"#!/bin/sh\n[ $1 = run ] || exec {os.environ['SCREE']} \"$@\"\ntouch {begun}\nexec sleep 100\n")
    endless.chmod(0o755)
    begun.unlink(missing_ok=True)
    if tool == "film":
        scree.run(SLIDE, output=folder / "long.h5", settings=["step.count=400", "output.every=1"])
    process = subprocess.Popen([SOURCE / "tools" / tool, *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                               env=os.environ | {"SCREE": str(endless)}, start_new_session=True)
    if tool == "film":
        assert process.stderr.readline() == "film: 41 of 401 frames\n"
    else:
        wait_for(begun, process)
    os.killpg(process.pid, signal.SIGINT)  # as a terminal does
    said = [line for line in process.communicate()[1].splitlines() if not line.startswith("film: ")]
    assert process.returncode == 130 and said == [f"tools/{tool}: stopped"]
    assert not list(folder.glob("film*")) and not list(folder.glob("*/trial.h5"))


def test_ctrl_c_where_python_passes_over_exceptions_comes_again():
    """As while it frees what a picture had."""
    main = ("import signal, time\nfrom scree.arguments import ends_in_a_line\nclass Freed:\n def __del__(self):\n  signal.raise_signal(signal.SIGINT)\n"
            "@ends_in_a_line\ndef main():\n freed = Freed()\n del freed\n time.sleep(60)\nraise SystemExit(main())")
    done = subprocess.run([sys.executable, "-c", main], capture_output=True, text=True, timeout=50,
                          env=os.environ | {"PYTHONPATH": str(SOURCE / "tools")})
    assert done.returncode == 130 and len(done.stderr.splitlines()) == 1 and done.stderr.endswith(": stopped\n"), done.stderr


def wait_for(path, process):
    until = time.monotonic() + 60
    while not path.exists():
        assert time.monotonic() < until and process.poll() is None
        time.sleep(0.01)


@pytest.mark.parametrize("tool", ["api", "check", "quickstart", "test"])
def test_tools_of_the_sources_say_what_they_do(tmp_path, tool):
    """And do nothing: they have no program but those that this takes."""
    for name in ("dirname", "sed"):
        (tmp_path / name).symlink_to(shutil.which(name))
    for word in ("--help", "-h"):
        done = subprocess.run([SOURCE / "tools" / tool, word], env={"PATH": str(tmp_path)}, capture_output=True, text=True)
        opening = [line.removeprefix("#").removeprefix(" ") for line in (SOURCE / "tools" / tool).read_text().split("set -eu")[0].splitlines()[1:]]
        assert done.returncode == 0 and done.stdout.splitlines() == opening and len(opening) > 1 and not done.stderr
