"""Answers of the validation cases: closed forms, and the motion of rigid bodies integrated."""
import cmath
import dataclasses
import math

import numpy as np


def bisect(below, low, high, times=50):
    """Where `below` turns from true to false."""
    for _ in range(times):
        middle = (low + high) / 2
        low, high = (middle, high) if below(middle) else (low, middle)
    return (low + high) / 2


def slide(angle, mu, time, g=9.81):
    """Distance of a block that slides from rest down a plane."""
    return max(0.0, g * (math.sin(angle) - mu * math.cos(angle))) * time**2 / 2


def bolt_tension(weight, slope, friction, angle):
    """Tension with which a bolt at an angle to a plane just holds a block on it: W sin - T cos a = (W cos + T sin a) tan phi.

    Angles in degrees."""
    slope, mu, angle = math.radians(slope), math.tan(math.radians(friction)), math.radians(angle)
    return weight * (math.sin(slope) - mu * math.cos(slope)) / (math.cos(angle) + mu * math.sin(angle))


def grouted_bolt(weight, slope, friction, angle, along, across):
    """Forces along and across a grouted bolt at an angle to the plane that a block slides down by u until it is held.

    Its springs k and k' stretch by u cos a and u sin a, so they pull with (k cos^2 a + k' sin^2 a) u up the plane, and press on it with
    (k - k') sin a cos a u: W sin = (k cos^2 a + k' sin^2 a) u + (W cos + (k - k') sin a cos a u) tan phi. The second force is below 0 where
    the block goes down to the right. Angles in degrees."""
    slope, mu, angle = math.radians(slope), math.tan(math.radians(friction)), math.radians(angle)
    c, s = math.cos(angle), math.sin(angle)
    u = weight * (math.sin(slope) - mu * math.cos(slope)) / (along * c**2 + across * s**2 + mu * (along - across) * s * c)
    return along * c * u, -across * s * u


class Kirsch:
    """A round hole of radius 1 in a plate of plane strain under the stresses xx and yy far away (tension positive): Kirsch 1898.

    What it moves by is what digging it adds; angles from the x axis.
    """

    def __init__(self, xx, yy, young, poisson):
        self.mean, self.half, self.poisson = (xx + yy) / 2, (xx - yy) / 2, poisson
        self.shear = young / (2 * (1 + poisson))

    def hoop(self, angle):
        return 2 * self.mean - 4 * self.half * np.cos(2 * angle)

    def inwards(self, angle):
        return -(self.mean + (3 - 4 * self.poisson) * self.half * np.cos(2 * angle)) / (2 * self.shear)


def round_plate_hoop(radius, xx, yy):
    """Hoop stress at the side and the top of a hole of radius 1 in a round plate with the tractions of the stresses xx and yy around it.

    Lame's for their mean; for half their difference d the stress function (A r^2 + B r^4 + C/r^2 + D) cos 2t, with
    s_r = -(2 A + 6 C/r^4 + 4 D/r^2) cos 2t, t_rt = (2 A + 6 B r^2 - 6 C/r^4 - 2 D/r^2) sin 2t, nothing on the hole, d and -d around
    the plate, and the hoop stress (2 A + 12 B r^2 + 6 C/r^4) cos 2t (Michell 1899)."""
    rows = [row for r in (1.0, radius) for row in ([-2, 0, -6 / r**4, -4 / r**2], [2, 6 * r**2, -6 / r**4, -2 / r**2])]
    a, b, c, _ = np.linalg.solve(rows, [0, 0, (xx - yy) / 2, -(xx - yy) / 2])
    mean, varying = (xx + yy) * radius**2 / (radius**2 - 1), 2 * a + 12 * b + 6 * c
    return mean + varying, mean - varying


def brazilian_centre(force, diameter):
    """Stress across and along the loaded diameter at the centre of a disc pressed by two forces (Hertz 1883)."""
    return 2 * force / (math.pi * diameter), -6 * force / (math.pi * diameter)


def stop(speed, mu, angle=0.0, g=9.81):
    """Time and distance to rest of a block that is thrown down a plane, friction against it."""
    deceleration = g * (mu * math.cos(angle) - math.sin(angle))
    return speed / deceleration, speed**2 / (2 * deceleration)


class SlopeImpact:
    """A square, sides parallel to the axes, falls on a plane of 45 degrees that goes down to the right; plastic, Coulomb.

    The normal passes through the centre, so friction alone turns the block. The corner sticks where mu >= 1/4
    (moment of inertia m a^2/6, lever a/sqrt 2), else it slips.
    """

    def __init__(self, edge, drop, mu, g=9.81):
        self.edge, self.drop, self.g = edge, drop, g
        self.time = math.sqrt(2 * drop / g)
        self.speed = math.sqrt(2 * g * drop)
        normal = self.speed / math.sqrt(2)  # impulses over mass
        tangential = min(normal / 4, mu * normal)
        self.along = self.speed / math.sqrt(2) - tangential
        self.spin = 0.0 - tangential * (edge / math.sqrt(2)) / (edge**2 / 6)
        # A corner that sticks leaves the plane at once where along^2/r > g cos 45.
        self.leaves = mu >= 0.25 and self.along**2 / (edge / math.sqrt(2)) > g / math.sqrt(2)

    def place(self, start, time):
        """Centre and angle: flight after lift-off, or a slide without friction."""
        t = time - self.time
        along = self.along / math.sqrt(2) * t
        fall = self.g * t**2 / 2 if self.leaves else self.g * t**2 / 4
        aside = 0.0 if self.leaves else self.g * t**2 / 4
        return start[0] + along + aside, start[1] - self.drop - along - fall, self.spin * t


