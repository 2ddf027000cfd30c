//! Probabilities against closed forms, brute force, limits and properties.

use super::*;
use crate::inputs::{Empirical, Marginal};
use crate::integrate::NormalPair;
use crate::integrate::closed_form;
use crate::special_functions::normal::{density, upper_tail};
use proptest::prelude::*;
use stickslip_core::friction::measured_curve::{MeasuredCurve, SharedCurve};
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

const TOLERANCE: f64 = 1e-9;

/// The boundary of the preset with some parameters changed.
fn boundary(changes: &[(&str, f64)]) -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    for (key, value) in changes {
        parameters.set(key, *value).unwrap();
    }
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

/// A hyperbola through the origin: kinetic friction of 0.
fn product_boundary() -> PairBoundary {
    boundary(&[("friction.kinetic_coefficient", 0.0)])
}

fn lognormal(median: f64, log_std: f64) -> InputDistribution {
    let relative_std = (log_std * log_std).exp_m1().sqrt();
    InputDistribution::relative(&Marginal::Lognormal, median * (0.5 * log_std * log_std).exp(), relative_std)
}

#[test]
fn a_product_of_lognormal_inputs_has_the_tail_of_a_normal_sum() {
    let boundary = product_boundary();
    let product = boundary.critical_product;
    for coefficient in [-0.999_9, -0.9, -0.5, 0.0, 0.3, 0.8, 0.999_9] {
        for (first, second) in [(0.2_f64, 0.1), (0.05, 0.4), (0.3, 0.3), (1e-3, 0.2), (0.2, 1e-3)] {
            for tail in [0.5, 0.9, 1e-3, 1e-6, 1e-9, 1e-12, 1e-15] {
                // Without cancellation.
                let variance = (first - second).powi(2) + 2.0 * (1.0 + coefficient) * first * second;
                let deviate =
                    if tail > 0.5 { -normal::upper_quantile(1.0 - tail) } else { normal::upper_quantile(tail) };
                // The product exceeds the critical one with the probability of the tail.
                let friction = 0.4;
                let preload = product / friction / (deviate * variance.sqrt()).exp();
                let pair = Pair::new(lognormal(preload, first), lognormal(friction, second));
                let law = PairLaw::correlated(coefficient);
                let exact = pair.exact_probability(&boundary, &law);
                let error = (exact.value / tail - 1.0).abs();
                assert!(error < 1e-11, "{coefficient} {first} {second} {tail}: {exact:?}");
                assert!(
                    (exact.value - tail).abs() < exact.error_bound,
                    "{coefficient} {first} {second} {tail}: {exact:?}"
                );
                let fast = pair.probability(&boundary, &law, 1e-8);
                assert!((fast / tail - 1.0).abs() < 1e-8, "{coefficient} {first} {second} {tail}: {fast}");
            }
        }
    }
}

#[test]
fn the_law_given_other_inputs_shifts_and_narrows() {
    // The closed form of the product, with expected deviates and a factor of its own.
    let boundary = product_boundary();
    for law in [
        PairLaw { mean: [1.5, -0.7], factor: [0.6, 0.2, 0.5] },
        PairLaw { mean: [-3.0, -2.0], factor: [0.9, -0.4, 0.1] },
        PairLaw { mean: [-4.0, 4.0], factor: [0.3, -0.1, 0.02] },
    ] {
        let (first, second) = (0.2, 0.15);
        let [a, b, c] = law.factor;
        let std = (first * a + second * b).hypot(second * c);
        let mean = first * law.mean[0] + second * law.mean[1];
        for tail in [0.3, 1e-3, 1e-6, 1e-9] {
            let median = boundary.critical_product / 0.4 * (-mean - normal::upper_quantile(tail) * std).exp();
            let pair = Pair::new(lognormal(median, first), lognormal(0.4, second));
            let value = pair.probability(&boundary, &law, TOLERANCE);
            assert!((value / tail - 1.0).abs() < 1e-10, "{law:?} {tail}: {value}");
        }
    }
}

