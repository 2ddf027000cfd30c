//! `make bench`: the cost of a surface by each method at equal error, and of the surfaces of Figures 14 and 15 in the
//! time domain. Whole processes are timed. Errors are relative to the exact integral, in closed form or over the
//! verdict map.

#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark that cannot run should say so and stop")]

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use arrow::array::Float64Array;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::Value;

/// Root mean square error over the cells that every method must reach.
const TARGET: f64 = 1e-3;

/// Largest number of samples in a cell.
const MOST_SAMPLES: u64 = 1 << 22;

fn main() {
    // `cargo test --benches` passes --test; there is nothing to measure then.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    equal_error("eigenvalue", "kind = \"eigenvalue\"", &["monte-carlo", "sobol", "until", "exact"]);
    let from_rest = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"";
    equal_error(
        "rigid disc in time, from rest",
        from_rest,
        &["monte-carlo", "sobol", "boundary", "sobol-boundary", "exact"],
    );
    figures();
}

/// A finished run.
struct Run {
    seconds: f64,
    samples: f64,
    /// Samples and points of maps that were simulated or decided in closed form.
    decided: f64,
    probabilities: Vec<f64>,
}

fn submit(directory: &Path, name: &str, text: &str) -> Run {
    let job = directory.join(format!("{name}.toml"));
    let out: PathBuf = directory.join(name);
    let _ = fs::remove_dir_all(&out);
    fs::write(&job, text).expect("the job file can be written");
    let started = Instant::now();
    let done = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args([Path::new("submit"), &job, Path::new("--out"), &out])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .expect("stickslip starts");
    let seconds = started.elapsed().as_secs_f64();
    assert!(done.success(), "stickslip failed on {name}");
    let record = fs::read_to_string(out.join("run.json")).expect("a finished run has a record");
    let record: Value = serde_json::from_str(&record).expect("the record is JSON");
    let session = &record["sessions"][0];
    let number = |key: &str| session[key].as_f64().unwrap_or(0.0);
    let samples = number("samples_computed");
    let looked_up = session["map_simulations"].is_number();
    let decided = if looked_up {
        number("map_simulations") + number("lookups_simulated") + number("lookups_audited")
    } else {
        samples
    };
    let file = File::open(out.join("surface.parquet")).expect("a finished run has a surface");
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).and_then(ParquetRecordBatchReaderBuilder::build);
    let mut probabilities = Vec::new();
    for batch in reader.expect("the surface is Parquet") {
        let batch = batch.expect("the surface can be read");
        let column = batch.column_by_name("p_unstable").expect("the surface has probabilities");
        let column = column.as_any().downcast_ref::<Float64Array>().expect("probabilities are numbers");
        probabilities.extend(column.values());
    }
    Run { seconds, samples, decided, probabilities }
}

fn surface(criterion: &str, sampling: &str) -> String {
    format!(
        "name = \"methods\"\n[axes]\nrotating_speed = 15.0\npreload = {{ from = 0.03, to = 0.30, points = 10 }}\n\
         static_friction = {{ from = 0.27, to = 0.50, points = 9 }}\n[random]\ninputs = [\"preload\", \"static_friction\"]\n\
         relative_std = 0.2\n[criterion]\n{criterion}\n[sampling]\n{sampling}\n"
    )
}

/// Runs each method with as many samples as the target needs, doubling them.
fn equal_error(name: &str, criterion: &str, methods: &[&str]) {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let exact = submit(directory.path(), "exact", &surface(criterion, "method = \"exact\""));
    println!("{name}: 90 cells, root mean square error {TARGET} or less");
    println!("  {:<16} {:>14} {:>14} {:>10} {:>12}", "method", "samples", "decided", "seconds", "error");
    for &method in methods {
        let mut samples = 1024;
        let (run, error) = loop {
            let sampling = match method {
                "exact" => "method = \"exact\"".to_owned(),
                "sobol" => format!("method = \"sobol\"\nsamples = {samples}"),
                "boundary" => format!("evaluate = \"boundary\"\nsamples = {samples}"),
                "sobol-boundary" => format!("method = \"sobol\"\nevaluate = \"boundary\"\nsamples = {samples}"),
                // The half width of 95 % that goes with the target where the probability is one half.
                "until" => format!("until = {{ half_width = {}, at_most = {MOST_SAMPLES} }}", 1.96 * TARGET),
                _ => format!("samples = {samples}"),
            };
            let run = submit(directory.path(), method, &surface(criterion, &sampling));
            let squares: f64 =
                run.probabilities.iter().zip(&exact.probabilities).map(|(p, exact)| (p - exact) * (p - exact)).sum();
            let error = (squares / exact.probabilities.len() as f64).sqrt();
            let is_fixed = ["exact", "until"].contains(&method);
            if error <= TARGET || is_fixed || samples >= MOST_SAMPLES {
                break (run, error);
            }
            samples *= 2;
        };
        println!("  {method:<16} {:>14.0} {:>14.0} {:>10.3} {error:>12.1e}", run.samples, run.decided, run.seconds);
    }
}

/// All six surfaces of Figures 14 and 15 in the time domain, with verdict maps.
fn figures() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let jobs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../jobs");
    let mut total = 0.0;
    for name in ["fig14a", "fig14b", "fig14c", "fig14d", "fig15a", "fig15b"] {
        let text = fs::read_to_string(jobs.join(format!("{name}.toml"))).expect("the job is there");
        let text = text
            .replace("kind = \"eigenvalue\"", "kind = \"time-domain\"")
            .replace("seed = 2018", "seed = 2018\nevaluate = \"boundary\"");
        let run = submit(directory.path(), name, &text);
        total += run.seconds;
        println!(
            "{name} in time, flexible disc, evaluate = \"boundary\": {:.1} s, {:.0} samples, {:.0} simulations",
            run.seconds, run.samples, run.decided
        );
    }
    println!("all six surfaces of Figures 14 and 15 in time (limit 60): {total:.1} s");
}
