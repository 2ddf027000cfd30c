//! Bounds over all kinds of quantities against brute-force loops.

use super::*;
use crate::inputs::{InputDistribution, Marginal, PairLaw};
use crate::integrate::closed_form;
use crate::integrate::pair::Pair;
use std::convert::Infallible;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

/// What a quantity of the tests is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum What {
    Preload,
    Friction,
    StdOfPreload,
    StdOfFriction,
    Correlation,
    Speed,
}

/// A cell with all its quantities.
struct Brake {
    exponent: f64,
    speed: f64,
    cell: NormalPair,
    marginal: Marginal,
    correlation: f64,
    quantities: Vec<(What, [f64; 2])>,
}

impl Brake {
    fn new(preload: f64, static_friction: f64, stds: [f64; 2], quantities: &[(What, [f64; 2])]) -> Self {
        let cell = NormalPair { expected: [preload, static_friction], relative_std: stds };
        let quantities = quantities.to_vec();
        Self { exponent: 1.0, speed: 15.0, cell, marginal: Marginal::Normal, correlation: 0.0, quantities }
    }

    fn at(&self, values: &[f64]) -> (PairBoundary, NormalPair, f64) {
        let (mut cell, mut correlation, mut speed) = (self.cell, self.correlation, self.speed);
        for (&(what, _), &value) in self.quantities.iter().zip(values) {
            match what {
                What::Preload => cell.expected[0] = value,
                What::Friction => cell.expected[1] = value,
                What::StdOfPreload => cell.relative_std[0] = value,
                What::StdOfFriction => cell.relative_std[1] = value,
                What::Correlation => correlation = value,
                What::Speed => speed = value,
            }
        }
        let mut parameters = Parameters::sui_ding_2018();
        parameters.set("friction.stribeck_exponent", self.exponent).unwrap();
        parameters.set("operating_point.rotating_speed", speed).unwrap();
        (PadOnDisc::new(parameters).unwrap().stability_boundary(), cell, correlation)
    }

    fn roles(&self) -> Vec<Quantity> {
        let role = |what: What| match what {
            What::Preload | What::Friction => Role::Rising,
            What::StdOfPreload => Role::RelativeStd(0),
            What::StdOfFriction => Role::RelativeStd(1),
            What::Correlation | What::Speed => Role::Unknown,
        };
        self.quantities.iter().map(|&(what, interval)| Quantity { role: role(what), interval }).collect()
    }

    /// The least and the greatest probability of a loop over so many values of each quantity, with its evaluations.
    fn brute_force(&self, values: usize) -> ([f64; 2], u64) {
        let mut points = vec![Vec::new()];
        for (_, [low, high]) in &self.quantities {
            let value = |i: usize| low + (high - low) * i as f64 / (values - 1) as f64;
            let with = |point: &Vec<f64>, i: usize| [&point[..], &[value(i)]].concat();
            points = points.iter().flat_map(|point| (0..values).map(move |i| with(point, i))).collect();
        }
        let all = points.iter().map(|point| self.probability(point).map_or(f64::NAN, |found| found.value));
        let ends = all.fold([f64::INFINITY, f64::NEG_INFINITY], |ends, p| [ends[0].min(p), ends[1].max(p)]);
        (ends, points.len() as u64)
    }
}

impl Family for Brake {
    type Error = Infallible;

    fn probability(&self, at: &[f64]) -> Result<ExactProbability, Infallible> {
        let (boundary, cell, correlation) = self.at(at);
        if self.marginal == Marginal::Normal && correlation == 0.0 {
            return Ok(closed_form::probability(&boundary, &cell));
        }
        let of = |expected: f64, std: f64| InputDistribution::relative(&self.marginal, expected, std);
        let [preload, friction] = [0, 1].map(|input| of(cell.expected[input], cell.relative_std[input]));
        let pair = Pair::new(preload, friction);
        Ok(pair.exact_probability(&boundary, &PairLaw::correlated(correlation)))
    }

    fn normal_pair(&self, at: &[f64]) -> Result<Option<(PairBoundary, NormalPair)>, Infallible> {
        let is_correlated =
            self.correlation != 0.0 || self.quantities.iter().any(|(what, _)| *what == What::Correlation);
        let (boundary, cell, _) = self.at(at);
        Ok((self.marginal == Marginal::Normal && !is_correlated).then_some((boundary, cell)))
    }
}

/// Checks against a loop over so many values: to 1e-4, with at most a hundredth of the evaluations.
#[track_caller]
fn agrees(brake: &Brake, values: usize) -> Bounds {
    let Ok(found) = bounds(brake, &brake.roles());
    let (expected, evaluations) = brake.brute_force(values);
    for which in 0..2 {
        let Extreme { at, probability, bound } = &found.extremes[which];
        let sign = [1.0, -1.0][which];
        let value = probability.value;
        assert!((value - expected[which]).abs() <= 1e-4, "{at:?}: {value} {expected:?} {:?}", brake.quantities);
        assert!(sign * (value - expected[which]) <= 1e-5, "{at:?}: {value}, the loop found {expected:?}");
        assert!(bound.is_none_or(|bound| sign * (bound - expected[which]) <= 1e-13), "{bound:?} {expected:?}");
        assert_eq!(bound.is_some(), found.evidence[which] == Evidence::Proved);
        let Ok(there) = brake.probability(at);
        assert_eq!(there.value, value);
    }
    assert!(100 * found.evaluations <= evaluations, "{} of {evaluations}", found.evaluations);
    found
}

