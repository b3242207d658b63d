"""The words of a model for what holds, loads and bolts the rock, and for stages."""
from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from ..errors import ModelError
from .geometry import Blocks, Place, tidied
from .rock import Rock
from .text import Part, Setting, of_rows
from .words import HOLDS, POINT_HOLDS, Point, Points, number, one_of, place, places, text, vector, whole

# Lists of lines in decks: how many numbers a line has, and further lists with so many for each line.
PATTERN_NUMBERS = ("spacing", "number", "length", "direction", "radius", "from", "to")  # of a row or a ring of bolts
FULL_TURN, FIT = 360, 1e-9  # degrees; the share of a spacing by which the last bolt may lie beyond the end of its row
BOLT_NUMBERS = ("stiffness", "strength", "pretension", "shear_stiffness", "shear_strength")
COLUMNS = {"bolts.ends": dict.fromkeys(BOLT_NUMBERS, 1), "boundary.lines": {"pressure": 2, "traction": 4},
           **{f"support.{hold}": {} for hold in HOLDS}, "support.moved": {"velocity": 2},
           **{f"support.{points}": {} for points in POINT_HOLDS.values()}}
LINE, POINT = 4, 2  # numbers: x1 y1 x2 y2, x y
WIDTH_OF = {f"support.{points}": POINT for points in POINT_HOLDS.values()}
STEP_SETTINGS = ("step.size", "step.count", "step.end_time", "step.balance", "step.past_peak")


