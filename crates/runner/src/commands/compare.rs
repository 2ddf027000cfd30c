//! `compare`: finished runs cell by cell, and sample by sample where they share their samples.
//!
//! Neither surfaces nor pieces hold the joint verdicts of two runs. They are found again: samples are pure functions of
//! the seed, and their verdicts are cheap where a verdict map tells them. A cell is paired only if the verdicts found again
//! are those that either run counted. Intervals hold for all cells together, unless they are wanted for each by itself.

use std::fs;
use std::ops::Range;
use std::path::PathBuf;

use indicatif::HumanCount;
use stickslip_core::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;
use stickslip_sampler::estimate::difference::{Difference, PairedCounts};
use stickslip_sampler::estimate::difference::{dependent_difference, paired_difference, unpaired_difference};
use stickslip_sampler::estimate::interval::simultaneous_confidence;
use stickslip_sampler::estimate::interval::{BinomialInterval, Estimate, IntervalKind};
use stickslip_sampler::estimate::randomisations;

use super::differences::{Differences, Interval, Row, json, picture, summary, table};
use super::matching::{Kinship, Matching, Run};
use crate::cli::CompareArguments;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::integral::IntegratedCell;
use crate::evaluate::sums::Lookups;
use crate::failure::{Failure, Signal};
use crate::files::table::write_table;
use crate::interrupt::Interrupt;
use crate::job::Effort;
use crate::output::{note, output_file, result};
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::progress::Progress;
use crate::store::map_pieces;
use crate::tables::row::unaudited;

/// Samples of a unit of work at the most.
const MOST_UNIT_SAMPLES: u64 = 20 * BLOCK_SAMPLES;

/// `stickslip compare`.
pub fn compare(arguments: &CompareArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    if arguments.runs.len() < 2 {
        let only = arguments.runs.first().map_or_else(String::new, |run| format!(", not only {}", run.display()));
        let message =
            format!("compare takes two runs or more{only}: first the reference, then what is compared with it");
        return Err(Failure::Usage(message));
    }
    let confidence = arguments.confidence;
    if !(0.0 < confidence && confidence <= 1.0 - 1e-12) {
        let message = format!(
            "--confidence {confidence} is out of range: it must be greater than 0 and less than 1, for example 0.95"
        );
        return Err(Failure::Usage(message));
    }
    let out = arguments.out.as_deref().map(|out| output_file(out).map(|place| (out, place))).transpose()?;

    let runs: Vec<Run> = arguments.runs.iter().map(|path| Run::open(path)).collect::<Result<_, _>>()?;
    let matchings: Vec<Matching> =
        runs[1..].iter().map(|second| Matching::new(&runs[0], second)).collect::<Result<_, _>>()?;
    let is_paired: Vec<bool> =
        matchings.iter().map(|matching| matching.cells.iter().any(|cell| cell.2 == Kinship::Paired)).collect();
    let maps: Vec<PathBuf> = runs.iter().map(|run| run.directory.maps()).collect();
    let engine = Engine::new(arguments.threads.count())?;
    let mut readers = Vec::with_capacity(runs.len());
    for (i, run) in runs.iter().enumerate() {
        let needs_verdicts = if i == 0 { is_paired.contains(&true) } else { is_paired[i - 1] };
        readers.push(Reader::new(run, needs_verdicts, &maps, &engine, interrupt)?);
    }
    // Every row is one of so many that are looked at together.
    let cells =
        if arguments.pointwise { 1 } else { matchings.iter().map(|matching| matching.cells.len() as u64).sum() };
    let of_a_cell = simultaneous_confidence(confidence, cells);
    readers.iter().for_each(warn_of_audit);
    let (reference, others) = readers.split_at(1);
    let mut compared = Vec::with_capacity(others.len());
    for (second, matching) in others.iter().zip(&matchings) {
        compared.push(differences(&engine, &reference[0], second, matching, of_a_cell, interrupt)?);
    }

    if let Some((out, (directory, name))) = out {
        let footer = [
            ("stickslip:confidence", confidence.to_string()),
            ("stickslip:simultaneous", (!arguments.pointwise).to_string()),
            ("stickslip:engine_version", env!("CARGO_PKG_VERSION").to_owned()),
        ];
        write_table(&directory, &name, &table(&compared), &footer)?;
        note(format_args!("{}: {} rows", out.display(), rows(&compared)));
    }
    if arguments.json {
        return result(&format!("{:#}\n", json(&compared, confidence, !arguments.pointwise)));
    }
    let meaning = if arguments.pointwise {
        format!("of confidence {confidence} for each by itself")
    } else {
        format!("(confidence {confidence} for all together)")
    };
    let text = |compared: &Differences| format!("{}\n{}", summary(compared, &meaning), picture(compared));
    result(&compared.iter().map(text).collect::<String>())
}

