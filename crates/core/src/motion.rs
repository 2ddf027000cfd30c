//! Following a motion with stick and slip: fixed Runge-Kutta steps, and inside them the moments at which pad and disc
//! begin or cease to stick, located to the last digits.
//!
//! Stick and slip are states, not a smoothed sign function. In slip the pad moves under kinetic friction until the
//! sliding speed vanishes; in stick it moves with the disc until the friction that this takes exceeds what static
//! friction can give. A step that meets such a moment is cut there, so that no step size makes the motion chatter.

use crate::flexible::ContactState;

/// Moments of sticking and release in one step at the most; more of them means that the equations make no sense.
const MOST_EVENTS: usize = 64;

/// Displacements beyond this many disc thicknesses are no motion of a brake: the computation has broken down.
pub(crate) const FARTHEST: f64 = 1e3;

/// What a system of equations has to offer to be followed.
pub(crate) trait Equations {
    /// Displacements and speeds.
    type State: Copy;

    /// The state after a time `h` (any part of a step) in one state of contact.
    fn step(&self, state: &Self::State, contact: ContactState, h: f64) -> Step<Self::State>;

    /// x and x'.
    fn tangential(&self, state: &Self::State) -> (f64, f64);

    /// v.
    fn disc_speed(&self) -> f64;

    /// The same state moving exactly with the disc.
    fn moving_with_disc(&self, state: &Self::State) -> Self::State;

    /// What static friction has in hand while pad and disc stick: `f_s P` less the friction that is needed, against the
    /// pad slipping back, and against it running ahead. Any positive multiple of it.
    fn reserve(&self, state: &Self::State) -> Reserve;
}

/// See [`Equations::reserve`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reserve {
    pub against_slip: f64,
    pub against_overtaking: f64,
}

/// A step in one state of contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step<S> {
    pub next: S,
    /// x'' at its beginning, and as the last stage of the method sees it at its end.
    pub acceleration: (f64, f64),
}

/// What is told of a motion while it is followed.
pub(crate) trait Observer {
    /// The tangential motion turns back at `x`.
    fn turns(&mut self, time: f64, x: f64);
    /// Pad and disc begin to stick, at `x`.
    fn sticks(&mut self, time: f64, x: f64);
    /// They cease to.
    fn slips(&mut self, time: f64);
}

/// The computation broke down: not a number, or farther away than any brake could go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Breakdown;

/// A state with its contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion<S> {
    pub state: S,
    pub contact: ContactState,
}

/// Whether the sliding speed may vanish inside a step at whose ends it does not: it falls at the beginning, rises at the
/// end, and is small enough. `r` and `rate` are the sliding speed and its rate of change at both ends.
#[inline(always)]
pub(crate) fn may_touch(r: (f64, f64), rate: (f64, f64), h: f64) -> bool {
    (r.0 + h * rate.0 < 0.0) & (r.1 - h * rate.1 < 0.0)
}

/// The turning point inside a step at whose ends the speeds `u` differ in sign: its time after the beginning and its
/// displacement, from the cubic through speeds and accelerations.
pub(crate) fn turning_point(x: f64, u: (f64, f64), acceleration: (f64, f64), h: f64) -> (f64, f64) {
    let (c1, d) = (h * acceleration.0, u.1 - u.0);
    let c2 = 3.0 * d - h * (2.0 * acceleration.0 + acceleration.1);
    let c3 = h * (acceleration.0 + acceleration.1) - 2.0 * d;
    let speed = |s: f64| u.0 + s * (c1 + s * (c2 + s * c3));
    let (mut early, mut late) = (0.0, 1.0);
    let mut s = u.0 / (u.0 - u.1);
    for _ in 0..60 {
        let value = speed(s);
        if (value < 0.0) == (u.0 < 0.0) {
            early = s;
        } else {
            late = s;
        }
        let slope = c1 + s * (2.0 * c2 + s * 3.0 * c3);
        let newton = s - value / slope;
        let next = if newton > early && newton < late { newton } else { 0.5 * (early + late) };
        if (next - s).abs() < 1e-12 {
            break;
        }
        s = next;
    }
    (h * s, x + h * s * (u.0 + s * (c1 / 2.0 + s * (c2 / 3.0 + s * c3 / 4.0))))
}

/// Follows a motion for one step of length `h` from `time` on, whatever happens in it.
pub(crate) fn advance<E: Equations>(
    equations: &E,
    motion: &mut Motion<E::State>,
    time: f64,
    h: f64,
    observer: &mut impl Observer,
) -> Result<(), Breakdown> {
    let mut done = 0.0;
    let mut just_released = false;
    for _ in 0..MOST_EVENTS {
        let remaining = h - done;
        let part = follow(equations, motion, time + done, remaining, just_released, observer)?;
        just_released = motion.contact != ContactState::Stick;
        done += part;
        if part >= remaining || h - done <= 1e-13 * h {
            return Ok(());
        }
    }
    Err(Breakdown)
}

