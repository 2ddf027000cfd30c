//! `stickslip bounds`: the lower and upper probability over imprecise inputs.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use crate::common::{EIGENVALUE, Place, Table, submitted};
use serde_json::Value;
use stickslip_sampler::special_functions::normal;

const EXACT: &str = "method = \"exact\"";
const INPUTS: &str = "inputs = [\"preload\", \"static_friction\"]";

/// A job with these lines of `[axes]`, `[random]` and `[sampling]`.
fn job(axes: &str, random: &str, sampling: &str) -> String {
    format!(
        "name = \"bounds\"\n\n[axes]\n{axes}\n\n[random]\n{INPUTS}\n{random}\n\n[criterion]\n{EIGENVALUE}\n\n[sampling]\n{sampling}\n"
    )
}

/// The cells of `bounds --json` on a job.
#[track_caller]
fn bounds(place: &Place, text: &str) -> Vec<Value> {
    place.write("bounds.toml", text);
    let outcome = place.run("bounds bounds.toml --json").done();
    let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
    found["cells"].as_array().unwrap().clone()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"))
}

/// The probabilities of a precise job.
fn surface(place: &Place, run: &str, text: &str) -> Table {
    submitted(place, run, text)
}

/// Evenly spaced numbers as a list of TOML.
fn list(from: f64, to: f64, points: usize) -> String {
    let value = |i: usize| from + (to - from) * i as f64 / (points - 1) as f64;
    format!("{:?}", (0..points).map(value).collect::<Vec<f64>>())
}

#[test]
fn bounds_are_those_of_a_double_loop_over_submitted_cells() {
    let place = Place::new();
    let rows = bounds(
        &place,
        &job(
            "rotating_speed = 15.0\npreload = [0.05, 0.1, 0.2]\nstatic_friction = { between = [0.37, 0.39] }",
            "relative_std = { preload = { between = [0.10, 0.30] }, static_friction = 0.10 }",
            EXACT,
        ),
    );
    let points = 101;
    let stds: Vec<String> = (0..points)
        .map(|i| format!("{{ preload = {}, static_friction = 0.10 }}", 0.1 + 0.2 * i as f64 / (points - 1) as f64))
        .collect();
    let axes =
        format!("rotating_speed = 15.0\npreload = [0.05, 0.1, 0.2]\nstatic_friction = {}", list(0.37, 0.39, points));
    let table = surface(&place, "loop", &job(&axes, &format!("relative_std = [{}]", stds.join(", ")), EXACT));
    assert_eq!((rows.len(), table.column("preload").len()), (3, 3 * points * points));
    for row in &rows {
        let preload = number(row, "preload");
        let all = table.column("preload").iter().zip(table.column("p_unstable"));
        let all: Vec<f64> = all.filter(|(other, _)| **other == preload).map(|(_, p)| *p).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        assert!((number(row, "p_lower") - least).abs() < 1e-6, "{row} {least}");
        assert!((number(row, "p_upper") - most).abs() < 1e-6, "{row} {most}");
        // Proved, also against every cell of the loop.
        assert!(number(row, "p_lower_bound") <= least + 1e-13 && number(row, "p_upper_bound") >= most - 1e-13, "{row}");
        assert_eq!(
            (row["p_lower_evidence"].as_str(), row["p_upper_evidence"].as_str()),
            (Some("proved"), Some("proved"))
        );
        assert_eq!((number(row, "static_friction_at_lower"), number(row, "static_friction_at_upper")), (0.37, 0.39));
        assert_eq!(row["static_friction_trend"], "rises (proved)");
        assert!(100.0 * number(row, "evaluations") <= all.len() as f64, "{row}");
    }
    let inside = number(&rows[1], "std_preload_at_lower");
    assert!(inside > 0.11 && inside < 0.29, "an extreme between the ends: {inside}");
}

