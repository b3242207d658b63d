"""Runs decks, and reads what the validation cases measure from the results file."""
import subprocess
import time

import h5py
import numpy as np


class RunFailed(Exception):
    """What the program said."""


class Results:
    """The results of one run. Block numbers are those of the deck, from 1; measured points count from 0."""

    def __init__(self, path):
        with h5py.File(path) as f:
            self.time = f["history/time"][:]
            self.turn = f["history/rotation"][:]
            self.area = f["history/area"][:]
            self.momentum = f["history/momentum"][:]
            self.energy = f["history/energy/kinetic"][:] + f["history/energy/strain"][:]
            self.dissipated = f["history/energy/dissipated"][:]
            self.centroid = f["bodies/centroid"][:]
            if "measured_points" in f:
                self.place = f["measured_points/position"][:]
                self.moved = f["measured_points/displacement"][:]
                self.velocity = f["measured_points/velocity"][:]
            ends = f["VTKHDF/Offsets"][:]
            corners = f["VTKHDF/Connectivity"][:]
            last = f["VTKHDF/Points"][-f["VTKHDF/NumberOfPoints"][-1]:, :2]
            self.polygons = [last[corners[a:b]] for a, b in zip(ends[:-1], ends[1:])]

    def at(self, time, values):
        """A history at a time, between its rows."""
        return np.interp(time, self.time, values)

    def largest_move(self, since=0.0):
        """Largest way of a centroid from a share of the frames to the last."""
        start = self.centroid[int(since * (len(self.centroid) - 1))]
        return np.linalg.norm(self.centroid[-1] - start, axis=1).max()


def worst_overlap(polygons):
    """Depth of the deepest corner of a polygon in another: its distance from the outline."""
    corners = np.concatenate(polygons)
    owner = np.repeat(np.arange(len(polygons)), [len(p) for p in polygons])
    worst = 0.0
    for j, polygon in enumerate(polygons):
        near = (owner != j) & np.all((corners > polygon.min(0)) & (corners < polygon.max(0)), axis=1)
        p, a, b = corners[near][:, None], polygon, np.roll(polygon, -1, axis=0)
        side = b - a
        crosses = (a[:, 1] > p[..., 1]) != (b[:, 1] > p[..., 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            right = p[..., 0] < a[:, 0] + (p[..., 1] - a[:, 1]) * side[:, 0] / side[:, 1]
        inside = (crosses & right).sum(1) % 2 == 1
        share = np.clip(((p - a) * side).sum(2) / (side**2).sum(1), 0, 1)
        depth = np.linalg.norm(p - a - share[..., None] * side, axis=2).min(1) if near.any() else np.zeros(0)
        worst = max(worst, depth[inside].max(initial=0.0))
    return worst


class Runner:
    """Runs the program into a folder and adds up its seconds."""

    def __init__(self, program, folder):
        self.program, self.folder, self.seconds = program, folder, 0.0

    def __call__(self, deck, geometry=None, settings=(), name=None):
        """Runs an analysis deck; the geometry as (name, text) where the deck names none."""
        words = []
        if geometry:
            path = self.folder / geometry[0]
            path.write_text(geometry[1])
            words.append(path)
        words.append(deck)
        for setting in settings:
            words += ["--set", setting]
        out = self.folder / f"{name or deck.parent.name + '-' + deck.stem}.h5"
        start = time.perf_counter()
        done = subprocess.run([self.program, "run", *words, "-o", out, "--quiet"], capture_output=True, text=True)
        self.seconds += time.perf_counter() - start
        if done.returncode != 0:
            raise RunFailed((done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[0])
        return Results(out)
