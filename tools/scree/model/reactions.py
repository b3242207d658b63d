"""Reactions of supports, which results do not hold: what balances all other forces on the blocks that a support holds."""
from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from ..errors import ResultsError
from ..polygons import SLOPE, on_lines
from ..results import Results
from .views import ALIKE, distance_to, element_at, model_of, size_of, tolerance_of
from .words import HOLDS, POINT_HOLDS

BALANCED = 1e-3  # of the forces on a block: what reactions may leave of them
WAYS_OF_POINTS = {"both": [0, 1], "x": [0], "y": [1]}  # axes that points are held along
ONE_WAY = 1e-9  # of the largest displacement of a table: what is across one direction
GAUSS = ((1 - 3 ** -0.5) / 2, (1 + 3 ** -0.5) / 2)  # shares of a line whose two halves integrate cubics


@dataclasses.dataclass
class Support:
    """A support, or fixed points, in a frame: `reaction` is the force (x, y) on the rock."""

    reaction: np.ndarray


def support_of(results: Results, name: str, frame: int = -1) -> Support:
    """A support by name, of a static run of blocks. ResultsError where its reaction does not follow from what results hold.

    The reactions on a block are what its stress, in the six displacements of a block of DDA (Shi 1988), lacks of its weight and of the
    forces of contacts, bolts and loads. Where supports share a corner, each bears a part of what is there.
    """
    model, frame = model_of(results).until(results.frame_stages[results._frame(frame)] - 1), results._frame(frame)
    held = held_points(results, model)
    names = dict.fromkeys(own for points in held.values() for own, *_ in points)
    if name not in names:
        raise ResultsError(f"support(name=): expected one of {', '.join(filter(None, names)) or 'none, as there are none'}, found '{name}'")
    if results.n_elements > results.n_blocks or not results.is_static(frame) or frame == 0:
        raise ResultsError("support: expected the end of a static run of DDA blocks, of which alone reactions are known")
    total, polygons = np.zeros(2), results.polygons(frame)
    forces = [*forces_of_bolts(results, frame, polygons), *forces_on_edges(results, model, polygons), *forces_at_points(results, model, polygons)]
    for block, points in held.items():
        if not any(own == name for own, *_ in points) or not results.present(frame)[block - 1]:
            continue
        lacking, scale = lacking_forces(results, model, block, frame, forces)
        centre = results.bodies.centroid[frame][block - 1]
        columns = np.array([modes_at(polygons[block - 1][corner] if corner is not None else place, centre).T @ way
                            for _, way, corner, place in points]).T
        found, *_ = np.linalg.lstsq(columns, lacking, rcond=None)
        if np.abs(columns @ found - lacking)[:2].max() > BALANCED * (scale + np.abs(found).sum()):
            raise ResultsError(f"support: expected block {block} in equilibrium, found forces out of balance")
        total += sum((force * way for force, (own, way, *_) in zip(found, points) if own == name), np.zeros(2))
    return Support(total)


def modes_at(place, centre):
    """Displacements at a place by the six freedoms of a block (2, 6): two shifts, turn, strains xx, yy, xy."""
    x, y = place - centre
    return np.array([[1, 0, -y, x, 0, y / 2], [0, 1, x, 0, y, x / 2]])


