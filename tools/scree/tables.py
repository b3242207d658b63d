"""Results as tables of pandas and shapes of shapely, for who goes on with them there.

Needs Debian's python3-pandas and python3-shapely, which the rest of the package does not.
"""
from __future__ import annotations

import typing

import numpy as np

from .polygons import loops_of

if typing.TYPE_CHECKING:
    import pandas
    from shapely.geometry import Polygon

    from .results import Results

PARTS = {2: ("_x", "_y"), 3: ("_xx", "_yy", "_xy")}  # of vectors and stresses


def table_of_steps(results: Results) -> pandas.DataFrame:
    """A row for each step, by the time of its end; a column for each series that has one number a step, such as energy/kinetic."""
    import pandas
    history = results.history
    series = {name: history[name] for name in history.series()}
    time = series.pop("time")
    columns = {name: values for name, values in series.items() if values.ndim == 1}
    return pandas.DataFrame(columns, index=pandas.Index(time, name="time"))


def table_of_blocks(results: Results, frame: int = -1) -> pandas.DataFrame:
    """A row for each block in a frame, by its number from 1; area, centroid_x and _y, rotation, stress_xx, _yy and _xy ..."""
    import pandas
    frame, columns = results._frame(frame), {}
    for name in results.bodies:
        values = results.bodies[name][frame]
        if values.ndim == 1:
            columns[name] = values
        else:
            columns |= {name + part: column for part, column in zip(PARTS[values.shape[1]], values.T)}
    return pandas.DataFrame(columns, index=pandas.RangeIndex(1, results.n_blocks + 1, name="block"))


def table_of_contacts(results: Results, frame: int = -1) -> pandas.DataFrame:
    """A row for each closed contact of a frame: blocks of vertex and edge, state (sliding or locked), place, normal, forces."""
    import pandas
    contacts = results.contacts_of(frame)
    columns: dict[str, typing.Any] = {"vertex_block": [], "edge_block": [], "state": [], "x": [], "y": [], "normal_x": [], "normal_y": [],
               "normal_force": [], "shear_force": []}
    if contacts is not None and len(contacts):
        columns = dict(zip(columns, (*contacts.blocks.T, np.array(["", "sliding", "locked"])[contacts.state], *contacts.place.T,
                                     *contacts.normal.T, *contacts.force.T)))
    return pandas.DataFrame(columns)


def shapes(results: Results, frame: int = -1) -> list[Polygon]:
    """The polygon of each element in a frame, with holes where it has some, for shapely."""
    return [shape_of(polygon) for polygon in results.polygons(frame)]


def shape_of(polygon: np.ndarray) -> Polygon:
    """A polygon (n, 2) as a shape, its seams taken apart into outline and holes."""
    from shapely.geometry import Polygon
    outer, *holes = (polygon[loop] for loop in loops_of(polygon))
    return Polygon(outer, holes)
