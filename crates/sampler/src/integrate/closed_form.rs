//! The probability of instability and its derivatives where the boundary of stability is known in closed form.
//!
//! With the boundary `f_crit(Delta) = f_c + C / Delta` the probability of instability of a cell is
//!
//! ```text
//! P = integral over z1 with Delta(z1) > 0 of   phi(z1) Q(t(z1))   dz1,
//! Delta(z1) = Delta (1 + sigma_Delta z1),   t(z1) = (f_crit(Delta(z1)) / f_s - 1) / sigma_f
//! ```
//!
//! with the normal density `phi` and upper tail `Q`. If only one input scatters, it is a single tail. A measured curve
//! that falls only because it is shifted by its standard deviations is unstable between two static friction
//! coefficients, and `Q` becomes the difference of the two tails. The derivatives follow from the moments of the
//! deviates over the same region ([`derivatives`](crate::integrate::derivatives)).

use stickslip_core::rigid_disc::stability::StabilityBoundary;

use crate::grid::Cell;
use crate::integrate::derivatives::{Derivatives, DeviateMoments, moments_at, product};
use crate::integrate::quadrature::integrate_intervals;
use crate::special_functions::normal;

/// Deviates beyond this carry a probability below 1e-23.
const DEVIATE_LIMIT: f64 = 10.0;

/// Tolerance of the error of each interval of integration.
const TOLERANCE: f64 = 1e-14;

/// Most halvings of an interval; 2^-60 of the range is below the spacing of the abscissae.
const DEEPEST: u32 = 60;

/// The integral over the preload is divided where the critical static friction is at these deviates: a probability that
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

impl ExactProbability {
    /// Between which probabilities the error leaves it.
    #[must_use]
    pub fn bounds(&self) -> [f64; 2] {
        [(self.value - self.error_bound).max(0.0), (self.value + self.error_bound).min(1.0)]
    }
}

/// The probability that a sample of `cell` is unstable, by quadrature.
///
/// The error is about 1e-14 if an input has a relative standard deviation above 0.01. Below, it is the rounding error
/// of the boundary divided by the relative standard deviation.
#[must_use]
pub fn probability(boundary: &StabilityBoundary, cell: &Cell) -> ExactProbability {
    let (preload_scatters, friction_scatters) = scatter(cell);
    let friction_exceeds = |limit: f64| exceeds(cell.static_friction, cell.relative_std.static_friction, limit);
    let friction_share = |preload: f64| {
        let (above, below) = boundary.unstable_static_friction(preload);
        friction_exceeds(above) - friction_exceeds(below)
    };
    if !preload_scatters {
        return rounded(friction_share(cell.preload), cell);
    }
    if !friction_scatters {
        let critical = boundary.critical_preload(cell.static_friction);
        return rounded(exceeds(cell.preload, cell.relative_std.preload, critical), cell);
    }
    let integrand = |z: f64| [normal::density(z) * friction_share(preload_at(cell, z))];
    let ([value], [error]) = over_preload(boundary, cell, &integrand, TOLERANCE);
    ExactProbability { value: value.clamp(0.0, 1.0), error_bound: error + rounding(cell) }
}