def held_points(results, model):
    """For each block with held points: the name of what holds, the direction held, its corner (None for a fixed point), its place."""
    held, polygons, near = {}, results.polygons(0), tolerance_of(results)
    for hold in (*HOLDS, "moved"):
        for row in model._rows(f"support.{hold}"):
            line, own = row["line"], row["name"]
            side = np.array(line[2:]) - line[:2]
            ways = ways_of_motion(model, row) if hold == "moved" else {
                "both": np.eye(2), "x": [np.array([1.0, 0])], "y": [np.array([0, 1.0])],
                "normal": [np.array([-side[1], side[0]]) / np.linalg.norm(side)]}[hold]
            for block, corners in zip(results.block, polygons):
                after = np.roll(corners, -1, axis=0)
                edges = np.flatnonzero(on_lines((corners + after) / 2, after - corners, [line], near))
                for corner in np.unique(np.concatenate([edges, (edges + 1) % len(corners)])):
                    held.setdefault(int(block), []).extend((own, way, int(corner), None) for way in ways)
    for hold, points in POINT_HOLDS.items():
        for row in model._rows(f"support.{points}"):
            block = int(results.block[element_at(results, polygons, np.array(row["line"]), np.ones(len(polygons), bool))])
            held.setdefault(block, []).extend((row["name"], way, None, np.array(row["line"])) for way in np.eye(2)[WAYS_OF_POINTS[hold]])
    if "points" in results:
        rows = np.flatnonzero(results.points.kind == 1)
        known = [row.name for row in model.geometry.fixed]
        for i, k in enumerate(rows):
            own = known[i] if len(known) == len(rows) else ""
            block = int(results.block[results.points.element[k] - 1])
            held.setdefault(block, []).extend((own, way, None, results.points.place[k]) for way in np.eye(2))
    return held


def ways_of_motion(model, row):
    """The directions in which a moved line holds: that of its velocity, or of all displacements of its table."""
    table = model.in_force("support.table")
    shifts = np.array([row["velocity"]]) if table is None else np.diff(np.reshape(table.value, (-1, 3))[:, 1:], axis=0)
    _, sizes, ways = np.linalg.svd(shifts, full_matrices=False)
    return ways[sizes > ONE_WAY * sizes[0]]


def forces_on_edges(results, model, polygons):
    """The block, the place and the force at two points of each piece of an edge that pressure, traction or water acts on, for Gauss."""
    near = tolerance_of(results)
    for setting in ("boundary.ramp", "acceleration.table", "acceleration.file"):
        if model.in_force(setting):
            raise ResultsError(f"support: expected a run without {setting}, with which reactions are not known")
    water = model.in_force("water.table")
    table = np.array(water.value, float).reshape(-1, 2) if water and water.value != "none" else None
    weight = model["water.unit_weight"] if table is not None else 0.0
    lines = model._rows("boundary.lines")
    for block, before, now in zip(results.block, results.polygons(0), polygons):
        for i in range(len(before)):
            k = (i + 1) % len(before)
            p, side, own, own_side = before[i], before[k] - before[i], now[i], now[k] - now[i]
            across = np.array([-own_side[1], own_side[0]])  # into the block, as long as the edge
            pieces = [piece for row in lines for piece in loaded_part(p, side, row, near)]
            if table is not None:
                pieces += [(a, b, lambda place: (weight * depth(table, place), np.zeros(2))) for a, b in itertools.pairwise(breaks(table, p, side))]
            for (a, b, load), share in itertools.product(pieces, GAUSS):
                at = a + share * (b - a)
                pressure, traction = load(p + at * side)
                force = (b - a) / 2 * (pressure * across + traction * np.linalg.norm(side))
                if force.any():
                    yield int(block), own + at * own_side, force


def loaded_part(p, side, row, near):
    """The part of an edge that lies on a line with a load, in shares from 0 to 1, and the pressure and the traction at a place; none where
    it does not lie on it."""
    begin, way = np.array(row["line"][:2]), np.array(row["line"][2:]) - row["line"][:2]
    length, of_line = np.linalg.norm(side), np.linalg.norm(way)
    normal = np.array([-way[1], way[0]]) / of_line
    first, last = np.sort(np.clip([(begin - p) @ side / length ** 2, (begin + way - p) @ side / length ** 2], 0, 1))
    middle = p + (first + last) / 2 * side
    if abs(side @ normal) > SLOPE * length or abs((middle - begin) @ normal) > near or (last - first) * length <= near:
        return

    def load(place):
        share = (place - begin) @ way / of_line ** 2
        start, end = np.reshape(row["traction"], (2, 2))
        return row["pressure"][0] + share * (row["pressure"][1] - row["pressure"][0]), start + share * (end - start)

    yield first, last, load


def depth(table, place):
    """How deep a place lies below a water table; 0 above it."""
    return max(np.interp(place[0], *table.T) - place[1], 0.0)


