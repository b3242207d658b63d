"""The text of decks, read and written: numbers, then named groups, and the names that comments give to rows.

A comment that begins with a word in single quotes names the row of numbers before it:

    -15 0 15 0 1           ! 'bedding'

Decks have no place for such names. The program does not read comments, and results hold the decks, so names survive both.
"""
from __future__ import annotations

import dataclasses
import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence

from ..errors import ModelError

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?$")
NAMED = re.compile(r"\s*'([^']+)'")
TOKEN = re.compile(r"[ \t,]+|(?P<end>\n)|[!#](?P<comment>[^\n]*)|(?P<quoted>'[^'\n]*'|\"[^\"\n]*\")|(?P<sign>[&=/])|(?P<word>[^ \t,\n!#=/]+)")
WIDTH = 100  # letters of a line that is not one row
LARGE, SMALL = 1e5, 1e-3  # beyond which numbers may have an exponent
COLUMN = 28  # of a line at which its comment begins


def as_number(word: str) -> float:
    """The number of a word of a deck, whose exponents may be those of Fortran; a whole number where it has digits alone."""
    return int(word) if word.lstrip("+-").isdigit() else float(word.lower().replace("d", "e"))


def number_text(value: float) -> str:
    """The shortest text that reads back as the same number; of a whole number its digits, as counts need them."""
    if isinstance(value, int):
        return str(value)
    value = float(value)
    plain = repr(value).removesuffix(".0")
    if "e" in plain or abs(value) >= LARGE or 0 < abs(value) < SMALL:
        mantissa, _, exponent = next(text for text in (f"{value:.{digits}e}" for digits in range(18)) if float(text) == value).partition("e")
        short = f"{mantissa}e{int(exponent)}"
        if len(short) < len(plain):
            return short
    return plain


def numbers_text(values: Iterable[float]) -> str:
    """Numbers with single blanks between them."""
    return " ".join(map(number_text, values))


def with_comment(numbers: str, comment: str) -> str:
    """A line of a deck with its comment, if there is one."""
    return f"{numbers:<{COLUMN}} ! {comment}" if comment else numbers


def quoted(name: str, after: str = "") -> str:
    """The comment that gives a name; nothing where there is none."""
    return (f"'{name}'" + after) if name else after.removeprefix(": ")


@dataclasses.dataclass
class Setting:
    """The value of a setting: a text, or numbers. `names` has the names of rows by how many numbers end with the row."""

    value: str | list[float]
    names: dict[int, str] = dataclasses.field(default_factory=dict)

    def numbers(self) -> list[float]:
        """The numbers; ModelError of a text."""
        if isinstance(self.value, str):
            raise ModelError(f"expected numbers, found '{self.value}'")
        return self.value

    def text(self) -> str:
        """The text; numbers as a deck has them."""
        return self.value if isinstance(self.value, str) else numbers_text(self.value)

    def rows(self, width: int) -> list[tuple[tuple[float, ...], str]]:
        """Rows of so many numbers, each with its name; none of a text."""
        if isinstance(self.value, str):
            return []
        return [(tuple(self.value[end - width:end]), self.names.get(end, "")) for end in range(width, len(self.value) + 1, width)]


def of_rows(rows: Iterable[tuple[Sequence[float], str]]) -> Setting:
    """A setting of rows with names; `none` where there are no rows."""
    values: list[float] = []
    names: dict[int, str] = {}
    for numbers, name in rows:
        values += map(float, numbers)
        if name:
            names[len(values)] = name
    return Setting(values, names) if values else Setting("none")


Part = dict[str, Setting]  # settings of a stage by GROUP.NAME, in their order


def opening(text: str) -> tuple[str, str]:
    """The comment that a deck opens with, without its signs, and the rest."""
    lines = text.lstrip("\ufeff").splitlines()
    n = next((i for i, line in enumerate(lines) if not line.startswith(("!", "#"))), len(lines))
    return "\n".join(line[1:].removeprefix(" ") for line in lines[:n]), "\n".join(lines[n:])


def opening_text(title: str) -> list[str]:
    """The lines of an opening comment."""
    return [f"! {line}".rstrip() for line in title.split("\n")] if title else []


def tokens(text: str, source: str) -> Iterator[tuple[str, str]]:
    """Kinds and texts of what stands in a deck: word, quoted, sign, comment."""
    at, line = 0, 1
    while at < len(text):
        found = TOKEN.match(text, at)
        if not found:
            raise ModelError(f"{source}:{line}: expected a closing quote, found none")
        at = found.end()
        line += found.lastgroup == "end"
        if found.lastgroup and found.lastgroup != "end":
            yield found.lastgroup, found[found.lastgroup]


