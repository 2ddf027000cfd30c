//! An approximate eigenvalue made exact.

use nalgebra::{Complex, DMatrix, DVector, LU};

use super::pair::{Pair, norm, normalise, root_near};
use super::quadratic::Quadratic;
use super::region::magnitude;
use crate::numerics::eigenvalues::Eigenvalue;

/// Shifts that are factorised at most, and steps of inverse iteration with each.
const MOST_SHIFTS: usize = 8;
const STEPS_PER_SHIFT: usize = 6;

/// Relative change of an eigenvalue at which it has converged.
const CONVERGED: f64 = 2e-14;

/// Relative rounding with which an eigenvalue is taken for exact.
const MOST_ROUNDING: f64 = 1e-10;

/// The rounding of eigenvalues, in parts of the matrices seen through the vectors of a pair.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

impl Quadratic {
    /// Refines an approximate eigenvalue and its approximate vectors by two-sided inverse iteration, with the eigenvalue
    /// from `y^T Q(lambda) x = 0`, whose error is of second order in those of the vectors. `None` if it does not converge, as next to defective eigenvalues.
    #[must_use]
    pub fn refine(&self, start: Pair) -> Option<Pair> {
        let mut eigenvalue = start.eigenvalue;
        let (mut right, mut left) = (DVector::from_vec(start.right), DVector::from_vec(start.left));
        for _ in 0..MOST_SHIFTS {
            let shift = eigenvalue;
            let solver = Solver::new(self.value(shift))?;
            for _ in 0..STEPS_PER_SHIFT {
                right = unit(solver.solve(self.derivative_times(shift, &right))?)?;
                left = unit(solver.solve_transposed(self.transposed_derivative_times(shift, &left))?)?;
                let before = eigenvalue;
                let slope;
                (eigenvalue, slope) = root_near(eigenvalue, self.forms(&left, &right))?;
                let (change, size) = (magnitude(eigenvalue - before), magnitude(eigenvalue));
                if change <= MOST_ROUNDING * size {
                    let pair = self.pair(eigenvalue, slope, right.clone(), &left);
                    if change <= (CONVERGED * size).max(pair.error) {
                        return (pair.error <= MOST_ROUNDING * size).then_some(pair);
                    }
                }
            }
        }
        None
    }

    /// A pair of these vectors, scaled as those of pairs are; `slope` is `y^T Q'(lambda) x`.
    pub(super) fn pair(
        &self,
        eigenvalue: Eigenvalue,
        slope: Complex<f64>,
        mut right: DVector<Complex<f64>>,
        left: &DVector<Complex<f64>>,
    ) -> Pair {
        let scale = slope / norm(right.as_slice());
        normalise(right.as_mut_slice());
        let size = magnitude(eigenvalue);
        let entries = size * size + size * self.damping.amax() + self.stiffness.amax();
        let left: Vec<Complex<f64>> = left.iter().map(|value| value / scale).collect();
        let right: Vec<Complex<f64>> = right.data.into();
        let error = ROUNDING * (entries * norm(&left) + size);
        Pair { eigenvalue, right, left, error }
    }
}

/// A vector of length 1 along this one.
fn unit(mut vector: DVector<Complex<f64>>) -> Option<DVector<Complex<f64>>> {
    let largest = vector.iter().map(|value| value.re.abs().max(value.im.abs())).fold(0.0, f64::max);
    if !(largest.is_finite() && largest > 0.0) {
        return None;
    }
    vector.iter_mut().for_each(|value| *value = value.unscale(largest));
    normalise(vector.as_mut_slice());
    Some(vector)
}

/// Solves with a factorised matrix and with its transpose.
struct Solver {
    lu: LU<Complex<f64>, nalgebra::Dyn, nalgebra::Dyn>,
    lower: DMatrix<Complex<f64>>,
    upper: DMatrix<Complex<f64>>,
}

impl Solver {
    /// `None` if the matrix is not finite. A pivot of zero, where the shift is an eigenvalue in every digit, is replaced by
    /// the rounding of the largest: inverse iteration then finds the vector at once.
    fn new(matrix: DMatrix<Complex<f64>>) -> Option<Self> {
        let largest = matrix.iter().map(|value| value.re.abs().max(value.im.abs())).fold(0.0, f64::max);
        if !largest.is_finite() || matrix.iter().any(|value| value.re.is_nan() || value.im.is_nan()) {
            return None;
        }
        let lu = LU::new(matrix);
        let (lower, mut upper) = (lu.l(), lu.u());
        let least = (largest * f64::EPSILON).max(f64::MIN_POSITIVE);
        for i in 0..upper.nrows() {
            if magnitude(upper[(i, i)]) < least {
                upper[(i, i)] = Complex::from(least);
            }
        }
        Some(Self { lu, lower, upper })
    }

    fn solve(&self, mut of: DVector<Complex<f64>>) -> Option<DVector<Complex<f64>>> {
        self.lu.p().permute_rows(&mut of);
        let solved = self.lower.solve_lower_triangular_mut(&mut of) && self.upper.solve_upper_triangular_mut(&mut of);
        solved.then_some(of)
    }

    fn solve_transposed(&self, mut of: DVector<Complex<f64>>) -> Option<DVector<Complex<f64>>> {
        let solved =
            self.upper.tr_solve_upper_triangular_mut(&mut of) && self.lower.tr_solve_lower_triangular_mut(&mut of);
        self.lu.p().inv_permute_rows(&mut of);
        solved.then_some(of)
    }
}
