"""What the commands of tools/ do, as functions: pictures, films, pages, factors of safety and studies of results, models and decks."""
from __future__ import annotations

import argparse
import contextlib
import dataclasses
import os
import pathlib
import re
import tempfile
import typing
from collections.abc import Iterable, Iterator, Mapping, Sequence

from .errors import PlotError, ScreeError
from .model import Model
from .model.words import Points, places
from .program import StrPath, as_word, made_folder
from .results import Results, read
from .units import units_of_deck, units_of_settings

if typing.TYPE_CHECKING:
    import matplotlib.axes

    from .laboratories.command import Laboratory
    from .rockfalls.command import Falls

Scene = Model | StrPath


@contextlib.contextmanager
def in_words_of_python() -> Iterator[None]:
    """Errors that name an option of a command name the argument instead."""
    try:
        yield
    except ScreeError as problem:
        problem.args = (re.sub(r"--([a-z]\w*)", r"\1=", str(problem)),)
        raise


def units_of(what: Results | Scene) -> str | None:
    """Names of units for pictures, by the units that a model or the decks of a run say; None where they say none."""
    named = None
    if isinstance(what, Results):
        from .model.views import model_of
        named, what = units_of_deck(what), model_of(what)
    return named or (units_of_settings(what.named_units()) if isinstance(what, Model) else None)


def given_look(field: str | None = None, joints: str | None = None, vectors: str | None = None, crosses: bool = False,
               conditions: bool = False, points: bool = False,
               numbers: bool = False, covers: bool = False, window: Sequence[float] | None = None,
               range: Sequence[float] | str | None = None, magnify: float = 1, units: str | None = None, colours: str | None = None,
               mesh: bool = True, dpi: float = 150) -> tuple[list, typing.Any]:
    """What is drawn over frames, and how they are drawn, by the options of `tools/plot`."""
    from .drawing import JOINTS, VECTORS, draw_covers, draw_crosses, draw_numbers, draw_points, extras_of, look_of
    for name, value, choices in (("joints", joints, JOINTS), ("vectors", vectors, VECTORS)):
        if value is not None and value not in choices:
            raise PlotError(f"{name}=: expected one of {', '.join(choices)}, found {value!r}")
    drawn = ((crosses, draw_crosses), (points, draw_points), (numbers, draw_numbers), (covers, draw_covers))
    words = range if range is None else [range] if isinstance(range, str) else [repr(float(end)) for end in range]
    given = argparse.Namespace(field=field, conditions=conditions, joints=joints, vectors=vectors, extras=[draw for wanted, draw in drawn if wanted], window=window,
                               range=words, magnify=magnify, units=units, colours=colours, no_mesh=not mesh, dpi=dpi)
    return extras_of(given), look_of(given)


def plot(what: Results | Scene, field: str | None = None, frame: int | str = -1, **look: typing.Any) -> matplotlib.axes.Axes:
    """Draws a frame of results, or a model, a deck or a geometry as set up; returns axes of matplotlib.

    `field` is displacement of results and material of others unless it is given; `frame` is a number from 0, or from -1 backwards, or the
    name of a stage, whose last frame is drawn. All else are options of `tools/plot` (doc/pictures.md): joints='state', vectors='velocity',
    crosses=True, points=True, numbers=True, window=(x1, y1, x2, y2), range=(low, high), magnify=100, units='m,MPa=1e6', mesh=False.
    """
    from .drawing import FIELDS, draw_frames, open_shapes
    with tempfile.TemporaryDirectory() as folder, in_words_of_python():
        if look.get("units") is None:
            look["units"] = units_of(what)
        shapes = open_shapes(what.path if isinstance(what, Results) else deck_of(what, folder), None, folder)
        field = field or ("displacement" if len(shapes.times) > 1 else None)
        extras, how = given_look(field, **look)
        field = field or FIELDS[0]
        if field not in FIELDS:
            raise PlotError(f"field=: expected one of {', '.join(FIELDS)}, found {field!r}")
        return draw_frames([shapes], [str(frame)], field, extras, how, [frame] if isinstance(frame, str) else None).axes[0]


def film(results: Results, output: StrPath, field: str = "displacement", stage: str | None = None, every: int = 1, fps: float = 20,
         dpi: float = 120, **look: typing.Any) -> pathlib.Path:
    """Films the frames of results, or of a stage of them, each or every so many, as .mp4 or .gif; returns its path. `look` has the options
    of `plot`."""
    from .drawing import Frames, frames_of_stage
    from .filming import film as write_film
    with in_words_of_python():
        given: dict[str, typing.Any] = {"units": units_of(results), **look, "dpi": dpi}
        extras, how = given_look(field, **given)
        file = Frames(results.path, results.path.stem)
        frames = frames_of_stage(file, stage) if stage else list(range(len(file.times)))
        write_film(file, frames[::every], pathlib.Path(output), fps, dpi, field, extras, how)
    return pathlib.Path(output)


def report(results: Results, output: StrPath | None = None, units: str | None = None, title: str | None = None, project: str = "",
           note: str = "") -> pathlib.Path:
    """Writes the page of a run for a browser, as `tools/report` does; returns its path, by default that of the results with .html. The title
    is the first sentence of the opening comment of the deck unless it is given."""
    from .pages.command import write_page
    with in_words_of_python():
        return write_page(results.path, pathlib.Path(output or results.path.with_suffix(".html")), units or units_of(results), title, project,
                          note)


