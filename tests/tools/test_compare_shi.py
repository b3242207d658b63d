"""tools/compare_shi: runs against those of a derivative of Shi's program (tests/data/classic/runs); it sees what differs."""
import collections
import csv
import os
import pathlib
import re
import shutil
import subprocess
import tracemalloc

import h5py
import numpy as np
import pytest
import scree
from scree import compare_shi

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
DATA = SOURCE / "tests" / "data" / "classic"
ROUNDING = "1e-9"  # the references have 15 digits and 200 steps of roundings; measured 2e-13
CLOSE = "1e-7"     # where bodies touch; measured 3e-9. Vertices off by 1e-12 move the reference itself by 2e-7 (doc/results.md)
E = "1e6"          # stress scale of what is free of stress: strains agree to ROUNDING

Case = collections.namedtuple("Case", "reference geometry analysis settings compare")
CASES = [  # a run of the program as it is now with preset='shi': a line more is a case more
    Case("freefall", "freefall", "freefall", ["step.end_time=0.5"], ["--tolerance", ROUNDING, "--stress-scale", E]),
    Case("spin_w1", "spin", "spin_w1", [], ["--tolerance", ROUNDING, "--stress-scale", E]),
    Case("spin_w10", "spin", "spin_w10", [], ["--tolerance", ROUNDING, "--stress-scale", E]),
    Case("spin_w10_exact", "spin", "spin_w10", ["method.rotation=exact"], ["--tolerance", ROUNDING, "--stress-scale", E]),
    *(Case(name, name.split("_")[0], name, [], ["--tolerance", CLOSE, "--contacts", "0"])
      for name in ("incline30_p0", "incline30_p10", "incline30_p20", "incline30_p35", "incline30_c5", "stack5_dyn", "stack5_sta",
                   "wall100", "corners")),
    Case("topple_pf1", "topple", "topple", ["contact.stiffness=1e6"], ["--tolerance", CLOSE, "--contacts", "0"]),
    Case("topple_pf50", "topple", "topple", [], ["--tolerance", CLOSE, "--contacts", "0"]),
    Case("circleslope", "circleslope", "circleslope", ["step.control=shi", "contact.adapt=shi"],
         ["--tolerance", "1e-5", "--contacts", "0"]),  # one of its sizes differs by 4e-6 (doc/results.md)
]


def run(geometry, analysis, out, *settings, words=()):
    scree.run(DATA / f"{geometry}.geo", DATA / f"{analysis}.ana", output=out, words=words,
              settings=["method.preset=shi", "output.every=1", *settings])
    return out


def compare(*words):
    return subprocess.run([SOURCE / "tools" / "compare_shi", *words], capture_output=True, text=True)


def table(printed):
    """From block to its six numbers, NaN for '-', and to what stands behind them."""
    rows = {}
    for line in printed.splitlines():
        found = re.match(r" *(\d+)((?:  +[-+.e\d]+){6})  (.*)$", line)
        if found:
            rows[int(found[1])] = ([float(w) if w != "-" else float("nan") for w in found[2].split()], found[3])
    return rows


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.reference)
def test_a_run_is_that_of_shis_program(case, tmp_path):
    out = run(case.geometry, case.analysis, tmp_path / "x.h5", *case.settings)
    done = compare(out, DATA / "runs" / case.reference, *case.compare)
    assert done.returncode == 0, done.stdout + done.stderr
    assert table(done.stdout) and all(begins == "-" for _, begins in table(done.stdout).values())


@pytest.mark.parametrize("analysis, angle", [("spin_w1", 0.01), ("spin_w10", 0.1)])
def test_the_area_of_a_spinning_block_grows_as_the_formula_says(analysis, angle, tmp_path):
    """By 1 + angle^2 a step, in the run and in the reference."""
    area = scree.read(run("spin", analysis, tmp_path / "x.h5")).bodies.area[:, 0]
    np.testing.assert_allclose(area, 2 * (1 + angle**2) ** np.arange(201), rtol=1e-9)
    rows = list(csv.DictReader((DATA / "runs" / analysis / "blocks.csv").open()))
    area, steps = np.array([[float(row["area"]), float(row["step"])] for row in rows]).T
    np.testing.assert_allclose(area, 2 * (1 + angle**2) ** steps, rtol=1e-9)


