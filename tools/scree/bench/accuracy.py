"""Error beside time: the turning triangle by several methods and step sizes."""
import numpy as np

from ..program import TREE, with_settings
from ..results import read
from .processes import ROUNDS, run

DECK = TREE / "input" / "paper" / "rotation" / "t1.ana"
METHODS = {
    "small strain, Shi's step": ["method.strain=small", "integrator.beta=1", "integrator.gamma=0.5", "integrator.start=zero"],
    "Green strain, beta 1": ["method.strain=green", "integrator.scheme=newmark", "integrator.beta=1", "integrator.gamma=0.5",
                             "integrator.start=zero"],
    "Green strain, beta 1/2": ["method.strain=green", "integrator.scheme=newmark", "integrator.beta=0.5", "integrator.gamma=0.5",
                               "integrator.start=consistent"],
}
ENERGY_MOMENTUM = ["method.strain=green", "integrator.scheme=energy_momentum", "integrator.beta=1.0", "integrator.start=zero"]


def measure_turning(path, folder, deck, words, degrees, turns):
    """Larger error in percent after one turn, solves a step, microseconds a step, of one run."""
    settings = [*words, f"step.size={degrees / 360!r}", f"step.end_time={turns}", "output.interval=1"]
    run(path, "run", deck, "-o", folder / "r.h5", "--quiet", *with_settings(settings))
    r = read(folder / "r.h5")
    history, steps = r.history, len(r.history.time)
    one = np.searchsorted(history.time, 1 - 1e-9)
    area = history.area[one] / (np.sqrt(0.1875) * 0.01) - 1
    angle = history.rotation[one, 0] / (2 * np.pi * history.time[one]) - 1
    return 100 * max(abs(area), abs(angle)), history.solves.sum() / steps, 1e6 * r.seconds("steps") / steps


def accuracy(given, folder):
    cases = [(method, words, degrees) for method, words in METHODS.items() for degrees in (3.6, 0.36)]
    cases += [("energy-momentum, chi 1/2", ENERGY_MOMENTUM, degrees) for degrees in (20, 3.6, 0.36)]
    plain = folder / "triangle.ana"
    text = DECK.read_text().split("&integrator")[0].replace("triangle.geo", str(DECK.parent / "triangle.geo"))
    plain.write_text(text.replace(", strain='small'", ""))
    rounds = [[measure_turning(given.scree, folder, plain, words, degrees, given.turns) for _, words, degrees in cases]
              for _ in range(ROUNDS)]
    costs = [min(cost for _, _, cost in runs) for runs in zip(*rounds)]
    print(f"{'method':<28}{'degrees/step':>13}{'error %':>11}{'solves/step':>13}{'us/step':>9}{'ratio':>7}{'us/turn':>10}")
    for (method, _, degrees), (error, solves, _), cost in zip(cases, rounds[0], costs):
        print(f"{method:<28}{degrees:>13g}{error:>11.2g}{solves:>13.2f}{cost:>9.2f}{cost / costs[0]:>7.2f}"
              f"{cost * 360 / degrees:>10.0f}")
