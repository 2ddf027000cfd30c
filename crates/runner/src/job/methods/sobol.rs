//! Scrambled Sobol points.

use stickslip_sampler::draw::deviates::Points;

use crate::job::diagnosis::Complaint;
use crate::job::method::{MapUse, Method};
use crate::job::sampling_key::Key;
use crate::job::sampling_numbers::Effort;
use crate::job::sampling_spec::{SamplingMethod, SamplingSpec};

/// See [`Method`].
#[derive(Debug)]
pub struct Sobol;

impl Method for Sobol {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::Sobol
    }

    fn clause(&self) -> &'static str {
        "which draws randomised Sobol points"
    }

    fn keys(&self) -> &'static [Key] {
        &[
            Key::Samples,
            Key::Evaluate,
            Key::Audit,
            Key::Randomisations,
            Key::CommonRandomNumbers,
            Key::Confidence,
            Key::Simultaneous,
            Key::Derivatives,
        ]
    }

    fn points(&self) -> Points {
        Points::Sobol
    }

    fn map_use(&self) -> MapUse {
        MapUse::LookUp
    }

    fn effort(&self, spec: &SamplingSpec, samples: u64) -> Result<Effort, Complaint> {
        spec.shared_by_randomisations(samples, 2)
    }
}
