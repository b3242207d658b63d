"""The program: where it is, and how it is run."""
from __future__ import annotations

import contextlib
import importlib.metadata
import json
import numbers
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import typing
import urllib.parse
from collections.abc import Callable, Iterable, Iterator, Mapping

from .errors import ProgramMissing, RunFailed, ScreeError
from .results import Results, read
from .terminal import showing_progress

StrPath = str | os.PathLike
Look = Callable[[Results], Mapping[str, typing.Any] | bool | None]  # at a run as it goes

PAUSED = "paused"  # status of a run that --steps has ended

TREE = pathlib.Path(__file__).resolve().parents[2]
BUILT = TREE / "build" / "release" / "bin" / "scree"
PREFIX = (TREE / ".." / "..").resolve()  # where this is PREFIX/lib/python3/dist-packages/scree
INSTALLED = PREFIX / "bin" / "scree"


def origin() -> pathlib.Path | None:
    """The source tree that pip has installed this package from, as pip notes it; None where that is not known."""
    try:
        noted = importlib.metadata.distribution("scree").read_text("direct_url.json") or ""
        url = urllib.parse.urlsplit(json.loads(noted)["url"])
    except (importlib.metadata.PackageNotFoundError, TypeError, ValueError, KeyError):
        return None
    return pathlib.Path(urllib.parse.unquote(url.path)) if url.scheme == "file" else None


def program(path: StrPath | None = None) -> pathlib.Path:
    """The path of the program: the one given, else that of the variable SCREE, else that of the build folder, else the one that is
    installed beside this package, else the one that the shell finds, else the one built in the tree that pip took the package from."""
    places: list[StrPath | None] = [path, os.environ.get("SCREE"), *(built for built in (BUILT, INSTALLED) if built.exists()), shutil.which("scree"),
                                    *(tree / BUILT.relative_to(TREE) for tree in [origin()] if tree), BUILT]
    found = pathlib.Path(next(one for one in places if one))
    if not found.exists():
        raise ProgramMissing(f"expected the program {found}, found none: build it, or name it with --scree or the variable SCREE")
    return found.absolute()


def input_folder() -> pathlib.Path:
    """The folder input/, with the decks: that of the variable SCREE_INPUT, else that of the source tree, else of what is installed
    with this package or with the program, else of the tree that the program was built in or that pip took this package from."""
    if "SCREE_INPUT" in os.environ:
        return pathlib.Path(os.environ["SCREE_INPUT"]).absolute()
    found = [pathlib.Path(path).resolve() for path in (os.environ.get("SCREE"), shutil.which("scree")) if path]
    prefixes = [PREFIX, *(path.parents[1] for path in found if len(path.parents) > 1)]
    trees = [*(path.parents[3] for path in found if len(path.parents) > 3), *filter(None, [origin()])]
    folders = [TREE / "input", *(prefix / "share" / "scree" / "input" for prefix in prefixes), *(tree / "input" for tree in trees)]
    return next((folder for folder in folders if (folder / "validation").exists()), TREE / "input")


def shipped(name: str) -> pathlib.Path:
    """A deck or a folder of decks in input/, such as paper/rotation; ScreeError where it is not there."""
    path = input_folder() / name
    if not path.exists():
        raise ScreeError(f"{path}: expected decks of scree, found none: pip installs the commands alone; the decks are in the folder "
                         "input of the sources, and in share/scree/input of what cmake --install leaves: name that folder by the "
                         "variable SCREE_INPUT")
    return path


def call(*words: StrPath, path: StrPath | None = None, **options: typing.Any) -> subprocess.CompletedProcess[str]:
    """Runs `scree WORDS` and returns what subprocess.run does, with what it printed as text, whatever its exit status.

    `path` names another program; options are those of subprocess.run, such as cwd and timeout.
    """
    return subprocess.run([program(path), *words], capture_output=True, text=True, **options)


def done_or_failed(done: subprocess.CompletedProcess[str]) -> subprocess.CompletedProcess[str]:
    """What `call` returned, if its exit status is 0; else RunFailed."""
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
        raise RunFailed(said[-1].removeprefix("scree: "), done.returncode, done.stderr)
    return done


def version(path: StrPath | None = None) -> dict[str, str]:
    """Version, compiler and libraries of the program, by the names that they have in /scene of a results file."""
    return json.loads(done_or_failed(call("--version", "json", path=path)).stdout)


def with_settings(settings: Iterable[str]) -> list[str]:
    """Words of the command line for settings such as step.size=0.01."""
    return [word for setting in settings for word in ("--set", setting)]


def as_word(value: typing.Any) -> str:
    """A value of a setting as a deck has it: a text as it is, numbers with all their digits, a list one by one."""
    if isinstance(value, str | os.PathLike):
        return str(value)
    if isinstance(value, Iterable):
        return " ".join(map(as_word, value))
    if isinstance(value, numbers.Integral) and not isinstance(value, bool):
        return str(int(value))
    if isinstance(value, numbers.Real) and not isinstance(value, bool):
        return repr(float(value))
    raise TypeError(f"expected a text, a number or a list of these for a setting, found {value!r}")


