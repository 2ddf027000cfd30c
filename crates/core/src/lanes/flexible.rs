//! Lanes of a flexible disc.

use crate::criterion::decision::Decision;
use crate::criterion::flexible_monitor::FlexibleMonitor;
use crate::criterion::time_domain::TimeDomain;
use crate::flexible_disc::brake::FlexibleBrake;
use crate::flexible_disc::equations::FlexibleEquations;
use crate::lanes::dispatch::{InstructionSet, dispatch};
use crate::lanes::findings::{Finding, found};
use crate::lanes::flexible_step::{
    ContactRows, FlexibleArrays, InputRows, LANES, Tables, flexible_step, square, transposed,
};
use crate::lanes::scheduling::{Bundle, RunningSample};
use crate::motion::advance::advance;
use crate::motion::flexible::{FlexibleMotion, FlexibleSample, FlexibleState, MOST_FREEDOMS};
use crate::motion::integrator::{Breakdown, Motion};
use crate::pad::contact_state::ContactState;
use crate::pad::equations::PAD;
use crate::rigid_disc::pad_on_disc::RandomInputs;

/// Lanes of a flexible disc.
pub(super) struct FlexibleBundle<'a> {
    motion: &'a FlexibleMotion,
    tables: Tables,
    inputs: [RandomInputs; LANES],
    lanes: FlexibleArrays,
}

impl<'a> FlexibleBundle<'a> {
    pub fn new(motion: &'a FlexibleMotion) -> Self {
        let brake = &motion.brake.equations;
        let (size, averages) = (brake.size(), &brake.geometry.patch.averages);
        let inputs = RandomInputs { preload: 0.0, static_friction: 0.0 };
        let rows = |count: usize| vec![[0.0; LANES]; count];
        let tables = Tables {
            even_even: square(&averages.even_even, brake.geometry.patch.even),
            odd_odd: square(&averages.odd_odd, brake.geometry.patch.odd),
            even_follower: transposed(&averages.even_follower),
            odd_follower: transposed(&averages.odd_follower),
        };
        let contact = ContactRows {
            even_products: rows(averages.even_follower.first().map_or(0, Vec::len)),
            odd_products: rows(averages.odd_follower.first().map_or(0, Vec::len)),
            on_modes: rows(size - PAD),
            follower: rows(size - PAD),
        };
        let lanes = FlexibleArrays {
            inputs: InputRows { preload: [0.0; LANES], static_friction: [0.0; LANES] },
            friction_steps: [motion.friction_steps(inputs); LANES],
            q: rows(size),
            u: rows(size),
            next_q: rows(size),
            next_u: rows(size),
            stage_q: rows(size),
            stage_u: rows(size),
            k: [rows(size), rows(size), rows(size), rows(size)],
            contact,
            plain: [0; LANES],
            findings: [0; LANES],
        };
        Self { motion, tables, inputs: [inputs; LANES], lanes }
    }

    fn size(&self) -> usize {
        self.motion.brake.equations.size()
    }

    fn present(&self, lane: usize) -> FlexibleState {
        let mut state = FlexibleState { q: [0.0; MOST_FREEDOMS], u: [0.0; MOST_FREEDOMS] };
        for i in 0..self.size() {
            state.q[i] = self.lanes.q[i][lane];
            state.u[i] = self.lanes.u[i][lane];
        }
        state
    }

    fn set_sample(&mut self, lane: usize, sample: &FlexibleSample<'_>) {
        self.inputs[lane] = sample.inputs;
        self.lanes.inputs.preload[lane] = sample.inputs.preload;
        self.lanes.inputs.static_friction[lane] = sample.inputs.static_friction;
        self.lanes.friction_steps[lane] = sample.friction_steps;
    }

    fn set_next(&mut self, lane: usize, state: &FlexibleState) {
        for i in 0..self.size() {
            self.lanes.next_q[i][lane] = state.q[i];
            self.lanes.next_u[i][lane] = state.u[i];
        }
    }
}

impl Bundle for FlexibleBundle<'_> {
    const LANES: usize = LANES;

    type Monitor = FlexibleMonitor;

    fn begin(
        &mut self,
        criterion: &TimeDomain,
        lane: usize,
        inputs: RandomInputs,
    ) -> Result<(ContactState, FlexibleMonitor), Decision> {
        let sample = self.motion.sample(inputs);
        let (motion, monitor) = criterion.start_flexible(&sample, FlexibleBrake::linear_stability)?;
        self.set_sample(lane, &sample);
        self.set_next(lane, &motion.state);
        Ok((motion.contact, monitor))
    }

    fn place(&mut self, criterion: &TimeDomain, lane: usize, inputs: RandomInputs) {
        let sample = self.motion.sample(inputs);
        if let Ok((motion, _)) = criterion.flexible_start(&sample) {
            self.set_sample(lane, &sample);
            self.set_next(lane, &motion.state);
        }
    }

    #[inline]
    fn step(&mut self, set: InstructionSet) {
        let (brake, h) = (&self.motion.brake.equations, self.motion.step);
        let (tables, lanes) = (&self.tables, &mut self.lanes);
        dispatch!(set, flexible_step, brake: &FlexibleEquations, tables: &Tables, lanes: &mut FlexibleArrays, h: f64);
    }

    #[inline]
    fn finding(&self, lane: usize) -> Finding {
        found(self.lanes.findings[lane])
    }

    #[inline]
    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64)) {
        let lanes = &self.lanes;
        let acceleration = (lanes.k[0][0][lane], lanes.k[3][0][lane]);
        (lanes.q[0][lane], (lanes.u[0][lane], lanes.next_u[0][lane]), acceleration)
    }

    #[inline]
    fn next(&self, lane: usize) -> (f64, f64) {
        (self.lanes.next_q[0][lane], self.lanes.next_u[0][lane])
    }

    fn scalar_step(
        &mut self,
        lane: usize,
        contact: ContactState,
        time: f64,
        monitor: &mut Self::Monitor,
    ) -> Result<ContactState, Breakdown> {
        let mut motion = Motion { state: self.present(lane), contact };
        advance(&self.motion.sample(self.inputs[lane]), &mut motion, time, self.motion.step, monitor)?;
        self.set_next(lane, &motion.state);
        Ok(motion.contact)
    }

    #[inline]
    fn commit(&mut self) {
        std::mem::swap(&mut self.lanes.q, &mut self.lanes.next_q);
        std::mem::swap(&mut self.lanes.u, &mut self.lanes.next_u);
    }

    #[inline]
    fn step_length(&self) -> f64 {
        self.motion.step
    }

    fn finish(
        &self,
        criterion: &TimeDomain,
        lane: usize,
        running: &RunningSample<Self::Monitor>,
        steps: u64,
    ) -> Decision {
        let sample = self.motion.sample(self.inputs[lane]);
        let motion = Motion { state: self.present(lane), contact: running.contact };
        criterion.simulate(&sample, motion, running.monitor, self.motion.step, steps)
    }
}
