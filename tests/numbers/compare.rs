//! Comparing finished runs: joint counts, intervals, and what is refused.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use crate::common::{Place, Table, change_piece, send, tried_until_met, wait_until_it_watches};
use serde_json::Value;

/// A job over 3 by 3 cells with further lines for `[criterion]` and `[sampling]`.
fn job(name: &str, speed: f64, criterion: &str, sampling: &str) -> String {
    format!(
        "name = \"{name}\"\n[axes]\nrotating_speed = {speed}\npreload = {{ from = 0.1, to = 0.3, points = 3 }}\n\
         static_friction = {{ from = 0.3, to = 0.5, points = 3 }}\n[random]\ninputs = [\"preload\", \"static_friction\"]\n\
         relative_std = 0.2\n[criterion]\n{criterion}\n[sampling]\n{sampling}\n"
    )
}

const EIGENVALUE: &str = "kind = \"eigenvalue\"";
const RIGID: &str = "kind = \"time-domain\"\ndisc = \"rigid\"";
const FROM_REST: &str = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"";

/// Finished runs of jobs, each given by name, criterion and sampling.
fn runs(speed: f64, jobs: &[(&str, &str, &str)]) -> Place {
    let place = Place::new();
    for (name, criterion, sampling) in jobs {
        place.write("job.toml", &job(name, speed, criterion, sampling));
        place.run("submit job.toml").done();
    }
    place
}

fn sum(table: &Table, name: &str) -> f64 {
    table.column(name).iter().sum()
}

/// The texts of a column.
fn texts(place: &Place, file: &str, name: &str) -> Vec<String> {
    crate::common::texts(&place.path(file), name).into_iter().flatten().collect()
}

#[test]
fn eigenvalues_against_motion_in_time_are_paired_and_add_up() {
    let sampling = "samples = 400\nseed = 5";
    let place = runs(15.0, &[("linear", EIGENVALUE, sampling), ("motion", RIGID, sampling)]);
    let outcome = place.run("compare runs/linear runs/motion --out out.parquet").done();
    for text in [
        "runs/motion against runs/linear: 9 cells, 9 of them paired",
        "Difference, second minus first",
        "of the samples",
    ] {
        assert!(outcome.stdout.contains(text), "{text}: {}", outcome.stdout);
    }
    assert!(!outcome.stderr.contains("warning"), "{}", outcome.stderr);
    let contract = [
        "first_run",
        "second_run",
        "cell_first",
        "cell_second",
        "rotating_speed_rad_s",
        "std_preload",
        "std_static_friction",
        "preload",
        "static_friction",
        "n_paired",
        "n_both",
        "n_only_first",
        "n_only_second",
        "n_neither",
        "n_without_verdict",
        "p_first",
        "p_second",
        "difference",
        "difference_low",
        "difference_high",
        "interval",
    ];
    let table = Table::read(&place.path("out.parquet"));
    assert_eq!(table.names(), contract);
    assert_eq!(texts(&place, "out.parquet", "first_run"), ["runs/linear"; 9]);
    assert_eq!(texts(&place, "out.parquet", "second_run"), ["runs/motion"; 9]);
    assert_eq!(texts(&place, "out.parquet", "interval"), ["paired"; 9]);
    let [linear, motion] =
        ["linear", "motion"].map(|run| Table::read(&place.path("runs").join(run).join("surface.parquet")));
    for row in 0..9 {
        let of = |name: &str| table.column(name)[row];
        let (both, first, second) = (of("n_both"), of("n_only_first"), of("n_only_second"));
        assert_eq!(of("n_paired"), 400.0);
        assert_eq!(both + first + second + of("n_neither") + of("n_without_verdict"), 400.0);
        assert_eq!(both + first, linear.column("n_unstable")[row], "the marginal counts are those of the runs");
        assert_eq!(both + second, motion.column("n_unstable")[row]);
        assert_eq!(of("difference"), (second - first) / (400.0 - of("n_without_verdict")));
        assert!((of("p_second") - of("p_first") - of("difference")).abs() < 1e-15);
        assert!(of("difference_low") <= of("difference") && of("difference") <= of("difference_high"));
        assert!(of("difference_low") < of("difference_high"));
        assert_eq!(of("preload"), linear.column("preload")[row]);
        assert_eq!(of("cell_first"), of("cell_second"));
    }
    // Exchanging the runs changes the sign.
    place.run("compare runs/motion runs/linear --out back.parquet").done();
    let back = Table::read(&place.path("back.parquet"));
    for row in 0..9 {
        assert_eq!(back.column("difference")[row], -table.column("difference")[row]);
        assert_eq!(back.column("difference_low")[row], -table.column("difference_high")[row]);
        assert_eq!(back.column("n_only_first")[row], table.column("n_only_second")[row]);
    }
}

