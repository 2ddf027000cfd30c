//! How the probabilities of a job are found: its sampling keys, checked.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stickslip_sampler::interval::{MOST_WILSON_CONFIDENCE, half_of_the_error, simultaneous_confidence};
use stickslip_sampler::{IntervalKind, Looks, Precision, audit};
use toml::Spanned;

use super::criterion::Criterion;
use super::diagnosis::Complaint;
use super::random::RandomInputSet;

/// Samples in one cell at the most.
const MOST_SAMPLES: u64 = 1_000_000_000_000_000;

/// Independent randomisations of Sobol points unless told otherwise, and at the most.
const RANDOMISATIONS: u64 = 16;
const MOST_RANDOMISATIONS: u64 = 1000;

/// Samples of each cell that are looked up in a verdict map and simulated all the same, unless told otherwise.
const AUDIT: Audit = Audit::Samples(300);

/// Samples in a cell at the most with `until`, unless told otherwise.
const AT_MOST: u64 = 1_000_000;

/// Points of one randomisation at the most: Sobol numbers of 32 bits.
const MOST_SOBOL_POINTS: u64 = 1 << 32;

/// Audited samples in one cell at the most.
const MOST_AUDITED: u64 = 100_000_000;

/// Beyond, quantiles lose their meaning to rounding.
const HIGHEST_CONFIDENCE: f64 = 1.0 - 1e-12;

/// Sampling of the random inputs.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SamplingSpec {
    /// How probabilities are found; "monte-carlo" unless told.
    #[schemars(with = "Option<SamplingMethod>")]
    pub method: Option<Spanned<SamplingMethod>>,
    /// Samples in each cell, at least 1; 10000 unless told.
    #[schemars(with = "Option<u64>", range(min = 1))]
    pub samples: Option<Spanned<u64>>,
    /// Instead of `samples`: draw until the interval is narrow enough.
    #[schemars(with = "Option<UntilSpec>")]
    pub until: Option<Spanned<UntilSpec>>,
    /// Seed of the random numbers, 0 unless told. The same seed gives the same result on every machine.
    #[schemars(with = "Option<u64>")]
    pub seed: Option<Spanned<u64>>,
    /// Whether every sample is judged by itself ("each") or looked up in a map of the verdicts ("boundary").
    #[schemars(with = "Option<EvaluateMode>")]
    pub evaluate: Option<Spanned<EvaluateMode>>,
    /// With a verdict map: how many looked-up samples of each cell are simulated all the same (a whole number), or
    /// which share of them (less than 1, with evaluate = "boundary"); 300 unless told.
    #[schemars(with = "Option<Audit>")]
    pub audit: Option<Spanned<Audit>>,
    /// With method = "sobol": independent randomisations among which the samples are shared; 16 unless told.
    #[schemars(with = "Option<u64>", range(min = 2))]
    pub randomisations: Option<Spanned<u64>>,
    /// Whether all cells draw the same deviates; false unless told.
    #[serde(default)]
    pub common_random_numbers: bool,
    /// Confidence of the interval p_low to p_high, between 0 and 1; 0.95 unless told.
    #[schemars(with = "Option<f64>")]
    pub confidence: Option<Spanned<f64>>,
    /// The interval of Monte Carlo; "wilson" unless told, "clopper-pearson" where the confidence is above 0.95 or
    /// simultaneous.
    #[schemars(with = "Option<IntervalSpec>")]
    pub interval: Option<Spanned<IntervalSpec>>,
    /// Whether the intervals of all cells hold together with the confidence; false unless told.
    #[schemars(with = "Option<bool>")]
    pub simultaneous: Option<Spanned<bool>>,
    /// Whether the derivatives of the probability are written, as further columns; false unless told.
    #[schemars(with = "Option<bool>")]
    pub derivatives: Option<Spanned<bool>>,
    /// Whether first-order and total Sobol indices of the inputs are written, as further columns; false unless told.
    #[schemars(with = "Option<bool>")]
    pub sensitivity: Option<Spanned<bool>>,
}

