//! Probabilities down to 1e-12, by samples with weights and by populations.

#![allow(clippy::disallowed_methods, reason = "expected values are computed as a textbook writes them")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use crate::common::ten_inputs::{expected_of_ten, job_of_ten};
use crate::common::{BOTH, EIGENVALUE, Place, Table, job, submitted};

const IMPORTANCE: &str = "method = \"importance\"\nsamples = 4096\nseed = 2018";
const SUBSET: &str = "method = \"subset\"\nparticles = 200\nseed = 2018";

/// Preload and static friction of jobs in which instability is rare.
const NARROW: &str =
    "inputs = [\"preload\", \"static_friction\"]\nrelative_std = { preload = 0.1, static_friction = 0.05 }";

/// Compares a surface with expected probabilities, those below 1e-15 left out: the share of intervals that contain them,
/// and the largest relative error.
fn compared(table: &Table, expected: &[f64]) -> (f64, f64) {
    let [p, low, high, distrust] = ["p_unstable", "p_low", "p_high", "distrust"].map(|name| table.column(name));
    let (mut covered, mut count, mut largest) = (0, 0, 0.0_f64);
    for (row, &truth) in expected.iter().enumerate().filter(|(_, truth)| **truth > 1e-15) {
        if distrust[row] != 0.0 {
            assert!(p[row].is_nan(), "row {row} is not trusted, but has p = {}", p[row]);
            continue;
        }
        count += 1;
        covered += u32::from(low[row] <= truth && truth <= high[row]);
        largest = largest.max((p[row] / truth - 1.0).abs());
    }
    assert!(count > 0, "no row is trusted");
    (f64::from(covered) / f64::from(count), largest)
}

#[test]
fn rare_events_of_two_inputs_agree_with_the_integral() {
    let place = Place::new();
    let text = |name: &str, sampling: &str| {
        job(name, EIGENVALUE, NARROW, sampling)
            .replace("from = 0.05, to = 0.30", "from = 0.04, to = 0.09")
            .replace("from = 0.28, to = 0.50", "from = 0.28, to = 0.38")
    };
    let exact = submitted(&place, "exact", &text("exact", "method = \"exact\""));
    let expected = exact.column("p_unstable");
    assert!(expected.iter().filter(|p| **p < 1e-6 && **p > 1e-15).count() >= 5, "{expected:?}");
    for (name, sampling, error) in [("importance", IMPORTANCE, 0.1), ("subset", SUBSET, 0.3)] {
        let table = submitted(&place, name, &text(name, sampling));
        let (covered, largest) = compared(&table, expected);
        assert!(covered >= 0.85 && largest < error, "{name}: {covered} covered, relative error {largest}");
        // Only where next to nothing is unstable, no number may be found.
        for (row, &distrust) in table.column("distrust").iter().enumerate() {
            assert!(distrust == 0.0 || expected[row] < 1e-15, "{name}, row {row}: {distrust}, P = {}", expected[row]);
        }
    }
}

