//! Whether a file of results is the one of its job, as it was written.

use std::fs::File;
use std::io;

use crate::failure::Failure;
use crate::files::folder::Folder;
use crate::files::foreign::text_of_key;
use crate::store::digests::{Fit, Known, digest_of_file};

/// Why a file is taken for damaged.
pub const NOT_AS_WRITTEN: &str = "it does not have the digest that it was written with";

/// Largest file of results: a million cells with every column have about 1 GiB.
const MOST_BYTES: u64 = 1 << 32;

/// What there is of a file of results.
#[derive(Debug, PartialEq, Eq)]
pub enum FileState {
    /// No file.
    Absent,
    /// One that does not belong to the job as it is now, such as that of a run before it was extended.
    OfAnotherJob,
    /// One of the job, from a version of stickslip with other results or another format.
    OfAnotherVersion,
    /// One that is not as it was written, and why.
    Damaged(String),
    /// The one of the job.
    Sound,
}

/// The state of a Parquet file in a run directory whose footer should have these values.
pub fn state_of(root: &Folder, name: &str, footer: &[(&str, String)]) -> Result<FileState, Failure> {
    let opened = || -> io::Result<Option<(String, File)>> {
        let Some(file) = root.open_if_there(name)? else { return Ok(None) };
        if file.metadata()?.len() > MOST_BYTES {
            let why = format!("it has more than {MOST_BYTES} bytes, the most that such a file may have");
            return Err(io::Error::other(why));
        }
        Ok(Some((digest_of_file(file)?, root.open_file(name)?)))
    };
    let (digest, file) = match opened() {
        Ok(Some(opened)) => opened,
        Ok(None) => return Ok(FileState::Absent),
        Err(error) => return Ok(FileState::Damaged(error.to_string())),
    };
    if Known::read(root)?.fit(name, &digest) == Fit::Differs {
        return Ok(FileState::Damaged(NOT_AS_WRITTEN.to_owned()));
    }
    let mut state = FileState::Sound;
    for (key, value) in footer {
        match text_of_key(&file, key) {
            None => return Ok(FileState::Damaged("it is not a result of a run".to_owned())),
            Some(text) if text == *value => {}
            Some(_) => state = FileState::OfAnotherJob,
        }
    }
    Ok(state)
}
