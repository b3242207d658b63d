"""What a study found: errors, orders, times, who is beaten by nobody; as a table, CSV and JSON."""
import csv
import json
import math
import platform
import statistics
import sys
import typing

from ..bench.tables import Table, processor_name
from ..errors import ScreeError
from .choices import DECK, MULTIPLIERS
from .orders import agreed, cost_to_reach, distance, extrapolate, front, Limit, observed_order
from .runs import recorded

TARGETS = (1e-1, 1e-2, 1e-3, 1e-4)


class Cost(typing.NamedTuple):
    """What runs are ranked by: column of the rows, unit, words for an axis, digits that it is good to."""

    key: str
    unit: str
    words: str
    digits: int


SECONDS = Cost("seconds", "s", "seconds of the processor in the steps", 2)
INSTRUCTIONS = Cost("instructions", "instructions", "instructions of the steps, without those of the C library", 3)
METHOD = ("strain", "integrator", "contact", "tolerance", "mesh", "accuracy")


class Answer:
    """What a quantity is held against, a closed form or an extrapolated reference; its scale; how far it may be off over that."""

    def __init__(self, quantity, limit):
        largest = float(abs(limit.value).max(initial=0.0))
        self.value, self.scale = limit.value, quantity.scale or largest or 1.0
        self.doubt = quantity.doubt if quantity.exact is not None else limit.doubt / self.scale
        self.closed = quantity.exact is not None

    def error(self, value):
        return distance(value, self.value) / self.scale


def method_of(run):
    """Words for what a run does otherwise than in its steps: those of its settings, and what its choice changes of the deck."""
    asked, choice = run.asked, run.choice
    strain = asked["method.strain"]
    if strain == "auto" and ":" in choice.strain:
        strain = choice.strain
    if asked["method.rotation"] != "linear":
        strain = asked["method.rotation"]
    weights = [asked[name] for name in ("integrator.beta", "integrator.gamma", "integrator.rho") if name in asked]
    words = {"strain": strain, "integrator": f"{asked['integrator.scheme']} {', '.join(weights)}".strip()}
    for axis in METHOD[2:]:
        word = getattr(choice, axis)
        is_factor = axis not in ("tolerance", "accuracy") and word != MULTIPLIERS
        words[axis] = "" if word == DECK else f"{word} x" if is_factor else word
    return words


def mesh_of(run):
    """Its mesh over that of the deck."""
    return 1.0 if run.choice.mesh == DECK else float(run.choice.mesh)


def limits_of(name, records):
    """The limit of a quantity in each family of reference runs: of smaller steps on the finest mesh, then of meshes at one step."""
    families, limits = {}, []
    for run, record in records:
        words = method_of(run)
        if words["strain"] == "green" and not words["contact"] and not words["tolerance"] and record.get("values"):
            families.setdefault(words["integrator"], []).append((run, record["values"][name]))
    for runs in families.values():
        if not any(run.extra for run, _ in runs):
            continue
        finest = min(mesh_of(run) for run, _ in runs)
        limit = extrapolate(*zip(*((run.choice.step, value) for run, value in runs if mesh_of(run) == finest)))
        steps = [run.choice.step for run, _ in runs if mesh_of(run) != finest]
        if steps:
            meshes = {mesh_of(run): value for run, value in runs if run.choice.step == min(steps)}
            of_mesh = extrapolate(meshes.keys(), meshes.values())
            limit = Limit(limit.value + of_mesh.value - meshes[finest], limit.doubt + of_mesh.doubt)
        limits.append(limit)
    return limits


def words_of(row):
    """A method in a line."""
    return ", ".join([f"{row['strain']} {row['integrator']}", *(f"{axis} {row[axis]}" for axis in METHOD[2:] if row[axis])])


