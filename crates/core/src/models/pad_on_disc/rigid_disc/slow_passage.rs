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
//! The line repels at the rate `r(s) = G |d mu / ds| - C`, which is also how K x rises with falling s along it. So from
//! `s_0`, the largest sliding speed below v at which that rate exceeds [`REPELS`] times the natural frequency, down to s
//! disturbances grow by `exp(E)`,
//!
//! ```text
//! E(s) = integral from s to s_0 of r(s)^2 / [K (v - s)] ds
//! ```
//!
//! and before, while a motion approaches the line at s as a free pad does, by `r(s)` times the root of `2 (s_0 - s) / (K v)` at
//! most, which is added. A motion within the errors of the steps, [`ERROR`] times v, of the orbit that stays on the line is still on it as long as
//! the distance grows to less than s, `E < ln(s / (ERROR v))`. It departs further down the line. Then it meets the disc's
//! speed farther out than the line is there, or turns farther out than a motion that leaves that place at `v - s_0`.

use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, SlipEnd};
use crate::numerics::root_location::bisect;

/// A rate over the natural frequency at which disturbances grow so little, while a motion passes, that the errors of
/// fixed steps stay as small as they are elsewhere.
const REPELS: f64 = 1.0;

/// How close the largest such sliding speed is located, relative to itself.
const LOCATED: f64 = 1e-2;

/// A bound of the errors of fixed steps over the disc's speed, with a margin of ten.
const ERROR: f64 = 1e-4;

/// Points of the integral over the line.
const POINTS: u32 = 16;

/// The share of a turning point's distance from steady sliding that a rough simulation may miss it by.
const ROUGH: f64 = 1e-4;

/// Where motions are that may be as near the orbit that stays on the repelling line as errors are.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SlowPassage {
    /// The least x at which they meet the disc's speed.
    meeting: f64,
    /// The pad's speed at which those have that x or more that do not meet it.
    speed: f64,
}

impl PlanarMotion {
    /// Whether a motion that meets the disc's speed at `x` may have followed the repelling line.
    pub fn meets_slowly(&self, x: f64) -> bool {
        self.slow_passage().is_some_and(|passage| x >= passage.meeting)
    }

    /// Whether a motion that turns at `x`, its largest in a swing, may have followed the repelling line.
    pub fn passes_slowly(&self, x: f64) -> bool {
        let Some(SlowPassage { meeting, speed }) = self.slow_passage() else { return false };
        // It turns as far out at least as its energy carries it, against the friction of steady sliding and a damper that
        // takes no more than at this speed.
        let (from, drag) = (meeting - self.equilibrium(), self.damping * speed / self.stiffness);
        let energy = (from + drag) * (from + drag) + speed * speed / self.stiffness;
        let is_near = self.law.is_table() || x - self.equilibrium() >= energy.sqrt() - drag;
        if x < meeting || !is_near {
            return false;
        }
        let (size, state) = (self.size_of([meeting, speed]), [meeting, speed]);
        let slip = self.rough_slip(state, size);
        slip.end != SlipEnd::Turned || x >= slip.x - ROUGH * (slip.x - self.equilibrium()).abs()
    }

    /// Whether a motion in a state of slip is caught in one of its next `swings`, each to a turning point at the largest
    /// x; `None` if that is not resolved.
    pub fn is_caught_within(&self, swings: u32, state: [f64; 2]) -> Option<bool> {
        let size = self.size_of(state);
        let mut state = state;
        for _ in 0..swings {
            let slip = self.slip(state, size);
            match slip.end {
                SlipEnd::Turned => state = [slip.x, 0.0],
                SlipEnd::Captured => return Some(true),
                SlipEnd::Equilibrium => return Some(false),
                SlipEnd::Unresolved => return None,
            }
        }
        Some(false)
    }

    fn slow_passage(&self) -> Option<SlowPassage> {
        let (v, k) = (self.disc_speed, self.stiffness);
        let steep = self.damping + REPELS * k.sqrt();
        let (first, least_pull) = self.law.last_steeper_than(steep, v, |bracket| {
            bisect(bracket, 50, LOCATED, |sliding| self.law.fall(sliding) > steep).1
        })?;
        // In the root of s, as the rate may grow like its inverse; to the end of each part from its middle.
        let part = 1.0 / f64::from(POINTS);
        let mut growth = 0.0;
        for i in 0..POINTS {
            let root = 1.0 - (f64::from(i) + 0.5) * part;
            let sliding = first * root * root;
            let rate = (self.law.fall(sliding) - self.damping).max(0.0);
            growth += rate * rate * 2.0 * first * root * part / (k * (v - sliding).max(ERROR * v));
            let approach = rate * (2.0 * (first - sliding) / (k * v)).sqrt();
            if growth + approach >= libm::log(sliding / (ERROR * v)) {
                // From the beginning of this part on.
                let begin = first * (root + 0.5 * part) * (root + 0.5 * part);
                let pull = if self.law.is_table() { least_pull } else { self.law.coefficient(begin) };
                return Some(SlowPassage { meeting: (pull - self.damping * v) / k, speed: v - first });
            }
        }
        None
    }
}
