//! From counted verdicts to a probability and its confidence interval.

use stickslip_core::VerdictCounts;

use crate::normal;

/// A probability of instability with the interval that contains the true one at the job's confidence.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// `unstable / (stable + unstable)`; `None` if no sample was decided.
    pub probability: Option<f64>,
    /// Lower end, every undecided and failed sample counted as stable.
    pub low: f64,
    /// Upper end, every undecided and failed sample counted as unstable.
    pub high: f64,
}

/// Wilson's score interval for a binomial proportion (E. B. Wilson, J. Am. Stat. Assoc. 22, 1927):
///
/// ```text
/// (p + z^2 / 2n -+ z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n),      p = k / n
/// ```
///
/// It stays inside [0, 1], and is never empty at `k = 0` or `k = n`.
///
/// ```
/// use stickslip_sampler::WilsonInterval;
/// let (low, high) = WilsonInterval::new(0.95).bounds(81, 263);
/// assert!((low - 0.255_3).abs() < 5e-5 && (high - 0.366_2).abs() < 5e-5); // Newcombe 1998, method 3
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WilsonInterval {
    z: f64,
}

impl WilsonInterval {
    /// The interval with the given two-sided confidence, strictly between 0 and 1.
    #[must_use]
    pub fn new(confidence: f64) -> Self {
        Self { z: normal::upper_quantile(0.5 * (1.0 - confidence)) }
    }

    /// The ends for `successes` out of `trials`; (0, 1) without trials.
    #[must_use]
    pub fn bounds(&self, successes: u64, trials: u64) -> (f64, f64) {
        if trials == 0 {
            return (0.0, 1.0);
        }
        let failures = trials - successes;
        (self.lower(successes, failures), 1.0 - self.lower(failures, successes))
    }

    /// The lower end; the upper one is its mirror image, so that both ends are exact where they are 0 or 1.
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

    /// The estimate that counted verdicts give.
    #[must_use]
    pub fn estimate(&self, counts: &VerdictCounts) -> Estimate {
        let (decided, total) = (counts.decided(), counts.total());
        let probability = (decided > 0).then(|| counts.unstable as f64 / decided as f64);
        let doubtful = counts.undecided + counts.failed;
        let (low, _) = self.bounds(counts.unstable, total);
        let (_, high) = self.bounds(counts.unstable + doubtful, total);
        Estimate { probability, low, high }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_agree_with_published_examples() {
        // R. G. Newcombe, Statistics in Medicine 17 (1998), table I, method 3 (Wilson's score, no correction).
        let interval = WilsonInterval::new(0.95);
        for (k, n, low, high) in
            [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
        {
            let bounds = interval.bounds(k, n);
            assert!((bounds.0 - low).abs() <= 0.5e-4 && (bounds.1 - high).abs() <= 0.5e-4, "{k}/{n}: {bounds:?}");
        }
    }

    #[test]
    fn bounds_solve_the_score_equation() {
        // Definition: |p_hat - p| = z sqrt(p (1 - p) / n) at both ends.
        for confidence in [0.5, 0.9, 0.95, 0.999] {
            let interval = WilsonInterval::new(confidence);
            for (k, n) in [(1, 2), (3, 10), (500, 1000), (1, 1_000_000), (999_999, 1_000_000)] {
                let p_hat = k as f64 / n as f64;
                let (low, high) = interval.bounds(k, n);
                assert!(low < p_hat && p_hat < high);
                for p in [low, high] {
                    let score = (p_hat - p).abs() / (p * (1.0 - p) / n as f64).sqrt();
                    assert!((score / interval.z - 1.0).abs() < 1e-9, "{k}/{n} at {confidence}: {score}");
                }
            }
        }
    }

    #[test]
    fn ends_are_exact_at_zero_and_one() {
        let interval = WilsonInterval::new(0.95);
        assert_eq!(interval.bounds(0, 10_000).0, 0.0);
        assert_eq!(interval.bounds(10_000, 10_000).1, 1.0);
        assert!(interval.bounds(0, 10_000).1 > 0.0 && interval.bounds(10_000, 10_000).0 < 1.0);
        assert_eq!(interval.bounds(0, 0), (0.0, 1.0));
    }

    #[test]
    fn doubtful_samples_widen_the_interval_on_both_sides() {
        let interval = WilsonInterval::new(0.95);
        let certain = interval.estimate(&VerdictCounts { stable: 60, unstable: 40, ..Default::default() });
        let doubtful = interval.estimate(&VerdictCounts { stable: 50, unstable: 40, undecided: 7, failed: 3 });
        assert_eq!(doubtful.probability, Some(40.0 / 90.0));
        assert_eq!(doubtful.low, certain.low);
        assert_eq!(doubtful.high, interval.bounds(50, 100).1);
        let none = interval.estimate(&VerdictCounts { undecided: 5, ..Default::default() });
        assert_eq!(none.probability, None);
        assert_eq!((none.low, none.high), (0.0, 1.0));
    }

    #[test]
    fn the_interval_covers_the_true_probability_as_often_as_it_says() {
        // Exact coverage for n = 40, averaged over p: the sum of binomial probabilities of the k whose interval
        // contains p. Wilson's interval is right on average, not at every p.
        let (interval, n) = (WilsonInterval::new(0.95), 40u64);
        let mut coverage = 0.0;
        let points = 2000;
        for i in 0..points {
            let p = (f64::from(i) + 0.5) / f64::from(points);
            let mut mass = (1.0 - p).powi(n as i32);
            for k in 0..=n {
                let (low, high) = interval.bounds(k, n);
                if low <= p && p <= high {
                    coverage += mass;
                }
                mass *= (n - k) as f64 / (k + 1) as f64 * p / (1.0 - p);
            }
        }
        coverage /= f64::from(points);
        assert!((coverage - 0.95).abs() < 0.005, "{coverage}");
    }
}
