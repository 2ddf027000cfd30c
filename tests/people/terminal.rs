//! What the terminal says of a job: its answer first, its messages, and a bar that keeps to its line.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{Place, Table, make_pipe, repository};

/// A job of three speeds and six preloads without samples.
const EXACT: &str = r#"name = "exact"
[axes]
rotating_speed = [10.0, 15.0, 20.0]
preload = { from = 0.02, to = 0.12, points = 6 }
static_friction = 0.39
[random]
inputs = ["preload", "static_friction"]
relative_std = 0.1
[criterion]
kind = "eigenvalue"
[sampling]
method = "exact"
"#;

/// The largest preload up to which every upper end at a rotating speed is below the target, from the surface itself.
fn largest(table: &Table, wanted: f64, target: f64) -> Option<f64> {
    let [speed, preload, high] = ["rotating_speed_rad_s", "preload", "p_high"].map(|name| table.column(name));
    let own: Vec<usize> = (0..speed.len()).filter(|&cell| speed[cell] == wanted).collect();
    let first =
        own.iter().filter(|&&cell| high[cell] >= target).map(|&cell| preload[cell]).fold(f64::INFINITY, f64::min);
    own.iter().map(|&cell| preload[cell]).filter(|preload| *preload < first).reduce(f64::max)
}

#[test]
fn each_slice_has_a_line_of_its_own() {
    let place = Place::new();
    let friction = "static_friction = { from = 0.30, to = 0.36, points = 4 }";
    place.write("job.toml", &EXACT.replace("static_friction = 0.39", friction));
    let said = place.run("submit job.toml --out run --target 0.05").done().stdout.replace('\n', " ");
    let table = Table::read(&place.path("run/surface.parquet"));
    let found = [10.0, 15.0, 20.0].map(|speed| largest(&table, speed, 0.05));
    assert!(found.iter().any(Option::is_some) && found[0] != found[1], "{found:?}");
    for (speed, preload) in [10.0, 15.0, 20.0].into_iter().zip(found) {
        let end = match preload {
            None => "for no preload".to_owned(),
            Some(0.12) => "for every preload".to_owned(),
            Some(preload) => format!("for preload up to {preload}"),
        };
        assert!(said.contains(&format!("At {speed} rad/s: P < 5 % {end}.")), "{said}");
    }
    let worst = found.into_iter().map(|preload| preload.unwrap_or(0.0)).fold(f64::INFINITY, f64::min);
    let all = if worst == 0.0 { "for no preload".to_owned() } else { format!("for preload up to {worst}") };
    let whatever = "whatever the rotating speed and static friction";
    assert!(said.contains(&format!("P < 5 % {all}, {whatever} (")), "{said}");
}

#[test]
fn the_target_is_answered_first_for_each_combination() {
    let place = Place::new();
    let text = EXACT.replace("rotating_speed = [10.0, 15.0, 20.0]\n", "rotating_speed = 15.0\n");
    place.write("one.toml", &text);
    let one = place.run("submit one.toml --out one --target 0.05").done().stdout;
    let table = Table::read(&place.path("one/surface.parquet"));
    let preload = largest(&table, 15.0, 0.05).unwrap();
    assert!(one.contains("Target: P < 5 %, with P the probability of instability."), "{one}");
    assert!(one.replace('\n', " ").contains(&format!("P < 5 % for preload up to {preload} (")), "{one}");
    assert!(!one.contains("whatever"), "there is one axis: {one}");

    // The job says it, too, and the option wins. Neither belongs to what is computed.
    place.write("two.toml", &(text + "[target]\nprobability = 0.5\n"));
    let two = place.run("submit two.toml --out one").done();
    assert!(two.stderr.contains("is finished already") && two.stdout.contains("Target: P < 50 %"), "{two:?}");
    let again = place.run("submit two.toml --out two --target 0.05").done().stdout;
    assert!(again.contains("Target: P < 5 %"), "{again}");
    assert_eq!(place.surface("one"), place.surface("two"));
    assert!(place.run("resume two").done().stdout.contains("Target: P < 50 %"), "the run keeps the target of its job");

    for (line, texts) in [
        ("probability = 5", ["job.toml:", "target.probability = 5 is out of range"]),
        ("", ["job.toml:", "missing key `probability` in [target]"]),
        ("probabilty = 0.1", ["unknown key `probabilty` in [target]", "did you mean `probability`?"]),
    ] {
        place.write("job.toml", &format!("{EXACT}[target]\n{line}\n"));
        place.run("check job.toml").refused(65, &texts);
    }
    place.run("submit one.toml --target 5").refused(64, &["--target", "less than 1"]);
}

