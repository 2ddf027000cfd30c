//! How the probabilities of a job are found: its sampling keys, checked.

use stickslip_core::model::Model;
use stickslip_sampler::estimate::audit;
use stickslip_sampler::estimate::interval::IntervalKind;
use stickslip_sampler::estimate::interval::half_of_the_error;
use stickslip_sampler::estimate::looks::{Looks, Precision};
use toml::Spanned;

use super::diagnosis::{Complaint, Complaints};
use super::model::JobModel;
use super::random::RandomInputSet;
use super::sampling_spec::{AUDIT, Audit, EvaluateMode, IntervalSpec, SamplingMethod, SamplingSpec};

/// Samples in one cell by default.
const SAMPLES: u64 = 10_000;

/// Largest number of samples in one cell.
const MOST_SAMPLES: u64 = 1_000_000_000_000_000;

/// Independent randomisations of Sobol points by default, and at most.
const RANDOMISATIONS: u64 = 16;
const MOST_RANDOMISATIONS: u64 = 1000;

/// Particles of a population by default, that of samples and that of subsets, and their range.
const PARTICLES: [u64; 2] = [300, 1000];
const PARTICLES_RANGE: [u64; 2] = [50, 100_000];

/// Largest number of random inputs of samples with weights: one Sobol number chooses the density.
const MOST_WEIGHTED_INPUTS: usize = 31;

/// Largest number of points of one randomisation: Sobol numbers of 32 bits.
const MOST_SOBOL_POINTS: u64 = 1 << 32;

/// How many samples a cell gets, and which of them are counted apart.
#[derive(Debug, Clone, PartialEq)]
pub enum Effort {
    /// So many, counted together.
    Samples(u64),
    /// Randomisations of so many Sobol points each, counted apart.
    Randomisations {
        /// How many.
        count: u64,
        /// Points of each.
        points: u64,
    },
    /// Until the interval is narrow enough, looking from time to time; the samples between two looks are counted apart.
    Until(Looks),
    /// None: integrated.
    Integrated,
}

/// The sampling of a job, checked.
#[derive(Debug, Clone)]
pub struct Sampling {
    /// How probabilities are found.
    pub method: SamplingMethod,
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
    /// Which looked-up samples are simulated as a check.
    pub audit: Audit,
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
    /// Checks every key, and that they fit each other, the inputs and the criterion. `None` if anything is refused, or
    /// without inputs and criterion.
    pub fn validate(
        spec: &SamplingSpec,
        others: Option<(&RandomInputSet, &dyn JobModel)>,
        has_closed_form: Option<bool>,
        cells: Option<u64>,
        complaints: &mut Complaints,
    ) -> Option<Self> {
        let before = complaints.len();
        let is_eigenvalue = has_closed_form == Some(true);
        let cells = cells.unwrap_or(1);
        // Which keys have a meaning depends on these two.
        if !["method", "evaluate"].iter().any(|key| complaints.has_unread(&["sampling", key])) {
            spec.refuse_foreign_keys(is_eigenvalue, complaints);
        }
        let confidence = complaints.take(spec.checked_confidence(cells));
        let samples = complaints.take(spec.checked_samples());
        let audit = complaints.take(spec.checked_audit(is_eigenvalue));
        let until = complaints.take(spec.precision());
        if complaints.len() > before || complaints.has_unread(&["sampling"]) {
            return None;
        }
        let sampling = spec.resolved(confidence?, samples?, audit?, until?, is_eigenvalue, cells);
        let sampling = complaints.take(sampling)?;
        let (inputs, model) = others?;
        complaints.take(sampling.check_against(spec, inputs, model.model())).map(|()| sampling)
    }

