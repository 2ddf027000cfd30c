//! Whether steady sliding on a flexible disc is linearly stable, for every sample at little cost, and what feeds it
//! where it is not.
//!
//! The linearised equations depend on a sample through three numbers: the preload, the friction coefficient `mu` of
//! steady sliding, and the slope `m = (f_s - f_c) w(v)` with which friction falls there. The slope enters only through a
//! force on the tangential motion, proportional to `m Delta`, so at each preload and coefficient there is a critical
//! product: below it the falling friction takes less than the damping gives.
//!
//! Eigenvalues of all degrees of freedom take some hundred microseconds. So critical products are found once on a lattice
//! of preload and coefficient, and a sample is compared with those at the corners of its box:
//!
//! | `m Delta` of the sample | linearly |
//! |---|---|
//! | below all four by more than they differ among themselves, and by 0.2 % | stable |
//! | above all four by as much | unstable, fed by falling friction |
//! | else, or if a corner has no single critical product | the sample's own eigenvalues say |
//!
//! A corner has no single critical product if it is unstable without any fall of friction: then modes of pad and disc feed
//! each other through the contact (flutter), or the disc turns faster than one of its waves. Such corners are never
//! interpolated.

use std::collections::HashMap;
use std::fmt;
use std::sync::{Arc, PoisonError, RwLock};

use nalgebra::{Complex, DMatrix, DVector};

use crate::criterion::time_domain::Decision;
use crate::flexible_disc::brake::{FlexibleBrake, FlexibleError, PAD};
use crate::flexible_disc::stability::first_order;
use crate::numerics::eigenvalues::{Eigenvalue, EigenvalueError, eigenvalues};
use crate::rigid_disc::pad_on_disc::RandomInputs;
use crate::verdict::Verdict;

/// Lattice spacing of the logarithm of the preload, and of the friction coefficient. Neighbouring critical products of
/// the preset differ by less than a part in a thousand.
const PRELOAD_SPACING: f64 = 0.1;
const FRICTION_SPACING: f64 = 0.02;

/// Least distance from the critical products of a box at which they are believed, relative to them.
const LEAST_MARGIN: f64 = 2e-3;

/// Rows of the lattice, far beyond any friction coefficient.
const FARTHEST_ROW: f64 = 1e6;

/// Shares of the critical product below which a corner must be stable, and multiples at which it must be unstable. The
/// negative ones stand for friction that rises with speed.
const STABLE_AT: [f64; 6] = [-1.0, -0.3, 0.25, 0.5, 0.75, 0.95];
const UNSTABLE_AT: [f64; 4] = [1.05, 1.5, 4.0, 30.0];

/// Multiples of the critical product between which the lattice is believed.
const BELIEVED: (f64, f64) = (-1.0, 30.0);

/// A degree of freedom of pad and disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum DegreeOfFreedom {
    /// x, along the motion of the disc.
    Tangential,
    /// y, along the disc's axis.
    Normal,
    /// phi, the rotation of the pad.
    Angular,
    /// The bending of the disc.
    Disc,
}

impl fmt::Display for DegreeOfFreedom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Tangential => "tangential motion of the pad",
            Self::Normal => "normal motion of the pad",
            Self::Angular => "rotation of the pad",
            Self::Disc => "bending of the disc",
        })
    }
}

/// Linear stability of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LinearStability {
    /// Small motions about steady sliding die away.
    Stable,
    /// They grow.
    Unstable {
        /// What feeds them: the tangential motion where they would die away if friction did not fall with speed; or else
        /// the degree of freedom that has the largest share of the kinetic energy of the fastest growing mode.
        fed_by: DegreeOfFreedom,
    },
}

/// Critical products on the lattice, found when they are first asked for. Each is a function of the brake alone.
#[derive(Debug, Clone, Default)]
pub(crate) struct CriticalProducts {
    corners: Arc<RwLock<Corners>>,
}

/// By their place on the lattice: along the logarithm of the preload and along the friction coefficient.
type Corners = HashMap<(i64, i64), Option<f64>>;

