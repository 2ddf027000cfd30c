//! The distribution of one input.

use thiserror::Error;

use super::empirical::Empirical;
use super::truncation;

/// Largest relative standard deviation of any input. A larger one is a mistake, such as a percentage.
const LARGEST: f64 = 10.0;

/// Largest relative standard deviation of a normal input, at which one value in six is negative.
const LARGEST_NORMAL: f64 = 1.0;

/// Relative standard deviation of a uniform input that reaches down to zero, `1 / sqrt(3)`.
pub(super) const WIDEST_UNIFORM: f64 = 0.577_350_269_189_625_8;

/// Largest distance of the interval of a truncated normal input from the expected value, in standard deviations: a
/// normal deviate lies beyond with a probability of 6e-16.
const FARTHEST_INTERVAL: f64 = 8.0;

/// Shape parameters of a beta distribution for which [`crate::special_functions::beta`] is tested.
const BETA_SHAPES: [f64; 2] = [0.01, 1e10];

/// The distribution of an input with expected value `m > 0` and relative standard deviation `s`, from 0 to 10. The
/// standard deviation is `s m`.
///
/// Equations are those of N. L. Johnson, S. Kotz, N. Balakrishnan, Continuous Univariate Distributions, 2nd ed., vol. 1
/// (1994: normal 13, lognormal 14, Weibull 21) and vol. 2 (1995: Gumbel 22, beta 25, uniform and triangular 26), solved
/// for the parameters that give `m` and `s`. `Phi` is the standard normal distribution function, `p = Phi(z)`.
#[derive(Debug, Clone, PartialEq)]
pub enum Marginal {
    /// Normal: `m (1 + s z)`, for `s <= 1`. It is negative with probability `Phi(-1 / s)`.
    Normal,
    /// Lognormal: `m exp(t z - t^2 / 2)`, `t^2 = ln(1 + s^2)`.
    Lognormal,
    /// Uniform from `m (1 - s sqrt(3))` to `m (1 + s sqrt(3))`, for `s <= 1 / sqrt(3)`.
    Uniform,
    /// Normal with expected value `m` and standard deviation `s m`, truncated to the values from `m (1 + s low)` to
    /// `m (1 + s high)`. For `s > 1` these must not be negative.
    ///
    /// Truncation shifts and narrows the distribution: with `P = Phi(high) - Phi(low)` and
    /// `d = (phi(low) - phi(high)) / P`, its mean is `m (1 + s d)`, which is `m` if `low = -high`, and its
    /// variance `(s m)^2 (1 + (low phi(low) - high phi(high)) / P - d^2)` (vol. 1, section 13.10.1).
    /// [`Marginal::moments`] has both.
    TruncatedNormal {
        /// Lower end, in standard deviations from the expected value; may be minus infinity.
        low: f64,
        /// Upper end, in standard deviations from the expected value; may be infinity.
        high: f64,
    },
    /// Weibull: `m (-ln(1 - p))^(1/k) / Gamma(1 + 1/k)`. The shape `k` solves
    /// `Gamma(1 + 2/k) / Gamma(1 + 1/k)^2 = 1 + s^2`: 12.2 for `s = 0.1`, 1 (exponential) for `s = 1`.
    Weibull,
    /// Gumbel, the distribution of largest values: `m (1 + s sqrt(6) / pi (-ln(-ln(p)) - gamma))`, `gamma` being
    /// Euler's constant. It is negative with probability `exp(-exp(pi / (s sqrt(6)) - gamma))`: 7e-4 for `s = 1/2`.
    Gumbel,
    /// Triangular from `m (1 - w (1 + mode) / 3)`, which must not be negative, to `m (1 + w (2 - mode) / 3)`, with
    /// `w = s sqrt(18 / (1 - mode + mode^2))`.
    Triangular {
        /// Position of the peak from 0 (the lower end) to 1 (the upper end); 1/2 for a symmetric triangle.
        mode: f64,
    },
    /// Beta from `low m` to `high m`: with `mu = (1 - low) / (high - low)` and
    /// `nu = (1 - low) (high - 1) / s^2 - 1` its shapes are `nu mu` and `nu (1 - mu)`. They must be from 0.01 to 1e10.
    Beta {
        /// Lower end over the expected value, from 0 to less than 1.
        low: f64,
        /// Upper end over the expected value, more than 1.
        high: f64,
    },
    /// The distribution of measured values, scaled to the expected value `m`. It has the relative standard deviation of
    /// the values; `s` has no effect.
    Empirical(Empirical),
}

