//! The equations of the pad on a surface that moves in a known way.

use crate::models::pad_on_disc::finite_difference::patch::{MovingPatch, Surface};
use crate::models::pad_on_disc::motion::friction_steps::FrictionSteps;
use crate::models::pad_on_disc::motion::integrator::{Equations, Reserve, Step};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::equations::{ContactForces, PAD, PadEquations};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::numerics::runge_kutta::{self, Accelerations};
use crate::numerics::sine_cosine::sine_and_cosine;

/// x, y and phi with their speeds, at a time after the beginning of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PadState {
    pub q: [f64; PAD],
    pub u: [f64; PAD],
    pub time: f64,
}

/// The equations of the pad on a surface that moves in a known way.
pub(super) struct PadOnSurface<'a> {
    pub pad: PadEquations,
    pub inputs: RandomInputs,
    pub patch: &'a MovingPatch,
    /// The surface at the beginning of a step, and after its length.
    pub before: &'a Surface,
    pub after: &'a Surface,
    pub length: f64,
    pub friction_steps: FrictionSteps,
}

impl PadOnSurface<'_> {
    /// `g+` of every point.
    pub fn gaps(&self, state: &PadState) -> impl Iterator<Item = f64> {
        let (sine, cosine) = sine_and_cosine(state.q[2]);
        let (normal, tilt, share) = (state.q[1], sine / cosine, state.time / self.length);
        let surface = self.before.deflections.iter().zip(&self.after.deflections);
        surface.zip(&self.patch.points).map(move |((before, after), point)| {
            let gap = before + share * (after - before) - normal - point.arc * tilt;
            if gap > 0.0 { gap } else { 0.0 }
        })
    }

    /// Forces and accelerations in a state.
    pub fn rates(&self, state: &PadState, contact: ContactState) -> (ContactForces, [f64; PAD]) {
        let pressure = self.pad.pressure_gain * self.patch.average(self.gaps(state));
        let angle = sine_and_cosine(state.q[2]);
        let (accelerations, forces) =
            self.pad.accelerations(&self.inputs.into(), contact.into(), &state.q, &state.u, angle, pressure);
        (forces, accelerations)
    }

    /// The loads on the points at the beginning of the step, with a unit of contact gain.
    pub fn loads(&self, state: &PadState, contact: ContactState, loads: &mut Vec<f64>) {
        let ratio = self.rates(state, contact).0.acting_ratio();
        let weighted = self.gaps(state).zip(&self.before.slopes).zip(&self.patch.points);
        loads.clear();
        loads.extend(weighted.map(|((gap, slope), point)| -point.weight * gap * (1.0 + ratio * slope)));
    }

    /// The tangential displacement at which static friction can just hold the pad.
    pub fn release(&self, state: &PadState) -> f64 {
        let pressure = self.rates(state, ContactState::Slip).0.pressure;
        self.pad.release(self.inputs.static_friction, pressure, sine_and_cosine(state.q[2]))
    }
}

/// The pad in one state of contact. The time is a fourth displacement, with the speed 1.
struct InContact<'a> {
    pad: &'a PadOnSurface<'a>,
    contact: ContactState,
}

impl Accelerations<f64> for InContact<'_> {
    fn accelerations(&mut self, q: &[f64], u: &[f64], accelerations: &mut [f64]) {
        accelerations[..PAD].copy_from_slice(&self.pad.rates(&PadState::from_coordinates(q, u), self.contact).1);
        accelerations[PAD] = 0.0;
    }
}

impl PadState {
    fn from_coordinates(q: &[f64], u: &[f64]) -> Self {
        Self { q: [q[0], q[1], q[2]], u: [u[0], u[1], u[2]], time: q[PAD] }
    }
}

impl Equations for PadOnSurface<'_> {
    type State = PadState;

    fn step(&self, state: &PadState, contact: ContactState, h: f64) -> Step<PadState> {
        let PadState { q, u, .. } = state;
        let (q, u) = ([q[0], q[1], q[2], state.time], [u[0], u[1], u[2], 1.0]);
        let end = runge_kutta::step(&mut InContact { pad: self, contact }, PAD + 1, (&q, &u), h);
        Step { next: PadState::from_coordinates(&end.q, &end.u), acceleration: end.acceleration }
    }

    fn tangential(&self, state: &PadState) -> (f64, f64) {
        (state.q[0], state.u[0])
    }

    fn disc_speed(&self) -> f64 {
        self.pad.disc_speed
    }

    fn moving_with_disc(&self, state: &PadState) -> PadState {
        PadState { u: [self.pad.disc_speed, state.u[1], state.u[2]], ..*state }
    }

    fn reserve(&self, state: &PadState) -> Reserve {
        let needed = self.rates(state, ContactState::Stick).0.friction_ratio;
        let available = self.inputs.static_friction;
        Reserve { against_slip: available - needed, against_overtaking: available + needed }
    }

    fn meeting_rate(&self) -> f64 {
        self.pad.meeting_rate()
    }

    fn friction_steps(&self) -> &FrictionSteps {
        &self.friction_steps
    }
}
