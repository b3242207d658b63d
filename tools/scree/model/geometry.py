"""The geometry of a model: lines that the program cuts to blocks, or finished blocks; each read and written as a deck."""
from __future__ import annotations

import dataclasses
import math
import typing
from collections.abc import Sequence

from ..errors import ModelError
from .text import Numbers, number_text, numbers_text, opening_text, quoted, with_comment

SPARE_ROWS = 4  # behind each block in a block file: its first vertex again, and three that Shi's programs use
DIGITS = 10  # of places that words make
ROUNDING = 1e-12  # of a share of a line
Place = tuple[float, float]


@dataclasses.dataclass
class Row:
    """Numbers of a geometry, such as the ends of a line; a material where the row has one; its name."""

    numbers: tuple[float, ...]
    material: int = 0
    name: str = ""

    def text(self) -> str:
        """The line of a deck."""
        return with_comment(numbers_text([*self.numbers, *([self.material] if self.material else [])]), quoted(self.name))


@dataclasses.dataclass
class Block:
    """A finished block: corners counter-clockwise; `joints` has the joint material of the edge from each corner to the next."""

    material: int
    corners: list[Place]
    joints: list[int]
    name: str = ""


@dataclasses.dataclass
class Geometry:
    """What both kinds have: bolts, and points. A point is x y, and in a block file the number of its block, 0 where it is to be
    found."""

    title: str = ""
    bolts: list[Row] = dataclasses.field(default_factory=list)
    loads: list[Row] = dataclasses.field(default_factory=list)
    measured: list[Row] = dataclasses.field(default_factory=list)
    fixed: list[Row] = dataclasses.field(default_factory=list)
    ending: typing.ClassVar[str] = ""


@dataclasses.dataclass
class Lines(Geometry):
    """A geometry deck. `fixed` has lines; equal ends are a point."""

    e0: float = 0.001
    boundary: list[Row] = dataclasses.field(default_factory=list)
    joints: list[Row] = dataclasses.field(default_factory=list)
    material_lines: list[Row] = dataclasses.field(default_factory=list)
    holes: list[Row] = dataclasses.field(default_factory=list)
    ending: typing.ClassVar[str] = ".geo"

    def fix(self, x: float, y: float, name: str) -> None:
        """Adds a fixed point."""
        self.fixed.append(Row((x, y, x, y), name=name))

    def place(self, x: float, y: float, name: str) -> Row:
        """A load point or a measured point."""
        return Row((x, y), name=name)

    def text(self) -> str:
        """The geometry deck."""
        counts = [(f"{len(self.boundary) + len(self.joints)} {len(self.boundary)}", "lines, of which are boundary lines"),
                  (len(self.material_lines), "material lines"), (len(self.bolts), "bolts"), (len(self.fixed), "fixed lines"),
                  (len(self.loads), "load points"), (len(self.measured), "measured points"), (len(self.holes), "hole points")]
        rows = [*self.boundary, *self.joints, *self.material_lines, *self.bolts, *self.fixed, *self.loads, *self.measured,
                *self.holes]
        return "\n".join([*opening_text(self.title), with_comment(number_text(self.e0), "least distance of edge and node, over the size"),
                          *(with_comment(str(count), what) for count, what in counts), *(row.text() for row in rows)]) + "\n"

    @classmethod
    def read(cls, deck: Numbers) -> Lines:
        """The lines of a geometry deck."""
        e0, n, n_boundary = deck.number(), deck.count(), deck.count()
        counts = [deck.count() for _ in range(6)]

        def rows(number, width, has_material=False):
            for _ in range(number):
                numbers, name = deck.row(width + has_material)
                yield Row(tuple(numbers[:width]), int(numbers[-1]) if has_material else 0, name)

        lines = list(rows(n, 4, True))
        material_lines = list(rows(counts[0], 4, True))
        bolts = list(rows(counts[1], 7))
        fixed = list(rows(counts[2], 4))
        loads, measured, holes = (list(rows(count, 2)) for count in counts[3:])
        deck.end()
        return cls(deck.title, bolts, loads, measured, fixed, e0, lines[:n_boundary], lines[n_boundary:], material_lines, holes)


