//! Natural frequencies of the disc: a thin annular plate, clamped at the inner and free at the outer radius.
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

use crate::eigenvalues::EigenvalueError;
use crate::pad_on_disc::PadOnDisc;

/// Radial functions of the expansion. Sixteen give the first four frequencies of each nodal diameter to ten digits.
const RADIAL_FUNCTIONS: usize = 16;

/// Points of the Gauss-Legendre rule, exact for the polynomial part of the integrands and far beyond it.
const QUADRATURE_POINTS: usize = 48;

/// A clamped-free annular plate, by its two ratios.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AnnularPlate {
    /// a / b, between 0 and 1.
    pub radius_ratio: f64,
    /// nu.
    pub poissons_ratio: f64,
}

impl AnnularPlate {
    /// The first `count` frequency parameters `lambda^2 = omega b^2 sqrt(rho h / D)` of modes with
    /// `nodal_diameters` nodal diameters, rising.
    ///
    /// # Errors
    /// [`EigenvalueError`] if the matrices degenerate, as they do when the annulus is almost closed.
    ///
    /// # Panics
    /// If more than eight are asked for: the expansion does not resolve them.
    pub fn frequency_parameters(&self, nodal_diameters: u32, count: usize) -> Result<Vec<f64>, EigenvalueError> {
        assert!(count <= RADIAL_FUNCTIONS / 2, "at most {} radial modes are resolved", RADIAL_FUNCTIONS / 2);
        let (stiffness, mass) = self.energies(f64::from(nodal_diameters));
        let not_finite = EigenvalueError::NotFinite { row: 0, column: 0 };
        let cholesky = Cholesky::new(mass).ok_or(not_finite)?;
        let lower = cholesky.l();
        // L^-1 K L^-T, symmetric by construction but for rounding.
        let half = lower.solve_lower_triangular(&stiffness).unwrap_or(stiffness);
        let reduced = lower.solve_lower_triangular(&half.transpose()).unwrap_or(half);
        let symmetric = (&reduced + reduced.transpose()) * 0.5;
        let sweeps = 1000 * RADIAL_FUNCTIONS;
        let eigen =
            SymmetricEigen::try_new(symmetric, f64::EPSILON, sweeps).ok_or(EigenvalueError::NotConverged { sweeps })?;
        let mut parameters: Vec<f64> = eigen.eigenvalues.iter().map(|value| value.max(0.0).sqrt()).collect();
        parameters.sort_by(f64::total_cmp);
        parameters.truncate(count);
        Ok(parameters)
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

/// Legendre polynomial with its first two derivatives, |x| <= 1, by the three-term recurrence.
fn legendre(degree: usize, x: f64) -> (f64, f64, f64) {
    let (mut p, mut dp, mut ddp) = (1.0, 0.0, 0.0);
    let (mut p_before, mut dp_before, mut ddp_before) = (0.0, 0.0, 0.0);
    for k in 1..=degree {
        let (a, b) = ((2 * k - 1) as f64 / k as f64, (k - 1) as f64 / k as f64);
        let next =
            (a * x * p - b * p_before, a * (p + x * dp) - b * dp_before, a * (2.0 * dp + x * ddp) - b * ddp_before);
        (p_before, dp_before, ddp_before) = (p, dp, ddp);
        (p, dp, ddp) = next;
    }
    (p, dp, ddp)
}

/// Nodes and weights of the Gauss-Legendre rule on [-1, 1], by Newton's iteration from Tricomi's estimate.
fn gauss_legendre(points: usize) -> Vec<(f64, f64)> {
    let rule = |i: usize| {
        let angle = std::f64::consts::PI * (i as f64 + 0.75) / (points as f64 + 0.5);
        let mut x = libm::cos(angle);
        for _ in 0..20 {
            let (p, dp, _) = legendre(points, x);
            let step = p / dp;
            x -= step;
            if step.abs() < 1e-16 {
                break;
            }
        }
        let (_, dp, _) = legendre(points, x);
        (x, 2.0 / ((1.0 - x * x) * dp * dp))
    };
    (0..points).map(rule).collect()
}

impl PadOnDisc {
    /// The disc as an annular plate.
    #[must_use]
    pub fn annular_plate(&self) -> AnnularPlate {
        let disc = &self.parameters().disc;
        AnnularPlate { radius_ratio: disc.inner_radius / disc.outer_radius, poissons_ratio: disc.poissons_ratio }
    }

    /// The first `count` natural angular frequencies of the disc with `nodal_diameters` nodal diameters, per unit of
    /// scaled time: `lambda^2 h^(3/2) / b^2` (see the notation for the stray root of a length).
    ///
    /// # Errors
    /// As [`AnnularPlate::frequency_parameters`].
    pub fn disc_frequencies(&self, nodal_diameters: u32, count: usize) -> Result<Vec<f64>, EigenvalueError> {
        let disc = &self.parameters().disc;
        let rigidity_over_density = self.scales().flexural_rigidity / (disc.density * disc.thickness);
        let per_parameter = rigidity_over_density.sqrt() * self.scales().time / (disc.outer_radius * disc.outer_radius);
        let parameters = self.annular_plate().frequency_parameters(nodal_diameters, count)?;
        Ok(parameters.into_iter().map(|parameter| parameter * per_parameter).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::Parameters;

    #[test]
    fn frequencies_agree_with_the_bessel_determinant() {
        // lambda^2 for a/b = 0.064/0.135, nu = 0.3, clamped-free, from the zeros of the determinant of Bessel
        // functions (computed independently of this crate).
        let table = [
            [11.7565, 76.6917, 220.0855],
            [11.9802, 78.4021, 221.8871],
            [13.3679, 83.5585, 227.3205],
            [17.3691, 92.2270, 236.4629],
            [24.6646, 104.4948, 249.4168],
        ];
        let plate = AnnularPlate { radius_ratio: 0.064 / 0.135, poissons_ratio: 0.3 };
        for (n, row) in table.iter().enumerate() {
            let computed = plate.frequency_parameters(n as u32, 3).unwrap();
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
            for (value, expected) in plate.frequency_parameters(n, 3).unwrap().iter().zip(expected) {
                assert!((value - expected).abs() < 2e-6, "{plate:?}, n = {n}: {value} {expected}");
            }
        }
    }

    #[test]
    fn disc_frequencies_of_the_preset() {
        // Physics notes: 0.290, 1.894, 5.436 Hz of scaled time for the modes without nodal diameters.
        let brake = PadOnDisc::new(Parameters::sui_ding_2018()).unwrap();
        let hertz: Vec<f64> =
            brake.disc_frequencies(0, 3).unwrap().iter().map(|omega| omega / std::f64::consts::TAU).collect();
        for (value, expected) in hertz.iter().zip([0.290, 1.894, 5.436]) {
            assert!((value - expected).abs() < 5e-4, "{value} {expected}");
        }
    }
}
