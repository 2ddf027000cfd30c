//! The quadratic eigenvalue problem of a model, with dense or with sparse matrices.

use std::sync::Arc;

use nalgebra::DMatrix;
use thiserror::Error as ThisError;

use super::branches::{Branches, Path};
use super::covering::Covering;
use super::dense_branches::DenseBranches;
use super::error::Error;
use super::full::along::Along;
use super::full::band::KrylovLimit;
use super::full::quadratic::{Coefficients, SparseQuadratic};
use super::quadratic::{DenseQuadratic, QuadraticError};
use super::region::Region;
use super::sweep::{Intervals, Nodes, Steps, middle};
use super::terms::{Matrices, Matrix, Term};
use crate::model::critical_values::{Memory, UnstableValues};
use crate::numerics::eigenvalues::Eigenvalue;

/// How intervals of dense matrices are divided, over which discs prove what is unstable.
const DENSE_STEPS: Steps = Steps { joined: 3, halvings: 44, most: 1000, widest_first: true };

/// How those with sparse matrices do.
const SPARSE_STEPS: Steps = Steps { joined: 3, halvings: 44, most: 75, widest_first: false };

/// Up to so many degrees of freedom critical values of sparse matrices are proved with dense ones, which takes some seconds.
const SMALL: usize = 100;

/// With which matrices eigenvalues are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Solver {
    /// Dense ones: all eigenvalues, for some hundred degrees of freedom.
    Dense,
    /// Sparse ones: those in the bands, for as many degrees of freedom as one LU factorisation can have.
    Sparse,
}

/// The problem of a model.
#[derive(Debug, Clone)]
pub enum Problem {
    /// With dense matrices.
    Dense(Arc<DenseQuadratic>),
    /// With sparse ones.
    Sparse(Arc<SparseQuadratic>),
}

/// Why there is no such problem.
#[derive(Debug, Clone, PartialEq, ThisError)]
pub enum ProblemError {
    /// Of dense matrices.
    #[error(transparent)]
    Dense(#[from] QuadraticError),
    /// Of sparse matrices.
    #[error(transparent)]
    Sparse(#[from] Error),
}

impl Problem {
    /// The problem of these matrices.
    ///
    /// # Errors
    /// As [`DenseQuadratic::new`] and [`SparseQuadratic::new`].
    pub fn new(matrices: &Matrices, solver: Solver) -> Result<Self, ProblemError> {
        let Matrices { mass, damping, stiffness, .. } = matrices;
        match solver {
            Solver::Dense => {
                let terms = |terms: &[Term]| terms.iter().map(|term| dense(&term.matrix)).collect::<Vec<_>>();
                let typical = matrices.coefficients(&matrices.expected());
                let problem = DenseQuadratic::new(&dense(mass), &terms(damping), &terms(stiffness), &typical)?;
                Ok(Self::Dense(Arc::new(problem)))
            }
            Solver::Sparse => {
                let terms = |terms: &[Term]| terms.iter().map(|term| (*term.matrix).clone()).collect::<Vec<_>>();
                Ok(Self::Sparse(Arc::new(SparseQuadratic::new(mass, &terms(damping), &terms(stiffness))?)))
            }
        }
    }

    /// The problem without its rigid-body motions, and these, as displacements of all degrees of freedom. Those of sparse
    /// matrices stay.
    #[must_use]
    pub fn without_rigid_body_motions(self) -> (Self, Vec<Vec<f64>>) {
        let Self::Dense(problem) = self else { return (self, Vec::new()) };
        let (rest, motions) = Arc::unwrap_or_clone(problem).without_rigid_body_motions();
        (Self::Dense(Arc::new(rest)), motions.into_iter().map(|motion| motion.data.into()).collect())
    }

    /// rad/s of the unit of frequency in which its own eigenvalues are.
    #[must_use]
    pub fn unit(&self) -> f64 {
        match self {
            Self::Dense(problem) => problem.unit(),
            Self::Sparse(_) => 1.0,
        }
    }

    /// Eigenvalues with these coefficients that are not below the real axis, in rad/s: all with dense matrices, with sparse
    /// ones those in the bands of the regions with damping ratios from -0.99 to 0.05 above their thresholds.
    ///
    /// # Errors
    /// [`Error`], if they are not found.
    pub fn eigenvalues(&self, coefficients: &[f64], regions: &[Region]) -> Result<Vec<Eigenvalue>, Error> {
        match self {
            Self::Dense(problem) => {
                let not_converged = |_| Error::NotConverged { re: f64::NAN, im: f64::NAN };
                let values = problem.at(coefficients).eigenvalues().map_err(not_converged)?;
                Ok(values.into_iter().filter(|value| value.im >= 0.0).map(|value| value * problem.unit()).collect())
            }
            Self::Sparse(problem) => {
                let point = problem.at(&Coefficients::split(coefficients, problem.damping_terms()))?;
                let mut values = Vec::new();
                for region in regions {
                    let pairs = point.pairs_about(region, KrylovLimit::default())?;
                    values.extend(pairs.into_iter().map(|pair| pair.eigenvalue));
                }
                Ok(values)
            }
        }
    }

    /// The values of the parameter of a path between the first and the last of some places at which there is an unstable
    /// eigenvalue of a region, in rad/s; `None` if `memory` ends the search or pairs are not found.
    pub fn unstable_values(
        &self,
        path: &dyn Path,
        region: &Region,
        places: &[f64],
        memory: &dyn Memory,
    ) -> Option<UnstableValues> {
        // In a band from 0 real eigenvalues count, which are not looked for with sparse matrices.
        let is_small = |problem: &SparseQuadratic| problem.size() <= SMALL && region.lowest > 0.0;
        let dense = match self {
            Self::Dense(problem) => Some(Arc::clone(problem)),
            Self::Sparse(problem) if is_small(problem) => {
                let typical = path.coefficients(middle(*places.first()?, *places.last()?));
                problem.dense(&typical).ok().map(Arc::new)
            }
            Self::Sparse(_) => None,
        };
        let search = |intervals: &mut dyn Intervals, steps| intervals.unstable_values(places, steps, memory);
        match dense {
            Some(problem) => search(&mut Covering::new(&problem, path, &region.in_unit(problem.unit())), DENSE_STEPS),
            None => search(&mut Nodes::new(&*self.along(path), region), SPARSE_STEPS),
        }
    }

    /// Its pairs along a path, in its own unit.
    pub(super) fn along<'a>(&'a self, path: &'a dyn Path) -> Box<dyn Branches + 'a> {
        match self {
            Self::Dense(problem) => Box::new(DenseBranches { problem, path }),
            Self::Sparse(matrices) => Box::new(Along { matrices, path, limit: KrylovLimit::default() }),
        }
    }
}

fn dense(matrix: &Matrix) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(matrix.nrows(), matrix.ncols());
    for entry in matrix.triplet_iter() {
        dense[(entry.row, entry.col)] += *entry.val;
    }
    dense
}

#[cfg(test)]
mod tests {
    use faer::sparse::Triplet;

