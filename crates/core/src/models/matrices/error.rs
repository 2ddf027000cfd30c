//! What can go wrong.

use thiserror::Error;

/// Why eigenpairs could not be computed.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum Error {
    /// A matrix has another size than the mass matrix.
    #[error("a matrix is {rows} by {columns}, but the mass matrix has {size} rows")]
    Size {
        /// Its rows.
        rows: usize,
        /// Its columns.
        columns: usize,
        /// The rows of the mass matrix.
        size: usize,
    },
    /// A matrix or a coefficient contains NaN or an infinity.
    #[error("a matrix or a coefficient is not a finite number")]
    NotFinite,
    /// There are other numbers of coefficients than of matrices.
    #[error("there are {given} coefficients for {expected} matrices")]
    Coefficients {
        /// How many coefficients there are.
        given: usize,
        /// How many matrices.
        expected: usize,
    },
    /// The matrix at a shift could not be factorised.
    #[error("the matrix at {re} + {im}i could not be factorised")]
    Singular {
        /// Real part of the shift.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// There is not enough memory for a factorisation.
    #[error("not enough memory for a factorisation of {size} degrees of freedom")]
    Memory {
        /// The size of the matrices.
        size: usize,
    },
    /// An iteration did not converge.
    #[error("the eigenpair near {re} + {im}i did not converge")]
    NotConverged {
        /// Real part of the last iterate.
        re: f64,
        /// Imaginary part.
        im: f64,
    },
    /// A band or a limit makes no sense.
    #[error("{0}")]
    Request(&'static str),
}
