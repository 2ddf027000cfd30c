//! Trials: the cost of a job, measured on some of its samples, before it runs.
//!
//! What is set up is measured apart from samples, see [`cost`](crate::schedule::cost). Samples of different cells cost
//! differently, as motions last longer in some, so that those of a trial are from all over the job.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::evaluate::control::Control;
use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::rare_events::{populations, searches_per_sample};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Answer;
use crate::schedule::cost::{ENOUGH, LEAST_BATCHES, Measured, Time, UnitCost, Unmeasured};
use crate::schedule::engine::{Engine, Event, Link};
use crate::schedule::places::{Places, Tried};
use crate::schedule::spread::Spread;
use crate::schedule::time_left::{Mean, RateMeter};

/// Shortest and longest time of a trial, when the last one ends after a command began, and when it does where nothing else
/// was finished.
pub(super) const SHORTEST: Duration = Duration::from_millis(200);
const LONGEST: Duration = Duration::from_millis(2500);
const LAST: Duration = Duration::from_millis(3800);
const LAST_OF_ALL: Duration = Duration::from_millis(6500);

/// Samples of rare events that are tried where they are placed.
const PLACED_SAMPLES: u64 = 200;

/// The relative error of the cost in a stream if its rate was not measured for long.
const FROM_FEW: f64 = 1.0;

/// Samples of a cell in a stream that is tried.
const STREAM_SAMPLES: u64 = 16;

/// Share of the time of such a trial after which all lanes are busy.
const FILLED: f64 = 0.3;

/// Fewest samples of a cell that show when it stops.
const LEAST_FOR_STOP: u64 = 16;

/// What is measured, or why that was not possible.
pub type Trial<T> = Result<T, Unmeasured>;

/// When a trial ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    begun: Instant,
    usual: Instant,
    /// Where nothing was finished before.
    last: Instant,
}

impl Limits {
    /// Of a trial that begins now, for a command that began then.
    pub(super) fn of(begun: Instant) -> Self {
        let now = Instant::now();
        let soon = now + SHORTEST;
        let usual = (now + LONGEST).min(begun + LAST).max(soon);
        Self { begun: now, usual, last: (begun + LAST_OF_ALL).max(usual) }
    }

    pub(super) fn is_over(&self) -> bool {
        Instant::now() >= self.usual
    }

    pub(super) fn is_over_at_last(&self) -> bool {
        Instant::now() >= self.last
    }

    pub(super) fn unmeasured(&self, what: &'static str) -> Unmeasured {
        Unmeasured { what, seconds: self.begun.elapsed().as_secs_f64() }
    }

    /// The same that ends earlier.
    pub(super) fn earlier(self, by: Duration) -> Self {
        Self { usual: self.usual - by, ..self }
    }
}

/// What a trial of samples found.
#[derive(Debug, Clone, Copy, Default)]
pub struct SampleTrial {
    /// The cost of a sample, with its share of the searches for rare events.
    pub cost: UnitCost,
    /// Samples that a thread evaluates one after the other, at most.
    pub serial: u64,
    /// Seconds in which one thread makes such a search, which others wait for; 0 where there are none.
    pub search: f64,
    /// What is expected of the cells of a job with looks.
    pub until_stop: Option<UntilStop>,
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

impl SampleTrial {
    /// How long so many samples in each of so many cells take at most, without what is set up; where they stop by precision,
    /// how long is expected.
    pub fn time(&self, samples: u64, cells: u64, threads: usize) -> Time {
        let serial = self.serial as f64;
        let time = match self.until_stop {
            None => self.cost.units(samples as f64 * cells as f64, serial, threads),
            Some(stop) => {
                let cost = UnitCost { error: stop.error, ..self.cost };
                cost.units(stop.samples_by_cost * cells as f64, serial, threads)
            }
        };
        Time { seconds: time.seconds.max(self.search), ..time }
    }
}

impl Engine {
    /// Measures the cost of samples from all over a job, for a command that began then.
    pub fn try_samples(&self, evaluator: &Evaluator<'_>, begun: Instant) -> Result<Trial<SampleTrial>, Failure> {
        let (limits, places) = (Limits::of(begun), Places::of_samples(evaluator));
        if evaluator.job().answer() == Answer::Weight {
            return Ok(try_placed(evaluator, &places, limits));
        }
        let what = if evaluator.job().answer().is_of_rare_events() { "search for rare events" } else { "sample" };
        let first = places.cell(0);
        places.is_first_in(first);
        let Some(twice) = places.set_up_in(first, &|| limits.is_over_at_last()) else {
            return Ok(Err(limits.unmeasured(what)));
        };
        let mut measured = Measured::default();
        measured.set_up(twice.set_up());
        let is_simulated = evaluator.job().model().simulation().is_some() && evaluator.counts_verdicts();
        let mut until_stop = None;
        if !is_simulated || evaluator.parts().looks().is_some() {
            // A stream that follows has the other half of the time.
            let half =
                if is_simulated { limits.usual.saturating_duration_since(Instant::now()) / 2 } else { Duration::ZERO };
            until_stop = self.try_batches(evaluator, &places, limits.earlier(half), &mut measured)?;
        }
        if measured.batches() == 0 && evaluator.counts_verdicts() {
            measured.batch(twice.again, 1.0);
        }
        let trial = |cost: UnitCost| SampleTrial { cost, serial: places.most(), search: 0.0, until_stop };
        if is_simulated {
            // Simulations of different cells share the lanes, so that batches by themselves take longer.
            if let Some(cost) = self.try_stream(evaluator, &places, limits, &mut measured)? {
                return Ok(Ok(trial(cost)));
            }
        }
        Ok(measured.falling_cost().map(trial).ok_or_else(|| limits.unmeasured(what)))
    }

