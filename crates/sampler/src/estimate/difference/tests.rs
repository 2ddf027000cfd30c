//! Intervals of differences against published examples, their definitions and their coverage.

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
fn paired_intervals_have_their_coverage() {
    // Share of seeded repetitions; the score interval is approximate, so the mean over the settings is near the
    // confidence and none is far below.
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(1998);
    let (repetitions, n) = (4000, 200);
    let mut mean = 0.0;
    let settings = [(0.3, 0.10, 0.05), (0.0, 0.03, 0.02), (0.5, 0.2, 0.2), (0.9, 0.05, 0.01)];
    for (both, only_first, only_second) in settings {
        let mut covered = 0;
        for _ in 0..repetitions {
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
        let coverage = f64::from(covered) / f64::from(repetitions);
        assert!((0.93..0.98).contains(&coverage), "{only_first} {only_second}: {coverage}");
        mean += coverage / settings.len() as f64;
    }
    assert!((mean - 0.95).abs() < 0.01, "{mean}");
}

#[test]
fn unpaired_intervals_have_their_coverage() {
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(873);
    let repetitions = 4000;
    let mut mean = 0.0;
    let settings = [(0.5, 100, 0.4, 150), (0.02, 400, 0.05, 200), (0.9, 80, 0.9, 80), (0.3, 50, 0.01, 500)];
    for (p1, n1, p2, n2) in settings {
        let mut covered = 0;
        for _ in 0..repetitions {
            let mut count = |p: f64, n: u64| (0..n).filter(|_| uniform(&mut generator) < p).count() as u64;
            let difference = unpaired_difference(count(p1, n1), n1, count(p2, n2), n2, 0.95);
            covered += u32::from(difference.low <= p1 - p2 && p1 - p2 <= difference.high);
        }
        let coverage = f64::from(covered) / f64::from(repetitions);
        assert!((0.93..0.98).contains(&coverage), "{p1} {p2}: {coverage}");
        mean += coverage / settings.len() as f64;
    }
    assert!((mean - 0.95).abs() < 0.015, "{mean}");
}

/// The Poisson distribution, up to numbers of negligible probability.
fn poisson(mean: f64) -> Vec<f64> {
    let mut mass = vec![(-mean).exp()];
    while mass.len() as f64 <= mean + 10.0 * mean.sqrt() + 25.0 {
        mass.push(mass[mass.len() - 1] * mean / mass.len() as f64);
    }
    mass
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn beyond_95_percent_no_difference_has_less_than_its_coverage() {
    // Rare events, at most a few in 10,000 samples: sums over all counts, with the error of 780 cells at 95 % and with
    // 1 %.
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
fn dependent_samples_have_their_coverage() {
    // Unstable below 0.3 of a uniform deviate in the first, above 0.7 in the second: the difference scatters twice as
    // much as that of independent samples.
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(6);
    let (mut independent, mut dependent, repetitions, n) = (0, 0, 4000, 300);
    for _ in 0..repetitions {
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
    let share = |count: u32| f64::from(count) / f64::from(repetitions);
    assert!(share(independent) < 0.91 && share(dependent) >= 0.95, "{} {}", share(independent), share(dependent));
}

#[test]
fn without_an_unstable_sample_each_end_has_half_of_the_error() {
    // None of n: the end solves (1 - p)^n = a quarter of the error, as either probability has half of it, on two sides.
    for confidence in [0.95, 0.99] {
        for (first, second) in [(50, 80), (1000, 30)] {
            let found = dependent_difference(0, first, 0, second, confidence);
            let end = |trials: u64| 1.0 - (0.25 * (1.0 - confidence)).powf(1.0 / trials as f64);
            assert!((found.high - end(first)).abs() < 1e-12 && (found.low + end(second)).abs() < 1e-12, "{found:?}");
        }
    }
}
