//! The beta distribution and what follows from it: exact binomial limits and Student's t.
//!
//! With `x + y = 1` the regularised incomplete beta function is
//!
//! ```text
//! I_x(a, b) = 1 / B(a, b) * integral from 0 to x of t^(a-1) (1-t)^(b-1) dt
//! ```
//!
//! It is the probability that a binomial variable of `a + b - 1` trials at probability `x` is at least `a`. For counts
//! up to 1e10 the usual ways fail: logarithms of the gamma function cancel to few digits, and continued fractions need
//! some `sqrt(n)` terms. Here
//!
//! * the power `x^a y^b / B(a, b)` is taken as a deviation from its maximum times ratios of Stirling errors, in which
//!   nothing cancels (C. Loader, Fast and accurate computation of binomial probabilities, 2000);
//! * if `a` or `b` is below 1000, a continued fraction follows (A. R. DiDonato and A. H. Morris, algorithm 708, ACM
//!   Trans. Math. Softw. 18, 1992, equation 9), on the side of the mean where it converges quickly;
//! * else a Gauss-Legendre rule of 32 points integrates the density relative to its value at `x`, over the stretch
//!   beyond `x` where that is above 1e-16 or so: smooth and falling, whatever `a` and `b`.
//!
//! Both tails are accurate relative to themselves, to some 1e-13 where `x` is given exactly; what the spacing of `x`
//! makes of it is the density times that spacing, some 1e-10 for `a` and `b` of 1e10. The quantiles are accurate to
//! some 1e-15 relative to `x` and to `1 - x`.

use std::f64::consts::TAU;

use crate::special_functions::normal;

/// From here on, in both parameters, the density is narrow enough for quadrature.
const LARGE: f64 = 1000.0;

/// The quadrature leaves out what is below the exponential of minus this, relative to the density at `x`.
const DEPTH: f64 = 45.0;

/// A point of [0, 1] with its complement, so that neither end loses digits.
#[derive(Clone, Copy)]
struct Point {
    x: f64,
    y: f64,
}

impl Point {
    /// The point with `x / y = odds`.
    fn from_odds(odds: f64) -> Self {
        // 1 / (1 + 1 / odds) and not odds / (1 + odds): right for infinite odds too.
        Self { x: 1.0 / (1.0 + 1.0 / odds), y: 1.0 / (1.0 + odds) }
    }

    fn mirrored(self) -> Self {
        Self { x: self.y, y: self.x }
    }
}

/// `I_x(a, b)`: probability that a beta variable is at most `x`, for `a`, `b` from 0.01 to 1e10 and `x` in [0, 1].
///
/// ```
/// // At least 2 heads of 3: 3 p^2 (1 - p) + p^3.
/// let p = stickslip_sampler::special_functions::beta::lower_tail(2.0, 2.0, 0.3);
/// assert!((p - 0.216).abs() < 1e-15);
/// ```
#[must_use]
pub fn lower_tail(a: f64, b: f64, x: f64) -> f64 {
    tails(a, b, Point { x, y: 1.0 - x }).0
}

/// `1 - I_x(a, b)`: probability that a beta variable exceeds `x`, without cancellation; range as for [`lower_tail`].
#[must_use]
pub fn upper_tail(a: f64, b: f64, x: f64) -> f64 {
    tails(a, b, Point { x, y: 1.0 - x }).1
}

/// Probability that a binomial variable of `trials` trials with probability `p` is at least `count`:
/// `I_p(count, trials - count + 1)`, for up to 1e10 trials; accurate to some 1e-13 of itself.
///
/// ```
/// // At least 2 heads of 3.
/// let p = stickslip_sampler::special_functions::beta::binomial_at_least(2, 3, 0.3);
/// assert!((p - 0.216).abs() < 1e-15);
/// ```
#[must_use]
pub fn binomial_at_least(count: u64, trials: u64, p: f64) -> f64 {
    match count {
        0 => 1.0,
        _ if count > trials => 0.0,
        _ => lower_tail(count as f64, (trials - count) as f64 + 1.0, p),
    }
}

