//! The command line as a user types it: what it says, its exit codes, and what it does with silly input.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;
use std::fs::OpenOptions;
use std::process::Stdio;

use crate::common::{Place, Table, commands_of_the_program, repository, send, surface_job, wait_for};

#[test]
fn a_job_becomes_a_surface() {
    let place = Place::new();
    place.write("job.toml", &surface_job("small", 3, 100, 7));
    let outcome = place.run("submit job.toml").done();
    assert!(
        outcome.stdout.contains("runs/small/surface.parquet: 9 cells, 100 samples each, seed 7"),
        "{}",
        outcome.stdout
    );
    assert!(outcome.stdout.contains("Probability of instability at 15 rad/s"), "{}", outcome.stdout);
    for name in ["job.toml", "shards", "surface.parquet", "run.json"] {
        assert!(place.path("runs/small").join(name).exists(), "{name}");
    }
    assert_eq!(
        fs::read_to_string(place.path("runs/small/job.toml")).unwrap(),
        surface_job("small", 3, 100, 7),
        "frozen as submitted"
    );

    let table = Table::read(&place.path("runs/small/surface.parquet"));
    let contract = [
        "cell",
        "rotating_speed_rad_s",
        "std_preload",
        "std_static_friction",
        "preload",
        "static_friction",
        "n_samples",
        "n_stable",
        "n_unstable",
        "n_undecided",
        "n_failed",
        "p_unstable",
        "p_low",
        "p_high",
        "n_outside_physics",
    ];
    assert_eq!(table.names(), contract);
    assert_eq!(table.column("cell"), [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    assert_eq!(table.column("static_friction"), [0.27, 0.385, 0.5].repeat(3));
    for row in 0..9 {
        let of = |name: &str| table.column(name)[row];
        assert_eq!(of("n_samples"), 100.0);
        assert_eq!(of("n_stable") + of("n_unstable") + of("n_undecided") + of("n_failed"), 100.0);
        assert_eq!(of("p_unstable"), of("n_unstable") / 100.0);
        assert!(of("p_low") <= of("p_unstable") && of("p_unstable") <= of("p_high"));
    }
    let keys: Vec<&str> = table.footer.iter().map(|(key, _)| key.as_str()).collect();
    assert_eq!(
        keys,
        [
            "stickslip:job",
            "stickslip:job_hash",
            "stickslip:seed",
            "stickslip:engine_version",
            "stickslip:results_version"
        ]
    );
}

#[test]
fn submitting_again_is_a_no_op_that_says_so() {
    let place = Place::new();
    place.write("job.toml", &surface_job("again", 3, 100, 7));
    place.run("submit job.toml").done();
    let before = place.surface("runs/again");
    let modified = fs::metadata(place.path("runs/again/surface.parquet")).unwrap().modified().unwrap();
    let outcome = place.run("submit job.toml").done();
    assert!(outcome.stderr.contains("finished already"), "{}", outcome.stderr);
    assert_eq!(place.surface("runs/again"), before);
    assert_eq!(fs::metadata(place.path("runs/again/surface.parquet")).unwrap().modified().unwrap(), modified);

    // Name and description are not part of what a job computes.
    place.write("renamed.toml", &surface_job("other-name", 3, 100, 7));
    place.run("submit renamed.toml --out runs/again").done();
}

#[test]
fn a_lost_or_damaged_surface_comes_back_from_the_pieces() {
    let place = Place::new();
    place.write("job.toml", &surface_job("lost", 3, 100, 7));
    place.run("submit job.toml").done();
    let before = place.surface("runs/lost");
    fs::remove_file(place.path("runs/lost/surface.parquet")).unwrap();
    let status = place.run("status runs/lost").done();
    assert!(status.stdout.contains("complete, not merged"), "{}", status.stdout);
    place.run("submit job.toml").done();
    assert_eq!(place.surface("runs/lost"), before);
    place.write("runs/lost/surface.parquet", "PAR1 nonsense");
    place.run("resume runs/lost").done();
    assert_eq!(place.surface("runs/lost"), before);
}

#[test]
fn damaged_pieces_are_computed_again() {
    let place = Place::new();
    place.write("job.toml", &surface_job("damaged", 3, 100, 7));
    place.run("submit job.toml").done();
    let before = place.surface("runs/damaged");
    let piece = fs::read_dir(place.path("runs/damaged/shards")).unwrap().next().unwrap().unwrap().path();
    let mut bytes = fs::read(&piece).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&piece, bytes).unwrap();
    fs::remove_file(place.path("runs/damaged/surface.parquet")).unwrap();
    let status = place.run("status runs/damaged").done();
    assert!(status.stdout.contains("unfinished") && status.stderr.contains("is ignored"), "{status:?}");
    let refused =
        place.run("submit job.toml").refused(73, &["checksum", "unfinished run", "stickslip resume runs/damaged"]);
    assert!(refused.stdout.is_empty());
    place.run("merge runs/damaged").refused(65, &["not complete", "0 of 9 cells"]);
    place.run("resume runs/damaged").done();
    assert_eq!(place.surface("runs/damaged"), before);
}

#[test]
fn a_run_of_another_job_is_refused_and_untouched() {
    let place = Place::new();
    place.write("job.toml", &surface_job("mine", 3, 100, 7));
    place.run("submit job.toml").done();
    let before = place.surface("runs/mine");
    place
        .run("submit job.toml --seed 8")
        .refused(65, &["run of another job", "`sampling.seed = 7`", "`sampling.seed = 8`", "--out"]);
    place
        .run("submit job.toml --samples 50")
        .refused(65, &["100 samples in each cell, more than the 50 of this one", "--out"]);
    place.write("job.toml", &surface_job("mine", 3, 100, 7).replace("15.0", "16.0"));
    place.run("submit job.toml").refused(65, &["rotating_speed = [15.0]", "rotating_speed = [16.0]"]);
    assert_eq!(place.surface("runs/mine"), before);
}

#[test]
fn bad_job_specs_are_refused_with_place_value_and_remedy() {
    let good = surface_job("bad", 3, 100, 7);
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "samples = 100",
            "sampels = 100",
            &["job.toml:16:1", "unknown key `sampels`", "did you mean `samples`?", "16 | sampels = 100"],
        ),
        ("[criterion]", "[criterium]", &["job.toml:12:2", "unknown key `criterium`", "did you mean `criterion`?"]),
        ("samples = 100", "samples = \"many\"", &["job.toml:16:11", "string \"many\"", "whole number"]),
        ("samples = 100", "samples = -5", &["job.toml:16:11", "-5", "whole number"]),
        ("samples = 100", "samples = 0", &["job.toml:16:11", "samples = 0", "at least 1"]),
        ("rotating_speed = 15.0", "rotating_speed = []", &["job.toml:4:18", "axes.rotating_speed", "empty"]),
        ("points = 3", "points = 0", &["axes.preload", "empty"]),
        ("points = 3", "points = 1", &["axes.preload", "at least 2 points"]),
        ("points = 3", "ponts = 3", &["ponts", "did you mean `points`?"]),
        ("rotating_speed = 15.0", "rotating_speed = nan", &["job.toml:4:18", "NaN"]),
        (
            "rotating_speed = 15.0",
            "rotating_speed = 0",
            &["axes.rotating_speed: 0 is out of range", "at least 0.000001", "rad/s"],
        ),
        ("rotating_speed = 15.0", "rotating_speed = [10, 15, 10]", &["10 appears twice"]),
        ("from = 0.03", "from = \"low\"", &["string \"low\"", "a number"]),
        ("relative_std = 0.2", "relative_std = -0.2", &["job.toml:10:16", "relative_std = -0.2", "at least 0"]),
        ("relative_std = 0.2", "relative_std = nan", &["relative_std = NaN", "at least 0"]),
        ("relative_std = 0.2", "relative_std = { preload = 0.2 }", &["no value for static_friction"]),
        ("relative_std = 0.2\n", "", &["relative_std is missing"]),
        ("\"static_friction\"]", "\"static_fricton\"]", &["static_fricton", "did you mean `static_friction`?"]),
        ("kind = \"eigenvalue\"", "kind = \"eigenvalues\"", &["eigenvalues", "did you mean `eigenvalue`?"]),
        ("kind = \"eigenvalue\"", "", &["missing key `kind`"]),
        ("seed = 7", "seed = 7\nconfidence = 1.5", &["confidence = 1.5", "less than 1"]),
        ("seed = 7", "seed = -1", &["-1", "whole number"]),
        ("[axes]", "[model]\npreset = \"sui\"\n[axes]", &["unknown preset \"sui\"", "sui-ding-2018"]),
        (
            "[axes]",
            "[model.disc]\nthickness = 0\n[axes]",
            &["job.toml:4:13", "disc.thickness = 0", "greater than 0", "(in m)"],
        ),
        (
            "[axes]",
            "[model.disc]\nthicknes = 0.1\n[axes]",
            &["job.toml:4:1", "unknown key `thicknes`", "did you mean `thickness`?"],
        ),
        ("[axes]", "[model.disk]\nthickness = 0.1\n[axes]", &["unknown key `disk`", "did you mean `disc`?"]),
        (
            "[axes]",
            "[model.friction]\nkinetic_coefficient = 0.5\n[axes]",
            &["friction.kinetic_coefficient = 0.5", "must be at most", "0.27"],
        ),
        (
            "[axes]",
            "[model.disc]\ninner_radius = 0.2\n[axes]",
            &["job.toml:4:16", "disc.inner_radius = 0.2 must be less than disc.outer_radius = 0.135"],
        ),
        ("name = \"bad\"", "name = \"../evil\"", &["job.toml:1:8", "cannot name a run directory"]),
        ("name = \"bad\"\n", "", &["missing key `name`"]),
        ("name = \"bad\"", "name = \"bad", &["job.toml:1"]),
        ("points = 3 }\nstatic", "points = 4000000000 }\nstatic", &["too many"]),
        ("points = 3", "points = 2000", &["4000000 cells", "limit is 1000000"]),
    ];
    for (from, to, texts) in cases {
        let place = Place::new();
        assert!(good.contains(from), "{from}");
        place.write("job.toml", &good.replace(from, to));
        for command in ["submit job.toml", "check job.toml"] {
            place.run(command).refused(65, texts);
        }
        assert!(!place.path("runs").exists(), "nothing is left behind by {to}");
    }
}

