"""Reads results files (doc/results.md says what is in them)."""
from __future__ import annotations

import base64
import html
import io
import json
import os
import pathlib
import time
import typing
from collections.abc import Callable, Iterator, Sequence

import h5py
import numpy as np

from . import tables
from .errors import ResultsError, reason_of

if typing.TYPE_CHECKING:
    import pandas
    from shapely.geometry import Polygon

    from .model.reactions import Support
    from .model.views import Bolts, Joint, Line

GIVEN_AS = {"fixed": 1, "load": 2, "measured": 3}  # /points/kind
STEPS = ("search", "alone", "assemble", "factor", "solve", "judge", "friction", "restitution", "check", "update", "sleep")
OF_TIPS = "history/cracks"  # arrays by step and tip, which the file has as a table
LATER = -1  # the joint of an edge that a crack makes after a frame
LOOKS, PAUSE = 40, 0.01  # how often a run that goes on is looked at where a write is under way, and seconds between two looks
TORN = (OSError, KeyError, RuntimeError, ValueError)  # what h5py raises where a write is under way


def read(path: str | os.PathLike) -> Results:
    """The results of a file of `scree run` or `scree cut`."""
    return Results(path)


class Absent(Exception):
    """What a file has not."""


class Group:
    """A group of a results file: its datasets as arrays, its groups and its attributes, by their names in doc/results.md.

    Arrays are read when they are asked for, and kept. `group.energy.kinetic` and `group["energy/kinetic"]` are the same; `in` and
    iteration go over the names. Texts are str.
    """

    def __init__(self, results: Results, name: str) -> None:
        self._results, self._name = results, name
        self._read: dict[str, typing.Any] = {}

    def __getitem__(self, name: str) -> typing.Any:
        if name not in self._read:
            self._read[name] = self._results._fetch(self._name, name)
        return self._read[name]

    def __getattr__(self, name: str) -> typing.Any:
        if name.startswith("_"):
            raise AttributeError(name)
        try:
            return self[name]
        except KeyError as problem:
            raise AttributeError(problem.args[0]) from None

    def __contains__(self, name: str) -> bool:
        return self._results._look(lambda f: in_file(f"{self._name}/{name}") in f)

    def __iter__(self) -> Iterator[str]:
        return iter(self._results._look(lambda f: list(f[in_file(self._name) or "/"])))

    def __dir__(self) -> list[str]:
        return [*super().__dir__(), *self._results._look(lambda f: [*f[in_file(self._name) or "/"], *f[in_file(self._name) or "/"].attrs])]

    def units(self, name: str) -> str:
        """The dimension of a dataset, such as force/length^2."""
        return self._results._attribute(f"{self._name}/{name}", "units")

    def description(self, name: str) -> str:
        """What a dataset is, in words."""
        return self._results._attribute(f"{self._name}/{name}", "description")

    def series(self) -> list[str]:
        """Names of all datasets in it and below, such as energy/kinetic."""
        def list_series(f):
            names = []
            f[self._name or "/"].visititems(lambda name, item: names.append(name) if isinstance(item, h5py.Dataset) else None)
            return names

        tips = [f"cracks/{name}" for name in ("K_I", "K_II", "place", "length")] if self._name == "history" and "cracks" in self else []
        return self._results._look(list_series) + tips


class Contacts:
    """The closed contacts of a frame, a row each: `blocks` of the vertex and of the edge, `state` (1 sliding, 2 locked), `place` of
    the vertex, outer `normal` of the edge, `force` on the block of the vertex along the normal and the normal turned left."""

    def __init__(self, group: Group, rows: slice) -> None:
        self.blocks, self.state, self.place, self.normal, self.force = (
            group[name][rows] for name in ("blocks", "state", "place", "normal", "force"))

    def __len__(self) -> int:
        return len(self.state)


