"""`make bench-peers`: rare events by stickslip, OpenTURNS and UQpy, as work at equal error.

    python benches/peers_rare_events.py path/to/stickslip path/to/python-with-UQpy

Without kinetic friction a brake is unstable if a product of powers of its parameters exceeds a critical value. With
lognormal inputs its logarithm is a normal sum, and the probability the tail of a normal distribution. The expected preload
is chosen so that it is 1e-3, 1e-6 and 1e-9, with two random inputs and with ten.

The peers get the same event as a linear limit state in independent standard normal deviates, `beta - direction . u`, and
its values and gradients. stickslip gets the brake:

- *by verdicts*: samples are counted by verdicts. This applies to two inputs, and to ten with
  `outside_physics = "failed"`, which changes nothing else here, since all inputs are positive. `importance` looks for design
  points by the values of the limit state, whose gradients are differences; each value counts. `subset` sees verdicts alone.
- *by integrals*: as `importance` does by itself with `kind = "eigenvalue"` and more than two inputs, it integrates over
  preload and friction at every sample. An integral counts as one evaluation and takes some twenty microseconds.

With two inputs `method = "exact"` would need no samples at all; they are here for the comparison. Subset simulation has 16
populations of 300 particles here and not of 1000, its default, which takes ten seconds a run with ten inputs.

The peers' settings are their defaults, or better ones where this limit state allows them:

- OpenTURNS, FORM and importance sampling: the design point from the symbolic gradient, each gradient counted as one
  evaluation, and a normal density around it. A linear limit state in standard normal deviates is its ideal case: it finds
  the one design point in a few steps. A region that has no design point of its own, such as the second of two branches, is
  outside its view.
- OpenTURNS, directional sampling: independent directions, with the root strategy that evaluates the far end and looks for
  a root only if the sign differs there ("risky and fast"). For a half-space it is right; the default takes some six times
  as many evaluations.
- OpenTURNS and UQpy, subset sampling: a tenth of the samples is kept in each level.

Of SEEDS runs each, for every case and method: the mean of the probabilities over the true one, the relative
root-mean-square error, the mean number of evaluations, those that an error of 5 % takes, how many of the 95 % intervals
contain the truth, and the median of the seconds. stickslip gives no number where it does not trust it; such runs are
counted, and their evaluations are added to those of the others. "At an error of 5 %" scales evaluations by the square of
the error. That holds for the sampling part only, so what is spent on finding the region (stickslip's search before
importance sampling, FORM) stays as it is. An error of SEEDS runs is itself uncertain by a sixth, its square by a third.
The ratios are those numbers of peers over stickslip: above 1, stickslip needs less.

Seconds are those of the whole process for stickslip, and of the computation alone for the peers, whose limit state costs
nothing. Each figure is a line with name, value and unit.

A program whose mean is farther from the truth than LARGEST_Z of its standard errors, or which gives fewer numbers than
FEWEST_NUMBERS, has a line that says so, and no number at an error of 5 %. UQpy has none anyway. The chains of its version here go on from samples
outside of the level, which it has just rejected, so that those it keeps lie too close to the border of the level.
Probabilities come out too small, the more so the rarer the event, with 10 000 samples a level as with 1000, and with the
stretch sampler as with modified Metropolis. No number of samples leads to an error of 5 %, so its figures are printed
without that number and without ratios.
"""

import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import openturns
import pyarrow.parquet

from peers import Job, figure

SEEDS = range(1, 21)
PROBABILITIES = [1e-3, 1e-6, 1e-9]
TARGET = 0.05
# Student's t of 19 degrees of freedom is beyond it once in 100 000 times.
LARGEST_Z = 6.0
FEWEST_NUMBERS = 10

ROTATING_SPEED = 15.0
STATIC_FRICTION = 0.4
# Random inputs, each with its relative standard deviation and the power to which the driving over the damping depends on
# it; the ten of tests/common/ten_inputs.rs.
TEN = [
    ("preload", 0.2, 1.0),
    ("static_friction", 0.1, 1.0),
    ("damping.tangential", 0.1, -1.0),
    ("stiffness.contact_tangential_1", 0.05, -1.0),
    ("stiffness.contact_tangential_2", 0.08, 1.0),
    ("disc.thickness", 0.02, 1.0),
    ("pad.mass", 0.1, 0.0),
    ("pad.moment_of_inertia", 0.1, 0.0),
    ("damping.normal", 0.2, 0.0),
    ("stiffness.calliper_angular", 0.1, 0.0),
]

