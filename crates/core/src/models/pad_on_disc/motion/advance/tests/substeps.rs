//! What each part of a step does alone.

use super::*;
use crate::models::pad_on_disc::motion::integrator::Breakdown;
use crate::models::pad_on_disc::motion::substep::check;

/// The substep that begins in a state, by trial steps one after the other.
fn substep(toy: &Toy, from: &Motion<Pad>, h: f64, just_released: bool) -> Result<Substep<Pad>, Breakdown> {
    let mut attempt = Attempt::new(from.contact, h, just_released);
    loop {
        let trial = toy.step(&from.state, from.contact, attempt.length);
        if let Some(part) = attempt.judge(toy, from, &trial)? {
            return Ok(part);
        }
    }
}

fn slide(toy: &Toy, from: &Motion<Pad>, h: f64, just_released: bool) -> Result<Substep<Pad>, Breakdown> {
    substep(toy, from, h, just_released)
}

fn stick(toy: &Toy, state: &Pad, h: f64) -> Result<Substep<Pad>, Breakdown> {
    substep(toy, &Motion { state: *state, contact: ContactState::Stick }, h, false)
}

#[track_caller]
fn assert_substep(part: &Substep<Pad>, ending: Ending, contact: ContactState, time: f64, state: Pad) {
    assert_eq!((part.ending, part.end.contact), (ending, contact), "{part:?}");
    let is_there = close(part.time, time) && close(part.end.state.x, state.x) && close(part.end.state.u, state.u);
    assert!(is_there, "{part:?}, not {time} {state:?}");
}

#[test]
fn a_stuck_pad_moves_with_the_disc_while_friction_holds_it() {
    let toy = Toy::new(Law::Spring(0.0), HOLDS_TWO);
    let part = stick(&toy, &pad(1.0, V), 0.5).unwrap();
    assert_substep(&part, Ending::Completed, ContactState::Stick, 0.5, pad(1.5, V));
}

#[test]
fn a_stuck_pad_slips_when_friction_holds_it_no_longer() {
    let toy = Toy::new(Law::Spring(0.0), HOLDS_TWO);
    let part = stick(&toy, &pad(1.7, V), 0.5).unwrap();
    assert_substep(&part, Ending::Released, ContactState::Slip, 0.3, pad(2.0, V));
    let part = stick(&toy, &pad(2.0, V), 0.5).unwrap();
    assert_substep(&part, Ending::Released, ContactState::Slip, 0.0, pad(2.0, V));
}

#[test]
fn a_stuck_pad_runs_ahead_when_friction_keeps_it_back_no_longer() {
    let toy = Toy::new(Law::Spring(0.0), |x| (2.0 + x, 2.0 - x));
    let part = stick(&toy, &pad(1.7, V), 0.5).unwrap();
    assert_substep(&part, Ending::Released, ContactState::Overtaking, 0.3, pad(2.0, V));
}

#[test]
fn a_pad_that_is_carried_too_far_has_broken_down() {
    assert_eq!(stick(&Toy::new(Law::Spring(0.0), HOLDS), &pad(999.0, V), 2.0).err(), Some(Breakdown));
    assert_eq!(stick(&Toy::new(Law::Spring(0.0), HOLDS), &pad(-1001.0, V), 0.5).err(), Some(Breakdown));
    assert!(stick(&Toy::new(Law::Spring(0.0), HOLDS), &pad(999.0, V), 0.5).is_ok());
}

#[test]
fn a_sliding_pad_that_meets_nothing_slides_on() {
    let toy = Toy::new(Law::Constant(0.5, 0.0), HOLDS);
    let part = slide(&toy, &slipping(0.0, 0.0), 1.0, false).unwrap();
    assert_substep(&part, Ending::Completed, ContactState::Slip, 1.0, pad(0.25, 0.5));
    assert!(!part.grazes);
    assert_eq!(part.acceleration, (0.5, 0.5));
}

#[test]
fn a_sliding_pad_sticks_where_it_meets_the_disc_and_friction_holds_it() {
    let toy = Toy::new(Law::Constant(2.0, 0.0), HOLDS_TWO);
    let part = slide(&toy, &slipping(1.0, 0.0), 1.0, false).unwrap();
    assert_substep(&part, Ending::Stuck, ContactState::Stick, 0.5, pad(1.25, V));
    assert_eq!(part.end.state.u, V, "exactly");
    assert!(!part.grazes);
}

