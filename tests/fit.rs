//! `stickslip fit`, as typed: what it prints, writes and refuses.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

mod common;

use std::fs;

use common::{Place, Table};
use serde_json::Value;

const VERDICTS: &str = "rotating_speed,preload,squealed,count\n13,0.1,1,39\n13,0.1,0,1\n14,0.1,1,35\n14,0.1,0,5\n\
    15,0.1,1,30\n15,0.1,0,10\n16,0.1,1,19\n16,0.1,0,21\n17,0.1,1,7\n17,0.1,0,33\n18,0.1,1,2\n18,0.1,0,38\n";

const ONSETS: &str = "onset_speed,preload,censored\n15.2,0.1,0\n16.3,0.1,0\n\n14.1,0.1,0\n12,0.1,1\n17.1,0.12,0\n\
    16.8,0.12,0\n15.5,0.12,0\n13.9,0.08,0\n12.6,0.08,0\n12,0.08,1\n";

const RANDOM: &str = "inputs = [\"preload\", \"static_friction\"]\n\
    relative_std = { preload = 0.05, static_friction = 0.1 }";

fn job(random: &str, rest: &str) -> String {
    format!(
        "name = \"tested\"\n\n[axes]\nrotating_speed = [14, 16]\npreload = [0.08, 0.1]\n\n[random]\n{random}\n\n\
        [criterion]\nkind = \"eigenvalue\"\n\n[sampling]\nmethod = \"exact\"\n{rest}"
    )
}

fn place(data: &str) -> Place {
    let place = Place::new();
    place.write("job.toml", &job(RANDOM, ""));
    place.write("data.csv", data);
    place
}

