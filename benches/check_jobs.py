"""Random jobs of every model, criterion and method: how long `check` takes, and how well it predicts `submit`.

Usage: python3 benches/check_jobs.py PROGRAM [--jobs N] [--seed S] [--longest SECONDS] [--seconds SECONDS] [--keep FILE.csv]
       [--picture FILE.svg]

A job that `check` refuses is drawn again, so that N jobs are accepted. Those with a predicted time below the longest are
run. All work is done on one thread, and times are of the clock on the wall: run it on a quiet machine. It needs Python 3.9
and nothing else.
"""

import argparse
import collections
import csv
import json
import math
import random
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple, Optional

LONGEST_CHECK = 10.0
FACTOR = 3.0
# The share of jobs that should be predicted within the factor.
SHARE = 0.95

PAD_INPUTS = [
    "preload",
    "static_friction",
    "friction.kinetic_coefficient",
    "friction.stribeck_velocity",
    "stiffness.contact_normal",
    "damping.tangential",
    "pad.mass",
    "disc.thickness",
    "rotating_speed",
]
STARTS = ["near-equilibrium", "rest", "limit-cycle"]
CRITERIA = [
    "eigenvalue", "coupled-eigenvalue", "rigid", "flexible", "belt-eigenvalue", "belt-time", "matrices", "large-matrices"
]
METHODS = [
    "monte-carlo", "until", "relative", "sobol", "sensitivity", "boundary", "exact", "conditional", "importance", "subset"
]

BELT = """[model]
kind = "belt-oscillator"
mass = 1.0
stiffness = 1.0
damping = 0.1
belt_speed = 1.3
[model.friction]
law = "stribeck"
kinetic_coefficient = 0.25
stribeck_velocity = 1.0
"""


def listed(words: list) -> str:
    return "[" + ", ".join(f'"{word}"' for word in words) + "]"


def spread(chance: random.Random, least: float, most: float, values: int) -> str:
    """An axis with so many values within a range."""
    ends = sorted(round(chance.uniform(least, most), 4) for _ in range(2))
    if values == 1 or ends[0] == ends[1]:
        return f"{ends[0]}"
    return f"{{ from = {ends[0]}, to = {ends[1]}, points = {values} }}"


