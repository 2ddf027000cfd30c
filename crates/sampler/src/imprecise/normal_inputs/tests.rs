//! Extremes over standard deviations against a brute-force double loop.

use super::*;
use std::convert::Infallible;
use stickslip_core::friction::measured_curve::{MeasuredCurve, SharedCurve};
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

fn boundary(speed: f64) -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", speed).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

fn cell(preload: f64, static_friction: f64) -> NormalPair {
    NormalPair { expected: [preload, static_friction], relative_std: [0.0; 2] }
}

/// Values per interval of the double loop.
const LOOP: usize = 101;

/// The least and the greatest probability of a double loop, whose number of evaluations it also gives.
fn double_loop(boundary: &PairBoundary, cell: &NormalPair, intervals: StdIntervals) -> ([f64; 2], u64) {
    let values = intervals.0.map(|[low, high]| {
        let steps = if low < high { LOOP } else { 1 };
        (0..steps).map(|i| low + (high - low) * i as f64 / (LOOP - 1) as f64).collect::<Vec<f64>>()
    });
    let (mut ends, mut evaluations) = ([f64::INFINITY, f64::NEG_INFINITY], 0);
    for &preload in &values[0] {
        for &static_friction in &values[1] {
            let cell = NormalPair { relative_std: [preload, static_friction], ..*cell };
            let p = closed_form::probability(boundary, &cell).value;
            ends = [ends[0].min(p), ends[1].max(p)];
            evaluations += 1;
        }
    }
    (ends, evaluations)
}

fn found(boundary: &PairBoundary, cell: &NormalPair, intervals: StdIntervals) -> Found {
    let Ok(found) = extremes(boundary, cell, intervals, [true; 2], || Ok::<_, Infallible>(()));
    found
}

/// Checks a cell against the double loop: to 1e-4, with at most a hundredth of the evaluations, and proved.
#[track_caller]
fn agrees(boundary: &PairBoundary, cell: &NormalPair, intervals: [[f64; 2]; 2]) -> Found {
    let intervals = StdIntervals(intervals);
    let (expected, evaluations) = double_loop(boundary, cell, intervals);
    let found = found(boundary, cell, intervals);
    let [least, most] = found.extremes.clone().map(Option::unwrap);
    for (extreme, expected, sign) in [(&least, expected[0], 1.0), (&most, expected[1], -1.0)] {
        let value = extreme.probability.value;
        assert!((value - expected).abs() < 1e-4, "{cell:?}: {extreme:?} {expected}");
        // The loop finds nothing beyond the proved bound, nor anything better than the tolerance.
        assert!(sign * (expected - extreme.bound.unwrap()) >= -1e-13, "{cell:?}: {extreme:?} {expected}");
        assert!(sign * (value - extreme.bound.unwrap()) <= tolerance(value), "{cell:?}: {extreme:?} {expected}");
        let there = NormalPair { relative_std: [extreme.at[0], extreme.at[1]], ..*cell };
        assert_eq!(closed_form::probability(boundary, &there), extreme.probability);
        for (value, [low, high]) in extreme.at.iter().zip(intervals.0) {
            assert!((low..=high).contains(value));
        }
    }
    assert!(100 * found.evaluations <= evaluations, "{} of {evaluations}", found.evaluations);
    found
}

#[test]
fn extremes_are_those_of_a_double_loop() {
    let boundary = boundary(15.0);
    let usual = [[0.05, 0.15], [0.04, 0.12]];
    for (preload, friction, intervals) in [
        (0.1, 0.39, usual),
        (0.3, 0.5, [[0.1, 0.3], [0.1, 0.3]]),
        (0.05, 0.45, [[0.02, 0.3], [0.05, 0.1]]),
        (0.01, 0.25, usual),
    ] {
        agrees(&boundary, &cell(preload, friction), intervals);
    }
}

#[test]
fn an_extreme_between_the_ends_is_found_and_proved() {
    let found = agrees(&boundary(15.0), &cell(0.1, 0.37), [[0.1, 0.3], [0.1, 0.3]]);
    let [least, _] = found.extremes.map(Option::unwrap);
    assert!(least.at[0] > 0.11 && least.at[0] < 0.29, "inside: {least:?}");
    assert_eq!(found.trends[0].direction, Direction::Turns);
    assert_eq!(found.trends[1], Trend { direction: Direction::Rises, is_proved: true });
}