#[test]
fn a_run_over_starts_does_not_differ_from_itself() {
    let place = Place::new();
    place.write(
        "basin.toml",
        "name = \"basin\"\n[axes]\nrotating_speed = 20\npreload = 0.1\nstatic_friction = 0.39\nstart.velocity = [-0.2, 0.0]\n\
         start.tangential = [-1e-4, 0.0, 1e-4]\n[random]\ninputs = [\"preload\"]\nrelative_std = 0.05\n[criterion]\n\
         kind = \"time-domain\"\ndisc = \"rigid\"\nstart = { from_equilibrium = true }\n[sampling]\nsamples = 30\n",
    );
    place.run("submit basin.toml").done();
    let compared = place.run("compare runs/basin runs/basin").done();
    assert!(compared.stdout.contains("6 cells, 6 of them paired"), "{}", compared.stdout);
    assert!(!compared.stderr.contains("warning"), "{}", compared.stderr);
    assert!(!place.path("runs/basin/map").exists(), "a verdict map is of one start");
}

#[test]
fn a_run_does_not_differ_from_itself() {
    let place = runs(15.0, &[("same", RIGID, "samples = 200"), ("exact", EIGENVALUE, "method = \"exact\"")]);
    let outcome = place.run("compare runs/same runs/same runs/same --json").done();
    let summaries: Value = serde_json::from_str(&outcome.stdout).unwrap();
    assert_eq!(summaries.as_array().unwrap().len(), 2);
    for summary in summaries.as_array().unwrap() {
        assert_eq!(summary["cells_paired"], 9);
        assert_eq!(summary["mean_absolute_difference"], 0.0);
        assert_eq!(summary["samples_only_first_unstable"], 0);
        assert_eq!(summary["samples_only_second_unstable"], 0);
        assert_eq!(summary["cells_significantly_higher"], 0);
        assert_eq!(summary["cells_significantly_lower"], 0);
        assert!(summary["largest"]["difference_low"].as_f64().unwrap() < 0.0);
    }
    let exact = place.run("compare runs/exact runs/exact").done();
    assert!(exact.stdout.contains("significant       0 of 9 cells"), "{}", exact.stdout);
}

#[test]
fn a_start_from_rest_is_unstable_where_steady_sliding_is_stable() {
    let sampling = "samples = 300\nseed = 3";
    let place = runs(22.0, &[("held", RIGID, sampling), ("rest", FROM_REST, sampling)]);
    place.run("compare runs/held runs/rest --out out.parquet").done();
    let table = Table::read(&place.path("out.parquet"));
    assert_eq!(sum(&table, "n_only_first"), 0.0);
    assert!(sum(&table, "n_only_second") > 300.0, "{}", sum(&table, "n_only_second"));
    let low = table.column("difference_low");
    assert!(low.iter().any(|&low| low > 0.1), "{low:?}");
}

#[test]
fn other_samples_are_not_paired() {
    let place =
        runs(15.0, &[("a", EIGENVALUE, "samples = 500\nseed = 1"), ("b", EIGENVALUE, "samples = 700\nseed = 2")]);
    let outcome = place.run("compare runs/a runs/b --out out.parquet").done();
    assert!(outcome.stderr.contains("their seeds differ (1 and 2)"), "{}", outcome.stderr);
    assert_eq!(texts(&place, "out.parquet", "interval"), ["unpaired"; 9]);
    let table = Table::read(&place.path("out.parquet"));
    assert_eq!(sum(&table, "n_paired"), 0.0);
    let b = Table::read(&place.path("runs/b/surface.parquet"));
    assert_eq!(table.column("p_second"), b.column("p_unstable"));
    for row in 0..9 {
        let of = |name: &str| table.column(name)[row];
        assert_eq!(of("difference"), of("p_second") - of("p_first"));
        assert!(of("difference_low") < of("difference") && of("difference") < of("difference_high"));
    }
}

