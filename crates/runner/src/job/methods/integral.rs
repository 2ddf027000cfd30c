//! The probability of the unstable side of the boundary of stability, by integration: in closed form, or over a verdict
//! map.

use crate::job::diagnosis::Complaint;
use crate::job::method::{Answer, Computed, MapUse, Method, Sampling};
use crate::job::needs::Need;
use crate::job::sampling_key::Key;
use crate::job::sampling_spec::{SamplingMethod, SamplingSpec};

/// See [`Method`].
#[derive(Debug)]
pub struct Integral {
    /// Whether the boundary is that of a verdict map, of which samples are audited.
    pub over_map: bool,
}

impl Method for Integral {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::Exact
    }

    fn clause(&self) -> &'static str {
        if self.over_map { "which draws no samples" } else { "which draws no samples and integrates in closed form" }
    }

    fn keys(&self) -> &'static [Key] {
        if self.over_map {
            &[Key::Audit, Key::Confidence, Key::Simultaneous, Key::Derivatives]
        } else {
            &[Key::Derivatives]
        }
    }

    fn needs(&self) -> &'static [Need] {
        if self.over_map {
            &[Need::Pair, Need::PairAlone, Need::NormalOverMap, Need::NoAmplitude]
        } else {
            &[Need::Pair, Need::PairAlone]
        }
    }

    fn instead(&self) -> &'static str {
        "use method = \"monte-carlo\" or \"sobol\" with evaluate = \"each\""
    }

    fn answer(&self) -> Answer {
        Answer::Integral
    }

    fn map_use(&self) -> MapUse {
        if self.over_map { MapUse::Integrate } else { MapUse::Nothing }
    }

    fn samples(&self, _: &SamplingSpec) -> Result<u64, Complaint> {
        Ok(0)
    }

    fn probability(&self) -> &'static str {
        "probability of instability, the integral"
    }

    fn without_verdicts(&self, _: &str) -> Option<String> {
        Some("this run integrates its probabilities; it has no samples to replay or to write".to_owned())
    }

    fn interval(&self, _: &Sampling) -> String {
        "bounds of the integral".to_owned()
    }

    fn upper_ends(&self, _: &Sampling) -> String {
        "upper bounds of the integral".to_owned()
    }

    fn closing(&self, _: &Sampling, computed: &Computed) -> String {
        let undecided = match computed.undecided {
            0.0 => String::new(),
            undecided => format!("; up to {undecided:.1e} of a cell's samples would be undecided, see p_undecided"),
        };
        format!("integrated, error at most {:.1e}{undecided}", computed.error)
    }
}
