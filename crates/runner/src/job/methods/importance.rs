//! Scrambled Sobol points of a density that is found for each cell, with weights, for rare events.

use stickslip_sampler::draw::deviates::Points;

use crate::job::diagnosis::Complaint;
use crate::job::method::{Answer, Method};
use crate::job::needs::Need;
use crate::job::sampling_key::Key;
use crate::job::sampling_numbers::Effort;
use crate::job::sampling_spec::{SamplingMethod, SamplingSpec};

/// Largest number of random inputs of samples with weights: one Sobol number chooses the density.
const MOST_INPUTS: usize = 31;

/// Randomisations at least: populations are compared, each of which has four.
const LEAST_RANDOMISATIONS: u64 = 8;

/// What methods for rare events need.
pub const NEEDS: [Need; 3] = [Need::Inputs(MOST_INPUTS), Need::Scatter, Need::NothingRecorded];

/// What is done where they cannot be used.
pub const INSTEAD: &str = "use method = \"monte-carlo\" or \"sobol\"";

/// Why their samples cannot be looked at.
pub const WITHOUT_VERDICTS: &str = "the samples of this run are drawn where instability is frequent, and have weights (method = \"importance\" or \"subset\"); submit the job with method = \"monte-carlo\" into another directory to look at samples";

/// What their probability is.
pub const PROBABILITY: &str =
    "probability of instability, the mean of samples with weights; null where distrust says why";

/// See [`Method`].
#[derive(Debug)]
pub struct Importance;

impl Method for Importance {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::Importance
    }

    fn clause(&self) -> &'static str {
        "which draws randomised Sobol points with weights"
    }

    fn keys(&self) -> &'static [Key] {
        &[
            Key::Samples,
            Key::Audit,
            Key::Randomisations,
            Key::Particles,
            Key::CommonRandomNumbers,
            Key::Confidence,
            Key::Simultaneous,
        ]
    }

    fn needs(&self) -> &'static [Need] {
        &NEEDS
    }

    fn instead(&self) -> &'static str {
        INSTEAD
    }

    fn answer(&self) -> Answer {
        Answer::Weight
    }

    fn points(&self) -> Points {
        Points::Sobol
    }

    fn effort(&self, spec: &SamplingSpec, samples: u64) -> Result<Effort, Complaint> {
        spec.shared_by_randomisations(samples, LEAST_RANDOMISATIONS)
    }

    fn particles(&self) -> Option<u64> {
        Some(300)
    }

    fn moves(&self) -> usize {
        4
    }

    fn probability(&self) -> &'static str {
        PROBABILITY
    }

    fn counts(&self, _: &str) -> Vec<(&'static str, String)> {
        [
            ("n_samples", "samples, drawn where instability is frequent"),
            ("n_stable", "of these, samples decided as stable, or unstable with a probability of at most one half"),
            ("n_unstable", "of these, samples decided as unstable, or unstable with a probability above one half"),
            ("n_undecided", "of these, samples without a certain verdict"),
            ("n_failed", "0; failed samples are counted as undecided"),
        ]
        .map(|(column, meaning)| (column, meaning.to_owned()))
        .to_vec()
    }

    fn without_verdicts(&self, _: &str) -> Option<String> {
        Some(WITHOUT_VERDICTS.to_owned())
    }

    fn more(&self) -> &'static str {
        "samples or particles"
    }
}
