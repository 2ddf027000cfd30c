//! Large jobs: the memory that their cells take, and what many shards of them are predicted to cost.

mod common;

#[cfg(target_os = "linux")]
use std::process::Command;

use common::{Place, surface_job};
use serde_json::Value;

/// A job of as many cells as there may be.
#[cfg(target_os = "linux")]
fn million_cells() -> Place {
    let place = Place::new();
    place.write("job.toml", &surface_job("large", 1000, 2, 1));
    place
}

/// Runs a command with so many KiB of memory for its data, and asserts its exit code.
#[cfg(target_os = "linux")]
#[track_caller]
fn with_memory(place: &Place, kib: u32, words: &str, code: i32) {
    let mut command = Command::new("sh");
    command.args(["-c", &format!("ulimit -d {kib} && exec {} {words}", env!("CARGO_BIN_EXE_stickslip"))]);
    let output = command.current_dir(place.path("")).output().unwrap();
    assert_eq!(output.status.code(), Some(code), "{words}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
#[cfg(target_os = "linux")]
fn a_shard_of_a_million_cells_takes_little_memory() {
    let place = million_cells();
    with_memory(&place, 98_304, "submit job.toml --out run --threads 1 --shard 1/1000", 0);
    // What is there is read, also if it is not complete.
    with_memory(&place, 98_304, "merge run", 65);
    place.run("merge run").refused(65, &["1000 of 1000000 cells"]);
}

#[test]
fn check_predicts_the_times_of_shards_and_merge() {
    let place = Place::new();
    place.write("job.toml", &surface_job("job", 20, 3000, 1));
    let checked = place.run("check job.toml --nodes 4 --threads 2 --json").done();
    let told: Value = serde_json::from_str(&checked.stdout).unwrap();
    assert_eq!((&told["cells"], &told["samples_at_most"]), (&Value::from(400), &Value::from(1_200_000)));
    let cluster = &told["cluster"];
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
    assert_eq!(cluster["best"]["shards"], 1, "a second of work is not worth more: {cluster:#}");

    let text = place.run("check job.toml --nodes 4 --threads 2").done().stdout;
    for part in ["# on 4 nodes with 2 threads each, in 1 shard: about", "# 1000  ", "merge"] {
        let part = part.replace("# 1000", "#     1000");
        assert!(text.contains(&part), "{part:?} is not in {text}");
    }
    assert!(!place.run("check job.toml").done().stdout.contains("nodes"));
    place.run("check job.toml --nodes 0").refused(64, &["--nodes"]);
}

#[test]
fn integrals_are_not_shared_among_nodes() {
    let place = Place::new();
    let job = surface_job("job", 3, 10, 1).replace("samples = 10", "method = \"exact\"");
    place.write("job.toml", &job);
    let text = place.run("check job.toml --nodes 4").done().stdout;
    assert!(text.contains("method = \"exact\" draws no samples that nodes could share"), "{text}");
    let told: Value = serde_json::from_str(&place.run("check job.toml --nodes 4 --json").done().stdout).unwrap();
    assert!(told["cluster"].is_null() && told["load"].is_null(), "{told:#}");
}
