//! Starts that are given in numbers.

use super::*;
use crate::models::pad_on_disc::motion::start::{GivenStart, StartUnits};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::uniform_draws;
use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, SlipEnd};

fn scaled(tangential: f64, velocity: f64) -> GivenStart {
    let units = StartUnits::Scaled;
    GivenStart { tangential: Some(tangential), velocity: Some(velocity), units, ..Default::default() }
}

fn with(start: GivenStart) -> TimeDomainSettings {
    TimeDomainSettings { start: Start::Given(start), ..Default::default() }
}

/// What happens to a motion on a rigid disc, by the adaptive method alone: whether it comes to stick for ever. `None`
/// if this takes too long.
fn keeps_sticking(motion: &PlanarMotion, mut x: f64, mut u: f64) -> Option<bool> {
    let v = motion.disc_speed;
    // A pad that overtakes is one that slips, seen in a mirror.
    let mirrored = PlanarMotion { disc_speed: -v, ..*motion };
    let mut sticks = 0;
    let mut tops: Vec<f64> = Vec::new();
    for _ in 0..3000 {
        let size = (x - motion.equilibrium()).abs().max(u.abs()).max(v) / motion.stiffness.sqrt().min(1.0);
        let held = (motion.stiffness * x + motion.damping * v).abs() <= motion.law.static_coefficient;
        if u == v && held {
            sticks += 1;
            if sticks == 2 {
                return Some(true);
            }
            x = motion.release();
            tops.clear();
        }
        // At the disc's speed the spring decides; on release it pulls back.
        let pulled_back = motion.stiffness * x + motion.damping * v > 0.0;
        if u < v || (u == v && pulled_back) {
            let slip = motion.slip([x, u], size);
            match slip.end {
                SlipEnd::Turned => {
                    (x, u) = (slip.x, 0.0);
                    tops.push(x - motion.equilibrium());
                    let [.., before, last] = tops[..] else { continue };
                    let change = last / before - 1.0;
                    if change.abs() < 1e-9 {
                        return None;
                    }
                    // With an exponent of 1 only one cycle without sticking exists, and it is unstable.
                    if change < 0.0 {
                        return Some(false);
                    }
                }
                SlipEnd::Captured => (x, u) = (slip.x, v),
                SlipEnd::Equilibrium => return Some(false),
                SlipEnd::Unresolved => return None,
            }
        } else {
            let slip = mirrored.slip([-x, -u], size);
            assert_eq!(slip.end, SlipEnd::Captured, "overtaking ends at the disc's speed");
            (x, u) = (-slip.x, v);
            tops.clear();
        }
    }
    None
}

#[test]
fn starts_of_all_kinds_on_a_rigid_disc_end_as_the_return_map_says() {
    let mut draw = uniform_draws(12);
    let mut counts = [0; 2];
    let mut unresolved = 0;
    for _ in 0..600 {
        let brake = PadOnDisc::preset_with(&[
            ("operating_point.rotating_speed", 16.0 + 18.0 * draw()),
            ("damping.tangential", 369.0 * (0.7 + 0.6 * draw())),
        ]);
        let RigidBrake { disc_speed, stiffness, .. } = RigidBrake::new(&brake);
        let sample = RigidBrake::new(&brake);
        let sample = sample.sample(NOMINAL);
        let (x0, swing) = (sample.equilibrium(), disc_speed / stiffness.sqrt());
        let far = if draw() < 0.2 { 100.0 } else { 1.0 };
        let x = if draw() < 0.2 { x0 } else { x0 + far * swing * (8.0 * draw() - 4.0) };
        let u = match (6.0 * draw()) as u32 {
            0 => 0.0,
            1 => disc_speed,
            2 => disc_speed * (1.0 + 3.0 * far * draw()),
            3 => -disc_speed * 3.0 * far * draw(),
            _ => disc_speed * draw(),
        };
        let motion = sample.planar_motion();
        if motion.damping_at_equilibrium() <= 0.0 {
            continue;
        }
        let decision = TimeDomain::new(&brake, &DiscModel::Rigid, with(scaled(x, u))).unwrap().decide(NOMINAL);
        match keeps_sticking(&motion, x, u) {
            None => unresolved += 1,
            Some(sticks) => {
                let expected = if sticks { Verdict::Unstable } else { Verdict::Stable };
                assert_eq!(
                    decision.verdict,
                    expected,
                    "{:?} from {x} {u} (x0 {x0}, v {disc_speed})",
                    brake.parameters()
                );
                counts[usize::from(sticks)] += 1;
            }
        }
    }
    assert!(counts[0] > 100 && counts[1] > 100 && unresolved < 30, "{counts:?} {unresolved}");
}

#[test]
fn the_state_of_contact_follows_from_speed_and_friction() {
    let brake = PadOnDisc::preset_with(&[]);
    let rigid = RigidBrake::new(&brake);
    let sample = rigid.sample(NOMINAL);
    let (v, release) = (sample.brake.disc_speed, sample.release());
    let behind = -(sample.static_pull + sample.brake.damping * v) / sample.brake.stiffness;
    for disc in [DiscModel::Rigid, FLEXIBLE] {
        for (x, u, expected) in [
            (0.0, 0.0, ContactState::Slip),
            (0.0, 0.999 * v, ContactState::Slip),
            (0.0, v, ContactState::Stick),
            (0.0, v * (1.0 + 1e-10), ContactState::Stick),
            (0.9 * release, v, ContactState::Stick),
            (1.1 * release, v, ContactState::Slip),
            (1.1 * behind, v, ContactState::Overtaking),
            (0.0, 1.001 * v, ContactState::Overtaking),
        ] {
            let criterion = TimeDomain::new(&brake, &disc, with(scaled(x, u))).unwrap();
            let (contact, speed) = match &criterion.system {
                System::Rigid(motion) => {
                    let start = criterion.rigid_start(&motion.sample(NOMINAL), criterion.settings.start);
                    (start.contact, start.state.u)
                }
                System::Flexible(motion) => {
                    let start = criterion.flexible_start(&motion.sample(NOMINAL), criterion.settings.start).unwrap().0;
                    (start.contact, start.state.u[0])
                }
            };
            assert_eq!(contact, expected, "{disc:?} {x} {u}");
            if expected == ContactState::Stick {
                assert_eq!(speed, v);
            }
        }
    }
}

