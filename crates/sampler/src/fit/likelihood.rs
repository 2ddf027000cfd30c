//! The likelihood of the tests.

use stickslip_core::model::pair_boundary::PairBoundary;

use super::data::TestData;
use super::parameter::{FitValues, Range};
use crate::inputs::{InputDistribution, Marginal, PairLaw, PairParameter};
use crate::integrate::pair::Pair;

/// Relative error of each integral, small against the steps of numerical derivatives.
const TOLERANCE: f64 = 1e-10;

/// A probability below this counts as this, so that the logarithm is finite. At a maximum no test may be as improbable.
const LEAST: f64 = 1e-300;

/// The same for the complement of a probability, whose rounding error is about as large.
const LEAST_COMPLEMENT: f64 = 1e-16;

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

    /// The probability of squeal with given values, at a nominal first input.
    pub(super) fn probability(&self, values: &FitValues, nominal: f64, boundary: &PairBoundary) -> f64 {
        let law = PairLaw::correlated(values.correlation);
        self.pair(values, nominal).probability(boundary, &law, TOLERANCE)
    }
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
        let log = |probability: f64, least: f64| libm::log(probability.max(least));
        for verdicts in &self.data.verdicts {
            let pair = self.prepare(&mut prepared, &values, verdicts.nominal);
            let probability = pair.probability(&verdicts.boundary, &law, TOLERANCE);
            if verdicts.squealed > 0.0 {
                sum += verdicts.squealed * log(probability, LEAST);
            }
            if verdicts.quiet > 0.0 {
                sum += verdicts.quiet * log(1.0 - probability, LEAST_COMPLEMENT);
            }
        }
        for onset in &self.data.onsets {
            let pair = self.prepare(&mut prepared, &values, onset.nominal);
            let [slow, fast] = &onset.boundaries;
            let probability = pair.probability_between([slow, fast], &law, TOLERANCE);
            sum += log(probability, LEAST) - libm::log(onset.width);
        }
        sum
    }

    /// The rows of tests that are as good as impossible at some coordinates, in order.
    pub(super) fn impossible(&self, coordinates: &[f64]) -> Vec<u64> {
        let values = self.values(coordinates);
        let law = PairLaw::correlated(values.correlation);
        let mut rows = Vec::new();
        for verdicts in &self.data.verdicts {
            let probability = self.model.probability(&values, verdicts.nominal, &verdicts.boundary);
            rows.extend(verdicts.rows[0].filter(|_| probability <= LEAST));
            rows.extend(verdicts.rows[1].filter(|_| 1.0 - probability <= LEAST_COMPLEMENT));
        }
        for onset in &self.data.onsets {
            let [slow, fast] = &onset.boundaries;
            let pair = self.model.pair(&values, onset.nominal);
            rows.extend((pair.probability_between([slow, fast], &law, TOLERANCE) <= LEAST).then_some(onset.row));
        }
        rows.sort_unstable();
        rows
    }

    /// The inputs at a nominal first one, those of the test before if they are the same.
    fn prepare<'p>(&self, prepared: &'p mut Option<(f64, Pair)>, values: &FitValues, nominal: f64) -> &'p Pair {
        if prepared.as_ref().is_some_and(|(of, _)| *of != nominal) {
            *prepared = None;
        }
        &prepared.get_or_insert_with(|| (nominal, self.model.pair(values, nominal))).1
    }
}
