"""The work of tools/check: layout, lint, rooms, complexity and arguments of the Fortran, types of the Python package, and words, as
findings or as a table."""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

from . import ablate, limits, measures, parts, prose, rooms, texts
from .fortran import QUOTED_OR_COMMENT

TREE = pathlib.Path(__file__).resolve().parents[3]
FOLDERS = ("src", "tests")
SUFFIXES = (".f90", ".pf")
BIN = TREE / "build" / "check" / "bin"
PACKAGES = ("scree.model",)
TYPED = (*PACKAGES, "scree", "scree.errors", "scree.ground_motion", "scree.in_force", "scree.notebooks", "scree.program", "scree.results",
         "scree.terminal", "scree.verbs")  # what users of the package call

# Where fprettify 0.3.7 errs: a blank lost before `.not.`, and one gained where a variable has the name of a statement.
ITS_ERRORS = ((re.compile(r",\s*(\.not\.)", re.I), r", \1"), (re.compile(r"\b(open|close|read|write)\s+\(", re.I), r"\1("))


class CheckError(Exception):
    """One line for the user."""


def sources():
    return [path for folder in FOLDERS for path in sorted((TREE / folder).rglob("*")) if path.suffix in SUFFIXES]


def layout(paths):
    """Lines that fprettify would write otherwise, but for the indent of continuation lines: it sets them below the last open
    bracket, where ours may stand at a step of indent so that rows of a table and long calls fit."""
    with tempfile.TemporaryDirectory() as folder:
        copies = [pathlib.Path(folder) / f"{k}{path.name}.f90" for k, path in enumerate(paths)]
        for path, copy in zip(paths, copies):
            shutil.copyfile(path, copy)
        # A line length that no line has: fprettify gives up the indent of a line that gets too long. fortitude knows ours.
        done = subprocess.run([BIN / "fprettify", "--silent", "--indent", "2", "--line-length", "1000", *copies],
                              capture_output=True, text=True)
        if done.returncode:
            raise CheckError(f"fprettify failed: {(done.stderr.strip().splitlines() or ['it did not say why'])[-1]}")
        for path, copy in zip(paths, copies):
            yield from differences(path, *(p.read_text(encoding="utf-8").splitlines() for p in (path, copy)))


def differences(path, ours, theirs):
    """What layout says of one file."""
    if len(ours) != len(theirs):
        yield path, 1, f"layout: expected {len(theirs)} lines as fprettify has it, found {len(ours)}"
        return
    continued = False
    for number, (own, other) in enumerate(zip(ours, theirs), 1):
        for error, right in ITS_ERRORS:
            own, other = error.sub(right, own), error.sub(right, other)
        indent_matters = not continued and not own.lstrip().startswith("&")
        if own != other if indent_matters else own.lstrip() != other.lstrip():
            yield path, number, f"layout: expected '{other}', found '{own}'"
        code = QUOTED_OR_COMMENT.sub(lambda part: "" if part[0].startswith("!") else "''", own).rstrip()
        continued = code.endswith("&") if code else continued


def lint():
    """What fortitude finds by the rules of tools/fortitude.toml."""
    done = subprocess.run([BIN / "fortitude", "--config", TREE / "tools" / "fortitude.toml", "check", "--output-format", "concise",
                           *FOLDERS], cwd=TREE, capture_output=True, text=True)
    found = re.findall(r"(?m)^(\S[^:\n]*):(\d+):\d+: (.*)$", done.stdout)
    if done.returncode not in (0, 1) or bool(done.returncode) != bool(found):
        raise CheckError(f"fortitude failed: {(done.stderr.strip().splitlines() or ['it did not say why'])[-1]}")
    for path, line, text in found:
        yield TREE / path, int(line), text


