//! The estimate from conditional probabilities at randomised Sobol points.
//!
//! Every point stands for all inputs but the two that are integrated over, and has the probability that a sample is
//! unstable given these ([`integrate::pair`](crate::integrate::pair)). Their mean is the probability of instability.
//!
//! Conditional probabilities and their squares are added as [whole numbers](super::fixed_point), so that a sum has the
//! same bits in any order.

use crate::estimate::fixed_point::{add_words, can_be_sum, number, number_of_unit};
use crate::estimate::interval::{Estimate, MOST_WILSON_CONFIDENCE};
use crate::estimate::randomisations::student;
use crate::special_functions::{beta, normal};

/// Words of a sum: a probability of 1e-30 still has digits.
const WORDS: usize = 4;

/// Where fewer points matter than this, the scatter of a few randomisations may be smaller than their error.
const FEW: f64 = 1000.0;

/// Where fewer points matter than this, no scatter shows the error, but their number does. The second number applies
/// beyond a confidence of 95 %.
const RARE: [f64; 2] = [200.0, 600.0];

/// Where fewer points matter than this, their number says nothing either.
const FEWEST: f64 = 20.0;

/// The share of the effective number of points that counts as successes.
const QUARTER: f64 = 0.25;

/// Probabilities whose relative standard deviation is below this are alike.
const ALIKE: f64 = 1e-6;

/// The largest number of trials of which binomial tails are computed.
const MOST_TRIALS: f64 = 1e10;

/// The sums of conditional probabilities and of their squares, as words.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ProbabilitySums([i64; ProbabilitySums::COUNT]);

impl ProbabilitySums {
    /// The number of sums.
    pub const COUNT: usize = 2 * WORDS;

    /// Adds a probability, and its square.
    pub fn add(&mut self, probability: f64) {
        let (first, second) = self.0.split_at_mut(WORDS);
        add_words(first, probability);
        add_words(second, probability * probability);
    }

    /// The sums of the words.
    #[must_use]
    pub fn sums(&self) -> [i64; Self::COUNT] {
        self.0
    }

    /// Whether these can be the sums of so many samples, whose probabilities are at most 1.
    #[must_use]
    pub fn can_be(sums: &[i64], decided: u64) -> bool {
        let Some((probabilities, squares)) = sums.split_at_checked(WORDS) else { return false };
        can_be_sum(probabilities, decided as f64) && can_be_sum(squares, number_of_unit(probabilities))
    }
}

/// What is known of the points of one randomisation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ConditionalPart {
    /// Points.
    pub points: u64,
    /// Those of them with which there is no model.
    pub failed: u64,
    /// The sum of the probabilities of the others.
    pub probabilities: f64,
    /// The sum of their squares.
    pub squares: f64,
}

impl ConditionalPart {
    /// From the sums of [`ProbabilitySums`]; zero from none.
    #[must_use]
    pub fn from_sums(points: u64, failed: u64, sums: &[i128]) -> Self {
        let of = |from: usize| sums.get(from..from + WORDS).map_or(0.0, number);
        Self { points, failed, probabilities: of(0), squares: of(WORDS) }
    }
}

