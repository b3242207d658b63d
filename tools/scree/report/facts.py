"""What a run came to, as rows and charts of a page."""
import numpy as np

from ..histories import COLUMNS, axis_of, histories_of, is_static, names_of_histories
from ..units import number

SHARE = 0.01      # of what is compared with: an error above it is worth a look
BINS = 300        # over the time of a chart, each with the least and the largest of a series
MOST_LINES = 6    # of a chart, those of the largest at the end


def percent(share):
    return f"{100 * share:.3g} %"


def since_restart(results, units):
    """Words for what is known of the last part of a run alone; none of a run that was not restarted."""
    said = results.summary
    begun = said["time"]["from"] if said else 0
    return f" since the restart at time {units.quantity(float(begun), 'time')}" if begun > 0 else ""


def verdict(results, units):
    """How grave it is (good, look, bad), how the run ended, and remarks on what is worth a look."""
    status = results.scene.status
    level = {"complete": "good", "cut": "look", "running": "bad", "interrupted": "bad"}.get(status, "bad")
    words = {"complete": "The run is complete", "cut": "The model as set up, without a run", "interrupted": "The run was interrupted",
             "running": "The run goes on, or was killed"}.get(status, f"The run ended early: {status}")
    if results.n_frames and len(results.history.time):
        words += f", at time {units.quantity(float(results.history.time[-1]), 'time')}"
    remarks = list(remarks_on(results, units))
    return "look" if remarks and level == "good" else level, f"{words}.", remarks


def remarks_on(results, units):
    """What is off by more than a hundredth."""
    history, summary = results.history, results.summary
    if not len(history.time):
        return
    before, area = results.bodies.area[0].sum(), history.area
    if np.abs(area / before - 1).max() > SHARE:
        yield f"The area of all blocks changed by up to {percent(np.abs(area / before - 1).max())}: small strain takes rotation for growth."
    if "overlap" in history:
        size, k = np.sqrt(results.bodies.area[0].min()), int(history.overlap.argmax())
        if history.overlap[k] > SHARE * size:
            yield (f"Contacts overlapped by up to {units.quantity(float(history.overlap[k]), 'length')}, "
                   f"{percent(history.overlap[k] / size)} of the size of the smallest block, at time "
                   f"{units.quantity(float(history.time[k]), 'time')}.")
    if "error" in history and history.error.share.max() > SHARE:
        yield f"Steps are estimated to be off by up to {percent(history.error.share.max())} of the displacement."
    if summary and summary["energy"]["share_lost"] < -SHARE:
        yield f"Energy was made{since_restart(results, units)}: {percent(-summary['energy']['share_lost'])} of what there was to give."
    cut = int(history.rejected.sum())
    if cut > SHARE * len(history.time):
        yield f"{cut} tries of steps were cut, of {len(history.time)} steps taken."


def outcome_rows(results, units):
    """What `scree run` says at its end, in rows of a name and words; nothing where the run was killed."""
    said = results.summary
    if said is None:
        return []

    def place(position):
        return f"({', '.join(units.quantity(x, 'length') for x in position)})"

    def where(name, dimension):
        found = said[name]
        return f"{units.quantity(found['largest'], dimension)}, block {found['block']} at {place(found['position'])}"

    rows = [("time", f"{units.quantity(said['time']['reached'], 'time')} of {units.quantity(said['time']['asked'], 'time')}"),
            ("steps", f"{said['steps']['taken']} taken of {number(said['steps']['planned'])} planned, {said['steps']['cut']} tries cut, "
                      f"{said['steps']['solves']} solves, {said['steps']['factors']} factors"),
            ("farthest vertex", where("displacement", "length")), ("fastest vertex", where("speed", "length/time"))]
    if said["at_rest"] is not None:
        rows.append(("at rest", "yes" if said["at_rest"] else "no"))
    if said["balance"]:
        rows.append(("out of balance", f"{number(said['balance']['share'])} of what acts on block {said['balance']['block']}; up to "
                                       f"{number(said['balance']['tolerance'])} is equilibrium"))
    rows.append(("area", f"changed by {percent(said['change_of_area'])}"))
    if said["overlap"]:
        deepest = said["overlap"]
        rows.append(("worst overlap", f"{units.quantity(deepest['largest'], 'length')} at time {units.quantity(deepest['time'], 'time')}, "
                                      f"block {deepest['blocks'][0]} in block {deepest['blocks'][1]} at {place(deepest['position'])}"
                     if deepest["largest"] else "none"))
    given, friction, damping, lost = (units.quantity(said["energy"][name], results.history.units("energy/kinetic"))
                                      for name in ("given", "friction", "damping", "lost_otherwise"))
    rows.append(("energy", f"{given} given; friction took {friction}, damping {damping}; lost otherwise {lost}, "
                           f"{percent(said['energy']['share_lost'])}"))
    return rows


def stage_rows(results, units):
    """The stages that the run was in: name, kind, how each ended, steps, times."""
    said = results.summary or {}
    return [(stage["name"], stage["kind"], stage["status"], f"{stage['steps']} steps",
             f"{units.quantity(stage['from'], 'time')} to {units.quantity(stage['reached'], 'time')}") for stage in said.get("stages", [])]


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
    """Panels of histories: energies in one, of blocks and points those that moved or turned most, the others one by one."""
    history = results.history
    if not len(history.time):
        return []
    _, steps = axis_of(results, units, is_static(results))
    energies = {name: history.energy[name] for name in history.energy}
    if "gravity" in energies:  # its zero is that of y
        energies["gravity"] = energies["gravity"] - energies["gravity"][0]
    found = [chart(units, steps, "energies, of gravity its change", history.units("energy/kinetic"), list(energies.items()))]
    for name in names_of_histories(results):
        if name == "time" or name.startswith("energy/"):
            continue
        for one in histories_of(results, name):
            chosen = np.argsort(-np.abs(one.values[-1]), kind="stable")[:MOST_LINES]
            found.append(chart(units, steps, one.description, one.dimension,
                               [(one.names[i], one.values[:, i]) for i in (np.sort(chosen) if name in COLUMNS else chosen)]))
    return found


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
