//! `make bench`: one line for each figure: name, value, unit. Ratios are taken pairwise in this one run; absolute
//! values belong to the machine.

#![allow(clippy::expect_used, clippy::print_stdout, reason = "a benchmark that cannot run should say so and stop")]

use std::fs;
use std::hint::black_box;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use rand::RngExt as _;
use rand_distr::StandardNormal;
use stickslip_core::{PadOnDisc, Parameters, VerdictCounts};
use stickslip_sampler::identity::block_generator;
use stickslip_sampler::{BLOCK_SAMPLES, Cell, Purpose, RelativeStd, SampleStream};

const CELL: Cell = Cell {
    index: 17,
    rotating_speed: 15.0,
    relative_std: RelativeStd { preload: 0.2, static_friction: 0.2 },
    preload: 0.1,
    static_friction: 0.39,
};

fn figure(name: &str, value: f64, unit: &str) {
    let digits = if value >= 1000.0 { 0 } else { 3 };
    println!("{name:<58} {value:>16.digits$} {unit}");
}

fn main() {
    // `cargo test --benches` runs this with --test: nothing to measure then.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    sampling();
    threads();
    memory();
    start_up();
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Seconds that `work` takes.
fn seconds(work: impl FnOnce()) -> f64 {
    let started = Instant::now();
    work();
    started.elapsed().as_secs_f64()
}

/// The loop over samples on one thread, with and without the verdict, in turn.
fn sampling() {
    const SAMPLES: u64 = 10_000_000;
    let mut parameters = Parameters::sui_ding_2018();
    parameters.operating_point.rotating_speed = CELL.rotating_speed;
    let boundary = PadOnDisc::new(parameters).expect("the preset is valid").stability_boundary();
    let stream = SampleStream {
        seed: 2018,
        common_random_numbers: false,
        preload_is_random: true,
        static_friction_is_random: true,
    };
    let judged = || {
        let mut counts = VerdictCounts::default();
        stream.for_each(&CELL, 0..SAMPLES, |samples| {
            counts += boundary.count(samples.preloads, samples.static_frictions);
        });
        black_box(counts);
    };
    // The same blocks and the same deviates, and nothing else.
    let raw = || {
        let mut deviates = [[0.0_f64; 2]; 250];
        for block in 0..SAMPLES / BLOCK_SAMPLES {
            let mut generator = block_generator(2018, Purpose::Inputs, CELL.index, block);
            for _ in 0..BLOCK_SAMPLES / 250 {
                for pair in &mut deviates {
                    *pair = [generator.sample(StandardNormal), generator.sample(StandardNormal)];
                }
                black_box(&mut deviates);
            }
        }
    };
    let (mut judged_times, mut raw_times, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..15 {
        let (with, without) = (seconds(judged), seconds(raw));
        judged_times.push(with);
        raw_times.push(without);
        ratios.push(with / without);
    }
    figure("samples with verdict, one thread", SAMPLES as f64 / median(judged_times), "samples/s");
    figure("two normal deviates only, one thread", SAMPLES as f64 / median(raw_times), "samples/s");
    figure("verdict and bookkeeping over raw sampling (limit 0.2)", median(ratios) - 1.0, "of raw time");
}

/// A job file in a directory of its own.
fn job(directory: &Path, name: &str, cells: usize, samples: u64) -> std::path::PathBuf {
    let path = directory.join(format!("{name}.toml"));
    let text = format!(
        "name = \"{name}\"\n[axes]\nrotating_speed = 15.0\npreload = {{ from = 0.01, to = 0.30, points = {cells} }}\n\
         static_friction = {{ from = 0.25, to = 0.50, points = {cells} }}\n[random]\ninputs = [\"preload\", \
         \"static_friction\"]\nrelative_std = 0.2\n[criterion]\nkind = \"eigenvalue\"\n[sampling]\nsamples = {samples}\nseed = 1\n"
    );
    fs::write(&path, text).expect("the job file can be written");
    path
}

/// Runs a job to its end in a fresh directory; seconds and peak memory in MiB of the whole process.
fn submit(directory: &Path, job: &Path, threads: usize) -> (f64, f64) {
    let out = directory.join("run");
    let _ = fs::remove_dir_all(&out);
    let started = Instant::now();
    let mut child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .args([Path::new("submit"), job, Path::new("--out"), &out, Path::new("--threads")])
        .arg(threads.to_string())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("stickslip starts");
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0.0;
    loop {
        if let Some(done) = child.try_wait().expect("stickslip can be waited for") {
            assert!(done.success(), "stickslip failed");
            return (started.elapsed().as_secs_f64(), peak);
        }
        // The kernel's own high-water mark, so polling misses only the last moment.
        let text = fs::read_to_string(&status).unwrap_or_default();
        let mark =
            text.lines().find_map(|line| line.strip_prefix("VmHWM:")?.split_whitespace().next()?.parse::<f64>().ok());
        peak = mark.map_or(peak, |kib| kib / 1024.0);
        thread::sleep(Duration::from_millis(2));
    }
}

fn threads() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let job = job(directory.path(), "threads", 20, 1_000_000);
    let all = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let (mut one, mut two, mut every) = (Vec::new(), Vec::new(), Vec::new());
    let (mut ratios, mut limits) = (Vec::new(), Vec::new());
    for _ in 0..7 {
        let single = submit(directory.path(), &job, 1).0;
        let double = submit(directory.path(), &job, 2).0;
        // Two processes that share nothing: what the machine gives beyond one of its processors.
        let apart = ["a", "b"].map(|name| directory.path().join(name));
        let together = seconds(|| {
            thread::scope(|scope| {
                for path in &apart {
                    fs::create_dir_all(path).expect("a directory can be made");
                    let job = &job;
                    scope.spawn(move || submit(path, job, 1));
                }
            });
        });
        one.push(single);
        two.push(double);
        ratios.push(single / double);
        limits.push(2.0 * single / together);
        if all != 2 {
            every.push(submit(directory.path(), &job, all).0);
        }
    }
    let samples = 400.0 * 1e6;
    figure("whole run of 4e8 samples, 1 thread", samples / median(one), "samples/s");
    figure("whole run of 4e8 samples, 2 threads", samples / median(two), "samples/s");
    if all != 2 {
        figure(&format!("whole run of 4e8 samples, all {all} threads"), samples / median(every), "samples/s");
    }
    figure("two threads over one (at least 1.9)", median(ratios), "times");
    figure("two separate processes over one (the machine's limit)", median(limits), "times");
}

fn memory() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let all = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    for (exponent, samples) in [(9, 2_500_000), (10, 25_000_000)] {
        let job = job(directory.path(), &format!("memory-1e{exponent}"), 20, samples);
        let (time, peak) = submit(directory.path(), &job, all);
        figure(&format!("peak memory of a run of 1e{exponent} samples (limit 64)"), peak, "MiB");
        figure(&format!("whole run of 1e{exponent} samples, all threads"), time, "s");
    }
}

fn start_up() {
    let directory = tempfile::tempdir().expect("a temporary directory can be made");
    let job = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../jobs/table3.toml");
    let all = thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let times = (0..15).map(|_| submit(directory.path(), &job, all).0).collect();
    figure("start to result of jobs/table3.toml (limit 0.3)", median(times), "s");
}
