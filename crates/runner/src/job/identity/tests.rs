use std::collections::BTreeMap;
use std::path::PathBuf;

use stickslip_core::models::pad_on_disc::parameters::SCALARS;

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
fn limits_belong_to_no_identity() {
    let plain = job(SOBOL.replace("coupled-eigenvalue", "eigenvalue").as_str());
    let limit = "[limit]\nof = \"preload\"\nprobability = [0.01, 1e-5]\n";
    let with = job(&format!("{}{limit}", SOBOL.replace("coupled-eigenvalue", "eigenvalue")));
    assert_eq!(with.limit.as_ref().unwrap().targets, [0.01, 1e-5]);
    assert_eq!((with.hash(), with.normalised()), (plain.hash(), plain.normalised()));
}

/// Of a motion on a flexible disc 16 plain samples are usual, else 300.
#[test]
fn a_given_number_of_plain_samples_is_taken_where_it_is_that_of_other_models_too() {
    let of = |criterion: &str, audit: &str| {
        job(&format!(
            "name = \"j\"\n[axes]\npreload = [0.05, 0.1]\n[random]\ninputs = [\"preload\", \"static_friction\"]\n\
             relative_std = 0.2\n[criterion]\nkind = \"time-domain\"\n{criterion}\n[sampling]\nmethod = \"importance\"\n\
             samples = 160\n{audit}\n"
        ))
    };
    for (criterion, usual, other) in [("disc = \"flexible\"\ndisc_modes = 5", 16, 300), ("disc = \"rigid\"", 300, 16)] {
        let plain = of(criterion, "");
        let [same, differing] = [usual, other].map(|samples| of(criterion, &format!("audit = {samples}")));
        assert_eq!([plain.plain_samples(), same.plain_samples(), differing.plain_samples()], [usual, usual, other]);
        assert!(plain.hash() == same.hash() && plain.hash() != differing.hash(), "{criterion}");
        for job_of in [plain, same, differing] {
            assert_eq!(job(&job_of.normalised()).plain_samples(), job_of.plain_samples(), "{criterion}");
        }
        assert_eq!(of(criterion, "audit = 0").plain_samples(), 0);
    }
}

#[test]
fn plain_samples_are_a_tenth_of_what_a_probability_takes_itself_within_bounds() {
    let of = |disc: &str, sampling: &str| {
        let text = SOBOL.replace("kind = \"coupled-eigenvalue\"", disc);
        let keys = text.split_once("method").unwrap().0;
        job(&format!("{keys}{sampling}\n"))
    };
    let rigid = "kind = \"time-domain\"\ndisc = \"rigid\"";
    let flexible = "kind = \"time-domain\"\ndisc = \"flexible\"\ndisc_modes = 5";
    let importance = |samples: u64| format!("method = \"importance\"\nsamples = {samples}");
    for (samples, [usual, slow]) in
        [(160, [300, 16]), (2000, [300, 200]), (8192, [819, 819]), (1 << 30, [1_000_000, 1_000_000])]
    {
        let of_disc = |disc: &str| of(disc, &importance(samples));
        assert_eq!([rigid, flexible].map(|disc| of_disc(disc).plain_samples()), [usual, slow], "{samples}");
        // Where it is not known how long a sample takes.
        assert_eq!([rigid, flexible].map(|disc| of_disc(disc).certain_plain_samples()), [slow, slow], "{samples}");
        let given = of(rigid, &format!("{}\naudit = 700", importance(samples)));
        assert_eq!([given.plain_samples(), given.certain_plain_samples()], [700, 700], "{samples}");
    }
    let of = |disc: &str, sampling: &str| of(disc, sampling).plain_samples();
    // 16 populations of 1000 particles take at least 16,000 verdicts.
    assert_eq!(of(rigid, "method = \"subset\""), 1600);
    assert_eq!(of(rigid, "method = \"subset\"\nparticles = 100\nrandomisations = 8"), 300);
    assert_eq!(of("kind = \"eigenvalue\"", "method = \"exact\""), 300);
}

