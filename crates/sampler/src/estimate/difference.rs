//! Intervals for the difference `p1 - p2` of two probabilities, from paired samples (two models or two cells with
//! common random numbers), from independent samples, and from samples that depend on each other in an unknown way.
//!
//! Up to a confidence of 95 % the intervals for paired and for independent samples are approximate: they reach the
//! stated coverage on average over probabilities. Beyond, where many intervals have to hold together, they are built
//! from Clopper and Pearson's ([`IntervalKind::for_confidence`]).

use crate::estimate::interval::{BinomialInterval, IntervalKind, half_of_the_error};
use crate::special_functions::normal;

/// Samples decided twice, counted by the two verdicts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PairedCounts {
    /// Unstable in both.
    pub both: u64,
    /// Unstable in the first only.
    pub only_first: u64,
    /// Unstable in the second only.
    pub only_second: u64,
    /// Unstable in neither.
    pub neither: u64,
}

impl PairedCounts {
    /// The number of pairs.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.both + self.only_first + self.only_second + self.neither
    }
}

/// A difference `p1 - p2` of two probabilities with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The observed difference; `None` without samples.
    pub value: Option<f64>,
    /// Lower end, at least -1.
    pub low: f64,
    /// Upper end, at most 1.
    pub high: f64,
}

impl Difference {
    /// What is known without samples.
    const UNKNOWN: Self = Self { value: None, low: -1.0, high: 1.0 };
}

/// The two-sided interval for the difference of two probabilities from `n` paired samples, `n` up to 1e10. It is (-1,
/// 1) without pairs. The caller decides how to count pairs with an undecided sample.
///
/// Up to a confidence of 95 % it is Tango's score interval (T. Tango, Statistics in Medicine 17, 1998, p. 891): the
/// differences `d` with
///
/// ```text
/// |b - c - n d| <= z sqrt(n (2 q + d (1 - d))),
/// ```
///
/// where `b` pairs are unstable only in the first and `c` only in the second, `z` is the normal quantile, and `q` is
/// the maximum-likelihood probability of a pair unstable only in the second at difference `d`. The interval is never
/// empty, even for `b = c = 0`, and stays inside [-1, 1].
///
/// Beyond 95 % it is the range of `d = w (2 t - 1)`. Here `w`, the probability that a pair differs, is in Clopper and
/// Pearson's interval for `b` plus `c` out of `n`, and `t`, the probability that the first is the unstable one of a
/// pair that differs, is in theirs for `b` out of `b + c`, each interval with half of the error. By Bonferroni's
/// inequality the coverage is at least the confidence. For many pairs with `b` near `c` the interval is little wider
/// than Tango's.
///
/// ```
/// use stickslip_sampler::estimate::difference::{PairedCounts, paired_difference};
/// let counts = PairedCounts { both: 1, only_first: 1, only_second: 7, neither: 12 };
/// let difference = paired_difference(&counts, 0.95);
/// assert!((difference.low + 0.517).abs() < 5e-4 && (difference.high + 0.026).abs() < 5e-4);
/// ```
#[must_use]
pub fn paired_difference(counts: &PairedCounts, confidence: f64) -> Difference {
    let total = counts.total();
    if total == 0 {
        return Difference::UNKNOWN;
    }
    let value = Some((counts.only_first as f64 - counts.only_second as f64) / total as f64);
    let (low, high) = match IntervalKind::for_confidence(confidence) {
        IntervalKind::Wilson => tango(counts, confidence),
        IntervalKind::ClopperPearson => exact_paired(counts, confidence),
    };
    Difference { value, low, high }
}

/// Tango's interval.
fn tango(counts: &PairedCounts, confidence: f64) -> (f64, f64) {
    let z = normal::upper_quantile(0.5 * (1.0 - confidence));
    let (first, second, total) = (counts.only_first as f64, counts.only_second as f64, counts.total() as f64);
    (-score_limit(second, first, total, z), score_limit(first, second, total, z))
}

/// The interval from the share of pairs that differ and the direction in which they do.
fn exact_paired(counts: &PairedCounts, confidence: f64) -> (f64, f64) {
    let interval = BinomialInterval::new(IntervalKind::ClopperPearson, half_of_the_error(confidence));
    let differ = counts.only_first + counts.only_second;
    let (least, most) = interval.bounds(differ, counts.total());
    let (low, high) = interval.bounds(counts.only_first, differ);
    let [low, high] = [low, high].map(|first| 2.0 * first - 1.0);
    (low * if low > 0.0 { least } else { most }, high * if high > 0.0 { most } else { least })
}

