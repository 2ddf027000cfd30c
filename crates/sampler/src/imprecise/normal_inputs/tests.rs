//! Extremes over standard deviations against a brute-force double loop.

use super::*;
use std::convert::Infallible;
use stickslip_core::friction::measured_curve::{MeasuredCurve, SharedCurve};
use stickslip_core::parameters::Parameters;
use stickslip_core::rigid_disc::pad_on_disc::PadOnDisc;

fn boundary(speed: f64) -> StabilityBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", speed).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

fn cell(preload: f64, static_friction: f64) -> Cell {
    let relative_std = RelativeStd { preload: 0.0, static_friction: 0.0 };
    Cell { index: 0, rotating_speed: 15.0, relative_std, preload, static_friction }
}

/// Values per interval of the double loop.
const LOOP: usize = 101;

/// The least and the greatest probability of a double loop, whose number of evaluations it also gives.
fn double_loop(boundary: &StabilityBoundary, cell: &Cell, intervals: StdIntervals) -> ([f64; 2], u64) {
    let values = intervals.0.map(|[low, high]| {
        let steps = if low < high { LOOP } else { 1 };
        (0..steps).map(|i| low + (high - low) * i as f64 / (LOOP - 1) as f64).collect::<Vec<f64>>()
    });
    let (mut ends, mut evaluations) = ([f64::INFINITY, f64::NEG_INFINITY], 0);
    for &preload in &values[0] {
        for &static_friction in &values[1] {
            let cell = Cell { relative_std: RelativeStd { preload, static_friction }, ..*cell };
            let p = closed_form::probability(boundary, &cell).value;
            ends = [ends[0].min(p), ends[1].max(p)];
            evaluations += 1;
        }
    }
    (ends, evaluations)
}

fn found(boundary: &StabilityBoundary, cell: &Cell, intervals: StdIntervals) -> Found {
    let Ok(found) = extremes(boundary, cell, intervals, [true; 2], || Ok::<_, Infallible>(()));
    found
}

/// Checks a cell against the double loop: to 1e-4, with at most a hundredth of the evaluations, and proved.
#[track_caller]
fn agrees(boundary: &StabilityBoundary, cell: &Cell, intervals: [[f64; 2]; 2]) -> Found {
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
        let [preload, static_friction] = [extreme.at[0], extreme.at[1]];
        let there = Cell { relative_std: RelativeStd { preload, static_friction }, ..*cell };
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
    let critical = boundary.critical_preload(0.39);
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
