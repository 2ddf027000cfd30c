//! Random inputs through the command line: distributions, measured values, and their columns.

#![allow(clippy::disallowed_methods, reason = "expected values are computed as a textbook writes them")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::f64::consts::PI;
use std::fs::{self, File};

use crate::common::{Place, Table};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

/// A job of one cell, with the given keys of `[random]` and `[sampling]`.
fn job(random: &str, sampling: &str) -> String {
    format!(
        "name = \"job\"\n\n[axes]\nrotating_speed = 15.0\npreload = 0.1\nstatic_friction = 0.385\n\n\
         [random]\n{random}\n\n[criterion]\nkind = \"eigenvalue\"\n\n[sampling]\n{sampling}\n"
    )
}

fn submitted(place: &Place, name: &str, text: &str) -> Table {
    place.write(&format!("{name}.toml"), text);
    place.run(&format!("submit {name}.toml --out {name}")).done();
    Table::read(&place.path(&format!("{name}/surface.parquet")))
}

/// The critical damping over its expected value. The critical product is proportional to the damping, so a sample is
/// unstable if its damping is below.
fn critical_damping() -> f64 {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", 15.0).unwrap();
    0.1 * (0.385 - 0.25) / PadOnDisc::new(parameters).unwrap().stability_boundary().critical_product
}

#[test]
fn every_distribution_gives_the_probability_in_closed_form() {
    let place = Place::new();
    place.write("measured.csv", "stop,damping\n1,0.3\n2,0.7\n3,0.2\n4,0.4\n");
    let ratio = critical_damping();
    let gumbel = |std: f64| (-(-((ratio - 1.0) * PI / (std * 6f64.sqrt()) + 0.577_215_664_901_532_9)).exp()).exp();
    let triangular = |mode: f64, std: f64| {
        let width = std * (18.0 / (1.0 - mode + mode * mode)).sqrt();
        let t = (ratio - 1.0) / width + (1.0 + mode) / 3.0;
        if t < mode { t * t / mode } else { 1.0 - (1.0 - t) * (1.0 - t) / (1.0 - mode) }
    };
    // Shapes 2 and 4.
    let t = (ratio - 0.5) / 1.5;
    let beta = 1.0 - (1.0 - t).powi(5) - 5.0 * t * (1.0 - t).powi(4);
    // Over their mean 0.4, at the probabilities 1/8, 3/8, 5/8 and 7/8.
    let corners = [(0.5, 0.125), (0.75, 0.375), (1.0, 0.625), (1.75, 0.875)];
    let piece = corners.windows(2).find(|pair| pair[1].0 >= ratio).unwrap();
    let measured = piece[0].1 + 0.25 * (ratio - piece[0].0) / (piece[1].0 - piece[0].0);
    let file = "{ csv = \"measured.csv\", column = \"damping\" }";
    for (name, distribution, std, expected) in [
        ("exponential", "\"weibull\"", Some(1.0), 1.0 - (-ratio).exp()),
        ("weibull", "\"weibull\"", Some(5f64.sqrt()), 1.0 - (-(2.0 * ratio).sqrt()).exp()),
        ("gumbel", "\"gumbel\"", Some(0.2), gumbel(0.2)),
        ("symmetric", "\"triangular\"", Some(0.2), triangular(0.5, 0.2)),
        ("skew", "{ triangular = 0.125 }", Some(0.2), triangular(0.125, 0.2)),
        ("beta", "{ beta = [0.5, 2.0] }", Some((0.5_f64 / 7.0).sqrt()), beta),
        ("measured", file, None, measured),
        ("values", "{ values = [0.3, 0.7, 0.2, 0.4] }", None, measured),
    ] {
        assert!((0.02..0.98).contains(&expected), "{name}: {expected}");
        let std = std.map_or(String::new(), |std| format!("relative_std = {std}\n"));
        let random = format!(
            "inputs = [\"damping.tangential\"]\n{std}distribution = {{ \"damping.tangential\" = {distribution} }}"
        );
        for (kind, sampling, tolerance) in
            [("mc", "samples = 40_000", 0.011), ("sobol", "method = \"sobol\"\nsamples = 16_384", 0.001)]
        {
            let table = submitted(&place, &format!("{name}-{kind}"), &job(&random, sampling));
            let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|column| table.column(column)[0]);
            assert!((p - expected).abs() < tolerance, "{name}: {p} {expected}");
            assert!(low <= p && p <= high);
        }
        // With all defaults filled in, it is the same job.
        let full = place.run(&format!("check --all {name}-mc.toml")).done().stdout;
        place.write("full.toml", &full);
        let again = place.run(&format!("submit full.toml --out {name}-mc")).done();
        assert!(again.stderr.contains("finished already"), "{name}: {}", again.stderr);
    }
}

