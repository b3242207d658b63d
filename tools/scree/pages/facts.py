"""What a run came to, as rows and charts of a page."""
import numpy as np

from ..histories import COLUMNS, MEASURED, TIPS, axis_of, histories_of, is_static, names_of_histories
from ..units import number

SHARE = 0.01      # of what is compared with: an error above it is worth a look
TOO_FAR_OFF = 2   # times the error that was asked for: an estimate tells no more
BINS = 300        # over the time of a chart, each with the least and the largest of a series
MOST_LINES = 6    # of a chart, those of the largest at the end
OF_THE_SOLVER = {"asleep", "contacts", "deformation_iterations", "green_elements", "momentum", "open_close_iterations", "overlap", "rejected",
                 "solves", "stage", "step_size", "unbalanced", "unbalanced_block"}  # histories that tell how it was computed


def percent(share):
    return f"{100 * share:.3g} %"


def passed(results, units, time):
    """A time of the summary in words: that which has passed by then on the clock of the run."""
    ends, clock = np.append(0, results.history.time), np.append(0, results.clock)
    return units.quantity(float(np.interp(time, ends, clock) + max(0, time - ends[-1])), "time")


def since_restart(results, units):
    """Words for what is known of the last part of a run alone; none of a run that was not restarted."""
    said = results.summary
    begun = said["time"]["from"] if said else 0
    return f" since the restart at time {passed(results, units, begun)}" if begun > 0 else ""


def verdict(results, units):
    """How grave it is (good, look, bad), how the run ended, and remarks on what is worth a look."""
    status = results.scene.status
    level = {"complete": "good", "cut": "look", "running": "bad", "interrupted": "bad"}.get(status, "bad")
    words = {"complete": "The run is complete", "cut": "The model as set up, without a run", "interrupted": "The run was interrupted",
             "running": "The run goes on, or was killed"}.get(status, f"The run ended early: {status}")
    if results.n_frames and len(results.history.time) and not is_static(results):
        words += f", at time {units.quantity(float(results.clock[-1]), 'time')}"
    remarks = list(remarks_on(results, units))
    return "look" if remarks and level == "good" else level, f"{words}.", remarks


def remarks_on(results, units):
    """What is off by more than a hundredth."""
    history, summary = results.history, results.summary
    if not len(history.time):
        return
    growth = growth_of_areas(results)
    worst = growth[np.abs(growth).argmax()] if len(growth) else 0.0
    if abs(worst) > SHARE:
        yield f"The blocks {'grew' if worst > 0 else 'shrank'} by up to {percent(abs(worst))} of their area: small strain takes rotation for growth."
    if "overlap" in history:
        k = int(history.overlap.argmax())
        size, whose = size_of_overlapping(results)
        if history.overlap[k] > SHARE * size:
            yield (f"Contacts overlapped by up to {units.quantity(float(history.overlap[k]), 'length')}, "
                   f"{percent(history.overlap[k] / size)} of the size of {whose}, at time "
                   f"{units.quantity(float(results.clock[k]), 'time')}.")
    off, asked = estimated_error(results)
    if off > (TOO_FAR_OFF * asked if asked else SHARE):
        yield (f"The run estimates that its displacements are off by {percent(off)}" +
               (f"; step.accuracy asks for {percent(asked)}." if asked else "."))
    if summary and summary["energy"]["share_lost"] < -SHARE:
        yield f"Energy was made{since_restart(results, units)}: {percent(-summary['energy']['share_lost'])} of what there was to give."


def notes_on(results, units):
    """What a reader may take for a fault, and is none."""
    history = results.history
    again = int(history.rejected.sum()) if "rejected" in history else 0
    if again:
        yield (f"{counted(again, 'step was', 'steps were')} tried again with a smaller size, of {len(history.time)} steps taken. Steps are "
               "tried again where many contacts change at once; nothing is wrong with them.")
    before, area, names = there_in(results, 0), first_areas(results), results.stage_names
    for stage, there in blocks_of_stages(results).items():
        if gone := int((before & ~there).sum()):
            name = f"Stage {stage}" + (f" ({names[stage - 1]})" if names[stage - 1] != f"stage {stage}" else "")
            yield (f"{name} removed {counted(gone, 'block', 'blocks')} with an area of "
                   f"{units.quantity(float(area[before & ~there].sum()), 'length^2')}.")
        before = there


