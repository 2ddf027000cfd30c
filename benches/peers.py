"""`make bench-peers`: the job of Figure 14a by stickslip, by NumPy and by OpenTURNS, side by side in one run.

    python benches/peers.py path/to/stickslip

All of them run jobs/fig14a.toml with more samples per cell, so that sampling and not the start-up takes most of the
time. The programs take turns in each round. Rates and ratios are medians over the rounds, each ratio taken within one
round. Each figure is a line with name, value and unit. Absolute values depend on the machine.

Times of stickslip are those of the whole process, from its start to the surface on disk. Times of the peers are those
of the computation alone, without starting Python and loading the libraries. NumPy and OpenTURNS run in one process on
one thread, so the fair ratio is the one with stickslip on one thread.

The probabilities of all of them are compared cell by cell; a disagreement ends the program with exit code 1.
"""

import math
import os
import subprocess
import sys
import tempfile
import time
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import openturns
import pyarrow.parquet

JOB_FILE = Path(__file__).resolve().parent.parent / "jobs" / "fig14a.toml"
ROUNDS = 5
SAMPLES = 100_000
# The general eigenvalue solver is more than a hundred times slower than the closed form.
EIGENVALUE_SAMPLES = 200
# Both libraries are faster in batches that stay in the cache than with a whole cell in one array.
BATCH = 10_000
LARGEST_Z = 6.0
# Over some 700 cells, the mean of the squares has a standard deviation of 0.05 about 1.
LARGEST_MEAN_SQUARE = 1.4

# The parameters that decide linear stability: the preset "sui-ding-2018" of the job file, typed in again from
# Parameters::sui_ding_2018 in crates/core/src/models/pad_on_disc/parameters.rs. SI units.
DENSITY = 7800.0
YOUNGS_MODULUS = 2.1e11
POISSONS_RATIO = 0.3
THICKNESS = 0.020
OUTER_RADIUS = 0.135
MASS = 0.10
MOMENT_OF_INERTIA = 2.0e-4
MOMENT_ARM = 0.008
CALLIPER_TANGENTIAL = 3.249e7
CALLIPER_NORMAL = 3.249e7
CALLIPER_ANGULAR = 2.472e4
CONTACT_NORMAL = 3.816e7
CONTACT_TANGENTIAL_1 = 2.138e7
CONTACT_TANGENTIAL_2 = 2.138e7
DAMPING_TANGENTIAL = 369.0
DAMPING_NORMAL = 106.1
DAMPING_ANGULAR = 0.08882
KINETIC_FRICTION = 0.25
STRIBECK_VELOCITY = 0.72

# Scales and shorthands of the paper.
ETA0 = YOUNGS_MODULUS / (12.0 * (1.0 - POISSONS_RATIO**2) * DENSITY * THICKNESS)
SPEED_SCALE = THICKNESS * math.sqrt(ETA0)
TRANSMISSION = CONTACT_TANGENTIAL_2 / CONTACT_TANGENTIAL_1
FORCE_PER_PRELOAD = CONTACT_NORMAL * CALLIPER_NORMAL / (CONTACT_NORMAL + CALLIPER_NORMAL)


@dataclass
class Job:
    """The cells of the job, static friction varying fastest, and its random inputs."""

    rotating_speed: float
    relative_std: float
    preloads: np.ndarray
    static_frictions: np.ndarray

    @classmethod
    def read(cls, path: Path) -> "Job":
        spec = tomllib.loads(path.read_text(encoding="utf-8"))
        axes = spec["axes"]
        preload, static_friction = (
            np.linspace(axes[name]["from"], axes[name]["to"], axes[name]["points"])
            for name in ("preload", "static_friction")
        )
        return cls(
            rotating_speed=axes["rotating_speed"],
            relative_std=spec["random"]["relative_std"],
            preloads=np.repeat(preload, len(static_friction)),
            static_frictions=np.tile(static_friction, len(preload)),
        )

    def cells(self) -> list[tuple[float, float]]:
        return list(zip(self.preloads.tolist(), self.static_frictions.tolist(), strict=True))

    def speed_ratio(self) -> float:
        """Disc speed under the pad over the Stribeck velocity."""
        return OUTER_RADIUS * self.rotating_speed / STRIBECK_VELOCITY

    def weakening(self) -> float:
        """Fall of friction with scaled sliding speed, per unit of f_s - f_c."""
        return SPEED_SCALE / STRIBECK_VELOCITY * math.exp(-self.speed_ratio())

    def critical_product(self) -> float:
        """Delta (f_s - f_c) on the boundary of linear stability."""
        return DAMPING_TANGENTIAL * math.sqrt(ETA0) / (TRANSMISSION * FORCE_PER_PRELOAD * self.weakening())


