//! The motion of the pad on a rigid disc with its rotation, for recording.

use crate::motion::friction_steps::FrictionSteps;
use crate::motion::integrator::{Equations, Reserve, Step};
use crate::motion::moment::{Moment, RecordedContact};
use crate::motion::rigid::{RigidSample, RigidState};
use crate::pad::contact_state::ContactState;
use crate::pad::equations::PadEquations;
use crate::rigid_disc::pad_on_disc::{PadOnDisc, SlidingEquilibrium};

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
            _ => self.sample.pull(contact, u),
        }
    }

    fn angular_acceleration(&self, pad: (f64, f64), phi: (f64, f64), contact: ContactState) -> f64 {
        let spring = self.pad.contact_tangential * pad.0 - self.friction(pad.0, pad.1, contact);
        self.pad.angular_acceleration(phi.0, phi.1, spring)
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

impl Equations for RigidWithAngle {
    type State = RigidAngleState;

    fn step(&self, state: &RigidAngleState, contact: ContactState, h: f64) -> Step<RigidAngleState> {
        // The pad exactly as the criterion steps it; the angle through the same stages of the method.
        let step = self.sample.step(&state.pad, contact, h);
        let stages = self.sample.stages(&state.pad, contact, h);
        let (half, sixth) = (0.5 * h, h / 6.0);
        let (p, w) = (state.phi, state.phi_speed);
        let a = |stage: usize, p: f64, w: f64| self.angular_acceleration(stages[stage], (p, w), contact);
        let k1 = a(0, p, w);
        let w2 = w + half * k1;
        let k2 = a(1, p + half * w, w2);
        let w3 = w + half * k2;
        let k3 = a(2, p + half * w2, w3);
        let w4 = w + h * k3;
        let k4 = a(3, p + h * w3, w4);
        let next = RigidAngleState {
            pad: step.next,
            phi: p + h * (w + sixth * (k1 + k2 + k3)),
            phi_speed: w + sixth * (k1 + 2.0 * (k2 + k3) + k4),
        };
        Step { next, acceleration: step.acceleration }
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
