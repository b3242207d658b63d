"""tools/cost_of_accuracy: its numbers about errors, orders that are known, a study that is stopped, its page."""
import base64
import csv
import json
import math
import os
import pathlib
import re
import signal
import subprocess
import time

import numpy as np
import pytest
from scree import block_files
from scree.accuracy import choices, orders
from scree.validation import references

SCREE = os.environ["SCREE"]
SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
TOOL = SOURCE / "tools" / "cost_of_accuracy"
TURN = SOURCE / "input" / "paper" / "rotation"
TIMED = ("seconds", "rounds", "front: area", "front: angle")  # what differs from one study to the next


def words(folder, *given):
    return [TOOL, *map(str, given), "--scree", SCREE, "--folder", folder, "--jobs", "2"]


def cost(folder, *given):
    """The JSON of a study, and its rows by scene."""
    done = subprocess.run(words(folder, *given), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    written = json.loads((folder / "cost.json").read_text())
    return written, {scene["scene"]: scene["rows"] for scene in written["scenes"]}


# Numbers about errors

@pytest.mark.parametrize("order", [0.5, 1.0, 2.0, 4.0])
@pytest.mark.parametrize("ratio", [2.0, 3.0])
def test_the_limit_of_a_power_is_exact(order, ratio):
    sizes = 0.1 / ratio**np.arange(4)
    limit = orders.extrapolate(sizes, [np.array([3.0, -1.0]) + h**order * np.array([2.0, 5.0]) for h in sizes])
    assert limit.value == pytest.approx([3.0, -1.0], abs=1e-12)
    assert limit.order == pytest.approx(order, abs=1e-9) and limit.doubt < 1e-9


@pytest.mark.parametrize("f", [math.exp, math.cos, lambda h: 1 / (1 + 3 * h + h**2), lambda h: 5 + h**2 - 2 * h**3])
@pytest.mark.parametrize("largest", [0.2, 0.05])
def test_a_limit_tells_how_far_it_may_be_off(f, largest):
    """The error is not above what it says, and that is not much above the last step of the values."""
    sizes = largest / 2**np.arange(4)
    limit = orders.extrapolate(sizes, [f(h) for h in sizes])
    assert abs(limit.value[0] - f(0.0)) <= limit.doubt <= 1.5 * abs(f(sizes[-1]) - f(sizes[-2]))


def test_values_without_an_order_have_the_last_for_a_limit():
    """Values that jump, grow or turn about are off by as much as they jumped."""
    for values, doubt in (([0, 1, 0, 1], 1.0), ([0, 1, 3, 7], 4.0), ([0, 3, 1, 2], 2.0)):
        limit = orders.extrapolate([8, 4, 2, 1], values)
        assert (limit.value[0], limit.doubt, limit.order) == (values[-1], doubt, None)
    assert orders.extrapolate([2, 1], [5.0, 6.0]).doubt == 1.0 and orders.extrapolate([1], [5.0]).doubt == math.inf


def test_limits_that_disagree_are_as_sure_as_they_agree():
    sure, vague = orders.Limit(1.0, 0.01), orders.Limit(1.5, 0.2)
    both = orders.agreed([vague, sure])
    assert both.value[0] == 1.0 and both.doubt == pytest.approx(0.3)
    assert orders.agreed([sure, orders.Limit(1.1, 0.2)]).doubt == 0.01


def test_an_order_is_what_errors_agree_on_or_why_there_is_none():
    sizes = [8.0, 4.0, 2.0, 1.0]
    assert orders.observed_order(sizes, [h**2 for h in sizes]) == (pytest.approx(2.0), "2.00")
    # below the doubt of the reference errors mean nothing, above it they do
    assert orders.observed_order(sizes, [64.0, 16.0, 4.0, 2.5], doubt=0.9)[0] == pytest.approx(2.0)
    for errors, doubt, impacts, said in (
            ([1e-3] * 4, 1e-2, False, "none: doubt"), ([1e-3, 1.01e-3, 9.9e-4, 1e-3], 0.0, False, "none: a floor"),
            ([4.0, 1.0, 3.0, 0.1], 0.0, True, "none: impacts"), ([4.0, 1.0, 3.0, 0.1], 0.0, False, "none: uneven"),
            ([4.0, 2.0, None, math.inf], 0.0, False, "none: sizes"), ([None] * 4, 0.0, True, "none: no runs")):
        assert orders.observed_order(sizes, errors, doubt, impacts) == (None, said)


def test_the_front_is_who_is_beaten_by_nobody():
    errors, seconds = [1.0, 0.5, 0.6, 0.1, 0.1, 0.05], [1.0, 2.0, 3.0, 4.0, 5.0, 4.0]
    marked = orders.front(errors, seconds)
    for i in range(6):
        beaten = any(errors[j] <= errors[i] and seconds[j] <= seconds[i] and (errors[j], seconds[j]) != (errors[i], seconds[i])
                     for j in range(6))
        assert marked[i] is not beaten


def test_the_cost_to_reach_an_error_is_that_from_which_on_it_is_kept():
    """Time 1/h and error h^2 are the time error^-1/2; a large step that is exact by luck counts for nothing."""
    sizes = [1.0, 0.5, 0.25, 0.125]
    seconds, errors = [1 / h for h in sizes], [h**2 for h in sizes]
    for wanted in (0.7, 0.1, 0.03):
        assert orders.cost_to_reach(wanted, sizes, errors, seconds) == pytest.approx(wanted**-0.5)
    assert orders.cost_to_reach(2.0, sizes, errors, seconds) == 1.0
    assert orders.cost_to_reach(1e-3, sizes, errors, seconds) is None
    assert orders.cost_to_reach(0.1, sizes, [1e-9, *errors[1:]], seconds) == pytest.approx(0.1**-0.5)


def test_the_grid_varies_one_axis_at_a_time_or_all():
    axes = {"strain": ["deck", "green"], "integrator": ["deck", "shi", "newmark"], "contact": ["deck", "0.1"],
            "tolerance": ["deck"], "mesh": ["deck", "2"], "accuracy": ["deck"], "step": [2.0, 1.0]}
    assert len(choices.grid(axes)) == 2 * 2 * (3 + 1 + 1)
    assert len(choices.grid(axes, every=True)) == 2 * 3 * 2 * 2 * 2


# Closed forms of the scenes

def test_a_pendulum_swings_as_its_equation_says():
    """Steps of the classical method of Runge and Kutta, whose error here is 1e-11; the period by arithmetic-geometric means."""
    length, amplitude, steps = 0.94, 2.4, 4000

    def rate(state):
        return np.array([state[1], -9.81 / length * math.sin(state[0])])

    state, h = np.array([amplitude, 0.0]), 3.0 / steps
    for _ in range(steps):
        a = rate(state)
        b = rate(state + h / 2 * a)
        c = rate(state + h / 2 * b)
        state = state + h / 6 * (a + 2 * b + 2 * c + rate(state + h * c))
    assert references.pendulum(amplitude, length, 3.0) == pytest.approx(state[0], abs=1e-9)
    assert references.pendulum(1e-4, length, 0.3) == pytest.approx(1e-4 * math.cos(0.3 * math.sqrt(9.81 / length)), rel=1e-7)
    # a period of 1.180341 times that of small swings at 90 degrees
    period = 1.180341 * 2 * math.pi * math.sqrt(length / 9.81)
    assert references.pendulum(math.pi / 2, length, period) == pytest.approx(math.pi / 2, abs=1e-5)


def test_a_rocking_block_is_where_its_time_says():
    block = references.Rocking(0.25, 1.0)
    start = 0.5 * block.alpha
    for time in (0.1, 0.3, 0.49):
        assert block.time(start, block.tilt(start, time)) == pytest.approx(time, rel=1e-9)
    assert block.tilt(start, block.impact(start)[0]) == pytest.approx(0.0, abs=1e-9)


# Studies

@pytest.fixture(scope="module")
def turning(tmp_path_factory):
    folder = tmp_path_factory.mktemp("turning")
    steps = [4, 2, 1, 0.5, 0.25]
    return (folder, *cost(folder, "triangle", "--steps", *steps, "--tolerances", "deck", "--rounds", 1))


def test_orders_that_are_known_are_observed(turning):
    """Of Newmark: 1 with beta 1, 2 with beta 1/2; of the middle of the step 2. Small strain grows by (w dt)^2 a step."""
    _, _, rows = turning
    seen = {(row["strain"], row["integrator"]): row for row in rows["triangle"]}
    for integrator, order in (("newmark 1, 0.5", 1), ("newmark 1, 0.5625", 1), ("newmark 0.5, 0.5", 2), ("energy_momentum 0.5", 2),
                              ("energy_momentum 1", 2), ("energy_decaying 1", 2)):
        assert seen["green", integrator]["order: angle"] == pytest.approx(order, abs=0.1), integrator
    assert seen["small", "newmark 1, 0.5"]["order: area"] == pytest.approx(1.0, abs=0.1)


def test_errors_are_those_of_theory(turning):
    """With the angle a a step: the middle of the step turns by 2 atan(a/2); small strain by Shi's step grows by a w t."""
    _, _, rows = turning
    for row in rows["triangle"]:
        a = 2 * math.pi * row["step"]
        if row["integrator"] == "energy_momentum 0.5":
            assert row["error: angle"] == pytest.approx(1 - 2 * math.atan(a / 2) / a, rel=1e-3, abs=1e-7)
        if (row["strain"], row["integrator"]) == ("small", "newmark 1, 0.5"):
            assert row["error: area"] == pytest.approx(2 * math.pi * a, rel=a / 4)


def test_the_default_is_that_of_a_new_deck(turning):
    _, written, rows = turning
    default = [row for row in rows["triangle"] if row["default"]]
    assert len(default) == 5 and {(row["strain"], row["integrator"]) for row in default} == {("auto", "energy_decaying 1")}
    reached = written["scenes"][0]["cost to reach"]["angle"]
    assert [time for time, *_ in reached["0.01"]] == sorted(time for time, *_ in reached["0.01"])
    once = [row["error: angle"] for row in rows["triangle"] if (row["strain"], row["integrator"]) == ("small", "newmark 1, 0.5625")]
    assert len(once) == 5 and min(once) > 1e-3  # an error of a/w t is above it at all these steps


def test_runs_are_ranked_by_instructions_once_all_have_them(tmp_path):
    """Counts that go against the seconds turn the front about, and with it who is cheapest; with one missing seconds rank."""
    given = ["triangle", "--strains", "green", "--integrators", "deck", "--steps", 1, 0.5, "--tolerances", "deck", "--contacts", "deck",
             "--rounds", 1]
    written, _ = cost(tmp_path, *given)
    assert written["scenes"][0]["ranked by"] == "seconds"
    records = sorted((tmp_path / "triangle" / "runs").glob("*.json"), key=lambda path: json.loads(path.read_text())["steps"])
    for path, count in zip(records, (5000, 123)):  # the finer run the cheaper one
        path.write_text(json.dumps({**json.loads(path.read_text()), "instructions": count}))
    written, rows = cost(tmp_path, *given)
    scene = written["scenes"][0]
    assert scene["ranked by"] == "instructions"
    assert [row["front: angle"] for row in sorted(rows["triangle"], key=lambda row: -row["step"])] == [False, True]
    assert scene["cost to reach"]["angle"]["0.1"][0][0] == 5000  # the largest step will do
    assert "the cheapest, by instructions" in (tmp_path / "index.html").read_text()
    records[0].write_text(json.dumps({name: value for name, value in json.loads(records[0].read_text()).items() if name != "instructions"}))
    assert cost(tmp_path, *given)[0]["scenes"][0]["ranked by"] == "seconds"


def test_the_page_needs_no_network_and_shows_all_scenes(turning):
    folder, written, rows = turning
    page = (folder / "index.html").read_text()
    pictures = re.findall(r"src='([^']*)'", page)
    words = re.sub(r"src='data:[^']*'", "", page)  # the letters of a picture may spell anything
    assert not re.search(r"https?:|//\w+\.|<script|<link|<iframe|@import|url\(|href|src=", words, re.I)
    assert len(pictures) == len(written["scenes"])
    for picture, scene in zip(pictures, written["scenes"]):
        kind, data = picture.split(",")
        assert kind == "data:image/png;base64" and base64.b64decode(data) == (folder / f"{scene['scene']}.png").read_bytes()
    assert page.count("<tr class=default>") == sum(row["default"] for row in rows["triangle"])


def without_times(path):
    return [{name: value for name, value in row.items() if name not in TIMED} for row in csv.DictReader(open(path, newline=""))]


def test_a_study_that_is_killed_goes_on_and_ends_with_the_same_table(tmp_path):
    """What was done is not done again; what was written when it died is not taken for a run."""
    given = ["triangle", "--strains", "green", "--steps", 4, 2, 1, "--tolerances", "deck", "--rounds", 1]
    folder, whole = tmp_path / "killed", tmp_path / "whole"
    runs = folder / "triangle" / "runs"
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(words(folder, *given), start_new_session=True, **quiet) as study:
        while study.poll() is None and len(list(runs.glob("*.json"))) < 5:
            time.sleep(0.01)
        os.killpg(study.pid, signal.SIGKILL)
    assert study.returncode == -signal.SIGKILL
    done = {path: path.read_bytes() for path in runs.glob("*.json")}
    (runs / "half.part").write_text('{"ended": "compl')
    broken = next(iter(done))
    broken.write_bytes(done.pop(broken)[:20])
    written, _ = cost(whole, *given)
    assert 4 <= len(done) < len(written["scenes"][0]["rows"])
    cost(folder, *given)
    assert all(path.read_bytes() == record for path, record in done.items())
    assert without_times(folder / "cost.csv") == without_times(whole / "cost.csv")


def test_rounds_add_times_and_change_no_figure(tmp_path):
    given = ["triangle", "--strains", "green", "--integrators", "momentum", "--steps", 4, 2, "--tolerances", "deck"]
    _, once = cost(tmp_path, *given, "--rounds", 1)
    _, thrice = cost(tmp_path, *given, "--rounds", 3)
    assert [row["rounds"] for row in once["triangle"]] == [1, 1] and [row["rounds"] for row in thrice["triangle"]] == [3, 3]
    for a, b in zip(once["triangle"], thrice["triangle"]):
        assert a["error: angle"] == b["error: angle"] and a["solves"] == b["solves"]


def test_the_reference_of_a_deck_is_the_truth_to_what_it_says(tmp_path):
    """The triangle of the paper's T4, from a steady state: a turn is 2 pi, its energy I w^2/2, but for what it is stretched by."""
    written, rows = cost(tmp_path, TURN / "t4.ana", "--quantity", "rotation", "kinetic", "--strains", "deck", "--steps", 4, 2, 1,
                         "--contacts", "deck", "--tolerances", "deck", "--rounds", 1)
    answers = written["scenes"][0]["answers"]
    inertia = 2500 * math.sqrt(0.1875) * 0.01 * 5 / 12 * 0.01  # of an equilateral triangle about a corner: m 5 a^2/12
    stretch = 4e-8  # rho w^2 a^2/E, which changes the moment of inertia
    for name, truth in (("rotation", 2 * math.pi), ("kinetic", inertia * (2 * math.pi)**2 / 2)):
        answer = answers[name]
        assert not answer["closed form"]
        off = abs(answer["value"][0] - truth) / answer["scale"]
        assert off <= 3 * answer["doubt"] + stretch, (name, answer)
        coarse = max(row[f"error: {name}"] for row in rows["t4"])
        assert answer["doubt"] < 1e-2 * coarse  # else it says nothing
    for row in rows["t4"]:
        if row["integrator"] == "newmark 0.5, 0.5":
            assert row["order: rotation"] == pytest.approx(2.0, abs=0.1)


def test_the_reference_of_a_mesh_is_that_of_two_dimensional_elasticity(tmp_path):
    """Quadratic elements gave (0.25859, 0.60977) under two forces at the corners; constant strain converges with the square."""
    written, _ = cost(tmp_path, "cantilever", "--strains", "green", "--integrators", "newmark", "--steps", 8, "--tolerances",
                      "deck", "--meshes", "deck", 4, 2, 0.5, "--rounds", 1)
    scene, = written["scenes"]
    answer = scene["answers"]["deflection"]
    off = np.abs(np.array(answer["value"]) - [-0.25859, -0.60977]).max() / answer["scale"]
    assert off <= answer["doubt"] < 0.01
    assert scene["orders in the mesh"]["deflection"]["green newmark 1, 0.5625"] == pytest.approx(2.0, abs=0.3)


def test_ways_that_contradict_themselves_are_left_out(tmp_path):
    """Small strain keeps no energy of Green strain, and has no tolerance of an iteration."""
    _, rows = cost(tmp_path, "triangle", "--strains", "small", "--integrators", "newmark", "momentum", "--tolerances", "deck",
                   "1e-3", "--steps", 2, "--rounds", 1)
    row, = rows["triangle"]
    assert (row["strain"], row["integrator"], row["tolerance"]) == ("small", "newmark 1, 0.5625", "")


def test_a_run_that_fails_has_a_row_and_no_error(tmp_path):
    """So many steps are stopped after a second, and again where there is more time, but not again where there is not."""
    deck = tmp_path / "long.ana"
    deck.write_text((TURN / "t4.ana").read_text().replace("geometry='", f"geometry='{TURN}/").replace("\n100  ", "\n9000000  "))
    given = [deck, "--strains", "deck", "--integrators", "deck", "--contacts", "deck", "--tolerances", "deck", "--steps", 1,
             "--rounds", 1, "--quantity", "area"]
    for limit, said in ((1, "1 s"), (2, "2 s"), (1, "2 s")):
        _, rows = cost(tmp_path, *given, "--limit", limit)
        row, = rows["long"]
        assert row["ended"] == f"stopped after {said}" and row["error: area"] is None
        assert row["order in words: area"] == "none: no runs"


@pytest.mark.parametrize("given, expected", [
    (["nowhere.ana"], "expected a deck or one of triangle"), (["triangle", "--set", "contact.nonsense=1"], "nonsense"),
    (["triangle", "--strains", "large"], "expected deck, small"), (["triangle", "--contacts", "-1"], "above 0"),
    ([TURN / "t4-dda.ana", "--meshes", "deck", "2", "--integrators", "deck", "--contacts", "deck"], "expected a scene with cover.edge"),
    ([TURN / "t4.ana", f"{TURN}/../rotation/t4.ana"], "decks of different names")], ids=lambda x: "")
def test_what_is_wrong_is_said_in_one_line(given, expected, tmp_path):
    done = subprocess.run(words(tmp_path, *given), capture_output=True, text=True)
    assert done.returncode in (1, 2) and expected in done.stderr.splitlines()[-1], done.stderr
    assert "Traceback" not in done.stderr


def test_a_change_of_any_file_of_a_deck_is_another_run(tmp_path):
    """Of the deck, and of the geometry that it names or that lies beside it; nothing else makes a run anew."""
    deck, geometry = tmp_path / "turns.ana", tmp_path / "turns.geo"
    deck.write_text((TURN / "t4.ana").read_text().replace("&deck geometry='triangle.geo' /", ""))
    geometry.write_text((TURN / "triangle.geo").read_text())
    given = [deck, "--strains", "deck", "--integrators", "deck", "--contacts", "deck", "--tolerances", "deck", "--steps", 4,
             "--rounds", 1, "--quantity", "area"]
    count = []
    for change in (lambda: None, lambda: None, lambda: geometry.write_text(geometry.read_text().replace("0.1  0.0 ", "0.11 0.0 ")),
                   lambda: deck.write_text(deck.read_text().replace("2500 0 1e10", "2600 0 1e10"))):
        change()
        cost(tmp_path / "out", *given)
        count.append(len(list((tmp_path / "out" / "turns" / "runs").glob("*.json"))))
    assert count[0] == count[1] and count[2] == 2 * count[0] and count[3] == 3 * count[0]


@pytest.mark.parametrize("model", ["dda", "nmm"])
def test_errors_do_not_depend_on_the_units(model, tmp_path):
    """A block that slides, of 1 mm and of 1 km: E as the size, times as its root. What is left is rounding of coordinates."""
    errors = []
    for size in (1e-3, 1e3):
        folder = tmp_path / f"{size:g}"
        folder.mkdir()
        base, block = (block_files.turned(size * corners, -math.pi / 6)
                       for corners in (block_files.box(-5, 10, -1, 0), block_files.box(0, 1, 0, 1)))
        text = block_files.block_file("slides", [(1, base), (2, block)], block_files.held(base, 1), measured=[(*block.mean(0), 2)])
        (folder / "slides.blk").write_text(text)
        rock = f"{1e10 * size} 0.25 0 0 0 0 0 0 0 0 0"
        mesh = f"&method model='nmm' /\n&cover edge={0.8 * size} /\n" if model == "nmm" else ""
        (folder / "slides.ana").write_text(f"1 50 2 1 0.05 {0.01 * math.sqrt(size)}\n2500 0 {rock}\n2500 24525 {rock}\n17 0 0\n"
                                           f"&deck geometry='slides.blk', dialect='short' /\n{mesh}")
        _, rows = cost(folder, folder / "slides.ana", "--strains", "deck", "green", "--integrators", "deck", "--contacts", "deck",
                       "--tolerances", "deck", "--steps", 4, 2, "--rounds", 1, "--quantity", "displacement", "rotation")
        errors.append([row[key] for row in rows["slides"] for key in ("error: displacement", "error: rotation")])
    assert len(errors[0]) == 8 and errors[0] == pytest.approx(errors[1], rel=1e-3, abs=1e-8)


def test_comparators_are_ways_where_they_are_asked_for(tmp_path):
    """Cures of small strain, generalized-alpha, Bathe's composite and central differences; what a scene cannot take is left out."""
    _, rows = cost(tmp_path, "pendulum", "corner-drop", "--strains", "small", "trigonometric", "strain_rotation", "green", "--integrators",
                   "deck", "alpha-0.5", "bathe", "central", "--steps", "1", "0.5", "--contacts", "deck", "--tolerances", "deck", "--rounds", "1")
    ways = {(row["strain"], row["integrator"].split()[0]) for row in rows["pendulum"]}
    assert {(strain, scheme) for strain in ("small", "trigonometric", "green") for scheme in ("generalized_alpha", "bathe", "central_difference")} < ways
    error = {(row["strain"], row["integrator"].split()[0], row["step"]): row["error: area"] for row in rows["pendulum"]}
    finest = min(step for *_, step in error)
    assert {("strain_rotation", scheme) for scheme in ("newmark", "generalized_alpha", "bathe")} < ways
    assert ("strain_rotation", "central_difference") not in ways
    assert error["trigonometric", "newmark", finest] < 1e-4 * error["small", "newmark", finest]
    assert {row["integrator"].split()[0] for row in rows["corner-drop"]} == {"newmark", "energy_decaying"}  # they have no restitution


def test_runs_by_accuracy_say_what_was_asked_beside_what_is_true(tmp_path):
    _, rows = cost(tmp_path, "triangle", "--strains", "green", "--accuracies", "1e-2", "1e-3", "--integrators", "deck", "--steps", "4",
                   "--contacts", "deck", "--tolerances", "deck", "--rounds", "1")
    found = {row["accuracy"]: row for row in rows["triangle"] if row["accuracy"]}
    assert sorted(found) == ["0.001", "0.01"]
    for asked, row in found.items():
        share = row["error: angle"] * math.pi  # of the angle, over the chord of half a turn
        assert share < 3 * float(asked) and share / 3 < row["estimate"] < 3 * share
    assert found["0.001"]["steps"] > found["0.01"]["steps"]
