"""Motions of a pad on a flexible disc, found independently of the program, for flexible-fates.csv.

    python flexible_fates.py make flexible-fates.csv [SEED]     draws brakes and follows their motions
    python flexible_fates.py one FILE.csv LINE                  one line again, with another tolerance

Needs numpy, scipy and numba. Nothing here is taken from the program's own sources: the equations are those of docs/theory.md.

The disc
--------
The modes of an annular plate, clamped at a and free at b, are R(r) cos(n theta) and R(r) sin(n theta) with

    R = c1 J_n(k r) + c2 Y_n(k r) + c3 I_n(k r) + c4 K_n(k r),     k = lambda / b,

where R = R' = 0 at a, and at b

    R'' + nu (R'/r - n^2 R/r^2) = 0,     (R'' + R'/r - n^2 R/r^2)' - (1 - nu) (n^2 / r^2) (R' - R/r) = 0.

The zeros of the determinant give lambda. The modes of lowest frequency are kept. The equations of motion are those of theory.md
in the frame of the pad, projected on these shapes.

The contact
-----------
While the whole patch presses, its integrals are Gauss-Legendre sums over 12 by 18 points. Where the gap opens somewhere, they are
taken line by line: on 20 radii the angle is divided into 16 pieces, each of them cut where the gap vanishes, with five points on
what presses.

The motion
----------
SciPy's DOP853 follows one state of contact at a time, to a relative tolerance of 1e-10. A pad that slips or overtakes the
disc does so until x' = v, a pad that sticks until static friction, f_s P, is less than what it takes to keep x'' = 0. Both
are located as events, and a touch between two steps by the largest x' there. Where x' = v and static friction can hold the pad, it sticks; otherwise it passes.

How a fate is found
-------------------
Steady sliding is found by Newton's method, and its eigenvalues from differences of the right hand side.

    unstable   in 12 cycles in a row the pad has stuck, and met the disc at the same x to 1e-7 of the swing
    stable     steady sliding is linearly stable, and the energy of the distance from it has died to 1e-8 of that of x0, with
               the springs of the linear equations; before that the pad has not stuck for 20 swings

Motions that show neither in a scaled time of 3000 are left out, and so are those whose fate changes with a tolerance of 1e-8.

What else is written
--------------------
x and x' of the pad at up to six times of the first swings, no nearer than 0.2 to a beginning or an end of stick, and only as
long as the coarser tolerance gives the same to 1e-6: a pad that grazes the disc's speed is followed no farther. For stick-slip
the largest and smallest x of the settled cycle, its period, its share of stick, and when it was settled; the least gap on
the patch, over the mean one in steady sliding on a rigid disc, negative where the pad has partly lifted off.

20 brakes differ from the preset in thickness, damping, preload, static friction and speed, 12 in seven more parameters:
soft discs, and pads that tilt so far that they lift off.
"""

import csv
import math
import sys
import time

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import i1e, ive, ivp, jv, jvp, kve, kvp, yv, yvp

PRESET = dict(density=7800.0, youngs=2.1e11, nu=0.3, h=0.020, a=0.064, b=0.135, zeta=0.02, mass=0.10, inertia=2.0e-4, r_a=0.090,
              psi=math.pi / 6.0, q=0.008, k_x=3.249e7, k_y=3.249e7, k_s=2.472e4, k_en=3.816e7, k_t1=2.138e7, k_t2=2.138e7,
              c_x=369.0, c_y=106.1, c_s=0.08882, f_s=0.39, f_c=0.25, v_s=0.72, preload=0.1, speed=16.0)
KEYS = {"disc.thickness": "h", "disc.youngs_modulus": "youngs", "disc.transverse_damping_ratio": "zeta", "pad.moment_arm": "q",
        "stiffness.calliper_angular": "k_s", "stiffness.contact_normal": "k_en", "damping.tangential": "c_x",
        "friction.kinetic_coefficient": "f_c", "friction.stribeck_velocity": "v_s", "preload": "preload",
        "static_friction": "f_s", "rotating_speed": "speed"}