/// When enough samples are drawn: half_width or relative is given, or both; then the first that is reached.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(
    deny_unknown_fields,
    expecting = "a table, for example until = { half_width = 0.005 } or until = { relative = 0.05 }"
)]
pub struct UntilSpec {
    /// Half of the width of the interval that is wanted, greater than 0 and less than 0.5.
    pub half_width: Option<f64>,
    /// The same over the middle of the interval, greater than 0 and less than 1.
    pub relative: Option<f64>,
    /// Confidence of the interval; 0.95 unless told.
    pub confidence: Option<f64>,
    /// Samples in a cell at the most; 1000000 unless told. It can be raised later.
    pub at_most: Option<u64>,
}

impl UntilSpec {
    fn at_most(&self) -> u64 {
        self.at_most.unwrap_or(AT_MOST)
    }

    fn precision(&self) -> Result<Precision, String> {
        let Self { half_width, relative, .. } = *self;
        for (key, value, limit) in [("half_width", half_width, 0.5), ("relative", relative, 1.0)] {
            if let Some(value) = value
                && !(value > 0.0 && value < limit)
            {
                return Err(format!(
                    "sampling.until.{key} = {value} is out of range: it must be greater than 0 and less than {limit}"
                ));
            }
        }
        if half_width.is_none() && relative.is_none() {
            return Err("sampling.until does not say when a cell is known well enough: give half_width (of p_low to p_high) or relative (half of that width over its middle), for example until = { relative = 0.05 }".to_owned());
        }
        Ok(Precision { half_width, relative })
    }
}

/// Which of the samples that a verdict map tells are simulated all the same.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "sampling.audit is a whole number of samples of each cell, for example 300, or a share of the looked-up samples, for example 0.01"
)]
pub enum Audit {
    /// The first so many of each cell.
    Samples(u64),
    /// A share of all.
    Share(f64),
}

impl Audit {
    /// Whether none is.
    pub fn is_nothing(self) -> bool {
        matches!(self, Self::Samples(0)) || self == Self::Share(0.0)
    }
}

/// How probabilities are found.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SamplingMethod {
    /// Independent samples.
    #[default]
    MonteCarlo,
    /// Scrambled Sobol points.
    Sobol,
    /// The normal measure of the unstable side of the boundary.
    Exact,
}

/// Which samples are judged.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum EvaluateMode {
    /// Every sample by itself.
    #[default]
    Each,
    /// Those within the resolution of a map of the verdicts; the others are looked up in it.
    Boundary,
}

/// An interval for counted verdicts.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum IntervalSpec {
    /// Wilson's score interval: right on average.
    #[default]
    Wilson,
    /// Clopper and Pearson's: never less than the confidence, and wider.
    ClopperPearson,
}

impl From<IntervalSpec> for IntervalKind {
    fn from(spec: IntervalSpec) -> Self {
        match spec {
            IntervalSpec::Wilson => Self::Wilson,
            IntervalSpec::ClopperPearson => Self::ClopperPearson,
        }
    }
}

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
    /// Samples in each cell (at the most, with `until`; 0 for integrals).
    pub samples: u64,
    /// The precision that is wanted of each cell, with `until`.
    until: Option<Precision>,
    /// How they are shared.
    pub effort: Effort,
    /// Seed.
    pub seed: u64,
    /// Which samples are judged.
    pub evaluate: EvaluateMode,
    /// Which looked-up samples are simulated all the same.
    pub audit: Audit,
    /// Whether cells share their deviates.
    pub common_random_numbers: bool,
    /// Confidence of the intervals.
    pub confidence: f64,
    /// Which interval, if the spec says so.
    pub interval: Option<IntervalSpec>,
    /// Whether the intervals hold together.
    pub simultaneous: bool,
    /// Whether verdicts are looked up in a map, and which of them is audited.
    pub is_audited: bool,
    /// Whether derivatives are wanted.
    pub derivatives: bool,
    /// Whether Sobol indices are wanted.
    pub sensitivity: bool,
}