#[test]
fn two_seeds_of_one_job_do_not_differ() {
    let grid = |name: &str, seed: u64| {
        job(name, 15.0, EIGENVALUE, &format!("samples = 2000\nseed = {seed}"))
            .replace("{ from = 0.3, to = 0.5, points = 3 }", "{ from = 0.3, to = 0.5, points = 40 }")
    };
    let place = Place::new();
    for (name, seed) in [("a", 1), ("b", 2)] {
        place.write("job.toml", &grid(name, seed));
        place.run("submit job.toml").done();
    }
    let significant = |words: &str| {
        let outcome = place.run(&format!("compare runs/a runs/b --json{words}")).done();
        let summary: Value = serde_json::from_str(&outcome.stdout).unwrap();
        let count = |key: &str| summary[0][key].as_u64().unwrap();
        assert_eq!(summary[0]["simultaneous"], words.is_empty());
        count("cells_significantly_higher") + count("cells_significantly_lower")
    };
    assert_eq!(significant(""), 0);
    assert!(significant(" --pointwise") > 0, "one in twenty of 120 cells, by chance");
    let text = place.run("compare runs/a runs/b").done().stdout;
    assert!(text.contains("confidence 0.95 for all together"), "{text}");
}

#[test]
fn runs_that_share_deviates_are_not_treated_as_independent() {
    let place = Place::new();
    let text = |name: &str, extra: &str| {
        job(name, 15.0, EIGENVALUE, "samples = 500\nseed = 4")
            .replace("\n[criterion]", &format!("{extra}\n[criterion]"))
    };
    let correlated = |rho: f64| format!("\ncorrelation = [[\"preload\", \"static_friction\", {rho}]]");
    let third = text("third", "").replace(
        "inputs = [\"preload\", \"static_friction\"]",
        "inputs = [\"preload\", \"static_friction\", \"pad.mass\"]",
    );
    for (name, text) in
        [("up", text("up", &correlated(0.9))), ("down", text("down", &correlated(-0.9))), ("third", third)]
    {
        place.write("job.toml", &text);
        place.run("submit job.toml").done();
        assert!(place.path("runs").join(name).is_dir());
    }
    // The same deviates, transformed to other inputs, are paired sample by sample.
    place.run("compare runs/up runs/down --out out.parquet").done();
    assert_eq!(texts(&place, "out.parquet", "interval"), ["paired"; 9]);
    // With another number of inputs, the same random numbers make other samples.
    let outcome = place.run("compare runs/up runs/third --out out.parquet").done();
    assert!(outcome.stderr.contains("2 and 3 random inputs, though they share random numbers"), "{}", outcome.stderr);
    assert_eq!(texts(&place, "out.parquet", "interval"), ["dependent"; 9]);
}

#[test]
fn runs_of_different_length_are_paired_where_both_have_samples() {
    let until = "until = { half_width = 0.08, at_most = 4000 }\nseed = 1";
    let place = runs(
        15.0,
        &[
            ("a", EIGENVALUE, "samples = 500\nseed = 1"),
            ("b", RIGID, "samples = 700\nseed = 1"),
            ("c", EIGENVALUE, until),
        ],
    );
    let outcome = place.run("compare runs/a runs/b runs/c --out out.parquet").done();
    assert!(!outcome.stderr.contains("warning"), "{}", outcome.stderr);
    assert_eq!(texts(&place, "out.parquet", "interval"), ["paired"; 18]);
    let table = Table::read(&place.path("out.parquet"));
    assert_eq!(table.column("n_paired")[..9], [500.0; 9]);
    // The same criterion on the same samples.
    assert_eq!(table.column("difference")[9..], [0.0; 9]);
}

#[test]
fn sobol_points_are_paired_by_randomisation() {
    let sampling = "method = \"sobol\"\nsamples = 512\nrandomisations = 4\nseed = 9";
    let other = sampling.replace("= 4", "= 8");
    let place = runs(15.0, &[("a", EIGENVALUE, sampling), ("b", RIGID, sampling), ("c", EIGENVALUE, &other)]);
    let outcome = place.run("compare runs/a runs/b runs/c --out out.parquet").done();
    assert!(outcome.stderr.contains("they have 4 and 8 randomisations"), "{}", outcome.stderr);
    let intervals = texts(&place, "out.parquet", "interval");
    assert_eq!(
        (&intervals[..9], &intervals[9..]),
        (&vec!["paired".to_owned(); 9][..], &vec!["dependent".to_owned(); 9][..])
    );
    assert_eq!(Table::read(&place.path("out.parquet")).column("n_paired")[..9], [512.0; 9]);
}

