//! What the geometry of disc and pad alone determines of the model.

use std::sync::Arc;

use crate::models::pad_on_disc::flexible_disc::contact::patch::ContactPatch;
use crate::models::pad_on_disc::flexible_disc::contact::points::sufficient_points;
use crate::models::pad_on_disc::flexible_disc::plate_modes::PlateMode;
use crate::models::pad_on_disc::parameters::Parameters;

/// The disc's modes, their shapes on the patch and the averages of these. They depend on the radii a, b and r_a,
/// Poisson's ratio, and the pad's angle psi. Thickness, Young's modulus and density change all frequencies in the same
/// proportion, and so neither the shapes nor their order.
#[derive(Debug)]
pub(crate) struct DiscGeometry {
    /// The bits of what it depends on.
    key: [u64; 5],
    /// Modes of the disc that are kept; a cosine and its sine count as one.
    pub modes: Vec<PlateMode>,
    pub patch: ContactPatch,
    /// The cosine and the sine amplitude of each mode that has both.
    pub pairs: Vec<(usize, usize)>,
    /// lambda^2 of the lowest mode.
    pub lowest_parameter: f64,
    /// Shapes of the cosine amplitudes at the outer edge, and a quarter of the way to it.
    pub shapes_at_edge: Vec<f64>,
    pub shapes_inside: Vec<f64>,
}

impl DiscGeometry {
    /// With as many points on the patch as the modes need.
    pub fn new(parameters: &Parameters, modes: &[PlateMode]) -> Arc<Self> {
        Self::with_points(parameters, modes, sufficient_points(parameters, modes))
    }

    /// With a given number of points along the radius and along the angle of the patch.
    pub fn with_points(parameters: &Parameters, modes: &[PlateMode], (radial, angular): (usize, usize)) -> Arc<Self> {
        let clamped = parameters.disc.inner_radius / parameters.disc.outer_radius;
        let shapes_at = |r: f64| modes.iter().map(|mode| mode.shape(r)).collect();
        let with_sine = (0..modes.len()).filter(|&index| modes[index].nodal_diameters > 0);
        let parameters_of_modes = modes.iter().map(|mode| mode.frequency_parameter);
        Arc::new(Self {
            pairs: with_sine.zip(modes.len()..).collect(),
            lowest_parameter: parameters_of_modes.fold(f64::INFINITY, f64::min),
            key: key(parameters),
            patch: ContactPatch::new(parameters, modes, radial, angular),
            shapes_at_edge: shapes_at(1.0),
            shapes_inside: shapes_at(clamped + 0.25 * (1.0 - clamped)),
            modes: modes.to_vec(),
        })
    }

    /// Whether a disc and a pad with these parameters have this geometry, to the bit.
    pub fn is_of(&self, parameters: &Parameters) -> bool {
        self.key == key(parameters)
    }
}

/// The bits of the parameters that the geometry depends on.
fn key(parameters: &Parameters) -> [u64; 5] {
    let (disc, pad) = (&parameters.disc, &parameters.pad);
    [disc.inner_radius, disc.outer_radius, disc.poissons_ratio, pad.inner_radius, pad.half_angle].map(f64::to_bits)
}
