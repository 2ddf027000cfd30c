//! The probability of instability as a polynomial in the logarithms of the standard deviations, with a bound on the rest.
//!
//! For normal, independent inputs let `sigma_1` and `sigma_2` be the logarithms of the relative standard deviations of
//! the first and the second. With the deviates `z` and the normal density `phi`
//!
//! ```text
//! d^(i+j) P / d sigma_1^i d sigma_2^j = integral over the unstable region of  p_i(z1) phi(z1) p_j(z2) phi(z2)  dz1 dz2,
//! p_0 = 1,   p_(k+1) = (z^2 - 1) p_k - z p_k'
//! ```
//!
//! Over a tail `z >= t`, `p_k phi` has the integral `T_k(t) phi(t)` with `T_1 = t`, `T_(k+1) = t^2 T_k - t T_k'`. So one
//! quadrature gives all derivatives. Given one input, the unstable values of the other are a tail, therefore no
//! derivative exceeds
//!
//! ```text
//! max |T_i phi|  E|p_j|,   nor  max |T_j phi|  E|p_i|
//! ```
//!
//! at any expected values and standard deviations. These numbers bound the remainder of Taylor's polynomial on a box.

use stickslip_core::model::pair_boundary::PairBoundary;

use crate::integrate::NormalPair;
use crate::integrate::closed_form::{self, first_at, over_first};
use crate::special_functions::normal;

/// Degree of the polynomials.
pub const DEGREE: usize = 8;

/// Number of coefficients in one direction.
pub const TERMS: usize = DEGREE + 1;

/// Tolerance of each interval of the quadrature of a coefficient.
const TOLERANCE: f64 = 1e-12;

/// Bound on the error of the value of a polynomial by quadrature and rounding.
pub const ROUNDING: f64 = 1e-9;

/// Upper bounds of `|T_k(t)| phi(t)` over all `t`, from `k = 1`.
pub(super) const MOST_OF_TAIL: [f64; TERMS] =
    [0.241_971, 0.325_813, 0.703_168, 3.131_56, 16.737_8, 100.288, 764.035, 7226.62, 72_363.7];

/// Upper bounds of the mean of `|p_k|`, from `k = 0`.
pub(super) const MEAN: [f64; TERMS + 1] =
    [1.0, 0.967_883, 1.832_13, 5.698_21, 25.009_8, 141.91, 987.329, 8133.63, 77_406.0, 835_553.0];

/// The polynomials `p_k(z) / k!`: coefficients of the powers of `z^2`.
pub(super) const DENSITIES: [[f64; TERMS]; TERMS] = densities();

/// The polynomials `T_k(t) / (k! t)`, from `k = 1`, likewise.
pub(super) const TAILS: [[f64; TERMS]; DEGREE] = tails();

const fn densities() -> [[f64; TERMS]; TERMS] {
    let mut all = [[0.0; TERMS]; TERMS];
    all[0][0] = 1.0;
    let mut k = 0;
    while k + 1 < TERMS {
        let mut power = 0;
        while power <= k {
            // z^2 z^(2n), less (1 + 2n) z^(2n).
            let share = all[k][power] / (k + 1) as f64;
            all[k + 1][power + 1] += share;
            all[k + 1][power] -= (1 + 2 * power) as f64 * share;
            power += 1;
        }
        k += 1;
    }
    all
}

const fn tails() -> [[f64; TERMS]; DEGREE] {
    let mut all = [[0.0; TERMS]; DEGREE];
    all[0][0] = 1.0;
    let mut k = 0;
    while k + 1 < DEGREE {
        let mut power = 0;
        while power <= k {
            // t^2 t^(2n+1), less (2n + 1) t^(2n+1).
            let share = all[k][power] / (k + 2) as f64;
            all[k + 1][power + 1] += share;
            all[k + 1][power] -= (2 * power + 1) as f64 * share;
            power += 1;
        }
        k += 1;
    }
    all
}

/// Coefficients of a polynomial: `[i][j]` of the power `i` of the first and `j` of the second variable.
pub type Coefficients = [[f64; TERMS]; TERMS];

/// Number of coefficients up to the degree.
const ALL: usize = TERMS * (TERMS + 1) / 2;

