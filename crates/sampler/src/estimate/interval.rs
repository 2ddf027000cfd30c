//! From counted verdicts to a probability and its confidence interval.

use stickslip_core::verdict::VerdictCounts;

use crate::special_functions::{beta, normal};

/// A probability of instability with the interval that contains the true one at the job's confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// `unstable / (stable + unstable)`; `None` if no sample was decided.
    pub probability: Option<f64>,
    /// Lower end, every undecided and failed sample counted as stable.
    pub low: f64,
    /// Upper end, every undecided and failed sample counted as unstable.
    pub high: f64,
}

/// Wilson's score interval for a binomial proportion (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927):
///
/// ```text
/// (p + z^2 / 2n -+ z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n),      p = k / n
/// ```
///
/// It stays inside [0, 1], and is never empty at `k = 0` or `k = n`.
///
/// ```
/// use stickslip_sampler::estimate::interval::WilsonInterval;
/// let (low, high) = WilsonInterval::new(0.95).bounds(81, 263);
/// assert!((low - 0.255_3).abs() < 5e-5 && (high - 0.366_2).abs() < 5e-5); // Newcombe 1998, method 3
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WilsonInterval {
    z: f64,
}

impl WilsonInterval {
    /// The interval with the given two-sided confidence, strictly between 0 and 1.
    #[must_use]
    pub fn new(confidence: f64) -> Self {
        Self { z: normal::upper_quantile(0.5 * (1.0 - confidence)) }
    }

    /// The ends for `successes` out of `trials`; (0, 1) without trials.
    #[must_use]
    pub fn bounds(&self, successes: u64, trials: u64) -> (f64, f64) {
        if trials == 0 {
            return (0.0, 1.0);
        }
        let failures = trials - successes;
        (self.lower(successes, failures), 1.0 - self.lower(failures, successes))
    }

    /// The lower end; the upper one is its mirror image, so that both ends are exact where they are 0 or 1.
    fn lower(&self, successes: u64, failures: u64) -> f64 {
        if successes == 0 {
            return 0.0;
        }
        let (k, n) = (successes as f64, (successes + failures) as f64);
        let z2 = self.z * self.z;
        let centre = k + 0.5 * z2;
        let spread = self.z * (k * (failures as f64 / n) + 0.25 * z2).sqrt();
        // (centre - spread) / (n + z^2), multiplied out by (centre + spread): no cancellation.
        (k * k / n) / (centre + spread)
    }

    /// The estimate that counted verdicts give.
    #[must_use]
    pub fn estimate(&self, counts: &VerdictCounts) -> Estimate {
        estimate(counts, |successes, trials| self.bounds(successes, trials))
    }
}

/// The estimate from counted verdicts by the `bounds` of successes and trials. A doubtful sample could have been
/// either: it counts as stable for the lower end and as unstable for the upper one.
fn estimate(counts: &VerdictCounts, bounds: impl Fn(u64, u64) -> (f64, f64)) -> Estimate {
    let (decided, total) = (counts.decided(), counts.total());
    let probability = (decided > 0).then(|| counts.unstable as f64 / decided as f64);
    let doubtful = counts.without_verdict();
    let (low, _) = bounds(counts.unstable, total);
    let (_, high) = bounds(counts.unstable + doubtful, total);
    Estimate { probability, low, high }
}

/// Which interval a binomial proportion gets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalKind {
    /// Wilson's score interval: covers the true probability as often as it says on average over probabilities. Near 0
    /// and 1 it covers less: at 95 % never less than 0.838 (at `n p` = 0.177, for large `n`), at 99.9 % 0.925.
    Wilson,
    /// Clopper and Pearson's exact interval: covers at least as often as it says whatever the probability, and is
    /// wider.
    ClopperPearson,
}

/// Wilson's interval is not used beyond this confidence: the rarer a miss is to be, the more often it misses than it says.
pub const MOST_WILSON_CONFIDENCE: f64 = 0.95;

