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
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::sliding_friction::SlidingFriction;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::numerics::row::{Number, numbers};

/// Degrees of freedom of the pad: x, y and phi. They come before the amplitudes of a disc.
pub(crate) const PAD: usize = 3;

numbers! {
    /// Coefficients of the pad's equations of motion, for scaled time and divided by `M eta0` or `I_s eta0`.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub(crate) struct PadEquations<N> {
        pub tangential_damping: N,
        pub tangential_stiffness: N,
        /// k_t2 / M.
        pub contact_tangential: N,
        pub normal_damping: N,
        pub normal_stiffness: N,
        pub angular_damping: N,
        pub angular_stiffness: N,
        /// (h q / 2) M / I_s: angular acceleration for one unit of S.
        pub arm: N,
        /// k_en / M.
        pub pressure_gain: N,
        /// k_t2 / k_t1.
        pub transmission: N,
        /// `(k_t2 / k_t1) N / M` on a rigid disc for one unit of preload.
        pub friction_per_preload: N,
        /// v.
        pub disc_speed: N,
        pub friction_shape: Shape,
        /// 1 / v_s, or over another speed scale of the law.
        pub inverse_stribeck: N,
        pub stribeck_exponent: N,
        pub kinetic_friction: N,
        /// e of the law, and e b(0).
        pub additional_friction: N,
        pub additional_at_rest: N,
    }
}

numbers! {
    /// What differs between samples of one brake.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub(crate) struct PadInputs<N> {
        /// Delta.
        pub preload: N,
        /// f_s.
        pub static_friction: N,
    }
}

impl From<RandomInputs> for PadInputs {
    #[inline(always)]
    fn from(RandomInputs { preload, static_friction }: RandomInputs) -> Self {
        Self { preload, static_friction }
    }
}

/// The state of contact: the pad sticks where `sticks` is 1 and not 0; elsewhere friction has this direction, see
/// [`SlidingFriction::at`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact<N> {
    pub sticks: N,
    pub direction: f64,
}

impl From<ContactState> for Contact<f64> {
    #[inline(always)]
    fn from(state: ContactState) -> Self {
        Self { sticks: if state == ContactState::Stick { 1.0 } else { 0.0 }, direction: state.direction() }
    }
}

/// Forces at the contact in one state, divided by the pad's mass over scaled time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct ContactForces<N = f64> {
    /// P / (M eta0).
    pub pressure: N,
    /// mu s: friction over pressure; infinite for a pad that is to stick without pressure.
    pub friction_ratio: N,
}

impl<N: Number> ContactForces<N> {
    /// Friction over pressure as it acts: none without pressure, however large the ratio.
    #[inline(always)]
    pub fn acting_ratio(&self) -> N {
        self.pressure.zip(self.friction_ratio, |pressure, ratio| if pressure > 0.0 { ratio } else { 0.0 })
    }
}

impl<N: Number> PadEquations<N> {
    /// Accelerations of x, y and phi, and the forces at the contact. `q` and `u` hold x, y and phi and their speeds
    /// first, `sine` and `cosine` are those of phi, `pressure` is `P / (M eta0)`.
    #[inline(always)]
    pub fn accelerations(
        &self,
        inputs: &PadInputs<N>,
        contact: Contact<N>,
        q: &[N],
        u: &[N],
        (sine, cosine): (N, N),
        pressure: N,
    ) -> ([N; PAD], ContactForces<N>) {
        let Contact { sticks, direction } = contact;
        let (mut spring, mut friction_ratio, mut tangential) = (N::default(), N::default(), N::default());
        if !sticks.all() {
            friction_ratio = self.friction(inputs.static_friction).at(u[0], direction);
            spring = self.contact_tangential * q[0] - self.transmission * friction_ratio * pressure;
            tangential = -(self.pull(q, u, sine, pressure) + spring * cosine);
        }
        if sticks.any() {
            let (spring_in_stick, ratio_in_stick) = self.hold(q, u, (sine, cosine), pressure);
            spring = sticks.choose(spring_in_stick, spring);
            friction_ratio = sticks.choose(ratio_in_stick, friction_ratio);
            tangential = sticks.choose(N::default(), tangential);
        }
        let normal = -(self.normal_damping * u[1] + self.normal_stiffness * (inputs.preload + q[1])
            - pressure * cosine
            + spring * sine);
        let angular = self.angular_acceleration(q[2], u[2], spring);
        ([tangential, normal, angular], ContactForces { pressure, friction_ratio })
    }

    /// The force of all springs and dampers but the tangential contact's, against x.
    #[inline(always)]
    fn pull(&self, q: &[N], u: &[N], sine: N, pressure: N) -> N {
        self.tangential_damping * u[0] + self.tangential_stiffness * q[0] + pressure * sine
    }

    /// The force S of the contact spring that keeps the pad moving with the disc, and the friction that it takes over
    /// the pressure.
    #[inline(always)]
    pub fn hold(&self, q: &[N], u: &[N], (sine, cosine): (N, N), pressure: N) -> (N, N) {
        let spring = -self.pull(q, u, sine, pressure) / cosine;
        let friction = self.contact_tangential * q[0] - spring;
        let ratio = friction / (self.transmission * pressure);
        let without_pressure = friction.map(|friction| f64::INFINITY.copysign(friction));
        let is_pressed = pressure.map(|pressure| if pressure > 0.0 { 1.0 } else { 0.0 });
        (spring, is_pressed.choose(ratio, without_pressure))
    }

    /// phi'' under the force S of the contact spring, divided by the mass.
    #[inline(always)]
    pub fn angular_acceleration(&self, angle: N, speed: N, spring: N) -> N {
        -(self.angular_damping * speed + self.angular_stiffness * angle + self.arm * spring)
    }

    /// The friction law of a sample.
    #[inline(always)]
    pub fn friction(&self, static_friction: N) -> SlidingFriction<N> {
        SlidingFriction {
            shape: self.friction_shape,
            disc_speed: self.disc_speed,
            inverse_stribeck: self.inverse_stribeck,
            exponent: self.stribeck_exponent,
            kinetic: self.kinetic_friction,
            falling: static_friction - self.kinetic_friction,
            additional: self.additional_friction,
        }
    }

    /// mu at rest, the most that friction can hold.
    #[inline(always)]
    pub fn friction_at_rest(&self, static_friction: N) -> N {
        static_friction + self.additional_at_rest
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

    /// mu of steady sliding.
    pub fn steady_friction(&self, static_friction: f64) -> f64 {
        self.friction(static_friction).at(0.0, 1.0)
    }

    /// f_s with which the friction coefficient of steady sliding is `mu`.
    pub fn static_friction_for(&self, mu: f64) -> f64 {
        let (a, b) = self.friction_shape.parts(self.disc_speed * self.inverse_stribeck, self.stribeck_exponent);
        let falling = mu - self.kinetic_friction - self.additional_friction * b;
        if falling == 0.0 { self.kinetic_friction } else { self.kinetic_friction + falling / a }
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
        let inputs = PadInputs { preload: 0.1, static_friction: 0.39 };
        pad.accelerations(&inputs, contact.into(), &q, &[speed, 0.0, 0.0], (0.0, 1.0), pressure)
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
