//! Determinism: the result of a job does not depend on threads, shards, interruptions, builds and processors.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]
#![allow(
    clippy::print_stdout,
    clippy::disallowed_methods,
    reason = "a child process reports; the platform is the control"
)]

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

use crate::common::{Place, Table, repository, send, surface_job, wait_for};
use stickslip_sampler::draw::deviates::{DeviateStream, Points};
use stickslip_sampler::inputs::{Correlation, InputColumns, Marginal};

/// Job specs whose columns are pinned, with the digest of every value. Regression values of results version 1: they
/// change only together with `RESULTS_VERSION`.
const GOLDEN: [(&str, &str); 3] = [
    ("fig14a", "24dbcf59c5c76f573f04203a1b4f66c3"),
    ("table3", "4bc9e806a3c265e0e127742fb9bb831f"),
    ("fig12", "cf4f2a136328bffd1e0068a6f4468dc3"),
];

#[test]
fn result_columns_are_pinned() {
    let place = Place::new();
    for (name, digest) in GOLDEN {
        place.run(&format!("submit {}", repository().join(format!("jobs/{name}.toml")).display())).done();
        let table = Table::read(&place.path(&format!("runs/{name}/surface.parquet")));
        assert_eq!(table.digest(), digest, "{name}");
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    let place = Place::new();
    place.write("job.toml", &surface_job("threads", 12, 30_500, 3));
    for threads in [1, 2, 3, 8] {
        place.run(&format!("submit job.toml --threads {threads} --out {threads}")).done();
        assert!(place.surface("1") == place.surface(&threads.to_string()), "{threads} threads");
    }
}

#[test]
fn repeated_runs_write_the_same_bytes() {
    // Random order in hash maps, time stamps and the like would differ here.
    let place = Place::new();
    place.write("job.toml", &surface_job("repeated", 4, 1000, 3));
    place.run("submit job.toml --out 0").done();
    for run in 1..20 {
        place.run(&format!("submit job.toml --out {run}")).done();
        assert!(place.surface("0") == place.surface(&run.to_string()), "run {run}");
    }
}

#[test]
fn shards_merged_in_any_order_do_not_change_a_byte() {
    let place = Place::new();
    // Cells of several units, so that shards share cells, too.
    let job = surface_job("shards", 4, 2_500_000, 3);
    place.write("job.toml", &job);
    place.run("submit job.toml --out whole").done();
    for (count, stride) in [(1, 1), (4, 3), (16, 5), (16, 11)] {
        let run = format!("in-{count}-by-{stride}");
        let missing = place.run(&format!("merge {run}"));
        assert_eq!(missing.code, Some(74));
        for step in 0..count {
            let index = (step * stride) % count + 1;
            place.run(&format!("submit job.toml --out {run} --shard {index}/{count}")).done();
            if step == 0 && count > 1 {
                place.run(&format!("merge {run}")).refused(65, &["is not complete", "stickslip resume"]);
            }
        }
        place.run(&format!("merge {run}")).done();
        assert!(place.surface("whole") == place.surface(&run), "{run}");
        // Shards that a batch system starts a second time change nothing.
        place.run(&format!("submit job.toml --out {run} --shard 1/{count}")).done();
        place.run(&format!("merge {run}")).done();
        assert!(place.surface("whole") == place.surface(&run), "{run}, twice");
    }
}

#[test]
fn shards_at_the_same_time_share_a_directory() {
    let place = Place::new();
    place.write("job.toml", &surface_job("together", 4, 2_500_000, 3));
    place.run("submit job.toml --out whole").done();
    let children: Vec<_> = (0..4)
        .map(|index| {
            let mut command = place.command(&format!("submit job.toml --out together --threads 1 --shard {index}/4"));
            command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
        })
        .collect();
    for mut child in children {
        assert!(child.wait().unwrap().success());
    }
    place.run("merge together").done();
    assert!(place.surface("whole") == place.surface("together"));
}

#[test]
fn kills_at_random_times_do_not_change_a_byte() {
    let place = Place::new();
    place.write("job.toml", &surface_job("killed", 20, 1_000_000, 3));
    place.run("submit job.toml --out whole").done();
    let mut command = place.begin_or_go_on("killed");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for("a piece", &mut child, || place.pieces("killed/shards") > 0);
    child.kill().unwrap();
    child.wait().unwrap();
    let status: serde_json::Value = serde_json::from_str(&place.run("status killed --json").done().stdout).unwrap();
    assert!(status["share_done"].as_f64().unwrap() > 0.0, "a killed run keeps what it had finished: {status}");
    let mut random = 0x9E37_79B9_7F4A_7C15_u64;
    let delays = [(); 12].map(|()| {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        5 + (random >> 33) % 245
    });
    place.assert_survives_kills("whole", &delays, 10);
    let left_behind = |directory: &str| {
        let entries = fs::read_dir(place.path(directory)).unwrap();
        entries.filter(|entry| entry.as_ref().unwrap().file_name().to_string_lossy().starts_with(".unfinished")).count()
    };
    assert_eq!(left_behind("killed") + left_behind("killed/shards"), 0, "the last run removes unfinished files");
}

#[test]
fn signals_keep_finished_work_and_print_how_to_continue() {
    let place = Place::new();
    place.write("job.toml", &surface_job("signalled", 20, 500_000, 3));
    place.run("submit job.toml --out whole").done();
    for (signal, code, word) in [("INT", 130, "interrupted"), ("TERM", 143, "terminated")] {
        let words = if signal == "INT" { "submit job.toml --threads 1" } else { "resume runs/signalled --threads 1" };
        let pieces = || place.pieces("runs/signalled/shards");
        let before = pieces();
        let mut child = place.command(words).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        wait_for("a piece", &mut child, || pieces() > before);
        send(&child, signal);
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{stderr}");
        assert!(stderr.contains(word) && stderr.contains("stickslip resume runs/signalled"), "{stderr}");
        assert!(!place.path("runs/signalled/surface.parquet").exists());
    }
    assert!(place.run("status runs/signalled").done().stdout.contains("unfinished"));
    place.run("resume runs/signalled").done();
    assert!(place.surface("whole") == place.surface("runs/signalled"));
}

#[test]
fn more_samples_extend_a_run_and_keep_the_first_ones() {
    let place = Place::new();
    place.write("few.toml", &surface_job("extended", 6, 10_000, 3));
    place.write("many.toml", &surface_job("extended", 6, 100_000, 3));
    place.run("submit few.toml").done();
    let outcome = place.run("submit many.toml").done();
    assert!(outcome.stderr.contains("from 10000 to 100000 samples"), "{}", outcome.stderr);
    assert!(outcome.stderr.contains("3,240,000 samples in"), "only the missing ones are drawn: {}", outcome.stderr);
    place.run("submit many.toml --out anew").done();
    assert!(place.surface("anew") == place.surface("runs/extended"));
    // A number of samples that ends within a block works as well.
    for samples in [10_001, 54_321, 100_000] {
        place.run(&format!("submit few.toml --out odd --samples {samples}")).done();
    }
    assert!(place.surface("anew") == place.surface("odd"));
}

/// A million samples, bit by bit, and the platform's exponential as a control: 64 hexadecimal digits each.
fn digests_of_deviates() -> (String, String) {
    let stream = DeviateStream { seed: 2018, common_random_numbers: false, dimensions: 2, points: Points::Random };
    let independent = Correlation::independent(2);
    let scatter = InputColumns::new(&[Marginal::Normal, Marginal::Normal], &independent, &[0.1, 0.39], &[0.2, 0.1]);
    let (mut deviates, mut control) = (blake3::Hasher::new(), blake3::Hasher::new());
    stream.for_each_chunk(5, 0, 0..1_000_000, |columns| {
        scatter.apply(columns);
        for (preload, static_friction) in columns[0].iter().zip(&columns[1]) {
            deviates.update(&preload.to_le_bytes());
            deviates.update(&static_friction.to_le_bytes());
            control.update(&(-preload * 37.0).exp().to_le_bytes());
        }
    });
    (deviates.finalize().to_hex().to_string(), control.finalize().to_hex().to_string())
}

/// Runs in a child process of the next test, and prints the digests.
#[test]
fn print_digests_of_deviates() {
    let (deviates, control) = digests_of_deviates();
    println!("deviates {deviates}\ncontrol {control}");
    // The value that is pinned in the sampler's own build, where num-traits computes with libm.
    assert_eq!(deviates, "741a4286eef692db97fdf4336b27f4fea74853a6fae742e77f10867421ebff78");
}

#[test]
fn the_processor_does_not_change_a_byte() {
    let tunables = "glibc.cpu.hwcaps=-FMA,-AVX2";
    let here = Place::new();
    let there = Place::new().with_environment("GLIBC_TUNABLES", tunables);
    for place in [&here, &there] {
        place.write("job.toml", &surface_job("processor", 12, 100_000, 3));
        place.run("submit job.toml").done();
    }
    assert!(here.surface("runs/processor") == there.surface("runs/processor"));
    let analyses = [&here, &there].map(|place| place.run("analyse --json").done().stdout);
    assert_eq!(analyses[0], analyses[1]);

    // Counts hardly ever change with a last bit of a sample, so the samples themselves are compared.
    let child = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "determinism::print_digests_of_deviates", "--nocapture"])
        .env("GLIBC_TUNABLES", tunables)
        .output()
        .unwrap();
    let text = String::from_utf8(child.stdout).unwrap();
    assert!(child.status.success(), "{text}");
    let (deviates, control) = digests_of_deviates();
    assert!(text.contains(&format!("deviates {deviates}")), "{text}");
    // Where the processor has FMA, the platform's own exponential must differ, or this test compares nothing.
    if cfg!(all(target_env = "gnu", target_arch = "x86_64")) && std::is_x86_feature_detected!("fma") {
        assert!(!text.contains(&format!("control {control}")), "GLIBC_TUNABLES changed nothing: {text}");
    }
}