#[test]
fn numbers_and_axes_in_another_form_are_answered_with_the_right_one() {
    let place = Place::new();
    let start = "criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\nstart = { velocity = 0.1 }";
    let start = EXACT.replace("criterion]\nkind = \"eigenvalue\"", start);
    place.write("exact.toml", EXACT);
    place.write("start.toml", &start.replace("method = \"exact\"", "samples = 10"));
    for (words, texts) in [
        ("limit exact.toml --of preload --probability 5", vec!["did you mean 0.05 (5 %)?"]),
        ("limit exact.toml --of preload --probability 5%", vec!["5% is in per cent; write 0.05"]),
        ("limit exact.toml --of preload --probability 0,05", vec!["0,05 has a decimal comma; write 0.05"]),
        (
            "limit exact.toml --of preload --probability 0.05 --probability 5e-2",
            vec!["--probability 0.05 is given twice; give it once"],
        ),
        (
            "limit exact.toml --of relative_std --probability 0.05",
            vec!["--of relative_std: limits are sought along expected values", "rotating_speed, preload)"],
        ),
        (
            "limit start.toml --of start.velocity --probability 0.05",
            vec!["--of start.velocity: limits are sought along the brake", "a number of the start", "preload)"],
        ),
        ("analyse pad.mass=0.2", vec!["pad.mass=0.2: there is no such job or run", "write --set pad.mass=0.2"]),
        ("analyse --set pad.mass=", vec!["--set pad.mass=: there is no number; write one"]),
        ("analyse --set pad.mass=20%", vec!["20% is in per cent; write 0.2"]),
        ("analyse --set pad.mass=−0.2", vec!["−0.2 has a dash that is no minus sign; write -0.2"]),
        ("analyse exact.toml --cell -1", vec!["--cell", "write a whole number"]),
        ("plot runs/none --cell one", vec!["--cell", "write a whole number"]),
        ("trajectory --horizon long", vec!["--horizon", "\"long\" is not a number"]),
        ("trajectory --disc-modes many", vec!["--disc-modes", "write a whole number"]),
        ("trajectory --start velocity=fast", vec!["velocity=fast: \"fast\" is not a number"]),
        ("submit exact.toml --at rotating_speed=143rpm", vec!["143 rpm = 14.974925 rad/s"]),
        ("merge runs/none --wait soon", vec!["--wait", "write a whole number"]),
    ] {
        place.run(words).refused(64, &texts);
    }
}

#[test]
fn many_combinations_end_with_a_line_each_and_more_with_one() {
    let place = Place::new();
    place.write("exact.toml", &(EXACT.to_owned() + "[target]\nprobability = 0.05\n"));
    let said = place.run("submit exact.toml --out run").done().stdout;
    let lines: Vec<&str> = said.lines().filter(|line| line.starts_with("At ") && line.contains("P < 5 %")).collect();
    assert_eq!(lines.len(), 6, "{said}");
    let table = Table::read(&place.path("run/surface.parquet"));
    let [speed, preload, high] = ["rotating_speed_rad_s", "preload", "p_high"].map(|name| table.column(name));
    for line in lines {
        let wanted: f64 = line["At preload = ".len()..].split(':').next().unwrap().parse().unwrap();
        let met: Vec<f64> =
            (0..18).filter(|&cell| preload[cell] == wanted && high[cell] < 0.05).map(|cell| speed[cell]).collect();
        let said = match met.as_slice() {
            [] => "for no rotating speed".to_owned(),
            [_, _, _] => "for every rotating speed".to_owned(),
            [first, ..] => format!("for rotating speed from {first} rad/s"),
        };
        assert!(line.contains(&said), "{line}: {met:?}");
    }
    place.write("many.toml", &(EXACT.replace("points = 6", "points = 13") + "[target]\nprobability = 0.05\n"));
    let said = place.run("submit many.toml --out many").done().stdout.replace('\n', " ");
    assert!(said.contains("Of 13 combinations of the other axes, ") && !said.contains("At preload"), "{said}");
}