STARTS = ["rest", "limit-cycle"]
NEAR_THE_PRESET, FAR_FROM_IT = 20, 12
LONGEST = 3000.0
TOLERANCE, COARSE = 1e-10, 1e-8
SLIP, STICK, OVERTAKING = 1.0, 0.0, -1.0
LEAST_COMPLIANCE = 0.9


HEAD = """\
# Fates and first swings of pads on flexible discs. Parameters not named are the preset's.
# Made by tests/data/flexible_fates.py, which shares no code with the program: modes by Bessel functions, SciPy's DOP853 with
# located stick and slip, 2026-11. Scaled units. cycle: largest and smallest x, period, share of stick, and when it was settled.
"""


# ------------------------------------------------------------------------------------------------------ modes of the disc


def conditions(n, lam, ratio, nu):
    """The boundary conditions at a / b and 1 for the four Bessel functions, lambda r as argument; columns scaled."""
    def column(value, first, sign):
        rows = []
        for r in (ratio, 1.0):
            z = lam * r
            w, dw = value(z), lam * first(z)
            laplacian, dlaplacian = sign * lam * lam * w, sign * lam * lam * dw
            if r == ratio:
                rows += [w, dw]
            else:
                second = laplacian - dw / r + n * n * w / r**2
                rows += [second + nu * (dw / r - n * n * w / r**2),
                         dlaplacian - (1.0 - nu) * n * n / r**2 * (dw - w / r)]
        return np.array(rows)

    columns = [
        column(lambda z: jv(n, z), lambda z: jvp(n, z), -1.0),
        column(lambda z: yv(n, z), lambda z: yvp(n, z), -1.0),
        column(lambda z: ive(n, z) * math.exp(z - lam), lambda z: ivp(n, z) * math.exp(-lam), 1.0),
        column(lambda z: kve(n, z) * math.exp(lam * ratio - z), lambda z: kvp(n, z) * math.exp(lam * ratio), 1.0),
    ]
    matrix = np.array(columns).T
    scales = np.abs(matrix).max(axis=0)
    return matrix / scales, scales


def modes_of(ratio, nu, count):
    """n, lambda^2 and the radial shape (of r / b, unit integral of R^2 r) of the modes of lowest frequency."""
    found = []
    for n in range(14):
        determinant = lambda lam: np.linalg.det(conditions(n, lam, ratio, nu)[0])
        grid = np.linspace(1.0, 17.0, 400)
        values = [determinant(lam) for lam in grid]
        roots = [brentq(determinant, x, y, xtol=1e-14, rtol=1e-14)
                 for x, y, f, g in zip(grid, grid[1:], values, values[1:]) if f * g < 0.0]
        found += [(lam, n) for lam in roots]
    modes = []
    for lam, n in sorted(found)[:count]:
        matrix, scales = conditions(n, lam, ratio, nu)
        c = np.linalg.svd(matrix)[2][-1] / scales

        def raw(r, n=n, lam=lam, c=c):
            z = lam * np.asarray(r)
            return (c[0] * jv(n, z) + c[1] * yv(n, z) + c[2] * ive(n, z) * np.exp(z - lam)
                    + c[3] * kve(n, z) * np.exp(lam * ratio - z))

        nodes, weights = np.polynomial.legendre.leggauss(60)
        r = ratio + 0.5 * (1.0 - ratio) * (nodes + 1.0)
        norm = math.sqrt(0.5 * (1.0 - ratio) * np.sum(weights * r * raw(r) ** 2))
        modes.append((n, lam * lam, lambda r, raw=raw, norm=norm: raw(r) / norm))
    return modes


# ------------------------------------------------------------------------------------------------------ right hand side


@njit(cache=True)
def loads_of_whole(y, tilt, a, weights, arcs, shapes, slopes, loads):
    """P / k_en, the loads <psi g+> and the follower loads <psi g+ w_theta / r>; also the least gap."""
    size = a.size
    mean, least = 0.0, 1e300
    loads[:] = 0.0
    for i in range(weights.size):
        gap, slope = -y - arcs[i] * tilt, 0.0
        for k in range(size):
            gap += a[k] * shapes[i, k]
            slope += a[k] * slopes[i, k]
        least = min(least, gap)
        share = weights[i] * gap
        mean += share
        for k in range(size):
            loads[0, k] += share * shapes[i, k]
            loads[1, k] += share * slope * shapes[i, k]
    return mean, least


