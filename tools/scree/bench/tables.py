"""Tables of figures, how they grow, and their form for other programs (JSON)."""
import json
import math
import pathlib
import platform
import sys

from ..errors import ScreeError


def growth(rows, of):
    """The exponent of the first column in `of` a row, between each row and the one before it."""
    exponents = [math.nan]
    for a, b in zip(rows, rows[1:]):
        both_measured = of(a) > 0 and of(b) > 0 and b[0] != a[0]
        exponents.append(math.log(of(b) / of(a)) / math.log(b[0] / a[0]) if both_measured else math.nan)
    return exponents


def n_log_n(row):
    return row[0] * math.log(row[0])


def print_table(columns, rows):
    """Columns are name and format; what is not a number is a dash."""
    print("".join(f"{name:>{max(10, len(name) + 2)}}" for name, _ in columns))
    for row in rows:
        print("".join(f"{format(value, form) if value == value else '-':>{max(10, len(name) + 2)}}"
                      for (name, form), value in zip(columns, row)))


class Table:
    """A table that is printed row by row as the figures come, and kept for JSON.

    Columns are (head, key of the row, format, width); a width below zero sets text to the left. What a row has no figure for is a
    dash there and null in the JSON.
    """

    def __init__(self, columns):
        self.columns, self.rows = columns, []

    def add(self, row):
        if not self.rows:
            self.print_line(head for head, _, _, _ in self.columns)
        self.rows.append(row)
        self.print_line(format(row[key], form) if row.get(key) is not None else "-" for _, key, form, _ in self.columns)

    def print_line(self, texts):
        widths = (width for _, _, _, width in self.columns)
        cells = (f"{text:<{-width}}" if width < 0 else f"{text:>{width}}" for text, width in zip(texts, widths))
        print("  ".join(cells).rstrip(), flush=True)

    def write(self, path, **facts):
        """Writes the rows as JSON, with the command, the machine and other facts."""
        machine = {"system": platform.system(), "processor": processor_name(), "python": platform.python_version()}
        try:
            pathlib.Path(path).write_text(json.dumps({"command": sys.argv[1:], "machine": machine, **facts, "rows": self.rows},
                                                     indent=1, allow_nan=False) + "\n")
        except OSError as problem:
            raise ScreeError(f"{path}: cannot write: {problem.strerror}") from None


def processor_name():
    """The processor, as Linux calls it."""
    try:
        names = [line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    except OSError:
        names = []
    return names[0] if names else platform.machine()
