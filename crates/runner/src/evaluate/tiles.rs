//! Resolving tiles of verdict maps by simulation, and the cost of that.

use std::time::{Duration, Instant};

use stickslip_core::model::Columns;
use stickslip_core::model::decision::Decision;
use stickslip_sampler::verdict_map::tile::{Tile, TileIndex};

use crate::evaluate::evaluator::Evaluator;
use crate::job::MapUse;
use stickslip_core::model::IsStopped;

/// Simulations of a tile that are counted first.
const FIRST_BATCH: usize = 64;

/// Time between two counts, by the cost of the simulations before.
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
    /// The cells whose first samples show what simulating all samples costs; none where that is not asked.
    pub fn limiting_cells(&self) -> Vec<u64> {
        if self.job.map_use() != MapUse::LookUp {
            return Vec::new();
        }
        let cells = self.job.cells();
        let tried = cells.min(TRIAL_CELLS);
        (0..tried).map(|turn| (u128::from(turn) * u128::from(cells) / u128::from(tried)) as u64).collect()
    }

    /// The cost of the first samples of a cell.
    pub fn limiting_cost(&self, cell: u64) -> u64 {
        cost_of(&self.simulate_first(cell, self.limiting_samples()))
    }

    fn limiting_samples(&self) -> u64 {
        self.parts.max_samples(0).min(TRIAL_SAMPLES)
    }

    /// Limits the cost of the verdict maps to that of simulating all samples but the audited ones. It is estimated from
    /// the `cost` of the first samples of this many `cells`, and so depends on the job alone.
    pub fn limit_maps(&mut self, cells: usize, cost: u64) {
        let others = self.job.verdicts_of_samples().saturating_sub(self.job.audited_samples());
        let tried = (cells as u64 * self.limiting_samples()).max(1);
        self.maps.limit(others.saturating_mul(u128::from(cost)) / u128::from(tried));
    }

    /// Resolves one tile. `count` is called with the decisions of each batch. The search ends as soon as it
    /// `is_stopped`, also in the middle of a batch, and the result is `None`.
    pub fn resolve(
        &self,
        brake: usize,
        index: TileIndex,
        count: impl Fn(&[Decision]),
        is_stopped: IsStopped<'_>,
    ) -> Option<Tile> {
        let map = self.maps.get(brake)?;
        let configuration = self.criteria.configuration(self.job, brake)?;
        let mut cost = 0;
        let mut at_once = FIRST_BATCH;
        let mut tile = Tile::resolve(index, |points| {
            let mut verdicts = Vec::with_capacity(points.len());
            while verdicts.len() < points.len() {
                let batch = points[verdicts.len()..].iter().take(at_once);
                let pairs: Vec<[f64; 2]> = batch.map(|&point| map.inputs(point)).collect();
                let [firsts, seconds] = [0, 1].map(|which| pairs.iter().map(|pair| pair[which]).collect::<Vec<f64>>());
                let all: Vec<usize> = (0..pairs.len()).collect();
                let begun = Instant::now();
                let columns = [&firsts[..], &seconds];
                let decided = configuration.decide(&Columns::new(pairs.len(), &columns), &all, is_stopped);
                let decisions = decided.unwrap_or_default();
                count(&decisions);
                if decisions.len() < pairs.len() || is_stopped() {
                    return None;
                }
                let affordable = BATCH_TIME.as_secs_f64() / begun.elapsed().as_secs_f64().max(1e-9);
                at_once = ((pairs.len() as f64 * affordable) as usize).clamp(1, 4 * at_once);
                verdicts.extend(decisions.iter().map(|decision| decision.verdict));
                cost += cost_of(&decisions);
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
