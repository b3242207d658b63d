"""Turns joint maps into a geometry deck (doc/drawings.md). tools/dxf2geo is another name of this command.

    tools/map MAP [...] [-o OUT.geo] [--layer NAME=ROLE ...] [--by COLUMN] [--clip X1 Y1 X2 Y2 [X3 Y3 ...]]
              [--plane xy|xz|yz | --section X1 Y1 X2 Y2 [--reach W]] [--snap S] [--extend L] [--close G] [--fixed X1 Y1 X2 Y2 ...]
              [--origin X Y] [--sagitta S] [--e0 0.001] [--least-area A] [--picture PICTURE.png]

MAP is a drawing (.dxf), GeoJSON (.geojson, .json), a table of traces (.csv, .txt), or what GDAL reads (.gpkg, .shp, ...). Several
files are one map. A layer is that of the drawing or file. Features of GeoJSON and the like are of the layer that their column COLUMN
names, by default "layer" or fractopo's "azimuth_set" where they have one; else of one layer by the name of the file.

The beginning of the name of a layer says what it holds, in capitals or not:

    BOUNDARY    boundary lines                  MEASURED    measured points
    MATERIAL    material lines, of the block    HOLE        hole points
                material at the end of the      any other   joint lines
                name (MATERIAL_2)
    FIXED       fixed lines and points          TUNNEL      outlines of what is cut out of the rock;
    LOAD        load points                     EXCAVATION  the same
    BOLT        bolts, a line each              WATER       the water table
    STAGE_2...  outlines of what stage 2 of a run removes; they are joint lines, too

Any other layer that holds polygons of features alone has boundary lines.

The number of a layer is that of a name that is one of these words, or JOINT, and a number (JOINT_3, joints 3, BOUNDARY-2), or a
number alone (3). It is the joint material of joint lines, boundary lines and tunnels. All other layers of these, such as
Survey_2019, get the numbers that are free, from 1, in order of name. --layer NAME=ROLE decides instead; ROLE is joint:N, boundary:N,
material:N, tunnel:N, stage:K, bolt:STIFFNESS[:STRENGTH[:PRETENSION]] (which bolts need), water, fixed, load, measured, hole or skip.

The boundary lines enclose the rock, and joints beyond the boundary make no block. Boundary lines and the outlines of tunnels and
stages must close: ends up to --close apart are joined; a drawing with ends farther apart is refused with their places.

--plane takes two coordinates of the drawing; xz and yz are for sections. The third coordinate is left out. --section takes the
vertical plane through a line of the map: x of the deck is the distance along the line, y the height. Lines no farther from it than
--reach are projected on it. A trace with the columns dip and dip_direction (or strike) becomes a line where it crosses the section,
downwards with the apparent dip, as long as the trace.

Ends of joint traces that meet no line are moved onto a trace not farther than --snap, or else extended in their direction to the
next trace where it is not farther than --extend (which may be inf). Without these options they are kept; the cutter leaves out what
bounds no block. --fixed adds a fixed line. --origin is taken off all coordinates; --clip and --fixed are in those of the map.

--clip takes a window, by two corners, or a polygon, by three or more; its sides bound the rock. Joints in tunnels are left out, and
tunnels get hole points where rock encloses them. The water table becomes the group &water at the end of the deck. --least-area, below
which blocks join a neighbour, becomes the group &blocks. OUT.stages has the groups &stage for the end of the analysis deck, which
remove what the layers STAGE enclose.

Lines are LINE, LWPOLYLINE, POLYLINE, ARC, CIRCLE, ELLIPSE and SPLINE; points are POINT and, on the layers of points and of what is
fixed, the centres of CIRCLE. INSERT is exploded. Curves become chords that are nowhere farther than the sagitta from them.
The deck lists layers in order of name, and within a layer keeps the order of the drawing.

Needs numpy; ezdxf for .dxf; pyogrio and shapely, or fiona, for what GDAL reads; shapely for tunnels, stages, a clip of boundary lines
and boundary lines that do not close; matplotlib for the picture.
"""
import math
import pathlib

import numpy as np

from ..arguments import above_zero, beside, check_ending, check_picture, ends_in_a_line, length_from_zero, parser_for, say
from .deck import Deck
from .features import FeatureMap
from .joint_map import DEFAULT_PLANE, Plane, Section
from .layers import chosen_roles
from .shapes import MapError

FEATURES = (".geojson", ".json", ".csv", ".txt", ".gpkg", ".shp", ".fgb", ".gml", ".kml", ".tab")


def read_maps(paths, view, by):
    """The map that some files are together. Layers of features are by the column `by`."""
    maps = []
    for path in paths:
        ending = pathlib.Path(path).suffix.lower()
        if ending in FEATURES:
            maps.append(FeatureMap(path, view, by))
        elif ending == ".dxf":
            try:
                from .dxf_drawing import Drawing  # here, as it needs ezdxf
            except ImportError:
                raise MapError(f"{path}: expected ezdxf to read a DXF file, found none: pip install ezdxf, or on Debian "
                               "apt-get install python3-ezdxf") from None
            maps.append(Drawing(path, view))
        else:
            raise MapError(f"{path}: expected a map with the ending .dxf, {', '.join(FEATURES)}, found '{ending}'")
    first, *others = maps
    for other in others:
        first.join(other)
    return first


