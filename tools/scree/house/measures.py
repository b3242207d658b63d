"""Procedures in numbers: own lines, arguments, complexity; and what the redesign of the rooms counts."""
import re

from .fortran import procedures, statements
from .rooms import room_of

MOST_OWN_LINES, MOST_ARGUMENTS, MOST_COMPLEXITY = 60, 7, 15

# Rooms in which no procedure may pass MOST_COMPLEXITY, but these for now: who mends one takes it off the list, which
# may only shrink.
GUARDED_ROOMS = ("joints", "contact", "restitution", "accuracy", "stepping")
STILL_COMPLEX = set()

# Components that say by whose rules contact goes; `contact_rules` alone is to ask for them.
RULES = re.compile(r"%\s*(lags|conserving|by_name|adapts|outside|anchored|bends)\b")
RULES_FILE = "contact_rules.f90"
WORLD = {"system", "share", "state"}


def all_procedures(source):
    return [p for path in sorted(source.rglob("*.f90")) for p in procedures(path)]


def large(found):
    """From a heading to the procedures that pass a limit, as (number, procedure), the largest first."""
    def over(limit, number):
        return sorted(((number(p), p) for p in found if number(p) > limit), key=lambda row: (-row[0], row[1].full_name()))

    return {f"over {MOST_OWN_LINES} own lines": over(MOST_OWN_LINES, lambda p: p.own_lines),
            f"over {MOST_ARGUMENTS} arguments": over(MOST_ARGUMENTS, lambda p: len(p.arguments)),
            f"complexity over {MOST_COMPLEXITY}": over(MOST_COMPLEXITY, lambda p: p.complexity)}


def with_the_world(found):
    """Procedures that carry system, share and state side by side."""
    return [p for p in found if WORLD <= set(p.arguments)]


def rules_asked(source):
    """Places outside RULES_FILE that ask by whose rules contact goes: path, line."""
    return [(path, s.line) for path in sorted(source.rglob("*.f90")) if path.name != RULES_FILE
            for s in statements(path) if RULES.search(s.text)]


def too_complex(found, source, allowed=frozenset(STILL_COMPLEX)):
    """What a guarded room may not have, as path, line, text: a procedure that is too complex, or an exception without need."""
    for p in found:
        guarded, complex_ = room_of(p.path, source) in GUARDED_ROOMS, p.complexity > MOST_COMPLEXITY
        if guarded and complex_ and p.full_name() not in allowed:
            yield p.path, p.line, f"{p.name} has complexity {p.complexity}, above {MOST_COMPLEXITY}: part it"
    needed = {p.full_name() for p in found if p.complexity > MOST_COMPLEXITY}
    for name in sorted(set(allowed) - needed):
        yield source, 0, f"{name} is no longer too complex: take it off STILL_COMPLEX in tools/scree/house/measures.py"
