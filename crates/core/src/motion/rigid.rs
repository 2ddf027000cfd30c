//! The tangential motion of the pad on a rigid disc, as the time-domain criterion follows it.
//!
//! `sin(phi) = 0`, `cos(phi) = 1`, no disc: normal motion and rotation do not act back on the tangential one, and a pad
//! that starts pressed on the disc stays so. What is left is a mass on a moving belt,
//!
//! ```text
//! slip (x' < v):   x'' = G mu(v - x') - K x - C x',     G = (k_t2 / k_t1) N / (M eta0)
//! stick (x' = v):  while |K x + C v| <= G f_s           K = (k_x + k_t2) / (M eta0),  C = c_x sqrt(eta0) / (M eta0)
//! ```
//!
//! in Runge-Kutta steps of a tenth over the natural frequency, shorter where friction is steep ([`crate::motion::friction_steps`]).
//! [`crate::rigid_disc::return_map`] follows the same equations with an adaptive method of its own; the tests compare the two.

use crate::flexible_disc::brake::ContactState;
use crate::friction::{StribeckLaw, decay};
use crate::motion::flexible::DAMPED_STEP;
use crate::motion::friction_steps::FrictionSteps;
use crate::motion::integrator::{Equations, Reserve, Step};
use crate::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::rigid_disc::return_map::PlanarMotion;

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
    /// 1 / v_s.
    pub inverse_stribeck: f64,
    /// delta.
    pub stribeck_exponent: f64,
    kinetic_friction: f64,
    /// G for one unit of preload.
    gain_per_preload: f64,
    /// Length of a step.
    pub step: f64,
    /// See [`FrictionSteps::new`].
    pub refinement: f64,
}

/// The equations of one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RigidSample<'a> {
    pub brake: &'a RigidBrake,
    /// G f_c.
    pub kinetic_pull: f64,
    /// G (f_s - f_c).
    pub falling_pull: f64,
    /// G f_s.
    pub static_pull: f64,
    /// What friction asks of the steps.
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
            inverse_stribeck: 1.0 / law.stribeck_velocity,
            stribeck_exponent: law.exponent,
            kinetic_friction: law.kinetic_coefficient,
            gain_per_preload: brake.friction_transmission() * brake.normal_force_per_preload() / mass,
            step: (STEP / stiffness.sqrt()).min(DAMPED_STEP / damping),
            refinement: 1.0,
        }
    }

    pub fn sample(&self, inputs: RandomInputs) -> RigidSample<'_> {
        let gain = self.gain_per_preload * inputs.preload;
        let falling_pull = gain * (inputs.static_friction - self.kinetic_friction);
        RigidSample {
            brake: self,
            kinetic_pull: gain * self.kinetic_friction,
            falling_pull,
            static_pull: gain * inputs.static_friction,
            friction_steps: self.friction_steps(falling_pull),
        }
    }

    /// What the friction of a sample asks of steps.
    #[inline(always)]
    pub fn friction_steps(&self, falling_pull: f64) -> FrictionSteps {
        let (v, inverse) = (self.disc_speed, self.inverse_stribeck);
        FrictionSteps::new(v, inverse, self.stribeck_exponent, falling_pull, self.refinement)
    }
}

impl RigidSample<'_> {
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
        let sliding = direction * (self.brake.disc_speed - u);
        direction
            * (self.kinetic_pull
                + self.falling_pull * decay(sliding * self.brake.inverse_stribeck, self.brake.stribeck_exponent))
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
            law: StribeckLaw {
                static_coefficient: self.static_pull,
                kinetic_coefficient: self.kinetic_pull,
                stribeck_velocity: 1.0 / self.brake.inverse_stribeck,
                exponent: self.brake.stribeck_exponent,
            },
        }
    }

    /// Where static friction can hold the pad no longer.
    pub fn release(&self) -> f64 {
        (self.static_pull - self.brake.damping * self.brake.disc_speed) / self.brake.stiffness
    }
}

