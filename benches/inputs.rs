//! `make bench`: what more random inputs and other friction laws cost, as ratios of samples per second.
//!
//! Whole processes on one thread are timed, alternately. With `STICKSLIP_BEFORE=PATH`, another build of the program
//! runs the same jobs with fewer samples, and its ratios are printed too.

#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark that cannot run should say so and stop")]

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

/// Rounds in which every job runs once.
const ROUNDS: usize = 5;

/// By how much fewer samples another build gets, since one that follows eight inputs one by one takes minutes.
const FEWER_BEFORE: u64 = 30;

const TWO: &str = r#"inputs = ["preload", "static_friction"]"#;

const EIGHT: &str = r#"inputs = ["preload", "static_friction", "friction.kinetic_coefficient",
  "friction.stribeck_velocity", "damping.tangential", "stiffness.contact_normal", "disc.youngs_modulus", "rotating_speed"]"#;

/// A criterion, with samples for about a second.
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    criterion: &'static str,
    rotating_speed: f64,
    samples: u64,
    /// Least ratio of samples per second, eight inputs over two.
    wanted: f64,
}

const CASES: [Case; 4] = [
    Case {
        name: "eigenvalue",
        criterion: "kind = \"eigenvalue\"",
        rotating_speed: 15.0,
        samples: 40_000_000,
        wanted: 0.25,
    },
    Case {
        name: "coupled eigenvalue",
        criterion: "kind = \"coupled-eigenvalue\"",
        rotating_speed: 15.0,
        samples: 100_000,
        wanted: 0.7,
    },
    Case {
        name: "rigid disc in time",
        criterion: "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"",
        rotating_speed: 22.0,
        samples: 200_000,
        wanted: 0.8,
    },
    Case {
        name: "flexible disc in time",
        criterion: "kind = \"time-domain\"\ndisc = \"flexible\"\nstart = \"rest\"",
        rotating_speed: 22.0,
        samples: 3000,
        wanted: 0.7,
    },
];

/// Laws, with their least ratio of samples per second over exponent 1.
const LAWS: [(&str, &str, f64); 5] = [
    ("exponent 1", "", 1.0),
    ("exponent 2", "stribeck_exponent = 2.0", 0.9),
    ("exponent 1.3", "stribeck_exponent = 1.3", 0.6),
    ("rational law", "law = \"rational\"", 0.6),
    (
        "measured curve",
        "law = \"table\"\ntable = { speed = [0.0, 0.3, 0.7, 1.2, 2.0, 3.0, 5.0, 8.0], coefficient = [0.39, 0.345, 0.305, 0.28, 0.265, 0.257, 0.252, 0.25] }",
        0.6,
    ),
];

fn main() {
    // `cargo test --benches` passes --test; there is nothing to measure then.
    if env::args().any(|argument| argument == "--test") {
        return;
    }
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let now = Program { path: env!("CARGO_BIN_EXE_stickslip").into(), directory: directory.path().into() };
    let before =
        env::var_os("STICKSLIP_BEFORE").map(|path| Program { path: path.into(), directory: directory.path().into() });
    for case in &CASES {
        let jobs = [TWO, EIGHT].map(|inputs| job(case, inputs, ""));
        compare(case.name, "eight random inputs over two", &now, &jobs, case, case.wanted);
        if let Some(before) = &before {
            let case = Case { samples: case.samples / FEWER_BEFORE, ..*case };
            let jobs = [TWO, EIGHT].map(|inputs| job(&case, inputs, ""));
            compare(case.name, "the same before", before, &jobs, &case, 0.0);
        }
    }
    for case in &CASES[2..] {
        for (name, law, wanted) in &LAWS[1..] {
            let jobs = ["", law].map(|law| job(case, TWO, law));
            compare(case.name, &format!("{name} over exponent 1"), &now, &jobs, case, *wanted);
        }
    }
}

fn job(case: &Case, inputs: &str, law: &str) -> String {
    format!(
        "name = \"bench\"\n[model.friction]\n{law}\n[axes]\nrotating_speed = {}\npreload = 0.1\nstatic_friction = 0.39\n\
         [random]\n{inputs}\nrelative_std = 0.1\n[criterion]\n{}\n[sampling]\nsamples = {}\nseed = 1\n",
        case.rotating_speed, case.criterion, case.samples
    )
}

/// Prints the rates of two jobs, and their ratio.
fn compare(case: &str, what: &str, program: &Program, jobs: &[String; 2], of: &Case, wanted: f64) {
    let mut seconds = [Vec::new(), Vec::new()];
    let mut ratios = Vec::new();
    for _ in 0..ROUNDS {
        let [first, second] = [0, 1].map(|i| program.seconds(&jobs[i]));
        seconds[0].push(first);
        seconds[1].push(second);
        ratios.push(first / second);
    }
    let [first, second] = seconds.map(|times| of.samples as f64 / median(times));
    let limit = if wanted > 0.0 { format!(" (at least {wanted})") } else { String::new() };
    println!("{:<74} {:>12.3} times", format!("{case}: {what}{limit}"), median(ratios));
    println!("{:<74} {first:>12.0} and {second:.0} samples/s", "");
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

struct Program {
    path: PathBuf,
    directory: PathBuf,
}

impl Program {
    /// The time of a whole run on one thread.
    fn seconds(&self, job: &str) -> f64 {
        let file = self.directory.join("job.toml");
        let out = self.directory.join("run");
        fs::write(&file, job).expect("the job file can be written");
        let _ = fs::remove_dir_all(&out);
        let started = Instant::now();
        let status = Command::new(&self.path)
            .args([Path::new("submit"), &file, Path::new("--threads"), Path::new("1"), Path::new("--out"), &out])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .expect("stickslip starts");
        assert!(status.success(), "stickslip refuses\n{job}");
        started.elapsed().as_secs_f64()
    }
}
