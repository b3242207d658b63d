"""What is drawn over the blocks of a picture: vectors, principal stresses, states of joints, forces of contacts.

Each `draw_...(axis, file, frame, common)` draws on a panel and returns the entries of the legend by what they say. Colours
are those of Okabe and Ito (2008), told apart by those who see red and green alike; what differs in colour differs in line too, for
print in grey.
"""
import numpy as np
from matplotlib import patheffects
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from .errors import PlotError
from .polygons import boxes_that_meet
from .units import Units

SLIDING, LOCKED = 1, 2  # /contacts/state
STATES = {"stick": dict(colors="#0072B2", linewidths=1.6, linestyles="solid"),
          "slip": dict(colors="#D55E00", linewidths=2.8, linestyles="solid"),
          "open": dict(colors="black", linewidths=1.4, linestyles=(0, (1, 1.2)))}
COMPRESSION, TENSION = dict(colors="black", linewidths=1.1), dict(colors="#D55E00", linewidths=1.8)
FORCE = dict(colors="#009E73", linewidths=1.8)
MANY_BLOCKS = 100  # from which on their lines are thinner
CELLS = 36       # over the width of a picture, that hold one vector or cross each
LONGEST = 0.07   # of a vector, over that width
CROSS = 0.07     # of a cross
PARALLEL = 0.05  # sine of the most that an edge is turned from that of a contact on it; by more it touches with a corner
BESIDE = 0.05    # of an edge and a contact on it, over the length of the edge
CORNER = 0.3     # of a piece of joint at a corner, over the shortest edge of its block
OUTSIDE = 1e-3   # of what lies against an edge, over the length of the shorter one; a shorter part is none


class Common:
    """What the panels of a picture have in common: their frames, size and units, and the scales of what is drawn over them."""

    def __init__(self, slots, size, units=None):
        self.slots, self.size, self.units, self.largest = slots, size, units or Units(), {}

    def scale(self, measure, share):
        """Length in the picture for one of what is measured, `measure(file, frame)`: its large values, but for the 2 % above them,
        are as long as a share of the picture. The large value too."""
        if measure not in self.largest:
            values = np.concatenate([np.abs(np.ravel(measure(file, frame))) for file, frame in self.slots])
            self.largest[measure] = robust_limits(values, 0.02)[1] if len(values) else 0.0
        largest = self.largest[measure]
        return (share * self.size / largest if largest > 0 else 0.0), largest


def robust_limits(values, share=0.01):
    """Least and largest without so large a share of the values at each end; of few values all count."""
    values = np.sort(np.asarray(values, float).ravel())
    left_out = int(share * len(values))
    return values[left_out], values[len(values) - 1 - left_out]


def spread_out(places, there, common):
    """Elements that are drawn of those that are there: in each cell of a lattice the one with its place nearest to its middle."""
    there = np.flatnonzero(there)
    cell = np.floor(places / (common.size / CELLS)) + 0.5
    order = there[np.argsort(((places / (common.size / CELLS) - cell) ** 2).sum(1)[there], kind="stable")]
    return order[np.unique(cell[order], axis=0, return_index=True)[1]]


def round_below(value):
    """The largest of 1, 2 and 5 times a power of ten up to a value."""
    power = 10.0 ** np.floor(np.log10(value))
    return power * max(digit for digit in (1, 2, 5) if digit * power <= value * (1 + 1e-9))


def draw_scale(axis, scale, largest, what, colour, units):
    """A bar with its value in the corner of a panel, below those that are there."""
    if not largest > 0:
        return
    what, factor = units.of(what)
    scale, value, row = scale * factor, round_below(largest / factor), len(getattr(axis, "scale_bars", []))
    axis.scale_bars = [*getattr(axis, "scale_bars", []), what]
    left, right = axis.get_xlim()
    start, height = left + 0.03 * (right - left), 0.95 - 0.07 * row
    axis.plot([start, start + scale * value], [height, height], color=colour, linewidth=2, transform=axis.get_xaxis_transform(),
              solid_capstyle="butt", label="_scale")
    axis.text(start + scale * value + 0.015 * (right - left), height, f"{value:g} {what}", fontsize=7, va="center",
              transform=axis.get_xaxis_transform(), path_effects=[patheffects.withStroke(linewidth=2, foreground="white")])


def results_of(file, what):
    """The results behind a frame; PlotError for a geometry, which has none."""
    if not hasattr(file, "file"):
        raise PlotError(f"{file.name}: expected a results file for {what}, found a geometry")
    return file.file