def check_numbers(given):
    """MapError for an option whose numbers are out of range."""
    if not 0 <= given.e0 < 1:
        raise MapError(f"--e0: expected at least 0 and below 1, found {given.e0}")
    if given.sagitta is not None and not 0 < given.sagitta < math.inf:
        raise MapError(f"--sagitta: expected a length above 0, found {given.sagitta}")
    if given.clip and (len(given.clip) < 4 or len(given.clip) % 2 or not np.isfinite(given.clip).all()):
        raise MapError(f"--clip: expected x and y of two corners or more, found {' '.join(map(repr, given.clip))}")
    if not 0 <= given.least_area < math.inf:
        raise MapError(f"--least-area: expected an area from 0, found {given.least_area}")
    if given.close is not None and not 0 <= given.close < math.inf:
        raise MapError(f"--close: expected a length from 0, found {given.close}")
    if not np.isfinite([*given.origin, *(given.section or ()), *(number for line in given.fixed for number in line)]).all():
        raise MapError("--origin, --section, --fixed: expected finite numbers, found others")


@ends_in_a_line
@np.errstate(all="ignore")  # what is not finite is refused by name
def main():
    parser = parser_for(__doc__)
    parser.add_argument("maps", metavar="MAP", nargs="+")
    parser.add_argument("-o", "--output", metavar="OUT.geo", help="deck; default: the first map with .geo, beside it")
    parser.add_argument("--e0", type=float, default=0.001, help="least distance of edge and node, over the size; default: 0.001")
    parser.add_argument("--sagitta", type=float, metavar="S",
                        help="largest distance of a chord from its curve; default: 1e-3 of the drawing's extent")
    parser.add_argument("--layer", action="append", default=[], metavar="NAME=ROLE", help="role of a layer; may be repeated")
    parser.add_argument("--by", metavar="COLUMN", help="column of features whose value is their layer")
    parser.add_argument("--clip", type=float, nargs="+", default=[], metavar="X",
                        help="x and y of two corners of a window, or of three or more of a polygon")
    view = parser.add_mutually_exclusive_group()
    view.add_argument("--section", type=float, nargs=4, metavar=("X1", "Y1", "X2", "Y2"), help="line of the map, for its vertical plane")
    view.add_argument("--plane", choices=("xy", "xz", "yz"), default=DEFAULT_PLANE,
                      help="coordinates of the drawing that the deck takes; the third is left out; default: xy")
    parser.add_argument("--reach", type=above_zero, default=math.inf, metavar="W", help="largest distance of lines from the section; default: any")
    parser.add_argument("--snap", type=length_from_zero, default=0.0, metavar="S", help="largest distance by which an end of a trace is moved; default: 0")
    parser.add_argument("--extend", type=length_from_zero, default=0.0, metavar="L", help="largest distance by which one is extended; default: 0")
    parser.add_argument("--fixed", type=float, nargs=4, action="append", default=[], metavar=("X1", "Y1", "X2", "Y2"),
                        help="a fixed line; may be repeated")
    parser.add_argument("--origin", type=float, nargs=2, default=(0.0, 0.0), metavar=("X", "Y"), help="taken off all coordinates; default: 0 0")
    parser.add_argument("--close", type=float, metavar="G",
                        help="largest gap of an outline whose ends are joined; default: 1.25 e0 w0")
    parser.add_argument("--least-area", type=float, default=0.0, metavar="A", help="of a block: a smaller one joins its neighbour")
    parser.add_argument("--picture", metavar="PICTURE.png", help="picture of the map as the deck has it")
    given = parser.parse_args()
    check_numbers(given)
    output = pathlib.Path(given.output or beside(given.maps[0], ".geo"))
    if output.resolve() in [pathlib.Path(path).resolve() for path in given.maps]:
        raise MapError(f"{output}: expected another name than the map's for the deck (-o), found the same")
    check_ending(output, "a deck", (".geo",))
    if given.picture:
        check_picture(pathlib.Path(given.picture))
    joined = read_maps(given.maps, Section(given.section[:2], given.section[2:], given.reach) if given.section else Plane(given.plane), given.by)
    deck = Deck(joined, chosen_roles(given.layer, joined), given.e0, given.sagitta, given.clip, given.least_area, given.close, given.origin,
                given.snap, given.extend, given.fixed)
    try:
        output.write_text(deck.text(), encoding="utf-8")
        if deck.removed:
            output.with_suffix(".stages").write_text(deck.stages(), encoding="utf-8")
    except OSError as error:
        raise MapError(f"{output}: cannot write the deck: {error.strerror}") from None
    if given.picture:
        from .picture import draw  # here, as matplotlib takes a second to begin
        draw(deck, given.picture)
    for line in deck.mapping():
        print(line)
    for line in deck.warnings():
        say(f"warning: {joined.path}: {line}")
    print(*([given.picture] if given.picture else []), *([output.with_suffix(".stages")] if deck.removed else []), output, sep="\n")
    return 0
