//! `--messages json`: each kind of failure is one object, which says what text mode says, and nothing else is on standard
//! error.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs::{self, File};
use std::io::{BufRead as _, BufReader, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::process::Stdio;
use std::time::Instant;

use crate::common::{Place, send, surface_job, wait_for, with_default_signals};
use serde_json::{Value, json};

/// The objects on standard error; every line is one.
#[track_caller]
fn objects(stderr: &str) -> Vec<Value> {
    let read = |line: &str| serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"));
    let objects: Vec<Value> = stderr.lines().map(read).collect();
    assert!(objects.iter().all(|object| object["code"].is_string() && object["text"].is_string()), "{stderr}");
    objects
}

/// What text mode says of the same: progress is not compared, as its figures are those of a moment.
fn as_text(objects: &[Value]) -> String {
    let line = |object: &Value| {
        let (code, text) = (object["code"].as_str().unwrap(), object["text"].as_str().unwrap());
        format!("stickslip: {}{text}\n", if code == "warning" { "warning: " } else { "" })
    };
    objects.iter().filter(|object| object["code"] != "progress").map(line).collect()
}

/// Runs a command that fails in the same way in both modes, and returns the object of the failure.
#[track_caller]
fn failure(place: &Place, words: &str, exit: i32) -> Value {
    let [text, json] = [words.to_owned(), format!("--messages json {words}")].map(|words| place.run(&words));
    assert_eq!((text.code, json.code), (Some(exit), Some(exit)), "{}\n{}", text.stderr, json.stderr);
    assert_eq!(text.stdout, json.stdout);
    let objects = objects(&json.stderr);
    assert_eq!(as_text(&objects), text.stderr);
    objects.last().unwrap().clone()
}

/// The object without its text.
fn without_text(mut object: Value) -> Value {
    object.as_object_mut().unwrap().remove("text");
    object
}

#[test]
fn errors_of_the_command_line_are_objects() {
    let place = Place::new();
    for words in ["submit", "submit x --threads 0", "nonsense", "status --json=3 x", ""] {
        let text = place.run(&format!("{words} --messages=text"));
        let json = place.run(&format!("{words} --messages=json"));
        assert_eq!((text.code, json.code), (Some(64), Some(64)), "{}", json.stderr);
        let [object] = &objects(&json.stderr)[..] else { panic!("{}", json.stderr) };
        assert_eq!(object["code"], "usage");
        let said = format!("error: {}\n\n{}\n", object["text"].as_str().unwrap(), object["remedy"].as_str().unwrap());
        assert_eq!(said, text.stderr);
    }
    // What is refused later, by a command.
    let object = failure(&place, "analyse --set pad.mass=heavy", 64);
    assert_eq!(object["code"], "usage");
    assert_eq!(place.run("--messages xml schema").code, Some(64));
    // Help and results stay as they are.
    for words in ["--help", "schema", "analyse --json"] {
        let json = place.run(&format!("--messages json {words}")).done();
        assert_eq!((json.stdout, json.stderr), (place.run(words).done().stdout, String::new()));
    }
}

#[test]
fn what_is_wrong_with_a_job_has_its_place() {
    let place = Place::new();
    let job = surface_job("a", 2, 1000, 1);
    place.write("wrong.toml", &job.replace("relative_std = 0.2", "relative_std = -1"));
    let at = json!({ "file": "wrong.toml", "line": 10, "column": 16, "key": "random.relative_std" });
    assert_eq!(without_text(failure(&place, "submit wrong.toml", 65)), json!({ "code": "job-spec", "place": at }));
    // Of several the first, whatever the order in which they are found.
    place.write("several.toml", &job.replace("relative_std = 0.2", "relative_std = -1").replace("[axes]", "[axis]"));
    let object = failure(&place, "check several.toml", 65);
    assert_eq!((&object["place"]["line"], &object["place"]["column"]), (&json!(3), &json!(2)), "{object}");
    // No TOML, no name, no file, no text.
    place.write("broken.toml", "name = \n");
    let object = failure(&place, "check broken.toml", 65);
    assert_eq!((&object["code"], &object["place"]["line"]), (&json!("job-spec"), &json!(1)), "{object}");
    place.write("nameless.toml", &job.replace("name = \"a\"\n", ""));
    let object = failure(&place, "check nameless.toml", 65);
    assert_eq!(object["place"]["key"], "name", "{object}");
    let missing = json!({ "code": "input-output", "place": { "file": "nothing.toml" } });
    assert_eq!(without_text(failure(&place, "check nothing.toml", 74)), missing);
    // Tests of brakes have lines, too.
    place.write("tests.csv", "rotating_speed,preload,squealed\n13,0.1,1\n\n14,0.1,maybe\n");
    place.write("job.toml", &job);
    let object = failure(&place, "fit tests.csv --job job.toml", 65);
    assert_eq!(without_text(object), json!({ "code": "job-refused", "place": { "file": "tests.csv", "line": 4 } }));
}

#[test]
fn a_job_from_standard_input_is_called_job() {
    let place = Place::new();
    let mut child =
        place.command("--messages json check -").stdin(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(b"name = 3\n").unwrap();
    let output = child.wait_with_output().unwrap();
    let objects = objects(&String::from_utf8(output.stderr).unwrap());
    assert_eq!(objects.last().unwrap()["place"], json!({ "file": "job", "line": 1, "column": 8, "key": "name" }));
}

#[test]
fn each_state_of_a_run_has_a_code_and_a_remedy() {
    let place = Place::new();
    place.write("job.toml", &surface_job("a", 2, 1000, 1));
    place.write("more.toml", &surface_job("a", 2, 2000, 1));
    place.write("fewer.toml", &surface_job("a", 2, 500, 1));
    place.write("other.toml", &surface_job("a", 3, 1000, 1));
    place.run("submit job.toml --shard 1/4 --out run").done();
    let resume = "stickslip resume run";
    for (words, exit, code, remedy) in [
        ("submit job.toml --out run", 73, "run-unfinished", resume),
        ("submit more.toml --out run", 73, "run-to-extend", resume),
        ("submit other.toml --out run", 65, "job-differs", "--out"),
        ("submit fewer.toml --out run", 65, "run-has-more", "--samples 1000"),
        ("plot run", 65, "incomplete", resume),
        ("merge run", 65, "incomplete", resume),
        ("compare run run", 65, "incomplete", resume),
    ] {
        assert_eq!(without_text(failure(&place, words, exit)), json!({ "code": code, "remedy": remedy }), "{words}");
    }
    for words in ["resume nothing", "status nothing"] {
        let no_run = json!({ "code": "no-run", "place": { "file": "nothing" } });
        assert_eq!(without_text(failure(&place, words, 74)), no_run);
    }
    let object = failure(&place, "submit job.toml --out more.toml", 73);
    let taken = json!({ "code": "cannot-create", "place": { "file": "more.toml" }, "remedy": "--out" });
    assert_eq!(without_text(object), taken);

    // What is written and what is finished are notes that programs know.
    place.run("resume run").done();
    let codes = |words: &str| -> Vec<String> {
        let said = place.run(&format!("--messages json {words}")).done().stderr;
        objects(&said).iter().map(|object| object["code"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!(codes("submit job.toml --out run"), ["run-finished"]);
    assert_eq!(codes("limit run --of preload --probability 0.5 --out limits.parquet").last().unwrap(), "file-written");

    // Damage, with the file, and a piece that is left out.
    fs::write(place.path("run/surface.parquet"), "no surface").unwrap();
    let damaged = json!({ "file": "run/surface.parquet" });
    let object = failure(&place, "plot run", 74);
    assert_eq!(without_text(object), json!({ "code": "damaged", "place": damaged, "remedy": "stickslip verify run" }));
    let piece = fs::read_dir(place.path("run/shards")).unwrap().next().unwrap().unwrap().path();
    fs::write(&piece, "no piece").unwrap();
    let said = objects(&place.run("--messages json merge run").stderr);
    assert_eq!((&said[0]["code"], &said[1]["code"]), (&json!("warning"), &json!("incomplete")), "{said:?}");
    assert!(said[0]["place"]["file"].as_str().unwrap().starts_with("run/shards/"), "{said:?}");
    fs::write(place.path("run/job.toml"), "edited").unwrap();
    assert_eq!(failure(&place, "resume run", 74)["code"], "damaged");
}

#[test]
fn a_file_that_cannot_be_written_has_its_place() {
    let place = Place::new();
    let file = "nowhere/file.parquet";
    let object = failure(&place, &format!("trajectory --horizon 1 --disc rigid --out {file}"), 73);
    assert_eq!(object["code"], "cannot-create");
    if cfg!(target_os = "linux") {
        let mut command = place.command("--messages json schema");
        let output = command.stdout(File::options().write(true).open("/dev/full").unwrap()).output().unwrap();
        assert_eq!(output.status.code(), Some(74));
        let said = objects(&String::from_utf8(output.stderr).unwrap());
        assert_eq!((said.len(), &said[0]["code"]), (1, &json!("input-output")));
    }
}

#[test]
fn names_that_would_change_a_terminal_are_harmless() {
    let place = Place::new();
    let name = "a\u{1b}[31m\"b\\";
    let object = failure(&place, &format!("check {name}"), 74);
    assert_eq!(object["text"], "cannot read $'a\\033[31m\"b\\\\': No such file or directory (os error 2)");
}

/// A job whose end no test sees.
fn begin_long(place: &Place) -> std::process::Child {
    place.write("long.toml", &surface_job("long", 20, 2_000_000_000, 3));
    let mut command = place.command("--messages json submit long.toml --out long --threads 1");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    wait_for("its job", &mut child, || place.path("long/job.toml").exists());
    child
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn progress_has_numbers_and_an_interruption_its_remedy() {
    let place = Place::new();
    let begun = Instant::now();
    let mut child = begin_long(&place);
    // It is in use meanwhile.
    let object = failure(&place, "resume long", 75);
    assert_eq!(without_text(object), json!({ "code": "run-in-use", "remedy": "wait until it ends, or stop it" }));
    let mut text = String::new();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let (mut timed, mut advances) = (0, 0);
    while timed < 3 || advances < 3 {
        let line = lines.next().unwrap();
        let numbers = &objects(&line)[0]["progress"];
        timed += u32::from(numbers["seconds_left"].is_number());
        advances += u32::from(numbers["done"].as_u64().is_some_and(|done| done > 0));
        text += &(line + "\n");
    }
    send(&child, "INT");
    lines.for_each(|line| text += &(line + "\n"));
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let said = objects(&text);
    let progress: Vec<&Value> = said.iter().filter(|object| object["code"] == "progress").collect();
    // Five a second, the first at once.
    assert!(progress.len() as u128 <= begun.elapsed().as_millis() / 200 + 2, "{said:?}");
    let numbers: Vec<&Value> = progress.iter().map(|object| &object["progress"]).collect();
    let done: Vec<u64> = numbers.iter().map(|numbers| numbers["done"].as_u64().unwrap()).collect();
    assert!(done.is_sorted() && done[0] < *done.last().unwrap(), "{done:?}");
    let last = numbers.last().unwrap();
    assert_eq!(
        (&last["total"], &last["total_is"], &last["unit"]),
        (&json!(800_000_000_000_u64), &json!("known"), &json!("samples"))
    );
    let (rate, left) = (last["rate"].as_f64().unwrap(), last["seconds_left"].as_f64().unwrap());
    let wanted = (8e11 - *done.last().unwrap() as f64) / rate;
    // The rate is the mean since the beginning, the time left comes from how it varies. Both are in seconds.
    assert!(left > wanted / 30.0 && left < wanted * 30.0, "{left} s left, {wanted} s from the rate");
    let rest: Vec<&Value> = said.iter().filter(|object| object["code"] != "progress").collect();
    let codes: Vec<&str> = rest.iter().map(|object| object["code"].as_str().unwrap()).collect();
    assert_eq!(codes, ["interrupting", "note", "interrupted"], "{rest:?}");
    assert_eq!(
        (&rest[0]["remedy"], &rest[2]["remedy"]),
        (&json!("stickslip resume long"), &json!("stickslip resume long"))
    );
}

#[test]
fn what_other_programs_say_is_a_note() {
    let place = Place::new();
    let script =
        "#!/bin/sh\nif [ \"$1\" = --version ]; then echo slurm; else echo \"$0: no partition\" >&2; exit 1; fi\n";
    fs::create_dir(place.path("bin")).unwrap();
    for name in ["sbatch", "scontrol"] {
        fs::set_permissions(place.write(&format!("bin/{name}"), script), fs::Permissions::from_mode(0o755)).unwrap();
    }
    let bin = place.path("bin").display().to_string();
    let place = place.with_environment("PATH", &format!("{bin}:{}", std::env::var("PATH").unwrap()));
    place.write("job.toml", &surface_job("a", 2, 1000, 1));
    let refused = place.run("--messages json submit job.toml --engine slurm --shards 2 --out run").refused(74, &[]);
    let said = objects(&refused.stderr);
    let note = json!({ "code": "note", "text": format!("{bin}/sbatch: no partition") });
    assert!(said.contains(&note), "{said:?}");
    let last = said.last().unwrap();
    assert_eq!(last["code"], "input-output");
    assert!(last["remedy"].as_str().unwrap().contains("submit the job again"), "{last}");
}

#[test]
#[cfg(target_os = "linux")]
fn too_little_memory_is_an_object() {
    let place = Place::new();
    place.write("job.toml", &surface_job("large", 1000, 2, 1));
    let words = format!("ulimit -d 16384 && exec {} --messages json submit job.toml", env!("CARGO_BIN_EXE_stickslip"));
    let output = with_default_signals("sh").args(["-c", &words]).current_dir(place.path("")).output().unwrap();
    assert_eq!(output.status.code(), Some(74));
    let said = objects(&String::from_utf8(output.stderr).unwrap());
    assert_eq!(said.last().unwrap()["code"], "internal-error", "{said:?}");
    assert!(said.last().unwrap()["text"].as_str().unwrap().starts_with("out of memory: "));
}
