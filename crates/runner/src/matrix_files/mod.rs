//! Matrices in files that other programs wrote: MAT files of MATLAB (5 to 7), and Matrix Market.

use std::fs;
use std::path::Path;

use faer::sparse::{SparseColMat, Triplet};
use thiserror::Error;

mod mat;

mod matrix_market;

/// Entries of a matrix at most.
const MOST_ENTRIES: usize = 400_000_000;

/// Why a matrix cannot be read.
#[derive(Debug, Error)]
pub enum MatrixFileError {
    /// The file cannot be opened or read.
    #[error("cannot read {path}: {source}")]
    Unreadable {
        /// The file.
        path: String,
        /// Why not.
        source: std::io::Error,
    },
    /// The file is not what it should be.
    #[error("{path}: {message}")]
    Refused {
        /// The file.
        path: String,
        /// What is wrong, and what would be right.
        message: String,
    },
}

/// A matrix of a file.
type Matrix = SparseColMat<usize, f64>;

/// Reads a matrix; `name` is its name, in a file that has several.
///
/// # Errors
/// [`MatrixFileError`], with what would be right.
pub fn read(path: &Path, name: Option<&str>) -> Result<Matrix, MatrixFileError> {
    let shown = path.display().to_string();
    let bytes = fs::read(path).map_err(|source| MatrixFileError::Unreadable { path: shown.clone(), source })?;
    let read = if bytes.starts_with(b"%%MatrixMarket") {
        matrix_market::read(&bytes, name)
    } else {
        mat::read(&bytes, name).map_err(|message| other_format(path, &bytes).unwrap_or(message))
    };
    read.map_err(|message| MatrixFileError::Refused { path: shown, message })
}

/// What to do about a file of another program.
fn other_format(path: &Path, bytes: &[u8]) -> Option<String> {
    let extension = path.extension()?.to_str()?.to_lowercase();
    let instead = "Matrix Market (scipy.io.mmwrite) or a MAT file (scipy.io.savemat, or save with -v7 in MATLAB)";
    Some(match extension.as_str() {
        _ if bytes.starts_with(b"\x89HDF\r\n\x1a\n") => {
            "this is a MAT file of version 7.3 (HDF5), which is not read; save it with save('brake.mat', 'M', 'K', '-v7')".to_owned()
        }
        "full" | "sub" => {
            format!("a binary file of Ansys is not read; export with the command HBMAT and convert to {instead}")
        }
        "sim" | "odb" => format!(
            "a binary file of Abaqus is not read; export with *MATRIX GENERATE and *MATRIX OUTPUT, and convert to {instead}"
        ),
        "op2" => format!("a binary file of Nastran is not read; export with PARAM,EXTOUT,DMIGPCH and convert to {instead}"),
        "mtx" | "pch" | "npz" | "npy" | "rua" | "rsa" | "sti" | "mas" => {
            format!("this format is not read; convert it to {instead}")
        }
        _ => return None,
    })
}

/// Builds a matrix from entries, each checked.
struct Entries {
    rows: usize,
    columns: usize,
    triplets: Vec<Triplet<usize, usize, f64>>,
}

impl Entries {
    /// For a matrix of this size, with about so many entries, of which the file has room for `possible`.
    fn new(rows: u64, columns: u64, count: u64, possible: usize) -> Result<Self, String> {
        if rows == 0 || columns == 0 {
            return Err(format!("the matrix is {rows} by {columns}: it has no entries"));
        }
        if rows > MOST_ENTRIES as u64 || columns > MOST_ENTRIES as u64 {
            return Err(format!("the matrix is {rows} by {columns}; at most {MOST_ENTRIES} rows and columns are read"));
        }
        if count > possible as u64 {
            return Err(format!(
                "the matrix says that it has {count} entries, but the file has room for {possible} at most: it is cut off or damaged"
            ));
        }
        let triplets = Vec::with_capacity(count as usize);
        Ok(Self { rows: rows as usize, columns: columns as usize, triplets })
    }

    /// Adds an entry, counted from 0.
    fn add(&mut self, row: u64, column: u64, value: f64) -> Result<(), String> {
        if row >= self.rows as u64 || column >= self.columns as u64 {
            return Err(format!(
                "an entry stands in row {}, column {}, but the matrix is {} by {}",
                row + 1,
                column + 1,
                self.rows,
                self.columns
            ));
        }
        if !value.is_finite() {
            return Err(format!(
                "the entry in row {}, column {} is {value}; it must be a finite number",
                row + 1,
                column + 1
            ));
        }
        self.triplets.push(Triplet::new(row as usize, column as usize, value));
        Ok(())
    }

    fn matrix(self) -> Result<Matrix, String> {
        SparseColMat::try_new_from_triplets(self.rows, self.columns, &self.triplets)
            .map_err(|error| format!("the matrix does not fit the memory: {error:?}"))
    }
}
