//! Limits by each method: against independent root finding on runs, and how often their bounds hold.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{EIGENVALUE, Place, submitted};
use serde_json::Value;

const BOTH: &str =
    "inputs = [\"preload\", \"static_friction\"]\nrelative_std = { preload = 0.2, static_friction = 0.1 }";
const THREE: &str = "inputs = [\"preload\", \"static_friction\", \"damping.tangential\"]\n\
    relative_std = { preload = 0.1, static_friction = 0.08, \"damping.tangential\" = 0.1 }";
const EXACT: &str = "method = \"exact\"";
const RIGID: &str = "kind = \"time-domain\"\ndisc = \"rigid\"";

/// A job but for its axes.
#[derive(Clone, Copy)]
struct Job<'a> {
    before: &'a str,
    random: &'a str,
    criterion: &'a str,
    sampling: &'a str,
}

impl Job<'_> {
    fn text(&self, axes: &str) -> String {
        let Self { before, random, criterion, sampling } = self;
        format!(
            "name = \"limits\"\n{before}\n[axes]\n{axes}\n[random]\n{random}\n[criterion]\n{criterion}\n[sampling]\n{sampling}\n"
        )
    }

    /// The rows of `limit --json`.
    #[track_caller]
    fn limits(&self, place: &Place, axes: &str, arguments: &str) -> Vec<Value> {
        place.write("limits.toml", &self.text(axes));
        let outcome = place.run(&format!("limit limits.toml --json {arguments}")).done();
        let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
        found["limits"].as_array().unwrap().clone()
    }

    /// A column of the surface of a run with these values of an axis.
    fn column(&self, place: &Place, axes: &str, of: &str, values: &[f64], column: &str) -> Vec<f64> {
        if place.path("run").exists() {
            fs::remove_dir_all(place.path("run")).unwrap();
        }
        submitted(place, "run", &self.text(&format!("{axes}\n{of} = {values:?}"))).column(column).to_vec()
    }

    /// Where `p_unstable` of runs passes a target once between two values, by dividing the bracket in sixteen again and
    /// again.
    fn root(&self, place: &Place, axes: &str, of: &str, mut bracket: [f64; 2], target: f64) -> f64 {
        for _ in 0..7 {
            let [from, to] = bracket;
            let values: Vec<f64> = (0..=16).map(|i| from + (to - from) * f64::from(i) / 16.0).collect();
            let p = self.column(place, axes, of, &values, "p_unstable");
            let passages: Vec<usize> = (0..16).filter(|&i| (p[i] > target) != (p[i + 1] > target)).collect();
            let [only] = passages[..] else { panic!("{target}: {values:?} {p:?}") };
            bracket = [values[only], values[only + 1]];
        }
        0.5 * (bracket[0] + bracket[1])
    }
}

fn number(row: &Value, key: &str) -> f64 {
    row[key].as_f64().unwrap_or_else(|| panic!("{key} of {row}"))
}

fn states(rows: &[Value]) -> Vec<&str> {
    rows.iter().map(|row| row["state"].as_str().unwrap()).collect()
}

#[test]
fn exact_limits_are_roots_of_the_surfaces_of_runs() {
    let place = Place::new();
    let job = Job { before: "", random: BOTH, criterion: EIGENVALUE, sampling: EXACT };
    let others = "rotating_speed = 15.0\nstatic_friction = 0.39";
    let rows = job.limits(
        &place,
        &format!("{others}\npreload = [0.001, 0.3]"),
        "--of preload --probability 1e-6 --probability 0.01 --probability 0.5",
    );
    assert_eq!(rows.len(), 3);
    for row in &rows {
        let root = job.root(&place, others, "preload", [0.001, 0.3], number(row, "target"));
        assert!((number(row, "limit") / root - 1.0).abs() < 1e-6, "{row} {root}");
    }
}