#[test]
fn one_random_input_has_a_single_tail_that_changes_in_one_direction() {
    let boundary = boundary(15.0);
    let critical = boundary.critical_first(0.39);
    for (preload, direction) in [(0.8 * critical, Direction::Rises), (1.2 * critical, Direction::Falls)] {
        let intervals = StdIntervals([[0.1, 0.4], [0.0, 0.0]]);
        let found = found(&boundary, &cell(preload, 0.39), intervals);
        assert_eq!(found.trends[0], Trend { direction, is_proved: true });
        let [least, most] = found.extremes.map(Option::unwrap);
        let ends = if direction == Direction::Rises { [0.1, 0.4] } else { [0.4, 0.1] };
        assert_eq!([least.at[0], most.at[0]], ends);
        let upper = crate::special_functions::normal::upper_tail((critical / preload - 1.0) / ends[1]);
        assert!((most.probability.value - upper).abs() < 1e-14);
    }
}

#[test]
fn a_band_of_unstable_friction_coefficients_agrees_with_a_double_loop() {
    // A measured curve that falls only as it is shifted: unstable below a static friction coefficient.
    let curve = MeasuredCurve::new(&[0.0, 1.0, 4.0], &[0.3, 0.32, 0.33], Some(&[0.08, 0.02, 0.01])).unwrap();
    let mut parameters = Parameters::sui_ding_2018();
    parameters.friction.use_table(SharedCurve::new(curve));
    parameters.friction.band = 2.0;
    parameters.damping.tangential = 500.0;
    parameters.operating_point.rotating_speed = 1.0;
    let boundary = PadOnDisc::new(parameters).unwrap().stability_boundary();
    assert!(!boundary.is_unstable_above());
    agrees(&boundary, &cell(0.1, 0.39), [[0.1, 0.3], [0.1, 0.3]]);
}

/// The search of a cell over one wide box, whose remainder is far above the tolerance.
fn one_wide_box<'a>(boundary: &'a PairBoundary, pair: &'a NormalPair) -> (Search<'a>, Part) {
    let intervals = StdIntervals([[0.05, 0.35], [0.04, 0.28]]);
    let mut search = Search { boundary, inputs: pair, intervals, wanted: [true; 2], evaluations: 0 };
    let ends = intervals.0.map(|ends| ends.map(libm::log));
    let part = search.part(ends);
    (search, part)
}

#[test]
fn the_remainder_of_a_box_covers_what_its_polynomial_misses() {
    let boundary = boundary(15.0);
    let mut largest = 0.0_f64;
    for (preload, friction) in [(0.1, 0.39), (0.1, 0.37), (0.05, 0.36), (0.2, 0.3)] {
        let cell = cell(preload, friction);
        let (search, part) = one_wide_box(&boundary, &cell);
        for i in 0..=8 {
            for j in 0..=8 {
                let [x, y] = [i, j].map(|k| f64::from(k) / 4.0 - 1.0);
                let polynomial = part.scaled.iter().rev().fold(0.0, |sum, row| {
                    sum * x + row.iter().rev().fold(0.0, |sum, coefficient| sum * y + coefficient)
                });
                let at = |along: usize, x: f64| {
                    let [from, to] = part.ends[along];
                    0.5 * (from + to) + 0.5 * x * (to - from)
                };
                let exact = closed_form::probability(&boundary, &search.inputs_at([at(0, x), at(1, y)])).value;
                let missed = (polynomial - exact).abs();
                assert!(missed <= part.remainder, "{cell:?}: {missed:e} {:e}", part.remainder);
                largest = largest.max(missed);
            }
        }
    }
    assert!(largest > 1e-4, "without its remainder the polynomial is wrong: {largest:e}");
}

#[test]
fn nothing_is_proved_while_a_remainder_leaves_room() {
    // The extremes of the polynomial are known to the tolerance, but not those of the probability.
    let (boundary, cell) = (boundary(15.0), cell(0.1, 0.39));
    let (mut search, part) = one_wide_box(&boundary, &cell);
    assert!(part.remainder > 100.0 * tolerance(1.0));
    let parts = [part];
    for which in [0, 1] {
        assert!(open_part(&parts, which).is_some(), "the box is to be halved");
        assert_eq!(search.extreme(&parts, which).bound, None);
    }
    // A derivative that is positive for the polynomial alone.
    let mut parts = parts;
    parts[0].scaled = [[0.0; TERMS]; TERMS];
    (parts[0].scaled[0][0], parts[0].scaled[1][0]) = (0.5, 0.1 * parts[0].remainder);
    let trend = search.trend(&parts, 0);
    assert!(!trend.is_proved, "{trend:?}");
}
