//! The messages about a job spec, or `--set`, that is wrong or probably not meant.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs;
use std::io::Write as _;
use std::process::Stdio;

use crate::common::{Outcome, Place, surface_job};

/// A job of four cells with a change.
fn changed(from: &str, to: &str) -> String {
    let text = surface_job("job", 2, 100, 7);
    assert!(text.contains(from), "{from}");
    text.replacen(from, to, 1)
}

/// A job of four cells in time.
fn in_time(keys: &str) -> String {
    changed("kind = \"eigenvalue\"", &format!("kind = \"time-domain\"\ndisc = \"rigid\"\n{keys}"))
}

#[track_caller]
fn checked(text: &str) -> Outcome {
    let place = Place::new();
    place.write("job.toml", text);
    place.run("check --all job.toml")
}

#[test]
fn every_error_of_a_file_is_reported_in_its_order() {
    let text = "nmae = \"job\"\n\n\
        [model.disc]\nthickness = 20\nyoungs_modulus = \"2.1e11\"\n\n\
        [model.stiffness]\nk_en = 1e7\n\n\
        [axes]\npreload = 5000\nspeed = 3\n\n\
        [random]\ninputs = [\"preload\", \"f_s\"]\nrelative_std = 0.2\n\n\
        [criterion]\nkind = \"time-domain\"\nstart = { at = \"rest\" }\nhorizon = -1\n\n\
        [sampling]\nsamples = 0\nseed = -1\nrandomisations = 4\n";
    let said = checked(text).refused(65, &[]).stderr;
    let mut from = 0;
    for (place, texts) in [
        ("job.toml:1:1: ", &["unknown key `nmae`; did you mean `name`?", "1 | nmae = "][..]),
        ("job.toml:4:13: ", &["disc.thickness = 20 is out of range", "at most 1", "did you mean 0.02 (20 mm)?"]),
        ("job.toml:5:18: ", &["model.disc.youngs_modulus is the string", "a number", "write 2.1e11, without quotes"]),
        ("job.toml:8:1: ", &["unknown key `k_en` in [model.stiffness]", "did you mean `contact_normal`?"]),
        ("job.toml:11:11: ", &["axes.preload: 5000 is out of range"]),
        ("job.toml:12:1: ", &["unknown key `speed` in [axes]", "rotating_speed"]),
        ("job.toml:15:22: ", &["no input \"f_s\"", "did you mean `static_friction`?"]),
        ("job.toml:20:11: ", &["unknown key `at` in [criterion.start]", "it may have tangential, velocity"]),
        ("job.toml:21:11: ", &["criterion.horizon = -1 is out of range"]),
        ("job.toml:24:11: ", &["sampling.samples = 0 is out of range"]),
        ("job.toml:25:8: ", &["sampling.seed is -1", "from 0 to 18446744073709551615 (2^64 - 1)"]),
        ("job.toml:26:18: ", &["sampling.randomisations has no meaning", "or use method = \"sobol\""]),
    ] {
        let rest = &said[from..];
        let at = rest.find(place).unwrap_or_else(|| panic_with(place, rest));
        let message = &rest[at..rest[at + 1..].find("job.toml:").map_or(rest.len(), |next| at + 1 + next)];
        for text in texts {
            assert!(message.contains(text), "{text:?} is not in: {message}");
        }
        from += at + place.len();
    }
    // Nothing but these: no complaint that follows from another one, such as a missing name.
    assert_eq!(said.matches("job.toml:").count(), 12, "{said}");
}

#[track_caller]
#[allow(clippy::panic, reason = "the test has failed")]
fn panic_with(text: &str, said: &str) -> usize {
    panic!("{text:?} does not follow in: {said}")
}