def pairs_of_masses(chance: random.Random, pairs: list) -> str:
    """Pairs of masses that friction couples, as matrices."""
    size = 2 * chance.choice(pairs)
    matrix = lambda entry: [[float(entry(i, j)) for j in range(size)] for i in range(size)]
    near = lambda i, j: i // 2 == j // 2
    scale = lambda i: 1 + 0.1 * (i // 2)
    mass = matrix(lambda i, j: i == j)
    damping = matrix(lambda i, j: 0.001 * (i == j))
    stiffness = matrix(lambda i, j: near(i, j) * (2 if i == j else 1) * scale(i))
    friction = matrix(lambda i, j: (i % 2 == 0 and j == i + 1) * -4 / 3 * scale(i))
    return (
        f'[model]\nkind = "matrices"\nmass = {{ matrix = {mass} }}\ndamping = {{ matrix = {damping}, factor = "damping" }}\n'
        f'stiffness = [{{ matrix = {stiffness} }}, {{ matrix = {friction}, factor = "friction" }}]\n'
        "[model.parameters]\nfriction = 0.6\ndamping = 1.0\n"
    )


def drawn_job(chance: random.Random) -> tuple:
    """A random job, its criterion and its method."""
    criterion, method = chance.choice(CRITERIA), chance.choice(METHODS)
    values = lambda most: chance.choice([1, 1, 2, most])
    if criterion.startswith("belt"):
        model, record = BELT, []
        all_inputs = ["normal_force", "static_coefficient", "belt_speed", "damping"]
        axes = {"normal_force": spread(chance, 0.2, 2.0, values(6)), "static_coefficient": spread(chance, 0.3, 0.6, values(5))}
        kind = '"eigenvalue"' if criterion == "belt-eigenvalue" else '"time-domain"'
        rest = f'start = "{chance.choice(STARTS[:2])}"\n' if criterion == "belt-time" else ""
    elif criterion.endswith("matrices"):
        # Many coordinates have a series that is set up once, which takes longer than many samples.
        pairs = [15, 30, 60, 100] if criterion == "large-matrices" else [1, 2, 5]
        model, all_inputs, kind = pairs_of_masses(chance, pairs), ["friction", "damping"], '"complex-eigenvalue"'
        axes, rest = {"friction": spread(chance, 0.4, 1.0, values(8))}, ""
    else:
        model, all_inputs = "", PAD_INPUTS
        axes = {
            "rotating_speed": spread(chance, 8.0, 25.0, values(3)),
            "preload": spread(chance, 0.02, 0.3, values(6)),
            "static_friction": spread(chance, 0.27, 0.5, values(5)),
        }
        kind = f'"{criterion}"' if criterion.endswith("eigenvalue") else '"time-domain"'
        rest = ""
        if kind == '"time-domain"':
            disc = "rigid" if criterion == "rigid" else "flexible"
            rest = f'disc = "{disc}"\nstart = "{chance.choice(STARTS)}"\n'
    count = chance.choice([1, 2, 2, 3, len(all_inputs)])
    inputs = all_inputs[:2] if method == "boundary" or chance.random() < 0.4 else chance.sample(all_inputs, min(count, len(all_inputs)))
    samples = int(10 ** chance.uniform(2, 6))
    sampling = {
        "monte-carlo": f"samples = {samples}",
        "until": f"until = {{ half_width = {chance.choice([0.1, 0.03, 0.01])}, at_most = {samples} }}",
        "relative": f"until = {{ relative = {chance.choice([0.3, 0.1])}, at_most = {samples} }}",
        "sobol": f'method = "sobol"\nsamples = {2 ** chance.randint(8, 18)}',
        "sensitivity": f"samples = {samples}\nsensitivity = true",
        "boundary": f'samples = {samples}\nevaluate = "boundary"',
        "exact": 'method = "exact"',
        "conditional": f'method = "conditional"\nsamples = {2 ** chance.randint(8, 16)}',
        "importance": f'method = "importance"\nsamples = {2 ** chance.randint(8, 14)}\nparticles = {chance.choice([100, 300])}',
        "subset": f'method = "subset"\nparticles = {chance.choice([100, 300, 1000])}\nrandomisations = {chance.choice([8, 16])}',
    }[method]
    lines = "\n".join(f"{name} = {value}" for name, value in axes.items())
    text = (
        f'name = "random"\n{model}[axes]\n{lines}\n[random]\ninputs = {listed(inputs)}\n'
        f"relative_std = {round(chance.uniform(0.01, 0.2), 3)}\n[criterion]\nkind = {kind}\n{rest}"
        f"[sampling]\n{sampling}\nseed = {chance.randrange(1000)}\n"
    )
    return text, criterion, method


class Predicted(NamedTuple):
    """What `check --json` says of the time of a run."""

    seconds: Optional[float]
    why_unknown: Optional[str]


def predicted(said: str) -> Predicted:
    """What `check` predicts of a whole run."""
    answer = json.loads(said)
    return Predicted(answer["seconds"], answer["not_known_because"])


def timed(words: list, folder: Path, limit: float) -> tuple:
    """Runs a command; its seconds, its exit code (none if it takes longer) and what it said."""
    begun = time.monotonic()
    try:
        done = subprocess.run(list(map(str, words)), cwd=folder, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        return time.monotonic() - begun, None, ""
    return time.monotonic() - begun, done.returncode, done.stdout + done.stderr


WIDTH, MARGIN, TEXT = 640, 70, 'font-family="sans-serif" font-size="13"'


def picture(rows: list) -> str:
    """Predicted over measured seconds, as SVG, with the factor about both as a band and a colour for each criterion."""
    points = [(measured, prediction.seconds, criterion) for _, criterion, _, _, prediction, measured in rows if measured]
    exponents = [math.log10(value) for point in points for value in point[:2]]
    low, high = math.floor(min(exponents)), math.ceil(max(exponents))
    scale = (WIDTH - 2 * MARGIN) / max(high - low, 1)
    x = lambda seconds: MARGIN + (math.log10(seconds) - low) * scale
    y = lambda seconds: WIDTH - x(seconds)
    ends, by = (10.0**low, 10.0**high), FACTOR
    band = " ".join(
        f"{x(at):.1f},{y(at * factor):.1f}" for at, factor in [(ends[0], by), (ends[1], by), (ends[1], 1 / by), (ends[0], 1 / by)]
    )
    frame = f'x="{MARGIN}" y="{MARGIN}" width="{WIDTH - 2 * MARGIN}" height="{WIDTH - 2 * MARGIN}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH + 160}" height="{WIDTH}" {TEXT}>',
        f'<rect width="100%" height="100%" fill="white"/><clipPath id="frame"><rect {frame}/></clipPath>',
        f'<polygon points="{band}" fill="#e8e8e8" clip-path="url(#frame)"/><rect {frame} fill="none" stroke="black"/>',
        f'<line x1="{x(ends[0])}" y1="{y(ends[0])}" x2="{x(ends[1])}" y2="{y(ends[1])}" stroke="#888"/>',
    ]
    for exponent in range(low, high + 1):
        at = 10.0**exponent
        parts.append(f'<text x="{x(at):.1f}" y="{WIDTH - MARGIN + 20}" text-anchor="middle">{at:g}</text>')
        parts.append(f'<text x="{MARGIN - 8}" y="{y(at) + 4:.1f}" text-anchor="end">{at:g}</text>')
    for index, criterion in enumerate(CRITERIA):
        colour = f"hsl({index * 360 // len(CRITERIA)}, 70%, 45%)"
        mine = [point for point in points if point[2] == criterion]
        parts += [f'<circle cx="{x(at):.1f}" cy="{y(said):.1f}" r="3" fill="{colour}"/>' for at, said, _ in mine]
        parts.append(f'<text x="{WIDTH - MARGIN + 14}" y="{MARGIN + 18 * index + 12}" fill="{colour}">{criterion}</text>')
    middle = WIDTH // 2
    parts += [
        f'<text x="{middle}" y="{WIDTH - 18}" text-anchor="middle">measured time of submit, s</text>',
        f'<text x="20" y="{middle}" text-anchor="middle" transform="rotate(-90 20 {middle})">predicted by check, s</text>',
        f'<text x="{MARGIN}" y="{MARGIN - 14}">{len(points)} jobs; the band is a factor of {FACTOR:g}</text></svg>',
    ]
    return "\n".join(parts) + "\n"


def quantiles(numbers: list) -> str:
    numbers = sorted(numbers)
    at = lambda part: numbers[min(len(numbers) - 1, int(part * len(numbers)))]
    return f"least {numbers[0]:.2f}, median {at(0.5):.2f}, 90 % below {at(0.9):.2f}, greatest {numbers[-1]:.2f}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=Path)
    parser.add_argument("--jobs", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--longest", type=float, default=20.0, help="predicted seconds of jobs that are run")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="begin no job later than this")
    parser.add_argument("--keep", type=Path, help="a table of all jobs, and the jobs beside it")
    parser.add_argument("--picture", type=Path, help="predicted over measured seconds, as SVG")
    options = parser.parse_args()
    program = options.program.resolve()
    rows, refused, failed = [], 0, []
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        number = 0
        while len(rows) < options.jobs and time.monotonic() - begun < options.seconds:
            number += 1
            text, criterion, method = drawn_job(random.Random(f"{options.seed}/{number}"))
            job = folder / f"{number}.toml"
            job.write_text(text)
            seconds, code, said = timed([program, "check", job.name, "--threads", 1, "--json"], folder, 120)
            if code == 65:
                refused += 1
                continue
            if code != 0:
                failed.append((number, f"check ends with {code} after {seconds:.1f} s", said))
                continue
            prediction, measured = predicted(said), None
            if prediction.seconds is not None and prediction.seconds < options.longest:
                words = [program, "submit", job.name, "--threads", 1, "--out", "run"]
                measured, code, output = timed(words, folder, 20 * options.longest)
                # An audit that finds a map wrong is a result.
                if code not in (0, 70, None):
                    failed.append((number, f"submit ends with {code}", output))
                shutil.rmtree(folder / "run", ignore_errors=True)
            rows.append((number, criterion, method, seconds, prediction, measured))
            if options.keep:
                (options.keep.parent / f"{options.keep.stem}-{number}.toml").write_text(text)
            print(f"\r{len(rows)} of {options.jobs}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    if options.keep:
        with options.keep.open("w", newline="") as file:
            table = csv.writer(file)
            table.writerow(["number", "criterion", "method", "check", "predicted", "not_known_because", "measured"])
            for number, criterion, method, seconds, prediction, measured in rows:
                table.writerow([number, criterion, method, f"{seconds:.3f}", *prediction, measured])
    if options.picture and any(row[5] for row in rows):
        options.picture.write_text(picture(rows))
    print(f"{len(rows)} jobs were accepted, {refused} refused; seed {options.seed}")
    print("by criterion: " + ", ".join(f"{name} {count}" for name, count in collections.Counter(row[1] for row in rows).items()))
    print("by method: " + ", ".join(f"{name} {count}" for name, count in collections.Counter(row[2] for row in rows).items()))
    print(f"seconds of check: {quantiles([row[3] for row in rows])}")
    unknown = collections.Counter(row[4].why_unknown for row in rows if row[4].seconds is None)
    print(f"without a predicted time, which is said: {sum(unknown.values())}")
    ratios = [(row[4].seconds / row[5], row) for row in rows if row[5] is not None]
    within = [ratio for ratio, _ in ratios if 1 / FACTOR <= ratio <= FACTOR]
    # What is over at once tells little of a prediction.
    told = [(ratio, row) for ratio, row in ratios if row[5] > 0.5]
    for what, some in [("all", ratios), ("of more than half a second", told)]:
        if some:
            good = sum(1 / FACTOR <= ratio <= FACTOR for ratio, _ in some)
            print(f"predicted over measured, {len(some)} runs, {what}: {quantiles([ratio for ratio, _ in some])}; {good} within {FACTOR:g}")
    for ratio, (number, criterion, method, _, prediction, measured) in sorted(ratios, key=lambda entry: entry[0]):
        if not 1 / FACTOR <= ratio <= FACTOR:
            print(f"outside: job {number}, {criterion}, {method}: predicted {prediction.seconds:.2f}, measured {measured:.2f} s")
    slow = [row for row in rows if row[3] > LONGEST_CHECK]
    for number, criterion, method, seconds, _, _ in slow:
        print(f"slow: check of job {number}, {criterion}, {method}: {seconds:.1f} s")
    for number, why, said in failed:
        print(f"FAILED: job {number}: {why}\n{said}")
    is_good = len(within) >= SHARE * len(ratios)
    return 0 if is_good and not failed and not slow else 1


if __name__ == "__main__":
    sys.exit(main())
