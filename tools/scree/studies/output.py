"""The table of a study as a file, by the ending of its name: text (.csv), or columns with types (.parquet)."""
import csv
import io

import numpy as np

from ..arguments import check_ending
from ..errors import ScreeError
from ..records import replace

WHOLE = ("run", "steps.taken", "steps.cut", "displacement.block", "warnings")  # columns of whole numbers; others are real or words


def as_csv(header, lines):
    """The table as text, in bytes; what a run has not is left empty."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([["" if value is None else value for value in line] for line in lines])
    return text.getvalue().encode()


def as_parquet(header, lines):
    """The table in the format of Apache Parquet, in bytes: whole and real numbers, true and false, words; what a run has not is null."""
    import pyarrow
    from pyarrow import parquet
    columns = {name: typed(name, column) for name, column in zip(header, zip(*lines))}
    stored = io.BytesIO()
    parquet.write_table(pyarrow.table(columns), stored)
    return stored.getvalue()


def typed(name, column):
    """A column of one type, None where a run has nothing."""
    if name in WHOLE or all(value is None or isinstance(value, bool) for value in column):
        return list(column)
    numbers = numbers_of(column)
    if numbers is None:
        return [None if value is None else str(value) for value in column]
    return [None if value in ("", None) else float(number) for value, number in zip(column, numbers)]


def numbers_of(values):
    """A column as numbers, NaN where it has none; None where it is of words."""
    try:
        return np.array([np.nan if value in ("", None) else float(value) for value in values])
    except ValueError:
        return None


FORMATS = {".csv": as_csv, ".parquet": as_parquet}


def check_output(path):
    """ScreeError where a table cannot be written by that name: another ending, no folder, a package that is missing."""
    check_ending(path, "a table", FORMATS)
    if not path.parent.is_dir():
        raise ScreeError(f"{path}: expected a folder that there is, found none")
    if path.suffix.lower() == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401  here, as nothing else needs it
        except ImportError as problem:
            raise ScreeError(f"{path}: expected the Python package pyarrow, found: {problem}; pip install '.[parquet]', or give a "
                             "name with .csv") from None


def write_table(path, header, lines):
    """Writes the table, whole or not at all."""
    try:
        replace(path, FORMATS[path.suffix.lower()](header, lines))
    except OSError as problem:
        raise ScreeError(f"{path}: cannot write the table: {problem.strerror}") from None
