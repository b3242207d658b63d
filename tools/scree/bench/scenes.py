"""Scenes of many blocks, in sizes, for what a step of contact costs; units kg, m, s, N.

A scene of boxes on a fixed base (wall, column, pyramid) is known to other programs too (`peers`); those of rock are decks.
"""
import dataclasses
import math

from .. import touching
from ..block_files import box, on_base, running_bond, turned
from ..errors import ScreeError
from ..program import call, done_or_failed, shipped

DENSITY, GRAVITY, YOUNG, POISSON = 2500.0, 9.81, 1e10, 0.25


@dataclasses.dataclass
class Scene:
    """A scene that writes its decks.

    `series` and `size` tell which rows are of one kind and grow; `edge` is the length of its blocks, `end` the time it is to run,
    `weight` the unit weight of the blocks of the material `moving`, which overlaps and energies are of.
    """

    name: str
    series: str
    size: float
    edge: float
    end: float
    weight: float = DENSITY * GRAVITY
    moving: int = 1

    def write(self, folder, step):
        """Writes the decks for steps of so many seconds and returns them, the analysis last."""
        raise NotImplementedError

    def steps(self, step):
        """How many steps are asked for."""
        return max(1, round(self.end / step))


@dataclasses.dataclass
class Boxes(Scene):
    """Boxes on a fixed base, the first of `corners`, with Coulomb's friction `mu` and no cohesion."""

    corners: list = None
    mu: float = 0.6
    moving: int = 2

    def write(self, folder, step):
        blocks, deck = folder / f"{self.name}.blk", folder / f"{self.name}.ana"
        blocks.write_text(on_base(self.name, self.corners))
        at_rest = "0 0 0 0 0 0 0 0 0"
        deck.write_text(f"1 {self.steps(step)} 2 1 0.05 {step!r}\n{DENSITY} 0 {YOUNG} {POISSON} {at_rest}\n"
                        f"{DENSITY} {self.weight} {YOUNG} {POISSON} {at_rest}\n{math.degrees(math.atan(self.mu))!r} 0 0\n"
                        "&deck dialect='short' /\n")
        return [blocks, deck]


def wall(courses, edge=1.0, end=1.0):
    """The wall of the validation case m9, in equilibrium from the start: nothing moves."""
    return Boxes(f"wall{courses}", "wall", courses, edge, end, corners=[edge * corners for corners in running_bond(courses)])


def column(blocks, edge=0.05, end=1.0):
    """A column four times as high as wide, put up on a base turned by 25 degrees, steeper than its friction: it collapses."""
    wide = math.isqrt(blocks // 4)
    if wide < 1 or 4 * wide**2 != blocks:
        raise ScreeError(f"expected a column of four times a square, as 4, 16, 36, 64, 100 or 400 blocks, found {blocks}")
    base = box(-40 * wide, 40 * wide, -8 * wide, 0)
    left = -wide / 2
    corners = [base, *(box(left + i, left + i + 1, k, k + 1) for i in range(wide) for k in range(4 * wide))]
    return Boxes(f"column{blocks}", "column", blocks, edge, end, mu=0.3,
                 corners=[edge * turned(block, -math.radians(25)) for block in corners])


def pyramid(blocks, edge=0.005, end=1.0):
    """A pyramid with so many blocks in its lowest course, each course half a block in: nothing moves."""
    corners = [box(-100 * blocks, 100 * blocks, -40 * blocks, 0)]
    for course in range(blocks):
        left = (course - blocks) / 2
        corners += [box(left + k, left + k + 1, course, course + 1) for k in range(blocks - course)]
    return Boxes(f"pyramid{blocks}", "pyramid", blocks, edge, end, corners=[edge * block for block in corners])


@dataclasses.dataclass
class Rock(Scene):
    """Rock cut at random under sudden gravity (`touching.jointed_rock`)."""

    kind: str = "dda"
    seed: int = 0

    def write(self, folder, step):
        return [touching.jointed_rock(folder, self.kind, self.seed, self.steps(step), step)]


def rock(kind, seed, end=0.1):
    return Rock(f"{kind}, seed {seed}", kind, seed, touching.ROCK_SIZE / 10, end, touching.ROCK_DENSITY * touching.G,
                kind=kind, seed=seed)


@dataclasses.dataclass
class Slope(Scene):
    """A slope of `scree joints`, with its weight put on at once, dynamic or static."""

    deck: str = "big"
    static: bool = False
    friction = {"g4": [35], "reg": [35, 32, 32], "big": [40]}  # of each joint material, degrees

    def write(self, folder, step):
        analysis = folder / f"{self.deck}.ana"
        joints = "".join(f"{angle} 0 0\n" for angle in self.friction[self.deck])
        analysis.write_text(f"{0 if self.static else 1} {self.steps(step)} 1 {len(self.friction[self.deck])} 0.01 {step!r}\n"
                            f"2600 {self.weight} 1e10 0.25 0 0 0 0 0 0 0 0 0\n{joints}"
                            "&deck dialect='short' /\n&method strain='green', plane='strain' /\n")
        return [shipped(f"bench/slope/{self.deck}.geo"), analysis]


def slope(deck, static, end=0.5):
    edge = {"g4": 4.0, "reg": 8.0, "big": 1.2}[deck]  # spacing of its joints
    motion = "static" if static else "dynamic"
    return Slope(f"{deck}, {motion}", motion, 0, edge, end, 25506.0, deck=deck, static=static)


@dataclasses.dataclass
class Tunnel(Scene):
    """A tunnel in rock with joints of 0, 60 and -60 degrees, drawn by `scree joints`, that gets its weight at once: static, until
    it is in equilibrium or some of it moves."""

    def write(self, folder, step):
        joints, geometry, analysis = (folder / f"{self.name}{end}" for end in (".joints", ".geo", ".ana"))
        sets = "".join(f"&joint_set dip={dip}, spacing={self.size!r}, length=200, bridge=0, randomness=0, material={material} /\n"
                       for material, dip in enumerate((0, 60, -60), 2))
        joints.write_text("&window x=-20 20 20 -20, y=-15 -15 20 20 /\n&tunnel centre=0.3 0.2, radius=3.1, sides=24 /\n"
                          f"{sets}&seed value=1 /\n&deck least_area=0.02 /\n&support x=-20 20, y=-15 -15, hold='both' /\n"
                          "&support x=-20 -20, y=-15 20, hold='normal' /\n&support x=20 20, y=-15 20, hold='normal' /\n")
        done_or_failed(call("joints", joints, "-o", geometry))
        analysis.write_text(f"0 {self.steps(step)} 1 4 0.05 {step!r}\n2600 {self.weight} 2e10 0.25 0 0 0 0 0 0 0 0 0\n"
                            "30 0 0\n35 0 0\n35 0 0\n35 0 0\n"
                            "&deck dialect='short' /\n&method plane='strain' /\n&step balance=1e-3 /\n")
        return [geometry, analysis]


def tunnel(spacing):
    return Tunnel(f"tunnel{spacing:g}", "tunnel", spacing, spacing, 1.0, 25506.0)
