//! The probability itself, where the boundary of stability is known in closed form.
//!
//! With the boundary `f_crit(Delta) = f_c + C / Delta` the probability of instability of a cell is
//!
//! ```text
//! P = integral over z1 with Delta(z1) > 0 of   phi(z1) Q((f_crit(Delta(z1)) / f_s - 1) / sigma_f)   dz1,
//! Delta(z1) = Delta (1 + sigma_Delta z1)
//! ```
//!
//! with the normal density `phi` and upper tail `Q`; if only one input is random it is a single tail.

use stickslip_core::StabilityBoundary;

use crate::grid::Cell;
use crate::normal;

/// Deviates beyond this carry a probability below 1e-23.
const DEVIATE_LIMIT: f64 = 10.0;

/// Subdivision ends when the error estimate of a piece falls below this share of the whole.
const TOLERANCE: f64 = 1e-14;

/// Halvings of a piece at the most; 2^-60 of the range is below the spacing of the abscissae.
const DEEPEST: u32 = 60;

/// A probability with a bound of its numerical error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExactProbability {
    /// The probability of instability.
    pub value: f64,
    /// A bound of its error.
    pub error_bound: f64,
}

/// The probability that a sample of `cell` is unstable, by quadrature (an error of some 1e-14).
#[must_use]
pub fn probability(boundary: &StabilityBoundary, cell: &Cell) -> ExactProbability {
    let std = cell.relative_std;
    // Probability of f_s,sample > f_crit at a given preload; a sample without scatter is on one side or the other.
    let given_preload =
        |preload: f64| exceeds(cell.static_friction, std.static_friction, boundary.critical_static_friction(preload));
    if std.preload == 0.0 || cell.preload == 0.0 {
        return rounded(given_preload(cell.preload));
    }
    if std.static_friction == 0.0 || cell.static_friction == 0.0 {
        return rounded(exceeds(cell.preload, std.preload, boundary.critical_preload(cell.static_friction)));
    }
    let integrand = |z: f64| normal::density(z) * given_preload(cell.preload * (1.0 + std.preload * z));
    let from = (-1.0 / std.preload).max(-DEVIATE_LIMIT);
    if from >= DEVIATE_LIMIT {
        return rounded(0.0);
    }
    // Where the conditional probability passes through 1/2: steep if the friction scatters little.
    let middle = (boundary.critical_preload(cell.static_friction) / cell.preload - 1.0) / std.preload;
    let middle = if middle > from && middle < DEVIATE_LIMIT { middle } else { 0.5 * (from + DEVIATE_LIMIT) };
    let (left, left_error) = integrate(&integrand, from, middle, DEEPEST);
    let (right, right_error) = integrate(&integrand, middle, DEVIATE_LIMIT, DEEPEST);
    ExactProbability {
        value: (left + right).clamp(0.0, 1.0),
        error_bound: left_error + right_error + 4.0 * f64::EPSILON,
    }
}

fn rounded(value: f64) -> ExactProbability {
    ExactProbability { value, error_bound: if value == 0.0 || value == 1.0 { 0.0 } else { 4.0 * f64::EPSILON } }
}

/// Probability that `expected (1 + relative_std z)` exceeds `threshold`, `expected` >= 0.
fn exceeds(expected: f64, relative_std: f64, threshold: f64) -> f64 {
    let spread = expected * relative_std;
    if spread == 0.0 {
        return if expected > threshold { 1.0 } else { 0.0 };
    }
    normal::upper_tail((threshold - expected) / spread)
}

/// Adaptive quadrature: a piece is halved until the 7-point Gauss and the 15-point Kronrod rule agree. Returns the
/// integral and the sum of the error estimates.
fn integrate(f: &impl Fn(f64) -> f64, from: f64, to: f64, halvings_left: u32) -> (f64, f64) {
    let (kronrod, error) = gauss_kronrod(f, from, to);
    if error <= TOLERANCE || halvings_left == 0 {
        return (kronrod, error);
    }
    let middle = 0.5 * (from + to);
    let (left, left_error) = integrate(f, from, middle, halvings_left - 1);
    let (right, right_error) = integrate(f, middle, to, halvings_left - 1);
    (left + right, left_error + right_error)
}

/// Abscissae of the 15-point Kronrod rule on [-1, 1], the positive half from outside in; every second one belongs to
/// the 7-point Gauss rule (R. Piessens et al., QUADPACK, 1983).
const KRONROD_NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];
const KRONROD_WEIGHTS: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_56,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_82,
];
const GAUSS_WEIGHTS: [f64; 4] =
    [0.129_484_966_168_869_7, 0.279_705_391_489_276_64, 0.381_830_050_505_118_9, 0.417_959_183_673_469_4];

