//! What a step of slip met in a lane.

use crate::motion::friction_steps::FrictionSteps;
use crate::motion::integrator::{FARTHEST, grazes_at_end, may_touch, turns};

/// What a step found in a lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Finding {
    /// Plain slip.
    Nothing,
    /// Plain slip with a turning point.
    Turn,
    /// Something for the scalar code.
    Event,
}

/// Bits of a finding as the lanes write them: numbers of the width of a lane, so that writing them is one vector
/// operation too.
const TURN: u64 = 1;
pub(super) const EVENT: u64 = 2;

#[inline]
pub(super) fn found(bits: u64) -> Finding {
    if bits & EVENT != 0 {
        Finding::Event
    } else if bits & TURN != 0 {
        Finding::Turn
    } else {
        Finding::Nothing
    }
}

/// What a step of slip from `u` to `next_u` has met; the conditions of [`crate::motion::integrator`], as bits.
#[inline(always)]
pub(super) fn findings(
    steps: &FrictionSteps,
    disc_speed: f64,
    u: (f64, f64),
    next_x: f64,
    acceleration: (f64, f64),
    h: f64,
) -> u64 {
    let sliding = (disc_speed - u.0, disc_speed - u.1);
    let touches = may_touch(sliding, (-acceleration.0, -acceleration.1), h);
    let ordinary = (sliding.1 > 0.0) & (sliding.1 < f64::MAX) & (next_x.abs() < FARTHEST);
    let too_long = steps.is_too_long_for_tustin(u, acceleration, h);
    let grazes = grazes_at_end(sliding, disc_speed);
    u64::from(touches | grazes | too_long | !ordinary) * EVENT + u64::from(turns(u.0, u.1)) * TURN
}
