"""`make bench-peers`: samples simulated on a rigid disc by stickslip, numba, SciPy and diffrax, side by side.

    python benches/peers_time_domain.py path/to/stickslip

The problem is that of jobs/fig14b.toml with `disc = "rigid"`: a mass on a moving belt, x'' = G mu(v - x') - K x - C x'
in slip, started one per cent of x0 from steady sliding and simulated until a swing is longer or shorter than an earlier
one by 1e-4, or the pad sticks. Every program decides by the same rule and locates turning points and sticking.

First, accuracy is checked: the ratio of two swings of each program is compared with SciPy's DOP853 at a tolerance of
1e-11, on samples near the boundary and all over the grid. stickslip and numba take a fixed step of a tenth over the
natural frequency; the other programs have tolerances with which they are at least as accurate. A verdict that differs
from the reference ends the program with exit code 1, unless the swings are within 1e-4 of neutral.

Each figure is a line with name, value and unit. Rates and ratios are medians over the rounds, each ratio taken within
one round. Times of stickslip are those of the whole process; times of the others are those of the computation alone,
without start, import and compilation (which takes diffrax some seconds).
"""

import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import diffrax
import jax
import jax.numpy as jnp
import numba
import numpy as np
import optimistix
import pyarrow.parquet
from scipy.integrate import solve_ivp

from peers import (
    CALLIPER_TANGENTIAL,
    CONTACT_TANGENTIAL_2,
    DAMPING_TANGENTIAL,
    ETA0,
    FORCE_PER_PRELOAD,
    JOB_FILE,
    KINETIC_FRICTION,
    MASS,
    OUTER_RADIUS,
    SPEED_SCALE,
    STRIBECK_VELOCITY,
    TRANSMISSION,
    Job,
)

ROUNDS = 3
# Samples in each of the 780 cells; diffrax and SciPy are slower.
SAMPLES = 1000
DIFFRAX_SAMPLES = 20
SCIPY_TRAJECTORIES = 150
PROBES = 120
LARGEST_Z = 6.0
# Relative change of amplitude that decides, as in stickslip.
CHANGE = 1e-4
HORIZON = 1e4

JOB = Job.read(JOB_FILE)
STIFFNESS = (CALLIPER_TANGENTIAL + CONTACT_TANGENTIAL_2) / (MASS * ETA0)
DAMPING = DAMPING_TANGENTIAL * math.sqrt(ETA0) / (MASS * ETA0)
DISC_SPEED = OUTER_RADIUS * JOB.rotating_speed / SPEED_SCALE
INVERSE_STRIBECK = SPEED_SCALE / STRIBECK_VELOCITY
GAIN = TRANSMISSION * FORCE_PER_PRELOAD / (MASS * ETA0)
STEP = 0.1 / math.sqrt(STIFFNESS)
DISPLACEMENT = 1.01
# Bounds exp(u / v_s) in trial steps far beyond the disc's speed.
LARGEST_EXPONENT = DISC_SPEED * INVERSE_STRIBECK + 1.0

UNSTABLE, STABLE, UNDECIDED = 1, -1, 0


def pulls(preload: float, static_friction: float) -> tuple[float, float, float]:
    """G f_c, G (f_s - f_c) exp(-v / v_s), and the position where the motion starts."""
    gain = GAIN * preload
    kinetic = gain * KINETIC_FRICTION
    falling = gain * (static_friction - KINETIC_FRICTION) * math.exp(-DISC_SPEED * INVERSE_STRIBECK)
    return kinetic, falling, DISPLACEMENT * (kinetic + falling) / STIFFNESS


numba_pulls = numba.njit(inline="always")(pulls)


