//! The Stribeck friction law.

use crate::numerics::exponential::exp;

/// Friction that falls with sliding speed:
///
/// ```text
/// mu(v) = f_c + (f_s - f_c) exp(-(|v| / v_s)^delta)
/// ```
///
/// (the paper's equation 2.6 with the sign of its exponent corrected). `v` and `v_s` share a unit; inside this crate
/// they are scaled speeds.
///
/// ```
/// use stickslip_core::friction::StribeckLaw;
/// let law = StribeckLaw { static_coefficient: 0.39, kinetic_coefficient: 0.25, stribeck_velocity: 0.72, exponent: 1.0 };
/// assert_eq!(law.coefficient(0.0), 0.39);
/// assert!((law.coefficient(0.72) - (0.25 + 0.14 / std::f64::consts::E)).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StribeckLaw {
    /// f_s, the coefficient at rest.
    pub static_coefficient: f64,
    /// f_c, the limit at high sliding speed; at most `static_coefficient` for a falling curve.
    pub kinetic_coefficient: f64,
    /// v_s > 0.
    pub stribeck_velocity: f64,
    /// delta > 0; 1 is Tustin's law, 2 the Gaussian one.
    pub exponent: f64,
}

impl StribeckLaw {
    /// The friction coefficient mu at sliding speed `speed` (either sign).
    #[must_use]
    pub fn coefficient(&self, speed: f64) -> f64 {
        let (_, decay) = self.decay(speed.abs());
        self.kinetic_coefficient + (self.static_coefficient - self.kinetic_coefficient) * decay
    }

    /// The fall of friction with speed, per unit of `f_s - f_c`:
    ///
    /// ```text
    /// w(v) = (delta / v_s) (v / v_s)^(delta - 1) exp(-(v / v_s)^delta),      d mu / d v = -(f_s - f_c) w(v)
    /// ```
    ///
    /// It does not depend on the friction coefficients. `speed` > 0; for exponents below 1 it grows without
    /// bound towards zero speed.
    pub(crate) fn weakening(&self, speed: f64) -> f64 {
        let (power, decay) = self.decay(speed);
        if self.exponent == 1.0 {
            decay / self.stribeck_velocity
        } else if decay == 0.0 {
            0.0
        } else {
            self.exponent * power / speed * decay
        }
    }

    /// The speed in `from..=to` at which friction falls most steeply; `from` > 0.
    ///
    /// For exponents up to 1 the slope falls with speed; above 1 it has its crest at
    /// `v_s (1 - 1 / delta)^(1 / delta)`.
    pub(crate) fn steepest_between(&self, from: f64, to: f64) -> f64 {
        if self.exponent <= 1.0 {
            return from;
        }
        let crest = libm::pow(1.0 - 1.0 / self.exponent, 1.0 / self.exponent);
        (self.stribeck_velocity * crest).clamp(from, to)
    }

    /// `(v / v_s)^delta` and the exponential of its negative, for `speed` >= 0.
    fn decay(&self, speed: f64) -> (f64, f64) {
        let ratio = speed / self.stribeck_velocity;
        let power = if self.exponent == 1.0 { ratio } else { libm::pow(ratio, self.exponent) };
        (power, libm::exp(-power))
    }
}

/// `exp(-r^delta)` for integration steps, `r` the sliding speed over the Stribeck velocity.
///
/// A step may reach a little beyond the moment at which the sliding speed vanishes; for Tustin's law the curve is
/// continued smoothly to `r = -1`, so that the step keeps its order, and is constant below.
#[inline(always)]
pub(crate) fn decay(r: f64, exponent: f64) -> f64 {
    let power = if exponent == 1.0 { tustin_power(r) } else { libm::pow(r.abs(), exponent) };
    exp(-power)
}

/// [`decay`] for the exponent 1, Tustin's law; without a branch, for lanes.
#[inline(always)]
pub(crate) fn tustin_decay(r: f64) -> f64 {
    exp(-tustin_power(r))
}

#[inline(always)]
fn tustin_power(r: f64) -> f64 {
    if r < -1.0 { -1.0 } else { r }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(exponent: f64) -> StribeckLaw {
        StribeckLaw { static_coefficient: 0.4, kinetic_coefficient: 0.25, stribeck_velocity: 0.7, exponent }
    }

    #[test]
    fn the_coefficient_falls_from_static_to_kinetic() {
        for exponent in [0.5, 1.0, 2.0, 3.7] {
            let law = law(exponent);
            assert_eq!(law.coefficient(0.0), 0.4);
            assert!((law.coefficient(1e9) - 0.25).abs() < 1e-15);
            assert_eq!(law.coefficient(-0.3), law.coefficient(0.3));
            let curve: Vec<f64> = (0..100).map(|i| law.coefficient(0.05 * f64::from(i))).collect();
            assert!(curve.windows(2).all(|pair| pair[1] <= pair[0]), "exponent {exponent}");
        }
    }

    #[test]
    fn weakening_is_the_slope_of_the_coefficient() {
        for exponent in [0.5, 1.0, 2.0, 3.7] {
            let law = law(exponent);
            for speed in [0.01, 0.1, 0.7, 1.3, 2.0] {
                let step = 1e-5 * speed;
                let slope = (law.coefficient(speed + step) - law.coefficient(speed - step)) / (2.0 * step);
                let expected = -0.15 * law.weakening(speed);
                assert!(
                    (slope - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                    "{exponent} {speed}: {slope} {expected}"
                );
            }
        }
    }

    #[test]
    fn nothing_in_a_range_is_steeper_than_the_steepest() {
        for exponent in [0.5, 1.0, 1.3, 2.0, 3.7] {
            let law = law(exponent);
            for (from, to) in [(0.01, 3.0), (0.6, 0.8), (1.0, 3.0), (0.01, 0.1)] {
                let steepest = law.weakening(law.steepest_between(from, to));
                for i in 0..=1000 {
                    let speed = from + (to - from) * f64::from(i) / 1000.0;
                    assert!(law.weakening(speed) <= steepest * (1.0 + 1e-12), "{exponent} {from} {to} {speed}");
                }
            }
        }
    }

    #[test]
    fn weakening_vanishes_without_nan_at_extreme_speed() {
        for exponent in [0.5, 1.0, 2.0, 10.0] {
            assert_eq!(law(exponent).weakening(1e300), 0.0);
        }
    }
}
