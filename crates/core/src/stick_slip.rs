//! Stick-slip of the pad on a rigid disc: the limit cycle and where it ends.
//!
//! With constant contact force N the tangential motion is that of a mass on a moving belt,
//!
//! ```text
//! slip (x' < v):   M eta0 x'' = -(k_x + k_t2) x - c_x sqrt(eta0) x' + (k_t2 / k_t1) mu(v - x') N
//! stick (x' = v):  until the friction needed, (k_t1 / k_t2) [(k_x + k_t2) x + c_x sqrt(eta0) v], exceeds f_s N
//! ```
//!
//! Stick and slip are states with located ends, not a smoothed sign function: a switch at step ends chatters.

use crate::friction::StribeckLaw;
use crate::pad_on_disc::PadOnDisc;

/// Local error allowed in one step, relative to the size of the motion.
const TOLERANCE: f64 = 1e-12;

/// Steps of one slip phase at the most; a few hundred are usual. Only a pad so light or so damped that its motion is
/// stiff needs more; an explicit method is the wrong one for it.
const MOST_STEPS: usize = 20_000;

/// The highest admissible rotating speed, see `operating_point.rotating_speed`; the search for the saddle-node ends
/// there.
const HIGHEST_SPEED: f64 = 1e5;

/// A stick-slip limit cycle, in scaled time and length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitCycle {
    /// Duration of one cycle.
    pub period: f64,
    /// Largest tangential displacement.
    pub tangential_max: f64,
    /// Smallest tangential displacement.
    pub tangential_min: f64,
    /// Share of the period spent in stick.
    pub stick_fraction: f64,
}

/// One slip phase, from release to recapture.
#[derive(Debug, Clone, Copy)]
struct SlipArc {
    duration: f64,
    recaptured_at: f64,
    largest: f64,
    smallest: f64,
}

/// Tangential slip motion, divided by the mass.
#[derive(Debug, Clone, Copy)]
struct SlipMotion {
    stiffness: f64,
    damping: f64,
    friction_gain: f64,
    law: StribeckLaw,
    disc_speed: f64,
}

impl SlipMotion {
    fn new(brake: &PadOnDisc) -> Self {
        let mass = brake.scaled_mass();
        Self {
            stiffness: brake.tangential_stiffness() / mass,
            damping: brake.scaled_tangential_damping() / mass,
            friction_gain: brake.friction_transmission() * brake.normal_force() / mass,
            law: *brake.friction_law(),
            disc_speed: brake.disc_speed(),
        }
    }

    /// Displacement at which static friction can hold the pad no longer.
    fn release(&self) -> f64 {
        (self.friction_gain * self.law.static_coefficient - self.damping * self.disc_speed) / self.stiffness
    }

    fn rate(&self, [x, speed]: [f64; 2]) -> [f64; 2] {
        let friction = self.friction_gain * self.law.coefficient(self.disc_speed - speed);
        [speed, friction - self.stiffness * x - self.damping * speed]
    }

    /// One step of Dormand and Prince's fifth-order method; the second value is the estimate of its error.
    fn step(&self, state: [f64; 2], h: f64) -> ([f64; 2], [f64; 2]) {
        let combine = |terms: &[(f64, [f64; 2])]| {
            let mut sum = [0.0; 2];
            for (factor, rate) in terms {
                sum[0] += factor * rate[0];
                sum[1] += factor * rate[1];
            }
            sum
        };
        let at = |terms: &[(f64, [f64; 2])]| {
            let sum = combine(terms);
            self.rate([state[0] + h * sum[0], state[1] + h * sum[1]])
        };
        let k1 = self.rate(state);
        let k2 = at(&[(1.0 / 5.0, k1)]);
        let k3 = at(&[(3.0 / 40.0, k1), (9.0 / 40.0, k2)]);
        let k4 = at(&[(44.0 / 45.0, k1), (-56.0 / 15.0, k2), (32.0 / 9.0, k3)]);
        let k5 =
            at(&[(19_372.0 / 6561.0, k1), (-25_360.0 / 2187.0, k2), (64_448.0 / 6561.0, k3), (-212.0 / 729.0, k4)]);
        let k6 = at(&[
            (9017.0 / 3168.0, k1),
            (-355.0 / 33.0, k2),
            (46_732.0 / 5247.0, k3),
            (49.0 / 176.0, k4),
            (-5103.0 / 18_656.0, k5),
        ]);
        let increment = combine(&[
            (35.0 / 384.0, k1),
            (500.0 / 1113.0, k3),
            (125.0 / 192.0, k4),
            (-2187.0 / 6784.0, k5),
            (11.0 / 84.0, k6),
        ]);
        let next = [state[0] + h * increment[0], state[1] + h * increment[1]];
        let k7 = self.rate(next);
        let error = combine(&[
            (71.0 / 57_600.0, k1),
            (-71.0 / 16_695.0, k3),
            (71.0 / 1920.0, k4),
            (-17_253.0 / 339_200.0, k5),
            (22.0 / 525.0, k6),
            (-1.0 / 40.0, k7),
        ]);
        (next, [h * error[0], h * error[1]])
    }

