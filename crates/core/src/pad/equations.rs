//! The pad's equations of motion.
//!
//! With `mu s` the friction coefficient with its direction, `P` the contact force and `F = mu s P`, all forces divided
//! by h:
//!
//! ```text
//! M eta0 x''     + c_x sqrt(eta0) x'     + k_x x + P sin(phi) + S cos(phi)           = 0,    S = k_t2 (x - F / k_t1)
//! M eta0 y''     + c_y sqrt(eta0) y'     + k_y (Delta + y) - P cos(phi) + S sin(phi) = 0
//! I_s eta0 phi'' + c_s sqrt(eta0) phi'   + k_s phi + S h q / 2                       = 0
//! ```
//!
//! (the paper's equation 2.5). While pad and disc stick, `x''` is zero and `mu s` is the friction that this takes, over
//! the pressure.
//!
//! The paper writes the sign of the sliding speed before the whole of S. A contact spring that turns into its opposite
//! when the pad overtakes the disc has no state of stick to return to. Here friction alone changes its direction, which
//! is the same in all motion with `x' <= v`.

use crate::friction::shape::Shape;
use crate::pad::contact_state::ContactState;
use crate::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// Degrees of freedom of the pad: x, y and phi. They come before the amplitudes of a disc.
pub(crate) const PAD: usize = 3;

/// Coefficients of the pad's equations of motion, for scaled time and divided by `M eta0` or `I_s eta0`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PadEquations {
    pub tangential_damping: f64,
    pub tangential_stiffness: f64,
    /// k_t2 / M.
    pub contact_tangential: f64,
    pub normal_damping: f64,
    pub normal_stiffness: f64,
    pub angular_damping: f64,
    pub angular_stiffness: f64,
    /// (h q / 2) M / I_s: angular acceleration for one unit of S.
    pub arm: f64,
    /// k_en / M.
    pub pressure_gain: f64,
    /// k_t2 / k_t1.
    pub transmission: f64,
    /// `(k_t2 / k_t1) N / M` on a rigid disc for one unit of preload.
    pub friction_per_preload: f64,
    /// v.
    pub disc_speed: f64,
    pub friction_shape: Shape,
    /// 1 / v_s, or over another speed scale of the law.
    pub inverse_stribeck: f64,
    pub stribeck_exponent: f64,
    pub kinetic_friction: f64,
    /// e of the law, and e b(0).
    pub additional_friction: f64,
    pub additional_at_rest: f64,
}

/// Forces at the contact in one state, divided by the pad's mass over scaled time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct ContactForces {
    /// P / (M eta0).
    pub pressure: f64,
    /// mu s: friction over pressure; infinite for a pad that is to stick without pressure.
    pub friction_ratio: f64,
}

impl ContactForces {
    /// Friction over pressure as it acts: none without pressure, however large the ratio.
    #[inline(always)]
    pub fn acting_ratio(&self) -> f64 {
        if self.pressure > 0.0 { self.friction_ratio } else { 0.0 }
    }
}

impl PadEquations {
    pub fn new(brake: &PadOnDisc) -> Self {
        let parameters = brake.parameters();
        let stiffness = &parameters.stiffness;
        let (mass, law) = (brake.scaled_mass(), brake.friction_law());
        let (normal, angular) = (brake.normal_oscillator(), brake.angular_oscillator());
        Self {
            tangential_damping: brake.scaled_tangential_damping() / mass,
            tangential_stiffness: stiffness.calliper_tangential / mass,
            contact_tangential: stiffness.contact_tangential_2 / mass,
            normal_damping: normal.damping,
            normal_stiffness: stiffness.calliper_normal / mass,
            angular_damping: angular.damping,
            angular_stiffness: angular.stiffness,
            arm: brake.angular_arm(),
            pressure_gain: stiffness.contact_normal / mass,
            transmission: brake.friction_transmission(),
            friction_per_preload: brake.friction_transmission() * brake.normal_force_per_preload() / mass,
            disc_speed: brake.disc_speed(),
            friction_shape: law.shape,
            inverse_stribeck: 1.0 / law.speed_scale,
            stribeck_exponent: law.exponent,
            kinetic_friction: law.kinetic_coefficient,
            additional_friction: law.additional,
            additional_at_rest: law.additional_at_rest(),
        }
    }

