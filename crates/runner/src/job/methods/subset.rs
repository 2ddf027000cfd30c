//! Populations of samples that are led to rare events step by step (subset simulation).

use super::importance;
use crate::job::diagnosis::Complaint;
use crate::job::method::{Answer, Computed, Method, Sampling};
use crate::job::needs::Need;
use crate::job::sampling_key::Key;
use crate::job::sampling_numbers::Effort;
use crate::job::sampling_spec::{SamplingMethod, SamplingSpec};
use crate::output::counted;

/// See [`Method`].
#[derive(Debug)]
pub struct Subset;

impl Method for Subset {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::Subset
    }

    fn clause(&self) -> &'static str {
        "which draws populations (sampling.particles is the size of one, sampling.randomisations their number)"
    }

    fn keys(&self) -> &'static [Key] {
        &[Key::Audit, Key::Randomisations, Key::Particles, Key::CommonRandomNumbers, Key::Confidence, Key::Simultaneous]
    }

    fn needs(&self) -> &'static [Need] {
        &importance::NEEDS
    }

    fn instead(&self) -> &'static str {
        importance::INSTEAD
    }

    fn answer(&self) -> Answer {
        Answer::Population
    }

    fn samples(&self, spec: &SamplingSpec) -> Result<u64, Complaint> {
        Ok(spec.randomisations())
    }

    fn effort(&self, spec: &SamplingSpec, samples: u64) -> Result<Effort, Complaint> {
        spec.shared_by_randomisations(samples, 2)
    }

    fn particles(&self) -> Option<u64> {
        Some(1000)
    }

    fn decisions(&self, samples: u64, particles: u64) -> u64 {
        samples.saturating_mul(particles)
    }

    fn moves(&self) -> usize {
        8
    }

    fn without_limits(&self) -> Option<&'static str> {
        Some(
            "populations of sampling.method = \"subset\" differ from value to value, so that they have no limits; use \"importance\"",
        )
    }

    fn probability(&self) -> &'static str {
        importance::PROBABILITY
    }

    fn counts(&self, _: &str) -> Vec<(&'static str, String)> {
        [
            ("n_samples", "populations"),
            ("n_stable", "populations that found nothing unstable"),
            ("n_unstable", "populations that found something unstable"),
            ("n_undecided", "0"),
            ("n_failed", "0"),
        ]
        .map(|(column, meaning)| (column, meaning.to_owned()))
        .to_vec()
    }

    fn without_verdicts(&self, _: &str) -> Option<String> {
        Some(importance::WITHOUT_VERDICTS.to_owned())
    }

    fn more(&self) -> &'static str {
        "particles or randomisations"
    }

    fn closing(&self, sampling: &Sampling, computed: &Computed) -> String {
        format!(
            "{} each, {} in all, seed {}",
            counted(sampling.samples.into(), "population", "populations"),
            counted(computed.evaluations as u128, "verdict", "verdicts"),
            sampling.seed
        )
    }
}