#[test]
fn brakes_far_from_the_preset_have_the_probabilities_of_the_integral() {
    let place = Place::new();
    // Numbers from 0 to 1, evenly spread over brakes and parameters.
    let spread =
        |brake: u32, parameter: u32| (f64::from(brake + 1) * 0.618_034 + f64::from(parameter) * 0.414_214).fract();
    let (mut covered, mut cells) = (0.0, 0.0);
    for brake in 0..8 {
        let value = |parameter: u32, middle: f64| middle * (1.4 * (spread(brake, parameter) - 0.5)).exp();
        let kinetic = value(0, 0.25);
        let model = format!(
            "stiffness.contact_tangential_1 = {:e}\nstiffness.contact_tangential_2 = {:e}\nstiffness.contact_normal = {:e}\n\
             damping.tangential = {}\npad.mass = {}\ndisc.thickness = {}\nfriction.stribeck_velocity = {}\n\
             friction.kinetic_coefficient = {kinetic}\nfriction.stribeck_exponent = {}\n",
            value(1, 2.1e7),
            value(2, 2.1e7),
            value(3, 3.8e7),
            value(4, 369.0),
            value(5, 0.1),
            value(6, 0.02),
            value(7, 0.72),
            [0.5, 1.0, 2.0][brake as usize % 3],
        );
        let text = |sampling: &str| {
            format!(
                "name = \"far\"\n[model]\n{model}[axes]\nrotating_speed = {}\npreload = [0.01, 0.03, 0.06, 0.1, 0.2, 0.4]\n\
                 static_friction = {}\n[random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = {{ preload = {}, \
                 static_friction = {} }}\ndistribution = {{ preload = \"weibull\", static_friction = \"lognormal\" }}\n\
                 [criterion]\n{EIGENVALUE}\n[sampling]\n{sampling}\n",
                2.0 + 26.0 * spread(brake, 8),
                kinetic + 0.05 + 0.35 * spread(brake, 9),
                0.02 + 0.2 * spread(brake, 10),
                0.01 + 0.1 * spread(brake, 11),
            )
        };
        let exact = submitted(&place, &format!("exact{brake}"), &text("method = \"exact\""));
        let sampling = format!("method = \"importance\"\nsamples = 4096\nseed = {brake}");
        let table = submitted(&place, &format!("importance{brake}"), &text(&sampling));
        for row in 0..6 {
            let truth = exact.column("p_unstable")[row];
            if (1e-14..1.0 - 1e-9).contains(&truth) {
                let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|name| table.column(name)[row]);
                assert!((p / truth - 1.0).abs() < 0.2, "brake {brake}, row {row}: {p} {truth}");
                covered += f64::from(u8::from(low <= truth && truth <= high));
                cells += 1.0;
            }
        }
    }
    assert!(cells >= 20.0 && covered >= 0.85 * cells, "{covered} of {cells} intervals contain the integral");
}

#[test]
fn rare_events_of_ten_inputs_agree_with_the_closed_form() {
    let place = Place::new();
    for (name, sampling, error) in [("importance", IMPORTANCE, 0.1), ("subset", SUBSET, 0.4)] {
        // Preload and friction are integrated over, except with the second policy.
        for policy in ["stable", "failed"] {
            let criterion = format!("{EIGENVALUE}\noutside_physics = \"{policy}\"");
            let run = format!("{name}-{policy}");
            let table = submitted(&place, &run, &job_of_ten(&run, sampling).replace(EIGENVALUE, &criterion));
            let expected = expected_of_ten(&table);
            assert!(expected.iter().any(|p| *p < 1e-6) && expected.iter().any(|p| *p > 1e-3), "{expected:?}");
            let (covered, largest) = compared(&table, &expected);
            assert!(covered >= 0.75 && largest < error, "{run}: {covered} covered, relative error {largest}");
            let mut rows = table.column("distrust").iter().zip(&expected);
            assert!(rows.all(|(distrust, p)| *distrust == 0.0 || (name == "subset" && *p < 1e-9)), "{run}");
        }
    }
}

#[test]
fn motions_from_rest_have_the_probabilities_of_their_map() {
    // Between the critical speed and the saddle-node of limit cycles, a start from rest decides: a second branch of the
    // boundary beside that of linear stability.
    let place = Place::new();
    let criterion = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"";
    let text = |name: &str, sampling: &str| {
        job(name, criterion, NARROW, sampling)
            .replace("{ from = 0.05, to = 0.30, points = 6 }", "[0.03, 0.04]")
            .replace("{ from = 0.28, to = 0.50, points = 5 }", "0.33")
    };
    let exact = submitted(&place, "exact", &text("exact", "method = \"exact\"\naudit = 0"));
    let expected = exact.column("p_unstable");
    assert!(expected[0] < 1e-8 && expected[0] > 1e-12, "{expected:?}");
    let sampling = "method = \"importance\"\nsamples = 1024\nparticles = 100";
    let table = submitted(&place, "importance", &text("importance", sampling));
    let (covered, largest) = compared(&table, expected);
    assert!(covered == 1.0 && largest < 0.2, "{covered} covered, relative error {largest}");
}

