//! Probabilities through the command line: integrals, verdict maps, stopping by precision, Sobol points, intervals,
//! derivatives, Sobol indices, further random inputs.

#![allow(clippy::disallowed_methods, reason = "expected values are computed as a textbook writes them")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{BOTH, EIGENVALUE, Place, Table, job, lines_of, submitted, write_piece};
use serde_json::Value;
use stickslip_core::model::decision::Decision;
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use stickslip_core::models::pad_on_disc::criterion::time_domain::{DiscModel, TimeDomain};
use stickslip_core::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use stickslip_sampler::special_functions::normal;

const RIGID: &str = "kind = \"time-domain\"\ndisc = \"rigid\"";
const FROM_REST: &str = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"";

/// Submits a job and returns its standard output.
fn submitted_text(place: &Place, name: &str, text: &str) -> String {
    place.write(&format!("{name}.toml"), text);
    place.run(&format!("submit {name}.toml --out {name}")).done().stdout
}

fn boundary(speed: f64) -> PairBoundary {
    let mut parameters = Parameters::sui_ding_2018();
    parameters.set("operating_point.rotating_speed", speed).unwrap();
    PadOnDisc::new(parameters).unwrap().stability_boundary()
}

/// The last session in the run.json of a run.
fn last_session(place: &Place, run: &str) -> Value {
    let text = fs::read_to_string(place.path(run).join("run.json")).unwrap();
    let record: Value = serde_json::from_str(&text).unwrap();
    record["sessions"].as_array().unwrap().last().unwrap().clone()
}

/// The mean of a function of a standard normal deviate, by the trapezoidal rule.
fn mean(f: impl Fn(f64) -> f64) -> f64 {
    let (points, limit) = (40_000, 9.0);
    let step = 2.0 * limit / f64::from(points);
    (0..=points)
        .map(|i| {
            let z = -limit + step * f64::from(i);
            normal::density(z) * f(z)
        })
        .sum::<f64>()
        * step
}

/// The probability that a sample is unstable at a given deviate of the preload, for the closed form.
fn given_preload(boundary: &PairBoundary, preload: f64, static_friction: f64, std: f64, z: f64) -> f64 {
    let critical = boundary.critical_second(preload * (1.0 + std * z));
    normal::upper_tail((critical / static_friction - 1.0) / std)
}

#[test]
fn integrals_agree_with_an_independent_quadrature() {
    let place = Place::new();
    let table = submitted(&place, "exact", &job("exact", EIGENVALUE, BOTH, "method = \"exact\""));
    let boundary = boundary(15.0);
    for row in 0..30 {
        let [preload, friction] = ["preload", "static_friction"].map(|name| table.column(name)[row]);
        let expected = mean(|z| given_preload(&boundary, preload, friction, 0.2, z));
        let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|name| table.column(name)[row]);
        assert!((p - expected).abs() < 1e-10, "{preload} {friction}: {p} {expected}");
        assert!(low <= p && p <= high && high - low < 1e-10);
        assert_eq!(table.column("n_samples")[row], 0.0);
    }
    let again = place.run("submit exact.toml --out exact").done();
    assert!(again.stderr.contains("finished already"), "{}", again.stderr);
    let status: Value = serde_json::from_str(&place.run("status exact --json").done().stdout).unwrap();
    assert_eq!((&status["state"], &status["share_done"]), (&"finished".into(), &1.0.into()));
}

#[test]
fn derivatives_are_those_of_the_probability() {
    let place = Place::new();
    let text = job("d", EIGENVALUE, BOTH, "method = \"exact\"\nderivatives = true");
    let exact = submitted(&place, "d", &text);
    // Central differences of other runs.
    let h = 1e-5;
    let shifted = |name: &str, from: &str, to: &str| submitted(&place, name, &text.replace(from, to));
    let friction = |shift: f64| format!("static_friction = [{}, {}]", 0.39 + shift, 0.45 + shift);
    let axis = "static_friction = { from = 0.28, to = 0.50, points = 5 }";
    let centre = shifted("centre", axis, &friction(0.0));
    let (up, down) = (shifted("up", axis, &friction(h)), shifted("down", axis, &friction(-h)));
    let wide = submitted(&place, "wide", &text.replace(axis, &friction(0.0)).replace("= 0.2", "= 0.20001"));
    let narrow = submitted(&place, "narrow", &text.replace(axis, &friction(0.0)).replace("= 0.2", "= 0.19999"));
    for row in 0..12 {
        let slope = |a: &Table, b: &Table| (a.column("p_unstable")[row] - b.column("p_unstable")[row]) / (2.0 * h);
        let by_friction = centre.column("dp_dstatic_friction")[row];
        assert!((by_friction - slope(&up, &down)).abs() < 1e-6, "{by_friction} {}", slope(&up, &down));
        let by_stds = centre.column("dp_dstd_preload")[row] + centre.column("dp_dstd_static_friction")[row];
        assert!((by_stds - slope(&wide, &narrow)).abs() < 1e-6, "{by_stds} {}", slope(&wide, &narrow));
    }
    // Derivatives from samples agree within their standard errors. Those from Sobol points have smaller errors than
    // stated.
    for (name, sampling) in [
        ("mc", "samples = 40_000\nseed = 5"),
        ("sobol", "method = \"sobol\"\nsamples = 32_768"),
        ("until", "until = { half_width = 0.01, at_most = 50_000 }"),
    ] {
        let sampled = submitted(&place, name, &job(name, EIGENVALUE, BOTH, &format!("{sampling}\nderivatives = true")));
        for column in ["dp_dpreload", "dp_dstatic_friction", "dp_dstd_preload", "dp_dstd_static_friction"] {
            for row in 0..30 {
                let error = sampled.column(&format!("{column}_error"))[row];
                let deviation = sampled.column(column)[row] - exact.column(column)[row];
                // 360 values are compared at once. Errors are not known well where few samples have one of the
                // verdicts.
                let rare = sampled.column("n_unstable")[row].min(sampled.column("n_stable")[row]) < 50.0;
                assert!(rare || deviation.abs() < 4.2 * error, "{name} {column} {row}: {deviation} {error}");
            }
        }
    }
}

