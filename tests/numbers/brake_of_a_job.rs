//! `analyse` and `trajectory` of the brake of a job or a run.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs::{self, File};
use std::process::Stdio;

use crate::common::{Outcome, Place};
use serde_json::Value;

const JOB: &str = "name = \"job\"\n[model.friction]\nlaw = \"rational\"\nstribeck_velocity = 0.5\n[axes]\n\
    rotating_speed = [10.0, 12.0, 20.0]\npreload = [0.1, 0.2]\nstatic_friction = [0.3, 0.4, 0.45, 0.5]\n\
    \"start.velocity\" = [0.1, 0.2]\n[random]\ninputs = [\"static_friction\"]\nrelative_std = 0.1\n\
    [criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\n[sampling]\nsamples = 2\n";

fn place() -> Place {
    let place = Place::new();
    place.write("job.toml", JOB);
    place
}

/// What a command says as JSON.
#[track_caller]
fn json(outcome: Outcome) -> Value {
    serde_json::from_str(&outcome.done().stdout).unwrap()
}

/// Rotating speed, preload and static friction of an analysis.
fn point(analysis: &Value) -> [f64; 3] {
    let of = |key: &str| analysis["parameters"][key].as_f64().unwrap();
    [of("operating_point.rotating_speed"), of("operating_point.preload"), of("friction.static_coefficient")]
}

#[test]
fn a_cell_gives_its_expected_values_and_its_friction_law() {
    let place = place();
    // Static friction varies fastest, then preload, rotating speed and the start.
    for (cell, expected) in
        [(0, [10.0, 0.1, 0.3]), (7, [10.0, 0.2, 0.5]), (9, [12.0, 0.1, 0.4]), (47, [20.0, 0.2, 0.5])]
    {
        let analysis = json(place.run(&format!("analyse --json --job job.toml --cell {cell}")));
        assert_eq!(point(&analysis), expected, "cell {cell}");
        assert_eq!(analysis["parameters"]["friction.stribeck_velocity"], 0.5);
        let [speed, preload, friction] = expected;
        let by_hand = json(place.run(&format!(
            "analyse --json --set friction.law=rational --set friction.stribeck_velocity=0.5 \
             --set operating_point.rotating_speed={speed} --set operating_point.preload={preload} \
             --set friction.static_coefficient={friction}"
        )));
        assert_eq!(analysis["critical_speed_rad_s"], by_hand["critical_speed_rad_s"], "cell {cell}");
    }
}

#[test]
fn without_a_cell_it_is_the_middle_of_the_axes_and_says_so() {
    let place = place();
    let outcome = place.run("analyse --json --job job.toml");
    assert!(
        outcome.stderr.contains("cell 9 of 0 to 47 of the job \"job\", the middle of the axes"),
        "{}",
        outcome.stderr
    );
    assert_eq!(point(&json(outcome)), [12.0, 0.1, 0.4]);
    // Its operating point comes before the middle.
    let point_of_job = "[target]\nprobability = 0.1\nat = { rotating_speed = 20, preload = 0.2, static_friction = 0.3, \"start.velocity\" = 0.1 }\n";
    place.write("asked.toml", &format!("{JOB}{point_of_job}"));
    let outcome = place.run("analyse --json --job asked.toml");
    assert!(outcome.stderr.contains("of the job \"job\", the operating point; choose"), "{}", outcome.stderr);
    assert_eq!(point(&json(outcome)), [20.0, 0.2, 0.3]);
    // A job of one cell has no other.
    place.write("one.toml", "name = \"one\"\n[axes]\npreload = 0.2\n[criterion]\nkind = \"eigenvalue\"\n");
    let outcome = place.run("analyse --json --job one.toml").done();
    assert_eq!(outcome.stderr, "");
    assert_eq!(point(&json(outcome)), [16.0, 0.2, 0.39]);
}

