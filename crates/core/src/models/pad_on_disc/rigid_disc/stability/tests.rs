use super::*;
use crate::friction::law::LawKind;
use crate::friction::measured_curve::{MeasuredCurve, SharedCurve};
use crate::model::verdict::Verdict;
use crate::models::pad_on_disc::parameters::SCALARS;
use crate::numerics::eigenvalues::eigenvalues;
use nalgebra::Normed;
use proptest::prelude::*;

/// The scaled equations of motion (2.5) for a rigid disc, sin(phi) = 0, cos(phi) = 1, sliding forward; written
/// from the paper, independently of the linearisation.
fn right_hand_side(brake: &PadOnDisc, state: &[f64; 6]) -> [f64; 6] {
    let [x, vx, y, vy, phi, vphi] = *state;
    let p = brake.parameters();
    let (k, c) = (&p.stiffness, &p.damping);
    let (eta0, root) = (brake.scales().eta0, brake.scales().eta0.sqrt());
    let contact = k.contact_normal * (-y).max(0.0);
    let friction = brake.friction_law().coefficient(brake.disc_speed() - vx) * contact;
    let spring = k.contact_tangential_2 * (x - friction / k.contact_tangential_1);
    let ax = -(k.calliper_tangential * x + c.tangential * root * vx + spring) / (p.pad.mass * eta0);
    let ay =
        -(k.calliper_normal * (p.operating_point.preload + y) + c.normal * root * vy - contact) / (p.pad.mass * eta0);
    let moment = spring * p.disc.thickness * p.pad.moment_arm / 2.0;
    let aphi = -(k.calliper_angular * phi + c.angular * root * vphi + moment) / (p.pad.moment_of_inertia * eta0);
    [vx, ax, vy, ay, vphi, aphi]
}

fn brakes() -> Vec<PadOnDisc> {
    let points = [(16.0, 0.1, 1.0), (35.0, 0.1, 1.0), (4.0, 0.3, 2.0), (12.0, 0.05, 0.6)];
    let brake = |(speed, preload, exponent)| {
        PadOnDisc::preset_with(&[
            ("operating_point.rotating_speed", speed),
            ("operating_point.preload", preload),
            ("friction.stribeck_exponent", exponent),
        ])
    };
    points.map(brake).to_vec()
}

#[test]
fn nothing_moves_at_the_equilibrium() {
    for brake in brakes() {
        let e = brake.sliding_equilibrium();
        let rate = right_hand_side(&brake, &[e.tangential, 0.0, e.normal, 0.0, e.angle, 0.0]);
        for component in rate {
            assert!(component.abs() < 1e-15, "{rate:?}");
        }
    }
}

#[test]
fn the_jacobian_is_the_derivative_of_the_equations_of_motion() {
    for brake in brakes() {
        let e = brake.sliding_equilibrium();
        let at = [e.tangential, 0.0, e.normal, 0.0, e.angle, 0.0];
        let jacobian = brake.jacobian();
        for column in 0..6 {
            let step = 1e-6;
            let [mut ahead, mut behind] = [at, at];
            ahead[column] += step;
            behind[column] -= step;
            let [ahead, behind] = [right_hand_side(&brake, &ahead), right_hand_side(&brake, &behind)];
            for row in 0..6 {
                let difference = (ahead[row] - behind[row]) / (2.0 * step);
                let entry = jacobian[(row, column)];
                assert!(
                    (difference - entry).abs() < 2e-7 * (1.0 + entry.abs()),
                    "({row}, {column}): {difference} {entry}"
                );
            }
        }
    }
}

#[test]
fn eigenvalues_at_the_critical_speed_are_the_printed_ones() {
    // The paper, section 3.3: +-2.0904i; -0.0478 +- 2.3934i; -0.02 +- 1.0012i.
    let critical = PadOnDisc::preset_with(&[]).unstable_speeds()[0].to;
    let at_critical = PadOnDisc::preset_with(&[("operating_point.rotating_speed", critical)]);
    let [x, _, y, _, phi, _] = at_critical.sliding_eigenvalues();
    let as_printed = |value: f64, expected: f64| (value - expected).abs() <= 0.5e-4;
    assert!(x.re.abs() < 1e-12);
    assert!(as_printed(x.im, 2.0904), "{x}");
    assert!(as_printed(y.re, -0.0478), "{y}");
    assert!(as_printed(phi.re, -0.02), "{phi}");
    // Two misses by one in the last printed digit, because the preset gives its stiffnesses to four digits:
    // 2.3935 for 2.3934 and 1.0011 for 1.0012. The values are pinned as regression values.
    assert!((y.im - 2.393_500_6).abs() < 1e-7, "{y}");
    assert!((phi.im - 1.001_121_0).abs() < 1e-7, "{phi}");
}

