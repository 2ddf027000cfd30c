//! Gaussian elimination in lanes, without exchange of rows.
//!
//! No exchange is needed where `v* R v` has a positive imaginary part for every v, as the module documentation proves
//! of the core: pivots cannot vanish then, and their growth is bounded (G. H. Golub, C. F. Van Loan, "Unsymmetric
//! positive definite linear systems", Linear Algebra and its Applications 28, 1979, 85-97). The search for the
//! equilibrium shows by its convergence that its own elimination was good.

use crate::numerics::row::Row;

/// Replaces a square matrix by its triangular factors: L below the diagonal, with ones on it, U above, and the
/// reciprocals of its diagonal.
#[inline(always)]
pub(super) fn eliminate<const L: usize>(matrix: &mut [Row<L>], size: usize) {
    for k in 0..size {
        let (above, below) = matrix.split_at_mut((k + 1) * size);
        let pivot = &mut above[k * size..];
        pivot[k] = pivot[k].reciprocal();
        for row in below.chunks_exact_mut(size) {
            let multiple = row[k] * pivot[k];
            row[k] = multiple;
            for (entry, other) in row[k + 1..].iter_mut().zip(&pivot[k + 1..]) {
                *entry -= multiple * *other;
            }
        }
    }
}

/// Solves a system whose matrix was [eliminated](eliminate).
#[inline(always)]
pub(super) fn solve<const L: usize>(factors: &[Row<L>], size: usize, vector: &mut [Row<L>]) {
    for i in 1..size {
        let mut sum = vector[i];
        for (entry, value) in factors[i * size..i * size + i].iter().zip(&vector[..i]) {
            sum -= *entry * *value;
        }
        vector[i] = sum;
    }
    for i in (0..size).rev() {
        let row = &factors[i * size..(i + 1) * size];
        let mut sum = vector[i];
        for (entry, value) in row[i + 1..].iter().zip(&vector[i + 1..]) {
            sum -= *entry * *value;
        }
        vector[i] = sum * row[i];
    }
}

/// A complex number in each lane.
pub(super) type Complex<const L: usize> = (Row<L>, Row<L>);

#[inline(always)]
pub(super) fn product<const L: usize>(a: Complex<L>, b: Complex<L>) -> Complex<L> {
    (a.0 * b.0 - a.1 * b.1, a.0 * b.1 + a.1 * b.0)
}

/// Replaces a complex matrix by its triangular factors: L below the diagonal, with ones on it, U above, and the
/// reciprocals of its diagonal, all but the last, which stays itself.
#[inline(always)]
pub(super) fn eliminate_complex<const L: usize>(real: &mut [Row<L>], imaginary: &mut [Row<L>], size: usize) {
    for k in 0..size - 1 {
        let (above, below) = real.split_at_mut((k + 1) * size);
        let (above_imaginary, below_imaginary) = imaginary.split_at_mut((k + 1) * size);
        let (re, im) = (&mut above[k * size..], &mut above_imaginary[k * size..]);
        let scale = (re[k] * re[k] + im[k] * im[k]).reciprocal();
        (re[k], im[k]) = (re[k] * scale, -(im[k] * scale));
        for (row, row_imaginary) in below.chunks_exact_mut(size).zip(below_imaginary.chunks_exact_mut(size)) {
            let (a, b) = product((row[k], row_imaginary[k]), (re[k], im[k]));
            (row[k], row_imaginary[k]) = (a, b);
            let entries = row[k + 1..].iter_mut().zip(&mut row_imaginary[k + 1..]);
            for ((x, y), (u, v)) in entries.zip(re[k + 1..].iter().zip(&im[k + 1..])) {
                *x -= a * *u - b * *v;
                *y -= a * *v + b * *u;
            }
        }
    }
}

/// Of the factors of a matrix with last column c and last row r, and of R, all the rest of it: `z = R^-1 c` and
/// `w = r R^-1`.
#[inline(always)]
pub(super) fn left_and_right<const L: usize>(
    (real, imaginary): (&[Row<L>], &[Row<L>]),
    size: usize,
    left: &mut [Complex<L>],
    right: &mut [Complex<L>],
) {
    let last = size - 1;
    let at = |i: usize, j: usize| (real[i * size + j], imaginary[i * size + j]);
    for i in (0..last).rev() {
        let (mut w, mut z) = (at(last, i), at(i, last));
        for j in i + 1..last {
            let (a, b) = product(left[j], at(j, i));
            w = (w.0 - a, w.1 - b);
            let (a, b) = product(at(i, j), right[j]);
            z = (z.0 - a, z.1 - b);
        }
        left[i] = w;
        right[i] = product(z, at(i, i));
    }
}

/// `R^-1 v` for a real vector, by the same factors.
#[inline(always)]
pub(super) fn solve_complex<const L: usize>(
    (real, imaginary): (&[Row<L>], &[Row<L>]),
    size: usize,
    vector: &[Row<L>],
    solution: &mut [Complex<L>],
) {
    let last = size - 1;
    let at = |i: usize, j: usize| (real[i * size + j], imaginary[i * size + j]);
    for i in 0..last {
        let mut sum = (vector[i], Row::ZERO);
        for (j, value) in solution[..i].iter().enumerate() {
            let (a, b) = product(at(i, j), *value);
            sum = (sum.0 - a, sum.1 - b);
        }
        solution[i] = sum;
    }
    for i in (0..last).rev() {
        let mut sum = solution[i];
        for (j, value) in solution[..last].iter().enumerate().skip(i + 1) {
            let (a, b) = product(at(i, j), *value);
            sum = (sum.0 - a, sum.1 - b);
        }
        solution[i] = product(sum, at(i, i));
    }
}
