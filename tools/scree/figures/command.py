"""Draws the figures of the theory, doc/pictures/theory/NAME.png, from formulas and small models of their own.

    tools/figures [NAME ...] [-o FOLDER] [--list]

Without a name all are drawn. The same version of matplotlib draws the same file each time.
"""
import pathlib

from ..arguments import ends_in_a_line, parser_for
from ..errors import ScreeError
from ..program import TREE
from . import contacts, equilibrium, impacts, integrators, kinematics, laws, problems  # noqa: F401  they register their figures
from .sheet import FIGURES, FONT, RESOLUTION, drawn

FOLDER = TREE / "doc" / "pictures" / "theory"


def draw(name, folder):
    """Draws one figure into a folder, and returns the file."""
    import matplotlib
    path = pathlib.Path(folder) / f"{name}.png"
    with matplotlib.rc_context(FONT):
        drawn(FIGURES[name]).savefig(path, dpi=RESOLUTION, metadata={"Software": None})
    return path


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("-o", "--output", type=pathlib.Path, default=FOLDER, metavar="FOLDER")
    parser.add_argument("--list", action="store_true", help="say the names of all figures")
    options = parser.parse_args()
    if options.list:
        print(*FIGURES, sep="\n")
        return 0
    for name in options.names or FIGURES:
        if name not in FIGURES:
            raise ScreeError(f"expected a figure of: {', '.join(FIGURES)}; found '{name}'")
        options.output.mkdir(parents=True, exist_ok=True)
        print(draw(name, options.output))
    return 0