#[test]
fn a_pad_that_runs_ahead_is_caught_by_the_disc_too() {
    let toy = Toy::new(Law::Constant(0.0, -2.0), HOLDS);
    let ahead = Motion { state: pad(0.0, 2.0), contact: ContactState::Overtaking };
    let part = slide(&toy, &ahead, 1.0, false).unwrap();
    assert_substep(&part, Ending::Stuck, ContactState::Stick, 0.5, pad(0.75, V));
    let part = slide(&toy, &ahead, 0.25, false).unwrap();
    assert_substep(&part, Ending::Completed, ContactState::Overtaking, 0.25, pad(0.4375, 1.5));
}

#[test]
fn a_pad_that_friction_cannot_hold_passes_the_disc_where_its_spring_pulls_it() {
    let toy = Toy::new(Law::Constant(2.0, 2.0), HOLDS_TWO);
    let part = slide(&toy, &slipping(-5.0, 0.0), 1.0, false).unwrap();
    assert_substep(&part, Ending::Overtaken, ContactState::Overtaking, 0.5, pad(-4.75, V));
    let part = slide(&toy, &slipping(5.0, 0.0), 1.0, false).unwrap();
    assert_substep(&part, Ending::Overtaken, ContactState::Slip, 0.5, pad(5.25, V));
}

#[test]
fn friction_that_just_suffices_holds_the_pad() {
    for reserve in [(|_| (0.0, 1.0)) as Reserves, |_| (1.0, 0.0)] {
        let part = slide(&Toy::new(Law::Constant(2.0, 2.0), reserve), &slipping(0.0, 0.0), 1.0, false).unwrap();
        assert_eq!(part.ending, Ending::Stuck);
    }
}

/// A pad on a spring whose speed has a maximum `fastest` in the middle of a step of length 1.
fn swings_by(fastest: f64) -> Substep<Pad> {
    let (sin, cos) = libm::sincos(0.5);
    let toy = Toy::new(Law::Spring(0.0), HOLDS_TWO);
    slide(&toy, &slipping(-fastest * sin, fastest * cos), 1.0, false).unwrap()
}

#[test]
fn a_touch_inside_a_step_is_seen() {
    for fastest in [1.1, 1.01, 1.000_001] {
        let part = swings_by(fastest);
        let before_middle = libm::acos(1.0 / fastest);
        assert_eq!((part.ending, part.end.state.u), (Ending::Stuck, V));
        // At the first of two moments, where the speed is nearly constant.
        let tolerance = 1e-12 / before_middle;
        assert!((part.time - (0.5 - before_middle)).abs() < tolerance, "{fastest}: {}", part.time);
        assert!((part.end.state.x + fastest * libm::sin(before_middle)).abs() < 2.0 * tolerance);
    }
}

#[test]
fn a_touch_of_a_pad_that_is_ahead_is_seen_too() {
    // Its speed has a minimum in the middle of the step.
    for (slowest, touches, grazes) in [(0.99, true, false), (1.000_01, false, true), (1.001, false, false)] {
        let state = pad(-slowest * libm::sinh(0.5), slowest * libm::cosh(0.5));
        let ahead = Motion { state, contact: ContactState::Overtaking };
        let part = slide(&Toy::new(Law::Repelled(0.0), HOLDS_TWO), &ahead, 1.0, false).unwrap();
        assert_eq!((part.ending == Ending::Stuck, part.grazes), (touches, grazes), "{slowest}");
        let time = if touches { 0.5 - libm::acosh(1.0 / slowest) } else { 1.0 };
        assert!((part.time - time).abs() < 1e-11, "{slowest}: {}", part.time);
    }
}

#[test]
fn what_passes_by_nearer_than_a_ten_thousandth_of_the_disc_speed_grazes() {
    for (fastest, grazes) in [(0.9, false), (1.0 - 1.1e-4, false), (1.0 - 0.9e-4, true), (1.0 - 1e-9, true)] {
        let part = swings_by(fastest);
        assert_eq!((part.ending, part.grazes), (Ending::Completed, grazes), "{fastest}");
    }
}