/// Probability that a binomial variable of `trials` trials with probability `p` is at most `count`:
/// `1 - I_p(count + 1, trials - count)`; range and accuracy as for [`binomial_at_least`].
#[must_use]
pub fn binomial_at_most(count: u64, trials: u64, p: f64) -> f64 {
    if count >= trials { 1.0 } else { upper_tail(count as f64 + 1.0, (trials - count) as f64, p) }
}

/// The `x` with `I_x(a, b) = p`, for `a`, `b` from 0.01 to 1e10 and `p` in [0, 1], tails down to 1e-100.
///
/// ```
/// // Rule of three: no event in 100 trials leaves probabilities up to about 3 / 100 possible.
/// let high = stickslip_sampler::special_functions::beta::quantile(1.0, 100.0, 0.95);
/// assert!((high - (1.0 - 0.05f64.powf(0.01))).abs() < 1e-16);
/// ```
#[must_use]
pub fn quantile(a: f64, b: f64, p: f64) -> f64 {
    if p <= 0.5 { Point::from_odds(lower_odds(a, b, p)).x } else { Point::from_odds(lower_odds(b, a, 1.0 - p)).y }
}

/// The `x` with `1 - I_x(a, b) = q`; for small `q` more accurate than [`quantile`] of `1 - q`.
#[must_use]
pub fn upper_quantile(a: f64, b: f64, q: f64) -> f64 {
    if q <= 0.5 { Point::from_odds(lower_odds(b, a, q)).y } else { Point::from_odds(lower_odds(a, b, 1.0 - q)).x }
}

/// The `t` that a Student variable stays within, `|T| <= t`, with probability `confidence` in [0, 1); degrees of
/// freedom from 1 on.
///
/// `P(|T| > t) = I_x(f/2, 1/2)` with `x = f / (f + t^2)` (Abramowitz and Stegun, 26.7.1).
///
/// ```
/// let t = stickslip_sampler::special_functions::beta::student_quantile(0.95, 10);
/// assert!((t - 2.228_138_851_986_274).abs() < 1e-14);
/// ```
#[must_use]
pub fn student_quantile(confidence: f64, degrees_of_freedom: u32) -> f64 {
    let freedom = f64::from(degrees_of_freedom);
    // With x / y = f / t^2; the smaller of the two probabilities is inverted.
    if confidence >= 0.5 {
        (freedom / lower_odds(0.5 * freedom, 0.5, 1.0 - confidence)).sqrt()
    } else {
        (freedom * lower_odds(0.5, 0.5 * freedom, confidence)).sqrt()
    }
}

/// The odds `x / (1 - x)` where the lower tail is `p`, for `p <= 1/2`.
///
/// Newton's iteration for `ln I_x = ln p` over `w = ln(x / y)`. The density over `w`, `x^a y^b / B(a, b)`, has a
/// concave logarithm, and so has its integral: from any start the first step lands below the quantile and the others
/// rise to it without ever passing it.
fn lower_odds(a: f64, b: f64, p: f64) -> f64 {
    if p <= 0.0 {
        return 0.0;
    }
    let target = libm::log(p);
    let mut odds = first_odds(a, b, p);
    for _ in 0..100 {
        let point = Point::from_odds(odds);
        let (lower, _) = tails(a, b, point);
        let density = power(a, b, point);
        if lower <= 0.0 || density <= 0.0 {
            // So far off that nothing is left of the distribution: half the way to its mean.
            odds = (odds * (a / b)).sqrt();
            continue;
        }
        let step = (target - libm::log(lower)) * lower / density;
        // What an astray first guess may cost is a few more steps.
        let step = step.clamp(-20.0, 20.0);
        odds *= libm::exp(step);
        if step.abs() <= 2e-16 {
            break;
        }
        // Convergence is quadratic with a factor below the scale a + b: beyond this the next step is rounding error.
        if step.abs() * step.abs() * (a + b).sqrt() <= 1e-17 {
            break;
        }
    }
    odds
}

