//! The distribution of measured values.

use std::sync::Arc;

use thiserror::Error;

use super::end::{End, at_tails, beyond};
use crate::special_functions::normal;

/// The distribution of measured values.
///
/// Its quantile function joins the sorted values `x_1 ... x_n` by straight lines, `x_i` at the probability `(i - 1/2) /
/// n`, and is constant beyond the first and the last (definition 5 of R. J. Hyndman, Y. Fan, Sample quantiles in
/// statistical packages, The American Statistician 50 (1996) 361-365; `method="hazen"` of NumPy). No input lies outside
/// the measured range, and the mean is that of the values. The variance is that of the values, `sum of (x_i - mean)^2 /
/// n`, minus `sum of (x_(i+1) - x_i)^2 / (6 n)` for the straight lines.
#[derive(Debug, Clone, PartialEq)]
pub struct Empirical {
    /// Sorted.
    values: Arc<[f64]>,
    mean: f64,
    relative_std: f64,
}

/// Why values do not define the distribution of an input.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum EmpiricalError {
    /// No value or one.
    #[error("there are too few values ({count}); a distribution takes at least 2")]
    TooFew {
        /// The number of values.
        count: usize,
    },
    /// An infinite value or NaN.
    #[error("{value} is not a finite number")]
    NotFinite {
        /// The value.
        value: f64,
    },
    /// All values are equal.
    #[error("all values are {value}; they must differ, or the input does not scatter")]
    AllEqual {
        /// The value.
        value: f64,
    },
    /// Values that cannot be scaled to a positive expected value.
    #[error("the mean of the values is {mean}; it must be positive, since they are scaled to the expected value")]
    Mean {
        /// The mean.
        mean: f64,
    },
}

impl Empirical {
    /// The distribution of values, in any order.
    ///
    /// # Errors
    /// [`EmpiricalError`] if there are fewer than two, if one is not finite, if all are equal, or if their mean is not
    /// positive.
    ///
    /// ```
    /// use stickslip_sampler::inputs::{Empirical, Marginal};
    /// let measured = Marginal::Empirical(Empirical::new(&[0.5, 0.3, 0.4])?);
    /// // The median of the values over their mean, times the expected value.
    /// assert!((measured.value(2.0, 0.0, 0.0) - 2.0).abs() < 1e-15);
    /// # Ok::<(), stickslip_sampler::inputs::EmpiricalError>(())
    /// ```
    pub fn new(values: &[f64]) -> Result<Self, EmpiricalError> {
        if let Some(&value) = values.iter().find(|value| !value.is_finite()) {
            return Err(EmpiricalError::NotFinite { value });
        }
        let count = values.len();
        let mut values = values.to_vec();
        values.sort_by(f64::total_cmp);
        let (&[first, ..], &[_, .., last]) = (&values[..], &values[..]) else {
            return Err(EmpiricalError::TooFew { count });
        };
        if first == last {
            return Err(EmpiricalError::AllEqual { value: first });
        }
        let n = count as f64;
        let mean = values.iter().map(|value| value / n).sum::<f64>();
        if mean <= 0.0 {
            return Err(EmpiricalError::Mean { mean });
        }
        // Divided by the mean, so that no square overflows.
        let square = |difference: f64| (difference / mean) * (difference / mean);
        let scatter: f64 = values.iter().map(|value| square(value - mean)).sum();
        let steps: f64 = values.windows(2).map(|pair| square(pair[1] - pair[0])).sum();
        let relative_std = ((scatter - steps / 6.0) / n).sqrt();
        if !relative_std.is_finite() {
            return Err(EmpiricalError::Mean { mean });
        }
        Ok(Self { values: values.into(), mean, relative_std })
    }

    /// The values, sorted.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Standard deviation over mean.
    #[must_use]
    pub fn relative_std(&self) -> f64 {
        self.relative_std
    }

    /// The quantile at `Phi(z)`, over the mean.
    pub(super) fn quantile(&self, z: f64) -> f64 {
        let last = self.values.len() - 1;
        // Counted from 0: value i is at the probability (i + 1/2) / n.
        let position = (normal::cumulative(z) * self.values.len() as f64 - 0.5).clamp(0.0, last as f64);
        let below = (position as usize).min(last - 1);
        let [low, high] = [self.values[below], self.values[below + 1]];
        let share = position - below as f64;
        // Exact at both ends, and between them in spite of rounding.
        (low * (1.0 - share) + high * share).clamp(low, high) / self.mean
    }

    /// The least or the greatest deviate at which the quantile over the mean is `value`; infinite beyond the values.
    pub(super) fn deviate(&self, value: f64, end: End) -> f64 {
        let n = self.values.len();
        let after = self.values.partition_point(|own| match end {
            End::Least => own / self.mean < value,
            End::Greatest => own / self.mean <= value,
        });
        if after == 0 || after == n {
            return beyond(after == 0);
        }
        let [low, high] = [self.values[after - 1], self.values[after]].map(|own| own / self.mean);
        let position = (after - 1) as f64 + ((value - low) / (high - low)).clamp(0.0, 1.0);
        at_tails((position + 0.5) / n as f64, (n as f64 - 0.5 - position) / n as f64)
    }

    /// The values over their mean, each once.
    pub(super) fn relative(&self) -> Vec<f64> {
        let mut relative: Vec<f64> = self.values.iter().map(|value| value / self.mean).collect();
        relative.dedup();
        relative
    }
}
