"""The page: its parts in `page.html`, what they show from the results, the scripts that draw in it."""
import html
import importlib.resources
import json

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import to_hex

from .. import overlays
from ..conditions import BOLTS
from ..drawing import FIELDS, POINTS, ROCK, ROCKS, Look, limits_of, name_of, paler
from ..histories import LINES, axis_of, is_static
from ..overlays import Common, lengths_of, principal_values
from ..tips import INTENSITY, MOST_WORDS, TIP
from . import facts, modelled
from .frames import pack_frames
from .packing import Pack

SCRIPTS = ("packing.js", "scene.js", "player.js", "overlays.js", "charts.js", "page.js")
DASHES = {"-": [], ":": [2, 3]}  # of bolts, pixels


def page_of(file, units, title=None, project="", note=""):
    """The page of the frames of a results file, as text, its numbers in units; with a title, the opening comment of the deck by default, and
    with a project and a note where they are given."""
    results, pack = file.file, Pack()
    scene = pack_frames(file, pack, units)
    look = look_of(file, units)
    level, words, remarks = facts.verdict(results, units)
    parts = {
        "title": html.escape(title or modelled.title_of(results)), "project": paragraphs(project, note),
        "answers": answers(results, units), "modelled": what_is_modelled(results, units), "level": level, "verdict": html.escape(words), "remarks": listed(remarks) + listed(list(facts.notes_on(results, units)), "notes"),
        "fields": "".join(f"<option>{name}</option>" for name in FIELDS), "tables": tables(results, units), "decks": decks(results),
        "style": own("style.css"), "facts": as_json({"scene": scene, "arrays": pack.directory, "charts": facts.charts(results, units)}),
        "frames": pack.text(), "along": html.escape(axis_of(results, units, is_static(results))[0]),
        "scripts": f"const LOOK = {as_json(look)};\n" + "".join(own(name) for name in SCRIPTS)}
    first, *pieces = own("page.html").split("{{")
    return first + "".join(parts[name] + rest for name, rest in (piece.split("}}", 1) for piece in pieces))


def own(name):
    """A file beside this one."""
    return (importlib.resources.files(__package__) / name).read_text(encoding="utf-8")


