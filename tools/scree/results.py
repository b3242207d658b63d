"""Reads results files (doc/results.md says what is in them)."""
import json
import os
import pathlib

import h5py
import numpy as np

from .errors import ResultsError

GIVEN_AS = {"fixed": 1, "load": 2, "measured": 3}  # /points/kind
STEPS = ("search", "alone", "assemble", "factor", "solve", "judge", "friction", "restitution", "check", "update", "sleep")


def read(path):
    """The results of a file of `scree run` or `scree cut`."""
    return Results(path)


class Group:
    """A group of a results file: its datasets as arrays, its groups and its attributes, by their names in doc/results.md.

    Arrays are read when they are asked for, and kept. `group.energy.kinetic` and `group["energy/kinetic"]` are the same; `in` and
    iteration go over the names. Texts are str.
    """

    def __init__(self, results, name):
        self._results, self._name, self._read = results, name, {}

    def __getitem__(self, name):
        if name not in self._read:
            self._read[name] = self._results._fetch(self._name, name)
        return self._read[name]

    def __getattr__(self, name):
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError as problem:
            raise AttributeError(problem.args[0]) from None

    def __contains__(self, name):
        with self._results._open() as f:
            return f"{self._name}/{name}" in f

    def __iter__(self):
        with self._results._open() as f:
            return iter(list(f[self._name or "/"]))

    def __dir__(self):
        with self._results._open() as f:
            return [*super().__dir__(), *f[self._name or "/"], *f[self._name or "/"].attrs]

    def units(self, name):
        """The dimension of a dataset, such as force/length^2."""
        return self._results._attribute(f"{self._name}/{name}", "units")

    def description(self, name):
        """What a dataset is, in words."""
        return self._results._attribute(f"{self._name}/{name}", "description")

    def series(self):
        """Names of all datasets in it and below, such as energy/kinetic."""
        names = []
        with self._results._open() as f:
            f[self._name or "/"].visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
        return names


class Contacts:
    """The closed contacts of a frame, a row each: `blocks` of the vertex and of the edge, `state` (1 sliding, 2 locked), `place` of
    the vertex, outer `normal` of the edge, `force` on the block of the vertex along the normal and the normal turned left."""

    def __init__(self, group, rows):
        self.blocks, self.state, self.place, self.normal, self.force = (
            group[name][rows] for name in ("blocks", "state", "place", "normal", "force"))

    def __len__(self):
        return len(self.state)


