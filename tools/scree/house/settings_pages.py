"""The pages of doc/settings, one a group of an analysis deck, made of the two tables that `scree explain --settings` prints.

`tools/site --write` makes them. Each setting is a heading, so that it has an anchor and is found by its name.
"""
import re

from ..program import TREE, call

OVERVIEW, FOLDER = TREE / "doc" / "settings.md", TREE / "doc" / "settings"

GROUPS = {
    "deck": "What belongs to the deck as a whole.",
    "stage": "Each `&stage` begins a part of the deck ([stages](../howto/stages.md)).",
    "method": "What is solved: blocks or a mesh, small or Green strain ([accuracy](../accuracy.md)).",
    "cover": "The mathematical mesh of the Numerical Manifold Method ([meshes](../howto/meshes.md)).",
    "integrator": "How a step goes from one time to the next ([vibration](../howto/vibration.md)).",
    "step": "Sizes of steps, and when a run ends ([step size](../howto/step-size.md), [static runs](../howto/static-runs.md)).",
    "iteration": "The iteration of the deformation within a step.",
    "contact": "Contact between bodies ([stiffness](../howto/stiffness.md), [restitution](../howto/restitution.md)).",
    "materials": "Numbers of the block materials, in place of those of the deck.",
    "joints": "Joint materials: strength in place of that of the deck, and stiffness ([stiffness](../howto/stiffness.md)).",
    "fixed_points": "How fixed points and supports hold.",
    "loads": "Forces at load points.",
    "blocks": "Blocks that are cut from lines.",
    "bolts": "Rock bolts ([bolts](../howto/bolts.md)).",
    "support": "Lines that hold the edges of blocks ([decks](../decks.md#supports)).",
    "boundary": "Pressure and traction on edges ([decks](../decks.md#loads-on-edges)).",
    "water": "A water table ([water](../howto/water.md)).",
    "absorbing": "Edges that absorb waves, and waves that come in ([earthquakes](../howto/earthquakes.md)).",
    "gravity": "The weight, which the block materials give.",
    "acceleration": "Acceleration of the ground ([earthquakes](../howto/earthquakes.md)).",
    "damping": "Mass damping ([vibration](../howto/vibration.md)).",
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


def condition(value, other):
    """When a setting, or a value of it, may be given."""
    apart = other.startswith("without ")
    other = other.removeprefix("without ") if apart else other.removeprefix("with ")
    if value:
        return f"The value `{value}` does not go with {other}" if apart else f"The value `{value}` needs {other}"
    return f"Not with {other}" if apart else f"Only with {other}"


def pages(printed):
    """From the path of a page to its text."""
    settings, rules = tables(printed)
    made = {}
    for group in dict.fromkeys(row[0].strip("`").split(".")[0] for row in settings):
        lines = [f"# &{group}", "", GROUPS[group], ""]
        for name, values, unit, default, meaning in settings:
            name = name.strip("`")
            if name.split(".")[0] != group:
                continue
            lines += [f"## {name}", "", meaning[0].upper() + meaning[1:] + ".", "", f"- Default: {default}"]
            lines += [f"- Values: {values}"] * bool(values) + [f"- Unit: {unit}"] * (unit not in ("", "1"))
            for cell, other, why in rules:
                lines += [f"- {condition(value, other)}: {why}" for named, value in of_rule(cell) if named == name]
            lines.append("")
        made[FOLDER / f"{group}.md"] = "\n".join(lines)
    made[OVERVIEW] = overview(settings)
    return made


def overview(settings):
    """The page that lists all groups and names."""
    lines = ["# Settings", "", "Settings stand in named groups after the numbers of an analysis deck, or on the command line as",
             "`--set GROUP.NAME=VALUE`. A setting that contradicts another, or would do nothing, is refused with the reason that its page gives.",
             "`scree explain --settings` prints this list, `scree explain DECK` the values of a deck and where each comes from.", ""]
    names = [row[0].strip("`") for row in settings]
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
