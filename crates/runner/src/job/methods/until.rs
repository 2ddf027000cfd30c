//! Independent samples until the interval of the cell is narrow enough, with looks from time to time.

use super::keys::Key;
use super::{Computed, MapUse, Method};
use crate::job::limit::{LimitMethod, in_closed_form};
use crate::job::limit_axis::LimitAxis;
use crate::job::sampling::Sampling;
use crate::job::sampling_spec::SamplingMethod;
use crate::job::validated::Job;
use crate::output::{HumanCount128, counted};

/// See [`Method`].
#[derive(Debug)]
pub struct Until;

impl Method for Until {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::MonteCarlo
    }

    fn asked(&self) -> &'static str {
        "sampling.until"
    }

    fn clause(&self) -> &'static str {
        "which has at_most and confidence of its own (until = { ..., confidence = ..., at_most = ... }), and an interval that stays valid under repeated looks"
    }

    fn keys(&self) -> &'static [Key] {
        &[Key::Until, Key::Evaluate, Key::Audit, Key::CommonRandomNumbers, Key::Simultaneous, Key::Derivatives]
    }

    fn map_use(&self) -> MapUse {
        MapUse::LookUp
    }

    fn limits(&self, job: &Job, _: &LimitAxis) -> Result<LimitMethod, String> {
        in_closed_form(job)?;
        Err("limits are found with the same number of samples at all values; give sampling.samples in place of sampling.until".to_owned())
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
