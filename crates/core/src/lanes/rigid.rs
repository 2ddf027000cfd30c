//! Lanes of a rigid disc.

use crate::criterion::decision::Decision;
use crate::criterion::rigid_monitor::RigidMonitor;
use crate::criterion::time_domain::TimeDomain;
use crate::friction::tustin_decay;
use crate::lanes::dispatch::{InstructionSet, dispatch};
use crate::lanes::findings::{Finding, findings, found};
use crate::lanes::scheduling::{Bundle, RunningSample};
use crate::motion::advance::advance;
use crate::motion::integrator::{Breakdown, Motion};
use crate::motion::rigid::{RigidBrake, RigidSample, RigidState};
use crate::pad::contact_state::ContactState;
use crate::rigid_disc::pad_on_disc::RandomInputs;

/// Lanes: enough independent chains to hide the latency of the friction law.
pub(super) const LANES: usize = 64;

/// Lanes of a rigid disc.
pub(super) struct RigidBundle<'a> {
    brake: &'a RigidBrake,
    inputs: [RandomInputs; LANES],
    lanes: RigidArrays,
}

struct RigidArrays {
    kinetic_pull: [f64; LANES],
    falling_pull: [f64; LANES],
    x: [f64; LANES],
    u: [f64; LANES],
    next_x: [f64; LANES],
    next_u: [f64; LANES],
    first_acceleration: [f64; LANES],
    last_acceleration: [f64; LANES],
    findings: [u64; LANES],
}

impl<'a> RigidBundle<'a> {
    pub fn new(brake: &'a RigidBrake) -> Self {
        let zero = [0.0; LANES];
        Self {
            brake,
            inputs: [RandomInputs { preload: 0.0, static_friction: 0.0 }; LANES],
            lanes: RigidArrays {
                kinetic_pull: zero,
                falling_pull: zero,
                x: zero,
                u: zero,
                next_x: zero,
                next_u: zero,
                first_acceleration: zero,
                last_acceleration: zero,
                findings: [0; LANES],
            },
        }
    }

    fn present(&self, lane: usize) -> RigidState {
        RigidState { x: self.lanes.x[lane], u: self.lanes.u[lane] }
    }

    fn set_next(&mut self, lane: usize, inputs: RandomInputs, sample: &RigidSample<'_>, state: &RigidState) {
        self.inputs[lane] = inputs;
        self.lanes.kinetic_pull[lane] = sample.kinetic_pull;
        self.lanes.falling_pull[lane] = sample.falling_pull;
        self.lanes.next_x[lane] = state.x;
        self.lanes.next_u[lane] = state.u;
    }
}

