//! Changes in the basis of modes that are kept and others, and what they make.

use nalgebra::Complex;

use super::super::fast_basis::ComplexMat;

/// What changes make of the modes.
pub(super) struct Changed {
    /// What they add to the matrix that remains, by rows.
    pub(super) entries: Vec<Complex<f64>>,
    /// A bound of rho.
    pub(super) norm: f64,
    /// `|e / sqrt(g)|`.
    pub(super) rows: Vec<f64>,
    /// b.
    pub(super) columns: Vec<f64>,
    /// `|y_0 sqrt(g)|` and `|y_0 / sqrt(g)|`.
    pub(super) first: [Vec<f64>; 2],
    /// The same of `y_1`.
    pub(super) second: [Vec<f64>; 2],
}

/// Changes in the basis of all modes, those that are kept first.
pub(super) struct Modes<'a> {
    pub(super) changes: &'a [ComplexMat],
    /// How many are kept.
    pub(super) kept: usize,
    /// `sqrt(g)`, and one over it.
    pub(super) roots: Vec<f64>,
    pub(super) inverse_roots: Vec<f64>,
    /// `1 / (s_i - lambda_r)`.
    pub(super) inverse_gaps: ComplexMat,
}

impl Modes<'_> {
    /// Operations that a sample takes with polynomials, nearly, and without.
    pub(super) fn work(&self) -> [f64; 2] {
        let [count, kept, others] = [self.changes.len(), self.kept, self.roots.len()].map(|number| number as f64);
        let all = kept + others;
        let of_two = 0.5 * count * (count + 1.0);
        let of_three = of_two * (count + 2.0) / 3.0;
        let of_four = 0.5 * of_two * (of_two + 1.0);
        let forms = 2.0 * kept * (4.0 * of_two + 2.0 * of_four) + 2.0 * of_two * of_two;
        let products = 8.0 * kept * others * (others + kept);
        [4.0 * kept * kept * (count + of_two + of_three) + forms, 4.0 * count * all * all + products]
    }
}

/// Whether a bound of rho is one of something regular.
pub(super) fn is_regular(norm: f64) -> bool {
    norm < 1.0
}
