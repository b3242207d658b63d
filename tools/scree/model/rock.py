"""The words of a model for materials and geometry."""
from __future__ import annotations

import dataclasses
import numbers
import pathlib
import tempfile
import typing
from collections.abc import Mapping, Sequence

from ..errors import ModelError
from ..program import call, done_or_failed
from .geometry import Block, Blocks, Lines, Place, Row, area_of, clipped, contains, tidied
from .shapes import brick_courses, stones_of_arch, voronoi_lines
from .text import Numbers, Part, Setting, number_text, numbers_text
from .words import Point, Points, UnitSystem, number, one_of, place, places, text, vector, whole

JOINT_LAWS = ("kn", "ks", "energy", "shear_energy", "residual_phi", "residual_slip", "residual_c", "jrc", "jcs", "closure", "dilation", "dilation_slip")
if typing.TYPE_CHECKING:
    from .grains import Grains

HELD_CORNERS = 0.01  # from the corner of a block to its middle, where the fixed points of a fixed block lie


@dataclasses.dataclass
class Material:
    """A block material: the numbers of its rows in a deck."""

    density: float
    unit_weight: float
    young: float
    poisson: float
    stress: tuple[float, ...] = (0.0, 0.0, 0.0)
    stress_increase: tuple[float, ...] = (0.0, 0.0, 0.0)
    velocity: tuple[float, ...] = (0.0, 0.0, 0.0)


@dataclasses.dataclass
class JointMaterial:
    """A joint material: the numbers of its row in a deck."""

    phi: float
    cohesion: float
    tensile_strength: float


