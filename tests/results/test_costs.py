"""What a run says that it cost: phases that make up the whole, begun as often as its steps say."""
import os
import pathlib
import time

import pytest
from scree import call, read, touching
from scree.bench import effects, scenes

SOURCE = pathlib.Path(os.environ["SCREE_SOURCE"])
CLASSIC = SOURCE / "tests" / "data" / "classic"
PROBLEMS = "output.problems=all"

# Decks and settings of runs that take up to a second, and phases that they have beside those that all have.
SCENES = {
    "a block that falls": (lambda folder: ([CLASSIC / "freefall.geo", CLASSIC / "freefall.ana"],
                                           ["step.count=5000", "step.end_time=1000"]), {"alone"}),
    "a mesh": (lambda folder: ([touching.jointed_rock(folder, "nmm", 3, 20)], []), {"assemble", "solve", "factor", "judge", "friction", "sleep"}),
    "a wall": (lambda folder: ([CLASSIC / "wall100.geo", CLASSIC / "wall100.ana"], ["step.count=30"]),
               {"assemble", "solve", "factor", "judge", "friction", "sleep"}),
    "a wall by Shi's rules": (lambda folder: ([CLASSIC / "wall100.geo", CLASSIC / "wall100.ana"], ["method.preset=shi", "step.count=30"]),
                              {"assemble", "solve", "factor", "judge"}),
    "random rock": (lambda folder: ([touching.jointed_rock(folder, "dda, Green strain", 3, 8)], []),
                    {"assemble", "solve", "factor", "judge", "friction", "sleep"}),
    "impacts": (lambda folder: ([SOURCE / "input/paper/arc/arc.ana"], ["contact.restitution=0.5", "step.size=2e-3"]),
                {"alone", "assemble", "solve", "factor", "judge", "friction", "restitution", "sleep"}),  # circles in one step
    "blocks that fall asleep": (lambda folder: (effects.on_ground(3, 2, 60.0).with_more(velocity=(20.0, 0.0, 0.0)).write(folder, "x"),
                                                ["step.sleep=1e-3", "step.end_time=5"]),
                                {"assemble", "solve", "judge", "sleep"}),
}
OF_ALL = {"read", "set-up", "search", "check", "update", "history", "frames", "other"}


@pytest.fixture(scope="module", params=SCENES)
def run(request, tmp_path_factory):
    """Results, the phases that its scene has beside those of all, the seconds that the process took."""
    folder = tmp_path_factory.mktemp("costs")
    make, phases = SCENES[request.param]
    decks, settings = make(folder)
    words = [word for setting in [*settings, PROBLEMS] for word in ("--set", setting)]
    begun = time.perf_counter()
    done = call("run", *decks, *words, "-o", folder / "r.h5", "--quiet", timeout=120)
    taken = time.perf_counter() - begun
    assert done.returncode == 0, done.stderr
    return read(folder / "r.h5"), phases, taken


def calls(r):
    return dict(zip(r.cost.phase, r.cost.calls.tolist()))


def test_phases_are_those_that_the_scene_has(run):
    r, phases, _ = run
    assert set(r.cost.phase) - {"alone"} == OF_ALL | phases - {"alone"}  # what is alone for some steps is no matter
    assert "alone" in r.cost.phase or "alone" not in phases
    assert len(set(r.cost.phase)) == len(r.cost.phase)


def test_times_add_up_to_the_whole(run):
    r, _, taken = run
    wall, share = r.cost.wall_seconds, r.cost.share
    assert share.sum() == pytest.approx(1, abs=1e-12) and share == pytest.approx(wall / wall.sum(), abs=1e-12)
    assert (wall >= 0).all() and (r.cost.processor_seconds >= 0).all()
    assert 0 < wall.sum() < taken
    steps = [phase for phase in r.cost.phase if phase not in ("read", "set-up", "history", "frames", "other")]
    assert r.seconds("steps") == pytest.approx(sum(r.seconds(phase) for phase in steps), rel=1e-12)


def test_calls_are_those_of_the_steps(run):
    r, phases, _ = run
    n, history = calls(r), r.history
    steps = len(history.time)
    assert n["read"] == n["set-up"] == 1
    assert n["update"] == n["history"] == steps and n["frames"] == r.n_frames + 1  # and what waits at the end
    assert n["search"] >= steps + history.rejected.sum()  # and where a try was to look farther
    if "judge" in phases and "open_close_iterations" in history:
        assert n["judge"] >= history.open_close_iterations.sum()
    assert n.get("friction", 0) == (len(list(r.problems)) if "problems" in r else 0)


def test_factors_are_those_of_the_work_and_the_history(run, request):
    r, _, _ = run
    n, work = calls(r), dict(zip(r.cost.work, r.cost["count"].tolist()))
    factors, solves = work["factors by CHOLMOD"] + work["factors by LU"], r.history.solves.sum()
    of_problems = n.get("factor", 0) - factors
    if "friction" not in n:
        assert of_problems == 0
    if "alone" not in n:
        # a solution is of the equations, or one of the matrices of a friction problem, some of which are factorised twice
        assert 0 <= solves - n["solve"] <= of_problems
        assert (solves == n["solve"]) == (of_problems == 0)
    if "Shi" in request.node.name:
        assert n["factor"] >= n["solve"] == solves  # all are factorised
