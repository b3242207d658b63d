"""The runs of a study: made where their records are missing, a file each, so that a study that was killed goes on."""
import concurrent.futures
import contextlib
import json
import os
import subprocess
import threading
import time

import numpy as np

from ..errors import ScreeError
from ..program import made_folder, program, with_settings
from ..records import Bar, dimensions, explain, files_of, hashed, names_a_file, replace, stopped_at_once
from ..results import read
from ..units import ENERGY

ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_THREAD_LIMIT": "1"}  # where as many runs as processors go on at once
DONE, FAILED, BAD_INPUT = 0, 1, 2  # exit statuses of a run that came to something

# Columns of the table of a study, from what `--summary json` prints (doc/results.md); places are two columns.
SUMMARY = ("time.reached", "steps.taken", "steps.cut", "displacement.largest", "displacement.block", "displacement.position",
           "speed.largest", "at_rest", "energy.given", "energy.friction", "energy.share_lost", "change_of_area", "overlap.largest",
           "warnings")
PLACES = ("displacement.position",)
DIMENSIONS = {"time.reached": "time", "displacement.largest": "length", "displacement.position.x": "length",
              "displacement.position.y": "length", "speed.largest": "length/time", "energy.given": ENERGY, "energy.friction": ENERGY,
              "overlap.largest": "length"}  # of these columns; others have none


