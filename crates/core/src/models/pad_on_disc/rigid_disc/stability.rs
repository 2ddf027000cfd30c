//! Linear stability of steady sliding, in closed form.
//!
//! On a rigid disc the Jacobian is block triangular (normal, tangential, angular motion), so its six eigenvalues
//! are those of three oscillators. Only the tangential one can lose its damping:
//!
//! ```text
//! m1 = [ -(k_t2 / k_t1) N d mu / d v - c_x sqrt(eta0) ] / (M eta0),      N = k_en k_y Delta / (k_en + k_y)
//! ```
//!
//! with the slope `d mu / d v = -(f_s - f_c) w(v) + e b'(v)` of the friction law. Steady sliding is unstable exactly
//! when `m1 > 0`, so the boundary in the plane of preload and static friction is a hyperbola, `Delta (f_s - f_0) =
//! const`.

use nalgebra::DMatrix;

use crate::friction::law::FrictionLaw;
use crate::friction::shape::Shape;
use crate::model::pair_boundary::PairBoundary;
use crate::models::pad_on_disc::parameters::Parameters;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{Oscillator, PadOnDisc};
use crate::numerics::eigenvalues::Eigenvalue;

impl Oscillator {
    /// Both roots of `lambda^2 + damping lambda + stiffness = 0`, the larger real part first, then the positive
    /// imaginary part. `stiffness` > 0.
    pub fn eigenvalues(&self) -> [Eigenvalue; 2] {
        let half = -0.5 * self.damping;
        let discriminant = half * half - self.stiffness;
        if discriminant < 0.0 {
            let frequency = (-discriminant).sqrt();
            return [Eigenvalue::new(half, frequency), Eigenvalue::new(half, -frequency)];
        }
        // The root of larger modulus first, the other by Vieta: no cancellation.
        let larger = if half >= 0.0 { half + discriminant.sqrt() } else { half - discriminant.sqrt() };
        let smaller = self.stiffness / larger;
        [Eigenvalue::new(larger.max(smaller), 0.0), Eigenvalue::new(larger.min(smaller), 0.0)]
    }
}

/// Rotating speeds between which steady sliding is unstable, or between which there are limit cycles, rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedRange {
    /// Lower end: 0 for the rational law and Stribeck exponents up to 1; above 1 the friction curve is flat at rest,
    /// and very slow sliding is stable again.
    pub from: f64,
    /// Upper end, of unstable sliding the critical speed; infinite if nothing damps the tangential motion.
    pub to: f64,
}

impl PadOnDisc {
    /// The 6x6 Jacobian of the scaled equations at steady sliding on a rigid disc, for the state
    /// `(x, x', y, y', phi, phi')` and scaled time: the paper's equation (3.8).
    #[must_use]
    pub fn jacobian(&self) -> DMatrix<f64> {
        let Parameters { stiffness, pad, .. } = self.parameters();
        let [x, y, phi] = [self.tangential_oscillator(), self.normal_oscillator(), self.angular_oscillator()];
        let mass = self.scaled_mass();
        let friction_by_normal = self.friction_law().coefficient(self.disc_speed()) * stiffness.contact_normal;
        let arm = 0.5 * pad.moment_arm * self.scales().length / (pad.moment_of_inertia * self.scales().eta0);

        let mut jacobian = DMatrix::zeros(6, 6);
        for (row, oscillator) in [(0, x), (2, y), (4, phi)] {
            jacobian[(row, row + 1)] = 1.0;
            jacobian[(row + 1, row)] = -oscillator.stiffness;
            jacobian[(row + 1, row + 1)] = -oscillator.damping;
        }
        jacobian[(1, 2)] = -self.friction_transmission() * friction_by_normal / mass;
        jacobian[(5, 0)] = -arm * stiffness.contact_tangential_2;
        jacobian[(5, 1)] = arm * self.friction_weakening_force();
        jacobian[(5, 2)] = -arm * self.friction_transmission() * friction_by_normal;
        jacobian
    }

    /// The six eigenvalues of steady sliding on a rigid disc: tangential, normal and angular pair.
    #[must_use]
    pub fn sliding_eigenvalues(&self) -> [Eigenvalue; 6] {
        let [a, b] = self.tangential_oscillator().eigenvalues();
        let [c, d] = self.normal_oscillator().eigenvalues();
        let [e, f] = self.angular_oscillator().eigenvalues();
        [a, b, c, d, e, f]
    }

