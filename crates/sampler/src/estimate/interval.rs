//! Confidence intervals for a probability from counted verdicts.

use stickslip_core::model::verdict::VerdictCounts;

use crate::special_functions::{beta, normal};

/// An estimated probability of instability with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// `unstable / (stable + unstable)`; `None` if no sample was decided.
    pub probability: Option<f64>,
    /// Lower end, with every undecided and failed sample counted as stable.
    pub low: f64,
    /// Upper end, with every undecided and failed sample counted as unstable.
    pub high: f64,
}

/// Wilson's score interval for a binomial proportion (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927):
///
/// ```text
/// (p + z^2 / 2n -+ z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n),      p = k / n
/// ```
///
/// for `k` successes in `n` trials and the normal quantile `z`. It stays inside [0, 1] and has a positive width at `k =
/// 0` and `k = n` too.
#[derive(Debug, Clone, Copy, PartialEq)]
struct WilsonInterval {
    z: f64,
}

impl WilsonInterval {
    /// The interval with the given two-sided confidence, strictly between 0 and 1.
    fn new(confidence: f64) -> Self {
        Self { z: normal::upper_quantile(0.5 * (1.0 - confidence)) }
    }

    /// The ends for `successes` out of `trials`; (0, 1) without trials.
    fn bounds(&self, successes: u64, trials: u64) -> (f64, f64) {
        if trials == 0 {
            return (0.0, 1.0);
        }
        let failures = trials - successes;
        (self.lower(successes, failures), 1.0 - self.lower(failures, successes))
    }

    /// The lower end. The upper one is its mirror image, so that both are exact where they are 0 or 1.
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
}

/// The estimate from counted verdicts, by the `bounds` of successes and trials. A sample without a verdict could be
/// either: it counts as stable for the lower end and as unstable for the upper one.
fn estimate(counts: &VerdictCounts, bounds: impl Fn(u64, u64) -> (f64, f64)) -> Estimate {
    let (decided, total) = (counts.decided(), counts.total());
    let probability = (decided > 0).then(|| counts.unstable as f64 / decided as f64);
    let without_verdict = counts.without_verdict();
    let (low, _) = bounds(counts.unstable, total);
    let (_, high) = bounds(counts.unstable + without_verdict, total);
    Estimate { probability, low, high }
}

/// The kind of interval for a binomial proportion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IntervalKind {
    /// Wilson's score interval. Its coverage is the confidence on average over probabilities. Near 0 and 1 it is less:
    /// at 95 % at least 0.838 (at `n p` = 0.177, for large `n`), at 99.9 % at least 0.925.
    Wilson,
    /// Clopper and Pearson's exact interval. Its coverage is at least the confidence for every probability, and it is
    /// wider.
    ClopperPearson,
}

/// The highest confidence at which Wilson's interval is used: beyond, it misses several times as often as it claims.
pub const MOST_WILSON_CONFIDENCE: f64 = 0.95;

impl IntervalKind {
    /// The default for a confidence: Wilson's up to 95 %, Clopper and Pearson's beyond.
    #[must_use]
    pub fn for_confidence(confidence: f64) -> Self {
        if confidence > MOST_WILSON_CONFIDENCE { Self::ClopperPearson } else { Self::Wilson }
    }
}

/// A confidence interval for a binomial proportion, of either kind.
///
/// Wilson's interval (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927) for `k` successes in `n` trials and the normal
/// quantile `z` stays inside [0, 1] and has a positive width at `k = 0` and `k = n` too:
///
/// ```text
/// (p + z^2 / 2n -+ z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n),      p = k / n
/// ```
///
/// Clopper and Pearson's interval (Biometrika 26, 1934) has the ends at which the observed count or a more extreme one
/// has the probability `alpha / 2 = (1 - confidence) / 2`:
///
/// ```text
/// I_low(k, n - k + 1) = alpha / 2,      I_high(k + 1, n - k) = 1 - alpha / 2
/// ```
///
/// with `I_x(a, b)` the regularised incomplete beta function; they are 0 at `k = 0` and 1 at `k = n`. The ends are
/// computed with an error of about 1e-15 relative to their distance from 0 and from 1, for up to 1e10 trials.
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

    /// The ends for `successes` out of `trials`, all of them if they are more; (0, 1) without trials.
    #[must_use]
    pub fn bounds(&self, successes: u64, trials: u64) -> (f64, f64) {
        let successes = successes.min(trials);
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

/// The confidence `1 - (1 - c) / m` that each of `m` intervals needs so that all of them together contain their true
/// values with the confidence `c`.
///
/// By Bonferroni's inequality the probability that any of the intervals misses is at most the sum of their
/// probabilities to miss, however they depend on each other. For independent intervals `c^(1/m)` would suffice, which
/// is hardly less.
///
/// ```
/// let each = stickslip_sampler::estimate::interval::simultaneous_confidence(0.95, 50);
/// assert!((each - 0.999).abs() < 1e-15);
/// ```
#[must_use]
pub fn simultaneous_confidence(confidence: f64, intervals: u64) -> f64 {
    1.0 - (1.0 - confidence) / intervals.max(1) as f64
}

/// The confidence of each of two intervals that together hold with `confidence`: [`simultaneous_confidence`] of two.
#[must_use]
pub fn half_of_the_error(confidence: f64) -> f64 {
    0.5 + 0.5 * confidence
}

#[cfg(test)]
mod tests;
