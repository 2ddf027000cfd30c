//! The tangential motion of the pad on a rigid disc, as the time-domain criterion simulates it.
//!
//! `sin(phi) = 0`, `cos(phi) = 1`, no disc: normal motion and rotation do not act back on the tangential one, and a pad
//! that starts pressed on the disc stays so. What is left is a mass on a moving belt,
//!
//! ```text
//! slip (x' < v):   x'' = G mu(v - x') - K x - C x',     G = (k_t2 / k_t1) N / (M eta0)
//! stick (x' = v):  while |K x + C v| <= G f_s           K = (k_x + k_t2) / (M eta0),  C = c_x sqrt(eta0) / (M eta0)
//! ```
//!
//! in Runge-Kutta steps of a tenth over the natural frequency, shorter where friction is steep
//! ([`crate::models::pad_on_disc::motion::friction_steps`]). [`crate::models::pad_on_disc::rigid_disc::planar_motion`] integrates the same equations by an
//! adaptive method; the tests compare the two.

use crate::friction::law::FrictionLaw;
use crate::models::pad_on_disc::motion::friction_steps::{DAMPED_STEP, FrictionSteps, LimitedLaw};
use crate::models::pad_on_disc::motion::integrator::{Equations, Reserve, Step};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::sliding_friction::SlidingFriction;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::models::pad_on_disc::rigid_disc::planar_motion::PlanarMotion;
use crate::numerics::row::{Number, numbers};
use crate::numerics::runge_kutta::{self, Accelerations};

/// Step length times the natural frequency.
const STEP: f64 = 0.1;

/// The equations at one rotating speed; preload and static friction come with the sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidBrake {
    /// K.
    pub stiffness: f64,
    /// C.
    pub damping: f64,
    /// v.
    pub disc_speed: f64,
    /// The friction law, its static coefficient apart.
    pub law: FrictionLaw,
    limited_law: LimitedLaw,
    /// 1 / v_s, or over another speed scale of the law.
    pub inverse_stribeck: f64,
    /// G for one unit of preload.
    gain_per_preload: f64,
    /// Length of a step.
    pub step: f64,
    /// See [`FrictionSteps::new`].
    pub refinement: f64,
}

/// The equations of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidSample {
    pub brake: RigidBrake,
    /// G.
    pub gain: f64,
    pub pad: MassOnBelt,
    /// G f_s.
    pub static_pull: f64,
    /// G mu(0), the most that friction can hold.
    pub holding_pull: f64,
    /// The limits of the steps.
    pub friction_steps: FrictionSteps,
}

numbers! {
    /// The tangential motion of a sample.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub(crate) struct MassOnBelt<N> {
        /// K.
        pub stiffness: N,
        /// C.
        pub damping: N,
        /// The friction law times G.
        pub friction: SlidingFriction<N>,
    }
}

/// A mass on a belt in one state of contact.
pub(crate) struct OnBelt<'a, N> {
    pub pad: &'a MassOnBelt<N>,
    pub contact: ContactState,
}

impl<N: Number> OnBelt<'_, N> {
    #[inline(always)]
    pub fn acceleration(&self, x: N, u: N) -> N {
        if self.contact == ContactState::Stick {
            return N::default();
        }
        self.pad.friction.at(u, self.contact.direction()) - self.pad.stiffness * x - self.pad.damping * u
    }
}

impl<N: Number> Accelerations<N> for OnBelt<'_, N> {
    #[inline(always)]
    fn accelerations(&mut self, q: &[N], u: &[N], accelerations: &mut [N]) {
        accelerations[0] = self.acceleration(q[0], u[0]);
    }
}

/// x and x'.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidState {
    pub x: f64,
    pub u: f64,
}

impl RigidBrake {
    pub fn new(brake: &PadOnDisc) -> Self {
        let mass = brake.scaled_mass();
        let stiffness = brake.tangential_stiffness() / mass;
        let damping = brake.scaled_tangential_damping() / mass;
        let law = brake.friction_law();
        Self {
            stiffness,
            damping,
            disc_speed: brake.disc_speed(),
            law: *law,
            limited_law: LimitedLaw::new(law.shape, law.exponent),
            inverse_stribeck: 1.0 / law.speed_scale,
            gain_per_preload: brake.friction_transmission() * brake.normal_force_per_preload() / mass,
            step: (STEP / stiffness.sqrt()).min(DAMPED_STEP / damping),
            refinement: 1.0,
        }
    }

