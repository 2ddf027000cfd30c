//! Problems of two coordinates: their eigenvalues as the roots of the characteristic polynomial.
//!
//! ```text
//! det(lambda^2 + lambda C + K) = lambda^4 + a3 lambda^3 + a2 lambda^2 + a1 lambda + a0
//! a3 = tr C,  a2 = tr K + det C,  a1 = c11 k22 + c22 k11 - c12 k21 - c21 k12,  a0 = det K
//! ```
//!
//! The roots without damping, from the quadratic equation for `lambda^2`, are made exact by the method of Weierstrass, whose
//! corrections W also bound the error: the discs of radius `4 |W|` hold all roots, and one that meets no other holds one
//! (B. T. Smith, J. ACM 17 (1970) 661).

use nalgebra::Complex;

use super::quadratic::DenseQuadratic;
use super::region::{magnitude, square_root};
use crate::numerics::eigenvalues::Eigenvalue;

/// Corrections after which the iteration is given up: next to multiple roots, and with strong damping.
const MOST_STEPS: usize = 12;

/// Corrections at which roots are taken, in parts of the largest.
const CONVERGED: f64 = 1e-13;

/// The rounding of the polynomial, in parts of the sum of its terms without their signs.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// The four eigenvalues of a problem of two coordinates, each with its radius; `None` where they are not told so.
pub(super) fn eigenvalues(problem: &DenseQuadratic, coefficients: &[f64]) -> Option<[(Eigenvalue, f64); 4]> {
    if problem.size() != 2 {
        return None;
    }
    let [c, k] = problem.entries_of_two(coefficients);
    let absolute = |entries: [f64; 4]| entries.map(f64::abs);
    // Of entries in the order 11, 21, 12, 22; `sign` is that of products across.
    let polynomial = |c: [f64; 4], k: [f64; 4], sign: f64| {
        let determinant = |m: [f64; 4]| m[0] * m[3] + sign * m[1] * m[2];
        let mixed = c[0] * k[3] + c[3] * k[0] + sign * (c[2] * k[1] + c[1] * k[2]);
        [determinant(k), mixed, k[0] + k[3] + determinant(c), c[0] + c[3]]
    };
    let a = polynomial(c, k, -1.0);
    let sizes = polynomial(absolute(c), absolute(k), 1.0);
    let half = Complex::from(-0.5 * a[2]);
    let root = square_root(half * half - a[0]);
    let starts = [half + root, half - root].map(square_root);
    let mut roots = [starts[0], -starts[0], starts[1], -starts[1]];
    for _ in 0..MOST_STEPS {
        let largest = roots.iter().map(|root| magnitude(*root)).fold(0.0, f64::max);
        let corrections: [(Complex<f64>, f64); 4] = std::array::from_fn(|i| {
            let z = roots[i];
            let value = (((z + a[3]) * z + a[2]) * z + a[1]) * z + a[0];
            let size = magnitude(z);
            let rounding = ((((size + sizes[3]) * size + sizes[2]) * size + sizes[1]) * size + sizes[0]) * ROUNDING;
            let others = (0..4).filter(|j| *j != i);
            let product = others.fold(Complex::from(1.0), |product, j| product * (z - roots[j]));
            (value / product, rounding / magnitude(product))
        });
        if !corrections.iter().all(|(correction, rounding)| correction.re.is_finite() && rounding.is_finite()) {
            return None;
        }
        if corrections.iter().all(|(correction, rounding)| magnitude(*correction) <= CONVERGED * largest + rounding) {
            let discs: [(Eigenvalue, f64); 4] = std::array::from_fn(|i| {
                let (correction, rounding) = corrections[i];
                (roots[i], 4.0 * (magnitude(correction) + rounding))
            });
            let meet = |i: usize, j: usize| magnitude(discs[i].0 - discs[j].0) <= discs[i].1 + discs[j].1;
            return (0..4).all(|i| (0..i).all(|j| !meet(i, j))).then_some(discs);
        }
        roots.iter_mut().zip(corrections).for_each(|(root, (correction, _))| *root -= correction);
    }
    None
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, dmatrix};

    use super::*;
    use crate::models::matrices::trial::{Numbers, problem};

    #[test]
    fn discs_hold_the_eigenvalues() {
        let mut told = 0;
        for seed in (0..4000).map(|i| 8 * i + 1) {
            let (problem, mut coefficients, _) = problem(seed);
            let mut numbers = Numbers(seed);
            coefficients.iter_mut().for_each(|value| *value *= 1.0 + numbers.next());
            let Some(found) = eigenvalues(&problem, &coefficients) else { continue };
            told += 1;
            let exact = problem.at(&coefficients).eigenvalues().unwrap();
            for (value, radius) in found {
                // Of QR, whose own rounding is larger near double roots.
                let inside = exact.iter().filter(|exact| magnitude(value - *exact) <= radius + 1e-7).count();
                assert!(inside == 1 || radius > 1e-9, "problem {seed}: {inside} of {exact:?} in {found:?}");
            }
        }
        assert!(told > 3000, "{told}");
    }

    /// Two close modes without damping in turned coordinates, whose eigenvalues are known: the rounding of the entries grows with
    /// their nearness, and the discs do.
    #[test]
    fn discs_grow_with_the_rounding_of_close_modes() {
        let mut told = 0;
        for (exponent, degrees) in (1..8).flat_map(|exponent| (1..90).map(move |degrees| (exponent, degrees))) {
            let gap = libm::pow(10.0, -f64::from(exponent));
            let (sine, cosine) = libm::sincos(f64::from(degrees).to_radians());
            let stiffness = [
                dmatrix![1.0 + gap * sine * sine, gap * sine * cosine; gap * sine * cosine, 1.0 + gap * cosine * cosine],
            ];
            let problem = DenseQuadratic::new(&DMatrix::identity(2, 2), &[], &stiffness, &[1.0]).unwrap();
            let Some(found) = eigenvalues(&problem, &[1.0]) else { continue };
            told += 1;
            for (value, radius) in found {
                let off =
                    [1.0, (1.0 + gap).sqrt()].map(|exact| magnitude(value - Complex::new(0.0, exact / problem.unit())));
                let off = off.map(|off| if value.im > 0.0 { off } else { 0.0 });
                assert!(off[0].min(off[1]) <= radius, "{gap} {degrees}: {off:?} {radius}");
            }
        }
        assert!(told > 300, "{told}");
    }
}
