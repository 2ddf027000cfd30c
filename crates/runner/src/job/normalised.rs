//! A job written out in full, as TOML that can itself be submitted, and its identity.

use std::collections::BTreeMap;

use serde::Serialize;
use stickslip_core::parameters::SCALARS;
use stickslip_core::time_domain::VERDICTS_VERSION;
use stickslip_sampler::{RESULTS_VERSION, RelativeStd};

use super::criterion::{Criterion, NormalisedCriterion};
use super::spec::{EvaluateMode, RandomInput, SamplingMethod};
use super::validated::Job;

impl Job {
    /// The job with everything written out, as TOML that can itself be submitted.
    pub fn normalised(&self) -> String {
        self.to_toml(&NormalisedSampling::of(self), &self.name, &self.description)
    }

    /// Identifies the job: everything that its result depends on.
    pub fn hash(&self) -> String {
        self.hash_text(&self.to_toml(&NormalisedSampling::of(self), "", ""))
    }

    /// Identifies the job but for the number of samples: runs that agree in it share their samples.
    pub fn experiment_hash(&self) -> String {
        let sampling = NormalisedSampling { samples: 0, ..NormalisedSampling::of(self) };
        self.hash_text(&self.to_toml(&sampling, "", ""))
    }

    fn hash_text(&self, text: &str) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&RESULTS_VERSION.to_le_bytes());
        if matches!(self.criterion, Criterion::TimeDomain { .. }) {
            hasher.update(&VERDICTS_VERSION.to_le_bytes());
        }
        hasher.update(text.as_bytes());
        hasher.finalize().to_hex().to_string()
    }

    fn to_toml(&self, sampling: &NormalisedSampling, name: &str, description: &str) -> String {
        let mut model = BTreeMap::new();
        for scalar in &SCALARS {
            // These are the axes' business.
            let is_axis = scalar.section() == "operating_point" || scalar.key == "friction.static_coefficient";
            if !is_axis {
                let section: &mut BTreeMap<_, _> = model.entry(scalar.section()).or_default();
                section.insert(scalar.name(), scalar.value(&self.parameters));
            }
        }
        let normalised = NormalisedJob {
            name,
            description,
            model,
            axes: NormalisedAxes {
                rotating_speed: self.grid.rotating_speed.values(),
                preload: self.grid.preload.values(),
                static_friction: self.grid.static_friction.values(),
            },
            random: NormalisedRandom {
                inputs: &self.inputs,
                relative_std: self
                    .grid
                    .relative_std
                    .iter()
                    .filter(|_| !self.inputs.is_empty())
                    .map(|std| self.inputs.iter().map(|&input| (input.name(), std_of(std, input))).collect())
                    .collect(),
            },
            criterion: self.criterion.normalised(),
            sampling,
        };
        // Strings, numbers, lists and tables only: there is nothing in it that TOML cannot hold.
        toml::to_string(&normalised).unwrap_or_else(|error| format!("# not representable: {error}\n"))
    }
}

#[derive(Serialize)]
struct NormalisedJob<'a> {
    name: &'a str,
    description: &'a str,
    model: BTreeMap<&'static str, BTreeMap<&'static str, f64>>,
    axes: NormalisedAxes<'a>,
    random: NormalisedRandom<'a>,
    criterion: NormalisedCriterion,
    sampling: &'a NormalisedSampling,
}

#[derive(Serialize)]
struct NormalisedAxes<'a> {
    rotating_speed: &'a [f64],
    preload: &'a [f64],
    static_friction: &'a [f64],
}

#[derive(Serialize)]
struct NormalisedRandom<'a> {
    inputs: &'a [RandomInput],
    #[serde(skip_serializing_if = "Vec::is_empty")]
    relative_std: Vec<BTreeMap<&'static str, f64>>,
}

#[derive(Serialize)]
struct NormalisedSampling {
    method: SamplingMethod,
    samples: u64,
    seed: u64,
    evaluate: EvaluateMode,
    common_random_numbers: bool,
    confidence: f64,
}

impl NormalisedSampling {
    fn of(job: &Job) -> Self {
        Self {
            method: job.method,
            samples: job.samples,
            seed: job.seed,
            evaluate: job.evaluate,
            common_random_numbers: job.common_random_numbers,
            confidence: job.confidence,
        }
    }
}

fn std_of(std: &RelativeStd, input: RandomInput) -> f64 {
    match input {
        RandomInput::Preload => std.preload,
        RandomInput::StaticFriction => std.static_friction,
    }
}
