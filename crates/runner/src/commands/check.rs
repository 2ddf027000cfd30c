//! `check`: what a job is and what it will cost.

use std::time::{Duration, Instant};

use indicatif::{HumanCount, HumanDuration};

use crate::cli::CheckArguments;
use crate::failure::Failure;
use crate::job::{Job, JobSource};
use crate::output::result;
use crate::run::{Engine, Slots};

/// How long the cost of a sample is measured.
const TRIAL: Duration = Duration::from_millis(30);

/// `stickslip check`.
pub fn check(arguments: &CheckArguments) -> Result<(), Failure> {
    let job = JobSource::read(&arguments.job)?.job()?;
    job.warn_of_few_modes();
    job.warn_of_validity();
    job.warn_of_missing_scatter();
    let threads = arguments.threads.count();
    let lengths = job.grid.lengths();
    let work =
        if job.is_integrated() || job.uses_maps() { cost_of_maps(&job)? } else { cost_of_samples(&job, threads)? };
    result(&format!(
        "{}\n# {} is valid.\n# {} cells: {} rotating speeds x {} standard deviations x {} preloads x {} static friction coefficients\n{work}",
        job.normalised(),
        arguments.job.display(),
        HumanCount(job.cells()),
        lengths[0],
        lengths[1],
        lengths[2],
        lengths[3],
    ))
}

/// What samples cost that are judged one by one.
fn cost_of_samples(job: &Job, threads: usize) -> Result<String, Failure> {
    let rate = samples_per_second(job)?;
    let seconds = job.total_samples() as f64 / rate / threads as f64;
    let cost = if seconds < 1.0 {
        format!("{seconds:.2} seconds")
    } else {
        HumanDuration(Duration::from_secs_f64(seconds.min(1e15))).to_string()
    };
    let at_most = if job.stops_by_precision() { "at most " } else { "" };
    Ok(format!(
        "# {at_most}{} samples, {at_most}about {cost} on {threads} threads ({} samples/s on one, measured now)\n",
        job.total_samples(),
        HumanCount(rate as u64),
    ))
}

/// What a verdict map costs; how many simulations its boundaries take is only known afterwards.
fn cost_of_maps(job: &Job) -> Result<String, Failure> {
    let tiles = Engine::new(job, 1)?.maps().needed();
    let samples = if job.is_integrated() { "no".to_owned() } else { job.total_samples().to_string() };
    let map = match job.uses_maps() {
        false => "the boundary is known in closed form".to_owned(),
        true => format!(
            "a verdict map of {} tiles: some 40 simulations each, and some hundreds more for each that a boundary crosses",
            HumanCount(tiles as u64)
        ),
    };
    Ok(format!("# {samples} samples, {map}\n"))
}

/// The rate of one thread, from samples of the job itself.
fn samples_per_second(job: &Job) -> Result<f64, Failure> {
    let engine = Engine::new(job, 1)?;
    let started = Instant::now();
    // A hundredth of a unit: the costlier the samples, the fewer at once.
    let trial = job.unit_samples() / 100;
    let slots = Slots::new(job);
    let (mut samples, mut cell) = (0, 0);
    while started.elapsed() < TRIAL {
        samples += engine.compute(slots.of(cell).start, 0..slots.most(0).min(trial)).len();
        // A stride that visits cells all over the grid.
        cell = (cell + 7919) % job.cells();
    }
    Ok(samples as f64 / started.elapsed().as_secs_f64())
}
