//! The distribution of a positive quantity over samples, kept in integers so that no result depends on their order.

use std::collections::BTreeMap;

/// Bits of a double below those that choose its bin: 10 of the 52 of the fraction remain, so that a bin is at most
/// 1/1024 of its values wide.
const DROPPED_BITS: u32 = 42;

/// Sums are kept in units of 2^-34, some 6e-11: values far below are lost in them, and a sum beyond 10^9 stays there.
const UNITS: f64 = (1_u64 << 34) as f64;

/// Mean and quantiles of a positive quantity of ordinary size (some 1e-6 to 1e3). Adding values or whole distributions commutes, bit for bit.
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
    /// Sum of all values, in units of 2^-34.
    sum: u64,
    /// How many values fell into each bin, by the leading bits of the value.
    bins: BTreeMap<u32, u64>,
}

impl Distribution {
    /// Whether a bin can hold any finite value.
    #[must_use]
    pub fn is_bin(bin: u32) -> bool {
        f64::from_bits(u64::from(bin) << DROPPED_BITS).is_finite() && bin < 1 << 21
    }

    /// A distribution from its parts, see [`Distribution::sum`] and [`Distribution::bins`]; each bin once.
    #[must_use]
    pub fn from_parts(sum: u64, bins: impl IntoIterator<Item = (u32, u64)>) -> Self {
        Self { sum, bins: bins.into_iter().collect() }
    }

    /// Adds a value. Negative values and NaN count as 0.
    pub fn add(&mut self, value: f64) {
        let value = value.max(0.0);
        // A conversion to an integer saturates.
        self.sum = self.sum.saturating_add((value * UNITS + 0.5) as u64);
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

    /// How many values there are.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.bins.values().fold(0, |sum: u64, count| sum.saturating_add(*count))
    }

    /// The sum of all values, in units of 2^-34.
    #[must_use]
    pub fn sum(&self) -> u64 {
        self.sum
    }

    /// Every bin that is not empty, and how many values it has.
    pub fn bins(&self) -> impl Iterator<Item = (u32, u64)> + '_ {
        self.bins.iter().map(|(bin, count)| (*bin, *count))
    }

    /// The mean; `None` without values.
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        let count = self.count();
        (count > 0).then(|| self.sum as f64 / UNITS / count as f64)
    }

    /// The value below which a share `p` of all values lies, to one part in two thousand: the middle of its bin. `None`
    /// without values.
    #[must_use]
    pub fn quantile(&self, p: f64) -> Option<f64> {
        // The smallest value with at least this many at or below it.
        let rank = (p.clamp(0.0, 1.0) * self.count() as f64).ceil().max(1.0) as u64;
        let mut below = 0;
        for (bin, count) in &self.bins {
            below += count;
            if below >= rank {
                let edge = |bin: u32| f64::from_bits(u64::from(bin) << DROPPED_BITS);
                return Some(0.5 * (edge(*bin) + edge(bin + 1)));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values() -> Vec<f64> {
        (1..5000_u32).map(|i| 0.02 / f64::from(i * 7919 % 5003)).collect()
    }

    #[test]
    fn order_and_partition_do_not_matter() {
        let mut whole = Distribution::default();
        values().iter().for_each(|value| whole.add(*value));
        let mut parts = [const { Distribution { sum: 0, bins: BTreeMap::new() } }; 3];
        values().iter().rev().enumerate().for_each(|(i, value)| parts[i % 3].add(*value));
        let mut joined = Distribution::default();
        [2, 0, 1].iter().for_each(|&part: &usize| joined.add_all(&parts[part]));
        assert_eq!(whole, joined);
        assert_eq!(Distribution::from_parts(whole.sum(), whole.bins()), whole);
    }

    #[test]
    fn mean_and_quantiles_are_those_of_the_values() {
        let mut sorted = values();
        let mut distribution = Distribution::default();
        sorted.iter().for_each(|value| distribution.add(*value));
        sorted.sort_by(f64::total_cmp);
        assert_eq!(distribution.count(), sorted.len() as u64);
        let mean = sorted.iter().sum::<f64>() / sorted.len() as f64;
        assert!((distribution.mean().unwrap() - mean).abs() < 1e-10);
        for p in [0.01, 0.05, 0.5, 0.95, 1.0] {
            let expected = sorted[((p * sorted.len() as f64).ceil() as usize).max(1) - 1];
            let found = distribution.quantile(p).unwrap();
            assert!((found / expected - 1.0).abs() < 1.0 / 2000.0, "{p}: {found} {expected}");
        }
    }

    #[test]
    fn nothing_has_no_mean() {
        let nothing = Distribution::default();
        assert_eq!((nothing.mean(), nothing.quantile(0.5), nothing.count()), (None, None, 0));
    }
}
