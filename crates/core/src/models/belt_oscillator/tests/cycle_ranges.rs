//! The ranges of belt speed with limit cycles, against motions that are integrated one by one.
//!
//! The ends were found outside the program, in Python: by a classical Runge-Kutta method with steps of 0.01 and of 0.005,
//! on which they agree to 2e-7, and located places where the mass comes to the belt's speed. Those of stick-slip are where
//! the motion after a release just comes to that speed; those of cycles without sticking where the largest or the
//! smallest change of amplitude over a swing passes 0.

use super::*;
use crate::models::pad_on_disc::rigid_disc::cycle_ranges::CycleRanges;
use crate::models::pad_on_disc::rigid_disc::stability::SpeedRange;

/// Largest error of the ends, over their speed.
const CLOSE: f64 = 1e-6;

/// The rows of a curve that falls twice: up to 0.1 m/s and from 0.4 to 0.8 m/s.
const SPEEDS: [f64; 7] = [0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.2];
const COEFFICIENTS: [f64; 7] = [0.7, 0.7, 0.4, 0.4, 0.8, 0.2, 0.2];

/// m = k = N = 1.
fn unit(damping: f64, friction: Friction) -> Oscillator {
    Oscillator { mass: 1.0, stiffness: 1.0, normal_force: 1.0, belt_speed: 1.0, damping, friction }
}

fn on_curve(damping: f64, speeds: &[f64], coefficients: &[f64]) -> Oscillator {
    let curve = SharedCurve::new(MeasuredCurve::new(speeds, coefficients, None).unwrap());
    let (law, static_coefficient) = (LawKind::Table(curve), coefficients[0]);
    unit(damping, Friction { law, static_coefficient, kinetic_coefficient: 0.0, ..oscillator().friction })
}

fn ranges(oscillator: &Oscillator) -> CycleRanges {
    PadOnDisc::new(oscillator.as_pad()).unwrap().cycle_ranges()
}

fn assert_ranges(found: &[SpeedRange], expected: &[[f64; 2]]) {
    let is_close = |found: f64, expected: f64| (found - expected).abs() <= CLOSE * expected;
    let all =
        found.iter().zip(expected).all(|(found, [from, to])| is_close(found.from, *from) && is_close(found.to, *to));
    assert!(found.len() == expected.len() && all, "{found:?}, not {expected:?}");
}

