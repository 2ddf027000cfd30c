//! The identity of a job: a hash of every value that its result depends on.
//!
//! Each value enters the hash under the name of its key, with its type, its length where it has one, and its bits. The
//! hash thus depends on no printer of numbers and on no order of a file. The values are those of the normalised job,
//! see [`normalised`](super::normalised): the name and the description do not belong to them, nor do keys that the
//! job's method or criterion has no use for.

use stickslip_core::criterion::time_domain::VERDICTS_VERSION;
use stickslip_sampler::draw::identity::{ESTIMATES_VERSION, RESULTS_VERSION};
use stickslip_sampler::verdict_map::resolve::MAP_VERSION;

use super::criterion::Criterion;
use super::criterion_spec::{CriterionKind, DiscKind, OutsidePhysics, Record, StartKind, UnitsSpec};
use super::friction::CurveColumns;
use super::normalised::{
    NormalisedAxes, NormalisedCriterion, NormalisedExperiment, NormalisedIndex, NormalisedMarginal, NormalisedModel,
    NormalisedRandom, NormalisedSampling, NormalisedStart, NormalisedUntil, NormalisedValue, model,
};
use super::sampling_spec::{Audit, EvaluateMode, IntervalSpec, SamplingMethod};
use super::start_value::StartValue;
use super::validated::Job;

/// Version of the way in which jobs are identified. Version 1 hashed the TOML text of the normalised job.
pub const IDENTITY_VERSION: u32 = 2;

impl Job {
    /// Identifies the job: everything that its result depends on.
    pub fn hash(&self) -> String {
        self.hash_experiment(&self.into())
    }

    /// Identifies the job but for the number of samples: runs that agree in it share their samples.
    pub fn experiment_hash(&self) -> String {
        let mut experiment = NormalisedExperiment::from(self);
        experiment.sampling.samples = None;
        experiment.sampling.until = experiment.sampling.until.map(|until| NormalisedUntil { at_most: 0, ..until });
        self.hash_experiment(&experiment)
    }

    /// Identifies what decides a sample of one brake of the grid: jobs that agree in it can share verdict maps.
    pub fn map_key(&self, brake: usize) -> String {
        let mut hash = self.begin("verdict map");
        hash.whole("map version", MAP_VERSION.into());
        let cell = self.grid.first_cell_with(brake);
        hash.real("rotating_speed", cell.rotating_speed);
        // The parameters of a grid that was checked are admissible.
        let parameters = self.brakes().in_cell(&cell).unwrap_or_else(|_| self.parameters.clone());
        hash.model(&model(&parameters, &[]));
        hash.criterion(&(&self.criterion).into());
        hash.finish()
    }

    fn hash_experiment(&self, experiment: &NormalisedExperiment<'_>) -> String {
        let mut hash = self.begin("job");
        if self.has_later_estimates() {
            hash.whole("estimates version", ESTIMATES_VERSION.into());
        }
        if self.uses_maps() {
            hash.whole("map version", MAP_VERSION.into());
        }
        let NormalisedExperiment { model, axes, random, criterion, sampling } = experiment;
        hash.model(model);
        hash.axes(axes);
        hash.random(random);
        hash.criterion(criterion);
        hash.sampling(sampling);
        hash.finish()
    }

    /// A hash of what is identified and of the versions behind results and verdicts.
    fn begin(&self, what: &str) -> ValueHasher {
        let mut hash = ValueHasher(blake3::Hasher::new());
        hash.word("what", what);
        hash.whole("identity version", IDENTITY_VERSION.into());
        hash.whole("results version", RESULTS_VERSION.into());
        if !matches!(self.criterion, Criterion::Eigenvalue) {
            hash.whole("verdicts version", VERDICTS_VERSION.into());
        }
        hash
    }
}

/// The bits of a value; zero has one sign.
fn bits(value: f64) -> [u8; 8] {
    (value + 0.0).to_bits().to_le_bytes()
}

/// Hashes values under their names. What is absent is left out.
struct ValueHasher(blake3::Hasher);

impl ValueHasher {
    fn entry(&mut self, key: &str, kind: u8) {
        self.0.update(&(key.len() as u64).to_le_bytes());
        self.0.update(key.as_bytes());
        self.0.update(&[kind]);
    }

    fn real(&mut self, key: &str, value: f64) {
        self.entry(key, b'r');
        self.0.update(&bits(value));
    }

