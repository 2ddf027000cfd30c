//! Completing the verdict maps of a job on all threads, unless they cost more than the samples.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use indicatif::HumanCount;
use stickslip_core::model::decision::Decision;
use stickslip_sampler::verdict_map::tile::{Tile, TileIndex};

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::tiles::cost_of;
use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::schedule::engine::{Engine, Event, Outcome};
use crate::schedule::plan::Shard;
use crate::schedule::progress::Progress;
use crate::schedule::saving::{LONGEST_INTERVAL, SHORTEST_INTERVAL};
use crate::store::map_pieces;
use stickslip_core::model::IsStopped;

/// How the completion of verdict maps ended.
#[derive(Debug, Clone, Copy)]
pub struct CompletedMaps {
    /// Whether it finished.
    pub outcome: Outcome,
    /// Simulations that were made now.
    pub simulations: u64,
    /// Number of tiles that are resolved.
    pub tiles: u64,
    /// If the maps were given up because they cost more than the samples: all simulations made for them until then.
    pub given_up: Option<u64>,
}

impl CompletedMaps {
    /// A note that the maps were given up, if they were.
    pub fn why_given_up(&self, job: &Job) -> Option<String> {
        let simulations = self.given_up?;
        let audited = job.audited_samples();
        let audit = if audited > 0 { format!(" than the map and its audit of {audited}") } else { String::new() };
        Some(format!(
            "the verdict map is given up after {} simulations ({} tiles were resolved), as simulating the {} samples costs less{}: each sample is simulated, as with evaluate = \"each\"",
            HumanCount(simulations),
            HumanCount(self.tiles),
            job.total_samples(),
            audit
        ))
    }
}

/// Which tiles of verdict maps are completed, and where they are kept.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mapping<'a> {
    /// The directory of new tiles, if they are kept.
    pub keep: Option<&'a Folder>,
    /// Whether some of those that are there come from other runs; they are kept, too.
    pub borrowed: bool,
    /// Whether only the maps are wanted now, and samples later. Then maps are given up by the cost of tiles that are
    /// kept alone, so that a run that finds these later gives them up, too.
    pub is_all: bool,
    /// The share of the tiles, if others complete the rest.
    pub share: Option<Shard>,
}

impl Engine {
    /// Limits the cost of the verdict maps of a job to that of simulating its samples. Nothing of it is kept, so that a
    /// signal ends the process at once.
    pub fn limit_maps(&self, evaluator: &mut Evaluator<'_>) -> Result<(), Failure> {
        let cells = evaluator.limiting_cells();
        if cells.is_empty() {
            return Ok(());
        }
        let mut progress = Progress::new(cells.len() as u128, "cells").of_step("the cost of samples");
        let mut total = 0;
        let cost = |place: u64, _: IsStopped<'_>| evaluator.limiting_cost(cells[place as usize]);
        self.in_parallel(cells.len() as u64, &Interrupt::unwatched(), cost, |event| {
            if let Event::Finished(cost) = event {
                progress.advance(1);
                total += cost;
            }
            progress.tick();
            Ok(())
        })?;
        progress.finish();
        evaluator.limit_maps(cells.len(), total);
        Ok(())
    }

    /// Completes the verdict maps of `evaluator` by simulation, or gives them up if they cost more than the samples.
    pub fn complete_maps(
        &self,
        evaluator: &mut Evaluator<'_>,
        mapping: Mapping<'_>,
        interrupt: &Interrupt,
    ) -> Result<CompletedMaps, Failure> {
        let Mapping { keep, borrowed, is_all, share } = mapping;
        self.limit_maps(evaluator)?;
        if let (Some(keep), true) = (keep, borrowed) {
            map_pieces::write_all(evaluator.maps(), keep)?;
        }
        let missing = evaluator.maps().missing_of(|number| share.is_none_or(|share| share.has(number)));
        let known = evaluator.maps().simulations();
        let (simulations, cost) = (AtomicU64::new(known), AtomicU64::new(evaluator.maps().cost()));
        // That of whole tiles.
        let kept = AtomicU64::new(evaluator.maps().cost());
        let is_too_costly =
            || evaluator.maps().are_too_costly(if is_all { &kept } else { &cost }.load(Ordering::Relaxed));
        let mut progress = Progress::new(missing.len() as u128, "tiles").of_step("the verdict map");
        let mut finished: Vec<(usize, TileIndex, Tile)> = Vec::new();
        let mut written = 0;
        let (started, mut since) = (Instant::now(), Instant::now());
        let resolve = |unit: u64, is_stopped: IsStopped<'_>| {
            let (configuration, index) = missing[unit as usize];
            let count = |decisions: &[Decision]| {
                simulations.fetch_add(decisions.len() as u64, Ordering::Relaxed);
                cost.fetch_add(cost_of(decisions), Ordering::Relaxed);
            };
            let is_over = || is_stopped() || is_too_costly();
            let tile = if is_over() { None } else { evaluator.resolve(configuration, index, count, &is_over) };
            kept.fetch_add(tile.as_ref().map_or(0, |tile| tile.cost), Ordering::Relaxed);
            (configuration, index, tile)
        };
        let outcome = self.in_parallel(missing.len() as u64, interrupt, resolve, |event| {
            let is_done = matches!(event, Event::Done);
            if let Event::Finished((configuration, index, Some(tile))) = event {
                progress.advance(1);
                finished.push((configuration, index, tile));
            }
            progress.tick();
            let interval = match interrupt.signal() {
                Some(_) => SHORTEST_INTERVAL,
                None => (started.elapsed() / 10).clamp(SHORTEST_INTERVAL, LONGEST_INTERVAL),
            };
            if let Some(keep) = keep
                && finished.len() > written
                && (is_done || since.elapsed() >= interval)
            {
                let _saving = interrupt.saving();
                map_pieces::write(evaluator.maps(), keep, &finished[written..])?;
                written = finished.len();
                since = Instant::now();
            }
            Ok(())
        })?;
        progress.finish();
        let given_up = outcome == Outcome::Finished && is_too_costly();
        for (configuration, index, tile) in finished {
            evaluator.maps_mut().insert(configuration, index, tile);
        }
        let simulations = simulations.into_inner();
        let completed = CompletedMaps {
            outcome,
            simulations: simulations - known,
            tiles: evaluator.maps().resolved() as u64,
            given_up: given_up.then_some(simulations),
        };
        if given_up {
            evaluator.maps_mut().give_up();
        }
        Ok(completed)
    }
}
