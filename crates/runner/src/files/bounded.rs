//! Reading files of a limited size. A slipped name, such as that of a device, must not fill the memory.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// Reads a file, a pipe or a device that holds at most `most` bytes.
pub fn read_file(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    read(&mut File::open(path)?, most)
}

/// Opens a file that is no pipe and no device: such may never end, or wait for a writer without end.
///
/// # Errors
/// What cannot be opened, and what is no regular file.
pub fn open_regular(path: &Path) -> io::Result<File> {
    // Asked before: opening a pipe waits already.
    if !fs::metadata(path)?.is_file() {
        let message =
            "it is no regular file (but a folder, a pipe or a device); give a file, or copy it into one first";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    File::open(path)
}

/// Reads what holds at most `most` bytes.
pub fn read(from: &mut dyn Read, most: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    from.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > most {
        let message = format!("it is larger than {} MiB, the limit", most >> 20);
        return Err(io::Error::new(io::ErrorKind::FileTooLarge, message));
    }
    Ok(bytes)
}

/// Whether a regular file of this path can be read and holds these bytes.
pub fn holds(path: &Path, bytes: &[u8]) -> bool {
    open_regular(path).and_then(|mut file| read(&mut file, bytes.len() as u64)).is_ok_and(|there| there == bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_never_end_is_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [&pipe, Path::new("/dev/zero"), folder.path()] {
            assert_eq!(open_regular(path).unwrap_err().kind(), io::ErrorKind::InvalidInput, "{}", path.display());
        }
        let file = folder.path().join("file");
        fs::write(&file, "abc").unwrap();
        assert_eq!(read(&mut open_regular(&file).unwrap(), 3).unwrap(), b"abc");
    }

    #[test]
    fn the_limit_itself_is_allowed() {
        assert_eq!(read(&mut &b"abc"[..], 3).unwrap(), b"abc");
        assert_eq!(read(&mut &b"abcd"[..], 3).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read(&mut io::repeat(0), 1 << 20).unwrap_err().to_string(), "it is larger than 1 MiB, the limit");
    }
}
