//! Verdict maps in the making: their tiles resolved on all cores, and what they may cost.

use std::cell::Cell as Counter;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use indicatif::HumanCount;
use stickslip_core::criterion::time_domain::Decision;
use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_core::verdict::Verdict;
use stickslip_sampler::verdict_map::map::{Tile, TileIndex};

use crate::evaluate::batch::Batch;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::schedule::engine::{Engine, Event, Outcome};
use crate::schedule::progress::Progress;

/// Verdicts of a tile that are asked for at once; a signal is looked for between.
const TILE_BATCH: usize = 64;

/// Tiles of a trial at the most.
const MOST_TRIAL_TILES: usize = 32;

/// The golden section.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// Cells, and samples of each, by which the cost of simulating the samples of a job is estimated.
const TRIAL_CELLS: u64 = 64;
const TRIAL_SAMPLES: u64 = 4;

/// What became of the verdict maps of a job.
#[derive(Debug, Clone, Copy)]
pub struct CompletedMaps {
    /// How it ended.
    pub outcome: Outcome,
    /// Verdicts that were asked for.
    pub simulations: u64,
    /// Needed tiles that are resolved.
    pub tiles: u64,
    /// With maps that cost more than the samples: simulations when that was known, whenever made.
    pub given_up: Option<u64>,
}

impl CompletedMaps {
    /// What to say of maps that were given up, if they were.
    pub fn why_given_up(&self, job: &Job) -> Option<String> {
        let asked = self.given_up?;
        let audited = job.audited_samples();
        let audit = if audited > 0 { format!(" than the map and its audit of {audited}") } else { String::new() };
        Some(format!(
            "the verdict map is given up after {} simulations ({} tiles were resolved), as simulating the {} samples costs less{}: each is simulated by itself, as with evaluate = \"each\"",
            HumanCount(asked),
            HumanCount(self.tiles),
            job.total_samples(),
            audit
        ))
    }
}

/// What resolving some tiles took.
#[derive(Debug, Clone, Copy, Default)]
pub struct MapTrial {
    /// Tiles that were begun.
    pub tiles: u64,
    /// How many of them were dropped because they took too long.
    pub unfinished: u64,
    /// Verdicts that were asked for.
    pub simulations: u64,
    /// What they cost.
    pub cost: u64,
    /// How long it took.
    pub seconds: f64,
}

