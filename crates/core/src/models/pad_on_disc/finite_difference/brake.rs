//! The paper's own method for the disc, as a reference for the modal one: a polar grid of the plate in the disc's own
//! frame, over which the pad's load moves.
//!
//! In the frame that turns with the disc, `W(theta, t) = w(theta + Om t, t)`, the Om terms of the paper's equation
//! (2.5) vanish and the load moves. Their signs say which way: the middle of the pad is at `theta_pad = -Om t`, since
//! the disc passes under it towards growing theta. Damping in the space-fixed frame, as [`FlexibleBrake`] has it,
//! stays there:
//!
//! ```text
//! W_tt + (1/h) nabla^4 W + eta1 (W_t - Om W_theta) = (h^2 / D) p,       eta1 = 2 zeta omega_1
//! p = -(k_en h g+ / A_s) (1 + mu s W_theta / r),       g = W - y - r theta tan(phi),       P = k_en <g+>
//! ```
//!
//! with theta in `g` counted from the middle of the pad. The patch is a set of Gauss-Legendre points. `W` and `W_theta`
//! at a point are linear between the nodes around it, along the radius and along the ring, and its load is allotted to
//! the same nodes with the same weights: the work done on the nodes is the work that the loads do at their points.
//!
//! Time steps are `dt = dtheta / (C Om)` with the smallest integer C for which explicit steps are stable. The disc
//! makes steps of central differences, with the load in their middle, where the deflection is known. The pad then makes
//! the same step by the Runge-Kutta method with located stick and slip (as on every other disc), on a surface that
//! moves linearly from the disc's old deflection to its new one. The error is of second order in dt, or of first order
//! in the one step in which friction jumps at an event. As dt is a small fraction of what the pad's motion needs, what
//! is left is the error of the grid.

use thiserror::Error;

use crate::models::pad_on_disc::criterion::settings::SettingsError;
use crate::models::pad_on_disc::finite_difference::patch::{MovingPatch, Passage, Surface};
use crate::models::pad_on_disc::finite_difference::plate::grid::PlateGrid;
use crate::models::pad_on_disc::finite_difference::plate::motion::{ExplicitStep, PlateMotion};
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::motion::flexible::FlexibleMotion;
use crate::models::pad_on_disc::pad::equations::PadEquations;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

/// Numbers of intervals that a grid may have along the radius, and elements that it may have under the pad.
const RADIAL: (usize, usize) = (4, 64);
const PER_PAD: (usize, usize) = (4, 64);

/// The pad of the paper covers this part of the edge.
const PADS_AROUND: usize = 6;

/// Step length over the longest that is stable.
const STEP: f64 = 0.95;

/// The grid of the disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct DiscGrid {
    /// Intervals from the clamped inner radius to the free edge, 4 to 64.
    pub radial: usize,
    /// The paper's n, 4 to 64: there are `6 n` elements around the disc, and n of them lie under a pad that covers a
    /// sixth of it. Pads of other sizes cover more or fewer.
    pub per_pad: usize,
}

/// How the load passes from node to node (section 3.1 of the paper).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Allotment {
    /// Case a: the pad stands still on the disc's nodes and jumps on by one element each time it is half an element
    /// behind. `C dtheta = Om dt` with C = 1 for the load; between two jumps the disc makes many stable steps.
    Nodal,
    /// Case b: `dtheta = C Om dt`. The pad moves on by a C-th of an element with every step, and each load is allotted
    /// to the nodes e and e + 1 around it in the proportion `1 - i/C` to `i/C`.
    Linear,
}

/// Why there is no finite-difference model, or no motion of it.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FiniteDifferenceError {
    /// A grid that is too coarse to mean anything, or too fine to simulate.
    #[error("grid.{key} = {value} is out of range: it must be at least {least} and at most {most}")]
    Grid {
        /// Which number of the grid.
        key: &'static str,
        /// Its value.
        value: usize,
        /// Lower limit.
        least: usize,
        /// Upper limit.
        most: usize,
    },
    /// The pad, the modes that give eta1, or the equilibrium.
    #[error(transparent)]
    Brake(#[from] FlexibleError),
    /// Displacement or horizon.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The equations of the grid could not be solved.
    #[error("the deflection of the disc under the pad cannot be computed on this grid")]
    NotSolvable,
}

