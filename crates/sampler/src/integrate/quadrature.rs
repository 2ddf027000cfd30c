//! Adaptive Gauss-Kronrod quadrature.

/// The integrals of several functions from the first to the last of the ascending `ends`, each interval by itself, and
/// the sums of the error estimates.
///
/// An interval is halved until the error estimates of all functions are at most `tolerance`, but no more than
/// `halvings` times.
pub(crate) fn integrate_intervals<const N: usize>(
    f: &impl Fn(f64) -> [f64; N],
    ends: &[f64],
    tolerance: f64,
    halvings: u32,
) -> ([f64; N], [f64; N]) {
    let mut sum = ([0.0; N], [0.0; N]);
    for pair in ends.windows(2).filter(|pair| pair[0] < pair[1]) {
        add(&mut sum, &integrate(f, pair[0], pair[1], tolerance, halvings));
    }
    sum
}

/// The integrals over one interval, halved until the 7-point Gauss and the 15-point Kronrod rule agree for every
/// function.
fn integrate<const N: usize>(
    f: &impl Fn(f64) -> [f64; N],
    from: f64,
    to: f64,
    tolerance: f64,
    halvings_left: u32,
) -> ([f64; N], [f64; N]) {
    let (kronrod, error) = gauss_kronrod(f, from, to);
    if error.iter().all(|&error| error <= tolerance) || halvings_left == 0 {
        return (kronrod, error);
    }
    let middle = 0.5 * (from + to);
    let mut sum = integrate(f, from, middle, tolerance, halvings_left - 1);
    add(&mut sum, &integrate(f, middle, to, tolerance, halvings_left - 1));
    sum
}

/// Adds the integrals and errors of an interval.
fn add<const N: usize>(sum: &mut ([f64; N], [f64; N]), interval: &([f64; N], [f64; N])) {
    for i in 0..N {
        sum.0[i] += interval.0[i];
        sum.1[i] += interval.1[i];
    }
}

/// Abscissae of the 15-point Kronrod rule on [-1, 1], the non-negative half from outside in; every second one belongs
/// to the 7-point Gauss rule (R. Piessens et al., QUADPACK, 1983).
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

/// The integrals by the Kronrod rule, and the differences from those by the Gauss rule.
pub(crate) fn gauss_kronrod<const N: usize>(f: &impl Fn(f64) -> [f64; N], from: f64, to: f64) -> ([f64; N], [f64; N]) {
    let (centre, half) = (0.5 * (from + to), 0.5 * (to - from));
    let (mut kronrod, mut gauss) = ([0.0; N], [0.0; N]);
    for (i, (&node, &weight)) in KRONROD_NODES.iter().zip(&KRONROD_WEIGHTS).enumerate() {
        let offset = half * node;
        let mut value = f(centre - offset);
        if node != 0.0 {
            let other = f(centre + offset);
            (0..N).for_each(|k| value[k] += other[k]);
        }
        (0..N).for_each(|k| kronrod[k] += weight * value[k]);
        if i % 2 == 1 {
            (0..N).for_each(|k| gauss[k] += GAUSS_WEIGHTS[i / 2] * value[k]);
        }
    }
    (kronrod.map(|sum| half * sum), std::array::from_fn(|k| (half * (kronrod[k] - gauss[k])).abs()))
}

/// Whole steps from zero at which [`over_the_line`] looks first.
const FARTHEST_STEP: i32 = 20;

/// Values below this share of the greatest are left out.
const NEGLIGIBLE: f64 = 1e-18;

/// Most halvings of the step.
const MOST_HALVINGS: u32 = 5;

