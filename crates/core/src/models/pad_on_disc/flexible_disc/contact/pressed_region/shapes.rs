//! The disc's modes on the patch, at any radius and angle.

use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::line::{Radius, SampleAngle};
use crate::models::pad_on_disc::flexible_disc::plate_modes::{
    MOST_REFERENCE_MODES, PlateMode, RADIAL_FUNCTIONS, RadialFunctions,
};
use crate::numerics::quadrature::gauss_legendre;

/// Intervals along the radius between the lines on which the pressed region is sought.
pub(super) const PROBE_INTERVALS: usize = 8;

/// The disc's modes on the patch, at any radius and angle; lengths are over b here.
#[derive(Debug, Clone)]
pub(crate) struct PressedRegion {
    pub inner: f64,
    /// Of the lengths along the disc, over b.
    pub length_unit: f64,
    pub half_angle: f64,
    /// n of every mode.
    pub harmonics: Vec<usize>,
    /// Modes with a sine shape, in the order of the odd amplitudes.
    pub odd_modes: Vec<usize>,
    /// One more than the largest n.
    pub harmonic_count: usize,
    /// a / b.
    pub radius_ratio: f64,
    /// Of the radial functions, each in all modes.
    pub coefficients: Vec<[f64; MOST_REFERENCE_MODES]>,
    pub probes: Vec<Radius>,
    pub(super) samples: Vec<SampleAngle>,
    /// For panels wider than a quarter of the pad, and for narrower ones, which count for less.
    pub radial_rules: [Vec<(f64, f64)>; 3],
    pub angular_rule: Vec<(f64, f64)>,
}

/// The expansions of modes, function by function.
fn coefficients(modes: &[PlateMode]) -> Vec<[f64; MOST_REFERENCE_MODES]> {
    let mut rows = vec![[0.0; MOST_REFERENCE_MODES]; RADIAL_FUNCTIONS];
    for (index, mode) in modes.iter().enumerate() {
        for (row, coefficient) in rows.iter_mut().zip(mode.coefficients()) {
            row[index] = *coefficient;
        }
    }
    rows
}

impl PressedRegion {
    /// `radial` points between two cuts of the radius, `angular` points on each piece of a line.
    pub fn new(
        modes: &[PlateMode],
        (inner, length_unit, half_angle): (f64, f64, f64),
        radial: usize,
        angular: usize,
    ) -> Self {
        let harmonics: Vec<usize> = modes.iter().map(|mode| mode.nodal_diameters as usize).collect();
        let most_waves = harmonics.iter().copied().max().unwrap_or(0);
        let mut region = Self {
            inner,
            length_unit,
            half_angle,
            odd_modes: (0..modes.len()).filter(|&mode| harmonics[mode] > 0).collect(),
            harmonic_count: most_waves + 1,
            radius_ratio: modes.first().map_or(0.0, PlateMode::radius_ratio),
            coefficients: coefficients(modes),
            probes: Vec::new(),
            samples: Vec::new(),
            radial_rules: [radial, 3 * radial / 4, radial / 2].map(gauss_legendre),
            angular_rule: gauss_legendre(angular),
            harmonics,
        };
        let share = |i: usize| i as f64 / PROBE_INTERVALS as f64;
        region.probes = (0..=PROBE_INTERVALS).map(|i| region.at(inner + (1.0 - inner) * share(i))).collect();
        // Half a radian of the shortest wave at most.
        let intervals = ((4.0 * most_waves as f64 * half_angle).ceil() as usize).max(8);
        let sample = |i: usize| {
            let theta = half_angle * (2.0 * i as f64 / intervals as f64 - 1.0);
            let wave = |n: usize| (libm::cos(n as f64 * theta), libm::sin(n as f64 * theta));
            SampleAngle { theta, waves: (0..=most_waves).map(wave).collect() }
        };
        region.samples = (0..=intervals).map(sample).collect();
        region
    }

    pub fn at(&self, r: f64) -> Radius {
        let functions = RadialFunctions::at(r, self.radius_ratio);
        let (mut shapes, modes) = ([0.0; MOST_REFERENCE_MODES], self.harmonics.len());
        for (function, coefficients) in functions.values().zip(&self.coefficients) {
            for (shape, coefficient) in shapes[..modes].iter_mut().zip(coefficients) {
                *shape += coefficient * function;
            }
        }
        Radius { r, shapes }
    }
}