def shaken_block(mu, amplitude, frequency, end, g=9.81):
    """Slip of a block on a flat base of acceleration amplitude sin(2 pi f t): at the end, and the least.

    From event to event: each slide begins at rest and has a closed form until its speed is zero again; there the block
    slides back at once or sticks until the base outruns friction.
    """
    omega, limit, fine = 2 * math.pi * frequency, mu * g, 1e-4 / frequency
    t = slip = least = 0.0
    while t < end:
        ground = amplitude * math.sin(omega * t)
        if abs(ground) < limit * (1 - 1e-9):
            t = first(lambda x: abs(amplitude * math.sin(omega * x)) < limit, t, fine, end)
            continue
        begin, sign = t, -math.copysign(1.0, ground)

        def speed(x):
            return amplitude / omega * (math.cos(omega * x) - math.cos(omega * begin)) - sign * limit * (x - begin)

        t = first(lambda x: speed(x) * sign > 0, begin + fine, fine, end)
        rest = (math.sin(omega * t) - math.sin(omega * begin)) / omega - math.cos(omega * begin) * (t - begin)
        slip += amplitude / omega * rest - sign * limit * (t - begin)**2 / 2
        least = min(least, slip)
    return slip, least


def shaken_incline(degrees, mu, time, acceleration, g=9.81, fine=200):
    """Slip down a plane that is shaken, of a rigid block that does not turn and begins at rest (Newmark 1965).

    `acceleration` is (n, 2), linear between the times. Each interval is cut into `fine` parts of constant acceleration; in a part
    the block stops where its speed is zero, and sticks as long as friction bears.
    """
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    fine_time = np.linspace(time[0], time[-1], fine * (len(time) - 1) + 1)
    middle, dt = 0.5 * (fine_time[1:] + fine_time[:-1]), fine_time[1] - fine_time[0]
    force = -np.column_stack([np.interp(middle, time, acceleration[:, i]) for i in (0, 1)]) - [0, g]
    drive, limit = force @ [c, -s], mu * -(force @ [s, c])
    v = slip = 0.0
    for d, most in zip(drive, limit):
        if v == 0.0 and abs(d) <= most:
            continue
        a = d - math.copysign(most, v if v != 0.0 else d)
        lasts = dt if v * (v + a * dt) >= 0 else -v / a
        slip += v * lasts + a * lasts**2 / 2
        v = v + a * dt if lasts == dt else 0.0
    return slip


def first(holds, start, fine, end):
    """The first time from the start at which a condition holds no more, or the end."""
    t = start
    while t < end and holds(t):
        t += fine
    return end if t >= end else bisect(holds, max(start, t - fine), t)


def block_mode(width, height, phi, slope):
    """(slides, topples): how a rigid block starts from rest on a plane; width along the plane, angles in radians.

    The mode is the one whose contact forces are admissible: pressure within the base, friction within its limit.
    """
    mu = math.tan(phi)
    lever = height * math.tan(slope) > width  # the weight passes outside the base
    if slope <= phi and not lever:
        return False, False
    if slope > phi and mu * height <= width:  # sliding: pressure at mu h/2 from the middle
        return True, False
    inertia = (width**2 + height**2) / 3  # about the lower edge, over mass
    turn = (math.sin(slope) * height - math.cos(slope) * width) / (2 * inertia)  # over g
    normal = math.cos(slope) + turn * width / 2
    shear = math.sin(slope) - turn * height / 2
    return abs(shear) > mu * normal, True


def pendulum(amplitude, length, time, g=9.81):
    """Angle of a pendulum released at an amplitude; its length is the square of its radius of inertia about the pin over the arm.

    sin(angle/2) = k sn(K + t sqrt(g/l), k), k = sin(amplitude/2); sn by arithmetic-geometric means (Abramowitz and Stegun 16.4).
    """
    k = math.sin(amplitude / 2)
    a, b, c, ratios, doublings = 1.0, math.sqrt(1 - k**2), k, [], 0
    while c > 1e-16:
        a, b, c = (a + b) / 2, math.sqrt(a * b), (a - b) / 2
        ratios.append(c / a)
        doublings += 1
    phase = 2**doublings * a * (math.pi / (2 * a) + time * math.sqrt(g / length))
    for ratio in reversed(ratios):
        phase = (phase + math.asin(ratio * math.sin(phase))) / 2
    return 2 * math.asin(k * math.sin(phase))


