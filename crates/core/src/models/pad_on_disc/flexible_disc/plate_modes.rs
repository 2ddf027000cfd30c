//! Modes of the disc: a thin annular plate, clamped at the inner and free at the outer radius.
//!
//! With `w = R(r) cos(n theta)` the strain and kinetic energies of Kirchhoff's plate are, up to common factors,
//!
//! ```text
//! U = integral of [ (L R)^2 - 2 (1 - nu) ( R'' G R - n^2 (H R)^2 ) ] r dr,      T = omega^2 rho h / D  integral of R^2 r dr
//! L R = R'' + R'/r - n^2 R/r^2,     G R = R'/r - n^2 R/r^2,     H R = (R/r)'
//! ```
//!
//! (A. W. Leissa, Vibration of Plates, NASA SP-160, 1969, chapter 2). The radial function is expanded in
//! `s^2 P_k(2 s - 1)`, `s = (r - a)/(b - a)`, Legendre polynomials times a factor that clamps the inner edge
//! (Ritz's method); the free edge is the natural boundary condition of the energy.

use nalgebra::{Cholesky, DMatrix, SymmetricEigen};

use crate::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use crate::numerics::eigenvalues::EigenvalueError;
use crate::numerics::quadrature::{gauss_legendre, legendre};

/// Radial functions of the expansion. Sixteen give the first four frequencies of each nodal diameter to ten digits.
pub(crate) const RADIAL_FUNCTIONS: usize = 16;

/// Points of the Gauss-Legendre rule, exact for the polynomial part of the integrands and far beyond it.
const QUADRATURE_POINTS: usize = 48;

/// Modes of the disc that a model may keep, and the number of nodal diameters among which they are sought.
pub const MOST_DISC_MODES: usize = 24;

/// Modes of the disc with which models are compared, at the most.
pub(crate) const MOST_REFERENCE_MODES: usize = 2 * MOST_DISC_MODES;

/// A clamped-free annular plate, by its two ratios.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnnularPlate {
    /// a / b, between 0 and 1.
    pub radius_ratio: f64,
    /// nu.
    pub poissons_ratio: f64,
}

/// One mode of the plate, `w = R(r) cos(n theta)` (and, for n > 0, its twin with the sine).
#[derive(Debug, Clone, PartialEq)]
pub struct PlateMode {
    /// n, the number of nodal diameters.
    pub nodal_diameters: u32,
    /// lambda^2 = omega b^2 sqrt(rho h / D).
    pub frequency_parameter: f64,
    /// a / b.
    radius_ratio: f64,
    /// Of the expansion; the integral of `R^2 r dr` from a to b is 1 with b as unit of length, and `R(b) > 0`.
    coefficients: Vec<f64>,
}

impl PlateMode {
    /// The radial shape `R` at radius `r`, `a/b <= r <= 1`, with b as unit of length.
    pub(crate) fn shape(&self, r: f64) -> f64 {
        let functions = RadialFunctions::at(r, self.radius_ratio);
        let terms = self.coefficients.iter().zip(&functions.polynomials);
        functions.factor * terms.map(|(c, p)| c * p).sum::<f64>()
    }

    /// The integral of the square of the shape along the angle, `cos(n theta)` or `sin(n theta)`.
    pub(crate) fn circle(&self) -> f64 {
        if self.nodal_diameters == 0 { 2.0 * std::f64::consts::PI } else { std::f64::consts::PI }
    }

    /// Of the radial functions, see [`RadialFunctions`].
    pub(crate) fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// a / b.
    pub(crate) fn radius_ratio(&self) -> f64 {
        self.radius_ratio
    }
}

/// Values at one radius of what modes are expanded in, `s^2 P_k(2 s - 1)`.
pub(crate) struct RadialFunctions {
    factor: f64,
    polynomials: [f64; RADIAL_FUNCTIONS],
}