def test_another_rotation_is_seen_in_its_first_step(tmp_path):
    """Linear, and by cos and sin: the two part at once, by 1 % of the area."""
    done = compare(run("spin", "spin_w10", tmp_path / "x.h5"), DATA / "runs" / "spin_w10_exact", "--stress-scale", E)
    assert done.returncode == 1 and table(done.stdout)[1][1] == "step 1, time 0.01: place, area"


@pytest.fixture(scope="module")
def stack(tmp_path_factory):
    """Five blocks on a sixth for ten steps, with the classic output."""
    return run("stack5", "stack5_dyn", tmp_path_factory.mktemp("stack") / "s.h5", "step.end_time=0.05", words=["--classic-output"])


def test_the_classic_output_read_back_is_the_run(stack):
    done = compare(stack, stack.with_suffix(".replay"))
    rows = table(done.stdout)
    assert done.returncode == 0 and len(rows) == 6 and done.stdout.startswith("11 of 11 frames"), done.stdout
    for numbers, _ in rows.values():
        assert numbers[1] == 0  # of vertices every digit
        assert numbers[0] < 1e-14 and numbers[3] < 1e-14  # centroid and area are worked out anew
    assert "measured points: 0.00e+00" in done.stdout


def test_elements_of_a_manifold_are_compared_as_polygons(tmp_path):
    out = run("freefall", "freefall", tmp_path / "m.h5", "method.model=nmm", "cover.edge=0.4", "step.end_time=0.05",
              words=["--classic-output"])
    done = compare(out, out.with_suffix(".replay"))
    rows = table(done.stdout)
    assert done.returncode == 0 and len(rows) > 10 and all(numbers[1] == 0 for numbers, _ in rows.values()), done.stdout
    done = compare(out, DATA / "runs" / "freefall", "--stress-scale", E)  # the centroid of the block; and it ends at a tenth
    assert done.returncode == 1 and "centroids alone" in done.stdout and "the run ends before the reference" in done.stdout
    assert table(done.stdout)[1][1] == "-"


def replay_with(path, out, frame, row, by):
    """The replay with x of a vertex row of a frame moved."""
    lines = path.read_text().splitlines()
    n, n_blocks, _, oo = map(int, lines[0].split())
    n_points = sum(map(int, lines[1].split()))
    at = 3 + n_blocks + frame * (oo + n_points + 2) + row
    joint, x, y = lines[at].split()
    lines[at] = f"{joint} {float(x) + by} {y}"
    out.write_text("\n".join(lines) + "\n")
    return out


@pytest.mark.parametrize("frame, block", [(1, 1), (6, 4), (10, 6)])
def test_a_vertex_that_is_off_is_found_in_its_block_at_its_step(frame, block, stack, tmp_path):
    off = replay_with(stack.with_suffix(".replay"), tmp_path / "off.replay", frame, 8 * (block - 1) + 3, 1e-3)
    done = compare(stack, off, "--tolerance", "1e-3")
    assert done.returncode == 1, done.stdout
    for b, (numbers, begins) in table(done.stdout).items():
        if b != block:
            assert begins == "-"
        else:  # the travel is 0.0125
            assert numbers[1] == pytest.approx(1e-3) and begins == f"step {frame}, time {0.005 * frame:g}: place"
    assert compare(stack, off, "--tolerance", "1e-3", "--length-scale", "2").returncode == 0


def folder_with(source, out, name, step, block, column, value):
    shutil.copytree(source, out)
    rows = list(csv.DictReader((source / f"{name}.csv").open()))
    for row in rows:
        if row["step"] == str(step) and row.get("block", "1") == str(block):
            row[column] = value
    with (out / f"{name}.csv").open("w", newline="") as f:
        table = csv.DictWriter(f, rows[0])
        table.writeheader()
        table.writerows(rows)
    return out


@pytest.fixture(scope="module")
def fall(tmp_path_factory):
    return run("freefall", "freefall", tmp_path_factory.mktemp("fall") / "f.h5", "step.end_time=0.5",
               words=["--classic-output"])


@pytest.mark.parametrize("name, column, value, expected", [
    ("blocks", "syy", "5", "stress"), ("blocks", "area", "1.0001", "area"), ("blocks", "cx", "0.51", "place"),
    ("vertices", "x", "0.9", "place")])
