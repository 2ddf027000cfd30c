//! The probability of instability and its derivatives where the boundary of stability is known in closed form.
//!
//! Let `m1` and `m2` be the expected values of the two inputs, and `s1` and `s2` their relative standard deviations.
//! With the boundary `b_crit(a) = b_0 + C / a` the probability of instability is
//!
//! ```text
//! P = integral over z1 with a(z1) > 0 of   phi(z1) Q(t(z1))   dz1,
//! a(z1) = m1 (1 + s1 z1),   t(z1) = (b_crit(a(z1)) / m2 - 1) / s2
//! ```
//!
//! with the normal density `phi` and upper tail `Q`. If only one input scatters, it is a single tail. Where samples are
//! unstable below the boundary in the second input, they are so between two values of it, and `Q` becomes the difference
//! of the two tails. The derivatives follow from the moments of the deviates over the same region
//! ([`derivatives`](crate::integrate::derivatives)).

use stickslip_core::model::pair_boundary::PairBoundary;

use crate::integrate::derivatives::{Derivatives, DeviateMoments, moments_at, product};
use crate::integrate::normal_pair::NormalPair;
use crate::integrate::quadrature::integrate_intervals;
use crate::special_functions::normal;

/// Deviates beyond this carry a probability below 1e-23.
const DEVIATE_LIMIT: f64 = 10.0;

/// Tolerance of the error of each interval of integration.
const TOLERANCE: f64 = 1e-14;

/// Most halvings of an interval; 2^-60 of the range is below the spacing of the abscissae.
const DEEPEST: u32 = 60;

/// The integral over the first input is divided where the critical second one is at these deviates: a probability that
/// rises from 0 to 1 between two abscissae would be missed.
const CUTS: [f64; 7] = [-9.0, -6.0, -3.0, 0.0, 3.0, 6.0, 9.0];

/// A probability with a bound on its numerical error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExactProbability {
    /// The probability of instability.
    pub value: f64,
    /// A bound on its error.
    pub error_bound: f64,
}

/// Bounds that are farther apart say too little for a probability between them.
pub const MOST_OPEN: f64 = 1e-3;

impl ExactProbability {
    /// Whether the bounds are near enough to each other for the value between them to be a probability.
    #[must_use]
    pub fn is_resolved(&self) -> bool {
        let [low, high] = self.bounds();
        high - low <= MOST_OPEN
    }

    /// Between which probabilities the error leaves it.
    #[must_use]
    pub fn bounds(&self) -> [f64; 2] {
        [(self.value - self.error_bound).max(0.0), (self.value + self.error_bound).min(1.0)]
    }
}

/// The probability that a sample is unstable, by quadrature.
///
/// The error is about 1e-14 if an input has a relative standard deviation above 0.01. Below, it is the rounding error
/// of the boundary divided by the relative standard deviation.
#[must_use]
pub fn probability(boundary: &PairBoundary, inputs: &NormalPair) -> ExactProbability {
    let NormalPair { expected, relative_std } = *inputs;
    let [first_scatters, second_scatters] = inputs.scatter();
    let second_exceeds = |limit: f64| exceeds(expected[1], relative_std[1], limit);
    let second_share = |first: f64| {
        let (above, below) = boundary.unstable_second(first);
        second_exceeds(above) - second_exceeds(below)
    };
    if !first_scatters {
        return rounded(second_share(expected[0]), inputs);
    }
    if !second_scatters {
        let critical = boundary.critical_first(expected[1]);
        return rounded(exceeds(expected[0], relative_std[0], critical), inputs);
    }
    let integrand = |z: f64| [normal::density(z) * second_share(first_at(inputs, z))];
    let ([value], [error]) = over_first(boundary, inputs, &integrand, TOLERANCE);
    ExactProbability { value: value.clamp(0.0, 1.0), error_bound: error + rounding(inputs) }
}

