//! Intervals against published examples, their definitions and their coverage.

use super::*;
use rand::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

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
fn samples_without_a_verdict_widen_the_interval_on_both_sides() {
    let interval = BinomialInterval::new(IntervalKind::Wilson, 0.95);
    let decided = interval.estimate(&VerdictCounts { stable: 60, unstable: 40, ..Default::default() });
    let with_undecided = interval.estimate(&VerdictCounts { stable: 50, unstable: 40, undecided: 7, failed: 3 });
    assert_eq!(with_undecided.probability, Some(40.0 / 90.0));
    assert_eq!(with_undecided.low, decided.low);
    assert_eq!(with_undecided.high, interval.bounds(50, 100).1);
    let none = interval.estimate(&VerdictCounts { undecided: 5, ..Default::default() });
    assert_eq!(none.probability, None);
    assert_eq!((none.low, none.high), (0.0, 1.0));
}

#[test]
fn wilsons_interval_has_its_coverage_on_average() {
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

/// Probability that the interval for `n` trials contains `p`, summed over all counts.
fn exact_coverage(interval: &BinomialInterval, n: u64, p: f64) -> f64 {
    let (mut coverage, mut mass) = (0.0, (1.0 - p).powi(n as i32));
    for k in 0..=n {
        let (low, high) = interval.bounds(k, n);
        if low <= p && p <= high {
            coverage += mass;
        }
        mass *= (n - k) as f64 / (k + 1) as f64 * p / (1.0 - p);
    }
    coverage
}

#[test]
fn exact_bounds_agree_with_published_examples() {
    // R. G. Newcombe, Statistics in Medicine 17 (1998), table I, method 5 (Clopper-Pearson).
    let interval = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95);
    for (k, n, low, high) in
        [(81, 263, 0.2527, 0.3676), (15, 148, 0.0578, 0.1617), (0, 20, 0.0, 0.1684), (1, 29, 0.0009, 0.1776)]
    {
        let bounds = interval.bounds(k, n);
        assert!((bounds.0 - low).abs() <= 0.5e-4 && (bounds.1 - high).abs() <= 0.5e-4, "{k}/{n}: {bounds:?}");
    }
}

#[test]
fn exact_bounds_have_their_closed_forms_at_zero_and_all() {
    for confidence in [0.5, 0.95, 1.0 - 1e-9] {
        let interval = BinomialInterval::new(IntervalKind::ClopperPearson, confidence);
        let tail: f64 = 0.5 * (1.0 - confidence);
        for n in [1u64, 20, 10_000, 1_000_000_000] {
            // (1 - high)^n = alpha / 2.
            let high = -(tail.ln() / n as f64).exp_m1();
            let (none, all) = (interval.bounds(0, n), interval.bounds(n, n));
            assert!(none.0 == 0.0 && (none.1 / high - 1.0).abs() < 1e-13, "{n}: {none:?}");
            assert!(all.1 == 1.0 && (all.0 - (1.0 - high)).abs() < 1e-15, "{n}: {all:?}");
        }
        assert_eq!(interval.bounds(0, 0), (0.0, 1.0));
    }
}

#[test]
fn clopper_and_pearsons_bounds_approach_wilsons() {
    // For large counts both tend to the normal interval, with differences of the order of half a count.
    let wilson = WilsonInterval::new(0.95);
    let exact = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95);
    for (k, n) in [(300_000, 1_000_000u64), (5_000_000_000, 10_000_000_000), (1_000_000, 10_000_000_000)] {
        let (a, b) = (wilson.bounds(k, n), exact.bounds(k, n));
        assert!((a.0 - b.0).abs() < 2.0 / n as f64 && (a.1 - b.1).abs() < 2.0 / n as f64, "{a:?} {b:?}");
        let mirrored = exact.bounds(n - k, n);
        assert!((mirrored.0 - (1.0 - b.1)).abs() < 1e-15 && (mirrored.1 - (1.0 - b.0)).abs() < 1e-15);
    }
}

#[test]
fn both_kinds_count_samples_without_a_verdict_against_both_ends() {
    let counts = VerdictCounts { stable: 50, unstable: 40, undecided: 7, failed: 3 };
    for kind in [IntervalKind::Wilson, IntervalKind::ClopperPearson] {
        let interval = BinomialInterval::new(kind, 0.95);
        let estimate = interval.estimate(&counts);
        assert_eq!(estimate.probability, Some(40.0 / 90.0));
        assert_eq!((estimate.low, estimate.high), (interval.bounds(40, 100).0, interval.bounds(50, 100).1));
    }
}

