//! A substep, found by trial steps.
//!
//! A substep is a part of a step in one state of contact. Where it ends is found by trial steps of the equations, all
//! from the state at its beginning:
//!
//! | in the state | a trial step | then |
//! |---|---|---|
//! | stick | static friction still holds the pad at its end | completed |
//! | | it does not | the release is located by further trials: released |
//! | slip, overtaking | is too long for the friction law ([`crate::models::pad_on_disc::motion::friction_steps`]) | a shorter one |
//! | | does not meet the disc's speed | completed |
//! | | meets it | the meeting is located by further trials: stuck if static friction can hold the pad, else overtaken |
//!
//! [`Attempt`] says how long the next trial step is, and judges it. Who takes the step does not matter: the scalar code
//! takes one after the other, lanes take those of many samples at once.

use crate::models::pad_on_disc::motion::friction_steps::MOST_GROWTH;
use crate::models::pad_on_disc::motion::integrator::{
    Breakdown, Equations, FARTHEST, Motion, Step, grazes_at_end, may_touch,
};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::numerics::root_location::FalsePosition;

/// Trial steps are not cut below this share of the first one.
pub(crate) const SHORTEST: f64 = 1e-12;

/// What ended a substep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ending {
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
pub(crate) struct Substep<S> {
    pub time: f64,
    pub end: Motion<S>,
    /// x'' at its beginning and its end.
    pub acceleration: (f64, f64),
    pub ending: Ending,
    pub grazes: bool,
    /// It ends close to the disc's speed on a fast approach, and static friction could hold the pad there. Only set
    /// for the exponent 1, whose steps seldom end there.
    pub is_caught: bool,
    /// How many times longer the next substep may be, if this one is completed.
    pub growth: f64,
}

/// A substep that is not found yet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Attempt<S> {
    /// Length of the next trial step.
    pub length: f64,
    aim: Aim<S>,
}

/// What a trial step is for.
#[derive(Debug, Clone, Copy)]
enum Aim<S> {
    /// To slide; the shortest trial step, and whether static friction has just released the pad.
    Slide { shortest: f64, just_released: bool },
    /// To locate where the sliding speed vanishes; the state at the late end of the search, and x'' at the beginning.
    Meeting { search: FalsePosition, state: S, acceleration: f64 },
    /// To move with the disc.
    Stick,
    /// To locate where static friction is exhausted; the state at the late end of the search.
    Release { search: FalsePosition, state: S },
}

impl<S: Copy> Attempt<S> {
    /// A substep of length `h` at most.
    #[inline]
    pub fn new(contact: ContactState, h: f64, just_released: bool) -> Self {
        match contact {
            ContactState::Stick => Self { length: h, aim: Aim::Stick },
            _ => Self { length: h, aim: Aim::Slide { shortest: SHORTEST * h, just_released } },
        }
    }

    /// A substep of slip whose trial step has come down to `length`.
    #[inline]
    pub fn sliding(length: f64, shortest: f64) -> Self {
        Self { length, aim: Aim::Slide { shortest, just_released: false } }
    }

    /// The shortest trial step, if lanes may judge the next one: if nothing is located and what happened before the
    /// substep does not matter.
    #[inline]
    pub fn shortest_plain(&self) -> Option<f64> {
        match self.aim {
            Aim::Slide { shortest, just_released: false } => Some(shortest),
            Aim::Stick => Some(0.0),
            _ => None,
        }
    }

