//! Samples that need a word: those outside the model, undecided ones and failed ones.

use indicatif::HumanCount;

use crate::job::{Job, OutsidePhysics};
use crate::output::counted;

/// How many samples of a run lie outside the model, are undecided, and failed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Exceptions {
    samples: u128,
    undecided: u64,
    failed: u64,
    outside: u64,
    /// The largest share of a cell's samples that is outside the model.
    outside_of_a_cell: f64,
}

impl Exceptions {
    /// Adds the samples of a cell.
    pub fn add(&mut self, samples: u64, undecided: u64, failed: u64, outside: u64) {
        self.samples += u128::from(samples);
        self.undecided += undecided;
        self.failed += failed;
        self.outside += outside;
        self.outside_of_a_cell = self.outside_of_a_cell.max(outside as f64 / samples.max(1) as f64);
    }

    /// A sentence for each kind there is, without a full stop.
    pub fn sentences(&self, job: &Job) -> Vec<String> {
        self.outside_the_model(job).into_iter().chain(self.without_verdict()).collect()
    }

    fn outside_the_model(&self, job: &Job) -> Option<String> {
        let share = |share: f64| format!("{:.2} %", 100.0 * share);
        (self.outside > 0).then(|| {
            format!(
                "{} samples ({}, in one cell up to {}) lie outside the model: {}; {}",
                HumanCount(self.outside),
                share(self.outside as f64 / self.samples as f64),
                share(self.outside_of_a_cell),
                job.model().outside_meaning(),
                match job.outside_physics {
                    OutsidePhysics::Stable if !job.model().sources().is_empty() => {
                        "they are decided as they are, see criterion.outside_physics"
                    }
                    OutsidePhysics::Stable => "they count as stable, see criterion.outside_physics",
                    OutsidePhysics::Failed => "they count as failed",
                    OutsidePhysics::Clamp => "they are moved to its edge",
                }
            )
        })
    }

    fn without_verdict(&self) -> Option<String> {
        let Self { undecided, failed, .. } = *self;
        (undecided > 0 || failed > 0).then(|| {
            format!(
                "{} undecided, {} failed; p_low and p_high allow for either verdict on them",
                counted(undecided.into(), "sample", "samples"),
                HumanCount(failed)
            )
        })
    }
}
