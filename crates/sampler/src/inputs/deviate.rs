//! The deviates of inputs: the inverse of the quantile function of each marginal distribution at `Phi(z)`.

use super::end::{End, at_tails, beyond};
use super::transform::Transform;
use crate::special_functions::{beta, normal};

impl Transform {
    /// The deviate at which the input is `value` times its expected value; infinite beyond the ends of the
    /// distribution.
    ///
    /// It comes from the probability below or from that above, whichever is smaller, and each of these from the distance
    /// to its own end of the distribution. So it is accurate in both tails.
    pub fn deviate(&self, value: f64, end: End) -> f64 {
        match *self {
            Self::Fixed => beyond(1.0 > value || (end == End::Least && 1.0 >= value)),
            Self::Normal { relative_std } => (value - 1.0) / relative_std,
            Self::Lognormal { .. } | Self::Weibull { .. } if value <= 0.0 => f64::NEG_INFINITY,
            Self::Lognormal { log_std, shift } => (libm::log(value) + shift) / log_std,
            Self::Uniform { half_width } => {
                let width = 2.0 * half_width;
                at_tails((value - (1.0 - half_width)) / width, ((1.0 + half_width) - value) / width)
            }
            Self::TruncatedNormal { relative_std, low, high, below, above } => {
                let x = (value - 1.0) / relative_std;
                if x <= low || x >= high {
                    return beyond(x <= low);
                }
                // Differences of the tails in which less cancels.
                let [lower_tail, upper_tail] = [normal::cumulative(x), normal::upper_tail(x)];
                let whole = if low > 0.0 { above[0] - above[1] } else { below[1] - below[0] };
                let lower = if low > 0.0 { above[0] - upper_tail } else { lower_tail - below[0] };
                let upper = if x > 0.0 { upper_tail - above[1] } else { below[1] - lower_tail };
                at_tails(lower / whole, upper / whole)
            }
            Self::Weibull { inverse_shape, scale } => {
                let exponential = libm::pow(value / scale, 1.0 / inverse_shape);
                at_tails(-libm::expm1(-exponential), libm::exp(-exponential))
            }
            Self::Gumbel { scale, location } => {
                let exponential = libm::exp((location - value) / scale);
                at_tails(libm::exp(-exponential), -libm::expm1(-exponential))
            }
            Self::Triangular { mode, low, high, width } => {
                let (from, to) = ((value - low) / width, (high - value) / width);
                if from <= 0.0 || to <= 0.0 {
                    return beyond(from <= 0.0);
                }
                let (lower, upper) = (from * from / mode, to * to / (1.0 - mode));
                if from < mode { at_tails(lower, 1.0 - lower) } else { at_tails(1.0 - upper, upper) }
            }
            Self::Beta { shapes: [a, b], low, high } => {
                let (from, to) = ((value - low) / (high - low), (high - value) / (high - low));
                if from <= 0.0 || to <= 0.0 {
                    return beyond(from <= 0.0);
                }
                at_tails(beta::lower_tail(a, b, from), beta::lower_tail(b, a, to))
            }
            Self::Empirical(ref values) => values.deviate(value, end),
        }
    }

    /// The values over the expected one at which the quantile function is not smooth, ends of the distribution
    /// included.
    pub fn kinks(&self) -> Vec<f64> {
        match *self {
            Self::Fixed | Self::Normal { .. } | Self::Lognormal { .. } | Self::Gumbel { .. } => Vec::new(),
            Self::Weibull { .. } => vec![0.0],
            Self::Uniform { half_width } => vec![1.0 - half_width, 1.0 + half_width],
            Self::TruncatedNormal { relative_std, low, high, .. } => {
                [low, high].into_iter().filter(|end| end.is_finite()).map(|end| 1.0 + relative_std * end).collect()
            }
            Self::Triangular { mode, low, high, width } => vec![low, low + width * mode, high],
            Self::Beta { low, high, .. } => vec![low, high],
            Self::Empirical(ref values) => values.relative(),
        }
    }
}