impl IntervalKind {
    /// The interval for a confidence if nobody asks for one of them: Wilson's up to 95 %, Clopper and Pearson's beyond.
    #[must_use]
    pub fn for_confidence(confidence: f64) -> Self {
        if confidence > MOST_WILSON_CONFIDENCE { Self::ClopperPearson } else { Self::Wilson }
    }
}

/// A confidence interval for a binomial proportion, of either kind.
///
/// Wilson's is [`WilsonInterval`]. Clopper and Pearson's (Biometrika 26, 1934) has the ends at which the observed count
/// or a more extreme one has the probability `alpha / 2 = (1 - confidence) / 2`:
///
/// ```text
/// I_low(k, n - k + 1) = alpha / 2,      I_high(k + 1, n - k) = 1 - alpha / 2
/// ```
///
/// and 0 at `k = 0`, 1 at `k = n`. Its ends are computed to some 1e-15 relative to their distance from 0 and from 1,
/// for up to 1e10 trials ([`beta`]).
///
/// ```
/// use stickslip_sampler::estimate::interval::{BinomialInterval, IntervalKind};
/// let (low, high) = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95).bounds(81, 263);
/// assert!((low - 0.252_7).abs() < 5e-5 && (high - 0.367_6).abs() < 5e-5); // Newcombe 1998, method 5
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BinomialInterval {
    kind: IntervalKind,
    confidence: f64,
    wilson: WilsonInterval,
}

impl BinomialInterval {
    /// The interval of the given kind with the given two-sided confidence, strictly between 0 and 1.
    #[must_use]
    pub fn new(kind: IntervalKind, confidence: f64) -> Self {
        Self { kind, confidence, wilson: WilsonInterval::new(confidence) }
    }

    /// Which interval this is.
    #[must_use]
    pub fn kind(&self) -> IntervalKind {
        self.kind
    }

    /// The two-sided confidence.
    #[must_use]
    pub fn confidence(&self) -> f64 {
        self.confidence
    }

    /// The ends for `successes` out of `trials`; (0, 1) without trials.
    #[must_use]
    pub fn bounds(&self, successes: u64, trials: u64) -> (f64, f64) {
        match self.kind {
            IntervalKind::Wilson => self.wilson.bounds(successes, trials),
            IntervalKind::ClopperPearson => self.exact_bounds(successes, trials),
        }
    }

    fn exact_bounds(&self, successes: u64, trials: u64) -> (f64, f64) {
        let tail = 0.5 * (1.0 - self.confidence);
        let (k, failures) = (successes as f64, (trials - successes) as f64);
        let low = if successes == 0 { 0.0 } else { beta::quantile(k, failures + 1.0, tail) };
        let high = if successes == trials { 1.0 } else { beta::upper_quantile(k + 1.0, failures, tail) };
        (low, high)
    }

    /// The estimate that counted verdicts give.
    #[must_use]
    pub fn estimate(&self, counts: &VerdictCounts) -> Estimate {
        estimate(counts, |successes, trials| self.bounds(successes, trials))
    }
}

/// The confidence that each of a number of intervals needs so that all of them together contain their true values with
/// probability `confidence`: `1 - (1 - c) / m`.
///
/// Bonferroni's inequality: the probability that any of `m` intervals misses is at most the sum of theirs, however they
/// depend on one another. For independent intervals `c^(1/m)` would do, which is hardly less.
///
/// ```
/// let each = stickslip_sampler::estimate::interval::simultaneous_confidence(0.95, 50);
/// assert!((each - 0.999).abs() < 1e-15);
/// ```
#[must_use]
pub fn simultaneous_confidence(confidence: f64, intervals: u64) -> f64 {
    1.0 - (1.0 - confidence) / intervals.max(1) as f64
}

