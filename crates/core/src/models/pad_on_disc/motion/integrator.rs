//! What a motion with stick and slip is made of: equations that can be simulated, their steps, and who learns of
//! events.
//!
//! Stick and slip are states, not a smoothed sign function. In slip the pad moves under kinetic friction until the
//! sliding speed vanishes; in stick it moves with the disc until the friction that this takes exceeds what static
//! friction can give. Fixed Runge-Kutta steps ([`crate::models::pad_on_disc::motion::advance`]) consist of substeps, each in one state of
//! contact ([`crate::models::pad_on_disc::motion::substep`]); the moments at which pad and disc begin or cease to stick are located to the
//! last digits.

use crate::models::pad_on_disc::motion::friction_steps::FrictionSteps;
use crate::models::pad_on_disc::pad::contact_state::ContactState;

/// Displacements beyond this many disc thicknesses are no motion of a brake: the computation has broken down.
pub(crate) const FARTHEST: f64 = 1e3;

/// A system of equations that can be simulated.
pub(crate) trait Equations {
    /// Displacements and speeds.
    type State: Copy;

    /// The state after a time `h` (any part of a step) in one state of contact.
    fn step(&self, state: &Self::State, contact: ContactState, h: f64) -> Step<Self::State>;

    /// x'' in a state.
    fn acceleration(&self, state: &Self::State, contact: ContactState) -> f64 {
        self.step(state, contact, 0.0).acceleration.0
    }

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
    /// The same, also where they have not left each other since the release.
    fn holds(&mut self, _time: f64) {}
    /// They cease to.
    fn slips(&mut self, time: f64);
    /// Pad and disc pass each other at `x` without sticking, and are then in this state of contact.
    fn overtakes(&mut self, _x: f64, _then: ContactState) {}
    /// The pad comes so near the disc's speed, or meets it so slowly, that errors of the steps may decide whether they
    /// stick. If they do, this comes first.
    fn grazes(&mut self) {}
    /// The pad, at `x`, will surely reach the disc's speed at once, and stick. Not reported for laws that may rise just
    /// there.
    fn is_caught(&mut self, _x: f64) {}
}

/// The computation broke down: not a number, or farther away than any brake could go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Breakdown;

/// Why a motion is not simulated further.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stopped {
    BrokeDown,
    /// It took as many substeps as it may.
    Exhausted,
}

impl From<Breakdown> for Stopped {
    fn from(Breakdown: Breakdown) -> Self {
        Self::BrokeDown
    }
}

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
pub(crate) fn grazes_at_end(r: (f64, f64), disc_speed: f64, grazing_speed: f64) -> bool {
    (r.1 < grazing_speed * disc_speed) & (r.1 < r.0)
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

/// Whether the speed changes its sign between two moments.
#[inline(always)]
pub(crate) fn turns(u: f64, next: f64) -> bool {
    ((u > 0.0) & (next <= 0.0)) | ((u < 0.0) & (next >= 0.0))
}
