"""Files of DDAML as decks, through the tool and the program."""
import os
import pathlib
import re
import subprocess

import numpy as np
import pytest
import scree

TOOL = pathlib.Path(os.environ["SCREE_SOURCE"]) / "tools" / "ddaml2deck"
HEAD = """<?xml version="1.0" standalone="no"?>
<!DOCTYPE DDA SYSTEM "geometry.dtd">
<Berkeley:DDA xmlns:Berkeley="http://example.org/dda">
"""
TAIL = "</Berkeley:DDA>\n"
JOINTS = """<Joint type="1"> 0 0 6 0 </Joint> <Joint type="1"> 6 0 6 1 </Joint> <!-- a remark -->
    <Joint type="2"> 6 1 0 1 </Joint> <Joint type="1"> 0 1 0 0 </Joint>
    <Joint type="1"> 1 1 1 3 </Joint> <Joint type="1"> 1 3 2 3 </Joint> <Joint type="1"> 2 3 2 1 </Joint>"""
POINTS = "<Fixedpointlist><Point> 0.5 0.2 </Point><Point> 5.5 0.2 </Point></Fixedpointlist>"
GEOMETRY = """<Berkeley:Geometry>
  <Berkeley:Edgenodedist distance="0.005"/>
  <Jointlist> {joints} </Jointlist>
  <Matlinelist><Line type="2"> 1.5 2 1.5 2.5 </Line></Matlinelist>
  {points}
  <Loadpointlist><Point> 1.5 2 </Point></Loadpointlist>
  <Measuredpointlist><Point> 1.5 2 </Point></Measuredpointlist>
  {more}
</Berkeley:Geometry>
"""
BLOCK = """<Blockmaterial type="{k}"><Unitmass> {k} </Unitmass><Unitweight> 0 </Unitweight><Youngsmod> 1e6 </Youngsmod>
  <Poissonratio> 0.2 </Poissonratio><Damping>0.0</Damping><Istress> 0 0 0 </Istress><Ivelocity> 0 0 0 </Ivelocity></Blockmaterial>
"""
LOAD = "<Loadpointlist><Loadpoint numpoints = '2'> 0 {fx} 0; 5 {late} 0; </Loadpoint></Loadpointlist>"
ANALYSIS = """<Analysis type="{kind}">
  <Numtimesteps timesteps="20"/> <Maxtimestep maxtimestep="0.01"/> <Maxdisplacement maxdisplacement="0.025"/>
  <Autopenalty flag="no" pfactor="50.0"/> <Saveinterval step="5"/>
  {blocks}
  <Jointproperties type="1"><Friction> 30 </Friction><Cohesion> 0 </Cohesion><Tensile> 0 </Tensile></Jointproperties>
  <Jointproperties type="2"><Friction> 0 </Friction><Cohesion> 0 </Cohesion><Tensile> 0 </Tensile></Jointproperties>
  {more}
</Analysis>
"""


def write(folder, geometry="", analysis="", joints=JOINTS, points=POINTS, kind="dynamic", load=(3.0, 3.0)):
    (folder / "a.geo").write_text(HEAD + GEOMETRY.format(joints=joints, points=points, more=geometry) + TAIL)
    more = LOAD.format(fx=load[0], late=load[1]) + analysis
    (folder / "a.ana").write_text(HEAD + ANALYSIS.format(kind=kind, more=more, blocks=BLOCK.format(k=1) + BLOCK.format(k=2)) + TAIL)


def tool(folder, *words):
    return subprocess.run([TOOL, *words], cwd=folder, capture_output=True, text=True)


def numbers(path):
    text = re.sub("[!&].*", "", path.read_text())
    return [float(word) for word in text.split()]


def test_the_decks_have_the_numbers_of_the_files(tmp_path):
    write(tmp_path)
    done = tool(tmp_path, "a.geo", "a.ana")
    assert done.returncode == 0 and done.stderr == "" and done.stdout.split() == ["a_deck.geo", "a_deck.ana"]
    assert numbers(tmp_path / "a_deck.geo") == [
        0.005, 7, 0, 1, 0, 2, 1, 1, 0,
        0, 0, 6, 0, 1, 6, 0, 6, 1, 1, 6, 1, 0, 1, 2, 0, 1, 0, 0, 1, 1, 1, 1, 3, 1, 1, 3, 2, 3, 1, 2, 3, 2, 1, 1,
        1.5, 2, 1.5, 2.5, 2, 0.5, 0.2, 0.5, 0.2, 5.5, 0.2, 5.5, 0.2, 1.5, 2, 1.5, 2]
    rows = [[k, 0, 1e6, 0.2] + [0] * 9 for k in (1, 2)]
    assert numbers(tmp_path / "a_deck.ana") == [1, 20, 2, 2, 0.025, 0.01, *rows[0], *rows[1], 30, 0, 0, 0, 0, 0]
    groups = re.findall("&.*", (tmp_path / "a_deck.ana").read_text())
    assert groups == ["&deck geometry='a_deck.geo', dialect='short' /",
                      "&contact stiffness=50000000.0 /", "&loads force=3.0 0.0 /", "&output every=5 /"]


