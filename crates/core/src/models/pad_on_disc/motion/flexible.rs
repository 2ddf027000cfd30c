//! The motion of pad and flexible disc in time: fixed Runge-Kutta steps of the equations of
//! [`crate::models::pad_on_disc::flexible_disc::equations`].

use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::contact::loads::ContactLoads;
use crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::flexible_disc::plate_modes::MOST_DISC_MODES;
use crate::models::pad_on_disc::motion::friction_steps::{DAMPED_STEP, FrictionSteps};
use crate::models::pad_on_disc::motion::integrator::{Equations, Reserve, Step};
use crate::models::pad_on_disc::motion::moment::{Moment, RecordedContact};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::equations::{ContactForces, PAD};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::numerics::runge_kutta::{self, Accelerations};
use crate::numerics::sine_cosine::sine_and_cosine;

/// Step length times the highest frequency of pad, contact and kept disc modes.
const STEP: f64 = 0.45;

/// Largest number of degrees of freedom.
pub(crate) const MOST_FREEDOMS: usize = PAD + 2 * MOST_DISC_MODES;

/// Pad and flexible disc, and the steps in which their motion is simulated.
#[derive(Debug, Clone)]
pub(crate) struct FlexibleMotion {
    pub brake: FlexibleBrake,
    /// Length of a step.
    pub step: f64,
    /// See [`FrictionSteps::new`].
    pub refinement: f64,
}

/// Displacements and speeds, of which the first [`FlexibleEquations::size`] count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct FlexibleState {
    pub q: [f64; MOST_FREEDOMS],
    pub u: [f64; MOST_FREEDOMS],
}

/// The equations of one sample.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FlexibleSample<'a> {
    pub brake: &'a FlexibleBrake,
    pub inputs: RandomInputs,
    pub friction_steps: FrictionSteps,
}

impl FlexibleMotion {
    pub fn new(brake: FlexibleBrake) -> Self {
        let step = Self::resolving_step(&brake.equations);
        Self { brake, step, refinement: 1.0 }
    }

    /// The same for another brake.
    pub fn with_brake(&self, brake: PadOnDisc) -> Result<Self, FlexibleError> {
        let brake = self.brake.with_brake(brake)?;
        Ok(Self { refinement: self.refinement, ..Self::new(brake) })
    }

    /// The equations of one sample.
    pub fn sample(&self, inputs: RandomInputs) -> FlexibleSample<'_> {
        self.sample_in_finer_steps(inputs, 1.0)
    }

    /// The same for steps divided by `divisor`.
    pub fn sample_in_finer_steps(&self, inputs: RandomInputs, divisor: f64) -> FlexibleSample<'_> {
        FlexibleSample { brake: &self.brake, inputs, friction_steps: self.friction_steps(inputs, divisor) }
    }

    /// The limits that the friction of a sample sets to steps divided by `divisor`.
    pub fn friction_steps(&self, inputs: RandomInputs, divisor: f64) -> FrictionSteps {
        FrictionSteps::of_pad(&self.brake.equations.coefficients.pad, inputs, self.refinement / divisor)
    }

    /// The length of a step that resolves every degree of freedom.
    fn resolving_step(equations: &FlexibleEquations) -> f64 {
        let pad = &equations.coefficients.pad;
        let normal = pad.normal_stiffness + pad.pressure_gain;
        let tangential = pad.tangential_stiffness + pad.contact_tangential;
        let pad_frequencies = [normal, tangential, pad.angular_stiffness].map(f64::sqrt);
        let modes = equations.coefficients.amplitudes.iter().zip(&equations.geometry.patch.averages.largest_shape).map(
            |(amplitude, shape)| {
                // In the space-fixed frame rotation splits the frequency by n Om.
                let spin = 0.5 * amplitude.gyroscopic.abs();
                (amplitude.stiffness + spin * spin + amplitude.compliance * shape * shape).sqrt() + spin
            },
        );
        let fastest = modes.chain(pad_frequencies).fold(0.0, f64::max);
        let dampings =
            [equations.coefficients.disc_damping, pad.tangential_damping, pad.normal_damping, pad.angular_damping];
        let most_damped = dampings.into_iter().fold(0.0, f64::max);
        (STEP / fastest).min(DAMPED_STEP / most_damped)
    }
}

