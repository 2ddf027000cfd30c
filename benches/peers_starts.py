"""`make bench-peers`: starts of a friction oscillator classified by stickslip, numba and SciPy, side by side.

    python benches/peers_starts.py path/to/stickslip

The oscillator is that of M. Stender and N. Hoffmann ("bSTAB", Nonlinear Dynamics 2021, doi 10.1007/s11071-021-06786-5)
at v_d = 1.5: x'' = -x - 0.1 x' + sgn(r) (0.5 + 0.5 exp(-|r| / 0.5)), r = v_d - x', with starts uniform on [-2, 2] x
[0, 2]. What is asked is which of them end in steady sliding.

- stickslip runs jobs/bstab.toml at this speed: each motion is simulated until its verdict is certain.
- *The authors' way*: SciPy's solve_ivp (RK45, default tolerances) to t = 500, with the sign smoothed by arctan as usual
  for ordinary solvers; a start ends in steady sliding if the pad's speed stays small over the last tenth.
- numba, all the way to t = 500: fixed Runge-Kutta steps of 0.05, with stick as a state.
- numba, stopping as early as this oscillator allows: at the second stick, or once two swings differ.

numba's and SciPy's verdicts are compared with the exact boundary of the basin (the unstable cycle, by SciPy's DOP853 at a
tolerance of 1e-12): a start that lies farther from it than one per cent of its size and is classified wrongly ends the
program with exit code 1. The share that stickslip finds is compared with the area inside.

Each figure is a line with name, value and unit: medians over the rounds, ratios within one round. Times of stickslip are
those of the whole process, times of the others those of the computation alone, without compilation.
"""

import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numba
import numpy as np
import pyarrow.parquet
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

JOB_FILE = Path(__file__).resolve().parent.parent / "jobs" / "bstab.toml"
SPEED = 1.5
STARTS = 100_000
SCIPY_STARTS = 40
ROUNDS = 3
HORIZON = 500.0
STEP = 0.05
LARGEST_Z = 5.0
# What the smoothed sign and the horizon may classify wrongly, as a distance over that of the unstable cycle.
MARGIN = 0.01

DAMPING, KINETIC, FALLING, STRIBECK = 0.1, 0.5, 0.5, 0.5
EQUILIBRIUM = KINETIC + FALLING * math.exp(-SPEED / STRIBECK)


@numba.njit(inline="always")
def slip(x: float, u: float, side: float) -> float:
    """x'' under friction that pulls forwards (side = 1) or backwards (-1)."""
    return side * (KINETIC + FALLING * math.exp(-side * (SPEED - u) / STRIBECK)) - x - DAMPING * u


@numba.njit
def ends_sliding(x: float, u: float, stops_early: bool) -> bool:
    """Whether a start ends in steady sliding, by Runge-Kutta's method with fixed steps and stick as a state."""
    sticks, last_top, h = 0, -1.0, STEP
    side = 1.0 if u < SPEED else -1.0
    steps = int(HORIZON / h)
    fastest = 0.0
    step = 0
    while step < steps:
        step += 1
        a1 = slip(x, u, side)
        u2 = u + 0.5 * h * a1
        a2 = slip(x + 0.5 * h * u, u2, side)
        u3 = u + 0.5 * h * a2
        a3 = slip(x + 0.5 * h * u2, u3, side)
        u4 = u + h * a3
        a4 = slip(x + h * u3, u4, side)
        next_x = x + h * (u + h / 6.0 * (a1 + a2 + a3))
        next_u = u + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
        if side * (SPEED - next_u) <= 0.0:
            # At the disc's speed: linear in the step is enough for where.
            x += (next_x - x) * (SPEED - u) / (next_u - u) if next_u != u else 0.0
            u = SPEED
            needed = x + DAMPING * SPEED
            if abs(needed) <= KINETIC + FALLING:
                sticks += 1
                if stops_early and sticks == 2:
                    return False
                release = KINETIC + FALLING - DAMPING * SPEED
                step += int((release - x) / SPEED / h)
                x, side, last_top = release, 1.0, -1.0
                # Off the disc by what a short step gives.
                x += 1e-3 * SPEED
                u -= 1e-6
            else:
                side = 1.0 if needed > 0.0 else -1.0
            continue
        if stops_early and u > 0.0 and next_u <= 0.0:
            top = x + h * u * u / (u - next_u) * 0.5 - EQUILIBRIUM
            top += 0.0
            # The turning point of the parabola through both speeds.
            if last_top > 0.0 and abs(top / last_top - 1.0) > 1e-4:
                return top < last_top
            last_top = top
        x, u = next_x, next_u
        if step > 0.9 * steps:
            fastest = max(fastest, abs(u))
    return fastest < 0.5 * SPEED


