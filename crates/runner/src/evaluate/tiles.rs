//! Resolving tiles of verdict maps by simulation.

use std::time::{Duration, Instant};

use stickslip_core::model::Columns;
use stickslip_sampler::verdict_map::tile::{Tile, TileIndex};

use crate::evaluate::evaluator::Evaluator;
use stickslip_core::model::IsStopped;

/// Simulations of a tile that are counted first.
const FIRST_BATCH: usize = 64;

/// Time between two counts, by the cost of the simulations before.
const BATCH_TIME: Duration = Duration::from_millis(200);

impl Evaluator<'_> {
    /// Resolves one tile. `count` is called with the number of simulations of each batch. The search ends as soon as it
    /// `is_stopped`, also in the middle of a batch, and the result is `None`.
    pub fn resolve(
        &self,
        brake: usize,
        index: TileIndex,
        count: impl Fn(u64),
        is_stopped: IsStopped<'_>,
    ) -> Option<Tile> {
        let map = self.maps.get(brake)?;
        let configuration = self.criteria.configuration(self.job, brake)?;
        let mut at_once = FIRST_BATCH;
        Tile::resolve(index, |points| {
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
                count(decisions.len() as u64);
                if decisions.len() < pairs.len() || is_stopped() {
                    return None;
                }
                let affordable = BATCH_TIME.as_secs_f64() / begun.elapsed().as_secs_f64().max(1e-9);
                at_once = ((pairs.len() as f64 * affordable) as usize).clamp(1, 4 * at_once);
                verdicts.extend(decisions.iter().map(|decision| decision.verdict));
            }
            Some(verdicts)
        })
    }
}
