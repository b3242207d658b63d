"""Bad decks: each gives one line with file, line, expected and found, exit status 2, quickly and in little memory."""
import os
import resource
import subprocess
import time

import pytest
import scree

SCREE = os.environ["SCREE"]

GEOMETRY = """0.001
4 0
0
0
1
0
1
0
0 0 1 0 1
1 0 1 1 1
1 1 0 1 1
0 1 0 0 1
0 0 0 0
0.5 0.5
"""
ANALYSIS = """1
10
1
1
0.05
0.01
2500 0 1e10 0.3
0 0 0
0 0 0
0 0 1
30 0 0
&deck geometry='g.geo' /
"""
BLOCKS = """1 0 8
0 0 1
1 1 4
1 0 0
1 1 0
1 1 1
1 0 1
1 0 0
0 1 1
0 .5 .5
0 .5 .5
.5 .5 1
"""


def geometry(line, text):
    """The geometry deck with one line replaced."""
    lines = GEOMETRY.splitlines()
    lines[line - 1] = text
    return {"g.geo": "\n".join(lines) + "\n"}


def bolts(*rows):
    """The geometry deck with bolts, from line 13 on."""
    lines = GEOMETRY.splitlines()
    lines[3] = str(len(rows))
    return {"g.geo": "\n".join(lines[:12] + list(rows) + lines[12:]) + "\n"}


def block_bolt(row):
    """A block file with a bolt in line 12."""
    lines = BLOCKS.splitlines()
    lines[0] = "1 1 8"
    return {"g.blk": "\n".join(lines[:11] + [row] + lines[11:]) + "\n", "a.ana": ANALYSIS.replace("g.geo", "g.blk")}


def analysis(line, text):
    """The analysis deck with one line replaced."""
    lines = ANALYSIS.splitlines()
    lines[line - 1] = text
    return {"a.ana": "\n".join(lines) + "\n"}


def groups(text):
    """The analysis deck with more groups, from line 13 on."""
    return {"a.ana": ANALYSIS + text}


def record(text):
    """A record of the acceleration of the ground."""
    return {"q.txt": text} | groups("&acceleration file='q.txt' /\n")


PEER = """PEER STRONG MOTION RECORD
NORTHRIDGE #1 & AFTERSHOCKS, 01/17/94, SOMEWHERE, 090
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=   3, DT=   .0100 SEC
  -.1000000E-03   .2000000E+00
   .3000000E-03
"""


def peer(old="", new="", words="scale=9.81"):
    """A record of PEER with a text replaced."""
    return {"q.AT2": PEER.replace(old, new)} | groups(f"&acceleration file='q.AT2', {words} /\n")


def blocks(line, text):
    """A block file with one line replaced."""
    lines = BLOCKS.splitlines()
    lines[line - 1] = text
    return {"g.blk": "\n".join(lines) + "\n", "a.ana": ANALYSIS.replace("g.geo", "g.blk")}


