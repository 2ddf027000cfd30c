"""`make bench-peers`: the methods of sampling, by stickslip and by OpenTURNS, at equal error and side by side.

    python benches/peers_methods.py path/to/stickslip

The surface is a coarse Figure 14a: the same axes with fewer points, without cells where nearly all samples are stable.
The errors are deviations from the exact probabilities, root mean square over the cells and over SEEDS seeds. Every
method doubles its samples per cell until its error is within the target. It is timed with that number and with half of
it, the programs taking turns. Quasi-Monte Carlo uses scrambled Sobol points in stickslip and randomly shifted ones in
OpenTURNS, with new randomisations in every cell: 16 ("x 16"), which also gives a good interval, or as few as the
program allows, with more points each: two in stickslip ("x 2"), one in OpenTURNS ("x 1").

Each figure is a line with name, value and unit. Seconds and ratios are medians over the rounds, each ratio taken within
one round. Doubling may overshoot the target by different amounts, so there are two ratios: of the runs as they are, and
of the seconds at the target itself, interpolated (in logarithms) between the last two numbers of samples. As in
peers.py, the time of stickslip is that of the whole process and the time of OpenTURNS that of the computation alone;
one thread each.

The exact probabilities are compared with a quadrature in this file, and the error of Monte Carlo with that of
independent samples; a disagreement, or a target that is never reached, ends the program with exit code 1.
"""

import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import openturns
import pyarrow.parquet

from peers import KINETIC_FRICTION, LARGEST_MEAN_SQUARE, Job, figure

JOB = """
name = "methods"
model.preset = "sui-ding-2018"
criterion.kind = "eigenvalue"
random = { inputs = ["preload", "static_friction"], relative_std = 0.2 }

[axes]
rotating_speed = 15.0
preload = { from = 0.03, to = 0.30, points = 10 }
static_friction = { from = 0.27, to = 0.50, points = 9 }

[sampling]
"""
# To be filled in by each run.
MONTE_CARLO = "samples = {samples}\nseed = {seed}\n"
SOBOL = 'method = "sobol"\n' + MONTE_CARLO
SEEDS = 5
ROUNDS = 3
# Samples in each cell: the first number tried, and the last.
FEWEST_SAMPLES = 1 << 10
MOST_SAMPLES = 1 << 24
# Batches that stay in the cache, see peers.py; a power of two, as the samples are.
BATCH = 1 << 13
LARGEST_QUADRATURE_DIFFERENCE = 1e-12

# From (samples per cell, seed) to the seconds and the probability of each cell.
Run = Callable[[int, int], tuple[float, np.ndarray]]


@dataclass
class Step:
    """A number of samples per cell, the error with them, and the seconds of every round."""

    samples: int
    error: float
    seconds: list[float] = field(default_factory=list)


@dataclass
class Method:
    """A method of one of the programs, with the numbers of samples that it tried."""

    name: str
    run: Run
    # The last two: half of the samples, whose error is beyond the target, and the samples, whose error is within.
    steps: list[Step] = field(default_factory=list)

    def climb(self, exact: np.ndarray, target: float) -> None:
        samples = FEWEST_SAMPLES
        while not self.steps or self.steps[-1].error > target:
            if samples > MOST_SAMPLES:
                sys.exit(f"{self.name}: not within {target:g} of the exact probabilities with {MOST_SAMPLES} samples")
            found = [self.run(samples, seed)[1] for seed in range(1, SEEDS + 1)]
            self.steps.append(Step(samples, float(np.sqrt(np.mean(np.square(np.array(found) - exact))))))
            samples *= 2
        if len(self.steps) < 2:
            sys.exit(f"{self.name}: {FEWEST_SAMPLES} samples are too many to begin with for an error of {target:g}")

    def take_turn(self, seed: int) -> None:
        for step in self.steps[-2:]:
            step.seconds.append(self.run(step.samples, seed)[0])

    def seconds(self) -> np.ndarray:
        return np.array(self.steps[-1].seconds)

    def seconds_at(self, target: float) -> np.ndarray:
        """The seconds at the target itself, for every round."""
        half, full = self.steps[-2:]
        share = math.log(half.error / target) / math.log(half.error / full.error)
        return np.power(half.seconds, 1.0 - share) * np.power(full.seconds, share)


