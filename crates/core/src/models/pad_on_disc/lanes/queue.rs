//! Where samples come from, and where their decisions go.

use crate::model::decision::Decision;
use crate::models::pad_on_disc::criterion::time_domain::TimeDomain;
use crate::models::pad_on_disc::motion::start::Start;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// A sample to decide.
#[derive(Debug, Clone)]
pub struct QueuedSample<'q> {
    /// What the decision is returned with.
    pub ticket: u64,
    /// The criterion of its brake; or, if it has a brake of its own, one for a brake with the same disc model whose
    /// settings hold for it too.
    pub criterion: &'q TimeDomain,
    /// Its brake, if it is not the criterion's.
    pub brake: Option<PadOnDisc>,
    /// Its preload and static friction.
    pub inputs: RandomInputs,
    /// Where its motion starts. SI units are those of its own brake.
    pub start: Start,
}

impl<'q> QueuedSample<'q> {
    /// A sample of the criterion's brake that starts where the criterion's settings say.
    #[must_use]
    pub fn new(ticket: u64, criterion: &'q TimeDomain, inputs: RandomInputs) -> Self {
        Self { ticket, criterion, brake: None, inputs, start: criterion.start() }
    }

    /// Where its motion starts, in scaled units.
    pub(super) fn scaled_start(&self) -> Start {
        self.start.scaled(self.brake.as_ref().unwrap_or(&self.criterion.brake).scales())
    }

    /// Whether its motion meets a sliding speed at which there is no friction, see [`TimeDomain::meets_no_friction`].
    pub(crate) fn meets_no_friction(&self) -> bool {
        let Some(brake) = &self.brake else { return self.criterion.meets_no_friction_from(self.inputs, self.start) };
        let law = brake.friction_law().with_static(self.inputs.static_friction);
        let own = || self.criterion.with_brake(brake).ok();
        // Most have friction at every speed, and need nothing prepared.
        !law.without_friction().is_empty()
            && own().is_some_and(|criterion| criterion.meets_no_friction_from(self.inputs, self.start))
    }

    /// Its decision by the scalar code.
    #[must_use]
    pub fn decide(self) -> Decision {
        match self.brake {
            None => self.criterion.decide_from(self.inputs, self.start),
            Some(brake) => match self.criterion.with_brake(&brake) {
                Ok(criterion) => criterion.decide_from(self.inputs, self.start),
                Err(_) => Decision::FAILED,
            },
        }
    }
}

/// Samples to decide, in any order and from any cells and units of work.
pub trait SampleQueue<'q> {
    /// The next sample; `None` if there are no more.
    fn next(&mut self) -> Option<QueuedSample<'q>>;

    /// Receives the decision on the sample with this ticket. Samples are decided in any order.
    fn decided(&mut self, ticket: u64, decision: Decision);

    /// Whether to stop: samples that are not decided are dropped. It is asked about once a millisecond.
    fn is_stopped(&self) -> bool {
        false
    }
}
