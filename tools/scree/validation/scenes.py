"""Models of the cases whose scenes are a block or a few, and differ by some numbers."""
import math

import numpy as np

from ..block_files import box, turned
from ..model import Model
from . import references

FLEXURE = ((0, 1, 2, 12), (0.0, 0.05, 0.75, 1.0))  # times, and shares of the way of the press of a notched beam
STRIP = (0.0, 0.9, 1.03)  # movement of the grips of a strip over that of Griffith, at 0, 1 and 12 s


def on_base(name, title, base, block, phi, velocity=(0, 0, 0), density=2500, young=1e10, gravity=9.81):
    """A block on a fixed base, measured in its middle: corners, and the friction angle between them in degrees."""
    m = Model(name, gravity=gravity, title=title)
    m.material("base", density=density, young=young, unit_weight=0)
    m.material("block", density=density, young=young, velocity=velocity)
    m.joint_material("contact", phi=phi)
    m.block("base", base, "base")
    m.block("block", block, "block")
    m.fix("base", block="base")
    m.measure("middle", np.mean(block, axis=0))
    return m


def on_plane(name, title, degrees, width, height, phi, reach=(1, 5), speed=0.0, **rock):
    """A block on a plane that falls to the right; `reach` is how far the plane goes up and down from the upper corner, in widths of the
    block, which starts with a speed along the plane."""
    down = -math.radians(degrees)
    corners = [turned(sides, down) for sides in (box(-reach[0] * width, reach[1] * width, -width, 0), box(0, width, 0, height))]
    return on_base(name, title, *corners, phi, (speed * math.cos(down), speed * math.sin(down), 0), **rock)


def impact(name, title, phi):
    """A square of edge 0.05 that falls with its lowest corner from 0.05 above a plane of 45 degrees; plastic."""
    m = on_base(name, title, [(0, 0), (0.5, 0), (0, 0.5)], box(0.1, 0.15, 0.45, 0.5), phi)
    m.dynamic(time=0.15, size=1e-4)
    m["method.strain"], m["contact.restitution"] = "green", 0
    return m


def tilted(name, title, share, phi):
    """The block of `references.Rocking(0.25, 1)`, tilted about its right corner (0.25, 0) by a share of the angle at which it would stay."""
    tilt = -share * references.Rocking(0.25, 1.0).alpha
    m = on_base(name, title, box(-3, 3, -0.5, 0), turned(box(-0.5, 0, 0, 2), tilt) + [0.25, 0], phi)
    m["method.strain"] = "green"
    return m


def dam(name, width, phi):
    """A dam 12 high of 24 kN/m^3 with water of 10 kN/m^3 to its crest, in kN, m, t."""
    m = on_base(name, "A dam 12 high under water to its crest. kN, m, t.", box(-20, 30, -10, 0), box(0, width, 0, 12), phi, density=2.4,
                young=1e7, gravity=10)
    m.units = None  # tonnes, with another gravity
    m.load("water", [(0, 0), (0, 12)], pressure=[120, 0])
    m.static(balance=1e-4, steps=100)
    return m


def column():
    """Ten blocks on each other."""
    m = on_base("m1-column", "A column of ten blocks at rest: the lowest contacts carry its weight.", box(-1, 2, -1, 0), box(0, 1, 0, 1), 30)
    for level in range(1, 10):
        m.block("block", box(0, 1, level, level + 1), "block")
    m.static(balance=None, steps=100, size=0.1)
    m["contact.stiffness"] = 1e9
    return m


def cradle():
    """Five blocks of equal mass in a row, 0.05 apart, 1 x 0.5 and 0.8 x 0.625 in turn so that corners meet edges; the first is thrown."""
    m = Model("m7-cradle", title="Newton's cradle: the first of five blocks is thrown at the others, elastic, no weight.")
    m.material("at rest", density=2500, young=1e10, unit_weight=0)
    m.material("thrown", density=2500, young=1e10, unit_weight=0, velocity=(1, 0, 0))
    m.joint_material("contact", phi=0)
    right = -0.05
    for k, (width, height) in enumerate([(1, 0.5), (0.8, 0.625), (1, 0.5), (0.8, 0.625), (1, 0.5)]):
        left, right = right + 0.05, right + 0.05 + width
        m.block(f"block {k + 1}", box(left, right, -height / 2, height / 2), "at rest" if k else "thrown")
        m.measure(f"block {k + 1}", ((left + right) / 2, 0))
    m.dynamic(time=0.5, size=0.001)
    m["contact.restitution"] = 1
    return m


