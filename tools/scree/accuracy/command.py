"""Runs a scene with many settings, and shows the error of each run beside its time.

    tools/cost_of_accuracy                       the shipped scenes, which take a while; --list names them
    tools/cost_of_accuracy triangle pendulum     some of these
    tools/cost_of_accuracy MY.ana                your own deck, which names its geometry
        --quantity displacement rotation area kinetic stress
                                                 what is compared at its end: displacements of measured points, else of the centroids
                                                 of blocks; rotation, area, mean stress of blocks; kinetic energy
    settings, in parts; without an option the scene has its own:
        --strains deck small green auto auto:1e-4      auto with an accuracy
            exact adjusted second_order trigonometric exponential    small strain with that method.rotation, where asked for
        --integrators deck shi newmark newmark-half momentum momentum-1 decaying
            alpha-1 alpha-0.8 alpha-0.5 alpha-0 central              to compare with, where asked for
        --steps 4 2 1 0.5 0.25                   over the step of the deck
        --contacts deck 0.1 10 multipliers       stiffness over that of the deck, or springs and multipliers
        --tolerances deck 1e-6 1e-3              iteration.tolerance
        --meshes deck 2 0.5                      cover.edge over that of the deck
        --accuracies 1e-2 1e-3 1e-4              runs that choose their steps by it: the accuracy asked, the true and the estimated
                                                 error; the largest step is the largest of --steps
        --all                                    every combination, not strains with steps and one of the others at a time
    --run-out                                    the run-out of a deck by the implicit scheme and by small steps, each with several
                                                 settings of --steps, --contacts, --tolerances and --accuracies: means of
        --runs 5                                 so many runs whose steps are 1 % apart; run-out.csv and DECK-run-out.png
    --set GROUP.NAME=VALUE                       a setting of every run
    --rounds 3 --jobs N --limit 60               times that each run is timed; runs at once; seconds that one may take
    --instructions                               counts those of the steps, where valgrind is installed, and ranks by them
    --folder cost-of-accuracy                    for the records of runs, cost.csv, cost.json, SCENE.png and index.html

Settings that contradict each other are left out. The reference is a closed form where the scene has one, else the limit of finer runs
with Green strain, whose uncertainty is a grey band in the diagrams. An order is given where the errors of three steps agree on one;
otherwise the reason why there is none. Seconds are processor seconds of the steps, the median of the rounds. A run of more than 10 s
is not repeated. Finished runs are kept in the folder: the same command continues where it was stopped, with the runs of the same
program, decks and settings.
"""
import argparse
import os
import pathlib
import sys

from ..arguments import STOPPED, above_zero, ends_in_a_line, parser_for, say, whole_from
from ..errors import ScreeError
from ..program import program, version, work_folder
from ..records import explain
from .choices import COMPARED, CURES, DECK, INTEGRATORS, MULTIPLIERS, STRAINS, grid
from .ensembles import DEFAULTS, Ensembles, QUANTITIES as WAYS, RunOut, print_run_out
from .runs import Study, run_all
from .scenes import QUANTITIES, SHIPPED, own
from .table import Findings, print_findings, write_csv, write_json


def factor(word):
    """A factor of what the deck has, or what the deck has."""
    return DECK if word == DECK or above_zero(word) == 1 else f"{above_zero(word):g}"


def contact(word):
    return word if word == MULTIPLIERS else factor(word)


def tolerance(word):
    return word if word == DECK else f"{above_zero(word):g}"


def strain(word):
    name, _, accuracy = word.partition(":")
    if name not in (DECK, *STRAINS, *CURES) or (accuracy and name != "auto"):
        raise argparse.ArgumentTypeError(f"expected {DECK}, {', '.join(STRAINS + CURES)} or auto:ACCURACY, found '{word}'")
    if accuracy:
        above_zero(accuracy)
    return word


def arguments():
    parser = parser_for(__doc__)
    parser.add_argument("scene", nargs="*", help=f"of {' '.join(SHIPPED)}, or an analysis deck")
    parser.add_argument("--quantity", nargs="+", choices=QUANTITIES, default=["displacement", "rotation", "area", "kinetic"],
                        metavar="NAME", help="what a deck of one's own is judged by")
    parser.add_argument("--strains", nargs="+", type=strain)
    parser.add_argument("--integrators", nargs="+", choices=[DECK, *INTEGRATORS, *COMPARED], metavar="NAME")
    parser.add_argument("--steps", nargs="+", type=above_zero)
    parser.add_argument("--contacts", nargs="+", type=contact)
    parser.add_argument("--tolerances", nargs="+", type=tolerance)
    parser.add_argument("--meshes", nargs="+", type=factor)
    parser.add_argument("--accuracies", nargs="+", type=tolerance)
    parser.add_argument("--all", action="store_true", help="every combination")
    parser.add_argument("--run-out", action="store_true", help="ensembles of both schemes")
    parser.add_argument("--runs", type=whole_from(1), default=5, metavar="N", help="of an ensemble")
    parser.add_argument("--set", action="append", default=[], metavar="GROUP.NAME=VALUE", help="a setting of every run")
    parser.add_argument("--rounds", type=whole_from(1), default=3)
    parser.add_argument("--jobs", type=whole_from(1), default=len(os.sched_getaffinity(0)), help="runs at once; default: the processors")
    parser.add_argument("--limit", type=above_zero, default=60.0, metavar="SECONDS")
    parser.add_argument("--instructions", action="store_true")
    parser.add_argument("--folder", type=pathlib.Path, default=pathlib.Path("cost-of-accuracy"))
    parser.add_argument("--list", action="store_true", help="the shipped set")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    return parser.parse_args()


