use super::*;
use crate::friction::law::LawKind;
use crate::friction::measured_curve::{MeasuredCurve, SharedCurve};
use crate::models::pad_on_disc::motion::advance::advance;
use crate::models::pad_on_disc::motion::event_log::EventLog;
use crate::models::pad_on_disc::motion::integrator::Motion;
use crate::models::pad_on_disc::parameters::Parameters;

fn inputs(brake: &PadOnDisc) -> RandomInputs {
    let parameters = brake.parameters();
    RandomInputs {
        preload: parameters.operating_point.preload,
        static_friction: parameters.friction.static_coefficient,
    }
}

fn simulate_from_release(brake: &RigidBrake, inputs: RandomInputs, time: f64, h: f64) -> EventLog {
    let sample = brake.sample(inputs);
    let mut motion =
        Motion { state: RigidState { x: sample.release(), u: brake.disc_speed }, contact: ContactState::Stick };
    let mut log = EventLog::default();
    for k in 0..(time / h) as u32 {
        advance(&sample, &mut motion, h * f64::from(k), h, &mut log).unwrap();
    }
    log
}

#[test]
fn the_limit_cycle_is_that_of_the_table() {
    // Physics notes, section 7: adaptive Runge-Kutta, tolerance 1e-11, outside Rust.
    let table = [
        (10.0, 3.56373, 0.014309, 0.003465, 0.3756),
        (15.56, 3.21741, 0.015334, 0.002579, 0.2556),
        (20.0, 3.10909, 0.016207, 0.001879, 0.1873),
    ];
    for (speed, period, largest, smallest, stick) in table {
        let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
        let rigid = RigidBrake::new(&brake);
        let log = simulate_from_release(&rigid, inputs(&brake), 40.0, rigid.step);
        let cycles = log.slips.len() - 1;
        let found = (log.slips[cycles] - log.slips[1]) / (cycles - 1) as f64;
        assert!((found - period).abs() < 1e-4, "{speed}: period {found}");
        let last: Vec<f64> = log.turns.iter().rev().take(2).map(|turn| turn.1).collect();
        assert!((last[0].max(last[1]) - largest).abs() < 1e-6, "{speed}: {last:?}");
        assert!((last[0].min(last[1]) - smallest).abs() < 1e-6, "{speed}: {last:?}");
        let found = (log.slips[3] - log.sticks[2]) / period;
        assert!((found - stick).abs() < 1e-4, "{speed}: stick {found}");
    }
}

#[test]
fn fixed_and_adaptive_steps_find_the_same_limit_cycle() {
    for (speed, preload) in [(6.0, 0.1), (12.0, 0.2), (25.0, 0.1)] {
        let changes = [("operating_point.rotating_speed", speed), ("operating_point.preload", preload)];
        let brake = PadOnDisc::preset_with(&changes);
        let cycle = brake.limit_cycle().unwrap();
        let rigid = RigidBrake::new(&brake);
        for divisor in [1.0, 4.0] {
            let log = simulate_from_release(&rigid, inputs(&brake), 20.0, rigid.step / divisor);
            let tolerance = 2e-4 / (divisor * divisor);
            let period = log.slips[3] - log.slips[2];
            assert!((period / cycle.period - 1.0).abs() < tolerance, "{speed} {divisor}: {period} {cycle:?}");
            let largest = log.turns.iter().map(|turn| turn.1).fold(f64::NEG_INFINITY, f64::max);
            assert!((largest / cycle.tangential_max - 1.0).abs() < tolerance, "{speed} {divisor}: {largest} {cycle:?}");
        }
    }
}

/// Whether the slip phase that begins at release ends in stick.
fn is_recaptured(speed: f64, divisor: f64) -> bool {
    let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
    let rigid = RigidBrake::new(&brake);
    !simulate_from_release(&rigid, inputs(&brake), 5.0, rigid.step / divisor).sticks.is_empty()
}