#[test]
fn integrals_in_time_agree_with_simulated_samples() {
    let place = Place::new();
    for (name, criterion) in [("near", RIGID), ("rest", FROM_REST)] {
        let exact = submitted(&place, &format!("{name}-exact"), &job(name, criterion, BOTH, "method = \"exact\""));
        let sampled = submitted(&place, name, &job(name, criterion, BOTH, "samples = 10_000\nseed = 2"));
        let mut largest = 0.0_f64;
        for row in 0..30 {
            let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|column| exact.column(column)[row]);
            let audit = exact.column("p_audit")[row];
            // 300 samples of which none differs: a share of 1 - 0.05^(1 / 300).
            assert!((audit - 0.009_936).abs() < 1e-6 && exact.column("n_audited")[row] == 300.0, "{audit}");
            assert!(low <= p && p <= high);
            assert!(f64::max(p - low, high - p) < audit + 1e-4, "{low} {p} {high}");
            let error = (p * (1.0 - p) / 1e4).sqrt().max(2e-4);
            largest = largest.max((sampled.column("p_unstable")[row] - p).abs() / error);
        }
        assert!(largest < 4.0, "{name}: {largest} standard errors");
    }
}

/// A larger job.
fn mapped(name: &str, criterion: &str, sampling: &str) -> String {
    job(name, criterion, BOTH, sampling).replace("points = 6", "points = 12").replace("points = 5", "points = 13")
}

/// Asserts that all columns agree but the limits, which are wider by what the audit does not exclude.
fn assert_same_counts(each: &Table, looked_up: &Table) {
    for column in each.names() {
        let [a, b] = [each, looked_up].map(|table| table.column(column));
        for (row, (a, b)) in a.iter().zip(b).enumerate() {
            match column.as_str() {
                "p_low" => assert!(b <= a, "{column} {row}"),
                "p_high" => assert!(b >= a, "{column} {row}"),
                _ => assert_eq!(a, b, "{column} {row}"),
            }
        }
    }
}

#[test]
fn looked_up_verdicts_are_those_of_simulated_samples() {
    let place = Place::new();
    for (name, criterion, speed) in [("near", RIGID, 15.0), ("rest", FROM_REST, 15.5), ("between", FROM_REST, 24.0)] {
        let text = |sampling: &str| {
            mapped(name, criterion, sampling).replace("rotating_speed = 15.0", &format!("rotating_speed = {speed}"))
        };
        let each = submitted(&place, &format!("{name}-each"), &text("samples = 12_000"));
        let looked_up = submitted(&place, name, &text("samples = 12_000\nevaluate = \"boundary\"\naudit = 0.001"));
        assert_same_counts(&each, &looked_up);
        let sum = |column: &str| looked_up.column(column).iter().sum::<f64>();
        let (simulated, audited) = (sum("n_simulated"), sum("n_audited"));
        assert_eq!(sum("n_audit_differed"), 0.0);
        // 1 872 000 samples, a thousandth of them.
        assert!((audited - 1872.0).abs() < 200.0, "{audited}");
        let session = last_session(&place, name);
        let simulations = session["map_simulations"].as_f64().unwrap() + simulated + audited;
        assert_eq!(session["lookups_simulated"].as_f64(), Some(simulated));
        assert!(100.0 * simulations < sum("n_samples"), "{name}: {simulations} simulations");
    }
}

#[test]
fn samples_in_undecided_regions_are_simulated() {
    // At so short a horizon, lines of decided samples, too thin for any grid, cross the undecided region.
    let place = Place::new();
    let short = |name: &str, sampling: &str| {
        let scatter = BOTH.replace("= 0.2", "= 0.1");
        let text = job(name, &format!("{FROM_REST}\nhorizon = 3.0"), &scatter, sampling);
        text.replace("{ from = 0.05, to = 0.30, points = 6 }", "0.08")
            .replace("{ from = 0.28, to = 0.50, points = 5 }", "0.33")
    };
    let each = submitted(&place, "each", &short("each", "samples = 40_000"));
    let looked_up = submitted(&place, "map", &short("map", "samples = 40_000\nevaluate = \"boundary\"\naudit = 0.0"));
    for column in each.names() {
        assert_eq!(each.column(column), looked_up.column(column), "{column}");
    }
    assert!(each.column("n_undecided")[0] > 30_000.0 && each.column("n_unstable")[0] > 600.0);
    let simulated = looked_up.column("n_simulated")[0];
    assert!(simulated >= each.column("n_undecided")[0] && simulated < 38_000.0, "{simulated}");
}

