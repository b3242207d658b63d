"""Results by the names of a model: joints and bolts; and by places: closures and lines.

The names are those in the comments of the decks, which results hold. What has no name is found by its number from 1, as a text.
"""
from __future__ import annotations

import dataclasses
import functools
import typing

import numpy as np

from ..errors import ResultsError
from ..overlays import edges_of_contact, parts_against_others
from ..polygons import on_lines
from ..results import Results
from .geometry import read_geometry
from .model import Model
from .text import Numbers
from .words import vector, whole

if typing.TYPE_CHECKING:
    from ..drawing import Frames

ON_LINE = 1e-4   # of the size of the model: how far an edge on a line may lie from it (doc/decks.md)
ALIKE = 1e-6     # of the size of the model: places that are one
SAME = 1e-3      # of a part of a joint: how far the middles of its two sides may be apart at the start


@dataclasses.dataclass
class Joint:
    """A joint or a joint material in a frame. Rows are the parts where two blocks lay against each other at the start: `place` of the middle
    then (n, 2), `length`, `slip` along the joint and `opening` across it since (n). `normal_force` (compression is positive) and
    `shear_force` are the sums over its closed contacts."""

    place: np.ndarray
    length: np.ndarray
    slip: np.ndarray
    opening: np.ndarray
    normal_force: float
    shear_force: float


@dataclasses.dataclass
class Bolts:
    """The bolts of a name in a frame: `force` (tension is positive) and `elongation` (n), `state` (n; 0 elastic, 1 has yielded, 2 broken,
    3 not there), `ends` (n, 4)."""

    force: np.ndarray
    elongation: np.ndarray
    state: np.ndarray
    ends: np.ndarray


@dataclasses.dataclass
class Line:
    """Places on a line in rock (n, 2), their `distance` from its beginning (n), and the `stress` xx, yy, xy there (n, 3)."""

    place: np.ndarray
    distance: np.ndarray
    stress: np.ndarray


@functools.lru_cache(maxsize=8)
def model_of(results: Results) -> Model:
    """The model that results are of, by the decks that they hold."""
    scene = results.scene
    geometry, analysis = ("\n".join(map(str, scene[name])) for name in ("geometry_deck", "analysis_deck"))
    return Model.of_decks(results.path.stem, Numbers(analysis, str(scene.decks[-1])), *read_geometry(geometry, str(scene.decks[0])))


@functools.lru_cache(maxsize=8)
def frames_of(results: Results) -> Frames:
    """The frames of results, with the edges of their blocks."""
    from ..drawing import Frames  # here, as pictures draw conditions by names
    return Frames(results.path, results.path.stem)


def size_of(results: Results) -> float:
    """The larger one of the width and the height of the model."""
    return float(np.ptp(results.vertices(0), axis=0).max())


def tolerance_of(results: Results) -> float:
    """How far an edge may lie from a line that it is on."""
    e0 = getattr(model_of(results).geometry, "e0", 0.0)
    return max(1.25 * e0, ON_LINE) * size_of(results)


# Joints

def joint_of(results: Results, name: str, frame: int = -1) -> Joint:
    """A joint by the name of its lines, else by the name of its joint material; ResultsError where there is none."""
    file, frame = frames_of(results), results._frame(frame)
    _, material, element = file.edge_list(frame)
    start, now = (file.places(slice(None), k, magnified=False) for k in (0, frame))
    chosen = edges_of_name(results, str(name), start, material) & (material > 0)
    edge, shares = parts_against_others(file)
    edge, shares = edge[chosen[edge]], shares[chosen[edge]]
    first, second = pairs_of_sides(start, edge, shares, element, ALIKE * size_of(results))
    there = file.present(frame)
    kept = there[element[edge[first]]] & there[element[edge[second]]]
    first, second = first[kept], second[kept]
    middle = shares.mean(axis=1)[:, None]

    def places(edges, rows):
        return edges[edge[rows], 0] + middle[rows] * (edges[edge[rows], 1] - edges[edge[rows], 0])

    moved = (places(now, second) - places(now, first)) - (places(start, second) - places(start, first))
    along = now[edge[first], 1] - now[edge[first], 0]
    along /= np.linalg.norm(along, axis=1)[:, None]
    whole_length = np.linalg.norm(start[edge[first], 1] - start[edge[first], 0], axis=1)
    return Joint(places(start, first), whole_length * np.ptp(shares[first], axis=1), np.abs((moved * along).sum(1)),
                 moved[:, 0] * along[:, 1] - moved[:, 1] * along[:, 0], *forces_on(results, frame, now, chosen, element))