#[test]
fn what_people_type_is_answered_in_their_words() {
    let place = Place::new();
    let job = |line: &str| format!("name = \"a\"\n[axes]\n{line}\n[criterion]\nkind = \"eigenvalue\"\n");
    for (line, text) in [
        ("preload = 2", "Write 0.1 for 2 mm; a force of 2 N is preload_force = 2 in its place"),
        ("friction = 0.4", "did you mean `static_friction`?"),
        ("preload = “0.1”", "“0.1” has typographic quotation marks; write straight ones: preload = 0.1"),
        ("preload = −0.1", "−0.1 has a dash that is no minus sign; write preload = -0.1"),
        ("rotating_speed = 143rpm", "write the number alone, in the unit of the parameter; 143 rpm = 14.974925 rad/s"),
    ] {
        place.write("job.toml", &job(line));
        place.run("check job.toml").refused(65, &["job.toml:3:", text]);
    }
    place.write("job.toml", &job("preload = 0.1").replace("\"a\"", "\"Bremse Müller\""));
    place.run("check job.toml").refused(65, &["for example \"Bremse-Mueller\""]);
    place.run("analyse --set friction=0.4").refused(64, &["did you mean `friction.static_coefficient`?"]);
    place
        .run("analyse --set rotating_speed=143rpm")
        .refused(64, &["143 rpm = 14.974925 rad/s; `stickslip parameters` lists the units"]);
}

#[test]
fn a_quantity_has_the_names_of_axes_and_of_parameters_everywhere() {
    let place = Place::new();
    let long = place.run("analyse --set operating_point.preload=0.07 --set friction.static_coefficient=0.45").done();
    let short = place.run("analyse --set preload=0.07 --set static_friction=0.45").done();
    assert_eq!(short.stdout, long.stdout);
    assert!(long.stdout.contains("preload 0.07, static friction 0.45"), "{}", long.stdout);
    place
        .run("analyse --set preload=0.07 --set operating_point.preload=0.08")
        .refused(64, &["operating_point.preload is set a second time"]);
    let force = place.run("analyse --set preload_force=9000").done().stdout;
    assert_eq!(force, place.run("analyse --set operating_point.preload_force=9000").done().stdout);
}

#[test]
fn status_without_a_name_is_that_of_the_folder_runs() {
    let place = Place::new();
    place.run("status").refused(74, &["runs is not a run directory: it does not exist"]);
    place.write("exact.toml", EXACT);
    place.run("submit exact.toml").done();
    let said = place.run("status").done().stdout;
    assert!(said.starts_with("exact") && said.contains("finished"), "{said}");
}

