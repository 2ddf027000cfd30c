//! The probability of a cell by integration instead of samples.

use stickslip_core::rigid_disc::stability::StabilityBoundary;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::grid::Cell;
use stickslip_sampler::inputs::PairLaw;
use stickslip_sampler::integrate::closed_form::{self, ExactProbability};
use stickslip_sampler::integrate::derivatives::Derivatives;
use stickslip_sampler::integrate::verdict_map::{BoundedProbability, MapRegions};

use crate::evaluate::evaluator::Evaluator;
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

/// The probability of a cell whose boundary of stability is known in closed form, where only preload and static friction
/// scatter.
pub fn exact_probability(job: &Job, boundary: &StabilityBoundary, cell: &Cell) -> ExactProbability {
    if job.random.is_plain() {
        return closed_form::probability(boundary, cell);
    }
    let coefficient = job.random.pairs.first().map_or(0.0, |&(_, _, coefficient)| coefficient);
    job.pair(cell).exact_probability(boundary, &PairLaw::correlated(coefficient))
}

impl Evaluator<'_> {
    /// The regions of the maps, one for each brake; none without maps.
    pub fn regions(&self) -> Vec<MapRegions> {
        (0..self.job.grid.brakes()).filter_map(|brake| self.maps.get(brake)).map(MapRegions::new).collect()
    }

    /// The probability of a cell, in closed form or from `regions`; `lookups` is the audit of its map.
    pub fn integrate(&self, cell: &Cell, regions: &[MapRegions], lookups: Lookups) -> IntegratedCell {
        let brake = self.job.grid.brake_index(cell.index);
        if let Some(boundary) = &self.criteria.boundary(self.job, brake) {
            let exact = exact_probability(self.job, boundary, cell);
            let low = (exact.value - exact.error_bound).max(0.0);
            let high = (exact.value + exact.error_bound).min(1.0);
            let wanted = self.job.sampling.derivatives;
            let derivatives = if wanted { closed_form::derivatives(boundary, cell) } else { Derivatives::default() };
            let estimate = Estimate { probability: Some(exact.value), low, high };
            return IntegratedCell { estimate, derivatives, ..IntegratedCell::unknown() };
        }
        let mapped = regions[brake].probability(cell);
        let estimate = Estimate { probability: mapped.value, low: mapped.low, high: mapped.high };
        let BoundedProbability { derivatives, undecided, .. } = mapped;
        IntegratedCell { estimate, derivatives, undecided, lookups }
    }
}