def types(tree):
    """What mypy finds in the typed modules of the package, where mypy is installed; a line says where it is not."""
    if not shutil.which("mypy"):
        print("check: mypy is not installed, so the types of the Python package are not checked", file=sys.stderr)
        return
    done = subprocess.run(["mypy", "--no-site-packages", "--ignore-missing-imports", "--follow-imports=silent", "--cache-dir", tree / "build" / "mypy",
                           *(word for name in TYPED for word in ("-p" if name in PACKAGES else "-m", name))],
                          cwd=tree, env=os.environ | {"MYPYPATH": str(tree / "tools")}, capture_output=True, text=True)
    found = re.findall(r"(?m)^(\S[^:\n]*):(\d+): error: (.*)$", done.stdout)
    if done.returncode not in (0, 1) or bool(done.returncode) != bool(found):
        raise CheckError(f"mypy failed: {((done.stderr or done.stdout).strip().splitlines() or ['it did not say why'])[-1]}")
    for path, line, text in found:
        yield tree / path, int(line), text


def findings():
    """All findings: path, line, text."""
    source = TREE / "src"
    yield from layout(sources())
    yield from lint()
    yield from types(TREE)
    arrows, sees = rooms.arrows(source), rooms.seen_by(source)
    yield from rooms.unlisted(arrows, sees)
    yield from rooms.unused(arrows, sees, source)
    procedures = measures.all_procedures(source)
    yield from measures.too_complex(procedures, source)
    yield from limits.beyond(limits.measured(procedures, source), limits.read())
    yield from parts.parts_given(sorted(source.rglob("*.f90")))
    yield from texts.made_in_constructors(sources())
    yield from prose.findings(TREE)


def table(source):
    """The figures of a folder src/."""
    found, arrows = measures.all_procedures(source), rooms.arrows(source)
    pairs = rooms.both_ways(arrows)
    large = measures.large(found)
    world, asked = measures.with_the_world(found), measures.rules_asked(source)
    print(f"{'procedures':<44}{len(found):>5}")
    for heading, rows in large.items():
        print(f"{heading:<44}{len(rows):>5}")
    guarded = [p for _, p in large[f"complexity over {measures.MOST_COMPLEXITY}"]
               if rooms.room_of(p.path, source) in measures.GUARDED_ROOMS]
    print(f"{'  of these in ' + ', '.join(measures.GUARDED_ROOMS):<44}{len(guarded):>5}")
    print(f"{'arrows from room to room':<44}{len(arrows):>5}")
    print(f"{'  of these with one back':<44}{2 * len(pairs):>5}")
    print(f"{'signatures with system, share and state':<44}{len(world):>5}")
    print(f"{'lines that ask for rules of contact':<44}{len(asked):>5}  outside {measures.RULES_FILE}, in "
          f"{len({path for path, _ in asked})} files")
    print()
    for line in rooms.picture(arrows, rooms.seen_by(source)):
        print(line)
    for heading, rows in large.items():
        print(f"\n{heading}")
        for number, p in rows:
            print(f"{number:>5}  {p.path.relative_to(source)}:{p.line}: {p.name}")
    print("\nsignatures with system, share and state")
    for p in world:
        print(f"       {p.path.relative_to(source)}:{p.line}: {p.name}")


def main():
    parser = argparse.ArgumentParser(prog="tools/check", description=__doc__)
    parser.add_argument("--table", nargs="?", const=TREE / "src", type=pathlib.Path, metavar="SOURCE",
                        help="print the figures of src/, or of the src/ of another tree, and check nothing")
    parser.add_argument("--lower", action="store_true", help="write the exceptions to the limits that have become smaller")
    parser.add_argument("--ablate", metavar="ROOM",
                        help="take out the rules of a folder of src/ one at a time, and tell which unit test notices each")
    given = parser.parse_args()
    try:
        if given.lower:
            limits.lower(limits.measured(measures.all_procedures(TREE / "src"), TREE / "src"), limits.read())
            return 0
        if given.ablate:
            return ablate.ablate(given.ablate, TREE)
        if given.table:
            if not given.table.is_dir():
                raise CheckError(f"{given.table}: expected a folder of sources, found none")
            table(given.table)
            return 0
        found = 0
        for path, line, text in findings():
            print(f"{path.relative_to(TREE)}:{line}: {text}", flush=True)
            found += 1
        print(f"{found} findings" if found else "check: layout, lint, rooms, complexity, arguments and words are as they should be")
        return 1 if found else 0
    except (CheckError, OSError, ValueError) as problem:
        print(f"tools/check: {problem}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