impl CriticalProducts {
    fn at(&self, corner: (i64, i64), find: impl FnOnce() -> Option<f64>) -> Option<f64> {
        let known = self.corners.read().unwrap_or_else(PoisonError::into_inner).get(&corner).copied();
        known.unwrap_or_else(|| {
            let found = find();
            self.corners.write().unwrap_or_else(PoisonError::into_inner).insert(corner, found);
            found
        })
    }
}

/// The linearised equations at one preload and friction coefficient, for any slope.
struct Linearisation {
    stiffness: DMatrix<f64>,
    /// Without a fall of friction, and what one unit of slope adds.
    damping: DMatrix<f64>,
    damping_by_slope: DMatrix<f64>,
}

impl Linearisation {
    fn matrix(&self, slope: f64) -> DMatrix<f64> {
        first_order(&self.stiffness, &(&self.damping + &self.damping_by_slope * slope))
    }

    fn growth_rate(&self, slope: f64) -> Result<f64, EigenvalueError> {
        let values = eigenvalues(&self.matrix(slope))?;
        Ok(values.first().map_or(f64::NEG_INFINITY, |value| value.re))
    }
}

impl FlexibleBrake {
    /// Whether steady sliding is linearly stable, and what feeds it where it is not. The same as the sign of
    /// [`FlexibleBrake::growth_rate`], at a hundredth of the cost.
    ///
    /// # Errors
    /// As [`FlexibleBrake::growth_rate`].
    pub fn linear_stability(&self, inputs: RandomInputs) -> Result<LinearStability, FlexibleError> {
        match self.by_lattice(inputs) {
            Some(stability) => Ok(stability),
            None => self.by_eigenvalues(inputs),
        }
    }

    /// The verdict on a sample by the coupled eigenvalues, of its own or by the lattice, whichever is asked for by
    /// `stability`: [`FlexibleBrake::linear_stability`] for one of many samples, [`FlexibleBrake::by_eigenvalues`] for a
    /// single one. Without preload a sample is stable; one whose equilibrium or eigenvalues cannot be found is failed.
    #[must_use]
    pub fn decide_with(
        &self,
        inputs: RandomInputs,
        stability: impl Fn(&Self, RandomInputs) -> Result<LinearStability, FlexibleError>,
    ) -> Decision {
        if inputs.preload <= 0.0 {
            return Decision::OUTSIDE_PHYSICS;
        }
        let (verdict, fed_by) = match stability(self, inputs) {
            Ok(LinearStability::Stable) => (Verdict::Stable, None),
            Ok(LinearStability::Unstable { fed_by }) => (Verdict::Unstable, Some(fed_by)),
            Err(_) => (Verdict::Failed, None),
        };
        Decision { fed_by, ..Decision::from(verdict) }
    }

    /// [`FlexibleBrake::linear_stability`] by the eigenvalues of this very sample.
    ///
    /// # Errors
    /// As [`FlexibleBrake::growth_rate`].
    pub fn by_eigenvalues(&self, inputs: RandomInputs) -> Result<LinearStability, FlexibleError> {
        let values = self.coupled_eigenvalues(inputs)?;
        let Some(fastest) = values.first().filter(|value| value.re > 0.0) else {
            return Ok(LinearStability::Stable);
        };
        let linearisation = self.linearisation(inputs)?;
        let fed_by = if linearisation.growth_rate(0.0)? <= 0.0 {
            DegreeOfFreedom::Tangential
        } else {
            self.largest_share(&linearisation.matrix(self.friction_slope(inputs.static_friction)), *fastest)
        };
        Ok(LinearStability::Unstable { fed_by })
    }

    /// The growth rate of the fastest growing mode if friction did not fall with speed: positive where modes of pad and
    /// disc feed each other.
    ///
    /// # Errors
    /// As [`FlexibleBrake::growth_rate`].
    pub fn growth_rate_without_fall(&self, inputs: RandomInputs) -> Result<f64, FlexibleError> {
        Ok(self.linearisation(inputs)?.growth_rate(0.0)?)
    }

