//! Block Arnoldi iteration with `(A - s B)^-1 B`, where `A - lambda B` is a linearisation of the quadratic problem.
//!
//! With `v = lambda x / w` and a scale w: a step from `(u, v)` is `p = -Q(s)^-1 ((C + s M) u + w M v)`, `q = (u + s p) / w`:
//! one solve. Eigenvalues of the step are `1 / (lambda - s)`. Blocks of two find double eigenvalues, which discs have; single
//! vectors go twice as many steps.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par, c64};

use super::quadratic::{Factorisation, Point, Side};
use crate::models::matrices::error::Error;
use crate::models::matrices::pair::Complex;
use crate::models::matrices::region::magnitude;

/// Steps after which an eigenvalue would have converged that is twice as near to the shift as all others: 2^-30 is 1e-9.
const STEPS_FOR_NONE: usize = 30;

/// Eigenvalues of a Krylov space by distance from the shift.
pub(super) struct Krylov {
    size: usize,
    basis: Mat<c64>,
    combinations: Mat<c64>,
    /// In order of distance from the shift.
    pub(super) values: Vec<Ritz>,
    /// Up to this distance from the shift all eigenvalues are found and converged.
    pub(super) radius: f64,
}

/// An approximate eigenvalue.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ritz {
    pub(super) eigenvalue: Complex,
    /// Its distance from the shift.
    pub(super) distance: f64,
    /// The residual of the step's eigenvalue, relative to it.
    pub(super) residual: f64,
    column: usize,
}

/// How far to go.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// The distance from the shift up to which eigenvalues are wanted.
    pub(super) radius: f64,
    /// The largest number of vectors.
    pub(super) vectors: usize,
    /// How many a step adds.
    pub(super) block: usize,
    /// The residual at which a Ritz value is taken as converged.
    pub(super) tolerance: f64,
}

impl Krylov {
    /// Adds vectors until all eigenvalues within the radius are found, or there are as many as allowed.
    pub(super) fn new(point: &Point<'_>, near: &Factorisation, side: Side, effort: Effort) -> Result<Self, Error> {
        let (size, block) = (point.family().size(), effort.block);
        let most = effort.vectors.min(2 * size).max(block) / block * block;
        let mut basis = Mat::<c64>::zeros(2 * size, most + block);
        let mut projected = Mat::<c64>::zeros(most + block, most);
        let mut seed = 0;
        let mut first = vec![Complex::default(); block * 2 * size];
        first.iter_mut().for_each(|value| *value = unstructured(&mut seed));
        // One step first: it takes out what belongs to infinite eigenvalues.
        let scale = magnitude(near.shift()).max(f64::MIN_POSITIVE);
        step(point, near, side, scale, &mut first)?;
        append(&mut basis, 0, &mut first, size, None, &mut seed);
        let mut count = 0;
        loop {
            let mut vectors: Vec<Complex> = (count..count + block)
                .flat_map(|column| basis.col(column).iter().copied().collect::<Vec<_>>())
                .collect();
            step(point, near, side, scale, &mut vectors)?;
            append(&mut basis, count + block, &mut vectors, size, Some(&mut projected), &mut seed);
            count += block;
            let is_last = count + block > most;
            if is_last || (count >= 16 && count.is_multiple_of(8)) {
                let mut found = Self::ritz(size, projected.as_ref(), count, near.shift(), effort)?;
                if is_last || found.radius >= effort.radius {
                    if count >= 2 * size {
                        found.radius = f64::INFINITY;
                    }
                    found.basis = basis;
                    return Ok(found);
                }
            }
        }
    }

    fn ritz(size: usize, all: MatRef<'_, c64>, count: usize, shift: Complex, effort: Effort) -> Result<Self, Error> {
        let block = effort.block;
        let failed = Error::NotConverged { re: shift.re, im: shift.im };
        let square = all.submatrix(0, 0, count, count);
        let eigen = square.eigen().map_err(|_| failed)?;
        let combinations = eigen.U().to_owned();
        let below = all.submatrix(count, count - block, block, block);
        let mut values = Vec::with_capacity(count);
        for column in 0..count {
            let theta = eigen.S()[column];
            let tail = combinations.as_ref().submatrix(count - block, column, block, 1);
            let length = combinations.col(column).norm_l2();
            let residual = (below * tail).norm_l2() / (length * magnitude(theta));
            if theta != Complex::default() && residual.is_finite() {
                let away = Complex::new(1.0, 0.0) / theta;
                values.push(Ritz { eigenvalue: shift + away, distance: magnitude(away), residual, column });
            }
        }
        values.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        // Up to halfway between the last of the converged and the first that is not.
        let converged = values.iter().take_while(|value| value.residual <= effort.tolerance).count();
        let last = converged.checked_sub(1).map_or(0.0, |last| values[last].distance);
        let radius = match values.get(converged) {
            // An eigenvalue much nearer than all Ritz values would have been found by now: the steps favour it by that ratio.
            Some(nearest) if converged == 0 && count / block >= STEPS_FOR_NONE => 0.5 * nearest.distance,
            Some(next) => 0.5 * (last + next.distance.min(1.5 * last)),
            None => last,
        };
        Ok(Self { size, basis: Mat::new(), combinations, values, radius })
    }

