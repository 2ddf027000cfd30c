//! The estimate of a cell from its randomisations or populations.

use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::estimate::conditional::{self, ConditionalPart};
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::randomisations;
use stickslip_sampler::estimate::weighted::WeightedEstimate;

use crate::evaluate::parts::Parts;
use crate::evaluate::rare_events;
use crate::evaluate::sums::SumLayout;
use crate::job::Job;
use crate::store::tally::Tally;

/// The probability of a cell of a job with Sobol points, with the interval of a confidence: from counted verdicts,
/// from conditional probabilities, or from samples with weights.
pub fn estimate(job: &Job, parts: &Parts, tally: &Tally, cell: u64, confidence: f64) -> Estimate {
    if job.is_conditional() {
        let layout = SumLayout::of(job);
        let of = |part: u64| layout.read_probabilities(&tally.sums(part), &tally.counts(part));
        return conditional::estimate(&parts.of(cell).map(of).collect::<Vec<ConditionalPart>>(), confidence);
    }
    if let Some(weighted) = of_weights(job, parts, tally, cell, confidence) {
        return weighted.estimate;
    }
    let counts: Vec<VerdictCounts> = parts.of(cell).map(|part| tally.counts(part)).collect();
    randomisations::estimate(&counts, job.random.inputs.len(), confidence)
}

/// The estimate of a cell of a job whose samples have weights, with what there is to say about it; `None` for other jobs.
pub fn of_weights(job: &Job, parts: &Parts, tally: &Tally, cell: u64, confidence: f64) -> Option<WeightedEstimate> {
    if !job.is_weighted() {
        return None;
    }
    let layout = SumLayout::of(job);
    let own = parts.of(cell).map(|part| layout.read_weighted(&tally.sums(part), &tally.counts(part)));
    rare_events::estimate(job, &own.collect::<Vec<_>>(), confidence)
}