/// A first guess of the odds: by the normal quantile (Abramowitz and Stegun, 26.5.22), or for parameters below 1 by the
/// leading term of the lower tail.
fn first_odds(a: f64, b: f64, p: f64) -> f64 {
    if a < 1.0 || b < 1.0 {
        let density = power(a, b, Point { x: 0.5, y: 0.5 }) * libm::exp((a + b) * std::f64::consts::LN_2);
        if density.is_finite() && density > 0.0 {
            let x = libm::exp(libm::log(p * a / density) / a).min(0.999);
            return x / (1.0 - x);
        }
        return a / b;
    }
    let z = normal::quantile(p.max(f64::MIN_POSITIVE));
    let (inverse_a, inverse_b) = (1.0 / (2.0 * a - 1.0), 1.0 / (2.0 * b - 1.0));
    let h = 2.0 / (inverse_a + inverse_b);
    let lambda = (z * z - 3.0) / 6.0;
    let w = z * (h + lambda).sqrt() / h + (inverse_a - inverse_b) * (lambda + 5.0 / 6.0 - 2.0 / (3.0 * h));
    a / b * libm::exp(2.0 * w)
}

/// `(I_x(a, b), 1 - I_x(a, b))`: one of them computed, the other its complement.
fn tails(a: f64, b: f64, point: Point) -> (f64, f64) {
    let Point { x, y } = point;
    if x <= 0.0 {
        return (0.0, 1.0);
    }
    if y <= 0.0 {
        return (1.0, 0.0);
    }
    if a >= LARGE && b >= LARGE {
        // Away from the mode the density falls.
        if (a - 1.0) * y >= (b - 1.0) * x {
            let lower = by_quadrature(a, b, point);
            (lower, 1.0 - lower)
        } else {
            let upper = by_quadrature(b, a, point.mirrored());
            (1.0 - upper, upper)
        }
    } else if a * y >= b * x {
        let lower = by_continued_fraction(a, b, point);
        (lower, 1.0 - lower)
    } else {
        let upper = by_continued_fraction(b, a, point.mirrored());
        (1.0 - upper, upper)
    }
}

/// The lower tail for `x` up to the mean, by the modified Lentz method.
fn by_continued_fraction(a: f64, b: f64, point: Point) -> f64 {
    let Point { x, y } = point;
    let excess = a * y - b * x + 1.0;
    let denominator =
        |m: f64| m + m * (b - m) * x / (a + 2.0 * m - 1.0) + (a + m) / (a + 2.0 * m + 1.0) * (excess + m * (1.0 + y));
    let mut fraction = a / (a + 1.0) * excess;
    let (mut c, mut d) = (fraction, 0.0);
    let mut m = 0.0;
    while m < 1e6 {
        m += 1.0;
        let odd = a + 2.0 * m - 1.0;
        let numerator = (a + m - 1.0) / odd * ((a + b + m - 1.0) / odd) * m * (b - m) * x * x;
        let next = denominator(m);
        d = 1.0 / (next + numerator * d);
        c = next + numerator / c;
        let change = c * d;
        fraction *= change;
        if (change - 1.0).abs() <= f64::EPSILON {
            break;
        }
    }
    power(a, b, point) / fraction
}

/// The lower tail for `x` up to the mode and both parameters large, by quadrature over `u = x - t`:
///
/// ```text
/// I_x = x^a y^b / (B x y) * integral of exp(-slope u + (a - 1) m(-u/x) + (b - 1) m(u/y)) du,
/// slope = ((a - 1) y - (b - 1) x) / (x y),     m(v) = ln(1 + v) - v <= 0
/// ```
fn by_quadrature(a: f64, b: f64, point: Point) -> f64 {
    let Point { x, y } = point;
    let slope = ((a - 1.0) * y - (b - 1.0) * x) / (x * y);
    let curvature = (a - 1.0) / (x * x) + (b - 1.0) / (y * y);
    // Where slope u + curvature u^2 / 2 reaches the depth: at most 0.3 x and 0.3 y, as both parameters are large.
    let half = DEPTH / (slope + (slope * slope + 2.0 * curvature * DEPTH).sqrt());
    let integrand =
        |u: f64| libm::exp(-slope * u + (a - 1.0) * log_minus_linear(-u / x) + (b - 1.0) * log_minus_linear(u / y));
    let mut integral = 0.0;
    for (node, weight) in LEGENDRE {
        integral += weight * (integrand(half * (1.0 - node)) + integrand(half * (1.0 + node)));
    }
    power(a, b, point) / (x * y) * half * integral
}

