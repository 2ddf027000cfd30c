//! The estimate from weighted samples of rare events.
//!
//! A sample that is drawn with another density than that of the inputs counts `w g`: `g` is 1 if it is unstable, 0 if not,
//! or the probability given the sample, and `w` is the ratio of the densities ([`Proposal`](crate::rare::proposal)). The
//! mean over all samples is the probability of instability. The sums are [whole numbers](super::fixed_point).

use crate::estimate::conditional::{around, binomial, effective_number};
use crate::estimate::fixed_point::{add_words, can_be_sum, number};
use crate::estimate::groups::{half_width, significance};
use crate::estimate::interval::Estimate;
use crate::estimate::randomisations::student;
use crate::special_functions::normal;

/// The largest weight, which sums are scaled by.
pub const MOST_WEIGHT: f64 = 8.0;

/// Words of the sums of contributions, of their squares, and of the other sums: a contribution of 1e-60 still has digits.
const WORDS: [usize; 4] = [8, 17, 4, 4];

/// Counts behind the words: samples from the distribution of the inputs, evaluations, contributions above zero, and samples
/// that are of stability.
const COUNTS: usize = 4;

/// Where the sums begin.
const STARTS: [usize; 5] =
    [0, WORDS[0], WORDS[0] + WORDS[1], WORDS[0] + WORDS[1] + WORDS[2], WORDS[0] + WORDS[1] + WORDS[2] + WORDS[3]];

/// The high end of a probability all of whose contributions are below the last digit.
const NEXT_TO_NOTHING: f64 = 1e-60;

/// The effective number of samples below which an estimate is not trusted.
const LEAST_EFFECTIVE: f64 = 100.0;

/// Where fewer samples matter than this, the interval is at least as wide as that of independent samples.
const FEW: f64 = 300.0;

/// The number of samples with most of the sum of squares below which an estimate from few samples is not trusted: its
/// variance is not known then.
const LEAST_DECISIVE: f64 = 20.0;

/// The significance at which the groups of randomisations differ so much that the estimate is not trusted.
const DISAGREEMENT: f64 = 1e-4;

/// The share of unstable samples from which on the samples that populations tried at first count.
const FREQUENT: f64 = 0.05;

/// The relative standard deviation of the estimates of populations above which their mean is not trusted.
const MOST_SCATTER: f64 = 1.0;

/// What the samples of a part are of: the rarer of both, so that either has all digits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Event {
    /// `g` is that of instability.
    #[default]
    Instability,
    /// `g` is 1 less that of instability.
    Stability,
}

impl Event {
    /// `g` of this event, from that of instability.
    #[must_use]
    pub fn value(self, of_instability: f64) -> f64 {
        match self {
            Self::Instability => of_instability,
            Self::Stability => 1.0 - of_instability,
        }
    }

    /// A limit state of this event, from that of instability.
    #[must_use]
    pub fn limit_state(self, of_instability: f64) -> f64 {
        match self {
            Self::Instability => of_instability,
            Self::Stability => -of_instability,
        }
    }

    fn count(self, samples: i64) -> i64 {
        if self == Self::Stability { samples } else { 0 }
    }
}

/// The sums of weighted samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WeightedSums([i64; WeightedSums::COUNT]);

impl Default for WeightedSums {
    fn default() -> Self {
        Self([0; Self::COUNT])
    }
}

impl WeightedSums {
    /// The number of sums: of the contributions, their squares, the weights of samples without a verdict, and the
    /// `g` of samples that are drawn from the distribution of the inputs; the number of these, the number of evaluations,
    /// the number of contributions above zero, and the number of samples of stability.
    pub const COUNT: usize = STARTS[4] + COUNTS;

