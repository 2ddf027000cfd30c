//! Stopping by precision: looking at a cell's counts again and again until its probability is known well enough.
//!
//! Who computes an ordinary 95 % interval at every look and stops as soon as it is narrow enough stops more often when
//! the counts happen to be low than when they happen to be high: a small observed probability makes a narrow interval.
//! For rare events such an interval covers less than it says. [`Looks`] fixes in advance when the counts are looked at
//! and spends the error over those looks.

use stickslip_core::VerdictCounts;

use crate::identity::BLOCK_SAMPLES;
use crate::interval::{BinomialInterval, Estimate, IntervalKind, simultaneous_confidence};

/// The sample counts at which a cell is looked at, and intervals that hold whichever look is the last.
///
/// Every one of the `K` looks has a Clopper-Pearson interval at the confidence `1 - (1 - c) / K`. Each of these misses
/// the true probability at most that often, so by Bonferroni's inequality all of them contain it together with
/// probability `c` or more, and so does the one at which any rule stops. This holds for finite samples and for every
/// probability: Clopper-Pearson is exact, and the bound asks nothing of how the looks depend on one another, nor of the
/// stopping rule. Equal shares are the choice that makes the worst look's interval the narrowest; which look will
/// stop is not known before the probability is. The looks' dependence makes the bound pessimistic, by 7 to 8 % of the
/// width for 11 to 38 looks; boundaries that use it (S. J. Pocock, Biometrika 64, 1977) hold for normal means, not for
/// few counts.
///
/// With sample counts that grow by a quarter (at the start by a block) a stop is at most that much later than need be,
/// and `K` grows with the logarithm of `at_most / first` only. Fewer looks mean narrower intervals: `first` should not
/// be far below the count at which a stop is thinkable.
///
/// ```
/// use stickslip_sampler::Looks;
/// let looks = Looks::new(1000, 10_500, 0.95);
/// assert_eq!(looks.ends(), [1000, 2000, 3000, 4000, 5000, 7000, 9000, 10_500]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Looks {
    ends: Vec<u64>,
    interval: BinomialInterval,
}

impl Looks {
    /// Looks at `first` samples, then at a quarter more each time, rounded up to whole blocks, and finally at
    /// `at_most`, with the given two-sided confidence for all looks together.
    #[must_use]
    pub fn new(first: u64, at_most: u64, confidence: f64) -> Self {
        let whole_blocks = |samples: u64| samples.div_ceil(BLOCK_SAMPLES).saturating_mul(BLOCK_SAMPLES).min(at_most);
        let mut end = whole_blocks(first.max(1));
        let mut ends = vec![end];
        while end < at_most {
            end = whole_blocks(end.saturating_add(end.div_ceil(4)));
            ends.push(end);
        }
        let confidence = simultaneous_confidence(confidence, ends.len() as u64);
        Self { ends, interval: BinomialInterval::new(IntervalKind::ClopperPearson, confidence) }
    }

    /// Samples of the cell at each look, strictly increasing; the last is the most it may have.
    #[must_use]
    pub fn ends(&self) -> &[u64] {
        &self.ends
    }

    /// The estimate from the counts at a look (0 is the first), valid under repeated looks and any stopping rule.
    ///
    /// All looks have the same confidence. The counts must be those of the first `ends()[look]` samples, all of them.
    #[must_use]
    pub fn interval(&self, look: usize, counts: &VerdictCounts) -> Estimate {
        debug_assert_eq!(self.ends.get(look), Some(&counts.total()), "counts of another look");
        self.interval.estimate(counts)
    }