/// The upper end of Tango's interval; the lower one is its mirror image.
///
/// Bisection of `n d - (b - c) - z sqrt(n variance)` between the observed difference, where it is not positive, and 1,
/// where the variance vanishes: some 80 steps of two square roots each.
fn score_limit(first: f64, second: f64, total: f64, z: f64) -> f64 {
    let observed = first - second;
    let (mut low, mut high) = (observed / total, 1.0);
    // Differences below a millionth of one sample's share are meaningless.
    while high - low > 1e-15 * f64::max(f64::max(low.abs(), high.abs()), 1e-6 / total) {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        let below = total * middle - observed < z * (total * score_variance(first, second, total, middle)).sqrt();
        if below {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The variance `2 q + d (1 - d)` of one pair's difference, where `q` is the maximum-likelihood probability of a pair
/// unstable only in the second if the difference of the probabilities is `d`:
///
/// ```text
/// 2 n q^2 + (-b - c + (2 n - b + c) d) q - c d (1 - d) = 0
/// ```
fn score_variance(first: f64, second: f64, total: f64, difference: f64) -> f64 {
    if difference < 0.0 {
        // With the roles exchanged the difference is positive, and nothing below cancels.
        return score_variance(second, first, total, -difference);
    }
    let spread = difference * (1.0 - difference);
    let linear = (2.0 * total - first + second) * difference - first - second;
    let root = (linear * linear + 8.0 * total * second * spread).sqrt();
    let q = if linear <= 0.0 { (root - linear) / (4.0 * total) } else { 2.0 * second * spread / (root + linear) };
    2.0 * q + spread
}

/// Newcombe's two-sided hybrid interval for the difference of two probabilities from independent samples (R. G.
/// Newcombe, Statistics in Medicine 17, 1998, p. 873, method 10). With the ends `l` and `u` of either probability's
/// interval it is
///
/// ```text
/// d - sqrt((p1 - l1)^2 + (u2 - p2)^2)   to   d + sqrt((u1 - p1)^2 + (p2 - l2)^2),      d = p1 - p2
/// ```
///
/// Up to a confidence of 95 % the ends `l` and `u` are Wilson's, as in Newcombe's paper; beyond, Clopper and Pearson's.
/// The interval is (-1, 1) if either has no samples.
///
/// ```
/// use stickslip_sampler::estimate::difference::unpaired_difference;
/// let difference = unpaired_difference(56, 70, 48, 80, 0.95);
/// assert!((difference.low - 0.0524).abs() < 5e-5 && (difference.high - 0.3339).abs() < 5e-5);
/// ```
#[must_use]
pub fn unpaired_difference(
    successes_first: u64,
    trials_first: u64,
    successes_second: u64,
    trials_second: u64,
    confidence: f64,
) -> Difference {
    let interval = BinomialInterval::new(IntervalKind::for_confidence(confidence), confidence);
    let share = |successes, trials| Share::estimate(successes, trials, &interval);
    let (Some(first), Some(second)) = (share(successes_first, trials_first), share(successes_second, trials_second))
    else {
        return Difference::UNKNOWN;
    };
    let length = |a: f64, b: f64| (a * a + b * b).sqrt();
    let value = first.value - second.value;
    Difference {
        value: Some(value),
        low: (value - length(first.value - first.low, second.high - second.value)).max(-1.0),
        high: (value + length(first.high - first.value, second.value - second.low)).min(1.0),
    }
}

/// The two-sided interval for the difference of two probabilities from samples that may depend on each other in any
/// way:
///
/// ```text
/// l1 - u2   to   u1 - l2
/// ```
///
/// with the ends `l` and `u` of Clopper and Pearson's intervals, each with half of the error. By Bonferroni's
/// inequality the coverage is at least the confidence. The interval is (-1, 1) if either has no samples.
#[must_use]
pub fn dependent_difference(
    successes_first: u64,
    trials_first: u64,
    successes_second: u64,
    trials_second: u64,
    confidence: f64,
) -> Difference {
    let interval = BinomialInterval::new(IntervalKind::ClopperPearson, half_of_the_error(confidence));
    let share = |successes, trials| Share::estimate(successes, trials, &interval);
    let (Some(first), Some(second)) = (share(successes_first, trials_first), share(successes_second, trials_second))
    else {
        return Difference::UNKNOWN;
    };
    Difference { value: Some(first.value - second.value), low: first.low - second.high, high: first.high - second.low }
}

/// An observed share with the ends of its interval.
struct Share {
    value: f64,
    low: f64,
    high: f64,
}

impl Share {
    /// `None` without trials.
    fn estimate(successes: u64, trials: u64, interval: &BinomialInterval) -> Option<Self> {
        let (low, high) = interval.bounds(successes, trials);
        (trials > 0).then(|| Self { value: successes as f64 / trials as f64, low, high })
    }
}

#[cfg(test)]
mod tests;
