"""A joint map as it was read: the shapes of each layer, and the plane that a deck takes of them."""
import collections
import dataclasses
import math

import numpy as np

from .shapes import Line, MapError, rows_of

DEFAULT_PLANE = "xy"
ON_EDGE = 100.0   # height over width of a drawing from which on it stands on the plane, within 0.6 degrees of upright
VERTICAL = 1e-12  # largest share of a direction along the section, of a plane that stands across it


class JointMap:
    """What each layer of a map holds, by a key that is the same in capitals or not. `path` names its files in messages.

    Shapes are turned so that the two coordinates of the view come first. The third is the height, which a deck leaves out."""

    def __init__(self, path, view):
        self.files, self.view = [str(path)], view
        self.names = {}                              # names of layers as written
        self.hidden = collections.Counter()          # entities by layer and why
        self.held = collections.defaultdict(list)    # kind and shapes by layer, or kind and why there are none
        self.areas = set()                           # layers that hold outlines of areas alone
        self.on_paper = 0                            # entities in the paper space of a drawing
        self.noted = []                              # what the deck says of the file
        self.warned = []

    @property
    def path(self):
        return ", ".join(self.files)

    def join(self, other):
        """Takes the layers of another map as well."""
        self.files += other.files
        for layer, held in other.held.items():
            areas = layer in other.areas and (layer in self.areas or layer not in self.held)
            (self.areas.add if areas else self.areas.discard)(layer)
            self.held[layer] += held
        self.names = {**other.names, **self.names}
        self.hidden += other.hidden
        self.on_paper += other.on_paper
        self.noted += other.noted
        self.warned += other.warned


@dataclasses.dataclass(frozen=True)
class Plane:
    """Two of the coordinates x, y and z, in this order; the third is left out."""
    axes: str = DEFAULT_PLANE

    def of(self, shape):
        """The shape with the coordinates of the plane in front."""
        return shape.in_plane(self.axes)

    def left_out(self, low, high):
        """What the deck says of coordinates that it leaves out, which reach from low to high."""
        return f"heights left out: {self.across} from {low:.6g} to {high:.6g}, projected on the plane {self.axes} (--plane)"

    def refusal(self, places, width_of):
        """What is wrong with places x y z (n, 3), as the plane has them, that stand on it: the plane that takes them. None for others."""
        low, high = places[:, 2].min(), places[:, 2].max()
        if high - low <= ON_EDGE * width_of(places[:, :2]):
            return None
        order = self.axes + self.across
        other = max((pair for pair in ("xy", "xz", "yz") if pair != self.axes),
                    key=lambda pair: width_of(places[:, [order.index(one) for one in pair]]))
        return (f"expected a drawing in the plane {self.axes}, found one that stands on it, {width_of(places[:, :2]):.6g} wide "
                f"with {self.across} from {low:.6g} to {high:.6g}: --plane {other} takes {other[0]} and {other[1]} of it")

    @property
    def across(self):
        """The coordinate that is left out."""
        return min(set("xyz") - set(self.axes))


class Section:
    """The vertical plane through a line from x1 y1 to x2 y2 of the map. A deck has the distance along the line as x, the height as y."""

    def __init__(self, start, end, reach=math.inf):
        self.start, self.length, self.reach = np.array(start, float), math.dist(start, end), reach
        if not self.length > 0:
            raise MapError(f"--section: expected two places that are apart, found {start[0]!r} {start[1]!r} twice")
        self.way = (np.array(end, float) - self.start) / self.length

    def of(self, shape):
        """The shape with the distance along the line, the height and the distance to the left of the line."""
        (tx, ty), normal = self.way, np.array([-self.way[1], self.way[0]])
        return shape.moved(np.array([[tx, 0, normal[0], 0], [ty, 0, normal[1], 0], [0, 1, 0, 0],
                                     [-self.way @ self.start, 0, -normal @ self.start, 1]]))

    def holds(self, shape):
        """Whether a shape, as the section has it, comes as near to the section as its reach."""
        off = shape.rows[:, 2][shape.rows[:, 3] != 0]
        return off.min() <= self.reach and off.max() >= -self.reach

    def trace(self, shape, dip, dip_direction):
        """Lines of the section where a plane of a dip and a dip direction (degrees; clockwise from y) meets it, from each crossing of
        the section line with the plane's trace on the map, downwards, as long as the trace.

        tan(apparent dip) = tan(dip) cos(angle from the section to the dip direction), as of Ragan, Structural Geology (2009), 1.8."""
        rows = self.of(shape).rows
        along = math.degrees(math.atan2(*self.way))  # clockwise from y
        down = np.array([math.cos(math.radians(dip)), -math.sin(math.radians(dip)) * math.cos(math.radians(dip_direction - along))])
        if math.hypot(*down) <= VERTICAL:  # the section runs along the strike of an upright plane
            return []
        down *= (1 if down[1] < 0 else -1) * float(np.hypot(*np.diff(rows[:, [0, 2]], axis=0).T).sum()) / math.hypot(*down)
        lines = []
        for (s1, z1, n1, _), (s2, z2, n2, _) in zip(rows, rows[1:]):
            if (n1 > 0) != (n2 > 0):
                share = n1 / (n1 - n2)
                top = np.array([s1 + share * (s2 - s1), z1 + share * (z2 - z1)])
                if 0 <= top[0] <= self.length:
                    lines.append(Line(rows_of([(*top, 0.0), (*(top + down), 0.0)])))
        return lines

    def left_out(self, low, high):
        """What the deck says of distances from the section, which reach from low to high."""
        return f"section: lines lie from {0 - high:.6g} to {0 - low:.6g} to the right of it, and are projected on it (--section)"

    def refusal(self, places, width_of):
        """What is wrong with lines that have one height; None for others."""
        if np.ptp(places[:, 1]) > 0:
            return None
        return "expected heights of lines, or columns dip and dip_direction of traces, for --section, found lines of one height"