    /// Whether to stop at a look: its interval is at most `half_width` to either side of its middle, or it is the last.
    #[must_use]
    pub fn is_enough(&self, look: usize, counts: &VerdictCounts, half_width: f64) -> bool {
        if look + 1 >= self.ends.len() {
            return true;
        }
        let Estimate { low, high, .. } = self.interval(look, counts);
        0.5 * (high - low) <= half_width
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::WilsonInterval;
    use rand::SeedableRng;
    use rand_distr::{Binomial, Distribution};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn looks_are_whole_blocks_that_grow_by_a_quarter() {
        for (first, at_most) in [(1, 1), (1000, 1000), (1, 999), (1500, 1_000_000), (10_000, 12_345_678), (7, 1 << 40)]
        {
            let looks = Looks::new(first, at_most, 0.95);
            let ends = looks.ends();
            assert_eq!(ends[0], first.div_ceil(BLOCK_SAMPLES).saturating_mul(BLOCK_SAMPLES).min(at_most));
            assert_eq!(*ends.last().unwrap(), at_most);
            let inner = &ends[..ends.len() - 1];
            assert!(inner.iter().all(|end| end % BLOCK_SAMPLES == 0));
            for pair in ends.windows(2) {
                assert!(pair[0] < pair[1]);
                assert!(pair[1] <= pair[0] + pair[0] / 4 + BLOCK_SAMPLES);
                assert!(pair[1] == at_most || 4 * pair[1] >= 5 * pair[0]);
            }
        }
        assert_eq!(Looks::new(5000, 1000, 0.95).ends(), [1000]);
        assert_eq!(Looks::new(0, 2000, 0.95).ends(), [1000, 2000]);
        assert_eq!(Looks::new(0, 0, 0.95).ends(), [0]);
        assert_eq!(*Looks::new(1000, u64::MAX, 0.95).ends().last().unwrap(), u64::MAX);
    }

    #[test]
    fn one_look_is_a_plain_clopper_pearson_interval() {
        let counts = VerdictCounts { stable: 900, unstable: 60, undecided: 30, failed: 10 };
        let plain = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95);
        let looks = Looks::new(1000, 1000, 0.95);
        assert_eq!(looks.interval(0, &counts), plain.estimate(&counts));
        // More looks, each a smaller error: wider.
        let wider = Looks::new(1000, 100_000, 0.95).interval(0, &counts);
        assert!(wider.low < plain.estimate(&counts).low && wider.high > plain.estimate(&counts).high);
    }

    #[test]
    fn a_look_is_enough_when_narrow_or_last() {
        let looks = Looks::new(1000, 2000, 0.95);
        let counts = VerdictCounts { stable: 900, unstable: 100, ..Default::default() };
        let Estimate { low, high, .. } = looks.interval(0, &counts);
        assert!(looks.is_enough(0, &counts, 0.5 * (high - low)));
        assert!(!looks.is_enough(0, &counts, 0.499 * (high - low)));
        assert!(looks.is_enough(1, &VerdictCounts { stable: 1000, unstable: 1000, ..Default::default() }, 1e-9));
        // Undecided samples count as width.
        let doubtful = VerdictCounts { stable: 500, unstable: 100, undecided: 400, ..Default::default() };
        assert!(!looks.is_enough(0, &doubtful, 0.15));
    }

    /// Shares of seeded replicates whose interval at the stopping time contains `p`: of [`Looks`] with its own rule,
    /// and of plain 95 % Wilson intervals that stop at the same half width.
    fn coverage_when_stopped(p: f64, half_width: f64, replicates: u32) -> (f64, f64) {
        let looks = Looks::new(1000, 20_000, 0.95);
        let wilson = WilsonInterval::new(0.95);
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(1945);
        let (mut by_looks, mut by_wilson) = (0, 0);
        for _ in 0..replicates {
            let mut counts = VerdictCounts::default();
            let (mut looks_stopped, mut wilson_stopped) = (false, false);
            for (look, &end) in looks.ends().iter().enumerate() {
                let more = end - counts.total();
                let unstable = Binomial::new(more, p).unwrap().sample(&mut generator);
                counts.unstable += unstable;
                counts.stable += more - unstable;
                let contains = |estimate: &Estimate| u32::from(estimate.low <= p && p <= estimate.high);
                if !looks_stopped && looks.is_enough(look, &counts, half_width) {
                    looks_stopped = true;
                    by_looks += contains(&looks.interval(look, &counts));
                }
                let plain = wilson.estimate(&counts);
                let last = look + 1 == looks.ends().len();
                if !wilson_stopped && (last || 0.5 * (plain.high - plain.low) <= half_width) {
                    wilson_stopped = true;
                    by_wilson += contains(&plain);
                }
                if looks_stopped && wilson_stopped {
                    break;
                }
            }
        }
        (f64::from(by_looks) / f64::from(replicates), f64::from(by_wilson) / f64::from(replicates))
    }

    #[test]
    fn intervals_at_the_stopping_time_cover_at_least_as_often_as_they_say() {
        for (p, half_width) in
            [(0.0005, 0.002), (0.003, 0.0012), (0.02, 0.004), (0.3, 0.01), (0.5, 0.02), (0.97, 0.005)]
        {
            let (by_looks, _) = coverage_when_stopped(p, half_width, 4000);
            assert!(by_looks >= 0.95, "{p}: {by_looks}");
        }
    }

    #[test]
    fn a_plain_interval_with_the_same_rule_covers_less_than_it_says() {
        // Exact values by convolving binomial distributions from look to look (NumPy 2, SciPy 1.17): 0.9299 for
        // Wilson's intervals, 0.9956 for the looks'. The standard error of 20,000 replicates is 0.0018.
        let (by_looks, by_wilson) = coverage_when_stopped(0.003, 0.0012, 20_000);
        assert!((by_wilson - 0.9299).abs() < 0.006, "{by_wilson}");
        assert!((by_looks - 0.9956).abs() < 0.002, "{by_looks}");
    }
}
