//! Derivatives against integration, and their standard errors against repeated estimates.

use super::*;
use crate::draw::deviates::{DeviateStream, Points};
use crate::integrate::closed_form;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::model::verdict::Verdict;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

/// The scores of a sample, in the order of [`PairParameter::DIFFERENTIATED`]; 0 for an input without scatter.
fn scores(cell: &NormalPair, z: [Option<f64>; 2]) -> [f64; 4] {
    let scaled = scaled_scores(cell, z);
    std::array::from_fn(|i| {
        let scale = scale(PairParameter::DIFFERENTIATED[i], cell);
        if scale == 0.0 { 0.0 } else { scaled[i] / scale }
    })
}

fn boundary() -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", 15.0).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

fn cell(preload: f64, static_friction: f64, preload_std: f64, friction_std: f64) -> NormalPair {
    NormalPair { expected: [preload, static_friction], relative_std: [preload_std, friction_std] }
}

/// The deviates of samples, each with its verdict by the closed form.
fn decided_samples(seed: u64, cell: &NormalPair, samples: u64) -> Vec<([Option<f64>; 2], Verdict)> {
    let [preload, static_friction] = cell.relative_std;
    let stds: Vec<f64> = [preload, static_friction].into_iter().filter(|&std| std > 0.0).collect();
    let stream = DeviateStream { seed, common_random_numbers: false, dimensions: stds.len(), points: Points::Random };
    let boundary = boundary();
    let mut found = Vec::new();
    stream.for_each_chunk(0, 0, 0..samples, |columns| {
        let mut next = columns.iter();
        let mut column = |std: f64| if std > 0.0 { next.next() } else { None };
        let deviates = [column(preload), column(static_friction)];
        for sample in 0..columns.first().map_or(0, Vec::len) {
            let z = deviates.map(|column| column.map(|column| column[sample]));
            let input = |expected: f64, std: f64, z: Option<f64>| expected * (1.0 + std * z.unwrap_or(0.0));
            let verdict = boundary
                .verdict(input(cell.expected[0], preload, z[0]), input(cell.expected[1], static_friction, z[1]));
            found.push((z, verdict));
        }
    });
    found
}

/// Sums and counts of some samples.
fn total(cell: &NormalPair, decided_samples: &[([Option<f64>; 2], Verdict)]) -> (ScoreTotals, VerdictCounts) {
    let mut totals = [0_i128; ScoreSums::COUNT];
    let mut counts = VerdictCounts::default();
    for part in decided_samples.chunks(1000) {
        let mut sums = ScoreSums::default();
        for (z, verdict) in part {
            sums.add(cell, *z, *verdict);
            counts += (*verdict).into();
        }
        totals.iter_mut().zip(sums.sums()).for_each(|(total, sum)| *total += i128::from(sum));
    }
    (ScoreTotals::from_sums(&totals), counts)
}

fn estimate(
    cell: &NormalPair,
    decided_samples: &[([Option<f64>; 2], Verdict)],
    parameter: PairParameter,
) -> Option<(f64, f64)> {
    let (totals, counts) = total(cell, decided_samples);
    totals.derivative(parameter, cell, &counts, counts.unstable as f64 / counts.decided() as f64)
}

fn exact_derivatives(cell: &NormalPair) -> [Option<f64>; 4] {
    closed_form::derivatives(&boundary(), cell).0
}

