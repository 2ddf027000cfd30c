//! The cost of verdict maps, measured on some of their tiles.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Instant;

use stickslip_core::model::IsStopped;

use crate::evaluate::evaluator::Evaluator;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::schedule::cost::{Measured, UnitCost};
use crate::schedule::engine::Engine;
use crate::schedule::trial::{Limits, SHORTEST, Trial};

/// What a trial of tiles found.
#[derive(Debug, Clone, Copy)]
pub struct MapTrial {
    /// The cost of a tile.
    pub cost: UnitCost,
    /// Simulations of a tile.
    pub simulations: f64,
    /// Tiles that were finished.
    pub tiles: u64,
}

/// A tile that was tried.
struct TriedTile {
    simulations: u64,
    seconds: f64,
    is_finished: bool,
}

impl Engine {
    /// Resolves some of the missing tiles, evenly spread, to estimate the cost of all. Those that are not finished in time are
    /// dropped.
    pub fn try_maps(&self, evaluator: &Evaluator<'_>, begun: Instant) -> Result<Trial<MapTrial>, Failure> {
        let missing = evaluator.maps().missing();
        let limits = Limits::of(begun);
        let started = Instant::now();
        let is_enough = AtomicBool::new(false);
        let has_finished = AtomicBool::new(false);
        // Where none is finished, they have all the time that there is.
        let is_over = || if has_finished.load(Ordering::Relaxed) { limits.is_over() } else { limits.is_over_at_last() };
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
            let is_finished = evaluator.resolve(configuration, index, count, &is_over).is_some();
            has_finished.fetch_or(is_finished, Ordering::Relaxed);
            Some(TriedTile {
                simulations: simulations.into_inner(),
                seconds: begun.elapsed().as_secs_f64(),
                is_finished,
            })
        };
        let mut measured = Measured::default();
        let mut simulations = 0;
        self.for_each_in_parallel(missing.len() as u64, &Interrupt::unwatched(), work, |tried| {
            let Some(tried) = tried else { return };
            simulations += tried.simulations;
            match tried.is_finished {
                true => measured.batch(tried.seconds, 1.0),
                false => measured.unfinished(tried.seconds),
            }
            if started.elapsed() >= SHORTEST && measured.is_certain() {
                is_enough.store(true, Ordering::Relaxed);
            }
        })?;
        let tiles = measured.batches();
        let trial = |mut cost: UnitCost| {
            if tiles == missing.len() as u64 {
                cost.error = 0.0;
            }
            MapTrial { cost, simulations: simulations as f64 / tiles as f64, tiles }
        };
        Ok(measured.cost().map(trial).ok_or_else(|| limits.unmeasured("tile of the verdict map")))
    }
}
