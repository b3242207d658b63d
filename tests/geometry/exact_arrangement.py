"""What line segments enclose, in rational numbers: no rounding, no tolerance."""
import functools
import math
from fractions import Fraction


def turn(a, b, c):
    """Twice the area of a triangle, positive counter-clockwise."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def lengthened(segments, by):
    """The segments, longer at both ends."""
    longer = []
    for s in segments:
        length = math.dist(s[:2], s[2:])
        if length > 0:
            x, y = [Fraction(by * (b - a) / length) for a, b in zip(s[:2], s[2:])]
            longer.append((s[0] - x, s[1] - y, s[2] + x, s[3] + y))
    return longer


def edges_of(segments):
    """The segments cut where they meet: pairs of places, each pair once, its lower end first."""
    ends = [((Fraction(s[0]), Fraction(s[1])), (Fraction(s[2]), Fraction(s[3]))) for s in segments if s[:2] != s[2:]]
    on = [set(pair) for pair in ends]
    for i, (a, b) in enumerate(ends):
        for j, (c, d) in enumerate(ends[:i]):
            if any(max(a[k], b[k]) < min(c[k], d[k]) or max(c[k], d[k]) < min(a[k], b[k]) for k in (0, 1)):
                continue
            of_c, of_d, of_a, of_b = turn(a, b, c), turn(a, b, d), turn(c, d, a), turn(c, d, b)
            if of_c == 0 and of_d == 0:  # on one line
                on[i] |= {p for p in (c, d) if min(a, b) <= p <= max(a, b)}
                on[j] |= {p for p in (a, b) if min(c, d) <= p <= max(c, d)}
            elif of_c * of_d <= 0 and of_a * of_b <= 0:
                share = of_a / (of_a - of_b)
                place = (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))
                on[i].add(place)
                on[j].add(place)
    edges = set()
    for places in on:
        row = sorted(places)
        edges |= set(zip(row, row[1:]))
    return edges


def neighbours_around(edges):
    """The other ends of the edges at each place, counter-clockwise."""
    found = {}
    for p, q in edges:
        found.setdefault(p, []).append(q)
        found.setdefault(q, []).append(p)

    def before(o, a, b):
        upper = [p[1] > o[1] or (p[1] == o[1] and p[0] > o[0]) for p in (a, b)]
        if upper[0] != upper[1]:
            return 1 if upper[0] else -1
        return -1 if turn(o, a, b) > 0 else 1

    return {o: sorted(places, key=functools.cmp_to_key(functools.partial(before, o))) for o, places in found.items()}


def cycles_of(edges):
    """Cycles of directed edges with the same face on their left, and twice the area of each."""
    around = neighbours_around(edges)
    place_in = {o: {q: i for i, q in enumerate(places)} for o, places in around.items()}
    seen, cycles, areas = set(), [], []
    for o, places in around.items():
        for q in places:
            if (o, q) in seen:
                continue
            cycle, p = [], (o, q)
            while p not in seen:
                seen.add(p)
                cycle.append(p)
                p = (p[1], around[p[1]][place_in[p[1]][p[0]] - 1])
            cycles.append(cycle)
            areas.append(sum(a[0] * b[1] - a[1] * b[0] for a, b in cycle))
    return cycles, areas


def enclosed_area(segments):
    """Area of all bounded faces together."""
    edges = edges_of(segments)
    cycles, areas = cycles_of(edges)
    outlines = [(cycle, -area) for cycle, area in zip(cycles, areas) if area < 0]  # of connected parts, from outside

    def is_inside(place, cycle):
        inside = False
        for a, b in cycle:
            if (a[1] > place[1]) != (b[1] > place[1]) and \
                    a[0] + (place[1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1]) > place[0]:
                inside = not inside
        return inside

    twice = sum(area for k, (cycle, area) in enumerate(outlines)
                if not any(is_inside(cycle[0][0], other) for j, (other, _) in enumerate(outlines) if j != k))
    return twice / 2