def pendulum_period(amplitude, length, g=9.81):
    """2 pi (l/g)^1/2 over the arithmetic-geometric mean of 1 and cos(amplitude/2)."""
    a, b = 1.0, math.cos(amplitude / 2)
    while a - b > 1e-15:
        a, b = (a + b) / 2, math.sqrt(a * b)
    return 2 * math.pi * math.sqrt(length / g) / a


class Cantilevers:
    """Two arms of Young's modulus E and a height, held together by an energy of fracture G, as simple beams: the crack grows at P a = (G EI)^(1/2),
    where the arms are d = 2 P a^3/3 EI apart. What shear and the bonds give way makes the crack longer by a constant, which cancels in P(d)."""

    def __init__(self, young, height, energy):
        self.young, self.height, self.energy, self.bending = young, height, energy, young * height**3 / 12

    def opening(self, crack):
        """Of the ends of the arms, as a crack of a length grows."""
        return 2 * math.sqrt(self.energy / self.bending) * crack**2 / 3

    def load(self, opening):
        """Force on each arm at an opening, as the crack grows."""
        return math.sqrt(self.energy * self.bending) / np.sqrt(1.5 * opening * math.sqrt(self.bending / self.energy))


class NotchedFlexure:
    """A beam on three points of span 2 L, of two layers of height h that a crack a from one end parts (end notched flexure): its compliance, and the
    energy released by the crack (Russell and Street 1985). The tip gives way as a crack longer by 0.42 chi h (Wang and Williams 1992), and
    shear by 0.6 L/E h, with nu = 0 and unit width."""

    def __init__(self, young, half, height):
        self.young, self.half, self.height = young, half, height
        way = 1.18 * 2  # E over the shear modulus
        self.longer = 0.42 * height * math.sqrt(2 / 11 * (3 - 2 * (way / (1 + way))**2))

    def compliance(self, crack):
        """Deflection of the middle over the load there."""
        return ((2 * self.half**3 + 3 * (crack + self.longer)**3) / (8 * self.height**3) + 0.6 * self.half / self.height) / self.young

    def crack(self, compliance):
        """Length of the crack, with what the tip makes it longer, at which a beam has a compliance."""
        bent = 8 * self.height**3 * (self.young * compliance - 0.6 * self.half / self.height)
        return np.cbrt((bent - 2 * self.half**3) / 3)

    def energy(self, load, crack):
        """Energy that the crack releases over its area, at its length with what the tip makes it longer."""
        return 9 * (load * crack)**2 / (16 * self.young * self.height**3)


class Rocking:
    """A rigid block of half width b and half height h that rocks about its lower corners (Housner 1963)."""

    def __init__(self, b, h, g=9.81):
        self.alpha, self.R, self.g = math.atan2(b, h), math.hypot(b, h), g

    def spin(self, start, tilt):
        """Rate at a tilt, from rest at the start: 1/2 (4/3 m R^2) w^2 = m g R (cos(alpha - start) - cos(alpha - tilt))."""
        return math.sqrt(1.5 * self.g / self.R * max(0.0, math.cos(self.alpha - start) - math.cos(self.alpha - tilt)))

    def time(self, start, tilt, order=60):
        """From rest at the start to a tilt; tilt = start - u^2 takes the singularity at rest away."""
        x, w = np.polynomial.legendre.leggauss(order)
        half = math.sqrt(start - tilt) / 2
        u = half * (x + 1)
        return sum(wi * half * 2 * ui / self.spin(start, start - ui**2) for ui, wi in zip(u, w))

    def impact(self, start):
        """Time and rate of the first impact."""
        return self.time(start, 0.0), self.spin(start, 0.0)

    def tilt(self, start, time):
        """Where it is at a time before the first impact."""
        return start - bisect(lambda turn: self.time(start, start - turn) < time, 0.0, start)

    def tops(self, start, count):
        """Largest tilts after each of the first impacts. An impact leaves (1 - 1.5 sin^2 alpha)^2 of the energy (Housner 1963)."""
        left, rise = (1 - 1.5 * math.sin(self.alpha)**2)**2, math.cos(self.alpha - start) - math.cos(self.alpha)
        return [self.alpha - math.acos(math.cos(self.alpha) + rise * left**n) for n in range(1, count + 1)]

    def least_acceleration(self):
        """Lasting acceleration of the base, over g, that lifts and so overturns the block."""
        return math.tan(self.alpha)


