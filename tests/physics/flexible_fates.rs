//! Verdicts, steady sliding and motions on flexible discs, against an independent integration.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::collections::HashMap;

use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::criterion::settings::{HORIZON, TimeDomainSettings};
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain};
use stickslip_core::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use stickslip_core::models::pad_on_disc::motion::moment::Moment;
use stickslip_core::models::pad_on_disc::motion::start::Start;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_core::models::pad_on_disc::trajectory::recording::Trajectory;

/// Motions from rest and from the limit cycle, of brakes near the preset and far from it.
const FATES: &str = include_str!("../data/flexible-fates.csv");

/// One motion of the file.
struct Case {
    line: usize,
    brake: PadOnDisc,
    modes: usize,
    start: Start,
    fate: Verdict,
    /// Of steady sliding: the largest real part of an eigenvalue, and x.
    growth_rate: f64,
    equilibrium: f64,
    /// Times of the first swings, with x and x'.
    samples: Vec<(f64, f64, f64)>,
    /// Whether the pad lifts off in places. The reference integrates over what presses line by line, and is less accurate.
    lifts_off: bool,
    /// Stick-slip that has settled.
    cycle: Option<Cycle>,
}

struct Cycle {
    largest: f64,
    smallest: f64,
    period: f64,
    stick_fraction: f64,
    /// When it was settled.
    time: f64,
}

impl Case {
    fn of_row(line: usize, row: &HashMap<&str, &str>) -> Self {
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let numbers = |name: &str| -> Vec<f64> { row[name].split_whitespace().map(|n| n.parse().unwrap()).collect() };
        let mut parameters = Parameters::sui_ding_2018();
        for name in row.keys() {
            let key = match *name {
                "preload" | "rotating_speed" => format!("operating_point.{name}"),
                "static_friction" => "friction.static_coefficient".to_owned(),
                key if key.contains('.') => key.to_owned(),
                _ => continue,
            };
            parameters.set(&key, number(name)).unwrap();
        }
        let (x, speeds) = (numbers("x"), numbers("speed"));
        let samples = numbers("times").into_iter().zip(x).zip(speeds).map(|((time, x), speed)| (time, x, speed));
        let cycle = match numbers("cycle")[..] {
            [largest, smallest, period, stick_fraction, time] => {
                Some(Cycle { largest, smallest, period, stick_fraction, time })
            }
            _ => None,
        };
        Self {
            line,
            brake: PadOnDisc::new(parameters).unwrap(),
            modes: row["modes"].parse().unwrap(),
            start: match row["start"] {
                "rest" => Start::Rest,
                "limit-cycle" => Start::LimitCycle,
                other => panic!("line {line}: start {other}"),
            },
            fate: match row["fate"] {
                "stable" => Verdict::Stable,
                "unstable" => Verdict::Unstable,
                other => panic!("line {line}: fate {other}"),
            },
            growth_rate: number("growth_rate"),
            equilibrium: number("equilibrium"),
            samples: samples.collect(),
            lifts_off: number("least_gap") < 0.0,
            cycle,
        }
    }

    fn inputs(&self) -> RandomInputs {
        let parameters = self.brake.parameters();
        RandomInputs {
            preload: parameters.operating_point.preload,
            static_friction: parameters.friction.static_coefficient,
        }
    }

    fn criterion(&self, horizon: f64) -> TimeDomain {
        let settings = TimeDomainSettings { start: self.start, horizon, ..Default::default() };
        TimeDomain::new(&self.brake, &DiscModel::Flexible { modes: self.modes }, settings).unwrap()
    }

    /// The motion with steps divided by `divisor`.
    fn trajectory(&self, horizon: f64, divisor: f64) -> Trajectory {
        self.criterion(horizon).with_steps_divided_by(divisor).trajectory(self.inputs(), horizon).unwrap()
    }

