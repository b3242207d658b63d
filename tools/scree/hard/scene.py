"""A hard scene: blocks of about unit edge, which it is written in any size."""
import dataclasses
import math

import numpy as np

from ..bench.scenes import DENSITY, GRAVITY, POISSON, YOUNG
from ..block_files import block_file, held

EDGE, STEPS = 1.0, (5e-3, 1e-3)  # m; s, of blocks of that edge


@dataclasses.dataclass
class Block:
    """Corners, counter-clockwise. Velocity: x, y in m/s, rotation rate in 1/s. Weight is that of the density, but of what is fixed."""

    corners: np.ndarray
    density: float = DENSITY
    velocity: tuple = (0.0, 0.0, 0.0)
    fixed: bool = False


@dataclasses.dataclass(frozen=True)
class Size:
    """A size of a scene: everything that has a length is `edge` times as long, and nothing else is another motion: gravity and
    densities stay, so times grow by the root, and the stiffness of rock, as stresses do, by the length."""

    edge: float = EDGE

    @property
    def time(self):
        return math.sqrt(self.edge)

    @property
    def young(self):
        return YOUNG * self.edge

    def speed(self, velocity):
        return velocity[0] * self.time, velocity[1] * self.time, velocity[2] / self.time


@dataclasses.dataclass
class Scene:
    """Blocks, what they are to do, and bounds of what must be true, in lengths of a block of edge 1.

    `settings` is asked for a size. `pushes` are (x, y, block number from 0, fx, fy). `shake` is (amplitude, frequency) of the ground
    along x in units of g and Hz. `answer` is given the results and the size and says what is wrong, or ''.
    """

    blocks: list
    answer: object = None
    mu: float = 0.6
    end: float = 2.0
    settings: object = lambda size: []
    pushes: list = ()
    shake: tuple = ()
    gravity: float = GRAVITY
    young: float = 1.0             # times that of all scenes
    overlap: float = 1e-3          # that frames may have
    gain: float = 1e-3             # of energy out of nothing, over what there is
    area: float = 0.02             # change of that of a block
    may_refuse: bool = False       # a run that is refused, or stops, with block and reason has told the truth
    convex: bool = True

    def write(self, folder, name, size, step):
        """Writes geometry and analysis for steps of so many seconds of the scene of edge 1, and returns them."""
        geometry, analysis = folder / f"{name}.blk", folder / f"{name}.ana"
        kinds = sorted({(b.density, b.velocity, b.fixed) for b in self.blocks}, key=str)
        fixed = [point for i, b in enumerate(self.blocks) if b.fixed
                 for point in held(size.edge * np.asarray(b.corners), i + 1, 0.01 if self.convex else 0.0)]
        load = [(size.edge * x, size.edge * y, block + 1) for x, y, block, _, _ in self.pushes]
        geometry.write_text(block_file(name, [(kinds.index((b.density, b.velocity, b.fixed)) + 1, size.edge * np.asarray(b.corners))
                                              for b in self.blocks], fixed, load))
        rock = f"{self.young * size.young} {POISSON}"
        materials = "".join(f"{density} {0.0 if still else density * self.gravity} {rock} 0 0 0 0 0 0 "
                            f"{' '.join(repr(float(v)) for v in size.speed(velocity))}\n" for density, velocity, still in kinds)
        groups = ""
        if self.pushes:
            groups += "&loads force=" + " ".join(str(size.edge**2 * float(f)) for *_, fx, fy in self.pushes for f in (fx, fy)) + " /\n"
        if self.shake:
            groups += "&acceleration table=" + " ".join(map(str, self.motion(size))) + " /\n"
        end = self.end * size.time
        analysis.write_text(f"1 {max(1, round(self.end / step))} {len(kinds)} 1 0.05 {step * size.time}\n{materials}"
                            f"{math.degrees(math.atan(self.mu))} 0 0\n&deck dialect='short' /\n"
                            f"&step end_time={end} /\n{groups}")
        return [geometry, analysis]

    def motion(self, size):
        """t ax ay of the ground: a sine in sixty points a period."""
        amplitude, frequency = self.shake
        t = np.linspace(0, self.end, max(2, round(60 * frequency * self.end) + 1))
        a = amplitude * self.gravity * np.sin(2 * np.pi * frequency * t)
        return [float(x) for row in zip(t * size.time, a, 0 * t) for x in row]

    def moving(self):
        """Numbers from 0 of the blocks that are not fixed."""
        return [i for i, block in enumerate(self.blocks) if not block.fixed]

    def meet(self, r):
        """Takes from results what only they know."""


@dataclasses.dataclass
class Written(Scene):
    """A scene of `tools/bench`, which writes itself, in its own size; all its blocks count as moving ones of one density."""

    made: object = None
    convex: bool = False

    def write(self, folder, name, size, step):
        (folder / name).mkdir(exist_ok=True)
        return self.made.write(folder / name, step)

    def meet(self, r):
        self.blocks = [Block(None, self.made.weight / self.gravity)] * r.n_blocks


# What a scene is to do. Lengths are those of a block of edge 1.


def travel(r, size, scene):
    """How far the middles of the blocks went from the start to the end (b)."""
    return np.linalg.norm(r.bodies.centroid[-1] - r.bodies.centroid[0], axis=1)[scene.moving()] / size.edge


def stands(most=1e-2):
    """No block goes farther than `most`."""
    def answer(r, size, scene):
        farthest = travel(r, size, scene).max()
        return "" if farthest <= most else f"moved {farthest:.1e}, should stand to {most:g}"
    return answer


def falls(least=0.05):
    """Some block goes at least so far."""
    def answer(r, size, scene):
        farthest = travel(r, size, scene).max()
        return "" if farthest >= least else f"moved {farthest:.1e}, should fall"
    return answer


def goes(distance, tolerance):
    """The last block goes a distance that is known, to a share of it."""
    def answer(r, size, scene):
        found = travel(r, size, scene)[-1]
        return "" if abs(found - distance) <= tolerance * distance else f"went {found:.6g}, should go {distance:.6g}"
    return answer


def stays_above(height):
    """Nothing that moves falls below a height."""
    def answer(r, size, scene):
        lowest = r.bodies.centroid[..., scene.moving(), 1].min() / size.edge
        return "" if lowest >= height else f"fell to {lowest:.3g}, below {height:g}"
    return answer