def axes_of(scene, given):
    """The axes of a scene, but for those that were given."""
    asked = {axis: getattr(given, {"mesh": "meshes", "accuracy": "accuracies"}.get(axis, f"{axis}s")) for axis in scene.axes}
    asked["accuracy"] = asked["accuracy"] and [DECK, *asked["accuracy"]]
    return {axis: asked[axis] or words for axis, words in scene.axes.items()}


def scene_of_deck(name, given, quantities, names, path):
    """The scene of a deck that is judged by some quantities."""
    deck = pathlib.Path(name).absolute()
    if not deck.is_file():
        raise ScreeError(f"expected a deck or one of {' '.join(SHIPPED)}, found '{name}'")
    return own(deck, explain([deck], given.set, path), {name: quantities[name] for name in names})


def scenes_of(given, path):
    """The scenes of the set and of decks that are asked for."""
    scenes = [SHIPPED[name][1]() if name in SHIPPED else scene_of_deck(name, given, QUANTITIES, given.quantity, path)
              for name in dict.fromkeys(given.scene or SHIPPED)]
    names = [scene.name for scene in scenes]
    if len(set(names)) < len(names):
        raise ScreeError(f"expected decks of different names, found {', '.join(names)}: run each into a --folder of its own")
    return scenes


def study_of(scene, given, decks, path):
    """The runs of a scene."""
    scene.axes = axes_of(scene, given)
    return Study(scene, grid(scene.axes, given.all), given.set, decks, given.folder, path)


def run_out(given):
    """Runs what is left to run of the ensembles, prints their tables, draws them."""
    from .diagrams import draw_run_out
    if not given.scene:
        raise ScreeError("--run-out: expected decks, found none")
    path = program(given.scree)
    axes = {"step": given.steps, "contact": given.contacts, "tolerance": given.tolerances, "accuracy": given.accuracies}
    axes = {axis: words or DEFAULTS[axis] for axis, words in axes.items()}
    with work_folder() as decks:
        studies = [Ensembles(scene_of_deck(name, given, WAYS, WAYS, path), axes, given.runs, given.set, decks, given.folder, path)
                   for name in dict.fromkeys(given.scene)]
        run_all(studies, path, 1, given.jobs, given.limit)
    found = [RunOut(one) for one in studies]
    for one in found:
        print_run_out(one)
        draw_run_out(one, given.folder / f"{one.scene.name}-run-out.png")
    write_csv(given.folder / "run-out.csv", [{"deck": one.scene.name, **row} for one in found for row in one.rows])


def study(given):
    """Runs what is left to run, prints the tables, writes the files."""
    path = program(given.scree)
    with work_folder() as decks:
        studies = [study_of(scene, given, decks, path) for scene in scenes_of(given, path)]
        run_all(studies, path, given.rounds, given.jobs, given.limit, given.instructions)
    from .diagrams import draw  # here, as matplotlib takes a second to begin
    from .page import write_page
    found, pictures = [Findings(one) for one in studies], []
    for findings in found:
        print_findings(findings)
        pictures.append(given.folder / f"{findings.scene.name}.png")
        draw(findings, pictures[-1])
    facts = {"program": version(path)["version"], "command": " ".join(["tools/cost_of_accuracy", *sys.argv[1:]])}
    write_csv(given.folder / "cost.csv", [row for findings in found for row in findings.rows])
    write_json(given.folder / "cost.json", found, program=facts["program"])
    write_page(given.folder / "index.html", found, pictures, facts)
    print(f"\n{given.folder}/index.html has the diagrams, cost.csv and cost.json beside it all figures")


@ends_in_a_line
def main():
    given = arguments()
    if given.list:
        print("\n".join(f"{name:<16}{text}" for name, (text, _) in SHIPPED.items()))
        return 0
    try:
        (run_out if given.run_out else study)(given)
    except KeyboardInterrupt:
        print(file=sys.stderr)
        say("stopped; the same command goes on")
        return STOPPED
    return 0