#[test]
fn clopper_and_pearsons_interval_has_at_least_its_coverage_at_every_probability() {
    for confidence in [0.8, 0.95, 0.999] {
        let interval = BinomialInterval::new(IntervalKind::ClopperPearson, confidence);
        let wilson = BinomialInterval::new(IntervalKind::Wilson, confidence);
        for n in [10, 40] {
            let (mut least, mut least_of_wilson) = (1.0_f64, 1.0_f64);
            for i in 1..1000 {
                let p = f64::from(i) / 1000.0;
                least = least.min(exact_coverage(&interval, n, p));
                least_of_wilson = least_of_wilson.min(exact_coverage(&wilson, n, p));
            }
            assert!(least >= confidence - 1e-12, "{n} at {confidence}: {least}");
            // Wilson's interval does not promise this.
            assert!(least_of_wilson < confidence, "{n} at {confidence}: {least_of_wilson}");
        }
    }
}

fn uniform(generator: &mut Xoshiro256PlusPlus) -> f64 {
    (generator.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

#[test]
fn estimates_from_partly_undecided_verdicts_cover_the_true_probability() {
    // One sample in twenty of either kind has no verdict. The interval holds whatever the verdict would be, so that its
    // coverage is at least the confidence.
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(1927);
    let (p, samples, repetitions) = (0.1, 200, 4000);
    let intervals = [IntervalKind::Wilson, IntervalKind::ClopperPearson].map(|kind| BinomialInterval::new(kind, 0.95));
    for share in [0.0, 0.05] {
        let mut covered = [0; 2];
        for _ in 0..repetitions {
            let mut counts = VerdictCounts::default();
            for _ in 0..samples {
                let unstable = uniform(&mut generator) < p;
                match (uniform(&mut generator) < share, unstable) {
                    (true, true) => counts.undecided += 1,
                    (true, false) => counts.failed += 1,
                    (false, true) => counts.unstable += 1,
                    (false, false) => counts.stable += 1,
                }
            }
            for (covered, interval) in covered.iter_mut().zip(&intervals) {
                let estimate = interval.estimate(&counts);
                *covered += u32::from(estimate.low <= p && p <= estimate.high);
            }
        }
        let [wilson, exact] = covered.map(|count| f64::from(count) / f64::from(repetitions));
        if share == 0.0 {
            // Exact coverage at this p and n, SciPy 1.17: 0.9561 and 0.9669.
            assert!((wilson - 0.9561).abs() < 0.012, "{wilson}");
            assert!((exact - 0.9669).abs() < 0.012, "{exact}");
        } else {
            assert!(wilson > 0.98 && exact > 0.98, "{wilson} {exact}");
        }
    }
}

#[test]
fn simultaneous_intervals_all_cover_together() {
    // 20 cells of 60 samples: independent ones, and ones that share half of their random numbers.
    let (cells, samples, repetitions) = (20, 60, 2000);
    let each = BinomialInterval::new(IntervalKind::ClopperPearson, simultaneous_confidence(0.95, cells));
    let plain = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95);
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(1936);
    for shared in [0, samples / 2] {
        let (mut all_cover, mut all_cover_plainly) = (0, 0);
        for _ in 0..repetitions {
            let common: Vec<f64> = (0..shared).map(|_| uniform(&mut generator)).collect();
            let (mut together, mut plainly) = (true, true);
            for cell in 0..cells {
                let p = 0.05 + 0.03 * cell as f64;
                let own = (shared..samples).filter(|_| uniform(&mut generator) < p).count();
                let successes = own + common.iter().filter(|&&u| u < p).count();
                let contains = |(low, high): (f64, f64)| low <= p && p <= high;
                together &= contains(each.bounds(successes as u64, samples));
                plainly &= contains(plain.bounds(successes as u64, samples));
            }
            all_cover += u32::from(together);
            all_cover_plainly += u32::from(plainly);
        }
        let [together, plainly] = [all_cover, all_cover_plainly].map(|count| f64::from(count) / f64::from(repetitions));
        assert!(together >= 0.95, "{shared}: {together}");
        assert!(plainly < 0.8, "{shared}: {plainly}");
    }
    assert_eq!(simultaneous_confidence(0.95, 1), 0.95);
}

#[test]
fn any_counts_have_an_interval() {
    let counts = [0, 1, 2, 1000, 1 << 32, 1 << 53, (1 << 53) + 1, 1 << 63, u64::MAX - 1, u64::MAX];
    for kind in [IntervalKind::Wilson, IntervalKind::ClopperPearson] {
        for confidence in [0.5, 0.95, 1.0 - 1e-12] {
            let interval = BinomialInterval::new(kind, confidence);
            for successes in counts {
                for trials in counts {
                    let (low, high) = interval.bounds(successes, trials);
                    // Counts from 2^53 up have more digits than the numbers that stand for them.
                    let are_ends = 0.0 <= low && low <= high + 1e-15 && high <= 1.0;
                    assert!(are_ends, "{kind:?} {successes} {trials}: {low} {high}");
                    if successes >= trials {
                        assert_eq!(high, 1.0);
                    }
                }
            }
        }
    }
}
