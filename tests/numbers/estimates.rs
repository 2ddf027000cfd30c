//! Estimates through the command line: intervals, stopping by precision, derivatives, and Sobol indices with samples
//! that have no verdict.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use crate::common::{BOTH, EIGENVALUE, Place, Table, job, submitted};
use stickslip_sampler::estimate::interval::{BinomialInterval, IntervalKind};

#[test]
fn intervals_are_clopper_pearson_at_high_confidence() {
    let place = Place::new();
    for (name, sampling, kind, confidence) in [
        ("plain", "", IntervalKind::Wilson, 0.95),
        ("exact", "interval = \"clopper-pearson\"", IntervalKind::ClopperPearson, 0.95),
        ("sure", "confidence = 0.99", IntervalKind::ClopperPearson, 0.99),
        ("band", "simultaneous = true", IntervalKind::ClopperPearson, 1.0 - 0.05 / 30.0),
        ("low-band", "simultaneous = true\nconfidence = 0.5", IntervalKind::ClopperPearson, 1.0 - 0.5 / 30.0),
    ] {
        let table = submitted(&place, name, &job(name, EIGENVALUE, BOTH, &format!("samples = 2000\n{sampling}")));
        let interval = BinomialInterval::new(kind, confidence);
        for row in 0..30 {
            let [unstable, low, high] = ["n_unstable", "p_low", "p_high"].map(|column| table.column(column)[row]);
            let (expected_low, expected_high) = interval.bounds(unstable as u64, 2000);
            assert!((low - expected_low).abs() < 1e-12 && (high - expected_high).abs() < 1e-12, "{name} {row}");
        }
    }
    for (sampling, texts) in [
        ("interval = \"wilson\"\nsimultaneous = true", ["job.toml:16", "clopper-pearson"]),
        ("interval = \"wilson\"\nconfidence = 0.99", ["0.99, above 0.95", "clopper-pearson"]),
    ] {
        place.write("job.toml", &job("job", EIGENVALUE, BOTH, sampling));
        place.run("check job.toml").refused(65, &texts);
    }
}

#[test]
fn a_relative_precision_is_reached_and_its_limit_can_be_raised() {
    let place = Place::new();
    let text = |at_most: u64| {
        job(
            "until",
            EIGENVALUE,
            BOTH,
            &format!("until = {{ relative = 0.05, at_most = {at_most} }}\nderivatives = true"),
        )
    };
    let first = submitted(&place, "short", &text(20_500));
    let wanting = |table: &Table| {
        let (low, high, samples) = (table.column("p_low"), table.column("p_high"), table.column("n_samples"));
        let is_short = |row: &usize| high[*row] - low[*row] > 0.05 * (high[*row] + low[*row]);
        (0..30).filter(is_short).map(|row| samples[row]).collect::<Vec<_>>()
    };
    assert!(wanting(&first).len() > 3 && wanting(&first).iter().all(|&samples| samples == 20_500.0));
    // A limit that is raised in the job, on the command line, or given at the start leads to the same bytes.
    place.run("submit short.toml --out raised").done();
    place.write("longer.toml", &text(150_000));
    for run in ["short", "direct"] {
        place.run(&format!("submit longer.toml --out {run}")).done();
    }
    let outcome = place.run("submit short.toml --out raised --samples 150000").done();
    assert!(outcome.stderr.contains("from at most 20500 to at most 150000 samples"), "{}", outcome.stderr);
    assert!(place.surface("short") == place.surface("direct") && place.surface("raised") == place.surface("direct"));
    let direct = Table::read(&place.path("direct/surface.parquet"));
    assert!(wanting(&direct).len() < wanting(&first).len());
    place.run("submit short.toml --out direct").refused(65, &["at most 150000 samples", "--samples 150000"]);
    // With both precisions, the first that is reached counts.
    let either = "until = { relative = 0.1, half_width = 0.005 }";
    let table = submitted(&place, "either", &job("either", EIGENVALUE, BOTH, either));
    for row in 0..30 {
        let [low, high] = ["p_low", "p_high"].map(|column| table.column(column)[row]);
        assert!(high - low <= 0.01 || high - low <= 0.1 * (high + low), "{row}: {low} {high}");
    }
    for (until, text) in [
        ("{ at_most = 5000 }", "half_width"),
        ("{ relative = 1.5 }", "relative = 1.5 is out of range"),
        ("{ relative = 0.0 }", "relative = 0 is out of range"),
    ] {
        place.write("job.toml", &job("job", EIGENVALUE, BOTH, &format!("until = {until}")));
        place.run("check job.toml").refused(65, &["job.toml:16", text]);
    }
}