@pytest.mark.parametrize("load, velocity", [((3.0, 3.0), 0.15), ((0.0, 75.0), 0.075)])
def test_a_block_that_slides_without_friction_gets_the_velocity_of_its_load(load, velocity, tmp_path):
    """A block of area 2 and density 2 under a force of 3, or of 15 t, for 0.2 s: v = 3 * 0.2/4, or 15 * 0.2^2/2/4."""
    write(tmp_path, load=load)
    assert tool(tmp_path, "a.geo", "a.ana", "-o", "b").returncode == 0
    results = scree.run(tmp_path / "b.ana", output=tmp_path / "b.h5")
    assert results.bodies.area[0] == pytest.approx([6, 2], rel=1e-12)
    # the force is at the centroid, so nothing turns; the spring of the joint below and small strain leave less than 1e-4
    np.testing.assert_allclose(results.measured_points.velocity[-1], [[velocity, 0]], atol=1e-4)


def test_one_file_may_hold_both_and_needs_no_namespace(tmp_path):
    write(tmp_path)
    texts = [re.search("<(Berkeley:)?DDA[^>]*>(.*)</", (tmp_path / name).read_text(), re.S)[2] for name in ("a.geo", "a.ana")]
    (tmp_path / "all.xml").write_text("<DDA>" + "".join(texts) + "</DDA>")  # with a prefix that nothing binds
    assert tool(tmp_path, "all.xml", "-o", "c").returncode == 0
    assert tool(tmp_path, "a.geo", "a.ana", "-o", "d").returncode == 0
    for ending in (".geo", ".ana"):
        assert numbers(tmp_path / f"c{ending}") == numbers(tmp_path / f"d{ending}")


def test_flags_become_groups(tmp_path):
    write(tmp_path, analysis="<Analysistype type='static'/><Rotation type='exact'/><Planestrain flag='yes'/><Autotimestep flag='yes'/>")
    assert tool(tmp_path, "a.geo", "a.ana").returncode == 0
    text = (tmp_path / "a_deck.ana").read_text()
    assert "&method strain='small', rotation='exact', plane='strain' /" in text and "&step control='shi' /" in text
    assert numbers(tmp_path / "a_deck.ana")[0] == 0  # static: Analysistype wins over the attribute of Analysis
    assert scree.call("check", tmp_path / "a_deck.ana").returncode == 0


def test_bolts_have_the_properties_of_the_analysis(tmp_path):
    write(tmp_path, geometry="<Boltlist><Bolt type='1'> 1.5 2 1.5 0.5 </Bolt></Boltlist>",
          analysis="<Boltproperties type='1'> 2000 300 4 </Boltproperties>")
    assert tool(tmp_path, "a.geo", "a.ana").returncode == 0
    assert " ".join("1.5 2.0 1.5 0.5 2000.0 300.0 4.0".split()) in (tmp_path / "a_deck.geo").read_text()
    done = tool(tmp_path, "a.geo")
    assert done.returncode == 2 and "a.geo: expected one Boltproperties" in done.stderr


def test_what_decks_leave_out_is_named(tmp_path):
    write(tmp_path, geometry="<Seismicpointlist><Point> 1 1 </Point></Seismicpointlist>",
          analysis="<Timehistory filename='x' format='shake'/><Gravity flag='yes'/><AConstants/><Mintimestep mintimestep='1'/>")
    done = tool(tmp_path, "a.geo", "a.ana")
    said = [line.split("left out: ")[1] for line in done.stderr.splitlines()]
    assert done.returncode == 0 and [line.split(",")[0] for line in said] == ["Seismicpointlist", "Gravity", "Timehistory"]


@pytest.mark.parametrize("change, expected", [
    (dict(joints="<Joint type='1'> 0 0 1 </Joint>"), "a.geo: expected 4 numbers (a Joint of Jointlist), found '0 0 1'"),
    (dict(joints="<Joint type='x'> 0 0 1 1 </Joint>"), "expected 1 number (type of a Joint), found 'x'"),
    (dict(joints=""), "expected a Joint in the Jointlist, found none"),
    (dict(joints="<Joint"), "a.geo:6: expected DDAML, the XML of ntdda"),
    (dict(load=(0, 1), points="<Fixedpointlist><Line> 0 0.5 6 0.5 </Line></Fixedpointlist>"), "found a fixed Line"),
    (dict(analysis="<Rotation type='none'/>"), "expected linear, exact, secondorder (type of Rotation), found 'none'"),
    (dict(load=("nan", 1)), "expected 3 numbers (t fx fy of a Loadpoint), found '0 nan 0'")])
def test_files_that_are_wrong_are_one_line_and_write_nothing(change, expected, tmp_path):
    write(tmp_path, **change)
    done = tool(tmp_path, "a.geo", "a.ana")
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr
    assert not list(tmp_path.glob("a_deck.*"))


def test_decks_are_not_written_over_the_files(tmp_path):
    write(tmp_path)
    before = (tmp_path / "a.geo").read_text()
    done = tool(tmp_path, "a.geo", "a.ana", "-o", "a")
    assert done.returncode == 2 and "expected another name" in done.stderr and (tmp_path / "a.geo").read_text() == before
    (tmp_path / "deck.geo").write_text("0.01 1 0\n")
    assert "deck.geo:1: expected DDAML" in tool(tmp_path, "deck.geo").stderr
