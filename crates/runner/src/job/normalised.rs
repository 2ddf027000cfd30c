//! A job written out in full, with every default filled in, as TOML that can itself be submitted.
//!
//! These are the values that belong to a job's experiment; its identity is a hash of them.

use std::collections::BTreeMap;

use serde::Serialize;
use stickslip_sampler::estimate::looks::Precision;
use stickslip_sampler::inputs::Marginal;

use super::axes_spec::{AxesSpec, AxisEntry, AxisSpec};
use super::distribution_spec::{DistributionSpec, MarginalSpec};
use super::method::Sampling;
use super::model::{OutsidePhysics, Tables, table_of, written};
use super::random_spec::{RandomSpec, RelativeStdSpec, StdSpec};
use super::sampling_key::Key;
use super::sampling_numbers::Effort;
use super::sampling_spec::{EvaluateMode, IntervalSpec, SamplingSpec, UntilSpec};
use super::scatter::own_std;
use super::spec::JobSpec;
use super::validated::Job;

/// What a job asks of its result.
#[derive(Serialize, Default)]
struct Asked<'a> {
    limit: Option<AskedLimit<'a>>,
    target: Option<AskedTarget>,
}

#[derive(Serialize)]
struct AskedLimit<'a> {
    of: &'a str,
    probability: &'a [f64],
}

#[derive(Serialize)]
struct AskedTarget {
    probability: Option<f64>,
    at: Option<BTreeMap<String, f64>>,
}

/// A spec as TOML: strings, numbers, lists and tables only, so that there is nothing in it that TOML cannot hold.
fn text_of(spec: &impl Serialize) -> String {
    toml::to_string(spec).unwrap_or_else(|error| format!("# not representable: {error}\n"))
}

impl Job {
    /// The job with everything written out, as TOML that can itself be submitted.
    pub fn normalised(&self) -> String {
        text_of(&self.written_out())
    }

    /// The same, with the keys that make no difference while they have their defaults, and with what is asked of the
    /// result. It is the same experiment.
    pub fn with_all_keys(&self) -> String {
        let mut spec = self.written_out();
        let (takes, sampling) = (|key: Key| self.sampling.method.takes(key), &self.sampling);
        let if_taken = |key: Key, value: bool| takes(key).then(|| written(value));
        spec.sampling = SamplingSpec {
            simultaneous: if_taken(Key::Simultaneous, sampling.simultaneous),
            derivatives: if_taken(Key::Derivatives, sampling.derivatives),
            sensitivity: if_taken(Key::Sensitivity, sampling.sensitivity),
            ..spec.sampling
        };
        let marginals = self.random.marginals.iter().enumerate();
        let marginals: BTreeMap<String, MarginalSpec> = marginals
            .map(|(i, marginal)| (self.quantity_of(i).name.to_string(), MarginalSpec::Given(marginal.clone())))
            .collect();
        spec.random.distribution = (!marginals.is_empty()).then(|| written(DistributionSpec::Each(marginals)));
        if let Some(criterion) = spec.criterion.as_mut().and_then(toml::Value::as_table_mut) {
            criterion.extend(table_of(&BTreeMap::from([("outside_physics", self.outside_physics)])));
        }
        let at = self.operating_point.map(|cell| self.point(cell).into_iter().collect());
        let target = AskedTarget { probability: self.target, at };
        let target = (target.probability.is_some() || target.at.is_some()).then_some(target);
        let target = text_of(&Asked { target, ..Asked::default() });
        let texts = [text_of(&spec), self.limit_table(), target];
        texts.into_iter().filter(|text| !text.is_empty()).collect::<Vec<_>>().join("\n")
    }

    /// The table `[limit]`; nothing where there is none.
    pub fn limit_table(&self) -> String {
        let limit = self.limit.as_ref().map(|limit| AskedLimit { of: &limit.of, probability: &limit.targets });
        text_of(&Asked { limit, ..Asked::default() })
    }

    /// The spec of the job with everything that its result depends on.
    pub(super) fn written_out(&self) -> JobSpec {
        let Tables { model, mut criterion } = self.model.tables(&self.grid);
        if self.outside_physics != OutsidePhysics::default() {
            criterion.extend(table_of(&BTreeMap::from([("outside_physics", self.outside_physics)])));
        }
        let axes = self.grid.axes.iter().map(|axis| AxisEntry {
            name: written(self.quantity(axis.quantity).name.to_string()),
            axis: written(AxisSpec::Values(axis.axis.values().to_vec())),
        });
        JobSpec {
            name: Some(written(self.name.clone())),
            description: Some(self.description.clone()),
            model: Some(model.into()),
            axes: AxesSpec(axes.collect()),
            random: self.random_written_out(),
            criterion: Some(criterion.into()),
            sampling: (&self.sampling).into(),
            limit: None,
            target: None,
        }
    }

