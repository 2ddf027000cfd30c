//! What a method of finding probabilities is, and the sampling of a job, which has one.

use std::fmt::Debug;

use stickslip_sampler::draw::deviates::Points;
use stickslip_sampler::estimate::interval::IntervalKind;
use stickslip_sampler::estimate::looks::Precision;

use super::diagnosis::Complaint;
use super::needs::Need;
use super::sampling_key::Key;
use super::sampling_numbers::Effort;
use super::sampling_spec::{
    Audit, EvaluateMode, FEW_PLAIN_SAMPLES, IntervalSpec, LEAST_PLAIN_SAMPLES, MOST_PLAIN_SAMPLES, SamplingMethod,
    SamplingSpec,
};
use crate::output::counted;

/// What a method returns for a sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// Its verdict, which can be looked at again.
    Verdict,
    /// The probability of instability over the pair of the model, given the other inputs.
    Probability,
    /// A verdict or a probability with a weight: samples are drawn where instability is frequent.
    Weight,
    /// A probability of its own: it is a population that is led to instability.
    Population,
    /// Nothing: it draws no samples, and integrates.
    Integral,
}

impl Answer {
    /// Whether instability is looked for where it is rare.
    pub fn is_of_rare_events(self) -> bool {
        matches!(self, Self::Weight | Self::Population)
    }
}

/// What verdict maps are used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapUse {
    /// There are none.
    Nothing,
    /// Samples are looked up in them.
    LookUp,
    /// Probabilities are integrated over them.
    Integrate,
}

/// What was computed of all cells together, for the report of a run.
#[derive(Debug, Clone, Copy)]
pub struct Computed {
    /// Samples.
    pub samples: u128,
    /// Verdicts or probabilities, where samples have weights.
    pub evaluations: f64,
    /// The largest error of an integral.
    pub error: f64,
    /// The largest probability that a sample is undecided, where probabilities are integrated.
    pub undecided: f64,
}

/// How the probability of a cell is found.
pub trait Method: Debug + Send + Sync {
    /// Its name in job specs.
    fn written(&self) -> SamplingMethod;

    /// How it is asked for, in messages.
    fn asked(&self) -> String {
        format!("method = \"{}\"", self.written().name())
    }

    /// What it does, as the relative clause of a message.
    fn clause(&self) -> &'static str;

    /// The keys of `[sampling]` that have a meaning with it, beside `method` and `seed`.
    fn keys(&self) -> &'static [Key];

    /// What it needs of model and random inputs.
    fn needs(&self) -> &'static [Need] {
        &[]
    }

    /// What to do where a need is not met, as the end of a message.
    fn instead(&self) -> &'static str {
        "use method = \"monte-carlo\""
    }

    /// What it returns for a sample.
    fn answer(&self) -> Answer {
        Answer::Verdict
    }

    /// What its deviates are drawn from.
    fn points(&self) -> Points {
        Points::Random
    }

    /// What it uses verdict maps for, even if samples are not looked up.
    fn map_use(&self) -> MapUse {
        MapUse::Nothing
    }

    /// The largest number of samples in each cell.
    ///
    /// # Errors
    /// A number out of range.
    fn samples(&self, spec: &SamplingSpec) -> Result<u64, Complaint> {
        spec.checked_samples()
    }

    /// How the samples of a cell are counted.
    ///
    /// # Errors
    /// Numbers that do not fit each other.
    fn effort(&self, spec: &SamplingSpec, samples: u64) -> Result<Effort, Complaint> {
        let _ = spec;
        Ok(Effort::Samples(samples))
    }

    /// Particles of a population by default, if it has populations.
    fn particles(&self) -> Option<u64> {
        None
    }

    /// Verdicts and integrals that the probability of a cell takes at least, with so many particles in a population.
    fn decisions(&self, samples: u64, particles: u64) -> u64 {
        let _ = particles;
        samples
    }

    /// Moves of each particle of a population.
    fn moves(&self) -> usize {
        0
    }

    /// Why limits cannot be found with it, and what would be right; `None` if they can.
    fn without_limits(&self) -> Option<&'static str> {
        None
    }

    /// What `p_unstable` is.
    fn probability(&self) -> &'static str {
        "probability of instability, unstable over decided samples"
    }

    /// The meanings of counts that differ from the usual ones, by column; `pair` is what the pair of the model is called.
    fn counts(&self, pair: &str) -> Vec<(&'static str, String)> {
        let _ = pair;
        Vec::new()
    }

    /// Why there are no verdicts on samples to look at again, and what has them.
    fn without_verdicts(&self, pair: &str) -> Option<String> {
        let _ = pair;
        None
    }

    /// What the intervals of its probabilities are.
    fn interval(&self, sampling: &Sampling) -> String {
        format!("{} % interval{}", percent(sampling), together(sampling))
    }

    /// What their upper ends are.
    fn upper_ends(&self, sampling: &Sampling) -> String {
        format!("upper ends of the {} % intervals{}", percent(sampling), together(sampling))
    }

    /// What to take more of where a probability is not to be trusted.
    fn more(&self) -> &'static str {
        "samples"
    }

    /// What was computed of each cell.
    fn closing(&self, sampling: &Sampling, computed: &Computed) -> String {
        let _ = computed;
        format!("{} each, seed {}", counted(sampling.samples.into(), "sample", "samples"), sampling.seed)
    }
}

