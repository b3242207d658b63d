"""Random decks of joint sets in slopes, benches, tunnels and holes, in units from a millimetre to a kilometre."""
import math
import random

E0 = (1e-5, 1e-4, 1e-3, 1e-2)


def slope(rnd):
    """Window and slope."""
    width, height, foot = rnd.uniform(40, 120), rnd.uniform(20, 60), rnd.uniform(0.2, 0.6)
    top = height * rnd.uniform(0.75, 0.95)
    rise = rnd.uniform(0.2, 0.8) * (top - foot * height) + foot * height
    x = sorted(rnd.uniform(0.2, 0.8) * width for _ in range(2))
    return width, height, [f"&slope x=0 {x[0]} {x[1]} {width}, y={foot * height} {foot * height} {rise} {top} /"]


def benches(rnd):
    """Window and a slope of steps."""
    width, height = rnd.uniform(60, 120), rnd.uniform(40, 60)
    n, at, level = rnd.randrange(2, 6), 0.15 * width, 0.2 * height
    x, y = [0, at], [level, level]
    for _ in range(n):
        x += [x[-1] + 0.03 * width, x[-1] + 0.03 * width + rnd.uniform(0.03, 0.7 / n - 0.03) * width]
        y += [y[-1] + 0.7 * height / n] * 2
    return width, height, [f"&slope x={' '.join(map(repr, x + [width]))}, y={' '.join(map(repr, y + [y[-1]]))} /"]


def tunnels(rnd):
    """Window and round tunnels, some of which meet or leave the window."""
    width, height, groups = rnd.uniform(30, 60), rnd.uniform(20, 40), []
    for _ in range(rnd.randrange(1, 4)):
        groups.append(f"&tunnel centre={rnd.uniform(0, width)} {rnd.uniform(0, height)}, radius={rnd.uniform(1, 4)}, "
                      f"sides={rnd.choice((3, 6, 12, 40))} /")
    return width, height, groups


def holes(rnd):
    """Window and holes with corners anywhere."""
    width, height, groups = rnd.uniform(30, 60), rnd.uniform(20, 40), []
    for _ in range(rnd.randrange(1, 5)):
        n, turn, middle = rnd.randrange(3, 8), rnd.random(), (rnd.uniform(5, width - 5), rnd.uniform(5, height - 5))
        corners = [(middle[0] + r * math.cos(turn + 2 * math.pi * i / n), middle[1] + r * math.sin(turn + 2 * math.pi * i / n))
                   for i in range(n) for r in [rnd.uniform(0.5, 4)]]
        groups.append("&tunnel x={}, y={} /".format(*(" ".join(str(c[k]) for c in corners) for k in (0, 1))))
    return width, height, groups


KINDS = (slope, benches, tunnels, holes)


def scaled(group, scale):
    """A group with all its lengths in another unit."""
    name, _, rest = group.partition(" ")
    words = []
    for part in rest.rstrip(" /").split(", "):
        key, _, values = part.partition("=")
        if key in ("x", "y", "centre", "radius", "spacing", "length", "bridge"):
            values = " ".join(str(float(v) * scale) for v in values.split())
        words.append(f"{key}={values}")
    return f"{name} {', '.join(words)} /"


def make_rock(seed):
    """The deck of joint sets of a seed, and the kind, e0 and unit of length that it is of."""
    rnd = random.Random(seed)
    kind, e0, unit = KINDS[seed % 4], E0[seed // 4 % 4], (1e-3, 1.0, 1e3)[seed // 16 % 3]
    width, height, groups = kind(rnd)
    size = min(width, height)
    groups.insert(0, f"&window x=0 {width}, y=0 {height} /")
    for i in range(rnd.randrange(2, 4)):
        groups.append(f"&joint_set dip={rnd.uniform(-90, 90)}, spacing={size * rnd.uniform(0.06, 0.2)}, "
                      f"length={size * rnd.uniform(0.2, 1)}, bridge={size * rnd.uniform(0, 0.1)}, randomness={rnd.random()}, "
                      f"material={i + 2} /")
    deck = [scaled(g, unit) for g in groups] + [f"&seed value={seed} /", f"&deck e0={e0} /"]
    return "\n".join(deck) + "\n", kind.__name__, e0, unit
