//! Completing the verdict maps of a job on all threads.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use stickslip_sampler::verdict_map::tile::{Tile, TileIndex};

use crate::evaluate::evaluator::Evaluator;
use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::interrupt::Interrupt;
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
}

/// Which tiles of verdict maps are completed, and where they are kept.
#[derive(Debug, Clone, Copy, Default)]
pub struct Mapping<'a> {
    /// The directory of new tiles, if they are kept.
    pub keep: Option<&'a Folder>,
    /// Whether some of those that are there come from other runs; they are kept, too.
    pub borrowed: bool,
    /// The share of the tiles, if others complete the rest.
    pub share: Option<Shard>,
}

impl Engine {
    /// Completes the verdict maps of `evaluator` by simulation.
    pub fn complete_maps(
        &self,
        evaluator: &mut Evaluator<'_>,
        mapping: Mapping<'_>,
        interrupt: &Interrupt,
    ) -> Result<CompletedMaps, Failure> {
        let Mapping { keep, borrowed, share } = mapping;
        if let (Some(keep), true) = (keep, borrowed) {
            map_pieces::write_all(evaluator.maps(), keep)?;
        }
        let missing = evaluator.maps().missing_of(|number| share.is_none_or(|share| share.has(number)));
        let simulations = AtomicU64::new(0);
        let mut progress = Progress::new(missing.len() as u128, "tiles").of_step("the verdict map");
        let mut finished: Vec<(usize, TileIndex, Tile)> = Vec::new();
        let mut written = 0;
        let (started, mut since) = (Instant::now(), Instant::now());
        let resolve = |unit: u64, is_stopped: IsStopped<'_>| {
            let (configuration, index) = missing[unit as usize];
            let count = |made| {
                simulations.fetch_add(made, Ordering::Relaxed);
            };
            (configuration, index, evaluator.resolve(configuration, index, count, is_stopped))
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
        for (configuration, index, tile) in finished {
            evaluator.maps_mut().insert(configuration, index, tile);
        }
        let tiles = evaluator.maps().resolved() as u64;
        Ok(CompletedMaps { outcome, simulations: simulations.into_inner(), tiles })
    }
}
