//! `stickslip limit`: the values of an axis at which the probability passes a target.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use crate::common::{EIGENVALUE, Place, Table, submitted};
use serde_json::Value;

/// A job with the given lines of `[axes]`, `[random]` and `[sampling]`, and `before` its axes.
fn job(before: &str, axes: &str, random: &str, sampling: &str) -> String {
    format!(
        "name = \"limits\"\n{before}\n[axes]\n{axes}\n[random]\n{random}\n[criterion]\n{EIGENVALUE}\n[sampling]\n{sampling}\n"
    )
}

const BOTH: &str =
    "inputs = [\"preload\", \"static_friction\"]\nrelative_std = { preload = 0.2, static_friction = 0.1 }";
const PRELOADS: &str = "rotating_speed = 15.0\npreload = { from = 0.01, to = 0.3, points = 4 }";
const EXACT: &str = "method = \"exact\"";

/// The rows of `limit --json` on a job.
#[track_caller]
fn limits(place: &Place, text: &str, arguments: &str) -> Vec<Value> {
    place.write("limits.toml", text);
    let outcome = place.run(&format!("limit limits.toml --json {arguments}")).done();
    let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
    found["limits"].as_array().unwrap().clone()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"))
}

/// A column of the surface of a job.
fn surface(place: &Place, text: &str, run: &str, column: &str) -> Vec<f64> {
    submitted(place, run, text).column(column).to_vec()
}

#[test]
fn an_exact_run_has_the_target_at_the_limit() {
    let place = Place::new();
    let axes = "rotating_speed = [12.0, 15.0]\npreload = { from = 0.001, to = 0.3, points = 3 }\nstatic_friction = [0.35, 0.45]";
    let rows = limits(&place, &job("", axes, BOTH, EXACT), "--of preload --probability 0.01 --probability 0.3");
    assert_eq!(rows.len(), 8, "four combinations, two targets: {rows:?}");
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row["state"], "rises");
        assert_eq!(
            (number(row, "rotating_speed_rad_s"), number(row, "static_friction")),
            [(12.0, 0.35), (12.0, 0.45), (15.0, 0.35), (15.0, 0.45),][i / 2]
        );
        assert_eq!(number(row, "target"), [0.01, 0.3][i % 2]);
        let limit = number(row, "limit");
        let axes = format!(
            "rotating_speed = {}\npreload = {limit}\nstatic_friction = {}",
            row["rotating_speed_rad_s"], row["static_friction"]
        );
        let p = surface(&place, &job("", &axes, BOTH, EXACT), &format!("run-{i}"), "p_unstable")[0];
        let target = number(row, "target");
        assert!(p <= target && p > target * (1.0 - 1e-9), "{row}: {p}");
        assert!(number(row, "limit_low") <= limit && limit <= number(row, "limit_high"));
        assert!(number(row, "p_from") < target && number(row, "p_to") > target);
    }
}

#[test]
fn correlated_inputs_of_any_distribution_have_the_target_at_the_limit() {
    let place = Place::new();
    let random =
        format!("{BOTH}\ndistribution = \"lognormal\"\ncorrelation = [[\"preload\", \"static_friction\", 0.5]]");
    let axes = format!("{PRELOADS}\nstatic_friction = 0.4");
    for (i, target) in [1e-6, 0.01].into_iter().enumerate() {
        let rows = limits(&place, &job("", &axes, &random, EXACT), &format!("--of preload --probability {target}"));
        let axes = format!("rotating_speed = 15.0\npreload = {}\nstatic_friction = 0.4", rows[0]["limit"]);
        let p = surface(&place, &job("", &axes, &random, EXACT), &format!("run-{i}"), "p_unstable")[0];
        assert!((p - target).abs() < 1e-6 * target, "{target}: {p}");
        let independent = limits(
            &place,
            &job("", &format!("{PRELOADS}\nstatic_friction = 0.4"), BOTH, EXACT),
            &format!("--of preload --probability {target}"),
        );
        assert!(
            number(&independent[0], "limit") > number(&rows[0], "limit"),
            "tails are heavier where both rise together"
        );
    }
}

