use super::*;

/// A part of so many samples, of which each hundredth counts `contribution`.
fn part(samples: u64, contribution: f64) -> WeightedPart {
    let mut sums = WeightedSums::default();
    for sample in 0..samples {
        sums.add(
            if sample % 100 == 0 { contribution } else { 1.0 },
            Some(if sample % 100 == 0 { 1.0 } else { 0.0 }),
            sample % 8 == 0,
            Event::Instability,
        );
    }
    WeightedPart::from_sums(samples, &sums.sums().map(i128::from))
}

#[test]
fn sums_have_the_values_that_were_added() {
    let mut sums = WeightedSums::default();
    sums.add(8.0, Some(1.0), false, Event::Instability);
    sums.add(3e-9, Some(0.5), true, Event::Instability);
    sums.add(0.25, None, true, Event::Instability);
    sums.add_evaluations(1000);
    let part = WeightedPart::from_sums(3, &sums.sums().map(i128::from));
    let close = |value: f64, expected: f64| assert!((value - expected).abs() <= 1e-15 * expected, "{value:e}");
    close(part.contributions, 8.0 + 1.5e-9);
    close(part.squares, 64.0 + 2.25e-18);
    close(part.without_verdict, 0.25);
    assert_eq!(part.of_inputs, [2.0, 1.5]);
    assert_eq!(part.evaluations, 1003.0);
    // Small contributions keep their digits.
    for small in [3e-12, 3e-50] {
        let mut sums = WeightedSums::default();
        sums.add(small, Some(1.0), false, Event::Instability);
        let part = WeightedPart::from_sums(1, &sums.sums().map(i128::from));
        assert!((part.contributions / small - 1.0).abs() < 1e-15, "{small:e}");
        assert!((part.squares / (small * small) - 1.0).abs() < 1e-9, "{small:e}");
    }
}

#[test]
fn sums_do_not_depend_on_the_order() {
    let contributions = [1.0 / 3.0, 1e-9 / 7.0, 2.0 / 9.0, 1e-20 / 3.0];
    let sum = |order: &mut dyn Iterator<Item = &f64>| {
        let mut sums = WeightedSums::default();
        order.for_each(|&weight| sums.add(weight, Some(1.0), false, Event::Instability));
        sums
    };
    assert_eq!(sum(&mut contributions.iter()), sum(&mut contributions.iter().rev()));
}

#[test]
fn the_interval_is_students() {
    let parts: Vec<WeightedPart> = (0..16).map(|i| part(6400, 1e-6 * (1.0 + 0.01 * f64::from(i / 4 % 2)))).collect();
    let WeightedEstimate { estimate, effective, distrust, .. } = estimate(&parts, 4, 0.95);
    assert_eq!(distrust, None);
    assert!((effective / 1024.0 - 1.0).abs() < 1e-3);
    // Four groups of mean 1.005e-8, each with a standard deviation of 5e-11 sqrt(4/3); t(12) = 2.1788.
    let half_width = 2.178_813 * 5e-11 * (4.0_f64 / 3.0).sqrt() / 4.0;
    assert!((estimate.probability.unwrap() - 1.005e-8).abs() < 1e-20);
    assert!((estimate.low - (1.005e-8 - half_width)).abs() < 1e-5 * half_width);
    assert!((estimate.high - 1.005e-8 - half_width).abs() < 0.01 * half_width);
}

#[test]
fn groups_that_disagree_are_not_trusted() {
    // One group of four has missed half of the probability.
    let noise = |i: u32| 1.0 + 0.03 * f64::from(i / 4 % 2);
    let lost = |i: u32| if i.is_multiple_of(4) { 0.5 } else { 1.0 };
    let parts: Vec<WeightedPart> = (0..16).map(|i| part(1600, 1e-6 * noise(i) * lost(i))).collect();
    let found = estimate(&parts, 4, 0.95);
    assert_eq!(found.distrust, Some(Distrust::Disagreement));
    assert_eq!(found.estimate.probability, None);
    // Of the samples from the distribution of the inputs 4 % are unstable here.
    assert!(found.estimate.low == 0.0 && found.estimate.high < 0.06, "{found:?}");
    // A smaller loss widens the interval about to that of four groups.
    let noise = |i: u32| 1.0 + 0.06 * f64::from(i / 4 % 2);
    let lost = |i: u32| if i.is_multiple_of(4) { 0.92 } else { 1.0 };
    let parts: Vec<WeightedPart> = (0..16).map(|i| part(16_000, 1e-6 * noise(i) * lost(i))).collect();
    let found = estimate(&parts, 4, 0.95);
    assert_eq!(found.distrust, None);
    let WeightedEstimate { estimate: of_one_group, .. } = estimate(&parts, 1, 0.95);
    let width = |estimate: Estimate| estimate.high - estimate.low;
    assert!(width(found.estimate) > 1.5 * width(of_one_group), "{found:?} {of_one_group:?}");
}

