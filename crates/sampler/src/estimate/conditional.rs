//! The estimate from conditional probabilities at randomised Sobol points.
//!
//! Every point stands for all inputs but the two that are integrated over, and has the probability that a sample is
//! unstable given these ([`integrate::pair`](crate::integrate::pair)). Their mean is the probability of instability. Some points
//! lie [beyond](crate::draw::beyond) those of the distribution of the inputs, so that all points have weights `a` of at most 1,
//! and the mean is `sum a p / sum a`.
//!
//! Probabilities with their weights, and their squares are added as [whole numbers](super::fixed_point), so that a sum has the
//! same bits in any order.

use crate::draw::beyond::EACH;
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

/// Probabilities whose relative standard deviation is below this are alike: what the other inputs change in one region says nothing
/// of another one.
const ALIKE: f64 = 0.02;

/// The largest number of trials of which binomial tails are computed.
const MOST_TRIALS: f64 = 1e10;

/// Sums of points with a probability: of what they count for instability, of its squares, the same for stability, of the products
/// of both, and of the weights of points without a probability.
const SUMS: usize = 6;

/// The sums of conditional probabilities with their weights, as words.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ProbabilitySums([i64; ProbabilitySums::COUNT]);

impl ProbabilitySums {
    /// The number of words.
    pub const COUNT: usize = SUMS * WORDS;

    /// Adds a point of a weight of at most 1: its probability, `None` if there is no model with it.
    pub fn add(&mut self, weight: f64, probability: Option<f64>) {
        let unstable = weight * probability.unwrap_or(0.0);
        let stable = if probability.is_some() { (weight - unstable).max(0.0) } else { 0.0 };
        let failed = if probability.is_some() { 0.0 } else { weight };
        let added: [f64; SUMS] = [unstable, unstable * unstable, stable, stable * stable, unstable * stable, failed];
        for (words, number) in self.0.chunks_exact_mut(WORDS).zip(added) {
            add_words(words, number);
        }
    }

    /// The sums of the words.
    #[must_use]
    pub fn sums(&self) -> [i64; Self::COUNT] {
        self.0
    }

    /// Whether these can be the sums of so many samples, with the points [beyond](crate::draw::beyond) that belong to them.
    #[must_use]
    pub fn can_be(sums: &[i64], samples: u64) -> bool {
        if sums.len() < Self::COUNT {
            return false;
        }
        let of = |sum: usize| &sums[sum * WORDS..][..WORDS];
        let [unstable, stable, failed] = [0, 2, 5].map(|sum| number_of_unit(of(sum)));
        let points = samples as f64 + samples.div_ceil(EACH) as f64;
        let most = [points - stable - failed, unstable, points, stable, unstable.min(stable), points];
        most.into_iter().enumerate().all(|(sum, most)| can_be_sum(of(sum), most))
    }
}

/// What is known of the points of one randomisation.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ConditionalPart {
    /// Points, by their weights.
    pub points: f64,
    /// Those of them with which there is no model.
    pub failed: f64,
    /// The sum of what the others count for instability, weight times probability, and that of its squares.
    pub unstable: [f64; 2],
    /// The same for stability.
    pub stable: [f64; 2],
    /// The sum of the products of both.
    pub products: f64,
}

impl ConditionalPart {
    /// From the sums of [`ProbabilitySums`]; zero from none.
    #[must_use]
    pub fn from_sums(sums: &[i128]) -> Self {
        let of = |sum: usize| sums.get(sum * WORDS..(sum + 1) * WORDS).map_or(0.0, number);
        let (unstable, stable, failed) = ([of(0), of(1)], [of(2), of(3)], of(5));
        Self { points: unstable[0] + stable[0] + failed, failed, unstable, stable, products: of(4) }
    }

    /// Points that count 1 each: so many, those of them with which there is no model, the sum of the probabilities of the others
    /// and that of their squares.
    #[must_use]
    pub fn unweighted(points: u64, failed: u64, probabilities: f64, squares: f64) -> Self {
        let decided = points as f64 - failed as f64;
        Self {
            points: points as f64,
            failed: failed as f64,
            unstable: [probabilities, squares],
            stable: [decided - probabilities, decided - 2.0 * probabilities + squares],
            products: probabilities - squares,
        }
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
/// **Points that are all alike**, to 2 %, those beyond too, say nothing of a region that none of them met. The interval then allows
/// for a region of other probabilities, as large as Clopper and Pearson's for no success in as many points.
///
/// ```
/// use stickslip_sampler::estimate::conditional::{ConditionalPart, estimate};
/// let part = |p: f64| ConditionalPart::unweighted(1000, 0, 1000.0 * p, 1000.0 * p * p);
/// let estimate = estimate(&[part(1.0e-6), part(1.2e-6), part(1.1e-6)], 0.95);
/// assert!((estimate.probability.unwrap() - 1.1e-6).abs() < 1e-20);
/// assert!(estimate.low > 0.8e-6 && estimate.high < 1.4e-6);
/// ```
#[must_use]
pub fn estimate(parts: &[ConditionalPart], confidence: f64) -> Estimate {
    let parts: Vec<&ConditionalPart> = parts.iter().filter(|part| part.points > 0.0).collect();
    let sum = |of: fn(&ConditionalPart) -> f64| parts.iter().map(|part| of(part)).sum::<f64>();
    let (points, failed) = (sum(|part| part.points), sum(|part| part.failed));
    let (unstable, stable) = (sum(|part| part.unstable[0]), sum(|part| part.stable[0]));
    let squares = [sum(|part| part.unstable[1]), sum(|part| part.stable[1])];
    let products = sum(|part| part.products);
    // The sum of squares of what all points differ by from their weights times a mean.
    let scatter = |mean: f64| {
        let rest = 1.0 - mean;
        rest * rest * squares[0] - 2.0 * mean * rest * products + mean * mean * squares[1]
    };
    let decided = unstable + stable;
    let probability = (decided > 0.0).then(|| (unstable / decided).min(1.0));
    let binomial = binomial(unstable, unstable + failed, points, confidence);
    if parts.len() < 2 {
        return Estimate { probability, low: binomial.0, high: binomial.1 };
    }
    let sides = [effective_number(unstable, squares[0]), effective_number(stable, squares[1])];
    let matter = sides[0].min(sides[1]);
    let is_rare = matter < RARE[usize::from(confidence > MOST_WILSON_CONFIDENCE)];
    let independent = if matter < FEW {
        let mean = unstable / points;
        let variance = (scatter(mean) + mean * mean * failed).max(0.0);
        normal::upper_quantile(0.5 * (1.0 - confidence)) * variance.sqrt() / points
    } else {
        0.0
    };
    let interval = |with_failed: bool| {
        let failed = |part: &ConditionalPart| if with_failed { part.failed } else { 0.0 };
        let shares = parts.iter().map(|part| (part.unstable[0] + failed(part)) / part.points);
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
            let (from, to) = scaled_binomial(stable, sides[1], points, confidence);
            (1.0 - to - failed / points, 1.0 - from)
        };
        low = low.min(from);
        high = high.max(to);
    }
    let mean = unstable / decided;
    if scatter(mean) <= (ALIKE * mean) * (ALIKE * mean) * decided {
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