    /// Adds a sample: its weight, its `g` of an event, which is `None` without a verdict, and whether it was drawn from the
    /// distribution of the inputs.
    pub fn add(&mut self, weight: f64, value: Option<f64>, is_of_inputs: bool, event: Event) {
        let [contributions, squares, without, of_inputs, numbers] = split(&mut self.0);
        let contribution = weight * value.unwrap_or(0.0) / MOST_WEIGHT;
        add_words(contributions, contribution);
        add_words(squares, contribution * contribution);
        if value.is_none() {
            add_words(without, weight / MOST_WEIGHT);
        }
        if is_of_inputs {
            // Without a verdict it may be unstable.
            add_words(of_inputs, value.unwrap_or(1.0));
            numbers[0] += 1;
        }
        numbers[1] += 1;
        numbers[2] += i64::from(contribution > 0.0);
        numbers[3] += event.count(1);
    }

    /// Adds a population: the probability of its event, that of a sample without a verdict, and the samples of the
    /// distribution of the inputs that it tried, with the sum of their `g`.
    pub fn add_population(&mut self, probability: f64, without_verdict: f64, tried: [f64; 2], event: Event) {
        self.add(probability, Some(1.0), false, event);
        let [_, _, without, of_inputs, numbers] = split(&mut self.0);
        add_words(without, without_verdict.min(1.0) / MOST_WEIGHT);
        let [count, sum] = tried;
        add_words(of_inputs, sum);
        numbers[0] += count as i64;
        numbers[1] -= 1;
    }

    /// Adds evaluations that are no samples.
    pub fn add_evaluations(&mut self, evaluations: u64) {
        self.0[STARTS[4] + 1] += evaluations.cast_signed();
    }

    /// The sums.
    #[must_use]
    pub fn sums(&self) -> [i64; Self::COUNT] {
        self.0
    }

    /// Whether these can be the sums of so many samples, or of so many `populations`, each of which has tried any number.
    #[must_use]
    pub fn can_be(sums: &[i64], samples: u64, populations: bool) -> bool {
        let Ok(mut sums) = <[i64; Self::COUNT]>::try_from(sums) else { return false };
        let numbers: [i64; COUNTS] = std::array::from_fn(|i| sums[STARTS[4] + i]);
        if numbers.iter().any(|number| *number < 0) {
            return false;
        }
        let [of_inputs, _, contributing, of_stability] = numbers.map(i64::cast_unsigned);
        let part = WeightedPart::from_sums(samples, &sums.map(i128::from));
        let [contributions, squares, without, of_inputs_sums, _] = split(&mut sums);
        (populations || of_inputs <= samples)
            && contributing.max(of_stability) <= samples
            && can_be_sum(contributions, samples as f64)
            && can_be_sum(squares, part.contributions / MOST_WEIGHT)
            && can_be_sum(without, samples as f64)
            && can_be_sum(of_inputs_sums, of_inputs as f64)
    }
}

fn split(sums: &mut [i64; WeightedSums::COUNT]) -> [&mut [i64]; 5] {
    let (contributions, rest) = sums.split_at_mut(WORDS[0]);
    let (squares, rest) = rest.split_at_mut(WORDS[1]);
    let (without, rest) = rest.split_at_mut(WORDS[2]);
    let (of_inputs, numbers) = rest.split_at_mut(WORDS[3]);
    [contributions, squares, without, of_inputs, numbers]
}

/// What is known of the samples of one randomisation, or of one population.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct WeightedPart {
    /// Samples; populations count one each.
    pub samples: f64,
    /// The sum of `w g`.
    pub contributions: f64,
    /// The sum of its squares.
    pub squares: f64,
    /// The sum of `w` of samples without a verdict.
    pub without_verdict: f64,
    /// Samples drawn from the distribution of the inputs, and the sum of their `g`, 1 without a verdict.
    pub of_inputs: [f64; 2],
    /// Values of `g` that were computed, also those by which the density of the samples was found.
    pub evaluations: f64,
    /// Samples that contribute.
    pub contributing: f64,
    /// Samples of [`Event::Stability`], all or none.
    pub of_stability: f64,
}

