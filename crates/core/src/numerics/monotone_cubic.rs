//! Monotone cubic interpolation (PCHIP): slopes at the knots with which piecewise cubics do not overshoot.

/// The slopes of Fritsch and Butland (1984) at the knots `x` of a curve with the values `y`: between two knots the
/// curve is then monotone, and everywhere its slope is continuous. There are at least two knots, in rising order.
///
/// Inside, the slope is the weighted harmonic mean of the secants on both sides, and zero where these differ in sign.
/// At an end beyond which the curve is constant it is zero; at another one it is that of the parabola through three
/// points, limited as the secant demands. These are the slopes of SciPy's `PchipInterpolator` for the same knots and,
/// beyond an end with a constant curve, one more of the same value.
pub(crate) fn monotone_slopes(x: &[f64], y: &[f64], is_constant_before: bool, is_constant_after: bool) -> Vec<f64> {
    let last = x.len() - 1;
    let width = |i: usize| x[i + 1] - x[i];
    let secant = |i: usize| (y[i + 1] - y[i]) / width(i);
    let inside = |i: usize| {
        let (before, after) = (secant(i - 1), secant(i));
        if before * after <= 0.0 {
            return 0.0;
        }
        let (first, second) = (2.0 * width(i) + width(i - 1), width(i) + 2.0 * width(i - 1));
        (first + second) / (first / before + second / after)
    };
    (0..=last)
        .map(|i| match i {
            0 if is_constant_before => 0.0,
            0 if last == 1 => secant(0),
            0 => end_slope((width(0), width(1)), (secant(0), secant(1))),
            i if i < last => inside(i),
            _ if is_constant_after => 0.0,
            _ if last == 1 => secant(0),
            i => end_slope((width(i - 1), width(i - 2)), (secant(i - 1), secant(i - 2))),
        })
        .collect()
}

/// The slope at an end from the widths and secants of its two nearest intervals, the nearer one first.
fn end_slope((near, far): (f64, f64), (at_end, next): (f64, f64)) -> f64 {
    let slope = ((2.0 * near + far) * at_end - near * next) / (near + far);
    if slope * at_end <= 0.0 {
        0.0
    } else if at_end * next <= 0.0 && slope.abs() > 3.0 * at_end.abs() {
        3.0 * at_end
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_are_scipys() {
        // scipy 1.17.1, PchipInterpolator(x, y).derivative()(x).
        let x = [0.0, 0.1, 0.25, 0.7, 1.0, 2.5, 2.7];
        let y = [0.45, 0.41, 0.3, 0.27, 0.29, 0.36, 0.36];
        let expected = [
            -0.266_666_666_666_667_16,
            -0.507_692_307_692_307_9,
            -0.141_935_483_870_967_63,
            0.0,
            0.057_142_857_142_857_086,
            0.0,
            0.0,
        ];
        for (slope, expected) in monotone_slopes(&x, &y, false, false).into_iter().zip(expected) {
            assert!((slope - expected).abs() < 1e-14, "{slope} {expected}");
        }
        let flat = monotone_slopes(&x, &y, true, true);
        assert_eq!((flat[0], flat[6]), (0.0, 0.0));
        assert_eq!(flat[1..6], monotone_slopes(&x, &y, false, false)[1..6]);
    }

    #[test]
    fn two_knots_make_a_line() {
        assert_eq!(monotone_slopes(&[0.0, 2.0], &[1.0, 0.0], false, false), [-0.5, -0.5]);
        assert_eq!(monotone_slopes(&[0.0, 2.0], &[1.0, 0.0], false, true), [-0.5, 0.0]);
    }

    #[test]
    fn an_end_that_would_overshoot_is_limited() {
        assert_eq!(end_slope((1.0, 1.0), (1.0, 5.0)), 0.0);
        assert_eq!(end_slope((1.0, 0.1), (1.0, -40.0)), 3.0);
    }
}