#[test]
fn bounds_are_reached_where_they_say() {
    let place = Place::new();
    let axes = "preload = { between = [0.09, 0.11] }\nstatic_friction = { one_of = [0.37, 0.4] }";
    let random = "relative_std = { between = [0.1, 0.2] }\ndistribution = { preload = { one_of = [\"normal\", \"lognormal\"] } }\ncorrelation = [[\"preload\", \"static_friction\", { between = [-0.5, 0.0] }]]";
    let rows = bounds(&place, &job(axes, random, EXACT));
    let [row] = &rows[..] else { panic!("{rows:?}") };
    for end in ["lower", "upper"] {
        let at = |name: &str| row[format!("{name}_at_{end}")].to_string();
        let axes = format!("preload = {}\nstatic_friction = {}", at("preload"), at("static_friction"));
        let random = format!(
            "relative_std = {{ preload = {}, static_friction = {} }}\ndistribution = {{ preload = {} }}\ncorrelation = [[\"preload\", \"static_friction\", {}]]",
            at("std_preload"),
            at("std_static_friction"),
            at("distribution_preload"),
            at("correlation")
        );
        let p = surface(&place, end, &job(&axes, &random, EXACT)).column("p_unstable")[0];
        assert!((p - number(row, &format!("p_{end}"))).abs() < 1e-12, "{end}: {p} {row}");
    }
    // Further combinations, each between the bounds.
    for (i, (preload, friction, std, distribution, correlation)) in [
        (0.1, 0.37, 0.15, "normal", -0.2),
        (0.09, 0.37, 0.2, "lognormal", 0.0),
        (0.11, 0.4, 0.1, "lognormal", -0.5),
        (0.11, 0.4, 0.1, "normal", -0.5),
        (0.11, 0.4, 0.1, "normal", 0.0),
    ]
    .into_iter()
    .enumerate()
    {
        let axes = format!("preload = {preload}\nstatic_friction = {friction}");
        let random = format!(
            "relative_std = {std}\ndistribution = {{ preload = \"{distribution}\" }}\ncorrelation = [[\"preload\", \"static_friction\", {correlation}]]"
        );
        let p = surface(&place, &format!("between-{i}"), &job(&axes, &random, EXACT)).column("p_unstable")[0];
        assert!(number(row, "p_lower") <= p + 1e-6 && p <= number(row, "p_upper") + 1e-6, "{p} {row}");
    }
}

#[test]
fn alternatives_alone_are_all_computed() {
    let place = Place::new();
    let axes = "preload = 0.1\nstatic_friction = 0.37";
    let random = "relative_std = { one_of = [0.1, 0.2, 0.3] }\ndistribution = { one_of = [\"normal\", \"uniform\"] }";
    let rows = bounds(&place, &job(axes, random, EXACT));
    // Every input has a value of its own.
    assert_eq!(number(&rows[0], "evaluations"), 36.0);
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let stds: Vec<String> = [0.1, 0.2, 0.3]
        .iter()
        .flat_map(|a| [0.1, 0.2, 0.3].map(|b| format!("{{ preload = {a}, static_friction = {b} }}")))
        .collect();
    for (i, pair) in ["normal normal", "normal uniform", "uniform normal", "uniform uniform"].into_iter().enumerate() {
        let (preload, friction) = pair.split_once(' ').unwrap();
        let random = format!(
            "relative_std = [{}]\ndistribution = {{ preload = \"{preload}\", static_friction = \"{friction}\" }}",
            stds.join(", ")
        );
        for p in surface(&place, &format!("of-{i}"), &job(axes, &random, EXACT)).column("p_unstable") {
            (least, most) = (p.min(least), p.max(most));
        }
    }
    assert_eq!((number(&rows[0], "p_lower"), number(&rows[0], "p_upper")), (least, most));
    assert_eq!(rows[0]["p_lower_evidence"], "proved");
}

#[test]
fn a_parameter_of_the_brake_may_be_imprecise() {
    let place = Place::new();
    let axes = "preload = 0.1\nstatic_friction = 0.38\n\"damping.tangential\" = { between = [300, 450] }\nrotating_speed = { between = [14, 16] }";
    let rows = bounds(&place, &job(axes, "relative_std = 0.1", EXACT));
    // Damping stabilises, and so does speed.
    assert_eq!(
        (number(&rows[0], "damping.tangential_at_upper"), number(&rows[0], "rotating_speed_rad_s_at_upper")),
        (300.0, 14.0)
    );
    assert_eq!(
        (rows[0]["damping.tangential_trend"].as_str(), rows[0]["p_upper_evidence"].as_str()),
        (Some("falls (checked)"), Some("checked"))
    );
    let text = job(
        &axes.replace("{ between = [300, 450] }", "300").replace("{ between = [14, 16] }", "14"),
        "relative_std = 0.1",
        EXACT,
    );
    assert_eq!(surface(&place, "upper", &text).column("p_unstable")[0], number(&rows[0], "p_upper"));
}

