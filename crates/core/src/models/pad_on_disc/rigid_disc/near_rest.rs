//! Slip close to the disc's speed with a Stribeck exponent below 1, by the square root of the sliding speed.
//!
//! There friction falls as the power delta of the sliding speed `s = v - x'`, infinitely steeply at rest, and no step in s
//! is accurate. With `z = sqrt(s)`, the distance `y = x - x_r` from the release and a time that stands still at rest,
//! `dt = 2 z d tau`, the motion is
//!
//! ```text
//! dz / d tau = K y - C z^2 + G mu(0) - G mu(z^2),      dy / d tau = 2 z (v - z^2)
//! ```
//!
//! whose right-hand side is smooth for the exponent 1/2, and has a continuous slope above it. The release is a saddle
//! point, `z = y = 0`: a released pad leaves it along
//!
//! ```text
//! y = (2 v / l) z,      l^2 - A l - 2 v K = 0,      A = [G mu(0) - G mu(z^2) - C z^2] / z  for z -> 0
//! ```
//!
//! and at the end of stick-slip it comes back to it. Errors across the line on which it leaves decay, so it is followed
//! from a small z on.

use crate::friction::law::FrictionLaw;
use crate::numerics::dormand_prince;
use crate::numerics::root_location::false_position;

/// The sliding speed over the disc's up to which z takes its place.
const NEAR: f64 = 0.1;

/// Where a released pad is followed from: z over its value at the disc's speed.
const RELEASED: f64 = 1e-7;

/// Largest number of steps of one passage; some hundred are usual.
const MOST_STEPS: usize = 20_000;

/// How a passage ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum PassageEnd {
    /// The pad slides faster again.
    Left,
    /// It has the disc's speed.
    Captured,
    /// Too many steps, or numbers out of range.
    Unresolved,
}

/// A passage close to the disc's speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Passage {
    pub end: PassageEnd,
    pub duration: f64,
    pub x: f64,
    pub speed: f64,
}

/// The tangential motion, forces over the mass, where it is close to the disc's speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NearRest<'a> {
    /// K.
    pub stiffness: f64,
    /// C.
    pub damping: f64,
    /// v.
    pub disc_speed: f64,
    /// G mu.
    pub law: &'a FrictionLaw,
    /// x_r.
    pub release: f64,
}

impl NearRest<'_> {
    /// Whether a state of slip is so close to the disc's speed that z takes the place of the sliding speed.
    pub fn includes(&self, [_, speed]: [f64; 2]) -> bool {
        let v = self.disc_speed;
        self.law.is_infinitely_steep_at_rest() && v > 0.0 && v - speed < NEAR * v
    }

    /// The passage from such a state, with the local error `tolerance` relative to the disc's speed.
    pub fn pass(&self, [x, speed]: [f64; 2], tolerance: f64) -> Passage {
        let (v, release) = (self.disc_speed, self.release);
        let pull = |z: f64| self.law.at_rest() - self.law.coefficient(z * z) - self.damping * z * z;
        let rate = |[y, z, _]: [f64; 3]| [2.0 * z * (v - z * z), self.stiffness * y + pull(z.abs()), 2.0 * z];
        let far = (NEAR * v).sqrt();
        let smallest = RELEASED * v.sqrt();
        let slope = pull(smallest) / smallest;
        let leaving = 0.5 * (slope + (slope * slope + 8.0 * v * self.stiffness).sqrt());
        let (y, z) = (x - release, (v - speed).max(0.0).sqrt());
        let is_released = z == 0.0 && y.abs() <= 2.0 * v / leaving * smallest;
        let mut state = if is_released { [2.0 * v / leaving * smallest, smallest, 0.0] } else { [y, z, 0.0] };
        let passage = |end, [y, z, duration]: [f64; 3]| Passage {
            end,
            duration,
            x: release + y,
            speed: if end == PassageEnd::Captured { v } else { v - z * z },
        };
        let (size_of_y, size_of_z) = (v / self.stiffness.sqrt(), far);
        let mut h = 1e-3 / leaving;
        for _ in 0..MOST_STEPS {
            let (next, error) = dormand_prince::step(rate, state, h);
            let error = (error[0].abs() / size_of_y).max(error[1].abs() / size_of_z) / tolerance;
            if error.is_nan() {
                break;
            }
            if error > 1.0 {
                h *= dormand_prince::growth(error);
                continue;
            }
            if next[1] <= 0.0 {
                let at = |part| dormand_prince::step(rate, state, part).0;
                let (_, end) = false_position((0.0, state[1]), (h, next[1]), next, 1e-15 * h, at, |state| state[1]);
                return passage(PassageEnd::Captured, end);
            }
            state = next;
            if state[1] > far {
                return passage(PassageEnd::Left, state);
            }
            h *= dormand_prince::growth(error);
        }
        passage(PassageEnd::Unresolved, state)
    }
}