class Toppling:
    """Columns on a stepped base (Goodman and Bray 1976; numbers of the example in Hoek and Bray, Rock Slope Engineering)."""

    def __init__(self, columns=16, width=10.0, base=30.0, below=5.0, above=5.0, step=1.0, crest=10, weight=25.0):
        self.width, self.base, self.weight, self.crest, self.step = width, math.radians(base), weight, crest, step
        self.below, self.above = below, above  # steps of the face and of the ground behind the crest: a1, a2
        self.height = [n * (below - step) if n <= crest else crest * (below - step) - (n - crest) * (above + step)
                       for n in range(1, columns + 1)]

    def forces(self, mu):
        """P(n-1), n from the top column to the toe, and how each column goes; the last is the force that the toe needs."""
        s, c, P, rows = math.sin(self.base), math.cos(self.base), 0.0, []
        for n in range(len(self.height), 0, -1):
            y, W = self.height[n - 1], self.weight * self.width * self.height[n - 1]
            upper = y if n < self.crest else y - self.above  # where the column above pushes
            lower = y - self.below if n <= self.crest else y
            slide = P - W * (mu * c - s) / (1 - mu**2)
            # The toe column of the example has no lever (lower < 0): it can only slide.
            topple = (P * (upper - mu * self.width) + W / 2 * (y * s - self.width * c)) / lower if lower > 0 else -math.inf
            P = max(topple, slide, 0.0)
            rows.append((n, P, "stable" if P == 0 else "topples" if topple > slide else "slides"))
        toe = rows[-1]
        rows[-1] = (1, slide, toe[2])
        return rows

    def critical(self):
        """tan phi at which the toe needs no force."""
        return bisect(lambda mu: self.forces(mu)[-1][1] > 0, 0.6, 0.95)


def arch_thickness(voussoirs, polygon=False):
    """Least t/R (R of the middle line) at which a semicircular arch stands by thrust alone: no tension, no sliding.

    A line of thrust of horizontal force H that passes the crown at height z must lie within each joint: half-planes
    in (H, H z). Weights are those of ring sectors, or of the polygons between the joints.
    """
    return bisect(lambda t: not stands(voussoirs, t, polygon), 0.05, 0.2, times=30)


