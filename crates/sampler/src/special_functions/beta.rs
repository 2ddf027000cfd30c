//! The beta distribution, and with it exact binomial tails and Student's t.
//!
//! The regularised incomplete beta function is
//!
//! ```text
//! I_x(a, b) = 1 / B(a, b) * integral from 0 to x of t^(a-1) (1-t)^(b-1) dt
//! ```
//!
//! It is the probability that a binomial variable of `a + b - 1` trials with probability `x` is at least `a`. For
//! counts up to 1e10 the usual methods fail: logarithms of the gamma function cancel to a few digits, and continued
//! fractions need some `sqrt(n)` terms. Here, with `y = 1 - x`,
//!
//! * the power `x^a y^b / B(a, b)` is computed from its deviation from its maximum and from Stirling errors, in which
//!   nothing cancels (C. Loader, Fast and accurate computation of binomial probabilities, 2000);
//! * if `a` or `b` is below 1000, a continued fraction is used (A. R. DiDonato and A. H. Morris, algorithm 708, ACM
//!   Trans. Math. Softw. 18, 1992, equation 9), on the side of the mean where it converges quickly;
//! * otherwise a Gauss-Legendre rule of 32 points integrates the density relative to its value at `x`, over the
//!   interval beyond `x` where that is above 1e-16 or so. There the density is smooth and falls, whatever `a` and `b`.
//!
//! Both tails have a relative error of about 1e-13 where `x` is given exactly. The spacing of `x` adds the density
//! times that spacing, about 1e-10 for `a` and `b` of 1e10. The quantiles have an error of about 1e-15 relative to `x`
//! and to `1 - x`.

use std::f64::consts::TAU;

use crate::special_functions::gauss_legendre::NODES_32;
use crate::special_functions::normal;

/// Where both parameters are at least this, the density is narrow enough for quadrature.
const LARGE: f64 = 1000.0;

/// Largest sum of the parameters: beyond any count of 64 bits, and far from overflow.
const LARGEST: f64 = 1e20;

/// The quadrature ends where the density is the exponential of minus this times that at `x`.
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

/// `I_x(a, b)`: the probability that a beta variable is at most `x`, for `a`, `b` from 0.01 to 1e10 and `x` in [0, 1].
#[must_use]
pub(crate) fn lower_tail(a: f64, b: f64, x: f64) -> f64 {
    tails(a, b, Point { x, y: 1.0 - x }).0
}

/// `1 - I_x(a, b)`: the probability that a beta variable exceeds `x`, without cancellation; range as for
/// [`lower_tail`].
#[must_use]
pub(crate) fn upper_tail(a: f64, b: f64, x: f64) -> f64 {
    tails(a, b, Point { x, y: 1.0 - x }).1
}

/// Probability that a binomial variable of `trials` trials with probability `p` is at least `count`:
/// `I_p(count, trials - count + 1)`, for up to 1e10 trials; with a relative error of about 1e-13.
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
#[must_use]
pub(crate) fn quantile(a: f64, b: f64, p: f64) -> f64 {
    if p <= 0.5 { Point::from_odds(lower_odds(a, b, p)).x } else { Point::from_odds(lower_odds(b, a, 1.0 - p)).y }
}

/// The `x` with `1 - I_x(a, b) = q`; for small `q` more accurate than [`quantile`] of `1 - q`.
#[must_use]
pub(crate) fn upper_quantile(a: f64, b: f64, q: f64) -> f64 {
    if q <= 0.5 { Point::from_odds(lower_odds(b, a, q)).y } else { Point::from_odds(lower_odds(a, b, 1.0 - q)).x }
}

/// The two-sided quantile `t` of Student's distribution, `P(|T| <= t) = confidence`, for `confidence` in [0, 1) and at
/// least one degree of freedom, of which the number need not be whole.
///
/// `P(|T| > t) = I_x(f/2, 1/2)` with `x = f / (f + t^2)` (Abramowitz and Stegun, 26.7.1).
#[must_use]
pub(crate) fn student_quantile(confidence: f64, freedom: f64) -> f64 {
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
/// concave logarithm, and so has its integral: from any start the first step ends below the quantile, and the others
/// rise to it without passing it.
fn lower_odds(a: f64, b: f64, p: f64) -> f64 {
    if !are_in_range(a, b) || p.is_nan() {
        return f64::NAN;
    }
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
            // So far out that the tail underflows: move half way to the mean.
            odds = (odds * (a / b)).sqrt();
            continue;
        }
        let step = (target - libm::log(lower)) * lower / density;
        // After a poor first guess this costs a few more steps.
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

/// Whether there is a beta distribution with these parameters, as far as it can be computed.
fn are_in_range(a: f64, b: f64) -> bool {
    a > 0.0 && b > 0.0 && a + b <= LARGEST
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

/// `(I_x(a, b), 1 - I_x(a, b))`: one of them is computed, the other is its complement.
fn tails(a: f64, b: f64, point: Point) -> (f64, f64) {
    let Point { x, y } = point;
    if !are_in_range(a, b) || x.is_nan() {
        return (f64::NAN, f64::NAN);
    }
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

/// The lower tail for `x` up to the mean, by the modified Lentz algorithm.
fn by_continued_fraction(a: f64, b: f64, point: Point) -> f64 {
    let Point { x, y } = point;
    let excess = a * y - b * x + 1.0;
    let denominator =
        |m: f64| m + m * (b - m) * x / (a + 2.0 * m - 1.0) + (a + m) / (a + 2.0 * m + 1.0) * (excess + m * (1.0 + y));
    let mut fraction = a / (a + 1.0) * excess;
    let (mut c, mut d) = (fraction, 0.0);
    let mut m = 0.0;
    while m < 1e6 {
        #[cfg(test)]
        tests::TERMS.with(|terms| terms.set(terms.get() + 1));
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

/// The lower tail for `x` up to the mode and two large parameters, by quadrature over `u = x - t`:
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
    for (node, weight) in NODES_32 {
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
    // The first condition ends it where v is out of range or no number.
    while odd < 100.0 && term > 1e-17 * v.abs() {
        sum += term / odd;
        term *= square;
        odd += 2.0;
    }
    r * (sum - v)
}

/// The error of Stirling's formula, `ln Gamma(a) - (a - 1/2) ln a + a - ln(2 pi) / 2`, for `a > 0`.
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

#[cfg(test)]
mod tests;
