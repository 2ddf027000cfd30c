//! Estimates against closed forms and an independent fit, recovery, coverage, invariance, and data that determine nothing.

use super::*;
use crate::inputs::{Marginal, PairParameter};
use crate::special_functions::normal::{density, quantile, upper_tail};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

const USUAL: [PairParameter; 2] = [PairParameter::Expected(1), PairParameter::RelativeStd(1)];

/// The preset at a rotating speed.
fn boundary_at(rotating_speed: f64) -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", rotating_speed).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

fn model(marginal: &Marginal, preload_std: f64, correlation: f64) -> FitModel {
    FitModel {
        names: ["preload".to_owned(), "static_friction".to_owned()],
        marginals: [marginal.clone(), marginal.clone()],
        values: FitValues { expected: [1.0, 0.42], relative_std: [preload_std, 0.1], correlation },
    }
}

/// A standard normal deviate.
fn deviate(generator: &mut Xoshiro256PlusPlus) -> f64 {
    quantile(generator.random_range(1e-15..1.0))
}

/// Counts of brakes that squealed, of so many at each speed.
fn verdicts(
    seed: u64,
    speeds: &[f64],
    preload: f64,
    each: u64,
    draw: impl Fn([f64; 2]) -> [f64; 2],
) -> Vec<(f64, u64)> {
    let mut generator = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut of_speed = |&speed: &f64| {
        let boundary = boundary_at(speed);
        let is_unstable = |_: &u64| {
            let [factor, friction] = draw([deviate(&mut generator), deviate(&mut generator)]);
            friction > boundary.critical_second(preload * factor)
        };
        (speed, (0..each).filter(is_unstable).count() as u64)
    };
    speeds.iter().map(&mut of_speed).collect()
}

fn data_of(counts: &[(f64, u64)], preload: f64, each: u64) -> TestData {
    let mut data = TestData::default();
    for &(speed, squealed) in counts {
        data.add_verdict(preload, &boundary_at(speed), true, squealed);
        data.add_verdict(preload, &boundary_at(speed), false, each - squealed);
    }
    data
}

fn near(value: f64, expected: f64, tolerance: f64) {
    assert!((value / expected - 1.0).abs() < tolerance, "{value} for {expected}");
}

/// Probit regression `P = Phi(a + b x)` by iteratively reweighted least squares, with the log-likelihood.
fn probit(rows: &[(f64, f64, f64)]) -> (f64, f64, f64) {
    let (mut a, mut b) = (0.0, 0.0);
    for _ in 0..200 {
        let [mut w0, mut w1, mut w2, mut s0, mut s1] = [0.0; 5];
        for &(x, squealed, tests) in rows {
            let eta = a + b * x;
            let p = upper_tail(-eta);
            let weight = tests * density(eta).powi(2) / (p * (1.0 - p));
            let response = eta + (squealed / tests - p) / density(eta);
            w0 += weight;
            w1 += weight * x;
            w2 += weight * x * x;
            s0 += weight * response;
            s1 += weight * x * response;
        }
        let determinant = w0 * w2 - w1 * w1;
        (a, b) = ((w2 * s0 - w1 * s1) / determinant, (w0 * s1 - w1 * s0) / determinant);
    }
    let log = |&(x, squealed, tests): &(f64, f64, f64)| {
        squealed * upper_tail(-a - b * x).ln() + (tests - squealed) * upper_tail(a + b * x).ln()
    };
    (a, b, rows.iter().map(log).sum())
}

#[test]
fn with_scattering_friction_alone_it_is_a_probit_regression() {
    let counts = [(12.0, 38), (14.0, 33), (16.0, 21), (18.0, 11), (20.0, 4)];
    let (model, data) = (model(&Marginal::Normal, 0.0, 0.0), data_of(&counts, 0.1, 40));
    let fit = fit(&model, &data, &USUAL, 0.95).unwrap();
    let rows = counts.map(|(speed, squealed)| (boundary_at(speed).critical_second(0.1), squealed as f64, 40.0));
    // P = Phi((f_s - f_crit) / (s f_s)).
    let (a, b, log_likelihood) = probit(&rows);
    near(fit.parameters[0].value, -a / b, 1e-5);
    near(fit.parameters[1].value, 1.0 / a, 1e-4);
    assert!((fit.log_likelihood - log_likelihood).abs() < 1e-6, "{} {log_likelihood}", fit.log_likelihood);
    // The ends of the interval of f_s, by a fine search over the standard deviation.
    let least = log_likelihood - 0.5 * 1.959_963_984_540_054_f64.powi(2);
    let profile = |friction: f64| {
        let of = |std: f64| -> f64 {
            let log = |&(x, squealed, tests): &(f64, f64, f64)| {
                let t = (x - friction) / (std * friction);
                squealed * upper_tail(t).ln() + (tests - squealed) * upper_tail(-t).ln()
            };
            rows.iter().map(log).sum()
        };
        (0..4000).map(|i| of(0.02 * 1.001_f64.powi(i))).fold(f64::NEG_INFINITY, f64::max)
    };
    for end in [fit.parameters[0].low, fit.parameters[0].high] {
        assert!((profile(end.unwrap()) - least).abs() < 2e-3, "{end:?}");
    }
}

