//! Independent samples until the interval of the cell is narrow enough, with looks from time to time.

use crate::job::method::{Computed, MapUse, Method, Sampling};
use crate::job::sampling_key::Key;
use crate::job::sampling_spec::SamplingMethod;
use crate::output::{HumanCount128, counted};

/// See [`Method`].
#[derive(Debug)]
pub struct Until;

impl Method for Until {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::MonteCarlo
    }

    fn asked(&self) -> String {
        "sampling.until".to_owned()
    }

    fn clause(&self) -> &'static str {
        "which stops by precision (until = { ..., confidence = ..., at_most = ... })"
    }

    fn keys(&self) -> &'static [Key] {
        &[Key::Until, Key::Evaluate, Key::Audit, Key::CommonRandomNumbers, Key::Simultaneous, Key::Derivatives]
    }

    fn map_use(&self) -> MapUse {
        MapUse::LookUp
    }

    fn without_limits(&self) -> Option<&'static str> {
        Some(
            "limits are found with the same number of samples at all values; give sampling.samples in place of sampling.until",
        )
    }

    fn probability(&self) -> &'static str {
        "probability of instability, the unbiased estimate of stopping by precision"
    }

    fn closing(&self, sampling: &Sampling, computed: &Computed) -> String {
        format!(
            "{} in all, at most {} each, seed {}",
            counted(computed.samples, "sample", "samples"),
            HumanCount128(sampling.samples.into()),
            sampling.seed
        )
    }
}
