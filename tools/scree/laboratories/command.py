"""Tests specimens of bonded grains as a laboratory tests rock: strength, stiffness, cracks, and their spread over seeds.

    tools/test_rock TEST [--grains N] [--seeds S ...] [--pressures MPA ...] [-o FOLDER] [options]

TEST is ucs (unconfined compression), biaxial (with confinement), brazilian (a disc), shear (a direct shear test) or bending (a notched
beam on three points). Units are kg, m and s; stresses of options are in MPa, moduli in GPa (doc/howto/laboratory.md).

FOLDER, by default the name of the test with -tests, holds the decks and results of each specimen, specimens.json and specimens.png. Exit
status 0; 1 where a run fails; 2 for bad input.
"""
from __future__ import annotations

import dataclasses
import json
import pathlib
import typing
from collections.abc import Sequence

import numpy as np

from ..arguments import above_zero, ends_in_a_line, length_from_zero, parser_for, whole_from
from ..model.grains import KINDS
from ..program import StrPath, made_folder
from ..records import Bar
from .runs import Outcome, all_tests, mohr_coulomb
from .specimens import TESTS, Rock, Specimen

MEGA, GIGA = 1e6, 1e9
TABLE, PICTURE = "specimens.json", "specimens.png"
CONFINEMENTS = (0.0, 5.0, 10.0)  # MPa, of tests with a pressure
SHORT = 0.5                      # width of a beam over that of other specimens, as it is four times as long


@dataclasses.dataclass
class Laboratory:
    """What tests came to: the outcome of each specimen, all seeds of a pressure after each other."""

    outcomes: list[Outcome]

    @property
    def strength(self) -> tuple[float, float]:
        """Mean strength of the lowest pressure, and its standard deviation over the seeds."""
        lowest = min(outcome.specimen.pressure for outcome in self.outcomes)
        values = [outcome.strength for outcome in self.outcomes if outcome.specimen.pressure == lowest]
        return float(np.mean(values)), float(np.std(values, ddof=1)) if len(values) > 1 else 0.0

    @property
    def mohr_coulomb(self) -> tuple[float, float] | None:
        """Cohesion and friction angle in degrees, by a line through all strengths; None with one pressure alone."""
        return mohr_coulomb(self.outcomes)

    def rows(self) -> list[dict[str, typing.Any]]:
        """A row for each specimen, in kg, m and s."""
        return [{"test": one.specimen.kind, "seed": one.seed, "pressure": one.specimen.pressure, "grains": one.grains, "strength": one.strength,
                 "strain_at_peak": float(one.strain[one.peak]), "fell": one.has_peak, "residual": one.residual, "onset": one.onset,
                 **({"young": one.young, "poisson": one.poisson} if one.specimen.kind in ("ucs", "biaxial") else {}),
                 "broken_in_tension": one.broken[0], "broken_in_shear": one.broken[1], "steps": len(one.stress), "processor_seconds": one.seconds,
                 "results": one.path.name} for one in self.outcomes]

    def plot(self) -> typing.Any:
        """A figure with the curves, and the first specimen as it broke."""
        from .pictures import draw_outcomes
        return draw_outcomes(self.outcomes)


def laboratory(test: str = "ucs", seeds: Sequence[int] = (1,), pressures: Sequence[float] = (0.0,), folder: StrPath | None = None,
               jobs: int | None = None, rock: Rock | None = None, path: StrPath | None = None, show: typing.Any = Bar,
               **specimen: typing.Any) -> Laboratory:
    """Tests specimens with each seed at each pressure (Pa), as `tools/test_rock` does; further arguments are those of a `Specimen`."""
    found = [Specimen(test, pressure=pressure, rock=rock or Rock(), **specimen) for pressure in pressures]
    return Laboratory(all_tests(found, seeds, made_folder(folder or f"{test}-tests"), jobs, path, show))


NAMES = {"ucs": "UCS", "biaxial": "strength", "brazilian": "BTS", "shear": "shear strength", "bending": "nominal strength"}


