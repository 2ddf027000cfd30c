//! Whether steady sliding on a flexible disc is linearly stable, for every sample at little cost, and what feeds it
//! where it is not.
//!
//! The linearised equations depend on a sample through three numbers: the preload, the friction coefficient `mu` of
//! steady sliding, and the slope `m = (f_s - f_c) w(v)` with which friction falls there. The slope enters only through
//! a force on the tangential motion, proportional to `m Delta`, so at each preload and coefficient there is a critical
//! product, below which the falling friction feeds the motion less than the dampers take from it.
//!
//! The eigenvalues of all degrees of freedom take some hundred microseconds. So critical products are found once on a
//! lattice of preload and coefficient, and a sample is compared with those at the corners of its box:
//!
//! | `m Delta` of the sample | linearly |
//! |---|---|
//! | below all four by more than they differ among themselves, and by 0.2 % | stable |
//! | above all four by as much | unstable, fed by falling friction |
//! | else, or if a corner has no single critical product | by its response, or else by its own eigenvalues |
//!
//! A corner has no single critical product if it is unstable without any fall of friction: then modes of pad and disc
//! feed each other through the contact (flutter), or the disc turns faster than one of its waves. Such corners are
//! never interpolated.

use nalgebra::{Complex, DMatrix, DVector};

use crate::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::pad::equations::PAD;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::numerics::eigenvalues::{Eigenvalue, eigenvalues};
use crate::numerics::root_location::false_position;

/// Lattice spacing of the logarithm of the preload, and of the friction coefficient. Neighbouring critical products of
/// the preset differ by less than a part in a thousand.
const PRELOAD_SPACING: f64 = 0.1;
const FRICTION_SPACING: f64 = 0.02;

/// Least distance from the critical products of a box at which they decide, relative to them.
const LEAST_MARGIN: f64 = 2e-3;

/// Rows of the lattice, far beyond any friction coefficient.
const FARTHEST_ROW: f64 = 1e6;

/// Shares of the critical product below which a corner must be stable, and multiples at which it must be unstable. The
/// negative ones stand for friction that rises with speed.
const STABLE_AT: [f64; 6] = [-1.0, -0.3, 0.25, 0.5, 0.75, 0.95];
const UNSTABLE_AT: [f64; 4] = [1.05, 1.5, 4.0, 30.0];

/// Multiples of the critical product between which the lattice decides.
const BELIEVED: (f64, f64) = (-1.0, 30.0);

/// Linear stability of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinearStability {
    /// Small motions about steady sliding die away.
    Stable,
    /// They grow.
    Unstable {
        /// What feeds them: the tangential motion where they would die away if friction did not fall with speed; or
        /// else the degree of freedom that has the largest share of the kinetic energy of the fastest growing mode.
        fed_by: DegreeOfFreedom,
    },
}

impl FlexibleBrake {
    /// [`FlexibleBrake::linear_stability`] by the eigenvalues of this very sample.
    ///
    /// # Errors
    /// As [`FlexibleBrake::growth_rate`].
    pub fn by_eigenvalues(&self, inputs: RandomInputs) -> Result<LinearStability, FlexibleError> {
        let q = self.sliding_equilibrium(inputs)?;
        let pad = &self.equations.coefficients.pad;
        let linearisation = self.equations.linearise_with(&q, pad.steady_friction(inputs.static_friction));
        let slope = self.equations.friction_slope(inputs.static_friction);
        let matrix = linearisation.first_order(slope);
        let values = eigenvalues(&matrix)?;
        let Some(fastest) = values.first().filter(|value| value.re > 0.0) else {
            return Ok(LinearStability::Stable);
        };
        let without_fall = eigenvalues(&linearisation.first_order(0.0))?;
        let fed_by = if slope > 0.0 && without_fall.first().is_none_or(|value| value.re <= 0.0) {
            DegreeOfFreedom::Tangential
        } else {
            self.largest_share(&matrix, *fastest)
        };
        Ok(LinearStability::Unstable { fed_by })
    }

    /// By the critical products of the sample's box; `None` if they leave it open, or if it is stopped while they are
    /// sought.
    pub(crate) fn by_lattice(&self, inputs: RandomInputs, is_stopped: &dyn Fn() -> bool) -> Option<LinearStability> {
        let RandomInputs { preload, static_friction } = inputs;
        if !(preload > 0.0 && static_friction.is_finite()) {
            return None;
        }
        let pad = &self.equations.coefficients.pad;
        let mu = pad.steady_friction(static_friction);
        let column = (libm::log(preload) / PRELOAD_SPACING).floor() as i64;
        let row = ((mu - pad.kinetic_friction) / FRICTION_SPACING).floor();
        if row.abs() > FARTHEST_ROW {
            return None;
        }
        let row = row as i64;
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in [(column, row), (column + 1, row), (column, row + 1), (column + 1, row + 1)] {
            let find = || self.critical_product(corner, is_stopped);
            let critical = self.critical_products.at(corner, find, is_stopped)?;
            least = least.min(critical);
            most = most.max(critical);
        }
        let product = self.equations.friction_slope(static_friction) * preload;
        let margin = (most - least) + LEAST_MARGIN * most;
        if product < least - margin && product >= BELIEVED.0 * least {
            Some(LinearStability::Stable)
        } else if product > most + margin && product <= BELIEVED.1 * least {
            Some(LinearStability::Unstable { fed_by: DegreeOfFreedom::Tangential })
        } else {
            None
        }
    }