/// Pad and disc on a grid, at one rotating speed.
///
/// ```
/// use stickslip_core::models::pad_on_disc::finite_difference::brake::{Allotment, DiscGrid, FiniteDifferenceBrake};
/// use stickslip_core::models::pad_on_disc::motion::start::Start;
/// use stickslip_core::models::pad_on_disc::parameters::Parameters;
/// use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
/// let brake = PadOnDisc::new(Parameters::sui_ding_2018())?;
/// let brake = FiniteDifferenceBrake::new(brake, DiscGrid { radial: 6, per_pad: 6 })?;
/// let inputs = RandomInputs { preload: 0.1, static_friction: 0.39 };
/// let trajectory = brake.trajectory(inputs, Start::Rest, 0.01, 10.0, Allotment::Linear)?;
/// assert!(trajectory.moments.iter().all(|moment| moment.contact_force > 0.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct FiniteDifferenceBrake {
    /// Gives the pad's equations, eta1, linear stability and the interval between moments; its disc does not move.
    pub(crate) modal: FlexibleMotion,
    pub(crate) plate: PlateGrid,
    pub(crate) patch: MovingPatch,
    /// Om.
    pub(crate) spin: f64,
    /// h k_en / D: the acceleration of a node with the area h^2 that carries the whole pad, for a gap of 1.
    pub(crate) contact_gain: f64,
    /// C.
    pub(crate) steps_per_element: u64,
    /// dt.
    pub(crate) step_length: f64,
    pub(crate) step: ExplicitStep,
}

impl FiniteDifferenceBrake {
    /// The model on a grid.
    ///
    /// # Errors
    /// [`FiniteDifferenceError::Grid`] if a number of the grid is out of range, and [`FiniteDifferenceError::Brake`] as
    /// [`FlexibleBrake::new`], which gives the damping of the disc.
    pub fn new(brake: PadOnDisc, grid: DiscGrid) -> Result<Self, FiniteDifferenceError> {
        for (key, value, (least, most)) in [("radial", grid.radial, RADIAL), ("per_pad", grid.per_pad, PER_PAD)] {
            if value < least || value > most {
                return Err(FiniteDifferenceError::Grid { key, value, least, most });
            }
        }
        let modal = FlexibleMotion::new(FlexibleBrake::new(brake)?);
        let brake = modal.brake.brake();
        let parameters = brake.parameters();
        let (disc, h) = (&parameters.disc, parameters.disc.thickness);
        let radii = (disc.inner_radius / h, disc.outer_radius / h);
        let plate = PlateGrid::new(grid.radial, PADS_AROUND * grid.per_pad, radii, h, disc.poissons_ratio);
        let patch = MovingPatch::new(&plate, parameters.pad.inner_radius / h, parameters.pad.half_angle, grid.per_pad);
        let spin = parameters.operating_point.rotating_speed * brake.scales().time;
        let contact_gain = h * parameters.stiffness.contact_normal / brake.scales().flexural_rigidity;
        // The contact stiffens the disc at most as if one node carried the whole pad.
        let least_area = plate.area(1).min(plate.area(plate.rings));
        let stiffest = plate.largest_squared_frequency() + contact_gain / least_area;
        let longest = (STEP * 2.0 / stiffest.sqrt()).min(modal.step);
        let steps_per_element = (plate.angle / (spin * longest)).ceil().max(1.0);
        let step_length = plate.angle / (spin * steps_per_element);
        let step = plate.explicit_step(step_length, modal.brake.equations.coefficients.disc_damping, spin);
        let steps_per_element = steps_per_element as u64;
        Ok(Self { modal, plate, patch, spin, contact_gain, steps_per_element, step_length, step })
    }