class Rock:
    """Materials and geometry of a model."""

    geometry: Lines | Blocks
    units: UnitSystem | None
    gravity: float | None
    regions: list[tuple[list[Place], int]]
    parts: list[Part]
    materials: dict[str, Material]
    joint_materials: dict[str, JointMaterial]
    tables: list[list[tuple[float, ...]]] | None

    def material(self, name: str, density: float | None = None, young: float | None = None, poisson: float | None = None,
                 unit_weight: float | None = None, velocity: Point | None = None) -> None:
        """A block material. Its unit weight is density times gravity, unless it is given; 0 for what is held.

        With the name of a material that is there, its numbers change: in a stage from that stage on (`young`, `poisson` and
        `unit_weight` alone).
        """
        self._changes("material", name, self.materials, density=density, velocity=velocity)
        there = self.materials.get(text(name, "material(name=)"))
        if there is None and (density is None or young is None):
            raise ModelError(f"material(density=, young=): expected both numbers for the new material '{name}', found "
                             f"{density!r} and {young!r}")
        given: dict[str, typing.Any] = {"young": young if young is None else number(young, "material(young=)", above=0),
                                       "poisson": poisson if poisson is None else number(poisson, "material(poisson=)", least=-0.9999, most=0.4999),
                                       "unit_weight": unit_weight if unit_weight is None else number(unit_weight, "material(unit_weight=)")}
        if len(self.parts) > 1:
            self._change_in_stage("materials", self.materials, name, given)
            return
        if density is not None:
            number(density, "material(density=)", least=0)
            if unit_weight is None and self.gravity is None:
                raise ModelError("material(unit_weight=): expected a number, as the deck of the model does not say its gravity")
            given |= {"density": float(density), "unit_weight": density * (self.gravity or 0.0) if unit_weight is None else float(unit_weight)}
        if velocity is not None:
            given["velocity"] = vector(velocity, "material(velocity=)", 3)
        if there is None and given["poisson"] is None:
            given["poisson"] = 0.25
        given = {key: value for key, value in given.items() if value is not None}
        self.materials[name] = dataclasses.replace(there, **given) if there else Material(**given)

    def joint_material(self, name: str, phi: float | None = None, cohesion: float | None = None,
                       tensile_strength: float | None = None, **laws: float) -> None:
        """A joint material: friction angle in degrees, cohesion and tensile strength, and numbers of `&joints`, such as kn and ks.

        With the name of a joint material that is there, its numbers change, in a stage from that stage on.
        """
        self._changes("joint_material", name, self.joint_materials)
        there = self.joint_materials.get(text(name, "joint_material(name=)"))
        given: dict[str, typing.Any] = {"phi": phi if phi is None else number(phi, "joint_material(phi=)", least=0, most=89.9),
                                       "cohesion": cohesion if cohesion is None else number(cohesion, "joint_material(cohesion=)", least=0),
                                       "tensile_strength": tensile_strength if tensile_strength is None else
                                       number(tensile_strength, "joint_material(tensile_strength=)", least=0)}
        for law, value in laws.items():
            one_of(law, JOINT_LAWS, "joint_material(**laws)")
            number(value, f"joint_material({law}=)", least=0)
        if len(self.parts) > 1:
            self._change_in_stage("joints", self.joint_materials, name, given | laws)
            return
        given = {key: value for key, value in given.items() if value is not None}
        self.joint_materials[name] = (dataclasses.replace(there, **given) if there else
                                      JointMaterial(**({"phi": 0.0, "cohesion": 0.0, "tensile_strength": 0.0} | given)))
        self._change_in_stage("joints", self.joint_materials, name, laws)

    def _changes(self, word, name, there, **fixed):
        """ModelError where a stage would make a material, or change what no stage changes."""
        if len(self.parts) == 1:
            return
        one_of(name, there, f"{word}(name=) in a stage")
        if given := [key for key, value in fixed.items() if value is not None]:
            raise ModelError(f"{word}({given[0]}=): expected it before the first stage, as no stage changes it")

    def _change_in_stage(self, group, materials, name, given):
        """Sets numbers of one material in lists that have one number for each material."""
        at = list(materials).index(name)
        for key in [key for key in self.parts[-1] if key.startswith(f"{group}.")]:  # lists grow with the materials
            values = self.parts[-1][key].value
            if not isinstance(values, str):
                values += [0.0] * (len(materials) - len(values))
        for key, value in given.items():
            if value is not None:
                found = self.in_force(f"{group}.{key}")
                values = list(found.value) if found else [getattr(one, key, 0.0) for one in materials.values()]
                values += [0.0] * (len(materials) - len(values))
                values[at] = float(value)
                self.parts[-1][f"{group}.{key}"] = Setting(values)

    def in_situ(self, surface: float | Points, k0: float, unit_weight: float | None = None) -> None:
        """Stress before the run: vertical stress is the weight of the ground below the surface, which is level at a height or runs through
        points with ascending x; horizontal stress is `k0` times that.

        The weight is that of the blocks, and above them that of the highest one, unless one `unit_weight` is given for all.
        """
        self._only_first("in_situ")
        level = isinstance(surface, numbers.Real)
        line = [(0.0, number(surface, "in_situ(surface=)"))] if level else places(surface, "in_situ(surface=)", 1)
        self.parts[0] |= {"in_situ.surface": Setting([value for place in line for value in place]),
                          "in_situ.k0": Setting([number(k0, "in_situ(k0=)", least=0)])}
        if unit_weight is not None:
            self.parts[0]["in_situ.gradient"] = Setting([number(unit_weight, "in_situ(unit_weight=)", above=0)])

    # Rock that lines cut

    def rock(self, corners: Points, material: str | None = None, joint: str | None = None, name: str = "") -> None:
        """A polygon of rock, which joints cut to blocks. A model may have more than one. `joint` is the joint material of its sides, the
        first unless it is given."""
        corners = _counter_clockwise(places(corners, "rock(corners=)", 3), "rock(corners=)")
        lines = self._lines("rock")
        self._material(material, "rock(material=)")
        number = self._joint(joint or next(iter(self.joint_materials), None), "rock(joint=)")
        lines.boundary += [Row((*p, *q), number, name) for p, q in _sides(corners)]
        self.region(corners, material)

    def region(self, corners: Points, material: str | None = None) -> None:
        """Gives all blocks inside a polygon a material; a later region wins. It cuts nothing."""
        corners = _counter_clockwise(places(corners, "region(corners=)", 3), "region(corners=)")
        self._lines("region")
        number = self._material(material, "region(material=)")
        if number > 1 or self.regions:
            self.regions.append((corners, number))

    def opening(self, corners: Points, joint: str | None = None, name: str = "") -> None:
        """A polygon of air in the rock from the start, such as a tunnel; joints end at its sides. `joint` is as for `rock`."""
        corners = _counter_clockwise(places(corners, "opening(corners=)", 3), "opening(corners=)")
        lines, number = self._lines("opening"), self._joint(joint or next(iter(self.joint_materials), None), "opening(joint=)")
        lines.joints = [Row((*p, *q), row.material, row.name) for row in lines.joints
                        for p, q in clipped((row.numbers[0], row.numbers[1]), (row.numbers[2], row.numbers[3]), [corners], inside=False)]
        lines.boundary += [Row((*p, *q), number, name) for p, q in _sides(corners)]
        lines.holes.append(Row(_inside(corners), name=name))

    def joint(self, name: str, points: Points, material: str | None = None) -> None:
        """A joint from point to point, as far as it lies in the rock. The joint material is that of its name, or the only one, unless it
        is given."""
        points = places(points, "joint(points=)", 2)
        number = self._joint(material, "joint(material=)", name)
        self._add_joints(text(name, "joint(name=)"), zip(points, points[1:]), number)

    def excavation(self, name: str, corners: Points, material: str | None = None) -> None:
        """A polygon of rock that a stage excavates by its name. Its joint material holds until then, so give that strength."""
        corners = places(corners, "excavation(corners=)", 3)
        number = self._joint(material, "excavation(material=)", name)
        self._add_joints(text(name, "excavation(name=)"), _sides(corners), number)

    def joint_set(self, name: str, dip: float, spacing: float, length: float, bridge: float = 0, randomness: float = 0,
                  material: str | None = None, seed: int = 1) -> None:
        """A joint set in all rock, as `scree joints` draws it: dip in degrees counter-clockwise from x, spacing of lines, length of
        traces, bridge of rock between two traces. Randomness is from 0 to 1."""
        given = {"dip": number(dip, "joint_set(dip=)", least=-360, most=360), "spacing": number(spacing, "joint_set(spacing=)", above=0),
                 "length": number(length, "joint_set(length=)", above=0), "bridge": number(bridge, "joint_set(bridge=)", least=0),
                 "randomness": number(randomness, "joint_set(randomness=)", least=0, most=1)}
        joint = self._joint(material, "joint_set(material=)", name)
        lines, (rock, openings) = self._lines("joint_set"), self._loops()
        words = "\n".join(["&joint_set " + ", ".join(f"{key}={number_text(value)}" for key, value in given.items()) + " /",
                           f"&seed value={whole(seed, 'joint_set(seed=)', 0)} /", *(_polygon_group("tunnel", one) for one in openings)])
        if not rock:
            raise ModelError("joint_set: expected rock before it, found none")
        for corners in rock:
            with tempfile.TemporaryDirectory() as folder:
                deck, drawn = pathlib.Path(folder, "set.joints"), pathlib.Path(folder, "set.geo")
                deck.write_text(f"{_polygon_group('window', corners)}\n{words}\n")
                done_or_failed(call("joints", deck.name, "-o", drawn.name, cwd=folder))
                found = Lines.read(Numbers(drawn.read_text(), str(drawn)))
            lines.joints += [Row(row.numbers, joint, text(name, "joint_set(name=)")) for row in found.joints]

    def voronoi(self, name: str, size: float, within: Points | None = None, randomness: float = 1, material: str | None = None,
                seed: int = 1) -> None:
        """Joints around Voronoi grains of a mean size in all rock, or within a polygon. Randomness 0 makes regular hexagons."""
        rock = self._loops()[0] if within is None else [places(within, "voronoi(within=)", 3)]
        joint = self._joint(material, "voronoi(material=)", name)
        if not rock:
            raise ModelError("voronoi: expected rock before it, found none")
        lines = voronoi_lines(rock, number(size, "voronoi(size=)", above=0),
                              number(randomness, "voronoi(randomness=)", least=0, most=1), whole(seed, "voronoi(seed=)", 0))
        self._add_joints(text(name, "voronoi(name=)"), [part for p, q in lines for part in clipped(p, q, rock)], joint)

    def _add_joints(self, name, lines, number):
        """Adds the parts of lines in the rock, where rock has been drawn."""
        geometry = self._lines("joints")
        rock, openings = self._loops()
        for p, q in lines:
            inside = clipped(p, q, rock) if rock else [(p, q)]
            for part in [part for a, b in inside for part in (clipped(a, b, openings, inside=False) if openings else [(a, b)])]:
                geometry.joints.append(Row((*part[0], *part[1]), number, name))

    def _loops(self):
        """Polygons of rock and of openings, by the boundary lines that close."""
        loops, begun = [], []
        for row in self._lines("joints").boundary:
            begun.append(row.numbers[:2])
            if row.numbers[2:] == begun[0]:
                loops.append(begun)
                begun = []
        openings = []
        for hole in self.geometry.holes:
            around = sorted((one for one in loops if contains(one, *hole.numbers)), key=lambda one: abs(area_of(one)))
            openings += around[:1] if len(around) > 1 else []
        return [one for one in loops if one not in openings], openings

    # Finished blocks

    def block(self, name: str, corners: Points, material: str | None = None,
              joint: str | Sequence[str | None] | None = None) -> None:
        """A finished block. `joint` is the joint material of its sides: one name, or one for the side from each corner to the next."""
        self._only_first("block")
        if isinstance(self.geometry, Lines):
            if self.geometry.boundary or self.geometry.joints:
                raise ModelError("block: expected a model of finished blocks, found one of rock that joints cut: draw this block with "
                                 "rock(), which may be called again")
            self.geometry = Blocks(self.geometry.title)
        corners = places(corners, "block(corners=)", 3)
        joints = [joint] * len(corners) if joint is None or isinstance(joint, str) else list(joint)
        if len(joints) != len(corners):
            raise ModelError(f"block(joint=): expected one name or {len(corners)}, one for each side, found {len(joints)}")
        if area_of(corners) < 0:
            corners, joints = corners[::-1], [*joints[-2::-1], joints[-1]]
        self.geometry.blocks.append(Block(self._material(material, "block(material=)"),
                                          _counter_clockwise(corners, "block(corners=)"),
                                          [self._joint(one, "block(joint=)") for one in joints], text(name, "block(name=)")))

    def bricks(self, name: str, corner: Point, columns: int, courses: int, width: float, height: float, material: str | None = None,
               joint: str | None = None) -> None:
        """A wall of bricks in running bond from its lower left corner; every second course begins and ends with half a brick."""
        for corners in brick_courses(place(corner, "bricks(corner=)"), whole(columns, "bricks(columns=)"), whole(courses, "bricks(courses=)"),
                                     number(width, "bricks(width=)", above=0), number(height, "bricks(height=)", above=0)):
            self.block(name, corners, material, joint)

    def arch(self, name: str, centre: Point, radius: float, thickness: float, stones: int, start: float = 0, end: float = 180,
             material: str | None = None, joint: str | None = None) -> None:
        """An arch of stones from one angle to another, in degrees counter-clockwise from x; `radius` is that of its inside."""
        for corners in stones_of_arch(place(centre, "arch(centre=)"), number(radius, "arch(radius=)", above=0),
                                      number(thickness, "arch(thickness=)", above=0), whole(stones, "arch(stones=)"),
                                      number(start, "arch(start=)"), number(end, "arch(end=)", above=start)):
            self.block(name, corners, material, joint)

    def grains(self, name: str, outline: Points, size: float, minerals: Mapping[str, float] | None = None,
               joint: str | Mapping[tuple[str, str], str] | None = None, side: str | None = None, kind: str = "voronoi", grading: float = 0,
               relax: int = 10, least: float = 0.2, seed: int = 1) -> Grains:
        """Grains that fill a polygon as finished blocks; `size` is the side of a square of their mean area.

        `minerals` has shares of the area by block material. `joint` is the joint material between grains: one name, or one for each pair of
        minerals. `side` is that of the outline, the first of these unless it is given. `kind` is voronoi or trigon, `grading` the spread of
        sizes, `relax` how often points move to the middles of their cells, `least` the shortest side over the size.
        """
        if minerals is None and len(self.materials) > 1:
            raise ModelError(f"grains(minerals=): expected shares of {', '.join(self.materials)}, found none")
        for one in minerals or {}:
            self._material(one, "grains(minerals=)")
        from .grains import grains_in  # here, as scipy and shapely are not needed by other words
        found = grains_in(outline, size, kind, grading, relax, least, minerals, seed)
        left, joints, corners = found.neighbours(), {}, tidied(found.corners.tolist())
        for (a, b), i in left.items():
            if (b, a) in left:
                pair = found.minerals[i], found.minerals[left[b, a]]
                joints[a, b] = joint.get(pair, joint.get(pair[::-1])) if isinstance(joint, Mapping) else joint
                if isinstance(joint, Mapping) and joints[a, b] is None:
                    raise ModelError(f"grains(joint=): expected the joint material of {pair[0]} and {pair[1]}, found none")
        side = side or (next(iter(joint.values())) if isinstance(joint, Mapping) else joint)
        for own, mineral in zip(found.grain, found.minerals):
            self.block(name, [corners[i] for i in own], mineral or None,
                       [joints.get(pair, side) for pair in zip(own, own[1:] + own[:1])])
        return found

    # Points

    def fix(self, name: str, *points: Point, block: str | None = None, move: list[Point] | None = None) -> None:
        """Fixed points, or all corners of the blocks of a name. `move` has the displacement of the points: times with (t, x, y)."""
        self._only_first("fix")
        chosen = [place(point, "fix(points)") for point in points]
        if block is not None:
            blocks = getattr(self.geometry, "blocks", [])
            one_of(block, list(dict.fromkeys(one.name for one in blocks)), "fix(block=)")
            for own in (one.corners for one in blocks if one.name == block):
                x, y = _inside(own)
                chosen += [(a + HELD_CORNERS * (x - a), b + HELD_CORNERS * (y - b)) for a, b in own]
        if not chosen:
            raise ModelError("fix(points): expected points, or block=, found neither")
        table = [vector(row, "fix(move=)", 3) for row in move or []]
        if table:
            self._need_tables("fix(move=)")
        for x, y in tidied(chosen):
            self.geometry.fix(x, y, text(name, "fix(name=)"))
            if self.tables is not None:
                self.tables.insert(len(self.tables) - len(self.geometry.loads), table)

    def _need_tables(self, what: str) -> list[list[tuple[float, ...]]]:
        """The tables of fixed points and load points, which begin here where there are none; ModelError where their number is not known before rock is cut."""
        if self.tables is None:
            if any(row.numbers[:2] != row.numbers[2:] for row in self.geometry.fixed if isinstance(self.geometry, Lines)):
                raise ModelError(f"{what}: expected fixed points alone, found fixed lines, of which the program makes points")
            self.tables = [[] for _ in range(len(self.geometry.fixed) + len(self.geometry.loads))]
        return self.tables

    def measure(self, name: str, point: Point) -> None:
        """A measured point, whose place, velocity and stress are kept at each step."""
        self._only_first("measure")
        self.geometry.measured.append(self.geometry.place(*place(point, "measure(point=)"), text(name, "measure(name=)")))

    # Names

    def _lines(self, word: str) -> Lines:
        """The geometry of lines; ModelError where the model has finished blocks, or a stage has begun."""
        self._only_first(word)
        if isinstance(self.geometry, Blocks):
            raise ModelError(f"{word}: expected a model of rock that joints cut, found one of finished blocks: use block(), or rock() "
                             "for all polygons")
        return self.geometry

    def _only_first(self, word):
        if len(self.parts) > 1:
            raise ModelError(f"{word}: expected it before the first stage, as no stage changes the geometry or the initial stress")

    def _material(self, name, what):
        """The number of a material; that of the only one where no name is given."""
        return self._number_of(name, self.materials, what)

    def _joint(self, name, what, otherwise=""):
        """The number of a joint material; that of another name, or of the only one, where no name is given."""
        return self._number_of(otherwise if name is None and otherwise in self.joint_materials else name, self.joint_materials, what)

    @staticmethod
    def _number_of(name, there, what):
        """The number of a material, from 1, by its name; ModelError where none is given of several."""
        if name is None and len(there) > 1:
            raise ModelError(f"{what}: expected one of {', '.join(there)}, found none")
        return 1 if name is None else list(there).index(one_of(name, there, what)) + 1

    def material_lines(self) -> list[Row]:
        """The material lines of the regions: a point in each block inside one. The program cuts the rock for them."""
        lines = self.geometry
        if isinstance(lines, Blocks) or not self.regions:
            return [] if isinstance(lines, Blocks) else lines.material_lines
        with tempfile.TemporaryDirectory() as folder:
            deck, cut = pathlib.Path(folder, "rock.geo"), pathlib.Path(folder, "rock.blk")
            deck.write_text(lines.text())
            done_or_failed(call("cut", deck.name, "-o", cut.name, cwd=folder))
            blocks = Blocks.read(Numbers(cut.read_text(), str(cut))).blocks
        found = list(lines.material_lines)
        for x, y in (_inside(block.corners) for block in blocks):
            number = next((number for corners, number in reversed(self.regions) if contains(corners, x, y)), 0)
            if number:
                found.append(Row(tuple(tidied([(x, y)])[0] * 2), number))
        return found


