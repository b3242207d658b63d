"""`--set` gives a number of the decks: as if it stood there, with the checks of the place where it stands."""
import numpy as np
import pytest
import scree

GEOMETRY = """0.001
5 4
1
0
2
2
1
0
0 0 2 0 1
2 0 2 1 1
2 1 0 1 1
0 1 0 0 1
1 0 1 1 2
1.5 0.2 1.6 0.2 2
0.2 0.2 0.2 0.2
0.8 0.2 0.8 0.2
1.5 0.5
1.6 0.6
1.7 0.7
"""
ANALYSIS = """1
10
2
2
0.05
0.01
0
2 0 2 1
0 0 0
1 0.1 0.2
0 1 2
3 4 5
0.5 7 8
2500 -10 1e10 0.3
1 2 3
4 5 6
7 8 9
2600 -11 2e10 0.2
0 0 0
0 0 0
0 0 0
30 1 2
20 3 4
&deck geometry='g.geo', dialect='shi' /
"""
IN_GEOMETRY = {  # name: line and place in it, from 1
    "deck.e0": (1, 1), "line(5).x1": (13, 1), "line(1).y2": (9, 4), "line(2).jm": (10, 5), "material_line(1).x1": (14, 1),
    "material_line(1).bm": (14, 5), "fixed_line(2).y1": (16, 2), "load_point(2).x": (18, 1), "load_point(1).y": (17, 2),
    "measured_point(1).x": (19, 1)}
IN_ANALYSIS = {
    "deck.k01": (1, 1), "deck.n5": (2, 1), "deck.g2": (5, 1), "deck.g1": (6, 1), "deck.g0": (7, 1),
    "fixed_point(1).time(2)": (10, 1), "fixed_point(1).move_x(1)": (9, 2), "fixed_point(1).move_y(2)": (10, 3),
    "load_point(1).time(2)": (12, 1), "load_point(1).force_x(2)": (12, 2), "load_point(1).force_y(1)": (11, 3),
    "load_point(2).force_y(1)": (13, 3), "material(1).ma": (14, 1), "material(2).density": (18, 1), "material(1).we": (14, 2),
    "material(2).unit_weight": (18, 2), "material(1).E": (14, 3), "material(2).young": (18, 3), "material(1).nu": (14, 4),
    "material(2).poisson": (18, 4), "material(1).s11": (15, 1), "material(1).s22": (15, 2), "material(2).s12": (19, 3),
    "material(1).t11": (16, 1), "material(1).t22": (16, 2), "material(2).t12": (20, 3), "material(1).vx": (17, 1),
    "material(1).vy": (17, 2), "material(2).vr": (21, 3), "joint(1).phi": (22, 1), "joint(2).friction_angle": (23, 1),
    "material(2).phi": (23, 1), "joint(1).c": (22, 2), "joint(2).cohesion": (23, 2), "joint(1).T": (22, 3),
    "joint(2).tensile_strength": (23, 3), "joint(1).PHI": (22, 1)}
VALUES = {"deck.e0": "0.002", "line(2).jm": "2", "material_line(1).bm": "1", "deck.k01": "0.5", "deck.n5": "7",
          "fixed_point(1).time(2)": "0.75", "load_point(1).time(2)": "3.5", "load_point(1).time(1)": "0.5",
          "line(5).x1": "0.95", "line(1).y2": "0.01", "material_line(1).x1": "1.4", "fixed_line(2).y1": "0.3"}


def write(folder, geometry=GEOMETRY, analysis=ANALYSIS):
    folder.mkdir(exist_ok=True)
    (folder / "g.geo").write_text(geometry)
    (folder / "a.ana").write_text(analysis)


def with_number(text, place, value):
    """A deck with one of its numbers replaced."""
    lines = [line.split() for line in text.splitlines()]
    lines[place[0] - 1][place[1] - 1] = value
    return "\n".join(" ".join(line) for line in lines) + "\n"


def explained(folder, *words):
    """What explain says, but for the line on --set and the places of the settings."""
    done = scree.call("explain", "a.ana", *words, cwd=folder)
    assert done.returncode == 0, done.stderr
    return [line for line in done.stdout.splitlines() if not line.startswith("  given: --set")]


