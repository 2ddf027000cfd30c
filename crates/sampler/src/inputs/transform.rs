//! The inputs of deviates: the quantile function of each marginal distribution at `Phi(z)`.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use super::empirical::Empirical;
use super::marginal::Marginal;
use super::weibull::inverse_shape;
use crate::special_functions::{beta, normal};

/// Euler's constant.
const EULER_GAMMA: f64 = 0.577_215_664_901_532_9;

impl Marginal {
    /// The input of the standard normal deviate `z`, for `|z| <= 37`: the quantile at `Phi(z)`, which rises with `z`.
    ///
    /// Meaningful only where [`Marginal::check`] finds no error.
    ///
    /// ```
    /// use stickslip_sampler::inputs::Marginal;
    /// assert_eq!(Marginal::Normal.value(0.4, 0.1, 1.5), 0.4 * (1.0 + 0.1 * 1.5));
    /// assert_eq!(Marginal::Uniform.value(0.4, 0.1, 0.0), 0.4);
    /// ```
    #[inline]
    #[must_use]
    pub fn value(&self, expected: f64, relative_std: f64, z: f64) -> f64 {
        Transform::new(self, relative_std).value(expected, z)
    }

    /// Replaces each standard normal deviate by its input, as [`Marginal::value`] returns it. The constants of the
    /// distribution are computed once.
    #[inline]
    pub fn apply(&self, expected: f64, relative_std: f64, deviates: &mut [f64]) {
        Transform::new(self, relative_std).apply(expected, deviates);
    }
}

/// A marginal distribution and the constants of its quantile function.
#[derive(Debug, Clone)]
pub enum Transform {
    /// `s = 0`.
    Fixed,
    Normal {
        relative_std: f64,
    },
    Lognormal {
        log_std: f64,
        shift: f64,
    },
    Uniform {
        /// Half of the interval, over the expected value.
        half_width: f64,
    },
    TruncatedNormal {
        relative_std: f64,
        low: f64,
        high: f64,
        /// Probabilities below the two ends, of the normal distribution.
        below: [f64; 2],
        /// Probabilities above the two ends.
        above: [f64; 2],
    },
    Weibull {
        inverse_shape: f64,
        /// Over the expected value.
        scale: f64,
    },
    Gumbel {
        /// Over the expected value, like `location`.
        scale: f64,
        location: f64,
    },
    Triangular {
        mode: f64,
        low: f64,
        high: f64,
        width: f64,
    },
    Beta {
        shapes: [f64; 2],
        low: f64,
        high: f64,
    },
    Empirical(Empirical),
}

impl Transform {
    /// Computes the constants.
    #[inline]
    pub fn new(marginal: &Marginal, relative_std: f64) -> Self {
        match *marginal {
            Marginal::Normal => Self::Normal { relative_std },
            Marginal::Lognormal => {
                let log_variance = libm::log1p(relative_std * relative_std);
                Self::Lognormal { log_std: log_variance.sqrt(), shift: 0.5 * log_variance }
            }
            Marginal::Uniform => Self::Uniform { half_width: relative_std * 3.0_f64.sqrt() },
            Marginal::TruncatedNormal { low, high } => Self::TruncatedNormal {
                relative_std,
                low,
                high,
                below: [normal::upper_tail(-low), normal::upper_tail(-high)],
                above: [normal::upper_tail(low), normal::upper_tail(high)],
            },
            Marginal::Weibull => {
                let inverse_shape = inverse_shape(relative_std);
                Self::Weibull { inverse_shape, scale: 1.0 / libm::tgamma(1.0 + inverse_shape) }
            }
            Marginal::Gumbel => {
                let scale = relative_std * 6.0_f64.sqrt() / PI;
                Self::Gumbel { scale, location: 1.0 - scale * EULER_GAMMA }
            }
            Marginal::Triangular { mode } => {
                let width = relative_std * (18.0 / (1.0 - mode + mode * mode)).sqrt();
                let low = (1.0 - width * (1.0 + mode) / 3.0).max(0.0);
                Self::Triangular { mode, low, high: 1.0 + width * (2.0 - mode) / 3.0, width }
            }
            Marginal::Beta { .. } if relative_std == 0.0 => Self::Fixed,
            Marginal::Beta { low, high } => Self::Beta { shapes: beta_shapes(low, high, relative_std), low, high },
            Marginal::Empirical(ref values) => Self::Empirical(values.clone()),
        }
    }

