//! Stopping by precision: looking at a cell's counts again and again until its probability is known well enough.
//!
//! Who computes an ordinary 95 % interval at every look and stops as soon as it is narrow enough stops more often when
//! the counts happen to be low than when they happen to be high: a small observed probability makes a narrow interval.
//! For rare events such an interval covers less than it says, and the observed share is too low on average. [`Looks`]
//! fixes in advance when the counts are looked at, spends the error over those looks, and has the unbiased estimate of
//! this design.

use stickslip_core::verdict::VerdictCounts;

use crate::draw::identity::BLOCK_SAMPLES;
use crate::estimate::interval::{BinomialInterval, Estimate, IntervalKind};

/// Of the error, the part that the regular looks share; the others share the rest.
const REGULAR: f64 = 0.9;

/// With a relative precision only: looks at which probabilities down to this one stop are regular.
const LEAST_REGULAR: f64 = 1e-6;

/// No schedule has more looks: samples would be beyond 2^64.
const MOST_LOOKS: usize = 200;

/// When an interval is narrow enough: when one of the two holds. At least one of them is given.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Half of its width is at most this; greater than 0 and less than 0.5.
    pub half_width: Option<f64>,
    /// Half of its width is at most this times its middle; greater than 0 and less than 1.
    pub relative: Option<f64>,
}

impl Precision {
    /// Whether an interval is narrow enough.
    #[must_use]
    pub fn is_met(&self, low: f64, high: f64) -> bool {
        let width = high - low;
        self.half_width.is_some_and(|most| 0.5 * width <= most)
            || self.relative.is_some_and(|most| width <= most * (low + high))
    }

    /// A number of samples below which no counts make an interval of error `alpha` narrow enough.
    fn least_samples(&self, alpha: f64) -> u64 {
        // The narrowest intervals are those of no unstable sample, and of nothing else: their other end is
        // (alpha / 2)^(1 / n) from 1 or from 0.
        let end = |ratio: f64| libm::log(0.5 * alpha) / libm::log(ratio);
        let absolute = self.half_width.map_or(f64::INFINITY, |most| end(1.0 - 2.0 * most));
        let relative = self.relative.map_or(f64::INFINITY, |most| end((1.0 - most) / (1.0 + most)));
        f64::min(absolute, relative) as u64
    }

    /// Whether all probabilities stop at so many samples; with a relative precision only, those from 1e-6 on.
    fn is_met_by_most(&self, interval: &BinomialInterval, samples: u64) -> bool {
        let unstable = if self.half_width.is_some() { samples / 2 } else { (samples as f64 * LEAST_REGULAR) as u64 };
        let (low, high) = interval.bounds(unstable, samples);
        self.is_met(low, high)
    }
}

