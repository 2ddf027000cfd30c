//! Matrices as sums of terms, each a given matrix times a factor in named parameters.

use std::sync::Arc;

use faer::sparse::SparseColMat;

use super::branches::Path;
use super::factor::Factor;
use crate::model::quantity::Limits;

/// A matrix of a model, real and square.
pub type Matrix = SparseColMat<usize, f64>;

/// A matrix times a factor in parameters.
#[derive(Debug, Clone)]
pub struct Term {
    /// The matrix.
    pub matrix: Arc<Matrix>,
    /// Its factor.
    pub factor: Factor,
}

/// A named parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name in factors and jobs.
    pub name: String,
    /// Its expected value.
    pub value: f64,
    /// Its unit; `1` for a pure number.
    pub unit: String,
    /// Its name in pictures.
    pub label: String,
    /// Values that have a meaning; samples beyond are outside the model.
    pub range: Limits,
}

/// `M q'' + C(p) q' + K(p) q = 0`, with `C = sum_i c_i(p) C_i` and `K = sum_j k_j(p) K_j`.
#[derive(Debug, Clone)]
pub struct Matrices {
    /// M: symmetric and positive definite.
    pub mass: Arc<Matrix>,
    /// The terms of C.
    pub damping: Vec<Term>,
    /// The terms of K.
    pub stiffness: Vec<Term>,
    /// p, in the order in which factors know them.
    pub parameters: Vec<Parameter>,
}

impl Matrices {
    /// The number of degrees of freedom.
    #[must_use]
    pub fn size(&self) -> usize {
        self.mass.ncols()
    }

    /// The factors of the terms of C and then of K at these values of the parameters.
    #[must_use]
    pub fn coefficients(&self, parameters: &[f64]) -> Vec<f64> {
        self.damping.iter().chain(&self.stiffness).map(|term| term.factor.value(parameters)).collect()
    }

    /// The expected values of the parameters.
    #[must_use]
    pub fn expected(&self) -> Vec<f64> {
        self.parameters.iter().map(|parameter| parameter.value).collect()
    }

    /// The parameters in the factors of friction, as far as that can be told: of stiffness terms that are not symmetric; then
    /// those in any factor. By their places, some of them repeatedly.
    pub(super) fn integrated(&self) -> Vec<usize> {
        let friction = self.stiffness.iter().filter(|term| !is_symmetric(&term.matrix));
        let terms = friction.chain(&self.stiffness).chain(&self.damping);
        terms.flat_map(|term| term.factor.parameters()).collect()
    }
}

/// The largest asymmetry of a matrix, over its largest entry, that counts as rounding.
const ROUNDING: f64 = 1e-9;

/// Whether a matrix is symmetric to rounding.
#[must_use]
pub fn is_symmetric(matrix: &Matrix) -> bool {
    let [asymmetry, largest] = asymmetry(matrix);
    asymmetry <= ROUNDING * largest
}

/// The largest difference of entries across the diagonal, and the largest entry.
#[must_use]
pub fn asymmetry(matrix: &Matrix) -> [f64; 2] {
    let mut largest = [0.0_f64; 2];
    for entry in matrix.triplet_iter() {
        let across = matrix.get(entry.col, entry.row).copied().unwrap_or(0.0);
        largest = [largest[0].max((entry.val - across).abs()), largest[1].max(entry.val.abs())];
    }
    largest
}

/// The coefficients of matrices over one parameter.
pub(super) struct OverParameter<'a> {
    pub(super) matrices: &'a Matrices,
    /// The values of all parameters; that of the one counts for nothing.
    pub(super) values: &'a [f64],
    pub(super) place: usize,
}

impl Path for OverParameter<'_> {
    fn series(&self, p: f64, step: f64) -> Vec<[f64; 4]> {
        let mut values = self.values.to_vec();
        values[self.place] = p;
        let Matrices { damping, stiffness, .. } = self.matrices;
        damping.iter().chain(stiffness).map(|term| term.factor.series(&values, self.place, step)).collect()
    }
}