    /// What the methods need of the inputs and the criterion.
    fn check_against(&self, spec: &SamplingSpec, inputs: &RandomInputSet, model: &dyn Model) -> Result<(), Complaint> {
        let method = spec.method.as_ref().map(Spanned::span);
        let evaluate = spec.evaluate.as_ref().map(Spanned::span).or(method.clone());
        let complain = |span, message: String| Err(Complaint::maybe_at(span, message));
        let uses_map = self.evaluate == EvaluateMode::Boundary || self.method == SamplingMethod::Exact;
        let asked = if self.method == SamplingMethod::Exact { "method = \"exact\"" } else { "evaluate = \"boundary\"" };
        if uses_map && model.pair().is_none() {
            return complain(
                evaluate,
                format!(
                    "sampling.{asked} knows the boundary as a curve over a pair of quantities, and this model has no such pair. Use method = \"monte-carlo\" or \"sobol\" with evaluate = \"each\""
                ),
            );
        }
        if uses_map && let Some(other) = inputs.other() {
            return complain(
                evaluate,
                format!(
                    "sampling.{asked} knows the boundary as a curve over {}; random.inputs also lists {}. Use method = \"monte-carlo\" or \"sobol\" with evaluate = \"each\"",
                    pair_names(model),
                    model.quantities()[other].name
                ),
            );
        }
        let is_closed = model.has_closed_form();
        if self.method == SamplingMethod::Exact && !is_closed && !inputs.is_plain() {
            return complain(
                method,
                "sampling.method = \"exact\" integrates independent normal inputs over a verdict map; for other distributions or correlation use criterion.kind = \"eigenvalue\", or method = \"monte-carlo\" or \"sobol\"".to_owned(),
            );
        }
        if self.method == SamplingMethod::Conditional {
            self.check_conditional(spec, inputs, model)?;
        }
        if self.particles.is_some() {
            self.check_weighted(spec, inputs, model)?;
        }
        if uses_map && model.records_amplitude() {
            return complain(
                evaluate,
                format!(
                    "sampling.{asked} looks samples up, and these have no amplitude; remove criterion.record, or use evaluate = \"each\""
                ),
            );
        }
        if self.derivatives && model.pair().is_none() {
            return complain(
                spec.derivatives.as_ref().map(Spanned::span),
                "sampling.derivatives are those by the law of a pair of quantities, and this model has no such pair; remove it, or use sampling.sensitivity".to_owned(),
            );
        }
        if self.derivatives && !inputs.is_plain() {
            return complain(
                spec.derivatives.as_ref().map(Spanned::span),
                "sampling.derivatives are those of independent normal inputs; remove it, or random.distribution and random.correlation".to_owned(),
            );
        }
        let sensitivity = spec.sensitivity.as_ref().map(Spanned::span);
        if self.sensitivity && (self.method != SamplingMethod::MonteCarlo || spec.until.is_some()) {
            return complain(
                sensitivity,
                "sampling.sensitivity needs method = \"monte-carlo\" with a number of samples".to_owned(),
            );
        }
        if self.sensitivity && (inputs.inputs.len() < 2 || !inputs.correlation.is_independent()) {
            return complain(
                sensitivity,
                "sampling.sensitivity splits the variance among independent inputs: it needs two or more of them, without random.correlation".to_owned(),
            );
        }
        Ok(())
    }

    /// What integration over preload and static friction needs at every sample of the other inputs.
    fn check_conditional(
        &self,
        spec: &SamplingSpec,
        inputs: &RandomInputSet,
        model: &dyn Model,
    ) -> Result<(), Complaint> {
        let at_method = |message: &str| {
            Err(Complaint::maybe_at(
                spec.method.as_ref().map(Spanned::span),
                format!("sampling.method = \"conditional\" {message}"),
            ))
        };
        let pair = pair_names(model);
        if !model.has_closed_form() {
            return at_method(&format!(
                "integrates over {pair} where the boundary of stability is known in closed form: with criterion.kind = \"eigenvalue\". For this criterion use method = \"sobol\", or with no further random inputs \"exact\""
            ));
        }
        if inputs.pair() == [None, None] {
            return at_method(&format!(
                "integrates over {pair}, and random.inputs lists neither; use method = \"sobol\""
            ));
        }
        if inputs.others().is_empty() {
            return at_method(&format!(
                "draws the inputs other than {pair}, and random.inputs lists none; method = \"exact\" integrates over these two without samples"
            ));
        }
        if let Err(error) = inputs.correlation_with_pair_last() {
            return at_method(&format!(
                "cannot separate these inputs: {error}; lower the coefficients of random.correlation, or use method = \"sobol\""
            ));
        }
        if self.derivatives {
            return Err(Complaint::maybe_at(
                spec.derivatives.as_ref().map(Spanned::span),
                "sampling.derivatives come from verdicts on samples, which method = \"conditional\" has none of; remove it, or use method = \"sobol\"".to_owned(),
            ));
        }
        Ok(())
    }

    /// What samples with weights need.
    fn check_weighted(&self, spec: &SamplingSpec, inputs: &RandomInputSet, model: &dyn Model) -> Result<(), Complaint> {
        let method = if self.method == SamplingMethod::Subset { "subset" } else { "importance" };
        let complain = |span, message: String| Err(Complaint::maybe_at(span, message));
        let at_method = spec.method.as_ref().map(Spanned::span);
        if inputs.inputs.is_empty() {
            return complain(
                at_method,
                format!(
                    "sampling.method = \"{method}\" draws random inputs, and random.inputs lists none; add some, for example inputs = [{}]",
                    example_inputs(model)
                ),
            );
        }
        if inputs.inputs.len() > MOST_WEIGHTED_INPUTS {
            return complain(
                at_method,
                format!(
                    "sampling.method = \"{method}\" takes at most {MOST_WEIGHTED_INPUTS} random inputs; random.inputs lists {}. Let fewer scatter, or use method = \"monte-carlo\"",
                    inputs.inputs.len()
                ),
            );
        }
        if inputs.scatters_nothing() {
            return complain(
                at_method,
                format!(
                    "sampling.method = \"{method}\" looks for rare events, and nothing scatters: all standard deviations of [random] are 0; give some above 0, or use method = \"monte-carlo\" with samples = 1"
                ),
            );
        }
        if model.records_amplitude() {
            return complain(
                at_method,
                format!(
                    "sampling.method = \"{method}\" records no amplitudes; remove criterion.record, or use method = \"monte-carlo\" or \"sobol\""
                ),
            );
        }
        if self.derivatives {
            return complain(
                spec.derivatives.as_ref().map(Spanned::span),
                format!(
                    "sampling.derivatives come from samples that count alike, and those of method = \"{method}\" have weights; remove it, or use method = \"sobol\" or \"exact\""
                ),
            );
        }
        Ok(())
    }

