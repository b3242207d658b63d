"""The scene of a rock fall: the slope, its materials, the rocks that start, a barrier and collectors, as a TOML file says them."""
from __future__ import annotations

import dataclasses
import math
import pathlib
import tomllib
import typing
from collections.abc import Mapping

import numpy as np

from ..errors import ScreeError
from ..program import StrPath
from ..studies.tables import draw

GRAVITY, KILO = 9.81, 1e3
ROCK, OUT, BARRIER = "falling rock", "beyond the slope", "barrier"  # joint materials that the scene adds: of rocks, of the ground beyond the slope, of a barrier
ADDED = {ROCK: (89.0, 1.0), OUT: (89.0, 0.0), BARRIER: (30.0, 0.0)}  # friction angle in degrees, restitution; that of less friction counts
KNOWN = {"title", "slope", "ground", "materials", "start", "rock", "barrier", "collectors", "number", "seed", "time", "step", "gravity"}
TABLES = {"start": {"line", "velocity", "spin"}, "rock": {"size", "density", "corners", "elongation", "angle"},
          "barrier": {"x", "height", "thickness", "phi", "restitution"}}
CLEAR = 1e-3  # of its size: how far a rock starts above the slope at least


@dataclasses.dataclass
class Rock:
    """A rock that starts: corners counter-clockwise about the origin (n, 2), size, place of its centre, velocity (x, y, spin), friction angle
    and restitution by material."""

    corners: np.ndarray
    size: float
    place: np.ndarray
    velocity: tuple[float, float, float]
    laws: dict[str, tuple[float, float]]


class RockFall:
    """A scene: `surface` of the slope (n, 2) from left to right with the material of each part, and `rocks`."""

    def __init__(self, given: Mapping[str, typing.Any], source: str = "rockfall") -> None:
        self.source = source
        self._check_names("", given, KNOWN)
        for name, known in TABLES.items():
            self._check_names(name, given.get(name, {}), known)
        self.title = str(given.get("title", source))
        self.slope = self._points(given, "slope")
        if len(self.slope) < 2 or (np.diff(self.slope[:, 0]) <= 0).any():  # noqa: PLR2004  a line
            raise self._wrong("slope", "two places [x, y] or more, with ascending x", given.get("slope"))
        self.materials = dict(given.get("materials", {}))
        if not self.materials or set(self.materials) & set(ADDED):
            raise self._wrong("materials", f"tables of phi and restitution, with names other than {', '.join(ADDED)}", list(self.materials))
        ground = given.get("ground", next(iter(self.materials)))
        self.ground = [ground] * (len(self.slope) - 1) if isinstance(ground, str) else list(ground)
        if len(self.ground) != len(self.slope) - 1 or not set(self.ground) <= set(self.materials):
            raise self._wrong("ground", f"a material for each of the {len(self.slope) - 1} parts of the slope: {', '.join(self.materials)}", ground)
        self.number, self.seed = self._whole(given, "number", 100), self._whole(given, "seed", 1)
        self.time, self.step = self._above(given, "time", 60.0), self._above(given, "step", 0.01)
        self.gravity = self._above(given, "gravity", GRAVITY)
        self.barrier = given.get("barrier")
        self.collectors = {str(name): float(x) for name, x in given.get("collectors", {}).items()}
        self.density = self._above(given.get("rock", {}), "density", 2650.0)
        self.laws = dict(ADDED)
        if self.barrier:
            self.laws[BARRIER] = (float(self.barrier.get("phi", ADDED[BARRIER][0])), float(self.barrier.get("restitution", ADDED[BARRIER][1])))
        self.rocks = self._rocks(given)

    @classmethod
    def read(cls, path: StrPath, number: int | None = None) -> RockFall:
        """The scene of a TOML file, with another number of rocks where one is given; ScreeError where it is none."""
        path = pathlib.Path(path)
        try:
            given = tomllib.loads(path.read_text(encoding="utf-8-sig"))
            return cls(given | ({"number": number} if number else {}), str(path))
        except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as problem:
            raise ScreeError(f"{path}: expected the TOML file of a rock fall, found: {problem}") from None

    def _wrong(self, name, expected, found):
        return ScreeError(f"{self.source}: expected {expected} for {name}, found {found!r}")

    def _check_names(self, table, given, known):
        """ScreeError where a table has a name that means nothing."""
        if unknown := [name for name in given if name not in known]:
            raise ScreeError(f"{self.source}: expected {', '.join(sorted(known))}{f' in [{table}]' if table else ''}, found {unknown[0]}")

    def _points(self, given, name):
        try:
            points = np.array(given[name], float).reshape(-1, 2)
        except (KeyError, TypeError, ValueError):
            raise self._wrong(name, "places [x, y]", given.get(name)) from None
        return points

    def _above(self, given, name, default):
        """A number above 0."""
        value = given.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0 < value < math.inf:
            raise self._wrong(name, "a number above 0", value)
        return float(value)

    def _whole(self, given, name, default):
        value = given.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int) or value < 1:
            raise self._wrong(name, "a whole number from 1", value)
        return value

    def _drawn(self, name, what):
        """A value of each rock: the same number, or one from a range, a normal distribution or a list."""
        if isinstance(what, int | float) and not isinstance(what, bool):
            return [float(what)] * self.number
        try:
            return draw(name, what, self.number, f"{self.seed} {name}")
        except (ValueError, TypeError, KeyError):
            raise self._wrong(name, "a number, a list, {from, to} or {mean, deviation}", what) from None

    def _rocks(self, given):
        """The rocks, one from each part of equal probability of all that varies."""
        start, rock = given.get("start", {}), given.get("rock", {})
        line = self._points(start, "line")
        along = self._drawn("start.line", {"from": 0.0, "to": 1.0})
        size, angle = self._drawn("rock.size", rock.get("size", 1.0)), self._drawn("rock.angle", rock.get("angle", {"from": 0.0, "to": 360.0}))
        corners, elongation = self._drawn("rock.corners", rock.get("corners", [5, 6, 7, 8])), self._drawn("rock.elongation", rock.get("elongation", 1.3))
        velocity = [self._drawn(f"start.velocity.{k}", one) for k, one in zip("xy", start.get("velocity", (0, 0)))]
        spin = self._drawn("start.spin", start.get("spin", 0))
        laws = {name: (self._drawn(f"{name}.phi", law.get("phi", 35)), self._drawn(f"{name}.restitution", law.get("restitution", 0.3)))
                for name, law in self.materials.items()}
        surface, found = self.surface()[0], []
        length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        for i in range(self.number):
            if corners[i] < 3 or size[i] <= 0 or elongation[i] < 1:  # noqa: PLR2004  a polygon
                raise self._wrong("rock", "a size above 0, corners from 3 and an elongation from 1", (size[i], corners[i], elongation[i]))
            shape = rock_shape(int(corners[i]), size[i], elongation[i], math.radians(angle[i]))
            place = np.array([np.interp(along[i] * length[-1], length, line[:, k]) for k in (0, 1)])
            place[1] = max(place[1], least_height(shape, place[0], surface) + CLEAR * size[i])
            found.append(Rock(shape, size[i], place, (velocity[0][i], velocity[1][i], spin[i]),
                              {name: (phi[i], restitution[i]) for name, (phi, restitution) in laws.items()} | self.laws))
        return found

    def surface(self) -> tuple[np.ndarray, list[str]]:
        """Places of the surface from left to right (n, 2), with the barrier and the ground beyond the slope, and the material of each part."""
        beyond = np.ptp(self.slope[:, 0])
        points, materials = self.slope, list(self.ground)
        if self.barrier:
            points, materials = self._with_barrier(points, materials)
        first, last = points[0] - [beyond, 0], points[-1] + [beyond, 0]
        return np.vstack([first, points, last]), [OUT, *materials, OUT]

    def _with_barrier(self, points, materials):
        """The surface with a wall on it."""
        x, height = (self._above(self.barrier, name, None) for name in ("x", "height"))
        half = self._above(self.barrier, "thickness", 0.5) / 2
        if not points[0, 0] < x - half < x + half < points[-1, 0]:
            raise self._wrong("barrier.x", "a place on the slope", x)
        foot = [(end, float(np.interp(end, *points.T))) for end in (x - half, x + half)]
        top = max(y for _, y in foot) + height
        before, after = points[:, 0] < x - half, points[:, 0] > x + half
        wall = [foot[0], (x - half, top), (x + half, top), foot[1]]
        return (np.vstack([points[before], wall, points[after]]),
                [*materials[:before.sum()], BARRIER, BARRIER, BARRIER, *materials[len(materials) - after.sum():]])

    def height_above(self, places: np.ndarray) -> np.ndarray:
        """How high places (n, 2) are above the slope, without the barrier (n)."""
        return places[:, 1] - np.interp(places[:, 0], *self.slope.T)


