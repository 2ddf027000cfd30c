//! The probability of the unstable side of the boundary of stability, by integration: in closed form, over a verdict
//! map, or between critical values.

use crate::job::diagnosis::Complaint;
use crate::job::method::{Answer, Computed, MapUse, Method, Sampling};
use crate::job::needs::Need;
use crate::job::sampling_key::Key;
use crate::job::sampling_spec::{SamplingMethod, SamplingSpec};

/// What the boundary is known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// A closed form, over the pair of the model.
    ClosedForm,
    /// A verdict map over the pair, of which samples are audited.
    Map,
    /// Critical values of the one random input.
    OneInput,
}

/// See [`Method`].
#[derive(Debug)]
pub struct Integral {
    /// What the boundary is known from.
    pub over: Over,
}

impl Method for Integral {
    fn written(&self) -> SamplingMethod {
        SamplingMethod::Exact
    }

    fn clause(&self) -> &'static str {
        match self.over {
            Over::ClosedForm => "which draws no samples and integrates in closed form",
            Over::Map => "which draws no samples",
            Over::OneInput => "which draws no samples and integrates between critical values",
        }
    }

    fn keys(&self) -> &'static [Key] {
        match self.over {
            Over::ClosedForm => &[Key::Audit, Key::Derivatives],
            Over::Map => &[Key::Audit, Key::Confidence, Key::Simultaneous, Key::Derivatives],
            Over::OneInput => &[Key::Audit],
        }
    }

    fn needs(&self) -> &'static [Need] {
        match self.over {
            Over::ClosedForm => &[Need::Pair, Need::PairAlone],
            Over::Map => &[Need::Pair, Need::PairAlone, Need::NormalOverMap, Need::NothingRecorded],
            Over::OneInput => &[Need::OneInput, Need::NothingRecorded],
        }
    }

    fn instead(&self) -> &'static str {
        match self.over {
            Over::OneInput => "use method = \"conditional\", which draws the others",
            Over::ClosedForm | Over::Map => "use method = \"monte-carlo\" or \"sobol\" with evaluate = \"each\"",
        }
    }

    fn answer(&self) -> Answer {
        Answer::Integral
    }

    fn map_use(&self) -> MapUse {
        if self.over == Over::Map { MapUse::Integrate } else { MapUse::Nothing }
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
