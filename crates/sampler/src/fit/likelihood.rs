//! The likelihood of the tests.

use stickslip_core::rigid_disc::stability::StabilityBoundary;

use super::data::TestData;
use super::parameter::{FitParameter, FitValues, Range};
use crate::inputs::{InputDistribution, Marginal, PairLaw};
use crate::integrate::pair::Pair;

/// Relative error of each integral, small against the steps of numerical derivatives.
const TOLERANCE: f64 = 1e-10;

/// A probability below this counts as this, so that the logarithm is finite.
const LEAST: f64 = 1e-300;

/// The same for the complement of a probability, whose rounding error is about as large.
const LEAST_COMPLEMENT: f64 = 1e-16;

/// What is known of the random inputs before the fit.
#[derive(Debug, Clone)]
pub struct FitModel {
    /// The distributions of preload and static friction.
    pub marginals: [Marginal; 2],
    /// The values of all parameters; those to be estimated start here.
    pub values: FitValues,
}

impl FitModel {
    /// Preload and static friction at a nominal preload.
    fn pair(&self, values: &FitValues, preload: f64) -> Pair {
        let of = |marginal: &Marginal, expected: f64, std: f64| {
            let scatters = std > 0.0 || matches!(marginal, Marginal::Empirical(_));
            if scatters {
                InputDistribution::relative(marginal, expected, std)
            } else {
                InputDistribution::fixed(expected)
            }
        };
        let [of_preload, of_friction] = &self.marginals;
        Pair::new(
            of(of_preload, values.preload_factor * preload, values.preload_std),
            of(of_friction, values.static_friction, values.static_friction_std),
        )
    }

    /// The probability of squeal with given values, at a nominal preload.
    pub(super) fn probability(&self, values: &FitValues, preload: f64, boundary: &StabilityBoundary) -> f64 {
        let law = PairLaw::correlated(values.correlation);
        self.pair(values, preload).probability(boundary, &law, TOLERANCE)
    }
}

/// The likelihood as a function of the coordinates of the parameters that are estimated.
pub(super) struct Likelihood<'a> {
    pub(super) model: &'a FitModel,
    pub(super) data: &'a TestData,
    pub(super) estimated: Vec<(FitParameter, Range)>,
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
            let pair = self.prepare(&mut prepared, &values, verdicts.preload);
            let probability = pair.probability(&verdicts.boundary, &law, TOLERANCE);
            if verdicts.squealed > 0.0 {
                sum += verdicts.squealed * log(probability, LEAST);
            }
            if verdicts.quiet > 0.0 {
                sum += verdicts.quiet * log(1.0 - probability, LEAST_COMPLEMENT);
            }
        }
        for onset in &self.data.onsets {
            let pair = self.prepare(&mut prepared, &values, onset.preload);
            let [slow, fast] = &onset.boundaries;
            let probability = pair.probability_between([slow, fast], &law, TOLERANCE);
            sum += log(probability, LEAST) - libm::log(onset.width);
        }
        sum
    }

    /// The inputs at a nominal preload, those of the test before if they are the same.
    fn prepare<'p>(&self, prepared: &'p mut Option<(f64, Pair)>, values: &FitValues, preload: f64) -> &'p Pair {
        if prepared.as_ref().is_some_and(|(of, _)| *of != preload) {
            *prepared = None;
        }
        &prepared.get_or_insert_with(|| (preload, self.model.pair(values, preload))).1
    }
}