class Holding(Rock):
    """Supports, loads, water, bolts and stages of a model. Each word holds from the stage that it is said in on."""

    def in_force(self, name: str) -> Setting | None:
        """A setting as the present stage has it, GROUP.NAME; None where nothing has been said of it."""
        return next((part[name] for part in reversed(self.parts) if name in part), None)

    def stage(self, name: str, kind: str | None = None, reset: str | None = None) -> None:
        """Begins a stage: all words after it are of this stage. `kind` is static or dynamic, `reset` sets velocities, displacements
        or both to zero."""
        part: Part = {"stage.name": Setting(text(name, "stage(name=)"))}
        if kind is not None:
            part["stage.kind"] = Setting(one_of(kind, ("static", "dynamic"), "stage(kind=)"))
        if reset is not None:
            part["stage.reset"] = Setting(one_of(reset, ("velocities", "displacements", "both"), "stage(reset=)"))
        self.parts.append(part)

    def static(self, balance: float | None = 1e-4, steps: int = 200, size: float = 0.01) -> None:
        """The run, or the stage, is static: it ends where on no block more than a share `balance` of its weight and loads is out of
        balance, at most after so many steps. `size` is that of the first. With balance None all steps are taken, as tables of movements
        need them."""
        self._steps("static", 0, steps, size, "static")
        if balance is not None:
            self.parts[-1]["step.balance"] = Setting([number(balance, "static(balance=)", above=0, most=1)])

    def dynamic(self, time: float, size: float = 0.01) -> None:
        """The run, or the stage, is dynamic and lasts so long; `size` is that of its steps."""
        number(time, "dynamic(time=)", above=0)
        number(size, "dynamic(size=)", above=0)
        self._steps("dynamic", 1, max(1, round(time / size)), size, "dynamic")
        self.parts[-1]["step.end_time"] = Setting([float(time)])

    def _steps(self, kind, k01, steps, size, word):
        """Says how many steps of a size the present part has."""
        whole(steps, f"{word}(steps=)")
        number(size, f"{word}(size=)", above=0)
        for name in STEP_SETTINGS:
            self.parts[-1].pop(name, None)
        if len(self.parts) == 1:
            self.k01, self.steps, self.step_size = float(k01), steps, float(size)
            return
        self.parts[-1] |= {"stage.kind": Setting(kind), "step.size": Setting([float(size)])}
        if kind == "static":
            self.parts[-1]["step.count"] = Setting([steps])

    # Lines with names

    def _rows(self, lines):
        """The lines in force: for each its numbers, its name and its numbers in further lists."""
        found, group = self.in_force(lines), lines.partition(".")[0]
        rows = found.rows(WIDTH_OF.get(lines, LINE)) if found else []
        columns = {}
        for column, width in COLUMNS[lines].items():
            given = self.in_force(f"{group}.{column}")
            values = [] if given is None or isinstance(given.value, str) else given.value
            if len(values) == width:
                values = values * len(rows)
            columns[column] = [tuple(values[i * width:(i + 1) * width]) or (0.0,) * width for i in range(len(rows))]
        return [{"line": line, "name": name, **{column: values[i] for column, values in columns.items()}}
                for i, (line, name) in enumerate(rows)]

    def _set_rows(self, lines, rows):
        """Says the lines of the present part anew."""
        group, part = lines.partition(".")[0], self.parts[-1]
        if not rows and len(self.parts) == 1:
            for name in (lines, *(f"{group}.{column}" for column in COLUMNS[lines])):
                part.pop(name, None)
            return
        part[lines] = of_rows((row["line"], row["name"]) for row in rows)
        for column, width in COLUMNS[lines].items() if rows else ():
            values = [value for row in rows for value in row[column]]
            if any(values) or self.in_force(f"{group}.{column}"):
                part[f"{group}.{column}"] = Setting(values[:1] if width == 1 and len(set(values)) == 1 else values)

    def remove(self, name: str) -> None:
        """Takes away the supports, loads and bolts of a name, from the present stage on."""
        there = False
        for lines in COLUMNS:
            rows = self._rows(lines)
            kept = [row for row in rows if row["name"] != name]
            if len(kept) < len(rows):
                there = True
                self._set_rows(lines, kept)
        if not there:
            names = dict.fromkeys(row["name"] for lines in COLUMNS for row in self._rows(lines) if row["name"])
            one_of(name, list(names), "remove(name=)")

    def support(self, name: str, line: Points | None = None, hold: str = "both", points: Points | None = None,
                velocity: Point | None = None, table: Sequence[Point] | None = None) -> None:
        """Holds the edges of blocks on a line, from point to point: `both` wholly, `normal` across the line, `x` or `y` along an axis.
        In place of a line, `points` of blocks are held, `both`, `x` or `y`.

        With a `velocity` (x, y), or a `table` of times of the stage with (t, x, y), the line moves. It holds edges along that motion alone;
        another support of the same line holds them across. All lines of a stage that tables move have one table.
        """
        text(name, "support(name=)")
        if (line is None) == (points is None):
            raise ModelError("support(line=, points=): expected one of both")
        if line is None:
            lines = f"support.{POINT_HOLDS[one_of(hold, POINT_HOLDS, 'support(hold=) of points')]}"
            self._set_rows(lines, self._rows(lines) + [{"line": point, "name": name} for point in places(points, "support(points=)", 1)])
            return
        moved = velocity is not None or table is not None
        lines = "support.moved" if moved else f"support.{one_of(hold, HOLDS, 'support(hold=)')}"
        line = places(line, "support(line=)", 2)
        rows = [{"line": (*p, *q), "name": name} for p, q in zip(line, line[1:])]
        if moved:
            self._move_support(velocity, table)
            speed = (0.0, 0.0) if velocity is None else vector(velocity, "support(velocity=)")
            rows = [{**row, "velocity": speed} for row in rows]
        self._set_rows(lines, self._rows(lines) + rows)

    def _move_support(self, velocity, table):
        """Takes the table of moved supports; ModelError where the lines would have two motions."""
        there = "support.table" if self.in_force("support.table") else "support.velocity" if self.in_force("support.velocity") else None
        if (velocity is None) == (table is None) or there == ("support.table" if table is None else "support.velocity"):
            raise ModelError("support(velocity=, table=): expected one of both for all lines that move, found two")
        if table is not None:
            rows = [vector(row, "support(table=)", 3) for row in table]
            self.parts[-1]["support.table"] = Setting([value for row in rows for value in row])

    def load(self, name: str, line: Points, pressure: float | Sequence[float] = 0.0, traction: Point = (0.0, 0.0)) -> None:
        """Loads the edges of blocks on a line: a pressure across them, one number or one for each point of the line; a traction (x, y)
        that keeps its direction."""
        line = places(line, "load(line=)", 2)
        if isinstance(pressure, Iterable):
            given = list(vector(pressure, "load(pressure=) along the line", len(line)))
        else:
            given = [number(pressure, "load(pressure=)")] * len(line)
        traction = vector(traction, "load(traction=)")
        rows = [{"line": (*p, *q), "name": text(name, "load(name=)"), "pressure": pair, "traction": traction * 2}
                for p, q, pair in zip(line, line[1:], zip(given, given[1:]))]
        self._set_rows("boundary.lines", self._rows("boundary.lines") + rows)

    def force(self, name: str, point: Point, force: Sequence) -> None:
        """A force on a point: (x, y), or times with (t, x, y), linear between. Constant forces may change in a stage."""
        at, there = place(point, "force(point=)"), [row.name for row in self.geometry.loads]
        of_times = isinstance(force, Sequence) and len(force) > 0 and isinstance(force[0], Sequence)
        if len(self.parts) > 1:
            one_of(name, there, "force(name=) in a stage")
        else:
            if of_times or self.tables is not None:
                tables = self._need_tables("force(force=)")
                rows = [vector(row, "force(force=)", 3) for row in force] if of_times else [(0.0, *vector(force, "force(force=)"))]
                tables.append(rows)
            self.geometry.loads.append(self.geometry.place(*at, text(name, "force(name=)")))
        if self.tables is None:
            found = self.in_force("loads.force")
            values = list(found.numbers()) if found else []
            values += [0.0] * (2 * len(self.geometry.loads) - len(values))
            k = [row.name for row in self.geometry.loads].index(name)
            values[2 * k:2 * k + 2] = vector(force, "force(force=)")
            self.parts[-1]["loads.force"] = Setting(values)

    def water(self, table: Points | None, unit_weight: float | None = None) -> None:
        """A water table through points with ascending x; None takes the water away. The unit weight is that of water in the units of the
        model, unless it is given."""
        if table is None:
            self.parts[-1]["water.table"] = Setting("none")
            return
        line = places(table, "water(table=)", 1)
        if unit_weight is None and self.units is None:
            raise ModelError("water(unit_weight=): expected a number, as the deck of the model does not say its units")
        own = self.units.water * (self.gravity or 0.0) if self.units else 0.0
        weight = own if unit_weight is None else number(unit_weight, "water(unit_weight=)", above=0)
        self.parts[-1] |= {"water.table": Setting([value for place in line for value in place]), "water.unit_weight": Setting([weight])}

    # Bolts

    def bolt(self, name: str, head: Point, end: Point, stiffness: float, strength: float = 0, pretension: float = 0,
             shear_stiffness: float = 0, shear_strength: float = 0) -> None:
        """A bolt between two points, with numbers per unit thickness; a strength of 0 is no limit, a shear stiffness makes it grouted.

        In a stage it adds to the bolts that are there.
        """
        self._add_bolts("bolt", name, [(vector(head, "bolt(head=)"), vector(end, "bolt(end=)"))],
                        (stiffness, strength, pretension, shear_stiffness, shear_strength))

    def bolt_row(self, name: str, line: Points, count: int, length: float, stiffness: float, angle: float | None = None,
                 strength: float = 0, pretension: float = 0, shear_stiffness: float = 0, shear_strength: float = 0) -> None:
        """Bolts of a length with their heads in equal distances along a line, from point to point. They point in a direction in degrees
        counter-clockwise from x, or to the left of the line."""
        line = places(line, "bolt_row(line=)", 2)
        number(length, "bolt_row(length=)", above=0)
        heads = spread_along(line, whole(count, "bolt_row(count=)"))
        ways = [left if angle is None else math.radians(number(angle, "bolt_row(angle=)")) for _, left in heads]
        self._add_bolts("bolt_row", name, [((x, y), (x + length * math.cos(way), y + length * math.sin(way)))
                                           for ((x, y), _), way in zip(heads, ways)],
                        (stiffness, strength, pretension, shear_stiffness, shear_strength))

    def bolt_ring(self, name: str, centre: Point, radius: float, count: int, length: float, stiffness: float, start: float = 0,
                  end: float = 360, strength: float = 0, pretension: float = 0, shear_stiffness: float = 0,
                  shear_strength: float = 0) -> None:
        """Bolts of a length that point outwards from a circle, in equal angles from one angle to another in degrees counter-clockwise
        from x."""
        x, y = vector(centre, "bolt_ring(centre=)")
        number(radius, "bolt_ring(radius=)", above=0)
        number(length, "bolt_ring(length=)", above=0)
        n = whole(count, "bolt_ring(count=)")
        span = number(end, "bolt_ring(end=)", above=number(start, "bolt_ring(start=)")) - start
        ways = [math.radians(start + span * i / (n if span == 360 else max(n - 1, 1))) for i in range(n)]  # noqa: PLR2004  a full circle
        self._add_bolts("bolt_ring", name, [tuple((x + r * math.cos(way), y + r * math.sin(way)) for r in (radius, radius + length))
                                            for way in ways], (stiffness, strength, pretension, shear_stiffness, shear_strength))

    def _add_bolts(self, word, name, ends, values):
        """Adds bolts with the same numbers to those in force."""
        given = {column: (number(value, f"{word}({column}=)", least=None if column == "stiffness" else 0,
                                 above=0 if column == "stiffness" else None),) for column, value in zip(BOLT_NUMBERS, values)}
        rows = [{"line": sum(tidied(pair), ()), "name": text(name, f"{word}(name=)"), **given} for pair in ends]
        self._set_rows("bolts.ends", self._rows("bolts.ends") + rows)

    def bolts(self) -> list[tuple[tuple, str]]:
        """The bolts of the groups of the present stage, in their order: what tells each from others, and its name."""
        found = [(tuple(value for key, value in row.items() if key != "name"), row["name"]) for row in self._rows("bolts.ends")]
        for group, place, width in (("bolt_row", "line", LINE), ("bolt_ring", "centre", POINT)):
            places_of = self.in_force(f"{group}.{place}")
            for i, (row, name) in enumerate(places_of.rows(width) if places_of else ()):
                own = {key: self._of_pattern(group, key, i) for key in (*PATTERN_NUMBERS, *BOLT_NUMBERS)}
                if group == "bolt_row":
                    span, closed = math.dist(row[:2], row[2:]), False
                else:
                    turn = FULL_TURN if own["to"] is None else own["to"] - (own["from"] or 0)
                    span, closed = math.radians(turn) * own["radius"], turn >= FULL_TURN
                fit = int(span / own["spacing"] * (1 + FIT)) if own["spacing"] else 0
                count = int(own["number"]) if own["number"] else max(1, fit if closed else fit + 1)
                found += [((group, row, *own.values(), k), name) for k in range(count)]
        return found

    def _of_pattern(self, group, name, i):
        """A number of a row or ring of bolts: its own, or that of all; None where there is none."""
        found = self.in_force(f"{group}.{name}")
        if found is None or isinstance(found.value, str):
            return None
        return found.value[i if len(found.value) > 1 else 0]

    # Excavation

    def excavate(self, *what: str | Points) -> None:
        """Removes, in the present stage: excavations or blocks by name, or all blocks inside a polygon."""
        if len(self.parts) == 1:
            raise ModelError("excavate: expected a stage before it, found none: begin one with stage(); what is air from the start is an "
                             "opening()")
        for one in what:
            if isinstance(one, str) and isinstance(self.geometry, Blocks):
                one_of(one, list(dict.fromkeys(block.name for block in self.geometry.blocks)), "excavate(what)")
                found = self.parts[-1].setdefault("stage.remove_blocks", Setting([]))
                removed = found.numbers()
                removed += [i for i, block in enumerate(self.geometry.blocks, 1) if block.name == one]
                continue
            corners, name = (self._excavation(one), one) if isinstance(one, str) else (places(one, "excavate(what)", 3), "")
            found = self.parts[-1].setdefault("stage.remove_inside", Setting([]))
            outline = found.numbers()
            outline += [value for corner in [*corners, corners[0]] for value in corner]
            found.names |= {len(outline): name} if name else {}

    def _excavation(self, name):
        """The corners of an excavation, by the joints of its name."""
        loops, begun = {}, []
        for row in self.geometry.joints:
            if begun and (row.name != begun[0][1] or begun[-1][2] != row.numbers[:2]):
                begun = []
            begun.append((row.numbers[:2], row.name, row.numbers[2:]))
            if begun[0][0] == row.numbers[2:]:
                loops[row.name] = [place for place, _, _ in begun]
                begun = []
        return loops[one_of(name, list(loops), "excavate(what)")]


def spread_along(line: list[Place], count: int) -> list[tuple[Place, float]]:
    """Places in equal distances along a line, and there the direction to its left, in radians. One alone lies in the middle."""
    line = [line[0], *(q for p, q in zip(line, line[1:]) if p != q)]
    lengths = [math.dist(p, q) for p, q in zip(line, line[1:])]
    if not lengths:
        raise ModelError("bolt_row(line=): expected a line with a length, found one place")
    found = []
    for i in range(count):
        way = sum(lengths) * (i / (count - 1) if count > 1 else 0.5)
        k = 0
        while k < len(lengths) - 1 and way > lengths[k]:
            way -= lengths[k]
            k += 1
        (x1, y1), (x2, y2), share = line[k], line[k + 1], way / lengths[k]
        found.append(((x1 + share * (x2 - x1), y1 + share * (y2 - y1)), math.atan2(y2 - y1, x2 - x1) + math.pi / 2))
    return found