#[test]
fn the_interval_of_a_prediction_holds_its_extremes_where_the_likelihood_is_high() {
    let counts = [(12.0, 38), (14.0, 33), (16.0, 21), (18.0, 11), (20.0, 4)];
    let (model, data) = (model(&Marginal::Normal, 0.0, 0.0), data_of(&counts, 0.1, 40));
    let fit = fit(&model, &data, &USUAL, 0.95).unwrap();
    let rows = counts.map(|(speed, squealed)| (boundary_at(speed).critical_second(0.1), squealed as f64, 40.0));
    let least = fit.log_likelihood - 0.5 * 1.959_963_984_540_054_f64.powi(2);
    for speed in [10.0, 16.0, 24.0] {
        let boundary = boundary_at(speed);
        let critical = boundary.critical_second(0.1);
        let (mut low, mut high) = (1.0_f64, 0.0_f64);
        for i in 0..400 {
            for j in 0..400 {
                let friction = fit.values.expected[1] * (1.0 + 4e-4 * (f64::from(i) - 200.0));
                let std = fit.values.relative_std[1] * (0.01 * (f64::from(j) - 150.0)).exp();
                let log = |&(x, squealed, tests): &(f64, f64, f64)| {
                    let t = (x - friction) / (std * friction);
                    squealed * upper_tail(t).ln() + (tests - squealed) * upper_tail(-t).ln()
                };
                if rows.iter().map(log).sum::<f64>() >= least {
                    let probability = upper_tail((critical - friction) / (std * friction));
                    (low, high) = (low.min(probability), high.max(probability));
                }
            }
        }
        let predicted = fit.predict(0.1, &boundary);
        // The search is as fine as this.
        for (end, expected) in [(predicted.low, low), (predicted.high, high)] {
            assert!((quantile(end) - quantile(expected)).abs() < 0.02, "{end} for {expected}");
        }
        assert!(predicted.low < predicted.probability && predicted.probability < predicted.high);
    }
}

#[test]
fn onset_speeds_of_lognormal_friction_give_the_moments_of_its_logarithm() {
    // Each onset speed gives the friction coefficient of its brake: the one on the boundary.
    let mut data = TestData::default();
    let speeds = [11.0, 13.5, 14.0, 15.2, 16.1, 16.3, 17.7, 19.4];
    for speed in speeds {
        let ends = [speed * (1.0 - 1e-5), speed * (1.0 + 1e-5)];
        data.add_onset(0.1, ends.map(boundary_at), ends);
    }
    let model = model(&Marginal::Lognormal, 0.0, 0.0);
    let fit = fit(&model, &data, &USUAL, 0.95).unwrap();
    let logs = speeds.map(|speed| boundary_at(speed).critical_second(0.1).ln());
    let mean = logs.iter().sum::<f64>() / 8.0;
    let variance = logs.iter().map(|log| (log - mean).powi(2)).sum::<f64>() / 8.0;
    near(fit.values.expected[1], (mean + 0.5 * variance).exp(), 1e-5);
    near(fit.values.relative_std[1], variance.exp_m1().sqrt(), 1e-4);
    // The density itself, of ln v at the estimates.
    let slope = |speed: f64| {
        let log = |speed: f64| boundary_at(speed).critical_second(0.1).ln();
        (log(speed * 1.000_1) - log(speed * 0.999_9)) / 2e-4
    };
    let std = variance.sqrt();
    let expected: f64 =
        speeds.iter().zip(logs).map(|(&speed, log)| (density((log - mean) / std) / std * slope(speed)).ln()).sum();
    assert!((fit.log_likelihood - expected).abs() < 1e-4, "{} {expected}", fit.log_likelihood);
}

