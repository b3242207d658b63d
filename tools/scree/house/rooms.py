"""The rooms of the house: the folders of src/, and who uses whom.

src/CMakeLists.txt declares each room by `scree_room(NAME SEES ROOM ...)`, ground floor first. The build makes a library of each, and
lets it see only the rooms in its list. What lies in src/ itself (the program and its parts) sees all of them.
"""
import collections
import re

from .fortran import module_of, modules_used

TOP = "src"
ROOM = re.compile(r"(?m)^scree_room\(\s*(\w+)(?:\s+SEES\s+([^)]*))?\)")


def seen_by(source):
    """From each room, ground floor first, to the list of the rooms that it may see; the program is last."""
    found = ROOM.findall((source / "CMakeLists.txt").read_text(encoding="utf-8"))
    if not found:
        raise ValueError(f"{source}/CMakeLists.txt: expected scree_room(NAME SEES ROOM ...), found none")
    return {room: sees.split() for room, sees in found} | {TOP: [room for room, _ in found]}


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


def unlisted(found, sees):
    """The places of `use` of a room that is not in the list of the room that uses it, as path, line, text."""
    for (a, b), places in sorted(found.items()):
        for path, line, module in places:
            if a not in sees or b not in sees:
                yield path, line, f"src/CMakeLists.txt declares no room '{a if a not in sees else b}'"
            elif b not in sees[a]:
                yield path, line, f"{a} uses {module} of {b}, which its SEES in src/CMakeLists.txt does not list"


def unused(found, sees, source):
    """Rooms in a list that the room with the list does not use, as path, line, text."""
    path = source / "CMakeLists.txt"
    text = path.read_text(encoding="utf-8")
    for room in ROOM.finditer(text):
        for seen in sees[room[1]]:
            if (room[1], seen) not in found:
                yield path, text.count("\n", 0, room.start()) + 1, f"room {room[1]} uses nothing of {seen}, which its SEES lists"


def picture(found, order):
    """Lines that show each room with those that it uses, and how often."""
    for room in order:
        used = [f"{b} {len(found[room, b])}{' <->' if (b, room) in found else ''}" for b in order if (room, b) in found]
        yield f"{room:<12} -> {', '.join(used) or 'none'}"
