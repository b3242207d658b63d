"""The rooms of the house: the folders of src/, and who uses whom.

Each room sees those before it in the list `scree_rooms` of src/CMakeLists.txt, by which the build makes one library a room. What
lies in src/ itself (the program and its parts) is above all of them.
"""
import collections
import re

from .fortran import module_of, modules_used

TOP = "src"


def order_of(source):
    """The rooms from the ground floor up."""
    found = re.search(r"set\(\s*scree_rooms\s+([^)]*)\)", (source / "CMakeLists.txt").read_text(encoding="utf-8"))
    if not found:
        raise ValueError(f"{source}/CMakeLists.txt: expected set(scree_rooms ...), found none")
    return re.sub(r"#.*", "", found[1]).split() + [TOP]


def room_of(path, source):
    """The name of the room that a file lies in."""
    inner = path.relative_to(source).parts
    return inner[0] if len(inner) > 1 else TOP


def arrows(source):
    """From a room and the room that it uses, to the places of the `use`: path, line, module."""
    paths = sorted(source.rglob("*.f90"))
    home = {module_of(path): room_of(path, source) for path in paths}
    found = collections.defaultdict(list)
    for path in paths:
        for line, module in modules_used(path):
            a, b = room_of(path, source), home.get(module)
            if b and a != b:
                found[a, b].append((path, line, module))
    return found


def both_ways(found):
    """Pairs of rooms that use each other."""
    return sorted((a, b) for a, b in found if a < b and (b, a) in found)


def against_order(found, order):
    """The places of `use` that look up, as path, line, text; and rooms that have no place in the order."""
    floor = {room: k for k, room in enumerate(order)}
    for (a, b), places in sorted(found.items()):
        for path, line, module in places:
            if a not in floor or b not in floor:
                lost = a if a not in floor else b
                yield path, line, f"room '{lost}' is not in the list scree_rooms of src/CMakeLists.txt"
            elif floor[b] > floor[a]:
                yield path, line, f"{a} uses {module} of {b}, which is above it"


def picture(found, order):
    """Lines that show each room with those that it uses, and how often."""
    for room in order:
        used = [f"{b} {len(found[room, b])}{' <->' if (b, room) in found else ''}" for b in order if (room, b) in found]
        yield f"{room:<12} -> {', '.join(used) or 'none'}"
