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
//! The rational law has the length `s = 0.6 (1 + r)` with `e = 1`, and the slope `G (f_s - f_c) / (v_s (1 + r)^2)`. A viscous term
//! is a damping rate; the length of a step times it is at most 1.
//!
//! A measured curve has a continuous slope, but its second derivative jumps at the rows. A step that crosses a jump J of
//! `G d^2 mu / d v^2` changes the speed wrongly by at most `0.0027 h J (h x'')^2`: the error of Simpson's rule for a
//! parabola that begins inside the step. So
//!
//! ```text
//! bends      h B (h x'')^2  <=  1e-3 v
//! intervals  a step begins and ends at most two intervals apart
//! feedback   h G |d mu / d v|  <=  0.4
//! ```
//!
//! with the largest variation B of the second derivative over an interval, its ends included, and the steepest slope, over
//! the intervals of both ends of the step and their neighbours. With these limits the saddle-node of the rational law, of
//! viscous friction and of measured curves is right to 2e-5, as the tests check; most of that is an error of the plain
//! step, which Tustin's law has too where the disc is some ten times faster than v_s.
//!
//! Both limits are checked after a step, with the speeds and accelerations at its ends. A plain step has these anyway,
//! so lanes find out by a few comparisons which steps are too long, and leave those to the scalar code.

use crate::friction::law::FrictionLaw;
use crate::friction::measured_curve::SharedCurve;
use crate::friction::shape::Shape;
use crate::pad::equations::PadEquations;
use crate::rigid_disc::pad_on_disc::RandomInputs;

/// Largest change of `p` where friction has not fallen yet, and largest growth of a disturbance, in one step.
///
/// Measured together, see the tests: the saddle-node of stick-slip is where the adaptive reference finds it, to 1e-5,
/// for disc speeds up to 1000 Stribeck velocities.
const RESOLUTION: f64 = 0.25;
const FEEDBACK: f64 = 0.4;

/// The rational law bends more than the exponential at the same slope: the share of [`RESOLUTION`] that it is allowed.
const RATIONAL: f64 = 0.6;

/// Largest change of `r` in one step over `r` itself where derivatives of the law grow without bound at rest, and the
/// sliding speed at which that ends.
const NEAR_REST: f64 = 0.3;
const FLOOR: f64 = 1e-5;

/// Largest error of the speed that the bends of a measured curve may cause in one step, over the disc's speed and 0.0027,
/// and most intervals that a step may begin and end apart.
const BEND: f64 = 1e-3;
const MOST_INTERVALS: usize = 2;

/// Length of any step times the highest damping rate: the method is stable up to 2.8.
pub(crate) const DAMPED_STEP: f64 = 1.0;

/// The limits that a friction law sets to the steps that integrate it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FrictionSteps {
    disc_speed: f64,
    inverse_stribeck: f64,
    shape: Shape,
    exponent: f64,
    /// `G (f_s - f_c) / v_s`, per unit of scaled time.
    feedback: f64,
    /// `G e / v_s`: the damping by a viscous term.
    additional: f64,
    resolution_limit: f64,
    feedback_limit: f64,
    bend_limit: f64,
}

impl FrictionSteps {
    /// For friction that changes the acceleration by `falling_pull` between rest and high sliding speed, and an
    /// additional term of the size `additional_pull`.
    ///
    /// `refinement` is 1; smaller in studies of convergence, where it multiplies the limits.
    #[inline(always)]
    pub fn new(
        disc_speed: f64,
        inverse_stribeck: f64,
        (shape, exponent): (Shape, f64),
        (falling_pull, additional_pull): (f64, f64),
        refinement: f64,
    ) -> Self {
        Self {
            disc_speed,
            inverse_stribeck,
            shape,
            exponent,
            feedback: falling_pull * inverse_stribeck,
            additional: additional_pull * inverse_stribeck,
            resolution_limit: refinement * RESOLUTION,
            feedback_limit: refinement * FEEDBACK,
            // The product that it limits goes with the cube of the step.
            bend_limit: refinement * refinement * refinement * BEND * disc_speed * inverse_stribeck,
        }
    }

    /// For a pad on a disc that yields, with the contact force on a rigid disc, which no motion exceeds by much.
    pub fn of_pad(pad: &PadEquations, inputs: RandomInputs, refinement: f64) -> Self {
        let law = (pad.friction_shape, pad.stribeck_exponent);
        Self::new(pad.disc_speed, pad.inverse_stribeck, law, Self::pulls_of_pad(pad, inputs), refinement)
    }

    /// By how much friction changes the acceleration of a pad on a disc that yields, see [`FrictionSteps::new`].
    pub fn pulls_of_pad(pad: &PadEquations, inputs: RandomInputs) -> (f64, f64) {
        let gain = pad.friction_per_preload * inputs.preload;
        (gain * (inputs.static_friction - pad.kinetic_friction).max(0.0), gain * pad.additional_friction)
    }