    /// [`FlexibleBrake::sliding_equilibrium`] at a friction coefficient `mu`, whatever law gives it.
    fn sliding_equilibrium_with(&self, preload: f64, mu: f64) -> Option<Vec<f64>> {
        let pad = &self.equations.coefficients.pad;
        let static_friction = pad.static_friction_for(mu);
        let q = self.sliding_equilibrium(RandomInputs { preload, static_friction }).ok()?;
        q.iter().all(|q| q.is_finite()).then_some(q)
    }

    /// The critical product at a corner of the lattice, if it has a single one and the search is not stopped.
    fn critical_product(&self, (column, row): (i64, i64), is_stopped: &dyn Fn() -> bool) -> Option<f64> {
        let preload = libm::exp(PRELOAD_SPACING * column as f64);
        let mu = self.equations.coefficients.pad.kinetic_friction + FRICTION_SPACING * row as f64;
        let q = self.sliding_equilibrium_with(preload, mu)?;
        let linearisation = self.equations.linearise_with(&q, mu);
        let growth_rate = |slope: f64| if is_stopped() { None } else { linearisation.growth_rate(slope).ok() };
        let at_rest = growth_rate(0.0)?;
        let by_slope = linearisation.damping_by_slope[(0, 0)];
        if at_rest >= 0.0 || by_slope <= 0.0 {
            return None;
        }
        // Where the falling friction takes what the tangential damper gives; the other degrees of freedom shift it a
        // little.
        let guess = -linearisation.damping[(0, 0)] / by_slope;
        let (mut low, mut at_low, mut high) = (0.0, at_rest, guess);
        let mut at_high = growth_rate(high)?;
        for _ in 0..40 {
            if at_high > 0.0 {
                break;
            }
            (low, at_low) = (high, at_high);
            high = 1.05 * high + 1e-9;
            at_high = growth_rate(high)?;
        }
        if at_high <= 0.0 {
            return None;
        }
        // Where the eigenvalues do not converge, the value is no number, and the search ends there.
        let value = |slope: &f64| growth_rate(*slope).map_or(f64::NAN, |rate| -rate);
        let (high, _) = false_position((low, -at_low), (high, -at_high), high, 1e-9 * high, |slope| slope, value);
        growth_rate(high)?;
        let stable = STABLE_AT.iter().all(|share| growth_rate(share * high).is_some_and(|rate| rate < 0.0));
        let unstable = UNSTABLE_AT.iter().all(|multiple| growth_rate(multiple * high).is_some_and(|rate| rate > 0.0));
        (stable && unstable).then_some(high * preload)
    }

    /// The degree of freedom with the largest share of the kinetic energy in the mode of an eigenvalue.
    fn largest_share(&self, matrix: &DMatrix<f64>, value: Eigenvalue) -> DegreeOfFreedom {
        let size = self.size();
        let mode = eigenvector(matrix, value);
        // Kinetic energy over the pad's mass: x, y, phi and the amplitudes with the masses that go with the contact
        // force.
        let energy = |i: usize, mass: f64| 0.5 * mass * mode[size + i].norm_sqr();
        let length = self.brake().scales().length;
        let pad = &self.brake().parameters().pad;
        let inertia = pad.moment_of_inertia / (pad.mass * length * length);
        let disc = self.equations.coefficients.amplitudes.iter().enumerate();
        let disc = disc
            .map(|(k, amplitude)| energy(PAD + k, self.equations.coefficients.pad.pressure_gain / amplitude.compliance))
            .sum();
        let shares = [
            (DegreeOfFreedom::Tangential, energy(0, 1.0)),
            (DegreeOfFreedom::Normal, energy(1, 1.0)),
            (DegreeOfFreedom::Angular, energy(2, inertia)),
            (DegreeOfFreedom::Disc, disc),
        ];
        let largest = |a: (DegreeOfFreedom, f64), b: (DegreeOfFreedom, f64)| if b.1 > a.1 { b } else { a };
        shares.into_iter().fold((DegreeOfFreedom::Tangential, 0.0), largest).0
    }
}

/// The eigenvector of a known eigenvalue, by inverse iteration from a start without symmetry.
fn eigenvector(matrix: &DMatrix<f64>, value: Eigenvalue) -> DVector<Complex<f64>> {
    let size = matrix.nrows();
    // Beside the eigenvalue, or there would be nothing to invert.
    let shift = value * (1.0 + 1e-9) + Complex::new(1e-12, 0.0);
    let shifted = matrix.map(|entry| Complex::new(entry, 0.0)) - DMatrix::from_diagonal_element(size, size, shift);
    let solver = shifted.lu();
    let mut vector = DVector::from_fn(size, |i, _| Complex::new(1.0 / (1.0 + i as f64), 0.3 / (2.0 + i as f64)));
    for _ in 0..3 {
        if let Some(next) = solver.solve(&vector) {
            let norm = next.iter().map(|entry| entry.re.abs().max(entry.im.abs())).fold(0.0, f64::max);
            vector = next / Complex::new(norm, 0.0);
        }
    }
    vector
}

#[cfg(test)]
mod tests;