def pendulum(amplitude, time):
    """A square of 1 m pinned at a corner, its middle turned by an amplitude (degrees) from below that."""
    m = Model(f"e3-{amplitude}", title=f"A square of 1 m is pinned at a corner, and swings from {amplitude} degrees.")
    m.material("rock", density=2500, young=1e10)
    m.joint_material("none", phi=30)
    corners = turned(box(0, 1, 0, 1), math.radians(amplitude - 135))
    m.block("square", corners)
    m.fix("pin", corners[0])
    m.dynamic(time=time, size=0.005)
    m["output.interval"] = 100
    return m


def shaken_base():
    """A block on a base whose acceleration is 0.5 g sin(2 pi t); the block and the base are measured in their middle."""
    m = on_base("b8-sine", "A block slips on a base of acceleration 0.5 g sin(2 pi t), mu 0.2, for 2 s.", box(-2, 3, -0.5, 0), box(0, 1, 0, 0.5),
                math.degrees(math.atan(0.2)))
    m.measure("base", (0.5, -0.25))
    m.dynamic(time=2, size=0.001)
    m["acceleration.table"] = [number for t in np.arange(401) / 200 for number in (t, 0.5 * 9.81 * math.sin(2 * math.pi * t), 0)]
    return m


def strip(sheared=False):
    """A strip of 0.6 x 0.2 with a crack along its middle, bonded beyond 0.245374; grips at each node of its mesh move its edges apart, or along it."""
    m = Model("j4-strip", title="A strip that grips pull apart, or shear, has a crack along its bonded middle.")
    m.material("plate", density=2500, young=1e10, poisson=0, unit_weight=0)
    m.joint_material("crack", phi=0)
    if sheared:
        m.joint_material("bond", phi=0, cohesion=1e6, tensile_strength=1e8, shear_energy=5.78)
    else:
        m.joint_material("bond", phi=45, cohesion=1e7, tensile_strength=1e6, energy=5.78)
    joints, tip = ["crack", "bond", "crack", "crack", "crack"], (0.245374, 0)
    m.block("upper", [(0, 0), tip, (0.6, 0), (0.6, 0.1), (0, 0.1)], joint=joints)
    m.block("lower", [(0, -0.1), (0.6, -0.1), (0.6, 0), tip, (0, 0)], joint=["crack", "crack", "bond", "crack", "crack"])
    nodes = [*np.arange(84) * 0.0072168785, 0.6]
    griffith = math.sqrt(5.78 * 0.1 / (5e9 if sheared else 1e10))
    for name, side in ("upper", 1), ("lower", -1):
        ways = [side * griffith * share for share in STRIP]
        m.fix(name, *((x, 0.1 * side) for x in nodes), move=[(t, way, 0) if sheared else (t, 0, way) for t, way in zip((0, 1, 12), ways)])
    m.static(balance=None, steps=12, size=1)
    m["method.model"], m["method.strain"], m["cover.edge"], m["output.every"] = "nmm", "small", 0.014433757, 1
    m["cover.origin"] = [0, 0]
    return m


def cantilevers(rows):
    """Two arms of a double cantilever with so many rows of triangles each, bonded beyond a crack. Their ends are moved apart until the crack of
    simple beams, as `references.Cantilevers`, is 0.28 long. The zone of the bonds, (2 EI/kn)^(1/4) with kn = T^2/2G, is six edges long."""
    arms = references.Cantilevers(1e10, 0.05, 240.0)
    edge = arms.height / rows / math.sin(math.pi / 3)
    strength, steps, end = math.sqrt(4 * arms.energy * arms.bending / (6 * edge)**4), 30, arms.opening(0.28)
    m = Model("j5-cantilevers", title="The bonded arms of a double cantilever are moved apart, and a crack grows between them.")
    m.material("arm", density=2500, young=arms.young, poisson=0, unit_weight=0)
    m.joint_material("crack", phi=0)
    m.joint_material("bond", phi=45, cohesion=10 * strength, tensile_strength=strength, energy=arms.energy)
    joints, tip = ["crack", "bond", "crack", "crack", "crack"], (16.25 * edge, 0)
    m.block("upper", [(0, 0), tip, (0.5, 0), (0.5, arms.height), (0, arms.height)], joint=joints)
    m.block("lower", [(0, -arms.height), (0.5, -arms.height), (0.5, 0), tip, (0, 0)], joint=["crack", "crack", "bond", "crack", "crack"])
    for name, side in ("upper", 1), ("lower", -1):
        m.fix(name, (0, side * arms.height / 2), move=[(0, 0, 0), (1, 0, 0.15 * side * end), (steps, 0, 0.5 * side * end)])
    m.static(balance=None, steps=steps, size=1)
    m["method.model"], m["method.strain"], m["cover.edge"], m["output.every"] = "nmm", "small", edge, 1
    m["cover.origin"] = [0, 0]
    return m