@dataclasses.dataclass
class Blocks(Geometry):
    """A block file."""

    blocks: list[Block] = dataclasses.field(default_factory=list)
    ending: typing.ClassVar[str] = ".blk"

    def fix(self, x: float, y: float, name: str) -> None:
        """Adds a fixed point."""
        self.fixed.append(self.place(x, y, name))

    def place(self, x: float, y: float, name: str) -> Row:
        """A point whose block the program finds."""
        return Row((x, y, 0), name=name)

    def text(self) -> str:
        """The block file."""
        n_rows = sum(len(block.corners) + SPARE_ROWS for block in self.blocks)
        lines = [*opening_text(self.title), with_comment(f"{len(self.blocks)} {len(self.bolts)} {n_rows}", "blocks, bolts, vertex rows"),
                 with_comment(f"{len(self.fixed)} {len(self.loads)} {len(self.measured)}", "fixed, load, measured points")]
        first = 1
        for block in self.blocks:
            lines.append(with_comment(f"{block.material} {first} {first + len(block.corners) - 1}", quoted(block.name)))
            first += len(block.corners) + SPARE_ROWS
        for block in self.blocks:
            before = [block.joints[-1], *block.joints]
            lines += [f"{joint} {numbers_text(corner)}" for joint, corner in zip(before, [*block.corners, block.corners[0]])]
            lines += ["0 0 0"] * (SPARE_ROWS - 1)
        return "\n".join([*lines, *(row.text() for row in (*self.bolts, *self.fixed, *self.loads, *self.measured))]) + "\n"

    @classmethod
    def read(cls, deck: Numbers) -> Blocks:
        """The blocks of a block file."""
        n, n_bolts, n_rows, *counts = (deck.count() for _ in range(6))
        ranges = [deck.row(3) for _ in range(n)]
        rows = [deck.row(3)[0] for _ in range(n_rows)]
        blocks = []
        for (material, first, last), name in ranges:
            own = rows[int(first) - 1:int(last)]
            joints = [int(row[0]) for row in own]
            blocks.append(Block(int(material), [(x, y) for _, x, y in own], joints[1:] + joints[:1], name))
        bolts = [Row(tuple(numbers), name=name) for numbers, name in (deck.row(9) for _ in range(n_bolts))]
        width = 4 if sum(counts) and deck.left() == 4 * sum(counts) else 3  # ntdda writes the type of each point first
        fixed, loads, measured = ([Row(tuple(numbers[-3:]), name=name) for numbers, name in (deck.row(width) for _ in range(count))]
                                  for count in counts)
        deck.end()
        return cls(deck.title, bolts, loads, measured, fixed, blocks)


def read_geometry(text: str, source: str) -> tuple[Lines | Blocks, Numbers]:
    """The geometry of a deck, a block file by the name of its file, and what was read, for its groups."""
    deck = Numbers(text, source)
    name = source.lower()
    kind: type[Lines] | type[Blocks] = Blocks if name.endswith((".blk", ".blck", "block.in")) else Lines
    return kind.read(deck), deck


def tidied(places: Sequence[Place]) -> list[Place]:
    """Places rounded to DIGITS of the largest coordinate, so that decks are read with ease."""
    largest = max((abs(value) for place in places for value in place), default=0.0)
    digits = DIGITS - math.ceil(math.log10(largest)) if largest > 0 else 0
    return [(round(x, digits) + 0.0, round(y, digits) + 0.0) for x, y in places]


def area_of(corners: Sequence[Place]) -> float:
    """The area of a polygon, above 0 where its corners run counter-clockwise."""
    return sum(x1 * y2 - x2 * y1 for (x1, y1), (x2, y2) in zip(corners, [*corners[1:], corners[0]])) / 2


def contains(corners: Sequence[Place], x: float, y: float) -> bool:
    """Whether a place is inside a polygon."""
    inside = False
    for (x1, y1), (x2, y2) in zip(corners, [*corners[1:], corners[0]]):
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) * (x2 - x1) / (y2 - y1):
            inside = not inside
    return inside


def clipped(p: Place, q: Place, polygons: Sequence[Sequence[Place]], inside: bool = True) -> list[tuple[Place, Place]]:
    """The parts of a line from p to q inside any of some polygons, or outside all of them. A line that crosses no side stays as it is
    or goes; a part that is cut ends on the side."""
    shares = {0.0, 1.0}
    dx, dy = q[0] - p[0], q[1] - p[1]
    for corners in polygons:
        for (x1, y1), (x2, y2) in zip(corners, [*corners[1:], corners[0]]):
            ex, ey = x2 - x1, y2 - y1
            cross = dx * ey - dy * ex
            if cross == 0:
                continue
            along = ((x1 - p[0]) * ey - (y1 - p[1]) * ex) / cross
            side = ((x1 - p[0]) * dy - (y1 - p[1]) * dx) / cross
            if 0 <= side <= 1 and 0 < along < 1:
                shares.add(along)
    found: list[tuple[float, float]] = []
    ends = sorted(shares)
    ends = [a for a, b in zip(ends, [*ends[1:], 2.0]) if b - a > ROUNDING or b > 1]
    for a, b in zip(ends, ends[1:]):
        x, y = p[0] + (a + b) / 2 * dx, p[1] + (a + b) / 2 * dy
        if any(contains(corners, x, y) for corners in polygons) == inside:
            if found and found[-1][1] == a:
                found[-1] = (found[-1][0], b)
            else:
                found.append((a, b))

    def at(share):
        return p if share == 0 else q if share == 1 else tidied([(p[0] + share * dx, p[1] + share * dy)])[0]

    return [(at(a), at(b)) for a, b in found]