#[test]
fn a_flexible_disc_is_mapped_too() {
    let place = Place::new();
    // With the least number of modes, near its boundary too motions are decided soon.
    let text = |sampling: &str| job("flexible", "kind = \"time-domain\"\ndisc_modes = 4", BOTH, sampling);
    let each = submitted(&place, "each", &text("samples = 400"));
    let looked_up = submitted(&place, "map", &text("samples = 400\nevaluate = \"boundary\"\naudit = 0.01"));
    let coupled = "kind = \"coupled-eigenvalue\"";
    let coupled_each = submitted(&place, "coupled-each", &job("c", coupled, BOTH, "samples = 200"));
    let coupled_map = submitted(&place, "coupled", &job("c", coupled, BOTH, "samples = 200\nevaluate = \"boundary\""));
    for (each, looked_up) in [(&each, &looked_up), (&coupled_each, &coupled_map)] {
        assert_same_counts(each, looked_up);
    }
}

/// Copies the verdict map of the run `from` into `to`, with the key of the run `as_of`. It is wrong for that run, as if
/// it had missed a region of another verdict.
fn forge_map(place: &Place, from: &str, as_of: &str, to: &str) {
    let pieces = |run: &str| -> Vec<_> {
        fs::read_dir(place.path(run).join("map")).unwrap().map(|entry| entry.unwrap().path()).collect()
    };
    let own = lines_of(&pieces(as_of)[0]).remove(0);
    let forged = place.path(to).join("map");
    fs::create_dir_all(&forged).unwrap();
    for piece in pieces(from) {
        let mut lines = lines_of(&piece);
        assert_ne!(lines[0], own);
        lines[0] = own.clone();
        write_piece(&forged, &lines);
    }
}

#[test]
fn an_audit_finds_a_map_that_is_wrong() {
    // The map of a brake with more damping.
    let place = Place::new();
    let text = job("wrong", RIGID, BOTH, "samples = 2000\nevaluate = \"boundary\"\naudit = 300");
    submitted(&place, "other", &text.replace("[axes]", "[model.damping]\ntangential = 500.0\n\n[axes]"));
    let own = submitted(&place, "own", &text);
    forge_map(&place, "other", "own", "forged");
    let outcome = place.run("submit own.toml --out audited --map forged");
    outcome.refused(70, &["the verdict map is wrong somewhere", "p_low and p_high", "evaluate = \"each\""]);
    // The result is written nevertheless, counts the differences, and its intervals contain the true probabilities.
    let exact = "method = \"exact\"\naudit = 300";
    place.write("exact.toml", &job("exact", RIGID, BOTH, exact));
    place.run("submit exact.toml --out exact --map forged").refused(70, &["the verdict map is wrong", "monte-carlo"]);
    let closed = submitted(&place, "closed", &job("closed", EIGENVALUE, BOTH, "method = \"exact\""));
    for run in ["audited", "exact"] {
        let table = Table::read(&place.path(run).join("surface.parquet"));
        assert!(table.column("n_audit_differed").iter().sum::<f64>() > 100.0);
        let (mut far_off, mut missed) = (0, 0);
        for row in 0..30 {
            let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|name| table.column(name)[row]);
            let truth = closed.column("p_unstable")[row];
            missed += u32::from(truth < low || truth > high);
            far_off += u32::from((p - truth).abs() > 0.05);
        }
        assert!(far_off > 5 && missed <= 4, "{run}: {far_off} far off, {missed} of 30 intervals of 95 % miss");
    }
    assert!(own.column("n_audit_differed").iter().all(|&differed| differed == 0.0));
    assert!(own.column("p_audit").iter().all(|&share| share > 0.0 && share < 0.0145));
    assert!(place.run("status audited").done().stdout.contains("audited samples differed"));
    assert!(place.run("compare audited own").done().stderr.contains("warning: audited: "));
    // A finished run repeats the message.
    place.run("submit own.toml --out audited --map forged").refused(70, &["wrong somewhere"]);
}