/// The derivatives of [`probability`], by quadrature.
///
/// The error of a derivative by an expected value is about 1e-14 divided by the standard deviation of the input; that
/// of a derivative by a relative standard deviation about 1e-14 divided by the latter.
#[must_use]
pub fn derivatives(boundary: &StabilityBoundary, cell: &Cell) -> Derivatives {
    const WHOLE: DeviateMoments = [1.0, 0.0, 0.0];
    let std = cell.relative_std;
    let friction_moments = |preload: f64| {
        let (above, below) = boundary.unstable_static_friction(preload);
        let [above, below] = [above, below].map(|limit| tail_moments(cell.static_friction, std.static_friction, limit));
        std::array::from_fn(|i| above[i] - below[i])
    };
    let moments = match scatter(cell) {
        (false, _) => product(&WHOLE, &friction_moments(cell.preload)),
        (true, false) => {
            let critical = boundary.critical_preload(cell.static_friction);
            product(&tail_moments(cell.preload, std.preload, critical), &WHOLE)
        }
        (true, true) => {
            let integrand = |z: f64| product(&moments_at(z), &friction_moments(preload_at(cell, z)));
            over_preload(boundary, cell, &integrand, TOLERANCE).0
        }
    };
    let mut derivatives = Derivatives::of(cell, &moments);
    // An input without scatter moves the limit of the other one: dP = -phi(t) dt.
    let slope = |expected: f64, std: f64, limit: f64, slope_of_limit: f64| {
        let spread = expected * std;
        let density = normal::density((limit - expected) / spread);
        let slope = -density * slope_of_limit / spread;
        Some(if density > 0.0 { slope } else { 0.0 })
    };
    match scatter(cell) {
        (false, true) if cell.preload > 0.0 => {
            let (above, below) = boundary.unstable_static_friction(cell.preload);
            // Sliding is unstable above `f_0 + C / Delta`, or below `f_0 - C / Delta`: with more preload more so,
            // either way.
            let limit = if below.is_finite() { below } else { above };
            let slope_of_limit = if limit > boundary.least_static_coefficient() {
                -boundary.critical_product() / (cell.preload * cell.preload)
            } else {
                0.0
            };
            derivatives.preload = slope(cell.static_friction, std.static_friction, limit, slope_of_limit);
        }
        (true, false) if boundary.critical_preload(cell.static_friction).is_finite() => {
            let limit = boundary.critical_preload(cell.static_friction);
            let slope_of_limit = boundary.critical_preload_slope(cell.static_friction);
            derivatives.static_friction = slope(cell.preload, std.preload, limit, slope_of_limit);
        }
        _ => {}
    }
    derivatives
}

/// Whether the preload and whether the static friction scatters.
fn scatter(cell: &Cell) -> (bool, bool) {
    let std = cell.relative_std;
    (cell.preload * std.preload != 0.0, cell.static_friction * std.static_friction != 0.0)
}

/// The preload at a deviate.
pub(crate) fn preload_at(cell: &Cell, z: f64) -> f64 {
    cell.preload * (1.0 + cell.relative_std.preload * z)
}

/// The integral over the deviates at which the preload is positive, with an error of about `tolerance`.
pub(crate) fn over_preload<const N: usize>(
    boundary: &StabilityBoundary,
    cell: &Cell,
    integrand: &impl Fn(f64) -> [f64; N],
    tolerance: f64,
) -> ([f64; N], [f64; N]) {
    let std = cell.relative_std;
    let from = (-1.0 / std.preload).clamp(-DEVIATE_LIMIT, DEVIATE_LIMIT);
    let mut ends = [from; CUTS.len() + 3];
    ends[CUTS.len() + 2] = DEVIATE_LIMIT;
    // Below the critical preload of the least physical coefficient nothing may be unstable.
    let cuts = CUTS.map(|cut| cell.static_friction * (1.0 + std.static_friction * cut));
    let cuts = cuts.into_iter().chain([boundary.least_static_coefficient()]);
    for (end, static_friction) in ends[1..].iter_mut().zip(cuts) {
        let critical = boundary.critical_preload(static_friction);
        *end = ((critical / cell.preload - 1.0) / std.preload).clamp(from, DEVIATE_LIMIT);
    }
    ends.sort_by(f64::total_cmp);
    integrate_intervals(integrand, &ends, tolerance, DEEPEST)
}

/// A tail, computed without quadrature.
fn rounded(value: f64, cell: &Cell) -> ExactProbability {
    ExactProbability { value, error_bound: if value == 0.0 || value == 1.0 { 0.0 } else { rounding(cell) } }
}

/// The effect of rounding on the boundary: some units in the last place of the threshold, in standard deviations of the
/// input that scatters most.
fn rounding(cell: &Cell) -> f64 {
    let std = cell.relative_std.preload.max(cell.relative_std.static_friction);
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