    /// With the refinement of steps of another brake, but not their length.
    pub fn refined_as(self, other: &Self) -> Self {
        Self { refinement: other.refinement, ..self }
    }

    pub fn sample(&self, inputs: RandomInputs) -> RigidSample {
        let gain = self.gain_per_preload * inputs.preload;
        let law = self.law.with_static(inputs.static_friction);
        let friction = SlidingFriction {
            shape: law.shape,
            disc_speed: self.disc_speed,
            inverse_stribeck: self.inverse_stribeck,
            exponent: law.exponent,
            kinetic: gain * law.kinetic_coefficient,
            falling: gain * law.falling(),
            additional: gain * law.additional,
        };
        let pulls = (friction.falling, friction.additional);
        RigidSample {
            brake: *self,
            gain,
            pad: MassOnBelt { stiffness: self.stiffness, damping: self.damping, friction },
            static_pull: gain * law.static_coefficient,
            holding_pull: gain * law.at_rest(),
            friction_steps: FrictionSteps::new(
                self.disc_speed,
                self.inverse_stribeck,
                self.limited_law,
                pulls,
                self.refinement,
            ),
        }
    }

    /// Whether a sample is stable by definition, see [`PadOnDisc::is_outside_physics`].
    pub fn is_outside_physics(&self, inputs: RandomInputs) -> bool {
        inputs.are_outside_physics(self.law.least_static_coefficient(self.disc_speed))
    }
}

impl RigidSample {
    /// Steady sliding, x0.
    pub fn equilibrium(&self) -> f64 {
        self.pad.friction.at(0.0, 1.0) / self.brake.stiffness
    }

    /// The same motion for the adaptive method.
    pub fn planar_motion(&self) -> PlanarMotion {
        PlanarMotion {
            stiffness: self.brake.stiffness,
            damping: self.brake.damping,
            disc_speed: self.brake.disc_speed,
            law: FrictionLaw {
                static_coefficient: self.static_pull,
                kinetic_coefficient: self.pad.friction.kinetic,
                additional: self.pad.friction.additional,
                speed_scale: 1.0 / self.brake.inverse_stribeck,
                ..self.brake.law
            },
        }
    }

    /// Where static friction can hold the pad no longer.
    pub fn release(&self) -> f64 {
        (self.holding_pull - self.brake.damping * self.brake.disc_speed) / self.brake.stiffness
    }
}

impl Equations for RigidSample {
    type State = RigidState;

    #[inline(always)]
    fn step(&self, state: &RigidState, contact: ContactState, h: f64) -> Step<RigidState> {
        let mut equations = OnBelt { pad: &self.pad, contact };
        let end = runge_kutta::step(&mut equations, 1, (&[state.x], &[state.u]), h);
        Step { next: RigidState { x: end.q[0], u: end.u[0] }, acceleration: end.acceleration }
    }

    fn acceleration(&self, state: &RigidState, contact: ContactState) -> f64 {
        OnBelt { pad: &self.pad, contact }.acceleration(state.x, state.u)
    }

    fn tangential(&self, state: &RigidState) -> (f64, f64) {
        (state.x, state.u)
    }

    fn disc_speed(&self) -> f64 {
        self.brake.disc_speed
    }

    fn moving_with_disc(&self, state: &RigidState) -> RigidState {
        RigidState { x: state.x, u: self.brake.disc_speed }
    }

    fn reserve(&self, state: &RigidState) -> Reserve {
        let needed = self.brake.stiffness * state.x + self.brake.damping * self.brake.disc_speed;
        Reserve { against_slip: self.holding_pull - needed, against_overtaking: self.holding_pull + needed }
    }

    fn meeting_rate(&self) -> f64 {
        self.brake.disc_speed * self.brake.stiffness.sqrt()
    }

    fn friction_steps(&self) -> &FrictionSteps {
        &self.friction_steps
    }
}

#[cfg(test)]
mod tests;
