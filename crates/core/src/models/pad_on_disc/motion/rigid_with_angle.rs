//! The motion of the pad on a rigid disc with its rotation, for recording.

use crate::models::pad_on_disc::motion::friction_steps::FrictionSteps;
use crate::models::pad_on_disc::motion::integrator::{Equations, Reserve, Step};
use crate::models::pad_on_disc::motion::moment::{Moment, RecordedContact};
use crate::models::pad_on_disc::motion::rigid::{OnBelt, RigidSample, RigidState};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::equations::PadEquations;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, SlidingEquilibrium};
use crate::numerics::runge_kutta::{self, Accelerations};

/// A rigid disc with the pad's rotation, which the tangential motion drives and does not feel.
pub(crate) struct RigidWithAngle {
    sample: RigidSample,
    pad: PadEquations,
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct RigidAngleState {
    pub pad: RigidState,
    phi: f64,
    phi_speed: f64,
}

impl RigidAngleState {
    /// The state of a pad whose rotation is at rest at `phi`.
    pub fn with_angle(pad: RigidState, phi: f64) -> Self {
        Self { pad, phi, phi_speed: 0.0 }
    }
}

impl RigidWithAngle {
    pub fn new(sample: RigidSample, brake: &PadOnDisc) -> Self {
        Self { sample, pad: PadEquations::new(brake) }
    }

    /// Friction over the mass, as it reaches the pad.
    fn friction(&self, x: f64, u: f64, contact: ContactState) -> f64 {
        let brake = &self.sample.brake;
        match contact {
            ContactState::Stick => brake.stiffness * x + brake.damping * u,
            _ => self.sample.pad.friction.at(u, contact.direction()),
        }
    }

    /// Everything that is recorded of a state about an equilibrium.
    pub fn moment(
        &self,
        time: f64,
        state: &RigidAngleState,
        contact: ContactState,
        equilibrium: &SlidingEquilibrium,
        length: f64,
    ) -> Moment {
        let RigidState { x, u } = state.pad;
        let contact = RecordedContact {
            state: contact,
            force: equilibrium.normal_force * length,
            friction_ratio: self.friction(x, u, contact) / self.sample.gain,
        };
        let (q, speeds) = ([x, equilibrium.normal, state.phi], [u, 0.0, state.phi_speed]);
        Moment::of_pad(time, q, speeds, self.sample.brake.disc_speed, contact)
    }
}

/// The motion in one state of contact: the pad as the criterion has it, and the angle.
struct InContact<'a> {
    motion: &'a RigidWithAngle,
    contact: ContactState,
}

impl Accelerations<f64> for InContact<'_> {
    fn accelerations(&mut self, q: &[f64], u: &[f64], accelerations: &mut [f64]) {
        let RigidWithAngle { sample, pad } = self.motion;
        let spring = pad.contact_tangential * q[0] - self.motion.friction(q[0], u[0], self.contact);
        accelerations[0] = OnBelt { pad: &sample.pad, contact: self.contact }.acceleration(q[0], u[0]);
        accelerations[1] = pad.angular_acceleration(q[1], u[1], spring);
    }
}

impl Equations for RigidWithAngle {
    type State = RigidAngleState;

    fn step(&self, state: &RigidAngleState, contact: ContactState, h: f64) -> Step<RigidAngleState> {
        let RigidState { x, u } = state.pad;
        let mut equations = InContact { motion: self, contact };
        let end = runge_kutta::step(&mut equations, 2, (&[x, state.phi], &[u, state.phi_speed]), h);
        let pad = RigidState { x: end.q[0], u: end.u[0] };
        Step { next: RigidAngleState { pad, phi: end.q[1], phi_speed: end.u[1] }, acceleration: end.acceleration }
    }

    fn tangential(&self, state: &RigidAngleState) -> (f64, f64) {
        self.sample.tangential(&state.pad)
    }

    fn disc_speed(&self) -> f64 {
        self.sample.disc_speed()
    }

    fn moving_with_disc(&self, state: &RigidAngleState) -> RigidAngleState {
        RigidAngleState { pad: self.sample.moving_with_disc(&state.pad), ..*state }
    }

    fn reserve(&self, state: &RigidAngleState) -> Reserve {
        self.sample.reserve(&state.pad)
    }

    fn meeting_rate(&self) -> f64 {
        self.sample.meeting_rate()
    }

    fn friction_steps(&self) -> &FrictionSteps {
        self.sample.friction_steps()
    }
}
