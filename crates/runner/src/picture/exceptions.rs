//! What needs a word: samples outside the model, undecided ones and failed ones, and cells without a probability.

use indicatif::HumanCount;

use crate::job::{Job, OutsidePhysics};
use crate::output::counted;
use crate::tables::row::CONTRADICTED;

/// How many samples of a run lie outside the model, are undecided, and failed, and how many of its cells have no probability.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Exceptions {
    samples: u128,
    undecided: u64,
    failed: u64,
    outside: u64,
    /// The largest share of a cell's samples that is outside the model.
    outside_of_a_cell: f64,
    /// In how many cells the probability is not to be trusted, by the column `distrust` less one.
    distrusted: [u64; 6],
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

    /// Adds a cell with this value in its column `distrust`; 0 if nothing speaks against its probability.
    pub fn add_distrust(&mut self, distrust: u64) {
        let reason = usize::try_from(distrust).ok().and_then(|reason| reason.checked_sub(1));
        if let Some(count) = reason.and_then(|reason| self.distrusted.get_mut(reason)) {
            *count += 1;
        }
    }

    /// The cells whose probability plain samples contradict.
    pub fn contradicted(&self) -> u64 {
        self.distrusted[CONTRADICTED as usize - 1]
    }

    /// A sentence for each kind there is, without a full stop.
    pub fn sentences(&self, job: &Job) -> Vec<String> {
        let of_samples = self.outside_the_model(job).into_iter().chain(self.without_verdict());
        of_samples.chain(self.without_probability(job)).collect()
    }

    /// Why cells have no probability, by reason.
    fn without_probability(&self, job: &Job) -> Vec<String> {
        let more = job.sampling.method.more();
        let reasons = [
            "no unstable sample was found, even with a larger scatter (or no stable one, where instability is frequent)"
                .to_owned(),
            format!("few samples have most of the probability; take more {more}"),
            format!("independent populations disagree, so some have missed a region; take more {more}"),
            "samples without a verdict are more probable than unstable ones, so that the populations say little".to_owned(),
            "plain samples contradict p_low to p_high (n_audit and n_audit_unstable)".to_owned(),
            "critical values leave too much open between p_low and p_high".to_owned(),
        ];
        let cells = |count: u64| counted(count.into(), "cell", "cells");
        let with_counts = reasons.into_iter().zip(self.distrusted).filter(|(_, count)| *count > 0);
        with_counts.map(|(why, count)| format!("p_unstable is null in {}: {why}", cells(count))).collect()
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