/// Follows a motion until its contact changes, at most for a time `h`; returns the time that has passed.
fn follow<E: Equations>(
    equations: &E,
    motion: &mut Motion<E::State>,
    time: f64,
    h: f64,
    just_released: bool,
    observer: &mut impl Observer,
) -> Result<f64, Breakdown> {
    let from = motion.state;
    let (x, u) = equations.tangential(&from);
    let contact = motion.contact;
    if contact == ContactState::Stick {
        let margin = |state: &E::State| {
            let reserve = equations.reserve(state);
            reserve.against_slip.min(reserve.against_overtaking)
        };
        let release = |state: &E::State| {
            let reserve = equations.reserve(state);
            if reserve.against_slip < reserve.against_overtaking {
                ContactState::Slip
            } else {
                ContactState::Overtaking
            }
        };
        if margin(&from) <= 0.0 {
            motion.contact = release(&from);
            observer.slips(time);
            return Ok(0.0);
        }
        let next = equations.step(&from, contact, h).next;
        check(equations, &next)?;
        if margin(&next) > 0.0 {
            motion.state = next;
            return Ok(h);
        }
        let (part, state) = locate(h, &next, |part| equations.step(&from, contact, part).next, margin);
        motion.state = state;
        motion.contact = release(&state);
        observer.slips(time + part);
        return Ok(part);
    }

    let direction = if contact == ContactState::Slip { 1.0 } else { -1.0 };
    let sliding = |state: &E::State| direction * (equations.disc_speed() - equations.tangential(state).1);
    let step = equations.step(&from, contact, h);
    check(equations, &step.next)?;
    let rate = (-direction * step.acceleration.0, -direction * step.acceleration.1);
    let ends = (sliding(&from), sliding(&step.next));
    let mut meets = (ends.1 <= 0.0).then_some((h, step.next));
    if meets.is_none() && ends.0 > 0.0 && may_touch(ends, rate, h) {
        meets = touch(equations, &from, contact, h, &sliding);
    }
    if let Some((late, state)) = meets {
        let (part, state) = if ends.0 > 0.0 {
            locate(late, &state, |part| equations.step(&from, contact, part).next, sliding)
        } else if just_released {
            // It does not come away from the disc in this time: it may as well have stuck.
            (h, step.next)
        } else {
            (0.0, from)
        };
        let state = equations.moving_with_disc(&state);
        let (next_x, _) = equations.tangential(&state);
        let acceleration = (step.acceleration.0, equations.step(&state, contact, 0.0).acceleration.0);
        report_turn(x, u, (next_x, equations.disc_speed()), acceleration, part, time, observer);
        let reserve = equations.reserve(&state);
        motion.state = state;
        if reserve.against_slip >= 0.0 && reserve.against_overtaking >= 0.0 {
            motion.contact = ContactState::Stick;
            // What has not come away since its release has not come back either.
            if ends.0 > 0.0 {
                observer.sticks(time + part, next_x);
            }
        } else if reserve.against_overtaking < 0.0 {
            motion.contact = ContactState::Overtaking;
        } else {
            motion.contact = ContactState::Slip;
        }
        return Ok(part);
    }
    let (next_x, next_u) = equations.tangential(&step.next);
    report_turn(x, u, (next_x, next_u), step.acceleration, h, time, observer);
    motion.state = step.next;
    Ok(h)
}

/// Tells of a turning point inside a step, if there is one.
fn report_turn(
    x: f64,
    u: f64,
    next: (f64, f64),
    acceleration: (f64, f64),
    h: f64,
    time: f64,
    observer: &mut impl Observer,
) {
    if turns(u, next.1) {
        let (part, at) = turning_point(x, (u, next.1), acceleration, h);
        observer.turns(time + part, at);
    }
}

/// Whether the speed changes its sign between two moments.
#[inline(always)]
pub(crate) fn turns(u: f64, next: f64) -> bool {
    ((u > 0.0) & (next <= 0.0)) | ((u < 0.0) & (next >= 0.0))
}

fn check<E: Equations>(equations: &E, state: &E::State) -> Result<(), Breakdown> {
    let (x, u) = equations.tangential(state);
    if x.abs() < FARTHEST && u.is_finite() { Ok(()) } else { Err(Breakdown) }
}

/// The lowest point of the sliding speed inside a step, if it is not above zero.
fn touch<E: Equations>(
    equations: &E,
    from: &E::State,
    contact: ContactState,
    h: f64,
    sliding: &impl Fn(&E::State) -> f64,
) -> Option<(f64, E::State)> {
    // The sliding speed falls as long as the acceleration at the end of a partial step says so.
    let falls = |part: f64| {
        let step = equations.step(from, contact, part);
        let direction = if contact == ContactState::Slip { 1.0 } else { -1.0 };
        (direction * equations.step(&step.next, contact, 0.0).acceleration.0 > 0.0, step.next)
    };
    let (mut early, mut late) = (0.0, h);
    for _ in 0..60 {
        let middle = 0.5 * (early + late);
        let (falls, state) = falls(middle);
        if sliding(&state) <= 0.0 {
            return Some((middle, state));
        }
        if falls {
            early = middle;
        } else {
            late = middle;
        }
    }
    None
}

/// The time in `0..late` at which `value`, positive before and not positive at `late`, vanishes; and the state there, on
/// the side where it is not positive. The Illinois variant of the false position, with bisection as its safeguard.
fn locate<S: Copy>(late: f64, state: &S, state_after: impl Fn(f64) -> S, value: impl Fn(&S) -> f64) -> (f64, S) {
    let (mut early, mut late, mut state) = (0.0, late, *state);
    let (mut at_early, mut at_late) = (value(&state_after(0.0)), value(&state));
    let tolerance = 1e-15 * late;
    let mut side = 0;
    for iteration in 0..100 {
        if late - early <= tolerance || at_late == 0.0 {
            break;
        }
        let secant = early + (late - early) * (at_early / (at_early - at_late));
        let middle = 0.5 * (early + late);
        let part = if iteration % 8 < 7 && secant > early && secant < late { secant } else { middle };
        if part <= early || part >= late {
            break;
        }
        let candidate = state_after(part);
        let at_part = value(&candidate);
        if at_part > 0.0 {
            early = part;
            at_early = at_part;
            if side == 1 {
                at_late *= 0.5;
            }
            side = 1;
        } else {
            late = part;
            at_late = at_part;
            state = candidate;
            if side == 2 {
                at_early *= 0.5;
            }
            side = 2;
        }
    }
    (late, state)
}
