"""The validation cases of elastic bodies without contact."""
import math

import numpy as np

from ..errors import RunFailed
from . import references
from .cases import DECKS, Row, case

SIDE = 2 / math.sqrt(3)  # edge of triangles that are 1 high


def orders(values):
    """Observed orders of convergence of a value on meshes, or steps, each half the one before: log2 of the ratio of its changes."""
    changes = np.diff(values)
    return np.log2(changes[:-1] / changes[1:])


def frequency(time, values, guess):
    """Of the sine that fits best, within 3 % of a guess."""
    tried = guess * np.linspace(0.97, 1.03, 601)
    left = []
    for f in tried:
        of_time = np.column_stack([np.ones_like(time), np.cos(2 * math.pi * f * time), np.sin(2 * math.pi * f * time)])
        left.append(np.sum((values - of_time @ np.linalg.lstsq(of_time, values, rcond=None)[0])**2))
    return tried[np.argmin(left)]


@case
def e6(run):
    """A cantilever under a small load: its deflection, how that converges, and its first frequency."""
    beam, deck = references.TimoshenkoBeam(10.0, 1.0, 1e9, 0.25, 2500.0), DECKS / "e6-cantilever" / "bent.ana"
    found = {}
    for order, rows in ((0, (8, 16, 32)), (1, (1, 2, 4, 8))):
        for n in rows:
            r = run(deck, settings=[f"cover.order={order}", f"cover.edge={SIDE / n!r}"], name=f"e6-order{order}-{n}")
            found[order, n] = -r.measured_points.displacement[-1, :, 1].mean()
    for words, of in (("order=0, 16 rows", (0, 16)), ("order=1, one row", (1, 1))):
        yield Row(f"deflection, {words}", beam.deflection(1e4), found[of], 0.01)
    yield Row("order of the error, order=0, mesh halved", 2.0, orders([found[0, n] for n in (8, 16, 32)])[0], 0.05)
    yield Row("order of the error, order=1, mesh halved", 2 * references.clamped_corner(0.25), orders([found[1, n] for n in (2, 4, 8)])[0], 0.05)
    r = run(DECKS / "e6-cantilever" / "swings.ana")
    exact = beam.frequency()
    yield Row("first frequency", exact, frequency(r.history.time, r.measured_points.displacement[:, :, 1].mean(axis=1), exact), 0.01)


def bar_ends(run, ratio, name):
    """How the bar of e7 ends under a load over E: with its words where it is refused for its stiffness."""
    try:
        r = run(DECKS / "e7-bar" / "bar.ana", settings=[f"boundary.traction={ratio * 1e9!r} 0 {ratio * 1e9!r} 0"], name=name)
    except RunFailed as failed:
        return "lost its stiffness" if "Green strain has lost its stiffness" in failed.said else "fails"
    return r.scene.status


@case
def e7(run):
    """A bar in Green strain, of one block and of a mesh: its stretch, and the load at which its stiffness is lost."""
    for name, settings in (("block", []), ("mesh", ["method.model=nmm", "cover.edge=0.4"])):
        for ratio in (0.01, 0.1, 0.5, -0.1, -0.192):
            r = run(DECKS / "e7-bar" / "bar.ana", settings=[f"boundary.traction={ratio * 1e9!r} 0 {ratio * 1e9!r} 0", *settings],
                    name=f"e7-{name}{ratio:g}")
            yield Row(f"stretch at P/E = {ratio:g}, {name}", references.green_stretch(ratio),
                      1 + r.measured_points.displacement[-1, 0, 0] / 2, 1e-8)
    limit = -1 / math.sqrt(27)
    for factor, expected in ((0.999999, "complete"), (1.000005, "lost its stiffness")):
        yield Row(f"{factor} of the limit -0.19245 E, block", expected, bar_ends(run, factor * limit, f"e7-limit{factor}"))
