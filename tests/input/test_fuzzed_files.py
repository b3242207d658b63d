"""Files that were changed at random, word by word, are read or refused: in words, quickly, in little memory, and nothing dies.

What is changed are decks that are right, so most of what comes out is nearly right. A number draws an input: a failure names it.
"""
import contextlib
import io
import os
import pathlib
import random
import re
import resource
import subprocess
import sys
from unittest import mock

import pytest
from scree.maps import command

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
INPUTS = int(os.environ.get("SCREE_INPUTS", 600))  # of all kinds together
SECONDS, MEMORY = 60, 8 * 2**30  # the first is for machines that do much else, too
SPECIAL = ["0", "-1", "1", "2", "3", "1e-300", "1e300", "-1e20", "1e20", "nan", "inf", "2147483648", "999999999", "1000000000000", "0.5",
           "1.0d5", "1,5", "abc", "&", "/", "'", "''", "=", "!", "&step", "$Nodes", "1e", "-", "\x00", "\xff", "é", "\t", ""]
MESH = ("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 6 1 6\n2 1 0 6\n1\n2\n3\n4\n5\n6\n-1 -1 0\n1 -1 0\n3 -1 0\n-1 3 0\n1 3 0\n"
        "3 3 0\n$EndNodes\n$Elements\n1 4 1 4\n2 1 2 4\n1 1 2 5\n2 1 5 4\n3 2 3 6\n4 2 6 5\n$EndElements\n")
SQUARE = "0.001 4 0 0 0 0 0 0 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n"
MATERIAL = "1 3 1 1 0.05 0.01\n2500 25000 1e10 0.3\n0 0 0\n0 0 0\n0 0 0\n30 0 0\n"
BLOCKS = ("2 0 16\n1 0 1\n1 1 4\n1 9 12\n1 0 0\n1 1 0\n1 1 1\n1 0 1\n1 0 0\n0 0 0\n0 0 0\n0 0 0\n"
          "1 0 1\n1 1 1\n1 1 2\n1 0 2\n1 0 1\n0 0 0\n0 0 0\n0 0 0\n0.5 0.5 1\n0.5 1.5 2\n")
GROUPS = ("&deck geometry='g.geo', dialect='short' /\n&method strain='green', plane='strain', mass='constant' /\n"
          "&integrator scheme='newmark', beta=0.6 /\n&step size=1e-3, end_time=0.01, least=1e-9 /\n&iteration method='newton', most=20 /\n"
          "&contact method='augmented', stiffness=1e9, overlap=1e-6, initial=0.1 /\n&joints kn=1e10, ks=1e9 /\n"
          "&acceleration file='a.txt', scale=2 /\n&damping mass=0.1 /\n&output interval=1e-3, checkpoint=2 /\n")
JOINTS = ("&window x=0 10, y=0 10 /\n&tunnel centre=5 5, radius=1.5, sides=8 /\n&joint_set dip=30, spacing=1, length=4, bridge=1 /\n"
          "&joint_set dip=100, spacing=2, length=5, bridge=0.5 /\n")


def tags(*pairs):
    return "".join(f"{code}\n{value}\n" for code, value in pairs)


def entity(kind, layer, *pairs):
    return tags((0, kind), (100, "AcDbEntity"), (8, layer), *pairs)


def line(layer, *ends):
    return entity("LINE", layer, (100, "AcDbLine"), *zip((10, 20, 11, 21), ends))


def section(name, *parts):
    return tags((0, "SECTION"), (2, name)) + "".join(parts) + tags((0, "ENDSEC"))


