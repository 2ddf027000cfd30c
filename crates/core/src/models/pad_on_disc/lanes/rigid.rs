//! Lanes of a rigid disc.

use crate::friction::shape::Shape;
use crate::model::decision::Decision;
use crate::models::pad_on_disc::criterion::rigid_monitor::RigidMonitor;
use crate::models::pad_on_disc::criterion::time_domain::System;
use crate::models::pad_on_disc::lanes::BLOCK;
use crate::models::pad_on_disc::lanes::bundle::{Begun, Bundle};
use crate::models::pad_on_disc::lanes::dispatch::{InstructionSet, dispatch};
use crate::models::pad_on_disc::lanes::pace::Pace;
use crate::models::pad_on_disc::lanes::queue::QueuedSample;
use crate::models::pad_on_disc::lanes::rigid_step::{BLOCKS, RigidBlock, rigid_step};
use crate::models::pad_on_disc::motion::integrator::{Motion, Step};
use crate::models::pad_on_disc::motion::rigid::{RigidBrake, RigidSample, RigidState};
use crate::models::pad_on_disc::pad::contact_state::ContactState;

/// Lanes: enough independent chains to hide the latency of the friction law, and one bit for each in a register.
pub(super) const LANES: usize = BLOCK * BLOCKS;

/// Lanes of a rigid disc.
pub(super) struct RigidBundle {
    shape: Shape,
    samples: Vec<Option<RigidSample>>,
    blocks: Box<[RigidBlock; BLOCKS]>,
}

impl RigidBundle {
    /// Lanes for brakes with the friction law of this one.
    pub fn new(brake: &RigidBrake) -> Self {
        Self {
            shape: brake.law.shape,
            samples: vec![None; LANES],
            blocks: Box::new(std::array::from_fn(|_| RigidBlock::default())),
        }
    }

    fn set_sample(&mut self, lane: usize, sample: RigidSample) {
        self.blocks[lane / BLOCK].set_sample(lane % BLOCK, &sample);
        self.samples[lane] = Some(sample);
    }
}

impl<'q> Bundle<'q> for RigidBundle {
    const LANES: usize = LANES;

    type State = RigidState;
    type Equations<'a> = RigidSample;
    type Monitor = RigidMonitor;

    const AT_ONCE: usize = 16;
    type Known = ();

    fn examine(&self, samples: &[QueuedSample<'q>]) -> Vec<()> {
        vec![(); samples.len()]
    }

    fn begin(
        &mut self,
        lane: usize,
        sample: &QueuedSample<'q>,
        _: f64,
        (): (),
        _: &dyn Fn() -> bool,
    ) -> Result<Begun<RigidState, RigidMonitor>, Decision> {
        let equations = equations_of(sample)?;
        if equations.brake.law.shape != self.shape {
            return Err(sample.clone().decide());
        }
        let (motion, monitor) = sample.criterion.start_rigid(&equations, sample.inputs, sample.scaled_start())?;
        self.set_sample(lane, equations);
        Ok(Begun { motion, monitor, step: equations.brake.step })
    }

    fn place(&mut self, lane: usize, sample: &QueuedSample<'q>) -> Option<(Motion<RigidState>, f64)> {
        let equations = equations_of(sample).ok()?;
        self.set_sample(lane, equations);
        Some((sample.criterion.rigid_start(&equations, sample.scaled_start()), equations.brake.step))
    }

    #[inline]
    fn step(&mut self, set: InstructionSet) {
        let blocks = &mut self.blocks;
        dispatch!(set, rigid_step, blocks: &mut [RigidBlock; BLOCKS]);
    }

    #[inline]
    fn visits(&self) -> u64 {
        self.blocks.iter().enumerate().fold(0, |lanes, (index, block)| lanes | (block.visits << (index * BLOCK)))
    }

    #[inline]
    fn pace(&mut self, lane: usize) -> (&mut Pace<BLOCK>, usize) {
        (&mut self.blocks[lane / BLOCK].pace, lane % BLOCK)
    }

    #[inline]
    fn equations(&self, lane: usize) -> Option<RigidSample> {
        self.samples[lane]
    }

    #[inline]
    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64)) {
        let (block, l) = (&self.blocks[lane / BLOCK], lane % BLOCK);
        let acceleration = (block.acceleration.0.0[l], block.acceleration.1.0[l]);
        (block.x.0[l], (block.u.0[l], block.next_u.0[l]), acceleration)
    }

    #[inline]
    fn next_tangential(&self, lane: usize) -> (f64, f64) {
        let (block, l) = (&self.blocks[lane / BLOCK], lane % BLOCK);
        (block.next_x.0[l], block.next_u.0[l])
    }

    #[inline]
    fn present(&self, lane: usize) -> RigidState {
        let (block, l) = (&self.blocks[lane / BLOCK], lane % BLOCK);
        RigidState { x: block.x.0[l], u: block.u.0[l] }
    }

    #[inline]
    fn trial(&self, lane: usize) -> Option<Step<RigidState>> {
        Some(Step { next: self.next(lane), acceleration: self.tangential(lane).2 })
    }

    #[inline]
    fn next(&self, lane: usize) -> RigidState {
        let (block, l) = (&self.blocks[lane / BLOCK], lane % BLOCK);
        RigidState { x: block.next_x.0[l], u: block.next_u.0[l] }
    }

    fn simulates(contact: ContactState) -> bool {
        contact == ContactState::Slip
    }

    #[inline]
    fn set_next(&mut self, lane: usize, motion: &Motion<RigidState>) {
        let (block, l) = (&mut self.blocks[lane / BLOCK], lane % BLOCK);
        (block.next_x.0[l], block.next_u.0[l]) = (motion.state.x, motion.state.u);
    }

    #[inline]
    fn keep(&mut self, lane: usize) {
        let (block, l) = (&mut self.blocks[lane / BLOCK], lane % BLOCK);
        (block.next_x.0[l], block.next_u.0[l]) = (block.x.0[l], block.u.0[l]);
    }
}

/// The equations of a sample, or the decision if there are none.
fn equations_of(sample: &QueuedSample<'_>) -> Result<RigidSample, Decision> {
    match (&sample.brake, &sample.criterion.system) {
        (None, System::Rigid(brake)) => Ok(brake.sample(sample.inputs)),
        (Some(own), System::Rigid(brake)) => {
            let own = RigidBrake::new(own).refined_as(brake);
            let is_resolved = sample.criterion.check_horizon(own.step).is_ok();
            if is_resolved { Ok(own.sample(sample.inputs)) } else { Err(Decision::FAILED) }
        }
        (_, System::Flexible(_)) => Err(sample.clone().decide()),
    }
}