#[test]
fn the_file_has_what_json_has_whatever_the_threads() {
    let place = Place::new();
    let axes = "preload = [0.05, 0.1, 0.2]\nstatic_friction = { between = [0.37, 0.39] }\nrotating_speed = [13, 15]";
    let random =
        "relative_std = { between = [0.1, 0.2] }\ndistribution = { preload = { one_of = [\"normal\", \"gumbel\"] } }";
    let text = job(axes, random, EXACT);
    let rows = bounds(&place, &text);
    place.run("bounds bounds.toml --out one.parquet --threads 1").done();
    place.run("bounds bounds.toml --out two.parquet --threads 2").done();
    let bytes = |name: &str| std::fs::read(place.path(name)).unwrap();
    assert!(bytes("one.parquet") == bytes("two.parquet"));
    let table = Table::read(&place.path("one.parquet"));
    let known = ["cell", "rotating_speed_rad_s", "preload"].map(str::to_owned);
    let ends = ["lower", "upper"].map(|end| ["", "_error", "_bound", "_evidence"].map(|kind| format!("p_{end}{kind}")));
    let places = ["static_friction", "std_preload", "std_static_friction", "distribution_preload"]
        .map(|name| ["at_lower", "at_upper", "trend"].map(|kind| format!("{name}_{kind}")));
    let all = known.iter().chain(ends.iter().flatten()).chain(places.iter().flatten());
    let expected: Vec<&str> =
        all.map(String::as_str).filter(|name| *name != "distribution_preload_trend").chain(["evaluations"]).collect();
    assert_eq!(table.names(), expected);
    assert_eq!(rows.len(), 6);
    for (i, row) in rows.iter().enumerate() {
        for name in expected.iter().filter(|name| row[**name].is_f64()) {
            let (in_file, in_json) = (table.column(name)[i], number(row, name));
            assert!((in_file - in_json).abs() <= 4e-16 * in_file.abs(), "{name} of {row}: {in_file}");
        }
    }
    let footer = |key: &str| table.footer.iter().find(|(name, _)| name == key).map(|(_, value)| value.clone());
    assert_eq!(footer("stickslip:job"), Some(text));
    assert!(footer("stickslip:imprecise").is_some_and(|text| text.contains("distribution_preload")));
}

#[test]
fn imprecise_jobs_are_described_by_check_and_refused_elsewhere() {
    let place = Place::new();
    let axes = "preload = [0.1, 0.2]\nstatic_friction = { between = [0.37, 0.39] }";
    place.write(
        "rough.toml",
        &job(axes, "relative_std = 0.1\ndistribution = { preload = { one_of = [\"normal\", \"gumbel\"] } }", EXACT),
    );
    let printed = place.run("check rough.toml").done().stdout;
    for text in [
        "static_friction between 0.37 and 0.39",
        "one of normal, gumbel",
        "2 cells, 2 combinations",
        "stickslip bounds rough.toml",
    ] {
        assert!(printed.contains(text), "{text}: {printed}");
    }
    // With every key, it is a job that is imprecise in the same.
    let all = place.run("check rough.toml --all").done().stdout;
    for text in [
        "preload = [0.1, 0.2]\n",
        "static_friction = { between = [0.37, 0.39] }\n",
        "{ preload = { one_of = [\"normal\", \"gumbel\"] } }\n",
        "stribeck_velocity = 0.72\n",
    ] {
        assert!(all.contains(text), "{text}: {all}");
    }
    place.write("all.toml", &all);
    let described = |text: &str| text.lines().skip(1).take(3).map(str::to_owned).collect::<Vec<_>>();
    let mut again = [&printed, &place.run("check all.toml").done().stdout].map(|text| described(text));
    again.iter_mut().for_each(|lines| lines.sort_unstable());
    assert_eq!(again[0], again[1]);
    let printed: Value = serde_json::from_str(&place.run("check rough.toml --json").done().stdout).unwrap();
    assert_eq!(printed["imprecise"][0]["between"], serde_json::json!([0.37, 0.39]));
    for command in ["submit rough.toml", "limit rough.toml --of preload --probability 0.1"] {
        place.run(command).refused(
            65,
            &["rough.toml:5:19", "axes.static_friction is imprecise", "stickslip bounds", "rough.toml:10:"],
        );
    }
    place.write("precise.toml", &job("preload = 0.1", "relative_std = 0.1", EXACT));
    place
        .run("bounds precise.toml")
        .refused(64, &["nothing in the job \"bounds\" is imprecise", "between = [LOW, HIGH]"]);
    place.run("bounds none.toml").refused(74, &["none.toml"]);
    place.run("bounds rough.toml --out none/out.parquet").refused(73, &["none"]);
    place.run("bounds rough.toml --out out.csv").refused(64, &["out.parquet"]);
}

