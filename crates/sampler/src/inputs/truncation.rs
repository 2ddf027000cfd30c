//! Moments of a truncated normal distribution.

use crate::special_functions::gauss_legendre::NODES_32;

/// Values whose density, relative to the largest, is below the exponential of minus this are left out.
const DEPTH: f64 = 45.0;

/// Mean and standard deviation of a standard normal deviate truncated to the values from `low` to `high`.
///
/// They are integrated by Gauss-Legendre rules of 32 points over panels no wider than 1. In the closed form digits
/// cancel where the interval is narrow or far out.
pub fn moments(low: f64, high: f64) -> (f64, f64) {
    // The value of largest density, and how far from zero the density matters.
    let peak = 0.0_f64.clamp(low, high);
    let reach = (peak * peak + 2.0 * DEPTH).sqrt();
    let (low, high) = (low.max(-reach), high.min(reach));
    let panels = (high - low).ceil().max(1.0);
    let half = 0.5 * (high - low) / panels;
    // The integral of a function times the density, relative to that at the peak.
    let integral = |f: &dyn Fn(f64) -> f64| {
        let term = |x: f64| f(x) * libm::exp(0.5 * (peak - x) * (peak + x));
        let mut sum = 0.0;
        for panel in 0..panels as u32 {
            let centre = low + half * (2.0 * f64::from(panel) + 1.0);
            for (node, weight) in NODES_32 {
                sum += weight * (term(centre - half * node) + term(centre + half * node));
            }
        }
        sum * half
    };
    let mass = integral(&|_| 1.0);
    // Relative to the peak, so that no digits cancel in a narrow interval.
    let shift = integral(&|x| x - peak) / mass;
    let variance = integral(&|x| (x - peak - shift) * (x - peak - shift)) / mass;
    (peak + shift, variance.sqrt())
}
