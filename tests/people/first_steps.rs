//! The first steps of a user: an example job, the list of parameters, and a look at all runs.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{Place, repository, surface_job};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

#[test]
fn the_example_job_is_written_checked_and_run() {
    let place = Place::new();
    let printed = place.run("init").done();
    assert!(printed.stdout.contains("stickslip check job.toml\n  stickslip submit job.toml\n"), "{}", printed.stdout);
    let checked = place.run("check job.toml").done();
    assert!(checked.stdout.contains("# 780 cells: ") && !checked.stderr.contains("warning"), "{checked:?}");
    let run = place.run("submit job.toml --samples 200").done();
    assert!(run.stdout.contains("runs/example/surface.parquet: 780 cells, 200 samples each, seed 1"), "{run:?}");
    // On standard output there is the same text and nothing else.
    assert_eq!(place.run("init -").done().stdout, fs::read_to_string(place.path("job.toml")).unwrap());
}

#[test]
fn an_existing_file_is_never_replaced() {
    let place = Place::new();
    place.write("job.toml", "precious");
    place.run("init").refused(73, &["job.toml exists already", "stickslip init NAME.toml"]);
    assert_eq!(fs::read_to_string(place.path("job.toml")).unwrap(), "precious");
    fs::create_dir(place.path("folder")).unwrap();
    place.run("init folder").refused(73, &["folder is a directory"]);
    place.run("init no/such/folder/job.toml").refused(73, &["no/such/folder"]);
    place.run("init folder/mine.toml").done();
    place.run("check folder/mine.toml").done();
}

#[test]
fn every_parameter_is_listed_with_its_range_and_value() {
    let place = Place::new();
    let text = place.run("parameters").done().stdout;
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    assert!(!text.contains('*'), "{text}");
    let listed = json(&place.run("parameters --json").done().stdout);
    let parameters = listed["parameters"].as_array().unwrap();
    let analysed = json(&place.run("analyse --json").done().stdout);
    assert_eq!(parameters.len(), analysed["parameters"].as_object().unwrap().len());
    let page = fs::read_to_string(repository().join("docs/reference/job-spec.md")).unwrap();
    for parameter in parameters {
        let key = parameter["key"].as_str().unwrap();
        assert_eq!(parameter["value"], analysed["parameters"][key]);
        assert_eq!(parameter["value"], parameter["preset"]);
        let row =
            format!("{key:30} {:6} {:9} ", parameter["symbol"].as_str().unwrap(), parameter["unit"].as_str().unwrap());
        assert!(text.lines().any(|line| line.starts_with(&row)), "{row}\n{text}");
        assert!(page.contains(&format!("| `{key}` |")), "{key}");
    }
    for row in [
        "disc.poissons_ratio            nu     1         0 to <0.5   0.3       Poisson's ratio of the disc",
        "pad.half_angle                 psi    rad       >0 to pi    0.523599  half of the angle that the pad",
        "friction.law                                                stribeck  friction law: stribeck,",
    ] {
        assert!(text.contains(row), "{row}\n{text}");
    }
}

#[test]
fn changed_parameters_are_marked() {
    let place = Place::new();
    place.write("curve.csv", "speed,coefficient\n0,0.45\n1,0.26\n3,0.24\n");
    let set = "parameters --set pad.mass=0.2 --set friction.table=curve.csv";
    let text = place.run(set).done().stdout;
    for row in [
        " 0.2*      mass of the pad\n",
        " table*    friction law:",
        " 3 rows*   measured curve",
        " 0.45*     static friction coefficient\n",
        " 24720     angular stiffness",
        "* not the value of the preset\n",
    ] {
        assert!(text.contains(row), "{row}\n{text}");
    }
    let listed = json(&place.run(&format!("{set} --json")).done().stdout);
    assert_eq!(listed["friction.law"]["value"], "table");
    assert_eq!(listed["friction.table"]["value"]["coefficient"], serde_json::json!([0.45, 0.26, 0.24]));
    let mass =
        listed["parameters"].as_array().unwrap().iter().find(|parameter| parameter["key"] == "pad.mass").unwrap();
    assert_eq!((&mass["value"], &mass["preset"]), (&serde_json::json!(0.2), &serde_json::json!(0.1)));
    place.run("parameters --set pad.mas=0.2").refused(64, &["did you mean `mass`?"]);
    place.run("parameters --set pad.mass=-1").refused(64, &["pad.mass", "greater than 0"]);
}