@njit(cache=True)
def least_at_edges(y, tilt, a, arcs, shapes):
    least = 1e300
    for i in range(arcs.size):
        gap = -y - arcs[i] * tilt
        for k in range(a.size):
            gap += a[k] * shapes[i, k]
        least = min(least, gap)
    return least


@njit(cache=True)
def gap_at(theta, y, tilt_r, a, radial, ns, sines):
    gap, slope = -y - theta * tilt_r, 0.0
    for k in range(a.size):
        angle = ns[k] * theta
        c, s = math.cos(angle), math.sin(angle)
        if sines[k]:
            gap += a[k] * radial[k] * s
            slope += a[k] * radial[k] * ns[k] * c
        else:
            gap += a[k] * radial[k] * c
            slope -= a[k] * radial[k] * ns[k] * s
    return gap, slope


@njit(cache=True)
def loads_of_part(y, tilt, a, psi, lines, ns, sines, rule, tables, loads):
    """The same where part of the patch may have lifted off. The tables hold shapes on the ends of all pieces, and shapes and
    slopes on their points; pieces that are cut have points of their own."""
    radii, line_weights, radials = lines
    points, point_weights = rule
    end_shapes, shapes, slopes = tables
    pieces = end_shapes.shape[1] - 1
    mean, least = 0.0, 1e300
    loads[:] = 0.0
    size = a.size
    for i in range(radii.size):
        tilt_r = radii[i] * tilt
        g_left = 0.0
        for piece in range(-1, pieces):
            left, right = psi * (2.0 * piece / pieces - 1.0), psi * (2.0 * (piece + 1) / pieces - 1.0)
            g_right = -y - right * tilt_r
            for k in range(size):
                g_right += a[k] * end_shapes[i, piece + 1, k]
            least = min(least, g_right)
            if piece >= 0 and g_left > 0.0 and g_right > 0.0:
                for j in range(points.size):
                    gap, slope = -y - (left + 0.5 * (right - left) * (1.0 + points[j])) * tilt_r, 0.0
                    for k in range(size):
                        gap += a[k] * shapes[i, piece, j, k]
                        slope += a[k] * slopes[i, piece, j, k]
                    share = line_weights[i] * 0.5 * (right - left) * point_weights[j] * gap
                    mean += share
                    for k in range(size):
                        loads[0, k] += share * shapes[i, piece, j, k]
                        loads[1, k] += share * slope * shapes[i, piece, j, k]
            elif piece >= 0 and g_left * g_right < 0.0:
                low, high = left, right
                while high - low > 1e-14:
                    middle = 0.5 * (low + high)
                    if (gap_at(middle, y, tilt_r, a, radials[i], ns, sines)[0] > 0.0) == (g_left > 0.0):
                        low = middle
                    else:
                        high = middle
                begin, end = (left, low) if g_left > 0.0 else (high, right)
                for j in range(points.size):
                    theta = begin + 0.5 * (end - begin) * (1.0 + points[j])
                    gap, slope = gap_at(theta, y, tilt_r, a, radials[i], ns, sines)
                    share = line_weights[i] * 0.5 * (end - begin) * point_weights[j] * gap
                    mean += share
                    for k in range(size):
                        shape = radials[i, k] * (math.sin(ns[k] * theta) if sines[k] else math.cos(ns[k] * theta))
                        loads[0, k] += share * shape
                        loads[1, k] += share * slope / radii[i] * shape
            g_left = g_right
    return mean, least


