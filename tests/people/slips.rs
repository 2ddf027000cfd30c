//! Slips that people make at first, and that each is answered once, where it is, with what is right.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use crate::common::{Outcome, Place, surface_job};

/// A job of a model given by matrices.
const OF_MATRICES: &str = r#"name = "brake"

[model]
kind = "matrices"
mass = { matrix = [[1, 0], [0, 1]] }
stiffness = [
    { matrix = [[2, 1], [1, 2]] },
    { matrix = [[0, -1], [0, 0]], factor = "friction" },
]

[model.parameters]
friction = 0.7

[random]
inputs = ["friction"]
relative_std = 0.1

[criterion]
kind = "complex-eigenvalue"
frequency = [0.0, 10.0]

[sampling]
samples = 100
"#;

/// The job with a change.
#[track_caller]
fn with(from: &str, to: &str) -> String {
    assert!(OF_MATRICES.contains(from), "{from}");
    OF_MATRICES.replacen(from, to, 1)
}

/// What `check` says of a job that is refused with one message.
#[track_caller]
fn refused_once(text: &str, texts: &[&str]) -> Outcome {
    let place = Place::new();
    place.write("job.toml", text);
    let outcome = place.run("check job.toml").refused(65, texts);
    assert_eq!(outcome.stderr.matches("job.toml").count(), 1, "{}", outcome.stderr);
    outcome
}

#[test]
fn a_forgotten_kind_of_model_is_one_message() {
    refused_once(
        &with("kind = \"matrices\"\n", ""),
        &["job.toml:3:2: missing key `kind` in [model]", "write kind = \"matrices\""],
    );
}

#[test]
fn a_criterion_of_another_kind_of_model_is_named_as_such() {
    let said = refused_once(
        &surface_job("pad", 2, 100, 7).replace("\"eigenvalue\"", "\"complex-eigenvalue\""),
        &["decides models of kind \"matrices\"", "this one is of kind \"pad-on-disc\"", "\"coupled-eigenvalue\""],
    );
    assert!(!said.stderr.contains("did you mean"), "{}", said.stderr);
    refused_once(
        &with("\"complex-eigenvalue\"", "\"eigenvalue\""),
        &["job.toml:19:8", "decides models of kind \"pad-on-disc\"", "of this kind: \"complex-eigenvalue\""],
    );
}

#[test]
fn a_matrix_shows_how_it_is_written() {
    let form = "it must be a matrix as { file = \"brake.mat\", matrix = \"K\", factor = \"friction\" }";
    refused_once(
        &with("{ matrix = [[1, 0], [0, 1]] }", "\"M.mtx\""),
        &["job.toml:5:8: model.mass is the string \"M.mtx\"", form, "; write { file = \"M.mtx\" }"],
    );
    refused_once(
        &with("{ matrix = [[1, 0], [0, 1]] }", "[[1, 0], [0, 1]]"),
        &["job.toml:5:8: model.mass is a list", "or { matrix = [[2, -1], [-1, 2]] }"],
    );
    refused_once(
        &with("{ matrix = [[2, 1], [1, 2]] }", "\"K.mtx\""),
        &["an element of model.stiffness is the string \"K.mtx\"", "; write { file = \"K.mtx\" }"],
    );
    refused_once(&with("friction = 0.7", "friction = \"high\""), &["job.toml:12:", "it must be a number, or a table"]);
}

#[test]
fn a_missing_file_of_matrices_is_reported_once_at_its_line() {
    let missing = with("{ matrix = [[2, 1], [1, 2]] }", "{ file = \"K.mtx\" }")
        .replace("{ matrix = [[0, -1], [0, 0]], factor", "{ file = \"K.mtx\", factor");
    refused_once(&missing, &["job.toml:7:14: model.stiffness[0]: K.mtx", "No such file"]);
    let single = "name = \"one\"\n[model]\nkind = \"matrices\"\nmass = { matrix = [[1]] }\n\
        damping = { matrix = [[1, 2]] }\nstiffness = { file = \"K.mtx\" }\n\
        [criterion]\nkind = \"complex-eigenvalue\"\n";
    let place = Place::new();
    place.write("job.toml", single);
    let said = place.run("check job.toml").refused(65, &["No such file"]).stderr;
    assert!(
        said.contains("job.toml:5:22: model.damping[0]") && said.contains("job.toml:6:22: model.stiffness[0]"),
        "{said}"
    );
}