#[test]
fn a_task_started_twice_and_killed_once_loses_nothing() {
    let place = Place::new();
    place.write("job.toml", &surface_job("twice", 3, 20_000_000, 3));
    place.run("submit job.toml --out whole").done();
    for attempt in [0, 3] {
        let run = format!("twice-{attempt}");
        let start = || {
            let mut command = place.command(&format!("submit job.toml --out {run} --shard 1/1 --threads 1"));
            command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
        };
        let mut orphan = start();
        thread::sleep(Duration::from_millis(30));
        let mut requeued = start();
        thread::sleep(Duration::from_millis(300 + 150 * attempt));
        orphan.kill().unwrap();
        orphan.wait().unwrap();
        assert!(requeued.wait().unwrap().success());
        place.run(&format!("merge {run}")).done();
        assert!(place.surface("whole") == place.surface(&run), "{run}");
    }
}

/// `make test-optimisation` builds the other program, which is optimised less and checks for overflow.
#[test]
#[ignore = "needs another build: make test-optimisation"]
fn optimisation_does_not_change_a_byte() {
    let other = std::env::var_os("STICKSLIP_OTHER_PROGRAM").unwrap();
    let (here, there) = (Place::new(), Place::new().with_program(Path::new(&other)));
    let motions = |disc: &str| {
        let criterion = format!("kind = \"time-domain\"\ndisc = \"{disc}\"\nrecord = [\"amplitude\"]");
        surface_job(disc, 3, 40, 3).replace("kind = \"eigenvalue\"", &criterion)
    };
    for job in [surface_job("eigenvalues", 8, 20_500, 3), motions("rigid"), motions("flexible")] {
        for place in [&here, &there] {
            place.write("job.toml", &job);
            place.run("submit job.toml --out run").done();
        }
        assert!(here.surface("run") == there.surface("run"), "{job}");
        for place in [&here, &there] {
            fs::remove_dir_all(place.path("run")).unwrap();
        }
    }
    let analyses = [&here, &there].map(|place| place.run("analyse --json").done().stdout);
    assert_eq!(analyses[0], analyses[1]);
}

#[test]
fn common_random_numbers_share_deviates_between_cells() {
    let place = Place::new();
    let job = surface_job("common", 12, 2_000, 3);
    place.write("own.toml", &job);
    place.write("common.toml", &job.replace("seed = 3", "seed = 3\ncommon_random_numbers = true"));
    place.run("submit own.toml --out own").done();
    place.run("submit common.toml --out common").done();
    // With the same deviates everywhere the probability cannot fall when an expected value rises.
    let rises = |run: &str| {
        let table = Table::read(&place.path(run).join("surface.parquet"));
        table.column("p_unstable").chunks(12).all(|row| row.windows(2).all(|pair| pair[0] <= pair[1]))
    };
    assert!(rises("common") && !rises("own"));
}