#[test]
fn a_folder_of_runs_is_one_line_a_run() {
    let place = Place::new();
    for name in ["second", "first"] {
        place.write("job.toml", &surface_job(name, 3, 100, 7));
        place.run("submit job.toml").done();
    }
    place.write("job.toml", &surface_job("third", 3, 100_000, 7));
    place.run("submit job.toml --shard 1/3").done();
    fs::remove_file(place.path("runs/second/surface.parquet")).unwrap();
    fs::create_dir(place.path("runs/pictures")).unwrap();
    place.write("runs/notes.txt", "not a run");
    let printed = place.run("status runs").done().stdout;
    let lines: Vec<&str> = printed.lines().collect();
    assert_eq!(lines.len(), 3, "{printed}");
    assert_eq!(lines[0], "first   finished              100.0 %");
    assert_eq!(lines[1], "second  complete, not merged  100.0 %");
    assert!(lines[2].starts_with("third   unfinished             "), "{printed}");
    let printed = json(&place.run("status runs --json").done().stdout);
    assert_eq!(printed[0], json(&place.run("status runs/first --json").done().stdout));
    let states: Vec<&str> = printed.as_array().unwrap().iter().map(|run| run["state"].as_str().unwrap()).collect();
    assert_eq!(states, ["finished", "complete, not merged", "unfinished"]);

    // One run that cannot be read does not hide the others.
    place.write("runs/first/job.toml", "nonsense");
    let printed = place.run("status runs").done();
    assert!(printed.stdout.starts_with("first   unreadable                  -\nsecond "), "{}", printed.stdout);
    assert!(printed.stderr.contains("warning: runs/first/job.toml was damaged or edited"), "{}", printed.stderr);
    fs::remove_file(place.path("runs/first/job.toml")).unwrap();
    let printed = json(&place.run("status runs --json").done().stdout);
    assert!(
        printed[0]["state"] == "unreadable" && printed[0]["message"].to_string().contains("its job.toml is lost"),
        "{printed}"
    );
    place.run("status runs/pictures").refused(74, &["runs/pictures is not a run directory: it has neither job.toml"]);
    place.run("status .").refused(74, &["is not a run directory"]);
}

#[test]
fn the_summary_of_a_run_is_there_for_programs() {
    let place = Place::new();
    place.write("job.toml", &surface_job("counted", 3, 100, 7));
    let said = json(&place.run("submit job.toml --json").done().stdout);
    let status = json(&place.run("status runs/counted --json").done().stdout);
    for key in ["run", "name", "job_hash", "surface", "cells", "samples_done", "samples_audited"] {
        assert!(!said[key].is_null() && said[key] == status[key], "{key}: {said} {status}");
    }
    let p = crate::common::Table::read(&place.path(said["surface"].as_str().unwrap())).column("p_unstable").to_vec();
    let ends = [p.iter().copied().fold(1.0, f64::min), p.iter().copied().fold(0.0, f64::max)];
    assert_eq!([&said["p_unstable_min"], &said["p_unstable_max"]].map(|end| end.as_f64().unwrap()), ends);
    // The same sentence as in words, and of a finished run again.
    let words = place.run("submit job.toml").done().stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    let answer = said["answer"].as_str().unwrap().split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(answer.starts_with("P, the probability of instability: ") && words.contains(&answer), "{answer}\n{words}");
    assert_eq!(json(&place.run("submit job.toml --json").done().stdout), said);
    assert!(said["decision"].is_null(), "no operating point is asked about: {said}");
    place.run("submit job.toml --json --shard 1/2").refused(64, &["cannot be used with"]);
}

#[test]
fn small_probabilities_and_hidden_slices_are_printed() {
    let place = Place::new();
    let tail = "name = \"tail\"\n[axes]\nrotating_speed = 20.0\npreload = { from = 0.09, to = 0.18, points = 4 }\n\
                static_friction = 0.39\n[random]\ninputs = [\"preload\", \"static_friction\"]\n\
                relative_std = { preload = 0.1, static_friction = 0.08 }\n[criterion]\nkind = \"eigenvalue\"\n\
                [sampling]\nmethod = \"exact\"\n";
    place.write("tail.toml", tail);
    let printed = place.run("submit tail.toml").done().stdout;
    assert!(printed.contains("| 6.0e-8  (6.0e-8 to 6.0e-8)\n"), "{printed}");
    assert!(!printed.contains("0.0000"), "{printed}");
    let columns: Vec<usize> =
        printed.lines().filter_map(|line| line.find(" to ").filter(|_| line.contains("  ("))).collect();
    assert_eq!(columns.len(), 4, "{printed}");

    // Two further axes make the slices.
    let slices = |points: usize| {
        let axes = format!("[axes]\n\"pad.mass\" = {{ from = 0.1, to = 0.2, points = {points} }}");
        let speeds = format!("= {{ from = 10.0, to = 20.0, points = {points} }}");
        place
            .write("slices.toml", &surface_job("slices", 9, 10, 7).replace("[axes]", &axes).replace("= 15.0", &speeds));
        place.run(&format!("submit slices.toml --out {points}")).done().stdout
    };
    let printed = slices(3);
    assert!(
        printed.starts_with("Probability of instability in 9 slices; `stickslip plot` draws them all\n"),
        "{printed}"
    );
    assert!(printed.lines().count() < 20, "{printed}");
    let printed = slices(8);
    assert!(
        printed.starts_with("Probability of instability in 64 slices; `stickslip plot` draws at most 12 at once\n"),
        "{printed}"
    );
    assert!(printed.lines().count() < 24 && printed.contains("\nand 52 further slices\n"), "{printed}");
    // What P is, is said once.
    assert_eq!(printed.matches("P, the probability of instability").count(), 1, "{printed}");
}
