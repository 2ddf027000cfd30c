//! The matrix that remains, and the norms of what is left out, from the sum of the changes.
//!
//! Rho is bounded by the root of the sum of squares of G, and by that of the largest sum of moduli of a row times that of a column.

use faer::{Mat, MatRef};
use nalgebra::Complex;

use super::super::boundary::length;
use super::super::fast_basis::ComplexMat;
use super::changed::{Changed, Modes, is_regular};

/// The rounding of a sum, in parts of its terms, and more.
const ROUNDING: f64 = 1e-12;

pub(super) struct Direct {
    /// E of each change, by columns.
    changes: Vec<Vec<Complex<f64>>>,
    kept: usize,
    roots: Vec<f64>,
    inverse_roots: Vec<f64>,
    inverse_gaps: ComplexMat,
    /// The bound of rho for a unit of each change.
    norms: Vec<f64>,
}

impl Direct {
    pub(super) fn new(modes: &Modes<'_>) -> Self {
        let kept = modes.kept;
        let norm = |change: &ComplexMat| norm(change.get(kept.., kept..), &modes.inverse_roots);
        let by_columns = |change: &ComplexMat| change.col_iter().flat_map(|column| column.iter().copied()).collect();
        Self {
            norms: modes.changes.iter().map(norm).collect(),
            changes: modes.changes.iter().map(by_columns).collect(),
            kept,
            roots: modes.roots.clone(),
            inverse_roots: modes.inverse_roots.clone(),
            inverse_gaps: modes.inverse_gaps.clone(),
        }
    }

    pub(super) fn numbers(&self) -> usize {
        self.changes.iter().map(|change| 2 * change.len()).sum()
    }

    pub(super) fn norm(&self, changes: &[f64]) -> f64 {
        self.norm_of(self.matrix(&self.sum(changes)), changes)
    }

    /// The same for what these changes add up to, and for its rounding.
    fn norm_of(&self, sum: MatRef<'_, Complex<f64>>, changes: &[f64]) -> f64 {
        let each = changes.iter().zip(&self.norms).map(|(change, norm)| change.abs() * norm);
        norm(sum.get(self.kept.., self.kept..), &self.inverse_roots) + ROUNDING * each.sum::<f64>()
    }

    /// E by columns.
    fn sum(&self, changes: &[f64]) -> Vec<Complex<f64>> {
        let all = self.kept + self.roots.len();
        let mut sum = vec![Complex::from(0.0); all * all];
        for (change, factor) in self.changes.iter().zip(changes).filter(|(_, factor)| **factor != 0.0) {
            sum.iter_mut().zip(change).for_each(|(sum, entry)| *sum += entry * factor);
        }
        sum
    }

    fn matrix<'a>(&self, sum: &'a [Complex<f64>]) -> MatRef<'a, Complex<f64>> {
        let all = self.kept + self.roots.len();
        MatRef::from_column_major_slice(sum, all, all)
    }

    /// What changes make, where rho is below 1.
    pub(super) fn after(&self, changes: &[f64]) -> Option<Changed> {
        let sum = self.sum(changes);
        let all = self.matrix(&sum);
        let kept = self.kept;
        let norm = self.norm_of(all, changes);
        if !is_regular(norm) {
            return None;
        }
        let (rows, columns) = (all.get(..kept, kept..), all.get(kept.., ..kept));
        let over_gaps = |rows: MatRef<'_, Complex<f64>>| {
            Mat::from_fn(kept, self.roots.len(), |i, r| rows[(i, r)] * self.inverse_gaps[(i, r)])
        };
        let first = over_gaps(rows);
        let second = over_gaps((&first * all.get(kept.., kept..)).as_ref());
        let eliminated = (&first + &second) * columns;
        let entry = |place: usize| {
            let (i, j) = (place / kept, place % kept);
            all[(i, j)] + eliminated[(i, j)]
        };
        let both = |rows: &ComplexMat| [&self.roots, &self.inverse_roots].map(|factors| norms(rows.as_ref(), factors));
        Some(Changed {
            entries: (0..kept * kept).map(entry).collect(),
            norm,
            rows: norms(rows, &self.inverse_roots),
            columns: norms(columns.transpose(), &self.inverse_roots),
            first: both(&first),
            second: both(&second),
        })
    }
}

/// The bound of rho for an E_RR.
fn norm(others: MatRef<'_, Complex<f64>>, inverse_roots: &[f64]) -> f64 {
    let mut rows = vec![0.0; inverse_roots.len()];
    let (mut largest_column, mut squares) = (0.0, 0.0);
    for (column, inverse_root) in others.col_iter().zip(inverse_roots) {
        let mut sum = 0.0;
        for ((row, entry), other_root) in rows.iter_mut().zip(column.iter()).zip(inverse_roots) {
            let part = length(*entry) * inverse_root * other_root;
            sum += part;
            squares += part * part;
            *row += part;
        }
        largest_column = larger(largest_column, sum);
    }
    let largest_row = rows.into_iter().fold(0.0, larger);
    if largest_column * largest_row < squares { (largest_column * largest_row).sqrt() } else { squares.sqrt() }
}

/// The norms of rows whose entries are multiplied by factors.
fn norms(rows: MatRef<'_, Complex<f64>>, factors: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; rows.nrows()];
    for (column, factor) in rows.col_iter().zip(factors) {
        sums.iter_mut().zip(column.iter()).for_each(|(sum, entry)| *sum += entry.norm_sqr() * (factor * factor));
    }
    sums.into_iter().map(f64::sqrt).collect()
}

/// The larger of two numbers, or NaN if one is.
fn larger(one: f64, other: f64) -> f64 {
    if one.is_nan() || other <= one { one } else { other }
}
