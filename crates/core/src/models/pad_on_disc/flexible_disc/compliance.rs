//! The static compliance of the disc under the pad, mode by mode.

use crate::models::pad_on_disc::flexible_disc::plate_modes::{MOST_DISC_MODES, PlateMode};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use crate::numerics::eigenvalues::EigenvalueError;
use crate::numerics::quadrature::gauss_legendre;

/// Share of the static compliance under the pad that the kept modes must carry.
pub(crate) const LEAST_COMPLIANCE: f64 = 0.9;

/// Points along the radius of the pad for the mean shape of a mode.
const COMPLIANCE_POINTS: usize = 24;

/// What each mode adds to the static deflection of the disc under the pad, averaged over the patch, for a force that is
/// spread evenly over it: `<psi>^2 / (m lambda^4)`, in a unit that all modes share,
/// at rest, without the centrifugal softening of the rotation. It depends on the geometry alone.
pub(crate) fn relative_compliances(brake: &PadOnDisc, modes: &[PlateMode]) -> Vec<f64> {
    let (disc, pad) = (&brake.parameters().disc, &brake.parameters().pad);
    let inner = pad.inner_radius / disc.outer_radius;
    let rule = gauss_legendre(COMPLIANCE_POINTS);
    let compliance = |mode: &PlateMode| {
        let angle = f64::from(mode.nodal_diameters) * pad.half_angle;
        let along_angle = if angle > 0.0 { libm::sin(angle) / angle } else { 1.0 };
        let along_radius = |&(s, weight): &(f64, f64)| {
            let r = 0.5 * ((1.0 + inner) + (1.0 - inner) * s);
            weight * r * mode.shape(r) / (1.0 + inner)
        };
        let mean = along_angle * rule.iter().map(along_radius).sum::<f64>();
        mean * mean / (mode.circle() * mode.frequency_parameter * mode.frequency_parameter)
    };
    modes.iter().map(compliance).collect()
}

/// [`relative_compliances`] in m/N: times `h^3 / (D b^2)` and by the square of the frequency for one unit of lambda^2.
pub(crate) fn compliances(brake: &PadOnDisc, modes: &[PlateMode]) -> Vec<f64> {
    let disc = &brake.parameters().disc;
    let gain = disc.thickness * disc.thickness * disc.thickness / brake.scales().flexural_rigidity;
    let frequency = brake.frequency_per_parameter();
    let unit = gain / (disc.outer_radius * disc.outer_radius * frequency * frequency);
    relative_compliances(brake, modes).iter().map(|compliance| unit * compliance).collect()
}

/// The modes of lowest frequency, enough of them for every model.
///
/// # Errors
/// As [`AnnularPlate::modes`](crate::models::pad_on_disc::flexible_disc::plate_modes::AnnularPlate::modes).
pub(crate) fn lowest_modes(brake: &PadOnDisc) -> Result<Vec<PlateMode>, EigenvalueError> {
    modes_below(brake, MOST_DISC_MODES as u32)
}

/// The modes with fewer nodal diameters and up to three nodal circles, in the order of their frequencies. As many of
/// them as there are nodal diameters are the lowest of all.
///
/// # Errors
/// As [`lowest_modes`].
pub(crate) fn modes_below(brake: &PadOnDisc, nodal_diameters: u32) -> Result<Vec<PlateMode>, EigenvalueError> {
    let plate = brake.annular_plate();
    let mut modes = Vec::new();
    for nodal_diameters in 0..nodal_diameters {
        modes.extend(plate.modes(nodal_diameters, 4)?);
    }
    modes.sort_by(|a, b| a.frequency_parameter.total_cmp(&b.frequency_parameter));
    Ok(modes)
}