    use super::*;
    use crate::model::critical_values::NoMemory;

    fn diagonal(entries: [f64; 2]) -> Matrix {
        let entries = [0, 1].map(|i| Triplet::new(i, i, entries[i]));
        Matrix::try_new_from_triplets(2, 2, &entries).unwrap()
    }

    /// The damping of the first of two modes is `(p - 0.3)^2 - width^2`.
    struct Window {
        width: f64,
    }

    impl Path for Window {
        fn series(&self, p: f64, _: f64) -> Vec<[f64; 4]> {
            let from = p - 0.3;
            vec![[(from - self.width) * (from + self.width), 2.0 * from, 1.0, 0.0], [1.0, 0.0, 0.0, 0.0]]
        }
    }

    #[test]
    fn narrow_windows_of_small_sparse_matrices_are_not_missed() {
        let (damping, stiffness) = (diagonal([1.0, 0.0]), diagonal([1.0, 4.0]));
        let problem = SparseQuadratic::new(&diagonal([1.0, 1.0]), &[damping], &[stiffness]).unwrap();
        let problem = Problem::Sparse(Arc::new(problem));
        for (band, is_in) in [([0.5, 1.5], true), ([1.5, 2.5], false)] {
            let region = Region { lowest: band[0], highest: band[1], damping_ratio: 0.0 };
            for width in [0.01, 1e-3] {
                let path = Window { width };
                let found = problem.unstable_values(&path, &region, &[-2.0, 0.0, 2.0], &NoMemory).unwrap();
                // A damping ratio counts from 1e-9 below zero on, which is half of the damping.
                let half = (width * width - 2e-9).sqrt();
                let expected = if is_in { vec![[0.3 - half, 0.3 + half]] } else { Vec::new() };
                for intervals in [&found.surely, &found.possibly] {
                    assert_eq!(intervals.len(), expected.len(), "{width} {band:?}: {found:?}");
                }
                for ([from, to], [low, high]) in found.surely.iter().chain(&found.possibly).zip(expected.iter().cycle())
                {
                    assert!((from - low).abs() < 1e-9 && (to - high).abs() < 1e-9, "{width}: {found:?} {expected:?}");
                }
            }
        }
    }
}