def breaks(table, p, side):
    """Shares of an edge, from 0 to 1, between which the depth below a water table is linear."""
    found = {0.0, 1.0}
    if side[0] != 0:
        found |= {share for share in (table[:, 0] - p[0]) / side[0] if 0 < share < 1}
    ends = sorted(found)
    above = [np.interp(p[0] + share * side[0], *table.T) - p[1] - share * side[1] for share in ends]
    crossings = {a + (b - a) * low / (low - high) for a, b, low, high in zip(ends, ends[1:], above, above[1:]) if low * high < 0}
    return sorted(found | crossings)


def forces_at_points(results, model, polygons):
    """The block, the place and the force of each load point."""
    if not model.geometry.loads:
        return
    if model.tables is not None and any(model.tables[len(model.tables) - len(model.geometry.loads):]):
        raise ResultsError("support: expected constant forces, found tables, with which reactions are not known")
    given, start = model.in_force("loads.force"), results.polygons(0)
    rows = np.flatnonzero(results.points.kind == 2)  # noqa: PLR2004  load points
    for k, force in zip(rows, np.reshape(given.value if given else [], (-1, 2))):
        element = results.points.element[k] - 1
        off = np.vstack([(start[element] - results.points.place[k]).T, np.ones(len(start[element]))])
        yield int(results.block[element]), np.linalg.lstsq(off, [0, 0, 1], rcond=None)[0] @ polygons[element], np.asarray(force, float)


def lacking_forces(results, model, block, frame, forces):
    """What the stress of a block needs beyond its weight, contacts, loads and bolts (6), and the size of these forces."""
    centre, area = results.bodies.centroid[frame][block - 1], results.bodies.area[frame][block - 1]
    material = int(results.material[block - 1])
    weights = model.in_force("materials.unit_weight")
    weight = weights.value[material - 1] if weights else list(model.materials.values())[material - 1].unit_weight
    weight *= results.bodies.area[0][block - 1] * share_of_weight(results, model, frame)
    lacking = np.concatenate([[0, weight, 0], area * results.bodies.stress[frame][block - 1]])
    scale = abs(weight)
    contacts = results.contacts_of(frame)
    for i in np.flatnonzero((contacts.blocks == block).any(axis=1)) if contacts is not None else ():
        nx, ny = contacts.normal[i]
        force = contacts.force[i, 0] * np.array([nx, ny]) + contacts.force[i, 1] * np.array([-ny, nx])
        sign = {int(contacts.blocks[i, 0]): 1, int(contacts.blocks[i, 1]): -1}.get(block, 0)
        lacking -= sign * modes_at(contacts.place[i], centre).T @ force
        scale += abs(sign) * np.linalg.norm(force)
    for own, place, force in forces:
        if own == block:
            lacking -= modes_at(place, centre).T @ force
            scale += np.linalg.norm(force)
    return lacking, scale


def share_of_weight(results, model, frame):
    """The part of the weight that acts in a frame while it grows (`gravity.ramp`)."""
    ramp = model["gravity.ramp"] if model.in_force("gravity.ramp") else 0
    if not ramp:
        return 1.0
    stages = results.frame_stages
    begins = results.times[np.flatnonzero(stages < stages[frame])].max(initial=0.0)
    return min(1.0, (results.times[frame] - begins) / ramp)


def forces_of_bolts(results, frame, polygons):
    """The block, the place and the force of each end of each bolt; ends that the ground holds have none."""
    if "bolts" not in results:
        return []
    if "shear" in results.bolts:
        raise ResultsError("support: expected a run without grouted bolts, whose reactions are not known")
    found = []
    for ends, tension in zip(results.bolts.ends[frame].reshape(-1, 2, 2), results.bolts.force[frame]):
        way = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        for place, force in ((ends[0], tension * way), (ends[1], -tension * way)):
            away = [distance_to(polygon, place) for polygon in polygons]
            k = int(np.argmin(away))
            if away[k] <= ALIKE * size_of(results):
                found.append((int(results.block[k]), place, force))
    return found
