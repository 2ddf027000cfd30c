//! Completing the verdict maps of a job on all threads, unless they cost more than the samples.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use indicatif::HumanCount;
use stickslip_sampler::verdict_map::tile::{Tile, TileIndex};

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::tiles::cost_of;
use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::schedule::engine::{Engine, Event, Outcome};
use crate::schedule::progress::Progress;
use crate::schedule::saving::{LONGEST_INTERVAL, SHORTEST_INTERVAL};
use crate::store::map_pieces;

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

impl Engine {
    /// Completes the verdict maps of `evaluator` by simulation, or gives them up if they cost more than the samples.
    /// New tiles are written to the directory `keep`, if there is one. If some are `borrowed` from other runs, those
    /// are, too.
    pub fn complete_maps(
        &self,
        evaluator: &mut Evaluator<'_>,
        keep: Option<&Folder>,
        borrowed: bool,
        interrupt: &Interrupt,
    ) -> Result<CompletedMaps, Failure> {
        evaluator.limit_maps();
        if let (Some(keep), true) = (keep, borrowed) {
            map_pieces::write_all(evaluator.maps(), keep)?;
        }
        let missing = evaluator.maps().missing();
        let known = evaluator.maps().simulations();
        let (simulations, cost) = (AtomicU64::new(known), AtomicU64::new(evaluator.maps().cost()));
        let mut progress = Progress::new(missing.len() as u128, "tiles").of_step("the verdict map");
        let mut finished: Vec<(usize, TileIndex, Tile)> = Vec::new();
        let mut written = 0;
        let (started, mut since) = (Instant::now(), Instant::now());
        let resolve = |unit: u64| {
            let (speed, index) = missing[unit as usize];
            let tile = evaluator.resolve(speed, index, |decisions| {
                count(&simulations, decisions.len() as u64);
                let cost = count(&cost, cost_of(decisions));
                interrupt.signal().is_none() && !evaluator.maps().are_too_costly(cost)
            });
            (speed, index, tile)
        };
        let outcome = self.in_parallel(missing.len() as u64, interrupt, resolve, |event| {
            let is_done = matches!(event, Event::Done);
            if let Event::Finished((speed, index, Some(tile))) = event {
                progress.advance(1);
                finished.push((speed, index, tile));
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
        for (speed, index, tile) in finished {
            evaluator.maps_mut().insert(speed, index, tile);
        }
        let simulations = simulations.into_inner();
        let given_up = outcome == Outcome::Finished && evaluator.maps().are_too_costly(cost.into_inner());
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

/// Adds to a counter that threads share, and returns its new value.
fn count(counter: &AtomicU64, more: u64) -> u64 {
    counter.fetch_add(more, Ordering::Relaxed) + more
}