#[test]
fn parameters_of_many_tests_are_found_again() {
    let (friction, preload_std, friction_std) = (0.4, 0.15, 0.08);
    let mut data = TestData::default();
    let correlation: f64 = 0.5;
    for (seed, preload) in [(1, 0.04), (2, 0.1), (3, 0.25)] {
        let draw = |z: [f64; 2]| {
            let second = correlation * z[0] + (1.0 - correlation * correlation).sqrt() * z[1];
            [1.0 + preload_std * z[0], friction * (1.0 + friction_std * second)]
        };
        let speeds = [10.0, 14.0, 18.0, 22.0];
        for (speed, squealed) in verdicts(seed, &speeds, preload, 20_000, draw) {
            data.add_verdict(preload, &boundary_at(speed), true, squealed);
            data.add_verdict(preload, &boundary_at(speed), false, 20_000 - squealed);
        }
    }
    let mut model = model(&Marginal::Normal, preload_std, correlation);
    let found = fit(&model, &data, &USUAL, 0.999).unwrap();
    for (fitted, truth) in found.parameters.iter().zip([friction, friction_std]) {
        assert!(fitted.low.unwrap() < truth && truth < fitted.high.unwrap(), "{fitted:?} {truth}");
        near(fitted.value, truth, 0.05);
    }
    // Each of the others, with the rest known.
    (model.values.expected[1], model.values.relative_std[1]) = (friction, friction_std);
    for (parameter, truth) in [
        (PairParameter::Expected(0), 1.0),
        (PairParameter::RelativeStd(0), preload_std),
        (PairParameter::Correlation, correlation),
    ] {
        let mut model = model.clone();
        // Not from the truth.
        model.values.set(parameter, 0.7 * truth);
        let fitted = fit(&model, &data, &[parameter], 0.999).unwrap().parameters[0];
        assert!(fitted.low.unwrap() < truth && truth < fitted.high.unwrap(), "{fitted:?} {truth}");
        near(fitted.value, truth, 0.1);
    }
}

#[test]
fn ninety_five_per_cent_intervals_cover_their_truth_about_as_often() {
    // 200 sets: 95 % of them cover with a standard error of 1.5 %.
    let [friction, std] = [0.4, 0.08];
    let speeds = [13.0, 14.0, 15.0, 16.0, 17.0, 18.0];
    let predicted_at = boundary_at(18.0);
    let predicted = upper_tail((predicted_at.critical_second(0.1) / friction - 1.0) / std);
    let mut covered = [0; 3];
    let sets = 200;
    for seed in 0..sets {
        let counts = verdicts(seed, &speeds, 0.1, 40, |z| [1.0, friction * (1.0 + std * z[1])]);
        let (model, data) = (model(&Marginal::Normal, 0.0, 0.0), data_of(&counts, 0.1, 40));
        let fit = fit(&model, &data, &USUAL, 0.95).unwrap();
        let prediction = fit.predict(0.1, &predicted_at);
        let of = |i: usize| (fit.parameters[i].low.unwrap_or(0.0), fit.parameters[i].high.unwrap_or(9.0));
        let intervals = [(of(0), friction), (of(1), std), ((prediction.low, prediction.high), predicted)];
        for (covered, ((low, high), truth)) in covered.iter_mut().zip(intervals) {
            *covered += u32::from(low <= truth && truth <= high);
        }
    }
    for covered in covered {
        let share = f64::from(covered) / sets as f64;
        assert!((share - 0.95).abs() < 3.0 * (0.95 * 0.05 / sets as f64).sqrt(), "{share}");
    }
}