@numba.njit
def decide_numba(preload: float, static_friction: float, h: float) -> tuple[int, float]:
    """Verdict and ratio of swings, by Runge-Kutta's method with fixed steps."""
    if preload <= 0.0 or static_friction < KINETIC_FRICTION:
        return STABLE, math.nan
    kinetic, falling, x = numba_pulls(preload, static_friction)
    u, turn, reference = 0.0, x, 0.0
    for _ in range(int(HORIZON / h)):
        a1 = kinetic + falling * math.exp(u * INVERSE_STRIBECK) - STIFFNESS * x - DAMPING * u
        u2 = u + 0.5 * h * a1
        a2 = kinetic + falling * math.exp(u2 * INVERSE_STRIBECK) - STIFFNESS * (x + 0.5 * h * u) - DAMPING * u2
        u3 = u + 0.5 * h * a2
        a3 = kinetic + falling * math.exp(u3 * INVERSE_STRIBECK) - STIFFNESS * (x + 0.5 * h * u2) - DAMPING * u3
        u4 = u + h * a3
        power = min(u4 * INVERSE_STRIBECK, LARGEST_EXPONENT)
        a4 = kinetic + falling * math.exp(power) - STIFFNESS * (x + h * u3) - DAMPING * u4
        next_x = x + h * (u + h / 6.0 * (a1 + a2 + a3))
        next_u = u + h / 6.0 * (a1 + 2.0 * (a2 + a3) + a4)
        if next_u >= DISC_SPEED:
            # A swing that ends in stick is longer than the first one, which did not end in stick.
            return UNSTABLE, math.nan
        if u * next_u <= 0.0 and u != 0.0:
            # The turning point of the cubic through speeds and accelerations.
            c1, d = h * a1, next_u - u
            c2, c3 = 3.0 * d - h * (2.0 * a1 + a4), h * (a1 + a4) - 2.0 * d
            s = u / (u - next_u)
            for _ in range(4):
                s -= (u + s * (c1 + s * (c2 + s * c3))) / (c1 + s * (2.0 * c2 + s * 3.0 * c3))
            at = x + h * s * (u + s * (c1 / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0)))
            amplitude = 0.5 * abs(at - turn)
            turn = at
            if reference == 0.0:
                reference = amplitude
            else:
                ratio = amplitude / reference
                if ratio > 1.0 + CHANGE:
                    return UNSTABLE, ratio
                if ratio * (1.0 + CHANGE) < 1.0:
                    return STABLE, ratio
        x, u = next_x, next_u
    return UNDECIDED, math.nan


@numba.njit(parallel=True)
def count_numba(preloads: np.ndarray, static_frictions: np.ndarray, std: float, samples: int, seed: int) -> np.ndarray:
    unstable = np.zeros(preloads.size, np.int64)
    for cell in numba.prange(preloads.size):
        np.random.seed(seed * 1000 + cell)
        for _ in range(samples):
            preload = preloads[cell] * (1.0 + std * np.random.standard_normal())
            static_friction = static_frictions[cell] * (1.0 + std * np.random.standard_normal())
            unstable[cell] += decide_numba(preload, static_friction, STEP)[0] == UNSTABLE
    return unstable


def decide_scipy(preload: float, static_friction: float, **options: object) -> tuple[int, float]:
    """Likewise, by an adaptive method with located events."""
    if preload <= 0.0 or static_friction < KINETIC_FRICTION:
        return STABLE, math.nan
    kinetic, falling, start = pulls(preload, static_friction)

    def rates(_: float, state: np.ndarray) -> tuple[float, float]:
        x, u = state
        power = min(u * INVERSE_STRIBECK, LARGEST_EXPONENT)
        return u, kinetic + falling * math.exp(power) - STIFFNESS * x - DAMPING * u

    def turns(_: float, state: np.ndarray) -> float:
        return state[1]

    def sticks(_: float, state: np.ndarray) -> float:
        return DISC_SPEED - state[1]

    turns.terminal, sticks.terminal = 3, True
    state, reference, now = (start, 0.0), None, 0.0
    while now < HORIZON:
        motion = solve_ivp(rates, (now, HORIZON), state, events=(turns, sticks), **options)
        turning = motion.y_events[0][:, 0]
        for amplitude in 0.5 * np.abs(np.diff(turning)):
            if reference is None:
                reference = amplitude
            elif amplitude / reference > 1.0 + CHANGE:
                return UNSTABLE, amplitude / reference
            elif amplitude / reference * (1.0 + CHANGE) < 1.0:
                return STABLE, amplitude / reference
        if len(motion.t_events[1]):
            return UNSTABLE, math.nan
        state, now = (turning[-1], 0.0), motion.t[-1]
    return UNDECIDED, math.nan