#[test]
fn rare_events_are_not_underestimated_when_stopping() {
    // Means over 600 cells with one probability: of p_unstable, and of the share of unstable samples, which is biased.
    let place = Place::new();
    let cells: Vec<String> = (0..600).map(|i| format!("{}", 0.05 + 1e-9 * f64::from(i))).collect();
    let text = |sampling: &str| {
        job("rare", EIGENVALUE, BOTH, sampling)
            .replace("{ from = 0.05, to = 0.30, points = 6 }", &format!("[{}]", cells.join(", ")))
            .replace("{ from = 0.28, to = 0.50, points = 5 }", "0.29")
    };
    let exact = submitted(&place, "exact", &text("method = \"exact\"")).column("p_unstable")[0];
    assert!((5e-4..3e-3).contains(&exact), "{exact}");
    let half_width = 2.0 * exact;
    let table = submitted(&place, "until", &text(&format!("until = {{ half_width = {half_width} }}\nseed = 3")));
    let [p, unstable, samples] = ["p_unstable", "n_unstable", "n_samples"].map(|column| table.column(column));
    let mean = |values: &mut dyn Iterator<Item = f64>| values.sum::<f64>() / 600.0;
    let estimate = mean(&mut p.iter().copied());
    let error = (mean(&mut p.iter().map(|p| (p - estimate) * (p - estimate))) / 600.0).sqrt();
    let share = mean(&mut (0..600).map(|row| unstable[row] / samples[row]));
    assert!((estimate - exact).abs() < 4.0 * error, "{estimate} +- {error}, {exact}");
    assert!(exact - share > 0.05 * exact, "the share is biased: {share}, {exact}");
}

#[test]
fn derivatives_are_withheld_where_few_samples_are_unstable_or_stable() {
    let place = Place::new();
    let text = |sampling: &str| job("d", EIGENVALUE, BOTH, &format!("{sampling}\nderivatives = true"));
    let sampled = submitted(&place, "sampled", &text("samples = 3000"));
    let [stable, unstable] = ["n_stable", "n_unstable"].map(|column| sampled.column(column));
    let mut withheld = 0;
    for column in ["dp_dpreload", "dp_dpreload_error", "dp_dstd_static_friction", "dp_dstd_static_friction_error"] {
        for (row, value) in sampled.column(column).iter().enumerate() {
            let is_rare = unstable[row].min(stable[row]) < 30.0;
            withheld += u32::from(is_rare);
            assert_eq!(value.is_nan(), is_rare, "{column} {row}: {value}");
        }
    }
    assert!(withheld > 0);
}

#[test]
fn derivatives_leave_undecided_samples_out_by_the_quotient_rule() {
    // With a short horizon, many samples are undecided. The reference is an integral over the verdict map.
    let place = Place::new();
    let criterion = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"\nhorizon = 4.0";
    let text = |sampling: &str| {
        job("d", criterion, BOTH, &format!("{sampling}\nderivatives = true"))
            .replace("{ from = 0.05, to = 0.30, points = 6 }", "[0.1, 0.2]")
            .replace("{ from = 0.28, to = 0.50, points = 5 }", "[0.36, 0.42]")
    };
    let exact = submitted(&place, "exact", &text("method = \"exact\"\naudit = 0"));
    let sampled = submitted(&place, "sampled", &text("samples = 20_000"));
    let mut checked = 0;
    for row in 0..4 {
        let undecided = sampled.column("n_undecided")[row] / 20_000.0;
        for column in ["dp_dpreload", "dp_dstatic_friction"] {
            let [value, error] = ["", "_error"].map(|suffix| sampled.column(&format!("{column}{suffix}"))[row]);
            let truth = exact.column(column)[row];
            if undecided > 0.05 && !value.is_nan() {
                checked += 1;
                assert!(
                    (value - truth).abs() < 4.0 * error,
                    "{column} {row}: {value} +- {error}, {truth}; {undecided}"
                );
            }
        }
    }
    assert!(checked >= 2, "{checked}");
}