JOB = """
name = "rare"
model.preset = "sui-ding-2018"
model.friction.kinetic_coefficient = 0.0
axes = {{ rotating_speed = {speed!r}, preload = {preload!r}, static_friction = {static_friction!r} }}

[random]
inputs = [{inputs}]
relative_std = {{ {stds} }}
distribution = "lognormal"

[criterion]
kind = "eigenvalue"
outside_physics = "{outside_physics}"

[sampling]
seed = {seed}
{sampling}
"""
IMPORTANCE = 'method = "importance"\nsamples = 1024'
SUBSET = 'method = "subset"\nparticles = 300'
DESIGN_POINT_SAMPLES = 4096
DIRECTIONS = 50_000
OPENTURNS_LEVEL = 20_000
# UQpy's own default; a larger one takes minutes for each run.
UQPY_LEVEL = 1000
BLOCK = 64


@dataclass
class Run:
    """What one run of a method gives."""

    # None if the program gives no number.
    probability: float | None
    # Evaluations that find the region, and those whose number decides the error.
    finding: int
    sampling: int
    seconds: float
    # The interval of 95 %, if the program gives one.
    interval: tuple[float, float] | None = None


@dataclass
class Case:
    """A brake whose probability of instability is known."""

    inputs: list[tuple[str, float, float]]
    probability: float

    def logarithms(self) -> np.ndarray:
        """The standard deviations of the logarithms in the sum, with their signs."""
        return np.array([power * math.sqrt(math.log1p(std**2)) for _, std, power in self.inputs])

    def direction(self) -> list[float]:
        logarithms = self.logarithms()
        return (logarithms / np.linalg.norm(logarithms)).tolist()

    def beta(self) -> float:
        """The distance of the boundary, in standard normal deviates."""
        return -openturns.Normal().computeQuantile(self.probability)[0]

    def preload(self) -> float:
        """The expected preload with which the brake has this probability."""
        job = Job(ROTATING_SPEED, 0.0, np.empty(0), np.empty(0))
        mean = sum(-0.5 * power * math.log1p(std**2) for _, std, power in self.inputs)
        below = self.beta() * float(np.linalg.norm(self.logarithms()))
        return job.critical_product() / STATIC_FRICTION * math.exp(-mean - below)

    def job(self, sampling: str, outside_physics: str, seed: int) -> str:
        return JOB.format(
            speed=ROTATING_SPEED,
            preload=self.preload(),
            static_friction=STATIC_FRICTION,
            inputs=", ".join(f'"{name}"' for name, _, _ in self.inputs),
            stds=", ".join(f'"{name}" = {std}' for name, std, _ in self.inputs),
            outside_physics=outside_physics,
            seed=seed,
            sampling=sampling,
        )


@dataclass
class Method:
    """A method of one of the programs, with its runs of a case."""

    name: str
    run: Callable[[Case], list[Run]]
    # Whether its errors fall with the number of samples, so that it has to agree with the truth.
    is_unbiased: bool = True

    def measure(self, case: Case) -> "Measured":
        return Measured(self, case, self.run(case))


@dataclass
class Measured:
    """The runs of a method, compared with the truth."""

    method: Method
    case: Case
    runs: list[Run]

    def ratios(self) -> np.ndarray:
        """Probabilities over the true one, of the runs that gave a number."""
        return np.array([run.probability for run in self.runs if run.probability is not None]) / self.case.probability

    def error(self) -> float:
        return float(np.sqrt(np.mean((self.ratios() - 1.0) ** 2)))

    def z(self) -> float:
        ratios = self.ratios()
        return float((ratios.mean() - 1.0) / (ratios.std(ddof=1) / math.sqrt(len(ratios))))

    def agrees(self) -> bool:
        return len(self.ratios()) >= FEWEST_NUMBERS and abs(self.z()) <= LARGEST_Z

    def has_target(self) -> bool:
        return self.method.is_unbiased and self.agrees()

    def evaluations(self) -> float:
        """For each number that the runs gave."""
        return sum(run.finding + run.sampling for run in self.runs) / len(self.ratios())

    def evaluations_at_target(self) -> float:
        finding, sampling = (sum(each) for each in zip(*[(run.finding, run.sampling) for run in self.runs], strict=True))
        return (finding + sampling * (self.error() / TARGET) ** 2) / len(self.ratios())

    def report(self) -> None:
        name = f"  {self.method.name}"
        without = len(self.runs) - len(self.ratios())
        if without:
            figure(f"{name}, without a number", float(without), f"of {len(self.runs)} runs")
        if without == len(self.runs):
            return
        if self.method.is_unbiased and not self.agrees():
            print(f"{name} does not agree with the truth: {self.ratios()}", flush=True)
        figure(f"{name}, P over the true one", float(self.ratios().mean()), f"(z = {self.z():.1f})")
        figure(f"{name}, relative error", self.error(), "rms")
        figure(f"{name}, evaluations", self.evaluations(), "a number")
        if self.has_target():
            figure(f"{name}, at 5 % error", self.evaluations_at_target(), "evaluations")
        intervals = [run.interval for run in self.runs if run.interval is not None and run.probability is not None]
        if intervals:
            covered = sum(low <= self.case.probability <= high for low, high in intervals)
            figure(f"{name}, coverage", covered / len(intervals), f"of {len(intervals)} intervals")
        figure(f"{name}, time", float(np.median([run.seconds for run in self.runs])), "s a run")