@njit(cache=True)
def rates(state, contact, p, disc, whole, edges, part, loads, out):
    """Time derivatives of displacements and speeds. Returns the needed or acting friction F, P, and the least gap."""
    (mass, inertia, c_x, c_y, c_s, k_x, k_y, k_s, k_en, k_t1, k_t2, arm, f_s, f_c, v, v_s, preload, eta1, gain) = p
    ns, sines, partner, stiffness, gyroscopic, modal_mass = disc
    size = state.size // 2
    x, y, phi = state[0], state[1], state[2]
    a = state[3:size]
    dx, dy, dphi = state[size], state[size + 1], state[size + 2]
    tilt = math.tan(phi)
    least = least_at_edges(y, tilt, a, edges[0], edges[1])
    mean = 0.0
    if least > 0.0:
        mean, inside = loads_of_whole(y, tilt, a, whole[0], whole[1], whole[2], whole[3], loads)
        least = min(least, inside)
    if least <= 0.0:
        mean, inside = loads_of_part(y, tilt, a, part[0], part[1], ns, sines, part[2], part[3], loads)
        least = min(least, inside)
    pressure = k_en * mean
    sine, cosine = math.sin(phi), math.cos(phi)
    if contact == 0.0:
        friction = k_t1 / (k_t2 * cosine) * ((k_x + k_t2 * cosine) * x + c_x * v + pressure * sine)
    else:
        sliding = contact * (v - dx)
        friction = contact * (f_c + (f_s - f_c) * math.exp(-sliding / v_s)) * pressure
    spring = k_t2 * (x - friction / k_t1)
    for i in range(size):
        out[i] = state[size + i]
    out[size] = 0.0 if contact == 0.0 else -(c_x * dx + k_x * x + pressure * sine + spring * cosine) / mass
    out[size + 1] = -(c_y * dy + k_y * (preload + y) - pressure * cosine + spring * sine) / mass
    out[size + 2] = -(c_s * dphi + k_s * phi + spring * arm) / inertia
    ratio = friction / pressure if pressure > 0.0 else 0.0
    for k in range(a.size):
        load = loads[0, k] + ratio * loads[1, k]
        out[size + 3 + k] = -(eta1 * state[size + 3 + k] + stiffness[k] * a[k]
                              + gyroscopic[k] * state[size + 3 + partner[k]]) - gain * load / modal_mass[k]
    return friction, pressure, least


# ------------------------------------------------------------------------------------------------------ a brake


MODES = modes_of(PRESET["a"] / PRESET["b"], PRESET["nu"], 12)


def compliance_shares():
    """What the first modes carry of the deflection under an even pressure of the pad, over what all 12 carry."""
    q = PRESET
    nodes, weights = np.polynomial.legendre.leggauss(24)
    inner = q["r_a"] / q["b"]
    r = inner + 0.5 * (1.0 - inner) * (nodes + 1.0)
    terms = []
    for n, parameter, shape in MODES:
        mean = np.sum(weights * r * shape(r)) / np.sum(weights * r) * np.sinc(n * q["psi"] / math.pi)
        terms.append(mean**2 / ((2.0 if n == 0 else 1.0) * parameter**2))
    return np.cumsum(terms) / np.sum(terms)