#[test]
fn sobol_indices_do_not_attribute_failed_samples_to_an_input() {
    // The moment of inertia does not enter the tangential motion; one value in six is below zero.
    let place = Place::new();
    let inputs = "inputs = [\"preload\", \"static_friction\", \"pad.moment_of_inertia\"]\n\
        relative_std = { preload = 0.2, static_friction = 0.2, \"pad.moment_of_inertia\" = 1.0 }";
    let table = submitted(&place, "s", &job("s", EIGENVALUE, inputs, "samples = 3000\nsensitivity = true"));
    let [failed, left_out] = ["n_failed", "n_left_out_pad.moment_of_inertia"].map(|name| table.column(name));
    for row in 0..30 {
        let total = table.column("total_pad.moment_of_inertia")[row];
        assert!(total.is_nan() || total == 0.0, "{row}: {total}");
        // A sample is left out if it, its partner or the mixture failed.
        assert!(failed[row] > 300.0 && left_out[row] > failed[row] && left_out[row] < 3.0 * failed[row]);
    }
    assert!(table.column("total_preload").iter().any(|&total| total > 0.3));
    let correlated = format!("{BOTH}\ncorrelation = [[\"preload\", \"static_friction\", 0.3]]");
    place.write("job.toml", &job("job", EIGENVALUE, &correlated, "sensitivity = true"));
    place.run("check job.toml").refused(65, &["sampling.sensitivity", "random.correlation"]);
}

const FROM_REST: &str = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"rest\"";

#[test]
fn a_half_width_is_shared_with_the_audit_of_a_map() {
    let place = Place::new();
    let text = |sampling: &str| job("u", FROM_REST, BOTH, &format!("{sampling}\nevaluate = \"boundary\""));
    let table = submitted(&place, "u", &text("until = { half_width = 0.02 }"));
    for row in 0..30 {
        let [low, high, audit] = ["p_low", "p_high", "p_audit"].map(|column| table.column(column)[row]);
        assert!(0.5 * (high - low) <= 0.02 && (0.005..0.011).contains(&audit), "{row}: {low} {high} {audit}");
    }
    for (sampling, texts) in [
        (
            "until = { half_width = 0.005 }\naudit = 300",
            ["half_width = 0.005 cannot be reached with sampling.audit = 300", "audit = 0"],
        ),
        ("until = { relative = 0.05 }", ["sampling.until.relative cannot be kept with a verdict map", "audit = 0"]),
        ("until = { half_width = 0.01 }\naudit = 0.1", ["whole number", "job.toml:18"]),
        ("audit = 1", ["audit = 1.0", "job.toml:18"]),
        ("audit = \"all\"", ["whole number of samples", "300"]),
        ("until = 0.01", ["until = { half_width = 0.005 }", "job.toml:18"]),
    ] {
        place.write("job.toml", &text(sampling));
        place.run("check job.toml").refused(65, &texts);
    }
    // Without an audit, the counts may use all of the precision.
    let table = submitted(&place, "trusted", &text("until = { relative = 0.2, at_most = 20_000 }\naudit = 0"));
    assert!(table.column("p_audit").iter().all(|share| share.is_nan()));
}

#[test]
fn replay_distinguishes_looked_up_from_simulated_verdicts() {
    let place = Place::new();
    submitted(&place, "map", &job("map", FROM_REST, BOTH, "samples = 3000\nevaluate = \"boundary\""));
    let replayed = |words: &str| -> serde_json::Value {
        serde_json::from_str(&place.run(&format!("replay {words} --horizon 5 --json")).done().stdout).unwrap()
    };
    let looked_up = replayed("map --cell 7 --sample 2000");
    assert_eq!(looked_up["verdict_looked_up"], looked_up["verdict_in_run"]);
    assert_eq!(looked_up["verdict_simulated"], looked_up["verdict_in_run"]);
    // An audited sample.
    let simulated = replayed("map --cell 7 --sample 200");
    assert!(simulated["verdict_in_run"].is_string() && simulated["verdict_looked_up"].is_null());
}