impl Sampling {
    /// Checks every key, and that they fit each other, the inputs and the criterion.
    pub fn validate(
        spec: &SamplingSpec,
        inputs: &RandomInputSet,
        criterion: &Criterion,
        cells: u64,
    ) -> Result<Self, Complaint> {
        spec.refuse_foreign_keys(criterion)?;
        let confidence = spec.checked_confidence(cells)?;

        let samples = match (&spec.until, &spec.samples) {
            _ if spec.method() == SamplingMethod::Exact => 0,
            (Some(until), _) => until.get_ref().at_most(),
            (None, samples) => samples.as_ref().map_or(10_000, |samples| *samples.get_ref()),
        };
        if spec.method() != SamplingMethod::Exact && (samples == 0 || samples > MOST_SAMPLES) {
            let span = spec.until.as_ref().map(Spanned::span).or(spec.samples.as_ref().map(Spanned::span));
            let key = if spec.until.is_some() { "until.at_most" } else { "samples" };
            let message =
                format!("sampling.{key} = {samples} is out of range: it must be at least 1 and at most {MOST_SAMPLES}");
            return Err(Complaint { span, message });
        }
        let evaluate = spec.evaluate.as_ref().map_or(EvaluateMode::Each, |evaluate| *evaluate.get_ref());
        let audit = spec.checked_audit(criterion)?;
        let uses_map = evaluate == EvaluateMode::Boundary || spec.method() == SamplingMethod::Exact;
        let uses_map = uses_map && !matches!(criterion, Criterion::Eigenvalue);
        let is_audited = uses_map && !audit.unwrap_or(AUDIT).is_nothing();
        spec.refuse_wilson_beyond_its_reach(confidence, is_audited)?;
        let of_a_cell = spec.confidence_of_a_cell(confidence, cells);
        let for_counts = if is_audited { half_of_the_error(of_a_cell) } else { of_a_cell };
        let precision = spec.precision()?;
        let (audit, precision) = match precision {
            Some(precision) if is_audited => {
                let (audit, precision) = spec.share_precision(precision, audit, for_counts)?;
                (audit, Some(precision))
            }
            precision => (audit.unwrap_or(AUDIT), precision),
        };
        let sampling = Self {
            method: spec.method(),
            samples,
            until: spec.precision()?,
            effort: spec.effort(samples, for_counts, precision)?,
            seed: spec.seed.as_ref().map_or(0, |seed| *seed.get_ref()),
            evaluate,
            audit,
            common_random_numbers: spec.common_random_numbers,
            confidence,
            interval: spec.interval.as_ref().map(|interval| *interval.get_ref()),
            simultaneous: spec.is_simultaneous(),
            is_audited,
            derivatives: spec.derivatives.as_ref().is_some_and(|derivatives| *derivatives.get_ref()),
            sensitivity: spec.sensitivity.as_ref().is_some_and(|sensitivity| *sensitivity.get_ref()),
        };
        sampling.check_against(spec, inputs, criterion)?;
        Ok(sampling)
    }