class Brake:
    """One brake in scaled units: lengths over h, times over tau."""

    def __init__(self, case):
        q = PRESET | {KEYS[key]: value for key, value in case.items() if key in KEYS}
        h = q["h"]
        rigidity = q["youngs"] * h**3 / (12.0 * (1.0 - q["nu"] ** 2))
        tau = math.sqrt(q["density"] * h**4 / rigidity)
        eta0, speed = 1.0 / tau**2, math.sqrt(rigidity / (q["density"] * h * h))
        count = case["modes"]
        modes = MODES[:count]
        b = q["b"]
        spin = q["speed"] * tau
        self.v = b * q["speed"] / speed
        self.f_s, self.preload = q["f_s"], q["preload"]
        root = math.sqrt(eta0)
        omega = [parameter * h**1.5 / b**2 for _, parameter, _ in modes]
        self.p = (q["mass"] * eta0, q["inertia"] * eta0, q["c_x"] * root, q["c_y"] * root, q["c_s"] * root,
                  q["k_x"], q["k_y"], q["k_s"], q["k_en"], q["k_t1"], q["k_t2"], h * q["q"] / 2.0, self.f_s, q["f_c"],
                  self.v, q["v_s"] / speed, self.preload, 2.0 * q["zeta"] * min(omega), h**3 * q["k_en"] / rigidity)
        rows = [(n, False, w, shape) for (n, _, shape), w in zip(modes, omega)]
        rows += [(n, True, w, shape) for (n, _, shape), w in zip(modes, omega) if n > 0]
        partner, gyroscopic = [], []
        for i, (n, sine, _, shape) in enumerate(rows):
            other = [j for j, row in enumerate(rows) if row[3] is shape and row[1] != sine]
            partner.append(other[0] if other else i)
            gyroscopic.append((-1.0 if sine else 1.0) * 2.0 * spin * n)
        ns = np.array([float(row[0]) for row in rows])
        sines = np.array([row[1] for row in rows])
        self.disc = (ns, sines, np.array(partner), np.array([row[2] ** 2 - row[0] ** 2 * spin**2 for row in rows]),
                     np.array(gyroscopic),
                     np.array([b * b * (2.0 * math.pi if row[0] == 0 else math.pi) for row in rows]))
        self.size = 3 + len(rows)
        psi, inner = q["psi"], q["r_a"] / b

        def nodes(radial, angular):
            """Radii over b and angles."""
            r, theta = (array.ravel() for array in np.meshgrid(radial, angular, indexing="ij"))
            shapes = np.array([row[3](r) * (np.sin if row[1] else np.cos)(row[0] * theta) for row in rows]).T
            slopes = np.array([row[3](r) * row[0] * (np.cos(row[0] * theta) if row[1] else -np.sin(row[0] * theta))
                               for row in rows]).T
            return r, theta, r * theta * b / h, np.ascontiguousarray(shapes), np.ascontiguousarray(slopes / (r * b / h)[:, None])

        def rule(points):
            s, weights = np.polynomial.legendre.leggauss(points)
            return inner + 0.5 * (1.0 - inner) * (s + 1.0), 0.5 * (1.0 - inner) * weights

        radial, radial_weights = rule(12)
        t, angular_weights = np.polynomial.legendre.leggauss(18)
        r, _, arcs, shapes, slopes = nodes(radial, psi * t)
        area = psi * (1.0 - inner * inner)
        weights = np.outer(radial_weights, psi * angular_weights).ravel() * r / area
        self.whole = (weights, arcs, shapes, slopes)
        _, _, arcs, shapes, _ = nodes(np.linspace(inner, 1.0, 5), np.linspace(-psi, psi, 9))
        self.edges = (arcs, shapes)
        radial, radial_weights = rule(20)
        points, point_weights = np.polynomial.legendre.leggauss(5)
        ends = np.linspace(-psi, psi, 17)
        inside = (ends[:-1, None] + 0.5 * (ends[1] - ends[0]) * (1.0 + points)).ravel()
        _, _, _, end_shapes, _ = nodes(radial, ends)
        _, _, _, shapes, slopes = nodes(radial, inside)
        tables = (end_shapes.reshape(20, 17, -1), shapes.reshape(20, 16, 5, -1), slopes.reshape(20, 16, 5, -1))
        radials = np.array([[float(row[3](s)) for row in rows] for s in radial])
        self.part = (psi, (radial * b / h, radial_weights * radial / area, radials), (points, point_weights), tables)
        self.loads = np.zeros((2, len(rows)))
        self.equilibrium = self.find_equilibrium()
        force = q["k_en"] * q["k_y"] / (q["k_en"] + q["k_y"]) * self.preload
        self.mean_gap = force / q["k_en"]
        self.least_gap = math.inf

    def rate(self, state, contact):
        out = np.empty(2 * self.size)
        friction, pressure, least = rates(state, contact, self.p, self.disc, self.whole, self.edges, self.part, self.loads, out)
        return out, friction, pressure, least

    def accelerations(self, q):
        state = np.concatenate([q, np.zeros(self.size)])
        return self.rate(state, SLIP)[0][self.size:]

    def stiffness_matrix(self, q):
        columns = []
        for i in range(self.size):
            step = np.zeros(self.size)
            step[i] = 1e-6
            columns.append((self.accelerations(q + step) - self.accelerations(q - step)) / 2e-6)
        return np.array(columns).T

    def find_equilibrium(self):
        q = np.zeros(self.size)
        q[1] = -self.p[6] * self.preload / (self.p[6] + self.p[8])
        for _ in range(50):
            step = np.linalg.solve(self.stiffness_matrix(q), self.accelerations(q))
            q = q - step
            if np.abs(step).max() < 1e-15:
                break
        if np.abs(step).max() > 1e-12:
            raise ArithmeticError("no equilibrium")
        return q

    def growth_rate(self):
        """The largest real part of the eigenvalues of steady sliding."""
        n = self.size
        jacobian = np.zeros((2 * n, 2 * n))
        at = np.concatenate([self.equilibrium, np.zeros(n)])
        for i in range(2 * n):
            step = np.zeros(2 * n)
            step[i] = 1e-6
            jacobian[:, i] = (self.rate(at + step, SLIP)[0] - self.rate(at - step, SLIP)[0]) / 2e-6
        return np.linalg.eigvals(jacobian).real.max()

    def held(self, state):
        """What static friction can hold, and what it takes to stick."""
        _, needed, pressure, _ = self.rate(state, STICK)
        return self.f_s * max(pressure, 0.0), needed

    def start(self, name):
        state = np.concatenate([self.equilibrium, np.zeros(self.size)])
        if name == "rest":
            state[0] = 0.0
            return state
        _, _, pressure, _ = self.rate(state, SLIP)
        phi = state[2]
        c_x, k_x, k_t1, k_t2 = self.p[2], self.p[5], self.p[9], self.p[10]
        force = k_t2 / k_t1 * self.f_s * pressure * math.cos(phi) - pressure * math.sin(phi) - c_x * self.v
        state[0] = force / (k_x + k_t2 * math.cos(phi))
        state[self.size] = self.v * (1.0 - 1e-13)
        return state

    def distance(self, state):
        """The root of the energy of a distance from steady sliding, over that of x0."""
        n, p = self.size, self.p
        d, u = state[:n] - self.equilibrium, state[n:]
        mass, inertia, k_s, k_en = p[0], p[1], p[7], p[8]
        modal = self.disc[5] * mass  # any positive weights will do
        energy = (p[5] + p[10]) * d[0] ** 2 + mass * (u[0] ** 2 + u[1] ** 2) + (p[6] + k_en) * d[1] ** 2
        energy += k_s * d[2] ** 2 + inertia * u[2] ** 2
        energy += np.sum(modal * (u[3:] ** 2 + np.abs(self.disc[3]) * d[3:] ** 2))
        return math.sqrt(energy / ((p[5] + p[10]) * self.equilibrium[0] ** 2))

    def follow(self, name, tolerance, longest=LONGEST, times=(), is_stable=True):
        """The motion from a start: its fate, what it is, x and x' at some times, and the settled cycle."""
        n, v = self.size, self.v
        state, contact, now = self.start(name), SLIP, 0.0
        times = sorted(times)
        samples, events, meetings, releases, turnings = {}, [], [], [], []
        swings = 0
        atol = np.full(2 * n, tolerance * 1e-2)

        def meets(_, s):
            return contact * (v - s[n])

        def turns(_, s):
            return s[n]

        def slips(_, s):
            can, needed = self.held(s)
            return can - abs(needed)

        def passes(_, s):
            return contact * self.rate(s, contact)[0][n]

        def phase(until, watch, dense):
            return solve_ivp(lambda _, s: self.rate(s, contact)[0], (now, until), state, method="DOP853", rtol=tolerance,
                             atol=atol, events=watch, dense_output=dense, max_step=0.5)

        def turns_back(_, s):
            return s[n]

        meets.terminal, meets.direction = True, -1.0
        passes.direction = -1.0
        turns.terminal, turns.direction = True, -1.0
        turns_back.direction = 1.0
        slips.terminal, slips.direction = True, -1.0
        while now < longest:
            watch = [slips] if contact == STICK else [meets, turns, turns_back, passes] if contact == SLIP else [meets]
            wanted = [t for t in times if t >= now]
            solved = phase(longest, watch, bool(wanted))
            if contact == SLIP:
                # A step may reach beyond the disc's speed and back: then the pad has met the disc before it was fastest.
                peaks = zip(solved.t_events[3], solved.y_events[3])
                fastest = next((t for t, s in peaks if s[n] >= v and t > now + 1e-3), None)
                if fastest is not None and fastest < solved.t[-1]:
                    until_then, before = phase(fastest, [], True).sol, 1e-6
                    while until_then(fastest - before)[n] >= v:
                        before *= 2.0
                    meeting = brentq(lambda t: v - until_then(t)[n], fastest - before, fastest, xtol=1e-14)
                    solved = phase(meeting, [meets, turns, turns_back], True)
            if not solved.success:
                raise ArithmeticError(solved.message)
            self.least_gap = min([self.least_gap] + [self.rate(s, contact)[3] for s in solved.y.T])
            for t in wanted:
                if t <= solved.t[-1]:
                    sample = solved.sol(t)
                    samples[t] = (sample[0], sample[n])
            now, state = solved.t[-1], solved.y[:, -1].copy()
            if contact == SLIP:
                turnings += [s[0] for s in (*solved.y_events[1], *solved.y_events[2])]
            if contact == SLIP and len(solved.t_events[1]):
                # Turned back at the far end of a swing, without sticking. DOP853 goes on behind the turning point.
                swings += 1
                state[n] = -1e-13 * v
                if swings >= 20 and is_stable and self.distance(state) < 1e-4:
                    return "stable", "sliding", samples, events, None
                continue
            if contact == STICK:
                releases.append((now, state[0]))
                contact = SLIP if self.held(state)[1] > 0.0 else OVERTAKING
                state[n] = v * (1.0 - contact * 1e-13)
                events.append(now)
                continue
            if now >= longest:
                break
            events.append(now)
            state[n] = v
            can, needed = self.held(state)
            if abs(needed) <= can:
                swings = 0
                contact = STICK
                meetings.append((now, state[0]))
                if len(meetings) >= 13 and len(releases) >= 12:
                    swing = releases[-1][1] - self.equilibrium[0]
                    last = np.array([x for _, x in meetings[-13:]])
                    if np.ptp(last) <= 1e-7 * abs(swing):
                        period = (meetings[-1][0] - meetings[-13][0]) / 12.0
                        stick = (releases[-1][1] - last[-1]) / v / period
                        cycle = (max(turnings[-6:]), min(turnings[-6:]), period, stick, meetings[-13][0])
                        return "unstable", "stick-slip", samples, events, cycle
            else:
                contact = OVERTAKING if needed < 0.0 else SLIP
                state[n] = v * (1.0 - contact * 1e-13)
        return None, f"{len(meetings)} times stuck, distance {self.distance(state):.3g}", samples, events, None


