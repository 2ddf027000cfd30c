//! Sequential sampling: looking at the counts of a cell repeatedly until its probability is known precisely enough.
//!
//! A rule that computes an ordinary 95 % interval at every look and stops as soon as that is narrow enough stops
//! earlier when the counts happen to be low, because a small observed probability makes a narrow interval. For rare
//! events such an interval covers the true probability less often than it claims, and the observed share is too low on
//! average. [`Looks`] fixes the sample counts of the looks in advance, divides the error among them, and has the
//! unbiased estimate of this design.

mod unbiased;

use stickslip_core::model::verdict::VerdictCounts;

use crate::draw::identity::BLOCK_SAMPLES;
use crate::estimate::interval::{BinomialInterval, Estimate, IntervalKind};

/// The fraction of the error that the regular looks share; later looks share the rest.
const REGULAR: f64 = 0.9;

/// With a relative precision only, the regular looks end where probabilities down to this one stop.
const LEAST_REGULAR: f64 = 1e-6;

/// Most looks of a schedule; the samples of more would exceed 2^64.
const MOST_LOOKS: usize = 200;

/// The precision at which sampling stops. At least one of the two is given; with both, one of them suffices.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Half of the interval's width is at most this; greater than 0 and less than 0.5.
    pub half_width: Option<f64>,
    /// Half of the interval's width is at most this times its middle; greater than 0 and less than 1.
    pub relative: Option<f64>,
}

impl Precision {
    /// Whether an interval is narrow enough.
    fn is_met(&self, low: f64, high: f64) -> bool {
        let width = high - low;
        self.half_width.is_some_and(|most| 0.5 * width <= most)
            || self.relative.is_some_and(|most| width <= most * (low + high))
    }

    /// The samples below which no counts make an interval of error `alpha` narrow enough.
    fn least_samples(&self, alpha: f64) -> u64 {
        // The narrowest intervals are those without an unstable or without a stable sample: their other end is
        // (alpha / 2)^(1 / n) from 1 or from 0.
        let end = |ratio: f64| libm::log(0.5 * alpha) / libm::log(ratio);
        let absolute = self.half_width.map_or(f64::INFINITY, |most| end(1.0 - 2.0 * most));
        let relative = self.relative.map_or(f64::INFINITY, |most| end((1.0 - most) / (1.0 + most)));
        f64::min(absolute, relative) as u64
    }

    /// Whether every probability stops at `samples`; with a relative precision only, every one from 1e-6 on.
    fn is_met_by_most(&self, interval: &BinomialInterval, samples: u64) -> bool {
        let unstable = if self.half_width.is_some() { samples / 2 } else { (samples as f64 * LEAST_REGULAR) as u64 };
        let (low, high) = interval.bounds(unstable, samples);
        self.is_met(low, high)
    }
}

/// A schedule of looks at a cell, with intervals that are valid at whichever look the cell stops, and an unbiased
/// estimate.
///
/// **Intervals.** Look `j` has a Clopper-Pearson interval of error `alpha_j`, and the `alpha_j` add up to `1 - c` for a
/// confidence `c`. By Bonferroni's inequality all of the intervals together contain the true probability with
/// probability `c` or more, and so does the one at which any rule stops. This holds for finite samples and for every
/// probability: Clopper and Pearson's interval is exact, and the inequality assumes nothing about how the looks depend
/// on each other or about the stopping rule. (Boundaries that use the dependence of the looks, S. J. Pocock, Biometrika
/// 64, 1977, hold for normal means, not for small counts.)
///
/// **Schedule.** The first look is where a stop becomes possible. Sample counts grow by a quarter from look to look, at
/// the start by a block, so that a stop is at most that much later than necessary and the number of looks grows with
/// the logarithm of the precision. The `K` regular looks extend to the sample count at which every probability stops
/// (with a relative precision only, every one from 1e-6 on). They share nine tenths of the error equally, which makes
/// the widest of their intervals as narrow as possible. Look `K + i` has the fraction `1 / (i (i + 1))` of the rest.
/// The limit of samples does not enter and can be raised later; an interval at the limit has the error of the next
/// look.
///
/// **Estimate.** The share of unstable samples at the stop is biased: with a half width of 0.0005 it is 17 % too low at
/// a probability of 1e-4; with a relative precision it is too high. The share at the first look is unbiased but has a
/// large variance. Its expected value given the counts at the stop is unbiased with the smallest variance (M. A.
/// Girshick, F. Mosteller, L. J. Savage, Ann. Math. Stat. 17, 1946). The expectation is over all orders of the samples
/// that would not have stopped earlier; given the count at one look, that at the look before is hypergeometric.
///
/// ```
/// use stickslip_sampler::estimate::looks::{Looks, Precision};
/// let precision = Precision { half_width: Some(0.01), relative: None };
/// let looks = Looks::new(precision, 5500, 0.95);
/// assert_eq!(looks.ends(), [1000, 2000, 3000, 4000, 5000, 5500]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Looks {
    precision: Precision,
    ends: Vec<u64>,
    regular: usize,
    intervals: Vec<BinomialInterval>,
}