#[test]
fn scores_are_derivatives_of_the_logarithm_of_the_density() {
    let log_density = |value: f64, expected: f64, std: f64| {
        let z = (value / expected - 1.0) / std;
        -0.5 * z * z - (expected * std).ln()
    };
    let c = cell(0.1, 0.4, 0.2, 0.05);
    for z in [-2.5, -0.3, 0.0, 1.0, 3.0] {
        let scores = scores(&c, [Some(z), Some(0.5 * z)]);
        for (input, expected, std, z) in [(0, 0.1, 0.2, z), (1, 0.4, 0.05, 0.5 * z)] {
            let value = expected * (1.0 + std * z);
            let h = 1e-5;
            let by_expected = (log_density(value, expected * (1.0 + h), std)
                - log_density(value, expected * (1.0 - h), std))
                / (2.0 * h * expected);
            let by_std = (log_density(value, expected, std * (1.0 + h))
                - log_density(value, expected, std * (1.0 - h)))
                / (2.0 * h * std);
            assert!((scores[input] - by_expected).abs() < 1e-5 * by_expected.abs().max(1.0), "{z}");
            assert!((scores[input + 2] - by_std).abs() < 1e-5 * by_std.abs().max(1.0), "{z}");
        }
    }
    let only_preload = scores(&cell(0.1, 0.4, 0.2, 0.0), [Some(1.0), None]);
    assert_eq!((only_preload[1], only_preload[3]), (0.0, 0.0));
    assert_eq!(scores(&cell(0.1, 0.4, 0.0, 0.0), [Some(1.0), Some(1.0)]), [0.0; 4]);
}

#[test]
fn estimates_agree_with_integration() {
    let samples = 400_000;
    for cell in [
        cell(0.1, 0.39, 0.2, 0.2),
        cell(0.05, 0.45, 0.3, 0.1),
        cell(0.1, 0.38, 1e-3, 0.2),
        cell(0.1, 0.38, 0.2, 0.0),
        cell(0.1, 0.38, 0.0, 0.2),
    ] {
        let decided_samples = decided_samples(7, &cell, samples);
        for (parameter, exact) in PairParameter::DIFFERENTIATED.into_iter().zip(exact_derivatives(&cell)) {
            let estimate = estimate(&cell, &decided_samples, parameter);
            assert_eq!(estimate.is_some(), scale(parameter, &cell) != 0.0, "{cell:?} {parameter:?}");
            if let (Some((value, error)), Some(exact)) = (estimate, exact) {
                assert!((value - exact).abs() < 4.0 * error, "{cell:?} {parameter:?}: {value} +- {error}, {exact}");
                let scale = scale(parameter, &cell);
                assert!(error * scale < 2.0 / (samples as f64).sqrt(), "{parameter:?}: {error}");
            }
        }
    }
}

#[test]
fn the_order_of_the_samples_has_no_effect() {
    let c = cell(0.1, 0.39, 0.2, 0.2);
    let decided_samples = decided_samples(3, &c, 50_000);
    let mut backwards = decided_samples.clone();
    backwards.reverse();
    assert_eq!(total(&c, &decided_samples), total(&c, &backwards));
}

/// The mean square of the deviations over their standard errors, and the share within 1.96 of them, over repetitions of
/// `samples` samples; of those that have an estimate.
fn deviations(
    cell: &NormalPair,
    parameter: PairParameter,
    samples: u64,
    repetitions: u64,
    exact: f64,
) -> (f64, f64, u64) {
    let (mut squares, mut covered, mut count) = (0.0, 0.0, 0);
    for seed in 0..repetitions {
        if let Some((value, error)) = estimate(cell, &decided_samples(seed, cell, samples), parameter) {
            let deviation = (value - exact) / error;
            squares += deviation * deviation;
            covered += f64::from(u32::from(deviation.abs() <= 1.96));
            count += 1;
        }
    }
    (squares / count as f64, covered / count as f64, count)
}

