//! How long a step may be where friction is steep.
//!
//! A step of a tenth over the natural frequency resolves the springs. It does not resolve the friction law where the
//! disc is much faster than the Stribeck velocity: there friction rises only within a few `v_s` of sticking, and a pad
//! passes that range in a fraction of such a step. So two limits may divide a step. With the sliding speed `r = |v -
//! x'| / v_s` and `p = r^delta`, friction above its kinetic value is proportional to `exp(-p)`:
//!
//! ```text
//! resolution   h |x''| / v_s  <=  0.5 e(p) s(r)       e(p) = 1 + p/5 + ... + (p/5)^4/24 <= exp(p/5)
//! feedback     h lambda(r)    <=  0.4                 lambda(r) >= G (f_s - f_c) |d exp(-p) / dv|
//! ```
//!
//! *Resolution*: `r` may change by a part of the length `s` over which `p` changes by one. The error of a fourth-order
//! step is proportional to `exp(-p) (change of p)^5`, so at equal error the change may grow as `exp(p/5)`; where
//! friction has fallen to nothing, nothing limits the step. *Feedback*: near sticking the falling friction drives the
//! pad away at the rate `lambda`, which steps have to resolve even while nothing moves much yet. It is bounded by
//! the slope with `1 + p + ... + p^4/24` in place of `exp(p)`, and by the steepest slope of the law.
//!
//! | exponent | s(r) |
//! |---|---|
//! | 1 | 1, with 0.25 in place of 0.5 and e(p) up to its square: the law has one length, v_s |
//! | above 1 | `1 / delta` below r = 1, `r^(1 - delta) / delta` above |
//! | below 1 | `r^(1 - delta) / delta` |
//!
//! At rest a derivative of the law is infinite, the second one for exponents between 1 and 2, the first one below 1. So
//! for exponents below 2 a step may also change r by no more than `0.75 r`, unless, for exponents from 1 to 2, the fall
//! of friction below its value at rest changes the pad's speed by less than `5e-4 v` within it,
//!
//! ```text
//! near rest    h |x''| / v_s  <=  0.75 r   or    h G (f_s - f_c) p  <=  5e-4 v     at the end that slides faster
//! ```
//!
//! because the error of a step across rest is at most 0.0027 of that change: Simpson's rule for `r^delta`. For
//! exponents below 1 the limits end at `r = 1e-5`, where the law changes no speed by more than `1e-5 v_s`.
//!
//! In these limits powers are computed to 10 %, by fewer operations than friction itself. They decide the lengths of
//! steps, so they have the same bits everywhere.
//!
//! The rational law has the length `s = 0.6 (1 + r)` with 0.25 and `e = 1`, and the slope `G (f_s - f_c) / (v_s (1 +
//! r)^2)`. A viscous term is a damping rate; the length of a step times it is at most 1.
//!
//! A measured curve has a continuous slope, but its second derivative jumps at the rows. A step that crosses a jump J
//! of `G d^2 mu / d v^2` changes the speed wrongly by at most `0.0027 h J (h x'')^2`: the error of Simpson's rule for a
//! parabola that begins inside the step. So
//!
//! ```text
//! bends      h B (h x'')^2  <=  1e-3 v
//! intervals  a step begins and ends at most two intervals apart
//! feedback   h G |d mu / d v|  <=  0.4
//! ```
//!
//! with the largest variation B of the second derivative over an interval, its ends included, and the steepest slope,
//! over the intervals of both ends of the step and their neighbours. With these limits the saddle-node of the rational
//! law, of viscous friction and of measured curves is right to 2e-5, as the tests check; most of that is an error of
//! the plain step, which Tustin's law has too where the disc is some ten times faster than v_s.
//!
//! The limits are checked after a step, with the speeds and accelerations at its ends. A plain step has these anyway,
//! so lanes find out by a few operations which steps are too long, and by how much.

use crate::friction::measured_curve::SharedCurve;
use crate::friction::shape::Shape;
use crate::models::pad_on_disc::pad::equations::PadEquations;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::numerics::logarithm::rough_power;
use crate::numerics::row::numbers;

/// Largest change of `p` where friction has not fallen yet, and largest growth of a disturbance, in one step.
///
/// Measured together, see the tests: the saddle-node of stick-slip is where the adaptive reference finds it, to 1e-5,
/// for disc speeds of ten to 1000 Stribeck velocities.
const RESOLUTION: f64 = 0.25;
const FEEDBACK: f64 = 0.4;

/// How many times [`RESOLUTION`] other laws are allowed. The rational law bends more than the exponential at the same
/// slope. Stribeck's law with another exponent is as accurate with longer steps near rest, because e(p) follows
/// `exp(p/5)` to higher p.
const RATIONAL: f64 = 0.6;
const STRIBECK: f64 = 2.0;

