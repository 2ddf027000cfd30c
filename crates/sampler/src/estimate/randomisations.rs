//! The estimate from independent randomisations of Sobol points.

use stickslip_core::model::verdict::VerdictCounts;

use crate::estimate::interval::{BinomialInterval, Estimate, IntervalKind, MOST_WILSON_CONFIDENCE};
use crate::special_functions::beta::student_quantile;

/// With fewer samples than this on either side, the scatter of a few randomisations does not show the error. The second
/// number applies beyond a confidence of 95 %, where the quantile depends on the tails of the distribution of the
/// shares.
const RARE: [u64; 2] = [30, 200];

/// The estimate from `R` randomisations of equal size: the mean of their shares `p_r` of unstable samples and, with
/// Student's quantile `t` for `R - 1` degrees of freedom, the interval
///
/// ```text
/// mean -+ t s / sqrt(R),     s^2 = sum (p_r - mean)^2 / (R - 1)
/// ```
///
/// Undecided and failed samples count as stable for the low end and as unstable for the high one. With fewer than two
/// randomisations the interval is Clopper and Pearson's for all samples.
///
/// **Rare events.** Where fewer than 30 samples (200 beyond a confidence of 95 %) are unstable or stable, or all shares
/// are equal, the scatter of the shares does not show their error. The interval is then widened to include Clopper and
/// Pearson's for as many independent samples. (The variance of a scrambled net is at most a small multiple of that of
/// independent samples: A. B. Owen, SIAM J. Numer. Anal. 34, 1997.)
///
/// **One input.** If `N` is a power of two, `N` points over one input lie one in each of `N` strata. A boundary crosses
/// one stratum, so that the counts of the randomisations are `c` or `c + 1`, the latter with the probability `f` for
/// which the true probability is `(c + f) / N`. Then `f` is a binomial proportion of `R` trials, for which Student's
/// interval is a poor approximation (it covers 0.88 instead of 0.95). Wherever the counts differ by no more than one,
/// the interval includes Clopper and Pearson's for `f`. With one input it then need not include that for independent
/// samples.
///
/// ```
/// use stickslip_core::model::verdict::VerdictCounts;
/// use stickslip_sampler::estimate::randomisations::estimate;
/// let part = |unstable| VerdictCounts { unstable, stable: 100 - unstable, ..VerdictCounts::default() };
/// let estimate = estimate(&[part(40), part(42), part(41), part(41)], 2, 0.95);
/// assert!((estimate.probability.unwrap() - 0.41).abs() < 1e-12);
/// assert!(estimate.low > 0.39 && estimate.high < 0.43);
/// ```
#[must_use]
pub fn estimate(parts: &[VerdictCounts], inputs: usize, confidence: f64) -> Estimate {
    let pooled = parts.iter().fold(VerdictCounts::default(), |sum, part| sum + *part);
    let binomial = BinomialInterval::new(IntervalKind::ClopperPearson, confidence).estimate(&pooled);
    let parts: Vec<&VerdictCounts> = parts.iter().filter(|part| part.total() > 0).collect();
    if parts.len() < 2 {
        return binomial;
    }
    let lower: Vec<(u64, u64)> = parts.iter().map(|part| (part.unstable, part.total())).collect();
    let upper: Vec<(u64, u64)> =
        parts.iter().map(|part| (part.unstable + part.without_verdict(), part.total())).collect();
    let shares = |counts: &[(u64, u64)]| -> Vec<f64> {
        counts.iter().map(|&(count, total)| count as f64 / total as f64).collect()
    };
    let (low_mean, low_half_width) = student(&shares(&lower), confidence);
    let (high_mean, high_half_width) = student(&shares(&upper), confidence);
    let (mut low, mut high) = (low_mean - low_half_width, high_mean + high_half_width);
    let strata = [strata(&lower, confidence), strata(&upper, confidence)];
    if let Some((end, _)) = strata[0] {
        low = low.min(end);
    }
    if let Some((_, end)) = strata[1] {
        high = high.max(end);
    }
    // By counts, as the mean of equal shares may be rounded.
    let all_agree = |counts: &[(u64, u64)]| counts.windows(2).all(|pair| pair[0] == pair[1]);
    let rare = RARE[usize::from(confidence > MOST_WILSON_CONFIDENCE)];
    let is_rare = pooled.unstable.min(pooled.stable) < rare || all_agree(&lower) || all_agree(&upper);
    let is_stratified =
        inputs == 1 && strata.iter().all(Option::is_some) && parts.iter().all(|part| part.total().is_power_of_two());
    if is_rare && !is_stratified {
        low = low.min(binomial.low);
        high = high.max(binomial.high);
    }
    Estimate { probability: binomial.probability, low: low.max(0.0), high: high.min(1.0) }
}

