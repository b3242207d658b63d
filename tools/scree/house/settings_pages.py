"""The pages of doc/settings, one a group of an analysis deck, made of the two tables that `scree explain --settings` prints.

`tools/site --write` makes them. Each setting is a heading, so that it has an anchor and is found by its name.
"""
import itertools
import re

from ..program import TREE, call

OVERVIEW, FOLDER = TREE / "doc" / "settings.md", TREE / "doc" / "settings"

LEAST_NAMES = 3  # settings of a group that share a rule, from which on the page says the rule once, at its top

GROUPS = {
    "deck": "What belongs to the deck as a whole.",
    "units": "Names of the units that the numbers of a deck are in, for what prints them ([units](../howto/units.md)).",
    "stage": "Each `&stage` begins a part of the deck ([stages](../howto/stages.md)).",
    "method": "What is solved: blocks or a mesh, small or Green strain ([accuracy](../accuracy.md)).",
    "cover": "The mathematical mesh of the Numerical Manifold Method ([meshes](../howto/meshes.md)).",
    "integrator": "How a step goes from one time to the next ([vibration](../howto/vibration.md)).",
    "step": "Sizes of steps, and when a run ends ([step size](../howto/step-size.md), [static runs](../howto/static-runs.md)).",
    "iteration": "The iteration of the deformation within a step.",
    "contact": "Contact between bodies ([stiffness](../howto/stiffness.md), [restitution](../howto/restitution.md)).",
    "materials": "Numbers of the block materials, which replace numbers of the deck: one for each material.",
    "joints": "Joint materials: strength, which replaces numbers of the deck, and stiffness. Give one number for each material ([joints](../howto/joints.md), [stiffness](../howto/stiffness.md)).",
    "cracks": "When cracks that are drawn grow through a mesh ([how to](../howto/cracks.md)).",
    "fixed_points": "How fixed points and supports act.",
    "loads": "Forces at load points.",
    "blocks": "Blocks that are cut from lines.",
    "scene": "The part of the world that the run follows ([blocks that leave](../howto/restitution.md#blocks-that-leave)).",
    "bolts": "Rock bolts ([bolts](../howto/bolts.md)).",
    "bolt_row": "Rows of bolts along lines ([bolts](../howto/bolts.md#rows-and-rings)).",
    "bolt_ring": "Rings of bolts around circles ([bolts](../howto/bolts.md#rows-and-rings)).",
    "in_situ": "Stress before the run ([decks](../decks.md#stress-before-the-run)).",
    "excavation": "Rock that stages excavate ([stages](../howto/stages.md)).",
    "support": "Lines and points that support blocks ([decks](../decks.md#supports)).",
    "boundary": "Pressure and traction on edges ([decks](../decks.md#loads-on-edges)).",
    "water": "A water table ([water](../howto/water.md)).",
    "absorbing": "Edges that absorb waves, and incoming waves ([earthquakes](../howto/earthquakes.md)).",
    "gravity": "Growth of the weight.",
    "acceleration": "Acceleration of the ground ([earthquakes](../howto/earthquakes.md)).",
    "damping": "Damping in proportion to mass and stiffness ([vibration](../howto/vibration.md)).",
    "output": "What is written, and how often ([results](../results.md)).",
}