const STDS: [(What, [f64; 2]); 2] = [(What::StdOfPreload, [0.1, 0.3]), (What::StdOfFriction, [0.05, 0.15])];

#[test]
fn expected_values_are_at_their_ends_with_a_proof() {
    let brake = Brake::new(0.1, 0.39, [0.2, 0.1], &[(What::Preload, [0.08, 0.12]), (What::Friction, [0.37, 0.41])]);
    let found = agrees(&brake, 41);
    assert_eq!((&found.extremes[0].at[..], &found.extremes[1].at[..]), (&[0.08, 0.37][..], &[0.12, 0.41][..]));
    assert_eq!((found.evidence, found.evaluations), ([Evidence::Proved; 2], 2));
}

#[test]
fn an_expected_value_and_both_standard_deviations_agree_with_a_triple_loop() {
    let brake = Brake::new(0.1, 0.37, [0.0; 2], &[STDS[0], STDS[1], (What::Preload, [0.09, 0.11])]);
    let found = agrees(&brake, 21);
    assert_eq!(found.evidence, [Evidence::Proved; 2]);
}

#[test]
fn correlation_and_a_standard_deviation_agree_with_a_double_loop() {
    for (preload, friction) in [(0.1, 0.39), (0.05, 0.36)] {
        let quantities = [(What::Correlation, [-0.5, 0.3]), (What::StdOfPreload, [0.1, 0.3])];
        let brake = Brake::new(preload, friction, [0.0, 0.1], &quantities);
        let found = agrees(&brake, 101);
        assert!(found.evidence.iter().all(|evidence| *evidence != Evidence::Proved));
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn other_distributions_agree_with_a_double_loop() {
    for marginal in [Marginal::Lognormal, Marginal::Uniform, Marginal::Gumbel] {
        let brake = Brake { marginal, ..Brake::new(0.1, 0.37, [0.0; 2], &STDS) };
        agrees(&brake, 101);
    }
}

#[test]
fn two_limits_along_the_speed_have_an_extreme_between_them() {
    // With a Stribeck exponent of 2 very slow sliding is stable, as is fast sliding.
    let quantities = [(What::Speed, [0.03, 18.0]), (What::StdOfFriction, [0.05, 0.1])];
    let brake = Brake { exponent: 2.0, ..Brake::new(0.1, 0.45, [0.1, 0.0], &quantities) };
    let found = agrees(&brake, 101);
    assert_eq!(found.trends[0].direction, Direction::Turns);
    let speed = found.extremes[1].at[0];
    assert!(speed > 0.1 && speed < 17.0, "{found:?}");
}

#[test]
fn a_loop_over_random_boxes_finds_nothing_beyond_the_bounds() {
    let marginals = [Marginal::Normal, Marginal::Lognormal, Marginal::Uniform, Marginal::Gumbel, Marginal::Weibull];
    let places = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)];
    let mut state = 12345u32;
    let mut between = |least: f64, most: f64| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        least + (most - least) * f64::from(state >> 8) / f64::from(1 << 24)
    };
    for round in 0..18 {
        let mut interval = |least: f64, most: f64| {
            let ends = [between(least, most), between(least, most)];
            [ends[0].min(ends[1]), ends[0].max(ends[1]) + 1e-3]
        };
        let all = [
            (What::StdOfPreload, interval(0.02, 0.4)),
            (What::StdOfFriction, interval(0.02, 0.25)),
            (What::Correlation, interval(-0.8, 0.8)),
            (What::Speed, interval(5.0, 25.0)),
        ];
        let (first, second) = places[round % places.len()];
        let brake = Brake::new(between(0.03, 0.28), between(0.3, 0.45), [0.15, 0.1], &[all[first], all[second]]);
        let marginal = marginals[round % marginals.len()].clone();
        let brake = Brake { marginal, correlation: if round % 4 == 0 { 0.3 } else { 0.0 }, ..brake };
        let Ok(found) = bounds(&brake, &brake.roles());
        let (expected, _) = brake.brute_force(21);
        let [least, most] = [0, 1].map(|which| found.extremes[which].probability.value);
        let beyond = (least - expected[0]).max(expected[1] - most);
        assert!(beyond < 1e-6, "round {round}: {beyond:e} {:?} {found:?}", brake.quantities);
        assert!(found.evaluations < 500, "round {round}: {}", found.evaluations);
    }
}

/// A probability that rises and falls, of which nothing is known beforehand.
struct Bump;

impl Family for Bump {
    type Error = Infallible;

    fn probability(&self, at: &[f64]) -> Result<ExactProbability, Infallible> {
        Ok(ExactProbability { value: 0.2 - 0.1 * (at[0] - 0.4) * (at[0] - 0.4), error_bound: 0.0 })
    }

    fn normal_pair(&self, _: &[f64]) -> Result<Option<(PairBoundary, NormalPair)>, Infallible> {
        Ok(None)
    }
}

#[test]
fn an_extreme_that_no_direction_leads_to_is_only_searched_for() {
    let along = |interval: [f64; 2]| {
        let Ok(found) = bounds(&Bump, &[Quantity { role: Role::Unknown, interval }]);
        (found.evidence, found.trends[0].direction)
    };
    assert_eq!(along([0.0, 1.0]), ([Evidence::Searched; 2], Direction::Turns));
    assert_eq!(along([0.5, 1.0]), ([Evidence::Checked; 2], Direction::Falls));
}
