//! A job written out in full, as TOML that can itself be submitted, and its identity.

use std::collections::BTreeMap;

use serde::Serialize;
use stickslip_core::criterion::time_domain::VERDICTS_VERSION;
use stickslip_core::parameters::SCALARS;
use stickslip_sampler::draw::identity::{ESTIMATES_VERSION, RESULTS_VERSION};
use stickslip_sampler::verdict_map::resolve::MAP_VERSION;

use super::criterion::{Criterion, NormalisedCriterion};
use super::random::NormalisedRandom;
use super::sampling::NormalisedSampling;
use super::validated::Job;

impl Job {
    /// The job with everything written out, as TOML that can itself be submitted.
    pub fn normalised(&self) -> String {
        self.to_toml(&self.sampling.normalised(), &self.name, &self.description)
    }

    /// Identifies the job: everything that its result depends on.
    pub fn hash(&self) -> String {
        self.hash_job(self.to_toml(&self.sampling.normalised(), "", ""))
    }

    /// Identifies the job but for the number of samples: runs that agree in it share their samples.
    pub fn experiment_hash(&self) -> String {
        let sampling = self.sampling.normalised().for_any_number();
        self.hash_job(self.to_toml(&sampling, "", ""))
    }

    /// Identifies what decides a sample at one rotating speed: jobs that agree in it can share verdict maps.
    pub fn map_key(&self, rotating_speed: f64) -> String {
        let verdicts =
            NormalisedVerdicts { model: self.model(), rotating_speed, criterion: self.criterion.normalised() };
        let text = toml::to_string(&verdicts).unwrap_or_else(|error| format!("# not representable: {error}\n"));
        self.hash_text(&format!("verdict map {MAP_VERSION}\n{text}"))
    }

    /// A hash of a text and of the versions behind results and verdicts.
    fn hash_text(&self, text: &str) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&RESULTS_VERSION.to_le_bytes());
        if !matches!(self.criterion, Criterion::Eigenvalue) {
            hasher.update(&VERDICTS_VERSION.to_le_bytes());
        }
        hasher.update(text.as_bytes());
        hasher.finalize().to_hex().to_string()
    }

    /// The same of a text of the job, with the version of the estimates where that matters.
    fn hash_job(&self, mut text: String) -> String {
        if self.has_later_estimates() {
            text += &format!("estimates version {ESTIMATES_VERSION}\n");
        }
        self.hash_text(&text)
    }

    fn model(&self) -> BTreeMap<&'static str, BTreeMap<&'static str, f64>> {
        let mut model = BTreeMap::new();
        for scalar in &SCALARS {
            // These are the axes' business.
            let is_axis = scalar.section() == "operating_point" || scalar.key == "friction.static_coefficient";
            if !is_axis {
                let section: &mut BTreeMap<_, _> = model.entry(scalar.section()).or_default();
                section.insert(scalar.name(), scalar.value(&self.parameters));
            }
        }
        model
    }

    fn to_toml(&self, sampling: &NormalisedSampling, name: &str, description: &str) -> String {
        let normalised = NormalisedJob {
            name,
            description,
            model: self.model(),
            axes: NormalisedAxes {
                rotating_speed: self.grid.rotating_speed.values(),
                preload: self.grid.preload.values(),
                static_friction: self.grid.static_friction.values(),
            },
            random: self.random.normalised(),
            criterion: self.criterion.normalised(),
            sampling,
        };
        // Strings, numbers, lists and tables only: there is nothing in it that TOML cannot hold.
        toml::to_string(&normalised).unwrap_or_else(|error| format!("# not representable: {error}\n"))
    }
}

#[derive(Serialize)]
struct NormalisedVerdicts {
    rotating_speed: f64,
    model: BTreeMap<&'static str, BTreeMap<&'static str, f64>>,
    criterion: NormalisedCriterion,
}

#[derive(Serialize)]
struct NormalisedJob<'a> {
    name: &'a str,
    description: &'a str,
    model: BTreeMap<&'static str, BTreeMap<&'static str, f64>>,
    axes: NormalisedAxes<'a>,
    random: NormalisedRandom,
    criterion: NormalisedCriterion,
    sampling: &'a NormalisedSampling,
}

#[derive(Serialize)]
struct NormalisedAxes<'a> {
    rotating_speed: &'a [f64],
    preload: &'a [f64],
    static_friction: &'a [f64],
}