#[test]
fn what_is_no_imprecise_value_is_refused_with_its_line_and_a_remedy() {
    let place = Place::new();
    let axes = "preload = 0.1\nstatic_friction = 0.37";
    let refused = |axes: &str, random: &str, sampling: &str, line: u32, texts: &[&str]| {
        place.write("job.toml", &job(axes, random, sampling));
        let place_in_file = format!("job.toml:{line}:");
        let texts: Vec<&str> = [place_in_file.as_str()].into_iter().chain(texts.iter().copied()).collect();
        place.run("bounds job.toml").refused(65, &texts);
    };
    for (value, texts) in [
        ("{ between = [0.1, 0.2, 0.3] }", &["random.relative_std of preload", "3 values", "between = [LOW, HIGH]"][..]),
        ("{ between = [0.3, 0.1] }", &["reversed", "between = [0.1, 0.3]"]),
        ("{ between = [0.1, 0.1] }", &["both ends", "write 0.1"]),
        ("{ between = [-0.1, 0.1] }", &["-0.1 is out of range", "at least 0"]),
        ("{ between = [0.1, 2] }", &["preload", "would be negative too often", "largest possible is 1"]),
        ("{ between = [\"a\", 1] }", &["\"a\" is no end"]),
        ("{ between = [nan, 1] }", &["nan is no end"]),
        ("{ between = 0.1 }", &["with a list"]),
        ("{ between = [0.1, 0.2], one_of = [0.1] }", &["no other key"]),
        ("{ one_of = [] }", &["empty"]),
        ("{ one_of = [0.1] }", &["write 0.1 without one_of"]),
        ("{ one_of = [0.1, 0.1] }", &["0.1 twice"]),
        ("[{ between = [0.1, 0.2] }, 0.3]", &["makes an axis", "one table"]),
    ] {
        refused(axes, &format!("relative_std = {value}"), EXACT, 9, texts);
    }
    let rough = "relative_std = { between = [0.1, 0.3] }";
    let with = |line: &str| format!("relative_std = 0.1\n{line}");
    refused(
        axes,
        &with("distribution = { one_of = [\"normal\", \"lognorml\"] }"),
        EXACT,
        10,
        &["\"lognorml\"; did you mean \"lognormal\"?"],
    );
    refused(axes, &with("distribution = { between = [\"normal\", \"gumbel\"] }"), EXACT, 10, &["one_of"]);
    refused(
        axes,
        &with("correlation = [[\"preload\", \"static_friction\", { between = [-1, 0] }]]"),
        EXACT,
        10,
        &["greater than -1"],
    );
    refused("preload = { between = [0.1, 2] }", "relative_std = 0.1", EXACT, 4, &["axes.preload: 2 is out of range"]);
    refused("preload_force = { between = [100, 200] }", "relative_std = 0.1", EXACT, 4, &["axes.preload"]);
    refused(
        axes,
        rough,
        "method = \"monte-carlo\"",
        15,
        &["random.relative_std of preload", "sampling.method = \"exact\""],
    );
    refused(axes, rough, "seed = 1", 9, &["sampling.method = \"exact\""]);
    place.write("job.toml", &job(axes, rough, EXACT).replace(EIGENVALUE, "kind = \"time-domain\"\ndisc = \"rigid\""));
    place.run("bounds job.toml").refused(65, &["job.toml:12:", "criterion.kind = \"eigenvalue\""]);
    place.write(
        "job.toml",
        &job(axes, rough, EXACT).replace("[axes]", "model.damping.tangential = { between = [1, 2] }\n[axes]"),
    );
    place
        .run("bounds job.toml")
        .refused(65, &["model.damping.tangential: this cannot be imprecise", "axes.\"section.name\""]);
}

