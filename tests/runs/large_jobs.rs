//! Large jobs: the memory that their cells take, and what they are predicted to cost.

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
