//! The model of pad and flexible disc: its modes, its steady sliding, and the eigenvalues there.
//!
//! # How many modes
//!
//! 60 random brakes, each with its own preload, a third of it and three times of it, compared with 24 modes. The brakes
//! have E 2e10 to 2.1e11 Pa, h 8 to 30 mm, preload 0.02 to 0.3, zeta 0.002 to 0.05, contact stiffness 0.3 to 3 times
//! that of the preset, 5 to 40 rad/s, v_s 0.2 to 3 m/s, f_c 0.1 to 0.4, and f_s up to twice that.
//!
//! | modes | other sign of the growth rate | largest difference | over the growth rate or 0.1 |
//! |---|---|---|---|
//! | 5 | 0 of 180 | 0.13 | 5.7 % |
//! | as `mode_count` finds, 5 to 14 | 0 of 180 | 0.007 | 0.14 % |
//! | 16 | 0 of 180 | 0.002 | 0.02 % |
//!
//! Five modes were not enough at 46 of the 180 points. A sign changes only close to the boundary; the module
//! `mode_count` says what a difference of the growth rate means there.

use std::sync::{Arc, OnceLock};

use crate::models::pad_on_disc::flexible_disc::compliance::{LEAST_COMPLIANCE, lowest_modes, relative_compliances};
use crate::models::pad_on_disc::flexible_disc::critical_products::CriticalProducts;
use crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations;
use crate::models::pad_on_disc::flexible_disc::equilibrium::EquilibriumSearch;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::flexible_disc::geometry::DiscGeometry;
use crate::models::pad_on_disc::flexible_disc::linearisation::first_order;
use crate::models::pad_on_disc::flexible_disc::plate_modes::{MOST_DISC_MODES, PlateMode};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::numerics::eigenvalues::{Eigenvalue, eigenvalues};

/// Disc modes that the preset needs, those with 0 to 4 nodal diameters and no nodal circle. Other brakes may need more:
/// see the module `mode_count`.
pub const DISC_MODES: usize = 5;

/// Pad and flexible disc at one rotating speed; preload and static friction are given sample by sample.
///
/// What the geometry alone determines is shared between brakes, see [`FlexibleBrake::with_brake`].
#[derive(Debug, Clone)]
pub struct FlexibleBrake {
    pub(crate) equations: FlexibleEquations,
    /// Prepared when it is first needed.
    search: OnceLock<EquilibriumSearch>,
    /// Where linear stability is lost.
    pub(crate) critical_products: CriticalProducts,
}

impl FlexibleBrake {
    /// The model with [`DISC_MODES`] disc modes.
    ///
    /// # Errors
    /// [`FlexibleError`] if the disc has no computable modes, or if they are too stiff for it.
    pub fn new(brake: PadOnDisc) -> Result<Self, FlexibleError> {
        Self::with_modes(brake, DISC_MODES)
    }

    /// The model with the `count` disc modes of lowest frequency; a cosine and its sine count as one.
    ///
    /// # Errors
    /// As [`FlexibleBrake::new`], and if `count` is 0, more than [`MOST_DISC_MODES`], or too small to carry nine tenths
    /// of the disc's static compliance under the pad.
    pub fn with_modes(brake: PadOnDisc, count: usize) -> Result<Self, FlexibleError> {
        if count == 0 || count > MOST_DISC_MODES {
            return Err(FlexibleError::ModeCount { count });
        }
        let modes = lowest_modes(&brake)?;
        let compliances = relative_compliances(&brake, &modes);
        let total: f64 = compliances.iter().sum();
        let share = |count: usize| compliances[..count].iter().sum::<f64>() / total;
        if share(count) < LEAST_COMPLIANCE {
            let needed = (1..=modes.len()).find(|&count| share(count) >= LEAST_COMPLIANCE);
            let needed = needed.unwrap_or(MOST_DISC_MODES + 1);
            return Err(FlexibleError::TooFewModes { count, share: share(count), needed });
        }
        Ok(Self::of_modes(brake, &modes[..count]))
    }

