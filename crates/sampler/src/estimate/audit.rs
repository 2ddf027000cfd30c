//! The audit of a verdict map: some of the looked-up samples are simulated as a check, and bound the share of wrong
//! verdicts among the others.

use std::ops::Range;

use rand::RngExt;
use stickslip_core::model::verdict::VerdictCounts;

use crate::draw::identity::{BLOCK_SAMPLES, Purpose, block_generator};
use crate::special_functions::beta;

/// Whether each sample of `range` is audited: a random choice of a `share` of them.
///
/// The choice is a pure function of the seed, the part and the number of the sample, independent of the samples'
/// inputs.
#[must_use]
pub fn choose(seed: u64, part: u64, range: Range<u64>, share: f64) -> Vec<bool> {
    let mut chosen = Vec::with_capacity((range.end - range.start) as usize);
    let mut next = range.start;
    while next < range.end {
        let block = next / BLOCK_SAMPLES;
        let mut generator = block_generator(seed, Purpose::Audit, part, block);
        let whole: Vec<bool> = (0..BLOCK_SAMPLES).map(|_| generator.random::<f64>() < share).collect();
        let end = range.end.min((block + 1) * BLOCK_SAMPLES);
        let first = (next - block * BLOCK_SAMPLES) as usize;
        chosen.extend_from_slice(&whole[first..first + (end - next) as usize]);
        next = end;
    }
    chosen
}

/// The share of wrong verdicts among the looked-up samples, at most, with the given one-sided confidence: Clopper and
/// Pearson's upper limit for `differed` out of `audited`. It is 1 without an audit.
///
/// ```
/// // The rule of three.
/// let bound = stickslip_sampler::estimate::audit::upper_bound(0, 1000, 0.95);
/// assert!((bound - 3.0 / 1000.0).abs() < 1e-5);
/// ```
#[must_use]
pub fn upper_bound(differed: u64, audited: u64, confidence: f64) -> f64 {
    if differed >= audited {
        return 1.0;
    }
    beta::upper_quantile(differed as f64 + 1.0, (audited - differed) as f64, 1.0 - confidence)
}

/// How probable it is at most that plain samples contradict a probability that is right.
const CONTRADICTION: f64 = 1e-6;

/// The confidence of the interval of a probability that plain samples are compared with. At 95 % one right estimate of
/// twenty misses by chance, and enough plain samples would tell; here the interval has half of the 1e-6 at which they contradict.
pub const COMPARED: f64 = 1.0 - 0.5 * CONTRADICTION;

/// How improbable counts of plain samples have to be at the end of that interval: few unstable ones and many share the rest.
const TAIL: f64 = 0.25 * CONTRADICTION;

/// Plain samples beside a probability that does not come from them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PlainSamples {
    /// Samples with a verdict.
    pub decided: u64,
    /// Unstable ones of them.
    pub unstable: u64,
}

impl From<VerdictCounts> for PlainSamples {
    fn from(counts: VerdictCounts) -> Self {
        Self { decided: counts.decided(), unstable: counts.unstable }
    }
}

impl PlainSamples {
    /// Whether they contradict a probability whose interval of the confidence [`COMPARED`] has these ends, or that has such
    /// bounds: at the nearest end, so few unstable ones or so many have a probability below 2.5e-7. A right probability is
    /// contradicted with a probability of at most 1e-6: that its interval misses has half of it, and each tail a quarter.
    #[must_use]
    pub fn contradict(&self, [low, high]: [f64; 2]) -> bool {
        let Self { decided, unstable } = *self;
        let at_most = || beta::binomial_at_most(unstable, decided, low);
        let at_least = || beta::binomial_at_least(unstable, decided, high);
        decided > 0 && (at_most() < TAIL || at_least() < TAIL)
    }

