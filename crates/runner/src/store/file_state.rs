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
    let opened = || -> io::Result<Option<[File; 2]>> {
        let Some(file) = root.open_if_there(name)? else { return Ok(None) };
        if file.metadata()?.len() > MOST_BYTES {
            let why = format!("it has more than {MOST_BYTES} bytes, the most that such a file may have");
            return Err(io::Error::other(why));
        }
        // Reading the footer of one moves its place in it.
        Ok(Some([file, root.open_file(name)?]))
    };
    let [file, described] = match opened() {
        Ok(Some(opened)) => opened,
        Ok(None) => return Ok(FileState::Absent),
        Err(error) => return Ok(FileState::Damaged(error.to_string())),
    };
    let known = Known::read(root)?;
    let mut state = FileState::Sound;
    for (key, value) in footer {
        match text_of_key(&described, key) {
            // Without a footer it is not read, whatever its size.
            None if known.fit(name, "") == Fit::Unknown => {
                return Ok(FileState::Damaged("it is not a result of a run".to_owned()));
            }
            None => return Ok(FileState::Damaged(NOT_AS_WRITTEN.to_owned())),
            Some(text) if text == *value => {}
            Some(_) => state = FileState::OfAnotherJob,
        }
    }
    match digest_of_file(file) {
        Ok(digest) if known.fit(name, &digest) == Fit::Differs => Ok(FileState::Damaged(NOT_AS_WRITTEN.to_owned())),
        Ok(_) => Ok(state),
        Err(error) => Ok(FileState::Damaged(error.to_string())),
    }
}
