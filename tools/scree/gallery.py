"""Runs the examples of input/examples and the commands on pages of doc/, and compares what they print with what is quoted there.

    tools/gallery [NAME ...] [--write] [--keep FOLDER] [--jobs N] [--scree PROGRAM]

A name is that of an example, of a page with commands, such as tutorial, or of a notebook; without any name all are run. An example is an
analysis deck whose opening comment says what it shows, the commands to give (indented), and after `Expect:` the numbers to expect.
Or it is a script of Python with a docstring that says this, without commands. Numbers are

    history/rotation[-1, 2] = 1.5708 within 0.001: why        of the results of the deck; `largest` for an index: the largest there
    factor of safety = 1.1984 within 0.5 %: why               what the commands print after these words

On a page the commands are in blocks ```sh, or ```python with a script, each followed by a block ```text where it quotes what they
print (a script that quotes nothing is not run): its lines are found in that order, with numbers that agree to 0.1 %. Commands are to fail where an error of the program is quoted (scree: ...), nowhere
else. They run in a folder of their own, with the folders of the tree in it. The cells of a notebook of doc/ (.ipynb) are run in the
plain interpreter; they print what the notebook holds, with numbers that agree to 0.1 %, and draw pictures of the same sizes. --write
makes doc/gallery.md of the examples, puts the pictures that examples and pages make into doc/pictures, and the outputs of cells into
their notebooks. Exit status 1 where a number is off, or a command fails.
"""
import ast
import concurrent.futures
import dataclasses
import itertools
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

import numpy as np

from .arguments import ends_in_a_line, parser_for, whole_from
from .errors import ScreeError
from .notebooks import lines_of, pictures_of, read_notebook, size_of
from .program import TREE, program, work_folder
from .records import stopped_at_once
from .results import read

EXAMPLES, DOC = TREE / "input" / "examples", TREE / "doc"
PICTURES = DOC / "pictures"
INTRODUCTION = """# Gallery

The scenes of `input/examples`, with their commands for the folder of scree. Those in Python run with
`PYTHONPATH=tools python3 input/examples/NAME/NAME.py`. `tools/gallery` runs all of them and compares with the expected numbers.
"""
EXPECTED = re.compile(r"(?P<what>.+?) = (?P<value>\S+) within (?P<within>\S+?)(?P<share> %)?: (?P<why>.+)")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
ERROR = "scree: "   # how a line begins that a page quotes of a command that is to fail
QUOTED = 1e-3       # share by which a number that a page quotes may differ: its digits; kernels of OpenBLAS differ by 1e-12
INDENT = "    "
BUILT = ("build", "release", "bin", "scree")  # the program in the folder of a scene
INTERPRETERS = {"sh": ("sh", "-e"), "python": (sys.executable, "-")}  # of the blocks of a page
BLOCKS = re.compile(r"^```(sh|python)\n(.*?)^```\n(?:\s*```text\n(.*?)^```\n)?", re.M | re.S)


@dataclasses.dataclass
class Expected:
    """A number that a scene comes to: what it is, its value, by how much it may differ, and why it is this."""

    what: str
    value: float
    within: float
    why: str


@dataclasses.dataclass
class Outcome:
    """A row of the table: what was expected, what was found, by how much it differs, and by how much it may; or what went wrong."""

    scene: str
    what: str
    expected: float = math.nan
    found: float = math.nan
    within: float = math.nan
    wrong: str = ""

    @property
    def holds(self):
        return not self.wrong and abs(self.found - self.expected) <= self.within