/// Why a marginal distribution was refused.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum MarginalError {
    /// The expected value is zero, negative, infinite or NaN.
    #[error("the expected value is {value}; it must be positive and finite")]
    Expected {
        /// The expected value.
        value: f64,
    },
    /// The relative standard deviation is negative, too large or NaN.
    #[error(
        "the relative standard deviation is {value}; it must be at least 0 and at most 10 (standard deviation over \
         expected value, not per cent)"
    )]
    RelativeStd {
        /// The relative standard deviation.
        value: f64,
    },
    /// A standard deviation that is negative or no number.
    #[error("the standard deviation is {value}; it must be at least 0 and finite")]
    Std {
        /// The standard deviation.
        value: f64,
    },
    /// A normal distribution with too many negative values.
    #[error(
        "a normal input with a relative standard deviation of {value} would be negative too often; the largest \
         possible is 1. A lognormal, Weibull or Gumbel one may have more"
    )]
    NormalTooWide {
        /// The relative standard deviation.
        value: f64,
    },
    /// A truncated normal distribution with a relative standard deviation above 1 that includes negative values.
    #[error(
        "a truncated normal input with a relative standard deviation of {value} would be negative at its lower end; \
         above 1, low must be at least -1/{value} = {lowest:.4} (it is {low})"
    )]
    TruncatedTooWide {
        /// The relative standard deviation.
        value: f64,
        /// Lower end.
        low: f64,
        /// The lower end at which the input is zero.
        lowest: f64,
    },
    /// A uniform distribution that includes negative values.
    #[error(
        "a uniform input with a relative standard deviation of {value} would become negative; \
         the largest possible is 1/sqrt(3) = 0.57735"
    )]
    UniformTooWide {
        /// The relative standard deviation.
        value: f64,
    },
    /// The ends of a truncated normal distribution in the wrong order, equal or NaN.
    #[error("nothing lies between low = {low} and high = {high}; low must be less than high")]
    NoInterval {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A truncated normal distribution so far out that the normal one practically never has such values.
    #[error(
        "the interval from {low} to {high} is more than 8 standard deviations away from the expected value; \
         low and high count standard deviations, not values of the input"
    )]
    IntervalTooFar {
        /// Lower end.
        low: f64,
        /// Upper end.
        high: f64,
    },
    /// A triangular distribution whose peak is not between its ends.
    #[error(
        "the peak of a triangular input is at {mode} of the way from its lower to its upper end; it must be at least 0 \
         and at most 1, 0.5 for a symmetric one"
    )]
    Mode {
        /// The position given.
        mode: f64,
    },
    /// A triangular distribution that includes negative values.
    #[error(
        "a triangular input with its peak at {mode} and a relative standard deviation of {value} would become \
         negative; the largest possible is {largest:.5}"
    )]
    TriangularTooWide {
        /// Position of the peak.
        mode: f64,
        /// The relative standard deviation.
        value: f64,
        /// The largest possible one.
        largest: f64,
    },
    /// A beta distribution whose ends do not enclose the expected value, or are negative or infinite.
    #[error(
        "a beta input cannot lie between {low} and {high} times its expected value: the lower end must be at least 0 \
         and less than 1, the upper end greater than 1 and finite"
    )]
    BetaEnds {
        /// Lower end over the expected value.
        low: f64,
        /// Upper end over the expected value.
        high: f64,
    },
    /// A beta distribution with a standard deviation that its ends do not allow.
    #[error(
        "a beta input between {low} and {high} times its expected value cannot have a relative standard deviation of \
         {value}; it must be 0, or at least {smallest:.1e} and at most {largest:.5}"
    )]
    BetaStd {
        /// Lower end over the expected value.
        low: f64,
        /// Upper end over the expected value.
        high: f64,
        /// The relative standard deviation.
        value: f64,
        /// The smallest for which it is tested.
        smallest: f64,
        /// The largest for which it is tested, a little below `sqrt((1 - low) (high - 1))`.
        largest: f64,
    },
}

