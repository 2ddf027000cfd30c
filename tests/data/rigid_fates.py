"""The fate of a pad on a rigid disc, found independently of the program, and the two files of cases made from it.

    python rigid_fates.py check rigid-fates.csv         every case of a file again; prints the disagreements
    python rigid_fates.py one FILE.csv ROW              one row in detail, its return map included
    python rigid_fates.py make rigid-fates-more.csv     2000 cases around the boundaries of the verdicts, about 5 minutes

Needs numpy and numba. Nothing here is taken from the program's own sources.

The model
---------
The pad slides or sticks under a constant normal force N (sections 3, 4 and 7 of the physics notes; sin phi = 0):

    M eta0 x'' = -(k_x + k_t2) x - c_x sqrt(eta0) x' + (k_t2 / k_t1) mu(v - x') N,     N = k_en k_y Delta / (k_en + k_y),
    mu(r) = sign(r) (f_c + (f_s - f_c) exp(-(|r| / v_s)^delta)).

All is computed in units in which the frequency sqrt((k_x + k_t2) / (M eta0)) and the speed of the disc are 1 and the place y
counts from the sliding equilibrium. Five numbers are left: the damping ratio zeta, A and B (strength of the falling
and of the constant part of friction), s = v_s / v and delta. With u = y' and w = 1 - u, the speed of sliding,

    u' = -y - 2 zeta u + phi(u),     phi(u) = A (exp(-(w / s)^delta) - exp(-(1 / s)^delta)),     w > 0.

The pad sticks (u = 1) while y lies between -(2 B + A (1 + exp(-(1/s)^delta))) - 2 zeta and the release point
phi(1) - 2 zeta. Near sticking the unknown is w itself, and y counts from the release point, so that nothing cancels.

How a fate is found
-------------------
The motion is planar and autonomous, so orbits never cross, and the section {u = 0, y > 0} has a monotone return map P.
h(a) = P(a) / a - 1 is the relative change per cycle.

1. Motion that sticks follows one orbit afterwards, the one released from stick. If that sticks again, the motion repeats for
   ever: stick-slip. If not, it winds inwards from its first turning point.
2. Motion that winds inwards ends on the first fixed point of P below it, or at the equilibrium where there is none. An
   equilibrium that is linearly unstable is never approached. Otherwise h is scanned inwards down to the disc
   |u| < R in which 2 zeta - phi(u) / u is positive and every motion loses energy. Steps are a tenth of the amplitude,
   and shorter where the least sliding speed of the orbit changes within the exponential of the friction law.
   Where |h| has a minimum on the way, it is refined by golden section.
3. Motion that winds outwards is scanned outwards in the same way, to a fixed point (a smooth cycle) or into stick.

Orbits are computed by the Dormand-Prince pair of order 5(4), with a tolerance of 1e-12 of the motion's own radius, and of
the sliding speed itself near sticking; steps are also kept short against the width of the exponential. Turning points, stick
and the least sliding speed inside a step are located by bisection.

The margin
----------
How near a case is to another verdict or another kind of motion: the least of the numbers that decided. These are |h| wherever
its sign was relied on (for a smooth cycle: the largest |h| on its far side, which vanishes where two cycles meet),
the linear decay rate over the frequency where the equilibrium is approached, and, where it matters whether an orbit sticks,
the relative distance of its turning point from that of the orbit that only just does. 0.01 is comfortable, 1e-7 is the least
that is written; below it a case is left out.
"""

import csv
import math
import sys
import time
from collections import Counter
from typing import NamedTuple

import numpy as np
from numba import njit

PRESET = dict(density=7800.0, youngs=2.1e11, nu=0.3, h=0.020, b=0.135, mass=0.10, k_x=3.249e7, k_y=3.249e7,
              k_en=3.816e7, k_t1=2.138e7, k_t2=2.138e7)
COLUMNS = ["damping.tangential", "friction.kinetic_coefficient", "friction.stribeck_velocity",
           "friction.stribeck_exponent", "preload", "static_friction", "rotating_speed", "start", "displacement",
           "fate", "kind", "damping_ratio"]
INPUTS = COLUMNS[:7]
RESOLUTION = 1e-7
TURNED, STUCK, HOME, FAILED = 1, 2, 3, 4
TOLERANCE = 1e-12


