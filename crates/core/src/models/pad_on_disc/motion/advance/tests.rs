//! Equations of motion with closed forms: a pad under a constant acceleration, and one on a spring.

use std::f64::consts::{FRAC_PI_2, PI};

use super::*;
use crate::friction::shape::Shape;
use crate::models::pad_on_disc::motion::friction_steps::{FrictionSteps, LimitedLaw};
use crate::models::pad_on_disc::motion::integrator::Reserve;

mod substeps;

#[derive(Debug, Clone, Copy, PartialEq)]
struct Pad {
    x: f64,
    u: f64,
}

#[derive(Clone, Copy)]
enum Law {
    /// x'' in slip, and while the pad is faster than the disc.
    Constant(f64, f64),
    /// x'' = centre - x.
    Spring(f64),
    /// x'' = x - centre.
    Repelled(f64),
    /// Steps that are longer than this leave the range of numbers, by their acceleration.
    Violent(f64),
    /// Nothing but NaN.
    Broken,
}

/// A disc at speed 1 and a pad on it.
struct Toy {
    law: Law,
    reserve: Reserves,
    limits: FrictionSteps,
}

const V: f64 = 1.0;

/// The reserve of static friction at x, against slip and against overtaking.
type Reserves = fn(f64) -> (f64, f64);

/// Static friction that always holds.
const HOLDS: Reserves = |_| (1.0, 1.0);

/// A spring of stiffness 1 that static friction holds up to a force of 2, to either side.
const HOLDS_TWO: Reserves = |x| (2.0 - x, 2.0 + x);

impl Toy {
    /// With friction that sets no limits to steps.
    fn new(law: Law, reserve: Reserves) -> Self {
        Self { law, reserve, limits: FrictionSteps::new(V, 0.0, LimitedLaw::new(Shape::Tustin, 1.0), (0.0, 0.0), 1.0) }
    }

    /// With a Stribeck velocity of 1 to whose friction steps have to keep.
    fn steep(law: Law) -> Self {
        Self {
            limits: FrictionSteps::new(V, 1.0, LimitedLaw::new(Shape::Tustin, 1.0), (0.0, 0.0), 1.0),
            ..Self::new(law, HOLDS)
        }
    }
}

impl Equations for Toy {
    type State = Pad;

    fn step(&self, &Pad { x, u }: &Pad, contact: ContactState, h: f64) -> Step<Pad> {
        let constant = |a: f64, reported: f64| Step {
            next: Pad { x: x + h * (u + 0.5 * h * a), u: u + h * a },
            acceleration: (reported, reported),
        };
        match self.law {
            _ if contact == ContactState::Stick => constant(0.0, 0.0),
            Law::Constant(_, overtaking) if contact == ContactState::Overtaking => constant(overtaking, overtaking),
            Law::Constant(a, _) => constant(a, a),
            Law::Spring(centre) => {
                let (sin, cos) = libm::sincos(h);
                let next = Pad { x: centre + (x - centre) * cos + u * sin, u: u * cos - (x - centre) * sin };
                Step { next, acceleration: (centre - x, centre - next.x) }
            }
            Law::Repelled(centre) => {
                let (sinh, cosh) = (libm::sinh(h), libm::cosh(h));
                let next = Pad { x: centre + (x - centre) * cosh + u * sinh, u: u * cosh + (x - centre) * sinh };
                Step { next, acceleration: (x - centre, next.x - centre) }
            }
            Law::Violent(longest) => constant(1.0, if h > longest { f64::INFINITY } else { 0.0 }),
            Law::Broken => constant(f64::NAN, f64::NAN),
        }
    }

    fn tangential(&self, state: &Pad) -> (f64, f64) {
        (state.x, state.u)
    }

    fn disc_speed(&self) -> f64 {
        V
    }

    fn moving_with_disc(&self, state: &Pad) -> Pad {
        Pad { u: V, ..*state }
    }

    fn reserve(&self, state: &Pad) -> Reserve {
        let (against_slip, against_overtaking) = (self.reserve)(state.x);
        Reserve { against_slip, against_overtaking }
    }

    fn meeting_rate(&self) -> f64 {
        1.0
    }

