//! Deviates as the inverse of quantiles.

use super::*;

/// Every distribution, with a relative standard deviation.
fn all() -> Vec<(Marginal, f64)> {
    vec![
        (Marginal::Normal, 0.25),
        (Marginal::Lognormal, 0.25),
        (Marginal::Lognormal, 3.0),
        (Marginal::Uniform, 0.25),
        (Marginal::Uniform, WIDEST_UNIFORM),
        (truncated(-2.0, 3.0), 0.25),
        (truncated(1.0, f64::INFINITY), 0.25),
        (truncated(f64::NEG_INFINITY, -1.5), 0.25),
        (Marginal::Weibull, 0.25),
        (Marginal::Weibull, 3.0),
        (Marginal::Gumbel, 0.25),
        (SYMMETRIC, 0.25),
        (Marginal::Triangular { mode: 0.0 }, 0.25),
        (Marginal::Triangular { mode: 1.0 }, 0.25),
        (BETA, 0.25),
        (Marginal::Empirical(Empirical::new(&MEASURED).unwrap()), 0.0),
    ]
}

/// The distributions of an input that scatters relatively, and absolutely.
fn distributions(marginal: &Marginal, std: f64) -> [InputDistribution; 2] {
    let absolute = if matches!(marginal, Marginal::Empirical(_)) {
        InputDistribution::relative(marginal, 2.0, 0.0)
    } else {
        InputDistribution::absolute(marginal, EXPECTED, std * EXPECTED)
    };
    [InputDistribution::relative(marginal, EXPECTED, std), absolute]
}

#[test]
fn deviates_are_those_of_their_values_in_both_tails() {
    for (marginal, std) in all() {
        for (place, distribution) in distributions(&marginal, std).into_iter().enumerate() {
            for i in -40..=40 {
                let z = 0.2 * f64::from(i);
                let value = distribution.value(z);
                let step = 1e-3;
                let slope = (distribution.value(z + step) - distribution.value(z - step)) / (2.0 * step);
                let [least, greatest] = [End::Least, End::Greatest].map(|end| distribution.deviate(value, end));
                // A shift rounds small values.
                let is_shifted = place == 1 && !matches!(marginal, Marginal::Lognormal | Marginal::Weibull);
                let size = value.abs() + if is_shifted { EXPECTED } else { 0.0 };
                if slope < 1e-8 * size {
                    // Equal measured values, or too close to an end for values to distinguish deviates.
                    let is_between = least < z && z < greatest;
                    let is_far = least * z > 0.0 && least.abs() > 5.0;
                    assert!(is_between || is_far, "{marginal:?} {z}: {least} {greatest}");
                    continue;
                }
                let tolerance = 4e-15 * (1.0 + z.abs()) + 2e-15 * size / slope;
                assert!((least - z).abs() < tolerance, "{marginal:?} {z}: {least}");
                assert!((greatest - z).abs() < tolerance, "{marginal:?} {z}: {greatest}");
            }
        }
    }
}

#[test]
fn tails_of_distributions_in_closed_form_keep_their_digits() {
    // Upper tails 1e-3 to 1e-15 of distributions whose tails are elementary.
    for exponent in [3, 6, 9, 12, 15] {
        let tail = 10.0_f64.powi(-exponent);
        let deviate = normal::upper_quantile(tail);
        // Exponential.
        let exponential = InputDistribution::relative(&Marginal::Weibull, 2.0, 1.0);
        assert!((exponential.deviate(-2.0 * tail.ln(), End::Least) / deviate - 1.0).abs() < 1e-14);
        // Its lower tail is 1 - exp(-x).
        assert!((exponential.deviate(-2.0 * (-tail).ln_1p(), End::Least) / deviate + 1.0).abs() < 1e-14);
        let scale = 0.5 * 6.0_f64.sqrt() / std::f64::consts::PI;
        let gumbel = InputDistribution::relative(&Marginal::Gumbel, 1.0, 0.5);
        let location = 1.0 - scale * 0.577_215_664_901_532_9;
        let value = location - scale * (-(-tail).ln_1p()).ln();
        assert!((gumbel.deviate(value, End::Least) / deviate - 1.0).abs() < 1e-13, "{exponent}");
        let lognormal = InputDistribution::relative(&Marginal::Lognormal, 1.0, 0.5);
        let log_std = 1.25_f64.ln().sqrt();
        let value = (log_std * deviate - 0.5 * log_std * log_std).exp();
        assert!((lognormal.deviate(value, End::Least) / deviate - 1.0).abs() < 1e-14);
        // From zero, whose distance from small values is exact.
        let uniform = InputDistribution::relative(&Marginal::Uniform, 1.0, WIDEST_UNIFORM);
        let width = 2.0 * WIDEST_UNIFORM * 3.0_f64.sqrt();
        let value = (1.0 - 0.5 * width) + width * tail;
        assert!((uniform.deviate(value, End::Least) + deviate).abs() < 1e-15 / tail / deviate, "{exponent}");
    }
}

