//! Limits of probabilities against closed forms and independent root finding.

use std::convert::Infallible;
use std::f64::consts::PI;

use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

use super::*;
use crate::integrate::NormalPair;
use crate::integrate::closed_form;
use crate::integrate::closed_form::ExactProbability;
use crate::special_functions::normal;

fn brake(changes: &[(&str, f64)]) -> PadOnDisc {
    let mut parameters = Parameters::sui_ding_2018();
    changes.iter().for_each(|(key, value)| parameters.set(key, *value).unwrap());
    PadOnDisc::new(parameters).unwrap()
}

fn boundary(speed: f64) -> PairBoundary {
    brake(&[("operating_point.rotating_speed", speed)]).stability_boundary()
}

fn cell(preload: f64, static_friction: f64, stds: [f64; 2]) -> NormalPair {
    NormalPair { expected: [preload, static_friction], relative_std: stds }
}

fn found(axis: &[f64], target: f64, probability: impl Fn(f64) -> ExactProbability) -> Vec<Limit> {
    let estimate = |value| Ok::<_, Infallible>(estimate_of(&probability(value)));
    let scan = Scan::new(&scanned_values(axis, 256), 1e-12, estimate).unwrap();
    scan.limits(target, estimate).unwrap()
}

fn estimate_of(found: &ExactProbability) -> Estimate {
    let [low, high] = found.bounds();
    Estimate { probability: Some(found.value), low, high }
}

fn values(limits: &[Limit]) -> Vec<f64> {
    limits.iter().filter_map(|limit| limit.value).collect()
}

fn without_error(value: f64) -> ExactProbability {
    ExactProbability { value, error_bound: 0.0 }
}

/// A root by the Illinois method, to the last digits.
fn root(mut from: f64, mut to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut at_from, mut at_to) = (f(from), f(to));
    assert!(at_from * at_to < 0.0, "{from} {at_from}, {to} {at_to}");
    for _ in 0..200 {
        let middle = (from * at_to - to * at_from) / (at_to - at_from);
        let at_middle = f(middle);
        if at_middle == 0.0 || (to - from).abs() < 1e-14 * to.abs() {
            return middle;
        }
        if at_middle * at_to < 0.0 {
            (from, at_from) = (to, at_to);
        } else {
            at_from *= 0.5;
        }
        (to, at_to) = (middle, at_middle);
    }
    to
}

#[test]
fn limits_are_roots_of_the_exact_probability() {
    let boundary = boundary(15.0);
    for (static_friction, stds) in [(0.39, [0.2, 0.2]), (0.5, [0.1, 0.05]), (0.35, [0.3, 0.1])] {
        for target in [1e-3, 0.01, 0.2, 0.5, 0.6] {
            let probability = |preload| closed_form::probability(&boundary, &cell(preload, static_friction, stds));
            let limits = found(&[0.001, 0.3], target, probability);
            let [Limit { state: State::Rises, value: Some(limit), bounds: Some([low, high]) }] = limits[..] else {
                panic!("{limits:?}")
            };
            let independent = root(0.001, 0.3, |preload| probability(preload).value / target - 1.0);
            assert!((limit / independent - 1.0).abs() < 1e-6, "{limit} {independent}");
            assert!(probability(limit).value <= target, "the limit is on the side within the target");
            assert!(low <= limit && limit <= high && high - low < 1e-9 * limit, "{low} {limit} {high}");
            assert!(low * (1.0 - 1e-10) <= independent && independent <= high * (1.0 + 1e-10));
        }
    }
}

#[test]
fn with_one_random_input_the_limit_is_a_closed_form() {
    let boundary = boundary(15.0);
    for target in [1e-9, 1e-3, 0.1, 0.5, 0.9] {
        let z = -normal::quantile(target);
        // Unstable is Delta (1 + sigma z) > Delta_crit.
        let preloads = [0.01, 0.02, 0.3];
        let limits =
            found(&preloads, target, |preload| closed_form::probability(&boundary, &cell(preload, 0.39, [0.2, 0.0])));
        let expected = boundary.critical_first(0.39) / (1.0 + 0.2 * z);
        assert_eq!(limits.len(), 1);
        let limit = limits[0].value.unwrap();
        assert!((limit / expected - 1.0).abs() < 3e-12 + 1e-14 / target, "{target}: {limit} {expected}");
        let [low, high] = limits[0].bounds.unwrap();
        assert!((low..=high).contains(&limit));
        let limits = found(&[0.2, 0.6], target, |friction| {
            closed_form::probability(&boundary, &cell(0.1, friction, [0.0, 0.1]))
        });
        let expected = boundary.critical_second(0.1) / (1.0 + 0.1 * z);
        let limit = limits[0].value.unwrap();
        assert!((limit / expected - 1.0).abs() < 3e-12 + 1e-14 / target, "{target}: {limit} {expected}");
    }
    // Where nothing scatters, the probability jumps from 0 to 1 at the boundary.
    let limits =
        found(&[0.3, 0.01], 0.01, |preload| closed_form::probability(&boundary, &cell(preload, 0.39, [0.0; 2])));
    let critical = boundary.critical_first(0.39);
    assert!((values(&limits)[0] / critical - 1.0).abs() < 2e-12, "{limits:?} {critical}");
}

