//! Every sample of a cell in a file of its own.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs::{self, File};

use crate::common::{BOTH, EIGENVALUE, Place, Table, job, submitted, texts};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::Value;

/// Asserts that the samples of a cell have the counts of its row in the surface, and returns their verdicts.
#[track_caller]
fn assert_counts(place: &Place, surface: &Table, run: &str, cell: usize) -> Vec<String> {
    place.run(&format!("samples {run} --cell {cell}")).done();
    let path = place.path(&format!("{run}/samples-{cell}.parquet"));
    let verdicts: Vec<String> = texts(&path, "verdict").into_iter().flatten().collect();
    assert_eq!(verdicts.len() as f64, surface.column("n_samples")[cell], "{run}");
    for verdict in ["stable", "unstable", "undecided", "failed"] {
        let count = verdicts.iter().filter(|other| *other == verdict).count();
        assert_eq!(count as f64, surface.column(&format!("n_{verdict}"))[cell], "{run}: {verdict}");
    }
    let table = Table::read(&path);
    let numbers: Vec<f64> = (0..verdicts.len()).map(|number| number as f64).collect();
    assert_eq!(table.column("sample"), numbers, "{run}");
    let outside: f64 = table.column("outside_physics").iter().sum();
    assert_eq!(outside, surface.column("n_outside_physics")[cell], "{run}");
    verdicts
}

