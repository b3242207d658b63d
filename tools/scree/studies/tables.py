"""Which runs a study has: a CSV file with a run a line, or a TOML file of lists, ranges and samples."""
import csv
import dataclasses
import itertools
import math
import pathlib
import random
import statistics
import tomllib

from ..errors import ScreeError

KINDS = {"deck": str, "geometry": str, "set": list, "grid": dict, "sample": dict, "quantities": dict}  # of what a TOML file may have
WORDS = {str: "a text", list: "a list of texts", dict: "a table"}
ROUNDING = 1e-13  # of what lies between two numbers, over its size
MOST_RUNS = 100_000  # of a TOML file
LEAST_PROBABILITY = 1e-300  # 37 deviations from the mean


class TableError(ScreeError):
    """A table that says no runs."""


@dataclasses.dataclass
class Table:
    """Names for `--set`, and for each run their values as texts; decks and settings of all runs, where the table has them; what
    is read from the results of each run, as name: (dataset, index...)."""

    names: list
    rows: list
    decks: list = dataclasses.field(default_factory=list)
    settings: list = dataclasses.field(default_factory=list)
    quantities: dict = dataclasses.field(default_factory=dict)


def read_table(path):
    """The table of a file, TOML where its name ends so, else CSV. TableError with the file and what is wrong."""
    path = pathlib.Path(path)
    try:
        text = path.read_text(encoding="utf-8-sig")  # spreadsheets write a mark before the first letter
    except (OSError, UnicodeDecodeError) as problem:
        raise TableError(f"{path}: expected a table of runs, found: {problem}") from None
    return checked(path, from_toml(path, text) if path.suffix == ".toml" else from_csv(path, text))


def checked(path, table):
    """A table of a file, or of words; TableError where it has no runs, or names that are none."""
    if not table.rows or not table.names:
        raise TableError(f"{path}: expected at least one run and one name, found none")
    wrong = [name for name in table.names if "=" in name or "." not in name]
    if wrong or len(set(table.names)) < len(table.names):
        raise TableError(f"{path}: expected names for --set, each once, found {', '.join(wrong or table.names)}")
    return table


def from_csv(path, text):
    lines = [[word.strip() for word in line] for line in csv.reader(text.splitlines()) if any(word.strip() for word in line)]
    if not lines:
        raise TableError(f"{path}: expected a line with names for --set, found none")
    for number, line in enumerate(lines[1:], 1):
        if len(line) != len(lines[0]) or "" in line:
            raise TableError(f"{path}: expected {len(lines[0])} values in run {number}, found {len([w for w in line if w])}")
    return Table(lines[0], lines[1:])


def from_toml(path, text):
    try:
        given = tomllib.loads(text)
    except tomllib.TOMLDecodeError as problem:
        raise TableError(f"{path}: expected TOML, found: {problem}") from None
    return table_of(path, given)


def table_of(path, given):
    """The table that the members of a TOML file say."""
    for name, what in given.items():
        if name not in KINDS:
            raise TableError(f"{path}: expected {', '.join(KINDS)}, found {name}")
        if not isinstance(what, KINDS[name]) or KINDS[name] is list and not all(isinstance(one, str) for one in what):
            raise TableError(f"{path}: expected {WORDS[KINDS[name]]} for {name}, found {what!r}")
    for name, what in given.get("quantities", {}).items():
        if not (isinstance(what, list) and what and isinstance(what[0], str)):
            raise TableError(f"{path}: expected a dataset and places in it for {name} of [quantities], found {what!r}")
    grid, sample = given.get("grid", {}), dict(given.get("sample", {}))
    try:
        number, seed = sample.pop("number", 0 if sample else 1), sample.pop("seed", 1)
        if not isinstance(number, int) or not isinstance(seed, int) or not 1 <= number <= MOST_RUNS:
            raise TableError(f"{path}: expected whole numbers for number (from 1 to {MOST_RUNS}) and seed in [sample], "
                             f"found {number} and {seed}")
        each = {name: points(name, what) for name, what in grid.items()}
        check_runs(path, {**{name: len(values) for name, values in each.items()}, "number of [sample]": number})
        drawn = list(zip(*(draw(name, what, number, f"{seed} {name}") for name, what in sample.items()))) or [()]
        values = itertools.product(*each.values())
        rows = [[text_of(value) for value in (*point, *one)] for point in values for one in drawn]
    except (ValueError, ArithmeticError) as problem:
        raise TableError(f"{path}: expected lists, or tables of numbers as doc/studies.md has them, found: {problem}") from None
    names = [name for name in ("geometry", "deck") if name in given]
    return Table([*grid, *sample], rows, [path.parent / given[name] for name in names], given.get("set", []),
                 {name: tuple(what) for name, what in given.get("quantities", {}).items()})


