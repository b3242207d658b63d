"""Joint maps as surveys draw them: polylines with noise in two sets, islands, ends that just miss another trace, traces past the
boundary."""
import math
import random

WIDTH = 100.0       # of a map, length
SETS = (20, 105)    # degrees from x
BOUNDARY = [(0, 0), (0.55, -0.04), (1, 0.02), (0.97, 0.5), (1.02, 1), (0.6, 0.93), (0.45, 0.7), (0.3, 0.98), (-0.02, 0.95), (0.05, 0.4)]
MISS = 0.8          # of the snap distance: ends of traces are at most so far from the trace that they end at
ISLANDS, ENDING, PAST = 0.04, 0.3, 0.1  # shares of traces: closed outlines, those that end at another trace, at the boundary or past it


def snap_distance(e0, places):
    """e0 w0, as doc/decks.md says."""
    width, height = (max(place[k] for place in places) - min(place[k] for place in places) for k in (0, 1))
    return e0 * 1.02 * max(height / 2, width / 2 / 1.3)


def along(a, b, share):
    return (a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]))


def trace_map(n, e0, seed):
    """Corners of the boundary, n traces as rows of places, the snap distance."""
    rnd = random.Random(seed)
    corners = [(WIDTH * x, WIDTH * y) for x, y in BOUNDARY]
    length = 4 * WIDTH / math.sqrt(n)
    e = snap_distance(e0, [(-1.5 * length, -1.5 * length), (WIDTH + 1.5 * length, WIDTH + 1.5 * length)])  # no trace reaches farther
    traces = []
    for k in range(n):
        x, y = (rnd.uniform(-0.02, 1.02) * WIDTH for _ in range(2))
        if rnd.random() < ISLANDS:
            corners_of_island, radius = rnd.randrange(4, 9), rnd.uniform(0.02, 0.1) * length
            ring = [(x + radius * rnd.uniform(0.7, 1) * math.cos(math.tau * i / corners_of_island),
                     y + radius * rnd.uniform(0.7, 1) * math.sin(math.tau * i / corners_of_island)) for i in range(corners_of_island)]
            traces.append(ring + ring[:1])
            continue
        angle = math.radians(SETS[k % 2] + rnd.gauss(0, 8))
        reach, pieces = length * rnd.uniform(0.4, 1.2), rnd.randrange(1, 6)
        trace = [(x + reach * (i / pieces - 0.5) * math.cos(angle) + rnd.gauss(0, 0.01) * reach,
                  y + reach * (i / pieces - 0.5) * math.sin(angle) + rnd.gauss(0, 0.01) * reach) for i in range(pieces + 1)]
        lot = rnd.random()
        if lot < ENDING + PAST and traces:
            target = rnd.choice(traces[-50:])
            sides = list(zip(target, target[1:])) if lot < ENDING else list(zip(corners, corners[1:] + corners[:1]))
            a, b = rnd.choice(sides)
            at = along(a, b, rnd.uniform(0.1, 0.9))
            if math.dist(at, trace[0]) < 1.2 * length:  # the last piece ends there, short of it or past it
                trace[-1] = along(trace[0], at, 1 + MISS * e * rnd.uniform(-1, 1) / math.dist(at, trace[0]))
                trace[1:-1] = [along(trace[0], trace[-1], i / pieces) for i in range(1, pieces)]
        traces.append(trace)
    places = [place for trace in [*traces, corners] for place in trace]
    assert snap_distance(e0, places) <= e
    return corners, traces, snap_distance(e0, places)


def lengthened(trace, by):
    """A trace whose ends reach farther; an island as it is."""
    if trace[0] == trace[-1]:
        return trace
    (a, b), (c, d) = trace[:2], trace[:-3:-1]
    return [along(b, a, 1 + by / math.dist(a, b)), *trace[1:-1], along(d, c, 1 + by / math.dist(c, d))]
