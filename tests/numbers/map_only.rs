//! Verdict maps that are resolved before the samples, in shares.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use crate::common::{BOTH, EIGENVALUE, Place, Table, job, wait_for};

const FROM_REST: &str = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"";

fn tiles(place: &Place, run: &str) -> usize {
    place.pieces(&format!("{run}/map"))
}

#[test]
fn shares_of_a_map_serve_the_shards_of_the_samples() {
    let place = Place::new();
    let text = job("job", FROM_REST, BOTH, "samples = 20_000\nevaluate = \"boundary\"\naudit = 0.001");
    place.write("job.toml", &text.replace("rotating_speed = 15.0", "rotating_speed = [12.0, 15.0]"));
    place.run("submit job.toml --out whole").done();
    let first = place.run("submit job.toml --out run --map-only --shard 1/2").done();
    assert!(first.stdout.is_empty() && first.stderr.contains("--map-only --shard I/N"), "{}", first.stderr);
    // A share that is there is not resolved again.
    let again = place.run("submit job.toml --out run --map-only --shard 1/2").done();
    assert!(again.stderr.contains(", 0 simulations now"), "{}", again.stderr);
    let second = place.run("submit run/job.toml --out run --map-only --shard 2/2").done();
    assert!(second.stderr.contains("the verdict map is complete"), "{}", second.stderr);
    assert!(second.stderr.contains("submit run/job.toml --out run --shard I/N"), "{}", second.stderr);
    assert!(!second.stderr.contains(", 0 simulations now"), "{}", second.stderr);
    for shard in 1..=2 {
        let shard = place.run(&format!("submit job.toml --out run --shard {shard}/2")).done();
        assert!(shard.stderr.contains(", 0 of them new"), "{}", shard.stderr);
    }
    place.run("merge run").done();
    assert!(place.surface("run") == place.surface("whole"));
    // As a whole, and then the samples in one process.
    place.run("submit job.toml --out alone --map-only --threads 1").done();
    let resumed = place.run("resume alone").done();
    assert!(resumed.stderr.contains(", 0 of them new"), "{}", resumed.stderr);
    assert!(place.surface("alone") == place.surface("whole"));
}

#[test]
fn a_map_that_is_integrated_over_is_resolved_in_shares() {
    let place = Place::new();
    place.write("job.toml", &job("job", FROM_REST, BOTH, "method = \"exact\""));
    place.run("submit job.toml --out whole").done();
    for shard in 0..3 {
        place.run(&format!("submit job.toml --out run --map-only --shard {shard}/3")).done();
    }
    let resumed = place.run("resume run").done();
    assert!(resumed.stderr.contains(", 0 of them new"), "{}", resumed.stderr);
    assert!(place.surface("run") == place.surface("whole"));
}

/// A map is made as it is asked for, also where its simulations are more than the samples. `check` says both costs before.
#[test]
fn a_map_for_few_samples_is_resolved_as_well() {
    let place = Place::new();
    let text = job("job", FROM_REST, BOTH, "samples = 40\nevaluate = \"boundary\"\naudit = 2");
    place.write("job.toml", &text);
    let checked = place.run("check job.toml").done().stdout;
    for words in ["for the verdict map of ", "60 simulations for its audit", "if each is simulated: 1,200 samples"] {
        assert!(checked.contains(words), "{words}: {checked}");
    }
    let said = place.run("submit job.toml --out map").done().stderr;
    assert!(said.contains("verdict map: ") && tiles(&place, "map") > 0, "{said}");
    place.write("each.toml", &text.replace("evaluate = \"boundary\"\naudit = 2", ""));
    place.run("submit each.toml --out each").done();
    let [map, each] = ["map", "each"].map(|run| Table::read(&place.path(&format!("{run}/surface.parquet"))));
    assert_eq!(map.column("p_unstable"), each.column("p_unstable"));
    assert!(map.column("n_simulated").iter().sum::<f64>() < 600.0, "looked up");
}

#[test]
fn a_job_without_a_map_has_none_to_resolve() {
    let place = Place::new();
    place.write("job.toml", &job("job", EIGENVALUE, BOTH, "samples = 100\nevaluate = \"boundary\""));
    place.run("submit job.toml --out run --map-only").refused(64, &["--map-only", "uses no verdict map"]);
    assert!(!place.path("run").exists());
}

/// The simulations that a command says it made.
fn simulations(said: &str) -> u64 {
    let digits = said[..said.find(" simulations now").unwrap()].rsplit(' ').next().unwrap().replace(',', "");
    digits.parse().unwrap()
}

#[test]
fn tiles_are_kept_while_others_go_on_arriving() {
    let place = Place::new();
    let speeds = "rotating_speed = { from = 10.0, to = 20.0, points = 4 }";
    let text = job("job", FROM_REST, BOTH, "samples = 1_000_000\nevaluate = \"boundary\"");
    place.write("job.toml", &text.replace("rotating_speed = 15.0", speeds));
    let mut child = place.command("submit job.toml --out run --map-only").spawn().unwrap();
    wait_for("a tile", &mut child, || tiles(&place, "run") > 0);
    child.kill().unwrap();
    child.wait().unwrap();
    let said = place.run("submit job.toml --out run --map-only").done().stderr;
    let whole = place.run("submit job.toml --out whole --map-only").done().stderr;
    assert!(simulations(&said) < simulations(&whole), "{said}{whole}");
}
