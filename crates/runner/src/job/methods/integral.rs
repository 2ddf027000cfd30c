//! The probability of the unstable side of a boundary that is known in closed form, by integration.

use crate::job::diagnosis::Complaint;
use crate::job::method::{Answer, Computed, Method, Sampling};
use crate::job::needs::Need;
use crate::job::sampling_key::Key;
use crate::job::sampling_spec::{SamplingMethod, SamplingSpec};

/// Why there are no samples to look at.
pub const WITHOUT_VERDICTS: &str = "this run integrates its probabilities; it has no samples to replay or to write";

/// What the intervals are, and their upper ends.
pub const BOUNDS: &str = "bounds of the integral";
pub const UPPER_BOUNDS: &str = "upper bounds of the integral";

/// What the probability is.
pub const PROBABILITY: &str = "probability of instability, the integral";

/// See [`Method`].
#[derive(Debug)]
pub struct Integral;

impl Method for Integral {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::Exact
    }

    fn asked(&self) -> &'static str {
        "method = \"exact\""
    }

    fn clause(&self) -> &'static str {
        "which draws no samples, and bounds the numerical error by p_low and p_high where the boundary is known in closed form"
    }

    fn keys(&self) -> &'static [Key] {
        &[Key::Derivatives]
    }

    fn needs(&self) -> &'static [Need] {
        &[Need::Pair, Need::PairAlone, Need::NoAmplitude]
    }

    fn instead(&self) -> &'static str {
        "use method = \"monte-carlo\" or \"sobol\" with evaluate = \"each\""
    }

    fn answer(&self) -> Answer {
        Answer::Integral
    }

    fn samples(&self, _: &SamplingSpec) -> Result<u64, Complaint> {
        Ok(0)
    }

    fn probability(&self) -> &'static str {
        PROBABILITY
    }

    fn without_verdicts(&self, _: &str) -> Option<String> {
        Some(WITHOUT_VERDICTS.to_owned())
    }

    fn interval(&self, _: &Sampling) -> String {
        BOUNDS.to_owned()
    }

    fn upper_ends(&self, _: &Sampling) -> String {
        UPPER_BOUNDS.to_owned()
    }

    fn closing(&self, _: &Sampling, computed: &Computed) -> String {
        format!("integrated, error at most {:.1e}", computed.error)
    }
}