def counted(number, one, many):
    return f"{number} {one if number == 1 else many}"


def blocks_of_stages(results):
    """For each stage that has a frame, whether each block is there (n_blocks), or a stage has removed the block."""
    stages = results.frame_stages[:results.n_frames]
    return {int(stage): there_in(results, int(np.flatnonzero(stages == stage)[-1])) for stage in np.unique(stages)}


def there_in(results, frame):
    """Whether each block is there in a frame (n_blocks)."""
    there = np.zeros(results.n_blocks, bool)
    there[results.block[results.present(frame)] - 1] = True
    return there


def growth_of_areas(results):
    """Growth of the area of the blocks that are there, as a share of their area at the start, at each step of a stage that has a frame.
    Blocks that a stage has removed count in neither area."""
    history, area = results.history, results.bodies.area[0]
    stage = history.stage if "stage" in history else np.ones(len(history.time), int)
    growth = np.zeros(len(history.time))
    for number, there in blocks_of_stages(results).items():
        growth[stage == number] = history.area[stage == number] / area[there].sum() - 1
    return growth


def first_areas(results):
    """The area of each block in the first frame that it is in; 0 of one that never broke off."""
    area = results.bodies.area[:results.n_frames]
    return area[np.argmax(area > 0, axis=0), np.arange(results.n_blocks)]


def size_of_overlapping(results):
    """The size of the smaller one of the two blocks with the deepest overlap, and its name; of the smallest block where the run was
    killed, as nothing then says which two they were. The size is the square root of the area."""
    size = np.sqrt(first_areas(results))
    said = results.summary and results.summary["overlap"]
    if not said or not said["blocks"]:
        return size[size > 0].min(), "the smallest block"
    smaller = min(said["blocks"], key=lambda block: size[block - 1])
    return size[smaller - 1], f"block {smaller}"


def estimated_error(results):
    """The share of the displacement that the run estimates to be off by at its end, and what was asked for, 0 where nothing was."""
    if "error" not in results.history:
        return 0.0, 0.0
    said = (results.summary or {}).get("error")
    if said:
        return said["share"], said["asked"] or 0.0
    return float(results.history.error.share[-1]), 0.0


def outcome_rows(results, units):
    """What `scree run` says at its end, in rows of a name and words; nothing where the run was killed."""
    said = results.summary
    if said is None:
        return []

    def place(position):
        return f"({', '.join(units.quantity(x, 'length') for x in position)})"

    def where(name, dimension):
        found = said[name]
        return f"{units.quantity(found['largest'], dimension)}" + (
            f", block {found['block']} at {place(found['position'])}" if found["largest"] else "")

    time, steps = said["time"], said["steps"]
    rows = [("time", passed(results, units, time["reached"]) + (f" of {passed(results, units, time['asked'])}" if time["asked"] is not None else "")),
            ("steps", f"{steps['taken']} taken" + (f" of {number(steps['planned'])} planned" if steps["planned"] is not None else "") +
                      f", {steps['cut']} tried again with a smaller size; {steps['solves']} solves, {steps['factors']} factors"),
            ("largest displacement", where("displacement", "length")), ("largest speed", where("speed", "length/time"))]
    if said["at_rest"] is not None:
        rows.append(("at rest", "yes" if said["at_rest"] else "no"))
    if said["balance"]:
        rows.append(("unbalanced force", f"{number(said['balance']['share'])} of the forces on block {said['balance']['block']}; up to "
                                         f"{number(said['balance']['tolerance'])} counts as equilibrium"))
    rows.append(("area", f"{'shrank' if said['change_of_area'] < 0 else 'grew'} by {percent(abs(said['change_of_area']))}"))
    if said["overlap"]:
        deepest = said["overlap"]
        rows.append(("worst overlap", f"{units.quantity(deepest['largest'], 'length')} at time {passed(results, units, deepest['time'])}, "
                                      f"block {deepest['blocks'][0]} in block {deepest['blocks'][1]} at {place(deepest['position'])}"
                     if deepest["largest"] else "none"))
    lost = said["energy"]["lost_otherwise"]
    given, friction, damping, other = (units.quantity(abs(value), results.history.units("energy/kinetic"))
                                       for value in (*(said["energy"][name] for name in ("given", "friction", "damping")), lost))
    share = percent(abs(said["energy"]["share_lost"]))
    rows.append(("energy", f"{given} supplied; friction took {friction}, damping {damping}; " + (
        f"{other} ({share}) was gained, an error of the steps" if lost < 0 else
        f"{other} ({share}) was lost in {'static steps' if is_static(results) else 'impacts and steps'}")))
    return rows