    /// The random inputs.
    fn random_written_out(&self) -> RandomSpec {
        let random = &self.random;
        let name = |i: usize| self.quantity_of(i).name.to_string();
        let inputs = || 0..random.inputs.len();
        let is_absolute = |i: usize| random.is_absolute(i);
        let first = random.relative_stds.first();
        // Measured values have their own standard deviation, which is not given.
        let is_free = |&i: &usize| own_std(&random.marginals[i]).is_none() && !is_absolute(i);
        let given = |stds: &Vec<f64>| -> BTreeMap<String, f64> {
            inputs().filter(is_free).map(|i| (name(i), stds[i])).collect()
        };
        let relative_stds = random.relative_stds.iter().map(given).filter(|stds| !stds.is_empty());
        let relative_stds: Vec<StdSpec> = relative_stds.map(StdSpec::Each).collect();
        let absolute = inputs().filter(|&i| is_absolute(i));
        let stds: BTreeMap<_, _> = absolute.filter_map(|i| Some((written(name(i)), written(first?[i])))).collect();
        let others = inputs().filter(|&i| random.marginals[i] != Marginal::Normal);
        let distributions: BTreeMap<String, MarginalSpec> =
            others.map(|i| (name(i), MarginalSpec::Given(random.marginals[i].clone()))).collect();
        // In one order, however they are written.
        let mut pairs: Vec<_> = random.pairs.iter().map(|&(i, j, rho)| (i.min(j), i.max(j), rho)).collect();
        pairs.sort_by_key(|&(i, j, _)| (i, j));
        RandomSpec {
            inputs: Some(written(inputs().map(|i| written(name(i))).collect())),
            relative_std: (!relative_stds.is_empty()).then(|| written(RelativeStdSpec(relative_stds))),
            std: (!stds.is_empty()).then(|| written(stds)),
            distribution: (!distributions.is_empty()).then(|| written(DistributionSpec::Each(distributions))),
            correlation: (!pairs.is_empty())
                .then(|| written(pairs.into_iter().map(|(i, j, rho)| written((name(i), name(j), rho))).collect())),
        }
    }
}

/// Keys that have no meaning for the method are absent.
impl From<&Sampling> for SamplingSpec {
    fn from(sampling: &Sampling) -> Self {
        let samples = match sampling.effort {
            Effort::Samples(samples) => Some(samples),
            Effort::Randomisations { count, points } => Some(count * points),
            Effort::Until(_) => None,
        };
        let randomisations = match sampling.effort {
            Effort::Randomisations { count, .. } => Some(count),
            _ => None,
        };
        let until = sampling.until.map(|Precision { half_width, relative }| UntilSpec {
            half_width,
            relative,
            confidence: Some(sampling.confidence),
            at_most: Some(sampling.samples),
        });
        let takes = |key: Key| sampling.method.takes(key);
        // What is integrated is audited with samples.
        let draws = sampling.samples > 0 || sampling.is_audited || sampling.has_plain_samples();
        let is_unusual = sampling.audit != sampling.usual_audit;
        let has_audit = sampling.is_audited || sampling.evaluate == EvaluateMode::Boundary || is_unusual;
        let interval = sampling.interval.filter(|interval| *interval != IntervalSpec::Wilson);
        let if_true = |value: bool| value.then(|| written(true));
        Self {
            method: Some(written(sampling.method.written())),
            samples: samples.filter(|_| takes(Key::Samples)).map(written),
            seed: draws.then(|| written(sampling.seed)),
            evaluate: takes(Key::Evaluate).then(|| written(sampling.evaluate)),
            common_random_numbers: takes(Key::CommonRandomNumbers).then(|| written(sampling.common_random_numbers)),
            confidence: (draws && takes(Key::Confidence)).then(|| written(sampling.confidence)),
            audit: has_audit.then(|| written(sampling.audit)),
            randomisations: randomisations.map(written),
            particles: sampling.particles.map(written),
            interval: interval.map(written),
            simultaneous: if_true(sampling.simultaneous),
            derivatives: if_true(sampling.derivatives),
            sensitivity: if_true(sampling.sensitivity),
            until: until.map(written),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use crate::job::{Job, JobSource};

    #[test]
    #[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
    fn a_shipped_job_and_its_normalised_form_are_one_job() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../jobs");
        let mut count = 0;
        for entry in fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.extension().is_none_or(|extension| extension != "toml") {
                continue;
            }
            let job = JobSource { text: fs::read_to_string(&path).unwrap(), path: path.clone() }.job().unwrap();
            assert!(job.warnings().is_empty(), "{}: {:?}", path.display(), job.warnings());
            let text = job.normalised();
            // Files of matrices are named without their folder there.
            let files = path.with_extension("");
            let beside = if files.is_dir() { files } else { folder.clone() };
            let again = JobSource { path: beside.join("normalised.toml"), text: text.clone() }.job().unwrap();
            assert_eq!(again.hash(), job.hash(), "{}", path.display());
            assert_eq!(again.normalised(), text, "{}", path.display());
            let text = job.with_all_keys();
            let again = JobSource { path: beside.join("all.toml"), text: text.clone() }.job().unwrap();
            assert_eq!(again.hash(), job.hash(), "{}", path.display());
            let asked = |job: &Job| (job.limit.clone(), job.target, job.operating_point);
            assert_eq!(asked(&again), asked(&job), "{}", path.display());
            assert_eq!(again.with_all_keys(), text, "{}", path.display());
            assert!(text.contains("outside_physics = "), "{text}");
            count += 1;
        }
        assert!(count > 20);
        // Intervals of their own kind, which the key does not name.
        let first = fs::read_to_string(folder.join("table3.toml")).unwrap();
        for sampling in ["simultaneous = true", "confidence = 0.99999"] {
            let text = first.replace("[sampling]", &format!("[sampling]\n{sampling}"));
            let job = JobSource { text, path: folder.join("interval.toml") }.job().unwrap();
            let text = job.with_all_keys();
            assert_eq!(
                JobSource { text, path: folder.join("all.toml") }.job().unwrap().hash(),
                job.hash(),
                "{sampling}"
            );
        }
    }
}