    /// The probability at most of what was missed, of instability or of stability, where a probability is said to lie between
    /// these bounds: with this one-sided confidence.
    #[must_use]
    pub fn largest_missed(&self, [low, high]: [f64; 2], confidence: f64) -> f64 {
        let Self { decided, unstable } = *self;
        let most = upper_bound(unstable, decided, confidence);
        let least = 1.0 - upper_bound(decided - unstable, decided, confidence);
        (most - low).max(high - least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::interval::{BinomialInterval, IntervalKind};

    #[test]
    fn the_choice_has_its_share_and_is_independent_of_the_range() {
        let whole = choose(7, 3, 0..200_000, 0.01);
        let chosen = whole.iter().filter(|&&chosen| chosen).count() as f64;
        assert!((chosen - 2000.0).abs() < 4.0 * 2000_f64.sqrt(), "{chosen}");
        for (from, to) in [(0, 1), (999, 1001), (1500, 150_000)] {
            assert_eq!(choose(7, 3, from..to, 0.01), whole[from as usize..to as usize]);
        }
        assert_ne!(choose(8, 3, 0..200_000, 0.01), whole);
        assert_ne!(choose(7, 4, 0..200_000, 0.01), whole);
        assert!(choose(7, 3, 0..5000, 0.0).iter().all(|&chosen| !chosen));
        assert!(choose(7, 3, 0..5000, 1.0).iter().all(|&chosen| chosen));
    }

    /// Of 300 samples, the first number of unstable ones beyond the bounds, by sums of binomial probabilities.
    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn counts_contradict_bounds_that_make_them_improbable() {
        let mass = |n: u32, k: u32, p: f64| {
            let choose = (0..k).fold(1.0, |product, i| product * f64::from(n - i) / f64::from(i + 1));
            choose * p.powi(k as i32) * (1.0 - p).powi((n - k) as i32)
        };
        let n = 300;
        for bounds in [[0.0, 0.0], [0.1, 0.1], [0.1, 0.3], [0.97, 1.0], [1.0, 1.0], [0.0, 1.0]] {
            for unstable in 0..=n {
                let below: f64 = (0..=unstable).map(|k| mass(n, k, bounds[0])).sum();
                let above: f64 = (unstable..=n).map(|k| mass(n, k, bounds[1])).sum();
                let samples = PlainSamples { decided: n.into(), unstable: unstable.into() };
                let expected = below < TAIL || above < TAIL;
                assert_eq!(samples.contradict(bounds), expected, "{unstable} of {n}: {bounds:?} {below} {above}");
            }
        }
        assert!(!PlainSamples::default().contradict([0.5, 0.5]));
        // Nothing of 1000: the rule of three, of instability beside 0 and of stability beside 1.
        for (unstable, bound) in [(0, 0.0), (1000, 1.0)] {
            let missed = PlainSamples { decided: 1000, unstable }.largest_missed([bound; 2], 0.95);
            assert!((missed - 2.991e-3).abs() < 1e-6, "{missed}");
        }
    }

    #[test]
    fn a_right_estimate_that_misses_by_chance_is_not_contradicted() {
        // A twentieth is unstable, of which 1000 samples found 32: 2.6 standard errors below, beyond the interval of 95 %.
        let interval =
            |confidence: f64| BinomialInterval::new(IntervalKind::ClopperPearson, confidence).bounds(32, 1000);
        let plain = PlainSamples { decided: 100_000, unstable: 5000 };
        let contradicted = |confidence: f64| plain.contradict(interval(confidence).into());
        assert_eq!([contradicted(0.95), contradicted(COMPARED)], [true, false]);
        // Twice as many are no chance.
        assert!(PlainSamples { decided: 100_000, unstable: 10_000 }.contradict(interval(COMPARED).into()));
    }

    #[test]
    fn the_bound_solves_its_definition() {
        // P(at most k of n) = 1 - confidence at the bound.
        for (k, n) in [(0_u32, 10_u32), (1, 10), (3, 50)] {
            let p = upper_bound(u64::from(k), u64::from(n), 0.95);
            let mut mass = (1.0 - p).powi(n as i32);
            let mut sum = 0.0;
            for i in 0..=k {
                sum += mass;
                mass *= f64::from(n - i) / f64::from(i + 1) * p / (1.0 - p);
            }
            assert!((sum - 0.05).abs() < 1e-12, "{k} of {n}: {sum}");
        }
        assert_eq!([upper_bound(0, 0, 0.95), upper_bound(5, 5, 0.95)], [1.0, 1.0]);
    }

    #[test]
    fn the_choice_is_drawn_for_the_audit_alone() {
        let by = |purpose: Purpose| -> Vec<bool> {
            let mut generator = block_generator(7, purpose, 3, 2);
            (0..BLOCK_SAMPLES).map(|_| generator.random::<f64>() < 0.5).collect()
        };
        let chosen = choose(7, 3, 2 * BLOCK_SAMPLES..3 * BLOCK_SAMPLES, 0.5);
        assert_eq!(chosen, by(Purpose::Audit));
        for purpose in [Purpose::Inputs, Purpose::CommonInputs, Purpose::Sensitivity, Purpose::Population] {
            assert_ne!(chosen, by(purpose), "{purpose:?}");
        }
    }
}
