//! What needs a word: samples outside the model, undecided ones and failed ones, unstable ones without a settled
//! amplitude, and cells without a probability.

use indicatif::HumanCount;
use stickslip_core::model::recorded::RecordedOf;

use crate::job::{Job, OutsidePhysics};
use crate::output::counted;
use crate::tables::row::CONTRADICTED;

/// How many samples of a run lie outside the model, are undecided, and failed, and how many of its cells have no
/// probability.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Exceptions {
    samples: u128,
    undecided: u64,
    failed: u64,
    outside: u64,
    /// The largest share of a cell's samples that is outside the model.
    outside_of_a_cell: f64,
    /// How many unstable samples have no result that is recorded of unstable ones.
    unsettled: u64,
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

    /// Adds the unstable samples of a cell whose motion had not settled.
    pub fn add_unsettled(&mut self, samples: u64) {
        self.unsettled += samples;
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
        let of_samples =
            self.outside_the_model(job).into_iter().chain(self.without_verdict()).chain(self.not_settled(job));
        of_samples.chain(self.without_probability(job)).collect()
    }

    /// Why cells have no probability, by reason.
    fn without_probability(&self, job: &Job) -> Vec<String> {
        let cells = |count: u64| counted(count.into(), "cell", "cells");
        let with_counts = reasons(job).into_iter().zip(self.distrusted).filter(|(_, count)| *count > 0);
        with_counts.map(|(why, count)| format!("p_unstable is null in {}: {why}", cells(count))).collect()
    }

    fn outside_the_model(&self, job: &Job) -> Option<String> {
        let one_or_more = |one, more| if self.outside == 1 { one } else { more };
        let of_a_cell = match job.cells() {
            1 => String::new(),
            _ => format!(", in one cell up to {}", share(self.outside_of_a_cell)),
        };
        (self.outside > 0).then(|| {
            format!(
                "{} ({}{of_a_cell}) {} outside the model: {}; {}",
                counted(self.outside.into(), "sample", "samples"),
                share(self.outside as f64 / self.samples as f64),
                one_or_more("lies", "lie"),
                job.model().outside_meaning(),
                match job.outside_physics {
                    OutsidePhysics::Stable if !job.model().sources().is_empty() => one_or_more(
                        "it is decided as it is, see criterion.outside_physics",
                        "they are decided as they are, see criterion.outside_physics",
                    ),
                    OutsidePhysics::Stable => one_or_more(
                        "it counts as stable, see criterion.outside_physics",
                        "they count as stable, see criterion.outside_physics",
                    ),
                    OutsidePhysics::Failed => one_or_more("it counts as failed", "they count as failed"),
                    OutsidePhysics::Clamp => one_or_more("it is moved to its edge", "they are moved to its edge"),
                }
            )
        })
    }

    fn not_settled(&self, job: &Job) -> Option<String> {
        let result = job.model().recorded().iter().find(|result| result.of == RecordedOf::Unstable)?;
        (self.unsettled > 0).then(|| {
            format!(
                "{} no {} at the horizon; its mean and quantiles leave {} out",
                counted(self.unsettled.into(), "unstable sample has", "unstable samples have"),
                result.noun,
                if self.unsettled == 1 { "it" } else { "them" }
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

/// Why a probability with this value in its column `distrust` is not to be trusted; none if nothing speaks against it.
pub fn reason(job: &Job, distrust: u64) -> Option<String> {
    reasons(job).into_iter().nth(usize::try_from(distrust.checked_sub(1)?).ok()?)
}

/// Why probabilities are not to be trusted, by the column `distrust` less one.
fn reasons(job: &Job) -> [String; 6] {
    let more = job.sampling.method.more();
    [
        "no unstable sample was found, even with a larger scatter (or no stable one, where instability is frequent)"
            .to_owned(),
        format!("few samples have most of the probability; take more {more}"),
        format!("independent populations disagree, so some have missed a region; take more {more}"),
        "samples without a verdict are more probable than unstable ones, so that the populations say little".to_owned(),
        "plain samples contradict p_low to p_high (n_audit and n_audit_unstable)".to_owned(),
        "critical values leave too much open between p_low and p_high".to_owned(),
    ]
}

/// A share above 0 in per cent.
pub fn share(share: f64) -> String {
    match 100.0 * share {
        percent if percent < 0.01 => "less than 0.01 %".to_owned(),
        percent => format!("{percent:.2} %"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::JobSource;

    /// What is said of so many samples outside the model in each of some cells of 100,000.
    fn said(outside: &[u64]) -> Vec<String> {
        let preloads: Vec<String> = (1..=outside.len()).map(|i| format!("0.{i}")).collect();
        let text = format!(
            "name = \"outside\"\n[axes]\nrotating_speed = 15.0\npreload = [{}]\nstatic_friction = 0.4\n[random]\ninputs = [\"preload\"]\nrelative_std = 0.2\n[criterion]\nkind = \"eigenvalue\"\n[sampling]\nsamples = 100000\nseed = 1\n",
            preloads.join(", ")
        );
        let job = JobSource { path: "job.toml".into(), text }.job().unwrap();
        let mut exceptions = Exceptions::default();
        outside.iter().for_each(|&outside| exceptions.add(100_000, 0, 0, outside));
        exceptions.sentences(&job)
    }

    #[test]
    fn a_single_sample_is_no_share_of_zero() {
        let meaning = "preload at or below 0, or f_s < f_c";
        assert!(said(&[0]).is_empty());
        assert_eq!(
            said(&[1]),
            [format!(
                "1 sample (less than 0.01 %) lies outside the model: {meaning}; it counts as stable, see criterion.outside_physics"
            )]
        );
        assert_eq!(
            said(&[1, 1200]),
            [format!(
                "1,201 samples (0.60 %, in one cell up to 1.20 %) lie outside the model: {meaning}; they count as stable, see criterion.outside_physics"
            )]
        );
    }
}