@dataclasses.dataclass
class Example:
    """An analysis deck with an opening comment, or a script of Python with a docstring: its paragraphs, of which those that are indented
    hold commands or formulas, and the numbers that it expects. ScreeError where a comment says no command, or the expectations cannot be
    read."""

    deck: pathlib.Path
    paragraphs: list = dataclasses.field(default_factory=list)
    expected: list = dataclasses.field(default_factory=list)

    def __post_init__(self):
        text, _, after = self.opening().partition("Expect:\n")
        self.paragraphs = [part.strip("\n") for part in re.split(r"\n\s*\n", text) if part.strip()]
        for line in filter(str.strip, after.splitlines()):
            found = EXPECTED.fullmatch(line.strip())
            if not found:
                raise ScreeError(f"{self.deck}: expected WHAT = NUMBER within NUMBER: WHY after Expect:, found '{line}'")
            value = float(found["value"])
            within = float(found["within"]) * (abs(value) / 100 if found["share"] else 1)
            self.expected.append(Expected(found["what"], value, within, found["why"]))
        if not self.commands or not self.expected:
            raise ScreeError(f"{self.deck}: expected commands and numbers in its opening comment, found none")

    def opening(self):
        """The opening comment of the deck, or the docstring of the script."""
        text = self.deck.read_text()
        if self.script is not None:
            return ast.get_docstring(ast.parse(text)) or ""
        comment = itertools.takewhile(lambda line: line.startswith("!"), text.splitlines())
        return "\n".join(line[1:].removeprefix(" ") for line in comment)

    @property
    def name(self):
        return self.deck.stem

    @property
    def script(self):
        """The lines of a script below its docstring; None of a deck."""
        return self.deck.read_text().split('"""\n', 1)[-1] if self.deck.suffix == ".py" else None

    @property
    def commands(self):
        """What is given to run the example, and the interpreters."""
        if self.script is not None:
            return [(self.deck.read_text(), INTERPRETERS["python"])]
        lines = [line.removeprefix(INDENT) for part in self.paragraphs if part.startswith(INDENT) for line in part.splitlines()]
        return [(line, INTERPRETERS["sh"]) for line in lines if line.startswith(("build/", "tools/"))]

    @property
    def pictures(self):
        return re.findall(r'savefig\("(.*?)"', self.script) if self.script is not None else [f"{self.name}.png"]

    def run(self, folder):
        """Gives the commands in a folder; the outcome of each number."""
        said = []
        for command, interpreter in self.commands:
            status, output = give(command, folder, interpreter)
            if status:
                return [Outcome(self.name, command.splitlines()[0], wrong=how_it_failed(status, output))]
            said.append(output)
        return [Outcome(self.name, one.what, one.value, self.number(one.what, folder, "\n".join(said)), one.within)
                for one in self.expected]

    def number(self, what, folder, said):
        """A number that was printed, or of the results: one of a dataset, or one less another."""
        if "[" in what:
            first, *others = (self.of_dataset(term, folder) for term in what.split(" - "))
            return first - sum(others)
        found = re.search(rf"^{re.escape(what)}: ({NUMBER.pattern})", said, re.M)
        return float(found[1]) if found else math.nan

    def of_dataset(self, term, folder):
        dataset, _, index = term.strip().rstrip("]").partition("[")
        values = np.asarray(read(folder / f"{self.name}.h5")[dataset], float)
        places = tuple(slice(None) if word.strip() == "largest" else int(word) for word in index.split(","))
        return float(np.abs(values[places]).max()) if "largest" in index else float(values[places])

    def markdown(self):
        """The section of the example in doc/gallery.md."""
        lines = [f"## {self.name}", "", *(line for part in self.paragraphs for line in (part, ""))]
        if self.script is not None:
            lines += [f"```python\n{self.script.strip()}\n```", ""]
        for picture in self.pictures:
            lines += [f"![The example {self.name}](pictures/{picture})", ""]
        lines += ["| expected | | |", "|---|---|---|"]
        lines += [f"| `{one.what}` | {one.value:.6g} | {one.why} |" for one in self.expected]
        return "\n".join(lines) + "\n"


@dataclasses.dataclass
class Page:
    """A page of doc/ with blocks ```sh of commands, or scripts ```python, and blocks ```text of what they print. A script without
    ```text is not run."""

    path: pathlib.Path

    @property
    def name(self):
        return self.path.stem

    @property
    def pictures(self):
        return re.findall(r"\]\(pictures/(.*?\.png)\)", self.path.read_text())

    def blocks(self):
        """Interpreters, commands for them, and lines that they are said to print after them, if there are any."""
        found = BLOCKS.findall(self.path.read_text())
        return [(INTERPRETERS[kind], commands, [line for line in quoted.splitlines() if line.strip() not in ("", "...")])
                for kind, commands, quoted in found if kind == "sh" or quoted]

    def run(self, folder):
        """Gives the commands of all blocks, one after the other; what is not as the page says."""
        rows = []
        for interpreter, commands, quoted in self.blocks():
            status, output = give(commands, folder, interpreter)
            first = commands.strip().splitlines()[0]
            missing = next_missing(quoted, output)
            if status and not missing and not any(line.startswith(ERROR) for line in quoted):
                rows.append(Outcome(self.name, first, wrong=how_it_failed(status, output)))
            elif missing:
                rows.append(Outcome(self.name, first, wrong=f"expected the line '{missing}', found:\n{output}"))
            else:
                rows.append(Outcome(self.name, first, len(quoted), len(quoted), 0))
        return rows


@dataclasses.dataclass
class NotebookPage:
    """A notebook of doc/: its cells print what the outputs in it say, and draw pictures of the same sizes."""

    path: pathlib.Path
    pictures = ()  # those of its outputs stand in it

    @property
    def name(self):
        return self.path.stem

    def run(self, folder):
        """Runs all cells into a notebook of its name in a folder; what is not as the notebook says."""
        made = folder / self.path.name
        status, output = give(f"import pathlib, scree.notebooks as n; n.write_executed(*map(pathlib.Path, {[str(self.path), made.name]}))", folder,
                              INTERPRETERS["python"])
        if status:
            return [Outcome(self.name, self.path.name, wrong=how_it_failed(status, output))]
        return [self.compared(*cells) for cells in zip(*(read_notebook(path)["cells"] for path in (self.path, made)), strict=True)
                if cells[0]["cell_type"] == "code"]

    def compared(self, kept, made):
        """The outcome of a cell."""
        first, said, now = kept["source"][0].strip(), lines_of(kept), lines_of(made)
        if len(said) != len(now) or not all(map(agree, said, now)):
            return Outcome(self.name, first, wrong="\n".join(["expected the lines", *said, "found", *now]))
        sizes, found = ([size_of(picture) for picture in pictures_of(cell)] for cell in (kept, made))
        if sizes != found:
            return Outcome(self.name, first, wrong=f"expected pictures of the sizes {sizes}, found {found}")
        return Outcome(self.name, first, len(said), len(now), 0)


