//! The friction oscillator on a belt as a job: what it refuses, in its own words, and where its numbers lie.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs::File;

use crate::common::{Place, Table};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

const EIGENVALUE: &str = "kind = \"eigenvalue\"";
const IN_TIME: &str = "kind = \"time-domain\"";

/// A job of an oscillator: further keys of [model], its law of friction, axes and random inputs, and its criterion.
fn job(model: &str, friction: &str, scatter: &str, criterion: &str) -> String {
    format!(
        "name = \"belt\"\n[model]\nkind = \"belt-oscillator\"\ndamping = 0.1\nnormal_force = 10.0\nbelt_speed = 0.5\n{model}\n\
         [model.friction]\n{friction}\n{scatter}\n[criterion]\n{criterion}\n[sampling]\nsamples = 20\n"
    )
}

const SLOW: &str = "mass = 1.0\nstiffness = 1.0";
const STRIBECK: &str = "static_coefficient = 0.6\nkinetic_coefficient = 0.3\nstribeck_velocity = 0.5";
const TABLE: &str = "law = \"table\"\ntable = { speed = [0.0, 1.0, 2.0], coefficient = [0.6, 0.4, 0.3] }";

#[test]
fn what_belongs_to_another_law_does_not_vary() {
    let place = Place::new();
    for (friction, scatter, named) in [
        (TABLE, "[axes]\nkinetic_coefficient = [0.2, 0.3]", "axes: kinetic_coefficient"),
        (TABLE, "[random]\ninputs = [\"stribeck_velocity\"]\nrelative_std = 0.1", "random.inputs: stribeck_velocity"),
        (STRIBECK, "[random]\ninputs = [\"band\"]\nstd = { band = 1.0 }", "random.inputs: band"),
        (TABLE, "[random]\ninputs = [\"band\"]\nstd = { band = 1.0 }", "no column std"),
    ] {
        place.write("job.toml", &job(SLOW, friction, scatter, EIGENVALUE));
        place.run("check job.toml").refused(65, &[named]);
    }
    // With its own law, and the pair with any.
    for (friction, scatter) in [
        ("static_coefficient = 0.6\nstribeck_velocity = 0.5", "[axes]\nkinetic_coefficient = [0.2, 0.3]"),
        (TABLE, "[random]\ninputs = [\"normal_force\"]\nrelative_std = 0.1"),
    ] {
        place.write("job.toml", &job(SLOW, friction, scatter, EIGENVALUE));
        place.run("check job.toml").done();
    }
}

#[test]
fn one_error_is_one_complaint() {
    let place = Place::new();
    let place_of = |model: &str, friction: &str, criterion: &str, scatter: &str, text: &str| {
        place.write("job.toml", &job(model, friction, scatter, criterion));
        let said = place.run("check job.toml").refused(65, &[text]).stderr;
        assert_eq!(said.matches("job.toml").count(), 1, "{said}");
    };
    place_of("mass = 1.0\nstiffness = -1.0", STRIBECK, EIGENVALUE, "", "model.stiffness = -1 is out of range");
    place_of(SLOW, "law = \"coulomb\"", EIGENVALUE, "", "coulomb");
    let start = "[axes]\n\"start.velocity\" = [0.0, 0.1]";
    place_of(SLOW, STRIBECK, EIGENVALUE, start, "axes.start.velocity is a number of the start");
}

#[test]
fn amplitudes_are_in_metres() {
    let place = Place::new();
    place.write(
        "job.toml",
        &job(SLOW, STRIBECK, "", "kind = \"time-domain\"\nstart = \"rest\"\nrecord = [\"amplitude\"]"),
    );
    place.run("submit job.toml").done();
    let surface = place.path("runs/belt/surface.parquet");
    let schema = ParquetRecordBatchReaderBuilder::try_new(File::open(&surface).unwrap()).unwrap().schema().clone();
    assert_eq!(schema.field_with_name("amplitude_mean").unwrap().metadata()["unit"], "m");
    // Twice the distance between the ends of stick: the mass is dragged until static friction gives way.
    let mean = Table::read(&surface).column("amplitude_mean")[0];
    assert!((0.5 * 0.3 * 10.0..0.7 * 10.0).contains(&mean), "{mean}");
    place.run("report runs/belt").done();
    let report = std::fs::read_to_string(place.path("runs/belt/report.html")).unwrap();
    assert!(report.contains("\"scale\":1000") && report.contains("\"unit\":\"mm\""), "amplitudes in m are shown in mm");
}

