"""Layers of a joint map: the role that each has by its name or by the option --layer (doc/drawings.md)."""
import collections
import math
import re

from .shapes import Line, MapError, Point

LINE_KINDS = ("boundary", "joint", "material", "tunnel", "stage")  # with a number each
POINT_KINDS = ("load", "measured", "hole")
NAMED_KINDS = {"boundar": "boundary", "joint": "joint", "material": "material", "fixed": "fixed", "tunnel": "tunnel",
               "excavation": "tunnel", "bolt": "bolt", "water": "water", "stage": "stage"
               } | {kind: kind for kind in POINT_KINDS}  # by the beginnings of names
NUMBERED = re.compile(f"(?:(?:{'|'.join(NAMED_KINDS)})[a-z]*[ _.-]*)?([0-9]+)")  # names whose number is that of a material or stage
ROLES = ("joint:N, boundary:N, material:N, tunnel:N, stage:K, bolt:STIFFNESS[:STRENGTH[:PRETENSION]], water, fixed, load, measured, "
         "hole or skip")
LARGEST_NUMBER = 2**31 - 1

Role = collections.namedtuple("Role", "kind number bolt", defaults=[None])  # number: of a material; bolt: e0 t0 f0 of a deck


def shown(text):
    """A text of the drawing, fit for one line."""
    return "".join(letter if letter.isprintable() else "?" for letter in str(text))


def in_order(layer):
    """Key of the order of names: 2 comes before 10."""
    return [int(part) if part.isdecimal() else part for part in re.split("([0-9]+)", layer)]


def role_by_name(name, areas=False):
    """The role that a layer's name says; else outlines of areas are boundary lines and other lines joints. Its number is that of a
    name of one word and a number, or of a number alone; else 0."""
    kind = next((kind for word, kind in NAMED_KINDS.items() if name.lower().startswith(word)), "boundary" if areas else "joint")
    found = NUMBERED.fullmatch(name.lower())
    number = int(found[1]) if found and kind in LINE_KINDS else 0
    return Role(kind, number if number <= LARGEST_NUMBER else 0)


def chosen_roles(words, drawing):
    """The roles that the options --layer give, by layer."""
    roles = {}
    for word in words:
        name, _, role = word.rpartition("=")
        found = re.fullmatch("(joint|boundary|material|tunnel|stage):([0-9]{1,10})|(fixed|load|measured|hole|water|skip)", role.lower())
        bolt = bolt_of(role.lower())
        if not name or not (found or bolt) or found and found[2] and not 1 <= int(found[2]) <= LARGEST_NUMBER:
            raise MapError(f"--layer: expected NAME=ROLE with ROLE one of {ROLES} (N from 1), found '{shown(word)}'")
        if name.lower() not in drawing.names:
            raise MapError(f"{drawing.path}: expected a layer of the name '{shown(name)}' (--layer), found "
                           + ", ".join(f"'{shown(drawing.names[layer])}'" for layer in sorted(drawing.names, key=in_order)))
        if name.lower() in roles:
            raise MapError(f"--layer: expected one role for the layer '{shown(name)}', found two")
        roles[name.lower()] = Role("bolt", 0, bolt) if bolt else Role(found[1] or found[3], int(found[2] or 0))
    return roles


def bolt_of(role):
    """Stiffness, strength and pretension of a role bolt:...; None where it is another, or they are no such numbers."""
    kind, *words = role.split(":")
    try:
        numbers = [float(word) for word in words]
    except ValueError:
        return None
    whole = kind == "bolt" and 1 <= len(numbers) <= 3 and numbers[0] > 0 and all(0 <= number < math.inf for number in numbers)
    return tuple((numbers + [0.0, 0.0])[:3]) if whole else None


def wanted(role, shapes):
    """The shapes of an entity that a layer of a role takes."""
    points = [shape for shape in shapes if isinstance(shape, Point)]
    curves = [shape for shape in shapes if not isinstance(shape, Point)]
    if role.kind == "bolt":
        return curves if len(curves) == 1 and isinstance(curves[0], Line) else []
    return points if role.kind in POINT_KINDS else points or curves if role.kind == "fixed" else curves


def role_words(role):
    """What the layer of a role is for."""
    return "points" if role.kind in POINT_KINDS else "straight lines" if role.kind == "bolt" else "lines"