def scales():
    """Disc stiffness over density: eta0, the unit of speed, and the pad's stiffness, frequency, normal force at unit preload."""
    q = PRESET
    rigidity = q["youngs"] * q["h"] ** 3 / (12.0 * (1.0 - q["nu"] ** 2))
    eta0 = rigidity / (q["density"] * q["h"] ** 4)
    speed = math.sqrt(rigidity / (q["density"] * q["h"] ** 2))
    stiffness = q["k_x"] + q["k_t2"]
    omega = math.sqrt(stiffness / (q["mass"] * eta0))
    normal = q["k_en"] * q["k_y"] / (q["k_en"] + q["k_y"])
    return eta0, speed, stiffness, omega, normal


ETA0, SPEED, STIFFNESS, OMEGA, NORMAL = scales()
CRITICAL_DAMPING = 2.0 * math.sqrt(STIFFNESS * PRESET["mass"])


def reduced(case):
    """The five numbers (and two derived from them) that the motion depends on: 2 zeta, A, B, s, delta, exp(-(1/s)^delta), release point."""
    v = PRESET["b"] * case["rotating_speed"] / SPEED
    pull = PRESET["k_t2"] / PRESET["k_t1"] * NORMAL * case["preload"] / (PRESET["mass"] * ETA0)
    zeta2 = case["damping.tangential"] * math.sqrt(ETA0) / (PRESET["mass"] * ETA0) / OMEGA
    fall = pull * (case["static_friction"] - case["friction.kinetic_coefficient"]) / (OMEGA * v)
    constant = pull * case["friction.kinetic_coefficient"] / (OMEGA * v)
    s = case["friction.stribeck_velocity"] / SPEED / v
    return parameters(zeta2, fall, constant, s, case["friction.stribeck_exponent"])


def parameters(zeta2, fall, constant, s, delta):
    top = s ** -delta
    return np.array([zeta2, fall, constant, s, delta, math.exp(-top), -fall * math.expm1(-top) - zeta2])


# ---------------------------------------------------------------------------------------------------- the motion


@njit
def friction_change(u, p):
    """phi(u): friction at the pad's speed u less friction at the equilibrium, u < 1, without cancellation for small u."""
    w = 1.0 - u
    fall, s, delta = p[1], p[3], p[4]
    log_w = math.log1p(-u) if u < 0.5 else math.log(w)
    exponent = -s ** -delta * math.expm1(delta * log_w)
    if exponent <= 1.0:
        return fall * p[5] * math.expm1(exponent)
    return fall * (math.exp(-((w / s) ** delta)) - p[5])


@njit
def rates(mode, a, b, p):
    """mode 0: (y, u); mode 1: (y - release point, w); mode 2, pad faster than the disc: (y, u - 1)."""
    if mode == 0:
        return b, -a - p[0] * b + friction_change(b, p)
    if mode == 1:
        change = 0.0
        if b > 0.0:
            change = -p[1] * math.expm1(-math.exp(p[4] * math.log(b / p[3])))
        return 1.0 - b, a - p[0] * b + change
    falling = 1.0
    if b > 0.0:
        falling = math.exp(-((b / p[3]) ** p[4]))
    return 1.0 + b, -a - p[0] * (1.0 + b) - (2.0 * p[2] + p[1] * p[5] + p[1] * falling)


@njit
def step(mode, a, b, k1a, k1b, h, p):
    """One Dormand-Prince step: new state, its rates, and the two error estimates."""
    k2a, k2b = rates(mode, a + h * 0.2 * k1a, b + h * 0.2 * k1b, p)
    k3a, k3b = rates(mode, a + h * (3 / 40 * k1a + 9 / 40 * k2a), b + h * (3 / 40 * k1b + 9 / 40 * k2b), p)
    k4a, k4b = rates(mode, a + h * (44 / 45 * k1a - 56 / 15 * k2a + 32 / 9 * k3a),
                     b + h * (44 / 45 * k1b - 56 / 15 * k2b + 32 / 9 * k3b), p)
    k5a, k5b = rates(mode, a + h * (19372 / 6561 * k1a - 25360 / 2187 * k2a + 64448 / 6561 * k3a - 212 / 729 * k4a),
                     b + h * (19372 / 6561 * k1b - 25360 / 2187 * k2b + 64448 / 6561 * k3b - 212 / 729 * k4b), p)
    k6a, k6b = rates(mode, a + h * (9017 / 3168 * k1a - 355 / 33 * k2a + 46732 / 5247 * k3a + 49 / 176 * k4a - 5103 / 18656 * k5a),
                     b + h * (9017 / 3168 * k1b - 355 / 33 * k2b + 46732 / 5247 * k3b + 49 / 176 * k4b - 5103 / 18656 * k5b), p)
    na = a + h * (35 / 384 * k1a + 500 / 1113 * k3a + 125 / 192 * k4a - 2187 / 6784 * k5a + 11 / 84 * k6a)
    nb = b + h * (35 / 384 * k1b + 500 / 1113 * k3b + 125 / 192 * k4b - 2187 / 6784 * k5b + 11 / 84 * k6b)
    k7a, k7b = rates(mode, na, nb, p)
    ea = h * (71 / 57600 * k1a - 71 / 16695 * k3a + 71 / 1920 * k4a - 17253 / 339200 * k5a + 22 / 525 * k6a - k7a / 40)
    eb = h * (71 / 57600 * k1b - 71 / 16695 * k3b + 71 / 1920 * k4b - 17253 / 339200 * k5b + 22 / 525 * k6b - k7b / 40)
    return na, nb, k7a, k7b, ea, eb