    /// Accelerations of x, y and phi, and the forces at the contact. `q` and `u` hold x, y and phi and their speeds
    /// first, `sine` and `cosine` are those of phi, `pressure` is `P / (M eta0)`.
    #[inline(always)]
    pub fn accelerations(
        &self,
        inputs: RandomInputs,
        contact: ContactState,
        q: &[f64],
        u: &[f64],
        (sine, cosine): (f64, f64),
        pressure: f64,
    ) -> ([f64; PAD], ContactForces) {
        let pull = self.tangential_damping * u[0] + self.tangential_stiffness * q[0] + pressure * sine;
        let (spring, friction_ratio) = match contact {
            ContactState::Stick => {
                let spring = -pull / cosine;
                let friction = self.contact_tangential * q[0] - spring;
                let ratio = if pressure > 0.0 {
                    friction / (self.transmission * pressure)
                } else {
                    f64::INFINITY.copysign(friction)
                };
                (spring, ratio)
            }
            ContactState::Slip | ContactState::Overtaking => {
                let ratio = if contact == ContactState::Slip {
                    self.friction_coefficient(self.disc_speed - u[0], inputs.static_friction)
                } else {
                    -self.friction_coefficient(u[0] - self.disc_speed, inputs.static_friction)
                };
                (self.contact_tangential * q[0] - self.transmission * ratio * pressure, ratio)
            }
        };
        let tangential = if contact == ContactState::Stick { 0.0 } else { -(pull + spring * cosine) };
        let normal = -(self.normal_damping * u[1] + self.normal_stiffness * (inputs.preload + q[1])
            - pressure * cosine
            + spring * sine);
        let angular = self.angular_acceleration(q[2], u[2], spring);
        ([tangential, normal, angular], ContactForces { pressure, friction_ratio })
    }

    /// phi'' under the force S of the contact spring, divided by the mass.
    #[inline(always)]
    pub fn angular_acceleration(&self, angle: f64, speed: f64, spring: f64) -> f64 {
        -(self.angular_damping * speed + self.angular_stiffness * angle + self.arm * spring)
    }

    /// mu at a sliding speed, see [`Shape::parts`].
    #[inline(always)]
    pub fn friction_coefficient(&self, sliding_speed: f64, static_friction: f64) -> f64 {
        let (a, b) = self.friction_shape.parts(sliding_speed * self.inverse_stribeck, self.stribeck_exponent);
        self.kinetic_friction + (static_friction - self.kinetic_friction) * a + self.additional_friction * b
    }

    /// f_s with which the friction coefficient of steady sliding is `mu`.
    pub fn static_friction_for(&self, mu: f64) -> f64 {
        let (a, b) = self.friction_shape.parts(self.disc_speed * self.inverse_stribeck, self.stribeck_exponent);
        let falling = mu - self.kinetic_friction - self.additional_friction * b;
        if falling == 0.0 { self.kinetic_friction } else { self.kinetic_friction + falling / a }
    }

    /// mu at rest, the most that friction can hold.
    #[inline(always)]
    pub fn friction_at_rest(&self, static_friction: f64) -> f64 {
        static_friction + self.additional_at_rest
    }

    /// x at which static friction can just hold a pad that moves with the disc, under this pressure.
    pub fn release(&self, static_friction: f64, pressure: f64, (sine, cosine): (f64, f64)) -> f64 {
        let friction = self.transmission * self.friction_at_rest(static_friction) * pressure;
        (friction * cosine - pressure * sine - self.tangential_damping * self.disc_speed)
            / (self.tangential_stiffness + self.contact_tangential * cosine)
    }

    /// The disc's speed times the natural frequency of the tangential motion.
    pub fn meeting_rate(&self) -> f64 {
        self.disc_speed * (self.tangential_stiffness + self.contact_tangential).sqrt()
    }

    /// The amplitude of an oscillation at the natural frequency of the tangential motion that is as fast as the disc.
    pub fn smallest_cycle(&self) -> f64 {
        self.disc_speed / (self.tangential_stiffness + self.contact_tangential).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn accelerations(contact: ContactState, q: [f64; 3], speed: f64, pressure: f64) -> ([f64; 3], ContactForces) {
        let pad = PadEquations::new(&PadOnDisc::preset_with(&[]));
        let inputs = RandomInputs { preload: 0.1, static_friction: 0.39 };
        pad.accelerations(inputs, contact, &q, &[speed, 0.0, 0.0], (0.0, 1.0), pressure)
    }

    #[test]
    fn a_pad_that_is_to_stick_without_pressure_needs_infinite_friction_against_its_springs() {
        for (x, sign) in [(0.01, 1.0), (-0.01, -1.0)] {
            let (_, forces) = accelerations(ContactState::Stick, [x, 0.0, 0.0], 0.0, 0.0);
            assert_eq!(forces.friction_ratio, sign * f64::INFINITY, "{x}");
            assert_eq!(forces.acting_ratio(), 0.0);
        }
    }

    #[test]
    fn friction_in_stick_is_what_a_slipping_pad_would_need_to_keep_its_speed() {
        let q = [0.01, -0.05, 0.0];
        let ([tangential, ..], stick) = accelerations(ContactState::Stick, q, 0.1, 2.0);
        assert_eq!(tangential, 0.0);
        let pad = PadEquations::new(&PadOnDisc::preset_with(&[]));
        let friction = pad.transmission * stick.friction_ratio * stick.pressure;
        let held = (pad.tangential_stiffness + pad.contact_tangential) * q[0] + pad.tangential_damping * 0.1;
        assert!((friction / held - 1.0).abs() < 1e-14, "{friction} {held}");
    }
}