    fn friction_steps(&self) -> &FrictionSteps {
        &self.limits
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Event {
    Turns(f64, f64),
    Sticks(f64, f64),
    Slips(f64),
    Grazes,
}

#[derive(Default)]
struct Log(Vec<Event>);

impl Observer for Log {
    fn turns(&mut self, time: f64, x: f64) {
        self.0.push(Event::Turns(time, x));
    }
    fn sticks(&mut self, time: f64, x: f64) {
        self.0.push(Event::Sticks(time, x));
    }
    fn slips(&mut self, time: f64) {
        self.0.push(Event::Slips(time));
    }
    fn grazes(&mut self) {
        self.0.push(Event::Grazes);
    }
}

fn pad(x: f64, u: f64) -> Pad {
    Pad { x, u }
}

fn slipping(x: f64, u: f64) -> Motion<Pad> {
    Motion { state: pad(x, u), contact: ContactState::Slip }
}

fn close(found: f64, expected: f64) -> bool {
    (found - expected).abs() < 1e-12
}

#[test]
fn the_speed_turns_where_its_sign_changes() {
    for (u, next, expected) in [
        (1.0, -1.0, true),
        (-1.0, 1.0, true),
        (1.0, 0.0, true),
        (-1.0, 0.0, true),
        (0.0, 1.0, false),
        (0.0, -1.0, false),
        (0.0, 0.0, false),
        (1.0, 2.0, false),
        (-1.0, -2.0, false),
    ] {
        assert_eq!(turns(u, next), expected, "{u} {next}");
    }
}

#[test]
fn a_turning_point_is_exact_where_the_speed_is_a_cubic() {
    // u = (s - 0.3)(s - 2)(s + 1), with s = t / h.
    for h in [0.1, 1.0, 7.0] {
        for sign in [1.0, -1.0] {
            let accelerations = (sign * -1.7 / h, sign * -1.3 / h);
            let (time, x) = turning_point(5.0, (sign * 0.6, sign * -1.4), accelerations, h);
            assert!((time / h - 0.3).abs() < 5e-12, "{time}");
            assert!(((x - 5.0) / (sign * h) - 0.093_825).abs() < 1e-12, "{x}");
        }
    }
}

#[test]
fn a_turning_point_at_the_end_of_a_step_is_there() {
    let (time, x) = turning_point(0.0, (1.0, 0.0), (-1.0, -1.0), 1.0);
    assert!(close(time, 1.0) && close(x, 0.5), "{time} {x}");
}

#[test]
fn a_turning_point_of_a_spring_is_found_to_the_fifth_order_of_the_step() {
    let errors = [0.2, 0.1].map(|h| {
        let begin = FRAC_PI_2 - 0.3 * h;
        let speed = |time: f64| libm::cos(time);
        let accelerations = (-libm::sin(begin), -libm::sin(begin + h));
        let (time, x) = turning_point(libm::sin(begin), (speed(begin), speed(begin + h)), accelerations, h);
        assert!((x - 1.0).abs() < 0.01 * h * h * h * h * h, "{h}: {:e}", x - 1.0);
        (time - 0.3 * h).abs()
    });
    assert!(errors[0] < 1e-5 && errors[1] < errors[0] / 15.0, "{errors:?}");
}

/// Simulates a pad step by step, and keeps its events.
fn simulate(toy: &Toy, motion: &mut Motion<Pad>, h: f64, steps: u32) -> Vec<Event> {
    let mut log = Log::default();
    for step in 0..steps {
        advance(toy, motion, h * f64::from(step), h, &mut log).unwrap();
    }
    log.0
}

#[track_caller]
fn assert_events(found: &[Event], expected: &[Event], tolerance: f64) {
    assert_eq!(found.len(), expected.len(), "{found:?}");
    for (found, expected) in found.iter().zip(expected) {
        let numbers = |event: &Event| match *event {
            Event::Turns(time, x) | Event::Sticks(time, x) => [time, x],
            Event::Slips(time) => [time, 0.0],
            Event::Grazes => [0.0, 0.0],
        };
        assert_eq!(std::mem::discriminant(found), std::mem::discriminant(expected), "{found:?} {expected:?}");
        let [[time, x], [expected_time, expected_x]] = [numbers(found), numbers(expected)];
        assert!(
            (time - expected_time).abs() < tolerance && (x - expected_x).abs() < tolerance,
            "{found:?} {expected:?}"
        );
    }
}

#[test]
fn stick_slip_on_a_spring_has_the_period_and_the_turns_of_its_closed_form() {
    // Static friction holds up to x = 2, kinetic friction centres the spring at 1.5: slip is part of a circle around
    // it.
    let toy = Toy::new(Law::Spring(1.5), HOLDS_TWO);
    let radius = f64::sqrt(1.0 + 0.25);
    let to_turn = libm::atan(2.0);
    let slip = 2.0 * (PI - libm::atan(0.5));
    let mut expected = vec![];
    for cycle in 0..3 {
        let release = 0.25 + f64::from(cycle) * (slip + 1.0);
        expected.extend([
            Event::Slips(release),
            Event::Turns(release + to_turn, 1.5 + radius),
            Event::Turns(release + to_turn + PI, 1.5 - radius),
            Event::Sticks(release + slip, 1.0),
        ]);
    }
    for h in [0.05, 0.3, 0.71] {
        let mut motion = Motion { state: pad(1.75, V), contact: ContactState::Stick };
        let steps = libm::ceil((expected.len() as f64 / 4.0) * (slip + 1.0) / h);
        let found = simulate(&toy, &mut motion, h, steps as u32);
        // Turning points are interpolated.
        assert_events(&found[..12], &expected, 1e-4 + 0.02 * h * h * h * h);
        let exact = |event: &&Event| !matches!(event, Event::Turns(..));
        let [found, expected] =
            [&found[..12], &expected].map(|log| log.iter().filter(exact).copied().collect::<Vec<_>>());
        assert_events(&found, &expected, 1e-10);
    }
}

#[test]
fn several_events_in_one_step_are_reported_in_their_order() {
    // It turns, meets the disc, and is carried to where friction holds it no longer; then it slips away.
    let toy = Toy::new(Law::Constant(2.0, 0.0), |x| (1.0 - x, 9.0));
    let mut motion = slipping(0.0, -1.0);
    let found = simulate(&toy, &mut motion, 1.5, 1);
    assert_events(&found, &[Event::Turns(0.5, -0.25), Event::Sticks(1.0, 0.0)], 5e-12);
    assert_eq!(motion.contact, ContactState::Stick);
    assert!(close(motion.state.x, 0.5) && motion.state.u == V, "{motion:?}");

    let toy = Toy::new(Law::Constant(-1.0, 0.0), |x| (1.0 - x, 9.0));
    let mut motion = Motion { state: pad(0.5, V), contact: ContactState::Stick };
    let found = simulate(&toy, &mut motion, 2.0, 1);
    assert_events(&found, &[Event::Slips(0.5), Event::Turns(1.5, 1.5)], 5e-12);
    assert_eq!(motion.contact, ContactState::Slip);
    assert!(close(motion.state.x, 1.375) && close(motion.state.u, -0.5), "{motion:?}");
}

#[test]
fn a_pad_that_overtakes_the_disc_in_a_step_is_simulated_to_its_end_without_an_event() {
    let toy = Toy::new(Law::Constant(1.0, 0.5), |_| (9.0, -1.0));
    let mut motion = slipping(0.0, 0.0);
    assert_eq!(simulate(&toy, &mut motion, 2.0, 1), []);
    assert_eq!(motion.contact, ContactState::Overtaking);
    assert!(close(motion.state.x, 0.5 + 1.25) && close(motion.state.u, 1.5), "{motion:?}");
}

#[test]
fn a_graze_is_reported_before_the_stick_that_it_leads_to() {
    let toy = Toy::new(Law::Constant(0.01, 0.0), HOLDS);
    let found = simulate(&toy, &mut slipping(0.0, 0.995), 1.0, 1);
    assert_events(&found, &[Event::Grazes, Event::Sticks(0.5, 0.498_75)], 1e-12);
}

#[test]
fn a_pad_that_has_not_left_the_disc_since_its_release_reports_no_stick() {
    let toy = Toy::new(Law::Constant(2.0, 0.0), |x| (x, 1.0));
    let mut motion = Motion { state: pad(0.0, V), contact: ContactState::Stick };
    assert_eq!(simulate(&toy, &mut motion, 0.5, 1), [Event::Slips(0.0)]);
    assert_eq!(motion.contact, ContactState::Stick);
}

#[test]
fn the_substeps_of_a_cut_step_make_up_the_whole_step() {
    let toy = Toy::steep(Law::Constant(-1.0, 0.0));
    let mut motion = slipping(0.0, V);
    let found = simulate(&toy, &mut motion, 4.0, 1);
    assert_events(&found, &[Event::Turns(1.0, 0.5)], 5e-12);
    assert!(close(motion.state.x, -4.0) && close(motion.state.u, -3.0), "{motion:?}");
}