@njit
def locate(mode, a, b, k1a, k1b, h, p, of_rate, sign):
    """The part of the step h at which b (or its rate) has just got the sign `sign`."""
    low, high = 0.0, h
    for _ in range(60):
        mid = 0.5 * (low + high)
        if mid == low or mid == high:
            break
        na, nb, ra, rb, _, _ = step(mode, a, b, k1a, k1b, mid, p)
        value = rb if of_rate else nb
        if value * sign > 0.0:
            high = mid
        else:
            low = mid
    return high


@njit
def simulate(mode, a, b, p, return_radius, tolerance):
    """Simulates the motion to its next upper turning point, into stick, or back to the equilibrium.

    Returns (what happened, y of the turning point or of sticking, least sliding speed on the way, times the pad overtook)."""
    s = p[3]
    release = p[6]
    lowest = -(2.0 * p[2] + p[1] * (1.0 + p[5])) - p[0]
    h = 1e-3
    least = 1e300
    overtaken = 0
    for _ in range(20_000_000):
        ka, kb = rates(mode, a, b, p)
        if mode == 0:
            y, u, w = a, b, 1.0 - b
        elif mode == 1:
            y, u, w = a + release, 1.0 - b, b
        else:
            y, u, w = a, 1.0 + b, b
        least = min(least, w if mode < 2 else 0.0)
        radius = math.hypot(y, u)
        if radius <= return_radius:
            return HOME, y, least, overtaken
        # Steps are short against the width over which friction changes.
        width = 0.3 * (w + 0.1 * s)
        limit = 0.2
        if abs(kb) * limit > width:
            limit = width / abs(kb)
        if mode > 0 and limit * limit > 0.7 * width:
            limit = math.sqrt(0.7 * width)
        h = min(h, limit)
        while True:
            na, nb, ra, rb, ea, eb = step(mode, a, b, ka, kb, h, p)
            size_b = radius if mode == 0 else min(radius, max(w, abs(nb)) + 1e-5 * min(1.0, s))
            error = max(abs(ea) / radius, abs(eb) / size_b) / tolerance
            if error <= 1.0:
                break
            h *= max(0.2, 0.9 * error ** -0.2)
            if h < 1e-200:
                return FAILED, y, least, overtaken
        if mode == 0:
            if b > 0.0 and nb <= 0.0 and na > 0.0:
                t = locate(0, a, b, ka, kb, h, p, False, -1.0) if nb < 0.0 else h
                na, nb, ra, rb, ea, eb = step(0, a, b, ka, kb, t, p)
                return TURNED, na, least, overtaken
        elif mode == 1:
            until = -1.0
            if nb <= 0.0:
                until = h
            elif kb < 0.0 and rb > 0.0:
                # A least sliding speed inside the step: does it touch stick?
                t = locate(1, a, b, ka, kb, h, p, True, 1.0)
                ma, mb, _, _, _, _ = step(1, a, b, ka, kb, t, p)
                least = min(least, max(mb, 0.0))
                if mb <= 0.0:
                    until = t
            if until >= 0.0:
                t = locate(1, a, b, ka, kb, until, p, False, -1.0)
                ma, mb, _, _, _, _ = step(1, a, b, ka, kb, t, p)
                y = ma + release
                if y >= lowest:
                    return STUCK, y, 0.0, overtaken
                mode, a, b = 2, y, 0.0
                overtaken += 1
                continue
        elif nb <= 0.0 and b > 0.0:
            t = locate(2, a, b, ka, kb, h, p, False, -1.0)
            y, mb, _, _, _, _ = step(2, a, b, ka, kb, t, p)
            if y <= release:
                return STUCK, y, 0.0, overtaken
            mode, a, b = 1, y - release, 0.0
            continue
        a, b = na, nb
        h *= min(4.0, 0.9 * max(error, 1e-10) ** -0.2)
        if mode == 0 and b > 0.5:
            mode, a, b = 1, a - release, 1.0 - b
        elif mode == 1 and b > 0.6:
            mode, a, b = 0, a + release, 1.0 - b
    return FAILED, a, least, overtaken