    /// The eigenvector of one value, not scaled.
    pub(super) fn vector(&self, value: &Ritz) -> Vec<Complex> {
        let count = self.combinations.nrows();
        let top = self.basis.as_ref().submatrix(0, 0, self.size, count);
        let vector = top * self.combinations.col(value.column);
        vector.iter().copied().collect()
    }
}

/// A number without structure from -1 to 1 in both parts: fractions of squares times the golden ratio.
fn unstructured(seed: &mut u64) -> Complex {
    let mut next = || {
        *seed += 1;
        let word = seed.wrapping_mul(*seed).wrapping_add(*seed << 20).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        (word >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    Complex::new(next(), next())
}

/// One step for each vector of a block, in place.
fn step(point: &Point<'_>, near: &Factorisation, side: Side, scale: f64, block: &mut [Complex]) -> Result<(), Error> {
    let size = point.family().size();
    let shift = near.shift();
    let (zero, one) = (Complex::default(), Complex::new(1.0, 0.0));
    let mut right = vec![zero; block.len() / 2];
    let mut part = vec![zero; size];
    for (vector, right) in block.chunks_exact(2 * size).zip(right.chunks_exact_mut(size)) {
        point.combine([shift, one, zero], &vector[..size], side, right);
        point.combine([one * scale, zero, zero], &vector[size..], side, &mut part);
        right.iter_mut().zip(&part).for_each(|(sum, part)| *sum = -(*sum + part));
    }
    near.solve(&mut right, size, side)?;
    for (vector, solved) in block.chunks_exact_mut(2 * size).zip(right.chunks_exact(size)) {
        let (upper, lower) = vector.split_at_mut(size);
        for ((upper, lower), solved) in upper.iter_mut().zip(lower).zip(solved) {
            *lower = (*upper + shift * solved).unscale(scale);
            *upper = *solved;
        }
    }
    Ok(())
}

/// Makes a block orthogonal to the first `known` columns of the basis and in itself, and writes it behind them. Coefficients
/// go to the columns of `projected` that belong to it.
fn append(
    basis: &mut Mat<c64>,
    known: usize,
    block: &mut [Complex],
    size: usize,
    mut projected: Option<&mut Mat<c64>>,
    seed: &mut u64,
) {
    let one = c64::new(1.0, 0.0);
    let width = block.len() / (2 * size);
    for (index, vector) in block.chunks_exact_mut(2 * size).enumerate() {
        let count = known + index;
        let before = vector.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
        let mut is_new = true;
        let mut norm = before;
        for pass in 0..8 {
            let mut coefficients = Mat::<c64>::zeros(count, 1);
            let old = basis.as_ref().submatrix(0, 0, 2 * size, count);
            let mut column = MatMut::from_column_major_slice_mut(vector, 2 * size, 1);
            matmul(&mut coefficients, Accum::Replace, old.adjoint(), column.as_ref(), one, Par::Seq);
            matmul(&mut column, Accum::Add, old, coefficients.as_ref(), -one, Par::Seq);
            if is_new && let Some(projected) = projected.as_deref_mut() {
                for row in 0..count {
                    projected[(row, known - width + index)] += coefficients[(row, 0)];
                }
            }
            // The space is complete: what is left is rounding.
            if count >= 2 * size {
                is_new = false;
                norm = 0.0;
                break;
            }
            let after = vector.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
            if pass >= 1 && after > 0.5 * norm {
                norm = after;
                break;
            }
            norm = after;
            // Nothing new in this direction: a vector without structure goes on, uncoupled.
            if norm <= 1e-14 * before {
                is_new = false;
                vector.iter_mut().for_each(|value| *value = unstructured(seed));
            }
        }
        if is_new && let Some(projected) = projected.as_deref_mut() {
            projected[(count, known - width + index)] = c64::new(norm, 0.0);
        }
        let factor = if norm > 0.0 { 1.0 / norm } else { 0.0 };
        for (row, value) in vector.iter().enumerate() {
            basis[(row, count)] = value * factor;
        }
    }
}