def stage_rows(results, units):
    """The stages that the run was in: name, kind, how each ended, steps, times."""
    said = results.summary or {}
    return [(stage["name"], stage["kind"], stage["status"], f"{stage['steps']} steps",
             "" if stage["kind"] == "static" else f"{passed(results, units, stage['from'])} to {passed(results, units, stage['reached'])}")
            for stage in said.get("stages", [])]


def error_rows(results, units):
    """The estimate of the error at the end, where the run made one."""
    if "error" not in results.history:
        return []
    error = results.history.error
    return [(name, units.quantity(float(error[name][-1]), error.units(name)), error.description(name))
            for name in error if len(error[name])]


def energy_rows(results, units):
    """The books of energy at the end."""
    if not len(results.history.time):
        return []
    energy = results.history.energy
    return [(name, units.quantity(float(energy[name][-1]), energy.units(name)), energy.description(name)) for name in energy]


def cost_rows(results):
    """Phases, what they took first where it was most: seconds, share, how often."""
    if "cost/phase" not in results:
        return []
    cost = results.cost
    rows = zip(cost.phase, cost.wall_seconds, cost.share, cost.calls)
    return sorted(((phase, float(seconds), float(share), int(calls)) for phase, seconds, share, calls in rows), key=lambda row: -row[1])


def scene_rows(results):
    """What there is, and what it was made by."""
    scene = results.scene
    rows = [("blocks", str(results.n_blocks)), ("elements", str(results.n_elements)), ("frames", str(results.n_frames)),
            ("decks", ", ".join(scene.decks)), ("program", f"{scene.version}, {scene.compiler}, {scene.blas}"), ("date", scene.date)]
    return rows + ([("--set", ", ".join(scene.options))] if len(scene.options) else [])


def charts(results, units):
    """Panels of histories: of measured points first, of blocks and points those that moved or turned most; energies in one; those that tell
    how it was computed last."""
    history = results.history
    if not len(history.time):
        return []
    _, steps = axis_of(results, units, is_static(results))
    energies = {name: history.energy[name] for name in history.energy}
    if "gravity" in energies:  # its zero is that of y
        energies["gravity"] = energies["gravity"] - energies["gravity"][0]
    found = [chart(units, steps, "energies, of gravity its change", history.units("energy/kinetic"), list(energies.items()))
             | {"solver": False, "first": False}]
    for name in names_of_histories(results):
        if name == "time" or name.startswith("energy/"):
            continue
        for one in histories_of(results, name):
            chosen = np.argsort(-np.abs(one.values[-1]), kind="stable")[:MOST_LINES]
            found.append(chart(units, steps, one.description, one.dimension,
                               [(one.names[i], one.values[:, i]) for i in (np.sort(chosen) if name in COLUMNS else chosen)])
                         | {"solver": name in OF_THE_SOLVER, "first": name.startswith((MEASURED, TIPS)) or name == "support_force"})
    return sorted(found, key=lambda one: not one["first"])


def chart(units, steps, title, dimension, series):
    """A panel with as few steps, by where they are along its axis, as show what there is: in each bin the least and the largest of
    each series."""
    unit, factor = units.words(f"[{dimension}]")
    n = len(steps)
    rows = np.arange(n)
    if n > 2 * BINS:
        bins = np.array_split(rows, BINS)
        rows = np.unique([0, n - 1, *(b[0] + i for _, values in series for b in bins
                                      for i in (int(values[b].argmin()), int(values[b].argmax())))])
    return {"title": f"{title} {unit}", "steps": rounded(steps[rows]),
            "series": [{"name": name, "values": rounded(np.asarray(values, float)[rows] / factor)} for name, values in series]}


def rounded(values):
    return [float(f"{value:.8g}") for value in values]
