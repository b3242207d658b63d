"""Random rows of flush blocks over which a box slides, tips that land on a joint of two blocks, and stacks whose blocks overlap."""
import dataclasses
import os

import numpy as np
import pytest
import scree
from scree.block_files import block_file, box, held
from shapely.geometry import Point, Polygon
from shapely.ops import unary_union
from test_bodies_overlap import crossing_stack

SCENES = int(os.environ.get("SCREE_SCENES", "12"))
G, DENSITY, YOUNG = 10.0, 2500.0, 1e10
SPRINGS = ("", "&method strain='green' /", "&contact restitution=0.5 /")
GROUPS = (*SPRINGS, "&contact method='augmented' /")
DEEP = 0.5  # height of the blocks of a row


def run(folder, blocks, fixed, *, steps, dt=5e-3, young=YOUNG, phi=0.0, group="", speed=(0.0, 0.0)):
    """Runs blocks under gravity. The last of them begins with a velocity."""
    materials = [1] * (len(blocks) - 1) + [2]
    rock = f"{DENSITY} {DENSITY * G} {young} 0.2 {'0 ' * 6}"
    (folder / "a.blk").write_text(block_file("A random scene", list(zip(materials, blocks)), fixed))
    (folder / "a.ana").write_text("\n".join([
        f"1 {steps} 2 1 0.05 {dt}", f"{rock} 0 0 0", f"{rock} {speed[0]} {speed[1]} 0", f"{phi} 0 0",
        "&deck geometry='a.blk', dialect='short' /", "&output every=1 /", group, ""]))
    return scree.run(folder / "a.ana", output=folder / "a.h5", timeout=300)


def largest_gain(r):
    """The most energy that a step brings from nowhere."""
    return -np.diff(r.history.energy.dissipated, prepend=0.0).min()


@dataclasses.dataclass
class Row:
    """Flush blocks that are held, by their lengths, and a box that slides over them."""

    lengths: np.ndarray
    length: float
    height: float
    start: float
    speed: float
    dt: float
    young: float

    def run(self, folder, group):
        """The results, and the number of the box from 0. The box slides for 60 steps, or to the end of the row."""
        ends = np.concatenate([[0], np.cumsum(self.lengths)])
        row = [box(a, b, -DEEP, 0) for a, b in zip(ends[:-1], ends[1:])]
        fixed = [point for k, x in enumerate(row, 1) for point in held(x, k)]
        way = 0.95 * (ends[-1] - self.start - self.length)
        blocks = [*row, box(self.start, self.start + self.length, 0, self.height)]
        return run(folder, blocks, fixed, steps=min(60, int(way / self.speed / self.dt)), dt=self.dt, young=self.young, group=group,
                   speed=(self.speed, 0.0)), len(row)


def drawn_row(random):
    """A row that is at least 1.5 m longer than the box."""
    lengths, length = random.uniform(0.1, 1, int(random.integers(4, 13))), random.uniform(0.3, 1.5)
    while lengths.sum() < length + 1.5:
        lengths = np.append(lengths, random.uniform(0.1, 1))
    return Row(lengths, length, random.uniform(0.1, 0.6), random.choice([0.0, random.uniform(0, 0.5)]), random.uniform(0.5, 5),
               float(random.choice([2e-3, 5e-3, 1e-2])), float(random.choice([1e10, 5e8])))


@pytest.mark.parametrize("number", range(SCENES))
def test_a_block_that_slides_over_a_row_is_not_caught(number, tmp_path):
    """The box slides without friction, and no side of a block stands in its way. So it keeps its speed, to 1e-5."""
    row = drawn_row(np.random.default_rng(number))
    r, box_number = row.run(tmp_path, GROUPS[number % len(GROUPS)])
    x = r.bodies.centroid[:, box_number, 0]
    assert (np.diff(x) > 0).all()
    assert np.abs(r.bodies.velocity[:, box_number, 0] / row.speed - 1).max() < 1e-5


def tip_in(polygons, tip):
    """How deep the vertices of a tip lie in the union of two flush blocks. Both are grown by 1e-6, and the union shrunk by as much, to close
    the gap that rounding leaves between them."""
    grown = unary_union([Polygon(x).buffer(1e-6, join_style=2) for x in polygons]).buffer(-1e-6, join_style=2)
    return max((grown.boundary.distance(Point(*x)) for x in tip if grown.contains(Point(*x))), default=0.0)


@pytest.mark.parametrize("number", range(SCENES))
def test_a_tip_that_lands_on_a_joint_is_borne_and_gains_nothing(number, tmp_path):
    """The tip lands on the joint of two flush blocks, or up to 1e-4 m beside the joint. It goes in no deeper than its spring is pressed, to
    1e-6 m. No step gains more than 1e-9 of the kinetic energy and of the energy of the fall."""
    random = np.random.default_rng(number)
    aside = random.choice([0, 1e-12, 1e-9, 1e-6, 1e-4]) * random.choice([-1, 1])
    gap, half, lean, size = 10 ** random.uniform(-5, -2.5), random.uniform(0.2, 1.2), random.uniform(-0.3, 0.3), random.uniform(0.3, 1)
    tip = size * np.array([[0, 0], *([np.sin(lean + a), np.cos(lean + a)] for a in (half, -half))]) + [aside, gap]
    blocks = [box(-1.5, 1.5, -2 * DEEP, -DEEP), box(-1, 0, -DEEP, 0), box(0, 1, -DEEP, 0), tip]
    fixed = [(*x, k + 1) for k in range(3 if random.random() < 0.5 else 1) for x in blocks[k]]
    speed = gap / 5e-3 * random.uniform(0.3, 3)
    r = run(tmp_path, blocks, fixed, steps=20, phi=float(random.choice([0, 30])), group=SPRINGS[number % len(SPRINGS)],
            speed=(0.0, -speed))
    for frame in range(1, r.n_frames):
        polygons, contacts = r.polygons(frame), r.contacts_of(frame)
        pressed = contacts.force[(contacts.blocks == 4).any(1), 0].max(initial=0.0) / (5 * YOUNG)
        assert tip_in(polygons[1:3], polygons[3]) < pressed + 1e-6
    assert r.history.contacts.any()
    assert largest_gain(r) < 1e-9 * (r.history.energy.kinetic.max() + np.ptp(r.history.energy.gravity))


@pytest.mark.parametrize("number", range(SCENES))
def test_a_stack_whose_blocks_overlap_gains_nothing(number, tmp_path):
    """When the run begins, the blocks overlap by 1e-4 of their size, corners across both of their lines. No step gains more than 1e-9 of
    the weight of the stack times its height."""
    random = np.random.default_rng(number)
    blocks = crossing_stack(random, 1e-4)
    fixed = [(*x, 1) for x in blocks[0]]
    r = run(tmp_path, blocks, fixed, steps=20, phi=float(random.choice([0, 40])), group=SPRINGS[number % len(SPRINGS)])
    assert r.history.overlap[0] > 1e-5
    area, height = sum(Polygon(x).area for x in blocks[1:]), max(x[:, 1].max() for x in blocks)
    assert largest_gain(r) < 1e-9 * DENSITY * G * area * height