class Findings:
    """What all runs of a scene say: `rows`, one a run, and the `answers` that they are held against."""

    def __init__(self, study):
        self.scene, self.names = study.scene, list(study.scene.quantities)
        records = [(run, record) for run in study.runs if (record := recorded(run))]
        self.answers = {name: self.answer(name, records) for name in self.names}
        self.rows = [self.row(run, record, run.method == study.default) for run, record in records if not run.extra]
        counted = [row["instructions"] is not None for row in self.rows if row["seconds"]]
        self.cost = INSTRUCTIONS if counted and all(counted) else SECONDS  # what runs are ranked by
        self.rows.sort(key=lambda row: (not row["default"], *(row[axis] for axis in METHOD), -row["step"]))
        self.orders_in_mesh = {name: self.order_in_mesh(name, records) for name in self.names}
        for name in self.names:
            self.add_orders(name)
            self.add_front(name)

    def answer(self, name, records):
        quantity = self.scene.quantities[name]
        if quantity.exact is not None:
            return Answer(quantity, Limit(quantity.exact, 0.0))
        limits = limits_of(name, records)
        return Answer(quantity, agreed(limits)) if limits else None

    def row(self, run, record, default):
        """A run; a quantity that could not be held against anything has no error."""
        seconds = record.get("seconds", [])
        row = {"scene": self.scene.name, **method_of(run), "step": run.step, "default": default, "method": run.method,
               "seconds": statistics.median(seconds) if seconds else None, "rounds": len(seconds),
               **{name: record.get(name) for name in ("steps", "cuts", "solves", "instructions", "impacts", "estimate", "ended")}}
        for name in self.names:
            value, answer = record.get("values", {}).get(name), self.answers[name]
            error = answer.error(value) if value is not None and answer else math.inf
            row[f"error: {name}"] = error if math.isfinite(error) else None
        return row

    def methods(self):
        """The rows of each method, in their order."""
        found = {}
        for row in self.rows:
            found.setdefault(row["method"], []).append(row)
        return list(found.values())

    def add_orders(self, name):
        for rows in self.methods():
            doubt = self.answers[name].doubt if self.answers[name] else 0.0
            order, words = observed_order([row["step"] for row in rows], [row[f"error: {name}"] for row in rows], doubt,
                                          any(row["impacts"] for row in rows))
            for row in rows:
                row[f"order: {name}"], row[f"order in words: {name}"] = order, words

    def judged(self, name, rows=None):
        """Rows, those of all or these, that have an error and a cost."""
        return [row for row in (self.rows if rows is None else rows) if row[f"error: {name}"] is not None and row[self.cost.key]]

    def add_front(self, name):
        """Who is beaten by nobody, where errors below what the reference may be off by are the same."""
        rows = self.judged(name)
        errors = [max(row[f"error: {name}"], self.answers[name].doubt) for row in rows]
        for row, marked in zip(rows, front(errors, [row[self.cost.key] for row in rows])):
            row[f"front: {name}"] = marked

    def order_in_mesh(self, name, records):
        """The order that values of methods that differ in the mesh alone tell, at their smallest step, by words for the method."""
        smallest, families = min(run.choice.step for run, _ in records if not run.extra), {}
        for run, record in records:
            if run.choice.step == smallest and record.get("values") and not run.extra:
                families.setdefault(words_of({**method_of(run), "mesh": ""}), []).append((mesh_of(run), record["values"][name]))
        orders = {method: extrapolate(*zip(*found)).order for method, found in families.items() if len(found) > 2}
        return {method: order for method, order in orders.items() if order is not None}

    def costs_to_reach(self, name, wanted):
        """What it costs each method to get to an error: (that, words, whether it is the default), the cheapest first."""
        found = []
        for rows in self.methods():
            rows = self.judged(name, rows)
            cost = cost_to_reach(wanted, *([row[key] for row in rows] for key in ("step", f"error: {name}", self.cost.key)))
            if cost is not None:
                found.append((cost, words_of(rows[0]), rows[0]["default"]))
        return sorted(found)

    def cheapest(self, name):
        """For each error wanted, in words: how the cheapest method gets there, how many times that the best of each other strain costs,
        and the default.
        """
        lines = []
        for wanted in TARGETS:
            found = self.costs_to_reach(name, wanted)
            if found:
                cost, words, _ = found[0]
                others = {one[1].split()[0]: one for one in reversed(found)}  # the cheapest of each strain
                others.pop(words.split()[0])
                default = next((one for one in found if one[2]), None)
                lines.append((wanted, f"{words}, {cost:.{self.cost.digits}g} {self.cost.unit}",
                              "; ".join(f"{one[1]}, {one[0] / cost:.1f} times" for one in sorted(others.values())),
                              f"{default[0] / cost:.1f} times" if default else "not reached"))
        return lines

    def by_accuracy(self):
        """Of each run that chose its steps by an accuracy: strain, what was asked, the largest error over the displacement, whose it is,
        what was estimated, steps, seconds.
        """
        lines = []
        for row in (row for row in self.rows if row["accuracy"]):
            errors = [(error * self.answers[name].scale / (self.scene.quantities[name].way or self.answers[name].scale), name)
                      for name in self.names if (error := row[f"error: {name}"]) is not None]
            lines.append((row["strain"], float(row["accuracy"]), *max(errors, default=(None, row["ended"])), row["estimate"],
                          row["steps"], row["seconds"]))
        return lines

    def about(self, name):
        """A line on what a quantity is held against."""
        answer = self.answers[name]
        if answer is None:
            return f"{name}: no reference, as its runs did not end"
        where = "closed form" if answer.closed else "Richardson's extrapolation of finer runs"
        return f"{name}: errors over {answer.scale:.4g}, from the {where}, which may be off by {answer.doubt:.1e}"


