//! Linear stability of steady sliding, in closed form.
//!
//! On a rigid disc the Jacobian is block triangular (normal, tangential, angular motion), so its six eigenvalues
//! are those of three oscillators. Only the tangential one can lose its damping:
//!
//! ```text
//! m1 = [ (k_t2 / k_t1) N (f_s - f_c) w(v) - c_x sqrt(eta0) ] / (M eta0),      N = k_en k_y Delta / (k_en + k_y)
//! ```
//!
//! with the weakening `w(v)` of the friction law. Steady sliding is unstable exactly when `m1 > 0`, so the boundary
//! in the plane of preload and static friction is a hyperbola, `Delta (f_s - f_c) = const`.

use nalgebra::DMatrix;

use crate::numerics::eigenvalues::Eigenvalue;
use crate::parameters::Parameters;
use crate::rigid_disc::pad_on_disc::{Oscillator, PadOnDisc};
use crate::verdict::{Verdict, VerdictCounts};

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

/// Rotating speeds between which steady sliding is unstable, rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpeedRange {
    /// Lower end: 0 for Stribeck exponents up to 1; above 1 the friction curve is flat at rest, and very slow
    /// sliding is stable again.
    pub from: f64,
    /// Upper end, the critical speed; infinite if nothing damps the tangential motion.
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
        self.tangential_oscillator().eigenvalues()[0].re
    }

    /// The rotating speeds at which steady sliding is unstable with this preload and friction, or `None` if it is
    /// stable at every speed. The upper end is the critical speed.
    ///
    /// For Tustin's law `v_crit = v_s ln[(k_t2 / k_t1) N (f_s - f_c) / (v_s c_x sqrt(eta0))]`. For other exponents
    /// `u = (v / v_s)^delta` solves `u^p exp(-u) = c_x sqrt(eta0) v_s / (delta (k_t2 / k_t1) N (f_s - f_c))` with
    /// `p = 1 - 1/delta`, which is `u = -p W(...)` with Lambert's W on both its real branches.
    #[must_use]
    pub fn unstable_speeds(&self) -> Option<SpeedRange> {
        let law = self.friction_law();
        let falling = law.static_coefficient - law.kinetic_coefficient;
        let driving = self.friction_transmission() * self.normal_force() * falling;
        if driving <= 0.0 {
            return None;
        }
        let damping = self.scaled_tangential_damping();
        if damping == 0.0 {
            return Some(SpeedRange { from: 0.0, to: f64::INFINITY });
        }
        let level = libm::log(damping * law.stribeck_velocity / (law.exponent * driving));
        let speed = |log_power: f64| self.rotating_speed(law.stribeck_velocity * libm::exp(log_power / law.exponent));
        let power = 1.0 - 1.0 / law.exponent;
        if power == 0.0 {
            let to = self.rotating_speed(law.stribeck_velocity * -level);
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

    /// The boundary of linear stability at this rotating speed, for any preload and static friction.
    #[must_use]
    pub fn stability_boundary(&self) -> StabilityBoundary {
        let damping = self.scaled_tangential_damping();
        let weakening = self.friction_law().weakening(self.disc_speed());
        let driving = self.friction_transmission() * self.normal_force_per_preload() * weakening;
        StabilityBoundary {
            // A weakening that underflows to zero drives nothing, whatever the damping.
            critical_product: if driving > 0.0 { damping / driving } else { f64::INFINITY },
            kinetic_coefficient: self.friction_law().kinetic_coefficient,
        }
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

/// The hyperbola `Delta (f_s - f_c) = critical_product` that separates stable from unstable steady sliding at one
/// rotating speed.
///
/// Samples outside physics are stable by definition, and never redrawn: `Delta <= 0` presses nothing together, and
/// `f_s < f_c` means friction that rises with speed. (The bare product would call "both negative" unstable.)
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StabilityBoundary {
    critical_product: f64,
    kinetic_coefficient: f64,
}

impl StabilityBoundary {
    /// `Delta (f_s - f_c)` on the boundary; non-negative, infinite where nothing is ever unstable.
    #[must_use]
    pub fn critical_product(&self) -> f64 {
        self.critical_product
    }

    /// f_c, the kinetic friction coefficient.
    #[must_use]
    pub fn kinetic_coefficient(&self) -> f64 {
        self.kinetic_coefficient
    }

    /// The static friction coefficient on the boundary at a given preload; infinite for preloads that are not
    /// positive.
    #[must_use]
    pub fn critical_static_friction(&self, preload: f64) -> f64 {
        if preload > 0.0 { self.kinetic_coefficient + self.critical_product / preload } else { f64::INFINITY }
    }

    /// The preload on the boundary at a given static friction coefficient; infinite where friction does not fall.
    #[must_use]
    pub fn critical_preload(&self, static_friction: f64) -> f64 {
        let falling = static_friction - self.kinetic_coefficient;
        if falling > 0.0 { self.critical_product / falling } else { f64::INFINITY }
    }

    /// The verdict on one sample.
    #[inline]
    #[must_use]
    pub fn verdict(&self, preload: f64, static_friction: f64) -> Verdict {
        if self.is_unstable(preload, static_friction) { Verdict::Unstable } else { Verdict::Stable }
    }

    #[inline]
    fn is_unstable(&self, preload: f64, static_friction: f64) -> bool {
        let falling = static_friction - self.kinetic_coefficient;
        // `&`, not `&&`: the loop over samples then has no branches and runs in vector registers.
        (preload > 0.0) & (falling > 0.0) & (preload * falling > self.critical_product)
    }

    /// The verdicts on samples `(preloads[i], static_frictions[i])`, counted.
    ///
    /// # Panics
    /// If the slices differ in length.
    #[inline]
    #[must_use]
    pub fn count(&self, preloads: &[f64], static_frictions: &[f64]) -> VerdictCounts {
        assert_eq!(preloads.len(), static_frictions.len());
        let unstable = preloads.iter().zip(static_frictions).map(|(&p, &f)| u64::from(self.is_unstable(p, f))).sum();
        VerdictCounts { stable: preloads.len() as u64 - unstable, unstable, ..VerdictCounts::default() }
    }
}

#[cfg(test)]
mod tests;
