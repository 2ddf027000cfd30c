//! `check`: validates a job and estimates its cost.

use std::sync::Arc;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use stickslip_core::model::quantity::{Quantity, Role};

use super::costs::{Cost, measured};
use super::named_job::read_job;
use crate::cli::CheckArguments;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{counted, result, shown, warn};
use crate::schedule::within::within;

/// When the cost has to be known after the command began. What takes longer, such as a single sample of large matrices, is
/// not waited for.
const LONGEST: Duration = Duration::from_secs(9);

/// `stickslip check`.
pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let begun = Instant::now();
    let source = read_job(&arguments.job)?;
    let job = Arc::new(source.job()?);
    warn(job.warnings());
    let threads = arguments.threads.count();
    let left = LONGEST.saturating_sub(begun.elapsed());
    let trial = {
        let job = Arc::clone(&job);
        within(left, move || measured(&job, threads, begun))?
    };
    let cost = match trial {
        Some(cost) => cost?,
        None => Cost::unknown(&job, left.as_secs_f64()),
    };
    if arguments.json {
        return result(&format!("{:#}\n", as_json(&job, threads, &cost)));
    }
    let all = match arguments.all {
        true => format!("\n{}", job.with_all_keys()),
        false => "# --all shows every key with its value, defaults too\n".to_owned(),
    };
    result(&format!(
        "# {} is valid.\n# {}: {}\n{}{}{}{all}",
        shown(&source.path),
        counted(job.cells().into(), "cell", "cells"),
        axes(&job),
        job.model.remarks(&job.grid),
        cost.text,
        plain_samples(&job),
    ))
}

/// A line on the samples beside probabilities that do not come from such.
fn plain_samples(job: &Job) -> String {
    const AT_LIMITS: &str = "at each limit and both ends of its axis";
    let [beside_cells, at_limits] = [job.plain_samples(), at_limits(job)];
    let place = match (beside_cells, at_limits) {
        (0, 0) => return String::new(),
        (0, _) => AT_LIMITS.to_owned(),
        (_, 0) => "beside each cell".to_owned(),
        _ => format!("beside each cell, and {AT_LIMITS}"),
    };
    // Limits have as many as cells have.
    let samples = counted(beside_cells.max(at_limits).into(), "plain sample", "plain samples");
    format!("# {samples} {place}, to check that its probability misses no region (sampling.audit)\n")
}

/// Samples at each limit that the job asks for, and at each end of its axis.
fn at_limits(job: &Job) -> u64 {
    if job.limit.is_some() { job.samples_beside_limits() } else { 0 }
}

/// Everything by name.
fn as_json(job: &Job, threads: usize, cost: &Cost) -> Value {
    let bounds = cost.time.as_ref().ok().and_then(|time| time.prediction().bounds());
    json!({
        "name": job.name,
        "job": job.normalised(),
        "cells": job.cells(),
        "samples_at_most": u64::try_from(job.total_samples()).unwrap_or(u64::MAX),
        "plain_samples_per_cell": job.plain_samples(),
        "plain_samples_at_limits": at_limits(job),
        "threads": threads,
        "seconds": cost.time.as_ref().ok().filter(|_| bounds.is_some()).map(|time| time.seconds),
        "seconds_low": bounds.map(|[low, _]| low),
        "seconds_high": bounds.map(|[_, high]| high),
        "seconds_of_set_up": cost.time.as_ref().ok().map(|_| cost.set_up),
        "not_known_because": cost.time.as_ref().err(),
        "seconds_of_a_sample": cost.of_a_sample.map(|[seconds, _]| seconds),
        "relative_error": cost.of_a_sample.map(|[_, error]| error),
    })
}

/// How many values each axis has, slowest first.
fn axes(job: &Job) -> String {
    let mut axes: Vec<String> = job
        .grid
        .axes
        .iter()
        .map(|axis| {
            let (quantity, length) = (job.quantity(axis.quantity), axis.axis.values().len());
            let name = short_name(quantity);
            if quantity.is_always_shown {
                counted(length as u128, name, &format!("{name}s"))
            } else {
                format!("{length} {name}")
            }
        })
        .collect();
    let stds = counted(job.grid.scatters as u128, "standard deviation", "standard deviations");
    axes.insert(job.grid.slower_than_scatter, stds);
    axes.join(" x ")
}

/// What varies along an axis.
fn short_name(quantity: &Quantity) -> &str {
    match (quantity.is_always_shown, quantity.role) {
        (true, Role::Input) => quantity.noun(),
        (true, _) => &quantity.label,
        (false, _) => &quantity.name,
    }
}