def stickslip(binary: Path, sampling: str, outside_physics: str) -> Callable[[Case], list[Run]]:
    """The whole process on one thread, into a fresh run directory."""

    def run(case: Case, seed: int) -> Run:
        with tempfile.TemporaryDirectory() as directory:
            job_file, out = Path(directory) / "job.toml", Path(directory) / "run"
            job_file.write_text(case.job(sampling, outside_physics, seed), encoding="utf-8")
            command = [binary, "submit", job_file, "--out", out, "--threads", "1"]
            started = time.perf_counter()
            done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
            seconds = time.perf_counter() - started
            if done.returncode != 0:
                print(f"  stickslip failed with exit code {done.returncode}: {done.stderr.strip()}", flush=True)
                return Run(None, 0, 0, seconds)
            [row] = pyarrow.parquet.read_table(out / "surface.parquet").to_pylist()
        evaluations = int(row["n_evaluations"])
        # Of subset simulation all evaluations make the estimate.
        samples = int(row["n_samples"]) if sampling == IMPORTANCE else evaluations
        return Run(row["p_unstable"], evaluations - samples, samples, seconds, (row["p_low"], row["p_high"]))

    return lambda case: [run(case, seed) for seed in SEEDS]


# From the limit state, the event and the deviates to the algorithm, and the evaluations that it took to set it up.
Setup = Callable[
    [openturns.Function, openturns.ThresholdEvent, openturns.Normal], tuple[openturns.EventSimulation, int]
]


def openturns_runs(setup: Setup) -> Callable[[Case], list[Run]]:
    """Runs an algorithm of OpenTURNS on the limit state of a case, with a new limit state for each run.

    The runs follow one another in one stream of random numbers. With a seed for each, 1 to 20, the mean of directional
    sampling was five standard errors from the truth, with seeds far apart it was not.
    """

    def run(case: Case) -> Run:
        names = [f"u{i}" for i in range(len(case.inputs))]
        terms = [f"({factor!r}) * {name}" for factor, name in zip(case.direction(), names, strict=True)]
        started = time.perf_counter()
        limit_state = openturns.SymbolicFunction(names, [f"{case.beta()!r} - ({' + '.join(terms)})"])
        deviates = openturns.Normal(len(names))
        values = openturns.CompositeRandomVector(limit_state, openturns.RandomVector(deviates))
        event = openturns.ThresholdEvent(values, openturns.Less(), 0.0)
        algorithm, finding = setup(limit_state, event, deviates)
        # The number of samples is given, not an error at which to stop.
        algorithm.setMaximumCoefficientOfVariation(-1.0)
        algorithm.run()
        seconds = time.perf_counter() - started
        result = algorithm.getResult()
        probability, half = result.getProbabilityEstimate(), 0.5 * result.getConfidenceLength(0.95)
        sampling = calls(limit_state) - finding
        return Run(probability, finding, sampling, seconds, (probability - half, probability + half))

    def runs(case: Case) -> list[Run]:
        openturns.RandomGenerator.SetSeed(SEEDS[0])
        return [run(case) for _ in SEEDS]

    return runs


def calls(limit_state: openturns.Function) -> int:
    return limit_state.getEvaluationCallsNumber() + limit_state.getGradientCallsNumber()