    /// Which interval counted verdicts get at a confidence.
    pub fn interval_kind(&self, confidence: f64) -> IntervalKind {
        match (IntervalKind::for_confidence(confidence), self.interval) {
            (IntervalKind::Wilson, Some(interval)) if !self.simultaneous => interval.into(),
            (IntervalKind::Wilson, None) if !self.simultaneous => IntervalKind::Wilson,
            _ => IntervalKind::ClopperPearson,
        }
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
            Effort::Integrated => vec![0],
        }
    }
}

/// The names of the pair of a model: "preload and static_friction".
fn pair_names(model: &dyn Model) -> String {
    let names = model.pair().map(|pair| pair.map(|place| model.quantities()[place].name.to_string()));
    names.map_or_else(|| "a pair of quantities".to_owned(), |names| names.join(" and "))
}

/// Inputs that a job may list.
fn example_inputs(model: &dyn Model) -> String {
    let names = model.quantities().iter().take(2).map(|quantity| format!("\"{}\"", quantity.name));
    names.collect::<Vec<_>>().join(", ")
}

impl SamplingSpec {
    /// Largest number of samples in each cell.
    fn checked_samples(&self) -> Result<u64, Complaint> {
        if self.method() == SamplingMethod::Exact {
            return Ok(0);
        }
        if self.method() == SamplingMethod::Subset {
            return Ok(self.randomisations.as_ref().map_or(RANDOMISATIONS, |count| *count.get_ref()));
        }
        let (key, samples, span) = match (&self.until, &self.samples) {
            (Some(until), _) => ("until.at_most", until.get_ref().at_most(), Some(until.span())),
            (None, Some(samples)) => ("samples", *samples.get_ref(), Some(samples.span())),
            (None, None) => ("samples", SAMPLES, None),
        };
        if (1..=MOST_SAMPLES).contains(&samples) {
            return Ok(samples);
        }
        let message =
            format!("sampling.{key} = {samples} is out of range: it must be at least 1 and at most {MOST_SAMPLES}");
        Err(Complaint::maybe_at(span, message))
    }

    /// The sampling that the keys ask for, each of which is checked.
    fn resolved(
        &self,
        confidence: f64,
        samples: u64,
        audit: Option<Audit>,
        until: Option<Precision>,
        is_eigenvalue: bool,
        cells: u64,
    ) -> Result<Sampling, Complaint> {
        let evaluate = self.evaluate.as_ref().map_or(EvaluateMode::Each, |evaluate| *evaluate.get_ref());
        let uses_map = evaluate == EvaluateMode::Boundary || self.method() == SamplingMethod::Exact;
        let is_audited = uses_map && !is_eigenvalue && !audit.unwrap_or(AUDIT).is_nothing();
        self.refuse_wilson_beyond_its_reach(confidence, is_audited)?;
        let of_a_cell = self.confidence_of_a_cell(confidence, cells);
        let for_counts = if is_audited { half_of_the_error(of_a_cell) } else { of_a_cell };
        let (audit, precision) = match until {
            Some(precision) if is_audited => {
                let (audit, precision) = self.share_precision(precision, audit, for_counts)?;
                (audit, Some(precision))
            }
            precision => (audit.unwrap_or(AUDIT), precision),
        };
        Ok(Sampling {
            method: self.method(),
            samples,
            until,
            effort: self.effort(samples, for_counts, precision)?,
            seed: self.seed.as_ref().map_or(0, |seed| *seed.get_ref()),
            evaluate,
            audit,
            particles: self.checked_particles()?,
            common_random_numbers: self.common_random_numbers,
            confidence,
            interval: self.interval.as_ref().map(|interval| *interval.get_ref()),
            simultaneous: self.is_simultaneous(),
            is_audited,
            derivatives: self.derivatives.as_ref().is_some_and(|derivatives| *derivatives.get_ref()),
            sensitivity: self.sensitivity.as_ref().is_some_and(|sensitivity| *sensitivity.get_ref()),
        })
    }

