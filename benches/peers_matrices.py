"""`make bench-peers`: verdicts on models given by matrices by stickslip, NumPy and SciPy, side by side.

    python benches/peers_matrices.py path/to/stickslip

Four models of the form M q'' + C(p) q' + K(p) q = 0, the first three with a share of unstable samples near one half:

- two masses coupled by friction (Hoffmann and others 2002), friction random;
- 10 coordinates with a random structure and a random nonsymmetric coupling, friction, damping and stiffness random;
- the brake of TU Berlin (jobs/tu-brake) projected on 100 vectors, pairs from 1 to 3 kHz, friction, stiffness, lining damping
  and speed random;
- the brake of jobs/own-brake.toml, reduced by stickslip to 120 vectors, pairs in three bands from 1 to 12 kHz, friction, stiffness
  of lining and contact and lining damping random, one in ten unstable: stickslip answers for each band and for any, the peers
  for any.

What is asked is whether a pair in the band has a damping ratio below 0. The peers find all eigenvalues of the state matrix:

- numpy.linalg.eigvals, in batches for 2 and 10 coordinates, sample by sample for the brake;
- *the loop* that one writes with MATLAB: scipy.linalg.eig of the pencil, with eigenvectors, sample by sample.

All of them run on one thread, OpenBLAS too, and with the instructions that it chooses by itself: the variable
OPENBLAS_CORETYPE is taken away. Rates of stickslip are samples over the seconds of `run.json`, which has reading, measuring
and writing in it; times of the peers are those of assembly, eigenvalues and verdict, without drawing and loading. Each figure
is a line with name, value and unit: medians over the rounds, ratios within one round. The shares of unstable samples are compared;
a disagreement ends the program with exit code 1.
"""

import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

# OpenBLAS reads these when NumPy is loaded.
os.environ.pop("OPENBLAS_CORETYPE", None)
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

import numpy as np  # noqa: E402
import pyarrow.parquet  # noqa: E402
import scipy.io  # noqa: E402
import scipy.linalg  # noqa: E402
import scipy.sparse  # noqa: E402
import scipy.sparse.linalg  # noqa: E402

JOBS = Path(__file__).resolve().parent.parent / "jobs"
BRAKE = JOBS / "tu-brake" / "tu-brake.mat"
ROUNDS = 3
VECTORS = 100
LARGEST_Z = 5.0
HERTZ = 2.0 * math.pi

Parameters = dict[str, np.ndarray]


@dataclass
class Term:
    """A matrix and its factor: a text as in a job, and the same as a function of the parameters."""

    matrix: np.ndarray
    factor: str
    value: Callable[[Parameters], np.ndarray]


