"""Specimens of bonded grains between platens, as models: what a test of rock loads, and how far."""
from __future__ import annotations

import dataclasses
import math
import typing

from ..errors import ScreeError
from ..model import Model, arc
from ..model.geometry import Place

TESTS = ("ucs", "biaxial", "brazilian", "shear", "bending")
SIDES = 64                # of the polygon of a disc
LIGHT = 0.01              # density of platens over that of the rock, so that their inertia bears little
OVERHANG = 0.05           # of a platen over the specimen, over its width
PLATEN, WALL = 0.1, 0.02  # thickness of a platen and gap between the two boxes of a shear test, over the width of the specimen
SPAN, NOTCH = 0.8, (0.2, 0.02)  # of a beam: distance of its supports over its length, depth and width of its notch over its height
SLOW = 4.5                # step, over the time of a wave through the specimen: inertia bears 1/(2 SLOW^2) of what a step adds to the load
MOST = 4.0                # strain of a test by default, over that at which bonds begin to fail
FALLEN, FALLEN_UNDER_PRESSURE = 0.7, 0.5  # stress over its peak at which a test ends
COARSE, UNTIL = 4, 0.4    # steps of the elastic part over those of the rest, up to this part of the strain at which bonds fail


@dataclasses.dataclass
class Rock:
    """Numbers of a rock and of the bonds between its grains, in kg, m and s. Stiffnesses of bonds are in Pa/m; 0 leaves them to the program.
    `minerals` has shares by name; all have the same numbers in a specimen of the laboratory."""

    density: float = 2600.0
    young: float = 50e9
    poisson: float = 0.25
    phi: float = 30.0
    cohesion: float = 20e6
    tension: float = 5e6
    kn: float = 0.0
    ks: float = 0.0
    residual: float | None = None  # friction angle of broken bonds; None: phi