#[test]
fn critical_speed_and_threshold_of_the_preset() {
    // The paper prints 15.56; physics notes give 15.560 and, from Table 3, f_s,crit = 0.402 at 16 rad/s.
    assert!((PadOnDisc::preset_with(&[]).unstable_speeds()[0].to - 15.560).abs() < 5e-4);
    assert!((PadOnDisc::preset_with(&[]).stability_boundary().critical_second(0.1) - 0.4020).abs() < 5e-5);
}

#[test]
fn samples_outside_physics_are_stable() {
    let boundary = PadOnDisc::preset_with(&[]).stability_boundary();
    assert_eq!(boundary.verdict(10.0, 5.0), Verdict::Unstable);
    for (preload, friction) in [(-10.0, -5.0), (-10.0, 5.0), (10.0, -5.0), (0.0, 5.0), (10.0, 0.25), (f64::NAN, 5.0)] {
        assert_eq!(boundary.verdict(preload, friction), Verdict::Stable, "{preload} {friction}");
    }
}

#[test]
fn without_damping_every_falling_curve_is_unstable() {
    let undamped = PadOnDisc::preset_with(&[("damping.tangential", 0.0)]);
    assert_eq!(undamped.unstable_speeds(), [SpeedRange { from: 0.0, to: f64::INFINITY }]);
    assert_eq!(undamped.stability_boundary().verdict(1e-9, 0.2500001), Verdict::Unstable);
    assert_eq!(undamped.stability_boundary().verdict(-1e-9, 0.2), Verdict::Stable);
    let far = PadOnDisc::preset_with(&[("damping.tangential", 0.0), ("operating_point.rotating_speed", 9e4)]);
    assert_eq!(far.stability_boundary().verdict(1.0, 0.5), Verdict::Stable, "the weakening underflows");
}

#[test]
fn an_overdamped_oscillator_has_two_real_eigenvalues() {
    let [fast, slow] = Oscillator { damping: -1e6, stiffness: 1.0 }.eigenvalues();
    assert!((fast.re - 1e6).abs() < 1e-3 && (slow.re - 1e-6).abs() < 1e-16, "{fast} {slow}");
    let [slow, fast] = Oscillator { damping: 1e6, stiffness: 1.0 }.eigenvalues();
    assert!((fast.re + 1e6).abs() < 1e-3 && (slow.re + 1e-6).abs() < 1e-16, "{fast} {slow}");
}

