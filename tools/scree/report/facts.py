"""What a run came to, as rows and charts of a page."""
import numpy as np

from ..histories import COLUMNS, history_of, names_of_histories

SHARE = 0.01      # of what is compared with: an error above it is worth a look
BINS = 300        # over the time of a chart, each with the least and the largest of a series
MOST_LINES = 6    # of a chart, those of the largest at the end


def number(value):
    return "–" if value is None else f"{value:,.4g}".replace(",", " ") if isinstance(value, float) else f"{value}"


def percent(share):
    return f"{100 * share:.3g} %"


def verdict(results):
    """How grave it is (good, look, bad), how the run ended, and remarks on what is worth a look."""
    status = results.scene.status
    level = {"complete": "good", "cut": "look", "running": "bad", "interrupted": "bad"}.get(status, "bad")
    words = {"complete": "The run is complete", "cut": "The model as set up, without a run", "interrupted": "The run was interrupted",
             "running": "The run goes on, or was killed"}.get(status, f"The run ended early: {status}")
    if results.n_frames and len(results.history.time):
        words += f", at time {number(float(results.history.time[-1]))}"
    remarks = list(remarks_on(results))
    return "look" if remarks and level == "good" else level, f"{words}.", remarks


def remarks_on(results):
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
            yield (f"Contacts overlapped by up to {number(float(history.overlap[k]))}, {percent(history.overlap[k] / size)} of the size of "
                   f"the smallest block, at time {number(float(history.time[k]))}.")
    if "error" in history and history.error.share.max() > SHARE:
        yield f"Steps are estimated to be off by up to {percent(history.error.share.max())} of the displacement."
    if summary and summary["energy"]["share_lost"] < -SHARE:
        yield f"Energy was made: {percent(-summary['energy']['share_lost'])} of what there was to give."
    cut = int(history.rejected.sum())
    if cut > SHARE * len(history.time):
        yield f"{cut} tries of steps were cut, of {len(history.time)} steps taken."


def outcome_rows(results):
    """What `scree run` says at its end, in rows of a name and words; nothing where the run was killed."""
    said = results.summary
    if said is None:
        return []

    def where(name):
        found = said[name]
        return f"{number(found['largest'])}, block {found['block']} at ({', '.join(map(number, found['position']))})"

    rows = [("time", f"{number(said['time']['reached'])} of {number(said['time']['asked'])}"),
            ("steps", f"{said['steps']['taken']} taken of {number(said['steps']['planned'])} planned, {said['steps']['cut']} tries cut, "
                      f"{said['steps']['solves']} solves, {said['steps']['factors']} factors"),
            ("farthest vertex", where("displacement")), ("fastest vertex", where("speed"))]
    if said["at_rest"] is not None:
        rows.append(("at rest", "yes" if said["at_rest"] else "no"))
    if said["balance"]:
        rows.append(("out of balance", f"{number(said['balance']['share'])} of what acts on block {said['balance']['block']}; up to "
                                       f"{number(said['balance']['tolerance'])} is equilibrium"))
    rows.append(("area", f"changed by {percent(said['change_of_area'])}"))
    if said["overlap"]:
        rows.append(("worst overlap", f"{where_of_overlap(said['overlap'])}"))
    energy = said["energy"]
    rows.append(("energy", f"{number(energy['given'])} given; friction took {number(energy['friction'])}, damping "
                           f"{number(energy['damping'])}; lost otherwise {number(energy['lost_otherwise'])}, "
                           f"{percent(energy['share_lost'])}"))
    return rows


def where_of_overlap(overlap):
    """The deepest overlap in words."""
    if not overlap["largest"]:
        return "none"
    return (f"{number(overlap['largest'])} at time {number(overlap['time'])}, block {overlap['blocks'][0]} in block "
            f"{overlap['blocks'][1]} at ({', '.join(map(number, overlap['position']))})")


def error_rows(results):
    """The estimate of the error at the end, where the run made one."""
    if "error" not in results.history:
        return []
    error = results.history.error
    return [(name, number(float(error[name][-1])), error.description(name)) for name in error if len(error[name])]


def energy_rows(results):
    """The books of energy at the end."""
    if not len(results.history.time):
        return []
    energy = results.history.energy
    return [(name, number(float(energy[name][-1])), energy.description(name)) for name in energy]


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


def charts(results):
    """Panels of histories: energies in one, of blocks and points those that moved or turned most, the others one by one."""
    history = results.history
    if not len(history.time):
        return []
    energies = {name: history.energy[name] for name in history.energy}
    if "gravity" in energies:  # its zero is that of y
        energies["gravity"] = energies["gravity"] - energies["gravity"][0]
    found = [chart(history.time, "energies, of gravity its change", history.units("energy/kinetic"), list(energies.items()))]
    for name in names_of_histories(results):
        if name != "time" and not name.startswith("energy/"):
            one = history_of(results, name)
            chosen = np.argsort(-np.abs(one.values[-1]), kind="stable")[:MOST_LINES]
            found.append(chart(history.time, one.description, one.dimension,
                               [(one.names[i], one.values[:, i]) for i in (np.sort(chosen) if name in COLUMNS else chosen)]))
    return found


def chart(times, title, unit, series):
    """A panel with as few places in time as show what there is: in each bin the least and the largest of each series."""
    n = len(times)
    rows = np.arange(n)
    if n > 2 * BINS:
        bins = np.array_split(rows, BINS)
        rows = np.unique([0, n - 1, *(b[0] + i for _, values in series for b in bins
                                      for i in (int(values[b].argmin()), int(values[b].argmax())))])
    return {"title": title, "unit": unit, "times": rounded(times[rows]),
            "series": [{"name": name, "values": rounded(np.asarray(values, float)[rows])} for name, values in series]}


def rounded(values):
    return [float(f"{value:.8g}") for value in values]
