"""Runs cases with a known answer and prints case | quantity | reference | scree | error | tolerance.

    tools/validate [CASE ...] [--set GROUP.NAME=VALUE] [--scree PROGRAM] [--keep FOLDER] [--write]

Without a case, all of them. A setting is for every run. doc/validation.md describes the cases and where the answers are from; --write
makes the pages of doc/verification, one a case, with its picture, numbers and deck. Exit
status 0 when every tolerance is met, 1 on a miss or a run that fails, 2 when the program is missing or a case
cannot have a setting.
Needs Debian's python3-numpy and python3-h5py.
"""
import pathlib

from ..arguments import BAD_INPUT, ends_in_a_line, parser_for
from ..errors import RunFailed, ScreeError
from ..program import shipped, work_folder
from . import cracks, elastic, pages, published  # noqa: F401  (the cases of these modules join CASES)
from .cases import CASES


def text(value):
    return value if isinstance(value, str) else f"{value:.7g}"


def compare(names, run, finished=lambda name, rows: None):
    """Prints the table, and what all of it took; calls `finished` after each case with its rows; returns the number of misses."""
    misses = 0
    print(f"{'case':<5}{'quantity':<46}{'reference':>14}{'scree':>20}{'error':>10}{'tolerance':>11}{'seconds':>9}")
    for name in names:
        rows, done = CASES[name](run), []
        while True:
            run.seconds = 0.0
            try:
                row = next(rows)
            except StopIteration:
                break
            except RunFailed as failed:
                if failed.status == BAD_INPUT and str(failed).startswith("--set"):
                    raise ScreeError(f"{name}: {failed}") from None
                print(f"{name:<5}{failed}  MISS")
                misses += 1
                break
            misses += not row.met()
            done.append(row)
            error = "" if isinstance(row.reference, str) else f"{row.error():.1e}"
            tolerance = "" if isinstance(row.reference, str) else f"{row.tolerance:.1e}"
            seconds = f"{run.seconds:.2f}" if run.seconds else ""
            print(f"{name:<5}{row.quantity:<46}{text(row.reference):>14}{text(row.found):>20}{error:>10}{tolerance:>11}{seconds:>9}"
                  f"{'  ok' if row.met() else '  MISS'}", flush=True)
        finished(name, done)
    print(f"{misses} misses" if misses else "every tolerance is met",
          f"{run.solves} solves, {run.processor_seconds:.1f} s of the processor in steps", sep=", ")
    return misses


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("case", nargs="*", help=f"of {' '.join(CASES)}")
    parser.add_argument("--set", action="append", default=[], metavar="GROUP.NAME=VALUE",
                        help="a setting of every run, unless its case has another; may be repeated")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for geometries and results; else they are not kept")
    parser.add_argument("--write", action="store_true", help="make the pages of doc/verification, with pictures")
    given = parser.parse_args()
    unknown = [name for name in given.case if name not in CASES]
    if unknown:
        parser.error(f"expected cases of {' '.join(CASES)}, found {' '.join(unknown)}")
    shipped("validation")
    with work_folder(given.keep) as folder:
        run = pages.Recorder(folder, given.scree, given.set)

        def write(name, rows):
            pages.write(name, CASES[name].__doc__.splitlines()[0].rstrip("."), rows, run.made)
            run.made = []

        return 1 if compare(given.case or list(CASES), run, *[write] * given.write) else 0
