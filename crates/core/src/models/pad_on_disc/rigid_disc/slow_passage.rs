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
//! and before, while a motion approaches the line at s as a free pad does, by the exponential of `r(s)` times the root of
//! `2 (s_0 - s) / (K v)` at most, which is added to E. A motion within the errors of the steps, [`ERROR`] times v, of the
//! orbit that stays on the line is still on it as long as the distance grows to less than s, `E < ln(s / (ERROR v))`. It
//! departs further down the line. Then it meets the disc's speed farther out than the line is there, or turns farther out
//! than the motion through that place of the line, since orbits do not cross.
//!
//! The bounds of errors are estimates. What they give was tested on both sides of the end of stick-slip, see
//! docs/methods.md.

use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, SlipEnd, last_swing};
use crate::numerics::dormand_prince;
use crate::numerics::root_location::bisect;

/// A rate over the natural frequency at which disturbances grow so little, while a motion passes, that the errors of
/// fixed steps stay as small as they are elsewhere.
const REPELS: f64 = 1.0;

/// How close the largest such sliding speed is located, relative to itself.
const LOCATED: f64 = 1e-2;

/// Bounds of the errors over the disc's speed, with a margin: of fixed steps, and of a rough simulation.
const ERROR: f64 = 2e-5;
const ROUGH_ERROR: f64 = 1e-7;

/// The disc's speed over `s_0` above which fixed steps are not accurate enough to say what is in doubt; some thousand
/// Stribeck velocities.
const NARROW: f64 = 500.0;

/// Points of the integral over the line.
const POINTS: u32 = 16;

/// Local error of that simulation in one step, over its size: far below `s_0 / v`.
const ROUGH_TOP: f64 = 1e-7;

/// The share of a turning point's distance from steady sliding that a rough simulation may miss it by.
const ROUGH: f64 = 1e-3;

/// Largest number of steps of a rough simulation; some twenty are usual.
const MOST_ROUGH_STEPS: u32 = 1000;

/// The line along which a pad is repelled.
#[derive(Debug, Clone, Copy, PartialEq)]
struct RepellingLine {
    /// `s_0`.
    first: f64,
    /// The least `G mu` on it.
    least_pull: f64,
}

impl PlanarMotion {
    /// Whether a motion that meets the disc's speed at `x` may have followed the repelling line.
    pub fn meets_slowly(&self, x: f64) -> bool {
        self.repelling_line().is_some_and(|line| self.is_narrow(&line) || x >= self.departure(&line, ERROR)[0])
    }

    /// The same for a rough simulation.
    pub fn meets_slowly_if_rough(&self, x: f64) -> bool {
        self.repelling_line().is_some_and(|line| x >= self.departure(&line, ROUGH_ERROR)[0])
    }

    /// Whether a motion that turns at `x`, its largest in a swing, may have followed the repelling line.
    pub fn passes_slowly(&self, x: f64) -> bool {
        self.repelling_line()
            .is_some_and(|line| self.is_narrow(&line) || self.turns_beyond(self.departure(&line, ERROR), x))
    }

    /// Whether a motion that turns at `x` may be outside one from a state at `x'` > 0.
    fn turns_beyond(&self, state: [f64; 2], x: f64) -> bool {
        x >= self.least_top(state)
            && self.rough_top(state).is_none_or(|top| x >= top - ROUGH * (top - self.equilibrium()).abs())
    }

    /// A bound from below of where a motion turns from a state at `x'` > 0: without a table, friction is nowhere less than in
    /// steady sliding, and with that this is an oscillation, in which `Q = K d^2 + C d u + u^2` falls as `exp(-C t)`.
    fn least_top(&self, [x, u]: [f64; 2]) -> f64 {
        let (k, c, d) = (self.stiffness, self.damping, x - self.equilibrium());
        let square = k - 0.25 * c * c;
        if self.law.is_table() || square <= 0.0 {
            return x;
        }
        let frequency = square.sqrt();
        let time = libm::atan2(frequency * u, 0.5 * c * u + k * d) / frequency;
        let q = (k * d * d + c * d * u + u * u).max(0.0);
        self.equilibrium() + (q / k).sqrt() * libm::exp(-0.5 * c * time)
    }

