//! Simulation of a motion with stick and slip: fixed Runge-Kutta steps, and inside them the moments at which pad and
//! disc begin or cease to stick, located to the last digits.
//!
//! Stick and slip are states, not a smoothed sign function. In slip the pad moves under kinetic friction until the
//! sliding speed vanishes; in stick it moves with the disc until the friction that this takes exceeds what static
//! friction can give. [`advance`] takes a step as one or more substeps, each in one state of contact:
//!
//! | in the state | function | a substep ends | then |
//! |---|---|---|---|
//! | stick | [`stick`] | completed, at the end of the step | stick |
//! | | | released, static friction is exhausted | slip or overtaking, as the needed friction points |
//! | slip, overtaking | [`slide`] | completed, at the end of the step or where [`FrictionSteps`] cut it | the same |
//! | | | stuck, the sliding speed vanishes and static friction can hold the pad | stick |
//! | | | overtaken, the sliding speed vanishes and static friction cannot | overtaking or slip, the other sense |
//!
//! So the motion does not chatter at any step size, and no step jumps across the friction law.

use crate::motion::friction_steps::FrictionSteps;
use crate::numerics::root_location::false_position;
use crate::pad::contact_state::ContactState;

/// Changes of contact in one step at most, and substeps; more of them mean that the equations make no sense. Some
/// hundred substeps are usual where the disc is a thousand times faster than the Stribeck velocity.
const MOST_CHANGES: usize = 64;
const MOST_SUBSTEPS: usize = 1_000_000;

/// A substep that the friction law cuts is shortened to this share of what the law allows, so that a second cut is
/// rare, and at once to no less than this share of its length.
const CUT: f64 = 0.8;
const DEEPEST_CUT: f64 = 1e-3;

/// Displacements beyond this many disc thicknesses are no motion of a brake: the computation has broken down.
pub(crate) const FARTHEST: f64 = 1e3;

/// A system of equations that can be simulated.
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

    /// The reserve of static friction while pad and disc stick, up to a positive factor: `f_s P` less the friction that
    /// is needed to keep the pad from slipping back, and from running ahead.
    fn reserve(&self, state: &Self::State) -> Reserve;

    /// A typical acceleration of a pad that meets the disc: the disc's speed times the natural frequency of the
    /// tangential motion.
    fn meeting_rate(&self) -> f64;

    /// The limits that the friction law sets to steps.
    fn friction_steps(&self) -> &FrictionSteps;
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

/// Receives the events of a motion while it is simulated.
pub(crate) trait Observer {
    /// The tangential motion turns back at `x`.
    fn turns(&mut self, time: f64, x: f64);
    /// Pad and disc begin to stick, at `x`.
    fn sticks(&mut self, time: f64, x: f64);
    /// They cease to.
    fn slips(&mut self, time: f64);
    /// Pad and disc pass each other without sticking.
    fn overtakes(&mut self) {}
    /// The pad comes so near the disc's speed, or meets it so slowly, that errors of the steps may decide whether they
    /// stick. If they do, this comes first.
    fn grazes(&mut self) {}
}

/// A pad grazes where its sliding speed has a minimum below this share of the disc's speed, or where it meets the disc
/// with less than this share of the disc's speed times its natural frequency. Where stick-slip ends, errors of the
/// sliding speed are some 1e-6 of the disc's (a test of the steps), and the acceleration at the meeting grows with the
/// square root of the distance to a mere touch.
const GRAZING_SPEED: f64 = 1e-4;
const GRAZING_RATE: f64 = 3e-2;

/// The computation broke down: not a number, or farther away than any brake could go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Breakdown;

/// A state with its contact.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motion<S> {
    pub state: S,
    pub contact: ContactState,
}

/// Whether the sliding speed may vanish inside a step at whose ends it does not: it falls at the beginning, rises at
/// the end, and is small enough. `r` and `rate` are the sliding speed and its rate of change at both ends.
#[inline(always)]
pub(crate) fn may_touch(r: (f64, f64), rate: (f64, f64), h: f64) -> bool {
    (r.0 + h * rate.0 < 0.0) & (r.1 - h * rate.1 < 0.0)
}