@njit
def after_turning(amplitude, p, return_radius, tolerance):
    """The return map: from the turning point y = amplitude (upper if positive, lower if negative) to the next upper one."""
    return simulate(0, amplitude, 0.0, p, return_radius, tolerance)


# ---------------------------------------------------------------------------------------------------- the verdict


def half_growth(p):
    """Linear growth rate over the frequency: half of phi'(0) - 2 zeta."""
    zeta2, fall, _, s, delta, _, _ = p
    top = s ** -delta
    return 0.5 * (fall * delta * top * math.exp(-top) - zeta2)


@njit
def certain_radius(p):
    """A speed below which 2 zeta - phi(u) / u is positive for both signs: there every motion loses energy."""
    u = 1e-9
    found = 1.0
    while u < 1.0:
        ahead = p[0] - friction_change(u, p) / u
        behind = p[0] + friction_change(-u, p) / u
        if ahead <= 0.0 or behind <= 0.0:
            found = u
            break
        u *= 1.005
    return found * 0.98 if found < 1.0 else 0.999999


class Scan:
    """h along the section, from one amplitude inwards or outwards."""

    def __init__(self, p, tolerance):
        self.p = p
        self.tolerance = tolerance
        self.growth = float(half_growth(p))
        self.radius = certain_radius(p) if self.growth < 0.0 else 0.0
        self.overtaken = 0

    def change(self, amplitude):
        what, y, least, over = after_turning(amplitude, self.p, 1e-3 * self.radius, self.tolerance)
        if what == FAILED:
            raise ArithmeticError("the motion was not simulated to its end")
        self.overtaken += over
        h = y / amplitude - 1.0 if what == TURNED else (math.inf if what == STUCK else -1.0)
        return what, h, least

    def extremum(self, left, right, sign):
        """The least sign * h between two amplitudes, by golden section in the logarithm of the amplitude."""
        ratio = 0.5 * (math.sqrt(5.0) - 1.0)
        low, high = math.log(left), math.log(right)
        x1, x2 = high - ratio * (high - low), low + ratio * (high - low)
        f1, f2 = sign * self.change(math.exp(x1))[1], sign * self.change(math.exp(x2))[1]
        while high - low > 1e-6:
            if f1 < f2:
                high, x2, f2 = x2, x1, f1
                x1 = high - ratio * (high - low)
                f1 = sign * self.change(math.exp(x1))[1]
            else:
                low, x1, f1 = x1, x2, f2
                x2 = low + ratio * (high - low)
                f2 = sign * self.change(math.exp(x2))[1]
            if high - low < 1e-3 and abs(f1 - f2) < 1e-3 * max(abs(f1), abs(f2)):
                break
        return (f1, math.exp(x1)) if f1 < f2 else (f2, math.exp(x2))

    def run(self, start, direction, sign, end, enough=math.inf):
        """Scans from `start` (direction -1 inwards, +1 outwards) to `end` while h has the sign `sign` and |h| is below `enough`.

        Returns why it stopped ("end", "enough", "crossed", "stuck", "returned"), where, the least |h| and the largest |h| on the way,
        and how far beyond zero h was seen to go."""
        layer = 0.02 * self.p[3]
        what, h, least = self.change(start)
        if what == STUCK:
            return "stuck", start, 1.0, 0.0, 0.0
        if what == HOME:
            return "returned", start, 1.0, 1.0, 0.0
        if h * sign <= 0.0:
            return "crossed", start, 0.0, 0.0, abs(h)
        trail = [(start, h, least)]
        nearest = largest = abs(h)
        part = 0.1
        while True:
            at, h_at, least_at = trail[-1]
            if (at - end) * direction >= 0.0:
                return "end", at, nearest, largest, 0.0
            if largest >= enough:
                return "enough", at, nearest, largest, 0.0
            new = at / (1.0 - part) if direction > 0 else max(at * (1.0 - part), 0.999 * end)
            what, h, least = self.change(new)
            jump = abs(math.log((least + layer) / (least_at + layer)))
            if part > 1e-9 and (what == STUCK or jump > 0.2 or abs(h - h_at) > 0.3 + 0.3 * min(abs(h), abs(h_at))):
                part *= 0.5
                continue
            if what == STUCK:
                return "stuck", new, nearest, largest, 0.0
            if what == HOME:
                return "returned", new, nearest, largest, 0.0
            if h * sign <= 0.0:
                return "crossed", new, nearest, largest, abs(h)
            trail.append((new, h, least))
            nearest, largest = min(nearest, abs(h)), max(largest, abs(h))
            if len(trail) > 2 and abs(trail[-2][1]) <= min(abs(trail[-3][1]), abs(h)) and abs(trail[-2][1]) < 0.3:
                a0, a2 = trail[-3][0], new
                best, where = self.extremum(min(a0, a2), max(a0, a2), sign)
                if best <= 0.0:
                    return "crossed", where, nearest, largest, -best
                nearest = min(nearest, best)
            if jump < 0.07:
                part = min(0.1, 2.0 * part)

    def beyond(self, crossed, direction, sign):
        """How far h goes beyond zero on the other side of a crossing (0.01 is enough to know)."""
        at, depth = crossed
        return max(depth, self.run(at, direction, -sign, 0.03 * at if direction < 0 else math.inf, enough=0.01)[3])


