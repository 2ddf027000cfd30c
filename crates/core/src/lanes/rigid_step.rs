//! A trial step of slip in the lanes of a rigid disc.

use crate::friction::shape::Shape;
use crate::lanes::BLOCK;
use crate::lanes::findings::{Slip, findings};
use crate::lanes::pace::{Pace, TOO_LONG};
use crate::motion::rigid::RigidSample;

/// Blocks: enough independent chains to hide the latency of the friction law.
pub(super) const BLOCKS: usize = 4;

/// One value for each lane of a block.
type Row = [f64; BLOCK];

/// Neighbouring lanes: as many as keep a step in registers.
pub(super) struct RigidBlock {
    pub stiffness: Row,
    pub damping: Row,
    pub kinetic_pull: Row,
    pub slip: Slip<BLOCK>,
    pub x: Row,
    pub u: Row,
    pub next_x: Row,
    pub next_u: Row,
    pub first_acceleration: Row,
    pub last_acceleration: Row,
    pub pace: Pace<BLOCK>,
    pub visits: u64,
}

impl RigidBlock {
    pub fn idle() -> Self {
        let zero = [0.0; BLOCK];
        Self {
            stiffness: zero,
            damping: zero,
            kinetic_pull: zero,
            slip: Slip::idle(),
            x: zero,
            u: zero,
            next_x: zero,
            next_u: zero,
            first_acceleration: zero,
            last_acceleration: zero,
            pace: Pace::idle(),
            visits: 0,
        }
    }

    pub fn set_sample(&mut self, l: usize, sample: &RigidSample) {
        self.stiffness[l] = sample.brake.stiffness;
        self.damping[l] = sample.brake.damping;
        self.kinetic_pull[l] = sample.kinetic_pull;
        self.slip.disc_speed[l] = sample.brake.disc_speed;
        self.slip.inverse_stribeck[l] = sample.brake.inverse_stribeck;
        let law = sample.friction_steps.law;
        (self.slip.exponent[l], self.slip.steepest[l]) = (law.exponent, law.steepest);
        self.slip.falling_pull[l] = sample.falling_pull;
        self.slip.additional_pull[l] = sample.additional_pull;
        self.slip.refinement[l] = sample.brake.refinement;
    }
}

/// [`crate::motion::rigid`]'s step of slip, with this shape of the friction law.
#[inline(always)]
pub(super) fn rigid_step(blocks: &mut [RigidBlock; BLOCKS], shape: Shape) {
    for block in blocks {
        // The shape is matched once, and each arm has a kernel of its own.
        match shape {
            Shape::Tustin => block_step(block, Shape::Tustin),
            Shape::Gaussian => block_step(block, Shape::Gaussian),
            Shape::Stribeck => block_step(block, Shape::Stribeck),
            Shape::Rational => block_step(block, Shape::Rational),
            Shape::Table(curve) => block_step(block, Shape::Table(curve)),
        }
    }
}

#[inline(always)]
fn block_step(block: &mut RigidBlock, shape: Shape) {
    let (x, u, h) = (block.next_x, block.next_u, block.pace.length);
    let [mut stage_x, mut stage_u] = [[0.0; BLOCK]; 2];
    let k1 = accelerations(block, shape, &x, &u);
    for i in 0..BLOCK {
        let half = 0.5 * h[i];
        stage_x[i] = x[i] + half * u[i];
        stage_u[i] = u[i] + half * k1[i];
    }
    let k2 = accelerations(block, shape, &stage_x, &stage_u);
    for i in 0..BLOCK {
        let half = 0.5 * h[i];
        stage_x[i] = x[i] + half * stage_u[i];
        stage_u[i] = u[i] + half * k2[i];
    }
    let k3 = accelerations(block, shape, &stage_x, &stage_u);
    for i in 0..BLOCK {
        stage_x[i] = x[i] + h[i] * stage_u[i];
        stage_u[i] = u[i] + h[i] * k3[i];
    }
    let k4 = accelerations(block, shape, &stage_x, &stage_u);
    let [mut next_x, mut next_u] = [[0.0; BLOCK]; 2];
    for i in 0..BLOCK {
        let sixth = h[i] / 6.0;
        next_x[i] = x[i] + h[i] * (u[i] + sixth * (k1[i] + k2[i] + k3[i]));
        next_u[i] = u[i] + sixth * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    }
    let trials = findings(&block.slip, shape, (&u, &next_u), &next_x, (&k1, &k4), &h);
    block.pace.judge(&trials);
    // Steps that are too long are taken again from where they began.
    for l in 0..BLOCK {
        let is_too_long = block.pace.findings[l] & TOO_LONG != 0;
        next_x[l] = if is_too_long { x[l] } else { next_x[l] };
        next_u[l] = if is_too_long { u[l] } else { next_u[l] };
        block.pace.findings[l] &= !TOO_LONG;
    }
    block.visits = block.pace.visits();
    (block.x, block.u) = (x, u);
    (block.next_x, block.next_u) = (next_x, next_u);
    (block.first_acceleration, block.last_acceleration) = (k1, k4);
}

// A function and not a closure: what is not inlined is compiled for the baseline.
#[inline(always)]
fn accelerations(block: &RigidBlock, shape: Shape, x: &Row, u: &Row) -> Row {
    let RigidBlock { stiffness, damping, kinetic_pull, slip, .. } = block;
    let (a, b) = slip.friction_parts(shape, u);
    let mut accelerations = [0.0; BLOCK];
    for l in 0..BLOCK {
        let pull = kinetic_pull[l] + slip.falling_pull[l] * a[l] + slip.additional_pull[l] * b[l];
        accelerations[l] = pull - stiffness[l] * x[l] - damping[l] * u[l];
    }
    accelerations
}