#[test]
fn files_and_directories_that_are_not_what_they_should_be() {
    let place = Place::new();
    place.write("job.toml", &surface_job("paths", 3, 100, 7));
    place.run("submit missing.toml").refused(74, &["cannot read missing.toml"]);
    place.run("submit .").refused(74, &["cannot read ."]);
    place.write("file", "precious");
    place.run("submit job.toml --out file").refused(73, &["file is a file"]);
    assert_eq!(fs::read_to_string(place.path("file")).unwrap(), "precious");
    place.run("submit job.toml --out file/below").refused(73, &["cannot create file/below"]);
    fs::create_dir(place.path("mine")).unwrap();
    place.write("mine/thesis.tex", "precious");
    place.run("submit job.toml --out mine").refused(73, &["mine is not empty and not a run directory"]);
    assert_eq!(fs::read_dir(place.path("mine")).unwrap().count(), 1);
    for command in ["resume", "status", "merge"] {
        place.run(&format!("{command} nowhere")).refused(74, &["nowhere is not a run directory: it does not exist"]);
        place
            .run(&format!("{command} mine"))
            .refused(74, &["mine is not a run directory: it has neither job.toml nor shards/"]);
        place.run(&format!("{command} file")).refused(74, &["file is not a run directory: it is a file"]);
    }
    place.write("binary.toml", "\u{0}\u{1}");
    place.run("submit binary.toml").refused(65, &["binary.toml:1"]);
    place.write("curve.csv", "# measured\nspeed;coefficient\n0,0;0,4940\n0,05;0,4525\n");
    let told = place.run("check curve.csv").refused(65, &["curve.csv:2: this is no job", "\"speed;coefficient\""]);
    assert_eq!(told.stderr.lines().count(), 1, "{}", told.stderr);
    place.write("dotted.toml", "model = { preset = sui-ding }\ncriterion.kind = \"eigenvalue\"\n");
    let told = place.run("check dotted.toml").refused(65, &["dotted.toml:1:"]);
    assert!(!told.stderr.contains("no job"), "{}", told.stderr);
    fs::write(place.path("latin1.toml"), b"name = \"caf\xe9\"").unwrap();
    place.run("submit latin1.toml").refused(74, &["cannot read latin1.toml", "UTF-8"]);
}

