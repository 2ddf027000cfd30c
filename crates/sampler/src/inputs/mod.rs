//! Random inputs: what standard normal deviates become, and how they are correlated.
//!
//! Input `i` is `F_i^-1(Phi(y_i))`, where `F_i` is the distribution function of its [`Marginal`] and `y = L z` are
//! normal deviates with a given [`Correlation`], made from independent ones `z` by the Cholesky factor `L`. Inputs
//! joined in this way have a Gaussian copula (R. B. Nelsen, An Introduction to Copulas, 2nd ed. 2006, section 2.3).
//!
//! Quantiles keep their digits in both tails: they start from `Phi(z)` or from `1 - Phi(z)`, whichever is small.

mod columns;
mod correlation;
mod empirical;
mod marginal;
mod transform;
mod truncation;
mod weibull;

#[cfg(test)]
mod tests;

pub use columns::InputColumns;
pub use correlation::{Correlation, CorrelationError};
pub use empirical::{Empirical, EmpiricalError};
pub use marginal::{Marginal, MarginalError};
