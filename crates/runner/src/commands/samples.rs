//! `samples`: every sample of one cell of a run, with its inputs and its verdict.
//!
//! Runs keep counts, not samples. These are pure functions of the seed, so they are drawn and decided once more, and
//! must give the counts of the run.

use std::ops::Range;

use indicatif::HumanCount;
use stickslip_core::model::decision::Decision;
use stickslip_core::model::verdict::{Verdict, VerdictCounts};
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;

use super::completion::evaluator_again;
use super::motion_report::name;
use crate::cli::SamplesArguments;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::samples::Samples;
use crate::failure::Failure;
use crate::files::table::{TableColumn, TableValues, write_table};
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::messages::Code;
use crate::output::{counted, output_file, quoted, result, shown};
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::progress::Progress;
use crate::store::directory::RunDirectory;
use crate::store::tally::Tally;
use crate::tables::surface::footer;
use stickslip_core::model::IsStopped;

/// Largest number of samples, which are held in memory.
const MOST_SAMPLES: u64 = 10_000_000;

/// Largest number of samples of a unit of work.
const MOST_UNIT_SAMPLES: u64 = 20 * BLOCK_SAMPLES;

/// `stickslip samples`.
pub fn samples(arguments: &SamplesArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    interrupt.remark("nothing was written");
    let directory = RunDirectory::view(&arguments.run)?;
    let job = directory.job()?;
    let tally = directory.tally(&job)?;
    let evaluator = evaluator_again(&directory, &job, &tally, arguments.cell)?;
    let counts = finished_counts(&evaluator, &tally, arguments)?;
    let file =
        arguments.out.clone().unwrap_or_else(|| arguments.run.join(format!("samples-{}.parquet", arguments.cell)));
    let (out, file_name) = output_file(&file)?;
    let drawn = draw(&evaluator, &tally, arguments, interrupt)?;
    if drawn.counts() != counts {
        let [again, before] = [drawn.counts(), counts].map(|counts| in_words(&counts));
        return Err(Failure::InputOutput(format!(
            "{}: its samples of cell {} have other verdicts than it counted: {again}, not {before}; one of its files is wrong",
            arguments.run.display(),
            arguments.cell
        )));
    }
    let mut pairs = footer(&job);
    pairs.push(("stickslip:cell", arguments.cell.to_string()));
    write_table(&out, &file_name, &drawn.columns(&job), &pairs)?;
    let total = counted(counts.total().into(), "sample", "samples");
    result(&format!("{}: {total} of cell {}, {}\n", shown(&file), arguments.cell, in_words(&counts)))
}

fn in_words(counts: &VerdictCounts) -> String {
    let VerdictCounts { stable, unstable, undecided, failed } = *counts;
    let of = |count: u64, verdict| format!("{} {}", HumanCount(count), name(verdict));
    let mut words = vec![of(unstable, Verdict::Unstable), of(stable, Verdict::Stable)];
    words.extend((undecided > 0).then(|| of(undecided, Verdict::Undecided)));
    words.extend((failed > 0).then(|| of(failed, Verdict::Failed)));
    words.join(", ")
}

/// The verdicts that the run counted in the cell, if it has all of them and not too many.
fn finished_counts(
    evaluator: &Evaluator<'_>,
    tally: &Tally,
    arguments: &SamplesArguments,
) -> Result<VerdictCounts, Failure> {
    let SamplesArguments { run, cell, .. } = arguments;
    let counts = evaluator.parts().counts(tally, *cell);
    if !evaluator.parts().is_complete(tally, *cell) {
        let resume = format!("stickslip resume {}", quoted(run));
        return Err(Failure::Job(format!(
            "cell {cell} of {} is not finished, it has {}; compute the others with `{resume}`",
            run.display(),
            counted(counts.total().into(), "sample", "samples"),
        ))
        .coded(Code::Incomplete)
        .remedied(resume));
    }
    if counts.total() > MOST_SAMPLES {
        return Err(Failure::Usage(format!(
            "cell {cell} has {} samples, and samples writes {} at most; look at single ones with `stickslip replay {} --cell {cell} --sample J`, or submit the job with fewer (--samples N --out DIR): they are the first ones of these",
            HumanCount(counts.total()),
            HumanCount(MOST_SAMPLES),
            quoted(run)
        )));
    }
    Ok(counts)
}

/// Consecutive samples, in columns.
#[derive(Default)]
struct DrawnSamples {
    /// The values of each random input, in the job's order.
    values: Vec<Vec<f64>>,
    decisions: Vec<Decision>,
    are_outside: Vec<bool>,
}

