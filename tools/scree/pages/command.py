"""Makes one page of a results file: what the run came to, its frames to play, histories, energy, cost, decks.

    tools/report RESULTS.h5 [-o PAGE.html] [--title TITLE] [--project PROJECT] [--note NOTE] [--units m,MPa=1e6,s]

What was found comes first: measured points, closures, bolts, reactions; then what is modelled and its numbers. How it was computed is folded.

The page needs no network and no other file. Any browser of 2023 or later shows it: frames are drawn in it, with zoom, and any field,
vectors, states of joints and forces of contacts over the blocks.

Needs Debian's python3-numpy, python3-h5py and python3-matplotlib.
"""
import pathlib

from ..arguments import beside, check_ending, ends_in_a_line, parser_for
from ..errors import PlotError
from ..drawing import Frames, kind_of
from ..units import Units, add_units, units_of_deck
from .page import page_of


def write_page(path, output, units=None, title=None, project="", note=""):
    """Writes the page of a results file, in units such as m,MPa=1e6,s; returns its path. PlotError where it cannot."""
    check_ending(output, "a page", (".html", ".htm"))
    if kind_of(path) != "results":
        raise PlotError(f"{path}: expected a results file, found another")
    frames = Frames(path, pathlib.Path(path).stem)
    text = page_of(frames, Units(units or units_of_deck(frames.file)), title, project, note)
    try:
        output.write_text(text, encoding="utf-8")
    except OSError as problem:
        raise PlotError(f"{output}: cannot write the page: {problem.strerror}") from None
    return output


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("file", type=pathlib.Path, metavar="RESULTS")
    parser.add_argument("-o", "--output", type=pathlib.Path, metavar="PAGE", help="default: the file with .html")
    parser.add_argument("--title", help="default: the first sentence of the opening comment of the analysis deck")
    parser.add_argument("--project", default="", help="a line below the title")
    parser.add_argument("--note", default="", help="a paragraph below that")
    add_units(parser)
    given = parser.parse_args()
    output = given.output or beside(given.file, ".html")
    print(write_page(given.file, output, given.units, given.title, given.project, given.note))
    return 0
