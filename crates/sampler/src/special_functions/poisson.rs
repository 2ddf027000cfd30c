//! The Poisson distribution: counts of rare events, where a normal deviate says nothing.

/// Probability that a Poisson variable with the given `mean` (up to some hundreds) is at least `count`.
///
/// ```
/// let p = stickslip_sampler::special_functions::poisson::at_least(2, 0.5);
/// assert!((p - (1.0 - 1.5 * (-0.5f64).exp())).abs() < 1e-15);
/// ```
#[must_use]
pub fn at_least(count: u64, mean: f64) -> f64 {
    let mut term = libm::exp(-mean);
    let mut below = 0.0;
    for k in 0..count {
        below += term;
        term *= mean / (k + 1) as f64;
        if term == 0.0 {
            break;
        }
    }
    (1.0 - below).max(0.0)
}

/// Probability that a Poisson variable with the given `mean` is at most `count`.
#[must_use]
pub fn at_most(count: u64, mean: f64) -> f64 {
    1.0 - at_least(count + 1, mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tails_agree_with_direct_sums() {
        for mean in [0.0_f64, 1e-3, 0.7, 3.0, 9.5] {
            let mass = |k: u64| (1..=k).fold((-mean).exp(), |mass, i| mass * mean / i as f64);
            for count in 0..30 {
                let upper: f64 = (count..200).map(mass).sum();
                assert!((at_least(count, mean) - upper).abs() < 1e-14, "{mean} {count}");
                assert!((at_most(count, mean) + upper - mass(count) - 1.0).abs() < 1e-14, "{mean} {count}");
            }
        }
    }
}
