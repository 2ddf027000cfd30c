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
//! ([`crate::motion::friction_steps`]). [`crate::rigid_disc::planar_motion`] integrates the same equations by an
//! adaptive method; the tests compare the two.

use crate::friction::law::FrictionLaw;
use crate::motion::friction_steps::{DAMPED_STEP, FrictionSteps, LimitedLaw};
use crate::motion::integrator::{Equations, Reserve, Step};
use crate::pad::contact_state::ContactState;
use crate::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::rigid_disc::planar_motion::PlanarMotion;

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
    /// G f_c.
    pub kinetic_pull: f64,
    /// G (f_s - f_c).
    pub falling_pull: f64,
    /// G e, the additional term of the law.
    pub additional_pull: f64,
    /// G f_s.
    pub static_pull: f64,
    /// G mu(0), the most that friction can hold.
    pub holding_pull: f64,
    /// The limits of the steps.
    pub friction_steps: FrictionSteps,
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
        let law = FrictionLaw { static_coefficient: inputs.static_friction, ..self.law };
        RigidSample {
            brake: *self,
            gain,
            kinetic_pull: gain * law.kinetic_coefficient,
            falling_pull: gain * law.falling(),
            additional_pull: gain * law.additional,
            static_pull: gain * law.static_coefficient,
            holding_pull: gain * law.at_rest(),
            friction_steps: self.friction_steps(gain * law.falling(), gain * law.additional),
        }
    }

    /// Whether a sample is stable by definition, see [`PadOnDisc::is_outside_physics`].
    pub fn is_outside_physics(&self, inputs: RandomInputs) -> bool {
        inputs.are_outside_physics(self.law.least_static_coefficient())
    }

    /// The limits that the friction of a sample sets to steps.
    #[inline(always)]
    pub fn friction_steps(&self, falling_pull: f64, additional_pull: f64) -> FrictionSteps {
        let (v, inverse) = (self.disc_speed, self.inverse_stribeck);
        let pulls = (falling_pull, additional_pull);
        FrictionSteps::new(v, inverse, self.limited_law, pulls, self.refinement)
    }
}

impl RigidSample {
    /// x and x' at the four stages of a step.
    pub fn stages(&self, state: &RigidState, contact: ContactState, h: f64) -> [(f64, f64); 4] {
        let RigidState { x, u } = *state;
        let acceleration = |(x, u): (f64, f64)| {
            if contact == ContactState::Stick {
                return 0.0;
            }
            self.pull(contact, u) - self.brake.stiffness * x - self.brake.damping * u
        };
        let half = 0.5 * h;
        let second = (x + half * u, u + half * acceleration((x, u)));
        let third = (x + half * second.1, u + half * acceleration(second));
        let fourth = (x + h * third.1, u + h * acceleration(third));
        [(x, u), second, third, fourth]
    }

    /// mu of slip times G, in the direction of `contact`.
    pub fn pull(&self, contact: ContactState, u: f64) -> f64 {
        let direction = if contact == ContactState::Overtaking { -1.0 } else { 1.0 };
        let r = direction * (self.brake.disc_speed - u) * self.brake.inverse_stribeck;
        let (a, b) = self.brake.law.shape.parts(r, self.brake.law.exponent);
        direction * (self.kinetic_pull + self.falling_pull * a + self.additional_pull * b)
    }

    /// Steady sliding, x0.
    pub fn equilibrium(&self) -> f64 {
        self.pull(ContactState::Slip, 0.0) / self.brake.stiffness
    }

    /// The same motion for the adaptive method.
    pub fn planar_motion(&self) -> PlanarMotion {
        PlanarMotion {
            stiffness: self.brake.stiffness,
            damping: self.brake.damping,
            disc_speed: self.brake.disc_speed,
            law: FrictionLaw {
                static_coefficient: self.static_pull,
                kinetic_coefficient: self.kinetic_pull,
                additional: self.additional_pull,
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
        let RigidState { x, u } = *state;
        if contact == ContactState::Stick {
            return Step { next: RigidState { x: x + h * u, u }, acceleration: (0.0, 0.0) };
        }
        let (stiffness, damping) = (self.brake.stiffness, self.brake.damping);
        let acceleration = |x: f64, u: f64| self.pull(contact, u) - stiffness * x - damping * u;
        let half = 0.5 * h;
        let k1 = acceleration(x, u);
        let u2 = u + half * k1;
        let k2 = acceleration(x + half * u, u2);
        let u3 = u + half * k2;
        let k3 = acceleration(x + half * u2, u3);
        let u4 = u + h * k3;
        let k4 = acceleration(x + h * u3, u4);
        let sixth = h / 6.0;
        let next = RigidState { x: x + h * (u + sixth * (k1 + k2 + k3)), u: u + sixth * (k1 + 2.0 * (k2 + k3) + k4) };
        Step { next, acceleration: (k1, k4) }
    }

    fn acceleration(&self, state: &RigidState, contact: ContactState) -> f64 {
        match contact {
            ContactState::Stick => 0.0,
            _ => self.pull(contact, state.u) - self.brake.stiffness * state.x - self.brake.damping * state.u,
        }
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