class Verdict(NamedTuple):
    fate: str
    kind: str
    margin: float
    why: str
    overtaken: int
    sticks: bool  # is there a stick phase on the way?


def grazing_distance(p, turning, tolerance):
    """How far, relatively, a turning point (of either sign) is from the one whose orbit only just sticks; 0.3 at most."""
    sticks = after_turning(turning, p, 1e-12, tolerance)[0] == STUCK
    distance = 1e-8
    while distance < 0.3:
        factor = 1.0 - distance if sticks else 1.0 / (1.0 - distance)
        if (after_turning(turning * factor, p, 1e-12, tolerance)[0] == STUCK) != sticks:
            return distance
        distance *= 1.5
    return 0.3


def fate(case, tolerance=TOLERANCE):
    """The verdict on one case."""
    if case["preload"] <= 0.0 or case["static_friction"] < case["friction.kinetic_coefficient"]:
        return Verdict("stable", "equilibrium", 1.0, "outside physics", 0, False)
    p = reduced(case)
    scan = Scan(p, tolerance)
    place = p[2] + p[1] * p[5]  # of the equilibrium, counted from where the pad's spring is relaxed

    def verdict(fate, kind, margin, why):
        return Verdict(fate, kind, min(margin, 1.0), why, scan.overtaken, sticks)

    # To the first upper turning point, or into stick; `graze` is how near the motion came to the other of the two.
    sticks = case["start"] == "limit-cycle"
    margin, graze = 1.0, 1.0
    if case["start"] == "near-equilibrium":
        turning = case["displacement"] * place
    elif case["start"] == "rest":
        what, turning, _, over = after_turning(-place, p, scan.radius, tolerance)
        scan.overtaken += over
        if what == HOME:
            return verdict("stable", "equilibrium", -scan.growth, "returns to the equilibrium at once")
        if what == STUCK:
            sticks, graze = True, grazing_distance(p, -place, tolerance)

    # From there outwards, until it sticks, or winds inwards.
    if not sticks:
        what, h, _ = scan.change(turning)
        if what == HOME:
            return verdict("stable", "equilibrium", -scan.growth, "returns to the equilibrium without turning again")
        if what == TURNED and h < 0.0:
            return inwards(scan, turning, 1.0, verdict)
        sticks = True
        if what == STUCK:
            graze = grazing_distance(p, turning, tolerance)
        else:
            why, at, margin, _, depth = scan.run(turning, +1, 1.0, math.inf)
            if why == "crossed":
                sticks = False
                return verdict("unstable", "smooth-cycle", min(margin, scan.beyond((at, depth), +1, 1.0)), "winds outwards to a smooth cycle")
            if why != "stuck":
                raise ArithmeticError("winding outwards ended in: " + why)

    # From stick every motion goes the same way.
    what, turning, _, over = simulate(1, 0.0, 0.0, p, scan.radius, tolerance)
    scan.overtaken += over
    if what == HOME:
        return verdict("stable", "equilibrium", min(margin, -scan.growth), "is released and returns to the equilibrium without turning")
    if what != TURNED:
        raise ArithmeticError("the released orbit does not turn")
    what, h, _ = scan.change(turning)
    if what == HOME:
        return verdict("stable", "equilibrium", min(margin, -scan.growth), "is released and returns to the equilibrium without turning again")
    released = grazing_distance(p, turning, tolerance)
    if what == STUCK:
        return verdict("unstable", "stick-slip", min(margin, graze, released), "the released orbit sticks again")
    if h >= 0.0:
        raise ArithmeticError("the released orbit winds outwards")
    return inwards(scan, turning, min(margin, released), verdict)


