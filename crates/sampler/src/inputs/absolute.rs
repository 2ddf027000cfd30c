//! Distributions with a standard deviation that is not relative to the expected value.

use super::marginal::{Marginal, MarginalError};

/// A distribution as a shifted one: its values are those with this expected value and relative standard deviation, plus
/// `shift`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shifted {
    pub expected: f64,
    pub relative_std: f64,
    pub shift: f64,
}

impl Marginal {
    /// A relative standard deviation for which the distribution exists, if any shift of it is a distribution of the
    /// same kind.
    fn shiftable(&self) -> Option<f64> {
        match self {
            Self::Normal | Self::TruncatedNormal { .. } => Some(1.0),
            Self::Uniform | Self::Gumbel => Some(0.5),
            Self::Triangular { .. } => Some(0.2),
            Self::Lognormal | Self::Weibull | Self::Beta { .. } | Self::Empirical(_) => None,
        }
    }

    /// The distribution with this expected value and standard deviation.
    pub(super) fn shifted(&self, expected: f64, std: f64) -> Shifted {
        match self.shiftable() {
            Some(relative_std) => {
                let scale = std / relative_std;
                Shifted { expected: scale, relative_std, shift: expected - scale }
            }
            None => Shifted { expected, relative_std: std / expected, shift: 0.0 },
        }
    }

    /// Whether the distribution exists with this expected value and this standard deviation, which is not relative to
    /// it. Normal, uniform, Gumbel, triangular and truncated normal distributions do with any expected value; the
    /// others, which have positive values only, with positive ones.
    ///
    /// # Errors
    /// [`MarginalError`] if it does not.
    pub fn check_absolute(&self, expected: f64, std: f64) -> Result<(), MarginalError> {
        match self.shiftable() {
            _ if !(std >= 0.0 && std.is_finite()) => Err(MarginalError::Std { value: std }),
            Some(relative_std) => self.check_scatter(relative_std),
            None => self.check(expected, std / expected),
        }
    }

    /// Mean and standard deviation, as [`Marginal::moments`], with a standard deviation that is not relative.
    #[must_use]
    pub fn absolute_moments(&self, expected: f64, std: f64) -> (f64, f64) {
        let Shifted { expected, relative_std, shift } = self.shifted(expected, std);
        let (mean, std) = self.moments(expected, relative_std);
        (mean + shift, std)
    }
}