impl WeightedPart {
    /// From the sums of [`WeightedSums`].
    #[must_use]
    pub fn from_sums(samples: u64, sums: &[i128]) -> Self {
        let of = |i: usize| sums.get(STARTS[i]..STARTS[i + 1]).map_or(0.0, number);
        let count = |i: usize| sums.get(STARTS[4] + i).map_or(0.0, |&sum| sum as f64);
        Self {
            samples: samples as f64,
            contributions: MOST_WEIGHT * of(0),
            squares: MOST_WEIGHT * MOST_WEIGHT * of(1),
            without_verdict: MOST_WEIGHT * of(2),
            of_inputs: [count(0), of(3)],
            evaluations: count(1),
            contributing: count(2),
            of_stability: count(3),
        }
    }

    fn is_of_stability(&self) -> bool {
        self.of_stability > 0.0
    }

    /// The same samples as those of instability. Digits of a small probability of stability are lost.
    fn of_instability(&self) -> Self {
        if !self.is_of_stability() {
            return *self;
        }
        let Self { samples, contributions, squares, without_verdict, of_inputs: [count, stable], .. } = *self;
        Self {
            contributions: (samples - contributions - without_verdict).max(0.0),
            squares: (samples - 2.0 * contributions + squares).max(0.0),
            of_inputs: [count, count - stable],
            contributing: samples,
            of_stability: 0.0,
            ..*self
        }
    }
}

/// The estimate of instability, from that of the event of the parts: of stability if all are of it.
fn of_event(parts: &[WeightedPart], estimate: impl Fn(&[WeightedPart]) -> WeightedEstimate) -> WeightedEstimate {
    if parts.is_empty() || !parts.iter().all(WeightedPart::is_of_stability) {
        return estimate(&parts.iter().map(WeightedPart::of_instability).collect::<Vec<_>>());
    }
    let found = estimate(parts);
    let sum = |of: fn(&WeightedPart) -> f64| parts.iter().map(of).sum::<f64>();
    let without = sum(|part| part.without_verdict) / sum(|part| part.samples);
    let complement = |stable: f64| (1.0 - stable - without).max(0.0);
    let Estimate { probability, low, high } = found.estimate;
    let estimate = Estimate { probability: probability.map(complement), low: 1.0 - high, high: 1.0 - low };
    WeightedEstimate { estimate, mean: complement(found.mean), ..found }
}

/// Why an estimate is not trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Distrust {
    /// Nothing unstable was found, or, where instability is frequent, nothing stable.
    NothingFound,
    /// Few samples have most of the probability.
    FewSamples,
    /// Randomisations whose samples were placed independently disagree.
    Disagreement,
    /// Samples without a verdict are more probable than unstable ones.
    WithoutVerdict,
}

/// The probability with its interval, and whether it is trusted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WeightedEstimate {
    /// Without a probability if it is not trusted. The interval is then that of the samples drawn from the distribution
    /// of the inputs.
    pub estimate: Estimate,
    /// The mean, also if it is not to be trusted.
    pub mean: f64,
    /// The effective number of samples `(sum w g)^2 / sum (w g)^2`.
    pub effective: f64,
    /// Values of `g` that were computed.
    pub evaluations: f64,
    /// Why it is not trusted.
    pub distrust: Option<Distrust>,
}

/// The mean of weighted samples, with Student's interval from the scatter of the randomisations, within and between
/// [groups](super::groups), at its higher end by the logarithm where that is wider.
///
/// Randomisation `r` belongs to group `r` modulo `groups`. The samples of each group were placed independently. If the
/// groups differ with a significance of 1e-4 (analysis of variance), the estimate is not trusted, as some have missed a
/// region. Nor is it with an effective number of samples below 100, or below 300 if fewer than 20 of them have most of the variance.
///
/// Where instability is frequent, parts are of stability, and 1 less the probability has as many digits. Samples without a
/// verdict count as stable for the low end and as unstable for the high one. A probability below some
/// 1e-70, of which the sums have no digits, is given as 0 with a high end of 1e-60 if 100 samples contribute.
#[must_use]
pub fn estimate(parts: &[WeightedPart], groups: usize, confidence: f64) -> WeightedEstimate {
    of_event(parts, |parts| estimate_of_samples(parts, groups, confidence))
}