    /// The part of a step at whose end `event` vanishes; it is positive at its beginning, not at its end.
    fn locate(&self, state: [f64; 2], h: f64, event: impl Fn([f64; 2]) -> f64) -> (f64, [f64; 2]) {
        let (mut early, mut late) = (0.0, h);
        for _ in 0..100 {
            let middle = 0.5 * (early + late);
            if middle <= early || middle >= late {
                break;
            }
            if event(self.step(state, middle).0) > 0.0 {
                early = middle;
            } else {
                late = middle;
            }
        }
        (late, self.step(state, late).0)
    }

    /// Follows the slip that begins at release. `None` if the pad, swinging back, slows down before it has reached the
    /// disc's speed again: then nothing recaptures it.
    fn slip_arc(&self) -> Option<SlipArc> {
        let frequency = self.stiffness.sqrt();
        let scale = self.release().abs().max(self.disc_speed / frequency);
        let mut state = [self.release(), self.disc_speed];
        let mut arc = SlipArc { duration: 0.0, recaptured_at: 0.0, largest: state[0], smallest: state[0] };
        let mut h = 1e-3 / frequency;
        let mut has_returned = false;
        for _ in 0..MOST_STEPS {
            let (next, error) = self.step(state, h);
            let size = (error[0].abs() / scale).max(error[1].abs() / (scale * frequency)) / TOLERANCE;
            if size.is_nan() {
                return None;
            }
            if size > 1.0 {
                h *= (0.9 * libm::pow(size, -0.2)).max(0.2);
                continue;
            }
            let slips = |state: [f64; 2]| self.disc_speed - state[1];
            if state[1] > 0.0 && next[1] <= 0.0 {
                arc.largest = arc.largest.max(self.locate(state, h, |state| state[1]).1[0]);
            }
            if state[1] < 0.0 && next[1] >= 0.0 {
                arc.smallest = arc.smallest.min(self.locate(state, h, |state| -state[1]).1[0]);
                has_returned = true;
            }
            // After the extremes: on a slow disc one step may pass both zero and the disc's speed.
            if slips(state) > 0.0 && slips(next) <= 0.0 && has_returned {
                let (part, caught) = self.locate(state, h, slips);
                arc.duration += part;
                arc.recaptured_at = caught[0];
                return Some(arc);
            }
            if has_returned && self.rate(next)[1] < 0.0 {
                return None;
            }
            arc.duration += h;
            state = next;
            h *= (0.9 * libm::pow(size.max(1e-10), -0.2)).clamp(0.2, 5.0);
        }
        None
    }
}

impl PadOnDisc {
    /// The stick-slip limit cycle on a rigid disc with constant contact force, or `None` if there is none at this
    /// operating point.
    ///
    /// The cycle is followed from the release from stick: all motions that stick leave it at the same point, by the
    /// same slip phase. Accuracy some 1e-10 (Dormand-Prince 5(4), located ends). A slip phase that takes more than
    /// 20 000 steps, of a pad far lighter or more damped than any brake's, counts as not recaptured.
    #[must_use]
    pub fn limit_cycle(&self) -> Option<LimitCycle> {
        let motion = SlipMotion::new(self);
        if motion.release() <= 0.0 {
            return None;
        }
        let arc = motion.slip_arc()?;
        let stick = (motion.release() - arc.recaptured_at) / motion.disc_speed;
        let period = arc.duration + stick;
        (stick > 0.0).then_some(LimitCycle {
            period,
            tangential_max: arc.largest,
            tangential_min: arc.smallest,
            stick_fraction: stick / period,
        })
    }

