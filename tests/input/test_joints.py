"""scree joints through the program: the geometry deck it writes, what it refuses, and the same numbers by another hand."""
import math
import os
import pathlib
import re
import resource
import time

import pytest
import scree

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])

DECK = """! a slope over a tunnel, and a notch in the floor
&window x=0 20, y=0 10 /
&slope x=0 5 12 20, y=4 4 9 9, material=3 /
&tunnel centre=14 3, radius=1.5, sides=12 /
&tunnel x=17 18 18 17, y=-1 -1 2 2 /
&joint_set dip=30, spacing=0.5, length=5, bridge=1, randomness=0.5, material=2 /
&joint_set dip=-60, spacing=0.7, length=4, bridge=0.5, randomness=0.3, material=4 /
&seed value=7 /
&deck e0=0.002 /
&fixed x=1 19, y=0.5 0.5 /
&load x=11, y=8 /
&measured x=11 2, y=8 1 /
"""
WINDOW = "&window x=0 20, y=0 10 /\n"
ROUND_OFF = 1e-7  # coordinates are rounded to 1e-8 in a window of 20


def joints(folder, text, *words, output="rock.geo"):
    """Runs a deck; the numbers of the geometry deck it wrote."""
    (folder / "rock.joints").write_text(text)
    done = scree.call("joints", "rock.joints", *words, cwd=folder, timeout=60)
    assert done.returncode == 0, done.stderr
    return read((folder / output).read_text())


def read(text):
    """The numbers of a geometry deck by the layout of the manual."""
    numbers = [float(word) for line in text.split("\n&")[0].splitlines() for word in line.split("!")[0].split()]
    deck = {"e0": numbers[0]}
    counts = [int(number) for number in numbers[1:9]]
    deck["boundary"] = counts[1]
    assert counts[3] == 0
    at = 9
    for name, count, size in (("lines", counts[0], 5), ("material_lines", counts[2], 5), ("fixed", counts[4], 4),
                              ("load", counts[5], 2), ("measured", counts[6], 2), ("hole", counts[7], 2)):
        deck[name] = [tuple(numbers[at + size*i:at + size*(i + 1)]) for i in range(count)]
        at += size*count
    assert at == len(numbers)
    return deck


def splitmix64(state):
    """The generator by its definition, in integers of any length."""
    mask = 2**64 - 1
    while True:
        state = (state + 0x9E3779B97F4A7C15) & mask
        bits = state
        bits = ((bits ^ (bits >> 30))*0xBF58476D1CE4E5B9) & mask
        bits = ((bits ^ (bits >> 27))*0x94D049BB133111EB) & mask
        yield bits ^ (bits >> 31)


def level_traces(seed, spacing, length, bridge, randomness, width, height):
    """The first set of a seed, level, in a window about its middle: the same draws by another hand."""
    bits = splitmix64(next(splitmix64(seed)))

    def uniform():
        return (next(bits) >> 11)/2**53

    def draw(*means):
        return [mean*(1 + randomness*(2*uniform() - 1)) for mean in means]

    def draw_covering(*means):
        while True:
            found = draw(*means)
            if uniform()*(1 + randomness)*sum(means) <= sum(found):
                return found

    interval, = draw_covering(spacing)
    y = -height/2 + (1 - uniform())*interval
    while y <= height/2:
        trace, gap = draw_covering(length, bridge)
        x = -width/2 - uniform()*(trace + gap)
        while x <= width/2:
            left, right = max(x, -width/2), min(x + trace, width/2)
            if left < right:
                yield left + width/2, right + width/2, y + height/2
            x += trace + gap
            trace, gap = draw(length, bridge)
        y += draw(spacing)[0]


def test_the_deck_has_the_layout_of_the_manual(tmp_path):
    deck = joints(tmp_path, DECK)
    assert deck["e0"] == 0.002 and deck["boundary"] == 22
    assert deck["fixed"] == [(1, 0.5, 1, 0.5), (19, 0.5, 19, 0.5)]
    assert deck["load"] == [(11, 8)] and deck["measured"] == [(11, 8), (2, 1)]
    assert deck["hole"] == [(14, 3)]  # none for the notch, which is open
    # the window less the mouth of the notch and what is above the slope, the slope, the tunnel, the notch
    assert [line[4] for line in deck["lines"][:22]] == [1]*4 + [3]*3 + [1]*12 + [1]*3
    materials = [line[4] for line in deck["lines"][22:]]
    assert set(materials) == {2, 4} and materials == sorted(materials)  # set by set
    assert "seed 7" in (tmp_path / "rock.geo").read_text().splitlines()[-1]