    fn whole(&mut self, key: &str, value: u64) {
        self.entry(key, b'w');
        self.0.update(&value.to_le_bytes());
    }

    fn flag(&mut self, key: &str, value: bool) {
        self.entry(key, b'f');
        self.0.update(&[u8::from(value)]);
    }

    fn word(&mut self, key: &str, value: &str) {
        self.entry(key, b's');
        self.0.update(&(value.len() as u64).to_le_bytes());
        self.0.update(value.as_bytes());
    }

    /// Announces a list; its elements follow.
    fn list(&mut self, key: &str, length: usize) {
        self.entry(key, b'l');
        self.0.update(&(length as u64).to_le_bytes());
    }

    fn reals(&mut self, key: &str, values: &[f64]) {
        self.list(key, values.len());
        for &value in values {
            self.0.update(&bits(value));
        }
    }

    fn finish(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }

    fn model(&mut self, model: &NormalisedModel) {
        self.list("model", model.len());
        for (section, values) in model {
            self.list(section, values.len());
            for (name, value) in values {
                match value {
                    NormalisedValue::Number(value) => self.real(name, *value),
                    NormalisedValue::Word(word) => self.word(name, word),
                    NormalisedValue::Curve(CurveColumns { speed, coefficient, std }) => {
                        self.reals("speed", speed);
                        self.reals("coefficient", coefficient);
                        self.reals("std", std.as_deref().unwrap_or_default());
                    }
                }
            }
        }
    }

    fn axes(&mut self, axes: &NormalisedAxes<'_>) {
        let NormalisedAxes { further, rotating_speed, preload, static_friction } = axes;
        for (name, values) in further {
            self.reals(&format!("axes.{name}"), values);
        }
        self.reals("axes.rotating_speed", rotating_speed);
        self.reals("axes.preload", preload);
        self.reals("axes.static_friction", static_friction);
    }

    fn random(&mut self, random: &NormalisedRandom) {
        let NormalisedRandom { inputs, relative_std, std, correlation, distribution } = random;
        self.list("random.inputs", inputs.len());
        for input in inputs {
            self.word("input", input);
        }
        self.list("random.relative_std", relative_std.len());
        for stds in relative_std {
            self.list("entry", stds.len());
            for (input, &std) in stds {
                self.real(input, std);
            }
        }
        for (input, &std) in std {
            self.real(&format!("random.std.{input}"), std);
        }
        self.list("random.correlation", correlation.len());
        // Neither the order of the pairs nor that of the two inputs of a pair means anything.
        let mut pairs: Vec<_> = correlation.iter().map(|(a, b, rho)| (a.min(b), a.max(b), *rho)).collect();
        pairs.sort_by_key(|&(first, second, _)| (first, second));
        for (first, second, coefficient) in pairs {
            self.word("first", first);
            self.word("second", second);
            self.real("coefficient", coefficient);
        }
        self.list("random.distribution", distribution.len());
        for (input, marginal) in distribution {
            self.word("input", input);
            match marginal {
                NormalisedMarginal::Normal => self.reals("normal", &[]),
                NormalisedMarginal::Lognormal => self.reals("lognormal", &[]),
                NormalisedMarginal::Uniform => self.reals("uniform", &[]),
                NormalisedMarginal::TruncatedNormal(low, high) => self.reals("truncated-normal", &[*low, *high]),
                NormalisedMarginal::Weibull => self.reals("weibull", &[]),
                NormalisedMarginal::Gumbel => self.reals("gumbel", &[]),
                NormalisedMarginal::Triangular(mode) => self.reals("triangular", &[*mode]),
                NormalisedMarginal::Beta(low, high) => self.reals("beta", &[*low, *high]),
                NormalisedMarginal::Values(values) => self.reals("values", values),
            }
        }
    }

