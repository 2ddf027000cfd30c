//! Eigenpairs with their left and right vectors.

use nalgebra::Complex as NalgebraComplex;

use super::region::{damping_ratio, magnitude};

/// A complex number: eigenvalues, whose real part is a growth rate and whose imaginary part is an angular frequency.
pub type Complex = NalgebraComplex<f64>;

/// An eigenpair: `Q(lambda) x = 0`, `y^T Q(lambda) = 0` (transposed, not conjugated).
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// lambda: growth rate in 1/s, angular frequency in rad/s, or both in the unit of the problem.
    pub eigenvalue: Complex,
    /// x, of length 1.
    pub right: Vec<Complex>,
    /// y, scaled so that `y^T Q'(lambda) x = 1`.
    pub left: Vec<Complex>,
    /// An estimate of the distance of the eigenvalue from the exact one of the matrices as summed.
    pub error: f64,
}

impl Pair {
    /// The damping ratio `-Re lambda / |lambda|`: negative where the motion grows.
    #[must_use]
    pub fn damping_ratio(&self) -> f64 {
        damping_ratio(self.eigenvalue)
    }

    /// The error of the damping ratio that the error of the eigenvalue makes.
    #[must_use]
    pub fn damping_ratio_error(&self) -> f64 {
        self.error / magnitude(self.eigenvalue)
    }
}

/// The derivative of the damping ratio, from that of the eigenvalue.
#[must_use]
pub fn damping_ratio_slope(eigenvalue: Complex, slope: Complex) -> f64 {
    // d(-a/r) with r^2 = a^2 + b^2.
    let size = magnitude(eigenvalue);
    (eigenvalue.im / size) * (eigenvalue.re * slope.im - eigenvalue.im * slope.re) / (size * size)
}

/// The root of `a lambda^2 + b lambda + c` near a guess by Newton's method, and the slope there. With a, b, c the matrices
/// of a problem between a left and a right vector, its error is a product of the errors of both.
pub(super) fn root_near(guess: Complex, [a, b, c]: [Complex; 3]) -> Option<(Complex, Complex)> {
    let slope = |value: Complex| a * value * 2.0 + b;
    let mut value = guess;
    for _ in 0..50 {
        let change = ((a * value + b) * value + c) / slope(value);
        if !(change.re.is_finite() && change.im.is_finite()) {
            return None;
        }
        value -= change;
        if magnitude(change) <= 2.0 * f64::EPSILON * magnitude(value) {
            break;
        }
    }
    Some((value, slope(value)))
}

/// `a^T b`, not conjugated.
pub(super) fn dot(a: &[Complex], b: &[Complex]) -> Complex {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The length of a vector.
pub(super) fn norm(vector: &[Complex]) -> f64 {
    vector.iter().map(Complex::norm_sqr).sum::<f64>().sqrt()
}

/// Scales to length 1.
pub(super) fn normalise(vector: &mut [Complex]) {
    let length = norm(vector);
    if length > 0.0 {
        vector.iter_mut().for_each(|value| *value = value.unscale(length));
    }
}