def test_the_boundary_closes(tmp_path):
    deck = joints(tmp_path, DECK)
    ends = [end for x1, y1, x2, y2, _ in deck["lines"][:deck["boundary"]] for end in ((x1, y1), (x2, y2))]
    assert all(ends.count(end) == 2 for end in ends)


def test_every_joint_is_in_the_rock(tmp_path):
    """51 places on each: in the window, under the slope, out of the twelve-sided tunnel and of the notch."""
    def slope(x):
        return 4 if x < 5 else 9 if x > 12 else 4 + 5*(x - 5)/7

    deck = joints(tmp_path, DECK)
    inner = 1.5*math.cos(math.pi/12)
    for x1, y1, x2, y2, _ in deck["lines"][deck["boundary"]:]:
        for k in range(51):
            x, y = x1 + k/50*(x2 - x1), y1 + k/50*(y2 - y1)
            assert -ROUND_OFF <= x <= 20 + ROUND_OFF and -ROUND_OFF <= y <= slope(x) + ROUND_OFF
            sides = [(2*i + 1)*math.pi/12 for i in range(12)]
            assert max((x - 14)*math.cos(a) + (y - 3)*math.sin(a) for a in sides) >= inner - ROUND_OFF
            assert max(17 - x, x - 18, y - 2) >= -ROUND_OFF


def test_the_traces_are_those_of_the_seed_by_another_hand(tmp_path):
    for seed in (1, 2, 999999999):
        deck = joints(tmp_path, WINDOW + "&joint_set dip=0, spacing=0.4, length=2, bridge=0.3, randomness=0.7 /\n"
                      f"&deck e0=1e-6 /\n&seed value={seed} /\n")
        expected = list(level_traces(seed, 0.4, 2, 0.3, 0.7, 20, 10))
        found = [(x1, x2, y1) for x1, y1, x2, y2, _ in deck["lines"][4:]]
        assert len(found) == len(expected) > 150
        for a, b in zip(found, expected):
            assert a == pytest.approx(b, abs=1e-8)


def test_without_randomness_the_lines_are_regular(tmp_path):
    deck = joints(tmp_path, WINDOW + "&joint_set dip=90, spacing=2, length=1e6 /\n")
    x = [line[0] for line in deck["lines"][4:]]
    assert len(x) == 10 and all(a - b == pytest.approx(2, abs=ROUND_OFF) for a, b in zip(x, x[1:]))
    assert all((x1, y1, y2) == (x2, 0, 10) for x1, y1, x2, y2, _ in deck["lines"][4:])


def test_the_same_seed_writes_the_same_deck_and_another_another(tmp_path):
    texts = []
    for seed in (7, 7, 8):
        joints(tmp_path, DECK.replace("value=7", f"value={seed}"))
        texts.append((tmp_path / "rock.geo").read_text())
    assert texts[0] == texts[1] != texts[2]


def test_the_order_of_the_groups_and_their_dress_mean_nothing(tmp_path):
    lines = DECK.splitlines()
    plain = joints(tmp_path, DECK)
    assert joints(tmp_path, "\n".join([*lines[7:], *lines[:7]])) == plain
    assert joints(tmp_path, DECK.replace(", y", "\n y").replace("\n", "\r\n").upper()) == plain


def test_a_closed_polygon_may_repeat_its_first_corner(tmp_path):
    assert len(joints(tmp_path, "&window x=0 4 2 0, y=0 0 3 0 /")["lines"]) == 3


def test_a_window_that_nothing_crosses_is_a_block_to_scree(tmp_path):
    joints(tmp_path, WINDOW + "&slope x=0 20, y=4 9 /\n&fixed x=1, y=1 /\n&load x=3, y=2 /\n&measured x=2, y=3 /\n")
    (tmp_path / "rock.ana").write_text("1 10 1 1 0.05 0.01 2500 0 1e10 0.3 0 0 0 0 0 0 0 0 1 30 0 0\n")
    done = scree.call("check", "rock", cwd=tmp_path)
    assert done.returncode == 0 and "1 blocks" in done.stdout, done.stderr


def test_the_output_has_the_stem_of_the_deck_or_the_name_asked_for(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "wall.joints").write_text(DECK)
    for words, file in ((["there/wall.joints"], "wall.geo"), (["there/wall.joints", "-o", "there/x.dat"], "there/x.dat")):
        done = scree.call("joints", *words, cwd=tmp_path)
        assert done.returncode == 0 and (tmp_path / file).exists()
        assert re.fullmatch(rf"{file}: 22 boundary lines, \d+ joints of 2 sets, seed 7\n", done.stdout)
    done = scree.call("joints", "there/wall.joints", "--quiet", cwd=tmp_path)
    assert done.returncode == 0 and done.stdout == "" and done.stderr == ""