#[test]
fn one_random_input_has_a_limit_in_closed_form() {
    let place = Place::new();
    let random = "inputs = [\"preload\"]\nrelative_std = 0.2";
    let axes = format!("{PRELOADS}\nstatic_friction = 0.39");
    let rows = limits(&place, &job("", &axes, random, EXACT), "--of preload --probability 0.5 --probability 0.05");
    let analysed = place.run("analyse --set operating_point.rotating_speed=15 --json").done();
    let analysed: Value = serde_json::from_str(&analysed.stdout).unwrap();
    let critical = number(&analysed, "critical_preload");
    // Unstable is v (1 + 0.2 z) > critical; z is 1.6448536 with a probability of 5 %.
    for (row, z) in rows.iter().zip([0.0, 1.644_853_626_951_472_7]) {
        let limit = number(row, "limit");
        assert!((limit * (1.0 + 0.2 * z) / critical - 1.0).abs() < 1e-11, "{row} {critical}");
    }
    // The same by samples: the interval contains it.
    let sampled = job("", &axes, random, "samples = 20_000\nseed = 7");
    for (row, exact) in limits(&place, &sampled, "--of preload --probability 0.5 --probability 0.05").iter().zip(&rows)
    {
        let exact = number(exact, "limit");
        assert!(number(row, "limit_low") <= exact && exact <= number(row, "limit_high"), "{row} {exact}");
        assert!(number(row, "limit_high") / number(row, "limit_low") < 1.05, "{row}");
    }
}

#[test]
fn a_speed_axis_has_a_limit_on_either_side_of_instability() {
    let place = Place::new();
    let before = "[model.friction]\nstribeck_exponent = 2.0";
    let axes = "rotating_speed = [0.05, 5.0, 25.0]\npreload = 0.1\nstatic_friction = 0.45";
    let rows = limits(&place, &job(before, axes, BOTH, EXACT), "--of rotating_speed --probability 0.01");
    let states: Vec<&str> = rows.iter().map(|row| row["state"].as_str().unwrap()).collect();
    assert_eq!(states, ["rises", "falls"], "{rows:?}");
    assert!(rows.iter().all(|row| row.get("rotating_speed_rad_s").is_none()), "{rows:?}");
    for (i, row) in rows.iter().enumerate() {
        let axes = format!("rotating_speed = {}\npreload = 0.1\nstatic_friction = 0.45", row["limit"]);
        let p = surface(&place, &job(before, &axes, BOTH, EXACT), &format!("run-{i}"), "p_unstable")[0];
        assert!((p / 0.01 - 1.0).abs() < 1e-6 && p <= 0.01, "{row}: {p}");
    }
    // A parameter of the brake: more damping is needed below the limit.
    let axes = "\"damping.tangential\" = [100.0, 1000.0]\nrotating_speed = 15.0\npreload = 0.1\nstatic_friction = 0.39";
    let rows = limits(&place, &job("", axes, BOTH, EXACT), "--of damping.tangential --probability 0.01");
    assert_eq!((rows.len(), rows[0]["state"].as_str()), (1, Some("falls")));
    let axes = axes.replace("[100.0, 1000.0]", &rows[0]["limit"].to_string());
    let p = surface(&place, &job("", &axes, BOTH, EXACT), "damped", "p_unstable")[0];
    assert!((p / 0.01 - 1.0).abs() < 1e-6 && p <= 0.01, "{p}");
}

#[test]
fn a_measured_curve_may_be_unstable_between_two_friction_coefficients() {
    let place = Place::new();
    let before = "[model.damping]\ntangential = 50.0\n[model.friction]\nlaw = \"table\"\ntable = { speed = [0, 1, 4], coefficient = [0.3, 0.32, 0.33], std = [0.02, 0.06, 0.1] }\nband = -2.0";
    let axes = "rotating_speed = 1.0\npreload = 0.1\nstatic_friction = [0.01, 5.0]";
    let exact =
        limits(&place, &job(before, axes, BOTH, EXACT), "--of static_friction --probability 0.5 --probability 0.1");
    let states: Vec<&str> = exact.iter().map(|row| row["state"].as_str().unwrap()).collect();
    assert_eq!(states, ["rises", "falls", "rises", "falls"], "{exact:?}");
    let sampling = "samples = 20_000\nseed = 7";
    let sampled =
        limits(&place, &job(before, axes, BOTH, sampling), "--of static_friction --probability 0.5 --probability 0.1");
    for (row, exact) in sampled.iter().zip(&exact) {
        assert_eq!(row["state"], exact["state"]);
        let (low, high) = (number(row, "limit_low"), number(row, "limit_high"));
        assert!(low <= number(exact, "limit") && number(exact, "limit") <= high, "{row} {exact}");
    }
}