/// `x^a y^b / B(a, b)`, the density of the beta distribution over `ln(x / y)`.
fn power(a: f64, b: f64, point: Point) -> f64 {
    let Point { x, y } = point;
    let sum = a + b;
    // x = (1 + v) a / (a + b) and y = (1 + w) b / (a + b), with a v + b w = 0: the linear parts of the logarithms
    // cancel.
    let deviation = x * b - y * a;
    let part = |x: f64, a: f64, v: f64| {
        // Far from the mean nothing cancels, and v next to -1 has lost the digits of a small x.
        a * if v.abs() <= 0.5 { log_minus_linear(v) } else { libm::log(x * (sum / a)) - v }
    };
    let exponent = part(x, a, deviation / a) + part(y, b, -deviation / b);
    let stirling = stirling_error(sum) - stirling_error(a) - stirling_error(b);
    (a / sum * b / TAU).sqrt() * libm::exp(exponent + stirling)
}

/// `ln(1 + v) - v` for `|v| <= 1/2`, without cancellation.
fn log_minus_linear(v: f64) -> f64 {
    // With r = v / (2 + v): ln(1 + v) = 2 (r + r^3/3 + r^5/5 + ...), and v = 2 r + r v.
    let r = v / (2.0 + v);
    let square = r * r;
    let (mut sum, mut term, mut odd) = (0.0, 2.0 * square, 3.0);
    while term > 1e-17 * v.abs() {
        sum += term / odd;
        term *= square;
        odd += 2.0;
    }
    r * (sum - v)
}

/// `ln Gamma(a) - (a - 1/2) ln a + a - ln(2 pi) / 2`, what Stirling's formula leaves out, for `a > 0`.
fn stirling_error(a: f64) -> f64 {
    let (mut shifted, mut sum) = (a, 0.0);
    while shifted < 10.0 {
        sum += (shifted + 0.5) * libm::log1p(1.0 / shifted) - 1.0;
        shifted += 1.0;
    }
    let inverse = 1.0 / shifted;
    let square = inverse * inverse;
    // Bernoulli numbers B_2k / (2k (2k - 1)): Abramowitz and Stegun, 6.1.41.
    let mut series = 0.0;
    for coefficient in
        [1.0 / 156.0, -691.0 / 360_360.0, 1.0 / 1188.0, -1.0 / 1680.0, 1.0 / 1260.0, -1.0 / 360.0, 1.0 / 12.0]
    {
        series = series * square + coefficient;
    }
    sum + series * inverse
}

/// The positive half of the 32 nodes of the Gauss-Legendre rule on [-1, 1] with their weights (computed with 40 digits;
/// Abramowitz and Stegun, table 25.4, agrees).
pub(crate) const LEGENDRE: [(f64, f64); 16] = [
    (0.048_307_665_687_738_32, 0.096_540_088_514_727_8),
    (0.144_471_961_582_796_5, 0.095_638_720_079_274_86),
    (0.239_287_362_252_137_07, 0.093_844_399_080_804_57),
    (0.331_868_602_282_127_65, 0.091_173_878_695_763_88),
    (0.421_351_276_130_635_35, 0.087_652_093_004_403_81),
    (0.506_899_908_932_229_4, 0.083_311_924_226_946_76),
    (0.587_715_757_240_762_3, 0.078_193_895_787_070_3),
    (0.663_044_266_930_215_2, 0.072_345_794_108_848_5),
    (0.732_182_118_740_289_7, 0.065_822_222_776_361_85),
    (0.794_483_795_967_942_4, 0.058_684_093_478_535_55),
    (0.849_367_613_732_57, 0.050_998_059_262_376_18),
    (0.896_321_155_766_052_1, 0.042_835_898_022_226_68),
    (0.934_906_075_937_739_7, 0.034_273_862_913_021_43),
    (0.964_762_255_587_506_4, 0.025_392_065_309_262_06),
    (0.985_611_511_545_268_4, 0.016_274_394_730_905_67),
    (0.997_263_861_849_481_5, 0.007_018_610_009_470_097),
];

#[cfg(test)]
mod tests {
    use super::*;