#[test]
fn order_counts_and_the_unit_of_the_preload_change_nothing() {
    let counts = [(12.0, 38), (14.0, 33), (16.0, 21), (18.0, 11), (20.0, 4)];
    let first_model = model(&Marginal::Lognormal, 0.1, 0.3);
    let data = data_of(&counts, 0.1, 40);
    let first = fit(&first_model, &data, &USUAL, 0.95).unwrap();
    // One by one, backwards.
    let mut single = TestData::default();
    for &(speed, squealed) in counts.iter().rev() {
        (0..40).for_each(|i| single.add_verdict(0.1, &boundary_at(speed), i < squealed, 1));
    }
    let second = fit(&first_model, &single, &USUAL, 0.95).unwrap();
    // Half of the preload, doubled by the machine.
    let mut doubled_model = first_model.clone();
    doubled_model.values.expected[0] = 2.0;
    let halved = data_of(&counts, 0.05, 40);
    let third = fit(&doubled_model, &halved, &USUAL, 0.95).unwrap();
    // From another start.
    let mut other_model = first_model.clone();
    other_model.values.expected[1] = 0.3;
    other_model.values.relative_std[1] = 0.4;
    let fourth = fit(&other_model, &data, &USUAL, 0.95).unwrap();
    for other in [second, third, fourth] {
        for (a, b) in first.parameters.iter().zip(&other.parameters) {
            near(b.value, a.value, 1e-4);
            near(b.low.unwrap(), a.low.unwrap(), 1e-3);
            near(b.high.unwrap(), a.high.unwrap(), 1e-3);
        }
    }
}

#[test]
fn data_that_do_not_determine_the_parameters_are_refused() {
    let plain = model(&Marginal::Normal, 0.0, 0.0);
    let refused = |counts: &[(f64, u64)], estimated: &[PairParameter]| {
        let data = data_of(counts, 0.1, 40);
        fit(&plain, &data, estimated, 0.95).err().unwrap()
    };
    assert_eq!(refused(&[], &USUAL), FitError::NoTests);
    assert_eq!(
        refused(&[(12.0, 40), (14.0, 40)], &USUAL),
        FitError::OneSided { squealed: true, first: "preload".to_owned() }
    );
    assert_eq!(refused(&[(12.0, 0)], &USUAL), FitError::OneSided { squealed: false, first: "preload".to_owned() });
    let separated = refused(&[(12.0, 40), (14.0, 40), (16.0, 0)], &USUAL);
    assert_eq!(separated, FitError::Separated { parameter: "std.static_friction".to_owned() });
    let all_but_one = refused(&[(12.0, 40), (14.0, 40), (16.0, 9), (18.0, 0)], &USUAL);
    assert_eq!(all_but_one, FitError::Separated { parameter: "std.static_friction".to_owned() });
    // One condition cannot determine two parameters.
    let single = refused(&[(15.0, 17)], &USUAL);
    assert!(matches!(single, FitError::NotIdentified { .. }), "{single}");
    // The factor of the preload, the expected friction and its scatter change the product alike.
    let counts = [(12.0, 38), (14.0, 33), (16.0, 21), (18.0, 11), (20.0, 4)];
    let three = [PairParameter::Expected(1), PairParameter::Expected(0), PairParameter::RelativeStd(1)];
    let redundant = refused(&counts, &three);
    assert!(matches!(redundant, FitError::NotIdentified { .. }), "{redundant}");
    // A correlation with a preload that does not scatter.
    let nothing = refused(&counts, &[PairParameter::Expected(1), PairParameter::Correlation]);
    let parameters = vec!["correlation".to_owned()];
    assert_eq!(nothing, FitError::NotIdentified { parameters, first: "preload".to_owned() });
    // Less scatter than the preload alone makes: a greater likelihood the less the friction adds.
    let wide = model(&Marginal::Normal, 0.5, 0.0);
    let data = data_of(&[(14.0, 39), (16.0, 20), (18.0, 1)], 0.1, 40);
    let limit = fit(&wide, &data, &USUAL, 0.95).err().unwrap();
    assert!(matches!(&limit, FitError::NoScatter { parameter, .. } if parameter == "std.static_friction"), "{limit}");
}

#[test]
fn parameters_are_named_after_the_inputs() {
    let model = model(&Marginal::Normal, 0.0, 0.0);
    let names = ESTIMABLE.map(|parameter| model.name(parameter));
    assert_eq!(names, ["static_friction", "preload_factor", "std.preload", "std.static_friction", "correlation"]);
}

#[test]
fn what_one_parameter_is_estimated_from_may_be_separated() {
    let plain = model(&Marginal::Normal, 0.0, 0.0);
    let data = data_of(&[(12.0, 40), (14.0, 40), (16.0, 0)], 0.1, 40);
    let fit = fit(&plain, &data, &[PairParameter::Expected(1)], 0.95).unwrap();
    let [low, high] = [fit.parameters[0].low.unwrap(), fit.parameters[0].high.unwrap()];
    assert!(low < fit.parameters[0].value && fit.parameters[0].value < high);
}