/// Asserts that with shared deviates the counts of a run pass the target at each limit of its samples.
#[track_caller]
fn assert_counts_pass(random: &str, sampling: &str, criterion: &str, of: &str, axis: [f64; 2]) {
    let place = Place::new();
    let sampling = format!("{sampling}\ncommon_random_numbers = true");
    let other = if of == "preload" { "static_friction = 0.37" } else { "preload = 0.08" };
    let text = |values: [f64; 2]| {
        let axes = format!("rotating_speed = 15.0\n{of} = [{}, {}]\n{other}", values[0], values[1]);
        job("", &axes, random, &sampling).replace(EIGENVALUE, &format!("{EIGENVALUE}\n{criterion}"))
    };
    let rows =
        limits(&place, &text(axis), &format!("--of {of} --probability 0.02 --probability 0.2 --probability 0.35"));
    assert_eq!(rows.len(), 3, "{rows:?}");
    for (i, row) in rows.iter().enumerate() {
        assert_eq!(row["state"], "rises", "{row}");
        let limit = number(row, "limit");
        assert!(number(row, "limit_low") < limit && limit < number(row, "limit_high"), "{row}");
        let around = [limit * (1.0 - 1e-9), limit * (1.0 + 1e-9)];
        let table = submitted(&place, &format!("run-{i}"), &text(around));
        let p = table.column("p_unstable");
        let target = number(row, "target");
        assert!(p[0] <= target && target < p[1], "{row}: {p:?}");
        assert!(p[1] - p[0] < 0.001, "one sample decides: {p:?}");
        // At its bounds the interval of the run begins and ceases to contain the target.
        for (bound, column) in [("limit_low", "p_high"), ("limit_high", "p_low")] {
            let at = number(row, bound);
            if axis.contains(&at) || sampling.contains("sobol") {
                continue;
            }
            let around = [at * (1.0 - 1e-9), at * (1.0 + 1e-9)];
            let table = submitted(&place, &format!("run-{i}-{bound}"), &text(around));
            let end = table.column(column);
            assert!(end[0] <= target && target < end[1], "{row} {bound}: {end:?}");
        }
    }
}

#[test]
fn limits_of_samples_are_where_the_counts_of_a_run_pass_the_target() {
    let sampling = "samples = 4000\nseed = 11";
    assert_counts_pass(BOTH, sampling, "", "preload", [0.01, 0.3]);
    assert_counts_pass(BOTH, sampling, "", "static_friction", [0.26, 0.6]);
    assert_counts_pass(BOTH, "method = \"sobol\"\nsamples = 4096\nseed = 11", "", "static_friction", [0.26, 0.6]);
}

#[test]
fn limits_of_samples_hold_for_all_inputs_distributions_and_choices_outside_physics() {
    let sampling = "samples = 3000\nseed = 12\nconfidence = 0.9";
    let random = "inputs = [\"preload\", \"static_friction\", \"damping.tangential\", \"friction.stribeck_velocity\"]\n\
        relative_std = { preload = 0.3, static_friction = 0.15, \"damping.tangential\" = 0.3, \"friction.stribeck_velocity\" = 0.1 }\n\
        distribution = { preload = \"lognormal\", static_friction = \"weibull\", \"damping.tangential\" = \"gumbel\" }\n\
        correlation = [[\"preload\", \"static_friction\", 0.5]]";
    assert_counts_pass(random, sampling, "", "preload", [0.001, 0.5]);
    assert_counts_pass(random, sampling, "", "static_friction", [0.26, 1.5]);
    for outside in ["failed", "clamp"] {
        let criterion = format!("outside_physics = \"{outside}\"");
        assert_counts_pass(BOTH, sampling, &criterion, "static_friction", [0.26, 0.8]);
        assert_counts_pass(BOTH, sampling, &criterion, "preload", [0.01, 0.5]);
    }
}

