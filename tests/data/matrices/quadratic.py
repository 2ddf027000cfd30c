"""Eigenvalues of M q'' + C q' + K q = 0 by LAPACK and ARPACK, for the references of this folder. Needs numpy and scipy."""

import math

import numpy as np
import scipy.linalg
import scipy.sparse
import scipy.sparse.linalg


def all_eigenvalues(m, c, k):
    """Every eigenvalue, by LAPACK's dggev on the pencil ([0 I; -K -C], [I 0; 0 M]), in time scaled to the frequencies of K and M."""
    m, c, k = (np.asarray(a, dtype=float) for a in (m, c, k))
    n = len(m)
    scale = math.sqrt(np.linalg.norm(k) / np.linalg.norm(m))
    unit = np.linalg.norm(k)
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-k / unit, -c * scale / unit]])
    b = np.block([[np.eye(n), np.zeros((n, n))], [np.zeros((n, n)), m * scale * scale / unit]])
    return scipy.linalg.eigvals(a, b) * scale


def nearest(m, c, k, shift, count=6):
    """The eigenvalues nearest to a shift, by ARPACK's shift and invert with a sparse LU of K + shift C + shift^2 M."""
    n = m.shape[0]
    lu = scipy.sparse.linalg.splu((k + shift * c + shift * shift * m).astype(complex).tocsc())

    def invert(z):
        q, p = z[:n], z[n:]
        x = -lu.solve(m @ p + c @ q + shift * (m @ q))
        return np.concatenate([x, shift * x + q])

    operator = scipy.sparse.linalg.LinearOperator((2 * n, 2 * n), invert, dtype=complex)
    start = np.random.default_rng(1).standard_normal(2 * n) + 0j
    values = scipy.sparse.linalg.eigs(
        operator, k=count, v0=start, ncv=max(4 * count, 20), tol=1e-13, return_eigenvectors=False
    )
    return shift + 1.0 / values


def follow(m, c, k, guess):
    """The eigenvalue nearest to a guess: twice, so that the second shift lies beside it."""
    for offset in (1e-3, 1e-5):
        found = nearest(m, c, k, guess * (1.0 + offset * 1j), 4)
        guess = found[np.argmin(abs(found - guess))]
    return complex(guess)


def damping_ratio(value):
    return -value.real / abs(value)


def zero_by_secant(f, a, b, tolerance=1e-12):
    """A zero of f near a and b."""
    fa, fb = f(a), f(b)
    for _ in range(40):
        a, b, fa = b, b - fb * (b - a) / (fb - fa), fb
        if abs(b - a) <= tolerance * abs(b):
            return b
        fb = f(b)
    return b
