//! What every format is written from: the columns of a surface and the axes of its grid.

use std::path::Path;

use crate::failure::Failure;
use crate::tables::cell_columns::axes;
use crate::tables::finished::{FinishedColumn, FinishedSurface};

/// A surface to be exported.
pub struct ExportedSurface {
    /// Name of the job.
    pub name: String,
    /// Hash of the job.
    pub job_hash: String,
    /// The axes of the grid, slowest first.
    pub axes: Vec<ExportedAxis>,
    /// All columns, in the order of the file.
    pub columns: Vec<FinishedColumn>,
}

/// An axis of the grid.
pub struct ExportedAxis {
    /// The name of its column.
    pub name: String,
    /// Unit; `1` for a pure number.
    pub unit: String,
    /// Its values.
    pub values: Vec<f64>,
}

impl ExportedSurface {
    /// Reads the surface of a finished run.
    ///
    /// # Errors
    /// As those of [`FinishedSurface`], and a surface without the column of an axis.
    pub fn read(run: &Path) -> Result<Self, Failure> {
        let surface = FinishedSurface::open(run)?;
        surface.note_other_version();
        let columns = surface.columns(|_| true)?;
        let axis = |(name, values): (String, Vec<f64>)| {
            let column = columns.iter().find(|column| column.name == name);
            let column = column.ok_or_else(|| surface.broken(format!("it has no column {name}, which is an axis")))?;
            Ok(ExportedAxis { unit: column.unit.clone(), name, values })
        };
        let axes = axes(&surface.job).into_iter().map(axis).collect::<Result<_, Failure>>()?;
        Ok(Self { name: surface.job.name.clone(), job_hash: surface.job.hash(), axes, columns })
    }
}