@dataclass
class Model:
    name: str
    mass: np.ndarray
    damping: list[Term]
    stiffness: list[Term]
    expected: dict[str, float]
    relative_std: dict[str, float]
    # In hertz.
    band: tuple[float, float]
    # Samples of stickslip, of NumPy and of the loop in one round.
    samples: tuple[int, int, int]
    # Samples in one call of NumPy.
    batch: int
    # In hertz: the band in parts that are counted each, after all of them.
    bands: tuple[tuple[float, float], ...] = ()

    def draw(self, count: int, seed: int) -> Parameters:
        random = np.random.default_rng(seed)
        deviates = {key: random.standard_normal(count) for key in self.relative_std}
        return {
            key: value * (1.0 + self.relative_std[key] * deviates[key]) if key in deviates else np.full(count, value)
            for key, value in self.expected.items()
        }

    def assembled(self, terms: list[Term], parameters: Parameters) -> np.ndarray:
        """A matrix a sample."""
        total = np.zeros((len(next(iter(parameters.values()))), *self.mass.shape))
        for term in terms:
            total += np.asarray(term.value(parameters))[..., None, None] * term.matrix
        return total

    @cached_property
    def inverse_mass(self) -> np.ndarray:
        return np.linalg.inv(self.mass)

    @cached_property
    def time_scale(self) -> float:
        """The geometric mean of the lowest and the highest angular frequency."""
        singular = np.linalg.svd(self.inverse_mass @ self.assembled(self.stiffness, at(self.expected))[0])[1]
        return float((singular[0] * singular[-1]) ** 0.25)

    def in_band(self, eigenvalues: np.ndarray) -> np.ndarray:
        frequency = np.abs(eigenvalues.imag) / HERTZ
        return (frequency >= self.band[0]) & (frequency <= self.band[1])

    def is_unstable(self, eigenvalues: np.ndarray) -> np.ndarray:
        # An undamped pair has a real part of either sign within rounding.
        growing = eigenvalues.real > 1e-10 * np.abs(eigenvalues)
        return (growing & self.in_band(eigenvalues)).any(axis=-1)

    def numpy_unstable(self, parameters: Parameters) -> int:
        """By numpy.linalg.eigvals of the state matrix, in time scaled to the stiffness."""
        count, n = len(next(iter(parameters.values()))), len(self.mass)
        inverse, scale, unstable = self.inverse_mass, self.time_scale, 0
        for start in range(0, count, self.batch):
            part = {key: value[start : start + self.batch] for key, value in parameters.items()}
            k = inverse @ self.assembled(self.stiffness, part)
            state = np.zeros((len(k), 2 * n, 2 * n))
            state[:, :n, n:] = np.eye(n)
            state[:, n:, :n] = -k / scale**2
            if self.damping:
                state[:, n:, n:] = -(inverse @ self.assembled(self.damping, part)) / scale
            unstable += int(self.is_unstable(np.linalg.eigvals(state) * scale).sum())
        return unstable

    def loop_unstable(self, parameters: Parameters) -> int:
        """By scipy.linalg.eig of the pencil, sample by sample, as a user's script does."""
        n, unstable = len(self.mass), 0
        right = scipy.linalg.block_diag(np.eye(n), self.mass)
        for i in range(len(next(iter(parameters.values())))):
            one = {key: value[i : i + 1] for key, value in parameters.items()}
            k, c = self.assembled(self.stiffness, one)[0], self.assembled(self.damping, one)[0]
            left = np.block([[np.zeros((n, n)), np.eye(n)], [-k, -c]])
            eigenvalues, _ = scipy.linalg.eig(left, right)
            unstable += int(self.is_unstable(eigenvalues))
        return unstable

    def job(self, folder: Path, seed: int) -> Path:
        """The same as a job, its matrices in an .npz file beside it."""
        matrices = {"M": self.mass}
        lines: dict[str, list[str]] = {"damping": [], "stiffness": []}
        for kind, terms in (("damping", self.damping), ("stiffness", self.stiffness)):
            for i, term in enumerate(terms):
                key = f"{kind}_{i}"
                matrices[key] = term.matrix
                factor = f', factor = "{term.factor}"' if term.factor else ""
                lines[kind].append(f'    {{ file = "model.npz", matrix = "{key}"{factor} }},\n')
        np.savez(folder / "model.npz", **matrices)
        text = 'name = "peers"\n[model]\nkind = "matrices"\nmass = { file = "model.npz", matrix = "M" }\n'
        text += "".join(f"{kind} = [\n{''.join(terms)}]\n" for kind, terms in lines.items() if terms)
        text += "[model.parameters]\n" + "".join(f"{key} = {value!r}\n" for key, value in self.expected.items())
        text += f"[random]\ninputs = {json.dumps(list(self.relative_std))}\n"
        text += (
            "relative_std = { " + ", ".join(f"{key} = {value!r}" for key, value in self.relative_std.items()) + " }\n"
        )
        text += '[criterion]\nkind = "complex-eigenvalue"\n'
        if self.bands:
            text += f"bands = {json.dumps(self.bands)}\n"
        elif self.band[1] < math.inf:
            text += f"frequency = [{self.band[0]!r}, {self.band[1]!r}]\n"
        text += f"damping_ratio = 0.0\n[sampling]\nsamples = {self.samples[0]}\nseed = {seed}\n"
        path = folder / "job.toml"
        path.write_text(text)
        return path


def constant(parameters: Parameters) -> np.ndarray:
    return np.ones(len(next(iter(parameters.values()))))


def two_masses() -> Model:
    return Model(
        "2 coordinates",
        np.eye(2),
        [],
        [
            Term(np.array([[2.0, 1.0], [1.0, 2.0]]), "", constant),
            Term(np.array([[0.0, -4.0 / 3.0], [0.0, 0.0]]), "friction", lambda p: p["friction"]),
        ],
        {"friction": 0.75},
        {"friction": 0.1},
        (0.0, math.inf),
        (50_000_000, 200_000, 2_000),
        10_000,
    )


def critical(model: Model, name: str, low: float, high: float) -> float:
    """The value of a parameter at which the expected model becomes unstable."""
    for _ in range(40):
        middle = 0.5 * (low + high)
        model.expected[name] = middle
        low, high = (low, middle) if model.numpy_unstable(at(model.expected)) else (middle, high)
    return high