#[test]
fn every_value_that_cannot_be_read_is_reported_with_what_would_be_right() {
    let friction = |value: &str| changed("[axes]", &format!("[model.friction]\nstribeck_velocity = {value}\n\n[axes]"));
    for (text, texts) in [
        (
            friction("\"0.5\""),
            &["job.toml:4:21", "model.friction.stribeck_velocity is the string \"0.5\"", "write 0.5, without quotes"][..],
        ),
        (friction("\"0,5\""), &["write 0.5, without quotes"]),
        (friction("\"slow\""), &["the string \"slow\"; it must be a number\n"]),
        (friction("0,5"), &["job.toml:4:21", "0,5 has a decimal comma; write 0.5"]),
        (
            changed("{ from = 0.03, to = 0.30,", "{ from = 0,03, to = 0,30,"),
            &[
                "job.toml:5:20: 0,03 has a decimal comma; write 0.03",
                "job.toml:5:31: 0,30 has a decimal comma; write 0.30",
            ],
        ),
        (changed("seed = 7", "seed ="), &["job.toml:17:7: seed has no value"]),
        (changed("seed = 7", "seed = 7;"), &["a line has no semicolon at its end: seed = 7\n"]),
        (changed("seed = 7", "seed = 7 % any"), &["a comment begins with #, not with %: seed = 7 # ..."]),
        (changed("rotating_speed = 15.0", "rotating_speed = [10 15]"), &["separated by commas: [10, 15]"]),
        (changed("rotating_speed = 15.0", "rotating_speed = 10:5:20"), &["{ from = 0.1, to = 0.2, points = 5 }"]),
        (changed("rotating_speed = 15.0", "rotating_speed = [10, 15"), &["the list is not closed with ]"]),
        (
            changed("rotating_speed = 15.0", "rotating_speed = [10, \"15\"]"),
            &["an element of axes.rotating_speed is the string \"15\"; it must be a number; write 15, without quotes"],
        ),
        (
            changed("rotating_speed = 15.0", "rotating_speed = 2025-01-01"),
            &["axes.rotating_speed = 2025-01-01 is a date"],
        ),
        (changed("rotating_speed = 15.0", "rotating_speed = 1e999"), &["axes.rotating_speed = 1e999 is too large"]),
        (changed("[random]", "[[random]]"), &["[[random]] would be a list of tables; write [random]"]),
        (
            changed("name = \"job\"", "samples = 3\nname = \"job\""),
            &["unknown key `samples`; `samples` belongs in [sampling]"],
        ),
        (changed("name = \"job\"", "name = job"), &["job.toml:1:8: job is no value", "in quotes, \"job\""]),
        (changed("name = \"job\"", "name = 3"), &["job.toml:1:8: name is 3; it must be a text in quotes"]),
        (changed("[criterion]\nkind = \"eigenvalue\"", ""), &["there is no [criterion]", "kind = \"eigenvalue\""]),
        (
            changed("kind = \"eigenvalue\"", ""),
            &["job.toml:12:1", "missing key `kind` in [criterion]", "\"time-domain\""],
        ),
        (in_time("start = 3"), &["criterion.start = 3", "\"near-equilibrium\", \"rest\" or \"limit-cycle\""]),
        (in_time("record = \"amplitude\""), &["criterion.record is the string \"amplitude\"; it must be a list"]),
        (
            in_time("index = 0.002"),
            &["criterion.index is 0.002; it must be a table, for example { amplitude = 0.002 }"],
        ),
        (
            changed("seed = 7", "seed = 18446744073709551616"),
            &["job.toml:17:8", "sampling.seed is 18446744073709551616", "from 0 to 18446744073709551615 (2^64 - 1)"],
        ),
        (changed("seed = 7", &format!("seed = 1{}", "0".repeat(50))), &["is too large", "(2^64 - 1)"]),
        (changed("samples = 100", "samples = 1.5e0"), &["sampling.samples is 1.5", "a whole number"]),
        (
            changed("rotating_speed = 15.0", "Omega = 15.0\nk_t1 = 1\nsamples = 5"),
            &[
                "job.toml:4:1: unknown key `Omega` in [axes]; did you mean `rotating_speed`?",
                "job.toml:5:1: unknown key `k_t1` in [axes]; did you mean `\"stiffness.contact_tangential_1\"`?",
                "job.toml:6:1: unknown key `samples` in [axes]; `samples` belongs in [sampling]",
            ],
        ),
        (
            changed("[axes]", "[model.friction]\nf_s = 0.4\n\n[axes]"),
            &["unknown key `f_s` in [model.friction]; did you mean `static_friction` in [axes]?"],
        ),
    ] {
        checked(&text).refused(65, texts);
    }
}

