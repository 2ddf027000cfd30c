//! A job written out in full, with every default filled in, as TOML that can itself be submitted.
//!
//! These are the values that belong to a job's experiment; its identity is a hash of them.

use std::collections::BTreeMap;

use serde::Serialize;
use stickslip_sampler::estimate::looks::Precision;
use stickslip_sampler::inputs::Marginal;

use super::method::Sampling;
use super::model::{OutsidePhysics, Tables, table_of};
use super::sampling_key::Key;
use super::sampling_numbers::Effort;
use super::sampling_spec::{AUDIT, Audit, EvaluateMode, IntervalSpec, SamplingMethod};
use super::scatter::own_std;
use super::validated::Job;

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
    experiment: NormalisedExperiment,
}

/// What a job computes.
#[derive(Serialize)]
pub struct NormalisedExperiment {
    pub(super) model: toml::Table,
    pub(super) axes: toml::Table,
    pub(super) random: NormalisedRandom,
    pub(super) criterion: toml::Table,
    pub(super) sampling: NormalisedSampling,
}

impl From<&Job> for NormalisedExperiment {
    fn from(job: &Job) -> Self {
        let Tables { model, mut criterion } = job.model.tables(&job.grid);
        if job.outside_physics != OutsidePhysics::default() {
            criterion.extend(table_of(&BTreeMap::from([("outside_physics", job.outside_physics)])));
        }
        let axes = job.grid.axes.iter().map(|axis| (&*job.quantity(axis.quantity).name, axis.axis.values()));
        Self {
            model,
            axes: table_of(&axes.collect::<BTreeMap<&str, &[f64]>>()),
            random: job.into(),
            criterion,
            sampling: (&job.sampling).into(),
        }
    }
}

/// The random inputs.
#[derive(Serialize)]
pub struct NormalisedRandom {
    pub(super) inputs: Vec<String>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) relative_std: Vec<BTreeMap<String, f64>>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) std: BTreeMap<String, f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) correlation: Vec<(String, String, f64)>,
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub(super) distribution: BTreeMap<String, NormalisedMarginal>,
}

impl From<&Job> for NormalisedRandom {
    fn from(job: &Job) -> Self {
        let random = &job.random;
        let name = |i: usize| job.quantity_of(i).name.to_string();
        let inputs = || 0..random.inputs.len();
        let is_absolute = |i: usize| job.quantity_of(i).scatters_absolutely;
        let first = random.relative_stds.first();
        // Measured values have their own standard deviation, which is not given.
        let is_free = |&i: &usize| own_std(&random.marginals[i]).is_none() && !is_absolute(i);
        let given = |stds: &Vec<f64>| -> BTreeMap<String, f64> {
            inputs().filter(is_free).map(|i| (name(i), stds[i])).collect()
        };
        let absolute = inputs().filter(|&i| is_absolute(i));
        // In one order, however they are written.
        let mut pairs: Vec<_> = random.pairs.iter().map(|&(i, j, rho)| (i.min(j), i.max(j), rho)).collect();
        pairs.sort_by_key(|&(i, j, _)| (i, j));
        Self {
            inputs: inputs().map(name).collect(),
            relative_std: random.relative_stds.iter().map(given).filter(|stds| !stds.is_empty()).collect(),
            std: absolute.filter_map(|i| Some((name(i), first?[i]))).collect(),
            distribution: inputs()
                .filter(|&i| random.marginals[i] != Marginal::Normal)
                .map(|i| (name(i), (&random.marginals[i]).into()))
                .collect(),
            correlation: pairs.into_iter().map(|(i, j, rho)| (name(i), name(j), rho)).collect(),
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
            Effort::Randomisations { count, points } => Some(count * points),
            Effort::Until(_) => None,
        };
        let until = sampling.until.map(|Precision { half_width, relative }| NormalisedUntil {
            half_width,
            relative,
            confidence: sampling.confidence,
            at_most: sampling.samples,
        });
        let takes = |key: Key| sampling.method.takes(key);
        // What is integrated over a map is audited with samples.
        let draws = sampling.samples > 0 || sampling.is_audited;
        let has_audit = sampling.is_audited || sampling.evaluate == EvaluateMode::Boundary || sampling.audit != AUDIT;
        Self {
            method: sampling.method.written(),
            samples: samples.filter(|_| takes(Key::Samples)),
            seed: draws.then_some(sampling.seed),
            evaluate: takes(Key::Evaluate).then_some(sampling.evaluate),
            common_random_numbers: takes(Key::CommonRandomNumbers).then_some(sampling.common_random_numbers),
            confidence: (draws && takes(Key::Confidence)).then_some(sampling.confidence),
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