def check_runs(path, counts):
    """TableError where the values of names, each with each, make more runs than a study can have."""
    runs = math.prod(counts.values())
    if runs > MOST_RUNS:
        found = ", ".join(f"{count} of {name}" for name, count in counts.items() if count > 1)
        raise TableError(f"{path}: expected at most {MOST_RUNS} runs, found {runs}: {found}")


def text_of(value):
    """A value as `--set` takes it."""
    if isinstance(value, list):
        return " ".join(text_of(one) for one in value)
    return str(value)


def points(name, what):
    """The values of a name in a grid: a list, or so many from one to another, evenly or by equal ratios."""
    check_kind(name, what)
    if isinstance(what, list):
        return what
    check_keys(name, what, {"from", "to", "count"}, {"scale"})
    if not isinstance(what["count"], int) or not 2 <= what["count"] <= MOST_RUNS:  # noqa: PLR2004  the ends
        raise ValueError(f"count {what['count']} of {name}, which is to be a whole number from 2 to {MOST_RUNS}")
    return [between(name, what, i / (what["count"] - 1)) for i in range(what["count"])]


def draw(name, what, number, seed):
    """So many values of a name: one from each of as many parts of equal probability, in an order by chance (McKay et al. 1979).

    The random numbers are those that Python promises not to change: a seed gives the same values anywhere. Each name has its own.
    """
    check_kind(name, what)
    chance = random.Random(seed)
    order = sorted(range(number), key=[chance.random() for _ in range(number)].__getitem__)
    shares = [(part + chance.random()) / number for part in order]
    if isinstance(what, list):
        return [what[int(share * len(what))] for share in shares]
    if "mean" not in what:
        check_keys(name, what, {"from", "to"}, {"scale"})
        return [between(name, what, share) for share in shares]
    check_keys(name, what, {"mean", "deviation"}, {"least", "most"})
    return cut_normal(name, what, shares)


def cut_normal(name, what, shares):
    """What lies at shares of a normal distribution that is cut off at its ends, not piled up there. Where all of it lies above the mean
    it is that of the other side: probabilities near 0 have digits, those near 1 have none."""
    mean, deviation, least, most = what["mean"], what["deviation"], what.get("least", -math.inf), what.get("most", math.inf)
    if not (math.isfinite(mean) and 0 < deviation < math.inf and least < most):
        raise ValueError(f"{what} for {name}, whose deviation is to be above 0, and least below most")
    low, high = (least - mean) / deviation, (most - mean) / deviation
    side = -1 if low > 0 else 1
    if side < 0:
        low, high, shares = -high, -low, [1 - share for share in shares]
    first, last = (math.erfc(-end / math.sqrt(2)) / 2 for end in (low, high))
    if last < LEAST_PROBABILITY:
        raise ValueError(f"{what} for {name}, of whose distribution nothing is left")
    chosen = (min(max(first + share * (last - first), LEAST_PROBABILITY), 1 - 2 ** -53) for share in shares)
    return [min(max(mean + side * deviation * statistics.NormalDist().inv_cdf(one), least), most) for one in chosen]


def check_kind(name, what):
    """That it is a list with entries, or a table of numbers but for its scale."""
    numbers = [value for key, value in what.items() if key != "scale"] if isinstance(what, dict) else []
    if not (what if isinstance(what, list) else numbers) or not all(type(number) in (int, float) for number in numbers):
        raise ValueError(f"{what!r} for {name}")


def check_keys(name, what, needed, allowed):
    if missing := needed - set(what):
        raise ValueError(f"{what} for {name} without {', '.join(sorted(missing))}")
    if not set(what) <= needed | allowed or what.get("scale", "log") not in ("log", "linear"):
        raise ValueError(f"{what} for {name}")


def between(name, what, share):
    """What lies at a share of the way; a whole number where both ends are written so, and it is one but for rounding."""
    low, high = what["from"], what["to"]
    if what.get("scale") != "log":
        value = low + share * (high - low)
    elif min(low, high) <= 0:
        raise ValueError(f"{what} for {name}: a scale of log needs numbers above 0")
    else:
        value = low * (high / low) ** share
    whole = isinstance(low, int) and isinstance(high, int) and math.isclose(value, round(value), rel_tol=ROUNDING)
    return round(value) if whole else value
