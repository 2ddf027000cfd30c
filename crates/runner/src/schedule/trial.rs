//! Trials: the cost of a job, measured on some of its samples and tiles, before it runs.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use stickslip_core::model::verdict::VerdictCounts;
use stickslip_sampler::draw::identity::BLOCK_SAMPLES;

use stickslip_core::model::IsStopped;

use crate::evaluate::control::Control;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::rare_events::searches_per_sample;
use crate::evaluate::tiles::MapTrial;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Answer;
use crate::schedule::engine::{Engine, Event, Link};
use crate::schedule::spread::Spread;
use crate::schedule::time_left::{Mean, Prediction, RateMeter};

/// Shortest and longest time of a trial, and when the last one ends after a command began.
const SHORTEST: Duration = Duration::from_millis(600);
const LONGEST: Duration = Duration::from_millis(2500);
const LAST: Duration = Duration::from_millis(3800);

/// Samples of rare events that are tried where they are placed.
const PLACED_SAMPLES: u64 = 200;

/// A trial ends when the relative standard error of the mean cost is this small.
const ENOUGH: f64 = 0.07;

/// Fewest batches from which the error of their mean is known.
const LEAST_BATCHES: u64 = 12;

/// The relative error if there are fewer.
const FROM_FEW: f64 = 1.0;

/// Time that a batch of samples should take: short, so that there are many from all over the job, but long enough for
/// the vector lanes to be busy.
const BATCH: Duration = Duration::from_millis(25);

/// Samples of a cell in a stream that is tried.
const STREAM_SAMPLES: u64 = 16;

/// Share of the time of such a trial after which all lanes are busy.
const FILLED: f64 = 0.3;

/// Fewest samples of a cell that show when it stops.
const LEAST_FOR_STOP: u64 = 16;

/// Multiples of it are spread evenly.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// What a trial of samples found.
#[derive(Debug, Clone, Copy, Default)]
pub struct SampleTrial {
    /// Seconds for one sample on one thread, while all threads are at work.
    pub cost: f64,
    /// The relative standard error of the cost.
    pub error: f64,
    /// What is expected of the cells of a job with looks.
    pub until_stop: Option<UntilStop>,
    /// After which time no sample was finished, if none was: then the cost is the least that it can be.
    pub unfinished: Option<Duration>,
}

/// What is expected of the cells of a job with looks.
#[derive(Debug, Clone, Copy)]
pub struct UntilStop {
    /// Samples of a cell when it stops.
    pub samples: f64,
    /// The same, weighted with the costs of the cells' samples.
    pub samples_by_cost: f64,
    /// The relative standard error of the cost of a cell.
    pub error: f64,
}

/// Some samples of a trial.
struct Batch {
    seconds: f64,
    counts: VerdictCounts,
}

impl Engine {
    /// Measures the cost of samples from all over a job, for a command that began then.
    pub fn try_samples(&self, evaluator: &Evaluator<'_>, begun: Instant) -> Result<SampleTrial, Failure> {
        let places = Places::new(evaluator);
        let until = end_of_trial(begun);
        if evaluator.job().answer() == Answer::Weight {
            return Ok(places.try_placed(evaluator, until));
        }
        // Some criteria compute tables when they are first used, which a whole run does once.
        let started = Instant::now();
        let first = places.count(evaluator, 0, 1, &|| Instant::now() >= until);
        let took = started.elapsed();
        if first.is_none() {
            return Ok(SampleTrial { cost: took.as_secs_f64(), unfinished: Some(took), ..SampleTrial::default() });
        }
        if Instant::now() >= until {
            return Ok(SampleTrial { cost: took.as_secs_f64(), error: FROM_FEW, ..SampleTrial::default() });
        }
        let is_simulated = evaluator.job().model().simulation().is_some();
        let mut trial = SampleTrial::default();
        if !is_simulated || evaluator.parts().looks().is_some() {
            // A stream that follows has the other half of the time.
            let until_stream = Instant::now() + (until - Instant::now()) / 2;
            trial = self.try_batches(evaluator, &places, if is_simulated { until_stream } else { until })?;
            if trial.cost == 0.0 {
                trial.cost = took.as_secs_f64();
            }
        }
        if is_simulated {
            // Simulations of different cells share the lanes, so that batches by themselves take longer.
            let (cost, error) = self.try_stream(evaluator, &places, until)?;
            if cost > 0.0 {
                (trial.cost, trial.error) = (cost, error);
            } else if trial.cost == 0.0 {
                (trial.cost, trial.error) = (took.as_secs_f64(), FROM_FEW);
            }
        }
        Ok(trial)
    }

