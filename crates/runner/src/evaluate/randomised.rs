//! The probability of a cell from parts that are counted apart: randomisations and populations.

use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::conditional::{self, ConditionalPart};
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::randomisations;
use stickslip_sampler::estimate::weighted::{self, WeightedEstimate, WeightedPart};

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::rare_events::populations;
use crate::evaluate::sums::SumLayout;
use crate::job::{Answer, Job};
use stickslip_core::model::IsStopped;

/// What is counted of a part.
#[derive(Debug, Clone)]
pub struct CountedPart {
    /// Its verdicts.
    pub counts: VerdictCounts,
    /// Its further sums; none if nothing is counted yet.
    pub sums: Vec<i128>,
}

/// The probability of a cell from all its parts, with the interval of a confidence: from counted verdicts, from conditional
/// probabilities, or from samples with weights.
pub fn estimate(job: &Job, parts: &[CountedPart], confidence: f64) -> Estimate {
    if job.answer() == Answer::Probability {
        let layout = SumLayout::for_job(job);
        let of = |part: &CountedPart| layout.read_probabilities(&part.sums, &part.counts);
        return conditional::estimate(&parts.iter().map(of).collect::<Vec<ConditionalPart>>(), confidence);
    }
    if let Some(weighted) = of_weights(job, parts, confidence) {
        return weighted.estimate;
    }
    let counts: Vec<VerdictCounts> = parts.iter().map(|part| part.counts).collect();
    randomisations::estimate(&counts, job.random.inputs.len(), confidence)
}

/// The estimate of a cell whose samples have weights, with what there is to say about it; `None` for other jobs.
pub fn of_weights(job: &Job, parts: &[CountedPart], confidence: f64) -> Option<WeightedEstimate> {
    let layout = SumLayout::for_job(job);
    let weighted =
        || -> Vec<WeightedPart> { parts.iter().map(|part| layout.read_weighted(&part.sums, &part.counts)).collect() };
    match job.answer() {
        Answer::Weight => Some(weighted::estimate(&weighted(), populations(job), confidence)),
        Answer::Population => Some(weighted::estimate_of_populations(&weighted(), confidence)),
        _ => None,
    }
}

impl Evaluator<'_> {
    /// Evaluates and counts all parts of a cell; `None` if it is stopped before.
    pub fn count_cell(&self, cell: u64, is_stopped: IsStopped<'_>) -> Option<Vec<CountedPart>> {
        let parts = self.parts();
        let of_part = |part: u64| {
            let unit = self.count(part, 0..parts.max_samples(parts.place(part).1), is_stopped)?;
            Some(CountedPart { counts: unit.counts, sums: unit.sums.iter().map(|&sum| sum.into()).collect() })
        };
        parts.in_cell(cell).map(of_part).collect()
    }
}