    /// The rotating speed (rad/s) above which no stick-slip limit cycle exists on a rigid disc: there the slip phase
    /// released from stick just fails to reach the disc's speed again, and the limit cycle vanishes in a saddle-node
    /// bifurcation. `None` if there is no limit cycle at any speed, or up to any speed.
    ///
    /// Bisection to 1e-10 of the speed between neighbours of a logarithmic scan, from the highest admissible speed
    /// to far below both speeds that matter: the Stribeck velocity, and that of an oscillation as wide as the drop in
    /// friction.
    #[must_use]
    pub fn saddle_node_speed(&self) -> Option<f64> {
        let cycles = |speed: f64| {
            let mut parameters = self.parameters().clone();
            parameters.operating_point.rotating_speed = speed;
            PadOnDisc::new(parameters).is_ok_and(|brake| brake.limit_cycle().is_some())
        };
        let motion = SlipMotion::new(self);
        let drop = motion.friction_gain * (motion.law.static_coefficient - motion.law.kinetic_coefficient);
        let oscillation = self.rotating_speed(drop / motion.stiffness.sqrt());
        let stribeck = self.rotating_speed(motion.law.stribeck_velocity);
        if oscillation <= 0.0 {
            return None;
        }
        let lowest = (1e-4 * oscillation.min(stribeck)).clamp(1e-5, HIGHEST_SPEED);
        let points = 1 + (15.0 * libm::log10(HIGHEST_SPEED / lowest)).ceil() as u32;
        let ratio = libm::pow(HIGHEST_SPEED / lowest, 1.0 / f64::from(points));
        let scan: Vec<f64> =
            (0..points).scan(HIGHEST_SPEED, |speed, _| Some(std::mem::replace(speed, *speed / ratio))).collect();
        // Falling speeds: the first one with a limit cycle lies below the saddle-node, the one before it above.
        let first = scan.iter().position(|&speed| cycles(speed))?;
        let (mut with, mut without) = (scan[first], scan[first.checked_sub(1)?]);
        while without - with > 1e-10 * with {
            let middle = 0.5 * (with + without);
            if cycles(middle) {
                with = middle;
            } else {
                without = middle;
            }
        }
        Some(0.5 * (with + without))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limit_cycles_agree_with_an_independent_integration() {
        // Adaptive Runge-Kutta, tolerance 1e-11, located events, outside Rust; preset, Delta = 0.1, f_s = 0.39:
        // speed, period, max x, min x, share in stick.
        for (speed, period, max, min, stick) in [
            (10.0, 3.56373, 0.014309, 0.003465, 0.3756),
            (15.56, 3.21741, 0.015334, 0.002579, 0.2556),
            (20.0, 3.10909, 0.016207, 0.001879, 0.1873),
        ] {
            let cycle = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]).limit_cycle().unwrap();
            assert!((cycle.period - period).abs() < 1e-5, "{cycle:?}");
            assert!((cycle.tangential_max - max).abs() < 1e-6, "{cycle:?}");
            assert!((cycle.tangential_min - min).abs() < 1e-6, "{cycle:?}");
            assert!((cycle.stick_fraction - stick).abs() < 1e-4, "{cycle:?}");
        }
    }

    #[test]
    fn the_saddle_node_is_where_an_independent_integration_finds_it() {
        let speed = PadOnDisc::preset_with(&[]).saddle_node_speed().unwrap();
        assert!((speed - 30.197).abs() < 0.01, "{speed}");
        assert!(PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed * 0.999)]).limit_cycle().is_some());
        assert!(PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed * 1.001)]).limit_cycle().is_none());
    }

    #[test]
    fn on_a_very_slow_disc_the_cycle_is_nearly_all_stick() {
        // The slip phase no longer depends on the disc's speed, so the stick phase lasts its width over the speed.
        let slow =
            |speed: f64| PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]).limit_cycle().unwrap();
        let reference = slow(1e-4);
        for speed in [1e-5, 1e-6] {
            let cycle = slow(speed);
            assert!((cycle.tangential_min / reference.tangential_min - 1.0).abs() < 1e-3, "{speed}: {cycle:?}");
            assert!((cycle.period * speed / (reference.period * 1e-4) - 1.0).abs() < 1e-2, "{speed}: {cycle:?}");
        }
    }

    #[test]
    fn without_falling_friction_nothing_sticks_and_slips() {
        let flat = PadOnDisc::preset_with(&[("friction.kinetic_coefficient", 0.39)]);
        assert_eq!(flat.limit_cycle(), None);
        assert_eq!(flat.saddle_node_speed(), None);
        assert_eq!(PadOnDisc::preset_with(&[("operating_point.preload", 0.0)]).limit_cycle(), None);
    }

    #[test]
    fn an_undamped_pad_sticks_and_slips_at_every_speed() {
        let undamped = PadOnDisc::preset_with(&[("damping.tangential", 0.0)]);
        assert!(undamped.limit_cycle().is_some());
        assert_eq!(undamped.saddle_node_speed(), None);
    }

    #[test]
    fn with_constant_slip_friction_the_saddle_node_is_that_of_a_damped_oscillator() {
        // Friction that drops at once: the slip phase is x_c + exp(-beta t) (A cos + B sin), and the saddle-node is the
        // disc speed that its return just reaches.
        let sharp = PadOnDisc::preset_with(&[("friction.stribeck_velocity", 1e-6)]);
        let motion = SlipMotion::new(&sharp);
        let (beta, centre) = (0.5 * motion.damping, motion.friction_gain * 0.25 / motion.stiffness);
        let omega = (motion.stiffness - beta * beta).sqrt();
        let fastest_return = |speed: f64| {
            let release = (motion.friction_gain * 0.39 - motion.damping * speed) / motion.stiffness;
            let a = release - centre;
            let b = (speed + beta * a) / omega;
            let velocity = |t: f64| {
                (-beta * t).exp()
                    * ((b * omega - beta * a) * (omega * t).cos() - (a * omega + beta * b) * (omega * t).sin())
            };
            let period = std::f64::consts::TAU / omega;
            (0..200_000).map(|i| velocity(period * (0.4 + 0.8e-5 * f64::from(i)))).fold(f64::NEG_INFINITY, f64::max)
        };
        let (mut slow, mut fast) = (1e-6, 1.0);
        for _ in 0..60 {
            let middle = 0.5 * (slow + fast);
            if fastest_return(middle) > middle { slow = middle } else { fast = middle }
        }
        let expected = sharp.rotating_speed(slow);
        let speed = sharp.saddle_node_speed().unwrap();
        assert!((speed / expected - 1.0).abs() < 1e-3, "{speed} {expected}");
    }

    #[test]
    fn with_constant_slip_friction_the_slip_phase_is_a_harmonic_arc() {
        // A Stribeck velocity far below all speeds: friction drops at once from f_s to f_c, and without damping the
        // slip phase is an arc about x_c with amplitude sqrt((x_r - x_c)^2 + (v / omega)^2).
        let sharp = PadOnDisc::preset_with(&[
            ("damping.tangential", 0.0),
            ("friction.stribeck_velocity", 1e-7),
            ("operating_point.rotating_speed", 10.0),
        ]);
        let cycle = sharp.limit_cycle().unwrap();
        let motion = SlipMotion::new(&sharp);
        let centre = motion.friction_gain * 0.25 / motion.stiffness;
        let amplitude = f64::hypot(motion.release() - centre, motion.disc_speed / motion.stiffness.sqrt());
        assert!((cycle.tangential_max - (centre + amplitude)).abs() < 1e-6, "{cycle:?}");
        assert!((cycle.tangential_min - (centre - amplitude)).abs() < 1e-6, "{cycle:?}");
    }
}