/// Hoffmann's two masses with damping: a pair grows from the friction 1 + 2 (0.02 d)^2 on.
fn masses(damping: &str, friction: &str, random: &str) -> String {
    format!(
        r#"name = "masses"
[model]
kind = "matrices"
mass = {{ matrix = [[1, 0], [0, 1]] }}
damping = {{ matrix = [[0.02, 0], [0, 0.02]], factor = "damping" }}
stiffness = [{{ matrix = [[2, 1], [1, 2]] }}, {{ matrix = [[0, 1], [0, 0]], factor = "-friction" }}]
[model.parameters]
friction = {friction}
damping = {damping}
[random]
inputs = ["friction"]
{random}
[criterion]
kind = "complex-eigenvalue"
[sampling]
method = "exact"
"#
    )
}

/// The probability that the friction is beyond its critical value, in standard deviations from the expected one.
fn beyond(damping: f64, friction: f64, std: f64) -> f64 {
    let critical = 1.0 + 2.0 * (0.02 * damping) * (0.02 * damping);
    normal::upper_tail((critical - friction) / (std * friction))
}

#[test]
fn every_parameter_of_matrices_may_be_imprecise() {
    let place = Place::new();
    let between = |low: f64, high: f64| format!("{{ between = [{low}, {high}] }}");
    let (precise, scatter) = ("relative_std = 0.1", format!("relative_std = {}", between(0.05, 0.15)));
    // The lower and the upper end: damping, friction, relative standard deviation.
    let cases = [
        (masses(&between(0.5, 8.0), "0.9", precise), [(8.0, 0.9, 0.1), (0.5, 0.9, 0.1)]),
        (masses("2.0", &between(0.8, 1.1), precise), [(2.0, 0.8, 0.1), (2.0, 1.1, 0.1)]),
        (masses("2.0", "0.9", &scatter), [(2.0, 0.9, 0.05), (2.0, 0.9, 0.15)]),
        (masses(&between(0.5, 8.0), &between(0.8, 0.9), &scatter), [(8.0, 0.8, 0.05), (0.5, 0.9, 0.15)]),
        // More scatter is less squeal where the expected brake squeals.
        (masses("2.0", "1.1", &scatter), [(2.0, 1.1, 0.15), (2.0, 1.1, 0.05)]),
    ];
    for (text, ends) in cases {
        let rows = bounds(&place, &text);
        for ((damping, friction, std), key) in ends.into_iter().zip(["p_lower", "p_upper"]) {
            let (expected, found) = (beyond(damping, friction, std), number(&rows[0], key));
            assert!((found / expected - 1.0).abs() < 1e-6, "{key} {found} {expected}\n{text}");
            assert_eq!(rows[0][format!("{key}_evidence")], "checked");
        }
    }
    let alternatives = "relative_std = 0.1\ndistribution = { friction = { one_of = [\"normal\", \"uniform\"] } }";
    let rows = bounds(&place, &masses("2.0", "0.8", alternatives));
    // Uniform friction ends at 0.8 (1 + 0.1 sqrt(3)), below the critical value.
    assert_eq!(
        (number(&rows[0], "p_lower"), rows[0]["distribution_friction_at_lower"].as_str()),
        (0.0, Some("uniform"))
    );
    assert!((number(&rows[0], "p_upper") / beyond(2.0, 0.8, 0.1) - 1.0).abs() < 1e-6);
}
