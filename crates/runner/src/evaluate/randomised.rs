//! The probability of a cell from parts that are counted apart: randomisations and populations.

use std::ops::Range;

use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::conditional::{self, ConditionalPart};
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::estimate::randomisations;
use stickslip_sampler::estimate::weighted::{self, WeightedEstimate, WeightedPart};
use stickslip_sampler::integrate::closed_form::MOST_OPEN;

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::rare_events::populations;
use crate::evaluate::remembering::Asked;
use crate::evaluate::sums::SumLayout;
use crate::evaluate::unit::FinishedUnit;
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
        let of = |part: &CountedPart| layout.read_probabilities(&part.sums);
        let found = conditional::estimate(&parts.iter().map(of).collect::<Vec<ConditionalPart>>(), confidence);
        let all = parts.iter().fold(VerdictCounts::default(), |sum, part| sum + part.counts);
        // Those that are open may have any probability, and so may their share of the mean.
        let is_open = all.undecided as f64 > MOST_OPEN * all.total() as f64;
        return if is_open { Estimate { probability: None, ..found } } else { found };
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
    /// Evaluates and counts all parts of a cell, unit by unit, of which each is an answer of a search; `None` if it is stopped
    /// before.
    pub fn count_cell(&self, cell: u64, asked: &Asked<'_>, is_stopped: IsStopped<'_>) -> Option<Vec<CountedPart>> {
        let parts = self.parts();
        let of_part = |part: u64| {
            let (end, length) = (parts.max_samples(parts.place(part).1), parts.unit_samples());
            let mut counted: Option<FinishedUnit> = None;
            for first in (0..end).step_by(length as usize) {
                let next = self.asked_unit(part, first..end.min(first + length), asked, is_stopped)?;
                match &mut counted {
                    Some(counted) => counted.append(&next),
                    None => counted = Some(next),
                }
            }
            let FinishedUnit { counts, sums, .. } = counted?;
            Some(CountedPart { counts, sums: sums.into_iter().map(i128::from).collect() })
        };
        parts.in_cell(cell).map(of_part).collect()
    }

    /// A unit as an answer: its counts, and the halves of its sums, all of which are exact as numbers.
    fn asked_unit(
        &self,
        part: u64,
        samples: Range<u64>,
        asked: &Asked<'_>,
        is_stopped: IsStopped<'_>,
    ) -> Option<FinishedUnit> {
        let empty = self.empty_unit(part, samples.clone());
        let read = |numbers: &[f64]| {
            let (counts, sums) = numbers.split_at(COUNTS);
            let count = |number: &f64| (number.fract() == 0.0 && *number >= 0.0).then_some(*number as u64);
            let counts: Vec<u64> = counts.iter().map(count).collect::<Option<_>>()?;
            let &[stable, unstable, undecided, failed] = &counts[..] else { return None };
            let sums =
                sums.chunks_exact(2).map(|halves| whole([halves[0], halves[1]])).collect::<Option<Vec<i64>>>()?;
            let counts = VerdictCounts { stable, unstable, undecided, failed };
            let unit = FinishedUnit { counts, sums, ..empty.clone() };
            (unit.is_consistent(&[]) && SumLayout::for_job(self.job()).can_be(&unit)).then_some(unit)
        };
        let write = |unit: &FinishedUnit| {
            let VerdictCounts { stable, unstable, undecided, failed } = unit.counts;
            let counts = [stable, unstable, undecided, failed].map(|count| count as f64);
            counts.into_iter().chain(unit.sums.iter().flat_map(|&sum| halves(sum))).collect()
        };
        let find = || self.count(part, samples.clone(), is_stopped).ok_or(());
        asked.ask(COUNTS + 2 * empty.sums.len(), read, write, find).ok()
    }
}

/// Counts of a unit.
const COUNTS: usize = 4;

/// The upper and the lower half of a sum.
fn halves(sum: i64) -> [f64; 2] {
    [(sum >> 32) as f64, (sum & 0xffff_ffff) as f64]
}

/// The sum of two halves, if they can be such.
fn whole([upper, lower]: [f64; 2]) -> Option<i64> {
    let is_half = |half: f64, from: f64| half.fract() == 0.0 && (from..from + 4_294_967_296.0).contains(&half);
    (is_half(upper, -2_147_483_648.0) && is_half(lower, 0.0)).then_some(((upper as i64) << 32) | lower as i64)
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::path::PathBuf;

    use super::*;
    use crate::evaluate::remembering::tests::InMemory;
    use crate::job::JobSource;

    /// Criteria and sampling of jobs whose cell is counted in several units.
    const JOBS: [[&str; 2]; 3] = [
        ["\"time-domain\"\ndisc = \"rigid\"", "samples = 5000"],
        ["\"time-domain\"\ndisc = \"rigid\"", "method = \"sobol\"\nsamples = 4096\nrandomisations = 8"],
        ["\"eigenvalue\"", "method = \"conditional\"\nsamples = 131072\nrandomisations = 8"],
    ];

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn a_cell_that_is_stopped_after_every_unit_is_counted_with_no_unit_lost() {
        for [criterion, sampling] in JOBS {
            let text = format!(
                "name = \"x\"\n[axes]\npreload = 0.1\nstatic_friction = 0.39\nrotating_speed = 15.0\n[random]\n\
                 inputs = [\"preload\", \"static_friction\", \"pad.mass\"]\nrelative_std = 0.2\n[criterion]\n\
                 kind = {criterion}\n[sampling]\n{sampling}\n"
            );
            let job = JobSource { path: PathBuf::from("job.toml"), text }.job().unwrap();
            let evaluator = Evaluator::new(&job).unwrap();
            let nobody = Asked::new(None, (0, 0));
            let all = Cell::new(0);
            let never = || {
                all.set(all.get() + 1);
                false
            };
            let whole = evaluator.count_cell(0, &nobody, &never).unwrap();
            let keeper = InMemory::default();
            let mut sessions = 0;
            let counted = loop {
                // Long enough for a unit, too short for all of them.
                let asked = Cell::new(0);
                let is_stopped = || asked.replace(asked.get() + 1) > all.get() / 3;
                let answers = Asked::new(Some(&keeper), (0, 0));
                sessions += 1;
                assert!(sessions < 100, "{sampling}");
                if let Some(counted) = evaluator.count_cell(0, &answers, &is_stopped) {
                    break counted;
                }
            };
            assert!(sessions > 1, "{sampling}: {sessions}");
            for (part, of_whole) in counted.iter().zip(&whole) {
                assert_eq!((part.counts, &part.sums), (of_whole.counts, &of_whole.sums), "{sampling}");
            }
        }
    }

    #[test]
    fn sums_are_whole_again() {
        for sum in [0, 1, -1, i64::MAX, i64::MIN, 1 << 32, (1 << 53) + 1, -(1 << 53) - 1, 0x1234_5678_9abc_def0] {
            assert_eq!(whole(halves(sum)), Some(sum));
        }
        for broken in [[0.5, 0.0], [0.0, -1.0], [f64::NAN, 0.0], [0.0, 4_294_967_296.0], [3e9, 0.0]] {
            assert_eq!(whole(broken), None, "{broken:?}");
        }
    }
}