impl Bundle for RigidBundle<'_> {
    const LANES: usize = LANES;

    type Monitor = RigidMonitor;

    fn begin(
        &mut self,
        criterion: &TimeDomain,
        lane: usize,
        inputs: RandomInputs,
    ) -> Result<(ContactState, RigidMonitor), Decision> {
        let sample = self.brake.sample(inputs);
        let (motion, monitor) = criterion.start_rigid(&sample, inputs)?;
        self.set_next(lane, inputs, &sample, &motion.state);
        Ok((motion.contact, monitor))
    }

    fn place(&mut self, criterion: &TimeDomain, lane: usize, inputs: RandomInputs) {
        let sample = self.brake.sample(inputs);
        let state = criterion.rigid_start(&sample).state;
        self.set_next(lane, inputs, &sample, &state);
    }

    #[inline]
    fn step(&mut self, set: InstructionSet) {
        let (brake, lanes) = (self.brake, &mut self.lanes);
        dispatch!(set, rigid_step, brake: &RigidBrake, lanes: &mut RigidArrays);
    }

    #[inline]
    fn finding(&self, lane: usize) -> Finding {
        found(self.lanes.findings[lane])
    }

    #[inline]
    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64)) {
        let lanes = &self.lanes;
        let acceleration = (lanes.first_acceleration[lane], lanes.last_acceleration[lane]);
        (lanes.x[lane], (lanes.u[lane], lanes.next_u[lane]), acceleration)
    }

    #[inline]
    fn next(&self, lane: usize) -> (f64, f64) {
        (self.lanes.next_x[lane], self.lanes.next_u[lane])
    }

    fn scalar_step(
        &mut self,
        lane: usize,
        contact: ContactState,
        time: f64,
        monitor: &mut Self::Monitor,
    ) -> Result<ContactState, Breakdown> {
        let sample = self.brake.sample(self.inputs[lane]);
        let mut motion = Motion { state: self.present(lane), contact };
        advance(&sample, &mut motion, time, self.brake.step, monitor)?;
        self.lanes.next_x[lane] = motion.state.x;
        self.lanes.next_u[lane] = motion.state.u;
        Ok(motion.contact)
    }

    #[inline]
    fn commit(&mut self) {
        self.lanes.x = self.lanes.next_x;
        self.lanes.u = self.lanes.next_u;
    }

    #[inline]
    fn step_length(&self) -> f64 {
        self.brake.step
    }

    fn finish(
        &self,
        criterion: &TimeDomain,
        lane: usize,
        running: &RunningSample<Self::Monitor>,
        steps: u64,
    ) -> Decision {
        let sample = self.brake.sample(self.inputs[lane]);
        let motion = Motion { state: self.present(lane), contact: running.contact };
        criterion.simulate(&sample, motion, running.monitor, self.brake.step, steps)
    }
}

/// [`crate::motion::rigid`]'s step of slip.
#[inline(always)]
fn rigid_step(brake: &RigidBrake, lanes: &mut RigidArrays) {
    type Lanes = [f64; LANES];
    let h = brake.step;
    let (half, sixth) = (0.5 * h, h / 6.0);
    let acceleration = |x: &Lanes, u: &Lanes, kinetic: &Lanes, falling: &Lanes, out: &mut Lanes| {
        for i in 0..LANES {
            let ratio = (brake.disc_speed - u[i]) * brake.inverse_stribeck;
            let pull = kinetic[i] + falling[i] * tustin_decay(ratio);
            out[i] = pull - brake.stiffness * x[i] - brake.damping * u[i];
        }
    };
    let RigidArrays { kinetic_pull, falling_pull, x, u, .. } = lanes;
    let [mut k1, mut k2, mut k3, mut k4] = [[0.0; LANES]; 4];
    let [mut stage_x, mut stage_u] = [[0.0; LANES]; 2];
    acceleration(x, u, kinetic_pull, falling_pull, &mut k1);
    for i in 0..LANES {
        stage_x[i] = x[i] + half * u[i];
        stage_u[i] = u[i] + half * k1[i];
    }
    acceleration(&stage_x, &stage_u, kinetic_pull, falling_pull, &mut k2);
    for i in 0..LANES {
        stage_x[i] = x[i] + half * stage_u[i];
        stage_u[i] = u[i] + half * k2[i];
    }
    acceleration(&stage_x, &stage_u, kinetic_pull, falling_pull, &mut k3);
    for i in 0..LANES {
        stage_x[i] = x[i] + h * stage_u[i];
        stage_u[i] = u[i] + h * k3[i];
    }
    acceleration(&stage_x, &stage_u, kinetic_pull, falling_pull, &mut k4);
    for i in 0..LANES {
        lanes.next_x[i] = lanes.x[i] + h * (lanes.u[i] + sixth * (k1[i] + k2[i] + k3[i]));
        lanes.next_u[i] = lanes.u[i] + sixth * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    }
    for i in 0..LANES {
        let (u, acceleration) = ((lanes.u[i], lanes.next_u[i]), (k1[i], k4[i]));
        let steps = brake.friction_steps(lanes.falling_pull[i]);
        lanes.findings[i] = findings(&steps, brake.disc_speed, u, lanes.next_x[i], acceleration, h);
    }
    lanes.first_acceleration = k1;
    lanes.last_acceleration = k4;
}