def run(*decks: StrPath, output: StrPath | None = None, set: Mapping[str, typing.Any] | None = None, settings: Iterable[str] = (),
        words: Iterable[str] = (), path: StrPath | None = None, progress: bool = False, each: Look | None = None, every: int = 100,
        **options: typing.Any) -> Results:
    """Runs decks (an analysis; or a geometry and an analysis) and returns their Results; raises RunFailed with the program's words.

    `output` is the results file, by default beside the analysis; `set` has values by name, such as {"step.size": 0.01,
    "joint(1).phi": 30, "water.table": [0, 4, 20, 6]}; `settings` are the same as texts, "step.size=0.01"; `words` are more words of
    the command line, `path` is another program, options are those of subprocess.run.

    `progress` shows a line with the time that is left, in a notebook too. `each` is called after every so many steps with the results
    so far. It returns None or True for the run to go on, False to end it, or values by name with which it goes on: those that `--restart` may
    change (doc/running.md). Each call costs a restart: the run pauses, and goes on in a new process from its checkpoint.
    """
    output, words = pathlib.Path(output or pathlib.Path(decks[-1]).with_suffix(".h5")), list(words)
    start: list[StrPath] = ["run", *decks, "-o", output]
    if each is not None:
        if not (isinstance(every, numbers.Integral) and every > 0):
            raise ScreeError(f"run(every=): expected a whole number from 1, found {every!r}")
        words += ["--steps", str(every)]
    given = [*settings, *texts_of(set)]
    while True:
        with showing_progress(progress) as screen:
            done_or_failed(subprocess.run([program(path), *start, *with_settings(given), *words, *screen.words], stdout=screen.file,
                                          stderr=subprocess.PIPE, text=True, **options))
        results = read(pathlib.Path(options.get("cwd") or ".") / output)
        if each is None or results.scene.status != PAUSED:
            return results
        said = each(results)
        changed = said if isinstance(said, Mapping) else {}
        if said is not None and said is not changed:
            if said not in (True, False):  # also those of numpy
                raise ScreeError(f"run(each=): expected a function that returns None, False or values by name, found {said!r}")
            if not said:
                return results
        start, given = ["run", "--restart", output], texts_of(changed)


def texts_of(set: Mapping[str, typing.Any] | None) -> list[str]:
    """Values by name as texts, such as step.size=0.01."""
    return [f"{name}={as_word(value)}" for name, value in (set or {}).items()]


def cut(*decks: StrPath, output: StrPath, path: StrPath | None = None, **options: typing.Any) -> pathlib.Path:
    """Cuts a geometry to a block file, or an analysis to a results file of the model as set up; raises RunFailed."""
    done_or_failed(call("cut", *decks, "-o", output, "--quiet", path=path, **options))
    return pathlib.Path(output)


def made_folder(path: StrPath) -> pathlib.Path:
    """A folder to write into, made where it is not there; ScreeError where it cannot be."""
    try:
        pathlib.Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as problem:
        raise ScreeError(f"{path}: expected a folder to write into, found: {problem.strerror}") from None
    return pathlib.Path(path)


@contextlib.contextmanager
def work_folder(keep: StrPath | None = None) -> Iterator[pathlib.Path]:
    """A folder for runs: the one to keep, made where it is not there, or one that goes again."""
    if keep:
        yield made_folder(keep)
    else:
        with tempfile.TemporaryDirectory() as folder:
            yield pathlib.Path(folder)


class Runner:
    """Runs decks into a folder, each to a name, with settings for all before those of each; adds up the seconds that they take, and
    the systems that they solve and the seconds of the processor that their steps take."""

    def __init__(self, folder, path=None, settings=()):
        self.folder, self.path, self.settings = pathlib.Path(folder), program(path), settings
        self.seconds, self.solves, self.processor_seconds = 0.0, 0, 0.0

    def __call__(self, deck, geometry=None, settings=(), name=None):
        """Runs an analysis deck, or a model, whose decks are written into the folder; the geometry as (name, text) where the deck names
        none."""
        if not isinstance(deck, str | os.PathLike):
            name = name or deck.name
            deck = deck.save(self.folder / f"{name}.ana")
        decks = [deck]
        if geometry:
            decks.insert(0, self.folder / geometry[0])
            decks[0].write_text(geometry[1])
        output = self.folder / f"{name or deck.parent.name + '-' + deck.stem}.h5"
        start = time.perf_counter()
        try:
            results = run(*decks, output=output, settings=[*self.settings, *settings], path=self.path)
            self.solves += int(results.history.solves.sum())
            self.processor_seconds += results.seconds("steps", "processor")
            return results
        finally:
            self.seconds += time.perf_counter() - start
