//! The identity of a job: a hash of every value that its result depends on.
//!
//! Each value enters the hash under the name of its key, with its type, its length where it has one, and its bits. The
//! hash thus depends on no printer of numbers and on no order of a file. The values are those of the normalised job, see
//! [`normalised`](super::normalised): the name and the description do not belong to them, nor do keys that the job's
//! method or criterion has no use for.

use stickslip_core::criterion::time_domain::VERDICTS_VERSION;
use stickslip_sampler::draw::identity::{ESTIMATES_VERSION, RESULTS_VERSION};
use stickslip_sampler::verdict_map::resolve::MAP_VERSION;

use super::criterion::Criterion;
use super::criterion_spec::{CriterionKind, DiscKind, OutsidePhysics, Record, StartKind};
use super::normalised::{
    NormalisedAxes, NormalisedCriterion, NormalisedExperiment, NormalisedIndex, NormalisedMarginal, NormalisedModel,
    NormalisedRandom, NormalisedSampling, NormalisedUntil, model,
};
use super::sampling_spec::{Audit, EvaluateMode, IntervalSpec, SamplingMethod};
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

    /// Identifies what decides a sample at one rotating speed: jobs that agree in it can share verdict maps.
    pub fn map_key(&self, rotating_speed: f64) -> String {
        let mut hash = self.begin("verdict map");
        hash.whole("map version", MAP_VERSION.into());
        hash.real("rotating_speed", rotating_speed);
        hash.model(&model(self));
        hash.criterion(&(&self.criterion).into());
        hash.finish()
    }

    fn hash_experiment(&self, experiment: &NormalisedExperiment<'_>) -> String {
        let mut hash = self.begin("job");
        if self.has_later_estimates() {
            hash.whole("estimates version", ESTIMATES_VERSION.into());
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
        self.0.update(&value.to_bits().to_le_bytes());
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
        for value in values {
            self.0.update(&value.to_bits().to_le_bytes());
        }
    }

    fn finish(&self) -> String {
        self.0.finalize().to_hex().to_string()
    }

    fn model(&mut self, model: &NormalisedModel) {
        self.list("model", model.len());
        for (section, values) in model {
            self.list(section, values.len());
            for (name, &value) in values {
                self.real(name, value);
            }
        }
    }

    fn axes(&mut self, axes: &NormalisedAxes<'_>) {
        let NormalisedAxes { rotating_speed, preload, static_friction } = axes;
        self.reals("axes.rotating_speed", rotating_speed);
        self.reals("axes.preload", preload);
        self.reals("axes.static_friction", static_friction);
    }

    fn random(&mut self, random: &NormalisedRandom) {
        let NormalisedRandom { inputs, relative_std, correlation, distribution } = random;
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
        self.list("random.correlation", correlation.len());
        for (first, second, coefficient) in correlation {
            self.word("first", first);
            self.word("second", second);
            self.real("coefficient", *coefficient);
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
            self.word(
                "criterion.start",
                match start {
                    StartKind::NearEquilibrium => "near-equilibrium",
                    StartKind::Rest => "rest",
                    StartKind::LimitCycle => "limit-cycle",
                },
            );
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
            },
        );
        for (key, value) in
            [("sampling.samples", samples), ("sampling.seed", seed), ("sampling.randomisations", randomisations)]
        {
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
mod tests {
    use std::collections::BTreeMap;
    use std::path::PathBuf;

    use stickslip_core::parameters::SCALARS;

    use super::*;
    use crate::job::JobSource;

    fn job(text: &str) -> Job {
        JobSource { path: PathBuf::from("job.toml"), text: text.to_owned() }.job().unwrap()
    }

    const PLAIN: &str = r#"
name = "plain"
description = "what it is for"
[axes]
rotating_speed = 15.0
preload = [0.05, 0.1]
static_friction = [0.3, 0.4]
[random]
inputs = ["preload", "static_friction", "pad.mass"]
relative_std = { preload = 0.2, static_friction = 0.1, "pad.mass" = 0.3 }
distribution = { preload = "lognormal" }
correlation = [["preload", "static_friction", 0.3]]
[criterion]
kind = "time-domain"
disc = "flexible"
disc_modes = 5
start = "rest"
displacement = 0.01
horizon = 5000.0
index = { amplitude = 0.002 }
record = ["amplitude"]
[sampling]
method = "monte-carlo"
samples = 1000
seed = 1
evaluate = "each"
common_random_numbers = false
confidence = 0.95
interval = "wilson"
"#;

    const MAPPED: &str = r#"
name = "mapped"
[axes]
rotating_speed = 15.0
preload = [0.05, 0.1]
static_friction = [0.3, 0.4]
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
[criterion]
kind = "time-domain"
disc = "rigid"
[sampling]
evaluate = "boundary"
audit = 900
until = { half_width = 0.01, confidence = 0.95, at_most = 100_000 }
"#;

    const SOBOL: &str = r#"
name = "sobol"
[axes]
preload = [0.05, 0.1]
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.2
[criterion]
kind = "coupled-eigenvalue"
[sampling]
method = "sobol"
samples = 8192
randomisations = 16
"#;

    #[test]
    fn identities_do_not_change_with_the_libraries() {
        let hashes = [PLAIN, MAPPED, SOBOL].map(|text| job(text).hash());
        let [plain, mapped, sobol] = hashes.map(|hash| hash[..16].to_owned());
        assert_eq!([plain, mapped, sobol], ["981722f703856f12", "fe20df6649865f51", "35dc7e58e0e43418"]);
        let job = job(MAPPED);
        let others = [job.experiment_hash(), job.map_key(15.0)].map(|hash| hash[..16].to_owned());
        assert_eq!(others, ["cb611e64184df9fa", "b6ece79a4b450902"]);
    }

    #[test]
    fn every_key_that_changes_results_changes_the_identity() {
        let cases: &[(&str, &[(&str, &str)])] = &[
            (
                PLAIN,
                &[
                    ("rotating_speed = 15.0", "rotating_speed = 15.000000000000002"),
                    ("rotating_speed = 15.0", "rotating_speed = [15.0, 16.0]"),
                    ("preload = [0.05, 0.1]", "preload = [0.05, 0.11]"),
                    ("preload = [0.05, 0.1]", "preload = [0.1, 0.05]"),
                    ("static_friction = [0.3, 0.4]", "static_friction = [0.3]"),
                    (
                        ", \"pad.mass\"]\nrelative_std = { preload = 0.2, static_friction = 0.1, \"pad.mass\" = 0.3 }",
                        "]\nrelative_std = { preload = 0.2, static_friction = 0.1 }",
                    ),
                    ("\"pad.mass\" = 0.3 }", "\"pad.mass\" = 0.31 }"),
                    ("{ preload = 0.2, static_friction = 0.1,", "{ preload = 0.1, static_friction = 0.2,"),
                    ("{ preload = \"lognormal\" }", "{ static_friction = \"lognormal\" }"),
                    ("{ preload = \"lognormal\" }", "{ preload = \"uniform\" }"),
                    ("{ preload = \"lognormal\" }", "{ preload = \"weibull\" }"),
                    ("{ preload = \"lognormal\" }", "{ preload = \"gumbel\" }"),
                    ("{ preload = \"lognormal\" }", "{ preload = \"triangular\" }"),
                    ("{ preload = \"lognormal\" }", "{ preload = { triangular = 0.4 } }"),
                    ("{ preload = \"lognormal\" }", "{ preload = { truncated-normal = [-2.0, 3.0] } }"),
                    ("{ preload = \"lognormal\" }", "{ preload = { truncated-normal = [-2.0, 4.0] } }"),
                    ("{ preload = \"lognormal\" }", "{ preload = { beta = [0.2, 3.0] } }"),
                    ("{ preload = \"lognormal\" }", "\"lognormal\""),
                    ("\"static_friction\", 0.3]]", "\"static_friction\", -0.3]]"),
                    ("\"static_friction\", 0.3]]", "\"pad.mass\", 0.3]]"),
                    ("correlation = [[\"preload\", \"static_friction\", 0.3]]", ""),
                    (
                        "kind = \"time-domain\"\ndisc = \"flexible\"\ndisc_modes = 5\nstart = \"rest\"\ndisplacement = 0.01\nhorizon = 5000.0\nindex = { amplitude = 0.002 }\nrecord = [\"amplitude\"]",
                        "kind = \"eigenvalue\"",
                    ),
                    ("disc = \"flexible\"\ndisc_modes = 5", "disc = \"rigid\""),
                    ("disc_modes = 5", "disc_modes = 6"),
                    ("start = \"rest\"", "start = \"limit-cycle\""),
                    ("start = \"rest\"", "start = \"near-equilibrium\""),
                    ("displacement = 0.01", "displacement = 0.02"),
                    ("horizon = 5000.0", "horizon = 6000.0"),
                    ("amplitude = 0.002", "amplitude = 0.003"),
                    ("index = { amplitude = 0.002 }", ""),
                    ("record = [\"amplitude\"]", ""),
                    ("samples = 1000", "samples = 1001"),
                    ("seed = 1", "seed = 2"),
                    ("common_random_numbers = false", "common_random_numbers = true"),
                    ("confidence = 0.95", "confidence = 0.94"),
                    ("interval = \"wilson\"", "interval = \"clopper-pearson\""),
                    ("interval = \"wilson\"", "simultaneous = true"),
                ],
            ),
            (
                MAPPED,
                &[
                    ("evaluate = \"boundary\"\naudit = 900", "evaluate = \"each\""),
                    ("audit = 900", "audit = 1000"),
                    (
                        "audit = 900\nuntil = { half_width = 0.01, confidence = 0.95, at_most = 100_000 }",
                        "audit = 0.01",
                    ),
                    ("half_width = 0.01", "half_width = 0.02"),
                    ("confidence = 0.95", "confidence = 0.9"),
                    ("at_most = 100_000", "at_most = 200_000"),
                    (
                        "evaluate = \"boundary\"\naudit = 900\nuntil = { half_width = 0.01,",
                        "until = { relative = 0.01,",
                    ),
                    ("until = { half_width = 0.01, confidence = 0.95, at_most = 100_000 }", "derivatives = true"),
                    (
                        "evaluate = \"boundary\"\naudit = 900\nuntil = { half_width = 0.01, confidence = 0.95, at_most = 100_000 }",
                        "sensitivity = true",
                    ),
                    (
                        "evaluate = \"boundary\"\naudit = 900\nuntil = { half_width = 0.01, confidence = 0.95, at_most = 100_000 }",
                        "method = \"exact\"",
                    ),
                ],
            ),
            (
                SOBOL,
                &[
                    ("randomisations = 16", "randomisations = 32"),
                    ("method = \"sobol\"\nsamples = 8192\nrandomisations = 16", "samples = 8192"),
                ],
            ),
        ];
        let mut seen = BTreeMap::new();
        let mut note = |text: &str, what: String| {
            if let Some(other) = seen.insert(job(text).hash(), what.clone()) {
                panic!("{what} and {other} have the same identity");
            }
        };
        for (base, changes) in cases {
            note(base, format!("the job {}", base.lines().nth(1).unwrap()));
            for (from, to) in *changes {
                assert!(base.contains(from), "{from}");
                note(&base.replacen(from, to, 1), format!("{from} -> {to}"));
            }
        }
        let preset = stickslip_core::parameters::Parameters::sui_ding_2018();
        for scalar in &SCALARS {
            if scalar.section() != "operating_point" && scalar.key != "friction.static_coefficient" {
                let value = 0.999 * scalar.value(&preset);
                let (section, name) = (scalar.section(), scalar.name());
                note(
                    &SOBOL.replace("[axes]", &format!("[model.{section}]\n{name} = {value}\n[axes]")),
                    scalar.key.to_owned(),
                );
            }
        }
    }

    #[test]
    fn names_and_defaults_do_not_belong_to_the_identity() {
        for (base, from, to) in [
            (PLAIN, "name = \"plain\"", "name = \"other\""),
            (PLAIN, "description = \"what it is for\"", ""),
            (PLAIN, "interval = \"wilson\"", ""),
            (PLAIN, "displacement = 0.01", ""),
            (PLAIN, "method = \"monte-carlo\"", ""),
            (SOBOL, "[axes]", "[model.damping]\ntangential = 369.0\n[axes]"),
            (SOBOL, "[axes]", "[axes]\nrotating_speed = 16"),
            (
                SOBOL,
                "relative_std = 0.2",
                "relative_std = { preload = 0.2, static_friction = 0.2 }\ndistribution = \"normal\"",
            ),
            (SOBOL, "method = \"sobol\"", "method = \"sobol\"\nseed = 0\nconfidence = 0.95"),
        ] {
            assert!(base.contains(from), "{from}");
            assert_eq!(job(base).hash(), job(&base.replacen(from, to, 1)).hash(), "{from} -> {to}");
        }
    }

    #[test]
    fn samples_are_shared_whatever_their_number() {
        for (base, from, to) in [
            (PLAIN, "samples = 1000", "samples = 2000"),
            (MAPPED, "at_most = 100_000", "at_most = 200_000"),
            (SOBOL, "samples = 8192", "samples = 16384"),
        ] {
            assert_eq!(job(base).experiment_hash(), job(&base.replace(from, to)).experiment_hash());
            let reseeded = base.replace("seed = 1\n", "").replace("[sampling]", "[sampling]\nseed = 77");
            assert_ne!(job(base).experiment_hash(), job(&reseeded).experiment_hash());
        }
    }

    #[test]
    fn maps_are_shared_where_model_speed_and_criterion_agree() {
        let key = |text: &str, speed: f64| job(text).map_key(speed);
        let own = key(MAPPED, 15.0);
        assert_eq!(
            own,
            key(&MAPPED.replace("preload = [0.05, 0.1]", "preload = 0.2").replace("audit = 900", "audit = 1000"), 15.0)
        );
        assert_ne!(own, key(MAPPED, 16.0));
        assert_ne!(own, key(&MAPPED.replace("disc = \"rigid\"", "disc = \"rigid\"\nhorizon = 9000"), 15.0));
        assert_ne!(own, key(&MAPPED.replace("[axes]", "[model.pad]\nmass = 0.11\n[axes]"), 15.0));
        assert_ne!(own, job(MAPPED).hash());
    }
}