impl RadialFunctions {
    /// At radius `r` over b of a plate with this `a / b`.
    pub fn at(r: f64, radius_ratio: f64) -> Self {
        let s = (r - radius_ratio) / (1.0 - radius_ratio);
        let x = 2.0 * s - 1.0;
        let mut polynomials = [1.0; RADIAL_FUNCTIONS];
        polynomials[1] = x;
        for k in 2..RADIAL_FUNCTIONS {
            let (a, b) = ((2 * k - 1) as f64 / k as f64, (k - 1) as f64 / k as f64);
            polynomials[k] = a * x * polynomials[k - 1] - b * polynomials[k - 2];
        }
        Self { factor: s * s, polynomials }
    }

    /// One after the other.
    pub fn values(&self) -> impl Iterator<Item = f64> {
        self.polynomials.iter().map(|p| self.factor * p)
    }
}

impl AnnularPlate {
    /// The first `count` modes with `nodal_diameters` nodal diameters, in the order of their frequencies.
    ///
    /// # Errors
    /// [`EigenvalueError`] if the matrices degenerate, as they do when the annulus is almost closed.
    ///
    /// # Panics
    /// If `count` exceeds eight: the expansion does not resolve more modes.
    pub fn modes(&self, nodal_diameters: u32, count: usize) -> Result<Vec<PlateMode>, EigenvalueError> {
        assert!(count <= RADIAL_FUNCTIONS / 2, "at most {} radial modes are resolved", RADIAL_FUNCTIONS / 2);
        let (stiffness, mass) = self.energies(f64::from(nodal_diameters));
        let not_finite = || EigenvalueError::NotFinite { row: 0, column: 0 };
        let cholesky = Cholesky::new(mass).ok_or_else(not_finite)?;
        let lower = cholesky.l();
        // L^-1 K L^-T, symmetric by construction but for rounding.
        let half = lower.solve_lower_triangular(&stiffness).ok_or_else(not_finite)?;
        let reduced = lower.solve_lower_triangular(&half.transpose()).ok_or_else(not_finite)?;
        let symmetric = (&reduced + reduced.transpose()) * 0.5;
        let sweeps = 1000 * RADIAL_FUNCTIONS;
        let eigen =
            SymmetricEigen::try_new(symmetric, f64::EPSILON, sweeps).ok_or(EigenvalueError::NotConverged { sweeps })?;
        // The eigenvectors of the reduced problem are orthonormal, so L^-T of them are so with respect to the mass.
        let shapes = lower.tr_solve_lower_triangular(&eigen.eigenvectors).ok_or_else(not_finite)?;
        let mode = |column: usize| {
            let coefficients: Vec<f64> = shapes.column(column).iter().copied().collect();
            // P_k(1) = 1 for every k: the sum is R(b).
            let sign = if coefficients.iter().sum::<f64>() < 0.0 { -1.0 } else { 1.0 };
            PlateMode {
                nodal_diameters,
                frequency_parameter: eigen.eigenvalues[column].max(0.0).sqrt(),
                radius_ratio: self.radius_ratio,
                coefficients: coefficients.into_iter().map(|c| sign * c).collect(),
            }
        };
        let mut modes: Vec<PlateMode> = (0..RADIAL_FUNCTIONS).map(mode).collect();
        modes.sort_by(|a, b| a.frequency_parameter.total_cmp(&b.frequency_parameter));
        modes.truncate(count);
        Ok(modes)
    }