#[test]
fn a_band_of_speeds_is_found_beyond_a_wide_stable_range() {
    // With a Stribeck exponent of 2 very slow sliding is stable too, so that unstable speeds are a band: an island far
    // below the expected speed.
    let place = Place::new();
    let random = "inputs = [\"rotating_speed\", \"damping.tangential\"]\nrelative_std = { rotating_speed = 0.12, \"damping.tangential\" = 0.02 }";
    let text = |name: &str, sampling: &str| {
        job(name, EIGENVALUE, random, sampling)
            .replace("[axes]", "[model.friction]\nstribeck_exponent = 2.0\n\n[axes]")
            .replace("rotating_speed = 15.0", "rotating_speed = [20.0, 25.0]")
            .replace("{ from = 0.05, to = 0.30, points = 6 }", "0.1")
            .replace("{ from = 0.28, to = 0.50, points = 5 }", "0.45")
    };
    let found = submitted(&place, "importance", &text("importance", IMPORTANCE));
    let counted = submitted(&place, "counted", &text("counted", "method = \"sobol\"\nsamples = 4_194_304"));
    for row in 0..2 {
        let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|name| found.column(name)[row]);
        let [other_low, other_high] = ["p_low", "p_high"].map(|name| counted.column(name)[row]);
        assert!(low < other_high && other_low < high, "{row}: {low} {p} {high}, {other_low} {other_high}");
        assert!(high - low < 0.2 * p, "{row}: {low} {p} {high}");
    }
}

#[test]
fn twenty_inputs_are_not_too_many() {
    // The ten inputs, and ten others that matter less.
    let place = Place::new();
    let more = [
        "pad.length",
        "pad.thickness",
        "stiffness.calliper_normal",
        "stiffness.calliper_tangential",
        "damping.angular",
        "disc.inner_radius",
    ];
    let text = job_of_ten("many", "method = \"importance\"\nsamples = 8192\nseed = 3");
    let known = place.run("parameters").done().stdout;
    let more: Vec<&str> = more.into_iter().filter(|key| known.contains(key)).collect();
    assert!(more.len() >= 3, "{more:?} of\n{known}");
    let added: String = more.iter().map(|key| format!(", \"{key}\"")).collect();
    let stds: String = more.iter().map(|key| format!(", \"{key}\" = 0.0001")).collect();
    let text = text.replacen("]\nrelative_std", &format!("{added}]\nrelative_std"), 1).replacen(
        " }\ndistribution",
        &format!("{stds} }}\ndistribution"),
        1,
    );
    let table = submitted(&place, "many", &text);
    let (covered, largest) = compared(&table, &expected_of_ten(&table));
    assert!(covered >= 0.75 && largest < 0.1, "{covered} covered, relative error {largest}");
}

#[test]
fn sums_of_weights_do_not_depend_on_how_the_work_is_shared() {
    let place = Place::new();
    for (name, sampling) in
        [("importance", "method = \"importance\"\nsamples = 1024"), ("subset", "method = \"subset\"\nparticles = 100")]
    {
        place.write("small.toml", &job_of_ten(name, sampling).replace("0.008, 0.012, 0.016, 0.02", "0.012, 0.02"));
        let run = |run: &str| format!("{name}-{run}");
        place.run(&format!("submit small.toml --out {} --threads 1", run("one"))).done();
        place.run(&format!("submit small.toml --out {} --threads 2", run("two"))).done();
        for shard in [3, 1, 2] {
            place.run(&format!("submit small.toml --out {} --shard {shard}/3", run("shards"))).done();
        }
        place.run(&format!("merge {}", run("shards"))).done();
        for other in ["two", "shards"] {
            assert!(place.surface(&run("one")) == place.surface(&run(other)), "{name}: {other}");
        }
    }
    // Begun with fewer samples, and extended.
    place.write(
        "begun.toml",
        &job_of_ten("importance", "method = \"importance\"\nsamples = 256")
            .replace("0.008, 0.012, 0.016, 0.02", "0.012, 0.02"),
    );
    place.run("submit begun.toml --out extended").done();
    place.run("submit begun.toml --out extended --samples 1024").done();
    assert!(place.surface("importance-one") == place.surface("extended"));
    let samples = "method = \"importance\"\nsamples = 32_768\nparticles = 100";
    place.write("job.toml", &job_of_ten("job", samples));
    place.run("submit job.toml --out whole").done();
    place.assert_survives_kills("whole", &[300, 500, 400], 2);
}

#[test]
fn columns_of_rare_events_are_pinned() {
    // Regression values: another version gives the same columns, or another results version.
    let place = Place::new();
    for (name, sampling, digest) in [
        ("importance", "method = \"importance\"\nsamples = 256\nseed = 7", "b646a0ed72ff85810bed24915fbef2bb"),
        ("subset", "method = \"subset\"\nparticles = 100\nseed = 7", "215d7b23f5c391dfcc9e66937bd66099"),
    ] {
        let table = submitted(&place, name, &job_of_ten(name, sampling));
        assert_eq!(table.digest(), digest, "{name}");
    }
}