/// The mean of conditional probabilities, with Student's interval from the scatter of the randomisations.
///
/// Points with which there is no model count as stable for the low end and as unstable for the high one. The half width
/// `h` of the interval is that of the logarithms of `p` and of `1 - p` too, `p exp(h / p)` being the higher end: small
/// probabilities are skew.
///
/// **Few points that matter.** Student's interval needs a probability to which many points contribute. Their effective
/// number is `(sum p)^2 / sum p^2` (L. Kish, Survey Sampling, 1965), the count of unstable points if all probabilities
/// are 0 or 1. It is taken of the unstable or of the stable side, whichever is smaller.
///
/// * Below 1000 the interval is at least as wide as that of independent points.
/// * Below 200 (600 beyond a confidence of 95 %) it includes Clopper and Pearson's for a quarter of the effective number of
///   successes, scaled to the probability. The quarter was found by simulation (`make coverage`): large probabilities that
///   no point has met are missing in the effective number.
/// * Below 20 it includes Clopper and Pearson's for as many independent samples: of all variables between 0 and 1 with the
///   same mean, verdicts scatter most.
///
/// **Points that are all alike** say nothing of a region that none of them met. The interval then allows for a region of other
/// probabilities, as large as Clopper and Pearson's for no success in as many points.
///
/// ```
/// use stickslip_sampler::estimate::conditional::{ConditionalPart, estimate};
/// let part = |p: f64| ConditionalPart { points: 1000, failed: 0, probabilities: 1000.0 * p, squares: 1000.0 * p * p };
/// let estimate = estimate(&[part(1.0e-6), part(1.2e-6), part(1.1e-6)], 0.95);
/// assert!((estimate.probability.unwrap() - 1.1e-6).abs() < 1e-20);
/// assert!(estimate.low > 0.8e-6 && estimate.high < 1.4e-6);
/// ```
#[must_use]
pub fn estimate(parts: &[ConditionalPart], confidence: f64) -> Estimate {
    let parts: Vec<&ConditionalPart> = parts.iter().filter(|part| part.points > 0).collect();
    let sum = |of: fn(&ConditionalPart) -> f64| parts.iter().map(|part| of(part)).sum::<f64>();
    let points = sum(|part| part.points as f64);
    let failed = sum(|part| part.failed as f64);
    let (unstable, squares) = (sum(|part| part.probabilities), sum(|part| part.squares));
    let decided = points - failed;
    let probability = (decided > 0.0).then(|| (unstable / decided).min(1.0));
    let binomial = binomial(unstable, unstable + failed, points, confidence);
    if parts.len() < 2 {
        return Estimate { probability, low: binomial.0, high: binomial.1 };
    }
    let sides = [
        effective_number(unstable, squares),
        // The squares of 1 - p.
        effective_number(decided - unstable, decided - 2.0 * unstable + squares),
    ];
    let matter = sides[0].min(sides[1]);
    let is_rare = matter < RARE[usize::from(confidence > MOST_WILSON_CONFIDENCE)];
    let independent = if matter < FEW {
        let variance = (squares / points - (unstable / points) * (unstable / points)).max(0.0);
        normal::upper_quantile(0.5 * (1.0 - confidence)) * (variance / points).sqrt()
    } else {
        0.0
    };
    let interval = |with_failed: bool| {
        let failed = |part: &ConditionalPart| if with_failed { part.failed as f64 } else { 0.0 };
        let shares = parts.iter().map(|part| (part.probabilities + failed(part)) / part.points as f64);
        let (mean, half_width) = student(&shares.collect::<Vec<_>>(), confidence);
        let half_width = half_width.max(independent);
        if is_rare { (mean - half_width, mean + half_width) } else { around(mean.min(1.0), half_width) }
    };
    let (mut low, mut high) = (interval(false).0, interval(true).1);
    if is_rare {
        let (from, to) = if matter < FEWEST {
            binomial
        } else if sides[0] <= sides[1] {
            let (from, to) = scaled_binomial(unstable, sides[0], points, confidence);
            (from, to + failed / points)
        } else {
            let (from, to) = scaled_binomial(decided - unstable, sides[1], points, confidence);
            (1.0 - to - failed / points, 1.0 - from)
        };
        low = low.min(from);
        high = high.max(to);
    }
    let mean = unstable / decided;
    if squares / decided - mean * mean <= (ALIKE * mean) * (ALIKE * mean) {
        let (_, unmet) = self::binomial(0.0, 0.0, points, confidence);
        low = low.min(mean * (1.0 - unmet));
        high = high.max(mean + unmet * (1.0 - mean));
    }
    Estimate { probability, low: low.max(0.0), high: high.min(1.0) }
}

/// The effective number of numbers with this sum and this sum of squares.
pub(crate) fn effective_number(sum: f64, squares: f64) -> f64 {
    if squares > 0.0 { sum * sum / squares } else { 0.0 }
}

/// The interval of a quarter of an effective number of successes, scaled to the share that their sum is of the trials.
fn scaled_binomial(sum: f64, effective: f64, trials: f64, confidence: f64) -> (f64, f64) {
    let successes = QUARTER * effective;
    let (low, high) = binomial(successes, successes, trials, confidence);
    (low * (sum / successes), high * (sum / successes))
}

/// The ends at a distance from a probability, or at the same distance by its logarithm, whichever is farther.
pub(super) fn around(mean: f64, half_width: f64) -> (f64, f64) {
    let above = |mean: f64| if mean > 0.0 { mean * libm::exp(half_width / mean) } else { half_width };
    (1.0 - above(1.0 - mean), above(mean))
}

/// Clopper and Pearson's interval for successes, which need not be whole, out of trials: the low end for the first
/// number of them, the high one for the second.
pub(super) fn binomial(at_least: f64, at_most: f64, trials: f64, confidence: f64) -> (f64, f64) {
    if !(trials > 0.0 && trials.is_finite()) || at_least.is_nan() || at_most.is_nan() {
        return (0.0, 1.0);
    }
    // Sums that are read may be forged. Those that were rounded stay as they are.
    let [at_least, at_most] = [at_least, at_most].map(|count| count.clamp(0.0, trials + 0.5));
    let scale = (MOST_TRIALS / trials).min(1.0);
    let [at_least, at_most, trials] = [at_least, at_most, trials].map(|count| count * scale);
    let tail = 0.5 * (1.0 - confidence);
    // Less than one success does not distinguish a probability from zero.
    let low = if at_least < 1.0 { 0.0 } else { beta::quantile(at_least, trials - at_least + 1.0, tail) };
    let failures = trials - at_most;
    let high = if failures < 0.01 { 1.0 } else { beta::upper_quantile(at_most + 1.0, failures, tail) };
    (low, high)
}

#[cfg(test)]
mod tests;