#[test]
fn the_processor_does_not_change_a_byte() {
    let here = Place::new();
    let there = Place::new().with_environment("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-AVX2");
    let random = "inputs = [\"preload\", \"static_friction\", \"damping.tangential\", \"pad.mass\", \"stiffness.contact_normal\"]\n\
        relative_std = { preload = 0.3, static_friction = 0.1, \"damping.tangential\" = 0.2, \"pad.mass\" = 0.2 }\n\
        distribution = { preload = \"weibull\", static_friction = \"gumbel\", \"damping.tangential\" = { beta = [0.5, 2.0] }, \
        \"pad.mass\" = { triangular = 0.25 }, \"stiffness.contact_normal\" = { values = [0.8, 1.0, 1.1] } }";
    for place in [&here, &there] {
        submitted(place, "run", &job(random, "samples = 5000"));
    }
    assert!(here.surface("run") == there.surface("run"));
}

#[test]
fn verdict_maps_reach_as_far_as_the_inputs() {
    let place = Place::new();
    let spread = "preload = [0.1, 0.2]\nstatic_friction = [0.3, 0.385]";
    for (i, distribution) in [
        "{ preload = \"weibull\", static_friction = { beta = [0.6, 1.8] } }",
        "{ preload = { triangular = 0.25 }, static_friction = \"gumbel\" }",
        "{ preload = { values = [0.5, 0.8, 0.9, 1.4] }, static_friction = \"triangular\" }",
    ]
    .iter()
    .enumerate()
    {
        let std = if i == 2 { "{ static_friction = 0.2 }" } else { "0.2" };
        let random = format!(
            "inputs = [\"preload\", \"static_friction\"]\nrelative_std = {std}\ndistribution = {distribution}\n\
             correlation = [[\"preload\", \"static_friction\", 0.5]]"
        );
        let text = |sampling: &str| {
            job(&random, sampling)
                .replace("preload = 0.1\nstatic_friction = 0.385", spread)
                .replace("kind = \"eigenvalue\"", "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"")
        };
        let each = submitted(&place, &format!("each-{i}"), &text("samples = 8000"));
        let looked_up =
            submitted(&place, &format!("map-{i}"), &text("samples = 8000\nevaluate = \"boundary\"\naudit = 0"));
        for column in each.names() {
            assert_eq!(each.column(column), looked_up.column(column), "{distribution}: {column}");
        }
        assert!(looked_up.column("n_simulated").iter().sum::<f64>() < 500.0);
    }
}

const MEASURED: &str = "inputs = [\"preload\", \"static_friction\"]\nrelative_std = { preload = 0.1 }\n\
    distribution = { static_friction = { csv = \"data/mu.csv\", column = \"mu\" } }";

#[test]
fn a_run_keeps_the_measured_values() {
    let place = Place::new();
    fs::create_dir(place.path("data")).unwrap();
    place.write("data/mu.csv", "stop, mu\n1, 0.36\n2, 0.41\n3, 0.33\n4, 0.44\n");
    let text = job(MEASURED, "samples = 30_000\nseed = 4").replace("preload = 0.1\n", "preload = [0.1, 0.12]\n");
    let table = submitted(&place, "whole", &text);
    let mean = 0.25 * (0.36 + 0.41 + 0.33 + 0.44);
    let squares = [0.36, 0.41, 0.33, 0.44].map(|x: f64| (x - mean).powi(2)).iter().sum::<f64>();
    let steps = 0.03_f64.powi(2) + 0.05_f64.powi(2) + 0.03_f64.powi(2);
    let std = ((squares - steps / 6.0) / 4.0).sqrt() / mean;
    for row in 0..2 {
        assert!((table.column("std_static_friction")[row] - std).abs() < 1e-12, "{std}");
        assert_eq!(table.column("std_preload")[row], 0.1);
    }
    // Compute some of the samples, and then remove the file.
    place.run("submit whole.toml --out part --shard 1/2").done();
    let other = "stop, mu\n1, 0.36\n2, 0.41\n3, 0.34\n4, 0.44\n";
    fs::remove_file(place.path("data/mu.csv")).unwrap();
    place.run("resume part").done();
    assert!(place.surface("whole") == place.surface("part"));
    let frozen = fs::read_to_string(place.path("part/job.toml")).unwrap();
    assert!(frozen.starts_with("# random.distribution of static_friction: measured values from \"data/mu.csv\""));
    assert!(frozen.contains("values = [0.33, 0.36, 0.41, 0.44]"), "{frozen}");
    let copy = place.run("submit part/job.toml --out whole").done();
    assert!(copy.stderr.contains("finished already"), "{}", copy.stderr);
    // The same values in another order make the same job, other values another.
    place.write("data/mu.csv", "mu\n0.33\n0.41\n0.44\n0.36\n");
    place.run("submit whole.toml --out whole").done();
    place.write("data/mu.csv", other);
    place.run("submit whole.toml --out whole").refused(65, &["run of another job", "0.33", "0.34"]);
    // One file for all inputs, and a distribution in a table of its own.
    let common =
        "inputs = [\"preload\", \"static_friction\"]\ndistribution = { csv = \"data/mu.csv\", column = \"mu\" }";
    submitted(&place, "common", &job(common, "samples = 10"));
    let table = "inputs = [\"preload\"]\n\n[random.distribution.preload]\ncsv = \"data/mu.csv\"\ncolumn = \"mu\"";
    submitted(&place, "table", &job(table, "samples = 10"));
    fs::remove_file(place.path("data/mu.csv")).unwrap();
    for run in ["common", "table"] {
        place.run(&format!("resume {run}")).done();
    }
}

#[test]
fn an_invalid_file_is_refused_with_file_and_line() {
    let place = Place::new();
    fs::create_dir(place.path("data")).unwrap();
    place.write("job.toml", &job(MEASURED, "samples = 10"));
    place.run("check job.toml").refused(65, &["job.toml:11:16", "cannot read data/mu.csv"]);
    for (content, texts) in [
        ("", &["data/mu.csv:1", "no column \"mu\""][..]),
        ("stop,muu\n1,2\n", &["data/mu.csv:1", "no column \"mu\"; did you mean \"muu\"?", "\"stop\", \"muu\""]),
        ("mu,mu\n1,2\n", &["data/mu.csv:1", "two columns"]),
        ("mu\n0.3\n\n0.4\nnan\n", &["data/mu.csv:5", "\"nan\"", "not a finite number"]),
        ("stop,mu\n1,0.3\n2,\n", &["data/mu.csv:3", "\"\" in column \"mu\""]),
        ("stop,mu\n1,\"0,3\"\n", &["data/mu.csv:2", "\"0,3\"", "such as 0.41"]),
        ("stop,mu\n1,0.3\n2\n", &["data/mu.csv:3", "1 fields", "2"]),
        ("mu\n0.3\n", &["data/mu.csv", "too few values (1)", "at least 2"]),
        ("mu\n0.3\n0.3\n", &["all values are 0.3"]),
        ("mu\n-0.5\n0.25\n", &["mean of the values is -0.125", "positive"]),
    ] {
        place.write("data/mu.csv", content);
        place.run("check job.toml").refused(65, texts);
    }
    fs::write(place.path("data/mu.csv"), b"mu\n0.3\n\xff\n").unwrap();
    place.run("check job.toml").refused(65, &["data/mu.csv:3", "UTF-8"]);
}

#[test]
fn what_a_distribution_does_not_allow_is_refused() {
    let place = Place::new();
    let one = "inputs = [\"preload\"]\nrelative_std = ";
    let measured = "{ values = [1.0, 2.0] }";
    for (random, texts) in [
        (format!("{one}1.1"), &["job.toml:10:16", "normal", "largest possible is 1", "lognormal"][..]),
        (format!("{one}20"), &["relative_std = 20", "at most 10", "per cent"]),
        (format!("{one}0.5\ndistribution = \"triangular\""), &["job.toml:11", "0.40825"]),
        (format!("{one}0.1\ndistribution = {{ triangular = 2.0 }}"), &["peak", "at most 1"]),
        (format!("{one}0.1\ndistribution = {{ beta = [1.5, 2.0] }}"), &["1.5", "less than 1"]),
        (format!("{one}0.8\ndistribution = {{ beta = [0.5, 2.0] }}"), &["0.8", "at most 0.69673"]),
        (format!("{one}2.0\ndistribution = {{ truncated-normal = [-1.0, 2.0] }}"), &["-0.5000", "(it is -1)"]),
        (format!("{one}0.1\ndistribution = \"weibul\""), &["no distribution \"weibul\"; did you mean \"weibull\"?"]),
        (format!("{one}0.1\ndistribution = {{ beta = 2.0 }}"), &["{ beta = 2.0 } is no distribution", "[LOW, HIGH]"]),
        (format!("{one}0.1\ndistribution = {{ preload = {{ beat = [0.5, 2.0] }} }}"), &["did you mean \"beta\"?"]),
        (format!("{one}0.1\ndistribution = {{ csv = \"x.csv\" }}"), &["which column of x.csv"]),
        (
            format!("{one}0.1\ndistribution = {measured}"),
            &["preload has measured values", "remove random.relative_std"],
        ),
        (
            format!("{one}{{ preload = 0.1 }}\ndistribution = {measured}"),
            &["job.toml:10", "0.1 for preload", "remove preload"],
        ),
        (
            format!(
                "inputs = [\"preload\", \"pad.mass\"]\nrelative_std = 0.1\ndistribution = {{ preload = {measured} }}"
            ),
            &["write relative_std = { \"pad.mass\" = 0.1 }"],
        ),
    ] {
        place.write("job.toml", &job(&random, "samples = 10"));
        place.run("check job.toml").refused(65, texts);
    }
    for distribution in ["lognormal", "weibull", "gumbel"] {
        submitted(&place, distribution, &job(&format!("{one}1.5\ndistribution = \"{distribution}\""), "samples = 10"));
    }
}

#[test]
fn an_input_that_does_not_scatter_causes_a_warning() {
    let place = Place::new();
    let random = "inputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.1";
    let text = job(random, "samples = 10").replace("preload = 0.1", "preload = [0.0, 0.1]");
    place.write("job.toml", &text);
    for command in ["check job.toml", "submit job.toml"] {
        let said = place.run(command).done().stderr;
        assert!(said.contains("warning: preload does not scatter") && said.contains("axes.preload = 0"), "{said}");
        assert!(!said.contains("static_friction"), "{said}");
    }
    place.write("job.toml", &text.replace("= 0.1\n\n[crit", "= { preload = 0.0, static_friction = 0.1 }\n\n[crit"));
    assert_eq!(place.run("check job.toml").done().stderr, "");
}

#[test]
fn columns_distinguish_parameters_from_means() {
    let place = Place::new();
    let random = "inputs = [\"preload\", \"pad.mass\", \"rotating_speed\"]\n\
        relative_std = [{ preload = 1.0, \"pad.mass\" = 0.1, rotating_speed = 0.05 }, 0.2]\n\
        distribution = { preload = { truncated-normal = [-1.0, 4.0] }, \"pad.mass\" = \"lognormal\" }";
    let table = submitted(&place, "columns", &job(random, "samples = 10"));
    assert_eq!(
        table.names()[14..],
        ["mean_preload", "scatter_preload", "pad.mass", "std_pad.mass", "std_rotating_speed", "n_outside_physics"]
    );
    assert_eq!(table.column("std_pad.mass"), [0.1, 0.2]);
    assert_eq!(table.column("std_rotating_speed"), [0.05, 0.2]);
    assert_eq!(table.column("pad.mass"), [0.1, 0.1]);
    // scipy.stats.truncnorm(-1, 4).mean() and .std(), SciPy 1.17.1.
    let (mean, std) = (0.28745172460702695, 0.793173635611463);
    for (row, scatter) in [1.0, 0.2].into_iter().enumerate() {
        let true_mean = 0.1 * (1.0 + scatter * mean);
        assert!((table.column("mean_preload")[row] - true_mean).abs() < 1e-12);
        assert!((table.column("scatter_preload")[row] - 0.1 * scatter * std / true_mean).abs() < 1e-12);
    }
    let file = File::open(place.path("columns/surface.parquet")).unwrap();
    let schema = ParquetRecordBatchReaderBuilder::try_new(file).unwrap().schema().clone();
    let meaning = |name: &str| schema.field_with_name(name).unwrap().metadata()["long_name"].clone();
    assert!(meaning("preload").contains("before it is truncated") && meaning("preload").contains("mean_preload"));
    assert!(meaning("std_preload").contains("scatter_preload"));
    assert!(!meaning("static_friction").contains("truncated") && !meaning("std_pad.mass").contains("truncated"));
    assert_eq!(schema.field_with_name("pad.mass").unwrap().metadata()["unit"], "kg");
}

#[test]
fn samples_outside_physics_are_counted_and_treated_as_the_job_specifies() {
    let place = Place::new();
    let text = |name: &str, criterion: &str, sampling: &str| {
        format!(
            "name = \"{name}\"\n[model.friction]\nkinetic_coefficient = 0.35\n[axes]\nrotating_speed = 6.0\npreload = 0.2\n\
             static_friction = 0.45\n[random]\ninputs = [\"static_friction\"]\nrelative_std = 0.2\n\
             [criterion]\n{criterion}\n[sampling]\n{sampling}\n"
        )
    };
    // P(f_s < f_c) = Phi((0.35 / 0.45 - 1) / 0.2) = Phi(-10 / 9), from a table of the normal distribution.
    let expected = 0.133_26;
    let samples = 200_000.0;
    let numbers = |table: &Table| {
        ["n_outside_physics", "n_stable", "n_unstable", "n_failed", "p_unstable"].map(|name| table.column(name)[0])
    };
    let [stable, failed, clamp] = ["stable", "failed", "clamp"].map(|policy| {
        let criterion = format!("kind = \"eigenvalue\"\noutside_physics = \"{policy}\"");
        numbers(&submitted(&place, policy, &text(policy, &criterion, "samples = 200_000")))
    });
    for [outside, ..] in [stable, failed, clamp] {
        assert!((outside / samples - expected).abs() < 4.0 * (expected * (1.0 - expected) / samples).sqrt());
    }
    assert!(stable[1] >= stable[0] && stable[4] < 1.0 - expected + 0.004, "{stable:?}");
    assert_eq!(clamp, stable, "friction that does not fall is stable on a rigid disc");
    assert_eq!(failed, [failed[0], stable[1] - stable[0], stable[2], stable[0], failed[4]]);
    assert!((failed[4] - stable[2] / (samples - stable[0])).abs() < 1e-12);
    let outcome = place.run("submit stable.toml").done();
    assert!(
        outcome.stdout.contains("lie outside the model: preload at or below 0, or f_s < f_c; "),
        "{}",
        outcome.stdout
    );

    // The same samples are outside physics with every criterion, with a map, and with derivatives.
    for (name, criterion, sampling) in [
        ("motion", "kind = \"time-domain\"\ndisc = \"rigid\"\noutside_physics = \"failed\"", "samples = 3000"),
        (
            "map",
            "kind = \"time-domain\"\ndisc = \"rigid\"\noutside_physics = \"failed\"",
            "samples = 3000\nevaluate = \"boundary\"",
        ),
        ("modes", "kind = \"coupled-eigenvalue\"\noutside_physics = \"failed\"", "samples = 3000"),
        ("slopes", "kind = \"eigenvalue\"\noutside_physics = \"failed\"", "samples = 3000\nderivatives = true"),
    ] {
        let [outside, _, _, failed, _] = numbers(&submitted(&place, name, &text(name, criterion, sampling)));
        assert!(outside > 300.0 && outside == failed, "{name}: {outside} outside, {failed} failed");
    }
    let replayed = (0..100).map(|sample| {
        let replay = place.run(&format!("replay motion --cell 0 --sample {sample} --horizon 5 --json")).done();
        serde_json::from_str::<serde_json::Value>(&replay.stdout).unwrap()
    });
    for sample in replayed {
        let is_outside = sample["static_friction"].as_f64().unwrap() < 0.35;
        assert_eq!(sample["verdict_in_run"] == "failed", is_outside, "{sample}");
    }
    place.write(
        "exact.toml",
        &text("exact", "kind = \"eigenvalue\"\noutside_physics = \"clamp\"", "method = \"exact\""),
    );
    place.run("check exact.toml").refused(65, &["outside_physics", "method = \"exact\"", "monte-carlo"]);
}

/// A job over preload and friction, whose scatter is given by `random` and whose preloads are `preloads`.
fn scattered(preloads: &str, random: &str, sampling: &str) -> String {
    format!(
        "name = \"scattered\"\n[axes]\nrotating_speed = 15.0\npreload = {preloads}\nstatic_friction = 0.39\n[random]\n\
         inputs = [\"preload\", \"static_friction\"]\n{random}\n[criterion]\nkind = \"eigenvalue\"\n[sampling]\n{sampling}\n"
    )
}

#[test]
fn a_standard_deviation_in_units_gives_in_each_cell_what_its_relative_one_gives() {
    let place = Place::new();
    let preloads = [0.05, 0.1, 0.16];
    let exact = "method = \"exact\"";
    for (name, distribution) in [("normal", ""), ("lognormal", "\ndistribution = \"lognormal\"")] {
        let absolute = format!("relative_std = {{ static_friction = 0.08 }}\nstd = {{ preload = 0.02 }}{distribution}");
        for (method, sampling, tolerance) in [("exact", exact, 1e-12), ("drawn", "samples = 2000\nseed = 3", 0.0)] {
            let run = format!("{name}-{method}");
            let table = submitted(&place, &run, &scattered("[0.05, 0.1, 0.16]", &absolute, sampling));
            assert_eq!(table.column("std_preload"), [0.02; 3]);
            assert_eq!(table.column("std_static_friction"), [0.08; 3]);
            for (cell, preload) in preloads.into_iter().enumerate() {
                let std = 0.02 / preload;
                let relative = format!("relative_std = {{ static_friction = 0.08, preload = {std} }}{distribution}");
                let alone =
                    submitted(&place, &format!("{run}-{cell}"), &scattered(&preload.to_string(), &relative, sampling));
                let [found, expected] = [table.column("p_unstable")[cell], alone.column("p_unstable")[0]];
                // Samples of the first cell alone are those of the other job.
                if method == "exact" || cell == 0 {
                    assert!((found - expected).abs() <= tolerance, "{run} {preload}: {found} {expected}");
                }
                assert!(method == "drawn" || (0.001..0.999).contains(&found), "{run} {preload}: {found}");
            }
        }
    }
    // At a limit the probability is the target, whichever way it is found.
    place.write(
        "job.toml",
        &scattered("{ from = 0.05, to = 0.16, points = 3 }", "std = { preload = 0.02, static_friction = 0.03 }", exact),
    );
    let found = place.run("limit job.toml --of preload --probability 0.3 --json").done().stdout;
    let found: serde_json::Value = serde_json::from_str(&found).unwrap();
    let limit = found["limits"][0]["limit"].as_f64().unwrap();
    let there = scattered(&limit.to_string(), "std = { preload = 0.02, static_friction = 0.03 }", exact);
    let p = submitted(&place, "there", &there).column("p_unstable")[0];
    assert!((p - 0.3).abs() < 1e-9, "{limit}: {p}");
    for (random, texts) in [
        (
            "std = { preload = 0.2, static_friction = 0.03 }",
            &[
                "random.std of preload: 0.2 is 4.0000 times the expected value, 0.05",
                "relative standard deviation of 4",
            ][..],
        ),
        ("std = { preload = -0.1 }\nrelative_std = 0.1", &["random.std of preload = -0.1 is out of range"]),
        (
            "std = { preload = 0.1, static_friction = 0.1 }\ndistribution = { preload = { values = [0.1, 0.2] } }",
            &["random.std gives 0.1 for preload, but preload has measured values"],
        ),
    ] {
        place.write("job.toml", &scattered("0.05", random, exact));
        place.run("check job.toml").refused(65, texts);
    }
    // No number is so many times an expected value of 0.
    place.write("job.toml", &scattered("[0.05, 0]", "std = { preload = 0.01, static_friction = 0.03 }", exact));
    let refused = place.run("check job.toml").refused(65, &[
        "random.std of preload: a normal input that scatters by 0.01 has an expected value above 0, and here it is 0; give it one above 0, or leave it out of random.inputs",
    ]);
    assert!(!refused.stderr.contains("inf"), "{}", refused.stderr);
}

#[test]
fn a_parameter_of_matrices_scatters_by_its_own_unit() {
    let place = Place::new();
    // Unstable where 4/3 of the friction is more than the coupling: beyond 0.75.
    let job = "name = \"masses\"\n[model]\nkind = \"matrices\"\nmass = { matrix = [[1, 0], [0, 1]] }\n\
        stiffness = [{ matrix = [[2, 1], [1, 2]] }, { matrix = [[0, -1.3333333333333333], [0, 0]], factor = \"friction\" }]\n\
        parameters = { friction = 0.7 }\n[random]\ninputs = [\"friction\"]\nstd = { friction = 0.3 }\n\
        [criterion]\nkind = \"complex-eigenvalue\"\n[sampling]\nmethod = \"exact\"\n";
    let table = submitted(&place, "masses", job);
    // The normal distribution function at -1/6.
    assert!((table.column("p_unstable")[0] - 0.433_816_167_389).abs() < 1e-6, "{:?}", table.column("p_unstable"));
    assert_eq!(table.column("std_friction"), [0.3]);
    // Around 0, too, unless the distribution has positive values only.
    let around = job.replace("friction = 0.7", "friction = 0");
    place.write("around.toml", &around);
    place.run("check around.toml").done();
    let positive = around.replace("std = {", "distribution = { friction = \"lognormal\" }\nstd = {");
    place.write("positive.toml", &positive);
    place.run("check positive.toml").refused(65, &[
        "of friction: a lognormal input that scatters by 0.3 has an expected value above 0, and here it is 0; give it one above 0, or a distribution that may have any, such as normal, or leave it out",
    ]);
}
