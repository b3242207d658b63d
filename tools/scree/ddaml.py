"""Writes files of DDAML, the XML of the program ntdda, as a geometry deck and an analysis deck (doc/drawings.md).

    tools/ddaml2deck FILE.geo FILE.ana [-o STEM]

The files hold a Geometry and an Analysis; either may be missing, or one file may hold both. STEM.geo and STEM.ana are written, by
default in the folder of the first file with its name and _deck; STEM.ana names STEM.geo. Elements that have no number in the decks, such as
a record of the ground, are named in warnings where they would change the run, and left out. Load points whose force changes need a
table, which counts the fixed points; with fixed lines such a file is refused.

Materials are numbered in the order of the file, as ntdda numbers them. The stiffness of contact is that of Autopenalty: its factor times the largest
Young's modulus. Contact, time integration and fixed points are those of scree; &method preset='shi' / takes those of Shi's program.

Needs the standard library of Python alone. Source of the format: the parsers src/geomddaml.c and src/analysisddaml.c of ntdda.
"""
import math
import pathlib
import re
import xml.etree.ElementTree as ElementTree

from .arguments import ends_in_a_line, parser_for, say
from .errors import ScreeError

PREFIX = re.compile(rb"(</?)[A-Za-z_][\w.-]*:(?=[A-Za-z])")  # of names, as in <Berkeley:Geometry>, whose namespace means nothing here
DEFAULT_E0 = 0.01  # of ntdda, where a file has no Edgenodedist
HARMLESS = {"Mintimestep", "Opencloselimit", "OCLimit", "AConstants", "Writevertices"}  # limits and constants of ntdda's own algorithm
ROTATIONS = {"linear": "", "exact": "exact", "secondorder": "exact"}  # ntdda takes the exact rotation for that of second order


class DdamlError(ScreeError):
    """One line for the user."""


class Part:
    """The Geometry or the Analysis of a file, with its elements by name."""

    def __init__(self, path, root):
        self.path, self.root, self.taken = path, root, set()

    def all(self, *names):
        """The elements at a path of names, in order."""
        self.taken.add(names[0])
        return self.root.findall("/".join(names))

    def one(self, name):
        """The last element of a name, as ntdda reads them; None where there is none."""
        found = self.all(name)
        return found[-1] if found else None

    def attribute(self, name, key, default=None):
        """A number that an element has as an attribute. Without a default the element is needed."""
        element = self.one(name)
        if element is None and default is not None:
            return default
        text = None if element is None else element.get(key)
        return self.numbers(f"{key} of {name}", text, 1)[0]

    def numbers(self, what, text, count):
        """So many finite numbers of a text."""
        try:
            found = [float(word) for word in (text or "").replace(",", " ").split()]
        except ValueError:
            found = []
        if len(found) != count or not all(map(math.isfinite, found)):
            raise DdamlError(f"{self.path}: expected {count} number{'s' * (count > 1)} ({what}), found "
                             f"'{' '.join((text or '').split())[:60]}'")
        return found

    def rows(self, count, *names):
        """Numbers of the elements at a path of names."""
        return [self.numbers(names[-1] + " of " + names[0], element.text, count) for element in self.all(*names)]

    def is_on(self, name):
        """Whether an element has the flag yes."""
        element = self.one(name)
        return element is not None and element.get("flag") == "yes"

    def left_out(self):
        """Names of elements that nothing has taken."""
        names = dict.fromkeys(child.tag for child in self.root if isinstance(child.tag, str))
        return [name for name in names if name not in self.taken | HARMLESS]


def read_parts(paths):
    """The Geometry and the Analysis of files; None where there is none."""
    parts = {"Geometry": None, "Analysis": None}
    for path in paths:
        try:
            root = ElementTree.fromstring(PREFIX.sub(rb"\1", pathlib.Path(path).read_bytes()))
        except ElementTree.ParseError as error:
            raise DdamlError(f"{path}:{error.position[0]}: expected DDAML, the XML of ntdda, found: {error.msg}") from None
        if root.tag != "DDA":
            raise DdamlError(f"{path}: expected DDAML with the root DDA, found '{root.tag}'")
        for name in parts:
            found = root.find(name)
            if found is None:
                continue
            if parts[name] is not None:
                raise DdamlError(f"{path}: expected one {name} in all files, found another")
            parts[name] = Part(path, found)
    if not any(parts.values()):
        raise DdamlError(f"{paths[0]}: expected a Geometry or an Analysis, found neither")
    return parts["Geometry"], parts["Analysis"]


