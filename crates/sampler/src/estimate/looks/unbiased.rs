//! The unbiased estimate of a probability after sequential looks.

use stickslip_core::model::verdict::VerdictCounts;

/// The expected share of unstable samples at the first look with decided samples, given the counts at the stop and that
/// no earlier look stopped. `None` if no sample is decided.
///
/// `counts` holds the counts up to each look, the last being the stop; `stops` returns whether a look stops with a
/// given number of unstable samples. Which samples are undecided or failed is taken as given: the verdicts of the
/// others are independent.
pub(super) fn probability(counts: &[VerdictCounts], stops: impl Fn(usize, u64) -> bool) -> Option<f64> {
    let first = counts.iter().position(|counts| counts.decided() > 0)?;
    let last = counts.len() - 1;
    let mut weights = Weights { from: counts[last].unstable, values: vec![1.0] };
    let mut look = last;
    while look > first
        && !(first..look)
            .all(|earlier| continues(earlier, &weights, counts[look].decided(), counts[earlier].decided(), &stops))
    {
        weights = weights.one_look_back(counts[look].decided(), counts[look - 1].decided());
        look -= 1;
        weights.trim(|unstable| stops(look, unstable));
    }
    // Where no earlier look can have stopped, the expected share at the first look is the one here.
    let share = weights.mean() / counts[look].decided() as f64;
    // No weight is left if the counts cannot be those of independent samples.
    Some(if share.is_nan() { counts[last].unstable as f64 / counts[last].decided() as f64 } else { share })
}

/// Whether look `earlier`, with `decided` samples, cannot have stopped given the `weights` at a look with `all`
/// samples, except with a probability as small as rounding errors.
fn continues(earlier: usize, weights: &Weights, all: u64, decided: u64, stops: &impl Fn(usize, u64) -> bool) -> bool {
    let Some(steps) = (weights.values.len() as u64).checked_sub(1) else { return true };
    let all = all as f64;
    let fraction = decided as f64 / all;
    // Nine standard deviations of the hypergeometric distribution, and ten samples more for small counts.
    let reach = |unstable: u64| {
        let share = unstable as f64 / all;
        9.0 * (decided as f64 * share * (1.0 - share) * (1.0 - fraction)).sqrt() + 10.0
    };
    let (from, to) = (weights.from, weights.from + steps);
    let low = (from as f64 * fraction - reach(from)).max(0.0) as u64;
    let high = ((to as f64 * fraction + reach(to)) as u64).min(decided);
    // Intervals are widest in the middle: between two counts that continue every count continues.
    !stops(earlier, low.min(decided)) && !stops(earlier, high)
}

/// Weights of consecutive numbers of unstable samples, from `from` on.
struct Weights {
    from: u64,
    values: Vec<f64>,
}

impl Weights {
    /// Weights smaller than this, relative to the largest, are dropped.
    const LEAST: f64 = 1e-18;

    /// The weights of the numbers of unstable ones among the first `before` of `decided` samples in random order.
    fn one_look_back(&self, decided: u64, before: u64) -> Self {
        let rows: Vec<(f64, Self)> = self
            .values
            .iter()
            .enumerate()
            .filter(|(_, weight)| **weight > 0.0)
            .map(|(i, &weight)| (weight, Self::hypergeometric(decided, self.from + i as u64, before)))
            .collect();
        let from = rows.iter().map(|(_, row)| row.from).min().unwrap_or(0);
        let to = rows.iter().map(|(_, row)| row.from + row.values.len() as u64).max().unwrap_or(0);
        let mut values = vec![0.0; (to - from) as usize];
        for (weight, row) in &rows {
            let place = (row.from - from) as usize;
            for (sum, value) in values[place..].iter_mut().zip(&row.values) {
                *sum += weight * value;
            }
        }
        Self { from, values }
    }

    /// The hypergeometric distribution of the number of unstable ones among `drawn` samples out of `all`, of which
    /// `unstable` are unstable.
    fn hypergeometric(all: u64, unstable: u64, drawn: u64) -> Self {
        let (low, high) = ((unstable + drawn).saturating_sub(all), unstable.min(drawn));
        let mode = ((drawn as f64 + 1.0) * (unstable as f64 + 1.0) / (all as f64 + 2.0)) as u64;
        let mode = mode.clamp(low, high);
        // The ratio of the probabilities of k + 1 and k.
        let ratio = |k: u64| {
            let (up, down) =
                ((unstable - k) as f64 * (drawn - k) as f64, (k + 1) as f64 * (all + k + 1 - unstable - drawn) as f64);
            up / down
        };
        let mut below = Vec::new();
        let (mut k, mut weight) = (mode, 1.0);
        while k > low && weight > Self::LEAST {
            k -= 1;
            weight /= ratio(k);
            below.push(weight);
        }
        let from = k;
        let mut values: Vec<f64> = below.into_iter().rev().collect();
        values.push(1.0);
        (k, weight) = (mode, 1.0);
        while k < high && weight > Self::LEAST {
            weight *= ratio(k);
            k += 1;
            values.push(weight);
        }
        let sum: f64 = values.iter().sum();
        values.iter_mut().for_each(|value| *value /= sum);
        Self { from, values }
    }

    /// Drops the numbers at which the cell would have stopped. They lie at both ends, as intervals are widest in the
    /// middle.
    fn trim(&mut self, stops: impl Fn(u64) -> bool) {
        let length = self.values.len();
        let front = (0..length).take_while(|&i| stops(self.from + i as u64)).count();
        let back = (front..length).rev().take_while(|&i| stops(self.from + i as u64)).count();
        self.values.truncate(length - back);
        self.values.drain(..front);
        self.from += front as u64;
    }

    /// The mean; NaN without weights.
    fn mean(&self) -> f64 {
        let sum: f64 = self.values.iter().sum();
        let moment: f64 =
            self.values.iter().enumerate().map(|(i, weight)| weight * (self.from + i as u64) as f64).sum();
        moment / sum
    }
}