def tables(printed):
    """The rows of the two tables as lists of cells."""
    settings, rules = printed.strip().split("\n\n")
    return [[[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines()[2:]] for part in (settings, rules)]


def of_rule(cell):
    """What a rule names: pairs of a setting and the values that it is for, or nothing where it is for any."""
    words = cell.strip("`")
    name, is_value, values = words.partition("=")
    return [(name, values)] if is_value else [(one.strip(), "") for one in words.split(",")]


def condition(other):
    """What a setting needs, or what it does not go with, as the list names it."""
    other = re.sub(r"\w+\.\w+(?:='\w+'(?: or '\w+')*)?", r"`\g<0>`", other)
    return f"not with {other.removeprefix('without ')}" if other.startswith("without ") else f"only with {other.removeprefix('with ')}"


def of_several(group, settings, rules):
    """The rules that at least LEAST_NAMES settings of a group share, with the names of these settings."""
    for rule in rules:
        names = [name for name, value in of_rule(rule[0]) if not value and name in settings and name.split(".")[0] == group]
        if len(names) >= LEAST_NAMES:
            yield rule, names


def sentence(meaning):
    """A meaning with a capital and a full stop; what begins with the name of a number, as t or x1, keeps it."""
    return (meaning[0].upper() + meaning[1:] if re.match("[a-z]{2}", meaning) else meaning) + "."


def conditions(name, rules):
    """The lines of what a setting needs, and of what each of its values needs. Rules that follow each other with one reason are one line."""
    mine = [(value, why, other) for cell, other, why in rules for named, value in of_rule(cell) if named == name]
    lines, last = [], ""
    for (value, why, _), same in itertools.groupby(mine, key=lambda rule: (*rule[:2], rule[2].startswith("without "))):
        others = [other for _, _, other in same]
        text = condition(", ".join([others[0], *(re.sub("^with(?:out)? ", "", other) for other in others[1:])]))
        lines += [f"- `{value}`:"] * bool(value and value != last)
        lines.append(f"  - {text}: {why}" if value else f"- {text[0].upper()}{text[1:]}: {why}")
        last = value
    return lines


def pages(printed):
    """From the path of a page to its text."""
    settings, rules = tables(printed)
    settings = {row[0].strip("`"): row[1:] for row in settings}
    made = {}
    for group in dict.fromkeys(name.split(".")[0] for name in settings):
        lines = [f"# &{group}", "", GROUPS[group], ""]
        shared = list(of_several(group, settings, rules))
        count = sum(name.split(".")[0] == group for name in settings)
        for (_, other, why), names in shared:
            text = condition(other)
            whose = "all settings" if len(names) == count else ", ".join(name.split(".")[1] for name in names)
            lines.append(f"- {text[0].upper()}{text[1:]} ({why}): {whose}")
        lines += [""] * bool(shared)
        own = [rule for rule in rules if all(rule is not other for other, _ in shared)]
        for name, (values, unit, default, meaning) in settings.items():
            if name.split(".")[0] != group:
                continue
            lines += [f"## {name}", "", sentence(meaning), "", f"- Default: {default}"]
            lines += [f"- Values: {values}"] * bool(values) + [f"- Unit: {unit}"] * (unit not in ("", "1"))
            lines += [*conditions(name, own), ""]
        made[FOLDER / f"{group}.md"] = "\n".join(lines)
    made[OVERVIEW] = overview(list(settings))
    return made


def overview(names):
    """The page that lists all groups and names."""
    lines = ["# Settings", "", "Settings stand in named groups after the numbers of an analysis deck, or on the command line as",
             "`--set GROUP.NAME=VALUE`. A setting that contradicts another, or would do nothing, is refused with the reason that its page gives.",
             "`scree explain --settings` prints this list, `scree explain DECK` the values of a deck and where each comes from.", ""]
    for group in dict.fromkeys(name.split(".")[0] for name in names):
        within = ", ".join(f"[{name.split('.')[1]}](settings/{group}.md#{anchor(name)})" for name in names if name.split(".")[0] == group)
        lines.append(f"- [&{group}](settings/{group}.md): {within}")
    return "\n".join(lines) + "\n"


def anchor(name):
    """The anchor of a heading, as a forge makes it."""
    return re.sub(r"[^\w\- ]", "", name.lower()).replace(" ", "-")


def main():
    FOLDER.mkdir(exist_ok=True)
    made = pages(call("explain", "--settings").stdout)
    for path in set(FOLDER.glob("*.md")) - set(made):
        path.unlink()
    for path, text in made.items():
        path.write_text(text)


if __name__ == "__main__":
    main()