def edges_of_name(results, name, start, material):
    """Which edges (n) are of a joint, or of a joint material, by name."""
    model = model_of(results)
    rows = [row for row in getattr(model.geometry, "joints", []) if row.name]
    lines = [row.numbers for row in rows if row.name == name]
    if lines:
        return on_lines(start.mean(axis=1), start[:, 1] - start[:, 0], lines, tolerance_of(results))
    materials = list(model.joint_materials)
    if name in materials or name in map(str, range(1, len(materials) + 1)):
        return material == (materials.index(name) + 1 if name in materials else int(name))
    known = dict.fromkeys([row.name for row in rows] + materials)
    raise ResultsError(f"joint(name=): expected one of {', '.join(known)}, found '{name}'")


def pairs_of_sides(start, edge, shares, element, near):
    """Parts of joints in pairs, the two sides of each: rows of one side and of the other."""
    ends = start[edge][:, 0, None] + shares[..., None] * (start[edge][:, 1] - start[edge][:, 0])[:, None]
    middle, of = ends.mean(axis=1), element[edge]
    room = near + SAME * np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    order = np.argsort(middle[:, 0])
    low, high = (np.searchsorted(middle[order, 0], middle[:, 0] + sign * room) for sign in (-1, 1))
    first, second = [], []
    for i in range(len(edge)):
        others = order[low[i]:high[i]]
        others = others[(others > i) & (of[others] != of[i])]
        apart = np.linalg.norm(middle[others] - middle[i], axis=1)
        if len(others) and apart.min() <= room[i]:
            first.append(i)
            second.append(others[apart.argmin()])
    return np.array(first, int), np.array(second, int)


def forces_on(results, frame, edges, chosen, element):
    """Sums of the normal forces and of the shear forces of the closed contacts on chosen edges in a frame."""
    contacts = results.contacts_of(frame)
    block, normal, shear = results.block[element], 0.0, 0.0
    of_block = {number: np.flatnonzero(chosen & (block == number)) for number in np.unique(block)}
    for i in range(len(contacts) if contacts is not None else 0):
        own = of_block.get(contacts.blocks[i, 1], ())
        if len(own) and len(edges_of_contact(edges[own], contacts.place[i], contacts.normal[i])):
            normal, shear = normal + contacts.force[i, 0], shear + contacts.force[i, 1]
    return float(normal), abs(float(shear))


# Bolts

def bolts_of(results: Results, name: str, frame: int = -1) -> Bolts:
    """The bolts of a name in a frame; ResultsError where there are none."""
    model, frame = model_of(results), results._frame(frame)
    names = names_of_bolts(model)
    if name not in names and name not in map(str, range(1, len(names) + 1)):
        raise ResultsError(f"bolt(name=): expected one of {', '.join(dict.fromkeys(filter(None, names))) or 'none, as there are none'}, "
                           f"found '{name}'")
    chosen = [i for i, one in enumerate(names) if one == name] if name in names else [int(name) - 1]
    given = results.bolts
    rows = np.isin(given.number[frame] - 1, chosen) if "number" in given else np.array(chosen)
    return Bolts(given.force[frame][rows], given.elongation[frame][rows], given.state[frame][rows].astype(int), given.ends[frame][rows])


