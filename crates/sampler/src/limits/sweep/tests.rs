//! Sweeps against counts at single values, and the coverage of their bounds.

use std::convert::Infallible;

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use stickslip_core::model::verdict::VerdictCounts;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

use super::*;
use crate::draw::deviates::{DeviateStream, Points};
use crate::estimate::interval::{Estimate, IntervalKind};
use crate::integrate::NormalPair;
use crate::integrate::closed_form::probability;
use crate::limits::scan::{Scan, scanned_values};
use crate::limits::spans::{OutsidePhysics, Sample};

fn interval() -> BinomialInterval {
    BinomialInterval::new(IntervalKind::ClopperPearson, 0.95)
}

fn sweep(range: Span, spans: &[Spans]) -> SortedSweep {
    let mut sweep = Sweep::new(range);
    spans.iter().for_each(|spans| sweep.add(spans));
    sweep.sorted()
}

fn unstable(from: f64, to: f64) -> Spans {
    Spans { unstable: [from, to], without_verdict: [[0.0; 2]; 2] }
}

#[test]
fn limits_are_order_statistics_of_critical_values() {
    // Sample i is unstable above i: at v as many are unstable as there are numbers below v.
    let spans: Vec<Spans> = (1..=1000).rev().map(|i| unstable(f64::from(i), f64::INFINITY)).collect();
    let sweep = sweep([0.0, 2000.0], &spans);
    assert_eq!((sweep.samples(), sweep.ends()), (1000, [Some(0.0), Some(1.0)]));
    for (target, rank) in [(0.01, 11.0), (0.25, 251.0), (0.9994, 1000.0)] {
        let limits = sweep.limits(target, &interval());
        let [Limit { state: State::Rises, value: Some(value), bounds: Some([low, high]) }] = limits[..] else {
            panic!("{limits:?}")
        };
        assert_eq!(value, rank, "{target}");
        // Up to the bounds the interval contains the target, and beyond them it does not.
        let bounds = |count: f64| interval().bounds(count as u64, 1000);
        assert!(bounds(low).1 > target && bounds(low - 1.0).1 <= target, "{low}");
        assert!(high == 2000.0 || bounds(high).0 > target && bounds(high - 1.0).0 <= target, "{high}");
    }
}

#[test]
fn without_a_limit_the_sweep_says_where_the_interval_leaves_it_open() {
    let spans: Vec<Spans> = (1..=1000).map(|i| unstable(f64::from(i), f64::INFINITY)).collect();
    let of = |range, target| sweep(range, &spans).limits(target, &interval());
    assert_eq!(of([0.0, 10.0], 0.5), [Limit { state: State::Within, value: None, bounds: None }]);
    assert_eq!(of([700.0, 900.0], 0.5), [Limit { state: State::Above, value: None, bounds: None }]);
    let limits = of([0.0, 490.0], 0.5);
    let [Limit { state: State::Within, value: None, bounds: Some([low, 490.0]) }] = limits[..] else {
        panic!("{limits:?}")
    };
    assert!((460.0..480.0).contains(&low), "{low}");
    let limits = of([510.0, 900.0], 0.5);
    let [Limit { state: State::Above, value: None, bounds: Some([510.0, high]) }] = limits[..] else {
        panic!("{limits:?}")
    };
    assert!((520.0..540.0).contains(&high), "{high}");
}

#[test]
fn jumps_and_samples_that_agree_are_taken_at_once() {
    // All samples are unstable above 3 and stable again above 5.
    let spans = vec![unstable(3.0, 5.0); 500];
    let limits = sweep([0.0, 10.0], &spans).limits(0.2, &interval());
    let expected = [(State::Rises, 3.0), (State::Falls, 5.0)];
    let expected = expected.map(|(state, at)| Limit { state, value: Some(at), bounds: Some([at, at]) });
    assert_eq!(limits, expected);
}

#[test]
fn entries_and_exits_near_each_other_are_one_passage() {
    // The share wavers around the target while it rises: of three samples one leaves.
    let mut spans = Vec::new();
    for i in 0..3000 {
        let at = f64::from(i);
        spans.push(unstable(at, if i % 3 == 0 { at + 0.5 } else { f64::INFINITY }));
    }
    let limits = sweep([-1.0, 5000.0], &spans).limits(0.3, &interval());
    assert_eq!(limits.len(), 1, "{limits:?}");
    let Limit { state: State::Rises, value: Some(value), bounds: Some([low, high]) } = limits[0] else {
        panic!("{limits:?}")
    };
    // The first value at which more than 900 are unstable.
    assert_eq!(value, 1350.0, "{limits:?}");
    assert!(low < 1320.0 && high > 1380.0);
}

#[test]
fn a_share_that_rises_and_falls_has_two_limits() {
    let mut spans: Vec<Spans> = (0..2000).map(|i| unstable(f64::from(i), 4000.0 + 2.0 * f64::from(i))).collect();
    spans.extend(vec![unstable(0.0, 0.0); 2000]);
    let sweep = sweep([0.0, 10_000.0], &spans);
    let limits = sweep.limits(0.2, &interval());
    let [rise, fall] = limits[..] else { panic!("{limits:?}") };
    assert_eq!((rise.state, rise.value), (State::Rises, Some(800.0)));
    assert_eq!((fall.state, fall.value), (State::Falls, Some(4000.0 + 2.0 * 1199.0)));
    for limit in limits {
        let [low, high] = limit.bounds.unwrap();
        assert!(low < limit.value.unwrap() && limit.value.unwrap() < high);
    }
    // At half of the samples the share stops at the target: it is within it.
    assert_eq!(sweep.limits(0.5, &interval())[0].state, State::Within);
}

