//! The formats, by name.

use std::io::{self, Write};
use std::path::Path;

use clap::ValueEnum;

use super::arrays::GridArrays;
use super::columns::ExportedSurface;
use super::{mat, npz, text};
use crate::failure::Failure;

/// A format of an exported surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// One row for each cell, for spreadsheets and everything else
    Csv,
    /// Axes and columns with unit and meaning
    Json,
    /// Arrays over the axes, for MATLAB and Octave
    Mat,
    /// Arrays over the axes, for NumPy
    Npz,
}

impl Format {
    /// How the names of its files end.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Csv => "csv",
            Self::Json => "json",
            Self::Mat => "mat",
            Self::Npz => "npz",
        }
    }

    /// Checks that a file is named after the format, so that neither a slip of the keyboard replaces a file of the run
    /// nor another program takes the file for what it is not. A directory is refused elsewhere.
    ///
    /// # Errors
    /// Another name, with the one to take.
    pub fn check_name(self, file: &Path) -> Result<(), Failure> {
        let wanted = self.extension();
        if file.is_dir() || file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case(wanted)) {
            return Ok(());
        }
        let name = file.with_extension(wanted);
        let message = format!("{}: the file is written as {wanted}; name it {}", file.display(), name.display());
        Err(Failure::Usage(message))
    }

    /// Writes a surface.
    ///
    /// # Errors
    /// Those of `out`, and a surface that is too large for the format.
    pub fn write(self, surface: &ExportedSurface, out: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Csv => text::write_csv(surface, out),
            Self::Json => text::write_json(surface, out),
            Self::Mat => mat::write(&GridArrays::new(surface), out),
            Self::Npz => npz::write(&GridArrays::new(surface), out),
        }
    }
}
