//! Sums in any order, intervals, and their coverage against a closed form.

use super::*;
use crate::draw::deviates::{DeviateStream, Points};
use crate::estimate::interval::{BinomialInterval, IntervalKind};
use crate::estimate::randomisations;
use crate::special_functions::normal;
use proptest::prelude::*;
use stickslip_core::verdict::VerdictCounts;

fn totals(sums: &ProbabilitySums) -> Vec<i128> {
    sums.sums().map(i128::from).to_vec()
}

fn part(probabilities: &[f64], failed: u64) -> ConditionalPart {
    let mut sums = ProbabilitySums::default();
    probabilities.iter().for_each(|&p| sums.add(p));
    ConditionalPart::from_sums(probabilities.len() as u64 + failed, failed, &totals(&sums))
}

#[test]
fn probabilities_keep_their_digits() {
    for p in [1.0, 0.5, 0.1, 1.0 - f64::EPSILON, 1e-3, 1e-9, 1e-12, 0.0] {
        let one = part(&[p], 0);
        assert_eq!(one.probabilities, p);
        assert!((one.squares - p * p).abs() <= 1e-12 * p * p, "{p}: {}", one.squares);
        let many = part(&vec![p; 1000], 0);
        assert!((many.probabilities - 1000.0 * p).abs() <= 2e-13 * p * 1000.0);
    }
    // A sum of 2^32 words of ones does not overflow.
    let word = totals(&part_sums(1.0))[0];
    assert!(word.checked_mul(1 << 32).is_some_and(|sum| sum < i128::from(i64::MAX)));
    assert!((part(&[1e-30], 0).probabilities / 1e-30 - 1.0).abs() < 1e-5);
}

fn part_sums(probability: f64) -> ProbabilitySums {
    let mut sums = ProbabilitySums::default();
    sums.add(probability);
    sums
}

proptest! {
    #[test]
    fn sums_are_the_same_in_any_order(exponents in prop::collection::vec(-40.0_f64..0.0, 1..60), turn in 0_usize..60) {
        let mut probabilities: Vec<f64> = exponents.iter().map(|exponent| exponent.exp()).collect();
        let sum = |probabilities: &[f64]| {
            let mut sums = ProbabilitySums::default();
            probabilities.iter().for_each(|&p| sums.add(p));
            sums
        };
        let forwards = sum(&probabilities);
        let parts = probabilities.len() / 2;
        let halves = [sum(&probabilities[parts..]), sum(&probabilities[..parts])];
        let added: Vec<i64> = halves[0].sums().iter().zip(halves[1].sums()).map(|(a, b)| a + b).collect();
        prop_assert_eq!(&added[..], &forwards.sums()[..]);
        probabilities.rotate_left(turn % exponents.len());
        probabilities.reverse();
        prop_assert_eq!(sum(&probabilities), forwards);
        let exact: f64 = probabilities.iter().sum();
        let total = ConditionalPart::from_sums(1, 0, &totals(&forwards)).probabilities;
        prop_assert!((total / exact - 1.0).abs() < 1e-13);
    }
}

#[test]
fn verdicts_have_an_interval_that_contains_that_of_counts() {
    for counts in [[300, 340, 290, 350], [3, 0, 1, 2], [0; 4], [1000; 4], [999, 1000, 998, 1000]] {
        let parts = counts.map(|unstable| {
            let mut probabilities = vec![1.0; unstable];
            probabilities.resize(1000, 0.0);
            part(&probabilities, 0)
        });
        let counted = counts.map(|count| VerdictCounts {
            unstable: count as u64,
            stable: 1000 - count as u64,
            ..VerdictCounts::default()
        });
        for confidence in [0.9, 0.95, 0.99] {
            let (own, other) = (estimate(&parts, confidence), randomisations::estimate(&counted, 2, confidence));
            assert!((own.probability.unwrap() - other.probability.unwrap()).abs() < 1e-15);
            assert!(own.low <= other.low + 1e-15 && own.high >= other.high - 1e-15, "{own:?} {other:?}");
            assert!(own.high - own.low < 2.0 * (other.high - other.low), "{own:?} {other:?}");
        }
    }
    // 2000 points matter: the interval is Student's but for its curvature. SciPy: t.interval(0.95, 3, mean, sem).
    let parts = [0.3, 0.34, 0.29, 0.35].map(|p| part(&vec![p; 2000], 0));
    let own = estimate(&parts, 0.95);
    assert!((own.high - 0.32 * ((0.366_844_341_2_f64 - 0.32) / 0.32).exp()).abs() < 1e-9, "{own:?}");
    assert!((own.low - (1.0 - 0.68 * ((0.32_f64 - 0.273_155_658_8) / 0.68).exp())).abs() < 1e-9, "{own:?}");
}