class Numbers:
    """The numbers of a deck, row by row, with the names of the rows; then its groups."""

    def __init__(self, text: str, source: str) -> None:
        self.title, text = opening(text)
        self.source, self.at = source, 0
        self.values: list[float] = []
        self.names: dict[int, str] = {}
        beyond = list(tokens(text, source))
        for i, (kind, word) in enumerate(beyond):
            if (kind, word) == ("sign", "&"):
                self.parts = read_groups(beyond[i:], source)
                break
            if kind == "comment":
                if named := NAMED.match(word):
                    self.names[len(self.values)] = named[1]
            elif kind == "word" and NUMBER.match(word):
                self.values.append(as_number(word))
            else:
                raise ModelError(f"{source}: expected numbers before the groups, found '{word}'")
        else:
            self.parts = [{}]

    def row(self, width: int) -> tuple[list[float], str]:
        """The next numbers, and the name of their row."""
        self.at += width
        if self.at > len(self.values):
            raise ModelError(f"{self.source}: expected more numbers, found the end of them")
        return self.values[self.at - width:self.at], self.names.get(self.at, "")

    def number(self) -> float:
        return self.row(1)[0][0]

    def count(self) -> int:
        return int(self.number())

    def left(self) -> int:
        """How many numbers have not been read."""
        return len(self.values) - self.at

    def end(self) -> None:
        """ModelError where numbers are left."""
        if self.left():
            raise ModelError(f"{self.source}: expected the end of the numbers, found {self.left()} more")


def read_groups(found: list[tuple[str, str]], source: str) -> list[Part]:
    """The settings of a deck: those before its first &stage, and those of each stage."""
    parts: list[Part] = [{}]
    group, name, setting, words = None, "", None, iter([*found, ("", "")])
    kind, word = next(words)
    while kind:
        after = next(words)
        if kind == "comment":
            if (named := NAMED.match(word)) and setting and not isinstance(setting.value, str):
                setting.names[len(setting.value)] = named[1]
        elif group is None:
            if (kind, word) != ("sign", "&") or after[0] != "word":
                raise ModelError(f"{source}: expected & and the name of a group, found '{word}'")
            group, name, setting = after[1].lower(), "", None
            parts += [{}] if group == "stage" else []
            after = next(words)
        elif (kind, word) == ("sign", "/"):
            group = None  # a comment behind it still names the last row
        elif after == ("sign", "="):
            name, setting = word.lower(), None
            after = next(words)
        elif not name:
            raise ModelError(f"{source}: expected a name in &{group}, found '{word}'")
        elif kind == "word" and NUMBER.match(word):
            setting = parts[-1].setdefault(f"{group}.{name}", Setting([]))
            setting.numbers().append(as_number(word))
        else:
            setting = parts[-1][f"{group}.{name}"] = Setting(word[1:-1] if kind == "quoted" else word)
        kind, word = after
    if group is not None:
        raise ModelError(f"{source}: expected '/' at the end of &{group}, found the end of the deck")
    return parts


def value_lines(setting: Setting, width: int) -> list[str]:
    """The lines that a value takes: rows with names one by one, others as many as there is room for."""
    if isinstance(setting.value, str):
        return [setting.value if setting.value == "none" else f"'{setting.value}'"]
    room_of_rows = max((len(numbers_text(row)) for row, _ in setting.rows(width)), default=0) if setting.names else 0
    ends = sorted({*setting.names, *range(width, len(setting.value), width), len(setting.value)})
    lines: list[str] = []
    begin = room = 0
    for end in ends:
        row, name = numbers_text(setting.value[begin:end]), setting.names.get(end, "")
        if lines and not setting.names and room + len(row) < WIDTH:
            lines[-1] += f"  {row}" if width > 1 else f" {row}"
            room += len(row) + 2
        else:
            *full, row = textwrap.wrap(row, WIDTH) or [""]
            lines += [*full, f"{row:<{room_of_rows}}  ! {quoted(name)}" if name else row]
            room = len(row)
        begin = end
    return lines


POLYGONS = 10**9  # rows of as many numbers as they have
WIDTHS = {"bolts.ends": 4, "support.normal": 4, "support.x": 4, "support.y": 4, "support.both": 4, "support.moved": 4,
          "support.points": 2, "support.points_x": 2, "support.points_y": 2, "support.velocity": 2, "support.table": 3, "boundary.lines": 4,
          "absorbing.lines": 4, "absorbing.sides": 4, "boundary.traction": 4, "boundary.pressure": 2, "water.table": 2, "stage.remove_inside": POLYGONS, "excavation.outline": POLYGONS,
          "bolt_row.line": 4, "bolt_ring.centre": 2, "in_situ.surface": 2,
          "loads.force": 2, "acceleration.table": 3, "absorbing.table": 3}  # numbers of a row


def group_text(group: str, settings: Part) -> str:
    """A group with its settings."""
    lines, room = [f"&{group}"], 0
    for i, (name, setting) in enumerate(settings.items()):
        first, *others = value_lines(setting, WIDTHS.get(f"{group}.{name}", 1))
        short = not others and not setting.names
        head = f"{name}={first}"
        if i and (not short or room + len(head) > WIDTH):
            lines[-1] += "," if not has_comment(lines[-1]) else ""
            lines.append("    " + head)
        else:
            lines[-1] += (" " if i == 0 else ", ") + head
        lines += [" " * (5 + len(name)) + other for other in others]
        room = len(lines[-1]) if short else WIDTH
    return "\n".join(lines) + ("\n/" if has_comment(lines[-1]) else " /")


def has_comment(line: str) -> bool:
    """Whether a line of a group ends in the comment that names its row."""
    return re.search(r" ! '[^']+'$", line) is not None


def groups_text(part: Part) -> str:
    """The groups of a part of a deck; &stage first, and &deck."""
    groups: dict[str, Part] = {}
    for name, setting in part.items():
        group, _, own = name.partition(".")
        groups.setdefault(group, {})[own] = setting
    first = [group for group in ("stage", "deck") if group in groups]
    return "\n".join(group_text(group, groups[group]) for group in [*first, *(g for g in groups if g not in first)])
