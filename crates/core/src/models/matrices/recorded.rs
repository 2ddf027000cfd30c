//! What can be recorded of samples: figures of their least stable pair.

use super::region::damping_ratio;
use crate::model::recorded::{RecordedOf, RecordedResult};
use crate::numerics::eigenvalues::Eigenvalue;

/// A figure of the least stable pair: of those in the bands, the one with the least damping ratio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum PairResult {
    /// The damping ratio, `-Re lambda / |lambda|`.
    DampingRatio,
    /// The growth rate, `Re lambda`.
    GrowthRate,
    /// The frequency, `Im lambda` in Hz.
    Frequency,
}

impl PairResult {
    /// Its description.
    #[must_use]
    pub fn described(self) -> RecordedResult {
        let (name, unit, noun) = match self {
            Self::DampingRatio => ("damping_ratio", "1", "damping ratio"),
            Self::GrowthRate => ("growth_rate", "1/s", "growth rate"),
            Self::Frequency => ("frequency", "Hz", "frequency"),
        };
        let meaning = "that of the least stable pair in the band";
        RecordedResult { name, unit, noun, meaning, of: RecordedOf::All, is_length: false, has_mean: true }
    }

    /// Its value for a pair with this eigenvalue, rad/s.
    #[must_use]
    pub fn value(self, eigenvalue: Eigenvalue) -> f64 {
        match self {
            Self::DampingRatio => damping_ratio(eigenvalue),
            Self::GrowthRate => eigenvalue.re,
            Self::Frequency => eigenvalue.im.abs() / std::f64::consts::TAU,
        }
    }
}