#[test]
fn a_start_in_si_units_is_the_same_as_in_scaled_ones() {
    let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", 22.0)]);
    let scales = brake.scales();
    let (x, u) = (0.013, 0.004);
    let si = GivenStart { tangential: Some(x * scales.length), velocity: Some(u * scales.speed), ..Default::default() };
    let [si, scaled] = [si, scaled(x, u)].map(|start| {
        let criterion = TimeDomain::new(&brake, &DiscModel::Rigid, with(start)).unwrap();
        let System::Rigid(motion) = &criterion.system else { unreachable!() };
        criterion.rigid_start(&motion.sample(NOMINAL), criterion.settings.start).state
    });
    assert!((si.x / scaled.x - 1.0).abs() < 1e-15 && (si.u / scaled.u - 1.0).abs() < 1e-15);
}

#[test]
fn what_a_start_leaves_out_is_steady_sliding() {
    for disc in [DiscModel::Rigid, FLEXIBLE] {
        for (start, displaced) in [
            (GivenStart::default(), 0.0),
            (GivenStart { from_equilibrium: true, ..Default::default() }, 0.0),
            (
                GivenStart {
                    tangential: Some(1e-3),
                    from_equilibrium: true,
                    units: StartUnits::Scaled,
                    ..Default::default()
                },
                1e-3,
            ),
        ] {
            let criterion = criterion(22.0, &disc, with(start));
            match &criterion.system {
                System::Rigid(motion) => {
                    let sample = motion.sample(NOMINAL);
                    let start = criterion.rigid_start(&sample, criterion.settings.start).state;
                    assert_eq!(start, RigidState { x: sample.equilibrium() + displaced, u: 0.0 });
                }
                System::Flexible(motion) => {
                    let sample = motion.sample(NOMINAL);
                    let mut expected = sample.equilibrium().unwrap();
                    expected.q[0] += displaced;
                    assert_eq!(criterion.flexible_start(&sample, criterion.settings.start).unwrap().0.state, expected);
                }
            }
            assert_eq!(criterion.decide(NOMINAL).verdict, Verdict::Stable, "{disc:?} {start:?}");
        }
    }
}

#[test]
fn starts_that_no_pad_can_have_are_refused_and_fail() {
    for disc in [DiscModel::Rigid, FLEXIBLE] {
        for (x, u) in [(2e3, 0.0), (-1e3, 0.0), (0.0, 1e6), (f64::NAN, 0.0), (0.0, f64::INFINITY)] {
            let criterion = criterion(22.0, &disc, with(scaled(x, u)));
            let error = criterion.check_start(NOMINAL).unwrap_err();
            assert!(matches!(error, TimeDomainError::Start(StartError::OutOfReach { .. })), "{error}");
            assert_eq!(criterion.decide(NOMINAL).verdict, Verdict::Failed, "{disc:?} {x} {u}");
        }
    }
    for (normal, angle) in [(0.1, 0.0), (f64::NAN, 0.0), (-0.05, 2.0)] {
        let start =
            GivenStart { normal: Some(normal), angle: Some(angle), units: StartUnits::Scaled, ..Default::default() };
        let criterion = criterion(22.0, &FLEXIBLE, with(start));
        let error = criterion.check_start(NOMINAL).unwrap_err();
        assert!(matches!(error, TimeDomainError::Start(StartError::LiftedOff { .. })), "{error}");
        assert_eq!(criterion.decide(NOMINAL).verdict, Verdict::Failed, "{normal} {angle}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn knocks_on_a_flexible_disc_end_as_their_motions_do() {
    // At 22 rad/s steady sliding is stable, and so is stick-slip.
    let at_rest = 1e-4;
    let mut seen = [0; 2];
    for (tangential, velocity, normal, angle) in [
        (0.0, 0.0, 0.0, 0.0),
        (0.0, 1e-3, 0.0, 0.0),
        (0.0, 0.02, 0.0, 0.0),
        (0.0, -0.05, 0.0, 0.0),
        (0.02, 0.0, 0.0, 0.0),
        (-0.03, 0.1, 0.0, 0.0),
        (0.0, 0.0, -0.01, 0.0),
        (0.0, 0.0, 0.0, 0.02),
        (0.0, 0.0, -0.03, 0.05),
        (0.3, 0.0, 0.0, 0.0),
    ] {
        let start = GivenStart {
            tangential: Some(tangential),
            velocity: Some(velocity),
            normal: Some(normal),
            angle: Some(angle),
            from_equilibrium: true,
            units: StartUnits::Scaled,
        };
        let criterion = criterion(22.0, &FLEXIBLE, with(start));
        let late = late_motion(&criterion, NOMINAL, 2000.0);
        let expected = if late.sticks_after(1900.0) {
            Verdict::Unstable
        } else {
            assert!(late.amplitude() < at_rest, "{start:?}: {}", late.amplitude());
            Verdict::Stable
        };
        assert_eq!(criterion.decide(NOMINAL).verdict, expected, "{start:?}");
        seen[usize::from(expected == Verdict::Unstable)] += 1;
    }
    assert!(seen[0] > 2 && seen[1] > 2, "{seen:?}");
}