def words_of(tests: Laboratory) -> typing.Iterator[str]:
    """The table in lines, and the means."""
    kind = tests.outcomes[0].specimen.kind
    pressed, elastic = kind in ("biaxial", "shear"), kind in ("ucs", "biaxial")
    yield ("seed " + ("pressure " if pressed else "") + "strength  strain onset " + ("residual " if pressed else "") + ("E [GPa]   nu " if elastic else "") + "tension shear")
    for one in tests.outcomes:
        yield (f"{one.seed:4d} " + (f"{one.specimen.pressure / MEGA:8.4g} " if pressed else "") +
               f"{one.strength / MEGA:8.4g} {1e3 * one.strain[one.peak]:7.3f} {one.onset / MEGA:5.3g} " +
               ((f"{one.residual / MEGA:8.4g} " if one.residual is not None else "       - ") if pressed else "") +
               (f"{one.young / GIGA:7.4g} {one.poisson:4.2f} " if elastic else "") +
               f"{one.broken[0]:7d} {one.broken[1]:5d}" + ("" if one.has_peak else "  did not fall: try more --strain"))
    for pressure in dict.fromkeys(one.specimen.pressure for one in tests.outcomes):
        values = np.array([one.strength for one in tests.outcomes if one.specimen.pressure == pressure]) / MEGA
        spread = f" +- {values.std(ddof=1):.2g}" if len(values) > 1 else ""
        yield f"{NAMES[kind]}{f' at {pressure / MEGA:g} MPa' if pressed else ''}: {values.mean():.4g}{spread} MPa"
    if found := tests.mohr_coulomb:
        left = sum(not one.has_peak for one in tests.outcomes)
        yield (f"cohesion {found[0] / MEGA:.4g} MPa, friction angle {found[1]:.1f} degrees" +
               (f", with {left} of {len(tests.outcomes)} specimens that did not fall" if left else ""))


@ends_in_a_line
def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("test", choices=TESTS, metavar="TEST", help=", ".join(TESTS))
    parser.add_argument("--grains", type=whole_from(1), default=400, metavar="N", help="in a specimen; default: 400")
    parser.add_argument("--seeds", type=whole_from(0), nargs="+", default=[1, 2, 3], metavar="S", help="a specimen each; default: 1 2 3")
    parser.add_argument("--pressures", type=length_from_zero, nargs="+", metavar="MPA", help="of biaxial and shear; default: 0 5 10, of shear 1 2 4")
    parser.add_argument("--width", type=above_zero, metavar="M", help="of the specimen; default: 0.05, of a beam 0.025, which is 4 times as long")
    parser.add_argument("--shape", choices=KINDS, default="voronoi", help="of grains; default: voronoi")
    parser.add_argument("--grading", type=length_from_zero, default=0.0, metavar="G", help="spread of the sizes of grains over their mean; default: 0")
    parser.add_argument("--strain", type=above_zero, metavar="E", help="at the end, where the stress does not fall; default: by the strength of bonds")
    parser.add_argument("--steps", type=whole_from(1), default=240, metavar="N", help="to that strain; default: 240")
    for name, unit, default, what in (("young", "GPA", 50.0, "Young's modulus of grains"), ("kn", "GPA/M", 0.0, "normal stiffness of bonds; 0: by the program"),
                                      ("ks", "GPA/M", 0.0, "shear stiffness of bonds; 0: 0.4 kn"), ("cohesion", "MPA", 20.0, "of bonds"),
                                      ("tension", "MPA", 5.0, "tensile strength of bonds"), ("phi", "DEGREES", 30.0, "friction angle of bonds"),
                                      ("poisson", "NU", 0.25, "Poisson's ratio of grains")):
        parser.add_argument(f"--{name}", type=length_from_zero, default=default, metavar=unit, help=f"{what}; default: {default:g}")
    parser.add_argument("--jobs", type=whole_from(1), metavar="N", help="runs at once; default: one for each processor")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FOLDER")
    given = parser.parse_args()
    rock = Rock(young=given.young * GIGA, poisson=given.poisson, phi=given.phi, cohesion=given.cohesion * MEGA, tension=given.tension * MEGA,
                kn=given.kn * GIGA, ks=given.ks * GIGA)
    pressures = given.pressures or {"biaxial": CONFINEMENTS, "shear": (1.0, 2.0, 4.0)}.get(given.test, (0.0,))
    folder = made_folder(given.output or pathlib.Path(f"{given.test}-tests"))
    tests = laboratory(given.test, given.seeds, [MEGA * one for one in pressures], folder, given.jobs, rock, given.scree, grains=given.grains,
                       width=given.width or 0.05 * (SHORT if given.test == "bending" else 1), shape=given.shape, grading=given.grading,
                       strain=given.strain, steps=given.steps)
    (folder / TABLE).write_text(json.dumps(tests.rows(), indent=1) + "\n")
    tests.plot().savefig(folder / PICTURE, dpi=100)
    print(*words_of(tests), f"{folder}/{TABLE}, {PICTURE}", sep="\n")
    return 0