#[test]
fn a_map_serves_other_jobs_without_a_new_simulation() {
    let place = Place::new();
    submitted(&place, "first", &mapped("first", FROM_REST, "samples = 1000\nevaluate = \"boundary\""));
    let other = "name = \"other\"\n\n[axes]\nrotating_speed = 15.0\npreload = [0.08, 0.11, 0.21]\nstatic_friction = [0.33, 0.41]\n\n\
        [random]\ninputs = [\"preload\", \"static_friction\"]\nrelative_std = { preload = 0.1, static_friction = 0.15 }\n\n\
        [criterion]\nkind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"\n\n\
        [sampling]\nsamples = 3000\nseed = 99\nevaluate = \"boundary\"\naudit = 0\n";
    place.write("other.toml", other);
    place.run("submit other.toml --out served --map first").done();
    let session = last_session(&place, "served");
    assert_eq!((session["map_simulations"].as_u64(), session["lookups_simulated"].as_u64()), (Some(0), Some(0)));
    place.run("submit other.toml --out alone").done();
    assert!(last_session(&place, "alone")["map_simulations"].as_u64() > Some(1000));
    assert!(place.surface("served") == place.surface("alone"), "a borrowed map gives the same bytes");
    // A run keeps borrowed tiles, so an integral can use them from there.
    let exact = other.replace("samples = 3000\nseed = 99\nevaluate = \"boundary\"", "method = \"exact\"");
    place.write("exact.toml", &exact);
    place.run("submit exact.toml --out exact --map served").done();
    assert_eq!(last_session(&place, "exact")["map_simulations"].as_u64(), Some(0));
    // With another criterion, nothing can be borrowed.
    place.write("near.toml", &other.replace("start = \"rest\"", "start = \"near-equilibrium\""));
    place.run("submit near.toml --out near --map first").done();
    assert!(last_session(&place, "near")["map_simulations"].as_u64() > Some(1000));
    // An integral gives the probability of samples that the horizon leaves undecided.
    let short = exact.replace("start = \"rest\"", "start = \"rest\"\nhorizon = 3.0");
    let text = submitted_text(&place, "short", &short);
    assert!(text.contains("undecided"), "{text}");
    let table = Table::read(&place.path("short/surface.parquet"));
    let sampled = submitted(&place, "short-sampled", &short.replace("method = \"exact\"\naudit = 0", "samples = 4000"));
    for row in 0..6 {
        let [undecided, low, high] = ["p_undecided", "p_low", "p_high"].map(|column| table.column(column)[row]);
        let share = sampled.column("n_undecided")[row] / 4000.0;
        assert!((undecided - share).abs() < 0.035 && high - low >= undecided - 1e-12, "{undecided} {share}");
    }
    place.run("submit other.toml --out x --map nowhere").refused(74, &["nowhere", "no verdict map"]);
    place.write("plain.toml", &job("plain", EIGENVALUE, BOTH, "samples = 10"));
    place.run("submit plain.toml --out x --map first").refused(64, &["--map first", "uses no verdict map"]);
    place.run("submit exact.toml --out y --shard 1/2").refused(64, &["--shard 1/2", "draws no samples"]);
}

#[test]
fn maps_do_not_depend_on_threads_shards_and_kills() {
    let place = Place::new();
    place.write("job.toml", &mapped("job", FROM_REST, "samples = 20_000\nevaluate = \"boundary\"\naudit = 0.001"));
    for threads in [1, 2, 3] {
        place.run(&format!("submit job.toml --threads {threads} --out {threads}")).done();
        assert!(place.surface("1") == place.surface(&threads.to_string()), "{threads} threads");
    }
    for shard in 1..=3 {
        place.run(&format!("submit job.toml --out shards --shard {shard}/3")).done();
    }
    place.run("merge shards").done();
    assert!(place.surface("1") == place.surface("shards"));
    place.assert_survives_kills("1", &[60, 150, 300, 500, 700], 2);
    // Nor do integrals over the map.
    place.write("exact.toml", &mapped("exact", FROM_REST, "method = \"exact\"\nderivatives = true"));
    for threads in [1, 3] {
        place.run(&format!("submit exact.toml --threads {threads} --out exact-{threads}")).done();
    }
    place.run("submit exact.toml --out exact-borrowed --map 1").done();
    for run in ["exact-3", "exact-borrowed"] {
        assert!(place.surface("exact-1") == place.surface(run), "{run}");
    }
    // A damaged piece of the map is found, and its tiles are resolved again.
    let piece = fs::read_dir(place.path("2/map")).unwrap().next().unwrap().unwrap().path();
    let mut bytes = fs::read(&piece).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&piece, bytes).unwrap();
    let resumed = place.run("submit job.toml --out 2 --samples 21000").done();
    assert!(resumed.stderr.contains("does not match the checksum"), "{}", resumed.stderr);
    place.run("submit job.toml --out direct --samples 21000").done();
    assert!(place.surface("2") == place.surface("direct"));
}

const UNTIL: &str = "until = { half_width = 0.01, confidence = 0.9, at_most = 60_000 }\nseed = 8";

#[test]
fn cells_get_as_many_samples_as_their_precision_needs() {
    let place = Place::new();
    let table = submitted(&place, "until", &job("until", EIGENVALUE, BOTH, UNTIL));
    let exact = submitted(&place, "exact", &job("exact", EIGENVALUE, BOTH, "method = \"exact\""));
    let (mut counts, mut missed) = (Vec::new(), 0);
    for row in 0..30 {
        let [n, low, high] = ["n_samples", "p_low", "p_high"].map(|name| table.column(name)[row]);
        assert!(0.5 * (high - low) <= 0.01 && n < 60_000.0 && n % 1000.0 == 0.0, "{n} {low} {high}");
        let p = exact.column("p_unstable")[row];
        missed += u32::from(p < low || p > high);
        counts.push((p * (1.0 - p), n));
    }
    assert!(missed <= 3, "{missed} of 30 intervals of 90 % miss the exact value");
    counts.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(counts[0].1 <= 1000.0 && counts[29].1 >= 8000.0, "{counts:?}");
    // Intervals that hold together need more samples.
    let together = submitted(&place, "together", &job("t", EIGENVALUE, BOTH, &format!("{UNTIL}\nsimultaneous = true")));
    assert!(together.column("n_samples").iter().sum::<f64>() > 1.5 * table.column("n_samples").iter().sum::<f64>());
    // Where the precision cannot be reached, sampling stops at the limit.
    let short =
        submitted(&place, "short", &job("s", EIGENVALUE, BOTH, "until = { half_width = 0.0001, at_most = 2500 }"));
    assert!(short.column("n_samples").iter().all(|&n| n == 2500.0));
    let status: Value = serde_json::from_str(&place.run("status until --json").done().stdout).unwrap();
    assert_eq!((&status["state"], &status["share_done"]), (&"finished".into(), &1.0.into()));
}

