//! The estimate of a cell from its randomisations.

use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::estimate::conditional::{self, ConditionalPart};
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::randomisations;

use crate::evaluate::parts::Parts;
use crate::evaluate::sums::SumLayout;
use crate::job::Job;
use crate::store::tally::Tally;

/// The probability of a cell of a job with Sobol points, with the interval of a confidence: from counted verdicts, or
/// from conditional probabilities.
pub fn estimate(job: &Job, parts: &Parts, tally: &Tally, cell: u64, confidence: f64) -> Estimate {
    if job.is_conditional() {
        let layout = SumLayout::of(job);
        let of = |part: u64| layout.read_probabilities(&tally.sums(part), &tally.counts(part));
        return conditional::estimate(&parts.of(cell).map(of).collect::<Vec<ConditionalPart>>(), confidence);
    }
    let counts: Vec<VerdictCounts> = parts.of(cell).map(|part| tally.counts(part)).collect();
    randomisations::estimate(&counts, job.random.inputs.len(), confidence)
}
