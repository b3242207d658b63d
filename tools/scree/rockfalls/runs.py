"""The runs of a rock fall, a rock each in a process of its own, and the path of each rock."""
from __future__ import annotations

import concurrent.futures
import dataclasses
import os
import pathlib
import tempfile
from collections.abc import Callable

import numpy as np

from ..block_files import block_file, held
from ..program import StrPath, run
from ..records import Bar, stopped_at_once
from ..results import Results
from .scene import ROCK, Rock, RockFall

ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
SLOW = 0.02      # of the speed of a fall from its own size, below which a rock is at rest
STILL = 1e-6     # of this speed, below which a run ends: what rests in equilibrium is slower, what only turns back is faster
LOOK = 500       # steps after which a run is looked at; a restart takes as long as some hundred of them
DEEP = 0.25      # of the width of the slope: how deep the ground goes below its lowest place


@dataclasses.dataclass
class Path:
    """The path of a rock until it comes to rest, leaves the slope, or the time ends: `time` (t), `place` and `velocity` of its centre
    (t, 2), `energy` of translation and rotation of a rock as thick as its size (t); `end` is rest, out or moving."""

    rock: Rock
    mass: float
    time: np.ndarray
    place: np.ndarray
    velocity: np.ndarray
    energy: np.ndarray
    end: str

    @property
    def speed(self) -> np.ndarray:
        """Of the centre (t)."""
        return np.linalg.norm(self.velocity, axis=1)

    def at(self, x: float) -> tuple[float, ...] | None:
        """Time, y, speed and energy where the centre first passes x, on a straight line between two steps; None where it does not."""
        side = np.sign(self.place[:, 0] - x)
        passed = np.flatnonzero((side[1:] != side[:-1]) & (side[1:] != 0))
        if len(passed) == 0:
            return None
        k = int(passed[0])
        share = (x - self.place[k, 0]) / (self.place[k + 1, 0] - self.place[k, 0])
        return tuple(float(values[k] + share * (values[k + 1] - values[k])) for values in (self.time, self.place[:, 1], self.speed, self.energy))


def decks(scene: RockFall, rock: Rock, folder: pathlib.Path) -> list[pathlib.Path]:
    """Writes the decks of the run of a rock. The rock is block 1; each part of the ground is a column that is held."""
    surface, parts = scene.surface()
    names = list(dict.fromkeys([*parts, ROCK]))
    number = {name: k for k, name in enumerate(names, 1)}
    low = surface[:, 1].min() - DEEP * np.ptp(scene.slope[:, 0])
    columns = [(1, [(x1, low), (x2, low), (x2, y2), (x1, y1)], [number[name]] * 4)
               for name, (x1, y1), (x2, y2) in zip(parts, surface, surface[1:]) if x2 > x1]
    points = [(*point[:2], k) for k, (_, corners, _) in enumerate(columns, 2) for point in held(corners[:2] + [np.mean(corners, axis=0)], k)[:2]]
    blocks = [(2, rock.corners + rock.place, [number[ROCK]] * len(rock.corners)), *columns]
    (folder / "fall.blk").write_text(block_file(scene.title.replace("\n", " "), blocks, points, measured=[(*rock.place, 1)]))
    weight = scene.density * scene.gravity
    rows = [f"1 {max(1, round(scene.time / scene.step))} 2 {len(names)} 0.05 {scene.step}",
            f"{scene.density} 0 1e10 0.25 0 0 0 0 0 0 0 0 0",
            f"{scene.density} {weight} 1e10 0.25 0 0 0 0 0 0 " + " ".join(repr(float(v)) for v in rock.velocity),
            *(f"{rock.laws[name][0]} 0 0" for name in names),
            "&deck dialect='short', geometry='fall.blk' /", "&integrator scheme='small_steps' /", "&output every=999999999 /",
            f"&joints restitution={' '.join(repr(float(rock.laws[name][1])) for name in names)} /"]
    (folder / "fall.ana").write_text("\n".join(rows) + "\n")
    return [folder / "fall.ana"]


def fall(scene: RockFall, rock: Rock, path: StrPath | None = None) -> Path:
    """The path of a rock."""
    with tempfile.TemporaryDirectory() as folder:
        results = run(*decks(scene, rock, pathlib.Path(folder)), output=pathlib.Path(folder, "fall.h5"), path=path, env=os.environ | ONE_THREAD,
                      each=lambda so_far: is_under_way(scene, rock, so_far), every=LOOK)
        history, points = results.history, results.measured_points
        time, place, velocity = history.time, points.position[:, 0], points.velocity[:, 0]
        energy = history.energy.kinetic * rock.size
        area, inertia = float(results.bodies.area[0][0]), inertia_of(rock.corners)
    speed = np.linalg.norm(velocity, axis=1)
    start = np.array(rock.velocity[:2], float)
    first = scene.density * rock.size / 2 * (area * start @ start + inertia * rock.velocity[2] ** 2)
    time, place, velocity, energy = (np.concatenate([[one], values]) for one, values in (
        (0.0, time), (rock.place, place), (start, velocity), (first, energy)))
    slow = SLOW * np.sqrt(scene.gravity * rock.size)
    moving = np.flatnonzero(speed > slow)
    last, end = (moving[-1] + 2 if len(moving) else 1), "rest"
    if last > len(speed):
        last, end = len(speed), "moving"
    outside = np.flatnonzero((place[:, 0] < scene.slope[0, 0]) | (place[:, 0] > scene.slope[-1, 0]))
    if len(outside) and outside[0] <= last:
        last, end = int(outside[0]), "out"
    kept = slice(0, last + 1)
    return Path(rock, scene.density * area * rock.size, time[kept], place[kept], velocity[kept], energy[kept], end)


def is_under_way(scene: RockFall, rock: Rock, results: Results) -> bool:
    """Whether a rock moves, and is above the slope."""
    (x, _), velocity = results.measured_points.position[-1, 0], results.measured_points.velocity[-1, 0]
    return scene.slope[0, 0] <= x <= scene.slope[-1, 0] and np.hypot(*velocity) > STILL * np.sqrt(scene.gravity * rock.size)


def inertia_of(corners: np.ndarray) -> float:
    """The second moment of the area of a polygon about its centroid, the origin."""
    after = np.roll(corners, -1, axis=0)
    cross = corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]
    return float((cross * ((corners ** 2).sum(1) + (corners * after).sum(1) + (after ** 2).sum(1))).sum() / 12)


def all_falls(scene: RockFall, jobs: int | None = None, path: StrPath | None = None, show: Callable = Bar) -> list[Path]:
    """The paths of all rocks, in their order; so many runs at once."""
    bar, found = show("rock fall", len(scene.rocks), "rocks"), {}
    with concurrent.futures.ThreadPoolExecutor(jobs or len(os.sched_getaffinity(0))) as pool:
        waiting = {pool.submit(fall, scene, rock, path): i for i, rock in enumerate(scene.rocks)}
        with stopped_at_once(pool):
            for done in concurrent.futures.as_completed(waiting):
                found[waiting[done]] = done.result()
                bar.advance(f"rock {waiting[done] + 1}")
    bar.end()
    return [found[i] for i in range(len(scene.rocks))]
