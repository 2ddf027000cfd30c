//! From the counted verdicts of independent randomisations to a probability and its interval.

use stickslip_core::VerdictCounts;

use crate::beta::student_quantile;
use crate::interval::{BinomialInterval, Estimate, IntervalKind};

/// With fewer samples than this on either side, the scatter of a few randomisations does not tell the error.
const RARE: u64 = 30;

/// The estimate from randomisations of equal size: the mean of their shares `p_r` and, with Student's quantile `t` for
/// `R - 1` degrees of freedom,
///
/// ```text
/// mean -+ t s / sqrt(R),     s^2 = sum (p_r - mean)^2 / (R - 1)
/// ```
///
/// Undecided and failed samples count as stable for the low end and as unstable for the high one. Where fewer than 30
/// samples are on one side, or all shares agree, the shares say little of their error; the interval then includes that of
/// Clopper and Pearson for as many independent samples. (The variance of a scrambled net is at most a small multiple of
/// that of independent samples: A. B. Owen, SIAM J. Numer. Anal. 34, 1997.)
///
/// ```
/// use stickslip_core::VerdictCounts;
/// use stickslip_sampler::replicates::estimate;
/// let part = |unstable| VerdictCounts { unstable, stable: 100 - unstable, ..VerdictCounts::default() };
/// let estimate = estimate(&[part(40), part(42), part(41), part(41)], 0.95);
/// assert!((estimate.probability.unwrap() - 0.41).abs() < 1e-12);
/// assert!(estimate.low > 0.39 && estimate.high < 0.43);
/// ```
#[must_use]
pub fn estimate(parts: &[VerdictCounts], confidence: f64) -> Estimate {
    let pooled = parts.iter().fold(VerdictCounts::default(), |sum, part| sum + *part);
    let binomial = BinomialInterval::new(IntervalKind::ClopperPearson, confidence).estimate(&pooled);
    let parts: Vec<&VerdictCounts> = parts.iter().filter(|part| part.total() > 0).collect();
    if parts.len() < 2 {
        return binomial;
    }
    let doubtful = |part: &VerdictCounts| part.undecided + part.failed;
    let share = |count: u64, part: &VerdictCounts| count as f64 / part.total() as f64;
    let (low_mean, low_reach) = reach(parts.iter().map(|part| share(part.unstable, part)), confidence);
    let (high_mean, high_reach) =
        reach(parts.iter().map(|part| share(part.unstable + doubtful(part), part)), confidence);
    let (mut low, mut high) = ((low_mean - low_reach).max(0.0), (high_mean + high_reach).min(1.0));
    let is_rare = pooled.unstable.min(pooled.stable) < RARE;
    if is_rare || low_reach == 0.0 || high_reach == 0.0 {
        low = low.min(binomial.low);
        high = high.max(binomial.high);
    }
    Estimate { probability: binomial.probability, low, high }
}

/// Mean and half width of the interval.
fn reach(shares: impl Iterator<Item = f64> + Clone, confidence: f64) -> (f64, f64) {
    let count = shares.clone().count();
    let mean = shares.clone().sum::<f64>() / count as f64;
    let squares: f64 = shares.map(|share| (share - mean) * (share - mean)).sum();
    let error = (squares / (count - 1) as f64 / count as f64).sqrt();
    (mean, student_quantile(confidence, count as u32 - 1) * error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Cell, DeviateStream, Points, RelativeStd, exact};
    use stickslip_core::{PadOnDisc, Parameters};

    fn part(stable: u64, unstable: u64, undecided: u64) -> VerdictCounts {
        VerdictCounts { stable, unstable, undecided, ..VerdictCounts::default() }
    }

    #[test]
    fn the_interval_is_students() {
        // SciPy: t.interval(0.95, 3, mean, sem) of 0.3, 0.34, 0.29, 0.35.
        let estimate = estimate(&[part(700, 300, 0), part(660, 340, 0), part(710, 290, 0), part(650, 350, 0)], 0.95);
        assert!(
            (estimate.low - 0.273_155_658_8).abs() < 1e-9 && (estimate.high - 0.366_844_341_2).abs() < 1e-9,
            "{estimate:?}"
        );
    }

    #[test]
    fn none_and_all_are_no_certainty() {
        let none = estimate(&[part(1000, 0, 0); 8], 0.95);
        assert_eq!((none.probability, none.low), (Some(0.0), 0.0));
        assert!((none.high - (1.0 - 0.025_f64.powf(1.0 / 8000.0))).abs() < 1e-12, "{none:?}");
        let all = estimate(&[part(0, 1000, 0); 8], 0.95);
        assert!(all.high == 1.0 && all.low < 1.0 && all.low > 0.999);
        assert_eq!((estimate(&[], 0.95).low, estimate(&[], 0.95).high), (0.0, 1.0));
    }

    #[test]
    fn undecided_samples_widen_it_on_one_side_each() {
        let certain = estimate(&[part(500, 500, 0), part(510, 490, 0), part(490, 510, 0)], 0.95);
        let doubtful = estimate(&[part(400, 500, 100), part(410, 490, 100), part(390, 510, 100)], 0.95);
        assert!((doubtful.low - certain.low).abs() < 1e-12 && (doubtful.high - certain.high - 0.1).abs() < 1e-12);
    }

    #[test]
    fn scrambled_points_cover_the_exact_probability_with_far_narrower_intervals() {
        let boundary = PadOnDisc::new(Parameters::sui_ding_2018()).unwrap().stability_boundary();
        let relative_std = RelativeStd { preload: 0.2, static_friction: 0.2 };
        let (mut covered, mut width, mut count) = (0, 0.0, 0);
        for (preload, static_friction) in [(0.1, 0.39), (0.2, 0.3), (0.05, 0.5), (0.03, 0.4)] {
            for seed in 0..60 {
                let cell = Cell { index: seed, rotating_speed: 16.0, relative_std, preload, static_friction };
                let stream = DeviateStream { seed, common_random_numbers: false, dimensions: 2, points: Points::Sobol };
                let counts: Vec<VerdictCounts> = (0..16)
                    .map(|randomisation| {
                        let deviates = stream.draw(seed, randomisation, 0..512);
                        let verdict = |z: &[f64]| {
                            boundary.verdict(preload * (1.0 + 0.2 * z[0]), static_friction * (1.0 + 0.2 * z[1]))
                        };
                        deviates.chunks_exact(2).fold(VerdictCounts::default(), |sum, z| sum + verdict(z).into())
                    })
                    .collect();
                let estimate = estimate(&counts, 0.95);
                let exact = exact::probability(&boundary, &cell).value;
                covered += u32::from(estimate.low <= exact && exact <= estimate.high);
                let binomial = 2.0 * 1.96 * (exact * (1.0 - exact) / 8192.0).sqrt();
                width += (estimate.high - estimate.low) / binomial;
                count += 1;
            }
        }
        // 240 trials of 0.95: 228 +- 3.4. Less than half as wide as independent samples make it.
        assert!((217..=239).contains(&covered), "{covered} of {count}");
        assert!(width / f64::from(count) < 0.5, "{}", width / f64::from(count));
    }
}
