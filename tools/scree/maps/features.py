"""Maps of geographic information systems: features, each a geometry with columns, of GeoJSON, CSV, GeoPackage and shapefiles.

GeoJSON and CSV are read by this module alone, and everything else by pyogrio with shapely, or by fiona.
"""
import csv
import json
import math
import pathlib
import re

import numpy as np

from .joint_map import JointMap, Section
from .layers import shown
from .shapes import Line, MapError, Point, rows_of

LAYER_COLUMNS = ("layer", "azimuth_set")     # whose values are names of layers: of a DXF by ogr2ogr, of fractopo
ERRORS_COLUMN = "validation_errors"          # of fractopo
DIP, DIP_DIRECTION, STRIKE = ("dip",), ("dip_direction", "dip_dir", "dipdir", "dipdirection"), ("strike",)
TRACE_COLUMNS = ("trace", "trace_id", "id", "fid", "line", "line_id")
WKT_COLUMNS = ("wkt", "geometry", "the_geom", "geom")
NESTING = {"Point": 0, "MultiPoint": 1, "LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
DEGREES = re.compile("CRS84|EPSG:+4326|EPSG:+4258|^GEOG(CS|CRS)", re.I)  # coordinate systems of longitude and latitude


class FeatureMap(JointMap):
    """The features of a file. The layer of a feature is its value in the column `by` (default: the first of LAYER_COLUMNS that is
    there), else the name of the file, or of the layer in the file."""

    def __init__(self, path, view, by=None):
        super().__init__(path, view)
        features, system = read_features(path)
        if system and DEGREES.search(system):
            raise MapError(f"{path}: expected coordinates that are lengths, found degrees ({shown(system)[:60]}): "
                           "project the map, as by ogr2ogr -t_srs")
        columns = {str(name).lower(): name for feature in features for name in feature.columns}
        column = columns.get(by.lower()) if by else next((columns[name] for name in LAYER_COLUMNS if name in columns), None)
        if by and column is None:
            raise MapError(f"{path}: expected a column '{shown(by)}' (--by), found "
                           + (", ".join(f"'{shown(name)}'" for name in columns.values()) or "no columns"))
        if column:
            self.noted.append(f"layers of {shown(pathlib.Path(path).name)} by the column '{shown(column)}'")
        self.failed = self.far = self.flat = 0
        for feature in features:
            value = feature.columns.get(column) if column else None
            name = feature.layer if value in (None, "") else f"{value:g}" if isinstance(value, float) else str(value)
            self.take(feature, name)
        self.areas = {layer for layer, held in self.held.items() if all("Polygon" in kind for kind, _ in held)}
        for count, what in ((self.failed, "traces that fractopo found invalid (VALIDATION_ERRORS)"),):
            self.warned += [f"{count} {what}"] if count else []
        for count, what in ((self.far, "features farther from the section than --reach"),
                            (self.flat, "features with dip and dip_direction that do not cross the section")):
            self.noted += [f"left out: {count} {what}"] if count else []

    def take(self, feature, name):
        """Takes the shapes of a feature to its layer."""
        layer = name.lower()
        self.names.setdefault(layer, name)
        errors = feature.of(ERRORS_COLUMN)
        self.failed += bool(re.search("[A-Za-z]", str(errors or "")))
        for kind, shapes in geometries(feature):
            if isinstance(shapes, str):
                self.held[layer].append((kind, shapes))
                continue
            dips = self.dips_of(feature) if isinstance(self.view, Section) else None
            if dips:
                lines = [line for shape in shapes if len(shape.rows) > 1 for line in self.view.trace(shape, *dips)]
                self.flat += not lines
                kept = lines
            else:
                kept = [self.view.of(shape) for shape in shapes]
                if isinstance(self.view, Section):
                    near = [shape for shape in kept if self.view.holds(shape)]
                    self.far += len(kept) > len(near)
                    kept = near
            if kept:
                self.held[layer].append((kind, kept))

    def dips_of(self, feature):
        """Dip and dip direction of a feature in degrees; None where it has no such columns. A strike is 90 degrees left of it."""
        dip, direction, strike = (feature.number(*names) for names in (DIP, DIP_DIRECTION, STRIKE))
        direction = strike + 90 if direction is None and strike is not None else direction
        if dip is None or direction is None:
            return None
        if not 0 <= dip <= 90:
            raise MapError(f"{feature.place}: expected a dip from 0 to 90 degrees, found {dip:g}")
        return dip, direction


class Feature:
    """A feature: where it stands in its file, the layer that it is of by default, its columns, its geometry as GeoJSON has it."""

    def __init__(self, place, layer, columns, geometry):
        self.place, self.layer, self.columns, self.geometry = place, layer, columns, geometry
        self.by_name = {str(name).lower(): value for name, value in columns.items()}

    def of(self, *names):
        """The value of the first of some columns that has one."""
        return next((self.by_name[name] for name in names if self.by_name.get(name) not in (None, "")), None)

    def number(self, *names):
        """The number in the first of some columns that has a value; None where there is none."""
        value = self.of(*names)
        try:
            found = None if value is None else float(value)
        except (TypeError, ValueError):
            found = math.nan
        if found is not None and not math.isfinite(found):
            raise MapError(f"{self.place}: expected a number of the column {names[0]}, found '{shown(value)}'")
        return found


def geometries(feature, geometry=None):
    """Kind and shapes of a feature, or kind and why there are none, of each part of a collection."""
    geometry = feature.geometry if geometry is None else geometry
    if geometry is None:
        return [("feature", "feature without a geometry")]
    kind = geometry.get("type") if isinstance(geometry, dict) else None
    if kind == "GeometryCollection":
        return [one for part in geometry.get("geometries") or [] for one in geometries(feature, part)]
    if kind not in NESTING:
        return [(str(kind), f"feature of the kind '{shown(kind)}'")]
    parts = [geometry.get("coordinates")]
    for _ in range(NESTING[kind] - 1):
        if not all(isinstance(part, (list, tuple)) for part in parts):
            raise MapError(f"{feature.place}: expected the coordinates of a {kind}, found others")
        parts = [one for part in parts for one in part]
    if kind in ("Point", "MultiPoint"):
        places = parts if kind == "Point" else parts[0]
        return [(kind, [Point(rows_of([place])) for place in places_of(feature, kind, places, 1).tolist()])]
    return [(kind, [Line(rows_of(places_of(feature, kind, part, 2).tolist())) for part in parts])]


def places_of(feature, kind, places, least):
    """Coordinates (n, 3) of at least so many places; heights that are not there are 0."""
    try:
        rows = [[float(number) for number in place] for place in places]
    except (TypeError, ValueError):
        raise MapError(f"{feature.place}: expected numbers as coordinates of a {kind}, found '{shown(places)[:60]}'") from None
    if len(rows) < least or any(len(row) < 2 for row in rows):
        raise MapError(f"{feature.place}: expected {'a place' if least == 1 else f'{least} places or more'} x y of a {kind}, found "
                       f"'{shown(places)[:60]}'")
    return np.array([(*row, 0.0)[:3] for row in rows])


def read_features(path):
    """The features of a file, and its coordinate system where it names one."""
    ending = pathlib.Path(path).suffix.lower()
    if ending in (".geojson", ".json"):
        return geojson_features(path)
    return csv_features(path) if ending in (".csv", ".txt") else vector_features(path)


def read_text(path, what):
    """The text of a file."""
    try:
        return pathlib.Path(path).read_text(encoding="utf-8-sig")
    except OSError as problem:
        raise MapError(f"{path}: expected {what}, found: {problem.strerror}") from None
    except UnicodeDecodeError:
        raise MapError(f"{path}: expected {what}, found no text in UTF-8") from None


def geojson_features(path):
    """Of GeoJSON (RFC 7946): a collection of features, a feature, or a geometry. The member `crs` of older files is the system."""
    try:
        whole = json.loads(read_text(path, "GeoJSON"))
    except (ValueError, RecursionError) as problem:
        raise MapError(f"{path}: expected GeoJSON, found: {shown(problem)}") from None
    layer = pathlib.Path(path).stem
    kind = whole.get("type") if isinstance(whole, dict) else None
    if kind == "FeatureCollection":
        members = whole.get("features")
    elif kind == "Feature":
        members = [whole]
    else:
        members = [{"type": "Feature", "geometry": whole}] if kind in (*NESTING, "GeometryCollection") else None
    if not isinstance(members, list):
        raise MapError(f"{path}: expected GeoJSON with features, found {shown(kind) if kind else 'no type of GeoJSON'}")
    features = []
    for number, member in enumerate(members, 1):
        if not isinstance(member, dict) or member.get("type") != "Feature":
            raise MapError(f"{path}: feature {number}: expected a feature, found '{shown(member)[:60]}'")
        columns = member.get("properties")
        features.append(Feature(f"{path}: feature {number}", layer, columns if isinstance(columns, dict) else {}, member.get("geometry")))
    system = whole.get("crs")
    named = system.get("properties") if isinstance(system, dict) else None
    return features, str(named.get("name") or "") if isinstance(named, dict) else ""


def csv_features(path):
    """Of a table of text. Its first line names columns: x1 y1 x2 y2 (a line a row), x y and a trace (a place a row), or WKT. Without
    names each row is a trace, x1 y1 x2 y2 x3 y3 and on."""
    text = read_text(path, "a table of traces")
    lines = [(number, line) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    if not lines:
        raise MapError(f"{path}: expected a table of traces, found an empty file")
    first, layer = lines[0][1], pathlib.Path(path).stem
    letter = next((letter for letter in "\t;," if letter in first), " ")
    rows = [(f"{path}:{number}", [cell.strip() for cell in next(csv.reader([line], delimiter=letter, skipinitialspace=True))])
            for number, line in lines]
    if all(is_number(cell) for cell in rows[0][1] if cell):
        features = [Feature(place, layer, {}, {"type": "LineString", "coordinates": pairs(place, [cell for cell in cells if cell])})
                    for place, cells in rows]
        return features, ""
    header = rows[0][1]
    return table_features(path, layer, header, [(place, dict(zip(header, cells, strict=False))) for place, cells in rows[1:]]), ""


def table_features(path, layer, header, rows):
    """Of rows of a table with named columns."""
    names = {name.lower(): name for name in header}
    wkt = next((names[name] for name in WKT_COLUMNS if name in names), None)
    trace = next((names[name] for name in TRACE_COLUMNS if name in names), None)
    if wkt:
        return [Feature(place, layer, row, of_wkt(place, row.get(wkt, ""))) for place, row in rows]
    if {"x1", "y1", "x2", "y2"} <= set(names):
        return [Feature(place, layer, row, {"type": "LineString", "coordinates": pairs(
            place, [row.get(names[name], "") for name in ("x1", "y1", "x2", "y2")])}) for place, row in rows]
    if not ({"x", "y"} <= set(names) and trace):
        raise MapError(f"{path}:1: expected the columns x1 y1 x2 y2, or x y and trace, or wkt, found {', '.join(map(shown, header))}")
    axes = [names[name] for name in ("x", "y", "z") if name in names]
    traces = {}
    for place, row in rows:
        traces.setdefault(row.get(trace), []).append((place, row))
    features = []
    for members in traces.values():
        places = [[number_of(place, row.get(axis, "")) for axis in axes] for place, row in members]
        geometry = {"type": "LineString" if len(places) > 1 else "Point", "coordinates": places if len(places) > 1 else places[0]}
        features.append(Feature(members[0][0], layer, members[0][1], geometry))
    return features


def is_number(cell):
    """Whether a cell of a table is a number."""
    try:
        return math.isfinite(float(cell))
    except ValueError:
        return False


def number_of(place, cell):
    """The number in a cell."""
    if not is_number(cell):
        raise MapError(f"{place}: expected a number, found '{shown(cell)}'")
    return float(cell)


def pairs(place, cells):
    """Places of cells x1 y1 x2 y2 and on."""
    if len(cells) < 4 or len(cells) % 2:
        raise MapError(f"{place}: expected x and y of two places or more, found {len(cells)} numbers")
    numbers = [number_of(place, cell) for cell in cells]
    return list(zip(numbers[::2], numbers[1::2]))


def of_wkt(place, text):
    """The geometry of well-known text (OGC 06-103r4), as GeoJSON has it."""
    found = re.fullmatch(r"\s*(?:SRID=\d+;)?\s*([A-Za-z]+)\s*(?:Z|M|ZM)?\s*(\(.*\))\s*", text, re.I | re.S)
    kind = {name.upper(): name for name in NESTING}.get(found[1].upper()) if found else None
    if kind is None:
        raise MapError(f"{place}: expected well-known text of a line, polygon or point, found '{shown(text)[:60]}'")
    def places(part):
        return "[" + ",".join("[" + ",".join(repr(float(number)) for number in one.split()) + "]" for one in part[1].split(",")) + "]"

    try:
        coordinates = json.loads(re.sub(r"\(\s*([^()]+?)\s*\)", places, found[2]).replace("(", "[").replace(")", "]"))
    except ValueError:
        raise MapError(f"{place}: expected numbers in the well-known text, found '{shown(text)[:60]}'") from None
    if kind == "MultiPoint" and isinstance(coordinates[0][0], list):
        coordinates = [one for part in coordinates for one in part]  # MULTIPOINT ((1 2), (3 4))
    return {"type": kind, "coordinates": coordinates[0] if kind == "Point" else coordinates}


def vector_features(path):
    """Of a GeoPackage, a shapefile or another file that GDAL reads."""
    if not pathlib.Path(path).is_file():
        raise MapError(f"{path}: expected a map, found no such file")
    for reader in (by_pyogrio, by_fiona):
        try:
            return reader(path)
        except ImportError:
            continue
    raise MapError(f"{path}: expected pyogrio with shapely, or fiona, to read {pathlib.Path(path).suffix}, found neither: "
                   "pip install 'scree[maps]', or on Debian apt-get install python3-fiona; GeoJSON and CSV need none")


def by_pyogrio(path):
    """The features of all layers of a file, by pyogrio."""
    import pyogrio
    import shapely.errors
    import shapely.geometry
    import shapely.wkb
    features, system = [], ""
    try:
        for layer in pyogrio.list_layers(path)[:, 0]:
            about, _, shapes, columns = pyogrio.raw.read(path, layer=layer)
            system = about["crs"] or system
            shapes = [None] * len(columns[0]) if shapes is None else shapes
            for number, (shape, *values) in enumerate(zip(shapes, *columns), 1):
                features.append(Feature(f"{path}: layer '{shown(layer)}', feature {number}", str(layer),
                                        dict(zip(about["fields"], map(plain, values))),
                                        None if shape is None else shapely.geometry.mapping(shapely.wkb.loads(shape))))
    except (pyogrio.errors.DataSourceError, pyogrio.errors.DataLayerError, shapely.errors.ShapelyError) as problem:
        raise MapError(f"{path}: expected a map that GDAL reads, found: {shown(problem)}") from None
    return features, system


def by_fiona(path):
    """The features of all layers of a file, by fiona."""
    import fiona
    features, system = [], ""
    try:
        for layer in fiona.listlayers(path):
            with fiona.open(path, layer=layer) as source:
                system = source.crs_wkt or system
                features += [Feature(f"{path}: layer '{shown(layer)}', feature {number}", str(layer), dict(member["properties"]),
                                     getattr(member["geometry"], "__geo_interface__", member["geometry"])) for number, member in enumerate(source, 1)]
    except (fiona.errors.FionaError, ValueError) as problem:
        raise MapError(f"{path}: expected a map that GDAL reads, found: {shown(problem)}") from None
    return features, system


def plain(value):
    """A value of numpy as one of Python; None for one that is missing."""
    value = value.item() if hasattr(value, "item") else value
    return None if isinstance(value, float) and math.isnan(value) else value
