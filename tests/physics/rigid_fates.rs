//! Verdicts on rigid-disc brakes of many kinds, against independent return maps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

#[path = "../data/fates.rs"]
mod fates;

use fates::{FATES, FATES_AT_BOUNDARIES, cases};
use stickslip_core::model::decision::Decision;
use stickslip_core::model::verdict::Verdict;

/// 500 brakes with friction curves that jump from row to row, linearly stable.
const JAGGED_FATES: &str = include_str!("../data/jagged-fates.csv");

/// Decides every case of a file with steps divided by `divisor`, asserts that no verdict is wrong, and returns the
/// number of undecided ones.
#[track_caller]
fn assert_fates(text: &str, divisor: f64) -> usize {
    let mut undecided = 0;
    let mut wrong = Vec::new();
    for case in cases(text) {
        let decision = case.decide(divisor);
        if decision.verdict == Verdict::Undecided {
            undecided += 1;
        } else if decision.verdict != case.fate {
            wrong.push(format!("line {}: {decision:?}", case.line));
        }
    }
    assert!(wrong.is_empty(), "steps / {divisor}: {wrong:#?}");
    undecided
}

#[test]
fn verdicts_are_those_of_an_independent_return_map() {
    assert!(assert_fates(FATES, 1.0) <= 1);
    assert!(assert_fates(FATES_AT_BOUNDARIES, 1.0) <= 5);
}

#[test]
fn verdicts_with_jagged_friction_curves_are_those_of_a_stiff_integration() {
    assert_eq!(assert_fates(JAGGED_FATES, 1.0), 0);
}

#[test]
fn shorter_steps_change_no_verdict() {
    for divisor in [2.0, 8.0] {
        assert!(assert_fates(FATES, divisor) <= 1);
    }
    assert!(assert_fates(FATES_AT_BOUNDARIES, 2.0) <= 5);
}

#[test]
fn lanes_and_scalar_code_agree_on_brakes_of_all_kinds() {
    for case in cases(FATES).iter().step_by(10).chain(cases(JAGGED_FATES).iter().step_by(60)) {
        let (criterion, inputs) = case.criterion(1.0);
        let bits = |decision: Decision| (decision.verdict, decision.time.to_bits(), decision.fed_by);
        let expected = bits(criterion.decide(inputs));
        // The same sample many times over fills the lanes.
        for decision in criterion.decide_all(&[inputs; 70]) {
            assert_eq!(bits(decision), expected, "line {}", case.line);
        }
    }
}
