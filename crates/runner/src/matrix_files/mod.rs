//! Reading matrices of finite-element models from the files of other programs.
//!
//! What a file announces is compared with its length before anything is allocated, and all that is read is checked: no
//! file ends in a panic or with the memory full.

mod error;

mod source;

mod entries;

mod matrix;

mod numbers;

mod text;

mod nodes;

mod binary;

mod mat;

mod matrix_market;

mod zip;

mod npy;

mod npz;

mod abaqus;

mod substructure;

mod nastran;

mod calculix;

mod harwell_boeing;

mod align;

#[cfg(test)]
mod forged;
#[cfg(test)]
mod tests;

use std::path::Path;

pub use align::align;
pub use error::MatrixFileError;
pub use matrix::{Place, ReadMatrix, Stored};

use error::Problem;
use source::{Listed, Source, no_name};

/// The formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Mat,
    MatrixMarket,
    Npz,
    Npy,
    MatrixInput,
    Coordinate,
    Substructure,
    Nastran,
    CalculiX,
    HarwellBoeing,
}

/// Reads the matrix of a file: that of this name, or the only one.
///
/// # Errors
/// Everything that is wrong with the file or the name.
pub fn read(path: &Path, name: Option<&str>) -> Result<ReadMatrix, MatrixFileError> {
    read_from(path, name).map_err(|problem| problem.in_file(path))
}

fn read_from(path: &Path, name: Option<&str>) -> Result<ReadMatrix, Problem> {
    let mut source = Source::open(path)?;
    let format = recognised(&mut source)?;
    if !has_names(format) {
        no_name(name)?;
    }
    match format {
        Format::Mat => mat::read(&mut source, name),
        Format::MatrixMarket => matrix_market::read(&mut source),
        Format::Npz => npz::read(&mut source, name),
        Format::Npy => npy::read_file(&mut source),
        Format::MatrixInput => abaqus::read_matrix_input(&mut source),
        Format::Coordinate => abaqus::read_coordinate(&mut source),
        Format::Substructure => substructure::read(&mut source, name),
        Format::Nastran => nastran::read(&mut source, name),
        Format::CalculiX => calculix::read(&mut source),
        Format::HarwellBoeing => harwell_boeing::read(&mut source),
    }
}

/// Whether files of a format name their matrices.
fn has_names(format: Format) -> bool {
    matches!(format, Format::Mat | Format::Npz | Format::Substructure | Format::Nastran)
}

/// The names of the matrices in a file that can be read; none where it has one without a name.
///
/// # Errors
/// A file that cannot be read.
pub fn names(path: &Path) -> Result<Vec<String>, MatrixFileError> {
    let all = || {
        let mut source = Source::open(path)?;
        let format = recognised(&mut source)?;
        list(&mut source, format)
    };
    let all = all().map_err(|problem: Problem| problem.in_file(path))?.unwrap_or_default();
    Ok(all.into_iter().filter(|one| one.problem.is_none()).map(|one| one.name).collect())
}

/// What has a name in a file; `None` of formats, and of files, with one matrix without a name.
fn list(source: &mut Source, format: Format) -> Result<Option<Vec<Listed>>, Problem> {
    match format {
        Format::Mat => mat::list(source).map(Some),
        Format::Npz => npz::list(source),
        Format::Substructure => substructure::list(source).map(Some),
        Format::Nastran => nastran::list(source).map(Some),
        _ => Ok(None),
    }
}

/// The format of a file by its first bytes, and by its ending where they do not tell.
fn recognised(source: &mut Source) -> Result<Format, Problem> {
    let head = source.head()?;
    let extension = source.extension();
    let starts = |text: &str| head.get(..text.len()).is_some_and(|start| start.eq_ignore_ascii_case(text.as_bytes()));
    if head.is_empty() {
        return Err(Problem::new("the file is empty"));
    }
    if head.starts_with(b"\xef\xbb\xbf") {
        return Err(Problem::new(
            "the file begins with a byte order mark, which programs for texts write; save it as UTF-8 without one",
        ));
    }
    if starts("%%MatrixMarket") {
        return Ok(Format::MatrixMarket);
    }
    if head.starts_with(b"PK\x03\x04") || head.starts_with(b"PK\x05\x06") {
        return Ok(Format::Npz);
    }
    if head.starts_with(npy::MAGIC) {
        return Ok(Format::Npy);
    }
    if mat::is_one(&head, &extension) || head.starts_with(mat::HDF5) {
        return Ok(Format::Mat);
    }
    if let Some(refusal) = binary::refusal(&head, &extension) {
        return Err(Problem::new(refusal));
    }
    let text = String::from_utf8_lossy(&head);
    if matches!(&*extension, "sti" | "mas") {
        return Ok(Format::CalculiX);
    }
    if extension == "pch" || text.lines().any(nastran::is_dmig) {
        return Ok(Format::Nastran);
    }
    if harwell_boeing::is_one(&text) {
        return Ok(Format::HarwellBoeing);
    }
    if text.lines().any(substructure::is_keyword) {
        return Ok(Format::Substructure);
    }
    // The last line may be cut off by the end of the head.
    let data = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with(['*', '#', '%']));
    match data.map_or(0, |line| text::words(line).count()) {
        5 => Ok(Format::MatrixInput),
        3 => Ok(Format::Coordinate),
        _ => Err(Problem::new(binary::UNKNOWN)),
    }
}
