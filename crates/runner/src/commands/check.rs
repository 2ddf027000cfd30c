//! `check`: validates a job and estimates its cost.

use std::time::{Duration, Instant};

use indicatif::{HumanCount, HumanDuration};

use crate::cli::CheckArguments;
use crate::evaluate::evaluator::Evaluator;
use crate::failure::Failure;
use crate::job::{Job, JobSource};
use crate::output::{counted, result, warn};

/// Longest time for measuring the cost of a sample.
const TRIAL: Duration = Duration::from_millis(600);

/// Number of evaluations from which the cost is known well enough.
const TRIAL_EVALUATIONS: u32 = 16;

/// Number of samples in the first evaluation.
const FIRST_TRIAL_SAMPLES: u64 = 10;

/// Samples at once that fill vector registers.
const ENOUGH_TRIAL_SAMPLES: u64 = 320;

/// Time for measuring the cost of tiles of verdict maps.
const TRIAL_OF_MAPS: Duration = Duration::from_secs(1);

/// `stickslip check`.
pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let source = JobSource::read(&arguments.job)?;
    let job = source.job()?;
    warn(job.warnings());
    let threads = arguments.threads.count();
    let lengths = job.grid.lengths();
    let usual = lengths.len() - 4;
    let further: String =
        job.grid.further().zip(&lengths).map(|(further, length)| format!("{length} {} x ", further.name)).collect();
    let work = match (job.uses_maps(), job.is_integrated()) {
        (true, _) => cost_of_maps(&job, threads)?,
        (false, true) => "# no samples: the boundary is known in closed form\n".to_owned(),
        (false, false) => cost_of_samples(&job, samples_per_second(&job)?, threads),
    };
    result(&format!(
        "{}\n# {} is valid.\n# {}: {further}{} x {} x {} x {}\n{work}",
        job.normalised(),
        source.path.display(),
        counted(job.cells().into(), "cell", "cells"),
        counted(lengths[usual].into(), "rotating speed", "rotating speeds"),
        counted(lengths[usual + 1].into(), "standard deviation", "standard deviations"),
        counted(lengths[usual + 2].into(), "preload", "preloads"),
        counted(lengths[usual + 3].into(), "static friction coefficient", "static friction coefficients"),
    ))
}

/// The cost of samples that are decided one by one.
fn cost_of_samples(job: &Job, rate: f64, threads: usize) -> String {
    let cost = duration(job.total_samples() as f64 / rate / threads as f64);
    let at_most = if job.stops_by_precision() { "at most " } else { "" };
    format!(
        "# {at_most}{}, {at_most}about {cost} on {} ({} samples/s on one, measured now)\n",
        counted(job.total_samples(), "sample", "samples"),
        counted(threads as u128, "thread", "threads"),
        HumanCount(rate as u64),
    )
}

/// The cost of verdict maps, estimated from some of their tiles, and whether a run will use them.
fn cost_of_maps(job: &Job, threads: usize) -> Result<String, Failure> {
    let mut evaluator = Evaluator::new(job)?;
    evaluator.limit_maps();
    let tiles = evaluator.maps().needed() as u64;
    let trial = evaluator.try_maps(TRIAL_OF_MAPS);
    let share = tiles as f64 / trial.tiles.max(1) as f64;
    let [simulations, cost] = [trial.simulations, trial.cost].map(|count| (count as f64 * share) as u64);
    // A dropped tile counts with the cost until then.
    let (about, unfinished) = match trial.unfinished {
        0 => ("about", String::new()),
        unfinished => ("at least", format!(", {} of which took too long to finish", HumanCount(unfinished))),
    };
    let map = format!(
        "{about} {} for the verdict map of {} (measured on {} of them{unfinished}), {about} {} on {}",
        counted(simulations.into(), "simulation", "simulations"),
        counted(tiles.into(), "tile", "tiles"),
        HumanCount(trial.tiles),
        duration(trial.seconds * share / threads as f64),
        counted(threads as u128, "thread", "threads"),
    );
    let audit = counted(job.audited_samples(), "simulation", "simulations");
    if job.is_integrated() {
        return Ok(format!("# no samples; {map}\n# {audit} for its audit\n"));
    }
    let is_given_up = evaluator.maps().are_too_costly(cost);
    let what_it_does = match (is_given_up, trial.unfinished) {
        (true, _) => "the map takes more: it will be given up and each sample simulated",
        (false, 0) => "the map takes fewer: samples will be looked up in it",
        (false, _) => {
            "the map may take fewer: samples will be looked up in it, unless it turns out to take more and is given up"
        }
    };
    // Simulations of a map lie near boundaries and may be slower than those of samples.
    let rate = samples_per_second(job)?;
    let is_faster = !is_given_up && job.verdicts_of_samples() as f64 / rate < trial.seconds * share;
    let hint = if is_faster { "; but evaluate = \"each\" takes less time for this job" } else { "" };
    Ok(format!(
        "# {map}\n# {audit} for its audit\n{}# simulating each sample takes {}; {what_it_does}{hint}\n",
        cost_of_samples(job, rate, threads),
        counted(job.verdicts_of_samples(), "simulation", "simulations"),
    ))
}

/// A time in words.
fn duration(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{seconds:.2} seconds")
    } else {
        HumanDuration(Duration::from_secs_f64(seconds.min(1e15))).to_string()
    }
}

/// Samples per second on one thread, measured on samples of the job.
fn samples_per_second(job: &Job) -> Result<f64, Failure> {
    let evaluator = Evaluator::new(job)?;
    let parts = evaluator.parts();
    let most = parts.max_samples(0).min(job.unit_samples());
    // Some criteria compute tables when they are first used, which a whole run does once.
    evaluator.count(parts.of(0).start, 0..FIRST_TRIAL_SAMPLES.min(most));
    let started = Instant::now();
    let (mut samples, mut seconds, mut evaluations) = (0, 0.0, 0);
    let (mut cell, mut at_once) = (0, FIRST_TRIAL_SAMPLES.min(most));
    while evaluations == 0 || (evaluations < TRIAL_EVALUATIONS && started.elapsed() < TRIAL) {
        let begun = Instant::now();
        let evaluated = evaluator.count(parts.of(cell).start, 0..at_once).len();
        let took = begun.elapsed();
        // A stride that visits cells all over the grid.
        cell = (cell + 7919) % job.cells();
        // A few samples at once take longer each than those of a whole unit, as simulations share vector registers.
        let is_few = at_once < ENOUGH_TRIAL_SAMPLES && started.elapsed() < TRIAL;
        if (took < TRIAL / 4 || is_few) && at_once < most {
            at_once = most.min(2 * at_once);
        } else {
            samples += evaluated;
            seconds += took.as_secs_f64();
            evaluations += 1;
        }
    }
    Ok(samples as f64 / seconds)
}
