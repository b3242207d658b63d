"""Runs that are many: what tells one from another, what is kept of each, how far they are."""
import contextlib
import hashlib
import pathlib
import re
import sys

from .program import call, done_or_failed, with_settings

NAME_FILES = ("deck.geometry", "cover.mesh", "acceleration.file", "acceleration.vertical", "absorbing.file")  # settings


def explain(decks, settings, path):
    """The settings of a scene with more of them, the files that its stages name, and the numbers of the decks that these give, by
    name, and where its geometry is; RunFailed where the program refuses them."""
    said = done_or_failed(call("explain", *decks, *with_settings(settings), path=path)).stdout
    asked = dict(re.findall(r"^  (\w+\.\w+) = (.*?)(?: \[\S*\])?  \(.*\)$", said, re.M))
    given = dict(re.findall(r"^  given: --set (.*?)=(.*)$", said, re.M))
    for number, changes in re.findall(r"^stage (\d+) (.*)$", said, re.M):
        changed = re.findall(r"; (\w+\.\w+) = ([^;]*)", changes)
        asked |= {f"stage({number}).{name}": value for name, value in changed if names_a_file(name)}
    return {**given, **asked, "deck.geometry": re.search(r"^geometry: (.*)$", said, re.M)[1]}


def dimensions(decks, settings, path):
    """The dimensions of settings and of numbers of the analysis deck, by their names for `--set`, such as force/length; of those that
    have none, and of a geometry, there is no entry."""
    said = done_or_failed(call("explain", *decks, *with_settings(settings), path=path)).stdout
    found = dict(re.findall(r"^  (\w+\.\w+) = .*? \[(\S*)\]  \(.*\)$", said, re.M))
    group = ""
    for line in said.partition("\nsettings\n")[0].splitlines():
        if line[:1] != " ":
            header = re.search(r"\((\w+\(\d+\)) for --set\)", line)
            group = header[1] if header else "deck"
        elif number := re.fullmatch(r"  .* \(([\w ]+).*?\): .* \[(\S+)\]", line):
            found |= {f"{group}.{name}": number[2] for name in number[1].split()}
    return found


def hashed(*parts):
    digest = hashlib.sha256()
    for part in parts:
        digest.update(part if isinstance(part, bytes) else str(part).encode())
        digest.update(b"\0")
    return digest.hexdigest()[:20]


def names_a_file(name):
    """Whether a setting, of the scene or of a stage, names a file."""
    return re.sub(r"^stage\(\d+\)\.", "", name) in NAME_FILES


def files_of(decks, asked):
    """What decks and the files that their settings name say."""
    folder = decks[-1].parent
    beside = [folder / value for name, value in asked.items() if names_a_file(name) and name != "deck.geometry"]
    paths = dict.fromkeys(path.resolve() for path in [*decks, pathlib.Path(asked["deck.geometry"]), *beside])
    return [path.read_bytes() for path in paths if path.is_file()]


def replace(path, content):
    """Replaces a file by a text, or by bytes, whole or not at all."""
    partial = path.with_suffix(".part")
    partial.write_bytes(content if isinstance(content, bytes) else content.encode())
    partial.replace(path)


@contextlib.contextmanager
def stopped_at_once(pool):
    """Ends a pool without the runs that wait, where something goes wrong or someone stops it."""
    try:
        yield
    except BaseException:
        pool.shutdown(cancel_futures=True)
        raise


class Bar:
    """How far a round of runs is, or what else is many, on stderr: a bar on a terminal, else a line at each tenth."""

    def __init__(self, what, total, things="runs"):
        self.what, self.total, self.things, self.done, self.said = what, total, things, 0, 0

    def advance(self, name):
        self.done += 1
        tenths = 10 * self.done // self.total
        if sys.stderr.isatty():
            bar = "#" * (2 * tenths)
            print(f"\r{self.what} [{bar:<20}] {self.done}/{self.total} {name:<20}", end="", file=sys.stderr, flush=True)
        elif tenths > self.said:
            print(f"{self.what}: {self.done} of {self.total} {self.things}", file=sys.stderr, flush=True)
        self.said = tenths

    def end(self):
        if self.done and sys.stderr.isatty():
            print(file=sys.stderr)
