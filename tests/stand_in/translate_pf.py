#!/usr/bin/env python3
"""Translates pFUnit test files (.pf) to a Fortran program for the stand-in module funit.

    translate_pf.py TESTS.pf PROGRAM.F90

Knows @test, @before, @after and the asserts of funit.f90, each alone on one line, as pFUnit
wants them. Anything else that begins with @ is an
error with file and line. Line numbers of compiler messages are those of the .pf file.
"""
import pathlib
import re
import sys

ASSERTS = ("assertEqual", "assertTrue", "assertFalse", "assertLessThan", "assertGreaterThan", "assertLessThanOrEqual",
           "assertGreaterThanOrEqual")


class TranslationError(Exception):
    """What is wrong, with file and line."""


def translate(path):
    """The Fortran of one .pf file: its module, and a program that runs its tests."""
    lines = path.read_text().splitlines()
    module = None
    procedures = {"test": [], "before": [], "after": []}
    pending = None
    out = []
    for number, line in enumerate(lines, 1):
        def wrong(what):
            return TranslationError(f"{path}:{number}: {what}")

        directive = re.match(r"\s*@(\w+)\s*(.*)$", line)
        if found := re.match(r"\s*module\s+(?!procedure\b)(\w+)\s*$", line, re.I):
            module = module or found.group(1)
        if pending and (found := re.match(r"\s*subroutine\s+(\w+)", line, re.I)):
            procedures[pending].append(found.group(1))
            pending = None
        elif pending and line.strip() and not line.strip().startswith("!"):
            raise wrong(f"expected a subroutine after @{pending}, found '{line.strip()}'")
        if not directive:
            out.append(line)
            continue
        name, rest = directive.groups()
        if name in procedures:
            if pending:
                raise wrong(f"expected a subroutine after @{pending}, found @{name}")
            pending = name
            out.append("")
        elif name in ASSERTS:
            arguments = re.match(r"\((.*)\)\s*$", rest)
            if not arguments:
                raise wrong(f"expected @{name}(...) alone on one line, found '{line.strip()}'")
            out += [f"    call {name}({arguments.group(1)}, &",
                    f"      location=source_location_t('{path.name}', {number}))",
                    f"    if (anyExceptions()) return",
                    f'#line {number + 1} "{path.name}"']
        else:
            raise wrong(f"expected a directive that the stand-in knows, found @{name}")
    if not module or not procedures["test"]:
        raise TranslationError(f"{path}: expected a module with an @test, found none")
    return "\n".join([f'#line 1 "{path.name}"', *out, *driver(module, procedures)]) + "\n"


def driver(module, procedures):
    """The program: @before, the test and @after for each test, then the verdict."""
    yield f"program run_{module}"
    yield "  use funit, only: begin_test, end_test, end_tests"
    yield f"  use {module}"
    yield "  implicit none"
    for test in procedures["test"]:
        yield f"  call begin_test('{test}')"
        yield from (f"  call {name}()" for name in procedures["before"])
        yield f"  call {test}()"
        yield from (f"  call {name}()" for name in procedures["after"])
        yield "  call end_test()"
    yield "  call end_tests()"
    yield f"end program run_{module}"


def main():
    source, target = map(pathlib.Path, sys.argv[1:3])
    try:
        target.write_text(translate(source))
    except TranslationError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
