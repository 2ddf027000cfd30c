//! A file of matrices that is read, and what of it a reader wants.

use std::fs::{self, File};
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::{Path, PathBuf};

use super::error::{Problem, listed, quoted};

/// Bytes at the start of a file by which its format is recognised.
const HEAD: u64 = 4096;

/// An open file.
pub struct Source {
    pub path: PathBuf,
    pub file: File,
    pub length: u64,
}

impl Source {
    /// Opens a file.
    ///
    /// # Errors
    /// A file that cannot be opened, and what is no file: a device has no end.
    pub fn open(path: &Path) -> Result<Self, Problem> {
        let cannot_open = |error: io::Error| Problem::new(format!("cannot open the file: {error}"));
        // Asked before it is opened: a pipe without a writer would wait for one.
        if !fs::metadata(path).map_err(cannot_open)?.is_file() {
            return Err(Problem::new("this is no file; give the file that holds the matrix"));
        }
        let file = File::open(path).map_err(cannot_open)?;
        let metadata = file.metadata().map_err(|error| Problem::of_reading(&error))?;
        Ok(Self { path: path.to_owned(), file, length: metadata.len() })
    }

    /// The first bytes.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn head(&mut self) -> Result<Vec<u8>, Problem> {
        self.seek(0)?;
        let mut head = Vec::new();
        (&self.file).take(HEAD).read_to_end(&mut head).map_err(|error| Problem::of_reading(&error))?;
        self.seek(0)?;
        Ok(head)
    }

    /// Goes to a byte of the file.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn seek(&mut self, place: u64) -> Result<(), Problem> {
        self.file.seek(SeekFrom::Start(place)).map(|_| ()).map_err(|error| Problem::of_reading(&error))
    }

    /// The ending of the file's name, in lower-case letters.
    pub fn extension(&self) -> String {
        self.path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
    }
}

/// A thing in a file that has a name: a matrix that can be read, or why it cannot.
pub struct Listed {
    pub name: String,
    pub problem: Option<String>,
}

/// The place of the matrix that is wanted: the one of this name, or the only one.
///
/// # Errors
/// No or several such matrices.
pub fn choose(all: &[Listed], name: Option<&str>) -> Result<usize, Problem> {
    let readable: Vec<&str> = all.iter().filter(|one| one.problem.is_none()).map(|one| one.name.as_str()).collect();
    let there_are = match &readable[..] {
        [] => "there are no matrices in it".to_owned(),
        names => format!("there are {}", listed(names.iter().copied())),
    };
    let Some(name) = name else {
        return match &readable[..] {
            [only] => Ok(all.iter().position(|one| one.name == *only && one.problem.is_none()).unwrap_or_default()),
            [] => Err(Problem::new(match all {
                [] => there_are,
                _ => format!("{there_are} that can be read, but {}", described(all)),
            })),
            _ => Err(Problem::new(format!(
                "the file has several matrices; say which with `matrix = \"{}\"` ({there_are})",
                readable[0]
            ))),
        };
    };
    // The last of several variables of a name is the one that counts in MATLAB.
    let Some(place) = all.iter().rposition(|one| one.name == name) else {
        let other_case = readable.iter().find(|other| other.eq_ignore_ascii_case(name));
        let hint = other_case.map(|other| format!("; do you mean {}?", quoted(other))).unwrap_or_default();
        return Err(Problem::new(format!("there is no matrix {} ({there_are}){hint}", quoted(name))));
    };
    match &all[place].problem {
        None => Ok(place),
        Some(problem) => Err(Problem::new(problem.clone()).of_matrix(name)),
    }
}

/// What cannot be read, with the reasons.
fn described(all: &[Listed]) -> String {
    let first = all.iter().find_map(|one| one.problem.as_ref().map(|problem| (quoted(&one.name), problem)));
    first.map(|(name, problem)| format!("{name}, of which is said: {problem}")).unwrap_or_default()
}

/// Refuses a name where the file has one matrix without a name.
///
/// # Errors
/// A name.
pub fn no_name(name: Option<&str>) -> Result<(), Problem> {
    name.map_or(Ok(()), |name| {
        let text = format!(
            "the file has one matrix without a name, so there is no matrix {}; leave out `matrix`",
            quoted(name)
        );
        Err(Problem::new(text))
    })
}