@numba.njit(parallel=True)
def classify(x: np.ndarray, u: np.ndarray, stops_early: bool) -> np.ndarray:
    ends = np.zeros(x.size, np.bool_)
    for index in numba.prange(x.size):
        ends[index] = ends_sliding(x[index], u[index], stops_early)
    return ends


def classify_scipy(x: float, u: float) -> bool:
    """The authors' way: to a fixed horizon, then a look at what is left."""

    def rates(_: float, state: np.ndarray) -> tuple[float, float]:
        sliding = SPEED - state[1]
        friction = KINETIC + FALLING * math.exp(-abs(sliding) / STRIBECK)
        direction = 2.0 / math.pi * math.atan(1e3 * sliding)
        return state[1], -state[0] - DAMPING * state[1] + direction * friction

    motion = solve_ivp(rates, (0.0, HORIZON), (x, u), method="RK45")
    late = motion.t > 0.9 * HORIZON
    return float(np.abs(motion.y[1][late]).max()) < 0.5 * SPEED


def unstable_cycle() -> np.ndarray:
    """Points of the boundary of the basin."""

    def rates(_: float, state: np.ndarray) -> tuple[float, float]:
        return state[1], KINETIC + FALLING * math.exp((state[1] - SPEED) / STRIBECK) - state[0] - DAMPING * state[1]

    def turns(_: float, state: np.ndarray) -> float:
        return state[1]

    turns.terminal, turns.direction = True, -1.0

    def swing(amplitude: float, **options: object) -> object:
        start = (EQUILIBRIUM + amplitude, -1e-300)
        return solve_ivp(rates, (0.0, 10.0), start, method="DOP853", rtol=1e-12, atol=1e-14, events=turns, **options)

    amplitude = brentq(lambda a: swing(a).y_events[0][-1, 0] - EQUILIBRIUM - a, 1.0, 1.4, xtol=1e-12)
    return swing(amplitude, max_step=0.002).y.T


def area_within_window(cycle: np.ndarray) -> float:
    """The upper half of the cycle lies within the window at this speed."""
    upper = cycle[cycle[:, 1] >= 0.0]
    upper = upper[np.argsort(upper[:, 0])]
    return float(np.trapezoid(upper[:, 1], upper[:, 0])) / 8.0


def is_inside(cycle: np.ndarray, x: np.ndarray, u: np.ndarray, scale: float) -> np.ndarray:
    """Whether starts lie inside the cycle enlarged by a factor, by the angle about steady sliding."""
    angle = np.arctan2(cycle[:, 1], cycle[:, 0] - EQUILIBRIUM)
    radius = np.hypot(cycle[:, 0] - EQUILIBRIUM, cycle[:, 1])
    order = np.argsort(angle)
    limit = np.interp(np.arctan2(u, x - EQUILIBRIUM), angle[order], radius[order], period=2.0 * math.pi)
    return np.hypot(x - EQUILIBRIUM, u) < scale * limit