def at(values: dict[str, float]) -> Parameters:
    return {key: np.array([value]) for key, value in values.items()}


def ten_coordinates() -> Model:
    random = np.random.default_rng(7)
    q = np.linalg.qr(random.standard_normal((10, 10)))[0]
    k = q @ np.diag((HERTZ * np.linspace(200.0, 2000.0, 10)) ** 2) @ q.T
    coupling = random.standard_normal((10, 10)) * np.linalg.norm(k, 2) / 20.0
    model = Model(
        "10 coordinates",
        np.eye(10),
        [Term(k * 1e-6 + 5.0 * np.eye(10), "damping", lambda p: p["damping"])],
        [
            Term(k, "stiffness", lambda p: p["stiffness"]),
            Term(coupling, "friction", lambda p: p["friction"]),
        ],
        {"friction": 0.5, "damping": 1.0, "stiffness": 1.0},
        {"friction": 0.1, "damping": 0.1, "stiffness": 0.02},
        (0.0, math.inf),
        (1_000_000, 20_000, 1_000),
        1_000,
    )
    model.expected["friction"] = critical(model, "friction", 0.0, 10.0)
    return model


def reduced_brake() -> Model:
    """Real modes, and the answers of the brake to the friction that they cause, from both sides."""
    if not BRAKE.exists():
        sys.exit(f"{BRAKE} is missing")
    data = {key: value.tocsc() for key, value in scipy.io.loadmat(BRAKE).items() if key[0] != "_"}
    symmetric = (data["K1"] + data["K1"].T) / 2.0
    _, modes = scipy.sparse.linalg.eigsh(symmetric, 60, data["M"], sigma=-1e4)
    lu = scipy.sparse.linalg.splu((symmetric + 1e4 * data["M"]).tocsc())
    answers = [lu.solve(part @ modes) for part in (data["KR"], data["KR"].T)]
    rest = np.hstack(answers)
    rest -= modes @ (modes.T @ (data["M"] @ rest))
    rest = np.linalg.svd(rest / np.linalg.norm(rest, axis=0), full_matrices=False)[0]
    basis = np.linalg.qr(np.hstack([modes, rest])[:, :VECTORS])[0]
    small = {key: basis.T @ (matrix @ basis) for key, matrix in data.items()}
    small["M"] = (small["M"] + small["M"].T) / 2.0
    model = Model(
        f"TU brake, {VECTORS} coordinates",
        small["M"],
        [
            Term(small["D1"], "", constant),
            Term(small["DR"], "1 / speed", lambda p: 1.0 / p["speed"]),
            Term(small["DG"], "speed", lambda p: p["speed"]),
            Term(small["D4"], "lining_damping", lambda p: p["lining_damping"]),
        ],
        [
            Term(small["K1"], "stiffness", lambda p: p["stiffness"]),
            Term(small["KR"], "friction", lambda p: p["friction"]),
            Term(small["KGEO"], "speed^2", lambda p: p["speed"] ** 2),
        ],
        {"friction": 1.9, "stiffness": 1.0, "lining_damping": 6.25e-4, "speed": 2.0 * HERTZ},
        {"friction": 0.1, "stiffness": 0.02, "lining_damping": 0.2, "speed": 0.1},
        (1000.0, 3000.0),
        (10_000, 100, 30),
        1,
    )
    model.expected["friction"] = critical(model, "friction", 0.5, 5.0)
    return model


def own_brake(binary: Path) -> Model:
    """The brake of a shipped job, reduced as its users do."""
    with tempfile.TemporaryDirectory() as directory:
        out = Path(directory) / "small.toml"
        command = [binary, "reduce", JOBS / "own-brake.toml", "--vectors", "120", "--out", out]
        subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
        stored = {key: value for key, value in scipy.io.loadmat(out.with_suffix(".mat")).items() if key[0] != "_"}
    data = {key: value.toarray() if scipy.sparse.issparse(value) else value for key, value in stored.items()}
    return Model(
        f"own brake, {len(data['M'])} coordinates",
        data["M"],
        [
            Term(data["C1"], "20", lambda p: np.full(len(p["friction"]), 20.0)),
            Term(data["C2"], "1e-6", lambda p: np.full(len(p["friction"]), 1e-6)),
            Term(data["C3"], "lining_damping * lining_modulus", lambda p: p["lining_damping"] * p["lining_modulus"]),
        ],
        [
            Term(data["K1"], "", constant),
            Term(data["K2"], "lining_modulus", lambda p: p["lining_modulus"]),
            Term(data["K3"], "contact_stiffness", lambda p: p["contact_stiffness"]),
            Term(data["K4"], "friction * contact_stiffness", lambda p: p["friction"] * p["contact_stiffness"]),
        ],
        {"friction": 0.45, "lining_modulus": 8e9, "contact_stiffness": 5e12, "lining_damping": 1e-6},
        {"friction": 0.1, "lining_modulus": 0.1, "contact_stiffness": 0.1, "lining_damping": 0.2},
        (1000.0, 12_000.0),
        (10_000, 300, 30),
        1,
        bands=((1000.0, 8000.0), (8000.0, 10_000.0), (10_000.0, 12_000.0)),
    )