fn rows(compared: &[Differences]) -> HumanCount {
    HumanCount(compared.iter().map(|differences| differences.rows.len() as u64).sum())
}

/// Says of a run that its verdict map is wrong somewhere, if its audit found that.
fn warn_of_audit(reader: &Reader<'_>) {
    let run = reader.run;
    let mut lookups = Lookups::default();
    (0..run.job.cells()).for_each(|cell| lookups.add(reader.lookups(cell)));
    if lookups.differed > 0 {
        note(format_args!(
            "warning: {}: {} of {} audited samples differed, so its verdict map is wrong somewhere; the intervals contain what the audit leaves open",
            run.name,
            HumanCount(lookups.differed),
            HumanCount(lookups.audited)
        ));
    }
}

/// A run with what evaluates its samples again.
struct Reader<'a> {
    run: &'a Run,
    evaluator: Evaluator<'a>,
    integrated: Vec<IntegratedCell>,
}

impl<'a> Reader<'a> {
    fn new(
        run: &'a Run,
        needs_verdicts: bool,
        maps: &[PathBuf],
        engine: &Engine,
        interrupt: &Interrupt,
    ) -> Result<Self, Failure> {
        let mut evaluator = Evaluator::new(&run.job)?;
        let mut integrated = Vec::new();
        if run.job.uses_maps() && (needs_verdicts || run.job.is_integrated()) {
            // A finished run of a colleague may not be ours to write to; the map is then not kept.
            let own = run.directory.maps();
            let is_ours = fs::create_dir_all(&own).is_ok() && tempfile::tempfile_in(&own).is_ok();
            map_pieces::load(evaluator.maps_mut(), &own)?;
            let mut borrowed = false;
            for other in maps.iter().filter(|other| **other != own) {
                borrowed |= map_pieces::load(evaluator.maps_mut(), other)? > 0;
            }
            let completed =
                engine.complete_maps(&mut evaluator, is_ours.then_some(own.as_path()), borrowed, interrupt)?;
            if let Outcome::Stopped(signal) = completed.outcome {
                return Err(stopped(signal));
            }
            if let Some(why) = completed.why_given_up(&run.job) {
                note(format_args!("{}: {why}", run.name));
            } else if completed.simulations > 0 {
                note(format_args!(
                    "{}: verdict map of {} tiles from {} simulations{}",
                    run.name,
                    HumanCount(evaluator.maps().needed() as u64),
                    HumanCount(completed.simulations),
                    if is_ours { "; kept in the run for the next time" } else { "" }
                ));
            }
        }
        if run.job.is_integrated() {
            let (outcome, cells) = engine.integrate(&evaluator, interrupt)?;
            if let Outcome::Stopped(signal) = outcome {
                return Err(stopped(signal));
            }
            integrated = cells;
        }
        Ok(Self { run, evaluator, integrated })
    }

    /// Probability of a cell with the interval of the given confidence, or with its bounds.
    fn estimate(&self, cell: u64, confidence: f64) -> Estimate {
        let Run { job, parts, tally, .. } = self.run;
        if let Some(integrated) = self.integrated.get(cell as usize) {
            return integrated.estimate;
        }
        if let Effort::Randomisations { .. } = job.sampling.effort {
            let parts: Vec<VerdictCounts> = parts.of(cell).map(|part| tally.counts(part)).collect();
            return randomisations::estimate(&parts, job.random.inputs.len(), confidence);
        }
        let interval = BinomialInterval::new(IntervalKind::for_confidence(confidence), confidence);
        let estimate = interval.estimate(&self.run.counts(cell));
        // The unbiased estimate, if the cell was looked at until it was known well enough.
        let probability =
            parts.estimate_at_stop(tally, cell).map_or(estimate.probability, |at_stop| at_stop.probability);
        Estimate { probability, ..estimate }
    }

    /// How the samples of a cell, or those of its audit, were judged.
    fn lookups(&self, cell: u64) -> Lookups {
        self.integrated.get(cell as usize).map_or_else(|| self.run.lookups(cell), |integrated| integrated.lookups)
    }

    /// How much of a cell's probability the audit of its verdict map does not exclude to be wrong; 0 without an audit.
    fn unaudited(&self, cell: u64, confidence: f64) -> f64 {
        if !self.run.is_audited() {
            return 0.0;
        }
        let samples = (!self.run.job.is_integrated()).then(|| self.run.counts(cell).total());
        unaudited(&self.lookups(cell), samples, confidence)
    }

    /// The share of the error that the look at which a cell stopped may take; 1 without looks.
    fn error_share(&self, cell: u64) -> f64 {
        self.run.parts.error_share_at_stop(&self.run.tally, cell)
    }
}

