//! How many quadrature points the patch needs.

use crate::models::pad_on_disc::flexible_disc::plate_modes::PlateMode;
use crate::models::pad_on_disc::parameters::Parameters;
use crate::numerics::quadrature::gauss_legendre;

/// Gauss-Legendre points of the patch along the radius and along the angle, at the least.
pub(crate) const RADIAL_POINTS: usize = 4;
pub(crate) const ANGULAR_POINTS: usize = 8;

/// What the rule may miss of a product of three shapes (two and a slope, as in the follower load), relative to the cube
/// of their size. Products of two shapes are better by far. The 4 x 8 points of the preset with five modes miss 5e-6.
const PRODUCT_TOLERANCE: f64 = 1e-5;

/// Largest number of points; beyond them the modes are finer than anything that the plate model describes.
const MOST_POINTS: usize = 96;

/// Points along the radius and along the angle that integrate products of these modes over the patch.
pub(crate) fn sufficient_points(parameters: &Parameters, modes: &[PlateMode]) -> (usize, usize) {
    let inner = parameters.pad.inner_radius / parameters.disc.outer_radius;
    let mean = |points: usize, mode: &PlateMode| {
        let (mut square, mut product) = (0.0, 0.0);
        for (s, weight) in gauss_legendre(points) {
            let r = 0.5 * ((1.0 + inner) + (1.0 - inner) * s);
            let shape = mode.shape(r);
            square += weight * r * shape * shape / (1.0 + inner);
            product += weight * shape * shape * shape / (1.0 + inner);
        }
        (square, product)
    };
    let radial_suffice = |points: usize| {
        modes.iter().all(|mode| {
            let ((_, product), (square, exact)) = (mean(points, mode), mean(2 * points, mode));
            (product - exact).abs() <= PRODUCT_TOLERANCE * square * square.sqrt()
        })
    };
    // The shortest wave of such a product.
    let most_diameters = modes.iter().map(|mode| mode.nodal_diameters).max().unwrap_or(0);
    let phase = 3.0 * f64::from(most_diameters) * parameters.pad.half_angle;
    let angular_suffice = |points: usize| {
        let mean: f64 = gauss_legendre(points).iter().map(|(x, weight)| 0.5 * weight * libm::cos(phase * x)).sum();
        phase == 0.0 || (mean - libm::sin(phase) / phase).abs() <= PRODUCT_TOLERANCE
    };
    let first = |from: usize, suffice: &dyn Fn(usize) -> bool| {
        (from..MOST_POINTS).find(|&points| suffice(points)).unwrap_or(MOST_POINTS)
    };
    // Fewer than two points for a wave length may seem to suffice by chance.
    let waves = (phase / std::f64::consts::PI).ceil() as usize;
    (first(RADIAL_POINTS, &radial_suffice), first(ANGULAR_POINTS.max(2 * waves), &angular_suffice))
}