/// Draws and decides all samples of the cell.
fn draw(
    evaluator: &Evaluator<'_>,
    tally: &Tally,
    arguments: &SamplesArguments,
    interrupt: &Interrupt,
) -> Result<DrawnSamples, Failure> {
    let length = evaluator.job().unit_samples().min(MOST_UNIT_SAMPLES);
    let units: Vec<(u64, Range<u64>)> = evaluator
        .parts()
        .in_cell(arguments.cell)
        .flat_map(|part| {
            let end = tally.counts(part).total();
            (0..end).step_by(length as usize).map(move |start| (part, start..end.min(start + length)))
        })
        .collect();
    let mut drawn: Vec<DrawnSamples> = Vec::new();
    drawn.resize_with(units.len(), DrawnSamples::default);
    let mut progress = Progress::new(evaluator.parts().counts(tally, arguments.cell).total().into(), "samples");
    let evaluate = |index: u64, is_stopped: IsStopped<'_>| {
        let (part, samples) = units[index as usize].clone();
        let mut unit = DrawnSamples::default();
        evaluator
            .each_decided(part, samples, is_stopped, |chunk, decisions, outside| unit.add(chunk, decisions, outside));
        (index as usize, unit)
    };
    let engine = Engine::new(arguments.threads.count())?;
    let outcome = engine.for_each_in_parallel(units.len() as u64, interrupt, evaluate, |(index, unit)| {
        progress.advance(unit.decisions.len() as u64);
        progress.tick();
        drawn[index] = unit;
    })?;
    progress.finish();
    match outcome {
        Outcome::Finished => Ok(drawn.into_iter().fold(DrawnSamples::default(), DrawnSamples::followed_by)),
        Outcome::Stopped(signal) => Err(Failure::stopped(signal, &"nothing was written".into())),
    }
}

impl DrawnSamples {
    /// Adds the samples of a chunk.
    fn add(&mut self, chunk: &Samples, decisions: &[Decision], outside: Option<Vec<bool>>) {
        self.values.resize(chunk.values(0).count(), Vec::new());
        for sample in 0..decisions.len() {
            self.values.iter_mut().zip(chunk.values(sample)).for_each(|(column, value)| column.push(value));
        }
        self.decisions.extend_from_slice(decisions);
        self.are_outside.extend(outside.unwrap_or_else(|| vec![false; decisions.len()]));
    }

    /// These and those after them.
    fn followed_by(mut self, next: Self) -> Self {
        self.values.resize(next.values.len(), Vec::new());
        for (values, further) in self.values.iter_mut().zip(next.values) {
            values.extend(further);
        }
        self.decisions.extend(next.decisions);
        self.are_outside.extend(next.are_outside);
        self
    }

    fn counts(&self) -> VerdictCounts {
        self.decisions.iter().fold(VerdictCounts::default(), |counts, decision| counts + decision.verdict.into())
    }

    /// One row for each sample.
    fn columns(self, job: &Job) -> Vec<TableColumn> {
        let Self { values, decisions, are_outside } = self;
        let column = |name: &'static str, unit: &'static str, long_name: &str, values| TableColumn {
            name: name.into(),
            unit: unit.into(),
            long_name: long_name.to_owned().into(),
            values,
        };
        let numbers = TableValues::Integer((0..decisions.len() as u64).collect());
        let mut columns =
            vec![column("sample", "1", "0-based number of the sample in its cell, as replay takes it", numbers)];
        for (&input, values) in job.random.inputs.iter().zip(values) {
            let quantity = job.quantity(input);
            columns.push(TableColumn {
                name: quantity.column.clone(),
                unit: quantity.unit.clone(),
                long_name: format!("{}, as drawn", quantity.description).into(),
                values: TableValues::Real(values.into_iter().map(Some).collect()),
            });
        }
        let verdicts = decisions.iter().map(|decision| Some(name(decision.verdict))).collect();
        let meaning = "verdict that the run counts: stable, unstable, undecided or failed";
        columns.push(column("verdict", "1", meaning, TableValues::Word(verdicts)));
        let outside = TableValues::Integer(are_outside.into_iter().map(u64::from).collect());
        let meaning = format!(
            "1 for a sample outside the model ({}), decided as criterion.outside_physics specifies, otherwise 0",
            job.model().outside_meaning()
        );
        columns.push(column("outside_physics", "1", &meaning, outside));
        let sources = job.model().sources();
        if let Some((last, others)) = sources.split_last() {
            let name = |decision: &Decision| decision.fed_by.map(|source| sources[source].name);
            let others: Vec<&str> = others.iter().map(|source| source.name).collect();
            let meaning = format!("what feeds an unstable sample: {} or {}", others.join(", "), last.name);
            columns.push(column("fed_by", "1", &meaning, TableValues::Word(decisions.iter().map(name).collect())));
        }
        for (place, result) in job.model().recorded().iter().enumerate() {
            let meaning = format!("{} of {}, {}", result.noun, result.of.nouns()[0], result.meaning);
            let values = decisions.iter().map(|decision| decision.recorded[place]).collect();
            columns.push(column(result.name, result.unit, &meaning, TableValues::Real(values)));
        }
        columns
    }
}