impl FlexibleSample<'_> {
    /// Steady sliding, with nothing moving.
    pub fn equilibrium(&self) -> Result<FlexibleState, FlexibleError> {
        let mut state = FlexibleState { q: [0.0; MOST_FREEDOMS], u: [0.0; MOST_FREEDOMS] };
        let equilibrium = self.brake.sliding_equilibrium(self.inputs)?;
        state.q[..equilibrium.len()].copy_from_slice(&equilibrium);
        Ok(state)
    }

    /// The tangential displacement at which static friction can just hold the pad, everything else as in `state`.
    pub fn release(&self, state: &FlexibleState) -> f64 {
        let (_, forces) = self.pad_rates(state, ContactState::Slip);
        let angle = sine_and_cosine(state.q[2]);
        self.brake.equations.coefficients.pad.release(self.inputs.static_friction, forces.pressure, angle)
    }

    /// Accelerations of the pad alone, and the forces, in a state.
    fn pad_rates(&self, state: &FlexibleState, contact: ContactState) -> ([f64; PAD], ContactForces) {
        let n = self.brake.equations.size();
        self.brake.equations.pad_accelerations(self.inputs, contact, &state.q[..n], &state.u[..n])
    }

    /// Forces and accelerations in a state.
    pub fn rates(&self, state: &FlexibleState, contact: ContactState) -> (ContactForces, [f64; MOST_FREEDOMS]) {
        let n = self.brake.equations.size();
        let mut accelerations = [0.0; MOST_FREEDOMS];
        let mut loads = ContactLoads::zero();
        let forces = self.brake.equations.accelerations(
            self.inputs,
            contact,
            &state.q[..n],
            &state.u[..n],
            &mut loads,
            &mut accelerations[..n],
        );
        (forces, accelerations)
    }

    /// Everything that is recorded of a state.
    pub fn moment(&self, time: f64, state: &FlexibleState, contact: ContactState) -> Moment {
        let equations = &self.brake.equations;
        let geometry = &equations.geometry;
        let (forces, _) = self.rates(state, contact);
        let position = equations.position(&state.q, sine_and_cosine(state.q[2]));
        let amplitudes = &state.q[PAD..equations.size()];
        // The sine shapes vanish at theta = 0.
        let deflection =
            |shapes: &[f64]| amplitudes.iter().zip(shapes).map(|(amplitude, shape)| amplitude * shape).sum::<f64>();
        let contact = RecordedContact {
            state: contact,
            force: equations.brake.newtons(forces.pressure),
            friction_ratio: forces.friction_ratio,
        };
        let pad = |values: &[f64; MOST_FREEDOMS]| [values[0], values[1], values[2]];
        Moment {
            contact_share: geometry.patch.contact_share(position, amplitudes),
            deflection: (deflection(&geometry.shapes_at_edge), deflection(&geometry.shapes_inside)),
            ..Moment::of_pad(time, pad(&state.q), pad(&state.u), equations.coefficients.pad.disc_speed, contact)
        }
    }
}

/// A sample in one state of contact.
struct InContact<'a> {
    sample: &'a FlexibleSample<'a>,
    contact: ContactState,
    loads: ContactLoads,
}

impl Accelerations<f64> for InContact<'_> {
    #[inline]
    fn accelerations(&mut self, q: &[f64], u: &[f64], accelerations: &mut [f64]) {
        let FlexibleSample { brake, inputs, .. } = self.sample;
        brake.equations.accelerations(*inputs, self.contact, q, u, &mut self.loads, accelerations);
    }
}

impl Equations for FlexibleSample<'_> {
    type State = FlexibleState;

    fn step(&self, state: &FlexibleState, contact: ContactState, h: f64) -> Step<FlexibleState> {
        let mut equations = InContact { sample: self, contact, loads: ContactLoads::zero() };
        let end = runge_kutta::step(&mut equations, self.brake.equations.size(), (&state.q, &state.u), h);
        Step { next: FlexibleState { q: end.q, u: end.u }, acceleration: end.acceleration }
    }

    fn acceleration(&self, state: &FlexibleState, contact: ContactState) -> f64 {
        self.pad_rates(state, contact).0[0]
    }

    fn tangential(&self, state: &FlexibleState) -> (f64, f64) {
        (state.q[0], state.u[0])
    }

    fn disc_speed(&self) -> f64 {
        self.brake.equations.coefficients.pad.disc_speed
    }

    fn moving_with_disc(&self, state: &FlexibleState) -> FlexibleState {
        let mut state = *state;
        state.u[0] = self.brake.equations.coefficients.pad.disc_speed;
        state
    }

    fn reserve(&self, state: &FlexibleState) -> Reserve {
        let (_, forces) = self.pad_rates(state, ContactState::Stick);
        let held = self.brake.equations.coefficients.pad.friction_at_rest(self.inputs.static_friction);
        Reserve { against_slip: held - forces.friction_ratio, against_overtaking: held + forces.friction_ratio }
    }

    fn meeting_rate(&self) -> f64 {
        self.brake.equations.coefficients.pad.meeting_rate()
    }

    fn friction_steps(&self) -> &FrictionSteps {
        &self.friction_steps
    }
}