#[test]
fn stopping_does_not_depend_on_threads_shards_and_kills() {
    let place = Place::new();
    let until = "until = { half_width = 0.0012, at_most = 3_000_000 }";
    place.write("job.toml", &job("job", EIGENVALUE, BOTH, until));
    for threads in [1, 2, 3] {
        place.run(&format!("submit job.toml --threads {threads} --out {threads}")).done();
        assert!(place.surface("1") == place.surface(&threads.to_string()), "{threads} threads");
    }
    for shard in [3, 1, 4, 2] {
        place.run(&format!("submit job.toml --out shards --shard {shard}/4")).done();
    }
    place.run("merge shards").done();
    assert!(place.surface("1") == place.surface("shards"));
    place.assert_survives_kills("1", &[20, 30, 40, 60, 80, 100], 2);
}

#[test]
fn sobol_points_have_smaller_errors_and_valid_intervals() {
    let place = Place::new();
    let exact = submitted(&place, "exact", &job("exact", EIGENVALUE, BOTH, "method = \"exact\""));
    let sobol = submitted(&place, "sobol", &job("sobol", EIGENVALUE, BOTH, "method = \"sobol\"\nsamples = 16_384"));
    let plain = submitted(&place, "plain", &job("plain", EIGENVALUE, BOTH, "samples = 16_384"));
    let (mut missed, mut errors) = (0, [0.0, 0.0]);
    for row in 0..30 {
        let p = exact.column("p_unstable")[row];
        missed += u32::from(p < sobol.column("p_low")[row] || p > sobol.column("p_high")[row]);
        for (sum, table) in errors.iter_mut().zip([&sobol, &plain]) {
            *sum += (table.column("p_unstable")[row] - p).powi(2);
        }
    }
    assert!(missed <= 4, "{missed} of 30 intervals miss the exact value");
    assert!(25.0 * errors[0] < errors[1], "at equal samples the error is a fifth: {errors:?}");
    for threads in [1, 3] {
        place.run(&format!("submit sobol.toml --threads {threads} --out {threads}")).done();
        assert!(place.surface("sobol") == place.surface(&threads.to_string()));
    }
    // More points extend a run.
    place.run("submit sobol.toml --out sobol --samples 32768").done();
    place.run("submit sobol.toml --out more --samples 32768").done();
    assert!(place.surface("sobol") == place.surface("more"));
}

#[test]
fn intervals_have_the_widths_of_their_kinds() {
    let place = Place::new();
    let width = |name: &str, sampling: &str| -> Vec<f64> {
        let table = submitted(&place, name, &job(name, EIGENVALUE, BOTH, &format!("samples = 5000\n{sampling}")));
        table.column("p_low").iter().zip(table.column("p_high")).map(|(low, high)| high - low).collect()
    };
    let wilson = width("wilson", "");
    let exact = width("exact", "interval = \"clopper-pearson\"");
    let band = width("band", "interval = \"clopper-pearson\"\nsimultaneous = true");
    for row in 0..30 {
        assert!(wilson[row] < exact[row] * 1.2 && exact[row] < band[row], "{row}");
    }
    // At one half a band over 30 cells is z(1 - 0.025/30) / z(0.975) times as wide.
    let middle = (0..30).max_by(|&a, &b| exact[a].total_cmp(&exact[b])).unwrap();
    assert!((band[middle] / exact[middle] - 3.144 / 1.960).abs() < 0.02, "{}", band[middle] / exact[middle]);
}

#[test]
fn sobol_indices_agree_with_quadrature() {
    let place = Place::new();
    let table = submitted(&place, "s", &job("s", EIGENVALUE, BOTH, "samples = 50_000\nsensitivity = true"));
    let boundary = boundary(15.0);
    let mut checked = 0;
    for row in 0..30 {
        let [preload, friction] = ["preload", "static_friction"].map(|name| table.column(name)[row]);
        let given_preload = |z: f64| given_preload(&boundary, preload, friction, 0.2, z);
        let given_friction = |z: f64| {
            let critical = boundary.critical_first(friction * (1.0 + 0.2 * z));
            normal::upper_tail((critical / preload - 1.0) / 0.2)
        };
        let p = mean(given_preload);
        let variance = p * (1.0 - p);
        if variance < 0.02 {
            continue;
        }
        checked += 1;
        let explained = |f: &dyn Fn(f64) -> f64| (mean(|z| f(z) * f(z)) - p * p) / variance;
        let (by_preload, by_friction) = (explained(&given_preload), explained(&given_friction));
        for (name, first_order, total) in
            [("preload", by_preload, 1.0 - by_friction), ("static_friction", by_friction, 1.0 - by_preload)]
        {
            for (kind, expected) in [("first_order", first_order), ("total", total)] {
                let [value, error] = ["", "_error"].map(|suffix| table.column(&format!("{kind}_{name}{suffix}"))[row]);
                // Up to 120 values are compared at once, and the variance is an estimate, too.
                let allowed = 4.0 * error + 0.02 * expected;
                assert!((value - expected).abs() < allowed, "{kind} {name} {row}: {value} {expected} {error}");
            }
        }
    }
    assert!(checked >= 15, "{checked}");
}