def stands(voussoirs, t, polygon):
    """Whether a line of thrust exists; R = 1, weight per area = 1, angles from the crown."""
    inner, outer = 1 - t / 2, 1 + t / 2
    joints = math.pi / 2 - math.pi / voussoirs * np.arange(voussoirs // 2 + 1)
    # Load on the half from the crown to each joint: force, and moment about x = 0. The crown stone of odd N is halved.
    edges = np.unique(np.append(joints, 0.0))
    force, moment, load = 0.0, 0.0, {0.0: (0.0, 0.0)}
    for a, b in zip(edges[:-1], edges[1:]):
        half = a == 0.0 and voussoirs % 2
        if polygon:
            if half:  # trapezium of the whole crown stone, its right half
                area, first = trapezium_half(inner, outer, b)
            else:
                area = (outer**2 - inner**2) / 2 * math.sin(b - a)
                first = (outer**3 - inner**3) / 6 * math.sin(b - a) * (math.sin(a) + math.sin(b))
        else:
            area = (outer**2 - inner**2) / 2 * (b - a)
            first = (outer**3 - inner**3) / 3 * (math.cos(a) - math.cos(b))
        force, moment = force + area, moment + first
        load[b] = (force, moment)
    planes = []  # a0 H + a1 Hz <= c
    for angle in joints:
        W, M = load[min(load, key=lambda key: abs(key - angle))]
        for r, sign in ((inner, 1.0), (outer, -1.0)):
            x, y = r * math.sin(angle), r * math.cos(angle)
            # Moment of crown thrust and weights about the point; the thrust line above the inner end, below the outer.
            # H (z - y) - (W x - M) >= 0 at the inner end, <= 0 at the outer one.
            planes.append((sign * y, -sign, -sign * (W * x - M)))
    planes = np.array(planes)
    i, j = np.triu_indices(len(planes), 1)
    a, b = planes[i], planes[j]
    det = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    ok = np.abs(det) > 1e-14
    a, b, det = a[ok], b[ok], det[ok]
    H = (a[:, 2] * b[:, 1] - a[:, 1] * b[:, 2]) / det
    z = (a[:, 0] * b[:, 2] - a[:, 2] * b[:, 0]) / det
    return bool(np.any(np.all(planes[:, :1] * H + planes[:, 1:2] * z <= planes[:, 2:] + 1e-12, axis=0)))


def trapezium_half(inner, outer, b):
    """Area and first moment about x = 0 of the right half of the crown stone, corners at angles -b and b."""
    corners = np.array([(0, inner * math.cos(b)), (inner * math.sin(b), inner * math.cos(b)),
                        (outer * math.sin(b), outer * math.cos(b)), (0, outer * math.cos(b))])
    x, y = corners.T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    return cross.sum() / 2, ((x + np.roll(x, -1)) * cross).sum() / 6


def plane_failure(height, face, plane, crack, cohesion, phi, weight, water=0.0, water_weight=9.81):
    """Factor of safety of a plane slide with a vertical tension crack behind the crest, with water in it and along the plane, where
    its pressure falls to nothing at the toe (Hoek and Bray)."""
    length = (height - crack) / math.sin(plane)
    W = weight * height**2 / 2 * ((1 - (crack / height)**2) / math.tan(plane) - 1 / math.tan(face))
    uplift, thrust = water_weight * water * length / 2, water_weight * water**2 / 2
    across = W * math.cos(plane) - uplift - thrust * math.sin(plane)
    return (cohesion * length + across * math.tan(phi)) / (W * math.sin(plane) + thrust * math.cos(plane))


def roof_wedge(half_angle, phi, height, density, g=9.81):
    """Weight, and the normal force on each face and horizontal thrust that just hold a symmetric wedge."""
    W = density * g * height**2 * math.tan(half_angle)
    N = W / 2 / (math.tan(phi) * math.cos(half_angle) - math.sin(half_angle))
    return W, N, N * (math.cos(half_angle) + math.tan(phi) * math.sin(half_angle))


def track(points, opening, R, run=3.0, beyond=3.0):
    """Corners of a flat, an arc of chords and its straight continuation; the arc starts at the origin."""
    angles = np.linspace(0, math.radians(opening), points)
    arc = np.column_stack([R * np.sin(angles), R * (1 - np.cos(angles))])
    last = (arc[-1] - arc[-2]) / np.linalg.norm(arc[-1] - arc[-2])
    return np.vstack([[-run, 0.0], arc, arc[-1] + beyond * last])


def elastic_slide(corners, length, height, speed, stiffness, g=10.0, dt=1e-6, end=0.8):
    """(time of the top from the foot, rise, rotation's energy there over g, error of energy over g) of a rigid block on a track.

    Nothing is lost: the corners are on springs, a stiffness over mass, and the steps (Verlet) resolve them.
    """
    inertia = (length**2 + height**2) / 12  # over mass
    lines = [(x, y, (u - x) / math.hypot(u - x, v - y), (v - y) / math.hypot(u - x, v - y))
             for (x, y), (u, v) in zip(corners.tolist(), corners[1:].tolist())]
    x, y, turn, vx, vy, spin = -length / 2, height / 2 - g / stiffness / 2, 0.0, speed, 0.0, 0.0
    ax = ay = bend = spring = 0.0
    low, top, worst, ends = y, (0.0, 0.0, 0.0), 0.0, [0, 0]
    for step in range(round(end / dt)):
        vx, vy, spin = vx + ax * dt / 2, vy + ay * dt / 2, spin + bend * dt / 2
        x, y, turn = x + vx * dt, y + vy * dt, turn + spin * dt
        c, s = math.cos(turn), math.sin(turn)
        ax, ay, bend, spring = 0.0, -g, 0.0, 0.0
        for i, side in enumerate((-length / 2, length / 2)):  # the track is hollow: a place is above it if above all lines
            rx, ry = c * side + s * height / 2, s * side - c * height / 2
            while ends[i] + 1 < len(lines) and lines[ends[i] + 1][0] < x + rx:
                ends[i] += 1
            while ends[i] > 0 and lines[ends[i]][0] > x + rx:
                ends[i] -= 1
            for u, v, tx, ty in lines[max(ends[i] - 1, 0):ends[i] + 2]:
                gap = (y + ry - v) * tx - (x + rx - u) * ty
                if gap < 0:
                    push = -stiffness * gap
                    ax, ay, bend = ax - push * ty, ay + push * tx, bend + push * (rx * tx + ry * ty) / inertia
                    spring += stiffness * gap**2 / 2
        vx, vy, spin = vx + ax * dt / 2, vy + ay * dt / 2, spin + bend * dt / 2
        if y - low > top[1]:
            top = (step + 1) * dt, y - low, inertia * spin**2 / 2 / g
        if step % 100 == 0:
            worst = max(worst, abs((vx**2 + vy**2 - speed**2 + inertia * spin**2) / 2 + g * (y - low) + spring) / g)
    return *top, worst


class ArcSlide:
    """A rigid block, both lower corners on the track, without friction; plastic at each kink.

    One degree of freedom: the way s of the front corner. Between kinks energy is kept; where a corner passes one, the
    velocity is projected on the new motion in the norm of the kinetic energy.
    """

    def __init__(self, corners, length, height, speed, g=10.0):
        self.corners, self.length, self.height, self.g = corners, length, height, g
        self.inertia = (length**2 + height**2) / 12  # over mass
        self.s = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1)))
        self.tangent = np.diff(corners, axis=0) / np.diff(self.s)[:, None]
        self.slide(speed)

    def point(self, s, segment):
        return self.corners[segment] + (s - self.s[segment]) * self.tangent[segment]

    def rear(self, front, segment):
        """Where the rear corner is on the line of a segment: at the length of the block behind the front one."""
        gap = self.point(front, self.front_segment) - self.corners[segment]
        along = gap @ self.tangent[segment]
        return self.s[segment] + along - math.sqrt(self.length**2 - (gap @ gap - along**2))

    def state(self, front):
        """Centre, and the motion (centre x, y, angle) for one unit of front way."""
        f, r = self.point(front, self.front_segment), self.point(self.rear(front, self.rear_segment), self.rear_segment)
        axis = (f - r) / self.length
        tf, tr = self.tangent[self.front_segment], self.tangent[self.rear_segment]
        ratio = (tf @ axis) / (tr @ axis)
        normal = np.array([-axis[1], axis[0]])
        turn = (tf - ratio * tr) @ normal / self.length
        centre = (f + r) / 2 + self.height / 2 * normal
        motion = (tf + ratio * tr) / 2 - self.height / 2 * turn * axis
        return centre, np.append(motion, turn)

    def mass(self, motion):
        return motion @ (motion * [1, 1, self.inertia])

    def legs(self):
        """Ways of the front corner at which a kink is met, by itself or by the rear corner; then the end of the track."""
        ends = [(self.s[k], "front") for k in range(1, len(self.s) - 1)]
        for k in range(1, len(self.s) - 1):
            for segment in range(k - 1, len(self.tangent)):
                gap = self.corners[segment] - self.corners[k]
                along = -gap @ self.tangent[segment]
                inside = self.length**2 - (gap @ gap - along**2)
                front = self.s[segment] + along + math.sqrt(max(inside, 0.0))
                if inside >= 0 and self.s[segment] - 1e-12 <= front <= self.s[segment + 1] + 1e-12 and front > self.s[k]:
                    ends.append((front, "rear"))
                    break
        return [*sorted(ends), (self.s[-1], "end")]

    def slide(self, speed):
        """Up from the foot and back; sets top_time (from the foot), rise and speed_back."""
        legs = self.legs()
        self.front_segment, self.rear_segment = 0, 0
        low = self.height / 2
        velocity = np.array([speed, 0.0, 0.0])
        passed, time = [], 0.0
        for (front, which), (end, _) in zip(legs, legs[1:]):
            passed.append((front, which))
            self.front_segment += which == "front"
            self.rear_segment += which == "rear"
            centre, motion = self.state(front)
            rate = (motion * [1, 1, self.inertia]) @ velocity / self.mass(motion)
            energy = self.mass(motion) * rate**2 / 2 + self.g * centre[1]
            left = energy - self.g * self.state(end)[0][1]
            if left <= 0:
                break
            time += self.time(front, end, energy)
            motion = self.state(end)[1]
            velocity = motion * math.sqrt(2 * left / self.mass(motion))
        top = bisect(lambda s: self.g * self.state(s)[0][1] < energy, front, end)
        self.top_time = time + self.time(front, top, energy)
        self.rise = energy / self.g - low
        for front, which in reversed(passed):
            centre, motion = self.state(front)
            left = energy - self.g * centre[1]
            velocity = -motion * math.sqrt(2 * left / self.mass(motion))
            self.front_segment -= which == "front"
            self.rear_segment -= which == "rear"
            motion = self.state(front)[1]
            rate = (motion * [1, 1, self.inertia]) @ velocity / self.mass(motion)
            energy = self.mass(motion) * rate**2 / 2 + self.g * centre[1]
        self.speed_back = -rate

    def time(self, start, end, energy, order=40):
        """Between two ways; s = end - u^2 takes the singularity at a top away."""
        x, w = np.polynomial.legendre.leggauss(order)
        u = math.sqrt(end - start) * (x + 1) / 2
        total = 0.0
        for ui, wi in zip(u, w):
            centre, motion = self.state(end - ui**2)
            total += wi * ui * math.sqrt(self.mass(motion) / (2 * (energy - self.g * centre[1])))
        return total * math.sqrt(end - start)