def inwards(scan, turning, margin, verdict):
    """The fate of motion that winds inwards from a turning point."""
    end = scan.radius if scan.growth < 0.0 else 1e-6 * turning
    why, at, nearest, _, depth = scan.run(turning, -1, -1.0, end)
    margin = min(margin, nearest)
    if why == "crossed":
        inside = max(scan.growth, scan.beyond((at, depth), -1, -1.0))
        return verdict("unstable", "smooth-cycle", min(margin, inside), "winds inwards to a smooth cycle")
    if scan.growth > 0.0:
        return verdict("unstable", "smooth-cycle", min(margin, scan.growth), "winds inwards, but its equilibrium is unstable")
    return verdict("stable", "equilibrium", min(margin, -scan.growth), "winds inwards to its equilibrium")


# ----------------------------------------------------------------------------------------------------- the files


def read(path):
    with open(path) as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return [{k: v if k in ("start", "fate", "kind") else float(v) for k, v in row.items()} for row in rows]


def check(path):
    cases = read(path)
    wrong = 0
    begin = time.time()
    for number, case in enumerate(cases):
        found = fate(case)
        if (found.fate, found.kind) != (case["fate"], case["kind"]):
            wrong += 1
            print(f"row {number}: file {case['fate']} {case['kind']}, found {found}, case {case}")
    print(f"{len(cases)} cases, {wrong} disagreements, {time.time() - begin:.0f} s")


def one(path, row):
    case = read(path)[row]
    p = reduced(case)
    print(case)
    print(fate(case))
    print(f"zeta {p[0] / 2:.6g}, A {p[1]:.6g}, B {p[2]:.6g}, v_s/v {p[3]:.6g}, delta {p[4]}, growth {half_growth(p):.6g}")
    if case["start"] == "near-equilibrium":
        mode, a, b = 0, case["displacement"] * (p[2] + p[1] * p[5]), 0.0
    elif case["start"] == "rest":
        mode, a, b = 0, -(p[2] + p[1] * p[5]), 0.0
    else:
        mode, a, b = 1, 0.0, 0.0
    for turn in range(60):
        what, y, least, over = simulate(mode, a, b, p, 0.0, TOLERANCE)
        print(turn, ["", "turns", "sticks", "returned", "failed"][what], f"y {y!r}, least sliding speed {least:.3g} v, overtook {over}")
        mode, a, b = (1, 0.0, 0.0) if what == STUCK else (0, y, 0.0)


# ------------------------------------------------------------------------------------------- drawing 2000 cases


class NoBoundary(Exception):
    """These parameters have no boundary of the kind that was asked for: draw again."""


def log_uniform(rng, low, high):
    return float(math.exp(rng.uniform(math.log(low), math.log(high))))


def draw(rng, starts=(1, 1, 1), exponents=None):
    """Everything but the rotating speed; `starts` weighs near-equilibrium, rest and limit-cycle."""
    if exponents is None:
        exponents = (0.5, 0.7, 1.0, 1.5, 2.0, 3.0, (0.5, 3.0))
    chosen = exponents[rng.integers(len(exponents))]
    exponent = float(chosen if isinstance(chosen, float) else rng.uniform(*chosen))
    kinetic = float(rng.uniform(0.05, 0.5))
    start = ("near-equilibrium", "rest", "limit-cycle")[rng.choice(3, p=np.array(starts) / sum(starts))]
    displacement = 0.01 if rng.random() < 0.75 else log_uniform(rng, 1e-3, 0.3)
    return {
        "damping.tangential": log_uniform(rng, 1e-3, 0.5) * CRITICAL_DAMPING,
        "friction.kinetic_coefficient": kinetic,
        "friction.stribeck_velocity": log_uniform(rng, 0.05, 3.0),
        "friction.stribeck_exponent": exponent,
        "preload": float(rng.uniform(0.02, 0.4)),
        "static_friction": kinetic * float(rng.uniform(1.0, 3.0)),
        "rotating_speed": math.nan,
        "start": start,
        "displacement": displacement,
    }


def at_ratio(case, ratio):
    """The case at the speed v = ratio v_s."""
    return {**case, "rotating_speed": ratio * case["friction.stribeck_velocity"] / PRESET["b"]}


def bisect(low, high, test, halvings=40):
    """The logarithmic middle of the last bracket in which `test` changes between low (true) and high (false)."""
    for _ in range(halvings):
        mid = math.sqrt(low * high)
        if test(mid):
            low = mid
        else:
            high = mid
    return math.sqrt(low * high)