/// The interval from counts that differ by no more than one, as those of strata of which a boundary crosses one; `None`
/// if they differ by more, or if the randomisations are not of equal size.
fn strata(counts: &[(u64, u64)], confidence: f64) -> Option<(f64, f64)> {
    let &(first, points) = counts.first()?;
    let (least, most) = counts.iter().fold((first, first), |(a, b), &(count, _)| (a.min(count), b.max(count)));
    if most - least > 1 || counts.iter().any(|&(_, other)| other != points) {
        return None;
    }
    let trials = counts.len() as u64;
    let more = counts.iter().filter(|(count, _)| *count > least).count() as u64;
    let interval = BinomialInterval::new(IntervalKind::ClopperPearson, confidence);
    let (mut from, to) = interval.bounds(more, trials);
    if more == 0 {
        // All of them may have the one point more.
        from = interval.bounds(trials, trials).0 - 1.0;
    }
    Some(((least as f64 + from) / points as f64, (least as f64 + to) / points as f64))
}

/// Mean and half width of Student's interval from the shares of randomisations.
pub(super) fn student(shares: &[f64], confidence: f64) -> (f64, f64) {
    let count = shares.len();
    let mean = shares.iter().sum::<f64>() / count as f64;
    let squares: f64 = shares.iter().map(|share| (share - mean) * (share - mean)).sum();
    let error = (squares / (count - 1) as f64 / count as f64).sqrt();
    (mean, student_quantile(confidence, (count - 1) as f64) * error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::deviates::{DeviateStream, Points};
    use crate::integrate::NormalPair;
    use crate::integrate::closed_form;
    use stickslip_core::models::pad_on_disc::parameters::Parameters;
    use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

    fn part(stable: u64, unstable: u64, undecided: u64) -> VerdictCounts {
        VerdictCounts { stable, unstable, undecided, ..VerdictCounts::default() }
    }

    #[test]
    fn the_interval_is_students() {
        // SciPy: t.interval(0.95, 3, mean, sem) of 0.3, 0.34, 0.29, 0.35.
        let estimate = estimate(&[part(700, 300, 0), part(660, 340, 0), part(710, 290, 0), part(650, 350, 0)], 2, 0.95);
        assert!(
            (estimate.low - 0.273_155_658_8).abs() < 1e-9 && (estimate.high - 0.366_844_341_2).abs() < 1e-9,
            "{estimate:?}"
        );
    }

    #[test]
    fn no_count_gives_an_interval_without_width() {
        let none = estimate(&[part(1000, 0, 0); 8], 2, 0.95);
        assert_eq!((none.probability, none.low), (Some(0.0), 0.0));
        assert!((none.high - (1.0 - 0.025_f64.powf(1.0 / 8000.0))).abs() < 1e-12, "{none:?}");
        let all = estimate(&[part(0, 1000, 0); 8], 2, 0.95);
        assert!(all.high == 1.0 && all.low < 1.0 && all.low > 0.999);
        assert_eq!((estimate(&[], 2, 0.95).low, estimate(&[], 2, 0.95).high), (0.0, 1.0));
    }

    #[test]
    fn undecided_samples_widen_it_on_one_side_each() {
        let decided = estimate(&[part(500, 500, 0), part(510, 490, 0), part(490, 510, 0)], 2, 0.95);
        let with_undecided = estimate(&[part(400, 500, 100), part(410, 490, 100), part(390, 510, 100)], 2, 0.95);
        assert!(
            (with_undecided.low - decided.low).abs() < 1e-12
                && (with_undecided.high - decided.high - 0.1).abs() < 1e-12
        );
    }

    /// The share of seeds whose interval contains `p`, where samples are unstable by the first coordinate of Sobol
    /// points.
    fn coverage(points: u64, dimensions: usize, p: f64, is_unstable: impl Fn(f64) -> bool) -> f64 {
        let seeds = 1000;
        let covered = (0..seeds).filter(|&seed| {
            let stream = DeviateStream { seed, common_random_numbers: false, dimensions, points: Points::Sobol };
            let parts: Vec<VerdictCounts> = (0..16)
                .map(|randomisation| {
                    let deviates = stream.draw(seed, randomisation, 0..points);
                    let unstable = deviates.chunks_exact(dimensions).filter(|z| is_unstable(z[0])).count() as u64;
                    part(points - unstable, unstable, 0)
                })
                .collect();
            let estimate = estimate(&parts, dimensions, 0.95);
            estimate.low <= p && p <= estimate.high
        });
        covered.count() as f64 / seeds as f64
    }

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn the_interval_with_one_input_has_its_coverage() {
        // The probabilities that lie a little, and half, above a whole number of points.
        for (points, unstable) in [(64, 20.06), (64, 20.5), (256, 3.15), (256, 100.9), (1024, 0.07)] {
            let p = unstable / points as f64;
            let limit = -crate::special_functions::normal::quantile(p);
            for dimensions in [1, 2] {
                let covered = coverage(points, dimensions, p, |z| z > limit);
                assert!(covered >= 0.94, "{points} {unstable} {dimensions}: {covered}");
            }
        }
        // Two boundaries: unstable between them.
        let p = crate::special_functions::normal::upper_tail(0.4) - crate::special_functions::normal::upper_tail(1.3);
        let covered = coverage(128, 1, p, |z| 0.4 < z && z < 1.3);
        assert!(covered >= 0.93, "{covered}");
    }

    #[test]
    fn the_interval_from_strata_is_narrower_than_that_of_independent_samples() {
        let one = estimate(&[part(924, 100, 0); 16], 1, 0.95);
        let two = estimate(&[part(924, 100, 0); 16], 2, 0.95);
        // Clopper and Pearson's 0 of 16 is 0 to 0.205907.
        let end = 0.205_907;
        assert!((1024.0 * one.high - 100.0 - end).abs() < 1e-5 && (1024.0 * one.low - 100.0 + end).abs() < 1e-5);
        assert!(two.low < one.low && two.high > one.high);
        // Points that are no power of two have no strata.
        let [other, pooled] = [1, 2].map(|inputs| estimate(&[part(900, 100, 0); 16], inputs, 0.95));
        assert_eq!(other, pooled);
    }

    #[test]
    fn scrambled_points_cover_the_exact_probability_with_far_narrower_intervals() {
        let boundary = PadOnDisc::new(Parameters::sui_ding_2018()).unwrap().stability_boundary();
        let (mut covered, mut width, mut count) = (0, 0.0, 0);
        for (preload, static_friction) in [(0.1, 0.39), (0.2, 0.3), (0.05, 0.5), (0.03, 0.4)] {
            let cell = NormalPair { expected: [preload, static_friction], relative_std: [0.2; 2] };
            for seed in 0..60 {
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
                let estimate = estimate(&counts, 2, 0.95);
                let exact = closed_form::probability(&boundary, &cell).value;
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

    #[test]
    fn few_stable_samples_are_as_rare_as_few_unstable_ones() {
        for confidence in [0.95, 0.99] {
            for few in [[1, 4, 0, 2], [6, 8, 7, 7], [24, 26, 25, 25]] {
                let rare = estimate(&few.map(|count| part(1000 - count, count, 0)), 2, confidence);
                let frequent = estimate(&few.map(|count| part(count, 1000 - count, 0)), 2, confidence);
                assert!((rare.low + frequent.high - 1.0).abs() < 1e-12, "{rare:?} {frequent:?}");
                assert!((rare.high + frequent.low - 1.0).abs() < 1e-12, "{rare:?} {frequent:?}");
            }
        }
    }

    #[test]
    fn beyond_ninety_five_per_cent_more_samples_are_few() {
        // A hundred unstable samples that hardly scatter between the randomisations.
        let parts = [24, 26, 25, 25].map(|count| part(1000 - count, count, 0));
        let pooled = |confidence: f64| {
            BinomialInterval::new(IntervalKind::ClopperPearson, confidence).estimate(&part(3900, 100, 0))
        };
        let [usual, high] = [0.95, 0.99].map(|confidence| (estimate(&parts, 2, confidence), pooled(confidence)));
        assert!(usual.0.low > usual.1.low && usual.0.high < usual.1.high, "{usual:?}");
        assert!(high.0.low <= high.1.low && high.0.high >= high.1.high, "{high:?}");
    }
}
