"""The program: where it is, and how it is run."""
import contextlib
import os
import pathlib
import shutil
import subprocess
import tempfile
import time

from .errors import ProgramMissing, RunFailed
from .results import read

TREE = pathlib.Path(__file__).resolve().parents[2]
BUILT = TREE / "build" / "release" / "bin" / "scree"


def program(path=None):
    """The path of the program: the one given, else that of the variable SCREE, else that of the build folder, else the one that
    the shell finds."""
    path = path or os.environ.get("SCREE") or (BUILT if BUILT.exists() else shutil.which("scree") or BUILT)
    if not pathlib.Path(path).exists():
        raise ProgramMissing(f"expected the program {path}, found none: build it, or name it with --scree or the variable SCREE")
    return pathlib.Path(path).absolute()


def call(*words, path=None, **options):
    """Runs `scree WORDS` and returns what subprocess.run does, with what it printed as text, whatever its exit status.

    `path` names another program; options are those of subprocess.run, such as cwd and timeout.
    """
    return subprocess.run([program(path), *words], capture_output=True, text=True, **options)


def done_or_failed(done):
    """What `call` returned, if its exit status is 0; else RunFailed."""
    if done.returncode:
        said = done.stderr.strip().splitlines() or [f"exit status {done.returncode}"]
        raise RunFailed(said[-1].removeprefix("scree: "), done.returncode, done.stderr)
    return done


def with_settings(settings):
    """Words of the command line for settings such as step.size=0.01."""
    return [word for setting in settings for word in ("--set", setting)]


def run(*decks, output=None, settings=(), words=(), path=None, **options):
    """Runs decks (an analysis; or a geometry and an analysis) and returns their Results; raises RunFailed with the program's words.

    `output` is the results file, by default beside the analysis; `settings` are texts such as "step.size=0.01"; `words` are more
    words of the command line, `path` is another program, options are those of subprocess.run.
    """
    output = pathlib.Path(output or pathlib.Path(decks[-1]).with_suffix(".h5"))
    done_or_failed(call("run", *decks, "-o", output, "--quiet", *with_settings(settings), *words, path=path, **options))
    return read(pathlib.Path(options.get("cwd") or ".") / output)


def cut(*decks, output, path=None, **options):
    """Cuts a geometry to a block file, or an analysis to a results file of the model as set up; raises RunFailed."""
    done_or_failed(call("cut", *decks, "-o", output, "--quiet", path=path, **options))
    return pathlib.Path(output)


@contextlib.contextmanager
def work_folder(keep=None):
    """A folder for runs: the one to keep, made where it is not there, or one that goes again."""
    if keep:
        pathlib.Path(keep).mkdir(parents=True, exist_ok=True)
        yield pathlib.Path(keep)
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
        """Runs an analysis deck; the geometry as (name, text) where the deck names none."""
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