    /// Largest real part of the tangential eigenvalue pair, per unit of scaled time: `m1 / 2` while the motion
    /// oscillates. Steady sliding is unstable exactly when it is positive.
    #[must_use]
    pub fn growth_rate(&self) -> f64 {
        self.tangential_eigenvalue().re
    }

    /// That eigenvalue, of the pair the one with the positive imaginary part.
    #[must_use]
    pub fn tangential_eigenvalue(&self) -> Eigenvalue {
        self.tangential_oscillator().eigenvalues()[0]
    }

    /// The eigenvalue of all motions of the pad with the largest real part, per unit of scaled time; of a pair the one with the
    /// positive imaginary part.
    #[must_use]
    pub fn least_stable_eigenvalue(&self) -> Eigenvalue {
        let others = [self.normal_oscillator(), self.angular_oscillator()].map(|other| other.eigenvalues()[0]);
        let larger = |least: Eigenvalue, other: Eigenvalue| if other.re > least.re { other } else { least };
        others.into_iter().fold(self.tangential_eigenvalue(), larger)
    }

    /// The rotating speeds at which steady sliding is unstable with this preload and friction, in rising order; none if
    /// it is stable at every speed. The upper end of the last range is the critical speed. A measured curve that falls
    /// in several places may have several ranges.
    ///
    /// Unstable is a sliding speed at which friction falls more steeply than `c = c_x sqrt(eta0) + (k_t2 / k_t1) N k_v`
    /// with the viscous term k_v of the law. For Tustin's law `v_crit = v_s ln[(k_t2 / k_t1) N (f_s - f_c) / (v_s c)]`.
    /// For other exponents `u = (v / v_s)^delta` solves `u^p exp(-u) = c v_s / (delta (k_t2 / k_t1) N (f_s - f_c))`
    /// with `p = 1 - 1/delta`, which is `u = -p W(...)` with Lambert's W on both its real branches. For the rational
    /// law `(1 + v_crit / v_s)^2 = (k_t2 / k_t1) N (f_s - f_c) / (v_s c)`. On a table the slope of each cubic is a
    /// parabola.
    #[must_use]
    pub fn unstable_speeds(&self) -> Vec<SpeedRange> {
        let law = self.friction_law();
        if let Shape::Table(_) = law.shape {
            return self.unstable_speeds_of_table(law);
        }
        let force = self.friction_transmission() * self.normal_force();
        let driving = force * law.falling();
        if driving <= 0.0 {
            return Vec::new();
        }
        let damping = self.scaled_tangential_damping() + force * law.rise(0.0);
        if damping == 0.0 {
            return vec![SpeedRange { from: 0.0, to: f64::INFINITY }];
        }
        let range = match law.shape {
            Shape::Rational => {
                let to = law.speed_scale * ((driving / (damping * law.speed_scale)).sqrt() - 1.0);
                (to > 0.0).then(|| SpeedRange { from: 0.0, to: self.rotating_speed(to) })
            }
            _ => self.unstable_speeds_of_stribeck(law, damping, driving),
        };
        range.into_iter().collect()
    }

    fn unstable_speeds_of_stribeck(&self, law: &FrictionLaw, damping: f64, driving: f64) -> Option<SpeedRange> {
        let level = libm::log(damping * law.speed_scale / (law.exponent * driving));
        let speed = |log_power: f64| self.rotating_speed(law.speed_scale * libm::exp(log_power / law.exponent));
        let power = 1.0 - 1.0 / law.exponent;
        if power == 0.0 {
            let to = self.rotating_speed(law.speed_scale * -level);
            return (to > 0.0).then_some(SpeedRange { from: 0.0, to });
        }
        if power < 0.0 {
            return Some(SpeedRange { from: 0.0, to: speed(upper_log_root(power, level)) });
        }
        let crest = power * libm::log(power) - power;
        (crest > level).then(|| SpeedRange {
            from: speed(log_root(power, level, level / power)),
            to: speed(upper_log_root(power, level)),
        })
    }

