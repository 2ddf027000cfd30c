//! The distribution of a quantity over samples, kept in integers so that the order of the samples has no
//! effect.

use std::collections::BTreeMap;

/// Low bits of a double that its bin ignores. 10 of the 52 bits of the fraction remain, so that a bin is at most 1/1024
/// of its values wide.
const DROPPED_BITS: u32 = 42;

/// Sums are kept in multiples of 2^-34, about 6e-11: much smaller values are lost.
const STEPS_PER_ONE: f64 = (1_u64 << 34) as f64;

/// Larger values count as this in sums, which cannot overflow then.
const LARGEST: f64 = (1_u64 << 40) as f64;

/// The bin number of negative values has this bit; without it, it is that of their opposite.
const SIGN: u32 = 1 << 21;

/// Mean and quantiles of a quantity of a size of about 1e-6 to 1e12. The order in which values and distributions are
/// added does not change a bit of the result.
///
/// ```
/// use stickslip_sampler::estimate::distribution::Distribution;
/// let mut values = Distribution::default();
/// (1..=1000).for_each(|i| values.add(1e-5 * f64::from(i)));
/// assert!((values.mean().unwrap() - 5.005e-3).abs() < 1e-9);
/// assert!((values.quantile(0.95).unwrap() / 9.5e-3 - 1.0).abs() < 1e-3);
/// ```
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Distribution {
    /// Sum of all values, in multiples of 2^-34.
    sum: i128,
    /// The number of values in each bin, by the leading bits of the value.
    bins: BTreeMap<u32, u64>,
}

impl Distribution {
    /// Whether a bin number is that of finite values.
    #[must_use]
    pub fn is_bin(bin: u32) -> bool {
        f64::from_bits(u64::from(bin) << DROPPED_BITS).is_finite() && bin < 2 * SIGN
    }

    /// A distribution from its sum ([`Distribution::sum`]) and its bins ([`Distribution::bins`]), each bin once.
    #[must_use]
    pub fn from_parts(sum: i128, bins: impl IntoIterator<Item = (u32, u64)>) -> Self {
        Self { sum, bins: bins.into_iter().collect() }
    }

    /// Whether its sum can be that of so many values.
    #[must_use]
    pub fn can_be(&self) -> bool {
        let most = (LARGEST * STEPS_PER_ONE) as u128;
        self.sum.unsigned_abs() <= most.saturating_mul(self.count().into())
    }

    /// Adds a value. NaN counts as 0.
    pub fn add(&mut self, value: f64) {
        // Zero has one sign.
        let value = if value.is_nan() { 0.0 } else { value + 0.0 };
        let steps = (value.abs().min(LARGEST) * STEPS_PER_ONE + 0.5) as i128;
        self.sum = self.sum.saturating_add(if value < 0.0 { -steps } else { steps });
        *self.bins.entry((value.to_bits() >> DROPPED_BITS) as u32).or_default() += 1;
    }

    /// Adds all values of another distribution.
    pub fn add_all(&mut self, other: &Self) {
        self.sum = self.sum.saturating_add(other.sum);
        for (bin, count) in &other.bins {
            let sum = self.bins.entry(*bin).or_default();
            *sum = sum.saturating_add(*count);
        }
    }

    /// The number of values.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.bins.values().fold(0, |sum: u64, count| sum.saturating_add(*count))
    }

    /// The sum of all values, in multiples of 2^-34.
    #[must_use]
    pub fn sum(&self) -> i128 {
        self.sum
    }

    /// Every bin that is not empty, with its number of values.
    pub fn bins(&self) -> impl Iterator<Item = (u32, u64)> + '_ {
        self.bins.iter().map(|(bin, count)| (*bin, *count))
    }

    /// The middle of every bin that is not empty, with its number of values, from the least to the greatest.
    pub fn middles(&self) -> impl Iterator<Item = (f64, u64)> + '_ {
        // From the negative values that are farthest from 0 to the largest positive one.
        let sorted = self.bins.range(SIGN..).rev().chain(self.bins.range(..SIGN));
        let edge = |bin: u32| f64::from_bits(u64::from(bin) << DROPPED_BITS);
        // What shares the bin of zero is below 1e-310.
        let middle = move |bin: u32| if bin & !SIGN == 0 { 0.0 } else { 0.5 * (edge(bin) + edge(bin + 1)) };
        sorted.map(move |(bin, count)| (middle(*bin), *count))
    }

    /// The mean; `None` without values.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        let count = self.count();
        (count > 0).then(|| self.sum as f64 / STEPS_PER_ONE / count as f64)
    }

    /// The value below which a share `p` of all values lies: the middle of its bin, with a relative error below 1/2000.
    /// `None` without values.
    #[must_use]
    pub fn quantile(&self, p: f64) -> Option<f64> {
        // The smallest value with at least this many at or below it.
        let rank = (p.clamp(0.0, 1.0) * self.count() as f64).ceil().max(1.0) as u64;
        let mut below = 0;
        let reaches = |(_, count): &(f64, u64)| {
            below += count;
            below >= rank
        };
        self.middles().find(reaches).map(|(value, _)| value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Positive values, values of either sign, and large negative ones.
    fn values() -> [Vec<f64>; 3] {
        let positive = || (1..5000_u32).map(|i| 0.02 / f64::from(i * 7919 % 5003));
        [positive().collect(), positive().map(|x| 1e-4 - x).collect(), positive().map(|x| -1e9 * x).collect()]
    }

    #[test]
    fn zeros_are_zeros() {
        let mut distribution = Distribution::default();
        [0.0, -0.0, 0.0, 2.0].into_iter().for_each(|value| distribution.add(value));
        assert_eq!(distribution.quantile(0.5), Some(0.0));
        assert_eq!(distribution.middles().next(), Some((0.0, 3)));
    }

    #[test]
    fn order_and_partition_have_no_effect() {
        for values in values() {
            let mut whole = Distribution::default();
            values.iter().for_each(|value| whole.add(*value));
            let mut parts = [const { Distribution { sum: 0, bins: BTreeMap::new() } }; 3];
            values.iter().rev().enumerate().for_each(|(i, value)| parts[i % 3].add(*value));
            let mut joined = Distribution::default();
            [2, 0, 1].iter().for_each(|&part: &usize| joined.add_all(&parts[part]));
            assert_eq!(whole, joined);
            assert!(whole.bins().all(|(bin, _)| Distribution::is_bin(bin)));
            assert_eq!(Distribution::from_parts(whole.sum(), whole.bins()), whole);
        }
    }

    #[test]
    fn mean_and_quantiles_are_those_of_the_values() {
        for mut sorted in values() {
            let mut distribution = Distribution::default();
            sorted.iter().for_each(|value| distribution.add(*value));
            sorted.sort_by(f64::total_cmp);
            assert_eq!(distribution.count(), sorted.len() as u64);
            let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
            let scale = sorted.iter().map(|value| value.abs()).fold(0.0, f64::max);
            assert!((distribution.mean().unwrap() - mean).abs() < 1e-10 + 1e-13 * scale);
            for p in [0.01, 0.05, 0.5, 0.95, 1.0] {
                let expected = sorted[((p * sorted.len() as f64).ceil() as usize).max(1) - 1];
                let found = distribution.quantile(p).unwrap();
                assert!((found / expected - 1.0).abs() < 1.0 / 2000.0, "{p}: {found} {expected}");
            }
        }
    }

    #[test]
    fn an_empty_distribution_has_no_mean() {
        let empty = Distribution::default();
        assert_eq!((empty.mean(), empty.quantile(0.5), empty.count()), (None, None, 0));
    }
}