def first_of(lists):
    """Where each list begins, of all of them one after the other."""
    return np.cumsum([0, *map(len, lists[:-1])])


def all_corners(file):
    """Where the corners of each element begin, of those of all one after the other; and of each corner its vertex, the next one and
    the first of its element."""
    if not hasattr(file, "all_corners"):
        first, every = first_of(file.corners), np.concatenate(file.corners)
        after = np.concatenate([np.roll(corners, -1) for corners in file.corners])
        file.all_corners = first, every, after, np.repeat(every[first], list(map(len, file.corners)))
    return file.all_corners


def means(file, frame, values):
    """Of a linear field, its value at the centroid of each element, from those at all vertices."""
    first, every, after, of_first = all_corners(file)
    places = file.file.vertices(frame)
    own, own_after = places[every] - places[of_first], places[after] - places[of_first]
    twice = own[:, 0] * own_after[:, 1] - own[:, 1] * own_after[:, 0]
    sums = np.add.reduceat(twice[:, None] * (values[every] + values[after] + values[of_first]), first)
    return sums / (3 * np.add.reduceat(twice, first))[:, None]


def centroids(file, frame):
    """Of each element, as drawn."""
    return means(file, frame, file.vertices(frame))


def displacements(file, frame):
    """Of the centroid of each element."""
    return means(file, frame, results_of(file, "--vectors").displacement(frame))


def velocities(file, frame):
    return means(file, frame, results_of(file, "--vectors").velocity(frame))


def lengths(vectors):
    """How long the vectors of a frame are, as a measure."""
    def measure(file, frame):
        return np.linalg.norm(vectors(file, frame), axis=1)
    return measure


lengths_of = {vectors: lengths(vectors) for vectors in (displacements, velocities)}


def draw_arrows(vectors, name, dimension):
    """What draws vectors at the centroids of elements."""
    def draw(axis, file, frame, common):
        found = vectors(file, frame)
        scale, largest = common.scale(lengths_of[vectors], LONGEST)
        places = centroids(file, frame)
        chosen = spread_out(places, file.present(frame), common)
        chosen = chosen[np.linalg.norm(found[chosen], axis=1) * scale > 1e-3 * common.size]  # no dots
        if len(chosen):
            axis.quiver(*places[chosen].T, *(scale * found[chosen]).T, angles="xy", scale_units="xy", scale=1, width=0.004,
                        headwidth=4, headlength=5, color="black", edgecolor="white", linewidth=0.4, zorder=4)
        draw_scale(axis, scale, largest, f"{name} [{dimension}]", "black", common.units)
        return {}
    return draw


VECTORS = {"displacement": draw_arrows(displacements, "displacement", "length"),
           "velocity": draw_arrows(velocities, "velocity", "length/time")}


def principal_stresses(file, frame):
    """Larger and smaller one of each element (e, 2), tension positive, and the direction of the larger, its angle with x (e)."""
    xx, yy, xy = results_of(file, "--crosses").stress(frame).T
    mean, half = (xx + yy) / 2, np.hypot((xx - yy) / 2, xy)
    return np.stack([mean + half, mean - half], axis=1), np.arctan2(2 * xy, xx - yy) / 2


def principal_values(file, frame):
    return principal_stresses(file, frame)[0]


def draw_crosses(axis, file, frame, common):
    """Principal stresses of elements as crosses: lines along their directions, as long as they are large."""
    values, angle = principal_stresses(file, frame)
    scale, largest = common.scale(principal_values, CROSS)
    places = centroids(file, frame)
    chosen, entries = spread_out(places, file.present(frame), common), {}
    along = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    place = np.concatenate([places[chosen]] * 2)
    value = np.concatenate([values[chosen, 0], values[chosen, 1]])
    half = (scale * np.abs(value) / 2)[:, None] * np.concatenate([along[chosen], across[chosen]])
    for name, which, look in (("compression", value < 0, COMPRESSION), ("tension", value > 0, TENSION)):
        if scale > 0:
            axis.add_collection(LineCollection(np.stack([place - half, place + half], axis=1)[which], zorder=4, label=name, **look))
        entries[name] = Line2D([], [], color=look["colors"], linewidth=look["linewidths"])
    draw_scale(axis, scale, largest, "principal stress [force/length$^2$]", "black", common.units)
    return entries