    /// The model of another brake, with as many modes. The same as [`FlexibleBrake::with_modes`], at a thousandth of
    /// the cost if radii, Poisson's ratio and the pad's angle are the same numbers: the modes of the disc are not
    /// solved again then, and the averages of their shapes over the patch are shared.
    ///
    /// # Errors
    /// As [`FlexibleBrake::with_modes`].
    pub fn with_brake(&self, brake: PadOnDisc) -> Result<Self, FlexibleError> {
        let geometry = &self.equations.geometry;
        if geometry.is_of(brake.parameters()) {
            return Ok(Self::of_geometry(brake, Arc::clone(geometry)));
        }
        Self::with_modes(brake, self.modes())
    }

    /// The model with these modes, however little of the compliance they carry.
    pub(crate) fn of_modes(brake: PadOnDisc, modes: &[PlateMode]) -> Self {
        let geometry = DiscGeometry::new(brake.parameters(), modes);
        Self::of_geometry(brake, geometry)
    }

    /// The model of a brake with this geometry.
    pub(crate) fn of_geometry(brake: PadOnDisc, geometry: Arc<DiscGeometry>) -> Self {
        let equations = FlexibleEquations::new(brake, geometry);
        Self { equations, search: OnceLock::new(), critical_products: CriticalProducts::default() }
    }

    /// The pad and its operating point.
    #[must_use]
    pub fn brake(&self) -> &PadOnDisc {
        &self.equations.brake
    }

    /// Modes of the disc that are kept; a cosine and its sine count as one.
    #[must_use]
    pub fn modes(&self) -> usize {
        self.equations.geometry.modes.len()
    }

    /// Degrees of freedom: x, y, phi, the cosine amplitudes and the sine amplitudes of the disc.
    pub(crate) fn size(&self) -> usize {
        self.equations.size()
    }

    /// The displacements of steady sliding: x and y over h, phi in rad, then the amplitudes of the disc over h.
    ///
    /// # Errors
    /// [`FlexibleError::NotPressed`] for a preload of zero or less, [`FlexibleError::NoEquilibrium`] if neither Newton's
    /// method nor continuation from the equilibrium under a small load finds one, [`FlexibleError::Rotated`] if the pad
    /// turns beyond small angles in it.
    pub fn sliding_equilibrium(&self, inputs: RandomInputs) -> Result<Vec<f64>, FlexibleError> {
        let search = self.search.get_or_init(|| EquilibriumSearch::new(&self.equations));
        search.find(&self.equations, inputs)
    }

    /// The eigenvalues of the coupled model linearised about its own sliding equilibrium; per unit of scaled time.
    ///
    /// # Errors
    /// [`FlexibleError`] if there is no equilibrium, or if the eigenvalues do not converge.
    pub(crate) fn coupled_eigenvalues(&self, inputs: RandomInputs) -> Result<Vec<Eigenvalue>, FlexibleError> {
        let q = self.sliding_equilibrium(inputs)?;
        let (stiffness, damping) = self.equations.linearise(inputs, &q);
        Ok(eigenvalues(&first_order(&stiffness, &damping))?)
    }

    /// The largest real part of the coupled eigenvalues: steady sliding is unstable where it is positive.
    ///
    /// # Errors
    /// [`FlexibleError`] if there is no equilibrium, or if the eigenvalues do not converge.
    pub fn growth_rate(&self, inputs: RandomInputs) -> Result<f64, FlexibleError> {
        Ok(self.least_stable(inputs)?.re)
    }

    /// The coupled eigenvalue with that real part.
    ///
    /// # Errors
    /// As [`FlexibleBrake::growth_rate`].
    pub fn least_stable(&self, inputs: RandomInputs) -> Result<Eigenvalue, FlexibleError> {
        let values = self.coupled_eigenvalues(inputs)?;
        let least = values.into_iter().reduce(|least, value| if value.re > least.re { value } else { least });
        Ok(least.unwrap_or(Eigenvalue::new(f64::NEG_INFINITY, 0.0)))
    }
}

#[cfg(test)]
mod tests;
