//! The chi-squared distribution: of the sum of squares of independent standard normal deviates.

use std::f64::consts::FRAC_2_SQRT_PI;

use crate::special_functions::normal;

/// The probability that so many deviates have a larger sum of squares: `Q(n/2, x/2)`, by the recursion over `n`, in which all
/// terms are positive (Abramowitz and Stegun, 26.4.8). Above some 1490 the exponential of half the sum is 0, and so
/// is the tail.
#[must_use]
pub(crate) fn upper_tail(square: f64, deviates: usize) -> f64 {
    let half = 0.5 * square;
    let density = libm::exp(-half);
    // term = half^(added / 2) exp(-half) / Gamma(added / 2 + 1)
    let (mut sum, mut term, mut added) = if deviates.is_multiple_of(2) {
        (density, density * half, 2)
    } else {
        (2.0 * normal::upper_tail(square.sqrt()), density * half.sqrt() * FRAC_2_SQRT_PI, 1)
    };
    while added < deviates {
        sum += term;
        term *= half / (0.5 * added as f64 + 1.0);
        added += 2;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_are_those_of_scipy() {
        // SciPy 1.17: chi2.sf(square, deviates).
        for (square, deviates, expected) in [
            (4.0, 1, 0.045_500_263_896_358_38),
            (4.0, 2, 0.135_335_283_236_612_7),
            (4.0, 3, 0.261_464_129_949_110_6),
            (30.0, 4, 4.894_437_128_029_217e-6),
            (60.0, 9, 1.340_678_048_395_962_5e-9),
            (100.0, 31, 3.464_370_244_941_618_7e-9),
        ] {
            let found = upper_tail(square, deviates);
            assert!((found / expected - 1.0).abs() < 1e-12, "{square} {deviates}: {found:e}");
        }
        // SciPy 1.14: chi2.isf(tail, deviates).
        for (square, deviates, tail) in [
            (3.841_458_82, 1, 0.05),
            (5.991_464_55, 2, 0.05),
            (9.487_729_04, 4, 0.05),
            (11.070_497_69, 5, 0.05),
            (23.209_251_16, 10, 0.01),
        ] {
            assert!((upper_tail(square, deviates) - tail).abs() < 1e-9, "{square} {deviates}");
        }
        assert!([1, 2, 5].iter().all(|deviates| (upper_tail(0.0, *deviates) - 1.0).abs() < 1e-15));
    }
}
