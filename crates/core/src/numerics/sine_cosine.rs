//! Sine and cosine together, by their series for the small angles of a pad.

/// Angles up to which the series of sine and cosine are exact to the last place.
pub(crate) const SERIES_ANGLE: f64 = 0.25;

/// Sine and cosine of the pad's angle: series for the small angles of a pad, `libm` beyond.
#[inline(always)]
pub(crate) fn sine_and_cosine(angle: f64) -> (f64, f64) {
    if angle.abs() > SERIES_ANGLE {
        return (libm::sin(angle), libm::cos(angle));
    }
    small_sine_and_cosine(angle)
}

/// The series alone.
#[inline(always)]
pub(crate) fn small_sine_and_cosine(angle: f64) -> (f64, f64) {
    let s = angle * angle;
    let sine =
        ((((-1.0 / 39_916_800.0 * s + 1.0 / 362_880.0) * s - 1.0 / 5040.0) * s + 1.0 / 120.0) * s - 1.0 / 6.0) * s;
    let cosine = (((((1.0 / 479_001_600.0 * s - 1.0 / 3_628_800.0) * s + 1.0 / 40_320.0) * s - 1.0 / 720.0) * s
        + 1.0 / 24.0)
        * s
        - 0.5)
        * s;
    (angle + angle * sine, 1.0 + cosine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_libms() {
        for i in -400..=400 {
            let angle = 1e-3 * f64::from(i);
            let (sine, cosine) = sine_and_cosine(angle);
            assert!((sine - libm::sin(angle)).abs() <= 1e-16 * (1.0 + angle.abs()), "{angle}");
            assert!((cosine - libm::cos(angle)).abs() <= 2.3e-16, "{angle}");
        }
    }
}
