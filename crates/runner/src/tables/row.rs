//! What is known of one cell: a row of the surface.

use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::estimate::audit;
use stickslip_sampler::estimate::distribution::Distribution;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::grid::Cell;

use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::sums::Lookups;

/// One row of the result.
#[derive(Debug, Clone)]
pub struct SurfaceRow {
    /// Expected values and scatter.
    pub cell: Cell,
    /// Verdicts.
    pub counts: VerdictCounts,
    /// Probability and interval.
    pub estimate: Estimate,
    /// The share of samples whose looked-up verdict the audit does not exclude to be wrong; `None` without an audit.
    pub unaudited: Option<f64>,
    /// Settled amplitudes of the unstable samples, if the job records them.
    pub amplitudes: Distribution,
    /// Samples without preload or with friction that rises with speed; 0 where none are drawn.
    pub outside_physics: u64,
    /// How its samples, or those of its audit, were judged.
    pub(super) lookups: Lookups,
    /// Further sums that the job asks for.
    pub(super) sums: Vec<i128>,
    /// What is known beside the probability, where it was integrated.
    pub(super) integrated: Option<IntegratedCell>,
}

impl SurfaceRow {
    /// The share of samples without a verdict, undecided or failed.
    pub fn unknown_share(&self) -> f64 {
        let counted = self.counts.without_verdict() as f64 / self.counts.total().max(1) as f64;
        self.integrated.map_or(counted, |integrated| integrated.undecided)
    }
}

/// The share of a cell whose looked-up verdicts may be wrong, as far as the audit does not exclude it. Of `samples` in all,
/// those that were simulated are right; an integral has none.
pub fn unaudited(lookups: &Lookups, samples: Option<u64>, confidence: f64) -> f64 {
    let looked_up = samples.map_or(1.0, |samples| {
        samples.saturating_sub(lookups.simulated + lookups.audited) as f64 / samples.max(1) as f64
    });
    looked_up * audit::upper_bound(lookups.differed, lookups.audited, confidence)
}

/// An estimate if so large a share of the samples may have the other verdict.
pub fn widened(estimate: &Estimate, by: f64) -> Estimate {
    Estimate { low: (estimate.low - by).max(0.0), high: (estimate.high + by).min(1.0), ..*estimate }
}