#[test]
fn what_is_set_changes_the_brake_of_the_job() {
    let place = place();
    let analysis = json(place.run("analyse --json --job job.toml --cell 9 --set operating_point.preload=0.3"));
    assert_eq!(point(&analysis), [12.0, 0.3, 0.4]);
    place.run("analyse --job job.toml --cell 0 --set friction.stribeck_exponent=2").refused(
        64,
        &["friction.stribeck_exponent belongs to law = \"stribeck\", but the friction law is \"rational\""],
    );
    let other_law = "--set friction.law=stribeck --set friction.stribeck_exponent=2";
    let analysis = json(place.run(&format!("analyse --json --job job.toml --cell 0 {other_law}")));
    assert_eq!(analysis["parameters"]["friction.stribeck_exponent"], 2.0);
}

#[test]
fn a_trajectory_has_the_disc_and_the_start_of_the_job() {
    let place = place();
    let run = |options: &str| json(place.run(&format!("trajectory --json --horizon 5 --job job.toml {options}")));
    let first = run("--cell 9");
    assert_eq!((&first["disc"], &first["start"]), (&"rigid".into(), &"velocity=0.1".into()));
    assert_eq!(first["rotating_speed_rad_s"], 12.0);
    // The cell decides where the motion starts, and what is typed goes before the job.
    assert_eq!(run("--cell 33")["start"], "velocity=0.2");
    let by_hand = "--set friction.law=rational --set friction.stribeck_velocity=0.5 --set operating_point.rotating_speed=12 \
        --set friction.static_coefficient=0.4 --disc rigid --start velocity=0.1";
    assert_eq!(first, json(place.run(&format!("trajectory --json --horizon 5 {by_hand}"))));
    let other = run("--cell 9 --disc flexible --disc-modes 5 --start rest");
    assert_eq!((&other["disc"], &other["start"]), (&"flexible".into(), &"rest".into()));
}

#[test]
fn a_run_and_standard_input_are_jobs_too() {
    let place = place();
    let of_job = json(place.run("analyse --json --job job.toml --cell 9"));
    place.run("submit job.toml --out run").done();
    assert_eq!(json(place.run("analyse --json --job run --cell 9")), of_job);
    let input = File::open(place.path("job.toml")).unwrap();
    let mut command = place.command("analyse --json --job - --cell 9");
    let output = command.stdin(Stdio::from(input)).output().unwrap();
    assert_eq!(serde_json::from_slice::<Value>(&output.stdout).unwrap(), of_job);

    // A measured curve lies beside the job, wherever the command runs.
    fs::create_dir(place.path("folder")).unwrap();
    place.write("folder/curve.csv", "speed,coefficient\n0,0.45\n0.5,0.3\n2,0.26\n");
    place.write(
        "folder/measured.toml",
        "name = \"m\"\n[model.friction]\nlaw = \"table\"\ntable = \"curve.csv\"\n[criterion]\nkind = \"eigenvalue\"\n",
    );
    let by_job = json(place.run("analyse --json --job folder/measured.toml"));
    let by_hand = json(place.run("analyse --json --set friction.table=folder/curve.csv"));
    assert_eq!(by_job, by_hand);
}

#[test]
fn what_is_no_job_or_no_cell_is_refused() {
    let place = place();
    place.run("analyse --job job.toml --cell 48").refused(64, &["--cell 48: the job \"job\" has cells 0 to 47"]);
    place.run("analyse --cell 3").refused(64, &["--job"]);
    place.run("trajectory --job missing.toml").refused(74, &["missing.toml"]);
    fs::create_dir(place.path("empty")).unwrap();
    place.run("analyse --job empty").refused(74, &["empty is not a run directory"]);
    place.write("wrong.toml", "name = \"wrong\"\n");
    place.run("analyse --job wrong.toml").refused(65, &["there is no [criterion]"]);
    place.run("compare - run").refused(64, &["- is standard input", "stickslip submit - --out RUN_DIR"]);
}
