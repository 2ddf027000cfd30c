"""Numbers that other programs find for models given by matrices, for references.toml.

    python references.py [--without-brakes] > references.toml

Needs numpy and scipy. Nothing here is taken from the program's own sources. Each number carries its source:

    [P]  printed by others: copied, with the value found here beside it
    [L]  computed here, by LAPACK (dense) or by ARPACK with a sparse LU (full matrices)
    [M]  a formula of the literature, with the value found here by LAPACK beside it

`computed` is always what this script finds. `printed` and `formula` are what it is compared with. It takes some four minutes.
"""

import math
import sys
from pathlib import Path

import numpy as np
import scipy.io
import scipy.stats

from quadratic import all_eigenvalues, damping_ratio, follow, nearest, zero_by_secant

JOBS = Path(__file__).resolve().parents[3] / "jobs"
HERTZ = 2.0 * math.pi


def entry(name, source, about, **values):
    print(f"\n[[reference]]\nname = {name!r}\nsource = {source!r}\nabout = {about!r}".replace("'", '"'))
    for key, value in values.items():
        print(f"{key} = {toml(value)}")
    sys.stdout.flush()


def toml(value):
    if isinstance(value, complex):
        return f"[{value.real:.17g}, {value.imag:.17g}]"
    if isinstance(value, list | tuple | np.ndarray):
        return "[" + ", ".join(toml(v) for v in value) + "]"
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, int):
        return str(value)
    text = f"{float(value):.15g}"
    return text if any(c in text for c in ".e") else text + ".0"


def largest_growth(m, c, k):
    return max(all_eigenvalues(m, c, k).real)


def crossing(grows, low, high):
    """The value between two at which the verdict changes, by bisection."""
    for _ in range(100):
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        low, high = (low, middle) if grows(middle) else (middle, high)
    return 0.5 * (low + high)


# Two masses, mode coupling. K = [[k11, k12 - D], [k12, k22]], M = I, C = diag(c1, c2).


def coupled(k11, k12, k22, c1=0.0, c2=0.0):
    """The critical D: by formula, and by eigenvalues."""
    if c1 == c2 == 0.0:
        formula = k12 + (k11 - k22) ** 2 / (4.0 * k12)
    else:
        a3, a2, a1 = c1 + c2, k11 + k22 + c1 * c2, c1 * k22 + c2 * k11
        formula = (a1 * (a3 * a2 - a1) / a3**2 - (k11 * k22 - k12**2)) / k12
    m, c = np.eye(2), np.diag([c1, c2])

    def grows(d):
        # Undamped: at the flutter limit two eigenvalues meet, and their real parts are a square root of what is left.
        return largest_growth(m, c, [[k11, k12 - d], [k12, k22]]) > (1e-7 if c1 == c2 == 0.0 else 0.0)

    return formula, crossing(grows, 0.5 * formula, 1.5 * formula)


def small_models():
    paper = "Hoffmann, Fischer, Allgaier, Gaul 2002; Hoffmann and Gaul 2003"
    springs = "K = [[2, 1 - D], [1, 2]], D = 4 mu/3: the critical friction"
    formula, found = coupled(2.0, 1.0, 2.0)
    entry("hoffmann-undamped", f"[M] {paper}", springs, formula=0.75 * formula, computed=0.75 * found, tolerance=1e-9)
    for c1, c2 in [(0.02, 0.02), (0.01, 0.05), (0.1, 0.3)]:
        formula, found = coupled(2.0, 1.0, 2.2, c1, c2)
        about = f"k11 = 2, k12 = 1, k22 = 2.2, c = ({c1}, {c2}): the critical D"
        entry(f"hoffmann-damped-{c1}-{c2}", f"[M] {paper}", about, formula=formula, computed=found, tolerance=1e-10)
    formula, found = coupled(2.0, 1.0, 2.2)
    entry(
        "hoffmann-detuned",
        f"[M] {paper}",
        "k22 = 2.2, undamped: the critical D",
        formula=formula,
        computed=found,
        tolerance=1e-9,
    )
    for ratio in (1, 10):
        formula, found = coupled(2.0, 1.0, 2.2, 1e-4, 1e-4 * ratio)
        limit = coupled(2.0, 1.0, 2.2, 1e-9, 1e-9 * ratio)[0]
        about = f"k22 = 2.2, c1 = 1e-4, c2 = {ratio} c1: the critical D; formula_limit for c1 -> 0. Damping can destabilise."
        entry(
            f"hoffmann-destabilised-{ratio}",
            f"[M] {paper}",
            about,
            formula=formula,
            formula_limit=limit,
            computed=found,
            tolerance=1e-8,
        )

    w1, w2 = HERTZ * 100.0, HERTZ * 75.0
    printed = {(0.0, 0.0): 0.2916667, (0.02, 0.02): 0.2893671, (0.01, 0.05): 0.2390839}
    for (e1, e2), value in printed.items():
        c = np.diag([e1 * w1, e2 * w2])

        def grows(mu, c=c, undamped=e1 == 0.0):
            k = [[w1**2, -mu * w2**2], [mu * w1**2, w2**2]]
            return largest_growth(np.eye(2), c, k) > (1e-4 if undamped else 0.0)

        more = (
            {"formula": abs(w1**2 - w2**2) / (2.0 * w1 * w2)}
            if e1 == 0.0
            else {"formula": hulten_damped(w1, w2, e1, e2)}
        )
        # The damped figures, too, come from the condition of Routh and Hurwitz.
        entry(
            f"hulten-{e1}-{e2}",
            "[M] Sinou and Jezequel 2007",
            f"w1, w2 = 2 pi (100, 75), e = ({e1}, {e2}): the critical mu. given: to the digits handed down.",
            **more,
            given=value,
            computed=crossing(grows, 0.1, 0.6),
            tolerance=1e-9,
        )