/// The estimate of the event of the parts.
fn estimate_of_samples(parts: &[WeightedPart], groups: usize, confidence: f64) -> WeightedEstimate {
    let sum = |of: &dyn Fn(&WeightedPart) -> f64| parts.iter().map(of).sum::<f64>();
    let (total, squares) = (sum(&|part| part.contributions), sum(&|part| part.squares));
    let (samples, without) = (sum(&|part| part.samples), sum(&|part| part.without_verdict));
    let effective = effective_number(total, squares);
    let contributing = sum(&|part| part.contributing);
    let is_complete = parts.len() >= 2 && parts.iter().all(|part| part.samples > 0.0);
    let shares: Vec<f64> = parts.iter().map(|part| part.contributions / part.samples).collect();
    let evaluations = sum(&|part| part.evaluations);
    if total <= 0.0 && contributing >= LEAST_EFFECTIVE && without <= 0.0 && is_complete {
        let estimate = Estimate { probability: Some(0.0), low: 0.0, high: NEXT_TO_NOTHING };
        return WeightedEstimate { estimate, mean: 0.0, effective: contributing, evaluations, distrust: None };
    }
    let distrust = if total <= 0.0 {
        Some(Distrust::NothingFound)
    } else if effective < LEAST_EFFECTIVE
        || !is_complete
        || (effective < FEW && decisive_samples(parts) < LEAST_DECISIVE)
    {
        Some(Distrust::FewSamples)
    } else {
        (significance(&shares, groups) < DISAGREEMENT).then_some(Distrust::Disagreement)
    };
    if distrust.is_some() {
        let [count, unstable] = [0, 1].map(|i| sum(&|part| part.of_inputs[i]));
        let (low, high) = binomial(0.0, unstable, count, confidence);
        let estimate = Estimate { probability: None, low, high };
        return WeightedEstimate { estimate, mean: total / samples, effective, evaluations, distrust };
    }
    let independent = if effective < FEW {
        let variance = (squares / samples - (total / samples) * (total / samples)).max(0.0);
        normal::upper_quantile(0.5 * (1.0 - confidence)) * (variance / samples).sqrt()
    } else {
        0.0
    };
    let reach = |shares: &[f64]| half_width(shares, groups, confidence).max(independent);
    let (mean, with_failed) = (total / samples, (total + without) / samples);
    let highest: Vec<f64> =
        parts.iter().map(|part| (part.contributions + part.without_verdict) / part.samples).collect();
    let low = below(mean.min(1.0), reach(&shares));
    let high = around(with_failed.min(1.0), reach(&highest)).1;
    let estimate = Estimate { probability: Some(mean.min(1.0)), low: low.max(0.0), high: high.min(1.0) };
    WeightedEstimate { estimate, mean, effective, evaluations, distrust }
}

/// About how many samples have most of the sum of squares, from how unevenly the randomisations share it. Where these are
/// few, the variance itself is known badly, and is likely to come out too small (A. B. Owen, Monte Carlo theory, methods and
/// examples, 2013, section 9.3).
fn decisive_samples(parts: &[WeightedPart]) -> f64 {
    let means = || parts.iter().map(|part| part.squares / part.samples);
    let randomisations = effective_number(means().sum(), means().map(|mean| mean * mean).sum());
    1.0 / (1.0 / randomisations - 1.0 / parts.len() as f64).max(0.0)
}

/// The mean of the estimates of independent populations. Their logarithms are about normal, and the interval is the one
/// that includes Student's and Cox's for the mean of a lognormal variable (C. E. Land, Technometrics 14 (1972) 145-158),
///
/// ```text
/// ln P = m + s^2 / 2 -+ t sqrt(s^2 / R + s^4 / (2 (R - 1)))
/// ```
///
/// with mean `m` and standard deviation `s` of the `R` logarithms. It is not trusted if the relative standard deviation of
/// the estimates is above 1, if some populations found nothing, or if samples without a verdict are more probable than
/// unstable ones. These count as stable for the low end and as unstable for the high one. Where instability is frequent, the
/// interval includes Clopper and Pearson's for the samples that the populations tried at first.
#[must_use]
pub fn estimate_of_populations(parts: &[WeightedPart], confidence: f64) -> WeightedEstimate {
    of_event(parts, |parts| mean_of_populations(parts, confidence))
}

