//! The probability of a cell by integration instead of samples.

use std::convert::Infallible;

use stickslip_core::model::IsStopped;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::{InputDistribution, PairLaw};
use stickslip_sampler::integrate::NormalPair;
use stickslip_sampler::integrate::closed_form::{self, ExactProbability};
use stickslip_sampler::integrate::derivatives::Derivatives;
use stickslip_sampler::integrate::pair::Pair;
use stickslip_sampler::integrate::verdict_map::{BoundedProbability, MapRegions};

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::remembered_intervals::RememberedIntervals;
use crate::evaluate::remembering::Asked;
use crate::evaluate::sums::Lookups;
use crate::job::Job;

/// The probability of a cell by integration.
#[derive(Debug, Clone, Copy)]
pub struct IntegratedCell {
    /// The probability and its error bounds.
    pub estimate: Estimate,
    /// Its derivatives.
    pub derivatives: Derivatives,
    /// The probability that a sample is undecided or fails.
    pub undecided: f64,
    /// The audit of the map behind it.
    pub lookups: Lookups,
}

impl IntegratedCell {
    /// A cell that is not integrated yet.
    pub fn unknown() -> Self {
        Self {
            estimate: Estimate { probability: None, low: 0.0, high: 1.0 },
            derivatives: Derivatives::default(),
            undecided: 0.0,
            lookups: Lookups::default(),
        }
    }
}

/// The probability of instability with a boundary of stability, where only the pair of the model scatters: with these
/// expected values and standard deviations. The inputs are normal and independent where the job says no more, and have the
/// distributions of the job otherwise.
pub fn exact_probability(job: &Job, boundary: &PairBoundary, pair: &NormalPair) -> ExactProbability {
    if job.random.is_plain() {
        return closed_form::probability(boundary, pair);
    }
    let correlation = job.random.pairs.first().map_or(0.0, |&(_, _, coefficient)| coefficient);
    let of = |which: usize| match job.random.pair()[which] {
        Some(position) => {
            let marginal = &job.random.marginals[position];
            InputDistribution::relative(marginal, pair.expected[which], pair.relative_std[which])
        }
        None => InputDistribution::fixed(pair.expected[which]),
    };
    Pair::new(of(0), of(1)).exact_probability(boundary, &PairLaw::correlated(correlation))
}

impl Evaluator<'_> {
    /// The regions of the maps, one for each configuration; none without maps.
    pub fn regions(&self) -> Vec<MapRegions> {
        (0..self.job.grid.configurations()).filter_map(|index| self.maps.get(index)).map(MapRegions::new).collect()
    }

    /// The probability of a cell, in closed form or from `regions`; `lookups` is the audit of its map. `None` if it is stopped
    /// before.
    pub fn integrate(
        &self,
        cell: &Cell,
        regions: &[MapRegions],
        lookups: Lookups,
        is_stopped: IsStopped<'_>,
    ) -> Option<IntegratedCell> {
        let index = self.job.grid.configuration_index(cell.index);
        let pair = self.job.normal_pair(cell);
        let asked = |cell: u64| Asked::new(self.keeper.as_deref(), (cell, 0));
        if let Some(boundary) = &self.criteria.boundary(self.job, index) {
            let Ok(estimate) = asked(cell.index).estimate(|| {
                let exact = exact_probability(self.job, boundary, &pair);
                let low = (exact.value - exact.error_bound).max(0.0);
                let high = (exact.value + exact.error_bound).min(1.0);
                Ok::<_, Infallible>(Estimate { probability: Some(exact.value), low, high })
            });
            let wanted = self.job.sampling.derivatives;
            let derivatives = if wanted { closed_form::derivatives(boundary, &pair) } else { Derivatives::default() };
            return Some(IntegratedCell { estimate, derivatives, ..IntegratedCell::unknown() });
        }
        if let Some(place) = self.job.integrated() {
            // All cells that differ in the input alone have one search, which is kept with the first of them.
            let asked = asked(self.job.grid.first_cell_but_for(place, cell.index));
            let memory = RememberedIntervals { asked: &asked, is_stopped };
            let estimate = self.unstable_values.estimate(self.job, cell, place, &memory);
            return (!is_stopped()).then(|| IntegratedCell { estimate, ..IntegratedCell::unknown() });
        }
        let mapped = regions[index].probability(&pair);
        let estimate = Estimate { probability: mapped.value, low: mapped.low, high: mapped.high };
        let BoundedProbability { derivatives, undecided, .. } = mapped;
        Some(IntegratedCell { estimate, derivatives, undecided, lookups })
    }
}