#[test]
fn many_tests_end_intervals_on_both_sides() {
    // Tests of correlated inputs, estimated as if they were not: the scatter of the preload then has to give way.
    let (each, preloads) = (4000_u64, [0.05, 0.1, 0.2]);
    let (correlated, model) = (model(&Marginal::Normal, 0.15, -0.4), model(&Marginal::Normal, 0.1, 0.0));
    let mut truth = correlated.values;
    (truth.expected[1], truth.relative_std[1]) = (0.4, 0.08);
    let mut data = TestData::default();
    for preload in preloads {
        for speed in [12.0, 14.0, 16.0, 18.0, 20.0] {
            let boundary = boundary_at(speed);
            let squealed = (each as f64 * correlated.probabilities(&truth, preload, &boundary)[0]).round() as u64;
            data.add_verdict(preload, &boundary, true, squealed);
            data.add_verdict(preload, &boundary, false, each - squealed);
        }
    }
    let estimated = [PairParameter::Expected(1), PairParameter::RelativeStd(0), PairParameter::RelativeStd(1)];
    let fit = fit(&model, &data, &estimated, 0.95).unwrap();
    for fitted in &fit.parameters {
        let (low, high) = (fitted.low.unwrap(), fitted.high.unwrap());
        assert!(low < fitted.value && fitted.value < high, "{fitted:?}");
    }
}