#[test]
fn a_speed_axis_may_enter_and_leave_instability() {
    // With an exponent of 2 the friction curve is flat at rest: slow and fast sliding is stable.
    let probability = |speed: f64| {
        let changes = [("operating_point.rotating_speed", speed), ("friction.stribeck_exponent", 2.0)];
        closed_form::probability(&brake(&changes).stability_boundary(), &cell(0.1, 0.45, [0.1, 0.05]))
    };
    let axis = [0.05, 1.0, 5.0, 25.0];
    let limits = found(&axis, 0.01, probability);
    let states: Vec<State> = limits.iter().map(|limit| limit.state).collect();
    assert_eq!(states, [State::Rises, State::Falls], "{limits:?}");
    for (limit, between) in values(&limits).into_iter().zip([[0.05, 5.0], [5.0, 25.0]]) {
        let independent = root(between[0], between[1], |speed| probability(speed).value / 0.01 - 1.0);
        assert!((limit / independent - 1.0).abs() < 1e-6, "{limit} {independent}");
    }
    // The critical speeds, where nothing scatters.
    let still = |speed: f64| {
        let changes = [("operating_point.rotating_speed", speed), ("friction.stribeck_exponent", 2.0)];
        closed_form::probability(&brake(&changes).stability_boundary(), &cell(0.1, 0.45, [0.0; 2]))
    };
    let changes = [("friction.stribeck_exponent", 2.0), ("friction.static_coefficient", 0.45)];
    let range = brake(&changes).unstable_speeds()[0];
    let limits = values(&found(&axis, 0.5, still));
    assert_eq!(limits.len(), 2);
    assert!((limits[0] / range.from - 1.0).abs() < 1e-10 && (limits[1] / range.to - 1.0).abs() < 1e-10, "{limits:?}");
}

#[test]
fn without_a_crossing_the_side_is_returned() {
    let boundary = boundary(15.0);
    let probability = |preload| closed_form::probability(&boundary, &cell(preload, 0.39, [0.2, 0.2]));
    for (axis, target, state) in
        [([0.001, 0.01], 0.01, State::Within), ([0.25, 0.3], 0.01, State::Above), ([0.0, 0.3], 0.999, State::Within)]
    {
        let limits = found(&axis, target, probability);
        assert_eq!(limits, [Limit { state, value: None, bounds: None }], "{axis:?} {target}");
    }
    // Nothing presses without preload; a probability that equals the target is within it.
    assert_eq!(probability(0.0).value, 0.0);
    let flat = found(&[1.0, 2.0], 0.25, |_| without_error(0.25));
    assert_eq!(flat[0].state, State::Within);
}

#[test]
fn narrow_peaks_and_dips_between_the_values_of_a_scan_are_found() {
    // A peak a tenth of a step wide at its top, beside values of the scan that are below the target.
    let step = 1.0 / 256.0;
    for centre in [0.5 * step, 100.3 * step, 200.5 * step, 255.7 * step] {
        let peak = |x: f64| without_error(0.5 / (1.0 + ((x - centre) / step).powi(2)));
        let limits = found(&[0.0, 1.0], 0.499, peak);
        let half = step * (0.5f64 / 0.499 - 1.0).sqrt();
        assert_eq!(limits.len(), 2, "{centre}: {limits:?}");
        assert_eq!((limits[0].state, limits[1].state), (State::Rises, State::Falls));
        for (limit, expected) in values(&limits).into_iter().zip([centre - half, centre + half]) {
            assert!((limit - expected).abs() < 1e-10, "{centre}: {limit} {expected}");
        }
        let dip = |x: f64| without_error(1.0 - peak(x).value);
        let limits = found(&[0.0, 1.0], 0.501, dip);
        assert_eq!(limits.len(), 2, "{centre}: {limits:?}");
        assert_eq!((limits[0].state, limits[1].state), (State::Falls, State::Rises));
    }
}