/// The confidence of each of two intervals that hold together with `confidence`.
#[must_use]
pub fn half_of_the_error(confidence: f64) -> f64 {
    0.5 + 0.5 * confidence
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn bounds_agree_with_published_examples() {
        // R. G. Newcombe, Statistics in Medicine 17 (1998), table I, method 3 (Wilson's score, no correction).
        let interval = WilsonInterval::new(0.95);
        for (k, n, low, high) in
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
        {
            let bounds = interval.bounds(k, n);
            assert!((bounds.0 - low).abs() <= 0.5e-4 && (bounds.1 - high).abs() <= 0.5e-4, "{k}/{n}: {bounds:?}");
        }
    }

    #[test]
    fn bounds_solve_the_score_equation() {
        // Definition: |p_hat - p| = z sqrt(p (1 - p) / n) at both ends.
        for confidence in [0.5, 0.9, 0.95, 0.999] {
            let interval = WilsonInterval::new(confidence);
            for (k, n) in [(1, 2), (3, 10), (500, 1000), (1, 1_000_000), (999_999, 1_000_000)] {
                let p_hat = k as f64 / n as f64;
                let (low, high) = interval.bounds(k, n);
                assert!(low < p_hat && p_hat < high);
                for p in [low, high] {
                    let score = (p_hat - p).abs() / (p * (1.0 - p) / n as f64).sqrt();
                    assert!((score / interval.z - 1.0).abs() < 1e-9, "{k}/{n} at {confidence}: {score}");
                }
            }
        }
    }

    #[test]
    fn ends_are_exact_at_zero_and_one() {
        let interval = WilsonInterval::new(0.95);
        assert_eq!(interval.bounds(0, 10_000).0, 0.0);
        assert_eq!(interval.bounds(10_000, 10_000).1, 1.0);
        assert!(interval.bounds(0, 10_000).1 > 0.0 && interval.bounds(10_000, 10_000).0 < 1.0);
        assert_eq!(interval.bounds(0, 0), (0.0, 1.0));
    }

    #[test]
    fn doubtful_samples_widen_the_interval_on_both_sides() {
        let interval = WilsonInterval::new(0.95);
        let certain = interval.estimate(&VerdictCounts { stable: 60, unstable: 40, ..Default::default() });
        let doubtful = interval.estimate(&VerdictCounts { stable: 50, unstable: 40, undecided: 7, failed: 3 });
        assert_eq!(doubtful.probability, Some(40.0 / 90.0));
        assert_eq!(doubtful.low, certain.low);
        assert_eq!(doubtful.high, interval.bounds(50, 100).1);
        let none = interval.estimate(&VerdictCounts { undecided: 5, ..Default::default() });
        assert_eq!(none.probability, None);
        assert_eq!((none.low, none.high), (0.0, 1.0));
    }

    #[test]
    fn the_interval_covers_the_true_probability_as_often_as_it_says() {
        // Exact coverage for n = 40, averaged over p: the sum of binomial probabilities of the k whose interval
        // contains p. Wilson's interval is right on average, not at every p.
        let (interval, n) = (WilsonInterval::new(0.95), 40u64);
        let mut coverage = 0.0;
        let points = 2000;
        for i in 0..points {
            let p = (f64::from(i) + 0.5) / f64::from(points);
            let mut mass = (1.0 - p).powi(n as i32);
            for k in 0..=n {
                let (low, high) = interval.bounds(k, n);
                if low <= p && p <= high {
                    coverage += mass;
                }
                mass *= (n - k) as f64 / (k + 1) as f64 * p / (1.0 - p);
            }
        }
        coverage /= f64::from(points);
        assert!((coverage - 0.95).abs() < 0.005, "{coverage}");
    }

    /// Probability that the interval for `n` trials contains `p`, summed over all counts.
    fn exact_coverage(interval: &BinomialInterval, n: u64, p: f64) -> f64 {
        let (mut coverage, mut mass) = (0.0, (1.0 - p).powi(n as i32));
        for k in 0..=n {
            let (low, high) = interval.bounds(k, n);
            if low <= p && p <= high {
                coverage += mass;
            }
            mass *= (n - k) as f64 / (k + 1) as f64 * p / (1.0 - p);
        }
        coverage
    }

    #[test]
    fn exact_bounds_agree_with_published_examples() {
        // R. G. Newcombe, Statistics in Medicine 17 (1998), table I, method 5 (Clopper-Pearson).
        let interval = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95);
        for (k, n, low, high) in
            [(81, 263, 0.2527, 0.3676), (15, 148, 0.0578, 0.1617), (0, 20, 0.0, 0.1684), (1, 29, 0.0009, 0.1776)]
        {
            let bounds = interval.bounds(k, n);
            assert!((bounds.0 - low).abs() <= 0.5e-4 && (bounds.1 - high).abs() <= 0.5e-4, "{k}/{n}: {bounds:?}");
        }
    }

    #[test]
    fn exact_bounds_have_their_closed_forms_at_zero_and_all() {
        for confidence in [0.5, 0.95, 1.0 - 1e-9] {
            let interval = BinomialInterval::new(IntervalKind::ClopperPearson, confidence);
            let tail: f64 = 0.5 * (1.0 - confidence);
            for n in [1u64, 20, 10_000, 1_000_000_000] {
                // (1 - high)^n = alpha / 2.
                let high = -(tail.ln() / n as f64).exp_m1();
                let (none, all) = (interval.bounds(0, n), interval.bounds(n, n));
                assert!(none.0 == 0.0 && (none.1 / high - 1.0).abs() < 1e-13, "{n}: {none:?}");
                assert!(all.1 == 1.0 && (all.0 - (1.0 - high)).abs() < 1e-15, "{n}: {all:?}");
            }
            assert_eq!(interval.bounds(0, 0), (0.0, 1.0));
        }
    }

    #[test]
    fn exact_bounds_contain_wilsons_neighbourhood_and_approach_it() {
        // For large counts both tend to the normal interval, with differences of the order of half a count.
        let wilson = WilsonInterval::new(0.95);
        let exact = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95);
        for (k, n) in [(300_000, 1_000_000u64), (5_000_000_000, 10_000_000_000), (1_000_000, 10_000_000_000)] {
            let (a, b) = (wilson.bounds(k, n), exact.bounds(k, n));
            assert!((a.0 - b.0).abs() < 2.0 / n as f64 && (a.1 - b.1).abs() < 2.0 / n as f64, "{a:?} {b:?}");
            let mirrored = exact.bounds(n - k, n);
            assert!((mirrored.0 - (1.0 - b.1)).abs() < 1e-15 && (mirrored.1 - (1.0 - b.0)).abs() < 1e-15);
        }
    }

    #[test]
    fn both_kinds_count_doubtful_samples_against_both_ends() {
        let counts = VerdictCounts { stable: 50, unstable: 40, undecided: 7, failed: 3 };
        for kind in [IntervalKind::Wilson, IntervalKind::ClopperPearson] {
            let interval = BinomialInterval::new(kind, 0.95);
            let estimate = interval.estimate(&counts);
            assert_eq!(estimate.probability, Some(40.0 / 90.0));
            assert_eq!((estimate.low, estimate.high), (interval.bounds(40, 100).0, interval.bounds(50, 100).1));
        }
        assert_eq!(
            BinomialInterval::new(IntervalKind::Wilson, 0.95).estimate(&counts),
            WilsonInterval::new(0.95).estimate(&counts)
        );
    }

    #[test]
    fn exact_intervals_cover_at_least_as_often_as_they_say_at_every_probability() {
        for confidence in [0.8, 0.95, 0.999] {
            let interval = BinomialInterval::new(IntervalKind::ClopperPearson, confidence);
            let wilson = BinomialInterval::new(IntervalKind::Wilson, confidence);
            for n in [10, 40] {
                let (mut least, mut least_of_wilson) = (1.0_f64, 1.0_f64);
                for i in 1..1000 {
                    let p = f64::from(i) / 1000.0;
                    least = least.min(exact_coverage(&interval, n, p));
                    least_of_wilson = least_of_wilson.min(exact_coverage(&wilson, n, p));
                }
                assert!(least >= confidence - 1e-12, "{n} at {confidence}: {least}");
                // What Wilson's interval does not promise.
                assert!(least_of_wilson < confidence, "{n} at {confidence}: {least_of_wilson}");
            }
        }
    }

    fn uniform(generator: &mut Xoshiro256PlusPlus) -> f64 {
        (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    #[test]
    fn estimates_from_partly_undecided_verdicts_cover_the_true_probability() {
        // One sample in twenty of either kind cannot be judged. The interval holds whatever its verdict would have
        // been, so it covers at least as often as it says.
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(1927);
        let (p, samples, replicates) = (0.1, 200, 4000);
        let intervals =
            [IntervalKind::Wilson, IntervalKind::ClopperPearson].map(|kind| BinomialInterval::new(kind, 0.95));
        for doubt in [0.0, 0.05] {
            let mut covered = [0; 2];
            for _ in 0..replicates {
                let mut counts = VerdictCounts::default();
                for _ in 0..samples {
                    let unstable = uniform(&mut generator) < p;
                    match (uniform(&mut generator) < doubt, unstable) {
                        (true, true) => counts.undecided += 1,
                        (true, false) => counts.failed += 1,
                        (false, true) => counts.unstable += 1,
                        (false, false) => counts.stable += 1,
                    }
                }
                for (covered, interval) in covered.iter_mut().zip(&intervals) {
                    let estimate = interval.estimate(&counts);
                    *covered += u32::from(estimate.low <= p && p <= estimate.high);
                }
            }
            let [wilson, exact] = covered.map(|count| f64::from(count) / f64::from(replicates));
            if doubt == 0.0 {
                // Exact coverage at this p and n, SciPy 1.17: 0.9561 and 0.9669.
                assert!((wilson - 0.9561).abs() < 0.012, "{wilson}");
                assert!((exact - 0.9669).abs() < 0.012, "{exact}");
            } else {
                assert!(wilson > 0.98 && exact > 0.98, "{wilson} {exact}");
            }
        }
    }

    #[test]
    fn simultaneous_intervals_all_cover_together() {
        // 20 cells of 60 samples: independent ones, and ones that share half of their random numbers.
        let (cells, samples, replicates) = (20, 60, 2000);
        let each = BinomialInterval::new(IntervalKind::ClopperPearson, simultaneous_confidence(0.95, cells));
        let plain = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95);
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(1936);
        for shared in [0, samples / 2] {
            let (mut all_cover, mut all_cover_plainly) = (0, 0);
            for _ in 0..replicates {
                let common: Vec<f64> = (0..shared).map(|_| uniform(&mut generator)).collect();
                let (mut together, mut plainly) = (true, true);
                for cell in 0..cells {
                    let p = 0.05 + 0.03 * cell as f64;
                    let own = (shared..samples).filter(|_| uniform(&mut generator) < p).count();
                    let successes = own + common.iter().filter(|&&u| u < p).count();
                    let contains = |(low, high): (f64, f64)| low <= p && p <= high;
                    together &= contains(each.bounds(successes as u64, samples));
                    plainly &= contains(plain.bounds(successes as u64, samples));
                }
                all_cover += u32::from(together);
                all_cover_plainly += u32::from(plainly);
            }
            let [together, plainly] =
                [all_cover, all_cover_plainly].map(|count| f64::from(count) / f64::from(replicates));
            assert!(together >= 0.95, "{shared}: {together}");
            assert!(plainly < 0.8, "{shared}: {plainly}");
        }
        assert_eq!(simultaneous_confidence(0.95, 1), 0.95);
    }
}
