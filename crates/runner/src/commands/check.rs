//! `check`: validates a job and estimates its cost.

use std::time::Instant;

use indicatif::HumanCount;
use serde_json::{Value, json};
use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;

use super::named_job::read_job;
use crate::cli::CheckArguments;
use crate::evaluate::evaluator::Evaluator;
use crate::failure::Failure;
use crate::job::Job;
use crate::output::{counted, rate, result, shown, warn};
use crate::schedule::engine::Engine;
use crate::schedule::time_left::Prediction;
use crate::schedule::trial::{SampleTrial, UntilStop};

/// The measured cost of a job.
struct Cost {
    /// What it is, as comments.
    text: String,
    /// Seconds that a sample takes on one thread, and the relative standard error; `None` if no samples are drawn.
    of_a_sample: Option<[f64; 2]>,
}

/// `stickslip check`.
pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let begun = Instant::now();
    let source = read_job(&arguments.job)?;
    let job = source.job()?;
    warn(job.warnings());
    let threads = arguments.threads.count();
    let engine = Engine::new(threads)?;
    let evaluator = Evaluator::new(&job)?;
    let cost = match (job.uses_maps(), job.draws_samples()) {
        (true, _) => cost_of_maps(&evaluator, &engine, threads, begun)?,
        (false, false) => {
            let how = match job.integrated() {
                Some(place) => format!("critical values of {} are found instead", job.quantity(place).name),
                None => "the boundary is known in closed form".to_owned(),
            };
            let text = format!("# no samples: {how}\n");
            Cost { text, of_a_sample: None }
        }
        (false, true) => {
            let trial = engine.try_samples(&evaluator, begun)?;
            Cost { text: cost_of_samples(&job, &trial, threads), of_a_sample: Some([trial.cost, trial.error]) }
        }
    };
    if arguments.json {
        return result(&format!("{:#}\n", as_json(&job, threads, &cost)));
    }
    let all = match arguments.all {
        true => format!("\n{}", job.normalised()),
        false => "# --all shows every key with its value, defaults too\n".to_owned(),
    };
    result(&format!(
        "# {} is valid.\n# {}: {}\n{}{}{all}",
        shown(&source.path),
        counted(job.cells().into(), "cell", "cells"),
        axes(&job),
        job.model.remarks(&job.grid),
        cost.text,
    ))
}

/// Everything by name.
fn as_json(job: &Job, threads: usize, cost: &Cost) -> Value {
    json!({
        "name": job.name,
        "job": job.normalised(),
        "cells": job.cells(),
        "samples_at_most": u64::try_from(job.total_samples()).unwrap_or(u64::MAX),
        "threads": threads,
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

/// The cost of samples that are decided one by one.
fn cost_of_samples(job: &Job, trial: &SampleTrial, threads: usize) -> String {
    let on = counted(threads as u128, "thread", "threads");
    let rate = rate(1.0 / trial.cost.max(1e-12));
    let measured = match trial.unfinished {
        None => format!("on {on} ({rate} samples/s on one, measured now)"),
        Some(after) => {
            let what = if job.answer().is_of_rare_events() { "population" } else { "sample" };
            format!("on {on}, and much more: no {what} was finished in {:.1} seconds of measuring", after.as_secs_f64())
        }
    };
    let unit = job.unit_samples().min(job.sampling.samples);
    let total = counted(job.total_samples(), "sample", "samples");
    let time = |samples: f64, error: f64| SampleTrial { error, ..*trial }.time(samples, unit, threads);
    match trial.until_stop {
        None => format!("# {total}, {} {measured}\n", time(job.total_samples() as f64, trial.error)),
        Some(UntilStop { samples, samples_by_cost, error }) => {
            let cells = job.cells() as f64;
            format!(
                "# at most {total}, about {} expected, {} {measured}\n",
                HumanCount((samples * cells) as u64),
                time(samples_by_cost * cells, error)
            )
        }
    }
}

/// The cost of verdict maps, estimated from some of their tiles, and whether the samples cost less.
fn cost_of_maps(evaluator: &Evaluator<'_>, engine: &Engine, threads: usize, begun: Instant) -> Result<Cost, Failure> {
    let job = evaluator.job();
    let tiles = evaluator.maps().needed() as u64;
    let trial = engine.try_maps(evaluator, begun)?;
    let share = tiles as f64 / trial.tiles.max(1) as f64;
    let simulations = (trial.simulations as f64 * share) as u64;
    let seconds = trial.seconds * share / threads as f64;
    let map_time = Prediction::from_rate(seconds, trial.error);
    // A dropped tile counts with the cost until then.
    let (map_time, about, unfinished) = match trial.unfinished {
        0 => (map_time, "about", String::new()),
        unfinished => {
            let more =
                if 2 * unfinished > trial.tiles { ", so that the whole may take many times as long" } else { "" };
            let unfinished = HumanCount(unfinished);
            (map_time.at_least(), "at least", format!(", {unfinished} of which took too long to finish{more}"))
        }
    };
    let map = format!(
        "{about} {} for the verdict map of {} (measured on {} of them{unfinished}), {map_time} on {}",
        counted(simulations.into(), "simulation", "simulations"),
        counted(tiles.into(), "tile", "tiles"),
        HumanCount(trial.tiles),
        counted(threads as u128, "thread", "threads"),
    );
    let samples = engine.try_samples(&Evaluator::new(job)?, begun)?;
    let audit_samples = job.audited_samples();
    let audit_time = samples.time(audit_samples as f64, BLOCK_SAMPLES, threads);
    let audit = format!("{} for its audit, {audit_time}", counted(audit_samples, "simulation", "simulations"));
    if !job.draws_samples() {
        let text = format!("# no samples; {map}\n# {audit}\n");
        return Ok(Cost { text, of_a_sample: None });
    }
    let each = cost_of_samples(job, &samples, threads);
    // Simulations of a map lie near boundaries and may be slower than those of samples.
    let seconds_of = |simulations: u128| simulations as f64 * samples.cost / threads as f64;
    let hint = if seconds_of(job.verdicts_of_samples()) < seconds + seconds_of(audit_samples) {
        "# evaluate = \"each\" takes less time for this job\n"
    } else {
        ""
    };
    let text = format!("# {map}\n# {audit}\n# if each is simulated: {}{hint}", each.trim_start_matches("# "));
    Ok(Cost { text, of_a_sample: Some([samples.cost, samples.error.max(trial.error)]) })
}
