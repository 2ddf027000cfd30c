//! The verdicts of two runs on the same samples, counted in pairs.

use std::ops::Range;

use stickslip_core::model::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;
use stickslip_sampler::estimate::difference::{Difference, PairedCounts, paired_difference};

use super::evaluated_run::{EvaluatedRun, stopped};
use super::matching::{Dependence, Matching};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::progress::Progress;
use stickslip_core::model::IsStopped;

/// Largest number of samples of a unit of work.
const MOST_UNIT_SAMPLES: u64 = 20 * BLOCK_SAMPLES;

/// The verdicts of two runs on the same samples of a cell, counted in pairs.
#[derive(Debug, Clone, Copy, Default)]
pub struct JointCounts {
    /// Pairs where both are decided.
    pub decided: PairedCounts,
    /// All pairs, with those verdicts for the unknown ones that make the difference lowest.
    pub lowest: PairedCounts,
    /// Likewise, for the highest difference.
    highest: PairedCounts,
    /// All verdicts of either run, including those on samples that the other does not have.
    pub counts: [VerdictCounts; 2],
}

impl JointCounts {
    /// Counts verdicts on consecutive samples, both lists beginning with the same sample. Where one list is longer, its
    /// remaining verdicts are in no pair.
    pub fn from_verdicts(first: &[Verdict], second: &[Verdict]) -> Self {
        let mut joint = Self::default();
        for (counts, verdicts) in joint.counts.iter_mut().zip([first, second]) {
            verdicts.iter().for_each(|&verdict| *counts += verdict.into());
        }
        for pair in first.iter().zip(second) {
            let [first, second] = [pair.0, pair.1].map(|verdict| match verdict {
                Verdict::Unstable => Some(true),
                Verdict::Stable => Some(false),
                Verdict::Undecided | Verdict::Failed => None,
            });
            if let (Some(first), Some(second)) = (first, second) {
                count(&mut joint.decided, first, second);
            }
            count(&mut joint.lowest, first.unwrap_or(true), second.unwrap_or(false));
            count(&mut joint.highest, first.unwrap_or(false), second.unwrap_or(true));
        }
        joint
    }

    /// Adds the counts of other samples.
    fn add(&mut self, other: &Self) {
        let all = |joint: &Self| [joint.decided, joint.lowest, joint.highest];
        for (own, other) in [&mut self.decided, &mut self.lowest, &mut self.highest].into_iter().zip(all(other)) {
            own.both += other.both;
            own.only_first += other.only_first;
            own.only_second += other.only_second;
            own.neither += other.neither;
        }
        for (own, other) in self.counts.iter_mut().zip(other.counts) {
            *own += other;
        }
    }

    /// The probability in the second run minus that in the first, with the interval of a confidence. Verdicts that are
    /// not known widen it at both ends.
    pub fn difference(&self, confidence: f64) -> Difference {
        let of = |counts: &PairedCounts| {
            // `paired_difference` is first minus second.
            let exchanged = PairedCounts { only_first: counts.only_second, only_second: counts.only_first, ..*counts };
            paired_difference(&exchanged, confidence)
        };
        Difference { value: of(&self.decided).value, low: of(&self.lowest).low, high: of(&self.highest).high }
    }
}

fn count(counts: &mut PairedCounts, first: bool, second: bool) {
    match (first, second) {
        (true, true) => counts.both += 1,
        (true, false) => counts.only_first += 1,
        (false, true) => counts.only_second += 1,
        (false, false) => counts.neither += 1,
    }
}

/// A unit of work: some samples of a matched cell.
struct Unit {
    /// The place of the cell among the matched ones.
    matched: usize,
    randomisation: usize,
    samples: Range<u64>,
}

/// The joint counts of all matched cells, all zero where samples are not shared.
pub fn count_pairs(
    engine: &Engine,
    first: &EvaluatedRun<'_>,
    second: &EvaluatedRun<'_>,
    matching: &Matching,
    interrupt: &Interrupt,
) -> Result<Vec<JointCounts>, Failure> {
    let length = first.run.job.unit_samples().min(second.run.job.unit_samples()).min(MOST_UNIT_SAMPLES);
    let mut units = Vec::new();
    let mut total = 0;
    let paired = matching.cells.iter().enumerate().filter(|(_, cell)| cell.dependence == Dependence::Paired);
    for (matched, cell) in paired {
        // Samples that only one run has are evaluated, too: the counts that the run stored are those of all its
        // samples.
        let lengths = first.run.lengths(cell.first).into_iter().zip(second.run.lengths(cell.second));
        for (randomisation, (a, b)) in lengths.enumerate() {
            let end = a.max(b);
            total += u128::from(end);
            let starts = (0..end).step_by(length as usize);
            units.extend(starts.map(|start| Unit { matched, randomisation, samples: start..end.min(start + length) }));
        }
    }
    let mut joints = vec![JointCounts::default(); matching.cells.len()];
    let mut progress = Progress::new(total, "samples");
    let evaluate = |i: u64, is_stopped: IsStopped<'_>| {
        let unit = &units[i as usize];
        let cell = matching.cells[unit.matched];
        let verdicts = |run: &EvaluatedRun<'_>, cell: u64| {
            let end = unit.samples.end.min(run.run.lengths(cell)[unit.randomisation]);
            let samples = unit.samples.start..end;
            match &run.evaluator {
                Some(evaluator) if !samples.is_empty() => {
                    evaluator.verdicts(cell, unit.randomisation, samples, is_stopped)
                }
                _ => Vec::new(),
            }
        };
        let joint = JointCounts::from_verdicts(&verdicts(first, cell.first), &verdicts(second, cell.second));
        (unit.matched, unit.samples.end - unit.samples.start, joint)
    };
    let outcome =
        engine.for_each_in_parallel(units.len() as u64, interrupt, evaluate, |(matched, samples, joint)| {
            joints[matched].add(&joint);
            progress.advance(samples);
            progress.tick();
        })?;
    progress.finish();
    match outcome {
        Outcome::Finished => Ok(joints),
        Outcome::Stopped(signal) => Err(stopped(signal)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_verdicts_widen_both_ends() {
        use Verdict::{Failed, Stable, Undecided, Unstable};
        let first = [Stable, Stable, Unstable, Unstable, Undecided, Failed, Stable, Undecided];
        let second = [Stable, Unstable, Stable, Unstable, Unstable, Stable, Undecided];
        let joint = JointCounts::from_verdicts(&first, &second);
        assert_eq!(joint.decided, PairedCounts { both: 1, only_first: 1, only_second: 1, neither: 1 });
        // Where one verdict of a pair is known, the pair cannot take every value.
        assert_eq!(joint.lowest, PairedCounts { both: 2, only_first: 2, only_second: 1, neither: 2 });
        assert_eq!(joint.highest, PairedCounts { both: 1, only_first: 1, only_second: 3, neither: 2 });
        assert_eq!([joint.counts[0].total(), joint.counts[1].total()], [8, 7], "the longer list has a verdict more");
        let difference = joint.difference(0.95);
        let decided = paired_difference(&joint.decided, 0.95);
        assert_eq!(difference.value, Some(0.0));
        assert!(difference.low < 0.0 && difference.high > 0.0 && decided.low < 0.0);
    }
}