    /// Tails by mpmath 1.4 with 40 digits: numerical integration of the density, at the doubles nearest to these x.
    const TAILS: [(f64, f64, f64, bool, f64); 21] = [
        (1.0, 1.0, 0.3, false, 0.3),
        (1.0, 20.0, 0.01, false, 0.182_093_062_402_769_13),
        (20.0, 1.0, 0.8, false, 0.011_529_215_046_068_483),
        (2.0, 3.0, 0.4, true, 0.4752),
        (2.0, 3.0, 0.9, true, 0.003_7),
        (5.0, 1e6, 1e-6, false, 0.003_659_885_148_265_091_6),
        (5.0, 1e6, 1e-5, true, 0.029_251_363_932_457_597),
        (1e6, 5.0, 0.99999, false, 0.029_251_363_933_318_488),
        (30.0, 70.0, 0.25, false, 0.135_814_904_283_427_44),
        (30.0, 70.0, 0.55, true, 2.052_466_240_174_723e-7),
        (999.0, 999.0, 0.45, false, 3.722_113_900_449_52e-6),
        (1000.0, 1000.0, 0.45, false, 3.683_198_869_007_578e-6),
        (1000.0, 1000.0, 0.51, true, 0.185_552_659_431_511_45),
        (300.0, 1e10, 4e-8, true, 7.507_353_610_434_936e-8),
        (1001.0, 1e10, 9e-8, false, 0.000_490_637_800_426_944_8),
        (1001.0, 1e10, 1.3e-7, true, 2.443_539_222_287_532e-18),
        (1e10, 1e10, 0.49998, false, 7.708_628_851_474_704e-9),
        (1e10, 1e10, 0.500_001, true, 0.388_648_705_392_89),
        (1e10, 3e9, 0.7692, false, 4.166_587_537_842_186e-17),
        (1e10, 3e9, 0.76928, true, 8.469_947_513_012_28e-41),
        (1e10, 2.5, 0.999_999_999_8, true, 0.450_584_096_398_483),
    ];

    #[test]
    fn tails_agree_with_high_precision() {
        for (a, b, x, upper, expected) in TAILS {
            let tail = if upper { upper_tail(a, b, x) } else { lower_tail(a, b, x) };
            // Beside the method's own error, what the spacing of the doubles next to x makes of it.
            let spacing = power(a, b, Point { x, y: 1.0 - x }) / (x * (1.0 - x)) / expected * f64::EPSILON;
            let rounding = spacing * x.min(1.0 - x);
            let error = (tail / expected - 1.0).abs();
            assert!(error < 1e-13 + rounding, "{a} {b} {x}: {tail} instead of {expected}");
        }
    }