    /// The cost of samples in batches, each evaluated by itself.
    fn try_batches(&self, evaluator: &Evaluator<'_>, places: &Places, until: Instant) -> Result<SampleTrial, Failure> {
        let looks = evaluator.parts().looks();
        let least = if looks.is_some() { LEAST_FOR_STOP.min(places.most) } else { 1 };
        let is_late = || Instant::now() >= until;
        let samples = places.samples_of_a_batch(evaluator, &is_late).max(least);
        let started = Instant::now();
        let is_enough = AtomicBool::new(false);
        let turn = AtomicU64::new(0);
        let work = |link: &Link<'_, Batch>| {
            while !is_enough.load(Ordering::Relaxed) && !is_late() {
                let batch = places.count(evaluator, turn.fetch_add(1, Ordering::Relaxed), samples, &is_late);
                batch.into_iter().for_each(|batch| link.send(batch));
            }
        };
        let (mut costs, mut ends, mut costs_to_stop) = (Mean::default(), Mean::default(), Mean::default());
        self.on_every_thread(0, &Interrupt::unwatched(), work, |event| {
            let Event::Finished(batch) = event else { return Ok(()) };
            costs.add(batch.seconds);
            if let Some(looks) = looks {
                // Cells whose samples cost more may stop earlier or later.
                let end = looks.expected_end(0, &batch.counts) as f64;
                ends.add(end);
                costs_to_stop.add(batch.seconds / samples as f64 * end);
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
        let until_stop = looks.filter(|_| cost > 0.0).map(|_| UntilStop {
            samples: mean(&ends),
            samples_by_cost: mean(&costs_to_stop) / cost,
            error: error(&costs_to_stop),
        });
        Ok(SampleTrial { cost, error: error(&costs), until_stop, unfinished: None })
    }

    /// The cost of a sample in a stream of samples from all over the job, and its relative standard error.
    fn try_stream(&self, evaluator: &Evaluator<'_>, places: &Places, until: Instant) -> Result<(f64, f64), Failure> {
        let started = Instant::now();
        let is_enough = AtomicBool::new(false);
        let is_over = || is_enough.load(Ordering::Relaxed) || Instant::now() >= until;
        let turn = AtomicU64::new(0);
        let samples = places.most.min(STREAM_SAMPLES);
        let work = |link: &Link<'_, u64>| {
            let next = || (!is_over()).then(|| places.at(evaluator, turn.fetch_add(1, Ordering::Relaxed), samples));
            let control = || if is_over() { Control::Stop } else { Control::Continue };
            evaluator.work(&next, &mut |unit| link.send(unit.len()), &control);
        };
        let mut meter = RateMeter::new();
        let mut record: Vec<(f64, u64)> = vec![(0.0, 0)];
        self.on_every_thread(0, &Interrupt::unwatched(), work, |event| {
            // What is finished after the end were the shorter motions.
            if is_over() {
                return Ok(());
            }
            let (seconds, done) = (started.elapsed().as_secs_f64(), record[record.len() - 1].1);
            let done = if let Event::Finished(samples) = event { done + samples } else { done };
            record.push((seconds, done));
            meter.record(seconds, done as f64);
            if seconds >= SHORTEST.as_secs_f64() && meter.relative_error().is_some_and(|error| error <= ENOUGH) {
                is_enough.store(true, Ordering::Relaxed);
            }
            Ok(())
        })?;
        // At first no motion ends, while the lanes are being filled.
        let (end, done) = record[record.len() - 1];
        let (begin, before) = record[record.partition_point(|&(seconds, _)| seconds < FILLED * end)];
        let cost = (end - begin) * self.threads() as f64 / (done - before).max(1) as f64;
        let error = meter.relative_error().filter(|error| error.is_finite()).unwrap_or(FROM_FEW);
        Ok((cost, error))
    }

    /// Resolves some of the missing tiles, evenly spread, to estimate the cost of all. Tiles that take too long are
    /// dropped.
    pub fn try_maps(&self, evaluator: &Evaluator<'_>, begun: Instant) -> Result<MapTrial, Failure> {
        let missing = evaluator.maps().missing();
        // Samples are tried after them.
        let until = end_of_trial(begun) - SHORTEST;
        let started = Instant::now();
        let is_enough = AtomicBool::new(false);
        let is_over = || Instant::now() >= until;
        let work = |turn: u64, _: IsStopped<'_>| {
            if is_enough.load(Ordering::Relaxed) || is_over() {
                return None;
            }
            let (configuration, index) = missing[turn as usize];
            let begun = Instant::now();
            let simulations = AtomicU64::new(0);
            let count = |made| {
                simulations.fetch_add(made, Ordering::Relaxed);
            };
            let tile = evaluator.resolve(configuration, index, count, &is_over);
            Some((simulations.into_inner(), begun.elapsed().as_secs_f64(), tile.is_some()))
        };
        let mut trial = MapTrial::default();
        let mut costs = Mean::default();
        self.for_each_in_parallel(missing.len() as u64, &Interrupt::unwatched(), work, |result| {
            let Some((simulations, seconds, is_finished)) = result else { return };
            trial.tiles += 1;
            trial.unfinished += u64::from(!is_finished);
            trial.simulations += simulations;
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

/// When a trial ends that starts now.
fn end_of_trial(begun: Instant) -> Instant {
    let now = Instant::now();
    (now + LONGEST).min(begun + LAST).max(now + SHORTEST)
}

/// The samples of a trial: some of each of many parts, from all over the job.
struct Places {
    order: Spread,
    parts: u64,
    /// The number of parts of a cell that are tried: with looks, those up to the first.
    of_a_cell: u64,
    /// Largest number of samples of a part at once.
    most: u64,
}

impl Places {
    fn new(evaluator: &Evaluator<'_>) -> Self {
        let parts = evaluator.parts();
        let of_a_cell = if parts.are_sequential() { 1 } else { parts.of_a_cell() as u64 };
        let count = parts.cells() * of_a_cell;
        let most = parts.max_samples(0).min(evaluator.job().unit_samples()).max(1);
        Self { order: Spread::over(count), parts: count, of_a_cell, most }
    }

    /// The samples of one turn: their part and range.
    fn at(&self, evaluator: &Evaluator<'_>, turn: u64, samples: u64) -> (u64, Range<u64>) {
        let place = self.order.at(turn % self.parts).unwrap_or(0);
        let part = evaluator.parts().in_cell(place / self.of_a_cell).start + place % self.of_a_cell;
        // Samples from anywhere in the part. Those of common random numbers are the same in all cells.
        let first = ((turn as f64 * GOLDEN_SECTION).fract() * (self.most - samples + 1) as f64) as u64;
        (part, first..first + samples)
    }

    /// Evaluates the samples of one turn; `None` if it is stopped before.
    fn count(&self, evaluator: &Evaluator<'_>, turn: u64, samples: u64, is_stopped: IsStopped<'_>) -> Option<Batch> {
        let (part, samples) = self.at(evaluator, turn, samples);
        let begun = Instant::now();
        let unit = evaluator.count(part, samples, is_stopped)?;
        Some(Batch { seconds: begun.elapsed().as_secs_f64(), counts: unit.counts })
    }

    /// The cost of samples of rare events with that of the searches for their places, which is that of a search for a
    /// population of a cell.
    fn try_placed(&self, evaluator: &Evaluator<'_>, until: Instant) -> SampleTrial {
        let started = Instant::now();
        let is_late = || Instant::now() >= until;
        let parts = evaluator.parts();
        let timed = |part: u64, samples: Range<u64>| {
            let begun = Instant::now();
            evaluator.count(part, samples, &is_late).map(|_| begun.elapsed().as_secs_f64())
        };
        let cells = Spread::over(parts.cells());
        let (mut searches, mut samples) = (Mean::default(), Mean::default());
        let more = PLACED_SAMPLES.min(self.most - 1);
        for cell in (0..parts.cells()).map_while(|turn| cells.at(turn)).take_while(|_| !is_late()) {
            let part = parts.in_cell(cell).start;
            let Some(search) = timed(part, 0..1) else { break };
            searches.add(search);
            let Some(seconds) = timed(part, 1..1 + more) else { break };
            samples.add(seconds / more.max(1) as f64);
        }
        let mean = |costs: &Mean| costs.sum() / costs.count().max(1) as f64;
        let per_sample = searches_per_sample(evaluator.job());
        if searches.count() == 0 {
            let cost = started.elapsed().as_secs_f64() * per_sample;
            return SampleTrial { cost, unfinished: Some(started.elapsed()), ..SampleTrial::default() };
        }
        let error = if searches.count() < LEAST_BATCHES { FROM_FEW } else { searches.relative_error() };
        let cost = mean(&searches) * per_sample + mean(&samples);
        SampleTrial { cost, error, until_stop: None, unfinished: None }
    }

    /// How many samples take the time of a batch.
    fn samples_of_a_batch(&self, evaluator: &Evaluator<'_>, is_late: IsStopped<'_>) -> u64 {
        let mut samples = 1;
        let started = Instant::now();
        for turn in 0.. {
            // A single sample may cost far more than most.
            let tried = (0..3).filter_map(|i| self.count(evaluator, 3 * turn + i, samples, is_late));
            let tried = tried.map(|batch| batch.seconds);
            let seconds = tried.fold(f64::INFINITY, f64::min);
            let affordable = samples as f64 * BATCH.as_secs_f64() / seconds.max(1e-9);
            let next = self.most.min(affordable.min(4.0 * samples as f64) as u64).max(1);
            if next <= samples || started.elapsed() >= SHORTEST || is_late() {
                break;
            }
            samples = next;
        }
        // Whole blocks are drawn fastest.
        if samples > BLOCK_SAMPLES { samples - samples % BLOCK_SAMPLES } else { samples }
    }
}

impl SampleTrial {
    /// How long samples take on all threads, if a thread computes up to `unit` of them one after the other.
    pub fn time(&self, samples: f64, unit: u64, threads: usize) -> Prediction {
        let seconds = samples * self.cost / threads as f64;
        if self.unfinished.is_some() {
            return Prediction::AtLeast(seconds);
        }
        Prediction::from_rate(seconds.max(samples.min(unit as f64) * self.cost), self.error)
    }
}