#[test]
fn every_crossing_of_a_wave_is_listed_and_limits_at_zero_are_found() {
    let wave = |x: f64| without_error(0.5 + 0.4 * (2.0 * PI * x).sin());
    let limits = found(&[-1.25, 0.3, 1.25], 0.5, wave);
    let expected = [-1.0, -0.5, 0.0, 0.5, 1.0];
    assert_eq!(limits.len(), expected.len(), "{limits:?}");
    for (i, (limit, expected)) in limits.iter().zip(expected).enumerate() {
        assert!((limit.value.unwrap() - expected).abs() < 1e-12, "{limit:?}");
        assert_eq!(limit.state, if i % 2 == 0 { State::Rises } else { State::Falls });
    }
}

#[test]
fn bounds_contain_what_the_error_leaves_open() {
    let line = |x: f64| ExactProbability { value: x, error_bound: 1e-4 };
    let limit = found(&[0.0, 1.0], 0.3, line)[0];
    let [low, high] = limit.bounds.unwrap();
    assert!((low - 0.2999).abs() < 1e-12 && (high - 0.3001).abs() < 1e-12, "{limit:?}");
    let falling = |x: f64| ExactProbability { value: 1.0 - x, error_bound: 1e-4 };
    let limit = found(&[0.0, 1.0], 0.3, falling)[0];
    assert_eq!(limit.state, State::Falls);
    let [low, high] = limit.bounds.unwrap();
    assert!((low - 0.6999).abs() < 1e-12 && (high - 0.7001).abs() < 1e-12, "{limit:?}");
    // Over many values of the scan, up to the ends of the range.
    let rough = |x: f64| ExactProbability { value: x, error_bound: 0.1 };
    let [low, high] = found(&[0.0, 1.0], 0.3, rough)[0].bounds.unwrap();
    assert!((low - 0.2).abs() < 1e-12 && (high - 0.4).abs() < 1e-12, "{low} {high}");
    let [low, high] = found(&[0.25, 0.5], 0.3, rough)[0].bounds.unwrap();
    assert!(low == 0.25 && (high - 0.4).abs() < 1e-12, "{low} {high}");
    // Without a limit they show where there may be one.
    let limit = found(&[0.0, 0.25], 0.3, rough)[0];
    assert_eq!((limit.state, limit.value), (State::Within, None));
    let [low, high] = limit.bounds.unwrap();
    assert!((low - 0.2).abs() < 1e-12 && high == 0.25, "{low} {high}");
}

#[test]
fn a_search_takes_few_estimates() {
    let boundary = boundary(15.0);
    let count = std::cell::Cell::new(0);
    let estimate = |preload| {
        count.set(count.get() + 1);
        let found = closed_form::probability(&boundary, &cell(preload, 0.39, [0.2, 0.2]));
        Ok::<_, Infallible>(Estimate {
            probability: Some(found.value),
            low: 0.9 * found.value,
            high: 1.1 * found.value,
        })
    };
    let scan = Scan::new(&scanned_values(&[0.001, 0.3], 32), 1e-9, estimate).unwrap();
    assert_eq!(count.replace(0), 33);
    for target in [1e-6, 0.01, 0.5] {
        assert_eq!(scan.limits(target, estimate).unwrap().len(), 1);
        assert!(count.replace(0) <= 45, "{target}: {}", count.get());
    }
}

#[test]
fn scans_have_the_values_of_the_axis_and_enough_between() {
    for axis in [vec![0.3, 0.01], vec![1.0, 7.0, 3.0], (0..400).map(f64::from).collect()] {
        let scanned = scanned_values(&axis, 256);
        assert!(axis.iter().all(|value| scanned.contains(value)));
        assert!(scanned.len() >= 257 && scanned.len() >= 2 * axis.len() - 1);
        assert!(scanned.windows(2).all(|pair| pair[0] < pair[1]));
    }
}

#[test]
fn bounds_reach_to_where_the_interval_surely_excludes_the_target() {
    let estimate = |x: f64| Ok::<_, Infallible>(Estimate { probability: Some(x), low: x - 0.1, high: x + 0.1 });
    for tolerance in [1e-2, 1e-4] {
        let Ok(scan) = Scan::new(&[0.15, 0.35, 0.55, 0.75, 0.95], tolerance, estimate);
        let Ok(limits) = scan.limits(0.5, estimate);
        let [low, high] = limits[0].bounds.unwrap();
        assert!(low <= 0.4 && low > 0.4 - 1.1 * tolerance, "{low}");
        assert!(high > 0.6 && high < 0.6 + 1.1 * tolerance, "{high}");
    }
}