def parts_against_others(file):
    """Parts of the edges of joints, also of those that cracks make later, that lie against edges of other elements at the start: the edge (n),
    a row of `edge_list`, and from where to where along it, in shares (n, 2)."""
    if not hasattr(file, "against"):
        _, joint, element = file.edge_list()
        rows = np.flatnonzero(joint > 0)
        edges, element = file.places(rows, 0), element[rows]
        first = np.flatnonzero(np.diff(element, prepend=-1))  # edge of each element that has some
        of_element = np.split(np.arange(len(edges)), first)[1:]
        found, shares = [np.empty(0, int)], [np.empty((0, 2))]
        for own, others in zip(of_element, neighbours(edges, first)):
            others = np.concatenate([of_element[k] for k in others] or [own[:0]])
            there, part = lying_against(edges[own], edges[others])
            found.append(own[np.nonzero(there)[0]])
            shares.append(part[there])
        file.against = rows[np.concatenate(found)], np.concatenate(shares)
    return file.against


def neighbours(edges, first):
    """Of each element, by the first of its edges, those that its edges may lie against."""
    if len(first) == 0:
        return []
    spare = OUTSIDE * np.maximum.reduceat(np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1), first)[:, None]
    pairs = boxes_that_meet(np.minimum.reduceat(edges.min(1), first) - spare, np.maximum.reduceat(edges.max(1), first) + spare)
    pairs = np.concatenate([pairs, pairs[:, ::-1]])
    pairs = pairs[np.argsort(pairs[:, 0], kind="stable")]
    return np.split(pairs[:, 1], np.searchsorted(pairs[:, 0], np.arange(1, len(first))))


def lying_against(edges, others):
    """Whether each of some edges (n, 2, 2) lies against each of others (m, 2, 2), which runs the other way, and from where to where
    along it, in shares: (n, m) and (n, m, 2)."""
    side = edges[:, 1] - edges[:, 0]
    length, of_others = np.linalg.norm(side, axis=1)[:, None], np.linalg.norm(others[:, 1] - others[:, 0], axis=1)
    off = others[:, ::-1] - edges[:, None, None, 0]
    along = (off @ side[:, None, :, None])[..., 0] / length[..., None] ** 2
    away = (off @ np.stack([side[:, 1], -side[:, 0]], axis=1)[:, None, :, None])[..., 0] / length[..., None]
    run, rise = (np.diff(values, axis=2) for values in (along, away))
    part = np.clip(along, 0, 1)
    gap = np.abs(away[..., :1] + rise / np.where(run > 0, run, 1) * (part - along[..., :1])).max(2)
    near = OUTSIDE * np.minimum(length, of_others)
    there = (run[..., 0] > 0) & (gap <= near) & (np.abs(rise[..., 0]) <= PARALLEL * of_others)
    return there & (np.diff(part, axis=2)[..., 0] * length > near), part


def edges_of_contact(edges, place, normal):
    """Which edges a contact is on: those near it that run across its normal; both that end in a vertex on a straight joint."""
    side = edges[:, 1] - edges[:, 0]
    length = np.linalg.norm(side, axis=1)
    share = np.clip(((place - edges[:, 0]) * side).sum(1) / length ** 2, 0, 1)
    distance = np.linalg.norm(edges[:, 0] + share[:, None] * side - place, axis=1) / length
    return np.flatnonzero((distance < BESIDE) & (np.abs(side @ normal) <= PARALLEL * length))


def common_part(edge, other):
    """From where to where along an edge another one lies on it, in shares of it (2); None where that is nowhere."""
    side = edge[1] - edge[0]
    shares = np.clip(np.sort((other - edge[0]) @ side / (side @ side)), 0, 1)
    return shares if shares[0] < shares[1] else None


def vertices_of_contacts(file, frame):
    """The vertex of each contact of a frame: of those of its block that at its place."""
    results, contacts = file.file, file.file.contacts_of(frame)
    places = np.vstack([results.vertices(frame), contacts.place])
    n_vertices = len(places) - len(contacts)
    owner = np.zeros(len(places), int)
    owner[all_corners(file)[1]] = np.repeat(results.blocks(frame), list(map(len, file.corners)))
    owner[n_vertices:] = contacts.blocks[:, 0]
    order = np.lexsort((np.arange(len(places)), places[:, 1], places[:, 0], owner))  # contacts behind the vertex of their place
    last = np.maximum.accumulate(np.where(order < n_vertices, np.arange(len(order)), 0))
    vertex = np.empty(len(places), int)
    vertex[order] = order[last]
    vertex = vertex[n_vertices:]
    if not (places[vertex] == contacts.place).all():
        raise PlotError(f"{file.name}: expected contacts at vertices in frame {frame}, found others")
    return vertex