    /// Particles of a population; none where no rare events are looked for.
    fn checked_particles(&self) -> Result<Option<u64>, Complaint> {
        let default = match self.method() {
            SamplingMethod::Importance => PARTICLES[0],
            SamplingMethod::Subset => PARTICLES[1],
            _ => return Ok(None),
        };
        let particles = self.particles.as_ref().map_or(default, |particles| *particles.get_ref());
        let [least, most] = PARTICLES_RANGE;
        if (least..=most).contains(&particles) {
            return Ok(Some(particles));
        }
        let message = format!(
            "sampling.particles = {particles} is out of range: it must be at least {least} and at most {most}; {default} is usual"
        );
        Err(Complaint::maybe_at(self.particles.as_ref().map(Spanned::span), message))
    }

    /// Shares the half width that is wanted among the audit of a verdict map, of which no sample differs, and the
    /// counts: the audit that it takes, and what is left for the counts.
    fn share_precision(
        &self,
        precision: Precision,
        audit: Option<Audit>,
        confidence: f64,
    ) -> Result<(Audit, Precision), Complaint> {
        let complain = |message: String| Err(Complaint::maybe_at(self.until.as_ref().map(Spanned::span), message));
        let (Some(half_width), None) = (precision.half_width, precision.relative) else {
            return complain(
                "sampling.until.relative cannot be kept with a verdict map, whose audit leaves the same share open whatever the probability: use half_width, evaluate = \"each\", or audit = 0 (the map is then taken for right)".to_owned(),
            );
        };
        // The map may not tell some of the first samples.
        let open = |samples: u64| audit::upper_bound(0, samples - samples / 20, confidence);
        let wanted = |reach: f64| (libm::log(1.0 - confidence) / libm::log1p(-reach) / 0.95).ceil() as u64 + 2;
        let audit = match audit {
            Some(Audit::Share(_)) => {
                return complain(
                    "sampling.until needs to know how many samples are audited: give sampling.audit as a whole number of samples of each cell".to_owned(),
                );
            }
            Some(Audit::Samples(samples)) => samples,
            None => wanted(0.5 * half_width),
        };
        let left = half_width - open(audit);
        if left <= 0.1 * half_width {
            return complain(format!(
                "sampling.until.half_width = {half_width} cannot be reached with sampling.audit = {audit}, which leaves {:.2e} of the samples of a cell open: audit = {} leaves half of it, audit = 0 takes the verdict map for right",
                open(audit),
                wanted(0.5 * half_width)
            ));
        }
        Ok((Audit::Samples(audit), Precision { half_width: Some(left), relative: None }))
    }

    fn effort(&self, samples: u64, confidence: f64, precision: Option<Precision>) -> Result<Effort, Complaint> {
        match (self.method(), precision) {
            (SamplingMethod::Exact, _) => Ok(Effort::Integrated),
            (SamplingMethod::MonteCarlo, None) => Ok(Effort::Samples(samples)),
            (SamplingMethod::MonteCarlo, Some(precision)) => {
                Ok(Effort::Until(Looks::new(precision, samples, confidence)))
            }
            (
                SamplingMethod::Sobol
                | SamplingMethod::Conditional
                | SamplingMethod::Importance
                | SamplingMethod::Subset,
                _,
            ) => {
                let count = self.randomisations.as_ref().map_or(RANDOMISATIONS, |count| *count.get_ref());
                let span = self.randomisations.as_ref().map(Spanned::span);
                // Populations are compared, each of which has four randomisations.
                let least = if self.method() == SamplingMethod::Importance { 8 } else { 2 };
                if !(least..=MOST_RANDOMISATIONS).contains(&count) {
                    let message = format!(
                        "sampling.randomisations = {count} is out of range: it must be at least {least} and at most {MOST_RANDOMISATIONS}"
                    );
                    return Err(Complaint::maybe_at(span, message));
                }
                if samples / count > MOST_SOBOL_POINTS {
                    let message = format!(
                        "sampling.samples = {samples} are too many for {count} randomisations: each has at most 2^32 points, all together {}",
                        count * MOST_SOBOL_POINTS
                    );
                    return Err(Complaint::maybe_at(self.samples.as_ref().map(Spanned::span), message));
                }
                if !samples.is_multiple_of(count) {
                    let span = self.samples.as_ref().map(Spanned::span).or(span);
                    let near = (samples / count).max(1).next_power_of_two() * count;
                    let message = format!(
                        "sampling.samples = {samples} cannot be shared by {count} randomisations of equal size; powers of two are best, for example samples = {near}"
                    );
                    return Err(Complaint::maybe_at(span, message));
                }
                Ok(Effort::Randomisations { count, points: samples / count })
            }
        }
    }
}
