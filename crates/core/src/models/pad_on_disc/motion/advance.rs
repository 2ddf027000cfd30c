//! A step of fixed length, as one or more substeps.
//!
//! So the motion does not chatter at any step size, and no step jumps across the friction law: see
//! [`crate::models::pad_on_disc::motion::substep`].

use crate::models::pad_on_disc::motion::integrator::{
    Equations, Motion, Observer, Step, Stopped, turning_point, turns,
};
use crate::models::pad_on_disc::motion::substep::{Attempt, Ending, Substep};
use crate::models::pad_on_disc::pad::contact_state::ContactState;

/// Changes of contact in one step at most; more of them mean that the equations make no sense.
const MOST_CHANGES: u32 = 64;

/// Substeps of one step at most, for motions whose substeps are not counted beyond it. Some hundred are usual where the
/// disc is a thousand times faster than the Stribeck velocity.
const MOST_SUBSTEPS: u64 = 1_000_000;

/// A step is over when no more than this share of it is left.
pub(crate) const LEAST_REMAINDER: f64 = 1e-13;

/// The substeps of a motion, and how many it may take: a bound on the work that does not depend on the clock.
///
/// A motion of whole steps is bounded by its horizon, so only a step that is divided further ends a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Substeps {
    pub taken: u64,
    pub most: u64,
}

impl Substeps {
    pub fn at_most(most: u64) -> Self {
        Self { taken: 0, most }
    }
}

/// Simulates one step of length `h` from `time` on, whatever happens in it.
pub(crate) fn advance<E: Equations>(
    equations: &E,
    motion: &mut Motion<E::State>,
    time: f64,
    h: f64,
    observer: &mut impl Observer,
) -> Result<(), Stopped> {
    advance_counted(equations, motion, (time, h), &mut Substeps::at_most(MOST_SUBSTEPS), observer)
}

/// The same for a motion whose `substeps` are counted.
pub(crate) fn advance_counted<E: Equations>(
    equations: &E,
    motion: &mut Motion<E::State>,
    (time, h): (f64, f64),
    substeps: &mut Substeps,
    observer: &mut impl Observer,
) -> Result<(), Stopped> {
    let mut step = StepInProgress::new(motion.contact, h, *substeps);
    loop {
        let trial = equations.step(&motion.state, motion.contact, step.attempt.length);
        if step.judge(equations, motion, &trial, time, observer)? {
            *substeps = step.substeps;
            return Ok(());
        }
    }
}

/// A step that is not over yet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepInProgress<S> {
    /// The present substep.
    pub attempt: Attempt<S>,
    /// Length of the step.
    pub h: f64,
    /// What is over of it.
    pub done: f64,
    /// The longest substep that is tried: after a cut, substeps grow again step by step.
    pub longest: f64,
    /// Substeps of the motion that are over, and changes of contact in the step.
    pub substeps: Substeps,
    pub changes: u32,
}

impl<S: Copy> StepInProgress<S> {
    /// At its beginning, after the `substeps` of the steps before.
    #[inline]
    pub fn new(contact: ContactState, h: f64, substeps: Substeps) -> Self {
        let attempt = Attempt::new(contact, h, false);
        Self { attempt, h, done: 0.0, longest: h, substeps, changes: 0 }
    }

    /// Judges a trial step of the present substep. If that ends with it, `motion` goes on to its end, and the observer
    /// learns what happened. Returns whether the whole step is over. `time` is that of its beginning.
    #[inline]
    pub fn judge<E: Equations<State = S>>(
        &mut self,
        equations: &E,
        motion: &mut Motion<S>,
        trial: &Step<S>,
        time: f64,
        observer: &mut impl Observer,
    ) -> Result<bool, Stopped> {
        let Some(part) = self.attempt.judge(equations, motion, trial)? else { return Ok(false) };
        report(equations, motion, &part, time + self.done, observer);
        let is_completed = part.ending == Ending::Completed;
        let just_released = !is_completed && part.end.contact != ContactState::Stick;
        self.longest = if is_completed { part.growth * part.time } else { self.h };
        self.changes += u32::from(!is_completed);
        self.substeps.taken += 1;
        *motion = part.end;
        let remaining = self.h - self.done;
        self.done += part.time;
        let left = self.h - self.done;
        if part.time >= remaining || left <= LEAST_REMAINDER * self.h {
            return Ok(true);
        }
        if self.changes > MOST_CHANGES {
            return Err(Stopped::BrokeDown);
        }
        if self.substeps.taken >= self.substeps.most {
            return Err(Stopped::Exhausted);
        }
        self.attempt = Attempt::new(motion.contact, left.min(self.longest), just_released);
        Ok(false)
    }
}

/// Reports what happened in a substep from `motion` at `begin` on.
#[inline]
fn report<E: Equations>(
    equations: &E,
    motion: &Motion<E::State>,
    part: &Substep<E::State>,
    begin: f64,
    observer: &mut impl Observer,
) {
    let (x, u) = equations.tangential(&motion.state);
    let (next_x, next_u) = equations.tangential(&part.end.state);
    if motion.contact != ContactState::Stick && turns(u, next_u) {
        let (time, at) = turning_point(x, (u, next_u), part.acceleration, part.time);
        observer.turns(begin + time, at);
    }
    if part.grazes {
        observer.grazes();
    }
    if part.ending == Ending::Stuck {
        let has_come = u != equations.disc_speed();
        observer.holds(begin + if has_come { part.time } else { time_away(part) });
    }
    if part.is_caught {
        observer.is_caught(next_x);
    }
    match part.ending {
        Ending::Completed => {}
        Ending::Released => observer.slips(begin + part.time),
        // A pad that has not left the disc since its release has not come to stick either.
        Ending::Stuck if u == equations.disc_speed() => {}
        Ending::Stuck => observer.sticks(begin + part.time, next_x),
        Ending::Overtaken => observer.overtakes(next_x, part.end.contact),
    }
}

/// How long a pad was away from the disc that left it at the beginning of a substep and sticks to it at the end: the
/// relative speed is back at zero after `t` in `a0 t + (a1 - a0) t^2 / (2 T) = 0`.
fn time_away<S>(part: &Substep<S>) -> f64 {
    let (first, last) = part.acceleration;
    let share = 2.0 * first / (first - last);
    if share > 0.0 { share.min(1.0) * part.time } else { 0.0 }
}

#[cfg(test)]
mod tests;