/// The integral by the Kronrod rule, and how far the Gauss rule is from it.
fn gauss_kronrod(f: &impl Fn(f64) -> f64, from: f64, to: f64) -> (f64, f64) {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    let (mut kronrod, mut gauss) = (0.0, 0.0);
    for (i, (&node, &weight)) in KRONROD_NODES.iter().zip(&KRONROD_WEIGHTS).enumerate() {
        let offset = half * node;
        let value = if node == 0.0 { f(centre) } else { f(centre - offset) + f(centre + offset) };
        kronrod += weight * value;
        if i % 2 == 1 {
            gauss += GAUSS_WEIGHTS[i / 2] * value;
        }
    }
    (half * kronrod, (half * (kronrod - gauss)).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::RelativeStd;
    use stickslip_core::{PadOnDisc, Parameters};

    fn boundary(speed: f64) -> StabilityBoundary {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.set("operating_point.rotating_speed", speed).unwrap();
        PadOnDisc::new(parameters).unwrap().stability_boundary()
    }

    fn cell(preload: f64, static_friction: f64, preload_std: f64, friction_std: f64) -> Cell {
        let relative_std = RelativeStd { preload: preload_std, static_friction: friction_std };
        Cell { index: 0, rotating_speed: 15.0, relative_std, preload, static_friction }
    }

    #[test]
    fn the_rules_integrate_polynomials_exactly() {
        for degree in 0..=22 {
            let (value, gauss_error) = gauss_kronrod(&|x: f64| x.powi(degree), -1.0, 1.0);
            let expected = if degree % 2 == 0 { 2.0 / f64::from(degree + 1) } else { 0.0 };
            assert!((value - expected).abs() < 1e-15, "Kronrod, degree {degree}: {value}");
            if degree <= 13 {
                assert!(gauss_error < 1e-15, "Gauss, degree {degree}: {gauss_error}");
            }
        }
    }

    /// The same probability by a rule that shares nothing with the module: the trapezoidal rule over both deviates,
    /// conditioned on friction instead of preload.
    fn by_trapezoid(boundary: &StabilityBoundary, cell: &Cell) -> f64 {
        let (points, limit) = (400_000, 9.0);
        let step = 2.0 * limit / f64::from(points);
        let mut sum = 0.0;
        for i in 0..=points {
            let z = -limit + step * f64::from(i);
            let friction = cell.static_friction * (1.0 + cell.relative_std.static_friction * z);
            let critical = boundary.critical_preload(friction);
            let deviate = (critical / cell.preload - 1.0) / cell.relative_std.preload;
            sum += (-0.5 * z * z).exp() / std::f64::consts::TAU.sqrt() * 0.5 * libm::erfc(deviate / 2f64.sqrt());
        }
        sum * step
    }

    #[test]
    fn quadrature_agrees_with_an_independent_rule() {
        let boundary = boundary(15.0);
        for (preload, friction, preload_std, friction_std) in [
            (0.1, 0.39, 0.2, 0.2),
            (0.3, 0.5, 0.2, 0.2),
            (0.01, 0.25, 0.2, 0.2),
            (0.05, 0.45, 0.3, 0.3),
            (0.2, 0.3, 0.1, 0.1),
            (0.1, 0.39, 0.5, 0.05),
            (0.1, 0.39, 0.02, 0.3),
        ] {
            let cell = cell(preload, friction, preload_std, friction_std);
            let exact = probability(&boundary, &cell);
            let other = by_trapezoid(&boundary, &cell);
            assert!((exact.value - other).abs() < 1e-10, "{cell:?}: {exact:?} {other}");
            assert!(exact.error_bound < 1e-12, "{exact:?}");
        }
    }

    #[test]
    fn one_random_input_is_a_single_tail() {
        let boundary = boundary(16.0);
        let f_crit = boundary.critical_static_friction(0.1);
        let exact = probability(&boundary, &cell(0.1, 0.389, 0.0, 0.2)).value;
        assert!((exact - normal::upper_tail((f_crit / 0.389 - 1.0) / 0.2)).abs() < 1e-15);
        let preload_crit = boundary.critical_preload(0.39);
        let exact = probability(&boundary, &cell(0.1, 0.39, 0.2, 0.0)).value;
        assert!((exact - normal::upper_tail((preload_crit / 0.1 - 1.0) / 0.2)).abs() < 1e-15);
    }

    #[test]
    fn without_scatter_the_probability_is_zero_or_one() {
        let boundary = boundary(16.0);
        assert_eq!(probability(&boundary, &cell(0.1, 0.41, 0.0, 0.0)).value, 1.0);
        assert_eq!(probability(&boundary, &cell(0.1, 0.39, 0.0, 0.0)).value, 0.0);
        assert_eq!(probability(&boundary, &cell(0.0, 0.39, 0.2, 0.2)).value, 0.0);
        assert_eq!(probability(&boundary, &cell(0.1, 0.0, 0.2, 0.2)).value, 0.0);
        assert_eq!(probability(&boundary, &cell(0.1, 0.25, 0.2, 0.0)).value, 0.0);
    }

    #[test]
    fn little_scatter_approaches_the_deterministic_verdict() {
        let boundary = boundary(16.0);
        for std in [1e-2, 1e-4, 1e-8, 1e-12] {
            let p = probability(&boundary, &cell(0.1, boundary.critical_static_friction(0.1), std, std));
            assert!((p.value - 0.5).abs() < 0.05, "{std}: {p:?}");
            assert_eq!(probability(&boundary, &cell(0.1, 0.5, std.min(1e-3), std.min(1e-3))).value, 1.0);
        }
    }

    #[test]
    fn undamped_brakes_are_unstable_wherever_friction_falls() {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.set("damping.tangential", 0.0).unwrap();
        let boundary = PadOnDisc::new(parameters).unwrap().stability_boundary();
        let p = probability(&boundary, &cell(0.1, 0.3, 0.5, 0.2)).value;
        let expected = normal::upper_tail(-2.0) * normal::upper_tail((0.25 / 0.3 - 1.0) / 0.2);
        assert!((p - expected).abs() < 1e-12, "{p} {expected}");
    }
}