@dataclass
class Contender:
    """A program that counts the unstable samples of every cell, with the results of its rounds."""

    name: str
    samples: int
    # From (samples per cell, seed) to the seconds and the unstable samples of each cell.
    run: Callable[[int, int], tuple[float, np.ndarray]]
    rates: list[float] = field(default_factory=list)
    counts: list[np.ndarray] = field(default_factory=list)

    def take_turn(self, seed: int) -> None:
        seconds, unstable = self.run(self.samples, seed)
        self.rates.append(len(unstable) * self.samples / seconds)
        self.counts.append(unstable)


def stickslip(binary: Path, threads: int, job: Job) -> Callable[[int, int], tuple[float, np.ndarray]]:
    """The whole process, into a fresh run directory."""

    def run(samples: int, seed: int) -> tuple[float, np.ndarray]:
        with tempfile.TemporaryDirectory() as directory:
            out = Path(directory) / "run"
            command = [binary, "submit", JOB_FILE, "--out", out]
            command += ["--threads", str(threads), "--samples", str(samples), "--seed", str(seed)]
            started = time.perf_counter()
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
            seconds = time.perf_counter() - started
            if done.returncode != 0:
                sys.exit(f"stickslip failed with exit code {done.returncode}:\n{done.stderr}")
            return seconds, read_surface(out / "surface.parquet", samples, job)

    return run


def read_surface(path: Path, samples: int, job: Job) -> np.ndarray:
    """The unstable samples of each cell, after checking that the cells are those that the peers compute."""
    table = pyarrow.parquet.read_table(path)
    column = {name: table[name].to_numpy() for name in table.column_names}
    same_cells = len(column["cell"]) == len(job.preloads) and all(
        np.allclose(column[name], expected, rtol=1e-12, atol=0.0)
        for name, expected in [
            ("preload", job.preloads),
            ("static_friction", job.static_frictions),
            ("std_preload", job.relative_std),
            ("std_static_friction", job.relative_std),
            ("rotating_speed_rad_s", job.rotating_speed),
        ]
    )
    if not same_cells:
        sys.exit(f"{path.name}: the cells are not those of {JOB_FILE.name} as read here")
    if np.any(column["n_stable"] + column["n_unstable"] != samples):
        sys.exit(f"{path.name}: not every sample has a verdict")
    return column["n_unstable"]


def timed(count: Callable[[int, int], list[int]]) -> Callable[[int, int], tuple[float, np.ndarray]]:
    """Times a peer that runs in this process."""

    def run(samples: int, seed: int) -> tuple[float, np.ndarray]:
        started = time.perf_counter()
        unstable = count(samples, seed)
        return time.perf_counter() - started, np.array(unstable)

    return run


