//! Means and standard deviations against independent ones.

use super::*;

/// Mean and standard deviation by the trapezoidal rule over z, which converges exponentially for these smooth
/// integrands.
fn moments(marginal: &Marginal, relative_std: f64) -> (f64, f64) {
    const STEP: f64 = 1.0 / 64.0;
    let integral = |power: i32, centre: f64| -> f64 {
        (-12 * 64..=12 * 64)
            .map(|i| {
                let z = f64::from(i) * STEP;
                (marginal.value(EXPECTED, relative_std, z) - centre).powi(power) * normal::density(z) * STEP
            })
            .sum()
    };
    let mean = integral(1, 0.0);
    (mean, integral(2, mean).sqrt())
}

#[test]
fn inputs_have_the_stated_expected_value_and_standard_deviation() {
    for (marginal, stds) in [
        (Marginal::Normal, &[0.0, 0.05, 0.5, 1.0][..]),
        (Marginal::Lognormal, &[0.0, 0.05, 0.5, 1.0]),
        (Marginal::Uniform, &[0.0, 0.05, 0.5, WIDEST_UNIFORM]),
        (Marginal::Weibull, &[0.0, 1e-7, 0.05, 0.5, 1.0, 1.5]),
        (Marginal::Gumbel, &[0.0, 0.05, 0.5, 1.5]),
        (BETA, &[0.0, 1e-4, 0.05, 0.25, 0.35]),
        (Marginal::Beta { low: 0.0, high: 4.0 }, &[0.05, 0.3, 0.6]),
    ] {
        for &relative_std in stds {
            let (mean, std) = moments(&marginal, relative_std);
            assert!((mean - EXPECTED).abs() < 1e-10, "{marginal:?}, {relative_std}: mean {mean}");
            let stated = relative_std * EXPECTED;
            assert!((std - stated).abs() < 1e-10, "{marginal:?}, {relative_std}: standard deviation {std}");
        }
    }
}

#[test]
fn truncation_shifts_and_narrows() {
    // scipy.stats.truncnorm(low, high, loc=0.39, scale=0.0975).mean() and .std(), SciPy 1.17.1, with the last
    // digits from mpmath 1.3.
    for (low, high, mean, std) in [
        (-2.0, 3.0, 0.3949513414933007, 0.09110636233966429),
        (-4.0, 4.0, 0.39, 0.09744778892619027),
        (1.0, 2.0, 0.5248589820465764, 0.02629661691156946),
        (4.0, 6.0, 0.8019908258511043, 0.02103768004605845),
        (f64::NEG_INFINITY, 1.0, 0.36195900283343013, 0.07736895536430523),
        (-6.0, -5.5, -0.16036001339883596, 0.011683969176994368),
        (f64::NEG_INFINITY, f64::INFINITY, 0.39, 0.0975),
    ] {
        let (computed_mean, computed_std) = moments(&truncated(low, high), 0.25);
        assert!((computed_mean - mean).abs() < 1e-10, "{low}, {high}: mean {computed_mean}");
        assert!((computed_std - std).abs() < 1e-10, "{low}, {high}: standard deviation {computed_std}");
    }
}

#[test]
fn triangles_have_the_stated_expected_value_and_standard_deviation() {
    // With p = mode t^2 below the peak and 1 - p = (1 - mode) t^2 above it, the rule is exact.
    for mode in [0.0, 0.125, 0.5, 1.0] {
        let marginal = Marginal::Triangular { mode };
        let integral = |f: &dyn Fn(f64) -> f64| -> f64 {
            let term = |t: f64| {
                let below = f(marginal.value(EXPECTED, 0.25, normal::quantile(mode * t * t)));
                let above = f(marginal.value(EXPECTED, 0.25, -normal::quantile((1.0 - mode) * t * t)));
                t * (if mode > 0.0 { mode * below } else { 0.0 } + if mode < 1.0 { (1.0 - mode) * above } else { 0.0 })
            };
            NODES_32.iter().map(|(node, weight)| weight * (term(0.5 - 0.5 * node) + term(0.5 + 0.5 * node))).sum()
        };
        let mean = integral(&|x| x);
        let variance = integral(&|x| (x - EXPECTED) * (x - EXPECTED));
        assert!((mean - EXPECTED).abs() < 1e-13, "{mode}: mean {mean}");
        assert!((variance.sqrt() / (0.25 * EXPECTED) - 1.0).abs() < 1e-12, "{mode}: {variance}");
    }
}

#[test]
fn moments_are_those_of_the_inputs() {
    for marginal in [truncated(-2.0, 3.0), truncated(1.0, 2.0), truncated(f64::NEG_INFINITY, 1.0), BETA] {
        let (mean, std) = moments(&marginal, 0.25);
        let (stated_mean, stated_std) = marginal.moments(EXPECTED, 0.25);
        assert!((mean - stated_mean).abs() < 1e-10 && (std - stated_std).abs() < 1e-10, "{marginal:?}: {mean} {std}");
    }
    // The closed form with 60 digits, by mpmath 1.4; narrow and far intervals among them.
    for (low, high, mean, std) in [
        (-2.0, 3.0, 0.050_782_989_674_878_97, 0.934_424_229_124_762),
        (0.0, 0.000_976_562_5, 0.000_488_281_211_194_893_95, 0.000_281_909_306_646_917_55),
        (7.0, 9.0, 7.137_545_439_418_038, 0.135_135_375_527_677_24),
        (1.0, 2.0, 1.383_169_046_631_552_7, 0.269_708_891_400_712_4),
        (-0.25, f64::INFINITY, 0.645_839_371_016_817_3, 0.649_177_682_988_561_7),
    ] {
        let (computed_mean, computed_std) = truncation::moments(low, high);
        assert!((computed_mean / mean - 1.0).abs() < 1e-13, "{low} {high}: {computed_mean}");
        assert!((computed_std / std - 1.0).abs() < 1e-13, "{low} {high}: {computed_std}");
    }
}
