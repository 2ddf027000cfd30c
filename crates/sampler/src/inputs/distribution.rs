//! The distribution of one input, with its expected value and scatter.

use super::absolute::Shifted;
use super::end::{End, beyond};
use super::marginal::Marginal;
use super::transform::Transform;

/// The distribution of one input: its values are `expected` times those of a relative one, plus `shift`.
///
/// ```
/// use stickslip_sampler::inputs::{End, InputDistribution, Marginal};
/// let input = InputDistribution::relative(&Marginal::Lognormal, 0.1, 0.3);
/// let deviate = input.deviate(0.2, End::Least);
/// assert!((input.value(deviate) / 0.2 - 1.0).abs() < 1e-15);
/// ```
#[derive(Debug, Clone)]
pub struct InputDistribution {
    expected: f64,
    transform: Transform,
    shift: f64,
    scatters: bool,
}

impl InputDistribution {
    /// With a standard deviation relative to the expected value.
    #[must_use]
    pub fn relative(marginal: &Marginal, expected: f64, relative_std: f64) -> Self {
        Self {
            expected,
            transform: Transform::new(marginal, relative_std),
            shift: 0.0,
            scatters: expected != 0.0 && (relative_std != 0.0 || matches!(marginal, Marginal::Empirical(_))),
        }
    }

    /// With a standard deviation that is not relative to the expected value, which may be zero.
    #[must_use]
    pub fn absolute(marginal: &Marginal, expected: f64, std: f64) -> Self {
        let Shifted { expected, relative_std, shift } = marginal.shifted(expected, std);
        Self { shift, ..Self::relative(marginal, expected, relative_std) }
    }

    /// An input that does not scatter.
    #[must_use]
    pub fn fixed(value: f64) -> Self {
        Self { expected: value, transform: Transform::Fixed, shift: 0.0, scatters: false }
    }

    /// Whether it scatters.
    #[must_use]
    pub fn scatters(&self) -> bool {
        self.scatters
    }

    /// The input of a standard normal deviate.
    #[must_use]
    pub fn value(&self, deviate: f64) -> f64 {
        self.transform.value(self.expected, deviate) + self.shift
    }

    /// Replaces deviates by inputs.
    #[inline]
    pub(super) fn apply(&self, column: &mut [f64]) {
        self.transform.apply(self.expected, column);
        if self.shift != 0.0 {
            column.iter_mut().for_each(|value| *value += self.shift);
        }
    }

    /// The deviate of a value, the inverse of [`InputDistribution::value`], accurate in both tails: minus infinity if all
    /// inputs are greater, infinity if all are less. Where measured values are equal, and where an input does not
    /// scatter, `end` says which of their deviates.
    #[must_use]
    pub fn deviate(&self, value: f64, end: End) -> f64 {
        if !self.scatters {
            let own = self.value(0.0);
            return beyond(own > value || (end == End::Least && own >= value));
        }
        self.transform.deviate((value - self.shift) / self.expected, end)
    }

    /// The values at which the distribution begins, ends, or has a kink: between them its quantiles are smooth.
    #[must_use]
    pub fn kinks(&self) -> Vec<f64> {
        if !self.scatters {
            return Vec::new();
        }
        self.transform.kinks().into_iter().map(|kink| self.expected * kink + self.shift).collect()
    }
}
