"""Verdicts of LAPACK on small models given by matrices, for fates.csv and fates.json.

    python fates.py [FOLDER] [SEED]

Needs numpy, scipy and mpmath. Nothing here is taken from the program's own sources.

500 models of 1, 2, 3, 5, 10 and 20 coordinates are drawn at random, each with a band in hertz and a threshold for the damping
ratio zeta = -Re/|lambda|. A model is unstable if an eigenvalue with its |Im| / 2 pi in the band has zeta below the threshold.
The kinds:

    plain       symmetric M, C and K, positive definite, and a nonsymmetric part of K from friction
    undamped    the same without damping, or nearly so: C is 0, or 1e-9 of that of the others
    skew        and a gyroscopic, skew-symmetric part of C
    repeated    modes that coincide, or nearly so, before friction couples them
    divergence  K with a negative direction, so that an eigenvalue is real and positive
    negative    damping that feeds some modes, as falling friction does
    stiff       stiffnesses that differ by six orders of magnitude

A real eigenvalue has the frequency 0: it counts if the band begins at 0. A real positive one has zeta = -1, a real negative
one zeta = 1. Half of the thresholds are 0; half of the rest lie near the worst damping ratio, at relative distances from 1e-1
down to 1e-7.

`worst` is the least damping ratio in the band, from the eigenvalues that scipy.linalg.eig finds for the pencil, with balanced
units. Where it lies within 1e-6 of the threshold, or an eigenvalue within 1e-6 of an end of the band, where a real eigenvalue
or a nearly double one is there to be doubted, or the two ways of scaling of LAPACK differ by more than 1e-9, the eigenvalues are
found once more with 50 digits by mpmath, and those are written. Cases in which 50 digits still leave a distance to the threshold
below 1e-9, or an eigenvalue within 1e-9 of an end of the band, are drawn again. Undamped models stand on their threshold where
it is 0, unless they are unstable; they are drawn with another threshold.

fates.csv has a row per model: case, kind, coordinates, band, threshold, unstable (0 or 1), worst, the frequency of the worst in
hertz, and by which program. fates.json has the matrices in the same order: m, c, k, row by row, exactly as doubles.
"""

import csv
import json
import math
import sys
from pathlib import Path

import mpmath
import numpy as np
import scipy.linalg

SIZES = [1, 2, 3, 5, 10, 20]
# Cases of each size: few of the largest, to keep the file small.
COUNTS = {1: 70, 2: 120, 3: 125, 5: 110, 10: 60, 20: 15}
KINDS = ["plain", "undamped", "skew", "repeated", "divergence", "negative", "stiff"]
MARGIN = 1e-9
HERTZ = 2.0 * math.pi


def rounded(a, digits=5):
    """Few digits keep the file small; the doubles nearest to them are the model."""
    return np.array([[float(f"{v:.{digits}g}") for v in row] for row in a])


def positive(random, n, spread):
    q = np.linalg.qr(random.standard_normal((n, n)))[0]
    return q @ np.diag(np.exp(spread * random.standard_normal(n))) @ q.T


def symmetric(a):
    return np.tril(a) + np.tril(a, -1).T


def draw(random, n, kind):
    """M, C and K in kg, N s/m and N/m: frequencies of some hundred hertz."""
    unit = (HERTZ * 10.0 ** random.uniform(1.0, 3.5)) ** 2
    m = positive(random, n, 0.3)
    root = np.linalg.cholesky(m)
    spread = 3.0 if kind == "stiff" else 0.6
    if kind == "repeated":
        values = np.repeat(np.exp(0.6 * random.standard_normal((n + 1) // 2)), 2)[:n]
        values *= 1.0 + random.choice([0.0, 1e-7, 1e-4]) * random.standard_normal(n)
        q = np.linalg.qr(random.standard_normal((n, n)))[0]
        k = root @ q @ np.diag(values) @ q.T @ root.T
    else:
        k = root @ positive(random, n, spread) @ root.T
    if kind == "divergence":
        v = root @ random.standard_normal(n)
        k -= random.uniform(0.8, 3.0) * np.outer(v, v) / (v @ np.linalg.solve(k, v))
    c = 10.0 ** random.uniform(-3.0, -1.3) * (root @ positive(random, n, 0.5) @ root.T)
    if kind == "undamped":
        c *= random.choice([0.0, 1e-9])
    if kind == "negative":
        v = root @ random.standard_normal(n)
        c -= 10.0 ** random.uniform(-3.0, -1.0) * np.outer(v, v)
    c, k, m = symmetric(c), symmetric(k), symmetric(m)
    if kind == "skew" and n > 1:
        a = 10.0 ** random.uniform(-2.0, 0.3) * random.standard_normal((n, n))
        c = c + (a - a.T) / 2.0
    if n > 1:
        friction = random.standard_normal((n, n))
        share = random.uniform(0.0, 0.6) if kind != "stiff" else random.uniform(0.0, 0.2)
        k = k + share * friction * np.linalg.norm(k, 2) / np.linalg.norm(friction, 2) * random.choice([0.1, 1.0])
    if kind in ("repeated", "undamped") and random.random() < 0.3:
        k = symmetric(k)
    # Repeated modes are to stay so to many digits.
    digits = 12 if kind == "repeated" and n <= 5 else 5
    return rounded(m, digits), rounded(c * math.sqrt(unit), digits), rounded(k * unit, digits)


def by_lapack(m, c, k, frequency_unit):
    """All eigenvalues of the pencil, in time scaled to this frequency."""
    n = len(m)
    s = frequency_unit
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-k / s**2, -c / s]])
    b = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), m]])
    return scipy.linalg.eigvals(a, b) * s