def test_fixed_lines_go_from_point_to_point(tmp_path):
    deck = joints(tmp_path, DECK + "&fixed_line x=-1 10 21, y=0.2 0.3 0.2 /\n")
    assert deck["fixed"] == [(1, 0.5, 1, 0.5), (19, 0.5, 19, 0.5), (-1, 0.2, 10, 0.3), (10, 0.3, 21, 0.2)]


def test_supports_end_the_geometry_and_hold_the_rock(tmp_path):
    """A closed line is four; what holds the rock along all of its bottom and sides leaves it at rest in equilibrium."""
    joints(tmp_path, WINDOW + "&joint_set dip=30, spacing=3, length=50 /\n&support x=0 0, y=0 10 /\n&support x=20 20, y=0 10 /\n"
           "&support x=0 20, y=0 0, hold='both' /\n&support x=0 1 1 0 0, y=0 0 1 1 0, hold='x' /\n")
    text = (tmp_path / "rock.geo").read_text()
    assert text.endswith("\n&support normal=0 0 0 10 20 0 20 10 x=0 0 1 0 1 0 1 1 1 1 0 1 0 1 0 0 both=0 0 20 0 /\n")
    joints(tmp_path, text="".join(line + "\n" for line in (tmp_path / "rock.joints").read_text().splitlines()[:-1]))
    (tmp_path / "rock.ana").write_text("0 200 1 1 0.05 0.01\n2500 25000 1e9 0.25\n0 0 0\n0 0 0\n0 0 0\n40 0 0\n&step balance=1e-3 /\n")
    results = scree.run(tmp_path / "rock.ana")
    assert results.scene.status == "complete" and results.history.unbalanced[-1] < 1e-3


def test_slivers_join_and_it_is_said(tmp_path):
    text = DECK.replace("&deck e0=0.002", "&deck e0=0.002, least_area=0.1")
    deck = joints(tmp_path, text)
    plain = joints(tmp_path, DECK, "-o", "plain.geo", output="plain.geo")
    assert deck == plain  # the lines are the same, the cutter takes out what parts the slivers
    said = scree.call("joints", "rock.joints", cwd=tmp_path).stdout
    assert "joints of 2 sets" in said
    (tmp_path / "rock.joints").write_text(text)
    said = int(re.search(r"; (\d+) blocks smaller than 0.1 joined their neighbours\n", scree.call("joints", "rock.joints", cwd=tmp_path).stdout)[1])
    counts = [int(scree.call("cut", name, cwd=tmp_path).stdout.split()[0]) for name in ("plain.geo", "rock.geo")]
    assert said > 10 and counts[0] - counts[1] == said


