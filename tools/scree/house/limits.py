"""Limits on the size of procedures and modules, and the exceptions there are, in a table whose numbers may only fall.

The limits: lines of code of a procedure with those that it contains, names that a module makes public, and names that it imports.
"""
import pathlib

from .fortran import imported_names, module_of, public_names

LIMITS = {"lines": 150, "public": 15, "imports": 50}
TABLE = pathlib.Path(__file__).with_name("limits.txt")


def measured(procedures, source):
    """From a limit and a procedure or a module to the number that it has, and where it is: (limit, name) to (number, path, line)."""
    found = {("lines", p.full_name()): (p.all_lines, p.path, p.line) for p in procedures}
    for path in sorted(source.rglob("*.f90")):
        found["public", module_of(path)] = (public_names(path), path, 1)
        found["imports", module_of(path)] = (imported_names(path), path, 1)
    return found


def read(table=TABLE):
    """The exceptions: (limit, name) to number. Lines that begin with # are comments."""
    rows = (line.split() for line in table.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#"))
    return {(limit, name): int(number) for limit, name, number in rows}


def beyond(found, listed, table=TABLE):
    """What is beyond its limit, and exceptions that are larger than they need to be, as path, line, text."""
    for (limit, name), (number, path, line) in found.items():
        most = max(LIMITS[limit], listed.get((limit, name), 0))
        if number > most:
            yield path, line, f"{name} has {number} {limit}, above {most}: part it"
    for key, number in listed.items():
        now = found.get(key, (0,))[0]
        if now < number:
            yield table, 1, f"{' '.join(key)} is {now} and no longer {number}: let tools/check --lower write that"


def lower(found, listed, table=TABLE):
    """Writes the table anew: exceptions with the smaller number, without those that keep the limit now."""
    head = [line for line in table.read_text(encoding="utf-8").splitlines() if line.startswith("#")]
    now = {key: min(number, found.get(key, (0,))[0]) for key, number in listed.items()}
    rows = [f"{limit} {name} {number}" for (limit, name), number in sorted(now.items()) if number > LIMITS[limit]]
    table.write_text("\n".join(head + rows) + "\n", encoding="utf-8")
