//! Among how many processes a job is shared, by what it costs.

use std::time::Instant;

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::parts::Parts;
use crate::failure::Failure;
use crate::job::Job;
use crate::schedule::engine::Engine;
use crate::schedule::plan::Plan;
use crate::schedule::trial::SampleTrial;
use crate::store::tally::Tally;

/// Seconds that looking up a sample in a verdict map takes, about.
const LOOK_UP: f64 = 1e-7;

/// Work that can be shared.
#[derive(Debug, Clone, Copy)]
pub struct WorkToShare {
    /// What it takes on one thread.
    pub seconds: f64,
    /// In how many units it comes, of which a thread computes one at a time.
    pub units: u64,
}

/// Refuses a job without samples, for an option that shares them.
///
/// # Errors
/// What to do in place of it.
pub fn require_samples_to_share(job: &Job, option: &str) -> Result<(), Failure> {
    if job.draws_samples() {
        return Ok(());
    }
    let asked = job.sampling.method.asked();
    Err(Failure::Usage(format!(
        "{option}: {asked} draws no samples to share; one process computes it, without this option"
    )))
}

/// The units of work in which the missing samples of a job come; where a cell stops by its precision, its cells.
pub fn units_of_work(job: &Job, tally: &Tally) -> u64 {
    let parts = Parts::new(job);
    if parts.are_sequential() {
        return job.cells() - parts.complete_cells(tally);
    }
    Plan::new(tally, &parts, job.unit_samples(), None).units()
}

/// What the missing samples of a job cost, measured on some of them.
pub fn cost_of_samples(job: &Job, tally: &Tally, engine: &Engine) -> Result<WorkToShare, Failure> {
    let trial = engine.try_samples(&Evaluator::new(job)?, Instant::now())?;
    let missing = (job.total_samples() - tally.counted()) as f64;
    let simulated = seconds_of(&trial, job, missing);
    let seconds = match job.uses_maps() {
        false => simulated,
        // Those that are looked up cost little, unless the map is given up.
        true => simulated.min(job.audited_samples() as f64 * trial.cost + missing * LOOK_UP),
    };
    Ok(WorkToShare { seconds, units: units_of_work(job, tally) })
}

/// The time of the missing samples on one thread, each simulated.
fn seconds_of(trial: &SampleTrial, job: &Job, missing: f64) -> f64 {
    match trial.until_stop {
        None => missing * trial.cost,
        Some(until) => missing / job.sampling.samples as f64 * until.samples_by_cost * trial.cost,
    }
}

/// What the verdict maps of a job cost, measured on some of their tiles.
pub fn cost_of_maps(job: &Job, engine: &Engine) -> Result<WorkToShare, Failure> {
    let mut evaluator = Evaluator::new(job)?;
    engine.limit_maps(&mut evaluator)?;
    let trial = engine.try_maps(&evaluator, Instant::now())?;
    let tiles = evaluator.maps().needed() as u64;
    Ok(WorkToShare { seconds: trial.seconds * tiles as f64 / trial.tiles.max(1) as f64, units: tiles })
}