SET = "&joint_set dip=30, spacing=1, length=5"
# name: deck, line of the error, a word of what was expected
BAD = {
    "empty": ("", 1, "a &window"),
    "no window": (SET + " /\n", 2, "a &window"),
    "two windows": (WINDOW*2, 2, "once"),
    "two seeds": (WINDOW + "&seed value=1 /\n&seed value=2 /\n", 3, "once"),
    "numbers": ("0.001\n" + WINDOW, 1, "'&'"),
    "numbers after a group": (WINDOW + "5\n", 2, "'&'"),
    "an unknown group": (WINDOW + "&joints /\n", 2, "&window, &tunnel, &slope, &joint_set, &seed, &deck, &fixed_line, &support, &fixed, &load"),
    "an unknown name": (WINDOW + "&joint_set\n dpi=3 /\n", 3, "dip, spacing, length, bridge, randomness, material"),
    "a name twice": (WINDOW + SET + ", dip=3 /\n", 2, "second dip"),
    "a name without '='": (WINDOW + "&seed value 3 /\n", 2, "'='"),
    "a group without end": (WINDOW + SET + "\n", 3, "'/'"),
    "no dip": (WINDOW + "&joint_set spacing=1, length=5 /\n", 2, "dip in &joint_set"),
    "no spacing": (WINDOW + "&joint_set dip=1, length=5 /\n", 2, "spacing in &joint_set"),
    "no length": (WINDOW + "&joint_set dip=1, spacing=5 /\n", 2, "length in &joint_set"),
    "a dip that is a word": (WINDOW + "&joint_set dip=steep, spacing=1, length=1 /\n", 2, "a number for joint_set.dip"),
    "two dips": (WINDOW + "&joint_set dip=1 2, spacing=1, length=1 /\n", 2, "one number"),
    "a dip of 400": (WINDOW + "&joint_set dip=400, spacing=1, length=1 /\n", 2, "at most 360"),
    "a spacing of 0": (WINDOW + "&joint_set dip=1, spacing=0, length=1 /\n", 2, "above 0"),
    "a length of 0": (WINDOW + "&joint_set dip=1, spacing=1, length=0 /\n", 2, "above 0"),
    "a negative bridge": (WINDOW + SET + ", bridge=-1 /\n", 2, "at least 0"),
    "a randomness above 1": (WINDOW + SET + ", randomness=1.1 /\n", 2, "at most 1"),
    "a randomness below 0": (WINDOW + SET + ", randomness=-0.1 /\n", 2, "at least 0"),
    "a randomness that is NaN": (WINDOW + SET + ", randomness=nan /\n", 2, "a number"),
    "material 0": (WINDOW + SET + ", material=0 /\n", 2, "at least 1"),
    "a material that is not whole": (WINDOW + SET + ", material=1.5 /\n", 2, "whole"),
    "1e9 traces": (WINDOW + "&joint_set dip=1, spacing=1e-4, length=1e-3 /\n", 2, "at most 1000000 traces"),
    "a spacing too small for a count": (WINDOW + "&joint_set dip=1, spacing=1e-20, length=1e-3 /\n", 2, "at most 1000000 traces"),
    "a spacing too small for the arithmetic": (WINDOW + "&joint_set dip=1, spacing=1e-290, length=1e-3 /\n", 2, "at least 1e-20"),
    "a window without y": ("&window x=0 1 /\n", 1, "y in &window"),
    "a window with one y too few": ("&window x=0 1 1,\n y=0 1 /\n", 2, "as many"),
    "a window of one corner": ("&window x=0, y=0 /\n", 1, "from 2"),
    "a window without height": ("&window x=0 1, y=0 0 /\n", 1, "wide and high"),
    "a window on a line": ("&window x=0 1 2, y=0 1 2 /\n", 1, "meet at their corners"),
    "a window that crosses itself": ("&window x=0 1 1 0, y=0 1 0 1 /\n", 1, "meet at their corners"),
    "a window too far": ("&window x=1e13 2e13, y=0 1 /\n", 1, "at most"),
    "a window small for its distance": ("&window x=1e6 1000001, y=0 1 /\n", 1, "1e-5"),
    "a window of words": ("&window x=left right, y=0 1 /\n", 1, "a number"),
    "a tunnel of nothing": (WINDOW + "&tunnel /\n", 2, "x and y, or centre and radius"),
    "a tunnel of two corners": (WINDOW + "&tunnel x=1 2, y=1 2 /\n", 2, "from 3"),
    "a tunnel of both kinds": (WINDOW + "&tunnel x=1 2 2, y=1 2 3, centre=1 1, radius=1 /\n", 2, "both"),
    "a tunnel without radius": (WINDOW + "&tunnel centre=1 1 /\n", 2, "centre and radius"),
    "a tunnel of two sides": (WINDOW + "&tunnel centre=1 1, radius=1, sides=2 /\n", 2, "at least 3"),
    "a tunnel of 1e8 sides": (WINDOW + "&tunnel centre=1 1, radius=1, sides=100000000 /\n", 2, "at most 2000"),
    "a tunnel with a centre of three": (WINDOW + "&tunnel centre=1 1 1, radius=1 /\n", 2, "two numbers"),
    "a tunnel that crosses itself": (WINDOW + "&tunnel x=1 2 2 1, y=1 2 1 2 /\n", 2, "meet at their corners"),
    "a tunnel outside": (WINDOW + "&tunnel centre=30 1, radius=1 /\n", 2, "from the window"),
    "a tunnel that takes all": (WINDOW + "&tunnel x=-1 21 21 -1, y=-1 -1 11 11 /\n", 1, "rock left"),
    "a slope of one point": (WINDOW + "&slope x=1, y=1 /\n", 2, "from 2"),
    "a slope that ends inside": (WINDOW + "&slope x=0 10, y=4 5 /\n", 2, "from the left"),
    "a slope above the window": (WINDOW + "&slope x=0 20, y=11 12 /\n", 2, "from the window"),
    "a slope that crosses itself": (WINDOW + "&slope x=0 9 9 5 5 20, y=1 1 5 5 0 0 /\n", 2, "meet at their corners"),
    "a negative seed": (WINDOW + "&seed value=-1 /\n", 2, "at least 0"),
    "a seed of words": (WINDOW + "&seed value=now /\n", 2, "whole"),
    "an e0 of 0": (WINDOW + "&deck e0=0 /\n", 2, "at least"),
    "an e0 of 0.5": (WINDOW + "&deck e0=0.5 /\n", 2, "at most 0.1"),
    "a fixed point outside": (WINDOW + "&fixed x=1 30, y=1 1 /\n", 2, "a fixed point in the rock"),
    "a load point in a tunnel": (WINDOW + "&tunnel centre=5 5, radius=1 /\n&load x=5, y=5 /\n", 3, "a load point in the rock"),
    "a measured point in the air": (WINDOW + "&slope x=0 20, y=5 5 /\n&measured x=5, y=6 /\n", 3, "a measured point"),
    "a fixed line outside": (WINDOW + "&fixed_line x=0 20, y=-1 -1 /\n", 2, "a fixed line that meets the rock"),
    "a fixed line of a point": (WINDOW + "&fixed_line x=1, y=1 /\n", 2, "from 2"),
    "a support in the air": (WINDOW + "&slope x=0 20, y=5 5 /\n&support x=0 20, y=10 10 /\n", 3, "a support that meets the rock"),
    "a support that holds nothing": (WINDOW + "&support x=0 20, y=0 0, hold='rock' /\n", 2, "normal, x, y, both"),
    "a least area below 0": (WINDOW + "&deck least_area=-1 /\n", 2, "at least 0"),
    "a byte that is no text": ("&window\0 x=0 1, y=0 1 /\n", 1, "text"),
}