/// How often a motion sticks from here on, and peak to peak of x in its last 15 s: by a classical Runge-Kutta method, each
/// stick ending in the release. It never overtakes the belt.
fn followed(mu: impl Fn(f64) -> f64, [damping, speed]: [f64; 2], start: [f64; 2], time: f64) -> (u32, f64) {
    const STEP: f64 = 0.01;
    let rate = |[x, u]: [f64; 2]| [u, mu((speed - u).abs()) - x - damping * u];
    let along = |[x, u]: [f64; 2], [by_x, by_u]: [f64; 2], h: f64| [x + h * by_x, u + h * by_u];
    let release = [mu(0.0) - damping * speed, speed];
    let (mut state, mut sticks) = (start, 0);
    let [mut least, mut most] = [f64::INFINITY, f64::NEG_INFINITY];
    let steps = (time / STEP) as u32;
    for step in 0..steps {
        let first = rate(state);
        let second = rate(along(state, first, 0.5 * STEP));
        let third = rate(along(state, second, 0.5 * STEP));
        let fourth = rate(along(state, third, STEP));
        let mean = [0, 1].map(|i| (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i]) / 6.0);
        let next = along(state, mean, STEP);
        let has_stuck = next[1] >= speed && state[1] < speed;
        if has_stuck {
            assert!(next[0] < release[0] && next[0] > -mu(0.0) - damping * speed, "{next:?}");
            sticks += 1;
        }
        state = if has_stuck { release } else { next };
        if f64::from(steps - step) * STEP < 15.0 {
            (least, most) = (least.min(state[0]), most.max(state[0]));
        }
    }
    (sticks, most - least)
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_curve_with_two_falling_parts_has_two_ranges_of_stick_slip_and_cycles_without_sticking_inside_one() {
    let oscillator = on_curve(0.4, &SPEEDS, &COEFFICIENTS);
    let found = ranges(&oscillator);
    let (first, second) = ([0.034_805_549_4, 0.140_711_521_6], [0.404_344_808, 0.599_373_6]);
    let sliding = [0.529_883_46, 1.028_504_98];
    assert_ranges(&found.stick_slip, &[first, second]);
    // Where sliding loses its stability, at -mu' = 0.4, small swings are limited from both sides: 0.4544806 by an integration of
    // adaptive order 8. About 0.05 and 0.1 m/s the curve is its own mirror image, and so are these two ranges.
    let [one, other] = [[0.050_561_869_5, 0.050_563_564_4], [0.099_436_435_6, 0.099_438_130_5]];
    assert_ranges(&found.without_sticking, &[one, other, [0.418_647_059_9, 0.454_480_6], sliding]);
    assert!(found.unresolved.is_empty(), "{found:?}");
    assert_eq!(found.end_of_stick_slip(), Some(found.stick_slip[1].to));
    assert_eq!(found.end_of_cycles(), Some(found.without_sticking[3].to));

    let curve = MeasuredCurve::new(&SPEEDS, &COEFFICIENTS, None).unwrap();
    let mu = |speed: f64| curve.coefficient(speed);
    for (end, is_lower) in [(first[0], true), (first[1], false), (second[0], true), (second[1], false)] {
        for (speed, is_inside) in [(0.995 * end, !is_lower), (1.005 * end, is_lower)] {
            let (sticks, _) = followed(mu, [0.4, speed], [0.7 - 0.4 * speed, speed], 60.0);
            assert_eq!(sticks > 3, is_inside, "{speed}: {sticks}");
            assert!(is_inside || sticks == 0, "{speed}: {sticks}");
        }
    }
    // From near steady sliding, which is unstable about the lower end, and from a release about the upper one.
    for (speed, slides) in [(0.99 * sliding[0], false), (1.01 * sliding[0], true)] {
        let (sticks, width) = followed(mu, [0.4, speed], [mu(speed) + 0.02 * speed, 0.0], 400.0);
        assert!((sticks == 0) == slides && width > 1.0, "{speed}: {sticks} {width}");
    }
    for (speed, slides) in [(0.99 * sliding[1], true), (1.01 * sliding[1], false)] {
        let (sticks, width) = followed(mu, [0.4, speed], [0.7 - 0.4 * speed, speed], 400.0);
        assert!(sticks == 0 && if slides { width > 1.0 } else { width < 1e-3 }, "{speed}: {sticks} {width}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn with_an_exponent_above_one_stick_slip_begins_above_a_low_speed() {
    let friction = Friction { stribeck_exponent: 2.0, ..oscillator().friction };
    let found = ranges(&unit(0.3, friction));
    // Steady sliding is unstable from 0.07679004083 to 0.76113849171 m/s, where 4 V exp(-4 V^2) > 0.3.
    let (lower, [from, to], upper) = (0.076_790_040_83, [0.078_249_493_4, 0.863_577_844_5], 0.877_128_175_3);
    assert_ranges(&found.stick_slip, &[[from, to]]);
    assert_ranges(&found.without_sticking, &[[lower, from], [to, upper]]);
    assert!(found.unresolved.is_empty(), "{found:?}");

    let mu = |speed: f64| 0.5 + 0.5 * libm::exp(-4.0 * speed * speed);
    for (speed, is_inside) in [(0.995 * from, false), (1.005 * from, true), (0.995 * to, true), (1.005 * to, false)] {
        let (sticks, _) = followed(mu, [0.3, speed], [1.0 - 0.3 * speed, speed], 60.0);
        assert_eq!(sticks > 3, is_inside, "{speed}: {sticks}");
    }
    // Small swings shrink below the lower end and grow above it, without sticking.
    for (speed, grows) in [(0.985 * lower, false), (1.01 * lower, true)] {
        let displacement = 0.02 * speed;
        let (sticks, width) = followed(mu, [0.3, speed], [mu(speed) + displacement, 0.0], 400.0);
        assert!(sticks == 0 && (width > 2.0 * displacement) == grows, "{speed}: {sticks} {width}");
    }
    for (speed, slides) in [(0.995 * upper, true), (1.005 * upper, false)] {
        let (sticks, width) = followed(mu, [0.3, speed], [1.0 - 0.3 * speed, speed], 400.0);
        assert!(sticks == 0 && if slides { width > 1.0 } else { width < 1e-3 }, "{speed}: {sticks} {width}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_curve_that_rises_from_rest_sticks_and_slips_between_two_speeds() {
    // The curve of the test of its cycles above; steady sliding is unstable from 0.306317 m/s on.
    let found = ranges(&on_curve(0.02, &[0.0, 0.1, 0.3, 1.0, 2.0, 5.0], &[0.1, 0.5, 0.6, 0.3, 0.2, 0.3]));
    let between = |found: &SpeedRange, [from, to]: [f64; 2]| {
        assert!((found.from / from - 1.0).abs() < 1e-5 && (found.to / to - 1.0).abs() < 1e-5, "{found:?} {from} {to}");
    };
    assert_eq!((found.stick_slip.len(), found.without_sticking.len()), (1, 3), "{found:?}");
    between(&found.stick_slip[0], [0.443_715_5, 2.778_244_9]);
    between(&found.without_sticking[0], [0.306_317_3, 0.443_715_5]);
    // Just below the upper end of unstable sliding, at 1.92185632 m/s; by an integration of adaptive order 8 a small swing is limited
    // at 1.9216, and none is at 1.9206 m/s.
    let SpeedRange { from, to } = found.without_sticking[1];
    assert!((1.9206..1.9216).contains(&from) && (to - 1.921_856_32).abs() < 1e-8, "{found:?}");
    between(&found.without_sticking[2], [2.778_244_9, 3.886_93]);
    assert!(found.unresolved.is_empty(), "{found:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn up_to_exponent_one_stick_slip_has_one_range_from_rest() {
    for exponent in [0.5, 1.0] {
        let oscillator = unit(0.1, Friction { stribeck_exponent: exponent, ..oscillator().friction });
        let brake = PadOnDisc::new(oscillator.as_pad()).unwrap();
        let (found, end) = (brake.cycle_ranges(), brake.saddle_node_speed().unwrap());
        assert_eq!((found.stick_slip.len(), found.stick_slip[0].from), (1, 0.0), "{exponent} {found:?}");
        assert!((found.stick_slip[0].to / end - 1.0).abs() < 1e-9, "{exponent} {found:?} {end}");
        assert_eq!((found.without_sticking.len(), found.unresolved.len()), (0, 0), "{exponent} {found:?}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn without_a_fall_there_is_no_range_and_without_damping_it_has_no_end() {
    let flat = Friction { kinetic_coefficient: 1.0, ..oscillator().friction };
    assert_eq!(ranges(&unit(0.1, flat)), CycleRanges::default());
    let undamped = ranges(&unit(0.0, oscillator().friction));
    assert_eq!(undamped.stick_slip, [SpeedRange { from: 0.0, to: f64::INFINITY }]);
    assert_eq!((undamped.end_of_stick_slip(), undamped.end_of_cycles()), (None, None));
}

/// Steady sliding lies 6 m from the unloaded spring, and the narrowest swings about it are a millionth of the whole.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn narrow_swings_about_a_distant_equilibrium_are_resolved() {
    let curve = on_curve(0.1, &[0.0, 0.5, 1.0, 1.5, 2.0, 3.0], &[0.6, 0.4, 0.5, 0.55, 0.3, 0.3]);
    let found = ranges(&Oscillator { normal_force: 10.0, ..curve });
    assert_eq!((found.stick_slip[0].from, found.unresolved), (0.0, Vec::new()));
}
