"""Words of command lines that several tools take: what is a number, what is not, and what is said then."""
import argparse
import functools
import os
import pathlib
import subprocess

import ezdxf
import pytest
import scree
from scree.arguments import above_zero, whole_from

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
SLIDE = SOURCE / "input" / "validation" / "b1-slide" / "slope30.ana"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With results, a map and a table of a study."""
    folder = tmp_path_factory.mktemp("tools")
    scree.run(SLIDE, output=folder / "slide.h5", settings=["step.count=5"])
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
    (functools.partial(above_zero, below=1000), ("1000", "0"), "above 0 and below 1000")])
def test_what_is_no_such_number_is_refused(kind, words, said):
    for word in words:
        with pytest.raises(argparse.ArgumentTypeError, match=said) as refused:
            kind(word)
        assert f"found '{word}'" in str(refused.value)


@pytest.mark.parametrize("tool,words", [
    ("plot", ["slide.h5"]), ("film", ["slide.h5"]), ("report", ["slide.h5"]), ("contacts", ["slide.h5"]), ("dxf2geo", ["map.dxf"]),
    ("study", ["phi.csv", SLIDE, "--to"])])
@pytest.mark.parametrize("name", ["deck.ana", "deck.blk", "deck"])
def test_no_deck_is_written_over(folder, tool, words, name):
    """What is written has an ending of its own; that of a deck, or none, is refused."""
    deck = folder / name
    deck.write_text("a deck\n")
    said = one_line(folder, tool, *words, *([] if words[-1] == "--to" else ["-o"]), deck)
    assert " with the ending ." in said and said.endswith(f", found '{deck.suffix}'") and deck.read_text() == "a deck\n"
