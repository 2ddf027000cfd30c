//! How the limits of a job along an axis are found, if they can be.

use indicatif::HumanCount;
use stickslip_core::model::quantity::Role;
use toml::Spanned;

use super::diagnosis::Complaint;
use super::limit_axis::LimitAxis;
use super::limit_request::LimitRequest;
use super::limit_spec::LimitSpec;
use super::method::{Answer, MapUse};
use super::validated::Job;

/// Largest number of samples of a cell: they are held in memory, or evaluated at many values.
const MOST_SAMPLES: u64 = 10_000_000;

/// How the limits of a job are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitMethod {
    /// From the integrated probability, whose boundary is known in closed form.
    Integral,
    /// From the probability over the one random input, whose critical values are found.
    OneInput,
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
        let method = job.sampling.method;
        if method.answer() == Answer::Integral {
            return match (job.map_use(), axis.varied) {
                (MapUse::Integrate, None) => Err(format!(
                    "a verdict map serves all values of {}, along which limits are found; along other axes submit the job and read surface.parquet, or use kind = \"eigenvalue\"",
                    job.axes_of(Role::Input).collect::<Vec<_>>().join(" and ")
                )),
                (MapUse::Integrate, Some(_)) => Ok(Self::MapIntegral),
                _ if job.integrated().is_some() => Ok(Self::OneInput),
                _ => Ok(Self::Integral),
            };
        }
        let is_smooth = job.has_closed_form() || method.answer() == Answer::Probability;
        if !is_smooth && !method.answer().is_of_rare_events() {
            return Err(format!(
                "limits are found where the boundary is known in closed form, as of criterion.kind = \"eigenvalue\", or with sampling.method = \"exact\", \"conditional\" or \"importance\" where the model allows it; the job \"{}\" decides its samples one by one. Submit it: its summary states up to which values of its axes the probability is below 1 %, 5 % and 50 %, and surface.parquet has p_high of every cell",
                job.name
            ));
        }
        if let Some(why) = method.without_limits() {
            return Err(why.to_owned());
        }
        let samples = job.sampling.samples;
        if samples > MOST_SAMPLES {
            return Err(format!(
                "limits are found with {} samples of each combination at most; sampling.samples is {}. Give fewer, or sampling.method = \"exact\", which needs none",
                HumanCount(MOST_SAMPLES),
                HumanCount(samples)
            ));
        }
        Ok(match (method.answer(), axis.varied) {
            (Answer::Weight | Answer::Population, _) => Self::WeightedSamples,
            // Values of a sample are in proportion to the expected one, but for those of an input that scatters by `std`.
            (Answer::Verdict, Some(varied)) if !job.is_absolute(axis.quantity) => Self::CriticalValues(varied),
            _ => Self::Samples,
        })
    }
}