def rock_shape(corners: int, size: float, elongation: float, angle: float) -> np.ndarray:
    """Corners (n, 2) of a convex rock about its centroid: of a regular polygon that is drawn out, turned by an angle in radians. Its area is
    that of a circle with the size as its diameter."""
    at = 2 * math.pi * (np.arange(corners) + 0.5) / corners
    shape = np.stack([math.sqrt(elongation) * np.cos(at), np.sin(at) / math.sqrt(elongation)], axis=1)
    area = corners / 2 * math.sin(2 * math.pi / corners)
    c, s = math.cos(angle), math.sin(angle)
    return math.sqrt(math.pi / 4 / area) * size * shape @ np.array([[c, s], [-s, c]])


def least_height(shape: np.ndarray, x: float, surface: np.ndarray) -> float:
    """The lowest y of the centre of a rock at x, at which no part of the rock lies in the ground."""
    at = np.unique(np.concatenate([x + shape[:, 0], surface[np.abs(surface[:, 0] - x) < np.abs(shape[:, 0]).max(), 0]]))
    return max(float(np.interp(one, *surface.T)) - underside(shape, one - x) for one in at)


def underside(shape: np.ndarray, x: float) -> float:
    """The lowest y of a convex polygon at x, above which its inside begins."""
    heights = []
    for (x1, y1), (x2, y2) in zip(shape, np.roll(shape, -1, axis=0)):
        if min(x1, x2) - 1e-12 <= x <= max(x1, x2) + 1e-12:
            heights.append(min(y1, y2) if x1 == x2 else y1 + (x - x1) / (x2 - x1) * (y2 - y1))
    return min(heights) if heights else float(shape[:, 1].max())