#[test]
fn fast_oscillators_have_a_horizon_that_they_can_reach() {
    let place = Place::new();
    // 225 Hz; 10 000 s would be too many steps.
    place.write("job.toml", &job("mass = 1.0\nstiffness = 2e6", STRIBECK, "", IN_TIME));
    place.run("submit job.toml").done();
    let table = Table::read(&place.path("runs/belt/surface.parquet"));
    assert_eq!(table.column("n_failed")[0] + table.column("n_undecided")[0], 0.0);
}

#[test]
fn analyse_takes_an_oscillator_without_normal_force_and_one_at_the_edge() {
    let place = Place::new();
    let text = job(SLOW, STRIBECK, "", EIGENVALUE);
    place.write("job.toml", &text.replace("normal_force = 10.0", "normal_force = 0.0"));
    place.run("analyse --job job.toml").done();
    // Steady sliding that rounding leaves with a speed below 0 came to a panic.
    let edge = text
        .replace("mass = 1.0\nstiffness = 1.0", "mass = 0.0068039756726080095\nstiffness = 16.400237891648526")
        .replace("damping = 0.1\nnormal_force = 10.0\nbelt_speed = 0.5", "damping = 0.0\nnormal_force = 0.4055642483713161\nbelt_speed = 0.0667082381660945")
        .replace(STRIBECK, "static_coefficient = 0.532563434691326\nkinetic_coefficient = 0.3220468535000858\nstribeck_velocity = 0.28022462984092034\nstribeck_exponent = 3.3\nviscous = 3.2691892788029273");
    place.write("job.toml", &edge);
    place.run("analyse --job job.toml").done();
}

#[test]
fn analyse_names_every_range_of_speed_in_which_sliding_is_unstable() {
    let place = Place::new();
    // The curve falls, rises and falls again.
    let wavy = "law = \"table\"\ntable = { speed = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0], coefficient = [0.6, 0.4, 0.5, 0.55, 0.3, 0.3] }";
    let grid = "[axes]\nbelt_speed = { from = 0.05, to = 3.0, points = 60 }\n[random]\ninputs = []";
    place.write("job.toml", &job(SLOW, wavy, grid, EIGENVALUE).replace("belt_speed = 0.5\n", ""));
    let json: serde_json::Value =
        serde_json::from_str(&place.run("analyse --job job.toml --json").done().stdout).unwrap();
    let ranges: Vec<[f64; 2]> = serde_json::from_value(json["unstable_speeds"].clone()).unwrap();
    assert_eq!(ranges.len(), 2, "{ranges:?}");
    // As the samples at 60 speeds say.
    place.run("submit job.toml").done();
    let table = Table::read(&place.path("runs/belt/surface.parquet"));
    for (&speed, &probability) in table.column("belt_speed").iter().zip(table.column("p_unstable")) {
        let is_in = ranges.iter().any(|&[from, to]| from < speed && speed < to);
        assert_eq!(is_in, probability == 1.0, "{speed}: {probability}, {ranges:?}");
    }
    let text = place.run("analyse --job job.toml").done().stdout;
    assert!(text.contains("critical speed     unstable below ") && text.contains(" m/s, from "), "{text}");
}