    /// The largest error at the times of the samples: of x over that of steady sliding, of x' over the disc's speed.
    fn error_of_motion(&self, divisor: f64) -> f64 {
        let horizon = 1.0 + self.samples.iter().map(|sample| sample.0).fold(0.0, f64::max);
        let trajectory = self.trajectory(horizon, divisor);
        let error = |&(time, x, speed): &(f64, f64, f64)| {
            let (at_time, speed_there) = at(&trajectory.moments, trajectory.interval, time);
            let of_speed = (speed_there - speed).abs() / self.brake.disc_speed();
            ((at_time - x).abs() / self.equilibrium).max(of_speed)
        };
        self.samples.iter().map(error).fold(0.0, f64::max)
    }
}

fn cases() -> Vec<Case> {
    let mut lines = FATES.lines().zip(1..).filter(|(line, _)| !line.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().0.split(',').collect();
    lines.map(|(row, line)| Case::of_row(line, &header.iter().copied().zip(row.split(',')).collect())).collect()
}

/// x and x' at a time between moments, by the cubic through x and x' at both.
fn at(moments: &[Moment], interval: f64, time: f64) -> (f64, f64) {
    let index = (time / interval) as usize;
    let ((x0, u0), (x1, u1)) = (moments[index].tangential, moments[index + 1].tangential);
    let (s, d0, d1) = (time / interval - index as f64, interval * u0, interval * u1);
    let (c2, c3) = (3.0 * (x1 - x0) - 2.0 * d0 - d1, d0 + d1 - 2.0 * (x1 - x0));
    (x0 + s * (d0 + s * (c2 + s * c3)), (d0 + s * (2.0 * c2 + s * 3.0 * c3)) / interval)
}

#[test]
fn verdicts_are_those_of_an_independent_integration() {
    let mut undecided = 0;
    let mut wrong = Vec::new();
    for case in cases() {
        let decision = case.criterion(HORIZON).decide(case.inputs());
        if decision.verdict == Verdict::Undecided {
            undecided += 1;
        } else if decision.verdict != case.fate {
            wrong.push(format!("line {}: {decision:?}", case.line));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert_eq!(undecided, 0);
}

#[test]
fn steady_sliding_and_its_growth_rate_are_those_of_modes_of_bessel_functions() {
    for case in cases().iter().filter(|case| case.start == Start::Rest) {
        let brake = FlexibleBrake::with_modes(case.brake.clone(), case.modes).unwrap();
        let x = brake.sliding_equilibrium(case.inputs()).unwrap()[0];
        let rate = brake.growth_rate(case.inputs()).unwrap();
        let (of_x, of_rate) = if case.lifts_off { (1e-5, 3e-4) } else { (2e-8, 1e-8) };
        assert!((x / case.equilibrium - 1.0).abs() < of_x, "line {}: {x}, not {}", case.line, case.equilibrium);
        assert!((rate - case.growth_rate).abs() < of_rate, "line {}: {rate}, not {}", case.line, case.growth_rate);
    }
}

#[test]
fn motions_are_those_of_an_independent_integration() {
    for case in cases() {
        // Moments are as far apart as steps, and with those in use the cubic between them adds most of the difference.
        let (in_use, fine) = (case.error_of_motion(1.0), case.error_of_motion(4.0));
        let largest = if case.lifts_off { 1e-3 } else { 1e-4 };
        assert!(in_use < 1e-2 && fine < largest, "line {}: {in_use}, with fine steps {fine}", case.line);
    }
}

#[test]
fn stick_slip_settles_to_the_cycle_of_an_independent_integration() {
    let cases = cases();
    // Every fourth of them: they take long.
    for (case, cycle) in cases.iter().filter_map(|case| Some((case, case.cycle.as_ref()?))).step_by(4) {
        // The last quarter of the trajectory is summarised.
        let settled = case.trajectory(cycle.time * 4.0 / 3.0 + 20.0 * cycle.period, 1.0).settled.unwrap();
        let swing = cycle.largest - cycle.smallest;
        let errors = [
            (settled.tangential_max - cycle.largest) / swing,
            (settled.tangential_min - cycle.smallest) / swing,
            settled.period.unwrap() / cycle.period - 1.0,
            settled.stick_fraction - cycle.stick_fraction,
        ];
        assert!(errors.iter().all(|error| error.abs() < 1e-4), "line {}: {errors:?}", case.line);
    }
}
