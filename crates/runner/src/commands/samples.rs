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
use super::drawn_samples::{Add, DrawnSamples, draw};
use super::motion_report::name;
use crate::cli::SamplesArguments;
use crate::evaluate::evaluator::Evaluator;
use crate::failure::Failure;
use crate::files::table::{TableColumn, TableValues, csv_names, csv_row, write_table};
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::messages::Code;
use crate::output::{counted, output_file, quoted, result, shown};
use crate::store::directory::RunDirectory;
use crate::store::tally::Tally;
use crate::tables::surface::footer;
use stickslip_core::model::IsStopped;

/// Largest number of samples, which are held in memory.
const MOST_SAMPLES: u64 = 10_000_000;

/// Rows of CSV that are printed at a time.
const ROWS_AT_ONCE: usize = 10_000;

/// Largest number of samples of a unit of work.
const MOST_UNIT_SAMPLES: u64 = 20 * BLOCK_SAMPLES;

/// `stickslip samples`.
pub fn samples(arguments: &SamplesArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    interrupt.remark("nothing was written");
    let directory = RunDirectory::view(&arguments.run)?;
    let job = directory.job()?;
    let tally = directory.tally(&job)?;
    let evaluator = evaluator_again(&directory, &job, arguments.cell)?;
    let counts = finished_counts(&evaluator, &tally, arguments)?;
    let file =
        arguments.out.clone().unwrap_or_else(|| arguments.run.join(format!("samples-{}.parquet", arguments.cell)));
    let place = (!arguments.csv).then(|| output_file(&file)).transpose()?;
    let units = units_of(&evaluator, &tally, arguments.cell);
    let of_unit = |(part, samples): &(u64, Range<u64>), is_stopped: IsStopped<'_>, add: Add<'_>| {
        evaluator.each_decided(*part, samples.clone(), is_stopped, add);
    };
    let drawn = draw(&units, counts.total(), arguments.threads.count(), interrupt, of_unit)?;
    if drawn.counts() != counts {
        let [again, before] = [drawn.counts(), counts].map(|counts| in_words(&counts));
        return Err(Failure::InputOutput(format!(
            "{}: its samples of cell {} have other verdicts than it counted: {again}, not {before}; one of its files is wrong",
            arguments.run.display(),
            arguments.cell
        )));
    }
    let columns = columns(drawn, &job);
    let Some((out, file_name)) = place else {
        return print_csv(&columns, counts.total() as usize);
    };
    let mut pairs = footer(&job);
    pairs.push(("stickslip:cell", arguments.cell.to_string()));
    write_table(&out, &file_name, &columns, &pairs)?;
    let total = counted(counts.total().into(), "sample", "samples");
    result(&format!("{}: {total} of cell {}, {}\n", shown(&file), arguments.cell, in_words(&counts)))
}

/// Prints a table as CSV, a part after the other: it may have millions of rows.
fn print_csv(columns: &[TableColumn], rows: usize) -> Result<(), Failure> {
    result(&csv_names(columns))?;
    (0..rows).step_by(ROWS_AT_ONCE).try_for_each(|first| {
        let lines = (first..rows.min(first + ROWS_AT_ONCE)).map(|row| csv_row(columns, row));
        result(&lines.collect::<String>())
    })
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

/// The samples of a cell in units of work, each with its part.
fn units_of(evaluator: &Evaluator<'_>, tally: &Tally, cell: u64) -> Vec<(u64, Range<u64>)> {
    let length = evaluator.job().unit_samples().min(MOST_UNIT_SAMPLES);
    let of_part = |part: u64| {
        let end = tally.counts(part).total();
        (0..end).step_by(length as usize).map(move |start| (part, start..end.min(start + length)))
    };
    evaluator.parts().in_cell(cell).flat_map(of_part).collect()
}

/// One row for each sample.
fn columns(drawn: DrawnSamples, job: &Job) -> Vec<TableColumn> {
    let DrawnSamples { values, decisions, are_outside } = drawn;
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
