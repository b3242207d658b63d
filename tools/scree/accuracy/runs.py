"""Runs scenes in many ways. What a run gives and takes is kept in a file of its own, so that a study that was stopped goes on."""
import concurrent.futures
import dataclasses
import json
import pathlib
import re
import tempfile

import numpy as np

from ..bench.effects import Counter
from ..bench.processes import start
from ..errors import RunFailed, ScreeError
from ..program import made_folder, with_settings
from ..records import Bar, explain, files_of, hashed, replace, stopped_at_once
from ..results import read
from . import scenes
from .choices import Choice, DECK

BAD_INPUT = 2           # exit status
LONG = 10.0             # seconds of a run after which it is not repeated
FRAMES = ["output.every=999999999"]  # the first and the last
FINER = (2.0, 1.0, 0.5, 0.25)  # steps of the reference over the smallest of the grid
REFERENCES = (("green", DECK), ("green", "newmark-half"))  # strain and integrator of runs that a reference is extrapolated from


@dataclasses.dataclass
class Run:
    """A run of a scene: its choice, decks and settings, and what these came to (`asked`).

    `key` is that of its program, decks and settings; `method` is the same for runs that differ in the step alone.
    """

    scene: scenes.Scene
    choice: Choice
    decks: list
    settings: list
    asked: dict
    key: str
    method: str
    record: pathlib.Path
    extra: bool = False  # for the reference alone

    @property
    def step(self):
        return self.choice.step * self.scene.size

    def words(self, output):
        return ["run", *self.decks, "-o", output, "--quiet", *with_settings(self.settings)]


class Study:
    """All runs of a scene by a program: their decks in a folder, what is kept of them in another."""

    def __init__(self, scene, choices, settings, decks, kept, path):
        self.scene, self.path, self.settings = scene, path, settings
        self.decks, self.kept = made_folder(decks / scene.name), made_folder(kept / scene.name / "runs")
        self.program = hashed(path.read_bytes())
        decks, given = self.write(Choice())
        self.base = explain(decks, given, path)
        self.default = self.made(Choice()).method
        self.runs = self.of(choices)
        self.runs += self.of(self.reference_choices(), extra=True, but={run.key for run in self.runs})

    def write(self, choice):
        """Decks and settings of a choice, but for what depends on the settings of the deck."""
        decks, of_mesh = self.scene.write(self.decks, 1.0 if choice.mesh == DECK else float(choice.mesh))
        return decks, [*self.settings, *of_mesh, *FRAMES, f"step.end_time={self.scene.end}"]

    def made(self, choice, extra=False):
        """The run of a choice; RunFailed where the program refuses it."""
        decks, settings = self.write(choice)
        settings = [*settings, *choice.settings(self.base, self.scene.size)]
        asked = explain(decks, settings, self.path)
        files = files_of(decks, asked)
        kept = sorted((name, value) for name, value in asked.items() if name != "deck.geometry")
        method = hashed(*files, [row for row in kept if not row[0].startswith("step.") or row[0] == "step.accuracy"])
        key = hashed(self.program, *files, kept)
        return Run(self.scene, choice, decks, settings, asked, key, method, self.kept / f"{key}.json", extra)

    def of(self, choices, extra=False, but=()):
        """The runs of choices, without those that contradict themselves and those that another one is already."""
        found, keys = [], set(but)
        for choice in choices:
            try:
                run = self.made(choice, extra)
            except RunFailed as refused:
                if refused.status == BAD_INPUT and "--set" in refused.said:
                    continue
                raise
            if run.key not in keys:
                keys.add(run.key)
                found.append(run)
        return found

    def needs_reference(self):
        return any(quantity.exact is None for quantity in self.scene.quantities.values())

    def reference_choices(self):
        """Runs that a reference is extrapolated from: finer steps, on the finest mesh, and the meshes before it."""
        if not self.needs_reference():
            return []
        steps = sorted(self.scene.axes["step"])
        finest, *coarser = sorted(1.0 if mesh == DECK else float(mesh) for mesh in self.scene.axes["mesh"])
        choices = []
        for strain, integrator in REFERENCES:
            choices += [Choice(strain, integrator, mesh=f"{finest:g}", step=factor * steps[0]) for factor in FINER]
            choices += [Choice(strain, integrator, mesh=f"{mesh:g}", step=steps[0]) for mesh in coarser]
        return choices