    fn linearisation(&self, inputs: RandomInputs) -> Result<Linearisation, FlexibleError> {
        let q = self.sliding_equilibrium(inputs)?;
        let mu = self.pad.friction_coefficient(self.pad.disc_speed, inputs.static_friction);
        let (stiffness, damping) = self.linearise_with(&q, mu, 0.0);
        let damping_by_slope = self.linearise_with(&q, mu, 1.0).1 - &damping;
        Ok(Linearisation { stiffness, damping, damping_by_slope })
    }

    fn by_lattice(&self, inputs: RandomInputs) -> Option<LinearStability> {
        let RandomInputs { preload, static_friction } = inputs;
        if !(preload > 0.0 && static_friction.is_finite()) {
            return None;
        }
        let pad = &self.pad;
        let mu = pad.friction_coefficient(pad.disc_speed, static_friction);
        let column = (libm::log(preload) / PRELOAD_SPACING).floor() as i64;
        let row = ((mu - pad.kinetic_friction) / FRICTION_SPACING).floor();
        if row.abs() > FARTHEST_ROW {
            return None;
        }
        let row = row as i64;
        let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
        for corner in [(column, row), (column + 1, row), (column, row + 1), (column + 1, row + 1)] {
            let critical = self.critical_products.at(corner, || self.critical_product(corner))?;
            least = least.min(critical);
            most = most.max(critical);
        }
        let product = self.friction_slope(static_friction) * preload;
        let margin = (most - least) + LEAST_MARGIN * most;
        if product < least - margin && product >= BELIEVED.0 * least {
            Some(LinearStability::Stable)
        } else if product > most + margin && product <= BELIEVED.1 * least {
            Some(LinearStability::Unstable { fed_by: DegreeOfFreedom::Tangential })
        } else {
            None
        }
    }

    /// The critical product at a corner of the lattice, if it has a single one.
    fn critical_product(&self, (column, row): (i64, i64)) -> Option<f64> {
        let preload = libm::exp(PRELOAD_SPACING * column as f64);
        let mu = self.pad.kinetic_friction + FRICTION_SPACING * row as f64;
        let q = self.sliding_equilibrium_with(preload, mu)?;
        let (stiffness, damping) = self.linearise_with(&q, mu, 0.0);
        let damping_by_slope = self.linearise_with(&q, mu, 1.0).1 - &damping;
        let linearisation = Linearisation { stiffness, damping, damping_by_slope };
        let growth_rate = |slope: f64| linearisation.growth_rate(slope).ok();
        let at_rest = growth_rate(0.0)?;
        let by_slope = linearisation.damping_by_slope[(0, 0)];
        if at_rest >= 0.0 || by_slope <= 0.0 {
            return None;
        }
        // Where the falling friction takes what the tangential damper gives; the other degrees of freedom shift it a little.
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
        // False position with halved weights (Illinois).
        for _ in 0..60 {
            if high - low <= 1e-9 * high {
                break;
            }
            let middle = high - at_high * (high - low) / (at_high - at_low);
            let at_middle = growth_rate(middle)?;
            if at_middle > 0.0 {
                (high, at_high) = (middle, at_middle);
                at_low *= 0.5;
            } else {
                (low, at_low) = (middle, at_middle);
                at_high *= 0.5;
            }
        }
        let stable = STABLE_AT.iter().all(|share| growth_rate(share * high).is_some_and(|rate| rate < 0.0));
        let unstable = UNSTABLE_AT.iter().all(|multiple| growth_rate(multiple * high).is_some_and(|rate| rate > 0.0));
        (stable && unstable).then_some(high * preload)
    }