#[test]
fn what_meets_the_disc_slowly_grazes() {
    // The acceleration when they meet is sqrt(fastest^2 - 1), of a spring with the frequency 1.
    for (rate, grazes) in [(0.029, true), (0.031, false)] {
        let part = swings_by(f64::sqrt(1.0 + rate * rate));
        assert_eq!((part.ending, part.grazes), (Ending::Stuck, grazes), "{rate}");
    }
}

#[test]
fn what_friction_barely_holds_grazes_where_the_limits_say() {
    let reserves: [(Reserves, bool); 4] =
        [(|_| (0.03, 1.97), false), (|_| (0.01, 1.99), true), (|_| (1.99, 0.01), true), (|_| (2.01, -0.01), true)];
    for (number, (reserve, grazes)) in reserves.into_iter().enumerate() {
        let mut toy = Toy::new(Law::Constant(2.0, 0.0), reserve);
        assert!(!slide(&toy, &slipping(1.0, 0.0), 1.0, false).unwrap().grazes, "{number}");
        toy.limits.grazing_reserve = 0.02;
        assert_eq!(slide(&toy, &slipping(1.0, 0.0), 1.0, false).unwrap().grazes, grazes, "{number}");
    }
}

#[test]
fn a_step_that_ends_next_to_the_disc_speed_grazes_or_is_about_to_meet_it() {
    let end = |from: f64, to: f64, exponent: f64| {
        let law = LimitedLaw::new(Shape::of_stribeck(exponent), exponent);
        let limits = FrictionSteps::new(V, 0.0, law, (0.0, 0.0), 1.0);
        let toy = Toy { limits, ..Toy::new(Law::Constant(to - from, 0.0), HOLDS) };
        let part = slide(&toy, &slipping(0.0, from), 1.0, false).unwrap();
        assert_eq!(part.ending, Ending::Completed);
        (part.grazes, part.is_caught)
    };
    for exponent in [1.0, 1.5, 2.0] {
        assert_eq!(end(0.995, 1.0 - 0.9e-4, exponent), (true, false));
        assert_eq!(end(0.995, 1.0 - 1.1e-4, exponent), (false, false));
        assert_eq!(end(1.0 - 0.1e-4, 1.0 - 0.9e-4, exponent), (false, false));
        // On a fast approach; of interest where steps are not short near rest in any case.
        assert_eq!(end(0.5, 1.0 - 0.9e-4, exponent), (false, exponent == 1.0));
    }
}

#[test]
fn a_pad_that_does_not_leave_the_disc_after_its_release_sticks_again() {
    let toy = Toy::new(Law::Constant(2.0, 0.0), HOLDS);
    let part = slide(&toy, &slipping(0.0, V), 0.5, true).unwrap();
    assert_substep(&part, Ending::Stuck, ContactState::Stick, 0.5, pad(0.75, V));
    let part = slide(&toy, &slipping(0.0, V), 0.5, false).unwrap();
    assert_substep(&part, Ending::Stuck, ContactState::Stick, 0.0, pad(0.0, V));
}

#[test]
fn a_pad_that_leaves_the_disc_before_its_first_step_is_over_slides() {
    // Its speed has a maximum soon after the release, and at the end of the step it lags behind.
    let toy = Toy::new(Law::Spring(0.0), HOLDS_TWO);
    let part = slide(&toy, &slipping(-0.1, V), 1.0, true).unwrap();
    let (sin, cos) = libm::sincos(1.0);
    assert_substep(&part, Ending::Completed, ContactState::Slip, 1.0, pad(sin - 0.1 * cos, cos + 0.1 * sin));
}

#[test]
fn a_pad_that_has_not_left_the_disc_yet_does_not_graze_it_however_slowly_it_moves() {
    let toy = Toy::new(Law::Constant(0.01, 0.0), HOLDS);
    assert!(!slide(&toy, &slipping(0.0, V), 0.5, true).unwrap().grazes);
}

#[test]
fn a_pad_that_leaves_the_disc_slides() {
    let toy = Toy::new(Law::Constant(-2.0, 0.0), HOLDS);
    let part = slide(&toy, &slipping(0.0, V), 0.5, true).unwrap();
    assert_substep(&part, Ending::Completed, ContactState::Slip, 0.5, pad(0.25, 0.0));
    assert!(!part.grazes);
}