#[test]
fn an_island_has_a_limit_on_either_side_and_none_beside_it() {
    let place = Place::new();
    // With an exponent of 2 slow sliding is stable, too, and so is all sliding with little preload.
    let before = "[model.friction]\nstribeck_exponent = 2.0";
    let job = Job { before, random: BOTH, criterion: EIGENVALUE, sampling: EXACT };
    let axes = "rotating_speed = [0.1, 5.0, 25.0]\npreload = [0.0005, 0.01, 0.02]\nstatic_friction = 0.39";
    let rows = job.limits(&place, axes, "--of rotating_speed --probability 0.01");
    assert_eq!(states(&rows), ["within", "rises", "falls", "rises", "falls"], "{rows:?}");
    assert!(rows[0]["limit"].is_null() && number(&rows[0], "p_from") < 0.01);
    for (row, bracket) in rows[1..].iter().zip([[0.1, 4.0], [4.0, 25.0]].iter().cycle()) {
        let others = format!("preload = {}\nstatic_friction = 0.39", row["preload"]);
        let root = job.root(&place, &others, "rotating_speed", *bracket, 0.01);
        assert!((number(row, "limit") / root - 1.0).abs() < 1e-6, "{row} {root}");
    }
}

#[test]
fn limits_over_a_verdict_map_are_roots_of_the_surfaces_of_runs() {
    let place = Place::new();
    let job = Job { before: "", random: BOTH, criterion: RIGID, sampling: "method = \"exact\"\naudit = 0" };
    for (of, others, axis) in [
        ("preload", "rotating_speed = 15.0\nstatic_friction = 0.39", [0.02, 0.15]),
        ("static_friction", "rotating_speed = 15.0\npreload = 0.08", [0.3, 0.5]),
    ] {
        let rows = job.limits(&place, &format!("{others}\n{of} = {axis:?}"), &format!("--of {of} --probability 0.2"));
        assert_eq!(states(&rows), ["rises"], "{rows:?}");
        let (limit, low, high) =
            (number(&rows[0], "limit"), number(&rows[0], "limit_low"), number(&rows[0], "limit_high"));
        let root = job.root(&place, others, of, axis, 0.2);
        assert!((limit / root - 1.0).abs() < 1e-6, "{} {root}", rows[0]);
        // The bounds are where the bounds of the integral are the target.
        assert!(low < limit && limit < high && high - low < 1e-3 * limit, "{}", rows[0]);
        let p_high = job.column(&place, others, of, &[low * (1.0 - 1e-6), low * (1.0 + 1e-6)], "p_high");
        assert!(p_high[0] <= 0.2 && 0.2 < p_high[1], "{p_high:?}");
        let p_low = job.column(&place, others, of, &[high * (1.0 - 1e-6), high * (1.0 + 1e-6)], "p_low");
        assert!(p_low[0] <= 0.2 && 0.2 < p_low[1], "{p_low:?}");
    }
    let axes = "rotating_speed = [10.0, 15.0]\npreload = 0.08\nstatic_friction = 0.39";
    place.write("speed.toml", &job.text(axes));
    place
        .run("limit speed.toml --of rotating_speed --probability 0.1")
        .refused(64, &["preload and static_friction", "kind = \"eigenvalue\""]);
}

#[test]
fn the_interval_of_a_run_passes_the_target_at_the_bounds() {
    let place = Place::new();
    // With shared deviates the cells of a run have the samples of the limits.
    let shared = "common_random_numbers = true";
    for (sampling, random, of, others, axis) in [
        (
            "method = \"sobol\"\nsamples = 4096",
            BOTH,
            "preload",
            "rotating_speed = 15.0\nstatic_friction = 0.39",
            [0.001, 0.3],
        ),
        (
            "method = \"conditional\"\nsamples = 128",
            THREE,
            "preload",
            "rotating_speed = 15.0\nstatic_friction = 0.39",
            [0.001, 0.3],
        ),
        (
            "method = \"conditional\"\nsamples = 64",
            THREE,
            "rotating_speed",
            "preload = 0.06\nstatic_friction = 0.39",
            [10.0, 20.0],
        ),
        ("samples = 2000", THREE, "rotating_speed", "preload = 0.06\nstatic_friction = 0.39", [10.0, 20.0]),
        ("samples = 2000", BOTH, "damping.tangential", "rotating_speed = 15.0\npreload = 0.06", [100.0, 700.0]),
    ] {
        let sampling = format!("{sampling}\nseed = 5\n{shared}");
        let job = Job { before: "", random, criterion: EIGENVALUE, sampling: &sampling };
        let quoted = if of.contains('.') { format!("\"{of}\"") } else { of.to_owned() };
        let axes = format!("{others}\n{quoted} = {axis:?}");
        let rows = job.limits(&place, &axes, &format!("--of {of} --probability 0.1"));
        let [row] = &rows[..] else { panic!("{rows:?}") };
        let rises = row["state"] == "rises";
        for (key, column) in [("limit_low", "p_high"), ("limit", "p_unstable"), ("limit_high", "p_low")] {
            let at = number(row, key);
            // Where the probability falls, its lower end passes the target first.
            let column = match column {
                "p_high" if !rises => "p_low",
                "p_low" if !rises => "p_high",
                column => column,
            };
            let around = [at * (1.0 - 1e-7), at * (1.0 + 1e-7)];
            let mut p = job.column(&place, others, &quoted, &around, column);
            if !rises {
                p.reverse();
            }
            assert!(p[0] <= 0.1 && 0.1 < p[1], "{sampling} {row}: {column} {p:?}");
        }
    }
}

