"""What is modelled, the numbers of the input with their units, and the answers that a reader looks for first, as rows of a page."""
from __future__ import annotations

import itertools
import re

import numpy as np

from ..errors import ScreeError
from ..in_force import numbers, settings_of_frame
from ..model import Model
from ..model.views import model_of
from ..results import Results
from ..units import Units

MOST_PAIRS = 6  # of measured points, whose closures are listed
MOST_TIPS = 20  # of cracks that grew
LAWS = (("kn", "kn", "force/length^3"), ("ks", "ks", "force/length^3"), ("residual_phi", "residual friction", "degree"), ("jrc", "JRC", ""),
        ("dilation", "dilation", "degree"))
METHODS = {"dda": "blocks with one strain each (DDA)", "nmm": "blocks under a mesh (Numerical Manifold Method)"}


def model_or_none(results: Results) -> Model | None:
    """The model of the decks; None where no model reads them."""
    try:
        return model_of(results)
    except ScreeError:
        return None


def title_of(results: Results) -> str:
    """The first sentence of the opening comment of the analysis deck; the name of the file where there is none."""
    model = model_or_none(results)
    words = model.title.strip().split("\n\n")[0].replace("\n", " ") if model else ""
    return re.split(r"(?<=[.!?])\s", words)[0].rstrip(".") or results.path.stem


def modelled_rows(results: Results, units: Units) -> list[tuple[str, str]]:
    """What is modelled: rock, size, kind of run, stages, what acts."""
    settings, size = settings_of_frame(results, 0), np.ptp(results.vertices(0), axis=0)
    rows = [("model", f"{blocks_in_words(results)}, {' × '.join(units.quantity(float(side), 'length') for side in size)}, "
                      f"plane {settings.get('method.plane', 'stress')}"),
            ("method", METHODS[settings.get("method.model", "dda")])]
    static = [results.is_static(int(frame)) for frame in range(results.n_frames)] if len(results.history.time) else []
    if static:
        rows.append(("run", "static, to equilibrium" if all(static) else "dynamic" if not any(static) else "static and dynamic stages"))
    if names := results.stage_names:
        rows.append(("stages", "; ".join(names)))
    acting = {"stress in the ground": "in_situ.k0", "water": "water.table", "pressure or traction on edges": "boundary.lines",
              "forces on points": "loads.force", "moved supports": "support.moved", "acceleration of the ground": "acceleration.table",
              "record of the ground": "acceleration.file", "absorbing edges": "absorbing.lines",
              "free fields at the sides": "absorbing.sides", "absorbing base": "absorbing.base"}
    last = settings | settings_of_frame(results, -1)
    found = ["weight"] if "gravity" in results.history.energy else []
    found += [what for what, name in acting.items() if last.get(name, "none") != "none"]
    if "bolts" in results:
        found.append(f"{results.bolts.force.shape[1]} bolts")
    rows.append(("what acts", ", ".join(found) or "nothing"))
    return rows


def blocks_in_words(results: Results) -> str:
    """How many blocks there are at the start, and at the end where that is another number."""
    counts = [results.n_blocks] * 2
    if "present" in results.bodies:
        counts = [int(results.bodies.present[frame].sum()) for frame in (0, -1)]
    first = f"{counts[0]} block{'s' * (counts[0] != 1)}"
    return first if counts[0] == counts[1] else f"{first}, {counts[1]} at the end"


def input_rows(results: Results, units: Units) -> list[tuple[str, str]]:
    """The numbers of block materials, joint materials and water, as the first stage has them."""
    model = model_or_none(results)
    if model is None:
        return []
    settings = settings_of_frame(results, 0)
    rows = []
    changed = {name: numbers(settings, f"materials.{name}") for name in ("young", "poisson", "unit_weight")}
    for k, (name, rock) in enumerate(model.materials.items()):
        young, poisson, weight = (values[k] if (values := changed[key]) else getattr(rock, key) for key in ("young", "poisson", "unit_weight"))
        rows.append((f"rock {name}", f"{density_of(rock, units)}unit weight {units.quantity(weight, 'force/length^3')}, "
                                     f"E = {units.quantity(young, 'force/length^2')}, Poisson's ratio {poisson:g}"))
    changed = {name: numbers(settings, f"joints.{name}") for name in ("phi", "cohesion", "tensile_strength")}
    for k, (name, joint) in enumerate(model.joint_materials.items()):
        phi, cohesion, tension = (values[k] if (values := changed[key]) else getattr(joint, key) for key in changed)
        words = (f"friction {phi:g}°, cohesion {units.quantity(cohesion, 'force/length^2')}, "
                 f"tensile strength {units.quantity(tension, 'force/length^2')}")
        for law, what, dimension in LAWS:
            if (values := numbers(settings, f"joints.{law}")) and values[k] > 0:
                words += f", {what} {values[k]:g}°" if dimension == "degree" else f", {what} {units.quantity(values[k], dimension)}"
        rows.append((f"joint {name}", words))
    if weight := numbers(settings, "water.unit_weight"):
        rows.append(("water", f"unit weight {units.quantity(weight[0], 'force/length^3')}"))
    if options := [str(one) for one in np.ravel(results.scene.options)]:
        rows.append(("changed for this run", ", ".join(options)))
    return rows


