"""Writes the contacts of a run for ParaView and VTK (9.3 or newer), as a file beside the results, which show the blocks.

    tools/contacts RESULTS.h5 [-o CONTACTS.vtkhdf]

Each frame has a point for each closed contact, at its vertex, with `state` (1 sliding, 2 locked), `force` on the block of the vertex,
its parts `across` and `along` the edge, the outer `normal` of the edge, and `block` and `against`, the blocks of the vertex and of the
edge. Arrows of `force` are glyphs in ParaView.
"""
import pathlib

import h5py
import numpy as np

from .arguments import beside, check_ending, ends_in_a_line, parser_for
from .errors import PlotError, reason_of
from .results import read

VTK_VERTEX = 1  # a cell of one point


def as_vectors(pairs):
    """Pairs of x and y as vectors in space."""
    return np.column_stack([pairs, np.zeros(len(pairs))])


def point_data(contacts):
    """What the contacts of a frame have, by name."""
    left = np.stack([-contacts.normal[:, 1], contacts.normal[:, 0]], axis=1)
    across, along = contacts.force.T
    return {"state": contacts.state, "force": as_vectors(across[:, None] * contacts.normal + along[:, None] * left), "across": across,
            "along": along, "normal": as_vectors(contacts.normal), "block": contacts.blocks[:, 0], "against": contacts.blocks[:, 1]}


def write_contacts(results, path):
    """Writes the contacts of all frames as an UnstructuredGrid of VTKHDF in time, a vertex each. ScreeError: the run has no contacts,
    or no file can be written by that name."""
    if path.exists() and path.samefile(results.path):
        raise PlotError(f"{path}: expected another name for the contacts, found that of the results")
    check_ending(path, "contacts", (".vtkhdf", ".hdf"))
    if "contacts" not in results:
        raise PlotError(f"{results.path}: expected a run with contacts, found one without")
    if results.n_frames == 0:
        raise PlotError(f"{results.path}: expected a frame, found none")
    frames = [results.contacts_of(frame) for frame in range(results.n_frames)]
    count = np.array([len(contacts) for contacts in frames])
    before = np.cumsum([0, *count[:-1]])
    data = [point_data(contacts) for contacts in frames]
    try:
        with h5py.File(path, "w") as f:
            top = f.create_group("VTKHDF")
            top.attrs["Version"] = (2, 0)
            top.attrs.create("Type", b"UnstructuredGrid", dtype=h5py.string_dtype("ascii", len("UnstructuredGrid")))
            for name in ("NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"):
                top[name] = count
            top["Points"] = as_vectors(np.concatenate([contacts.place for contacts in frames]))
            top["Connectivity"] = np.concatenate([np.arange(n) for n in count])
            top["Offsets"] = np.concatenate([np.arange(n + 1) for n in count])
            top["Types"] = np.full(count.sum(), VTK_VERTEX, np.uint8)
            for name in data[0]:
                top[f"PointData/{name}"] = np.concatenate([values[name] for values in data])
            steps = top.create_group("Steps")
            steps.attrs["NSteps"] = results.n_frames
            steps["Values"] = results.times
            steps["PartOffsets"] = np.arange(results.n_frames)
            steps["NumberOfParts"] = np.ones(results.n_frames, int)
            steps["PointOffsets"] = before
            for name in ("CellOffsets", "ConnectivityIdOffsets"):
                steps[name] = before[:, None]
            for name in data[0]:
                steps[f"PointDataOffsets/{name}"] = before
    except OSError as problem:
        raise PlotError(f"{path}: cannot write the contacts: {reason_of(problem)}") from None


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("file", type=pathlib.Path, metavar="RESULTS")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="CONTACTS", help="default: RESULTS-contacts.vtkhdf")
    given = parser.parse_args()
    output = given.output or beside(given.file, "-contacts.vtkhdf")
    write_contacts(read(given.file), output)
    print(output)
    return 0
