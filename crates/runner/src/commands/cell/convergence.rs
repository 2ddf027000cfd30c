//! How the estimate of a cell converges as samples are counted.

use std::ops::Range;
use std::path::Path;

use indicatif::HumanCount;
use stickslip_sampler::estimate::interval::Estimate;
use stickslip_sampler::grid::Cell;

use super::common::{FEW_SAMPLES, place};
use crate::cli::PlotArguments;
use crate::commands::completion::evaluator_again;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::parts::Parts;
use crate::evaluate::unit::FinishedUnit;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::{Answer, Effort, Job};
use crate::output::{counted, note};
use crate::picture::view::{rounded, scatter};
use crate::plot::convergence::ConvergencePlot;
use crate::plot::distribution::significant;
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::progress::Progress;
use crate::store::directory::RunDirectory;
use crate::store::tally::Tally;
use crate::tables::surface::Surface;
use stickslip_core::model::IsStopped;

/// Fewest and most samples that are drawn.
const LEAST: u64 = 4;
const MOST_SAMPLES: u64 = 10_000_000;

/// Numbers of samples at which the estimate is drawn, for each factor of ten, and the first of them: of many, and of few.
const STEPS_OF_A_DECADE: f64 = 24.0;
const FIRST: f64 = 10.0;
const MANY: u64 = 200;
const FIRST_OF_FEW: f64 = 2.0;

/// The picture of a cell of a run, or of a job before it is run.
///
/// # Errors
/// A job that draws no samples, and an interruption.
pub fn convergence(
    path: &Path,
    job: &Job,
    cell: &Cell,
    arguments: &PlotArguments,
    interrupt: &Interrupt,
) -> Result<ConvergencePlot, Failure> {
    if !job.draws_samples() {
        return Err(Failure::Usage(format!(
            "the job \"{}\" integrates its probabilities and draws no samples, so nothing converges with their number",
            job.name
        )));
    }
    let run = if path.is_dir() { Some(RunDirectory::view(path)?) } else { None };
    let counted_by_run = run.as_ref().map(|directory| directory.tally(job)).transpose()?;
    let evaluator = match &run {
        Some(directory) if job.uses_maps() => evaluator_again(directory, job, cell.index)?,
        _ => Evaluator::new(job)?,
    };
    let parts = evaluator.parts();
    // A run may end before it has drawn as many as it may.
    let of_part = |part: u64| match &counted_by_run {
        Some(tally) => tally.counts(part).total(),
        None => parts.max_samples(parts.place(part).1),
    };
    let ends: Vec<(u64, u64)> = parts.in_cell(cell.index).map(|part| (part, of_part(part))).collect();
    let all: u64 = ends.iter().map(|(_, end)| end).sum();
    let usual = if run.is_none() && job.model().has_slow_samples() { FEW_SAMPLES } else { MOST_SAMPLES };
    let samples = arguments.samples.unwrap_or(usual).min(all).min(MOST_SAMPLES);
    if samples < LEAST {
        return Err(Failure::Usage(format!(
            "{} of cell {} make no curve; draw {LEAST} or more (--samples)",
            counted(samples.into(), "sample", "samples"),
            cell.index
        )));
    }
    let units = units(&evaluator, &ends, samples, all);
    let mut tally = Tally::new(parts);
    let mut progress = Progress::new(samples.into(), "samples");
    let engine = Engine::new(arguments.threads.count())?;
    let mut counted_units: Vec<Option<FinishedUnit>> = vec![None; units.len()];
    let count = |index: u64, is_stopped: IsStopped<'_>| {
        let (_, part, range) = &units[index as usize];
        (index as usize, evaluator.count(*part, range.clone(), is_stopped))
    };
    let outcome = engine.for_each_in_parallel(units.len() as u64, interrupt, count, |(index, unit)| {
        progress.advance(unit.as_ref().map_or(0, FinishedUnit::len));
        progress.tick();
        counted_units[index] = unit;
    })?;
    progress.finish();
    if let Outcome::Stopped(signal) = outcome {
        return Err(Failure::stopped(signal, &"nothing was written".into()));
    }
    let mut estimates: Vec<(u64, Estimate)> = Vec::new();
    let mut of_all = 0;
    for (i, unit) in counted_units.iter().enumerate() {
        let Some(unit) = unit else { continue };
        tally.add(unit);
        of_all += unit.len();
        let is_last_of_step = units.get(i + 1).is_none_or(|(step, ..)| *step != units[i].0);
        if is_last_of_step {
            estimates.push((of_all, estimate(job, &tally, cell.index)));
        }
    }
    let mut notes = vec![format!(
        "{} of {}; band: {}, at each number of samples by itself",
        counted(of_all.into(), "sample", "samples"),
        scatter(job, cell.index),
        job.sampling.method.interval(&job.sampling)
    )];
    if let Some((_, Estimate { probability: Some(probability), low, high })) = estimates.last() {
        let [probability, low, high] = [probability, low, high].map(|value| rounded(significant(*value)));
        notes.push(format!("last: P = {probability} ({low} to {high})"));
    }
    let wanted = arguments.samples.unwrap_or(all);
    if samples < wanted {
        note(format_args!("{} of {} are drawn", HumanCount(samples), counted(wanted.into(), "sample", "samples")));
    }
    let what = if job.answer() == Answer::Population { "Populations of the cell" } else { "Samples of the cell" };
    Ok(ConvergencePlot { estimates, across: what.to_owned(), title: place(job, cell.index), notes })
}

/// The estimate of a cell; while a run goes on until it is precise, that of a run of as many samples.
fn estimate(job: &Job, tally: &Tally, cell: u64) -> Estimate {
    match job.sampling.effort {
        Effort::Until(_) => job.interval(job.sampling.confidence).estimate(&Parts::new(job).counts(tally, cell)),
        _ => Surface::new(job, tally).row(cell).estimate,
    }
}

/// The samples of a cell in units of work, each with the number of its step and its part: all parts grow alike, but for
/// those that follow each other.
fn units(
    evaluator: &Evaluator<'_>,
    parts_ends: &[(u64, u64)],
    samples: u64,
    all: u64,
) -> Vec<(usize, u64, Range<u64>)> {
    let parts = evaluator.parts();
    let first = if samples < MANY { FIRST_OF_FEW } else { FIRST };
    let last = libm::log10(samples.max(1) as f64 / first).max(0.0);
    let steps = (STEPS_OF_A_DECADE * last).ceil() as usize;
    let mut ends: Vec<u64> =
        (0..=steps).map(|step| (first * libm::pow(10.0, step as f64 / STEPS_OF_A_DECADE)) as u64).collect();
    ends.push(samples);
    ends.retain(|end| (1..=samples).contains(end));
    ends.sort_unstable();
    ends.dedup();
    // Up to where each part is counted after a step.
    let end_of = |part: u64, most: u64, end: u64| {
        let place = parts.place(part).1;
        if parts.are_sequential() {
            end.saturating_sub(parts.first_sample(place)).min(most)
        } else {
            (u128::from(end) * u128::from(most) / u128::from(all.max(1))) as u64
        }
    };
    let length = evaluator.job().unit_samples();
    let mut units = Vec::new();
    let mut before = 0;
    for (step, &end) in ends.iter().enumerate() {
        for &(part, most) in parts_ends {
            let range = end_of(part, most, before)..end_of(part, most, end);
            let starts = range.clone().step_by(length as usize);
            units.extend(starts.map(|start| (step, part, start..range.end.min(start + length))));
        }
        before = end;
    }
    units
}
