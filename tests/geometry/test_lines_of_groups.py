"""Lines that hold, load or absorb find their edges whole, whatever joints come near; what they do not find is said."""
import pytest

import scree

ANALYSIS = """1 {steps} 1 1 0.05 0.005
2500 24525 {young} 0.25
0 0 0  0 0 0  0 0 0
35 0 0
&deck geometry='g.geo', dialect='short'{deck} /
{groups}
"""
BOX = [(0, 0, 10, 0), (10, 0, 10, 4), (10, 4, 0, 4), (0, 4, 0, 0)]
# a trace with a vertex 3 mm above the base, where e0 w0 is 3.9 mm
TRACE = [(4.6, 0.9, 5, 0.003), (5, 0.003, 5.2, 0.5), (5.2, 0.5, 5.5, 0)]


def scene(folder, lines, n_boundary, groups, deck="", steps=40, e0=0.001, unit=1.0):
    """Writes decks of lines in a unit of length; the line x=... of groups holds numbers in it."""
    rows = "\n".join(" ".join(str(unit * x) for x in line) + " 1" for line in lines)
    (folder / "g.geo").write_text(f"{e0}\n{len(lines)} {n_boundary} 0 0 0 0 0 0\n{rows}\n")
    (folder / "g.ana").write_text(ANALYSIS.format(groups=groups, deck=deck, steps=steps, young=1e10 * unit**2))
    return folder / "g.ana"


def numbers(*values, unit=1.0):
    return " ".join(str(unit * x) for x in values)


@pytest.mark.parametrize("unit", (1e-3, 1.0, 1e3))
def test_a_vertex_of_a_trace_near_the_base_takes_no_support_away(tmp_path, unit):
    """All rock rests on its base, and no chip of it falls; a free fall of 0.2 s is 0.2 m, and E lets the rock settle by 2e-5 m."""
    sides = f"x={numbers(0, 0, 0, 4, unit=unit)} {numbers(10, 0, 10, 4, unit=unit)}"
    r = scree.run(scene(tmp_path, BOX + TRACE, 4, f"&support y={numbers(0, 0, 10, 0, unit=unit)}, {sides} /", unit=unit))
    assert r.bodies.area[0].sum() == pytest.approx(40 * unit**2, rel=1e-12)
    assert abs(r.displacement()).max() < 1e-4


GROUPS = {"support": "&support y=0 2 10 2 /",
          "absorbing": "&absorbing lines=0 2 10 2 /",
          "boundary": "&boundary lines=0 2 10 2, pressure=1 1 /",
          "stage": "&stage remove_inside=0 2 10 2 10 5 0 5 0 2 /"}


@pytest.mark.parametrize("group", GROUPS)
def test_a_joint_that_a_group_names_stays_straight(tmp_path, group):
    """Joints that cross 3 mm above a level joint bend it where no group names it, and come down onto it where one does."""
    crossing = [(0, 1.003, 10, 3.003), (10, 1.003, 0, 3.003)]
    lines = BOX + [(0, 2, 10, 2)] + crossing
    off = []
    for groups in ("", GROUPS[group]):
        deck = scene(tmp_path, lines, 4, groups)
        model = tmp_path / "model.h5"
        done = scree.call("cut", deck.name, "-o", model.name, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        off.append([y for x, y in scree.read(model).vertices(0) if 0 < abs(y - 2) < 0.1])
        model.unlink()
    assert off[0] and not off[1]


def check(folder, deck):
    done = scree.call("check", deck.name, cwd=folder)
    return done.returncode, done.stdout + done.stderr


@pytest.mark.parametrize("group", ("support", "absorbing", "boundary"))
def test_a_line_without_edges_is_told(tmp_path, group):
    """A line that leaves the rock inside the model: 4 % of it warns, 40 % is refused unless the deck allows it; outside nothing is said."""
    def of_width(width):
        """A box with a notch of a width in its top."""
        return [(0, 0, 10, 0), (10, 0, 10, 4), (10, 4, 6, 4), (6, 4, 6, 3), (6, 3, 6 - width, 3), (6 - width, 3, 6 - width, 4),
                (6 - width, 4, 0, 4), (0, 4, 0, 0)]

    def told(width, x1=0, x2=10, deck=""):
        line = f"{x1} 4 {x2} 4"
        groups = {"support": f"&support both=0 0 10 0, normal={line} /",
                  "absorbing": f"&support both=0 0 10 0 /\n&absorbing lines={line} /",
                  "boundary": f"&support both=0 0 10 0 /\n&boundary lines={line}, pressure=1 1 /"}[group]
        return check(tmp_path, scene(tmp_path, of_width(width), 8, groups, deck=deck))

    status, text = told(0.4)
    assert status == 0 and "none on 0.4 of its 10 in the model, most from (5.6, 4) to (6, 4)" in text
    status, text = told(4)
    assert status == 2 and "none on 4 of its 10" in text and "gaps='allow'" in text
    status, text = told(4, deck=", gaps='allow'")
    assert status == 0 and "none on 4 of its 10" in text
    status, text = told(0.005, x1=-1000, x2=1000)
    assert status == 0 and "all along line" not in text
