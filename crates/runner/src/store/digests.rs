//! `digests.json`: what the files of a run that carry no digest in their names should hold.
//!
//! The digest of a file is written before the file itself. So there is always one that fits, whenever a process is
//! killed: that of the file before or that of the one after.

use std::collections::BTreeMap;
use std::fs::File;
use std::io;

use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::files::folder::{Folder, is_no_file};

/// The name of the file.
pub const DIGESTS: &str = "digests.json";

/// Largest number of its bytes.
const MOST: u64 = 1 << 20;

/// Digests by file: hexadecimal BLAKE3. The last one is that of the newest content; the one before it may still be there.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Digests {
    files: BTreeMap<String, Vec<String>>,
}

#[derive(Serialize, Deserialize)]
struct Written {
    files: BTreeMap<String, Vec<String>>,
    /// The digest of `files`, by which damage to this file itself is found.
    digest: String,
}

/// What a directory knows about its files.
#[derive(Debug)]
pub enum Known {
    /// Their digests.
    Digests(Digests),
    /// Nothing: the file was removed.
    Nothing,
    /// The file is damaged.
    Damaged,
}

/// Whether the content of a file is the one that was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fit {
    /// It is.
    Fits,
    /// It is not.
    Differs,
    /// There is no digest of it.
    Unknown,
}

impl Known {
    /// Reads the digests in a directory.
    pub fn read(folder: &Folder) -> Result<Self, Failure> {
        let bytes = match folder.read_if_there(DIGESTS, MOST) {
            Ok(Some(bytes)) => bytes,
            Ok(None) => return Ok(Self::Nothing),
            Err(error) if is_no_file(&error) => return Ok(Self::Damaged),
            Err(error) => return Err(Failure::reading(&folder.path().join(DIGESTS), error)),
        };
        let written: Option<Written> = serde_json::from_slice(&bytes).ok();
        Ok(match written.filter(|written| written.digest == digest_of(&written.files)) {
            Some(Written { files, .. }) => Self::Digests(Digests { files }),
            None => Self::Damaged,
        })
    }

    /// Whether a digest is one of those of the file `name`.
    pub fn fit(&self, name: &str, digest: &str) -> Fit {
        match self {
            Self::Digests(digests) => match digests.files.get(name) {
                Some(digests) if digests.iter().any(|known| known == digest) => Fit::Fits,
                Some(_) => Fit::Differs,
                None => Fit::Unknown,
            },
            Self::Nothing | Self::Damaged => Fit::Unknown,
        }
    }

    /// The digests, none if they are not known.
    pub fn into_digests(self) -> Digests {
        match self {
            Self::Digests(digests) => digests,
            Self::Nothing | Self::Damaged => Digests::default(),
        }
    }
}

impl Digests {
    /// Adds the digest of what the file `name` will hold, and keeps that of what it holds now. `present` returns
    /// which of two digests that is after a write that failed.
    pub fn expect(&mut self, name: &str, digest: &str, present: impl FnOnce() -> Option<String>) {
        let digests = self.files.entry(name.to_owned()).or_default();
        digests.retain(|known| known != digest);
        if digests.len() > 1 {
            let present = present();
            digests.retain(|known| present.as_ref() == Some(known));
        }
        digests.push(digest.to_owned());
    }

    /// Forgets the file `name`, and keeps `digest` as the only one of it, if there is one.
    pub fn set(&mut self, name: &str, digest: Option<String>) {
        match digest {
            Some(digest) => self.files.insert(name.to_owned(), vec![digest]),
            None => self.files.remove(name),
        };
    }

    /// Takes the digests of the file `name` over from others that have some.
    pub fn keep(&mut self, name: &str, others: &Self) {
        if let Some(known) = others.files.get(name) {
            self.files.insert(name.to_owned(), known.clone());
        }
    }

    /// Writes the digests to a directory.
    pub fn publish(&self, folder: &Folder) -> Result<(), Failure> {
        let path = folder.path().join(DIGESTS);
        let written = Written { files: self.files.clone(), digest: digest_of(&self.files) };
        let text = serde_json::to_string_pretty(&written).map_err(|error| Failure::writing(&path, error))?;
        folder.publish(DIGESTS, (text + "\n").as_bytes()).map_err(|error| Failure::writing(&path, error))
    }
}

/// The digest of the content of a file, which may be large.
pub fn digest_of_file(mut file: File) -> io::Result<String> {
    let mut hasher = blake3::Hasher::new();
    io::copy(&mut file, &mut hasher)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// The digest of bytes.
pub fn digest_of_bytes(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

fn digest_of(files: &BTreeMap<String, Vec<String>>) -> String {
    let mut hasher = blake3::Hasher::new();
    for (name, digests) in files {
        for digest in digests {
            hasher.update(format!("{name} {digest}\n").as_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn the_content_before_and_the_one_after_fit_and_no_other() {
        let mut digests = Digests::default();
        let present = |digest: &str| Some(digest.to_owned());
        ["a", "b", "b", "c"].iter().for_each(|digest| digests.expect("file", digest, || present("b")));
        let fits =
            |digests: &Digests| ["a", "b", "c", "d"].map(|digest| Known::Digests(digests.clone()).fit("file", digest));
        assert_eq!(fits(&digests), [Fit::Differs, Fit::Fits, Fit::Fits, Fit::Differs]);
        // The write of "c" failed, and so may that of "d".
        digests.expect("file", "d", || present("b"));
        assert_eq!(fits(&digests), [Fit::Differs, Fit::Fits, Fit::Differs, Fit::Fits]);
        let known = Known::Digests(digests.clone());
        assert_eq!(known.fit("other", "a"), Fit::Unknown);
        digests.set("file", Some("d".to_owned()));
        assert_eq!(Known::Digests(digests).fit("file", "c"), Fit::Differs);
    }

    #[test]
    fn every_flipped_bit_is_found_or_changes_nothing() {
        let directory = tempfile::tempdir().unwrap();
        let folder = Folder::open(directory.path()).unwrap();
        assert!(matches!(Known::read(&folder).unwrap(), Known::Nothing));
        let mut digests = Digests::default();
        digests.expect("job.toml", &digest_of_bytes(b"job"), || None);
        digests.publish(&folder).unwrap();
        let path = directory.path().join(DIGESTS);
        let sound = fs::read(&path).unwrap();
        let mut damaged = 0;
        for bit in 0..8 * sound.len() {
            let mut bytes = sound.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            fs::write(&path, &bytes).unwrap();
            match Known::read(&folder).unwrap() {
                Known::Digests(read) => assert_eq!(read, digests, "bit {bit}"),
                Known::Nothing => panic!("the file is there"),
                Known::Damaged => damaged += 1,
            }
        }
        assert!(damaged > 7 * sound.len(), "{damaged} of {} flips found", 8 * sound.len());
    }
}
