//! How long a step may be where friction is steep.
//!
//! A step of a tenth over the natural frequency resolves the springs. It does not resolve the friction law where the
//! disc is much faster than the Stribeck velocity: there friction rises only within a few `v_s` of sticking, and a pad
//! passes that range in a fraction of such a step. So a step ends early where one of two limits asks for it. With the
//! sliding speed `r = |v - x'| / v_s` and `p = r^delta`, friction above its kinetic value is proportional to `exp(-p)`:
//!
//! ```text
//! resolution   h |x''| / v_s  <=  0.25 e(p) s(r)      e(p) = 1 + p/5 + p^2/50 <= exp(p/5)
//! feedback     h lambda(r)    <=  0.4                 lambda(r) = G (f_s - f_c) |d exp(-p) / dv|
//! ```
//!
//! *Resolution*: `r` may change by a part of the length `s` over which `p` changes by one. The error of a fourth-order
//! step is proportional to `exp(-p) (change of p)^5`, so at equal error the change may grow as `exp(p/5)`; where friction
//! has fallen to nothing, nothing limits the step. *Feedback*: near sticking the falling friction drives the pad away at
//! the rate `lambda`, which steps have to follow even while nothing moves much yet.
//!
//! | exponent | s(r) | why |
//! |---|---|---|
//! | 1 | 1 | the law has one length, v_s |
//! | above 1 | `1 / delta` below r = 1, `r^(1 - delta) / delta` above, at most `1.2 r` | at rest its second derivative may be infinite |
//! | below 1 | `r^(1 - delta) / delta`, at most `1.2 r` | at rest its slope is infinite |
//!
//! Below `r = 1e-5` steps shrink no further: what the law still does there changes no speed by more than `1e-5 v_s`.
//!
//! Both limits are held after a step, by the speeds and accelerations at its ends. A plain step has these anyway, so
//! lanes can tell at the cost of some comparisons which steps are too long, and leave those to the scalar code.

use crate::friction::StribeckLaw;

/// Largest change of `p` where friction has not fallen yet, and largest growth of a disturbance, in one step.
///
/// Measured together, see the tests: the saddle-node of stick-slip is where the adaptive reference finds it, to 1e-5, for
/// disc speeds up to 1000 Stribeck velocities.
const RESOLUTION: f64 = 0.25;
const FEEDBACK: f64 = 0.4;

/// Largest change of `r` in one step over `r` itself where derivatives of the law grow without bound at rest, and the
/// sliding speed at which that ends.
const NEAR_REST: f64 = 0.3;
const FLOOR: f64 = 1e-5;