def joint_states(file, frame):
    """Parts of joints (n, 2, 2) by state: slip where a contact on them slides, stick where those on them are locked: what two edges
    have of each other, or a short piece at a corner that touches an edge alone. Open: of edges without contact what lay against
    others at the start. At the start itself contacts are not looked for yet: there are none of them."""
    results = results_of(file, "--joints state")
    contacts = results.contacts_of(frame)
    if contacts is None:
        raise PlotError(f"{file.name}: expected a run with contacts for --joints state, found one without")
    rows = file.faces(frame)
    edges, drawn, element = file.places(rows, frame, magnified=False), file.places(rows, frame), file.edge_list(frame)[2][rows]
    places, block = file.vertices(frame)[vertices_of_contacts(file, frame)], results.blocks(frame)[element]
    of_block = {b: np.flatnonzero(block == b) for b in np.unique(block)}
    found, parts, touched = {}, {SLIDING: [], LOCKED: []}, set()
    for (of_vertex, of_edge), now, place, shown, normal in zip(contacts.blocks, contacts.state, contacts.place, places,
                                                               contacts.normal):
        first, second = (of_block[b][edges_of_contact(edges[of_block[b]], place, normal)] for b in (of_vertex, of_edge))
        touched.update(first, second)
        for pair in ((a, b) for a in first for b in second if a != b):
            found[pair] = min(found.get(pair, now), now)  # sliding wins
        if len(first) == 0 and len(second):
            piece = CORNER * np.linalg.norm(edges[of_block[of_vertex], 1] - edges[of_block[of_vertex], 0], axis=1).min()
            along = np.array([-normal[1], normal[0]])
            parts[now].append(shown + piece / 2 * np.array([-along, along]))
    for (a, b), now in found.items():
        shares = common_part(edges[b], edges[a])
        if shares is not None:
            parts[now].append(part_of(drawn[b], shares))
    edge, shares = parts_against_others(file)
    open_ = np.isin(edge, np.delete(rows, list(touched))) & (frame > 0)
    return {"stick": as_segments(parts[LOCKED]), "slip": as_segments(parts[SLIDING]),
            "open": as_segments([part_of(place, own) for place, own in zip(file.places(edge[open_], frame), shares[open_])])}


def part_of(edge, shares):
    """The ends of a part of an edge."""
    return edge[0] + shares[:, None] * (edge[1] - edge[0])


def as_segments(parts):
    return np.array(parts).reshape(-1, 2, 2)


def thinner_by(file):
    """What the lines at the joints of many blocks are thinner by."""
    return min(1.0, (MANY_BLOCKS / results_of(file, "--joints state").n_blocks) ** 0.3)


def draw_joint_states(axis, file, frame, common):
    """Edges by what their contacts do; the more there are, the thinner."""
    thinner = thinner_by(file)
    for name, edges in joint_states(file, frame).items():
        look = STATES[name] | {"linewidths": thinner * STATES[name]["linewidths"]}
        axis.add_collection(LineCollection(edges, zorder=3, label=name, **look))
    return {name: Line2D([], [], color=look["colors"], linewidth=look["linewidths"], linestyle=look["linestyles"])
            for name, look in STATES.items()}


def contact_forces(file, frame):
    """Force of each closed contact on the block of its vertex (n, 2), x and y."""
    contacts = results_of(file, "--joints forces").contacts_of(frame)
    if contacts is None or len(contacts) == 0:
        return np.empty((0, 2))
    left = np.stack([-contacts.normal[:, 1], contacts.normal[:, 0]], axis=1)
    return contacts.force[:, :1] * contacts.normal + contacts.force[:, 1:] * left


measure_of_forces = lengths(contact_forces)


def draw_contact_forces(axis, file, frame, common):
    """States of joints, and the force of each contact as a bar along it through its place."""
    entries = draw_joint_states(axis, file, frame, common)
    forces = contact_forces(file, frame)
    thinner = thinner_by(file)
    scale, largest = common.scale(measure_of_forces, LONGEST * thinner ** 2)
    look = FORCE | {"linewidths": thinner * FORCE["linewidths"]}
    if len(forces):
        place, half = file.vertices(frame)[vertices_of_contacts(file, frame)], scale * forces / 2
        axis.add_collection(LineCollection(np.stack([place - half, place + half], axis=1), zorder=5, label="force", **look))
    draw_scale(axis, scale, largest, "force of contact [force/length]", FORCE["colors"], common.units)
    return {**entries, "force of contact": Line2D([], [], color=FORCE["colors"], linewidth=FORCE["linewidths"])}