#[test]
fn tests_that_the_model_cannot_produce_are_named() {
    let model = model(&Marginal::Lognormal, 0.0, 0.0);
    // A misplaced decimal point: 152 rad/s for 15.2.
    let mut data = TestData::default();
    for (row, speed) in (2..).zip([11.0, 13.5, 14.0, 152.0, 16.1, 16.3, 17.7, 19.4]) {
        let ends = [speed * (1.0 - 1e-5), speed * (1.0 + 1e-5)];
        data.begin_row(row);
        data.add_onset(0.1, ends.map(boundary_at), ends);
    }
    match fit(&model, &data, &USUAL, 0.95) {
        Err(FitError::Impossible { rows }) => assert_eq!(rows, [5]),
        // With much more scatter it is possible, and the fit says that it explains little.
        Ok(fit) => assert!(fit.goodness()[0].p_value() < 0.01, "{:?} {:?}", fit.values, fit.goodness()),
        Err(other) => panic!("{other}"),
    }
    // One brake of forty that squealed at 60 rad/s.
    let mut data = data_of(&[(12.0, 95), (15.0, 60), (18.0, 15)], 0.1, 100);
    let before = fit(&model, &data, &USUAL, 0.95).unwrap().values;
    data.begin_row(9);
    data.add_verdict(0.1, &boundary_at(60.0), false, 39);
    data.begin_row(10);
    data.add_verdict(0.1, &boundary_at(60.0), true, 1);
    match fit(&model, &data, &USUAL, 0.95) {
        Err(FitError::Impossible { rows }) => assert_eq!(rows, [10]),
        // Only friction up to the limit explains it.
        Err(FitError::AtLimit { limit, suspects, .. }) => {
            assert!((limit - 5.0).abs() < 1e-9);
            let rows: Vec<u64> = suspects.iter().map(|test| test.row).collect();
            assert_eq!(rows, [10], "{suspects:?}");
            assert!(suspects[0].p_value < 1e-6, "{suspects:?}");
        }
        Ok(fit) => assert!((fit.values.relative_std[1] / before.relative_std[1] - 1.0).abs() > 0.01),
        Err(other) => panic!("{other}"),
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn goodness_of_fit_finds_data_that_contradict_the_model() {
    let model = model(&Marginal::Normal, 0.1, 0.0);
    let p_value = |counts: &[(f64, u64)]| {
        let data = data_of(counts, 0.1, 400);
        fit(&model, &data, &USUAL, 0.95).unwrap().goodness()[0].p_value()
    };
    let zigzag = [(10.0, 400), (12.0, 100), (14.0, 348), (16.0, 40), (18.0, 200), (20.0, 0)];
    assert!(p_value(&zigzag) < 1e-10);
    // Data of the model itself are below 5 % about once in twenty times.
    let speeds = [11.0, 13.0, 15.0, 17.0, 19.0];
    let draw = |[a, b]: [f64; 2]| [1.0 + 0.1 * a, 0.39 * (1.0 + 0.08 * b)];
    let sets = 100;
    let below = (0..sets).filter(|&seed| p_value(&verdicts(seed, &speeds, 0.1, 400, draw)) < 0.05).count();
    assert!((1..=11).contains(&below), "{below} of {sets}");
    // Onset speeds of the model, and of brakes of two kinds.
    let fitted = |speeds: &[f64]| {
        let mut data = TestData::default();
        for &speed in speeds {
            let ends = [speed * (1.0 - 1e-5), speed * (1.0 + 1e-5)];
            data.add_onset(0.1, ends.map(boundary_at), ends);
        }
        fit(&model, &data, &USUAL, 0.95).unwrap().goodness()[0].p_value()
    };
    let even: Vec<f64> = (0..60).map(|i| 15.0 + 1.2 * quantile((f64::from(i) + 0.5) / 60.0)).collect();
    let two: Vec<f64> = (0..60).map(|i| if i % 2 == 0 { 12.0 } else { 19.0 } + 0.01 * f64::from(i)).collect();
    assert!(fitted(&even) > 0.5 && fitted(&two) < 0.01, "{} {}", fitted(&even), fitted(&two));
}

#[test]
fn tests_that_ended_without_squeal_do_not_seem_to_contradict_the_model() {
    let model = model(&Marginal::Normal, 0.0, 0.0);
    // Onset speeds of the model, of which the test bench finds those above some speeds only.
    let fitted = |shift: f64, ends: [f64; 2]| {
        let mut data = TestData::default();
        for (row, i) in (2..).zip(0..60) {
            let speed = 15.0 + shift * f64::from(i % 2) + 1.2 * quantile((f64::from(i) + 0.5) / 60.0);
            let end = ends[i as usize % 2];
            data.begin_row(row);
            if speed > end {
                let around = [speed * (1.0 - 1e-5), speed * (1.0 + 1e-5)];
                data.add_onset(0.1, around.map(boundary_at), around);
            } else {
                data.add_censored(0.1, &boundary_at(end));
            }
        }
        let fit = fit(&model, &data, &USUAL, 0.95).unwrap();
        (fit.goodness(), fit.worst())
    };
    for ends in [[15.0, 15.0], [14.0, 15.5], [10.0, 16.0]] {
        let (goodness, worst) = fitted(0.0, ends);
        assert!(matches!(goodness[..], [Goodness::Onsets { p_value, .. }] if p_value > 0.5), "{ends:?} {goodness:?}");
        assert!(worst.is_empty(), "{ends:?} {worst:?}");
    }
    // Brakes of two kinds still contradict it.
    let (goodness, _) = fitted(12.0, [14.0, 14.0]);
    assert!(goodness[0].p_value() < 0.01, "{goodness:?}");
}

#[test]
fn tests_that_are_explained_worst_are_named_with_their_probability() {
    let model = model(&Marginal::Normal, 0.0, 0.0);
    // About as many as the model expects.
    let expected = [12.0, 14.0, 16.0, 18.0, 20.0].map(|speed| {
        let share = upper_tail((boundary_at(speed).critical_second(0.1) / 0.4 - 1.0) / 0.08);
        (speed, (400.0 * share).round() as u64)
    });
    let mut data = data_of(&expected, 0.1, 400);
    assert!(fit(&model, &data, &USUAL, 0.95).unwrap().worst().is_empty());
    data.begin_row(11);
    data.add_verdict(0.1, &boundary_at(24.0), false, 18);
    data.begin_row(12);
    data.add_verdict(0.1, &boundary_at(24.0), true, 12);
    let found = fit(&model, &data, &USUAL, 0.95).unwrap();
    let worst = found.worst();
    // The sum of the binomial distribution itself, with the probability of one test.
    let p = found.predict(0.1, &boundary_at(24.0)).probability;
    let choose = |k: i32| (0..k).fold(1.0, |product, i| product * f64::from(30 - i) / f64::from(i + 1));
    let tail: f64 = (12..=30).map(|k| choose(k) * p.powi(k) * (1.0 - p).powi(30 - k)).sum();
    near(worst.iter().find(|test| test.row == 12).unwrap().p_value, 2.0 * tail, 1e-9);
    assert!(worst.len() <= 3 && worst.windows(2).all(|pair| pair[0].p_value <= pair[1].p_value), "{worst:?}");
}