fn stopped(signal: Signal) -> Failure {
    let message = "nothing was compared; finished tiles of verdict maps are kept. Run the same command again";
    Failure::Stopped { signal, message: message.to_owned() }
}

/// The verdicts of two runs on the same samples of a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Joint {
    /// Pairs where both are decided.
    decided: PairedCounts,
    /// All pairs, what is unknown taken for the lowest difference, and for the highest.
    lowest: PairedCounts,
    highest: PairedCounts,
    /// Every verdict of either run, also on samples that the other does not have.
    counts: [VerdictCounts; 2],
}

impl Joint {
    /// Of consecutive samples from the same one on; the longer list goes on alone.
    fn of(first: &[Verdict], second: &[Verdict]) -> Self {
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

    /// Second minus first.
    fn difference(&self, confidence: f64) -> Difference {
        let of = |counts: &PairedCounts| {
            // The sampler's difference is first minus second.
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

/// Second minus first from counts that are independent, or depend on each other in an unknown way; what is unknown widens
/// both ends.
fn unpaired(first: &VerdictCounts, second: &VerdictCounts, kinship: Kinship, confidence: f64) -> Difference {
    let unknown = VerdictCounts::without_verdict;
    let of = if kinship == Kinship::Independent { unpaired_difference } else { dependent_difference };
    let all =
        |up: u64, down: u64| of(second.unstable + up, second.total(), first.unstable + down, first.total(), confidence);
    let value = of(second.unstable, second.decided(), first.unstable, first.decided(), confidence).value;
    Difference { value, low: all(0, unknown(first)).low, high: all(unknown(second), 0).high }
}

/// The differences of all cells of two runs, with intervals of this confidence each.
fn differences<'a>(
    engine: &Engine,
    first: &'a Reader<'_>,
    second: &'a Reader<'_>,
    matching: &Matching,
    confidence: f64,
    interrupt: &Interrupt,
) -> Result<Differences<'a>, Failure> {
    let joints = count_pairs(engine, first, second, matching, interrupt)?;
    let mut disagreed = 0_u64;
    let mut rows = Vec::with_capacity(matching.cells.len());
    for (&(index, other, kinship), joint) in matching.cells.iter().zip(&joints) {
        let counts = [first.run.counts(index), second.run.counts(other)];
        let found_again = joint.counts == counts;
        let is_paired = kinship == Kinship::Paired;
        disagreed += u64::from(is_paired && !found_again);
        // A run that stopped by precision was looked at more than once; its counts are those of any of these looks.
        let share = first.error_share(index) * second.error_share(other);
        // The audit of either run has a part of the error, as large as that of the counts.
        let parts = 1.0 + [first, second].iter().filter(|reader| reader.run.is_audited()).count() as f64;
        let of_audits = 1.0 - (1.0 - confidence) / parts;
        let confidence = (1.0 - (1.0 - confidence) / parts * share).min(1.0 - 1e-15);
        let row = Row {
            cell: first.run.job.grid.cell(index),
            second_cell: other,
            pairs: 0,
            joint: PairedCounts::default(),
            first: None,
            second: None,
            difference: Difference { value: None, low: -1.0, high: 1.0 },
            interval: if kinship == Kinship::Independent { Interval::Unpaired } else { Interval::Dependent },
        };
        let estimates = [first.estimate(index, confidence), second.estimate(other, confidence)];
        let [p_first, p_second] = estimates.map(|estimate| estimate.probability);
        let mut found = if first.run.job.is_integrated() || second.run.job.is_integrated() {
            let value = p_first.zip(p_second).map(|(first, second)| second - first);
            let (low, high) = (estimates[1].low - estimates[0].high, estimates[1].high - estimates[0].low);
            let difference = Difference { value, low, high };
            Row { first: p_first, second: p_second, difference, interval: Interval::Bounds, ..row }
        } else if is_paired && found_again {
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
            let found = unpaired(&counts[0], &counts[1], kinship, confidence);
            let value = p_first.zip(p_second).map(|(first, second)| second - first).or(found.value);
            Row { first: p_first, second: p_second, difference: Difference { value, ..found }, ..row }
        };
        let unaudited = first.unaudited(index, of_audits) + second.unaudited(other, of_audits);
        found.difference.low = (found.difference.low - unaudited).max(-1.0);
        found.difference.high = (found.difference.high + unaudited).min(1.0);
        rows.push(found);
    }
    if disagreed > 0 {
        note(format_args!(
            "warning: in {} of {} cells the verdicts that were found again are not those that {} and {} counted (another version, or a verdict map that is wrong somewhere); their intervals are those of samples that depend on each other in an unknown way",
            HumanCount(disagreed),
            HumanCount(rows.len() as u64),
            first.run.name,
            second.run.name
        ));
    }
    Ok(Differences { first: &first.run.name, second: &second.run.name, grid: &first.run.job.grid, rows })
}

/// A unit of work: some samples of a matched cell.
struct Unit {
    matched: usize,
    randomisation: usize,
    samples: Range<u64>,
}

/// Joint counts of the matched cells; nothing where samples are not shared.
fn count_pairs(
    engine: &Engine,
    first: &Reader<'_>,
    second: &Reader<'_>,
    matching: &Matching,
    interrupt: &Interrupt,
) -> Result<Vec<Joint>, Failure> {
    let length = first.run.job.unit_samples().min(second.run.job.unit_samples()).min(MOST_UNIT_SAMPLES);
    let mut units = Vec::new();
    let mut total = 0;
    for (matched, &(index, other, _)) in matching.cells.iter().enumerate().filter(|(_, cell)| cell.2 == Kinship::Paired)
    {
        // Samples that only one run has are judged too: its counts are known for all of them together only.
        let lengths = first.run.lengths(index).into_iter().zip(second.run.lengths(other));
        for (randomisation, (a, b)) in lengths.enumerate() {
            let end = a.max(b);
            total += u128::from(end);
            let starts = (0..end).step_by(length as usize);
            units.extend(starts.map(|start| Unit { matched, randomisation, samples: start..end.min(start + length) }));
        }
    }
    let mut joints = vec![Joint::default(); matching.cells.len()];
    let mut progress = Progress::new(total, "samples");
    let judge = |i: u64| {
        let unit = &units[i as usize];
        let (index, other, _) = matching.cells[unit.matched];
        let verdicts = |reader: &Reader<'_>, cell: u64| {
            let end = unit.samples.end.min(reader.run.lengths(cell)[unit.randomisation]);
            let samples = unit.samples.start..end;
            if samples.is_empty() { Vec::new() } else { reader.evaluator.verdicts(cell, unit.randomisation, samples) }
        };
        let joint = Joint::of(&verdicts(first, index), &verdicts(second, other));
        (unit.matched, unit.samples.end - unit.samples.start, joint)
    };
    let outcome = engine.for_each_in_parallel(units.len() as u64, interrupt, judge, |(matched, samples, joint)| {
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
    fn what_is_unknown_widens_both_ends() {
        use Verdict::{Failed, Stable, Undecided, Unstable};
        let first = [Stable, Stable, Unstable, Unstable, Undecided, Failed, Stable, Undecided];
        let second = [Stable, Unstable, Stable, Unstable, Unstable, Stable, Undecided];
        let joint = Joint::of(&first, &second);
        assert_eq!(joint.decided, PairedCounts { both: 1, only_first: 1, only_second: 1, neither: 1 });
        // A sample of which one verdict is known can only move so far.
        assert_eq!(joint.lowest, PairedCounts { both: 2, only_first: 2, only_second: 1, neither: 2 });
        assert_eq!(joint.highest, PairedCounts { both: 1, only_first: 1, only_second: 3, neither: 2 });
        assert_eq!([joint.counts[0].total(), joint.counts[1].total()], [8, 7], "the longer list goes on alone");
        let difference = joint.difference(0.95);
        let decided = paired_difference(&joint.decided, 0.95);
        assert_eq!(difference.value, Some(0.0));
        assert!(difference.low < 0.0 && difference.high > 0.0 && decided.low < 0.0);
    }

    #[test]
    fn the_difference_is_that_of_the_second_to_the_first() {
        let verdicts = |unstable: usize| -> Vec<Verdict> {
            (0..100).map(|i| if i < unstable { Verdict::Unstable } else { Verdict::Stable }).collect()
        };
        let joint = Joint::of(&verdicts(20), &verdicts(50));
        let paired = joint.difference(0.95);
        assert_eq!(paired.value, Some(0.3));
        let [first, second] = joint.counts;
        let unpaired = unpaired(&first, &second, Kinship::Independent, 0.95);
        assert!((unpaired.value.unwrap() - 0.3).abs() < 1e-15);
        assert!(
            0.0 < unpaired.low && unpaired.low < paired.low && paired.high < unpaired.high,
            "{paired:?} {unpaired:?}"
        );
        let unknown = VerdictCounts { undecided: 10, ..first };
        let wider = super::unpaired(&unknown, &second, Kinship::Independent, 0.95);
        assert!(wider.low < unpaired.low);
        let dependent = super::unpaired(&first, &second, Kinship::Dependent, 0.95);
        assert!(dependent.low < unpaired.low && unpaired.high < dependent.high);
    }
}