def as_json(value):
    """JSON that cannot end the script that it stands in."""
    return json.dumps(value, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")


def look_of(file, units):
    """Colours and sizes, those of pictures (drawing.py, overlays.py), with limits and scales of all frames; what numbers are divided by."""
    frames = range(len(file.times))
    fields = {}
    for field in FIELDS:
        found = [file.values(frame, field) for frame in frames]
        low, high, colours = limits_of(np.concatenate([values for values, _ in found]), field, Look())
        fields[field] = {"limits": [float(low), float(high)], "map": colours, **in_units(found[0][1], units)}
    common = Common([(file, frame) for frame in frames], 1.0)
    measures = {"displacement": (lengths_of[overlays.displacements], "displacement [length]"),
                "velocity": (lengths_of[overlays.velocities], "velocity [length/time]"),
                "stress": (principal_values, "principal stress [force/length^2]"),
                "force": (overlays.measure_of_forces, "force of contact [force/length]")}
    return {
        "fields": fields,
        "rocks": rocks(file) if fields["material"]["map"] == ROCK else [],
        "maps": {name: {"full": hexes(plt.get_cmap(name)), "paler": hexes(plt.get_cmap(name) if name == ROCK else paler(name))} for name in {f["map"] for f in fields.values()}},
        "scales": {name: {"large": float(common.scale(measure, 1.0)[1]), **in_units(label, units)}
                   for name, (measure, label) in measures.items()},
        "states": {name: drawn(look) for name, look in overlays.STATES.items()}, "force": drawn(overlays.FORCE),
        "compression": drawn(overlays.COMPRESSION), "tension": drawn(overlays.TENSION),
        "points": [{"kind": kind, "name": name, "colour": to_hex(colour)} for kind, (name, _, colour) in POINTS.items()],
        "bolts": [{"name": name, "colour": to_hex(colour), "dash": DASHES[style]} for name, style, colour in BOLTS],
        "tip": {"colour": TIP, "most": MOST_WORDS, **in_units(INTENSITY.replace("$", ""), units)}, "lines": LINES, "sliding": overlays.SLIDING, "parallel": overlays.PARALLEL, "beside": overlays.BESIDE, "corner": overlays.CORNER,
        "cells": overlays.CELLS, "longest": overlays.LONGEST, "cross": overlays.CROSS, "many_blocks": overlays.MANY_BLOCKS}


def rocks(file):
    """Names and colours of the block materials that are there."""
    return [{"name": name_of(file, "rock", int(number)), "colour": ROCKS[int(number) - 1]} for number in np.unique(file.values(0, "material")[0])]


def in_units(label, units):
    """A label, its unit alone where it has a name, and what numbers are divided by."""
    label, factor = units.words(label)
    return {"label": label.replace("^2", "²").replace("^(1/2)", "^½"), "unit": " " + label[label.index("[") + 1:-1] if units.given and "[" in label else "",
            "factor": factor}


def hexes(colours):
    return [to_hex(colour) for colour in colours(np.linspace(0, 1, 256))]


def drawn(look):
    """The look of lines: widths in pixels, gaps of a dash in widths."""
    style = look.get("linestyles", "solid")
    return {"colour": to_hex(look["colors"]), "width": look["linewidths"] * 4 / 3, "dash": [] if style == "solid" else list(style[1])}


def listed(words, kind="remarks"):
    return f'<ul class="{kind}">' + "".join(f"<li>{html.escape(line)}</li>" for line in words) + "</ul>" if words else ""


def paragraphs(project, note):
    """The project and the note below the title."""
    return "".join(f'<p class="{name}">{html.escape(words)}</p>' for name, words in (("project", project), ("note", note)) if words)


def answers(results, units):
    """What a reader looks for first: what was found, and warnings."""
    warnings = f"<div><h2>Warnings{facts.since_restart(results, units)}</h2>{listed(results.warnings)}</div>" if results.warnings else ""
    return table("Results", modelled.answer_rows(results, units)) + warnings


def what_is_modelled(results, units):
    """What is modelled, how its stages ended, and the numbers of the input."""
    return "\n".join([table("What is modelled", modelled.modelled_rows(results, units)), table("Stages", facts.stage_rows(results, units)),
                      table("Input", modelled.input_rows(results, units))])


def table(title, rows, numbers=()):
    """A table below its title; nothing where it has no rows. Columns of numbers stand to the right."""
    if not rows:
        return ""
    lines = "".join("<tr>" + "".join(f'<td class="number">{html.escape(cell)}</td>' if i in numbers else f"<td>{html.escape(cell)}</td>"
                                     for i, cell in enumerate(row)) + "</tr>" for row in rows)
    return f"<div><h2>{html.escape(title)}</h2><table>{lines}</table></div>"


def tables(results, units):
    """What the run came to, and how it was computed."""
    since = facts.since_restart(results, units)
    cost = [(phase, f"{seconds:.3g} s", f"{calls} calls", share) for phase, seconds, share, calls in facts.cost_rows(results)]
    bars = "".join(f'<tr><td>{phase}</td><td class="number">{seconds}</td><td class="number">{calls}</td><td class="share">'
                   f'<div style="width:{100 * share:.1f}%"></div></td></tr>' for phase, seconds, calls, share in cost)
    return "\n".join([
        '<div class="columns">', table(f"What it came to{since}", facts.outcome_rows(results, units)),
        table("Energy at the end", facts.energy_rows(results, units), (1,)), table("Estimated error at the end", facts.error_rows(results, units), (1,)),
        f"<div><h2>Cost{since}</h2><table>{bars}</table></div>" if cost else "", table("Scene", facts.scene_rows(results)),
        table("Effects, and why", list(zip(results.scene.effects, results.scene.effect_reasons))), "</div>"])


def decks(results):
    """Decks and settings, folded."""
    scene = results.scene
    texts = [("Geometry deck", scene.geometry_deck), ("Analysis deck", scene.analysis_deck), ("Settings", "\n".join(scene.settings))]
    return "\n".join(f"<details><summary>{name}</summary><pre>{html.escape(as_one(text))}</pre></details>" for name, text in texts)


def as_one(text):
    return text if isinstance(text, str) else "\n".join(text)