# Each kind of entity that tools/dxf2geo takes, a block, a layer that is off.
DRAWING = (
    section("HEADER", tags((9, "$ACADVER"), (1, "AC1015")))
    + section("TABLES", tags((0, "TABLE"), (2, "LAYER"), (70, 2)),
              *(tags((0, "LAYER"), (100, "AcDbSymbolTableRecord"), (100, "AcDbLayerTableRecord"), (2, name), (70, 0), (62, colour))
                for name, colour in (("BOUNDARY", 7), ("JOINT_3", -3))), tags((0, "ENDTAB")))
    + section("BLOCKS", tags((0, "BLOCK"), (100, "AcDbEntity"), (8, "0"), (100, "AcDbBlockBegin"), (2, "CRACK"), (70, 0), (10, 0), (20, 0)),
              line("0", 0, 0, 1, 1), tags((0, "ENDBLK"), (100, "AcDbEntity"), (8, "0"), (100, "AcDbBlockEnd")))
    + section("ENTITIES", *(line("BOUNDARY", *ends) for ends in ((0, 0, 4, 0), (4, 0, 4, 3), (4, 3, 0, 3), (0, 3, 0, 0))),
              line("JOINT_3", 0, 1, 4, 1.2), line("MATERIAL_2", 0.2, 0.3, 1, 0.3),
              entity("INSERT", "SET 2", (100, "AcDbBlockReference"), (2, "CRACK"), (10, 1), (20, 1), (41, 2), (42, 1), (50, 30)),
              entity("POLYLINE", "SET 2", (100, "AcDb2dPolyline"), (66, 1), (70, 1)),
              *(entity("VERTEX", "SET 2", (100, "AcDbVertex"), (100, "AcDb2dVertex"), (10, x), (20, y), (42, bulge))
                for x, y, bulge in ((1, 1, 0.5), (2, 1, 0), (2, 2, -1))), tags((0, "SEQEND"), (100, "AcDbEntity"), (8, "SET 2")),
              entity("ARC", "SET 2", (100, "AcDbCircle"), (10, 2), (20, 1.5), (40, 1), (100, "AcDbArc"), (50, 10), (51, 300)),
              *(entity("CIRCLE", layer, (100, "AcDbCircle"), (10, 3.4), (20, 1.8), (40, 0.2)) for layer in ("SET 2", "HOLE")),
              entity("ELLIPSE", "SET 2", (100, "AcDbEllipse"), (10, 2), (20, 1.5), (11, 1), (21, 0.2), (40, 0.5), (41, 0), (42, 3)),
              entity("SPLINE", "SET 2", (100, "AcDbSpline"), (70, 8), (71, 2), (72, 6), (73, 3), *((40, knot) for knot in (0, 0, 0, 1, 1, 1)),
                     *((code, x) for place in ((0.5, 0.5), (2, 2.5), (3.5, 0.5)) for code, x in zip((10, 20), place))),
              entity("LWPOLYLINE", "SET 2", (100, "AcDbPolyline"), (90, 3), (70, 0), (10, 0.5), (20, 2.5), (10, 1.5), (20, 2.6), (42, 0.2),
                     (10, 3.5), (20, 2.4)),
              entity("POINT", "MEASURED", (100, "AcDbPoint"), (10, 1), (20, 2)), entity("POINT", "FIXED", (100, "AcDbPoint"), (10, 0.1), (20, 0.1)))
    + tags((0, "EOF")))


def classic(name):
    return (SOURCE / "tests" / "data" / "classic" / name).read_text()


# Files of each kind, and the words of the command line that read them.
KINDS = {
    "Shi's decks": ({"g.geo": classic("incline30.geo"), "a.ana": classic("incline30_p10.ana")}, ["check", "g.geo", "a.ana"]),
    "points and tables": ({"g.geo": (SOURCE / "input/paper/arc/arc.geo").read_text(),
                           "a.ana": (SOURCE / "input/paper/arc/arc.ana").read_text()}, ["check", "g.geo", "a.ana"]),
    "named groups": ({"g.geo": SQUARE, "a.ana": MATERIAL + GROUPS, "a.txt": "0 0 0\n0.5 1 2\n1 0 0\n"}, ["check", "a.ana"]),
    "blocks": ({"b.blk": BLOCKS, "a.ana": MATERIAL + "&deck dialect='short' /\n"}, ["check", "b.blk", "a.ana"]),
    "mesh": ({"g.geo": SQUARE, "m.msh": MESH, "a.ana": MATERIAL + "&deck geometry='g.geo' /\n&method model='nmm' /\n&cover mesh='m.msh' /\n"},
             ["check", "a.ana"]),
    "joints": ({"x.joints": JOINTS}, ["joints", "x.joints", "--quiet", "-o", "out.geo"]),
}


def changed(text, draw):
    """The text after one of the things that go wrong with files."""
    words = re.findall(r"[^\s,=/']+|\s+|.", text)
    lines = text.splitlines(keepends=True)
    i, k = draw.randrange(len(words)), draw.randrange(len(lines))
    solid = [j for j, word in enumerate(words) if not word.isspace()]
    if not solid:
        return text
    j = draw.choice(solid)
    kind = draw.randrange(9)
    if kind < 4:
        words[j] = draw.choice(SPECIAL)
    elif kind == 4:
        words[j] = words[draw.choice(solid)]
    elif kind == 5:
        del words[i]
    elif kind == 6:
        return "".join(lines[:k] + lines[k + 1:])
    elif kind == 7:
        return "".join(lines[:k] + [lines[draw.randrange(len(lines))]] + lines[k:])
    else:
        return text[:draw.randrange(1, len(text) + 1)]
    return "".join(words)