    /// Whether a step of length `h` with the speeds `u` and accelerations at its ends is too long.
    pub fn is_too_long(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> bool {
        match self.shape {
            Shape::Tustin => self.is_too_long_for_tustin(u, acceleration, h),
            _ => self.excess(u, acceleration, h) > 1.0,
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
            | (h * self.additional > DAMPED_STEP)
    }

    /// The limits of resolution and feedback for the exponent 1, at `p` = r.
    #[inline(always)]
    fn limits_for_tustin(&self, p: f64) -> (f64, f64) {
        (self.resolution_limit * widening(p), self.feedback_limit * growth(p))
    }

    /// False only if [`FrictionSteps::is_too_long`] is false, and without a branch that depends on the motion: for
    /// lanes, which leave the steps of which it is true to the scalar code. It is exact but for Stribeck's law with an
    /// exponent other than 1.
    #[inline(always)]
    pub fn may_be_too_long(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> bool {
        match self.shape {
            Shape::Tustin => self.is_too_long_for_tustin(u, acceleration, h),
            Shape::Gaussian | Shape::Stribeck => self.may_be_too_long_for_stribeck(u, acceleration, h),
            Shape::Rational => self.excess_for_rational(u, acceleration, h) > 1.0,
            Shape::Table(curve) => self.excess_for_table(curve, u, acceleration, h) > 1.0,
        }
    }

    /// Without a power: below r = 1 the length s is at least `1 / delta` or r, and `s e` at least `0.48 r / delta`
    /// everywhere; the slope of `exp(-p)` is at most `delta / (e r)`.
    #[inline(always)]
    fn may_be_too_long_for_stribeck(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> bool {
        let (delta, least) = (self.exponent, self.least_sliding(u));
        let r = if least > FLOOR { least } else { FLOOR };
        let inside = if delta > 1.0 { 1.0 } else { r };
        let length = (if r < 1.0 { inside } else { 0.48 * r }) / delta;
        let resolution = self.resolution_limit * length;
        let near_rest = self.resolution_limit * (NEAR_REST / RESOLUTION) * r;
        let resolution = if resolution < near_rest { resolution } else { near_rest };
        let per_acceleration = h * self.inverse_stribeck;
        (per_acceleration * acceleration.0.abs() > resolution)
            | (per_acceleration * acceleration.1.abs() > resolution)
            | (h * self.feedback * (0.368 * delta) > self.feedback_limit * r)
            | (h * self.additional > DAMPED_STEP)
    }

    /// By how much a step is too long: its length over what the limits allow.
    pub fn excess(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        match self.shape {
            Shape::Tustin => {
                let (resolution, feedback) = self.limits_for_tustin(self.least_sliding(u));
                let change = h * larger(acceleration) * self.inverse_stribeck;
                (change / resolution).max(h * self.feedback / feedback).max(h * self.additional / DAMPED_STEP)
            }
            Shape::Gaussian | Shape::Stribeck => self.excess_for_stribeck(u, acceleration, h),
            Shape::Rational => self.excess_for_rational(u, acceleration, h),
            Shape::Table(curve) => self.excess_for_table(curve, u, acceleration, h),
        }
    }

    fn excess_for_stribeck(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let change = h * larger(acceleration) * self.inverse_stribeck;
        let delta = self.exponent;
        let r = self.least_sliding(u).max(FLOOR);
        let p = libm::pow(r, delta);
        let length = if delta > 1.0 && r < 1.0 { 1.0 } else { r / p } / delta;
        let resolution =
            (self.resolution_limit * widening(p) * length).min(self.resolution_limit / RESOLUTION * NEAR_REST * r);
        // The law is steepest at the crest of its slope, or at the end of the step that is nearer to it.
        let most = ((self.disc_speed - u.0).abs().max((self.disc_speed - u.1).abs()) * self.inverse_stribeck).max(r);
        let law = FrictionLaw::stribeck(1.0, 0.0, 1.0, delta);
        let slope = self.feedback * law.weakening(law.steepest_between(r, most));
        (change / resolution).max(h * slope / self.feedback_limit).max(h * self.additional / DAMPED_STEP)
    }

    /// `1 / (1 + r)` has the length `1 + r`, and its slope falls with its square.
    #[inline(always)]
    fn excess_for_rational(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let length = 1.0 + self.least_sliding(u);
        let change = h * larger(acceleration) * self.inverse_stribeck;
        let by_resolution = change / (RATIONAL * self.resolution_limit * length);
        let by_feedback = h * self.feedback / (self.feedback_limit * length * length);
        larger((larger((by_resolution, by_feedback)), h * self.additional / DAMPED_STEP))
    }

    #[inline(always)]
    fn excess_for_table(&self, curve: SharedCurve, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let place = |u: f64| curve.interval((self.disc_speed - u).abs() * self.inverse_stribeck);
        let intervals = (place(u.0), place(u.1));
        let (first, second) = (curve.window(intervals.0), curve.window(intervals.1));
        let of = |parts: (f64, f64)| self.feedback.abs() * parts.0 + self.additional.abs() * parts.1;
        let steepest = larger((of(first.steepest), of(second.steepest)));
        let bend = larger((of(first.bend), of(second.bend)));
        let change = h * larger(acceleration) * self.inverse_stribeck;
        // The error goes with the cube of the step; what is asked for is the ratio of lengths, for which a bound is enough.
        let by_bend = h * bend * change * change / self.bend_limit;
        let crossed = intervals.0.abs_diff(intervals.1);
        let by_intervals = if crossed > MOST_INTERVALS { crossed as f64 / MOST_INTERVALS as f64 } else { 0.0 };
        let by_bend = if by_bend > 1.0 { libm::cbrt(by_bend) } else { by_bend };
        larger((larger((by_bend, by_intervals)), h * steepest / self.feedback_limit))
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

/// The larger of two absolute values.
#[inline(always)]
fn larger((first, second): (f64, f64)) -> f64 {
    let (first, second) = (first.abs(), second.abs());
    if first > second { first } else { second }
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
