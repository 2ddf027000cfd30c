//! Surfaces exported for other programs: every format holds the values of the Parquet file.
//!
//! NumPy and SciPy read the arrays if STICKSLIP_PYTHON names an interpreter, see `tests/people/readers.rs`.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{Place, Table, python_agrees, repository, submitted};
use serde_json::Value;

/// A grid with more than one value on every axis, and columns with missing values: without scatter there are no
/// derivatives.
const GRID: &str = r#"
name = "grid"
[axes]
"pad.mass" = [0.8, 1.0]
rotating_speed = [12.0, 15.0]
preload = [0.05, 0.1, 0.3]
static_friction = [0.3, 0.35, 0.4, 0.45]
[random]
inputs = ["preload", "static_friction"]
relative_std = [0.0, 0.1, 0.2]
[criterion]
kind = "eigenvalue"
[sampling]
samples = 200
seed = 1
derivatives = true
"#;

/// Its axes, slowest first, with unit and length.
const AXES: [(&str, &str, usize); 5] = [
    ("pad.mass", "kg", 2),
    ("rotating_speed_rad_s", "rad/s", 2),
    ("std_preload", "1", 3),
    ("preload", "1", 3),
    ("static_friction", "1", 4),
];

const CELLS: usize = 2 * 2 * 3 * 3 * 4;

/// Asserts that a column is that of the Parquet file bit for bit; NaN is a missing value.
#[track_caller]
fn assert_same(table: &Table, name: &str, values: &[f64]) {
    let of_file = table.column(name);
    assert_eq!(values.len(), of_file.len(), "{name}");
    for (cell, (value, wanted)) in values.iter().zip(of_file).enumerate() {
        let is_same = value.to_bits() == wanted.to_bits() || (value.is_nan() && wanted.is_nan());
        assert!(is_same, "{name} in cell {cell}: {value} instead of {wanted}");
    }
}

#[test]
fn csv_has_every_value_and_leaves_missing_ones_empty() {
    let place = Place::new();
    let table = submitted(&place, "grid", GRID);
    assert_eq!(place.run("export grid --format csv").done().stdout, "grid/surface.csv\n");
    let mut reader = csv::Reader::from_path(place.path("grid/surface.csv")).unwrap();
    let names: Vec<String> = reader.headers().unwrap().iter().map(str::to_owned).collect();
    assert_eq!(names, table.names());
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), CELLS);
    let mut missing = 0;
    for (i, name) in names.iter().enumerate() {
        let number = |row: &csv::StringRecord| if row[i].is_empty() { f64::NAN } else { row[i].parse().unwrap() };
        let values: Vec<f64> = rows.iter().map(number).collect();
        missing += rows.iter().filter(|row| row[i].is_empty()).count();
        assert_same(&table, name, &values);
    }
    assert!(missing > 0, "the job has missing values");
    // The same surface gives the same bytes.
    place.run("export grid --format csv --out again.csv").done();
    assert_eq!(fs::read(place.path("grid/surface.csv")).unwrap(), fs::read(place.path("again.csv")).unwrap());
}

