//! Trials: the cost of a job, measured on some of its samples and tiles, before it runs.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use stickslip_core::verdict::VerdictCounts;
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::tiles::{MapTrial, cost_of};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::schedule::engine::{Engine, Event, Link};
use crate::schedule::spread::Spread;
use crate::schedule::time_left::{Mean, Prediction};

/// Shortest and longest time of a trial.
const SHORTEST: Duration = Duration::from_millis(600);
const LONGEST: Duration = Duration::from_secs(3);

/// A trial ends when the relative standard error of the mean cost is this small.
const ENOUGH: f64 = 0.07;

/// Fewest batches from which the error of their mean is known.
const LEAST_BATCHES: u64 = 12;

/// The relative error if there are fewer.
const FROM_FEW: f64 = 1.0;

/// Time that a batch of samples should take: short, so that there are many from all over the job, but long enough for
/// the vector lanes to be busy.
const BATCH: Duration = Duration::from_millis(25);

/// Fewest samples of a cell that show when it stops.
const LEAST_FOR_STOP: u64 = 16;

/// Multiples of it are spread evenly.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// What a trial of samples found.
#[derive(Debug, Clone, Copy)]
pub struct SampleTrial {
    /// Seconds for one sample on one thread, while all threads are at work.
    pub cost: f64,
    /// The relative standard error of the cost.
    pub error: f64,
    /// With looks: how many samples a cell is expected to have, weighted with their cost; `None` if that is not known.
    pub samples_at_stop: Option<f64>,
    /// The relative standard error of the cost of a cell with looks.
    pub error_at_stop: f64,
}

/// Some samples of a trial.
struct Batch {
    seconds: f64,
    counts: VerdictCounts,
}