/// The probability by the other order of integration: a midpoint rule over the deviate of the friction, of the
/// conditional probability of the preload.
fn over_friction(
    boundary: &PairBoundary,
    coefficient: f64,
    friction: impl Fn(f64) -> f64,
    preload_deviate: impl Fn(f64) -> f64,
) -> f64 {
    let (points, limit) = (40_000, 9.0);
    let step = 2.0 * limit / f64::from(points);
    let rest = (1.0 - coefficient * coefficient).sqrt();
    let point = |i: u32| -limit + step * (f64::from(i) + 0.5);
    let term = |z: f64| {
        let critical = boundary.critical_first(friction(z));
        let deviate = if critical.is_finite() { preload_deviate(critical) } else { f64::INFINITY };
        density(z) * upper_tail((deviate - coefficient * z) / rest)
    };
    (0..points).map(point).map(term).sum::<f64>() * step
}

/// The deviate with this probability below it.
fn deviate_of(below: f64, above: f64) -> f64 {
    match (below, above) {
        (below, _) if below < 1e-290 => f64::NEG_INFINITY,
        (_, above) if above < 1e-290 => f64::INFINITY,
        (below, above) if below < above => -normal::upper_quantile(below),
        (_, above) => normal::upper_quantile(above),
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn other_distributions_agree_with_the_other_order_of_integration() {
    let boundary = boundary(&[("operating_point.rotating_speed", 16.0)]);
    let root = 3.0_f64.sqrt();
    for (preload, friction) in [(0.1, 0.39), (0.05, 0.42), (0.2, 0.3)] {
        for coefficient in [-0.95, -0.4, 0.0, 0.5, 0.95] {
            let law = PairLaw::correlated(coefficient);
            let check = |marginals: [(&Marginal, f64); 2], other: f64| {
                let [first, second] = marginals;
                let pair = Pair::new(
                    InputDistribution::relative(first.0, preload, first.1),
                    InputDistribution::relative(second.0, friction, second.1),
                );
                let exact = pair.exact_probability(&boundary, &law);
                let error = (exact.value - other).abs();
                assert!(error < 2e-6 * other.max(1e-3), "{marginals:?} {coefficient}: {exact:?} {other}");
                let fast = pair.probability(&boundary, &law, 1e-8);
                assert!(
                    (fast - exact.value).abs() <= 1e-8 * exact.value,
                    "{marginals:?} {coefficient}: {exact:?} {fast}"
                );
                exact.value
            };
            // Quantiles and distribution functions as textbooks have them.
            let uniform = |z: f64| friction * (1.0 + 0.2 * root * (upper_tail(-z) - upper_tail(z)));
            let exponential = |x: f64| deviate_of(-(-x / preload).exp_m1(), (-x / preload).exp());
            let value = over_friction(&boundary, coefficient, uniform, exponential);
            check([(&Marginal::Weibull, 1.0), (&Marginal::Uniform, 0.2)], value);
            let scale = 0.3 * preload * 6.0_f64.sqrt() / std::f64::consts::PI;
            let location = preload - scale * 0.577_215_664_901_532_9;
            let gumbel = |x: f64| {
                let exponential = (-(x - location) / scale).exp();
                deviate_of((-exponential).exp(), -(-exponential).exp_m1())
            };
            let normal = |z: f64| friction * (1.0 + 0.15 * z);
            let value = over_friction(&boundary, coefficient, normal, gumbel);
            check([(&Marginal::Gumbel, 0.3), (&Marginal::Normal, 0.15)], value);
            // A symmetric triangle, and a normal distribution without its lower half.
            let half = 0.2 * preload * 6.0_f64.sqrt();
            let triangle = |x: f64| {
                let (from, to) = ((x - preload + half) / half, (preload + half - x) / half);
                let (below, above) = (0.5 * from.max(0.0).powi(2), 0.5 * to.max(0.0).powi(2));
                if x < preload { deviate_of(below, 1.0 - below) } else { deviate_of(1.0 - above, above) }
            };
            let cut = |z: f64| {
                let above = 0.5 * upper_tail(z);
                friction * (1.0 + 0.2 * if above < 0.5 { normal::upper_quantile(above) } else { 0.0 })
            };
            let value = over_friction(&boundary, coefficient, cut, triangle);
            let truncated = Marginal::TruncatedNormal { low: 0.0, high: f64::INFINITY };
            check([(&Marginal::Triangular { mode: 0.5 }, 0.2), (&truncated, 0.2)], value);
            // A beta distribution with shapes 1 and 1 is uniform from half to one and a half of the expected value.
            let beta = Marginal::Beta { low: 0.5, high: 1.5 };
            let uniform_beta = |x: f64| deviate_of(x / preload - 0.5, 1.5 - x / preload);
            let value = over_friction(&boundary, coefficient, normal, uniform_beta);
            check([(&beta, 1.0 / 12.0_f64.sqrt()), (&Marginal::Normal, 0.15)], value);
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn measured_values_are_integrated_with_their_steps() {
    let boundary = boundary(&[("operating_point.rotating_speed", 16.0)]);
    // Equal ones make steps, their quantiles are piecewise straight.
    let frictions = [0.3, 0.34, 0.36, 0.36, 0.4, 0.41, 0.48, 0.55];
    let preloads = [0.06, 0.1, 0.1, 0.1, 0.14];
    let quantile = |values: &[f64], z: f64| {
        let position = upper_tail(-z) * values.len() as f64 - 0.5;
        let position = position.clamp(0.0, (values.len() - 1) as f64);
        let below = (position as usize).min(values.len() - 2);
        let share = position - below as f64;
        values[below] * (1.0 - share) + values[below + 1] * share
    };
    let measured = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        InputDistribution::relative(&Marginal::Empirical(Empirical::new(values).unwrap()), mean, 0.0)
    };
    let pair = Pair::new(measured(&preloads), measured(&frictions));
    for coefficient in [-0.8, 0.0, 0.6] {
        let exact = pair.exact_probability(&boundary, &PairLaw::correlated(coefficient));
        // A midpoint rule over both deviates.
        let points = 4000;
        let step = 16.0 / f64::from(points);
        let rest = (1.0 - coefficient * coefficient).sqrt();
        let deviates: Vec<f64> = (0..points).map(|i| -8.0 + step * (f64::from(i) + 0.5)).collect();
        let mut other = 0.0;
        for &u in &deviates {
            let preload = quantile(&preloads, u);
            for &w in &deviates {
                if boundary.verdict(preload, quantile(&frictions, coefficient * u + rest * w)) == Verdict::Unstable {
                    other += density(u) * density(w) * step * step;
                }
            }
        }
        // The rule misplaces the boundary by up to half a step.
        assert!((exact.value - other).abs() < 5e-4, "{coefficient}: {exact:?} {other}");
        assert!(exact.error_bound < 1e-10, "{exact:?}");
    }
    // Independent inputs, of which the preload has a finite number of values: a sum in closed form.
    let step = Empirical::new(&[0.1, 0.1, 0.1, 0.2, 0.2, 0.2]).unwrap();
    let step = InputDistribution::relative(&Marginal::Empirical(step), 0.15, 0.0);
    let friction = InputDistribution::relative(&Marginal::Normal, 0.39, 0.1);
    let exact = Pair::new(step, friction).exact_probability(&boundary, &PairLaw::correlated(0.0));
    let tail = |preload: f64| upper_tail((boundary.critical_second(preload) / 0.39 - 1.0) / 0.1);
    // A sixth of the preloads lies evenly between the two.
    let between: f64 = (0..20_000).map(|i| tail(0.1 + 0.1 * (f64::from(i) + 0.5) / 20_000.0)).sum();
    let expected = 2.5 / 6.0 * (tail(0.1) + tail(0.2)) + between / 20_000.0 / 6.0;
    assert!((exact.value / expected - 1.0).abs() < 1e-9, "{exact:?} {expected}");
}

fn normal_pair(preload: f64, friction: f64, preload_std: f64, friction_std: f64) -> Pair {
    Pair::new(
        InputDistribution::relative(&Marginal::Normal, preload, preload_std),
        InputDistribution::relative(&Marginal::Normal, friction, friction_std),
    )
}

/// The boundary of a brake whose measured curve falls only because it is shifted by its standard deviations: unstable
/// is a static friction below it.
fn shifted_boundary() -> PairBoundary {
    let deviations = [0.08, 0.02, 0.01];
    let curve = MeasuredCurve::new(&[0.0, 1.0, 4.0], &[0.3, 0.32, 0.33], Some(&deviations)).unwrap();
    let mut parameters = Parameters::sui_ding_2018();
    parameters.friction.use_table(SharedCurve::new(curve));
    parameters.friction.band = 2.0;
    parameters.damping.tangential = 500.0;
    parameters.operating_point.rotating_speed = 1.0;
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

#[test]
fn independent_normal_inputs_have_the_integral_of_their_own() {
    let brake = boundary(&[("operating_point.rotating_speed", 15.0)]);
    let undamped = boundary(&[("damping.tangential", 0.0)]);
    for boundary in [brake, undamped, shifted_boundary()] {
        for (preload, friction) in [(0.1, 0.39), (0.3, 0.5), (0.05, 0.45), (0.2, 0.3), (0.0, 0.4), (0.1, 0.0)] {
            for (first, second) in
                [(0.2, 0.2), (0.5, 0.05), (0.02, 0.3), (1e-4, 0.1), (0.1, 1e-4), (0.0, 0.2), (0.2, 0.0), (0.0, 0.0)]
            {
                let cell = NormalPair { expected: [preload, friction], relative_std: [first, second] };
                let plain = closed_form::probability(&boundary, &cell);
                let pair = normal_pair(preload, friction, first, second);
                let exact = pair.exact_probability(&boundary, &PairLaw::correlated(0.0));
                let error = (exact.value - plain.value).abs();
                assert!(error < 1e-13 + plain.error_bound + exact.error_bound, "{cell:?}: {exact:?} {plain:?}");
                assert!(exact.error_bound < 1e-10, "{cell:?}: {exact:?}");
            }
        }
    }
}

#[test]
fn the_probability_of_inputs_of_which_one_follows_the_other_is_a_single_tail() {
    // As the correlation approaches 1, both inputs follow one deviate: the boundary is passed at the root of
    // Delta (1 + a z) (f_s (1 + b z) - f_c) = C.
    let boundary = boundary(&[]);
    let (a, b, preload) = (0.2, 0.1, 0.1);
    let f_c = boundary.asymptote();
    for friction in [0.3, 0.35, 0.39, 0.45] {
        let (p, q, r) = (
            a * b * friction,
            b * friction + a * (friction - f_c),
            friction - f_c - boundary.critical_product / preload,
        );
        let root = (-q + (q * q - 4.0 * p * r).sqrt()) / (2.0 * p);
        let pair = normal_pair(preload, friction, a, b);
        for (distance, tolerance) in [(1e-6, 1e-5), (1e-12, 1e-10)] {
            let value = pair.probability(&boundary, &PairLaw::correlated(1.0 - distance), TOLERANCE);
            assert!((value - upper_tail(root)).abs() < tolerance, "{friction}: {value} {}", upper_tail(root));
        }
    }
    // Opposite deviates: Delta grows as f_s falls, and the product has a greatest value between two roots.
    for friction in [0.39, 0.395, 0.398, 0.4, 0.45] {
        let (p, q, r) = (
            -a * b * friction,
            -b * friction + a * (friction - f_c),
            friction - f_c - boundary.critical_product / preload,
        );
        let discriminant = q * q - 4.0 * p * r;
        let expected = if discriminant > 0.0 {
            let [from, to] = [1.0, -1.0].map(|sign| (-q + sign * discriminant.sqrt()) / (2.0 * p));
            upper_tail(from) - upper_tail(to)
        } else {
            0.0
        };
        let pair = normal_pair(preload, friction, a, b);
        let value = pair.probability(&boundary, &PairLaw::correlated(-1.0 + 1e-12), TOLERANCE);
        assert!((value - expected).abs() < 1e-6, "{friction}: {value} {expected}");
    }
}

#[test]
fn a_boundary_beyond_the_support_gives_certainty() {
    let boundary = boundary(&[]);
    let critical = boundary.critical_second(0.1);
    let pair = |friction: f64| {
        Pair::new(InputDistribution::fixed(0.1), InputDistribution::relative(&Marginal::Uniform, friction, 0.01))
    };
    let half_width = 0.01 * 3.0_f64.sqrt();
    for (friction, expected) in
        [(0.9 * critical, 0.0), (1.1 * critical, 1.0), (critical / (1.0 + 0.5 * half_width), 0.25)]
    {
        let exact = pair(friction).exact_probability(&boundary, &PairLaw::correlated(0.7));
        assert!((exact.value - expected).abs() < 1e-12, "{friction}: {exact:?}");
    }
    // Both uniform, and unstable only in a corner that the boundary cuts off: nearly a triangle.
    for share in [1e-2, 1e-4] {
        let corner = [0.1 * (1.0 + half_width), critical * (1.0 + half_width)];
        let scale = (boundary.critical_product / (corner[0] * (corner[1] - boundary.asymptote()))).sqrt();
        let (first, second) = (
            0.1 * scale * (1.0 + share),
            boundary.asymptote() + scale * (1.0 + share) * (corner[1] - boundary.asymptote()),
        );
        let pair = Pair::new(
            InputDistribution::relative(&Marginal::Uniform, first, 0.01),
            InputDistribution::relative(&Marginal::Uniform, second / (1.0 + half_width), 0.01),
        );
        let exact = pair.exact_probability(&boundary, &PairLaw::correlated(0.0));
        // The area above the hyperbola, in closed form, over that of the rectangle.
        let [right, top] = [first * (1.0 + half_width), second - boundary.asymptote()];
        let (product, low) = (boundary.critical_product, second * (1.0 - half_width) / (1.0 + half_width));
        let left = (product / top).max(first * (1.0 - half_width));
        assert!(product / right > low - boundary.asymptote(), "a corner alone");
        let area = (right - left) * top - product * (right / left).ln();
        let expected = area / (2.0 * half_width * first) / (second - low);
        assert!((exact.value / expected - 1.0).abs() < 1e-7 && expected < 0.1, "{share}: {exact:?} {expected}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn probabilities_rise_with_the_inputs_and_are_between_the_bounds_of_all_copulas(
        preload in 0.02..0.4,
        friction in 0.26..0.7,
        first in 0.001..0.5,
        second in 0.001..0.5,
        coefficient in -0.999..0.999,
        choice in 0..5,
    ) {
        let marginal = match choice {
            0 => Marginal::Normal,
            1 => Marginal::Lognormal,
            2 => Marginal::Weibull,
            3 => Marginal::Gumbel,
            _ => Marginal::Uniform,
        };
        let boundary = boundary(&[]);
        let law = PairLaw::correlated(coefficient);
        let probability = |preload: f64, friction: f64| {
            let pair = Pair::new(
                InputDistribution::relative(&marginal, preload, first),
                InputDistribution::relative(&marginal, friction, second),
            );
            pair.probability(&boundary, &law, TOLERANCE)
        };
        let p = probability(preload, friction);
        prop_assert!((0.0..=1.0).contains(&p));
        let margin = 1e-9 * p + 1e-15;
        prop_assert!(probability(1.01 * preload, friction) >= p - margin);
        prop_assert!(probability(preload, 1.01 * friction) >= p - margin);
    }

    #[test]
    fn symmetric_inputs_have_the_same_probability_in_either_order(
        first in 0.05_f64..0.4,
        second in 0.05_f64..0.4,
        coefficient in -0.99..0.99,
        deviate in -3.0_f64..7.0,
    ) {
        // Lognormal inputs with a boundary that is symmetric in both: exchanging their scatter changes nothing.
        let boundary = product_boundary();
        let median = 0.4 * libm::exp(-deviate * first.hypot(second));
        let other = boundary.critical_product / 0.4;
        let probability = |first: f64, second: f64| {
            let pair = Pair::new(lognormal(other, first), lognormal(median, second));
            pair.probability(&boundary, &PairLaw::correlated(coefficient), TOLERANCE)
        };
        let (p, q) = (probability(first, second), probability(second, first));
        prop_assert!((p - q).abs() <= 1e-9 * p + 1e-25, "{} {}", p, q);
    }
}

#[test]
fn the_probability_between_two_boundaries_is_the_difference_without_cancellation() {
    let at = |speed: f64| boundary(&[("operating_point.rotating_speed", speed)]);
    for (preload_std, friction_std) in [(0.2, 0.1), (0.2, 0.0), (0.0, 0.1), (0.3, 0.004)] {
        for (marginal, coefficient) in [(Marginal::Normal, 0.0), (Marginal::Lognormal, 0.6), (Marginal::Weibull, -0.6)]
        {
            let pair = Pair::new(
                InputDistribution::relative(&marginal, 0.1, preload_std),
                InputDistribution::relative(&marginal, 0.4, friction_std),
            );
            let law = PairLaw::correlated(coefficient);
            for speed in [12.0, 16.0, 19.0] {
                let [below, above] = [speed * 0.999, speed * 1.001].map(|speed| {
                    let probability = pair.exact_probability(&at(speed), &law);
                    (at(speed), probability.value)
                });
                let wide = pair.probability_between([&below.0, &above.0], &law, 1e-10);
                assert!((wide - (below.1 - above.1)).abs() < 1e-9 * below.1, "{marginal:?} {speed}: {wide}");
                // A quotient that does not depend on the distance.
                let density = |step: f64| {
                    let ends = [at(speed * (1.0 - step)), at(speed * (1.0 + step))];
                    pair.probability_between([&ends[0], &ends[1]], &law, 1e-10) / step
                };
                let [coarse, fine] = [density(1e-5), density(1e-7)];
                assert!((coarse - fine).abs() <= 1e-5 * fine, "{marginal:?} {speed}: {coarse} {fine}");
            }
        }
    }
}

#[test]
fn the_share_between_two_close_arguments_is_that_of_a_quadrature() {
    // Simpson's rule over so narrow an interval has no error that shows.
    for middle in [-7.0, -1.3, 0.0, 0.4, 2.0, 9.0] {
        for width in [1e-6, 1e-4, 3.9e-3 / (1.0 + f64::abs(middle))] {
            let ends = [middle - 0.5 * width, middle + 0.5 * width];
            let at = |share: f64| density(ends[0] + share * (ends[1] - ends[0]));
            let expected = (ends[1] - ends[0]) * (at(0.0) + 4.0 * at(0.5) + at(1.0)) / 6.0;
            let found = narrow_share(ends);
            assert!((found / expected - 1.0).abs() < 1e-10, "{middle} {width}: {found:e} {expected:e}");
        }
    }
}

#[test]
fn the_probability_of_stability_has_its_digits_where_it_is_small() {
    // The closed form of the product, seen from its other end.
    let boundary = product_boundary();
    for coefficient in [-0.9, 0.0, 0.5, 0.999] {
        for (first, second) in [(0.2_f64, 0.1), (0.05, 0.4), (1e-3, 0.2)] {
            for tail in [0.4, 1e-3, 1e-9, 1e-15, 1e-40] {
                let variance = (first - second).powi(2) + 2.0 * (1.0 + coefficient) * first * second;
                let preload = boundary.critical_product / 0.4 * (normal::upper_quantile(tail) * variance.sqrt()).exp();
                let pair = Pair::new(lognormal(preload, first), lognormal(0.4, second));
                let value = pair.stable_probability(&boundary, &PairLaw::correlated(coefficient), TOLERANCE);
                assert!((value / tail - 1.0).abs() < 1e-8, "{coefficient} {first} {second} {tail}: {value}");
            }
        }
    }
    // With the probability of instability it is one, for all kinds of inputs, also where the first is not positive.
    let boundary = self::boundary(&[]);
    let input = |marginal: &Marginal, expected: f64, std: f64| InputDistribution::relative(marginal, expected, std);
    for first in [
        input(&Marginal::Normal, 0.1, 0.5),
        input(&Marginal::Uniform, 0.09, 0.2),
        InputDistribution::fixed(0.1),
        input(&Marginal::Lognormal, 0.12, 0.1),
    ] {
        for second in [input(&Marginal::Normal, 0.4, 0.1), input(&Marginal::Uniform, 0.42, 0.1)] {
            let pair = Pair::new(first.clone(), second);
            for coefficient in [0.0, -0.6] {
                let law = PairLaw::correlated(coefficient);
                let both = [pair.probability(&boundary, &law, 1e-11), pair.stable_probability(&boundary, &law, 1e-11)];
                assert!((both[0] + both[1] - 1.0).abs() < 1e-9, "{first:?} {coefficient}: {both:?}");
            }
        }
    }
}