#[test]
fn any_parameter_may_scatter() {
    let place = Place::new();
    let cell =
        "preload = { from = 0.05, to = 0.30, points = 6 }\nstatic_friction = { from = 0.28, to = 0.50, points = 5 }";
    let one = |name: &str, random: &str, sampling: &str| {
        let text = job(name, EIGENVALUE, random, sampling).replace(cell, "preload = 0.1\nstatic_friction = 0.385");
        let table = submitted(&place, name, &text);
        let [p, low, high] = ["p_unstable", "p_low", "p_high"].map(|column| table.column(column)[0]);
        (p, low, high)
    };
    // The critical damping over its expected value: the critical product is proportional to the damping.
    let ratio = 0.1 * (0.385 - 0.25) / boundary(15.0).critical_product;
    let damping = "inputs = [\"damping.tangential\"]\nrelative_std = 0.1";
    let t = (1.0_f64 + 0.01).ln().sqrt();
    for (name, random, expected) in [
        ("normal", damping.to_owned(), normal::upper_tail(-(ratio - 1.0) / 0.1)),
        (
            "lognormal",
            format!("{damping}\ndistribution = \"lognormal\""),
            normal::upper_tail(-(ratio.ln() + 0.5 * t * t) / t),
        ),
        (
            "uniform",
            format!("{damping}\ndistribution = \"uniform\""),
            0.5 + 0.5 * ((ratio - 1.0) / (0.1 * 3_f64.sqrt())).clamp(-1.0, 1.0),
        ),
        (
            "truncated",
            format!("{damping}\ndistribution = {{ \"damping.tangential\" = {{ truncated-normal = [-1.0, 2.0] }} }}"),
            {
                let [low, at, high] = [-1.0, (ratio - 1.0) / 0.1, 2.0].map(|z: f64| normal::upper_tail(-z));
                (at - low) / (high - low)
            },
        ),
    ] {
        assert!((0.02..0.98).contains(&expected), "{name}: {expected}");
        for (method, tolerance) in [("samples = 40_000", 0.011), ("method = \"sobol\"\nsamples = 16_384", 0.001)] {
            let (p, low, high) = one(name, &random, method);
            assert!((p - expected).abs() < tolerance, "{name}: {p} {expected}");
            assert!(low <= p && p <= high);
            fs::remove_dir_all(place.path(name)).unwrap();
        }
    }
    // Correlation: given the deviate z of the preload, that of friction is normal with mean rho z.
    let rho = -0.6;
    let correlated = format!("{BOTH}\ncorrelation = [[\"static_friction\", \"preload\", {rho}]]");
    let boundary = boundary(15.0);
    let expected = mean(|z| {
        let critical = (boundary.critical_second(0.1 * (1.0 + 0.2 * z)) / 0.385 - 1.0) / 0.2;
        normal::upper_tail((critical - rho * z) / (1.0 - rho * rho).sqrt())
    });
    let (p, ..) = one("correlated", &correlated, "method = \"sobol\"\nsamples = 32_768");
    assert!((p - expected).abs() < 0.002, "{p} {expected}");
    let mapped = one("looked-up", &correlated, "samples = 40_000\nevaluate = \"boundary\"");
    assert!((mapped.0 - expected).abs() < 0.011);
    // A stiffness below zero fails its sample, and widens the interval.
    let wild = one("wild", "inputs = [\"stiffness.contact_normal\"]\nrelative_std = 1.0", "samples = 5000");
    assert!(wild.2 - wild.1 > 0.15, "{wild:?}");
    let failed = Table::read(&place.path("wild/surface.parquet")).column("n_failed")[0];
    assert!((failed / 5000.0 - normal::upper_tail(1.0)).abs() < 0.02, "{failed}");
}

