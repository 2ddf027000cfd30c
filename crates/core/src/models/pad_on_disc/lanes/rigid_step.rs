//! A trial step of slip in the lanes of a rigid disc.

use crate::models::pad_on_disc::lanes::findings::findings;
use crate::models::pad_on_disc::lanes::pace::{Pace, TOO_LONG};
use crate::models::pad_on_disc::lanes::{BLOCK, Row};
use crate::models::pad_on_disc::motion::friction_steps::FrictionSteps;
use crate::models::pad_on_disc::motion::rigid::{MassOnBelt, OnBelt, RigidSample};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::numerics::row::{self, Lanes};
use crate::numerics::runge_kutta;

/// Blocks: enough independent chains to hide the latency of the friction law.
pub(super) const BLOCKS: usize = 4;

/// Neighbouring lanes: as many as keep a step in registers.
#[derive(Default)]
pub(super) struct RigidBlock {
    pub pad: MassOnBelt<Row>,
    pub friction_steps: FrictionSteps<Row>,
    pub x: Row,
    pub u: Row,
    pub next_x: Row,
    pub next_u: Row,
    /// At the beginning and at the end of the step.
    pub acceleration: (Row, Row),
    pub pace: Pace<BLOCK>,
    pub visits: u64,
}

impl RigidBlock {
    pub fn set_sample(&mut self, l: usize, sample: &RigidSample) {
        self.pad.set(l, &sample.pad);
        self.friction_steps.set(l, &sample.friction_steps);
    }
}

/// [`crate::models::pad_on_disc::motion::rigid`]'s step of slip.
#[inline(always)]
pub(super) fn rigid_step(blocks: &mut [RigidBlock; BLOCKS]) {
    for block in blocks {
        block_step(block);
    }
}

#[inline(always)]
fn block_step(block: &mut RigidBlock) {
    let (x, u, h) = (block.next_x, block.next_u, row::Row(block.pace.length));
    let mut equations = OnBelt { pad: &block.pad, contact: ContactState::Slip };
    let end = runge_kutta::step(&mut equations, 1, (&[x], &[u]), h);
    let ([mut next_x], [mut next_u]) = (end.q, end.u);
    let trials =
        findings(&block.friction_steps, &next_x, (&u, &next_u), (&end.acceleration.0, &end.acceleration.1), &h);
    block.pace.judge(&trials);
    // Steps that are too long are taken again from where they began.
    for l in 0..BLOCK {
        let is_too_long = block.pace.findings[l] & TOO_LONG != 0;
        next_x.0[l] = if is_too_long { x.0[l] } else { next_x.0[l] };
        next_u.0[l] = if is_too_long { u.0[l] } else { next_u.0[l] };
        block.pace.findings[l] &= !TOO_LONG;
    }
    block.visits = block.pace.visits();
    (block.x, block.u) = (x, u);
    (block.next_x, block.next_u) = (next_x, next_u);
    block.acceleration = end.acceleration;
}