def give(commands, folder, interpreter=("sh", "-e")):
    """Gives commands to a shell, or to another interpreter, in a folder: its exit status, with a shell that of the first command that
    fails; what all printed."""
    done = subprocess.run(interpreter, input=commands, cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          env=os.environ | {"PYTHONPATH": str(TREE / "tools"), "SCREE": str(pathlib.Path(folder, *BUILT).absolute())})
    return done.returncode, done.stdout


def how_it_failed(status, output):
    """The exit status of a command, and the last line that it printed, if any."""
    return ": ".join([f"exit status {status}", *output.strip().splitlines()[-1:]])


def agree(quoted, line):
    """Whether two lines have the same words, and numbers that differ by no more than QUOTED."""
    words, found = (" ".join(NUMBER.sub("#", text).split()) for text in (quoted, line))
    if words != found:
        return False
    return all(abs(float(a) - float(b)) <= QUOTED * abs(float(a)) for a, b in zip(NUMBER.findall(quoted), NUMBER.findall(line)))


def next_missing(quoted, output):
    """The first of the lines that is not found in the output after those before it; or nothing."""
    lines = iter(output.splitlines())
    return next((one for one in quoted if not any(agree(one, line) for line in lines)), None)


def pages():
    """The pages of doc/ with commands to try, but for its notes."""
    found = [Page(path) for path in sorted(DOC.rglob("*.md")) if "notes" not in path.parts]
    return [page for page in found if page.blocks()]


def known():
    """All examples and pages, by name."""
    folders = sorted(EXAMPLES.iterdir())
    decks = [next(folder / f"{folder.name}{ending}" for ending in (".ana", ".py") if (folder / f"{folder.name}{ending}").exists()) for folder in folders]
    scenes = [Example(deck) for deck in decks] + pages() + [NotebookPage(path) for path in sorted(DOC.glob("*.ipynb"))]
    return {scene.name: scene for scene in scenes}


def run_in_its_own(scene, folder, path):
    """Runs a scene in a folder made for it, with the folders of the tree and the program in it; its outcomes and its seconds."""
    own = folder / scene.name
    own.joinpath(*BUILT).parent.mkdir(parents=True)
    own.joinpath(*BUILT).symlink_to(path)
    for name in ("input", "tools"):
        (own / name).symlink_to(TREE / name)
    start = time.perf_counter()
    return scene.run(own), time.perf_counter() - start


def show(rows, seconds):
    for row in rows:
        if math.isnan(row.expected):
            print(f"{row.scene:<11} {row.what}\n            {row.wrong}", flush=True)
        elif row.within == 0:
            print(f"{row.scene:<11} {row.what}   {row.expected} lines as quoted", flush=True)
        else:
            print(f"{row.scene:<11} {row.what:<40} expected {row.expected:<12.6g} found {row.found:<12.6g} "
                  f"{'' if row.holds else 'off by more than '}within {row.within:.2g}", flush=True)
    print(f"{'':<11} {seconds:.1f} s", flush=True)


def gallery_page(scenes):
    """The text of doc/gallery.md."""
    return "\n".join([INTRODUCTION, *(scene.markdown() for scene in scenes if isinstance(scene, Example))])


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--write", action="store_true", help="make doc/gallery.md and the pictures of doc/pictures")
    parser.add_argument("--keep", metavar="FOLDER", help="keep what the commands write")
    parser.add_argument("--jobs", type=whole_from(1), default=len(os.sched_getaffinity(0)), metavar="N", help="scenes at once")
    parser.add_argument("--scree", metavar="PROGRAM", help="the program; default: that of $SCREE, or of build/release")
    given = parser.parse_args()
    path, scenes = program(given.scree), known()
    unknown = [name for name in given.names if name not in scenes]
    if unknown:
        parser.error(f"expected names out of {', '.join(scenes)}, found {unknown[0]}")
    chosen = [scenes[name] for name in given.names or scenes]
    with work_folder(given.keep) as folder, concurrent.futures.ThreadPoolExecutor(given.jobs) as pool, stopped_at_once(pool):
        all_rows = []
        for rows, seconds in pool.map(lambda scene: run_in_its_own(scene, folder, path), chosen):
            show(rows, seconds)
            all_rows += rows
        if given.write:
            for scene in chosen:
                kept = {picture: PICTURES / picture for picture in scene.pictures}
                kept |= {scene.path.name: scene.path} if isinstance(scene, NotebookPage) else {}
                for name, place in kept.items():
                    if (folder / scene.name / name).exists():
                        shutil.copy(folder / scene.name / name, place)
            (TREE / "doc" / "gallery.md").write_text(gallery_page(scenes.values()))
    off = [row for row in all_rows if not row.holds]
    print(f"{len(all_rows) - len(off)} of {len(all_rows)} as expected")
    return 1 if off else 0