@dataclasses.dataclass
class FactorOfSafety:
    """A factor of safety: between the largest factor that `stands` and the smallest that `falls`; `folder` holds the runs, `area` is that of
    the blocks that move, `others` has the factors of further mechanisms."""

    stands: float
    falls: float
    folder: pathlib.Path
    path: pathlib.Path
    area: float = 0.0
    others: list[FactorOfSafety] = dataclasses.field(default_factory=list)

    @property
    def factor(self) -> float:
        """The middle between the two."""
        return 0.5 * (self.stands + self.falls)

    def __float__(self) -> float:
        return self.factor

    @property
    def mechanism(self) -> Results:
        """The results of the run that just falls."""
        return read(self.path)


def fs(what: Scene, joints: Iterable[str | int] = (), balance: float = 1e-4, within: float = 0.005, most: float = 16,
       set: Mapping[str, typing.Any] | None = None, folder: StrPath | None = None, stage: str | None = None, load: str | None = None,
       least: float = 0.0, inside: Points | None = None, mechanisms: int = 1) -> FactorOfSafety:
    """The factor of safety of a model or a deck by strength reduction, as `tools/fs` finds it. NoFactor where strength does not decide.

    `joints` are the joint materials to weaken, by name or number, all where none is given. `stage` is the stage whose strength is reduced,
    by name or number, or 'all'; the last by default. With `load` 'seismic' or 'boundary' the factor multiplies that load instead. Mechanisms
    count from an area `least` on, and more than half inside a polygon. With `mechanisms` above 1 the `others` of the factor have the next
    ones, found without the blocks of those before.
    """
    from .mechanisms import Sought
    from .safety import Reduction, find
    model = what if isinstance(what, Model) else Model.read(what)
    folder = made_folder(folder or f"{model.name}-fs")
    with in_words_of_python():
        corners = None if inside is None else places(inside, "fs(inside=)", 3)
        reduction = Reduction([deck_of(what, folder)], settings_of(model, set), joints, balance, folder, None, stage, load,
                              Sought(least, corners))
        found = find(reduction, within, most, lambda *_: None, mechanisms)
    factors = [FactorOfSafety(one.stands, one.falls, folder, one.results, one.mechanism.area if one.mechanism else 0.0) for one in found]
    return dataclasses.replace(factors[0], others=factors[1:])


def study(what: Scene, grid: Mapping[str, typing.Any] | None = None, sample: Mapping[str, typing.Any] | None = None,
          quantities: Mapping[str, Sequence] | None = None, set: Mapping[str, typing.Any] | None = None, folder: StrPath | None = None,
          jobs: int | None = None, keep: bool = False) -> list[dict[str, typing.Any]]:
    """Runs a model or a deck with many numbers, as `tools/study` does, and returns a row for each run by the names of its columns.

    `grid`, `sample` and `quantities` are those of its TOML files (doc/studies.md), such as {"joint(bedding).phi": [20, 30, 40]}. Runs
    that `folder` has from before are not made again.
    """
    from .studies.runs import Study
    from .studies.tables import checked, table_of
    model = what if isinstance(what, Model) else Model.read(what)
    names = {model.numbered(one): one for one in (*(grid or {}), *(sample or {}))}
    given = {"grid": {model.numbered(one): values for one, values in (grid or {}).items()},
             "sample": {model.numbered(one): values for one, values in (sample or {}).items()}, "set": settings_of(model, set),
             "quantities": {key: list(value) for key, value in (quantities or {}).items()}}
    folder = made_folder(folder or f"{model.name}-study").absolute()
    with in_words_of_python():
        table = checked("study(grid=, sample=)", table_of("study", given))
        runs = Study(table, [pathlib.Path(deck_of(what, folder)).absolute()], [], folder, keeps_results=keep)
        runs.run(range(len(runs.keys)), jobs or len(os.sched_getaffinity(0)))
        header = [names.get(column, column) for column in runs.header()]
        return [dict(zip(header, line)) for line in runs.lines()]


def rockfall(scene: Mapping[str, typing.Any] | StrPath, jobs: int | None = None) -> Falls:
    """Lets many rocks fall on a slope, as `tools/rockfall` does: a TOML file, or its tables as a dictionary (doc/howto/rock-fall.md)."""
    from .rockfalls.command import rockfall as let_fall
    return let_fall(scene, jobs)


def laboratory(test: str = "ucs", seeds: Sequence[int] = (1,), pressures: Sequence[float] = (0.0,), folder: StrPath | None = None,
               jobs: int | None = None, **specimen: typing.Any) -> Laboratory:
    """Tests specimens of bonded grains, as `tools/test_rock` does: one with each seed at each pressure (doc/howto/laboratory.md). `specimen`
    has arguments of a `Specimen`, such as grains=200, and `rock`."""
    from .laboratories.command import laboratory as let_test
    with in_words_of_python():
        return let_test(test, seeds, pressures, folder, jobs, **specimen)


def deck_of(what: Scene, folder: StrPath) -> pathlib.Path:
    """The deck of a model, written into a folder; another deck as it is."""
    return what.save(pathlib.Path(folder, f"{what.name}.ana")) if isinstance(what, Model) else pathlib.Path(what)


def settings_of(model: Model, set: Mapping[str, typing.Any] | None) -> list[str]:
    """Settings by name as texts."""
    return [f"{model.numbered(name)}={as_word(value)}" for name, value in (set or {}).items()]