def hulten_damped(w1, w2, e1, e2):
    """a1 (a3 a2 - a1) = a3^2 a0, with a0 = w1^2 w2^2 (1 + mu^2)."""
    c1, c2 = e1 * w1, e2 * w2
    a3, a2, a1 = c1 + c2, w1**2 + w2**2 + c1 * c2, c1 * w2**2 + c2 * w1**2
    return math.sqrt(a1 * (a3 * a2 - a1) / (a3 * w1 * w2) ** 2 - 1.0)


def disk_brake100():
    source = "[L] NLEVP, disk_brake100; LAPACK"
    data = {k: v for k, v in scipy.io.loadmat(JOBS / "tu-brake" / "disk_brake100.mat").items() if k[0] != "_"}

    def matrices(speed, s=1.0):
        c = data["D1"] + s * data["DR"] / speed + speed * data["DG"]
        return data["M"], c, data["K1"] + s * data["KR"]

    given = {2: 0.00106524 + 0.000702j, 4: 0.00105920 + 0.000712j, 8: 0.00104698 + 0.000730j}
    for turns, value in given.items():
        eigenvalues = all_eigenvalues(*matrices(turns * math.pi))
        unstable = [v for v in eigenvalues if v.real > 0.0 and v.imag >= 0.0]
        worst = max(unstable, key=lambda v: v.real)
        entry(
            f"disk-brake-100-{turns}pi",
            source,
            f"speed {turns} pi: the least stable eigenvalue [re, im]; given: to the digits handed down",
            speed=turns * math.pi,
            given=value,
            computed=complex(worst),
            unstable_pairs=len(unstable),
            tolerance=1e-8,
        )
    found = crossing(lambda s: largest_growth(*matrices(2.0 * math.pi, s)) > 0.0, 0.01, 0.3)
    entry(
        "disk-brake-100-factor",
        source,
        "speed 2 pi: the factor on DR and KR together at which max Re = 0",
        given=0.0835794671,
        computed=found,
        tolerance=1e-6,
    )