    /// Beyond the last row a curve is constant, and sliding stable.
    fn unstable_speeds_of_table(&self, law: &FrictionLaw) -> Vec<SpeedRange> {
        let force = self.friction_transmission() * self.normal_force();
        if force <= 0.0 {
            return Vec::new();
        }
        // Slopes of a piece are taken over its own speeds.
        let limit = -self.scaled_tangential_damping() / force * law.speed_scale;
        let mut ranges: Vec<SpeedRange> = Vec::new();
        for piece in law.pieces() {
            let mut ends = piece.speeds_of_slope(limit);
            ends.insert(0, piece.from);
            ends.push(piece.to);
            for pair in ends.windows(2) {
                if piece.slope(0.5 * (pair[0] + pair[1])) >= limit {
                    continue;
                }
                let [from, to] = [pair[0], pair[1]].map(|speed| self.rotating_speed(speed * law.speed_scale));
                match ranges.last_mut() {
                    Some(last) if last.to == from => last.to = to,
                    _ => ranges.push(SpeedRange { from, to }),
                }
            }
        }
        ranges
    }

    /// The rotating speed, rad/s, at which friction falls most steeply, whatever the preload and the static friction; 0
    /// if that is at rest. Above it, whatever is unstable at one speed is unstable at each lower one. `None` for a
    /// measured curve, which may fall in several places.
    #[must_use]
    pub fn steepest_speed(&self) -> Option<f64> {
        let law = self.friction_law();
        let steepest = || self.rotating_speed(law.steepest_between(f64::MIN_POSITIVE, f64::INFINITY));
        (!matches!(law.shape, Shape::Table(_))).then(steepest).map(|speed| if speed < 1e-300 { 0.0 } else { speed })
    }

    /// The boundary of linear stability at this rotating speed, for any preload Delta and static friction f_s: the
    /// hyperbola `Delta (f_s - f_0) = const`.
    ///
    /// f_0 is the static friction coefficient with which friction neither falls nor rises at this speed: f_c, with a
    /// viscous term k_v `f_c + k_v / w(v)`. Where a measured curve rises, nothing is unstable; but if it falls only
    /// because it is shifted by its standard deviations, that is so for small f_s, and the boundary is
    /// `Delta (f_0 - f_s) = const`.
    ///
    /// Samples outside physics are stable by definition, and never redrawn: `Delta <= 0` presses nothing together, and
    /// `f_s < f_c` means friction that rises with speed, or a measured curve without friction at rest or at this speed.
    #[must_use]
    pub fn stability_boundary(&self) -> PairBoundary {
        let (law, v) = (self.friction_law(), self.disc_speed());
        let damping = self.scaled_tangential_damping();
        let force = self.friction_transmission() * self.normal_force_per_preload();
        let (weakening, rise) = (law.weakening(v), law.rise(v));
        let driving = force * weakening.abs();
        let kinetic = law.kinetic_coefficient;
        let (critical_product, by_second, offset) = if driving > 0.0 && weakening > 0.0 {
            (damping / driving, 1.0, -(kinetic + rise / weakening))
        } else if driving > 0.0 && rise < 0.0 {
            (damping / driving, -1.0, kinetic + rise / weakening)
        } else if rise < 0.0 {
            (damping / force, 0.0, -rise)
        } else {
            // A weakening that underflows to zero drives nothing, whatever the damping.
            (f64::INFINITY, 1.0, -kinetic)
        };
        PairBoundary { critical_product, by_second, offset, least_second: law.least_static_coefficient(v) }
    }
}

/// The root of `power s - exp(s) = level` on the falling side.
fn upper_log_root(power: f64, level: f64) -> f64 {
    let mut start = 1.0_f64;
    while power * start - libm::exp(start) >= level {
        start *= 2.0;
    }
    log_root(power, level, start)
}

/// Newton's iteration for `power s - exp(s) = level` from a `start` below the level. The left-hand side is concave,
/// so the iterates approach the root from that side without overshooting.
fn log_root(power: f64, level: f64, start: f64) -> f64 {
    let mut s = start;
    for _ in 0..200 {
        let exponential = libm::exp(s);
        let next = s - (power * s - exponential - level) / (power - exponential);
        if (next - s).abs() <= 2.0 * f64::EPSILON * s.abs() || !next.is_finite() {
            break;
        }
        s = next;
    }
    s
}

#[cfg(test)]
mod tests;