def numpy_closed_form(job: Job) -> Callable[[int, int], list[int]]:
    """NumPy arrays, one batch of a cell at a time."""
    critical_product = job.critical_product()

    def count(samples: int, seed: int) -> list[int]:
        generator = np.random.Generator(np.random.PCG64(seed))

        def unstable(preload: float, static_friction: float) -> int:
            preloads = preload * (1.0 + job.relative_std * generator.standard_normal(BATCH))
            static_frictions = static_friction * (1.0 + job.relative_std * generator.standard_normal(BATCH))
            # Without preload or with rising friction a sample is stable. The maximum keeps its product at or below 0.
            products = preloads * np.maximum(static_frictions - KINETIC_FRICTION, 0.0)
            return np.count_nonzero(products > critical_product)

        return [sum(unstable(*cell) for _ in range(samples // BATCH)) for cell in job.cells()]

    return count


def openturns_closed_form(job: Job) -> Callable[[int, int], list[int]]:
    """OpenTURNS: a joint distribution, a symbolic function and batches of samples, counted by NumPy.

    That is at least as fast as the library's own probability estimate by simulation with blocks of the same size.
    More of its threads would not help: they share the evaluation of the function, but not the sampling, which takes
    most of the time.
    """
    critical_product = job.critical_product()
    openturns.TBB.SetThreadsNumber(1)
    # For the maximum, see numpy_closed_form.
    product = openturns.SymbolicFunction(
        ["preload", "static_friction"], [f"preload * max(static_friction - {KINETIC_FRICTION}, 0)"]
    )

    def count(samples: int, seed: int) -> list[int]:
        openturns.RandomGenerator.SetSeed(seed)

        def unstable(inputs: openturns.JointDistribution) -> int:
            products = np.asarray(product(inputs.getSample(BATCH)))
            return np.count_nonzero(products > critical_product)

        counts = []
        for cell in job.cells():
            inputs = openturns.JointDistribution(
                [openturns.Normal(expected, job.relative_std * expected) for expected in cell]
            )
            counts.append(sum(unstable(inputs) for _ in range(samples // BATCH)))
        return counts

    return count


def numpy_eigenvalues(job: Job) -> Callable[[int, int], list[int]]:
    """The method of the paper: eigenvalues of the Jacobian of every sample, by a general solver."""

    def count(samples: int, seed: int) -> list[int]:
        generator = np.random.Generator(np.random.PCG64(seed))

        def unstable(preload: float, static_friction: float) -> int:
            preloads = preload * (1.0 + job.relative_std * generator.standard_normal(samples))
            static_frictions = static_friction * (1.0 + job.relative_std * generator.standard_normal(samples))
            growing = np.linalg.eigvals(jacobians(job, preloads, static_frictions)).real.max(axis=1) > 0.0
            return np.count_nonzero(growing & (preloads > 0.0) & (static_frictions > KINETIC_FRICTION))

        return [unstable(*cell) for cell in job.cells()]

    return count


def jacobians(job: Job, preloads: np.ndarray, static_frictions: np.ndarray) -> np.ndarray:
    """The 6x6 Jacobians of steady sliding, the paper's equation (3.8), for (x, x', y, y', phi, phi')."""
    mass, inertia, root = MASS * ETA0, MOMENT_OF_INERTIA * ETA0, math.sqrt(ETA0)
    arm = 0.5 * MOMENT_ARM * THICKNESS / inertia
    falling = static_frictions - KINETIC_FRICTION
    weakening_force = TRANSMISSION * FORCE_PER_PRELOAD * preloads * falling * job.weakening()
    friction_coefficient = KINETIC_FRICTION + falling * math.exp(-job.speed_ratio())
    friction_by_normal = TRANSMISSION * friction_coefficient * CONTACT_NORMAL

    matrices = np.zeros((len(preloads), 6, 6))
    matrices[:, [0, 2, 4], [1, 3, 5]] = 1.0
    matrices[:, 1, 0] = -(CALLIPER_TANGENTIAL + CONTACT_TANGENTIAL_2) / mass
    matrices[:, 1, 1] = (weakening_force - DAMPING_TANGENTIAL * root) / mass
    matrices[:, 1, 2] = -friction_by_normal / mass
    matrices[:, 3, 2] = -(CALLIPER_NORMAL + CONTACT_NORMAL) / mass
    matrices[:, 3, 3] = -DAMPING_NORMAL * root / mass
    matrices[:, 5, 0] = -arm * CONTACT_TANGENTIAL_2
    matrices[:, 5, 1] = arm * weakening_force
    matrices[:, 5, 2] = -arm * friction_by_normal
    matrices[:, 5, 4] = -CALLIPER_ANGULAR / inertia
    matrices[:, 5, 5] = -DAMPING_ANGULAR * root / inertia
    return matrices


def two_proportions(ours: Contender, theirs: Contender) -> np.ndarray:
    """The z of the two-proportion test over all rounds, for every cell where it is nearly normal."""
    our_counts, their_counts = sum(ours.counts), sum(theirs.counts)
    our_samples, their_samples = ours.samples * len(ours.counts), theirs.samples * len(theirs.counts)
    pooled = (our_counts + their_counts) / (our_samples + their_samples)
    # At least ten samples of either verdict must be expected from either program.
    meaningful = np.minimum(pooled, 1.0 - pooled) * min(our_samples, their_samples) >= 10.0
    difference = our_counts / our_samples - their_counts / their_samples
    variance = pooled * (1.0 - pooled) * (1.0 / our_samples + 1.0 / their_samples)
    return difference[meaningful] / np.sqrt(variance[meaningful])


def figure(name: str, value: float, unit: str) -> None:
    text = f"{value:.{0 if value >= 1000.0 else 3}f}"
    print(f"{name:<58} {text:>16} {unit}", flush=True)


def median_ratio(ours: Contender, theirs: Contender) -> float:
    return float(np.median(np.divide(ours.rates, theirs.rates)))


def check_agreement(one: Contender, every: Contender, peers: list[Contender]) -> None:
    """Prints how far the peers are from stickslip; ends the program if that is more than chance explains."""
    if not np.array_equal(one.counts, every.counts):
        sys.exit("stickslip gives other counts on all threads than on one")
    disagreements = []
    for peer in peers:
        z = two_proportions(one, peer)
        largest = float(np.abs(z).max())
        figure(f"largest |z| against {peer.name} (limit {LARGEST_Z:g})", largest, f"over {len(z)} cells")
        mean_square = float(np.mean(z**2))
        figure(f"mean z^2 against {peer.name} (limit {LARGEST_MEAN_SQUARE:g})", mean_square, "(1 expected)")
        if largest > LARGEST_Z or mean_square > LARGEST_MEAN_SQUARE:
            disagreements.append(f"stickslip and {peer.name} disagree: max |z| {largest:.1f}, mean z^2 {mean_square:.2f}")
    if disagreements:
        sys.exit("\n".join(disagreements))


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: python benches/peers.py path/to/stickslip")
    binary = Path(sys.argv[1]).resolve()
    if not binary.is_file():
        sys.exit(f"there is no program {binary}")
    job = Job.read(JOB_FILE)
    threads = os.cpu_count() or 1

    one = Contender("stickslip, 1 thread", SAMPLES, stickslip(binary, 1, job))
    every = Contender(f"stickslip, all {threads} threads", SAMPLES, stickslip(binary, threads, job))
    arrays = Contender("NumPy", SAMPLES, timed(numpy_closed_form(job)))
    symbolic = Contender("OpenTURNS", SAMPLES, timed(openturns_closed_form(job)))
    solver = Contender("NumPy eigvals", EIGENVALUE_SAMPLES, timed(numpy_eigenvalues(job)))
    contenders = [one, every, arrays, symbolic, solver]

    for seed in range(1, ROUNDS + 1):
        for contender in contenders:
            contender.take_turn(seed)

    for contender in contenders:
        figure(contender.name, float(np.median(contender.rates)), "samples/s")
    for peer in [arrays, symbolic]:
        for ours in [one, every]:
            figure(f"{ours.name} over {peer.name}", median_ratio(ours, peer), "times")
    check_agreement(one, every, [arrays, symbolic, solver])


if __name__ == "__main__":
    main()