/// Where `exp(-p)` is nothing.
const DEAD: f64 = 1e30;

/// Largest change of `r` in one step over `r` itself where derivatives of the law grow without bound at rest.
const NEAR_REST: f64 = 0.75;

/// The change of the pad's speed over the disc's below which that limit is waived.
const WAIVED: f64 = 5e-4;

/// The sliding speed `r` at which the limits end for exponents below 1.
const FLOOR: f64 = 1e-5;

/// Largest error of the speed in one step that the bends of a measured curve may cause, over the disc's speed and
/// 0.0027.
const BEND: f64 = 1e-3;

/// Most intervals of a measured curve that a step may begin and end apart.
const MOST_INTERVALS: usize = 2;

/// A trial step that is too long is shortened to this share of what the law allows, so that a second cut is rare, and
/// at once to no less than this share of its length.
const CUT: f64 = 0.8;
const DEEPEST_CUT: f64 = 1e-3;

/// How many times longer a step may be than the one before.
pub(crate) const MOST_GROWTH: f64 = 2.0;

/// A pad grazes where its sliding speed has a minimum, or a step ends, below this share of the disc's speed. Where
/// stick-slip ends, errors of the sliding speed are some 1e-6 of the disc's (a test of the steps).
const GRAZING_SPEED: f64 = 1e-4;

/// A pad grazes too where it meets the disc with less than this share of the disc's speed times its natural frequency:
/// the acceleration at the meeting grows with the square root of the distance to a mere touch. A step that ends near the
/// disc's speed on a faster approach only comes before the meeting. The same as the rate of a clear capture in
/// `rigid_disc::planar_motion`.
const GRAZING_RATE: f64 = 3e-2;

/// The same on a flexible disc, where contact and disc ring along in steps that hardly resolve them: of 40 random brakes,
/// stick-slip of every fourth ended at a speed that finer steps changed by 1e-3 to 5e-3. Steep friction draws the pad to
/// the disc, or does not, at sliding speeds of up to 3 % of the disc's, hence the first of these.
const FLEXIBLE_GRAZING_SPEED: f64 = 0.05;
const FLEXIBLE_GRAZING_RATE: f64 = 0.2;

/// The share of static friction by which it has to hold, or fail to hold, a pad that meets a flexible disc, or else the
/// pad grazes it too.
const FLEXIBLE_GRAZING_RESERVE: f64 = 0.02;

/// Length of any step times the highest damping rate: the method is stable up to 2.8.
pub(crate) const DAMPED_STEP: f64 = 1.0;

numbers! {
    /// What the limits depend on of a friction law.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub(crate) struct LimitedLaw<N> {
        pub shape: Shape,
        /// Of Stribeck's law.
        pub exponent: N,
        /// The steepest slope of `exp(-r^delta)`; infinite for exponents below 1.
        pub steepest: N,
    }
}

impl LimitedLaw {
    pub fn new(shape: Shape, exponent: f64) -> Self {
        let crest = 1.0 - 1.0 / exponent;
        let steepest = match shape {
            Shape::Gaussian => libm::sqrt(2.0) * libm::exp(-0.5),
            Shape::Stribeck if exponent > 1.0 => exponent * libm::pow(crest, crest) * libm::exp(-crest),
            _ => f64::INFINITY,
        };
        Self { shape, exponent, steepest }
    }
}

