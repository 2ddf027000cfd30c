//! The normal distribution, computed without the platform's mathematics library.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

/// Density of the standard normal distribution.
#[must_use]
pub fn density(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / TAU.sqrt()
}

/// Probability that a standard normal deviate exceeds `z`, accurate in both tails.
///
/// ```
/// let p = stickslip_sampler::normal::upper_tail(1.959963984540054);
/// assert!((p - 0.025).abs() < 1e-16);
/// ```
#[must_use]
pub fn upper_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z * FRAC_1_SQRT_2)
}

/// The deviate that a standard normal one exceeds with probability `tail`, for `0 < tail <= 0.5`.
///
/// Newton's iteration on the logarithm of the tail. That is concave, so from the upper bound
/// `sqrt(-2 ln(2 tail))` the iterates fall towards the quantile and never pass it.
#[must_use]
pub fn upper_quantile(tail: f64) -> f64 {
    let target = libm::log(tail);
    let mut z = (-2.0 * libm::log(2.0 * tail)).max(0.0).sqrt();
    for _ in 0..100 {
        let current = upper_tail(z);
        let step = (libm::log(current) - target) * current / density(z);
        z += step;
        if step.abs() <= 1e-15 * z.abs() {
            break;
        }
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_agree_with_published_tables() {
        // NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.6.7.1, and its inverse to more digits from
        // Abramowitz and Stegun, Handbook of Mathematical Functions, table 26.5.
        let table = [
            (0.5, 0.0),
            (0.25, 0.674_489_750_196_082),
            (0.1, 1.281_551_565_544_6),
            (0.025, 1.959_963_984_540_054),
            (0.005, 2.575_829_303_548_901),
            (0.0005, 3.290_526_731_491_896),
            (1e-9, 5.997_807_015_007_686),
        ];
        for (tail, z) in table {
            assert!((upper_quantile(tail) - z).abs() < 4e-15 * f64::max(1.0, z), "{tail}: {}", upper_quantile(tail));
        }
    }

    #[test]
    fn quantile_inverts_the_tail_down_to_the_smallest_levels() {
        for exponent in 1..300 {
            let tail = 10f64.powi(-exponent);
            let back = upper_tail(upper_quantile(tail));
            assert!((back / tail - 1.0).abs() < 1e-12, "{tail}: {back}");
        }
    }
}
