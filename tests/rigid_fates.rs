//! Verdicts on rigid brakes of all kinds against independent return maps.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use stickslip_core::{
    DiscModel, JudgedMotion, PadOnDisc, Parameters, RandomInputs, Start, TimeDomain, TimeDomainSettings, Verdict,
};

/// One brake of a file of fates.
struct Case {
    line: usize,
    parameters: Parameters,
    start: Start,
    displacement: f64,
    fate: Verdict,
}

impl Case {
    fn criterion(&self, divisor: f64) -> (TimeDomain, RandomInputs) {
        let settings = TimeDomainSettings {
            start: self.start,
            displacement: self.displacement,
            horizon: 1e5,
            ..Default::default()
        };
        let brake = PadOnDisc::new(self.parameters.clone()).unwrap();
        let criterion = TimeDomain::new(&brake, &DiscModel::Rigid, settings).unwrap().with_steps_divided_by(divisor);
        let inputs = RandomInputs {
            preload: self.parameters.operating_point.preload,
            static_friction: self.parameters.friction.static_coefficient,
        };
        (criterion, inputs)
    }

    fn judge(&self, divisor: f64) -> JudgedMotion {
        let (criterion, inputs) = self.criterion(divisor);
        criterion.judge(inputs)
    }
}

/// The cases of a file: columns named by their parameters, lines that begin with `#` are comments.
fn cases(text: &str) -> Vec<Case> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().1.split(',').collect();
    let case = |(line, row): (usize, &str)| {
        let mut case = Case {
            line: line + 1,
            parameters: Parameters::sui_ding_2018(),
            start: Start::Rest,
            displacement: f64::NAN,
            fate: Verdict::Failed,
        };
        for (name, value) in header.iter().zip(row.split(',')) {
            let number = || value.parse::<f64>().unwrap();
            match *name {
                "preload" | "rotating_speed" => {
                    case.parameters.set(&format!("operating_point.{name}"), number()).unwrap();
                }
                "static_friction" => case.parameters.set("friction.static_coefficient", number()).unwrap(),
                "displacement" => case.displacement = number(),
                "start" => {
                    case.start = match value {
                        "rest" => Start::Rest,
                        "near-equilibrium" => Start::NearEquilibrium,
                        "limit-cycle" => Start::LimitCycle,
                        other => panic!("line {}: start {other}", line + 1),
                    }
                }
                "fate" => {
                    case.fate = match value {
                        "stable" => Verdict::Stable,
                        "unstable" => Verdict::Unstable,
                        other => panic!("line {}: fate {other}", line + 1),
                    }
                }
                "kind" | "damping_ratio" | "margin" => {}
                key => case.parameters.set(key, number()).unwrap(),
            }
        }
        case
    };
    lines.map(case).collect()
}

/// Judges every case of a file with steps divided by `divisor`, and holds the verdicts against the fates: how many are
/// undecided.
#[track_caller]
fn assert_fates(text: &str, divisor: f64) -> usize {
    let mut undecided = 0;
    let mut wrong = Vec::new();
    for case in cases(text) {
        let judged = case.judge(divisor);
        if judged.verdict == Verdict::Undecided {
            undecided += 1;
        } else if judged.verdict != case.fate {
            wrong.push(format!("line {}: {judged:?}", case.line));
        }
    }
    assert!(wrong.is_empty(), "steps / {divisor}: {wrong:#?}");
    undecided
}

/// 400 brakes of all kinds.
const FATES: &str = include_str!("data/rigid-fates.csv");

/// 2000 brakes around the boundaries of the verdicts, at distances from 1e-7 of them on; smooth cycles, very slow and very
/// fast discs among them.
const FATES_AT_BOUNDARIES: &str = include_str!("data/rigid-fates-more.csv");

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
        let bits = |judged: JudgedMotion| (judged.verdict, judged.time.to_bits(), judged.fed_by);
        let expected = bits(criterion.judge(inputs));
        // The same sample many times over fills the lanes.
        for judged in criterion.judge_all(&[inputs; 70]) {
            assert_eq!(bits(judged), expected, "line {}", case.line);
        }
    }
}