fn json(place: &Place, command: &str) -> Value {
    serde_json::from_str(&place.run(command).done().stdout).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn verdicts_give_estimates_and_a_job_that_has_their_probabilities() {
    let place = place(VERDICTS);
    let said = place.run("fit data.csv --job job.toml --out new.toml").done();
    for text in ["240 tests, 132 of which squealed", "static_friction", "95 % interval", "as in the job", "P(squeal)"] {
        assert!(said.stdout.contains(text), "{text}: {}", said.stdout);
    }
    let found = json(&place, "fit data.csv --job job.toml --json");
    assert_eq!(found["kind"], "verdict");
    let friction = &found["estimates"]["static_friction"];
    assert!((number(&friction["value"]) - 0.4).abs() < 0.01, "{friction}");
    assert!(number(&friction["low"]) < number(&friction["value"]), "{friction}");
    assert!(number(&friction["high"]) > number(&friction["value"]), "{friction}");
    assert_eq!(number(&found["from_job"]["std.preload"]), 0.05);
    let text = fs::read_to_string(place.path("new.toml")).unwrap();
    assert!(
        text.starts_with("# Written by stickslip fit from the tests \"data.csv\" and the job \"job.toml\"."),
        "{text}"
    );
    assert!(text.contains("#   static_friction = 0."), "{text}");
    place.run("check new.toml").done();
    place.run("submit new.toml").done();
    let table = Table::read(&place.path("runs/tested-fitted/surface.parquet"));
    let cells = found["cells"].as_array().unwrap();
    assert_eq!(cells.len(), 4);
    for (row, cell) in cells.iter().enumerate() {
        let [p, low, high] = ["p_squeal", "p_low", "p_high"].map(|key| number(&cell[key]));
        // The job has six digits of each estimate.
        assert!((table.column("p_unstable")[row] - p).abs() < 2e-4, "{cell}");
        assert!(0.0 <= low && low < p && p < high && high <= 1.0, "{cell}");
    }
    place.run("fit data.csv --job job.toml --out new.toml").refused(73, &["new.toml exists already", "--out"]);
}

#[test]
fn the_factor_of_the_preload_moves_the_preloads_of_the_new_job() {
    let place = place(VERDICTS);
    let command = "fit data.csv --job job.toml --estimate preload_factor,std.static_friction";
    let found = json(&place, &format!("{command} --json"));
    let factor = number(&found["estimates"]["preload_factor"]["value"]);
    assert!(factor > 1.0 && factor < 1.5, "{found}");
    place.run(&format!("{command} --out new.toml")).done();
    place.run("submit new.toml").done();
    let table = Table::read(&place.path("runs/tested-fitted/surface.parquet"));
    for (row, cell) in found["cells"].as_array().unwrap().iter().enumerate() {
        assert!((table.column("preload")[row] / (factor * number(&cell["preload"])) - 1.0).abs() < 1e-5, "{cell}");
        assert!((table.column("p_unstable")[row] - number(&cell["p_squeal"])).abs() < 2e-4, "{cell}");
    }
}

#[test]
fn onset_speeds_are_recognised_by_their_column() {
    let place = place(ONSETS);
    let friction_only = "inputs = [\"static_friction\"]\nrelative_std = 0.1";
    place.write("job.toml", &job(friction_only, ""));
    let found = json(&place, "fit data.csv --job job.toml --json");
    assert_eq!(found["kind"], "onset");
    assert_eq!((number(&found["tests"]), number(&found["squealed"])), (10.0, 8.0));
    let friction = number(&found["estimates"]["static_friction"]["value"]);
    assert!((0.36..0.42).contains(&friction), "{friction}");
    // Without the tests that never squealed the brakes seem worse.
    place.write("without.csv", &ONSETS.replace("12,0.1,1\n", "").replace("12,0.08,1\n", ""));
    let without = json(&place, "fit without.csv --job job.toml --json");
    assert!(number(&without["estimates"]["static_friction"]["value"]) > friction, "{without}");
    // A curve that is flat at rest has onset speeds only above its steepest fall.
    let gaussian = job(RANDOM, "").replace("[axes]", "[model.friction]\nstribeck_exponent = 2\n\n[axes]");
    place.write("gaussian.toml", &gaussian);
    place.write("slow.csv", "onset_speed,preload\n9,0.1\n0.5,0.1\n");
    place
        .run("fit slow.csv --job gaussian.toml")
        .refused(65, &["slow.csv:3: onset_speed = 0.5 is not above", "steeply"]);
    let curve = "law = \"table\"\ntable = { speed = [0, 1, 3], coefficient = [0.45, 0.26, 0.24] }";
    place.write("table.toml", &job(RANDOM, "").replace("[axes]", &format!("[model.friction]\n{curve}\n\n[axes]")));
    place.run("fit data.csv --job table.toml").refused(65, &["data.csv:1", "verdicts"]);
}

#[test]
fn rows_that_cannot_be_right_are_refused_with_their_place() {
    let place = place("");
    for (data, texts) in [
        ("", &["data.csv:1", "rotating_speed,preload,squealed,count"][..]),
        ("speed,preload\n1,2\n", &["data.csv:1", "no column rotating_speed or onset_speed"]),
        ("onset_speed;preload\n15;0.1\n", &["data.csv:1", "commas", "it has \"onset_speed;preload\""]),
        (
            "onset_speed,preload\n15,0.1\n15,0.1\n",
            &["scatter no more than", "std.static_friction is 0.0020", "add tests"],
        ),
        ("rotating_speed,onset_speed,preload\n1,1,2\n", &["data.csv:1", "both"]),
        ("rotating_speed,preload,count\n1,0.1,2\n", &["data.csv:1", "no column squealed"]),
        ("rotating_speed,preload,squealed,Count\n1,0.1,1,2\n", &["data.csv:1", "\"Count\""]),
        ("onset_speed,preload,preload\n1,0.1,0.1\n", &["data.csv:1", "two columns are named preload"]),
        ("onset_speed,preload\n12,0.1\n\nfast,0.1\n", &["data.csv:4", "\"fast\" in column onset_speed"]),
        ("onset_speed,preload\n12,0.1\nNaN,0.1\n", &["data.csv:3", "\"NaN\" in column onset_speed"]),
        ("onset_speed,preload\n-12,0.1\n", &["data.csv:2", "onset_speed = -12 is out of range", "rad/s"]),
        ("onset_speed,preload\n12,35000\n", &["data.csv:2", "preload = 35000 is out of range", "at most 1"]),
        ("onset_speed,preload\n12\n", &["data.csv:2", "1 fields"]),
        ("onset_speed,preload,censored\n12,0.1,yes\n", &["data.csv:2", "\"yes\" in column censored", "0 (no)"]),
        ("rotating_speed,preload,squealed\n12,0.1,2\n", &["data.csv:2", "\"2\" in column squealed"]),
        ("rotating_speed,preload,squealed,count\n12,0.1,1,0\n", &["data.csv:2", "\"0\" in column count"]),
        ("rotating_speed,preload,squealed,count\n12,0.1,1,1.5\n", &["data.csv:2", "\"1.5\" in column count"]),
        ("rotating_speed,preload,squealed\n", &["data.csv", "no tests"]),
        ("rotating_speed,preload,squealed\n12,0.1,1\n14,0.1,1\n", &["every test squealed", "higher speeds"]),
        ("rotating_speed,preload,squealed\n12,0.1,1\n14,0.1,0\n", &["separated", "set it in the job"]),
    ] {
        place.write("data.csv", data);
        place.run("fit data.csv --job job.toml").refused(65, texts);
    }
    fs::write(place.path("data.csv"), [0xff, 0xfe, 0x00, b'\n', 0x80]).unwrap();
    place.run("fit data.csv --job job.toml").refused(65, &["data.csv"]);
    place.run("fit none.csv --job job.toml").refused(74, &["cannot read none.csv"]);
}

#[test]
fn jobs_that_do_not_say_enough_are_refused() {
    let place = place(VERDICTS);
    let only_preload = "inputs = [\"preload\"]\nrelative_std = 0.1";
    let third = "inputs = [\"static_friction\", \"pad.mass\"]\nrelative_std = 0.1";
    let several = "inputs = [\"static_friction\"]\nrelative_std = [0.1, 0.2]";
    for (text, options, words) in [
        (job(only_preload, ""), "", "random.inputs does not list static_friction"),
        (job(third, "").replace("\"exact\"", "\"monte-carlo\""), "", "pad.mass"),
        (job(several, ""), "", "random.relative_std lists several values"),
        (
            job(RANDOM, "").replace("preload = [", "static_friction = [0.3, 0.4]\npreload = ["),
            "--estimate std.static_friction",
            "axes.static_friction has several values",
        ),
        (
            job(RANDOM, "").replace("preload = [", "\"pad.mass\" = [0.1, 0.2]\npreload = ["),
            "",
            "axes.pad.mass has several values",
        ),
        (job("inputs = []", ""), "--estimate static_friction", "nothing scatters"),
        (
            job(RANDOM, "").replace("\"eigenvalue\"", "\"coupled-eigenvalue\"").replace("\"exact\"", "\"monte-carlo\""),
            "",
            "criterion.kind = \"eigenvalue\"",
        ),
    ] {
        place.write("other.toml", &text);
        place.run(&format!("fit data.csv --job other.toml {options}")).refused(65, &["other.toml", words]);
    }
    // A redundant set is recognised by its names.
    let all = "--estimate static_friction,preload_factor,std.static_friction";
    place
        .run(&format!("fit data.csv --job job.toml {all}"))
        .refused(65, &["the tests do not determine", "estimate fewer"]);
    place.run("fit data.csv --job job.toml --estimate friction").refused(64, &["static_friction"]);
}

#[test]
fn damaged_data_end_in_a_message_or_a_result() {
    let place = Place::new();
    place.write("job.toml", &job("inputs = [\"static_friction\"]\nrelative_std = 0.1", ""));
    for data in [VERDICTS, ONSETS] {
        for i in 0..24_usize {
            // A byte of the file replaced, at places and by bytes that a multiplication scatters.
            let mut bytes = data.as_bytes().to_vec();
            let length = bytes.len();
            bytes[i * 7919 % length] = [b'0', b'9', b',', b'-', b'e', b'\n', b'"', 0xff][i % 8];
            bytes.truncate(length - i * 31 % 40);
            fs::write(place.path("data.csv"), bytes).unwrap();
            let said = place.run("fit data.csv --job job.toml --json");
            assert!(matches!(said.code, Some(0 | 65)), "{i}: {said:?}");
        }
    }
}

#[test]
fn tests_that_contradict_the_model_are_told() {
    let zigzag = "rotating_speed,preload,squealed,count\n10,0.1,1,400\n12,0.1,1,100\n12,0.1,0,300\n14,0.1,1,348\n14,0.1,0,52\n\
                  16,0.1,1,40\n16,0.1,0,360\n18,0.1,1,200\n18,0.1,0,200\n20,0.1,0,400\n";
    let place = place(zigzag);
    let outcome = place.run("fit data.csv --job job.toml --json").done();
    assert!(outcome.stderr.contains("the tests contradict the model (p = "), "{}", outcome.stderr);
    let found: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert!(number(&found["goodness_of_fit"][0]["p_value"]) < 1e-10, "{found}");
    // A misplaced decimal point in line 3.
    place.write("data.csv", "onset_speed,preload\n15.2,0.1\n163,0.1\n14.1,0.1\n17.1,0.1\n16.8,0.12\n15.5,0.12\n");
    let texts = ["data.csv: the model cannot produce the test of line 3, whose"];
    place.run("fit data.csv --job job.toml").refused(65, &texts);
}