    /// Stiffness and mass matrix of the expansion, with b as unit of length.
    fn energies(&self, n: f64) -> (DMatrix<f64>, DMatrix<f64>) {
        let width = 1.0 - self.radius_ratio;
        let mut stiffness = DMatrix::zeros(RADIAL_FUNCTIONS, RADIAL_FUNCTIONS);
        let mut mass = DMatrix::zeros(RADIAL_FUNCTIONS, RADIAL_FUNCTIONS);
        for (node, weight) in gauss_legendre(QUADRATURE_POINTS) {
            let s = 0.5 * (node + 1.0);
            let r = self.radius_ratio + width * s;
            let weight = 0.5 * width * weight * r;
            let functions: Vec<RadialTerms> =
                (0..RADIAL_FUNCTIONS).map(|k| RadialTerms::new(k, s, width, r, n)).collect();
            for (i, f) in functions.iter().enumerate() {
                for (j, g) in functions.iter().enumerate() {
                    let gaussian = f.second * g.hoop + g.second * f.hoop - 2.0 * n * n * f.twist * g.twist;
                    let energy = f.laplacian * g.laplacian - (1.0 - self.poissons_ratio) * gaussian;
                    stiffness[(i, j)] += weight * energy;
                    mass[(i, j)] += weight * f.value * g.value;
                }
            }
        }
        (stiffness, mass)
    }
}

/// One radial function at one radius, with what the energies are made of.
struct RadialTerms {
    value: f64,
    second: f64,
    laplacian: f64,
    hoop: f64,
    twist: f64,
}

impl RadialTerms {
    fn new(degree: usize, s: f64, width: f64, r: f64, n: f64) -> Self {
        let (p, dp, ddp) = legendre(degree, 2.0 * s - 1.0);
        // R = s^2 P(2 s - 1); derivatives by r = a + width s.
        let value = s * s * p;
        let first = (2.0 * s * p + 2.0 * s * s * dp) / width;
        let second = (2.0 * p + 8.0 * s * dp + 4.0 * s * s * ddp) / (width * width);
        let hoop = first / r - n * n * value / (r * r);
        Self { value, second, laplacian: second + hoop, hoop, twist: first / r - value / (r * r) }
    }
}

impl PadOnDisc {
    /// The disc as an annular plate.
    #[must_use]
    pub fn annular_plate(&self) -> AnnularPlate {
        let disc = &self.parameters().disc;
        AnnularPlate { radius_ratio: disc.inner_radius / disc.outer_radius, poissons_ratio: disc.poissons_ratio }
    }

    /// Angular frequency, per unit of scaled time, of a disc mode: `lambda^2 h^(3/2) / b^2`, lengths in metres. Over
    /// tau it is the frequency of the plate in rad/s, see [`Scales`](crate::models::pad_on_disc::rigid_disc::pad_on_disc::Scales).
    #[must_use]
    pub fn disc_frequency(&self, mode: &PlateMode) -> f64 {
        mode.frequency_parameter * self.frequency_per_parameter()
    }

    /// [`PadOnDisc::disc_frequency`] for one unit of lambda^2: all that thickness, modulus and density change of it.
    pub(crate) fn frequency_per_parameter(&self) -> f64 {
        let disc = &self.parameters().disc;
        let rigidity_over_density = self.scales().flexural_rigidity / (disc.density * disc.thickness);
        rigidity_over_density.sqrt() * self.scales().time / (disc.outer_radius * disc.outer_radius)
    }
}

