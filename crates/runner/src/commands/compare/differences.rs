//! The difference of two runs in every cell that they share.

use indicatif::HumanCount;
use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::estimate::difference::{Difference, PairedCounts, dependent_difference, unpaired_difference};
use stickslip_sampler::grid::Cell;

use super::evaluated_run::EvaluatedRun;
use super::matching::{Dependence, MatchedCell, Matching};
use super::pairs::{JointCounts, count_pairs};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::{Answer, Job};
use crate::output::note;
use crate::schedule::engine::Engine;

/// What the interval of a difference follows from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interval {
    /// Verdicts of both runs on the same samples.
    Paired,
    /// Counts of independent samples.
    Unpaired,
    /// Counts of samples that share random numbers, but not sample by sample.
    Dependent,
    /// The bounds of an integral, and the interval of the other run if that has samples; or the intervals of both runs if
    /// one integrates at every sample.
    Bounds,
}

impl Interval {
    /// Its name in the result column.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paired => "paired",
            Self::Unpaired => "unpaired",
            Self::Dependent => "dependent",
            Self::Bounds => "bounds",
        }
    }
}

/// The difference in one cell.
#[derive(Debug, Clone)]
pub struct Row {
    /// The cell, as the first run has it.
    pub cell: Cell,
    /// Its index in the second run.
    pub second_cell: u64,
    /// Number of pairs of samples.
    pub pairs: u64,
    /// Pairs where both are decided; none unless the cell is paired.
    pub joint: PairedCounts,
    /// Probability in the first run: of the paired samples, if there are any.
    pub first: Option<f64>,
    /// Likewise, in the second run.
    pub second: Option<f64>,
    /// The second probability minus the first.
    pub difference: Difference,
    /// What its interval follows from.
    pub interval: Interval,
}

/// The differences of two runs.
pub struct Differences<'a> {
    /// The directory of the reference, as typed.
    pub first: &'a str,
    /// The directory of the run that is compared with it, as typed.
    pub second: &'a str,
    /// The job of the reference.
    pub job: &'a Job,
    /// A row for each cell that both have, in the order of the first; at least one.
    pub rows: Vec<Row>,
}

/// Second minus first from counts that are independent or depend on each other in an unknown way. Verdicts that are not
/// known widen the interval at both ends.
fn unpaired(first: &VerdictCounts, second: &VerdictCounts, dependence: Dependence, confidence: f64) -> Difference {
    let unknown = VerdictCounts::without_verdict;
    let of = if dependence == Dependence::Independent { unpaired_difference } else { dependent_difference };
    let all =
        |up: u64, down: u64| of(second.unstable + up, second.total(), first.unstable + down, first.total(), confidence);
    let value = of(second.unstable, second.decided(), first.unstable, first.decided(), confidence).value;
    Difference { value, low: all(0, unknown(first)).low, high: all(unknown(second), 0).high }
}

/// The differences of two runs in all their common cells, each interval with this confidence.
pub fn differences<'a>(
    engine: &Engine,
    first: &EvaluatedRun<'a>,
    second: &EvaluatedRun<'a>,
    matching: &Matching,
    confidence: f64,
    interrupt: &Interrupt,
) -> Result<Differences<'a>, Failure> {
    let joints = count_pairs(engine, first, second, matching, interrupt)?;
    let (mut disagreed, mut contradicted) = (0_u64, 0_u64);
    let mut rows = Vec::with_capacity(matching.cells.len());
    for (cell, joint) in matching.cells.iter().zip(&joints) {
        let counts = [first.run.counts(cell.first), second.run.counts(cell.second)];
        let joint = (cell.dependence == Dependence::Paired).then_some(joint);
        let agreeing = joint.filter(|joint| joint.counts == counts);
        disagreed += u64::from(joint.is_some() && agreeing.is_none());
        contradicted += u64::from(first.is_contradicted(cell.first) || second.is_contradicted(cell.second));
        rows.push(row(first, second, cell, agreeing, confidence));
    }
    if disagreed > 0 {
        note(format_args!(
            "warning: in {} of {} cells the verdicts, evaluated again, differ from those that {} or {} counted (another version, or a verdict map that is wrong somewhere); the intervals of these cells allow for any dependence between the runs",
            HumanCount(disagreed),
            HumanCount(rows.len() as u64),
            first.run.name,
            second.run.name
        ));
    }
    if contradicted > 0 {
        note(format_args!(
            "warning: in {} of {} cells plain samples contradict the probability of {} or {}; these cells have no difference",
            HumanCount(contradicted),
            HumanCount(rows.len() as u64),
            first.run.name,
            second.run.name
        ));
    }
    Ok(Differences { first: &first.run.name, second: &second.run.name, job: &first.run.job, rows })
}

