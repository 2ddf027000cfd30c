//! Large jobs: the memory that their cells take, and what many shards of them are predicted to cost.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

#[cfg(target_os = "linux")]
use std::process::Command;

use crate::common::{Place, surface_job};
use serde_json::Value;

#[test]
#[cfg(target_os = "linux")]
fn a_shard_of_a_million_cells_takes_little_memory() {
    let place = Place::new();
    // As many cells as there may be.
    place.write("job.toml", &surface_job("large", 1000, 2, 1));
    let (code, message) = with_memory(&place, 98_304, "submit job.toml --out run --threads 1 --shard 1/1000");
    assert_eq!(code, Some(0), "{message}");
    // What is there is read, also if it is not complete.
    let (code, message) = with_memory(&place, 98_304, "merge run");
    assert!(code == Some(65) && message.contains("1000 of 1000000 cells"), "{code:?} {message}");
}

/// Runs a command with so many KiB for its data: its exit code and its messages.
#[cfg(target_os = "linux")]
fn with_memory(place: &Place, kib: u32, words: &str) -> (Option<i32>, String) {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -d {kib} && exec {} {words}", env!("CARGO_BIN_EXE_stickslip"))]);
    let output = command.current_dir(place.path("")).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
#[cfg(target_os = "linux")]
fn too_little_memory_is_an_error_that_keeps_what_is_finished() {
    let place = Place::new();
    place.write("job.toml", &surface_job("large", 1000, 2, 1));
    place.run("submit job.toml --out run --shard 1/1000").done();
    let (code, message) = with_memory(&place, 16_384, "resume run --threads 1");
    assert_eq!(code, Some(74), "{message}");
    assert!(
        message.contains("out of memory") && message.contains("is kept") && !message.contains("panic"),
        "{message}"
    );
    assert!(place.run("status run").done().stdout.contains("1000 of 1000000 cells"));
}

#[test]
fn check_predicts_the_times_of_shards_and_merge() {
    let place = Place::new();
    place.write("job.toml", &surface_job("job", 20, 3000, 1));
    let checked = place.run("check job.toml --nodes 4 --threads 2 --json").done();
    let printed: Value = serde_json::from_str(&checked.stdout).unwrap();
    assert_eq!((&printed["cells"], &printed["samples_at_most"]), (&Value::from(400), &Value::from(1_200_000)));
    let cluster = &printed["cluster"];
    assert_eq!((&cluster["nodes"], &cluster["threads"]), (&Value::from(4), &Value::from(2)));
    for step in ["sample", "start", "piece_written", "piece_read", "row"] {
        assert!(cluster["seconds"][step].as_f64().unwrap() > 0.0, "{step}: {cluster:#}");
    }
    let shards = cluster["shards"].as_array().unwrap();
    assert_eq!(shards.iter().map(|cost| cost["shards"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 10, 100, 1000]);
    for cost in shards {
        let [all, merge, total] = ["all", "merge", "total"].map(|key| cost[key].as_f64().unwrap());
        assert!((all + merge - total).abs() < 1e-9 * total, "{cost:#}");
        assert!((0.0..1.0).contains(&cost["efficiency"].as_f64().unwrap()), "{cost:#}");
    }
    // Little work makes one shard, or one for each node where that is clearly quicker.
    let best = &cluster["best"];
    assert!(best["shards"] == 1 || best["shards"] == 4, "{cluster:#}");
    for cost in shards {
        assert!(best["total"].as_f64().unwrap() <= 1.05 * cost["total"].as_f64().unwrap(), "{cluster:#}");
    }

    // The page names every key.
    let page = include_str!("../../docs/cluster-costs.md");
    let described = page.split("\n## ").find(|section| section.starts_with("As JSON")).unwrap();
    for object in [&printed, cluster, &cluster["seconds"], &cluster["load"], best] {
        for key in object.as_object().unwrap().keys() {
            assert!(described.contains(&format!("`{key}`")), "`{key}` is not in the page");
        }
    }

    let text = place.run("check job.toml --nodes 4 --threads 2").done().stdout;
    for part in ["\n# on 4 nodes with 2 threads each, in ", "\n#     1000  ", "merge"] {
        assert!(text.contains(part), "{part:?} is not in {text}");
    }
    assert!(!place.run("check job.toml").done().stdout.contains("nodes"));
    for nodes in ["0", "100001"] {
        place.run(&format!("check job.toml --nodes {nodes}")).refused(64, &["--nodes", "1..=100000"]);
    }
}

#[test]
fn integrals_are_not_shared_among_nodes() {
    let place = Place::new();
    let job = surface_job("job", 3, 10, 1).replace("samples = 10", "method = \"exact\"");
    place.write("job.toml", &job);
    let text = place.run("check job.toml --nodes 4").done().stdout;
    assert!(text.contains("method = \"exact\" draws no samples that nodes could share"), "{text}");
    let printed: Value = serde_json::from_str(&place.run("check job.toml --nodes 4 --json").done().stdout).unwrap();
    assert!(printed["cluster"].is_null() && printed["load"].is_null(), "{printed:#}");
}

/// A job that is simulated and stops by precision is tried in two ways, one after the other.
#[test]
fn a_trial_of_simulated_samples_that_stop_by_precision_finds_a_cost() {
    let place = Place::new();
    let job = r#"
name = "until"
[axes]
rotating_speed = { from = 14.5, to = 19.3, points = 3 }
preload = { from = 0.17, to = 0.21, points = 6 }
static_friction = { from = 0.3, to = 0.5, points = 5 }
[random]
inputs = ["rotating_speed", "friction.kinetic_coefficient", "pad.mass"]
relative_std = 0.174
[criterion]
kind = "time-domain"
disc = "flexible"
start = "limit-cycle"
[sampling]
until = { relative = 0.3, at_most = 2637 }
"#;
    place.write("job.toml", job);
    let said: Value = serde_json::from_str(&place.run("check job.toml --threads 1 --json").done().stdout).unwrap();
    // No processor simulates a motion within a microsecond.
    let seconds = said["seconds_of_a_sample"].as_f64().unwrap();
    assert!(seconds > 1e-6, "{seconds} s a sample");
}
