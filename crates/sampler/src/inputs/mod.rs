//! Random inputs: marginal distributions and correlation.
//!
//! Input `i` is `F_i^-1(Phi(y_i))`, where `F_i` is the distribution function of its [`Marginal`] and `y = L z` are
//! normal deviates with a given [`Correlation`], made from independent ones `z` by the Cholesky factor `L`. Such inputs
//! have a Gaussian copula (R. B. Nelsen, An Introduction to Copulas, 2nd ed. 2006, section 2.3).
//!
//! Quantiles are accurate in both tails: they are computed from `Phi(z)` or from `1 - Phi(z)`, whichever is smaller. So
//! are the deviates of values ([`InputDistribution::deviate`]).

mod correlation;

mod pair_law;

mod end;

mod empirical;

mod truncation;

mod marginal;

mod absolute;

mod weibull;

mod transform;

mod deviate;

mod distribution;

mod columns;

#[cfg(test)]
mod tests;

pub use columns::InputColumns;
pub use correlation::{Correlation, CorrelationError};
pub use distribution::InputDistribution;
pub use empirical::{Empirical, EmpiricalError};
pub use end::End;
pub use marginal::{Marginal, MarginalError};
pub use pair_law::{DeviateLaw, PairLaw, PairParameter};