def names_of_bolts(model: Model) -> list[str]:
    """Names of the bolts of a run in their order: those of the geometry, then those of each stage that no stage before has."""
    known: list[tuple[tuple | None, str]] = [(None, row.name) for row in model.geometry.bolts]
    for stage in range(len(model.parts)):
        installed = set()
        for numbers, name in model.until(stage).bolts():
            k = next((k for k, (one, _) in enumerate(known) if one == numbers and k not in installed), None)
            if k is None:
                k = len(known)
                known.append((numbers, name))
            installed.add(k)
    return [name for _, name in known]


# Places

def distance_to(polygon: np.ndarray, place: np.ndarray) -> float:
    """The distance of a place from a polygon; 0 inside."""
    p, q = polygon, np.roll(polygon, -1, axis=0)
    side, off = q - p, place - p
    with np.errstate(divide="ignore", invalid="ignore"):
        right = p[:, 0] + off[:, 1] * side[:, 0] / side[:, 1]
    if (((p[:, 1] > place[1]) != (q[:, 1] > place[1])) & (place[0] < right)).sum() % 2:
        return 0.0
    share = np.clip((off * side).sum(1) / np.maximum((side ** 2).sum(1), 1e-300), 0, 1)
    return float(np.linalg.norm(off - share[:, None] * side, axis=1).min())


def element_at(results, polygons, place, there):
    """The element, from 0, that a place is in or, within the least distances of a model, beside; None where there is none."""
    near, best = tolerance_of(results), (np.inf, None)
    for e in np.flatnonzero(there):
        if (polygons[e].max(0) >= place - 2 * near).all() and (polygons[e].min(0) <= place + 2 * near).all():
            best = min(best, (distance_to(polygons[e], place), int(e)))
    return best[1] if best[0] <= near else None


def place_of(results, given, what):
    """A place, or that of a measured point by its name."""
    if isinstance(given, str):
        names = [row.name for row in model_of(results).geometry.measured]
        if given not in names:
            raise ResultsError(f"{what}: expected a place (x, y) or a measured point ({', '.join(filter(None, names)) or 'there are none'}), "
                               f"found '{given}'")
        return results.given_points("measured")[names.index(given)]
    return np.array(vector(given, what))


def closure_of(results: Results, p, q) -> np.ndarray:
    """How much nearer two points of the rock are to each other in each frame than at the start (f). The points are places at the start, or
    names of measured points. ResultsError where there is no rock at the end."""
    there, polygons, corners, ways = results.present(-1), results.polygons(0), results.corners(), []
    for given, what in ((p, "closure(p)"), (q, "closure(q)")):
        place = place_of(results, given, what)
        element = element_at(results, polygons, place, there)
        if element is None:
            raise ResultsError(f"{what}: expected a place in the rock that is there at the end, found {tuple(map(float, place))}")
        off = np.vstack([(polygons[element] - place).T, np.ones(len(corners[element]))])
        shares, *_ = np.linalg.lstsq(off, [0, 0, 1], rcond=None)  # of the corners: the field of an element is linear
        ways.append(np.array([shares @ results.vertices(k)[corners[element]] for k in range(results.n_frames)]))
    apart = np.linalg.norm(ways[1] - ways[0], axis=1)
    return apart[0] - apart


def line_of(results: Results, p, q, frame: int = -1, count: int = 50) -> Line:
    """Stress at so many places in equal distances from p to q, at the middles of as many parts, as far as there is rock in the frame."""
    p, q = place_of(results, p, "line(p)"), place_of(results, q, "line(q)")
    shares = (np.arange(whole(count, "line(count=)")) + 0.5) / count
    frame, there = results._frame(frame), results.present(frame)
    places = p + shares[:, None] * (q - p)
    polygons = results.polygons(frame)
    found = [element_at(results, polygons, place, there) for place in places]
    kept = np.array([element is not None for element in found])
    stress = results.stress(frame)
    return Line(places[kept], np.linalg.norm(places[kept] - p, axis=1),
                np.array([stress[element] for element in found if element is not None]).reshape(-1, 3))
