//! How the limits of a job along an axis are found, if they can be.

use indicatif::HumanCount;
use toml::Spanned;

use super::diagnosis::Complaint;
use super::limit_axis::LimitAxis;
use super::limit_request::LimitRequest;
use super::limit_spec::LimitSpec;
use super::validated::Job;

/// Largest number of samples of a cell: they are held in memory, or evaluated at many values.
const MOST_SAMPLES: u64 = 10_000_000;

/// How the limits of a job are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitMethod {
    /// From the integrated probability, whose boundary is known in closed form.
    Integral,
    /// From the integral over a verdict map.
    MapIntegral,
    /// From the critical values of all samples, along this quantity of the pair.
    CriticalValues(usize),
    /// From samples with weights.
    WeightedSamples,
    /// From the same samples at many values of the axis.
    Samples,
}

/// The request of a table `[limit]` whose keys were checked.
///
/// # Errors
/// An axis that the job does not have, or along which it has no limits.
pub fn requested(spec: &Spanned<LimitSpec>, job: &Job) -> Result<Option<LimitRequest>, Complaint> {
    let (Some(of), Some(targets)) = (&spec.get_ref().of, &spec.get_ref().probability) else { return Ok(None) };
    let axis = LimitAxis::named(job, of.get_ref());
    match axis.and_then(|axis| LimitMethod::for_axis(job, &axis).map(|_| axis)) {
        Ok(axis) => Ok(Some(LimitRequest { of: axis.name, targets: targets.get_ref().0.clone() })),
        Err(why) => Err(Complaint::at(of.span(), format!("limit.of = {:?}: {why}", of.get_ref()))),
    }
}

impl LimitMethod {
    /// How the limits along an axis of a job are found.
    ///
    /// # Errors
    /// Why they cannot be, and what would be right.
    pub fn for_axis(job: &Job, axis: &LimitAxis) -> Result<Self, String> {
        job.sampling.method.limits(job, axis)
    }
}

/// Refuses a job that simulates its samples.
///
/// # Errors
/// What has limits.
pub fn in_closed_form(job: &Job) -> Result<(), String> {
    if job.has_closed_form() {
        return Ok(());
    }
    Err(format!(
        "limits are found with criterion.kind = \"eigenvalue\", whose boundary is known in closed form, or with sampling.method = \"exact\" or \"importance\"; the job \"{}\" simulates its samples. Submit it: its summary states up to which values of its axes the probability is below 1 %, 5 % and 50 %, and surface.parquet has p_high of every cell",
        job.name
    ))
}

/// Refuses more samples of each combination than can be held.
///
/// # Errors
/// The largest number.
pub fn few_samples(job: &Job) -> Result<(), String> {
    let samples = job.sampling.samples;
    if samples <= MOST_SAMPLES {
        return Ok(());
    }
    Err(format!(
        "limits are found with {} samples of each combination at most; sampling.samples is {}. Give fewer, or sampling.method = \"exact\", which needs none",
        HumanCount(MOST_SAMPLES),
        HumanCount(samples)
    ))
}
