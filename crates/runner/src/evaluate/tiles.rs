//! Resolving tiles of verdict maps by simulation, and the cost of that.

use std::cell::Cell as Counter;
use std::time::{Duration, Instant};

use stickslip_core::criterion::decision::Decision;
use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_core::verdict::Verdict;
use stickslip_sampler::verdict_map::tile::{Tile, TileIndex};

use crate::evaluate::evaluator::Evaluator;

/// Simulations of a tile between two checks for a signal.
const TILE_BATCH: usize = 64;

/// Largest number of tiles of a trial.
const MOST_TRIAL_TILES: usize = 32;

/// The golden section.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_894_9;

/// Number of cells, and of samples in each, from which the cost of simulating all samples of a job is estimated.
const TRIAL_CELLS: u64 = 64;
const TRIAL_SAMPLES: u64 = 4;

/// The cost of resolving some tiles.
#[derive(Debug, Clone, Copy, Default)]
pub struct MapTrial {
    /// Tiles that were started.
    pub tiles: u64,
    /// Tiles that were dropped because they took too long.
    pub unfinished: u64,
    /// Simulations.
    pub simulations: u64,
    /// Their cost, see [`cost_of`].
    pub cost: u64,
    /// Their time in seconds.
    pub seconds: f64,
}

impl Evaluator<'_> {
    /// Limits the cost of the verdict maps to that of simulating all samples but the audited ones. It is estimated from
    /// the first samples of some cells, and so depends on the job alone.
    pub fn limit_maps(&mut self) {
        if self.job.is_integrated() || !self.job.uses_maps() {
            return;
        }
        let cells = self.job.cells();
        let trial = cells.min(TRIAL_CELLS);
        let samples = self.parts.max_samples(0).min(TRIAL_SAMPLES);
        let mut cost = 0;
        for turn in 0..trial {
            let cell = (u128::from(turn) * u128::from(cells) / u128::from(trial)) as u64;
            cost += cost_of(&self.simulate_first(cell, samples));
        }
        let others = self.job.verdicts_of_samples().saturating_sub(self.job.audited_samples());
        self.maps.limit(others.saturating_mul(u128::from(cost)) / u128::from((trial * samples).max(1)));
    }

    /// Resolves one tile. `keep_going` is called with the decisions of each batch; if it returns false, the result is
    /// `None`.
    pub fn resolve(&self, brake: usize, index: TileIndex, keep_going: impl Fn(&[Decision]) -> bool) -> Option<Tile> {
        let map = self.maps.get(brake)?;
        let criterion = self.criteria.for_brake(self.job, brake)?;
        let mut is_stopped = !keep_going(&[]);
        let mut cost = 0;
        let mut tile = Tile::resolve(index, |points| {
            let mut verdicts = Vec::with_capacity(points.len());
            for points in points.chunks(TILE_BATCH) {
                if is_stopped {
                    // The tile will be dropped. Equal verdicts end its resolution soonest.
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
                is_stopped = !keep_going(&decisions);
            }
            verdicts
        });
        tile.cost = cost;
        (!is_stopped).then_some(tile)
    }

    /// Resolves some of the missing tiles, evenly spread, for about `time`, to estimate the cost of all. A tile that
    /// takes more than a quarter of the time is dropped.
    pub fn try_maps(&self, time: Duration) -> MapTrial {
        let missing = self.maps.missing();
        let started = Instant::now();
        let mut trial = MapTrial::default();
        for turn in 0..MOST_TRIAL_TILES.min(missing.len()) {
            // Multiples of the golden section are spread evenly, however many tiles there is time for.
            let place = (0.5 + turn as f64 * GOLDEN_SECTION).fract() * missing.len() as f64;
            let (brake, index) = missing[place as usize];
            let begun = Instant::now();
            let counts = Counter::new((0, 0));
            let tile = self.resolve(brake, index, |decisions| {
                let (simulations, cost) = counts.get();
                counts.set((simulations + decisions.len() as u64, cost + cost_of(decisions)));
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

/// The cost of decisions: one each, plus the scaled time for which a motion was simulated.
pub fn cost_of(decisions: &[Decision]) -> u64 {
    decisions.iter().map(|decision| 1 + decision.time as u64).sum()
}
