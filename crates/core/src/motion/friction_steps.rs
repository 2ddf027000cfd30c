//! How long a step may be where friction is steep.
//!
//! A step of a tenth over the natural frequency resolves the springs. It does not resolve the friction law where the
//! disc is much faster than the Stribeck velocity: there friction rises only within a few `v_s` of sticking, and a pad
//! passes that range in a fraction of such a step. So two limits may divide a step. With the sliding speed `r = |v -
//! x'| / v_s` and `p = r^delta`, friction above its kinetic value is proportional to `exp(-p)`:
//!
//! ```text
//! resolution   h |x''| / v_s  <=  0.25 e(p) s(r)      e(p) = 1 + p/5 + p^2/50 <= exp(p/5)
//! feedback     h lambda(r)    <=  0.4                 lambda(r) = G (f_s - f_c) |d exp(-p) / dv|
//! ```
//!
//! *Resolution*: `r` may change by a part of the length `s` over which `p` changes by one. The error of a fourth-order
//! step is proportional to `exp(-p) (change of p)^5`, so at equal error the change may grow as `exp(p/5)`; where
//! friction has fallen to nothing, nothing limits the step. *Feedback*: near sticking the falling friction drives the
//! pad away at the rate `lambda`, which steps have to resolve even while nothing moves much yet.
//!
//! | exponent | s(r) | why |
//! |---|---|---|
//! | 1 | 1 | the law has one length, v_s |
//! | above 1 | `1 / delta` below r = 1, `r^(1 - delta) / delta` above, at most `1.2 r` | at rest its second derivative may be infinite |
//! | below 1 | `r^(1 - delta) / delta`, at most `1.2 r` | at rest its slope is infinite |
//!
//! Below `r = 1e-5` steps shrink no further: there the law changes no speed by more than `1e-5 v_s`.
//!
//! Both limits are checked after a step, with the speeds and accelerations at its ends. A plain step has these anyway,
//! so lanes find out by a few comparisons which steps are too long, and leave those to the scalar code.

use crate::friction::StribeckLaw;
use crate::pad::equations::PadEquations;
use crate::rigid_disc::pad_on_disc::RandomInputs;

/// Largest change of `p` where friction has not fallen yet, and largest growth of a disturbance, in one step.
///
/// Measured together, see the tests: the saddle-node of stick-slip is where the adaptive reference finds it, to 1e-5,
/// for disc speeds up to 1000 Stribeck velocities.
const RESOLUTION: f64 = 0.25;
const FEEDBACK: f64 = 0.4;

/// Largest change of `r` in one step over `r` itself where derivatives of the law grow without bound at rest, and the
/// sliding speed at which that ends.
const NEAR_REST: f64 = 0.3;
const FLOOR: f64 = 1e-5;

/// Length of any step times the highest damping rate: the method is stable up to 2.8.
pub(crate) const DAMPED_STEP: f64 = 1.0;

/// The limits that a friction law sets to the steps that integrate it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrictionSteps {
    disc_speed: f64,
    inverse_stribeck: f64,
    exponent: f64,
    /// `G (f_s - f_c) / v_s`, per unit of scaled time.
    feedback: f64,
    resolution_limit: f64,
    feedback_limit: f64,
}

impl FrictionSteps {
    /// For friction that changes the acceleration by `falling_pull` between rest and high sliding speed.
    ///
    /// `refinement` is 1; smaller in studies of convergence, where it multiplies the limits.
    #[inline(always)]
    pub fn new(disc_speed: f64, inverse_stribeck: f64, exponent: f64, falling_pull: f64, refinement: f64) -> Self {
        Self {
            disc_speed,
            inverse_stribeck,
            exponent,
            feedback: falling_pull * inverse_stribeck,
            resolution_limit: refinement * RESOLUTION,
            feedback_limit: refinement * FEEDBACK,
        }
    }

