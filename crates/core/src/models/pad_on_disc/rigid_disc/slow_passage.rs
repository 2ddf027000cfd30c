//! Motions that come to the disc's speed, or pass it by, so slowly that errors of fixed steps decide which.
//!
//! Where friction falls steeply with the sliding speed `s = v - u`, at more than the damping takes, the line
//!
//! ```text
//! K x = p(s),      p(s) = G mu(s) - C (v - s)
//! ```
//!
//! on which the forces on the pad balance repels: a motion close to it stays there for a while, then departs towards the
//! disc's speed or away from it, and a small error decides where to. On it x grows and s falls, up to the release. The
//! orbit that stays on it to the end is the one that just touches the disc's speed, at the end of stick-slip. Its
//! neighbours depart from the line at any s at which it repels, not only next to the disc's speed.
//!
//! The line repels at the rate `G |d mu / ds| - C`. Let s be the largest sliding speed below v at which that rate
//! exceeds [`REPELS`] times the natural frequency, and `x(s)` the least x of the line up to there. A motion that departed
//! towards the disc meets it at `x >= x(s)`. One that departed away from it was as fast as `v - s` at `x >= x(s)`, and
//! its next turning point is as far out at least as its energy then carries it: against the least friction up to the
//! speed v, and a damper that takes no more than `C (v - s)` times the distance.

use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, SlipEnd};
use crate::numerics::root_location::bisect;

/// A rate over the natural frequency at which disturbances grow so little, while a motion passes, that the errors of
/// fixed steps stay as small as they are elsewhere.
const REPELS: f64 = 1.0;

/// How close the largest such sliding speed is located.
const LOCATED: f64 = 1e-2;

/// Where motions are that may have followed the repelling line.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SlowPassage {
    /// The least x at which they meet the disc's speed.
    meeting: f64,
    /// The least x at which those turn that do not.
    top: f64,
}

impl PlanarMotion {
    /// Whether a motion that meets the disc's speed at `x` may have followed the repelling line.
    pub fn meets_slowly(&self, x: f64) -> bool {
        self.slow_passage().is_some_and(|passage| x >= passage.meeting)
    }

    /// Whether a motion that turns at `x`, its largest in a swing, may have followed the repelling line.
    pub fn passes_slowly(&self, x: f64) -> bool {
        self.slow_passage().is_some_and(|passage| x >= passage.top)
    }

    /// How the first swing of a motion in a state of slip ends.
    pub fn first_swing_from(&self, state: [f64; 2]) -> SlipEnd {
        let size = (state[0] - self.equilibrium()).abs().max(self.disc_speed / self.stiffness.sqrt());
        let first = self.slip(state, size);
        if first.end == SlipEnd::Turned { self.slip([first.x, 0.0], size).end } else { first.end }
    }

    fn slow_passage(&self) -> Option<SlowPassage> {
        let (v, k) = (self.disc_speed, self.stiffness);
        let steep = self.damping + REPELS * k.sqrt();
        let (sliding, pull) = self.law.last_steeper_than(steep, v, |bracket| {
            bisect(bracket, 50, LOCATED, |sliding| self.law.fall(sliding) > steep).1
        })?;
        let meeting = (pull - self.damping * v) / k;
        let (speed, from) = (v - sliding, meeting - self.equilibrium());
        let drag = self.damping * speed / k;
        // From x(s) on, with the energy there; below steady sliding it cannot turn before that.
        let turning = (drag * drag + from * from + 2.0 * drag * from + speed * speed / k).max(0.0).sqrt() - drag;
        Some(SlowPassage { meeting, top: self.equilibrium() + turning.max(from) })
    }
}