    /// Judges a trial step from the beginning of the substep. Returns the substep once it is found.
    #[inline]
    pub fn judge<E: Equations<State = S>>(
        &mut self,
        equations: &E,
        from: &Motion<S>,
        step: &Step<S>,
    ) -> Result<Option<Substep<S>>, Breakdown> {
        match &mut self.aim {
            Aim::Slide { shortest, just_released } => {
                let u = (equations.tangential(&from.state).1, equations.tangential(&step.next).1);
                let limits = equations.friction_steps();
                let (is_too_long, factor) = limits.judge(u, step.acceleration, self.length);
                if self.length > *shortest && is_too_long {
                    self.length *= factor;
                    return Ok(None);
                }
                let growth = if is_too_long { MOST_GROWTH } else { factor };
                let just_released = *just_released;
                self.judge_slide(equations, from, step, just_released, growth)
            }
            Aim::Meeting { search, state, acceleration } => {
                let relative = Relative::new(equations, from.contact);
                if search.add(self.length, relative.sliding(&step.next)) {
                    *state = step.next;
                }
                if let Some(length) = search.next_point() {
                    self.length = length;
                    return Ok(None);
                }
                Ok(Some(meeting(equations, from, search.late(), state, *acceleration)))
            }
            Aim::Stick => self.judge_stick(equations, from, step),
            Aim::Release { search, state } => {
                if search.add(self.length, margin(equations, &step.next)) {
                    *state = step.next;
                }
                if let Some(length) = search.next_point() {
                    self.length = length;
                    return Ok(None);
                }
                Ok(Some(stuck_until(equations, search.late(), state, Ending::Released)))
            }
        }
    }

    /// Judges a trial step of slip that is short enough.
    fn judge_slide<E: Equations<State = S>>(
        &mut self,
        equations: &E,
        from: &Motion<S>,
        step: &Step<S>,
        just_released: bool,
        growth: f64,
    ) -> Result<Option<Substep<S>>, Breakdown> {
        check(equations, &step.next)?;
        let (h, contact) = (self.length, from.contact);
        let relative = Relative::new(equations, contact);
        let rate = (-relative.direction * step.acceleration.0, -relative.direction * step.acceleration.1);
        let ends = (relative.sliding(&from.state), relative.sliding(&step.next));
        let mut meets = (ends.1 <= 0.0).then_some((h, step.next));
        let limits = equations.friction_steps();
        let is_near = grazes_at_end(ends, equations.disc_speed(), limits.grazing_speed);
        let is_fast = is_near && rate.1 <= -limits.grazing_rate * equations.meeting_rate();
        let mut grazes = is_near && !is_fast;
        let is_caught =
            is_fast && !limits.are_fine_near_rest() && margin(equations, &equations.moving_with_disc(&step.next)) > 0.0;
        if meets.is_none() && ends.0 > 0.0 && may_touch(ends, rate, h) {
            let (part, nearest) = relative.least_sliding(&from.state, h);
            grazes |= relative.sliding(&nearest) < limits.grazing_speed * equations.disc_speed();
            meets = (relative.sliding(&nearest) <= 0.0).then_some((part, nearest));
        }
        let Some((late, state)) = meets else {
            let end = Motion { state: step.next, contact };
            let acceleration = step.acceleration;
            return Ok(Some(Substep {
                time: h,
                end,
                acceleration,
                ending: Ending::Completed,
                grazes,
                is_caught,
                growth,
            }));
        };
        let acceleration = step.acceleration.0;
        let (time, state) = if ends.0 > 0.0 {
            let mut search = FalsePosition::new((0.0, ends.0), (late, relative.sliding(&state)), 1e-15 * late);
            if let Some(length) = search.next_point() {
                *self = Self { length, aim: Aim::Meeting { search, state, acceleration } };
                return Ok(None);
            }
            (late, state)
        } else if just_released {
            // It does not leave the disc in this time: it may as well have stuck.
            (h, step.next)
        } else {
            (0.0, from.state)
        };
        Ok(Some(meeting(equations, from, time, &state, acceleration)))
    }

    /// Judges a trial step in stick.
    fn judge_stick<E: Equations<State = S>>(
        &mut self,
        equations: &E,
        from: &Motion<S>,
        step: &Step<S>,
    ) -> Result<Option<Substep<S>>, Breakdown> {
        let at_beginning = margin(equations, &from.state);
        if at_beginning <= 0.0 {
            return Ok(Some(stuck_until(equations, 0.0, &from.state, Ending::Released)));
        }
        check(equations, &step.next)?;
        let at_end = margin(equations, &step.next);
        if at_end > 0.0 {
            return Ok(Some(stuck_until(equations, self.length, &step.next, Ending::Completed)));
        }
        let late = self.length;
        let mut search = FalsePosition::new((0.0, at_beginning), (late, at_end), 1e-15 * late);
        if let Some(length) = search.next_point() {
            *self = Self { length, aim: Aim::Release { search, state: step.next } };
            return Ok(None);
        }
        Ok(Some(stuck_until(equations, late, &step.next, Ending::Released)))
    }
}