# ------------------------------------------------------------------------------------------------------ the file


def draw(rng, is_far):
    """A brake whose rotating speed lies between the loss of stability on a rigid disc and somewhat beyond the end of stick-slip."""
    spread = lambda low, high: float(math.exp(rng.uniform(math.log(low), math.log(high))))
    shares = compliance_shares()
    fewest = next(i + 1 for i, share in enumerate(shares) if share > LEAST_COMPLIANCE + 0.005)
    while True:
        case = {"disc.thickness": spread(0.008, 0.03), "damping.tangential": PRESET["c_x"] * spread(0.3, 3.0),
                "preload": spread(0.03, 0.3), "static_friction": rng.uniform(0.3, 0.6)}
        far = {"disc.youngs_modulus": spread(2e10, 2.1e11), "disc.transverse_damping_ratio": spread(0.015, 0.05),
               "pad.moment_arm": spread(0.008, 0.03), "stiffness.calliper_angular": PRESET["k_s"] * spread(0.05, 1.0),
               "stiffness.contact_normal": PRESET["k_en"] * spread(0.3, 3.0), "friction.kinetic_coefficient": rng.uniform(0.1, 0.25),
               "friction.stribeck_velocity": spread(0.2, 2.0)}
        default = {key: PRESET[KEYS[key]] for key in far}
        case = {key: float(f"{value:.5g}") for key, value in (case | (far if is_far else default)).items()}
        q = PRESET | {KEYS[key]: value for key, value in case.items()}
        force = q["h"] * q["preload"] * q["k_en"] * q["k_y"] / (q["k_en"] + q["k_y"])
        fall = q["k_t2"] / q["k_t1"] * force * (q["f_s"] - q["f_c"])
        balance = lambda r: 2.0 * fall * i1e(r) - q["c_x"] * q["v_s"] * r
        if fall < 1.2 * q["c_x"] * q["v_s"]:
            continue
        highest = brentq(balance, 0.05, 500.0)
        critical = math.log(fall / (q["c_x"] * q["v_s"]))
        r = 0.9 * critical * (highest * 1.15 / (0.9 * critical)) ** rng.uniform(0.0, 1.0)
        if 0.3 < r < 40.0:
            speed = float(f"{r * q['v_s'] / q['b']:.5g}")
            return case | {"rotating_speed": speed, "modes": int(rng.integers(fewest, 9))}