def test_a_number_that_is_off_in_a_table_is_found_at_its_step(name, column, value, expected, fall, tmp_path):
    off = folder_with(DATA / "runs" / "freefall", tmp_path / "off", name, 17, 1, column, value)
    for words in ([], ["--match", "time"]):
        done = compare(fall, off, *words)
        assert done.returncode == 1 and table(done.stdout)[1][1] == f"step 17, time 0.17: {expected}", done.stdout


def test_times_match_where_steps_do_not(tmp_path):
    """Half the step: the places of a free fall are the same, at twice the step."""
    out = run("freefall", "freefall", tmp_path / "half.h5", "step.end_time=0.5", "step.size=0.005")
    assert compare(out, DATA / "runs" / "freefall", "--match", "time").returncode == 0
    done = compare(out, DATA / "runs" / "freefall")
    assert done.returncode == 1 and table(done.stdout)[1][1].startswith("step 1, ")
    assert "times differ by at most 2.50e-01" in done.stdout


@pytest.mark.parametrize("frames", [1, 2, 3000])
def test_the_nearest_time_is_found_without_a_table_of_all_pairs(frames):
    """Between times, at them, before and after all; a table of 3000 by 3500 numbers takes 84 MB."""
    chance = np.random.default_rng(frames)
    times = np.cumsum(chance.random(frames))
    values = np.concatenate([chance.random(500) * (times[-1] + 2) - 1, times])
    tracemalloc.start()
    found = compare_shi.nearest(times, values)
    assert tracemalloc.get_traced_memory()[1] < 1e6
    tracemalloc.stop()
    assert all(place == np.abs(times - value).argmin() for place, value in zip(found, values))


def test_frames_of_a_replay_may_be_steps_apart(stack, tmp_path):
    out = run("stack5", "stack5_dyn", tmp_path / "s.h5", "step.end_time=0.05", "output.every=5", words=["--classic-output"])
    done = compare(stack, out.with_suffix(".replay"), "--every", "5")
    assert done.returncode == 0 and done.stdout.startswith("3 of 3 frames of the reference, to step 10"), done.stdout
    assert compare(stack, out.with_suffix(".replay")).returncode == 1


def test_numbers_of_contacts_are_compared_where_both_have_them(fall, tmp_path):
    reference = DATA / "runs" / "freefall"
    own = tmp_path / "x.h5"
    shutil.copy(fall, own)
    with h5py.File(own, "a") as f:
        f["history"].pop("contacts", None)
    assert "contacts: the run has none to compare" in compare(own, reference).stdout
    with h5py.File(own, "a") as f:
        f["history/contacts"] = np.zeros((50, 3), int)  # open, sliding, locked
    done = compare(own, reference, "--contacts", "0")
    assert done.returncode == 0 and "contacts: closed differ at 0 of 50 steps" in done.stdout
    with h5py.File(own, "a") as f:
        f["history/contacts"][6] = [4, 1, 2]
        f["history/contacts"][8] = [0, 0, 1]
    done = compare(own, reference, "--contacts", "2")
    assert done.returncode == 1
    for kind, steps, most in (("open", 1, 4), ("closed", 2, 3)):
        assert (f"contacts: {kind} differ at {steps} of 50 steps, first at step 7; most at step 7: {most} in the run, "
                "0 in the reference") in done.stdout
    assert compare(own, reference, "--contacts", "3").returncode == compare(own, reference).returncode == 0
    assert "contacts: the reference has none to compare" in compare(own, fall.with_suffix(".replay")).stdout


def test_a_stack_comes_to_rest_with_the_same_load_in_it(tmp_path):
    """What carries the weight of those above."""
    stress = scree.read(run("stack5", "stack5_dyn", tmp_path / "x.h5", "output.every=2000")).bodies.stress[-1, :, 1]
    rows = [row for row in csv.DictReader((DATA / "runs" / "stack5_dyn" / "blocks.csv").open()) if row["step"] == "2000"]
    np.testing.assert_allclose(stress, [float(row["syy"]) for row in rows], atol=1e-5)
    np.testing.assert_allclose(stress[1:], [-117, -91, -65, -39, -13], atol=0.01)