def stickslip(binary: Path, job: Job, sampling: str) -> Run:
    """The whole process on one thread, into a fresh run directory."""

    def run(samples: int, seed: int) -> tuple[float, np.ndarray]:
        with tempfile.TemporaryDirectory() as directory:
            job_file, out = Path(directory) / "job.toml", Path(directory) / "run"
            job_file.write_text(JOB + sampling.format(samples=samples, seed=seed), encoding="utf-8")
            command = [binary, "submit", job_file, "--out", out, "--threads", "1"]
            started = time.perf_counter()
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
            seconds = time.perf_counter() - started
            if done.returncode != 0:
                sys.exit(f"stickslip failed with exit code {done.returncode}:\n{done.stderr}")
            table = pyarrow.parquet.read_table(out / "surface.parquet")
        column = {name: table[name].to_numpy() for name in ["preload", "static_friction", "p_unstable"]}
        for name, expected in [("preload", job.preloads), ("static_friction", job.static_frictions)]:
            if column[name].shape != expected.shape or not np.allclose(column[name], expected, rtol=1e-12, atol=0.0):
                sys.exit("surface.parquet: the cells are not those of the job as read here")
        return seconds, column["p_unstable"]

    return run


def openturns_probabilities(job: Job, count: Callable[[openturns.JointDistribution, int], int]) -> Run:
    """Computes the cells one by one. `count` returns the unstable ones of a number of samples of the inputs."""

    def run(samples: int, seed: int) -> tuple[float, np.ndarray]:
        started = time.perf_counter()
        openturns.RandomGenerator.SetSeed(seed)
        probabilities = []
        for cell in job.cells():
            inputs = openturns.JointDistribution(
                [openturns.Normal(expected, job.relative_std * expected) for expected in cell]
            )
            probabilities.append(count(inputs, samples) / samples)
        return time.perf_counter() - started, np.array(probabilities)

    return run


def openturns_verdicts(job: Job) -> Callable[[openturns.Sample], int]:
    """Counts the unstable ones of a sample by a symbolic function and NumPy, as in peers.py.

    ProbabilitySimulationAlgorithm, with experiments as below and blocks of the same size, takes longer.
    """
    critical_product = job.critical_product()
    product = openturns.SymbolicFunction(
        ["preload", "static_friction"], [f"preload * max(static_friction - {KINETIC_FRICTION}, 0)"]
    )
    return lambda sample: np.count_nonzero(np.asarray(product(sample)) > critical_product)