#[test]
fn completions_offer_the_keys_of_set() {
    let place = Place::new();
    let script = place.run("completions bash").done().stdout;
    for key in ["friction.static_coefficient=", "operating_point.preload_force=", "pad.effective_radius="] {
        assert!(script.contains(key), "{key}");
    }
    assert!(script.contains("compopt -o nospace"));
    // A key that is not offered is taken all the same.
    place.write("hoffmann.toml", &fs::read_to_string(repository().join("jobs/hoffmann.toml")).unwrap());
    place.run("analyse hoffmann.toml --set friction=0.3").done();
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_shipped_job_is_written_with_its_files_and_nothing_is_replaced() {
    let place = Place::new();
    let said = place.run("init --from mission").done().stdout;
    assert!(said.starts_with("Wrote mission.toml and mission-friction.csv. Next:\n"), "{said}");
    for file in ["mission.toml", "mission-friction.csv"] {
        assert_eq!(fs::read(place.path(file)).unwrap(), fs::read(repository().join("jobs").join(file)).unwrap());
    }
    place.run("check mission.toml").done();
    place
        .run("init --from mission")
        .refused(73, &["mission.toml exists already", "stickslip init --from mission NAME"]);
    place.run("init --from mission other.toml").done();
    place.write("mission-friction.csv", "mine");
    place
        .run("init --from mission third.toml")
        .refused(73, &["mission-friction.csv exists already and is another file"]);
    assert!(!place.path("third.toml").exists());
    fs::remove_file(place.path("mission-friction.csv")).unwrap();
    make_pipe(&place.path("mission-friction.csv"));
    let refused = place.run_unless_it_hangs("init --from mission third.toml");
    refused.refused(73, &["mission-friction.csv exists already and is another file"]);
    place.run("init --from own-brake").done();
    let matrices = "own-brake/own-brake.mat";
    assert!(fs::read(place.path(matrices)).unwrap() == fs::read(repository().join("jobs").join(matrices)).unwrap());
    place.run("init --from parking-mop").refused(64, &["did you mean parking-map?", "\n  mission "]);
    place.run("init --from tu-brake").refused(64, &["tu-brake does not come with the program", "too large"]);
    assert!(place.run("init --from fig4 -").done().stdout.contains("name = \"fig4\""));
}

#[test]
fn a_run_of_another_job_is_kept_apart_or_overwritten() {
    let place = Place::new();
    place.write("a.toml", EXACT);
    place.write("b.toml", &EXACT.replace("relative_std = 0.1", "relative_std = 0.2"));
    place.run("submit a.toml").done();
    place.run("submit b.toml").refused(
        65,
        &[
            "`random.relative_std = ",
            "the job has `random.relative_std = ",
            "--out, or replace that run with --overwrite",
        ],
    );
    let apart = place.run("submit b.toml --apart").done();
    assert!(apart.stderr.contains("runs/exact holds a run of another job; this one goes to runs/exact-"), "{apart:?}");
    let folders = || fs::read_dir(place.path("runs")).unwrap().count();
    assert_eq!(folders(), 2);
    assert!(place.run("submit b.toml --apart").done().stderr.contains("its surface is unchanged"));
    assert!(place.run("submit a.toml --apart").done().stderr.contains("its surface is unchanged"));
    assert_eq!(folders(), 2);
    let before = place.surface("runs/exact");
    place.run("plot runs/exact").done();
    place.write("runs/exact/notes.txt", "mine");
    place.run("submit b.toml --overwrite").done();
    assert_ne!(place.surface("runs/exact"), before);
    assert!(!place.path("runs/exact/surface.svg").exists() && place.path("runs/exact/notes.txt").exists());
    assert_eq!(folders(), 2);
    place.run("submit a.toml --overwrite --out .").refused(73, &["is not empty and not a run directory"]);
}

#[test]
fn whole_numbers_may_have_an_exponent() {
    let place = Place::new();
    let text = EXACT.replace("method = \"exact\"", "samples = 1e3\nseed = 1").replace("points = 6", "points = 6.0");
    place.write("a.toml", &text);
    assert!(place.run("submit a.toml --out a").done().stdout.contains(" 18 cells, 1,000 samples each, seed 1"));
    assert!(place.run("submit a.toml --out a --samples 2e3").done().stdout.contains("2,000 samples each"));
    place.run("submit a.toml --samples 2.5").refused(64, &["write a whole number, for example 10000, 10_000 or 1e4"]);
    place.write("a.toml", &text.replace("1e3", "1000.5"));
    place.run("check a.toml").refused(65, &["sampling.samples is 1000.5; it must be a whole number"]);
}