#[test]
fn a_brake_of_its_own_for_each_sample_gets_the_same_verdict() {
    // A random input without scatter makes every sample a brake of its own. Its verdict must be that of the preset's
    // brake with the same preload and static friction.
    let place = Place::new();
    let mut parameters = Parameters::sui_ding_2018();
    parameters.operating_point.rotating_speed = 15.0;
    let brake = PadOnDisc::new(parameters).unwrap();
    let in_time = |disc: &DiscModel| TimeDomain::new(&brake, disc, TimeDomainSettings::default()).unwrap();
    let (rigid, flexible) = (in_time(&DiscModel::Rigid), in_time(&DiscModel::Flexible { modes: 5 }));
    let modes = FlexibleBrake::with_modes(brake.clone(), 5).unwrap();
    let coupled = |inputs| modes.decide_with(inputs, FlexibleBrake::linear_stability);
    let decide: [(&str, &dyn Fn(RandomInputs) -> Decision); 3] = [
        ("kind = \"time-domain\"\ndisc = \"rigid\"", &|inputs| rigid.decide(inputs)),
        ("kind = \"time-domain\"\ndisc_modes = 5", &|inputs| flexible.decide(inputs)),
        ("kind = \"coupled-eigenvalue\"\ndisc_modes = 5", &coupled),
    ];
    for (criterion, decide) in decide {
        let random = "inputs = [\"preload\", \"static_friction\", \"friction.stribeck_velocity\"]\n\
            relative_std = { preload = 0.2, static_friction = 0.2, \"friction.stribeck_velocity\" = 0.0 }";
        let text = job("varying", criterion, random, "samples = 12");
        let table =
            submitted(&place, "varying", &text.replace("points = 6", "points = 3").replace("points = 5", "points = 2"));
        let mut found = [0.0; 2];
        for cell in 0..6 {
            let mut unstable = 0.0;
            for sample in 0..12 {
                let words = format!("replay varying --cell {cell} --sample {sample} --horizon 5 --json");
                let replayed: Value = serde_json::from_str(&place.run(&words).done().stdout).unwrap();
                let value = |name: &str| replayed[name].as_f64().unwrap();
                assert!((value("friction.stribeck_velocity") - 0.72).abs() < 1e-12);
                let inputs = RandomInputs { preload: value("preload"), static_friction: value("static_friction") };
                let expected = format!("{:?}", decide(inputs).verdict).to_lowercase();
                assert_eq!(replayed["verdict_in_run"], expected, "{criterion}: {inputs:?}");
                unstable += f64::from(u8::from(expected == "unstable"));
            }
            assert_eq!(unstable, table.column("n_unstable")[cell], "{criterion}, cell {cell}");
            found[usize::from(unstable > 0.0)] += 1.0;
        }
        assert!(found[0] > 0.0 && found[1] > 0.0, "{criterion}: cells without and with unstable samples, {found:?}");
        fs::remove_dir_all(place.path("varying")).unwrap();
    }
}

#[test]
fn samples_of_every_method_can_be_replayed() {
    let place = Place::new();
    for (name, sampling) in [
        ("sobol", "method = \"sobol\"\nsamples = 32\nrandomisations = 4"),
        ("map", "samples = 30\nevaluate = \"boundary\""),
        ("until", "until = { half_width = 0.49, at_most = 30 }"),
        ("looks", "until = { half_width = 0.021, at_most = 60_000 }"),
    ] {
        let table = submitted(&place, name, &job(name, RIGID, BOTH, sampling));
        let count = table.column("n_samples")[7] as u64;
        let outside = place.run(&format!("replay {name} --cell 7 --sample {count}"));
        outside.refused(64, &[&format!("has samples 0 to {}", count - 1)]);
        if name == "looks" {
            // The cell has several parts. The samples of the other jobs are replayed one by one.
            assert!(count > 2000);
            let last = place.run(&format!("replay {name} --cell 7 --sample {} --horizon 5 --json", count - 1)).done();
            assert!(last.stdout.contains("verdict_in_run"));
            continue;
        }
        let unstable = (0..count).filter(|sample| {
            let replayed = place.run(&format!("replay {name} --cell 7 --sample {sample} --horizon 5 --json")).done();
            serde_json::from_str::<Value>(&replayed.stdout).unwrap()["verdict_in_run"] == "unstable"
        });
        assert_eq!(unstable.count() as f64, table.column("n_unstable")[7], "{name}");
    }
    submitted(&place, "exact", &job("exact", RIGID, BOTH, "method = \"exact\""));
    place.run("replay exact --cell 0 --sample 0").refused(64, &["no samples to replay"]);
}