impl Equations for RigidSample<'_> {
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
        Reserve { against_slip: self.static_pull - needed, against_overtaking: self.static_pull + needed }
    }

    fn meeting_rate(&self) -> f64 {
        self.brake.disc_speed * self.brake.stiffness.sqrt()
    }

    fn friction_steps(&self) -> &FrictionSteps {
        &self.friction_steps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::integrator::{Motion, advance};
    use crate::trajectory::Diary;

    fn inputs(brake: &PadOnDisc) -> RandomInputs {
        let parameters = brake.parameters();
        RandomInputs {
            preload: parameters.operating_point.preload,
            static_friction: parameters.friction.static_coefficient,
        }
    }

    fn follow_from_release(brake: &RigidBrake, inputs: RandomInputs, time: f64, h: f64) -> Diary {
        let sample = brake.sample(inputs);
        let mut motion =
            Motion { state: RigidState { x: sample.release(), u: brake.disc_speed }, contact: ContactState::Stick };
        let mut log = Diary::default();
        for k in 0..(time / h) as u32 {
            advance(&sample, &mut motion, h * f64::from(k), h, &mut log).unwrap();
        }
        log
    }

    #[test]
    fn the_limit_cycle_is_that_of_the_table() {
        // Physics notes, section 7: adaptive Runge-Kutta, tolerance 1e-11, outside Rust.
        let table = [
            (10.0, 3.56373, 0.014309, 0.003465, 0.3756),
            (15.56, 3.21741, 0.015334, 0.002579, 0.2556),
            (20.0, 3.10909, 0.016207, 0.001879, 0.1873),
        ];
        for (speed, period, largest, smallest, stick) in table {
            let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
            let rigid = RigidBrake::new(&brake);
            let log = follow_from_release(&rigid, inputs(&brake), 40.0, rigid.step);
            let cycles = log.slips.len() - 1;
            let found = (log.slips[cycles] - log.slips[1]) / (cycles - 1) as f64;
            assert!((found - period).abs() < 1e-4, "{speed}: period {found}");
            let last: Vec<f64> = log.turns.iter().rev().take(2).map(|turn| turn.1).collect();
            assert!((last[0].max(last[1]) - largest).abs() < 1e-6, "{speed}: {last:?}");
            assert!((last[0].min(last[1]) - smallest).abs() < 1e-6, "{speed}: {last:?}");
            let found = (log.slips[3] - log.sticks[2]) / period;
            assert!((found - stick).abs() < 1e-4, "{speed}: stick {found}");
        }
    }

    #[test]
    fn fixed_and_adaptive_steps_find_the_same_limit_cycle() {
        for (speed, preload) in [(6.0, 0.1), (12.0, 0.2), (25.0, 0.1)] {
            let changes = [("operating_point.rotating_speed", speed), ("operating_point.preload", preload)];
            let brake = PadOnDisc::preset_with(&changes);
            let cycle = brake.limit_cycle().unwrap();
            let rigid = RigidBrake::new(&brake);
            for divisor in [1.0, 4.0] {
                let log = follow_from_release(&rigid, inputs(&brake), 20.0, rigid.step / divisor);
                let tolerance = 2e-4 / (divisor * divisor);
                let period = log.slips[3] - log.slips[2];
                assert!((period / cycle.period - 1.0).abs() < tolerance, "{speed} {divisor}: {period} {cycle:?}");
                let largest = log.turns.iter().map(|turn| turn.1).fold(f64::NEG_INFINITY, f64::max);
                assert!(
                    (largest / cycle.tangential_max - 1.0).abs() < tolerance,
                    "{speed} {divisor}: {largest} {cycle:?}"
                );
            }
        }
    }

    /// Whether the slip phase that begins at release ends in stick.
    fn is_recaptured(speed: f64, divisor: f64) -> bool {
        let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
        let rigid = RigidBrake::new(&brake);
        !follow_from_release(&rigid, inputs(&brake), 5.0, rigid.step / divisor).sticks.is_empty()
    }

    #[test]
    fn the_saddle_node_is_found_at_any_step_size() {
        // Physics notes: 30.197, independently.
        for divisor in [0.25, 0.5, 1.0, 3.0] {
            let (mut with, mut without) = (20.0, 40.0);
            for _ in 0..40 {
                let middle = 0.5 * (with + without);
                if is_recaptured(middle, divisor) { with = middle } else { without = middle }
            }
            let tolerance = if divisor < 1.0 { 0.15 } else { 0.01 };
            assert!((with - 30.197).abs() < tolerance, "step / {divisor}: {with}");
        }
    }

    #[test]
    fn steps_follow_the_friction_law_however_steep_it_is() {
        // Where stick-slip ends, by these steps and by the adaptive method; the disc passes the pad at up to a thousand
        // Stribeck velocities.
        for (exponent, stribeck_velocity) in [
            (1.0, 3.0),
            (1.0, 0.1),
            (1.0, 0.02),
            (1.0, 0.004),
            (0.5, 0.3),
            (0.5, 0.02),
            (0.7, 0.05),
            (1.5, 0.05),
            (2.0, 0.1),
            (2.0, 0.005),
            (3.0, 0.05),
        ] {
            let at = |speed: f64| {
                PadOnDisc::preset_with(&[
                    ("friction.stribeck_exponent", exponent),
                    ("friction.stribeck_velocity", stribeck_velocity),
                    ("operating_point.rotating_speed", speed),
                ])
            };
            let expected = at(10.0).saddle_node_speed().unwrap();
            let is_recaptured = |speed: f64, divisor: f64| {
                let mut rigid = RigidBrake::new(&at(speed));
                rigid.step /= divisor;
                rigid.refinement /= divisor;
                !follow_from_release(&rigid, inputs(&at(speed)), 5.0, rigid.step).sticks.is_empty()
            };
            for divisor in [1.0, 2.0] {
                let (mut with, mut without) = (0.9 * expected, 1.1 * expected);
                while without - with > 1e-9 * expected {
                    let middle = 0.5 * (with + without);
                    if is_recaptured(middle, divisor) { with = middle } else { without = middle }
                }
                let error = with / expected - 1.0;
                let tolerance = if divisor == 1.0 { 1e-5 } else { 2e-6 };
                assert!(error.abs() < tolerance, "{exponent} {stribeck_velocity} / {divisor}: {error:e}");
            }
        }
    }

    #[test]
    fn a_touch_between_the_ends_of_a_step_is_seen() {
        // Friction that is flat at rest does not hold the pad up near the disc's speed: just below the saddle-node it
        // passes there for a moment much shorter than a step.
        let at = |speed: f64| {
            PadOnDisc::preset_with(&[("friction.stribeck_exponent", 2.0), ("operating_point.rotating_speed", speed)])
        };
        let saddle_node = at(10.0).saddle_node_speed().unwrap();
        let is_recaptured = |speed: f64, divisor: f64| {
            let rigid = RigidBrake::new(&at(speed));
            !follow_from_release(&rigid, inputs(&at(speed)), 4.0, rigid.step / divisor).sticks.is_empty()
        };
        for divisor in [1.0, 1.1, 1.23, 1.37, 1.5, 1.71] {
            for share in [0.999, 0.9998, 0.9999] {
                assert!(is_recaptured(share * saddle_node, divisor), "{share} of {saddle_node}, step / {divisor}");
            }
            assert!(!is_recaptured(1.001 * saddle_node, divisor));
        }
    }

    #[test]
    fn no_step_size_makes_it_chatter() {
        let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", 10.0)]);
        let rigid = RigidBrake::new(&brake);
        for divisor in [0.05, 0.1, 0.3, 1.0, 10.0, 77.0] {
            let log = follow_from_release(&rigid, inputs(&brake), 200.0, rigid.step / divisor);
            // 200 time units are 56 cycles; chatter would show as hundreds of sticks.
            assert!((50..=65).contains(&log.sticks.len()), "step / {divisor}: {} sticks", log.sticks.len());
        }
    }

    #[test]
    fn a_pad_far_behind_is_overtaken_by_nothing_and_one_far_ahead_comes_back() {
        // Hurled against the calliper, the pad runs ahead of the disc and is caught on its way back.
        let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", 10.0)]);
        let rigid = RigidBrake::new(&brake);
        let sample = rigid.sample(inputs(&brake));
        let mut motion = Motion { state: RigidState { x: -0.5, u: 0.0 }, contact: ContactState::Slip };
        let mut log = Diary::default();
        let mut overtook = false;
        for k in 0..4000 {
            advance(&sample, &mut motion, rigid.step * f64::from(k), rigid.step, &mut log).unwrap();
            overtook |= motion.contact == ContactState::Overtaking;
        }
        assert!(overtook);
        let tail: Vec<f64> = log.turns.iter().rev().take(2).map(|turn| turn.1).collect();
        let cycle = brake.limit_cycle().unwrap();
        assert!((tail[0].max(tail[1]) / cycle.tangential_max - 1.0).abs() < 1e-3, "{tail:?} {cycle:?}");
    }
}