    #[test]
    fn tails_are_binomial_sums() {
        // I_p(k, n - k + 1) = P(at least k of n), the sum of the terms themselves.
        for n in [1u32, 2, 7, 30] {
            for p in [1e-3, 0.2, 0.5, 0.77, 0.999] {
                let mass = |k: u32| {
                    let choices = (0..k).fold(1.0, |product, i| product * f64::from(n - i) / f64::from(i + 1));
                    choices * f64::powi(p, k as i32) * f64::powi(1.0 - p, (n - k) as i32)
                };
                for k in 1..=n {
                    let (a, b) = (f64::from(k), f64::from(n - k + 1));
                    let at_least: f64 = (k..=n).map(mass).sum();
                    let below: f64 = (0..k).map(mass).sum();
                    for (tail, sum) in [(lower_tail(a, b, p), at_least), (upper_tail(a, b, p), below)] {
                        // A far tail is the exponential of a large number, rounded.
                        let limit = 5e-15 - 4e-16 * sum.ln();
                        assert!((tail / sum - 1.0).abs() < limit, "{k} of {n} at {p}: {tail:e} instead of {sum:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn both_methods_agree_where_they_meet() {
        for (a, b) in [(1000.0, 1000.0), (1000.0, 1e7), (5e4, 1000.0), (3000.0, 20_000.0)] {
            for deviations in [-6.0, -2.0, -0.5, 0.0] {
                let mean: f64 = a / (a + b);
                let mode_or_below = (a - 1.0) / (a + b - 2.0) * (1.0 - 1e-9);
                let x = (mean + deviations * (mean * (1.0 - mean) / (a + b)).sqrt()).min(mean).min(mode_or_below);
                let point = Point { x, y: 1.0 - x };
                let ratio = by_quadrature(a, b, point) / by_continued_fraction(a, b, point);
                assert!((ratio - 1.0).abs() < 1e-13, "{a} {b} {deviations}: {ratio}");
            }
        }
    }

    #[test]
    fn quantiles_agree_with_high_precision() {
        // mpmath 1.4 with 40 digits: Newton's iteration on the integrated density. Columns: a, b, p, x, 1 - x.
        let table = [
            (1.0, 29.0, 0.025, 0.000_872_646_883_579_922, 0.999_127_353_116_420_1),
            (81.0, 183.0, 0.025, 0.252_736_745_585_271_15, 0.747_263_254_414_728_9),
            (5.0, 999_996.0, 0.025, 1.623_488_319_241_169_8e-6, 0.999_998_376_511_680_8),
            (5.0, 1_000_000.0, 1.0e-12, 1.038_932_401_989_503_2e-8, 0.999_999_989_610_675_9),
            (1.0, 10_000_000_000.0, 1.0e-12, 1.000_000_000_000_5e-22, 1.0),
            (10_000_000_000.0, 1.0, 1.0e-12, 0.999_999_997_236_897_9, 2.763_102_107_775_488e-9),
            (600.0, 700.0, 1.0e-12, 0.366_120_964_817_680_47, 0.633_879_035_182_319_5),
            (2_000.0, 3_000.0, 0.025, 0.386_460_826_567_632_6, 0.613_539_173_432_367_4),
            (2_000.0, 1_000_000_000.0, 1.0e-12, 1.701_376_059_514_080_6e-6, 0.999_998_298_623_940_5),
            (10_000_000_000.0, 10_000_000_000.0, 1.0e-12, 0.499_975_129_343_94, 0.500_024_870_656_06),
            (10_000_000_000.0, 10_000_000_000.0, 0.025, 0.499_993_070_480_878_5, 0.500_006_929_519_121_5),
            (10_000_000_000.0, 3.0, 0.3, 0.999_999_999_638_443_2, 3.615_567_664_850_817e-10),
            (3_000_000_000.0, 7_000_000_000.0, 0.8, 0.300_003_856_789_120_34, 0.699_996_143_210_879_7),
        ];
        for (a, b, p, x, y) in table {
            let quantiles = [(quantile(a, b, p), x), (upper_quantile(b, a, p), y)];
            for (value, expected) in quantiles {
                assert!((value / expected - 1.0).abs() < 3e-15, "{a} {b} {p}: {value} instead of {expected}");
            }
        }
    }

    #[test]
    fn binomial_tails_agree_with_direct_sums() {
        let trials = 30_u64;
        for p in [0.0, 1e-3, 0.2, 0.5, 0.97, 1.0] {
            let mass = |k: u64| {
                let ways = (1..=k).fold(1.0, |ways, i| ways * (trials + 1 - i) as f64 / i as f64);
                ways * libm::pow(p, k as f64) * libm::pow(1.0 - p, (trials - k) as f64)
            };
            for count in 0..=trials {
                let upper: f64 = (count..=trials).map(mass).sum();
                let lower: f64 = (0..=count).map(mass).sum();
                assert!((binomial_at_least(count, trials, p) - upper).abs() < 1e-14, "{p} {count}");
                assert!((binomial_at_most(count, trials, p) - lower).abs() < 1e-14, "{p} {count}");
            }
        }
        assert_eq!((binomial_at_least(4, 3, 0.5), binomial_at_most(4, 3, 0.5)), (0.0, 1.0));
        assert_eq!((binomial_at_least(0, 0, 0.5), binomial_at_most(0, 0, 0.5)), (1.0, 1.0));
    }

    #[test]
    fn small_parameters_are_right_too() {
        // mpmath 1.4 with 50 digits.
        for (a, b, x, lower, upper) in [
            (0.01, 0.01, 0.25, 0.494_586_974_254_139_1, 0.505_413_025_745_860_9),
            (0.01, 0.01, 0.75, 0.505_413_025_745_860_9, 0.494_586_974_254_139_1),
            (0.01, 5.0, 0.000_976_562_5, 0.952_570_819_623_530_5, 0.047_429_180_376_469_424),
            (0.05, 300.0, 0.000_976_562_5, 0.953_489_467_112_266_7, 0.046_510_532_887_733_25),
            (0.125, 0.031_25, 0.875, 0.243_329_868_513_793_58, 0.756_670_131_486_206_4),
            (0.02, 1e5, 3.814_697_265_625e-6, 0.985_214_486_718_733_2, 0.014_785_513_281_266_823),
        ] {
            assert!((lower_tail(a, b, x) / lower - 1.0).abs() < 1e-13, "{a} {b} {x}: {}", lower_tail(a, b, x));
            assert!((upper_tail(a, b, x) / upper - 1.0).abs() < 1e-13, "{a} {b} {x}: {}", upper_tail(a, b, x));
            let odds = |x: f64| x / (1.0 - x);
            // How far x moves with p: 1 / density over ln(odds) is at most some 100.
            assert!((odds(quantile(a, b, lower)) / odds(x) - 1.0).abs() < 1e-11, "{a} {b} {x}");
        }
    }

    #[test]
    fn quantiles_invert_the_tails() {
        for a in [0.5, 1.0, 1.5, 3.0, 80.0, 2500.0, 1e6, 1e10] {
            for b in [0.5, 1.0, 2.0, 45.0, 999.0, 1e4, 1e10] {
                for p in [1e-100, 1e-12, 1e-6, 0.025, 0.5] {
                    let back = tails(a, b, Point::from_odds(lower_odds(a, b, p))).0;
                    // The density of the logarithm of the tail, times the spacing of the doubles.
                    let limit = 1e-13 + 1e-15 * f64::min(a, b).sqrt() * (1.0 - normal::quantile(p));
                    assert!((back / p - 1.0).abs() < limit, "{a} {b} {p}: {back}");
                }
            }
        }
        assert_eq!((quantile(2.0, 3.0, 0.0), quantile(2.0, 3.0, 1.0)), (0.0, 1.0));
        assert_eq!((upper_quantile(2.0, 3.0, 0.0), upper_quantile(2.0, 3.0, 1.0)), (1.0, 0.0));
    }

    #[test]
    fn students_quantiles_agree_with_closed_forms_and_high_precision() {
        // One degree of freedom is Cauchy's distribution, two have t = c sqrt(2 / (1 - c^2)).
        for confidence in [0.01, 0.3, 0.5, 0.9, 0.95, 0.999_999] {
            // The closed forms themselves lose digits next to 1.
            let limit = 1e-14 + 1e-15 / (1.0 - confidence);
            let cauchy = (std::f64::consts::FRAC_PI_2 * confidence).tan();
            assert!((student_quantile(confidence, 1) / cauchy - 1.0).abs() < limit, "{confidence}");
            let two = confidence * (2.0 / (1.0 - confidence * confidence)).sqrt();
            assert!((student_quantile(confidence, 2) / two - 1.0).abs() < limit, "{confidence}");
        }
        // mpmath 1.4 with 30 digits: the density integrated and inverted by Newton's iteration.
        for (confidence, freedom, t) in [
            (0.1, 1, 0.158_384_440_324_536_3),
            (0.95, 1, 12.706_204_736_174_694),
            (0.99, 1, 63.656_741_162_871_526),
            (0.1, 3, 0.136_598_199_353_698_9),
            (0.95, 3, 3.182_446_305_283_708_6),
            (0.99, 3, 5.840_909_309_733_355),
            (0.1, 10, 0.128_890_189_293_273_78),
            (0.95, 10, 2.228_138_851_986_274_4),
            (0.99, 10, 3.169_272_672_616_951),
            (0.1, 30, 0.126_729_613_132_073_6),
            (0.95, 30, 2.042_272_456_301_237_8),
            (0.99, 30, 2.749_995_653_567_225),
            (0.1, 200, 0.125_821_009_779_451_8),
            (0.95, 200, 1.971_896_223_633_909),
            (0.99, 200, 2.600_634_436_191_557_4),
            (0.1, 5_000, 0.125_667_729_307_245_82),
            (0.95, 5_000, 1.960_438_551_706_507_5),
            (0.99, 5_000, 2.576_812_966_556_280_7),
            (0.1, 4_000_000_000, 0.125_661_346_863_051_9),
            (0.95, 4_000_000_000, 1.959_963_985_133_121_6),
            (0.99, 4_000_000_000, 2.575_829_304_778_037),
        ] {
            let value = student_quantile(confidence, freedom);
            assert!((value / t - 1.0).abs() < 3e-15, "{confidence} {freedom}: {value}");
        }
    }
}
