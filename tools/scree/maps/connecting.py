"""Ends of joint traces that lie in the rock: moved onto a trace nearby, or extended to the next one.

An end is loose where no other line comes nearer than the distance at which the cutter takes an end and a line for one.
Needs numpy alone.
"""
import collections
import dataclasses
import math

import numpy as np

from .rock import holds

AHEAD = 1e-9  # of the length of a line: a crossing nearer than that is its end


@dataclasses.dataclass
class Ends:
    """What became of the ends of joint traces. Places are x y; rows of `added` are lines x1 y1 x2 y2."""
    meeting: int = 0
    outside: int = 0
    moved: list = dataclasses.field(default_factory=list)     # lengths
    added: list = dataclasses.field(default_factory=list)
    loose: list = dataclasses.field(default_factory=list)

    def text(self):
        """Lines that say it."""
        added = [math.dist(row[:2], row[2:]) for row in self.added]
        text = f"ends of joint traces: {self.meeting} meet a line"
        if self.moved:
            text += f", {len(self.moved)} were moved onto one by {max(self.moved):.6g} or less (--snap)"
        if added:
            text += f", {len(added)} were extended to one by {max(added):.6g} or less, {sum(added):.6g} in all (--extend)"
        text += f", {len(self.loose)} lie in the rock"
        return text + (f", {self.outside} outside of it" if self.outside else "")


def traces_of(lines):
    """The trace (a number) of each line x1 y1 x2 y2: lines that share an end where no third one ends are of one trace. And the ends
    (line, 0 or 1) that no other line shares."""
    at = collections.defaultdict(list)
    for row, line in enumerate(lines):
        for end in (0, 1):
            at[tuple(line[2 * end:2 * end + 2])].append((row, end))
    first = list(range(len(lines)))

    def root(row):
        while first[row] != row:
            first[row] = first[first[row]]
            row = first[row]
        return row

    for members in at.values():
        if len(members) == 2:
            first[root(members[0][0])] = root(members[1][0])
    return np.array([root(row) for row in range(len(lines))], int), sorted(members[0] for members in at.values() if len(members) == 1)


class Lines:
    """Lines x1 y1 x2 y2 (n, 4) by the boxes around them, so that few are looked at closely."""

    def __init__(self, rows):
        self.rows = rows
        self.low, self.high = np.minimum(rows[:, :2], rows[:, 2:]).T.copy(), np.maximum(rows[:, :2], rows[:, 2:]).T.copy()

    def move(self, row, end, place):
        """Moves an end (0 or 1) of a line."""
        self.rows[row, 2 * end:2 * end + 2] = place
        ends = self.rows[row].reshape(2, 2)
        self.low[:, row], self.high[:, row] = ends.min(0), ends.max(0)

    def near(self, low, high):
        """Which lines have a box that meets the box from low to high."""
        in_x = np.flatnonzero((self.low[0] <= high[0]) & (self.high[0] >= low[0]))
        return in_x[(self.low[1][in_x] <= high[1]) & (self.high[1][in_x] >= low[1])]


def nearest_on(place, lines):
    """The place on lines (n, 4) that is nearest to a place, and its distance, which is infinite where there is no line."""
    if not len(lines):
        return place, math.inf
    start, way = lines[:, :2], lines[:, 2:] - lines[:, :2]
    share = np.clip(((place - start) * way).sum(1) / (way * way).sum(1), 0, 1)
    on = start + share[:, None] * way
    far = np.hypot(*(on - place).T)
    return on[far.argmin()], float(far.min())


def way_to(place, way, lines):
    """How far from a place along a direction of length 1 each line (n, 4) is; infinity where it is not met."""
    start, along = lines[:, :2] - place, lines[:, 2:] - lines[:, :2]
    turn = way[0] * along[:, 1] - way[1] * along[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        far = (start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0]) / turn
        share = (start[:, 0] * way[1] - start[:, 1] * way[0]) / turn
    return np.where((turn != 0) & (far > 0) & (share >= 0) & (share <= 1), far, math.inf)


def connect(joints, others, boundary, within, snap, extend):
    """Joint lines (rows x1 y1 x2 y2 and more) whose loose ends are moved by at most `snap` onto a line of another trace, or else
    extended by at most `extend` in their direction to the first line of another trace; and the Ends. `others` are lines that a trace
    may end at as well, of which `boundary` (n, 4) enclose the rock where there are any. `within` is the distance at which an end meets
    a line as it is."""
    everything = Lines(np.array([line[:4] for line in [*joints, *others]], float).reshape(-1, 4))
    as_drawn = Lines(everything.rows.copy())
    trace, free = traces_of(as_drawn.rows.tolist())
    ends, loose = Ends(), []
    for row, end in free:
        if row >= len(joints):
            continue
        place = as_drawn.rows[row, 2 * end:2 * end + 2]
        close = everything.near(place - max(within, snap), place + max(within, snap))
        on, far = nearest_on(place, everything.rows[close[trace[close] != trace[row]]])
        if far <= within:
            ends.meeting += 1
        elif far <= snap:
            ends.moved.append(far)
            everything.move(row, end, on)
        elif len(boundary) and not holds(boundary, place[None])[0]:
            ends.outside += 1
        else:
            loose.append((row, end))
    for row, end in loose:
        place, start = as_drawn.rows[row, 2 * end:2 * end + 2], as_drawn.rows[row, 2 - 2 * end:4 - 2 * end]
        length = math.dist(place, start)
        way = (place - start) / length
        most = place + np.where(way == 0, 0.0, min(extend, np.finfo(float).max) * way)
        close = as_drawn.near(np.minimum(place, most), np.maximum(place, most)) if extend > 0 else np.empty(0, int)
        far = way_to(place, way, as_drawn.rows[close[trace[close] != trace[row]]])
        nearest = min(far[far > AHEAD * length], default=math.inf)
        if nearest <= extend and nearest < math.inf:
            everything.rows[row, 2 * end:2 * end + 2] = place + nearest * way
            ends.added.append([*map(float, place), *map(float, place + nearest * way)])
        else:
            ends.loose.append([*map(float, place)])
    return [[*place, *line[4:]] for place, line in zip(everything.rows[:len(joints)].tolist(), joints)], ends