    /// What the methods need of the inputs and the criterion.
    fn check_against(
        &self,
        spec: &SamplingSpec,
        inputs: &RandomInputSet,
        criterion: &Criterion,
    ) -> Result<(), Complaint> {
        let method = spec.method.as_ref().map(Spanned::span);
        let evaluate = spec.evaluate.as_ref().map(Spanned::span).or(method.clone());
        let complain = |span, message: String| Err(Complaint { span, message });
        let uses_map = self.evaluate == EvaluateMode::Boundary || self.method == SamplingMethod::Exact;
        let asked = if self.method == SamplingMethod::Exact { "method = \"exact\"" } else { "evaluate = \"boundary\"" };
        if uses_map && let Some(other) = inputs.other() {
            return complain(
                evaluate,
                format!(
                    "sampling.{asked} knows the boundary as a curve over preload and static friction; random.inputs also lists {}. Use method = \"monte-carlo\" or \"sobol\" with evaluate = \"each\"",
                    other.name()
                ),
            );
        }
        if self.method == SamplingMethod::Exact && !inputs.is_plain() {
            return complain(
                method,
                "sampling.method = \"exact\" integrates independent normal inputs; for other distributions or correlation use \"monte-carlo\" or \"sobol\"".to_owned(),
            );
        }
        if uses_map && criterion.records_amplitude() {
            return complain(
                evaluate,
                format!(
                    "sampling.{asked} looks samples up, and these have no amplitude; remove criterion.record, or use evaluate = \"each\""
                ),
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
                "sampling.sensitivity parts the variance among independent inputs: it needs two or more of them, without random.correlation".to_owned(),
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

    /// Parts of a cell that are counted apart: how many samples each has at the most.
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

    /// As a normalised job writes it.
    pub fn normalised(&self) -> NormalisedSampling {
        let samples = match self.effort {
            Effort::Samples(samples) => Some(samples),
            Effort::Randomisations { count, points } => Some(count * points),
            Effort::Until(_) | Effort::Integrated => None,
        };
        let until = match &self.effort {
            Effort::Until(_) => self.until.map(|Precision { half_width, relative }| NormalisedUntil {
                half_width,
                relative,
                confidence: self.confidence,
                at_most: self.samples,
            }),
            _ => None,
        };
        let integrated = self.method == SamplingMethod::Exact;
        // What is integrated over a map is audited with samples.
        let without_samples = integrated && !self.is_audited;
        NormalisedSampling {
            method: self.method,
            samples,
            seed: (!without_samples).then_some(self.seed),
            evaluate: (!integrated).then_some(self.evaluate),
            common_random_numbers: (!integrated).then_some(self.common_random_numbers),
            confidence: (!without_samples && until.is_none()).then_some(self.confidence),
            audit: (self.is_audited || self.evaluate == EvaluateMode::Boundary || self.audit != AUDIT)
                .then_some(self.audit),
            randomisations: match self.effort {
                Effort::Randomisations { count, .. } => Some(count),
                _ => None,
            },
            interval: self.interval.filter(|interval| *interval != IntervalSpec::Wilson),
            simultaneous: self.simultaneous,
            derivatives: self.derivatives,
            sensitivity: self.sensitivity,
            until,
        }
    }
}

impl SamplingSpec {
    fn method(&self) -> SamplingMethod {
        self.method.as_ref().map_or(SamplingMethod::MonteCarlo, |method| *method.get_ref())
    }

    fn is_simultaneous(&self) -> bool {
        self.simultaneous.as_ref().is_some_and(|simultaneous| *simultaneous.get_ref())
    }

    /// The confidence that one of so many intervals needs, for all of them to hold together if they are to.
    fn confidence_of_a_cell(&self, confidence: f64, cells: u64) -> f64 {
        if self.is_simultaneous() { simultaneous_confidence(confidence, cells) } else { confidence }
    }

    fn checked_confidence(&self, cells: u64) -> Result<f64, Complaint> {
        let (key, value, span) = match &self.until {
            Some(until) => ("until.confidence", until.get_ref().confidence.unwrap_or(0.95), Some(until.span())),
            None => (
                "confidence",
                self.confidence.as_ref().map_or(0.95, |confidence| *confidence.get_ref()),
                self.confidence.as_ref().map(Spanned::span),
            ),
        };
        // The bounds keep the quantile of the interval finite and its definition meaningful.
        if 0.0 < value && value <= HIGHEST_CONFIDENCE {
            let each = self.confidence_of_a_cell(value, cells);
            if each <= HIGHEST_CONFIDENCE {
                return Ok(value);
            }
            let message = format!(
                "sampling.{key} = {value} for {cells} cells together takes more than the highest confidence of one, 1 - 1e-12; lower it, or remove sampling.simultaneous"
            );
            return Err(Complaint { span, message });
        }
        let message = format!(
            "sampling.{key} = {value} is out of range: it must be greater than 0 and less than 1, for example 0.95"
        );
        Err(Complaint { span, message })
    }

    /// What is wanted of each cell, with `until`.
    fn precision(&self) -> Result<Option<Precision>, Complaint> {
        let precision = |until: &Spanned<UntilSpec>| {
            until.get_ref().precision().map_err(|message| Complaint::at(until.span(), message))
        };
        self.until.as_ref().map(precision).transpose()
    }

    /// Shares the half width that is wanted among the audit of a verdict map, of which no sample differs, and the counts:
    /// the audit that it takes, and what is left for the counts.
    fn share_precision(
        &self,
        precision: Precision,
        audit: Option<Audit>,
        confidence: f64,
    ) -> Result<(Audit, Precision), Complaint> {
        let complain = |message: String| Err(Complaint { span: self.until.as_ref().map(Spanned::span), message });
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

    /// Wilson's interval misses far more often than it says where misses are to be rare.
    fn refuse_wilson_beyond_its_reach(&self, confidence: f64, is_audited: bool) -> Result<(), Complaint> {
        let Some(interval) = self.interval.as_ref().filter(|interval| *interval.get_ref() == IntervalSpec::Wilson)
        else {
            return Ok(());
        };
        let why = if self.is_simultaneous() {
            "with sampling.simultaneous".to_owned()
        } else if IntervalKind::for_confidence(confidence) == IntervalKind::ClopperPearson {
            format!("at a confidence of {confidence}, above {MOST_WILSON_CONFIDENCE}")
        } else if is_audited
            && IntervalKind::for_confidence(half_of_the_error(confidence)) == IntervalKind::ClopperPearson
        {
            format!(
                "beside an audit, which takes half of the error: {} is above {MOST_WILSON_CONFIDENCE}",
                half_of_the_error(confidence)
            )
        } else {
            return Ok(());
        };
        let message = format!(
            "sampling.interval = \"wilson\" does not hold {why}: near 0 and 1 it misses far more often than it says. Remove it, or write \"clopper-pearson\""
        );
        Err(Complaint::at(interval.span(), message))
    }

    /// The audit of the verdict map, where there is one.
    fn checked_audit(&self, criterion: &Criterion) -> Result<Option<Audit>, Complaint> {
        let Some(spec) = &self.audit else { return Ok(None) };
        let complain = |message: String| Err(Complaint::at(spec.span(), message));
        if matches!(criterion, Criterion::Eigenvalue) && self.method() == SamplingMethod::Exact {
            return complain(
                "sampling.audit has no meaning where criterion.kind = \"eigenvalue\" is integrated in closed form; remove it".to_owned(),
            );
        }
        match *spec.get_ref() {
            Audit::Share(share) if !(0.0..=1.0).contains(&share) => complain(format!(
                "sampling.audit = {share} is out of range: it is a share of the looked-up samples, at least 0 and at most 1, or a whole number of samples of each cell"
            )),
            Audit::Share(0.0) => Ok(Some(Audit::Samples(0))),
            Audit::Samples(1) => complain(
                "sampling.audit = 1 is one sample of each cell, which says nothing; write audit = 1.0 for all samples, or a larger number".to_owned(),
            ),
            Audit::Share(share) if self.method() == SamplingMethod::Exact => complain(format!(
                "sampling.audit = {share} is a share of samples, and method = \"exact\" draws none but those of the audit: give their number in each cell, for example audit = 1000"
            )),
            Audit::Samples(samples) if samples > MOST_AUDITED => {
                complain(format!("sampling.audit = {samples} is out of range: it must be at most {MOST_AUDITED}"))
            }
            audit => Ok(Some(audit)),
        }
    }

    fn effort(&self, samples: u64, confidence: f64, precision: Option<Precision>) -> Result<Effort, Complaint> {
        match (self.method(), precision) {
            (SamplingMethod::Exact, _) => Ok(Effort::Integrated),
            (SamplingMethod::MonteCarlo, None) => Ok(Effort::Samples(samples)),
            (SamplingMethod::MonteCarlo, Some(precision)) => {
                Ok(Effort::Until(Looks::new(precision, samples, confidence)))
            }
            (SamplingMethod::Sobol, _) => {
                let count = self.randomisations.as_ref().map_or(RANDOMISATIONS, |count| *count.get_ref());
                let span = self.randomisations.as_ref().map(Spanned::span);
                if !(2..=MOST_RANDOMISATIONS).contains(&count) {
                    let message = format!(
                        "sampling.randomisations = {count} is out of range: it must be at least 2 and at most {MOST_RANDOMISATIONS}"
                    );
                    return Err(Complaint { span, message });
                }
                if samples / count > MOST_SOBOL_POINTS {
                    let message = format!(
                        "sampling.samples = {samples} are too many for {count} randomisations: each has at most 2^32 points, all together {}",
                        count * MOST_SOBOL_POINTS
                    );
                    return Err(Complaint { span: self.samples.as_ref().map(Spanned::span), message });
                }
                if !samples.is_multiple_of(count) {
                    let span = self.samples.as_ref().map(Spanned::span).or(span);
                    let near = (samples / count).max(1).next_power_of_two() * count;
                    let message = format!(
                        "sampling.samples = {samples} cannot be shared by {count} randomisations of equal size; powers of two are best, for example samples = {near}"
                    );
                    return Err(Complaint { span, message });
                }
                Ok(Effort::Randomisations { count, points: samples / count })
            }
        }
    }

    fn refuse_foreign_keys(&self, criterion: &Criterion) -> Result<(), Complaint> {
        let is_eigenvalue = matches!(criterion, Criterion::Eigenvalue);
        let is_exact = self.method() == SamplingMethod::Exact;
        let is_sobol = self.method() == SamplingMethod::Sobol;
        let is_boundary = self.evaluate.as_ref().is_some_and(|evaluate| *evaluate.get_ref() == EvaluateMode::Boundary);
        let samples = self.samples.as_ref().map(Spanned::span);
        let until = self.until.as_ref().map(Spanned::span);
        let confidence = self.confidence.as_ref().map(Spanned::span);
        let interval = self.interval.as_ref().map(Spanned::span);
        let rules = [
            (
                samples.clone(),
                is_exact,
                "sampling.samples has no meaning with method = \"exact\", which draws none; remove it (or --samples)",
            ),
            (
                until.clone(),
                is_exact,
                "sampling.until has no meaning with method = \"exact\", which draws no samples; remove it",
            ),
            (
                confidence.clone(),
                is_exact && is_eigenvalue,
                "sampling.confidence has no meaning where criterion.kind = \"eigenvalue\" is integrated in closed form: p_low and p_high bound the numerical error; remove it",
            ),
            (interval.clone(), is_exact, "sampling.interval has no meaning with method = \"exact\"; remove it"),
            (
                self.simultaneous.as_ref().map(Spanned::span),
                is_exact && is_eigenvalue,
                "sampling.simultaneous has no meaning where criterion.kind = \"eigenvalue\" is integrated in closed form, whose bounds all hold; remove it",
            ),
            (
                self.evaluate.as_ref().map(Spanned::span),
                is_exact,
                "sampling.evaluate has no meaning with method = \"exact\", which draws no samples; remove it",
            ),
            (
                until,
                is_sobol,
                "sampling.until needs method = \"monte-carlo\": Sobol points are only good in full powers of two; give `samples`",
            ),
            (
                interval.clone(),
                is_sobol,
                "sampling.interval has no meaning with method = \"sobol\", whose interval comes from the randomisations; remove it",
            ),
            (
                samples,
                self.until.is_some(),
                "sampling.samples and sampling.until exclude each other: give one of them (with until, at_most limits the samples)",
            ),
            (
                confidence,
                self.until.is_some(),
                "sampling.confidence and sampling.until exclude each other: write until = { ..., confidence = ... }",
            ),
            (
                interval,
                self.until.is_some(),
                "sampling.interval has no meaning with sampling.until, whose interval stays valid under repeated looks; remove it",
            ),
            (
                self.randomisations.as_ref().map(Spanned::span),
                !is_sobol,
                "sampling.randomisations belongs to method = \"sobol\"; remove it, or change the method",
            ),
            (
                self.audit.as_ref().map(Spanned::span),
                !is_boundary && !is_exact,
                "sampling.audit belongs to evaluate = \"boundary\" and to method = \"exact\"; remove it, or change one of these",
            ),
        ];
        for (span, is_foreign, message) in rules {
            if let (Some(span), true) = (span, is_foreign) {
                return Err(Complaint::at(span, message.to_owned()));
            }
        }
        Ok(())
    }
}

/// Sampling as a normalised job writes it; keys that came later only where they say something, so that older jobs keep
/// their identity.
#[derive(Serialize)]
pub struct NormalisedSampling {
    method: SamplingMethod,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    seed: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    evaluate: Option<EvaluateMode>,
    #[serde(skip_serializing_if = "Option::is_none")]
    common_random_numbers: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    confidence: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    audit: Option<Audit>,
    #[serde(skip_serializing_if = "Option::is_none")]
    randomisations: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    interval: Option<IntervalSpec>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    simultaneous: bool,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    derivatives: bool,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    sensitivity: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    until: Option<NormalisedUntil>,
}

impl NormalisedSampling {
    /// The same for any number of samples: jobs that agree in it share theirs.
    pub fn for_any_number(self) -> Self {
        let until = self.until.map(|until| NormalisedUntil { at_most: 0, ..until });
        Self { samples: self.samples.map(|_| 0), until, ..self }
    }
}

#[derive(Serialize)]
struct NormalisedUntil {
    #[serde(skip_serializing_if = "Option::is_none")]
    half_width: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    relative: Option<f64>,
    confidence: f64,
    at_most: u64,
}
