"""What contact costs: by the ways to treat it, and by the rules that it follows."""
import numpy as np

from .. import touching
from ..program import TREE, Runner


def solves_a_step(r):
    return r.history.solves.sum() / len(r.history.time)


def contact(given, folder):
    run = Runner(folder, given.scree)
    stiffness = (5, 50, 500, 5000)
    print(f"{'scene':<20}{'steps':>6}{'merged':>8}{'nested':>8}{'difference':>12}{'overlap':>9}" +
          "".join(f"{f'at {p} E':>11}" for p in stiffness) + f"{'largest overlap':>17}")
    for name, scene in touching.scenes().items():
        merged, nested = (scene.run(run, way, [f"contact.coupling={way}"]) for way in ("merged", "nested"))
        moved = [r.measured_points.displacement for r in (merged, nested)]
        difference = np.abs(moved[0] - moved[1]).max() / np.abs(moved[0]).max()
        held = [scene.run(run, f"at {p} E", ["contact.method=augmented", f"contact.stiffness={p * scene.E}"]) for p in stiffness]
        print(f"{name:<20}{scene.steps:>6}{solves_a_step(merged):>8.2f}{solves_a_step(nested):>8.2f}{difference:>12.0e}"
              f"{merged.history.overlap.max():>9.0e}" + "".join(f"{solves_a_step(r):>11.2f}" for r in held) +
              f"{max(r.history.overlap.max() for r in held):>17.0e}")


# By the rules of contact: a wall of 106 blocks, put up at once and left to stand. At rest nothing moves: kinetic energy and the
# farthest that a block went sideways are errors.
WALLS = {
    "Shi's contact": ["method.preset=shi"],
    "small strain": [],
    "Green strain": ["method.strain=green"],
    "with multipliers": ["method.strain=green", "contact.method=augmented"],
}


def rules(given, folder):
    classic, run = TREE / "tests" / "data" / "classic", Runner(folder, given.scree)
    print(f"{'wall':<20}{'steps':>7}{'solves a step':>15}{'ms a step':>11}{'ratio':>7}{'kinetic, kJ':>13}{'sideways, m':>13}{'open':>6}")
    times = []
    for name, settings in WALLS.items():
        r = run(classic / "wall100.ana", ("wall.geo", (classic / "wall100.geo").read_text()),
                [f"step.end_time={0.005 * given.steps}", *settings], name="wall")
        steps, place = len(r.history.time), r.bodies.centroid
        times.append(r.seconds("steps") / steps)
        print(f"{name:<20}{steps:>7}{solves_a_step(r):>15.2f}{1000 * times[-1]:>11.1f}{times[-1] / times[0]:>7.2f}"
              f"{r.history.energy.kinetic[-1]:>13.1e}{np.abs(place[-1] - place[0])[:, 0].max():>13.1e}{r.history.contacts[-1, 0]:>6}")
