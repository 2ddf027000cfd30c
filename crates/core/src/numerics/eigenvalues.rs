//! Eigenvalues of a general real matrix, computed so that nothing can hang or fail unseen.
//!
//! This is the oracle that closed forms are tested against, and the way to eigenvalues where no closed form
//! exists.

use faer::MatRef;
use nalgebra::linalg::balancing::balance_parlett_reinsch;
use nalgebra::{Complex, DMatrix};
use thiserror::Error;

use super::schur::{SWEEPS_PER_ROW, eigenvalues_of, power_of_two_near, real_schur};

/// What the sum of eigenvalues may differ by from the trace, over the norm of the matrix.
const TRACE: f64 = 1e-10;

/// One eigenvalue; its real part is a growth rate, its imaginary part an angular frequency.
pub type Eigenvalue = Complex<f64>;

/// Why eigenvalues could not be computed.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EigenvalueError {
    /// The matrix contains NaN or an infinity.
    #[error("the matrix has an entry that is not a finite number (row {row}, column {column})")]
    NotFinite {
        /// Row of the first such entry.
        row: usize,
        /// Column of the first such entry.
        column: usize,
    },
    /// The QR iteration reached its cap.
    #[error("the eigenvalue iteration did not converge within {sweeps} sweeps")]
    NotConverged {
        /// The cap.
        sweeps: usize,
    },
}

/// The eigenvalues of a square matrix, sorted by falling real part, then by falling imaginary part.
///
/// The matrix is scaled by a power of two and balanced (Parlett and Reinsch), both exact in floating point, and
/// then reduced to real Schur form.
///
/// # Errors
/// [`EigenvalueError::NotFinite`] and [`EigenvalueError::NotConverged`].
///
/// # Panics
/// If the matrix is not square.
///
/// ```
/// use nalgebra::dmatrix;
/// let rotation = dmatrix![0.0, -2.0; 2.0, 0.0];
/// let values = stickslip_core::numerics::eigenvalues::eigenvalues(&rotation)?;
/// assert_eq!((values[0].re, values[0].im, values[1].im), (0.0, 2.0, -2.0));
/// # Ok::<(), stickslip_core::numerics::eigenvalues::EigenvalueError>(())
/// ```
pub fn eigenvalues(matrix: &DMatrix<f64>) -> Result<Vec<Eigenvalue>, EigenvalueError> {
    let Some((scaled, scale)) = balanced(matrix)? else {
        return Ok(vec![Eigenvalue::new(0.0, 0.0); matrix.nrows()]);
    };
    let not_converged = EigenvalueError::NotConverged { sweeps: SWEEPS_PER_ROW * matrix.nrows() };
    let (_, triangle) = real_schur(&scaled).ok_or(not_converged)?;
    let mut values: Vec<Eigenvalue> = eigenvalues_of(&triangle).into_iter().map(|value| value * scale).collect();
    values.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
    Ok(values)
}

/// The eigenvalues of a square matrix in any order, three times faster than [`eigenvalues`] for large ones, but with last bits
/// that depend on the processor: for what does not rest on these. With them the size of the balanced matrix, in the unit of
/// the eigenvalues, to which their errors are relative. `None` where they cannot be computed.
#[must_use]
pub fn fast_eigenvalues(matrix: &DMatrix<f64>) -> Option<(Vec<Eigenvalue>, f64)> {
    let (scaled, scale) = balanced(matrix).ok()??;
    let entries = MatRef::from_column_major_slice(scaled.as_slice(), scaled.nrows(), scaled.ncols());
    let values = entries.eigenvalues().ok()?;
    // The trace shows whether the iteration, which does not say so, came to its end; it is not a number where a value is none.
    let norm = scaled.norm();
    let off = values.iter().map(|value| value.re).sum::<f64>() - scaled.trace();
    let imaginary = values.iter().map(|value| value.im).sum::<f64>();
    let is_right = off.abs().max(imaginary.abs()) <= TRACE * norm && !imaginary.is_nan();
    let values = values.into_iter().map(|value| Eigenvalue::new(value.re, value.im) * scale).collect();
    is_right.then_some((values, norm * scale))
}

