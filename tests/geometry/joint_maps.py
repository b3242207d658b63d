"""Random joint maps with all that cutting finds hard, near and far away."""
import math
import random

WIDTH = 10.0      # of the window
FAR = 1e6         # where half of the maps lie
KINDS = ("anywhere", "nearly parallel", "T-junction", "overlap", "twice", "no length", "polygon", "star", "nest", "touch")


def turned(line, angle):
    c, s = math.cos(angle), math.sin(angle)
    return (line[0] * c - line[1] * s, line[0] * s + line[1] * c, line[2] * c - line[3] * s, line[2] * s + line[3] * c)


def closed(places):
    return [p + q for p, q in zip(places, places[1:] + places[:1])]


def lines_of_kind(kind, lines, rnd):
    """Lines to be added to a map."""
    p, q = [(rnd.uniform(0, WIDTH), rnd.uniform(0, WIDTH)) for _ in range(2)]
    old = rnd.choice(lines)

    def on_old(share):
        return (old[0] + share * (old[2] - old[0]), old[1] + share * (old[3] - old[1]))

    if kind == "nearly parallel":
        off = rnd.choice([0, 3e-15, 1e-13, 1e-12, 1e-11, 1e-9]) * WIDTH
        return [tuple(c + off * rnd.uniform(-1, 1) for c in old)]
    if kind == "T-junction":
        x = on_old(rnd.random())
        # on the outline of the window a gap of rounding would decide what is enclosed
        return [x + q] if all(1e-6 < c < WIDTH - 1e-6 for c in x) else []
    if kind == "overlap":
        return [on_old(rnd.uniform(-0.3, 1.3)) + on_old(rnd.uniform(-0.3, 1.3))]
    if kind == "twice":
        return [old]
    if kind == "no length":
        return [p + p]
    if kind in ("polygon", "nest", "touch"):
        n, radius, phase = rnd.randrange(3, 7), rnd.uniform(0.1, 2), rnd.random()
        corners = [(p[0] + radius * math.cos(phase + 2 * math.pi * i / n), p[1] + radius * math.sin(phase + 2 * math.pi * i / n))
                   for i in range(n)]
        if kind == "nest":
            rings = [[(p[0] + s * (x - p[0]), p[1] + s * (y - p[1])) for x, y in corners] for s in (1, 0.6, 0.3)]
        elif kind == "touch":  # at one corner, from outside and from inside
            x, y = corners[0]
            rings = [[(x + s * (a - x), y + s * (b - y)) for a, b in corners] for s in (1, 0.5, -0.4)]
        else:
            rings = [corners]
        return [line for ring in rings for line in closed(ring)]
    if kind == "star":
        star = []
        for _ in range(3):
            angle, reach = rnd.uniform(0, math.pi), rnd.uniform(1, 5)
            dx, dy = reach * math.cos(angle), reach * math.sin(angle)
            star.append((p[0] - dx, p[1] - dy, p[0] + dx, p[1] + dy))
        return star
    return [p + q]


def make_map(seed):
    """Lines of a map, and whether it lies far away."""
    rnd = random.Random(seed)
    over = rnd.choice([0, 0, 0.01, 0.3])  # the lines of the window end in its corners, or beyond
    lines = [(-over, 0, WIDTH + over, 0), (WIDTH, -over, WIDTH, WIDTH + over), (WIDTH + over, WIDTH, -over, WIDTH),
             (0, WIDTH + over, 0, -over)]
    for _ in range(rnd.randrange(1, 25)):
        lines += lines_of_kind(rnd.choice(KINDS), lines, rnd)
    if seed % 2:
        angle = rnd.uniform(0, 2 * math.pi)
        lines = [turned(line, angle) for line in lines]
    far = seed % 4 >= 2
    if far:
        lines = [tuple(c + FAR for c in line) for line in lines]
    rnd.shuffle(lines)
    return lines, far


def geometry_deck(lines, e0):
    """The lines as a geometry deck, none of them boundary."""
    return f"{e0}\n{len(lines)} 0\n0\n0\n0\n0\n0\n0\n" + "".join(" ".join(map(repr, map(float, a))) + " 1\n" for a in lines)