    fn criterion(&mut self, criterion: &NormalisedCriterion) {
        let NormalisedCriterion {
            kind,
            disc,
            disc_modes,
            start,
            displacement,
            horizon,
            outside_physics,
            record,
            index,
        } = criterion;
        self.word(
            "criterion.kind",
            match kind {
                CriterionKind::Eigenvalue => "eigenvalue",
                CriterionKind::CoupledEigenvalue => "coupled-eigenvalue",
                CriterionKind::TimeDomain => "time-domain",
            },
        );
        if let Some(disc) = disc {
            self.word(
                "criterion.disc",
                match disc {
                    DiscKind::Flexible => "flexible",
                    DiscKind::Rigid => "rigid",
                },
            );
        }
        if let Some(modes) = disc_modes {
            self.whole("criterion.disc_modes", *modes as u64);
        }
        if let Some(start) = start {
            let name = match start {
                NormalisedStart::Named(StartKind::NearEquilibrium) => "near-equilibrium",
                NormalisedStart::Named(StartKind::Rest) => "rest",
                NormalisedStart::Named(StartKind::LimitCycle) => "limit-cycle",
                NormalisedStart::Given(given) => match given.units {
                    UnitsSpec::Si => "given in SI units",
                    UnitsSpec::Scaled => "given in scaled units",
                },
            };
            self.word("criterion.start", name);
            if let NormalisedStart::Given(given) = start {
                self.flag("criterion.start.from_equilibrium", given.from_equilibrium);
                let start = given.into();
                for number in StartValue::ALL {
                    if let Some(value) = number.of(&start) {
                        self.real(&format!("criterion.{}", number.key()), value);
                    }
                }
            }
        }
        if let Some(displacement) = displacement {
            self.real("criterion.displacement", *displacement);
        }
        if let Some(horizon) = horizon {
            self.real("criterion.horizon", *horizon);
        }
        if let Some(policy) = outside_physics {
            self.word(
                "criterion.outside_physics",
                match policy {
                    OutsidePhysics::Stable => "stable",
                    OutsidePhysics::Failed => "failed",
                    OutsidePhysics::Clamp => "clamp",
                },
            );
        }
        self.list("criterion.record", record.len());
        for Record::Amplitude in record {
            self.word("record", "amplitude");
        }
        if let Some(NormalisedIndex { amplitude }) = index {
            self.real("criterion.index.amplitude", *amplitude);
        }
    }

    fn sampling(&mut self, sampling: &NormalisedSampling) {
        let NormalisedSampling {
            method,
            samples,
            seed,
            evaluate,
            common_random_numbers,
            confidence,
            audit,
            randomisations,
            particles,
            interval,
            simultaneous,
            derivatives,
            sensitivity,
            until,
        } = sampling;
        self.word(
            "sampling.method",
            match method {
                SamplingMethod::MonteCarlo => "monte-carlo",
                SamplingMethod::Sobol => "sobol",
                SamplingMethod::Exact => "exact",
                SamplingMethod::Conditional => "conditional",
                SamplingMethod::Importance => "importance",
                SamplingMethod::Subset => "subset",
            },
        );
        for (key, value) in [
            ("sampling.samples", samples),
            ("sampling.seed", seed),
            ("sampling.randomisations", randomisations),
            ("sampling.particles", particles),
        ] {
            if let Some(value) = value {
                self.whole(key, *value);
            }
        }
        if let Some(evaluate) = evaluate {
            self.word(
                "sampling.evaluate",
                match evaluate {
                    EvaluateMode::Each => "each",
                    EvaluateMode::Boundary => "boundary",
                },
            );
        }
        if let Some(common) = common_random_numbers {
            self.flag("sampling.common_random_numbers", *common);
        }
        if let Some(confidence) = confidence {
            self.real("sampling.confidence", *confidence);
        }
        match audit {
            None => {}
            Some(Audit::Samples(samples)) => self.whole("sampling.audit", *samples),
            Some(Audit::Share(share)) => self.real("sampling.audit", *share),
        }
        if let Some(interval) = interval {
            self.word(
                "sampling.interval",
                match interval {
                    IntervalSpec::Wilson => "wilson",
                    IntervalSpec::ClopperPearson => "clopper-pearson",
                },
            );
        }
        self.flag("sampling.simultaneous", *simultaneous);
        self.flag("sampling.derivatives", *derivatives);
        self.flag("sampling.sensitivity", *sensitivity);
        if let Some(NormalisedUntil { half_width, relative, confidence, at_most }) = until {
            for (key, value) in [("sampling.until.half_width", half_width), ("sampling.until.relative", relative)] {
                if let Some(value) = value {
                    self.real(key, *value);
                }
            }
            self.real("sampling.until.confidence", *confidence);
            self.whole("sampling.until.at_most", *at_most);
        }
    }
}

#[cfg(test)]
mod tests;