/// Whether a step that slows down the sliding ends so near the disc's speed that the pad grazes it. `r` is the sliding
/// speed at both ends.
#[inline(always)]
pub(crate) fn grazes_at_end(r: (f64, f64), disc_speed: f64) -> bool {
    (r.1 < GRAZING_SPEED * disc_speed) & (r.1 < r.0)
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

/// What ended a substep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    /// The given time, or as much of it as the friction law allows.
    Completed,
    /// Static friction could hold the pad no longer.
    Released,
    /// Pad and disc came to move together, and static friction holds them.
    Stuck,
    /// Pad and disc passed each other: static friction could not hold them.
    Overtaken,
}

/// A part of a step in one state of contact.
#[derive(Debug, Clone, Copy)]
struct Substep<S> {
    time: f64,
    end: Motion<S>,
    /// x'' at its beginning and its end.
    acceleration: (f64, f64),
    ending: Ending,
    grazes: bool,
}

/// Simulates one step of length `h` from `time` on, whatever happens in it.
pub(crate) fn advance<E: Equations>(
    equations: &E,
    motion: &mut Motion<E::State>,
    time: f64,
    h: f64,
    observer: &mut impl Observer,
) -> Result<(), Breakdown> {
    let mut done = 0.0;
    let mut just_released = false;
    let mut changes = 0;
    // The longest substep that is tried: after a cut, substeps grow again by doubling.
    let mut longest = h;
    for _ in 0..MOST_SUBSTEPS {
        let remaining = h - done;
        let begin = time + done;
        let part = if motion.contact == ContactState::Stick {
            stick(equations, &motion.state, remaining)?
        } else {
            slide(equations, motion, remaining.min(longest), just_released)?
        };
        let before = equations.tangential(&motion.state);
        let after = equations.tangential(&part.end.state);
        if motion.contact != ContactState::Stick {
            report_turn(before, after, part.acceleration, part.time, begin, observer);
        }
        if part.grazes {
            observer.grazes();
        }
        match part.ending {
            Ending::Completed => {}
            Ending::Released => observer.slips(begin + part.time),
            // A pad that has not left the disc since its release has not come to stick either.
            Ending::Stuck if before.1 == equations.disc_speed() => {}
            Ending::Stuck => observer.sticks(begin + part.time, after.0),
            Ending::Overtaken => observer.overtakes(),
        }
        let completed = part.ending == Ending::Completed;
        just_released = !completed && part.end.contact != ContactState::Stick;
        longest = if completed { 2.0 * part.time } else { h };
        changes += usize::from(!completed);
        *motion = part.end;
        done += part.time;
        if part.time >= remaining || h - done <= 1e-13 * h {
            return Ok(());
        }
        if changes > MOST_CHANGES {
            break;
        }
    }
    Err(Breakdown)
}

/// Simulates pad and disc as they move together, until static friction is exhausted, at most for a time `h`.
fn stick<E: Equations>(equations: &E, from: &E::State, h: f64) -> Result<Substep<E::State>, Breakdown> {
    let margin = |state: &E::State| {
        let reserve = equations.reserve(state);
        reserve.against_slip.min(reserve.against_overtaking)
    };
    let part = |time: f64, state: E::State, ending: Ending| {
        let reserve = equations.reserve(&state);
        let contact = match ending {
            Ending::Released if reserve.against_slip < reserve.against_overtaking => ContactState::Slip,
            Ending::Released => ContactState::Overtaking,
            _ => ContactState::Stick,
        };
        Ok(Substep { time, end: Motion { state, contact }, acceleration: (0.0, 0.0), ending, grazes: false })
    };
    if margin(from) <= 0.0 {
        return part(0.0, *from, Ending::Released);
    }
    let next = equations.step(from, ContactState::Stick, h).next;
    check(equations, &next)?;
    if margin(&next) > 0.0 {
        return part(h, next, Ending::Completed);
    }
    let (time, state) = locate(h, &next, |time| equations.step(from, ContactState::Stick, time).next, margin);
    part(time, state, Ending::Released)
}