/// What a friction law asks of the steps that integrate it.
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
        let p = self.least_sliding(u);
        let per_acceleration = h * self.inverse_stribeck;
        let resolution = self.resolution_limit * widening(p);
        let feedback = self.feedback_limit * growth(p);
        (per_acceleration * acceleration.0.abs() > resolution)
            | (per_acceleration * acceleration.1.abs() > resolution)
            | (h * self.feedback > feedback)
    }

    /// By how much a step is too long: its length over what the limits allow.
    pub fn excess(&self, u: (f64, f64), acceleration: (f64, f64), h: f64) -> f64 {
        let fastest = acceleration.0.abs().max(acceleration.1.abs());
        let change = h * fastest * self.inverse_stribeck;
        let least = self.least_sliding(u);
        let delta = self.exponent;
        if delta == 1.0 {
            let feedback = self.feedback_limit * growth(least);
            return (change / (self.resolution_limit * widening(least))).max(h * self.feedback / feedback);
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

/// The beginning of the series of `exp(p)`, by which the feedback has fallen for the exponent 1 at least.
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
mod tests {
    use super::*;

    const EXPONENTS: [f64; 5] = [0.5, 1.0, 1.5, 2.0, 3.0];

    /// A disc at speed 10 and a Stribeck velocity of 1/2.
    fn limits(exponent: f64, falling_pull: f64, refinement: f64) -> FrictionSteps {
        FrictionSteps::new(10.0, 2.0, exponent, falling_pull, refinement)
    }

    /// The speed of a pad that slides at `r` Stribeck velocities.
    fn speed(r: f64) -> f64 {
        10.0 - 0.5 * r
    }

    /// Speeds and accelerations at the ends of steps, from a simple generator: speeds mostly near the disc's.
    fn states() -> impl Iterator<Item = ((f64, f64), (f64, f64), f64)> {
        let mut state = 0x9E37_79B9_7F4A_7C15_u64;
        let mut draw = move || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        std::iter::repeat_with(move || {
            let mut r = || 60.0 * (draw() - 0.2) * draw() * draw();
            let speeds = (speed(r()), speed(r()));
            (speeds, (40.0 * (draw() - 0.5), 40.0 * (draw() - 0.5)), 200.0 * draw() * draw())
        })
        .take(20_000)
    }

    #[test]
    fn for_exponent_one_a_step_is_too_long_exactly_if_its_excess_is_above_one() {
        let mut seen = [0; 2];
        for (speeds, accelerations, falling_pull) in states() {
            let limits = limits(1.0, falling_pull, 1.0);
            let longest = 1.0 / limits.excess(speeds, accelerations, 1.0);
            for share in [0.01, 0.3, 1.0 - 1e-12, 1.0 + 1e-12, 2.0, 50.0] {
                let h = share * longest;
                let is_too_long = limits.is_too_long_for_tustin(speeds, accelerations, h);
                assert_eq!(is_too_long, share > 1.0, "{speeds:?} {accelerations:?} {falling_pull} {share}");
                assert_eq!(limits.is_too_long(speeds, accelerations, h), is_too_long);
                seen[usize::from(is_too_long)] += 1;
            }
        }
        assert_eq!(seen, [60_000; 2]);
    }

    #[test]
    fn for_any_exponent_the_excess_says_how_much_shorter_a_step_has_to_be() {
        for exponent in EXPONENTS {
            for (speeds, accelerations, falling_pull) in states().take(1000) {
                let limits = limits(exponent, falling_pull, 1.0);
                let longest = 1.0 / limits.excess(speeds, accelerations, 1.0);
                assert!(limits.is_too_long(speeds, accelerations, longest * (1.0 + 1e-12)));
                assert!(!limits.is_too_long(speeds, accelerations, longest * (1.0 - 1e-12)));
            }
        }
    }

    #[test]
    fn limits_scale_with_the_refinement() {
        for exponent in EXPONENTS {
            for (speeds, accelerations, falling_pull) in states().take(1000) {
                let [whole, half] =
                    [1.0, 0.5].map(|share| limits(exponent, falling_pull, share).excess(speeds, accelerations, 0.1));
                assert!((half / whole - 2.0).abs() < 1e-12, "{exponent} {whole} {half}");
            }
        }
    }

    #[test]
    fn the_sliding_speed_may_change_as_much_as_the_table_allows() {
        let change_allowed = [
            // Exponent 1: 0.25 e(r).
            (1.0, 0.0, 0.25),
            (1.0, 1.0, 0.25 * 1.22),
            (1.0, 10.0, 0.25 * 5.0),
            // Above 1: at most 0.3 r; 1 / delta below r = 1; r^(1 - delta) / delta above.
            (2.0, 0.1, 0.03),
            (2.0, 0.5, 0.25 * 1.051_25 / 2.0),
            (2.0, 2.0, 0.25 * 2.12 / 4.0),
            (3.0, 0.9, 0.25 * (1.0 + 0.729 / 5.0 + 0.729 * 0.729 / 50.0) / 3.0),
            // Below 1: at most 0.3 r, r^(1 - delta) / delta.
            (0.5, 1.0, 0.3),
            (0.5, 25.0, 0.25 * 2.5 * 10.0),
            // At rest, where derivatives of the law are infinite.
            (0.5, 0.0, 0.3e-5),
            (2.0, 0.0, 0.3e-5),
        ];
        for (exponent, r, allowed) in change_allowed {
            // The nearer end counts, and the larger acceleration.
            for (speeds, accelerations) in
                [((r, r), (3.0, -3.0)), ((r, r + 1.0), (0.0, -3.0)), ((r + 1.0, r), (3.0, 1.0))]
            {
                let speeds = (speed(speeds.0), speed(speeds.1));
                let excess = limits(exponent, 0.0, 1.0).excess(speeds, accelerations, 0.1);
                let expected = 0.1 * 3.0 * 2.0 / allowed;
                // Up to what is lost where the speed of the pad is subtracted from the disc's.
                assert!((excess / expected - 1.0).abs() < 1e-10, "{exponent} {r}: {excess} {expected}");
            }
        }
    }

    #[test]
    fn a_step_through_sticking_is_as_long_as_one_at_it() {
        for exponent in EXPONENTS {
            let limits = limits(exponent, 0.0, 1.0);
            let at = limits.excess((speed(0.0), speed(0.0)), (1.0, 1.0), 0.1);
            for speeds in [(0.5, -2.0), (-2.0, 0.5)] {
                let through = limits.excess((speed(speeds.0), speed(speeds.1)), (1.0, 1.0), 0.1);
                assert_eq!(through, at, "{exponent}");
            }
        }
    }

    #[test]
    fn a_step_is_cut_near_sticking_and_not_where_friction_has_died() {
        // A disc a thousand Stribeck velocities fast, and a step of a tenth over the natural frequency.
        for exponent in EXPONENTS {
            let limits = FrictionSteps::new(1.0, 1e3, exponent, 0.1, 1.0);
            assert!(!limits.is_too_long((0.0, 0.1), (1.0, 1.0), 0.1), "{exponent}");
            assert!(limits.is_too_long((0.99, 1.0), (1.0, 1.0), 0.1), "{exponent}");
            assert!(limits.is_too_long((1.0, 0.99), (1.0, 1.0), 0.1), "{exponent}");
        }
    }

    #[test]
    fn at_release_the_falling_friction_limits_a_step_of_no_acceleration() {
        // From sticking to one Stribeck velocity: the steepest friction in between.
        let steepest = [
            (0.5, 0.5 * 1e5_f64.sqrt() * libm::exp(-1e-5_f64.sqrt())),
            (1.0, 1.0),
            (2.0, 2.0 * 0.5_f64.sqrt() * libm::exp(-0.5)),
        ];
        for (exponent, slope) in steepest {
            let excess = limits(exponent, 7.0, 1.0).excess((speed(0.0), speed(1.0)), (0.0, 0.0), 0.1);
            let expected = 0.1 * 7.0 * 2.0 * slope / 0.4;
            assert!((excess / expected - 1.0).abs() < 1e-9, "{exponent}: {excess} {expected}");
        }
        // Farther away it is the less the more friction has fallen.
        let excess = limits(1.0, 7.0, 1.0).excess((speed(4.0), speed(2.0)), (0.0, 0.0), 0.1);
        assert!((excess - 0.1 * 7.0 * 2.0 / (0.4 * 7.0)).abs() < 1e-9);
        let excess = limits(2.0, 7.0, 1.0).excess((speed(3.0), speed(2.0)), (0.0, 0.0), 0.1);
        assert!((excess - 0.1 * 7.0 * 2.0 * 4.0 * libm::exp(-4.0) / 0.4).abs() < 1e-9);
    }
}