#[test]
fn a_state_out_of_the_range_of_numbers_is_no_motion() {
    let toy = Toy::new(Law::Spring(0.0), HOLDS);
    assert_eq!(check(&toy, &pad(999.0, 1e9)), Ok(()));
    for (x, u) in [(1e3, 0.0), (-1e3, 0.0), (f64::NAN, 0.0), (0.0, f64::NAN), (0.0, f64::INFINITY)] {
        assert_eq!(check(&toy, &pad(x, u)), Err(Breakdown), "{x} {u}");
    }
}

/// The speed at the end of a substep of slip, and its length.
fn resolved(toy: &Toy, state: Pad, h: f64) -> Result<(f64, f64), Breakdown> {
    slide(toy, &Motion { state, contact: ContactState::Slip }, h, false).map(|part| (part.end.state.u, part.time))
}

#[test]
fn a_step_is_cut_to_four_fifths_of_what_steep_friction_allows() {
    // At the disc's speed a pad may change its speed by a quarter of the Stribeck velocity.
    let (u, h) = resolved(&Toy::steep(Law::Constant(-1.0, 0.0)), pad(0.0, V), 1.0).unwrap();
    assert!(close(h, 0.2) && close(u, 0.8), "{h} {u}");
    let (u, h) = resolved(&Toy::steep(Law::Constant(-1.0, 0.0)), pad(0.0, V), 0.26).unwrap();
    assert!(close(h, 0.8 * 0.25) && close(u, 0.8), "{h}");
}

#[test]
fn a_step_is_not_cut_where_friction_allows_it() {
    for (toy, h) in [
        (Toy::steep(Law::Constant(-1.0, 0.0)), 0.249),
        (Toy::steep(Law::Constant(-0.1, 0.0)), 1.0),
        (Toy::new(Law::Constant(-1.0, 0.0), HOLDS), 1.0),
    ] {
        assert_eq!(resolved(&toy, pad(0.0, V), h).unwrap().1, h);
    }
    // Ten Stribeck velocities behind the disc five times as much is allowed.
    assert_eq!(resolved(&Toy::steep(Law::Constant(-1.0, 0.0)), pad(0.0, -9.0), 1.24).unwrap().1, 1.24);
}

#[test]
fn a_step_out_of_the_range_of_numbers_is_cut_by_a_thousandth_at_a_time() {
    let (u, h) = resolved(&Toy::steep(Law::Violent(2e-4)), pad(0.0, 0.0), 1.0).unwrap();
    assert!(close(h, 1e-6) && close(u, 1e-6), "{h}");
}

#[test]
fn a_step_is_cut_no_further_than_makes_sense() {
    let (_, h) = resolved(&Toy::steep(Law::Violent(0.0)), pad(0.0, 0.0), 1.0).unwrap();
    assert!(h <= 1.001e-12 && h > 1e-16, "{h}");
}

#[test]
fn a_step_that_is_not_a_number_breaks_down() {
    for toy in [Toy::steep(Law::Broken), Toy::new(Law::Broken, HOLDS)] {
        assert_eq!(resolved(&toy, pad(0.0, 0.0), 1.0).err(), Some(Breakdown));
        assert_eq!(advance(&toy, &mut slipping(0.0, 0.0), 0.0, 1.0, &mut Log::default()), Err(Stopped::BrokeDown));
    }
}

#[test]
fn a_motion_ends_with_its_last_substep_in_a_step_that_is_divided_further() {
    // Steps of 1 are cut to 0.2 near rest.
    let toy = Toy::steep(Law::Constant(-1.0, 0.0));
    let mut motion = Motion { state: pad(0.0, V), contact: ContactState::Slip };
    let mut substeps = Substeps::at_most(3);
    let advanced = advance_counted(&toy, &mut motion, (0.0, 1.0), &mut substeps, &mut Log::default());
    assert_eq!(advanced, Err(Stopped::Exhausted));
    assert!(motion.state.u > V - 0.7 && motion.state.u < V - 0.5, "where three substeps lead: {}", motion.state.u);
    // One that needs no division goes on, however many substeps were taken.
    let mut substeps = Substeps { taken: 3, most: 3 };
    let free = Toy::new(Law::Constant(0.01, 0.0), HOLDS);
    assert_eq!(advance_counted(&free, &mut slipping(0.0, 0.0), (0.0, 1.0), &mut substeps, &mut Log::default()), Ok(()));
    assert_eq!(substeps.taken, 4);
}