@pytest.mark.parametrize("stiffness", ["1e6", "5e7"])
def test_a_block_topples_whatever_the_stiffness_but_for_the_tolerances_of_shi(stiffness, tmp_path):
    """5e7 times the gap at which a contact opens for Shi is more than the block weighs, and holds it."""
    angle = {}
    for preset in ("none", "shi"):
        r = scree.read(run("topple", "topple", tmp_path / "x.h5", f"contact.stiffness={stiffness}", f"method.preset={preset}",
                           "method.strain=small"))
        angle[preset] = r.history.rotation[-1, 1]
    assert angle["none"] == pytest.approx(-1.4803, abs=2e-4)
    assert angle["shi"] == pytest.approx(-1.4812 if stiffness == "1e6" else 0, abs=1e-4)


def test_the_steps_of_circleslope_are_those_of_shis_program(tmp_path):
    """Chosen sizes, cuts and solves, to the digits that are told: a step that is cut goes on from the states it was left in."""
    history = scree.read(run("circleslope", "circleslope", tmp_path / "x.h5", "step.control=shi", "contact.adapt=shi")).history
    size, solves, rejected = history.step_size, history.solves, history.rejected
    rows = list(csv.DictReader((DATA / "runs" / "circleslope" / "steps.csv").open()))[1:]
    assert list(solves) == [int(row["oc_iters"]) for row in rows] and list(rejected) == [int(row["cuts"]) for row in rows]
    reference = np.array([float(row["dt"]) for row in rows])
    np.testing.assert_allclose(size[:16], reference[:16], rtol=1e-8)
    np.testing.assert_allclose(size[16:], reference[16:], rtol=1e-5)


def test_no_reference_is_left_out():
    folders = {path.name for path in (DATA / "runs").iterdir() if path.is_dir()}
    assert folders == {case.reference for case in CASES}


def test_what_is_wrong_is_said_in_one_line(stack, fall, tmp_path):
    reference = DATA / "runs" / "freefall"
    replay = stack.with_suffix(".replay")
    (tmp_path / "text.replay").write_text("no replay")
    (tmp_path / "cut.replay").write_text(replay.read_text()[:20000])
    (tmp_path / "bolts.replay").write_text(replay.read_text().replace(" 6 0 48", " 6 1 48", 1))
    (tmp_path / "empty").mkdir()
    less = folder_with(reference, tmp_path / "less", "blocks", 3, 1, "cx", "")
    (tmp_path / "head").mkdir()
    (tmp_path / "head" / "blocks.csv").write_text("step,time\n0,0\n")
    corner = folder_with(reference, tmp_path / "corner", "vertices", 0, 1, "x", "0")
    rows = (corner / "vertices.csv").read_text().splitlines()
    (corner / "vertices.csv").write_text("\n".join(row for row in rows if row.split(",")[3] != "4") + "\n")
    with h5py.File(tmp_path / "other.h5", "w") as f:
        f["x"] = 1
    coarse = run("freefall", "freefall", tmp_path / "coarse.h5", "output.every=70")
    for words, expected in (
            ([fall, tmp_path / "none"], "expected a replay, found"), ([fall, tmp_path / "text.replay"], "expected a replay, found"),
            ([stack, tmp_path / "cut.replay"], "numbers of 11 frames"), ([stack, tmp_path / "bolts.replay"], "expected no bolts"),
            ([fall, tmp_path / "empty"], "blocks.csv"), ([fall, less], "row 4 after the head"),
            ([fall, tmp_path / "head"], "expected the columns step time block"), ([fall, corner], "expected 4 vertices of block 1"),
            ([stack, reference], "expected 6 blocks"), ([tmp_path / "other.h5", reference], "another HDF5 file"),
            ([tmp_path / "none.h5", reference], "expected a results file"), ([replay, reference], "expected a results file"),
            ([coarse, reference], "output.every=1"), ([stack, replay, "--match", "time"], "expected times"),
            ([fall, reference, "--tolerance", "0"], "--tolerance: expected a number above 0, found '0'"),
            ([stack, replay, "--every", "0"], "--every: expected a whole number from 1, found '0'"), ([fall], "REFERENCE")):
        done = compare(*words)
        assert done.returncode == 2 and len(done.stderr.splitlines()) == 1 and expected in done.stderr, (words, done.stderr)
        assert done.stderr.startswith("tools/compare_shi: ") and not done.stdout