class Results(Group):
    """The results of a run.

    What the file has is found by its names: `r.history.time`, `r.history.energy.kinetic`, `r.history.rotation` at the end of each
    step; `r.bodies.centroid`, `r.bodies.stress` of each block in each frame; `r.measured_points.displacement`; `r.scene.status`,
    `r.scene.settings`. Frames count from 0, the start, and from -1, the last; blocks are columns from 0 in arrays, and their
    numbers from 1 are those of the deck. Of a run that was killed the rows that all series have are there.
    """

    def __init__(self, path):
        super().__init__(self, "")
        self.path = pathlib.Path(path)
        try:
            self._stamp = self._stamp_now()
            with h5py.File(self.path) as f:
                if "VTKHDF" not in f or "history" not in f:
                    raise ResultsError(f"{path}: expected a results file of scree, found another HDF5 file")
                self.n_frames = int(f["VTKHDF/Steps"].attrs["NSteps"])
                self.n_elements = len(f["VTKHDF/Offsets"]) - 1
                self._n_vertices = int(f["VTKHDF/NumberOfPoints"][0]) if len(f["VTKHDF/NumberOfPoints"]) else 0
                self._rows = self._rows_that_count(f)
        except OSError as problem:
            raise ResultsError(f"{path}: expected a results file, found: {str(problem).splitlines()[0]}") from None
        except KeyError as problem:
            raise ResultsError(f"{path}: expected a results file of scree, found one without {problem.args[0]}") from None

    def __repr__(self):
        return f"<results {self.path}: {self.n_blocks} blocks, {self.n_frames} frames, {self.scene.status}>"

    def _rows_that_count(self, f):
        """How many rows of each group count."""
        steps = []
        for group in ("history", "measured_points"):
            if group in f:
                f[group].visititems(lambda _, item: steps.append(len(item)) if isinstance(item, h5py.Dataset) else None)
        n_steps = min(steps, default=0)
        return {"history": n_steps, "measured_points": n_steps, "bodies": self.n_frames, "bolts": self.n_frames}

    def _stamp_now(self):
        found = os.stat(self.path)
        return found.st_ino, found.st_size, found.st_mtime_ns

    def _open(self):
        """The open file, if it is still the one that was read."""
        try:
            unchanged = self._stamp_now() == self._stamp
        except OSError:
            unchanged = False
        if not unchanged:
            raise ResultsError(f"{self.path}: has changed since it was read: read it again")
        return h5py.File(self.path)

    def _fetch(self, group, name):
        """A group, an array, a text or an attribute."""
        path = f"{group}/{name}".strip("/")
        with self._open() as f:
            item = f.get(path)
            if isinstance(item, h5py.Group):
                return Group(self, path)
            if item is not None:
                value = item[()]
                rows = self._rows.get(path.split("/")[0])
                return as_text(value if rows is None else value[:rows])
            attributes = f[group or "/"].attrs
            if name in attributes:
                return as_text(attributes[name])
            raise KeyError(f"{self.path}: expected {path}, found {', '.join([*f[group or '/'], *attributes])}; "
                           "what a scene does not call for has no dataset")

    def _attribute(self, path, name):
        with self._open() as f:
            return as_text(f[path.strip("/")].attrs[name])

    @property
    def summary(self):
        """What the run came to, as `--summary json` prints it (doc/results.md); None where it has not ended, or was no run."""
        return json.loads(self["ending/summary"][0]) if "ending/summary" in self else None

    @property
    def warnings(self):
        """The warnings that the run gave; of one that has not ended none are known."""
        return list(self["ending/warnings"]) if "ending/warnings" in self else []

    # Frames

    @property
    def times(self):
        """Time of each frame (f)."""
        return self["VTKHDF/Steps/Values"][:self.n_frames]

    @property
    def frame_steps(self):
        """Number of the step that each frame is the end of (f); 0 for the start."""
        return np.searchsorted(np.append(0.0, self.history.time), self.times)

    @property
    def n_blocks(self):
        return self["bodies/area"].shape[1]

    @property
    def block(self):
        """Number of the block of each element (e), from 1. A block of DDA is one element."""
        return self["VTKHDF/CellData/block"]

    @property
    def material(self):
        """Number of the material of each element (e), from 1."""
        return self["VTKHDF/CellData/material"]

    def _frame(self, frame):
        """Its number from 0."""
        if not -self.n_frames <= frame < self.n_frames:
            raise IndexError(f"{self.path}: expected a frame from 0 to {self.n_frames - 1}, found {frame}")
        return frame % self.n_frames

    def _of_frame(self, name, frame, n):
        """The rows of a frame, n each, of a dataset below VTKHDF that has all frames one after the other; others are not read."""
        frame = self._frame(frame)
        with self._open() as f:
            return f[f"VTKHDF/{name}"][n * frame:n * (frame + 1)]

    def vertices(self, frame=-1):
        """Places of all vertices in a frame (v, 2)."""
        return self._of_frame("Points", frame, self._n_vertices)[:, :2]

    def displacement(self, frame=-1):
        """Of all vertices since the start (v, 2)."""
        return self._of_frame("PointData/displacement", frame, self._n_vertices)[:, :2]

    def velocity(self, frame=-1):
        """Of all vertices (v, 2)."""
        return self._of_frame("PointData/velocity", frame, self._n_vertices)[:, :2]

    def stress(self, frame=-1):
        """Cauchy stress of all elements (e, 3): xx, yy, xy, tension positive. That of blocks is bodies.stress."""
        return np.stack([self._of_frame(f"CellData/stress_{c}", frame, self.n_elements) for c in ("xx", "yy", "xy")], axis=1)

    def corners(self):
        """For each element the vertices that its polygon runs through, counter-clockwise, as rows of `vertices`."""
        return np.split(self["VTKHDF/Connectivity"], self["VTKHDF/Offsets"][1:-1])

    def polygons(self, frame=-1):
        """The polygon of each element in a frame, an array (n, 2) each."""
        vertices = self.vertices(frame)
        return [vertices[corners] for corners in self.corners()]

    def contacts_of(self, frame=-1):
        """The closed contacts of a frame; None where the scene has no contact."""
        if "contacts" not in self:
            return None
        frame, count = self._frame(frame), self["contacts/count"]
        return Contacts(self["contacts"], slice(count[:frame].sum(), count[:frame + 1].sum()))

    # Points, costs

    def given_points(self, kind):
        """Places (n, 2) at the start of the points of a kind: fixed, load or measured."""
        if "points" not in self:
            return np.empty((0, 2))
        return self["points/place"][self["points/kind"] == GIVEN_AS[kind]]

    def seconds(self, phase, of="wall"):
        """What a phase took (doc/results.md), or all that make up the steps (`steps`), of the `wall` or of the `processor`; 0 where
        there was none."""
        phases = STEPS if phase == "steps" else (phase,)
        return float(self[f"cost/{of}_seconds"][np.isin(self["cost/phase"], phases)].sum())


def as_text(value):
    """Texts as str, without the blanks at their ends; numbers as they are."""
    if isinstance(value, bytes):
        return value.decode().rstrip()
    if isinstance(value, np.ndarray) and value.dtype.kind in "SO":
        return np.array([as_text(text) for text in value.ravel()]).reshape(value.shape)
    return value
