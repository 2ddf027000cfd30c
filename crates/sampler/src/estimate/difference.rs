//! Intervals for a difference `p1 - p2` of two probabilities: of paired samples (two models or two cells with common
//! random numbers), of independent ones, and of samples that depend on each other in an unknown way.
//!
//! Up to a confidence of 95 % the intervals are approximate, and cover what they say on average. Beyond, as where many
//! of them have to hold together, they are made of Clopper and Pearson's intervals ([`IntervalKind::for_confidence`]).

use crate::estimate::interval::{BinomialInterval, IntervalKind, half_of_the_error};
use crate::special_functions::normal;

/// Samples judged twice, counted by the two verdicts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct PairedCounts {
    /// Unstable in both.
    pub both: u64,
    /// Unstable in the first only.
    pub only_first: u64,
    /// Unstable in the second only.
    pub only_second: u64,
    /// Unstable in neither.
    pub neither: u64,
}

impl PairedCounts {
    /// All pairs.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.both + self.only_first + self.only_second + self.neither
    }
}

/// A difference `p1 - p2` of two probabilities with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    /// The observed difference; `None` without samples.
    pub value: Option<f64>,
    /// Lower end, at least -1.
    pub low: f64,
    /// Upper end, at most 1.
    pub high: f64,
}

impl Difference {
    /// What is known without samples.
    const UNKNOWN: Self = Self { value: None, low: -1.0, high: 1.0 };
}

/// The interval for the difference of two probabilities from paired samples, two-sided. Pairs with an undecided sample
/// are the caller's to place. For `n` up to 1e10; (-1, 1) without pairs.
///
/// Up to a confidence of 95 % it is Tango's score interval (T. Tango, Statistics in Medicine 17, 1998, p. 891): the
/// differences `d` with
///
/// ```text
/// |b - c - n d| <= z sqrt(n (2 q + d (1 - d))),
/// ```
///
/// where `b` and `c` pairs of `n` are unstable only in the first or only in the second and `q` is the probability of
/// the latter most likely at difference `d`. It is never empty, also where `b = c = 0`, and stays inside [-1, 1].
///
/// Beyond 95 % it is the range of `d = w (2 t - 1)` where `w`, the probability that a pair differs, is in Clopper and
/// Pearson's interval for `b + c` of `n`, and `t`, the probability that it is then the first that is unstable, in
/// theirs for `b` of `b + c`, each with half of the error. By Bonferroni's inequality it covers at least as often as it
/// says; for many pairs with `b` near `c` it is little wider than Tango's.
///
/// ```
/// use stickslip_sampler::estimate::difference::{PairedCounts, paired_difference};
/// let counts = PairedCounts { both: 1, only_first: 1, only_second: 7, neither: 12 };
/// let difference = paired_difference(&counts, 0.95);
/// assert!((difference.low + 0.517).abs() < 5e-4 && (difference.high + 0.026).abs() < 5e-4);
/// ```
#[must_use]
pub fn paired_difference(counts: &PairedCounts, confidence: f64) -> Difference {
    let total = counts.total();
    if total == 0 {
        return Difference::UNKNOWN;
    }
    let value = Some((counts.only_first as f64 - counts.only_second as f64) / total as f64);
    let (low, high) = match IntervalKind::for_confidence(confidence) {
        IntervalKind::Wilson => tango(counts, confidence),
        IntervalKind::ClopperPearson => exact_paired(counts, confidence),
    };
    Difference { value, low, high }
}

/// Tango's interval.
fn tango(counts: &PairedCounts, confidence: f64) -> (f64, f64) {
    let z = normal::upper_quantile(0.5 * (1.0 - confidence));
    let (first, second, total) = (counts.only_first as f64, counts.only_second as f64, counts.total() as f64);
    (-score_limit(second, first, total, z), score_limit(first, second, total, z))
}