#[test]
fn sweeps_agree_with_counts_at_single_values() {
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut draw = move |scale: f64| scale * generator.random::<f64>();
    let spans: Vec<Spans> = (0..400)
        .map(|_| {
            let from = draw(1.0);
            let fails = draw(0.1);
            Spans {
                unstable: [from.max(fails), from + draw(1.0)],
                without_verdict: [[f64::NEG_INFINITY, fails], [9.0, f64::INFINITY]],
            }
        })
        .collect();
    let sweep = sweep([0.05, 1.5], &spans);
    for target in [0.1, 0.2, 0.35] {
        let counts = |value: f64| {
            let within = |[from, to]: Span| from < value && value < to;
            let unstable = spans.iter().filter(|spans| within(spans.unstable)).count() as u64;
            let failed =
                spans.iter().filter(|spans| spans.without_verdict.iter().any(|&span| within(span))).count() as u64;
            VerdictCounts { stable: 400 - unstable - failed, unstable, undecided: 0, failed }
        };
        let limits = sweep.limits(target, &interval());
        assert!(limits.iter().all(|limit| limit.value.is_some()), "{limits:?}");
        for limit in &limits {
            let [low, high] = limit.bounds.unwrap();
            let inside = |value: f64| {
                let estimate = interval().estimate(&counts(value));
                estimate.low <= target && target < estimate.high
            };
            let near = 1e-9;
            assert!(inside(low + near) && inside(high - near), "{target}: {limit:?}");
            assert!(low == 0.05 || !inside(low - near), "{target}: {limit:?}");
            assert!(high == 1.5 || !inside(high + near), "{target}: {limit:?}");
            let over = |value: f64| interval().estimate(&counts(value)).probability.unwrap() > target;
            let value = limit.value.unwrap();
            assert_eq!(
                (over(value - near), over(value + near)),
                match limit.state {
                    State::Rises => (false, true),
                    _ => (true, false),
                }
            );
        }
    }
}

#[test]
fn bounds_contain_the_exact_limit_as_often_as_they_say() {
    let boundary = PadOnDisc::new(Parameters::sui_ding_2018()).unwrap().stability_boundary();
    let wilson = BinomialInterval::new(IntervalKind::Wilson, 0.95);
    let (samples, seeds) = (500, 200);
    // Expected values of preload and friction and their relative standard deviations, the range and the target.
    for (varied, [preload, friction], stds, range, target) in [
        (0, [0.1, 0.39], [0.1, 0.0], [0.01, 0.3], 0.05),
        (0, [0.1, 0.39], [0.2, 0.1], [0.001, 0.3], 0.1),
        (1, [0.1, 0.39], [0.2, 0.1], [0.26, 0.6], 0.3),
    ] {
        let probability_at = |value: f64| {
            let mut inputs = NormalPair { expected: [preload, friction], relative_std: stds };
            inputs.expected[varied] = value;
            let found = probability(&boundary, &inputs);
            let [low, high] = found.bounds();
            Ok::<_, Infallible>(Estimate { probability: Some(found.value), low, high })
        };
        let scan = Scan::new(&scanned_values(&range, 256), 1e-12, probability_at).unwrap();
        let exact = scan.limits(target, probability_at).unwrap()[0].value.unwrap();
        let mut missed = [0, 0];
        for seed in 0..seeds {
            let stream = DeviateStream { seed, common_random_numbers: false, dimensions: 2, points: Points::Random };
            let mut sweep = Sweep::new(range);
            for z in stream.draw(0, 0, 0..samples).chunks(2) {
                let ratios = [1.0 + stds[0] * z[0], 1.0 + stds[1] * z[1]];
                let other = if varied == 0 { friction * ratios[1] } else { preload * ratios[0] };
                let sample = Sample { boundary, ratio: ratios[varied], other, most_second: f64::INFINITY };
                sweep.add(&Spans::new(&sample, varied, OutsidePhysics::Stable));
            }
            let sweep = sweep.sorted();
            assert_eq!(sweep.samples(), samples);
            for (missed, interval) in missed.iter_mut().zip([&wilson, &interval()]) {
                let limits = sweep.limits(target, interval);
                assert_eq!((limits.len(), limits[0].state), (1, State::Rises));
                let [low, high] = limits[0].bounds.unwrap();
                *missed += u32::from(!(low..=high).contains(&exact));
            }
        }
        // 10 of 200 with a standard deviation of 3.1; Clopper and Pearson's interval misses less often.
        assert!((2..=22).contains(&missed[0]), "{missed:?}");
        assert!(missed[1] >= 1 && missed[1] <= missed[0], "{missed:?}");
    }
}

#[test]
fn a_span_that_begins_with_the_range_is_unstable_from_there_on() {
    let mut sweep = Sweep::new([1.0, 2.0]);
    sweep.add(&Spans { unstable: [1.0, 1.5], without_verdict: [[0.0; 2]; 2] });
    sweep.add(&Spans { unstable: [1.5, 2.0], without_verdict: [[0.0; 2]; 2] });
    let sorted = sweep.sorted();
    assert_eq!(sorted.first().unstable, 1);
    assert_eq!(sorted.ends(), [Some(0.5), Some(0.5)]);
    assert_eq!(sorted.changes().filter(|(at, _)| *at <= 1.0).count(), 0);
}
