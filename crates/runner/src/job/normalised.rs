//! A job written out in full, with every default filled in, as TOML that can itself be submitted.
//!
//! These are the values that belong to a job's experiment; its identity is a hash of them.

use std::collections::BTreeMap;

use serde::{Serialize, Serializer};
use stickslip_core::criterion::time_domain::DiscModel;
use stickslip_core::friction::law::LawKind;
use stickslip_core::motion::start::Start;
use stickslip_core::parameters::{Parameters, SCALARS};
use stickslip_sampler::estimate::looks::Precision;
use stickslip_sampler::grid::FurtherAxis;
use stickslip_sampler::inputs::Marginal;

use super::criterion::Criterion;
use super::criterion_spec::{CriterionKind, DiscKind, GivenStartSpec, OutsidePhysics, Record, StartKind};
use super::friction::{CurveColumns, LawSpec};
use super::random::RandomInputSet;
use super::random_input::RandomInput;
use super::sampling::{Effort, Sampling};
use super::sampling_spec::{AUDIT, Audit, EvaluateMode, IntervalSpec, SamplingMethod};
use super::scatter::own_std;
use super::validated::Job;

/// Parameters that jobs did not have from the beginning; without effect while they are zero.
const LATER: [&str; 2] = ["friction.viscous", "friction.band"];

/// The values of the model by section and name, without those that are axes of the grid.
pub type NormalisedModel = BTreeMap<&'static str, BTreeMap<&'static str, NormalisedValue>>;

/// A value of the model.
#[derive(Serialize)]
#[serde(untagged)]
pub enum NormalisedValue {
    Number(f64),
    Word(&'static str),
    Curve(CurveColumns),
}

impl Job {
    /// The job with everything written out, as TOML that can itself be submitted.
    pub fn normalised(&self) -> String {
        let document = NormalisedDocument {
            name: &self.name,
            description: &self.description,
            experiment: NormalisedExperiment::from(self),
        };
        // Strings, numbers, lists and tables only: there is nothing in it that TOML cannot hold.
        toml::to_string(&document).unwrap_or_else(|error| format!("# not representable: {error}\n"))
    }
}

/// A job: what it is called, and what it computes.
#[derive(Serialize)]
struct NormalisedDocument<'a> {
    name: &'a str,
    description: &'a str,
    #[serde(flatten)]
    experiment: NormalisedExperiment<'a>,
}

/// What a job computes.
#[derive(Serialize)]
pub struct NormalisedExperiment<'a> {
    pub(super) model: NormalisedModel,
    pub(super) axes: NormalisedAxes<'a>,
    pub(super) random: NormalisedRandom,
    pub(super) criterion: NormalisedCriterion,
    pub(super) sampling: NormalisedSampling,
}

impl<'a> From<&'a Job> for NormalisedExperiment<'a> {
    fn from(job: &'a Job) -> Self {
        Self {
            model: model(&job.parameters, &job.grid.of_brake),
            axes: NormalisedAxes {
                further: job.grid.further().map(|further| (&*further.name, further.axis.values())).collect(),
                rotating_speed: job.grid.rotating_speed.values(),
                preload: job.grid.preload.values(),
                static_friction: job.grid.static_friction.values(),
            },
            random: (&job.random).into(),
            criterion: NormalisedCriterion {
                outside_physics: Some(job.outside_physics).filter(|policy| *policy != OutsidePhysics::default()),
                ..(&job.criterion).into()
            },
            sampling: (&job.sampling).into(),
        }
    }
}

/// The model of a job, but for what its axes give: those that every grid has, and `further` ones.
pub fn model(parameters: &Parameters, further: &[FurtherAxis]) -> NormalisedModel {
    let law = &parameters.friction.law;
    let mut model = NormalisedModel::new();
    for scalar in &SCALARS {
        let is_axis = scalar.section() == "operating_point" || scalar.key == "friction.static_coefficient";
        // Later parameters count only where they are used, so that earlier jobs keep their identity.
        let is_unused = LATER.contains(&scalar.key) && scalar.value(parameters) == 0.0;
        let is_further = further.iter().any(|further| further.name == scalar.key);
        let is_strange = scalar.section() == "friction" && LawSpec::from(law).refusal(scalar.name(), "").is_some();
        if !is_axis && !is_further && !is_unused && !is_strange {
            let value = NormalisedValue::Number(scalar.value(parameters));
            model.entry(scalar.section()).or_default().insert(scalar.name(), value);
        }
    }
    let friction = model.entry("friction").or_default();
    if !matches!(law, LawKind::Stribeck) {
        friction.insert("law", NormalisedValue::Word(law.name()));
    }
    if let Some(curve) = law.table() {
        friction.insert("table", NormalisedValue::Curve(CurveColumns::from(&**curve)));
    }
    model
}