#[test]
fn json_has_axes_and_columns_with_unit_and_meaning() {
    let place = Place::new();
    let table = submitted(&place, "grid", GRID);
    assert_eq!(place.run("export grid --format json --out grid.json").done().stdout, "grid.json\n");
    let text = fs::read_to_string(place.path("grid.json")).unwrap();
    let document: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(document["name"], "grid");
    let hash = table.footer.iter().find(|(key, _)| key == "stickslip:job_hash").map(|(_, hash)| hash.as_str());
    assert_eq!(document["job_hash"].as_str(), hash);
    let axes = document["axes"].as_array().unwrap();
    assert_eq!(axes.len(), AXES.len());
    let mut stride = CELLS;
    for (axis, (name, unit, length)) in axes.iter().zip(AXES) {
        assert_eq!((axis["name"].as_str(), axis["unit"].as_str()), (Some(name), Some(unit)));
        stride /= length;
        let values = axis["values"].as_array().unwrap();
        assert_eq!(values.len(), length, "{name}");
        for (cell, of_cell) in table.column(name).iter().enumerate() {
            assert_eq!(values[cell / stride % length].as_f64(), Some(*of_cell), "{name} in cell {cell}");
        }
    }
    let columns = document["columns"].as_object().unwrap();
    assert_eq!(columns.len(), table.names().len());
    assert_eq!(columns["rotating_speed_rad_s"]["unit"], "rad/s");
    assert_eq!(columns["p_low"]["long_name"], "lower end of the confidence interval of the probability");
    let mut end = 0;
    for name in table.names() {
        assert_eq!(columns[name]["values"].as_array().unwrap().len(), CELLS);
        // The digits as written: a parser of JSON may round otherwise. Columns are in the order of the file.
        let begin = end + text[end..].find(&format!("\"{name}\":{{")).unwrap();
        let begin = begin + text[begin..].find("\"values\":[").unwrap() + "\"values\":[".len();
        end = begin + text[begin..].find(']').unwrap();
        let number = |text: &str| if text == "null" { f64::NAN } else { text.parse().unwrap() };
        assert_same(&table, name, &text[begin..end].split(',').map(number).collect::<Vec<f64>>());
    }
    assert!(text.contains("null"));
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn numpy_and_scipy_read_arrays_over_the_axes() {
    let place = Place::new();
    // The inputs differ in the scatter of friction alone; the last axes have one value.
    let slim = GRID
        .replace(
            "0.0, 0.1, 0.2]",
            "{ preload = 0.1, static_friction = 0.1 }, { preload = 0.1, static_friction = 0.2 }]",
        )
        .replace("[0.05, 0.1, 0.3]", "0.1")
        .replace("[0.3, 0.35, 0.4, 0.45]", "0.39");
    let names = |names: [&str; 5]| names.map(|name| name.replace('.', "_")).join(",");
    let of_grid = AXES.map(|(name, ..)| name);
    let mut of_slim = of_grid;
    of_slim[2] = "std_static_friction";
    for (run, job, axes, shape) in [("grid", GRID, of_grid, "2,2,3,3,4"), ("slim", slim.as_str(), of_slim, "2,2,2,1,1")]
    {
        submitted(&place, run, job);
        for format in ["csv", "npz", "mat"] {
            let printed = place.run(&format!("export {run} --format {format}")).done().stdout;
            assert_eq!(printed, format!("{run}/surface.{format}\n"));
        }
        let axes = [names(axes), shape.to_owned()];
        if !python_agrees("exports.py", [place.path(run).into_os_string()].into_iter().chain(axes.map(Into::into))) {
            return;
        }
    }
}

/// A model without a pair has no axis of scatter where nothing scatters.
#[test]
fn a_surface_without_scatter_is_exported() {
    let place = Place::new();
    let job = fs::read_to_string(repository().join("jobs/hoffmann.toml")).unwrap();
    let scatter = "[random]\ninputs = [\"friction\"]\nrelative_std = 0.1\n";
    assert!(job.contains(scatter));
    place.write("still.toml", &job.replace(scatter, ""));
    place.run("submit still.toml --out run").done();
    place.run("export run --format csv --out run.csv").done();
    let text = fs::read_to_string(place.path("run.csv")).unwrap();
    assert!(text.starts_with("cell,") && !text.contains("std_") && text.lines().count() > 2, "{text}");
}

#[test]
fn what_cannot_be_exported_is_said() {
    let place = Place::new();
    submitted(&place, "grid", GRID);
    let surface = place.surface("grid");
    place.run("export nowhere --format csv").refused(74, &["nowhere is not a run directory"]);
    place.run("export grid").refused(64, &["--format"]);
    place.run("export grid --format xlsx").refused(64, &["xlsx", "csv", "json", "mat", "npz"]);
    place.run("export grid --format csv --out no/such/folder/grid.csv").refused(73, &["no/such/folder"]);
    fs::create_dir(place.path("folder")).unwrap();
    place.run("export grid --format csv --out folder").refused(73, &["folder is a directory"]);
    place
        .run("export grid --format csv --out grid/surface.parquet")
        .refused(64, &["grid/surface.parquet", "written as csv", "name it grid/surface.csv"]);
    assert!(place.surface("grid") == surface, "the result is untouched");
    fs::remove_file(place.path("grid/surface.parquet")).unwrap();
    for format in ["csv", "json", "mat", "npz"] {
        let refused = place.run(&format!("export grid --format {format}"));
        refused.refused(65, &["grid has no surface yet", "stickslip resume grid"]);
        assert!(!place.path(&format!("grid/surface.{format}")).exists());
    }
}