/// lambda^2 for a/b = 0.064/0.135, nu = 0.3, clamped-free, from the zeros of the determinant of Bessel functions
/// (computed independently of this crate): one row for each number of nodal diameters, from 0.
#[cfg(test)]
pub(crate) const BESSEL_FREQUENCIES: [[f64; 3]; 5] = [
    [11.7565, 76.6917, 220.0855],
    [11.9802, 78.4021, 221.8871],
    [13.3679, 83.5585, 227.3205],
    [17.3691, 92.2270, 236.4629],
    [24.6646, 104.4948, 249.4168],
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::models::pad_on_disc::parameters::Parameters;

    fn parameters(plate: &AnnularPlate, n: u32) -> Vec<f64> {
        plate.modes(n, 3).unwrap().iter().map(|mode| mode.frequency_parameter).collect()
    }

    #[test]
    fn modes_are_orthonormal_clamped_and_free() {
        let plate = AnnularPlate { radius_ratio: 0.064 / 0.135, poissons_ratio: 0.3 };
        let modes = plate.modes(3, 4).unwrap();
        // Midpoint rule, independent of the quadrature inside.
        let (points, width) = (20_000, 1.0 - plate.radius_ratio);
        let radius = |i: usize| plate.radius_ratio + width * (i as f64 + 0.5) / points as f64;
        for (i, a) in modes.iter().enumerate() {
            assert_eq!(a.shape(plate.radius_ratio), 0.0);
            assert!(a.shape(1.0) > 0.0);
            for (j, b) in modes.iter().enumerate() {
                let product: f64 = (0..points).map(radius).map(|r| a.shape(r) * b.shape(r) * r).sum();
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((product * width / points as f64 - expected).abs() < 1e-6, "{i} {j} {product}");
            }
            // Free edge, R'' + nu (R'/r - n^2 R/r^2) = 0 at r = 1, by one-sided differences of fourth order.
            let h = 1e-3;
            let at: Vec<f64> = (0..6).map(|k| a.shape(1.0 - h * f64::from(k))).collect();
            let first = (25.0 * at[0] - 48.0 * at[1] + 36.0 * at[2] - 16.0 * at[3] + 3.0 * at[4]) / (12.0 * h);
            let second = (45.0 * at[0] - 154.0 * at[1] + 214.0 * at[2] - 156.0 * at[3] + 61.0 * at[4] - 10.0 * at[5])
                / (12.0 * h * h);
            let moment = second + 0.3 * (first - 9.0 * at[0]);
            assert!(moment.abs() < 1e-4 * a.frequency_parameter, "{moment}");
        }
    }

    #[test]
    fn frequencies_agree_with_the_bessel_determinant() {
        let plate = AnnularPlate { radius_ratio: 0.064 / 0.135, poissons_ratio: 0.3 };
        for (n, row) in BESSEL_FREQUENCIES.iter().enumerate() {
            let computed = parameters(&plate, n as u32);
            for (value, expected) in computed.iter().zip(row) {
                assert!((value - expected).abs() < 1e-4, "n = {n}: {value} {expected}");
            }
        }
    }

    #[test]
    fn other_plates_agree_with_the_bessel_determinant() {
        // lambda^2 from the zeros of the 4x4 determinant of J, Y, I, K, evaluated with SciPy 1.17's Bessel functions:
        // a/b, nu, n, first three.
        let table = [
            (0.3, 0.0, 0, [6.238274, 41.591728, 122.547782]),
            (0.3, 0.0, 5, [36.680976, 101.267699, 190.28985]),
            (0.3, 1.0 / 3.0, 1, [6.560133, 44.705863, 125.904408]),
            (0.3, 1.0 / 3.0, 2, [7.854989, 50.941007, 133.11577]),
            (0.7, 0.0, 1, [36.854831, 239.361961, 680.148407]),
            (0.7, 1.0 / 3.0, 0, [37.069069, 240.080716, 680.877002]),
            (0.7, 1.0 / 3.0, 5, [55.139592, 274.95408, 715.427242]),
        ];
        for (radius_ratio, poissons_ratio, n, expected) in table {
            let plate = AnnularPlate { radius_ratio, poissons_ratio };
            for (value, expected) in parameters(&plate, n).iter().zip(expected) {
                assert!((value - expected).abs() < 2e-6, "{plate:?}, n = {n}: {value} {expected}");
            }
        }
    }

    #[test]
    fn disc_frequencies_of_the_preset() {
        // Physics notes: 0.290, 1.894, 5.436 Hz of scaled time for the modes without nodal diameters.
        let brake = PadOnDisc::new(Parameters::sui_ding_2018()).unwrap();
        let hertz: Vec<f64> = brake
            .annular_plate()
            .modes(0, 3)
            .unwrap()
            .iter()
            .map(|m| brake.disc_frequency(m) / std::f64::consts::TAU)
            .collect();
        for (value, expected) in hertz.iter().zip([0.290, 1.894, 5.436]) {
            assert!((value - expected).abs() < 5e-4, "{value} {expected}");
        }
    }
}