/// A matrix that is scaled by a power of two and balanced, and the power; nothing for one of zeros.
fn balanced(matrix: &DMatrix<f64>) -> Result<Option<(DMatrix<f64>, f64)>, EigenvalueError> {
    for column in 0..matrix.ncols() {
        for row in 0..matrix.nrows() {
            if !matrix[(row, column)].is_finite() {
                return Err(EigenvalueError::NotFinite { row, column });
            }
        }
    }
    let largest = matrix.amax();
    if largest == 0.0 {
        return Ok(None);
    }
    let scale = power_of_two_near(largest);
    let mut scaled = matrix / scale;
    balance_parlett_reinsch(&mut scaled);
    Ok(Some((scaled, scale)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::dmatrix;

    #[test]
    fn a_matrix_that_defeats_an_uncapped_iteration_ends() {
        // Companion matrix of x^4 + 1: eigenvalues are the primitive eighth roots of one.
        let companion = dmatrix![
            0.0, 0.0, 0.0, -1.0;
            1.0, 0.0, 0.0, 0.0;
            0.0, 1.0, 0.0, 0.0;
            0.0, 0.0, 1.0, 0.0
        ];
        for value in eigenvalues(&companion).unwrap() {
            assert!((value.re.abs() - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12, "{value}");
            assert!((value.im.abs() - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12, "{value}");
        }
    }

    #[test]
    fn fast_eigenvalues_are_the_same_up_to_rounding() {
        for size in [2, 3, 17, 80, 150] {
            let mut state = size as u64;
            let matrix = DMatrix::from_fn(size, size, |row, column| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let number = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
                number * 10_f64.powi((row % 5) as i32 - (column % 5) as i32)
            });
            let exact = eigenvalues(&matrix).unwrap();
            let (fast, norm) = fast_eigenvalues(&matrix).unwrap();
            assert_eq!(fast.len(), size);
            for value in exact {
                let nearest = fast.iter().map(|other| (other - value).norm()).fold(f64::INFINITY, f64::min);
                assert!(nearest < 1e-11 * norm, "{size}: {value} {nearest} {norm}");
            }
        }
        assert_eq!(fast_eigenvalues(&DMatrix::from_element(2, 2, f64::NAN)), None);
    }

    #[test]
    fn bad_entries_are_named() {
        let mut matrix = DMatrix::identity(3, 3);
        matrix[(2, 1)] = f64::NAN;
        assert_eq!(eigenvalues(&matrix), Err(EigenvalueError::NotFinite { row: 2, column: 1 }));
    }

    #[test]
    fn badly_scaled_matrices_keep_their_small_eigenvalues() {
        // Similar to diag(1, 2, 3) by diag(1, 1e8, 1e-8).
        let d = [1.0, 1e8, 1e-8];
        let base = dmatrix![1.0, 0.5, 0.25; 0.0, 2.0, 0.5; 0.0, 0.0, 3.0];
        let rotated = {
            let basis = dmatrix![1.0, 2.0, 0.0; 0.0, 1.0, 3.0; 1.0, 0.0, 1.0];
            let inverse = basis.clone().try_inverse().unwrap();
            basis * base * inverse
        };
        let scaled = DMatrix::from_fn(3, 3, |i, j| rotated[(i, j)] * d[i] / d[j]);
        let values = eigenvalues(&scaled).unwrap();
        for (value, expected) in values.iter().zip([3.0, 2.0, 1.0]) {
            assert!((value.re - expected).abs() < 1e-10 && value.im.abs() < 1e-10, "{value} {expected}");
        }
    }

    /// Entries from 1e-300 to 1e300 in one matrix: what is small beside the balanced matrix is lost, and nothing else.
    #[test]
    fn entries_over_the_whole_range_of_numbers_have_the_trace_of_the_matrix() {
        let mut state = 3_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for case in 0..60 {
            let size = 2 + case % 7;
            let matrix = DMatrix::from_fn(size, size, |_, _| next() * 10_f64.powi((300.0 * next()) as i32));
            let (balanced, scale) = balanced(&matrix).unwrap().unwrap();
            let values = eigenvalues(&matrix).unwrap();
            assert_eq!(values.len(), size);
            let sum = values.iter().map(|value| value / scale).sum::<Eigenvalue>();
            assert!((sum - balanced.trace()).norm() <= 1e-13 * balanced.norm(), "{matrix}");
        }
    }

    #[test]
    fn the_zero_matrix_has_zero_eigenvalues() {
        assert_eq!(eigenvalues(&DMatrix::zeros(2, 2)).unwrap(), vec![Eigenvalue::new(0.0, 0.0); 2]);
    }
}
