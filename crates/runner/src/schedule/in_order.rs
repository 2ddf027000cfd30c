//! Independent searches on all threads, and their results in order.

use std::sync::atomic::{AtomicU64, Ordering};

use crate::failure::{Advice, Failure};
use crate::interrupt::Interrupt;
use crate::schedule::engine::{Engine, Event, Outcome};
use crate::schedule::progress::{Progress, Total};
use stickslip_core::model::IsStopped;

/// The steps of all searches together, in which their progress is shown.
pub struct Steps<'a> {
    /// How many are done: the searches count them.
    pub done: &'a AtomicU64,
    /// How many there are, as far as is known before.
    pub total: u64,
    pub total_is: Total,
    /// What they are called.
    pub unit: &'static str,
}

impl Engine {
    /// The results of `count` searches. A search that is stopped gives `None`; `stopped` is what is said after a signal. Of
    /// several failures the first is returned, whatever the threads.
    pub fn in_order<T: Send>(
        &self,
        count: u64,
        steps: &Steps<'_>,
        interrupt: &Interrupt,
        stopped: &Advice,
        search: impl Fn(u64, IsStopped<'_>) -> Result<Option<T>, Failure> + Sync + Send,
    ) -> Result<Vec<T>, Failure> {
        let mut results: Vec<Option<T>> = (0..count).map(|_| None).collect();
        let mut failed: Option<(u64, Failure)> = None;
        let mut progress = Progress::new(0, steps.unit);
        progress.expect_left(u128::from(steps.total), steps.total_is);
        let mut shown = 0;
        let search = |index: u64, is_stopped: IsStopped<'_>| (index, search(index, is_stopped));
        let outcome = self.in_parallel(count, interrupt, search, |event| {
            let done = steps.done.load(Ordering::Relaxed);
            progress.advance(done - shown);
            progress.tick();
            shown = done;
            match event {
                Event::Finished((index, Ok(result))) => results[index as usize] = result,
                Event::Finished((index, Err(failure))) if failed.as_ref().is_none_or(|(first, _)| index < *first) => {
                    failed = Some((index, failure));
                }
                Event::Finished(_) | Event::Idle | Event::Done => {}
            }
            Ok(())
        })?;
        progress.finish();
        match (outcome, failed) {
            (Outcome::Stopped(signal), _) => Err(Failure::stopped(signal, stopped)),
            (Outcome::Finished, Some((_, failure))) => Err(failure),
            (Outcome::Finished, None) => Ok(results.into_iter().flatten().collect()),
        }
    }
}
