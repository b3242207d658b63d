"""What the player of a page draws: shapes, motion, stress, velocity and contacts of all frames as arrays of whole numbers."""
import numpy as np

from ..histories import axis_of, is_static
from ..overlays import all_corners, means, parts_against_others, vertices_of_contacts
from ..results import LATER
from ..tips import tips_of, weights_of
from .packing import PLACES, POSITIONS, ROOTS, SHADES, quantised


def pack_frames(file, pack, units):
    """Adds what the frames of a results file have to a pack; returns what the player needs besides, also where frames are along the
    axis of charts.

    Places are those at the start, moved by the displacement of each frame. That is kept to 1/16382 of the largest of its block,
    stress and velocity to 1/4094 of the largest of their element, forces of contacts by their roots.
    """
    results, corners = file.file, file.corners
    n_frames = len(file.times)
    start = results.vertices(0)
    low, size = start.min(0), max(np.ptp(start, axis=0).max(), 1e-300)
    pack.add("start", np.rint((start - low) / size * PLACES).T)
    every, of_element = all_corners(file)[1], np.repeat(np.arange(len(corners)), list(map(len, corners)))
    pack.add("corners", every)
    pack.add("count", list(map(len, corners)))
    blocks, block = np.unique(results.block, return_inverse=True)
    pack.add("block", block)
    pack.add("material", results.material)
    pack.add("gone", frames_until_gone(file, block))
    first = np.unique(block, return_index=True)[1]
    pack.add("was", np.searchsorted(blocks, [results.blocks(k)[first] for k in range(n_frames)]))
    ends, _, element = file.edge_list()
    pack.add("edges", every[ends].T)
    pack.add("edge_block", block[element])
    of_frames = [file.edge_list(k)[1] for k in np.unique(results._layouts.of_frame, return_index=True)[1]]
    for name, is_there in (("edge_drawn", lambda of_edge: of_edge != LATER), ("edge_face", lambda of_edge: of_edge > 0)):
        pack.add(name, first_frames(results, [is_there(of_edge) for of_edge in of_frames]))
    edge, shares = parts_against_others(file)
    pack.add("against_edge", edge)
    pack.add("against_shares", np.rint(shares * PLACES).T)

    of_vertex = np.zeros(len(start), int)
    of_vertex[every] = block[of_element]
    motion = np.stack([results.vertices(k) - start for k in range(n_frames)], axis=2)  # (v, 2, f)
    largest = np.zeros(len(blocks))
    np.maximum.at(largest, of_vertex, np.abs(motion).max(axis=(1, 2)))
    factor = np.where(largest > 0, largest, 1.0) / POSITIONS
    pack.add("motion", np.rint(motion / factor[of_vertex, None, None]))
    stress, stress_factor = quantised(np.stack([results.stress(k) for k in range(n_frames)], axis=2), SHADES, (1, 2))
    pack.add("stress", stress)
    speed = np.stack([means(file, k, results.velocity(k)) for k in range(n_frames)], axis=2)
    velocity, velocity_factor = quantised(speed, SHADES, (1, 2))
    pack.add("velocity", velocity)
    _, steps = axis_of(results, units, is_static(results))
    return {"origin": low.tolist(), "size": size, "steps": digits(np.append(0, steps)[results.frame_steps]),
            "moments": [file.moment(k, units) for k in range(n_frames)], "since": [file.since(k) for k in range(n_frames)], "blocks": blocks.tolist(),
            "motion_factor": digits(factor), "stress_factor": digits(stress_factor), "velocity_factor": digits(velocity_factor),
            "points": points_of(file), "bolts": bolts_of(file), "tips": all_tips(file), "force_factor": pack_contacts(file, pack)}


def frames_until_gone(file, block):
    """Of each block in how many frames it is there, before a stage removes it for ever."""
    first = np.unique(block, return_index=True)[1]
    return np.sum([file.present(frame)[first] for frame in range(len(file.times))], axis=0)


def first_frames(results, layouts):
    """Of each edge the first frame in which it is what `layouts` say of it, for each layout whether it is (layouts, n); n_frames where it never is."""
    frame = np.append(np.unique(results._layouts.of_frame, return_index=True)[1], results.n_frames)
    return frame[np.where(np.any(layouts, axis=0), np.argmax(layouts, axis=0), len(layouts))]


def all_tips(file):
    """The tips of cracks in each frame: vertices of an element with weights, and stress intensity factors."""
    return [[{"vertices": file.corners[tip.element].tolist(), "weights": digits(tip.weights), "intensity": digits(tip.intensity)}
             for tip in tips_of(file, frame)] for frame in range(len(file.times))]


def digits(values):
    """Numbers with as many digits as they need here."""
    return [float(f"{value:.7g}") for value in np.ravel(values)]


def points_of(file):
    """Kind of each point, and its place as a mean of vertices of its element with weights, which is so as this is deformed."""
    kinds, places = file.points(0)
    elements = file.file["points/element"] - 1 if len(kinds) else []
    found = []
    for kind, place, e in zip(kinds, places, elements):
        found.append({"kind": int(kind), "vertices": file.corners[e].tolist(), "weights": digits(weights_of(file.start[e], place))})
    return found


def bolts_of(file):
    """Ends and states of the bolts in each frame."""
    found = [file.bolts(frame) for frame in range(len(file.times))]
    return [{"ends": digits(ends), "state": states.tolist()} for ends, states in found] if len(found[0][1]) else []


def pack_contacts(file, pack):
    """Adds the closed contacts, those of a vertex and the block of an edge one after the other in time, pairs of blocks together.
    Returns the factor of their forces, whose roots are kept; None where there are none."""
    results = file.file
    if results.contacts_of(0) is None or not results["contacts/count"][:results.n_frames].sum():
        return None
    rows, present = [], np.unique(results.block)
    for frame in range(results.n_frames):
        contacts = results.contacts_of(frame)
        blocks = np.searchsorted(present, contacts.blocks)
        vertex = vertices_of_contacts(file, frame)
        angle = np.rint(np.arctan2(contacts.normal[:, 1], contacts.normal[:, 0]) * 128 / np.pi)
        rows.append(np.column_stack([blocks.min(1), blocks.max(1), vertex, blocks[:, 1], np.full(len(vertex), frame), contacts.state,
                                     angle, contacts.force]))
    rows = np.vstack(rows)
    rows = rows[np.lexsort(rows[:, 4::-1].T)]
    root = np.sqrt(np.abs(rows[:, 7:]))
    largest = root.max(initial=0.0) or 1.0
    for name, column in (("contact_vertex", 2), ("contact_block", 3), ("contact_frame", 4), ("contact_state", 5),
                         ("contact_angle", 6)):
        pack.add(name, rows[:, column])
    pack.add("contact_force", (np.sign(rows[:, 7:]) * np.rint(root / largest * ROOTS)).T)
    return float(largest / ROOTS) ** 2