def kind_of(part, element, what):
    """The number from 1 that an element has as its type."""
    number = part.numbers(f"type of {what}", element.get("type"), 1)[0]
    if number != int(number) or number < 1:
        raise DdamlError(f"{part.path}: expected a whole number from 1 (type of {what}), found '{element.get('type')}'")
    return int(number)


def bolt_rows(part, analysis):
    """Ends, stiffness, strength and pretension of the bolts. The Analysis has those three, once for all."""
    ends = part.rows(4, "Boltlist", "Bolt")
    properties = [analysis.numbers("a Boltproperties", element.text, 3) for element in analysis.all("Boltproperties")] if analysis else []
    if ends and len(properties) != 1:
        raise DdamlError(f"{part.path}: expected one Boltproperties for the bolts, in an Analysis beside this Geometry, "
                         f"found {len(properties)}")
    return [[*line, *properties[0]] for line in ends]


def geometry_text(part, analysis):
    """The geometry deck."""
    lines = [[*part.numbers("a Joint of Jointlist", joint.text, 4), kind_of(part, joint, "a Joint")]
             for joint in part.all("Jointlist", "Joint")]
    if not lines:
        raise DdamlError(f"{part.path}: expected a Joint in the Jointlist, found none")
    materials = [[*part.numbers("a Line of Matlinelist", line.text, 4), kind_of(part, line, "a Line of Matlinelist")]
                 for line in part.all("Matlinelist", "Line")]
    bolts = bolt_rows(part, analysis)
    fixed = [row * 2 if len(row) == 2 else row for row in fixed_rows(part)]  # a point is a line with equal ends
    loads, measured, holes = (part.rows(2, f"{kind}pointlist", "Point") for kind in ("Load", "Measured", "Hole"))
    heads = [(part.attribute("Edgenodedist", "distance", DEFAULT_E0), "least distance of edge and node, over the size (e0)"),
             (f"{len(lines)} 0", "lines, boundary lines")]
    heads += [(len(rows), what) for rows, what in ((materials, "material lines"), (bolts, "bolts"), (fixed, "fixed lines"),
                                                   (loads, "load points"), (measured, "measured points"), (holes, "hole points"))]
    rows = [row for rows in (lines, materials, bolts, fixed, loads, measured, holes) for row in rows]
    return (f"! From {part.path.name}, DDAML\n" + "".join(f"{number!s:<12} ! {what}\n" for number, what in heads)
            + "".join(" ".join(map(str, row)) + "\n" for row in rows))


def fixed_rows(part):
    """Two numbers of each fixed point and four of each fixed line, in the order of the file."""
    return [part.numbers(f"a {element.tag} of Fixedpointlist", element.text, 2 if element.tag == "Point" else 4)
            for element in part.all("Fixedpointlist", "*") if element.tag in ("Point", "Line")]


def block_material(part, element):
    """The four rows of a block material: density, weight, E, nu; stress and its increase; velocity."""
    def child(name, count, default=None):
        found = element.find(name)
        if found is None and default:
            return default
        return part.numbers(f"{name} of Blockmaterial", None if found is None else found.text, count)

    first = [child(name, 1)[0] for name in ("Unitmass", "Unitweight", "Youngsmod", "Poissonratio")]
    return [first, child("Istress", 3, [0.0] * 3), [0.0] * 3, child("Ivelocity", 3, [0.0] * 3)]


def load_tables(part):
    """Rows t fx fy of each load point."""
    tables = []
    for element in part.all("Loadpointlist", "Loadpoint"):
        tables.append([part.numbers("t fx fy of a Loadpoint", row, 3) for row in (element.text or "").split(";") if row.strip()])
        if not tables[-1]:
            raise DdamlError(f"{part.path}: expected rows t fx fy; in each Loadpoint, found none")
    return tables