def _sides(corners: list[Place]) -> list[tuple[Place, Place]]:
    return list(zip(corners, [*corners[1:], corners[0]]))


def _counter_clockwise(corners: list[Place], what: str) -> list[Place]:
    """Corners counter-clockwise, without the first repeated at the end; ModelError where they enclose nothing."""
    if corners[0] == corners[-1]:
        corners = corners[:-1]
    area = area_of(corners)
    if len(corners) < 3 or area == 0:  # noqa: PLR2004  a triangle
        raise ModelError(f"{what}: expected corners of a polygon, found some that enclose no area")
    return corners if area > 0 else corners[::-1]


def _inside(corners: list[Place]) -> Place:
    """A place inside a polygon, with seams or without: the middle of the widest run of a level line between two corners' heights."""
    heights = sorted({y for _, y in corners})
    best, room = corners[0], -1.0
    for low, high in zip(heights, heights[1:]):
        y = (low + high) / 2
        at = sorted(x1 + (y - y1) * (x2 - x1) / (y2 - y1) for (x1, y1), (x2, y2) in _sides(corners) if (y1 > y) != (y2 > y))
        for a, b in zip(at[::2], at[1::2]):
            if min(b - a, high - low) > room:
                best, room = ((a + b) / 2, y), min(b - a, high - low)
    return best


def _polygon_group(group: str, corners: list[Place]) -> str:
    xs, ys = zip(*corners)
    return f"&{group} x={numbers_text(xs)},\n    y={numbers_text(ys)} /"
