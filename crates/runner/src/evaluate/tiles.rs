//! Tiles of verdict maps, resolved by simulation, and what they cost.

use std::cell::Cell as Counter;
use std::time::{Duration, Instant};

use stickslip_core::criterion::decision::Decision;
use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_core::verdict::Verdict;
use stickslip_sampler::verdict_map::tile::{Tile, TileIndex};

use crate::evaluate::evaluator::Evaluator;

/// Verdicts of a tile that are asked for at once; a signal is looked for between.
const TILE_BATCH: usize = 64;

/// Tiles of a trial at the most.
const MOST_TRIAL_TILES: usize = 32;

/// The golden section.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// Cells, and samples of each, by which the cost of simulating the samples of a job is estimated.
const TRIAL_CELLS: u64 = 64;
const TRIAL_SAMPLES: u64 = 4;

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

impl Evaluator<'_> {
    /// Limits the cost of the verdict maps to that of simulating the samples, less what the audit takes of it. That is
    /// estimated from the first samples of some cells: a function of the job alone.
    pub fn limit_maps(&mut self) {
        if self.job.is_integrated() || !self.job.uses_maps() {
            return;
        }
        let cells = self.job.cells();
        let trial = cells.min(TRIAL_CELLS);
        let samples = self.parts.most(0).min(TRIAL_SAMPLES);
        let mut cost = 0;
        for turn in 0..trial {
            let cell = (u128::from(turn) * u128::from(cells) / u128::from(trial)) as u64;
            cost += cost_of(&self.simulate_first(cell, samples));
        }
        let others = self.job.verdicts_of_samples().saturating_sub(self.job.audited_samples());
        self.maps.limit(others.saturating_mul(u128::from(cost)) / u128::from((trial * samples).max(1)));
    }

    /// Resolves one tile; `None` if `goes_on`, which is told the decisions as they come, said no.
    pub fn resolve(&self, speed: usize, index: TileIndex, goes_on: impl Fn(&[Decision]) -> bool) -> Option<Tile> {
        let map = self.maps.get(speed)?;
        let criterion = self.criteria.at_speed(speed)?;
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
                let inputs_at = |&point: &[f64; 2]| {
                    let [preload, static_friction] = map.inputs(point);
                    RandomInputs { preload, static_friction }
                };
                let inputs: Vec<RandomInputs> = points.iter().map(inputs_at).collect();
                let decisions = criterion.decide(&inputs);
                verdicts.extend(decisions.iter().map(|decision| decision.verdict));
                cost += cost_of(&decisions);
                is_stopped = !goes_on(&decisions);
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
            let tile = self.resolve(speed, index, |decisions| {
                let (asked, cost) = counts.get();
                counts.set((asked + decisions.len() as u64, cost + cost_of(decisions)));
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

/// What verdicts cost: one each, and the scaled time for which a motion was simulated.
pub fn cost_of(decisions: &[Decision]) -> u64 {
    decisions.iter().map(|decision| 1 + decision.time as u64).sum()
}
