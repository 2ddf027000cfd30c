use super::*;
use crate::friction::measured_curve::{MeasuredCurve, SharedCurve};
use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::criterion::time_domain::DiscModel;
use crate::models::pad_on_disc::parameters::Parameters;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

const STARTS: [Start; 3] = [Start::NearEquilibrium, Start::Rest, Start::LimitCycle];

/// The preset with a measured curve that is shifted by `band` standard deviations.
fn brake(preload: f64, rotating_speed: f64, band: f64) -> PadOnDisc {
    let (speeds, coefficients, deviations) = ([0.0, 0.5, 2.0, 5.0], [0.45, 0.38, 0.3, 0.28], [0.02, 0.05, 0.08, 0.08]);
    let curve = MeasuredCurve::new(&speeds, &coefficients, Some(&deviations)).unwrap();
    let mut parameters = Parameters::sui_ding_2018();
    parameters.friction.use_table(SharedCurve::new(curve));
    parameters.friction.band = band;
    parameters.operating_point.preload = preload;
    parameters.operating_point.rotating_speed = rotating_speed;
    PadOnDisc::new(parameters).unwrap()
}

fn inputs(brake: &PadOnDisc) -> RandomInputs {
    let parameters = brake.parameters();
    RandomInputs {
        preload: parameters.operating_point.preload,
        static_friction: parameters.friction.static_coefficient,
    }
}

fn criterion(brake: &PadOnDisc, disc: &DiscModel, start: Start) -> TimeDomain {
    TimeDomain::new(brake, disc, TimeDomainSettings { start, ..TimeDomainSettings::default() }).unwrap()
}

/// Stick-slip, from any of these starts, slides at the most at the speed at which friction vanishes where the disc turns
/// at 9.7603 rad/s (friction vanishes at 3.1215 m/s) and at 6.0826 rad/s (3.6782 m/s): found outside the program, in
/// Python, by a classical Runge-Kutta method in SI with 300 and with 600 steps a period, on PCHIP.
#[test]
fn a_motion_is_outside_the_model_from_the_speed_at_which_it_meets_no_friction() {
    for (preload, band, limit) in [(0.02, -3.6, 9.7603), (0.05, -3.55, 6.0826)] {
        for start in STARTS {
            for (factor, expected) in [(0.5, false), (0.998, false), (1.002, true), (1.1, true)] {
                let brake = brake(preload, factor * limit, band);
                let criterion = criterion(&brake, &DiscModel::Rigid, start);
                let inputs = inputs(&brake);
                assert!(!brake.is_outside_physics(inputs));
                assert_eq!(criterion.meets_no_friction(inputs), expected, "{preload} {factor} {start:?}");
                let decision = criterion.decide(inputs);
                let verdict = if expected { Verdict::Stable } else { Verdict::Unstable };
                assert_eq!(decision.verdict, verdict, "{preload} {factor} {start:?}");
                assert_eq!(decision.time == 0.0 && verdict == Verdict::Stable, expected);
            }
        }
    }
}

#[test]
fn friction_that_vanishes_where_a_motion_does_not_come_leaves_it_as_it_is() {
    // Shifted so far it is above 0 at every speed, if only by 0.0008.
    let brake = brake(0.02, 20.0, -3.49);
    assert!(!criterion(&brake, &DiscModel::Rigid, Start::Rest).meets_no_friction(inputs(&brake)));
    // So little presses that the pad returns from a small displacement.
    let shifted = self::brake(0.001, 20.0, -3.6);
    let speeds = shifted.speeds_without_friction();
    assert!(speeds.len() == 1 && (speeds[0][0] - 3.121_518_2).abs() < 1e-6 && speeds[0][1].is_infinite(), "{speeds:?}");
    let near = criterion(&shifted, &DiscModel::Rigid, Start::NearEquilibrium);
    assert!(!near.meets_no_friction(inputs(&shifted)));
    assert_eq!(near.decide(inputs(&shifted)).verdict, Verdict::Stable);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_motion_on_a_flexible_disc_is_outside_the_model_if_its_moments_are() {
    let mut seen = [0; 2];
    for rotating_speed in [4.0, 7.0, 9.0, 11.0, 13.0] {
        let brake = brake(0.02, rotating_speed, -3.6);
        let criterion = criterion(&brake, &DiscModel::Flexible { modes: 5 }, Start::Rest);
        let inputs = inputs(&brake);
        let law = brake.friction_law();
        let [_, above] = law.positive_about(brake.disc_speed());
        let trajectory = criterion.trajectory(inputs, 400.0).unwrap();
        let moments = &trajectory.moments;
        let fastest = moments.iter().map(|moment| moment.sliding_speed.abs()).fold(0.0, f64::max);
        assert!((fastest / above - 1.0).abs() > 1e-2, "{rotating_speed} shows nothing");
        let expected = fastest > above;
        assert_eq!(criterion.meets_no_friction(inputs), expected, "{rotating_speed}");
        assert!(trajectory.lacks_friction == expected && (!expected || trajectory.verdict == Verdict::Stable));
        seen[usize::from(expected)] += 1;
    }
    assert!(seen.into_iter().all(|count| count > 0), "{seen:?}");
}

#[test]
fn a_crest_between_steps_is_met() {
    // sin over 1.2 to 2.0 in steps of 0.2: the crest at pi / 2 lies between the steps.
    let mut met = MetSpeeds::new(libm::sin(1.2));
    for step in 1..=4 {
        met.add(libm::sin(1.2 + 0.2 * f64::from(step)));
    }
    assert!((met.most - 1.0).abs() < 5e-5, "{}", met.most);
    assert!(met.leave([f64::NEG_INFINITY, 0.9999]) && !met.leave([f64::NEG_INFINITY, 1.001]));
    // A pad that overtakes the disc has come by every sliding speed down to 0.
    met.add(-0.1);
    assert!(met.leave([0.0, 1.5]) && !met.leave([-0.1, 1.5]));
}