/// The ends are those of motions that were integrated outside the program, see the core's tests of `cycle_ranges`.
#[test]
fn analyse_names_every_range_of_speed_with_limit_cycles() {
    let place = Place::new();
    let twice = "law = \"table\"\ntable = { speed = [0.0, 0.05, 0.1, 0.2, 0.4, 0.8, 1.2], coefficient = [0.7, 0.7, 0.4, 0.4, 0.8, 0.2, 0.2] }";
    let (stick_slip, sliding) = (
        [[0.034_805_5, 0.140_711_5], [0.404_344_8, 0.599_373_6]],
        [
            [0.050_561_9, 0.050_563_6],
            [0.099_436_4, 0.099_438_1],
            [0.418_647_1, 0.454_480_6],
            [0.529_883_5, 1.028_505_0],
        ],
    );
    let ends = stick_slip.iter().chain(&sliding).flatten().copied();
    let mut speeds: Vec<f64> = ends.flat_map(|end| [0.99, 1.01].map(|factor| factor * end)).collect();
    speeds.sort_by(f64::total_cmp);
    let speeds: Vec<String> = speeds.iter().map(f64::to_string).collect();
    let axis = format!("[axes]\nbelt_speed = [{}]\n[random]\ninputs = []", speeds.join(", "));
    let text = job(SLOW, twice, &axis, "kind = \"time-domain\"\nstart = \"limit-cycle\"")
        .replace("belt_speed = 0.5\n", "")
        .replace("damping = 0.1\nnormal_force = 10.0", "damping = 0.4\nnormal_force = 1.0");
    place.write("job.toml", &text);
    let json: serde_json::Value =
        serde_json::from_str(&place.run("analyse --job job.toml --json").done().stdout).unwrap();
    for (key, expected) in [("stick_slip_speeds", &stick_slip[..]), ("sliding_cycle_speeds", &sliding[..])] {
        let found: Vec<[f64; 2]> = serde_json::from_value(json[key].clone()).unwrap();
        assert_eq!(found.len(), expected.len(), "{key}: {found:?}");
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found / expected - 1.0).abs() < 2e-6, "{key}: {found} {expected}");
        }
    }
    assert_eq!(json["unresolved_speeds"], serde_json::json!([]));
    assert_eq!(json["end_of_stick_slip"], json["stick_slip_speeds"][1][1]);
    assert_eq!(json["end_of_cycles"], json["sliding_cycle_speeds"][3][1]);
    let said = place.run("analyse --job job.toml").done().stdout;
    assert!(
        said.contains(
            "stick-slip         from 0.03481 to 0.1407 m/s, from 0.4043 to 0.5994 m/s\n\
             without sticking   a limit cycle next to 0.05056 m/s, next to 0.09944 m/s, from 0.4186 to 0.4545 m/s, \
             from 0.5299 to 1.029 m/s\n"
        ),
        "{said}"
    );
    // Of the motions after a release, those end at rest that have no cycle around them.
    place.run("submit job.toml").done();
    let table = Table::read(&place.path("runs/belt/surface.parquet"));
    for (&speed, &probability) in table.column("belt_speed").iter().zip(table.column("p_unstable")) {
        let is_in = stick_slip.iter().chain(&sliding).any(|&[from, to]| from < speed && speed < to);
        assert_eq!(is_in, probability == 1.0, "{speed}: {probability}");
    }
}

#[test]
fn analyse_takes_other_values_of_an_oscillator() {
    let place = Place::new();
    place.write("job.toml", &job(SLOW, STRIBECK, "", EIGENVALUE));
    place.write("fast.toml", &job(SLOW, STRIBECK, "", EIGENVALUE).replace("belt_speed = 0.5", "belt_speed = 1.25"));
    let fast = place.run("analyse fast.toml --json").done().stdout;
    assert_eq!(place.run("analyse job.toml --set belt_speed=1.25 --json").done().stdout, fast);
    assert_ne!(place.run("analyse job.toml --json").done().stdout, fast);
    for (change, text) in [
        ("belt_sped=1", "there is no parameter belt_sped; did you mean belt_speed?"),
        ("belt_speed=-1", "-1 is out of range: it must be"),
        ("belt_speed=2mm", "2mm has a unit"),
        ("start.velocity=1", "there is no parameter start.velocity"),
        ("belt_speed", "write NAME=VALUE"),
    ] {
        place.run(&format!("analyse job.toml --set {change}")).refused(64, &[text]);
    }
}