/// The sample counts at which a cell is looked at, intervals that hold whichever look is the last, and the estimate that
/// is right on average.
///
/// **Intervals.** Look `j` has a Clopper-Pearson interval of error `alpha_j`, and all `alpha_j` together are `1 - c`.
/// By Bonferroni's inequality all of them contain the true probability together with probability `c` or more, and so
/// does the one at which any rule stops. This holds for finite samples and for every probability: Clopper-Pearson is
/// exact, and the bound asks nothing of how the looks depend on one another, nor of the stopping rule. Looks begin
/// where a stop becomes possible. The `K` regular ones, up to the sample count at which every probability stops (with a
/// relative precision those from 1e-6 on), share nine tenths of the error equally, which makes the worst look's
/// interval the narrowest; look `K + i` has the part `1 / (i (i + 1))` of the rest. The limit of samples does not
/// enter, so it can be raised later: an interval at the limit has the share of the next look. (Boundaries that use the
/// looks' dependence, S. J. Pocock, Biometrika 64, 1977, hold for normal means, not for few counts.)
///
/// With sample counts that grow by a quarter (at the start by a block) a stop is at most that much later than need be,
/// and `K` grows with the logarithm of the precision only.
///
/// **Estimate.** The share of unstable samples at the stop is biased: with a half width of 0.0005 it is 17 % too low at
/// a probability of 1e-4, with a relative precision too high. The share at the first look is not, but scatters. Its
/// expected value given the counts at the stop is unbiased and scatters least (M. A. Girshick, F. Mosteller, L. J.
/// Savage, Ann. Math. Stat. 17, 1946): over all orders in which the samples may have come that do not stop earlier.
/// Given the count at a look, that at the look before is hypergeometric.
///
/// ```
/// use stickslip_sampler::estimate::sequential::{Looks, Precision};
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
    /// Looks until `precision` is met or a cell has `at_most` samples, with the given two-sided confidence for all looks
    /// together.
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

    /// Samples of the cell at each look, strictly increasing; the last is the most it may have.
    #[must_use]
    pub fn ends(&self) -> &[u64] {
        &self.ends
    }

    /// The share of the error that a look has.
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

    /// Whether the interval is narrow enough with `unstable` of the decided samples.
    fn is_met(&self, look: usize, unstable: u64, counts: &VerdictCounts) -> bool {
        let estimate = self.intervals[look].estimate(&with_unstable(unstable, counts));
        self.precision.is_met(estimate.low, estimate.high)
    }

    /// The estimate at a stop, from the counts at each look up to it, every look's of all samples so far: unbiased, with an
    /// interval that is valid under repeated looks and any stopping rule. Nothing is known without a look.
    #[must_use]
    pub fn estimate(&self, counts: &[VerdictCounts]) -> Estimate {
        let Some((look, last)) = counts.iter().enumerate().next_back() else {
            return Estimate { probability: None, low: 0.0, high: 1.0 };
        };
        debug_assert_eq!(self.ends.get(look), Some(&last.total()), "counts of another look");
        let estimate = self.intervals[look].estimate(last);
        // Beyond its interval it is only after stops that no probability makes likely.
        Estimate { probability: self.unbiased(counts).map(|p| p.clamp(estimate.low, estimate.high)), ..estimate }
    }

    /// The expected share of unstable samples among those decided at the first look that has any, given the counts at
    /// the stop and that no earlier look was enough.
    ///
    /// Undecided and failed samples are taken as they came: given which samples are decided, their verdicts are
    /// independent.
    fn unbiased(&self, counts: &[VerdictCounts]) -> Option<f64> {
        let first = counts.iter().position(|counts| counts.decided() > 0)?;
        let last = counts.len() - 1;
        let mut weights = Weights { from: counts[last].unstable, values: vec![1.0] };
        let mut look = last;
        while look > first
            && !(first..look).all(|earlier| self.goes_on(earlier, &weights, &counts[look], &counts[earlier]))
        {
            weights = weights.a_look_before(counts[look].decided(), counts[look - 1].decided());
            look -= 1;
            weights.trim(|unstable| self.is_met(look, unstable, &counts[look]));
        }
        // Where no stop before was possible, the share at the first look is expected to be the one here.
        let share = weights.mean() / counts[look].decided() as f64;
        // No weight is left if the counts are not those of independent samples.
        Some(if share.is_nan() { counts[last].unstable as f64 / counts[last].decided() as f64 } else { share })
    }

    /// Whether no earlier look could have been enough, but with a probability of rounding errors.
    fn goes_on(&self, earlier: usize, weights: &Weights, here: &VerdictCounts, counts: &VerdictCounts) -> bool {
        let Some(steps) = (weights.values.len() as u64).checked_sub(1) else { return true };
        let (decided, all) = (counts.decided(), here.decided() as f64);
        let part = decided as f64 / all;
        // Hypergeometric: nine standard deviations, and ten more for few counts.
        let reach = |unstable: u64| {
            let share = unstable as f64 / all;
            9.0 * (decided as f64 * share * (1.0 - share) * (1.0 - part)).sqrt() + 10.0
        };
        let (from, to) = (weights.from, weights.from + steps);
        let low = (from as f64 * part - reach(from)).max(0.0) as u64;
        let high = ((to as f64 * part + reach(to)) as u64).min(decided);
        // Intervals are widest in the middle, so that what lies between two counts that go on goes on as well.
        !self.is_met(earlier, low.min(decided), counts) && !self.is_met(earlier, high, counts)
    }
}

/// Counts with another number of unstable samples among the decided ones.
fn with_unstable(unstable: u64, counts: &VerdictCounts) -> VerdictCounts {
    VerdictCounts { unstable, stable: counts.decided() - unstable, ..*counts }
}

