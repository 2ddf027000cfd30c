//! The probability of the unstable side of a verdict map, by integration over it.

use super::integral::{BOUNDS, PROBABILITY, UPPER_BOUNDS, WITHOUT_VERDICTS};
use crate::job::diagnosis::Complaint;
use crate::job::method::{Answer, Computed, MapUse, Method, Sampling};
use crate::job::needs::Need;
use crate::job::sampling_key::Key;
use crate::job::sampling_spec::{SamplingMethod, SamplingSpec};

/// See [`Method`].
#[derive(Debug)]
pub struct MapIntegral;

impl Method for MapIntegral {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::Exact
    }

    fn asked(&self) -> &'static str {
        "method = \"exact\""
    }

    fn clause(&self) -> &'static str {
        "which integrates over a verdict map and draws no samples"
    }

    fn keys(&self) -> &'static [Key] {
        &[Key::Audit, Key::Confidence, Key::Simultaneous, Key::Derivatives]
    }

    fn needs(&self) -> &'static [Need] {
        &[Need::Pair, Need::PairAlone, Need::IndependentNormal, Need::NoAmplitude]
    }

    fn instead(&self) -> &'static str {
        "use method = \"monte-carlo\" or \"sobol\" with evaluate = \"each\" (or criterion.kind = \"eigenvalue\", which needs no verdict map)"
    }

    fn answer(&self) -> Answer {
        Answer::Integral
    }

    fn map_use(&self) -> MapUse {
        MapUse::Integrate
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
        let undecided = match computed.undecided {
            0.0 => String::new(),
            undecided => format!("; up to {undecided:.1e} of a cell's samples would be undecided, see p_undecided"),
        };
        format!("integrated, error at most {:.1e}{undecided}", computed.error)
    }
}