    /// Measures the cost of the audits of a job, the plain samples beside its probabilities.
    pub fn try_audits(&self, evaluator: &Evaluator<'_>, begun: Instant) -> Result<Trial<SampleTrial>, Failure> {
        let (limits, places) = (Limits::of(begun), Places::of_audits(evaluator));
        let mut measured = Measured::default();
        let first = places.cell(0);
        places.is_first_in(first);
        if let Some(twice) = places.set_up_in(first, &|| limits.is_over_at_last()) {
            measured.set_up(twice.set_up());
            self.try_batches(evaluator, &places, limits, &mut measured)?;
            if measured.batches() == 0 {
                measured.batch(twice.again, 1.0);
            }
        }
        let found =
            measured.falling_cost().map(|cost| SampleTrial { cost, serial: places.most(), ..SampleTrial::default() });
        Ok(found.ok_or_else(|| limits.unmeasured("sample")))
    }

    /// The cost of samples in batches, each evaluated by itself, and when their cells stop.
    fn try_batches(
        &self,
        evaluator: &Evaluator<'_>,
        places: &Places<'_, '_>,
        limits: Limits,
        measured: &mut Measured,
    ) -> Result<Option<UntilStop>, Failure> {
        let looks = evaluator.parts().looks();
        let least = if looks.is_some() { LEAST_FOR_STOP.min(places.most()) } else { 1 };
        let Some((samples, seconds)) = places.samples_of_a_batch(&|| limits.is_over_at_last()) else { return Ok(None) };
        let samples = samples.max(least);
        let started = Instant::now();
        let is_enough = AtomicBool::new(false);
        let turn = AtomicU64::new(0);
        let work = |link: &Link<'_, Tried>| {
            while !is_enough.load(Ordering::Relaxed) && !limits.is_over() {
                link.send(places.tried(turn.fetch_add(1, Ordering::Relaxed), samples, &|| limits.is_over()));
            }
        };
        let (mut ends, mut costs_to_stop) = (Mean::default(), Mean::default());
        self.on_every_thread(0, &Interrupt::unwatched(), work, |event| {
            let Event::Finished(tried) = event else { return Ok(()) };
            tried.set_ups.into_iter().for_each(|seconds| measured.set_up(seconds));
            let Some(units) = tried.units else {
                measured.unfinished(tried.seconds);
                return Ok(());
            };
            measured.batch(tried.seconds, (samples * places.alike()) as f64);
            if let Some(looks) = looks {
                // Cells whose samples cost more may stop earlier or later. Those that share them are one measurement.
                let ends_of_all = units.iter().map(|unit| looks.expected_end(0, &unit.counts) as f64);
                let end = ends_of_all.sum::<f64>() / units.len() as f64;
                ends.add(end);
                costs_to_stop.add(tried.seconds / (samples * places.alike()) as f64 * end);
            }
            let elapsed = started.elapsed();
            // How many samples are drawn is not known where cells stop by precision.
            let total = if looks.is_some() { f64::INFINITY } else { places.total() };
            if elapsed >= SHORTEST && measured.is_settled(elapsed.as_secs_f64(), total, self.threads()) {
                is_enough.store(true, Ordering::Relaxed);
            }
            Ok(())
        })?;
        if measured.batches() == 0 {
            measured.batch(seconds, places.alike() as f64);
            return Ok(None);
        }
        let error = if ends.count() < LEAST_BATCHES { FROM_FEW } else { costs_to_stop.relative_error() };
        let mean = |values: &Mean| values.sum() / values.count() as f64;
        let cost = measured.cost().map_or(0.0, |cost| cost.unit);
        Ok(looks.filter(|_| cost > 0.0 && ends.count() > 0).map(|_| UntilStop {
            samples: mean(&ends),
            samples_by_cost: mean(&costs_to_stop) / cost,
            error,
        }))
    }