@dataclasses.dataclass
class Specimen:
    """What a test is made with: `kind` is one of TESTS, `width` (m) is that of a rectangle, the diameter of a disc, the length of a
    shear box, or a quarter of the length of a beam. `pressure` (Pa) confines, or presses on the shear box. `strain` is the largest, over the
    height of the specimen; it is reached in `steps` even steps, and steps are longer before bonds may fail. The test ends where the stress has
    fallen to `past_peak` of its largest; None leaves that to `fallen`."""

    kind: str = "ucs"
    grains: int = 400
    width: float = 0.05
    rock: Rock = dataclasses.field(default_factory=Rock)
    shape: str = "voronoi"
    grading: float = 0.0
    relax: int = 1
    least: float = 0.2
    pressure: float = 0.0
    platen_phi: float = 5.0
    strain: float | None = None
    steps: int = 240
    past_peak: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in TESTS:
            raise ScreeError(f"test: expected one of {', '.join(TESTS)}, found {self.kind!r}")
        for name in ("width", "grains", "steps"):
            if not getattr(self, name) > 0:
                raise ScreeError(f"{name}: expected a number above 0, found {getattr(self, name)!r}")
        if self.kind in ("biaxial", "shear") and not self.pressure >= 0:
            raise ScreeError(f"pressure: expected a number from 0, found {self.pressure!r}")

    @property
    def outline(self) -> list[Place]:
        """Corners of the specimen."""
        w, h = self.width, self.height
        if self.kind == "brazilian":  # a polygon with level sides at its foot and its top
            return [(x, y + h / 2) for x, y in disc(w)]
        if self.kind == "bending":
            deep, wide = (share * h for share in NOTCH)
            return [(-2 * w, 0), (-wide / 2, 0), (-wide / 2, deep), (wide / 2, deep), (wide / 2, 0), (2 * w, 0), (2 * w, h), (-2 * w, h)]
        return [(-w / 2, 0), (w / 2, 0), (w / 2, h), (-w / 2, h)]

    @property
    def height(self) -> float:
        """Along the load; of a shear box across it."""
        if self.kind == "brazilian":
            return 2 * max(y for _, y in disc(self.width))
        return {"ucs": 2, "biaxial": 2, "shear": 1, "bending": 1}[self.kind] * self.width

    @property
    def area(self) -> float:
        """Over which the force of the moving platen counts as a stress: of a specimen as thick as 1 m."""
        w, h = self.width, self.height
        if self.kind == "brazilian":  # the tension in the middle of an elastic disc, Hondros 1959
            return math.pi * w / 2
        if self.kind == "bending":  # of a beam above the notch, 6 M/h^2 of P S/4
            return (h * (1 - NOTCH[0])) ** 2 / (1.5 * SPAN * 4 * w)
        return w

    @property
    def failing(self) -> float:
        """Strain about at which bonds begin to fail: by Mohr and Coulomb, or by the tensile strength in a disc and a beam."""
        rock, sine = self.rock, math.sin(math.radians(self.rock.phi))
        if self.kind in ("ucs", "biaxial"):
            cosine = math.cos(math.radians(rock.phi))
            return (2 * rock.cohesion * cosine + self.pressure * (1 + sine)) / (1 - sine) / rock.young
        if self.kind == "shear":
            return (rock.cohesion + self.pressure * math.tan(math.radians(rock.phi))) / rock.young
        if self.kind == "brazilian":
            return 2.4 * rock.tension / rock.young
        return rock.tension / rock.young * (SPAN * 4) ** 2 / 6  # deflection of a beam over its height

    @property
    def fallen(self) -> float:
        """Stress over its peak at which the test ends. Without a pressure the result of a test is its peak; with one it is what stays, too."""
        if self.past_peak is not None:
            return self.past_peak
        return FALLEN_UNDER_PRESSURE if self.pressure > 0 else FALLEN

    @property
    def platens(self) -> int:
        """How many blocks are platens; they follow the grains."""
        return {"shear": 6, "bending": 3}.get(self.kind, 2)

    @property
    def step(self) -> float:
        """Size of a step."""
        return SLOW * max(self.width, self.height) / math.sqrt(self.rock.young / self.rock.density)

    def way(self) -> list[tuple[float, float]]:
        """Times and displacements of the moving platen: long steps before bonds may fail, then even ones."""
        fine = (self.strain or MOST * self.failing) * self.height / self.steps
        coarse = int(min(UNTIL * self.failing * self.height, self.steps * fine) / (COARSE * fine))
        left = self.steps - COARSE * coarse
        return [(0.0, 0.0), *([(coarse * self.step, coarse * COARSE * fine)] if coarse else []),
                *([((coarse + left) * self.step, self.steps * fine)] if left else [])]

    def model(self, seed: int) -> Model:
        """The model of one specimen."""
        rock, w, h = self.rock, self.width, self.height
        m = Model(f"{self.kind}-{seed}", title=f"{self.kind} test of {self.grains} bonded grains, seed {seed}.")
        m.material("rock", density=rock.density, young=rock.young, poisson=rock.poisson, unit_weight=0)
        laws = {"kn": rock.kn, "ks": rock.ks or 0.4 * rock.kn} if rock.kn else {}
        m.material("platen", density=LIGHT * rock.density, young=rock.young, poisson=rock.poisson, unit_weight=0)
        m.joint_material("bond", phi=rock.phi, cohesion=rock.cohesion, tensile_strength=rock.tension, **laws)
        m.joint_material("platen", phi=self.platen_phi, **laws)
        size = math.sqrt(abs(sum(x1 * y2 - x2 * y1 for (x1, y1), (x2, y2) in zip(self.outline, self.outline[1:] + self.outline[:1]))) / 2 / self.grains)
        m.grains("rock", self.outline, size, {"rock": 1.0}, joint="bond", kind=self.shape, grading=self.grading, relax=self.relax, least=self.least, seed=seed)
        way = self.way()
        self._platens(m, OVERHANG * w, PLATEN * w, lambda x, y: [(time, x * go + 0.0, y * go + 0.0) for time, go in way])
        for k in range(5):  # pairs of points across the middle half and along the middle half: strain gauges
            share = 0.25 + 0.125 * k
            m.measure(f"left {k}", (-0.4 * w, share * h))
            m.measure(f"right {k}", (0.4 * w, share * h))
            m.measure(f"low {k}", ((share - 0.5) * w, 0.25 * h))
            m.measure(f"high {k}", ((share - 0.5) * w, 0.75 * h))
        m.static(balance=None, steps=round(way[-1][0] / self.step), size=self.step)
        m["step.past_peak"] = self.fallen
        m["output.every"] = max(1, self.steps // 20)
        return m

    def _platens(self, m: Model, o: float, thick: float, moved: typing.Callable) -> None:
        """Platens, what holds and moves them, and pressures."""
        w, h = self.width, self.height

        def box(name, x1, y1, x2, y2):
            m.block(name, [(x1, y1), (x2, y1), (x2, y2), (x1, y2)], "platen", joint="platen")

        if self.kind == "bending":
            for name, x, y in (("left support", -SPAN * 2 * w, -thick), ("right support", SPAN * 2 * w, -thick), ("ram", 0, h)):
                box(name, x - thick, y, x + thick, y + thick)
            m.fix("left support", block="left support")
            m.fix("right support", block="right support")
            m.fix("ram", block="ram", move=moved(0, -1))
        elif self.kind == "shear":
            gap = WALL * w
            for name, x1, x2, y1, y2 in (("lower", -w / 2, w / 2, -thick, 0), ("lower", -w / 2 - thick, -w / 2, 0, h / 2 - gap),
                                         ("lower", w / 2, w / 2 + thick, 0, h / 2 - gap), ("upper", -w / 2 - thick, -w / 2, h / 2 + gap, h - gap),
                                         ("upper", w / 2, w / 2 + thick, h / 2 + gap, h - gap), ("cap", -w / 2, w / 2, h, h + thick)):
                box(name, x1, y1, x2, y2)
            m.fix("lower", block="lower")
            m.fix("upper", block="upper", move=moved(1, 0))
            m.load("normal", [(-w / 2, h + thick), (w / 2, h + thick)], pressure=self.pressure)
        else:
            half = 0.2 * w if self.kind == "brazilian" else w / 2 + o
            box("lower", -half, -thick, half, 0)
            box("upper", -half, h, half, h + thick)
            m.fix("lower", block="lower")
            m.fix("upper", block="upper", move=moved(0, -1))
            if self.kind == "biaxial" and self.pressure > 0:
                for x in (-w / 2, w / 2):
                    m.load("confinement", [(x, 0), (x, h)], pressure=self.pressure)


def disc(diameter: float) -> list[Place]:
    """Corners of a disc about the origin, with level sides at its foot and its top."""
    return arc((0, 0), diameter / 2, 180 / SIDES, 360 + 180 / SIDES, SIDES)