#[test]
fn an_estimate_that_is_not_to_be_trusted_is_not_given() {
    let place = Place::new();
    // Nothing near these values is unstable.
    let calm = "inputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.001";
    let text = job("calm", EIGENVALUE, calm, IMPORTANCE)
        .replace("{ from = 0.05, to = 0.30, points = 6 }", "0.05")
        .replace("{ from = 0.28, to = 0.50, points = 5 }", "0.28");
    place.write("calm.toml", &text);
    let said = place.run("submit calm.toml").done().stdout;
    assert!(said.contains("p_unstable is null in 1 cell: no unstable sample was found"), "{said}");
    let table = Table::read(&place.path("runs/calm/surface.parquet"));
    assert!(table.column("p_unstable")[0].is_nan());
    assert_eq!((table.column("distrust")[0], table.column("p_low")[0]), (1.0, 0.0));
    // An eighth of 4096 samples are those of the inputs.
    let high = table.column("p_high")[0];
    assert!(high > 0.004 && high < 0.01, "{high}");
    // Too few samples for ten inputs.
    place.write("few.toml", &job_of_ten("few", "method = \"importance\"\nsamples = 32\nparticles = 50"));
    let said = place.run("submit few.toml").done().stdout;
    assert!(said.contains("few samples have most of the probability; take more samples"), "{said}");
    for words in ["replay runs/few --cell 0 --sample 0", "samples runs/few --cell 0"] {
        place.run(words).refused(64, &["have weights", "method = \"monte-carlo\""]);
    }
}

/// Two masses that their damping feeds: nothing is stable, with twelve times the scatter neither.
#[test]
fn where_nothing_stable_is_found_there_is_no_number_either() {
    let place = Place::new();
    for (method, keys) in [("importance", "samples = 512"), ("subset", "particles = 60")] {
        let text = format!(
            "name = \"{method}\"\n[model]\nkind = \"matrices\"\nmass = {{ matrix = [[1, 0], [0, 1]] }}\n\
             damping = [{{ matrix = [[-0.1, 0], [0, -0.1]] }}]\nstiffness = [{{ matrix = [[2, 0], [0, 3]], factor = \"k\" }}]\n\
             [model.parameters]\nk = 1.0\n[random]\ninputs = [\"k\"]\nrelative_std = 0.001\n[criterion]\n\
             kind = \"complex-eigenvalue\"\n[sampling]\nmethod = \"{method}\"\n{keys}\n"
        );
        let table = submitted(&place, method, &text);
        let of = |name: &str| table.column(name)[0];
        assert!(of("p_unstable").is_nan(), "{method}: {}", of("p_unstable"));
        assert_eq!([of("distrust"), of("p_high"), of("n_audit_unstable")], [1.0, 1.0, 300.0], "{method}");
        let said = place.run(&format!("resume {method}")).done().stdout;
        assert!(said.contains("no probability, only") && !said.contains("no sample was decided"), "{said}");
    }
}

#[test]
fn weights_are_refused_where_they_do_not_apply() {
    let place = Place::new();
    let recorded = "kind = \"time-domain\"\ndisc = \"rigid\"\nrecord = [\"amplitude\"]";
    for (criterion, random, sampling, texts) in [
        (
            EIGENVALUE,
            BOTH,
            "method = \"subset\"\nsamples = 1000",
            &["job.toml:17:", "sampling.particles", "remove it"][..],
        ),
        (
            EIGENVALUE,
            BOTH,
            "method = \"sobol\"\nparticles = 300",
            &["job.toml:17:", "use method = \"importance\" or \"subset\""],
        ),
        (EIGENVALUE, BOTH, "method = \"importance\"\nparticles = 10", &["particles = 10", "at least 50"]),
        (EIGENVALUE, BOTH, "method = \"importance\"\nevaluate = \"boundary\"", &["evaluate has no meaning"]),
        (
            EIGENVALUE,
            BOTH,
            "method = \"importance\"\nderivatives = true",
            &["derivatives has no meaning", "with weights"],
        ),
        (EIGENVALUE, BOTH, "method = \"importance\"\nuntil = { relative = 0.1 }", &["until has no meaning"]),
        (EIGENVALUE, BOTH, "method = \"subset\"\nrandomisations = 1", &["randomisations = 1", "at least 2"]),
        (recorded, BOTH, "method = \"subset\"", &["records nothing of its samples", "criterion.record"]),
    ] {
        place.write("job.toml", &job("job", criterion, random, sampling));
        place.run("check job.toml").refused(65, texts);
    }
}