    /// Replaces deviates by inputs.
    #[inline]
    pub fn apply(&self, expected: f64, deviates: &mut [f64]) {
        // The usual case, without a branch in the loop.
        if let Self::Normal { relative_std } = *self {
            deviates.iter_mut().for_each(|value| *value = expected * (1.0 + relative_std * *value));
        } else {
            deviates.iter_mut().for_each(|value| *value = self.value(expected, *value));
        }
    }

    /// The input of a deviate.
    #[inline]
    pub fn value(&self, expected: f64, z: f64) -> f64 {
        match *self {
            Self::Fixed => expected,
            Self::Normal { relative_std } => expected * (1.0 + relative_std * z),
            Self::Lognormal { log_std, shift } => expected * libm::exp(log_std * z - shift),
            Self::Uniform { half_width } => {
                let x = z * FRAC_1_SQRT_2;
                // 2 Phi(z) - 1 = erf(x) = erfc(-x) - 1. Near the lower end, which may be zero, only the latter leaves
                // the small distance from it exact; the upper end is never small.
                if z < -1.0 {
                    expected * ((1.0 - half_width) + half_width * libm::erfc(-x))
                } else {
                    expected * (1.0 + half_width * libm::erf(x))
                }
            }
            Self::TruncatedNormal { relative_std, low, high, below, above } => {
                // Phi(x) = Phi(low) + (Phi(high) - Phi(low)) Phi(z) and 1 - Phi(x), each as a sum without
                // cancellation; the smaller of them gives x.
                let tail = normal::upper_tail(z.abs());
                let [upper, lower] = if z < 0.0 { [1.0 - tail, tail] } else { [tail, 1.0 - tail] };
                let probability = below[0] * upper + below[1] * lower;
                let complement = above[0] * upper + above[1] * lower;
                let x = if probability < complement {
                    normal::quantile(probability)
                } else {
                    -normal::quantile(complement)
                };
                expected * (1.0 + relative_std * x.clamp(low, high))
            }
            Self::Weibull { inverse_shape, scale } => expected * (scale * libm::pow(exponential(z), inverse_shape)),
            Self::Gumbel { scale, location } => expected * (location - scale * libm::log(exponential(-z))),
            Self::Triangular { mode, low, high, width } => {
                let below = normal::cumulative(z);
                if below < mode {
                    expected * (low + width * (mode * below).sqrt())
                } else {
                    expected * (high - width * ((1.0 - mode) * normal::upper_tail(z)).sqrt())
                }
            }
            Self::Beta { shapes: [a, b], low, high } => {
                // From the end on whose side the deviate is.
                if z < 0.0 {
                    expected * (low + (high - low) * beta::quantile(a, b, normal::cumulative(z)))
                } else {
                    expected * (high - (high - low) * beta::quantile(b, a, normal::upper_tail(z)))
                }
            }
            Self::Empirical(ref values) => expected * values.quantile(z),
        }
    }
}

/// `-ln(1 - Phi(z))`: the exponential deviate of a normal one.
fn exponential(z: f64) -> f64 {
    if z < 0.0 { -libm::log1p(-normal::cumulative(z)) } else { -libm::log(normal::upper_tail(z)) }
}

/// The shapes of a beta distribution between `low` and `high` times its expected value.
fn beta_shapes(low: f64, high: f64, relative_std: f64) -> [f64; 2] {
    let sum = (1.0 - low) * (high - 1.0) / (relative_std * relative_std) - 1.0;
    [sum * ((1.0 - low) / (high - low)), sum * ((high - 1.0) / (high - low))]
}