    /// The degree of freedom with the largest share of the kinetic energy in the mode of an eigenvalue.
    fn largest_share(&self, matrix: &DMatrix<f64>, value: Eigenvalue) -> DegreeOfFreedom {
        let size = self.size();
        let mode = eigenvector(matrix, value);
        // Kinetic energy over the pad's mass: x, y, phi and the amplitudes with the masses that go with the contact force.
        let energy = |i: usize, mass: f64| 0.5 * mass * mode[size + i].norm_sqr();
        let length = self.brake().scales().length;
        let pad = &self.brake().parameters().pad;
        let inertia = pad.moment_of_inertia / (pad.mass * length * length);
        let disc = self.amplitudes.iter().enumerate();
        let disc = disc.map(|(k, amplitude)| energy(PAD + k, self.pad.pressure_gain / amplitude.compliance)).sum();
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
mod tests {
    use super::*;
    use crate::rigid_disc::pad_on_disc::PadOnDisc;

    fn flexible(changes: &[(&str, f64)]) -> FlexibleBrake {
        FlexibleBrake::with_modes(PadOnDisc::preset_with(changes), 5).unwrap()
    }

    /// Inputs over the plane, denser towards the boundary of the preset's product.
    fn inputs(count: u32) -> impl Iterator<Item = RandomInputs> {
        (0..count).map(move |i| {
            let (a, b) = (0.618_034 * f64::from(i), 0.414_214 * f64::from(i));
            let (a, b) = (a - a.floor(), b - b.floor());
            let preload = 0.005 + 0.6 * a * a;
            let fall = if i % 2 == 0 { b * 0.7 - 0.1 } else { 0.0138 / preload * (1.0 + 0.02 * (b - 0.5)) };
            RandomInputs { preload, static_friction: 0.25 + fall }
        })
    }

    #[test]
    fn the_lattice_says_what_the_eigenvalues_say() {
        for changes in [
            vec![("operating_point.rotating_speed", 15.4)],
            vec![("operating_point.rotating_speed", 15.4), ("disc.youngs_modulus", 4e9)],
            vec![("operating_point.rotating_speed", 24.0), ("friction.stribeck_exponent", 2.0)],
            vec![("operating_point.rotating_speed", 20.0), ("disc.transverse_damping_ratio", 0.0)],
            // 50 Stribeck velocities: nothing is left of the fall of friction there.
            vec![("operating_point.rotating_speed", 15.0), ("friction.stribeck_velocity", 0.0405)],
        ] {
            let flexible = flexible(&changes);
            let mut by_lattice = 0;
            for inputs in inputs(300) {
                let exact = flexible.by_eigenvalues(inputs).unwrap();
                if let Some(stability) = flexible.by_lattice(inputs) {
                    assert_eq!(stability, exact, "{changes:?} {inputs:?}");
                    by_lattice += 1;
                }
                assert_eq!(flexible.linear_stability(inputs).unwrap(), exact);
            }
            // An undamped disc flutters almost everywhere, and has few critical products.
            let flutters = changes.contains(&("disc.transverse_damping_ratio", 0.0));
            assert!(flutters || by_lattice > 200, "{changes:?}: {by_lattice}");
        }
    }

    #[test]
    fn flutter_is_fed_by_the_disc_and_stick_slip_by_the_tangential_motion() {
        let nominal = RandomInputs { preload: 0.1, static_friction: 0.39 };
        let groaning = flexible(&[("operating_point.rotating_speed", 12.0)]);
        let tangential = LinearStability::Unstable { fed_by: DegreeOfFreedom::Tangential };
        assert_eq!(groaning.linear_stability(nominal).unwrap(), tangential);
        assert_eq!(groaning.by_eigenvalues(nominal).unwrap(), tangential);
        let disc = LinearStability::Unstable { fed_by: DegreeOfFreedom::Disc };
        for changes in [
            [("disc.transverse_damping_ratio", 0.0), ("operating_point.rotating_speed", 40.0)],
            [("disc.transverse_damping_ratio", 0.02), ("operating_point.rotating_speed", 2e4)],
        ] {
            assert_eq!(flexible(&changes).linear_stability(nominal).unwrap(), disc, "{changes:?}");
        }
    }

    #[test]
    fn an_eigenvector_is_one() {
        let flexible = flexible(&[]);
        let inputs = RandomInputs { preload: 0.1, static_friction: 0.39 };
        let matrix = flexible.linearisation(inputs).unwrap().matrix(0.3);
        for value in eigenvalues(&matrix).unwrap().into_iter().take(3) {
            let vector = eigenvector(&matrix, value);
            let image = matrix.map(|entry| Complex::new(entry, 0.0)) * &vector;
            let residual = (image - &vector * value).norm();
            assert!(residual < 1e-7 * vector.norm(), "{value}: {residual}");
        }
    }
}