impl Looks {
    /// The schedule of looks until `precision` is met or a cell has `at_most` samples. `confidence` is two-sided and
    /// holds for all looks together.
    #[must_use]
    pub fn new(precision: Precision, at_most: u64, confidence: f64) -> Self {
        let whole_blocks = |samples: u64| samples.div_ceil(BLOCK_SAMPLES).saturating_mul(BLOCK_SAMPLES);
        let alpha = 1.0 - confidence;
        let mut end = whole_blocks(precision.least_samples(alpha).max(1));
        let mut schedule = vec![end];
        let regular = loop {
            let looks = schedule.len();
            let share = BinomialInterval::new(IntervalKind::ClopperPearson, 1.0 - alpha * REGULAR / looks as f64);
            if looks == MOST_LOOKS || end == u64::MAX || precision.is_met_by_most(&share, end) {
                break looks;
            }
            end = whole_blocks(end.saturating_add(end.div_ceil(4)));
            schedule.push(end);
        };
        while end < at_most {
            end = whole_blocks(end.saturating_add(end.div_ceil(4)));
            schedule.push(end);
        }
        let mut ends: Vec<u64> = schedule.into_iter().take_while(|&end| end < at_most).collect();
        ends.push(at_most);
        let mut looks = Self { precision, ends, regular, intervals: Vec::new() };
        let interval =
            |look| BinomialInterval::new(IntervalKind::ClopperPearson, 1.0 - alpha * looks.error_share(look));
        looks.intervals = (0..looks.ends.len()).map(interval).collect();
        looks
    }

    /// Samples of the cell at each look, strictly increasing; the last is the limit.
    #[must_use]
    pub fn ends(&self) -> &[u64] {
        &self.ends
    }

    /// The fraction of the error that a look has.
    #[must_use]
    pub fn error_share(&self, look: usize) -> f64 {
        match (look + 1).checked_sub(self.regular) {
            None | Some(0) => REGULAR / self.regular as f64,
            Some(i) => (1.0 - REGULAR) / (i as f64 * (i as f64 + 1.0)),
        }
    }

    /// Whether to stop at a look: its interval is narrow enough, or it is the last.
    #[must_use]
    pub fn is_enough(&self, look: usize, counts: &VerdictCounts) -> bool {
        look + 1 >= self.ends.len() || self.is_met(look, counts.unstable, counts)
    }

    /// The number of samples at which a cell is expected to stop, at look `from` or later: if further samples have the
    /// shares of verdicts that `counts` has. At least one sample has to be counted.
    #[must_use]
    pub fn expected_end(&self, from: usize, counts: &VerdictCounts) -> u64 {
        let is_enough = |look: usize| {
            let scaled = |count: u64| {
                (u128::from(count) * u128::from(self.ends[look]) / u128::from(counts.total().max(1))) as u64
            };
            let counts = VerdictCounts {
                stable: scaled(counts.stable),
                unstable: scaled(counts.unstable),
                undecided: scaled(counts.undecided),
                failed: scaled(counts.failed),
            };
            self.is_enough(look, &counts)
        };
        // The more samples, the narrower the interval.
        let (mut low, mut high) = (from.min(self.ends.len() - 1), self.ends.len() - 1);
        while low < high {
            let middle = usize::midpoint(low, high);
            if is_enough(middle) {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        self.ends[low]
    }

    /// Whether the interval is narrow enough with `unstable` of the decided samples.
    fn is_met(&self, look: usize, unstable: u64, counts: &VerdictCounts) -> bool {
        let estimate = self.intervals[look].estimate(&with_unstable(unstable, counts));
        self.precision.is_met(estimate.low, estimate.high)
    }

    /// The estimate at a stop: unbiased, with an interval that is valid under repeated looks and any stopping rule.
    ///
    /// `counts` holds the counts of all samples up to each look, one entry a look. Without a look the interval is (0,
    /// 1).
    #[must_use]
    pub fn estimate(&self, counts: &[VerdictCounts]) -> Estimate {
        let Some((look, last)) = counts.iter().enumerate().next_back() else {
            return Estimate { probability: None, low: 0.0, high: 1.0 };
        };
        debug_assert_eq!(self.ends.get(look), Some(&last.total()), "counts of another look");
        let estimate = self.intervals[look].estimate(last);
        let stops = |look: usize, unstable: u64| self.is_met(look, unstable, &counts[look]);
        // It leaves the interval only after stops that are unlikely for every probability.
        Estimate {
            probability: unbiased::probability(counts, stops).map(|p| p.clamp(estimate.low, estimate.high)),
            ..estimate
        }
    }
}

/// Counts with another number of unstable samples among the decided ones.
fn with_unstable(unstable: u64, counts: &VerdictCounts) -> VerdictCounts {
    VerdictCounts { unstable, stable: counts.decided() - unstable, ..*counts }
}

#[cfg(test)]
mod tests;