/// Weights of consecutive numbers of unstable samples.
struct Weights {
    from: u64,
    values: Vec<f64>,
}

impl Weights {
    /// Smaller ones, over the largest, are left out.
    const LEAST: f64 = 1e-18;

    /// The weights of the numbers of unstable ones among the first `before` of `decided` samples, whose order is not known.
    fn a_look_before(&self, decided: u64, before: u64) -> Self {
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

    /// The probabilities of the numbers of unstable ones among `drawn` samples out of `all`, of which `unstable` are.
    fn hypergeometric(all: u64, unstable: u64, drawn: u64) -> Self {
        let (low, high) = ((unstable + drawn).saturating_sub(all), unstable.min(drawn));
        let mode = ((drawn as f64 + 1.0) * (unstable as f64 + 1.0) / (all as f64 + 2.0)) as u64;
        let mode = mode.clamp(low, high);
        // From k to k + 1.
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

    /// Drops the numbers at which the cell would have stopped: those at both ends, as intervals are widest between.
    fn trim(&mut self, stops: impl Fn(u64) -> bool) {
        let length = self.values.len();
        let front = (0..length).take_while(|&i| stops(self.from + i as u64)).count();
        let back = (front..length).rev().take_while(|&i| stops(self.from + i as u64)).count();
        self.values.truncate(length - back);
        self.values.drain(..front);
        self.from += front as u64;
    }

    /// Their mean; NaN without any.
    fn mean(&self) -> f64 {
        let sum: f64 = self.values.iter().sum();
        let moment: f64 =
            self.values.iter().enumerate().map(|(i, weight)| weight * (self.from + i as u64) as f64).sum();
        moment / sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::interval::WilsonInterval;
    use rand::SeedableRng;
    use rand_distr::{Binomial, Distribution};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn half_width(most: f64) -> Precision {
        Precision { half_width: Some(most), relative: None }
    }

    fn relative(most: f64) -> Precision {
        Precision { half_width: None, relative: Some(most) }
    }

    fn counts(unstable: u64, samples: u64) -> VerdictCounts {
        VerdictCounts { stable: samples - unstable, unstable, ..VerdictCounts::default() }
    }

    #[test]
    fn looks_are_whole_blocks_that_grow_by_a_quarter_from_where_a_stop_is_possible() {
        for (precision, first) in
            [(half_width(0.01), 1000), (half_width(0.0001), 19_000), (relative(0.05), 1000), (relative(1e-4), 19_000)]
        {
            for at_most in [999, 1000, 1_000_000, 12_345_678, 1 << 40] {
                let looks = Looks::new(precision, at_most, 0.95);
                let ends = looks.ends();
                assert_eq!(ends[0], first.min(at_most));
                assert_eq!(*ends.last().unwrap(), at_most);
                assert!(ends[..ends.len() - 1].iter().all(|end| end % BLOCK_SAMPLES == 0));
                for pair in ends.windows(2) {
                    assert!(pair[0] < pair[1] && pair[1] <= pair[0] + pair[0] / 4 + BLOCK_SAMPLES);
                    assert!(pair[1] == at_most || 4 * pair[1] >= 5 * pair[0]);
                }
                let spent: f64 = (0..ends.len()).map(|look| looks.error_share(look)).sum();
                assert!(spent <= 1.0 + 1e-12, "{precision:?} {at_most}: {spent}");
            }
        }
        let either = Precision { half_width: Some(1e-4), relative: Some(0.05) };
        assert_eq!(Looks::new(either, u64::MAX, 0.95).ends()[0], 1000);
        assert_eq!(*Looks::new(either, u64::MAX, 0.95).ends().last().unwrap(), u64::MAX);
    }

    #[test]
    fn a_higher_limit_changes_no_look_below_it() {
        for precision in [half_width(0.002), relative(0.1)] {
            let (short, long) = (Looks::new(precision, 31_500, 0.95), Looks::new(precision, 4_000_000, 0.95));
            let inner = short.ends().len() - 1;
            assert_eq!(short.ends()[..inner], long.ends()[..inner]);
            assert_eq!(short.intervals[..], long.intervals[..=inner], "the limit has the share of the next look");
        }
    }

    #[test]
    fn every_probability_stops_within_the_regular_looks() {
        let looks = Looks::new(half_width(0.01), 1_000_000, 0.95);
        let last = looks.ends()[looks.regular - 1];
        assert!(looks.is_met(looks.regular - 1, last / 2, &counts(last / 2, last)));
        assert!(last < 40_000, "{last}");
        // One look alone would take 9604 samples.
        let looks = Looks::new(relative(0.1), 1_000_000_000, 0.95);
        let end = looks.ends().iter().position(|&end| end > 300_000).unwrap();
        assert!(looks.is_met(end, looks.ends()[end] / 100, &counts(0, looks.ends()[end])));
    }

    #[test]
    fn a_look_is_enough_when_narrow_or_last() {
        let looks = Looks::new(half_width(0.02), 2000, 0.95);
        assert!(looks.is_enough(0, &counts(3, 1000)) && !looks.is_enough(0, &counts(500, 1000)));
        assert!(looks.is_enough(1, &counts(1000, 2000)));
        // Undecided samples count as width.
        let doubtful = VerdictCounts { stable: 597, unstable: 3, undecided: 400, ..Default::default() };
        assert!(!looks.is_enough(0, &doubtful));
        // Without unstable samples no relative precision is reached.
        let looks = Looks::new(relative(0.5), 100_000, 0.95);
        assert!(!looks.is_enough(0, &counts(0, 1000)) && looks.is_enough(0, &counts(200, 1000)));
    }

    /// For each count at which a cell of probability `p` without undecided samples may stop, its probability and
    /// the estimate there, by convolving binomial distributions from look to look.
    fn stops(looks: &Looks, p: f64) -> Vec<(f64, u64, u64, Estimate)> {
        let binomial = |n: u64| {
            let mut mass = vec![libm::exp(n as f64 * libm::log1p(-p))];
            while mass.len() as f64 <= n as f64 * p + 12.0 * (n as f64 * p).sqrt() + 20.0 {
                let k = mass.len() as f64;
                mass.push(mass[mass.len() - 1] * (n as f64 - k + 1.0) / k * p / (1.0 - p));
            }
            mass
        };
        let (mut going, mut found, mut before) = (vec![1.0], Vec::new(), 0);
        let mut path = Vec::new();
        for (look, &end) in looks.ends().iter().enumerate() {
            let step = binomial(end - before);
            let mut next = vec![0.0; going.len() + step.len()];
            for (i, a) in going.iter().enumerate() {
                step.iter().enumerate().for_each(|(j, b)| next[i + j] += a * b);
            }
            before = end;
            path.push(counts(0, end));
            for (k, mass) in next.iter_mut().enumerate().filter(|(_, mass)| **mass > 1e-13) {
                let here = counts(k as u64, end);
                if looks.is_enough(look, &here) {
                    *path.last_mut().unwrap() = here;
                    found.push((*mass, k as u64, end, looks.estimate(&path)));
                    *mass = 0.0;
                }
            }
            going = next;
        }
        found
    }

    #[test]
    fn the_estimate_is_unbiased_where_the_observed_share_is_not() {
        // Exact sums over all stops.
        for (precision, p, bias_of_share) in [
            (half_width(0.002), 1e-3, -0.14),
            (half_width(0.0005), 1e-4, -0.16),
            (half_width(0.001), 5e-3, -0.002),
            (relative(0.4), 5e-3, 0.01),
        ] {
            let looks = Looks::new(precision, 60_000, 0.95);
            let stops = stops(&looks, p);
            let total: f64 = stops.iter().map(|stop| stop.0).sum();
            assert!((total - 1.0).abs() < 1e-9, "{total}");
            let mean: f64 = stops.iter().map(|(mass, .., estimate)| mass * estimate.probability.unwrap()).sum();
            let share: f64 = stops.iter().map(|(mass, k, n, _)| mass * *k as f64 / *n as f64).sum();
            assert!((mean / p - 1.0).abs() < 1e-8, "{precision:?} {p}: {}", mean / p - 1.0);
            let bias = share / p - 1.0;
            assert!(bias.abs() > f64::abs(bias_of_share) && bias * bias_of_share > 0.0, "{precision:?} {p}: {bias}");
            let inside =
                stops.iter().all(|(_, _, _, e)| e.low <= e.probability.unwrap() && e.probability.unwrap() <= e.high);
            assert!(inside, "the estimate is in its interval");
            let covered: f64 = stops.iter().filter(|(.., e)| e.low <= p && p <= e.high).map(|stop| stop.0).sum();
            assert!(covered >= 0.95, "{precision:?} {p}: {covered}");
        }
    }

    #[test]
    fn undecided_samples_leave_the_estimate_unbiased() {
        // Every tenth sample is undecided, whatever its verdict would be.
        let (p, looks) = (0.002, Looks::new(half_width(0.055), 6000, 0.95));
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(1946);
        let (mut sum, mut sum_of_shares, mut squares, replicates) = (0.0, 0.0, 0.0, 20_000);
        let mut stopped_at = Vec::new();
        for _ in 0..replicates {
            let mut path: Vec<VerdictCounts> = Vec::new();
            for (look, &end) in looks.ends().iter().enumerate() {
                let before = path.last().copied().unwrap_or_default();
                let more = end - before.total();
                let undecided = Binomial::new(more, 0.1).unwrap().sample(&mut generator);
                let unstable = Binomial::new(more - undecided, p).unwrap().sample(&mut generator);
                path.push(
                    before + VerdictCounts { undecided, unstable, stable: more - undecided - unstable, failed: 0 },
                );
                if looks.is_enough(look, &path[look]) {
                    break;
                }
            }
            let last = path.last().unwrap();
            stopped_at.push(path.len());
            let estimate = looks.estimate(&path).probability.unwrap();
            sum += estimate;
            squares += estimate * estimate;
            sum_of_shares += last.unstable as f64 / last.decided() as f64;
        }
        let mean = sum / f64::from(replicates);
        let error = ((squares / f64::from(replicates) - mean * mean) / f64::from(replicates)).sqrt();
        assert!(stopped_at.iter().min() != stopped_at.iter().max(), "looks differ");
        assert!((mean - p).abs() < 4.0 * error, "{mean} +- {error}");
        let share = sum_of_shares / f64::from(replicates);
        assert!(p - share > 4.0 * error, "{share}");
    }

    #[test]
    fn a_single_look_gives_the_observed_share() {
        let counts = VerdictCounts { stable: 900, unstable: 60, undecided: 30, failed: 10 };
        let estimate = Looks::new(half_width(0.001), 1000, 0.95).estimate(&[counts]);
        assert_eq!(estimate.probability, Some(60.0 / 960.0));
        assert_eq!(Looks::new(half_width(0.001), 1000, 0.95).estimate(&[]).probability, None);
        let undecided = VerdictCounts { undecided: 1000, ..Default::default() };
        assert_eq!(Looks::new(half_width(0.001), 1000, 0.95).estimate(&[undecided]).probability, None);
    }

    #[test]
    fn many_counts_are_no_burden() {
        // Where only the last look can have been enough, the estimate is the share.
        let looks = Looks::new(half_width(0.0005), 100_000_000, 0.95);
        let mut path = Vec::new();
        for (look, &end) in looks.ends().iter().enumerate() {
            path.push(counts(3 * end / 10, end));
            if looks.is_enough(look, &path[look]) {
                break;
            }
        }
        let last = *path.last().unwrap();
        assert!(last.total() > 3_000_000);
        assert!((looks.estimate(&path).probability.unwrap() - 0.3).abs() < 1e-9, "{last:?}");
    }

    #[test]
    fn a_plain_interval_with_the_same_rule_covers_less_than_it_says() {
        let (p, most, replicates) = (0.003, 0.0012, 20_000);
        let looks = Looks::new(half_width(most), 20_000, 0.95);
        let wilson = WilsonInterval::new(0.95);
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(1945);
        let mut covered = 0;
        for _ in 0..replicates {
            let mut all = VerdictCounts::default();
            for &end in looks.ends() {
                let more = end - all.total();
                all += counts(Binomial::new(more, p).unwrap().sample(&mut generator), more);
                let plain = wilson.estimate(&all);
                if 0.5 * (plain.high - plain.low) <= most {
                    covered += u32::from(plain.low <= p && p <= plain.high);
                    break;
                }
            }
        }
        let share = f64::from(covered) / f64::from(replicates);
        assert!(share < 0.94, "{share}");
    }
}