def study(case, start, rng):
    """One row of the file, or why there is none."""
    brake = Brake(case)
    rate = brake.growth_rate()
    times = sorted(round(float(t), 3) for t in rng.uniform(0.5, 25.0, 12))
    rough = brake.follow(start, COARSE, is_stable=rate < 0.0, times=times)
    fine = brake.follow(start, TOLERANCE, is_stable=rate < 0.0, times=times)
    if fine[0] is None or fine[0] != rough[0]:
        return None, f"{rough[:2]} {fine[:2]}"
    scale = np.array([abs(brake.equilibrium[0]), brake.v])
    agree = lambda t: np.all(np.abs(np.subtract(rough[2][t], fine[2][t])) < 1e-6 * scale)
    first = next((t for t in times if not agree(t)), math.inf)
    times = [t for t in times if t < first and all(abs(t - event) > 0.2 for event in fine[3])][:6]
    samples = [fine[2][t] for t in times]
    row = {**case, "start": start, "fate": fine[0], "growth_rate": f"{rate:.8g}",
           "equilibrium": f"{brake.equilibrium[0]:.12g}",
           "times": " ".join(f"{t}" for t in times), "x": " ".join(f"{x:.11g}" for x, _ in samples),
           "speed": " ".join(f"{u:.11g}" for _, u in samples),
           "cycle": "" if fine[4] is None else " ".join(f"{value:.10g}" for value in fine[4]),
           "least_gap": f"{brake.least_gap / brake.mean_gap:.3f}"}
    return row, (fine[1], rough[4])