def measure(run, path, limit):
    """What a run gives, and the seconds that its steps take."""
    with tempfile.TemporaryDirectory() as folder:
        output = pathlib.Path(folder) / "r.h5"
        done = start(path, *run.words(output), limit=limit)
        said = (done.said.splitlines() or [""])[-1].removeprefix("scree: ")
        if not output.exists():
            return {"ended": said or f"exit status {done.status}"}
        r = read(output)
        history = r.history
        ended = r.scene.status
        if ended.startswith("not in equilibrium"):
            ended = "complete"  # it took the load steps that it was asked for; how far off that is, is what is measured
        found = {"ended": ended, "steps": len(history.time), "solves": int(history.solves.sum()),
                 "cuts": int(history.rejected.sum()), "megabytes": done.megabytes}
        if ended == "interrupted" and done.seconds < limit:
            raise ScreeError("a run was stopped by a signal")
        if ended != "complete":
            return {**found, "ended": f"stopped after {limit:g} s" if ended == "interrupted" else said or ended}
        closed = history.contacts[:, 1:].sum(1) if "contacts" in history else np.zeros(1)
        values = {name: np.atleast_1d(np.asarray(quantity.measure(r), float)).ravel().tolist()
                  for name, quantity in run.scene.quantities.items()}
        if "error" in history:
            found["estimate"] = float(history.error.share[-1])
        return {**found, "seconds": r.seconds("steps", "processor"), "values": values,
                "impacts": "contact.restitution" in run.asked or bool((np.diff(closed) > 0).any())}


def recorded(run):
    """What is kept of a run; empty where there is nothing, or not all that is asked for."""
    try:
        found = json.loads(run.record.read_text())
    except (OSError, ValueError):
        return {}
    return found if found["ended"] != "complete" or set(found["values"]) >= set(run.scene.quantities) else {}


def keep(run, found):
    """Replaces the record of a run, whole or not at all."""
    replace(run.record, json.dumps(found))


def do(run, path, limit):
    """A run once more: its seconds join those of the rounds before."""
    before, found = recorded(run), measure(run, path, limit)
    if "seconds" in found:
        earlier = before["seconds"] if before.get("ended") == "complete" else []
        found["seconds"] = [*earlier, found["seconds"]]
    keep(run, {**before, **found})


def count(run, counter):
    """Adds the instructions of the steps to the record of a run."""
    with tempfile.TemporaryDirectory() as folder:
        keep(run, {**recorded(run), "instructions": counter.instructions(run.words(pathlib.Path(folder) / "r.h5"))})


def to_do(runs, rounds, limit, instructions):
    """Lists of what is left, one a round: each takes all runs, so that what disturbs one round disturbs none of them alone.

    What was stopped is left where it has more time now.
    """
    for number in range(1, rounds + 1):
        left = []
        for run in runs:
            found = recorded(run)
            times = found.get("seconds", [])
            stopped = re.match(r"stopped after (\S+) s", found.get("ended", ""))
            more_time = stopped and float(stopped[1]) < limit
            if not found or more_time or (found["ended"] == "complete" and len(times) < number and max(times, default=0) < LONG):
                left.append(run)
        if number > 1:
            left = [run for run in left if not run.extra]
        yield do, left
    if instructions:
        yield count, [run for run in runs if not run.extra and recorded(run).get("ended") == "complete"
                      and "instructions" not in recorded(run)]


def run_all(studies, path, rounds, jobs, limit, instructions=False):
    """Makes all runs that are not made yet, so many at a time, and says how far it is."""
    runs = [run for study in studies for run in study.runs]
    counter = Counter(path)
    for number, (work, left) in enumerate(to_do(runs, rounds, limit, instructions and counter.valgrind), 1):
        bar = Bar(f"round {number} of {rounds}" if work is do else "instructions", len(left))
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            waiting = {pool.submit(work, run, *((path, limit) if work is do else (counter,))): run for run in left}
            with stopped_at_once(pool):
                for done in concurrent.futures.as_completed(waiting):
                    done.result()
                    bar.advance(waiting[done].scene.name)
        bar.end()
