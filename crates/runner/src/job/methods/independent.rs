//! Independent samples, so many of each cell.

use crate::job::method::{MapUse, Method};
use crate::job::sampling_key::Key;
use crate::job::sampling_spec::SamplingMethod;

/// See [`Method`].
#[derive(Debug)]
pub struct Independent;

impl Method for Independent {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::MonteCarlo
    }

    fn clause(&self) -> &'static str {
        "which draws independent samples"
    }

    fn keys(&self) -> &'static [Key] {
        &[
            Key::Samples,
            Key::Evaluate,
            Key::Audit,
            Key::CommonRandomNumbers,
            Key::Confidence,
            Key::Interval,
            Key::Simultaneous,
            Key::Derivatives,
            Key::Sensitivity,
        ]
    }

    fn map_use(&self) -> MapUse {
        MapUse::LookUp
    }
}
