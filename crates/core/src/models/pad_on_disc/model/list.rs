//! Samples in a list, as the lanes simulate them.

use crate::model::IsStopped;
use crate::model::decision::Decision;
use crate::models::pad_on_disc::lanes::queue::{QueuedSample, SampleQueue};

/// Samples whose tickets are their places in a list.
pub(super) struct List<'s, I> {
    samples: I,
    is_stopped: IsStopped<'s>,
    decisions: Vec<Option<Decision>>,
}

impl<'s, 'q, I: Iterator<Item = Result<QueuedSample<'q>, Decision>>> List<'s, I> {
    pub(super) fn new(samples: I, is_stopped: IsStopped<'s>) -> Self {
        Self { samples, is_stopped, decisions: Vec::new() }
    }

    /// The decisions in the order of the list; `None` if samples were left when it was stopped.
    pub(super) fn decisions(mut self) -> Option<Vec<Decision>> {
        if self.samples.next().is_some() { None } else { self.decisions.into_iter().collect() }
    }
}

impl<'q, I: Iterator<Item = Result<QueuedSample<'q>, Decision>>> SampleQueue<'q> for List<'_, I> {
    fn next(&mut self) -> Option<QueuedSample<'q>> {
        while !self.is_stopped() {
            match self.samples.next()? {
                Ok(queued) => {
                    self.decisions.push(None);
                    return Some(queued);
                }
                Err(decision) => self.decisions.push(Some(decision)),
            }
        }
        None
    }

    fn decided(&mut self, ticket: u64, decision: Decision) {
        if let Some(place) = self.decisions.get_mut(ticket as usize) {
            *place = Some(decision);
        }
    }

    fn is_stopped(&self) -> bool {
        (self.is_stopped)()
    }
}