#[test]
fn integrated_probabilities_have_bounds() {
    let place = runs(15.0, &[("exact", EIGENVALUE, "method = \"exact\""), ("drawn", EIGENVALUE, "samples = 1000")]);
    place.run("compare runs/exact runs/drawn --pointwise --out out.parquet").done();
    assert_eq!(texts(&place, "out.parquet", "interval"), ["bounds"; 9]);
    let table = Table::read(&place.path("out.parquet"));
    let [exact, drawn] =
        ["exact", "drawn"].map(|run| Table::read(&place.path("runs").join(run).join("surface.parquet")));
    assert_eq!(table.column("p_first"), exact.column("p_unstable"));
    for row in 0..9 {
        let of = |name: &str| table.column(name)[row];
        assert_eq!(of("n_paired"), 0.0);
        assert_eq!(of("difference_low"), drawn.column("p_low")[row] - exact.column("p_high")[row]);
        assert_eq!(of("difference_high"), drawn.column("p_high")[row] - exact.column("p_low")[row]);
        assert!(of("difference").abs() < 0.06);
    }
}

#[test]
fn cells_are_matched_by_their_values() {
    let place = Place::new();
    for (name, common) in [("own", false), ("common", true)] {
        let sampling = format!("samples = 300\ncommon_random_numbers = {common}");
        let whole = job(&format!("{name}-whole"), 15.0, EIGENVALUE, &sampling);
        place.write("whole.toml", &whole);
        let part = job(&format!("{name}-part"), 15.0, EIGENVALUE, &sampling);
        place.write("part.toml", &part.replace("{ from = 0.3, to = 0.5, points = 3 }", "[0.4, 0.5, 0.6]"));
        place.run("submit whole.toml").done();
        place.run("submit part.toml").done();
        let outcome = place.run(&format!("compare runs/{name}-whole runs/{name}-part --out {name}.parquet")).done();
        assert!(outcome.stderr.contains("6 cells are in both runs; left out are 3 of 9"), "{}", outcome.stderr);
    }
    let table = Table::read(&place.path("common.parquet"));
    assert_eq!(table.column("cell_first"), [1.0, 2.0, 4.0, 5.0, 7.0, 8.0]);
    assert_eq!(table.column("cell_second"), [0.0, 1.0, 3.0, 4.0, 6.0, 7.0]);
    assert_eq!(table.column("difference"), [0.0; 6], "the same samples in every cell");
    assert_eq!(texts(&place, "own.parquet", "interval"), ["unpaired"; 6]);
}

/// Replaces a piece of a verdict map by one with the opposite verdicts.
fn exchange_verdicts(piece: &Path) {
    let exchange = |code: &mut Value| *code = (1 - code.as_i64().unwrap()).into();
    change_piece(piece, |lines| {
        for node in lines[1..].iter_mut().flat_map(|tile| tile[3].as_array_mut().unwrap()) {
            if let Some(code) = node.get_mut("uniform") {
                exchange(code);
            } else if let Some(curve) = node.get_mut("crossed") {
                exchange(&mut curve[1]);
                exchange(&mut curve[2]);
            }
        }
    });
}

#[test]
fn verdicts_that_are_not_those_counted_are_not_paired() {
    let looked_up = "samples = 20_000\nevaluate = \"boundary\"\naudit = 0";
    let place = runs(15.0, &[("a", EIGENVALUE, "samples = 20_000"), ("b", RIGID, looked_up)]);
    place.run("compare runs/a runs/b").done();
    // A verdict map with the opposite verdicts and a valid checksum.
    let pieces: Vec<_> = fs::read_dir(place.path("runs/b/map")).unwrap().map(|entry| entry.unwrap().path()).collect();
    pieces.iter().for_each(|piece| exchange_verdicts(piece));
    let outcome = place.run("compare runs/a runs/b --out out.parquet").done();
    assert!(outcome.stderr.contains("warning: in 9 of 9 cells the verdicts"), "{}", outcome.stderr);
    assert_eq!(texts(&place, "out.parquet", "interval"), ["dependent"; 9]);
    let table = Table::read(&place.path("out.parquet"));
    let counted = Table::read(&place.path("runs/b/surface.parquet"));
    assert_eq!(table.column("p_second"), counted.column("p_unstable"));
}