#[test]
fn usage_errors_exit_with_64() {
    let place = Place::new();
    place.write("job.toml", &surface_job("usage", 3, 100, 7));
    for words in [
        "",
        "sumbit job.toml",
        "submit",
        "submit job.toml --threads 0",
        "submit job.toml --threads many",
        "submit job.toml --shard 5/4",
        "submit job.toml --seed 18446744073709551615",
        "reproduce fig99",
        "analyse --set friction.static_coefficient",
        "analyse --set friction.static_coefficient=high",
        "analyse --set friction.static_coefficient=nan",
        "analyse --set disc.inner_radius=0.2",
    ] {
        place.run(words).refused(64, &[]);
    }
    place.run("analyse --set friction.static_coeficient=0.4").refused(64, &["did you mean `static_coefficient`?"]);
    place.run("analyse --set static_coefficient=0.4").refused(64, &["did you mean `friction.static_coefficient`?"]);
    place.run("").refused(64, &["there is no command", "stickslip init --from fig14a", "stickslip help"]);
    place.run("--version").done();
    assert!(place.run("submit --help").done().stdout.contains("--shard"));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_full_standard_output_is_an_error_line_one_without_a_reader_is_none_and_nothing_is_lost() {
    let place = Place::new();
    place.write("job.toml", &surface_job("output", 3, 100, 7));
    let full = || Stdio::from(OpenOptions::new().write(true).open("/dev/full").unwrap());
    for words in
        ["schema", "man", "completions bash", "analyse", "check job.toml", "submit job.toml", "status runs/output"]
    {
        let output = place.command(words).stdout(full()).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(74), "{words}: {stderr}");
        assert!(
            stderr.contains("cannot write to standard output") && !stderr.contains("panicked"),
            "{words}: {stderr}"
        );

        // A pipe that nobody reads, as after `| head`.
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = place.command(words).stdout(writer).output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        // As of a tool that SIGPIPE ended.
        assert_eq!(output.status.code(), Some(141), "{words}: {stderr}");
        assert!(!stderr.contains("standard output") && !stderr.contains("panicked"), "{words}: {stderr}");
    }
    // The run itself was finished before its report failed.
    assert!(place.run("status runs/output").done().stdout.contains("finished"));
    // Nobody to hear complaints either.
    let status = place.command("submit missing.toml").stdout(full()).stderr(full()).status().unwrap();
    assert_eq!(status.code(), Some(74));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_directory_in_use_is_refused() {
    let place = Place::new();
    // Long enough to be in use while the second command looks, and ended by hand.
    place.write("job.toml", &surface_job("busy", 10, 1_000_000_000, 7));
    let mut child = place.command("submit job.toml").stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for("its job", &mut child, || place.path("runs/busy/job.toml").exists());
    // It is in use as well while it does nothing, for which the other tests need not wait.
    send(&child, "STOP");
    for words in ["submit job.toml", "resume runs/busy", "merge runs/busy --wait 0", "submit job.toml --shard 1/2"] {
        place.run(words).refused(75, &["runs/busy is in use"]);
    }
    let status = place.run("status runs/busy --json").done();
    assert!(status.stdout.contains("\"state\": \"running\""), "{}", status.stdout);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(place.run("status runs/busy").done().stdout.contains("unfinished"));
}

// That all of the shipped jobs are those that `check` shows of them is tested beside the code.
#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn check_shows_a_job_that_can_itself_be_submitted() {
    let place = Place::new();
    let job = repository().join("jobs/fig14a.toml").display().to_string();
    let shown = place.run(&format!("check --all {job}")).done().stdout;
    place.write("normalised.toml", &shown);
    let again = place.run("check --all normalised.toml").done().stdout;
    let body = |text: &str| text.lines().filter(|line| !line.starts_with('#')).map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(body(&again), body(&shown));
    place.run(&format!("submit {job} --samples 10")).done();
    // Both forms are one job: the run is there already.
    let again = place.run("submit normalised.toml --samples 10").done();
    assert!(again.stderr.contains("runs/fig14a is finished already"), "{again:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn check_predicts_the_time_of_a_run_with_every_method() {
    let place = Place::new();
    let matrices = "[model]\nkind = \"matrices\"\nmass = { matrix = [[1.0, 0.0], [0.0, 1.0]] }\n\
        damping = { matrix = [[0.01, 0.0], [0.0, 0.01]] }\n\
        stiffness = [{ matrix = [[2.0, 1.0], [1.0, 2.0]] }, { matrix = [[0.0, -1.3], [0.0, 0.0]], factor = \"friction\" }]\n\
        [model.parameters]\nfriction = 0.6\n[random]\ninputs = [\"friction\"]\nrelative_std = 0.1\n\
        [criterion]\nkind = \"complex-eigenvalue\"\n";
    let pad = "[random]\ninputs = [\"preload\", \"static_friction\", \"damping.tangential\"]\nrelative_std = 0.1\n\
        [criterion]\nkind = \"eigenvalue\"\n";
    let plain = pad.replace(", \"damping.tangential\"", "");
    for (model, sampling, draws_samples) in [
        (matrices, "samples = 100", true),
        (matrices, "method = \"exact\"", false),
        (pad, "samples = 1000", true),
        (plain.as_str(), "method = \"exact\"", false),
        (pad, "method = \"conditional\"\nsamples = 256", true),
        (pad, "method = \"importance\"\nparticles = 100\nsamples = 256", true),
        (pad, "method = \"subset\"\nparticles = 100", true),
        (pad, "until = { half_width = 0.1, at_most = 1000 }", true),
    ] {
        place.write("job.toml", &format!("name = \"job\"\n{model}[sampling]\n{sampling}\n"));
        let said = place.run("check job.toml --threads 1 --json").done().stdout;
        let said: serde_json::Value = serde_json::from_str(&said).unwrap();
        let number = |key: &str| said[key].as_f64().unwrap_or_else(|| panic!("{sampling}: no {key} in {said}"));
        let [low, seconds, high] = ["seconds_low", "seconds", "seconds_high"].map(number);
        assert!(0.0 < low && low < seconds && seconds < high && number("seconds_of_set_up") <= seconds, "{said}");
        assert!(said["not_known_because"].is_null(), "{said}");
        assert_eq!(said["seconds_of_a_sample"].as_f64().is_some(), draws_samples, "{said}");
        let said = place.run("check job.toml --threads 1").done().stdout;
        assert!(!said.contains("at least") && said.contains(" on 1 thread"), "{said}");
    }
    // Limits take longer than the surface: the probability is estimated at more values.
    let model = pad.replace("[random]", "[axes]\npreload = [0.05, 0.3]\n[random]");
    let job = format!("name = \"job\"\n{model}[sampling]\nmethod = \"conditional\"\nsamples = 256\n");
    let [alone, with_limits] = ["", "[limit]\nof = \"preload\"\nprobability = 0.01\n"].map(|limit| {
        place.write("job.toml", &format!("{job}{limit}"));
        let said = place.run("check job.toml --threads 1 --json").done().stdout;
        let said: serde_json::Value = serde_json::from_str(&said).unwrap();
        said["seconds"].as_f64().unwrap() - said["seconds_of_set_up"].as_f64().unwrap()
    });
    assert!(with_limits > 2.0 * alone, "{with_limits} {alone}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn shipped_jobs_are_checked_without_a_warning_and_run() {
    let place = Place::new();
    for entry in fs::read_dir(repository().join("jobs")).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_none_or(|extension| extension != "toml") {
            continue;
        }
        let job = path.display();
        let name = path.file_stem().unwrap().to_str().unwrap();
        let checked = place.run(&format!("check {job}")).done();
        assert!(!checked.stderr.contains("warning"), "{}", checked.stderr);
        let costs = ["samples/s on one, measured now", "# no samples: ", "in a time that is not known"];
        assert!(costs.iter().any(|cost| checked.stdout.contains(cost)), "{}", checked.stdout);
        if name == "mission" && !checked.stdout.contains("in a time that is not known") {
            let limits = " more for the limits of preload in 5 combinations";
            assert!(checked.stdout.contains(limits), "{}", checked.stdout);
        }
        let samples = match name {
            // They take half a minute: see `tests/numbers/matrices.rs`, and below.
            "tu-brake" | "mission" => continue,
            // A sample of each of its bands takes a second.
            "own-brake" => "--samples 1",
            "parking-map" => "",
            _ => "--samples 10",
        };
        let submitted = place.run(&format!("submit {job} {samples}")).done();
        assert!(!submitted.stderr.contains("warning"), "{}", submitted.stderr);
        assert!(place.path("runs").join(name).join("surface.parquet").exists());
    }
    // At one of its speeds.
    let mission = fs::read_to_string(repository().join("jobs/mission.toml")).unwrap();
    let speeds = "rotating_speed = [10.0, 12.5, 15.0, 17.5, 20.0]";
    assert!(mission.contains(speeds));
    place.write("mission.toml", &mission.replace(speeds, "rotating_speed = 15.0"));
    fs::copy(repository().join("jobs/mission-friction.csv"), place.path("mission-friction.csv")).unwrap();
    place.run("submit mission.toml --samples 1024").done();
    assert!(place.path("runs/mission/limits.parquet").exists());
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn jobs_in_time_outside_the_tested_range_are_warned_of_and_run() {
    let place = Place::new();
    // The slow end of the axis is covered, the fast one is 1875 Stribeck velocities.
    let job = surface_job("beyond", 2, 10, 7)
        .replace("rotating_speed = 15.0", "rotating_speed = [15.0, 10000.0]")
        .replace("[axes]", "[model.damping]\ntangential = 1.0\n\n[axes]");
    place.write("eigenvalue.toml", &job);
    place.write("job.toml", &job.replace("\"eigenvalue\"", "\"time-domain\"\ndisc = \"rigid\""));
    for command in ["check", "submit"] {
        let said = place.run(&format!("{command} job.toml")).done().stderr;
        for text in [
            "warning: v / v_s = 1.8750e3 is above 1000",
            "warning: the damping ratio of the tangential motion = 2.1543e-4 is below 0.001",
            "stickslip trajectory",
            "tenfold criterion.horizon",
        ] {
            assert_eq!(said.matches(text).count(), if text.starts_with("warning") { 1 } else { 2 }, "{text}: {said}");
        }
        let closed_form = place.run(&format!(
            "{command} eigenvalue.toml --threads 1 {}",
            if command == "submit" { "--out e" } else { "" }
        ));
        assert!(!closed_form.done().stderr.contains("verdicts in time"));
    }
}

#[test]
fn command_line_changes_are_frozen_with_the_comments() {
    let place = Place::new();
    let job = repository().join("jobs/fig14a.toml");
    place.run(&format!("submit {} --seed 99 --samples 20 --out changed", job.display())).done();
    let frozen = fs::read_to_string(place.path("changed/job.toml")).unwrap();
    assert!(frozen.contains("seed = 99") && frozen.contains("samples = 20"), "{frozen}");
    assert!(frozen.contains("# the same seed gives the same result on every machine"), "{frozen}");
    place.run("resume changed").done();
}

#[test]
fn analyse_reports_the_printed_numbers() {
    let place = Place::new();
    let json: serde_json::Value = serde_json::from_str(&place.run("analyse --json").done().stdout).unwrap();
    assert!((json["critical_speed_rad_s"].as_f64().unwrap() - 15.56).abs() < 5e-3);
    assert!((json["saddle_node_speed_rad_s"].as_f64().unwrap() - 30.197).abs() < 0.01);
    assert_eq!(json["stable"], true);
    assert_eq!(json["eigenvalues"].as_array().unwrap().len(), 6);
    let fast: serde_json::Value =
        serde_json::from_str(&place.run("analyse --set operating_point.rotating_speed=35 --json").done().stdout)
            .unwrap();
    assert!((fast["equilibrium"]["x"].as_f64().unwrap() - 8.15e-3).abs() < 5e-6);
    assert!(fast["limit_cycle"].is_null());
    // Above the saddle-node every motion returns; below the critical speed none does.
    assert!(fast["smallest_knock"].is_null() && fast["basin_area"].is_null());
    let slow: serde_json::Value =
        serde_json::from_str(&place.run("analyse --set operating_point.rotating_speed=10 --json").done().stdout)
            .unwrap();
    assert_eq!((slow["smallest_knock"]["speed"].as_f64(), slow["basin_area"].as_f64()), (Some(0.0), Some(0.0)));
    // In between, SciPy 1.17.1 (solve_ivp with DOP853, rtol 1e-13) at 16 rad/s.
    for (value, expected) in [
        (&json["smallest_knock"]["speed"], 0.002648059029),
        (&json["smallest_knock"]["displacement"], 0.001217401500),
        (&json["basin_area"], 1.0593414950e-5),
    ] {
        assert!((value.as_f64().unwrap() / expected - 1.0).abs() < 1e-8, "{value} {expected}");
    }
    let flat: serde_json::Value =
        serde_json::from_str(&place.run("analyse --set friction.kinetic_coefficient=0.39 --json").done().stdout)
            .unwrap();
    assert!(flat["critical_speed_rad_s"].is_null() && flat["saddle_node_speed_rad_s"].is_null());
    let text = place.run("analyse --set operating_point.rotating_speed=10").done().stdout;
    assert!(text.contains("UNSTABLE") && text.contains("15.5599 rad/s"), "{text}");
}

#[test]
fn the_schema_knows_every_key_of_the_example() {
    let place = Place::new();
    let schema: serde_json::Value = serde_json::from_str(&place.run("schema").done().stdout).unwrap();
    let text = schema.to_string();
    for key in
        ["rotating_speed", "relative_std", "stribeck_velocity", "common_random_numbers", "confidence", "thickness"]
    {
        assert!(text.contains(&format!("\"{key}\"")), "{key}");
    }
    assert_eq!(schema["additionalProperties"], false);
}

#[test]
fn completions_and_manual_cover_every_command() {
    let place = Place::new();
    let manual = place.run("man").done().stdout;
    for shell in ["bash", "zsh", "fish"] {
        let script = place.run(&format!("completions {shell}")).done().stdout;
        for command in ["submit", "resume", "status", "check", "analyse", "reproduce", "merge"] {
            assert!(script.contains(command), "{shell} {command}");
            assert!(manual.contains(&format!("stickslip\\-{command}")), "{command}");
        }
    }
}

#[test]
fn every_command_has_a_manual_page_of_its_own() {
    let place = Place::new();
    let outcome = place.run("man --out share/man/man1").done();
    assert!(outcome.stdout.contains("share/man/man1"), "{}", outcome.stdout);
    let read = |name: &str| fs::read_to_string(place.path("share/man/man1").join(name)).unwrap();
    let main = read("stickslip.1");
    assert!(main.contains(".TH stickslip 1"), "{main}");
    assert!(main.contains(".SH \"EXIT STATUS\"\nExit codes: 0 done"), "{main}");
    let commands = commands_of_the_program(&place);
    for command in &commands {
        let page = read(&format!("stickslip-{command}.1"));
        assert!(page.contains(&format!(".TH stickslip-{command} 1")), "{page}");
        assert!(page.contains(&format!(".SH EXAMPLES\n  stickslip {command}")), "{page}");
        // The main page names all others.
        assert!(main.contains(&format!("stickslip\\-{command}(1)")), "{command}: {main}");
    }
    assert_eq!(fs::read_dir(place.path("share/man/man1")).unwrap().count(), commands.len() + 1);
    // The text in one is the pages, one after the other.
    assert!(place.run("man").done().stdout.starts_with(&main));

    place.write("file", "");
    place.run("man --out file").refused(73, &["cannot create file"]);
}

#[test]
fn parameters_beyond_the_range_of_numbers_are_refused_not_called_stable() {
    let place = Place::new();
    for change in
        ["disc.thickness=1e-200", "disc.density=1e-320", "pad.mass=1e-320", "stiffness.contact_tangential_1=1e-310"]
    {
        place.run(&format!("analyse --set {change}")).refused(64, &["too small or too large to compute with"]);
    }
    let job = surface_job("tiny", 3, 100, 7).replace("[axes]", "[model.disc]\nthickness = 1e-200\n\n[axes]");
    place.write("job.toml", &job);
    place.run("submit job.toml").refused(65, &["too small or too large to compute with"]);
}

#[test]
fn status_does_not_call_the_surface_of_a_smaller_run_finished() {
    let place = Place::new();
    place.write("job.toml", &surface_job("grown", 3, 100, 7));
    place.run("submit job.toml").done();
    for index in [1, 2] {
        place.run(&format!("submit job.toml --samples 2000 --shard {index}/2")).done();
    }
    let status = place.run("status runs/grown --json").done().stdout;
    assert!(status.contains("\"complete, not merged\"") && status.contains("\"surface\": null"), "{status}");
    place.run("merge runs/grown").done();
    assert!(place.run("status runs/grown").done().stdout.contains("finished"));
    assert_eq!(Table::read(&place.path("runs/grown/surface.parquet")).column("n_samples"), [2000.0; 9]);
}

#[test]
fn samples_that_the_job_does_not_ask_for_are_never_counted() {
    let place = Place::new();
    place.write("job.toml", &surface_job("odd", 3, 1000, 7));
    place.run("submit job.toml --shard 1/2").done();
    // Another number of samples cannot join an unfinished run, as a shard or otherwise.
    for words in ["submit job.toml --samples 2000 --shard 2/2", "submit job.toml --samples 2000"] {
        place.run(words).refused(73, &["unfinished run", "stickslip resume runs/odd"]);
    }
    place.run("submit job.toml --samples 500 --shard 2/2").refused(65, &["more than the 500 of this one"]);
    place.run("resume runs/odd").done();
    // Nor can a job be shrunk by hand, even if somebody lets the digests fit.
    fs::remove_file(place.path("runs/odd/digests.json")).unwrap();
    place.write("runs/odd/job.toml", &surface_job("odd", 3, 500, 7));
    for words in ["status runs/odd", "resume runs/odd", "merge runs/odd"] {
        place.run(words).refused(65, &["the pieces in shards hold sample 999", "the job has only 500 samples"]);
    }
    // Files of other programs are nobody's pieces.
    place.write("runs/odd/job.toml", &surface_job("odd", 3, 1000, 7));
    place.write("runs/odd/shards/.DS_Store", "finder");
    assert!(place.run("status runs/odd").done().stderr.is_empty());
}

#[test]
fn pieces_without_their_job_are_used_if_they_are_of_this_one_and_refused_otherwise() {
    let place = Place::new();
    place.write("job.toml", &surface_job("bare", 3, 1000, 7));
    place.run("submit job.toml").done();
    let before = place.surface("runs/bare");
    let strip = || {
        for name in ["job.toml", "surface.parquet", "run.json"] {
            let _ = fs::remove_file(place.path("runs/bare").join(name));
        }
    };
    strip();
    place.run("submit job.toml --seed 8").refused(65, &["belongs to another job", "--out"]);
    assert!(!place.path("runs/bare/job.toml").exists(), "nothing is written into a refused directory");
    place.run("submit job.toml --samples 500").refused(65, &["the job has only 500 samples"]);
    let outcome = place.run("submit job.toml").done();
    assert!(!outcome.stderr.contains("samples in"), "nothing is computed twice: {}", outcome.stderr);
    assert_eq!(place.surface("runs/bare"), before);
}

#[test]
fn an_extended_run_serves_its_reproduction() {
    let place = Place::new();
    let job = repository().join("jobs/table3.toml");
    place.run(&format!("submit {} --samples 20_000", job.display())).done();
    place.run(&format!("submit {}", job.display())).refused(65, &["with 20000 samples", "--samples 20000"]);
    assert!(place.run("reproduce table3").done().stdout.contains("cells of 20000 samples"));
}

#[test]
fn suggested_commands_can_be_pasted() {
    let place = Place::new();
    place.write("job.toml", &surface_job("spaces", 10, 1_000_000_000, 7));
    let mut child = place.command("submit job.toml --out");
    let mut child = child.arg("my runs").stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for("its job", &mut child, || place.path("my runs/job.toml").exists());
    child.kill().unwrap();
    child.wait().unwrap();
    let output = place.command("status").arg("my runs").output().unwrap();
    assert!(String::from_utf8(output.stdout).unwrap().contains("`stickslip resume 'my runs'`"));
}

#[test]
fn absurdly_large_jobs_start_and_stop_at_once() {
    let place = Place::new();
    place.write("job.toml", &surface_job("huge", 30, 1_000_000_000_000_000, 7));
    for words in ["submit job.toml --shard 1/4", "submit job.toml"] {
        let words = format!("{words} --out {}", if words.contains("shard") { "shards" } else { "whole" });
        let mut child = place.command(&words).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let run = words.rsplit(' ').next().unwrap();
        wait_for("its first piece", &mut child, || place.pieces(&format!("{run}/shards")) > 0);
        send(&child, "TERM");
        assert_eq!(child.wait().unwrap().code(), Some(143));
    }
}

#[test]
fn a_seed_that_toml_does_not_allow_does_not_swallow_the_command_line() {
    let place = Place::new();
    place.write("job.toml", &surface_job("large", 2, 100, 7).replace("seed = 7", "seed = 9223372036854775808"));
    place.run("submit job.toml --samples 500").refused(65, &["job.toml: --seed and --samples cannot be noted in it"]);
    assert!(!place.path("runs/large").exists());
}

#[test]
fn a_renamed_job_does_not_rename_a_finished_run() {
    let place = Place::new();
    let text = surface_job("before", 2, 100, 7);
    place.write("job.toml", &text);
    place.run("submit job.toml --out run").done();
    let surface = place.surface("run");
    place.write("job.toml", &text.replace("before", "after"));
    let outcome = place.run("submit job.toml --out run").done();
    assert!(outcome.stderr.contains("nothing to do") && !outcome.stderr.contains("anew"), "{}", outcome.stderr);
    assert!(place.surface("run") == surface && fs::read_to_string(place.path("run/job.toml")).unwrap() == text);
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn what_has_no_verdict_is_not_drawn_as_safe() {
    let place = Place::new();
    let text = surface_job("short", 3, 200, 7)
        .replace("kind = \"eigenvalue\"", "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"\nhorizon = 0.5");
    assert!(text.contains("horizon"), "{text}");
    place.write("job.toml", &text);
    let outcome = place.run("submit job.toml").done();
    assert!(outcome.stdout.contains("0.4500?"), "{}", outcome.stdout);
    assert!(outcome.stdout.contains("? more than 10 % of the samples undecided or failed"), "{}", outcome.stdout);
    assert!(place.run("check job.toml").done().stdout.contains(": 1 rotating speed x 1 standard deviation x "));
    place.write(
        "sobol.toml",
        &surface_job("sobol", 2, 137_438_953_472, 7).replace("[sampling]", "[sampling]\nmethod = \"sobol\""),
    );
    place.run("check sobol.toml").refused(65, &["137438953472 are too many for 16 randomisations", "68719476736"]);
}

#[test]
fn replay_says_whether_a_sample_is_counted() {
    let place = Place::new();
    let job = surface_job("part", 2, 1000, 3);
    place.write("job.toml", &job);
    place.run("submit job.toml --shard 1/4").done();
    let verdicts: Vec<bool> = (0..4)
        .map(|cell| {
            let replayed = place.run(&format!("replay runs/part --cell {cell} --sample 7 --horizon 5 --json")).done();
            let replayed: serde_json::Value = serde_json::from_str(&replayed.stdout).unwrap();
            replayed["verdict_in_run"] != "not counted yet"
        })
        .collect();
    assert_eq!(verdicts.iter().filter(|&&counted| counted).count(), 1, "{verdicts:?}");
    // Pieces of another job are not those of this run, even if somebody lets the digests fit.
    fs::remove_file(place.path("runs/part/digests.json")).unwrap();
    let frozen = fs::read_to_string(place.path("runs/part/job.toml")).unwrap();
    place.write("runs/part/job.toml", &frozen.replace("seed = 3", "seed = 4"));
    place.run("replay runs/part --cell 0 --sample 7").refused(65, &["another job"]);
}
