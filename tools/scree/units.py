"""Units of pictures: names, and what the numbers of results are divided by, for the dimensions that results are in."""
import math
import re

from .errors import PlotError
from .in_force import Explained, settings_of_lines
from .program import call, done_or_failed
from .results import read

BASES = {"force": (1, 2, 0), "mass": (1, 1, 2), "length": (0, 1, 0), "time": (0, 0, 1)}  # powers of stress, length and time


# Names of a stress times the square of a length, as a force and as an energy of unit thickness, by the names of length and stress.
FORCES = {("m", "Pa"): ("N", "J/m"), ("m", "kPa"): ("kN", "kJ/m"), ("m", "MPa"): ("MN", "MJ/m"), ("m", "GPa"): ("GN", "GJ/m"),
          ("mm", "MPa"): ("N", "mJ/mm"), ("mm", "GPa"): ("kN", "J/mm")}
ENERGY = "force*length/length"
RAISED = {1: "", 0.5: "$^{1/2}$"}  # how powers are written that are not their number
NO_STRESSES = {"m", "mm", "cm", "km", "s", "ms"}  # names that are those of a length or a time
STRESSES = {(length, force): stress for (length, stress), (force, _) in FORCES.items()}


def units_of_deck(results):
    """The words of `--units` for the units that the deck of results names in &units; None where it names none, or others than known."""
    return units_of_settings(settings_of_lines(map(str, results.scene.settings)))


def units_of_files(*files, path=None):
    """As `units_of_deck`, of a results file, or of decks by what the program, or the one of a path, says of them."""
    if not str(files[-1]).lower().endswith(".ana"):
        return units_of_deck(read(files[-1]))
    return units_of_settings(Explained(done_or_failed(call("explain", *files, path=path)).stdout).stages[0])


def units_of_settings(settings):
    """The words of `--units` for values of settings by GROUP.NAME, those of &units."""
    length, force, time = (settings.get(f"units.{base}", "none") for base in ("length", "force", "time"))
    if (length, force) not in STRESSES:
        return None
    return ",".join([length, STRESSES[length, force], *([time] if time != "none" else [])])


class Units:
    """Names of stress, length and time, each with how many of the unit of the decks it is. Without names dimensions stay."""

    def __init__(self, words=None):
        """Of LENGTH,STRESS or LENGTH,STRESS,TIME, each NAME or NAME=FACTOR; PlotError where the words are others."""
        self.given, self.bases = words is not None, []
        if not self.given:
            return
        found = [re.fullmatch(r"([^\s=,]+)(?:=([^=]+))?", word) for word in words.split(",")]
        try:
            self.bases = [(match[1], float(match[2] or 1)) for match in found]
        except (TypeError, ValueError):
            self.bases = []
        if len(self.bases) not in (2, 3) or not all(0 < factor < float("inf") for _, factor in self.bases):
            raise PlotError(f"--units: expected LENGTH,STRESS or LENGTH,STRESS,TIME, such as m,MPa=1e6, found '{words}'")
        length, stress, time = [*self.bases, ("time", 1.0)][:3]
        if stress[0] in NO_STRESSES:
            raise PlotError(f"--units: expected LENGTH,STRESS or LENGTH,STRESS,TIME, such as m,MPa=1e6, found '{stress[0]}' for the stress")
        self.bases = [stress, length, time]

    def of(self, label):
        """A label such as `speed [length/time]` with the unit in place of the dimension, and what numbers are divided by."""
        match = re.search(r"\[(.*)\]", label)
        powers = self.powers(match[1].replace("$", "")) if match else None
        if not self.given or powers is None:
            return label, 1.0
        factor = math.prod(size**power for (_, size), power in zip(self.bases, powers))
        return f"{label[:match.start()]}[{self.named(match[1], *powers)}]{label[match.end():]}", factor

    def named(self, dimension, stress, length, time):
        """The unit of a dimension with these powers: of force and energy where the names of length and stress have one, else of stress."""
        (of_stress, _), (of_length, _), (of_time, _) = self.bases
        powers = [(of_stress, stress), (of_length, length), (of_time, time)]
        if (of_length, of_stress) in FORCES and stress == 1 and length >= 1:
            force, energy = FORCES[of_length, of_stress]
            if dimension == ENERGY:
                return energy
            powers[:2] = [(force, 1), (of_length, length - 2)]
        above, below = ([name + RAISED.get(abs(power), f"$^{abs(power)}$") for name, power in powers if sign * power > 0]
                        for sign in (1, -1))
        return "/".join([" ".join(above) or "1", *below])

    def powers(self, dimension):
        """Powers of stress, length and time of a dimension such as force*length/length; None for what has none."""
        total = [0, 0, 0]
        for sign, base, power, half in re.findall(r"([*/]?)([^*/^]+)\^?(\d*)(\(1/2\))?", dimension):
            if base not in BASES:
                return None
            for i, own in enumerate(BASES[base]):
                total[i] += (-1 if sign == "/" else 1) * (0.5 if half else int(power or 1)) * own
        return total

    def words(self, label):
        """As `of`, the label for a page: powers as letters."""
        label, factor = self.of(label)
        return label.replace("$^2$", "²").replace("$^3$", "³").replace("$^{1/2}$", "^½"), factor

    def quantity(self, value, dimension):
        """A number of a dimension in few digits, with its unit; without names the number alone."""
        if value is None or not self.given or self.powers(dimension) is None:
            return number(value)
        unit, factor = self.words(f"[{dimension}]")
        return f"{number(value / factor)} {unit[1:-1]}"


def add_units(parser):
    """What units the numbers of pictures and pages are in."""
    parser.add_argument("--units", metavar="LENGTH,STRESS[,TIME]",
                        help="names; NAME=FACTOR is so many of the unit of the decks, as in m,MPa=1e6; default: the names of &units")


def number(value):
    """A number, whole or not, in few digits; a dash for none."""
    return "–" if value is None else f"{value:,.4g}".replace(",", " ") if isinstance(value, float) else f"{value}"