@pytest.mark.parametrize("name", BAD)
def test_bad_deck_is_refused_in_one_line(name, tmp_path):
    text, at, expected = BAD[name]
    (tmp_path / "a.joints").write_text(text)
    before = time.perf_counter()
    done = scree.call("joints", "a.joints", cwd=tmp_path, timeout=20)
    line = done.stderr
    assert done.returncode == 2, line
    assert len(line.splitlines()) == 1 and line.startswith(f"scree: a.joints:{at}: expected "), line
    assert expected in line and ", found " in line, line
    assert not (tmp_path / "a.geo").exists()
    assert time.perf_counter() - before < 5  # a hang, not a speed; each takes milliseconds
    assert resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss < 500_000  # KiB


@pytest.mark.parametrize("words, expected", [
    (["none.joints"], "no such file"), (["."], "directory"), ([], "a deck after joints"), (["a.geo", "a.geo"], "one deck"),
    (["a.geo"], "another file"), (["./a.geo"], "another file"), (["a.geo", "-o", "."], "directory"),
    (["a.geo", "-o", "no/where.geo"], "can be written"),
    (["a.geo", "--set", "seed.value=3"], "--set with run")])
def test_bad_words_are_one_line_and_status_2(words, expected, tmp_path):
    (tmp_path / "a.geo").write_text(WINDOW)
    done = scree.call("joints", *words, cwd=tmp_path)
    assert done.returncode == 2 and len(done.stderr.splitlines()) == 1, done.stderr
    assert expected in done.stderr and "expected" in done.stderr and "found" in done.stderr, done.stderr
    assert (tmp_path / "a.geo").read_text() == WINDOW


def test_the_manual_names_all_that_the_program_takes(tmp_path):
    """The names are those that the errors list."""
    def listed(text):
        (tmp_path / "a.joints").write_text(text)
        done = scree.call("joints", "a.joints", cwd=tmp_path)
        return re.search(r"one of the (?:groups|names) (.*?)(?: in &\w+)?, found", done.stderr).group(1).split(", ")

    manual = (SOURCE / "doc" / "joint-sets.md").read_text()
    groups = [group.removeprefix("&") for group in listed("&nothing /")]
    for group in groups:
        for name in listed(f"&{group} nothing=1 /"):
            assert f"`{group}.{name}`" in manual
    taken = {f"{group}.{name}" for group in groups for name in listed(f"&{group} nothing=1 /")}
    assert set(re.findall(r"^\| `(\w+\.\w+)`", manual, re.M)) == taken


def test_the_deck_of_the_manual_runs(tmp_path):
    manual = (SOURCE / "doc" / "joint-sets.md").read_text()
    deck = "\n".join(line for line in manual.splitlines() if line.startswith("    &"))
    assert len(joints(tmp_path, deck)["lines"]) > 50
