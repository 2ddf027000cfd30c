//! The likelihood of the tests.

use stickslip_core::model::pair_boundary::PairBoundary;

use super::data::{Onset, TestData, Verdicts};
use super::parameter::{FitValues, Range};
use crate::inputs::{InputDistribution, Marginal, PairLaw, PairParameter};
use crate::integrate::pair::Pair;
use crate::special_functions::beta::binomial_at_least;

/// Relative error of each integral, small against the steps of numerical derivatives.
const TOLERANCE: f64 = 1e-10;

/// A probability below this counts as this, so that the logarithm is finite where the search passes values with which tests
/// are impossible. At a maximum no test is as improbable: [`Likelihood::impossible`].
pub(super) const LEAST: f64 = 1e-300;

/// Most tests that are named as explained worst, and the probability below which one of all is.
const MOST_WORST: usize = 3;
const UNLIKELY: f64 = 0.05;

/// Tests that values explain badly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unlikely {
    /// Their row.
    pub row: u64,
    /// Twice the probability of a result at least as far to its side: of the number of brakes that squeal in these
    /// conditions, or of the onset speed.
    pub p_value: f64,
}

/// What is known of the two random inputs before the fit.
#[derive(Debug, Clone)]
pub struct FitModel {
    /// The names of the inputs.
    pub names: [String; 2],
    /// Their distributions.
    pub marginals: [Marginal; 2],
    /// The values of all parameters; those to be estimated start here.
    pub values: FitValues,
}

impl FitModel {
    /// The name of a parameter. That of the first expected value is a factor on its nominal value.
    #[must_use]
    pub fn name(&self, parameter: PairParameter) -> String {
        match parameter {
            PairParameter::Expected(0) => format!("{}_factor", self.names[0]),
            PairParameter::Expected(input) => self.names[input].clone(),
            PairParameter::RelativeStd(input) => format!("std.{}", self.names[input]),
            PairParameter::Correlation => "correlation".to_owned(),
        }
    }

    /// The inputs at a nominal first one.
    fn pair(&self, values: &FitValues, nominal: f64) -> Pair {
        let of = |marginal: &Marginal, expected: f64, std: f64| {
            let scatters = std > 0.0 || matches!(marginal, Marginal::Empirical(_));
            if scatters {
                InputDistribution::relative(marginal, expected, std)
            } else {
                InputDistribution::fixed(expected)
            }
        };
        let [first, second] = &self.marginals;
        let [factor, expected] = values.expected;
        let stds = values.relative_std;
        Pair::new(of(first, factor * nominal, stds[0]), of(second, expected, stds[1]))
    }

    /// The probabilities of squeal and of none with given values, at a nominal first input.
    pub(super) fn probabilities(&self, values: &FitValues, nominal: f64, boundary: &PairBoundary) -> [f64; 2] {
        both(&self.pair(values, nominal), boundary, &PairLaw::correlated(values.correlation))
    }
}

/// The probabilities of squeal and of none, each accurate where it is small.
fn both(pair: &Pair, boundary: &PairBoundary, law: &PairLaw) -> [f64; 2] {
    let squeal = pair.probability(boundary, law, TOLERANCE);
    [squeal, if squeal > 0.5 { pair.stable_probability(boundary, law, TOLERANCE) } else { 1.0 - squeal }]
}

/// The likelihood as a function of the coordinates of the parameters that are estimated.
pub(super) struct Likelihood<'a> {
    pub(super) model: &'a FitModel,
    pub(super) data: &'a TestData,
    pub(super) estimated: Vec<(PairParameter, Range)>,
}

