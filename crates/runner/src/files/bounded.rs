//! Reading files of a limited size. A slipped name, such as that of a device, must not fill the memory.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// Reads a file, a pipe or a device that holds at most `most` bytes.
pub fn read_file(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    read(&mut File::open(path)?, most)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limit_itself_is_allowed() {
        assert_eq!(read(&mut &b"abc"[..], 3).unwrap(), b"abc");
        assert_eq!(read(&mut &b"abcd"[..], 3).unwrap_err().kind(), io::ErrorKind::FileTooLarge);
        assert_eq!(read(&mut io::repeat(0), 1 << 20).unwrap_err().to_string(), "it is larger than 1 MiB, the limit");
    }
}