# The mean of the free corners of the cantilever of Zhang et al. 2019, section 5.3, goes so far back along the beam and down: the solution of
# two dimensions with Green strain, by 320 six-node triangles of an independent program. The elastica, without shear, has 0.25442, 0.60325.
CANTILEVER = 0.2585890769, 0.6097706595


def confined_stress(depth, load, weight, nu):
    """Stress (xx, yy, xy) at some depths of rock that cannot go aside, in plane strain, with a load on its top."""
    across = -(load + weight * np.asarray(depth, float))
    return np.column_stack([nu / (1 - nu) * across, across, 0 * across])


def confined_settlement(height, load, weight, young, nu):
    """Of its top: (load h + weight h^2/2)/M."""
    return (load * height + weight * height**2 / 2) * (1 + nu) * (1 - 2 * nu) / (young * (1 - nu))


def dam_friction(width, height, weight, water):
    """Coefficient with which a box just stands against water to its crest: thrust over weight."""
    return water * height**2 / 2 / (weight * width * height)


def dam_width(height, weight, water):
    """Width with which it just does not turn about its toe: weight b h b/2 = water h^3/6."""
    return height * math.sqrt(water / (3 * weight))


def passed_wave(stiffness, impedance, time, velocity):
    """Velocity behind a joint that a wave meets at right angles: dv/dt = 2 k/z (v_in - v) (Schoenberg 1980; Pyrak-Nolte et al. 1990).

    `stiffness` is per unit area, `impedance` is rho c; the incoming velocity is linear between the times.
    """
    passed, rate = np.zeros_like(velocity), 2 * stiffness / impedance
    for i, dt in enumerate(np.diff(time)):
        slope, kept = (velocity[i + 1] - velocity[i]) / dt, math.exp(-rate * dt)
        passed[i + 1] = passed[i] * kept + velocity[i] * (1 - kept) + slope * (dt - (1 - kept) / rate)
    return passed