/// How many of the intervals of 100 seeds contain a limit.
fn covered(job: &Job<'_>, axes: &str, of: &str, target: f64, limit: f64) -> (u32, f64) {
    let place = Place::new();
    let (mut covered, mut width) = (0, 0.0);
    for seed in 0..100 {
        let sampling = format!("{}\nseed = {seed}", job.sampling);
        let rows =
            Job { sampling: &sampling, ..*job }.limits(&place, axes, &format!("--of {of} --probability {target}"));
        assert_eq!(rows.len(), 1, "{rows:?}");
        let (low, high) = (number(&rows[0], "limit_low"), number(&rows[0], "limit_high"));
        covered += u32::from(low <= limit && limit <= high);
        width += (high - low) / limit / 100.0;
    }
    (covered, width)
}

#[test]
fn intervals_of_sobol_points_contain_the_limit_and_are_narrow() {
    let axes = "rotating_speed = 15.0\npreload = [0.01, 0.3]\nstatic_friction = 0.39";
    let job = Job { before: "", random: BOTH, criterion: EIGENVALUE, sampling: EXACT };
    let exact = number(&job.limits(&Place::new(), axes, "--of preload --probability 0.1")[0], "limit");
    let sobol = covered(&Job { sampling: "method = \"sobol\"\nsamples = 4096", ..job }, axes, "preload", 0.1, exact);
    let random = covered(&Job { sampling: "samples = 2048", ..job }, axes, "preload", 0.1, exact);
    assert!(sobol.0 >= 93 && random.0 >= 93, "{sobol:?} {random:?}");
    // Twice as many independent samples would have intervals 0.71 times as wide.
    assert!(sobol.1 < 0.5 * 0.71 * random.1, "{sobol:?} {random:?}");
}

#[test]
fn intervals_of_samples_contain_the_limit_along_any_axis() {
    let axes = "rotating_speed = [10.0, 20.0]\npreload = 0.06\nstatic_friction = 0.39";
    let job = Job { before: "", random: BOTH, criterion: EIGENVALUE, sampling: EXACT };
    let exact = number(&job.limits(&Place::new(), axes, "--of rotating_speed --probability 0.1")[0], "limit");
    let random = covered(&Job { sampling: "samples = 500", ..job }, axes, "rotating_speed", 0.1, exact);
    assert!(random.0 >= 93, "{random:?}");
}

#[test]
fn intervals_of_conditional_probabilities_contain_the_limit() {
    let axes = "rotating_speed = 15.0\npreload = [0.01, 0.3]\nstatic_friction = 0.39";
    let many = Job { before: "", random: THREE, criterion: EIGENVALUE, sampling: "samples = 2_000_000\nseed = 99" };
    let reference = &many.limits(&Place::new(), axes, "--of preload --probability 0.1")[0];
    let job = Job { sampling: "method = \"conditional\"\nsamples = 32\nrandomisations = 8", ..many };
    let conditional = covered(&job, axes, "preload", 0.1, number(reference, "limit"));
    assert!(conditional.0 >= 93, "{conditional:?}");
    // The reference is known better than the intervals are wide.
    let width = (number(reference, "limit_high") - number(reference, "limit_low")) / number(reference, "limit");
    assert!(width < 0.2 * conditional.1, "{width} {conditional:?}");
}
