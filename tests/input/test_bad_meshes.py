"""Mathematical meshes that do not fit: each gives one line with where, expected and found, and exit status 2."""
import pytest
import scree

GEOMETRY = "0.001 4 0 0 0 0 0 0 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n"
ANALYSIS = """0 1 1 1 0.05 0.01
2500 0 1e10 0.3
0 0 0
0 0 0
0 0 0
30 0 0
&deck geometry='g.geo' /
&method model='nmm' /
"""
MESH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
1 6 1 6
2 1 0 6
1
2
3
4
5
6
0 0 0
1 0 0
2 0 0
0 1 0
1 1 0
2 1 0
$EndNodes
$Elements
1 4 1 4
2 1 2 4
1 1 2 5
2 1 5 4
3 2 3 6
4 2 6 5
$EndElements
"""


def mesh(line, text, taken=1, changed=("", "")):
    """The mesh with some lines replaced by one or more, and a text elsewhere by another."""
    lines = MESH.splitlines()
    lines[line - 1:line - 1 + taken] = [text]
    return {"m.msh": "\n".join(lines).replace(*changed) + "\n"}


def of_triangles(nodes, triangles):
    """The mesh with more nodes after its six, and with other triangles."""
    n = 6 + len(nodes)
    lines = [*MESH.splitlines()[:4], f"1 {n} 1 {n}", f"2 1 0 {n}", *(str(k + 1) for k in range(n)), *MESH.splitlines()[12:18], *nodes,
             "$EndNodes", "$Elements", f"1 {len(triangles)} 1 {len(triangles)}", f"2 1 2 {len(triangles)}",
             *(f"{k + 1} {three}" for k, three in enumerate(triangles)), "$EndElements", ""]
    return {"m.msh": "\n".join(lines)}


def cut_off(line, text=""):
    """The mesh up to a line, and what follows it."""
    return {"m.msh": "\n".join([*MESH.splitlines()[:line], text])}


def cover(text, analysis=ANALYSIS):
    """The analysis deck with another &cover, in line 9."""
    return {"a.ana": analysis + f"&cover {text} /\n"}


# name: files to write, where the error stands, what was expected and found
BAD = {
    "coarser than the model": (cover("edge=2.5"), "a.ana:9:", "up to the size of the model, 2", "2.5"),
    "a file coarser than the model": ({"m.msh": "\n".join([*MESH.splitlines()[:12], "-3 -3 0", "2 -3 0", "7 -3 0", "-3 4 0",
                                                            "2 4 0", "7 4 0", *MESH.splitlines()[18:], ""])}, "a.ana:9:",
                                      "up to the diagonal of the model, 2.236", "none below 5"),
    "too fine": (cover("edge=1e-5"), "a.ana:9:", "at most 50 million", "1e-5"),
    "an edge of 0": (cover("edge=0"), "a.ana:9:", "above 0", "0"),
    "edge and mesh": (cover("edge=1, mesh='m.msh'"), "a.ana:9:", "cover.mesh only without cover.edge", "cover.edge=1"),
    "neither edge nor mesh": (cover("angle=10"), "a.ana:9:", "cover.angle only with cover.edge", "none"),
    "origin of one number": (cover("edge=1, origin=5"), "a.ana:9:", "two numbers", "5"),
    "origin of three numbers": (cover("edge=1, origin=5 6 7"), "a.ana:9:", "two numbers", "5 6 7"),
    "an origin that is a word": (cover("edge=1, origin=here there"), "a.ana:9:", "number", "here"),
    "origin of a mesh": (cover("mesh='m.msh', origin=0 0"), "a.ana:9:", "only with cover.edge", "none"),
    "angle of a mesh": (cover("mesh='m.msh', angle=0"), "a.ana:9:", "only with cover.edge", "none"),
    "least above 1": (cover("edge=1, least=1.5"), "a.ana:9:", "at most 1", "1.5"),
    "a dda run": (cover("edge=1", ANALYSIS.replace("nmm", "dda")), "a.ana:9:", "nmm", "dda"),
    "a dda run by default": (cover("mesh='m.msh'", ANALYSIS.replace("&method model='nmm' /", "")), "a.ana:9:", "nmm", "dda"),
    "no such file": (cover("mesh='none.msh'"), "a.ana:", "a file for cover.mesh", "the mesh file none.msh does not exist"),
    "a folder": (cover("mesh='.'"), "expected", "a mesh", "directory"),
    "empty": ({"m.msh": ""}, "m.msh:1:", "$MeshFormat", "end"),
    "no Gmsh file": ({"m.msh": GEOMETRY}, "m.msh:1:", "$MeshFormat", "0.001"),
    "version 2.2": (mesh(2, "2.2 0 8"), "m.msh:2:", "4.1", "2.2"),
    "version 4.0": (mesh(2, "4 0 8"), "m.msh:2:", "4.1", "4"),
    "binary": (mesh(2, "4.1 1 8"), "m.msh:2:", "text", "1"),
    "binary with its bytes": ({"m.msh": b"$MeshFormat\n4.1 1 8\n\x01\x00\x00\x00\n$EndMeshFormat\n"}, "m.msh:", "text", "byte"),
    "quads alone": (mesh(21, "1 2 1 2\n2 1 3 2\n1 1 2 5 4\n2 2 3 6 5", 6), "m.msh:22:", "three nodes", "type 3"),
    "triangles of six nodes": (mesh(22, "2 1 9 4"), "m.msh:22:", "three nodes", "type 9"),
    "lines alone": (mesh(21, "1 1 1 1\n1 1 1 1\n1 1 2", 6), "m.msh:", "triangles", "none"),
    "no elements": ({"m.msh": MESH[:MESH.index("$Elements")]}, "m.msh:", "triangles", "none"),
    "elements before nodes": ({"m.msh": MESH[:MESH.index("$Nodes")] + MESH[MESH.index("$Elements"):]}, "m.msh:4:", "$Nodes before",
                              "none"),
    "a node off the plane": (mesh(17, "1 1 0.5"), "m.msh:17:", "z = 0", "off it"),
    "a triangle without area": (mesh(23, "1 1 2 3"), "m.msh:23:", "an area", "without"),
    "a triangle of two nodes": (mesh(23, "1 1 2 2"), "m.msh:23:", "an area", "without"),
    "a tag that no node has": (mesh(5, "1 6 1 7", changed=("1 1 2 5", "1 1 2 7")), "m.msh:23:", "a node of $Nodes", "7"),
    "a tag beyond the highest": (mesh(23, "1 1 2 9"), "m.msh:23:", "at most 6", "9"),
    "a tag twice": (mesh(8, "1"), "m.msh:", "once", "1 again"),
    "a coordinate that is a word": (mesh(14, "1 zero 0"), "m.msh:14:", "number", "zero"),
    "NaN": (mesh(14, "1 nan 0"), "m.msh:14:", "number", "nan"),
    "more nodes than announced": (mesh(5, "1 5 1 6"), "m.msh:6:", "5 announced", "6"),
    "1e8 nodes": (mesh(5, "1 99999999 1 6"), "m.msh:5:", "holds no more", "99999999"),
    "1e8 elements": (mesh(22, "2 1 2 99999999"), "m.msh:22:", "holds no more", "99999999"),
    "a tag of 1e9": (mesh(5, "1 6 1 999999999"), "m.msh:5:", "at most", "999999999"),
    "cut off in the nodes": (cut_off(14), "m.msh:5:", "the deck holds no more", "6 times 4"),
    "cut off in the elements": (cut_off(23), "m.msh:22:", "the deck holds no more", "4 times 2"),
    "cut off between elements": (cut_off(25), "m.msh:26:", "the tag of an element", "end"),
    "cut off in an element": (cut_off(25, "4 2 6"), "m.msh:26:", "a node of element", "end"),
    "cut off after the last node": (cut_off(18), "m.msh:19:", "$EndNodes", "end"),
    "cut off after the last element": (cut_off(26), "m.msh:27:", "$EndElements", "end"),
    "more elements than announced": (mesh(22, "2 1 2 3"), "m.msh:26:", "$EndElements", "4"),
    "nodes twice": ({"m.msh": MESH + MESH[MESH.index("$Nodes"):]}, "m.msh:28:", "$Nodes once", "again"),
    "a mesh beside the rock": ({"m.msh": MESH.replace("0 0 0\n", "0.1 0 0\n").replace("0 1 0\n", "0.1 1 0\n")}, "a.ana:9:",
                               "holds every block", "1 parts"),
    "a mesh far from the rock": ({"g.geo": GEOMETRY.replace("\n0 0 2 0", "\n9 9 9.5 9").replace("2 0 2 1", "9.5 9 9 9.5")
                                  .replace("2 1 0 1", "9 9.5 9 9").replace("0 1 0 0 1\n", "9 9 9 9 1\n")}, "a.ana:9:",
                                 "holds every block", "1 parts"),
    "a mesh without a part of the rock": (mesh(21, "1 3 1 3\n2 1 2 3", 2, changed=("4 2 6 5\n", "")), "a.ana:9:",
                                          "holds every block", "1 parts"),
    "a node that hangs on a line": (of_triangles(["1 0.5 0"], ["1 2 5", "1 5 4", "2 3 6", "2 6 7", "7 6 5"]), "a.ana:9:", "'m.msh'",
                                    "at (1, 0.25)"),
    "nodes twice on a line in a block": (of_triangles(["1 0 0", "1 1 0"], ["1 2 5", "1 5 4", "7 3 6", "7 6 8"]), "a.ana:9:",
                                         "both nodes in common", "at (1, 0.5)"),
    "a triangle over others": (of_triangles([], ["1 2 5", "1 5 4", "2 3 6", "2 6 5", "1 3 5"]), "a.ana:9:", "one triangle on either side",
                               "at (0.5, 0.5)"),
    "every triangle twice": (of_triangles([], 2*["1 2 5", "1 5 4", "2 3 6", "2 6 5"]), "a.ana:9:", "one triangle on either side", "at "),
}


def check(files, folder):
    for file, text in {"g.geo": GEOMETRY, "m.msh": MESH, **cover("mesh='m.msh'"), **files}.items():
        (folder / file).write_bytes(text if isinstance(text, bytes) else text.encode())
    return scree.call("run", "a.ana", "-o", "r.h5", cwd=folder, timeout=20)


def test_the_mesh_that_the_others_are_made_of_is_good(tmp_path):
    done = check({}, tmp_path)
    assert done.returncode == 0 and "4 elements, 6 covers" in done.stdout, done.stderr


@pytest.mark.parametrize("change", [
    lambda t: t.replace("\n", "\r\n"), lambda t: t.replace("1 1 2 5", "1 5 2 1"),
    lambda t: t.replace("$Nodes", "$PhysicalNames\n1\n2 1 \"rock\"\n$EndPhysicalNames\n$Entities\n0 0 1 0\n"
                        "1 0 0 0 2 1 0 0 0\n$EndEntities\n$Nodes", 1),
    lambda t: t.replace("1 4 1 4\n", "3 6 1 6\n0 1 15 1\n5 1\n1 1 1 1\n6 1 2\n")])
def test_a_good_mesh_is_taken_in_any_dress(change, tmp_path):
    done = check({"m.msh": change(MESH)}, tmp_path)
    assert done.returncode == 0 and "4 elements, 6 covers" in done.stdout, done.stderr


def test_nodes_may_be_there_twice_along_a_joint(tmp_path):
    """Meshes of two blocks need not fit each other: the joint between these has two nodes on one side, three on the other."""
    blocks = "0.001 5 4 0 0 0 0 0 0\n0 0 2 0 1\n2 0 2 1 1\n2 1 0 1 1\n0 1 0 0 1\n1 0 1 1 1\n"
    mesh_of_each = of_triangles(["1 0 0", "1 1 0", "1 0.5 0"], ["1 2 5", "1 5 4", "7 3 6", "7 6 9", "9 6 8"])
    done = check({"g.geo": blocks, **mesh_of_each}, tmp_path)
    assert done.returncode == 0 and "5 elements, 9 covers" in done.stdout, done.stderr


@pytest.mark.parametrize("name", BAD)
def test_a_mesh_that_does_not_fit_is_refused_in_one_line(name, tmp_path):
    files, where, expected, found = BAD[name]
    done = check(files, tmp_path)
    line = done.stderr
    assert done.returncode == 2, line
    assert len(line.splitlines()) == 1 and line.startswith("scree: "), line
    assert where in line and "expected" in line and "found" in line, line
    left, right = line.rsplit(", found ", 1)
    assert expected in left and found in right, line
    assert not (tmp_path / "r.h5").exists()


def test_an_edge_of_the_command_line_is_named_in_its_error(tmp_path):
    (tmp_path / "g.geo").write_text(GEOMETRY)
    (tmp_path / "a.ana").write_text(ANALYSIS)
    done = scree.call("check", "a.ana", "--set", "cover.edge=5", cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and "--set cover.edge" in done.stderr, done.stderr