def test_every_number_of_the_decks_is_reached_by_its_name(tmp_path):
    write(tmp_path / "deck")
    plain = explained(tmp_path / "deck")
    for name, place in (IN_GEOMETRY | IN_ANALYSIS).items():
        value = VALUES.get(name, "0.125")
        decks = {"geometry": with_number(GEOMETRY, place, value)} if name in IN_GEOMETRY else \
            {"analysis": with_number(ANALYSIS, place, value)}
        write(tmp_path / "edited", **decks)
        found = explained(tmp_path / "deck", "--set", f"{name}={value}")
        assert found == explained(tmp_path / "edited"), name
        assert found != plain, name


def test_explain_tells_what_was_given_and_a_later_one_wins(tmp_path):
    write(tmp_path)
    done = scree.call("explain", "a.ana", "--set", "joint(1).phi=40", "--set", "joint(1).friction_angle=41", cwd=tmp_path)
    assert "  given: --set joint(1).phi=40\n" in done.stdout
    assert "joint material 1 (joint(1) for --set)\n  friction angle (phi): 41 [degree]" in done.stdout


def test_a_point_of_a_block_file_is_reached(tmp_path):
    write(tmp_path)
    scree.cut("g.geo", output="g.blk", cwd=tmp_path)
    (tmp_path / "a.ana").write_text(ANALYSIS.replace("g.geo", "g.blk"))
    assert "  measured point 1 x y: 1.25 0.7 [length]" in explained(tmp_path, "--set", "measured_point(1).x=1.25")


def test_numbers_of_a_setting_are_as_far_apart_as_they_come(tmp_path):
    write(tmp_path)
    plain = explained(tmp_path, "--set", "support.both=0 0 2 0 0 1 2 1")
    assert any("support.both = 0 0 2 0 0 1 2 1" in line for line in plain)
    assert explained(tmp_path, "--set", "support.both= 0 0  2 0   0 1 2 1 ") == plain


@pytest.mark.parametrize("option, expected", [
    ("joint(1).phi=90", "expected the friction angle of joint material 1 below 90, found '90'"),
    ("joint(2).c=-1", "expected the cohesion of joint material 2 at least 0, found '-1'"),
    ("material(1).E=0", "expected the modulus E of block material 1 above 0, found '0'"),
    ("material(1).nu=0.5", "below 0.5"), ("material(1).ma=1e21", "of magnitude up to 1e20"), ("material(1).ma=nan", "a number"),
    ("material(1).E=1,5", "the decimal sign is a point"), ("material(1).ma=1 2", "a number for the density"),
    ("deck.n5=1.5", "a whole number"), ("deck.g1=0", "the step size (g1) above 0"), ("deck.k01=2", "at most 1"),
    ("deck.k02=2", "expected one of the numbers e0, k01, n5, g2, g1, g0 of deck, found 'k02'"),
    ("joint(1).E=1", "expected one of the numbers phi|friction_angle, c|cohesion, T|tensile_strength of joint(1), found 'e'"),
    ("joint(3).phi=1", "joint(1 to 2), line(1 to 5), material_line(1), fixed_line(1 to 2), fixed_point(1), load_point(1 to 2), "
                       "measured_point(1), which the decks have, found 'joint(3)'"),
    ("joint.phi=1", "which the decks have, found 'joint'"), ("material(1)=3", "expected GROUP.NAME=VALUE"),
    ("joint(1).phi=", "expected GROUP.NAME=VALUE"), ("load_point(1).time(2)=0", "times that increase"),
    ("fixed_point(2).move_x(1)=0", "expected one of"), ("line(1).jm=0", "the material of line 1 at least 1")])