/// The derivatives of [`probability`], by quadrature.
///
/// The error of a derivative by an expected value is about 1e-14 divided by the standard deviation of the input; that
/// of a derivative by a relative standard deviation about 1e-14 divided by the latter.
#[must_use]
pub fn derivatives(boundary: &PairBoundary, inputs: &NormalPair) -> Derivatives {
    const WHOLE: DeviateMoments = [1.0, 0.0, 0.0];
    let NormalPair { expected, relative_std } = *inputs;
    let second_moments = |first: f64| {
        let (above, below) = boundary.unstable_second(first);
        let [above, below] = [above, below].map(|limit| tail_moments(expected[1], relative_std[1], limit));
        std::array::from_fn(|i| above[i] - below[i])
    };
    let moments = match inputs.scatter() {
        [false, _] => product(&WHOLE, &second_moments(expected[0])),
        [true, false] => {
            let critical = boundary.critical_first(expected[1]);
            product(&tail_moments(expected[0], relative_std[0], critical), &WHOLE)
        }
        [true, true] => {
            let integrand = |z: f64| product(&moments_at(z), &second_moments(first_at(inputs, z)));
            over_first(boundary, inputs, &integrand, TOLERANCE).0
        }
    };
    let mut derivatives = Derivatives::from_moments(inputs, &moments);
    // An input without scatter moves the limit of the other one: dP = -phi(t) dt.
    let slope = |scattering: usize, limit: f64, slope_of_limit: f64| {
        let spread = inputs.spread(scattering);
        let density = normal::density((limit - expected[scattering]) / spread);
        let slope = -density * slope_of_limit / spread;
        Some(if density > 0.0 { slope } else { 0.0 })
    };
    match inputs.scatter() {
        [false, true] if expected[0] > 0.0 => {
            let (above, below) = boundary.unstable_second(expected[0]);
            // Samples are unstable above `b_0 + C / a`, or below `b_0 - C / a`: with a greater first input more so,
            // either way.
            let limit = if below.is_finite() { below } else { above };
            let slope_of_limit = if limit > boundary.least_second {
                -boundary.critical_product / (expected[0] * expected[0])
            } else {
                0.0
            };
            derivatives.0[0] = slope(1, limit, slope_of_limit);
        }
        [true, false] if boundary.critical_first(expected[1]).is_finite() => {
            let limit = boundary.critical_first(expected[1]);
            derivatives.0[1] = slope(0, limit, boundary.critical_first_slope(expected[1]));
        }
        _ => {}
    }
    derivatives
}

/// The first input at a deviate.
pub(crate) fn first_at(inputs: &NormalPair, z: f64) -> f64 {
    inputs.expected[0] * (1.0 + inputs.relative_std[0] * z)
}

/// The integral over the deviates at which the first input is positive, with an error of about `tolerance`.
pub(crate) fn over_first<const N: usize>(
    boundary: &PairBoundary,
    inputs: &NormalPair,
    integrand: &impl Fn(f64) -> [f64; N],
    tolerance: f64,
) -> ([f64; N], [f64; N]) {
    let NormalPair { expected, relative_std } = *inputs;
    let from = (-1.0 / relative_std[0]).clamp(-DEVIATE_LIMIT, DEVIATE_LIMIT);
    let mut ends = [from; CUTS.len() + 3];
    ends[CUTS.len() + 2] = DEVIATE_LIMIT;
    // Below the critical first input of the least second one inside the model nothing may be unstable.
    let cuts = CUTS.map(|cut| expected[1] * (1.0 + relative_std[1] * cut));
    let cuts = cuts.into_iter().chain([boundary.least_second]);
    for (end, second) in ends[1..].iter_mut().zip(cuts) {
        let critical = boundary.critical_first(second);
        *end = ((critical / expected[0] - 1.0) / relative_std[0]).clamp(from, DEVIATE_LIMIT);
    }
    ends.sort_by(f64::total_cmp);
    integrate_intervals(integrand, &ends, tolerance, DEEPEST)
}

/// A tail, computed without quadrature.
fn rounded(value: f64, inputs: &NormalPair) -> ExactProbability {
    ExactProbability { value, error_bound: if value == 0.0 || value == 1.0 { 0.0 } else { rounding(inputs) } }
}

/// The effect of rounding on the boundary: some units in the last place of the threshold, in standard deviations of the
/// input that scatters most.
fn rounding(inputs: &NormalPair) -> f64 {
    let std = inputs.relative_std[0].max(inputs.relative_std[1]);
    (8.0 * f64::EPSILON * (1.0 + 1.0 / std)).min(1.0)
}

/// Probability that `expected (1 + relative_std z)` exceeds `threshold`, for `expected >= 0`.
fn exceeds(expected: f64, relative_std: f64, threshold: f64) -> f64 {
    let spread = expected * relative_std;
    if spread == 0.0 {
        return if expected > threshold { 1.0 } else { 0.0 };
    }
    normal::upper_tail((threshold - expected) / spread)
}

/// The moments of the deviates `z` for which `expected (1 + relative_std z)` exceeds `threshold`.
fn tail_moments(expected: f64, relative_std: f64, threshold: f64) -> DeviateMoments {
    let spread = expected * relative_std;
    if spread == 0.0 {
        return [exceeds(expected, relative_std, threshold), 0.0, 0.0];
    }
    // The threshold may be infinite, and zero times infinity is not zero.
    let z = ((threshold - expected) / spread).clamp(-40.0, 40.0);
    let density = normal::density(z);
    [normal::upper_tail(z), density, z * density]
}

#[cfg(test)]
mod tests;