def notched_flexure(rows):
    """The beam of `references.NotchedFlexure(1e10, 0.5, 0.05)` with so many rows of triangles in a layer, a crack of 0.35 and bonds of 240 N/m
    that soften in shear; its middle is pressed down. The bonds soften over six edges, pi/4 (E G h)^(1/2)/c."""
    half, height, young, energy, steps = 0.5, 0.05, 1e10, 240.0, 12
    edge = height / rows / math.sin(math.pi / 3)
    cohesion = math.pi / 4 * math.sqrt(young * energy * height) / (6 * edge)
    m = Model("j6-flexure", title="A beam on three points, cracked at one end, shears off along its bonded middle.")
    m.material("layer", density=2500, young=young, poisson=0, unit_weight=0)
    m.joint_material("crack", phi=0)
    m.joint_material("bond", phi=0, cohesion=cohesion, tensile_strength=10 * cohesion, shear_energy=energy)
    joints, tip = ["crack", "bond", "crack", "crack", "crack"], (0.35, 0)
    m.block("upper", [(0, 0), tip, (2 * half, 0), (2 * half, height), (0, height)], joint=joints)
    m.block("lower", [(0, -height), (2 * half, -height), (2 * half, 0), tip, (0, 0)], joint=["crack", "crack", "bond", "crack", "crack"])
    m.support("feet", points=[(0, -height / 2), (2 * half, -height / 2)], hold="y")  # points, as an edge that is held cannot turn
    m.fix("press", (half, height), move=[(t, 0, -2.72e-3 * share) for t, share in zip(FLEXURE[0], FLEXURE[1])])
    m.measure("middle", (half, -1e-7))
    m.static(balance=None, steps=steps, size=1)
    m["method.model"], m["method.strain"], m["cover.edge"], m["output.interval"] = "nmm", "small", edge, 4
    m["cover.origin"] = [0, 0]
    return m


def notched_beam(depth, peak, rows, shift):
    """A beam of depth W = 1 on three points 4 apart, cut in its middle from the lower side to half of W, with bonds that soften along the rest. W is
    `depth` times E G/T^2, and the middle is pressed down until the load has fallen by 2 % from its largest, about `peak` T W. The mesh has so
    many edges over W, and is moved up from where the tip is a node by the share `shift` of an edge."""
    young, strength, steps = 1e10, 1e6, 60
    opening = 2 * strength / young / depth  # at which nothing of a bond is left
    way = 120 * peak * strength / young + opening / 2
    m = Model("j7-notched-beam", title="A notched beam on three points, whose ligament is held by bonds that soften, is pressed down.")
    m.material("rock", density=2500, young=young, poisson=0, unit_weight=0)
    m.joint_material("notch", phi=0)
    m.joint_material("bond", phi=45, cohesion=10 * strength, tensile_strength=strength, energy=opening * strength / 2)
    m.block("left", [(-2, 0), (0, 0), (0, 0.5), (0, 1), (-2, 1)], joint=["notch", "notch", "bond", "notch", "notch"])
    m.block("right", [(0, 0), (2, 0), (2, 1), (0, 1), (0, 0.5)], joint=["notch", "notch", "notch", "bond", "notch"])
    m.support("feet", points=[(-2, 0), (2, 0)], hold="y")
    m.fix("press", (0, 1), move=[(0, 0, 0), (1, 0, -0.3 * way), (steps, 0, -way)])
    m.static(balance=None, steps=steps, size=1)
    m["step.past_peak"] = 0.98
    m["method.model"], m["method.strain"], m["cover.edge"], m["output.interval"] = "nmm", "small", 1 / rows, steps
    m["cover.origin"], m["cover.angle"] = [0, shift / rows], 90
    return m