impl Marginal {
    /// What it is called, within a sentence.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Lognormal => "lognormal",
            Self::Uniform => "uniform",
            Self::TruncatedNormal { .. } => "truncated normal",
            Self::Weibull => "Weibull",
            Self::Gumbel => "Gumbel",
            Self::Triangular { .. } => "triangular",
            Self::Beta { .. } => "beta",
            Self::Empirical(_) => "measured values",
        }
    }

    /// Whether the distribution exists with this expected value and relative standard deviation.
    ///
    /// # Errors
    /// [`MarginalError`] if it does not.
    pub fn check(&self, expected: f64, relative_std: f64) -> Result<(), MarginalError> {
        if !(expected > 0.0 && expected.is_finite()) {
            return Err(MarginalError::Expected { value: expected });
        }
        self.check_scatter(relative_std)
    }

    /// Whether the distribution exists with this relative standard deviation, for any positive expected value.
    ///
    /// # Errors
    /// [`MarginalError`] if it does not.
    pub fn check_scatter(&self, relative_std: f64) -> Result<(), MarginalError> {
        let value = relative_std;
        if !(0.0..=LARGEST).contains(&value) && !matches!(self, Self::Empirical(_)) {
            return Err(MarginalError::RelativeStd { value });
        }
        match *self {
            Self::Normal if value > LARGEST_NORMAL => Err(MarginalError::NormalTooWide { value }),
            Self::Uniform if value > WIDEST_UNIFORM => Err(MarginalError::UniformTooWide { value }),
            Self::TruncatedNormal { low, high } if low.is_nan() || high.is_nan() || low >= high => {
                Err(MarginalError::NoInterval { low, high })
            }
            Self::TruncatedNormal { low, high } if low > FARTHEST_INTERVAL || high < -FARTHEST_INTERVAL => {
                Err(MarginalError::IntervalTooFar { low, high })
            }
            Self::TruncatedNormal { low, .. } if value > LARGEST_NORMAL && low < -1.0 / value => {
                Err(MarginalError::TruncatedTooWide { value, low, lowest: -1.0 / value })
            }
            Self::Triangular { mode } => check_triangular(mode, value),
            Self::Beta { low, high } => check_beta(low, high, value),
            Self::Normal
            | Self::Lognormal
            | Self::Uniform
            | Self::TruncatedNormal { .. }
            | Self::Weibull
            | Self::Gumbel
            | Self::Empirical(_) => Ok(()),
        }
    }

    /// Mean and standard deviation: `m` and `s m`, except for a truncated normal input, for which `m` and `s m` are
    /// those before truncation, and for an empirical one, which has the relative standard deviation of its values.
    ///
    /// Meaningful only where [`Marginal::check`] finds no error.
    ///
    /// ```
    /// use stickslip_sampler::inputs::Marginal;
    /// // Cut off at zero.
    /// let (mean, std) = Marginal::TruncatedNormal { low: -1.0, high: f64::INFINITY }.moments(0.1, 1.0);
    /// assert!((mean - 0.128_76).abs() < 1e-5 && (std - 0.079_35).abs() < 1e-5);
    /// ```
    #[must_use]
    pub fn moments(&self, expected: f64, relative_std: f64) -> (f64, f64) {
        match self {
            Self::TruncatedNormal { low, high } => {
                let (mean, std) = truncation::moments(*low, *high);
                (expected * (1.0 + relative_std * mean), expected * relative_std * std)
            }
            Self::Empirical(values) => (expected, expected * values.relative_std()),
            _ => (expected, expected * relative_std),
        }
    }
}

fn check_triangular(mode: f64, value: f64) -> Result<(), MarginalError> {
    if !(0.0..=1.0).contains(&mode) {
        return Err(MarginalError::Mode { mode });
    }
    // The lower end is zero.
    let largest = (0.5 * (1.0 - mode + mode * mode)).sqrt() / (1.0 + mode);
    if value > largest { Err(MarginalError::TriangularTooWide { mode, value, largest }) } else { Ok(()) }
}

fn check_beta(low: f64, high: f64, value: f64) -> Result<(), MarginalError> {
    if !((0.0..1.0).contains(&low) && high > 1.0 && high.is_finite()) {
        return Err(MarginalError::BetaEnds { low, high });
    }
    // The smaller shape is nu times the smaller of mu and 1 - mu, the larger one likewise.
    let (below, above) = (1.0 - low, high - 1.0);
    let [smaller, larger] = [below.min(above), below.max(above)].map(|part| part / (high - low));
    let std = |sum: f64| (below * above / (1.0 + sum)).sqrt();
    let [smallest, largest] = [std(BETA_SHAPES[1] / larger), std(BETA_SHAPES[0] / smaller)];
    if value == 0.0 || (smallest..=largest).contains(&value) {
        Ok(())
    } else {
        Err(MarginalError::BetaStd { low, high, value, smallest, largest })
    }
}
