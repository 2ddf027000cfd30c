//! The shape of a Weibull distribution from its relative standard deviation.

/// Below this, a series replaces the logarithms of the gamma function, which cancel.
const SMALL: f64 = 0.05;

/// Riemann's zeta function of 2, 3, 4, and so on.
const ZETA: [f64; 17] = [
    1.644_934_066_848_226_4,
    1.202_056_903_159_594_2,
    1.082_323_233_711_138_2,
    1.036_927_755_143_37,
    1.017_343_061_984_449,
    1.008_349_277_381_923,
    1.004_077_356_197_944_4,
    1.002_008_392_826_082_2,
    1.000_994_575_127_818,
    1.000_494_188_604_119_5,
    1.000_246_086_553_308,
    1.000_122_713_347_578_6,
    1.000_061_248_135_058_7,
    1.000_030_588_236_307,
    1.000_015_282_259_408_6,
    1.000_007_637_197_637_9,
    1.000_003_817_293_265,
];

/// The inverse shape `u = 1 / k` of the Weibull distribution whose standard deviation over its mean is `s`, from 0 to
/// 10.
///
/// It solves `ln Gamma(1 + 2 u) - 2 ln Gamma(1 + u) = ln(1 + s^2)`, whose left side rises with `u`, by bisection to the
/// last bit.
pub fn inverse_shape(relative_std: f64) -> f64 {
    let target = libm::log1p(relative_std * relative_std);
    // u / s is sqrt(6) / pi = 0.78 for small s, 1 for s = 1, and 0.43 for s = 10.
    let (mut low, mut high) = (0.4 * relative_std, 1.2 * relative_std);
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return middle;
        }
        if log_scatter(middle) < target {
            low = middle;
        } else {
            high = middle;
        }
    }
}

/// `ln Gamma(1 + 2 u) - 2 ln Gamma(1 + u)`; for small `u` by the series of `ln Gamma(1 + u)` (Abramowitz and Stegun,
/// 6.1.33), whose linear terms cancel.
fn log_scatter(u: f64) -> f64 {
    if u >= SMALL {
        return libm::lgamma(1.0 + 2.0 * u) - 2.0 * libm::lgamma(1.0 + u);
    }
    let (mut sum, mut power, mut twice) = (0.0, u * u, 4.0 * u * u);
    for (order, zeta) in (2..).zip(ZETA) {
        sum += zeta * (twice - 2.0 * power) / f64::from(order);
        power *= -u;
        twice *= -2.0 * u;
    }
    sum
}