# name: files to write, where the error stands, a word of what was expected
BAD = {
    "geometry empty": ({"g.geo": ""}, "g.geo:1:", "least distance"),
    "geometry of comments": ({"g.geo": "! nothing\n"}, "g.geo:2:", "least distance"),
    "geometry truncated": ({"g.geo": "\n".join(GEOMETRY.splitlines()[:11])}, "g.geo:11:", "x1 y1 x2 y2"),
    "geometry letters": (geometry(9, "0 zero 1 0 1"), "g.geo:9:", "number"),
    "geometry with text after it": ({"g.geo": GEOMETRY + "and more\n"}, "g.geo:15:", "end of the numbers"),
    "geometry with a number too many": ({"g.geo": GEOMETRY + "7\n"}, "g.geo:15:", "end of the numbers"),
    "geometry with a group": ({"g.geo": GEOMETRY + "&deck /\n"}, "g.geo:15:", "one of the groups"),
    "negative e0": (geometry(1, "-0.1"), "g.geo:1:", "at least 0"),
    "no lines": (geometry(2, "0 0"), "g.geo:2:", "at least 1"),
    "negative count": (geometry(2, "-4 0"), "g.geo:2:", "at least 1"),
    "a count of 1e9": (geometry(2, "1000000000 0"), "g.geo:2:", "nine digits"),
    "a count of 999999999": (geometry(2, "999999999 0"), "g.geo:2:", "at most"),
    "a count that is real": (geometry(2, "4.5 0"), "g.geo:2:", "whole"),
    "more boundary than lines": (geometry(2, "4 5"), "g.geo:2:", "at most 4"),
    "bolts without room": (geometry(4, "9"), "g.geo:4:", "numbers for bolts"),
    "bolts that are not there": (geometry(4, "1"), "g.geo:13:", "e0, number 5 of the row x1 y1 x2 y2 e0 t0 f0 of bolt 1"),
    "a bolt without stiffness": (bolts("0.1 0.1 0.9 0.9 0 0 0"), "g.geo:13:", "stiffness above 0"),
    "a bolt that is stretched beyond its strength": (bolts("0.1 0.1 0.9 0.9 5 1 2"), "g.geo:13:", "pretension up to the strength, 1"),
    "a bolt that pushes": (bolts("0.1 0.1 0.9 0.9 5 1 -2"), "g.geo:13:", "pretension from 0"),
    "a bolt without length": (bolts("0.1 0.1 0.1 0.1 5 1 0"), "g.geo:13:", "two ends"),
    "a bolt in the ground": (bolts("2 2 3 3 5 1 0") | groups("&bolts outside='ground' /\n"), "g.geo:13:", "an end in a block"),
    "an end of a bolt in the air": (bolts("0.1 0.1 0.1 1.1 5 1 0"), "g.geo:13:", "within 0.01 of one, 0.01 of its length, found the end (0.1, 1.1)"),
    "the head of a bolt far from the rock": (groups("&bolts ends=0.1 0.1 3.1 0.1, stiffness=5 /\n"), "a.ana:13:", "2.1 from block 1"),
    "bolts of a group without a number": (groups("&bolts ends=0.1 0.1 0.9, stiffness=5 /\n"), "a.ana:13:", "four numbers"),
    "bolts of a group without stiffness": (groups("&bolts ends=0.1 0.1 0.9 0.9 /\n"), "a.ana:13:", "bolts.stiffness"),
    "bolts of a group with stiffness for two": (groups("&bolts ends=0.1 0.1 0.9 0.9\n stiffness=5 6 /\n"), "a.ana:14:", "found 2"),
    "strength of no bolts": (groups("&bolts strength=5 /\n"), "a.ana:13:", "bolts.ends"),
    "a bolt of a block file in a block that is not there": (block_bolt("0.1 0.1 0.9 0.9 1 2 5 0 0"), "g.blk:12:", "at most 1"),
    "a bolt of a block file outside its block": (block_bolt("0.1 0.1 9 9 1 1 5 0 0"), "g.blk:12:", "in its block 1"),
    "joint material 0": (geometry(10, "1 0 1 1 0"), "g.geo:10:", "at least 1"),
    "joint material that is not there": (geometry(10, "1 0 1 1 2"), "g.geo:10:", "joint material up to 1"),
    "NaN in a line": (geometry(9, "nan 0 1 0 1"), "g.geo:9:", "number"),
    "infinity in a line": (geometry(9, "0 inf 1 0 1"), "g.geo:9:", "number"),
    "1e999 in a line": (geometry(9, "0 1e999 1 0 1"), "g.geo:9:", "magnitude up to 1e20"),
    "1e21 in a line": (geometry(9, "0 1e21 1 0 1"), "g.geo:9:", "magnitude up to 1e20"),
    "a decimal comma in a geometry": (geometry(1, "0,001"), "g.geo:2:", "the decimal sign is a point"),
    "a geometry of XML": ({"g.geo": '<?xml version="1.0"?>\n<a>1</a>\n'}, "g.geo:1:", "plain text, found XML"),
    "a geometry in UTF-16": ({"g.geo": GEOMETRY.encode("utf-16")}, "g.geo:1:", "UTF-8 or ASCII, found UTF-16"),
    "blocks lost in the model": ({"g.geo": GEOMETRY.replace("4 0", "8 0").replace("0 0 0 0\n", "".join(
        f"{x0} {y0} {x1} {y1} 1\n" for x0, y0, x1, y1 in [(9e9, 0, 1e10, 0), (1e10, 0, 1e10, 1e9), (1e10, 1e9, 9e9, 1e9),
                                                           (9e9, 1e9, 9e9, 0)]) + "0 0 0 0\n").replace("0.001", "0")},
        "g.geo:", "blocks larger than 1e-9 of the model"),
    "lines that enclose nothing": (geometry(9, "0 0 0.5 0 1"), "g.geo:9:", "enclose"),
    "lines next to nothing": ({"g.geo": "0.001 5 4 0 0 0 0 0 0\n0 0 4 0 1\n4 0 4 3 1\n4 3 0 3 1\n0 3 0 0 1\n1 1e20 2 1e20 1\n"}, "g.geo:2:", "enclose"),
    "lines without length": ({"g.geo": "1e-3 2 0 0 0 0 0 0 0\n1 1 1 1 1\n1 1 1 1 1\n"}, "g.geo:2:", "without length"),
    "a material line outside": ({"g.geo": GEOMETRY.replace("4 0\n0", "4 0\n1").replace("0 0 0 0\n", "5 5 6 6 1\n0 0 0 0\n")},
                                "g.geo:13:", "material line"),
    "a hole point outside": ({"g.geo": GEOMETRY.replace("1\n0\n0 0 1 0 1", "1\n1\n0 0 1 0 1") + "5 5\n"}, "g.geo:15:", "hole"),
    "a fixed point outside": (geometry(13, "5 5 5 5"), "g.geo:13:", "fixed"),
    "a measured point outside": (geometry(14, "5 5"), "g.geo:14:", "measured"),
    "a hole that empties the deck": ({"g.geo": GEOMETRY.replace("1\n0\n0 0 1 0 1", "1\n1\n0 0 1 0 1") + "0.5 0.5\n"},
                                     "g.geo:15:", "left"),
    "binary garbage": ({"g.geo": b"\x7fELF\x00\x01\x02" * 50}, "g.geo:1:", "byte"),
    "results in place of a geometry": ({"g.geo": b"\x89HDF\r\n\x1a\n" + bytes(100)}, "g.geo:", "expected a deck, found a file of HDF5"),
    "a NUL in the middle": ({"g.geo": GEOMETRY.encode()[:60] + b"\0" + GEOMETRY.encode()[60:]}, "g.geo:", "byte 0"),
    "geometry missing": (analysis(12, "&deck geometry='none.geo' /"), "a.ana:12:", "the geometry file none.geo does not exist"),
    "a mesh missing": (groups("&method model='nmm' /\n&cover mesh='none.msh' /\n"), "a.ana:14:", "the mesh file none.msh does not exist"),
    "a mesh a directory": (groups("&method model='nmm' /\n&cover mesh='.' /\n"), "scree: .:", "expected a mesh, found a directory"),
    "a wave missing": (groups("&absorbing base=0 0 1 0, file='none.txt' /\n"), "a.ana:13:", "the record file none.txt does not exist"),
    "geometry a directory": (analysis(12, "&deck geometry='.' /"), "directory", "expected a deck"),
    "analysis empty": ({"a.ana": "&deck geometry='g.geo' /"}, "a.ana:1:", "k01"),
    "analysis truncated": ({"a.ana": "\n".join(ANALYSIS.splitlines()[:8]) + "\n&deck geometry='g.geo' /"}, "a.ana:", "expected"),
    "analysis letters": (analysis(6, "0.0l"), "a.ana:6:", "number"),
    "k01 of 2": (analysis(1, "2"), "a.ana:1:", "at most 1"),
    "negative steps": (analysis(2, "-5"), "a.ana:2:", "at least 0"),
    "no steps": (analysis(2, "0"), "a.ana", "0 steps"),
    "no block material": (analysis(3, "0"), "a.ana:3:", "at least 1"),
    "1e9 block materials": (analysis(3, "999999999"), "a.ana:3:", "at most"),
    "negative joint materials": (analysis(4, "-1"), "a.ana:4:", "at least 0"),
    "step size 0": (analysis(6, "0"), "a.ana:6:", "above 0"),
    "E 0": (analysis(7, "2500 0 0 0.3"), "a.ana:7:", "above 0"),
    "E negative": (analysis(7, "2500 0 -1e10 0.3"), "a.ana:7:", "above 0"),
    "nu 0.5": (analysis(7, "2500 0 1e10 0.5"), "a.ana:7:", "below 0.5"),
    "nu -1": (analysis(7, "2500 0 1e10 -1"), "a.ana:7:", "above -1"),
    "density negative": (analysis(7, "-1 0 1e10 0.3"), "a.ana:7:", "at least 0"),
    "NaN density": (analysis(7, "NaN 0 1e10 0.3"), "a.ana:7:", "number"),
    "E 1e308": (analysis(7, "2500 0 1e308 0.3"), "a.ana:7:", "magnitude up to 1e20"),
    "E 1e-300": (analysis(7, "2500 0 1e-300 0.3"), "a.ana:7:", "at least 1e-20"),
    "density 1e-30": (analysis(7, "1e-30 0 1e10 0.3"), "a.ana:7:", "at least 1e-20 where it is not 0"),
    "stress 1e150": (analysis(8, "1e150 0 0"), "a.ana:8:", "magnitude up to 1e20"),
    "step size 1e-300": (analysis(6, "1e-300"), "a.ana:6:", "at least 1e-20"),
    "a decimal comma in an analysis": (analysis(5, "0,05"), "a.ana:", "the decimal sign is a point"),
    "a geometry of ntdda": ({"g.geo": "<?xml version='1.0'?>\n<B:DDA xmlns:B='b'><B:Geometry/></B:DDA>\n"}, "g.geo:1:",
                            "plain text, found DDAML, the XML of ntdda: tools/ddaml2deck writes such files as decks"),
    "an analysis of XML": ({"a.ana": "\n<html>\n"}, "a.ana:2:", "plain text, found XML or HTML: '<html>'"),
    "a friction of 90 degrees": (analysis(11, "90 0 0"), "a.ana:11:", "below 90"),
    "a number too many": (analysis(11, "30 0 0 5"), "a.ana:", "expected"),
    "a number too many, as in Shi's order without its tables": ({"a.ana": ANALYSIS.replace("2500 0", "2500 24525").replace("30 0 0", "30 0 0 7")},
                                                                "a.ana:11:", "3 numbers in this line (phi c T of joint material 1), found 4"),
    "a number too few": (analysis(11, "30 0"), "a.ana:11:", "T, number 3 of the row phi c T of joint material 1"),
    "dialect that does not fit": (analysis(12, "&deck geometry='g.geo', dialect='shi' /"), "a.ana:", "expected"),
    "unknown group": (groups("&nonsense /\n"), "a.ana:13:", "one of the groups &deck"),
    "unknown name": (groups("&method\n  modle='dda' /\n"), "a.ana:14:", "preset, model, strain"),
    "unknown choice": (groups("&method model='fem' /\n"), "a.ana:13:", "dda, nmm"),
    "a word for a number": (groups("&step size=small /\n"), "a.ana:13:", "number"),
    "two numbers for one": (groups("&step size=1 2 /\n"), "a.ana:13:", "one number"),
    "a decimal comma in a group": (groups("&step size=0,01 /\n"), "a.ana:13:", "the decimal sign is a point"),
    "a step size of 1e308": (groups("&step size=1e308 /\n"), "a.ana:13:", "magnitude up to 1e20"),
    "frames at every 1e-300": (groups("&output interval=1e-300 /\n"), "a.ana:13:", "at least 1e-20"),
    "frames closer than the least step": (groups("&output interval=1e-9 /\n"), "a.ana:13:", "at least step.least, 1e-8"),
    "beta of 2": (groups("&integrator beta=2 /\n"), "a.ana:13:", "at most 1"),
    "a group twice": (groups("&method model='dda' /\n&method strain='small' /\n"), "a.ana:14:", "second &method"),
    "a name twice": (groups("&method model='dda', model='nmm' /\n"), "a.ana:13:", "second model"),
    "a group without end": (groups("&method model='dda'\n"), "a.ana:14:", "'/'"),
    "a quote without end": (groups("&method model='dda /\n"), "a.ana:13:", "closing"),
    "a name without value": (groups("&method model /\n"), "a.ana:13:", "'='"),
    "text between groups": (groups("5 6 7\n"), "a.ana:13:", "'&'"),
    "energy-momentum with small strain": (groups("&method strain='small' /\n&integrator scheme='energy_momentum' /\n"), "a.ana:14:",
                                         "green"),
    "gamma of energy-momentum": (groups("&integrator scheme='energy_momentum', gamma=0.5 /\n"), "a.ana:13:", "only with integrator.scheme='newmark'"),
    "exact rotation in Green strain": (groups("&method strain='green', rotation='exact' /\n"), "a.ana:13:", "only with method.strain='small'"),
    "Shi's contact with multipliers": (groups("&method preset='shi' /\n&contact method='augmented', rules='shi' /\n"), "a.ana:14:", "penalty"),
    "energy of yesterday": (groups("&contact energy='conserving' /\n"), "a.ana:13:", "contact.energy='conserving' is now contact.rules='conserving'"),
    "friction of yesterday": (groups("&contact friction='lagging' /\n"), "a.ana:13:", "contact.friction='lagging' is now contact.rules='shi'"),
    "opening of yesterday": (groups("&contact opening=0 /\n"), "a.ana:13:", "contact.opening is now part of contact.rules='shi'"),
    "a step of no travel": (groups("&step travel=0 /\n"), "a.ana:13:", "0"),
    "rates of an NMM": (groups("&method model='nmm' /\n&integrator transport='rates' /\n"), "a.ana:14:", "dda"),
    "every and interval": (groups("&output every=1, interval=0.1 /\n"), "a.ana:13:", "without output.every"),
    "a force without a load point": (groups("&loads force=1, 2 /\n"), "a.ana:13:", "0 numbers"),
    "a record with a missing value": (record("0 0 0\n0.1 1\n0.2 0 0\n"), "q.txt:2:", "three numbers"),
    "a record with four columns": (record("! t ax ay az\n0 0 0 0\n0.1 1 0 0\n"), "q.txt:2:", "three numbers"),
    "a record with a word": (record("0 0 0\n0.1 x 0\n"), "q.txt:2:", "number"),
    "a record with a head": (record("t ax ay\n0 0 0\n1 0 0\n"), "q.txt:1:", "number"),
    "a record with decimal commas": (record("0,0 1,5 0\n1,0 0 0\n"), "q.txt:1:", "the decimal sign is a point"),
    "a record that goes back": (record("0 0 0\n# noise\n0.1 1 0\n0.1 0 0\n"), "q.txt:4:", "time above 0.1"),
    "a record of one line": (record("0 0 0"), "q.txt:1:", "two lines"),
    "an empty record": (record(""), "q.txt:1:", "two lines"),
    "a record with a group": (record("0 0 0\n1 0 0\n&end /\n"), "q.txt:3:", "alone"),
    "a record of bytes": (record("0 0 0\n\0"), "q.txt:2:", "byte 0"),
    "a record that is not there": (groups("&acceleration file='none.txt' /\n"), "a.ana:13:", "the record file none.txt does not exist"),
    "a PEER record of velocities": (peer("ACCELERATION", "VELOCITY"), "q.AT2:3:", "acceleration ... in units of g"),
    "a PEER record in parts of g": (peer("OF G", "OF G/10"), "q.AT2:3:", "acceleration ... in units of g"),
    "a PEER record in other units": (peer("OF G", "OF CM/S/S"), "q.AT2:3:", "acceleration ... in units of g"),
    "a PEER record that ends early": (peer("   .3000000E-03\n"), "q.AT2:4:", "as NPTS says (3), found 2"),
    "a PEER record that goes on": (peer("  -.1", "0.5 -.1"), "q.AT2:4:", "as NPTS says (3), found 4"),
    "a PEER record with a word in it": (peer(".3000000E-03", "end"), "q.AT2:6:", "number"),
    "a PEER record without a time step": (peer("DT=   .0100 SEC"), "q.AT2:5:", "DT"),
    "a PEER record with a time step of 0": (peer(".0100 SEC", "0 SEC"), "q.AT2:4:", "above 0"),
    "a PEER record with its values in the head": (peer("\nNPTS=   3", " NPTS=   3"), "q.AT2:4:", "NPTS"),
    "a PEER record of three lines": (peer(PEER[PEER.index("NPTS"):]), "q.AT2:4:", "head of four lines"),
    "a PEER record without a scale": ({"q.AT2": PEER} | groups("&acceleration file='q.AT2' /\n"), "a.ana:13:", "acceleration.scale"),
    "a PEER record beside another step": ({"v.at2": PEER.replace(".0100", ".0200")} | peer(words="vertical='v.at2', scale=9.81"),
                                          "v.at2:4:", "time step of q.AT2 (0.01), found 0.02"),
    "a PEER record beside a table": ({"q.txt": "0 0 0\n1 0 0\n"} | groups("&acceleration file='q.txt', vertical='q.AT2' /\n"), "a.ana:13:",
                                     "beside a PEER record"),
    "a vertical component alone": (groups("&acceleration vertical='q.AT2' /\n"), "a.ana:13:", "only with acceleration.file"),
    "a table of two columns": (groups("&acceleration table=0 0 1 1 /\n"), "a.ana:13:", "t ax ay"),
    "a table of one time": (groups("&acceleration table=0 0 1 /\n"), "a.ana:13:", "two times"),
    "a table that goes back": (groups("&acceleration table=0 0 1  0 0 2 /\n"), "a.ana:13:", "increase"),
    "a table and a record": (groups("&acceleration table=0 0 1  1 0 2\n file='q.txt' /\n"), "a.ana:14:", "without acceleration.table"),
    "a scale of nothing": (groups("&acceleration scale=9.81 /\n"), "a.ana:13:", "only with acceleration.table or acceleration.file"),
    "a damping that drives": (groups("&damping mass=-1 /\n"), "a.ana:13:", "at least 0"),
    "blocks: row beyond the end": (blocks(3, "1 1 9"), "g.blk:3:", "at most 8"),
    "blocks: two vertices": (blocks(3, "1 1 2"), "g.blk:3:", "three or more"),
    "blocks: clockwise": ({"g.blk": BLOCKS.replace("1 1 0\n1 1 1\n1 0 1\n", "1 0 1\n1 1 1\n1 1 0\n"),
                           "a.ana": ANALYSIS.replace("g.geo", "g.blk")}, "g.blk:4:", "counter-clockwise"),
    "blocks: a point in no block": (blocks(12, "5 .5 0"), "g.blk:12:", "inside a block"),
    "blocks: a fraction of a block": (blocks(12, ".5 .5 .5"), "g.blk:12:", "number of a block"),
    "blocks: truncated": ({"g.blk": "\n".join(BLOCKS.splitlines()[:6]), "a.ana": ANALYSIS.replace("g.geo", "g.blk")},
                          "g.blk:", "at most"),
    "blocks: 1e9 rows": (blocks(1, "1 0 999999999"), "g.blk:1:", "at most"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_deck_is_refused_in_one_line(name, tmp_path):
    files, where, expected = BAD[name]
    for file, text in {"g.geo": GEOMETRY, "a.ana": ANALYSIS, **files}.items():
        (tmp_path / file).write_bytes(text if isinstance(text, bytes) else text.encode())
    before = time.perf_counter()
    done = scree.call("run", "a.ana", "-o", "r.h5", cwd=tmp_path, timeout=20)
    seconds = time.perf_counter() - before
    line = done.stderr
    assert done.returncode == 2, line
    assert len(line.splitlines()) == 1 and line.startswith("scree: "), line
    assert where in line and expected in line and "expected" in line and "found" in line, line
    assert not (tmp_path / "r.h5").exists()
    assert seconds < 5  # a hang, not a speed; each takes milliseconds
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 500_000  # KiB; 1e9 of anything would be more


@pytest.mark.parametrize("option, expected", [
    ("step.size=0", "above 0"), ("step.size", "GROUP.NAME=VALUE"), ("step.siz=1", "size, count, end_time, travel, control, accuracy, overlap, least"),
    ("stp.size=1", "one of the groups"), ("method.model=", "GROUP.NAME=VALUE"), ("method.model=fem", "dda, nmm")])
def test_bad_option_is_refused(option, expected, tmp_path):
    (tmp_path / "g.geo").write_text(GEOMETRY)
    (tmp_path / "a.ana").write_text(ANALYSIS)
    done = scree.call("check", "a.ana", "--set", option, cwd=tmp_path)
    assert done.returncode == 2 and expected in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr


@pytest.mark.parametrize("change", [
    lambda t: t, lambda t: t.replace("\n", "\r\n"), lambda t: t.rstrip("\n"), lambda t: t.replace(" ", "\t"),
    lambda t: t.replace("0 0 1 0 1", "0, 0, 1, 0, 1 ! a comment"), lambda t: "# a comment\n\n" + t, lambda t: "\ufeff" + t,
    lambda t: t.replace("0 0 1 0 1", "0,0,1,0,1"), lambda t: t.replace("0 0 1 0 1", "0 -1e-400 1.0d0 1e-300 1")])
def test_good_decks_are_taken_in_any_dress(change, tmp_path):
    (tmp_path / "g.geo").write_bytes(change(GEOMETRY).encode())
    (tmp_path / "a.ana").write_bytes(("\ufeff" + ANALYSIS).replace("\n", "\r\n").encode())
    done = scree.call("check", "a.ana", cwd=tmp_path)
    assert done.returncode == 0 and "1 blocks" in done.stdout, done.stderr


def test_decks_may_come_through_pipes(tmp_path):
    (tmp_path / "g.geo").write_text(GEOMETRY + "! a long remark\n" * 10000)  # more than a pipe holds at once
    (tmp_path / "a.ana").write_text(ANALYSIS)
    words = ["bash", "-c", f"'{SCREE}' check <(cat g.geo) <(cat a.ana)"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, timeout=20)
    assert done.returncode == 0 and "1 blocks" in done.stdout, done.stderr


def test_a_block_file_is_read_in_both_point_layouts(tmp_path):
    (tmp_path / "a.ana").write_text(ANALYSIS.replace("g.geo", "g.blk"))
    typed = BLOCKS.replace("0 .5 .5\n0 .5 .5\n.5 .5 1\n", "0 .5 .5\n0 .5 .5\n1 .5 .5 1\n")
    for text in (BLOCKS, typed):
        (tmp_path / "g.blk").write_text(text)
        done = scree.call("explain", "a.ana", cwd=tmp_path)
        assert done.returncode == 0 and "measured point 1 x y: 0.5 0.5" in done.stdout, done.stderr
