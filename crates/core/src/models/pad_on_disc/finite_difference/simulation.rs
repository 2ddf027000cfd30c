//! The motion of pad and disc on the grid, step by step, and where it starts.

use crate::models::pad_on_disc::finite_difference::brake::{Allotment, FiniteDifferenceBrake, FiniteDifferenceError};
use crate::models::pad_on_disc::finite_difference::pad_on_surface::{PadOnSurface, PadState};
use crate::models::pad_on_disc::finite_difference::patch::{Passage, RingPosition, Surface};
use crate::models::pad_on_disc::finite_difference::plate::motion::PlateMotion;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::motion::advance::advance;
use crate::models::pad_on_disc::motion::integrator::{Motion, Observer};
use crate::models::pad_on_disc::motion::moment::{Moment, RecordedContact};
use crate::models::pad_on_disc::motion::start::{Start, TangentialStart};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::equations::PAD;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{LARGEST_ROTATION, RandomInputs};
use crate::numerics::fixed_point::fixed_point;

/// Change in a round, relative to the pad's displacements, at which an equilibrium is found.
const FOUND: f64 = 1e-13;

/// A motion of pad and disc, and room for what its steps need.
pub(super) struct Simulation<'a> {
    brake: &'a FiniteDifferenceBrake,
    inputs: RandomInputs,
    allotment: Allotment,
    steps: u64,
    pub pad: Motion<PadState>,
    plate: PlateMotion,
    positions: Vec<RingPosition>,
    loads: Vec<f64>,
    before: Surface,
    after: Surface,
}

impl Simulation<'_> {
    fn time(&self) -> f64 {
        self.steps as f64 * self.brake.step_length
    }

    /// One step of disc and pad; false if the computation broke down.
    pub fn step(&mut self, observer: &mut impl Observer) -> bool {
        let (brake, time) = (self.brake, self.time());
        let (plate, patch, step) = (&brake.plate, &brake.patch, &brake.step);
        let at_rest = brake.pad_on(self.inputs, &self.before, &self.before);
        at_rest.loads(&self.pad.state, self.pad.contact, &mut self.loads);
        plate.accelerate(step, &mut self.plate);
        patch.allot(plate, &self.positions, &self.loads, |ring, column, load| {
            plate.push(step, &mut self.plate, ring, column, brake.contact_gain * load);
        });
        plate.drift(step, &mut self.plate);
        self.steps += 1;
        patch.locate(plate, brake.passage(self.allotment, self.steps), &mut self.positions);
        patch.read(plate, &self.plate, &self.positions, &mut self.after);
        let moving = brake.pad_on(self.inputs, &self.before, &self.after);
        let advanced = advance(&moving, &mut self.pad, time, brake.step_length, observer);
        self.pad.state.time = 0.0;
        std::mem::swap(&mut self.before, &mut self.after);
        advanced.is_ok()
    }

    /// Everything that is recorded of this moment.
    pub fn moment(&self) -> Moment {
        let (brake, Motion { state, contact }) = (self.brake, &self.pad);
        let pad = brake.pad_on(self.inputs, &self.before, &self.before);
        let forces = pad.rates(state, *contact).0;
        let touching = pad.gaps(state).map(|gap| if gap > 0.0 { 1.0 } else { 0.0 });
        let contact = RecordedContact {
            state: *contact,
            force: brake.modal.brake.brake().newtons(forces.pressure),
            friction_ratio: forces.friction_ratio,
        };
        Moment {
            contact_share: brake.patch.average(touching),
            deflection: brake.patch.middle(&brake.plate, &self.plate, brake.passage(self.allotment, self.steps)),
            ..Moment::of_pad(self.time(), state.q, state.u, brake.pad().disc_speed, contact)
        }
    }
}

