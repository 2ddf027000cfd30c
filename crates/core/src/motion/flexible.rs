//! Pad and flexible disc followed in time: fixed Runge-Kutta steps of the equations of [`crate::flexible_disc::brake`].

use crate::flexible_disc::brake::{ContactForces, ContactState, FlexibleBrake, FlexibleError, PAD, sine_and_cosine};
use crate::flexible_disc::contact::{ContactLoads, MOST_AMPLITUDES};
use crate::motion::friction_steps::FrictionSteps;
use crate::motion::integrator::{Equations, Reserve, Step};
use crate::rigid_disc::pad_on_disc::RandomInputs;

/// Step length times the highest frequency of pad, contact and kept disc modes.
const STEP: f64 = 0.45;

/// Step length times the highest damping rate: the method is stable up to 2.8.
pub(crate) const DAMPED_STEP: f64 = 1.0;

/// Degrees of freedom at the most.
pub(crate) const MOST_FREEDOMS: usize = PAD + MOST_AMPLITUDES;

/// Displacements and speeds, of which the first [`FlexibleBrake::size`] count.
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

impl FlexibleBrake {
    /// The length of a step.
    pub(crate) fn step_length(&self) -> f64 {
        self.step
    }

    /// What the friction law asks of the steps of a sample.
    pub(crate) fn friction_steps(&self, inputs: RandomInputs) -> FrictionSteps {
        let (pad, brake) = (&self.pad, self.brake());
        // With the contact force on a rigid disc, which no motion exceeds by much.
        let gain = pad.transmission * brake.normal_force_per_preload() / brake.scaled_mass() * inputs.preload;
        let falling_pull = gain * (inputs.static_friction - pad.kinetic_friction).max(0.0);
        FrictionSteps::new(pad.disc_speed, pad.inverse_stribeck, pad.stribeck_exponent, falling_pull, self.refinement)
    }

    /// The length of a step that resolves every degree of freedom.
    pub(crate) fn resolving_step(&self) -> f64 {
        let pad = &self.pad;
        let normal = pad.normal_stiffness + pad.pressure_gain;
        let tangential = pad.tangential_stiffness + pad.contact_tangential;
        let pad_frequencies = [normal, tangential, pad.angular_stiffness].map(f64::sqrt);
        let modes = self.amplitudes.iter().zip(&self.patch.averages.largest_shape).map(|(amplitude, shape)| {
            // In the space-fixed frame rotation splits the frequency by n Om.
            let spin = 0.5 * amplitude.gyroscopic.abs();
            (amplitude.stiffness + spin * spin + amplitude.compliance * shape * shape).sqrt() + spin
        });
        let fastest = modes.chain(pad_frequencies).fold(0.0, f64::max);
        let dampings = [self.disc_damping, pad.tangential_damping, pad.normal_damping, pad.angular_damping];
        let most_damped = dampings.into_iter().fold(0.0, f64::max);
        (STEP / fastest).min(DAMPED_STEP / most_damped)
    }
}

impl<'a> FlexibleSample<'a> {
    pub fn new(brake: &'a FlexibleBrake, inputs: RandomInputs) -> Self {
        Self { brake, inputs, friction_steps: brake.friction_steps(inputs) }
    }

    /// Steady sliding, with nothing moving.
    pub fn equilibrium(&self) -> Result<FlexibleState, FlexibleError> {
        let mut state = FlexibleState { q: [0.0; MOST_FREEDOMS], u: [0.0; MOST_FREEDOMS] };
        let equilibrium = self.brake.sliding_equilibrium(self.inputs)?;
        state.q[..equilibrium.len()].copy_from_slice(&equilibrium);
        Ok(state)
    }

    /// The tangential displacement at which static friction can just hold the pad, everything else as in `state`.
    pub fn release(&self, state: &FlexibleState) -> f64 {
        let pad = &self.brake.pad;
        let (forces, _) = self.rates(state, ContactState::Slip);
        let (sine, cosine) = sine_and_cosine(state.q[2]);
        let friction = pad.transmission * self.inputs.static_friction * forces.pressure;
        (friction * cosine - forces.pressure * sine - pad.tangential_damping * pad.disc_speed)
            / (pad.tangential_stiffness + pad.contact_tangential * cosine)
    }

    /// Forces and accelerations in a state.
    pub fn rates(&self, state: &FlexibleState, contact: ContactState) -> (ContactForces, [f64; MOST_FREEDOMS]) {
        let n = self.brake.size();
        let mut accelerations = [0.0; MOST_FREEDOMS];
        let mut loads = ContactLoads::zero();
        let forces = self.brake.accelerations(
            self.inputs,
            contact,
            &state.q[..n],
            &state.u[..n],
            &mut loads,
            &mut accelerations[..n],
        );
        (forces, accelerations)
    }
}

impl Equations for FlexibleSample<'_> {
    type State = FlexibleState;

    #[allow(clippy::needless_range_loop, reason = "arrays by one index read like the formula, and like the lanes")]
    fn step(&self, state: &FlexibleState, contact: ContactState, h: f64) -> Step<FlexibleState> {
        let n = self.brake.size();
        let (half, sixth) = (0.5 * h, h / 6.0);
        let mut stage = *state;
        let k1 = self.rates(&stage, contact).1;
        for i in 0..n {
            stage.q[i] = state.q[i] + half * state.u[i];
            stage.u[i] = state.u[i] + half * k1[i];
        }
        let k2 = self.rates(&stage, contact).1;
        for i in 0..n {
            stage.q[i] = state.q[i] + half * stage.u[i];
            stage.u[i] = state.u[i] + half * k2[i];
        }
        let k3 = self.rates(&stage, contact).1;
        for i in 0..n {
            stage.q[i] = state.q[i] + h * stage.u[i];
            stage.u[i] = state.u[i] + h * k3[i];
        }
        let k4 = self.rates(&stage, contact).1;
        let mut next = *state;
        for i in 0..n {
            next.q[i] = state.q[i] + h * (state.u[i] + sixth * (k1[i] + k2[i] + k3[i]));
            next.u[i] = state.u[i] + sixth * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
        }
        Step { next, acceleration: (k1[0], k4[0]) }
    }

    fn tangential(&self, state: &FlexibleState) -> (f64, f64) {
        (state.q[0], state.u[0])
    }

    fn disc_speed(&self) -> f64 {
        self.brake.pad.disc_speed
    }

    fn moving_with_disc(&self, state: &FlexibleState) -> FlexibleState {
        let mut state = *state;
        state.u[0] = self.brake.pad.disc_speed;
        state
    }

    fn reserve(&self, state: &FlexibleState) -> Reserve {
        let forces = self.rates(state, ContactState::Stick).0;
        Reserve {
            against_slip: self.inputs.static_friction - forces.friction_ratio,
            against_overtaking: self.inputs.static_friction + forces.friction_ratio,
        }
    }

    fn meeting_rate(&self) -> f64 {
        self.brake.pad.meeting_rate()
    }

    fn friction_steps(&self) -> &FrictionSteps {
        &self.friction_steps
    }
}
