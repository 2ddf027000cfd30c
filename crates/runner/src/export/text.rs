//! CSV and JSON.

use std::io::{self, Write};

use serde::ser::SerializeMap as _;
use serde::{Serialize, Serializer};

use super::columns::ExportedSurface;
use crate::tables::finished::{FinishedColumn, FinishedValues};

/// Writes one row for each cell below a row of names. A missing value is an empty field.
///
/// # Errors
/// Those of `out`.
pub fn write_csv(surface: &ExportedSurface, out: &mut dyn Write) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(out);
    writer.write_record(surface.columns.iter().map(|column| &column.name))?;
    let cells: usize = surface.axes.iter().map(|axis| axis.values.len()).product();
    for cell in 0..cells {
        writer.write_record(surface.columns.iter().map(|column| match &column.values {
            FinishedValues::Integer(values) => values[cell].map_or_else(String::new, |value| value.to_string()),
            FinishedValues::Real(values) => values[cell].map_or_else(String::new, |value| value.to_string()),
        }))?;
    }
    writer.flush()
}

/// Writes one object. A missing value is `null`, and so is a value that is not finite, for which JSON has no number.
///
/// # Errors
/// Those of `out`.
pub fn write_json(surface: &ExportedSurface, out: &mut dyn Write) -> io::Result<()> {
    let axes = surface.axes.iter().map(|axis| Axis { name: &axis.name, unit: &axis.unit, values: &axis.values });
    let document = Document {
        name: &surface.name,
        job_hash: &surface.job_hash,
        axes: axes.collect(),
        columns: Columns(&surface.columns),
    };
    serde_json::to_writer(&mut *out, &document)?;
    out.write_all(b"\n")
}

#[derive(Serialize)]
struct Document<'a> {
    name: &'a str,
    job_hash: &'a str,
    axes: Vec<Axis<'a>>,
    columns: Columns<'a>,
}

#[derive(Serialize)]
struct Axis<'a> {
    name: &'a str,
    unit: &'a str,
    values: &'a [f64],
}

/// Columns by their names, in their order.
struct Columns<'a>(&'a [FinishedColumn]);

impl Serialize for Columns<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for FinishedColumn { name, unit, long_name, values } in self.0 {
            let values = match values {
                FinishedValues::Integer(values) => Values::Integer(values),
                FinishedValues::Real(values) => Values::Real(values),
            };
            map.serialize_entry(name, &Column { unit, long_name, values })?;
        }
        map.end()
    }
}

#[derive(Serialize)]
struct Column<'a> {
    unit: &'a str,
    long_name: &'a str,
    values: Values<'a>,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Values<'a> {
    Integer(&'a [Option<i64>]),
    Real(&'a [Option<f64>]),
}