def stickslip(binary: Path, model: Model, seed: int) -> tuple[float, int] | None:
    """Samples a second, as run.json has them, and unstable samples; None where this version does not know the model."""
    with tempfile.TemporaryDirectory() as directory:
        out = Path(directory) / "run"
        command = [binary, "submit", model.job(Path(directory), seed), "--out", out, "--threads", "1"]
        done = subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
        if done.returncode == 65:
            if seed == 1:
                print(f"{model.name}: stickslip does not take this job:\n{done.stderr}", file=sys.stderr)
            return None
        if done.returncode != 0:
            sys.exit(f"stickslip failed with exit code {done.returncode}:\n{done.stderr}")
        session = json.loads((out / "run.json").read_text())["sessions"][-1]
        # All bands together are the first cell.
        unstable = pyarrow.parquet.read_table(out / "surface.parquet")["n_unstable"].to_numpy()[0]
        return model.samples[0] / session["seconds"], int(unstable)


def figure(name: str, value: float, unit: str) -> None:
    text = f"{value:.3g}" if value < 1e-2 else f"{value:.3f}" if value < 1000.0 else f"{value:.0f}"
    print(f"{name:<66} {text:>12} {unit}", flush=True)


def timed(count: Callable[[Parameters], int], parameters: Parameters) -> tuple[float, int]:
    started = time.perf_counter()
    unstable = count(parameters)
    return len(next(iter(parameters.values()))) / (time.perf_counter() - started), unstable


def compare(binary: Path, model: Model) -> bool:
    """Prints the figures of a model. False if the shares of unstable samples disagree."""
    rates: dict[str, list[float]] = {}
    counts: dict[str, list[int]] = {}
    sizes = dict(zip(("stickslip", "numpy.linalg.eigvals", "a loop with scipy.linalg.eig"), model.samples, strict=True))
    for seed in range(1, ROUNDS + 1):
        found = {
            "stickslip": stickslip(binary, model, seed),
            "numpy.linalg.eigvals": timed(model.numpy_unstable, model.draw(model.samples[1], seed)),
            "a loop with scipy.linalg.eig": timed(model.loop_unstable, model.draw(model.samples[2], seed)),
        }
        for name, result in found.items():
            if result is not None:
                rates.setdefault(name, []).append(result[0])
                counts.setdefault(name, []).append(result[1])
    for name, values in rates.items():
        figure(f"{model.name}: {name}, one thread", float(np.median(values)), "samples/s")
    for name, values in rates.items():
        if name != "stickslip" and "stickslip" in rates:
            ratio = float(np.median(np.array(rates["stickslip"]) / np.array(values)))
            figure(f"{model.name}: stickslip over {name}", ratio, "times")
    shares = {name: sum(values) / (ROUNDS * sizes[name]) for name, values in counts.items()}
    for name, share in shares.items():
        figure(f"{model.name}: {name}, unstable", share, "")
    first = next(iter(shares))
    agree = True
    for name, share in shares.items():
        error = math.sqrt(max(share * (1.0 - share), 1e-3) * (1.0 / sizes[name] + 1.0 / sizes[first]) / ROUNDS)
        if abs(share - shares[first]) > LARGEST_Z * error:
            print(f"{first} and {name} disagree", file=sys.stderr)
            agree = False
    return agree


def main() -> None:
    binary = Path(sys.argv[1]).resolve()
    models = (two_masses, ten_coordinates, reduced_brake, lambda: own_brake(binary))
    agree = [compare(binary, make()) for make in models]
    if not all(agree):
        sys.exit(1)


if __name__ == "__main__":
    main()
