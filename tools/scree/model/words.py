"""What the words of a model may be: checks that say in one sentence which argument is wrong, and units."""
from __future__ import annotations

import dataclasses
import math
import numbers
from collections.abc import Iterable, Mapping, Sequence

from ..errors import ModelError

Point = Sequence[float]
Points = Iterable[Point]

MASSES = {"kg": 1.0, "t": 1e3, "g": 1e-3, "Mg": 1e3}  # in kg
LENGTHS = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "km": 1e3}  # in m
TIMES = {"s": 1.0, "ms": 1e-3}  # in s
FORCES = {1e-3: "mN", 1.0: "N", 1e3: "kN", 1e6: "MN", 1e9: "GN"}  # by how many N
GRAVITY, WATER = 9.81, 1000.0  # m/s^2, kg/m^3
HOLDS = ("normal", "x", "y", "both")
POINT_HOLDS = {"both": "points", "x": "points_x", "y": "points_y"}  # lists of &support with points


@dataclasses.dataclass
class UnitSystem:
    """A consistent system of units by the names of its length, mass and time."""

    words: str

    def __post_init__(self) -> None:
        names = str(self.words).split()
        tables = (LENGTHS, MASSES, TIMES)
        found = [next((name for name in names if name in table), "") for table in tables]
        if len(names) != len(tables) or "" in found:
            raise ModelError(f"Model(units=): expected a length ({', '.join(LENGTHS)}), a mass ({', '.join(MASSES)}) and a time "
                             f"({', '.join(TIMES)}), such as 'm kg s', found {self.words!r}")
        self.length, self.mass, self.time = found
        self.words = " ".join(found)

    @property
    def gravity(self) -> float:
        """The acceleration of gravity, 9.81 m/s^2."""
        return GRAVITY / LENGTHS[self.length] * TIMES[self.time] ** 2

    @property
    def water(self) -> float:
        """The density of water."""
        return WATER / MASSES[self.mass] * LENGTHS[self.length] ** 3

    @property
    def force(self) -> str:
        """The name of the unit of force, such as kN; that of mass times length over time squared where it has none."""
        size = MASSES[self.mass] * LENGTHS[self.length] / TIMES[self.time] ** 2
        return next((name for one, name in FORCES.items() if math.isclose(size, one)), f"{self.mass}*{self.length}/{self.time}^2")

    @property
    def settings(self) -> dict[str, str]:
        """The values of &units by GROUP.NAME."""
        return {"units.length": self.length, "units.force": self.force, "units.time": self.time}

    @classmethod
    def of_settings(cls, settings: Mapping[str, str]) -> UnitSystem | None:
        """The system that settings of &units name; None where they name no such system. Of two masses of a size it has the first."""
        length, time = settings.get("units.length"), settings.get("units.time")
        found = [cls(f"{length} {mass} {time}") for mass in MASSES] if length in LENGTHS and time in TIMES else []
        return next((one for one in found if one.force == settings.get("units.force")), None)


def number(value, what: str, above: float | None = None, least: float | None = None, most: float | None = None) -> float:
    """A finite number within limits; ModelError that names the argument."""
    limits = "".join([f" above {above:g}" if above is not None else "", f" from {least:g}" if least is not None else "",
                      f" to {most:g}" if most is not None else ""])
    real = isinstance(value, numbers.Real) and not isinstance(value, bool) and math.isfinite(value)
    if not real or (above is not None and value <= above) or (least is not None and value < least) or (most is not None and value > most):
        raise ModelError(f"{what}: expected a number{limits}, found {value!r}")
    return float(value)


def whole(value, what: str, least: int = 1) -> int:
    """A whole number from a least; ModelError that names the argument."""
    if not isinstance(value, numbers.Integral) or isinstance(value, bool) or value < least:
        raise ModelError(f"{what}: expected a whole number from {least}, found {value!r}")
    return int(value)


def vector(value, what: str, size: int = 2) -> tuple[float, ...]:
    """So many numbers, such as a place; ModelError that names the argument."""
    try:
        found = tuple(float(one) for one in value)
    except (TypeError, ValueError):
        found = ()
    if len(found) != size or not all(map(math.isfinite, found)):
        words = "two numbers (x, y)" if size == 2 else f"{size} numbers"  # noqa: PLR2004  x and y
        raise ModelError(f"{what}: expected {words}, found {value!r}")
    return found


def place(value, what: str) -> tuple[float, float]:
    """A place (x, y); ModelError that names the argument."""
    x, y = vector(value, what)
    return x, y


def places(value, what: str, least: int) -> list[tuple[float, float]]:
    """A list of places, at least so many; ModelError that names the argument."""
    if isinstance(value, str) or not isinstance(value, Iterable):
        raise ModelError(f"{what}: expected a list of places (x, y), found {value!r}")
    found = [place(one, what) for one in value]
    if len(found) < least:
        raise ModelError(f"{what}: expected at least {least} places (x, y), found {len(found)}")
    return found


def text(value, what: str) -> str:
    """A name; ModelError that names the argument."""
    if not isinstance(value, str) or not value.strip() or any(sign in value for sign in "'\"\n!#"):
        raise ModelError(f"{what}: expected a name without quotes, ! and #, found {value!r}")
    return value


def one_of(value, choices: Iterable[str], what: str) -> str:
    """One of some words; ModelError that names the argument."""
    if value not in choices:
        raise ModelError(f"{what}: expected one of {', '.join(choices) or 'none, as there are none'}, found {value!r}")
    return value
