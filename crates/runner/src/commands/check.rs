//! `check`: what a job is and what it will cost.

use std::time::{Duration, Instant};

use indicatif::{HumanCount, HumanDuration};

use crate::cli::CheckArguments;
use crate::failure::Failure;
use crate::job::{Job, JobSource};
use crate::output::result;
use crate::run::Engine;

/// How long the cost of a sample is measured.
const TRIAL: Duration = Duration::from_millis(30);

/// `stickslip check`.
pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let job = JobSource::read(&arguments.job)?.job()?;
    let threads = arguments.threads.count();
    let rate = samples_per_second(&job)?;
    let seconds = job.total_samples() as f64 / rate / threads as f64;
    let lengths = job.grid.lengths();
    let cost = if seconds < 1.0 {
        format!("{seconds:.2} seconds")
    } else {
        HumanDuration(Duration::from_secs_f64(seconds.min(1e15))).to_string()
    };
    result(&format!(
        "{}\n# {} is valid.\n# {} cells: {} rotating speeds x {} standard deviations x {} preloads x {} static friction coefficients\n# {} samples, about {cost} on {threads} threads ({} samples/s on one, measured now)\n",
        job.normalised(),
        arguments.job.display(),
        HumanCount(job.cells()),
        lengths[0],
        lengths[1],
        lengths[2],
        lengths[3],
        job.total_samples(),
        HumanCount(rate as u64),
    ))
}

/// The rate of one thread, from samples of the job itself.
fn samples_per_second(job: &Job) -> Result<f64, Failure> {
    let engine = Engine::new(job, 1)?;
    let started = Instant::now();
    // A hundredth of a unit: the costlier the samples, the fewer at once.
    let trial = job.unit_samples() / 100;
    let (mut samples, mut cell) = (0, 0);
    while started.elapsed() < TRIAL {
        samples += engine.compute(cell, 0..job.samples.min(trial)).len();
        // A stride that visits cells all over the grid.
        cell = (cell + 7919) % job.cells();
    }
    Ok(samples as f64 / started.elapsed().as_secs_f64())
}