def stickslip(binary: Path, threads: int, seed: int) -> tuple[float, float]:
    """Seconds of the whole process, and the share that ends in steady sliding."""
    with tempfile.TemporaryDirectory() as directory:
        job, out = Path(directory) / "job.toml", Path(directory) / "run"
        lines = JOB_FILE.read_text(encoding="utf-8").splitlines()
        job.write_text("\n".join(f"rotating_speed = {SPEED}" if l.startswith("rotating_speed") else l for l in lines))
        command = [binary, "submit", job, "--out", out, "--threads", str(threads)]
        command += ["--samples", str(STARTS), "--seed", str(seed)]
        started = time.perf_counter()
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
        seconds = time.perf_counter() - started
        if done.returncode != 0:
            sys.exit(f"stickslip failed with exit code {done.returncode}:\n{done.stderr}")
        table = pyarrow.parquet.read_table(out / "surface.parquet")
        return seconds, table["n_stable"][0].as_py() / STARTS


def figure(name: str, value: float, unit: str) -> None:
    text = f"{value:.3g}" if value < 1e-2 else f"{value:.3f}" if value < 1000.0 else f"{value:.0f}"
    print(f"{name:<66} {text:>12} {unit}", flush=True)


def check(name: str, cycle: np.ndarray, x: np.ndarray, u: np.ndarray, ends: np.ndarray) -> None:
    """Ends the program if a start is classified wrongly that lies clearly on one side."""
    surely, possibly = is_inside(cycle, x, u, 1.0 - MARGIN), is_inside(cycle, x, u, 1.0 + MARGIN)
    wrong = int(np.count_nonzero(surely & ~ends) + np.count_nonzero(~possibly & ends))
    figure(f"{name}: wrong farther than {MARGIN:g} from the boundary", float(wrong), f"of {len(x)}")
    if wrong:
        sys.exit(f"{name} classifies starts wrongly")


def main() -> None:
    binary = Path(sys.argv[1]).resolve()
    threads = numba.config.NUMBA_NUM_THREADS
    cycle = unstable_cycle()
    area = area_within_window(cycle)
    figure("share of the window inside the unstable cycle", area, "")
    classify(np.zeros(1), np.zeros(1), True)
    rates: dict[str, list[float]] = {}
    for seed in range(1, ROUNDS + 1):
        random = np.random.default_rng(seed)
        x, u = random.uniform(-2.0, 2.0, STARTS), random.uniform(0.0, 2.0, STARTS)
        for count, name in [(1, "one thread"), (threads, f"all {threads} threads")]:
            seconds, share = stickslip(binary, count, seed)
            z = (share - area) / math.sqrt(area * (1.0 - area) / STARTS)
            if abs(z) > LARGEST_Z:
                sys.exit(f"stickslip finds a share of {share}, z = {z:.1f}")
            rates.setdefault(f"stickslip, {name}", []).append(STARTS / seconds)
            numba.set_num_threads(count)
            peers: list[tuple[str, bool, int]] = [("stopping early", True, STARTS), ("to t = 500", False, STARTS // 50)]
            for rule, stops_early, starts in peers:
                started = time.perf_counter()
                ends = classify(x[:starts], u[:starts], stops_early)
                rates.setdefault(f"numba {rule}, {name}", []).append(starts / (time.perf_counter() - started))
                if seed == 1 and count == 1:
                    check(f"numba {rule}", cycle, x[:starts], u[:starts], ends)
        started = time.perf_counter()
        few = slice(0, SCIPY_STARTS)
        ends = np.array([classify_scipy(*pair) for pair in zip(x[few], u[few], strict=True)])
        rates.setdefault("SciPy to t = 500, one thread", []).append(SCIPY_STARTS / (time.perf_counter() - started))
        check("SciPy to t = 500", cycle, x[few], u[few], ends)

    for name, values in rates.items():
        figure(name, float(np.median(values)), "starts/s")
    one, every = rates["stickslip, one thread"], rates[f"stickslip, all {threads} threads"]
    figure(f"stickslip: {STARTS} starts on all {threads} threads", STARTS / float(np.median(every)), "s")
    for ours, theirs in [
        (one, "numba stopping early, one thread"),
        (one, "numba to t = 500, one thread"),
        (one, "SciPy to t = 500, one thread"),
        (every, f"numba stopping early, all {threads} threads"),
    ]:
        ratio = float(np.median(np.array(ours) / np.array(rates[theirs])))
        figure(f"stickslip over {theirs}", ratio, "times")


if __name__ == "__main__":
    main()