#[test]
fn the_samples_of_a_cell_have_the_counts_of_its_row() {
    let place = Place::new();
    let rigid = "kind = \"time-domain\"\ndisc = \"rigid\"";
    for (name, criterion, random, sampling) in [
        ("plain", EIGENVALUE, BOTH, "samples = 3000\nseed = 4"),
        ("long", EIGENVALUE, BOTH, "samples = 45_000"),
        ("failed", "kind = \"eigenvalue\"\noutside_physics = \"failed\"", BOTH, "samples = 3000"),
        ("sobol", EIGENVALUE, BOTH, "method = \"sobol\"\nsamples = 4096\nrandomisations = 4"),
        ("until", EIGENVALUE, BOTH, "until = { half_width = 0.02, at_most = 100_000 }"),
        ("time", rigid, BOTH, "samples = 60"),
        ("map", rigid, BOTH, "samples = 2000\nevaluate = \"boundary\"\naudit = 20"),
    ] {
        let surface = submitted(&place, name, &job(name, criterion, random, sampling));
        let verdicts = assert_counts(&place, &surface, name, 17);
        assert!(verdicts.iter().any(|verdict| verdict != &verdicts[0]), "{name}: all are alike");
    }
    // As CSV the same values in the same order, and no file.
    let table = Table::read(&place.path("long/samples-17.parquet"));
    fs::remove_file(place.path("long/samples-17.parquet")).unwrap();
    let printed = place.run("samples long --cell 17 --csv").done().stdout;
    let mut lines = printed.lines();
    assert_eq!(lines.next(), Some("sample,preload,static_friction,verdict,outside_physics"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    for (place_in_row, name) in ["sample", "preload", "static_friction"].into_iter().enumerate() {
        let column: Vec<f64> = rows.iter().map(|row| row[place_in_row].parse().unwrap()).collect();
        assert_eq!(column, table.column(name), "{name}");
    }
    assert!(!place.path("long/samples-17.parquet").exists());
    place.run("samples long --cell 17 --csv --out a.parquet").refused(64, &["cannot be used with"]);
    place.run("samples long --cell 17").done();
    // The same bytes from any number of threads.
    place.run("samples long --cell 17 --out again.parquet --threads 1").done();
    assert_eq!(
        fs::read(place.path("long/samples-17.parquet")).unwrap(),
        fs::read(place.path("again.parquet")).unwrap()
    );
}

#[test]
fn a_sample_has_the_inputs_and_the_verdict_that_replay_shows() {
    let place = Place::new();
    let random = "inputs = [\"preload\", \"rotating_speed\", \"stiffness.contact_normal\", \"start.velocity\"]\n\
        relative_std = 0.1\nstd = { \"start.velocity\" = 0.2 }";
    let criterion = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = { velocity = 0.3 }\nrecord = [\"amplitude\"]";
    let surface = submitted(&place, "run", &job("run", criterion, random, "samples = 40"));
    let verdicts = assert_counts(&place, &surface, "run", 8);
    let path = place.path("run/samples-8.parquet");
    let table = Table::read(&path);
    assert_eq!(
        table.names(),
        [
            "sample",
            "preload",
            "stiffness.contact_normal",
            "rotating_speed_rad_s",
            "start.velocity",
            "verdict",
            "outside_physics",
            "amplitude"
        ]
    );
    for sample in [0, 23, 39] {
        let replayed = place.run(&format!("replay run --cell 8 --sample {sample} --horizon 1 --json")).done().stdout;
        let replayed: Value = serde_json::from_str(&replayed).unwrap();
        for name in &table.names()[1..5] {
            // The reader of JSON rounds the last digit.
            let ratio = replayed[name].as_f64().unwrap() / table.column(name)[sample];
            assert!((ratio - 1.0).abs() < 1e-14, "{name} of sample {sample}: {ratio}");
        }
        assert_eq!(replayed["verdict_in_run"], *verdicts[sample]);
    }
    // An unstable sample has an amplitude, the others have none; their mean is that of the surface.
    let amplitudes = table.column("amplitude");
    let settled: Vec<f64> = amplitudes.iter().copied().filter(|amplitude| !amplitude.is_nan()).collect();
    assert_eq!(settled.len() as f64, surface.column("n_unstable")[8]);
    let mean = settled.iter().sum::<f64>() / settled.len() as f64;
    assert!((mean / surface.column("amplitude_mean")[8] - 1.0).abs() < 1e-2, "{mean}");

    // Units, meaning and the job travel with the file.
    let schema = ParquetRecordBatchReaderBuilder::try_new(File::open(&path).unwrap()).unwrap().schema().clone();
    let unit = |name: &str| schema.field_with_name(name).unwrap().metadata()["unit"].clone();
    let units = ["preload", "rotating_speed_rad_s", "stiffness.contact_normal", "start.velocity"].map(unit);
    assert_eq!(units, ["1", "rad/s", "N/m", "m/s"]);
    let of_surface = |key: &str| surface.footer.iter().find(|(other, _)| other == key).unwrap().1.clone();
    for (key, value) in &table.footer {
        let expected = if key == "stickslip:cell" { "8".to_owned() } else { of_surface(key) };
        assert_eq!(value, &expected, "{key}");
    }
    assert!(table.footer.iter().any(|(key, _)| key == "stickslip:job_hash"));
}

#[test]
fn what_feeds_a_sample_is_printed_where_there_is_a_disc() {
    let place = Place::new();
    let surface =
        submitted(&place, "run", &job("run", "kind = \"coupled-eigenvalue\"\ndisc_modes = 5", BOTH, "samples = 12"));
    let verdicts = assert_counts(&place, &surface, "run", 18);
    let fed_by = texts(&place.path("run/samples-18.parquet"), "fed_by");
    for (verdict, freedom) in verdicts.iter().zip(&fed_by) {
        assert_eq!(verdict == "unstable", freedom.is_some());
    }
    let tangential = fed_by.iter().flatten().filter(|freedom| *freedom == "tangential").count();
    assert_eq!(tangential as f64, surface.column("n_fed_tangential")[18]);
}

#[test]
fn what_cannot_be_written_is_refused() {
    let place = Place::new();
    let text = job("run", EIGENVALUE, BOTH, "samples = 100");
    submitted(&place, "run", &text);
    place.run("samples run --cell 30").refused(64, &["--cell 30: the run has cells 0 to 29"]);
    place.run("samples run --cell 0 --out samples.csv").refused(64, &["name it samples.parquet"]);
    place.run("samples missing --cell 0").refused(74, &["missing is not a run directory"]);
    submitted(&place, "exact", &job("exact", EIGENVALUE, BOTH, "method = \"exact\""));
    place.run("samples exact --cell 0").refused(64, &["integrates its probabilities", "no samples"]);
    // One shard of a run that is not finished.
    place.run("submit run.toml --shard 1/2 --out half").done();
    let missing =
        (0..30).map(|cell| place.run(&format!("samples half --cell {cell}"))).find(|outcome| outcome.code != Some(0));
    missing.unwrap().refused(65, &["of half is not finished, it has 0 samples", "`stickslip resume half`"]);
    // Samples are held in memory.
    let many = text.replace("points = 6", "points = 1").replace("from = 0.05, to", "from = 0.30, to");
    let many = many.replace("static_friction = { from = 0.28, to = 0.50, points = 5 }", "static_friction = 0.4");
    submitted(&place, "many", &many.replace("samples = 100", "samples = 10_000_001"));
    place
        .run("samples many --cell 0")
        .refused(64, &["cell 0 has 10,000,001 samples", "10,000,000 at most", "replay many"]);
}