#[test]
fn without_a_limit_the_state_is_reported() {
    let place = Place::new();
    let text = job("", "rotating_speed = [15.0, 3.0]\npreload = [0.001, 0.005]\nstatic_friction = 0.39", BOTH, EXACT);
    let rows = limits(&place, &text, "--of preload --probability 0.2");
    assert_eq!(rows[0]["state"], "within", "{rows:?}");
    assert!(["limit", "limit_low", "limit_high"].iter().all(|key| rows[0][key].is_null()), "{rows:?}");
    assert!(number(&rows[0], "p_to") < 0.2);
    let shown = place.run("limit limits.toml --of preload --probability 0.2").done().stdout;
    assert!(shown.contains("within: P does not pass the target"), "{shown}");
    let text = job("", "rotating_speed = 3.0\npreload = [0.2, 0.3]\nstatic_friction = 0.45", BOTH, "samples = 1000");
    let rows = limits(&place, &text, "--of preload --probability 0.2");
    assert_eq!((rows[0]["state"].as_str(), rows[0]["limit"].is_null()), (Some("above"), true));
    assert!(number(&rows[0], "p_from") > 0.9);
}

/// The boundary of small motions in time is that of eigenvalues.
#[test]
fn limits_over_a_verdict_map_have_simulated_samples_beside_them() {
    let place = Place::new();
    let text = job("", &format!("{PRELOADS}\nstatic_friction = 0.39"), BOTH, EXACT);
    let closed = limits(&place, &text, "--of preload --probability 0.05");
    let in_time = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"near-equilibrium\"";
    let text = text.replace(EIGENVALUE, in_time);
    let mapped = limits(&place, &text, "--of preload --probability 0.05");
    assert_eq!((mapped.len(), closed.len()), (1, 1));
    let [limit, low, high] = ["limit", "limit_low", "limit_high"].map(|name| number(&mapped[0], name));
    let of_eigenvalues = number(&closed[0], "limit");
    assert!((limit / of_eigenvalues - 1.0).abs() < 2e-3 && low <= limit && limit <= high, "{limit} {of_eigenvalues}");
    let decided = ["n_audit", "n_audit_from", "n_audit_to"].map(|name| number(&mapped[0], name));
    assert_eq!((decided, number(&mapped[0], "distrust")), ([300.0; 3], 0.0));
    let said = place.run("limit limits.toml --of preload --probability 0.05").done().stdout;
    assert!(said.contains("300 plain samples at each limit and at both ends: no region of more than"), "{said}");
    assert!(!said.contains("taken for right"), "{said}");
    place.write("limits.toml", &text.replace(EXACT, &format!("{EXACT}\naudit = 0")));
    let said = place.run("limit limits.toml --of preload --probability 0.05").done().stdout;
    assert!(said.contains("leaves open, which is taken for right.") && !said.contains("plain samples"), "{said}");
}