def columns_of(names):
    errors = [column for name in names for column in ((name, f"error: {name}", ".2e", max(9, len(name))),
                                                      ("order", f"order in words: {name}", "", -13), ("", f"mark: {name}", "", -1))]
    return [("strain", "strain", "", -6), ("integrator", "integrator", "", -22), ("contact", "contact", "", -11),
            ("tol.", "tolerance", "", -5), ("mesh", "mesh", "", -5), ("accuracy", "accuracy", "", -8), ("step", "step", ".4g", 9), *errors,
            ("s", "seconds", ".4f", 9), ("steps", "steps", "d", 6), ("cut", "cuts", "d", 4), ("solves", "solves", "d", 7),
            ("instructions", "instructions", "d", 12), ("", "place", "", -8)]


def print_findings(findings):
    """The table of a scene: the default and who is beaten by nobody, `*` beside that error; what errors are of; who is cheapest."""
    print(f"\n{findings.scene.name}: {findings.scene.text}; ranked by {findings.cost.key}")
    rows = [{**row, **{f"mark: {name}": "*" if row.get(f"front: {name}") else "" for name in findings.names},
             "place": "default" if row["default"] else ""} for row in findings.rows]
    rows = [row for row in rows if row["default"] or any(row[f"mark: {name}"] for name in findings.names)]
    table = Table([column for column in columns_of(findings.names) if ":" in column[1] or any(row.get(column[1]) for row in rows)])
    for row in rows:
        table.add(row)
    print_accuracies(findings)
    ended = [row["ended"] for row in findings.rows if row["ended"] != "complete"]
    others = [f"{ended.count(words)} ended: {words}" for words in dict.fromkeys(ended)]
    print(f"and {len(findings.rows) - len(rows)} other runs", *others, sep="; ")
    for name in findings.names:
        print(findings.about(name))
        for method, order in findings.orders_in_mesh[name].items():
            print(f"  order in the mesh, {method}: {order:.2f}")
        for wanted, best, others, default in findings.cheapest(name):
            print(f"  to {wanted:g}: {'; '.join(filter(None, (best, others, f'the default, {default}')))}")


def print_accuracies(findings):
    """What runs that chose their steps were asked beside what they came to: in doubt below what the answer leaves out."""
    lines = findings.by_accuracy()
    if lines:
        table = Table([("strain", "strain", "", -6), ("asked", "asked", ".0e", 6), ("is off", "error", ".1e", 8),
                       ("over that", "over", ".2f", 9), ("estimated", "estimate", ".1e", 9), ("", "", "", 1),
                       ("whose", "name", "", -16), ("steps", "steps", "d", 7), ("s", "seconds", ".3f", 8)])
        for strain, asked, error, name, estimate, steps, seconds in lines:
            table.add({"strain": strain, "asked": asked, "error": error, "over": error and error / asked, "estimate": estimate, "": "",
                       "name": name, "steps": steps, "seconds": seconds})


def write_csv(path, rows):
    """Rows by name of the column; what a row has not is empty."""
    columns = list(dict.fromkeys(name for row in rows for name in row if name != "method"))
    try:
        with open(path, "w", newline="") as f:
            table = csv.DictWriter(f, columns, extrasaction="ignore")
            table.writeheader()
            table.writerows(rows)
    except OSError as problem:
        raise ScreeError(f"{path}: cannot write: {problem.strerror}") from None


def write_json(path, all_findings, **facts):
    """All rows with what they are held against, the machine and other facts."""
    found = [{"scene": findings.scene.name, "text": findings.scene.text,
             "answers": {name: answer and {"value": answer.value.tolist(), "scale": answer.scale, "doubt": finite(answer.doubt),
                                            "closed form": answer.closed} for name, answer in findings.answers.items()},
              "orders in the mesh": findings.orders_in_mesh,
             "ranked by": findings.cost.key,
             "cost to reach": {name: {f"{wanted:g}": findings.costs_to_reach(name, wanted) for wanted in TARGETS}
                               for name in findings.names},
             "rows": findings.rows} for findings in all_findings]
    machine = {"system": platform.system(), "processor": processor_name(), "python": platform.python_version()}
    try:
        written = {"command": sys.argv[1:], "machine": machine, **facts, "scenes": found}
        path.write_text(json.dumps(written, indent=1, allow_nan=False) + "\n")
    except OSError as problem:
        raise ScreeError(f"{path}: cannot write: {problem.strerror}") from None


def finite(number):
    return number if math.isfinite(number) else None