impl Likelihood<'_> {
    /// The values at some coordinates.
    pub(super) fn values(&self, coordinates: &[f64]) -> FitValues {
        let mut values = self.model.values;
        for ((parameter, range), &y) in self.estimated.iter().zip(coordinates) {
            values.set(*parameter, range.value(y));
        }
        values
    }

    /// The logarithm of the likelihood.
    pub(super) fn logarithm(&self, coordinates: &[f64]) -> f64 {
        let values = self.values(coordinates);
        let law = PairLaw::correlated(values.correlation);
        let mut prepared: Option<(f64, Pair)> = None;
        let mut sum = 0.0;
        let log = |probability: f64| libm::log(probability.max(LEAST));
        for verdicts in &self.data.verdicts {
            let pair = self.prepare(&mut prepared, &values, verdicts.nominal);
            if verdicts.quiet > 0.0 {
                let [squeal, none] = both(pair, &verdicts.boundary, &law);
                sum += verdicts.squealed * log(squeal) + verdicts.quiet * log(none);
            } else {
                sum += verdicts.squealed * log(pair.probability(&verdicts.boundary, &law, TOLERANCE));
            }
        }
        for onset in &self.data.onsets {
            let pair = self.prepare(&mut prepared, &values, onset.nominal);
            let [slow, fast] = &onset.boundaries;
            let probability = pair.probability_between([slow, fast], &law, TOLERANCE);
            sum += log(probability) - libm::log(onset.width);
        }
        sum
    }

    /// The rows of tests that are as good as impossible at some coordinates, in order.
    pub(super) fn impossible(&self, coordinates: &[f64]) -> Vec<u64> {
        let values = self.values(coordinates);
        let law = PairLaw::correlated(values.correlation);
        let mut rows = Vec::new();
        for verdicts in &self.data.verdicts {
            let probabilities = self.model.probabilities(&values, verdicts.nominal, &verdicts.boundary);
            for (row, probability) in verdicts.rows.into_iter().zip(probabilities) {
                rows.extend(row.filter(|_| probability <= LEAST));
            }
        }
        for onset in &self.data.onsets {
            let [slow, fast] = &onset.boundaries;
            let pair = self.model.pair(&values, onset.nominal);
            rows.extend((pair.probability_between([slow, fast], &law, TOLERANCE) <= LEAST).then_some(onset.row));
        }
        rows.sort_unstable();
        rows
    }

    /// All tests with their probabilities by some values: of each condition those that squealed and those that did not, then
    /// the onset speeds.
    pub(super) fn p_values(&self, values: &FitValues) -> Vec<Unlikely> {
        let of_verdicts = |verdicts: &Verdicts| {
            let probabilities = self.model.probabilities(values, verdicts.nominal, &verdicts.boundary);
            let counts = [verdicts.squealed, verdicts.quiet];
            // How many ended without squeal says nothing without those that squealed before; each one may.
            let counts = if verdicts.are_censored { [0.0, 1.0] } else { counts };
            let tests = counts[0] + counts[1];
            let as_many = |which: usize| {
                let p_value = 2.0 * binomial_at_least(counts[which] as u64, tests as u64, probabilities[which]);
                Some(Unlikely { row: verdicts.rows[which]?, p_value: p_value.min(1.0) })
            };
            [as_many(0), as_many(1)]
        };
        let of_onset = |onset: &Onset| {
            let [above, below] = self.model.probabilities(values, onset.nominal, &onset.boundaries[0]);
            Unlikely { row: onset.row, p_value: 2.0 * above.min(below) }
        };
        let verdicts = self.data.verdicts.iter().flat_map(of_verdicts).flatten();
        verdicts.chain(self.data.onsets.iter().map(of_onset)).collect()
    }

    /// The probability of squeal of each test that squealed, and of none of each that did not, by some values; onset speeds
    /// may be too high and too low.
    pub(super) fn single(&self, values: &FitValues) -> [Vec<Unlikely>; 2] {
        let mut single: [Vec<Unlikely>; 2] = Default::default();
        let conditions = self.data.verdicts.iter().map(|of| (of.nominal, &of.boundary, of.rows));
        let onsets = self.data.onsets.iter().map(|of| (of.nominal, &of.boundaries[0], [Some(of.row); 2]));
        for (nominal, boundary, rows) in conditions.chain(onsets) {
            let probabilities = self.model.probabilities(values, nominal, boundary);
            for ((tests, row), p_value) in single.iter_mut().zip(rows).zip(probabilities) {
                tests.extend(row.map(|row| Unlikely { row, p_value }));
            }
        }
        single
    }

    /// The tests among these that are improbable, if the worst of all is rarely as bad.
    pub(super) fn worst(&self, of: Vec<Unlikely>) -> Vec<Unlikely> {
        let least = UNLIKELY / self.data.conditions().max(1) as f64;
        let mut worst: Vec<Unlikely> = of.into_iter().filter(|test| test.p_value < least).collect();
        worst.sort_by(|a, b| a.p_value.total_cmp(&b.p_value));
        worst.truncate(MOST_WORST);
        worst
    }

    /// The inputs at a nominal first one, those of the test before if they are the same.
    fn prepare<'p>(&self, prepared: &'p mut Option<(f64, Pair)>, values: &FitValues, nominal: f64) -> &'p Pair {
        if prepared.as_ref().is_some_and(|(of, _)| *of != nominal) {
            *prepared = None;
        }
        &prepared.get_or_insert_with(|| (nominal, self.model.pair(values, nominal))).1
    }
}
