//! Resolving tiles of verdict maps by simulation, and the cost of that.

use std::time::{Duration, Instant};

use stickslip_core::criterion::decision::Decision;
use stickslip_core::rigid_disc::pad_on_disc::RandomInputs;
use stickslip_sampler::verdict_map::tile::{Tile, TileIndex};

use crate::evaluate::evaluator::Evaluator;

/// Simulations of a tile before the first check for a signal.
const FIRST_BATCH: usize = 64;

/// Time between two checks, by the cost of the simulations before.
const BATCH_TIME: Duration = Duration::from_millis(200);

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
    /// Their time in seconds, over all threads.
    pub seconds: f64,
    /// The relative standard error of the time of a tile.
    pub error: f64,
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

    /// Resolves one tile. `keep_going` is called with the decisions of each batch; if it returns false, the search ends
    /// and the result is `None`.
    pub fn resolve(&self, brake: usize, index: TileIndex, keep_going: impl Fn(&[Decision]) -> bool) -> Option<Tile> {
        let map = self.maps.get(brake)?;
        let criterion = self.criteria.for_brake(self.job, brake)?;
        if !keep_going(&[]) {
            return None;
        }
        let mut cost = 0;
        let mut at_once = FIRST_BATCH;
        let mut tile = Tile::resolve(index, |points| {
            let mut verdicts = Vec::with_capacity(points.len());
            while verdicts.len() < points.len() {
                let batch = points[verdicts.len()..].iter().take(at_once);
                let inputs_at = |&point: &[f64; 2]| {
                    let [preload, static_friction] = map.inputs(point);
                    RandomInputs { preload, static_friction }
                };
                let inputs: Vec<RandomInputs> = batch.map(inputs_at).collect();
                let begun = Instant::now();
                let decisions = criterion.decide(&inputs);
                let affordable = BATCH_TIME.as_secs_f64() / begun.elapsed().as_secs_f64().max(1e-9);
                at_once = ((inputs.len() as f64 * affordable) as usize).clamp(1, 4 * at_once);
                verdicts.extend(decisions.iter().map(|decision| decision.verdict));
                cost += cost_of(&decisions);
                if !keep_going(&decisions) {
                    return None;
                }
            }
            Some(verdicts)
        })?;
        tile.cost = cost;
        Some(tile)
    }
}

/// The cost of decisions: one each, plus the scaled time for which a motion was simulated.
pub fn cost_of(decisions: &[Decision]) -> u64 {
    decisions.iter().map(|decision| 1 + decision.time as u64).sum()
}
