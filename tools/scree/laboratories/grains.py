"""Writes grains that fill a rectangle, a disc or a notched beam as a block file, which an analysis deck names.

    tools/grains OUTLINE NUMBERS --size S -o FILE.blk [--mineral NAME=SHARE ...] [options]

OUTLINE and its NUMBERS are one of: rectangle WIDTH HEIGHT; disc DIAMETER; beam LENGTH HEIGHT NOTCH WIDTH, with a notch of this depth and
width in the middle of its foot; polygon X1 Y1 X2 Y2 .... Block materials are the minerals in their order. Joint material 1 is that of the
outline. The next ones are those of the pairs of minerals, of the first with itself and all others, then of the second, and so on; the
command prints them (doc/howto/laboratory.md). The same options give the same grains. Exit status 0; 2 for bad input.
"""
from __future__ import annotations

import itertools
import pathlib

from ..arguments import above_zero, check_ending, ends_in_a_line, parser_for, whole_from
from ..errors import ScreeError
from ..model import Model, arc
from ..model.geometry import Place
from ..model.grains import KINDS

ARC = 0.5   # of the size of a grain: about how long the sides of a disc are
COUNT = {"rectangle": 2, "disc": 1, "beam": 4}


def outline_of(kind: str, numbers: list[float], size: float) -> list[Place]:
    """Corners of an outline; ScreeError where its numbers are too many or too few."""
    if kind != "polygon" and len(numbers) != COUNT[kind]:
        raise ScreeError(f"{kind}: expected {COUNT[kind]} numbers, found {len(numbers)}")
    if kind == "polygon":
        if len(numbers) % 2:
            raise ScreeError(f"polygon: expected x and y of each corner, found {len(numbers)} numbers")
        return list(zip(numbers[::2], numbers[1::2]))
    if min(numbers) <= 0:
        raise ScreeError(f"{kind}: expected numbers above 0, found {min(numbers):g}")
    if kind == "disc":
        return arc((0, 0), numbers[0] / 2, sides=max(12, 4 * round(numbers[0] * 3.14 / (4 * ARC * size))))
    if kind == "rectangle":
        width, height = numbers
        return [(0, 0), (width, 0), (width, height), (0, height)]
    length, height, deep, wide = numbers
    if deep >= height or wide >= length:
        raise ScreeError(f"beam: expected a notch smaller than the beam, found {deep:g} x {wide:g} in {length:g} x {height:g}")
    return [(0, 0), ((length - wide) / 2, 0), ((length - wide) / 2, deep), ((length + wide) / 2, deep), ((length + wide) / 2, 0), (length, 0),
            (length, height), (0, height)]


def share(word: str) -> tuple[str, float]:
    """NAME=SHARE."""
    name, sign, value = word.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise ScreeError(f"--mineral: expected NAME=SHARE, found {word!r}") from None


@ends_in_a_line
def main() -> int:
    parser = parser_for(__doc__)
    parser.add_argument("outline", choices=[*COUNT, "polygon"], metavar="OUTLINE")
    parser.add_argument("numbers", type=float, nargs="+", metavar="NUMBERS")
    parser.add_argument("--size", type=above_zero, required=True, metavar="S", help="side of a square of the mean area of a grain")
    parser.add_argument("--mineral", action="append", default=[], metavar="NAME=SHARE", help="share of the area; repeated for each mineral")
    parser.add_argument("--kind", choices=KINDS, default="voronoi", help="whole cells, or cells cut to triangles; default: voronoi")
    parser.add_argument("--grading", type=float, default=0.0, metavar="G", help="spread of sizes over their mean; default: 0")
    parser.add_argument("--relax", type=whole_from(0), default=10, metavar="N", help="times that points move to the middles of their cells; default: 10")
    parser.add_argument("--least", type=float, default=0.2, metavar="L", help="shortest side of a cell over the size of cells; default: 0.2")
    parser.add_argument("--seed", type=whole_from(0), default=1, metavar="N", help="default: 1")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, metavar="FILE.blk")
    given = parser.parse_args()
    check_ending(given.output, "a block file", [".blk"])
    minerals = dict(map(share, given.mineral)) or {"rock": 1.0}
    model = Model(given.output.stem)
    for name in minerals:
        model.material(name, density=0, young=1)
    pairs = {pair: " and ".join(pair) for pair in itertools.combinations_with_replacement(minerals, 2)}
    for name in ("outline", *pairs.values()):
        model.joint_material(name)
    grains = model.grains("grain", outline_of(given.outline, given.numbers, given.size), given.size, minerals, pairs, "outline", given.kind,
                          given.grading, given.relax, given.least, given.seed)
    for block in model.geometry.blocks:
        block.name = ""
    given.output.write_text(model.geometry.text())
    areas = grains.areas()
    print(f"{given.output}: {len(areas)} grains, mean area {areas.mean():.6g}")
    for number, name in enumerate(minerals, 1):
        found = areas[[one == name for one in grains.minerals]].sum() / areas.sum()
        print(f"block material {number}: {name}, {100 * found:.1f} % of the area")
    for number, name in enumerate(model.joint_materials, 1):
        print(f"joint material {number}: {name}")
    return 0
