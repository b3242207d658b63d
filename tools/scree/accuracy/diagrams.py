"""Work-precision diagrams: error beside cost, a picture a scene (PNG)."""
import itertools

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of what draws)

from .choices import CURES  # noqa: E402
from .ensembles import IMPLICIT, SMALL  # noqa: E402
from .table import METHOD  # noqa: E402

LEAST = 1e-15  # an error of nothing is drawn there
MARKERS = {"small": "o", "green": "s", "auto": "^", "strain_rotation": "P", **dict(zip(CURES, "xv<>D"))}
LINES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 4)), (0, (8, 2)))


def draw(findings, path):
    """A panel a quantity: a line a method, its steps along it; the front that nobody passes; the default."""
    count = len(findings.names)
    widths = [5.2] * count + [3.2]
    figure, panels = plt.subplots(1, count + 1, figsize=(sum(widths), 5.0), width_ratios=widths, layout="constrained")
    styles = styles_of(findings)
    for name, panel in zip(findings.names, panels):
        draw_quantity(findings, name, panel, styles)
    panels[-1].axis("off")
    panels[-1].legend(*panels[0].get_legend_handles_labels(), loc="upper left", fontsize=7)
    figure.suptitle(f"{findings.scene.name}: {findings.scene.text}", fontsize=9)
    figure.savefig(path, dpi=90)
    plt.close(figure)


def styles_of(findings):
    """Colours tell integrators, markers strains, lines the rest."""
    integrators = dict.fromkeys(row["integrator"] for row in findings.rows)
    others = dict.fromkeys(tuple(row[axis] for axis in METHOD[2:]) for row in findings.rows)
    colours = dict(zip(integrators, itertools.cycle(plt.rcParams["axes.prop_cycle"].by_key()["color"])))
    lines = dict(zip(others, itertools.cycle(LINES)))
    return lambda row: {"color": colours[row["integrator"]], "marker": MARKERS[row["strain"].partition(":")[0]],
                        "linestyle": lines[tuple(row[axis] for axis in METHOD[2:])]}


def draw_quantity(findings, name, panel, styles):
    key = f"error: {name}"
    for rows in findings.methods():
        rows = findings.judged(name, rows)
        if rows:
            label = " ".join(filter(None, (rows[0][axis] for axis in METHOD)))
            panel.loglog([row[findings.cost.key] for row in rows], [max(row[key], LEAST) for row in rows], label=label, markersize=4,
                         linewidth=1, **styles(rows[0]))
    judged = findings.judged(name)
    for label, chosen, look in (
            ("the default", [row for row in judged if row["default"]],
             {"marker": "o", "markersize": 11, "linestyle": "", "markerfacecolor": "none", "color": "black"}),
            ("beaten by nobody", sorted((row for row in judged if row.get(f"front: {name}")), key=lambda row: row[findings.cost.key]),
             {"drawstyle": "steps-post", "color": "grey", "linewidth": 5, "alpha": 0.4, "zorder": 0})):
        panel.loglog([row[findings.cost.key] for row in chosen], [max(row[key], LEAST) for row in chosen], label=label, **look)
    answer = findings.answers[name]
    if answer and 0 < answer.doubt < float("inf"):
        panel.axhspan(LEAST, answer.doubt, color="black", alpha=0.08, label="the reference may be off")
        panel.set_ylim(bottom=min([answer.doubt, *(max(row[key], LEAST) for row in judged)]) / 2)
    panel.set(xlabel=findings.cost.words, ylabel=f"error: {name}")
    panel.grid(True, which="major", alpha=0.3)


def draw_run_out(found, path):
    """Run-out beside processor seconds: a point an ensemble, its bar the uncertainty of its mean; a grey band that of the reference."""
    figure, panels = plt.subplots(1, 2, figsize=(9.5, 4.2), sharex=True, layout="constrained")
    for panel, measure in zip(panels, ("mean", "95 %")):
        for scheme, colour, marker in ((IMPLICIT, "tab:blue", "s"), (SMALL, "tab:orange", "o")):
            rows = [row for row in found.rows if row["scheme"] == scheme and row["runs"]]
            panel.errorbar([row["seconds"] for row in rows], [100 * row[f"error: {measure}"] for row in rows],
                           [100 * row[f"doubt: {measure}"] for row in rows], linestyle="", marker=marker, color=colour, capsize=3, label=scheme)
            for row in rows:
                panel.annotate(row["knob"], (row["seconds"], 100 * row[f"error: {measure}"]), xytext=(2, 4), textcoords="offset points",
                               fontsize=7, rotation=50)
        value, doubt = found.reference[measure]
        panel.axhspan(-100 * doubt / value, 100 * doubt / value, color="black", alpha=0.08, label="the reference may be off")
        panel.axhline(0, color="black", linewidth=0.6)
        panel.set(xscale="log", xlabel="seconds of the processor for one run", ylabel=f"error of the {measure} displacement, %")
        panel.margins(x=0.2)
        panel.grid(True, which="major", alpha=0.3)
    panels[0].legend(fontsize=8)
    figure.suptitle(f"{found.scene.name}: {found.scene.text}", fontsize=9)
    figure.savefig(path, dpi=90)
    plt.close(figure)