#[test]
fn a_unit_behind_a_number_is_converted() {
    let job = surface_job("units", 2, 100, 7);
    let speed = |value: &str| job.replace("rotating_speed = 15.0", &format!("rotating_speed = {value}"));
    for value in ["\"120 rpm\"", "[10.0, \"120 rpm\"]"] {
        refused_once(&speed(value), &["axes.rotating_speed", "120 rpm has a unit", "120 rpm = 12.5663706 rad/s"]);
    }
    let said = refused_once(
        &with("friction = 0.7", "friction = \"700 mm\""),
        &["model.parameters.friction: 700 mm has a unit; ", "in the unit of the parameter; 700 mm = 0.7 m"],
    );
    assert!(!said.stderr.contains("stickslip parameters"), "it lists the pad alone: {}", said.stderr);
}

#[test]
fn a_standard_deviation_in_per_cent_is_asked_about() {
    let of_pad = surface_job("scatter", 2, 100, 7).replace(", \"static_friction\"]", "]");
    for (job, said) in [
        (of_pad.replace("relative_std = 0.2", "relative_std = 2"), "did you mean 0.02 (2 %)?"),
        (with("relative_std = 0.1", "relative_std = 15"), "did you mean 0.15 (15 %)?"),
    ] {
        refused_once(&job, &["random.relative_std", said]);
    }
}

#[test]
fn words_that_people_try_as_commands_name_the_command() {
    let place = Place::new();
    place.run("run job.toml").refused(64, &["there is no command `run`", "`stickslip submit JOB.toml` runs a job"]);
    place.run("list").refused(64, &["`stickslip status` shows"]);
    let said = place.run("--messages json start job.toml").refused(64, &[]).stderr;
    let said: serde_json::Value = serde_json::from_str(&said).unwrap();
    assert_eq!((&said["code"], &said["remedy"]), (&"usage".into(), &"stickslip submit JOB.toml".into()));
    for threads in ["two", "0", "1025", "-1", "1.5"] {
        place
            .run(&format!("submit job.toml --threads {threads}"))
            .refused(64, &["a number of threads is a whole number from 1 to 1024"]);
    }
}

#[test]
fn a_run_and_a_shipped_job_that_is_not_there_say_how_to_go_on() {
    let place = Place::new();
    place.write("job.toml", &surface_job("mine", 2, 100, 7));
    place.run("submit job.toml").done();
    for command in ["submit", "check"] {
        place
            .run(&format!("{command} runs/mine"))
            .refused(74, &["cannot read runs/mine: ", "runs/mine/job.toml is the job", "`stickslip resume runs/mine`"]);
        for name in ["jobs/fig14a.toml", "fig14a.toml", "fig14a"] {
            place.run(&format!("{command} {name}")).refused(
                74,
                &[&format!("cannot read {name}: "), "fig14a comes with", "`stickslip init --from fig14a`"],
            );
        }
    }
    let other = place.run("submit missing.toml").refused(74, &["cannot read missing.toml"]).stderr;
    assert!(!other.contains("comes with"), "{other}");
}

#[test]
fn the_jobs_that_come_with_the_program_are_listed_and_completed() {
    let place = Place::new();
    let listed = place.run("init --list").done().stdout;
    assert!(listed.lines().count() > 15 && listed.contains("\nmission "), "{listed}");
    assert!(listed.lines().all(|line| line.split_once("  ").is_some_and(|(_, what)| what.len() > 10)), "{listed}");
    for shell in ["bash", "fish", "zsh"] {
        let script = place.run(&format!("completions {shell}")).done().stdout;
        assert!(script.contains("measured-friction") && script.contains("own-brake"), "{shell}");
    }
    place.run("init --list --from fig4").refused(64, &["cannot be used with"]);
}