#[test]
fn few_samples_are_not_trusted() {
    let parts: Vec<WeightedPart> = (0..16).map(|i| part(400, if i == 3 { 1.0 } else { 1e-6 })).collect();
    let found = estimate(&parts, 4, 0.95);
    assert_eq!(found.distrust, Some(Distrust::FewSamples));
    assert!(found.effective < 5.0);
    let parts: Vec<WeightedPart> = (0..16).map(|_| part(400, 0.0)).collect();
    let found = estimate(&parts, 4, 0.95);
    assert_eq!((found.distrust, found.estimate.probability), (Some(Distrust::NothingFound), None));
    // Two of a hundred samples count, and a half of these are of the inputs; their g is 1.
    assert!(found.estimate.high > 0.0);
}

#[test]
fn few_samples_that_decide_the_variance_are_not_trusted() {
    // Of 256 samples of 1e-6, one counts so many times as much.
    let with = |samples: u64, times: f64| {
        let mut parts: Vec<WeightedPart> = (0..16).map(|_| part(samples, 1e-6)).collect();
        parts[3].contributions += (times - 1.0) * 1e-6;
        parts[3].squares += (times * times - 1.0) * 1e-12;
        estimate(&parts, 4, 0.95)
    };
    let found = with(1600, 12.0);
    assert!(found.effective > 150.0);
    assert_eq!((found.distrust, found.estimate.probability), (Some(Distrust::FewSamples), None));
    assert_eq!(with(1600, 3.0).distrust, None);
    // Among more samples the mean is known well enough.
    assert_eq!(with(6400, 12.0).distrust, None);
}

#[test]
fn a_probability_without_digits_is_nearly_zero() {
    let parts: Vec<WeightedPart> = (0..16).map(|_| part(6400, 1e-90)).collect();
    let found = estimate(&parts, 4, 0.95);
    assert_eq!((found.distrust, found.estimate.probability), (None, Some(0.0)));
    assert!(found.estimate.low == 0.0 && found.estimate.high == 1e-60, "{found:?}");
}

#[test]
fn samples_without_a_verdict_widen_the_interval_upwards() {
    let with = |without_verdict: f64| {
        let parts: Vec<WeightedPart> = (0..16)
            .map(|i| WeightedPart { without_verdict, ..part(6400, 1e-6 * (1.0 + 0.01 * f64::from(i / 4 % 2))) })
            .collect();
        estimate(&parts, 4, 0.95).estimate
    };
    let (decided, open) = (with(0.0), with(6400.0 * 1e-9));
    assert_eq!((decided.low, decided.probability), (open.low, open.probability));
    assert!((open.high - decided.high - 1e-9).abs() < 1e-11);
}

#[test]
fn populations_are_averaged() {
    let populations = |found: &[f64]| {
        let part = |&p: &f64| {
            let mut sums = WeightedSums::default();
            sums.add_population(p, 0.0, [0.0; 2], Event::Instability);
            sums.add_evaluations(100);
            WeightedPart::from_sums(1, &sums.sums().map(i128::from))
        };
        estimate_of_populations(&found.iter().map(part).collect::<Vec<_>>(), 0.95)
    };
    let found = populations(&[1e-6, 1.2e-6, 0.8e-6, 1e-6]);
    assert!((found.estimate.probability.unwrap() - 1e-6).abs() < 1e-18);
    // With numpy and scipy: the low end is that of Student, 7.402e-7, the high one that of Cox, 1.3100e-6.
    assert!(
        (found.estimate.low / 0.740_154e-6 - 1.0).abs() < 1e-4
            && (found.estimate.high / 1.310_02e-6 - 1.0).abs() < 1e-4,
        "{found:?}"
    );
    assert_eq!(found.evaluations, 400.0);
    assert_eq!(populations(&[1e-6, 1e-9, 1e-9, 1e-9]).distrust, Some(Distrust::Disagreement));
    assert_eq!(populations(&[0.0; 4]).distrust, Some(Distrust::NothingFound));
    // Nothing stable is no number either.
    let of_stability = |probability: f64| {
        let mut sums = WeightedSums::default();
        sums.add_population(probability, 0.0, [0.0; 2], Event::Stability);
        estimate_of_populations(&[WeightedPart::from_sums(1, &sums.sums().map(i128::from)); 16], 0.95)
    };
    let certain = of_stability(0.0);
    assert_eq!((certain.distrust, certain.estimate.probability), (Some(Distrust::NothingFound), None));
    assert_eq!([certain.mean, certain.estimate.low, certain.estimate.high], [1.0, 0.0, 1.0]);
    let nearly_certain = of_stability(1e-5);
    assert_eq!(nearly_certain.distrust, None);
    assert!((nearly_certain.estimate.probability.unwrap() - 0.999_99).abs() < 1e-15);
    let nearly = populations(&[1e-80; 4]);
    assert_eq!((nearly.distrust, nearly.estimate.probability), (None, Some(0.0)));
    // Equal populations that found everything unstable have the interval of the samples that they tried.
    let of = |probability: f64, without: f64| {
        let mut sums = WeightedSums::default();
        sums.add_population(probability, without, [300.0, 300.0 * probability], Event::Instability);
        let part = WeightedPart::from_sums(1, &sums.sums().map(i128::from));
        estimate_of_populations(&[part; 16], 0.95)
    };
    let certain = of(1.0, 0.0).estimate;
    assert!(certain.low < 0.9995 && certain.low > 0.999 && certain.high == 1.0, "{certain:?}");
    assert_eq!(of(0.4, 0.5).distrust, Some(Distrust::WithoutVerdict));
    let (decided, open) = (of(0.4, 0.0).estimate, of(0.4, 0.1).estimate);
    assert_eq!((decided.low, decided.probability), (open.low, open.probability));
    assert!(decided.high < 0.45 && open.high > 0.5 && open.high < 0.55, "{open:?}");
    // Where it is rare, those samples say nothing.
    let rare = {
        let part = |p: f64| {
            let mut sums = WeightedSums::default();
            sums.add_population(p, 0.0, [300.0, 1e-5], Event::Instability);
            WeightedPart::from_sums(1, &sums.sums().map(i128::from))
        };
        estimate_of_populations(&[part(1e-6), part(1.1e-6), part(0.9e-6), part(1e-6)], 0.95).estimate
    };
    assert!(rare.high < 1.3e-6, "{rare:?}");
}

