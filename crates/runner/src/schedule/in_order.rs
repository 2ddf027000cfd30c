//! Independent searches on all threads, and their results in order.

use crate::failure::{Advice, Failure};
use crate::interrupt::Interrupt;
use crate::schedule::engine::{Engine, Outcome};
use crate::schedule::progress::Progress;
use stickslip_core::model::IsStopped;

impl Engine {
    /// The results of `count` searches, whose progress is shown in `unit`s. A search that is stopped gives `None`;
    /// `stopped` is what is said after a signal. Of several failures the first is returned, whatever the threads.
    pub fn in_order<T: Send>(
        &self,
        count: u64,
        unit: &'static str,
        interrupt: &Interrupt,
        stopped: &Advice,
        search: impl Fn(u64, IsStopped<'_>) -> Result<Option<T>, Failure> + Sync + Send,
    ) -> Result<Vec<T>, Failure> {
        let mut results: Vec<Option<T>> = (0..count).map(|_| None).collect();
        let mut failed: Option<(u64, Failure)> = None;
        let mut progress = Progress::new(u128::from(count), unit);
        let search = |index: u64, is_stopped: IsStopped<'_>| (index, search(index, is_stopped));
        let outcome = self.for_each_in_parallel(count, interrupt, search, |(index, result)| {
            progress.advance(u64::from(!matches!(result, Ok(None))));
            progress.tick();
            match result {
                Ok(result) => results[index as usize] = result,
                Err(failure) if failed.as_ref().is_none_or(|(first, _)| index < *first) => {
                    failed = Some((index, failure));
                }
                Err(_) => {}
            }
        })?;
        progress.finish();
        match (outcome, failed) {
            (Outcome::Stopped(signal), _) => Err(Failure::stopped(signal, stopped)),
            (Outcome::Finished, Some((_, failure))) => Err(failure),
            (Outcome::Finished, None) => Ok(results.into_iter().flatten().collect()),
        }
    }
}
