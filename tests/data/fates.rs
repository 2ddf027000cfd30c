//! Reads the fates of rigid brakes beside this file: for the tests and for the table of validity.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a file that cannot be read should say so and stop")]

use stickslip_core::friction::measured_curve::{MeasuredCurve, SharedCurve};
use stickslip_core::model::decision::Decision;
use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain};
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// 400 brakes of all kinds.
pub const FATES: &str = include_str!("rigid-fates.csv");

/// 2000 brakes around the boundaries of the verdicts, at distances from 1e-7 of them on; smooth cycles, very slow and
/// very fast discs among them.
pub const FATES_AT_BOUNDARIES: &str = include_str!("rigid-fates-more.csv");

/// One brake of a file of fates.
pub struct Case {
    pub line: usize,
    pub parameters: Parameters,
    pub start: Start,
    pub displacement: f64,
    pub fate: Verdict,
}

impl Case {
    /// The criterion with steps divided by `divisor`, and the inputs of the sample.
    pub fn criterion(&self, divisor: f64) -> (TimeDomain, RandomInputs) {
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

    /// The verdict with steps divided by `divisor`.
    pub fn decide(&self, divisor: f64) -> Decision {
        let (criterion, inputs) = self.criterion(divisor);
        criterion.decide(inputs)
    }
}

/// The cases of a file: columns named by their parameters, lines that begin with `#` are comments.
pub fn cases(text: &str) -> Vec<Case> {
    let mut lines = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().1.split(',').collect();
    let case = |(line, row): (usize, &str)| {
        let mut case = Case {
            line: line + 1,
            parameters: Parameters::sui_ding_2018(),
            start: Start::Rest,
            displacement: 0.01,
            fate: Verdict::Failed,
        };
        let mut speeds: Vec<f64> = Vec::new();
        for (name, value) in header.iter().zip(row.split(',')) {
            let number = || value.parse::<f64>().unwrap();
            let numbers = || value.split(' ').map(|number| number.parse::<f64>().unwrap()).collect::<Vec<_>>();
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
                "speeds" => speeds = numbers(),
                "coefficients" => {
                    let curve = MeasuredCurve::new(&speeds, &numbers(), None).unwrap();
                    case.parameters.friction.use_table(SharedCurve::new(curve));
                }
                "kind" | "damping_ratio" | "margin" => {}
                key => case.parameters.set(key, number()).unwrap(),
            }
        }
        case
    };
    lines.map(case).collect()
}
