//! Scrambled Sobol points of all inputs but the pair of the model, over which it integrates at each of them.

use stickslip_sampler::draw::deviates::Points;

use crate::job::diagnosis::Complaint;
use crate::job::method::{Answer, Method};
use crate::job::needs::Need;
use crate::job::sampling_key::Key;
use crate::job::sampling_numbers::Effort;
use crate::job::sampling_spec::{SamplingMethod, SamplingSpec};

/// See [`Method`].
#[derive(Debug)]
pub struct Conditional;

impl Method for Conditional {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::Conditional
    }

    fn clause(&self) -> &'static str {
        "which integrates at each of its randomised Sobol points"
    }

    fn keys(&self) -> &'static [Key] {
        &[Key::Samples, Key::Audit, Key::Randomisations, Key::CommonRandomNumbers, Key::Confidence, Key::Simultaneous]
    }

    fn needs(&self) -> &'static [Need] {
        &[Need::ClosedForm, Need::OneOfPair, Need::Others, Need::SeparatePair, Need::NothingRecorded]
    }

    fn instead(&self) -> &'static str {
        "use method = \"sobol\""
    }

    fn answer(&self) -> Answer {
        Answer::Probability
    }

    fn points(&self) -> Points {
        Points::Sobol
    }

    fn effort(&self, spec: &SamplingSpec, samples: u64) -> Result<Effort, Complaint> {
        spec.shared_by_randomisations(samples, 2)
    }

    fn probability(&self) -> &'static str {
        "probability of instability, the mean of the conditional probabilities of the samples"
    }

    fn counts(&self, pair: &str) -> Vec<(&'static str, String)> {
        vec![
            ("n_samples", format!("samples of the inputs other than {pair}")),
            ("n_stable", format!("samples that are unstable with a probability of at most one half over {pair}")),
            ("n_unstable", format!("samples that are unstable with a probability above one half over {pair}")),
            ("n_undecided", "samples whose critical values leave their probability open".to_owned()),
            ("n_failed", "samples with a value that is not admissible".to_owned()),
        ]
    }

    fn without_verdicts(&self, pair: &str) -> Option<String> {
        Some(format!(
            "this run integrates over {pair} at each of its samples (method = \"conditional\"), so they have no verdicts to replay or to write; submit the job with method = \"sobol\" into another directory to look at samples"
        ))
    }
}