#[test]
fn beyond_its_ends_a_distribution_has_no_deviate() {
    for (marginal, std) in all() {
        let [distribution, _] = distributions(&marginal, std);
        for kink in distribution.kinks() {
            assert!(kink >= 0.0 && kink.is_finite(), "{marginal:?}");
        }
        let kinks = distribution.kinks();
        let is_bounded = matches!(
            marginal,
            Marginal::Uniform | Marginal::Triangular { .. } | Marginal::Beta { .. } | Marginal::Empirical(_)
        );
        if let (true, &[first, .., last]) = (is_bounded, &kinks[..]) {
            for end in [End::Least, End::Greatest] {
                assert_eq!(distribution.deviate(0.999 * first - 1e-9, end), f64::NEG_INFINITY, "{marginal:?}");
                assert_eq!(distribution.deviate(1.001 * last, end), f64::INFINITY, "{marginal:?}");
            }
        }
    }
    for distribution in [InputDistribution::relative(&Marginal::Normal, 0.0, 0.2), InputDistribution::fixed(0.0)] {
        assert!(!distribution.scatters() && distribution.kinks().is_empty());
        assert_eq!(distribution.deviate(0.1, End::Least), f64::INFINITY);
        assert_eq!(distribution.deviate(-0.1, End::Greatest), f64::NEG_INFINITY);
        assert_eq!(distribution.deviate(0.0, End::Least), f64::NEG_INFINITY);
        assert_eq!(distribution.deviate(0.0, End::Greatest), f64::INFINITY);
    }
}

#[test]
fn equal_measured_values_fill_an_interval_of_deviates() {
    // Two of four, at the probabilities 1.5/4 and 2.5/4.
    let measured = Marginal::Empirical(Empirical::new(&[0.25, 0.5, 0.5, 0.75]).unwrap());
    let distribution = InputDistribution::relative(&measured, 0.5, 0.0);
    let both = |value: f64| [End::Least, End::Greatest].map(|end| distribution.deviate(value, end));
    assert_eq!(both(0.5), [1.5, 2.5].map(|position| normal::quantile(position / 4.0)));
    // The first and the last half of a value are constant.
    assert_eq!(both(0.25), [f64::NEG_INFINITY, normal::quantile(0.5 / 4.0)]);
    assert_eq!(both(0.75), [-normal::quantile(0.5 / 4.0), f64::INFINITY]);
    assert_eq!(distribution.kinks(), [0.25, 0.5, 0.75]);
}

#[test]
fn an_input_without_scatter_has_all_its_deviates_at_its_value() {
    use crate::inputs::end::End;
    use crate::inputs::transform::Transform;
    // The least deviate whose value is as large, and the greatest whose value is as small.
    let fixed = Transform::Fixed;
    let ends = |value: f64| [End::Least, End::Greatest].map(|end| fixed.deviate(value, end));
    assert_eq!(ends(1.0), [f64::NEG_INFINITY, f64::INFINITY]);
    assert_eq!(ends(0.9), [f64::NEG_INFINITY; 2]);
    assert_eq!(ends(1.1), [f64::INFINITY; 2]);
}

#[test]
fn deviates_far_out_in_a_truncated_tail_are_those_of_their_values() {
    use crate::inputs::end::End;
    use crate::inputs::transform::Transform;
    for (low, high) in [(6.0, 9.0), (-9.0, -6.0), (-1.0, 2.0)] {
        let transform = Transform::new(&Marginal::TruncatedNormal { low, high }, 0.05);
        for z in [-2.5, -1.0, 0.0, 0.7, 2.5] {
            let found = transform.deviate(transform.value(1.0, z), End::Least);
            assert!((found - z).abs() < 1e-6, "{low} {high}: {found} for {z}");
        }
    }
}