class Study:
    """The runs of a table: number, settings and the key of their records, which is that of program, decks and settings."""

    def __init__(self, table, decks, settings, folder, path=None, keeps_results=False):
        self.table, self.decks, self.path = table, decks, program(path)
        self.settings, self.folder, self.keeps = [*table.settings, *settings], folder, keeps_results
        made_folder(folder / "runs")
        explain(decks, self.settings_of(table.rows[0]), self.path)  # a name or a deck that is wrong is said before any run
        self.lock, self.going, self.stopping = threading.Lock(), set(), False
        self.keys = self.all_keys()

    def settings_of(self, row):
        return [*self.settings, *(f"{name}={value}" for name, value in zip(self.table.names, row))]

    def all_keys(self):
        """The key of each run. Files are looked at once, unless the table names them."""
        names_files = any(names_a_file(name) for name in self.table.names)
        program_key, quantities = hashed(self.path.read_bytes()), sorted(self.table.quantities.items())
        keys, files = [], None
        for row in self.table.rows:
            if files is None or names_files:
                files = hashed(*files_of(self.decks, explain(self.decks, self.settings_of(row), self.path)))
            keys.append(hashed(program_key, files, self.settings_of(row), quantities))
        return keys

    def record_path(self, number):
        return self.folder / "runs" / f"{self.keys[number]}.json"

    def results_path(self, number):
        return self.record_path(number).with_suffix(".h5")

    def record(self, number):
        """What is kept of a run; None where it is to be made."""
        try:
            found = json.loads(self.record_path(number).read_text())
        except (OSError, ValueError):
            return None
        return None if self.keeps and "quantities" in found and not self.results_path(number).exists() else found

    def make(self, number):
        """Makes a run and keeps what it came to; of one that was stopped nothing is kept."""
        partial = self.folder / "runs" / f"{self.keys[number]}-{os.getpid()}.h5"
        try:
            words = [self.path, "run", *self.decks, "-o", partial, "--quiet", "--summary", "json",
                     *with_settings(self.settings_of(self.table.rows[number]))]
            begun = time.perf_counter()
            status, printed, said = self.call(words)
            seconds = time.perf_counter() - begun
            if status not in (DONE, FAILED, BAD_INPUT):
                return False
            summary = json.loads(printed) if printed.strip() else None
            found = {"status": summary["status"] if status == DONE else last_line(said), "seconds": seconds, "summary": summary}
            if status == DONE:
                found["quantities"] = {name: self.measured(partial, name) for name in self.table.quantities}
                found["units"] = self.units_in(partial)
            if self.keeps and partial.exists():
                partial.replace(self.results_path(number))
            replace(self.record_path(number), json.dumps(found))
            return True
        finally:
            partial.unlink(missing_ok=True)

    def call(self, words):
        """Exit status and what a process printed, until it ends or the study is stopped."""
        with self.lock:
            if self.stopping:
                return -1, "", ""
            process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                       env=ONE_THREAD | os.environ)
            self.going.add(process)
        try:
            printed, said = process.communicate()
        finally:
            self.going.discard(process)
        return process.returncode, printed, said

    def stop(self):
        """Ends the runs that go on."""
        with self.lock:
            self.stopping = True
        for process in list(self.going):
            process.terminate()

    def measured(self, path, name):
        """A quantity of the results of a run."""
        dataset, *index = self.table.quantities[name]
        try:
            value = np.asarray(read(path)[dataset], float)[tuple(index)]
            return float(value)
        except (KeyError, IndexError, TypeError, ValueError) as problem:
            raise ScreeError(f"quantity {name}: expected a dataset of the results and the place of one number in it, found "
                             f"{[dataset, *index]}: {str(problem.args[0]).removeprefix(f'{path}: ')}") from None

    def units_in(self, path):
        """The dimensions of quantities that have one, by their names."""
        units, results = {}, read(path)
        for name, (dataset, *_) in self.table.quantities.items():
            with contextlib.suppress(KeyError):  # as numbers of blocks
                units[name] = results.units(dataset)
        return units

    def run(self, numbers, jobs):
        """Makes those of the runs that are not there, so many at once. Returns how many it made, and how many ended by a signal."""
        left = [number for number in numbers if self.record(number) is None]
        bar, made = Bar("study", len(left)), 0
        with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
            waiting = {pool.submit(self.make, number): number for number in left}
            with stopped_at_once(pool):
                try:
                    for done in concurrent.futures.as_completed(waiting):
                        made += done.result()
                        bar.advance(f"run {waiting[done] + 1}")
                except BaseException:
                    self.stop()
                    raise
        bar.end()
        self.clear()
        return made, len(left) - made

    def clear(self):
        """Takes away what runs left that were killed or went on without their study, and have been made since."""
        for left in (self.folder / "runs").glob("*-*.h5"):
            if left.with_name(f"{left.name.split('-')[0]}.json").exists():
                left.unlink(missing_ok=True)

    def header(self):
        """The names of the columns of the table, which are known before any run."""
        places = [[f"{name}.x", f"{name}.y"] if name in PLACES else [name] for name in SUMMARY]
        return ["run", *self.table.names, "status", *sum(places, []), *self.table.quantities, *(["results"] if self.keeps else [])]

    def lines(self):
        """The lines of the table of what the runs came to: numbers, truth values and texts, None where a run has nothing. The lines
        hold no times of the clock: they are the same however often the study was stopped."""
        lines = []
        for number, row in enumerate(self.table.rows):
            found = self.record(number) or {"status": "not run"}
            values = [value for name in SUMMARY for value in self.summary_values(found.get("summary"), name)]
            quantities = found.get("quantities", {})
            line = [number + 1, *row, found["status"], *values, *(quantities.get(name) for name in self.table.quantities)]
            if self.keeps:
                there = self.results_path(number)
                line.append(str(there.relative_to(self.folder)) if there.exists() else None)
            lines.append(line)
        return lines

    def dimensions(self):
        """The dimensions of the columns that have one, by their names; of quantities those of the first run that came to its end."""
        found = (self.record(number) for number in range(len(self.keys)))
        of_quantities = next((one["units"] for one in found if one and "units" in one), {})
        return DIMENSIONS | dimensions(self.decks, self.settings_of(self.table.rows[0]), self.path) | of_quantities

    @staticmethod
    def summary_values(summary, name):
        """Of a member of a summary, with points between the names."""
        for part in name.split("."):
            summary = summary[part] if summary is not None else None
        if name in PLACES:
            return summary or [None, None]
        return [summary]


def last_line(said):
    lines = said.strip().splitlines() or [""]
    return lines[-1].removeprefix("scree: ")