/// The end of a substep of slip at which the pad has come to the disc's speed after a `time`.
fn meeting<E: Equations>(
    equations: &E,
    from: &Motion<E::State>,
    time: f64,
    state: &E::State,
    acceleration: f64,
) -> Substep<E::State> {
    let comes_from_slip = Relative::new(equations, from.contact).sliding(&from.state) > 0.0;
    let state = equations.moving_with_disc(state);
    let acceleration = (acceleration, equations.acceleration(&state, from.contact));
    let reserve = equations.reserve(&state);
    let (contact, ending) = if reserve.against_slip >= 0.0 && reserve.against_overtaking >= 0.0 {
        (ContactState::Stick, Ending::Stuck)
    } else if reserve.against_overtaking < 0.0 {
        (ContactState::Overtaking, Ending::Overtaken)
    } else {
        (ContactState::Slip, Ending::Overtaken)
    };
    let slowest = equations.friction_steps().grazing_rate * equations.meeting_rate();
    let held = 0.5 * (reserve.against_slip + reserve.against_overtaking);
    let is_close = |reserve: f64| reserve.abs() < equations.friction_steps().grazing_reserve * held;
    let barely_holds = is_close(reserve.against_slip) || is_close(reserve.against_overtaking);
    let grazes = comes_from_slip && (acceleration.1.abs() < slowest || barely_holds);
    Substep { time, end: Motion { state, contact }, acceleration, ending, grazes, is_caught: false, growth: 1.0 }
}

/// The end of a substep of stick after a `time`.
fn stuck_until<E: Equations>(equations: &E, time: f64, state: &E::State, ending: Ending) -> Substep<E::State> {
    let contact = match ending {
        Ending::Released => {
            let reserve = equations.reserve(state);
            let slips = reserve.against_slip < reserve.against_overtaking;
            if slips { ContactState::Slip } else { ContactState::Overtaking }
        }
        _ => ContactState::Stick,
    };
    let end = Motion { state: *state, contact };
    Substep { time, end, acceleration: (0.0, 0.0), ending, grazes: false, is_caught: false, growth: MOST_GROWTH }
}

/// How far static friction is from letting go of a pad that moves with the disc.
fn margin<E: Equations>(equations: &E, state: &E::State) -> f64 {
    let reserve = equations.reserve(state);
    reserve.against_slip.min(reserve.against_overtaking)
}

/// Whether a state is one of a brake.
#[inline]
pub(crate) fn check<E: Equations>(equations: &E, state: &E::State) -> Result<(), Breakdown> {
    let (x, u) = equations.tangential(state);
    if x.abs() < FARTHEST && u.is_finite() { Ok(()) } else { Err(Breakdown) }
}

/// The motion against the disc, in the direction of the state of contact.
struct Relative<'a, E> {
    equations: &'a E,
    contact: ContactState,
    direction: f64,
}

impl<'a, E: Equations> Relative<'a, E> {
    #[inline]
    fn new(equations: &'a E, contact: ContactState) -> Self {
        Self { equations, contact, direction: if contact == ContactState::Slip { 1.0 } else { -1.0 } }
    }

    /// The sliding speed.
    #[inline]
    fn sliding(&self, state: &E::State) -> f64 {
        self.direction * (self.equations.disc_speed() - self.equations.tangential(state).1)
    }

    /// The lowest point of the sliding speed inside a step, or a point on the way there that is not above zero.
    fn least_sliding(&self, from: &E::State, h: f64) -> (f64, E::State) {
        let (mut early, mut late) = (0.0, h);
        let mut nearest = (0.0, *from);
        for _ in 0..60 {
            let middle = 0.5 * (early + late);
            let state = self.equations.step(from, self.contact, middle).next;
            nearest = (middle, state);
            if self.sliding(&state) <= 0.0 {
                break;
            }
            // Whether the sliding speed still falls there.
            if self.direction * self.equations.acceleration(&state, self.contact) > 0.0 {
                early = middle;
            } else {
                late = middle;
            }
        }
        nearest
    }
}