def decide_diffrax() -> Callable[[jax.Array, jax.Array], tuple[jax.Array, jax.Array]]:
    """Likewise for one sample, to be mapped: by diffrax's Tsit5, arc by arc between located turning points."""
    controller = diffrax.PIDController(rtol=1e-7, atol=1e-10)
    root_finder = optimistix.Newton(1e-8, 1e-12)

    def rates(_: jax.Array, state: tuple, pull: tuple) -> tuple:
        (x, u), (kinetic, falling) = state, pull
        power = jnp.minimum(u * INVERSE_STRIBECK, LARGEST_EXPONENT)
        return u, kinetic + falling * jnp.exp(power) - STIFFNESS * x - DAMPING * u

    def sample(preload: jax.Array, static_friction: jax.Array) -> tuple[jax.Array, jax.Array]:
        outside = (preload <= 0.0) | (static_friction < KINETIC_FRICTION)
        gain = GAIN * jnp.where(outside, 0.1, preload)
        excess = jnp.where(outside, 0.1, static_friction - KINETIC_FRICTION)
        kinetic = gain * KINETIC_FRICTION
        falling = gain * excess * math.exp(-DISC_SPEED * INVERSE_STRIBECK)
        start = DISPLACEMENT * (kinetic + falling) / STIFFNESS

        def arc(carry: dict) -> dict:
            event = diffrax.Event(
                [lambda t, y, args, **_: carry["side"] * y[1], lambda t, y, args, **_: DISC_SPEED - y[1]],
                root_finder,
                direction=[False, False],
            )
            motion = diffrax.diffeqsolve(
                diffrax.ODETerm(rates),
                diffrax.Tsit5(),
                0.0,
                HORIZON,
                3.0 * STEP,
                (carry["turn"], jnp.zeros_like(carry["turn"])),
                (kinetic, falling),
                stepsize_controller=controller,
                event=event,
                max_steps=256,
                adjoint=diffrax.ForwardMode(),
                throw=False,
            )
            end, stuck = motion.ys[0][-1], motion.event_mask[1]
            amplitude = 0.5 * jnp.abs(end - carry["turn"])
            ratio = amplitude / carry["reference"]
            is_decided = ~stuck & (carry["reference"] > 0.0)
            grows, shrinks = is_decided & (ratio > 1.0 + CHANGE), is_decided & (ratio * (1.0 + CHANGE) < 1.0)
            return {
                "turn": end,
                "side": -carry["side"],
                "reference": jnp.where(carry["reference"] > 0.0, carry["reference"], amplitude),
                "verdict": jnp.where(stuck | grows, UNSTABLE, jnp.where(shrinks, STABLE, UNDECIDED)),
                "ratio": jnp.where(is_decided, ratio, jnp.nan),
                "arcs": carry["arcs"] + 1,
            }

        carry = {
            "turn": start,
            "side": jnp.asarray(-1.0),
            "reference": jnp.asarray(0.0),
            "verdict": jnp.where(outside, STABLE, UNDECIDED),
            "ratio": jnp.asarray(jnp.nan),
            "arcs": jnp.asarray(0),
        }
        end = jax.lax.while_loop(lambda c: (c["verdict"] == UNDECIDED) & (c["arcs"] < 200), arc, carry)
        return end["verdict"], end["ratio"]

    return sample


def stickslip(binary: Path, threads: int, seed: int) -> tuple[float, np.ndarray]:
    """Seconds of the whole process, and the unstable samples of each cell."""
    with tempfile.TemporaryDirectory() as directory:
        job, out = Path(directory) / "job.toml", Path(directory) / "run"
        criterion = 'kind = "time-domain"\ndisc = "rigid"'
        job.write_text(JOB_FILE.read_text().replace('kind = "eigenvalue"', criterion))
        command = [binary, "submit", job, "--out", out, "--threads", str(threads)]
        command += ["--samples", str(SAMPLES), "--seed", str(seed)]
        started = time.perf_counter()
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
        seconds = time.perf_counter() - started
        if done.returncode != 0:
            sys.exit(f"stickslip failed with exit code {done.returncode}:\n{done.stderr}")
        return seconds, pyarrow.parquet.read_table(out / "surface.parquet")["n_unstable"].to_numpy()


def figure(name: str, value: float, unit: str) -> None:
    text = f"{value:.3g}" if value < 1e-2 else f"{value:.3f}" if value < 1000.0 else f"{value:.0f}"
    print(f"{name:<66} {text:>12} {unit}", flush=True)