/// Those of a probability, but not those that check verdicts looked up in a map: these decide what they estimate.
#[test]
fn runs_that_differ_in_plain_samples_share_their_samples() {
    let importance = SOBOL.replace("\"sobol\"", "\"importance\"").replace("coupled-eigenvalue", "eigenvalue");
    let audited = format!("{importance}audit = 5000\n");
    assert_ne!(job(&importance).hash(), job(&audited).hash());
    assert_eq!(job(&importance).experiment_hash(), job(&audited).experiment_hash());
    let looked_up = MAPPED.replace("audit = 900", "audit = 5000");
    assert_ne!(job(MAPPED).experiment_hash(), job(&looked_up).experiment_hash());
}

#[test]
fn identities_do_not_change_with_the_libraries() {
    // Of format version 1 and results version 1.
    let hashes = [PLAIN, MAPPED, SOBOL].map(|text| job(text).hash());
    let [plain, mapped, sobol] = hashes.map(|hash| hash[..16].to_owned());
    assert_eq!([plain, mapped, sobol], ["59e5f87cd7a04ab9", "47935a662d4bc6e1", "befc66bcf0124a3c"]);
    let job = job(MAPPED);
    let others = [job.experiment_hash(), job.map_key(0)].map(|hash| hash[..16].to_owned());
    assert_eq!(others, ["4b1a463fe4e28497", "5bf867b75d5a9c42"]);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
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
                ("start = \"rest\"", "start = { velocity = 0.1 }"),
                ("start = \"rest\"", "start = { velocity = 0.2 }"),
                ("start = \"rest\"", "start = { tangential = 0.0 }"),
                ("start = \"rest\"", "start = { velocity = 0.1, from_equilibrium = true }"),
                ("start = \"rest\"", "start = { velocity = 0.1, units = \"scaled\" }"),
                ("preload = [0.05, 0.1]", "preload = [0.05, 0.1]\n\"pad.moment_arm\" = [0.007, 0.008]"),
                ("preload = [0.05, 0.1]", "preload = [0.05, 0.1]\n\"pad.moment_arm\" = [0.008, 0.007]"),
                ("preload = [0.05, 0.1]", "preload = [0.05, 0.1]\n\"pad.moment_arm\" = 0.008"),
                ("preload = [0.05, 0.1]", "preload = [0.05, 0.1]\n\"damping.normal\" = [106.1, 107.0]"),
                ("displacement = 0.01", "displacement = 0.02"),
                ("horizon = 5000.0", "horizon = 6000.0"),
                ("amplitude = 0.002", "amplitude = 0.003"),
                ("index = { amplitude = 0.002 }", ""),
                ("record = [\"amplitude\"]", ""),
                ("displacement = 0.01", "displacement = 0.01\noutside_physics = \"failed\""),
                ("displacement = 0.01", "displacement = 0.01\noutside_physics = \"clamp\""),
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
                ("audit = 900\nuntil = { half_width = 0.01, confidence = 0.95, at_most = 100_000 }", "audit = 0.01"),
                ("half_width = 0.01", "half_width = 0.02"),
                ("confidence = 0.95", "confidence = 0.9"),
                ("at_most = 100_000", "at_most = 200_000"),
                ("evaluate = \"boundary\"\naudit = 900\nuntil = { half_width = 0.01,", "until = { relative = 0.01,"),
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
    let preset = stickslip_core::models::pad_on_disc::parameters::Parameters::sui_ding_2018();
    for scalar in &SCALARS {
        let is_of_a_table = scalar.key == "friction.band";
        if scalar.section() != "operating_point" && scalar.key != "friction.static_coefficient" && !is_of_a_table {
            let preset_value = scalar.value(&preset);
            let value = if preset_value == 0.0 { 0.1 } else { 0.999 * preset_value };
            let (section, name) = (scalar.section(), scalar.name());
            note(
                &SOBOL.replace("[axes]", &format!("[model.{section}]\n{name} = {value}\n[axes]")),
                scalar.key.to_owned(),
            );
        }
    }
}

