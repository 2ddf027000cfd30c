mod end_of_stick_slip;
mod given_starts;

use super::*;
use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use crate::models::pad_on_disc::motion::advance::advance;
use crate::models::pad_on_disc::motion::integrator::Observer;
use crate::models::pad_on_disc::motion::start::{GivenStart, Start};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{bstab_with, uniform_draws};
use crate::models::pad_on_disc::rigid_disc::return_map::Fate;

mod laws;

const NOMINAL: RandomInputs = RandomInputs { preload: 0.1, static_friction: 0.39 };

fn criterion(speed: f64, disc: &DiscModel, settings: TimeDomainSettings) -> TimeDomain {
    TimeDomain::new(&PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]), disc, settings).unwrap()
}

const FLEXIBLE: DiscModel = DiscModel::Flexible { modes: 5 };

/// The last turning points of a motion, and when it last stuck.
#[derive(Default)]
struct LateMotion {
    turns: [f64; 2],
    last_stick: Option<f64>,
}

impl LateMotion {
    fn amplitude(&self) -> f64 {
        0.5 * (self.turns[1] - self.turns[0]).abs()
    }

    fn sticks_after(&self, time: f64) -> bool {
        self.last_stick.is_some_and(|stick| stick > time)
    }
}

impl Observer for LateMotion {
    fn turns(&mut self, _: f64, x: f64) {
        self.turns = [self.turns[1], x];
    }
    fn sticks(&mut self, time: f64, _: f64) {
        self.last_stick = Some(time);
    }
    fn slips(&mut self, _: f64) {}
}

/// Follows a sample for `time`, whatever a monitor might think of it.
fn late_motion(criterion: &TimeDomain, inputs: RandomInputs, time: f64) -> LateMotion {
    fn run<E: Equations>(equations: &E, mut motion: Motion<E::State>, h: f64, time: f64) -> LateMotion {
        let x = equations.tangential(&motion.state).0;
        let mut late_motion = LateMotion { turns: [x; 2], last_stick: None };
        for step in 0..(time / h) as u64 {
            advance(equations, &mut motion, step as f64 * h, h, &mut late_motion).unwrap();
        }
        late_motion
    }
    match &criterion.system {
        System::Rigid(brake) => {
            let sample = brake.sample(inputs);
            run(&sample, criterion.rigid_start(&sample, criterion.settings.start), brake.step, time)
        }
        System::Flexible(brake) => {
            let sample = brake.sample(inputs);
            run(&sample, criterion.flexible_start(&sample, criterion.settings.start).unwrap().0, brake.step, time)
        }
    }
}

/// The verdict of the flexible disc's monitor without knowledge of linear stability.
fn unaided_verdict(criterion: &TimeDomain, inputs: RandomInputs) -> Verdict {
    let System::Flexible(brake) = &criterion.system else { panic!("a flexible disc") };
    let sample = brake.sample(inputs);
    let (motion, equilibrium) = criterion.flexible_start(&sample, criterion.settings.start).unwrap();
    let options = MonitorOptions {
        slowest_transient: brake.brake.equations.slowest_transient(),
        smallest_cycle: brake.brake.equations.coefficients.pad.smallest_cycle(),
        until_settled: false,
        linear_growth_fed_by: None,
        refinement: 1.0,
    };
    let turning = (motion.state.u[0] == 0.0).then_some(motion.state.q[0]);
    let mut monitor = FlexibleMonitor::new(options, equilibrium, criterion.settings.displacement, turning);
    criterion.simulate(&sample, motion, &mut monitor, brake.step).verdict
}