impl Engine<'_> {
    /// Takes the needed tiles that lie in a directory of pieces and are not there yet; how many.
    pub fn load_maps(&mut self, source: &Path) -> Result<usize, Failure> {
        self.maps.load(source)
    }

    /// Gives the verdict maps up: every sample is simulated.
    pub fn give_maps_up(&mut self) {
        self.maps.give_up();
    }

    /// Limits the cost of the verdict maps to that of simulating the samples, less what the audit takes of it. That is
    /// estimated from the first samples of some cells: a function of the job alone.
    pub fn limit_maps(&mut self) {
        if self.job.is_integrated() || !self.job.uses_maps() {
            return;
        }
        let cells = self.job.cells();
        let trial = cells.min(TRIAL_CELLS);
        let samples = self.slots.most(0).min(TRIAL_SAMPLES);
        let mut cost = 0;
        for turn in 0..trial {
            let cell = self.job.grid.cell((u128::from(turn) * u128::from(cells) / u128::from(trial)) as u64);
            let batch = Batch::draw(self.job, &cell, 0, 0..samples, self.job.points());
            let inputs: Vec<RandomInputs> = (0..batch.len()).map(|sample| batch.inputs(sample)).collect();
            cost += cost_of(&self.deciders.decide(self.job.grid.rotating_speed_index(cell.index), &inputs));
        }
        let others = self.job.verdicts_of_samples().saturating_sub(self.job.audited_samples());
        self.maps.limit(others.saturating_mul(u128::from(cost)) / u128::from((trial * samples).max(1)));
    }

    /// Completes the verdict maps by asking, or gives them up when they cost more than the samples. What is new is kept
    /// in `keep`, if there is such a directory, and so is what was `borrowed` from others.
    pub fn complete_maps(
        &mut self,
        keep: Option<&Path>,
        borrowed: bool,
        interrupt: &Interrupt,
    ) -> Result<CompletedMaps, Failure> {
        self.limit_maps();
        if let (Some(keep), true) = (keep, borrowed) {
            self.maps.write_all(keep)?;
        }
        let missing = self.maps.missing();
        let known = self.maps.questions();
        let (asked, cost) = (AtomicU64::new(known), AtomicU64::new(self.maps.cost()));
        let mut progress = Progress::new(missing.len() as u128, "tiles");
        let mut finished: Vec<(usize, TileIndex, Tile)> = Vec::new();
        let mut written = 0;
        let mut since = Instant::now();
        let resolve = |unit: u64| {
            let (speed, index) = missing[unit as usize];
            let tile = self.resolve(speed, index, |judged| {
                count(&asked, judged.len() as u64);
                let cost = count(&cost, cost_of(judged));
                interrupt.signal().is_none() && !self.maps.are_too_costly(cost)
            });
            (speed, index, tile)
        };
        let outcome = self.in_parallel(missing.len() as u64, interrupt, resolve, |event| {
            if let Event::Unit((speed, index, Some(tile))) = event {
                progress.advance(1);
                finished.push((speed, index, tile));
            } else if matches!(event, Event::Done) || since.elapsed() >= Duration::from_secs(5) {
                if let (Some(keep), true) = (keep, finished.len() > written) {
                    self.maps.write(keep, &finished[written..])?;
                    written = finished.len();
                }
                since = Instant::now();
            }
            progress.tick();
            Ok(())
        })?;
        progress.finish();
        for (speed, index, tile) in finished {
            self.maps.insert(speed, index, tile);
        }
        let asked = asked.into_inner();
        let given_up = outcome == Outcome::Finished && self.maps.are_too_costly(cost.into_inner());
        let completed = CompletedMaps {
            outcome,
            simulations: asked - known,
            tiles: self.maps.resolved() as u64,
            given_up: given_up.then_some(asked),
        };
        if given_up {
            self.maps.give_up();
        }
        Ok(completed)
    }

    /// Resolves one tile; `None` if `goes_on`, which is told the judged samples as they come, said no.
    fn resolve(&self, speed: usize, index: TileIndex, goes_on: impl Fn(&[Decision]) -> bool) -> Option<Tile> {
        let map = self.maps.get(speed)?;
        let mut is_stopped = !goes_on(&[]);
        let mut cost = 0;
        let mut tile = Tile::resolve(index, |points| {
            let mut verdicts = Vec::with_capacity(points.len());
            for points in points.chunks(TILE_BATCH) {
                if is_stopped {
                    // The tile is dropped; the sooner it is done, the better.
                    verdicts.extend(points.iter().map(|_| Verdict::Stable));
                    continue;
                }
                let inputs: Vec<RandomInputs> = points.iter().map(|&point| map.inputs(point)).collect();
                let judged = self.deciders.decide(speed, &inputs);
                verdicts.extend(judged.iter().map(|judged| judged.verdict));
                cost += cost_of(&judged);
                is_stopped = !goes_on(&judged);
            }
            verdicts
        });
        tile.cost = cost;
        (!is_stopped).then_some(tile)
    }

    /// Resolves some of the tiles that are missing, evenly spread, for about `time`: what they say of the cost of all.
    /// A tile that takes more than a quarter of it is dropped.
    pub fn try_maps(&self, time: Duration) -> MapTrial {
        let missing = self.maps.missing();
        let started = Instant::now();
        let mut trial = MapTrial::default();
        for turn in 0..MOST_TRIAL_TILES.min(missing.len()) {
            // Multiples of the golden section, so that however many there is time for, they are spread evenly.
            let place = (0.5 + turn as f64 * GOLDEN_SECTION).fract() * missing.len() as f64;
            let (speed, index) = missing[place as usize];
            let begun = Instant::now();
            let counts = Counter::new((0, 0));
            let tile = self.resolve(speed, index, |judged| {
                let (asked, cost) = counts.get();
                counts.set((asked + judged.len() as u64, cost + cost_of(judged)));
                started.elapsed() < time && begun.elapsed() < time / 4
            });
            trial.tiles += 1;
            trial.unfinished += u64::from(tile.is_none());
            trial.simulations += counts.get().0;
            trial.cost += counts.get().1;
            if started.elapsed() >= time {
                break;
            }
        }
        trial.seconds = started.elapsed().as_secs_f64();
        trial
    }
}

/// Adds to a counter that threads share; what it is then.
fn count(counter: &AtomicU64, more: u64) -> u64 {
    counter.fetch_add(more, Ordering::Relaxed) + more
}

/// What verdicts cost: one each, and the scaled time that a motion was followed.
fn cost_of(judged: &[Decision]) -> u64 {
    judged.iter().map(|judged| 1 + judged.time as u64).sum()
}
