//! A row of the surface: everything that is known of one cell.

use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::audit::{self, PlainSamples};
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::weighted::{Distrust, WeightedEstimate};
use stickslip_sampler::grid::Cell;

use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::sums::Lookups;
use crate::evaluate::unit::Recorded;

/// One row of the result.
#[derive(Debug, Clone)]
pub struct SurfaceRow {
    /// Expected values and standard deviations.
    pub cell: Cell,
    /// Verdict counts.
    pub counts: VerdictCounts,
    /// Probability and interval.
    pub estimate: Estimate,
    /// The largest share of wrong looked-up verdicts that the audit does not exclude; `None` without an audit.
    pub unaudited: Option<f64>,
    /// What the job records.
    pub recorded: Recorded,
    /// Number of samples outside the model; 0 if none are drawn.
    pub outside_physics: u64,
    /// How many of its samples, or of its audit, were simulated and audited.
    pub(super) lookups: Lookups,
    /// Further sums.
    pub(super) sums: Vec<i128>,
    /// The estimate of samples with weights, where they have them.
    pub weighted: Option<WeightedEstimate>,
    /// The integral, where the probability was integrated.
    pub(super) integrated: Option<IntegratedCell>,
    /// The plain samples beside the probability, where there are some.
    pub plain: Option<PlainSamples>,
    /// Why the probability is not to be trusted, as the column of that name has it; 0 if nothing speaks against it.
    pub distrust: u64,
}

/// Plain samples contradict the probability.
pub const CONTRADICTED: u64 = 5;

/// Critical values leave so much open that there is no probability.
pub const OPEN: u64 = 6;

/// Why an estimate is not to be trusted: by plain samples, by its weights, or as an integral that is left open.
pub fn distrust(weighted: Option<&WeightedEstimate>, is_open: bool, is_contradicted: bool) -> u64 {
    if is_contradicted {
        return CONTRADICTED;
    }
    match weighted.and_then(|weighted| weighted.distrust) {
        Some(Distrust::NothingFound) => 1,
        Some(Distrust::FewSamples) => 2,
        Some(Distrust::Disagreement) => 3,
        Some(Distrust::WithoutVerdict) => 4,
        None if is_open => OPEN,
        None => 0,
    }
}

impl SurfaceRow {
    /// The share of samples that are undecided or failed.
    pub fn unknown_share(&self) -> f64 {
        let counted = self.counts.without_verdict() as f64 / self.counts.total().max(1) as f64;
        self.integrated.map_or(counted, |integrated| integrated.undecided)
    }
}

/// The largest share of a cell with wrong looked-up verdicts that the audit does not exclude. Of the `samples` of the
/// cell, those that were simulated are right; an integral has no samples.
pub fn unaudited(lookups: &Lookups, samples: Option<u64>, confidence: f64) -> f64 {
    let looked_up = samples.map_or(1.0, |samples| {
        samples.saturating_sub(lookups.simulated + lookups.audited) as f64 / samples.max(1) as f64
    });
    looked_up * audit::upper_bound(lookups.differed, lookups.audited, confidence)
}

/// An estimate whose interval allows for a share `by` of the samples with the other verdict.
pub fn widened(estimate: &Estimate, by: f64) -> Estimate {
    Estimate { low: (estimate.low - by).max(0.0), high: (estimate.high + by).min(1.0), ..*estimate }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_samples_that_contradict_count_more_than_weights_and_open_bounds() {
        let estimate = Estimate { probability: None, low: 0.0, high: 0.01 };
        let distrusted = WeightedEstimate {
            estimate,
            mean: 0.0,
            effective: 0.0,
            evaluations: 300.0,
            distrust: Some(Distrust::NothingFound),
        };
        for (weighted, is_open, otherwise) in
            [(Some(&distrusted), false, 1), (Some(&distrusted), true, 1), (None, true, OPEN), (None, false, 0)]
        {
            let of = |is_contradicted: bool| distrust(weighted, is_open, is_contradicted);
            assert_eq!([of(false), of(true)], [otherwise, CONTRADICTED]);
        }
    }
}