#[test]
fn parts_that_agree_are_no_surer_than_so_many_independent_samples() {
    // Two hundred contributions of 1 in 32 768 samples, the same number in each part.
    let part = WeightedPart {
        samples: 2048.0,
        contributions: 12.5,
        squares: 12.5,
        evaluations: 2048.0,
        contributing: 12.5,
        ..WeightedPart::default()
    };
    let found = estimate(&[part; 16], 4, 0.95);
    assert_eq!(found.distrust, None);
    let half_width = 1.96 * (200.0_f64).sqrt() / 32_768.0 * 0.99;
    let mean = 200.0 / 32_768.0;
    assert!(found.estimate.low < mean - half_width && found.estimate.high > mean + half_width, "{found:?}");
}

#[test]
fn a_probability_near_one_has_the_digits_of_its_complement() {
    let part = |i: u32, event: Event| {
        let mut sums = WeightedSums::default();
        for sample in 0..400 {
            let value = f64::from(u8::from(u32::is_multiple_of(sample + i, 2)));
            sums.add(1e-9 * f64::from(1 + i % 3), Some(value), sample % 8 == 0, event);
        }
        sums.add(1e-10, None, false, event);
        WeightedPart::from_sums(401, &sums.sums().map(i128::from))
    };
    let of = |event: Event| estimate(&(0..16).map(|i| part(i, event)).collect::<Vec<_>>(), 4, 0.95);
    let (unstable, stable) = (of(Event::Instability), of(Event::Stability));
    let without = 1e-10 / 401.0;
    let [p, complement] = [unstable, stable].map(|found| found.estimate.probability.unwrap());
    assert!(p > 0.9e-9 && (1.0 - complement - p - without).abs() < 1e-15, "{p:e} {complement:e}");
    assert!((1.0 - stable.estimate.low - unstable.estimate.high).abs() < 1e-15);
    assert!((1.0 - stable.estimate.high - unstable.estimate.low).abs() < 1e-15);
    assert_eq!(stable.effective, unstable.effective);
    // Some parts are of the one and some of the other.
    let mixed: Vec<WeightedPart> = (0..16)
        .map(|i| {
            let event = if i % 4 == 0 { Event::Stability } else { Event::Instability };
            let mut sums = WeightedSums::default();
            (0..400).for_each(|sample| {
                sums.add(1.0, Some(f64::from(u8::from(u32::is_multiple_of(sample + i, 2)))), true, event);
            });
            WeightedPart::from_sums(400, &sums.sums().map(i128::from))
        })
        .collect();
    assert!((estimate(&mixed, 4, 0.95).estimate.probability.unwrap() - 0.5).abs() < 1e-12);
    // Nothing stable was found.
    let mut sums = WeightedSums::default();
    (0..400).for_each(|_| sums.add(1.0, Some(0.0), true, Event::Stability));
    let certain = estimate(&[WeightedPart::from_sums(400, &sums.sums().map(i128::from)); 16], 4, 0.95);
    assert_eq!((certain.estimate.probability, certain.mean), (None, 1.0));
    assert_eq!((certain.estimate.high, certain.distrust), (1.0, Some(Distrust::NothingFound)));
    assert!(certain.estimate.low > 0.999 && certain.estimate.low < 1.0);
}
