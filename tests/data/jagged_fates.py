"""Fates of a pad on a rigid disc with jagged friction curves, found independently of the program, for jagged-fates.csv.

    python jagged_fates.py jagged-fates.csv [SEED]

Needs numpy and scipy. Nothing here is taken from the program's own sources.

The curves have six to twenty rows, at speeds and with coefficients drawn at random: friction jumps from row to row. They are
interpolated by SciPy's PchipInterpolator, with one more row of the same coefficient before a first speed above 0 and beyond the
last one. Steady sliding is linearly stable in all cases. The motion

    M eta0 x'' = -(k_x + k_t2) x - c_x sqrt(eta0) x' + sign(v - x') (k_t2 / k_t1) mu(|v - x'|) N

is integrated by LSODA, which changes to an implicit method where friction rises so steeply that the motion is stiff, with
located events (x' = v, x' = 0), swing after swing:

    unstable   the pad sticks for the second time (or for the first time after a start at the release), or overtakes the disc
               at the same place in ten cycles in a row, or turns at the same place, away from rest, in ten cycles in a row
    stable     it has come to rest: nearer to steady sliding than 1e-5 v / omega in x and 1e-5 v in x'

Cases that show neither in 1500 swings are left out, and so are those in which another tolerance gives another fate: 18 beside
these 500, of which 362 are stable. It takes some three minutes on an idle processor.
"""

import csv
import math
import sys
import time

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import PchipInterpolator

PRESET = dict(density=7800.0, youngs=2.1e11, nu=0.3, h=0.020, b=0.135, mass=0.10, k_x=3.249e7, k_y=3.249e7,
              k_en=3.816e7, k_t1=2.138e7, k_t2=2.138e7)
STARTS = ["near-equilibrium", "rest", "limit-cycle"]
DISPLACEMENT = 0.01
AT_REST = 1e-5
SAME = 1e-7
CASES = 500


class Brake:
    """The motion in seconds over tau and thicknesses of the disc."""

    def __init__(self, case):
        q = PRESET
        rigidity = q["youngs"] * q["h"] ** 3 / (12.0 * (1.0 - q["nu"] ** 2))
        eta0 = rigidity / (q["density"] * q["h"] ** 4)
        speed = math.sqrt(rigidity / (q["density"] * q["h"] ** 2))
        inertia = q["mass"] * eta0
        self.k = (q["k_x"] + q["k_t2"]) / inertia
        self.c = case["damping"] * math.sqrt(eta0) / inertia
        self.omega = math.sqrt(self.k)
        normal = q["k_en"] * q["k_y"] / (q["k_en"] + q["k_y"]) * case["preload"]
        gain = q["k_t2"] / q["k_t1"] * normal / inertia
        speeds, values = list(case["speeds"]), [gain * value for value in case["coefficients"]]
        if speeds[0] > 0.0:
            speeds, values = [0.0, *speeds], [values[0], *values]
            speeds[0] = -1.0  # so that the slope at the first row is zero
        speeds, values = [*speeds, speeds[-1] + 1.0], [*values, values[-1]]
        pieces = PchipInterpolator(np.array(speeds) / speed, values)
        self.knots = pieces.x.tolist()
        self.cubics = pieces.c.T.tolist()
        self.v = q["b"] * case["rotating_speed"] / speed
        self.x0 = self.pull(self.v)[0] / self.k
        self.at_rest = self.pull(0.0)[0]
        self.release = (self.at_rest - self.c * self.v) / self.k
        self.last_hold = (-self.at_rest - self.c * self.v) / self.k

    def pull(self, r):
        """Friction over the inertia at the sliding speed r >= 0, and its slope."""
        if r >= self.knots[-2]:
            return self.cubics[-1][3], 0.0
        low, high = 0, len(self.cubics) - 1
        while low < high:
            middle = (low + high + 1) // 2
            if self.knots[middle] <= r:
                low = middle
            else:
                high = middle - 1
        d, c, b, a = self.cubics[low]
        t = r - self.knots[low]
        return a + t * (b + t * (c + t * d)), b + t * (2.0 * c + t * 3.0 * d)

    def phase(self, state, side, tolerance):
        """From a state of slip (side 1) or overtaking (side -1) to the disc's speed or to the next turning point at the largest x."""
        k, c, v, pull = self.k, self.c, self.v, self.pull

        def rate(_, y):
            r = side * (v - y[1])
            return [y[1], side * pull(r if r > 0.0 else 0.0)[0] - k * y[0] - c * y[1]]

        def jacobian(_, y):
            r = side * (v - y[1])
            return [[0.0, 1.0], [-k, -pull(r if r > 0.0 else 0.0)[1] - c]]

        def meets(_, y):
            return side * (v - y[1])

        def turns(_, y):
            return y[1]

        meets.terminal, meets.direction = True, -1.0
        turns.terminal, turns.direction = True, -1.0
        scale = max(abs(state[0] - self.x0), v / self.omega)
        creep = 0
        while creep < 40:
            solved = solve_ivp(rate, (0.0, 2000.0 / self.omega), state, method="LSODA", jac=jacobian, rtol=tolerance,
                               atol=[0.1 * tolerance * scale, 0.1 * tolerance * scale * self.omega],
                               events=[meets, turns] if side > 0.0 else [meets], first_step=1e-4 / self.omega)
            if not solved.success:
                raise ArithmeticError(solved.message)
            state = solved.y[:, -1].tolist()
            if len(solved.t_events[0]):
                return "meets", solved.y_events[0][0][0]
            if side > 0.0 and len(solved.t_events[1]):
                return "turns", solved.y_events[1][0][0]
            if self.is_at_rest(state):
                return "rests", state[0]
            creep += 1
        raise ArithmeticError("creeps for ever")

    def is_at_rest(self, state):
        return abs(state[0] - self.x0) < AT_REST * self.v / self.omega and abs(state[1]) < AT_REST * self.v