/// A brake whose measured friction falls, rises a little and drops: a second instability, four standard deviations of the
/// speed away.
const SECOND_INSTABILITY: &str = r#"
[model]
preset = "sui-ding-2018"

[model.friction]
law = "table"
table = { speed = [0, 0.3, 0.8, 1.4, 2.0, 2.4, 2.8, 3.0, 3.2, 3.6, 5.0], coefficient = [0.45, 0.36, 0.30, 0.272, 0.264, 0.262, 0.270, 0.272, 0.245, 0.235, 0.230] }

[model.damping]
tangential = 369.0

[axes]
rotating_speed = 16.0
preload = 0.016

[random]
inputs = ["preload", "static_friction", "rotating_speed", "damping.tangential"]
relative_std = { preload = 0.1, static_friction = 0.08, rotating_speed = 0.095, "damping.tangential" = 0.1 }

[criterion]
kind = "eigenvalue"

[sampling]
seed = 1
"#;

#[test]
fn a_second_instability_behind_a_valley_is_found() {
    let place = Place::new();
    let text = |name: &str, preload: &str, sampling: &str| {
        format!("name = \"{name}\"\n{SECOND_INSTABILITY}{sampling}\n").replace("0.016", preload)
    };
    // 50 million independent samples: 1.38e-5, 95 % between 1.28e-5 and 1.49e-5.
    for (name, sampling) in
        [("importance", "method = \"importance\"\nsamples = 4096"), ("subset", "method = \"subset\"\nparticles = 300")]
    {
        let table = submitted(&place, name, &text(name, "0.016", sampling));
        let p = table.column("p_unstable")[0];
        assert!(p > 1.28e-5 && p < 1.49e-5, "{name}: {p:e}");
        assert_eq!(table.column("distrust")[0], 0.0);
    }
    // 2.56e-5 at a preload of 0.03.
    let table = submitted(&place, "more", &text("more", "0.03", "method = \"importance\"\nsamples = 2048"));
    assert!((table.column("p_unstable")[0] / 2.56e-5 - 1.0).abs() < 0.06, "{:?}", table.column("p_unstable"));
    // It passes 1e-5 at a preload of 0.0105.
    let sampling = "method = \"importance\"\nsamples = 1024\nparticles = 100";
    place.write("limit.toml", &text("limit", "{ from = 0.008, to = 0.016, points = 3 }", sampling));
    let said = place.run("limit limit.toml --of preload --probability 1e-5 --json").done().stdout;
    let found: serde_json::Value = serde_json::from_str(&said).unwrap();
    let limit = found["limits"][0]["limit"].as_f64().unwrap_or_else(|| panic!("{said}"));
    assert!((limit / 0.0105 - 1.0).abs() < 0.03, "{said}");
}

#[test]
fn populations_give_a_number_where_far_particles_have_no_verdict() {
    // Twenty standard deviations out normal stiffness is negative.
    let place = Place::new();
    let inputs = "inputs = [\"preload\", \"static_friction\", \"stiffness.contact_tangential_1\", \"damping.tangential\"]\n\
                  relative_std = 0.1";
    let text = |name: &str, sampling: &str| {
        job(name, EIGENVALUE, inputs, sampling)
            .replace("{ from = 0.05, to = 0.30, points = 6 }", "0.05")
            .replace("{ from = 0.28, to = 0.50, points = 5 }", "0.3")
    };
    let importance = submitted(&place, "weights", &text("weights", IMPORTANCE));
    let subset =
        submitted(&place, "populations", &text("populations", "method = \"subset\"\nparticles = 500\nseed = 1"));
    let [p, q] = [&importance, &subset].map(|table| table.column("p_unstable")[0]);
    assert!(p > 1e-8 && p < 1e-3, "{p:e}");
    assert!((q / p - 1.0).abs() < 0.25, "{q:e}, {p:e}");
}