def by_mpmath(m, c, k, frequency_unit):
    """Likewise, with 50 digits. A zero of the band's lower end needs real eigenvalues exactly real."""
    mpmath.mp.dps = 50
    n = len(m)
    s = mpmath.mpf(frequency_unit)
    inverse = mpmath.inverse(mpmath.matrix(m.tolist()))
    a = mpmath.zeros(2 * n)
    top, bottom = inverse * mpmath.matrix(k.tolist()), inverse * mpmath.matrix(c.tolist())
    for i in range(n):
        a[i, n + i] = 1
        for j in range(n):
            a[n + i, j], a[n + i, n + j] = -top[i, j] / s**2, -bottom[i, j] / s
    values, _ = mpmath.eig(a)
    return [complex(v * s) if abs(v.imag) > mpmath.mpf(10) ** -30 else complex(v.real * s, 0.0) for v in values]


def damping_ratio(v):
    return -v.real / abs(v)


def worst_in(values, band):
    inside = [v for v in values if band[0] <= abs(v.imag) / HERTZ <= band[1]]
    return min(inside, key=damping_ratio) if inside else None


def at_an_end(values, band, relative):
    ends = [e for e in band if e > 0.0]
    return any(abs(abs(v.imag) / HERTZ - e) <= relative * e for v in values for e in ends)


def near_real_or_double(values):
    """Rounding may make a pair of a double real eigenvalue, or move two near ones by a square root of it."""
    values = np.asarray(values)
    scale = abs(values).max()
    gaps = abs(values[:, None] - values[None, :]) + np.eye(len(values)) * scale
    return bool((abs(values.imag) < 1e-6 * abs(values)).any() or (gaps.min(1) < 1e-4 * abs(values)).any())


def case(random, n, kind):
    """A model with its verdict, or None where there is none to 1e-9."""
    m, c, k = draw(random, n, kind)
    unit = math.sqrt(np.linalg.norm(k) / np.linalg.norm(m))
    values = by_lapack(m, c, k, unit)
    hertz = np.sort(abs(values.imag)) / HERTZ
    band = random.choice(hertz) * random.uniform(0.4, 0.95), random.choice(hertz) * random.uniform(1.05, 2.0)
    if random.random() < (0.8 if kind == "divergence" else 0.3):
        band = 0.0, band[1]
    if random.random() < 0.3:
        band = band[0], 10.0 * hertz[-1]
    band = tuple(float(f"{b:.6g}") for b in band)
    if not band[0] < band[1]:
        return None
    worst = worst_in(values, band)
    choice = random.random()
    threshold = 0.0
    if choice > 0.75 and worst is not None:
        threshold = damping_ratio(worst) + random.choice([-1.0, 1.0]) * 10.0 ** random.uniform(-7.0, -1.0)
    elif choice > 0.5 or kind == "undamped" and choice > 0.25:
        threshold = random.choice([-0.05, -0.01, -0.001, -1e-5, 0.001, 0.01])
    threshold = float(f"{min(max(threshold, -0.999), 0.999):.10g}")

    program = "lapack"
    other = worst_in(by_lapack(m, c, k, 3.7 * unit), band)
    doubtful = (
        at_an_end(values, band, 1e-6)
        or near_real_or_double(values)
        or (worst is None) != (other is None)
        or worst is not None
        and (abs(damping_ratio(worst) - threshold) < 1e-6 or abs(damping_ratio(worst) - damping_ratio(other)) > 1e-9)
    )
    before = worst
    if doubtful:
        program = "mpmath"
        values = by_mpmath(m, c, k, unit)
        worst = worst_in(values, band)
    if at_an_end(values, band, MARGIN):
        return None
    if worst is not None and abs(damping_ratio(worst) - threshold) < MARGIN:
        return None
    unstable = worst is not None and damping_ratio(worst) < threshold
    lapack_says = before is not None and damping_ratio(before) < threshold
    return m, c, k, band, threshold, unstable, worst, program, lapack_says


def main():
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    random = np.random.default_rng(int(sys.argv[2]) if len(sys.argv) > 2 else 2026)
    rows, models, wrong = [], [], 0
    for n in SIZES:
        found = 0
        while found < COUNTS[n]:
            kind = KINDS[found % len(KINDS)]
            result = case(random, n, kind)
            if result is None:
                continue
            m, c, k, band, threshold, unstable, worst, program, lapack_says = result
            found += 1
            wrong += lapack_says != unstable
            worst_ratio = "" if worst is None else repr(float(damping_ratio(worst)))
            hertz = "" if worst is None else repr(float(abs(worst.imag) / HERTZ))
            rows.append([len(rows), kind, n, *band, threshold, int(unstable), worst_ratio, hertz, program])
            models.append({name: a.ravel().tolist() for name, a in (("m", m), ("c", c), ("k", k))})
    with open(folder / "fates.csv", "w", newline="") as file:
        file.write(
            "# 500 verdicts on random models given by matrices, which are in fates.json. Made by tests/data/matrices/fates.py, which\n"
        )
        file.write(
            "# shares no code with the program: LAPACK, and mpmath with 50 digits where LAPACK's rounding could matter, 2026-11.\n"
        )
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            [
                "case",
                "kind",
                "coordinates",
                "from_hz",
                "to_hz",
                "damping_ratio",
                "unstable",
                "worst",
                "worst_hz",
                "program",
            ]
        )
        writer.writerows(rows)
    with open(folder / "fates.json", "w") as file:
        file.write("[\n" + ",\n".join(json.dumps(model, separators=(",", ":")) for model in models) + "\n]\n")
    unstable = sum(row[6] for row in rows)
    print(
        f"{len(rows)} cases, {unstable} unstable, {sum(r[9] == 'mpmath' for r in rows)} by mpmath; LAPACK alone wrong on {wrong}"
    )


if __name__ == "__main__":
    main()