#[test]
fn the_friction_law_and_its_curve_belong_to_the_identity() {
    let with = |friction: &str| job(&SOBOL.replace("[axes]", &format!("[model.friction]\n{friction}\n[axes]"))).hash();
    let table = |curve: &str, more: &str| with(&format!("law = \"table\"\ntable = {{ {curve} }}{more}"));
    let curve = "speed = [0, 1], coefficient = [0.4, 0.3]";
    let hashes = [
        with("stribeck_velocity = 0.72"),
        with("law = \"rational\""),
        with("law = \"rational\"\nviscous = 0.1"),
        table(curve, ""),
        table("speed = [0, 1], coefficient = [0.4, 0.31]", ""),
        table("speed = [0, 2], coefficient = [0.4, 0.3]", ""),
        table(&format!("{curve}, std = [0, 0.1]"), ""),
        table(&format!("{curve}, std = [0, 0.1]"), "\nband = 1"),
    ];
    for (i, hash) in hashes.iter().enumerate() {
        assert!(!hashes[..i].contains(hash), "{i}");
    }
    assert_eq!(hashes[0], with("law = \"stribeck\""));
    assert_eq!(hashes[0], job(SOBOL).hash());
    assert_eq!(hashes[3], table(curve, "\nband = 0"));
}

#[test]
fn starts_that_vary_belong_to_the_identity() {
    let rigid = |axes: &str, random: &str, start: &str| {
        let text = format!(
            "name = \"start\"\n[axes]\n{axes}\n[random]\n{random}\n[criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\n{start}\n"
        );
        job(&text).hash()
    };
    let scatter = |std: f64| format!("inputs = [\"start.velocity\"]\nstd = {{ \"start.velocity\" = {std} }}");
    let hashes = [
        rigid("", "", "start = {}"),
        rigid("start.velocity = 0.1", "", ""),
        rigid("start.velocity = [0.1, 0.2]", "", ""),
        rigid("start.tangential = [0.1, 0.2]", "", "start = { units = \"scaled\" }"),
        rigid("", &scatter(0.1), ""),
        rigid("", &scatter(0.2), ""),
        rigid("", &scatter(0.1), "start = { velocity = 0.1 }"),
    ];
    for (i, hash) in hashes.iter().enumerate() {
        assert!(!hashes[..i].contains(hash), "{i}");
    }
    // A start that is axis or random needs no key of its own.
    assert_eq!(rigid("start.velocity = 0.1", "", ""), rigid("start.velocity = 0.1", "", "start = {}"));
    assert_eq!(rigid("", &scatter(0.1), ""), rigid("", &scatter(0.1), "start = { velocity = 0.0 }"));
}

#[test]
fn names_and_defaults_do_not_belong_to_the_identity() {
    for (base, from, to) in [
        (PLAIN, "name = \"plain\"", "name = \"other\""),
        (PLAIN, "description = \"what it is for\"", ""),
        (PLAIN, "interval = \"wilson\"", ""),
        (PLAIN, "displacement = 0.01", ""),
        (PLAIN, "method = \"monte-carlo\"", ""),
        (PLAIN, "[[\"preload\", \"static_friction\", 0.3]]", "[[\"static_friction\", \"preload\", 0.3]]"),
        (PLAIN, "horizon = 5000.0", "horizon = 5000.0\noutside_physics = \"stable\""),
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
    let key = |text: &str, speed: f64| {
        job(&text.replace("rotating_speed = 15.0", &format!("rotating_speed = {speed}"))).map_key(0)
    };
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

#[test]
fn values_that_json_cannot_hold_have_different_hashes() {
    let of = |value: u8| hashed("job", &BTreeMap::from([((1, 2), value)]));
    assert_ne!(of(1), of(2));
    assert_eq!(of(1), of(1));
}