#[test]
fn the_saddle_node_is_found_at_any_step_size() {
    // Physics notes: 30.197, independently.
    for divisor in [0.25, 0.5, 1.0, 3.0] {
        let (mut with, mut without) = (20.0, 40.0);
        for _ in 0..40 {
            let middle = 0.5 * (with + without);
            if is_recaptured(middle, divisor) { with = middle } else { without = middle }
        }
        let tolerance = if divisor < 1.0 { 0.15 } else { 0.01 };
        assert!((with - 30.197).abs() < tolerance, "step / {divisor}: {with}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn steps_resolve_the_friction_law_however_steep_it_is() {
    // Where stick-slip ends, by these steps and by the adaptive method; the disc passes the pad at ten to a thousand
    // Stribeck velocities, and at two in the first case.
    for (exponent, stribeck_velocity) in [
        (1.0, 3.0),
        (1.0, 0.1),
        (1.0, 0.02),
        (1.0, 0.004),
        (0.5, 0.3),
        (0.5, 0.02),
        (0.7, 0.05),
        (1.3, 0.1),
        (1.5, 0.05),
        (2.0, 0.3),
        (2.0, 0.1),
        (2.0, 0.005),
        (3.0, 0.05),
    ] {
        let at = |speed: f64| {
            PadOnDisc::preset_with(&[
                ("friction.stribeck_exponent", exponent),
                ("friction.stribeck_velocity", stribeck_velocity),
                ("operating_point.rotating_speed", speed),
            ])
        };
        // Friction falls infinitely steeply at rest with exponents below 1: half steps gain less there.
        let half = if exponent < 1.0 { 5e-6 } else { 2e-6 };
        for (divisor, tolerance) in [(1.0, 1e-5), (2.0, half)] {
            let error = error_of_saddle_node(at, divisor);
            assert!(error.abs() < tolerance, "{exponent} {stribeck_velocity} / {divisor}: {error:e}");
        }
    }
}

#[test]
fn a_disc_of_some_stribeck_velocities_has_the_error_of_a_plain_step() {
    for exponent in [1.0, 1.3, 2.0, 3.0] {
        let at = |speed: f64| {
            let changes = [("friction.stribeck_exponent", exponent), ("operating_point.rotating_speed", speed)];
            PadOnDisc::preset_with(&changes)
        };
        for (divisor, tolerance) in [(1.0, 2.1e-5), (2.0, 3e-6)] {
            let error = error_of_saddle_node(at, divisor);
            assert!(error.abs() < tolerance, "{exponent} / {divisor}: {error:e}");
        }
    }
}

/// The relative error of the speed at which stick-slip ends, with all steps divided; against the adaptive method.
fn error_of_saddle_node(at: impl Fn(f64) -> PadOnDisc, divisor: f64) -> f64 {
    let expected = at(10.0).saddle_node_speed().unwrap();
    let is_recaptured = |speed: f64| {
        let mut rigid = RigidBrake::new(&at(speed));
        rigid.step /= divisor;
        rigid.refinement /= divisor;
        !simulate_from_release(&rigid, inputs(&at(speed)), 5.0, rigid.step).sticks.is_empty()
    };
    let (mut with, mut without) = (0.9 * expected, 1.1 * expected);
    while without - with > 1e-9 * expected {
        let middle = 0.5 * (with + without);
        if is_recaptured(middle) { with = middle } else { without = middle }
    }
    with / expected - 1.0
}

#[test]
fn steps_resolve_the_rational_law_viscous_friction_and_measured_curves() {
    let curve = |rows: u32, width: f64, rise: f64, scatter: f64| {
        // Closer rows where the curve is steep; measured with some scatter of alternating sign.
        let speeds: Vec<f64> = (0..rows)
            .map(|i| 4.0 * (f64::from(i) / f64::from(rows - 1)) * f64::from(i + 3) / f64::from(rows + 2))
            .collect();
        let alternating = |i: usize| if i.is_multiple_of(2) { scatter } else { -scatter };
        let coefficients: Vec<f64> = speeds
            .iter()
            .enumerate()
            .map(|(i, speed)| 0.25 + 0.16 * libm::exp(-speed / width) + rise * speed + alternating(i))
            .collect();
        LawKind::Table(SharedCurve::new(MeasuredCurve::new(&speeds, &coefficients, None).unwrap()))
    };
    let laws = [
        (LawKind::Rational, 0.5, 0.0),
        (LawKind::Rational, 0.02, 0.0),
        (LawKind::Rational, 0.1, 0.004),
        (LawKind::Stribeck, 0.3, 0.004),
        (curve(4, 0.5, 0.0, 0.0), 1.0, 0.0),
        (curve(12, 0.4, 0.01, 0.0), 1.0, 0.0),
        (curve(30, 0.7, 0.01, 0.0), 1.0, 0.0),
        (curve(30, 0.7, 0.0, 0.002), 1.0, 0.0),
        (curve(200, 0.3, 0.005, 0.0), 1.0, 0.0),
    ];
    // Where the disc is some ten times as fast as the law's speed scale, plain steps alone are wrong by 1.5e-5.
    let mut too_large = Vec::new();
    for (number, (law, stribeck_velocity, viscous)) in laws.into_iter().enumerate() {
        let at = |speed: f64| {
            let mut parameters = Parameters::sui_ding_2018();
            parameters.operating_point.rotating_speed = speed;
            let friction = &mut parameters.friction;
            (friction.law, friction.stribeck_velocity, friction.viscous) = (law, stribeck_velocity, viscous);
            if let LawKind::Table(curve) = law {
                friction.use_table(curve);
            }
            PadOnDisc::new(parameters).unwrap()
        };
        for (divisor, tolerance) in [(1.0, 2e-5), (2.0, 3e-6)] {
            let error = error_of_saddle_node(at, divisor);
            if error.abs() >= tolerance {
                too_large.push(format!("law {number} / {divisor}: {error:e}"));
            }
        }
    }
    assert!(too_large.is_empty(), "{too_large:?}");
}

#[test]
fn a_touch_between_the_ends_of_a_step_is_seen() {
    // Friction that is flat at rest does not hold the pad up near the disc's speed: just below the saddle-node it
    // passes there for a moment much shorter than a step.
    let at = |speed: f64| {
        PadOnDisc::preset_with(&[("friction.stribeck_exponent", 2.0), ("operating_point.rotating_speed", speed)])
    };
    let saddle_node = at(10.0).saddle_node_speed().unwrap();
    let is_recaptured = |speed: f64, divisor: f64| {
        let rigid = RigidBrake::new(&at(speed));
        !simulate_from_release(&rigid, inputs(&at(speed)), 4.0, rigid.step / divisor).sticks.is_empty()
    };
    for divisor in [1.0, 1.1, 1.23, 1.37, 1.5, 1.71] {
        for share in [0.999, 0.9998, 0.9999] {
            assert!(is_recaptured(share * saddle_node, divisor), "{share} of {saddle_node}, step / {divisor}");
        }
        assert!(!is_recaptured(1.001 * saddle_node, divisor));
    }
}

#[test]
fn no_step_size_makes_it_chatter() {
    let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", 10.0)]);
    let rigid = RigidBrake::new(&brake);
    for divisor in [0.05, 0.1, 0.3, 1.0, 10.0, 77.0] {
        let log = simulate_from_release(&rigid, inputs(&brake), 200.0, rigid.step / divisor);
        // 200 time units are 56 cycles; chatter would show as hundreds of sticks.
        assert!((50..=65).contains(&log.sticks.len()), "step / {divisor}: {} sticks", log.sticks.len());
    }
}

#[test]
fn a_pad_that_runs_ahead_of_the_disc_returns_to_the_limit_cycle() {
    // Hurled against the calliper, the pad runs ahead of the disc and is caught on its way back.
    let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", 10.0)]);
    let rigid = RigidBrake::new(&brake);
    let sample = rigid.sample(inputs(&brake));
    let mut motion = Motion { state: RigidState { x: -0.5, u: 0.0 }, contact: ContactState::Slip };
    let mut log = EventLog::default();
    let mut overtook = false;
    for k in 0..4000 {
        advance(&sample, &mut motion, rigid.step * f64::from(k), rigid.step, &mut log).unwrap();
        overtook |= motion.contact == ContactState::Overtaking;
    }
    assert!(overtook);
    let tail: Vec<f64> = log.turns.iter().rev().take(2).map(|turn| turn.1).collect();
    let cycle = brake.limit_cycle().unwrap();
    assert!((tail[0].max(tail[1]) / cycle.tangential_max - 1.0).abs() < 1e-3, "{tail:?} {cycle:?}");
}