impl dyn Method + '_ {
    /// Whether its probabilities may be checked by plain samples: they come neither from such nor from a verdict map, whose
    /// samples are looked up.
    pub fn has_plain_samples(&self) -> bool {
        self.answer() != Answer::Verdict && self.map_use() == MapUse::Nothing
    }

    /// How many plain samples check the probability of a cell by default: a tenth of the work that it takes itself, where
    /// that is more than the fewest.
    pub fn usual_plain_samples(&self, samples: u64, particles: Option<u64>, are_slow: bool) -> u64 {
        let least = if are_slow { FEW_PLAIN_SAMPLES } else { LEAST_PLAIN_SAMPLES };
        (self.decisions(samples, particles.unwrap_or(1)) / 10).clamp(least, MOST_PLAIN_SAMPLES)
    }

    /// Whether a key of `[sampling]` has a meaning with it.
    pub fn takes(&self, key: Key) -> bool {
        self.keys().contains(&key)
    }

    /// What it uses verdict maps for.
    pub fn map_use_with(&self, evaluate: EvaluateMode) -> MapUse {
        match self.map_use() {
            MapUse::LookUp if evaluate != EvaluateMode::Boundary => MapUse::Nothing,
            map_use => map_use,
        }
    }
}

/// The confidence of the intervals in percent, with at most six digits.
fn percent(sampling: &Sampling) -> f64 {
    let percent = 100.0 * sampling.confidence;
    format!("{percent:.5e}").parse().unwrap_or(percent)
}

fn together(sampling: &Sampling) -> &'static str {
    if sampling.simultaneous { " for all cells together" } else { "" }
}

/// The sampling of a job, checked.
#[derive(Debug, Clone)]
pub struct Sampling {
    /// How probabilities are found.
    pub method: &'static dyn Method,
    /// Samples in each cell (at most, with `until`; 0 for integrals).
    pub samples: u64,
    /// The precision that is wanted of each cell, with `until`.
    pub until: Option<Precision>,
    /// How they are shared.
    pub effort: Effort,
    /// Seed.
    pub seed: u64,
    /// How the verdicts of the samples are found.
    pub evaluate: EvaluateMode,
    /// Which looked-up samples are simulated as a check, or how many plain samples each probability has beside it.
    pub audit: Audit,
    /// The same where the spec does not say so.
    pub usual_audit: Audit,
    /// Particles of a population, where rare events are looked for.
    pub particles: Option<u64>,
    /// Whether cells share their deviates.
    pub common_random_numbers: bool,
    /// Confidence of the intervals.
    pub confidence: f64,
    /// Which interval, if the spec says so.
    pub interval: Option<IntervalSpec>,
    /// Whether the intervals hold together.
    pub simultaneous: bool,
    /// Whether verdicts are looked up in a map that is audited.
    pub is_audited: bool,
    /// Whether derivatives are wanted.
    pub derivatives: bool,
    /// Whether Sobol indices are wanted.
    pub sensitivity: bool,
}

impl Sampling {
    /// Which interval counted verdicts get at a confidence.
    pub fn interval_kind(&self, confidence: f64) -> IntervalKind {
        match (IntervalKind::for_confidence(confidence), self.interval) {
            (IntervalKind::Wilson, Some(interval)) if !self.simultaneous => interval.into(),
            (IntervalKind::Wilson, None) if !self.simultaneous => IntervalKind::Wilson,
            _ => IntervalKind::ClopperPearson,
        }
    }

    /// Whether plain samples are drawn beside each probability, as it does not come from such.
    pub fn has_plain_samples(&self) -> bool {
        self.method.has_plain_samples() && !self.audit.is_nothing()
    }

    /// Parts of a cell that are counted apart: how many samples each has at most.
    pub fn parts(&self) -> Vec<u64> {
        match &self.effort {
            Effort::Samples(samples) => vec![*samples],
            Effort::Randomisations { count, points } => vec![*points; *count as usize],
            Effort::Until(looks) => {
                let ends = looks.ends();
                (0..ends.len()).map(|i| ends[i] - if i == 0 { 0 } else { ends[i - 1] }).collect()
            }
        }
    }
}