def test_a_bad_number_is_one_line_that_names_the_option(option, expected, tmp_path):
    write(tmp_path)
    done = scree.call("run", "a.ana", "--set", option, cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, done.stderr
    assert "GROUP" in expected or done.stderr.startswith(f"scree: --set {option}: expected "), done.stderr


def test_a_run_has_the_bits_of_the_deck_with_that_number_and_goes_on_with_it(tmp_path):
    slide = {"geometry": GEOMETRY.replace("0.2 0.2 0.2 0.2\n0.8 0.2 0.8 0.2", "0.1 0.1 0.1 0.1\n0.9 0.1 0.9 0.1"),
             "analysis": "1 20 1 2 0.05 0.01\n2500 24500 1e8 0.2\n0 0 0\n0 0 0\n0.5 0 0\n30 0 0\n20 0 0\n"
                         "&deck geometry='g.geo' /\n&output every=5 /\n"}
    slide["geometry"] = slide["geometry"].replace("\n1\n0\n2\n2\n1\n0\n", "\n0\n0\n2\n0\n1\n0\n").replace(
        "1.5 0.2 1.6 0.2 2\n", "").replace("1.5 0.5\n1.6 0.6\n", "")
    write(tmp_path / "deck", **slide)
    write(tmp_path / "edited", slide["geometry"], slide["analysis"].replace("0.5 0 0", "0.5 0.25 0").replace("20 0 0", "20 5e3 0"))
    settings = ["material(1).vy=0.25", "joint(2).cohesion=5e3"]
    whole = scree.run("a.ana", settings=settings, cwd=tmp_path / "deck")
    edited = scree.run("a.ana", cwd=tmp_path / "edited")
    plain = scree.run("a.ana", output="plain.h5", cwd=tmp_path / "deck")
    assert np.array_equal(whole.vertices(), edited.vertices()) and not np.array_equal(whole.vertices(), plain.vertices())
    for folder, given in (("deck", settings), ("edited", [])):
        scree.run("a.ana", output="half.h5", settings=[*given, "step.end_time=0.1"], cwd=tmp_path / folder)
        done = scree.call("run", "--restart", "half.h5", "--set", "step.end_time=0.2", cwd=tmp_path / folder)
        assert done.returncode == 0, done.stderr
    on, edited = (scree.read(tmp_path / folder / "half.h5").vertices() for folder in ("deck", "edited"))
    assert np.array_equal(on, edited) and np.allclose(on, whole.vertices(), rtol=1e-9)
    done = scree.call("run", "--restart", "half.h5", "--set", "material(1).E=3", cwd=tmp_path / "deck")
    assert done.returncode == 2 and "expected one of step.size, " in done.stderr


def test_every_number_that_explain_prints_has_a_name(tmp_path):
    """Each number of a material is printed with the short name that --set takes in brackets."""
    write(tmp_path)
    text = "\n".join(explained(tmp_path))
    for kind, count in (("material", 13), ("joint", 3)):
        part = text.split(f"({kind}(1) for --set)\n")[1].split("\n" + ("block" if kind == "material" else "joint"))[0]
        names = [name for line in part.splitlines() for name in line.split("(")[1].split(")")[0].split()]
        assert len(names) == count, names
        for name in names:
            done = scree.call("explain", "a.ana", "--set", f"{kind}(1).{name}=0.25", cwd=tmp_path)
            assert done.returncode == 0 and "0.25" in done.stdout, name


@pytest.mark.parametrize("option, setting, given", [
    ("joint(1).phi=40", "joints.phi", "joints phi=10 20"), ("joint(2).cohesion=1", "joints.cohesion", "joints cohesion=1 2"),
    ("material(1).E=1e9", "materials.young", "materials young=1e9 2e9"), ("material(2).we=3", "materials.unit_weight", "materials unit_weight=1 2"),
    ("deck.g1=0.1", "step.size", "step size=0.01"), ("deck.g0=1e9", "contact.stiffness", "contact stiffness=1e8"),
    ("deck.n5=7", "step.end_time", "step end_time=0.1")])
def test_a_number_that_a_setting_stands_over_is_refused(option, setting, given, tmp_path):
    """It changed nothing without a word: a study of it had one row over and over."""
    write(tmp_path, analysis=ANALYSIS + f"&{given} /\n")
    done = scree.call("run", "a.ana", "--set", option, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr == f"scree: --set {option}: expected {setting}, which a.ana:25 gives over the numbers of the deck, found one of these\n"