/// The axes of the grid.
#[derive(Serialize)]
pub struct NormalisedAxes<'a> {
    /// The further axes, slowest first.
    #[serde(serialize_with = "serialize_further")]
    #[serde(flatten)]
    pub(super) further: Vec<(&'a str, &'a [f64])>,
    pub(super) rotating_speed: &'a [f64],
    pub(super) preload: &'a [f64],
    pub(super) static_friction: &'a [f64],
}

/// Further axes as keys of a table.
fn serialize_further<S: Serializer>(further: &[(&str, &[f64])], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(further.iter().copied())
}

/// The random inputs.
#[derive(Serialize)]
pub struct NormalisedRandom {
    pub(super) inputs: Vec<&'static str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) relative_std: Vec<BTreeMap<&'static str, f64>>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) std: BTreeMap<&'static str, f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) correlation: Vec<(&'static str, &'static str, f64)>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) distribution: BTreeMap<&'static str, NormalisedMarginal>,
}

impl From<&RandomInputSet> for NormalisedRandom {
    fn from(random: &RandomInputSet) -> Self {
        let name = |i: usize| random.inputs[i].name();
        let marginals = || random.inputs.iter().zip(&random.marginals);
        let is_absolute = |input: &RandomInput| input.scatters_absolutely();
        let absolute = marginals().zip(random.relative_stds.first().into_iter().flatten());
        let absolute = absolute.filter(|((input, _), _)| is_absolute(input));
        // Measured values have their own standard deviation, which is not given.
        let given = |stds: &Vec<f64>| -> BTreeMap<&'static str, f64> {
            let is_free = |input: &RandomInput, marginal| own_std(marginal).is_none() && !is_absolute(input);
            let free = marginals().zip(stds).filter(|((input, marginal), _)| is_free(input, marginal));
            free.map(|((input, _), &std)| (input.name(), std)).collect()
        };
        Self {
            inputs: random.inputs.iter().map(|input| input.name()).collect(),
            relative_std: random.relative_stds.iter().map(given).filter(|stds| !stds.is_empty()).collect(),
            std: absolute.map(|((input, _), &std)| (input.name(), std)).collect(),
            distribution: marginals()
                .filter(|(_, marginal)| **marginal != Marginal::Normal)
                .map(|(input, marginal)| (input.name(), marginal.into()))
                .collect(),
            correlation: random.pairs.iter().map(|&(i, j, rho)| (name(i), name(j), rho)).collect(),
        }
    }
}

/// A distribution.
#[derive(Debug, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum NormalisedMarginal {
    /// See [`Marginal`].
    Normal,
    /// See [`Marginal`].
    Lognormal,
    /// See [`Marginal`].
    Uniform,
    /// The two ends.
    TruncatedNormal(f64, f64),
    /// See [`Marginal`].
    Weibull,
    /// See [`Marginal`].
    Gumbel,
    /// The place of the peak.
    Triangular(f64),
    /// The two ends.
    Beta(f64, f64),
    /// Measured values, sorted.
    Values(Vec<f64>),
}

impl From<&Marginal> for NormalisedMarginal {
    fn from(marginal: &Marginal) -> Self {
        match *marginal {
            Marginal::Normal => Self::Normal,
            Marginal::Lognormal => Self::Lognormal,
            Marginal::Uniform => Self::Uniform,
            Marginal::TruncatedNormal { low, high } => Self::TruncatedNormal(low, high),
            Marginal::Weibull => Self::Weibull,
            Marginal::Gumbel => Self::Gumbel,
            Marginal::Triangular { mode } => Self::Triangular(mode),
            Marginal::Beta { low, high } => Self::Beta(low, high),
            Marginal::Empirical(ref measured) => Self::Values(measured.values().to_vec()),
        }
    }
}

/// The criterion. Keys that its kind has no use for are absent.
#[derive(Serialize)]
pub struct NormalisedCriterion {
    pub(super) kind: CriterionKind,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) disc: Option<DiscKind>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) disc_modes: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) start: Option<NormalisedStart>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) displacement: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) horizon: Option<f64>,
    /// Unless it is the default. What a verdict map says does not depend on it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) outside_physics: Option<OutsidePhysics>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) record: Vec<Record>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) index: Option<NormalisedIndex>,
}