impl FiniteDifferenceBrake {
    fn pad_on<'a>(&'a self, inputs: RandomInputs, before: &'a Surface, after: &'a Surface) -> PadOnSurface<'a> {
        PadOnSurface {
            pad: *self.pad(),
            inputs,
            patch: &self.patch,
            before,
            after,
            length: self.step_length,
            friction_steps: self.modal.friction_steps(inputs, 1.0),
        }
    }

    /// How far the disc has passed after some steps.
    pub(crate) fn passage(&self, allotment: Allotment, steps: u64) -> Passage {
        let (element, around) = (self.steps_per_element, self.plate.columns as u64);
        let whole = |elements: u64| (elements % around) as usize;
        match allotment {
            Allotment::Nodal => Passage { whole: whole((steps + element / 2) / element), part: 0.0 },
            Allotment::Linear => {
                Passage { whole: whole(steps / element), part: (steps % element) as f64 / element as f64 }
            }
        }
    }

    /// Steady sliding: the pad at rest, and the deflection (ring by ring) that the disc has under it.
    pub(super) fn equilibrium(&self, inputs: RandomInputs) -> Result<(PadState, Vec<f64>), FiniteDifferenceError> {
        if inputs.preload.is_nan() || inputs.preload <= 0.0 {
            return Err(FlexibleError::NotPressed { preload: inputs.preload }.into());
        }
        let pad = self.pad();
        let rigid = self.modal.brake.brake().sliding_equilibrium_at(inputs);
        let mut start = vec![rigid.tangential, rigid.normal, rigid.angle];
        start.resize(PAD + self.plate.rings * self.plate.columns, 0.0);
        let stiffness = [
            pad.tangential_stiffness + pad.contact_tangential,
            pad.normal_stiffness + pad.pressure_gain,
            pad.angular_stiffness,
        ];
        let pad_at = |q: &[f64]| PadState { q: [q[0], q[1], q[2]], u: [0.0; PAD], time: 0.0 };
        // In a round each displacement goes against its own stiffness, and the disc to where it is under the loads. On a
        // soft disc rounds alone swing further and further.
        let mut loads = Vec::new();
        let round = |q: &[f64]| {
            let surface = self.surface(&self.plate.at_rest(&q[PAD..]));
            let (at_rest, state) = (self.pad_on(inputs, &surface, &surface), pad_at(q));
            let accelerations = at_rest.rates(&state, ContactState::Slip).1;
            at_rest.loads(&state, ContactState::Slip, &mut loads);
            loads.iter_mut().for_each(|load| *load *= self.contact_gain);
            let moved = q.iter().zip(accelerations).zip(stiffness).map(|((q, rate), stiffness)| q + rate / stiffness);
            Ok::<_, FiniteDifferenceError>(moved.chain(self.steady_deflection(self.spin, &loads)?).collect())
        };
        let found = fixed_point(start, FOUND * rigid.normal.abs(), round)?;
        let RandomInputs { preload, static_friction } = inputs;
        let found = found.ok_or(FlexibleError::NoEquilibrium { preload, static_friction })?;
        if found[2].abs() > LARGEST_ROTATION {
            return Err(FlexibleError::Rotated { angle: found[2] }.into());
        }
        Ok((pad_at(&found), found[PAD..].to_vec()))
    }

    /// A motion at its start, and the equilibrium's x.
    pub(super) fn start(
        &self,
        inputs: RandomInputs,
        start: Start,
        displacement: f64,
        allotment: Allotment,
    ) -> Result<(Simulation<'_>, f64), FiniteDifferenceError> {
        let (mut state, deflection) = self.equilibrium(inputs)?;
        let plate = self.plate.standing_still(&deflection, self.spin, self.step_length);
        let before = self.surface(&plate);
        let equilibrium = state.q[0];
        let release = || self.pad_on(inputs, &before, &before).release(&state);
        let start = start.scaled(self.modal.brake.equations.brake.scales());
        let TangentialStart { x, speed } = start.tangential(displacement, equilibrium, release, self.pad().disc_speed);
        state.q[0] = x;
        state.u[0] = speed;
        (state.q[1], state.q[2]) = start.normal_and_angle((state.q[1], state.q[2]));
        let pad = start.motion(&self.pad_on(inputs, &before, &before), state);
        let mut positions = Vec::new();
        self.patch.locate(&self.plate, Passage::default(), &mut positions);
        let simulation = Simulation {
            brake: self,
            inputs,
            allotment,
            steps: 0,
            pad,
            plate,
            positions,
            loads: Vec::new(),
            before,
            after: Surface::default(),
        };
        Ok((simulation, equilibrium))
    }
}
