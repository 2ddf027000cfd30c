//! Samples of any model as those that the lanes simulate.

use crate::model;
use crate::model::decision::Decision;
use crate::models::pad_on_disc::lanes::queue::{QueuedSample, SampleQueue};

use super::configuration::{PadConfiguration, Prepared, queued};

/// The samples of a queue of any model.
pub(super) struct Motions<'s, 'q> {
    samples: &'s mut dyn model::SampleQueue<'q>,
    /// The values of the sample taken last.
    values: Vec<f64>,
}

impl<'s, 'q> Motions<'s, 'q> {
    pub(super) fn new(samples: &'s mut dyn model::SampleQueue<'q>) -> Self {
        Self { samples, values: Vec::new() }
    }
}

impl<'q> SampleQueue<'q> for Motions<'_, 'q> {
    fn next(&mut self) -> Option<QueuedSample<'q>> {
        loop {
            let model::QueuedSample { ticket, configuration, outline } = self.samples.next(&mut self.values)?;
            let prepared = PadConfiguration::from_any(configuration);
            let own = outline.as_deref().and_then(PadConfiguration::from_any).or(prepared);
            let queued = match (prepared.map(|configuration| &configuration.prepared), own) {
                (Some(Prepared::TimeDomain(criterion)), Some(own)) => queued(ticket, criterion, own, &self.values),
                _ => Err(Decision::FAILED),
            };
            match queued {
                Ok(queued) => return Some(queued),
                Err(decision) => self.samples.decided(ticket, decision),
            }
        }
    }

    fn decided(&mut self, ticket: u64, decision: Decision) {
        self.samples.decided(ticket, decision);
    }

    fn is_stopped(&self) -> bool {
        self.samples.is_stopped()
    }
}