/// Jobs of every method, whose columns are pinned below.
fn every_method() -> [(&'static str, String); 6] {
    let varied = "inputs = [\"preload\", \"static_friction\", \"stiffness.contact_normal\", \"damping.tangential\", \"pad.mass\"]\n\
        relative_std = 0.15\n\
        distribution = { preload = \"lognormal\", \"damping.tangential\" = \"uniform\", \"pad.mass\" = { truncated-normal = [-1.0, 2.0] } }\n\
        correlation = [[\"preload\", \"static_friction\", 0.4]]";
    [
        ("exact", job("m", EIGENVALUE, BOTH, "method = \"exact\"\nderivatives = true")),
        ("mapped", job("m", FROM_REST, BOTH, "method = \"exact\"\nderivatives = true")),
        (
            "boundary",
            job(
                "m",
                FROM_REST,
                BOTH,
                "samples = 3000\nevaluate = \"boundary\"\nderivatives = true\nsensitivity = true",
            ),
        ),
        ("sobol", job("m", EIGENVALUE, varied, "method = \"sobol\"\nsamples = 2048")),
        ("varied", job("m", EIGENVALUE, varied, "samples = 2000\ninterval = \"clopper-pearson\"")),
        ("until", job("m", RIGID, BOTH, "until = { half_width = 0.03, at_most = 9000 }\nsimultaneous = true")),
    ]
}

#[test]
fn result_columns_are_pinned() {
    // Regression values of results version 1.
    let place = Place::new();
    let digests = every_method().map(|(name, text)| (name, submitted(&place, name, &text).digest()));
    let digests: Vec<(&str, &str)> = digests.iter().map(|(name, digest)| (*name, digest.as_str())).collect();
    assert_eq!(
        digests,
        [
            ("exact", "d14ea0d09c533ba7eefb7db31bce257d"),
            ("mapped", "0d622319a85af366185314f46083bb81"),
            ("boundary", "e517669b6ae93105ddba54ecfce959bf"),
            ("sobol", "877a7a6722203b0241d51f2635dcfb81"),
            ("varied", "2c91640535a957153ad2c99f5802d6e7"),
            ("until", "ad3a12a5d2332d34022c22f396da8af4"),
        ]
    );
}

#[test]
fn the_processor_does_not_change_a_byte() {
    let here = Place::new();
    let there = Place::new().with_environment("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-AVX2");
    for (name, text) in every_method() {
        for place in [&here, &there] {
            submitted(place, name, &text);
        }
        assert!(here.surface(name) == there.surface(name), "{name}");
    }
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let place = Place::new();
    let third = "inputs = [\"preload\", \"stiffness.contact_normal\"]\nrelative_std = 0.1";
    let lognormal = "inputs = [\"preload\"]\nrelative_std = 0.1\ndistribution = \"lognormal\"";
    let recorded = "kind = \"time-domain\"\nrecord = [\"amplitude\"]";
    for (criterion, random, sampling, texts) in [
        (EIGENVALUE, BOTH, "method = \"exact\"\nsamples = 5", &["job.toml:17", "draws no samples"][..]),
        (EIGENVALUE, BOTH, "method = \"exact\"\nuntil = { half_width = 0.1, at_most = 5 }", &["draws no samples"]),
        (EIGENVALUE, BOTH, "method = \"exact\"\nsimultaneous = true", &["job.toml:17", "draws no samples"]),
        (
            EIGENVALUE,
            BOTH,
            "confidence = 0.999999999999\nsimultaneous = true",
            &["job.toml:16", "30 cells together", "1 - 1e-12"],
        ),
        (EIGENVALUE, BOTH, "method = \"magic\"", &["job.toml:16", "`magic`", "`exact`"]),
        (
            EIGENVALUE,
            third,
            "method = \"exact\"",
            &["job.toml:16", "stiffness.contact_normal", "\"monte-carlo\" or \"sobol\""],
        ),
        (RIGID, third, "evaluate = \"boundary\"", &["job.toml:17", "stiffness.contact_normal"]),
        (RIGID, lognormal, "method = \"exact\"", &["independent normal inputs", "verdict map", "\"eigenvalue\""]),
        (EIGENVALUE, lognormal, "derivatives = true", &["independent normal inputs"]),
        (recorded, BOTH, "evaluate = \"boundary\"", &["criterion.record"]),
        (EIGENVALUE, BOTH, "until = { half_width = 0.7, at_most = 5 }", &["half_width = 0.7", "less than 0.5"]),
        (EIGENVALUE, BOTH, "until = { half_width = 0.1, at_most = 0 }", &["until.at_most = 0"]),
        (
            EIGENVALUE,
            BOTH,
            "until = { half_width = 0.1, at_most = 5 }\nsamples = 7",
            &["samples has no meaning", "remove sampling.until"],
        ),
        (
            EIGENVALUE,
            BOTH,
            "until = { half_width = 0.1, at_most = 5 }\nconfidence = 0.9",
            &["confidence has no meaning", "until = { ..., confidence = ..."],
        ),
        (
            EIGENVALUE,
            BOTH,
            "method = \"sobol\"\nsamples = 1000",
            &["samples = 1000", "16 randomisations", "samples = 1024"],
        ),
        (EIGENVALUE, BOTH, "method = \"sobol\"\nrandomisations = 1", &["randomisations = 1", "at least 2"]),
        (EIGENVALUE, BOTH, "randomisations = 4", &["has no meaning", "use method = \"sobol\""]),
        (EIGENVALUE, BOTH, "audit = 0.1", &["belongs to evaluate = \"boundary\""]),
        (EIGENVALUE, BOTH, "evaluate = \"boundary\"\naudit = 1.5", &["audit = 1.5", "at most 1"]),
        (EIGENVALUE, BOTH, "sensitivity = true\nmethod = \"sobol\"", &["sensitivity"]),
        (EIGENVALUE, "inputs = [\"preload\"]\nrelative_std = 0.1", "sensitivity = true", &["at least 2 of them"]),
        (
            EIGENVALUE,
            "inputs = [\"contact_normal\"]\nrelative_std = 0.1",
            "",
            &["job.toml:9:11", "`stiffness.contact_normal`?"],
        ),
        (
            EIGENVALUE,
            "inputs = [\"friction.static_coefficient\"]\nrelative_std = 0.1",
            "",
            &["write \"static_friction\""],
        ),
        (
            EIGENVALUE,
            "inputs = [\"preload\"]\nrelative_std = { preload = 0.1, \"pad.mass\" = 0.1 }",
            "",
            &["does not list pad.mass"],
        ),
        (
            EIGENVALUE,
            "inputs = [\"preload\", \"static_friction\"]\nrelative_std = 0.1\ncorrelation = [[\"preload\", \"static_friction\", 1.5]]",
            "",
            &["preload and static_friction is 1.5"],
        ),
        (
            EIGENVALUE,
            "inputs = [\"preload\"]\nrelative_std = 0.1\ndistribution = { truncated-normal = [1.0, -1.0] }",
            "",
            &["job.toml:11", "low must be less than high"],
        ),
        (
            EIGENVALUE,
            "inputs = [\"pad.mass\"]\nrelative_std = 0.9\ndistribution = \"uniform\"",
            "",
            &["pad.mass", "0.57735"],
        ),
    ] {
        place.write("job.toml", &job("job", criterion, random, sampling));
        place.run("check job.toml").refused(65, texts);
    }
}
