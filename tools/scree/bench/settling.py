"""What a step of many blocks costs: scenes in sizes, a row each."""
import numpy as np

from ..arguments import say
from ..errors import RunFailed
from ..program import with_settings
from ..results import read
from . import factorisation, scenes
from .processes import start
from .tables import Table, growth

RUN_FAILED, BAD_INPUT = 1, 2  # exit statuses
COLUMNS = [
    ("scene", "scene", "", -24), ("blocks", "blocks", "d", 6), ("asked", "steps_asked", "d", 5), ("made", "steps", "d", 6),
    ("cut", "cuts", "d", 5), ("solves", "solves", "d", 7), ("factors", "factors", "d", 7),
    ("iter.", "iterations", "d", 6), ("judged", "judgements", "d", 7),
    ("reached", "time", ".4g", 7), ("s", "seconds", ".2f", 8), ("overlap", "overlap", ".1e", 8), ("gain", "energy_gain", ".0e", 6),
    ("travel", "travel", ".2e", 8), ("factor ms", "factor_ms", ".3f", 9), ("ratio", "ratio", ".0f", 7),
    ("growth", "growth", ".2f", 6), ("MB", "megabytes", ".0f", 5), ("", "ended", "", -8)]


def largest_gain(r, scene):
    """The most energy that a step made, over the work that the weight of all moving blocks could do across their height."""
    if not len(r.history.time):
        return None
    moving = r.material == scene.moving
    blocks = np.unique(r.block[moving])
    corners = np.concatenate([polygon for polygon, moves in zip(r.polygons(0), moving) if moves])
    scale = scene.weight * r.bodies.area[0, blocks - 1].sum() * np.ptp(corners[:, 1])
    return max(0.0, -np.diff(r.history.energy.dissipated, prepend=0.0).min() / scale)


def work_of(r):
    """Matrices factorised, those by LU among them, and iterations with such factors, where the results tell."""
    if "work" not in r.cost:
        return {"factors": None, "factors_by_lu": None, "iterations": None}
    count = dict(zip(r.cost.work, r.cost["count"].tolist()))
    return {"factors": count["factors by CHOLMOD"] + count["factors by LU"], "factors_by_lu": count["factors by LU"],
            "iterations": count["iterations of GMRES"]}


def figures(r, scene, step):
    """What the results of a run say, a row of the table."""
    history, place = r.history, r.bodies.centroid
    steps, overlap = len(history.time), float(history.overlap.max(initial=0.0))
    return {
        "scene": scene.name, "series": scene.series, "blocks": r.n_blocks, "edge": scene.edge, "step": step, "end": scene.end,
        "steps_asked": scene.steps(step), "steps": steps, "time": float(history.time[-1]) if steps else 0.0,
        "cuts": int(history.rejected.sum()), "solves": int(history.solves.sum()), **work_of(r),
        "judgements": int(history.open_close_iterations.sum()), "seconds": r.seconds("steps", "processor"),
        "overlap": overlap, "overlap_of_edge": overlap / scene.edge, "energy_gain": largest_gain(r, scene),
        "kinetic_at_end": float(history.energy.kinetic[-1]) if steps else None,
        "travel": float(np.linalg.norm(place[-1] - place[0], axis=1).max()),
        "status": r.scene.status, "ended": "" if r.scene.status == "complete" else r.scene.status.split(":")[0]}


def add_factor(row, r, program):
    """Adds what one factorisation takes, and the time of the run over it."""
    if program is None:
        return
    found = factorisation.factorise(program, *factorisation.pattern_of_run(r))
    row.update(unknowns=found.unknowns, factor_entries=found.factor_entries, analysis_ms=1000 * found.analysis,
               factor_ms=1000 * found.seconds, solution_ms=1000 * found.solution, ratio=row["seconds"] / found.seconds)


def run_scene(scene, given, folder):
    """The results of a scene, and the peak memory of its run in MB."""
    output = folder / f"{scene.name.replace(', ', '-').replace(' ', '-')}.h5"
    words = ["run", *scene.write(folder, given.step), "-o", output, "--quiet", *with_settings(given.set)]
    done = start(given.scree, *words, limit=given.limit)
    words = (done.said.splitlines() or [""])[-1].removeprefix("scree: ")
    if done.status == BAD_INPUT or not output.exists():
        raise RunFailed(words, done.status, done.said)
    if done.status == RUN_FAILED:
        say(f"{scene.name}: {words}")
    return read(output), done.megabytes


def measure(scene, given, folder):
    """The row of a scene, and its results."""
    r, megabytes = run_scene(scene, given, folder)
    row = figures(r, scene, given.step)
    add_factor(row, r, given.factor)
    row["megabytes"] = megabytes
    return row, r


def add_growth(row, before):
    """Adds the exponent of blocks by which the time grew since a row of the same series."""
    if before and before["series"] == row["series"] and "" == row["ended"] == before["ended"]:
        grown = growth([(before["blocks"], before["seconds"]), (row["blocks"], row["seconds"])], lambda pair: pair[1])[-1]
        row["growth"] = None if grown != grown else grown


def scenes_of(given):
    """The scenes of a case, in the order of the command line."""
    sizes = {"wall": scenes.wall, "column": scenes.column, "pyramid": scenes.pyramid}
    if given.name in sizes:
        return [sizes[given.name](size, given.edge, given.end) for size in given.sizes]
    if given.name == "rock":
        return [scenes.rock(kind, seed, given.end) for kind in given.kinds for seed in given.seeds]
    if given.name == "tunnel":
        return [scenes.tunnel(spacing) for spacing in given.spacings]
    return [scenes.slope(deck, motion == "static", given.end) for deck in given.decks for motion in given.motions]


def settling(given, folder):
    given.factor = factorisation.bench_factor(given.scree)
    table, before, program = Table(COLUMNS), None, {}
    for scene in scenes_of(given):
        row, r = measure(scene, given, folder)
        program = {name: r.scene[name] for name in ("version", "compiler", "blas")}
        add_growth(row, before)
        table.add(row)
        before = row
    if given.json:
        table.write(given.json, case=given.name, settings=given.set, limit=given.limit,
                    scree={"program": str(given.scree), **program})
