//! The velocity of the pad over a limit cycle.

use crate::models::pad_on_disc::rigid_disc::limit_cycle::LimitCycle;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, SlipEnd};
use crate::numerics::dormand_prince;

/// Local error allowed in one step, relative to the size of the motion.
const TOLERANCE: f64 = 1e-10;

/// Largest number of steps of one phase.
const MOST_STEPS: usize = 20_000;

/// The last step of a phase may end by this share of its duration too early.
const ROUNDING: f64 = 1e-13;

/// How far the phases may differ from the period of the cycle, over it.
const CLOSED: f64 = 1e-6;

impl PadOnDisc {
    /// The root mean square of x' over a limit cycle of this brake, in scaled speed, to some 1e-9; `None` if a phase is not
    /// resolved: a motion so damped that it is stiff.
    ///
    /// Where the pad sticks it has the disc's speed. Where it slips, the integral of the square is one more component of the
    /// equation of motion.
    #[must_use]
    pub fn rms_velocity(&self, cycle: &LimitCycle) -> Option<f64> {
        let motion = self.planar_motion();
        let speed = motion.disc_speed;
        let size = if cycle.reaches_disc_speed {
            motion.size_of([cycle.tangential_max, 0.0])
        } else {
            cycle.tangential_max - motion.equilibrium()
        };
        // From the turning point on, where every cycle comes by.
        let turned = [cycle.tangential_max, 0.0];
        let back = motion.slip(turned, size);
        let mut square = motion.square_over(turned, back.duration, size)?;
        if !cycle.reaches_disc_speed {
            let is_closed = back.end == SlipEnd::Turned && (back.duration / cycle.period - 1.0).abs() < CLOSED;
            return is_closed.then(|| (square / cycle.period).sqrt());
        }
        let (mut duration, mut from) = (back.duration, back.x);
        if let Some(overtaking) = motion.overtaking_from(back.x) {
            let mirrored = PlanarMotion { disc_speed: -speed, ..motion };
            square += mirrored.square_over([-back.x, -speed], overtaking.duration, size)?;
            duration += overtaking.duration;
            from = overtaking.x;
        }
        let stick = cycle.stick_fraction * cycle.period;
        if stick > 0.0 {
            from = motion.release();
        }
        square += speed * speed * stick;
        let out = motion.slip([from, speed], size);
        square += motion.square_over([from, speed], out.duration, size)?;
        duration += stick + out.duration;
        let is_closed = out.end == SlipEnd::Turned && (duration / cycle.period - 1.0).abs() < CLOSED;
        is_closed.then(|| (square / cycle.period).sqrt())
    }
}

impl PlanarMotion {
    /// The integral of the square of the speed over a phase of slip of this duration.
    fn square_over(&self, [x, speed]: [f64; 2], duration: f64, size: f64) -> Option<f64> {
        let frequency = self.stiffness.sqrt();
        let rate = |[x, speed, _]: [f64; 3]| {
            let [by_x, by_speed] = self.rate([x, speed]);
            [by_x, by_speed, speed * speed]
        };
        let (mut state, mut time, mut h) = ([x, speed, 0.0], 0.0, 1e-3 / frequency);
        for _ in 0..MOST_STEPS {
            h = h.min(duration - time);
            let (next, error) = dormand_prince::step(rate, state, h);
            let sizes = [size, size * frequency, size * size * frequency];
            let error = error.iter().zip(sizes).map(|(error, size)| error.abs() / size).fold(0.0, f64::max) / TOLERANCE;
            if !(error.is_finite() && next.iter().all(|value| value.is_finite())) {
                return None;
            }
            if error <= 1.0 {
                (time, state) = (time + h, next);
                if duration - time <= ROUNDING * duration {
                    return Some(state[2]);
                }
            }
            h *= dormand_prince::growth(error);
        }
        None
    }
}