#[test]
fn standard_errors_are_those_of_repeated_estimates() {
    let c = cell(0.1, 0.39, 0.2, 0.1);
    for (parameter, exact) in PairParameter::DIFFERENTIATED.into_iter().zip(exact_derivatives(&c)) {
        let (mean, covered, count) = deviations(&c, parameter, 2000, 1000, exact.unwrap());
        // The mean of 1000 squares of standard normal deviates has a standard deviation of 0.045.
        assert!(count == 1000 && (mean - 1.0).abs() < 0.18, "{parameter:?}: {mean}");
        assert!((covered - 0.95).abs() < 0.025, "{parameter:?}: {covered}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn rare_events_have_no_derivative() {
    // Some 8.5e-4 of the samples are unstable.
    let c = cell(0.1, 0.2735, 0.2, 0.1);
    let p = closed_form::probability(&boundary(), &c).value;
    assert!((p - 8.5e-4).abs() < 1e-4, "{p}");
    let exact = exact_derivatives(&c)[0].unwrap();
    let (.., count) = deviations(&c, PairParameter::Expected(0), 1000, 50, exact);
    assert_eq!(count, 0);
    let stable =
        decided_samples(1, &c, 100).into_iter().filter(|(_, verdict)| *verdict == Verdict::Stable).collect::<Vec<_>>();
    assert_eq!(estimate(&c, &stable, PairParameter::Expected(0)), None);
    // With enough of them the error is right.
    let (mean, covered, count) = deviations(&c, PairParameter::Expected(0), 60_000, 400, exact);
    assert!(count > 390 && (mean - 1.0).abs() < 0.35 && covered > 0.92, "{mean} {covered} {count}");
}

#[test]
fn undecided_samples_are_left_out_by_the_quotient_rule() {
    // Undecided is a sixth of the samples, those with much friction: what remains is stable more often, the more the
    // expected friction grows.
    let c = cell(0.1, 0.39, 0.2, 0.2);
    let limit = 0.39 * (1.0 + 0.2 * 1.0);
    // P(unstable | friction below the limit), by the trapezoidal rule over the deviate of the friction.
    let probability = |c: &NormalPair| {
        let (mut unstable, mut decided, step) = (0.0, 0.0, 1e-4);
        let end = (limit / c.expected[1] - 1.0) / c.relative_std[1];
        let mut z = end;
        let mut weight = 0.5;
        while z > -9.0 {
            let friction = c.expected[1] * (1.0 + c.relative_std[1] * z);
            let critical = (boundary().critical_first(friction) / c.expected[0] - 1.0) / c.relative_std[0];
            decided += weight * crate::special_functions::normal::density(z);
            unstable += weight
                * crate::special_functions::normal::density(z)
                * crate::special_functions::normal::upper_tail(critical);
            z -= step;
            weight = 1.0;
        }
        unstable / decided
    };
    let h = 1e-4;
    let shifted = |by: f64| NormalPair { expected: [c.expected[0], c.expected[1] + by], ..c };
    let exact = (probability(&shifted(h)) - probability(&shifted(-h))) / (2.0 * h);
    let (mut squares, repetitions) = (0.0, 300);
    for seed in 0..repetitions {
        let mut decided_samples = decided_samples(seed, &c, 2000);
        for ([_, z], verdict) in &mut decided_samples {
            if z.unwrap() > 1.0 {
                *verdict = Verdict::Undecided;
            }
        }
        let (value, error) = estimate(&c, &decided_samples, PairParameter::Expected(1)).unwrap();
        squares += ((value - exact) / error).powi(2);
    }
    let mean = squares / f64::from(u32::try_from(repetitions).unwrap());
    assert!((mean - 1.0).abs() < 0.3, "{mean}");
}

#[test]
fn the_largest_terms_do_not_overflow() {
    let c = cell(0.1, 0.39, 50.0, 0.1);
    let mut sums = ScoreSums::default();
    (0..1 << 22).for_each(|_| sums.add(&c, [Some(1e9), Some(f64::NAN)], Verdict::Unstable));
    let found: Vec<i64> = sums.sums().collect();
    assert_eq!(found[..8], [1 << 52, 0, 1 << 52, 0, 1 << 62, 0, 1 << 62, 0]);
}

#[test]
fn few_stable_samples_have_no_derivative_either() {
    let pair = NormalPair { expected: [0.1, 0.39], relative_std: [0.2, 0.1] };
    let derivative = |stable: u64, unstable: u64| {
        let counts = VerdictCounts { stable, unstable, ..VerdictCounts::default() };
        ScoreTotals::default().derivative(PairParameter::Expected(0), &pair, &counts, 0.5).is_some()
    };
    assert_eq!(
        [(29, 1000), (1000, 29), (30, 1000), (1000, 30)].map(|(a, b)| derivative(a, b)),
        [false, false, true, true]
    );
}
