"""The model: its words are those of `rock` and `holding`; here it becomes decks, and is read from them."""
from __future__ import annotations

import copy
import numbers
import pathlib
import re
import shutil
import tempfile
import typing
from collections.abc import Mapping

from ..errors import ModelError
from ..program import Look, StrPath, call, done_or_failed, run
from ..records import NAME_FILES
from ..results import Results
from .geometry import Blocks, Geometry, Lines, read_geometry
from .holding import Holding
from .rock import JointMaterial, Material
from .text import Numbers, Setting, groups_text, number_text, numbers_text, opening_text, quoted, with_comment
from .words import UnitSystem, number, one_of, text

GRAVITY = re.compile(r"^gravity: (\S+)$", re.M)  # in the opening comment, where it is not that of the earth
MATERIAL_NAME = re.compile(r"(joint|material)\((.+)\)(\..+)")
GROUPS_OF_PLACES = ("blocks", "bolts", "bolt_row", "bolt_ring", "support", "boundary", "water")  # that a geometry may have
MATERIAL_ROWS = ("density, unit weight, Young's modulus, Poisson's ratio", "initial stress xx yy xy at y = 0", "its increase with y",
                 "velocity x y, rotation rate")
JOINT_ROW = "friction angle, cohesion, tensile strength"


class Model(Holding):
    """A model of rock by words.

        m = scree.Model("slide")
        m.material("rock", density=2600, young=1e10)
        m.joint_material("plane", phi=30)
        m.block("base", [(0, 0), (10, 0), (10, 5)], "rock")
        ...
        m.static()
        r = m.run()

    `units` names a length, a mass and a time; gravity is 9.81 m/s^2 in these units unless it is given. Rock is either cut by joints
    (`rock`, `joint`, `joint_set`, `voronoi`) or made of finished blocks (`block`, `bricks`, `arch`). Words after `stage` are of that stage.
    Any setting of the reference is `m["group.name"] = value`. All errors in words are ModelError, and name the argument.
    """

    def __init__(self, name: str = "model", units: str = "m kg s", gravity: float | None = None, title: str = "") -> None:
        self.name, self.title = text(name, "Model(name=)"), str(title).strip("\n")
        self.units: UnitSystem | None = UnitSystem(units)  # None of a deck that does not say
        self.gravity: float | None = self.units.gravity if gravity is None else number(gravity, "Model(gravity=)", least=0)
        self.geometry: Lines | Blocks = Lines()
        self.materials: dict[str, Material] = {}
        self.joint_materials: dict[str, JointMaterial] = {}
        self.regions: list = []
        self.parts = [{"method.plane": Setting("strain")}]
        self.k01, self.steps, self.step_size, self.travel = 1.0, 100, 0.01, 0.05
        self.contact_stiffness, self.tables = 0.0, None
        self.folder = pathlib.Path()

    def __repr__(self) -> str:
        kind = f"{len(self.geometry.blocks)} blocks" if isinstance(self.geometry, Blocks) else (
            f"{len(self.geometry.boundary)} boundary lines, {len(self.geometry.joints)} joints")
        return f"<model {self.name}: {kind}, {len(self.parts)} {'stage' if len(self.parts) == 1 else 'stages'}>"

    def __setitem__(self, name: str, value: typing.Any) -> None:
        """Says a setting GROUP.NAME of the present stage: a text, a number or numbers."""
        if not re.fullmatch(r"[a-z]+(_[a-z]+)*\.[a-z_0-9]+", str(name)):
            raise ModelError(f"model[name]: expected GROUP.NAME, such as contact.restitution, found {name!r}")
        if isinstance(value, str):
            self.parts[-1][name] = Setting(value)
            return
        values = [value] if isinstance(value, numbers.Real) else list(value)
        self.parts[-1][name] = Setting([int(one) if isinstance(one, numbers.Integral) else number(one, f"model[{name!r}]") for one in values])

    def __getitem__(self, name: str) -> str | float | list[float]:
        """A setting as the present stage has it; KeyError where nothing has been said of it."""
        found = self.in_force(name)
        if found is None:
            raise KeyError(name)
        return found.value[0] if len(found.value) == 1 and not isinstance(found.value, str) else found.value

    def __delitem__(self, name: str) -> None:
        """Takes back what the present stage says of a setting."""
        del self.parts[-1][name]

    # Decks

    def save(self, path: StrPath) -> pathlib.Path:
        """Writes the model as an analysis deck of that name and a geometry beside it, with the files that its settings name; returns the
        path of the analysis. Names that decks have no place for stand in comments."""
        path = pathlib.Path(path)
        if path.suffix != ".ana":
            raise ModelError(f"save(path=): expected a name with .ana, found {str(path)!r}")
        if not path.parent.is_dir():
            raise ModelError(f"save(path=): expected a folder that is there, found '{path.parent}'")
        geometry = path.with_suffix(self.geometry.ending)
        texts = {geometry: self._geometry_text(), path: self._analysis_text(geometry.name)}
        for part in self.parts:
            for name in NAME_FILES:
                if name in part and part[name].value != "none":
                    self._copy(self.folder / part[name].text(), path.parent)
        for where, words in texts.items():
            where.write_text(words)
        return path

    def _copy(self, source, folder):
        """Copies a file that a setting names beside the decks."""
        target = folder / source.name
        if not source.exists():
            raise ModelError(f"save: expected the file {source} that a setting names, found none")
        if not target.exists() or not target.samefile(source):
            shutil.copy(source, target)

    def _geometry_text(self):
        geometry = self.geometry
        if not self.materials:
            raise ModelError("material: expected at least one block material, found none")
        if isinstance(geometry, Blocks):
            return geometry.text()
        if not geometry.boundary + geometry.joints:
            raise ModelError("rock: expected rock or blocks, found neither")
        kept, geometry.material_lines = geometry.material_lines, self.material_lines()
        try:
            return geometry.text()
        finally:
            geometry.material_lines = kept

    def _analysis_text(self, geometry):
        gravity = [] if self.gravity is None or (self.units and self.gravity == self.units.gravity) else [f"gravity: {number_text(self.gravity)}"]
        lines = [*opening_text("\n".join([*([self.title] if self.title else []), *gravity])),
                 with_comment(number_text(self.k01), "share of the velocity that a step passes on: 0 static, 1 dynamic"),
                 with_comment(number_text(self.steps), "steps, at most"),
                 with_comment(f"{len(self.materials)} {len(self.joint_materials)}", "block and joint materials"),
                 with_comment(number_text(self.travel), "largest displacement of a step, with rules of Shi alone"),
                 with_comment(number_text(self.step_size), "step size")]
        if self._in_shi_order():
            lines.append(with_comment(number_text(self.contact_stiffness), "contact stiffness; 0: the program chooses"))
            lines += [with_comment(str(len(table)), "times of the table of a point") for table in self.tables or []]
            lines += [with_comment(numbers_text(row), "") for table in self.tables or [] for row in table]
        for name, one in self.materials.items():
            rows = ((one.density, one.unit_weight, one.young, one.poisson), one.stress, one.stress_increase, one.velocity)
            first = quoted(name if name != str(_place(self.materials, name)) else "", f": {MATERIAL_ROWS[0]}")
            lines += [with_comment(numbers_text(row), words) for row, words in zip(rows, (first, *MATERIAL_ROWS[1:]))]
        for name, joint in self.joint_materials.items():
            lines.append(with_comment(numbers_text((joint.phi, joint.cohesion, joint.tensile_strength)),
                                      quoted(name if name != str(_place(self.joint_materials, name)) else "", f": {JOINT_ROW}")))
        first, *stages = self._parts_to_write(geometry)
        groups = [groups_text(first), *(groups_text(part) for part in stages)]
        return "\n".join(lines) + "\n\n" + "\n\n".join(groups) + "\n"

    def _in_shi_order(self):
        return self.contact_stiffness != 0 or self.tables is not None

    def _parts_to_write(self, geometry):
        """Settings of all parts, with the geometry, the order of the numbers and files beside the deck."""
        deck = {"deck.geometry": Setting(geometry)} | ({"deck.dialect": Setting("shi")} if self._in_shi_order() else {})
        deck |= {name: Setting(unit) for name, unit in self.units.settings.items()} if self.units else {}
        for k, part in enumerate(self.parts):
            part = {name: Setting(pathlib.Path(one.value).name) if name in NAME_FILES and one.value != "none" else one
                    for name, one in part.items()}
            yield {**deck, **{name: one for name, one in part.items() if name not in deck}} if k == 0 else (
                part if any(name.startswith("stage.") for name in part) else {"stage.name": Setting(f"stage {k + 1}")} | part)

    @classmethod
    def read(cls, path: StrPath, geometry: StrPath | None = None) -> Model:
        """The model of an analysis deck, and of the geometry that it names, unless one is given. Names are those in comments; what
        has none has its number. ModelError where the decks are none."""
        path = pathlib.Path(path)
        deck = Numbers(_text_of(path, "an analysis deck"), str(path))
        named = deck.parts[0].get("deck.geometry")
        where = path.with_suffix(".geo") if geometry is None else pathlib.Path(geometry)
        if geometry is None and named is not None:
            where = path.parent / named.text()
        elif not where.exists() and geometry is None:
            raise ModelError(f"{path}: expected &deck geometry=, read(geometry=), or a geometry of its name beside it, found none")
        model = cls.of_decks(path.stem, deck, *read_geometry(_text_of(where, "a geometry"), str(where)))
        model.folder = path.parent
        return model

    @classmethod
    def of_decks(cls, name: str, deck: Numbers, geometry: Lines | Blocks, geometry_deck: Numbers) -> Model:
        """The model of an analysis deck and a geometry that have been read."""
        model = cls(name)
        model.geometry, model.parts, model.units = geometry, deck.parts, None
        model.parts[0].pop("deck.geometry", None)
        model._read_numbers(deck)
        for one, setting in geometry_deck.parts[0].items():
            if one.partition(".")[0] not in GROUPS_OF_PLACES:
                raise ModelError(f"{geometry_deck.source}: expected groups of places ({', '.join(GROUPS_OF_PLACES)}), found "
                                 f"&{one.partition('.')[0]}")
            model.parts[0].setdefault(one, setting)
        model.units = UnitSystem.of_settings(model.named_units())
        for one in model.units.settings if model.units else ():
            del model.parts[0][one]
        found = GRAVITY.search(deck.title)
        model.title = GRAVITY.sub("", deck.title).strip("\n")
        model.gravity = float(found[1]) if found else model.units.gravity if model.units else None
        return model

    def named_units(self) -> dict[str, str]:
        """Names of units by GROUP.NAME, those of &units."""
        said = {name: setting.text() for name, setting in self.parts[0].items() if name.startswith("units.")}
        return self.units.settings if self.units else said

    def until(self, stage: int) -> Model:
        """The model with the stages up to one, from 0, as its own; geometry and materials are shared."""
        model = copy.copy(self)
        model.parts = self.parts[:stage + 1]
        return model

    def _read_numbers(self, deck):
        """Takes the numbers of an analysis deck, in the short order or that of Shi."""
        dialect = self.parts[0].pop("deck.dialect", Setting("auto")).value
        self.k01, self.steps = deck.number(), deck.number()
        n_blocks, n_joints = deck.count(), deck.count()
        self.travel, self.step_size = deck.number(), deck.number()
        beyond = deck.left() - 13 * n_blocks - 3 * n_joints
        if dialect == "shi" or (dialect == "auto" and beyond > 0):
            self.contact_stiffness, self.tables = deck.number(), _tables([deck.number() for _ in range(beyond - 1)], deck.source)
        for i in range(n_blocks):
            (first, name), *others = (deck.row(width) for width in (4, 3, 3, 3))
            self.materials[name or str(i + 1)] = Material(*first, *(tuple(row) for row, _ in others))
        for i in range(n_joints):
            row, name = deck.row(3)
            self.joint_materials[name or str(i + 1)] = JointMaterial(*row)
        deck.end()
        if (len(self.materials), len(self.joint_materials)) != (n_blocks, n_joints):
            raise ModelError(f"{deck.source}: expected each name of a material once, found one twice")

    # The program

    def check(self) -> str:
        """What `scree check` says of the model: what is in it, and warnings. RunFailed where the program refuses it."""
        with tempfile.TemporaryDirectory() as folder:
            deck = self.save(pathlib.Path(folder, f"{self.name}.ana"))
            done = done_or_failed(call("check", deck.name, cwd=folder))
        return (done.stdout + done.stderr).strip()

    def run(self, output: StrPath | None = None, set: Mapping[str, typing.Any] | None = None, each: Look | None = None,
            **options: typing.Any) -> Results:
        """Writes the decks, runs them and returns the results, as `scree.run` does with the same options. `output` is the results file,
        by default that of the name of the model here; the decks stand beside it. `set`, and what `each` returns, has values by name,
        such as {"joint(bedding).phi": 30}."""
        output = pathlib.Path(output or f"{self.name}.h5")

        def look(results: Results) -> Mapping[str, typing.Any] | bool | None:
            said = each(results) if each else None
            return self._with_numbers(said) if isinstance(said, Mapping) else said

        return run(self.save(output.with_suffix(".ana")), output=output, set=self._with_numbers(set or {}), each=look if each else None,
                   **options)

    def _with_numbers(self, values: Mapping[str, typing.Any]) -> dict[str, typing.Any]:
        """Values by name, with numbers of materials in place of their names."""
        return {self.numbered(name): value for name, value in values.items()}

    def numbered(self, name: str) -> str:
        """A name for `--set` with numbers of materials in place of their names, as joint(1).phi of joint(bedding).phi."""
        found = MATERIAL_NAME.fullmatch(name)
        if not found or found[2].isdigit():
            return name
        names: dict[str, Mapping[str, typing.Any]] = {"joint": self.joint_materials, "material": self.materials}
        there = names[found[1]]
        return f"{found[1]}({_place(there, one_of(found[2], there, name))}){found[3]}"

    def plot(self, **options: typing.Any) -> typing.Any:
        """A picture of the model as set up: axes of matplotlib. Options are those of `scree.plot`."""
        from ..verbs import plot
        return plot(self, **options)


def _place(names: typing.Iterable[str], name: str) -> int:
    return list(names).index(name) + 1


def _text_of(path: pathlib.Path, what: str) -> str:
    """The text of a deck; ModelError where it cannot be read."""
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as problem:
        raise ModelError(f"{path}: expected {what}, found: {getattr(problem, 'strerror', None) or 'bytes that are no text'}") from None


def _tables(given: list[float], source: str) -> list[list[tuple[float, ...]]]:
    """The tables of fixed points and load points in Shi's order: first how many times each has, then their rows of three."""
    total = 0
    for n in range(len(given) + 1):
        if n + 3 * total == len(given):
            counts, rows = [int(count) for count in given[:n]], iter(zip(*[iter(given[n:])] * 3))
            return [[next(rows) for _ in range(count)] for count in counts]
        total += int(given[n]) if n < len(given) else 0
    raise ModelError(f"{source}: expected tables of points whose counts fit their numbers, found others")
