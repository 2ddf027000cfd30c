//! Deviates from probabilities, and beyond the ends of distributions.

use crate::special_functions::normal;

/// Which of the deviates at which a distribution has a value: those of measured values that are equal fill an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The least, above which the input is at least that value.
    Least,
    /// The greatest, above which the input exceeds that value.
    Greatest,
}

/// The deviate with these probabilities below and above it.
pub(super) fn at_tails(lower: f64, upper: f64) -> f64 {
    if lower <= 0.0 || upper <= 0.0 {
        beyond(lower <= 0.0)
    } else if lower < upper {
        normal::quantile(lower)
    } else {
        -normal::quantile(upper)
    }
}

/// The deviate below the distribution, or above it.
pub(super) fn beyond(is_below: bool) -> f64 {
    if is_below { f64::NEG_INFINITY } else { f64::INFINITY }
}