/// The integral over the whole line of a function without kinks that falls off like a normal density, by the trapezoid
/// rule: its error falls faster than any power of the step, at least squared with each halving where the function is
/// analytic (L. N. Trefethen, J. A. C. Weideman, SIAM Review 56, 385, 2014).
///
/// The step is halved, from 1, until two results agree to the square root of the `tolerance`, relative, and a hundredth
/// of that for safety. `None` if they never do, or if the function is zero at all whole numbers.
pub(crate) fn over_the_line(f: &impl Fn(f64) -> f64, tolerance: f64) -> Option<f64> {
    let values: Vec<f64> = (-FARTHEST_STEP..=FARTHEST_STEP).map(|step| f(f64::from(step))).collect();
    let least = NEGLIGIBLE * values.iter().copied().fold(0.0, f64::max);
    let matters = |value: &f64| *value > least;
    let first = values.iter().position(matters)?.saturating_sub(1);
    let last = (values.iter().rposition(matters)? + 1).min(values.len() - 1);
    let from = first as f64 - f64::from(FARTHEST_STEP);
    let (mut sum, mut step, mut intervals) = (values[first..=last].iter().sum::<f64>(), 1.0, last - first);
    for _ in 0..MOST_HALVINGS {
        let middles: f64 = (0..intervals).map(|i| f(from + (i as f64 + 0.5) * step)).sum();
        let coarse = step * sum;
        (sum, step, intervals) = (sum + middles, 0.5 * step, 2 * intervals);
        let fine = step * sum;
        if (fine - coarse).abs() <= 0.01 * tolerance.sqrt() * fine {
            return Some(fine);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_trapezoid_rule_integrates_normal_densities_anywhere() {
        for (centre, std) in [(0.0, 1.0), (0.3, 0.7), (-7.7, 0.3), (5.0, 2.0)] {
            let density = |x: f64| (-0.5 * ((x - centre) / std).powi(2)).exp();
            let found = over_the_line(&density, 1e-10).unwrap() / (std * std::f64::consts::TAU.sqrt());
            assert!((found - 1.0).abs() < 1e-13, "{centre} {std}: {found}");
        }
        // Too narrow, a jump, and nothing.
        assert_eq!(over_the_line(&|x: f64| (-0.5 * ((x - 0.4) / 0.005).powi(2)).exp(), 1e-10), None);
        assert_eq!(over_the_line(&|x: f64| if x > 0.3 { (-x * x).exp() } else { 0.0 }, 1e-10), None);
        assert_eq!(over_the_line(&|_| 0.0, 1e-10), None);
    }

    #[test]
    fn the_rules_integrate_polynomials_exactly() {
        for degree in 0..=22 {
            let ([value], [gauss_error]) = gauss_kronrod(&|x: f64| [x.powi(degree)], -1.0, 1.0);
            let expected = if degree % 2 == 0 { 2.0 / f64::from(degree + 1) } else { 0.0 };
            assert!((value - expected).abs() < 1e-15, "Kronrod, degree {degree}: {value}");
            if degree <= 13 {
                assert!(gauss_error < 1e-15, "Gauss, degree {degree}: {gauss_error}");
            }
        }
    }

    #[test]
    fn all_functions_are_as_accurate_as_is_asked_and_errors_add_up() {
        let f = |x: f64| [1.0, x.sqrt(), (x - 0.3).abs()];
        let ([one, root, kink], errors) = integrate_intervals(&f, &[0.0, 0.5, 1.0], 1e-10, 40);
        let exact = [1.0, 2.0 / 3.0, 0.5 * (0.09 + 0.49)];
        for ((found, exact), error) in [one, root, kink].into_iter().zip(exact).zip(errors) {
            assert!((found - exact).abs() < 1e-8, "{found} {exact}");
            assert!((found - exact).abs() <= error + 1e-15, "{found} {exact} {error}");
        }
        // Without halving the error is that of the rules, in every interval.
        let rough = |ends: &[f64]| integrate_intervals(&f, ends, 0.0, 0).1;
        let (whole, [first, second]) = (rough(&[0.0, 0.5, 1.0]), [rough(&[0.0, 0.5]), rough(&[0.5, 1.0])]);
        assert!(first[1] > 1e-6 && second[1] > 0.0 && whole[1] == first[1] + second[1], "{whole:?} {first:?}");
    }
}