class Layouts:
    """The polygons that frames have, one layout after the other where cracks grow. Elements and vertices of a run are those of the last
    layout: what they are in an earlier frame follows from the elements that they are parts of, whose fields are linear."""

    def __init__(self, f, n_frames):
        group = f["VTKHDF"]
        self.points, self.cells, self.corners = (group[name][()] for name in (
            "NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"))
        self.of_frame = np.asarray(group["Steps/PartOffsets"][:n_frames], int)
        self.points, self.cells, self.corners = (n[:self.of_frame.max(initial=0) + 1] for n in (self.points, self.cells, self.corners))
        self.count, self.parents = len(self.cells), {}
        last = self.count - 1
        self.last = {} if self.count == 1 else {
            "VTKHDF/Connectivity": self.corners_of_layout(last), "elements/joint": self.corners_of_layout(last),
            "VTKHDF/Offsets": slice(self.cells[:last].sum() + last, self.cells.sum() + self.count),
            "VTKHDF/CellData/block": self.cells_of_layout(last), "VTKHDF/CellData/material": self.cells_of_layout(last)}

    def cells_of_layout(self, layout):
        return slice(self.cells[:layout].sum(), self.cells[:layout + 1].sum())

    def corners_of_layout(self, layout):
        return slice(self.corners[:layout].sum(), self.corners[:layout + 1].sum())

    def rows(self, of, frame):
        """Rows of a frame in a dataset that has all frames one after the other."""
        n = getattr(self, of)[self.of_frame]
        return slice(n[:frame].sum(), n[:frame + 1].sum())

    def elements_of(self, results, frame):
        """For each element the one, from 0, that it is part of in a frame."""
        layout = self.of_frame[frame]
        if layout not in self.parents:
            elements = np.arange(self.cells[-1])
            for later in range(self.count - 1, layout, -1):
                elements = results._look(lambda f, later=later: f["elements/parent"][self.cells_of_layout(later)])[elements] - 1
            self.parents[layout] = elements
        return self.parents[layout]


    def carriers(self, results, elements, places):
        """Of points with their elements in the first layout, from 0, those in the last that hold their places at the start."""
        parents, cuts = self.elements_of(results, 0), results._cuts(0)
        found = np.empty(len(elements), int)
        for i, (element, place) in enumerate(zip(elements, places)):
            parts = np.flatnonzero(parents == element)
            found[i] = next((e for e in parts if winds_around(cuts.start[results.corners()[e]], place)), parts[0])
        return found


class Cuts:
    """What cracks have made of the elements of a layout: for each vertex the vertices of the element that it was of, with weights."""

    def __init__(self, results, layout):
        layouts = results._layouts
        frame = int(np.argmax(layouts.of_frame == layout))
        last = int(np.argmax(layouts.of_frame == layouts.count - 1))
        before, now = (results._rows_of("Points", k, "points")[:, :2] - results._rows_of("PointData/displacement", k, "points")[:, :2]
                       for k in (frame, last))
        first = layouts.cells[:layout].sum() + layout
        corner, offset, joint = results._look(lambda f: (
            f["VTKHDF/Connectivity"][layouts.corners_of_layout(layout)], f["VTKHDF/Offsets"][first:first + layouts.cells[layout] + 1],
            f["elements/joint"][layouts.corners_of_layout(layout)]))
        parents, near = layouts.elements_of(results, frame), 1e-9 * np.ptp(before, axis=0).max()
        self.start, self.source = now, np.zeros(len(now), int)
        self.made, self.joint = [], results["elements/joint"].copy()
        at = 0
        for corners, parent in zip(results.corners(), parents):
            own, of_own = (rows[offset[parent]:offset[parent + 1]] for rows in (corner, joint))
            if len(own) == len(corners) and np.abs(before[own] - now[corners]).max() <= near:
                self.source[corners], self.joint[at:at + len(corners)] = own, of_own
            else:
                affine = np.linalg.pinv(np.column_stack([before[own], np.ones(len(own))]))
                weights = np.column_stack([now[corners], np.ones(len(corners))]) @ affine
                apart = np.linalg.norm(now[corners][:, None] - before[own], axis=2)
                same = apart.min(axis=1) <= near  # a corner that was there keeps its numbers to the bit
                weights[same] = np.eye(len(own))[apart.argmin(axis=1)[same]]
                self.made.append((corners, own, weights))
                edges = before[own], before[np.roll(own, -1)], of_own
                middle = (now[corners] + now[np.roll(corners, -1)]) / 2
                self.joint[at:at + len(corners)] = [joint_at(place, *edges, near) for place in middle]
            at += len(corners)

    def field(self, values):
        """Values of the vertices from those of the layout."""
        field = values[self.source]
        for corners, own, weights in self.made:
            field[corners] = weights @ values[own]
        return field


def winds_around(polygon, place):
    """Whether a polygon holds a place."""
    (x, y), (to_x, to_y) = (polygon - place).T, (np.roll(polygon, -1, axis=0) - place).T
    return abs(np.arctan2(x * to_y - y * to_x, x * to_x + y * to_y).sum()) > np.pi


