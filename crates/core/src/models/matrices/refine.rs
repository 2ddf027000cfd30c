//! An approximate eigenvalue made exact.

use nalgebra::{Complex, DMatrix, DVector, LU};

use super::quadratic::Quadratic;
use super::region::magnitude;
use crate::numerics::eigenvalues::Eigenvalue;

/// Shifts that are factorised at most, and steps of inverse iteration with each.
const MOST_SHIFTS: usize = 8;
const STEPS_PER_SHIFT: usize = 6;

/// Relative change of an eigenvalue at which it has converged.
const CONVERGED: f64 = 2e-14;

/// An eigenvalue with its vectors: `Q(lambda) right = 0` and `left^T Q(lambda) = 0`.
#[derive(Debug, Clone)]
pub struct Pair {
    /// lambda.
    pub eigenvalue: Eigenvalue,
    /// The right vector, of length 1.
    pub right: DVector<Complex<f64>>,
    /// The left vector, of length 1.
    pub left: DVector<Complex<f64>>,
}

impl Pair {
    /// Refines an approximate eigenvalue and its approximate vectors by two-sided inverse iteration, with the eigenvalue
    /// by Newton steps `lambda - y^T Q(lambda) x / y^T Q'(lambda) x`, whose error is of second order in those of the
    /// vectors. `None` if it does not converge, as next to defective eigenvalues.
    #[must_use]
    pub fn refined(self, problem: &Quadratic) -> Option<Self> {
        let Self { mut eigenvalue, mut right, mut left } = self;
        for _ in 0..MOST_SHIFTS {
            let shift = eigenvalue;
            let solver = Solver::new(problem.value(shift))?;
            for _ in 0..STEPS_PER_SHIFT {
                right = unit(solver.solve(problem.derivative_times(shift, &right))?)?;
                left = unit(solver.solve_transposed(problem.transposed_derivative_times(shift, &left))?)?;
                let before = eigenvalue;
                for _ in 0..2 {
                    eigenvalue -= newton_step(problem, eigenvalue, &right, &left)?;
                }
                if magnitude(eigenvalue - before) <= CONVERGED * magnitude(eigenvalue) {
                    return Some(Self { eigenvalue, right, left });
                }
            }
        }
        None
    }
}

fn newton_step(
    problem: &Quadratic,
    at: Eigenvalue,
    right: &DVector<Complex<f64>>,
    left: &DVector<Complex<f64>>,
) -> Option<Complex<f64>> {
    let step = left.dot(&problem.value_times(at, right)) / left.dot(&problem.derivative_times(at, right));
    (step.re.is_finite() && step.im.is_finite()).then_some(step)
}

/// A vector of length 1 along this one.
fn unit(vector: DVector<Complex<f64>>) -> Option<DVector<Complex<f64>>> {
    let largest = vector.iter().map(|value| value.re.abs().max(value.im.abs())).fold(0.0, f64::max);
    if !(largest.is_finite() && largest > 0.0) {
        return None;
    }
    let scaled = vector / Complex::from(largest);
    let length = scaled.iter().map(Complex::norm_sqr).sum::<f64>().sqrt();
    Some(scaled / Complex::from(length))
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