#[test]
fn points_without_a_brake_widen_the_interval_on_one_side_each() {
    let parts = |failed: u64| [0.2, 0.21, 0.19, 0.2].map(|p| part(&vec![p; 1000 - failed as usize], failed));
    let (whole, failed) = (estimate(&parts(0), 0.95), estimate(&parts(100), 0.95));
    assert!((failed.probability.unwrap() - 0.2).abs() < 1e-14);
    assert!((failed.low - 0.9 * whole.low).abs() < 1e-2 && failed.low < whole.low, "{failed:?}");
    assert!((failed.high - (0.9 * whole.high + 0.1)).abs() < 1e-2, "{failed:?}");
    let none = estimate(&[part(&[], 1000); 4], 0.95);
    assert_eq!((none.probability, none.low, none.high), (None, 0.0, 1.0));
    assert_eq!(estimate(&[], 0.95), Estimate { probability: None, low: 0.0, high: 1.0 });
}

#[test]
fn few_points_that_matter_are_as_good_as_few_samples() {
    // One point in each of sixteen randomisations has nearly all of the probability.
    let mut probabilities = vec![1e-9; 1000];
    probabilities[0] = 0.5;
    let few = estimate(&[part(&probabilities, 0); 16], 0.95);
    let (low, high) = BinomialInterval::new(IntervalKind::ClopperPearson, 0.95).bounds(8, 16_000);
    assert!((few.low - low).abs() < 1e-8 && (few.high - high).abs() < 1e-8, "{few:?} {low} {high}");
    // Many that contribute alike need no such interval, however small their probabilities are.
    let many = estimate(&[part(&vec![1e-9; 1000], 0), part(&vec![1.1e-9; 1000], 0)], 0.95);
    assert!(many.high < 3e-9 && many.low < 1e-9, "{many:?}");
}

#[test]
fn intervals_contain_a_probability_in_closed_form() {
    // Given the others, a sum of normal deviates exceeds its limit with the tail of the rest.
    let seeds = 300;
    for (points, dimensions, limit, rest) in [
        (64, 1, 6.0, 1.5),
        (64, 3, 2.0, 1.5),
        (64, 3, 6.0, 1.5),
        (128, 3, 12.0, 3.0),
        (64, 3, 1.0, 0.3),
        (128, 9, 16.8, 3.0),
    ] {
        let variance = rest * rest + dimensions as f64;
        let p = normal::upper_tail(limit / variance.sqrt());
        let mut covered = 0;
        for seed in 0..seeds {
            let stream = DeviateStream { seed, common_random_numbers: false, dimensions, points: Points::Sobol };
            let parts: Vec<ConditionalPart> = (0..16)
                .map(|randomisation| {
                    let deviates = stream.draw(0, randomisation, 0..points);
                    let given = |z: &[f64]| normal::upper_tail((limit - z.iter().sum::<f64>()) / rest);
                    part(&deviates.chunks_exact(dimensions).map(given).collect::<Vec<_>>(), 0)
                })
                .collect();
            let estimate = estimate(&parts, 0.95);
            covered += u32::from(estimate.low <= p && p <= estimate.high);
        }
        let share = f64::from(covered) / seeds as f64;
        // 0.95 with a standard error of 0.013.
        assert!(share > 0.91, "{points} {dimensions} {limit} {rest} {p}: {share}");
    }
}
