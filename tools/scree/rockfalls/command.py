"""Lets many rocks fall on a slope, each in a run of its own, and draws paths, envelopes and histograms.

    tools/rockfall SCENE.toml [-o FOLDER] [--number N] [--jobs N]

The TOML file has the slope from left to right, its materials with friction and restitution, the line on which rocks start, what the rocks
are like, and where wanted a barrier and collectors (doc/howto/rock-fall.md). Units are kg, m and s.

FOLDER, by default the name of the file with -fall, holds rocks.csv with a line for each rock, collectors.csv with one for each rock that
passes a collector, paths.png and histograms.png. Exit status 0; 2 for bad input.
"""
from __future__ import annotations

import csv
import dataclasses
import pathlib
import typing
from collections.abc import Mapping

import numpy as np

from ..arguments import ends_in_a_line, parser_for, whole_from
from ..errors import ScreeError
from ..program import StrPath, made_folder
from ..records import Bar
from .runs import Path, all_falls
from .scene import BARRIER, KILO, RockFall

ROCKS, COLLECTED, PATHS, HISTOGRAMS = "rocks.csv", "collectors.csv", "paths.png", "histograms.png"


@dataclasses.dataclass
class Falls:
    """What a rock fall came to: the scene, the path of each rock, and for each collector a row for each rock that passed it: rock, time,
    height of the centre above the slope, speed, energy (J, of a rock as thick as its size)."""

    scene: RockFall
    paths: list[Path]
    collected: dict[str, list[dict[str, float]]]

    @property
    def run_out(self) -> np.ndarray:
        """x where each rock ends."""
        return np.array([path.place[-1, 0] for path in self.paths])

    def stopped(self) -> int:
        """How many rocks come to rest before the barrier, on the side of their start."""
        if self.scene.barrier is None:
            raise ScreeError("stopped(): expected a scene with a barrier, found none")
        x = self.scene.barrier["x"]
        return sum(path.end == "rest" and (path.place[-1, 0] - x) * (path.place[0, 0] - x) > 0 for path in self.paths)

    def plot(self) -> typing.Any:
        """A figure with the paths and the envelopes."""
        from .pictures import draw_paths  # here, as matplotlib takes a second to begin
        return draw_paths(self.scene, self.paths)

    def histograms(self) -> typing.Any:
        """A figure with the histograms."""
        from .pictures import draw_histograms  # here, as matplotlib takes a second to begin
        return draw_histograms(self.scene, self.paths, self.collected)


def rockfall(scene: Mapping[str, typing.Any] | StrPath, jobs: int | None = None, path: StrPath | None = None, show: typing.Any = Bar) -> Falls:
    """Lets rocks fall, as `tools/rockfall` does: of a TOML file, or of its tables as a dictionary."""
    return falls_of(RockFall(scene) if isinstance(scene, Mapping) else RockFall.read(scene), jobs, path, show)


def falls_of(scene: RockFall, jobs: int | None = None, path: StrPath | None = None, show: typing.Any = Bar) -> Falls:
    """Runs a scene."""
    paths = all_falls(scene, jobs, path, show)
    return Falls(scene, paths, {name: list(passing(scene, paths, x)) for name, x in scene.collectors.items()})


def passing(scene: RockFall, paths: list[Path], x: float) -> typing.Iterator[dict[str, float]]:
    """A row for each rock that passes x."""
    for number, path in enumerate(paths, 1):
        if (found := path.at(x)) is not None:
            time, y, speed, energy = found
            yield {"rock": number, "time": time, "height": float(scene.height_above(np.array([[x, y]]))[0]), "speed": speed, "energy": energy}


def write_tables(falls: Falls, folder: pathlib.Path) -> None:
    """Writes the tables of rocks and of collectors."""
    with (folder / ROCKS).open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["rock", "size", "mass", "start_x", "start_y", "end", "time", "end_x", "end_y", "largest_speed", "largest_energy"])
        for number, path in enumerate(falls.paths, 1):
            writer.writerow([number, path.rock.size, path.mass, *path.place[0], path.end, path.time[-1], *path.place[-1],
                             path.speed.max(), path.energy.max()])
    with (folder / COLLECTED).open("w", newline="") as file:
        rows = [{"collector": name} | row for name, found in falls.collected.items() for row in found]
        of_rows = csv.DictWriter(file, ["collector", "rock", "time", "height", "speed", "energy"], lineterminator="\n")
        of_rows.writeheader()
        of_rows.writerows(rows)


def words_of(falls: Falls) -> typing.Iterator[str]:
    """What the rock fall came to, in lines."""
    ends = [path.end for path in falls.paths]
    yield (f"{len(ends)} rocks: {ends.count('rest')} come to rest, {ends.count('out')} leave the slope" +
           (f", {ends.count('moving')} still move: try a longer time" if "moving" in ends else ""))
    if falls.scene.barrier:
        yield f"{BARRIER}: {falls.stopped()} rocks come to rest before it"
    for name, rows in falls.collected.items():
        if not rows:
            yield f"{name}: no rock comes"
            continue
        usual, most = ({key: measure([row[key] for row in rows]) for key in ("height", "speed", "energy")}
                       for measure in (lambda values: np.percentile(values, 95), max))
        yield (f"{name}: {len(rows)} rocks; 95 % below a height of {usual['height']:.3g} m, {usual['speed']:.3g} m/s, {usual['energy'] / KILO:.3g} kJ; "
               f"at most {most['height']:.3g} m, {most['speed']:.3g} m/s, {most['energy'] / KILO:.3g} kJ")


@ends_in_a_line
def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("scene", type=pathlib.Path, metavar="SCENE")
    parser.add_argument("--number", type=whole_from(1), metavar="N", help="how many rocks; default: what the file says, or 100")
    parser.add_argument("--jobs", type=whole_from(1), metavar="N", help="runs at once; default: one for each processor")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="FOLDER")
    given = parser.parse_args()
    scene = RockFall.read(given.scene, given.number)
    folder = made_folder(given.output or pathlib.Path(f"{given.scene.stem}-fall"))
    falls = falls_of(scene, given.jobs, given.scree)
    write_tables(falls, folder)
    falls.plot().savefig(folder / PATHS, dpi=85)
    falls.histograms().savefig(folder / HISTOGRAMS, dpi=85)
    print(*words_of(falls), f"{folder}/{ROCKS}, {COLLECTED}, {PATHS}, {HISTOGRAMS}", sep="\n")
    return 0