def make(path, seed):
    rng = np.random.default_rng(seed)
    begin, rows, left_out = time.time(), [], 0
    for brake in range(NEAR_THE_PRESET + FAR_FROM_IT):
        case = draw(rng, brake >= NEAR_THE_PRESET)
        for start in STARTS:
            since = time.time()
            try:
                row, what = study(case, start, rng)
            except ArithmeticError as error:
                row, what = None, str(error)
            print(brake, start, case, None if row is None else (row["fate"], row["growth_rate"], row["least_gap"]), what,
                  f"{time.time() - since:.1f} s", flush=True)
            if row is None:
                left_out += 1
            else:
                rows.append(row)
    with open(path, "w", newline="") as file:
        file.write(HEAD)
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    print(f"{left_out} left out; {sum(row['fate'] == 'stable' for row in rows)} of {len(rows)} stable; {time.time() - begin:.0f} s")


def one(path, line):
    """One line again, with a tolerance ten times finer."""
    with open(path) as file:
        lines = file.read().split("\n")
    header = next(text for text in lines if not text.startswith("#")).split(",")
    row = dict(zip(header, lines[line - 1].split(",")))
    case = {key: float(row[key]) for key in KEYS if key in row} | {"modes": int(row["modes"])}
    brake = Brake(case)
    rate = brake.growth_rate()
    times = [float(t) for t in row["times"].split()]
    fate, what, samples, _, cycle = brake.follow(row["start"], 0.1 * TOLERANCE, is_stable=rate < 0.0, times=times)
    print(row)
    print(fate, what, rate, cycle)
    print({t: (float(x), float(u)) for t, (x, u) in sorted(samples.items())})


if __name__ == "__main__":
    if sys.argv[1] == "make":
        make(sys.argv[2], int(sys.argv[3]) if len(sys.argv) > 3 else 20_261_124)
    else:
        one(sys.argv[2], int(sys.argv[3]))