impl Engine {
    /// Measures the cost of samples from all over a job.
    pub fn try_samples(&self, evaluator: &Evaluator<'_>) -> Result<SampleTrial, Failure> {
        let parts = evaluator.parts();
        let of_a_cell = if parts.are_sequential() { 1 } else { parts.of_a_cell() as u64 };
        let most = parts.max_samples(0).min(evaluator.job().unit_samples()).max(1);
        let order = Spread::over(parts.cells() * of_a_cell);
        let batch = |turn: u64, samples: u64| {
            let place = order.at(turn % (parts.cells() * of_a_cell)).unwrap_or(0);
            let part = parts.of(place / of_a_cell).start + place % of_a_cell;
            // Samples from anywhere in the part. Those of common random numbers are the same in all cells.
            let first = ((turn as f64 * GOLDEN_SECTION).fract() * (most - samples + 1) as f64) as u64;
            let begun = Instant::now();
            let unit = evaluator.count(part, first..first + samples);
            Batch { seconds: begun.elapsed().as_secs_f64(), counts: unit.counts }
        };
        // Some criteria compute tables when they are first used, which a whole run does once.
        batch(0, 1);
        let samples = samples_of_a_batch(&batch, most);
        let started = Instant::now();
        let is_enough = AtomicBool::new(false);
        let looks = parts.looks().filter(|_| samples >= LEAST_FOR_STOP);
        let (mut costs, mut costs_to_stop) = (Mean::default(), Mean::default());
        let turn = AtomicU64::new(0);
        let work = |link: &Link<'_, Batch>| {
            while !is_enough.load(Ordering::Relaxed) && started.elapsed() < LONGEST {
                link.send(batch(turn.fetch_add(1, Ordering::Relaxed), samples));
            }
        };
        self.on_every_thread(0, &Interrupt::unwatched(), work, |event| {
            let Event::Finished(batch) = event else { return Ok(()) };
            costs.add(batch.seconds);
            if let Some(looks) = looks {
                // Cells whose samples cost more may stop earlier or later.
                let of_sample = batch.seconds / samples as f64;
                costs_to_stop.add(of_sample * looks.expected_end(0, &batch.counts) as f64);
            }
            let is_certain = costs.count() >= LEAST_BATCHES && costs.relative_error() <= ENOUGH;
            if is_certain && started.elapsed() >= SHORTEST {
                is_enough.store(true, Ordering::Relaxed);
            }
            Ok(())
        })?;
        let error = |costs: &Mean| if costs.count() < LEAST_BATCHES { FROM_FEW } else { costs.relative_error() };
        let mean = |costs: &Mean| costs.sum() / costs.count().max(1) as f64;
        let cost = mean(&costs) / samples as f64;
        Ok(SampleTrial {
            cost,
            error: error(&costs),
            samples_at_stop: looks.map(|_| mean(&costs_to_stop) / cost),
            error_at_stop: error(&costs_to_stop),
        })
    }

    /// Resolves some of the missing tiles, evenly spread, to estimate the cost of all. Tiles that take too long are
    /// dropped.
    pub fn try_maps(&self, evaluator: &Evaluator<'_>) -> Result<MapTrial, Failure> {
        let missing = evaluator.maps().missing();
        let started = Instant::now();
        let is_enough = AtomicBool::new(false);
        let work = |turn: u64| {
            let is_over = || is_enough.load(Ordering::Relaxed) || started.elapsed() >= LONGEST;
            if is_over() {
                return None;
            }
            let (speed, index) = missing[turn as usize];
            let begun = Instant::now();
            let (simulations, cost) = (AtomicU64::new(0), AtomicU64::new(0));
            let tile = evaluator.resolve(speed, index, |decisions| {
                simulations.fetch_add(decisions.len() as u64, Ordering::Relaxed);
                cost.fetch_add(cost_of(decisions), Ordering::Relaxed);
                started.elapsed() < LONGEST
            });
            Some((simulations.into_inner(), cost.into_inner(), begun.elapsed().as_secs_f64(), tile.is_some()))
        };
        let mut trial = MapTrial::default();
        let mut costs = Mean::default();
        self.for_each_in_parallel(missing.len() as u64, &Interrupt::unwatched(), work, |result| {
            let Some((simulations, cost, seconds, is_finished)) = result else { return };
            trial.tiles += 1;
            trial.unfinished += u64::from(!is_finished);
            trial.simulations += simulations;
            trial.cost += cost;
            trial.seconds += seconds;
            costs.add(seconds);
            let is_certain = costs.count() >= LEAST_BATCHES && costs.relative_error() <= ENOUGH;
            if is_certain && started.elapsed() >= SHORTEST {
                is_enough.store(true, Ordering::Relaxed);
            }
        })?;
        trial.error = match costs.count() {
            tiles if tiles == missing.len() as u64 => 0.0,
            tiles if tiles < LEAST_BATCHES => FROM_FEW,
            _ => costs.relative_error(),
        };
        Ok(trial)
    }
}

/// How many samples take the time of a batch.
fn samples_of_a_batch(batch: &impl Fn(u64, u64) -> Batch, most: u64) -> u64 {
    let mut samples = 1;
    let started = Instant::now();
    for turn in 0.. {
        let tried = batch(turn, samples);
        let affordable = samples as f64 * BATCH.as_secs_f64() / tried.seconds.max(1e-9);
        let next = most.min(affordable.min(4.0 * samples as f64) as u64).max(1);
        if next <= samples || started.elapsed() >= SHORTEST {
            break;
        }
        samples = next;
    }
    // Whole blocks are drawn fastest.
    if samples > BLOCK_SAMPLES { samples - samples % BLOCK_SAMPLES } else { samples }
}

impl SampleTrial {
    /// How long samples take on all threads, if a thread computes up to `unit` of them one after the other.
    pub fn time(&self, samples: f64, unit: u64, threads: usize) -> Prediction {
        let seconds = samples * self.cost / threads as f64;
        Prediction::from_rate(seconds.max(samples.min(unit as f64) * self.cost), self.error)
    }
}
