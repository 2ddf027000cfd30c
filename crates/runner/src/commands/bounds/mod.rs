//! `bounds`: the lower and upper probability of instability over imprecise inputs.

mod report;

use indicatif::HumanCount;
use serde_json::json;
use stickslip_sampler::imprecise::bounds::Bounds;
use stickslip_sampler::imprecise::result::{Extreme, Trend};
use stickslip_sampler::integrate::closed_form::ExactProbability;

use self::report::{Found, Reached, Row, imprecise_json};
use super::kept_beside::{KeptBeside, nothing_was_written};
use crate::cli::{BoundsArguments, CheckArguments};
use crate::evaluate::bounds::{Ended, ImpreciseCell, kept_bounds};
use crate::evaluate::remembering::Keeper;
use crate::failure::{Advice, Failure};
use crate::files::table::write_table;
use crate::interrupt::Interrupt;
use crate::job::{Combination, ImpreciseJob, JobSource};
use crate::messages::Code;
use crate::output::{announce, counted, output_file, result, warn};
use crate::schedule::engine::Engine;
use crate::shell::{quoted, shown};
use crate::store::searches::digest_of_searches;
use stickslip_core::model::IsStopped;

/// `stickslip bounds`.
pub fn bounds(arguments: &BoundsArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    interrupt.remark(nothing_was_written());
    let BoundsArguments { job: path, out, json, threads } = arguments;
    let source = JobSource::read(path)?;
    let job = source.imprecise_job()?;
    if job.quantities.is_empty() {
        return Err(Failure::Usage(format!(
            "nothing in the job \"{}\" is imprecise: write {{ between = [LOW, HIGH] }} or {{ one_of = [A, B] }} in place of a value, for example relative_std = {{ between = [0.1, 0.3] }}. A job without imprecise values is for `stickslip submit`",
            job.first().name
        )));
    }
    let out = out.as_deref().map(|out| output_file(out).map(|place| (out, place))).transpose()?;
    warn(job.warnings.clone());
    let engine = Engine::new(threads.count())?;
    let mut found = Found { source: &source, job: &job, rows: Vec::new() };
    let searches = || digest_of_searches("bounds", &job.first().experiment_hash(), &found.footer());
    let kept = out.as_ref().map(|(_, place)| KeptBeside::read(place, searches())).transpose()?;
    let stopped = kept.as_ref().map_or_else(nothing_was_written, KeptBeside::advice);
    interrupt.remark(stopped.clone());
    found.rows = all_rows(&engine, interrupt, &job, &stopped, kept.as_ref().map(KeptBeside::keeper))?;
    if let Some((out, (directory, name))) = out {
        write_table(&directory, &name, &found.table(), &found.footer())?;
        kept.into_iter().for_each(KeptBeside::forget);
        announce(Code::FileWritten, format_args!("{}: {} rows", out.display(), HumanCount(found.rows.len() as u64)));
    }
    result(&if *json { format!("{:#}\n", found.json()) } else { found.text() })
}

/// `stickslip check` of a job with imprecise inputs.
pub fn check(source: &JobSource, arguments: &CheckArguments) -> Result<(), Failure> {
    let job = source.imprecise_job()?;
    let first = job.first();
    warn(job.warnings.clone());
    if arguments.json {
        let found = json!({ "name": first.name, "cells": first.cells(), "imprecise": imprecise_json(&job) });
        return result(&format!("{found:#}\n"));
    }
    let path = shown(&source.path);
    let quantities: String = job.quantities.iter().map(|quantity| format!("#   {}\n", quantity.text())).collect();
    let combinations = match job.combinations.len() {
        1 => String::new(),
        several => format!(", {several} combinations of alternatives in each"),
    };
    let all = if arguments.all { format!("\n{}", job.normalised()) } else { String::new() };
    result(&format!(
        "# {path} is valid, with imprecise inputs:\n{quantities}# {}{combinations}\n# `stickslip bounds {}` finds the lower and upper probability of each cell\n{}",
        counted(first.cells().into(), "cell", "cells"),
        quoted(&source.path),
        all
    ))
}

/// The rows of all cells, in their order.
fn all_rows(
    engine: &Engine,
    interrupt: &Interrupt,
    job: &ImpreciseJob,
    stopped: &Advice,
    keeper: Option<&dyn Keeper>,
) -> Result<Vec<Row>, Failure> {
    engine.in_order(job.first().cells(), "cells", interrupt, stopped, |cell, is_stopped| {
        match row(job, cell, keeper, is_stopped) {
            Ok(row) => Ok(Some(row)),
            Err(Ended::Stopped) => Ok(None),
            Err(Ended::NoSuchConfiguration(error)) => Err(Failure::Job(format!(
                "there is no configuration with some of the imprecise values in cell {cell}: {error}; choose intervals between which there is one everywhere"
            ))),
            Err(Ended::NoCriticalValues(place)) => Err(Failure::Job(format!(
                "the critical values of {} cannot be found with some of the imprecise values in cell {cell}; choose narrower intervals",
                job.first().quantity(place).name
            ))),
        }
    })
}

/// The bounds of a cell over all combinations of alternatives.
fn row(job: &ImpreciseJob, cell: u64, keeper: Option<&dyn Keeper>, is_stopped: IsStopped<'_>) -> Result<Row, Ended> {
    let mut row: Option<Row> = None;
    for (number, combination) in job.combinations.iter().enumerate() {
        let (found, places) = kept_bounds(keeper, (cell, number as u64), |asked| {
            ImpreciseCell::new(&combination.job, cell, &job.quantities, is_stopped, asked)
        })?;
        let next = of_bounds(job, combination, cell, &places, &found);
        row = Some(match row {
            None => next,
            Some(row) => row.with(next),
        });
    }
    // There is at least one combination.
    row.ok_or(Ended::Stopped)
}

/// The row of one combination of alternatives.
fn of_bounds(job: &ImpreciseJob, combination: &Combination, cell: u64, places: &[usize], found: &Bounds) -> Row {
    let reached = |which: usize| {
        let Extreme { at, probability, bound } = &found.extremes[which];
        let mut values: Vec<Option<f64>> = vec![None; job.quantities.len()];
        places.iter().zip(at).for_each(|(&place, value)| values[place] = Some(*value));
        let ExactProbability { value, error_bound } = *probability;
        Reached {
            probability: value,
            error_bound,
            bound: *bound,
            evidence: found.evidence[which],
            choice: combination.choice.clone(),
            values,
        }
    };
    let mut trends: Vec<Option<Trend>> = vec![None; job.quantities.len()];
    places.iter().zip(&found.trends).for_each(|(&place, trend)| trends[place] = Some(*trend));
    Row { cell, ends: [reached(0), reached(1)], trends, evaluations: found.evaluations }
}