def joint_at(place, starts, ends, joint, near):
    """The joint material of the edges of an element at a place; LATER where the place is inside of the element."""
    along = ends - starts
    share = np.clip(((place - starts) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300), 0, 1)
    return joint[np.linalg.norm(starts + share[:, None] * along - place, axis=1) <= near].max(initial=LATER)


def opened(path):
    """A file of HDF5 for reading. A run locks its file in a way of its own, so a lock of HDF5 is not needed, and it is left out on
    systems without locks. It is asked for first, because HDF5 refuses a file that the same process has open with another choice."""
    try:
        return h5py.File(path, "r")
    except OSError:
        return h5py.File(path, "r", locking=False)


class Results(Group):
    """The results of a run.

    What the file has is found by its names: `r.history.time`, `r.history.energy.kinetic`, `r.history.rotation` at the end of each
    step; `r.bodies.centroid`, `r.bodies.stress` of each block in each frame; `r.measured_points.displacement`; `r.scene.status`,
    `r.scene.settings`. Frames count from 0, the start, and from -1, the last; blocks are columns from 0 in arrays, and their
    numbers from 1 are those of the deck. Of a run that was killed the rows that all series have are there.

    A run that goes on is read as far as it was when it was opened; its `scene.status` is running. Later frames are there where it is
    read again. The file is opened without a lock, so that the run does not mind, and a file system without locks does not either.
    """

    def __init__(self, path: str | os.PathLike) -> None:
        super().__init__(self, "")
        self._read_cuts: dict[int, typing.Any] = {}
        self.path = pathlib.Path(path)
        self._goes_on = True  # as far as is known
        try:
            self._stamp = self._stamp_now()
            self._look(self._take_counts)
        except OSError as problem:
            raise ResultsError(f"{path}: expected a results file, found: {reason_of(problem)}") from None
        except KeyError as problem:
            raise ResultsError(f"{path}: expected a results file of scree, found one without {problem.args[0]}") from None

    def _take_counts(self, f):
        """Takes from the open file what says how much of it counts."""
        self._goes_on = "scene" in f and as_text(f["scene"].attrs.get("status", "")) == "running"
        if self._goes_on and not ("history" in f and f["VTKHDF/Steps"].attrs["NSteps"]):
            raise ResultsError(f"{self.path}: expected a frame, found a run that has written none, or not yet")
        if "VTKHDF" not in f or "history" not in f:
            raise ResultsError(f"{self.path}: expected a results file of scree, found another HDF5 file")
        self.n_frames = int(f["VTKHDF/Steps"].attrs["NSteps"])  # first, as what it counts is there before
        self._layouts = Layouts(f, self.n_frames)
        self.n_elements, self._n_vertices = (int(n[-1]) for n in (self._layouts.cells, self._layouts.points))
        self._rows = self._rows_that_count(f)

    def __repr__(self) -> str:
        return f"<results {self.path}: {self.n_blocks} blocks, {self.n_frames} frames, {self.scene.status}>"

    def _rows_that_count(self, f):
        """How many rows of each group count."""
        steps = []
        for group in ("history", "measured_points"):
            if group in f:
                f[group].visititems(lambda _, item: steps.append(len(item)) if isinstance(item, h5py.Dataset) else None)
        n_steps, n_tips = min(steps, default=0), min((len(item) for item in f.get("tips", {}).values()), default=0)
        return {"tips": n_tips, "history": n_steps, "measured_points": n_steps, "bodies": self.n_frames, "bolts": self.n_frames}

    def _stamp_now(self):
        """What tells a file from another one by its name, and from what it was."""
        found = os.stat(self.path)
        return (found.st_dev, found.st_ino), (found.st_size, found.st_mtime_ns)

    def _is_the_one_read(self):
        """Whether the file is still the one that was read: of a run that goes on the same file, else the same bytes."""
        try:
            now = self._stamp_now()
        except OSError:
            return False
        return now[0] == self._stamp[0] if self._goes_on else now == self._stamp

    def _look(self, at: Callable[[h5py.File], typing.Any]) -> typing.Any:
        """What a function finds in the open file, if that is still the one that was read.

        While a run writes, what is read may be new in part: then it is looked at again, with what describes the data read anew.
        """
        for again in range(LOOKS, 0, -1):
            if not self._is_the_one_read():
                raise ResultsError(f"{self.path}: has changed since it was read: read it again")
            try:
                with opened(self.path) as f:
                    return at(f)
            except TORN:
                if again == 1 or not self._goes_on or not self._is_changing():
                    raise
            time.sleep(PAUSE)

    def _is_changing(self):
        """Whether the file was written a short time ago, or its end is not yet there."""
        return time.time() - os.stat(self.path).st_mtime < LOOKS * PAUSE

    def _fetch(self, group, name):
        """A group, an array, a text or an attribute."""
        path = f"{group}/{name}".strip("/")

        def find(f):
            item = f.get(in_file(path))
            if isinstance(item, h5py.Group):
                return Group(self, path)
            if path in self._layouts.last:
                return item[self._layouts.last[path]]
            if path == "points/element" and self._layouts.count > 1:
                return self._layouts.carriers(self, item[()] - 1, f["points/place"][()]) + 1
            if item is not None:
                top = in_file(path).split("/")[0]
                return as_text(item[:self._rows[top]] if top in self._rows else item[()])
            attributes = f[group or "/"].attrs
            if name in attributes:
                return as_text(attributes[name])
            raise Absent(f"{self.path}: expected {path}, found {', '.join([*f[group or '/'], *attributes])}; "
                         "what a scene does not call for has no dataset")

        try:
            found = self._look(find)
        except Absent as problem:
            raise KeyError(problem.args[0]) from None
        return self._by_step(found) if group == OF_TIPS else found

    def _by_step(self, rows):
        """A column of the table of tips as an array with a row each step and a column each tip (s, t, ...); 0 where a tip is not there."""
        step, tip = np.searchsorted(self.history.time, self.tips.time), self.tips.tip
        values = np.zeros((len(self.history.time), tip.max(initial=0), *rows.shape[1:]))
        there = step < len(values)
        values[step[there], tip[there] - 1] = rows[there]
        return values

    def _attribute(self, path, name):
        return self._look(lambda f: as_text(f[in_file(path)].attrs[name]))

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
    def times(self) -> np.ndarray:
        """Time of each frame (f)."""
        return self["VTKHDF/Steps/Values"][:self.n_frames]

    @property
    def frame_steps(self) -> np.ndarray:
        """Number of the step that each frame is the end of (f); 0 for the start."""
        return np.searchsorted(np.append(0.0, self.history.time), self.times)

    @property
    def clock(self) -> np.ndarray:
        """Time that has passed at the end of each step (s), as that of motion: static stages take none of it where others are dynamic.
        `history.time` counts the sizes of all steps, so that each frame has a time of its own."""
        if "stages" not in self or len(self.history.time) == 0:
            return self.history.time
        dynamic = (self["stages/kind"] == "dynamic")[self.history.stage - 1]
        return np.cumsum(dynamic * np.diff(self.history.time, prepend=0.0)) if dynamic.any() else self.history.time

    @property
    def frame_stages(self) -> np.ndarray:
        """Number of the stage that each frame is of (f), from 1: that of the step that it is the end of, and the first at the start."""
        of_step = self.history.stage if "stage" in self.history else np.ones(len(self.history.time), int)
        return np.append(1, of_step)[self.frame_steps]

    @property
    def stage_names(self) -> list[str]:
        """What the stages are called; none of a run without."""
        return list(self["stages/name"]) if "stages" in self else []

    def counted_from(self, frame: int = -1) -> int:
        """The frame that displacements of a frame count from: the start, or the last one before a stage that has reset them."""
        stages = self.frame_stages
        for stage in range(stages[self._frame(frame)], 1, -1):
            given = [line.split("  (")[0] for line in self[f"stages/settings_{stage}"]]
            if "stage.reset = displacements" in given or "stage.reset = both" in given:
                return int(np.searchsorted(stages, stage)) - 1
        return 0

    def is_static(self, frame: int = -1) -> bool:
        """Whether the stage that a frame is of, or the whole run, is static: no time passes in it."""
        if "stages" in self:
            return self["stages/kind"][self.frame_stages[self._frame(frame)] - 1] == "static"
        return "unbalanced" in self.history

    @property
    def n_blocks(self) -> int:
        return self["bodies/area"].shape[1]

    @property
    def block(self) -> np.ndarray:
        """Number of the block of each element (e) at the end, from 1. A block of DDA is one element."""
        return self["VTKHDF/CellData/block"]

    @property
    def material(self) -> np.ndarray:
        """Number of the material of each element (e), from 1."""
        return self["VTKHDF/CellData/material"]

    def _frame(self, frame):
        """Its number from 0."""
        if not -self.n_frames <= frame < self.n_frames:
            raise IndexError(f"{self.path}: expected a frame from 0 to {self.n_frames - 1}, found {frame}")
        return frame % self.n_frames

    def _rows_of(self, name, frame, of):
        """The rows of a frame of a dataset below VTKHDF that has all frames one after the other: those `of` its points, or its cells.
        Others are not read."""
        frame = self._frame(frame)
        return self._look(lambda f: f[f"VTKHDF/{name}"][self._layouts.rows(of, frame)])

    def _of_vertices(self, name, frame):
        """A field of the vertices in a frame (v, 2). Vertices that cracks have made later have what the elements that they are of had."""
        values, layout = self._rows_of(name, frame, "points")[:, :2], self._layouts.of_frame[self._frame(frame)]
        if layout == self._layouts.count - 1:
            return values
        return self._cuts(layout).field(values)

    def _cuts(self, layout):
        """What cracks have made of the elements of a layout since then."""
        if layout not in self._read_cuts:
            self._read_cuts[layout] = Cuts(self, layout)
        return self._read_cuts[layout]

    def vertices(self, frame: int = -1) -> np.ndarray:
        """Places of all vertices in a frame (v, 2)."""
        return self._of_vertices("Points", frame)

    def displacement(self, frame: int = -1) -> np.ndarray:
        """Of all vertices (v, 2) since the start, or since a stage has reset it: `counted_from`."""
        return self._of_vertices("PointData/displacement", frame)

    def velocity(self, frame: int = -1) -> np.ndarray:
        """Of all vertices (v, 2)."""
        return self._of_vertices("PointData/velocity", frame)

    def stress(self, frame: int = -1) -> np.ndarray:
        """Cauchy stress of all elements (e, 3): xx, yy, xy, tension positive. That of blocks is bodies.stress."""
        stress = np.stack([self._rows_of(f"CellData/stress_{c}", frame, "cells") for c in ("xx", "yy", "xy")], axis=1)
        return stress[self._layouts.elements_of(self, self._frame(frame))]

    def joints(self, frame: int = -1) -> np.ndarray:
        """Joint material of the edge from each vertex of the polygons to the next, polygon after polygon; 0: a line of the mesh; -1: of a
        crack that has not grown so far in this frame."""
        layout = self._layouts.of_frame[self._frame(frame)]
        return self["elements/joint"] if layout == self._layouts.count - 1 else self._cuts(layout).joint

    def corners(self) -> list[np.ndarray]:
        """For each element the vertices that its polygon runs through, counter-clockwise, as rows of `vertices`."""
        return np.split(self["VTKHDF/Connectivity"], self["VTKHDF/Offsets"][1:-1])

    def polygons(self, frame: int = -1) -> list[np.ndarray]:
        """The polygon of each element in a frame, an array (n, 2) each."""
        vertices = self.vertices(frame)
        return [vertices[corners] for corners in self.corners()]

    def present(self, frame: int = -1) -> np.ndarray:
        """Whether each element is there (e), or a stage has removed its block."""
        if "present" not in self.bodies:
            return np.ones(self.n_elements, bool)
        return self.bodies.present[self._frame(frame)][self.blocks(frame) - 1] > 0

    def blocks(self, frame: int = -1) -> np.ndarray:
        """Number of the block that each element is of in a frame (e), from 1: that of a part which breaks off later is of its block."""
        layout = self._layouts.of_frame[self._frame(frame)]
        own = self._look(lambda f: f["VTKHDF/CellData/block"][self._layouts.cells_of_layout(layout)])
        return own[self._layouts.elements_of(self, self._frame(frame))]

    def contacts_of(self, frame: int = -1) -> Contacts | None:
        """The closed contacts of a frame; None where the scene has no contact."""
        if "contacts" not in self:
            return None
        frame, count = self._frame(frame), self["contacts/count"]
        return Contacts(self["contacts"], slice(count[:frame].sum(), count[:frame + 1].sum()))

    # By the names of a model, and by places

    def joint(self, name: str, frame: int = -1) -> Joint:
        """A joint, joint set or joint material by name: slip and opening of its parts, forces. Needs matplotlib."""
        from .model.views import joint_of
        return joint_of(self, name, frame)

    def bolt(self, name: str, frame: int = -1) -> Bolts:
        """The bolts of a name: force, elongation, state, ends. Needs matplotlib."""
        from .model.views import bolts_of
        return bolts_of(self, name, frame)

    def support(self, name: str, frame: int = -1) -> Support:
        """A support by name, or fixed points: its reaction at the end of a static run. Needs matplotlib."""
        from .model.reactions import support_of
        return support_of(self, name, frame)

    def reactions(self, name: str) -> np.ndarray:
        """The reaction of a support by name in each frame (f, 2); NaN at the start and where a stage is in motion. With `output.every=1` each
        step has a frame. Needs matplotlib."""
        known = [frame > 0 and self.is_static(frame) for frame in range(self.n_frames)]
        return np.array([self.support(name, frame).reaction if there else (np.nan, np.nan) for frame, there in enumerate(known)])

    def closure(self, p: Sequence[float] | str, q: Sequence[float] | str) -> np.ndarray:
        """How much nearer two points of the rock are to each other in each frame than at the start (f): places at the start, or names of
        measured points. Needs matplotlib."""
        from .model.views import closure_of
        return closure_of(self, p, q)

    def line(self, p: Sequence[float] | str, q: Sequence[float] | str, frame: int = -1, count: int = 50) -> Line:
        """Stress at so many places of a line through the rock. Needs matplotlib."""
        from .model.views import line_of
        return line_of(self, p, q, frame, count)

    # For pandas, shapely and notebooks

    def table_of_steps(self) -> pandas.DataFrame:
        """A row for each step, by the time of its end, as a table of pandas: its energies, its size and the like."""
        return tables.table_of_steps(self)

    def table_of_blocks(self, frame: int = -1) -> pandas.DataFrame:
        """A row for each block in a frame, by its number from 1, as a table of pandas: area, centroid, stress and the like."""
        return tables.table_of_blocks(self, frame)

    def table_of_contacts(self, frame: int = -1) -> pandas.DataFrame:
        """A row for each closed contact of a frame, as a table of pandas."""
        return tables.table_of_contacts(self, frame)

    def shapes(self, frame: int = -1) -> list[Polygon]:
        """The polygon of each element in a frame, with holes where it has some, for shapely."""
        return tables.shapes(self, frame)

    def _repr_png_(self) -> bytes | None:
        """A picture of the last frame; None without matplotlib."""
        try:
            from .drawing import FIELDS, Frames, draw_conditions, draw_frames, draw_joints, plt
        except ImportError:
            return None
        figure = draw_frames([Frames(self.path, self.path.stem)], ["last"], FIELDS[0], [draw_joints, draw_conditions])
        picture = io.BytesIO()
        figure.savefig(picture, format="png", dpi=80, bbox_inches="tight")
        plt.close(figure)
        return picture.getvalue()

    def _repr_html_(self) -> str:
        """What a notebook shows: what the file holds, and the picture."""
        rows = {"file": self.path, "status": self.scene.status, "blocks": self.n_blocks, "elements": self.n_elements,
                "frames": f"{self.n_frames}, to t = {self.times[-1]:.6g}", "steps": len(self.history.time)}
        picture = self._repr_png_()
        image = f'<img src="data:image/png;base64,{base64.b64encode(picture).decode()}"/>' if picture else ""
        return ("<table>" + "".join(f"<tr><th>{name}</th><td>{html.escape(str(value))}</td></tr>" for name, value in rows.items())
                + f"</table>{image}")

    # Points, costs

    def given_points(self, kind: str) -> np.ndarray:
        """Places (n, 2) at the start of the points of a kind: fixed, load or measured."""
        if "points" not in self:
            return np.empty((0, 2))
        return self["points/place"][self["points/kind"] == GIVEN_AS[kind]]

    def seconds(self, phase: str, of: str = "wall") -> float:
        """What a phase took (doc/results.md), or all that make up the steps (`steps`), of the `wall` or of the `processor`; 0 where
        there was none."""
        phases = STEPS if phase == "steps" else (phase,)
        return float(self[f"cost/{of}_seconds"][np.isin(self["cost/phase"], phases)].sum())


def in_file(path):
    """Where the file has it: `history.cracks` is the table of tips, by steps."""
    path = path.strip("/")
    return path.replace(OF_TIPS, "tips", 1) if f"{path}/".startswith(f"{OF_TIPS}/") else path


def as_text(value):
    """Texts as str, without the blanks at their ends; numbers as they are."""
    if isinstance(value, bytes):
        return value.decode().rstrip()
    if isinstance(value, np.ndarray) and value.dtype.kind in "SO":
        return np.array([as_text(text) for text in value.ravel()]).reshape(value.shape)
    return value