/// Samples are decided again as the runs decided them.
#[test]
fn runs_without_a_map_are_compared_without_one() {
    let place = runs(15.0, &[("a", EIGENVALUE, "samples = 100"), ("b", RIGID, "samples = 100")]);
    place.run("compare runs/a runs/b").done();
    assert!(!place.path("runs/b/map").exists());
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let place = runs(15.0, &[("a", EIGENVALUE, "samples = 100")]);
    place.write("job.toml", &job("elsewhere", 16.0, EIGENVALUE, "samples = 100"));
    place.run("submit job.toml").done();
    place.run("compare runs/a runs/elsewhere").refused(65, &["no cell in common", "[axes]"]);
    place.run("compare").refused(64, &[]);
    place.run("compare runs/a").refused(64, &["two runs or more", "runs/a"]);
    for confidence in ["0", "1", "1.5", "-0.5", "nan"] {
        let words = format!("compare runs/a runs/a --confidence {confidence}");
        place.run(&words).refused(64, &["--confidence", "greater than 0 and less than 1"]);
    }
    place.run("compare runs/a runs/nowhere").refused(74, &["runs/nowhere is not a run directory"]);
    place.run("compare runs/a runs/a --out missing/out.parquet").refused(73, &["there is no directory missing"]);
    place.run("compare runs/a runs/a --out runs").refused(73, &["is a directory"]);

    place.write("job.toml", &job("half", 15.0, EIGENVALUE, "samples = 100"));
    place.run("submit job.toml --shard 1/2").done();
    place
        .run("compare runs/a runs/half")
        .refused(65, &["runs/half is not finished", "of 9 cells", "stickslip resume runs/half"]);
    place.run("resume runs/half").done();
    place.run("compare runs/a runs/half").done();
}

#[test]
fn ctrl_c_ends_a_comparison() {
    // Counting is fast, but comparing sample by sample is slower.
    let place = runs(15.0, &[("long", EIGENVALUE, "samples = 30_000_000")]);
    // At some moment it compares.
    let output = tried_until_met(|attempt| {
        let mut command = place.command("compare runs/long runs/long --out out.parquet");
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        wait_until_it_watches(&mut child);
        std::thread::sleep(Duration::from_millis(20 << (attempt % 6)));
        send(&child, "INT");
        let output = child.wait_with_output().unwrap();
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        match output.status.code() {
            Some(130) if stderr.contains("interrupted; nothing was compared") => Ok(output),
            code => Err(format!("{code:?} {stderr}")),
        }
    });
    assert!(output.stdout.is_empty() && !place.path("out.parquet").exists());
}

/// Two masses far from instability, of which importance sampling finds nothing: there is no probability to compare.
#[test]
fn cells_without_a_probability_are_counted() {
    let place = Place::new();
    place.write(
        "calm.toml",
        "name = \"calm\"\n[model]\nkind = \"matrices\"\nmass = { matrix = [[1, 0], [0, 1]] }\n\
         damping = [{ matrix = [[0.5, 0], [0, 0.5]] }]\nstiffness = [{ matrix = [[2, 0], [0, 3]], factor = \"k\" }]\n\
         [model.parameters]\nk = 1.0\n[random]\ninputs = [\"k\"]\nrelative_std = 0.001\n[criterion]\n\
         kind = \"complex-eigenvalue\"\nfrequency = [0.1, 1.0]\n[sampling]\nmethod = \"importance\"\nsamples = 256\n",
    );
    place.run("submit calm.toml").done();
    let compared = place.run("compare runs/calm runs/calm").done();
    assert!(compared.stdout.contains("left out          1 cell without a probability"), "{}", compared.stdout);
    let outcome = place.run("compare runs/calm runs/calm --json").done();
    let summary: Value = serde_json::from_str(&outcome.stdout).unwrap();
    let summary = summary.as_array().map_or(&summary, |all| &all[0]);
    assert_eq!((&summary["cells"], &summary["cells_without_difference"]), (&Value::from(1), &Value::from(1)));
}