/// The estimate of the event of the parts.
fn mean_of_populations(parts: &[WeightedPart], confidence: f64) -> WeightedEstimate {
    let complete = || parts.iter().filter(|part| part.samples > 0.0);
    let shares: Vec<f64> = complete().map(|part| part.contributions).collect();
    let highest: Vec<f64> = complete().map(|part| part.contributions + part.without_verdict).collect();
    let count = shares.len() as f64;
    let mean = shares.iter().sum::<f64>() / count.max(1.0);
    let scatter =
        (shares.iter().map(|share| (share - mean) * (share - mean)).sum::<f64>() / (count - 1.0).max(1.0)).sqrt();
    let evaluations = parts.iter().map(|part| part.evaluations).sum();
    let contributing: f64 = parts.iter().map(|part| part.contributing).sum();
    let without: f64 = parts.iter().map(|part| part.without_verdict).sum();
    if mean <= 0.0 && without <= 0.0 && count >= 2.0 && contributing >= count {
        let estimate = Estimate { probability: Some(0.0), low: 0.0, high: NEXT_TO_NOTHING };
        return WeightedEstimate { estimate, mean, effective: contributing, evaluations, distrust: None };
    }
    let distrust = if without > mean * count {
        Some(Distrust::WithoutVerdict)
    } else if mean <= 0.0 {
        Some(Distrust::NothingFound)
    } else if shares.len() < 2 {
        Some(Distrust::FewSamples)
    } else {
        let is_apart = scatter > MOST_SCATTER * mean || shares.iter().any(|share| *share <= 0.0);
        is_apart.then_some(Distrust::Disagreement)
    };
    let estimate = if distrust.is_some() {
        Estimate { probability: None, low: 0.0, high: 1.0 }
    } else {
        let (from, to) = (of_lognormal(&shares, confidence).0, of_lognormal(&highest, confidence).1);
        let with_failed = (mean + without / count).min(1.0);
        let mut low = below(mean, student(&shares, confidence).1).min(from);
        let mut high = around(with_failed, student(&highest, confidence).1).1.max(to);
        let [tried, unstable] = [0, 1].map(|i| parts.iter().map(|part| part.of_inputs[i]).sum::<f64>());
        if unstable > FREQUENT * tried {
            let (from, to) = binomial(unstable, unstable, tried, confidence);
            (low, high) = (low.min(from), high.max(to));
        }
        Estimate { probability: Some(mean.min(1.0)), low: low.max(0.0), high: high.min(1.0) }
    };
    let squares = shares.iter().map(|share| share * share).sum();
    let effective = effective_number(mean * count, squares);
    WeightedEstimate { estimate, mean, effective, evaluations, distrust }
}

/// Cox's interval for the mean of a lognormal variable.
fn of_lognormal(values: &[f64], confidence: f64) -> (f64, f64) {
    let logarithms: Vec<f64> = values.iter().map(|value| libm::log(*value)).collect();
    let (mean, of_mean) = student(&logarithms, confidence);
    let count = logarithms.len() as f64;
    let degrees = count - 1.0;
    let variance = logarithms.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>() / degrees;
    if variance <= 0.0 {
        return (values[0], values[0]);
    }
    // Student's half width is t s / sqrt(R).
    let half_width = of_mean * (1.0 + 0.5 * variance * count / degrees).sqrt();
    let middle = mean + 0.5 * variance;
    (libm::exp(middle - half_width), libm::exp(middle + half_width))
}

/// The low end at a distance from a probability; of a small one the complement would have no digits.
fn below(mean: f64, half_width: f64) -> f64 {
    if mean < 0.5 { mean - half_width } else { around(mean.min(1.0), half_width).0 }
}

#[cfg(test)]
mod tests;