    /// For a pad on a disc that yields, with the contact force on a rigid disc, which no motion exceeds by much.
    pub fn of_pad(pad: &PadEquations, inputs: RandomInputs, refinement: f64) -> Self {
        let falling_pull = Self::falling_pull(pad, inputs);
        Self::new(pad.disc_speed, pad.inverse_stribeck, pad.stribeck_exponent, falling_pull, refinement)
    }

    /// By how much friction changes the acceleration of a pad on a disc that yields, see [`FrictionSteps::new`].
    pub fn falling_pull(pad: &PadEquations, inputs: RandomInputs) -> f64 {
        let gain = pad.friction_per_preload * inputs.preload;
        gain * (inputs.static_friction - pad.kinetic_friction).max(0.0)
    }

    /// Whether a step of length `h` with the speeds `u` and accelerations at its ends is too long.
    pub fn is_too_long(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> bool {
        if self.exponent == 1.0 {
            self.is_too_long_for_tustin(u, acceleration, h)
        } else {
            self.excess(u, acceleration, h) > 1.0
        }
    }

    /// [`FrictionSteps::is_too_long`] for the exponent 1, without a branch.
    #[inline(always)]
    pub fn is_too_long_for_tustin(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> bool {
        let (resolution, feedback) = self.limits_for_tustin(self.least_sliding(u));
        let per_acceleration = h * self.inverse_stribeck;
        (per_acceleration * acceleration.0.abs() > resolution)
            | (per_acceleration * acceleration.1.abs() > resolution)
            | (h * self.feedback > feedback)
    }

    /// The limits of resolution and feedback for the exponent 1, at `p` = r.
    #[inline(always)]
    fn limits_for_tustin(&self, p: f64) -> (f64, f64) {
        (self.resolution_limit * widening(p), self.feedback_limit * growth(p))
    }

    /// By how much a step is too long: its length over what the limits allow.
    pub fn excess(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let fastest = acceleration.0.abs().max(acceleration.1.abs());
        let change = h * fastest * self.inverse_stribeck;
        let least = self.least_sliding(u);
        let delta = self.exponent;
        if delta == 1.0 {
            let (resolution, feedback) = self.limits_for_tustin(least);
            return (change / resolution).max(h * self.feedback / feedback);
        }
        let r = least.max(FLOOR);
        let p = libm::pow(r, delta);
        let length = if delta > 1.0 && r < 1.0 { 1.0 } else { r / p } / delta;
        let resolution =
            (self.resolution_limit * widening(p) * length).min(self.resolution_limit / RESOLUTION * NEAR_REST * r);
        // The law is steepest at the crest of its slope, or at the end of the step that is nearer to it.
        let most = ((self.disc_speed - u.0).abs().max((self.disc_speed - u.1).abs()) * self.inverse_stribeck).max(r);
        let law =
            StribeckLaw { static_coefficient: 1.0, kinetic_coefficient: 0.0, stribeck_velocity: 1.0, exponent: delta };
        let slope = self.feedback * law.weakening(law.steepest_between(r, most));
        (change / resolution).max(h * slope / self.feedback_limit)
    }

    /// The smallest sliding speed in a step over the Stribeck velocity; 0 where it passes through sticking.
    #[inline(always)]
    fn least_sliding(&self, u: (f64, f64)) -> f64 {
        let (first, last) = (self.disc_speed - u.0, self.disc_speed - u.1);
        let crosses = first * last <= 0.0;
        let (first, last) = (first.abs(), last.abs());
        let least = if first < last { first } else { last };
        if crosses { 0.0 } else { least * self.inverse_stribeck }
    }
}

/// The beginning of the series of `exp(p)`: for the exponent 1 the feedback has fallen by at least this factor.
#[inline(always)]
fn growth(p: f64) -> f64 {
    1.0 + p * (1.0 + p * (0.5 + p * (1.0 / 6.0 + p * (1.0 / 24.0))))
}

/// `e(p)`, how much more of a change is allowed where friction has fallen.
#[inline(always)]
fn widening(p: f64) -> f64 {
    1.0 + p * (0.2 + p * 0.02)
}

#[cfg(test)]
mod tests;