    /// The pad's equations.
    pub(crate) fn pad(&self) -> &PadEquations {
        &self.modal.brake.equations.coefficients.pad
    }

    /// dt, scaled time.
    #[must_use]
    pub fn step_length(&self) -> f64 {
        self.step_length
    }

    /// `lambda^2 = omega b^2 sqrt(rho h / D)` of the grid's first `count` motions with `nodal_diameters`, in ascending
    /// order; at most as many as there are radial intervals. Beyond half of the elements around the disc
    /// `nodal_diameters` repeat themselves.
    ///
    /// # Errors
    /// [`FiniteDifferenceError::Brake`] if the eigenvalues do not converge.
    #[cfg(test)]
    pub(crate) fn frequency_parameters(
        &self,
        nodal_diameters: usize,
        count: usize,
    ) -> Result<Vec<f64>, FiniteDifferenceError> {
        let squared = self.plate.squared_frequencies(nodal_diameters).map_err(FlexibleError::from)?;
        let thickness = self.modal.brake.brake().parameters().disc.thickness;
        let parameter = |squared: &f64| self.plate.outer * self.plate.outer * (squared * thickness).sqrt();
        Ok(squared.iter().take(count).map(parameter).collect())
    }

    /// The deflection over h at rest under a `pressure` (Pa, by radius in m and angle in rad from the middle of the
    /// pad) on the patch: `radial` rings from the one next to the clamped rim to the edge, each with its `6 n` nodes
    /// from angle 0 on.
    ///
    /// # Errors
    /// [`FiniteDifferenceError::NotSolvable`] if the stiffness of the grid is singular, which no plate of a brake is.
    #[cfg(test)]
    pub(crate) fn static_deflection(
        &self,
        pressure: impl Fn(f64, f64) -> f64,
    ) -> Result<Vec<f64>, FiniteDifferenceError> {
        let brake = self.modal.brake.brake();
        let h = brake.parameters().disc.thickness;
        let scale = h * h / brake.scales().flexural_rigidity * self.patch.area;
        let places = self.patch.places(self.plate.angle);
        let loads: Vec<f64> = places
            .zip(&self.patch.points)
            .map(|((radius, angle), point)| scale * point.weight * pressure(h * radius, angle))
            .collect();
        self.steady_deflection(0.0, &loads)
    }

    /// The mean static deflection under the pad for a unit force that is spread evenly over the patch, m/N; what
    /// the compliances of the modes add up to.
    ///
    /// # Errors
    /// As [`FiniteDifferenceBrake::static_deflection`].
    #[cfg(test)]
    pub(crate) fn compliance(&self) -> Result<f64, FiniteDifferenceError> {
        let h = self.modal.brake.brake().parameters().disc.thickness;
        let area = h * h * self.patch.area;
        let deflection = self.static_deflection(|_, _| 1.0 / area)?;
        let surface = self.surface(&self.plate.at_rest(&deflection));
        Ok(h * self.patch.average(surface.deflections.iter().copied()))
    }

    /// The deflection, ring by ring, that stands still under the loads of the points where the pad is at first.
    pub(crate) fn steady_deflection(&self, spin: f64, loads: &[f64]) -> Result<Vec<f64>, FiniteDifferenceError> {
        let mut positions = Vec::new();
        self.patch.locate(&self.plate, Passage::default(), &mut positions);
        let mut by_node = vec![0.0; self.plate.rings * self.plate.columns];
        self.patch.allot(&self.plate, &positions, loads, |ring, column, load| {
            by_node[(ring - 1) * self.plate.columns + column] += load;
        });
        self.plate.steady_deflection(spin, &by_node).ok_or(FiniteDifferenceError::NotSolvable)
    }

    /// The disc under the pad where the pad is at first.
    pub(crate) fn surface(&self, motion: &PlateMotion) -> Surface {
        let (mut positions, mut surface) = (Vec::new(), Surface::default());
        self.patch.locate(&self.plate, Passage::default(), &mut positions);
        self.patch.read(&self.plate, motion, &positions, &mut surface);
        surface
    }
}

#[cfg(test)]
mod tests;
