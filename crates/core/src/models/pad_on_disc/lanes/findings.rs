//! What a trial step of slip met in lanes: the conditions of [`crate::models::pad_on_disc::motion::substep`] without a branch.

use crate::friction::shape::Shape;
use crate::models::pad_on_disc::lanes::pace::Trials;
use crate::models::pad_on_disc::motion::friction_steps::FrictionSteps;
use crate::models::pad_on_disc::motion::integrator::{FARTHEST, grazes_at_end, may_touch, turns};
use crate::numerics::row::{Lanes, Row};

/// What trial steps of slip have met: `u`, `next_x` and `acceleration` at their ends, of length `h`.
#[inline(always)]
pub(super) fn findings<const N: usize>(
    steps: &FrictionSteps<Row<N>>,
    next_x: &Row<N>,
    u: (&Row<N>, &Row<N>),
    acceleration: (&Row<N>, &Row<N>),
    h: &Row<N>,
) -> Trials<N> {
    // The shape is matched once, and each arm has a loop of its own.
    match steps.law.shape {
        Shape::Tustin => findings_with(Shape::Tustin, steps, next_x, u, acceleration, h),
        Shape::Gaussian => findings_with(Shape::Gaussian, steps, next_x, u, acceleration, h),
        Shape::Stribeck => findings_with(Shape::Stribeck, steps, next_x, u, acceleration, h),
        Shape::Rational => findings_with(Shape::Rational, steps, next_x, u, acceleration, h),
        Shape::Table(curve) => findings_with(Shape::Table(curve), steps, next_x, u, acceleration, h),
    }
}

#[inline(always)]
fn findings_with<const N: usize>(
    shape: Shape,
    steps: &FrictionSteps<Row<N>>,
    next_x: &Row<N>,
    u: (&Row<N>, &Row<N>),
    acceleration: (&Row<N>, &Row<N>),
    h: &Row<N>,
) -> Trials<N> {
    let mut trials = Trials::plain();
    for l in 0..N {
        let mut steps = steps.get(l);
        steps.law.shape = shape;
        let disc_speed = steps.disc_speed;
        let (u, acceleration) = ((u.0.0[l], u.1.0[l]), (acceleration.0.0[l], acceleration.1.0[l]));
        let sliding = (disc_speed - u.0, disc_speed - u.1);
        let touches = may_touch(sliding, (-acceleration.0, -acceleration.1), h.0[l]);
        let ordinary = (sliding.1 > 0.0) & (sliding.1 < f64::MAX) & (next_x.0[l].abs() < FARTHEST);
        let grazes = grazes_at_end(sliding, disc_speed, steps.grazing_speed);
        let (is_too_long, factor) = steps.judge(u, acceleration, h.0[l]);
        (trials.is_too_long[l], trials.factor[l]) = (u64::from(is_too_long), factor);
        trials.is_event[l] = u64::from(touches | grazes | !ordinary);
        trials.turns[l] = u64::from(turns(u.0, u.1));
    }
    trials
}