/// Follows a sample ten times as long as its verdict took, and at least for some hundred cycles, and finds the same.
fn assert_verdict_holds(criterion: &TimeDomain, inputs: RandomInputs, context: &str) -> Verdict {
    let decision = criterion.decide(inputs);
    let soon = decision.time.max(60.0);
    let late = 10.0 * soon;
    let at_verdict = late_motion(criterion, inputs, soon).amplitude();
    let end = late_motion(criterion, inputs, late);
    let keeps_sticking = end.sticks_after(late - 10.0);
    let holds = match decision.verdict {
        Verdict::Unstable => keeps_sticking || end.amplitude() > at_verdict,
        Verdict::Stable => !keeps_sticking && (end.amplitude() < at_verdict || end.amplitude() < 1e-9),
        other => panic!("{context}: {inputs:?} {other:?}"),
    };
    assert!(holds, "{context}: {inputs:?} {decision:?} {at_verdict} then {} {:?}", end.amplitude(), end.last_stick);
    decision.verdict
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn verdicts_hold_ten_times_as_long_near_both_boundaries() {
    for (disc, boundaries) in [(DiscModel::Rigid, [15.56, 30.197]), (FLEXIBLE, [15.398, 30.6])] {
        for start in [Start::NearEquilibrium, Start::Rest, Start::LimitCycle] {
            let mut seen = [0; 4];
            for (boundary, offset) in
                boundaries.into_iter().flat_map(|b| (0..24).map(move |i| (b, (f64::from(i) - 11.3) / 11.3)))
            {
                // Denser towards the boundary: to one part in 1400 of it.
                let speed = boundary * (1.0 + 0.05 * offset * offset * offset.signum());
                let criterion = criterion(speed, &disc, TimeDomainSettings { start, ..Default::default() });
                let verdict = assert_verdict_holds(&criterion, NOMINAL, &format!("{disc:?} {start:?} {speed}"));
                seen[verdict as usize] += 1;
            }
            assert!(seen[0] >= 10 && seen[1] >= 10, "{disc:?} {start:?} {seen:?}: both verdicts must occur");
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn ringing_of_the_disc_is_no_instability() {
    // Much preload and little falling friction: the tangential motion dies away faster than the disc rings, and what
    // is left to see beats. No stick-slip exists there (22 rad/s, the limit cycle starts at f_s = 0.264 and more).
    for speed in [22.0, 30.0] {
        let criterion = criterion(speed, &FLEXIBLE, TimeDomainSettings { start: Start::Rest, ..Default::default() });
        for i in 0..60 {
            let (row, column) = (i / 10, i % 10);
            let preload = 0.35 + 0.13 * f64::from(row);
            let static_friction = 0.2502 + 0.0008 * f64::from(column);
            let inputs = RandomInputs { preload, static_friction };
            let end = late_motion(&criterion, inputs, 400.0);
            assert!(end.amplitude() < 2e-5 && !end.sticks_after(50.0), "{speed} {inputs:?}: it does not come to rest");
            assert_eq!(criterion.decide(inputs).verdict, Verdict::Stable, "{speed} {inputs:?}");
        }
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn the_threshold_in_time_is_that_of_the_eigenvalues() {
    for disc in [DiscModel::Rigid, FLEXIBLE] {
        // A small displacement: at one percent of x0 the falling friction is no longer quite linear.
        let settings = TimeDomainSettings { displacement: 1e-4, ..Default::default() };
        let boundary = |is_unstable: &dyn Fn(&TimeDomain) -> bool| {
            let (mut slow, mut fast) = (14.0, 17.0);
            while fast - slow > 1e-4 {
                let middle = 0.5 * (slow + fast);
                if is_unstable(&criterion(middle, &disc, settings)) { slow = middle } else { fast = middle }
            }
            slow
        };
        // By the motion itself, and on a flexible disc by the monitor without knowledge of linear stability.
        let grows = |criterion: &TimeDomain| {
            let [soon, late] = [800.0, 1600.0].map(|time| late_motion(criterion, NOMINAL, time));
            late.sticks_after(0.0) || late.amplitude() > soon.amplitude()
        };
        let in_time = match disc {
            DiscModel::Rigid => vec![boundary(&grows)],
            DiscModel::Flexible { .. } => {
                vec![boundary(&grows), boundary(&|at| unaided_verdict(at, NOMINAL) == Verdict::Unstable)]
            }
        };
        let by_eigenvalues = boundary(&|criterion| match &criterion.system {
            System::Rigid(_) => criterion.brake.growth_rate() > 0.0,
            System::Flexible(brake) => brake.brake.growth_rate(NOMINAL).unwrap() > 0.0,
        });
        let by_criterion = boundary(&|criterion| criterion.decide(NOMINAL).verdict == Verdict::Unstable);
        // What is left is the damping of the method, a part in 10^5; the criterion itself has none.
        for in_time in in_time {
            assert!((in_time - by_eigenvalues).abs() < 1e-3, "{disc:?} {in_time} {by_eigenvalues}");
        }
        assert!((by_criterion - by_eigenvalues).abs() < 2e-4, "{disc:?} {by_criterion} {by_eigenvalues}");
    }
}

#[test]
fn what_a_brake_does_between_the_boundaries_depends_on_its_start() {
    for disc in [DiscModel::Rigid, FLEXIBLE] {
        for (speed, expected) in [
            (12.0, [Verdict::Unstable, Verdict::Unstable, Verdict::Unstable]),
            (22.0, [Verdict::Stable, Verdict::Unstable, Verdict::Unstable]),
            (34.0, [Verdict::Stable, Verdict::Stable, Verdict::Stable]),
        ] {
            for (start, expected) in [Start::NearEquilibrium, Start::Rest, Start::LimitCycle].into_iter().zip(expected)
            {
                let criterion = criterion(speed, &disc, TimeDomainSettings { start, ..Default::default() });
                assert_eq!(criterion.decide(NOMINAL).verdict, expected, "{disc:?} {speed} {start:?}");
            }
        }
    }
}

#[test]
fn the_settled_amplitude_is_that_of_the_limit_cycle() {
    let settings = TimeDomainSettings { record_amplitude: true, ..Default::default() };
    for speed in [8.0, 12.0, 15.0] {
        let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
        let cycle = brake.limit_cycle().unwrap();
        let expected = 0.5 * (cycle.tangential_max - cycle.tangential_min);
        let rigid = criterion(speed, &DiscModel::Rigid, settings).decide(NOMINAL).recorded[0].unwrap();
        assert!((rigid / expected - 1.0).abs() < 2e-4, "{speed}: {rigid} {expected}");
        let flexible = criterion(speed, &FLEXIBLE, settings).decide(NOMINAL).recorded[0].unwrap();
        assert!((flexible / expected - 1.0).abs() < 0.05, "{speed}: {flexible} {expected}");
    }
}

#[test]
fn the_papers_index_is_a_limit_on_the_settled_amplitude() {
    let monitor = |limit: f64| {
        let settings = TimeDomainSettings { amplitude_index: Some(limit), ..Default::default() };
        criterion(12.0, &DiscModel::Rigid, settings).decide(NOMINAL).verdict
    };
    // The limit cycle at 12 rad/s has an amplitude of 0.0057.
    assert_eq!([monitor(0.005), monitor(0.006)], [Verdict::Unstable, Verdict::Stable]);
}

#[test]
fn inputs_outside_physics_are_stable_and_blown_up_ones_failed() {
    let criterion = criterion(10.0, &FLEXIBLE, TimeDomainSettings::default());
    for (preload, static_friction) in [(0.0, 0.4), (-0.1, 0.4), (0.1, 0.2), (0.1, 0.0), (-0.1, 0.2)] {
        let decision = criterion.decide(RandomInputs { preload, static_friction });
        assert_eq!((decision.verdict, decision.time), (Verdict::Stable, 0.0));
    }
    assert_eq!(criterion.decide(RandomInputs { preload: 0.1, static_friction: f64::NAN }).verdict, Verdict::Failed);
    assert_eq!(criterion.decide(RandomInputs { preload: f64::NAN, static_friction: 0.4 }).verdict, Verdict::Failed);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn recording_the_amplitude_changes_no_verdict() {
    for (disc, horizon) in [(DiscModel::Rigid, 9.0), (FLEXIBLE, 40.0)] {
        for start in [Start::NearEquilibrium, Start::Rest] {
            let plain = TimeDomainSettings { start, horizon, ..Default::default() };
            let recording = TimeDomainSettings { record_amplitude: true, ..plain };
            let [plain, recording] = [plain, recording].map(|settings| criterion(15.0, &disc, settings));
            for i in 0..120 {
                let inputs = RandomInputs { preload: 0.003 * f64::from(i), static_friction: 0.39 };
                let (plain, recording) = (plain.decide(inputs), recording.decide(inputs));
                assert_eq!(plain.verdict, recording.verdict, "{disc:?} {start:?} {inputs:?}");
                assert!(recording.recorded[0].is_none() || recording.verdict == Verdict::Unstable);
            }
        }
    }
}

#[test]
fn a_displacement_beyond_the_limit_cycle_makes_no_stick_slip_stable() {
    for disc in [DiscModel::Rigid, FLEXIBLE] {
        for displacement in [0.5, 5.0, 20.0] {
            let settings = TimeDomainSettings { displacement, ..Default::default() };
            assert_eq!(criterion(10.0, &disc, settings).decide(NOMINAL).verdict, Verdict::Unstable, "{displacement}");
            assert_eq!(criterion(40.0, &disc, settings).decide(NOMINAL).verdict, Verdict::Stable, "{displacement}");
        }
    }
}

#[test]
fn overdamped_and_stiff_motions_are_decided_too() {
    for damping in [6e3, 1e4, 1e5] {
        for disc in [DiscModel::Rigid, FLEXIBLE] {
            for start in [Start::NearEquilibrium, Start::Rest] {
                let brake = PadOnDisc::preset_with(&[("damping.tangential", damping)]);
                let settings = TimeDomainSettings { start, ..Default::default() };
                let decision = TimeDomain::new(&brake, &disc, settings).unwrap().decide(NOMINAL);
                assert_eq!(decision.verdict, Verdict::Stable, "{damping} {disc:?} {start:?} {decision:?}");
            }
        }
    }
    // The normal motion may be as stiff.
    let brake = PadOnDisc::preset_with(&[("damping.normal", 1e5)]);
    let decision = TimeDomain::new(&brake, &FLEXIBLE, TimeDomainSettings::default()).unwrap().decide(NOMINAL);
    assert_eq!(decision.verdict, Verdict::Stable, "{decision:?}");
}

#[test]
fn a_brake_whose_disc_flutters_is_unstable_and_fed_by_the_disc() {
    // Without damping the disc is unstable at any speed; with it, far beyond all that discs withstand. The audit's
    // brake: coupled growth +0.0007, which the tangential motion does not show.
    let audited = [
        ("disc.youngs_modulus", 7e10),
        ("disc.thickness", 0.01),
        ("disc.transverse_damping_ratio", 0.002),
        ("friction.stribeck_velocity", 20.0),
        ("friction.kinetic_coefficient", 0.15),
        ("friction.static_coefficient", 0.45),
        ("operating_point.rotating_speed", 20.0),
    ];
    for (changes, modes) in [
        (&[("disc.transverse_damping_ratio", 0.0), ("operating_point.rotating_speed", 20.0)][..], 5),
        (&[("disc.transverse_damping_ratio", 0.02), ("operating_point.rotating_speed", 2e4)][..], 5),
        (&audited[..], 16),
    ] {
        let brake = PadOnDisc::preset_with(changes);
        let inputs = RandomInputs { preload: 0.1, static_friction: brake.parameters().friction.static_coefficient };
        for start in [Start::NearEquilibrium, Start::Rest, Start::LimitCycle] {
            let settings = TimeDomainSettings { start, ..Default::default() };
            let criterion = TimeDomain::new(&brake, &DiscModel::Flexible { modes }, settings).unwrap();
            let decision = criterion.decide(inputs);
            assert_eq!(decision.verdict, Verdict::Unstable, "{changes:?} {start:?}");
            assert_eq!(decision.fed_by, Some(DegreeOfFreedom::Disc as usize), "{changes:?} {start:?}");
        }
    }
    let groaning = criterion(10.0, &FLEXIBLE, TimeDomainSettings::default()).decide(NOMINAL);
    assert_eq!(groaning.fed_by, Some(DegreeOfFreedom::Tangential as usize));
    assert_eq!(criterion(40.0, &FLEXIBLE, TimeDomainSettings::default()).decide(NOMINAL).fed_by, None);
}

#[test]
fn friction_that_rises_with_speed_does_not_stop_flutter() {
    let brake = PadOnDisc::preset_with(&[("disc.transverse_damping_ratio", 0.0)]);
    let rising = RandomInputs { preload: 0.1, static_friction: 0.2 };
    let flexible = TimeDomain::new(&brake, &FLEXIBLE, TimeDomainSettings::default()).unwrap().decide(rising);
    assert_eq!((flexible.verdict, flexible.fed_by), (Verdict::Unstable, Some(DegreeOfFreedom::Disc as usize)));
    let rigid = TimeDomain::new(&brake, &DiscModel::Rigid, TimeDomainSettings::default()).unwrap().decide(rising);
    assert_eq!(rigid.verdict, Verdict::Stable);
}

#[test]
fn a_pad_that_stuck_once_and_creeps_towards_the_equilibrium_is_stable() {
    // An overdamped brake that sticks once and then never turns.
    let changes = [("damping.tangential", 6000.0), ("operating_point.rotating_speed", 10.0)];
    let brake = PadOnDisc::preset_with(&changes);
    let settings = TimeDomainSettings { start: Start::Rest, ..Default::default() };
    for disc in [DiscModel::Rigid, FLEXIBLE] {
        let decision = TimeDomain::new(&brake, &disc, settings).unwrap().decide(NOMINAL);
        assert_eq!(decision.verdict, Verdict::Stable, "{disc:?} {decision:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn ringing_after_a_long_stick_is_no_instability() {
    // On a disc so slow the pad sticks for 2300 units of time, and what rings at its release beats for some hundred.
    let changes = [
        ("disc.youngs_modulus", 7.26e10),
        ("disc.thickness", 0.0117),
        ("disc.transverse_damping_ratio", 0.01025),
        ("stiffness.calliper_tangential", 4.914e7),
        ("stiffness.calliper_normal", 4.411e7),
        ("stiffness.calliper_angular", 1.729e4),
        ("stiffness.contact_normal", 2.214e7),
        ("stiffness.contact_tangential_1", 1.3066e7),
        ("stiffness.contact_tangential_2", 2.8613e7),
        ("damping.tangential", 25.14),
        ("damping.normal", 47.2),
        ("damping.angular", 0.1022),
        ("friction.kinetic_coefficient", 0.15916),
        ("friction.stribeck_velocity", 0.3982),
        ("friction.stribeck_exponent", 1.5),
        ("operating_point.rotating_speed", 0.00151),
    ];
    let inputs = RandomInputs { preload: 0.0908, static_friction: 0.16947 };
    let settings = TimeDomainSettings { start: Start::Rest, ..Default::default() };
    let criterion = TimeDomain::new(&PadOnDisc::preset_with(&changes), &FLEXIBLE, settings).unwrap();
    let end = late_motion(&criterion, inputs, 8000.0);
    assert!(end.amplitude() < 1e-10 && !end.sticks_after(3000.0), "it does not come to rest");
    let decision = criterion.decide(inputs);
    assert_eq!(decision.verdict, Verdict::Stable, "{decision:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_motion_whose_disc_rings_longer_than_its_pad_swings_is_decided() {
    // Partial contact and little damping of the disc: beyond time 100 nothing but its beats is left to see.
    let changes = [
        ("disc.youngs_modulus", 2.726e10),
        ("disc.thickness", 0.01058),
        ("disc.transverse_damping_ratio", 0.002523),
        ("stiffness.calliper_tangential", 4.598e7),
        ("stiffness.calliper_normal", 1.2391e7),
        ("stiffness.calliper_angular", 6.899e4),
        ("stiffness.contact_normal", 1.1207e8),
        ("stiffness.contact_tangential_1", 1.6564e7),
        ("stiffness.contact_tangential_2", 2.3442e7),
        ("damping.tangential", 1465.5),
        ("damping.normal", 209.3),
        ("damping.angular", 0.06608),
        ("friction.kinetic_coefficient", 0.33254),
        ("friction.stribeck_velocity", 1.8077),
        ("friction.stribeck_exponent", 1.5),
        ("operating_point.rotating_speed", 15.614),
    ];
    let inputs = RandomInputs { preload: 0.1146, static_friction: 0.64816 };
    let settings = TimeDomainSettings { start: Start::Rest, ..Default::default() };
    let decision = TimeDomain::new(&PadOnDisc::preset_with(&changes), &FLEXIBLE, settings).unwrap().decide(inputs);
    assert_eq!(decision.verdict, Verdict::Stable, "{decision:?}");
    assert!(decision.time < 4000.0, "{decision:?}");
}

#[test]
fn smooth_cycles_are_unstable_up_to_the_speed_at_which_they_end() {
    // The audit: exponent 2, c_x 3000, from rest; sustained to 7.3237 rad/s.
    let at = |speed: f64, record_amplitude: bool| {
        let brake = PadOnDisc::preset_with(&[
            ("friction.stribeck_exponent", 2.0),
            ("damping.tangential", 3000.0),
            ("operating_point.rotating_speed", speed),
        ]);
        let settings = TimeDomainSettings { start: Start::Rest, record_amplitude, ..Default::default() };
        TimeDomain::new(&brake, &DiscModel::Rigid, settings).unwrap().decide(NOMINAL)
    };
    for (speed, expected) in [(7.25, Verdict::Unstable), (7.3236, Verdict::Unstable), (7.3238, Verdict::Stable)] {
        assert_eq!(at(speed, false).verdict, expected, "{speed}");
    }
    let amplitudes = [7.0, 7.25, 7.32].map(|speed| at(speed, true).recorded[0].unwrap());
    assert!(amplitudes.is_sorted_by(|a, b| a > b) && amplitudes[2] > 1e-4, "{amplitudes:?}");
}

#[test]
fn a_pad_that_overtakes_the_disc_in_every_cycle_is_unstable() {
    // The limit cycle of this brake is tested against SciPy with those of `limit_cycle`.
    let brake = bstab_with(&[
        ("operating_point.preload", 0.05),
        ("damping.tangential", 0.001),
        ("operating_point.rotating_speed", 2.2),
    ]);
    let inputs = RandomInputs { preload: 0.05, static_friction: 1.0 };
    let cycle = brake.limit_cycle().unwrap();
    // From outside and from inside of the cycle, and from the disc's speed.
    for (tangential, velocity) in [(2.5, 0.0), (2.2, 0.0), (0.04, 2.2), (-3.0, 2.0)] {
        let start = Start::Given(GivenStart {
            tangential: Some(tangential),
            velocity: Some(velocity),
            ..GivenStart::default()
        });
        for record_amplitude in [false, true] {
            let settings = TimeDomainSettings { start, record_amplitude, ..Default::default() };
            let decision = TimeDomain::new(&brake, &DiscModel::Rigid, settings).unwrap().decide(inputs);
            assert_eq!(decision.verdict, Verdict::Unstable, "{tangential} {velocity}: {decision:?}");
            let Some(amplitude) = decision.recorded[0] else { continue };
            let expected = 0.5 * (cycle.tangential_max - cycle.tangential_min);
            assert!((amplitude / expected - 1.0).abs() < 1e-3, "{tangential} {velocity}: {decision:?}");
        }
    }
}

#[test]
fn a_short_horizon_leaves_samples_undecided() {
    let settings = TimeDomainSettings { horizon: 3.0, ..Default::default() };
    assert_eq!(criterion(15.5, &FLEXIBLE, settings).decide(NOMINAL).verdict, Verdict::Undecided);
}

#[test]
fn settings_out_of_range_are_refused() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let good = TimeDomainSettings::default();
        assert!(TimeDomainSettings { horizon: bad, ..good }.validate().is_err());
        assert!(TimeDomainSettings { displacement: bad, ..good }.validate().is_err());
        assert!(TimeDomainSettings { amplitude_index: Some(bad), ..good }.validate().is_err());
    }
    assert!(TimeDomainSettings::default().validate().is_ok());
    // More than 1e8 steps.
    let brake = PadOnDisc::preset_with(&[]);
    let endless = TimeDomainSettings { horizon: 1e8, ..Default::default() };
    assert!(matches!(
        TimeDomain::new(&brake, &DiscModel::Rigid, endless).unwrap_err(),
        TimeDomainError::Settings(SettingsError::OutOfRange { key: "horizon", .. })
    ));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn verdicts_are_right_on_both_sides_of_the_end_of_stick_slip() {
    // Its speed is where the adaptive method finds it: to 1e-10, as the tests of `limit_cycle` see it with SciPy.
    let mut draw = uniform_draws(31);
    let mut found = 0;
    for _ in 0..40 {
        let spread = |share: f64, low: f64, high: f64| libm::exp(libm::log(low) + share * libm::log(high / low));
        let changes = [
            ("damping.tangential", spread(draw(), 10.0, 1500.0)),
            ("friction.kinetic_coefficient", 0.25),
            ("friction.static_coefficient", 0.25 + 0.4 * draw()),
            ("friction.stribeck_velocity", spread(draw(), 0.01, 1.0)),
            ("friction.stribeck_exponent", [0.5, 0.7, 1.0, 1.5, 2.0][(5.0 * draw()) as usize]),
            ("operating_point.preload", spread(draw(), 0.02, 0.4)),
        ];
        let Some(end) = PadOnDisc::preset_with(&changes).saddle_node_speed() else { continue };
        for distance in [-1e-5, -1e-6, -1e-7, 1e-7, 1e-6, 1e-5] {
            let speed = [("operating_point.rotating_speed", end * (1.0 + distance))];
            let brake = PadOnDisc::preset_with(&[&changes[..], &speed].concat());
            let parameters = brake.parameters();
            let inputs = RandomInputs {
                preload: parameters.operating_point.preload,
                static_friction: parameters.friction.static_coefficient,
            };
            let settings = TimeDomainSettings { start: Start::LimitCycle, ..Default::default() };
            let criterion = TimeDomain::new(&brake, &DiscModel::Rigid, settings).unwrap();
            let after_a_pass = brake.planar_motion().fate_of_release();
            let expected = match (distance < 0.0, after_a_pass) {
                (true, _) => Verdict::Unstable,
                (false, Fate::Equilibrium) => Verdict::Stable,
                // A cycle without sticking, or sliding that is linearly unstable.
                (false, _) => continue,
            };
            assert_eq!(criterion.decide(inputs).verdict, expected, "{changes:?} {distance}");
            found += 1;
        }
    }
    assert!(found > 120, "{found}");
}