def openturns_monte_carlo(job: Job) -> Run:
    unstable = openturns_verdicts(job)

    def count(inputs: openturns.JointDistribution, samples: int) -> int:
        size = min(samples, BATCH)
        experiment = openturns.MonteCarloExperiment(inputs, size)
        return sum(unstable(experiment.generate()) for _ in range(samples // size))

    return openturns_probabilities(job, count)


def openturns_sobol(job: Job, randomisations: int) -> Run:
    unstable = openturns_verdicts(job)

    def count(inputs: openturns.JointDistribution, samples: int) -> int:
        size = samples // randomisations
        experiment = openturns.LowDiscrepancyExperiment(openturns.SobolSequence(), inputs, size, True)
        experiment.setRandomize(True)

        def randomised() -> openturns.Sample:
            # Starts at the first point again, with another shift.
            experiment.setDistribution(inputs)
            return experiment.generate()

        return sum(unstable(randomised()) for _ in range(randomisations))

    return openturns_probabilities(job, count)


def quadrature(job: Job) -> np.ndarray:
    """The probability that preload (f_s - f_c) exceeds its critical value, by Gauss and Legendre over the preload."""
    nodes, weights = np.polynomial.legendre.leggauss(400)
    root = math.sqrt(2.0)

    def probability(preload: float, static_friction: float) -> float:
        std_preload, std_static_friction = job.relative_std * preload, job.relative_std * static_friction
        # From no preload, below which every sample is stable, to ten standard deviations above the expected one.
        end = preload + 10.0 * std_preload
        preloads = 0.5 * end * (nodes + 1.0)
        density = np.exp(-0.5 * ((preloads - preload) / std_preload) ** 2) / (std_preload * math.sqrt(2.0 * math.pi))
        boundary = KINETIC_FRICTION + job.critical_product() / preloads
        beyond = [0.5 * math.erfc((at - static_friction) / (std_static_friction * root)) for at in boundary.tolist()]
        return float(0.5 * end * np.sum(weights * density * beyond))

    return np.array([probability(*cell) for cell in job.cells()])


def read_job() -> Job:
    with tempfile.TemporaryDirectory() as directory:
        path = Path(directory) / "job.toml"
        path.write_text(JOB, encoding="utf-8")
        return Job.read(path)


def exact_probabilities(binary: Path, job: Job) -> np.ndarray:
    run = stickslip(binary, job, 'method = "exact"')
    rounds = [run(0, 0) for _ in range(ROUNDS)]
    exact = rounds[0][1]
    figure("stickslip exact", float(np.median([seconds for seconds, _ in rounds])), f"s for {len(exact)} cells")
    difference = float(np.abs(exact - quadrature(job)).max())
    print(f"{'largest difference from a quadrature here':<58} {difference:>16.1e}")
    if not difference <= LARGEST_QUADRATURE_DIFFERENCE:
        sys.exit("the exact probabilities are not those of the quadrature")
    return exact


def compare(kind: str, target: float, exact: np.ndarray, pairs: list[tuple[Method, Method]]) -> None:
    """Prints for one kind of sampling how long the programs take to the target, and the ratio of each pair."""
    print(f"{kind}, rms error of at most {target:g}:", flush=True)
    methods = [method for pair in pairs for method in pair]
    for method in methods:
        method.climb(exact, target)
    for seed in range(1, ROUNDS + 1):
        for method in methods:
            method.take_turn(seed)
    for method in methods:
        step = method.steps[-1]
        unit = f"s, {step.samples} samples/cell, error {step.error:.2e}"
        figure(f"  {method.name}", float(np.median(step.seconds)), unit)
    for ours, theirs in pairs:
        as_run = theirs.seconds() / ours.seconds()
        figure(f"  {theirs.name} over {ours.name}, as run", float(np.median(as_run)), "times")
        at_target = theirs.seconds_at(target) / ours.seconds_at(target)
        figure(f"  {theirs.name} over {ours.name}, at the target", float(np.median(at_target)), "times")


def check_monte_carlo(exact: np.ndarray, methods: list[Method]) -> None:
    """Compares the errors with the known variance of independent samples."""
    for method in methods:
        step = method.steps[-1]
        mean_square = step.error**2 / float(np.mean(exact * (1.0 - exact)) / step.samples)
        figure(f"  squared error of {method.name} over p (1 - p) / n", mean_square, "(1 expected)")
        if not 1.0 / LARGEST_MEAN_SQUARE <= mean_square <= LARGEST_MEAN_SQUARE:
            sys.exit(f"the error of {method.name} is not that of independent samples")


def main() -> None:
    if len(sys.argv) != 2:
        sys.exit("usage: python benches/peers_methods.py path/to/stickslip")
    binary = Path(sys.argv[1]).resolve()
    if not binary.is_file():
        sys.exit(f"there is no program {binary}")
    openturns.TBB.SetThreadsNumber(1)
    job = read_job()
    exact = exact_probabilities(binary, job)

    ours = Method("stickslip", stickslip(binary, job, MONTE_CARLO))
    theirs = Method("OpenTURNS", openturns_monte_carlo(job))
    compare("Monte Carlo", 1e-3, exact, [(ours, theirs)])
    check_monte_carlo(exact, [ours, theirs])

    for target in [1e-3, 1e-4]:
        pairs = [
            (
                Method(f"stickslip x {our_number}", stickslip(binary, job, SOBOL + f"randomisations = {our_number}")),
                Method(f"OpenTURNS x {their_number}", openturns_sobol(job, their_number)),
            )
            for our_number, their_number in [(16, 16), (2, 1)]
        ]
        compare("quasi-Monte Carlo", target, exact, pairs)


if __name__ == "__main__":
    main()