def nudge(rng):
    """A factor near 1: in half of the draws within 1 % (down to 1e-5), otherwise within 30 %."""
    if rng.random() < 0.5:
        return 1.0 + float(rng.choice([-1.0, 1.0])) * log_uniform(rng, 1e-5, 1e-2)
    return float(rng.uniform(0.7, 1.3))


def released_orbit_sticks(case):
    p = reduced(case)
    radius = 1e-3 * certain_radius(p) if half_growth(p) < 0.0 else 0.0
    what, turning, _, _ = simulate(1, 0.0, 0.0, p, radius, TOLERANCE)
    return what == TURNED and after_turning(turning, p, radius, TOLERANCE)[0] == STUCK


def around_critical_speed(rng):
    case = draw(rng)
    exponent = case["friction.stribeck_exponent"]
    peak = ((exponent - 1.0) / exponent) ** (1.0 / exponent) if exponent > 1.0 else 1e-9
    grows = lambda ratio: half_growth(reduced(at_ratio(case, ratio))) > 0.0
    if not grows(peak):
        raise NoBoundary
    return at_ratio(case, bisect(peak, 1e6, grows) * log_uniform(rng, 0.3, 3.0))


def around_saddle_node(rng):
    case = draw(rng, starts=(1, 2, 3))
    sticks = lambda ratio: released_orbit_sticks(at_ratio(case, ratio))
    grid = np.geomspace(1e-3, 1e3, 47).tolist()
    seen = [sticks(ratio) for ratio in grid]
    ends = [i for i in range(46) if seen[i] != seen[i + 1]]
    if not ends:
        raise NoBoundary
    i = ends[-1] if rng.random() < 0.8 else ends[rng.integers(len(ends))]
    return at_ratio(case, bisect(grid[i], grid[i + 1], lambda ratio: sticks(ratio) == seen[i]) * nudge(rng))


def fast_disc(rng):
    """v / v_s from 10 to 1000; mostly where the released orbit only just sticks again, found at fixed v / v_s."""
    case = draw(rng, starts=(1, 2, 3))
    ratio = log_uniform(rng, 10.0, 1000.0)
    if rng.random() < 0.4:
        return at_ratio(case, ratio)
    with_width = lambda width: at_ratio({**case, "friction.stribeck_velocity": width}, ratio)
    sticks = lambda width: released_orbit_sticks(with_width(width))
    if not sticks(0.05) or sticks(3.0):
        raise NoBoundary
    case = with_width(bisect(0.05, 3.0, sticks))
    return {**case, "rotating_speed": case["rotating_speed"] * nudge(rng)}


CURVED = (1.5, 2.0, 3.0, (1.05, 3.0))


def draw_shallow(rng, starts):
    """As `draw`, with exponents above 1 and mostly a friction curve that falls little: then the released orbit may miss the stick."""
    case = draw(rng, starts, CURVED)
    if rng.random() < 0.8:
        case["static_friction"] = case["friction.kinetic_coefficient"] * (1.0 + log_uniform(rng, 3e-3, 0.5))
    return at_ratio(case, log_uniform(rng, 0.05, 2.0))


def with_growth(case, growth):
    """The damper at which the linear growth rate over the frequency is `growth`."""
    ratio = float(half_growth(reduced({**case, "damping.tangential": 0.0}))) - growth
    if not 1e-3 <= ratio <= 0.5:
        raise NoBoundary
    return {**case, "damping.tangential": ratio * CRITICAL_DAMPING}


def weakly_unstable(rng):
    case = draw_shallow(rng, (2, 1, 1))
    if rng.random() < 0.5:
        case["displacement"] = log_uniform(rng, 1e-3, 0.3)
    case = with_growth(case, float(rng.choice([-1.0, 1.0, 1.0])) * log_uniform(rng, 1e-6, 1e-3))
    if rng.random() < 0.6 and fate(case).kind != "smooth-cycle":
        raise NoBoundary  # so that smooth cycles are not rare
    return case