    /// The cost of a sample in a stream of samples from all over the job; `None` if none was finished. What is set up for them
    /// is no time of the stream.
    fn try_stream(
        &self,
        evaluator: &Evaluator<'_>,
        places: &Places<'_, '_>,
        limits: Limits,
        measured: &mut Measured,
    ) -> Result<Option<UnitCost>, Failure> {
        let started = Instant::now();
        let is_enough = AtomicBool::new(false);
        let is_over = || is_enough.load(Ordering::Relaxed) || limits.is_over();
        let turn = AtomicU64::new(0);
        let samples = places.most().min(STREAM_SAMPLES);
        let set_ups = Mutex::new(Vec::new());
        let work = |link: &Link<'_, u64>| {
            let next = || {
                let turn = (!is_over()).then(|| turn.fetch_add(1, Ordering::Relaxed))?;
                let unit = places.at(turn, samples);
                if places.is_first_in(places.cell(turn)) {
                    let begun = Instant::now();
                    evaluator.prepare(unit.0);
                    let seconds = begun.elapsed().as_secs_f64();
                    set_ups.lock().unwrap_or_else(PoisonError::into_inner).push(seconds);
                }
                Some(unit)
            };
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
            let (before, done) = record[record.len() - 1];
            let set_up: f64 = set_ups.lock().unwrap_or_else(PoisonError::into_inner).iter().sum();
            let seconds = (started.elapsed().as_secs_f64() - set_up / self.threads() as f64).max(before);
            let done = if let Event::Finished(samples) = event { done + samples } else { done };
            record.push((seconds, done));
            meter.record(seconds, done as f64);
            if seconds >= SHORTEST.as_secs_f64() && meter.relative_error().is_some_and(|error| error <= ENOUGH) {
                is_enough.store(true, Ordering::Relaxed);
            }
            Ok(())
        })?;
        set_ups.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().for_each(|one| measured.set_up(one));
        // At first no motion ends, while the lanes are being filled.
        let (end, done) = record[record.len() - 1];
        let (begin, before) = record[record.partition_point(|&(seconds, _)| seconds < FILLED * end)];
        if done == before || end <= begin {
            return Ok(None);
        }
        let unit = (end - begin) * self.threads() as f64 / (done - before) as f64;
        let error = meter.relative_error().filter(|error| error.is_finite()).unwrap_or(FROM_FEW);
        let set_up = measured.cost().unwrap_or_default();
        Ok(Some(UnitCost { unit, error, ..set_up }))
    }
}

/// The cost of samples of rare events with that of the searches for their places, which is that of a search for a
/// population of a cell.
fn try_placed(evaluator: &Evaluator<'_>, places: &Places<'_, '_>, limits: Limits) -> Trial<SampleTrial> {
    let parts = evaluator.parts();
    let of_a_cell = populations(evaluator.job()) as u64;
    let count = parts.cells() * of_a_cell;
    let order = Spread::over(count);
    let (mut searches, mut samples) = (Measured::default(), Measured::default());
    let more = PLACED_SAMPLES.min(places.most() - 1);
    for turn in 0..count {
        // The first search has all the time that there is.
        let is_first_search = searches.batches() == 0;
        let is_late = || if is_first_search { limits.is_over_at_last() } else { limits.is_over() };
        let Some(place) = order.at(turn).filter(|_| !is_late()) else { break };
        // Each randomisation of a cell has the population of its own number, up to their number.
        let (cell, population) = (place / of_a_cell, place % of_a_cell);
        let part = parts.in_cell(cell).start + population;
        if places.is_first_in(cell) {
            let Some(twice) = places.set_up_in(cell, &is_late) else { break };
            searches.set_up(twice.set_up());
        }
        let begun = Instant::now();
        let is_finished = evaluator.count(part, 0..1, &is_late).is_some();
        let seconds = begun.elapsed().as_secs_f64();
        if !is_finished {
            searches.unfinished(seconds);
            break;
        }
        searches.batch(seconds, 1.0);
        let begun = Instant::now();
        let is_finished = evaluator.count(part, 1..1 + more, &|| limits.is_over_at_last()).is_some();
        if is_finished && more > 0 {
            samples.batch(begun.elapsed().as_secs_f64(), more as f64);
        }
    }
    let Some(search) = searches.cost() else { return Err(limits.unmeasured("search for rare events")) };
    let error = if searches.batches() == count { 0.0 } else { search.error };
    let sample = samples.cost().map_or(0.0, |cost| cost.unit);
    let unit = search.unit * searches_per_sample(evaluator.job()) + sample;
    Ok(SampleTrial {
        cost: UnitCost { unit, error, ..search },
        serial: places.most(),
        search: search.unit,
        until_stop: None,
    })
}