def design_point(
    limit_state: openturns.Function, event: openturns.ThresholdEvent, deviates: openturns.Normal
) -> tuple[openturns.EventSimulation, int]:
    search = openturns.AbdoRackwitz()
    search.setStartingPoint(deviates.getMean())
    form = openturns.FORM(search, event)
    form.run()
    point = form.getResult().getStandardSpaceDesignPoint()
    around = openturns.Normal(point, openturns.CovarianceMatrix(len(point)))
    algorithm = openturns.ProbabilitySimulationAlgorithm(event, openturns.ImportanceSamplingExperiment(around))
    algorithm.setBlockSize(BLOCK)
    algorithm.setMaximumOuterSampling(DESIGN_POINT_SAMPLES // BLOCK)
    return algorithm, calls(limit_state)


def directional(
    _limit_state: openturns.Function, event: openturns.ThresholdEvent, _deviates: openturns.Normal
) -> tuple[openturns.EventSimulation, int]:
    root = openturns.RootStrategy(openturns.RiskyAndFast())
    directions = openturns.SamplingStrategy(openturns.RandomDirection())
    algorithm = openturns.DirectionalSampling(event, root, directions)
    algorithm.setBlockSize(1)
    algorithm.setMaximumOuterSampling(DIRECTIONS)
    return algorithm, 0


def subset(
    _limit_state: openturns.Function, event: openturns.ThresholdEvent, _deviates: openturns.Normal
) -> tuple[openturns.EventSimulation, int]:
    algorithm = openturns.SubsetSampling(event)
    algorithm.setBlockSize(BLOCK)
    algorithm.setMaximumOuterSampling(OPENTURNS_LEVEL // BLOCK)
    return algorithm, 0


def uqpy(python: Path) -> Callable[[Case], list[Run]]:
    """All seeds in one process, in the environment of UQpy."""

    def runs(case: Case) -> list[Run]:
        task = {"direction": case.direction(), "beta": case.beta(), "samples": UQPY_LEVEL, "seeds": list(SEEDS)}
        command = [python, Path(__file__).with_name("peers_uqpy.py"), json.dumps(task)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            print(f"  UQpy failed with exit code {done.returncode}: {done.stderr.strip()}", flush=True)
            return []
        return [Run(run["probability"], 0, run["evaluations"], run["seconds"]) for run in json.loads(done.stdout)]

    return runs


def compare(case: Case, ours: list[Method], theirs: list[Method]) -> None:
    """Prints the figures of one case."""
    print(f"{len(case.inputs)} random inputs, P = {case.probability:g}:", flush=True)
    measured = {}
    for method in ours + theirs:
        measured[method.name] = method.measure(case)
        measured[method.name].report()
    for our_method in ours:
        for their_method in theirs:
            our, their = measured[our_method.name], measured[their_method.name]
            if our.has_target() and their.has_target():
                ratio = their.evaluations_at_target() / our.evaluations_at_target()
                figure(f"  {their_method.name} over {our_method.name}", ratio, "times")


def main() -> None:
    if len(sys.argv) != 3:
        sys.exit("usage: python benches/peers_rare_events.py path/to/stickslip path/to/python-with-UQpy")
    # Not resolved: the Python of an environment is a link, and knows its packages by the link's place.
    binary, python = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).absolute()
    for program in [binary, python]:
        if not program.is_file():
            sys.exit(f"there is no program {program}")
    openturns.TBB.SetThreadsNumber(1)
    openturns.Log.Show(openturns.Log.NONE)

    by_verdicts = [
        Method("stickslip importance, verdicts", stickslip(binary, IMPORTANCE, "failed")),
        Method("stickslip subset, verdicts", stickslip(binary, SUBSET, "failed")),
    ]
    by_integrals = [Method("stickslip importance, integrals", stickslip(binary, IMPORTANCE, "stable"))]
    peers = [
        Method("OpenTURNS FORM + importance", openturns_runs(design_point)),
        Method("OpenTURNS directional", openturns_runs(directional)),
        Method("OpenTURNS subset", openturns_runs(subset)),
        Method("UQpy subset", uqpy(python), is_unbiased=False),
    ]

    for inputs, ours in [(TEN[:2], by_verdicts), (TEN, by_verdicts + by_integrals)]:
        for probability in PROBABILITIES:
            compare(Case(inputs, probability), ours, peers)


if __name__ == "__main__":
    main()