def draw(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Samples of cells all over the grid."""
    random = np.random.default_rng(seed)
    cells = random.integers(0, len(JOB.preloads), count)
    deviates = 1.0 + JOB.relative_std * random.standard_normal((2, count))
    return JOB.preloads[cells] * deviates[0], JOB.static_frictions[cells] * deviates[1]


def check_accuracy(diffrax_batch: Callable) -> None:
    """Compares every program with the tight reference, and ends the program if a verdict is wrong."""
    preloads, static_frictions = draw(PROBES, 1)
    random = np.random.default_rng(2)
    near_friction = random.uniform(0.3, 0.6, PROBES)
    near_product = JOB.critical_product() * (1.0 + 0.03 * random.uniform(-1.0, 1.0, PROBES))
    preloads = np.concatenate([preloads, near_product / (near_friction - KINETIC_FRICTION)])
    static_frictions = np.concatenate([static_frictions, near_friction])
    pairs = list(zip(preloads, static_frictions, strict=True))
    tight = {"method": "DOP853", "rtol": 1e-11, "atol": 1e-16}
    reference = np.array([decide_scipy(*pair, **tight) for pair in pairs])
    near = np.abs(reference[:, 1] - 1.0) < 0.1
    found = {
        "numba (and stickslip's own step)": np.array([decide_numba(*pair, STEP) for pair in pairs]),
        "SciPy solve_ivp": np.array([decide_scipy(*pair, **SCIPY) for pair in pairs]),
        "diffrax": np.array(diffrax_batch(preloads, static_frictions)).T,
    }
    for name, outcome in found.items():
        error = np.nanmax(np.abs(outcome[near, 1] - reference[near, 1]))
        figure(f"{name}: largest error of a ratio of swings", float(error), "")
        neutral = np.abs(reference[:, 1] - 1.0) < 2.0 * CHANGE
        wrong = int(((outcome[:, 0] != reference[:, 0]) & ~neutral).sum())
        if wrong:
            sys.exit(f"{name}: {wrong} of {len(pairs)} verdicts differ from the reference")


SCIPY = {"method": "RK45", "rtol": 1e-7, "atol": 1e-11}


def main() -> None:
    binary = Path(sys.argv[1]).resolve()
    jax.config.update("jax_enable_x64", True)
    diffrax_batch = jax.jit(jax.vmap(decide_diffrax()))
    threads = numba.config.NUMBA_NUM_THREADS
    cells = len(JOB.preloads)
    check_accuracy(diffrax_batch)
    batch = draw(cells * DIFFRAX_SAMPLES, 3)
    jax.block_until_ready(diffrax_batch(*batch))
    count_numba(JOB.preloads, JOB.static_frictions, JOB.relative_std, 1, 1)

    rates: dict[str, list[float]] = {}
    unstable: dict[str, list[np.ndarray]] = {"stickslip": [], "numba": []}
    for seed in range(1, ROUNDS + 1):
        for count, name in [(1, "one thread"), (threads, f"all {threads} threads")]:
            seconds, counts = stickslip(binary, count, seed)
            rates.setdefault(f"stickslip, {name}", []).append(cells * SAMPLES / seconds)
            numba.set_num_threads(count)
            started = time.perf_counter()
            counts_numba = count_numba(JOB.preloads, JOB.static_frictions, JOB.relative_std, SAMPLES, seed)
            rates.setdefault(f"numba, {name}", []).append(cells * SAMPLES / (time.perf_counter() - started))
        unstable["stickslip"].append(counts)
        unstable["numba"].append(counts_numba)
        started = time.perf_counter()
        jax.block_until_ready(diffrax_batch(*batch))
        rates.setdefault("diffrax, one batch", []).append(len(batch[0]) / (time.perf_counter() - started))
        preloads, static_frictions = draw(SCIPY_TRAJECTORIES, seed)
        started = time.perf_counter()
        for pair in zip(preloads, static_frictions, strict=True):
            decide_scipy(*pair, **SCIPY)
        rates.setdefault("SciPy solve_ivp, one thread", []).append(
            SCIPY_TRAJECTORIES / (time.perf_counter() - started)
        )

    for name, values in rates.items():
        figure(name, float(np.median(values)), "samples/s")
    one, every = rates["stickslip, one thread"], rates[f"stickslip, all {threads} threads"]
    for ours, theirs in [
        (one, "numba, one thread"),
        (one, "SciPy solve_ivp, one thread"),
        (every, f"numba, all {threads} threads"),
        (every, "diffrax, one batch"),
    ]:
        ratio = float(np.median(np.array(ours) / np.array(rates[theirs])))
        figure(f"stickslip over {theirs}", ratio, "times")

    a, b = (np.sum(unstable[name], axis=0) for name in ("stickslip", "numba"))
    total = ROUNDS * SAMPLES
    share = (a + b) / (2 * total)
    compared = np.minimum(share, 1.0 - share) * total > 10
    z = (a - b)[compared] / total / np.sqrt(2.0 * share * (1.0 - share) / total)[compared]
    figure(f"stickslip against numba, largest |z| of {compared.sum()} cells", float(np.abs(z).max()), "")
    if np.abs(z).max() > LARGEST_Z:
        sys.exit("stickslip and numba disagree")


if __name__ == "__main__":
    main()
