//! The table `[limit]` of a job, and limits.parquet in a run.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{EIGENVALUE, Place, Table};
use serde_json::Value;

const SAMPLES: &str = "samples = 4000\nseed = 3";
const EXACT: &str = "method = \"exact\"";
const LIMIT: &str = "[limit]\nof = \"preload\"\nprobability = [0.01, 0.2]\n";

fn job(sampling: &str, limit: &str) -> String {
    format!(
        "name = \"limits\"\n[axes]\nrotating_speed = [12.0, 15.0]\npreload = [0.01, 0.3]\nstatic_friction = 0.39\n[random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = {{ preload = 0.2, static_friction = 0.1 }}\n[criterion]\n{EIGENVALUE}\n[sampling]\n{sampling}\n{limit}"
    )
}

fn bytes(place: &Place, name: &str) -> Vec<u8> {
    fs::read(place.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

#[test]
fn the_command_takes_the_table_and_options_win_over_it() {
    let place = Place::new();
    place.write("job.toml", &job(EXACT, LIMIT));
    let limits = |options: &str| {
        let outcome = place.run(&format!("limit job.toml --json {options}")).done();
        let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
        let of = found["of"].as_str().unwrap().to_owned();
        let targets = found["limits"].as_array().unwrap().iter().map(|row| row["target"].as_f64().unwrap()).collect();
        (of, targets)
    };
    let preload = || "preload".to_owned();
    assert_eq!(limits(""), (preload(), vec![0.01, 0.2, 0.01, 0.2]));
    assert_eq!(limits("--probability 0.3"), (preload(), vec![0.3, 0.3]));
    assert_eq!(limits("--of rotating_speed").0, "rotating_speed");
    place.write("job.toml", &job(EXACT, &LIMIT.replace("[0.01, 0.2]", "0.05")));
    assert_eq!(limits("").1, [0.05, 0.05]);
}

#[test]
fn a_run_has_the_file_that_the_command_writes_and_the_surface_that_it_has_without() {
    for sampling in [EXACT, SAMPLES] {
        let place = Place::new();
        place.write("with.toml", &job(sampling, LIMIT));
        place.write("without.toml", &job(sampling, ""));
        let said = place.run("submit with.toml --out with --threads 1").done().stdout;
        assert!(said.contains("with/limits.parquet: limits of preload at P = 0.01, 0.2"), "{said}");
        let said = place.run("submit without.toml --out without").done().stdout;
        assert!(!said.contains("limits"), "{said}");
        assert!(!place.path("without/limits.parquet").exists());
        assert!(bytes(&place, "with/surface.parquet") == bytes(&place, "without/surface.parquet"));
        place.run("limit with.toml --out limits.parquet --threads 2").done();
        let written = bytes(&place, "with/limits.parquet");
        assert!(written == bytes(&place, "limits.parquet"), "whatever the threads");
        let table = Table::read(&place.path("limits.parquet"));
        assert_eq!(table.column("target"), [0.01, 0.2, 0.01, 0.2]);
        let digests = fs::read_to_string(place.path("with/digests.json")).unwrap();
        assert!(digests.contains("\"limits.parquet\""), "{digests}");
        // The job may be submitted again with other limits, and keeps them.
        place.write("without.toml", &job(sampling, &LIMIT.replace("0.2]", "0.3]  # more")));
        for command in ["submit without.toml --out with", "resume with"] {
            let said = place.run(command).done().stdout;
            assert!(said.contains("limits of preload at P = 0.01, 0.3"), "{said}");
            assert_eq!(Table::read(&place.path("with/limits.parquet")).column("target")[1], 0.3);
            assert!(fs::read_to_string(place.path("with/job.toml")).unwrap().contains("0.3]  # more"));
            assert!(bytes(&place, "with/surface.parquet") == bytes(&place, "without/surface.parquet"));
        }
        place.run("submit with.toml --out with").done();
        assert!(written == bytes(&place, "with/limits.parquet"));
        // Without the table the run keeps its own.
        place.write("without.toml", &job(sampling, ""));
        place.run("submit without.toml --out with").done();
        assert!(written == bytes(&place, "with/limits.parquet"));
    }
}

#[test]
fn lost_and_damaged_limits_are_found_and_written_again() {
    let place = Place::new();
    place.write("job.toml", &job(SAMPLES, LIMIT));
    place.run("submit job.toml --out run").done();
    let limits = place.path("run/limits.parquet");
    let sound = fs::read(&limits).unwrap();
    assert!(place.run("verify run").done().stdout.contains("limits.parquet: sound"));
    let mut damaged = sound.clone();
    damaged[sound.len() / 2] ^= 1;
    fs::write(&limits, &damaged).unwrap();
    place.run("verify run").refused(74, &["damaged: limits.parquet", "stickslip resume run"]);
    assert!(place.path("run/limits.parquet.damaged").exists());
    assert!(place.run("verify run").done().stdout.contains("limits.parquet: not written yet"));
    place.run("resume run").done();
    assert!(fs::read(&limits).unwrap() == sound);
    fs::write(&limits, &damaged).unwrap();
    place.run("resume run").done();
    assert!(fs::read(&limits).unwrap() == sound);
    fs::remove_file(&limits).unwrap();
    place.run("submit job.toml --out run").done();
    assert!(fs::read(&limits).unwrap() == sound);
    // Those of fewer samples are not those of the job any more.
    place.run("submit job.toml --out run --samples 8000").done();
    let more = fs::read(&limits).unwrap();
    assert!(more != sound);
    fs::write(&limits, &sound).unwrap();
    fs::remove_file(place.path("run/digests.json")).unwrap();
    assert!(place.run("verify run").done().stdout.contains("limits.parquet: those of the run before"));
    place.run("resume run").done();
    assert!(fs::read(&limits).unwrap() == more);
}

#[test]
fn a_job_that_is_written_again_has_its_limits_or_it_is_said_that_they_are_lost() {
    let place = Place::new();
    place.write("job.toml", &job(SAMPLES, LIMIT));
    place.run("submit job.toml --out run").done();
    let (path, limits) = (place.path("run/job.toml"), place.path("run/limits.parquet"));
    let sound = fs::read(&limits).unwrap();
    let damage = || fs::write(&path, fs::read_to_string(&path).unwrap().replacen("seed = 3", "seed = 4", 1)).unwrap();
    for is_lost in [false, true] {
        if is_lost {
            fs::remove_file(&path).unwrap();
        } else {
            damage();
        }
        let verified = place.run("verify run").done().stdout;
        let written = "the surface holds what it was, and it is written again\n";
        assert!(verified.contains(written) && verified.contains("limits.parquet: sound"), "{verified}");
        let said = place.run("resume run").done().stdout;
        assert!(said.contains("limits of preload at P = 0.01, 0.2"), "{said}");
        assert!(fs::read(&limits).unwrap() == sound);
    }
    // Without limits nothing says what they were of.
    fs::remove_file(&limits).unwrap();
    damage();
    let verified = place.run("verify run").refused(74, &["damaged: job.toml", "remove run/job.toml", "`--out run`"]);
    assert!(verified.stdout.contains("the surface holds what it was, but for [limit]"), "{}", verified.stdout);
    assert!(fs::read_to_string(place.path("run/job.toml.damaged")).unwrap().contains("[limit]"));
    assert!(!fs::read_to_string(&path).unwrap().contains("[limit]"));
    fs::remove_file(&path).unwrap();
    place.run("submit job.toml --out run").done();
    assert!(fs::read(&limits).unwrap() == sound);
    place.run("verify run").done();
}

/// Whatever is left of the text of the job: that it asked for something is known by digests.
#[test]
fn a_job_that_is_written_again_without_what_it_asked_is_never_called_mended() {
    let place = Place::new();
    let path = place.path("run/job.toml");
    let target = "[target]\nprobability = 0.01\n";
    let asking = [(LIMIT.to_owned(), "[limit]"), (target.to_owned(), "[target]")];
    let both = (format!("{LIMIT}{target}"), "[limit] and [target]");
    for (tables, lacking) in asking.into_iter().chain([both]) {
        place.write("job.toml", &job(SAMPLES, &tables));
        place.run("submit job.toml --out run --overwrite").done();
        let text = fs::read_to_string(&path).unwrap();
        for left in [Some(&text[..text.len() / 3]), Some("no job"), Some(""), None] {
            match left {
                Some(left) => fs::write(&path, left).unwrap(),
                None => fs::remove_file(&path).unwrap(),
            }
            if lacking.contains("[limit]") {
                fs::write(place.path("run/limits.parquet"), "damaged").unwrap();
            }
            let verified = place.run("verify run").refused(74, &["damaged: job.toml", "`--out run`"]);
            let said = format!("the surface holds what it was, but for {lacking}, and it is written again\n");
            assert!(verified.stdout.contains(&said), "{lacking} {left:?}: {}", verified.stdout);
            // It is not forgotten.
            for _ in 0..2 {
                let again = place.run("verify run").refused(74, &["damaged: job.toml", "`--out run`"]);
                let said = format!("job.toml: it was written again without {lacking}\n");
                assert!(again.stdout.contains(&said), "{}", again.stdout);
            }
            if let Some(left) = left {
                assert_eq!(fs::read_to_string(place.path("run/job.toml.damaged")).unwrap(), left);
                fs::remove_file(place.path("run/job.toml.damaged")).unwrap();
            }
            fs::remove_file(&path).unwrap();
            place.run("submit job.toml --out run").done();
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
            place.run("verify run").done();
        }
    }
    // What options ask is not in the job.
    place.write("job.toml", &job(SAMPLES, target));
    place.run("submit job.toml --out run --overwrite --target 0.3 --at preload=0.3 --at rotating_speed=15").done();
    place.run("verify run").done();
    place.run("resume run --target 0.2").done();
    place.run("verify run").done();
    // Digests of an earlier version, or none, do not say what was asked.
    place.write("job.toml", &job(SAMPLES, ""));
    place.run("submit job.toml --out run --overwrite").done();
    fs::write(&path, "no job").unwrap();
    fs::remove_file(place.path("run/digests.json")).unwrap();
    let verified = place.run("verify run").refused(74, &["damaged: job.toml"]);
    let said = "but for [limit] if it had one and [target] if it had one";
    assert!(verified.stdout.contains(said), "{}", verified.stdout);
}

#[test]
fn shards_leave_the_limits_to_merge() {
    let place = Place::new();
    place.write("job.toml", &job(SAMPLES, LIMIT));
    place.run("submit job.toml --out run --shard 1/2").done();
    place.run("submit job.toml --out run --shard 2/2").done();
    assert!(!place.path("run/limits.parquet").exists());
    let said = place.run("merge run").done().stdout;
    assert!(said.contains("run/limits.parquet: limits of preload at P = 0.01, 0.2"), "{said}");
    place.run("submit job.toml --out whole").done();
    for name in ["surface.parquet", "limits.parquet"] {
        assert!(bytes(&place, &format!("run/{name}")) == bytes(&place, &format!("whole/{name}")), "{name}");
    }
}

#[test]
fn what_is_wrong_with_the_table_is_reported_with_its_line() {
    let place = Place::new();
    let refused = |sampling: &str, limit: &str, line: usize, texts: &[&str]| {
        let text = job(sampling, limit);
        let first = text.lines().position(|line| line == "[limit]").unwrap();
        place.write("job.toml", &text);
        let place_of_it = format!("job.toml:{}:", first + line);
        let texts: Vec<&str> = texts.iter().copied().chain([&*place_of_it]).collect();
        let outcome = place.run("submit job.toml").refused(65, &texts);
        assert_eq!(outcome.stderr.matches("job.toml:").count(), 1, "{}", outcome.stderr);
        assert!(!place.path("runs").exists());
    };
    let table = |of: &str, probability: &str| format!("[limit]\nof = {of}\nprobability = {probability}\n");
    for value in ["0", "1", "1.5", "-0.1", "nan", "[0.01, 1]", "[0.01, 0.0]"] {
        let texts = ["limit.probability = ", "greater than 0 and less than 1", "0.01 for 1 %"];
        refused(EXACT, &table("\"preload\"", value), 3, &texts);
    }
    refused(EXACT, &table("\"preload\"", "[]"), 3, &["limit.probability is empty", "[0.01, 1e-5]"]);
    refused(EXACT, &table("\"preload\"", "[0.1, 0.2, 0.1]"), 3, &["0.1 twice"]);
    for value in ["\"x\"", "true", "{ a = 1 }", "[\"x\"]"] {
        refused(EXACT, &table("\"preload\"", value), 3, &["limit.probability"]);
    }
    refused(EXACT, &table("3", "0.01"), 2, &["limit.of", "a text in quotes"]);
    refused(EXACT, &table("\"prelaod\"", "0.01"), 2, &["limit.of = \"prelaod\"", "did you mean preload?"]);
    refused(EXACT, &table("\"static_friction\"", "0.01"), 2, &["one value, 0.39", "two or more"]);
    refused(EXACT, &table("\"pad.mass\"", "0.01"), 2, &["has no such axis", "[axes]"]);
    refused("until = { half_width = 0.01 }", LIMIT, 2, &["limit.of", "sampling.samples in place of sampling.until"]);
    refused(EXACT, "[limit]\nprobability = 0.1\n", 1, &["missing key `of` in [limit]", "of = \"AXIS\""]);
    refused(EXACT, "[limit]\nof = \"preload\"\n", 1, &["missing key `probability` in [limit]"]);
    refused(
        EXACT,
        "[limit]\nof = \"preload\"\nprobability = 0.1\nconfidence = 0.9\n",
        4,
        &["confidence", "[sampling]"],
    );
}
