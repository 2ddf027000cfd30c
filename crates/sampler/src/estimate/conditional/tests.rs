//! Sums in any order, intervals, and their coverage against a closed form.

use super::*;
use crate::draw::beyond;
use crate::draw::deviates::{DeviateStream, Points};
use crate::estimate::interval::{BinomialInterval, IntervalKind};
use crate::estimate::randomisations;
use crate::special_functions::normal;
use proptest::prelude::*;
use stickslip_core::model::verdict::VerdictCounts;

fn totals(sums: &ProbabilitySums) -> Vec<i128> {
    sums.sums().map(i128::from).to_vec()
}

fn part(probabilities: &[f64], failed: u64) -> ConditionalPart {
    let mut sums = ProbabilitySums::default();
    probabilities.iter().for_each(|&p| sums.add(1.0, Some(p)));
    (0..failed).for_each(|_| sums.add(1.0, None));
    ConditionalPart::from_sums(&totals(&sums))
}

/// The estimate from 16 randomisations of so many Sobol points of the other inputs and those beyond, which have these probabilities.
fn sampled(seed: u64, points: u64, dimensions: usize, given: impl Fn(&[f64]) -> f64) -> Estimate {
    let stream = DeviateStream { seed, common_random_numbers: false, dimensions, points: Points::Sobol };
    let part = |randomisation: u64| {
        let mut sums = ProbabilitySums::default();
        for z in stream.draw(0, randomisation, 0..points).chunks_exact(dimensions) {
            sums.add(beyond::weight(z), Some(given(z)));
        }
        let far = stream.draw(0, beyond::RANDOMISATIONS + randomisation, beyond::beside(0..points, randomisation));
        for z in far.chunks_exact(dimensions) {
            let mut point = z.to_vec();
            let weight = beyond::move_out(&mut point);
            sums.add(weight, Some(given(&point)));
        }
        ConditionalPart::from_sums(&totals(&sums))
    };
    estimate(&(0..16).map(part).collect::<Vec<_>>(), 0.95)
}

#[test]
fn probabilities_keep_their_digits() {
    for p in [1.0, 0.5, 0.1, 1.0 - f64::EPSILON, 1e-3, 1e-9, 1e-12, 0.0] {
        let one = part(&[p], 0);
        assert_eq!((one.unstable[0], one.points, one.failed), (p, 1.0, 0.0));
        assert!((one.unstable[1] - p * p).abs() <= 1e-12 * p * p, "{p}: {:?}", one.unstable);
        assert!((one.stable[1] - (1.0 - p) * (1.0 - p)).abs() <= 1e-12, "{p}: {:?}", one.stable);
        assert!((one.products - p * (1.0 - p)).abs() <= 1e-12 * p, "{p}: {}", one.products);
        let many = part(&vec![p; 1000], 0);
        assert!((many.unstable[0] - 1000.0 * p).abs() <= 2e-13 * p * 1000.0);
    }
    // A sum of 2^32 words of ones does not overflow.
    let word = totals(&part_sums(1.0))[0];
    assert!(word.checked_mul(1 << 32).is_some_and(|sum| sum < i128::from(i64::MAX)));
    assert!((part(&[1e-30], 0).unstable[0] / 1e-30 - 1.0).abs() < 1e-5);
}

fn part_sums(probability: f64) -> ProbabilitySums {
    let mut sums = ProbabilitySums::default();
    sums.add(1.0, Some(probability));
    sums
}