/// Simulates a sliding pad until it meets the disc's speed, at most for a time `h`, and no longer than the friction law
/// allows.
fn slide<E: Equations>(
    equations: &E,
    motion: &Motion<E::State>,
    h: f64,
    just_released: bool,
) -> Result<Substep<E::State>, Breakdown> {
    let Motion { state: from, contact } = *motion;
    let direction = if contact == ContactState::Slip { 1.0 } else { -1.0 };
    let sliding = |state: &E::State| direction * (equations.disc_speed() - equations.tangential(state).1);
    let (step, h) = resolved_step(equations, &from, contact, h)?;
    let rate = (-direction * step.acceleration.0, -direction * step.acceleration.1);
    let ends = (sliding(&from), sliding(&step.next));
    let mut meets = (ends.1 <= 0.0).then_some((h, step.next));
    let mut grazes = grazes_at_end(ends, equations.disc_speed());
    if meets.is_none() && ends.0 > 0.0 && may_touch(ends, rate, h) {
        let (part, nearest) = least_sliding(equations, &from, contact, h, &sliding);
        grazes |= sliding(&nearest) < GRAZING_SPEED * equations.disc_speed();
        meets = (sliding(&nearest) <= 0.0).then_some((part, nearest));
    }
    let Some((late, state)) = meets else {
        let end = Motion { state: step.next, contact };
        return Ok(Substep { time: h, end, acceleration: step.acceleration, ending: Ending::Completed, grazes });
    };
    let (time, state) = if ends.0 > 0.0 {
        locate(late, &state, |part| equations.step(&from, contact, part).next, sliding)
    } else if just_released {
        // It does not leave the disc in this time: it may as well have stuck.
        (h, step.next)
    } else {
        (0.0, from)
    };
    let state = equations.moving_with_disc(&state);
    let acceleration = (step.acceleration.0, equations.step(&state, contact, 0.0).acceleration.0);
    let reserve = equations.reserve(&state);
    let (contact, ending) = if reserve.against_slip >= 0.0 && reserve.against_overtaking >= 0.0 {
        (ContactState::Stick, Ending::Stuck)
    } else if reserve.against_overtaking < 0.0 {
        (ContactState::Overtaking, Ending::Overtaken)
    } else {
        (ContactState::Slip, Ending::Overtaken)
    };
    grazes = ends.0 > 0.0 && acceleration.1.abs() < GRAZING_RATE * equations.meeting_rate();
    Ok(Substep { time, end: Motion { state, contact }, acceleration, ending, grazes })
}

/// A step of length `h`, or the longest shorter one that the friction law allows; and its length.
fn resolved_step<E: Equations>(
    equations: &E,
    from: &E::State,
    contact: ContactState,
    mut h: f64,
) -> Result<(Step<E::State>, f64), Breakdown> {
    let limits = equations.friction_steps();
    let u = equations.tangential(from).1;
    let shortest = 1e-12 * h;
    loop {
        let step = equations.step(from, contact, h);
        let ends = (u, equations.tangential(&step.next).1);
        if h <= shortest || !limits.is_too_long(ends, step.acceleration, h) {
            check(equations, &step.next)?;
            return Ok((step, h));
        }
        // Infinite accelerations take the deepest cut.
        let share = CUT / limits.excess(ends, step.acceleration, h);
        h *= if share > DEEPEST_CUT { share.min(CUT) } else { DEEPEST_CUT };
    }
}

/// Reports a turning point inside a substep, if there is one.
fn report_turn(
    (x, u): (f64, f64),
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

/// The lowest point of the sliding speed inside a step, or a point on the way there that is not above zero.
fn least_sliding<E: Equations>(
    equations: &E,
    from: &E::State,
    contact: ContactState,
    h: f64,
    sliding: &impl Fn(&E::State) -> f64,
) -> (f64, E::State) {
    // Whether the sliding speed still falls at the end of a partial step.
    let falls = |part: f64| {
        let step = equations.step(from, contact, part);
        let direction = if contact == ContactState::Slip { 1.0 } else { -1.0 };
        (direction * equations.step(&step.next, contact, 0.0).acceleration.0 > 0.0, step.next)
    };
    let (mut early, mut late) = (0.0, h);
    let mut nearest = (0.0, *from);
    for _ in 0..60 {
        let middle = 0.5 * (early + late);
        let (falls, state) = falls(middle);
        nearest = (middle, state);
        if sliding(&state) <= 0.0 {
            break;
        }
        if falls {
            early = middle;
        } else {
            late = middle;
        }
    }
    nearest
}

/// The time in `0..late` at which `value`, positive before and not positive in the `state` at `late`, vanishes; and the
/// state there.
fn locate<S: Copy>(late: f64, state: &S, state_after: impl Fn(f64) -> S, value: impl Fn(&S) -> f64) -> (f64, S) {
    let ends = ((0.0, value(&state_after(0.0))), (late, value(state)));
    false_position(ends.0, ends.1, *state, 1e-15 * late, state_after, value)
}

#[cfg(test)]
mod tests;