numbers! {
    /// The limits that a friction law sets to the steps that integrate it.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub(crate) struct FrictionSteps<N> {
        pub disc_speed: N,
        pub inverse_stribeck: N,
        pub law: LimitedLaw<N>,
        /// `G (f_s - f_c) / v_s`, per unit of scaled time.
        pub feedback: N,
        /// `G e / v_s`: the damping by a viscous term.
        pub additional: N,
        pub resolution_limit: N,
        pub feedback_limit: N,
        pub refinement: N,
        /// A sliding speed, over the disc's, below which errors of the steps may decide whether the pad sticks.
        pub grazing_speed: N,
        /// An acceleration, over the disc's speed times the natural frequency, below which they may.
        pub grazing_rate: N,
        /// A reserve of static friction, over the friction at rest, below which they may.
        pub grazing_reserve: N,
    }
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
        law: LimitedLaw,
        (falling_pull, additional_pull): (f64, f64),
        refinement: f64,
    ) -> Self {
        Self {
            disc_speed,
            inverse_stribeck,
            law,
            feedback: falling_pull * inverse_stribeck,
            additional: additional_pull * inverse_stribeck,
            resolution_limit: refinement * RESOLUTION,
            feedback_limit: refinement * FEEDBACK,
            refinement,
            grazing_speed: GRAZING_SPEED,
            grazing_rate: GRAZING_RATE,
            grazing_reserve: 0.0,
        }
    }

    /// For a pad on a flexible disc, with the contact force on a rigid disc, which no motion exceeds by much.
    pub fn of_pad(pad: &PadEquations, inputs: RandomInputs, refinement: f64) -> Self {
        let law = LimitedLaw::new(pad.friction_shape, pad.stribeck_exponent);
        let gain = pad.friction_per_preload * inputs.preload;
        let falling = gain * (inputs.static_friction - pad.kinetic_friction).max(0.0);
        let pulls = (falling, gain * pad.additional_friction);
        let limits = Self::new(pad.disc_speed, pad.inverse_stribeck, law, pulls, refinement);
        // Errors of the method shrink with the fourth power of the steps, and a rate is of the square root of a distance.
        let finer = refinement * refinement;
        Self {
            grazing_speed: FLEXIBLE_GRAZING_SPEED * (finer * finer),
            grazing_rate: FLEXIBLE_GRAZING_RATE * finer,
            grazing_reserve: FLEXIBLE_GRAZING_RESERVE * (finer * finer),
            ..limits
        }
    }

    /// Whether a step of length `h` with the speeds `u` and accelerations at its ends is too long, and the length of
    /// the next trial step over this one's. A step that is too long is tried again with that length; after any other,
    /// the next step is no longer than that. No branch depends on the motion, so that lanes decide it too.
    #[inline(always)]
    pub fn judge(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> (bool, f64) {
        match self.law.shape {
            Shape::Tustin => {
                let is_too_long = self.is_too_long_for_tustin(u, acceleration, h);
                let share = CUT / self.excess_for_tustin(u, acceleration, h);
                (is_too_long, if is_too_long { shortened(share) } else { MOST_GROWTH })
            }
            Shape::Gaussian => self.judged(self.unrefined_excess_for_gaussian(u, acceleration, h)),
            Shape::Stribeck => self.judged(self.unrefined_excess_for_stribeck(u, acceleration, h)),
            Shape::Rational => self.judged(self.unrefined_excess_for_rational(u, acceleration, h)),
            Shape::Table(curve) => self.judged(self.unrefined_excess_for_table(curve, u, acceleration, h)),
        }
    }

    #[inline(always)]
    fn judged(&self, unrefined_excess: f64) -> (bool, f64) {
        let is_too_long = unrefined_excess > self.refinement;
        let share = CUT * self.refinement / unrefined_excess;
        let growth = if share < MOST_GROWTH { share } else { MOST_GROWTH };
        (is_too_long, if is_too_long { shortened(share) } else { growth })
    }

    /// Whether steps near rest may be so short that one often ends close to the disc's speed. Those of Tustin's law
    /// hardly ever are.
    pub fn are_fine_near_rest(&self) -> bool {
        self.law.shape != Shape::Tustin
    }

    /// Whether a step is too long for the exponent 1, without a branch.
    #[inline(always)]
    fn is_too_long_for_tustin(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> bool {
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

    /// By how much a step is too long: its length over what the limits allow.
    #[inline(always)]
    fn excess_for_tustin(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let (resolution, feedback) = self.limits_for_tustin(self.least_sliding(u));
        let change = h * larger(acceleration) * self.inverse_stribeck;
        (change / resolution).max(h * self.feedback / feedback).max(h * self.additional / DAMPED_STEP)
    }

    /// The same for any law.
    #[cfg(test)]
    pub fn excess(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let unrefined = match self.law.shape {
            Shape::Tustin => return self.excess_for_tustin(u, acceleration, h),
            Shape::Gaussian => self.unrefined_excess_for_gaussian(u, acceleration, h),
            Shape::Stribeck => self.unrefined_excess_for_stribeck(u, acceleration, h),
            Shape::Rational => self.unrefined_excess_for_rational(u, acceleration, h),
            Shape::Table(curve) => self.unrefined_excess_for_table(curve, u, acceleration, h),
        };
        unrefined / self.refinement
    }

    #[inline(always)]
    fn unrefined_excess_for_gaussian(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        self.excess_by_power(u, acceleration, h, 2.0, |r| r * r)
    }

    #[inline(always)]
    fn unrefined_excess_for_stribeck(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let delta = self.law.exponent;
        self.excess_by_power(u, acceleration, h, delta, |r| rough_power(r, delta))
    }

    /// For Stribeck's law with an exponent other than 1, before it is divided by the refinement.
    #[inline(always)]
    fn excess_by_power(
        &self,
        u: (f64, f64),
        acceleration: (f64, f64),
        h: f64,
        delta: f64,
        power: impl Fn(f64) -> f64,
    ) -> f64 {
        let is_steep_at_rest = delta < 1.0;
        let (least, most) = self.sliding(u);
        let r = if is_steep_at_rest & (least < FLOOR) { FLOOR } else { least };
        let p = power(r);
        // Beyond, friction has died long since, and products of the series stay finite.
        let p = if p < DEAD { p } else { DEAD };
        let (per_r, slope_of_p) = (1.0 / r, delta * p);
        let slope_of_p = slope_of_p * per_r;
        let (widening, growth) = (growth(0.2 * p), growth(p));
        let per_both = 1.0 / (widening * growth);
        let is_inside = !is_steep_at_rest & (r < 1.0);
        let change = h * larger(acceleration) * self.inverse_stribeck;
        let by_resolution = change * (if is_inside { delta } else { slope_of_p }) * (growth * per_both);
        let by_resolution = by_resolution * (1.0 / (STRIBECK * RESOLUTION));
        // `exp(-p)` is at most `1 / growth(p)`, and nowhere steeper than at its crest.
        let slope = slope_of_p * (widening * per_both);
        let is_before_crest = p * delta < delta - 1.0;
        let slope = if is_before_crest | (slope > self.law.steepest) { self.law.steepest } else { slope };
        let by_feedback = h * self.feedback * slope * (1.0 / FEEDBACK);
        let by_rest = if delta < 2.0 {
            let by_change = change * per_r * (1.0 / NEAR_REST);
            let by_size = h * self.feedback * power(most) / (WAIVED * self.disc_speed * self.inverse_stribeck);
            if !is_steep_at_rest & (by_size < by_change) { by_size } else { by_change }
        } else {
            0.0
        };
        let by_friction = larger((larger((by_resolution, by_rest)), by_feedback));
        larger((by_friction, self.refinement * h * self.additional * (1.0 / DAMPED_STEP)))
    }

    /// `1 / (1 + r)` has the length `1 + r`, and its slope falls with its square. Before it is divided by the
    /// refinement.
    #[inline(always)]
    fn unrefined_excess_for_rational(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let per_length = 1.0 / (1.0 + self.least_sliding(u));
        let change = h * larger(acceleration) * self.inverse_stribeck;
        let by_resolution = change * per_length * (1.0 / (RATIONAL * RESOLUTION));
        let by_feedback = h * self.feedback * per_length * per_length * (1.0 / FEEDBACK);
        larger((larger((by_resolution, by_feedback)), self.refinement * h * self.additional * (1.0 / DAMPED_STEP)))
    }

    /// Before it is divided by the refinement.
    #[inline(always)]
    fn unrefined_excess_for_table(&self, curve: SharedCurve, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let place = |u: f64| curve.interval((self.disc_speed - u).abs() * self.inverse_stribeck);
        let intervals = (place(u.0), place(u.1));
        let (first, second) = (curve.window(intervals.0), curve.window(intervals.1));
        let of = |parts: (f64, f64)| self.feedback.abs() * parts.0 + self.additional.abs() * parts.1;
        let steepest = larger((of(first.steepest), of(second.steepest)));
        let bend = larger((of(first.bend), of(second.bend)));
        let change = h * larger(acceleration) * self.inverse_stribeck;
        let cube_by_bends = h * bend * change * change / (BEND * self.disc_speed * self.inverse_stribeck);
        let by_bends = rough_power(cube_by_bends, 1.0 / 3.0);
        let crossed = intervals.0.abs_diff(intervals.1);
        let by_intervals = if crossed > MOST_INTERVALS { crossed as f64 / MOST_INTERVALS as f64 } else { 0.0 };
        let by_feedback = h * steepest * (1.0 / FEEDBACK);
        larger((larger((by_bends, self.refinement * by_intervals)), by_feedback))
    }

    /// The smallest sliding speed in a step over the Stribeck velocity; 0 where it passes through sticking.
    #[inline(always)]
    fn least_sliding(&self, u: (f64, f64)) -> f64 {
        self.sliding(u).0
    }

    /// The smallest and the largest sliding speed in a step over the Stribeck velocity.
    #[inline(always)]
    fn sliding(&self, u: (f64, f64)) -> (f64, f64) {
        let (first, last) = (self.disc_speed - u.0, self.disc_speed - u.1);
        let crosses = first * last <= 0.0;
        let (first, last) = (first.abs(), last.abs());
        let (least, most) = if first < last { (first, last) } else { (last, first) };
        (if crosses { 0.0 } else { least * self.inverse_stribeck }, most * self.inverse_stribeck)
    }
}

/// To what a trial step is shortened that is too long. Infinite accelerations take the deepest cut.
#[inline(always)]
fn shortened(share: f64) -> f64 {
    let cut = if share < CUT { share } else { CUT };
    if share > DEEPEST_CUT { cut } else { DEEPEST_CUT }
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