def wave_speeds(density, young, nu):
    """Of waves of pressure and shear in plane strain."""
    return {"p": math.sqrt(young * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) / density), "s": math.sqrt(young / (2 * (1 + nu)) / density)}


def shaken_layer(height, speed, w, alpha, beta):
    """Displacement amplitude of the top of a layer relative to a ground that shakes with the acceleration 1 and the circular frequency w,
    with Rayleigh damping: the shear beam (1 - 1/cos(k H))/(w^2 - i w alpha)."""
    k = cmath.sqrt((w**2 - 1j * w * alpha) / (speed**2 * (1 + 1j * w * beta)))
    return abs((1 - 1 / cmath.cos(k * height)) / (w**2 - 1j * w * alpha))


def barton_strength(stress, jrc, jcs, phi):
    """Shear strength of a rough joint (Barton & Choubey 1977), phi in degrees."""
    return stress * math.tan(math.radians(phi + jrc * math.log10(jcs / stress)))


def joint_closure(force, stiffness, most):
    """Of a joint that stiffens (Bandis et al. 1983): force = stiffness u/(1 - u/most)."""
    return force * most / (stiffness * most + force)


def softening(strength, opening, gap, largest):
    """Traction of a bond whose strength falls linearly to 0 at an opening, at a gap after a larger one (Hillerborg et al. 1976)."""
    return strength * max(0.0, 1 - largest / opening) * gap / largest


def deepest_closure(force, stiffness, most):
    """Where a force that acts at once has done the work of the joint's curve, by bisection."""
    low, high = 0.0, most
    for _ in range(60):
        u = 0.5 * (low + high)
        low, high = (u, high) if force * u > stiffness * most**2 * (-math.log(1 - u / most) - u / most) else (low, u)
    return low


def dilating_ride(push, gravity, phi, psi, time):
    """Ways along and up of a block on a joint that dilates: m x'' = m push - N tan phi, N - m gravity = m x'' tan psi; degrees."""
    friction, dilation = math.tan(math.radians(phi)), math.tan(math.radians(psi))
    along = 0.5 * (push - gravity * friction) / (1 + friction * dilation) * time**2
    return along, along * dilation


def dilating_hold(push, weight, stiffness, joint, phi, psi, height):
    """Ways along and up of the middle of a block of length 1 under a spring: (weight + stiffness up) tan phi is the push at half its height.

    The joint gives alike across and along, at the ends of the block; by that it tilts.
    """
    friction, dilation = math.tan(math.radians(phi)), math.tan(math.radians(psi))
    up = (push / friction - weight) / stiffness
    tilt = 2 * push * height / joint * (1 + friction * dilation)
    return (up + push / friction / joint) / dilation + push / joint + tilt * height / 2, up


def bonded_strength(stress, cohesion, phi):
    """Coulomb's, phi in degrees."""
    return stress * math.tan(math.radians(phi)) + cohesion


def green_stretch(ratio):
    """Stretch of a bar with nu 0 under a dead load over E A, S = E (l^2 - 1)/2: the largest root of l (l^2 - 1)/2 = ratio.

    There is none above l = 1/sqrt 3, where the tangent 3 l^2 - 1 is 0, below a ratio of -1/sqrt 27."""
    return max(root.real for root in np.roots([0.5, 0.0, -0.5, -ratio]) if abs(root.imag) < 1e-9)


def elastica(load):
    """Shortening and deflection over the length of a cantilever under P L^2/EI = load at its end (Bisshopp & Drucker 1945).

    With a the slope at the end, ds/L = da'/(2 load (sin a - sin a'))^1/2 for a slope a'; a - a' = q^2 takes the root at the end away."""
    x, w = np.polynomial.legendre.leggauss(60)

    def along(end):
        q = math.sqrt(end) * (x + 1) / 2
        angle = end - q**2
        return angle, math.sqrt(end) * w * q / np.sqrt(2 * load * (math.sin(end) - np.sin(angle)))

    end = bisect(lambda a: along(a)[1].sum() < 1, 1e-6, math.pi / 2 - 1e-9)
    angle, length = along(end)
    return 1 - length @ np.cos(angle), length @ np.sin(angle)


