//! What a trial step of slip met in lanes: the conditions of [`crate::motion::substep`] without a branch.

use crate::friction::shape::Shape;
use crate::lanes::pace::Trials;
use crate::motion::friction_steps::{FrictionSteps, LimitedLaw};
use crate::motion::integrator::{FARTHEST, grazes_at_end, may_touch, turns};

/// What findings in slip depend on, for some lanes.
#[derive(Debug, Clone)]
pub(super) struct Slip<const N: usize> {
    pub disc_speed: [f64; N],
    pub inverse_stribeck: [f64; N],
    /// Of Stribeck's law.
    pub exponent: [f64; N],
    /// See [`LimitedLaw`].
    pub steepest: [f64; N],
    /// See [`FrictionSteps::new`].
    pub falling_pull: [f64; N],
    pub additional_pull: [f64; N],
    pub refinement: [f64; N],
}

impl<const N: usize> Slip<N> {
    pub fn idle() -> Self {
        let zero = [0.0; N];
        Self {
            disc_speed: zero,
            inverse_stribeck: zero,
            exponent: zero,
            steepest: zero,
            falling_pull: zero,
            additional_pull: zero,
            refinement: zero,
        }
    }

    /// The parts of the friction law at speeds of the pad, see [`Shape::parts`].
    #[inline(always)]
    pub fn friction_parts(&self, shape: Shape, u: &[f64; N]) -> ([f64; N], [f64; N]) {
        let [mut r, mut a, mut b] = [[0.0; N]; 3];
        for l in 0..N {
            r[l] = (self.disc_speed[l] - u[l]) * self.inverse_stribeck[l];
        }
        shape.parts_of_lanes(&r, &self.exponent, &mut a, &mut b);
        (a, b)
    }
}

/// What trial steps of slip have met: `u`, `next_x` and `acceleration` at their ends, of length `h`.
#[inline(always)]
pub(super) fn findings<const N: usize>(
    slip: &Slip<N>,
    shape: Shape,
    u: (&[f64; N], &[f64; N]),
    next_x: &[f64; N],
    acceleration: (&[f64; N], &[f64; N]),
    h: &[f64; N],
) -> Trials<N> {
    let mut trials = Trials::plain();
    for l in 0..N {
        let disc_speed = slip.disc_speed[l];
        let (u, acceleration) = ((u.0[l], u.1[l]), (acceleration.0[l], acceleration.1[l]));
        let sliding = (disc_speed - u.0, disc_speed - u.1);
        let touches = may_touch(sliding, (-acceleration.0, -acceleration.1), h[l]);
        let ordinary = (sliding.1 > 0.0) & (sliding.1 < f64::MAX) & (next_x[l].abs() < FARTHEST);
        let grazes = grazes_at_end(sliding, disc_speed);
        let law = LimitedLaw { shape, exponent: slip.exponent[l], steepest: slip.steepest[l] };
        let pulls = (slip.falling_pull[l], slip.additional_pull[l]);
        let steps = FrictionSteps::new(disc_speed, slip.inverse_stribeck[l], law, pulls, slip.refinement[l]);
        let (is_too_long, factor) = steps.judge(u, acceleration, h[l]);
        (trials.is_too_long[l], trials.factor[l]) = (u64::from(is_too_long), factor);
        trials.is_event[l] = u64::from(touches | grazes | !ordinary);
        trials.turns[l] = u64::from(turns(u.0, u.1));
    }
    trials
}