def tu_brake():
    zamm = "Graebner, Mehrmann, Quraishi, Schroeder, von Wagner, ZAMM 96 (2016) 1388"
    data = {k: v.tocsc() for k, v in scipy.io.loadmat(JOBS / "tu-brake" / "tu-brake.mat").items() if k[0] != "_"}

    printed_counts = {
        "M": 93207,
        "D1": 5683,
        "DG": 66643,
        "DR": 5683,
        "D4": 23885,
        "K1": 280845,
        "KR": 21646,
        "KGEO": 280871,
    }
    printed_norms = {
        "M": 6.09e-5,
        "D1": 6.86,
        "DG": 1.52e-4,
        "DR": 6.86,
        "D4": 3.22e4,
        "K1": 5.98e7,
        "KR": 1.45e5,
        "KGEO": 2.40e-3,
    }
    for key, matrix in data.items():
        norm = scipy.sparse.linalg.svds(matrix, 1, return_singular_vectors=False, random_state=1)[0]
        entry(
            f"tu-brake-{key}",
            f"[P] {zamm}",
            f"{key}: number of nonzeros and 2-norm"
            + ("; the printed norm is not that of the file" if key == "KGEO" else ""),
            printed_nonzeros=printed_counts[key],
            nonzeros=matrix.nnz,
            printed=printed_norms[key],
            computed=norm,
            tolerance=0.02 if key == "KGEO" else 4e-3,
        )

    def matrices(speed, s=1.0, lining_damping=0.0):
        c = data["D1"] + data["DR"] / speed + speed * data["DG"] + lining_damping * data["D4"]
        return data["M"], c, data["K1"] + s * data["KR"] + speed**2 * data["KGEO"]

    logs = {2: [-2.462 + 3338j], 40: [-3.809 + 3576j, -6.673 + 9836j, -9.215 + 1413j, 63.93 + 17040j]}
    for turns, values in logs.items():
        for i, value in enumerate(values):
            found = follow(*matrices(turns * math.pi), value)
            entry(
                f"tu-brake-{turns}pi-{i}",
                f"[P] logs of the code of {zamm}",
                f"speed {turns} pi, without D4: eigenvalue [re, im]",
                speed=turns * math.pi,
                printed=value,
                computed=found,
                tolerance=1e-6,
            )
    for i, value in enumerate(
        [
            -10.173152 + 1413.56400j,
            -2.914258 + 3337.09330j,
            -11.495620 + 3521.83054j,
            -16.209506 + 4047.88531j,
            -27.570439 + 4915.77334j,
            -38.886828 + 4937.10036j,
            -0.000647 + 5130.60458j,
            -13.432573 + 10129.20111j,
            -38.180972 + 10253.97560j,
            -13.587414 + 16346.09452j,
            75.347507 + 17459.93857j,
        ]
    ):
        found = follow(*matrices(4.0 * math.pi), value)
        entry(
            f"tu-brake-4pi-{i}",
            "[L] ARPACK, sparse LU",
            "speed 4 pi, without D4: eigenvalue [re, im]; given: to the digits handed down",
            speed=4.0 * math.pi,
            given=value,
            computed=found,
            tolerance=1e-7,
        )

    damped = 4.0 * math.pi, 1.0 / 1600.0
    state = {"guess": 17354.76j}

    def ratio(s):
        state["guess"] = follow(*matrices(damped[0], s, damped[1]), state["guess"])
        return damping_ratio(state["guess"])

    s = zero_by_secant(ratio, 1.95, 1.97)
    hertz = abs(state["guess"]) / HERTZ
    about = "speed 4 pi, D4/1600: the factor on KR at which the pair of 2.76 kHz crosses, and its frequency in Hz"
    entry(
        "tu-brake-critical",
        "[L] ARPACK, sparse LU",
        about,
        given=1.9602310483,
        computed=s,
        given_hertz=2762.0966,
        computed_hertz=hertz,
        tolerance=1e-9,
    )
    probability = scipy.stats.norm.sf(s, 1.5, 0.2)
    entry(
        "tu-brake-probability",
        "[L] from the critical factor",
        "s normal with mean 1.5 and standard deviation 0.2, 1 to 3 kHz: P",
        given=0.0106914289,
        computed=probability,
        tolerance=1e-9,
    )
    # No other pair between 1 and 3 kHz may cross within seven standard deviations, or P would be another one. The shifts lie
    # 125 Hz apart, and each finds more pairs than there are in that distance.
    worst = {}
    for factor in (0.1, 1.0, 1.5, 1.95, 2.9):
        shifts = [1j * HERTZ * f for f in np.arange(1062.5, 3000.0, 125.0)]
        found = np.concatenate([nearest(*matrices(damped[0], factor, damped[1]), shift, 24) for shift in shifts])
        inside = found[(found.imag > HERTZ * 1000.0) & (found.imag < HERTZ * 3000.0)]
        # One mode is undamped: its ratio is zero to within rounding.
        inside = inside[abs(inside.imag / HERTZ - 816.56) > 5.0]
        worst[factor] = min(damping_ratio(v) for v in inside)
    entry(
        "tu-brake-band",
        "[L] ARPACK, sparse LU",
        "least damping ratio between 1 and 3 kHz at these factors on KR, speed 4 pi, D4/1600",
        factors=list(worst),
        computed=list(worst.values()),
        tolerance=1e-7,
    )


def own_brake():
    sys.path.insert(0, str(JOBS / "own-brake"))
    data = {k: v.tocsc() for k, v in scipy.io.loadmat(JOBS / "own-brake" / "own-brake.mat").items() if k[0] != "_"}
    modulus, contact, alpha, beta = 8e9, 5e12, 20.0, 5e-7
    structure = data["K0"] + modulus * data["K_lining"] + contact * data["K_contact"]
    c = alpha * data["M"] + beta * (data["K0"] + modulus * data["K_lining"])
    state = {}

    def ratio(mu):
        state["guess"] = follow(data["M"], c, structure + mu * contact * data["K_friction"], state["guess"])
        return damping_ratio(state["guess"])

    for name, guess, a, b in CROSSINGS:
        state["guess"] = guess
        mu = zero_by_secant(ratio, a, b)
        about = "jobs/own-brake/own-brake.mat: the critical friction, and the frequency in Hz"
        hertz = abs(state["guess"]) / HERTZ
        entry(name, "[L] ARPACK, sparse LU", about, computed=mu, computed_hertz=hertz, tolerance=1e-9)


# Of the own brake: name, pair to start from, two values of friction near the crossing.
CROSSINGS = [
    ("own-brake-12-khz", 2j * math.pi * 12743.0, 0.282, 0.283),
    ("own-brake-16-khz", 2j * math.pi * 16820.0, 0.155, 0.160),
]


def main():
    print(
        "# Made by tests/data/matrices/references.py. [P] printed by others, [L] computed independently, [M] a formula."
    )
    print("# computed: found by that script; tolerance: relative, of the computed value.")
    small_models()
    disk_brake100()
    if "--without-brakes" not in sys.argv:
        tu_brake()
        own_brake()


if __name__ == "__main__":
    main()