/// Taylor's polynomial of the probability, in the deviations of `sigma_1` and `sigma_2` from those of the inputs.
pub fn expansion(boundary: &PairBoundary, inputs: &NormalPair) -> Coefficients {
    let expected = inputs.expected;
    let mut coefficients = [[0.0; TERMS]; TERMS];
    match inputs.scatter() {
        [true, true] => {}
        [true, false] => {
            let critical = boundary.critical_first(expected[1]);
            let derivatives = tail_derivatives((critical - expected[0]) / inputs.spread(0));
            coefficients.iter_mut().zip(derivatives).for_each(|(row, derivative)| row[0] = derivative);
            return coefficients;
        }
        [false, true] => {
            coefficients[0] = share_derivatives(boundary, inputs, expected[0]);
            return coefficients;
        }
        [false, false] => {
            coefficients[0][0] = closed_form::probability(boundary, inputs).value;
            return coefficients;
        }
    }
    let integrand = |z: f64| {
        let of_second = share_derivatives(boundary, inputs, first_at(inputs, z));
        let density = normal::density(z);
        let mut moments = [0.0; ALL];
        let mut next = moments.iter_mut();
        for (i, polynomial) in DENSITIES.iter().enumerate() {
            let of_first = density * even_polynomial(polynomial, z * z);
            for (j, moment) in (0..TERMS - i).zip(&mut next) {
                *moment = of_first * of_second[j];
            }
        }
        moments
    };
    let (moments, _) = over_first(boundary, inputs, &integrand, TOLERANCE);
    let mut moments = moments.into_iter();
    for (i, row) in coefficients.iter_mut().enumerate() {
        row.iter_mut().take(TERMS - i).zip(&mut moments).for_each(|(place, moment)| *place = moment);
    }
    coefficients
}

/// The derivatives over their factorials of the share of unstable second inputs at a value of the first.
fn share_derivatives(boundary: &PairBoundary, inputs: &NormalPair, first: f64) -> [f64; TERMS] {
    let (expected, spread) = (inputs.expected[1], inputs.spread(1));
    let (above, below) = boundary.unstable_second(first);
    let [above, below] = [above, below].map(|limit| tail_derivatives((limit - expected) / spread));
    std::array::from_fn(|j| above[j] - below[j])
}

/// The derivatives over their factorials of the probability of a tail by the logarithm of the standard deviation.
pub(super) fn tail_derivatives(t: f64) -> [f64; TERMS] {
    // Beyond, all of them are below 1e-300.
    let t = t.clamp(-40.0, 40.0);
    let density = normal::density(t);
    let mut derivatives = [0.0; TERMS];
    derivatives[0] = normal::upper_tail(t);
    for (derivative, tail) in derivatives[1..].iter_mut().zip(&TAILS) {
        *derivative = density * t * even_polynomial(tail, t * t);
    }
    derivatives
}

fn even_polynomial(coefficients: &[f64; TERMS], square: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, coefficient| sum * square + coefficient)
}

/// A bound on the difference of the derivative of order `by` from that of the polynomial, on a box of these half widths.
///
/// `is_single` says that the unstable second inputs at a value of the first are a tail, and not between two ends.
pub fn remainder(half_widths: [f64; 2], by: [usize; 2], is_single: bool) -> f64 {
    let order = TERMS - by[0] - by[1];
    let mut sum = ROUNDING;
    for i in 0..=order {
        let j = order - i;
        let derivative = [i + by[0], j + by[1]];
        let by_first = bound(derivative);
        let by_second = if is_single {
            bound([derivative[1], derivative[0]])
        } else if derivative[0] == 0 {
            2.0 * bound([derivative[1], 0])
        } else {
            f64::INFINITY
        };
        sum +=
            by_first.min(by_second) * power_over_factorial(half_widths[0], i) * power_over_factorial(half_widths[1], j);
    }
    sum
}

/// The bound of a derivative with the tail of the first input; infinite if there is no such derivative.
fn bound([of_tail, of_density]: [usize; 2]) -> f64 {
    if of_tail == 0 { f64::INFINITY } else { MOST_OF_TAIL[of_tail - 1] * MEAN[of_density] }
}

fn power_over_factorial(x: f64, n: usize) -> f64 {
    (1..=n).fold(1.0, |product, k| product * x / k as f64)
}

#[cfg(test)]
mod tests;