proptest! {
    #[test]
    fn sums_are_the_same_in_any_order(exponents in prop::collection::vec(-40.0_f64..0.0, 1..60), turn in 0_usize..60) {
        let mut probabilities: Vec<f64> = exponents.iter().map(|exponent| exponent.exp()).collect();
        let sum = |probabilities: &[f64]| {
            let mut sums = ProbabilitySums::default();
            probabilities.iter().for_each(|&p| sums.add(1.0, Some(p)));
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
        let total = ConditionalPart::from_sums(&totals(&forwards)).unstable[0];
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

/// The share of seeds whose interval contains a probability.
fn coverage(seeds: u64, (points, dimensions): (u64, usize), p: f64, given: impl Fn(&[f64]) -> f64) -> f64 {
    let covers = |seed: &u64| {
        let Estimate { low, high, .. } = sampled(*seed, points, dimensions, &given);
        low <= p && p <= high
    };
    (0..seeds).filter(covers).count() as f64 / seeds as f64
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn intervals_contain_a_probability_in_closed_form() {
    // Given the others, a sum of normal deviates exceeds its limit with the tail of the rest.
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
        let share =
            coverage(300, (points, dimensions), p, |z| normal::upper_tail((limit - z.iter().sum::<f64>()) / rest));
        // 0.95 with a standard error of 0.013.
        assert!(share > 0.91, "{points} {dimensions} {limit} {rest} {p}: {share}");
    }
}

/// Points of few other inputs whose probabilities are smooth: nets are so precise that the weights beside the points beyond show.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn intervals_of_smooth_probabilities_contain_them() {
    for (points, dimensions, bend) in [(2048, 1, 0.1), (2048, 1, 1.0), (1024, 2, 0.1)] {
        let given = |z: &[f64]| 0.05 * libm::exp(-0.5 * bend * z.iter().map(|z| z * z).sum::<f64>());
        let p = 0.05 * libm::pow(1.0 + bend, -0.5 * dimensions as f64);
        let share = coverage(60, (points, dimensions), p, given);
        // 0.95 with a standard error of 0.028.
        assert!(share > 0.86, "{points} {dimensions} {bend}: {share}");
    }
}

/// Parts of 1000 points that all agree, of which so many matter: they are 1, all others 0.
fn agreeing(matter: f64, failed: u64) -> [ConditionalPart; 16] {
    [ConditionalPart::unweighted(1000, failed, matter / 16.0, matter / 16.0); 16]
}

#[test]
fn parts_that_agree_are_no_surer_than_so_many_independent_points() {
    let found = estimate(&agreeing(800.0, 0), 0.95);
    let (mean, half_width) = (0.05, 1.95 * (0.05 * 0.95 / 16_000.0_f64).sqrt());
    assert!(found.low < mean - half_width && found.high > mean + half_width, "{found:?}");
}

/// Points with the other probability each.
fn mirrored(part: &ConditionalPart) -> ConditionalPart {
    ConditionalPart { unstable: part.stable, stable: part.unstable, ..*part }
}

#[test]
fn stable_and_unstable_sides_are_mirror_images() {
    for matter in [50.0, 150.0, 500.0, 3000.0] {
        for share in [0.3, 0.8] {
            // Probabilities of `share`, and of 1 minus it.
            let scatter = |i: usize| 1.0 + 0.1 * (i as f64 - 7.5) / 8.0;
            let part = |i: usize| {
                let count = matter / 16.0 * scatter(i);
                ConditionalPart::unweighted(1000, 0, count * share, count * share * share)
            };
            let parts: Vec<ConditionalPart> = (0..16).map(part).collect();
            let mirror: Vec<ConditionalPart> = parts.iter().map(mirrored).collect();
            let [found, mirror] = [parts, mirror].map(|parts| estimate(&parts, 0.95));
            assert!((found.low + mirror.high - 1.0).abs() < 1e-9, "{matter} {share}: {found:?} {mirror:?}");
            assert!((found.high + mirror.low - 1.0).abs() < 1e-9, "{matter} {share}: {found:?} {mirror:?}");
        }
    }
}

#[test]
fn rare_points_that_failed_widen_either_side_by_their_share() {
    for matter in [60.0, 150.0] {
        let widened = |parts: [ConditionalPart; 16], with_failed: [ConditionalPart; 16]| {
            let [without, with] = [parts, with_failed].map(|parts| estimate(&parts, 0.95));
            [without.low - with.low, with.high - without.high]
        };
        let [low, high] = widened(agreeing(matter, 0), agreeing(matter, 10));
        assert!(low.abs() < 1e-12 && (high - 0.01).abs() < 1e-12, "{low} {high}");
        // Where stability is rare.
        let frequent = |failed: u64| agreeing(matter, failed).map(|part| mirrored(&part));
        let [low, high] = widened(frequent(0), frequent(10));
        assert!((low - 0.01).abs() < 1e-12 && (0.0..1e-3).contains(&high), "{low} {high}");
    }
}

#[test]
fn any_numbers_have_an_interval() {
    let numbers = [f64::NAN, f64::INFINITY, -1e300, -1.0, 0.0, 1e-300, 0.5, 1.0, 1000.0, 9e15, 9.3e18, 1e300];
    for at_least in numbers {
        for trials in numbers {
            for at_most in [at_least, 2.0 * at_least, 0.0] {
                let (low, high) = binomial(at_least, at_most, trials, 0.95);
                assert!((0.0..=1.0).contains(&low) && (0.0..=1.0).contains(&high), "{at_least} {trials}: {low} {high}");
            }
        }
    }
    // As of a piece whose sums are not those of its points.
    let part = |probabilities| ConditionalPart::unweighted(1000, 0, probabilities, probabilities);
    for probabilities in numbers {
        for parts in [vec![part(probabilities)], vec![part(probabilities); 16]] {
            let Estimate { low, high, .. } = estimate(&parts, 0.999);
            assert!(low.is_nan() || high.is_nan() || low <= 1.0, "{probabilities}: {low} {high}");
        }
    }
}

#[test]
fn sums_are_those_of_probabilities() {
    let sums = |probabilities: &[f64]| {
        let mut sums = ProbabilitySums::default();
        probabilities.iter().for_each(|&probability| sums.add(1.0, Some(probability)));
        sums.add(1.0, None);
        sums.sums()
    };
    for probabilities in [&[0.0; 3][..], &[1.0; 3], &[1e-30, 1.0 - 1e-16, 0.3]] {
        assert!(ProbabilitySums::can_be(&sums(probabilities), 4), "{probabilities:?}");
    }
    assert!(!ProbabilitySums::can_be(&sums(&[0.5, 0.6]), 1), "three points of one sample and one beyond");
    let sound = sums(&[0.25, 0.5]);
    for place in (0..SUMS).map(|sum| sum * WORDS) {
        for value in [1 << 53, i64::MAX, i64::MIN, -1 << 20] {
            let mut forged = sound;
            forged[place] = value;
            assert!(!ProbabilitySums::can_be(&forged, 3), "{forged:?}");
        }
    }
    assert!(ProbabilitySums::can_be(&sound, 3) && !ProbabilitySums::can_be(&sound[..3], 3));
}

/// Points of one probability: the interval reaches as far as a region could that none of them met.
#[test]
fn points_that_are_all_alike_leave_room_for_what_none_met() {
    for p in [2.867e-7, 0.3, 1.0 - 1e-9] {
        let parts: Vec<ConditionalPart> = (0..16).map(|_| part(&[p; 625], 0)).collect();
        let Estimate { low, high, .. } = estimate(&parts, 0.95);
        // None of 10,000 has a probability of a fortieth.
        let unmet = 1.0 - 0.025_f64.powf(1e-4);
        assert!((high - (p + unmet * (1.0 - p))).abs() < 1e-9, "{p}: {high}");
        // Next to 1 few points of stability matter, which widens it further.
        assert!(low < p * (1.0 - unmet) + 1e-9 && (p > 0.9 || low > p * (1.0 - unmet) - 1e-9), "{p}: {low}");
        // So it does where they depend a little on the other inputs; points that scatter are evidence.
        let scattered = |by: f64| {
            let probabilities: Vec<f64> = (0..625).map(|i| p * (1.0 - by * f64::from(i % 5))).collect();
            estimate(&vec![part(&probabilities, 0); 16], 0.95)
        };
        let [little, more] = [0.001, 0.05].map(scattered);
        assert!(little.high > high - 0.01 * p, "{p}: {little:?}");
        assert!(p > 0.9 || more.high < high - 0.05 * p, "{p}: {more:?}");
    }
}

/// Points of one probability have it as their mean, whatever their weights; and weights that differ are no scatter.
#[test]
fn weights_change_no_probability_that_all_points_have() {
    let part = |shift: usize| {
        let mut sums = ProbabilitySums::default();
        (0..625).for_each(|i| sums.add(1.0 / ((i + shift) % 7 + 1) as f64, Some(0.3)));
        ConditionalPart::from_sums(&totals(&sums))
    };
    let found = estimate(&(0..16).map(part).collect::<Vec<_>>(), 0.95);
    let points: f64 = (0..16).map(|shift| part(shift).points).sum();
    let unmet = 1.0 - 0.025_f64.powf(1.0 / points);
    assert!((found.probability.unwrap() - 0.3).abs() < 1e-12, "{found:?}");
    assert!((found.high - 0.3 - 0.7 * unmet).abs() < 1e-9 && (found.low - 0.3 + 0.3 * unmet).abs() < 1e-9, "{found:?}");
    // A point without a model has its weight.
    let mut sums = ProbabilitySums::default();
    sums.add(0.5, Some(0.25));
    sums.add(0.125, None);
    let ConditionalPart { points, failed, unstable, stable, products } = ConditionalPart::from_sums(&totals(&sums));
    assert_eq!((points, failed, products), (0.625, 0.125, 0.125 * 0.375));
    assert_eq!((unstable, stable), ([0.125, 0.015_625], [0.375, 0.140_625]));
}

/// A second region five standard deviations out, which has a third of the probability and which one of eight million points with
/// the distribution of the inputs meets.
#[test]
fn a_region_beyond_all_points_of_the_inputs_is_in_the_estimate() {
    let given = |z: &[f64]| 1e-7 * libm::exp(-0.3 * z[0] - 0.045) + if z[0] < -5.15 { 0.4 } else { 0.0 };
    let truth = 1e-7 + 0.4 * normal::upper_tail(5.15);
    for seed in 0..20 {
        let found = sampled(seed, 256, 1, given);
        assert!(found.low <= truth && truth <= found.high && found.high < 2.0 * truth, "seed {seed}: {found:?}");
        assert!((found.probability.unwrap() / truth - 1.0).abs() < 0.15, "seed {seed}: {found:?}");
    }
}
