//! Expected values, standard deviations and correlation of two inputs from tests, by maximum likelihood.
//!
//! Each test draws a sample of its own. It squeals at a speed with the probability of instability `P` there, an integral
//! over the boundary of stability ([`Pair`](crate::integrate::pair::Pair)). A test that only says whether there was
//! squeal contributes `P` or `1 - P` to the likelihood. One in which the speed was lowered until squeal began
//! contributes the density `-dP / d ln v` of the speed, or `1 - P` at the lowest speed if it never did.
//!
//! Intervals are those of the profile likelihood (D. R. Cox, D. V. Hinkley, Theoretical Statistics, 1974, section 9.3):
//! all values with which the likelihood, the other parameters chosen best, is at least `exp(-q / 2)` of its maximum,
//! with the quantile `q` of the chi-squared distribution with one degree of freedom. They do not depend on how the
//! parameters are written, need no symmetry, and say where the data have no bound. The interval of a
//! [predicted probability](Fit::predict) is the same for a function of the parameters: its least and its greatest value
//! where the likelihood is that high.

mod parameter;

mod data;

mod likelihood;

mod maximum;

mod root;

mod goodness;

pub mod shares;

mod fitted;

#[cfg(test)]
mod tests;

pub use data::TestData;
pub use fitted::{Fit, FitError, FittedParameter, Prediction, fit};
pub use goodness::Goodness;
pub use likelihood::{FitModel, Unlikely};
pub use parameter::{ESTIMABLE, FitValues};