#[test]
fn the_file_has_what_json_has_whatever_the_threads() {
    let place = Place::new();
    let axes = format!("{PRELOADS}\nstatic_friction = [0.39, 0.45]\n\"damping.tangential\" = [300, 369]");
    let random = BOTH.replace("0.2,", "[0.2, 0.3],").replace("= { preload", "= [{ preload");
    let random = random.replace(
        "[0.2, 0.3], static_friction = 0.1 }",
        "0.2, static_friction = 0.1 }, { preload = 0.3, static_friction = 0.1 }]",
    );
    for (sampling, keys) in [(EXACT, "stickslip:values_scanned"), ("samples = 2000\nseed = 4", "stickslip:confidence")]
    {
        let text = job("", &axes, &random, sampling);
        let rows = limits(&place, &text, "--of preload --probability 0.05 --out one.parquet --threads 1");
        place.run("limit limits.toml --of preload --probability 0.05 --out two.parquet --threads 2").done();
        let bytes = |name: &str| std::fs::read(place.path(name)).unwrap();
        assert!(bytes("one.parquet") == bytes("two.parquet"));
        let table = Table::read(&place.path("one.parquet"));
        let mut names = vec![
            "cell",
            "damping.tangential",
            "rotating_speed_rad_s",
            "std_preload",
            "std_static_friction",
            "static_friction",
            "of",
            "target",
            "state",
            "limit",
            "limit_low",
            "limit_high",
            "p_from",
            "p_to",
        ];
        // What is counted needs no plain samples beside it.
        if sampling == EXACT {
            names.extend(["n_audit", "n_audit_unstable", "n_audit_from", "n_audit_unstable_from"]);
            names.extend(["n_audit_to", "n_audit_unstable_to", "distrust"]);
        }
        assert_eq!(table.names(), names);
        assert_eq!(rows.len(), 8);
        for (i, row) in rows.iter().enumerate() {
            for name in table.names().iter().filter(|name| !["of", "state"].contains(&name.as_str())) {
                // The reader of JSON may round the last digit otherwise.
                let (in_file, in_json) = (table.column(name)[i], number(row, name));
                assert!((in_file - in_json).abs() <= 4e-16 * in_file.abs(), "{name} of {row}: {in_file}");
            }
            assert_eq!((row["of"].as_str(), row["state"].as_str()), (Some("preload"), Some("rises")));
        }
        let footer: Vec<&str> = table.footer.iter().map(|(key, _)| key.as_str()).collect();
        for key in ["stickslip:job", "stickslip:job_hash", "stickslip:of", keys] {
            assert!(footer.contains(&key), "{key}: {footer:?}");
        }
        // The cell is the one of the surface with the first value of the axis.
        let surface = submitted(&place, if sampling == EXACT { "exact" } else { "sampled" }, &text);
        for row in &rows {
            let cell = number(row, "cell") as usize;
            assert_eq!(surface.column("preload")[cell], 0.01);
            for name in ["damping.tangential", "std_preload", "static_friction"] {
                assert_eq!(surface.column(name)[cell], number(row, name), "{name}");
            }
            assert!((surface.column("p_unstable")[cell] - number(row, "p_from")).abs() < 1e-12);
        }
        // The run directory stands for the job.
        let run = if sampling == EXACT { "exact" } else { "sampled" };
        let again = place.run(&format!("limit {run} --of preload --probability 0.05 --json")).done();
        let again: Value = serde_json::from_str(&again.stdout).unwrap();
        assert_eq!(again["limits"].as_array().unwrap(), &rows);
    }
}

#[test]
fn what_has_no_limit_is_refused_with_a_remedy() {
    let place = Place::new();
    let axes = format!("{PRELOADS}\nstatic_friction = 0.39");
    let write = |name: &str, text: &str| place.write(&format!("{name}.toml"), text);
    write("exact", &job("", &axes, BOTH, EXACT));
    write("until", &job("", &axes, BOTH, "until = { half_width = 0.01 }"));
    write("many", &job("", &axes, BOTH, "samples = 1_000_000_000"));
    write(
        "time",
        &job("", &axes, BOTH, "samples = 10").replace(EIGENVALUE, "kind = \"time-domain\"\ndisc = \"rigid\""),
    );
    let refused = |words: &str, texts: &[&str]| {
        place.run(&format!("limit {words}")).refused(64, texts);
    };
    for p in ["0", "1", "1.5", "-0.1", "nan", "one"] {
        refused(&format!("exact.toml --of preload --probability {p}"), &["greater than 0 and less than 1", "0.01"]);
    }
    refused("exact.toml --of preload", &["--probability is missing", "no [limit]"]);
    refused("exact.toml --probability 0.1", &["--of is missing", "--of preload"]);
    let p = "--probability 0.01";
    refused(&format!("exact.toml --of prelaod {p}"), &["no such axis", "did you mean preload?"]);
    refused(&format!("exact.toml --of pad.mass {p}"), &["has no such axis", "preload", "[axes]"]);
    refused(&format!("exact.toml --of static_friction {p}"), &["one value, 0.39", "two or more"]);
    refused(&format!("exact.toml --of preload_force {p}"), &["name the axis preload"]);
    refused(&format!("until.toml --of preload {p}"), &["sampling.samples in place of sampling.until"]);
    refused(&format!("many.toml --of preload {p}"), &["10,000,000 samples of each combination at most"]);
    refused(&format!("time.toml --of preload {p}"), &["kind = \"eigenvalue\"", "surface.parquet"]);
    place.run(&format!("limit none.toml --of preload {p}")).refused(74, &["none.toml"]);
    place.run(&format!("limit exact.toml --of preload {p} --out none/out.parquet")).refused(73, &["none"]);
    refused(&format!("exact.toml --of preload {p} --out out.csv"), &["out.parquet"]);
}