#[test]
fn a_preload_is_no_force() {
    let hint = "a displacement";
    let said =
        checked(&changed("preload = {", "preload = 5000 #")).refused(65, &["axes.preload: 5000 is out of range"]);
    assert!(!said.stderr.contains(hint));
    // k_en k_y / (k_en + k_y) h = 350 975 N for the preset.
    for text in ["not a force", "preload 1 presses with 350975 N", "write 0.014246 for 5000 N"] {
        assert!(said.stderr.contains(text), "{}", said.stderr);
    }
    let place = Place::new();
    place
        .run("analyse --set operating_point.preload=5000")
        .refused(64, &["preload 1 presses with 350975 N", "write 0.014246 for 5000 N"]);
    let analysed = place.run("analyse --set operating_point.preload=0.014246 --json").done().stdout;
    let analysed: serde_json::Value = serde_json::from_str(&analysed).unwrap();
    assert!((analysed["normal_force_n"].as_f64().unwrap() - 5000.0).abs() < 0.1);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_value_in_two_places_is_refused_with_both_lines() {
    for (section, key, axis) in [
        ("friction", "static_coefficient = 0.4", "static_friction"),
        ("operating_point", "rotating_speed = 12", "rotating_speed"),
        ("operating_point", "preload = 0.2", "preload"),
    ] {
        let text = changed("[axes]", &format!("[model.{section}]\n{key}\n\n[axes]"));
        let line = text.lines().position(|line| line.starts_with(axis) && line != key).unwrap() + 1;
        let mentioned = text.lines().nth(line - 1).unwrap();
        checked(&text).refused(
            65,
            &[
                "job.toml:4:",
                &format!("model.{section}.{key} is given a second time as axes.{axis}"),
                &format!("job.toml:{line}:"),
                mentioned,
            ],
        );
        // Without the axis it is the value of the job.
        let alone: String = text.lines().filter(|other| *other != mentioned).map(|line| format!("{line}\n")).collect();
        let value: f64 = key.split_once(" = ").unwrap().1.parse().unwrap();
        let normalised = checked(&alone).done().stdout;
        assert!(normalised.contains(&format!("{axis} = [{value:?}]")), "{normalised}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn implausible_values_are_warned_of_with_the_likely_unit() {
    let place = Place::new();
    let model = |section: &str, keys: &str| changed("[axes]", &format!("[model.{section}]\n{keys}\n\n[axes]"));
    for (text, warning) in [
        (
            model("disc", "youngs_modulus = 210"),
            "disc.youngs_modulus = 210 Pa is not plausible (usually 1e9 to 1.5e12 Pa); did you mean 2.1e11 (210 GPa)?",
        ),
        (model("disc", "density = 7.8"), "did you mean 7800 (7.8 g/cm^3)?"),
        (model("pad", "mass = 300"), "did you mean 0.3 (300 g)?"),
        (model("disc", "thickness = 0.1"), "disc.thickness = 0.1 m is more than the width of the ring"),
        (model("stiffness", "calliper_angular = 51"), "the model holds up to 0.25 rad"),
        (
            changed("rotating_speed = 15.0", "rotating_speed = [15, 1500]"),
            "axes.rotating_speed = 1500 rad/s is not plausible (usually 0.001 to 1000 rad/s); did you mean 157.08 (1500 rpm)?",
        ),
        (
            changed(
                "relative_std = 0.2",
                "relative_std = 0.2\ndistribution = { preload = { truncated-normal = [1.0, 3.0] } }",
            ),
            "truncated-normal = [1, 3] excludes the expected value itself, so every sample is more than it",
        ),
        (
            in_time("displacement = 100"),
            "criterion.displacement = 100 starts the motion at 100 times the displacement of the equilibrium",
        ),
    ] {
        place.write("job.toml", &text);
        for command in ["check job.toml".to_owned(), format!("submit job.toml --out {}", blake3::hash(text.as_bytes()))]
        {
            let said = place.run(&command).done().stderr;
            assert_eq!(said.matches("warning: ").count(), 1, "{said}");
            assert!(said.contains(warning), "{said}");
        }
    }
    for command in ["analyse --json", "trajectory --json --disc rigid --horizon 5"] {
        let said = place.run(&format!("{command} --set pad.mass=20.5")).done().stderr;
        assert!(said.contains("warning: pad.mass = 20.5 kg is not plausible"), "{said}");
        assert!(!place.run(command).done().stderr.contains("warning"));
    }
    let said = place.run("trajectory --json --disc rigid --horizon 5 --displacement 100").done().stderr;
    assert!(said.contains("warning: --displacement = 100 starts the motion at 100 times"), "{said}");
}

#[test]
fn what_the_command_line_cannot_mean_is_refused() {
    let place = Place::new();
    place.write("job.toml", &surface_job("job", 2, 100, 7));
    for (words, texts) in [
        (
            "analyse --set pad.mass=0.2 --set pad.mass=0.3",
            &["--set pad.mass=0.3", "pad.mass is set a second time, after pad.mass=0.2"][..],
        ),
        ("analyse --set friction.static_coefficient=0,4", &["0,4 has a decimal comma; write 0.4"]),
        ("analyse --set axes.preload=0.1", &["did you mean `operating_point.preload`?"]),
        ("analyse --set axes.static_friction=0.1", &["did you mean `friction.static_coefficient`?"]),
        ("analyse --set model.friction.static_coefficient=0.4", &["did you mean `friction.static_coefficient`?"]),
        ("analyse --set k_t1=1e7", &["did you mean `stiffness.contact_tangential_1`?"]),
        ("analyse --set f_s=0.4", &["did you mean `friction.static_coefficient`?"]),
        ("analyse --set k_en=1e7", &["did you mean `stiffness.contact_normal`?"]),
        ("analyse --set Delta=0.1", &["did you mean `operating_point.preload`?"]),
        ("analyse --set Omega=10", &["did you mean `operating_point.rotating_speed`?"]),
        ("analyse --set disc.thickness=20", &["out of range", "did you mean 0.02 (20 mm)?"]),
        ("trajectory --disc rigid --out x.csv", &["x.csv", "written as Parquet", "name it x.parquet"]),
        ("trajectory --disc rigid --out x", &["name it x.parquet"]),
        ("submit job.toml --seed -1", &["a seed is a whole number from 0 to 9223372036854775807"]),
        ("submit job.toml --seed 18446744073709551616", &["a seed is a whole number from 0 to 9223372036854775807"]),
        ("submit job.toml --samples -1", &["write a whole number"]),
    ] {
        place.run(words).refused(64, texts);
    }
    assert_eq!(fs::read_dir(place.path("")).unwrap().count(), 1, "nothing is written");
}

#[test]
fn a_job_is_read_from_standard_input() {
    let place = Place::new();
    let given = |words: &str, text: &str| {
        let mut command = place.command(words);
        let command = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        let output = child.wait_with_output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        Outcome { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    };
    let text = surface_job("piped", 2, 100, 7);
    assert!(given("check -", &text).done().stdout.contains("# job is valid."));
    given("check -", &text.replace("samples", "sampels")).refused(65, &["job:16:1: unknown key `sampels`"]);
    given("submit -", &text).done();
    assert_eq!(fs::read_to_string(place.path("runs/piped/job.toml")).unwrap(), text);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn summaries_name_every_input_and_count_in_words() {
    let place = Place::new();
    let text = changed("inputs = [\"preload\", \"static_friction\"]", "inputs = [\"rotating_speed\", \"pad.mass\"]")
        .replace("relative_std = 0.2", "relative_std = { rotating_speed = 0.05, \"pad.mass\" = 0.1 }")
        .replace("preload = {", "preload = 0.1 #")
        .replace("static_friction = {", "static_friction = 0.4 #")
        .replace("samples = 100", "samples = 1");
    place.write("job.toml", &text);
    let said = place.run("submit job.toml").done().stdout;
    assert!(said.contains("relative std: pad.mass 0.1,\nrotating_speed 0.05"), "{said}");
    assert!(said.contains(": 1 cell, 1 sample each, seed 7"), "{said}");
    let said = place.run("check job.toml --threads 1").done().stdout;
    for text in
        ["# 1 cell: 1 rotating speed x 1 standard deviation x 1 preload x 1 static", "# 1 sample, ", "on 1 thread "]
    {
        assert!(said.contains(text), "{text} is not in: {said}");
    }
}