def fate(case, tolerance):
    brake = Brake(case)
    start = case["start"]
    sticks = 0
    if start == "limit-cycle":
        state, sticks = [brake.release, brake.v * (1.0 - 1e-13)], 1
    elif start == "rest":
        state = [0.0, 0.0]
    else:
        state = [brake.x0 * (1.0 + DISPLACEMENT), -1e-12 * brake.v]
    last, same, overtakes, same_overtakes = None, 0, None, 0
    for swing in range(1500):
        what, x = brake.phase(state, 1.0, tolerance)
        if what == "rests":
            return "stable"
        if what == "turns":
            if brake.is_at_rest([x, 0.0]):
                return "stable"
            same = same + 1 if last is not None and abs(x - last) <= SAME * abs(x - brake.x0) else 0
            if same == 10:
                return "unstable"
            last, state = x, [x, -1e-12 * brake.v]
            continue
        last, same = None, 0
        if x < brake.last_hold:
            same_overtakes = same_overtakes + 1 if overtakes is not None and abs(x - overtakes) <= SAME * abs(x - brake.x0) else 0
            if same_overtakes == 10:
                return "unstable"
            overtakes = x
            _, x = brake.phase([x, brake.v * (1.0 + 1e-13)], -1.0, tolerance)
            if x > brake.release:
                state = [x, brake.v * (1.0 - 1e-13)]
                continue
        sticks += 1
        if sticks == 2:
            return "unstable"
        state = [brake.release, brake.v * (1.0 - 1e-13)]
    return None


def draw(rng):
    rows = int(rng.integers(6, 21))
    spread = lambda low, high: float(math.exp(rng.uniform(math.log(low), math.log(high))))
    while True:
        highest = spread(0.3, 10.0)
        speeds = sorted(float(f"{rng.uniform(0.0, highest) if rng.random() < 0.5 else spread(1e-3, highest):.5g}") for _ in range(rows))
        if rng.random() < 0.7:
            speeds[0] = 0.0
        if any(b - a < 2e-4 * b for a, b in zip(speeds, speeds[1:])):
            continue
        case = {
            "damping": float(f"{spread(5.0, 3000.0):.5g}"), "preload": float(f"{spread(0.01, 0.4):.5g}"),
            "rotating_speed": float(f"{rng.uniform(0.02, 1.3) * highest / PRESET['b']:.5g}"),
            "start": STARTS[rng.integers(3)], "speeds": speeds,
            "coefficients": [float(f"{rng.uniform(0.05, 0.9):.5g}") for _ in speeds],
        }
        brake = Brake(case)
        if brake.c + brake.pull(brake.v)[1] > 1e-6 * brake.omega:
            return case


def main():
    rng = np.random.default_rng(int(sys.argv[2]) if len(sys.argv) > 2 else 20_261_123)
    begin, rows, left_out = time.time(), [], 0
    while len(rows) < CASES:
        case = draw(rng)
        try:
            fates = {fate(case, 1e-9), fate(case, 1e-7)}
        except ArithmeticError as error:
            fates = {str(error)}
        if len(fates) > 1 or not fates <= {"stable", "unstable"}:
            left_out += 1
            print("left out", fates, case, flush=True)
            continue
        rows.append({**case, "fate": fates.pop()})
        if len(rows) % 50 == 0:
            print(len(rows), f"{time.time() - begin:.0f} s", flush=True)
    with open(sys.argv[1], "w", newline="") as file:
        file.write("# 500 fates of a pad on a rigid disc with jagged friction curves and linearly stable steady sliding. Parameters not named\n"
                   "# are the preset's. Made by tests/data/jagged_fates.py, which shares no code with the program: SciPy's LSODA with located\n"
                   "# events, swing after swing, 2026-11.\n")
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["damping.tangential", "preload", "rotating_speed", "start", "speeds", "coefficients", "fate"])
        for row in rows:
            lists = [" ".join(f"{value:.5g}" for value in row[name]) for name in ("speeds", "coefficients")]
            writer.writerow([row["damping"], row["preload"], row["rotating_speed"], row["start"], *lists, row["fate"]])
    print(f"{left_out} left out; {sum(row['fate'] == 'stable' for row in rows)} stable; {time.time() - begin:.0f} s")


if __name__ == "__main__":
    main()