/// The interval of the share of pairs that differ, and of the direction in which they do.
fn exact_paired(counts: &PairedCounts, confidence: f64) -> (f64, f64) {
    let interval = BinomialInterval::new(IntervalKind::ClopperPearson, half_of_the_error(confidence));
    let differ = counts.only_first + counts.only_second;
    let (least, most) = interval.bounds(differ, counts.total());
    let (low, high) = interval.bounds(counts.only_first, differ);
    let [low, high] = [low, high].map(|first| 2.0 * first - 1.0);
    (low * if low > 0.0 { least } else { most }, high * if high > 0.0 { most } else { least })
}

/// The upper end of Tango's interval; the lower one is its mirror image.
///
/// Bisection of `n d - (b - c) - z sqrt(n variance)` between the observed difference, where it is not positive, and 1,
/// where the variance vanishes: some 80 halvings, each of two square roots.
fn score_limit(first: f64, second: f64, total: f64, z: f64) -> f64 {
    let observed = first - second;
    let (mut low, mut high) = (observed / total, 1.0);
    // Below a millionth of a sample's weight no digit of the result means anything.
    while high - low > 1e-15 * f64::max(f64::max(low.abs(), high.abs()), 1e-6 / total) {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        let below = total * middle - observed < z * (total * score_variance(first, second, total, middle)).sqrt();
        if below {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Variance `2 q + d (1 - d)` of one pair's difference, `q` the most likely probability of a pair unstable only in the
/// second if the difference of the probabilities is `d`:
///
/// ```text
/// 2 n q^2 + (-b - c + (2 n - b + c) d) q - c d (1 - d) = 0
/// ```
fn score_variance(first: f64, second: f64, total: f64, difference: f64) -> f64 {
    if difference < 0.0 {
        // With the roles exchanged the difference is positive and nothing below cancels.
        return score_variance(second, first, total, -difference);
    }
    let spread = difference * (1.0 - difference);
    let linear = (2.0 * total - first + second) * difference - first - second;
    let root = (linear * linear + 8.0 * total * second * spread).sqrt();
    let q = if linear <= 0.0 { (root - linear) / (4.0 * total) } else { 2.0 * second * spread / (root + linear) };
    2.0 * q + spread
}

/// Newcombe's hybrid interval for the difference of two probabilities from independent samples, two-sided (R. G.
/// Newcombe, Statistics in Medicine 17, 1998, p. 873, method 10): with the ends `l` and `u` of either probability
///
/// ```text
/// d - sqrt((p1 - l1)^2 + (u2 - p2)^2)   to   d + sqrt((u1 - p1)^2 + (p2 - l2)^2),      d = p1 - p2
/// ```
///
/// Up to a confidence of 95 % the ends are Wilson's, as Newcombe has them; beyond, Clopper and Pearson's. (-1, 1) if
/// either has no samples.
///
/// ```
/// use stickslip_sampler::estimate::difference::unpaired_difference;
/// let difference = unpaired_difference(56, 70, 48, 80, 0.95);
/// assert!((difference.low - 0.0524).abs() < 5e-5 && (difference.high - 0.3339).abs() < 5e-5);
/// ```
#[must_use]
pub fn unpaired_difference(
    successes_first: u64,
    trials_first: u64,
    successes_second: u64,
    trials_second: u64,
    confidence: f64,
) -> Difference {
    let interval = BinomialInterval::new(IntervalKind::for_confidence(confidence), confidence);
    let share = |successes, trials| Share::of(successes, trials, &interval);
    let (Some(first), Some(second)) = (share(successes_first, trials_first), share(successes_second, trials_second))
    else {
        return Difference::UNKNOWN;
    };
    let length = |a: f64, b: f64| (a * a + b * b).sqrt();
    let value = first.value - second.value;
    Difference {
        value: Some(value),
        low: (value - length(first.value - first.low, second.high - second.value)).max(-1.0),
        high: (value + length(first.high - first.value, second.value - second.low)).min(1.0),
    }
}

/// The interval for the difference of two probabilities from samples that depend on each other in whatever way, two-sided:
/// from the lowest first to the highest second probability and the other way round, in Clopper and Pearson's intervals
/// with half of the error each. It covers at least as often as it says (Bonferroni's inequality). (-1, 1) if either has no
/// samples.
#[must_use]
pub fn dependent_difference(
    successes_first: u64,
    trials_first: u64,
    successes_second: u64,
    trials_second: u64,
    confidence: f64,
) -> Difference {
    let interval = BinomialInterval::new(IntervalKind::ClopperPearson, half_of_the_error(confidence));
    let share = |successes, trials| Share::of(successes, trials, &interval);
    let (Some(first), Some(second)) = (share(successes_first, trials_first), share(successes_second, trials_second))
    else {
        return Difference::UNKNOWN;
    };
    Difference { value: Some(first.value - second.value), low: first.low - second.high, high: first.high - second.low }
}

/// An observed share with the ends of its interval.
struct Share {
    value: f64,
    low: f64,
    high: f64,
}

impl Share {
    /// `None` without trials.
    fn of(successes: u64, trials: u64, interval: &BinomialInterval) -> Option<Self> {
        let (low, high) = interval.bounds(successes, trials);
        (trials > 0).then(|| Self { value: successes as f64 / trials as f64, low, high })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn uniform(generator: &mut Xoshiro256PlusPlus) -> f64 {
        (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn pairs(both: u64, only_first: u64, only_second: u64, neither: u64) -> PairedCounts {
        PairedCounts { both, only_first, only_second, neither }
    }

    #[test]
    fn paired_limits_agree_with_the_definition() {
        // mpmath 1.4 with 40 digits, from the definition without its closed form: the likelihood of the three cells is
        // maximised over q by bisection of its derivative, the score equation solved by bisection in d.
        let table = [
            (pairs(36, 12, 2, 0), 0.95, 0.061_112_406_186_343_98, 0.344_708_748_282_148_7),
            (pairs(36, 12, 2, 0), 0.99, 0.008_798_065_726_200_44, 0.392_503_612_671_181_7),
            (pairs(43, 0, 1, 0), 0.95, -0.118_077_096_982_132_88, 0.059_393_231_116_627_97),
            (pairs(1, 1, 7, 12), 0.95, -0.517_232_276_421_377_4, -0.026_003_032_480_868_54),
            (pairs(0, 0, 0, 44), 0.95, -0.080_295_603_758_480_68, 0.080_295_603_758_480_68),
            (pairs(0, 10, 0, 0), 0.95, 0.444_934_400_274_221_5, 1.0),
            (pairs(0, 7, 3, 0), 0.95, -0.206_443_705_077_709_38, 0.784_417_465_187_398),
            (pairs(50, 3, 0, 47), 0.95, -0.008_103_303_153_195_255, 0.084_519_364_290_527_62),
            (pairs(900_000, 1200, 1100, 97_700), 0.95, 6.008_436_626_142_947e-6, 0.000_194_157_153_640_182_88),
            (pairs(999_999_995, 3, 1, 1), 0.95, -2.910_421_364_445_555_4e-9, 7.924_859_425_451_05e-9),
        ];
        for (counts, confidence, low, high) in table {
            let ends = tango(&counts, confidence);
            for (end, expected) in [(ends.0, low), (ends.1, high)] {
                assert!((end / expected - 1.0).abs() < 1e-12, "{counts:?}: {ends:?}");
            }
        }
    }

    #[test]
    fn paired_limits_are_antisymmetric_and_contain_the_observed_difference() {
        for counts in [pairs(3, 5, 0, 2), pairs(0, 0, 9, 1), pairs(400, 31, 17, 552), pairs(0, 0, 0, 1)] {
            let difference = paired_difference(&counts, 0.95);
            let exchanged = PairedCounts { only_first: counts.only_second, only_second: counts.only_first, ..counts };
            let mirrored = paired_difference(&exchanged, 0.95);
            assert_eq!((difference.low, difference.high), (-mirrored.high, -mirrored.low));
            let value = difference.value.unwrap();
            assert!(difference.low <= value && value <= difference.high && difference.low < difference.high);
        }
        assert_eq!(paired_difference(&PairedCounts::default(), 0.95), Difference::UNKNOWN);
    }

    #[test]
    fn pairs_without_a_difference_give_the_closed_form() {
        // b = c = 0: n d^2 = z^2 d (1 - d).
        let z2 = 1.959_963_984_540_054_f64.powi(2);
        for n in [1, 100, 1_000_000_000] {
            let high = paired_difference(&pairs(n / 2, 0, 0, n - n / 2), 0.95).high;
            assert!((high / (z2 / (n as f64 + z2)) - 1.0).abs() < 1e-13, "{n}: {high}");
        }
    }

    #[test]
    fn unpaired_limits_agree_with_published_examples() {
        // R. G. Newcombe, Statistics in Medicine 17 (1998), p. 873, table II, method 10.
        let table = [
            (56, 70, 48, 80, 0.0524, 0.3339),
            (9, 10, 3, 10, 0.1705, 0.8090),
            (10, 10, 0, 20, 0.6791, 1.0),
            (10, 10, 0, 10, 0.6075, 1.0),
        ];
        for (k1, n1, k2, n2, low, high) in table {
            let difference = unpaired_difference(k1, n1, k2, n2, 0.95);
            assert!((difference.low - low).abs() < 5e-5 && (difference.high - high).abs() < 5e-5, "{difference:?}");
        }
        assert_eq!(unpaired_difference(0, 0, 3, 4, 0.95), Difference::UNKNOWN);
    }

    #[test]
    fn paired_intervals_cover_as_often_as_they_say() {
        // Share of seeded replicates; the score interval is approximate, so the mean over the settings is near the
        // confidence and none is far below.
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(1998);
        let (replicates, n) = (4000, 200);
        let mut mean = 0.0;
        let settings = [(0.3, 0.10, 0.05), (0.0, 0.03, 0.02), (0.5, 0.2, 0.2), (0.9, 0.05, 0.01)];
        for (both, only_first, only_second) in settings {
            let mut covered = 0;
            for _ in 0..replicates {
                let mut counts = PairedCounts::default();
                for _ in 0..n {
                    let u = uniform(&mut generator);
                    if u < both {
                        counts.both += 1;
                    } else if u < both + only_first {
                        counts.only_first += 1;
                    } else if u < both + only_first + only_second {
                        counts.only_second += 1;
                    } else {
                        counts.neither += 1;
                    }
                }
                let difference = paired_difference(&counts, 0.95);
                let truth = only_first - only_second;
                covered += u32::from(difference.low <= truth && truth <= difference.high);
            }
            let coverage = f64::from(covered) / f64::from(replicates);
            assert!((0.93..0.98).contains(&coverage), "{only_first} {only_second}: {coverage}");
            mean += coverage / settings.len() as f64;
        }
        assert!((mean - 0.95).abs() < 0.01, "{mean}");
    }

    #[test]
    fn unpaired_intervals_cover_as_often_as_they_say() {
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(873);
        let replicates = 4000;
        let mut mean = 0.0;
        let settings = [(0.5, 100, 0.4, 150), (0.02, 400, 0.05, 200), (0.9, 80, 0.9, 80), (0.3, 50, 0.01, 500)];
        for (p1, n1, p2, n2) in settings {
            let mut covered = 0;
            for _ in 0..replicates {
                let mut count = |p: f64, n: u64| (0..n).filter(|_| uniform(&mut generator) < p).count() as u64;
                let difference = unpaired_difference(count(p1, n1), n1, count(p2, n2), n2, 0.95);
                covered += u32::from(difference.low <= p1 - p2 && p1 - p2 <= difference.high);
            }
            let coverage = f64::from(covered) / f64::from(replicates);
            assert!((0.93..0.98).contains(&coverage), "{p1} {p2}: {coverage}");
            mean += coverage / settings.len() as f64;
        }
        assert!((mean - 0.95).abs() < 0.015, "{mean}");
    }

    /// The probability of a Poisson number of events, for all numbers that are not beyond doubt.
    fn poisson(mean: f64) -> Vec<f64> {
        let mut mass = vec![(-mean).exp()];
        while mass.len() as f64 <= mean + 10.0 * mean.sqrt() + 25.0 {
            mass.push(mass[mass.len() - 1] * mean / mass.len() as f64);
        }
        mass
    }

    #[test]
    fn beyond_95_percent_no_difference_is_covered_less_than_is_said() {
        // Rare events, one in 10,000 samples or some: sums over all counts. The error of 780 cells at 95 %, and 1 %.
        let samples = 100_000;
        let means = [0.02, 0.2, 0.7, 2.0, 5.0, 12.0, 30.0];
        for alpha in [0.05 / 780.0, 0.01] {
            for first in means {
                for second in means {
                    let truth = (first - second) / samples as f64;
                    let (mut paired, mut unpaired, mut dependent) = (0.0, 0.0, 0.0);
                    for (b, weight) in poisson(first).into_iter().enumerate() {
                        for (c, other) in poisson(second).into_iter().enumerate() {
                            if weight * other < 1e-13 {
                                continue;
                            }
                            let (b, c) = (b as u64, c as u64);
                            let misses =
                                |d: Difference| if d.low <= truth && truth <= d.high { 0.0 } else { weight * other };
                            paired += misses(paired_difference(&pairs(0, b, c, samples - b - c), 1.0 - alpha));
                            unpaired += misses(unpaired_difference(b, samples, c, samples, 1.0 - alpha));
                            dependent += misses(dependent_difference(b, samples, c, samples, 1.0 - alpha));
                        }
                    }
                    for (name, missed) in [("paired", paired), ("unpaired", unpaired), ("dependent", dependent)] {
                        assert!(missed <= alpha, "{name} {alpha} {first} {second}: {missed}");
                    }
                }
            }
        }
    }

    #[test]
    fn exact_paired_limits_are_little_wider_for_many_pairs() {
        let counts = pairs(30_000, 1000, 1050, 67_950);
        let (exact, score) = (exact_paired(&counts, 0.9999), tango(&counts, 0.9999));
        let ratio = (exact.1 - exact.0) / (score.1 - score.0);
        assert!((1.0..1.2).contains(&ratio), "{ratio}");
        assert_eq!(exact_paired(&pairs(0, 0, 0, 100), 0.99).0, -exact_paired(&pairs(0, 0, 0, 100), 0.99).1);
        // Each of the two intervals has half of the error: 40 of 40 differ, all in one direction.
        let end = 0.0025_f64.powf(1.0 / 40.0);
        let all = exact_paired(&pairs(0, 40, 0, 0), 0.99);
        assert!((all.0 - end * (2.0 * end - 1.0)).abs() < 1e-12 && all.1 == 1.0, "{all:?}");
    }

    #[test]
    fn samples_that_depend_on_each_other_are_covered() {
        // Unstable below 0.3 of a uniform deviate in the first, above 0.7 in the second: the difference scatters twice as
        // much as that of independent samples.
        let mut generator = Xoshiro256PlusPlus::seed_from_u64(6);
        let (mut independent, mut dependent, replicates, n) = (0, 0, 4000, 300);
        for _ in 0..replicates {
            let (mut first, mut second) = (0, 0);
            for _ in 0..n {
                let u = uniform(&mut generator);
                first += u64::from(u < 0.3);
                second += u64::from(u > 0.7);
            }
            let contains = |d: Difference| u32::from(d.low <= 0.0 && 0.0 <= d.high);
            independent += contains(unpaired_difference(first, n, second, n, 0.95));
            dependent += contains(dependent_difference(first, n, second, n, 0.95));
        }
        let share = |count: u32| f64::from(count) / f64::from(replicates);
        assert!(share(independent) < 0.91 && share(dependent) >= 0.95, "{} {}", share(independent), share(dependent));
    }
}