def tried(name, number, folder):
    """What is wrong with how the program takes an input; '' where nothing is."""
    draw = random.Random(f"{name} {number}")
    files, words = KINDS[name]
    files = dict(files)
    for _ in range(draw.choice([1, 1, 1, 2, 3])):
        file = draw.choice(sorted(files))
        files[file] = changed(files[file], draw) or "\n"
    for file, text in files.items():
        (folder / file).write_bytes(text.encode("utf-8", "surrogateescape"))
    limit = None if "debug" in SCREE else lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))  # a sanitizer takes much
    try:
        done = subprocess.run([SCREE, *words], cwd=folder, capture_output=True, timeout=SECONDS, preexec_fn=limit)
    except subprocess.TimeoutExpired:
        return f"{name}, input {number}: takes more than {SECONDS} s"
    said = done.stderr.decode(errors="replace").splitlines()
    wrong = []
    if done.returncode not in (0, 2):
        wrong.append(f"exit status {done.returncode}")
    if not all(line.startswith("scree: ") for line in said):
        wrong.append("words that are not scree's")
    if done.returncode == 2 and not (said and "expected" in said[-1]):
        wrong.append("a refusal without what was expected")
    return f"{name}, input {number}: {', '.join(wrong)}: {said[-3:]}" if wrong else ""


@pytest.mark.parametrize("name", KINDS)
def test_files_changed_at_random_are_read_or_refused(name, tmp_path):
    wrong = [found for number in range(INPUTS // len(KINDS)) if (found := tried(name, number, tmp_path))]
    assert wrong == [], f"{len(wrong)} of {INPUTS // len(KINDS)}"


def converted(drawing):
    """Status, output and errors of tools/dxf2geo, in this process, which spares its start."""
    output, errors = io.StringIO(), io.StringIO()
    with (contextlib.redirect_stdout(output), contextlib.redirect_stderr(errors),
          mock.patch.object(sys, "argv", ["dxf2geo", str(drawing)])):
        status = command.main()
    return status, output.getvalue(), errors.getvalue()


def test_drawings_changed_at_random_are_converted_or_refused(tmp_path):
    """In words of the tool, never by the end of Python; what is converted the program reads or refuses."""
    wrong = []
    for number in range(INPUTS // (len(KINDS) + 1)):
        draw = random.Random(f"drawing {number}")
        text = DRAWING
        for _ in range(draw.choice([1, 1, 1, 2, 3])):
            text = changed(text, draw) or "\n"
        (tmp_path / "m.dxf").write_bytes(text.encode("utf-8", "surrogateescape"))
        try:
            status, _, said = converted(tmp_path / "m.dxf")
        except Exception as error:  # whatever it is, nobody is to see it
            wrong.append(f"input {number}: {error!r}")
            continue
        if status not in (0, 2) or not all(line.startswith("dxf2geo: ") for line in said.splitlines()):
            wrong.append(f"input {number}: exit status {status}: {said[-300:]}")
        if status == 0:
            done = subprocess.run([SCREE, "cut", "m.geo", "-o", "m.blk"], cwd=tmp_path, capture_output=True, text=True, timeout=SECONDS)
            if done.returncode not in (0, 2) or not all(line.startswith("scree: ") for line in done.stderr.splitlines()):
                wrong.append(f"input {number}: scree cut: exit status {done.returncode}: {done.stderr[-300:]}")
    assert wrong == []


def test_the_drawing_that_is_changed_was_right(tmp_path):
    (tmp_path / "m.dxf").write_text(DRAWING)
    status, _, said = converted(tmp_path / "m.dxf")
    assert (status, said) == (0, "")
    done = subprocess.run([SCREE, "cut", "m.geo", "-o", "m.blk"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", KINDS)
def test_what_is_changed_was_right(name, tmp_path):
    files, words = KINDS[name]
    for file, text in files.items():
        (tmp_path / file).write_text(text)
    done = subprocess.run([SCREE, *words], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