    /// About where a motion from a state at `x'` > 0 turns, unless it meets the disc's speed or takes too many steps.
    fn rough_top(&self, from: [f64; 2]) -> Option<f64> {
        let (v, frequency, size) = (self.disc_speed, self.stiffness.sqrt(), self.size_of(from));
        let (mut state, mut h) = (from, 1e-2 / frequency);
        for _ in 0..MOST_ROUGH_STEPS {
            let (next, error) = self.step(state, h);
            let error = (error[0].abs() / size).max(error[1].abs() / (size * frequency)) / ROUGH_TOP;
            if error.is_nan() || next[1] >= v {
                return None;
            }
            if error > 1.0 {
                h *= dormand_prince::growth(error);
                continue;
            }
            if next[1] <= 0.0 {
                // Where its speed would vanish, if it changed evenly; x changes little there.
                return Some(self.step(state, h * state[1] / (state[1] - next[1])).0[0]);
            }
            state = next;
            h *= dormand_prince::growth(error);
        }
        None
    }

    /// Whether a motion in a state of slip is caught in one of its next `swings`, each to a turning point at the largest
    /// x; `None` if that is not resolved. Where a rough simulation is clear, it decides.
    pub fn is_caught_within(&self, swings: u32, state: [f64; 2]) -> Option<bool> {
        let size = self.size_of(state);
        if let Some(line) = self.repelling_line().filter(|line| !self.is_narrow(line)) {
            let rough = last_swing(swings, state, |state| self.rough_slip(state, size));
            let departure = self.departure(&line, ROUGH_ERROR);
            let is_clear = match rough.end {
                SlipEnd::Captured => rough.x < departure[0] && self.is_clear_capture(&rough, size),
                SlipEnd::Turned => !self.turns_beyond(departure, rough.x),
                SlipEnd::Equilibrium | SlipEnd::Unresolved => false,
            };
            if is_clear {
                return Some(rough.end == SlipEnd::Captured);
            }
        }
        match last_swing(swings, state, |state| self.slip(state, size)).end {
            SlipEnd::Captured => Some(true),
            SlipEnd::Turned | SlipEnd::Equilibrium => Some(false),
            SlipEnd::Unresolved => None,
        }
    }

    /// Whether fixed steps do not resolve the line.
    fn is_narrow(&self, line: &RepellingLine) -> bool {
        self.disc_speed > NARROW * line.first
    }

    fn repelling_line(&self) -> Option<RepellingLine> {
        let steep = self.damping + REPELS * self.stiffness.sqrt();
        let (first, least_pull) = self.law.last_steeper_than(steep, self.disc_speed, |bracket| {
            bisect(bracket, 50, LOCATED, |sliding| self.law.fall(sliding) > steep).1
        })?;
        Some(RepellingLine { first, least_pull })
    }

    /// The state on the line, x and x', up to which no motion departs from it that errors of this size, over the disc's speed,
    /// may have put there.
    fn departure(&self, line: &RepellingLine, error: f64) -> [f64; 2] {
        let (v, k, first) = (self.disc_speed, self.stiffness, line.first);
        // In the root of s, as the rate may grow like its inverse; to the end of each part from its middle.
        let part = 1.0 / f64::from(POINTS);
        let (mut growth, mut departs) = (0.0, 0.0);
        for i in 0..POINTS {
            let root = 1.0 - (f64::from(i) + 0.5) * part;
            let sliding = first * root * root;
            let rate = (self.law.fall(sliding) - self.damping).max(0.0);
            growth += rate * rate * 2.0 * first * root * part / (k * (v - sliding).max(error * v));
            let approach = rate * (2.0 * (first - sliding) / (k * v)).sqrt();
            // At the beginning of the part in which errors have grown enough, at the latest of the last one.
            departs = first * (root + 0.5 * part) * (root + 0.5 * part);
            if growth + approach >= libm::log(sliding / (error * v)) {
                break;
            }
        }
        let (pull, speed) = if self.law.is_table() {
            (line.least_pull - self.damping * first, v - first)
        } else {
            (self.law.coefficient(departs), v - departs)
        };
        [(pull - self.damping * speed) / k, speed]
    }
}
