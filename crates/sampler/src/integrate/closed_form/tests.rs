//! Probabilities and derivatives against independent rules and differences.

use super::*;
use stickslip_core::friction::measured_curve::{MeasuredCurve, SharedCurve};
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

/// Expected preload and static friction, and their relative standard deviations.
const ORDINARY: [(f64, f64, f64, f64); 7] = [
    (0.1, 0.39, 0.2, 0.2),
    (0.3, 0.5, 0.2, 0.2),
    (0.01, 0.25, 0.2, 0.2),
    (0.05, 0.45, 0.3, 0.3),
    (0.2, 0.3, 0.1, 0.1),
    (0.1, 0.39, 0.5, 0.05),
    (0.1, 0.39, 0.02, 0.3),
];

fn boundary(speed: f64) -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", speed).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

fn cell(preload: f64, static_friction: f64, preload_std: f64, friction_std: f64) -> NormalPair {
    NormalPair { expected: [preload, static_friction], relative_std: [preload_std, friction_std] }
}

/// The same probability by an independent rule: the trapezoidal rule over the deviate of the friction.
fn by_trapezoid(boundary: &PairBoundary, cell: &NormalPair) -> f64 {
    let (points, limit) = (400_000, 9.0);
    let step = 2.0 * limit / f64::from(points);
    let mut sum = 0.0;
    for i in 0..=points {
        let z = -limit + step * f64::from(i);
        let friction = cell.expected[1] * (1.0 + cell.relative_std[1] * z);
        let critical = boundary.critical_first(friction);
        let deviate = (critical / cell.expected[0] - 1.0) / cell.relative_std[0];
        sum += (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt() * 0.5 * libm::erfc(deviate / 2f64.sqrt());
    }
    sum * step
}

#[test]
fn quadrature_agrees_with_an_independent_rule() {
    let boundary = boundary(15.0);
    let special = [
        // The conditional probability is a step between two abscissae unless the integral is divided there.
        (0.1, 0.39, 0.3, 1e-4),
        (0.1, 0.45, 0.3, 1e-3),
    ];
    for (preload, friction, preload_std, friction_std) in ORDINARY.into_iter().chain(special) {
        let cell = cell(preload, friction, preload_std, friction_std);
        let exact = probability(&boundary, &cell);
        let other = by_trapezoid(&boundary, &cell);
        assert!((exact.value - other).abs() < 1e-10, "{cell:?}: {exact:?} {other}");
        assert!(exact.error_bound < 1e-12, "{exact:?}");
    }
}

#[test]
fn one_random_input_is_a_single_tail() {
    let boundary = boundary(16.0);
    let f_crit = boundary.critical_second(0.1);
    let exact = probability(&boundary, &cell(0.1, 0.389, 0.0, 0.2)).value;
    assert!((exact - normal::upper_tail((f_crit / 0.389 - 1.0) / 0.2)).abs() < 1e-15);
    let preload_crit = boundary.critical_first(0.39);
    let exact = probability(&boundary, &cell(0.1, 0.39, 0.2, 0.0)).value;
    assert!((exact - normal::upper_tail((preload_crit / 0.1 - 1.0) / 0.2)).abs() < 1e-15);
}

#[test]
fn without_scatter_the_probability_is_zero_or_one() {
    let boundary = boundary(16.0);
    assert_eq!(probability(&boundary, &cell(0.1, 0.41, 0.0, 0.0)).value, 1.0);
    assert_eq!(probability(&boundary, &cell(0.1, 0.39, 0.0, 0.0)).value, 0.0);
    assert_eq!(probability(&boundary, &cell(0.0, 0.39, 0.2, 0.2)).value, 0.0);
    assert_eq!(probability(&boundary, &cell(0.1, 0.0, 0.2, 0.2)).value, 0.0);
    assert_eq!(probability(&boundary, &cell(0.1, 0.25, 0.2, 0.0)).value, 0.0);
}

#[test]
fn little_scatter_approaches_the_deterministic_verdict() {
    let boundary = boundary(16.0);
    for std in [1e-2, 1e-4, 1e-8, 1e-12] {
        let p = probability(&boundary, &cell(0.1, boundary.critical_second(0.1), std, std));
        assert!((p.value - 0.5).abs() < 0.05, "{std}: {p:?}");
        assert_eq!(probability(&boundary, &cell(0.1, 0.5, std.min(1e-3), std.min(1e-3))).value, 1.0);
    }
}

#[test]
fn undamped_brakes_are_unstable_wherever_friction_falls() {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("damping.tangential", 0.0).unwrap();
    let boundary = PadOnDisc::new(parameters).unwrap().stability_boundary();
    let p = probability(&boundary, &cell(0.1, 0.3, 0.5, 0.2)).value;
    let expected = normal::upper_tail(-2.0) * normal::upper_tail((0.25 / 0.3 - 1.0) / 0.2);
    assert!((p - expected).abs() < 1e-12, "{p} {expected}");
}

/// The boundary of a brake whose measured curve falls only because it is shifted by its standard deviations.
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
fn instability_below_a_static_friction_coefficient_is_integrated() {
    let boundary = shifted_boundary();
    let mut seen = [false; 2];
    for (preload, friction, preload_std, friction_std) in ORDINARY {
        let cell = cell(preload, friction, preload_std, friction_std);
        let (above, below) = boundary.unstable_second(preload);
        seen[usize::from(above < friction && friction < below)] = true;
        let exact = probability(&boundary, &cell);
        let other = by_trapezoid(&boundary, &cell);
        assert!((exact.value - other).abs() < 1e-5, "{cell:?}: {exact:?} {other}");
        for (which, derivative) in derivatives(&boundary, &cell).0.into_iter().enumerate() {
            let expected = by_differences(&boundary, &cell, which);
            let error = (derivative.unwrap() - expected).abs() / expected.abs().max(1.0);
            assert!(error < 1e-8, "{cell:?} {which}: {derivative:?} {expected}");
        }
        for (preload_std, friction_std) in [(0.0, 0.2), (0.2, 0.0)] {
            let cell = NormalPair { relative_std: [preload_std, friction_std], ..cell };
            for (which, derivative) in derivatives(&boundary, &cell).0.into_iter().enumerate() {
                let Some(derivative) = derivative else { continue };
                let expected = by_differences(&boundary, &cell, which);
                let error = (derivative - expected).abs() / expected.abs().max(1.0);
                assert!(error < 1e-8, "{cell:?} {which}: {derivative} {expected}");
            }
        }
    }
    assert_eq!(seen, [true; 2], "expected values on both sides of the boundary");
}

/// A cell with one of its four parameters shifted: preload, static friction and their relative standard deviations.
fn shifted(cell: &NormalPair, which: usize, by: f64) -> NormalPair {
    let mut other = *cell;
    *match which {
        0 => &mut other.expected[0],
        1 => &mut other.expected[1],
        2 => &mut other.relative_std[0],
        _ => &mut other.relative_std[1],
    } += by;
    other
}

/// A derivative from the probability alone: central differences, twice extrapolated.
fn by_differences(boundary: &PairBoundary, cell: &NormalPair, which: usize) -> f64 {
    let std = cell.relative_std;
    // The step: by the scatter of the input or, if it has none, by a twentieth of that of the other input.
    let [by_preload, by_friction] =
        [(std[0], std[1]), (std[1], std[0])].map(|(own, other)| if own > 0.0 { own } else { 0.05 * other });
    let step = 0.05 * [cell.expected[0] * by_preload, cell.expected[1] * by_friction, std[0], std[1]][which];
    let difference = |step: f64| {
        let p = |by: f64| probability(boundary, &shifted(cell, which, by)).value;
        (p(step) - p(-step)) / (2.0 * step)
    };
    let [a, b, c] = [step, 0.5 * step, 0.25 * step].map(difference);
    let (first, second) = ((4.0 * b - a) / 3.0, (4.0 * c - b) / 3.0);
    (16.0 * second - first) / 15.0
}

#[test]
fn derivatives_agree_with_differences_of_the_probability() {
    let boundary = boundary(15.0);
    let special = [(0.1, 0.38, 0.3, 1e-3), (0.1, 0.38, 1e-3, 0.3), (0.1, 0.38, 0.2, 0.0), (0.1, 0.38, 0.0, 0.2)];
    for (preload, friction, preload_std, friction_std) in ORDINARY.into_iter().chain(special) {
        let cell = cell(preload, friction, preload_std, friction_std);
        for (which, derivative) in derivatives(&boundary, &cell).0.into_iter().enumerate() {
            // Derivatives by expected values always exist, those by a standard deviation of 0 never.
            let exists = which < 2 || [preload_std, friction_std][which % 2] > 0.0;
            assert_eq!(derivative.is_some(), exists, "{cell:?} {which}");
            let Some(derivative) = derivative else { continue };
            let expected = by_differences(&boundary, &cell, which);
            let error = (derivative - expected).abs() / expected.abs().max(1.0);
            assert!(error < 1e-9, "{cell:?} {which}: {derivative} {expected}");
        }
    }
}

#[test]
fn derivatives_agree_with_sums_of_the_score() {
    let boundary = boundary(15.0);
    for (preload, friction, preload_std, friction_std) in
        [(0.1, 0.39, 0.2, 0.2), (0.05, 0.45, 0.3, 0.1), (0.2, 0.3, 0.1, 0.3)]
    {
        let cell = cell(preload, friction, preload_std, friction_std);
        let (points, limit) = (3000, 8.0);
        let step = 2.0 * limit / f64::from(points);
        let deviates: Vec<(f64, f64)> = (0..points)
            .map(|i| -limit + step * (f64::from(i) + 0.5))
            .map(|z| (z, step * (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt()))
            .collect();
        let mut sums = [0.0; 4];
        for (z1, weight1) in &deviates {
            for (z2, weight2) in &deviates {
                let (delta, f_s) = (preload * (1.0 + preload_std * z1), friction * (1.0 + friction_std * z2));
                if boundary.verdict(delta, f_s) == stickslip_core::model::verdict::Verdict::Unstable {
                    let weight = weight1 * weight2;
                    sums[0] += weight * (z1 * (1.0 + preload_std * z1) / (preload * preload_std) - 1.0 / preload);
                    sums[1] += weight * (z2 * (1.0 + friction_std * z2) / (friction * friction_std) - 1.0 / friction);
                    sums[2] += weight * (z1 * z1 - 1.0) / preload_std;
                    sums[3] += weight * (z2 * z2 - 1.0) / friction_std;
                }
            }
        }
        let scales = [preload * preload_std, friction * friction_std, preload_std, friction_std];
        for ((sum, derivative), scale) in sums.into_iter().zip(derivatives(&boundary, &cell).0).zip(scales) {
            // The rule misplaces the boundary by up to half a step.
            let error = (sum - derivative.unwrap()).abs() * scale;
            assert!(error < 1e-4, "{cell:?}: {sum} {derivative:?}");
        }
    }
}

#[test]
fn derivatives_are_zero_where_no_sample_is_ever_unstable() {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", 9e4).unwrap();
    let boundary = PadOnDisc::new(parameters).unwrap().stability_boundary();
    assert_eq!(boundary.critical_product, f64::INFINITY);
    assert_eq!(derivatives(&boundary, &cell(0.1, 0.39, 0.2, 0.2)).0, [Some(0.0); 4]);
    assert_eq!(derivatives(&boundary, &cell(0.1, 0.39, 0.0, 0.0)), Derivatives::default());
}