class TimoshenkoBeam:
    """A cantilever of unit width in plane stress with shear coefficient 5/6 (Timoshenko 1921)."""

    def __init__(self, length, height, young, poisson, density):
        self.length, self.mass, self.rotary = length, density * height, density * height**3 / 12
        self.bending, self.shear = young * height**3 / 12, 5 / 6 * young / (2 * (1 + poisson)) * height

    def deflection(self, force):
        """Of its end under a force there."""
        return force * self.length**3 / (3 * self.bending) + force * self.length / self.shear

    def free_end(self, f):
        """Determinant of moment and shear at the free end for those at the clamped one: 0 at a frequency of its own.

        Deflection w, angle a, moment M = EI a', shear V = kGA (w' - a): M' = -V - rho I W^2 a, V' = -rho A W^2 w, W = 2 pi f;
        M and V over EI, so that all numbers are of a size."""
        squared = (2 * math.pi * f)**2
        slope = np.array([[0, 1, 0, self.bending / self.shear], [0, 0, 1, 0], [0, -self.rotary * squared / self.bending, 0, -1],
                          [-self.mass * squared / self.bending, 0, 0, 0]])
        rates, modes = np.linalg.eig(slope)
        along = (modes * np.exp(rates * self.length)) @ np.linalg.inv(modes)
        return np.linalg.det(along[2:, 2:]).real

    def frequency(self):
        """Its first: below that of Euler and Bernoulli, 1.8751^2/2 pi (EI/rho A L^4)^1/2."""
        slender = 1.8751040687**2 / (2 * math.pi) * math.sqrt(self.bending / (self.mass * self.length**4))
        return bisect(lambda f: self.free_end(f) > 0, 0.5 * slender, 1.001 * slender)


def clamped_corner(nu):
    """Least power of the distance with which displacement grows from a corner of 90 degrees, one side clamped, one free, in plane stress
    (Williams 1952); energy, and deflection under a load, converge with twice that power of the mesh, where elements would allow more.

    sin^2(p w) = (k + 1)^2/4k - p^2 sin^2(w)/k with k = (3 - nu)/(1 + nu), w = pi/2."""
    k = (3 - nu) / (1 + nu)
    return bisect(lambda p: math.sin(p * math.pi / 2)**2 < (k + 1)**2 / (4 * k) - p**2 / k, 0.5, 1.0)


# Paths of notches that grow in a beam of 20 by 8 with three holes (Bittencourt, Wawrzynek, Ingraffea and Sousa 1996), by where the notch is.
# By the manifold method with quadratic covers and triangles of 0.25, in pieces of 0.25; linear ones of 0.15 agree within 0.005.
THREE_HOLES = {
    5: [(5.329, 2.444), (5.564, 2.884), (5.850, 3.290), (6.037, 3.753), (6.34, 4.69)],  # 1.5 long
    4: [(4.47, 2.42), (4.95, 3.30), (5.33, 3.95), (5.69, 4.60)],                         # 1 long
}

# K_I and K_II of cracks over s (pi a)^(1/2), with s the load; of the disc over P (a/pi)^(1/2)/R. By collocation on the boundary with
# Muskhelishvili's potentials, converged to the digits given. Tada, Paris and Irwin 2000 have 1.1862 for "centre" with a height of twice the
# width, where collocation gives 1.18764.
CRACKS = {
    "centre": (1.33371, 0.0),         # square plate, a half of its half width
    "inclined": (0.66908, 0.61677),   # the same at 45 degrees to the load
    "tilted": (0.90460, 0.46187),     # plate twice as high, 30 degrees off the normal of the load
    "edge": (2.8255, 0.0),            # plate twice as high as wide, a half of its width
    "disc": (1.05534, 1.20912),       # a half of the radius, 10 degrees to the load
    "closed": (0.0, 1.05888),         # square plate, a a quarter of its half width, pressed at 45 degrees; over the stress that makes it slip
}


def kink_angle(K_I, K_II):
    """Angle of the largest circumferential stress at a tip from the direction of its crack, degrees, and the intensity there: the maximum
    over all angles, by halving an interval (Erdogan and Sih 1963)."""
    def slope(t):
        return K_I * math.sin(t) + K_II * (3 * math.cos(t) - 1)

    t = bisect(lambda t: slope(t) > 0, 0.0, -math.pi / 2) if K_II else 0.0
    return math.degrees(t), math.cos(t / 2)**2 * (K_I * math.cos(t / 2) - 3 * K_II * math.sin(t / 2))



@dataclasses.dataclass
class DoubleCantilever:
    """Two arms with a crack between them that grows at an energy per area, by G = 12 (P (a + 0.673 h))^2/(E' h^3) and the compliance that
    this G has, per unit thickness (Foote and Buchwald 1985)."""
    height: float
    modulus: float
    energy: float

    def opening(self, length):
        """Way between the ends of the arms at which the crack has a length."""
        return 4 * (length + 0.673 * self.height)**2 * math.sqrt(self.energy / (3 * self.modulus * self.height**3))

    def length(self, opening):
        return np.sqrt(opening / self.opening(1 - 0.673 * self.height)) - 0.673 * self.height

    def load(self, opening):
        return self.modulus * self.height**3 * opening / (8 * (self.length(opening) + 0.673 * self.height)**3)