def fold_of_cycles(rng):
    """Where smooth cycles appear or vanish with the damper, near the one at which the equilibrium loses its stability:
    within 3 %, down to 1e-6."""
    case = draw_shallow(rng, (1, 2, 2))
    neutral = with_growth(case, 0.0)["damping.tangential"]
    kind = lambda damper: fate({**case, "damping.tangential": damper}).kind
    grid = [neutral * part for part in (0.6, 0.75, 0.85, 0.92, 0.96, 0.98, 0.99, 1.0001, 1.01, 1.02, 1.04, 1.08, 1.15, 1.25, 1.4)]
    seen = [kind(damper) for damper in grid]
    ends = [i for i in range(len(grid) - 1) if seen[i] != seen[i + 1] and "smooth-cycle" in seen[i : i + 2]]
    if not ends:
        raise NoBoundary
    i = ends[rng.integers(len(ends))]
    damper = bisect(grid[i], grid[i + 1], lambda value: kind(value) == seen[i], 24)
    damper *= 1.0 + float(rng.choice([-1.0, 1.0])) * log_uniform(rng, 1e-6, 3e-2)
    if not 1e-3 <= damper / CRITICAL_DAMPING <= 0.5:
        raise NoBoundary
    return {**case, "damping.tangential": damper}


def slow_disc(rng):
    ratio = log_uniform(rng, 1e-4, 1e-2)
    if rng.random() < 0.5:
        return at_ratio(draw(rng), ratio)
    case = at_ratio(draw(rng, exponents=CURVED), ratio)
    damper = with_growth(case, 0.0)["damping.tangential"] * log_uniform(rng, 0.5, 2.0)
    if not 1e-3 <= damper / CRITICAL_DAMPING <= 0.5:
        raise NoBoundary
    return {**case, "damping.tangential": damper}


FAMILIES = [(around_critical_speed, 667), (around_saddle_node, 667), (fast_disc, 333), (weakly_unstable, 200), (fold_of_cycles, 90), (slow_disc, 43)]
HEADER = """\
# 2000 fates of a pad on a rigid disc, drawn around the boundaries of the verdicts. Parameters not named are the preset's.
# Made by tests/data/rigid_fates.py, which shares no code with the program: independent return map, adaptive Dormand-Prince to
# 1e-12, 2026-11. The margin says how near a case is to another fate or kind (1e-7 is the least; see that file).
"""


def make(path):
    rng = np.random.default_rng(20_261_121)
    begin = time.time()
    rows, left_out, failed, overtaken = [], 0, 0, 0
    for family, count in FAMILIES:
        done, since = 0, time.time()
        while done < count:
            try:
                case = family(rng)
                found = fate(case)
            except NoBoundary:
                continue
            except ArithmeticError as error:
                failed += 1
                print(f"{family.__name__}: {error}: {case}", flush=True)
                continue
            if found.margin < RESOLUTION:
                left_out += 1
                print(f"{family.__name__}: left out, {found}: {case}", flush=True)
                continue
            done += 1
            overtaken += found.overtaken > 0
            ratio = case["damping.tangential"] / CRITICAL_DAMPING
            rows.append({**case, "fate": found.fate, "kind": found.kind, "damping_ratio": ratio, "margin": found.margin,
                         "why": found.why, "family": family.__name__})
        print(f"{family.__name__}: {count} in {time.time() - since:.0f} s", flush=True)
    with open(path, "w", newline="") as file:
        file.write(HEADER)
        writer = csv.DictWriter(file, COLUMNS + ["margin"], extrasaction="ignore", lineterminator="\n")
        writer.writeheader()
        for row in rows:
            writer.writerow({k: repr(float(v)) if isinstance(v, float) else v for k, v in row.items()})
    print(f"{len(rows)} cases; {left_out} left out for a margin below {RESOLUTION:g}, {failed} failed; {time.time() - begin:.0f} s")
    exponent = lambda row: row["friction.stribeck_exponent"] if row["friction.stribeck_exponent"] in (0.5, 0.7, 1.0, 1.5, 2.0, 3.0) else "other"
    speed = lambda row: PRESET["b"] * row["rotating_speed"] / row["friction.stribeck_velocity"]
    for name, key in [("kind", lambda row: row["kind"]), ("start and kind", lambda row: (row["start"], row["kind"])),
                      ("exponent and kind", lambda row: (str(exponent(row)), row["kind"])),
                      ("family and kind", lambda row: (row["family"], row["kind"])), ("reason", lambda row: row["why"]),
                      ("v / v_s above 10, and kind", lambda row: (speed(row) > 10.0, row["kind"])),
                      ("decade of the margin", lambda row: math.floor(math.log10(row["margin"])))]:
        print(name, dict(sorted(Counter(map(key, rows)).items())))
    print(f"an orbit on which the pad overtakes the disc was met in {overtaken}")


if __name__ == "__main__":
    if sys.argv[1] == "check":
        check(sys.argv[2])
    elif sys.argv[1] == "one":
        one(sys.argv[2], int(sys.argv[3]))
    elif sys.argv[1] == "make":
        make(sys.argv[2])
