"""Random pairs of blocks, many in one deck and far from each other, and an independent judge of how deep the blocks overlap."""
import dataclasses

import numpy as np
import scree
from scree.block_files import block_file, box
from shapely.geometry import Polygon

DENSITY, YOUNG, STIFFNESS = 2500.0, 1e10, 5e10  # the spring of a contact has 5 E, the default
DT = 5e-3
STEPS = 8


@dataclasses.dataclass
class Pair:
    """Two polygons (n, 2), counter-clockwise, with a velocity (vx, vy, w) and a load (fx, fy) each. A body without a velocity is held.
    `size` is the root of the smaller area."""

    corners: tuple
    velocities: tuple
    loads: tuple = ((0.0, 0.0), (0.0, 0.0))

    @property
    def size(self):
        return min(Polygon(x).area for x in self.corners) ** 0.5


def inner_point(corners):
    """A point inside a polygon: its centroid if that lies inside."""
    polygon = Polygon(corners)
    inside = polygon.centroid if polygon.contains(polygon.centroid) else polygon.representative_point()
    return np.array([inside.x, inside.y])


def lattice(pairs):
    """Places (n, 2) of a square lattice at which the pairs are far from each other."""
    reach = max(np.ptp(np.concatenate(pair.corners), axis=0).max() for pair in pairs)
    columns = int(np.ceil(len(pairs) ** 0.5))
    return 3 * reach * np.array([(k % columns, k // columns) for k in range(len(pairs))])


def run(folder, pairs, places=None, groups=(), steps=STEPS, dt=DT, phi=0.0, stiffness=STIFFNESS, name="pairs"):
    """Runs all pairs in one deck, each moved to its place. Pair k has the blocks 2k and 2k + 1."""
    places = lattice(pairs) if places is None else places
    blocks, materials, fixed, load, forces = [], [], [], [], []
    for pair, place in zip(pairs, places):
        for corners, velocity, force in zip(pair.corners, pair.velocities, pair.loads):
            x = np.asarray(corners) + place
            materials.append(f"{DENSITY} 0 {YOUNG} 0.2 {'0 ' * 6} {' '.join(str(float(v)) for v in velocity or (0, 0, 0))}")
            blocks.append((len(materials), x))
            if velocity is None:
                fixed += [(*vertex, len(blocks)) for vertex in x]
            elif any(force):
                load.append((*inner_point(x), len(blocks)))
                forces += [float(f) for f in force]
    (folder / f"{name}.blk").write_text(block_file("Random pairs", blocks, fixed, load))
    loads = [f"&loads force={' '.join(map(repr, forces))} /"] if forces else []
    (folder / f"{name}.ana").write_text("\n".join([
        f"1 {steps} {len(materials)} 1 0.05 {dt}", *materials, f"{phi} 0 0", f"&deck geometry='{name}.blk', dialect='short' /",
        f"&contact stiffness={stiffness} /", "&output every=1 /", *loads, *groups, ""]))
    return scree.run(folder / f"{name}.ana", output=folder / f"{name}.h5", timeout=600)


def depth(a, b):
    """The depth of the common area of two polygons. It is that of the deepest piece of the area. A piece is as deep as it reaches behind
    the line of an edge that bounds the piece, the least of all such edges."""
    common = Polygon(a).intersection(Polygon(b))
    near = 1e-9 * max(np.ptp(a, axis=0).max(), np.ptp(b, axis=0).max())
    worst = 0.0
    for piece in getattr(common, "geoms", [common]):
        if piece.geom_type != "Polygon" or piece.area == 0:
            continue
        corners = np.array(piece.exterior.coords)[:-1]
        middles = (corners + np.roll(corners, -1, axis=0)) / 2
        behind = []
        for x in (a, b):
            along = np.roll(x, -1, axis=0) - x
            along /= np.linalg.norm(along, axis=1)[:, None]
            outward = np.column_stack([along[:, 1], -along[:, 0]])
            across = np.einsum("ek,eck->ec", outward, corners[None] - x[:, None])
            on_line = (np.abs(across) < near) & (np.abs(np.roll(across, -1, axis=1)) < near)
            place = np.einsum("ek,eck->ec", along, middles[None] - x[:, None])
            length = np.linalg.norm(np.roll(x, -1, axis=0) - x, axis=1)[:, None]
            bounds = (on_line & (place > -near) & (place < length + near)).any(1)
            behind += list(-across.min(1)[bounds])
        worst = max(worst, min(behind, default=0.0))
    return worst


def without_contact(r, pairs):
    """The largest depth of the common area of each pair (k) in the frames in which the pair has no closed contact, over the size of the
    smaller body."""
    worst = np.zeros(len(pairs))
    for frame in range(r.n_frames):
        polygons = r.polygons(frame)
        for k in set(range(len(pairs))) - set((r.contacts_of(frame).blocks[:, 0] - 1) // 2):
            worst[k] = max(worst[k], depth(polygons[2 * k], polygons[2 * k + 1]) / pairs[k].size)
    return worst


def unborne(r, pairs, stiffness=STIFFNESS):
    """How much deeper the common area of each pair is than the most pressed spring of the pair, in each frame (k, f), over the size of the
    smaller body."""
    size = np.array([pair.size for pair in pairs])
    excess = np.zeros((len(pairs), r.n_frames))
    for frame in range(r.n_frames):
        polygons = r.polygons(frame)
        contacts = r.contacts_of(frame)
        pressed = np.zeros(len(pairs))
        np.maximum.at(pressed, (contacts.blocks[:, 0] - 1) // 2, contacts.force[:, 0] / stiffness)
        for k in range(len(pairs)):
            excess[k, frame] = (depth(polygons[2 * k], polygons[2 * k + 1]) - pressed[k]) / size[k]
    return excess


def polygon(random, least=0.1):
    """Of 3 to 8 vertices about the origin, convex or a star, of radius 1; its edges are at least `least` long."""
    while True:
        n = int(random.integers(3, 9))
        angles = np.sort(random.uniform(0, 2 * np.pi, n))
        if np.diff(angles, append=angles[0] + 2 * np.pi).max() > 2.8:
            continue
        radius = np.ones(n) if random.random() < 0.5 else random.uniform(0.3, 1, n)
        x = np.column_stack([np.cos(angles), np.sin(angles)]) * radius[:, None]
        side = np.roll(x, -1, axis=0) - x
        length = np.linalg.norm(side, axis=1)
        before = -np.roll(side, 1, axis=0)
        sharp = np.einsum("ik,ik->i", side, before) / length / np.linalg.norm(before, axis=1)
        if length.min() > least and sharp.max() < np.cos(np.radians(15)):
            return x


def place_on(random, x):
    """A random place on the outline of a polygon, a vertex in half of all draws, and the outward direction there."""
    i = int(random.integers(len(x)))
    tangent = np.roll(x, -1, axis=0)[i] - x[i]
    share = 0.0 if random.random() < 0.5 else random.uniform(0.02, 0.98)
    if share == 0.0:
        tangent = tangent / np.linalg.norm(tangent) + (x[i] - x[i - 1]) / np.linalg.norm(x[i] - x[i - 1])
        return x[i], np.array([tangent[1], -tangent[0]]) / np.linalg.norm(tangent)
    return x[i] + share * tangent, np.array([tangent[1], -tangent[0]]) / np.linalg.norm(tangent)


def turn(angle):
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def apart(a, b, way, gap):
    """The second polygon, moved along a direction until it is first a gap away from the first."""
    first = Polygon(a)
    distance = lambda t: first.distance(Polygon(b + t * way))
    step = gap / 2
    t = 0.0
    while distance(t) < gap:
        step = min(1.5 * step, 0.05)
        t += step
    low, high = t - step, t
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if distance(middle) >= gap else (middle, high)
    return b + high * way


def facing(random, a, b):
    """The second polygon, moved so that a place on its outline lies at a place of the first and faces it more or less. The direction
    away from there."""
    place, outward = place_on(random, a)
    own, inward = place_on(random, b)
    angle = np.arctan2(-outward[1], -outward[0]) - np.arctan2(inward[1], inward[0])
    angle += random.choice([0.0, np.radians(random.uniform(-3, 3)), random.uniform(-np.pi / 2, np.pi / 2)])
    return (b - own) @ turn(angle).T + place, outward @ turn(random.uniform(-0.3, 0.3)).T


def corners_opposite(random, a, b, gap):
    """The second polygon, moved so that edges of both face opposite ways within 3 degrees, and an end of one lies at an end of the other,
    or up to a gap aside. The outward direction of the edge."""
    i, k = int(random.integers(len(a))), int(random.integers(len(b)))
    along, own = np.roll(a, -1, axis=0)[i] - a[i], np.roll(b, -1, axis=0)[k] - b[k]
    tilt = np.radians(random.choice([0.0, random.uniform(-3, 3)]))
    angle = np.arctan2(-along[1], -along[0]) - np.arctan2(own[1], own[0]) + tilt
    first = random.random() < 0.5
    end, corner = (a[i], b[k]) if first else (np.roll(a, -1, axis=0)[i], np.roll(b, -1, axis=0)[k])
    along /= np.linalg.norm(along)
    aside = random.uniform(-1, 1) * gap * (abs(tilt) if random.random() < 0.5 else 1.0)
    return (b - corner) @ turn(angle).T + end + aside * along, np.array([along[1], -along[0]])


def drawn(random):
    """Two random polygons near each other, with a size ratio up to 20. One is held, or both are free. Velocities or loads push them
    together, by a third of the gap to three times the gap in the first step."""
    ratio = 20 ** random.random()
    a, b = ratio * polygon(random), polygon(random)
    if random.random() < 0.3:
        a, b = b, a
    gap = 10 ** random.uniform(-4, -1.3)
    b, outward = corners_opposite(random, a, b, gap) if random.random() < 0.25 else facing(random, a, b)
    b = apart(a, b, outward, gap)
    way = gap * 3 ** random.uniform(-1, 1)
    push = -(outward @ turn(random.choice([0.0, random.uniform(-1, 1)])).T)
    free = random.random() < 0.4
    by_load = random.random() < 0.5
    share = (0.5, 0.5) if free else (0.0, 1.0)
    velocities, loads = [], []
    for x, part, sign in ((a, share[0], -1), (b, share[1], 1)):
        if part == 0:
            velocities.append(None)
            loads.append((0.0, 0.0))
        elif by_load:
            velocities.append((0.0, 0.0, 0.0))
            loads.append(tuple(sign * part * way / DT**2 * DENSITY * Polygon(x).area * push))
        else:
            spin = random.choice([0.0, random.uniform(-1, 1)]) * way / DT / np.ptp(x, axis=0).max()
            velocities.append((*(sign * part * way / DT * push), spin))
            loads.append((0.0, 0.0))
    return Pair((a, b), tuple(velocities), tuple(loads))


def along_a_sword(random, thin):
    """A place on the axis of a body from -1 to 1, within three thicknesses of an end in most draws."""
    return random.choice([-1, 1]) * (1 - random.uniform(-1, 3) * thin) if random.random() < 0.7 else random.uniform(-1, 1)


def swords(random):
    """Two thin bodies at an angle, half of all draws near the ends of both. In a step velocities take them across each other by a tenth of
    their thickness to three times the thickness."""
    thin = 10 ** random.uniform(-2.5, -0.7)
    a = box(-1, 1, -thin / 2, thin / 2)
    b = (a - [along_a_sword(random, thin), 0]) @ turn(random.uniform(0.3, np.pi - 0.3)).T + [along_a_sword(random, thin), 0]
    way = turn(random.uniform(-0.5, 0.5)) @ [0, 1]
    b = apart(a, b, way, thin * 10 ** random.uniform(-2, 0))
    speed = thin * 10 ** random.uniform(-1, 0.5) / DT
    spin = random.choice([0.0, random.uniform(-0.05, 0.05)]) * speed
    if random.random() < 0.5:
        return Pair((a, b), (None, (*(-speed * way), spin)))
    return Pair((a, b), ((*(speed / 2 * way), 0.0), (*(-speed / 2 * way), spin)))