/// Where a motion starts. Numbers that are axes are absent.
#[derive(Serialize)]
#[serde(untagged)]
pub enum NormalisedStart {
    /// By name.
    Named(StartKind),
    /// In numbers.
    Given(GivenStartSpec),
}

/// The paper's index of instability.
#[derive(Serialize)]
pub struct NormalisedIndex {
    pub(super) amplitude: f64,
}

impl From<&Criterion> for NormalisedCriterion {
    fn from(criterion: &Criterion) -> Self {
        let empty = Self {
            kind: CriterionKind::Eigenvalue,
            disc: None,
            disc_modes: None,
            start: None,
            displacement: None,
            horizon: None,
            outside_physics: None,
            record: Vec::new(),
            index: None,
        };
        match criterion {
            Criterion::Eigenvalue => empty,
            Criterion::CoupledEigenvalue { modes } => {
                Self { kind: CriterionKind::CoupledEigenvalue, disc_modes: Some(*modes), ..empty }
            }
            Criterion::TimeDomain { disc, settings } => Self {
                kind: CriterionKind::TimeDomain,
                disc: Some(if matches!(disc, DiscModel::Rigid) { DiscKind::Rigid } else { DiscKind::Flexible }),
                disc_modes: if let DiscModel::Flexible { modes } = disc { Some(*modes) } else { None },
                start: Some(match settings.start {
                    Start::NearEquilibrium => NormalisedStart::Named(StartKind::NearEquilibrium),
                    Start::Rest => NormalisedStart::Named(StartKind::Rest),
                    Start::LimitCycle => NormalisedStart::Named(StartKind::LimitCycle),
                    Start::Given(ref given) => NormalisedStart::Given(given.into()),
                }),
                displacement: Some(settings.displacement),
                horizon: Some(settings.horizon),
                record: settings.record_amplitude.then_some(Record::Amplitude).into_iter().collect(),
                index: settings.amplitude_index.map(|amplitude| NormalisedIndex { amplitude }),
                outside_physics: None,
            },
        }
    }
}

/// How many samples are drawn, and how. Keys that have no meaning for the method are absent.
#[derive(Serialize)]
pub struct NormalisedSampling {
    pub(super) method: SamplingMethod,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) samples: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) seed: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) evaluate: Option<EvaluateMode>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) common_random_numbers: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) confidence: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) audit: Option<Audit>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) randomisations: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) particles: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) interval: Option<IntervalSpec>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) simultaneous: bool,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) derivatives: bool,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub(super) sensitivity: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) until: Option<NormalisedUntil>,
}

/// The precision that is wanted of each cell.
#[derive(Serialize)]
pub struct NormalisedUntil {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) half_width: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) relative: Option<f64>,
    pub(super) confidence: f64,
    pub(super) at_most: u64,
}

impl From<&Sampling> for NormalisedSampling {
    fn from(sampling: &Sampling) -> Self {
        let samples = match sampling.effort {
            Effort::Samples(samples) => Some(samples),
            // The number of populations is that of the randomisations.
            Effort::Randomisations { .. } if sampling.method == SamplingMethod::Subset => None,
            Effort::Randomisations { count, points } => Some(count * points),
            Effort::Until(_) | Effort::Integrated => None,
        };
        let until = sampling.until.map(|Precision { half_width, relative }| NormalisedUntil {
            half_width,
            relative,
            confidence: sampling.confidence,
            at_most: sampling.samples,
        });
        let integrated = sampling.method == SamplingMethod::Exact;
        let decides_by_itself = matches!(
            sampling.method,
            SamplingMethod::Conditional | SamplingMethod::Importance | SamplingMethod::Subset
        );
        // What is integrated over a map is audited with samples.
        let without_samples = integrated && !sampling.is_audited;
        let has_audit = sampling.is_audited || sampling.evaluate == EvaluateMode::Boundary || sampling.audit != AUDIT;
        Self {
            method: sampling.method,
            samples,
            seed: (!without_samples).then_some(sampling.seed),
            evaluate: (!integrated && !decides_by_itself).then_some(sampling.evaluate),
            common_random_numbers: (!integrated).then_some(sampling.common_random_numbers),
            confidence: (!without_samples && until.is_none()).then_some(sampling.confidence),
            audit: has_audit.then_some(sampling.audit),
            randomisations: match sampling.effort {
                Effort::Randomisations { count, .. } => Some(count),
                _ => None,
            },
            particles: sampling.particles,
            interval: sampling.interval.filter(|interval| *interval != IntervalSpec::Wilson),
            simultaneous: sampling.simultaneous,
            derivatives: sampling.derivatives,
            sensitivity: sampling.sensitivity,
            until,
        }
    }
}