def density_of(rock, units: Units) -> str:
    """The density of a rock in words; nothing where no name of a time makes it a number to read."""
    if units.given and units.bases[-1][0] == "time":
        return ""
    return f"density {units.quantity(rock.density, 'mass/length^3')}, "


def answer_rows(results: Results, units: Units) -> list[tuple[str, str]]:
    """Displacements of measured points and closures between them, forces of bolts, reactions of supports, and cracks that grew, at the end."""
    if not len(results.history.time):
        return []
    model = model_or_none(results)
    return [*point_rows(results, model, units), *bolt_rows(results, units), *reaction_rows(results, model, units),
            *growth_rows(results, units)]


def pair(values: np.ndarray, dimension: str, units: Units) -> str:
    """Two numbers in brackets."""
    return f"({', '.join(units.quantity(float(value), dimension) for value in values)})"


def point_rows(results: Results, model: Model | None, units: Units):
    """Displacement of each measured point, and how much nearer each two of a few have come."""
    places = results.given_points("measured")
    if not len(places):
        return
    names = [row.name for row in model.geometry.measured] if model else []
    names = [name or f"point {k}" for k, name in enumerate(names if len(names) == len(places) else [""] * len(places), 1)]
    moved = results.measured_points.displacement[-1]
    for name, place, way in zip(names, places, moved):
        yield f"displacement of {name} at {pair(place, 'length', units)}", (f"{units.quantity(float(np.linalg.norm(way)), 'length')}, "
                                                                         f"{pair(way, 'length', units)}")
    now = results.measured_points.position[-1]
    pairs = list(itertools.combinations(range(len(places)), 2))
    for i, k in pairs if len(pairs) <= MOST_PAIRS else ():
        closer = np.linalg.norm(places[i] - places[k]) - np.linalg.norm(now[i] - now[k])
        yield f"closure between {names[i]} and {names[k]}", units.quantity(float(closer), "length")


def bolt_rows(results: Results, units: Units):
    """The largest tension of a bolt, and how many have yielded or broken."""
    if "bolts" not in results:
        return
    force, state = results.bolts.force[-1], results.bolts.state[-1]
    if len(force):
        yield "bolts", (f"at most {units.quantity(float(force.max()), results.bolts.units('force'))}; {int((state == 1).sum())} have yielded, "
                        f"{int((state == 2).sum())} have broken")  # noqa: PLR2004  states


def reaction_rows(results: Results, model: Model | None, units: Units):
    """The force of each named support on the rock, of static runs of blocks."""
    if model is None or not results.is_static(-1):
        return
    names = {row.name for row in model.geometry.fixed}
    for hold in ("normal", "x", "y", "both"):
        setting = model.in_force(f"support.{hold}")
        names |= {name for _, name in setting.rows(4)} if setting else set()
    for name in sorted(filter(None, names)):
        try:
            force = results.support(name).reaction
        except ScreeError:  # forces that results do not hold
            return
        yield f"reaction of {name}", pair(force, results.history.units("energy/kinetic").replace("*length", "", 1), units)


def growth_rows(results: Results, units: Units):
    """How far the crack of each tip grew, from where to where, and when."""
    if "growth" not in results:
        return
    growth, clock = results.growth, np.append(0, results.clock)
    when = np.interp(growth.time[()], np.append(0, results.history.time), clock)
    for tip in np.unique(growth.tip)[:MOST_TIPS]:
        own = np.flatnonzero(growth.tip[()] == tip)
        length = np.linalg.norm(growth.end[own] - growth.start[own], axis=1).sum()
        yield f"growth of crack tip {tip}", (f"{units.quantity(float(length), 'length')} from {pair(growth.start[own[0]], 'length', units)} to "
                                             f"{pair(growth.end[own[-1]], 'length', units)}, time {units.quantity(float(when[own[0]]), 'time')} to "
                                             f"{units.quantity(float(when[own[-1]]), 'time')}")
