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

/// The keys that the example shows as comments: section, key, and the line without its comment sign.
fn shown_keys(example: &str) -> Vec<(String, String, String)> {
    let mut section = String::new();
    let mut shown = Vec::new();
    for line in example.lines() {
        if line.starts_with('[') {
            line.trim_matches(['[', ']']).clone_into(&mut section);
        } else if let Some(line) = line.strip_prefix("# ")
            && line.parse::<toml::Table>().is_ok_and(|table| !table.is_empty())
        {
            let (key, _) = line.split_once(" = ").unwrap();
            shown.push((section.clone(), key.to_owned(), line.to_owned()));
        }
    }
    shown
}

/// The example with one of its comments turned into a key, in place of the same key where that is set.
fn uncommented(example: &str, section: &str, key: &str, shown: &str) -> String {
    let mut within = String::new();
    let mut lines = Vec::new();
    for line in example.lines() {
        if line.starts_with('[') {
            line.trim_matches(['[', ']']).clone_into(&mut within);
        }
        let is_rival = within == section && line.starts_with(&format!("{key} = "));
        match line.strip_prefix("# ") {
            Some(bare) if within == section && bare == shown => lines.push(bare),
            _ if is_rival => {}
            _ => lines.push(line),
        }
    }
    lines.join("\n") + "\n"
}

#[test]
fn every_key_that_the_example_shows_is_accepted() {
    let place = Place::new();
    // A small grid, as the cost is measured each time.
    let example =
        place.run("init -").done().stdout.replace("points = 30", "points = 3").replace("points = 26", "points = 3");
    let shown = shown_keys(&example);
    let count = |wanted: &str| shown.iter().filter(|(section, ..)| section == wanted).count();
    assert!(count("model") >= 20 && count("sampling") >= 10, "{shown:?}");
    assert!(count("axes") >= 3 && count("random") >= 7 && count("criterion") >= 9, "{shown:?}");
    let body = |text: &str| text.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
    place.write("job.toml", &example);
    let plain = body(&place.run("check --all job.toml --threads 1").done().stdout);
    for (section, key, line) in &shown {
        let mut job = uncommented(&example, section, key, line);
        // What the comment beside the key says of other keys.
        let (from, to) = match (section.as_str(), key.as_str()) {
            ("criterion", "disc_modes") => ("kind = \"eigenvalue\"", "kind = \"coupled-eigenvalue\""),
            ("criterion", "disc") => ("kind = \"eigenvalue\"", "kind = \"time-domain\""),
            ("criterion", "start" | "displacement" | "horizon" | "record") => {
                ("kind = \"eigenvalue\"", "kind = \"time-domain\"\ndisc = \"rigid\"")
            }
            ("axes", "preload_force") => ("\npreload = ", "\n# preload = "),
            ("sampling", "until") => ("\nsamples = 10_000", "\n"),
            ("sampling", "method") if line.contains("exact") => ("\nsamples = 10_000", "\n"),
            ("sampling", "randomisations") => ("\nsamples = 10_000", "\nmethod = \"sobol\"\nsamples = 10_000"),
            ("random", "distribution") if line.contains("measured") => {
                ("\nrelative_std = 0.2", "\nrelative_std = { static_friction = 0.2 }")
            }
            _ => ("", ""),
        };
        assert!(job.contains(from), "{line}");
        job = job.replacen(from, to, 1);
        place.write("job.toml", &job);
        let checked = place.run("check --all job.toml --threads 1");
        assert_eq!(checked.code, Some(0), "{line}\n{}", checked.stderr);
        assert!(!checked.stderr.contains("warning"), "{line}\n{}", checked.stderr);
        // The values of the brake that are shown are those of the preset. One of them is not listed unless it is given, as
        // it follows another.
        let listed = body(&checked.stdout).replace("effective_radius = 0.135\n", "");
        assert!(section != "model" || listed == plain, "{line}");
    }
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
    assert_eq!(printed.matches("P is the probability of instability").count(), 1, "{printed}");
}
