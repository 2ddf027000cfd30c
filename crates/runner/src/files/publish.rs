//! Files that appear whole or not at all.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::Failure;
use crate::unfinished::{self, Unfinished};

/// Prefix of the names of unfinished files. A killed process leaves them behind.
pub const PREFIX: &str = ".unfinished-";

/// Writes `bytes` as the file `name` in `directory`, whole or not at all.
pub fn publish(directory: &Path, name: &str, bytes: &[u8]) -> Result<(), Failure> {
    publish_with(directory, name, |file| file.write_all(bytes))
        .map_err(|error| Failure::writing(&directory.join(name), error))
}

/// Writes `bytes` as the file `name` in `directory`, unless there is one of that name; returns false then.
pub fn publish_first(directory: &Path, name: &str, bytes: &[u8]) -> Result<bool, Failure> {
    let written = (|| {
        let (_unfinished, mut temporary) = temporary(directory)?;
        temporary.write_all(bytes)?;
        temporary.as_file().sync_all()?;
        match temporary.persist_noclobber(directory.join(name)) {
            Ok(_) => sync(directory).map(|()| true),
            Err(taken) if taken.error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
            Err(error) => Err(error.error),
        }
    })();
    written.map_err(|error| Failure::writing(&directory.join(name), error))
}

/// Lets `write` fill a temporary file in `directory`, and renames it to `name` when it is on disk.
pub fn publish_with<E: From<io::Error>>(
    directory: &Path,
    name: &str,
    write: impl FnOnce(&mut File) -> Result<(), E>,
) -> Result<(), E> {
    let (_unfinished, mut temporary) = temporary(directory)?;
    write(temporary.as_file_mut())?;
    temporary.as_file().sync_all()?;
    temporary.persist(directory.join(name)).map_err(|error| error.error)?;
    Ok(sync(directory)?)
}

/// The error of the system behind one that names a file.
fn cause(error: &io::Error) -> Option<io::Error> {
    let cause = error.get_ref()?.source()?.downcast_ref::<io::Error>()?;
    cause.raw_os_error().map(io::Error::from_raw_os_error)
}

/// A temporary file, which a signal removes.
fn temporary(directory: &Path) -> io::Result<(Unfinished, NamedTempFile)> {
    unfinished::create(|| {
        // Temporary files are private by default. The umask takes from these rights what the user wants to be taken.
        let rights = fs::Permissions::from_mode(0o666);
        let temporary = tempfile::Builder::new().prefix(PREFIX).permissions(rights).tempfile_in(directory);
        // The name of the file of which it speaks has been made up here.
        let temporary = temporary.map_err(|error| cause(&error).unwrap_or(error))?;
        let path = temporary.path().to_owned();
        Ok((temporary, path))
    })
}

/// Syncs a directory, so that a rename survives a power cut.
fn sync(directory: &Path) -> io::Result<()> {
    File::open(directory)?.sync_all()
}

/// Whether a path is that of an unfinished file.
pub fn is_temporary(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(PREFIX))
}

/// The paths of everything in a directory, sorted.
pub fn files(directory: &Path) -> Result<Vec<PathBuf>, Failure> {
    let entries = fs::read_dir(directory).map_err(|error| Failure::reading(directory, error))?;
    let mut paths = Vec::new();
    for entry in entries {
        paths.push(entry.map_err(|error| Failure::reading(directory, error))?.path());
    }
    paths.sort();
    Ok(paths)
}