/// The difference in one cell: from its joint counts, if it has any, else from the counts or integrals of both runs.
fn row(
    first: &EvaluatedRun<'_>,
    second: &EvaluatedRun<'_>,
    cell: &MatchedCell,
    joint: Option<&JointCounts>,
    confidence: f64,
) -> Row {
    // A run that stopped by precision has several looks, and each has its share of the error probability.
    let share = first.error_share(cell.first) * second.error_share(cell.second);
    // The audit of either run takes as much of the error probability as the counts, and so does each of two intervals.
    let by_bounds = [first, second].iter().any(|evaluated| evaluated.run.job.answer() != Answer::Verdict);
    let sampled = [first, second].iter().filter(|evaluated| evaluated.run.job.draws_samples()).count();
    let intervals = if by_bounds { sampled.max(1) as f64 } else { 1.0 };
    let parts = intervals + [first, second].iter().filter(|evaluated| evaluated.run.is_audited()).count() as f64;
    let of_audits = 1.0 - (1.0 - confidence) / parts;
    let confidence = (1.0 - (1.0 - confidence) / parts * share).min(1.0 - 1e-15);
    let row = Row {
        cell: first.run.job.grid.cell(cell.first),
        second_cell: cell.second,
        pairs: 0,
        joint: PairedCounts::default(),
        first: None,
        second: None,
        difference: Difference { value: None, low: -1.0, high: 1.0 },
        interval: if cell.dependence == Dependence::Independent { Interval::Unpaired } else { Interval::Dependent },
    };
    let estimates = [first.estimate(cell.first, confidence), second.estimate(cell.second, confidence)];
    let [p_first, p_second] = estimates.map(|estimate| estimate.probability);
    let mut found = if by_bounds {
        let value = p_first.zip(p_second).map(|(first, second)| second - first);
        let (low, high) = (estimates[1].low - estimates[0].high, estimates[1].high - estimates[0].low);
        let difference = Difference { value, low, high };
        Row { first: p_first, second: p_second, difference, interval: Interval::Bounds, ..row }
    } else if let Some(joint) = joint {
        let PairedCounts { both, only_first, only_second, .. } = joint.decided;
        let share = |count: u64| {
            let total = joint.decided.total();
            (total > 0).then(|| count as f64 / total as f64)
        };
        Row {
            pairs: joint.lowest.total(),
            joint: joint.decided,
            first: share(both + only_first),
            second: share(both + only_second),
            difference: joint.difference(confidence),
            interval: Interval::Paired,
            ..row
        }
    } else {
        let counts = [first.run.counts(cell.first), second.run.counts(cell.second)];
        let found = unpaired(&counts[0], &counts[1], cell.dependence, confidence);
        let value = p_first.zip(p_second).map(|(first, second)| second - first).or(found.value);
        Row { first: p_first, second: p_second, difference: Difference { value, ..found }, ..row }
    };
    let unaudited = first.unaudited(cell.first, of_audits) + second.unaudited(cell.second, of_audits);
    found.difference.low = (found.difference.low - unaudited).max(-1.0);
    found.difference.high = (found.difference.high + unaudited).min(1.0);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip_core::model::verdict::Verdict;

    #[test]
    fn the_difference_is_second_minus_first() {
        let verdicts = |unstable: usize| -> Vec<Verdict> {
            (0..100).map(|i| if i < unstable { Verdict::Unstable } else { Verdict::Stable }).collect()
        };
        let joint = JointCounts::from_verdicts(&verdicts(20), &verdicts(50));
        let paired = joint.difference(0.95);
        assert_eq!(paired.value, Some(0.3));
        let [first, second] = joint.counts;
        let unpaired = unpaired(&first, &second, Dependence::Independent, 0.95);
        assert!((unpaired.value.unwrap() - 0.3).abs() < 1e-15);
        assert!(
            0.0 < unpaired.low && unpaired.low < paired.low && paired.high < unpaired.high,
            "{paired:?} {unpaired:?}"
        );
        let unknown = VerdictCounts { undecided: 10, ..first };
        let wider = super::unpaired(&unknown, &second, Dependence::Independent, 0.95);
        assert!(wider.low < unpaired.low);
        let dependent = super::unpaired(&first, &second, Dependence::Dependent, 0.95);
        assert!(dependent.low < unpaired.low && unpaired.high < dependent.high);
    }
}