def analysis_text(part, geometry, geometry_name):
    """The analysis deck, in the short order where the loads are constant, else in Shi's."""
    blocks = [block_material(part, element) for element in part.all("Blockmaterial")]
    joints = [[part.numbers(f"{name} of Jointproperties", element.findtext(name), 1)[0] for name in ("Friction", "Cohesion", "Tensile")]
              for element in part.all("Jointproperties")]
    if not blocks or not joints:
        raise DdamlError(f"{part.path}: expected a Blockmaterial and Jointproperties, found {len(blocks)} and {len(joints)}")
    kind = part.one("Analysistype")
    dynamic = (part.root if kind is None else kind).get("type") == "dynamic"
    tables = load_tables(part)
    varying = any(row[1:] != table[0][1:] for table in tables for row in table)
    steps = part.attribute("Numtimesteps", "timesteps")
    numbers = [[int(dynamic)], [int(steps)], [len(blocks)], [len(joints)],
               [part.attribute("Maxdisplacement", "maxdisplacement", 0.01)], [part.attribute("Maxtimestep", "maxtimestep")]]
    named = f"geometry='{geometry_name}', " if geometry_name else ""
    groups = [f"&deck {named}dialect='{'shi' if varying else 'short'}' /"]
    penalty = part.one("Autopenalty")
    factor = 0.0 if penalty is None or penalty.get("pfactor") is None else part.attribute("Autopenalty", "pfactor")
    stiffness = factor * max(rows[0][2] for rows in blocks)
    if varying:
        numbers += [[stiffness], *shi_tables(part, geometry, tables)]
    else:
        if stiffness > 0:
            groups.append(f"&contact stiffness={stiffness} /")
        if tables:
            groups.append("&loads force=" + "  ".join(f"{table[0][1]} {table[0][2]}" for table in tables) + " /")
    groups += groups_of_flags(part)
    rows = [*numbers, *(row for rows in blocks for row in rows), *joints]
    return (f"! From {part.path.name}, DDAML\n" + "".join(" ".join(map(str, row)) + "\n" for row in rows)
            + "".join(f"{group}\n" for group in groups))


def shi_tables(part, geometry, tables):
    """Rows of Shi's order: counts of times of the fixed points and load points, then the times."""
    fixed = [] if geometry is None else fixed_rows(geometry)
    if geometry is None or any(len(row) == 4 for row in fixed):
        raise DdamlError(f"{part.path}: expected a Geometry with fixed points alone beside a Loadpoint whose force changes, as the table "
                         "counts fixed points, found " + ("none" if geometry is None else "a fixed Line"))
    return [[0] * len(fixed) + [len(table) for table in tables], *(row for table in tables for row in table)]


def groups_of_flags(part):
    """Groups for the elements that are a flag or a word."""
    groups, method = [], []
    rotation = part.one("Rotation")
    word = "linear" if rotation is None else rotation.get("type")
    if word not in ROTATIONS:
        raise DdamlError(f"{part.path}: expected {', '.join(ROTATIONS)} (type of Rotation), found '{word}'")
    if ROTATIONS[word]:
        method.append(f"strain='small', rotation='{ROTATIONS[word]}'")
    if part.is_on("Planestrain"):
        method.append("plane='strain'")
    if method:
        groups.append(f"&method {', '.join(method)} /")
    if part.is_on("Autotimestep"):
        groups.append("&step control='shi' /")
    if part.is_on("Autopenalty"):
        groups.append("&contact adapt='shi' /")
    every = part.one("Saveinterval")
    if every is not None:
        groups.append(f"&output every={max(1, int(part.attribute('Saveinterval', 'step')))} /")
    return groups


def differences(part):
    """What the decks leave out and ntdda would act on."""
    if part is None:
        return []
    said = []
    for element in part.all("Blockmaterial"):
        for name in ("Damping", "Istrain"):
            if any(float(word) != 0 for word in (element.findtext(name) or "").split()):
                said.append(f"{name} of a Blockmaterial")
    if part.is_on("Gravity"):
        said.append("Gravity, which lets the weight grow: &gravity ramp= does")
    return said + part.left_out()


@ends_in_a_line
def main():
    parser = parser_for(__doc__)
    parser.add_argument("files", nargs="+", metavar="FILE", help="with a Geometry, an Analysis or both")
    parser.add_argument("-o", "--output", metavar="STEM", help="of the decks; default: that of the first file and _deck")
    given = parser.parse_args()
    paths = [pathlib.Path(name) for name in given.files]
    geometry, analysis = read_parts(paths)
    stem = pathlib.Path(given.output) if given.output else paths[0].with_name(paths[0].stem + "_deck")
    texts = {}
    if geometry:
        texts[stem.with_name(stem.name + ".geo")] = geometry_text(geometry, analysis)
    if analysis:
        texts[stem.with_name(stem.name + ".ana")] = analysis_text(analysis, geometry, f"{stem.name}.geo" if geometry else "")
    for path in texts:
        if path.resolve() in [given.resolve() for given in paths]:
            raise DdamlError(f"{path}: expected another name than that of the DDAML for a deck (-o), found the same")
    for part in (geometry, analysis):
        for what in differences(part):
            say(f"warning: {part.path}: left out: {what}")
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")
        print(path)
    return 0