/// Parameter sets up to a factor 5 around the preset, friction of every exponent.
fn random_brakes() -> impl Strategy<Value = PadOnDisc> {
    (prop::collection::vec(-1.6..1.6, SCALARS.len()), 0.3..4.0, 0.0..0.6, 0.2..0.5).prop_filter_map(
        "valid parameters",
        |(logs, exponent, falling, kinetic)| {
            let mut parameters = Parameters::sui_ding_2018();
            for (scalar, log) in SCALARS.iter().zip(&logs) {
                if matches!(scalar.section(), "pad" | "stiffness" | "damping" | "operating_point") {
                    let factor = libm::exp(*log);
                    let _ = parameters.set(scalar.key, scalar.value(&parameters) * factor);
                }
            }
            parameters.pad.inner_radius = 0.09;
            parameters.friction.kinetic_coefficient = kinetic;
            parameters.friction.static_coefficient = kinetic + falling;
            parameters.friction.stribeck_exponent = exponent;
            PadOnDisc::new(parameters).ok()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn closed_form_eigenvalues_are_those_of_the_jacobian(brake in random_brakes()) {
        let mut closed = brake.sliding_eigenvalues().to_vec();
        closed.sort_by(|a, b| b.re.total_cmp(&a.re).then(b.im.total_cmp(&a.im)));
        let general = eigenvalues(&brake.jacobian()).unwrap();
        let largest = closed.iter().map(Normed::norm).fold(0.0, f64::max);
        for value in &closed {
            let nearest = general.iter().map(|other| (other - value).norm()).fold(f64::INFINITY, f64::min);
            // Two nearly equal roots of an oscillator split like the square root of the rounding error.
            prop_assert!(nearest < 1e-9 * largest.max(1.0) , "{value} not in {general:?}");
        }
    }

    #[test]
    fn the_verdict_is_the_sign_of_the_largest_real_part(brake in random_brakes()) {
        let p = brake.parameters();
        let general = eigenvalues(&brake.jacobian()).unwrap();
        let largest = general[0].re;
        prop_assume!(largest.abs() > 1e-11 * general.iter().map(Normed::norm).fold(0.0, f64::max));
        let verdict = brake.stability_boundary().verdict(p.operating_point.preload, p.friction.static_coefficient);
        prop_assert_eq!(verdict == Verdict::Unstable, largest > 0.0);
        prop_assert_eq!(brake.growth_rate() > 0.0, largest > 0.0);
    }

    #[test]
    fn the_growth_rate_changes_sign_at_the_ends_of_the_unstable_speeds(brake in random_brakes()) {
        let growth = |speed: f64| {
            let mut parameters = brake.parameters().clone();
            parameters.operating_point.rotating_speed = speed;
            PadOnDisc::new(parameters).map(|brake| brake.growth_rate())
        };
        match *brake.unstable_speeds() {
            [] => {
                for speed in [0.01, 0.1, 1.0, 3.0, 10.0, 30.0, 100.0] {
                    prop_assert!(growth(speed).unwrap() <= 0.0, "{}", speed);
                }
            }
            [SpeedRange { from, to }] => {
                prop_assume!(to > 1e-3 && to < 9e4);
                prop_assert!(growth(to * (1.0 + 1e-9)).unwrap() < 0.0);
                prop_assert!(growth((to * (1.0 - 1e-9)).max(0.5 * (from + to))).unwrap() > 0.0);
                if from > 1e-3 {
                    prop_assert!(growth(from * (1.0 - 1e-9)).unwrap() < 0.0);
                    prop_assert!(growth(from * (1.0 + 1e-9)).unwrap() > 0.0);
                }
            }
            _ => prop_assert!(false, "several ranges"),
        }
    }
}

/// A brake with another friction law than the preset's.
fn with_law(change: impl Fn(&mut crate::models::pad_on_disc::parameters::Friction), rotating_speed: f64) -> PadOnDisc {
    let mut parameters = Parameters::sui_ding_2018();
    change(&mut parameters.friction);
    parameters.operating_point.rotating_speed = rotating_speed;
    PadOnDisc::new(parameters).unwrap()
}

/// A curve that falls, rises and falls again.
fn wavy() -> SharedCurve {
    let speeds = [0.0, 0.3, 0.8, 1.3, 2.0, 2.6, 4.0];
    let coefficients = [0.45, 0.38, 0.28, 0.3, 0.36, 0.3, 0.28];
    let deviations = [0.02, 0.02, 0.01, 0.01, 0.02, 0.03, 0.01];
    SharedCurve::new(MeasuredCurve::new(&speeds, &coefficients, Some(&deviations)).unwrap())
}

#[test]
fn every_law_is_unstable_exactly_between_its_critical_speeds() {
    type Change = fn(&mut crate::models::pad_on_disc::parameters::Friction);
    let laws: [(Change, usize); 7] = [
        (|friction| friction.viscous = 0.002, 1),
        (|friction| (friction.stribeck_exponent, friction.viscous) = (2.5, 0.004), 1),
        (|friction| (friction.stribeck_exponent, friction.viscous) = (0.5, 0.004), 1),
        (|friction| friction.law = LawKind::Rational, 1),
        (|friction| (friction.law, friction.viscous) = (LawKind::Rational, 0.003), 1),
        (|friction| friction.use_table(wavy()), 2),
        (
            |friction| {
                friction.use_table(wavy());
                (friction.static_coefficient, friction.band) = (0.5, -0.7);
            },
            2,
        ),
    ];
    for (number, (change, ranges)) in laws.into_iter().enumerate() {
        let unstable = with_law(change, 10.0).unstable_speeds();
        assert_eq!(unstable.len(), ranges, "law {number}: {unstable:?}");
        let mut seen = [0; 2];
        for i in 1..3000 {
            let speed = 0.02 * f64::from(i);
            let brake = with_law(change, speed);
            let expected = unstable.iter().any(|range| range.from < speed && speed < range.to);
            let near = unstable.iter().any(|range| (range.from - speed).abs().min((range.to - speed).abs()) < 1e-9);
            assert!(near || (brake.growth_rate() > 0.0) == expected, "law {number} at {speed}");
            let friction = &brake.parameters().friction;
            let verdict = brake.stability_boundary().verdict(0.1, friction.static_coefficient);
            assert!(near || (verdict == Verdict::Unstable) == expected, "law {number} at {speed}");
            seen[usize::from(expected)] += 1;
        }
        assert!(seen.into_iter().all(|count| count > 50), "law {number}: {seen:?}");
        for end in unstable.iter().flat_map(|range| [range.from, range.to]).filter(|end| *end > 1e-3) {
            let sides = [1.0 - 1e-9, 1.0 + 1e-9].map(|factor| with_law(change, end * factor).growth_rate() > 0.0);
            assert_ne!(sides[0], sides[1], "law {number} at {end}");
        }
    }
}

#[test]
fn the_boundary_is_that_of_the_growth_rate_for_any_preload_and_friction() {
    let mut sides = [false; 2];
    for band in [-1.5, 0.0, 1.5] {
        for speed in [1.0, 4.0, 7.0, 12.0, 17.0, 25.0, 40.0] {
            let at = |preload: f64, static_friction: f64| {
                let mut parameters = Parameters::sui_ding_2018();
                parameters.damping.tangential = 60.0;
                parameters.friction.use_table(wavy());
                parameters.friction.band = band;
                parameters.friction.static_coefficient = static_friction;
                parameters.operating_point.preload = preload;
                parameters.operating_point.rotating_speed = speed;
                PadOnDisc::new(parameters).unwrap()
            };
            let boundary = at(0.1, 0.4).stability_boundary();
            for i in 1..40 {
                for preload in [0.02, 0.1, 0.3] {
                    let static_friction = 0.03 + 0.02 * f64::from(i);
                    let grows = at(preload, static_friction).growth_rate() > 0.0;
                    let verdict = boundary.verdict(preload, static_friction);
                    if static_friction < boundary.least_second {
                        assert_eq!(verdict, Verdict::Stable, "there is no friction");
                        continue;
                    }
                    assert_eq!(verdict == Verdict::Unstable, grows, "{band} {speed} {preload} {static_friction}");
                    assert_eq!(preload > boundary.critical_first(static_friction), grows);
                    let (above, below) = boundary.unstable_second(preload);
                    assert_eq!(above < static_friction && static_friction < below, grows);
                    if boundary.is_unstable_above() {
                        assert_eq!(above, boundary.critical_second(preload));
                        assert_eq!(below, f64::INFINITY);
                    }
                    sides[usize::from(below.is_finite())] |= grows;
                }
            }
        }
    }
    assert_eq!(sides, [true; 2], "instability above and below a static friction coefficient");
}

#[test]
fn beyond_the_steepest_speed_faster_is_never_less_stable() {
    for (exponent, is_at_rest) in [(0.5, true), (1.0, true), (2.0, false), (3.5, false)] {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.set("friction.stribeck_exponent", exponent).unwrap();
        let at = |speed: f64| {
            let mut parameters = parameters.clone();
            parameters.set("operating_point.rotating_speed", speed).unwrap();
            PadOnDisc::new(parameters).unwrap()
        };
        let steepest = at(10.0).steepest_speed().unwrap();
        assert_eq!(steepest == 0.0, is_at_rest, "{exponent}: {steepest}");
        let critical = |speed: f64| at(speed).stability_boundary().critical_product;
        let mut before = critical(steepest.max(1e-3));
        for i in 1..100 {
            let next = critical(steepest.max(1e-3) * (1.0 + 0.02 * f64::from(i)));
            assert!(next > before, "{exponent}");
            before = next;
        }
        assert!(steepest == 0.0 || critical(0.9 * steepest) > critical(steepest), "{exponent}");
    }
}

/// The largest real part of all six eigenvalues of the Jacobian; far above the critical speed that of the rotation.
#[test]
fn the_least_stable_eigenvalue_is_that_of_all_motions() {
    let of_rotation = brakes().into_iter().filter(|brake| {
        let expected =
            eigenvalues(&brake.jacobian()).unwrap().into_iter().map(|value| value.re).fold(f64::MIN, f64::max);
        let found = brake.least_stable_eigenvalue();
        assert!((found.re - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{found} {expected}");
        found != brake.tangential_eigenvalue()
    });
    assert!(of_rotation.count() > 0);
}
