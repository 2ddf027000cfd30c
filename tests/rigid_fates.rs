//! Verdicts on rigid brakes of all kinds against independent return maps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

#[path = "data/fates.rs"]
mod fates;

use fates::{FATES, FATES_AT_BOUNDARIES, cases};
use stickslip_core::criterion::decision::Decision;
use stickslip_core::verdict::Verdict;

/// Judges every case of a file with steps divided by `divisor`, and holds the verdicts against the fates: how many are
/// undecided.
#[track_caller]
fn assert_fates(text: &str, divisor: f64) -> usize {
    let mut undecided = 0;
    let mut wrong = Vec::new();
    for case in cases(text) {
        let judged = case.decide(divisor);
        if judged.verdict == Verdict::Undecided {
            undecided += 1;
        } else if judged.verdict != case.fate {
            wrong.push(format!("line {}: {judged:?}", case.line));
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
fn shorter_steps_change_no_verdict() {
    for divisor in [2.0, 8.0] {
        assert!(assert_fates(FATES, divisor) <= 1);
    }
    assert!(assert_fates(FATES_AT_BOUNDARIES, 2.0) <= 5);
}

#[test]
fn lanes_and_scalar_code_agree_on_brakes_of_all_kinds() {
    for case in cases(FATES).iter().step_by(4) {
        let (criterion, inputs) = case.criterion(1.0);
        let bits = |judged: Decision| (judged.verdict, judged.time.to_bits(), judged.fed_by);
        let expected = bits(criterion.decide(inputs));
        // The same sample many times over fills the lanes.
        for judged in criterion.decide_all(&[inputs; 70]) {
            assert_eq!(bits(judged), expected, "line {}", case.line);
        }
    }
}
